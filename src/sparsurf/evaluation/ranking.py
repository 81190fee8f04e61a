"""Which residues change most over the frames of a trajectory."""

from collections.abc import Callable, Iterable

import numpy as np
import pandas as pd


def rank_residues(
    residues: pd.DataFrame, quantity: str, statistic: str, values: Callable[[], Iterable[np.ndarray]]
) -> pd.DataFrame:
    """Tabulate how a quantity of residues changes over frames, with those that change most first.

    `values` yields the numbers of consecutive frames, (n, R) float64 with NaN where a residue has none, and is called twice, so
    that not all frames need be in memory. `statistic` is the column that orders: 'sd', the standard deviation, or 'range'.
    Residues without it come last; the index is the position of each residue in `residues`.
    """
    n = len(residues)
    count, total, squares = np.zeros(n), np.zeros(n), np.zeros(n)
    lowest, highest = np.full(n, np.nan), np.full(n, np.nan)
    for block in values():
        count += np.isfinite(block).sum(axis=0)
        total += np.nansum(block, axis=0)
        lowest = np.fmin(lowest, np.fmin.reduce(block))
        highest = np.fmax(highest, np.fmax.reduce(block))
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = total / count
        for block in values():
            squares += np.nansum((block - mean) ** 2, axis=0)
        sd = np.sqrt(np.where(count > 1, squares / (count - 1), np.nan))
    table = residues.assign(
        quantity=quantity,
        frames=count.astype(int),
        mean=mean,
        sd=sd,
        lowest=lowest,
        highest=highest,
        range=highest - lowest,
    )
    return table.sort_values(statistic, ascending=False, kind="stable")
