"""Whether the best parameters follow the mean roughness, with the uncertainty over the proteins.

Conformations of one protein are alike for other reasons than their roughness: counted as independent they give, where
roughness plays no part, a p below 0.05 in a quarter of all runs. So each protein counts once, by its mean, and the
conformations of one protein give neither a p nor an interval.
"""

from collections import Counter
from itertools import combinations, permutations

import numpy as np
import pandas as pd
from scipy.special import ndtri  # scipy.stats takes a quarter of a second to import

from sparsurf.sampling.combination import PARAMETERS, combination_labels, split_combinations
from sparsurf.study import statistics

NORMAL = ndtri(0.975)
EQUAL_ROUGHNESS = 0.01  # surfaces whose mean roughness differs by less count as equally rough
EXACT = 6  # up to so many surfaces all permutations are taken (720), beyond a sample of
PERMUTATIONS = 1999


def relate_to_roughness(rows, rng):
    """How the winners of one range go with mean roughness.

    Parameters
    ----------
    rows : DataFrame
        Rows of `summary.summary_table` of one reading, one per surface, none empty.
    rng : numpy.random.Generator
        For the permutations, where they are too many to take all.

    Returns
    -------
    dict: n_surfaces; n_proteins, which are the units of every p and interval; n_winners, different ones;
    `shared`, the combination that lies in most confidence sets of the best, and n_shared, in how many; n_pairs of
    surfaces of equal mean roughness, n_changes of them with different winners, n_told_apart with winners that lie
    outside each other's confidence set; Spearman's rho of each parameter with mean roughness and its 95 % interval; p,
    the probability of so large an |rho| of any parameter if roughness did not matter; gain, the mean of d_from_near -
    d_from_far, and over_all, that of d_from_near - d_from_all, with their 95 % intervals. NaN where it cannot be told.
    """
    winners, sets = combination_labels(rows), rows["best_set"].map(split_combinations).tolist()
    held = Counter(text for one in sets for text in one)
    shared, n_shared = max(held.items(), key=lambda item: (item[1], winners.count(item[0])), default=("", 0))
    counted = protein_means(rows)
    out = {"n_surfaces": len(rows), "n_proteins": len(counted), "n_winners": len(set(winners))}
    out |= {"shared": shared, "n_shared": n_shared}
    out |= winner_changes(rows["mean_roughness"].to_numpy(), winners, sets)
    out |= roughness_correlations(
        counted["mean_roughness"].to_numpy(), counted[PARAMETERS].to_numpy(float), rng
    )
    gain, over_all = (counted["d_from_near"] - counted[f"d_from_{who}"] for who in ("far", "all"))
    return out | with_interval("gain", gain) | with_interval("over_all", over_all)


def protein_means(rows):
    """Means over the conformations of each protein, a row each."""
    columns = ["mean_roughness", *PARAMETERS, "d", "d_held_out", "d_from_near", "d_from_far", "d_from_all"]
    return rows.groupby("protein", sort=False)[columns].mean()


def winner_changes(rough, winners, sets):
    """How often the winner changes between surfaces of equal mean roughness."""
    pairs = [
        (a, b) for a, b in combinations(range(len(rough)), 2) if abs(rough[a] - rough[b]) < EQUAL_ROUGHNESS
    ]
    differ = [(a, b) for a, b in pairs if winners[a] != winners[b]]
    apart = [winners[a] not in sets[b] and winners[b] not in sets[a] for a, b in differ]
    return {"n_pairs": len(pairs), "n_changes": len(differ), "n_told_apart": sum(apart)}


def roughness_correlations(rough, values, rng):
    """Spearman's rho of each column of `values` (S, 4) with `rough` (S,), its 95 % interval, and the joint p."""
    x, y = _ranks(rough[:, None])[:, 0], _ranks(values)
    rho = x @ y if len(x) > 2 else np.full(len(PARAMETERS), np.nan)
    low, high = rho_interval(rho, len(x))
    out = {}
    for k, name in enumerate(PARAMETERS):
        out |= {f"rho_{name}": rho[k], f"rho_{name}_low": low[k], f"rho_{name}_high": high[k]}
    if np.isnan(rho).all():
        return out | {"p": np.nan}
    if len(x) <= EXACT:
        orders = np.array(list(permutations(range(len(x)))))
    else:
        orders = rng.permuted(np.tile(np.arange(len(x)), (PERMUTATIONS, 1)), axis=1)
        orders = np.vstack([np.arange(len(x)), orders])  # what was seen is one of the possible orders
    largest = np.nanmax(np.abs(x[orders] @ y), axis=1)
    return out | {"p": float(np.mean(largest >= np.nanmax(np.abs(rho)) - 1e-12))}


def _ranks(values):
    """Ranks of the columns, centred, of length 1; NaN for a column of equal values."""
    ranks = pd.DataFrame(values).rank().to_numpy() - (len(values) + 1) / 2
    length = np.sqrt((ranks**2).sum(axis=0))
    return np.divide(ranks, length, out=np.full_like(ranks, np.nan), where=length > 0)


def rho_interval(rho, n):
    """95 % interval of Spearman's rho (Bonett and Wright, Psychometrika 65:23, 2000); NaN below 4 surfaces.

    A rho of 1 counts half a step less, a step being the exchange of two neighbours: it is never certain.
    """
    if n < 4:
        return np.full_like(rho, np.nan), np.full_like(rho, np.nan)
    most = 1 - 6 / (n * (n * n - 1))
    z, error = np.arctanh(np.clip(rho, -most, most)), np.sqrt((1 + rho**2 / 2) / (n - 3))
    return np.tanh(z - NORMAL * error), np.tanh(z + NORMAL * error)


def mean_interval(x):
    """`statistics.mean_interval`, whose ends need 3 proteins here."""
    return statistics.mean_interval(x, fewest=3)


def with_interval(name, values):
    """Mean of the values that are known and its 95 % interval, under `name`, `name`_low and `name`_high."""
    values = np.asarray(values, float)
    return dict(
        zip((name, f"{name}_low", f"{name}_high"), mean_interval(values[np.isfinite(values)]), strict=True)
    )
