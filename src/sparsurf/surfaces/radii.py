"""Atomic radii by element."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.arguments import PROBE_RADIUS as PROBE_RADIUS  # re-exported: most users import it from here
from sparsurf.errors import InputError, argument

if TYPE_CHECKING:
    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

# Atomic radii, Å. 'dms': the table of UCSF's program DMS, which made the surfaces of the paper. 'bondi': van der
# Waals radii of Bondi, J. Phys. Chem. 68, 441 (1964). Deuterium counts as hydrogen; DMS treats selenium as sulphur.
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
# Radius of every other element, Å: the value of DMS, and the usual choice where Bondi gives none.
RADIUS_OF_OTHER_ELEMENTS = {"dms": 1.90, "bondi": 2.00}


def radii(molecule: Molecule, table: str = "dms") -> np.ndarray:
    """Look up atomic radii by element, (A,) Å, in the table 'dms' or 'bondi'; hydrogens do not change those of other atoms."""
    if table not in list(RADII):  # a list, since the value of a user may not be hashable
        raise InputError(f"{argument('radii')} is {table!r}; it must be one of {', '.join(RADII)}.")
    return radii_of_elements(molecule.element, table)


def radii_of_elements(element: np.ndarray, table: str) -> np.ndarray:
    """Return the radius of each element (A,), upper case, in a table, Å; warn of elements that it lacks."""
    by_element, default = RADII[table], RADIUS_OF_OTHER_ELEMENTS[table]
    unknown = sorted(set(np.unique(element).tolist()) - by_element.keys())
    if unknown:
        log.warning("no %s radius for %s: %.2f Å is used", table, ", ".join(unknown), default)
    return np.array([by_element.get(symbol, default) for symbol in element.tolist()], dtype=float)
