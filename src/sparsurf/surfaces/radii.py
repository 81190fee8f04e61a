"""Atomic radii: tables by element, and those of the user."""

from __future__ import annotations

import csv
import logging
import os
from collections.abc import Mapping
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sparsurf.arguments import LENGTH
from sparsurf.arguments import PROBE_RADIUS as PROBE_RADIUS  # re-exported: most users import it from here
from sparsurf.errors import InputError, argument, naming_file
from sparsurf.files import read_text

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


# What a row of the user can name; of two rows that fit an atom, the one that names more is closer, then the first of these
KEYS = "atom", "residue_name", "element"
LARGEST_IN_NM = 0.5  # Å; no atom is so small, and no radius in nm so large


class OwnRadii(NamedTuple):
    """Radii of the user: Å, by name of the atom, residue name and element, each empty where it does not matter."""

    source: str
    rows: tuple[tuple[tuple[str, ...], float], ...]

    def __str__(self) -> str:
        return self.source

    def of(self, molecule: Molecule) -> np.ndarray:
        """Return the radius of each atom, (A,) Å, by the closest row."""
        rows = dict(self.rows)
        masks = sorted(product((True, False), repeat=len(KEYS)), key=sum, reverse=True)
        labels = [
            *zip(
                molecule.name.tolist(),
                np.char.upper(molecule.residue_name).tolist(),
                molecule.element.tolist(),
                strict=True,
            )
        ]
        found = {}
        for label in dict.fromkeys(labels):
            keys = [tuple(word * used for word, used in zip(label, mask, strict=True)) for mask in masks]
            found[label] = next((rows[key] for key in keys if key in rows), 0.0)
            if not found[label]:
                k = labels.index(label)
                raise InputError(
                    f"{self.source} has no radius for {label[0]} of {molecule.residue_label(k)}; add a row."
                )
        return np.array([found[label] for label in labels])


def check_radii(radii: Any) -> Any:
    """Return the name of a table, or the radii of a user: by element, or of a CSV; raise InputError for others."""
    if isinstance(radii, OwnRadii) or (isinstance(radii, str) and radii in RADII):
        return radii
    if isinstance(radii, Mapping):
        source, rows = "the dictionary of radii", [{"element": k, "radius": v} for k, v in radii.items()]
    elif isinstance(radii, os.PathLike) or (isinstance(radii, str) and os.path.exists(radii)):
        with naming_file(radii):
            lines = read_text(radii).splitlines()
        reader = csv.DictReader(lines, skipinitialspace=True)
        source, rows, header = os.fspath(radii), [*reader], [name.strip() for name in reader.fieldnames or []]
        if repeated := [name for name in header if header.count(name) > 1]:
            raise InputError(f"{source} has the column {repeated[0]!r} twice; remove or rename one.")
        if unread := [name for name in header if name not in (*KEYS, "radius")]:
            message = "%s: the columns %s are not read; atoms are those of the columns %s"
            log.warning(message, source, ", ".join(unread), ", ".join(KEYS))
    else:
        raise InputError(
            f"{argument('radii')} is {radii!r}; it must be {', '.join(RADII)}, or the path of a CSV with the column radius."
        )
    found: dict[tuple[str, ...], float] = {}
    for row in rows:
        atom, *names = (str(row.get(name) or "").strip() for name in KEYS)
        key = (atom, *(name.upper() for name in names))
        try:
            radius = float(row["radius"])
        except (KeyError, TypeError, ValueError):
            radius = 0.0
        if (
            key in found or not any(key) or not LENGTH.allow(radius) or None in row
        ):  # a cell beyond the header
            raise InputError(
                f"{source}: the row {row} is none of radii; it needs {' or '.join(KEYS)}, once, and radius, {LENGTH.words} (Å)."
            )
        found[key] = radius
    if found and (largest := max(found.values())) < LARGEST_IN_NM:
        log.warning("%s: the largest radius is %g Å; if they are in nm, multiply them by 10", source, largest)
    return OwnRadii(source, tuple(found.items()))


def radii(molecule: Molecule, table: Any = "dms") -> np.ndarray:
    """Look up atomic radii, (A,) Å, by element or in a table of the user; hydrogens do not change those of other atoms."""
    table = check_radii(table)
    return table.of(molecule) if isinstance(table, OwnRadii) else radii_of_elements(molecule.element, table)


def radii_of_elements(element: np.ndarray, table: str) -> np.ndarray:
    """Return the radius of each element (A,), upper case, in a table, Å; warn of elements that it lacks."""
    by_element, default = RADII[table], RADIUS_OF_OTHER_ELEMENTS[table]
    unknown = sorted(set(np.unique(element).tolist()) - by_element.keys())
    if unknown:
        log.warning("no %s radius for %s: %.2f Å is used", table, ", ".join(unknown), default)
    return np.array([by_element.get(symbol, default) for symbol in element.tolist()], dtype=float)
