"""Statistics over many proteins: each counts once, and every interval of a mean is `statistics.mean_interval`."""

import numpy as np
import pandas as pd
from scipy.stats import binom, rankdata

from sparsurf.patches.readings import FULL_READING, SCALED_READING
from sparsurf.sampling.combination import (
    PARAMETERS,
    combination_labels,
    join_combinations,
    split_combinations,
)
from sparsurf_study.analysis.best_set import best_set
from sparsurf_study.analysis.comparison import REFERENCE, smallest_n_s
from sparsurf_study.analysis.relation import rho_interval, with_interval
from sparsurf_study.analysis.summary import SurfaceResult, evaluated_readings, stack_column
from sparsurf_study.analysis.tables import range_index, range_limits

FRESH = "fresh dots"  # the floor of other dots of the same surface
TARGETS = (10.0, 25.0, 40.0)  # % of random dots as they are; the other subsets must reach their Z
SCALED = f"d_{SCALED_READING}"
# Of `d_by_range`: columns of the summary
COLUMNS = {"own": "d_cv", "from_all": "d_from_all", "lost": "lost", "near": "near", "scaled": SCALED}


def d_by_range(summary: pd.DataFrame) -> pd.DataFrame:
    """Return d over the proteins, per reading and range of n_S.

    Parameters
    ----------
    summary : DataFrame
        See `summary.summary_table`.

    Returns
    -------
    DataFrame: reading, range (0: mean of a protein's ranges), n (proteins), n_S_percent, `own`, cross-validated d of each
    protein's own best; `from_all`, d of the combination with the highest mean d on all others; `lost`, the first less the
    second; `near`, d of the choice of the others nearest in mean roughness less `from_all`; `scaled`, d of the protein's own best
    with a scaled link; with their intervals; n_below_scaled, proteins whose interval of that lies below 0;
    n_above and n_below, proteins whose own interval of cross-validated d lies above and below 0; n_worse, those on which both
    the sampling and the random subset have a higher Z than the mean patch in place of every patch.
    """
    rows = []
    sampled = summary[summary["n_combinations"] > 0].assign(
        lost=lambda t: t["d_cv"] - t["d_from_all"], near=lambda t: t["d_from_near"] - t["d_from_all"]
    )
    for reading, part in sampled.groupby("reading", sort=False):
        by_protein = part.groupby("protein", sort=False).mean(numeric_only=True)
        for k, rows_of_range in [(0, by_protein), *part.groupby("range")]:
            row = {
                "reading": reading,
                "range": k,
                "n": len(rows_of_range),
                "n_S_percent": rows_of_range["n_S_percent"].mean(),
            }
            for name, column in COLUMNS.items():
                row |= with_interval(name, rows_of_range[column])
            if k:
                row["n_above"] = int((rows_of_range["d_cv_low"] > 0).sum())
                row["n_below"] = int((rows_of_range["d_cv_high"] < 0).sum())
                row["n_below_scaled"] = int((rows_of_range[f"d_high_{SCALED_READING}"] < 0).sum())
                best = rows_of_range[["Z_tS", "Z_tR"]].min(axis=1)
                row["n_worse"] = int((best > rows_of_range["Z_mean_descriptor"]).sum())
            rows.append(row)
    return pd.DataFrame(rows)


def plateaus(results: list[SurfaceResult], summary: pd.DataFrame) -> pd.DataFrame:
    """Find the combinations that may be the best on average over proteins, and on how many proteins they are.

    Returns
    -------
    DataFrame: reading, range and its limits (of the mean n_S), n_combinations, `winner` (highest mean d), n_best_set and
    best_set, its 95 % confidence set with the proteins as units; n_there, proteins on which the winner falls into this
    range, and n_held, those of them whose own confidence set of the best it lies in.
    """
    percents = stack_column(results, "n_S_percent")
    mean, rows = percents.mean(axis=0), []
    grid = results[0].grid
    for reading in evaluated_readings(results[0]):
        d, rows_of_reading = stack_column(results, f"d_{reading}"), summary[summary["reading"] == reading]
        n_ranges = int(rows_of_reading["range"].max())
        limits = range_limits(mean, n_ranges)
        member = range_index(mean, limits)
        ranges = [range_index(percent, range_limits(percent, n_ranges)) for percent in percents]
        sets = rows_of_reading.set_index(["protein", "range"])["best_set"].map(split_combinations)
        for k in np.unique(member[member < n_ranges]):
            inside = np.flatnonzero(member == k)
            values = d[:, inside].T[:, None, :]
            best = inside[np.argmax(values.mean(axis=(1, 2)))]
            winner = combination_labels(grid.loc[[best]])[0]
            there = [
                one.protein
                for one, range_of_each in zip(results, ranges, strict=True)
                if range_of_each[best] == k
            ]
            among = grid.loc[inside[best_set(values)]]
            row = {
                "reading": reading,
                "range": k + 1,
                "n_S_low_percent": limits[k],
                "n_S_high_percent": limits[k + 1],
            }
            row |= {"n_combinations": len(inside), "winner": winner, "n_best_set": len(among)}
            row |= {"best_set": join_combinations(combination_labels(among)), "n_there": len(there)}
            rows.append(row | {"n_held": sum(winner in sets[name, k + 1] for name in there)})
    return pd.DataFrame(rows)


def median_interval(values: np.ndarray) -> tuple[float, float]:
    """Return the 95 % interval of a median by the ranks of the values, valid for any distribution; NaN for fewer than 6."""
    if len(values) < 6:
        return np.nan, np.nan
    rank, ordered = int(binom.ppf(0.025, len(values), 0.5)), np.sort(values)
    return ordered[rank - 1], ordered[len(values) - rank]


def needed(curves: pd.DataFrame) -> pd.DataFrame:
    """Find how many dots each sampler needs on each protein, as they are and recovered, for the Z of random dots as they are.

    Returns
    -------
    DataFrame: protein, target (% of random dots), Z, sampler, reading, n_S_percent, factor (target over n_S_percent) and
    bound: whether n_S lies beyond those measured and counts as the nearest measured one
    """
    rows = []
    for protein, part in curves.groupby("protein", sort=False):
        lines = {keys: line for keys, line in part.groupby(["sampler", "reading"], sort=False)}
        reference = lines[REFERENCE, FULL_READING].set_index("percent")
        for target in TARGETS:
            z, n_uniform = reference.loc[target, ["Z", "n_S_percent"]]
            for (sampler, reading), line in lines.items():
                sizes = line["n_S_percent"].to_numpy()
                n = smallest_n_s(z, sizes, line["Z"].to_numpy())
                inside = np.clip(n, sizes[0], sizes[-1])
                rows.append(
                    (protein, target, z, sampler, reading, inside, n_uniform / inside, bool(n != inside))
                )
    columns = ["protein", "target", "Z", "sampler", "reading", "n_S_percent", "factor", "bound"]
    return pd.DataFrame(rows, columns=columns)


def needed_means(table: pd.DataFrame) -> pd.DataFrame:
    """Return geometric means of `needed` over proteins with 95 % intervals, and how many of them are bounds."""
    rows = []
    for keys, part in table.groupby(["target", "sampler", "reading"], sort=False):
        row = dict(zip(("target", "sampler", "reading"), keys, strict=True))
        for name in ("n_S_percent", "factor"):
            row |= {key: np.exp(value) for key, value in with_interval(name, np.log(part[name])).items()}
        rows.append(row | {"n": len(part), "n_bound": int(part["bound"].sum())})
    return pd.DataFrame(rows)


def recovered_means(curves: pd.DataFrame, floors: pd.DataFrame) -> pd.DataFrame:
    """Return Z of each sampler by n_S over proteins, as it is and recovered, and over that of fresh dots.

    Returns
    -------
    DataFrame: sampler, percent, reading, n, Z and over_floor with their intervals, the highest Z and whose it is
    """
    table, rows = over_floor(curves, floors), []
    for keys, part in table.groupby(["sampler", "percent", "reading"], sort=False):
        row = dict(zip(("sampler", "percent", "reading"), keys, strict=True)) | {"n": len(part)}
        row |= with_interval("Z", part["Z"]) | with_interval("over_floor", part["over_floor"])
        worst = part.iloc[part["Z"].argmax()]
        rows.append(row | {"highest": worst["Z"], "highest_protein": worst["protein"]})
    return pd.DataFrame(rows)


def over_floor(curves: pd.DataFrame, floors: pd.DataFrame) -> pd.DataFrame:
    """Return `curves` with `over_floor`, Z over that of fresh dots of the same protein."""
    fresh = floors[floors["floor"] == FRESH].set_index("protein")["Z"]
    return curves.assign(over_floor=curves["Z"] / curves["protein"].map(fresh))


def rank_correlations(quantities: dict[str, pd.Series], surfaces: pd.DataFrame) -> pd.DataFrame:
    """Return Spearman's rho of numbers of the proteins with their size and mean roughness, with 95 % intervals.

    Parameters
    ----------
    quantities : dict of words to Series by protein
    surfaces : DataFrame
        protein, N, mean_roughness

    Returns
    -------
    DataFrame: quantity, against, n, rho, rho_low, rho_high
    """
    rows, known = [], surfaces.set_index("protein")
    for words, values in quantities.items():
        for against in ("N", "mean_roughness"):
            pair = pd.concat([values, known[against]], axis=1, join="inner").to_numpy(float)
            rho = float(np.corrcoef(rankdata(pair, axis=0).T)[0, 1]) if len(pair) > 2 else np.nan
            low, high = rho_interval(np.array([rho]), len(pair))
            rows.append((words, against, len(pair), rho, low[0], high[0]))
    return pd.DataFrame(rows, columns=["quantity", "against", "n", "rho", "rho_low", "rho_high"])


def spearman(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return Spearman's correlation of values without ties along the last axis."""
    n = x.shape[-1]
    x, y = (rankdata(values, axis=-1) - (n + 1) / 2 for values in (x, y))
    return np.einsum("...n,...n->...", x, y) / (n * (n * n - 1) / 12)


def power(n: int, rng: np.random.Generator, requested: float = 0.8, runs: int = 4000) -> dict[str, float]:
    """Find the smallest correlation of one parameter with roughness that the test of `relation` detects often enough.

    Roughness and the parameter are drawn from a normal distribution with a correlation, the three other parameters without one;
    the largest of the four |Spearman's rho| is compared with its 95 % quantile where none is correlated.

    Returns
    -------
    dict: n, requested, critical (the largest |rho| of four that chance gives in 5 % of runs), rho (smallest Spearman's found)
    """

    def largest(correlation: float) -> tuple[np.ndarray, float]:
        x = rng.standard_normal((runs, n))
        y = rng.standard_normal((runs, len(PARAMETERS), n))
        y[:, 0] = correlation * x + np.sqrt(1 - correlation**2) * y[:, 0]
        rho = spearman(x[:, None], y)
        return np.abs(rho).max(axis=1), rho[:, 0].mean()

    critical = float(np.quantile(largest(0.0)[0], 0.95))
    for correlation in np.arange(0.05, 1.0, 0.01):
        strongest, rho = largest(correlation)
        if (strongest > critical).mean() >= requested:
            return {"n": n, "requested": requested, "critical": critical, "rho": float(rho)}
    return {"n": n, "requested": requested, "critical": critical, "rho": np.nan}
