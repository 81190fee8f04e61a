"""Where two surfaces of one complex touch."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

INTERFACE = 3.0  # Å; dots nearer than this to the partner's surface are interface (authors' scripts)


def gaps(points: np.ndarray, partner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the dot of the partner that is nearest to each dot.

    Parameters
    ----------
    points, partner : (N, 3) and (M, 3) float64, Å

    Returns
    -------
    distance : (N,) float64, Å
    dot : (N,) int64, index into `partner`
    """
    distance, dot = cKDTree(partner).query(points)
    return np.asarray(distance), np.asarray(dot)


def interface(points: np.ndarray, partner: np.ndarray, within: float = INTERFACE) -> np.ndarray:
    """Label the dots that have a dot of the partner nearer than `within` Å.

    Parameters
    ----------
    points, partner : (N, 3) and (M, 3) float64, Å
    within : float, Å

    Returns
    -------
    (N,) bool
    """
    return gaps(points, partner)[0] < within


def native_pairs(points: np.ndarray, partner: np.ndarray, within: float = INTERFACE) -> np.ndarray:
    """Pair the dots that touch in the complex.

    Parameters
    ----------
    points, partner : (N, 3) and (M, 3) float64, Å
    within : float, Å

    Returns
    -------
    (P, 2) int64
        Each dot that is nearer than `within` to the partner, with the dot of the partner nearest to it.
    """
    gap, nearest = gaps(points, partner)
    touching = np.flatnonzero(gap < within)
    return np.column_stack([touching, nearest[touching]])
