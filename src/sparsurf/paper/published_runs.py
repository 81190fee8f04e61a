"""Table I of the paper against the winners of runs made as it was: the whole grid, fresh test dots, one draw, `as_coded`.

What such a test notices is its power: the share of runs with another parameter that it tells from runs as published.
"""

from functools import lru_cache

import numpy as np
import pandas as pd
from scipy.special import stdtr  # Student's t; scipy.stats takes a quarter of a second to import

from sparsurf.patches.index import build_index
from sparsurf.patches.readings import PUBLISHED
from sparsurf.sampling import published
from sparsurf.sampling.combination import PARAMETERS, TABLE_1
from sparsurf.streams import stream
from sparsurf.study import grid
from sparsurf.study.prepared_surface import number_of_tests
from sparsurf.study.tables import range_index, range_limits

RUNS = 40  # as-published runs of the whole grid
BINNINGS = {"closed": True, "half-open": False}  # whether the last range holds the largest n_S
MEASURES = ("d", "Z_tS")
CENTRES = 181  # of the patches that cover A1, as published
SIMULATED = 100_000  # sums of squares from which the p of all rows is taken
LEVEL = 0.05  # p below which a run counts as another one


def runs_as_published(evaluator, combinations, runs=RUNS, progress=lambda done, of: None, alpha=1.0):
    """Table I made the paper's way, again and again: N / 200 fresh test dots per combination, one draw, `as_coded`.

    Parameters
    ----------
    evaluator : Evaluator
    combinations : (K, 4) float64
    runs : int
    progress : callable
        Told how many of how many runs are done.
    alpha : float
        Factor of every alpha that is drawn by, which the table does not show.

    Returns
    -------
    DataFrame, one row per run, binning and range: run (from 1), binning, range (from 1), n_S_low_percent,
    n_S_high_percent, n_combinations, and of the winner alpha .. delta, n_S_percent, d, Z_tS (NaN in an empty range)
    """
    combinations = np.asarray(combinations, float)
    tests, rows = number_of_tests("published", len(evaluator.points)), []
    for run in range(runs):
        own = evaluator.changed(stream_name=f"{evaluator.name} selection {run}")
        result = grid.evaluate_grid(
            own, combinations * (alpha, 1, 1, 1), tests, 1, (PUBLISHED,), shared=False
        )
        z_ts = result.z_ts[0].mean(axis=(1, 2), dtype=np.float64)
        d = result.z_tr[0].mean(axis=(1, 2), dtype=np.float64) - z_ts
        percent = 100 * result.n_s[:, 0] / result.n_dots
        rows += [{"run": run + 1} | row for row in winners(combinations, percent, d, z_ts)]
        progress(run + 1, runs)
    return pd.DataFrame(rows)


def centres_in_random_orders(evaluator, runs=RUNS):
    """Number of centres of patches where the dots are swept in random orders, (runs,) int.

    It depends on R_patch and D_link, and on the order of the dots, which differs between programs.
    """
    points, normals, found = evaluator.points, evaluator.normals, []
    for run in range(runs):
        order = evaluator.stream("order of the dots", run).permutation(len(points))
        index = build_index(points[order], normals[order], evaluator.d_link)
        found.append(len(published.build_cover(index, np.zeros(len(order)), evaluator.r_patch).centre))
    return np.array(found)


def winners(combinations, percent, d, z_ts):
    """The combination with the highest d in each range, under both binnings, as dicts."""
    limits = range_limits(percent, len(TABLE_1))
    for binning, closed in BINNINGS.items():
        member = range_index(percent, limits, closed)
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


def table_1():
    """Table I as a DataFrame: range (from 1), alpha .. delta, d, Z_tS."""
    return pd.DataFrame(TABLE_1)[[*PARAMETERS, *MEASURES]].assign(range=np.arange(1, len(TABLE_1) + 1))


def place_published_values(runs, published=None):
    """Each published value among the winners of the runs.

    Parameters
    ----------
    runs : DataFrame
        See `as_published`.
    published : DataFrame, optional
        See `table_1`, which it is without.

    Returns
    -------
    DataFrame, one row per binning and range: range, n_runs (with a winner), alpha .. delta published, n_won (runs in
    which the published combination won), and for d and Z_tS: the published value, mean, sd, lowest and highest of the
    runs, n_below (runs that lie lower) and p, the two-sided probability of a place as far out by chance
    """
    published, out = (table_1() if published is None else published).set_index("range"), []
    for (binning, k), own in runs.groupby(["binning", "range"], sort=False):
        own, said = own[own["n_combinations"] > 0], published.loc[k]
        row = {"binning": binning, "range": k, "n_runs": len(own), **said[PARAMETERS].astype(float)}
        row["n_won"] = int(np.isclose(own[PARAMETERS], said[PARAMETERS].to_numpy(float)).all(axis=1).sum())
        for name in MEASURES if len(own) > 1 else ():
            found = _place(own[name].to_numpy(), float(said[name]))
            row |= {f"{name}_{key}": value for key, value in found.items()}
        out.append(row)
    return pd.DataFrame(out)


def _place(values, published):
    """One published value among those of the runs."""
    n_below, n_above = int((values < published).sum()), int((values > published).sum())
    found = {"published": published, "mean": values.mean(), "sd": values.std(ddof=1)}
    found |= {"lowest": values.min(), "highest": values.max(), "n_below": n_below}
    return found | {"p": min(1.0, 2 * (min(n_below, n_above) + 1) / (len(values) + 1))}


def joint_test(places, name, leave_out=()):
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
    rows = places[~places["range"].isin(leave_out)].dropna(subset=[f"{name}_sd", f"{name}_published"])
    n = rows["n_runs"].to_numpy()
    off = rows[f"{name}_published"] - rows[f"{name}_mean"]
    statistic = float(((off / (rows[f"{name}_sd"] * np.sqrt(1 + 1 / n))) ** 2).sum())
    drawn = _by_chance(tuple(map(int, n)), SIMULATED)
    p = float((np.sum(drawn >= statistic) + 1) / (len(drawn) + 1))
    return {"n_rows": len(rows), "statistic": statistic, "p": p}


@lru_cache
def _by_chance(runs, simulated):
    """Sums of squares of Student's t, each of as many degrees of freedom as runs less one, (simulated,)."""
    drawn = stream(0, "published rows").standard_t(np.array(runs) - 1, size=(simulated, len(runs)))
    return (drawn**2).sum(axis=1)


def tests_of_table_1(places, centres, published_centres=CENTRES):
    """Every test of Table I, under both binnings.

    Parameters
    ----------
    places : DataFrame
        See `place_of_published`.
    centres : (R,) int
        See `centres_in_any_order`.
    published_centres : int

    Returns
    -------
    DataFrame, of each binning a row for d, Z_tS, centres (by Student's t, as one more order) and together (the smallest of
    the three times three, Bonferroni): binning, measure, n_rows, statistic, p
    """
    off = (published_centres - np.mean(centres)) / (np.std(centres, ddof=1) * np.sqrt(1 + 1 / len(centres)))
    of_centres = {"n_rows": 1, "statistic": off**2, "p": float(2 * stdtr(len(centres) - 1, -abs(off)))}
    rows = []
    for binning, own in places.groupby("binning", sort=False):
        tests = {name: joint_test(own, name) for name in MEASURES} | {"centres": of_centres}
        least = min(test["p"] for test in tests.values())
        tests["together"] = {"n_rows": len(own), "statistic": np.nan, "p": min(1.0, len(tests) * least)}
        rows += [{"binning": binning, "measure": name, **test} for name, test in tests.items()]
    return pd.DataFrame(rows)


def power(runs, centres, other_runs, other_centres):
    """Share of runs made with another parameter that the tests of Table I tell from runs as published.

    Each of the other runs takes the place of Table I once.

    Parameters
    ----------
    runs, centres : as of `as_published` and `centres_in_any_order`, of the published parameters
    other_runs, other_centres : the same of another parameter

    Returns
    -------
    DataFrame: binning, measure, n_runs, power (share with p below `LEVEL`)
    """
    tables = []
    for run, own in other_runs.groupby("run"):
        for binning, table in own.groupby("binning", sort=False):
            places = place_published_values(runs[runs["binning"] == binning], table)
            tables.append(tests_of_table_1(places, centres, other_centres[(run - 1) % len(other_centres)]))
    groups = pd.concat(tables).groupby(["binning", "measure"], sort=False)["p"]
    return groups.agg(n_runs="size", power=lambda p: (p < LEVEL).mean()).reset_index()


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
