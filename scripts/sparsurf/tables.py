"""Tables of a study: the grid, the best combination per range of n_S, the best of all."""

import math

import numpy as np
import pandas as pd

from sparsurf.evaluation import halves, mean_and_error, yardsticks

PARAMETERS = ["alpha", "beta", "gamma", "delta"]
Z95 = 1.959964  # half width of a 95 % interval in standard errors


def grid_table(grid):
    """One row per combination.

    Parameters
    ----------
    grid : evaluation.Grid

    Returns
    -------
    DataFrame: alpha, beta, gamma, delta; n_S (mean of the draws), n_S_percent, n_S_expected (closed form);
    then for each reading Z_tS, Z_tR, d with standard errors, d on two halves that share neither test dots
    nor draws, and the median number of dots in the evaluated patches of the sampling and of the uniform subset.
    """
    table = pd.DataFrame(grid.combinations, columns=PARAMETERS)
    table["n_S"] = grid.n_s.mean(axis=1)
    table["n_S_percent"] = 100 * table["n_S"] / grid.n_dots
    table["n_S_expected"] = grid.n_s_expected
    for r, reading in enumerate(grid.readings):
        values = {"Z_tS": grid.z_ts[r], "Z_tR": grid.z_tr[r], "d": difference(grid, r)}
        for name, x in values.items():
            table[f"{name}_{reading}"], table[f"{name}_se_{reading}"] = mean_and_error(x)
        table[f"d_half1_{reading}"], table[f"d_half2_{reading}"] = halves(values["d"])
        table[f"fragment_{reading}"], table[f"fragment_uniform_{reading}"] = grid.fragment[r]
    return table


def difference(grid, r):
    """d of every combination, draw and test dot, under reading number r: (K, D, T) float64."""
    return grid.z_tr[r].astype(np.float64) - grid.z_ts[r]


def range_limits(n_s_percent, n_ranges):
    """Limits of equal ranges between the smallest and the largest n_S: (n_ranges + 1,) float64."""
    return np.linspace(np.min(n_s_percent), np.max(n_s_percent), n_ranges + 1)


def ranges_table(table, grid, n_ranges=10):
    """The combination with the highest d in each range of n_S, under each reading (paper, Table I).

    Parameters
    ----------
    table : DataFrame
        See `grid_table`.
    grid : evaluation.Grid
        The raw distances of the same combinations.
    n_ranges : int

    Returns
    -------
    DataFrame, one row per reading and range: limits, number of combinations, the winner with its n_S, d and
    95 % interval, `d_held_out` (selected on one half, reported on the other), Z_tS, Z_tR, fragment, and the
    plateau: every combination whose d cannot be told from the winner's (95 %, paired by test dot and draw).
    A range that no combination falls into has NaN. Every row ends with the yardsticks.
    """
    percent = table["n_S_percent"].to_numpy()
    limits = range_limits(percent, n_ranges)
    member = np.clip(np.searchsorted(limits, percent, side="right") - 1, 0, n_ranges - 1)
    rows = []
    for r, reading in enumerate(grid.readings):
        d = difference(grid, r)
        for k in range(n_ranges):
            inside = np.flatnonzero(member == k)
            row = {"islands": reading, "n_S_low_percent": limits[k], "n_S_high_percent": limits[k + 1]}
            row["n_combinations"] = len(inside)
            rows.append(row | (_winner(table, d, reading, inside) if len(inside) else {}))
    return with_yardsticks(pd.DataFrame(rows), yardsticks(grid.z_tot))


def with_yardsticks(table, sticks):
    """A table of Z with its yardsticks in every row: columns empty_patch and null_model."""
    return table.assign(empty_patch=sticks["empty_patch"], null_model=sticks["null_model"])


def _winner(table, d, reading, inside):
    """The row of the highest d among the combinations `inside`."""
    sub = table.iloc[inside]
    best = int(np.argmax(sub[f"d_{reading}"].to_numpy()))
    row = describe_combination(sub.iloc[best], reading)
    row["d_held_out"] = held_out(sub, reading)
    plateau = inside[equal_to(d, inside, inside[best])]
    row["n_plateau"] = len(plateau)
    row["plateau"] = "; ".join(combination_text(table.iloc[k]) for k in plateau)
    return row


def describe_combination(row, reading):
    """What the tables say of one combination under one reading, a dict."""
    d, error = row[f"d_{reading}"], row[f"d_se_{reading}"]
    return {
        **{p: row[p] for p in PARAMETERS},
        "n_S": row["n_S"],
        "n_S_percent": row["n_S_percent"],
        "d": d,
        "d_low": d - Z95 * error,
        "d_high": d + Z95 * error,
        "Z_tS": row[f"Z_tS_{reading}"],
        "Z_tR": row[f"Z_tR_{reading}"],
        "fragment": row[f"fragment_{reading}"],
    }


def held_out(sub, reading):
    """d of the winner of one half on the other half, mean of both ways; free of selection bias."""
    first, second = sub[f"d_half1_{reading}"].to_numpy(), sub[f"d_half2_{reading}"].to_numpy()
    return (second[np.argmax(first)] + first[np.argmax(second)]) / 2


def equal_to(d, inside, best):
    """Mask over `inside`: combinations whose d is within 1.96 paired standard errors of that of `best`."""
    gap, error = mean_and_error(d[best] - d[inside])
    return (gap <= Z95 * error) | (inside == best)


def combination_text(row):
    """(alpha, beta, gamma, delta) as text."""
    return "(" + ", ".join(f"{row[p]:g}" for p in PARAMETERS) + ")"


def best(table, grid, max_n_s_percent):
    """The best combinations of a surface and the yardsticks beside them.

    Returns
    -------
    dict: `yardsticks` (see `evaluation.yardsticks`) and per reading `unrestricted` (highest d at the largest
    alpha; the paper fixes alpha = 1) and `under_max_n_S` (highest d with n_S at most `max_n_s_percent` % of the
    dots; `answer` says so where none is that small).
    """
    alpha = table["alpha"].max()
    few = table["n_S_percent"].to_numpy() <= max_n_s_percent
    out = {"N": grid.n_dots, "max_n_S_percent": max_n_s_percent, "yardsticks": yardsticks(grid.z_tot)}
    for r, reading in enumerate(grid.readings):
        d = difference(grid, r)
        free = _winner(table, d, reading, np.flatnonzero(table["alpha"] == alpha))
        if few.any():
            bounded = _winner(table, d, reading, np.flatnonzero(few))
        else:
            least = table["n_S_percent"].min()
            bounded = {
                "answer": f"No combination of the grid keeps {max_n_s_percent:g} % of the dots or fewer; "
                f"the smallest n_S is {least:.2f} %. Add smaller values of alpha or raise tables.max_n_S_percent."
            }
        out[reading] = {"unrestricted": free, "under_max_n_S": bounded}
    return out


def markdown(table, decimals=2):
    """A DataFrame as a Markdown table."""

    def cell(value):
        if isinstance(value, float):
            return "" if math.isnan(value) else f"{value:.{decimals}f}"
        return str(value)

    lines = [list(table.columns), ["---"] * len(table.columns)]
    lines += [[cell(v) for v in row] for row in table.astype(object).itertuples(index=False)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


READINGS_EXPLAINED = (
    "`kept`: islands are removed among the kept dots (the authors' code; the published table). "
    "`surface`: the patch is cut once on the full surface and all its kept dots count (the paper's text).\n"
)


def yardsticks_markdown(sticks):
    """The yardsticks as a sentence."""
    return (
        f"Yardsticks of Z: an empty patch costs {sticks['empty_patch']:.2f} (mean |z_tot|), every patch given the "
        f"mean descriptor {sticks['null_model']:.2f} (null model), two different patches differ by "
        f"{sticks['two_patches']:.2f}.\n"
    )


def ranges_markdown(ranges, sticks):
    """Twin of ranges.csv for people."""
    parts = ["# Best combination per range of n_S\n", READINGS_EXPLAINED, yardsticks_markdown(sticks)]
    for reading, rows in ranges.groupby("islands", sort=False):
        short = pd.DataFrame(
            {
                "n_S range / %": [
                    f"{a:.2f} - {b:.2f}"
                    for a, b in zip(rows["n_S_low_percent"], rows["n_S_high_percent"], strict=True)
                ],
                "combinations": rows["n_combinations"].to_numpy(),
                "(alpha, beta, gamma, delta)": [
                    combination_text(row) if row["n_combinations"] else "" for _, row in rows.iterrows()
                ],
                "n_S / %": rows["n_S_percent"].to_numpy(),
                "d": rows["d"].to_numpy(),
                "95 %": [interval(row) for _, row in rows.iterrows()],
                "d held out": rows["d_held_out"].to_numpy(),
                "Z_tS": rows["Z_tS"].to_numpy(),
                "dots in the median patch": rows["fragment"].to_numpy(),
                "cannot be told apart": rows["n_plateau"].fillna(0).astype(int).to_numpy(),
            }
        )
        parts += [f"## islands: {reading}\n", markdown(short)]
    parts.append(
        "d held out: the winner of one half of the test dots and draws, measured on the other half; the difference "
        "to d is selection bias. The last column counts the combinations whose d lies within 1.96 paired standard "
        "errors of the winner's (the winner included); ranges.csv lists them.\n"
    )
    return "\n".join(parts)


def interval(row):
    """95 % interval of d as text."""
    return "" if pd.isna(row["d"]) else f"{row['d_low']:.2f} .. {row['d_high']:.2f}"


def best_markdown(result):
    """Twin of best.json for people."""
    parts = ["# Best parameters\n", READINGS_EXPLAINED, yardsticks_markdown(result["yardsticks"])]
    for reading in [key for key in ("kept", "surface") if key in result]:
        parts.append(f"## islands: {reading}\n")
        for title, row in (
            ("Unrestricted, largest alpha", result[reading]["unrestricted"]),
            (f"n_S at most {result['max_n_S_percent']:g} %", result[reading]["under_max_n_S"]),
        ):
            parts.append(f"- {title}: {row['answer'] if 'answer' in row else _best_sentence(row)}")
        parts.append("")
    return "\n".join(parts)


def as_good(row):
    """How many other combinations cannot be told from the winner, in words."""
    others = int(row["n_plateau"]) - 1
    if others < 2:
        return f"{'one' if others else 'no'} other combination is as good within the error"
    return f"{others} other combinations are as good within the error"


def _best_sentence(row):
    return (
        f"(alpha, beta, gamma, delta) = {combination_text(row)}, n_S = {row['n_S']:.0f} ({row['n_S_percent']:.2f} %), "
        f"d = {row['d']:.2f} ({interval(row)}; held out {row['d_held_out']:.2f}), Z_tS = {row['Z_tS']:.2f}; "
        f"{as_good(row)}."
    )


def rows_markdown(rows):
    """The published rows beside ours, for people (see `paper.rows_table`)."""
    short = pd.DataFrame(
        {
            "n_S range / %": [
                f"{a:.2f} - {b:.2f}"
                for a, b in zip(rows["n_S_low_percent"], rows["n_S_high_percent"], strict=True)
            ],
            "combination": [combination_text(row) for _, row in rows.iterrows()],
            "n_S / %": rows["n_S_percent"],
        }
    )
    for name in ("d", "Z_tS"):
        short[f"{name} published"] = rows[f"{name}_published"]
        short[f"{name} here"] = rows[name]
        short[f"{name} bias"] = rows[f"{name}_bias"]
        limits = zip(rows[f"{name}_low"], rows[f"{name}_high"], strict=True)
        short[f"{name} 95 %"] = [f"{a:.2f} .. {b:.2f}" for a, b in limits]
        short[f"{name} surface"] = rows[f"{name}_shared_surface"]
    return (
        "## Table I, row by row\n\n"
        + markdown(short)
        + "\nhere: mean of as-published replicates (N / 200 fresh test dots, one draw, islands `kept`); bias: selection "
        "bias of the range; 95 %: where one replicate falls, longer by the bias on the side that selection pulls to; "
        "surface: shared test dots, islands `surface`.\n"
    )
