"""Residues: protein, nucleic acid, water or other; the elements of their atoms, and their number of heavy atoms.

Names of the chemical component dictionary come from gemmi. The names that force fields use for protonation states, chain
ends, waters and ions are listed here.
"""

from __future__ import annotations

import re
from functools import cache
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
        "CYS": "CYM CYX CYN CYS1 CYS2 CYSH DISU",
        "ASP": "ASH AS4 ASPH ASPP",
        "GLU": "GLH GL4 GLUH GLUP",
        "LYS": "LYN LYP LSN LYSH LYSN LYSP",
        "ARG": "ARN ARGN ARGP",
        "TYR": "TYM",
    }.items()
    for variant in variants.split()
}
# Nucleotides whose usual number of atoms includes a phosphate
NUCLEOTIDES_WITH_PHOSPHATE = frozenset(["A", "C", "G", "U", "DA", "DC", "DG", "DT"])
ATOMS_OF_PHOSPHATE = ("P", "OP1", "OP2")
MAX_PHOSPHATE = 3.0  # Å, between the two oxygen atoms that a phosphorus joins (2.5)
AMINO_ACIDS = frozenset(name for name in HEAVY_ATOMS if len(name) == 3)
# AMBER marks the residue at a chain's end with N or C: NALA, CHID.
VARIANTS |= {end + name: VARIANTS.get(name, name) for end in "NC" for name in AMINO_ACIDS | VARIANTS.keys()}
# Names of four letters that begin like a standard residue: CHARMM's lipid anchors and patches, AMBER, GROMOS
LONG_NAMES = frozenset(
    ["CYSF", "CYSG", "CYSL", "CYSP", "CYSD", "GLYM", "GLYP", "GLUM", "GLYB", "LYSA", "LYSM", "LYSR", "PROP", "SERD", "SERP",
     "THRP", "TYRP", "TYRD", "TYRU", "ASPM", "ALAD", "ALAB", "ARGU", "HISE", "HISD", "TRPU"]
)  # fmt: skip
CAPS = frozenset(["ACE", "FOR", "NME", "NMA", "NAC", "NH2", "NHE"])
NUCLEOTIDES = frozenset(["ADE", "GUA", "CYT", "THY", "URA"]) | {
    sugar + base + end for sugar in ("D", "R", "") for base in "ACGTU" for end in ("", "3", "5")
}
WATERS = frozenset(
    ["SOL", "TIP", "TIP2", "TIP3", "TIP4", "TIP5", "T3P", "T4P", "TP3M", "SPC", "SPCE", "OH2", "SWM", "SWM4", "SWM6"]
)  # fmt: skip
# Names of waters that other molecules have as well: they are waters if they hold one oxygen and no other heavy atom
WATERS_BY_ATOMS = frozenset(
    ["TP3", "TP4", "TP5", "TIP3P", "TIP4P", "TIP5P", "TIPS", "T3H", "T4E", "T5P", "OPC", "OPC3", "OP3", "OP4", "SPF", "SPCF",
     "SPC/E", "SPB", "SOLV", "WTR", "HO4", "HO5", "FB3", "FB4"]
)  # fmt: skip
# Ions, by the names of residues (CHARMM, AMBER, GROMOS) that do not begin with their element
IONS = {
    "SOD": "NA", "POT": "K", "CAL": "CA", "CLA": "CL", "CES": "CS", "LIT": "LI", "MAG": "MG", "RUB": "RB", "BAR": "BA",
    "CAD": "CD", "CD2": "CD", "CIO": "CS", "C0": "CA", "IP": "NA", "IM": "CL", "IB": "NA", "IOD": "I", "CHL": "CL",
    "CHLO": "CL", "FLU": "F", "BRO": "BR", "NIO": "NA", "CIM": "CL", "CIP": "NA", "QNA": "NA", "QCL": "CL",
}  # fmt: skip
NAMES_OF_IONS = frozenset(["ION", "IONS"])  # residues whose atoms have the name of the ion
HALOGENS = frozenset(["F", "CL", "BR", "I"])

# Atoms of old files that may be N or O (or C of histidine), as the usual names for their places have it
AMBIGUOUS = {
    ("ASN", "AD1"): "O", ("ASN", "AD2"): "N", ("GLN", "AE1"): "O", ("GLN", "AE2"): "N",
    ("HIS", "AD1"): "N", ("HIS", "AD2"): "C", ("HIS", "AE1"): "C", ("HIS", "AE2"): "N",
}  # fmt: skip

# Particles that are no atoms. By their element in the file: pseudoatoms of CYANA (Q) and PyMOL (PS), lone pairs (LP), extra
# points of AMBER (EP) and of OpenMM (VS)
NO_ELEMENTS = frozenset(["Q", "PS", "LP", "EP", "VS"])
# By their name, where the element says nothing else: lone pairs and extra points in any molecule, and virtual sites of waters
LONE_PAIR = re.compile(r"LP[A-Z0-9]{0,3}|EPW?\d?")
VIRTUAL_SITE = re.compile(r"E?[MLP]W?\d?|OM|IW|DUM\d?")
# In amino acids: pseudoatoms (QB, QQG of CYANA, PS1 of PyMOL), and masses that carry virtual hydrogens (MCB1, MNZ2 of GROMACS)
PSEUDOATOM = re.compile(r"Q[A-Z0-9]*|PS\d*|M(C|N|W|TRP)[A-Z0-9]*")
DRUDE = re.compile(r"D[A-Z][A-Z0-9']*")  # the name of an atom behind a D
AT_ITS_ATOM = 0.6  # Å; a Drude particle is that close to its atom

# Elements that occur in a polymer's residues. Any other is a misread atom name: a left-shifted CA became
# calcium, HG mercury, CD1 cadmium.
POLYMER_ELEMENTS = frozenset(["H", "D", "C", "N", "O", "S", "SE", "P", "F", "CL", "BR", "I", "B"])

# Names of atoms in old files of ATP and NAD(P), whose first letter names the half of the molecule: AC5*, NC5*, AN9, AH2*
OF_A_HALF = re.compile(r"A[CHNOP]|A[CHNOP][0-9*'].*")
OF_EITHER_HALF = re.compile(r"[AN][CHNOP]([0-9*'P].*)?")
TWO_HALVES = frozenset(["NAD", "NAI", "NAP", "NDP"])

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
    caps: frozenset[str] = frozenset()  # residues without the backbone that end a chain


PEPTIDE = Linkage(("N", "CA", "C"), "C", "N", 2.0, CAPS)
PHOSPHODIESTER = Linkage(("C5'", "C3'", "O3'"), "O3'", "P", 2.2)
LINKAGES = {"protein": PEPTIDE, "nucleic": PHOSPHODIESTER}
COVALENT = (1.1, 1.75)  # Å, bonds of C, N, O and P; metals are farther away
MAX_RESIDUE_BOND = 2.2  # Å, between atoms of one residue (Se-C 1.95)
MAX_CAP = 300  # heavy atoms of a residue that may end a chain
MAX_PAIRS_OF_ENDS = 1_000_000  # At most so many pairs of ends of chains are compared one by one.


def standard_name(residue_name: str) -> str:
    """Return the standard residue of which a name is a protonation state or chain end; else the name itself."""
    return VARIANTS.get(residue_name, residue_name)


@cache
def split_label(label: str) -> tuple[str, str]:
    """Split a residue label into number and insertion code, as '52A' into '52' and 'A'."""
    parts = re.fullmatch(r"(-?\d*)(.?)", label)
    if parts is None:
        raise ValueError(f"{label!r} is not a residue number with an insertion code")
    return parts[1], parts[2]


@cache
def known_kind(residue_name: str) -> str:
    """Return 'protein', 'nucleic' or 'water' if the name implies it, else 'other'."""
    tabulated = gemmi.find_tabulated_residue(residue_name)
    if residue_name in VARIANTS or residue_name in AMINO_ACIDS or tabulated.is_amino_acid():
        return "protein"
    if residue_name in NUCLEOTIDES or tabulated.is_nucleic_acid():
        return "nucleic"
    return "water" if residue_name in WATERS or tabulated.is_water() else "other"


def residue_kinds(
    residue_name: np.ndarray, residue_index: np.ndarray, name: np.ndarray, hetero: np.ndarray, xyz: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Determine the kind of each residue (R,), and the next residue of the polymer (R,), -1 for none, from arrays of the atoms.

    A residue belongs to a polymer if its name implies it and the input does not mark it as a hetero group, or if it is
    bonded to another one as the polymer's residues are, or to the end of a chain by any of its atoms. Modified residues and
    caps are thus included wherever their lines stand, and a free amino acid marked as a hetero group is not.
    """
    first_atom = first_atoms(residue_index)
    names = residue_name[first_atom]
    kind_by_name = np.array([known_kind(str(text)) for text in names])
    kind = np.where(np.isin(kind_by_name, [*LINKAGES]) & hetero[first_atom], "other", kind_by_name)
    letter = first_letters(name)
    if (kind_by_name == "other").any():
        kind[(kind_by_name == "other") & _hold_water(names, residue_index, letter)] = "water"
    following = np.full(len(names), -1)
    name = np.char.replace(name.astype(str), "*", "'")  # of nucleic acids in old files
    no_cap = (np.bincount(residue_index) == 1)[residue_index] | np.isin(
        letter, [*"HDhd"]
    )  # ions, dummy atoms
    for polymer, linkage in LINKAGES.items():
        atoms = {
            atom_name: atoms_of_residues(residue_index, name == atom_name, len(names))
            for atom_name in (*linkage.backbone, linkage.last, linkage.first)
        }
        complete = np.all([atoms[atom_name] >= 0 for atom_name in linkage.backbone], axis=0)
        candidate = (kind_by_name == polymer) | np.isin(names, [*linkage.caps]) | complete
        last, first = (np.where(candidate, atoms[end], -1) for end in (linkage.last, linkage.first))
        before, after = _links(last, first, xyz, linkage.max_length)
        following[before] = after
        kind[before] = kind[after] = polymer
        ends = np.concatenate([np.delete(last, before), np.delete(first, after)])
        member = kind[residue_index] == polymer
        ends = ends[(ends >= 0) & member[ends]]
        while len(ends):  # a residue that is bonded to a cap also belongs to the chain
            other = np.flatnonzero((kind == "other")[residue_index] & ~no_cap)
            added = set[int]()
            for end in ends:
                distance = np.linalg.norm(xyz[other] - xyz[end], axis=1)
                for cap in residue_index[other[(distance > COVALENT[0]) & (distance < COVALENT[1])]].tolist():
                    if cap not in added and _is_connected(xyz[other[residue_index[other] == cap]]):
                        kind[cap] = polymer
                        added.add(cap)
            ends = np.flatnonzero(np.isin(residue_index, [*added]) & ~no_cap)
    return kind, following


def _is_connected(xyz: np.ndarray) -> bool:
    """Return whether bonds could join all of some atoms (A, 3)."""
    if len(xyz) > MAX_CAP:
        return False
    near = np.linalg.norm(xyz[:, None] - xyz, axis=2) < MAX_RESIDUE_BOND
    reached = near[0]
    for _ in range(len(xyz)):
        reached = near[reached].any(axis=0)
    return bool(reached.all())


def first_atoms(residue_index: np.ndarray) -> np.ndarray:
    """Return the index of the first atom of each residue, (R,)."""
    return np.unique(residue_index, return_index=True)[1]


def atoms_of_residues(residue_index: np.ndarray, mask: np.ndarray, n_residues: int) -> np.ndarray:
    """Return the last atom of each residue (R,) in a mask (A,); -1 for none."""
    atoms = np.full(n_residues, -1)
    atoms[residue_index[mask]] = np.flatnonzero(mask)
    return atoms


def _links(
    last: np.ndarray, first: np.ndarray, xyz: np.ndarray, max_length: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find bonds from the last atom of a residue to the first of another: between neighbours in the input, then any."""
    length = np.linalg.norm(xyz[last[:-1]] - xyz[first[1:]], axis=1)
    # unknown positions give nan: no bond
    bonded = (last[:-1] >= 0) & (first[1:] >= 0) & (length < max_length)
    before, after = np.flatnonzero(bonded), np.flatnonzero(bonded) + 1
    has_position = np.isfinite(xyz).all(axis=1)
    ends, starts = (
        np.setdiff1d(np.flatnonzero((atoms >= 0) & has_position[atoms]), linked)
        for atoms, linked in ((last, before), (first, after))
    )
    if not len(ends) or not len(starts):
        return before, after
    if len(ends) * len(starts) > MAX_PAIRS_OF_ENDS:
        from scipy.spatial import cKDTree  # takes long to load, and few inputs need it

        distance, nearest = map(np.asarray, cKDTree(xyz[first[starts]]).query(xyz[last[ends]]))
    else:
        table = np.linalg.norm(xyz[last[ends]][:, None] - xyz[first[starts]], axis=2)
        nearest, distance = table.argmin(axis=1), table.min(axis=1)
    found = (distance < max_length) & (ends != starts[nearest])
    _, once = np.unique(starts[nearest[found]], return_index=True)
    ends, starts = ends[found][once], starts[nearest[found]][once]
    return np.concatenate([before, ends]), np.concatenate([after, starts])


def find_particles(
    name: np.ndarray,
    residue_name: np.ndarray,
    residue_index: np.ndarray,
    element: np.ndarray,
    xyz: np.ndarray,
) -> np.ndarray:
    """Return which of the atoms (A,) of an input are none: pseudoatoms, lone pairs, virtual sites and Drude particles.

    `element` is that of the input, empty where it has none. A Drude particle has the name of an atom of its residue behind a D
    and lies beside it; the D of a deuterium precedes another letter.
    """
    odd_name = np.isin(name.astype("U1"), [*"QMLEDPIVX"]) | (name == "OM")
    found = np.isin(element, [*NO_ELEMENTS]) & odd_name
    unknown = (np.isin(element, ["", "X", "E", "L", "M", "O"]) | np.char.startswith(element, "D")) & ~found
    suspects = np.flatnonzero(unknown & odd_name)
    if not len(suspects):
        return found
    place: dict[tuple[int, str], int] | None = None
    for atom in suspects.tolist():
        text, kind = str(name[atom]).upper(), known_kind(str(residue_name[atom]))
        of_kind = {"water": VIRTUAL_SITE, "protein": PSEUDOATOM}.get(kind, LONE_PAIR)
        if LONE_PAIR.fullmatch(text) or of_kind.fullmatch(text):
            found[atom] = True
        elif DRUDE.fullmatch(text):
            place = place or {
                label: k for k, label in enumerate(zip(residue_index.tolist(), name.tolist(), strict=True))
            }
            parent = place.get((int(residue_index[atom]), text[1:]))
            distance = np.inf if parent is None else np.linalg.norm(xyz[atom] - xyz[parent])
            found[atom] = bool(distance < AT_ITS_ATOM)
    return found


def first_letters(names: np.ndarray) -> np.ndarray:
    """Return the first letter of each name of an atom (A,), which may follow digits; empty if there is none."""
    return np.char.lstrip(names.astype(str), "0123456789'*").astype("U1")


def _hold_water(residue_name: np.ndarray, residue_index: np.ndarray, letter: np.ndarray) -> np.ndarray:
    """Return which residues hold one oxygen, and two hydrogens or the name of a water, and nothing else but virtual sites."""
    oxygen, hydrogen, virtual = (
        np.bincount(residue_index[np.isin(letter, [*letters])], minlength=len(residue_name))
        for letters in ("Oo", "HDhd", "MELVXmelvx")
    )
    alone = (oxygen == 1) & (oxygen + hydrogen + virtual == np.bincount(residue_index))
    named = np.isin(residue_name, [*WATERS_BY_ATOMS])
    return alone & ((hydrogen == 2) | (named & (hydrogen < 2)))


def count_heavy_atoms(
    residue_name: np.ndarray,
    residue_index: np.ndarray,
    element: np.ndarray,
    name: np.ndarray | None = None,
    xyz: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Count the heavy atoms that each residue has and should have (R,); both 0 where the composition is not tabulated.

    With the names of the atoms and their positions (A, 3), Å, a nucleotide without O2' is one of DNA, and one at a 5' end may
    lack its phosphate.
    """
    first_atom = first_atoms(residue_index)
    expected = np.array([HEAVY_ATOMS.get(standard_name(name), 0) for name in residue_name[first_atom]], int)
    if name is not None and xyz is not None:
        expected -= _absent_from_nucleotides(residue_name[first_atom], residue_index, name, xyz)
    heavy = ~np.isin(element, ["H", "D"])
    present = np.bincount(residue_index[heavy], minlength=len(expected))
    return np.where(expected > 0, np.minimum(present, expected), 0), expected


def _absent_from_nucleotides(
    residue_name: np.ndarray, residue_index: np.ndarray, name: np.ndarray, xyz: np.ndarray
) -> np.ndarray:
    """Return how many heavy atoms each residue (R,) may lack: O2' of DNA under the name of RNA, the phosphate of a 5' end."""
    absent = np.zeros(len(residue_name), int)
    nucleotide = np.isin(residue_name, [*NUCLEOTIDES_WITH_PHOSPHATE])
    if not nucleotide.any():
        return absent
    prime = np.char.replace(name.astype(str), "*", "'")
    atom = {
        atom_name: atoms_of_residues(residue_index, prime == atom_name, len(absent))
        for atom_name in ("P", "O2'", "O5'", "O3'")
    }
    absent += nucleotide & (atom["O2'"] < 0) & ~np.char.startswith(residue_name.astype(str), "D")
    before = xyz[atom["O3'"][atom["O3'"] >= 0]]
    for residue in np.flatnonzero(nucleotide & (atom["P"] < 0) & (atom["O5'"] >= 0)):
        distance = np.linalg.norm(before - xyz[atom["O5'"][residue]], axis=1)
        # At this distance, the two oxygens share a phosphorus that is missing
        bridged = (distance > MAX_RESIDUE_BOND) & (distance < MAX_PHOSPHATE)
        absent[residue] += 0 if bridged.any() else len(ATOMS_OF_PHOSPHATE)
    return absent


@cache
def element_of_symbol(symbol: str) -> str:
    """Return the element of a chemical symbol in upper case, hydrogen for its isotopes D and T; empty if it is none."""
    if symbol.upper() in ("D", "T"):
        return "H"
    name = gemmi.Element(symbol).name.upper()  # gemmi reads the first two letters of a longer word
    return name if name == symbol.upper() and name != "X" else ""


@cache
def element_of(element: str, name: str, residue_name: str, polymer: bool, alone: bool) -> str:
    """Return the element of an atom in upper case, or 'X': that of an ion, the input's if it is possible, else the name's.

    `alone` says that the atom is the only one of its residue, as an ion is.
    """
    element = element.upper()
    ion = _element_of_ion(name.upper(), residue_name.upper()) if alone and not polymer else ""
    if ion:
        return ion
    if element not in ("", "X", *NO_ELEMENTS) and (not polymer or element in POLYMER_ELEMENTS):
        return element
    letters = re.sub("[^A-Z]", "", name.upper().lstrip("0123456789'*"))
    if polymer:
        if ambiguous := AMBIGUOUS.get((standard_name(residue_name), name.upper())):
            return ambiguous
        selenium = residue_name in SELENIUM_RESIDUES and letters.startswith("SE")
        return "SE" if selenium else letters[:1] or "X"
    of_half = OF_EITHER_HALF if residue_name in TWO_HALVES else OF_A_HALF
    if not alone and of_half.fullmatch(name.upper()):
        return name[1].upper()
    lone = alone and residue_name.upper().startswith(letters[:2]) and gemmi.Element(letters[:2]).name != "X"
    return letters[:2] if lone or letters[:2] in LIGAND_ELEMENTS else letters[:1] or "X"


def _element_of_ion(name: str, residue_name: str) -> str:
    """Return the element of a residue of one atom whose names are those of an ion; empty if they are not."""
    atom, residue = (re.sub("[^A-Z]", "", text) for text in (name, residue_name))
    if residue in NAMES_OF_IONS:
        residue, residue_name = atom, name
    symbol = IONS.get(residue_name, residue)
    forms_ions = gemmi.Element(symbol).is_metal or symbol in HALOGENS
    return symbol if forms_ions and atom in (residue, symbol) else ""
