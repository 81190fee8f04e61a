"""Means over everything within a radius: smoothed maps, and what a dot's surroundings are made of."""

import numpy as np
from numba import njit

from sparsurf.patches.index import ball, ball_bound, build_index
from sparsurf.threads import parallel_map

SMOOTHING = 6.0  # Å, radius of the mean of a propensity (authors' scripts)


def means_within(points, places, values, radius, threads=1):
    """Mean of `values` at the places within `radius` of each point.

    Parameters
    ----------
    points : (N, 3) float64
        Å.
    places : (n, 3) float64
        Å, where the values are known.
    values : (n,) or (n, V) float64
    radius : float
        Å, inclusive.
    threads : int

    Returns
    -------
    means : (N,) or (N, V) float64, NaN where no place is near
    counts : (N,) int64, places within the radius
    """
    points = np.ascontiguousarray(points, np.float64)
    columns = np.ascontiguousarray(np.reshape(values, (len(places), -1)), np.float64)
    index = build_index(places, np.zeros((len(places), 3)), 0.0)  # only its cells are used
    columns = columns[index.dot]
    means, counts = np.empty((len(points), columns.shape[1])), np.empty(len(points), np.int64)
    room = ball_bound(index, points, radius) + 1

    def block(a, b):
        _means(index, points[a:b], columns, radius, room, means[a:b], counts[a:b])

    parallel_map(block, len(points), threads)
    return means.reshape(len(points), *np.shape(values)[1:]), counts


@njit(cache=True, nogil=True)
def _means(index, points, columns, radius, room, means, counts):
    found = np.empty(room, np.int32)
    for i in range(len(points)):
        n = ball(index, points[i, 0], points[i, 1], points[i, 2], radius, found)
        counts[i] = n
        for c in range(columns.shape[1]):
            total = 0.0
            for k in range(n):
                total += columns[found[k], c]
            means[i, c] = total / n if n > 0 else np.nan


def smooth(points, centres, values, radius=SMOOTHING, threads=1):
    """A map known at centres, smoothed onto every dot: the mean of the centres within `radius`.

    Parameters
    ----------
    points : (N, 3) float64, Å
    centres : (n,) int, dots at which the values are known
    values : (n,) float64
    radius : float
        Å; 0 leaves the values of the centres as they are.

    Returns
    -------
    (N,) float64; a dot with no centre within the radius takes the value of the nearest one.
    """
    places = points[centres]
    means = np.full(len(points), np.nan)
    if radius > 0:
        means, _ = means_within(points, places, values, radius, threads)
    lonely = np.isnan(means)
    if lonely.any():
        from scipy.spatial import cKDTree

        means[lonely] = values[cKDTree(places).query(points[lonely])[1]]
    return means
