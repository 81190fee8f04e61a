"""Connected components of a molecular surface: the outside of each molecule, and its cavities.

Two dots belong to one component if the probe that touches the first can roll to the second: a cavity is what a probe can
neither enter nor leave. So the components are those of the positions of the probe's centre, not of the dots: two cavities may
meet at a cusp where their probes overlap, and yet no probe passes. Arcs that meet at a fixed probe belong together, and so do
the loops of arcs that bound one accessible patch of an atom.
"""

from __future__ import annotations

import logging
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sparsurf.errors import InputError
from sparsurf.files import pluralise
from sparsurf.kernels import njit
from sparsurf.surfaces.dot_placement import Rolled, roll_checked
from sparsurf.surfaces.pieces import (
    Pieces,
    capped_part,
    capped_volumes,
    faces_of_edges,
    narrowest_handles,
    pieces_of,
    rolled_sets,
    shapes_of,
)
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.rolling_probe import (
    ARC_RADIUS,
    CLOSED,
    E1,
    E2,
    MIXED,
    OPEN,
    PHI_0,
    PHI_1,
    EnclosedCentres,
    RolledAtoms,
    Rolling,
    T,
    U,
    arcs_of_atoms,
    blocker,
    end_of_arc,
    nearest_arc,
    no_enclosed_centres,
)
from sparsurf.surfaces.surface import COMPONENT_FIELD, CONCAVE, CONTACT, SADDLE, Surface
from sparsurf.surfaces.vectors import (
    Vector,
    add_scaled,
    cross,
    dot,
    join_two,
    point,
    root_of,
    scaled,
    set_of_arcs,
    set_point,
    subtract,
    vector_at,
)

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")

AT_A_PROBE = 1e-3  # Å, between the centre that a dot's normal points to and the probe that it lies on; far above rounding
MEETING_DISTANCE = 1e-4  # Å; the end of an arc and its fixed probe differ only by rounding
SORT_DIRECTION = np.array([0.61, 0.53, 0.59])  # in which few positions have the same height
ROUNDING_OF_ANGLES = 1e-9  # of cosines and angles (rad) on the sphere of an atom, far above their rounding


def fields_without_component(surface: Surface) -> dict[str, np.ndarray]:
    """Return the fields of a surface except the component, which has no mean and no value between dots."""
    return {name: values for name, values in surface.fields.items() if name != COMPONENT_FIELD}


def stored_components(surface: Surface) -> np.ndarray | None:
    """Return the component of each dot, (N,) int, that a study has stored with a surface; None for a ready surface."""
    stored = surface.fields.get(COMPONENT_FIELD)
    return None if stored is None else stored.astype(int)


def components_of(
    surface: Surface, xyz: ArrayLike, radii: ArrayLike, probe: float = PROBE_RADIUS
) -> np.ndarray:
    """Find the component of every dot, (N,), the largest being 0, of a surface of spheres, (A, 3) and (A,) Å."""
    return components_of_rolled(surface, roll_checked(xyz, radii, probe))


class _Found(NamedTuple):
    """The components of a surface: sets of positions between which the probe rolls, numbered by their dots."""

    of_dots: np.ndarray  # (N,) int64
    of_faces: np.ndarray  # (F,) int64
    dots: np.ndarray  # (C,) int64, number of dots, which may be 0
    pieces: Pieces
    faces: np.ndarray  # as of `faces_of_edges`


def components_of_rolled(surface: Surface, rolled: Rolled) -> np.ndarray:
    """Return `components_of` dots that were placed with a rolled probe."""
    return _find(surface, rolled).of_dots


def _find(surface: Surface, rolled: Rolled) -> _Found:
    """Find the components of dots that were placed with a rolled probe, and of the pieces of the surface."""
    rolling, n_atoms = rolled.rolling, len(rolled.atom)
    if not rolled.exact:  # spheres that no arc bounds count as those of the exact surface
        rolled = rolled._replace(whole=np.bincount(rolling.pair.ravel(), minlength=n_atoms) == 0)
    pieces = pieces_of(rolled)
    faces = faces_of_edges(pieces)
    sets = rolled_sets(pieces, faces)
    contact, saddle = (np.flatnonzero(pieces.face_kind == kind) for kind in (CONTACT, SADDLE))
    set_of_arc = np.full(len(rolling.arcs), -1)
    set_of_arc[pieces.face_owner[saddle]] = sets[saddle]
    # no probe touches some atoms on which DMS places dots: they count to the largest component
    label, mixed = np.full(n_atoms, np.bincount(sets).argmax()), np.zeros(n_atoms, bool)
    atom = pieces.face_owner[contact]
    label[atom] = sets[contact]
    mixed[atom[sets[contact] != label[atom]]] = True
    by_atom = np.argsort(rolled.atom)
    owner = by_atom[np.searchsorted(rolled.atom, surface.atom, sorter=by_atom)]
    of_dots, doubtful = label[owner], np.flatnonzero(mixed[owner])
    arcs = np.flatnonzero(set_of_arc >= 0)
    order, first = arcs_of_atoms(rolling.pair[arcs], n_atoms)
    centres = surface.points[doubtful] - rolled.origin + rolled.probe * surface.normals[doubtful]
    of_dots[doubtful] = set_of_arc[_nearest_arcs(centres, owner[doubtful], arcs[order], first, rolling.arcs)]
    dots = np.bincount(of_dots, minlength=int(sets.max()) + 1)
    # Of components with as many dots, that with the first atom comes first
    first_atom = np.full(len(dots), n_atoms)
    np.minimum.at(first_atom, sets[contact], rolled.by_position[atom])
    order = np.lexsort((first_atom, -dots))
    number = np.argsort(order)
    return _Found(number[of_dots], number[sets], dots[order], pieces, faces)


def table_of_components(surface: Surface, rolled: Rolled | None = None) -> pd.DataFrame:
    """Tabulate the components of all dots of a rolled probe, or as they were placed, as `sparsurf.components` does."""
    import pandas as pd  # here: placing dots needs no table

    return pd.DataFrame(columns_of_components(surface, rolled)).astype({"handles": "Int64"})


def columns_of_components(surface: Surface, rolled: Rolled | None = None) -> dict[str, np.ndarray]:
    """Return the columns of `table_of_components` by name; handles are float64, and NaN where they are counted elsewhere."""
    if rolled is None:
        assert surface.origin is not None
        rolled = surface.origin.rolled
    assert rolled is not None
    found = _find(surface, rolled)
    pieces, number, dots = found.pieces, found.of_faces, found.dots
    shapes = shapes_of(rolled, pieces)
    handles, narrowest = np.full((2, len(dots)), np.nan)
    is_known = pieces.n_open == 0 and shapes.agree()
    if is_known:
        area, volume = capped_volumes(rolled, pieces, found.faces, number)
    else:
        log.warning(
            "components: four or more atoms touch one probe, so that the handles of this surface cannot be counted, and its "
            "areas and volumes are sums over its dots; move the atoms by 0.001 Å to count its handles."
        )
        area = np.bincount(found.of_dots, surface.area, len(dots))
        volume = _signed_volumes(surface, found.of_dots, len(dots))
    rows = np.arange(len(dots))
    if rolled.cavities == "remove":
        rows = np.flatnonzero((dots > 0) | (volume > 0))
    if is_known:
        kept, faces, chi = np.isin(number, rows), found.faces, shapes.chi.astype(float)
        if not kept.all():  # the borders to cavities that are left out are closed by discs
            pieces, n_discs = capped_part(pieces, faces, kept)
            faces, chi = faces_of_edges(pieces), shapes_of(rolled, pieces).chi + n_discs
        row = np.full(len(chi), len(dots))
        np.minimum.at(row, pieces.component, number[kept])
        handles[row], narrowest[row] = 1 - chi / 2, narrowest_handles(pieces, faces, chi)
    columns = {
        "component": np.arange(len(rows)),
        "dots": dots[rows],
        "area": area[rows],
        "volume": np.abs(volume[rows]),
    }
    return columns | {
        "cavity": volume[rows] < 0,
        "handles": handles[rows],
        "narrowest_handle": narrowest[rows],
    }


def _signed_volumes(surface: Surface, component: np.ndarray, n: int = 0) -> np.ndarray:
    """Return the volume that each of at least n components encloses by its dots, Å^3, negative for cavities."""
    dots = np.maximum(np.bincount(component, minlength=n), 1)
    flux = np.zeros(len(surface))
    for position, outward in zip(surface.points.T, surface.normals.T, strict=True):
        # from a point near by, small errors of closing stay small
        centre = np.bincount(component, position, n) / dots
        flux += (position - centre[component]) * outward
    return np.bincount(component, flux * surface.area / 3, n)


def summarize_components(table: pd.DataFrame | dict[str, np.ndarray]) -> dict[str, float | int]:
    """Return sums over the components of a `table_of_components`, or its columns.

    These are volume (Å^3, of the molecule), components, cavities, cavity_dots, handles (NaN if they are not known) and
    narrowest_handle (Å, or NaN).
    """
    cavity = np.asarray(table["cavity"])
    handles, narrowest = (np.asarray(table[name], float) for name in ("handles", "narrowest_handle"))
    return {
        "volume": float(np.where(cavity, -1, 1) @ np.asarray(table["volume"])),
        "components": len(cavity),
        "cavities": int(cavity.sum()),
        "cavity_dots": int(np.asarray(table["dots"])[cavity].sum()),
        "handles": float(handles[~np.isnan(handles)].sum()) if np.isfinite(handles).any() else math.nan,
        "narrowest_handle": float(np.fmin.reduce(narrowest)),
    }


def volume_in_words(sums: dict[str, float | int], unit: str = " Å^3") -> str:
    """Return the volume and the handles of `summarize_components`, as in '7,952 Å^3, 3 handles, the narrowest 0.4 Å wide'."""
    text, n, width = f"{sums['volume']:,.0f}{unit}", sums["handles"], sums["narrowest_handle"]
    if math.isnan(n):  # not known, as several atoms touch one probe
        return text
    text += f", {pluralise(int(n), 'handle')}"
    if math.isnan(width):
        return text
    return f"{text}, {'the narrowest ' if n > 1 else ''}{width:.1f} Å wide"


def on_cavities(surface: Surface, component: np.ndarray) -> np.ndarray:
    """Find the dots on walls of cavities, (N,) bool."""
    return (_signed_volumes(surface, component) < 0)[component]


def without_cavities(surface: Surface, component: np.ndarray) -> Surface:
    """Return the surface of the components that are not cavities; the order of its dots stays."""
    cavity = on_cavities(surface, component)
    return surface.take(~cavity) if cavity.any() else surface


class LabelledCentres(NamedTuple):
    """The set of centres between which the probe rolls, of each place where it touches atoms."""

    roots: np.ndarray  # (B,) int, set of each arc
    label: np.ndarray  # (A,) int, set of the centres around each atom, unless several are
    is_mixed: np.ndarray  # (A,) bool, whether several are: then the nearest arc decides
    closed: np.ndarray  # bool by set, whether the probe cannot leave
    faces_outwards: np.ndarray  # bool by set, whether it surrounds atoms, and not the probe
    is_accessible: np.ndarray  # (A,) bool, whether the apex of the atom's sphere lies in no other sphere
    meeting: np.ndarray  # (B, 2) int, the fixed probes at both ends of each arc, or -1
    order: np.ndarray  # as of EnclosedCentres
    first: np.ndarray

    def sets_at(self, rolling: Rolling, positions: np.ndarray, atoms: np.ndarray) -> np.ndarray:
        """Return the set of centres (n, 3), each of which touches an atom (n,)."""
        sets, mixed = self.label[atoms], self.is_mixed[atoms]
        nearest = _nearest_arcs(positions[mixed], atoms[mixed], self.order, self.first, rolling.arcs)
        sets[mixed] = self.roots[nearest]
        return sets


def enclosed_centres(rolling: Rolling) -> EnclosedCentres:
    """Find the centres from which the probe cannot leave.

    The highest point along x of the centres around a molecule is the apex of a sphere. That of the centres in a cavity is not:
    there the spheres lie above. What lies inside a cavity, such as an atom that touches no wall, is found from its own apex: the
    way upwards first meets the wall.
    """
    labels = label_centres(rolling)
    return _centres_in(rolling, labels, labels.closed)


def enclosed_of(rolled: Rolled) -> EnclosedCentres:
    """Find the centres in cavities whose walls are no part of the surface."""
    find = enclosed_centres if rolled.cavities == "remove" else no_enclosed_centres
    return find(rolled.rolling)


def centres_of_cavities(rolling: Rolling) -> list[EnclosedCentres]:
    """Return, for each cavity, which centres lie in it."""
    labels = label_centres(rolling)
    sets = np.unique(labels.roots[labels.closed[labels.roots]])
    numbers = np.arange(len(labels.closed))
    return [_centres_in(rolling, labels, numbers == number) for number in sets]


def centres_apart_from(
    rolling: Rolling, positions: np.ndarray, start: np.ndarray, touched: np.ndarray
) -> EnclosedCentres:
    """Return which centres belong to sets on which none of the positions (n, 3) lies.

    Position k touches the atoms touched[start[k]:start[k + 1]].
    """
    labels = label_centres(rolling)
    is_apart = np.full(len(labels.closed), True)
    is_apart[labels.sets_at(rolling, np.repeat(positions, np.diff(start), axis=0), touched)] = False
    return _centres_in(rolling, labels, is_apart)


def all_other_centres(chosen: EnclosedCentres) -> EnclosedCentres:
    """Return which centres do not lie where `chosen` ones do."""
    atoms = np.where(chosen.atoms == MIXED, MIXED, np.where(chosen.atoms == CLOSED, OPEN, CLOSED))
    return chosen._replace(arcs=~chosen.arcs, probes=~chosen.probes, atoms=atoms.astype(np.int8))


def _centres_in(rolling: Rolling, labels: LabelledCentres, chosen: np.ndarray) -> EnclosedCentres:
    """Return which centres belong to chosen sets, a bool for each."""
    arcs = chosen[labels.roots]
    probes = np.zeros(len(rolling.probes), bool)
    at_end = labels.meeting >= 0
    probes[labels.meeting[at_end]] = np.repeat(arcs[:, None], 2, axis=1)[at_end]
    states = np.where(chosen[labels.label], CLOSED, OPEN).astype(np.int8)
    without = np.diff(labels.first) == 0  # of these only spheres that touch no other have accessible centres
    states[without & ~labels.is_accessible] = OPEN
    states[labels.is_mixed] = MIXED
    return EnclosedCentres(arcs, probes, states, labels.order, labels.first)


def label_centres(rolling: Rolling) -> LabelledCentres:
    """Find the sets of centres between which the probe rolls, and those from which it cannot leave."""
    n_arcs, n_atoms = len(rolling.arcs), len(rolling.atoms.centre)
    joined, meeting = joined_arcs(rolling)
    order, first = arcs_of_atoms(rolling.pair, n_atoms)
    has_arcs = np.flatnonzero(np.diff(first))
    mixed = _atoms_of_several_sets(set_of_arcs(joined), order, first, has_arcs)
    _join_patches(joined, mixed, order, first, meeting, rolling)
    roots = set_of_arcs(joined)
    label = n_arcs + np.arange(n_atoms)
    label[has_arcs] = roots[order[first[has_arcs]]]
    is_mixed = np.zeros(n_atoms, bool)
    is_mixed[_atoms_of_several_sets(roots, order, first, has_arcs)] = True
    centre, reach = rolling.atoms.centre, rolling.atoms.reach
    apexes = centre + reach[:, None] * [1.0, 0.0, 0.0]
    is_accessible = are_accessible(apexes, rolling.atoms)
    closed, faces_outwards = np.ones(n_arcs + n_atoms, bool), np.zeros(n_arcs + n_atoms, bool)
    labels = LabelledCentres(
        roots, label, is_mixed, closed, faces_outwards, is_accessible, meeting, order, first
    )
    accessible = np.flatnonzero(is_accessible)
    label_of_apex = labels.sets_at(rolling, apexes[accessible], accessible)
    highest = np.full(n_arcs + n_atoms, -np.inf)
    np.maximum.at(highest, roots, _highest_of_arcs(rolling.arcs))
    above = apexes[accessible, 0] > highest[label_of_apex]
    outward: dict[int, int] = {}  # highest apex of each set that faces outwards
    for atom, root in zip(accessible[above].tolist(), label_of_apex[above].tolist(), strict=True):
        if root not in outward or apexes[atom, 0] > apexes[outward[root], 0]:
            outward[root] = atom
    # from above, so that whether the wall met on the way up is closed is known
    for root, atom in sorted(outward.items(), key=lambda item: -apexes[item[1], 0]):
        met, wall = _first_sphere_above(apexes[atom], centre, reach)
        closed[root] = met is not None and closed[labels.sets_at(rolling, wall[None], np.array([met]))[0]]
    faces_outwards[list(outward)] = True
    return labels


def _nearest_probes(rolling: Rolling, atoms: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Return the fixed probe at each centre (n, 3), which usually touches the atom (n,) of its dot; without loading scipy."""
    probe = np.argsort(rolling.triple.ravel(), kind="stable") // 3  # by atom
    first = np.searchsorted(np.sort(rolling.triple.ravel()), np.arange(atoms.max() + 2))
    nearest = np.empty(len(atoms), np.int64)
    by_atom = np.argsort(atoms, kind="stable")
    for dots in np.split(by_atom, np.flatnonzero(np.diff(atoms[by_atom])) + 1):
        atom = int(atoms[dots[0]])
        candidates = probe[first[atom] : first[atom + 1]]
        gap = np.full(len(dots), np.inf)
        if len(candidates):
            distance = np.linalg.norm(centres[dots, None] - rolling.probes[candidates], axis=2)
            nearest[dots], gap = candidates[distance.argmin(axis=1)], distance.min(axis=1)
        # where probes overlap, the atom nearest to a dot may be none of the three that its probe touches
        for lost in dots[gap > AT_A_PROBE].tolist():
            nearest[lost] = np.linalg.norm(rolling.probes - centres[lost], axis=1).argmin()
    return nearest


def analytical_faces(
    surface: Surface, xyz: ArrayLike, radii: ArrayLike, probe: float = PROBE_RADIUS
) -> np.ndarray:
    """Return the number of the analytical face of each dot or vertex, (N,) from 1, of a surface of spheres, (A, 3) and (A,) Å.

    The faces are the concave triangles of the fixed probes, the saddles along the arcs, and the connected patches of the
    spheres that the probe touches alone.
    """
    rolled = roll_checked(xyz, radii, probe, in_order=True)
    rolling, centres = rolled.rolling, surface.points - rolled.origin + probe * surface.normals
    owner = np.searchsorted(rolled.atom, surface.atom)
    _, meeting = joined_arcs(rolling)
    n_atoms, n_arcs, n_probes = len(rolled.atom), len(rolling.arcs), len(rolling.probes)
    order, first = arcs_of_atoms(rolling.pair, n_atoms)
    face = n_probes + 3 * n_arcs + owner  # of a sphere that touches no other
    concave = surface.kind == CONCAVE
    if concave.any():
        face[concave] = _nearest_probes(rolling, owner[concave], centres[concave])
    by_owner = np.flatnonzero(~concave)
    by_owner = by_owner[np.argsort(owner[by_owner], kind="stable")]
    for dots in np.split(by_owner, np.flatnonzero(np.diff(owner[by_owner])) + 1) if len(by_owner) else ():
        atom = int(owner[dots[0]])
        arcs = order[first[atom] : first[atom + 1]]
        if not len(arcs):
            continue
        patch = _patches_of_atom(arcs, meeting, rolling, atom)
        if _loops(arcs, meeting).any():  # of several loops, a patch is named by its lowest arc
            lowest = np.full(len(arcs), n_arcs)
            np.minimum.at(lowest, patch, arcs)
            patch = lowest[patch]
        else:
            patch = np.full(len(arcs), arcs[0])
        saddle = surface.kind[dots] == SADDLE
        several = saddle | (len(np.unique(patch)) > 1)
        nearest = np.zeros(len(dots), int)
        nearest[several] = _distances(centres[dots[several]], rolling.arcs[arcs]).argmin(axis=1)
        # an arc bounds one patch on each of its two atoms
        side = rolling.pair[patch, 0] == atom
        face[dots] = n_probes + np.where(saddle, arcs[nearest], (n_arcs + 2 * patch + side)[nearest])
    return np.unique(face, return_inverse=True)[1].ravel() + 1


def faces_of_vertices(surface: Surface) -> np.ndarray:
    """Return the number of the analytical face of each dot or vertex, (N,) from 1, as files of MSMS have it.

    Where the spheres below a surface are not known, the parts of one kind on one sphere take the place of its faces. Raise
    InputError for a surface whose atoms or kinds are not known.
    """
    if surface.atom.min() < 0 or surface.kind.min() < 0:
        raise InputError(
            "surface: a .vert file needs the atom and the kind of every vertex; use PLY or npz instead."
        )
    if surface.origin is not None:
        origin = surface.origin
        return analytical_faces(surface, origin.xyz.round(3), origin.radii, origin.rules.probe_radius)
    return np.unique(surface.kind + 3 * surface.atom.astype(np.int64), return_inverse=True)[1].ravel() + 1


def _atoms_of_several_sets(
    roots: np.ndarray, order: np.ndarray, first: np.ndarray, has_arcs: np.ndarray
) -> np.ndarray:
    """Return the atoms whose arcs belong to several sets; these are few."""
    if not len(has_arcs):
        return has_arcs
    lowest, highest = (
        extreme.reduceat(roots[order], first[has_arcs]) for extreme in (np.minimum, np.maximum)
    )
    return has_arcs[lowest != highest]


def _highest_of_arcs(arcs: np.ndarray) -> np.ndarray:
    """Return the largest x of each arc, (B,): that of its ends, or of the highest point of its circle."""
    top = np.arctan2(arcs[:, E2], arcs[:, E1])
    holds_top = (top - arcs[:, PHI_0]) % (2 * math.pi) <= arcs[:, PHI_1] - arcs[:, PHI_0]
    of_circle = arcs[:, T] + arcs[:, ARC_RADIUS] * np.hypot(arcs[:, E1], arcs[:, E2])
    return np.where(holds_top, of_circle, _ends(arcs)[:, :, 0].max(axis=1, initial=-np.inf))


def _first_sphere_above(
    position: np.ndarray, centre: np.ndarray, reach: np.ndarray
) -> tuple[int | None, np.ndarray]:
    """Return the sphere that the way upwards along x from a position meets first, and where; None if it meets none."""
    half_chord = reach**2 - ((centre[:, 1:] - position[1:]) ** 2).sum(axis=1)
    crossed = np.flatnonzero((half_chord > 0) & (centre[:, 0] > position[0]))
    if not len(crossed):
        return None, position
    entry = centre[crossed, 0] - np.sqrt(half_chord[crossed])
    return int(crossed[entry.argmin()]), np.array([entry.min(), *position[1:]])


@njit()
def are_accessible(positions: np.ndarray, atoms: RolledAtoms) -> np.ndarray:
    """Return whether the position on the sphere of each atom, (A, 3), lies in no other sphere, (A,) bool."""
    accessible = np.empty(len(positions), np.bool_)
    for atom in range(len(positions)):
        accessible[atom] = blocker(point(positions, atom), atom, atoms, -1) < 0
    return accessible


@njit()
def _join(joined: np.ndarray, first: np.ndarray, second: np.ndarray) -> None:
    """Join the sets of pairs of arcs, (n,) each."""
    for k in range(len(first)):
        join_two(joined, first[k], second[k])


def _ends(arcs: np.ndarray) -> np.ndarray:
    """Return the positions of both ends of arcs, (B, 2, 3)."""
    phi = arcs[:, PHI_0 : PHI_1 + 1, None]
    outward = np.cos(phi) * arcs[:, None, E1 : E1 + 3] + np.sin(phi) * arcs[:, None, E2 : E2 + 3]
    return arcs[:, None, T : T + 3] + arcs[:, ARC_RADIUS, None, None] * outward


def joined_arcs(rolling: Rolling) -> tuple[np.ndarray, np.ndarray]:
    """Join arcs that end at the same fixed probe: the parent of each, and the probes at its two ends, (B, 2), or -1."""
    joined = np.arange(len(rolling.arcs))
    probe_of_end = _probes_at_ends(_ends(rolling.arcs).reshape(-1, 3), rolling.probes)
    ends = np.flatnonzero(probe_of_end >= 0)
    _, first, of_probe = np.unique(probe_of_end[ends], return_index=True, return_inverse=True)
    _join(joined, ends // 2, ends[first[of_probe]] // 2)
    return joined, probe_of_end.reshape(-1, 2)


def _probes_at_ends(ends: np.ndarray, probes: np.ndarray) -> np.ndarray:
    """Return the index of the nearest probe at each end of an arc, or -1; only those near along SORT_DIRECTION are compared."""
    order = np.argsort(probes @ SORT_DIRECTION)
    height_of_probes, height_of_ends = (probes @ SORT_DIRECTION)[order], ends @ SORT_DIRECTION
    low, high = (
        np.searchsorted(height_of_probes, height_of_ends + shift)
        for shift in (-MEETING_DISTANCE, MEETING_DISTANCE)
    )
    probe_of_end, gap = np.full(len(ends), -1), np.full(len(ends), MEETING_DISTANCE)
    for step in range((high - low).max(initial=0)):
        candidates = np.flatnonzero(low + step < high)
        probe = order[low[candidates] + step]
        distance = np.linalg.norm(probes[probe] - ends[candidates], axis=1)
        # where four atoms nearly touch one probe, two fixed probes are closer to each other than MEETING_DISTANCE
        closer = distance < gap[candidates]
        probe_of_end[candidates[closer]], gap[candidates[closer]] = probe[closer], distance[closer]
    return probe_of_end


def _distances(positions: np.ndarray, arcs: np.ndarray) -> np.ndarray:
    """Return the distance (n, B), Å, of positions (n, 3) from the nearest point of arcs (B, 17)."""
    w = positions[:, None] - arcs[None, :, T : T + 3]
    p1, p2 = (w * arcs[:, E1 : E1 + 3]).sum(axis=2), (w * arcs[:, E2 : E2 + 3]).sum(axis=2)
    flat = np.hypot(p1, p2)
    to_circle = np.sqrt(np.maximum((w**2).sum(axis=2) - flat**2, 0) + (flat - arcs[:, ARC_RADIUS]) ** 2)
    is_on_arc = (np.arctan2(p2, p1) - arcs[:, PHI_0]) % (2 * math.pi) <= arcs[:, PHI_1] - arcs[:, PHI_0]
    to_ends = np.linalg.norm(positions[:, None, None] - _ends(arcs)[None], axis=3).min(axis=2)
    return np.where(is_on_arc, to_circle, to_ends)


@njit()
def _nearest_arcs(
    positions: np.ndarray, atoms: np.ndarray, order: np.ndarray, first: np.ndarray, arcs: np.ndarray
) -> np.ndarray:
    """Return, for each position (n, 3), the nearest of the arcs around an atom (n,), (n,) int64."""
    nearest = np.empty(len(positions), np.int64)
    for k in range(len(positions)):
        nearest[k] = nearest_arc(point(positions, k), atoms[k], arcs, order, first)
    return nearest


@njit()
def _join_patches(
    joined: np.ndarray,
    atoms: np.ndarray,
    order: np.ndarray,
    first: np.ndarray,
    meeting: np.ndarray,
    rolling: Rolling,
) -> None:
    """Join the arcs that bound one accessible patch of an atom, for some atoms (n,)."""
    for atom in atoms:
        arcs = order[first[atom] : first[atom + 1]]
        patch = _patches_of_atom(arcs, meeting, rolling, atom)
        for a in range(len(arcs)):
            join_two(joined, arcs[patch[a]], arcs[a])


@njit()
def _patches_of_atom(arcs: np.ndarray, meeting: np.ndarray, rolling: Rolling, atom: int) -> np.ndarray:
    """Return the accessible patch of an atom that each arc around it, (k,), bounds: the position of its first arc, (k,).

    On a sphere, loops + 1 - covered parts is the number of free parts. If there is one, all loops bound it; if there is one
    covered part, each loop bounds its own. Otherwise those belong together between which a great circle crosses the free part
    alone.
    """
    patch = _loops(arcs, meeting)
    n_loops = len(np.unique(patch))
    if n_loops > 1:
        axis, half = _covering_caps(rolling.atoms, atom)
        n_covered = _n_covered_parts(axis, half)
        if n_loops == n_covered:
            patch[:] = 0
        elif n_covered > 1:
            _join_facing(patch, n_covered - 1, arcs, rolling, atom, axis, half)
    return set_of_arcs(patch)


@njit()
def _loops(arcs: np.ndarray, meeting: np.ndarray) -> np.ndarray:
    """Return the loop of each arc around one atom: arcs that meet at fixed probes, or a whole circle."""
    loop = np.arange(len(arcs))
    for a in range(len(arcs)):
        for b in range(a):
            for end in meeting[arcs[a]]:
                if end >= 0 and (end == meeting[arcs[b], 0] or end == meeting[arcs[b], 1]):
                    join_two(loop, a, b)
    return set_of_arcs(loop)


@njit()
def _covering_caps(atoms: RolledAtoms, atom: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the parts of an atom's sphere that its neighbours cover: unit axes (n, 3) and half angles (n,), rad."""
    near, reach = atoms.near[atoms.start[atom] : atoms.start[atom + 1]], atoms.reach[atom]
    axis, half, n = np.empty((len(near), 3)), np.empty(len(near)), 0
    for k in near:
        v = subtract(point(atoms.centre, k), point(atoms.centre, atom))
        d = math.sqrt(dot(v, v))
        cosine = (d**2 + reach**2 - atoms.reach[k] ** 2) / (2 * d * reach)
        if abs(cosine) < 1:
            axis[n, 0], axis[n, 1], axis[n, 2], half[n] = v[0] / d, v[1] / d, v[2] / d, math.acos(cosine)
            n += 1
    return axis[:n], half[:n]


@njit()
def _n_covered_parts(axis: np.ndarray, half: np.ndarray) -> int:
    """Count the connected parts that caps with unit axes (n, 3) and half angles (n,), rad, cover."""
    joined, n = np.arange(len(half)), len(half)
    for a in range(len(half)):
        for b in range(a):
            if root_of(joined, a) != root_of(joined, b):
                cosine = min(1.0, max(-1.0, dot(point(axis, a), point(axis, b))))
                if math.acos(cosine) < half[a] + half[b]:
                    join_two(joined, a, b)
                    n -= 1
    return n


@njit()
def _join_facing(
    loop: np.ndarray,
    n_joins: int,
    arcs: np.ndarray,
    rolling: Rolling,
    atom: int,
    axis_of_cap: np.ndarray,
    half_of_cap: np.ndarray,
) -> None:
    """Join the loops of arcs (k,), at most so often, between which the shortest way on the sphere of an atom is free.

    Of two sets of loops around one free part, the points nearest to one another are joined by a part of a great circle that
    crosses no covered part, as it would end there earlier. These points are the ends of arcs, or the points of two arcs, or of an
    arc and an end, on the great circle through the axes. So all these ways are tried, and none has to be sampled.
    """
    points, owner = _points_on_borders(loop, arcs, rolling, atom)
    cosine_of_cap = np.cos(half_of_cap) + ROUNDING_OF_ANGLES
    for b in range(len(points)):
        for a in range(b):
            if n_joins == 0:
                return
            if root_of(loop, owner[a]) != root_of(loop, owner[b]) and _is_free(
                point(points, a), point(points, b), axis_of_cap, cosine_of_cap
            ):
                join_two(loop, owner[a], owner[b])
                n_joins -= 1


@njit()
def _points_on_borders(
    loop: np.ndarray, arcs: np.ndarray, rolling: Rolling, atom: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions (m, 3) of the ends of arcs (k,), and of their points towards the other loops, and the arc of each."""
    n_arcs, m = len(arcs), 0
    # both ends and the axis; rad, between axis and circle
    towards, half = np.empty((n_arcs, 3, 3)), np.empty(n_arcs)
    points, owner = np.empty((2 * n_arcs + 6 * n_arcs**2, 3)), np.empty(2 * n_arcs + 6 * n_arcs**2, np.int64)
    centre, reach = point(rolling.atoms.centre, atom), rolling.atoms.reach[atom]
    for a in range(n_arcs):
        arc = rolling.arcs[arcs[a]]
        sign = 1.0 if rolling.pair[arcs[a], 0] == atom else -1.0
        to_circle = subtract(vector_at(arc, T), centre)
        half[a] = math.atan2(arc[ARC_RADIUS], sign * dot(to_circle, vector_at(arc, U)))
        for e in range(3):
            v = vector_at(arc, U) if e == 2 else subtract(end_of_arc(arc, PHI_0 + e), centre)
            size = sign if e == 2 else math.sqrt(dot(v, v))
            for c in range(3):
                towards[a, e, c] = v[c] / size
            if e < 2:
                set_point(points, m, point(towards[a], e))
                owner[m], m = a, m + 1
    for a in range(n_arcs):
        for b in range(n_arcs):
            for e in range(3 if loop[a] != loop[b] else 0):
                for side in (1.0, -1.0):
                    on_circle = _on_circle(point(towards[a], 2), half[a], point(towards[b], e), side)
                    if _is_on_arc(add_scaled(centre, reach, on_circle), rolling.arcs[arcs[a]]):
                        set_point(points, m, on_circle)
                        owner[m], m = a, m + 1
    return points[:m], owner[:m]


@njit()
def _on_circle(axis: Vector, half: float, target: Vector, side: float) -> Vector:
    """Return the point of a circle that lies in the plane of its axis and a target, towards it or away from it."""
    across = add_scaled(target, -dot(target, axis), axis)
    if dot(across, across) < ROUNDING_OF_ANGLES**2:  # then all points of the circle are equally near
        x, y, z = abs(axis[0]), abs(axis[1]), abs(axis[2])
        least = min(x, y, z)
        other = (1.0, 0.0, 0.0) if x == least else (0.0, 1.0, 0.0) if y == least else (0.0, 0.0, 1.0)
        across = cross(axis, other)
    across = scaled(side * math.sin(half) / math.sqrt(dot(across, across)), across)
    return add_scaled(across, math.cos(half), axis)


@njit()
def _is_on_arc(position: Vector, arc: np.ndarray) -> bool:
    """Return whether a point of an arc's circle lies on the arc, or at its ends up to rounding."""
    w = subtract(position, vector_at(arc, T))
    phi = math.atan2(dot(w, vector_at(arc, E2)), dot(w, vector_at(arc, E1))) - arc[PHI_0] + ROUNDING_OF_ANGLES
    turn = phi - 2 * math.pi * math.floor(phi / (2 * math.pi))
    return turn <= arc[PHI_1] - arc[PHI_0] + 2 * ROUNDING_OF_ANGLES


@njit()
def _is_free(first: Vector, last: Vector, axis: np.ndarray, cosine_of_cap: np.ndarray) -> bool:
    """Return whether the shorter great circle between two directions leaves out all caps around axes, (n, 3)."""
    cosine = min(1.0, max(-1.0, dot(first, last)))
    across = add_scaled(last, -cosine, first)
    size = max(math.sqrt(dot(across, across)), ROUNDING_OF_ANGLES)
    length = math.acos(cosine)
    for c in range(len(axis)):
        of_cap = point(axis, c)
        a, b = dot(first, of_cap), dot(across, of_cap) / size
        # The point of the circle that is nearest to the axis lies between both directions, or one of these is nearest
        nearest = max(a, dot(last, of_cap))
        if b > 0.0 and math.atan2(b, a) < length:
            nearest = math.hypot(a, b)
        if nearest > cosine_of_cap[c]:
            return False
    return True
