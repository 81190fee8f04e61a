"""Tools that the kernels of the molecular surface share: vectors as tuples, growing arrays, points sorted into cubes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit

Vector = tuple[float, float, float]


@njit(cache=True, nogil=True)
def point(rows: np.ndarray, i: int | np.integer) -> Vector:
    """Return row i of an (N, 3) array as a tuple, the form of all vectors in these kernels."""
    return rows[i, 0], rows[i, 1], rows[i, 2]


@njit(cache=True, nogil=True)
def vector_at(row: np.ndarray, first: int) -> Vector:
    """Return three columns of a row of `arcs`, from column `first` on."""
    return row[first], row[first + 1], row[first + 2]


@njit(cache=True, nogil=True)
def subtract(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(cache=True, nogil=True)
def add_scaled(a: Vector, s: float, b: Vector) -> Vector:
    """Return a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@njit(cache=True, nogil=True)
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True)
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, nogil=True)
def squared_distance(a: Vector, b: Vector) -> float:
    """Return the squared distance between two points."""
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


@njit(cache=True, nogil=True)
def doubled(rows: np.ndarray) -> np.ndarray:
    """Copy the rows to the start of an array twice as long."""
    longer = np.empty((2 * len(rows), rows.shape[1]), rows.dtype)
    for i in range(len(rows)):  # assigning a slice at once takes ten times longer to compile
        for k in range(rows.shape[1]):
            longer[i, k] = rows[i, k]
    return longer


class Cells(NamedTuple):
    """Points sorted into cubes that bisection finds, so that memory grows with the points and not with the box."""

    order: np.ndarray  # (N,) int64, points by cube
    key: np.ndarray  # (N,) int64, ascending number of the cube of each of them
    low: np.ndarray  # (3,) float64, corner of the box
    shape: np.ndarray  # (2,) int64, cubes along y and z
    size: float  # edge of a cube


def sort_into_cells(points: np.ndarray, size: float) -> Cells:
    """Sort points (N, 3) into cubes; all within `size` of a position lie in the 3 x 3 x 3 cubes around it."""
    low = points.min(axis=0)
    # An empty layer on each side, so that the cubes around a border have numbers of their own
    cube = ((points - low) / size).astype(np.int64) + 1
    shape = cube[:, 1:].max(axis=0) + 2
    key = (cube[:, 0] * shape[0] + cube[:, 1]) * shape[1] + cube[:, 2]
    order = np.argsort(key, kind="stable")
    return Cells(order, key[order], low, shape, float(size))


def pairs_within(points: np.ndarray, positions: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Find the points (N, 3) within a distance of each position (M, 3): both numbers of each pair, in order, (P,) each."""
    if len(points) == 0 or len(positions) == 0:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    cells = sort_into_cells(points, distance)
    cube = np.floor((positions - cells.low) / distance).astype(np.int64)
    column = np.array([(a * cells.shape[0] + b) * cells.shape[1] for a in range(3) for b in range(3)])
    key = ((cube[:, 0] * cells.shape[0] + cube[:, 1]) * cells.shape[1] + cube[:, 2])[:, None] + column
    first = np.searchsorted(cells.key, key).ravel()
    n = np.searchsorted(cells.key, key + 2, side="right").ravel() - first
    position = np.repeat(np.arange(len(positions)), n.reshape(-1, 9).sum(axis=1))
    point = cells.order[np.arange(n.sum()) + np.repeat(first - np.cumsum(n) + n, n)]
    near = ((points[point] - positions[position]) ** 2).sum(axis=1) <= distance * distance
    position, point = position[near], point[near]
    order = np.lexsort((point, position))
    return position[order], point[order]


@njit(cache=True, nogil=True)
def cell_column(cells: Cells, position: Vector, c: int) -> tuple[int, int]:
    """Return the first slot and the last key of column c (0 to 8) of the 3 x 3 x 3 cubes around a position."""
    a = math.floor((position[0] - cells.low[0]) / cells.size) + c // 3
    b = math.floor((position[1] - cells.low[1]) / cells.size) + c % 3
    key = (a * cells.shape[0] + b) * cells.shape[1] + math.floor((position[2] - cells.low[2]) / cells.size)
    first, last = 0, len(cells.key)
    while first < last:
        middle = (first + last) // 2
        if cells.key[middle] < key:
            first = middle + 1
        else:
            last = middle
    return first, key + 2
