"""Connected parts of a molecular surface: the outside of each molecule, and its cavities.

They follow from where the probe can stand, not from how far dots lie apart. Arcs that meet at a fixed probe belong
together, and so do the loops of arcs that bound one accessible patch of an atom, and a fixed probe with all that cuts
its concave triangle.
"""

import math

import numpy as np
import pandas as pd

from sparsurf.surfaces.placing_dots import relative_places, spheres
from sparsurf.surfaces.rolling_probe import E1, E2, PHI_0, PHI_1, RADIUS, T, roll

MEETS = 1e-4  # Å; the end of an arc and its fixed probe differ by rounding alone
FINE = 0.3  # Å, between places on an arc that stand for it
FIELD = "component"  # of a Surface: component of each dot
ALONG = np.array([0.61, 0.53, 0.59])  # a direction in which few places lie side by side
NEXT = 1.0  # Å; dots of one patch that lie side by side


def fields_alone(surface):
    """The fields of a surface but for the number of the component, which has no mean and no value between dots: dict."""
    return {name: values for name, values in surface.fields.items() if name != FIELD}


def components_of(surface, xyz, radii, probe=1.4):
    """Connected component of every dot.

    Parameters
    ----------
    surface : Surface that `molecular_surface` made of the following
    xyz : (A, 3), centres of the atoms, Å
    radii : (A,), Å
    probe : Å

    Returns
    -------
    (N,) int64 : 0 for the component with most dots, then 1, 2, ...
    """
    xyz, radii, kept = spheres(xyz, radii, probe)
    rolling = roll(np.add(*relative_places(xyz)), radii + probe)
    centres = surface.points - xyz[0] + probe * surface.normals
    owner = np.searchsorted(kept, surface.atom)
    joined, meeting = _joined_arcs(rolling)
    arcs_of = _arcs_of_atoms(rolling.pair, len(xyz))
    roots = np.array([_root(joined, arc) for arc in range(len(joined))], np.int64)
    label, order = np.empty(len(surface), np.int64), np.argsort(owner, kind="stable")
    for dots in np.split(order, np.flatnonzero(np.diff(owner[order])) + 1):
        atom = owner[dots[0]]
        arcs = arcs_of[atom]
        if not len(arcs):  # a sphere that no other touches
            label[dots] = len(rolling.arcs) + atom
            continue
        if (roots[arcs] == roots[arcs[0]]).all():  # most atoms: nothing to tell apart
            label[dots] = arcs[0]
            continue
        nearest = arcs[_distances(centres[dots], rolling.arcs[arcs]).argmin(axis=1)]
        _join_loops(joined, arcs, nearest, centres[dots], meeting, rolling.atoms, atom)
        label[dots] = nearest
    _join_cusps(joined, rolling, probe, meeting)
    roots = np.append([_root(joined, arc) for arc in range(len(joined))], np.arange(len(xyz)) + len(joined))
    label = roots.astype(np.int64)[label]
    _, label, count = np.unique(label, return_inverse=True, return_counts=True)
    rank = np.argsort(np.argsort(-count, kind="stable"))
    return rank[label]


def table_of_components(surface, component):
    """What each component is.

    Returns
    -------
    DataFrame : component, dots, area (Å^2), volume (Å^3, of the room that the probe's surface encloses), cavity (bool: its
        normals point inwards)
    """
    dots = np.bincount(component)
    centre = [
        np.bincount(component, axis) / dots for axis in surface.points.T
    ]  # near: small errors of closing stay small
    flux = (surface.points - np.array(centre).T[component]) * surface.normals
    volume = np.bincount(component, flux.sum(axis=1) * surface.area / 3)
    return pd.DataFrame(
        {
            "component": np.arange(len(dots)),
            "dots": dots,
            "area": np.bincount(component, surface.area),
            "volume": np.abs(volume),
            "cavity": volume < 0,
        }
    )


def numbers_of(table):
    """What a `table_of_components` comes to: volume (Å^3, of the molecule), components, cavities and their dots, a dict."""
    own = np.where(table["cavity"], -1, 1) @ table["volume"]
    cavities = table[table["cavity"]]
    return {
        "volume": float(own),
        "components": len(table),
        "cavities": len(cavities),
        "cavity_dots": int(cavities["dots"].sum()),
    }


def without_cavities(surface, component):
    """The Surface of the components that are no cavities; the order of its dots stays."""
    cavity = table_of_components(surface, component)["cavity"].to_numpy()
    return surface.take(~cavity[component]) if cavity.any() else surface


def _root(joined, arc):
    while joined[arc] != arc:
        joined[arc] = joined[joined[arc]]
        arc = joined[arc]
    return arc


def _join(joined, a, b):
    a, b = _root(joined, a), _root(joined, b)
    joined[max(a, b)] = min(a, b)


def _ends(arcs):
    """Places of both ends of arcs, (B, 2, 3)."""
    phi = arcs[:, PHI_0 : PHI_1 + 1, None]
    outward = np.cos(phi) * arcs[:, None, E1 : E1 + 3] + np.sin(phi) * arcs[:, None, E2 : E2 + 3]
    return arcs[:, None, T : T + 3] + arcs[:, RADIUS, None, None] * outward


def _joined_arcs(rolling):
    """Parent of every arc, arcs that end at the same fixed probe being joined; the probes (B, 2) at its ends, or -1."""
    joined = list(range(len(rolling.arcs)))
    probe, first = _same_place(_ends(rolling.arcs).reshape(-1, 3), rolling.probes), {}
    for end in np.flatnonzero(probe >= 0).tolist():
        _join(joined, end // 2, first.setdefault(int(probe[end]), end // 2))
    return joined, probe.reshape(-1, 2)


def _same_place(ends, probes):
    """Index of the probe that is where each end is, or -1; sought among those of about the same height along ALONG."""
    order = np.argsort(probes @ ALONG)
    height, own = (probes @ ALONG)[order], ends @ ALONG
    low, high = (np.searchsorted(height, own + shift) for shift in (-MEETS, MEETS))
    found = np.full(len(ends), -1)
    for step in range((high - low).max(initial=0)):
        at = np.flatnonzero(low + step < high)
        probe = order[low[at] + step]
        meets = np.linalg.norm(probes[probe] - ends[at], axis=1) < MEETS
        found[at[meets]] = probe[meets]
    return found


def _join_cusps(joined, rolling, probe, meeting):
    """Join what meets at a cusp: the triangle of a fixed probe and an accessible centre whose probe reaches through it."""
    if not (meeting >= 0).any():
        return
    places, arc = _along_arcs(rolling.arcs)
    root = np.array([_root(joined, k) for k in range(len(joined))])
    end, side = np.nonzero(meeting >= 0)
    part_of_probe = np.full(len(rolling.probes), -1)
    part_of_probe[meeting[end, side]] = root[end]
    largest = np.bincount(root[end]).argmax()
    small = np.flatnonzero((part_of_probe != largest) & (part_of_probe >= 0))
    to_atoms = rolling.atoms.centre[rolling.triple[small]] - rolling.probes[small, None]
    sides = np.cross(to_atoms, np.roll(to_atoms, -1, axis=1))
    sides *= np.sign((sides[:, 0] * to_atoms[:, 2]).sum(axis=1))[:, None, None]  # pointing into the triangle
    order = np.argsort(places[:, 0])
    x = places[order, 0]
    low, high = (np.searchsorted(x, rolling.probes[small, 0] + shift) for shift in (-2 * probe, 2 * probe))
    for k, centre in enumerate(rolling.probes[small]):
        other = order[low[k] : high[k]]
        other = other[((places[other] - centre) ** 2).sum(axis=1) <= 4 * probe**2]
        other = other[root[arc[other]] != part_of_probe[small[k]]]
        inside = ((places[other] - rolling.probes[small[k]]) @ sides[k].T > 0).all(axis=1)
        for each in np.unique(root[arc[other[inside]]]).tolist():
            _join(joined, int(part_of_probe[small[k]]), each)


def _along_arcs(arcs):
    """Places at most FINE apart on all arcs, both ends among them, (M, 3), and the arc of each."""
    turn = arcs[:, PHI_1] - arcs[:, PHI_0]
    steps = np.ceil(arcs[:, RADIUS] * turn / FINE).astype(int)
    arc = np.repeat(np.arange(len(arcs)), steps + 1)
    step = np.arange(len(arc)) - np.repeat(np.cumsum(steps + 1) - steps - 1, steps + 1)
    phi = (arcs[arc, PHI_0] + turn[arc] * step / np.maximum(steps[arc], 1))[:, None]
    outward = np.cos(phi) * arcs[arc, E1 : E1 + 3] + np.sin(phi) * arcs[arc, E2 : E2 + 3]
    return arcs[arc, T : T + 3] + arcs[arc, RADIUS, None] * outward, arc


def _arcs_of_atoms(pair, n_atoms):
    """Indices of the arcs around each atom, a list of arrays."""
    atom = pair.T.ravel()
    order = np.argsort(atom, kind="stable")
    return np.split(order % max(len(pair), 1), np.cumsum(np.bincount(atom, minlength=n_atoms))[:-1])


def _distances(places, arcs):
    """Distance (n, B), Å, of places (n, 3) from the nearest point of arcs (B, 17)."""
    w = places[:, None] - arcs[None, :, T : T + 3]
    p1, p2 = (w * arcs[:, E1 : E1 + 3]).sum(axis=2), (w * arcs[:, E2 : E2 + 3]).sum(axis=2)
    flat = np.hypot(p1, p2)
    to_circle = np.sqrt(np.maximum((w**2).sum(axis=2) - flat**2, 0) + (flat - arcs[:, RADIUS]) ** 2)
    on = (np.arctan2(p2, p1) - arcs[:, PHI_0]) % (2 * math.pi) < arcs[:, PHI_1] - arcs[:, PHI_0]
    to_ends = np.linalg.norm(places[:, None, None] - _ends(arcs)[None], axis=3).min(axis=2)
    return np.where(on, to_circle, to_ends)


def _join_loops(joined, arcs, nearest, centres, meeting, atoms, atom):
    """Join the loops of arcs that bound one accessible patch of an atom.

    On a sphere, `loops` closed curves between `covers` covered parts and the free ones make a tree: there are
    loops + 1 - covers free parts. With one of them all loops are joined, with one covered part none. Between, dots
    that lie side by side tell.
    """
    loops = _loops(arcs, meeting)
    n_loops = len(set(loops.values()))
    if n_loops < 2:
        return
    covers = _covered_parts(atoms, atom)
    if n_loops == covers:
        for arc in arcs[1:]:
            _join(joined, int(arcs[0]), int(arc))
    elif covers > 1:
        loop = np.array([loops[arc] for arc in nearest.tolist()])
        beside = ((centres[:, None] - centres[None]) ** 2).sum(axis=2) < NEXT**2
        for a, b in np.argwhere(beside & (loop[:, None] < loop)):
            _join(joined, int(nearest[a]), int(nearest[b]))


def _loops(arcs, meeting):
    """Loop of each arc around one atom, a dict: arcs that meet at fixed probes, or a whole circle."""
    parent, first = list(range(len(arcs))), {}
    for k, probes in enumerate(meeting[arcs].tolist()):
        for probe in probes:
            if probe >= 0:
                _join(parent, k, first.setdefault(probe, k))
    return {int(arc): _root(parent, k) for k, arc in enumerate(arcs)}


def _covered_parts(atoms, atom):
    """Number of connected parts of an atom's sphere that its neighbours cover."""
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
