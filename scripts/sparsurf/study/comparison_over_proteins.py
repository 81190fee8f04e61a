"""The comparison of samplers over several proteins: means and the spread between them."""

import numpy as np
import pandas as pd

from sparsurf.study.dots_needed import OF_ERROR, REFERENCE, ends_of, factor_of, needed

KEYS = ["sampler", "percent", "use", "measure"]


def by_protein(tables):
    """Means over the conformations of each protein.

    Parameters
    ----------
    tables : dict
        (protein, conformation) -> table of `comparison.compare`.

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


def over_proteins(units):
    """Means over proteins and the spread between them.

    Parameters
    ----------
    units : dict
        See `by_protein`.

    Returns
    -------
    DataFrame, one row per sampler, wished n_S and measure: n_S_percent, value, sd, lowest, highest over the
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


def needed_over_proteins(units):
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
    for measure in OF_ERROR:
        for table in units.values():
            need, ends = needed(table, measure), ends_of(table, measure)
            for row in need[need["sampler"].isin([REFERENCE, "paper"])].to_dict("records"):
                for name in need["sampler"].unique():
                    keys = (row["use"], measure, row["sampler"], name, row["percent"])
                    rows += [(*keys, *factor_of(row, name, ends))] if name != row["sampler"] else []
    keys = ["use", "measure", "than", "sampler", "percent"]
    groups = pd.DataFrame(rows, columns=[*keys, "factor", "bound"]).groupby(keys, sort=False)
    out = groups["factor"].agg(
        factor=lambda x: np.exp(np.mean(np.log(x))), lowest="min", highest="max", n="size"
    )
    bounds = groups["bound"].agg(lambda x: set(x) - {""})
    out["bound"] = [("about " if len(b) > 1 else "".join(b)) for b in bounds]
    return out.reset_index()
