"""Residues: protein, nucleic acid, water or other; the elements of their atoms, and their number of heavy atoms.

Names of the chemical component dictionary come from gemmi. The names that force fields use for protonation states and
chain ends are listed here.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

import gemmi
import numpy as np

# Non-hydrogen atoms of a residue inside a chain (without the terminal OXT), by standard name.
HEAVY_ATOMS = {
    "ALA": 5, "ARG": 11, "ASN": 8, "ASP": 8, "CYS": 6, "GLN": 9, "GLU": 9, "GLY": 4, "HIS": 10, "ILE": 8,
    "LEU": 8, "LYS": 9, "MET": 8, "MSE": 8, "PHE": 11, "PRO": 7, "SER": 6, "THR": 7, "TRP": 14, "TYR": 12,
    "VAL": 7, "A": 22, "C": 20, "G": 23, "U": 20, "DA": 21, "DC": 19, "DG": 22, "DT": 20,
}  # fmt: skip

# Force-field names (AMBER, CHARMM, GROMOS, OPLS) of protonation states: the standard residue they vary.
VARIANTS = {
    variant: standard
    for standard, variants in {
        "HIS": "HID HIE HIP HSD HSE HSP HISA HISB HISD HISE HISH HISP HIS1 HIS2",
        "CYS": "CYM CYX CYN CYS1 CYS2 CYSH",
        "ASP": "ASH AS4 ASPH ASPP",
        "GLU": "GLH GL4 GLUH GLUP",
        "LYS": "LYN LYP LSN LYSH LYSN LYSP",
        "ARG": "ARN ARGN ARGP",
        "TYR": "TYM",
    }.items()
    for variant in variants.split()
}
AMINO_ACIDS = frozenset(name for name in HEAVY_ATOMS if len(name) == 3)
# AMBER marks the residue at a chain's end with N or C: NALA, CHID.
VARIANTS |= {end + name: VARIANTS.get(name, name) for end in "NC" for name in AMINO_ACIDS | VARIANTS.keys()}
CAPS = frozenset(["ACE", "FOR", "NME", "NMA", "NAC", "NH2", "NHE"])
NUCLEOTIDES = frozenset(["ADE", "GUA", "CYT", "THY", "URA"]) | {
    sugar + base + end for sugar in ("D", "R", "") for base in "ACGTU" for end in ("", "3", "5")
}
WATERS = frozenset(["SOL", "TIP", "TIP2", "TIP3", "TIP4", "TIP5", "T3P", "T4P", "TP3M", "SPC", "SPCE", "OH2"])

# Elements that occur in a polymer's residues. Any other is a misread atom name: a left-shifted CA became
# calcium, HG mercury, CD1 cadmium.
POLYMER_ELEMENTS = frozenset(["H", "D", "C", "N", "O", "S", "SE", "P", "F", "CL", "BR", "I", "B"])

SELENIUM_RESIDUES = frozenset(["MSE", "SEC", "CSE"])

# Two-letter elements at the beginning of the name of a ligand's atom. Other letters (CA, CD, HG, ...) are more often
# a carbon or a hydrogen.
LIGAND_ELEMENTS = frozenset(["FE", "ZN", "MG", "MN", "CU", "CL", "BR", "SE", "SI"])


class Linkage(NamedTuple):
    """How the residues of a polymer are bonded to each other."""

    backbone: tuple[str, ...]  # names of its atoms
    last: str  # atom of a residue that is bonded to the next one
    first: str  # atom of the next residue in this bond
    max_length: float  # Å, of the bond: 1.33 and 1.61 Å in a relaxed chain, with room for poor geometry


PEPTIDE = Linkage(("N", "CA", "C"), "C", "N", 2.0)
PHOSPHODIESTER = Linkage(("C5'", "C3'", "O3'"), "O3'", "P", 2.2)


def standard_name(residue_name: str) -> str:
    """Return the standard residue of which a name is a protonation state or chain end; else the name itself."""
    return VARIANTS.get(residue_name, residue_name)


def split_label(label: str) -> tuple[str, str]:
    """Split a residue label into number and insertion code, as '52A' into '52' and 'A'."""
    parts = re.fullmatch(r"(-?\d*)(.?)", label)
    if parts is None:
        raise ValueError(f"{label!r} is not a residue number with an insertion code")
    return parts[1], parts[2]


def known_kind(residue_name: str) -> str:
    """Return 'protein', 'nucleic' or 'water' if the name implies it, else 'other'."""
    tabulated = gemmi.find_tabulated_residue(residue_name)
    if residue_name in VARIANTS or residue_name in AMINO_ACIDS or tabulated.is_amino_acid():
        return "protein"
    if residue_name in NUCLEOTIDES or tabulated.is_nucleic_acid():
        return "nucleic"
    return "water" if residue_name in WATERS or tabulated.is_water() else "other"


def residue_kinds(
    residue_name: np.ndarray,
    residue_index: np.ndarray,
    name: np.ndarray,
    hetero: np.ndarray,
    xyz: np.ndarray,
) -> np.ndarray:
    """Determine the kind of the residue of each atom.

    A residue belongs to a polymer if its name implies it and the file does not mark it as a hetero group. It also
    belongs to it if it is bonded to a neighbour as the polymer's residues are. Modified residues and caps are thus
    included, and a free amino acid or nucleotide marked as a hetero group is not.

    Parameters
    ----------
    residue_name, name : (A,) str
    residue_index : (A,) int, 0, 1, 2, ... in the order of the atoms
    hetero : (A,) bool, HETATM
    xyz : (A, 3) float, Å

    Returns
    -------
    (A,) str : 'protein', 'nucleic', 'water' or 'other'
    """
    first_atom = np.unique(residue_index, return_index=True)[1]
    names = residue_name[first_atom]
    unique, inverse = np.unique(names, return_inverse=True)
    known = np.array([known_kind(str(name)) for name in unique])[inverse]
    kind = np.where(np.isin(known, ["protein", "nucleic"]) & hetero[first_atom], "other", known)
    polymers: tuple[tuple[str, Linkage, Iterable[str]], ...] = (
        ("protein", PEPTIDE, CAPS),
        ("nucleic", PHOSPHODIESTER, ()),
    )
    for polymer, linkage, caps in polymers:
        candidate = (known == polymer) | np.isin(names, list(caps))
        kind[_in_polymer(candidate, linkage, residue_index, name, xyz)] = polymer
    return kind[residue_index]


def _in_polymer(
    candidate: np.ndarray, linkage: Linkage, residue_index: np.ndarray, name: np.ndarray, xyz: np.ndarray
) -> np.ndarray:
    """Find residues (R,) bonded to the one before or after, where both are candidates or have the backbone."""
    positions = {
        atom_name: np.full((len(candidate), 3), np.nan)
        for atom_name in (*linkage.backbone, linkage.last, linkage.first)
    }
    for atom_name, position in positions.items():
        position[residue_index[name == atom_name]] = xyz[name == atom_name]
    complete = ~np.isnan([positions[atom_name][:, 0] for atom_name in linkage.backbone]).any(axis=0)
    candidate = candidate | complete
    length = np.linalg.norm(positions[linkage.last][:-1] - positions[linkage.first][1:], axis=1)
    bond = candidate[:-1] & candidate[1:] & (length < linkage.max_length)  # a missing atom gives nan: no bond
    return np.append(bond, False) | np.append(False, bond)


def count_heavy_atoms(
    residue_name: np.ndarray, residue_index: np.ndarray, element: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Count the heavy atoms that each residue has and should have.

    Returns
    -------
    present, expected : (R,) int
        Both 0 for a residue whose composition is not tabulated.
    """
    first_atom = np.unique(residue_index, return_index=True)[1]
    expected = np.array([HEAVY_ATOMS.get(standard_name(name), 0) for name in residue_name[first_atom]], int)
    heavy = ~np.isin(element, ["H", "D"])
    present = np.bincount(residue_index[heavy], minlength=len(expected))
    return np.where(expected > 0, np.minimum(present, expected), 0), expected


def element_of(element: str, name: str, residue_name: str, polymer: bool, alone: bool) -> str:
    """Return the element of an atom: the file's if it is possible, else the one at the beginning of its name.

    Parameters
    ----------
    element : str, from the file; empty if it has none
    name, residue_name : str
    polymer : bool, whether the residue is part of a protein or nucleic acid
    alone : bool, whether the atom is the only one of its residue, as an ion is

    Returns
    -------
    str, upper case; 'X' if unknown
    """
    element = element.upper()
    if element not in ("", "X") and (not polymer or element in POLYMER_ELEMENTS):
        return element
    letters = re.sub("[^A-Z]", "", name.upper().lstrip("0123456789'*"))
    if polymer:
        selenium = residue_name in SELENIUM_RESIDUES and letters.startswith("SE")
        return "SE" if selenium else letters[:1] or "X"
    ion = alone and residue_name.upper().startswith(letters[:2]) and gemmi.Element(letters[:2]).name != "X"
    return letters[:2] if ion or letters[:2] in LIGAND_ELEMENTS else letters[:1] or "X"
