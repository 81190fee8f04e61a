"""Area under the ROC curve of scores of dots as predictors of the interface, with intervals, and means over pairs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.evaluation.statistics import mean_interval

BLOCK_LENGTH = 10.0  # Å, between the centres of blocks of residues that are resampled together
N_DRAWS = 500  # The bootstrap draws so many samples.
# Scores are of order 1, and rounded since between two equal partners all distances are 0 except for rounding errors
SCORE_DECIMALS = 9

MAIN_SCORE, BASELINE = "propensity_smoothed", "protrusion"  # what a study reports


def auc(score: np.ndarray, positive: np.ndarray, weight: np.ndarray | None = None) -> Any:
    """Compute the area under the ROC curve: the probability that a dot of the interface scores higher than another dot.

    B rows of `weight`, (B, n), give B areas. Ties (to SCORE_DECIMALS) count half; NaN if one of the two classes is empty.
    """
    weight = np.ones(len(score)) if weight is None else np.asarray(weight, np.float64)
    # Ties by rounding errors would be broken in another way on another processor
    score = np.round(score, SCORE_DECIMALS)
    order = np.argsort(score, kind="stable")
    value, w = score[order], np.atleast_2d(weight)[:, order]
    begin = np.flatnonzero(np.diff(value, prepend=np.nan) != 0)  # of each run of equal values
    inside = np.add.reduceat(w * positive[order], begin, axis=1)
    outside = np.add.reduceat(w * ~positive[order], begin, axis=1)
    below = np.cumsum(outside, axis=1) - outside / 2
    with np.errstate(invalid="ignore"):
        area = (inside * below).sum(axis=1) / (inside.sum(axis=1) * outside.sum(axis=1))
    return area if weight.ndim == 2 else float(area[0])


def blocks_of_residues(points: np.ndarray, residue: np.ndarray, length: float = BLOCK_LENGTH) -> np.ndarray:
    """Group neighbouring residues into blocks, the units of a bootstrap; return the block of each dot, from 0.

    A map smoothed over 6 Å is correlated over about twice that distance. Block centres are centres of residues, each the farthest
    from the previous ones, until every residue is within `length` Å of one; each residue joins the nearest block.
    """
    _, row, count = np.unique(residue, return_inverse=True, return_counts=True)
    centre = np.stack([np.bincount(row, points[:, c]) for c in range(3)], axis=1) / count[:, None]
    gap, block, n_blocks = np.full(len(centre), np.inf), np.zeros(len(centre), np.int64), 0
    while gap.max() > length:
        distance = np.linalg.norm(centre - centre[np.argmax(gap)], axis=1)
        block[distance < gap] = n_blocks
        gap, n_blocks = np.minimum(gap, distance), n_blocks + 1
    return block[row]


def bootstrap_auc(
    scores: Mapping[Any, np.ndarray],
    positive: np.ndarray,
    block: np.ndarray,
    rng: np.random.Generator,
    draws: int = N_DRAWS,
) -> dict[Any, tuple[float, float, float]]:
    """Compute AUC of all scores with 95 % intervals, by resampling whole blocks with replacement; NaN for a single block."""
    n_blocks = int(block.max()) + 1
    times = rng.multinomial(n_blocks, np.full(n_blocks, 1 / n_blocks), size=draws)
    areas = {}
    for name, score in scores.items():
        scored = ~np.isnan(score)
        drawn = auc(score[scored], positive[scored], times[:, block[scored]].astype(np.float64))
        drawn = drawn[~np.isnan(drawn)]
        has_scatter = n_blocks > 1 and len(drawn)  # all draws of a single block are the same
        low, high = np.percentile(drawn, [2.5, 97.5]) if has_scatter else (np.nan, np.nan)
        areas[name] = (auc(score[scored], positive[scored]), float(low), float(high))
    return areas


def means_over_pairs(table: pd.DataFrame, keys: Sequence[str] = ("score",)) -> pd.DataFrame:
    """Average AUC over pairs, whose two sides are averaged first, with 95 % intervals within 0 to 1, in order of appearance."""
    keys = [*keys]
    of_pair = table.groupby([*keys, "complex"], sort=False)["auc"].mean().reset_index()
    rows = []
    for key, group in of_pair.groupby(keys, sort=False):
        mean, *limits = mean_interval(group["auc"].to_numpy())
        rows.append((*key, mean, *np.clip(limits, 0, 1), len(group)))
    return pd.DataFrame(rows, columns=[*keys, "mean", "low", "high", "complexes"])
