"""Table I of the paper against the winners of runs made as it was: the whole grid, fresh test dots, one draw, `kept`."""

import numpy as np
import pandas as pd

from sparsurf.patches.readings import PUBLISHED
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.sampling.published import PUBLISHED_ROWS, TABLE_1
from sparsurf.streams import stream
from sparsurf.study import grid
from sparsurf.study.evaluator import number_of_tests
from sparsurf.study.ranges import range_limits, range_of

RUNS = 40  # as-published runs of the whole grid
BINNINGS = {"closed": True, "half-open": False}  # whether the last range holds the largest n_S
MEASURES = ("d", "Z_tS")
SIMULATED = 100_000  # sums of squares from which the p of all rows is taken


def as_published(evaluator, combinations, runs=RUNS, progress=lambda done, of: None):
    """Table I made the paper's way, again and again: N / 200 fresh test dots per combination, one draw, islands `kept`.

    Returns
    -------
    DataFrame, one row per run, binning and range: run (from 1), binning, range (from 1), n_S_low_percent,
    n_S_high_percent, n_combinations, and of the winner alpha .. delta, n_S_percent, d, Z_tS (NaN in an empty range)
    """
    tests, rows = number_of_tests("published", len(evaluator.points)), []
    for run in range(runs):
        own = evaluator.changed(name=f"{evaluator.name} selection {run}")
        result = grid.run(own, combinations, tests, 1, (PUBLISHED,), shared=False)
        z_ts = result.z_ts[0].mean(axis=(1, 2), dtype=np.float64)
        d = result.z_tr[0].mean(axis=(1, 2), dtype=np.float64) - z_ts
        percent = 100 * result.n_s[:, 0] / result.n_dots
        rows += [{"run": run + 1} | row for row in winners(result.combinations, percent, d, z_ts)]
        progress(run + 1, runs)
    return pd.DataFrame(rows)


def winners(combinations, percent, d, z_ts):
    """The combination with the highest d in each range, under both binnings, as dicts."""
    limits = range_limits(percent, len(TABLE_1))
    for binning, closed in BINNINGS.items():
        member = range_of(percent, limits, closed)
        for k in range(len(TABLE_1)):
            inside = np.flatnonzero(member == k)
            row = {"binning": binning, "range": k + 1}
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


def place_of_published(runs):
    """Each published value among the winners of the runs.

    Returns
    -------
    DataFrame, one row per binning and range: range, n_runs (with a winner), alpha .. delta published, n_won (runs in
    which the published combination won), and for d and Z_tS: the published value, mean, sd, lowest and highest of the
    runs, n_below (runs that lie lower) and p, the two-sided probability of a place as far out by chance
    """
    out = []
    for (binning, k), own in runs.groupby(["binning", "range"], sort=False):
        own = own[own["n_combinations"] > 0]
        published = TABLE_1[k - 1]
        row = {"binning": binning, "range": k, "n_runs": len(own)}
        row |= {name: float(published[name]) for name in PARAMETERS}
        row["n_won"] = int(np.isclose(own[PARAMETERS], PUBLISHED_ROWS[k - 1]).all(axis=1).sum())
        for name in MEASURES if len(own) > 1 else ():
            values, value = own[name].to_numpy(), float(published[name])
            n_below = int((values < value).sum())
            row |= {
                f"{name}_published": value,
                f"{name}_mean": values.mean(),
                f"{name}_sd": values.std(ddof=1),
            }
            row |= {
                f"{name}_lowest": values.min(),
                f"{name}_highest": values.max(),
                f"{name}_n_below": n_below,
            }
            row[f"{name}_p"] = min(
                1.0, 2 * (min(n_below, int((values > value).sum())) + 1) / (len(values) + 1)
            )
        out.append(row)
    return pd.DataFrame(out)


def all_rows_at_once(places, name, leave_out=()):
    """One test of all published values: the sum of their squared distances from the runs, in standard deviations.

    If a published row is one more run of the same kind, (value - mean) / (sd sqrt(1 + 1 / n)) follows Student's t with
    n - 1 degrees of freedom; rows have test dots and draws of their own, so the squares add.

    Parameters
    ----------
    places : DataFrame
        `place_of_published`, of one binning.
    name : {'d', 'Z_tS'}
    leave_out : sequence of int
        Ranges (from 1).

    Returns
    -------
    dict: n_rows, statistic, p
    """
    rows = places[~places["range"].isin(leave_out)].dropna(subset=f"{name}_sd")
    n = rows["n_runs"].to_numpy()
    off = rows[f"{name}_published"] - rows[f"{name}_mean"]
    t = (off / (rows[f"{name}_sd"] * np.sqrt(1 + 1 / n))).to_numpy()
    drawn = stream(0, "published rows").standard_t(n - 1, size=(SIMULATED, len(n)))
    statistic = float((t**2).sum())
    p = float((np.sum((drawn**2).sum(axis=1) >= statistic) + 1) / (SIMULATED + 1))
    return {"n_rows": len(rows), "statistic": statistic, "p": p}


def selection_bias(runs, table):
    """How far the winners' d and Z_tS lie from what the same combinations give with many shared test dots.

    Parameters
    ----------
    runs : DataFrame
        See `as_published`.
    table : DataFrame
        grid.csv of the same surface with shared test dots.

    Returns
    -------
    DataFrame, one row per binning and range: d_bias, Z_tS_bias (means over the runs)
    """
    true = table.set_index(PARAMETERS)
    keys = pd.MultiIndex.from_frame(runs[PARAMETERS])
    columns = {
        f"{name}_bias": runs[name].to_numpy() - true[f"{name}_{PUBLISHED}"].reindex(keys).to_numpy()
        for name in MEASURES
    }
    return (
        runs[["binning", "range"]]
        .assign(**columns)
        .groupby(["binning", "range"], sort=False)
        .mean()
        .reset_index()
    )
