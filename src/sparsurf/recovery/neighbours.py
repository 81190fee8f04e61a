"""Dots around each kept dot: the nearest ones on its side of the surface, and how far apart they lie."""

import math

import numpy as np
from numba import njit

from sparsurf.patches.index import span

# Cosine of two normals; dots that face each other across a cleft say nothing about each other
SAME_SIDE = -0.5
COUNTED = 8  # the spacing follows from the distance to this neighbour
WIDEST = 2.0  # median spacings; a dot alone in a cavity has no neighbours of its own
FAR = 1.3  # growth of a search radius that holds too few dots


@njit(cache=True, nogil=True)
def nearest(index, begin, end, first_radius, near, gap):
    """The nearest neighbours of kept dots, themselves first.

    Parameters
    ----------
    index : PatchIndex of the kept dots
    begin, end : slice of the positions
    first_radius : Å, of the first search
    near : (n, k) int32, out; positions by distance, -1 where there are no more
    gap : (n, k) float64, out; their distances in Å
    """
    n, k = near.shape
    found, distance = np.empty(n + 1, np.int32), np.empty(n + 1)
    diagonal = math.sqrt(np.sum((index.shape * index.side) ** 2))
    for i in range(begin, end):
        radius, m = first_radius, 0
        while True:
            m = _on_its_side(index, i, radius, found, distance)
            if m >= min(k, n) or radius > diagonal:
                break
            radius *= FAR
        _sort_nearest(found, distance, m, near[i], gap[i])


@njit(cache=True, nogil=True)
def _sort_nearest(found, distance, m, near, gap):
    """The nearest of `found[:m]` with their distances in ascending order, by insertion; equal ones as they were found."""
    k = 0
    for e in range(m):
        d = distance[e]
        if k == len(near) and d >= gap[k - 1]:
            continue
        k = min(k + 1, len(near))
        a = k - 1
        while a > 0 and gap[a - 1] > d:
            near[a], gap[a] = near[a - 1], gap[a - 1]
            a -= 1
        near[a], gap[a] = found[e], d
    for a in range(len(near)):
        near[a] = near[a] if a < k else -1
        gap[a] = math.sqrt(gap[a]) if a < k else gap[a - 1]


@njit(cache=True, nogil=True)
def _on_its_side(index, i, radius, found, distance):
    """Number of dots within `radius` of position i that do not face it; their squared distances into `distance`."""
    x, y, z = index.xyz[i, 0], index.xyz[i, 1], index.xyz[i, 2]
    u, v, w = index.normals[i, 0], index.normals[i, 1], index.normals[i, 2]
    a0, a1 = span(x, radius, index.origin[0], index.side, index.shape[0])
    b0, b1 = span(y, radius, index.origin[1], index.side, index.shape[1])
    c0, c1 = span(z, radius, index.origin[2], index.side, index.shape[2])
    m = 0
    for a in range(a0, a1 + 1):
        for b in range(b0, b1 + 1):
            row = (a * index.shape[1] + b) * index.shape[2]
            for j in range(index.start[row + c0], index.start[row + c1 + 1]):
                q = np.uintp(j)
                d = (index.xyz[q, 0] - x) ** 2 + (index.xyz[q, 1] - y) ** 2 + (index.xyz[q, 2] - z) ** 2
                side = index.normals[q, 0] * u + index.normals[q, 1] * v + index.normals[q, 2] * w
                found[np.uintp(m)], distance[np.uintp(m)] = j, d  # what does not count is overwritten
                m += 1 if (d <= radius * radius) & (side >= SAME_SIDE) else 0
    return m


def local_spacing(gap):
    """Spacing of the kept dots around each, 1 / sqrt(dots per Å^2), in Å.

    Parameters
    ----------
    gap : (n, k) float64, from `nearest`

    Returns
    -------
    (n,) float64; a disc of the radius of the m-th neighbour holds about m + 1/2 dots.
    """
    m = min(COUNTED, gap.shape[1] - 1)
    spacing = gap[:, m] * math.sqrt(math.pi / (m + 0.5))
    return np.minimum(spacing, WIDEST * np.median(spacing))
