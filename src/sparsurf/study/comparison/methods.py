"""Who takes part in a comparison of samplers.

The paper's sampling takes part with what its criterion chose, and in hindsight with what proved best. Next to the samplers
stands a surface dotted at low density in the first place, which needs no full surface.
"""

from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from sparsurf.patches.readings import TEXT
from sparsurf.sampling import published, samplers
from sparsurf.sampling.combination import PARAMETERS, Choices, choices_from_ranges
from sparsurf.sampling.samplers import HINDSIGHT
from sparsurf.surfaces.components import components_of, without_cavities
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.spacing import DENSITY

PERCENTS = (2.5, 5.0, 10.0, 20.0, 40.0, 60.0)  # n_S at which samplers are compared, % of the dots
NEAR_FACTOR = 1.1  # 'near' a requested n_S is up to this factor
STEPS = 4  # of the search for the density that gives a requested number of dots


def select_methods(evaluator, names=None, ranges=None, grid=None, percents=PERCENTS):
    """Who takes part, and with which parameters the paper's sampler does.

    Parameters
    ----------
    evaluator : Evaluator
    names : sequence of str, optional
        Of samplers; all without.
    ranges, grid : DataFrame, optional
        ranges.csv: the paper's sampler takes its winners under `as_coded`; Table I of the paper without.
        grid.csv: lets the paper's sampler also take part with the combination whose Z is lowest near each n_S.
    percents : sequence of float

    Returns
    -------
    dict of functions (n, rng) -> dots, by name

    Raises
    ------
    InputError : a name that no sampler has
    """
    chosen = samplers.get_samplers(
        names or samplers.SAMPLERS, "compare.samplers", choices_from_ranges(ranges)
    )
    if "paper" in chosen and grid is not None and f"Z_tS_{TEXT}" in grid:
        best = best_in_hindsight(evaluator, grid, percents)
        chosen[HINDSIGHT] = partial(samplers.paper, choices=best)
    return {name: partial(function, evaluator) for name, function in chosen.items()}


def best_in_hindsight(evaluator, grid, percents):
    """The combination of the grid with the lowest Z under `as_written` near each n_S, as `combination.Choices`.

    Near is within `NEAR` at a combination's own alpha, or the nearest. Only combinations that can keep as many dots
    take part, as their alpha is then set for n_S: Z may rise by that, above that of other choices. They were chosen on
    the very test dots of the comparison: a fair opponent, rather favoured.
    """
    rows = grid[PARAMETERS].to_numpy()
    reach = published.expected_n_s(evaluator.cover, rows * (0, 1, 1, 1) + (1, 0, 0, 0))
    best = []
    for percent in percents:
        gap = np.abs(np.log(grid["n_S_percent"].to_numpy() / percent))
        gap[100 * reach < percent * len(evaluator.points)] += 10.0  # last resort
        near = np.flatnonzero(gap <= max(np.log(NEAR_FACTOR), gap.min()))
        best.append(rows[near[np.argmin(grid[f"Z_tS_{TEXT}"].to_numpy()[near])]])
    return Choices(0.99 * np.array(percents), np.array(best))


def dotted_surface(xyz, radii, n, rng, probe=1.4, reentrant="exact", cavities="keep"):
    """The surface of atoms laid with about n dots, the molecule being turned at random first: points and normals."""
    turn = Rotation.random(random_state=rng).as_matrix()
    turned, density, best = xyz @ turn.T, None, None
    for _ in range(STEPS):
        surface = molecular_surface(turned, radii, probe, density or DENSITY, reentrant)
        if cavities == "remove":
            surface = without_cavities(surface, components_of(surface, turned, radii, probe))
        if best is None or abs(len(surface) - n) < abs(len(best) - n):
            best = surface
        density = (density or DENSITY) * n / len(surface)
    return best.points @ turn, best.normals @ turn
