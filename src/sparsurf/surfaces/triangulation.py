"""Triangles of the pieces of a molecular surface, whose vertices lie on it.

Every edge of the pieces is divided once, and both faces at it share its points. So the triangles close as the pieces do, and have
their handles. A saddle is divided into strips along its arc; a part of a sphere is triangulated between the points of its border
(`constrained_delaunay`). Then thin triangles are removed, and edges are collapsed until as many vertices are left as requested.
"""

from __future__ import annotations

import logging
import math
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sparsurf.arguments import Cavities
from sparsurf.errors import InputError, argument
from sparsurf.kernels import njit
from sparsurf.surfaces.chosen_points import on_steps
from sparsurf.surfaces.components import enclosed_of
from sparsurf.surfaces.constrained_delaunay import FAILED, add_points, fill_border, project
from sparsurf.surfaces.crossing_triangles import crossing_triangles
from sparsurf.surfaces.decimation import GRID_STEP, mesh_that_is_left, n_vertices_of, reduce_to, sized_mesh
from sparsurf.surfaces.dot_placement import Rolled, roll_checked
from sparsurf.surfaces.grid import pairs_within, sort_into_grid
from sparsurf.surfaces.grid_mesh import mesh_of_dense
from sparsurf.surfaces.half_edges import remaining, twins
from sparsurf.surfaces.mesh import Mesh, MeshSize, build_mesh
from sparsurf.surfaces.molecular_surface import RolledFrame
from sparsurf.surfaces.pieces import (
    CONTACT_ARC,
    CUSP_ARC,
    HIGH,
    LOW,
    PROBE_ARC,
    RADIUS,
    Pieces,
    pieces_of,
    shapes_of,
)
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.rolling_probe import (
    ARC_RADIUS,
    CLOSED,
    E1,
    E2,
    PHI_0,
    PHI_1,
    THETA_I,
    THETA_J,
    EnclosedCentres,
    Rolling,
    T,
    U,
    no_enclosed_centres,
)
from sparsurf.surfaces.slivers import remove_slivers
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE, Surface
from sparsurf.surfaces.vectors import (
    Vector,
    add_scaled,
    cross,
    dot,
    doubled,
    point,
    scaled,
    set_point,
    slots,
    squared_distance,
    subtract,
    vector_at,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")

HALFWAY = 1e-9  # rad; what lies halfway belongs to the first atom, whatever its rounding
FEWEST_ROWS = 64  # of arrays that are made longer when they are full
MAX_ATTEMPTS = 4  # to keep triangles from passing through one another
MAX_DIVISIONS = 12  # of edges whose lines cross, each into twice as many
RESERVE = 0.95
FINER, FINEST = 0.75, 0.4  # of a spacing whose triangles do not close, the next one and the last one
SPACING = 1.13  # Å, times the root of the density
SURPLUS = 1.16  # vertices at this spacing for each that is requested
SPARE = 500  # of so many vertices, one is left for thin triangles
WIDEST_SPACING = 0.8  # Å; triangles of longer edges are collapsed from these
POINTS_PER_AREA = 2.5  # at most, of a face, on the square of the spacing
FINEST_STEP = 0.1  # Å
VERTICES_PER_STEP = 4.5  # vertices per Å^2 times the square of the step of a grid that has as many
DENSITY_BETWEEN = 10.0  # dots per Å^2, of a surface whose pieces do not close
WIDEST_CIRCLE = (
    0.62  # of a triangle inside of a face, on the spacing of the vertices: .58 where it is equilateral
)


class Triangles(NamedTuple):
    """Triangles on the surface, and its points."""

    points: np.ndarray  # (V, 3) Å, as those of the pieces
    normals: np.ndarray  # (V, 3) outward; where faces meet at a cusp, their mean
    kind: np.ndarray  # (V,) int8
    atom: np.ndarray  # (V,) int64, as rolled
    triangles: np.ndarray  # (F, 3) int64, counterclockwise from outside


class _Divided(NamedTuple):
    """Into how many parts each edge is divided, and the number of its first point after the vertices of all edges."""

    n: np.ndarray  # (E,) int64
    first: np.ndarray  # (E,) int64


def _groups(pieces: Pieces) -> np.ndarray:
    """Return for each edge a number that it shares with the edges that are divided alike: both ends of a saddle."""
    n_edges = len(pieces.ends)
    groups = np.arange(n_edges)
    at_probe = np.flatnonzero(pieces.edge_kind == PROBE_ARC)
    key = 2 * pieces.edge_owner[at_probe, 0] + (pieces.circles[at_probe, LOW] > 0)
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    groups[at_probe] = at_probe[first][group]
    return groups


def _divisions(pieces: Pieces, groups: np.ndarray, spacing: float) -> np.ndarray:
    """Return into how many parts each edge is divided; of several between the same two vertices, only one may be a chord."""
    length = pieces.circles[:, RADIUS] * (pieces.circles[:, HIGH] - pieces.circles[:, LOW])
    closed = pieces.ends[:, 0] < 0
    n = np.maximum(np.round(length / spacing).astype(np.int64), np.where(closed, 3, 1))
    ends = np.sort(pieces.ends, axis=1)
    key = ends[:, 0] * (len(pieces.vertices) + 1) + ends[:, 1]
    order = np.argsort(key, kind="stable")
    again = np.zeros(len(n), bool)
    again[order[1:]] = (key[order[1:]] == key[order[:-1]]) & ~closed[order[1:]]
    n[again] = np.maximum(n[again], 2)
    np.maximum.at(n, groups, n)
    return n[groups]


@njit()
def _nearest_of_three(position: Vector, rolling: Rolling, q: int) -> int:
    """Return the atom of a fixed probe that is nearest to a position, to which dots there belong."""
    owner = rolling.triple[q, 0]
    for c in range(1, 3):
        other = rolling.triple[q, c]
        nearest = squared_distance(point(rolling.atoms.centre, owner), position)
        if squared_distance(point(rolling.atoms.centre, other), position) < nearest:
            owner = other
    return owner


@njit()
def _of_saddle(rolling: Rolling, b: int, theta: float) -> int:
    """Return the atom that dots of a saddle at theta belong to."""
    arc = rolling.arcs[b]
    return rolling.pair[b, int(2 * theta > arc[THETA_I] + arc[THETA_J] + HALFWAY)]


@njit()
def _sample_edges(
    pieces: Pieces,
    rolling: Rolling,
    divided: _Divided,
    points: np.ndarray,
    kind: np.ndarray,
    atom: np.ndarray,
) -> None:
    """Write the vertices and the points of each edge, and their kinds and atoms; -1 of those that count as concave.

    Half of the area along a border belongs to either side, and so does each second point.
    """
    for v in range(len(pieces.vertices)):
        set_point(points, v, point(pieces.vertices, v))
    # Where edges meet, those of cusps decide, and then those of contacts
    for this in (PROBE_ARC, CONTACT_ARC, CUSP_ARC):
        for e in range(len(divided.n)):
            if pieces.edge_kind[e] != this:
                continue
            circle, owner, other = pieces.circles[e], pieces.edge_owner[e, 0], pieces.edge_owner[e, 1]
            n = divided.n[e]
            for k in range(n + 1):
                v = _point_of_edge(pieces, e, k, divided)
                phi = circle[LOW] + k / n * (circle[HIGH] - circle[LOW])
                if v >= len(pieces.vertices):
                    here = add_scaled(
                        vector_at(circle, T), circle[RADIUS] * math.cos(phi), vector_at(circle, E1)
                    )
                    set_point(
                        points, v, add_scaled(here, circle[RADIUS] * math.sin(phi), vector_at(circle, E2))
                    )
                if this == CONTACT_ARC:
                    kind[v], atom[v] = SADDLE if k % 2 else CONTACT, rolling.pair[owner, other]
                elif this == PROBE_ARC and k % 2:
                    kind[v], atom[v] = CONCAVE, -1
                elif this == PROBE_ARC:
                    kind[v], atom[v] = SADDLE, _of_saddle(rolling, owner, phi)
                else:
                    kind[v], atom[v] = CONCAVE, _nearest_of_three(point(points, v), rolling, owner)
    for f in range(len(pieces.face_kind)):  # an apex, where a torus intersects itself, is a cusp as well
        if pieces.apex[f] >= 0:
            kind[pieces.apex[f]] = CONCAVE
            atom[pieces.apex[f]] = _of_saddle(rolling, pieces.face_owner[f], pieces.theta[f, 0])


@njit()
def _sphere(pieces: Pieces, rolling: Rolling, probe: float, f: int) -> tuple[Vector, float]:
    """Return centre and radius of the sphere of a contact or concave face."""
    owner = pieces.face_owner[f]
    if pieces.face_kind[f] == CONTACT:
        return point(rolling.atoms.centre, owner), rolling.atoms.reach[owner] - probe
    return point(rolling.probes, owner), probe


@njit()
def _axis(pieces: Pieces, rolling: Rolling, f: int) -> Vector:
    """Return the axis of the projection of a face, whose opposite lies outside of it."""
    owner = pieces.face_owner[f]
    if pieces.face_kind[f] == CONCAVE:
        probe, total, nearest = point(rolling.probes, owner), (0.0, 0.0, 0.0), np.inf
        for c in range(3):
            v = subtract(point(rolling.atoms.centre, rolling.triple[owner, c]), probe)
            total = add_scaled(total, 1 / math.sqrt(dot(v, v)), v)
        for loop in slots(pieces.face_start, f):
            for d in slots(pieces.loop_start, loop):
                e = pieces.loop_edges[d] // 2
                if pieces.edge_kind[e] == PROBE_ARC:
                    return scaled(1 / math.sqrt(dot(total, total)), total)
        # A probe that four atoms hold has no sides: its face is the sphere outside of the other probes that cut it
        for loop in slots(pieces.face_start, f):
            for d in slots(pieces.loop_start, loop):
                v = subtract(probe, vector_at(pieces.circles[pieces.loop_edges[d] // 2], T))
                if dot(v, v) < nearest:
                    total, nearest = v, dot(v, v)
        return scaled(1 / math.sqrt(dot(total, total)), total)
    best, axis = 2.0, (0.0, 0.0, 1.0)
    for loop in slots(pieces.face_start, f):
        for d in slots(pieces.loop_start, loop):
            b = pieces.edge_owner[pieces.loop_edges[d] // 2, 0]
            arc, side = rolling.arcs[b], rolling.pair[b, 1] == owner
            height = math.sin(arc[THETA_J]) if side else -math.sin(arc[THETA_I])
            if height < best:
                best, axis = height, scaled(1.0 if side else -1.0, vector_at(arc, U))
    return axis


@njit()
def _write_frame(axis: Vector, frame: np.ndarray) -> None:
    """Write a right-handed frame, (3, 3), whose last row is an axis."""
    flat = math.hypot(axis[0], axis[2])
    x = (-axis[2] / flat, 0.0, axis[0] / flat) if flat > 0 else (1.0, 0.0, 0.0)
    set_point(frame, 0, x)
    set_point(frame, 1, cross(axis, x))
    set_point(frame, 2, axis)


@njit()
def _point_of_edge(pieces: Pieces, e: int, k: int, divided: _Divided) -> int:
    """Return the point after k parts of an edge."""
    n, first = divided.n[e], divided.first[e]
    if pieces.ends[e, 0] < 0:
        return first + k % n
    return pieces.ends[e, int(k > 0)] if k in (0, n) else first + k - 1


@njit()
def _write_border(
    pieces: Pieces, f: int, divided: _Divided, ids: np.ndarray, following: np.ndarray, edge: np.ndarray
) -> int:
    """Write the points along the loops of a face, the next of each, and the edge between both; return their number."""
    m = 0
    for loop in slots(pieces.face_start, f):
        begin = m
        for d in slots(pieces.loop_start, loop):
            e, is_back = pieces.loop_edges[d] // 2, pieces.loop_edges[d] % 2 == 1
            for k in range(divided.n[e]):
                ids[m] = _point_of_edge(pieces, e, divided.n[e] - k if is_back else k, divided)
                following[m], edge[m] = m + 1, e
                m += 1
        following[m - 1] = begin
    return m


@njit()
def _longest_border(pieces: Pieces, n: np.ndarray) -> int:
    """Return the largest number of points along the loops of a face."""
    longest = 3
    for f in range(len(pieces.face_kind)):
        total = 0
        for d in range(pieces.loop_start[pieces.face_start[f]], pieces.loop_start[pieces.face_start[f + 1]]):
            total += n[pieces.loop_edges[d] // 2]
        longest = max(longest, total)
    return longest


@njit()
def _turns(p: np.ndarray, a: int, b: int, c: int) -> float:
    """Return twice the signed area of a triangle of the plane, positive counterclockwise."""
    return (p[b, 0] - p[a, 0]) * (p[c, 1] - p[a, 1]) - (p[b, 1] - p[a, 1]) * (p[c, 0] - p[a, 0])


@njit()
def _mark_crossing(
    pieces: Pieces,
    rolling: Rolling,
    probe: float,
    divided: _Divided,
    points: np.ndarray,
    in_doubt: np.ndarray,
    marked: np.ndarray,
) -> None:
    """Mark the edges of faces in doubt whose lines cross in the projection, or whose loops turn the wrong way."""
    longest = _longest_border(pieces, divided.n)
    ids, following, edge = np.empty((3, longest), np.int64)
    p, units, frame = np.empty((longest, 2)), np.empty((longest, 3)), np.empty((3, 3))
    for f in range(len(pieces.face_kind)):
        if (
            not in_doubt[f]
            or pieces.face_kind[f] == SADDLE
            or pieces.face_start[f] == pieces.face_start[f + 1]
        ):
            continue
        m = _write_border(pieces, f, divided, ids, following, edge)
        centre, radius = _sphere(pieces, rolling, probe, f)
        _write_frame(_axis(pieces, rolling, f), frame)
        for a in range(m):
            set_point(units, a, scaled(1 / radius, subtract(point(points, ids[a]), centre)))
            project(a, frame, units, p)
        a = 0
        while a < m:  # each loop: the outer one, then the holes
            begin, area = a, 0.0
            while True:
                b = following[a]
                area += p[a, 0] * p[b, 1] - p[b, 0] * p[a, 1]
                a += 1
                if b == begin:
                    break
            if a - begin < 3 or (area > 0) != (begin == 0):
                for c in range(begin, a):
                    marked[edge[c]] = True
        for a in range(m):
            b = following[a]
            for c in range(a + 1, m):
                d = following[c]
                if (
                    _turns(p, a, b, c) * _turns(p, a, b, d) < 0
                    and _turns(p, c, d, a) * _turns(p, c, d, b) < 0
                    and b != c
                    and d != a
                ):
                    marked[edge[a]] = marked[edge[c]] = True


class _Made(NamedTuple):
    """Points and triangles so far, in arrays with room for more."""

    points: np.ndarray  # (., 3) Å
    of_point: np.ndarray  # (., 1) int64, face of each, -1 on edges
    triangles: np.ndarray  # (., 4) int64, three points and the face
    n: np.ndarray  # (2,) int64, numbers of points and of triangles


@njit()
def _with_room(made: _Made, n_points: int, n_triangles: int) -> _Made:
    """Return arrays with room for more points and triangles."""
    points, of_point, triangles = made.points, made.of_point, made.triangles
    while len(points) < made.n[0] + n_points:
        points, of_point = doubled(points), doubled(of_point)
    while len(triangles) < made.n[1] + n_triangles:
        triangles = doubled(triangles)
    return _Made(points, of_point, triangles, made.n)


@njit()
def _add_point(made: _Made, position: Vector, f: int) -> int:
    """Add a point inside of a face, and return its number."""
    v = made.n[0]
    set_point(made.points, v, position)
    made.of_point[v, 0] = f
    made.n[0] += 1
    return v


@njit()
def _add_triangle(made: _Made, a: int, b: int, c: int, f: int) -> None:
    """Add a triangle of a face."""
    row = made.triangles[made.n[1]]
    row[0], row[1], row[2], row[3] = a, b, c, f
    made.n[1] += 1


@njit()
def _on_saddle(arc: np.ndarray, probe: float, phi: float, theta: float) -> Vector:
    """Return the point of a saddle at two angles."""
    outward = add_scaled(scaled(math.cos(phi), vector_at(arc, E1)), math.sin(phi), vector_at(arc, E2))
    position = add_scaled(vector_at(arc, T), arc[ARC_RADIUS] - probe * math.cos(theta), outward)
    return add_scaled(position, probe * math.sin(theta), vector_at(arc, U))


@njit()
def _edges_of_saddle(pieces: Pieces, f: int) -> tuple[int, int, int, int]:
    """Return the edges of a saddle at its two atoms and at the two ends of its arc, -1 where there is none."""
    at_i = at_j = at_0 = at_1 = -1
    for loop in slots(pieces.face_start, f):
        for d in slots(pieces.loop_start, loop):
            e = pieces.loop_edges[d] // 2
            is_second = pieces.edge_owner[e, 1] == 1
            if pieces.edge_kind[e] == CONTACT_ARC:
                at_i, at_j = (at_i, e) if is_second else (e, at_j)
            else:
                at_0, at_1 = (at_0, e) if is_second else (e, at_1)
    return at_i, at_j, at_0, at_1


@njit()
def _fill_saddle(
    made: _Made, pieces: Pieces, f: int, arc: np.ndarray, probe: float, divided: _Divided, spacing: float
) -> _Made:
    """Divide a saddle into strips along its arc, from the row of points at one atom to that at the other, or to the apex."""
    n = divided.n
    low, high, turn = pieces.theta[f, 0], pieces.theta[f, 1], arc[PHI_1] - arc[PHI_0]
    at_i, at_j, at_0, at_1 = _edges_of_saddle(pieces, f)
    closed = at_0 < 0
    n_strips = max(1, round(probe * (high - low) / spacing)) if closed else n[at_0]
    before = np.empty(0, np.int64)
    for k in range(n_strips + 1):
        theta = low + (high - low) * k / n_strips
        e = at_i if k == 0 else (at_j if k == n_strips else -1)
        m = max(3 if closed else 1, round((arc[ARC_RADIUS] - probe * math.cos(theta)) * turn / spacing))
        if e >= 0:
            m = n[e]
        elif k in (0, n_strips):
            m = 0
        row = np.empty(m + 1, np.int64)
        made = _with_room(made, m + 1, m + len(before))
        for i in range(m + 1):
            if m == 0:
                row[i] = pieces.apex[f]
            elif e >= 0:
                row[i] = _point_of_edge(pieces, e, i, divided)
            elif closed and i == m:
                row[i] = row[0]
            elif not closed and i in (0, m):
                row[i] = _point_of_edge(pieces, at_1 if i else at_0, k, divided)
            else:
                row[i] = _add_point(made, _on_saddle(arc, probe, arc[PHI_0] + turn * i / m, theta), f)
        i = j = 0
        while i < len(before) - 1 or (j < m and len(before) > 0):
            a, b = before[i], row[j]
            along = i < len(before) - 1
            if along and j < m:  # the shorter diagonal
                along = squared_distance(
                    point(made.points, before[i + 1]), point(made.points, b)
                ) <= squared_distance(point(made.points, row[j + 1]), point(made.points, a))
            if along:
                _add_triangle(made, before[i + 1], a, b, f)
                i += 1
            else:
                _add_triangle(made, b, row[j + 1], a, f)
                j += 1
        before = row
    return made


@njit()
def _fill_border_on_sphere(
    made: _Made,
    f: int,
    ids: np.ndarray,
    following: np.ndarray,
    axis: Vector,
    sphere: tuple[Vector, float],
    room: int,
    spacing: float,
    seen_from_inside: bool,
) -> tuple[_Made, bool]:
    """Triangulate the part of a sphere on the left of a border, with at most `room` points; return whether that was possible."""
    (centre, radius), m, frame = sphere, len(ids), np.empty((3, 3))
    _write_frame(axis, frame)
    p, units = np.empty((room + 3, 2)), np.empty((room, 3))
    tri, neighbour = np.empty((2 * room + 8, 3), np.int64), np.empty((2 * room + 8, 3), np.int64)
    here, stack = np.empty(room + 3, np.int64), np.empty(8 * room + 64, np.int64)
    for a in range(m):
        set_point(units, a, scaled(1 / radius, subtract(point(made.points, ids[a]), centre)))
        project(a, frame, units, p)
    t = fill_border(m, following, p, tri, neighbour, here, stack)
    if t == FAILED:
        return made, False
    widest = WIDEST_CIRCLE * spacing / radius
    size, t = add_points(m, t, widest, frame, following, p, units, tri, neighbour, here, stack)
    made = _with_room(made, size - m, t)
    before = made.n[0] - m
    for a in range(m, size):
        _add_point(made, add_scaled(centre, radius, point(units, a)), f)
    for c in range(t):
        u, v, w = tri[c, 0], tri[c, 1], tri[c, 2]
        u, v, w = (
            ids[u] if u < m else before + u,
            ids[v] if v < m else before + v,
            ids[w] if w < m else before + w,
        )
        _add_triangle(made, w if seen_from_inside else u, v, u if seen_from_inside else w, f)
    return made, True


@njit()
def _fill_faces(
    pieces: Pieces,
    rolling: Rolling,
    probe: float,
    divided: _Divided,
    spacing: float,
    points: np.ndarray,
    n_points: int,
) -> tuple[_Made, bool]:
    """Triangulate all faces between the points of the edges; return whether that was possible."""
    of_edges = np.full((len(points), 1), -1)
    rows = np.empty((2 * len(points), 4), np.int64)
    made = _Made(points, of_edges, rows, np.array([n_points, 0]))
    longest = _longest_border(pieces, divided.n)
    ids, following, edge = np.empty((3, longest), np.int64)
    for f in range(len(pieces.face_kind)):
        kind = pieces.face_kind[f]
        if kind == SADDLE:
            made = _fill_saddle(made, pieces, f, rolling.arcs[pieces.face_owner[f]], probe, divided, spacing)
            continue
        sphere, is_possible = _sphere(pieces, rolling, probe, f), True
        room = int(POINTS_PER_AREA * pieces.solid[f] * sphere[1] ** 2 / spacing**2) + 8
        if pieces.face_start[f] == pieces.face_start[f + 1]:
            # A whole sphere is divided at an equator
            m = max(3, round(2 * math.pi * sphere[1] / spacing))
            made = _with_room(made, m, 0)
            equator, following_of_equator = np.empty(m, np.int64), np.empty(m, np.int64)
            for a in range(m):
                phi = 2 * math.pi * a / m
                equator[a] = _add_point(
                    made, add_scaled(sphere[0], sphere[1], (math.cos(phi), math.sin(phi), 0.0)), f
                )
                following_of_equator[a] = (a + 1) % m
            for up in (1.0, -1.0):
                made, is_half = _fill_border_on_sphere(
                    made,
                    f,
                    equator,
                    following_of_equator,
                    (0.0, 0.0, up),
                    sphere,
                    room + 2 * m,
                    spacing,
                    False,
                )
                is_possible &= is_half
                equator = equator[::-1].copy()
        else:
            m = _write_border(pieces, f, divided, ids, following, edge)
            axis = _axis(pieces, rolling, f)
            made, is_possible = _fill_border_on_sphere(
                made, f, ids[:m], following[:m], axis, sphere, room + 2 * m, spacing, kind == CONCAVE
            )
        if not is_possible:
            return made, False
    return made, True


@njit()
def _label_points(
    pieces: Pieces,
    rolling: Rolling,
    probe: float,
    points: np.ndarray,
    of_point: np.ndarray,
    triangles: np.ndarray,
    normals: np.ndarray,
    kind: np.ndarray,
    atom: np.ndarray,
) -> None:
    """Write kind and atom of the points inside of faces, and the normals of all."""
    for v in range(len(points)):
        f = of_point[v, 0]
        if f < 0:
            continue
        owner = pieces.face_owner[f]
        kind[v] = pieces.face_kind[f]
        if kind[v] == CONTACT:
            atom[v] = owner
        elif kind[v] == CONCAVE:
            atom[v] = _nearest_of_three(point(points, v), rolling, owner)
        else:
            arc = rolling.arcs[owner]
            height = dot(subtract(point(points, v), vector_at(arc, T)), vector_at(arc, U))
            atom[v] = _of_saddle(rolling, owner, math.asin(height / probe))
    for c in range(len(triangles)):
        f = triangles[c, 3]
        owner = pieces.face_owner[f]
        for k in range(3):
            v = triangles[c, k]
            here = point(points, v)
            if atom[v] < 0 and pieces.face_kind[f] == CONCAVE:
                atom[v] = _nearest_of_three(here, rolling, owner)
            if pieces.face_kind[f] == SADDLE:
                arc = rolling.arcs[owner]
                w = subtract(here, vector_at(arc, T))
                outward = add_scaled(w, -dot(w, vector_at(arc, U)), vector_at(arc, U))
                flat = math.sqrt(dot(outward, outward))
                centre = vector_at(arc, T)
                if flat > 1e-9:  # at an apex, the mean of all around it
                    centre = add_scaled(centre, arc[ARC_RADIUS] / flat, outward)
                normal = scaled(1 / probe, subtract(centre, here))
            else:
                centre, radius = _sphere(pieces, rolling, probe, f)
                sign = 1.0 if pieces.face_kind[f] == CONTACT else -1.0
                normal = scaled(sign / radius, subtract(here, centre))
            set_point(normals, v, add_scaled(point(normals, v), 1.0, normal))
    for v in range(len(points)):
        length = math.sqrt(dot(point(normals, v), point(normals, v)))
        if length > 0:
            set_point(normals, v, scaled(1 / length, point(normals, v)))


def triangulate(pieces: Pieces, rolled: Rolled, spacing: float) -> Triangles | None:
    """Triangulate the pieces of a surface with edges of about `spacing`, Å; None where the border of a face crosses itself."""
    rolling, probe = rolled.rolling, rolled.probe
    groups = _groups(pieces)
    n = _divisions(pieces, groups, spacing)
    in_doubt = np.ones(len(pieces.face_kind), bool)
    of_direction = np.repeat(np.arange(len(pieces.face_kind)), np.diff(pieces.loop_start[pieces.face_start]))
    found = None
    for _ in range(MAX_DIVISIONS):
        count = np.where(pieces.ends[:, 0] < 0, n, n - 1)
        divided = _Divided(n, len(pieces.vertices) + np.cumsum(count) - count)
        n_points = len(pieces.vertices) + int(count.sum())
        points = np.empty((2 * n_points + FEWEST_ROWS, 3))
        kind, atom = np.empty(n_points, np.int8), np.empty(n_points, np.int64)
        _sample_edges(pieces, rolling, divided, points, kind, atom)
        marked = np.zeros(len(n), bool)
        _mark_crossing(pieces, rolling, probe, divided, points, in_doubt, marked)
        if not marked.any():
            made, is_possible = _fill_faces(pieces, rolling, probe, divided, spacing, points, n_points)
            if not is_possible:
                break
            found = _labelled(pieces, rolling, probe, made, kind, atom)
            crosses = crossing_triangles(found.points, found.normals, found.triangles)
            if not crosses.any():
                break
            thin = np.zeros(len(pieces.face_kind), bool)  # films, which the chords of their borders leave
            thin[made.triangles[: made.n[1]][crosses, 3]] = True
            marked[pieces.loop_edges[thin[of_direction]] // 2] = True
        is_divided = np.isin(groups, groups[marked])
        n = np.where(is_divided, 2 * n, n)
        in_doubt[:] = False
        in_doubt[of_direction[is_divided[pieces.loop_edges // 2]]] = True
    return found


def _labelled(
    pieces: Pieces, rolling: Rolling, probe: float, made: _Made, kind: np.ndarray, atom: np.ndarray
) -> Triangles:
    """Return the triangles of faces with normals, kinds and atoms, given those of the points on edges."""
    n_points, n_triangles = made.n
    added = np.zeros(n_points - len(kind), np.int64)
    kind, atom = np.append(kind, added.astype(np.int8)), np.append(atom, added)
    points, triangles = made.points[:n_points], made.triangles[:n_triangles]
    normals = np.zeros_like(points)
    _label_points(pieces, rolling, probe, points, made.of_point, triangles, normals, kind, atom)
    return Triangles(points, normals, kind, atom, triangles[:, :3].copy())


def molecular_mesh(
    xyz: ArrayLike,
    radii: ArrayLike,
    probe: float = PROBE_RADIUS,
    size: MeshSize | None = None,
    cavities: Cavities = "keep",
) -> Mesh:
    """Triangulate the solvent-excluded surface of spheres, (A, 3) and (A,) Å; its vertices lie on the surface."""
    return mesh_of_rolled(roll_checked(xyz, radii, probe, cavities=cavities, in_order=True), size)


def mesh_of_rolled(
    rolled: Rolled, size: MeshSize | None = None, left_out: EnclosedCentres | None = None
) -> Mesh:
    """Triangulate the surface below the centres of a rolled probe, but for those that are left out: by default, those enclosed.

    The triangles close as the pieces of the surface do, and have their handles. Where they do not, since the pieces are
    degenerate, the mesh is that of a grid around dots, and a warning says that its handles are the grid's.
    """
    rolled = _where_kept(rolled, left_out)
    pieces = pieces_of(rolled)
    shapes = shapes_of(rolled, pieces)
    return mesh_of_pieces(pieces, rolled, size or MeshSize(), float(shapes.area.sum()), int(shapes.chi.sum()))


def accessible_mesh(rolled: Rolled, size: MeshSize | None = None) -> Mesh:
    """Triangulate the accessible surface: the parts of spheres on which the centre of a rolled probe can lie."""
    rolled = _where_kept(rolled)
    reach = rolled.rolling.atoms.reach
    pieces, chi = _spheres_of_centres(pieces_of(rolled), rolled.rolling)
    area = float(pieces.solid @ reach[pieces.face_owner] ** 2)
    made = mesh_of_pieces(pieces, rolled._replace(radii=reach, probe=0.0), size or MeshSize(), area, chi)
    kind = np.full_like(made.vertices.kind, CONTACT)  # there are no saddles beyond its borders
    return replace(made, vertices=replace(made.vertices, kind=kind))


def _where_kept(rolled: Rolled, left_out: EnclosedCentres | None = None) -> Rolled:
    """Return a probe without the centres that are left out, or, where walls of cavities are removed, without those enclosed."""
    if left_out is None and rolled.cavities == "remove":
        left_out = enclosed_of(rolled)
    return rolled if left_out is None else without_centres(rolled, left_out)


def _spheres_of_centres(pieces: Pieces, rolling: Rolling) -> tuple[Pieces, int]:
    """Return the parts of the spheres of the probe's centres, which meet at its arcs, and their Euler characteristic."""
    from scipy.sparse import coo_array  # here, as below: it takes long to load
    from scipy.sparse.csgraph import connected_components

    faces = np.flatnonzero(pieces.face_kind == CONTACT)
    n_loops = np.diff(pieces.face_start)[faces]
    loops = _ranges(pieces.face_start[faces], n_loops)
    n_edges = np.diff(pieces.loop_start)[loops]
    codes = pieces.loop_edges[_ranges(pieces.loop_start[loops], n_edges)]
    arcs, edges = np.unique(pieces.edge_owner[codes // 2, 0], return_inverse=True)
    # Two contact pieces end on an arc; where their corners are, the arc ends, and the corners of all atoms there are one vertex
    contact = np.flatnonzero(pieces.edge_kind == CONTACT_ARC)
    of_arc = np.zeros((len(rolling.arcs), 2), np.int64)
    of_arc[pieces.edge_owner[contact, 0], pieces.edge_owner[contact, 1]] = contact
    corners = pieces.ends[of_arc[arcs]]  # by arc, atom and end
    meets = (corners[:, 0, 0] >= 0, slice(None))
    pairs = corners[meets].transpose(1, 0, 2).reshape(2, -1)
    n = len(pieces.vertices)
    meeting = coo_array((np.ones(pairs.shape[1]), pairs), shape=(n, n))
    vertex = connected_components(meeting, directed=False)[1]
    ends = np.append(vertex, -1)[corners[:, 0]]  # -1 where an arc is a whole circle
    used, ends[ends >= 0] = np.unique(ends[ends >= 0], return_inverse=True)
    columns = [*range(T, U), ARC_RADIUS, PHI_0, PHI_1]
    circles = rolling.arcs[arcs][:, columns]
    vertices = np.zeros((len(used), 3))
    for end, column in enumerate((PHI_0, PHI_1)):
        phi, at_end = rolling.arcs[arcs, column, None], ends[:, end] >= 0
        out = np.cos(phi) * circles[:, E1 : E1 + 3] + np.sin(phi) * circles[:, E2 : E2 + 3]
        vertices[ends[at_end, end]] = (circles[:, T : T + 3] + circles[:, RADIUS, None] * out)[at_end]
    none = np.full((len(faces), 2), np.nan)
    made = Pieces(
        vertices, circles, ends, np.full(len(arcs), CONTACT_ARC, np.int8), np.stack([arcs, 0 * arcs], axis=1),
        pieces.face_kind[faces], pieces.face_owner[faces], none, np.full(len(faces), -1),
        np.append(0, np.cumsum(n_loops)), np.append(0, np.cumsum(n_edges)), 2 * edges.ravel() + codes % 2,
        pieces.solid[faces], np.zeros(len(faces), np.int64), pieces.n_open,
    )  # fmt: skip
    return made, len(used) - int((ends[:, 0] >= 0).sum()) + 2 * len(faces) - len(loops)


def _ranges(start: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Return `count` numbers from each start on, one range after another."""
    return np.repeat(start - np.cumsum(count) + count, count) + np.arange(count.sum())


def mesh_of_pieces(pieces: Pieces, rolled: Rolled, size: MeshSize, area: float, chi: int) -> Mesh:
    """Triangulate pieces of an area, Å^2, and an Euler characteristic."""
    n: int | None = None
    if size.n_vertices is None and size.density is None:
        step = size.step or GRID_STEP
        if step < FINEST_STEP:
            raise InputError(
                f"{argument('step')} is {step:g} Å; it must be at least {FINEST_STEP:g} Å, which is about "
                f"{VERTICES_PER_STEP / FINEST_STEP**2:.0f} vertices per Å^2."
            )
        density = VERTICES_PER_STEP / step**2
        if density < SURPLUS * (SPACING / WIDEST_SPACING) ** 2:
            n = n_vertices_of(MeshSize(density=density), area)
        density /= SURPLUS
    else:
        n = n_vertices_of(size, area)
        density = n / area
    spacing = min(WIDEST_SPACING, SPACING / math.sqrt(density))
    finest = FINEST * spacing
    while True:
        fine = _closed(pieces, rolled, spacing, chi)
        if fine is None:  # a chord may cross a narrow face
            spacing *= FINER
            if spacing < finest:
                return _between_dots(rolled, size)
            continue
        if n is None or fine.n_vertices >= n:
            return _without_crossing(fine, rolled, spacing, n)
        spacing *= math.sqrt(RESERVE * fine.n_vertices / n)


class _HalfEdges(NamedTuple):
    """Triangles as half-edges, of which some are gone."""

    made: Triangles
    origin: np.ndarray  # (3 F,) int32, see `half_edges`
    twin: np.ndarray  # (3 F,) int32
    dead: np.ndarray  # (F,) bool
    n_vertices: int  # that are left


def _closed(pieces: Pieces, rolled: Rolled, spacing: float, chi: int) -> _HalfEdges | None:
    """Return the triangles of pieces without slivers; None where they do not close, or have another Euler characteristic."""
    made = triangulate(pieces, rolled, spacing) if pieces.n_open == 0 else None
    if made is None:
        return None
    fine = _without_slivers(made, np.zeros(len(made.points), bool))
    return fine if fine and len(made.points) - len(made.triangles) // 2 == chi else None


def _without_slivers(made: Triangles, steep: np.ndarray) -> _HalfEdges | None:
    """Return triangles without slivers; None where they do not close."""
    n, origin = len(made.points), made.triangles.astype(np.int32).ravel()
    twin, dead = twins(origin, n), np.zeros(len(made.triangles), bool)
    if (twin < 0).any():
        return None
    gone = remove_slivers(on_steps(made.points), on_steps(made.normals), origin, twin, dead, steep, n)
    return _HalfEdges(made, origin, twin, dead, n - gone)


def _without_crossing(fine: _HalfEdges, rolled: Rolled, spacing: float, n: int | None) -> Mesh:
    """Reduce triangles to n vertices, if given, so that none passes through another, or tell how many do.

    Where they do, in necks and clefts, no new triangle is tilted in the next attempt.
    """
    steep, best, fewest = np.zeros(len(fine.made.points), bool), None, 0
    for attempt in range(MAX_ATTEMPTS):
        half_edges = _without_slivers(fine.made, steep) if attempt else fine
        assert half_edges is not None  # these triangles close
        try:
            mesh = _reduced(half_edges, rolled, n, steep)
        except InputError:
            if best is None:
                raise
            break  # of so few vertices, none can stay
        crosses = crossing_triangles(mesh.vertices.points, mesh.vertices.normals, mesh.triangles)
        if best is None or crosses.sum() < fewest:
            best, fewest = mesh, int(crosses.sum())
        if fewest == 0:
            return best
        corners = mesh.vertices.points[np.unique(mesh.triangles[crosses])] - rolled.origin
        steep[pairs_within(fine.made.points, corners, 2.0 ** (attempt - 1) * spacing)[1]] = True
    assert best is not None
    log.warning(
        f"mesh: {fewest} of {len(best.triangles):,} triangles pass through others where the surface is a thin film; "
        "ask for more vertices if nothing may."
    )
    return best


def _reduced(fine: _HalfEdges, rolled: Rolled, n: int | None, steep: np.ndarray) -> Mesh:
    """Return the mesh of triangles, which are reduced in place to n vertices if given."""
    made, origin, twin, dead, _ = fine
    unknown = np.zeros(len(made.points))  # areas, which follow from the triangles
    vertices = Surface(made.points + rolled.origin, made.normals, unknown, made.kind, rolled.atom[made.atom])
    if n is None:
        kept, triangles = remaining(origin, dead)
        vertices = vertices.take(kept)
        return build_mesh(vertices.points, vertices.normals, triangles, vertices.kind, vertices.atom)
    points, normals = on_steps(made.points), on_steps(made.normals)
    # A few vertices are left for triangles that are thin then, and the rest of these go after them
    n_spare = min(n + n // SPARE, fine.n_vertices)
    reduce_to(n_spare, points, normals, origin, twin, dead, steep, fine.n_vertices)
    gone = remove_slivers(points, normals, origin, twin, dead, steep, n_spare - n)
    reduce_to(n, points, normals, origin, twin, dead, steep, n_spare - gone)
    remove_slivers(points, normals, origin, twin, dead, steep, 0)
    return mesh_that_is_left(vertices, origin, dead)


def without_centres(rolled: Rolled, left_out: EnclosedCentres) -> Rolled:
    """Return a probe that is rolled only where its centres are not left out, over the same atoms."""
    rolling = rolled.rolling
    arcs, probes = ~left_out.arcs, ~left_out.probes
    pair = rolling.pair[arcs]
    rolling = rolling._replace(
        arcs=rolling.arcs[arcs],
        pair=pair,
        first_arc=np.searchsorted(pair[:, 0], np.arange(len(rolling.first_arc))),
        probes=rolling.probes[probes],
        triple=rolling.triple[probes],
    )
    return rolled._replace(
        rolling=rolling,
        whole=rolled.whole & (left_out.atoms != CLOSED),
        probes=sort_into_grid(rolling.probes, rolled.probe),
        left_out=no_enclosed_centres(rolling),
        cavities="keep",
    )


def _between_dots(rolled: Rolled, size: MeshSize) -> Mesh:
    """Triangulate a surface by a grid around dense dots."""
    from scipy.spatial import cKDTree  # here: it takes long to load

    log.warning(
        "mesh: atoms in special positions leave the pieces of this surface open; its triangles are those of a grid around dots "
        "in their place, and the number of handles is that of the grid"
    )
    dots = RolledFrame(*rolled).surface(DENSITY_BETWEEN)
    build = partial(mesh_of_dense, dots.points, dots.normals)
    made = sized_mesh(build, size)
    nearest = cKDTree(dots.points).query(made.vertices.points)[1]
    return replace(made, vertices=replace(made.vertices, kind=dots.kind[nearest], atom=dots.atom[nearest]))
