"""What follows from a comparison of samplers: dots needed for the same Z, and the ranking."""

import numpy as np
import pandas as pd

REFERENCE = "uniform"  # sampler that the others are set against
RANKING = ("farthest", "uniform", "paper")  # expected order of Z, best first
# What a factor is whose n_S `dots_for` finds beyond those that were measured
BOUND = {0.0: "more than ", np.inf: "less than "}
OF_ERROR = ("Z surface", "Z centres")  # the Z of each use that `needed` speaks of


def values_of(table, measure, column="value"):
    """One measure as a matrix: samplers down, wished n_S (%) across, in the order of the table."""
    part = table[table["measure"] == measure]
    matrix = part.pivot(index="sampler", columns="percent", values=column)
    return matrix.reindex(index=part["sampler"].unique(), columns=part["percent"].unique())


def needed(table, measure="Z surface"):
    """Number of dots that each sampler needs for the Z that another one reaches.

    Parameters
    ----------
    table : DataFrame
        See `comparison.compare`.

    Returns
    -------
    DataFrame, one row per sampler and wished n_S: use, measure, sampler, percent, Z (what it reaches there), and
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
        | {name: dots_for(row["value"], *curve) for name, curve in curves.items()}
        for _, row in part.iterrows()
    ]
    return pd.DataFrame(rows)


def all_needed(table):
    """`needed` for both uses, as the surface and as centres."""
    return pd.concat([needed(table, measure) for measure in OF_ERROR], ignore_index=True)


def dots_for(z, n, values):
    """Smallest n_S that reaches z on a curve that never rises; 0 or inf beyond its ends."""
    values = np.minimum.accumulate(values).clip(1e-9)
    if z > values[0]:
        return 0.0
    if not z >= values[-1]:
        return np.inf
    k = int(np.argmax(values <= z))
    if k == 0:
        return float(n[0])
    share = np.log(values[k - 1] / max(z, 1e-9)) / np.log(values[k - 1] / values[k])
    return float(n[k - 1] * (n[k] / n[k - 1]) ** share)


def times_fewer(table, of, than, percent):
    """How many times fewer dots `of` needs for the Z that `than` reaches at a wished n_S.

    Parameters
    ----------
    table : DataFrame
        See `comparison.compare`.

    Returns
    -------
    float, and '' or, where the n_S lies beyond those that were measured, 'more than ' or 'less than '.
    """
    rows = needed(table)
    row = rows[(rows["sampler"] == than) & (rows["percent"] == percent)].iloc[0]
    return factor_of(row, of, ends_of(table))


def ends_of(table, measure="Z surface"):
    """The smallest and the largest n_S in % that were measured, (2,), of each sampler."""
    own = table[table["measure"] == measure].groupby("sampler")["n_S_percent"]
    return {name: (n_s.min(), n_s.max()) for name, n_s in own}


def factor_of(row, of, ends):
    """`times_fewer` from a row of `needed`, with what `ends_of` gives."""
    own, other = row[row["sampler"]], row[of]
    return float(own / np.clip(other, *ends[of])), BOUND.get(other, "")


def ranking(table, measure="Z surface", order=RANKING):
    """Whether Z rises in the given order at each wished n_S: Series of bool; empty where a sampler is missing."""
    matrix = values_of(table, measure)
    if not set(order) <= set(matrix.index):
        return pd.Series(dtype=bool)
    return matrix.loc[list(order)].diff().iloc[1:].gt(0).all()
