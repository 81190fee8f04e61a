"""Exact areas of the atoms of a molecule, from the arcs of the rolled probe and without dots.

The accessible area of an atom is that of the part of its sphere of probe centres that lies in no other such sphere; scaled to the
sphere of the atom, it is the contact part of the excluded area. A part of a sphere is measured by the cone from a fixed pole over
its border: the signed areas between the pole and the arcs of the border sum to the solid angle, but for a multiple of 4 pi.

The saddles have closed formulas; where a torus intersects itself, its part beyond the axis is left out. A concave triangle of a
fixed probe may enter other probes beyond the plane of its three atoms. There only fixed probes matter: a point of the triangle is
nearer to its probe than to all other accessible centres until the line from the probe reaches the region of another fixed probe.
What remains is the part of a sphere outside of several caps, whose area follows from the arcs of their circles as above.

Saddle and concave area belong to the atoms that dots at their places belong to (`dot_placement`): a saddle is divided halfway in
theta, a concave triangle by nearest centre. Lengths in Å, areas in Å^2, angles in rad.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.components import enclosed_of
from sparsurf.surfaces.dot_placement import (
    Rolled,
    band_area,
    bands,
    roll_checked,
)
from sparsurf.surfaces.grid import PointGrid, columns_around, in_column, sort_into_grid
from sparsurf.surfaces.rolling_probe import (
    ARC_RADIUS,
    CLOSED,
    E1,
    E2,
    PHI_0,
    PHI_1,
    THETA_I,
    THETA_J,
    UNCUT,
    EnclosedCentres,
    RolledAtoms,
    Rolling,
    U,
    blocker,
    cut_out,
    no_enclosed_centres,
    roll,
)
from sparsurf.surfaces.vectors import (
    POLE,
    Vector,
    add_scaled,
    cone,
    cross,
    dot,
    doubled,
    point,
    set_point,
    squared_distance,
    subtract,
    vector_at,
)

NO_SOLID_ANGLE = 1e-6  # sr; below it, one direction decides whether a sphere is covered or free
ROUNDING = 1e-9  # Å^2, far above that of areas
N_FIXED_CAPS = 5  # of a concave triangle: three sides, and the two atoms that are nearer


class AtomAreas(NamedTuple):
    """Areas of each of A atoms, Å^2; zero for atoms that lie at the position of another one."""

    accessible: np.ndarray  # (A,) float64
    buried: np.ndarray  # (A,) float64, accessible area that atoms of other chains take
    excluded: np.ndarray  # (A,) float64


def areas_of_spheres(
    xyz: np.ndarray, radii: np.ndarray, probe: float, chain: np.ndarray, with_excluded: bool = True
) -> AtomAreas:
    """Compute the areas of spheres at `xyz` (A, 3) with `radii`, Å, which belong to the chains `chain` (A,)."""
    rolled = roll_checked(xyz, radii, probe, in_order=True)
    areas = areas_of_rolled(rolled, chain)
    if with_excluded:
        areas.excluded[:] = areas_by_kind(rolled, len(chain)).sum(axis=1)
    return areas


def areas_of_rolled(rolled: Rolled, chain: np.ndarray) -> AtomAreas:
    """Compute the areas of atoms of the chains `chain` (A,) on a probe that is rolled already, without the excluded ones.

    Where walls of cavities are removed, they are no part of the accessible area.
    """
    rolling, atom, areas = rolled.rolling, rolled.atom, AtomAreas(*np.zeros((3, len(chain))))
    accessible = accessible_areas(rolling, no_enclosed_centres(rolling))
    areas.buried[atom] = _buried_areas(rolling, accessible, chain[atom])
    if rolled.cavities == "remove":
        accessible = accessible_areas(rolling, enclosed_of(rolled))
    areas.accessible[atom] = accessible
    return areas


def areas_by_kind(rolled: Rolled, n_atoms: int) -> np.ndarray:
    """Compute the contact, saddle and concave area of each atom, (A, 3), Å^2, of the surface on which dots are placed.

    The columns are in the order of the kinds of dots, and an area belongs to the atom to which dots at its place belong.
    """
    enclosed, areas = enclosed_of(rolled), np.zeros((n_atoms, 3))
    accessible = accessible_areas(rolled.rolling, enclosed)
    areas[rolled.atom] = _areas_by_kind(rolled.rolling, accessible, rolled.probe, enclosed)
    return areas


def _buried_areas(rolling: Rolling, accessible: np.ndarray, chain: np.ndarray) -> np.ndarray:
    """Compute the area (A,) of each atom that is accessible where its chain is alone, and not in the presence of all chains."""
    atoms = rolling.atoms
    atom, near = np.repeat(np.arange(len(chain)), np.diff(atoms.start)), atoms.near
    is_other = chain[atom] != chain[near]
    in_contact = np.bincount(atom, is_other, len(chain)) > 0
    # The area of an atom follows from its neighbours and what cuts it, which are also neighbours
    is_rolled = in_contact | (np.bincount(atom, in_contact[near] & ~is_other, len(chain)) > 0)
    alone = np.zeros(len(chain))
    for name in np.unique(chain[in_contact]):
        alone += _accessible_among(atoms, np.flatnonzero(is_rolled & (chain == name)))
    buried = np.where(in_contact, alone - accessible, 0.0)
    return np.where(buried > ROUNDING, buried, 0.0)


def contacts_of_rolled(rolled: Rolled, chain: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Compute the accessible area of each atom that each partner buries where only the two are present.

    Return atoms (n,), partners (n,) and areas (n,), Å^2, ordered by atoms and partners; `chain` (A,) int is the partner of each
    atom.
    """
    atoms, atom = rolled.rolling.atoms, rolled.atom
    partner = chain[atom]
    first = np.repeat(np.arange(len(partner)), np.diff(atoms.start))
    ends = np.column_stack([partner[first], partner[atoms.near]])
    meets = np.flatnonzero(ends[:, 0] != ends[:, 1])
    pairs, pair = np.unique(np.sort(ends[meets], axis=1), axis=0, return_inverse=True)
    meets, begin = meets[np.argsort(pair, kind="stable")], np.cumsum(np.bincount(pair))
    found = [np.zeros((0, 3))]
    for two, entries in zip(pairs, np.split(meets, begin)[:-1], strict=True):
        touching = np.unique(first[entries])
        # The area of an atom follows from its neighbours and what cuts it, which are also neighbours
        near = [atoms.near[atoms.start[row] : atoms.start[row + 1]] for row in touching]
        around = np.unique(np.concatenate([touching, *near]))
        around = around[np.isin(partner[around], two)]
        accessible = _accessible_among(atoms, around)
        for this, that in (two, two[::-1]):
            alone = _accessible_among(atoms, around[partner[around] == this])
            rows = touching[partner[touching] == this]
            buried = alone[rows] - accessible[rows]
            rows, buried = rows[buried > ROUNDING], buried[buried > ROUNDING]
            found.append(np.column_stack([atom[rows], np.full(len(rows), that), buried]))
    table = np.concatenate(found)
    table = table[np.lexsort((table[:, 1], table[:, 0]))]
    return table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2]


def _accessible_among(atoms: RolledAtoms, chosen: np.ndarray) -> np.ndarray:
    """Compute the accessible area of chosen atoms where only these are present, (K,) of all atoms: zero for the others."""
    areas = np.zeros(len(atoms.centre))
    part = roll(atoms.centre[chosen], atoms.reach[chosen])
    areas[chosen] = accessible_areas(part, no_enclosed_centres(part))
    return areas


def accessible_areas(rolling: Rolling, enclosed: EnclosedCentres) -> np.ndarray:
    """Compute the area of probe centres around each atom of a rolled probe, (A,) Å^2, without the enclosed ones."""
    solid = np.zeros(len(rolling.atoms.centre))
    _add_cones(rolling, enclosed.arcs, solid)
    _resolve(rolling, solid)
    solid[enclosed.atoms == CLOSED] = 0.0
    return rolling.atoms.reach**2 * solid


def _areas_by_kind(
    rolling: Rolling, accessible: np.ndarray, probe: float, left_out: EnclosedCentres
) -> np.ndarray:
    """Compute the contact, saddle and concave area of each atom, (A, 3) Å^2, from its accessible area."""
    contact, saddle, concave = np.zeros((3, len(accessible)))
    contact += accessible * (1 - probe / rolling.atoms.reach) ** 2
    _add_saddles(rolling, left_out.arcs, probe, saddle)
    _add_concave(rolling, left_out.probes, sort_into_grid(rolling.probes, 2 * probe), probe, concave)
    return np.stack([contact, saddle, concave], axis=1)


@njit()
def _add_cones(rolling: Rolling, left_out: np.ndarray, solid: np.ndarray) -> None:
    """Add the cones of all arcs except some (B,) to the solid angles of their two atoms."""
    for b in range(len(rolling.arcs)):
        if left_out[b]:
            continue
        arc = rolling.arcs[b]
        axis, e1, e2 = vector_at(arc, U), vector_at(arc, E1), vector_at(arc, E2)
        low, high = arc[PHI_0], arc[PHI_1]
        solid[rolling.pair[b, 0]] += cone(axis, -math.sin(arc[THETA_I]), e1, e2, low, high)
        # Seen from the other atom, the axis and the sense of phi are reversed
        axis, e2 = (-axis[0], -axis[1], -axis[2]), (-e2[0], -e2[1], -e2[2])
        solid[rolling.pair[b, 1]] += cone(axis, math.sin(arc[THETA_J]), e1, e2, -high, -low)


@njit()
def _resolve(rolling: Rolling, solid: np.ndarray) -> None:
    """Bring solid angles into the range 0 to 4 pi; near both ends of it, the pole decides whether the sphere is covered."""
    whole = 4 * math.pi
    for i in range(len(solid)):
        angle = solid[i] - whole * round(solid[i] / whole)
        if abs(angle) < NO_SOLID_ANGLE:
            top = add_scaled(point(rolling.atoms.centre, i), rolling.atoms.reach[i], POLE)
            angle += whole if blocker(top, i, rolling.atoms, -1) < 0 else 0.0
        elif angle < 0:
            angle += whole
        solid[i] = min(whole, max(0.0, angle))


@njit()
def _add_saddles(rolling: Rolling, left_out: np.ndarray, probe: float, area: np.ndarray) -> None:
    """Add the area of the saddle along each arc except some (B,) to its two atoms."""
    for b in range(len(rolling.arcs)):
        if left_out[b]:
            continue
        arc = rolling.arcs[b]
        radius, turn = arc[ARC_RADIUS], arc[PHI_1] - arc[PHI_0]
        halfway = (arc[THETA_I] + arc[THETA_J]) / 2
        for low, high in bands(arc, probe):
            if low < min(high, halfway):
                area[rolling.pair[b, 0]] += band_area(radius, probe, turn, low, min(high, halfway))
            if max(low, halfway) < high:
                area[rolling.pair[b, 1]] += band_area(radius, probe, turn, max(low, halfway), high)


@njit()
def _write_cap(caps: np.ndarray, row: int, axis: Vector, height: float) -> None:
    """Write the cap of the unit sphere beyond the plane v . axis = height; the axis need not be a unit vector."""
    length = max(math.sqrt(dot(axis, axis)), 1e-300)
    set_point(caps, row, (axis[0] / length, axis[1] / length, axis[2] / length))
    caps[row, 3] = height / length


@njit()
def _add_concave(
    rolling: Rolling, left_out: np.ndarray, grid: PointGrid, probe: float, area: np.ndarray
) -> None:
    """Add the area of the triangle of each fixed probe except some (P,) to its three atoms.

    Its parts inside of other probes are no part of it.
    """
    centre, reach = rolling.atoms.centre, rolling.atoms.reach
    caps = np.empty((64, 4))
    for q in range(len(rolling.probes)):
        if left_out[q]:
            continue
        apex = point(rolling.probes, q)
        i, j, k = rolling.triple[q, 0], rolling.triple[q, 1], rolling.triple[q, 2]
        to_i, to_j, to_k = (
            subtract(point(centre, i), apex),
            subtract(point(centre, j), apex),
            subtract(point(centre, k), apex),
        )
        if dot(cross(to_i, to_j), to_k) < 0:
            j, k, to_j, to_k = k, j, to_k, to_j
        corner, edges = (i, j, k), (to_i, to_j, to_k)
        plane = (0.0, 0.0, 0.0)
        for side in range(3):
            outwards = cross(edges[(side + 1) % 3], edges[side])
            _write_cap(caps, side, outwards, 0.0)
            plane = add_scaled(plane, -1.0, outwards)
        n = N_FIXED_CAPS
        # Only a triangle that reaches beyond the plane of its atoms can enter another probe
        if dot(plane, to_i) < probe * math.sqrt(dot(plane, plane)):
            columns = columns_around(grid.lattice, apex, grid.lattice.side)
            for c in range(columns.n):
                for p in in_column(grid.start, columns, c):
                    d2 = squared_distance(point(grid.xyz, p), apex)
                    if grid.dot[p] == q or d2 >= 4 * probe * probe:
                        continue
                    if n == len(caps):
                        caps = doubled(caps)
                    _write_cap(caps, n, subtract(point(grid.xyz, p), apex), d2 / (2 * probe))
                    n += 1
        for owner in range(3):
            for step in range(1, 3):
                nearer = (owner + step) % 3
                # Distances from both atoms are equal where v . axis has this height
                height = (reach[corner[nearer]] ** 2 - reach[corner[owner]] ** 2) / (2 * probe)
                _write_cap(caps, 2 + step, subtract(edges[nearer], edges[owner]), height)
            area[corner[owner]] += probe * probe * _area_outside(caps, n)


@njit()
def _area_outside(caps: np.ndarray, n: int) -> float:
    """Return the area of the unit sphere outside of n caps, which must be less than half of it."""
    area = 0.0
    parts, remaining = np.empty((n + 1, 4)), np.empty((n + 1, 4))
    for c in range(n):
        axis, height = point(caps, c), caps[c, 3]
        if height <= -1:
            return 0.0
        if height >= 1:
            continue
        flat = math.hypot(axis[0], axis[2])
        e1 = (-axis[2] / flat, 0.0, axis[0] / flat) if flat > 0 else (1.0, 0.0, 0.0)
        e2 = cross(e1, axis)
        m = UNCUT
        for k in range(n):
            if k == c or m == 0 or caps[k, 3] >= 1:
                continue
            # Of a position on the circle: inside the cap k where cos(phi - middle) exceeds `limit`
            p1, p2 = dot(point(caps, k), e1), dot(point(caps, k), e2)
            wide = math.sqrt(1 - height * height) * math.hypot(p1, p2)
            limit = caps[k, 3] - height * dot(point(caps, k), axis)
            if limit <= -wide:
                m = 0
            elif limit < wide:
                half = math.acos(limit / wide)
                m = cut_out(parts, m, math.atan2(p2, p1) - half, half, k, remaining)
                parts, remaining = remaining, parts
        if m == UNCUT:
            area += cone(axis, height, e1, e2, 0.0, 2 * math.pi)
        for p in range(m):
            area += cone(axis, height, e1, e2, parts[p, 0], parts[p, 1])
    return max(0.0, area - 4 * math.pi * round(area / (4 * math.pi)))
