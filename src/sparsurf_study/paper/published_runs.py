"""Compare Table I of the paper with the winners of runs as published: whole grid, new test dots, one draw, `kept`."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtr  # Student's t; scipy.stats takes a quarter of a second to import

from sparsurf.evaluation.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.patches.index import build_index
from sparsurf.patches.readings import KEPT_READING
from sparsurf.progress import Report, unreported
from sparsurf.sampling import published
from sparsurf.sampling.combination import PARAMETERS, TABLE_1
from sparsurf.streams import stream
from sparsurf_study.analysis import grid
from sparsurf_study.analysis.tables import range_index, range_limits
from sparsurf_study.paper.verdict import MEASURES, MIN_P, MIN_RUNS

RUNS = 40  # as-published runs of the whole grid
PUBLISHED_CENTRES = 181  # So many patches cover A1, as published.
SIMULATED_SUMS = 100_000  # sums of squares from which the p of all rows is taken


def runs_as_published(
    prepared: PreparedSurface,
    combinations: np.ndarray,
    runs: int = RUNS,
    progress: Report = unreported,
) -> pd.DataFrame:
    """Repeat Table I as published, for combinations (K, 4): the winner of each run and range, for paper_as_published.csv."""
    combinations = np.asarray(combinations, float)
    tests, rows = number_of_tests("published", len(prepared.points)), []
    for run in range(runs):
        renamed = prepared.with_streams(replace(prepared.stream, name=f"{prepared.name} selection {run}"))
        result = grid.evaluate_grid(renamed, combinations, tests, 1, (KEPT_READING,), shared=False)
        z_ts = result.z_ts[0].mean(axis=(1, 2), dtype=np.float64)
        d = result.z_tr[0].mean(axis=(1, 2), dtype=np.float64) - z_ts
        percent = 100 * result.n_s[:, 0] / result.n_dots
        rows += [{"run": run + 1} | row for row in winners(combinations, percent, d, z_ts)]
        progress(run + 1, runs)
    return pd.DataFrame(rows)


def centres_in_random_orders(prepared: PreparedSurface, runs: int = RUNS) -> np.ndarray:
    """Count the centres of patches if the dots are visited in random orders, (runs,) int; programs order dots differently."""
    points, normals, counts = prepared.points, prepared.normals, []
    for run in range(runs):
        order = prepared.stream("order of the dots", run).permutation(len(points))
        index = build_index(points[order], normals[order], prepared.patches.d_link)
        counts.append(
            len(published.build_cover(index, np.zeros(len(order)), prepared.patches.r_patch).centre)
        )
    return np.array(counts)


def winners(
    combinations: np.ndarray, percent: np.ndarray, d: np.ndarray, z_ts: np.ndarray
) -> Iterator[dict[str, Any]]:
    """Yield the combination with the highest d in each range, as a dict."""
    limits = range_limits(percent, len(TABLE_1))
    member = range_index(percent, limits)
    for k in range(len(TABLE_1)):
        inside = np.flatnonzero(member == k)
        row: dict[str, Any] = {"range": k + 1, "n_S_low_percent": limits[k]}
        row |= {"n_S_high_percent": limits[k + 1], "n_combinations": len(inside)}
        if len(inside):
            best = inside[np.argmax(d[inside])]
            row |= dict(zip(PARAMETERS, map(float, combinations[best]), strict=True))
            row |= {"n_S_percent": percent[best], "d": d[best], "Z_tS": z_ts[best]}
        yield row


def place_published_values(runs: pd.DataFrame) -> pd.DataFrame:
    """Compare each published value with those of the winners of the runs: the rows of paper_places.csv.

    p is the two-sided probability of a rank as extreme by chance; `inside` is 1 where it is at least 0.05, and NaN where fewer
    than MIN_RUNS runs have a winner, among which no rank is as extreme.
    """
    published, out = pd.DataFrame(TABLE_1, range(1, len(TABLE_1) + 1)), []
    for k, of_range in runs.groupby("range", sort=False):
        won = of_range[of_range["n_combinations"] > 0]
        expected = published.loc[[k]].iloc[0]
        parameters = expected[PARAMETERS].astype(float)
        row: dict[str, Any] = {"range": k, "n_runs": len(won)}
        row |= dict(zip(PARAMETERS, parameters, strict=True))
        row["n_won"] = int(np.isclose(won[PARAMETERS], parameters.to_numpy()).all(axis=1).sum())
        for name in MEASURES:
            statistics: dict[str, float] = {"published": float(expected[name])}
            statistics |= _rank(won[name].to_numpy(), statistics["published"]) if len(won) > 1 else {}
            statistics.setdefault("inside", np.nan)
            row |= {f"{name}_{key}": value for key, value in statistics.items()}
        out.append(row)
    return pd.DataFrame(out)


def _rank(values: np.ndarray, published: float) -> dict[str, float]:
    """Compare one published value with those of the runs."""
    n_below, n_above = int((values < published).sum()), int((values > published).sum())
    statistics = {"mean": values.mean(), "sd": values.std(ddof=1)}
    statistics |= {"lowest": values.min(), "highest": values.max(), "n_below": n_below}
    p = min(1.0, 2 * (min(n_below, n_above) + 1) / (len(values) + 1))
    return statistics | {"p": p, "inside": float(p >= MIN_P) if len(values) >= MIN_RUNS else np.nan}


def joint_test(comparison: pd.DataFrame, name: str, leave_out: Sequence[int] = ()) -> dict[str, float]:
    """Test all published values of d or Z_tS at once by their squared distances from the runs, without the ranges `leave_out`.

    If a published row is one more run of the same kind, (value - mean) / (sd sqrt(1 + 1 / n)) follows Student's t with n - 1
    degrees of freedom. Rows have their own test dots and draws, so the squares add.
    """
    rows = comparison[~comparison["range"].isin(leave_out)].dropna(subset=[f"{name}_sd", f"{name}_published"])
    n = rows["n_runs"].to_numpy()
    difference = rows[f"{name}_published"] - rows[f"{name}_mean"]
    statistic = float(((difference / (rows[f"{name}_sd"] * np.sqrt(1 + 1 / n))) ** 2).sum())
    simulated = _simulated_statistics(tuple(map(int, n)), SIMULATED_SUMS)
    p = float((np.sum(simulated >= statistic) + 1) / (len(simulated) + 1))
    return {"n_rows": len(rows), "statistic": statistic, "p": p}


@lru_cache  # d and Z_tS are tested with the same numbers of runs
def _simulated_statistics(runs: tuple[int, ...], simulated: int) -> np.ndarray:
    """Simulate sums of squares of Student's t, each with as many degrees of freedom as runs minus one, (simulated,)."""
    t = stream(0, "published rows").standard_t(np.array(runs) - 1, size=(simulated, len(runs)))
    return (t**2).sum(axis=1)


def tests_of_table_1(
    comparison: pd.DataFrame, centres: np.ndarray, published_centres: int = PUBLISHED_CENTRES
) -> pd.DataFrame:
    """Run every test of Table I: the rows of paper_tests.csv.

    The number of centres is tested by Student's t, as one more order; p of all together is three times the smallest (Bonferroni).
    """
    t = (published_centres - np.mean(centres)) / (np.std(centres, ddof=1) * np.sqrt(1 + 1 / len(centres)))
    of_centres = {"n_rows": 1, "statistic": t**2, "p": float(2 * stdtr(len(centres) - 1, -abs(t)))}
    tests = {name: joint_test(comparison, name) for name in MEASURES} | {"centres": of_centres}
    least = min(test["p"] for test in tests.values())
    tests["together"] = {"n_rows": len(comparison), "statistic": np.nan, "p": min(1.0, len(tests) * least)}
    return pd.DataFrame([{"measure": name, **test} for name, test in tests.items()])


def selection_bias(runs: pd.DataFrame, table: pd.DataFrame) -> pd.DataFrame:
    """Compare d and Z_tS of the winners with those of the same combinations in grid.csv: means over the runs by range."""
    true = table.set_index(PARAMETERS)
    keys = pd.MultiIndex.from_frame(runs[PARAMETERS])
    columns = {
        f"{name}_bias": runs[name].to_numpy() - true[f"{name}_{KEPT_READING}"].reindex(keys).to_numpy()
        for name in MEASURES
    }
    return runs[["range"]].assign(**columns).groupby("range", sort=False).mean().reset_index()
