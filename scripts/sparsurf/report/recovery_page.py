"""The page on surfaces recovered from few dots, from the tables that `scripts/measure_recovery.py` writes."""

import pandas as pd

from sparsurf.report.pages import markdown

WORDS = {
    "Z_kept": "Z, the dots as they are",
    "Z": "Z, recovered",
    "Z_over_floor": "recovered, over the fresh-dots floor",
    "distance": "distance to the true surface, Å",
    "angle": "angle of the normals, degrees",
    "microseconds": "CPU microseconds per recovered dot",
}
HOW = """A Hermite interpolant (Wendland's function, 12 neighbours) is put through every kept dot and its normal, places on the
dots' tangent discs are moved onto it and thinned. Nothing else is known: `sparsurf recover minimal.csv -o dense.ply`.
Z is measured against the full surface; the recovered surface is described as one of its own. The fresh-dots floor is Z of
another set of dots of the same surface, all kept: below it, a subset only repeats the dots that it is measured against.

The table follows from `python scripts/measure_recovery.py <folder of structures> docs/tables`: all atoms of each structure,
its first model, 1000 test dots; means over proteins with 95 % intervals by Student's t.
"""


def page(table, floors, means, pairs):
    """The page as Markdown.

    Parameters
    ----------
    table, floors, means, pairs : DataFrames of `study.recovery`: recover.csv, recover_floors.csv, recover_means.csv,
        recover_pairs.csv
    """
    parts = ["# A surface from a tenth of its dots\n", answer(means), "![](recover.png)\n", HOW]
    for sampler, part in means.groupby("sampler", sort=False):
        parts += [f"## {sampler} dots, mean of {part['n'].max()} structures\n", _matrix(part)]
    parts += ["## Does it pay to put dots where the surface is rough, or where it errs?\n", paying(pairs)]
    parts += ["## Each structure, farthest-point dots\n", _each(table, floors)]
    return "\n".join(parts)


def answer(means):
    """What comes out at a tenth and a twentieth, in sentences."""
    rows = means[means["sampler"] == "farthest"].set_index(["percent", "measure"])
    lines = []
    for percent in (10.0, 5.0, 2.5):
        over, z, before, gap = (
            rows.loc[(percent, key)] for key in ("Z_over_floor", "Z", "Z_kept", "distance")
        )
        lines.append(
            f"From {percent:g} % of the dots the surface comes back {gap['mean']:.3f} Å from the true one; its Z is "
            f"{over['mean']:.2f} ({over['low']:.2f} to {over['high']:.2f}) times that of other dots of the same surface, "
            f"{z['mean']:.2f} instead of {before['mean']:.2f}."
        )
    return "\n".join(lines) + "\n"


def _matrix(part):
    """Measures down, n_S across."""
    cells = part.assign(
        text=[
            _interval(row.mean_, row.low, row.high)
            for row in part.rename(columns={"mean": "mean_"}).itertuples()
        ]
    )
    short = cells.pivot(index="measure", columns="percent", values="text").reindex(list(WORDS))
    short = short.rename(index=WORDS, columns=lambda p: f"{p:g} %").reset_index(names="mean (95 %)")
    return markdown(short)


def _interval(mean, low, high):
    digits = 3 if abs(mean) < 0.2 else 2
    return f"{mean:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def paying(pairs):
    """Paired changes in %, with what follows from them."""
    lines = []
    for (first, second), part in pairs.groupby(["first", "second"], sort=False):
        rows = part[part["measure"] == "Z"]
        better = [f"{p:g} %" for p in rows[rows["high"] < 0]["percent"]]
        worse = [f"{p:g} %" for p in rows[rows["low"] > 0]["percent"]]
        said = [f"lower Z at {', '.join(better)}"] * bool(better) + [
            f"higher Z at {', '.join(worse)}"
        ] * bool(worse)
        lines.append(
            f"- {first} instead of {second}: {' and '.join(said) or 'no Z that differs beyond its interval'}."
        )
    table = pairs.assign(
        change=[
            f"{row.mean_:+.1f} ({row.low:+.1f} to {row.high:+.1f})"
            for row in pairs.rename(columns={"mean": "mean_"}).itertuples()
        ],
        pair=pairs["first"] + " instead of " + pairs["second"] + ", " + pairs["measure"],
    )
    short = table.pivot(index="pair", columns="percent", values="change").reindex(table["pair"].unique())
    short = short.rename(columns=lambda p: f"{p:g} %").reset_index(
        names="change in % (95 %), protein by protein"
    )
    return "\n".join(lines) + "\n\n" + markdown(short)


def _each(table, floors):
    """A row per structure: floor, and recovered Z at each n_S."""
    own = table[table["sampler"] == "farthest"]
    z = own.pivot(index="protein", columns="percent", values="Z").rename(columns=lambda p: f"Z at {p:g} %")
    floor = floors[floors["floor"] == "fresh dots"].set_index("protein")["Z"].rename("fresh dots")
    size = own.groupby("protein", sort=False)["N"].first()
    return markdown(pd.concat([size, floor, z], axis=1).reindex(size.index).reset_index(names="structure"))
