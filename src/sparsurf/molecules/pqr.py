"""Read PQR files: positions, charges and radii of atoms, in words between blanks or in the columns of a PDB file.

The format: https://apbs.readthedocs.io/en/latest/formats/pqr.html; pdb2pqr writes the columns of a PDB file unless
it is asked for blanks.
"""

from __future__ import annotations

import logging
import re
from typing import NamedTuple

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.files import ends_within_a_row
from sparsurf.molecules.residues import element_of_symbol

log = logging.getLogger("sparsurf")

N_NUMBERS = 5  # x, y, z, charge and radius at the end of a line
# A line without a chain has so many words; ATOM, serial, name, residue name and number come first.
N_WORDS = 10
POINTS = (34, 42, 50)  # columns of the decimal points of x, y and z in a PDB file
TOUCHING_NUMBERS = re.compile(r"\d\.\d+-\d|(\.\d+){2}")
MAX_CHARGE = 10  # e; no atom has more
MAX_MEDIAN_CHARGE = 0.5  # e; half of the charges of a molecule are lower, whereas radii are not
MIN_ATOMS_OF_MOLECULE = 3  # fewer may be ions
MAX_RADIUS = 10.0  # Å; no atom has more


class PqrAtoms(NamedTuple):
    """Atoms of a PQR file.

    Attributes
    ----------
    xyz : (A, 3) float64, Å
    charge : (A,) float64, e
    radius : (A,) float64, Å; some force fields give hydrogens 0
    names : (A,) str
    """

    xyz: np.ndarray
    charge: np.ndarray
    radius: np.ndarray
    names: list[str]


def read_pqr(text: str) -> PqrAtoms:
    """Read the atoms of the first model of a PQR file; raise InputError, with the line, where a number lacks or cannot be."""
    rows: list[list[float]] = []
    names: list[str] = []
    numbers: list[int] = []  # of their lines
    ended = False
    for number, line in enumerate(text.split("\n"), 1):
        if line.startswith(("MODEL", "ENDMDL", "END")):
            ended = bool(rows)
        elif line.startswith(("ATOM", "HETATM")):
            if ended:
                log.warning("%s holds several models: the first is read", FILE)
                break
            name, values = _atom(line, number)
            names.append(name)
            rows.append(values)
            numbers.append(number)
    if not rows:
        raise InputError(f"{FILE} holds no atoms: give a PQR file, as pdb2pqr writes it.")
    if text.rpartition("\n")[2].startswith(("ATOM", "HETATM")) and ends_within_a_row(text):
        raise InputError(
            f"{FILE} is cut short: line {text.count(chr(10)) + 1} is not complete; copy it again."
        )
    table = np.array(rows)
    atoms = PqrAtoms(table[:, :3].copy(), table[:, 3].copy(), table[:, 4].copy(), names)
    _refuse_other_columns(atoms)
    possible = np.isfinite(table).all(axis=1) & (np.abs(atoms.charge) <= MAX_CHARGE)
    possible &= (atoms.radius >= 0) & (atoms.radius <= MAX_RADIUS)
    if not possible.all():
        row = int(np.argmin(possible))
        listed = ", ".join(f"{value:g}" for value in table[row])
        raise InputError(
            f"{FILE}: line {numbers[row]} ends in {listed}, and no atom has such a position (Å), charge (e) and radius "
            "(Å); repair it."
        )
    return atoms


def _atom(line: str, number: int) -> tuple[str, list[float]]:
    """Return the name and the five numbers of an atom; an element may follow them."""
    name, texts = line[12:16].strip(), line.split()
    in_columns = all(line[column : column + 1] == "." for column in POINTS)
    if not in_columns and len(texts) > 2:
        name = texts[2]
    if element_of_symbol(texts[-1]):
        texts.pop()
    values = _numbers(texts[-N_NUMBERS:])
    if values and _is_complete(texts):
        return name, values
    if in_columns:
        behind = [word for word in line[54:].split() if not element_of_symbol(word)]
        values = _numbers([line[30:38], line[38:46], line[46:54], *behind])
        if len(values) == N_NUMBERS:
            return name, values
    advice = "its columns touch; separate them by blanks" if TOUCHING_NUMBERS.search(line) else "repair it"
    raise InputError(f"{FILE}: line {number} does not end in x, y, z, charge and radius: {advice}.")


def _numbers(texts: list[str]) -> list[float]:
    """Return words as numbers; none if one is no number."""
    try:
        return [float(word) for word in texts]
    except ValueError:
        return []


def _is_complete(texts: list[str]) -> bool:
    """Return whether the last five words are those of an atom: if one is missing, the number of the residue is among them.

    The names and numbers of other columns may touch.
    """
    numbers = texts[-N_NUMBERS:]
    if len(texts) < N_NUMBERS + 3 or len({"." in word for word in numbers[:3]}) > 1:
        return False
    with_points = all("." in word for word in numbers)
    return with_points or len(texts) > N_WORDS or (len(texts) == N_WORDS and not texts[4].isalpha())


def _refuse_other_columns(atoms: PqrAtoms) -> None:
    """Raise InputError if the columns of charge and radius hold something else: each other, or occupancy and B factor."""
    if not np.median(atoms.charge) > MAX_MEDIAN_CHARGE:
        return
    if len(atoms.charge) >= MIN_ATOMS_OF_MOLECULE or np.median(atoms.radius) <= MAX_MEDIAN_CHARGE:
        raise InputError(
            f"{FILE}: half of its charges are above {MAX_MEDIAN_CHARGE} e, as where charge and radius change places, or in a PDB "
            "file: exchange charge and radius, or give a PQR file."
        )
