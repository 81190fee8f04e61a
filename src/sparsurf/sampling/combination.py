"""Choices of the four parameters of the paper's sampling: as text and numbers, and those of Table I.

Table I holds the combinations that the paper's criterion d picked, per range of n_S.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from sparsurf.patches.readings import CODED_READING

SEPARATOR = "; "  # between combinations in one field of a table


class Combination(NamedTuple):
    """alpha, beta, gamma and delta of the paper's eq. 2; as text, (1, 0, 6, 0)."""

    alpha: float
    beta: float
    gamma: float
    delta: float

    def __str__(self):
        return "(" + ", ".join(f"{p:g}" for p in self) + ")"

    @classmethod
    def of(cls, row):
        """From anything with the keys alpha, beta, gamma and delta: a row of a table, a dict."""
        return cls(*(float(row[name]) for name in cls._fields))

    @classmethod
    def parse(cls, text):
        """From its text.

        Raises
        ------
        ValueError : not four numbers in brackets
        """
        values = [float(part) for part in text.strip().removeprefix("(").removesuffix(")").split(",")]
        if len(values) != len(cls._fields):
            raise ValueError(f"{text!r} is no combination of alpha, beta, gamma and delta")
        return cls(*values)

    def keys(self):
        """The parameters in millionths, as keys of a random stream: it does not depend on the order of a grid."""
        return [round(1e6 * p) for p in self]


PARAMETERS = list(Combination._fields)


def texts_of(table):
    """The combination of every row of a table as text, a list; '' of a row without one."""
    rows = (Combination.of(row) for _, row in table.iterrows())
    return ["" if row[0] != row[0] else str(row) for row in rows]


def joined(combinations):
    """Several combinations as one field of a table."""
    return SEPARATOR.join(map(str, combinations))


def split(field):
    """The texts of the combinations in one field of a table; none where it is empty."""
    return str(field).split(SEPARATOR) if isinstance(field, str) and field else []


# Table I of the paper: limits of the ranges of n_S in %, alpha, beta, gamma, delta, d and Z_tS
TABLE_1 = np.genfromtxt(Path(__file__).with_name("published_table1.csv"), delimiter=",", names=True)
PUBLISHED_ROWS = np.stack([TABLE_1[name] for name in PARAMETERS], axis=1)


class Choices(NamedTuple):
    """Combinations for ranges of n_S: (R,) lower limits in % of the dots, ascending, and (R, 4) rows."""

    lowest: np.ndarray
    rows: np.ndarray

    def from_n_s(self, percent):
        """Rows of the range that holds an n_S of `percent` % of the dots and of the ranges above it."""
        place = np.searchsorted(self.lowest, percent)
        return self.rows[int(np.clip(place, 1, len(self.rows))) - 1 :]


OF_PAPER = Choices(TABLE_1["n_S_low_percent"], PUBLISHED_ROWS)


def choices_of(ranges):
    """The winners of ranges.csv under the published reading; Table I of the paper without any."""
    if ranges is None or not (ranges["reading"] == CODED_READING).any():
        return OF_PAPER
    rows = ranges[(ranges["reading"] == CODED_READING) & (ranges["n_combinations"] > 0)]
    return Choices(rows["n_S_low_percent"].to_numpy(), rows[PARAMETERS].to_numpy())
