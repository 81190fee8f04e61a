"""Names of atoms that programs spell differently: one table for every look-up by name.

A molecule keeps the names of its file. Whoever looks up an atom by its name (charges, hydrogen bonds, values of a user's table)
asks for its usual name, which is that of the chemical component dictionary (PDB format 3).
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

import numpy as np

from sparsurf.molecules.residues import known_kind, standard_name

# In amino acids: CHARMM, GROMOS, OPLS and AMBER, and GROMACS' files of these
OF_AMINO_ACIDS = {
    "HN": "H", "HT1": "H1", "HT2": "H2", "HT3": "H3", "OT1": "O", "OT2": "OXT", "OC1": "O", "OC2": "OXT", "O1": "O", "O2": "OXT",
    "OT": "O", "OXT1": "O", "OXT2": "OXT",
}  # fmt: skip
# In nucleic acids, where an asterisk also stands for the prime
OF_NUCLEOTIDES = {"O1P": "OP1", "O2P": "OP2", "O3P": "OP3", "C5M": "C7"}
# The hydrogens of methylene groups, which some programs number 1 and 2 and the dictionary 2 and 3
METHYLENES = {
    "HA": "GLY", "HB": "ARG ASN ASP CYS GLN GLU HIS LEU LYS MET PHE PRO SER TRP TYR", "HG": "ARG GLN GLU LYS MET PRO",
    "HD": "ARG LYS PRO", "HE": "LYS", "HG1": "ILE",
}  # fmt: skip
OF_RESIDUES = {
    (residue, f"{group}1"): f"{group}3" for group, residues in METHYLENES.items() for residue in residues.split()
} | {("ILE", "CD"): "CD1", ("ILE", "HD1"): "HD11", ("ILE", "HD2"): "HD12", ("ILE", "HD3"): "HD13", ("CYS", "HG1"): "HG",
     ("SER", "HG1"): "HG"}  # fmt: skip


@cache
def usual_name(residue_name: str, name: str) -> str:
    """Return the usual name of an atom of a residue, in upper case; that of the file if there is no other."""
    name = name.upper()
    kind = known_kind(residue_name)
    if kind == "nucleic":
        name = name.replace("*", "'")
        return OF_NUCLEOTIDES.get(name, name)
    if kind != "protein":
        return name
    return OF_RESIDUES.get((standard_name(residue_name), name)) or OF_AMINO_ACIDS.get(name, name)


def usual_names(residue_name: np.ndarray, name: np.ndarray) -> np.ndarray:
    """Return the usual name of each atom (A,)."""
    pairs = zip(residue_name.tolist(), name.tolist(), strict=True)
    return np.array([usual_name(*pair) for pair in pairs], dtype=str)


def other_spellings(names: Iterable[str], residue_name: np.ndarray, name: np.ndarray) -> dict[str, str]:
    """Return the names in a file of some names that it spells differently: the first one of each."""
    pairs = sorted({*zip(residue_name.tolist(), name.tolist(), strict=True)})
    found = {}
    for word in names:
        if any(candidate == word for _, candidate in pairs):
            continue
        spelt = (
            candidate
            for residue, candidate in pairs
            if usual_name(residue, candidate) == usual_name(residue, word)
        )
        if (spelling := next(spelt, "")) and spelling != word:
            found[word] = spelling
    return found
