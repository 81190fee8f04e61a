"""Tools that the kernels of the molecular surface share: vectors as tuples, and growing arrays."""

from __future__ import annotations

import numpy as np

from sparsurf.kernels import njit

Vector = tuple[float, float, float]


@njit()
def point(rows: np.ndarray, i: int | np.integer) -> Vector:
    """Return row i of an (N, 3) array as a tuple, the form of all vectors in these kernels."""
    return rows[i, 0], rows[i, 1], rows[i, 2]


@njit()
def set_point(rows: np.ndarray, i: int | np.integer, v: Vector) -> None:
    """Write a vector into row i of an (N, 3) array, or into the first columns of a wider one."""
    rows[i, 0], rows[i, 1], rows[i, 2] = v


@njit()
def slots(start: np.ndarray, i: int | np.integer) -> range:
    """Return the entries of the list of i, where the lists follow one another and `start` is the first of each."""
    return range(start[i], start[i + 1])


@njit()
def vector_at(row: np.ndarray, first: int) -> Vector:
    """Return three columns of a row of `arcs`, from column `first` on."""
    return row[first], row[first + 1], row[first + 2]


@njit()
def subtract(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit()
def add_scaled(a: Vector, s: float, b: Vector) -> Vector:
    """Return a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@njit()
def scaled(s: float, a: Vector) -> Vector:
    """Return s a."""
    return add_scaled((0.0, 0.0, 0.0), s, a)


@njit()
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit()
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit()
def squared_distance(a: Vector, b: Vector) -> float:
    """Return the squared distance between two points."""
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


@njit()
def doubled(rows: np.ndarray) -> np.ndarray:
    """Copy the rows to the start of an array twice as long."""
    longer = np.empty((2 * len(rows), rows.shape[1]), rows.dtype)
    for i in range(len(rows)):  # assigning a slice at once takes ten times longer to compile
        for k in range(rows.shape[1]):
            longer[i, k] = rows[i, k]
    return longer
