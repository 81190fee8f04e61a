"""Depth of atoms and residues below the surface (Chakravarty & Varadarajan, Structure 7:723, 1999)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sparsurf.arguments import Cavities
from sparsurf.surfaces.grid import nearest_of
from sparsurf.surfaces.molecular_surface import roll_spheres
from sparsurf.surfaces.spacing import DENSITY

if TYPE_CHECKING:
    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.surface import Surface, SurfaceOrigin


def depth_of_atoms(
    xyz: np.ndarray, radii: np.ndarray, probe: float, cavities: Cavities = "remove"
) -> np.ndarray:
    """Return the distance of atoms at (A, 3) with radii (A,) from the nearest dot of their surface, (A,), Å.

    An atom that the probe touches lies exactly its radius below the surface. Others are too deep by up to 0.2 Å, since the
    nearest point of the surface lies between dots.
    """
    return depth_below(roll_spheres(xyz, radii, probe, cavities=cavities).surface(DENSITY), xyz)


def depth_below(dots: Surface, xyz: np.ndarray) -> np.ndarray:
    """Return the distance of atoms at (A, 3) from the nearest dot, (A,), Å."""
    return nearest_of(dots.points, xyz)[1]


def depth_of_residues(molecule: Molecule, depth: np.ndarray) -> np.ndarray:
    """Return the mean depth of the atoms of each residue, (n,), Å."""
    n = molecule.n_residues
    return np.bincount(molecule.residue_index, depth, n) / np.bincount(molecule.residue_index, minlength=n)


def depth_of_origin(origin: SurfaceOrigin) -> np.ndarray:
    """Return the depth of the residue of each atom that dots were placed on, (A,), Å, without cavities as a surface."""
    depth = depth_of_atoms(origin.xyz.round(3), origin.radii, origin.rules.probe_radius)
    if origin.molecule is None:
        return depth
    return depth_of_residues(origin.molecule, depth)[origin.molecule.residue_index]
