"""Read the atoms of a GRO file of GROMACS: names, residues and positions in columns.

The format: https://manual.gromacs.org/current/reference-manual/file-formats.html#gro
"""

from __future__ import annotations

from sparsurf.errors import FILE, InputError
from sparsurf.molecules.atom_table import AtomFile, atom_table
from sparsurf.molecules.source import Source
from sparsurf.molecules.text_frames import (
    Lines,
    box_of_gro,
    check_box_of_gro,
    count_of,
    numbers_of_box,
    positions_of_gro,
)


def read_gro(source: Source) -> AtomFile:
    """Read the atoms of the first frame of a GRO file; raise InputError, with the line, where it violates the columns."""
    with source.lines() as stream:
        lines = Lines(stream)
        lines.next()  # the title
        n_atoms = count_of(lines, lines.next(), "give a GRO file")
        rows = [line for _ in range(n_atoms) if (line := lines.next()) is not None]
        xyz = positions_of_gro(lines, rows, 2)
        if len(rows) < n_atoms:
            raise InputError(f"{FILE} is cut short: it has {len(rows)} of {n_atoms} atoms; copy it again.")
        box = lines.next()
        check_box_of_gro(lines, box)
    if not rows:
        raise InputError(f"{FILE} holds no atoms: give a GRO file with atoms.")
    numbers = [row[:5].strip() for row in rows]
    wrong = next((k for k, number in enumerate(numbers) if not number.removeprefix("-").isdecimal()), None)
    if wrong is not None:
        raise InputError(f"{FILE}: line {wrong + 3} is not in the columns of a GRO file: repair the line.")
    atoms = atom_table(
        name=[row[10:15].strip() for row in rows],
        residue_name=[row[5:10].strip() for row in rows],
        residue=[str(int(number)) for number in numbers],
        **dict(zip("xyz", xyz.T, strict=True)),
    )
    return AtomFile(atoms, box_of_gro(numbers_of_box(box or "")))
