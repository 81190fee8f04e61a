"""Tables written with as many digits as their errors leave."""

from __future__ import annotations

import math
import re
from os import PathLike
from typing import TYPE_CHECKING

from sparsurf import registry

if TYPE_CHECKING:
    import pandas as pd

DIGITS = 6  # Numbers without an error are rounded to so many digits.
DIGITS_OF_ERROR = 2
STANDARD_ERRORS_PER_INTERVAL = 4  # An interval of 95 % is so wide.
MAX_DECIMALS = 12
ENDING = re.compile(f"_(?:{'|'.join(registry.TABLE['reading'])})$")
# The errors of these are called se, low and high.
VALUES = ("Z", "value", "auc", "mean", "difference", "factor")


def write_rounded(path: str | PathLike[str], table: pd.DataFrame) -> None:
    """Write a table as CSV: a number with a standard error or an interval to two digits of the error, others to six digits."""
    round_by_error(table).to_csv(path, index=False)


def round_by_error(table: pd.DataFrame) -> pd.DataFrame:
    """Return the table with its floats as text by their error; empty for NaN.

    The error of a column `d` stands in `d_se`, or is a quarter of `d_high` - `d_low`; of `d_kept` in `d_se_kept`; of
    `Z`, `value`, `auc`, `mean`, `difference` and `factor` also in `se`, `low` and `high`.
    """
    floats = [name for name in table if table[name].dtype.kind == "f"]
    texts = {}
    for name in floats:
        with_error = [name, *_parts(str(name), "se"), *_parts(str(name), "low"), *_parts(str(name), "high")]
        present = [column for column in with_error if column in floats]
        if len(present) == 1:
            continue
        errors = _errors(table, str(name))
        for column in present:
            if column == name or column not in texts:
                texts[column] = [
                    _text(value, error) for value, error in zip(table[column].tolist(), errors, strict=True)
                ]
    for name in floats:
        if name not in texts:
            texts[name] = [_text(value, math.nan) for value in table[name].tolist()]
    return table.assign(**{str(name): values for name, values in texts.items()})


def _parts(name: str, part: str) -> list[str]:
    """Return the names that the `se`, `low` or `high` of a column may have."""
    names = [f"{name}_{part}"]
    if ending := ENDING.search(name):
        names.append(f"{name[: ending.start()]}_{part}{ending[0]}")
    return [*names, part] if name in VALUES else names


def _errors(table: pd.DataFrame, name: str) -> list[float]:
    """Return the standard error of each number of a column; NaN where it has none."""
    for part in _parts(name, "se"):
        if part in table:
            return table[part].tolist()
    for low, high in zip(_parts(name, "low"), _parts(name, "high"), strict=True):
        if low in table and high in table:
            return ((table[high] - table[low]) / STANDARD_ERRORS_PER_INTERVAL).tolist()
    return [math.nan] * len(table)


def _text(value: float, error: float) -> str:
    """Return a number with the decimals that its error leaves."""
    if math.isnan(value):
        return ""
    if not (0 < error < math.inf) or math.isinf(value):
        return f"{value:.{DIGITS}g}"
    decimals = DIGITS_OF_ERROR - 1 - math.floor(math.log10(error))
    return f"{value:z.{min(max(decimals, 0), MAX_DECIMALS)}f}"
