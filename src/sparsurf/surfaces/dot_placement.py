"""Place dots on the solvent-excluded surface where the program DMS places them.

DMS's manual does not describe how it places dots. The rules here were derived from its output (A1 of TDP-43 and 1a1u
chain A at `-d 1.0`), whose dots and order they reproduce: dots lie on rows sqrt(3)/2 d apart and every d along a row,
as in a hexagonal lattice of 5.5 dots per Å^2 (d = 0.458 Å); atoms are visited by x, then y, then z.
Surface: Connolly, J. Appl. Cryst. 16:548 (1983). Lengths in Å, areas in Å^2, angles in rad.
"""

from __future__ import annotations

import logging
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sparsurf.errors import InputError, argument
from sparsurf.kernels import njit
from sparsurf.surfaces.rolling_probe import (
    ARC_RADIUS,
    E1,
    E2,
    PHI_0,
    PHI_1,
    THETA_I,
    THETA_J,
    EnclosedCentres,
    RolledAtoms,
    Rolling,
    T,
    U,
    blocker,
    is_enclosed,
    no_enclosed_centres,
    roll,
    without_covered_circles,
)
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE
from sparsurf.surfaces.vectors import (
    Cells,
    Vector,
    add_scaled,
    cell_column,
    cross,
    dot,
    doubled,
    point,
    sort_into_cells,
    squared_distance,
    subtract,
    vector_at,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")

MAX_SPHERE_COORDINATE = 1e6  # Å
MAX_ATOM_RADIUS = 100  # Å
_warned: set[tuple[int, int]] = set()  # warnings are given once for all surfaces of the same atoms
# Dots per Å^2 of the lattice of DMS at `-d 1.0`; the surface of a protein gets 3 % fewer.
LATTICE = 5.5
# Distance of the rings of a sphere per distance of the dots; 0.899 to 0.914 reproduce the rings of all known radii.
RING_SPACING = 0.906

# Å, half width of the uniform random shift of every centre. It moves atoms out of special positions, where four or more
# touch one probe. It is far above rounding (1e-13 Å) and far below the accuracy of a dot's position.
MAX_PROBE_SHIFT = 1e-8
SHIFT_SEED = 1
# Å; a concave dot is inside another probe if it is nearer to its centre than the radius by this much.
INSIDE_TOLERANCE = 1e-9


class PlacedDots(NamedTuple):
    """Dots of one kind in the order in which they were placed."""

    rows: np.ndarray  # (N, 7) float64: position, outward normal, area
    atom: np.ndarray  # (N, 1) int64, owning atom


class RolledProbe(NamedTuple):
    """Atoms with the probe rolled over them, on which dots of any density are placed."""

    origin: np.ndarray  # (3,) float64, Å, that positions are relative to
    by_position: np.ndarray  # (A,) int64, atoms by x, then y, then z; the following are in this order
    radii: np.ndarray  # (A,) float64, Å
    rolling: Rolling
    blockers: RolledAtoms
    whole: np.ndarray  # (A,) bool, no arc bounds the accessible part of this sphere
    probe_cells: Cells  # of the fixed probes
    probe: float  # Å, radius
    exact: bool
    left_out: EnclosedCentres  # centres of the probe at which no dots are placed, and which trim none


class Placed(NamedTuple):
    """Dots by kind before their areas are exact and before they are in order."""

    dots: dict[int, PlacedDots]
    share: np.ndarray  # (P,) float64, part of the dots of each concave triangle that is kept
    spacing: float  # Å, of the lattice

    @property
    def positions(self) -> np.ndarray:
        """Positions (N, 3), Å, relative to the origin."""
        return np.concatenate([part.rows[:, :3] for part in self.dots.values()])


def roll_probe(xyz: np.ndarray, radii: np.ndarray, probe: float, exact: bool) -> RolledProbe:
    """Roll the probe over atoms at distinct positions `xyz` (A, 3) with `radii` (A,), Å; unless `exact`, as DMS does."""
    relative, shift = relative_positions(xyz)
    # As DMS visits the atoms: which of two comes first decides where the strips of their saddle begin
    by_position = np.lexsort(relative.T[::-1])
    radii = radii[by_position]
    rolling = roll((relative + shift)[by_position], radii + probe)
    blockers = rolling.atoms if exact else without_covered_circles(rolling.atoms)
    # DMS drops circles that one sphere covers, so that parts of a sphere without arcs are accessible
    whole = np.full(len(radii), exact)
    whole[rolling.pair] = False
    probe_cells = sort_into_cells(at_least_one_probe(rolling.probes), probe)
    left_out = no_enclosed_centres(rolling)
    return RolledProbe(
        xyz[0], by_position, radii, rolling, blockers, whole, probe_cells, probe, exact, left_out
    )


def place_dots(rolled: RolledProbe, density: float) -> Placed:
    """Place dots on the solvent-excluded surface, `density` per Å^2 of the lattice."""
    radii, rolling, probe, exact = rolled.radii, rolled.rolling, rolled.probe, rolled.exact
    left_out, kept_arcs = rolled.left_out, ~rolled.left_out.arcs
    spacing = math.sqrt(2 / math.sqrt(3) / density)
    templates, first, template = _templates(radii, spacing)
    contact = _contact_dots(
        rolled.blockers, rolled.whole, templates, first, template, probe, rolling, left_out
    )
    saddle = _saddle_dots(rolling.arcs[kept_arcs], rolling.pair[kept_arcs], probe, spacing, exact)
    units = sphere_template(probe, spacing)
    concave, share = _concave_dots(rolling, rolled.probe_cells, units, probe, exact, left_out)
    return Placed({CONCAVE: concave, SADDLE: saddle, CONTACT: contact}, share, spacing)


def finish_dots(
    rolled: RolledProbe, placed: Placed
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Sort dots by atom (concave, saddle, contact), with exact areas: points, normals, area, kind, atom; `placed` is used up."""
    dots, by_position = placed.dots, rolled.by_position
    if rolled.exact:
        _set_exact_areas(
            dots[CONTACT],
            dots[CONCAVE],
            placed.share,
            rolled.rolling,
            rolled.radii,
            rolled.probe,
            rolled.left_out,
        )
    n_dots = np.zeros(len(by_position), np.int64)
    for part in dots.values():
        n_dots[by_position] += np.bincount(part.atom[:, 0], minlength=len(by_position))
    n, slot, origin = int(n_dots.sum()), np.cumsum(n_dots) - n_dots, np.array(rolled.origin)
    points, normals, area = np.empty((n, 3)), np.empty((n, 3)), np.empty(n)
    kind, atom = np.empty(n, np.int8), np.empty(n, np.int32)
    for code in list(dots):  # each is freed once it is copied, as they take more memory than what is returned
        rows, owner = dots.pop(code)
        _copy_by_atom(rows, owner, code, by_position, origin, slot, points, normals, area, kind, atom)
    return points, normals, area, kind, atom


@njit(cache=True, nogil=True)
def _copy_by_atom(
    rows: np.ndarray,
    owner: np.ndarray,
    code: int,
    by_position: np.ndarray,
    origin: np.ndarray,
    slot: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    area: np.ndarray,
    kind: np.ndarray,
    atom: np.ndarray,
) -> None:
    """Copy dots of one kind to the next free places of their atoms, `slot` (A,), which is advanced."""
    for n in range(len(rows)):
        i = by_position[owner[n, 0]]
        k = slot[i]
        slot[i] = k + 1
        for a in range(3):
            points[k, a], normals[k, a] = rows[n, a] + origin[a], rows[n, 3 + a]
        area[k], kind[k], atom[k] = rows[n, 6], code, i


def checked_spheres(
    xyz: ArrayLike, radii: ArrayLike, probe: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Check atoms, (A, 3) and (A,) Å, and remove those at the position of another: positions, radii and indices of K atoms."""
    xyz, radii = np.asarray(xyz, dtype=float), np.asarray(radii, dtype=float)
    if xyz.ndim != 2 or xyz.shape[1] != 3 or len(xyz) == 0 or radii.shape != (len(xyz),):
        raise InputError(f"surface: needs (A, 3) centres and (A,) radii, not {xyz.shape} and {radii.shape}.")
    if not (np.abs(xyz) < MAX_SPHERE_COORDINATE).all():
        raise InputError(f"surface: coordinates must be numbers below {MAX_SPHERE_COORDINATE:.0f} Å.")
    if not ((radii > 0) & (radii <= MAX_ATOM_RADIUS)).all():
        raise InputError(f"surface: atomic radii must be positive numbers of at most {MAX_ATOM_RADIUS} Å.")
    if not 0 < probe < np.inf:
        raise InputError(f"{argument('surface.probe_radius')} is {probe}; it must be a positive number.")
    kept = _distinct(xyz, radii)
    return xyz[kept], radii[kept], kept


def _distinct(xyz: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Return the indices of atoms at distinct positions (to 0.001 Å), of each position the largest atom."""
    _, position = np.unique(np.round(xyz - xyz[0], 3), axis=0, return_inverse=True)
    by_position = np.lexsort((-radii, position))
    first = np.append(True, np.diff(position[by_position]) != 0)
    duplicates = np.sort(by_position[~first])
    if len(duplicates):
        warning = len(duplicates), int(duplicates[0]) + 1
        if warning not in _warned:
            _warned.add(warning)
            message = (
                "surface: atoms at the position of another atom are left out (%d), the first is number %d"
            )
            log.warning(message, *warning)
    return np.sort(by_position[first])


def relative_positions(xyz: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (A, 3) relative to the first, Å, equal bits wherever a molecule lies, and a random shift of each."""
    # Rounded, since a difference of large coordinates has other last bits than that of small ones
    relative = np.round(xyz - xyz[0], 9)
    return relative, np.random.default_rng(SHIFT_SEED).uniform(
        -MAX_PROBE_SHIFT, MAX_PROBE_SHIFT, relative.shape
    )


def _set_exact_areas(
    contact: PlacedDots,
    concave: PlacedDots,
    share: np.ndarray,
    rolling: Rolling,
    radii: np.ndarray,
    probe: float,
    left_out: EnclosedCentres,
) -> None:
    """Replace the counted areas of contact and concave dots by exact ones (Gauss-Bonnet), in place.

    The contact patches of an atom share their area among their dots. The concave triangles, of which the part `share` (P,) is
    left, do so all together, since many hold no dot.
    """
    centre, n = rolling.atoms.centre, len(radii)
    kept_arcs, kept_probes = ~left_out.arcs, ~left_out.probes
    arcs, pair, triple, share = (
        rolling.arcs[kept_arcs],
        rolling.pair[kept_arcs],
        rolling.triple[kept_probes],
        share[kept_probes],
    )
    # Angles of the spherical triangles: between the planes through the probe and two of its atoms
    to_atoms = centre[triple] - rolling.probes[kept_probes, None]
    normals = np.cross(to_atoms, np.roll(to_atoms, -1, axis=1))
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-300)
    corners = np.arccos(np.clip(-(normals * np.roll(normals, 1, axis=1)).sum(axis=2), -1, 1))
    if len(concave.rows):
        triangles = probe**2 * (corners.sum(axis=1) - math.pi)
        concave.rows[:, 6] *= (share * triangles).sum() / concave.rows[:, 6].sum()
    # A patch on a unit sphere has the area 2 pi chi - (total turn of its border); chi follows from the counted area
    length = arcs[:, PHI_1] - arcs[:, PHI_0]
    border_turn = np.zeros(n) + np.bincount(triple.ravel(), corners.ravel(), n)
    border_turn += np.bincount(pair[:, 0], np.sin(arcs[:, THETA_I]) * length, n)
    border_turn -= np.bincount(pair[:, 1], np.sin(arcs[:, THETA_J]) * length, n)
    owner, counted = contact.atom[:, 0], np.bincount(contact.atom[:, 0], contact.rows[:, 6], n)
    # Whole by its nature (sphere 2, disc 1, ring 0), so that the counted area need only be right to half of 2 pi
    chi = np.round((counted / radii**2 + border_turn) / (2 * math.pi))
    area = np.maximum(radii**2 * (2 * math.pi * chi - border_turn), 0)
    if len(owner):
        has_dots = counted > 0
        contact.rows[:, 6] *= (area[has_dots] / counted[has_dots])[np.cumsum(has_dots)[owner] - 1]
        # Atoms whose patch is too small for a dot leave their area to the others, so that the sum is that of the surface
        contact.rows[:, 6] *= area.sum() / area[has_dots].sum()


def sphere_template(radius: float, spacing: float) -> np.ndarray:
    """Return unit vectors (n, 3) of dots `spacing` Å apart on a sphere, in rings from the north pole; the south pole has none."""
    n_rings = max(1, int(math.pi * radius / (RING_SPACING * spacing) + 0.5))
    rings = [np.array([[0.0, 0.0, 1.0]])]
    for ring in range(1, n_rings):
        theta = math.pi * ring / n_rings
        n = max(1, int(2 * math.pi * radius * math.sin(theta) / spacing + 0.5))
        # As DMS does: every second ring begins on the other side
        phi = 2 * math.pi * np.arange(n) / n + (0.0 if ring % 2 else math.pi)
        unit = np.column_stack([np.cos(phi), np.sin(phi), np.zeros(n)])
        rings.append(math.sin(theta) * unit + [0, 0, math.cos(theta)])
    return np.concatenate(rings)


def _templates(radii: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the templates of all distinct radii in one (n, 3) array, the first row of each, and the template of each atom."""
    distinct, template = np.unique(radii, return_inverse=True)
    parts = [sphere_template(float(radius), spacing) for radius in distinct]
    first = np.concatenate([[0], np.cumsum([len(part) for part in parts])])
    return np.concatenate(parts), first, template.astype(np.int64)


def at_least_one_probe(probes: np.ndarray) -> np.ndarray:
    """Return the centres of probes (P, 3), or a distant one where there is none, since cells need a point."""
    return probes if len(probes) else np.full((1, 3), 1e9)


@njit(cache=True, nogil=True)
def _write(
    rows: np.ndarray, atom: np.ndarray, n: int, position: Vector, normal: Vector, area: float, owner: int
) -> None:
    """Fill row n of the dots."""
    for a in range(3):
        rows[n, a], rows[n, 3 + a] = position[a], normal[a]
    rows[n, 6], atom[n, 0] = area, owner


@njit(cache=True, nogil=True)
def _contact_dots(
    atoms: RolledAtoms,
    whole: np.ndarray,
    units: np.ndarray,
    first: np.ndarray,
    template: np.ndarray,
    probe: float,
    rolling: Rolling,
    left_out: EnclosedCentres,
) -> PlacedDots:
    """Place the dots of each atom at which a touching probe is accessible; on spheres `whole` one dot decides for all."""
    rows, atom, total = np.empty((64, 7)), np.empty((64, 1), np.int64), 0
    for i in range(len(atoms.centre)):
        radius, centre = atoms.reach[i] - probe, point(atoms.centre, i)
        begin, end = first[template[i]], first[template[i] + 1]
        guess = -1
        for n in range(begin, end):
            unit = point(units, n)
            touching = add_scaled(centre, atoms.reach[i], unit)
            guess = blocker(touching, i, atoms, guess)
            if guess >= 0 and whole[i]:
                break
            if guess >= 0 or is_enclosed(touching, i, rolling, left_out):
                continue
            if total == len(rows):
                rows, atom = doubled(rows), doubled(atom)
            area = 4 * math.pi * radius**2 / (end - begin)
            _write(rows, atom, total, add_scaled(centre, radius, unit), unit, area, i)
            total += 1
    return PlacedDots(rows[:total], atom[:total])


@njit(cache=True, nogil=True)
def band_area(radius: float, probe: float, turn: float, low: float, high: float) -> float:
    """Return the area between two thetas on an arc of angle `turn`."""
    return turn * probe * (radius * (high - low) - probe * (math.sin(high) - math.sin(low)))


@njit(cache=True, nogil=True)
def _n_dots_of_strip(radius: float, turn: float, spacing: float) -> int:
    """Return the number of dots on a part of a circle."""
    return int(radius * turn / spacing + 0.5)


@njit(cache=True, nogil=True)
def bands(arc: np.ndarray, probe: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the two ranges of theta of an arc; the first is empty unless the torus intersects itself (spindle)."""
    low, high = arc[THETA_I], arc[THETA_J]
    if arc[ARC_RADIUS] >= probe:
        return (low, low), (low, high)
    cusp = math.acos(arc[ARC_RADIUS] / probe)
    return (low, min(high, -cusp)), (max(low, cusp), high)


@njit(cache=True, nogil=True)
def _saddle_dots(arcs: np.ndarray, pair: np.ndarray, probe: float, spacing: float, exact: bool) -> PlacedDots:
    """Place the dots of the arcs, last arc first, in strips of equal width in theta, from atom j to atom i."""
    rows, atom, total = np.empty((64, 7)), np.empty((64, 1), np.int64), 0
    row_spacing = spacing * math.sqrt(0.75)
    cell, carried = spacing * row_spacing, 0.0
    # The last arc first, as in the files of DMS
    for b in range(len(arcs) - 1, -1, -1):
        arc = arcs[b]
        radius, turn = arc[ARC_RADIUS], arc[PHI_1] - arc[PHI_0]
        for low, high in bands(arc, probe):
            if high <= low:
                continue
            n_strips = max(1, int(probe * (high - low) / row_spacing + 0.5))
            width = (high - low) / n_strips
            n_filled, n_band = 0, 0
            for strip in range(n_strips):
                n = _n_dots_of_strip(radius - probe * math.cos(high - (strip + 0.5) * width), turn, spacing)
                n_filled, n_band = n_filled + (n > 0), n_band + n
            filled = 0
            for strip in range(n_strips):
                theta = high - (strip + 0.5) * width
                n = _n_dots_of_strip(radius - probe * math.cos(theta), turn, spacing)
                if exact:
                    area = band_area(radius, probe, turn, theta - width / 2, theta + width / 2) / max(n, 1)
                    owner = pair[b, int(2 * theta > arc[THETA_I] + arc[THETA_J])]
                    if n == 0:
                        # Too narrow for a dot: one for every area of `cell`, once half of it has accumulated
                        carried += area
                        if carried < 0.5 * cell:
                            continue
                        n, area, carried = 1, cell, carried - cell
                else:
                    area = band_area(radius, probe, turn, low, high) / max(n_band, 1)
                    owner = pair[b, int(2 * filled < n_filled)]
                # The dots of a strip face the gaps of the previous one
                offset = 0.5 if filled % 2 == 0 else 1.0
                filled += n > 0
                for m in range(n):
                    phi = arc[PHI_0] + turn * (m + offset) / n
                    outward = add_scaled((0.0, 0.0, 0.0), math.cos(phi), vector_at(arc, E1))
                    outward = add_scaled(outward, math.sin(phi), vector_at(arc, E2))
                    normal = add_scaled((0.0, 0.0, 0.0), math.cos(theta), outward)
                    normal = add_scaled(normal, -math.sin(theta), vector_at(arc, U))
                    position = add_scaled(add_scaled(vector_at(arc, T), radius, outward), -probe, normal)
                    if total == len(rows):
                        rows, atom = doubled(rows), doubled(atom)
                    _write(rows, atom, total, position, normal, area, owner)
                    total += 1
    return PlacedDots(rows[:total], atom[:total])


@njit(cache=True, nogil=True)
def _concave_dots(
    rolling: Rolling,
    probe_cells: Cells,
    units: np.ndarray,
    probe: float,
    exact: bool,
    left_out: EnclosedCentres,
) -> tuple[PlacedDots, np.ndarray]:
    """Place the dots of fixed probes between the directions to their three atoms; also return the share of each that is kept."""
    centre = rolling.atoms.centre
    rows, atom, total = np.empty((64, 7)), np.empty((64, 1), np.int64), 0
    share = np.ones(len(rolling.probes))
    area = 4 * math.pi * probe**2 / len(units)
    for q in range(len(rolling.probes)):
        if left_out.probes[q]:
            continue
        i, j, k = rolling.triple[q, 0], rolling.triple[q, 1], rolling.triple[q, 2]
        probe_centre = point(rolling.probes, q)
        to_i, to_j = subtract(point(centre, i), probe_centre), subtract(point(centre, j), probe_centre)
        to_k = subtract(point(centre, k), probe_centre)
        if dot(cross(to_i, to_j), to_k) < 0:
            to_j, to_k = to_k, to_j
        ij, jk, ki = cross(to_i, to_j), cross(to_j, to_k), cross(to_k, to_i)
        # The plane of the atoms is n.v = h for directions v from the probe
        n, h = add_scaled(add_scaled(ij, 1.0, jk), 1.0, ki), dot(ij, to_k)
        before, n_inside = total, 0
        for m in range(len(units)):
            unit = point(units, m)
            if dot(ij, unit) < 0 or dot(jk, unit) < 0 or dot(ki, unit) < 0:
                continue
            position = add_scaled(probe_centre, probe, unit)
            # Only points beyond that plane can lie inside another probe
            beyond = probe * dot(n, unit) > h
            within = probe - INSIDE_TOLERANCE
            if exact and beyond and _inside_other(position, q, rolling, probe_cells, within, left_out):
                n_inside += 1
                continue
            owner = i
            for other in (j, k):
                to_owner = squared_distance(point(centre, owner), position)
                if squared_distance(point(centre, other), position) < to_owner:
                    owner = other
            if total == len(rows):
                rows, atom = doubled(rows), doubled(atom)
            _write(rows, atom, total, position, (-unit[0], -unit[1], -unit[2]), area, owner)
            total += 1
        if n_inside > 0:
            share[q] = (total - before) / (total - before + n_inside)
    return PlacedDots(rows[:total], atom[:total]), share


@njit(cache=True, nogil=True)
def _inside_other(
    position: Vector, q: int, rolling: Rolling, probe_cells: Cells, within: float, left_out: EnclosedCentres
) -> bool:
    """Return whether an accessible centre other than fixed probe q is nearer than `within`; fixed probes are tested first."""
    for c in range(9):
        slot, last = cell_column(probe_cells, position, c)
        while slot < len(probe_cells.key) and probe_cells.key[slot] <= last:
            k = probe_cells.order[slot]
            slot += 1
            near = squared_distance(point(rolling.probes, k), position) < within**2
            if near and k != q and not left_out.probes[k]:
                return True
    atoms, cells = rolling.atoms, rolling.cells
    for c in range(9):
        slot, last = cell_column(cells, position, c)
        while slot < len(cells.key) and cells.key[slot] <= last:
            k = cells.order[slot]
            slot += 1
            centre, reach = point(atoms.centre, k), atoms.reach[k]
            w = subtract(position, centre)
            d = math.sqrt(dot(w, w))
            if d > reach + within:
                continue
            for b in range(rolling.first_arc[k], rolling.first_arc[k + 1]):
                if not left_out.arcs[b] and _arc_within(position, rolling.arcs[b], within):
                    return True
            # The patch of k is nearest straight outwards from its centre
            if reach - within < d < reach:
                nearest = add_scaled(centre, reach / d, w)
                if blocker(nearest, k, atoms, -1) < 0 and not is_enclosed(nearest, k, rolling, left_out):
                    return True
    return False


@njit(cache=True, nogil=True)
def _arc_within(position: Vector, arc: np.ndarray, within: float) -> bool:
    """Return whether the point of the arc's circle nearest to the position belongs to the arc and is nearer than `within`."""
    w = subtract(position, vector_at(arc, T))
    p1, p2 = dot(w, vector_at(arc, E1)), dot(w, vector_at(arc, E2))
    if (math.hypot(p1, p2) - arc[ARC_RADIUS]) ** 2 + dot(w, vector_at(arc, U)) ** 2 >= within**2:
        return False
    phi = math.atan2(p2, p1) - arc[PHI_0]
    return phi - 2 * math.pi * math.floor(phi / (2 * math.pi)) <= arc[PHI_1] - arc[PHI_0]
