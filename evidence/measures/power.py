"""How often the test of Table I notices that a run was made by other rules than the reference."""

from functools import cache

import numpy as np
import pandas as pd

from sparsurf.paper.published_runs import MEASURES, SIMULATED, as_published
from sparsurf.sampling import law
from sparsurf.streams import stream
from sparsurf.study.evaluator import Evaluator

LEVEL = 0.05


def runs_of(surface, combinations, rules, seed, name, runs, threads=1, progress=lambda done, of: None):
    """Winners of runs as published under rules of one's own, with the number of centres of the cover.

    Parameters
    ----------
    surface : Surface
    combinations : (K, 4) float64
    rules : dict, some of R_patch, R_zernike, D_link (Å), and `alpha`, a factor of all alphas
    seed, name, runs, threads : of the runs; another name gives other runs
    """
    radii = (rules.get(key, usual) for key, usual in (("R_patch", 4.0), ("R_zernike", 6.0), ("D_link", 0.5)))
    evaluator = Evaluator(surface, *radii, seed=seed, name=name, threads=threads)
    scaled = law_of(combinations, rules.get("alpha", 1.0))
    return as_published(evaluator, scaled, runs, progress).assign(centres=len(evaluator.cover.centre))


def law_of(combinations, factor):
    """Combinations whose alpha is `factor` times as large."""
    return np.asarray(combinations, float) * (factor, 1, 1, 1)


def grid_of(sampling):
    """The combinations of the config's `sampling`, (K, 4)."""
    return law.grid(*(sampling[key] for key in ("alpha", "beta", "gamma", "delta")))


def statistic(values, reference):
    """Sum of squared distances from the runs of the reference, as Student's t, and the runs of each row.

    Parameters
    ----------
    values : Series by range
    reference : Series by (run, range)
    """
    of_range = reference.groupby("range")
    n, mean, sd = of_range.count(), of_range.mean(), of_range.std(ddof=1)
    t = ((values - mean) / (sd * np.sqrt(1 + 1 / n))).dropna()
    return float((t**2).sum()), tuple(n[t.index])


def p_of(total, freedom):
    """Chance of a statistic as large, of a run of the same kind."""
    null = _null(freedom)
    return float((SIMULATED - np.searchsorted(null, total) + 1) / (SIMULATED + 1))


@cache
def _null(freedom):
    drawn = stream(0, "published rows").standard_t(np.array(freedom) - 1, size=(SIMULATED, len(freedom)))
    return np.sort((drawn**2).sum(axis=1))


def power(reference, other):
    """Of the runs of one rule: binning, measure, share that the test notices at `LEVEL`, and the centres.

    Parameters
    ----------
    reference, other : DataFrame
        See `runs_of`.
    """
    rows = []
    for binning, own in other.groupby("binning", sort=False):
        known = reference[reference["binning"] == binning].set_index(["run", "range"])
        for measure in MEASURES:
            found = [
                statistic(part.set_index("range")[measure], known[measure]) for _, part in own.groupby("run")
            ]
            p = [p_of(*each) for each in found]
            row = {"binning": binning, "measure": measure, "n_runs": len(p)}
            rows.append(row | {"power": np.mean(np.array(p) < LEVEL), "median_p": np.median(p)})
    return pd.DataFrame(rows).assign(centres=int(other["centres"].iloc[0]))
