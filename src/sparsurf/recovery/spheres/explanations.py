"""Which inferred atoms explain which dots, and what the dots that none explains say of further atoms.

The inward normal of a dot points from its probe to one atom (contact dot), lies between the directions to two atoms that the
probe touches (saddle) or among those to three (concave). A dot with such atoms is explained. An atom that explains no dot is
removed; where unexplained dots agree on a place, an atom is added.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, build_grid, select_separated
from sparsurf.recovery.spheres.atoms import (
    CANDIDATE_COLUMNS,
    NEIGHBOURS,
    append,
    centres_of_spheres,
    neighbours,
)
from sparsurf.recovery.spheres.votes import SphereModel
from sparsurf.surfaces.grid import columns_around, in_column
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
)

UNEXPLAINED, BY_CONTACT, BY_SADDLE, BY_THREE = 0, 1, 2, 3
MAX_TOUCHED = 12  # atoms of one probe that are tried; in general position a probe touches three
# rad, half of that between the normal of a dot and the direction or plane that explains it: the rounding of a file with four
# decimals turns both by 2e-4, and an error of the tolerance the direction to an atom, about 3 Å away, by a third of it
MIN_ANGLE, ANGLE_PER_TOLERANCE = 1e-3, 1 / 3
# Sine of the angle between two atoms seen from a probe below which their plane is not fixed, and for one that is added
MIN_PLANE, MIN_PLANE_OF_NEW = 0.02, 0.1
MIN_VOLUME, BORDER = 1e-4, -1e-3  # of three directions that span a cone, and of weights on its border
# Of a place, above the three constraints that fix it: one more agrees by chance once in a thousand places
MIN_SURPLUS = 1
ROUNDS_OF_PLACES = (
    3  # of added places: dots that one explains free others from what they need; a fourth adds none
)
MIN_ATOM_DISTANCE = 0.9  # Å, of an added atom from others: shorter than any bond of heavy atoms
SAME_CENTRE = 0.01  # Å, between probe centres that count once
MAX_PROBES_OF_PLACE = 16  # whose positions are compared with one another
REACH_OF_PROBES = (
    7.0  # Å, between probe centres that touch one atom: the diameter of the largest sphere of centres
)
MIN_DISTANCE2_OF_PROBES = (
    0.04  # Å^2, between two probes that fix the angle of the second atom of a saddle dot
)
ANGLE_BEYOND_DOT, MAX_ANGLE_BETWEEN = (
    0.02,
    2.8,
)  # rad, of the second atom beyond the dot, and between both atoms


class Explained(NamedTuple):
    """How each dot is explained, and the atoms that its probe touches."""

    kind: np.ndarray  # (n,) int8, UNEXPLAINED, BY_CONTACT, BY_SADDLE or BY_THREE
    used: np.ndarray  # (A,) int64, dots that each atom explains
    start: np.ndarray  # (n + 1,) int64; the probe of dot i touches the atoms touched[start[i]:start[i + 1]]
    touched: np.ndarray  # int64


class _Witnesses(NamedTuple):
    """The dots that confirm or refuse places of atoms, and how they are explained."""

    grid: PatchIndex  # of the probes
    probes: np.ndarray  # (n, 3)
    normals: np.ndarray  # (n, 3)
    found: Explained
    centres: np.ndarray  # (A, 3), of the atoms that are known
    tolerance: float  # Å, of a touch
    angle: float  # rad, of a normal
    distinct: np.ndarray  # (MAX_PROBES_OF_PLACE, 3), room for the probes of one place


def explain(
    probes: np.ndarray, normals: np.ndarray, centres: np.ndarray, radii: np.ndarray, model: SphereModel
) -> Explained:
    """Explain dots with probe centres (n, 3) and unit normals by atoms (A, 3) with radii (A,), Å."""
    start, touched = touched_atoms(probes, centres, radii + model.probe, 2 * model.tolerance)
    kind, used = np.zeros(len(probes), np.int8), np.zeros(len(centres), np.int64)
    _explain(probes, normals, start, touched, centres, _angle(model), kind, used)
    return Explained(kind, used, start, touched)


def _angle(model: SphereModel) -> float:
    """Return the angle, rad, within which a direction explains a normal: it follows the noise of the positions."""
    return max(MIN_ANGLE, ANGLE_PER_TOLERANCE * model.tolerance)


def completed(
    probes: np.ndarray, normals: np.ndarray, centres: np.ndarray, radii: np.ndarray, model: SphereModel
) -> tuple[np.ndarray, np.ndarray, Explained]:
    """Return the atoms (A, 3) and (A,) that explain dots, those that unexplained dots agree on, and how they explain the dots."""
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    grid = build_grid(probes)
    for _ in range(ROUNDS_OF_PLACES):
        centres, radii, found = _explaining(probes, normals, centres, radii, model)
        unexplained = np.flatnonzero(found.kind == UNEXPLAINED)
        if len(unexplained) < 3 or len(centres) == 0:
            break
        near = neighbours(cKDTree(probes[unexplained]), probes[unexplained], NEIGHBOURS + 1)
        room = np.empty((MAX_PROBES_OF_PLACE, 3))
        witnesses = _Witnesses(
            grid, probes, normals, found, centres, 2 * model.tolerance, 2 * _angle(model), room
        )
        places = _places(unexplained, unexplained[near], witnesses, model.radii, model.probe)
        places = places[np.lexsort((places[:, 3], -places[:, 4]))]
        if len(places):
            places = places[cKDTree(centres).query(places[:, :3])[0] > MIN_ATOM_DISTANCE]
        if len(places) == 0:
            break
        grid_of_places = build_grid(places[:, :3])
        places = places[
            select_separated(grid_of_places, np.arange(len(places)), MIN_ATOM_DISTANCE, len(places), 0)
        ]
        centres, radii = np.concatenate([centres, places[:, :3]]), np.concatenate([radii, places[:, 3]])
    return _explaining(probes, normals, centres, radii, model)


def _explaining(
    probes: np.ndarray, normals: np.ndarray, centres: np.ndarray, radii: np.ndarray, model: SphereModel
) -> tuple[np.ndarray, np.ndarray, Explained]:
    """Return the atoms (A, 3) and (A,) that explain a dot, and how they explain the dots."""
    used = explain(probes, normals, centres, radii, model).used > 0
    centres, radii = centres[used], radii[used]
    return centres, radii, explain(probes, normals, centres, radii, model)


def touched_atoms(
    probes: np.ndarray, centres: np.ndarray, reach: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """List the spheres (A, 3) of radius `reach` (A,), Å, on which each probe centre (n, 3) lies: first slots, and spheres."""
    grid = build_grid(centres)
    start, touched = _touched_atoms(probes, grid, reach[grid.dot], reach.max() + tolerance, tolerance)
    return start, touched


@njit()
def _touched_atoms(
    probes: np.ndarray, grid: PatchIndex, reach: np.ndarray, outer: float, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the lists of `touched_atoms`; `reach` is by position of the grid."""
    start, touched, n = np.zeros(len(probes) + 1, np.int64), np.empty((4 * len(probes) + 64, 1), np.int64), 0
    for i in range(len(probes)):
        centre = point(probes, i)
        columns = columns_around(grid.lattice, centre, outer)
        for c in range(columns.n):
            for q in in_column(grid.start, columns, c):
                d2 = squared_distance(point(grid.xyz, q), centre)
                if d2 < outer * outer and abs(math.sqrt(d2) - reach[q]) < tolerance:
                    touched = touched if n < len(touched) else doubled(touched)
                    touched[n, 0] = grid.dot[q]
                    n += 1
        start[i + 1] = n
    return start, touched[:n, 0].copy()


@njit()
def _unit(v: Vector) -> Vector:
    """Return a vector divided by its length."""
    length = math.sqrt(dot(v, v))
    return v[0] / length, v[1] / length, v[2] / length


@njit()
def _explain(
    probes: np.ndarray,
    normals: np.ndarray,
    start: np.ndarray,
    touched: np.ndarray,
    centres: np.ndarray,
    angle: float,
    kind: np.ndarray,
    used: np.ndarray,
) -> None:
    """Write how each dot is explained, with as few atoms as possible, and count the dots of each atom."""
    directions = np.empty((MAX_TOUCHED, 3))
    for i in range(len(probes)):
        first, m = start[i], min(start[i + 1] - start[i], MAX_TOUCHED)
        inward = (-normals[i, 0], -normals[i, 1], -normals[i, 2])
        nearest, best = 2.0 * angle, -1
        for a in range(m):
            to_atom = _unit(subtract(point(centres, touched[first + a]), point(probes, i)))
            set_point(directions, a, to_atom)
            across = cross(to_atom, inward)
            off = math.sqrt(dot(across, across))
            if off < nearest and dot(to_atom, inward) > 0:
                nearest, best = off, a
        if best >= 0:
            kind[i] = BY_CONTACT
            used[touched[first + best]] += 1
            continue
        nearest, two = 2.0 * angle, -1
        for a in range(m):
            for b in range(a + 1, m):
                off = _off_plane(point(directions, a), point(directions, b), inward, MIN_PLANE)
                if off < nearest:
                    nearest, best, two = off, a, b
        if two >= 0:
            kind[i] = BY_SADDLE
            used[touched[first + best]] += 1
            used[touched[first + two]] += 1
            continue
        for a in range(m):
            for b in range(a + 1, m):
                for c in range(b + 1, m):
                    if kind[i] == UNEXPLAINED and _in_cone(
                        point(directions, a), point(directions, b), point(directions, c), inward
                    ):
                        kind[i] = BY_THREE
                        used[touched[first + a]] += 1
                        used[touched[first + b]] += 1
                        used[touched[first + c]] += 1


@njit()
def _off_plane(a: Vector, b: Vector, inward: Vector, least: float) -> float:
    """Return the angle, rad, by which a direction leaves the plane of two others; infinity if it does not lie between these."""
    across = cross(a, b)
    if dot(across, across) < least * least:
        return np.inf
    across = _unit(across)
    if dot(cross(a, inward), across) <= 0 or dot(cross(inward, b), across) <= 0:
        return np.inf
    return abs(dot(across, inward))


@njit()
def _in_cone(a: Vector, b: Vector, c: Vector, inward: Vector) -> bool:
    """Return whether a direction lies among three others."""
    volume = dot(cross(a, b), c)
    if abs(volume) < MIN_VOLUME:
        return False
    weights = (
        dot(cross(inward, b), c) / volume,
        dot(cross(a, inward), c) / volume,
        dot(cross(a, b), inward) / volume,
    )
    return min(weights) > BORDER


@njit()
def _append_if_confirmed(
    rows: np.ndarray, n: int, place: Vector, radius: float, probe: float, witnesses: _Witnesses
) -> tuple[np.ndarray, int]:
    """Write a place that further dots confirm into row n; return the rows and their number."""
    surplus = _surplus(place, radius + probe, witnesses)
    if surplus < MIN_SURPLUS:
        return rows, n
    return append(rows, n, place, radius, surplus), n + 1


@njit()
def _surplus(place: Vector, reach: float, witnesses: _Witnesses) -> int:
    """Count the constraints of unexplained dots that a place meets beyond three; below 0 also where a probe is inside.

    A probe that touches it is one, the plane of a saddle dot with a known atom another, and the direction of a contact dot two.
    """
    grid, probes, normals, found, centres, tolerance, angle, distinct = witnesses
    outer, total, n = reach + tolerance, 0, 0
    columns = columns_around(grid.lattice, place, outer)
    for c in range(columns.n):
        for q in in_column(grid.start, columns, c):
            d2 = squared_distance(point(grid.xyz, q), place)
            if d2 <= (reach - tolerance) ** 2:
                return -1
            i = grid.dot[q]
            if d2 >= outer**2 or found.kind[i] != UNEXPLAINED:
                continue
            is_new = True
            for e in range(n):
                if squared_distance(point(distinct, e), point(grid.xyz, q)) < SAME_CENTRE**2:
                    is_new = False
            if is_new:
                total += 1
                if n < MAX_PROBES_OF_PLACE:
                    set_point(distinct, n, point(grid.xyz, q))
                    n += 1
            to_place = _unit(subtract(place, point(grid.xyz, q)))
            inward = (-normals[i, 0], -normals[i, 1], -normals[i, 2])
            across = cross(to_place, inward)
            if dot(across, across) < angle**2 and dot(to_place, inward) > 0:
                total += 2
                continue
            for slot in slots(found.start, i):
                to_atom = _unit(subtract(point(centres, found.touched[slot]), point(probes, i)))
                if _off_plane(to_place, to_atom, inward, MIN_PLANE_OF_NEW) < angle:
                    total += 1
                    break
    return total - 3


@njit()
def _places(
    unexplained: np.ndarray,
    near: np.ndarray,
    witnesses: _Witnesses,
    radii: np.ndarray,
    probe: float,
) -> np.ndarray:
    """Return places (m, 5) that unexplained dots fix, by three probes or the plane of a saddle dot, and further ones confirm."""
    probes, normals, found, centres = witnesses.probes, witnesses.normals, witnesses.found, witnesses.centres
    rows, n = np.empty((64, CANDIDATE_COLUMNS)), 0
    for a in range(len(unexplained)):
        i = unexplained[a]
        origin = point(probes, i)
        for e in range(1, near.shape[1]):
            j = near[a, e]
            b = subtract(point(probes, j), origin)
            if dot(b, b) > REACH_OF_PROBES**2:
                break
            for f in range(e + 1, near.shape[1]):
                k = near[a, f]
                c = subtract(point(probes, k), origin)
                if dot(c, c) > REACH_OF_PROBES**2:
                    break
                if j < i and k < i:
                    continue  # tried from one of them
                for r in radii:
                    exist, places = centres_of_spheres(origin, b, c, r + probe)
                    for side in range(2 if exist else 0):
                        rows, n = _append_if_confirmed(rows, n, places[side], r, probe, witnesses)
        for slot in slots(found.start, i):
            e1 = _unit(subtract(point(centres, found.touched[slot]), origin))
            inward = (-normals[i, 0], -normals[i, 1], -normals[i, 2])
            along = dot(inward, e1)
            e2 = add_scaled(inward, -along, e1)
            length = math.sqrt(dot(e2, e2))
            if length < MIN_PLANE:
                continue
            e2 = _unit(e2)
            beyond = math.atan2(length, along) + ANGLE_BEYOND_DOT
            for e in range(1, near.shape[1]):
                v = subtract(point(probes, near[a, e]), origin)
                v2, x, y = dot(v, v), dot(v, e1), dot(v, e2)
                if v2 > REACH_OF_PROBES**2:
                    break
                size = math.sqrt(x * x + y * y)
                if v2 < MIN_DISTANCE2_OF_PROBES:
                    continue
                for r in radii:
                    share = v2 / (2 * (r + probe))
                    if size <= share:
                        continue
                    for sign in range(2):
                        turn = (math.atan2(y, x) + math.acos(share / size) * (1 - 2 * sign)) % (2 * math.pi)
                        if turn <= beyond or turn > MAX_ANGLE_BETWEEN:
                            continue
                        place = add_scaled(origin, (r + probe) * math.cos(turn), e1)
                        place = add_scaled(place, (r + probe) * math.sin(turn), e2)
                        rows, n = _append_if_confirmed(rows, n, place, r, probe, witnesses)
    return rows[:n].copy()
