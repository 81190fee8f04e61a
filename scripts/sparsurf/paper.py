"""The paper's numbers beside ours: Table I as published, row by row, and what it rests on.

Everything here works on one surface made ready by `evaluation.Evaluator`.
"""

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from sparsurf import tables
from sparsurf.evaluation import PUBLISHED_ROWS, TABLE_1, Evaluator, mean_and_error, number_of_tests

REPLICATES = 40  # as-published evaluations of each published combination
SELECTIONS = 5  # as-published runs of the whole grid, from which selection bias is estimated
LINKS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5)  # Å, linking distances of the sweep


def published_table():
    """Table I as a DataFrame."""
    return pd.DataFrame(TABLE_1)


def replicate_rows(evaluator, replicates=REPLICATES):
    """Every published combination evaluated as published, again and again.

    Fresh N / 200 test dots, one draw, islands `kept`.

    Returns
    -------
    dict of (replicates, 10) float64: n_S_percent, d, Z_tS
    """
    n = len(evaluator.points)
    tests = number_of_tests("published", n)
    runs = [_as_published(evaluator, PUBLISHED_ROWS, tests, f"replicate {k}") for k in range(replicates)]
    return {
        "n_S_percent": 100 * np.array([g.n_s[:, 0] for g in runs]) / n,
        "d": np.array([tables.difference(g, 0).mean(axis=(1, 2)) for g in runs]),
        "Z_tS": np.array([g.z_ts[0].mean(axis=(1, 2)) for g in runs]),
    }


def _as_published(evaluator, combinations, n_tests, run):
    """A grid with fresh test dots per combination, in random streams of its own."""
    return evaluator.renamed(f"{evaluator.name} {run}").grid(
        combinations, n_tests, 1, ("kept",), shared=False
    )


def as_published(evaluator, combinations, selections=SELECTIONS, progress=lambda done, of: None):
    """Table I made the paper's way, several times: the winner of each range with its own noisy d.

    Returns
    -------
    list of DataFrame, one per run: see `tables.ranges_table`
    """
    tests = number_of_tests("published", len(evaluator.points))
    out = []
    for k in range(selections):
        grid = _as_published(evaluator, combinations, tests, f"selection {k}")
        out.append(tables.ranges_table(tables.grid_table(grid), grid, len(TABLE_1)))
        progress(k + 1, selections)
    return out


def selection_bias(selected, table):
    """How far the winners' d and Z_tS lie from what the same combinations give with many shared test dots.

    Parameters
    ----------
    selected : list of DataFrame
        See `as_published`.
    table : DataFrame
        grid.csv of the same surface with shared test dots.

    Returns
    -------
    DataFrame, one row per range: d_bias, Z_tS_bias (means over the runs; the bias of Table I's way of choosing)
    """
    true = table.set_index(tables.PARAMETERS)
    rows = []
    for one in selected:
        keys = [tuple(row) for row in one[tables.PARAMETERS].to_numpy()]
        rows.append(
            {
                "d_bias": one["d"].to_numpy() - true["d_kept"].reindex(keys).to_numpy(),
                "Z_tS_bias": one["Z_tS"].to_numpy() - true["Z_tS_kept"].reindex(keys).to_numpy(),
            }
        )
    return pd.concat(map(pd.DataFrame, rows)).groupby(level=0).mean()


def rows_table(replicated, bias, truth):
    """Each published row with our interval and whether the published value falls into it.

    A published value was the best of its range, ours was not chosen: it agrees when it lies within 1.96 standard
    deviations of one replicate of our mean, the interval made longer by the selection bias of the range on the side
    that selection pulls to. n_S agrees when our mean lies in the published range.

    Returns
    -------
    DataFrame, ten rows
    """
    out = published_table().rename(columns={"d": "d_published", "Z_tS": "Z_tS_published"})
    percent = replicated["n_S_percent"].mean(axis=0)
    out["n_S_percent"] = percent
    slack = 0.05 * (
        out["n_S_high_percent"] - out["n_S_low_percent"]
    )  # the limits move by this from run to run
    out["n_S_agrees"] = (percent >= out["n_S_low_percent"] - slack) & (
        percent <= out["n_S_high_percent"] + slack
    )
    for name in ("d", "Z_tS"):
        x = replicated[name]
        mean, sd = x.mean(axis=0), x.std(axis=0, ddof=1)
        out[name], out[f"{name}_sd"], out[f"{name}_bias"] = mean, sd, bias[f"{name}_bias"].to_numpy()
        bias_here = out[f"{name}_bias"].fillna(0).to_numpy()
        out[f"{name}_low"] = mean + np.minimum(bias_here, 0) - tables.Z95 * sd
        out[f"{name}_high"] = mean + np.maximum(bias_here, 0) + tables.Z95 * sd
        inside = (out[f"{name}_published"] >= out[f"{name}_low"] - 0.005) & (
            out[f"{name}_published"] <= out[f"{name}_high"] + 0.005
        )
        out[f"{name}_agrees"] = inside
    for key, values in truth.items():  # d_kept becomes d_shared_kept
        name, reading = key.rsplit("_", 1)
        out[f"{name}_shared_{reading}"] = values
    return out


def rows_with_shared_tests(evaluator, n_tests, draws):
    """The published combinations under both readings with shared test dots: dict of (10,) float64."""
    grid = evaluator.grid(PUBLISHED_ROWS, n_tests, draws)
    out = {}
    for r, reading in enumerate(grid.readings):
        out[f"d_{reading}"] = mean_and_error(tables.difference(grid, r))[0]
        out[f"Z_tS_{reading}"] = mean_and_error(grid.z_ts[r])[0]
        out[f"fragment_{reading}"] = grid.fragment[r, 0]
    return out


def sweep_links(surface, links, n_tests, draws, **settings):
    """d of the published combinations under `kept` for other linking distances.

    The sampling itself stays that of D_link = 0.5 Å: only the evaluation's islands change.

    Returns
    -------
    DataFrame: D_link, row (1..10), n_S_percent, d, d_se, Z_tS, fragment
    """
    first = Evaluator(surface, **settings)
    tests = first.draw_tests(n_tests)
    pairs = [first.pair(row, draw) for row in PUBLISHED_ROWS for draw in range(draws)]
    out = []
    with threadpool_limits(1, "blas"):
        for link in links:
            linked = first.relinked(link)
            z_tot, _ = linked.describe(tests)
            z_ts, size = linked.distances([s for s, _ in pairs], tests, z_tot, "kept")
            z_tr, _ = linked.distances([u for _, u in pairs], tests, z_tot, "kept")
            shape = (len(PUBLISHED_ROWS), draws, len(tests))
            d, error = mean_and_error((z_tr - z_ts).reshape(shape))
            for row in range(len(PUBLISHED_ROWS)):
                out.append(
                    {
                        "D_link": link,
                        "row": row + 1,
                        "n_S_percent": 100 * len(pairs[row * draws][0]) / len(surface.points),
                        "d": d[row],
                        "d_se": error[row],
                        "Z_tS": z_ts.reshape(shape)[row].mean(),
                        "fragment": np.median(size.reshape(shape)[row]),
                    }
                )
    return pd.DataFrame(out)


DEFECTS = {
    "as published": (True, True),
    "distances from the dot itself": (False, True),
    "one draw per dot": (True, False),
    "both corrected": (False, False),
}


def compare_defects(surface, n_tests, draws, **settings):
    """n_S, d and Z_tS of the published combinations with each defect of the published sampling corrected.

    Returns
    -------
    DataFrame: sampling, row, n_S_percent (closed form), then d and Z_tS under both readings
    """
    out = []
    for name, (moved_centre, every_patch) in DEFECTS.items():
        evaluator = Evaluator(surface, moved_centre=moved_centre, every_patch=every_patch, **settings)
        grid = evaluator.grid(PUBLISHED_ROWS, n_tests, draws)
        table = tables.grid_table(grid)
        part = pd.DataFrame({"sampling": name, "row": np.arange(1, len(PUBLISHED_ROWS) + 1)})
        part["n_S_percent"] = 100 * grid.n_s_expected / grid.n_dots
        for reading in grid.readings:
            for column in ("d", "d_se", "Z_tS", "fragment"):
                part[f"{column}_{reading}"] = table[f"{column}_{reading}"]
        out.append(part)
    return pd.concat(out, ignore_index=True)


def by_roughness(evaluator, best, n_tests):
    """Roughness of many test dots and, per reading, Z_tS(j), Z_tR(j) of the best combination under `kept`."""
    combination = [best["kept"]["unrestricted"][p] for p in tables.PARAMETERS]
    subsets = evaluator.pair(combination, 0)
    tests = evaluator.draw_tests(n_tests, "by roughness")
    with threadpool_limits(1, "blas"):
        z_tot, _ = evaluator.describe(tests)
        distances = {r: evaluator.distances(subsets, tests, z_tot, r)[0] for r in ("kept", "surface")}
    return evaluator.roughness[tests], {reading: (z[0], z[1]) for reading, z in distances.items()}


def surface_sentence(evaluator, made):
    """Which dots the page is about."""
    n = len(evaluator.points)
    rough = evaluator.roughness
    return (
        f"Surface: {made}; N = {n} dots (the paper's A1: 20045), {len(evaluator.cover.centre)} centres (181), mean "
        f"roughness {rough.mean():.4f} (0.6263)."
    )
