"""Place dots on the patches of the solvent-excluded surface, each where the program DMS places it.

DMS's manual does not say how it places dots. The rules here were read off its output (A1 of TDP-43 and 1a1u
chain A at `-d 1.0`), whose dots and order they give again: dots sit on rows sqrt(3)/2 d apart and every d
along a row, as in a hexagonal lattice of 5.5 dots per Å^2 (d = 0.458 Å); atoms are taken by x, then y, then z.
Surface: Connolly, J. Appl. Cryst. 16:548 (1983). Lengths in Å, areas in Å^2, angles in rad.
"""

import logging
import math
from typing import NamedTuple

import numpy as np
from numba import njit

from sparsurf import InputError
from sparsurf.surfaces.rolling_probe import (
    E1,
    E2,
    PHI_0,
    PHI_1,
    RADIUS,
    THETA_I,
    THETA_J,
    T,
    U,
    blocker,
    cutting,
    roll,
)
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE
from sparsurf.surfaces.vectors import along, apart2, cells_of, column, cross, dot, grown, minus, part, point

log = logging.getLogger("sparsurf")

FARTHEST = 1e6  # Å, largest coordinate
LARGEST = 100  # Å, atomic radius
_told = set()  # warnings that were given: once for all surfaces of the same atoms
# Dots per Å^2 of the lattice of DMS at `-d 1.0`; the surface of a protein gets 3 % fewer.
LATTICE = 5.5
# Distance of the rings of a sphere in units of that of the dots; 0.899 to 0.914 give the rings of all radii seen.
RING_SPACING = 0.906

# Half width of the uniform shift of every centre. It takes atoms out of special position (four and more that
# touch one probe), far above rounding (1e-13 Å) and far below anything that a dot's place is good for.
SHIFT = 1e-8
SHIFT_SEED = 1
# A concave dot is inside another probe when it is nearer to its centre than the radius by this much.
INSIDE = 1e-9


class Dots(NamedTuple):
    """Dots of one kind in the order in which they were placed."""

    rows: np.ndarray  # (N, 7) float64: place, outward normal, area
    atom: np.ndarray  # (N, 1) int64, owner


def place_dots(xyz, radii, probe, density, exact):
    """Dots of the solvent-excluded surface, grouped by atom; concave, saddle, contact in each.

    Parameters
    ----------
    xyz : (A, 3) float64, distinct places, Å
    radii : (A,) float64, Å
    probe : probe radius, Å
    density : dots per Å^2 of the lattice
    exact : drop the concave dots that lie inside another probe, and give the area of strips too
        narrow for a dot to dots of their own; otherwise do neither, as DMS

    Returns
    -------
    points (N, 3), normals (N, 3), area (N,), kind (N,) int8, atom (N,) int32
    """
    relative, shift = relative_places(xyz)
    by_place = np.lexsort(relative.T[::-1])
    radii = radii[by_place]
    spacing = math.sqrt(2 / math.sqrt(3) / density)
    rolling = roll((relative + shift)[by_place], radii + probe)
    blockers = rolling.atoms if exact else cutting(rolling.atoms)
    contact = _contact_dots(blockers, *_templates(radii, spacing), probe)
    saddle = _saddle_dots(rolling, probe, spacing, exact)
    probe_cells = cells_of(some_probes(rolling.probes), probe)
    concave, share = _concave_dots(rolling, probe_cells, template(probe, spacing), probe, exact)
    if exact:
        _set_exact_areas(contact, concave, share, rolling, radii, probe)
    dots = {CONCAVE: concave, SADDLE: saddle, CONTACT: contact}
    rows = np.concatenate([each.rows for each in dots.values()])
    atom = by_place[np.concatenate([each.atom[:, 0] for each in dots.values()])]
    kind = np.repeat(np.array(list(dots), np.int8), [len(each.atom) for each in dots.values()])
    by_atom = np.argsort(atom, kind="stable")
    rows = rows[by_atom]
    return rows[:, :3] + xyz[0], rows[:, 3:6], rows[:, 6], kind[by_atom], atom[by_atom].astype(np.int32)


def spheres(xyz, radii, probe):
    """Centres and radii of distinct atoms, checked, and which of the given ones these are; see `molecular_surface`."""
    xyz, radii = np.asarray(xyz, dtype=float), np.asarray(radii, dtype=float)
    if xyz.ndim != 2 or xyz.shape[1] != 3 or len(xyz) == 0 or radii.shape != (len(xyz),):
        raise InputError(f"surface: needs (A, 3) centres and (A,) radii, not {xyz.shape} and {radii.shape}.")
    if not (np.abs(xyz) < FARTHEST).all():
        raise InputError(f"surface: coordinates must be numbers below {FARTHEST:.0f} Å.")
    if not ((radii > 0) & (radii <= LARGEST)).all():
        raise InputError(f"surface: atomic radii must be positive numbers of at most {LARGEST} Å.")
    if not 0 < probe < np.inf:
        raise InputError(f"surface.probe_radius is {probe}; it must be a positive number.")
    kept = _distinct(xyz, radii)
    return xyz[kept], radii[kept], kept


def _distinct(xyz, radii):
    """Indices of the atoms without those at the place of another (to 0.001 Å); the largest of each stays."""
    _, place = np.unique(np.round(xyz - xyz[0], 3), axis=0, return_inverse=True)
    by_place = np.lexsort((-radii, place))
    first = np.append(True, np.diff(place[by_place]) != 0)
    left_out = np.sort(by_place[~first])
    if len(left_out):
        told = len(left_out), int(left_out[0]) + 1
        if told not in _told:
            _told.add(told)
            message = (
                "surface: atoms that lie at the place of another are left out (%d), the first is number %d"
            )
            log.warning(message, *told)
    return np.sort(by_place[first])


def relative_places(xyz):
    """Places (A, 3) relative to the first, on a grid of 1e-9 Å so that translated input gives the same numbers; a shift of
    each, (A, 3), at most `SHIFT`."""
    relative = np.round(xyz - xyz[0], 9)
    return relative, np.random.default_rng(SHIFT_SEED).uniform(-SHIFT, SHIFT, relative.shape)


def _set_exact_areas(contact, concave, share, rolling, radii, probe):
    """Replace the counted areas of contact and concave dots by exact ones (Gauss-Bonnet), in place.

    The contact patches of an atom share their area out among their dots; the concave triangles, of which
    only the part `share` (P,) is left, do so all together, since many hold no dot.

    Parameters
    ----------
    contact, concave : Dots, placed
    share : (P,) float64, part of the dots of each triangle that is left
    rolling : Rolling
    radii : (A,) float64, Å
    probe : Å
    """
    centre, n = rolling.atoms.centre, len(radii)
    # Corners of the spherical triangles: angles between the planes through the probe and two of its atoms.
    to_atoms = centre[rolling.triple] - rolling.probes[:, None]
    normals = np.cross(to_atoms, np.roll(to_atoms, -1, axis=1))
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-300)
    corners = np.arccos(np.clip(-(normals * np.roll(normals, 1, axis=1)).sum(axis=2), -1, 1))
    if len(concave.rows):
        triangles = probe**2 * (corners.sum(axis=1) - math.pi)
        concave.rows[:, 6] *= (share * triangles).sum() / concave.rows[:, 6].sum()
    # A patch on a unit sphere has the area 2 pi chi - (what its border turns); chi from the counted area.
    arcs, pair = rolling.arcs, rolling.pair
    length = arcs[:, PHI_1] - arcs[:, PHI_0]
    turned = np.zeros(n) + np.bincount(rolling.triple.ravel(), corners.ravel(), n)
    turned += np.bincount(pair[:, 0], np.sin(arcs[:, THETA_I]) * length, n)
    turned -= np.bincount(pair[:, 1], np.sin(arcs[:, THETA_J]) * length, n)
    owner, counted = contact.atom[:, 0], np.bincount(contact.atom[:, 0], contact.rows[:, 6], n)
    chi = np.round((counted / radii**2 + turned) / (2 * math.pi))
    area = np.maximum(radii**2 * (2 * math.pi * chi - turned), 0)
    if len(owner):
        seen = counted > 0
        contact.rows[:, 6] *= (area[seen] / counted[seen])[np.cumsum(seen)[owner] - 1]
        contact.rows[:, 6] *= area.sum() / area[seen].sum()


def template(radius, spacing):
    """Unit vectors of the dots of a whole sphere, (n, 3): rings from the north pole, none at the south pole."""
    n_rings = max(1, int(math.pi * radius / (RING_SPACING * spacing) + 0.5))
    rings = [np.array([[0.0, 0.0, 1.0]])]
    for ring in range(1, n_rings):
        theta = math.pi * ring / n_rings
        n = max(1, int(2 * math.pi * radius * math.sin(theta) / spacing + 0.5))
        phi = 2 * math.pi * np.arange(n) / n + (0.0 if ring % 2 else math.pi)
        unit = np.column_stack([np.cos(phi), np.sin(phi), np.zeros(n)])
        rings.append(math.sin(theta) * unit + [0, 0, math.cos(theta)])
    return np.concatenate(rings)


def _templates(radii, spacing):
    """Templates of all distinct radii in one (n, 3) array, first row of each, and the template of each atom."""
    distinct, which = np.unique(radii, return_inverse=True)
    parts = [template(float(radius), spacing) for radius in distinct]
    first = np.concatenate([[0], np.cumsum([len(part) for part in parts])])
    return np.concatenate(parts), first, which.astype(np.int64)


def some_probes(probes):
    """Cells cannot be made of nothing: a far place stands for no probe at all."""
    return probes if len(probes) else np.full((1, 3), 1e9)


@njit(cache=True, nogil=True)
def _write(rows, atom, n, place, normal, area, owner):
    """Fill row n of the dots."""
    for a in range(3):
        rows[n, a], rows[n, 3 + a] = place[a], normal[a]
    rows[n, 6], atom[n, 0] = area, owner


@njit(cache=True, nogil=True)
def _contact_dots(atoms, units, first, which, probe):
    """Dots of every atom at which a touching probe is free."""
    rows, atom, total = np.empty((64, 7)), np.empty((64, 1), np.int64), 0
    for i in range(len(atoms.centre)):
        radius, centre = atoms.reach[i] - probe, point(atoms.centre, i)
        begin, end = first[which[i]], first[which[i] + 1]
        guess = -1
        for n in range(begin, end):
            unit = point(units, n)
            guess = blocker(along(centre, atoms.reach[i], unit), i, atoms, guess)
            if guess >= 0:
                continue
            if total == len(rows):
                rows, atom = grown(rows), grown(atom)
            area = 4 * math.pi * radius**2 / (end - begin)
            _write(rows, atom, total, along(centre, radius, unit), unit, area, i)
            total += 1
    return Dots(rows[:total], atom[:total])


@njit(cache=True, nogil=True)
def _band_area(radius, probe, turn, low, high):
    """Area between two thetas on an arc of angle `turn`."""
    return turn * probe * (radius * (high - low) - probe * (math.sin(high) - math.sin(low)))


@njit(cache=True, nogil=True)
def _strip_dots(radius, turn, spacing):
    """Number of dots on a part of a circle."""
    return int(radius * turn / spacing + 0.5)


@njit(cache=True, nogil=True)
def _bands(arc, probe):
    """The two ranges of theta of an arc, the first one empty unless the torus cuts itself (spindle)."""
    low, high = arc[THETA_I], arc[THETA_J]
    if arc[RADIUS] >= probe:
        return (low, low), (low, high)
    cusp = math.acos(arc[RADIUS] / probe)
    return (low, min(high, -cusp)), (max(low, cusp), high)


@njit(cache=True, nogil=True)
def _saddle_dots(rolling, probe, spacing, exact):
    """Dots of the arcs, last arc first: strips of equal width in theta, from atom j to atom i."""
    rows, atom, total = np.empty((64, 7)), np.empty((64, 1), np.int64), 0
    row_spacing = spacing * math.sqrt(0.75)
    cell, carried = spacing * row_spacing, 0.0
    for b in range(len(rolling.arcs) - 1, -1, -1):
        arc = rolling.arcs[b]
        radius, turn = arc[RADIUS], arc[PHI_1] - arc[PHI_0]
        for low, high in _bands(arc, probe):
            if high <= low:
                continue
            n_strips = max(1, int(probe * (high - low) / row_spacing + 0.5))
            width = (high - low) / n_strips
            n_filled, n_band = 0, 0
            for strip in range(n_strips):
                n = _strip_dots(radius - probe * math.cos(high - (strip + 0.5) * width), turn, spacing)
                n_filled, n_band = n_filled + (n > 0), n_band + n
            filled = 0
            for strip in range(n_strips):
                theta = high - (strip + 0.5) * width
                n = _strip_dots(radius - probe * math.cos(theta), turn, spacing)
                if exact:
                    area = _band_area(radius, probe, turn, theta - width / 2, theta + width / 2) / max(n, 1)
                    owner = rolling.pair[b, int(2 * theta > arc[THETA_I] + arc[THETA_J])]
                    if n == 0:
                        # Too narrow for a dot: one for every `cell` of such strips, as soon as half of it is due.
                        carried += area
                        if carried < 0.5 * cell:
                            continue
                        n, area, carried = 1, cell, carried - cell
                else:
                    area = _band_area(radius, probe, turn, low, high) / max(n_band, 1)
                    owner = rolling.pair[b, int(2 * filled < n_filled)]
                # The dots of a strip face the gaps of the one before.
                offset = 0.5 if filled % 2 == 0 else 1.0
                filled += n > 0
                for m in range(n):
                    phi = arc[PHI_0] + turn * (m + offset) / n
                    outward = along((0.0, 0.0, 0.0), math.cos(phi), part(arc, E1))
                    outward = along(outward, math.sin(phi), part(arc, E2))
                    normal = along((0.0, 0.0, 0.0), math.cos(theta), outward)
                    normal = along(normal, -math.sin(theta), part(arc, U))
                    place = along(along(part(arc, T), radius, outward), -probe, normal)
                    if total == len(rows):
                        rows, atom = grown(rows), grown(atom)
                    _write(rows, atom, total, place, normal, area, owner)
                    total += 1
    return Dots(rows[:total], atom[:total])


@njit(cache=True, nogil=True)
def _concave_dots(rolling, probe_cells, units, probe, exact):
    """Dots of the fixed probes in the triangle spanned by the directions to their three atoms.

    With them, the share of each triangle's dots that was kept.
    """
    centre = rolling.atoms.centre
    rows, atom, total = np.empty((64, 7)), np.empty((64, 1), np.int64), 0
    share = np.ones(len(rolling.probes))
    area = 4 * math.pi * probe**2 / len(units)
    for q in range(len(rolling.probes)):
        i, j, k = point(rolling.triple, q)
        c = point(rolling.probes, q)
        to_i, to_j, to_k = minus(point(centre, i), c), minus(point(centre, j), c), minus(point(centre, k), c)
        if dot(cross(to_i, to_j), to_k) < 0:
            to_j, to_k = to_k, to_j
        ij, jk, ki = cross(to_i, to_j), cross(to_j, to_k), cross(to_k, to_i)
        # The plane of the atoms is n.v = h for directions v from the probe.
        n, h = along(along(ij, 1.0, jk), 1.0, ki), dot(ij, to_k)
        before, eaten = total, 0
        for m in range(len(units)):
            unit = point(units, m)
            if dot(ij, unit) < 0 or dot(jk, unit) < 0 or dot(ki, unit) < 0:
                continue
            place = along(c, probe, unit)
            # Only what lies beyond that plane can lie inside another probe.
            beyond = probe * dot(n, unit) > h
            if exact and beyond and _inside_other(place, q, rolling, probe_cells, probe - INSIDE):
                eaten += 1
                continue
            owner = i
            for other in (j, k):
                if apart2(point(centre, other), place) < apart2(point(centre, owner), place):
                    owner = other
            if total == len(rows):
                rows, atom = grown(rows), grown(atom)
            _write(rows, atom, total, place, (-unit[0], -unit[1], -unit[2]), area, owner)
            total += 1
        if eaten > 0:
            share[q] = (total - before) / (total - before + eaten)
    return Dots(rows[:total], atom[:total]), share


@njit(cache=True, nogil=True)
def _inside_other(place, q, rolling, probe_cells, within):
    """Is an accessible centre other than fixed probe q nearer than `within`? Points, then arcs and patches."""
    for c in range(9):
        slot, last = column(probe_cells, place, c)
        while slot < len(probe_cells.key) and probe_cells.key[slot] <= last:
            k = probe_cells.order[slot]
            slot += 1
            if k != q and apart2(point(rolling.probes, k), place) < within**2:
                return True
    atoms, cells = rolling.atoms, rolling.cells
    for c in range(9):
        slot, last = column(cells, place, c)
        while slot < len(cells.key) and cells.key[slot] <= last:
            k = cells.order[slot]
            slot += 1
            centre, reach = point(atoms.centre, k), atoms.reach[k]
            w = minus(place, centre)
            d = math.sqrt(dot(w, w))
            if d > reach + within:
                continue
            for b in range(rolling.first_arc[k], rolling.first_arc[k + 1]):
                if _arc_within(place, rolling.arcs[b], within):
                    return True
            # The patch of k comes nearest straight outwards from its centre.
            if reach - within < d < reach and blocker(along(centre, reach / d, w), k, atoms, -1) < 0:
                return True
    return False


@njit(cache=True, nogil=True)
def _arc_within(place, arc, within):
    """Is the inner point of the arc that is nearest to the place nearer than `within`?"""
    w = minus(place, part(arc, T))
    p1, p2 = dot(w, part(arc, E1)), dot(w, part(arc, E2))
    if (math.hypot(p1, p2) - arc[RADIUS]) ** 2 + dot(w, part(arc, U)) ** 2 >= within**2:
        return False
    phi = math.atan2(p2, p1) - arc[PHI_0]
    return phi - 2 * math.pi * math.floor(phi / (2 * math.pi)) < arc[PHI_1] - arc[PHI_0]
