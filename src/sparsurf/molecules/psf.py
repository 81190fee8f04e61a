"""Read the atoms of a PSF file of CHARMM, NAMD or VMD: the names, labels and segments that it holds, as text.

A PSF has no elements. The builder takes them from the names: masses do not tell them, since simulations with long time steps
move mass from heavy atoms to their hydrogens.
"""

from __future__ import annotations

import re

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.files import shorten
from sparsurf.molecules.atom_table import AtomFile, atom_table, molecules_of_bonds
from sparsurf.molecules.pdb import NumberReader
from sparsurf.molecules.source import Source

SECTION = re.compile(r"\s*(\d+)\s*!N(ATOM|BOND)\b")
# Columns of segment, residue, its name, name and type of the atom, where a field is empty
FIXED_COLUMNS = ((9, 13), (14, 18), (19, 23), (24, 28), (29, 33))
EXTENDED = ((11, 19), (20, 28), (29, 37), (38, 46), (47, 53))
MIN_WORDS = 8  # number, segment, residue, its name, name, type, charge and mass
PSF_RESIDUE_LABEL = re.compile(r"(-?\d+)([A-Za-z]?)")
DRUDE_TYPE = "DRUD"


def read_psf(source: Source) -> AtomFile:
    """Read the atoms of a PSF file, with coordinates nan; raise InputError if it is none, or cut short."""
    lines = source.text().split("\n")
    extended = "EXT" in lines[0].split()
    sections = {
        match[2]: (k, int(match[1])) for k, line in enumerate(lines) if (match := SECTION.match(line))
    }
    if "ATOM" not in sections:
        raise InputError(f"{FILE} has no section !NATOM: give a PSF file with atoms.")
    begin, n_atoms = sections["ATOM"]
    rows = [line for line in lines[begin + 1 : begin + 1 + n_atoms] if line.strip()]
    if len(rows) < n_atoms or not n_atoms:
        raise InputError(f"{FILE} is cut short: it has {len(rows)} of {n_atoms} atoms; copy it again.")
    fields = [_fields(row, extended) for row in rows]
    read_number, labels = NumberReader(), []
    for k, (segid, label, *further) in enumerate(fields):
        residue = _residue(label, segid, read_number)
        if residue is None or not all(further[:2]):
            raise InputError(
                f"{FILE}: line {begin + 2 + k} is no atom of a PSF file, {shorten(repr(rows[k].strip()))}: repair the line."
            )
        labels.append(residue)
    segids, _, residue_names, names, types = map(list, zip(*fields, strict=True))
    atoms = atom_table(
        name=names,
        residue_name=residue_names,
        chain=segids,
        segid=segids,
        residue=labels,
        # a Drude particle is no atom, and has the element of none
        element=["VS" if atom_type == DRUDE_TYPE else "" for atom_type in types],
    )
    bonds = _bonds(lines, sections.get("BOND", (len(lines), 0)), n_atoms)
    return AtomFile(atoms.assign(molecule=molecules_of_bonds(atoms, bonds)))


def _fields(row: str, extended: bool) -> tuple[str, ...]:
    """Return segment, residue, its name, name and type of an atom: words, or columns if a word is missing."""
    columns = row.split()
    if len(columns) > MIN_WORDS or (len(columns) == MIN_WORDS and PSF_RESIDUE_LABEL.fullmatch(columns[2])):
        return tuple(columns[1:6])
    if len(columns) == MIN_WORDS and PSF_RESIDUE_LABEL.fullmatch(columns[1]):  # the segment is blank
        return ("", *columns[1:5])
    return tuple(row[first:last].strip() for first, last in (EXTENDED if extended else FIXED_COLUMNS))


def _residue(label: str, segid: str, read_number: NumberReader) -> str | None:
    """Return the number with insertion code of a label, which may be hexadecimal beyond 9999; None if it is none."""
    number = read_number(label, segid) if len(label) == 4 and not label.isdecimal() else None
    if number is not None:
        return number
    match = PSF_RESIDUE_LABEL.fullmatch(label)
    if match is None:
        return None
    number = read_number(match[1], segid) if len(match[1]) <= 4 else match[1]
    return f"{int(number or match[1])}{match[2]}"


def _bonds(lines: list[str], section: tuple[int, int], n_atoms: int) -> np.ndarray:
    """Return the bonds (B, 2) of a PSF file, numbers of atoms from 0; columns of eight or ten digits may touch."""
    begin, n_bonds = section
    numbers: list[int] = []
    for line in lines[begin + 1 :]:
        if len(numbers) >= 2 * n_bonds or "!" in line:
            break
        texts = line.split()
        if texts and not all(word.isdecimal() and len(word) <= 10 for word in texts):
            break
        numbers += map(int, texts)
    bonds = np.array(numbers[: 2 * n_bonds], int)
    if len(bonds) < 2 * n_bonds or (len(bonds) and not 1 <= bonds.min() <= bonds.max() <= n_atoms):
        raise InputError(
            f"{FILE} announces {n_bonds} bonds and holds {len(bonds) // 2} between its {n_atoms} atoms: it is cut short or "
            "damaged; copy it again."
        )
    return bonds.reshape(-1, 2) - 1
