"""What the kernels of the molecular surface share: vectors as tuples, arrays that grow, points in cubes."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def point(rows, i):
    """Row i of an (N, 3) array as a tuple, the form in which all vectors are handled here."""
    return rows[i, 0], rows[i, 1], rows[i, 2]


@njit(cache=True, nogil=True)
def part(row, first):
    """Three columns of a row of `arcs`."""
    return row[first], row[first + 1], row[first + 2]


@njit(cache=True, nogil=True)
def minus(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(cache=True, nogil=True)
def along(a, s, b):
    """a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@njit(cache=True, nogil=True)
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True)
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, nogil=True)
def apart2(a, b):
    """Squared distance."""
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


@njit(cache=True, nogil=True)
def grown(rows):
    """The same rows at the head of an array twice as long."""
    longer = np.empty((2 * len(rows), rows.shape[1]), rows.dtype)
    for i in range(len(rows)):  # a slice set at once takes ten times longer to compile
        for k in range(rows.shape[1]):
            longer[i, k] = rows[i, k]
    return longer


class Cells(NamedTuple):
    """Points sorted into cubes, found by bisection, so that memory follows the points and not the box."""

    order: np.ndarray  # (N,) int64, points by cube
    key: np.ndarray  # (N,) int64, ascending number of the cube of each of them
    low: np.ndarray  # (3,) float64, corner of the box
    shape: np.ndarray  # (2,) int64, cubes along y and z
    size: float  # edge of a cube


def cells_of(points, size):
    """Sort (N, 3) points into cubes of edge `size`; all within `size` of a point lie in 3 x 3 x 3 cubes."""
    low = points.min(axis=0)
    cube = ((points - low) / size).astype(np.int64) + 1
    shape = cube[:, 1:].max(axis=0) + 2
    key = (cube[:, 0] * shape[0] + cube[:, 1]) * shape[1] + cube[:, 2]
    order = np.argsort(key, kind="stable")
    return Cells(order, key[order], low, shape, float(size))


@njit(cache=True, nogil=True)
def column(cells, place, c):
    """First slot and last key of column c (0..8) of the 3 x 3 x 3 cubes around a place."""
    a = math.floor((place[0] - cells.low[0]) / cells.size) + c // 3
    b = math.floor((place[1] - cells.low[1]) / cells.size) + c % 3
    key = (a * cells.shape[0] + b) * cells.shape[1] + math.floor((place[2] - cells.low[2]) / cells.size)
    first, last = 0, len(cells.key)
    while first < last:
        middle = (first + last) // 2
        if cells.key[middle] < key:
            first = middle + 1
        else:
            last = middle
    return first, key + 2
