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

from sparsurf.arguments import Cavities
from sparsurf.errors import InputError, argument
from sparsurf.kernels import njit
from sparsurf.surfaces.grid import PointGrid, columns_around, in_column, sort_into_grid
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
    Vector,
    add_scaled,
    cross,
    dot,
    point,
    scaled,
    slots,
    squared_distance,
    subtract,
    vector_at,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")

MAX_SPHERE_COORDINATE = 1e6  # Å
MAX_ATOM_RADIUS = 100  # Å
_warned: set[tuple[int, int, bytes]] = (
    set()
)  # warnings are given once for all frames and surfaces of the same atoms
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


class Dots(NamedTuple):
    """Dots by atom, those of one atom by kind (concave, saddle, contact); N is 0 while they are counted."""

    points: np.ndarray  # (N, 3) float64, Å
    normals: np.ndarray  # (N, 3) float64, outward
    area: np.ndarray  # (N,) float64, Å^2
    kind: np.ndarray  # (N,) int8
    atom: np.ndarray  # (N,) int32

    @staticmethod
    def empty(n: int) -> Dots:
        """Make room for n dots."""
        return Dots(
            np.empty((n, 3)), np.empty((n, 3)), np.empty(n), np.empty(n, np.int8), np.empty(n, np.int32)
        )

    def take(self, dots: np.ndarray) -> Dots:
        """Return some of the dots, by index or mask."""
        return Dots(*(column[dots] for column in self))


class Rolled(NamedTuple):
    """Atoms with the probe rolled over them, on which dots of any density are placed."""

    origin: np.ndarray  # (3,) float64, Å, that positions are relative to
    by_position: (
        np.ndarray
    )  # (A,) int64, atoms by x, then y, then z, or as given; the following are in this order
    atom: np.ndarray  # (A,) int64, their numbers among those given, of which some may lie in one place
    radii: np.ndarray  # (A,) float64, Å
    rolling: Rolling
    blockers: RolledAtoms
    whole: np.ndarray  # (A,) bool, no arc bounds the accessible part of this sphere
    probes: PointGrid  # the grid of the fixed probes, as wide as the radius
    probe: float  # Å, radius; 0 where dots lie on the spheres of its centres, whose radii are then `radii`
    exact: bool
    left_out: EnclosedCentres  # centres of the probe at which no dots are placed, and which trim none
    cavities: Cavities = "keep"  # or 'remove': whether their walls are part of the surface


def roll_checked(
    xyz: ArrayLike,
    radii: ArrayLike,
    probe: float,
    exact: bool = True,
    cavities: Cavities = "keep",
    in_order: bool = False,
) -> Rolled:
    """Check spheres, and roll the probe over those at distinct positions: by position, or in the order of the spheres."""
    xyz, radii, kept = checked_spheres(xyz, radii, probe)
    rolled = roll_probe(xyz, radii, float(probe), exact, in_order=in_order)
    return rolled._replace(atom=kept[rolled.by_position], cavities=cavities)


def roll_probe(
    xyz: np.ndarray,
    radii: np.ndarray,
    probe: float,
    exact: bool,
    before: Rolled | None = None,
    in_order: bool = False,
) -> Rolled:
    """Roll the probe over atoms at distinct positions `xyz` (A, 3) with `radii` (A,), Å; unless `exact`, as DMS does.

    The first of them may have been rolled over `before`.
    """
    relative, shift = relative_positions(xyz)
    # As DMS visits the atoms: which of two comes first decides where the strips of their saddle begin
    by_position = np.arange(len(xyz)) if in_order else np.lexsort(relative.T[::-1])
    radii = radii[by_position]
    place = None
    if before is not None:
        rank = np.empty(len(xyz), np.int64)
        rank[by_position] = np.arange(len(xyz))
        place = rank[before.by_position]
    rolling = roll((relative + shift)[by_position], radii + probe, before and before.rolling, place)
    blockers = rolling.atoms if exact else without_covered_circles(rolling.atoms)
    # DMS drops circles that one sphere covers, so that parts of a sphere without arcs are accessible
    whole = np.full(len(radii), exact)
    whole[rolling.pair] = False
    probes, left_out = sort_into_grid(rolling.probes, probe), no_enclosed_centres(rolling)
    return Rolled(
        xyz[0], by_position, by_position, radii, rolling, blockers, whole, probes, probe, exact, left_out
    )


def lattice_spacing(density: float) -> float:
    """Return the distance of neighbouring dots, Å, on a lattice of `density` dots per Å^2."""
    return math.sqrt(2 / math.sqrt(3) / density)


def place_dots(rolled: Rolled, density: float) -> Dots:
    """Place dots on the solvent-excluded surface, or on the spheres of a probe of 0 Å, `density` per Å^2 of the lattice.

    The dots of each atom and kind are counted first, so that each is written once, to its place among all.
    """
    radii, rolling, probe, exact = rolled.radii, rolled.rolling, rolled.probe, rolled.exact
    left_out, kept_arcs = rolled.left_out, ~rolled.left_out.arcs
    spacing, n_atoms = lattice_spacing(density), len(rolled.radii)
    templates, unit = _templates(radii, spacing), sphere_template(probe, spacing)
    if probe == 0:  # the spheres of its centres have contact dots alone
        kept_arcs, unit = np.zeros_like(kept_arcs), unit[:0]
    strips = rolling.arcs[kept_arcs], rolling.pair[kept_arcs], probe, spacing, exact
    n_contact, n_saddle, n_concave = np.zeros((3, n_atoms), np.int64)
    is_free, contact_area, counted = _count_contact_dots(
        rolled.blockers, rolled.whole, templates, probe, rolling, left_out, n_contact
    )
    uncounted, nowhere = Dots.empty(0), np.zeros(3)
    _saddle_dots(*strips, n_saddle, nowhere, rolled.atom, uncounted)
    owners, share = _count_concave_dots(rolling, rolled.probes, unit, probe, exact, left_out, n_concave)
    concave_area = 4 * math.pi * probe**2 / max(len(unit), 1)
    if exact:
        contact_area, concave_area = _exact_areas(
            contact_area, counted, concave_area, int(n_concave.sum()), share, rolling, radii, probe, left_out
        )
    n_dots = np.empty((n_atoms, 3), np.int64)
    n_dots[rolled.by_position] = np.stack([n_concave, n_saddle, n_contact], axis=1)
    first = (np.cumsum(n_dots) - n_dots.ravel()).reshape(n_dots.shape)[rolled.by_position]
    concave, saddle, contact = np.ascontiguousarray(first.T)
    dots, place = Dots.empty(int(n_dots.sum())), (np.array(rolled.origin), rolled.atom)
    _concave_dots(rolling, owners, unit, probe, concave_area, concave, *place, dots)
    _saddle_dots(*strips, saddle, *place, dots)
    _contact_dots(rolled.blockers, is_free, templates, probe, contact_area, contact, *place, dots)
    return dots


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
        number, warned = int(duplicates[0]) + 1, (len(duplicates), int(duplicates[0]), radii.tobytes())
        if warned not in _warned:
            _warned.add(warned)
            message = (
                "surface: atoms at the position of another atom are left out (%d), the first is number %d"
            )
            log.warning(message, len(duplicates), number)
    return np.sort(by_position[first])


def relative_positions(xyz: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (A, 3) relative to the first, Å, equal bits wherever a molecule lies, and a random shift of each."""
    # Rounded, since a difference of large coordinates has other last bits than that of small ones
    relative = np.round(xyz - xyz[0], 9)
    return relative, np.random.default_rng(SHIFT_SEED).uniform(
        -MAX_PROBE_SHIFT, MAX_PROBE_SHIFT, relative.shape
    )


def _exact_areas(
    contact_area: np.ndarray,
    counted: np.ndarray,
    concave_area: float,
    n_concave: int,
    share: np.ndarray,
    rolling: Rolling,
    radii: np.ndarray,
    probe: float,
    left_out: EnclosedCentres,
) -> tuple[np.ndarray, float]:
    """Return the areas of a contact dot of each atom, (A,), and of a concave dot, as they are exact (Gauss-Bonnet).

    The contact patches of an atom, whose dots have the area `counted` (A,), share their area among their dots. The concave
    triangles, of which the part `share` (P,) is left, do so all together, since many hold no dot.
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
    if n_concave:
        triangles = probe**2 * (corners.sum(axis=1) - math.pi)
        concave_area *= (share * triangles).sum() / np.broadcast_to(concave_area, n_concave).sum()
    # A patch on a unit sphere has the area 2 pi chi - (total turn of its border); chi follows from the counted area
    length = arcs[:, PHI_1] - arcs[:, PHI_0]
    border_turn = np.zeros(n) + np.bincount(triple.ravel(), corners.ravel(), n)
    border_turn += np.bincount(pair[:, 0], np.sin(arcs[:, THETA_I]) * length, n)
    border_turn -= np.bincount(pair[:, 1], np.sin(arcs[:, THETA_J]) * length, n)
    # Whole by its nature (sphere 2, disc 1, ring 0), so that the counted area need only be right to half of 2 pi
    chi = np.round((counted / radii**2 + border_turn) / (2 * math.pi))
    area = np.maximum(radii**2 * (2 * math.pi * chi - border_turn), 0)
    if (has_dots := counted > 0).any():
        exact = contact_area[has_dots] * (area[has_dots] / counted[has_dots])
        # Atoms whose patch is too small for a dot leave their area to the others, so that the sum is that of the surface
        contact_area[has_dots] = exact * (area.sum() / area[has_dots].sum())
    return contact_area, concave_area


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


class Templates(NamedTuple):
    """Directions of the dots on spheres of all distinct radii."""

    units: np.ndarray  # (n, 3) float64
    first: np.ndarray  # of each template and of what follows the last, the first of `units`
    of_atom: np.ndarray  # (A,) int64, template of each atom


def _templates(radii: np.ndarray, spacing: float) -> Templates:
    """Return the templates of all distinct radii."""
    distinct, template = np.unique(radii, return_inverse=True)
    parts = [sphere_template(float(radius), spacing) for radius in distinct]
    first = np.concatenate([[0], np.cumsum([len(part) for part in parts])])
    return Templates(np.concatenate(parts), first, template.astype(np.int64))


@njit()
def _write(
    dots: Dots,
    slot: np.ndarray,
    owner: int,
    position: Vector,
    normal: Vector,
    area: float,
    kind: int,
    origin: np.ndarray,
    atom_of_owner: np.ndarray,
) -> None:
    """Write a dot to the next free place of its owner, `slot` (A,), which is advanced."""
    k = slot[owner]
    slot[owner] = k + 1
    for a in range(3):
        dots.points[k, a], dots.normals[k, a] = position[a] + origin[a], normal[a]
    dots.area[k], dots.kind[k], dots.atom[k] = area, kind, atom_of_owner[owner]


@njit()
def _count_contact_dots(
    atoms: RolledAtoms,
    whole: np.ndarray,
    templates: Templates,
    probe: float,
    rolling: Rolling,
    left_out: EnclosedCentres,
    n_dots: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the dots at which a touching probe is accessible; on spheres `whole` one dot decides for all.

    Adds their number to `n_dots` (A,), and returns whether each dot of the template of each atom is one, the area of one dot of
    each atom, and that of all of them.
    """
    first, n_atoms = templates.first, len(atoms.centre)
    total = 0
    for i in range(n_atoms):
        total += first[templates.of_atom[i] + 1] - first[templates.of_atom[i]]
    is_free, area, counted, m = np.zeros(total, np.bool_), np.empty(n_atoms), np.zeros(n_atoms), 0
    for i in range(n_atoms):
        radius, centre = atoms.reach[i] - probe, point(atoms.centre, i)
        begin, end = first[templates.of_atom[i]], first[templates.of_atom[i] + 1]
        area[i] = 4 * math.pi * radius**2 / (end - begin)
        guess = -1
        for n in range(begin, end):
            touching = add_scaled(centre, atoms.reach[i], point(templates.units, n))
            guess = blocker(touching, i, atoms, guess)
            if guess >= 0 and whole[i]:
                break
            if guess >= 0 or is_enclosed(touching, i, rolling, left_out):
                continue
            is_free[m + n - begin] = True
            n_dots[i] += 1
            counted[i] += area[i]
        m += end - begin
    return is_free, area, counted


@njit()
def _contact_dots(
    atoms: RolledAtoms,
    is_free: np.ndarray,
    templates: Templates,
    probe: float,
    area: np.ndarray,
    slot: np.ndarray,
    origin: np.ndarray,
    atom_of_owner: np.ndarray,
    dots: Dots,
) -> None:
    """Write the dots of each atom that are free, of an area (A,) by atom, to their places `slot`."""
    m = 0
    for i in range(len(atoms.centre)):
        radius, centre = atoms.reach[i] - probe, point(atoms.centre, i)
        for n in slots(templates.first, templates.of_atom[i]):
            if is_free[m]:
                unit = point(templates.units, n)
                position = add_scaled(centre, radius, unit)
                _write(dots, slot, i, position, unit, area[i], CONTACT, origin, atom_of_owner)
            m += 1


@njit()
def band_area(radius: float, probe: float, turn: float, low: float, high: float) -> float:
    """Return the area between two thetas on an arc of angle `turn`."""
    return turn * probe * (radius * (high - low) - probe * (math.sin(high) - math.sin(low)))


@njit()
def _n_dots_of_strip(radius: float, turn: float, spacing: float) -> int:
    """Return the number of dots on a part of a circle."""
    return int(radius * turn / spacing + 0.5)


@njit()
def bands(arc: np.ndarray, probe: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the two ranges of theta of an arc; the first is empty unless the torus intersects itself (spindle)."""
    low, high = arc[THETA_I], arc[THETA_J]
    if arc[ARC_RADIUS] >= probe:
        return (low, low), (low, high)
    cusp = math.acos(arc[ARC_RADIUS] / probe)
    return (low, min(high, -cusp)), (max(low, cusp), high)


@njit()
def _saddle_dots(
    arcs: np.ndarray,
    pair: np.ndarray,
    probe: float,
    spacing: float,
    exact: bool,
    slot: np.ndarray,
    origin: np.ndarray,
    atom_of_owner: np.ndarray,
    dots: Dots,
) -> None:
    """Write the dots of the arcs, last arc first, in strips of equal width in theta, from atom j to atom i.

    They go to their places `slot` (A,); without room they are only counted.
    """
    counts = len(dots.area) == 0
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
                if counts:
                    slot[owner] += n
                    filled += n > 0
                    continue
                # The dots of a strip face the gaps of the previous one
                offset = 0.5 if filled % 2 == 0 else 1.0
                filled += n > 0
                for m in range(n):
                    phi = arc[PHI_0] + turn * (m + offset) / n
                    outward = scaled(math.cos(phi), vector_at(arc, E1))
                    outward = add_scaled(outward, math.sin(phi), vector_at(arc, E2))
                    normal = scaled(math.cos(theta), outward)
                    normal = add_scaled(normal, -math.sin(theta), vector_at(arc, U))
                    position = add_scaled(add_scaled(vector_at(arc, T), radius, outward), -probe, normal)
                    _write(dots, slot, owner, position, normal, area, SADDLE, origin, atom_of_owner)


@njit()
def _count_concave_dots(
    rolling: Rolling,
    probes: PointGrid,
    units: np.ndarray,
    probe: float,
    exact: bool,
    left_out: EnclosedCentres,
    n_dots: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Find the dots of fixed probes between the directions to their three atoms, and add their number to `n_dots` (A,).

    Returns which of its three atoms owns each dot of the template of each probe, counted from 1, 0 if it is not placed, and the
    share of the dots of each probe that is kept.
    """
    centre = rolling.atoms.centre
    owners, share = np.zeros((len(rolling.probes), len(units)), np.uint8), np.ones(len(rolling.probes))
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
        n_kept, n_inside = 0, 0
        for m in range(len(units)):
            unit = point(units, m)
            if dot(ij, unit) < 0 or dot(jk, unit) < 0 or dot(ki, unit) < 0:
                continue
            position = add_scaled(probe_centre, probe, unit)
            # Only points beyond that plane can lie inside another probe
            beyond = probe * dot(n, unit) > h
            within = probe - INSIDE_TOLERANCE
            if exact and beyond and _inside_other(position, q, rolling, probes, within, left_out):
                n_inside += 1
                continue
            owner = 0
            for other in range(1, 3):
                to_owner = squared_distance(point(centre, rolling.triple[q, owner]), position)
                if squared_distance(point(centre, rolling.triple[q, other]), position) < to_owner:
                    owner = other
            owners[q, m] = owner + 1
            n_dots[rolling.triple[q, owner]] += 1
            n_kept += 1
        if n_inside > 0:
            share[q] = n_kept / (n_kept + n_inside)
    return owners, share


@njit()
def _concave_dots(
    rolling: Rolling,
    owners: np.ndarray,
    units: np.ndarray,
    probe: float,
    area: float,
    slot: np.ndarray,
    origin: np.ndarray,
    atom_of_owner: np.ndarray,
    dots: Dots,
) -> None:
    """Write the dots of fixed probes that have owners, each of an area, to the places `slot` (A,) of these."""
    for q in range(len(owners)):
        for m in range(len(units)):
            if owners[q, m] > 0:
                unit, owner = point(units, m), rolling.triple[q, owners[q, m] - 1]
                position = add_scaled(point(rolling.probes, q), probe, unit)
                inward = (-unit[0], -unit[1], -unit[2])
                _write(dots, slot, owner, position, inward, area, CONCAVE, origin, atom_of_owner)


@njit()
def _inside_other(
    position: Vector, q: int, rolling: Rolling, probes: PointGrid, within: float, left_out: EnclosedCentres
) -> bool:
    """Return whether an accessible centre other than fixed probe q is nearer than `within`; fixed probes are tested first."""
    columns = columns_around(probes.lattice, position, probes.lattice.side)
    for c in range(columns.n):
        for p in in_column(probes.start, columns, c):
            k = probes.dot[p]
            near = squared_distance(point(probes.xyz, p), position) < within**2
            if near and k != q and not left_out.probes[k]:
                return True
    atoms, grid = rolling.atoms, rolling.grid
    columns = columns_around(grid.lattice, position, grid.lattice.side)
    for c in range(columns.n):
        for p in in_column(grid.start, columns, c):
            k = grid.dot[p]
            centre, reach = point(atoms.centre, k), atoms.reach[k]
            w = subtract(position, centre)
            d = math.sqrt(dot(w, w))
            if d > reach + within:
                continue
            for b in slots(rolling.first_arc, k):
                if not left_out.arcs[b] and _arc_within(position, rolling.arcs[b], within):
                    return True
            # The patch of k is nearest straight outwards from its centre
            if reach - within < d < reach:
                nearest = add_scaled(centre, reach / d, w)
                if blocker(nearest, k, atoms, -1) < 0 and not is_enclosed(nearest, k, rolling, left_out):
                    return True
    return False


@njit()
def _arc_within(position: Vector, arc: np.ndarray, within: float) -> bool:
    """Return whether the point of the arc's circle nearest to the position belongs to the arc and is nearer than `within`."""
    w = subtract(position, vector_at(arc, T))
    p1, p2 = dot(w, vector_at(arc, E1)), dot(w, vector_at(arc, E2))
    if (math.hypot(p1, p2) - arc[ARC_RADIUS]) ** 2 + dot(w, vector_at(arc, U)) ** 2 >= within**2:
        return False
    phi = math.atan2(p2, p1) - arc[PHI_0]
    return phi - 2 * math.pi * math.floor(phi / (2 * math.pi)) <= arc[PHI_1] - arc[PHI_0]
