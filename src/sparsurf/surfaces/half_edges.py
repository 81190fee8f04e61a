"""Closed meshes as half-edges, whose edges can be collapsed.

Half-edge 3 f + k leads from corner k of triangle f to the next corner, and its twin back. A triangle is folded if it faces
against the normals of its corners, and a vertex if the triangles around it face against its normal.
"""

from __future__ import annotations

import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.vectors import Vector, cross, dot, point, slots, squared_distance, subtract

LEAST_FACING = 1e-3  # cosine, so that rounding to float32 folds nothing


@njit()
def next_edge(h: int) -> int:
    """Return the next half-edge of the same triangle."""
    return h - 2 if h % 3 == 2 else h + 1


@njit()
def twins(origin: np.ndarray, n: int) -> np.ndarray:
    """Return the opposite half-edge of each, in a mesh of n vertices; -1 where not just one runs there, so that it is not closed.

    Half-edge 3 f + k leads from corner k of triangle f to the next.
    """
    start = np.zeros(n + 1, np.int64)
    for u in origin:
        start[u + 1] += 1
    for u in range(n):  # for `cumsum` numba loads scipy.linalg
        start[u + 1] += start[u]
    place, leaving = start.copy(), np.empty(len(origin), np.int32)
    for h in range(len(origin)):
        leaving[place[origin[h]]] = h
        place[origin[h]] += 1
    twin = np.full(len(origin), -1, np.int32)
    for h in range(len(origin)):
        found = 0
        for slot in slots(start, origin[next_edge(h)]):
            if origin[next_edge(leaving[slot])] == origin[h]:
                twin[h] = leaving[slot]
                found += 1
        if found != 1:
            twin[h] = -1
    for h in range(len(origin)):
        if twin[h] >= 0 and twin[twin[h]] != h:
            twin[h] = -1
    return twin


@njit()
def around(h: int, twin: np.ndarray) -> int:
    """Return the next half-edge from the same vertex."""
    return twin[next_edge(next_edge(h))]


@njit()
def squared_length(points: np.ndarray, u: int, v: int) -> float:
    """Return the squared distance of two vertices."""
    return squared_distance(point(points, u), point(points, v))


@njit()
def triangle_normal(points: np.ndarray, u: int, v: int, w: int) -> tuple[Vector, float]:
    """Return the unit normal of a triangle and twice its area."""
    corner = point(points, u)
    across = cross(subtract(point(points, v), corner), subtract(point(points, w), corner))
    size = math.sqrt(dot(across, across))
    inverse = 1.0 / size if size > 0.0 else 0.0
    return (across[0] * inverse, across[1] * inverse, across[2] * inverse), size


@njit()
def mark_neighbours(h: int, origin: np.ndarray, twin: np.ndarray, seen: np.ndarray, stamp: int) -> int:
    """Mark the neighbours of the start of a half-edge by `stamp`; return their number."""
    n, e = 0, h
    while True:
        seen[origin[twin[e]]] = stamp
        n += 1
        e = around(e, twin)
        if e == h:
            return n


@njit()
def may_collapse(h: int, origin: np.ndarray, twin: np.ndarray, seen: np.ndarray, stamp: int) -> bool:
    """Return whether the ends of an edge have two neighbours in common, and others besides."""
    common = n_of_v = 0
    n_of_u = mark_neighbours(h, origin, twin, seen, stamp)
    e = twin[h]
    while True:
        common += seen[origin[twin[e]]] == stamp
        n_of_v += 1
        e = around(e, twin)
        if e == twin[h]:
            break
    return common == 2 and n_of_u + n_of_v > 6


@njit()
def remove_start(h: int, origin: np.ndarray, twin: np.ndarray, dead: np.ndarray) -> None:
    """Move the start of a half-edge into its end, and remove the triangles on both sides."""
    v = origin[twin[h]]
    e = h
    while True:
        origin[e] = v
        e = around(e, twin)
        if e == h:
            break
    for end in range(2):
        side = twin[h] if end else h
        a, b = twin[next_edge(side)], twin[next_edge(next_edge(side))]
        twin[a], twin[b] = b, a
        dead[side // 3] = True


@njit()
def _facing(
    start: int,
    w: int,
    u: int,
    v: int,
    points: np.ndarray,
    normals: np.ndarray,
    origin: np.ndarray,
    twin: np.ndarray,
) -> tuple[float, float]:
    """Sum by how much the cosines of triangles with the normal of w exceed the least, evenly and by area; u is in v."""
    evenly = by_area = 0.0
    e = start
    while True:
        a, b, c = origin[e], origin[next_edge(e)], origin[next_edge(next_edge(e))]
        a, b, c = v if a == u else a, v if b == u else b, v if c == u else c
        if b not in (a, c) and a != c:
            normal, size = triangle_normal(points, a, b, c)
            excess = dot(normal, point(normals, w)) - LEAST_FACING
            evenly += excess
            by_area += excess * size
        e = around(e, twin)
        if e == start:
            return evenly, by_area


@njit()
def _is_folded(a: int, b: int, c: int, points: np.ndarray, normals: np.ndarray) -> bool:
    """Return whether a triangle faces against the mean normal of its corners."""
    normal, _ = triangle_normal(points, a, b, c)
    total = 0.0
    for w in (a, b, c):
        total += dot(normal, point(normals, w))
    return total < LEAST_FACING


@njit()
def n_folds(
    h: int, collapsed: bool, points: np.ndarray, normals: np.ndarray, origin: np.ndarray, twin: np.ndarray
) -> int:
    """Return the number of folded triangles and vertices around the start of a half-edge, now or with the start in its end."""
    u = origin[h]
    v = origin[twin[h]] if collapsed else u
    n = 0
    if not collapsed:
        evenly, by_area = _facing(h, u, u, u, points, normals, origin, twin)
        n += min(evenly, by_area) < 0
    e = h
    while True:
        a, b = origin[next_edge(e)], origin[next_edge(next_edge(e))]
        if v not in (a, b):
            n += _is_folded(v, a, b, points, normals)
        evenly, by_area = _facing(twin[e], a, u, v, points, normals, origin, twin)
        if a == v:
            of_start = _facing(h, a, u, v, points, normals, origin, twin)
            evenly, by_area = evenly + of_start[0], by_area + of_start[1]
        n += min(evenly, by_area) < 0
        e = around(e, twin)
        if e == h:
            return n


def remaining(origin: np.ndarray, dead: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices of the triangles that are left, and these triangles among them."""
    corners = origin.reshape(-1, 3)[~dead]
    kept = np.flatnonzero(np.bincount(corners.ravel()))
    number = np.empty(kept[-1] + 1 if len(kept) else 0, np.int64)
    number[kept] = np.arange(len(kept))
    return kept, number[corners]
