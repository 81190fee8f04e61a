"""Read the atoms of a coordinate file of CHARMM (CARD): names, labels, segments and positions in columns."""

from __future__ import annotations

import re

from sparsurf.errors import FILE, InputError
from sparsurf.molecules.atom_table import AtomFile, atom_table
from sparsurf.molecules.source import Source
from sparsurf.molecules.text_frames import Lines, lines_of_card, positions_of_card


def read_card(source: Source) -> AtomFile:
    """Read the atoms of a CARD file; raise InputError, with the line, where it violates the columns."""
    with source.lines() as stream:
        lines = Lines(stream)
        rows, columns, begin = lines_of_card(lines)
        if not rows:
            raise InputError(f"{FILE} is cut short: it has fewer atoms than it announces; copy it again.")
        xyz = positions_of_card(lines, rows, columns, begin)
    fields = [[row[first:last].strip() for first, last in columns] for row in rows]
    _, number, residue_name, name, *_, segid, label = map(list, zip(*fields, strict=True))
    labels = [of_segment or of_file for of_segment, of_file in zip(label, number, strict=True)]
    wrong = next((k for k, text in enumerate(labels) if not re.fullmatch(r"-?\d+[A-Za-z]?", text)), None)
    if wrong is not None:
        raise InputError(f"{FILE}: line {begin + wrong + 1} has no number of a residue: repair the line.")
    return AtomFile(
        atom_table(
            name=name,
            residue_name=residue_name,
            chain=segid,
            segid=segid,
            residue=labels,
            unit=number_runs(number),
            **dict(zip("xyz", xyz.T, strict=True)),
        )
    )


def number_runs(values: list[str]) -> list[int]:
    """Return a number for each value that changes where the value does."""
    runs: list[int] = []
    before = None
    for value in values:
        runs.append((runs[-1] if runs else -1) + (value != before))
        before = value
    return runs
