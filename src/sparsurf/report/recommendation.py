"""Which combination to take for a mean roughness and a requested n_S, or why the evidence does not say.

The paper's last promise (Conclusions): with the best combination known for each kind of surface, the user finds it
from the mean roughness and the required number of points. A choice by mean roughness is made only if the surfaces of
the run support it in every way that `reasons` asks for; else the best combination regardless of roughness is named.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.old_names import refuse_old_names
from sparsurf.patches.readings import TEXT
from sparsurf.report.numbers import interval, number, span
from sparsurf.sampling.combination import PARAMETERS, Combination, split
from sparsurf.study.relation import EQUAL, mean_interval, one_each, relation
from sparsurf.study.summary import NEAREST

TITLES = {
    "as_coded": "As coded (islands removed among the kept dots)",
    "as_written": "As written (islands removed on the full surface)",
    "recovered": "Recovered (the kept dots made a dense surface again)",
}
SAID = {  # whole sentences; d is that of a uniform subset of the same size minus that of the sampling
    "nothing": "  No combination keeps about {percent} % of the dots. They keep {low} to {high} %.",
    "worse": "  A uniform subset is better than each surface's own best combination: d = {d}.",
    "same": "  Even each surface's own best combination does not beat a uniform subset: d = {d}.",
    "uniform": "  Take a uniform subset.",
    "farthest": "  Take a farthest-point subset: `minimal: {{sampler: farthest, n_S_percent: {percent}}}` in the config.",
    "near": "  Take {text}: it is best on the {near} surfaces nearest in mean roughness. Expect d = {d}.",
    "supported": "  Mean roughness helps to choose: d grows by {gain} (p = {p}).",
    "on average": "  Of the paper's combinations, {text} is best on average: {share} % of the dots, d = {d}.",
    "nearest": "  Of the paper's combinations, {text} is best on the nearest surface.",
    "may be best": "  It may be the best on {held} of {n} surfaces.",
    "chosen": "  Chosen on the other surfaces, a surface gets d = {d}.",
    "against": "  Mean roughness does not help to choose:",
    "few": "{proteins} proteins have an answer here, and a relation needs {fewest}.",
    "outside": "{roughness} lies outside of what was measured, {seen}.",
    "shared": "{shared} may be the best on all {n} surfaces.",
    "unrelated": "The best parameters do not follow it (p = {p}).",
    "far": "Surfaces of similar roughness choose no better than the most different ones: d changes by {gain}.",
    "all": "Surfaces of similar roughness choose no better than all together: d changes by {over_all}.",
}
EVIDENCE = Path(__file__).with_name("evidence")  # of the study over many proteins, docs/proteins.md
FEWEST = 10  # proteins: with 5 a real dependence is found in 1 to 3 %, with 10 in 9 to 59 %, with 20 in 48 to 98 % of runs
SIGNIFICANT = 0.05
ABOUT = 1.05  # a requested n_S beyond the ends of the grid by less than this factor is that of the end
SHOWN = 5  # surfaces in the table of evidence
NEEDED = {
    "summary": [
        "protein", "conformation", "mean_roughness", "reading", "range", "n_S_low_percent", "n_S_high_percent",
        "n_combinations", *PARAMETERS, "n_S_percent", "d", "d_held_out", "d_held_out_low", "d_held_out_high", "d_from_near",
        "d_from_far", "d_from_all", "local", "Z_tS", "n_best_set", "best_set",
    ],
    "relation": ["reading", "range", *PARAMETERS, "n_S_percent", "d", "d_sd", "n_surfaces"],
    "surfaces": ["protein", "spacing", "mean_roughness", "R_patch", "D_link"],
}  # fmt: skip


def read_run(folder):
    """Tables `summary`, `relation` and `surfaces` of a run, a dict of DataFrames.

    Raises
    ------
    InputError : a table is missing, unreadable or empty, or lacks a column
    """
    out = {}
    for name, columns in NEEDED.items():
        path = folder / f"{name}.csv"
        if not path.is_file() and path.with_name(f"{name}.csv.gz").is_file():
            path = path.with_name(f"{name}.csv.gz")
        try:
            out[name] = pd.read_csv(path)
        except (OSError, ValueError) as error:
            reason = str(error).splitlines()[0]
            raise InputError(
                f"{path} cannot be read ({reason}): run the study first, or give --results."
            ) from None
        refuse_old_names(out[name], path)
        missing = [column for column in columns if column not in out[name]]
        if missing or out[name].empty:
            lacking = f"the column {missing[0]}" if missing else "rows"
            raise InputError(f"{path} lacks {lacking}: run the study again.")
    return out


def rows_for(summary, reading, percent):
    """Rows of one reading, one per surface, whose range holds an n_S of about `percent` % of the dots."""
    rows = summary[(summary["reading"] == reading) & (summary["n_combinations"] > 0)]
    of_surface = summary[summary["reading"] == reading].groupby(["protein", "conformation"])
    low = of_surface["n_S_low_percent"].transform("min")
    high = of_surface["n_S_high_percent"].transform("max")
    near = np.clip(percent, low, high)[rows.index]  # no combination keeps quite all dots, nor quite as few
    inside = (rows["n_S_low_percent"] <= near) & (near <= rows["n_S_high_percent"])
    inside &= (near / ABOUT <= percent) & (percent <= near * ABOUT)
    return rows[inside].drop_duplicates(["protein", "conformation"])


def recommend(run, roughness, percent, rng):
    """Answer for every reading, as text.

    Parameters
    ----------
    run : dict
        See `read_run`.
    roughness : float
        Mean R_i of the surface.
    percent : float
        Requested n_S in % of the dots.
    rng : numpy.random.Generator

    Returns
    -------
    str
    """
    return "\n".join(
        line
        for reading in run["summary"]["reading"].unique()
        for line in (f"\n{TITLES[reading]}", *of_reading(run, reading, roughness, percent, rng))
    )


def of_reading(run, reading, roughness, percent, rng):
    """The answer under one reading, line by line."""
    rows = rows_for(run["summary"], reading, percent)
    if rows.empty:
        own = run["summary"][run["summary"]["reading"] == reading]
        ends = own["n_S_low_percent"].min(), own["n_S_high_percent"].max()
        return [
            SAID["nothing"].format(percent=f"{percent:g}", low=number(ends[0], 1), high=number(ends[1], 1))
        ]
    rows = rows.iloc[np.argsort((rows["mean_roughness"] - roughness).abs(), kind="stable")]
    pooled = run["relation"][run["relation"]["reading"] == reading].set_index("range")
    found = relation(rows, rng)
    beaten = uniform_instead(rows, reading, percent)
    chosen = choice(rows, found, pooled.loc[rows["range"].mode()[0]], roughness)
    return [*beaten, *chosen, *evidence(rows)]


def uniform_instead(rows, reading, percent):
    """What to take where even the best combinations do not beat a uniform subset of the same size; or nothing."""
    d, low, high = against_uniform(rows)
    if low > 0:
        return []
    said = [SAID["worse" if high < 0 else "same"].format(d=interval(d, low, high))]
    return [*said, SAID["farthest" if reading == TEXT else "uniform"].format(percent=f"{percent:g}")]


def against_uniform(rows):
    """Mean d held out of each surface's own winner, and its 95 % interval: over proteins, of which it takes 3."""
    counted = one_each(rows)
    d, low, high = mean_interval(counted["d_held_out"].to_numpy())
    if np.isnan(low):  # too few proteins: the scatter over test dots and draws of these surfaces
        half = np.sqrt((((rows["d_held_out_high"] - rows["d_held_out_low"]) / 2) ** 2).sum()) / len(rows)
        low, high = d - half, d + half
    return d, low, high


def reasons(rows, found, roughness):
    """Why the evidence does not support a choice by mean roughness, keys of `SAID`; none where it does."""
    n, low, high = found["n_proteins"], rows["mean_roughness"].min(), rows["mean_roughness"].max()
    if n < FEWEST:
        yield "few"
    if not low - EQUAL <= roughness <= high + EQUAL:
        yield "outside"
    if found["n_shared"] == len(rows) > 1:
        yield "shared"
    if n >= FEWEST and not found["p"] < SIGNIFICANT:
        yield "unrelated"
    if n >= FEWEST and not found["gain_low"] > 0:
        yield "far"
    if n >= FEWEST and not found["over_all_low"] > 0:
        yield "all"


def choice(rows, found, pooled, roughness):
    """The combination to take, line by line."""
    against = list(reasons(rows, found, roughness))
    text = rows["local"].iloc[0]
    known = {
        "n": len(rows),
        "proteins": found["n_proteins"],
        "fewest": FEWEST,
        "roughness": number(roughness, 3),
        "seen": span(rows["mean_roughness"], lambda x: number(x, 3)),
        "shared": found.get("shared", ""),
        "p": "unknown" if np.isnan(found["p"]) else f"{found['p']:.2g}",
        "gain": interval(found["gain"], found["gain_low"], found["gain_high"]),
        "over_all": interval(found["over_all"], found["over_all_low"], found["over_all_high"]),
    }
    if not against:
        known |= {"text": text, "d": spread(rows["d_from_near"]), "near": NEAREST}
        return [SAID[key].format(**known) for key in ("near", "supported")]
    if np.isnan(pooled["d"]):  # no combination lies in the range on average: that of the nearest surface
        said = [SAID["nearest"].format(text=text)]
    else:
        text = str(Combination.of(pooled))
        share = number(pooled["n_S_percent"], 0)
        d = number(pooled["d"]) + (f" ± {number(pooled['d_sd'])}" if np.isfinite(pooled["d_sd"]) else "")
        said = [SAID["on average"].format(text=text, share=share, d=d)]
    held = sum(text in split(field) for field in rows["best_set"])
    said += [SAID["may be best"].format(held=held, **known)]
    if rows["d_from_all"].notna().any():
        said += [SAID["chosen"].format(d=spread(rows["d_from_all"]))]
    return [*said, SAID["against"], *(f"  - {SAID[key].format(**known)}" for key in against)]


def evidence(rows):
    """The surfaces nearest in mean roughness, with their own best combinations."""
    yield f"  {'surface':<24}{'roughness':>9}  {'best':<20}d (95 %)"
    for _, row in rows.head(SHOWN).iterrows():
        d = interval(row["d_held_out"], row["d_held_out_low"], row["d_held_out_high"])
        name = f"{row['protein']}/{row['conformation']}"
        yield f"  {name:<24}{number(row['mean_roughness'], 3):>9}  {Combination.of(row)!s:<20}{d}"


def spread(values):
    """Mean of the values that are known, and their standard deviation where there are several."""
    values = values.dropna()
    return number(values.mean()) + (f" ± {number(values.std(ddof=1))}" if len(values) > 1 else "")
