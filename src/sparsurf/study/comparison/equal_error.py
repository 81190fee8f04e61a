"""What follows from a comparison of samplers: dots needed for the same Z, differences, and means over proteins.

All samplers are measured at the same test dots, so that what a test dot adds to all of them cancels in a difference.
"""

import numpy as np
import pandas as pd

from sparsurf.study.comparison.measuring import USE
from sparsurf.study.required_dots import smallest_n_s
from sparsurf.study.statistics import CONFIDENCE_LEVEL, estimate

REFERENCE = "uniform"  # sampler that the others are set against
# What a factor is whose n_S `smallest_n_s` finds beyond those that were measured
BOUND = {0.0: "more than ", np.inf: "less than "}
Z_MEASURES = ("Z as_written", "Z centres")  # the Z of each use that `needed` speaks of
BASELINES = (REFERENCE, "farthest")  # samplers that the others are set against, beside the best
OF_FEWER = ["use", "measure", "than", "sampler", "percent", "factor", "low", "high", "bound"]
RESAMPLED = 400  # bootstrap samples of test dots and draws
KEYS = ["sampler", "percent", "use", "measure"]


def measure_matrix(table, measure, column="value"):
    """One measure as a matrix: samplers down, requested n_S (%) across, in the order of the table."""
    part = table[table["measure"] == measure]
    matrix = part.pivot(index="sampler", columns="percent", values=column)
    return matrix.reindex(index=part["sampler"].unique(), columns=part["percent"].unique())


def dots_needed(table, measure="Z as_written"):
    """Number of dots that each sampler needs for the Z that another one reaches.

    Parameters
    ----------
    table : DataFrame
        See `measuring.compare`.

    Returns
    -------
    DataFrame, one row per sampler and requested n_S: use, measure, sampler, percent, Z (what it reaches there), and
    for each sampler the n_S in % that reaches the same Z, by interpolation of ln Z over ln n_S. 0 stands for fewer
    dots than the smallest n_S that was measured, inf for more than the largest.
    """
    part = table[table["measure"] == measure]
    curves = {
        name: own.sort_values("n_S_percent")[["n_S_percent", "value"]].to_numpy().T
        for name, own in part.groupby("sampler", sort=False)
    }
    rows = [
        {**{key: row[key] for key in ("use", "measure", "sampler", "percent")}, "Z": row["value"]}
        | {name: smallest_n_s(row["value"], *curve) for name, curve in curves.items()}
        for _, row in part.iterrows()
    ]
    return pd.DataFrame(rows)


def dots_needed_for_all_uses(table):
    """`needed` for both uses, as the surface and as centres."""
    return pd.concat([dots_needed(table, measure) for measure in Z_MEASURES], ignore_index=True)


def measured_ranges(table, measure="Z as_written"):
    """The smallest and the largest n_S in % that were measured, (2,), of each sampler."""
    own = table[table["measure"] == measure].groupby("sampler")["n_S_percent"]
    return {name: (n_s.min(), n_s.max()) for name, n_s in own}


def factor_with_bound(row, of, ends):
    """How many times fewer dots the sampler `of` needs for the Z of a row of `needed`, with what `ends_of` gives.

    Returns
    -------
    float, and '' or, where the n_S lies beyond those that were measured, 'more than ' or 'less than '.
    """
    own, other = row[row["sampler"]], row[of]
    return float(own / np.clip(other, *ends[of])), BOUND.get(other, "")


def paired_differences(raw, percents, measures=("Z as_written", "Z scaled", "Z centres"), against=BASELINES):
    """Differences of Z between samplers.

    Parameters
    ----------
    raw : dict
        (sampler, measure) -> (P, D, T), see `measuring.compare`.
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


def factor_intervals(raw, table, rng, against=(REFERENCE, "paper"), resampled=RESAMPLED):
    """How many times fewer dots each sampler needs than another for the Z that one reaches, with 95 % intervals.

    Test dots, shared by all samplers, and the draws of each are drawn again with replacement, and the curves of Z over n_S
    made anew.

    Parameters
    ----------
    raw : dict
        See `paired`.
    table : DataFrame
        See `measuring.compare`: n_S_percent of every sampler.
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
    for measure in Z_MEASURES:
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
                    needed = [smallest_n_s(a[p], other, b) for a, b in pairs]
                    factors = own[p] / np.clip(needed, other[0], other[-1])
                    low, high = np.quantile(
                        factors[1:], [(1 - CONFIDENCE_LEVEL) / 2, (1 + CONFIDENCE_LEVEL) / 2]
                    )
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


def means_by_protein(tables):
    """Means over the conformations of each protein.

    Parameters
    ----------
    tables : dict
        (protein, conformation) -> table of `measuring.compare`.

    Returns
    -------
    dict, name -> table; where there is only one protein, its conformations stand for themselves.
    """
    names = list(dict.fromkeys(protein for protein, _ in tables))
    if len(names) == 1:
        return {f"{protein}/{conformation}": table for (protein, conformation), table in tables.items()}
    out = {}
    for name in names:
        own = pd.concat([table for (protein, _), table in tables.items() if protein == name])
        out[name] = own.groupby(KEYS, sort=False).mean(numeric_only=True).reset_index()
    return out


def means_over_proteins(units):
    """Means over proteins and the spread between them.

    Parameters
    ----------
    units : dict
        See `by_protein`.

    Returns
    -------
    DataFrame, one row per sampler, requested n_S and measure: n_S_percent, value, sd, lowest, highest over the
    proteins; the same of the ratio to the uniform subset of the same protein (NaN where it did not take part);
    n (of proteins, or of conformations of the only one); null_model, empty_patch and, where measured,
    fresh_dots and turned, means.
    """
    whole = pd.concat([table.assign(unit=name) for name, table in units.items()])
    reference = whole[whole["sampler"] == REFERENCE].set_index(["unit", "percent", "measure"])["value"]
    keys = pd.MultiIndex.from_frame(whole[["unit", "percent", "measure"]])
    with np.errstate(divide="ignore", invalid="ignore"):
        whole["ratio"] = whole["value"].to_numpy() / reference.reindex(keys).to_numpy()
    groups = whole.groupby(KEYS, sort=False)
    out = groups[["n_S_percent"]].mean()
    for name in ("value", "ratio"):
        spread = groups[name].agg(["mean", "std", "min", "max"])
        prefix = "" if name == "value" else "ratio_"
        out[[name, f"{prefix}sd", f"{prefix}lowest", f"{prefix}highest"]] = spread
    out["n"] = groups["value"].size()
    sticks = [key for key in ("null_model", "empty_patch", "fresh_dots", "turned") if key in whole]
    out[sticks] = groups[sticks].mean()
    return out.reset_index()


def factors_over_proteins(units):
    """How many times fewer dots each sampler needs than the uniform one and than the paper's.

    Parameters
    ----------
    units : dict
        See `by_protein`.

    Returns
    -------
    DataFrame: use, measure, than, sampler, percent (of `than`), factor (geometric mean over the proteins), lowest,
    highest, n, and bound: 'more than ' or 'less than ' where, of a protein, an n_S lies beyond those that were
    measured, so that its factor is but a bound; 'about ' where both happen.
    """
    rows = []
    for measure in Z_MEASURES:
        for table in units.values():
            need, ends = dots_needed(table, measure), measured_ranges(table, measure)
            for row in need[need["sampler"].isin([REFERENCE, "paper"])].to_dict("records"):
                for name in need["sampler"].unique():
                    keys = (row["use"], measure, row["sampler"], name, row["percent"])
                    rows += [(*keys, *factor_with_bound(row, name, ends))] if name != row["sampler"] else []
    keys = ["use", "measure", "than", "sampler", "percent"]
    groups = pd.DataFrame(rows, columns=[*keys, "factor", "bound"]).groupby(keys, sort=False)
    out = groups["factor"].agg(
        factor=lambda x: np.exp(np.mean(np.log(x))), lowest="min", highest="max", n="size"
    )
    bounds = groups["bound"].agg(lambda x: set(x) - {""})
    out["bound"] = [("about " if len(b) > 1 else "".join(b)) for b in bounds]
    return out.reset_index()
