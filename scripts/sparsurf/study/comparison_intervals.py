"""Intervals of what a comparison of samplers says: differences paired by test dot, and times fewer dots.

All samplers are measured at the same test dots, so that what a test dot adds to all of them cancels in a difference.
"""

import numpy as np
import pandas as pd

from sparsurf.study.comparison import USE
from sparsurf.study.dots_needed import BOUND, OF_ERROR, REFERENCE, dots_for
from sparsurf.study.statistics import LEVEL, estimate

AGAINST = (REFERENCE, "farthest")  # samplers that the others are set against, beside the best
OF_FEWER = ["use", "measure", "than", "sampler", "percent", "factor", "low", "high", "bound"]
RESAMPLED = 400  # bootstrap samples of test dots and draws


def paired(raw, percents, measures=("Z surface", "Z scaled", "Z centres"), against=AGAINST):
    """Differences of Z between samplers.

    Parameters
    ----------
    raw : dict
        (sampler, measure) -> (P, D, T), see `comparison.compare`.
    percents : sequence of float
    measures, against : sequences of str

    Returns
    -------
    DataFrame: measure, than, sampler, percent, difference (sampler - than: negative where the sampler is better) and its
    95 % interval, low and high
    """
    rows = []
    for measure in measures:
        names = [name for name, each in raw if each == measure]
        for than in [name for name in against if name in names]:
            for name in [name for name in names if name != than]:
                found = estimate(raw[name, measure] - raw[than, measure])
                columns = {"measure": measure, "than": than, "sampler": name, "percent": percents}
                rows.append(
                    pd.DataFrame(columns | {"difference": found.mean, "low": found.low, "high": found.high})
                )
    return pd.concat(rows, ignore_index=True) if rows else pd.DataFrame()


def times_fewer_intervals(raw, table, rng, against=(REFERENCE, "paper"), resampled=RESAMPLED):
    """How many times fewer dots each sampler needs than another for the Z that one reaches, with 95 % intervals.

    Test dots, shared by all samplers, and the draws of each are drawn again with replacement, and the curves of Z over n_S
    made anew.

    Parameters
    ----------
    raw : dict
        See `paired`.
    table : DataFrame
        See `comparison.compare`: n_S_percent of every sampler.
    rng : numpy.random.Generator
    against : sequence of str

    Returns
    -------
    DataFrame: use, measure, than, sampler, percent (of `than`), factor, low, high, bound; no rows of a measure that is not there.
    An n_S beyond those that were measured counts as the nearest measured one, so that a factor there is a bound: 'more
    than ' or 'less than ' in the column of that name. So is the limit on that side; where all samples are at the bound,
    nothing is known of the scatter, and low and high are NaN.
    """
    rows = []
    for measure in OF_ERROR:
        names = [name for name, each in raw if each == measure]
        if not names:
            continue
        n_s = table[table["measure"] == measure].pivot(
            index="sampler", columns="percent", values="n_S_percent"
        )
        curves = dict(zip(names, _together(raw, measure, names, rng, resampled), strict=True))
        for than in [name for name in against if name in names]:
            for name in [name for name in names if name != than]:
                own, other = n_s.loc[than].to_numpy(), n_s.loc[name].to_numpy()
                for p, percent in enumerate(n_s.columns):
                    pairs = zip(curves[than], curves[name], strict=True)
                    needed = [dots_for(a[p], other, b) for a, b in pairs]
                    factors = own[p] / np.clip(needed, other[0], other[-1])
                    low, high = np.quantile(factors[1:], [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
                    bound = BOUND.get(needed[0], "")
                    if bound and low == high:
                        low = high = np.nan
                    row = {
                        "use": USE[measure],
                        "measure": measure,
                        "than": than,
                        "sampler": name,
                        "percent": percent,
                    }
                    row |= {"factor": factors[0], "low": low, "high": high, "bound": bound}
                    rows.append(row)
    return pd.DataFrame(rows, columns=OF_FEWER)


def _together(raw, measure, names, rng, resampled):
    """Curves (1 + resampled, P) of each sampler, the first as measured; test dots are drawn again for all at once."""
    n_tests = raw[names[0], measure].shape[2]
    tests = [np.arange(n_tests), *(rng.integers(0, n_tests, n_tests) for _ in range(resampled))]
    for name in names:
        x = raw[name, measure]
        draws = [np.arange(x.shape[1]), *(rng.integers(0, x.shape[1], x.shape[1]) for _ in range(resampled))]
        yield np.array([x[:, d][:, :, t].mean(axis=(1, 2)) for d, t in zip(draws, tests, strict=True)])
