"""A column of a user's table, a value for each residue or atom, as values of a molecule's atoms."""

import io
import logging

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.surfaces.components import FIELD
from sparsurf.surfaces.surface import is_field
from sparsurf.texts import read_text

log = logging.getLogger("sparsurf")

KEYS = ("chain", "residue", "atom")  # columns that say where a row belongs; `residue` must be there


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
    if name == FIELD or not is_field(name):
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
    try:
        table = pd.read_csv(
            io.StringIO(read_text(path)), dtype=str, skipinitialspace=True, keep_default_na=False
        )
    except (pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise InputError(f"{path} is not a table: {str(error).strip()}.") from None
    table.columns = [str(column).strip() for column in table.columns]
    if "residue" not in table.columns:
        raise InputError(f"{path} has no column residue; it must say which residue a row is about.")
    return table.apply(lambda column: column.str.strip())
