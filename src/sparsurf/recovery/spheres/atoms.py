"""Infer the atoms of a surface from few of its dots, by trilateration from their probe centres.

An atom of radius r is the centre of a sphere of radius r + probe that passes through probe centres and holds none inside. Its
centre follows from one contact dot, from three probe centres, or from one known atom and the normal of a saddle dot.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, build_grid, select_separated
from sparsurf.recovery.spheres.votes import CLOSE, SphereModel
from sparsurf.surfaces.grid import columns_around, in_column
from sparsurf.surfaces.vectors import (
    Vector,
    add_scaled,
    cross,
    dot,
    doubled,
    point,
    scaled,
    set_point,
    squared_distance,
    subtract,
)
from sparsurf.threads import parallel_map

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

# Å; of two candidates this close, the one that more probes touch stays: shorter than any bond, even of hydrogens
SAME_ATOM = 0.7
# Of a probe centre, itself included, among which triples are tried. Their number grows with the square; from 10 to 30 neighbours
# infer the same atoms up to one in 700.
NEIGHBOURS = 14
# Probe centres that are tried with a saddle dot and one atom; 10 find 1 % fewer atoms, and 40 no more
NEIGHBOURS_OF_SADDLE = 25
# Å^4 and Å^2: three centres in one line, or in one plane with the atom, fix no sphere
MIN_TRIPLE, MIN_HEIGHT2 = 0.05, 0.01
# Probes that must touch an atom, of which a contact dot and a triple fix one and three
TOUCHES_OF_CONTACT, TOUCHES_OF_TRIPLE, TOUCHES_OF_SADDLE = 2, 5, 3
STEPS, MIN_TOUCHES, MAX_STEP = 3, 4, 0.05  # of least squares; a step is at most so long, Å
DAMPING = 1e-6  # relative to the trace: directions that no touch fixes do not move
# An atom that is found from a saddle dot helps to find the next. With evenly spread dots, 17 to 22 % of the atoms are found so,
# nine tenths of these in the first round; a fourth finds none.
ROUNDS_OF_SADDLES = 3
# Of a saddle dot, in the plane of its probe and both atoms: shortest component (Å) of the unit normal across the direction to the
# first atom, shortest squared distance (Å^2) to another probe, angle (radians) by which the second atom lies beyond the dot, and
# the largest angle between both atoms. Nearer probes, or atoms nearly opposite, fix the angle of the second atom poorly.
MIN_ACROSS, MIN_PROBE_DISTANCE2, BEYOND_DOT, MAX_ANGLE = 0.05, 0.09, 0.02, 2.6
MAX_DISTANCE_OF_TOUCH = 0.02  # Å, beyond which a probe cannot touch
PROBES_PER_TASK = 256
CANDIDATE_COLUMNS = 5  # of a candidate: position, radius, touches beyond those that fix it


class Atoms(NamedTuple):
    """Atoms that were inferred from dots.

    Attributes
    ----------
    centres : (A, 3) float64, Å
    radii : (A,) float64, Å
    touches : (A,) int64, number of distinct probes of the dots that touch each atom
    """

    centres: NDArray[np.float64]
    radii: NDArray[np.float64]
    touches: np.ndarray


def infer(points: np.ndarray, normals: np.ndarray, model: SphereModel, threads: int = 1) -> Atoms:
    """Infer the atoms that the probes of dots (n, 3) touch."""
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    probe, tolerance = model.probe, model.tolerance
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)  # those of a file are rounded
    all_probes = points + probe * normals
    kept = select_separated(build_grid(all_probes), np.arange(len(points)), 2 * tolerance, len(points), 0)
    probes = build_grid(all_probes[kept])
    rows = []
    for radius in model.radii:
        centres = points - radius * normals
        touched = _touches(probes, centres, np.full(len(centres), radius + probe), tolerance)
        rows.append(np.column_stack([centres, np.full(len(centres), radius), touched - 1.0]))
        rows[-1] = rows[-1][touched >= TOUCHES_OF_CONTACT]
    spread = kept[select_separated(build_grid(points[kept]), np.arange(len(kept)), CLOSE, len(kept), 0)]
    seeds = np.ascontiguousarray(all_probes[spread])
    near = neighbours(cKDTree(seeds), seeds, NEIGHBOURS)
    rows += parallel_map(
        lambda begin, end: _spheres_of_triples(
            probes, seeds, near, begin, end, model.radii, probe, tolerance
        ),
        len(seeds),
        threads,
        PROBES_PER_TASK,
    )
    atoms = _best_supported(np.concatenate(rows))
    _refine(probes, atoms, probe, tolerance)
    if len(atoms):
        near = neighbours(cKDTree(probes.xyz), all_probes, NEIGHBOURS_OF_SADDLE)
        for _ in range(ROUNDS_OF_SADDLES):
            grid = build_grid(atoms[:, :3])
            radii_of_grid = np.ascontiguousarray(atoms[grid.dot, 3])
            candidates = _second_atoms(
                probes, near, all_probes, normals, grid, radii_of_grid, model.radii, probe, tolerance
            )
            if len(candidates) == 0:
                break
            atoms = np.concatenate([atoms, _best_supported(candidates)])
    centres, radii = atoms[:, :3].copy(), atoms[:, 3].copy()
    return Atoms(centres, radii, np.maximum(_touches(probes, centres, radii + probe, 2 * tolerance), 0))


def neighbours(tree: cKDTree, points: np.ndarray, n: int) -> np.ndarray:
    """Return the nearest points of a tree, at most n, (m, k) int32."""
    near = tree.query(points, k=min(n, tree.n))[1]
    return np.asarray(near, np.int32).reshape(len(points), -1)


def _best_supported(rows: np.ndarray) -> np.ndarray:
    """Return the candidates (m, 5) of which none is near a better one, those with most touches first."""
    if len(rows) == 0:
        return rows
    order = np.lexsort((rows[:, 3], -rows[:, 4]))
    chosen = select_separated(build_grid(rows[:, :3]), order, SAME_ATOM, len(rows), 0)
    return rows[chosen]


@njit()
def _touching(probes: PatchIndex, centre: Vector, reach: float, tolerance: float) -> int:
    """Count the probe centres at the distance `reach` from a centre, up to the tolerance; -1 if one is nearer."""
    outer, inner2, outer2, n = reach + tolerance, (reach - tolerance) ** 2, (reach + tolerance) ** 2, 0
    columns = columns_around(probes.lattice, centre, outer)
    for c in range(columns.n):
        for q in in_column(probes.start, columns, c):
            d2 = squared_distance(point(probes.xyz, q), centre)
            if d2 <= inner2:
                return -1
            n += 1 if d2 <= outer2 else 0
    return n


@njit()
def _touches(probes: PatchIndex, centres: np.ndarray, reach: np.ndarray, tolerance: float) -> np.ndarray:
    """Return `_touching` of centres (m, 3) and distances (m,)."""
    out = np.empty(len(centres), np.int64)
    for i in range(len(centres)):
        out[i] = _touching(probes, point(centres, i), reach[i], tolerance)
    return out


@njit()
def append(rows: np.ndarray, n: int, centre: Vector, radius: float, touches: int) -> np.ndarray:
    """Write a candidate into row n, of a longer array where there is no such row."""
    if n == len(rows):
        rows = doubled(rows)
    set_point(rows, n, centre)
    rows[n, 3], rows[n, 4] = radius, touches
    return rows


@njit()
def _lists_pair(near: np.ndarray, i: int, j: int, k: int) -> bool:
    """Return whether j and k are both among the neighbours of probe i."""
    found = 0
    for e in range(1, near.shape[1]):
        found += 1 if (near[i, e] == j) | (near[i, e] == k) else 0
    return found == 2


@njit()
def centres_of_spheres(
    origin: Vector, b: Vector, c: Vector, radius: float
) -> tuple[bool, tuple[Vector, Vector]]:
    """Return the centres of the two spheres through a point and two others, b and c away from it; False if there are none."""
    w = cross(b, c)
    w2 = dot(w, w)
    if w2 <= MIN_TRIPLE:
        return False, (origin, origin)
    middle = scaled(dot(c, c) / (2 * w2), cross(w, b))
    middle = add_scaled(middle, dot(b, b) / (2 * w2), cross(c, w))
    height2 = radius**2 - dot(middle, middle)
    if height2 <= MIN_HEIGHT2:
        return False, (origin, origin)
    up, middle = math.sqrt(height2 / w2), add_scaled(origin, 1.0, middle)
    return True, (add_scaled(middle, up, w), add_scaled(middle, -up, w))


@njit()
def _spheres_of_triples(
    probes: PatchIndex,
    seeds: np.ndarray,
    near: np.ndarray,
    begin: int,
    end: int,
    radii: np.ndarray,
    probe: float,
    tolerance: float,
) -> np.ndarray:
    """Return the spheres (m, 5) through three seeds, one of a slice and two of its neighbours, that hold no probe inside."""
    rows, n = np.empty((64, CANDIDATE_COLUMNS)), 0
    for i in range(begin, end):
        origin = point(seeds, i)
        for e in range(1, near.shape[1]):
            j = near[i, e]
            for f in range(e + 1, near.shape[1]):
                k = near[i, f]
                # each triple once: by its lowest member among those whose neighbours it consists of
                if (j < i and _lists_pair(near, j, i, k)) or (k < i and _lists_pair(near, k, i, j)):
                    continue
                b, c = subtract(point(seeds, j), origin), subtract(point(seeds, k), origin)
                for r in radii:
                    exist, centres = centres_of_spheres(origin, b, c, r + probe)
                    for side in range(2 if exist else 0):
                        centre = centres[side]
                        touched = _touching(probes, centre, r + probe, tolerance)
                        if touched >= TOUCHES_OF_TRIPLE:
                            rows = append(rows, n, centre, r, touched - 3)
                            n += 1
    return rows[:n].copy()


@njit()
def _refine(probes: PatchIndex, atoms: np.ndarray, probe: float, tolerance: float) -> None:
    """Move the atoms (A, 5), in place, to the least squares of their distances from the probes that touch them."""
    for i in range(len(atoms)):
        for _ in range(STEPS):
            centre, reach = point(atoms, i), atoms[i, 3] + probe
            s = np.zeros(9)  # xx, xy, xz, yy, yz, zz of the system, and its right side
            n, columns = 0, columns_around(probes.lattice, centre, reach + MAX_DISTANCE_OF_TOUCH)
            for c in range(columns.n):
                for q in in_column(probes.start, columns, c):
                    u, v, w = subtract(centre, point(probes.xyz, q))
                    d = math.sqrt(u * u + v * v + w * w)
                    if abs(d - reach) < 2 * tolerance:
                        u, v, w, n = u / d, v / d, w / d, n + 1
                        s[0] += u * u
                        s[1] += u * v
                        s[2] += u * w
                        s[3] += v * v
                        s[4] += v * w
                        s[5] += w * w
                        s[6] += u * (reach - d)
                        s[7] += v * (reach - d)
                        s[8] += w * (reach - d)
            if n < MIN_TOUCHES:
                break
            step = _solved(s)
            if dot(step, step) < MAX_STEP**2:
                set_point(atoms, i, add_scaled(centre, 1.0, step))


@njit()
def _solved(s: np.ndarray) -> Vector:
    """Solve a symmetric system of three equations, damped, by Cramer's rule."""
    ridge = DAMPING * (s[0] + s[3] + s[5])
    a, d, f = s[0] + ridge, s[3] + ridge, s[5] + ridge
    first, second, third = (a, s[1], s[2]), (s[1], d, s[4]), (s[2], s[4], f)
    right = (s[6], s[7], s[8])
    whole = dot(first, cross(second, third))
    return (
        dot(right, cross(second, third)) / whole,
        dot(first, cross(right, third)) / whole,
        dot(first, cross(second, right)) / whole,
    )


@njit()
def _only_atom(
    grid: PatchIndex, radii: np.ndarray, largest: float, centre: Vector, probe: float, tolerance: float
) -> int:
    """Return the position of the only atom, of radii up to the largest, that the probe at a centre touches; -1 if not one."""
    found, columns = -1, columns_around(grid.lattice, centre, largest + probe + 2 * tolerance)
    for c in range(columns.n):
        for q in in_column(grid.start, columns, c):
            v = subtract(point(grid.xyz, q), centre)
            if abs(math.sqrt(dot(v, v)) - radii[q] - probe) < 2 * tolerance:
                if found >= 0:
                    return -1
                found = q
    return found


@njit()
def _is_near(grid: PatchIndex, centre: Vector, distance: float) -> bool:
    """Return whether a point of the grid lies within a distance of a centre."""
    return _touching(grid, centre, 0.5 * distance, 0.5 * distance) != 0


@njit()
def _second_atoms(
    probes: PatchIndex,
    near: np.ndarray,
    centres: np.ndarray,
    normals: np.ndarray,
    grid: PatchIndex,
    radii_of_grid: np.ndarray,
    radii: np.ndarray,
    probe: float,
    tolerance: float,
) -> np.ndarray:
    """Return candidates (m, 5) for the second atom of each saddle dot that touches one known atom.

    The normal of a saddle dot lies in the plane of the probe centre and both atoms. In this plane the second atom lies at the
    distance r + probe, and another probe that touches it fixes its angle.
    """
    rows, n, largest = np.empty((64, CANDIDATE_COLUMNS)), 0, radii_of_grid.max()
    for i in range(len(centres)):
        centre = point(centres, i)
        atom = _only_atom(grid, radii_of_grid, largest, centre, probe, tolerance)
        if atom < 0:
            continue
        e1 = subtract(point(grid.xyz, atom), centre)
        e1 = scaled(1.0 / math.sqrt(dot(e1, e1)), e1)
        inward = scaled(-1.0, point(normals, i))
        along = dot(inward, e1)
        e2 = add_scaled(inward, -along, e1)
        length = math.sqrt(dot(e2, e2))
        if along >= 1.0 - max(1e-5, 8 * tolerance**2) or length <= MIN_ACROSS:
            continue  # a contact dot touches no second atom
        e2 = scaled(1.0 / length, e2)
        # The dot lies between the directions to both atoms
        beyond = math.acos(max(-1.0, min(1.0, along))) + BEYOND_DOT
        for e in range(near.shape[1]):
            v = subtract(point(probes.xyz, near[i, e]), centre)
            v2, x, y = dot(v, v), dot(v, e1), dot(v, e2)
            size = math.sqrt(x * x + y * y)
            if v2 <= MIN_PROBE_DISTANCE2:
                continue
            for r in radii:
                q = v2 / (2 * (r + probe))
                if size <= q:
                    continue
                for sign in range(2):
                    t = (math.atan2(y, x) + math.acos(q / size) * (1 - 2 * sign)) % (2 * math.pi)
                    if t <= beyond or t >= MAX_ANGLE:
                        continue
                    place = add_scaled(centre, (r + probe) * math.cos(t), e1)
                    place = add_scaled(place, (r + probe) * math.sin(t), e2)
                    touched = _touching(probes, place, r + probe, 2 * tolerance)
                    if touched >= TOUCHES_OF_SADDLE and not _is_near(grid, place, SAME_ATOM):
                        rows = append(rows, n, place, r, touched)
                        n += 1
    return rows[:n].copy()
