"""How deep dots lie below the surface of more atoms, or below that of a larger probe."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import InputError, argument
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.molecular_surface import roll_spheres

if TYPE_CHECKING:
    from sparsurf.surfaces.surface import Surface, SurfaceOrigin

LARGE_PROBE = 5.0  # Å, radius of the probe below whose surface `enclosure` is measured


def burial(dots: Surface | None) -> np.ndarray:
    """Return how deep dots of one group lie below the surface of all groups together, Å; 0 where they stay on it.

    A probe that touches the group at x, with the normal n, has its centre at x + probe n. The dot stays on the joint surface
    if and only if this centre lies in no ball, larger than the atom by the probe, of an atom of another group.
    """
    origin = _origin_of_atoms(dots, "burial")
    if origin.partner is None:
        raise InputError(
            f"{argument('fields')}: burial needs groups; give them to surface() or points(), as in H,L+G."
        )
    assert dots is not None
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    xyz, radii = origin.partner
    probe, points = origin.rules.probe_radius, np.asarray(dots.points, float)
    centres, covered = points + probe * np.asarray(dots.normals, float), np.zeros(len(points), bool)
    for radius in np.unique(radii):  # a tree for each radius, so that the nearest atom decides
        covered |= cKDTree(xyz[radii == radius]).query(centres)[0] < radius + probe
    together = roll_spheres(np.concatenate([origin.xyz, xyz]), np.concatenate([origin.radii, radii]), probe)
    depth = np.zeros(len(points))
    depth[covered] = np.maximum(0.0, -exact_distance(points[covered], together))
    return depth


def enclosure(dots: Surface | None) -> np.ndarray:
    """Return how deep dots lie below the surface that a probe of 5 Å rolls over on the same atoms, Å; 0 where it touches."""
    origin = _origin_of_atoms(dots, "enclosure")
    assert dots is not None
    rolled = roll_spheres(origin.xyz, origin.radii, LARGE_PROBE)
    return np.maximum(0.0, -exact_distance(np.asarray(dots.points, float), rolled)) + 0.0  # without -0.0


def _origin_of_atoms(dots: Surface | None, name: str) -> SurfaceOrigin:
    """Return the atoms that dots were placed on; raise InputError if they are unknown."""
    if dots is None or dots.origin is None:
        raise InputError(
            f"{argument('fields')}: {name} follows from the atoms that the dots were placed on; give dots from surface() or "
            "points()."
        )
    return dots.origin
