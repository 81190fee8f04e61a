"""What a residue is: protein, nucleic acid, water or something else; its elements, and how many heavy atoms it should have.

Names of the chemical component dictionary come from gemmi's table; the names that force fields
invent for protonation states and chain ends stand here.
"""

import re

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

# Elements that occur in a polymer's residues. Anything else there is an atom name misread: a left-shifted
# CA became calcium, HG mercury, CD1 cadmium.
POLYMER_ELEMENTS = frozenset(["H", "D", "C", "N", "O", "S", "SE", "P", "F", "CL", "BR", "I", "B"])

SELENIUM_RESIDUES = frozenset(["MSE", "SEC", "CSE"])

# Two-letter elements that the name of a ligand's atom may begin with; others (CA, CD, HG, ...) are more
# often a carbon or a hydrogen.
LIGAND_ELEMENTS = frozenset(["FE", "ZN", "MG", "MN", "CU", "CL", "BR", "SE", "SI"])

# (atoms of the backbone, last atom of a residue, first atom of the next, longest bond between them in Å:
# 1.33 and 1.61 Å in a relaxed chain, with room for poor geometry)
PEPTIDE = (("N", "CA", "C"), "C", "N", 2.0)
PHOSPHODIESTER = (("C5'", "C3'", "O3'"), "O3'", "P", 2.2)


def standard_name(residue_name):
    """The standard residue of which `residue_name` is a protonation state or chain end; else the name."""
    return VARIANTS.get(residue_name, residue_name)


def known_kind(residue_name):
    """'protein', 'nucleic' or 'water' for a name that says so, else 'other'."""
    tabulated = gemmi.find_tabulated_residue(residue_name)
    if residue_name in VARIANTS or residue_name in AMINO_ACIDS or tabulated.is_amino_acid():
        return "protein"
    if residue_name in NUCLEOTIDES or tabulated.is_nucleic_acid():
        return "nucleic"
    return "water" if residue_name in WATERS or tabulated.is_water() else "other"


def residue_kinds(residue_name, residue_index, name, hetero, xyz):
    """Kind of the residue of each atom.

    A residue belongs to a polymer if its name says so and the file does not mark it as a hetero group,
    or if it is bonded to a neighbour the way the polymer is: modified residues and caps are in, a free
    amino acid or nucleotide marked as a hetero group is out.

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
    known = np.array([known_kind(each) for each in unique])[inverse]
    kind = np.where(np.isin(known, ["protein", "nucleic"]) & hetero[first_atom], "other", known)
    for polymer, chemistry, caps in (("protein", PEPTIDE, CAPS), ("nucleic", PHOSPHODIESTER, ())):
        candidate = (known == polymer) | np.isin(names, list(caps))
        kind[_bonded(candidate, chemistry, residue_index, name, xyz)] = polymer
    return kind[residue_index]


def _bonded(candidate, chemistry, residue_index, name, xyz):
    """(R,) bool: residues bonded to the one before or after, both being candidates or having the backbone."""
    backbone, last, first, longest = chemistry
    places = {each: np.full((len(candidate), 3), np.nan) for each in (*backbone, last, first)}
    for each, place in places.items():
        place[residue_index[name == each]] = xyz[name == each]
    candidate = candidate | ~np.isnan([places[each][:, 0] for each in backbone]).any(axis=0)
    length = np.linalg.norm(places[last][:-1] - places[first][1:], axis=1)
    bond = candidate[:-1] & candidate[1:] & (length < longest)  # a missing atom gives nan: no bond
    return np.append(bond, False) | np.append(False, bond)


def heavy_atoms_found(residue_name, residue_index, element):
    """Heavy atoms that each residue has and should have.

    Returns
    -------
    found, expected : (R,) int ; both 0 for a residue whose composition is not tabulated
    """
    first_atom = np.unique(residue_index, return_index=True)[1]
    expected = np.array([HEAVY_ATOMS.get(standard_name(each), 0) for each in residue_name[first_atom]], int)
    heavy = ~np.isin(element, ["H", "D"])
    found = np.bincount(residue_index[heavy], minlength=len(expected))
    return np.where(expected > 0, np.minimum(found, expected), 0), expected


def element_of(element, name, residue_name, polymer, alone):
    """Element of an atom: the one the file gives if it can be, else the one its name begins with.

    Parameters
    ----------
    element : str, as given by the file; empty if not given
    name, residue_name : str
    polymer : bool, whether the residue is part of a protein or nucleic acid
    alone : bool, whether the atom is the only one of its residue, as an ion is

    Returns
    -------
    str, upper case; 'X' if nothing can be told
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
