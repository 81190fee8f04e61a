"""Where two surfaces of one complex touch."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

INTERFACE = 3.0  # Å; dots nearer than this to the partner's surface are interface (authors' scripts)


def gaps(points: np.ndarray, partner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the dot of the partner that is nearest to each dot: its distance, (N,) Å, and its index."""
    distance, dot = cKDTree(partner).query(points)
    return np.asarray(distance), np.asarray(dot)


def interface(points: np.ndarray, partner: np.ndarray, within: float = INTERFACE) -> np.ndarray:
    """Label the dots that have a dot of the partner nearer than `within` Å, (N,) bool."""
    return gaps(points, partner)[0] < within


def native_pairs(points: np.ndarray, partner: np.ndarray, within: float = INTERFACE) -> np.ndarray:
    """Pair each dot that is nearer than `within` Å to the partner with the partner's nearest dot, (P, 2)."""
    gap, nearest = gaps(points, partner)
    touching = np.flatnonzero(gap < within)
    return np.column_stack([touching, nearest[touching]])
