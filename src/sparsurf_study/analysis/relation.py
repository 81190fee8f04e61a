"""Test whether the best parameters depend on the mean roughness.

Conformations of one protein are similar for other reasons than their roughness. If they counted as independent, p would be
below 0.05 in a quarter of all runs in which roughness does not matter. Each protein therefore counts once, by its mean, and
the conformations of a single protein give neither a p nor an interval.
"""

from collections import Counter
from collections.abc import Sequence
from itertools import combinations, permutations
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.special import ndtri  # scipy.stats takes a quarter of a second to import

from sparsurf.evaluation.statistics import mean_interval
from sparsurf.sampling.combination import PARAMETERS, combination_labels, split_combinations

NORMAL_QUANTILE = ndtri(0.975)
EQUAL_ROUGHNESS = 0.01  # surfaces whose mean roughness differs by less count as equally rough
MAX_EXACT = 6  # surfaces for which all permutations (720) are computed; for more, a sample
SAMPLED_PERMUTATIONS = 1999


def relate_to_roughness(rows: pd.DataFrame, rng: np.random.Generator) -> dict[str, Any]:
    """Test whether the winners of one range depend on the mean roughness; `rows` are of one reading, one per surface, none empty.

    n_proteins is the number of units of every p and interval. n_pairs counts pairs of surfaces of equal mean roughness, n_changes
    those with different winners, and n_distinct those with winners outside each other's confidence set. p is the probability of
    so large a |rho| (Spearman) of any parameter if roughness did not matter. NaN where a value cannot be computed.
    """
    winners, sets = combination_labels(rows), rows["best_set"].map(split_combinations).tolist()
    occurrences = Counter(text for best_set in sets for text in best_set)
    shared, n_shared = max(
        occurrences.items(), key=lambda item: (item[1], winners.count(item[0])), default=("", 0)
    )
    means = protein_means(rows)
    out: dict[str, Any] = {"n_surfaces": len(rows), "n_proteins": len(means)}
    out["n_winners"] = len(set(winners))
    out |= {"shared": shared, "n_shared": n_shared}
    out |= winner_changes(rows["mean_roughness"].to_numpy(), winners, sets)
    out |= roughness_correlations(means["mean_roughness"].to_numpy(), means[PARAMETERS].to_numpy(float), rng)
    gain, over_all = (means["d_from_near"] - means[f"d_from_{group}"] for group in ("far", "all"))
    return out | with_interval("gain", gain) | with_interval("over_all", over_all)


def protein_means(rows: pd.DataFrame) -> pd.DataFrame:
    """Average over the conformations of each protein."""
    columns = ["mean_roughness", *PARAMETERS, "d", "d_cv", "d_from_near", "d_from_far", "d_from_all"]
    return rows.groupby("protein", sort=False)[columns].mean()


def winner_changes(
    rough: np.ndarray, winners: Sequence[str], sets: Sequence[Sequence[str]]
) -> dict[str, int]:
    """Count how often the winner changes between surfaces of equal mean roughness."""
    pairs = [
        (a, b) for a, b in combinations(range(len(rough)), 2) if abs(rough[a] - rough[b]) < EQUAL_ROUGHNESS
    ]
    differ = [(a, b) for a, b in pairs if winners[a] != winners[b]]
    distinct = [winners[a] not in sets[b] and winners[b] not in sets[a] for a, b in differ]
    return {"n_pairs": len(pairs), "n_changes": len(differ), "n_distinct": sum(distinct)}


def roughness_correlations(
    rough: np.ndarray, values: np.ndarray, rng: np.random.Generator
) -> dict[str, float]:
    """Compute Spearman's rho of each column of `values` (S, 4) with `rough` (S,), its 95 % interval, and the joint p."""
    x, y = _ranks(rough[:, None])[:, 0], _ranks(values)
    rho = x @ y if len(x) > 2 else np.full(len(PARAMETERS), np.nan)
    low, high = rho_interval(rho, len(x))
    out: dict[str, float] = {}
    for k, name in enumerate(PARAMETERS):
        out |= {f"rho_{name}": rho[k], f"rho_{name}_low": low[k], f"rho_{name}_high": high[k]}
    if np.isnan(rho).all():
        return out | {"p": np.nan}
    if len(x) <= MAX_EXACT:
        orders = np.array(list(permutations(range(len(x)))))
    else:
        orders = rng.permuted(np.tile(np.arange(len(x)), (SAMPLED_PERMUTATIONS, 1)), axis=1)
        orders = np.vstack([np.arange(len(x)), orders])  # the observed order is one of the possible ones
    largest = np.nanmax(np.abs(x[orders] @ y), axis=1)
    # Correlations of equal permutations differ by rounding: the margin counts them as equal
    return out | {"p": float(np.mean(largest >= np.nanmax(np.abs(rho)) - 1e-12))}


def _ranks(values: np.ndarray) -> np.ndarray:
    """Return the ranks of the columns, centred and scaled to length 1; NaN for a column of equal values."""
    ranks = pd.DataFrame(values).rank().to_numpy() - (len(values) + 1) / 2
    length = np.sqrt((ranks**2).sum(axis=0))
    return np.divide(ranks, length, out=np.full_like(ranks, np.nan), where=length > 0)


def rho_interval(rho: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Compute the 95 % interval of Spearman's rho (Bonett and Wright, Psychometrika 65:23, 2000); NaN for n below 4.

    A rho of 1 is reduced by half of the change that swapping two neighbours causes, as its interval would have no width.
    """
    if n < 4:
        return np.full_like(rho, np.nan), np.full_like(rho, np.nan)
    max_rho = 1 - 6 / (n * (n * n - 1))
    z, error = np.arctanh(np.clip(rho, -max_rho, max_rho)), np.sqrt((1 + rho**2 / 2) / (n - 3))
    return np.tanh(z - NORMAL_QUANTILE * error), np.tanh(z + NORMAL_QUANTILE * error)


def with_interval(name: str, values: ArrayLike) -> dict[str, float]:
    """Return the mean of the finite values and its 95 % interval, of 3 or more, as `name`, `name`_low and `name`_high."""
    values = np.asarray(values, float)
    mean, low, high = mean_interval(values[np.isfinite(values)], fewest=3)
    return {name: mean, f"{name}_low": low, f"{name}_high": high}
