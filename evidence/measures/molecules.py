"""Structures as the evidence reads them."""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from sparsurf.errors import InputError
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import DENSITY

DENSITY_STEPS = 4  # of the search for the density with the requested number of dots


def atoms_of(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Read coordinates (A, 3) and radii (A,), Å, of the atoms of the first model of a structure, all its polymers."""
    molecule = read_molecule(path, selection=None)
    return molecule.xyz[0], radii(molecule, "dms")


def first_model(name: str, path: str | Path, hydrogens: str = "keep") -> Molecule | None:
    """Read the first model of a structure, or print why it takes no part and return None, as for a chain of C-alpha atoms."""
    try:
        return read_molecule(path, model=1, hydrogens=hydrogens)
    except InputError as error:
        print(f"{name} takes no part: {error}")
        return None


def dotted_surface(
    xyz: np.ndarray, radii: np.ndarray, n: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Generate the surface of atoms with about n dots, after a random rotation; points and normals in the old orientation."""
    rotation = Rotation.random(random_state=rng).as_matrix()
    density, best = DENSITY, None
    for _ in range(DENSITY_STEPS):
        surface = molecular_surface(xyz @ rotation.T, radii, density=density)
        if best is None or abs(len(surface) - n) < abs(len(best) - n):
            best = surface
        density = density * n / len(surface)
    return best.points @ rotation, best.normals @ rotation
