"""The page on surfaces recovered from few dots, from the tables that `scripts/measure_recovery.py` writes."""

import pandas as pd

from sparsurf.report.pages import markdown
from sparsurf.study import over_proteins

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

The table follows from `python scripts/measure_recovery.py <folder of structures> docs/tables`: the protein of each structure,
its first model, 1000 test dots; means over proteins with 95 % intervals by Student's t.
"""


TABLES = ("", "_floors", "_means", "_pairs", "_opponents", "_opponents_means", "_a1")
# What this recovery was to reach on A1: Z and distance (Å), below those of an algebraic point-set surface (Guennebaud & Gross,
# SIGGRAPH 2007) through as many dots; bytes of memory for a recovered dot, CPU seconds for a million.
GOALS = {"Z": {2.5: 0.75, 5.0: 0.60, 10.0: 0.53}, "distance": {5.0: 0.08}}
MOST_BYTES, MOST_SECONDS = 400, 2.0
MOST_OVER = 1.08  # Z at 10 % of the dots over the fresh-dots floor, on every structure
BESIDE = """Bytes: a dot with its normal takes 24 (six float32). A mesh takes 12 for a vertex and 6 for a triangle (three indices
of two bytes); with two triangles for every vertex that is 24 again: equal numbers are equal bytes.

- Settled dots: the farthest ones, each with its normal moved by least squares to where the surface recovered from them
  comes nearest to all dots (`sparsurf minimal --settle`, `minimal: {settle: true}` in a study).
- Sparsely laid dots: those of a turned molecule at a low density. The surface is recovered from these three.
- Decimated mesh: by quadric error (fast-simplification), from a mesh whose vertices lie on the analytic surface; dots are
  laid on its triangles as densely as recovered ones, with normals interpolated between its corners. Or the surface is
  recovered from its corners and their normals alone.

The structures of at most 3000 atoms take part.
"""


def read(folder):
    """The `TABLES` of a folder, as `page` takes them."""
    return [pd.read_csv(folder / f"recover{key}.csv") for key in TABLES]


def page(table, floors, means, pairs, opponents, opponents_means, a1):
    """The page as Markdown.

    Parameters
    ----------
    table, floors, means, pairs, opponents, opponents_means, a1 : DataFrames
        `TABLES`, of `study.recovery` and `study.opponents`.
    """
    beside = ~pairs["first"].isin(table["sampler"])
    parts = [
        "# A surface from a tenth of its dots\n",
        answer(means),
        "![](recover.png)\n",
        HOW,
        errors(table, opponents),
    ]
    parts += ["## The paper's A1, and the goals\n", goals(a1)]
    parts += [
        "## Beside other ways to keep as many bytes\n",
        paying(pairs[beside], atoms(opponents, a1)),
        BESIDE,
    ]
    parts += [_opponents(opponents_means)]
    for sampler, part in means.groupby("sampler", sort=False):
        parts += [f"## {sampler} dots, mean of {part['n'].max()} structures\n", _matrix(part)]
    parts += [
        "## Does it pay to put dots where the surface is rough, or where it errs?\n",
        paying(pairs[~beside]),
    ]
    over = over_floor(table, floors, opponents)
    parts += ["## Each structure\n", everywhere(over, floors), _each(table, floors, over)]
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
            f"- From {percent:g} % of the dots the surface comes back {gap['mean']:.3f} Å from the true one. Its Z is "
            f"{z['mean']:.2f}, {over['mean']:.2f} ({over['low']:.2f} to {over['high']:.2f}) times that of other dots "
            f"of the same surface; the kept dots as they are have Z = {before['mean']:.2f}."
        )
    return "\n".join(lines) + "\n"


def errors(table, opponents):
    """What distances and angles hold beside the error of recovery."""
    own = table[table["sampler"] == "farthest"].assign(kept=100 * table["n_S"] / table["dots"])
    kept = own.groupby("percent")["kept"].mean()
    exact = opponents[opponents["sampler"] == "atoms"]["angle"]
    shares, at = (
        ", ".join(f"{x:{form}}" for x in values) for values, form in ((kept, ".0f"), (kept.index, "g"))
    )
    return (
        f"Distances are means over all dots that come back, the kept ones among them, which lie on the surface: {shares} % at "
        f"{at} % of the dots; by as much the others lie farther off. Angles are to the normal of the nearest of 60 dots per "
        f"Å^2, which for dots of the true surface gives {exact.mean():.1f}° ({exact.min():.1f} to {exact.max():.1f}): small "
        "angles are told too large.\n"
    )


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


def goals(a1):
    """What came out on A1, beside what was to be bettered."""
    rows, n = a1[a1["sampler"] == "farthest"].set_index("percent"), int(a1["N"].iloc[0])
    lines = []
    for measure, wished in GOALS.items():
        found = [(p, rows.loc[p, measure], goal) for p, goal in wished.items()]
        words = ", ".join(f"{value:.3f} at {p:g} % (goal {goal:g})" for p, value, goal in found)
        unit = " Å" if measure == "distance" else ""
        lines.append(f"- {measure}{unit}: {words}: {_met(all(value <= goal for _, value, goal in found))}.")
    for sampler in ("adaptive", "settled dots"):
        own = a1[a1["sampler"] == sampler].set_index("percent").loc[[2.5, 5.0, 10.0]]
        values = (", ".join(f"{value:.3f}" for value in own[key]) for key in ("Z", "distance"))
        lines.append("- {}, at 2.5, 5 and 10 %: Z {}, distance {} Å.".format(sampler, *values))
    per_dot, seconds = a1["bytes_per_dot"].iloc[0], a1["a_million_s"].iloc[0]
    lines.append(
        f"- Memory: {per_dot:.0f} bytes for a recovered dot (goal {MOST_BYTES}): {_met(per_dot < MOST_BYTES)}; a million dots "
        f"from a tenth of those of copies side by side take {seconds:.1f} CPU seconds (goal {MOST_SECONDS:g}), the kernels being "
        f"compiled: {_met(seconds <= MOST_SECONDS)}."
    )
    shown = rows.loc[[2.5, 5.0, 10.0], ["n_S", "Z_kept", "Z", "Z_over_floor", "distance", "angle"]].T
    shown = shown.map(lambda value: f"{value:.0f}" if value >= 100 else f"{value:.3g}").rename(
        index={"n_S": "dots kept"} | WORDS, columns=lambda p: f"{p:g} %"
    )
    head = f"{n} dots of the exact surface, farthest-point subsets, 1000 test dots. The goals were set below what an "
    head += (
        "algebraic point-set surface through as many dots gives (Z 0.81, 0.64 and 0.54; 0.086 Å at 5 %).\n"
    )
    return head + "\n" + "\n".join(lines) + "\n\n" + markdown(shown.reset_index(names="A1"))


def _met(yes):
    return "met" if yes else "not met"


def atoms(opponents, a1):
    """What the atoms themselves take and give."""
    own, one = opponents[opponents["sampler"] == "atoms"], a1[a1["sampler"] == "atoms"].iloc[0]
    share = 16 / 24 * own["percent"]
    return (
        f"- The atoms themselves, places and radii, 16 bytes each, are {share.mean():.1f} % of the bytes of all dots "
        f"({share.min():.1f} to {share.max():.1f}) and give the surface back exactly (distance {own['distance'].mean():.3f} Å, "
        f"the error of measuring; Z {own['Z'].mean():.2f}, that of other dots); so do the {one['n_S']:.0f} atoms of A1 "
        f"({one['distance']:.3f} Å, Z {one['Z']:.2f}). Where the atoms may be kept, nothing of as few bytes comes near them."
    )


def _opponents(means):
    """Bytes, Z and distance of each way, n_S across."""
    cells = means[means["measure"].isin(["bytes", "Z", "distance"])].copy()
    cells["text"] = [
        f"{row.mean_:,.0f}" if row.measure == "bytes" else _interval(row.mean_, row.low, row.high)
        for row in cells.rename(columns={"mean": "mean_"}).itertuples()
    ]
    cells["what"] = cells["sampler"] + ", " + cells["measure"].replace({"distance": "distance in Å"})
    short = cells.pivot(index="what", columns="percent", values="text").reindex(cells["what"].unique())
    short = short.rename(columns=lambda p: f"{p:g} %").reset_index(
        names=f"mean of {cells['n'].max()} structures (95 %)"
    )
    return markdown(short)


def paying(pairs, *further):
    """Paired changes in %, with what follows from them, and further lines."""
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
    lines += further
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


def over_floor(table, floors, opponents, percent=10.0):
    """Z at `percent` of the dots over the fresh-dots floor: a row per structure, a column for each way to choose dots."""
    rows = over_proteins.over_floor(pd.concat([table, opponents], ignore_index=True), floors)
    own = rows[rows["percent"] == percent].pivot(index="protein", columns="sampler", values="over_floor")
    return own[["farthest", "adaptive", "settled dots"]]


def everywhere(over, floors):
    """On how many structures each column of `over_floor` stays within the goal; the most with the limits of its floor."""
    fresh, lines = _fresh(floors), []
    for sampler, values in over.items():
        known = values.dropna()
        within, most = int((known <= MOST_OVER).sum()), known.idxmax()
        low, high = (known.max() * fresh.loc[most, "Z"] / fresh.loc[most, end] for end in ("high", "low"))
        lines.append(
            f"- {sampler}: Z at 10 % is at most {MOST_OVER:g} times the fresh-dots floor on {within} of {len(known)} "
            f"structures; the most is {known.max():.3f} ({most}; {low:.2f} to {high:.2f} by the error of its floor, of "
            f"{fresh.loc[most, 'draws']} draws): {_met(within == len(known))}."
        )
    return "\n".join(lines) + "\n"


def _fresh(floors):
    """The fresh-dots floors by structure."""
    return floors[floors["floor"] == "fresh dots"].set_index("protein")


def _each(table, floors, over):
    """A row per structure: floor, recovered Z at each n_S, and that at 10 % over the floor."""
    own = table[table["sampler"] == "farthest"]
    z = own.pivot(index="protein", columns="percent", values="Z").rename(columns=lambda p: f"Z at {p:g} %")
    size = own.groupby("protein", sort=False)["N"].first()
    over = over.round(3).rename(columns=lambda sampler: f"{sampler}, 10 %, over fresh")
    floor = _fresh(floors)["Z"].rename("fresh dots")
    rows = pd.concat([size, floor, z, over], axis=1)
    return markdown(rows.reindex(size.index).reset_index(names="structure"))
