"""The page on samplers compared at equal n_S, on one surface or over several."""

import numpy as np

from sparsurf.patches.readings import WRITTEN_READING
from sparsurf.report.numbers import interval, number, share
from sparsurf.sampling.samplers import lookup_sampler
from sparsurf.study.comparison.measuring import DOTTED

TEMPLATE = "compare.html.j2"
AT = 10.0  # n_S in % that the answer speaks of, or the nearest that was measured
REFERENCE = "uniform"
LEAST = 1.05  # times fewer dots that a bound must promise to be told
AS_WRITTEN, RECOVERED = "Z as_written", "Z recovered"
MEASURES = (AS_WRITTEN, RECOVERED, "Z as_coded", "Z centres")  # that get a table each
BOUNDS = {"more than ": "> ", "less than ": "< ", "about ": "≈ "}


def comparison_page(name, table, fewer, pairs=None, alone=None, centres=None, of=None, **facts):
    """What the template asks for.

    Parameters
    ----------
    name : str
        Of the surface, or of the run.
    table : DataFrame
        compare.csv, of a surface or over several (there with `lowest` and `highest` in place of `low` and `high`).
    fewer : DataFrame
        How many times fewer dots a sampler needs than another for the same Z.
    pairs, alone : DataFrame, optional
        Differences between samplers with paired intervals; Z where nothing of the full surface is known.
    centres : DataFrame, optional
        centres.csv: d of the best combinations beside that of the always-kept centres.
    of : str, optional
        What the limits of a page over several surfaces are between.
    facts
        What else the template tells: n_dots, area, n_tests, draws, choices.
    """
    table, fewer = (_named(each) for each in (table, fewer))
    z, at, best = best_of(table)
    return {
        "name": name,
        "of": of,
        "at": f"{at:g}",
        "best": lookup_sampler(best).words,
        "best_Z": number(z.loc[best, at]),
        "alike": [lookup_sampler(each).words for each in alike(pairs, best, at)] if pairs is not None else [],
        "recovered": recovered(table, at),
        "fewer": fewer_rows(fewer, at),
        "against": against(fewer, at),
        "percents": [f"{p:g}" for p in z.columns],
        "tables": {
            measure: rows_of(table, measure) for measure in MEASURES if measure in set(table["measure"])
        },
        "alone": alone_rows(_named(alone), at) if alone is not None else [],
        "centres": centre_rows(centres) if centres is not None else [],
        "null_model": number(table["null_model"].mean()),
        "facts": facts,
    }


def best_of(table):
    """Z as written of every sampler, the n_S in % that the answer speaks of, and the sampler that is best there."""
    z = matrix(table, AS_WRITTEN)
    at = float(z.columns[np.argmin(np.abs(z.columns - AT))])
    return z, at, z[at].idxmin()


def _named(table):
    """Limits under one name, whether they are of an interval or of several surfaces."""
    return table.rename(columns={"lowest": "low", "highest": "high"})


def matrix(table, measure, value="value"):
    """Samplers down, requested n_S across."""
    own = table[table["measure"] == measure]
    found = own.pivot(index="sampler", columns="percent", values=value)
    return found.reindex(index=own["sampler"].unique(), columns=own["percent"].unique())


def rows_of(table, measure):
    """The same as text, the best of the middle column first."""
    values = matrix(table, measure)
    values = values.sort_values(values.columns[np.argmin(np.abs(values.columns - AT))])
    return [
        [lookup_sampler(name).words, *map(number, row)]
        for name, row in zip(values.index, values.to_numpy(), strict=True)
    ]


def alike(pairs, best, at):
    """Samplers whose Z does not differ significantly from that of the best, by the paired interval."""
    own = pairs[(pairs["measure"] == AS_WRITTEN) & (pairs["percent"] == at)]
    own = own[(own["low"] <= 0) & (own["high"] >= 0)]
    return dict.fromkeys([*own.loc[own["than"] == best, "sampler"], *own.loc[own["sampler"] == best, "than"]])


def recovered(table, at):
    """The dots from which the surface comes back best; None where that was not measured."""
    if RECOVERED not in set(table["measure"]):
        return None
    z = matrix(table, RECOVERED)[at]
    floor = table["fresh_dots"].mean() if "fresh_dots" in table else np.nan
    return {"sampler": lookup_sampler(z.idxmin()).words, "Z": number(z.min()), "floor": number(floor)}


def bounded(row):
    """A factor with its limits; a bound with its sign."""
    text = BOUNDS.get(row["bound"], "") + number(row["factor"], 1)
    return text if row["bound"] else interval(row["factor"], row["low"], row["high"], 1)


def fewer_rows(fewer, at):
    """One sampler a row: how many times fewer dots it needs than a uniform subset and than the paper's sampling."""
    own = fewer[(fewer["measure"] == AS_WRITTEN) & (fewer["percent"] == at) & (fewer["use"] == "surface")]
    by = {(row["sampler"], row["than"]): bounded(row) for _, row in own.iterrows()}
    names = dict.fromkeys(own.sort_values("factor", ascending=False)["sampler"])
    return [
        [lookup_sampler(name).words, by.get((name, REFERENCE), ""), by.get((name, "paper"), "")] for name in names
    ]


def against(fewer, at):
    """How many times fewer dots the farthest-point sampler needs than a uniform subset; None where not measured."""
    own = fewer[(fewer["measure"] == AS_WRITTEN) & (fewer["percent"] == at) & (fewer["use"] == "surface")]
    own = own[(own["sampler"] == "farthest") & (own["than"] == REFERENCE)]
    own = own[~own["bound"].astype(str).str.startswith("more") | (own["factor"] >= LEAST)]
    return None if own.empty else bounded(own.iloc[0])


def centre_rows(centres):
    """By range of n_S, as written where that was evaluated: n_S in % and d of the best combination, and d of the centres."""
    own = centres.dropna(subset="d")
    own = own[
        own["reading"]
        == (WRITTEN_READING if WRITTEN_READING in set(own["reading"]) else own["reading"].iloc[0])
    ]
    return [
        [share(row["n_S_percent"])]
        + [interval(*(row[f"{key}{end}"] for end in ("", "_low", "_high"))) for key in ("d", "d_centres")]
        for _, row in own.iterrows()
    ]


def alone_rows(alone, at):
    """Z of dots that stand alone, nothing known of the full surface, at one n_S and the middle linking distance."""
    scales = sorted(alone["scale"].unique())
    own = alone[(alone["percent"] == at) & (alone["scale"] == scales[len(scales) // 2])].sort_values("Z")
    words = {name: lookup_sampler(name).words for name in own["sampler"]} | {DOTTED: "sparsely laid dots"}
    return [
        [words[row["sampler"]], share(row["n_S_percent"]), interval(row["Z"], row["low"], row["high"])]
        for _, row in own.iterrows()
    ]
