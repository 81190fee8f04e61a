"""A column of a user's table, a value for each residue or atom, as values of a molecule's atoms."""

import csv
import io
import logging

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.surfaces.components import COMPONENT_FIELD
from sparsurf.surfaces.surface import ARRAY_NAMES, is_field_name
from sparsurf.texts import read_text

log = logging.getLogger("sparsurf")

KEYS = ("chain", "residue", "atom")  # columns that say where a row belongs; `residue` must be there
TAKEN = frozenset(
    [*ARRAY_NAMES, "file", "allow_pickle"]
)  # names that something else has in numpy's files of dots


def column_of_atoms(path, name, molecule):
    """Values of a column at the atoms of a molecule.

    Parameters
    ----------
    path : CSV with `residue` (number with insertion code) and, where these matter, `chain` and `atom` (its name)
    name : str, the column
    molecule : Molecule

    Returns
    -------
    (A,) float64, NaN for atoms that no row is about

    Raises
    ------
    InputError : no such column, a value that is no number, or no row that fits the molecule
    """
    table = _read(path)
    if name not in table.columns or name in KEYS:
        raise InputError(f"{path} has no column {name!r} of values; it has {', '.join(table.columns)}.")
    if name == COMPONENT_FIELD or not is_field_name(name):
        raise InputError(
            f"{path}: {name!r} cannot name a field; rename the column, to letters, digits and _ that mean nothing else."
        )
    values = pd.to_numeric(table[name], errors="coerce").replace([np.inf, -np.inf], np.nan)
    wrong = table[values.isna() & (table[name] != "")]
    if len(wrong):
        raise InputError(
            f"{path}, row {wrong.index[0] + 1}: {name} is {wrong[name].iloc[0]!r}, not a number."
        )
    keys = [key for key in KEYS if key in table.columns]
    of_atoms = {"chain": molecule.chain, "residue": molecule.residue, "atom": molecule.name}
    if table.duplicated(keys).any():
        raise InputError(
            f"{path} has two rows for one {keys[-1]}; add the column chain, or keep one of them."
        )
    rows = pd.Series(values.to_numpy(float), index=pd.MultiIndex.from_frame(table[keys]))
    found = rows.reindex(pd.MultiIndex.from_arrays([of_atoms[key] for key in keys])).to_numpy()
    if not np.isfinite(found).any():
        raise InputError(
            f"{path}: no row fits a residue of the molecule; check the columns {', '.join(keys)}."
        )
    log.info("%s: %s is known of %d of %d atoms", path, name, np.isfinite(found).sum(), len(found))
    return found


def columns_of(path):
    """Names of the columns of a table, see `column_of_atoms`."""
    return [*_read(path).columns]


def _read(path):
    """The cells of a table, without blanks around them."""
    lines = io.StringIO(read_text(path), "")
    try:
        rows = [
            [cell.strip() for cell in row]
            for row in csv.reader(lines, skipinitialspace=True, strict=True)
            if row
        ]
    except csv.Error as error:
        raise InputError(
            f"{path} is no table with commas between its columns ({error}): repair it."
        ) from None
    header, rows = (rows[0], rows[1:]) if rows else ([], [])
    if "residue" not in header:
        raise InputError(f"{path} has no column residue; it must say which residue a row is about.")
    if twice := [name for name in header if name and header.count(name) > 1]:
        raise InputError(f"{path} has the column {twice[0]!r} twice; remove or rename one.")
    for number, row in enumerate(rows, 1):
        if len(row) != len(header):
            raise InputError(f"{path}, row {number}: it has {len(row)} values, not {len(header)}; repair it.")
    return pd.DataFrame(rows, columns=header, dtype=str)
