"""The dots that the best combination of each range of n_S keeps."""

from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.sampling.combination import Combination


def winners_of(ranges: pd.DataFrame, prepared: PreparedSurface) -> dict[str, np.ndarray]:
    """Return the dots that winners keep in the first draw: for each reading (ranges, N) bool, all False in an empty range."""
    kept = {}
    for reading, rows in ranges.groupby("reading", sort=False):
        combinations = [Combination.from_row(row) for _, row in rows.iterrows()]
        kept[str(reading)] = chosen = np.zeros((len(combinations), len(prepared)), bool)
        for k, combination in enumerate(combinations):
            if not np.isnan(combination.alpha):
                chosen[k, prepared.pair(combination, 0)[0]] = True
    return kept


def write_winners(path: Path | str, ranges: pd.DataFrame, prepared: PreparedSurface) -> None:
    """Store the dots of the winners as npz, compressed to a fifth or less of a byte for each value."""
    with open(path, "wb") as stream:
        np.savez_compressed(stream, **winners_of(ranges, prepared))  # type: ignore[arg-type]
