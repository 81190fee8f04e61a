"""The comparison of samplers over several proteins: means and the spread between them."""

import numpy as np
import pandas as pd

from sparsurf.comparison_tables import OF_ERROR, RANKING, REFERENCE, factor_of, needed
from sparsurf.comparison_text import ABOUT, TWO_USES, matrix_markdown

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


def summary(units):
    """Means over proteins and the spread between them.

    Parameters
    ----------
    units : dict
        See `by_protein`.

    Returns
    -------
    DataFrame, one row per sampler, wished n_S and measure: n_S_percent, value, sd, lowest, highest over the
    proteins; the same of the ratio to the uniform subset of the same protein (NaN where it did not take part);
    n (of proteins, or of conformations of the only one); null_model and empty_patch, means.
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
    out[["null_model", "empty_patch"]] = groups[["null_model", "empty_patch"]].mean()
    return out.reset_index()


def needed_summary(units):
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
            need, ends = needed(table, measure), table["percent"].agg(["min", "max"])
            for row in need[need["sampler"].isin([REFERENCE, "paper"])].to_dict("records"):
                for name in need["sampler"].unique():
                    keys = (row["use"], measure, row["sampler"], name, row["percent"])
                    rows += [(*keys, *factor_of(row, name, *ends))] if name != row["sampler"] else []
    keys = ["use", "measure", "than", "sampler", "percent"]
    groups = pd.DataFrame(rows, columns=[*keys, "factor", "bound"]).groupby(keys, sort=False)
    out = groups["factor"].agg(
        factor=lambda x: np.exp(np.mean(np.log(x))), lowest="min", highest="max", n="size"
    )
    bounds = groups["bound"].agg(lambda x: set(x) - {""})
    out["bound"] = [("about " if len(b) > 1 else "".join(b)) for b in bounds]
    return out.reset_index()


def summary_markdown(table, fewer, rankings, of, n_conformations):
    """Twin of the table over proteins for people.

    Parameters
    ----------
    table, fewer : DataFrame
        See `summary` and `needed_summary`.
    rankings : dict
        Name of the protein -> `comparison_tables.ranking`.
    of : str
        'proteins' or 'conformations': what the spread is between.
    n_conformations : int
    """
    n = len(rankings)
    among = f"{n} {of}" + (f" ({n_conformations} conformations)" if n_conformations > n else "")
    note = (
        f"Cells: mean over {among}, in brackets lowest .. highest. > and <: a bound, where the n_S that was sought lies "
        "beyond those measured.\n"
    )
    parts = [
        f"# Samplers compared over {n} {of}\n",
        TWO_USES,
        note,
        "## Ranking\n",
        _rankings_markdown(rankings),
    ]
    parts += ["## Dots needed for the same Z, times fewer than `uniform` and `paper` need\n"]
    for (use, than), rows in fewer.groupby(["use", "than"], sort=False):
        parts += [f"As {use}, than {than}:\n", matrix_markdown(_spread(rows, "", "factor"))]
    titles = {
        "surface": "The kept dots as the surface",
        "centres": "The kept dots as centres of patches",
        "dots": "The nearest kept dot",
    }
    for use, title in titles.items():
        parts.append(f"## {title}\n")
        rows = table[table["use"] == use]
        for measure in [m for m in rows["measure"].unique() if m in ABOUT and m != "seconds"]:
            own = rows[rows["measure"] == measure]
            parts += [f"{ABOUT[measure]}:\n", matrix_markdown(_spread(own, "", "value"))]
            if measure in ("Z surface", "Z centres"):
                parts += [
                    "The same, relative to uniform:\n",
                    matrix_markdown(_spread(own, "ratio_", "ratio")),
                ]
    return "\n".join(parts)


def _spread(rows, prefix, value):
    """Matrix of texts: mean (lowest .. highest)."""
    sign = {"": "", "more than ": "> ", "less than ": "< ", "about ": "~ "}
    columns = rows.assign(bound=rows.get("bound", ""))
    columns = columns[["bound", value, f"{prefix}lowest", f"{prefix}highest"]].itertuples(index=False)
    text = [f"{sign[bound]}{a:.2f} ({b:.2f} .. {c:.2f})" for bound, a, b, c in columns]
    matrix = rows.assign(text=text).pivot(index="sampler", columns="percent", values="text")
    return matrix.reindex(index=rows["sampler"].unique(), columns=rows["percent"].unique())


def _rankings_markdown(rankings):
    holds = pd.DataFrame(rankings)
    if holds.empty:
        return f"{', '.join(RANKING)} did not all take part.\n"
    lines = [f"Z {' < '.join(RANKING)} under `surface` holds:\n"]
    for percent, row in holds.iterrows():
        missing = [str(name) for name in row.index[~row.astype(bool)]]
        lines.append(
            f"- at {percent:g} %: {int(row.sum())} of {len(row)}"
            + (f", not {', '.join(missing)}" if missing else "")
        )
    return "\n".join(lines) + "\n"
