"""Methods that take part in a comparison of samplers.

The paper's sampling takes part with the combinations that its criterion chose, and with those that proved best in hindsight.
A surface generated at low density is compared with the samplers; it needs no full surface.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from sparsurf.patches.readings import WRITTEN_READING
from sparsurf.sampling import published, samplers
from sparsurf.sampling.combination import PARAMETERS, Choices, choices_from_ranges
from sparsurf.sampling.samplers import HINDSIGHT
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.components import components_of, without_cavities
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.spacing import DENSITY

Method = Callable[[int, np.random.Generator], np.ndarray]  # (n, rng) -> dots

PERCENTS = (2.5, 5.0, 10.0, 20.0, 40.0, 60.0)  # n_S at which samplers are compared, % of the dots
NEAR_FACTOR = 1.1  # an n_S is 'near' a requested one if they differ by at most this factor
DENSITY_STEPS = 4  # of the search for the density with the requested number of dots


def select_methods(
    prepared: PreparedSurface,
    names: Iterable[str] | None = None,
    ranges: pd.DataFrame | None = None,
    grid: pd.DataFrame | None = None,
    percents: Sequence[float] = PERCENTS,
) -> dict[str, Method]:
    """Select the methods to compare.

    Parameters
    ----------
    prepared : PreparedSurface
    names : iterable of str, optional
        Names of samplers; all by default.
    ranges, grid : DataFrame, optional
        With ranges.csv, the paper's sampler uses its winners under `as_coded`, otherwise Table I of the paper. With
        grid.csv, it also takes part with the combination of lowest Z near each n_S.
    percents : sequence of float

    Returns
    -------
    dict of functions (n, rng) -> dots, by name

    Raises
    ------
    InputError
        If a name is not registered.
    """
    chosen = samplers.get_samplers(
        names or samplers.SAMPLERS, "compare.samplers", choices_from_ranges(ranges)
    )
    methods: dict[str, Method] = {
        name: partial(sampler.__call__, prepared) for name, sampler in chosen.items()
    }
    if "paper" in chosen and grid is not None and f"Z_tS_{WRITTEN_READING}" in grid:
        best = best_in_hindsight(prepared, grid, percents)
        methods[HINDSIGHT] = partial(samplers.paper, prepared, choices=best)
    return methods


def best_in_hindsight(prepared: PreparedSurface, grid: pd.DataFrame, percents: Sequence[float]) -> Choices:
    """Choose the combination of the grid with the lowest Z under `as_written` near each n_S.

    Combinations are near if their n_S, at their own alpha, differs by at most `NEAR_FACTOR`; if none is, the nearest is taken.
    Only combinations that can keep that many dots take part. Their alpha is later adjusted to n_S, which may raise Z above that
    of other choices. They are chosen on the test dots of the comparison itself, which favours them.
    """
    rows = grid[PARAMETERS].to_numpy()
    max_n_s = published.expected_n_s(prepared.cover, rows * (0, 1, 1, 1) + (1, 0, 0, 0))
    best = []
    for percent in percents:
        difference = np.abs(np.log(grid["n_S_percent"].to_numpy() / percent))
        difference[100 * max_n_s < percent * len(prepared.points)] += 10.0  # last resort
        near = np.flatnonzero(difference <= max(np.log(NEAR_FACTOR), difference.min()))
        best.append(rows[near[np.argmin(grid[f"Z_tS_{WRITTEN_READING}"].to_numpy()[near])]])
    return Choices(0.99 * np.array(percents), np.array(best))


def dotted_surface(
    xyz: np.ndarray,
    radii: np.ndarray,
    n: int,
    rng: np.random.Generator,
    probe: float = PROBE_RADIUS,
    reentrant: str = "exact",
    cavities: str = "keep",
) -> tuple[np.ndarray, np.ndarray]:
    """Generate the surface of atoms with about n dots, after a random rotation of the molecule.

    Parameters
    ----------
    xyz, radii : (A, 3) and (A,) float64, Å
    n : int
    rng : numpy.random.Generator
    probe : float, Å
    reentrant : str
        See `molecular_surface`.
    cavities : {'keep', 'remove'}

    Returns
    -------
    points, normals : (M, 3) float64, in the original orientation
    """
    rotation = Rotation.random(random_state=rng).as_matrix()
    rotated, density, best = xyz @ rotation.T, DENSITY, None
    for _ in range(DENSITY_STEPS):
        surface = molecular_surface(rotated, radii, probe, density, reentrant)
        if cavities == "remove":
            surface = without_cavities(surface, components_of(surface, rotated, radii, probe))
        if best is None or abs(len(surface) - n) < abs(len(best) - n):
            best = surface
        density = density * n / len(surface)
    assert best is not None
    return best.points @ rotation, best.normals @ rotation
