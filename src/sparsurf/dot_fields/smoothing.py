"""Values of atoms or residues as a smooth field: at each dot, the mean over the atoms around it."""

from __future__ import annotations

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.grid import PointGrid, columns_around, in_column, sort_into_grid
from sparsurf.surfaces.vectors import point, squared_distance

SIGMA = 2.5  # Å, of the Gaussian that weights the atoms
SMOOTHING_CUTOFF = 4.0  # sigmas; atoms beyond it weigh less than e^-8


def gaussian_mean(
    values: np.ndarray, xyz: np.ndarray, points: np.ndarray, sigma: float = SIGMA
) -> np.ndarray:
    """Average values of atoms, (A,), with a Gaussian of width `sigma` Å around each dot, (N,); NaN without any in four sigmas."""
    finite = np.isfinite(values)
    out = np.full(len(points), np.nan)
    if finite.any():
        grid = sort_into_grid(xyz[finite], SMOOTHING_CUTOFF * sigma)
        _smooth(np.asarray(values, np.float64)[finite], grid, float(sigma), points, out)
    return out


@njit()
def _smooth(values: np.ndarray, grid: PointGrid, sigma: float, points: np.ndarray, out: np.ndarray) -> None:
    """Write the Gaussian mean at each point to `out`."""
    for i in range(len(points)):
        dot, total, weights = point(points, i), 0.0, 0.0
        columns = columns_around(grid.lattice, dot, SMOOTHING_CUTOFF * sigma)
        for c in range(columns.n):
            for q in in_column(grid.start, columns, c):
                d2 = squared_distance(dot, point(grid.xyz, q))
                if d2 < (SMOOTHING_CUTOFF * sigma) ** 2:
                    weight = np.exp(-d2 / (2 * sigma * sigma))
                    total += weight * values[grid.dot[q]]
                    weights += weight
        if weights > 0.0:
            out[i] = total / weights
