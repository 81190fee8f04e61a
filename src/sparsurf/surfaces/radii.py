"""Elements and atomic radii."""

import logging

import numpy as np

from sparsurf import InputError

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


def radii(molecule, table="dms"):
    """Atomic radii by element; the same with and without explicit hydrogens.

    Parameters
    ----------
    molecule : molecule.Molecule, or anything with `element` (A,) str
    table : 'dms' or 'bondi'

    Returns
    -------
    (A,) float64, Å

    Raises
    ------
    InputError : another table
    """
    if table not in list(RADII):  # a list: what a user gives may have no hash
        raise InputError(f"radii is {table!r}; it must be one of {', '.join(RADII)}.")
    values, other = RADII[table], OTHER[table]
    unknown = sorted(set(np.unique(molecule.element).tolist()) - values.keys())
    if unknown:
        log.warning("no %s radius for %s: %.2f Å is used", table, ", ".join(unknown), other)
    return np.array([values.get(each, other) for each in molecule.element], dtype=float)
