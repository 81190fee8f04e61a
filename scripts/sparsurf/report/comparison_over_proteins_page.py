"""The page on samplers compared over several proteins."""

import pandas as pd

from sparsurf.report.comparison_answer import answer
from sparsurf.report.comparison_page import ABOUT, TWO_USES, matrix_markdown
from sparsurf.study.dots_needed import RANKING


def summary_markdown(table, fewer, rankings, of, n_conformations):
    """The table over proteins as a page.

    Parameters
    ----------
    table, fewer : DataFrame
        See `comparison_over_proteins.over_proteins` and `needed_over_proteins`.
    rankings : dict
        Name of the protein -> `dots_needed.ranking`.
    of : str
        'proteins', 'conformations' or 'conformation': what the spread is between.
    n_conformations : int
    """
    n = len(rankings)
    among = f"{n} {of}" + (f" ({n_conformations} conformations)" if n_conformations > n else "")
    note = (
        f"Cells: mean over {among}, in brackets lowest .. highest. > and <: a bound, where the n_S that was sought lies "
        "beyond those measured.\n"
    )
    spread = fewer[fewer["use"] == "surface"].rename(columns={"lowest": "low", "highest": "high"})
    begin = answer(table, fewer=spread)
    told = any(" .. " in line for line in begin if line.startswith("- "))
    parts = [
        f"# Samplers compared over {n} {of}\n",
        *begin,
        *([f"In brackets: lowest .. highest of the {n} {of}.\n"] if told else []),
        "## How it was measured\n",
        TWO_USES,
        note,
    ]
    holds = pd.DataFrame(rankings)
    parts += [] if holds.empty else ["## Ranking\n", _rankings_markdown(holds)]
    needed = "## Dots needed for the same Z, times fewer than `uniform` and `paper` need\n"
    parts += [needed] if len(fewer) else []
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
            if measure in ("Z surface", "Z centres") and own["ratio"].notna().any():
                parts += [
                    "The same, relative to uniform:\n",
                    matrix_markdown(_spread(own, "ratio_", "ratio")),
                ]
    return "\n".join(parts)


def _spread(rows, prefix, value):
    """Matrix of texts: mean (lowest .. highest); without brackets where all are at one bound."""
    sign = {"": "", "more than ": "> ", "less than ": "< ", "about ": "~ "}
    columns = rows.assign(bound=rows.get("bound", ""))
    columns = columns[["bound", value, f"{prefix}lowest", f"{prefix}highest"]].itertuples(index=False)
    text = [
        f"{sign[bound]}{a:.2f}" + ("" if bound and b == c else f" ({b:.2f} .. {c:.2f})")
        for bound, a, b, c in columns
    ]
    matrix = rows.assign(text=text).pivot(index="sampler", columns="percent", values="text")
    return matrix.reindex(index=rows["sampler"].unique(), columns=rows["percent"].unique())


def _rankings_markdown(holds):
    lines = [f"Z {' < '.join(RANKING)} under `surface` holds:\n"]
    for percent, row in holds.iterrows():
        missing = [str(name) for name in row.index[~row.astype(bool)]]
        lines.append(
            f"- at {percent:g} %: {int(row.sum())} of {len(row)}"
            + (f", not {', '.join(missing)}" if missing else "")
        )
    return "\n".join(lines) + "\n"
