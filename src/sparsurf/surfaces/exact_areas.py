"""Exact areas of the contact patches and of the concave triangles of the molecular surface."""

import math

import numpy as np

from sparsurf.surfaces.rolling_probe import PHI_0, PHI_1, THETA_I, THETA_J


def set_exact_areas(contact, concave, share, rolling, radii, probe):
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
