"""Which combination to take for a mean roughness and a wished n_S, or why the evidence does not say.

The paper's last promise (Conclusions): with the best combination known for each kind of surface, the user finds it
from the mean roughness and the required number of points. A choice by mean roughness is made only if the surfaces of
the run support it in every way that `reasons` asks for; else the best combination regardless of roughness is named.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.patches.readings import TEXT
from sparsurf.recovery.readings import READINGS
from sparsurf.sampling.combination import PARAMETERS, Combination, split
from sparsurf.study.relation import EQUAL, mean_interval, one_each, relation
from sparsurf.study.summary import NEAREST

EVIDENCE = Path(__file__).with_name("evidence")  # of the study over many proteins, docs/proteins.md
FEWEST = 10  # proteins: with 5 a real dependence is found in 1 to 3 %, with 10 in 9 to 59 %, with 20 in 48 to 98 % of runs
SIGNIFICANT = 0.05
ABOUT = 1.05  # a wished n_S beyond the ends of the grid by less than this factor is that of the end
SHOWN = 5  # surfaces in the table of evidence
NEEDED = {
    "summary": [
        "protein", "conformation", "mean_roughness", "islands", "range", "n_S_low_percent", "n_S_high_percent",
        "n_combinations", *PARAMETERS, "n_S_percent", "d", "d_held_out", "d_held_out_low", "d_held_out_high", "d_from_near",
        "d_from_far", "d_from_all", "local", "Z_tS", "n_best_set", "best_set",
    ],
    "relation": ["islands", "range", *PARAMETERS, "n_S_percent", "d", "d_sd", "n_surfaces"],
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
        missing = [column for column in columns if column not in out[name]]
        if missing or out[name].empty:
            lacking = f"the column {missing[0]}" if missing else "rows"
            raise InputError(f"{path} lacks {lacking}: run the study again.")
    return out


def rows_for(summary, reading, percent):
    """Rows of one reading, one per surface, whose range holds an n_S of about `percent` % of the dots."""
    rows = summary[(summary["islands"] == reading) & (summary["n_combinations"] > 0)]
    of_surface = summary[summary["islands"] == reading].groupby(["protein", "conformation"])
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
        Wished n_S in % of the dots.
    rng : numpy.random.Generator

    Returns
    -------
    str
    """
    parts = []
    for reading in run["summary"]["islands"].unique():
        parts.append(f"\n{READINGS[reading].words} (`{reading}`)")
        rows = rows_for(run["summary"], reading, percent)
        if rows.empty:
            own = run["summary"][run["summary"]["islands"] == reading]
            low, high = own["n_S_low_percent"].min(), own["n_S_high_percent"].max()
            parts.append(
                f"  No answer: no combination of the run keeps about {percent:g} % of the dots "
                f"(they keep {low:.1f} % to {high:.1f} %)."
            )
            continue
        rows = rows.iloc[np.argsort((rows["mean_roughness"] - roughness).abs(), kind="stable")]
        found = relation(rows, rng)
        pooled = run["relation"][run["relation"]["islands"] == reading].set_index("range")
        pooled = pooled.loc[rows["range"].mode()[0]]
        parts += [f"  {line}" for line in uniform_first(rows, reading, percent)]
        parts += [f"  {line}" for line in choice(rows, found, pooled, roughness)]
        parts += [f"  {line}" for line in evidence(rows, found)]
    return "\n".join(parts)


def uniform_first(rows, reading, percent):
    """A sentence where even the best combinations do not beat a uniform subset of the same size; or none."""
    d, low, high = against_uniform(rows)
    if low > 0:
        return []
    words = "is worse than" if high < 0 else "cannot be told from"
    number = f"d held out {signed(d)}, 95 % {signed(low)} .. {signed(high)}"
    better = ""
    if reading == TEXT:
        better = (
            f", or better a farthest-point one, `minimal: {{sampler: farthest, n_S_percent: {percent:g}}}` in "
            "config.yaml, which comes closer to the surface than uniform dots at the same n_S"
        )
    return [
        f"Not the paper's sampling: even each surface's own best combination {words} a uniform subset of as many "
        f"dots ({number}). Take a uniform subset{better}."
    ]


def against_uniform(rows):
    """Mean d held out of each surface's own winner, and its 95 % interval: over proteins, of which it takes 3."""
    counted = one_each(rows)
    d, low, high = mean_interval(counted["d_held_out"].to_numpy())
    if np.isnan(low):  # too few proteins: the scatter over test dots and draws of these surfaces
        half = np.sqrt((((rows["d_held_out_high"] - rows["d_held_out_low"]) / 2) ** 2).sum()) / len(rows)
        low, high = d - half, d + half
    return d, low, high


def reasons(rows, found, roughness):
    """Why the evidence does not support a choice by mean roughness; empty where it does."""
    n, low, high = found["n_proteins"], rows["mean_roughness"].min(), rows["mean_roughness"].max()
    if n < FEWEST:
        proteins = "1 protein has" if n == 1 else f"{n} proteins have"
        yield f"only {proteins} an answer in this range of n_S, and a relation needs at least {FEWEST} proteins"
    if not low - EQUAL <= roughness <= high + EQUAL:
        yield f"a mean roughness of {roughness:.3f} lies outside of what was seen, {low:.3f} .. {high:.3f}"
    if found["n_shared"] == len(rows) > 1:
        yield f"one combination, {found['shared']}, may be the best on each of the {len(rows)} surfaces"
    if n >= FEWEST and not found["p"] < SIGNIFICANT:
        rho = ", ".join(text for p in PARAMETERS if (text := rho_text(found, p)))
        p = f"; p = {found['p']:.2g} over {n} proteins" if rho else f" on all {n} proteins"
        related = f"({rho or 'they are the same'}{p})"
        yield f"the best parameters are no more correlated in rank with mean roughness than by chance {related}"
    if n >= FEWEST and not found["gain_low"] > 0:
        yield (
            f"a combination chosen on the surfaces nearest in mean roughness gives no higher d than one chosen on the "
            f"farthest (difference {signed(found['gain'])}, 95 % {signed(found['gain_low'])} .. "
            f"{signed(found['gain_high'])})"
        )
    if n >= FEWEST and not found["over_all_low"] > 0:
        yield (
            "a combination chosen on the surfaces nearest in mean roughness gives no higher d than one chosen on all "
            f"(difference {signed(found['over_all'])}, 95 % {signed(found['over_all_low'])} .. "
            f"{signed(found['over_all_high'])})"
        )


def rho_text(found, parameter):
    """Rank correlation of one parameter with its interval; empty where it does not vary."""
    rho, low, high = (found[f"rho_{parameter}{end}"] for end in ("", "_low", "_high"))
    if np.isnan(rho):
        return ""
    return f"{parameter} {signed(rho)}" + ("" if np.isnan(low) else f" [{signed(low)}, {signed(high)}]")


def choice(rows, found, pooled, roughness):
    """The combination to take, as sentences."""
    against = list(reasons(rows, found, roughness))
    if not against:
        nearest = f"{rows['protein'].iloc[0]}/{rows['conformation'].iloc[0]}"
        return [
            f"Take {rows['local'].iloc[0]}: it has the highest mean d on {nearest} and the {NEAREST - 1} surfaces that "
            f"are nearest to that in mean roughness.",
            f"To be expected: d = {mean_and_spread(rows['d_from_near'])} over the surfaces of the run, each with what "
            f"was chosen on its neighbours in mean roughness.",
            "The choice by mean roughness is supported: " + supported(found) + ".",
        ]
    sentences = ["The evidence does not support a choice by mean roughness:"]
    sentences += [f"- {reason}." for reason in against]
    sentences.append("Regardless of mean roughness, " + on_average(rows, pooled))
    if rows["d_from_all"].notna().any():
        sentences.append(
            f"Chosen in this way on the others, a surface gets d = {mean_and_spread(rows['d_from_all'])}."
        )
    return sentences


def on_average(rows, pooled):
    """The combination with the highest mean d of all surfaces; where none is in range on average, the nearest's."""
    text, number = rows["local"].iloc[0], ""
    if not np.isnan(pooled["d"]):
        text = str(Combination.of(pooled))
        of = "" if pooled["n_surfaces"] == len(rows) else f" of {pooled['n_surfaces']:.0f} surfaces"
        number = f" n_S = {pooled['n_S_percent']:.1f} %, d = {signed(pooled['d'])}{plus_minus(pooled['d_sd'])} on average{of};"
    held = sum(text in split(field) for field in rows["best_set"])
    surfaces = "the only surface" if len(rows) == held == 1 else f"{held} of {len(rows)} surfaces"
    return f"{text} is the paper's best in this range:{number} it lies in the 95 % confidence set of the best of {surfaces}."


def supported(found):
    """The evidence for a choice by mean roughness."""
    rho = ", ".join(text for p in PARAMETERS if (text := rho_text(found, p)))
    gain = f"{signed(found['gain'])} (95 % {signed(found['gain_low'])} .. {signed(found['gain_high'])})"
    return f"rank correlation {rho}, p = {found['p']:.2g}; near surfaces choose better than far ones by d = {gain}"


def evidence(rows, found):
    """The nearest surfaces with their winners, and how often winners change at equal roughness."""
    out = [
        f"{'surface':<24}{'R mean':>8}  {'winner':<20}{'n_S %':>6}{'d held out [95 %]':>22}{'as chosen':>10}{'best set':>9}"
    ]
    for _, row in rows.head(SHOWN).iterrows():
        d = f"{signed(row['d_held_out'])} [{signed(row['d_held_out_low'])}, {signed(row['d_held_out_high'])}]"
        name = f"{row['protein']}/{row['conformation']}"
        out.append(
            f"{name:<24}{row['mean_roughness']:>8.3f}  {Combination.of(row)!s:<20}{row['n_S_percent']:>6.1f}{d:>22}"
            f"{signed(row['d']):>10}{row['n_best_set']:>9.0f}"
        )
    if len(rows) > SHOWN:
        out.append(f"... and {len(rows) - SHOWN} more.")
    if found["n_pairs"]:
        out.append(
            f"Of {found['n_pairs']} pairs of surfaces whose mean roughness differs by less than {EQUAL:g}, "
            f"{found['n_changes']} have different winners, {found['n_told_apart']} winners that can be told apart."
        )
    return out


def signed(x):
    """Two decimals with a sign that is a minus."""
    return f"{x:+.2f}".replace("-", "−") if np.isfinite(x) else "unknown"


def plus_minus(sd):
    """A standard deviation over surfaces; nothing where it is unknown."""
    return f" ± {sd:.2f} (sd over surfaces)" if np.isfinite(sd) else ""


def mean_and_spread(values):
    """Mean of the values that are known, and their spread."""
    values = values.dropna()
    return signed(values.mean()) + plus_minus(values.std(ddof=1) if len(values) > 1 else np.nan)
