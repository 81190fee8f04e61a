"""Subsets that stand alone: nothing of the full surface is known but the dots themselves.

Beside the samplers stands a surface dotted at low density in the first place (`dotted`), which needs no full surface; and
the linking distance of the reading `scaled`, a choice of ours, is varied.
"""

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from sparsurf.patches.readings import linked_by_spacing
from sparsurf.study.comparison import PERCENTS
from sparsurf.study.statistics import estimate
from sparsurf.surfaces.making import molecular_surface
from sparsurf.surfaces.spacing import DENSITY

SCALES = (1.2, 1.4, 1.6, 1.8, 2.0, 2.5)  # linking distances in mean spacings of the kept dots
STEPS = 4  # of the search for the density that gives a wished number of dots
DOTTED = "dotted"


def dotted(xyz, radii, n, rng, probe=1.4, reentrant="exact"):
    """The surface of atoms laid with about n dots, the molecule being turned at random first: points and normals."""
    turn = Rotation.random(random_state=rng).as_matrix()
    turned, density, best = xyz @ turn.T, None, None
    for _ in range(STEPS):
        surface = molecular_surface(turned, radii, probe, density or DENSITY, reentrant)
        if best is None or abs(len(surface) - n) < abs(len(best) - n):
            best = surface
        density = (density or DENSITY) * n / len(surface)
    return best.points @ turn, best.normals @ turn


def stand_alone(evaluator, drawers, lay=None, percents=PERCENTS, n_tests=200, draws=3, scales=SCALES):
    """Z of subsets as surfaces of their own, by linking distance.

    Parameters
    ----------
    evaluator : Evaluator
    drawers : dict
        Name -> function (n, rng) -> dots, see `comparison.contestants`.
    lay : callable, optional
        (n, rng) -> points and normals, see `dotted`: lets the surface laid at low density take part.
    percents : sequence of float
    n_tests, draws : int
    scales : sequence of float

    Returns
    -------
    DataFrame: sampler, percent (wished), n_S_percent (mean of the draws), scale, Z, low, high
    """
    tests, rows = evaluator.draw_tests(n_tests), []
    z_tot, _ = evaluator.describe(tests)
    for name in [*drawers, *([DOTTED] if lay else [])]:
        for percent in percents:
            n = max(2, round(percent / 100 * len(evaluator.points)))
            subsets = [_dots(evaluator, name, drawers, lay, n, k) for k in range(draws)]
            share = 100 * np.mean([len(points) for points, _ in subsets]) / len(evaluator.points)
            for scale in scales:
                z = []
                for points, normals in subsets:
                    index = linked_by_spacing(points, normals, evaluator.d_link, evaluator.area, scale)
                    z.append(evaluator.distances_of(index, tests, z_tot)[0])
                found = estimate(np.array(z))
                row = {"sampler": name, "percent": percent, "n_S_percent": share, "scale": scale}
                rows.append(row | {"Z": found.mean, "low": found.low, "high": found.high})
    return pd.DataFrame(rows)


def _dots(evaluator, name, drawers, lay, n, draw):
    """Points and normals of one draw."""
    rng = evaluator.stream("stand alone", name, n, draw)
    if name == DOTTED:
        return lay(n, rng)
    kept = np.sort(drawers[name](n, rng))
    return evaluator.points[kept], evaluator.normals[kept]
