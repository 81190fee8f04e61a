"""Where two surfaces of one complex touch."""

import numpy as np
from scipy.spatial import cKDTree

INTERFACE = 3.0  # Å, dots this near to the partner's surface are interface (authors' scripts)


def gaps(points, partner):
    """Distance in Å from every dot (N, 3) to the nearest dot of the partner (M, 3), and that dot."""
    return cKDTree(partner).query(points)


def interface(points, partner, within=INTERFACE):
    """Whether a dot of the partner lies nearer than `within` Å: (N,) bool for dots (N, 3) and (M, 3)."""
    return gaps(points, partner)[0] < within


def native_pairs(points, partner, within=INTERFACE):
    """Pairs of dots that lie on each other in the complex.

    Parameters
    ----------
    points, partner : (N, 3) and (M, 3) float64, Å
    within : float, Å

    Returns
    -------
    (P, 2) int64: each dot that is nearer than `within` to the partner, with the dot of the partner nearest to it
    """
    gap, place = gaps(points, partner)
    mine = np.flatnonzero(gap < within)
    return np.column_stack([mine, place[mine]])
