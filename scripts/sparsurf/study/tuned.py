"""The whole family of the paper's sampling at equal n_S: alpha tuned for every (beta, gamma, delta)."""

import numpy as np
import pandas as pd

from sparsurf.patches.readings import TEXT
from sparsurf.sampling import law
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.sampling.samplers import tune_alpha
from sparsurf.study import grid
from sparsurf.study.statistics import estimate

PERCENTS = (5.0, 10.0, 20.0, 40.0)  # n_S, % of the dots


def tuned_family(evaluator, exponents, percents=PERCENTS, n_tests=400, draws=3):
    """Every member of the family that can keep a wished n_S, against a uniform draw of as many dots.

    Parameters
    ----------
    evaluator : Evaluator
    exponents : (K, 3) float64
        beta, gamma, delta.
    percents : sequence of float
    n_tests, draws : int

    Returns
    -------
    DataFrame, one row per wished n_S (`percent`) and member that reaches it with an alpha of at most 1: alpha ..
    delta, n_S_percent, Z_tS, Z_tR, d with d_low and d_high, under `surface`
    """
    n_dots, wished, rows = len(evaluator.points), [], []
    exponents = np.unique(np.asarray(exponents, float), axis=0)
    reach = law.expected_n_s(evaluator.cover, np.insert(exponents, 0, 1.0, axis=1))
    for percent in percents:
        n = percent / 100 * n_dots
        for row in exponents[reach >= n]:
            wished.append(percent)
            rows.append(tune_alpha(evaluator.cover, (1.0, *row), n))
    result = grid.run(evaluator, rows, n_tests, draws, (TEXT,))
    d = estimate(result.z_tr[0].astype(np.float64) - result.z_ts[0])
    table = pd.DataFrame(result.combinations, columns=PARAMETERS)
    table.insert(0, "percent", wished)
    table["n_S_percent"] = 100 * result.n_s.mean(axis=1) / n_dots
    table["Z_tS"], table["Z_tR"] = (
        z[0].mean(axis=(1, 2), dtype=np.float64) for z in (result.z_ts, result.z_tr)
    )
    return table.assign(d=d.mean, d_low=d.low, d_high=d.high)


def best_of_family(table):
    """Per wished n_S: members, those above a uniform draw for certain, and the one with the lowest Z_tS."""
    rows = []
    for percent, own in table.groupby("percent"):
        best = own.loc[own["Z_tS"].idxmin()]
        rows.append(
            {"percent": percent, "members": len(own), "n_better": int((own["d_low"] > 0).sum())}
            | {"n_worse": int((own["d_high"] < 0).sum()), "largest_d": own["d"].max(), "Z_best": best["Z_tS"]}
            | {"Z_uniform": own["Z_tR"].mean(), **best[PARAMETERS].to_dict()}
        )
    return pd.DataFrame(rows)
