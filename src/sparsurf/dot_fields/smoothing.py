"""Values of atoms or residues as a smooth field: at each dot their mean over the atoms around it."""

import numpy as np
from numba import njit

from sparsurf.surfaces.vectors import cell_column, point, sort_into_cells, squared_distance

WIDTH = 2.5  # Å, of the Gaussian that weighs the atoms
REACH = 4.0  # widths; atoms beyond weigh less than e^-8


def smoothed(values, xyz, points, width=WIDTH):
    """Mean of the values of atoms under a Gaussian around each dot.

    Parameters
    ----------
    values : (A,) float64, NaN where an atom has none
    xyz : (A, 3) float64, Å
    points : (N, 3) float64, Å
    width : float, Å

    Returns
    -------
    (N,) float64 in the unit of the values; NaN where no atom with a value lies within four widths
    """
    known = np.isfinite(values)
    out = np.full(len(points), np.nan)
    if known.any():
        places = np.ascontiguousarray(xyz[known], np.float64)
        cells = sort_into_cells(places, REACH * width)
        _smooth(places, np.asarray(values, np.float64)[known], cells, float(width), points, out)
    return out


@njit(cache=True, nogil=True)
def _smooth(xyz, values, cells, width, points, out):
    for i in range(len(points)):
        place, total, weights = point(points, i), 0.0, 0.0
        for c in range(9):
            slot, last = cell_column(cells, place, c)
            while slot < len(cells.key) and cells.key[slot] <= last:
                j = cells.order[slot]
                d2 = squared_distance(place, point(xyz, j))
                if d2 < (REACH * width) ** 2:
                    weight = np.exp(-d2 / (2 * width * width))
                    total += weight * values[j]
                    weights += weight
                slot += 1
        if weights > 0.0:
            out[i] = total / weights
