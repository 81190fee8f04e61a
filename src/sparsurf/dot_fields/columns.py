"""A column of a user's table, with a value per residue or atom, as values of a molecule's atoms."""

from __future__ import annotations

import csv
import io
import logging
import os
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import FILE, InputError, naming_file
from sparsurf.files import read_text
from sparsurf.molecules.names import usual_names
from sparsurf.molecules.residues import standard_name
from sparsurf.surfaces.surface import COMPONENT_FIELD, is_field_name

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

# Columns that identify the atoms of a row; a scale has `residue_name` in place of `residue`
ATOM_KEYS = ("chain", "residue", "atom")


def values_from_rows(table: pd.DataFrame, name: str, molecule: Molecule) -> np.ndarray:
    """Return a column of a table of residues or atoms, as `areas` has them, for the molecule's atoms, (A,); NaN if unknown."""
    if "residue" not in table.columns:
        raise InputError(f"{FILE} has no column residue: give a table with rows of residues or atoms.")
    if "atom_name" in table.columns:  # beside which `atom` is its number
        table = table.drop(columns="atom", errors="ignore").rename(columns={"atom_name": "atom"})
    return _values_of_atoms(table.astype(object).where(table.notna(), "").astype(str), name, molecule)


def column_of_atoms(path: str | os.PathLike[str], name: str, molecule: Molecule) -> np.ndarray:
    """Read a column of a CSV with `residue` and, where they matter, `chain` and `atom`, for the atoms, (A,); NaN if unknown."""
    with naming_file(path):
        values = _values_of_atoms(_cells(read_text(path)), name, molecule)
        if name == COMPONENT_FIELD or not is_field_name(name):
            raise InputError(
                f"{FILE}: {name!r} cannot name a field; rename the column, to letters, digits and _ that mean nothing else."
            )
        return values


def columns_of(path: str | os.PathLike[str]) -> list[str]:
    """Return the names of the columns of a table, see `column_of_atoms`."""
    with naming_file(path):
        return [*_cells(read_text(path)).columns]


def _values_of_atoms(table: pd.DataFrame, name: str, molecule: Molecule) -> np.ndarray:
    """Return a column of a table for the atoms, (A,); NaN if unknown."""
    import pandas as pd

    number = "residue" if "residue" in table.columns else "residue_name"
    if name not in table.columns or name in (*ATOM_KEYS, number):
        raise InputError(f"{FILE} has no column {name!r} of values; it has {', '.join(table.columns)}.")
    values = pd.to_numeric(table[name], errors="coerce").replace([np.inf, -np.inf], np.nan)
    wrong = table[values.isna() & (table[name] != "")]
    if len(wrong):
        raise InputError(
            f"{FILE}, row {wrong.index[0] + 1}: {name} is {wrong[name].iloc[0]!r}, not a number."
        )
    keys = [key for key in ("chain", number, "atom") if key in table.columns]
    labels = {
        "chain": molecule.chain, "residue": molecule.residue, "residue_name": molecule.residue_name, "atom": molecule.name,
    }  # fmt: skip
    if table.duplicated(keys).any():
        raise InputError(
            f"{FILE} has two rows for one {keys[-1].replace('_', ' ')}; add the column chain, or keep one of them."
        )
    rows = pd.Series(values.to_numpy(float), index=pd.MultiIndex.from_frame(table[keys]))
    of_atoms = rows.reindex(pd.MultiIndex.from_arrays([labels[key] for key in keys])).to_numpy()
    if "atom" in keys and np.isnan(of_atoms).any():  # atoms that the table may call by their usual names
        labels["atom"] = usual_names(molecule.residue_name, molecule.name)
        usual = rows.reindex(pd.MultiIndex.from_arrays([labels[key] for key in keys])).to_numpy()
        of_atoms = np.where(np.isnan(of_atoms), usual, of_atoms)
    if (
        number == "residue_name" and np.isnan(of_atoms).any()
    ):  # such as HIE of a force field for HIS of a scale
        labels[number] = np.array([standard_name(name) for name in molecule.residue_name.tolist()])
        usual = rows.reindex(pd.MultiIndex.from_arrays([labels[key] for key in keys])).to_numpy()
        of_atoms = np.where(np.isnan(of_atoms), usual, of_atoms)
    n_known = int(np.isfinite(of_atoms).sum())
    if n_known == 0:
        raise InputError(
            f"{FILE}: no row fits a residue of the molecule; check the columns {', '.join(keys)}."
        )
    log.info("%s: %d of %d atoms have a value of %s", FILE, n_known, len(of_atoms), name)
    return of_atoms


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
