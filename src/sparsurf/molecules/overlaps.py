"""Atoms of different partners at one position, of which nobody can say which buries which."""

from __future__ import annotations

import logging

import numpy as np

from sparsurf.errors import InputError
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.selection import Partners, partners_of_atoms

log = logging.getLogger("sparsurf")


def refuse_overlapping_partners(molecule: Molecule, partners: Partners, xyz: np.ndarray) -> None:
    """Raise InputError if atoms of two partners have the same position: which buries which cannot be said."""
    first, second = _overlaps(partners, xyz)
    if len(first):
        labels = " and ".join(molecule.residue_label(atom) for atom in (first[0], second[0]))
        raise InputError(
            f"areas: {len(first)} atoms lie at the position of an atom of another chain or ligand, the first ones in {labels}; "
            "choose chains and ligands that do not overlap."
        )


def _overlaps(partners: Partners, xyz: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the atoms (n,) and (n,) of different partners that have the same position."""
    _, first, position = np.unique(xyz, axis=0, return_index=True, return_inverse=True)
    twin = first[position.ravel()]
    twice = np.flatnonzero(partners.number != partners.number[twin])
    return twin[twice], twice


def without_overlaps(molecule: Molecule, frame: int) -> Molecule:
    """Return a molecule without its ligands that have an atom at the position of one of another partner, as a warning says."""
    atoms = np.concatenate(_overlaps(partners_of_atoms(molecule), molecule.xyz[frame].round(3)))
    overlapping = np.isin(molecule.residue_index, molecule.residue_index[atoms]) & (molecule.kind == "other")
    if overlapping.any():
        names = ", ".join(
            dict.fromkeys(molecule.residue_label(k) for k in np.flatnonzero(overlapping).tolist())
        )
        message = "areas: contacts leave out %s, which overlaps another chain or ligand; choose ligands that do not overlap"
        log.warning(message, names)
    return molecule.take(~overlapping)
