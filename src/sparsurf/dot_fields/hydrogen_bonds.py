"""Donors and acceptors of hydrogen bonds by the names of atoms.

hydrogen_bonds.csv holds, for each atom, how many hydrogens it donates and how many lone pairs accept one. Donors and acceptors
of proteins are those of Baker & Hubbard (Prog. Biophys. Mol. Biol. 44:97, 1984) without sulfur, those of nucleic acids are from
Saenger (Principles of Nucleic Acid Structure, 1984); the protonation states are those of charges.csv. A histidine whose state
neither its name nor its hydrogens tell may donate or accept with both nitrogens.
"""

from __future__ import annotations

import logging
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.dot_fields.charges import MAX_BOND_TO_HYDROGEN, protonation_states
from sparsurf.molecules.names import usual_name
from sparsurf.molecules.residues import first_atoms

if TYPE_CHECKING:
    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

DELTA_HISTIDINES = ("HID", "HSD", "HISD", "HISA")  # ends of its names with a hydrogen at ND1


def balance_of_atoms(molecule: Molecule) -> np.ndarray:
    """Return (donated - accepted) / (donated + accepted) hydrogen bonds of each atom, (A,), from 1 to -1; 0 for other atoms.

    A hydrogen at a donor has 1, any other 0.
    """
    donates, accepts = _counts(molecule)
    total = donates + accepts
    balance = np.divide(donates - accepts, total, out=np.zeros(len(total)), where=total > 0)
    balance[_donated_hydrogens(molecule, np.flatnonzero(donates > 0))] = 1.0
    return balance


@cache
def _table() -> dict[tuple[str, str], tuple[int, int]]:
    """Read the table: (residue or kind of residue, atom) -> hydrogens that it donates, lone pairs that accept."""
    import pandas as pd

    table = pd.read_csv(Path(__file__).with_name("hydrogen_bonds.csv"), keep_default_na=False)
    return {
        (residue, atom): (donates, accepts)
        for residue, atom, donates, accepts in table.itertuples(index=False)
    }


def _counts(molecule: Molecule) -> tuple[np.ndarray, np.ndarray]:
    """Return how many hydrogens each atom donates and how many it accepts, (A,) each; 0 for atoms that the table lacks."""
    table, counts, unknown = _table(), np.zeros((2, molecule.n_atoms)), set()
    states = _states(molecule)
    for i in np.flatnonzero(np.isin(molecule.element, ["N", "O"])):
        kind, atom = str(molecule.kind[i]), usual_name(str(molecule.residue_name[i]), str(molecule.name[i]))
        atom = "O" if kind == "water" else atom
        row = table.get((states[molecule.residue_index[i]], atom)) or table.get((kind, atom))
        if row is None:
            unknown.add(str(molecule.residue_name[i]))
        else:
            counts[:, i] = row
    if unknown:
        log.warning(
            "hbond: nitrogen and oxygen atoms of %s are not in the table and count as neither donors nor acceptors",
            ", ".join(sorted(unknown)),
        )
    return counts[0], counts[1]


def _states(molecule: Molecule) -> list[str]:
    """Return the name in the table of each residue; a histidine is HIS where its state is unknown."""
    states = protonation_states(molecule)
    first = first_atoms(molecule.residue_index)
    with_hydrogen = set(molecule.residue_index[molecule.name == "HD1"].tolist())
    for residue, name in enumerate(molecule.residue_name[first]):
        if states[residue] == "HIS" and (residue in with_hydrogen or str(name).endswith(DELTA_HISTIDINES)):
            states[residue] = "HID"
    return states


def _donated_hydrogens(molecule: Molecule, donors: np.ndarray) -> np.ndarray:
    """Find the hydrogens, indices of atoms, that are bonded to donors."""
    hydrogens = np.flatnonzero(~molecule.heavy)
    if not (len(hydrogens) and len(donors)):
        return np.empty(0, int)
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    xyz = molecule.xyz[0]
    distance = np.asarray(cKDTree(xyz[donors]).query(xyz[hydrogens])[0])
    return hydrogens[distance < MAX_BOND_TO_HYDROGEN]
