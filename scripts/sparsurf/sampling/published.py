"""The paper's own choice: Table I, the combinations that its criterion d picked, per range of n_S."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from sparsurf.sampling.combination import PARAMETERS

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
