"""Closed meshes as half-edges, whose edges can be collapsed, and the removal of folds.

Half-edge 3 f + k leads from corner k of triangle f to the next corner, and its twin back. A triangle is folded if it faces
against the normals of its corners, and a vertex if the triangles around it face against its normal.
"""

from __future__ import annotations

import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.chosen_points import on_steps
from sparsurf.surfaces.vectors import Vector, cross, dot, point, squared_distance, subtract

LEAST_FACING = 1e-3  # cosine, so that rounding to float32 folds nothing
MAX_SWEEPS = 20  # over all folds
LEAST_GAIN = -1  # folds that a collapse may add where no other removes one


def twins(origin: np.ndarray, n: int) -> np.ndarray:
    """Return the opposite half-edge of each; half-edge 3 f + k leads from corner k of triangle f to the next."""
    target = np.roll(origin.reshape(-1, 3), -1, axis=1).ravel()
    key = np.minimum(origin, target).astype(np.int64) * n
    key += np.maximum(origin, target)
    order = np.argsort(key, kind="stable").astype(np.int32)
    twin = np.empty(len(origin), np.int32)
    twin[order[::2]], twin[order[1::2]] = order[1::2], order[::2]
    return twin


@njit()
def next_edge(h: int) -> int:
    """Return the next half-edge of the same triangle."""
    return h - 2 if h % 3 == 2 else h + 1


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


def unfold(points: np.ndarray, normals: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Collapse edges of a closed mesh until nothing is folded: the vertices that are left, and the triangles among these.

    As many folds stay as no collapse removes; the mesh stays closed, and its parts and handles the same.
    """
    origin = np.array(triangles, np.int32).ravel()
    dead = _unfold(on_steps(points), on_steps(normals), origin, twins(origin, len(points)))
    return remaining(origin, dead)


def remaining(origin: np.ndarray, dead: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices of the triangles that are left, and these triangles among them."""
    kept, corners = np.unique(origin.reshape(-1, 3)[~dead], return_inverse=True)
    return kept, corners.reshape(-1, 3)


@njit()
def _unfold(points: np.ndarray, normals: np.ndarray, origin: np.ndarray, twin: np.ndarray) -> np.ndarray:
    """Collapse edges around folds, and return which triangles are gone."""
    dead = np.zeros(len(origin) // 3, np.bool_)
    seen, stamp = np.zeros(len(points), np.int64), 0
    visited = np.full(len(points), -1, np.int64)
    active = np.ones(len(points), np.bool_)  # vertices around which a fold may be
    least_gain = 1
    for sweep in range(MAX_SWEEPS):
        # counted, since `near.any()` would load scipy.linalg with this kernel
        near, n_folded = np.zeros(len(points), np.bool_), 0
        for h in range(len(origin)):
            if dead[h // 3] or not active[origin[h]]:
                continue
            corners = (origin[h], origin[next_edge(h)], origin[next_edge(next_edge(h))])
            folded = _is_folded(*corners, points, normals)
            if not folded and visited[corners[0]] != -2 - sweep:
                visited[corners[0]] = -2 - sweep
                facing = _facing(h, corners[0], corners[0], corners[0], points, normals, origin, twin)
                folded = min(facing[0], facing[1]) < 0
                if folded:
                    e = h
                    while True:
                        near[origin[twin[e]]] = True
                        e = around(e, twin)
                        if e == h:
                            break
            if folded:
                n_folded += 1
                for w in corners:
                    near[w] = True
        active[:], changed = near, False
        for h in range(len(origin)):
            u = origin[h]
            if dead[h // 3] or not near[u] or visited[u] == sweep:
                continue
            visited[u] = sweep
            now = n_folds(h, False, points, normals, origin, twin)
            best, gained, shortest = -1, least_gain, np.inf
            e = h
            while now > 0:
                stamp += 1
                if may_collapse(e, origin, twin, seen, stamp):
                    gain = now - n_folds(e, True, points, normals, origin, twin)
                    length = squared_length(points, u, origin[twin[e]])
                    if gain > gained or (gain == gained and length < shortest):
                        best, gained, shortest = e, gain, length
                e = around(e, twin)
                if e == h:
                    break
            if best >= 0:
                active[origin[twin[best]]] = True
                remove_start(best, origin, twin, dead)
                changed = True
        if not changed and (least_gain == LEAST_GAIN or n_folded == 0):
            break
        least_gain = 1 if changed else least_gain - 1
    return dead
