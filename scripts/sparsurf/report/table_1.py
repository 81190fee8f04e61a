"""Sentences and tables on Table I of the paper: as published, as made again, and as measured here."""

import math

import pandas as pd

from sparsurf.patches.readings import OF_GRID, PUBLISHED, TEXT
from sparsurf.report import pages
from sparsurf.sampling.combination import Combination, split, texts_of
from sparsurf.sampling.published import PUBLISHED_ROWS
from sparsurf.study.published_runs import BINNINGS, MEASURES, all_rows_at_once

UNLIKELY = 0.05


def against_runs(places, bias):
    """Whether the published values could be those of one more run, in sentences.

    Parameters
    ----------
    places, bias : DataFrame
        See `published_runs.place_of_published` and `selection_bias`.
    """
    out = []
    for binning in BINNINGS:
        own = places[places["binning"] == binning]
        for name in MEASURES:
            out.append(f"{_binned(binning)} {name}: {_test(own, name)}{_odd(own, name)}.")
    out.append(_last_range(places))
    own = bias[bias["binning"] == next(iter(BINNINGS))]["d_bias"]
    out.append(
        f"The d of a winner of such a run lies {own.mean():.2f} on average and {own.max():.2f} at most above what the same "
        "combination gives on many test dots: selection bias, which the published values share."
    )
    return out


def all_agree(places):
    """Which published values, over all rows at once, could be those of one more run: dict of bool to words."""
    out = {True: [], False: []}
    for name in MEASURES:
        for binning in BINNINGS:
            own = places[places["binning"] == binning]
            fits = bool(all_rows_at_once(own, name)["p"] >= UNLIKELY)
            out[fits].append(f"{name} ({binning} ranges)")
    return out


def _binned(binning):
    words = {
        "closed": "The largest n_S in the last range,",
        "half-open": "Half-open ranges (the largest n_S in none),",
    }
    return words[binning]


def _test(own, name):
    found = all_rows_at_once(own, name)
    verdict = "agree with" if found["p"] >= UNLIKELY else "do not agree with"
    return (
        f"the {found['n_rows']} published values together {verdict} the winners of {own['n_runs'].max()} runs made as "
        f"published (sum of squares {_sum(found['statistic'])} for {found['n_rows']} rows, {p_text(found['p'])})"
    )


def _odd(own, name):
    """Rows that lie outside of all runs, and what the others give without them."""
    outside = own[
        (own[f"{name}_published"] > own[f"{name}_highest"])
        | (own[f"{name}_published"] < own[f"{name}_lowest"])
    ]
    if outside.empty:
        return "; each lies within the range of the runs"
    cases = [
        f"row {row['range']} ({row[f'{name}_published']:.2f}; runs {row[f'{name}_lowest']:.2f} .. "
        f"{row[f'{name}_highest']:.2f})"
        for _, row in outside.iterrows()
    ]
    rest = all_rows_at_once(own, name, outside["range"])
    without = f"{rest['statistic']:.1f} for {rest['n_rows']} rows, {p_text(rest['p'])}"
    without = f"; without {'it' if len(cases) == 1 else 'them'} {without}" if rest["n_rows"] else ""
    return f"; outside of all runs: {', '.join(cases)}{without}"


def _last_range(places):
    """What the binning does to the last range."""
    last = {row["binning"]: row for _, row in places[places["range"] == places["range"].max()].iterrows()}
    closed, open_ = last["closed"], last["half-open"]
    text = Combination(*PUBLISHED_ROWS[-1])
    # of one run there is no mean
    mean = "" if math.isnan(open_["d_mean"]) else f" (mean d {open_['d_mean']:.2f})"
    if open_["n_runs"]:
        without = f"in {open_['n_won']} of {open_['n_runs']} where it does not{mean}"
    else:
        without = "where it does not, no combination of the grid lies in it"
    return (
        f"In the last range the published {text} with d = {closed['d_published']:.2f} wins in {closed['n_won']} of "
        f"{closed['n_runs']} runs where the range holds the largest n_S (winners' mean d {closed['d_mean']:.2f}), and "
        f"{without}."
    )


def _sum(statistic):
    return (
        f"{statistic:.1f}" if math.isfinite(statistic) else "without limit, since all runs agree in a range,"
    )


def p_text(p):
    """A probability, never as 0."""
    return "p < 0.0001" if p < 0.0001 else f"p = {p:.2g}"


def winners(ranges, places):
    """The winners with many shared test dots beside the published combinations, in sentences."""
    published = [str(Combination(*row)) for row in PUBLISHED_ROWS]
    kept = ranges[ranges["islands"] == PUBLISHED]
    pairs = list(zip(texts_of(kept), kept["best_set"].map(split), published, strict=False))
    same, among = sum(a == p for a, _, p in pairs), sum(p in held for _, held, p in pairs)
    own = places[places["binning"] == "half-open"]
    return [
        f"With shared test dots the winner is the published one in {same} of {len(kept)} ranges; the published one lies in "
        f"the 95 % confidence set of the best in {among}.",
        f"Of {own['n_runs'].max()} runs made as published, each row's combination wins its range in {own['n_won'].min()} to "
        f"{own['n_won'].max()}.",
    ]


def null_model(grid, rows):
    """In how many combinations a subset tells less of a patch than the mean descriptor, in sentences."""
    out = []
    for reading in OF_GRID:
        over, of_rows = (table[f"Z_tS_{reading}"] > grid.attrs["null_model"] for table in (grid, rows))
        out.append(
            f"`{reading}`: Z_tS exceeds the null model in {int(over.sum())} of {len(grid)} combinations and in "
            f"{int(of_rows.sum())} of the {len(rows)} published rows: those subsets tell less of a patch than the mean "
            "descriptor in its place."
        )
    return out


def places_markdown(places, rows):
    """Table I row by row: published, the winners of the runs, and the published combination with many test dots."""
    parts = ["## Table I, row by row\n"]
    for binning in BINNINGS:
        own = places[places["binning"] == binning]
        table = pd.DataFrame({"row": own["range"], "combination": texts_of(own)})
        table["won"] = [f"{a} of {b}" for a, b in own[["n_won", "n_runs"]].to_numpy()]
        for name in MEASURES:
            table[f"{name} published"] = own[f"{name}_published"]
            limits = own[[f"{name}_mean", f"{name}_lowest", f"{name}_highest"]].to_numpy()
            table[f"{name} of the runs"] = [
                "" if math.isnan(mean) else f"{mean:.2f} ({low:.2f} .. {high:.2f})"
                for mean, low, high in limits
            ]
            table[f"{name} below"] = own[f"{name}_n_below"].to_numpy()
        parts += [f"{_binned(binning)[:-1]}:\n", pages.markdown(table)]
    parts.append(
        "won: runs in which the published combination has the highest d of its range. of the runs: mean of the winners, in "
        "brackets the lowest and the highest. below: runs whose winner lies below the published value. Empty where no more than "
        "one run has a combination in the range.\n"
    )
    table = pd.DataFrame(
        {"row": range(1, len(rows) + 1), "combination": texts_of(rows), "n_S / %": rows["n_S_percent"]}
    )
    for reading in (PUBLISHED, TEXT):
        ends = rows[[f"{key}_{reading}" for key in ("d", "d_low", "d_high")]].to_numpy()
        table[f"d, {reading}"] = [f"{d:.2f} ({low:.2f} .. {high:.2f})" for d, low, high in ends]
        table[f"Z_tS, {reading}"] = rows[f"Z_tS_{reading}"]
    parts += [
        "The published combinations with shared test dots, 95 % intervals in brackets:\n",
        pages.markdown(table),
    ]
    return "\n".join(parts)
