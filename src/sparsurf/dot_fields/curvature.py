"""Exact curvature at dots: each lies on a sphere or on a torus, whose principal curvatures have closed forms.

A contact dot lies on an atom of radius r: both principal curvatures are 1 / r. A concave dot lies on a probe of radius p: both
are -1 / p. A saddle dot lies on the torus of a probe that rolls around two atoms. Along the probe its curvature is -1 / p; along
the circle around the axis of the two atoms, of radius rho, it is n.e / rho, where n is the outward normal and e the direction
away from the axis (do Carmo, Differential Geometry of Curves and Surfaces, 1976, ch. 3-3). Convex is positive.

Ridges, at which concave parts of the surface meet at an angle, have no curvature here, while a mesh bends there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE

if TYPE_CHECKING:
    from sparsurf.surfaces.surface import Surface, SurfaceOrigin

TOUCHING = 1e-3  # Å, between a probe and an atom that it touches, for positions in float32
ATOMS_AROUND_PROBE = 16  # atoms around a probe that are looked up at first


def principal_curvatures(dots: Surface, origin: SurfaceOrigin) -> tuple[np.ndarray, np.ndarray]:
    """Return the larger and the smaller principal curvature of dots (N,), 1/Å; NaN where their kind is unknown."""
    probe, n = origin.rules.probe_radius, len(dots)
    larger, smaller = np.full(n, np.nan), np.full(n, np.nan)
    contact, saddle = dots.kind == CONTACT, np.flatnonzero(dots.kind == SADDLE)
    larger[contact] = smaller[contact] = 1.0 / origin.radii[dots.atom[contact]]
    larger[dots.kind == CONCAVE] = smaller[dots.kind == CONCAVE] = -1.0 / probe
    if len(saddle):
        points, normals, first = dots.points[saddle], dots.normals[saddle], dots.atom[saddle]
        second = _second_atoms(points + probe * normals, normals, first, origin)
        has_second = second >= 0
        larger[saddle[has_second]] = _around_the_axis(
            points[has_second],
            normals[has_second],
            *(origin.xyz[atoms[has_second]] for atoms in (first, second)),
        )
        smaller[saddle[has_second]] = -1.0 / probe
    return larger, smaller


def _around_the_axis(
    points: np.ndarray, normals: np.ndarray, first: np.ndarray, second: np.ndarray
) -> np.ndarray:
    """Return the curvature of saddle dots along the circle around the axis through two atoms at (n, 3) each, 1/Å."""
    axis = second - first
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    away = points - first
    away -= (away * axis).sum(axis=1, keepdims=True) * axis
    rho = np.linalg.norm(away, axis=1)
    return (normals * away).sum(axis=1) / rho**2


def _second_atoms(
    centres: np.ndarray, normals: np.ndarray, first: np.ndarray, origin: SurfaceOrigin
) -> np.ndarray:
    """Find the atom besides the first that the probe at each centre (n, 3) rolls on, (n,) int; -1 where there is none.

    A probe at the end of an arc touches three atoms: the normal lies in the plane of the probe and of the two that count.
    """
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    probe, n_atoms = origin.rules.probe_radius, len(origin.xyz)
    tree, reach = cKDTree(origin.xyz), float(origin.radii.max()) + probe + TOUCHING
    # A query for all atoms would be slow, and a fixed number could miss one: it grows until none within reach is left
    k = min(ATOMS_AROUND_PROBE, n_atoms)
    while True:
        distance, atom = (
            np.asarray(part).reshape(len(centres), -1)
            for part in tree.query(centres, k, distance_upper_bound=reach)
        )
        if k == n_atoms or np.isinf(distance[:, -1]).all():
            break
        k = min(2 * k, n_atoms)
    atom = np.where(np.isinf(distance), 0, atom)
    touches = np.abs(distance - origin.radii[atom] - probe) < TOUCHING
    # an atom in the place of the first one makes no arc with it
    apart = np.linalg.norm(origin.xyz[atom] - origin.xyz[first][:, None], axis=2)
    touches &= (atom != first[:, None]) & (apart > TOUCHING)
    across = np.cross((origin.xyz[first] - centres)[:, None], origin.xyz[atom] - centres[:, None])
    across /= np.maximum(np.linalg.norm(across, axis=2, keepdims=True), 1e-12)
    tilt = np.where(touches, np.abs((across * normals[:, None]).sum(axis=2)), np.inf)
    best = tilt.argmin(axis=1)
    rows = np.arange(len(centres))
    return np.where(touches[rows, best], atom[rows, best], -1)
