"""Elements and atomic radii."""

import logging
import re

import gemmi
import numpy as np

log = logging.getLogger("sparsurf")

# Å. 'dms': the table of UCSF's program DMS, which the paper's surfaces were made with. 'bondi': van der
# Waals radii of Bondi, J. Phys. Chem. 68, 441 (1964). Deuterium is hydrogen; DMS takes selenium for sulphur.
RADII = {
    "dms": {
        "H": 1.20, "D": 1.20, "C": 1.90, "N": 1.50, "O": 1.40, "S": 1.85, "SE": 1.85, "P": 1.90, "F": 1.35,
        "CL": 1.80, "BR": 1.95, "I": 2.15, "FE": 0.64, "CU": 1.28, "ZN": 1.38,
    },
    "bondi": {
        "H": 1.20, "D": 1.20, "C": 1.70, "N": 1.55, "O": 1.52, "S": 1.80, "SE": 1.90, "P": 1.80, "F": 1.47,
        "CL": 1.75, "BR": 1.85, "I": 1.98, "SI": 2.10, "AS": 1.85, "TE": 2.06, "LI": 1.82, "NA": 2.27,
        "MG": 1.73, "K": 2.75, "NI": 1.63, "CU": 1.40, "ZN": 1.39, "PD": 1.63, "AG": 1.72, "CD": 1.58,
        "IN": 1.93, "SN": 2.17, "PT": 1.75, "AU": 1.66, "HG": 1.55, "TL": 1.96, "PB": 2.02, "GA": 1.87,
    },
}  # fmt: skip
# Å, every other element: DMS's value, and the usual choice where Bondi gives none.
OTHER = {"dms": 1.90, "bondi": 2.00}

# Elements that occur in a polymer's residues. Anything else there is an atom name misread: a left-shifted
# CA became calcium, HG mercury, CD1 cadmium.
POLYMER_ELEMENTS = frozenset(["H", "D", "C", "N", "O", "S", "SE", "P", "F", "CL", "BR", "I", "B"])
SELENIUM_RESIDUES = frozenset(["MSE", "SEC", "CSE"])
# Two-letter elements that the name of a ligand's atom may begin with; others (CA, CD, HG, ...) are more
# often a carbon or a hydrogen.
LIGAND_ELEMENTS = frozenset(["FE", "ZN", "MG", "MN", "CU", "CL", "BR", "SE", "SI"])


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


def radii(molecule, table="dms"):
    """Atomic radii by element; the same with and without explicit hydrogens.

    Parameters
    ----------
    molecule : molecule.Molecule, or anything with `element` (A,) str
    table : 'dms' or 'bondi'

    Returns
    -------
    (A,) float64, Å
    """
    values, other = RADII[table], OTHER[table]
    unknown = sorted(set(np.unique(molecule.element).tolist()) - values.keys())
    if unknown:
        log.warning("no %s radius for %s: %.2f Å is used", table, ", ".join(unknown), other)
    return np.array([values.get(each, other) for each in molecule.element], dtype=float)
