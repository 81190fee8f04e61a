"""The first page of a run: what was studied, the answer in three sentences, where to look."""

import pandas as pd

from sparsurf.patches.readings import TEXT
from sparsurf.recovery.readings import READINGS, RECOVERED, readings_in
from sparsurf.report.pages import bounded, held_out, markdown
from sparsurf.study.enough import NULL_MODEL

FRESH = "fresh dots"
YARDSTICKS = {
    NULL_MODEL: "what the mean of all patches in place of every patch costs",
    FRESH: "what other dots of the same surface cost",
    "turned": "what turning the molecule and laying its dots anew costs",
}
SAMPLERS = {
    "uniform": "with a uniform draw",
    "paper": "with whichever combination of the paper's sampling needs the fewest",
}
AT = 10  # % of the dots, at which samplers are compared
# What bounds a factor bounds its inverse the other way
OTHER_WAY = {"more than ": "less than ", "less than ": "more than "}
# A factor of 1.0
AS_MANY = {
    "": "as many dots",
    "more than ": "no more dots",
    "less than ": "no fewer dots",
    "about ": "about as many dots",
}
AGAINST = {"uniform": "a uniform draw", "paper": "the paper's sampling"}  # whom others are set against
SHOWN = 20  # conformations in the table, pairs with links
OF_PAIR = {
    "pair.md": "what was found",
    "book.png": "opened like a book",
    "view_1.html": "partner 1 to turn",
    "view_2.html": "partner 2 to turn",
    "thinning.png": "fewer centres",
}


def front_page(run, surfaces, enough, reached, handed_out, fewer, links, without=(), draws=None):
    """The page as Markdown.

    Parameters
    ----------
    run : str
    surfaces : DataFrame
        See `summary.surfaces_table`.
    enough : DataFrame
        See `enough.enough`, with protein and conformation.
    reached : DataFrame
        enough.csv of all conformations, see `minimal_by_floor.enough_dots`.
    handed_out : DataFrame
        protein, conformation and dots, how many dots minimal.csv holds.
    fewer : DataFrame or None
        See `comparison_over_proteins.needed_over_proteins`.
    links : list of (heading, list of (words, path from the folder of the run))
    without : list of (protein or pairs/<name>, what went wrong)
        What could not be finished of the config.
    draws : int, optional
        Of each combination; several without.
    """
    compared = any(path.endswith("compare.md") for _, pages in links for _, path in pages)
    back = f"{recovered_sentence(reached, surfaces, handed_out)} {sampler_sentence(fewer, compared)}"
    answer = [best_sentence(surfaces), enough_sentence(enough), back]
    parts = [
        f"# Results of the run {run}\n",
        *([unfinished(without)] if without else []),
        studied(surfaces),
        "## The answer\n",
        "\n".join(f"{k}. {sentence}" for k, sentence in enumerate(answer, 1)) + "\n",
        f"{WORDS} d held out: {held_out(draws)}.\n",
        where_to_look(links),
        "## The surfaces\n",
        _table(surfaces),
    ]
    return "\n".join(parts)


def where_to_look(links):
    """The list of links, see `front_page`."""
    lines = [
        f"- {heading}: " + ", ".join(f"[{words}]({path})" for words, path in pages)
        for heading, pages in links
    ]
    return "\n".join(["## Where to look\n", *lines, ""])


def links_to_pairs(pages):
    """Headings with what there is of each pair (the first ones of many), from paths pairs/<pair>/<file>."""
    of_pairs = (path.split("/")[1:] for path in pages if path.startswith("pairs/"))
    pairs = dict.fromkeys(place[0] for place in of_pairs if len(place) > 1)
    found = []
    for pair in list(pairs)[:SHOWN]:
        own = [(words, f"pairs/{pair}/{file}") for file, words in OF_PAIR.items()]
        found.append((pair, [(words, path) for words, path in own if path in pages]))
    return [(pair, links) for pair, links in found if links]


WORDS = (
    "n_S: number of kept dots. Z: mean distance of the descriptors of patches from those of the whole surface, 0 is best. "
    "d: Z of as many uniform dots minus Z of the sampling; above 0 the sampling is better. R: roughness, 1 is flat, 0 is "
    "rough."
)


def studied(surfaces):
    """What was studied, one sentence."""
    proteins = surfaces["protein"].unique()
    what = f"{_count(len(surfaces), 'surface')} of {_count(len(proteins), 'protein')}"
    if len(proteins) <= 3:
        what += f" ({', '.join(proteins)})"
    return (
        f"Studied: {what}, {_span(surfaces['N'], '{:,.0f}')} dots each, mean roughness "
        f"{_span(surfaces['mean_roughness'], '{:z.2f}')}.\n"
    )


def unfinished(without):
    """What is not in the page, and why, one line for each protein or pair."""
    pairs = sum(name.startswith("pairs/") for name, _ in without)
    counts = {"protein": len(without) - pairs, "pair": pairs}
    what = " and ".join(_count(n, word) for word, n in counts.items() if n)
    what += " could not be finished; what follows is of what was made."
    return "\n".join([f"**{what}**\n", *(f"- {name}: {reason}" for name, reason in without), ""])


def best_sentence(surfaces):
    """The best combination under each reading, with what d is."""
    found = []
    for reading in readings_in(surfaces, "best_"):
        often = surfaces[f"best_{reading}"].value_counts()
        own, who = surfaces[surfaces[f"best_{reading}"] == often.index[0]], f"{often.index[0]} is best"
        if often.iloc[0] == 1 < len(surfaces):
            own = surfaces.iloc[[surfaces[f"d_held_out_{reading}"].fillna(float("-inf")).argmax()]]
            row = own.iloc[0]
            place, best = f"{row['protein']}/{row['conformation']}", row[f"best_{reading}"]
            who = f"no two surfaces have the same best; the highest d has {best} on {place}"
        elif len(surfaces) > 1:
            who += f" on {often.iloc[0]} of {len(surfaces)} surfaces"
        begin = f"with {READINGS[reading].words} {who}: it keeps "
        if (own[f"n_S_percent_{reading}"] == 100).all():
            found.append(f"{begin}every dot, as a uniform draw of as many does, so that d is 0")
            continue
        ends = "95 %:" if len(own) == 1 else "95 % intervals within"
        found.append(
            f"{begin}{_span(own[f'n_S_percent_{reading}'], '{:.1f}')} % of the dots with d = "
            f"{_span(own[f'd_held_out_{reading}'], '{:z.2f}')} (held out; {ends} "
            f"{own[f'd_held_out_low_{reading}'].min():z.2f} to {own[f'd_held_out_high_{reading}'].max():z.2f}; as selected "
            f"{_span(own[f'd_{reading}'], '{:z.2f}')})"
        )
    return f"Of the paper's sampling at the largest α, {'; '.join(found)}."


def enough_sentence(enough):
    """How many dots are enough, by each yardstick; the median over the surfaces."""
    found = []
    for name, rows in enough.groupby("yardstick", sort=False):
        words = [f"{_from(own)} {SAMPLERS[sampler]}" for sampler, own in rows.groupby("sampler", sort=False)]
        z = _span(rows["Z"], "{:z.2f}")
        comes = "falls below" if name == NULL_MODEL else "comes within a tenth of"
        found.append(f"Z {comes} {z}, {YARDSTICKS.get(name, name)}, {' and '.join(words)}")
    reading = READINGS[enough["islands"].iloc[0]].words
    return f"How many dots are enough, {reading}: {'; '.join(found)}."


def _from(rows):
    """From which n_S on, over the surfaces."""
    known = rows["n_S_percent"].dropna()
    if len(known) < len(rows):
        where = f" on {len(rows) - len(known)} of {len(rows)} surfaces" if len(rows) > 1 else ""
        return f"at no n_S of the grid{where}"
    low, high = f"{known.min():.0f}", f"{known.max():.0f}"
    spread = f" ({low} to {high} %)" if low != high else ""
    already = ", the smallest n_S of the grid," if rows["smallest"].all() else ""
    return f"from {known.median():.0f} %{spread} of the dots{already} on"


def recovered_sentence(reached, surfaces, handed_out):
    """From which share of the dots the surface comes back, and what is handed out."""
    own = reached[reached["floor"] == FRESH].set_index("islands")
    share = 100 * handed_out["dots"].to_numpy() / surfaces["N"].to_numpy()
    back, as_they_are = own.loc[[RECOVERED]], own.loc[[TEXT]]
    return (
        f"From {_span(back['n_S_percent'].round(1), '{:.3g}')} % of the dots on (by the steps of enough.csv), taken by the "
        f"sampler {back['sampler'].iloc[0]}, "
        f"the surface is recovered to within a tenth of {YARDSTICKS[FRESH]} (Z {_span(back['Z'], '{:z.2f}')} beside "
        f"{_span(back['Z_floor'], '{:z.2f}')}; the dots as they are need "
        f"{_span(as_they_are['n_S_percent'], '{:.3g}')} %). As the config's `minimal` asks, "
        f"`minimal.csv` hands out {_span(pd.Series(share), '{:.1f}')} % of the dots."
    )


def sampler_sentence(fewer, compared=False):
    """What other samplers need, where they were compared: on all surfaces, or by pages of some of them alone."""
    if fewer is None:
        only = "The samplers were compared on single surfaces, see `samplers compared` below."
        return only if compared else "The samplers were not compared in this run (`make compare` does)."
    than = next((name for name in AGAINST if name in set(fewer["than"])), None)
    if than is None:
        return "How the samplers compare: `compare.md`; none of them is uniform or the paper's, against which dots are counted."
    rows = fewer[(fewer["measure"] == "Z surface") & (fewer["than"] == than)]
    rows = rows[(rows["percent"] - AT).abs() == (rows["percent"] - AT).abs().min()]
    rows = rows.sort_values("factor", ascending=False)
    best = rows.iloc[0]
    alike = [row["sampler"] for _, row in rows.iterrows() if _times(row) == _times(best)]
    names = [name for name in alike if name != "paper"] or alike
    paper = rows[(rows["sampler"] == "paper") & (names != ["paper"])]
    also = f", the paper's sampling {_times(paper.iloc[0])}" if len(paper) else ""
    return (
        f"For the Z of {AGAINST[than]} of {best['percent']:g} % of the dots, {' and '.join(names)} "
        f"need{'s' if len(names) == 1 else ''} {_times(best)}{also}."
    )


def _times(row):
    """A factor in words; below 1 it is more dots."""
    value, sign, words = row["factor"], row["bound"], "fewer"
    if value < 1:
        value, sign, words = 1 / value, OTHER_WAY.get(sign, sign), "more"
    if "1.0" in (f"{value:.1f}", bounded(value, sign)):
        return AS_MANY[row["bound"]]
    return f"{sign}{bounded(value, sign)} times {words} dots"


def _table(surfaces):
    """The surfaces, the first ones where there are many."""
    short = surfaces[["protein", "conformation", "N", "mean_roughness"]].copy()
    for reading in readings_in(surfaces, "best_"):
        short[f"best, {reading}"] = surfaces[f"best_{reading}"]
        short[f"d, {reading}"] = surfaces[f"d_held_out_{reading}"]
    note = f"\nThe first {SHOWN} of {len(surfaces)}; all in surfaces.csv.\n" if len(surfaces) > SHOWN else ""
    return markdown(short.head(SHOWN)) + note


def _count(n, word):
    return f"{n} {word}" if n == 1 else f"{n} {word}s"


def _span(values, form):
    """The value, or the smallest and the largest."""
    low, high = form.format(values.min()), form.format(values.max())
    return low if low == high else f"{low} to {high}"
