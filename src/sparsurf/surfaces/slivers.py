"""Remove thin triangles of a closed mesh: an edge is turned, or one of its ends goes into the other, where the angles grow.

Every vertex that is left stays where it was, and the parts and handles of the mesh stay the same.
"""

from __future__ import annotations

import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.half_edges import (
    around,
    may_collapse,
    next_edge,
    remove_start,
    squared_length,
    triangle_normal,
)
from sparsurf.surfaces.vectors import dot, point

# Cosines of the smallest angle of a thin triangle, and of the least one of a new triangle with the normals of its corners: where
# an angle of 12 degrees would take a triangle far from the surface, only those below 6 degrees do
PASSES = ((0.978, 0.6), (0.9945, 0.2), (0.9945, 0.0))
MAX_SWEEPS = 10
UPRIGHT = 0.1  # least cosine of a new triangle with the normals of its corners where the surface is steep
LEAST_GAIN = 1e-6  # of a cosine


@njit()
def largest_cosine(points: np.ndarray, u: int, v: int, w: int) -> float:
    """Return the cosine of the smallest angle of a triangle; 1 where two corners are one."""
    a, b, c = squared_length(points, v, w), squared_length(points, w, u), squared_length(points, u, v)
    if a < b:
        a, b = b, a
    if a < c:
        a, c = c, a
    # the smallest angle is opposite to the shortest side
    if b < c:
        b, c = c, b
    return (a + b - c) / (2 * math.sqrt(a * b)) if b > 0 else 1.0


@njit()
def facing(points: np.ndarray, normals: np.ndarray, u: int, v: int, w: int) -> float:
    """Return the least cosine of the normal of a triangle with those of its corners."""
    normal, _ = triangle_normal(points, u, v, w)
    return min(dot(normal, point(normals, u)), dot(normal, point(normals, v)), dot(normal, point(normals, w)))


@njit()
def _is_joined(h: int, v: int, origin: np.ndarray, twin: np.ndarray) -> bool:
    """Return whether an edge joins the start of half-edge h and v."""
    e = h
    while True:
        if origin[twin[e]] == v:
            return True
        e = around(e, twin)
        if e == h:
            return False


@njit()
def _after_turn(
    h: int,
    strict: bool,
    least: float,
    points: np.ndarray,
    normals: np.ndarray,
    origin: np.ndarray,
    twin: np.ndarray,
) -> tuple[float, float]:
    """Return the largest cosine of the two triangles at an edge now, and after the edge is turned; 2 where it may not be."""
    t = twin[h]
    u, v = origin[h], origin[t]
    x, y = origin[next_edge(next_edge(h))], origin[next_edge(next_edge(t))]
    now = max(largest_cosine(points, u, v, x), largest_cosine(points, v, u, y))
    after = max(largest_cosine(points, x, u, y), largest_cosine(points, y, v, x))
    if after >= now or _is_joined(next_edge(next_edge(h)), y, origin, twin):
        return now, 2.0
    if not strict:
        least = min(least, facing(points, normals, u, v, x), facing(points, normals, v, u, y))
    if facing(points, normals, x, u, y) < least or facing(points, normals, y, v, x) < least:
        return now, 2.0
    return now, after


@njit()
def _after_collapse(
    h: int,
    strict: bool,
    least: float,
    points: np.ndarray,
    normals: np.ndarray,
    origin: np.ndarray,
    twin: np.ndarray,
) -> tuple[float, float]:
    """Return the largest cosine around the start of a half-edge now, and with it in the end; 2 where a triangle folds."""
    u, v = origin[h], origin[twin[h]]
    now, after, e = -1.0, -1.0, h
    while True:
        a, b = origin[next_edge(e)], origin[next_edge(next_edge(e))]
        now = max(now, largest_cosine(points, u, a, b))
        if v not in (a, b):
            after = max(after, largest_cosine(points, v, a, b))
            limit = least if strict else min(least, facing(points, normals, u, a, b))
            if facing(points, normals, v, a, b) < limit:
                return now, 2.0
        e = around(e, twin)
        if e == h:
            return now, after


@njit()
def turn_edge(h: int, origin: np.ndarray, twin: np.ndarray) -> None:
    """Turn an edge into the other diagonal of its two triangles."""
    t = twin[h]
    h1, h2, t1, t2 = next_edge(h), next_edge(next_edge(h)), next_edge(t), next_edge(next_edge(t))
    u, v, x, y = origin[h], origin[t], origin[h2], origin[t2]
    # triangles x u y and y v x, the edge from y to x stands first in the first
    ux, vy, xu, yv = twin[h2], twin[t2], twin[h1], twin[t1]
    of_xu, of_vx, of_yv, of_uy = ux, xu, vy, yv
    origin[h], origin[h1], origin[h2] = y, x, u
    origin[t], origin[t1], origin[t2] = x, y, v
    twin[h], twin[t] = t, h
    twin[h1], twin[of_xu] = of_xu, h1
    twin[h2], twin[of_uy] = of_uy, h2
    twin[t1], twin[of_yv] = of_yv, t1
    twin[t2], twin[of_vx] = of_vx, t2


@njit()
def remove_slivers(
    points: np.ndarray,
    normals: np.ndarray,
    origin: np.ndarray,
    twin: np.ndarray,
    dead: np.ndarray,
    steep: np.ndarray,
    may_remove: int,
) -> int:
    """Turn and collapse edges of thin triangles; return the number of vertices that went, at most `may_remove`.

    No new triangle is tilted where the surface is steep, (V,) bool.
    """
    seen, stamp, gone = np.zeros(len(points), np.int64), 0, 0
    for limit, least in PASSES:
        for _ in range(MAX_SWEEPS):
            changed = False
            for f in range(len(origin) // 3):
                corners = origin[3 * f], origin[3 * f + 1], origin[3 * f + 2]
                if dead[f] or largest_cosine(points, *corners) < limit:
                    continue
                best, gain, turned = -1, LEAST_GAIN, True
                for h in range(3 * f, 3 * f + 3):
                    strict = steep[origin[h]]
                    upright = max(least, UPRIGHT) if strict else least
                    now, after = _after_turn(h, strict, upright, points, normals, origin, twin)
                    if now - after > gain:
                        best, gain, turned = h, now - after, True
                    e = h
                    while gone < may_remove:
                        stamp += 1
                        if may_collapse(e, origin, twin, seen, stamp):
                            now, after = _after_collapse(e, strict, upright, points, normals, origin, twin)
                            if now - after > gain:
                                best, gain, turned = e, now - after, False
                        e = around(e, twin)
                        if e == h:
                            break
                if best < 0:
                    continue
                changed = True
                if turned:
                    turn_edge(best, origin, twin)
                else:
                    remove_start(best, origin, twin, dead)
                    gone += 1
            if not changed:
                break
    return gone
