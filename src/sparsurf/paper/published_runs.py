"""Compare Table I of the paper with the winners of runs as published: whole grid, new test dots, one draw, `as_coded`.

The power of such a test is the share of runs with another parameter that it distinguishes from runs as published.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtr  # Student's t; scipy.stats takes a quarter of a second to import

from sparsurf.patches.index import build_index
from sparsurf.patches.readings import CODED_READING
from sparsurf.sampling import published
from sparsurf.sampling.combination import PARAMETERS, TABLE_1
from sparsurf.streams import stream
from sparsurf.study import grid
from sparsurf.study.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.study.tables import range_index, range_limits

RUNS = 40  # as-published runs of the whole grid
BINNINGS = {"closed": True, "half-open": False}  # whether the last range contains the largest n_S
MEASURES = ("d", "Z_tS")
CENTRES = 181  # of the patches that cover A1, as published
SIMULATED = 100_000  # sums of squares from which the p of all rows is taken
NORMAL_QUANTILE = 1.959964  # of a two-sided 95 % interval
SIGNIFICANCE_LEVEL = 0.05  # p below which a run counts as different


def runs_as_published(
    prepared: PreparedSurface,
    combinations: np.ndarray,
    runs: int = RUNS,
    progress: Callable[[int, int], None] = lambda done, of: None,
    alpha: float = 1.0,
) -> pd.DataFrame:
    """Repeat Table I as published: N / 200 new test dots per combination, one draw, `as_coded`.

    Parameters
    ----------
    prepared : PreparedSurface
    combinations : (K, 4) float64
    runs : int
    progress : callable
        Callback with the numbers of finished and total runs.
    alpha : float
        Factor of every alpha in the sampling; the table shows the alpha without it.

    Returns
    -------
    DataFrame, one row per run, binning and range: run (from 1), binning, range (from 1), n_S_low_percent,
    n_S_high_percent, n_combinations, and of the winner alpha to delta, n_S_percent, d, Z_tS (NaN in an empty range)
    """
    combinations = np.asarray(combinations, float)
    tests, rows = number_of_tests("published", len(prepared.points)), []
    for run in range(runs):
        renamed = prepared.changed(stream_name=f"{prepared.name} selection {run}")
        result = grid.evaluate_grid(
            renamed, combinations * (alpha, 1, 1, 1), tests, 1, (CODED_READING,), shared=False
        )
        z_ts = result.z_ts[0].mean(axis=(1, 2), dtype=np.float64)
        d = result.z_tr[0].mean(axis=(1, 2), dtype=np.float64) - z_ts
        percent = 100 * result.n_s[:, 0] / result.n_dots
        rows += [{"run": run + 1} | row for row in winners(combinations, percent, d, z_ts)]
        progress(run + 1, runs)
    return pd.DataFrame(rows)


def centres_in_random_orders(prepared: PreparedSurface, runs: int = RUNS) -> np.ndarray:
    """Count the centres of patches if the dots are visited in random orders, (runs,) int.

    The number depends on R_patch and D_link, and on the order of the dots, which differs between programs.
    """
    points, normals, counts = prepared.points, prepared.normals, []
    for run in range(runs):
        order = prepared.stream("order of the dots", run).permutation(len(points))
        index = build_index(points[order], normals[order], prepared.d_link)
        counts.append(len(published.build_cover(index, np.zeros(len(order)), prepared.r_patch).centre))
    return np.array(counts)


def winners(
    combinations: np.ndarray, percent: np.ndarray, d: np.ndarray, z_ts: np.ndarray
) -> Iterator[dict[str, Any]]:
    """Yield the combination with the highest d in each range, under both binnings, as dicts."""
    limits = range_limits(percent, len(TABLE_1))
    for binning, closed in BINNINGS.items():
        member = range_index(percent, limits, closed)
        for k in range(len(TABLE_1)):
            inside = np.flatnonzero(member == k)
            row: dict[str, Any] = {"binning": binning, "range": k + 1}
            row |= {
                "n_S_low_percent": limits[k],
                "n_S_high_percent": limits[k + 1],
                "n_combinations": len(inside),
            }
            if len(inside):
                best = inside[np.argmax(d[inside])]
                row |= dict(zip(PARAMETERS, map(float, combinations[best]), strict=True))
                row |= {"n_S_percent": percent[best], "d": d[best], "Z_tS": z_ts[best]}
            yield row


def table_1() -> pd.DataFrame:
    """Return Table I as a DataFrame: range (from 1), alpha to delta, d, Z_tS."""
    return pd.DataFrame(TABLE_1)[[*PARAMETERS, *MEASURES]].assign(range=np.arange(1, len(TABLE_1) + 1))


def place_published_values(runs: pd.DataFrame, published: pd.DataFrame | None = None) -> pd.DataFrame:
    """Compare each published value with those of the winners of the runs.

    Parameters
    ----------
    runs : DataFrame
        See `runs_as_published`.
    published : DataFrame, optional
        Table I by default, see `table_1`.

    Returns
    -------
    DataFrame, one row per binning and range: range, n_runs (with a winner), alpha to delta published, n_won (runs in
    which the published combination won), and for d and Z_tS: the published value, mean, sd, lowest and highest of the
    runs, n_below (number of runs with a lower value) and p, the two-sided probability of a rank as extreme by chance
    """
    published, out = (table_1() if published is None else published).set_index("range"), []
    for (binning, k), of_range in runs.groupby(["binning", "range"], sort=False):
        won = of_range[of_range["n_combinations"] > 0]
        expected = published.loc[k]  # type: ignore[call-overload]  # the stubs know no index of ints
        parameters = expected[PARAMETERS].astype(float)
        row: dict[str, Any] = {"binning": binning, "range": k, "n_runs": len(won), **parameters.to_dict()}
        row["n_won"] = int(np.isclose(won[PARAMETERS], parameters.to_numpy()).all(axis=1).sum())
        for name in MEASURES:
            statistics: dict[str, float] = {"published": float(expected[name])}
            statistics |= _rank(won[name].to_numpy(), statistics["published"]) if len(won) > 1 else {}
            row |= {f"{name}_{key}": value for key, value in statistics.items()}
        out.append(row)
    return pd.DataFrame(out)


def _rank(values: np.ndarray, published: float) -> dict[str, float]:
    """Compare one published value with those of the runs."""
    n_below, n_above = int((values < published).sum()), int((values > published).sum())
    statistics = {"mean": values.mean(), "sd": values.std(ddof=1)}
    statistics |= {"lowest": values.min(), "highest": values.max(), "n_below": n_below}
    return statistics | {"p": min(1.0, 2 * (min(n_below, n_above) + 1) / (len(values) + 1))}


def joint_test(comparison: pd.DataFrame, name: str, leave_out: Sequence[int] = ()) -> dict[str, float]:
    """Test all published values at once by the sum of their squared distances from the runs, in standard deviations.

    If a published row is one more run of the same kind, (value - mean) / (sd sqrt(1 + 1 / n)) follows Student's t with
    n - 1 degrees of freedom. Rows have their own test dots and draws, so the squares add.

    Parameters
    ----------
    comparison : DataFrame
        `place_published_values`, of one binning.
    name : {'d', 'Z_tS'}
    leave_out : sequence of int
        Ranges (from 1).

    Returns
    -------
    dict: n_rows, statistic, p
    """
    rows = comparison[~comparison["range"].isin(leave_out)].dropna(subset=[f"{name}_sd", f"{name}_published"])
    n = rows["n_runs"].to_numpy()
    difference = rows[f"{name}_published"] - rows[f"{name}_mean"]
    statistic = float(((difference / (rows[f"{name}_sd"] * np.sqrt(1 + 1 / n))) ** 2).sum())
    simulated = _simulated_statistics(tuple(map(int, n)), SIMULATED)
    p = float((np.sum(simulated >= statistic) + 1) / (len(simulated) + 1))
    return {"n_rows": len(rows), "statistic": statistic, "p": p}


@lru_cache
def _simulated_statistics(runs: tuple[int, ...], simulated: int) -> np.ndarray:
    """Simulate sums of squares of Student's t, each with as many degrees of freedom as runs minus one, (simulated,)."""
    t = stream(0, "published rows").standard_t(np.array(runs) - 1, size=(simulated, len(runs)))
    return (t**2).sum(axis=1)


def tests_of_table_1(
    comparison: pd.DataFrame, centres: np.ndarray, published_centres: int = CENTRES
) -> pd.DataFrame:
    """Run every test of Table I, under both binnings.

    Parameters
    ----------
    comparison : DataFrame
        See `place_published_values`.
    centres : (R,) int
        See `centres_in_random_orders`.
    published_centres : int

    Returns
    -------
    DataFrame, with a row per binning for d, Z_tS, centres (by Student's t, as one more order) and together (three times the
    smallest of the three, Bonferroni): binning, measure, n_rows, statistic, p
    """
    t = (published_centres - np.mean(centres)) / (np.std(centres, ddof=1) * np.sqrt(1 + 1 / len(centres)))
    of_centres = {"n_rows": 1, "statistic": t**2, "p": float(2 * stdtr(len(centres) - 1, -abs(t)))}
    rows = []
    for binning, of_binning in comparison.groupby("binning", sort=False):
        tests = {name: joint_test(of_binning, name) for name in MEASURES} | {"centres": of_centres}
        least = min(test["p"] for test in tests.values())
        tests["together"] = {
            "n_rows": len(of_binning),
            "statistic": np.nan,
            "p": min(1.0, len(tests) * least),
        }
        rows += [{"binning": binning, "measure": name, **test} for name, test in tests.items()]
    return pd.DataFrame(rows)


def power(
    runs: pd.DataFrame, centres: np.ndarray, other_runs: pd.DataFrame, other_centres: np.ndarray
) -> pd.DataFrame:
    """Compute the share of runs with another parameter that the tests of Table I distinguish from runs as published.

    Each of the other runs replaces Table I once.

    Parameters
    ----------
    runs, centres : from `runs_as_published` and `centres_in_random_orders`, with the published parameters
    other_runs, other_centres : the same with another parameter

    Returns
    -------
    DataFrame: binning, measure, n_runs, power (share with p below `SIGNIFICANCE_LEVEL`)
    """
    tables = []
    for run in sorted(other_runs["run"].unique().tolist()):
        of_run = other_runs[other_runs["run"] == run]
        for binning, table in of_run.groupby("binning", sort=False):
            comparison = place_published_values(runs[runs["binning"] == binning], table)
            tables.append(
                tests_of_table_1(comparison, centres, other_centres[(run - 1) % len(other_centres)])
            )
    groups = pd.concat(tables).groupby(["binning", "measure"], sort=False)["p"]
    return groups.agg(n_runs="size", power=lambda p: (p < SIGNIFICANCE_LEVEL).mean()).reset_index()


def size_of_tests(runs: pd.DataFrame) -> pd.DataFrame:
    """Compute how often the tests of Table I reject a run of the same kind: each run replaces Table I once, against the others.

    Parameters
    ----------
    runs : DataFrame
        See `runs_as_published`; if it has a column `centres`, the number of centres of each run is tested, too.

    Returns
    -------
    DataFrame: binning, measure, n_runs, share (with p below `SIGNIFICANCE_LEVEL`), low and high (its 95 % interval, somewhat too
    narrow: any two runs are compared with nearly the same others).
    """
    centres, tables = runs.groupby("run")["centres"].first() if "centres" in runs else None, []
    for run in sorted(runs["run"].unique().tolist()):
        for _, of_binning in runs.groupby("binning", sort=False):
            others, this_run = of_binning[of_binning["run"] != run], of_binning[of_binning["run"] == run]
            comparison = place_published_values(others, this_run)
            if centres is None:
                binning = comparison["binning"].iloc[0]
                tests = [
                    {"binning": binning, "measure": name, **joint_test(comparison, name)} for name in MEASURES
                ]
                tables.append(pd.DataFrame(tests))
            else:
                tables.append(tests_of_table_1(comparison, centres.drop(run).to_numpy(), centres[run]))
    groups = pd.concat(tables).groupby(["binning", "measure"], sort=False)["p"]
    out = groups.agg(n_runs="size", share=lambda p: (p < SIGNIFICANCE_LEVEL).mean()).reset_index()
    low, high = wilson_interval(out["share"].to_numpy(), out["n_runs"].to_numpy())
    return out.assign(low=low, high=high)


def wilson_interval(share: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the 95 % interval of a share of n independent cases (Wilson, J. Am. Stat. Assoc. 22:209, 1927)."""
    z2 = NORMAL_QUANTILE**2
    middle = (share + z2 / (2 * n)) / (1 + z2 / n)
    half = NORMAL_QUANTILE * np.sqrt(share * (1 - share) / n + z2 / (4 * n**2)) / (1 + z2 / n)
    return middle - half, middle + half


def selection_bias(runs: pd.DataFrame, table: pd.DataFrame) -> pd.DataFrame:
    """Compare d and Z_tS of the winners with those of the same combinations at many shared test dots.

    Parameters
    ----------
    runs : DataFrame
        See `runs_as_published`.
    table : DataFrame
        grid.csv of the same surface with shared test dots.

    Returns
    -------
    DataFrame, one row per binning and range: d_bias, Z_tS_bias (means over the runs)
    """
    true = table.set_index(PARAMETERS)
    keys = pd.MultiIndex.from_frame(runs[PARAMETERS])
    columns = {
        f"{name}_bias": runs[name].to_numpy() - true[f"{name}_{CODED_READING}"].reindex(keys).to_numpy()
        for name in MEASURES
    }
    return (
        runs[["binning", "range"]]
        .assign(**columns)
        .groupby(["binning", "range"], sort=False)
        .mean()
        .reset_index()
    )
