"""The element of an atom, from the file's column or from the atom's name."""

import re

import gemmi

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
