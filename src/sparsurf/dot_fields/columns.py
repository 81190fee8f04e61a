"""A column of a user's table, with a value per residue or atom, as values of a molecule's atoms."""

from __future__ import annotations

import csv
import io
import logging
import os
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import FILE, InputError, naming_file
from sparsurf.files import pluralise, read_text
from sparsurf.molecules.names import usual_names
from sparsurf.molecules.residues import known_kind, standard_name
from sparsurf.surfaces.surface import COMPONENT_FIELD, is_field_name

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

# Columns that identify the atoms of a row; a scale has `residue_name` in place of `residue`
ATOM_KEYS = ("chain", "residue", "atom")
N_ROWS_NAMED = 3  # A warning names so many rows.


def values_from_rows(table: pd.DataFrame, name: str, molecule: Molecule) -> np.ndarray:
    """Return a column of a table of residues or atoms, as `areas` has them, for the molecule's atoms, (A,); NaN if unknown."""
    if "residue" not in table.columns:
        raise InputError(f"{FILE} has no column residue: give a table with rows of residues or atoms.")
    if "atom_name" in table.columns:  # beside which `atom` is its number
        table = table.drop(columns="atom", errors="ignore").rename(columns={"atom_name": "atom"})
    return TableOfAtoms(table.astype(object).where(table.notna(), "").astype(str), molecule).values(name)


def columns_of(path: str | os.PathLike[str]) -> list[str]:
    """Return the names of the columns of a table, see `TableOfAtoms`."""
    with naming_file(path):
        return [*_cells(read_text(path)).columns]


class TableOfAtoms:
    """The cells of a table with `residue`, or `residue_name` of a scale, and, where they matter, `chain` and `atom`."""

    def __init__(self, cells: pd.DataFrame, molecule: Molecule, path: str | os.PathLike[str] = "") -> None:
        """Take the cells as strings."""
        self.cells, self._molecule, self._path = cells, molecule, path
        self._number = "residue" if "residue" in cells.columns else "residue_name"
        self._keys = [key for key in ("chain", self._number, "atom") if key in cells.columns]

    @classmethod
    def read(cls, path: str | os.PathLike[str], molecule: Molecule) -> TableOfAtoms:
        """Read a CSV for the atoms of a molecule."""
        with naming_file(path):
            return cls(_cells(read_text(path)), molecule, path)

    def field(self, name: str) -> np.ndarray:
        """Return a column that is to be a field, for the atoms, (A,); NaN if unknown."""
        with naming_file(self._path):
            values = self.values(name)
            if name == COMPONENT_FIELD or not is_field_name(name):
                raise InputError(
                    f"{FILE}: {name!r} cannot name a field; rename the column, to letters, digits and _ that mean nothing else."
                )
            return values

    def values(self, name: str) -> np.ndarray:
        """Return a column for the atoms, (A,); NaN if unknown."""
        import pandas as pd

        cells = self.cells
        if name not in cells.columns or name in (*ATOM_KEYS, self._number):
            raise InputError(f"{FILE} has no column {name!r} of values; it has {', '.join(cells.columns)}.")
        values = pd.to_numeric(cells[name], errors="coerce").replace([np.inf, -np.inf], np.nan)
        wrong = cells[values.isna() & (cells[name] != "")]
        if len(wrong):
            raise InputError(
                f"{FILE}, row {wrong.index[0] + 1}: {name} is {wrong[name].iloc[0]!r}, not a number."
            )
        of_atoms = np.append(values.to_numpy(float), np.nan)[self._row]
        n_known = int(np.isfinite(of_atoms).sum())
        if n_known == 0:
            raise InputError(
                f"{FILE}: no row fits a residue of the molecule; check the columns {', '.join(self._keys)}."
            )
        log.info("%s: %d of %d atoms have a value of %s", FILE, n_known, len(of_atoms), name)
        return of_atoms

    @cached_property
    def _row(self) -> np.ndarray:
        """The row of each atom, (A,), -1 for none; rows that fit no residue are told, and those of another name refused."""
        import pandas as pd

        cells, molecule, keys = self.cells.copy(), self._molecule, self._keys
        if "residue_name" in cells.columns:
            cells["residue_name"] = cells["residue_name"].str.upper()
        if cells.duplicated(keys).any():
            raise InputError(
                f"{FILE} has two rows for one {keys[-1].replace('_', ' ')}; add the column chain, or keep one of them."
            )
        names = np.char.upper(molecule.residue_name.astype(str))
        usual = {  # names that a table may use for atoms, and for residues such as HIE of a force field
            "residue_name": lambda: np.array([_usual_name(name) for name in names.tolist()]),
            "atom": lambda: usual_names(molecule.residue_name, molecule.name),
        }
        labels = {
            "chain": molecule.chain, "residue": molecule.residue, "residue_name": names, "atom": molecule.name,
        }  # fmt: skip
        index = pd.MultiIndex.from_frame(cells[keys])
        row = index.get_indexer(pd.MultiIndex.from_arrays([labels[key] for key in keys]))
        for key in keys:
            if key in usual and (row < 0).any():
                labels[key] = usual[key]()
                found = index.get_indexer(pd.MultiIndex.from_arrays([labels[key] for key in keys]))
                row = np.where(row < 0, found, row)
        if self._number == "residue" and "residue_name" in cells.columns:
            row = self._of_one_name(row, cells["residue_name"].tolist(), names)
        elif self._number == "residue":
            self._report_shared(row, names)
        self._report_unused(np.setdiff1d(np.arange(len(cells)), row), names)
        return row

    def _of_one_name(self, row: np.ndarray, given: list[str], names: np.ndarray) -> np.ndarray:
        """Return the row of each atom, -1 if its residue has another name; refuse rows that only fit residues of other names."""
        agrees = [
            k < 0 or given[k] == "" or _usual_name(given[k]) == _usual_name(name)
            for k, name in zip(row.tolist(), names.tolist(), strict=True)
        ]
        agreed = np.where(agrees, row, -1)
        wrong = np.setdiff1d(row, agreed)
        if len(wrong):
            residue = self._molecule.residue_label(int(np.flatnonzero(row == wrong[0])[0]))
            raise InputError(
                f"{FILE}, row {wrong[0] + 1}: residue_name is {given[wrong[0]]}, and the molecule has {residue} there"
                f" ({pluralise(len(wrong), 'row')} disagree); number the rows as the molecule is. Of a mutant, leave"
                " residue_name blank in rows of mutated residues."
            )
        return agreed

    def _report_shared(self, row: np.ndarray, names: np.ndarray) -> None:
        """Warn of rows that fit residues of different names, such as those of two chains."""
        first: dict[int, int] = {}
        shared: dict[int, int] = {}
        for atom, (k, name) in enumerate(zip(row.tolist(), names.tolist(), strict=True)):
            if k >= 0 and names[first.setdefault(k, atom)] != name:
                shared.setdefault(k, atom)
        if shared:
            k, atom = next(iter(shared.items()))
            message = "%s: %d of %d rows fit residues of different names, such as row %d, which fits %s and %s; add the column %s"
            residues = (self._molecule.residue_label(atom) for atom in (first[k], atom))
            missing = "residue_name" if "chain" in self._keys else "chain"
            log.warning(message, FILE, len(shared), len(self.cells), k + 1, *residues, missing)

    def _report_unused(self, unused: np.ndarray, names: np.ndarray) -> None:
        """Warn of rows that fit no atom, but for known residues of a scale that the molecule lacks; that none fits is refused."""
        labels = [" ".join(self.cells.loc[k, self._keys]) for k in unused.tolist()]
        if self._number == "residue_name":
            given = self.cells["residue_name"][unused].str.upper()
            labels = [
                label
                for label, name in zip(labels, given, strict=True)
                if name in names or known_kind(name) == "other"
            ]
        if labels and len(unused) < len(self.cells):
            named = ", ".join(labels[:N_ROWS_NAMED]) + (", ..." if len(labels) > N_ROWS_NAMED else "")
            message = "%s: %d of %d rows name no residue or atom of the molecule: %s"
            log.warning(message, FILE, len(labels), len(self.cells), named)


def _usual_name(name: str) -> str:
    """Return the standard name of a residue in capitals, with MET for MSE."""
    return "MET" if name == "MSE" else standard_name(name)


def _cells(text: str) -> pd.DataFrame:
    """Return the cells of a table as strings, without surrounding blanks."""
    import pandas as pd

    reader = csv.reader(io.StringIO(text, ""), skipinitialspace=True, strict=True)
    try:
        rows = [[cell.strip() for cell in row] for row in reader if row]
    except csv.Error as error:
        raise InputError(
            f"{FILE} is not a table with commas between its columns ({error}): repair it."
        ) from None
    while rows and not any(rows[-1]):  # a spreadsheet writes lines of commas below a table
        rows.pop()
    header, rows = (rows[0], rows[1:]) if rows else ([], [])
    if not {"residue", "residue_name"} & {*header}:
        raise InputError(
            f"{FILE} has no column residue, or residue_name of a scale, which identifies the residue of a row, but "
            f"{', '.join(header) or 'nothing'}: name it so, with commas between the columns."
        )
    if repeated := [name for name in header if name and header.count(name) > 1]:
        raise InputError(f"{FILE} has the column {repeated[0]!r} twice; remove or rename one.")
    for number, row in enumerate(rows, 1):
        if len(row) != len(header):
            raise InputError(f"{FILE}, row {number}: it has {len(row)} values, not {len(header)}; repair it.")
    return pd.DataFrame(rows, columns=header, dtype=str)
