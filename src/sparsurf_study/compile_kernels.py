"""Compile the kernels of a study that `sparsurf.compile_kernels` does not: `python -m sparsurf_study.compile_kernels`.

After `make setup` no job compiles anything, which a test checks for every rule.
"""

import numpy as np

from sparsurf.compile_kernels import ball_of_dots
from sparsurf.evaluation.prepared_surface import MIN_NESTED, PreparedSurface
from sparsurf.patches.readings import GRID_READINGS
from sparsurf.surfaces.surface import Surface
from sparsurf_study.analysis.grid import evaluate_grid
from sparsurf_study.pairs.nearest import nearest
from sparsurf_study.pairs.neighbourhoods import means_within


def compile_study() -> None:
    """Evaluate a grid of one combination on a tiny surface, and search for its nearest patches and neighbours."""
    points, normals = ball_of_dots()
    combination = np.array([[0.5, 0.5, 1.0, 1.0]])
    prepared = PreparedSurface(Surface(points, normals))
    for readings in (("kept",), GRID_READINGS):
        grid = evaluate_grid(prepared, combination, 4, readings=readings)
    # the random subsets of a large grid, which are nested
    prepared.compare_uniform(0, np.arange(1, MIN_NESTED + 1), grid.tests, GRID_READINGS, grid.z_tot)
    nearest(points, normals)
    means_within(points, points, points[:, 0], 1.0)


if __name__ == "__main__":
    compile_study()
