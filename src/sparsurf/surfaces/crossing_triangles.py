"""Triangles of a mesh that pass through one another."""

from __future__ import annotations

import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.grid import PointGrid, columns_around, in_column, sort_into_grid
from sparsurf.surfaces.slivers import facing
from sparsurf.surfaces.vectors import (
    add_scaled,
    cross,
    dot,
    point,
    squared_distance,
    subtract,
)

TILTED = 0.3  # cosine with the normal of a corner; only around such triangles some pass through others
REACH = 3  # column after the centre


def crossing_triangles(points: np.ndarray, normals: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return whether a triangle, (F,) bool, passes through another one, or another one through it, where some are tilted."""
    points, triangles = np.ascontiguousarray(points, float), np.ascontiguousarray(triangles)
    # `flatnonzero` and `max` outside of kernels, for which numba loads scipy.linalg
    tilted = np.flatnonzero(_around_tilted(points, np.ascontiguousarray(normals, float), triangles))
    if len(tilted) == 0:
        return np.zeros(len(triangles), bool)
    circles = _circles(points, triangles)
    grid = sort_into_grid(circles[:, :REACH], 2 * float(circles[:, REACH].mean()))
    return _crossing(points, triangles, grid, circles, tilted, float(circles[:, REACH].max()))


@njit()
def _around_tilted(points: np.ndarray, normals: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the triangles, (F,) bool, of which a corner is one of a tilted triangle."""
    at_tilted = np.zeros(len(points), np.bool_)
    for f in range(len(triangles)):
        u, v, w = triangles[f]
        if facing(points, normals, u, v, w) < TILTED:
            at_tilted[u], at_tilted[v], at_tilted[w] = True, True, True
    around = np.zeros(len(triangles), np.bool_)
    for f in range(len(triangles)):
        for corner in triangles[f]:
            around[f] |= at_tilted[corner]
    return around


@njit()
def _circles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the mean corner of each triangle, and the largest distance of a corner from it, (F, 4)."""
    circles = np.zeros((len(triangles), 4))
    for f in range(len(triangles)):
        for a in range(3):
            for corner in triangles[f]:
                circles[f, a] += points[corner, a] / 3
        for corner in triangles[f]:
            circles[f, REACH] = max(
                circles[f, REACH], squared_distance(point(points, corner), point(circles, f))
            )
        circles[f, REACH] = math.sqrt(circles[f, REACH])
    return circles


@njit()
def _crossing(
    points: np.ndarray,
    triangles: np.ndarray,
    grid: PointGrid,
    circles: np.ndarray,
    chosen: np.ndarray,
    largest: float,
) -> np.ndarray:
    """Return whether an edge of another triangle passes through each chosen triangle, or one of its edges through another."""
    crosses = np.zeros(len(triangles), np.bool_)
    for f in chosen:
        centre = point(circles, f)
        columns = columns_around(grid.lattice, centre, circles[f, REACH] + largest)
        for c in range(columns.n):
            for slot in in_column(grid.start, columns, c):
                g = grid.dot[slot]
                within = circles[f, REACH] + circles[g, REACH]
                if squared_distance(point(grid.xyz, slot), centre) > within * within:
                    continue
                if _an_edge_crosses(points, triangles, f, g) or _an_edge_crosses(points, triangles, g, f):
                    crosses[f], crosses[g] = True, True
    return crosses


@njit()
def _an_edge_crosses(points: np.ndarray, triangles: np.ndarray, f: int, g: int) -> bool:
    """Return whether an edge of triangle g, without a corner in common, passes through triangle f."""
    a = point(points, triangles[f, 0])
    u, v = subtract(point(points, triangles[f, 1]), a), subtract(point(points, triangles[f, 2]), a)
    normal = cross(u, v)
    for k in range(3):
        first, last = triangles[g, k], triangles[g, (k + 1) % 3]
        start, end = subtract(point(points, first), a), subtract(point(points, last), a)
        above, below = dot(normal, start), dot(normal, end)
        if above * below >= 0:
            continue
        is_corner = False
        for corner in triangles[f]:
            is_corner |= corner in (first, last)
        if is_corner:
            continue
        where = add_scaled(start, above / (above - below), subtract(end, start))
        across_u, across_v = dot(normal, cross(u, where)), dot(normal, cross(where, v))
        if across_u > 0 and across_v > 0 and across_u + across_v < dot(normal, normal):
            return True
    return False
