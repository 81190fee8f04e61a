"""Structures as the evidence reads them."""

from pathlib import Path

import numpy as np

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.radii import radii


def atoms_of(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Read coordinates (A, 3) and radii (A,), Å, of the atoms of the first model of a structure, all its polymers."""
    molecule = read_molecule(path, selection=None)
    return molecule.xyz[0], radii(molecule, "dms")
