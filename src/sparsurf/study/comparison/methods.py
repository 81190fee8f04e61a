"""Methods that take part in a comparison of samplers.

The paper's sampling takes part with the combinations that its criterion chose. A surface generated at low density is
compared with the samplers; it needs no full surface.
"""

from collections.abc import Callable, Iterable
from functools import partial

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from sparsurf.sampling import samplers
from sparsurf.sampling.combination import choices_from_ranges
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.components import components_of, without_cavities
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.spacing import DENSITY

Method = Callable[[int, np.random.Generator], np.ndarray]  # (n, rng) -> dots

PERCENTS = (2.5, 5.0, 10.0, 20.0, 40.0, 60.0)  # n_S at which samplers are compared, % of the dots
DENSITY_STEPS = 4  # of the search for the density with the requested number of dots


def select_methods(
    prepared: PreparedSurface,
    names: Iterable[str] | None = None,
    ranges: pd.DataFrame | None = None,
) -> dict[str, Method]:
    """Select the methods to compare.

    Parameters
    ----------
    prepared : PreparedSurface
    names : iterable of str, optional
        Names of samplers; all by default.
    ranges : DataFrame, optional
        With ranges.csv, the paper's sampler uses its winners under `as_coded`, otherwise Table I of the paper.

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
    return {name: partial(sampler.__call__, prepared) for name, sampler in chosen.items()}


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
