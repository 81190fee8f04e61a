"""Means within a radius: smoothed maps, and the surroundings of a dot."""

from __future__ import annotations

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, ball, ball_bound, build_index
from sparsurf.surfaces.vectors import point
from sparsurf.threads import parallel_map

SMOOTHING = 6.0  # Å, radius over which a propensity is averaged (authors' scripts)
NEIGHBOURHOOD_RADIUS = 10.0  # Å, radius within which heavy atoms are counted


def means_within(
    points: np.ndarray, centres: np.ndarray, values: np.ndarray, radius: float, threads: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Average values, (n,) or (n, V) at `centres`, within `radius` (Å, inclusive) of each point, else NaN; and count these."""
    points = np.ascontiguousarray(points, np.float64)
    columns = np.ascontiguousarray(np.reshape(values, (len(centres), -1)), np.float64)
    index = build_index(centres, np.zeros((len(centres), 3)), 0.0)  # only its cells are used
    columns = columns[index.dot]
    means, counts = np.empty((len(points), columns.shape[1])), np.empty(len(points), np.int64)
    capacity = ball_bound(index, points, radius) + 1

    def block(a: int, b: int) -> None:
        """Average around the points a to b."""
        _means(index, points[a:b], columns, radius, capacity, means[a:b], counts[a:b])

    parallel_map(block, len(points), threads)
    return means.reshape(len(points), *np.shape(values)[1:]), counts


@njit()
def _means(
    index: PatchIndex,
    points: np.ndarray,
    columns: np.ndarray,
    radius: float,
    capacity: int,
    means: np.ndarray,
    counts: np.ndarray,
) -> None:
    """Average columns over the sphere around each point, which contains fewer than `capacity` centres."""
    inside = np.empty(capacity, np.int32)
    for i in range(len(points)):
        n = ball(index, point(points, i), radius, inside)
        counts[i] = n
        for c in range(columns.shape[1]):
            total = 0.0
            for k in range(n):
                total += columns[inside[k], c]
            means[i, c] = total / n if n > 0 else np.nan


def smooth(
    points: np.ndarray, centres: np.ndarray, values: np.ndarray, radius: float = SMOOTHING, threads: int = 1
) -> np.ndarray:
    """Smooth a map over centres within `radius` Å (0: not), and extend it to all dots, far ones by the nearest centre."""
    centre_points = points[centres]
    means = np.full(len(points), np.nan)
    if radius > 0:
        means, _ = means_within(points, centre_points, values, radius, threads)
    isolated = np.isnan(means)
    if isolated.any():
        from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

        means[isolated] = values[cKDTree(centre_points).query(points[isolated])[1]]
    return means


def protrusion(points: np.ndarray, heavy_atoms: np.ndarray, threads: int = 1) -> np.ndarray:
    """Compute minus the number of heavy atoms within REACH: highest where the surface protrudes.

    Dots are ranked as by the protrusion index CX (Pintar et al., Bioinformatics 18:980, 2002).
    """
    return -means_within(points, heavy_atoms, np.zeros(len(heavy_atoms)), NEIGHBOURHOOD_RADIUS, threads)[
        1
    ].astype(np.float64)
