"""Tools that the kernels of the molecular surface share: vectors as tuples, growing arrays, sets and solid angles."""

from __future__ import annotations

import math

import numpy as np

from sparsurf.kernels import njit

Vector = tuple[float, float, float]
POLE = (0.36, 0.48, 0.8)  # of the cones, a unit vector in no special direction
LONGEST_PIECE = 2.0  # rad, of an arc under one cone; the ends of a longer one may lie opposite to each other


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


@njit()
def root_of(joined: np.ndarray, arc: int) -> int:
    """Return the lowest arc of the set of an arc (union-find with path halving)."""
    while joined[arc] != arc:
        joined[arc] = joined[joined[arc]]
        arc = joined[arc]
    return arc


@njit()
def set_of_arcs(joined: np.ndarray) -> np.ndarray:
    """Return the set of every arc, named by its lowest arc."""
    roots = np.empty_like(joined)
    for arc in range(len(joined)):
        roots[arc] = root_of(joined, arc)
    return roots


@njit()
def join_two(joined: np.ndarray, first: int, second: int) -> bool:
    """Join the sets of two arcs; return whether they were two."""
    a, b = root_of(joined, first), root_of(joined, second)
    joined[max(a, b)] = min(a, b)
    return a != b


@njit()
def triangle(a: Vector, b: Vector, c: Vector) -> float:
    """Return the signed area of a triangle on the unit sphere, positive counterclockwise, up to a multiple of 4 pi."""
    return 2 * math.atan2(dot(a, cross(b, c)), 1 + dot(a, b) + dot(b, c) + dot(c, a))


@njit()
def cone(axis: Vector, height: float, e1: Vector, e2: Vector, low: float, high: float) -> float:
    """Return the signed area between the pole and an arc of a circle on the unit sphere, outside of its cap on the left.

    The cap lies beyond `height` along the axis. Positions on the circle are height axis + r (cos phi e1 + sin phi e2), where
    e2 = e1 x axis.
    """
    radius = math.sqrt(max(0.0, 1 - height * height))
    n = max(1, math.ceil((high - low) / LONGEST_PIECE))
    middle, opposite = scaled(height, axis), (-axis[0], -axis[1], -axis[2])
    area, previous = (1 + height) * (high - low), (0.0, 0.0, 0.0)
    for k in range(n + 1):
        phi = low + (high - low) * k / n
        position = add_scaled(middle, radius * math.cos(phi), e1)
        position = add_scaled(position, radius * math.sin(phi), e2)
        if k > 0:
            area += triangle(POLE, previous, position) - triangle(opposite, previous, position)
        previous = position
    return area
