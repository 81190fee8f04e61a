"""Values of atoms or residues as a smooth field: at each dot, the mean over the atoms around it."""

from __future__ import annotations

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.vectors import Cells, cell_column, point, sort_into_cells, squared_distance

SIGMA = 2.5  # Å, of the Gaussian that weights the atoms
SMOOTHING_CUTOFF = 4.0  # sigmas; atoms beyond it weigh less than e^-8


def gaussian_mean(
    values: np.ndarray, xyz: np.ndarray, points: np.ndarray, sigma: float = SIGMA
) -> np.ndarray:
    """Average values of atoms, (A,), with a Gaussian of width `sigma` Å around each dot, (N,); NaN without any in four sigmas."""
    finite = np.isfinite(values)
    out = np.full(len(points), np.nan)
    if finite.any():
        atoms = np.ascontiguousarray(xyz[finite], np.float64)
        cells = sort_into_cells(atoms, SMOOTHING_CUTOFF * sigma)
        _smooth(atoms, np.asarray(values, np.float64)[finite], cells, float(sigma), points, out)
    return out


@njit(cache=True, nogil=True)
def _smooth(
    xyz: np.ndarray, values: np.ndarray, cells: Cells, sigma: float, points: np.ndarray, out: np.ndarray
) -> None:
    """Write the Gaussian mean at each point to `out`."""
    for i in range(len(points)):
        dot, total, weights = point(points, i), 0.0, 0.0
        for c in range(9):
            slot, last = cell_column(cells, dot, c)
            while slot < len(cells.key) and cells.key[slot] <= last:
                j = cells.order[slot]
                d2 = squared_distance(dot, point(xyz, j))
                if d2 < (SMOOTHING_CUTOFF * sigma) ** 2:
                    weight = np.exp(-d2 / (2 * sigma * sigma))
                    total += weight * values[j]
                    weights += weight
                slot += 1
        if weights > 0.0:
            out[i] = total / weights
