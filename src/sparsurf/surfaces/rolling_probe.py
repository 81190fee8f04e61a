"""Positions of a probe sphere that rolls over the atoms (Connolly, J. Appl. Cryst. 16:548, 1983).

The centre of a probe that touches atom k lies on the sphere of radius `reach[k]` = r_k + r_p around it. It is
*accessible* if it lies inside no other such sphere. The accessible centres form patches of those spheres (the probe
touches one atom), arcs (two atoms) and single points, the fixed probes (three atoms). Each gives one kind of dots,
which `dot_placement` places. Lengths in Å, angles in rad.

Frame of an arc between atoms i < j: unit axis u from i to j, e1 = u x y, e2 = e1 x u; a centre is
t + r (cos phi e1 + sin phi e2). On the probe, theta is measured in the plane of probe and axis from the
direction towards the axis, positive towards j.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.grid import PointGrid, columns_around, in_column, sort_into_grid
from sparsurf.surfaces.vectors import (
    Vector,
    add_scaled,
    cross,
    dot,
    doubled,
    point,
    set_point,
    slots,
    squared_distance,
    subtract,
    vector_at,
)

# Columns of a row of `arcs`; the first four hold vectors
T, E1, E2, U, ARC_RADIUS, PHI_0, PHI_1, THETA_I, THETA_J = 0, 3, 6, 9, 12, 13, 14, 15, 16
N_ARC_COLUMNS = 17
UNCUT = -1  # number of parts of a circle that nothing has been cut out of
OPEN, CLOSED, MIXED = 0, 1, 2  # of an atom: where the probes that touch it lie


class RolledAtoms(NamedTuple):
    """Spheres of probe centres around the atoms, and for each the overlapping ones, nearest first."""

    centre: np.ndarray  # (A, 3) float64
    reach: np.ndarray  # (A,) float64, atom + probe radius
    start: np.ndarray  # (A + 1,) int64; the neighbours of i are near[start[i]:start[i + 1]]
    near: np.ndarray  # (M,) int32


class Rolling(NamedTuple):
    """All positions where the probe touches at least two atoms."""

    atoms: RolledAtoms
    grid: PointGrid  # of the atoms; spheres that overlap are at most its side apart
    arcs: np.ndarray  # (B, 17) float64, columns above
    pair: np.ndarray  # (B, 2) int64, i < j, ascending i
    first_arc: np.ndarray  # (A + 1,) int64, arcs whose lower atom is i: first_arc[i]:first_arc[i + 1]
    probes: np.ndarray  # (P, 3) float64, centres of the fixed probes
    triple: np.ndarray  # (P, 3) int64, i < j < k


class EnclosedCentres(NamedTuple):
    """Which centres of a rolling probe lie in cavities."""

    arcs: np.ndarray  # (B,) bool
    probes: np.ndarray  # (P,) bool, fixed ones
    atoms: np.ndarray  # (A,) int8: OPEN, CLOSED, or MIXED where the nearest arc around the atom decides
    order: np.ndarray  # int64; the arcs around atom a are order[first[a]:first[a + 1]]
    first: np.ndarray  # (A + 1,) int64


def roll(
    centre: np.ndarray, reach: np.ndarray, before: Rolling | None = None, place: np.ndarray | None = None
) -> Rolling:
    """Find the arcs and the fixed probes, ordered by atoms and side, of distinct atoms (A, 3) with `reach` (A,), Å.

    Where a probe was rolled over some of the atoms `before`, which are those at `place`, ascending, only the others and the atoms
    that overlap with them are visited: the arcs of two atoms are stored with the lower one, and cut by its neighbours alone.
    """
    n, grid = len(centre), sort_into_grid(centre, 2 * reach.max())
    if before is None or place is None:
        before, place = nothing_rolled(grid), np.empty(0, np.int64)
    old = np.full(n, -1)
    old[place] = np.arange(len(place))
    visited = old < 0
    if len(place):
        _mark_overlapping(centre, reach, grid, np.flatnonzero(visited), visited)
    near = _overlaps(centre, reach, grid, visited, old, place, before.atoms.start, before.atoms.near)
    atoms = RolledAtoms(centre, reach, *near)
    arcs, pair, probes, ends = _arcs(atoms, visited)
    old_pair, old_triple = place[before.pair], place[before.triple]
    arcs_stay, probes_stay = ~visited[old_pair[:, 0]], ~visited[old_triple[:, 0]]
    pair = np.concatenate([old_pair[arcs_stay], pair])
    order = np.argsort(pair[:, 0], kind="stable")
    arcs, pair = np.concatenate([before.arcs[arcs_stay], arcs])[order], pair[order]
    # By atoms and side, whichever arc a probe was found on
    by_position = np.lexsort(ends[:, 3::-1].T)
    triple = np.concatenate([old_triple[probes_stay], ends[by_position][:, [0, 4, 5]]])
    probes = np.concatenate([before.probes[probes_stay], probes[by_position]])
    order = np.argsort(triple[:, 0], kind="stable")
    first_arc = np.searchsorted(pair[:, 0], np.arange(n + 1))
    return Rolling(atoms, grid, arcs, pair, first_arc, probes[order], triple[order])


def nothing_rolled(grid: PointGrid) -> Rolling:
    """Return the arcs and fixed probes of no atoms."""
    atoms = RolledAtoms(np.empty((0, 3)), np.empty(0), np.zeros(1, np.int64), np.empty(0, np.int32))
    pair, triple = np.empty((0, 2), np.int64), np.empty((0, 3), np.int64)
    return Rolling(
        atoms, grid, np.empty((0, N_ARC_COLUMNS)), pair, np.zeros(1, np.int64), np.empty((0, 3)), triple
    )


@njit()
def _mark_overlapping(
    centre: np.ndarray, reach: np.ndarray, grid: PointGrid, new: np.ndarray, marked: np.ndarray
) -> None:
    """Mark the spheres that overlap with new ones."""
    for i in new:
        columns = columns_around(grid.lattice, point(centre, i), grid.lattice.side)
        for c in range(columns.n):
            for q in in_column(grid.start, columns, c):
                k = grid.dot[q]
                if squared_distance(point(centre, k), point(centre, i)) < (reach[i] + reach[k]) ** 2:
                    marked[k] = True


@njit()
def _overlaps(
    centre: np.ndarray,
    reach: np.ndarray,
    grid: PointGrid,
    visited: np.ndarray,
    old: np.ndarray,
    place: np.ndarray,
    old_start: np.ndarray,
    old_near: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Build the neighbour lists `start` and `near` of `RolledAtoms`; those of atoms that are not visited are taken over."""
    n = len(centre)
    start = np.zeros(n + 1, np.int64)
    near, total = np.empty((64 * n, 1), np.int32), 0
    distance = np.empty((256, 1))
    for i in range(n):
        m, columns = 0, columns_around(grid.lattice, point(centre, i), grid.lattice.side)
        for c in range(columns.n if visited[i] else 0):
            for q in in_column(grid.start, columns, c):
                k, d2 = grid.dot[q], squared_distance(point(grid.xyz, q), point(centre, i))
                if k == i or d2 >= (reach[i] + reach[k]) ** 2:
                    continue
                if total + m == len(near):
                    near = doubled(near)
                if m == len(distance):
                    distance = doubled(distance)
                # Nearest first, as `blocker` tries them in this order, and the nearest atoms cover most of a sphere
                p = m
                while p > 0 and distance[p - 1, 0] > d2:
                    distance[p, 0], near[total + p, 0] = distance[p - 1, 0], near[total + p - 1, 0]
                    p -= 1
                distance[p, 0], near[total + p, 0] = d2, k
                m += 1
        if not visited[i]:
            for slot in slots(old_start, old[i]):
                if total + m == len(near):
                    near = doubled(near)
                near[total + m, 0] = place[old_near[slot]]
                m += 1
        total += m
        start[i + 1] = total
    return start, near[:total, 0].copy()


@njit()
def blocker(position: Vector, i: int, atoms: RolledAtoms, guess: int) -> int:
    """Return a neighbour of atom i whose sphere contains the position, or -1; `guess`, an atom or -1, is tried first."""
    if guess >= 0 and squared_distance(point(atoms.centre, guess), position) < atoms.reach[guess] ** 2:
        return guess
    for slot in slots(atoms.start, i):
        k = atoms.near[slot]
        if squared_distance(point(atoms.centre, k), position) < atoms.reach[k] ** 2:
            return k
    return -1


@njit()
def _circle(centre: np.ndarray, reach: np.ndarray, i: int, j: int, row: np.ndarray) -> bool:
    """Write the circle of centres that touch i and j into a row of `arcs`; return False if there is none."""
    u = subtract(point(centre, j), point(centre, i))
    d = math.sqrt(dot(u, u))
    height = (d * d + reach[i] ** 2 - reach[j] ** 2) / (2 * d)
    r2 = reach[i] ** 2 - height * height
    if d <= abs(reach[i] - reach[j]) or r2 <= 0.0:
        return False
    u = (u[0] / d, u[1] / d, u[2] / d)
    flat = math.hypot(u[0], u[2])
    e1 = (-u[2] / flat, 0.0, u[0] / flat) if flat > 0 else (1.0, 0.0, 0.0)
    t, e2 = add_scaled(point(centre, i), height, u), cross(e1, u)
    for a in range(3):
        row[T + a], row[E1 + a], row[E2 + a], row[U + a] = t[a], e1[a], e2[a], u[a]
    row[ARC_RADIUS] = math.sqrt(r2)
    row[THETA_I], row[THETA_J] = math.atan2(-height, row[ARC_RADIUS]), math.atan2(d - height, row[ARC_RADIUS])
    return True


@njit()
def _cutters(row: np.ndarray, i: int, j: int, atoms: RolledAtoms, cutter: np.ndarray) -> int:
    """List the neighbours of i that cut a circle, as slots; return their number, or -1 if one covers the whole circle."""
    n, t, u, radius = 0, vector_at(row, T), vector_at(row, U), row[ARC_RADIUS]
    for slot in slots(atoms.start, i):
        k = atoms.near[slot]
        if k == j:
            continue
        w = subtract(point(atoms.centre, k), t)
        w2 = dot(w, w)
        depth = radius * radius + w2 - atoms.reach[k] ** 2
        if depth * depth < 4 * radius * radius * (w2 - dot(w, u) ** 2):
            cutter[n] = slot
            n += 1
        elif depth < 0:
            return -1
    return n


@njit()
def _longest_list(start: np.ndarray) -> int:
    """Return the length of the longest neighbour list, at least 1."""
    longest = 1
    for i in range(len(start) - 1):
        longest = max(longest, start[i + 1] - start[i])
    return longest


@njit()
def without_covered_circles(atoms: RolledAtoms) -> RolledAtoms:
    """Remove the neighbours whose circle lies inside a third sphere.

    DMS tests contact dots only against the remaining ones. So dots that no probe can touch survive on some buried atoms (6
    of 953 in A1).
    """
    start, near, total = np.zeros(len(atoms.start), np.int64), np.empty(len(atoms.near), np.int32), 0
    cutter, row = np.empty(_longest_list(atoms.start), np.int64), np.empty(N_ARC_COLUMNS)
    for i in range(len(atoms.centre)):
        for slot in slots(atoms.start, i):
            j = atoms.near[slot]
            if not _circle(atoms.centre, atoms.reach, i, j, row) or _cutters(row, i, j, atoms, cutter) >= 0:
                near[total] = j
                total += 1
        start[i + 1] = total
    return RolledAtoms(atoms.centre, atoms.reach, start, near[:total].copy())


@njit()
def cut_out(parts: np.ndarray, m: int, begin: float, half: float, cutter: int, other: np.ndarray) -> int:
    """Cut an interval of phi, `half` wide on each side, out of m parts of a circle, or out of a `UNCUT` one.

    What remains is written to `other`, with the cutters at its ends; return the number of its parts.
    """
    if m == UNCUT:
        other[0, 0], other[0, 1] = begin + 2 * half, begin + 2 * math.pi
        other[0, 2], other[0, 3] = cutter, cutter
        return 1
    left = 0
    for p in range(m):
        low, high = parts[p, 0], parts[p, 1]
        # The covered interval that begins next after low; the previous one may reach into the part
        begin += 2 * math.pi * math.ceil((low - begin) / (2 * math.pi))
        end = begin + 2 * half
        new_low, new_high = max(low, end - 2 * math.pi), min(high, begin)
        if new_high > new_low:
            other[left, 0], other[left, 1] = new_low, new_high
            other[left, 2] = parts[p, 2] if new_low == low else cutter
            other[left, 3] = parts[p, 3] if new_high == high else cutter
            left += 1
        if end < high:
            other[left, 0], other[left, 1] = end, high
            other[left, 2], other[left, 3] = cutter, parts[p, 3]
            left += 1
    return left


@njit()
def _free_parts(
    row: np.ndarray, atoms: RolledAtoms, cutter: np.ndarray, n: int, parts: np.ndarray, other: np.ndarray
) -> np.ndarray:
    """Cut the arcs that n spheres cover out of a circle; rows are low and high phi, and the cutters (slots) that end there."""
    m = UNCUT
    for c in range(n):
        k = atoms.near[cutter[c]]
        w = subtract(point(atoms.centre, k), vector_at(row, T))
        p1, p2 = dot(w, vector_at(row, E1)), dot(w, vector_at(row, E2))
        depth = row[ARC_RADIUS] ** 2 + dot(w, w) - atoms.reach[k] ** 2
        half = math.acos(max(-1.0, min(1.0, depth / (2 * row[ARC_RADIUS] * math.hypot(p1, p2)))))
        left = cut_out(parts, m, math.atan2(p2, p1) - half, half, cutter[c], other)
        parts, other, m = other, parts, left
        if m == 0:
            break
    return parts[:m]


@njit()
def _arcs(atoms: RolledAtoms, visited: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Find the free parts of all circles around visited atoms (A,) bool, and the fixed probes at their ends.

    Returned are arcs, pair, probes and six integers for each probe.

    These are i, the slots of j and k in the neighbour list of i, the side of the plane i j k, j, k.
    """
    start, near = atoms.start, atoms.near
    arcs, pair, n_arcs = np.empty((64, N_ARC_COLUMNS)), np.empty((64, 2), np.int64), 0
    probes, ends, n_probes = np.empty((64, 3)), np.empty((64, 6), np.int64), 0
    longest = _longest_list(start)
    cutter, scratch = np.empty(longest, np.int64), np.empty((2, longest + 1, 4))
    whole, row = np.array([[0.0, 2 * math.pi, -1.0, -1.0]]), np.empty(N_ARC_COLUMNS)
    for i in range(len(start) - 1):
        if not visited[i]:
            continue
        for slot_j in slots(start, i):
            j = near[slot_j]
            if j < i or not _circle(atoms.centre, atoms.reach, i, j, row):
                continue
            n = _cutters(row, i, j, atoms, cutter)
            if n < 0:
                continue
            parts = _free_parts(row, atoms, cutter, n, scratch[0], scratch[1]) if n > 0 else whole
            # In the order in which they begin, from phi = 0
            first = 0
            for p in range(len(parts)):
                shift = 2 * math.pi * math.floor(parts[p, 0] / (2 * math.pi))
                parts[p, 0], parts[p, 1] = parts[p, 0] - shift, parts[p, 1] - shift
                first = p if parts[p, 0] < parts[first, 0] else first
            for turn in range(len(parts)):
                p = (first + turn) % len(parts)
                if n_arcs == len(arcs):
                    arcs, pair = doubled(arcs), doubled(pair)
                for c in range(N_ARC_COLUMNS):  # one by one: numba takes seconds to compile the copy of a row
                    arcs[n_arcs, c] = row[c]
                arcs[n_arcs, PHI_0], arcs[n_arcs, PHI_1] = parts[p, 0], parts[p, 1]
                pair[n_arcs, 0], pair[n_arcs, 1] = i, j
                n_arcs += 1
                for end in range(2):
                    phi, slot_k = parts[p, end], int(parts[p, 2 + end])
                    # A fixed probe ends arcs of three pairs; it is stored for the pair of its two lowest atoms alone
                    if slot_k < 0 or near[slot_k] < j:
                        continue
                    if n_probes == len(probes):
                        probes, ends = doubled(probes), doubled(ends)
                    centre = add_scaled(
                        vector_at(row, T), row[ARC_RADIUS] * math.cos(phi), vector_at(row, E1)
                    )
                    centre = add_scaled(centre, row[ARC_RADIUS] * math.sin(phi), vector_at(row, E2))
                    to_k = subtract(point(atoms.centre, near[slot_k]), vector_at(row, T))
                    side = int(dot(cross(vector_at(row, U), to_k), subtract(centre, vector_at(row, T))) > 0)
                    set_point(probes, n_probes, centre)
                    ends[n_probes, 0], ends[n_probes, 1], ends[n_probes, 2] = i, slot_j, slot_k
                    ends[n_probes, 3], ends[n_probes, 4], ends[n_probes, 5] = side, j, near[slot_k]
                    n_probes += 1
    return arcs[:n_arcs], pair[:n_arcs], probes[:n_probes], ends[:n_probes]


@njit()
def nearest_on_arc(position: Vector, arc: np.ndarray) -> tuple[Vector, bool]:
    """Return the point of the arc's circle that is nearest to a position, and whether it belongs to the arc."""
    w = subtract(position, vector_at(arc, T))
    p1, p2 = dot(w, vector_at(arc, E1)), dot(w, vector_at(arc, E2))
    flat = math.hypot(p1, p2)
    if flat == 0.0:
        return vector_at(arc, T), False
    phi = math.atan2(p2, p1) - arc[PHI_0]
    # equal where phi is 0 but for rounding, on a whole circle
    is_on_arc = phi - 2 * math.pi * math.floor(phi / (2 * math.pi)) <= arc[PHI_1] - arc[PHI_0]
    nearest = add_scaled(vector_at(arc, T), arc[ARC_RADIUS] * p1 / flat, vector_at(arc, E1))
    return add_scaled(nearest, arc[ARC_RADIUS] * p2 / flat, vector_at(arc, E2)), is_on_arc


def arcs_of_atoms(pair: np.ndarray, n_atoms: int) -> tuple[np.ndarray, np.ndarray]:
    """List the arcs around each atom, ascending: those around atom a are arcs[first[a]:first[a + 1]]."""
    atom = pair.T.ravel()
    arcs = np.argsort(atom, kind="stable") % max(len(pair), 1)
    return arcs, np.append(0, np.cumsum(np.bincount(atom, minlength=n_atoms)))


def no_enclosed_centres(rolling: Rolling) -> EnclosedCentres:
    """Return that no centre lies in a cavity, for a surface that keeps the walls of its cavities."""
    n_arcs, n_probes, n_atoms = len(rolling.arcs), len(rolling.probes), len(rolling.atoms.centre)
    states = np.zeros(n_atoms, np.int8)
    return EnclosedCentres(
        np.zeros(n_arcs, bool), np.zeros(n_probes, bool), states, *arcs_of_atoms(rolling.pair, n_atoms)
    )


@njit()
def is_enclosed(position: Vector, atom: int, rolling: Rolling, enclosed: EnclosedCentres) -> bool:
    """Return whether an accessible centre that touches an atom lies in a cavity."""
    if enclosed.atoms[atom] != MIXED:
        return enclosed.atoms[atom] == CLOSED
    return enclosed.arcs[nearest_arc(position, atom, rolling.arcs, enclosed.order, enclosed.first)]


@njit()
def nearest_arc(position: Vector, atom: int, arcs: np.ndarray, order: np.ndarray, first: np.ndarray) -> int:
    """Return the arc around an atom, of `arcs_of_atoms`, that is nearest to a position."""
    nearest, best = -1, np.inf
    for slot in slots(first, atom):
        distance = squared_distance_to_arc(position, arcs[order[slot]])
        if distance < best:
            nearest, best = order[slot], distance
    return nearest


@njit()
def squared_distance_to_arc(position: Vector, arc: np.ndarray) -> float:
    """Return the squared distance between a position and the nearest point of an arc."""
    nearest, is_on_arc = nearest_on_arc(position, arc)
    if is_on_arc:
        return squared_distance(nearest, position)
    first, last = end_of_arc(arc, PHI_0), end_of_arc(arc, PHI_1)
    return min(squared_distance(first, position), squared_distance(last, position))


@njit()
def end_of_arc(arc: np.ndarray, column: int) -> Vector:
    """Return the end of an arc, whose phi stands in a column."""
    end = add_scaled(vector_at(arc, T), arc[ARC_RADIUS] * math.cos(arc[column]), vector_at(arc, E1))
    return add_scaled(end, arc[ARC_RADIUS] * math.sin(arc[column]), vector_at(arc, E2))
