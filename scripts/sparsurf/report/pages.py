"""Tables as Markdown pages: the best combinations of a surface, with what every Z is measured against."""

import math

import pandas as pd

from sparsurf.patches.readings import PUBLISHED, TEXT
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling.combination import Combination, texts_of


def markdown(table, decimals=2):
    """A DataFrame as a Markdown table."""

    def cell(value):
        if isinstance(value, float):
            return "" if math.isnan(value) else f"{value:z.{decimals}f}"
        return str(value)

    lines = [list(table.columns), ["---"] * len(table.columns)]
    lines += [[cell(v) for v in row] for row in table.astype(object).itertuples(index=False)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def bounded(factor, bound):
    """A factor with one decimal; a bound, 'more than ' or 'less than ', is rounded to where it says less."""
    cut = {"more than ": math.floor, "less than ": math.ceil}.get(bound)
    return f"{cut(round(10 * factor, 6)) / 10 if cut else factor:.1f}"  # 0.3 / 0.1 is no 29.999999 tenths


EXPLAINED = {
    PUBLISHED: "islands are removed among the kept dots (the authors' code; the published table)",
    TEXT: "the patch is cut once on the full surface and all its kept dots count (the paper's text)",
    RECOVERED: "the kept dots are made a dense surface again, and its patches are cut from that",
}


def readings_explained(names):
    """What the readings of a page are, in a line."""
    return " ".join(f"`{name}`: {words}." for name, words in EXPLAINED.items() if name in names) + "\n"


def yardsticks_markdown(sticks):
    """The yardsticks as a sentence."""
    floors = "".join(f"; {words} {z:.2f}" for words, z in sticks.get("floors", {}).items())
    if floors:
        floors = f"\nWith all dots kept, Z of {floors[2:]}: below the first, a subset is no better than other dots are.\n"
    return (
        f"Yardsticks of Z: an empty patch costs {sticks['empty_patch']:.2f} (mean |z_tot|), every patch given the "
        f"mean descriptor {sticks['null_model']:.2f} (null model), two different patches differ by "
        f"{sticks['two_patches']:.2f}.\n{floors}"
    )


def held_out(draws=None):
    """What d held out is, by the number of draws (None: several); one draw cannot be dealt (`statistics.held_out`)."""
    if draws == 1:
        return (
            "winners are chosen on four fifths of the test dots and measured on the rest, in turn, but on the one draw that "
            "also chose: held out over test dots only, too high (on the embedded trajectory by 0.2 on average under `kept`, by "
            "0.02 under `surface`), with an interval that tells the scatter of test dots only"
        )
    return (
        f"winners are chosen on {'half' if draws == 2 else 'two thirds'} of the draws and four fifths of the test dots and "
        "measured on the rest, in turn; several may take part, so that it is the d of choosing so, not of the one combination "
        "shown"
    )


def ranges_markdown(ranges, sticks, draws=None):
    """ranges.csv as a page: where the sampling beats a uniform draw, the ranges, what the words mean.

    Parameters
    ----------
    ranges : DataFrame
        See `tables.ranges_table`.
    sticks : dict
        See `tables.all_yardsticks`.
    draws : int, optional
        Of each combination; several without.
    """
    parts = ["# Best combination per range of n_S\n"]
    parts += [
        f"- {_ranges_sentence(reading, rows)}" for reading, rows in ranges.groupby("islands", sort=False)
    ]
    parts.append("")
    for reading, rows in ranges.groupby("islands", sort=False):
        short = pd.DataFrame(
            {
                "n_S range / %": [
                    f"{a:.2f} - {b:.2f}"
                    for a, b in zip(rows["n_S_low_percent"], rows["n_S_high_percent"], strict=True)
                ],
                "combinations": rows["n_combinations"].to_numpy(),
                "(alpha, beta, gamma, delta)": [
                    text if n else "" for text, n in zip(texts_of(rows), rows["n_combinations"], strict=True)
                ],
                "n_S / %": rows["n_S_percent"].to_numpy(),
                "d held out": rows["d_held_out"].to_numpy(),
                "95 %": [interval(row) for _, row in rows.iterrows()],
                "d as selected": rows["d"].to_numpy(),
                "Z_tS": rows["Z_tS"].to_numpy(),
                "dots in the median patch": rows["fragment"].to_numpy(),
                "may be the best": rows["n_best_set"].fillna(0).astype(int).to_numpy(),
            }
        )
        parts += [f"## islands: {reading}\n", markdown(short)]
    parts.append(
        f"d held out: {held_out(draws)}; its interval is by Student's t. "
        "d as selected is higher by the selection bias. May be the best: size of the 95 % confidence set of the best, "
        "the combinations among which the truly best of the range lies (docs/coverage.md); ranges.csv lists them. The "
        "ranges share their test dots, so that their errors go together.\n"
    )
    explained = readings_explained(set(ranges["islands"]))
    return "\n".join([*parts, explained, yardsticks_markdown(sticks)])


def _ranges_sentence(reading, rows):
    """In how many ranges d is above and below zero for certain, and where it is largest."""
    rows = rows.dropna(subset="d_held_out")
    if rows.empty:
        return f"`{reading}`: too few test dots and draws to tell."
    top = rows.loc[rows["d_held_out"].idxmax()]
    ranges = f"{len(rows)} range{'s' if len(rows) > 1 else ''}"
    return (
        f"`{reading}`: of {ranges} the best combination beats a uniform draw of as many dots for certain in "
        f"{(rows['d_held_out_low'] > 0).sum()} and loses to it for certain in {(rows['d_held_out_high'] < 0).sum()}; d is "
        f"largest, {top['d_held_out']:.2f} ({interval(top)}), with {Combination.of(top)} at {top['n_S_percent']:.1f} % of the "
        f"dots."
    )


def interval(row):
    """95 % interval of d held out as text."""
    low, high = row["d_held_out_low"], row["d_held_out_high"]
    return "" if pd.isna(low) else f"{low:.2f} .. {high:.2f}"


def best_markdown(result):
    """best.json as a page."""
    parts = ["# Best parameters\n"]
    for reading in [key for key in EXPLAINED if key in result]:
        parts.append(f"## islands: {reading}\n")
        for title, row in (
            ("Unrestricted, largest alpha", result[reading]["unrestricted"]),
            (f"n_S at most {result['max_n_S_percent']:g} %", result[reading]["under_max_n_S"]),
        ):
            parts.append(f"- {title}: {row['answer'] if 'answer' in row else _best_sentence(row)}")
        parts.append("")
    explained = [f"d held out: {held_out(result.get('draws'))}.\n", readings_explained(result)]
    return "\n".join([*parts, *explained, yardsticks_markdown(result["yardsticks"])])


def may_be_best(row):
    """How many combinations the confidence set of the best holds, in words."""
    n = int(row["n_best_set"])
    if row["n_combinations"] == 1:
        return "no other combination was there to compare with"
    if n == 1:
        return "it is the best with 95 % confidence"
    return f"the 95 % confidence set of the best holds {n} combinations, this one among them"


def _best_sentence(row):
    return (
        f"(alpha, beta, gamma, delta) = {Combination.of(row)}, n_S = {row['n_S']:.0f} ({row['n_S_percent']:.2f} %), "
        f"d held out = {row['d_held_out']:.2f} ({interval(row)}; as selected {row['d']:.2f}), Z_tS = {row['Z_tS']:.2f}; "
        f"{may_be_best(row)}."
    )
