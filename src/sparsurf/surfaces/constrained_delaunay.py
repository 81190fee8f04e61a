"""Triangles of a part of a sphere between given borders, with points of its own inside, as close to equilateral as they can be.

The part is drawn in a plane by stereographic projection, which turns circles into circles: a Delaunay triangulation there is one
of the sphere. The points of the border are inserted one after another (Lawson), edges of the border that are missing are found
by flips (Sloan, Comput. Struct. 47:441, 1993), and what lies outside is removed. Then the centre of the widest circle around a
triangle becomes a new point until no circle is wider than allowed (Chew, Cornell TR 89-983, 1989).
"""

from __future__ import annotations

import heapq
import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.vectors import (
    Vector,
    cross,
    dot,
    point,
    scaled,
    set_point,
    squared_distance,
    subtract,
)

FAILED = -1
N_FAR = 3  # points of the triangle around all others
MAX_SWEEPS = 20
ROUNDING = 1e-11  # of the square of an area, far above that of its terms
PARTS_OF_CHORD = (
    2.0**32
)  # squared chords are compared in these parts, so that equal ones are equal on every machine
OUTSIDE = -1  # no triangle
MAX_COSINE_AT_BORDER = -0.2  # of the angle under which a new point sees an edge of the border


@njit()
def _turn(a: int, b: int, c: int, p: np.ndarray) -> float:
    """Return twice the signed area of a triangle of the plane, positive counterclockwise."""
    return (p[b, 0] - p[a, 0]) * (p[c, 1] - p[a, 1]) - (p[b, 1] - p[a, 1]) * (p[c, 0] - p[a, 0])


@njit()
def _in_circle(a: int, b: int, c: int, d: int, p: np.ndarray) -> bool:
    """Return whether d lies inside the circle around the counterclockwise triangle a b c."""
    ux, uy = p[a, 0] - p[d, 0], p[a, 1] - p[d, 1]
    vx, vy = p[b, 0] - p[d, 0], p[b, 1] - p[d, 1]
    wx, wy = p[c, 0] - p[d, 0], p[c, 1] - p[d, 1]
    a2, b2, c2 = ux * ux + uy * uy, vx * vx + vy * vy, wx * wx + wy * wy
    # of points on one circle, rounding must not decide
    inside = a2 * (vx * wy - wx * vy) - b2 * (ux * wy - wx * uy) + c2 * (ux * vy - vx * uy)
    return inside > ROUNDING * (a2 + b2 + c2) ** 2


@njit()
def _corner(tri: np.ndarray, t: int, v: int) -> int:
    """Return which corner of triangle t is v."""
    return 0 if tri[t, 0] == v else (1 if tri[t, 1] == v else 2)


@njit()
def _side(neighbour: np.ndarray, t: int, o: int) -> int:
    """Return across which side of triangle t the triangle o lies; side k is opposite to corner k."""
    return 0 if neighbour[t, 0] == o else (1 if neighbour[t, 1] == o else 2)


@njit()
def _replace_neighbour(neighbour: np.ndarray, t: int, old: int, new: int) -> None:
    """Name another triangle beside t."""
    if t != OUTSIDE:
        neighbour[t, _side(neighbour, t, old)] = new


@njit()
def _flip(tri: np.ndarray, neighbour: np.ndarray, t: int, k: int, triangle_of: np.ndarray) -> int:
    """Turn the edge between triangle t and that across its side k, which is returned, into the other diagonal."""
    o = neighbour[t, k]
    m = _side(neighbour, o, t)
    a, b, c, d = tri[t, k], tri[t, (k + 1) % 3], tri[t, (k + 2) % 3], tri[o, m]
    ab, ca = neighbour[t, (k + 2) % 3], neighbour[t, (k + 1) % 3]
    dc, bd = neighbour[o, (m + 2) % 3], neighbour[o, (m + 1) % 3]
    tri[t, 0], tri[t, 1], tri[t, 2] = a, b, d
    neighbour[t, 0], neighbour[t, 1], neighbour[t, 2] = bd, o, ab
    tri[o, 0], tri[o, 1], tri[o, 2] = a, d, c
    neighbour[o, 0], neighbour[o, 1], neighbour[o, 2] = dc, ca, t
    _replace_neighbour(neighbour, bd, o, t)
    _replace_neighbour(neighbour, ca, t, o)
    triangle_of[a], triangle_of[b], triangle_of[c], triangle_of[d] = t, t, o, t
    return o


@njit()
def _is_border(u: int, v: int, following: np.ndarray) -> bool:
    """Return whether two points are neighbours on the border."""
    return (u < len(following) and following[u] == v) or (v < len(following) and following[v] == u)


@njit()
def _insert(
    v: int,
    t: int,
    n_triangles: int,
    p: np.ndarray,
    tri: np.ndarray,
    neighbour: np.ndarray,
    triangle_of: np.ndarray,
    following: np.ndarray,
    stack: np.ndarray,
) -> int:
    """Divide triangle t at point v, and flip edges until all around are Delaunay but for the border; return the changed ones.

    Their numbers are written to `stack`.
    """
    a, b, c = tri[t, 0], tri[t, 1], tri[t, 2]
    na, nb, nc = neighbour[t, 0], neighbour[t, 1], neighbour[t, 2]
    t1, t2 = n_triangles, n_triangles + 1
    tri[t, 0], tri[t, 1], tri[t, 2] = v, b, c
    neighbour[t, 0], neighbour[t, 1], neighbour[t, 2] = na, t1, t2
    tri[t1, 0], tri[t1, 1], tri[t1, 2] = v, c, a
    neighbour[t1, 0], neighbour[t1, 1], neighbour[t1, 2] = nb, t2, t
    tri[t2, 0], tri[t2, 1], tri[t2, 2] = v, a, b
    neighbour[t2, 0], neighbour[t2, 1], neighbour[t2, 2] = nc, t, t1
    _replace_neighbour(neighbour, nb, t, t1)
    _replace_neighbour(neighbour, nc, t, t2)
    triangle_of[v], triangle_of[a], triangle_of[b], triangle_of[c] = t, t1, t2, t
    stack[0], stack[1], stack[2] = t, t1, t2
    # In front are triangles that stay, behind those whose side opposite to v is still in doubt
    done, m = 0, 3
    while done < m:
        f = stack[done]
        k = _corner(tri, f, v)
        o = neighbour[f, k]
        done += 1
        if o == OUTSIDE or _is_border(tri[f, (k + 1) % 3], tri[f, (k + 2) % 3], following):
            continue
        d = tri[o, _side(neighbour, o, f)]
        if _in_circle(tri[f, 0], tri[f, 1], tri[f, 2], d, p) and m < len(stack):
            stack[m] = _flip(tri, neighbour, f, k, triangle_of)
            m += 1
            done -= 1
    return m


@njit()
def _locate(v: int, t: int, n_triangles: int, p: np.ndarray, tri: np.ndarray, neighbour: np.ndarray) -> int:
    """Walk from triangle t to that around point v."""
    for _ in range(4 * n_triangles + 10):
        moved = False
        for k in range(3):
            o = neighbour[t, k]
            if o != OUTSIDE and _turn(tri[t, (k + 1) % 3], tri[t, (k + 2) % 3], v, p) < 0:
                t, moved = o, True
                break
        if not moved:
            break
    return t


@njit()
def _crossed(
    a: int,
    b: int,
    n_triangles: int,
    p: np.ndarray,
    tri: np.ndarray,
    neighbour: np.ndarray,
    triangle_of: np.ndarray,
) -> tuple[bool, list[tuple[int, int]]]:
    """Return whether a and b are joined, and the edges that the way from a to b crosses, none where it meets a point."""
    crossed = [(0, 0) for _ in range(0)]
    t = first = triangle_of[a]
    start = OUTSIDE
    while True:
        k = _corner(tri, t, a)
        u, w = tri[t, (k + 1) % 3], tri[t, (k + 2) % 3]
        if b in (u, w):
            return True, crossed
        if _turn(a, u, b, p) > 0 and _turn(a, w, b, p) < 0:
            start = t
        t = neighbour[t, (k + 1) % 3]
        if t in (OUTSIDE, first):
            break
    if start == OUTSIDE:
        return False, crossed
    t, k = start, _corner(tri, start, a)
    for _ in range(n_triangles):
        u, w = tri[t, (k + 1) % 3], tri[t, (k + 2) % 3]
        crossed.append((u, w))
        o = neighbour[t, k]
        d = tri[o, _side(neighbour, o, t)]
        if d == b:
            break
        t, k = o, _corner(tri, o, w if _turn(a, b, d, p) > 0 else u)
    return False, crossed


@njit()
def _triangle_at(u: int, w: int, tri: np.ndarray, neighbour: np.ndarray, triangle_of: np.ndarray) -> int:
    """Return the triangle in which w follows u, or OUTSIDE; around a corner of the triangle around all, they form no ring."""
    t = first = triangle_of[u]
    while True:
        k = _corner(tri, t, u)
        if tri[t, (k + 1) % 3] == w:
            return t
        t = neighbour[t, (k + 1) % 3]
        if t in (OUTSIDE, first):
            break
    t = neighbour[first, (_corner(tri, first, u) + 2) % 3]
    while t not in (OUTSIDE, first):
        k = _corner(tri, t, u)
        if tri[t, (k + 1) % 3] == w:
            return t
        t = neighbour[t, (k + 2) % 3]
    return OUTSIDE


@njit()
def _recover(
    a: int,
    b: int,
    n_triangles: int,
    p: np.ndarray,
    tri: np.ndarray,
    neighbour: np.ndarray,
    triangle_of: np.ndarray,
) -> bool:
    """Flip edges until a and b are joined; return whether they are."""
    joined, crossed = _crossed(a, b, n_triangles, p, tri, neighbour, triangle_of)
    if joined or len(crossed) == 0:
        return joined
    for _ in range(4 * n_triangles * len(crossed) + 16):
        u, w = crossed.pop(0)
        t = _triangle_at(u, w, tri, neighbour, triangle_of)
        if t == OUTSIDE:
            return False
        k = (_corner(tri, t, u) + 2) % 3
        x, d = tri[t, k], tri[neighbour[t, k], _side(neighbour, neighbour[t, k], t)]
        if _turn(x, u, d, p) > 0 and _turn(x, d, w, p) > 0:
            _flip(tri, neighbour, t, k, triangle_of)
            if a not in (x, d) and b not in (x, d) and _turn(a, b, x, p) * _turn(a, b, d, p) < 0:
                crossed.append((x, d))
        else:
            crossed.append((u, w))
        if len(crossed) == 0:
            return _crossed(a, b, n_triangles, p, tri, neighbour, triangle_of)[0]
    return False


@njit()
def _make_delaunay(
    n: int,
    n_triangles: int,
    p: np.ndarray,
    tri: np.ndarray,
    neighbour: np.ndarray,
    triangle_of: np.ndarray,
    following: np.ndarray,
) -> None:
    """Flip edges of triangles among the first n points, but for the border, where the other diagonal is Delaunay."""
    for _ in range(MAX_SWEEPS):
        changed = False
        for t in range(n_triangles):
            for k in range(3):
                o = neighbour[t, k]
                u, w, x = tri[t, (k + 1) % 3], tri[t, (k + 2) % 3], tri[t, k]
                if o < t or max(u, w, x) >= n or _is_border(u, w, following):
                    continue
                d = tri[o, _side(neighbour, o, t)]
                if d < n and _in_circle(x, u, w, d, p) and _turn(x, u, d, p) > 0 and _turn(x, d, w, p) > 0:
                    _flip(tri, neighbour, t, k, triangle_of)
                    changed = True
                    break
        if not changed:
            return


@njit()
def _keep_inside(
    n: int, n_triangles: int, tri: np.ndarray, neighbour: np.ndarray, following: np.ndarray, stack: np.ndarray
) -> int:
    """Keep the triangles on the left of the border, and return their number; FAILED where one reaches beyond the points."""
    number = np.full(n_triangles, OUTSIDE)
    m = kept = 0
    for t in range(n_triangles):
        for k in range(3):
            u, w = tri[t, (k + 1) % 3], tri[t, (k + 2) % 3]
            if number[t] == OUTSIDE and u < len(following) and following[u] == w:
                number[t] = 0
                stack[m] = t
                m += 1
    while m > 0:
        m -= 1
        t = stack[m]
        for k in range(3):
            u, w, o = tri[t, (k + 1) % 3], tri[t, (k + 2) % 3], neighbour[t, k]
            if _is_border(u, w, following):
                continue
            if o == OUTSIDE or max(u, w) >= n:
                return FAILED
            if number[o] == OUTSIDE:
                number[o] = 0
                stack[m] = o
                m += 1
    for t in range(n_triangles):
        if number[t] != OUTSIDE:
            number[t] = kept
            kept += 1
    for t in range(n_triangles):
        if number[t] == OUTSIDE:
            continue
        row = number[t]
        for k in range(3):
            if tri[t, k] >= n:
                return FAILED
        for k in range(3):
            o = neighbour[t, k]
            tri[row, k] = tri[t, k]
            neighbour[row, k] = OUTSIDE
            # an edge of the border leads out, whatever lies behind it
            if o != OUTSIDE and number[o] != OUTSIDE:
                neighbour[row, k] = number[o]
    for t in range(kept):
        for k in range(3):
            if _is_border(tri[t, (k + 1) % 3], tri[t, (k + 2) % 3], following):
                neighbour[t, k] = OUTSIDE
    return kept


@njit()
def fill_border(
    n: int,
    following: np.ndarray,
    p: np.ndarray,
    tri: np.ndarray,
    neighbour: np.ndarray,
    triangle_of: np.ndarray,
    stack: np.ndarray,
) -> int:
    """Triangulate what lies on the left of the border of n points of the plane, each joined to `following` (n,).

    Rows n to n + 2 of `p` are overwritten. Returns the number of triangles in `tri`, or FAILED.
    """
    low_x = high_x = p[0, 0]
    low_y = high_y = p[0, 1]
    for v in range(n):
        low_x, high_x = min(low_x, p[v, 0]), max(high_x, p[v, 0])
        low_y, high_y = min(low_y, p[v, 1]), max(high_y, p[v, 1])
    size = max(high_x - low_x, high_y - low_y, 1e-30)
    x, y = (low_x + high_x) / 2, (low_y + high_y) / 2
    p[n, 0], p[n, 1] = x - 30 * size, y - 20 * size
    p[n + 1, 0], p[n + 1, 1] = x + 30 * size, y - 20 * size
    p[n + 2, 0], p[n + 2, 1] = x, y + 40 * size
    tri[0, 0], tri[0, 1], tri[0, 2] = n, n + 1, n + 2
    neighbour[0, 0] = neighbour[0, 1] = neighbour[0, 2] = OUTSIDE
    n_triangles, t = 1, 0
    for v in range(n):
        t = _locate(v, t, n_triangles, p, tri, neighbour)
        _insert(v, t, n_triangles, p, tri, neighbour, triangle_of, following[:0], stack)
        n_triangles += 2
        t = triangle_of[v]
    for v in range(n):
        if not _recover(v, following[v], n_triangles, p, tri, neighbour, triangle_of):
            return FAILED
    n_triangles = _keep_inside(n, n_triangles, tri, neighbour, following, stack)
    if n_triangles != FAILED:
        _make_delaunay(n, n_triangles, p, tri, neighbour, triangle_of, following)
    return n_triangles


@njit()
def _circumcircle(t: int, tri: np.ndarray, units: np.ndarray) -> tuple[Vector, float]:
    """Return the pole of the circle around a triangle on the unit sphere, and the squared chord from it to the corners."""
    a = point(units, tri[t, 0])
    normal = cross(subtract(point(units, tri[t, 1]), a), subtract(point(units, tri[t, 2]), a))
    length = math.sqrt(dot(normal, normal))
    if length == 0.0:
        return a, 0.0
    pole = scaled(1 / length, normal)
    return pole, math.floor(squared_distance(pole, a) * PARTS_OF_CHORD + 0.5) / PARTS_OF_CHORD


@njit()
def _sees_border(v: int, t: int, tri: np.ndarray, units: np.ndarray, following: np.ndarray) -> bool:
    """Return whether an edge of the border at triangle t is too near to a point v in it."""
    for k in range(3):
        u, w = tri[t, (k + 1) % 3], tri[t, (k + 2) % 3]
        if _is_border(u, w, following):
            a, b = subtract(point(units, u), point(units, v)), subtract(point(units, w), point(units, v))
            if dot(a, b) < MAX_COSINE_AT_BORDER * math.sqrt(dot(a, a) * dot(b, b)):
                return True
    return False


@njit()
def add_points(
    n: int,
    n_triangles: int,
    widest: float,
    frame: np.ndarray,
    following: np.ndarray,
    p: np.ndarray,
    units: np.ndarray,
    tri: np.ndarray,
    neighbour: np.ndarray,
    triangle_of: np.ndarray,
    stack: np.ndarray,
) -> tuple[int, int]:
    """Add points inside of the triangles until the circles around them have chords of at most `widest`, on the unit sphere.

    `frame` (3, 3) has the axes x, y and the axis of the projection. Returns the numbers of points and of triangles; there is
    room for `len(units)` points.
    """
    limit, heap = widest * widest, [(0.0, 0, (0, 0, 0)) for _ in range(0)]
    for t in range(n_triangles):
        _, d2 = _circumcircle(t, tri, units)
        if d2 > limit:
            heap.append((-d2, t, (tri[t, 0], tri[t, 1], tri[t, 2])))
    heapq.heapify(heap)
    while len(heap) > 0 and n < len(units):
        _, t, corners = heapq.heappop(heap)
        if corners != (tri[t, 0], tri[t, 1], tri[t, 2]):
            continue
        pole, _ = _circumcircle(t, tri, units)
        set_point(units, n, pole)
        if not project(n, frame, units, p):
            continue
        # On the way to the new point, the border may not be crossed
        blocked = False
        for _ in range(n_triangles):
            moved = False
            for k in range(3):
                if _turn(tri[t, (k + 1) % 3], tri[t, (k + 2) % 3], n, p) < 0:
                    if neighbour[t, k] == OUTSIDE:
                        blocked = True
                    else:
                        t, moved = neighbour[t, k], True
                    break
            if blocked or not moved:
                break
        if blocked or _sees_border(n, t, tri, units, following):
            continue
        m = _insert(n, t, n_triangles, p, tri, neighbour, triangle_of, following, stack)
        n, n_triangles = n + 1, n_triangles + 2
        for s in range(m):
            f = stack[s]
            _, d2 = _circumcircle(f, tri, units)
            if d2 > limit:
                heapq.heappush(heap, (-d2, f, (tri[f, 0], tri[f, 1], tri[f, 2])))
    return n, n_triangles


@njit()
def project(v: int, frame: np.ndarray, units: np.ndarray, p: np.ndarray) -> bool:
    """Write the stereographic projection of a unit vector; return False for the pole opposite to the axis."""
    u = point(units, v)
    k = 1 + dot(u, point(frame, 2))
    if k < 1e-12:
        return False
    p[v, 0], p[v, 1] = dot(u, point(frame, 0)) / k, dot(u, point(frame, 1)) / k
    return True
