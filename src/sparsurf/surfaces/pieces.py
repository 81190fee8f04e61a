"""The solvent-excluded surface as a cell complex of its exact pieces: vertices, circular edges, and faces with loops of edges.

Faces are the connected contact pieces of atoms, the saddles along the arcs of the rolled probe, and the connected concave pieces
of fixed probes. A saddle whose torus intersects itself (a spindle) is two faces, which end in apexes on the axis. Concave pieces
cut one another only where two fixed probes overlap: all probes have one radius, so that both pieces end on the circle in which
the plane halfway between the probes cuts them. The sides of a concave piece, towards saddles, are cut nowhere else.

All probes on one circle of centres cut one another in planes through its axis. Of these only neighbours across a gap of the
circle matter; between neighbours that an arc joins, the saddle lies. Fixed probes at one place touch more than three atoms; they
are one face with more sides.

The Euler characteristic of a component is its number of vertices, less that of edges, plus that of faces, less that of holes in
faces. Its curvature (Gauss-Bonnet) follows from the same pieces by areas and angles, and must agree. A third of the flux of the
position through the pieces is the volume. Lengths in Å, areas in Å^2, angles in rad, solid angles in sr.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.dot_placement import Rolled, band_area
from sparsurf.surfaces.grid import PointGrid, columns_around, in_column
from sparsurf.surfaces.rolling_probe import (
    ARC_RADIUS,
    E1,
    E2,
    PHI_0,
    PHI_1,
    THETA_I,
    THETA_J,
    UNCUT,
    Rolling,
    T,
    U,
    arcs_of_atoms,
    blocker,
    cut_out,
    end_of_arc,
)
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE
from sparsurf.surfaces.vectors import (
    POLE,
    Vector,
    add_scaled,
    cone,
    cross,
    dot,
    doubled,
    join_two,
    point,
    scaled,
    set_of_arcs,
    set_point,
    slots,
    squared_distance,
    subtract,
    triangle,
    vector_at,
)

CONTACT_ARC, PROBE_ARC, CUSP_ARC = 0, 1, 2  # kinds of edges
RADIUS, LOW, HIGH = 9, 10, 11  # columns of `circles` after T (the centre), E1 and E2
OPEN_ARC, WHOLE, SHORT = 0, 1, 2  # of an arc: between two places, a whole circle, or within one place
ONE_PLACE = 1e-5  # Å; fixed probes, or ends of cusp arcs, that are nearer to one another are one
AT_END = 1e-4  # Å, between the end of an arc and its fixed probe, which differ by rounding
FAR_OFF = 0.1  # Å, of a point where three probes meet: these lie on one line, but for rounding
SHORT_ARC = 1e-3  # Å, of an arc whose ends are one place; a longer one leads around
DIRECTION = np.array([0.61, 0.53, 0.59])  # a direction along which few points have the same height
WHOLE_SPHERE = 4 * math.pi
NO_SOLID_ANGLE = 1e-3  # sr; so near to a whole sphere, a piece is one, or nothing
NEARLY_ONE = (
    0.999  # of the unit sphere; the caps that cover less than NO_SOLID_ANGLE begin at greater heights
)
TOLERANCE = 1e-3  # of the Euler characteristic, between both ways to compute it
CLOSING = 1e-6  # of the area, by which a closed surface may miss to close


class Pieces(NamedTuple):
    """The faces of an excluded surface, their edges and vertices.

    An edge runs along the circle m + radius (cos phi e1 + sin phi e2) from the phi of its first end to the larger one of its
    second. Loops of contact pieces and saddles are counterclockwise as seen from outside of the molecule, those of concave pieces
    as seen from inside of it, which is outside of the probe. So each edge stands once forwards and once backwards among two faces
    if the loops of concave pieces are read backwards.
    """

    vertices: (
        np.ndarray
    )  # (V, 3) float64, Å, as the centres of rolled atoms; an apex of a whole circle ends no edge
    circles: np.ndarray  # (E, 12) float64, columns above
    ends: np.ndarray  # (E, 2) int64, vertices; -1 of a whole circle
    edge_kind: np.ndarray  # (E,) int8
    edge_owner: (
        np.ndarray
    )  # (E, 2) int64, arc and its atom (0, 1); arc and its end (0, 1); two fixed probes, ascending
    face_kind: np.ndarray  # (F,) int8, kinds of dots
    face_owner: np.ndarray  # (F,) int64, atom, arc, or fixed probe (the first at its place)
    theta: np.ndarray  # (F, 2) float64, of saddles; else NaN
    apex: np.ndarray  # (F,) int64, vertex of half a spindle; else -1
    face_start: (
        np.ndarray
    )  # (F + 1,) int64, loops of each face: the outer one, then its holes; a whole sphere has none
    loop_start: np.ndarray  # (L + 1,) int64, edges of each loop
    loop_edges: np.ndarray  # (D,) int64, twice the edge, and 1 more if it is walked backwards
    solid: np.ndarray  # (F,) float64, sr, of contact and concave pieces; else NaN
    component: np.ndarray  # (F,) int64, numbered from the largest area
    n_open: int  # loops and edges that do not close, which degenerate positions cause; 0 of a closed surface


class ComponentShapes(NamedTuple):
    """What the pieces of each of C components, or other parts of a surface, say exactly."""

    area: np.ndarray  # (C,) float64, Å^2
    volume: np.ndarray  # (C,) float64, Å^3, negative where the molecule surrounds the component
    chi: np.ndarray  # (C,) int64, Euler characteristic, by numbers of vertices, edges, holes and faces
    curvature: np.ndarray  # (C,) float64, the same by areas and angles
    closing: (
        np.ndarray
    )  # (C,) float64, Å^2, length of the sum of the vector areas, which is 0 of a closed surface

    def agree(self) -> bool:
        """Return whether all components close, and both ways to count handles agree."""
        scale = CLOSING * (1 + self.area.max(initial=0.0))
        return bool((np.abs(self.curvature - self.chi) < TOLERANCE).all() and (self.closing < scale).all())


class _Places(NamedTuple):
    """Where the arcs of the probe's centres end, and which arcs end at each place of fixed probes."""

    first: np.ndarray  # (P,) int64, the first fixed probe at the place of each
    at_end: np.ndarray  # (B, 2) int64, that probe at both ends of each arc, or -1
    across: np.ndarray  # (B, 2) int64, the one beyond the gap of the circle
    state: np.ndarray  # (B,) int8, of each arc
    start: np.ndarray  # (P + 1,) int64
    sides: (
        np.ndarray
    )  # (S,) int64, twice the arc, and 1 more for its second end; those of place q from start[q] on


def pieces_of(rolled: Rolled) -> Pieces:
    """Find the pieces of the excluded surface of a probe that is rolled over spheres in their order."""
    rolling, probe = rolled.rolling, rolled.probe
    places = _places(rolling, rolled.probes)
    first, near = _overlapping(rolling, rolled.probes, places, probe)
    owner, circles, is_cut, met = _cusp_arcs(rolling, places, first, near, probe)
    corners, corner = _corners(rolling, places, probe)
    apexes, apex = _apexes(rolling, places.state, probe)
    ends, met = _joined_ends(met, is_cut, apexes)
    length = circles[:, RADIUS] * (circles[:, HIGH] - circles[:, LOW])
    stays = ~is_cut | (ends[:, 0] != ends[:, 1]) | (length > SHORT_ARC)
    vertices = np.concatenate([corners, met])
    cusps = circles[stays], np.where(ends < 0, -1, ends + len(corners))[stays], owner[stays]
    apex = np.where(apex < 0, -1, apex + len(corners))
    edges, of_arc = _edges(rolling, places, corner, apex, probe, *cusps)
    around = arcs_of_atoms(rolling.pair, len(rolling.atoms.centre))
    groups = _groups(rolling, places, *edges[2:], of_arc, apex, around, rolled.whole, probe)
    group, face_start, loop_start, loop_edges, n_open = _faces(rolling, *edges[:2], groups)
    kind, owner, theta, apex = (column[group] for column in groups[:4])
    loops = face_start, loop_start, loop_edges
    solid, area, component, n_lost = _joined_faces(rolling, edges, kind, owner, theta, *loops, probe)
    size = np.bincount(component, area)
    component = np.argsort(np.argsort(-size, kind="stable"))[component]
    return Pieces(vertices, *edges, kind, owner, theta, apex, *loops, solid, component, n_open + n_lost)


def shapes_of(rolled: Rolled, pieces: Pieces, label: np.ndarray | None = None) -> ComponentShapes:
    """Compute what the pieces of a rolled probe say of each component, or of the parts that labels of faces divide."""
    p, label = pieces, pieces.component if label is None else label
    n = int(label.max(initial=-1)) + 1
    faces = p.face_kind, p.face_owner, p.theta, p.apex, p.face_start, p.loop_start, p.loop_edges
    sums = _sums(rolled.rolling, rolled.probe, *p[:4], *faces, p.solid, moments_of(p.circles), label, n)
    area, flux, chi, curvature = sums[:, :4].T
    closing = np.linalg.norm(sums[:, 4:], axis=1)
    return ComponentShapes(area, flux / 3, chi.round().astype(np.int64), curvature / (2 * math.pi), closing)


def moments_of(circles: np.ndarray) -> np.ndarray:
    """Return half of the integral of x cross dx along each edge, (E, 3), Å^2: these sum to the vector area that a loop spans."""
    outward = [
        np.cos(circles[:, k, None]) * circles[:, E1:E2] + np.sin(circles[:, k, None]) * circles[:, E2:RADIUS]
        for k in (LOW, HIGH)
    ]
    radius, turn = circles[:, RADIUS, None], (circles[:, HIGH] - circles[:, LOW])[:, None]
    across = np.cross(circles[:, T:E1], radius * (outward[1] - outward[0]))
    moments: np.ndarray = (across + radius**2 * turn * np.cross(circles[:, E1:E2], circles[:, E2:RADIUS])) / 2
    return moments


def faces_of_edges(pieces: Pieces) -> np.ndarray:
    """Return the faces on the left and the right of each edge, (E, 2), as seen from outside of the molecule."""
    first = pieces.loop_start[pieces.face_start]
    face = np.repeat(np.arange(len(pieces.face_kind)), np.diff(first))
    side = (pieces.loop_edges % 2) ^ (pieces.face_kind[face] == CONCAVE)
    faces = np.full((len(pieces.circles), 2), -1)
    faces[pieces.loop_edges // 2, side] = face
    return faces


def rolled_sets(pieces: Pieces, faces: np.ndarray) -> np.ndarray:
    """Return, for each face, (F,), the set of positions between which the probe rolls: cusp arcs join none."""
    label = np.arange(len(pieces.face_kind))
    for kind in (SADDLE, CONCAVE):  # parts of one saddle, or of one concave piece
        of_kind = np.flatnonzero(pieces.face_kind == kind)
        _, first, number = np.unique(pieces.face_owner[of_kind], return_index=True, return_inverse=True)
        label[of_kind] = of_kind[first[number]]
    rolled = faces[pieces.edge_kind != CUSP_ARC]
    return np.unique(_joined(label, rolled), return_inverse=True)[1]


@njit()
def _joined(label: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Return the set of each face, named by its lowest one, where the pairs of faces are joined as well, unless one is -1."""
    joined = label.copy()
    for k in range(len(pairs)):
        if pairs[k, 0] >= 0 and pairs[k, 1] >= 0:
            join_two(joined, pairs[k, 0], pairs[k, 1])
    return set_of_arcs(joined)


def capped_volumes(
    rolled: Rolled, pieces: Pieces, faces: np.ndarray, label: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the area, Å^2, and the volume, Å^3, of the parts of a surface that the labels of its faces, (F,), divide.

    Two parts that meet on a circle of a cusp are closed there by its flat disc, and on cusps of several arcs by cones over these.
    So the volumes sum to that of the whole surface.
    """
    shapes = shapes_of(rolled, pieces, label)
    volume, border = shapes.volume.copy(), np.flatnonzero(label[faces[:, 0]] != label[faces[:, 1]])
    if len(border):
        circles = pieces.circles[border]
        group = _chained(pieces.ends[border])
        phi = (circles[:, LOW] + circles[:, HIGH])[:, None] / 2
        middle = circles[:, T:E1] + circles[:, RADIUS, None] * (
            np.cos(phi) * circles[:, E1:E2] + np.sin(phi) * circles[:, E2:RADIUS]
        )
        tip = (
            np.stack([np.bincount(group, column) for column in middle.T], axis=1)
            / np.bincount(group)[:, None]
        )
        flux = (tip[group] * moments_of(circles)).sum(axis=1) / 3
        volume += np.bincount(label[faces[border, 1]], flux, len(volume))
        volume -= np.bincount(label[faces[border, 0]], flux, len(volume))
    return shapes.area, volume


def capped_part(pieces: Pieces, faces: np.ndarray, kept: np.ndarray) -> tuple[Pieces, np.ndarray]:
    """Return the pieces of some faces, (F,) bool, and how many borders of each of its components are closed by discs, (C,).

    Where a border is no simple loop, NaN takes the place of the number.
    """
    n_loops, first = np.diff(pieces.face_start), pieces.loop_start[pieces.face_start]
    of_kept = np.repeat(kept, n_loops)
    start = np.append(0, np.cumsum(n_loops[kept]))
    loop_start = np.append(0, np.cumsum(np.diff(pieces.loop_start)[of_kept]))
    edges = pieces.loop_edges[np.repeat(kept, np.diff(first))]
    number = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1)[faces]
    component = np.unique(_joined(np.arange(kept.sum()), number), return_inverse=True)[1]
    part = pieces._replace(
        face_kind=pieces.face_kind[kept],
        face_owner=pieces.face_owner[kept],
        theta=pieces.theta[kept],
        apex=pieces.apex[kept],
        face_start=start,
        loop_start=loop_start,
        loop_edges=edges,
        solid=pieces.solid[kept],
        component=component,
    )
    border = np.flatnonzero((number < 0).any(axis=1) & (number >= 0).any(axis=1))
    ends = pieces.ends[border]
    group = np.unique(_chained(ends), return_index=True)[1]
    n_borders = np.bincount(
        component[number[border[group]].max(axis=1)], minlength=int(component.max(initial=-1)) + 1
    )
    is_simple = (np.unique(ends[ends >= 0], return_counts=True)[1] == 2).all()
    return part, n_borders.astype(float) if is_simple else np.full(len(n_borders), np.nan)


def _chained(ends: np.ndarray) -> np.ndarray:
    """Return the number of the chain of each edge, (n,), of those that share vertices, in the order of their first edges."""
    ended, n = np.flatnonzero(ends[:, 0] >= 0), len(ends)
    vertex = n + np.unique(ends[ended], return_inverse=True)[1].ravel()
    nodes = np.arange(int(vertex.max(initial=n - 1)) + 1)  # the edges, and their vertices
    chain = _joined(nodes, np.stack([np.repeat(ended, 2), vertex], axis=1))[:n]
    return np.unique(chain, return_inverse=True)[1]


def narrowest_handles(pieces: Pieces, faces: np.ndarray, chi: np.ndarray) -> np.ndarray:
    """Return the width of the narrowest cusp around a handle of each component, (C,) Å, or NaN.

    A closed cusp on one concave piece goes around a handle if the surface holds together when it is cut there. The width is the
    diameter of a circle that spans as much area.
    """
    loop_of = np.repeat(np.arange(len(pieces.loop_start) - 1), np.diff(pieces.loop_start))
    first, edges = pieces.loop_start, pieces.loop_edges // 2
    steps = moments_of(pieces.circles)[edges] * (1.0 - 2.0 * (pieces.loop_edges % 2))[:, None]
    spanned = np.stack([np.bincount(loop_of, column, len(first) - 1) for column in steps.T], axis=1)
    n_other = np.bincount(loop_of, pieces.edge_kind[edges] != CUSP_ARC, len(first) - 1)
    width = 2 * np.sqrt(np.linalg.norm(spanned, axis=1) / math.pi)
    component = np.repeat(pieces.component, np.diff(pieces.face_start))
    chosen = np.flatnonzero((n_other == 0) & (chi[component] < 2))
    chosen = chosen[np.argsort(width[chosen], kind="stable")]
    narrowest = np.full(len(chi), np.nan)
    for loop in chosen.tolist():  # few
        cut = edges[first[loop] : first[loop + 1]]
        if np.isnan(narrowest[component[loop]]) and (faces[cut] >= 0).all():
            left, right = faces[cut[0]]
            remaining = faces.copy()
            remaining[cut] = -1
            root = _joined(np.arange(len(pieces.face_kind)), remaining)
            if root[left] == root[right]:
                narrowest[component[loop]] = width[loop]
    return narrowest


@njit()
def _places_of_probes(grid: PointGrid, triple: np.ndarray) -> np.ndarray:
    """Return the first of the fixed probes (P,) at the place of each; two on both sides of one plane are never one."""
    joined = np.arange(len(grid.xyz))
    for slot in range(len(grid.xyz)):
        q, centre = grid.dot[slot], point(grid.xyz, slot)
        columns = columns_around(grid.lattice, centre, ONE_PLACE)
        for c in range(columns.n):
            for other in in_column(grid.start, columns, c):
                p = grid.dot[other]
                is_near = p < q and squared_distance(point(grid.xyz, other), centre) < ONE_PLACE**2
                if is_near and _n_shared(triple, p, q) < 3:
                    join_two(joined, p, q)
    return set_of_arcs(joined)


@njit()
def _n_shared(triple: np.ndarray, q: int, p: int) -> int:
    """Count the atoms that touch two fixed probes."""
    n = 0
    for a in range(3):
        for b in range(3):
            n += triple[q, a] == triple[p, b]
    return n


def _places(rolling: Rolling, grid: PointGrid) -> _Places:
    """Find the places of fixed probes at which arcs end, given the grid of the fixed probes."""
    first = _places_of_probes(grid, rolling.triple)
    at_end, across, state = _ends_of_arcs(rolling.arcs, rolling.pair, grid, first)
    ends = np.flatnonzero((at_end >= 0) & (state == OPEN_ARC)[:, None])
    place = at_end.ravel()[ends]
    start = np.append(0, np.cumsum(np.bincount(place, minlength=len(first))))
    return _Places(first, at_end, across, state, start, ends[np.argsort(place, kind="stable")])


@njit()
def _ends_of_arcs(
    arcs: np.ndarray, pair: np.ndarray, grid: PointGrid, first: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the place at both ends of each arc, that beyond the gaps there, and the state of the arc."""
    n = len(arcs)
    at_end, across, state = np.full((n, 2), -1), np.full((n, 2), -1), np.zeros(n, np.int8)
    for b in range(n):
        turn = arcs[b, PHI_1] - arcs[b, PHI_0]
        if turn == 2 * math.pi:
            state[b] = WHOLE
            continue
        for end in range(2):
            position, nearest = end_of_arc(arcs[b], PHI_0 + end), AT_END**2
            columns = columns_around(grid.lattice, position, AT_END)
            for c in range(columns.n):
                for slot in in_column(grid.start, columns, c):
                    distance = squared_distance(point(grid.xyz, slot), position)
                    if distance < nearest:
                        nearest, at_end[b, end] = distance, first[grid.dot[slot]]
        if at_end[b, 0] == at_end[b, 1] and turn * arcs[b, ARC_RADIUS] < SHORT_ARC:
            state[b] = SHORT
    low = 0
    for b in range(n):  # the arcs of one circle follow one another, in the order of phi
        if b + 1 < n and pair[b + 1, 0] == pair[b, 0] and pair[b + 1, 1] == pair[b, 1]:
            continue
        for this in range(low, b + 1):
            following = this + 1 if this < b else low
            across[this, 1], across[following, 0] = at_end[following, 0], at_end[this, 1]
        low = b + 1
    return at_end, across, state


@njit()
def _overlapping(
    rolling: Rolling, grid: PointGrid, places: _Places, probe: float
) -> tuple[np.ndarray, np.ndarray]:
    """List, for each place, the others whose probes may cut its concave piece: those of q are near[start[q]:start[q + 1]]."""
    n, triple = len(places.first), rolling.triple
    is_low, n_merged = np.zeros(n, np.bool_), np.zeros(n, np.int64)
    for q in range(n):
        # Only a concave piece that reaches beyond the plane of its atoms can be cut
        apex, i = point(rolling.probes, q), point(rolling.atoms.centre, triple[q, 0])
        side = subtract(point(rolling.atoms.centre, triple[q, 1]), i)
        normal = cross(side, subtract(point(rolling.atoms.centre, triple[q, 2]), i))
        if dot(normal, subtract(apex, i)) ** 2 < probe * probe * dot(normal, normal):
            is_low[places.first[q]] = True
        n_merged[places.first[q]] += 1
    start, near, total = np.zeros(n + 1, np.int64), np.empty((4 * n + 16, 1), np.int64), 0
    for q in range(n):
        if is_low[q]:
            apex = point(rolling.probes, q)
            columns = columns_around(grid.lattice, apex, 2 * probe)
            for c in range(columns.n):
                for slot in in_column(grid.start, columns, c):
                    p = grid.dot[slot]
                    if p == q or not is_low[p]:
                        continue
                    if squared_distance(point(grid.xyz, slot), apex) >= 4 * probe * probe:
                        continue
                    # Of the probes on one circle only those across a gap cut one another; many at one place lie on many circles
                    is_simple = n_merged[q] == 1 and n_merged[p] == 1
                    if is_simple and _n_shared(triple, q, p) > 1 and not _is_across(places, q, p):
                        continue
                    if total == len(near):
                        near = doubled(near)
                    near[total, 0] = p
                    total += 1
        start[q + 1] = total
    return start, near[:total, 0].copy()


@njit()
def _is_across(places: _Places, q: int, p: int) -> bool:
    """Return whether the fixed probe p lies across a gap of a circle on which q lies."""
    for slot in slots(places.start, q):
        side = places.sides[slot]
        if places.across[side // 2, side % 2] == p:
            return True
    return False


@njit()
def _cusp_arcs(
    rolling: Rolling, places: _Places, first: np.ndarray, near: np.ndarray, probe: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Find the arcs on which the concave pieces of two places end: both, circles, whether they are cut, and both ends, (n, 6)."""
    owner, circles, n = np.empty((64, 2), np.int64), np.empty((64, 12)), 0
    is_cut, ends = np.empty((64, 1), np.bool_), np.full((64, 6), np.inf)
    caps, parts, other = np.empty((64, 4)), np.empty((65, 4)), np.empty((65, 4))
    for q in range(len(places.first)):
        apex, n_sides, m_near = point(rolling.probes, q), 0, first[q + 1] - first[q]
        if m_near == 0:
            continue
        n_caps = places.start[q + 1] - places.start[q] + m_near
        while n_caps > len(caps):
            caps, parts, other = doubled(caps), doubled(parts), doubled(other)
        for slot in slots(places.start, q):  # beyond a side lies the saddle of the arc that ends there
            arc, end = rolling.arcs[places.sides[slot] // 2], places.sides[slot] % 2
            phi, sign = arc[PHI_0 + end], 1.0 - 2.0 * end
            set_point(caps, n_sides, scaled(sign, _turn(arc, phi)))
            caps[n_sides, 3] = 0.0
            n_sides += 1
        for k in range(m_near):
            towards = subtract(point(rolling.probes, near[first[q] + k]), apex)
            distance = math.sqrt(dot(towards, towards))
            set_point(caps, n_sides + k, scaled(1 / distance, towards))
            caps[n_sides + k, 3] = distance / (2 * probe)
        for k in range(m_near):
            p = near[first[q] + k]
            if p < q:
                continue
            axis, height = point(caps, n_sides + k), caps[n_sides + k, 3]
            flat = math.hypot(axis[0], axis[2])
            e1 = (-axis[2] / flat, 0.0, axis[0] / flat) if flat > 0 else (1.0, 0.0, 0.0)
            e2, m = cross(e1, axis), UNCUT
            for cutter in range(n_caps):
                if cutter == n_sides + k:
                    continue
                # Of a position on the circle: inside the cap where cos(phi - middle) exceeds `limit` / `wide`
                cap = point(caps, cutter)
                p1, p2 = dot(cap, e1), dot(cap, e2)
                wide = math.sqrt(1 - height * height) * math.hypot(p1, p2)
                limit = caps[cutter, 3] - height * dot(cap, axis)
                if limit <= -wide:
                    m = 0
                elif limit < wide:
                    half = math.acos(limit / wide)
                    m = cut_out(parts, m, math.atan2(p2, p1) - half, half, cutter, other)
                    parts, other = other, parts
                if m == 0:
                    break
            for part in range(max(m, 1) if m != 0 else 0):
                if n == len(circles):
                    owner, circles, is_cut, ends = (
                        doubled(owner),
                        doubled(circles),
                        doubled(is_cut),
                        doubled(ends),
                    )
                owner[n, 0], owner[n, 1], is_cut[n, 0] = q, p, m != UNCUT
                middle = add_scaled(apex, height * probe, axis)
                for a in range(3):
                    circles[n, a], circles[n, E1 + a], circles[n, E2 + a] = middle[a], e1[a], e2[a]
                circles[n, RADIUS] = probe * math.sqrt(1 - height * height)
                circles[n, LOW], circles[n, HIGH] = (
                    (parts[part, 0], parts[part, 1]) if m > 0 else (0.0, 2 * math.pi)
                )
                for end in range(2 if m > 0 else 0):
                    cutter, position = int(parts[part, 2 + end]), _on(circles[n], circles[n, LOW + end])
                    if cutter < n_sides:
                        arc = rolling.arcs[places.sides[places.start[q] + cutter] // 2]
                        if _cusp(arc, probe) >= 0:
                            position = _apex(
                                arc, probe, dot(subtract(position, vector_at(arc, T)), vector_at(arc, U))
                            )
                    else:
                        k_place = near[first[q] + cutter - n_sides]
                        position = _where_three_meet(rolling.probes, q, p, k_place, position, probe)
                    for a in range(3):
                        ends[n, 3 * end + a] = position[a]
                n += 1
    return owner[:n], circles[:n], is_cut[:n, 0].copy(), ends[:n]


@njit()
def _apex(arc: np.ndarray, probe: float, side: float) -> Vector:
    """Return the apex of the spindle of an arc towards the higher atom where `side` is positive, else the other one."""
    height = math.copysign(math.sqrt(probe * probe - arc[ARC_RADIUS] ** 2), side)
    return add_scaled(vector_at(arc, T), height, vector_at(arc, U))


@njit()
def _where_three_meet(probes: np.ndarray, q: int, p: int, k: int, position: Vector, probe: float) -> Vector:
    """Return the point near a position where three probes meet, with equal bits from whichever two of them it was found."""
    low, high = min(q, p, k), max(q, p, k)
    origin = point(probes, low)
    a, b = subtract(point(probes, q + p + k - low - high), origin), subtract(point(probes, high), origin)
    normal = cross(a, b)
    n2 = dot(normal, normal)
    middle = add_scaled(scaled(dot(b, b), cross(normal, a)), dot(a, a), cross(b, normal))
    middle = scaled(1 / max(2 * n2, 1e-300), middle)
    height = math.sqrt(max(0.0, probe * probe - dot(middle, middle)) / max(n2, 1e-300))
    side = dot(normal, subtract(position, origin))
    exact = add_scaled(origin, 1.0, add_scaled(middle, math.copysign(height, side), normal))
    return exact if squared_distance(exact, position) < FAR_OFF**2 else position


@njit()
def _on(circle: np.ndarray, phi: float) -> Vector:
    """Return a position on the circle of an edge."""
    position = add_scaled(vector_at(circle, T), circle[RADIUS] * math.cos(phi), vector_at(circle, E1))
    return add_scaled(position, circle[RADIUS] * math.sin(phi), vector_at(circle, E2))


@njit()
def _corners(rolling: Rolling, places: _Places, probe: float) -> tuple[np.ndarray, np.ndarray]:
    """Find the points where fixed probes touch atoms, (n, 3), and number them, (B, 2, 2), by arc, end and atom of its pair."""
    corners, n = np.empty((len(places.sides), 3)), 0
    corner = np.full((len(rolling.arcs), 2, 2), -1)
    for q in range(len(places.first)):
        for slot in slots(places.start, q):
            b, end = places.sides[slot] // 2, places.sides[slot] % 2
            for a in range(2):
                atom = rolling.pair[b, a]
                for before in range(places.start[q], slot):
                    side = places.sides[before]
                    for c in range(2):
                        if rolling.pair[side // 2, c] == atom:
                            corner[b, end, a] = corner[side // 2, side % 2, c]
                if corner[b, end, a] < 0:
                    outward = subtract(point(rolling.probes, q), point(rolling.atoms.centre, atom))
                    share = 1 - probe / rolling.atoms.reach[atom]
                    if n == len(corners):
                        corners = doubled(corners)
                    set_point(corners, n, add_scaled(point(rolling.atoms.centre, atom), share, outward))
                    corner[b, end, a], n = n, n + 1
    return corners[:n], corner


@njit()
def _cusp(arc: np.ndarray, probe: float) -> float:
    """Return the theta at which the saddle of an arc meets the axis, or -1 if it does not."""
    if arc[ARC_RADIUS] >= probe:
        return -1.0
    cusp = math.acos(arc[ARC_RADIUS] / probe)
    return cusp if arc[THETA_I] < -cusp and cusp < arc[THETA_J] else -1.0


@njit()
def _apexes(rolling: Rolling, state: np.ndarray, probe: float) -> tuple[np.ndarray, np.ndarray]:
    """Find the apexes of spindles, (n, 3), and number them by arc and atom, (B, 2), or -1: those of one circle are shared."""
    arcs, pair = rolling.arcs, rolling.pair
    apexes, apex, n = np.empty((2 * len(arcs), 3)), np.full((len(arcs), 2), -1), 0
    previous = -1
    for b in range(len(arcs)):
        if state[b] == SHORT or _cusp(arcs[b], probe) < 0:
            continue
        if previous >= 0 and pair[b, 0] == pair[previous, 0] and pair[b, 1] == pair[previous, 1]:
            apex[b, 0], apex[b, 1] = apex[previous, 0], apex[previous, 1]
        else:
            for a in range(2):
                set_point(apexes, n, _apex(arcs[b], probe, 2.0 * a - 1))
                apex[b, a], n = n, n + 1
        previous = b
    return apexes[:n], apex


def _joined_ends(met: np.ndarray, is_cut: np.ndarray, apexes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a number for each end of cusp arcs, (n, 2), one where several meet and -1 of whole circles, and their points.

    The first points are the apexes, at which cusp arcs may also end.
    """
    n, points = len(apexes), np.concatenate([apexes, met[is_cut].reshape(-1, 3)])
    heights = points @ DIRECTION
    first = _first_at_places(points, heights, np.argsort(heights, kind="stable"))
    stays = first == np.arange(len(points))
    stays[:n] = True
    number = np.cumsum(stays) - 1
    number[n:] = number[first[n:]]
    ends = np.full((len(met), 2), -1)
    ends[is_cut] = number[n:].reshape(-1, 2)
    return ends, points[stays]


@njit()
def _first_at_places(points: np.ndarray, heights: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Return the first of the points (n, 3) at the place of each, given their heights and the order of these."""
    joined = np.arange(len(points))
    for k in range(len(order)):
        before = k - 1
        while before >= 0 and heights[order[k]] - heights[order[before]] < ONE_PLACE:
            if squared_distance(point(points, order[k]), point(points, order[before])) < ONE_PLACE**2:
                join_two(joined, order[k], order[before])
            before -= 1
    return set_of_arcs(joined)


@njit()
def _edges(
    rolling: Rolling,
    places: _Places,
    corner: np.ndarray,
    apex: np.ndarray,
    probe: float,
    cusp_circles: np.ndarray,
    cusp_ends: np.ndarray,
    cusp_owner: np.ndarray,
) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
    """Return circles, ends, kinds and owners of all edges, and the first edge of each arc.

    From the first edge of an arc on, its edges are both contact arcs, those of its first end, and those of its second end: one
    each, or two of a spindle, from the lower atom to the higher one.
    """
    arcs, pair, n_cusps = rolling.arcs, rolling.pair, len(cusp_circles)
    room = 6 * len(arcs) + n_cusps
    circles, ends = np.empty((room, 12)), np.full((room, 2), -1)
    kind, owner, first, n = np.empty(room, np.int8), np.empty((room, 2), np.int64), np.full(len(arcs), -1), 0
    for b in range(len(arcs)):
        if places.state[b] == SHORT:
            continue
        first[b], arc = n, arcs[b]
        for a in range(2):
            atom = pair[b, a]
            share = 1 - probe / rolling.atoms.reach[atom]
            centre = point(rolling.atoms.centre, atom)
            middle = add_scaled(centre, share, subtract(vector_at(arc, T), centre))
            for c in range(3):
                circles[n, T + c], circles[n, E1 + c], circles[n, E2 + c] = (
                    middle[c],
                    arc[E1 + c],
                    arc[E2 + c],
                )
            circles[n, RADIUS], circles[n, LOW], circles[n, HIGH] = (
                share * arc[ARC_RADIUS],
                arc[PHI_0],
                arc[PHI_1],
            )
            ends[n, 0], ends[n, 1], kind[n], owner[n, 0], owner[n, 1] = (
                corner[b, 0, a],
                corner[b, 1, a],
                CONTACT_ARC,
                b,
                a,
            )
            n += 1
        cusp = _cusp(arc, probe)
        for end in range(2 if places.state[b] == OPEN_ARC else 0):
            phi = arc[PHI_0 + end]
            inward = add_scaled(
                scaled(-math.cos(phi), vector_at(arc, E1)), -math.sin(phi), vector_at(arc, E2)
            )
            middle = add_scaled(vector_at(arc, T), -arc[ARC_RADIUS], inward)
            for half in range(1 if cusp < 0 else 2):
                for c in range(3):
                    circles[n, T + c], circles[n, E1 + c], circles[n, E2 + c] = (
                        middle[c],
                        inward[c],
                        arc[U + c],
                    )
                circles[n, RADIUS], circles[n, LOW], circles[n, HIGH] = probe, arc[THETA_I], arc[THETA_J]
                ends[n, 0], ends[n, 1], kind[n] = corner[b, end, 0], corner[b, end, 1], PROBE_ARC
                owner[n, 0], owner[n, 1] = b, end
                if cusp >= 0 and half == 0:
                    circles[n, HIGH], ends[n, 1] = -cusp, apex[b, 0]
                elif cusp >= 0:
                    circles[n, LOW], ends[n, 0] = cusp, apex[b, 1]
                n += 1
    for k in range(n_cusps):
        for c in range(12):
            circles[n, c] = cusp_circles[k, c]
        ends[n, 0], ends[n, 1], kind[n] = cusp_ends[k, 0], cusp_ends[k, 1], CUSP_ARC
        owner[n, 0], owner[n, 1] = cusp_owner[k, 0], cusp_owner[k, 1]
        n += 1
    return (circles[:n], ends[:n], kind[:n], owner[:n]), first


@njit()
def _loops_of(codes: np.ndarray, ends: np.ndarray, first: np.ndarray) -> tuple[int, bool]:
    """Sort directed edges so that loop a is codes[first[a]:first[a + 1]]; return the number of loops and whether all close."""
    n_loops, closes, done, n = 0, True, 0, len(codes)
    first[0] = 0
    while done < n:
        begin, here = ends[codes[done] // 2, codes[done] % 2], ends[codes[done] // 2, 1 - codes[done] % 2]
        done += 1
        while here != begin:
            k = done
            while k < n and ends[codes[k] // 2, codes[k] % 2] != here:
                k += 1
            if k == n:
                closes = False
                break
            codes[done], codes[k] = codes[k], codes[done]
            here = ends[codes[done] // 2, 1 - codes[done] % 2]
            done += 1
        n_loops += 1
        first[n_loops] = done
    return n_loops, closes


@njit()
def _unit(v: Vector) -> Vector:
    """Return the direction of a vector."""
    return scaled(1 / max(math.sqrt(dot(v, v)), 1e-300), v)


@njit()
def _is_left_of(
    a: Vector, codes: np.ndarray, low: int, high: int, circles: np.ndarray, centre: Vector
) -> bool:
    """Return whether a direction lies on the left of the loop codes[low:high], on a sphere around a centre.

    The way to a point of the loop on a great circle crosses the loop so often: only circles meet, so that no arc is sampled.
    """
    edge, back = codes[low] // 2, codes[low] % 2
    phi_there = circles[edge, LOW] + 0.41 * (circles[edge, HIGH] - circles[edge, LOW])
    b = _unit(subtract(_on(circles[edge], phi_there), centre))
    across = cross(a, b)
    is_left = (dot(cross(b, _turn(circles[edge], phi_there)), cross(across, b)) < 0) != (back == 1)
    for k in range(low, high):
        circle = circles[codes[k] // 2]
        p1, p2 = dot(across, vector_at(circle, E1)), dot(across, vector_at(circle, E2))
        wide, depth = (
            circle[RADIUS] * math.hypot(p1, p2),
            -dot(across, subtract(vector_at(circle, T), centre)),
        )
        if abs(depth) >= wide:
            continue
        middle, half = math.atan2(p2, p1), math.acos(depth / wide)
        for side in range(2):
            phi = middle + (2 * side - 1) * half - circle[LOW]
            phi = circle[LOW] + phi - 2 * math.pi * math.floor(phi / (2 * math.pi))
            if phi > circle[HIGH]:
                continue
            met = subtract(_on(circle, phi), centre)
            is_target = k == low and abs(phi - phi_there) < 1e-7
            if not is_target and dot(cross(a, met), across) > 0 and dot(cross(met, b), across) > 0:
                is_left = not is_left
    return is_left


@njit()
def _height_of_cap(circle: np.ndarray, back: int, centre: Vector) -> float:
    """Return the height over the centre of a sphere, Å, beyond which the cap on the right of a directed edge lies."""
    axis = cross(vector_at(circle, E1), vector_at(circle, E2))
    return (2 * back - 1) * dot(axis, subtract(vector_at(circle, T), centre))


@njit()
def _outer_loop(
    kind: int,
    region: np.ndarray,
    f: int,
    first: np.ndarray,
    codes: np.ndarray,
    circles: np.ndarray,
    centre: Vector,
    outside: Vector,
) -> int:
    """Return the loop of region f behind which its projection begins: at the axis of the widest cap, or at `outside`."""
    outer, least = f, np.inf
    for a in range(len(region)):
        if region[a] != f:
            continue
        for k in range(first[a], first[a + 1]):
            height = _height_of_cap(circles[codes[k] // 2], codes[k] % 2, centre)
            if kind == CONTACT and height < least:
                outer, least = a, height
        if kind == CONCAVE and not _is_left_of(outside, codes, first[a], first[a + 1], circles, centre):
            outer = a
    return outer


@njit()
def _regions(
    codes: np.ndarray, first: np.ndarray, n_loops: int, circles: np.ndarray, centre: Vector
) -> np.ndarray:
    """Return the first loop of the connected region that each loop on a sphere bounds; loop a is codes[first[a]:first[a + 1]].

    Two loops bound one region if they lie on the same side of every loop.
    """
    region = np.arange(n_loops)
    left = np.ones((n_loops, n_loops), np.bool_)
    for a in range(n_loops if n_loops > 1 else 0):
        # from a cusp arc, which have the highest numbers, if there is one: many sides may lie on one great circle
        highest = codes[first[a]]
        for k in range(first[a], first[a + 1]):
            highest = max(highest, codes[k])
        circle = circles[highest // 2]
        start = _unit(subtract(_on(circle, circle[LOW] + 0.37 * (circle[HIGH] - circle[LOW])), centre))
        for b in range(n_loops):
            left[a, b] = a == b or _is_left_of(start, codes, first[b], first[b + 1], circles, centre)
        for b in range(a):
            n_same = 0
            for c in range(n_loops):
                n_same += left[a, c] == left[b, c]
            if n_same == n_loops:
                region[a] = region[b]
                break
    return region


@njit()
def _groups(
    rolling: Rolling,
    places: _Places,
    edge_kind: np.ndarray,
    edge_owner: np.ndarray,
    first_edge: np.ndarray,
    apex: np.ndarray,
    around: tuple[np.ndarray, np.ndarray],
    whole: np.ndarray,
    probe: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """List the directed edges around each atom, saddle and place: kind, owner, theta, apex, start and edges of each group."""
    order, first = around
    n_atoms, n_arcs, n_places = len(first) - 1, len(rolling.arcs), len(places.first)
    room = n_atoms + 2 * n_arcs + n_places
    kind, owner, apexes = np.empty(room, np.int8), np.empty(room, np.int64), np.full(room, -1)
    theta, start, codes = (
        np.full((room, 2), np.nan),
        np.zeros(room + 1, np.int64),
        np.empty(2 * len(edge_kind), np.int64),
    )
    n, total = 0, 0
    for atom in range(n_atoms):
        for slot in slots(first, atom):
            b = order[slot]
            side = int(rolling.pair[b, 1] == atom)
            if first_edge[b] >= 0:
                codes[total], total = 2 * (first_edge[b] + side) + side, total + 1
        if total == start[n]:
            top = add_scaled(point(rolling.atoms.centre, atom), rolling.atoms.reach[atom], POLE)
            if not whole[atom] or blocker(top, atom, rolling.atoms, -1) >= 0:
                continue
        kind[n], owner[n], start[n + 1] = CONTACT, atom, total
        n += 1
    for b in range(n_arcs):
        e, low, high, cusp = (
            first_edge[b],
            rolling.arcs[b, THETA_I],
            rolling.arcs[b, THETA_J],
            _cusp(rolling.arcs[b], probe),
        )
        if e < 0:
            continue
        n_halves = 1 if cusp < 0 else 2
        for half in range(n_halves):
            kind[n], owner[n], theta[n, 0], theta[n, 1] = SADDLE, b, low, high
            if cusp >= 0:
                theta[n, 1 - half], apexes[n] = cusp if half else -cusp, apex[b, half]
            for side in range(
                2
            ):  # the contact arcs, that of the lower atom backwards, and the sides at both ends
                if cusp < 0 or side == half:
                    codes[total], total = 2 * (e + side) + 1 - side, total + 1
                if places.state[b] == OPEN_ARC:
                    codes[total], total = 2 * (e + 2 + n_halves * side + half) + side, total + 1
            start[n + 1], n = total, n + 1
    cusps, first_cusp = _cusps_of_places(edge_kind, edge_owner, n_places)
    for q in range(n_places):
        if places.first[q] != q:
            continue
        for slot in slots(places.start, q):
            b, end = places.sides[slot] // 2, places.sides[slot] % 2
            n_halves = 1 if _cusp(rolling.arcs[b], probe) < 0 else 2
            for half in range(n_halves):
                codes[total], total = 2 * (first_edge[b] + 2 + n_halves * end + half) + end, total + 1
        for slot in slots(first_cusp, q):
            codes[total], total = cusps[slot], total + 1
        kind[n], owner[n], start[n + 1] = CONCAVE, q, total
        n += 1
    return kind[:n], owner[:n], theta[:n], apexes[:n], start[: n + 1], codes[:total]


@njit()
def _faces(
    rolling: Rolling,
    circles: np.ndarray,
    ends: np.ndarray,
    groups: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]:
    """Divide the groups into connected faces: their groups, loops and edges, and the number of loops that do not close."""
    kind, owner, _, _, start, codes = groups
    room = len(codes) + len(kind)
    group, face_start, n = np.empty(room, np.int64), np.zeros(room + 1, np.int64), 0
    loop_start, loop_edges, n_loops = np.zeros(len(codes) + 1, np.int64), np.empty_like(codes), 0
    first, done, n_open = np.empty(len(codes) + 1, np.int64), 0, 0
    for g in range(len(kind)):
        mine = codes[start[g] : start[g + 1]]
        n_mine, closes = _loops_of(mine, ends, first)
        n_open += not closes
        centre = point(
            rolling.atoms.centre if kind[g] == CONTACT else rolling.probes,
            0 if kind[g] == SADDLE else owner[g],
        )
        region = _regions(mine, first, n_mine if kind[g] != SADDLE else 1, circles, centre)
        for f in range(max(n_mine, 1)):
            if kind[g] != SADDLE and n_mine and region[f] != f:
                continue
            outer = f
            if kind[g] != SADDLE and n_mine > 1:
                outside = _away_from_atoms(rolling, owner[g]) if kind[g] == CONCAVE else centre
                outer = _outer_loop(kind[g], region, f, first, mine, circles, centre, outside)
            for turn in range(n_mine + 1 if n_mine else 0):
                loop = outer if turn == 0 else turn - 1
                if turn > 0 and (loop == outer or (kind[g] != SADDLE and region[loop] != f)):
                    continue
                for k in range(first[loop], first[loop + 1]):
                    loop_edges[done], done = mine[k], done + 1
                n_loops += 1
                loop_start[n_loops] = done
            group[n], face_start[n + 1] = g, n_loops
            n += 1
            if kind[g] == SADDLE:
                break
    return group[:n], face_start[: n + 1], loop_start[: n_loops + 1], loop_edges[:done], n_open


@njit()
def _away_from_atoms(rolling: Rolling, q: int) -> Vector:
    """Return the direction from a fixed probe away from its atoms."""
    away = (0.0, 0.0, 0.0)
    for a in range(3):
        towards = subtract(point(rolling.atoms.centre, rolling.triple[q, a]), point(rolling.probes, q))
        away = add_scaled(away, -1 / rolling.atoms.reach[rolling.triple[q, a]], towards)
    return _unit(away)


@njit()
def _cusps_of_places(kind: np.ndarray, owner: np.ndarray, n_places: int) -> tuple[np.ndarray, np.ndarray]:
    """List the directed cusp arcs of each place, forwards at the first of two fixed probes, and the first of each place."""
    start = np.zeros(n_places + 1, np.int64)
    for e in range(len(kind)):
        for side in range(2 if kind[e] == CUSP_ARC else 0):
            start[owner[e, side] + 1] += 1
    for q in range(n_places):
        start[q + 1] += start[q]
    cusps, fill = np.empty(start[n_places], np.int64), start[:-1].copy()
    for e in range(len(kind)):
        for side in range(2 if kind[e] == CUSP_ARC else 0):
            q = owner[e, side]
            cusps[fill[q]] = 2 * e + side
            fill[q] += 1
    return cusps, start


@njit()
def _cone_of(circle: np.ndarray, is_back: bool, centre: Vector, radius: float, is_great: bool) -> float:
    """Return the signed area between the pole and a directed edge of a piece of a sphere, on the unit sphere."""
    e1, e2 = vector_at(circle, E1), vector_at(circle, E2)
    if is_great:  # also where the probe is a point
        first, last = circle[HIGH if is_back else LOW], circle[LOW if is_back else HIGH]
        a = add_scaled(scaled(math.cos(first), e1), math.sin(first), e2)
        b = add_scaled(scaled(math.cos(last), e1), math.sin(last), e2)
        return triangle(POLE, a, b)
    axis = cross(e1, e2)
    height = dot(axis, subtract(vector_at(circle, T), centre)) / radius
    if is_back:
        return cone(axis, height, e1, scaled(-1.0, e2), -circle[HIGH], -circle[LOW])
    return cone(scaled(-1.0, axis), -height, e1, e2, circle[LOW], circle[HIGH])


@njit()
def _joined_faces(
    rolling: Rolling,
    edges: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    face_kind: np.ndarray,
    face_owner: np.ndarray,
    theta: np.ndarray,
    face_start: np.ndarray,
    loop_start: np.ndarray,
    loop_edges: np.ndarray,
    probe: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Return the solid angle, area and component of each face, and how many edges are not once in each sense in two faces."""
    circles, kind = edges[0], edges[2]
    n = len(face_kind)
    solid, area = np.full(n, np.nan), np.empty(n)
    faces = np.full((len(circles), 2), -1)
    n_lost = 0
    for f in range(n):
        arc, total = rolling.arcs[face_owner[f] if face_kind[f] == SADDLE else 0], 0.0
        is_contact = face_kind[f] == CONTACT
        centre = point(
            rolling.atoms.centre if is_contact else rolling.probes,
            0 if face_kind[f] == SADDLE else face_owner[f],
        )
        radius = rolling.atoms.reach[face_owner[f]] - probe if is_contact else probe
        least = 1.0  # height of the largest cap
        for k in range(loop_start[face_start[f]], loop_start[face_start[f + 1]]):
            edge, back = loop_edges[k] // 2, loop_edges[k] % 2
            side = 1 - back if face_kind[f] == CONCAVE else back
            n_lost += faces[edge, side] >= 0
            faces[edge, side] = f
            if face_kind[f] != SADDLE:
                total += _cone_of(circles[edge], back == 1, centre, radius, kind[edge] == PROBE_ARC)
                height = _height_of_cap(circles[edge], back, centre)
                least = min(least, height / radius if is_contact else 0.0)
        if face_kind[f] == SADDLE:
            area[f] = band_area(arc[ARC_RADIUS], probe, arc[PHI_1] - arc[PHI_0], theta[f, 0], theta[f, 1])
        else:
            total -= WHOLE_SPHERE * math.floor(total / WHOLE_SPHERE)
            if face_start[f + 1] == face_start[f]:
                total = WHOLE_SPHERE
            elif WHOLE_SPHERE - total < NO_SOLID_ANGLE and least < NEARLY_ONE:
                total = 0.0
            solid[f], area[f] = total, total * radius * radius
    for edge in range(len(circles)):
        n_lost += min(faces[edge, 0], faces[edge, 1]) < 0
    component, number, n_components = _joined(np.arange(n), faces), np.empty(n, np.int64), 0
    for f in range(n):
        if component[f] == f:
            number[f], n_components = n_components, n_components + 1
        component[f] = number[component[f]]
    return solid, area, component, n_lost


@njit()
def _turn(circle: np.ndarray, phi: float) -> Vector:
    """Return the direction of a circle in the sense of phi."""
    return add_scaled(scaled(-math.sin(phi), vector_at(circle, E1)), math.cos(phi), vector_at(circle, E2))


@njit()
def _sums(
    rolling: Rolling,
    probe: float,
    vertices: np.ndarray,
    circles: np.ndarray,
    ends: np.ndarray,
    edge_kind: np.ndarray,
    face_kind: np.ndarray,
    face_owner: np.ndarray,
    theta: np.ndarray,
    apex: np.ndarray,
    face_start: np.ndarray,
    loop_start: np.ndarray,
    loop_edges: np.ndarray,
    solid: np.ndarray,
    moments: np.ndarray,
    component: np.ndarray,
    n_components: int,
) -> np.ndarray:
    """Sum over the pieces of each component: area, three volumes, chi, curvature and vector area, (n, 7)."""
    sums = np.zeros((n_components, 7))
    seen, is_smooth = np.zeros(len(vertices), np.bool_), np.zeros(len(vertices), np.bool_)
    counted = np.zeros(len(circles), np.bool_)
    for e in range(len(circles)):
        if edge_kind[e] == CONTACT_ARC and ends[e, 0] >= 0:
            is_smooth[ends[e, 0]], is_smooth[ends[e, 1]] = True, True
    for f in range(len(face_kind)):
        row, n_loops, v = sums[component[f]], face_start[f + 1] - face_start[f], (0.0, 0.0, 0.0)
        row[2] += 2 - n_loops
        if face_kind[f] == SADDLE:
            centre, radius = vector_at(rolling.arcs[face_owner[f]], T), probe
        elif face_kind[f] == CONTACT:
            centre = point(rolling.atoms.centre, face_owner[f])
            radius = rolling.atoms.reach[face_owner[f]] - probe
        else:
            centre, radius = point(rolling.probes, face_owner[f]), probe
        for loop in range(face_start[f], face_start[f + 1]):
            low, high = loop_start[loop], loop_start[loop + 1]
            for k in range(low, high):
                e, back = loop_edges[k] // 2, loop_edges[k] % 2
                v = add_scaled(v, 1.0 - 2.0 * back, point(moments, e))
                if ends[e, 0] >= 0:
                    row[2] -= 0.0 if counted[e] else 1.0
                    counted[e] = True
                    for end in range(2):
                        vertex = ends[e, end]
                        if not seen[vertex]:
                            seen[vertex] = True
                            row[2] += 1
                            row[3] += 0.0 if is_smooth[vertex] else 2 * math.pi
                if face_kind[f] != CONCAVE:
                    continue
                circle = circles[e]
                if edge_kind[e] == CUSP_ARC:  # both pieces meet there at an angle
                    axis = cross(vector_at(circle, E1), vector_at(circle, E2))
                    height = abs(dot(axis, subtract(vector_at(circle, T), centre)))
                    row[3] -= height / radius * (circle[HIGH] - circle[LOW])
                vertex = ends[e, 1 - back]
                if vertex >= 0 and not is_smooth[vertex]:
                    code = loop_edges[k + 1 if k + 1 < high else low]
                    after = circles[code // 2]
                    a = scaled(1.0 - 2.0 * back, _turn(circle, circle[LOW if back else HIGH]))
                    b = scaled(1.0 - 2.0 * (code % 2), _turn(after, after[HIGH if code % 2 else LOW]))
                    outward = scaled(1 / probe, subtract(point(vertices, vertex), centre))
                    row[3] -= math.pi - math.atan2(dot(outward, cross(a, b)), dot(a, b))
        if face_kind[f] == SADDLE:
            arc, low, high = rolling.arcs[face_owner[f]], theta[f, 0], theta[f, 1]
            turn, wide = arc[PHI_1] - arc[PHI_0], arc[ARC_RADIUS]
            row[0] += band_area(wide, probe, turn, low, high)
            row[1] += turn * probe * (_band_flux(wide, probe, high) - _band_flux(wide, probe, low)) + dot(
                centre, v
            )
            row[3] -= turn * (math.sin(high) - math.sin(low))
            if apex[f] >= 0:
                row[3] -= turn * math.sqrt(max(0.0, 1 - (wide / probe) ** 2))
                row[3] += 0.0 if seen[apex[f]] else 2 * math.pi  # an apex that ends no edge
        else:
            sign = 1.0 if face_kind[f] == CONTACT else -1.0
            v = scaled(sign, v)
            row[0] += solid[f] * radius * radius
            row[1] += sign * solid[f] * radius**3 + dot(centre, v)
            row[3] += solid[f]
        for c in range(3):
            row[4 + c] += v[c]
    return sums


@njit()
def _band_flux(wide: float, probe: float, theta: float) -> float:
    """Return the integral over theta of the flux through a saddle, per turn and probe, from the centre of its circle."""
    linear = 1.5 * theta + math.sin(2 * theta) / 4
    return (wide * wide + probe * probe) * math.sin(theta) - wide * probe * linear
