"""Combinations of the four parameters of the paper's sampling, as numbers and as text.

Table I of the paper lists the combination that its criterion d selected in each range of n_S.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from sparsurf.patches.readings import KEPT_READING

if TYPE_CHECKING:
    import pandas as pd

SEPARATOR = "; "  # between combinations in one field of a table


class Combination(NamedTuple):
    """alpha, beta, gamma and delta of the paper's eq. 2; as text, (1, 0, 6, 0)."""

    alpha: float
    beta: float
    gamma: float
    delta: float

    def __str__(self) -> str:
        return "(" + ", ".join(f"{p:g}" for p in self) + ")"

    @classmethod
    def from_row(cls, row: Mapping | pd.Series) -> Self:
        """Take the combination from a dict or a row of a table with the keys alpha, beta, gamma and delta."""
        return cls(*(float(row[name]) for name in cls._fields))

    def keys(self) -> list[int]:
        """Return the parameters in millionths, as keys of a random stream: they do not depend on the order of a grid."""
        return [round(1e6 * p) for p in self]


PARAMETERS = list(Combination._fields)


def combination_labels(table: pd.DataFrame) -> list[str]:
    """Return the combination in each row of a table as text; '' if the row has none."""
    combinations = (Combination.from_row(row) for _, row in table.iterrows())
    return ["" if np.isnan(combination.alpha) else str(combination) for combination in combinations]


def join_combinations(combinations: Iterable[Combination | str]) -> str:
    """Write several combinations into one field of a table."""
    return SEPARATOR.join(map(str, combinations))


def split_combinations(field: object) -> list[str]:
    """Return the combinations in one field of a table as texts; [] if the field is empty."""
    return field.split(SEPARATOR) if isinstance(field, str) and field else []


# Table I of the paper: limits of the ranges of n_S in %, alpha, beta, gamma, delta, d and Z_tS
TABLE_1 = np.genfromtxt(Path(__file__).with_name("published_table1.csv"), delimiter=",", names=True)
PUBLISHED_ROWS = np.stack([TABLE_1[name] for name in PARAMETERS], axis=1)


class Choices(NamedTuple):
    """The combination to use in each range of n_S."""

    lowest: np.ndarray  # (R,) float64, lower limits of the ranges in % of the dots, ascending
    rows: np.ndarray  # (R, 4) float64, combinations

    def from_n_s(self, percent: float) -> np.ndarray:
        """Return the rows of the range, with its lower limit, that contains an n_S of `percent` %, and of all higher ranges."""
        # A range includes its lower limit, as in the authors' code; below the first one, the first one serves
        above = np.searchsorted(self.lowest, percent, side="right")
        return self.rows[int(np.clip(above, 1, len(self.rows))) - 1 :]


PUBLISHED_CHOICES = Choices(TABLE_1["n_S_low_percent"], PUBLISHED_ROWS)


def choices_from_ranges(ranges: pd.DataFrame | None) -> Choices:
    """Return the winners in ranges.csv under the published reading, or Table I of the paper if there are none."""
    if ranges is None or not (ranges["reading"] == KEPT_READING).any():
        return PUBLISHED_CHOICES
    rows = ranges[(ranges["reading"] == KEPT_READING) & (ranges["n_combinations"] > 0)]
    return Choices(rows["n_S_low_percent"].to_numpy(), rows[PARAMETERS].to_numpy())
