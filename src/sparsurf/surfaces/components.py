"""Connected components of a molecular surface: the outside of each molecule, and its cavities.

They follow from where the probe can stand, not from the distances of dots. Arcs that meet at a fixed probe belong
together. So do the loops of arcs that bound one accessible patch of an atom, and a fixed probe with everything that
intersects its concave triangle.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.dot_placement import RolledProbe, checked_spheres, roll_probe
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.rolling_probe import E1, E2, PHI_0, PHI_1, RADIUS, Atoms, Rolling, T
from sparsurf.surfaces.surface import COMPONENT_FIELD, Surface

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike

MEETING_DISTANCE = 1e-4  # Å; the end of an arc and its fixed probe differ only by rounding
ARC_STEP = 0.3  # Å, between positions that represent an arc
SORT_DIRECTION = np.array([0.61, 0.53, 0.59])  # in which few positions have the same height
NEIGHBOUR_DISTANCE = 1.0  # Å, of neighbouring dots on one patch


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
    xyz, radii, kept = checked_spheres(xyz, radii, probe)
    return components_of_rolled(surface, roll_probe(xyz, radii, float(probe), True), kept)


def components_of_rolled(surface: Surface, rolled: RolledProbe, kept: np.ndarray) -> np.ndarray:
    """Return `components_of` dots that were placed with a rolled probe; `kept` (K,) are its atoms among those of the dots."""
    rolling, probe, n_atoms = _in_order_of_atoms(rolled), rolled.probe, len(kept)
    centres = surface.points - rolled.origin + probe * surface.normals
    rank = np.empty(n_atoms, np.int64)
    rank[rolled.by_position] = np.arange(n_atoms)
    owner = rank[np.searchsorted(kept, surface.atom)]
    joined, meeting = _joined_arcs(rolling)
    n_arcs = len(joined)
    order, first = _arcs_of_atoms(rolling.pair, n_atoms)
    has_arcs = np.flatnonzero(np.diff(first))
    label = n_arcs + rolled.by_position  # by atom; it stays that of a sphere that touches no other
    label[has_arcs] = order[first[has_arcs]]
    roots = _roots(joined)[order]
    mixed = np.zeros(n_atoms, bool)
    if len(has_arcs):
        lowest, highest = (of.reduceat(roots, first[has_arcs]) for of in (np.minimum, np.maximum))
        mixed[has_arcs] = lowest != highest  # few atoms have arcs of several sets
    labels = label[owner]
    doubtful = np.flatnonzero(mixed[owner])
    doubtful = doubtful[np.argsort(owner[doubtful], kind="stable")]
    for dots in np.split(doubtful, np.flatnonzero(np.diff(owner[doubtful])) + 1) if len(doubtful) else ():
        atom = owner[dots[0]]
        arcs = order[first[atom] : first[atom + 1]]
        nearest = arcs[_distances(centres[dots], rolling.arcs[arcs]).argmin(axis=1)]
        _join_loops(joined, arcs, nearest, centres[dots], meeting, rolling.atoms, atom)
        labels[dots] = nearest
    _join_cusps(joined, rolling, probe, meeting)
    roots = np.append(_roots(joined), np.arange(n_atoms) + n_arcs)
    _, labels, count = np.unique(roots[labels], return_inverse=True, return_counts=True)
    return np.argsort(np.argsort(-count, kind="stable"))[labels]


def _in_order_of_atoms(rolled: RolledProbe) -> Rolling:
    """Return a Rolling with the arcs in the order of the atoms as given, which numbers components with as many dots."""
    rolling = rolled.rolling
    low = rolled.by_position[rolling.pair].min(axis=1)
    a, b = (rolling.atoms.centre[rolling.pair[:, k]] for k in range(2))
    order = np.lexsort((((a - b) ** 2).sum(axis=1), low))
    return rolling._replace(arcs=rolling.arcs[order], pair=rolling.pair[order])


def table_of_components(surface: Surface, component: np.ndarray) -> pd.DataFrame:
    """Tabulate the components (N,): dots, area (Å²), volume (Å³) and whether each is a cavity, whose normals point inwards."""
    import pandas as pd  # here: placing dots needs no table

    return pd.DataFrame(columns_of_components(surface, component))


def columns_of_components(surface: Surface, component: np.ndarray) -> dict[str, np.ndarray]:
    """Return the columns of `table_of_components` by name."""
    volume = _signed_volumes(surface, component)
    columns: dict[str, np.ndarray] = {"component": np.arange(len(volume)), "dots": np.bincount(component)}
    columns |= {"area": np.bincount(component, surface.area), "volume": np.abs(volume), "cavity": volume < 0}
    return columns


def _signed_volumes(surface: Surface, component: np.ndarray) -> np.ndarray:
    """Return the volume of the space that each component encloses, Å^3, negative for cavities."""
    dots = np.bincount(component)
    # from a point near by, small errors of closing stay small
    centre = [np.bincount(component, axis) / dots for axis in surface.points.T]
    flux = (surface.points - np.array(centre).T[component]) * surface.normals
    return np.bincount(component, flux.sum(axis=1) * surface.area / 3)


def summarize_components(table: pd.DataFrame | dict[str, np.ndarray]) -> dict[str, float | int]:
    """Return volume (Å^3, of the molecule), components, cavities and cavity_dots of a `table_of_components`, or its columns."""
    cavity = np.asarray(table["cavity"])
    return {
        "volume": float(np.where(cavity, -1, 1) @ np.asarray(table["volume"])),
        "components": len(cavity),
        "cavities": int(cavity.sum()),
        "cavity_dots": int(np.asarray(table["dots"])[cavity].sum()),
    }


def on_cavities(surface: Surface, component: np.ndarray) -> np.ndarray:
    """Find the dots on walls of cavities, (N,) bool."""
    return (_signed_volumes(surface, component) < 0)[component]


def without_cavities(surface: Surface, component: np.ndarray) -> Surface:
    """Return the surface of the components that are not cavities; the order of its dots stays."""
    cavity = on_cavities(surface, component)
    return surface.take(~cavity) if cavity.any() else surface


@njit(cache=True, nogil=True)
def _root(joined: np.ndarray, arc: int) -> int:
    """Return the lowest arc of the set of an arc (union-find with path halving)."""
    while joined[arc] != arc:
        joined[arc] = joined[joined[arc]]
        arc = joined[arc]
    return arc


@njit(cache=True, nogil=True)
def _roots(joined: np.ndarray) -> np.ndarray:
    """Return the root of every arc."""
    roots = np.empty_like(joined)
    for arc in range(len(joined)):
        roots[arc] = _root(joined, arc)
    return roots


@njit(cache=True, nogil=True)
def _join(joined: np.ndarray, first: np.ndarray, second: np.ndarray) -> None:
    """Join the sets of pairs of arcs, (n,) each."""
    for k in range(len(first)):
        a, b = _root(joined, first[k]), _root(joined, second[k])
        joined[max(a, b)] = min(a, b)


def _ends(arcs: np.ndarray) -> np.ndarray:
    """Return the positions of both ends of arcs, (B, 2, 3)."""
    phi = arcs[:, PHI_0 : PHI_1 + 1, None]
    outward = np.cos(phi) * arcs[:, None, E1 : E1 + 3] + np.sin(phi) * arcs[:, None, E2 : E2 + 3]
    return arcs[:, None, T : T + 3] + arcs[:, RADIUS, None, None] * outward


def _joined_arcs(rolling: Rolling) -> tuple[np.ndarray, np.ndarray]:
    """Join arcs that end at the same fixed probe: the parent of each, and the probes at its two ends, (B, 2), or -1."""
    joined = np.arange(len(rolling.arcs))
    probe_of_end = _probes_at_ends(_ends(rolling.arcs).reshape(-1, 3), rolling.probes)
    ends = np.flatnonzero(probe_of_end >= 0)
    _, first, of_probe = np.unique(probe_of_end[ends], return_index=True, return_inverse=True)
    _join(joined, ends // 2, ends[first[of_probe]] // 2)
    return joined, probe_of_end.reshape(-1, 2)


def _probes_at_ends(ends: np.ndarray, probes: np.ndarray) -> np.ndarray:
    """Return the index of the probe at each end of an arc, or -1; only those near along SORT_DIRECTION are compared."""
    order = np.argsort(probes @ SORT_DIRECTION)
    height_of_probes, height_of_ends = (probes @ SORT_DIRECTION)[order], ends @ SORT_DIRECTION
    low, high = (
        np.searchsorted(height_of_probes, height_of_ends + shift)
        for shift in (-MEETING_DISTANCE, MEETING_DISTANCE)
    )
    probe_of_end = np.full(len(ends), -1)
    for step in range((high - low).max(initial=0)):
        candidates = np.flatnonzero(low + step < high)
        probe = order[low[candidates] + step]
        meets = np.linalg.norm(probes[probe] - ends[candidates], axis=1) < MEETING_DISTANCE
        probe_of_end[candidates[meets]] = probe[meets]
    return probe_of_end


def _join_cusps(joined: np.ndarray, rolling: Rolling, probe: float, meeting: np.ndarray) -> None:
    """Join the triangle of a fixed probe with an accessible centre whose probe reaches through it, where they meet at a cusp."""
    if not (meeting >= 0).any():
        return
    positions, arc = _positions_along_arcs(rolling.arcs)
    root = _roots(joined)
    end, side = np.nonzero(meeting >= 0)
    part_of_probe = np.full(len(rolling.probes), -1)
    part_of_probe[meeting[end, side]] = root[end]
    largest = np.bincount(root[end]).argmax()
    small = np.flatnonzero((part_of_probe != largest) & (part_of_probe >= 0))
    to_atoms = rolling.atoms.centre[rolling.triple[small]] - rolling.probes[small, None]
    sides = np.cross(to_atoms, np.roll(to_atoms, -1, axis=1))
    sides *= np.sign((sides[:, 0] * to_atoms[:, 2]).sum(axis=1))[:, None, None]  # pointing into the triangle
    order = np.argsort(positions[:, 0])
    along, centres = positions[order], rolling.probes[small]
    low, high = (np.searchsorted(along[:, 0], centres[:, 0] + shift) for shift in (-2 * probe, 2 * probe))
    _join_through_triangles(
        joined, along, root[arc[order]], centres, part_of_probe[small], sides, low, high, 2.0 * probe
    )


@njit(cache=True, nogil=True)
def _join_through_triangles(
    joined: np.ndarray,
    positions: np.ndarray,
    part: np.ndarray,
    centres: np.ndarray,
    own_part: np.ndarray,
    sides: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    reach: float,
) -> None:
    """Join the part of each fixed probe with those of positions within `reach`, Å, that lie inside its triangle.

    `positions`, (M, 3), are sorted along x with their `part`; those of probe k that are near along x are low[k]:high[k]. The rows
    of `sides`, (K, 3, 3), point into its triangle.
    """
    for k in range(len(centres)):
        for q in range(low[k], high[k]):
            if part[q] == own_part[k]:
                continue
            x, y, z = (
                positions[q, 0] - centres[k, 0],
                positions[q, 1] - centres[k, 1],
                positions[q, 2] - centres[k, 2],
            )
            if abs(y) > reach or abs(z) > reach or x * x + y * y + z * z > reach * reach:
                continue
            inside = True
            for s in range(3):
                inside &= x * sides[k, s, 0] + y * sides[k, s, 1] + z * sides[k, s, 2] > 0
            if inside:
                a, b = _root(joined, part[q]), _root(joined, own_part[k])
                joined[max(a, b)] = min(a, b)


def _positions_along_arcs(arcs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions at most ARC_STEP apart on all arcs, with both ends, (M, 3), and the arc of each."""
    turn = arcs[:, PHI_1] - arcs[:, PHI_0]
    steps = np.ceil(arcs[:, RADIUS] * turn / ARC_STEP).astype(int)
    arc = np.repeat(np.arange(len(arcs)), steps + 1)
    step = np.arange(len(arc)) - np.repeat(np.cumsum(steps + 1) - steps - 1, steps + 1)
    phi = (arcs[arc, PHI_0] + turn[arc] * step / np.maximum(steps[arc], 1))[:, None]
    outward = np.cos(phi) * arcs[arc, E1 : E1 + 3] + np.sin(phi) * arcs[arc, E2 : E2 + 3]
    return arcs[arc, T : T + 3] + arcs[arc, RADIUS, None] * outward, arc


def _arcs_of_atoms(pair: np.ndarray, n_atoms: int) -> tuple[np.ndarray, np.ndarray]:
    """List the arcs around each atom, ascending: those around atom a are arcs[first[a]:first[a + 1]]."""
    atom = pair.T.ravel()
    arcs = np.argsort(atom, kind="stable") % max(len(pair), 1)
    return arcs, np.append(0, np.cumsum(np.bincount(atom, minlength=n_atoms)))


def _distances(positions: np.ndarray, arcs: np.ndarray) -> np.ndarray:
    """Return the distance (n, B), Å, of positions (n, 3) from the nearest point of arcs (B, 17)."""
    w = positions[:, None] - arcs[None, :, T : T + 3]
    p1, p2 = (w * arcs[:, E1 : E1 + 3]).sum(axis=2), (w * arcs[:, E2 : E2 + 3]).sum(axis=2)
    flat = np.hypot(p1, p2)
    to_circle = np.sqrt(np.maximum((w**2).sum(axis=2) - flat**2, 0) + (flat - arcs[:, RADIUS]) ** 2)
    on = (np.arctan2(p2, p1) - arcs[:, PHI_0]) % (2 * math.pi) < arcs[:, PHI_1] - arcs[:, PHI_0]
    to_ends = np.linalg.norm(positions[:, None, None] - _ends(arcs)[None], axis=3).min(axis=2)
    return np.where(on, to_circle, to_ends)


def _join_loops(
    joined: np.ndarray,
    arcs: np.ndarray,
    nearest: np.ndarray,
    centres: np.ndarray,
    meeting: np.ndarray,
    atoms: Atoms,
    atom: int,
) -> None:
    """Join the loops of arcs that bound one accessible patch of an atom.

    On a sphere, loops + 1 - covered parts is the number of free parts. If there is one, all loops are joined; if there is one
    covered part, none. Otherwise neighbouring dots decide.
    """
    loops = _loops(arcs, meeting)
    n_loops = len(set(loops.values()))
    if n_loops < 2:
        return
    n_covered = _n_covered_parts(atoms, atom)
    if n_loops == n_covered:
        _join(joined, np.full(len(arcs), arcs[0]), arcs)
    elif n_covered > 1:
        loop = np.array([loops[arc] for arc in nearest.tolist()])
        neighbouring = ((centres[:, None] - centres[None]) ** 2).sum(axis=2) < NEIGHBOUR_DISTANCE**2
        a, b = np.nonzero(neighbouring & (loop[:, None] < loop))
        _join(joined, nearest[a], nearest[b])


def _loops(arcs: np.ndarray, meeting: np.ndarray) -> dict[int, int]:
    """Return the loop of each arc around one atom: arcs that meet at fixed probes, or a whole circle."""
    parent = np.arange(len(arcs))
    # columns of one array, which would be another form of the kernels
    arc, side = (np.ascontiguousarray(column) for column in np.nonzero(meeting[arcs] >= 0))
    _, first, of_probe = np.unique(meeting[arcs][arc, side], return_index=True, return_inverse=True)
    _join(parent, arc, arc[first[of_probe]])
    return dict(zip(arcs.tolist(), _roots(parent).tolist(), strict=True))


def _n_covered_parts(atoms: Atoms, atom: int) -> int:
    """Count the connected parts of an atom's sphere that its neighbours cover."""
    near = atoms.near[atoms.start[atom] : atoms.start[atom + 1]]
    axis = atoms.centre[near] - atoms.centre[atom]
    d = np.linalg.norm(axis, axis=1)
    cosine = (d**2 + atoms.reach[atom] ** 2 - atoms.reach[near] ** 2) / (2 * d * atoms.reach[atom])
    cuts = np.abs(cosine) < 1
    axis, half = axis[cuts] / d[cuts, None], np.arccos(cosine[cuts])
    overlap = np.arccos(np.clip(axis @ axis.T, -1, 1)) < half[:, None] + half
    label = np.arange(len(half))
    while ((least := np.where(overlap, label, len(half)).min(axis=1, initial=len(half))) < label).any():
        label = least
    return len(np.unique(label))
