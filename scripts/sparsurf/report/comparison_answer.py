"""What a page on samplers begins with: its answer in five lines and one table."""

import numpy as np
import pandas as pd

from sparsurf.patches.readings import SCALE
from sparsurf.report.pages import bounded, markdown
from sparsurf.sampling.samplers import called
from sparsurf.study.dots_needed import REFERENCE, values_of
from sparsurf.study.without_the_surface import DOTTED

RECOVERED = "Z recovered"  # as `comparison` calls it
AT = 10.0  # n_S in % that the sentences speak of, or the nearest that was measured


def spoken(sampler):
    """Name of a sampler in a text."""
    return called(sampler).text


def answer(table, pairs=None, fewer=None, alone=None):
    """Five lines at most, then Z of every sampler: of its dots as they are, and of the surface recovered from them."""
    z, at, best = best_of(table)
    lines = [
        f"At {at:g} % of the dots {spoken(best)} describes the surface best: Z = {z.loc[best, at]:.2f}"
        f"{_alike(z[at], pairs, at)}."
    ]
    lines += _recovered(table, at)
    if pairs is not None and len(pairs):
        lines += _against(pairs, at)
    if fewer is not None and len(fewer):
        lines += _times(fewer, at)
    if alone is not None and len(alone):
        lines += _alone(alone, at)
    rows = [f"- {line}" for line in lines[:5]]
    parts = [*rows, "\nZ, patches cut on the full surface, by n_S:\n", _by_n_s(z)]
    if RECOVERED in set(table["measure"]):
        parts += [
            "Z of the surface recovered from the kept dots alone:\n",
            _by_n_s(values_of(table, RECOVERED)),
        ]
    return parts


def best_of(table):
    """Z under `surface` of every sampler, the n_S in % that the sentences speak of, and the sampler that is best there."""
    z = values_of(table, "Z surface")
    at = float(z.columns[np.argmin(np.abs(z.columns - AT))])
    return z, at, z[at].idxmin()


def _by_n_s(z):
    """A row per sampler, a column per n_S."""
    short = z.map("{:.2f}".format).rename(columns=lambda p: f"{p:g} %").reset_index()
    short["sampler"] = short["sampler"].map(spoken)
    return markdown(short)


def _alike(z, pairs, at):
    """Who shares the place of the best: by the paired 95 % interval with it; without one, by Z as it is printed."""
    best = z.idxmin()
    if pairs is None or not len(pairs):
        words, names = "has the same Z", z.index[z.map("{:.2f}".format) == f"{z.min():.2f}"].drop(best)
    else:
        own = pairs[(pairs["measure"] == "Z surface") & (pairs["percent"] == at)]
        own = own[(own["low"] <= 0) & (own["high"] >= 0)]
        names = [*own.loc[own["than"] == best, "sampler"], *own.loc[own["sampler"] == best, "than"]]
        words, names = "cannot be told from it", dict.fromkeys(names)
    named = " and ".join(map(spoken, names))
    words = words.replace("has", "have") if len(names) > 1 else words
    return f"; {named} {words}" if named else ""


def _recovered(table, at):
    """Which dots give the surface back best, beside what other dots of the same surface cost."""
    if RECOVERED not in set(table["measure"]):
        return
    z = values_of(table, RECOVERED)[at]
    floor = table["fresh_dots"].mean() if "fresh_dots" in table else np.nan
    beside = f"; other dots of the same surface, all kept, cost {floor:.2f}" if np.isfinite(floor) else ""
    uniform = f", {z[REFERENCE]:.2f} from a uniform draw" if REFERENCE in z.index else ""
    best = f"{z.min():.2f} from those of {spoken(z.idxmin())}"
    yield f"The surface recovered from the kept dots alone: Z = {best}{uniform}{beside}."


def _against(pairs, at):
    """Who is better or worse than a uniform draw for certain."""
    own = pairs[(pairs["measure"] == "Z surface") & (pairs["than"] == REFERENCE) & (pairs["percent"] == at)]
    better, worse = own[own["high"] < 0], own[own["low"] > 0]
    for words, rows in (("better", better), ("worse", worse)):
        if len(rows):
            cases = [
                f"{spoken(r.sampler)} {r.difference:+.2f} ({r.low:+.2f} .. {r.high:+.2f})"
                for r in rows.itertuples()
            ]
            yield f"For certain {words} than a uniform draw, by (paired 95 % interval): {', '.join(cases)}."


def _times(fewer, at):
    rows = fewer[
        (fewer["measure"] == "Z surface") & (fewer["percent"] == at) & (fewer["sampler"] == "farthest")
    ]
    cases = [
        f"{row.bound}{bounded(row.factor, row.bound)}{_limits(row)} times fewer than {spoken(row.than)}"
        for row in rows.itertuples()
    ]
    if cases:
        yield f"For the Z they reach there, farthest needs {' and '.join(cases)}."


def _limits(row):
    """Limits of a factor in brackets; of a bound without that at the bound itself, and none where they are alike or not there."""
    low, high = f"{row.low:.1f}", f"{row.high:.1f}"
    if row.bound and low == high:  # no scatter
        return ""
    if row.bound == "more than " and row.high <= row.factor:
        return f" ({low} or more)"
    if row.bound == "less than " and row.low >= row.factor:
        return f" ({high} or less)"
    return f" ({low} .. {high})"


def _alone(alone, at):
    """Farthest-point dots against a surface dotted at low density; nothing of the full surface known."""
    own = alone[(alone["percent"] == at) & (alone["scale"] == SCALE)]
    cases = [
        f"{spoken(r.sampler)} {r.Z:.2f} ({r.low:.2f} .. {r.high:.2f})"
        for r in own.sort_values("Z").itertuples()
    ]
    if cases:
        yield f"With nothing known of the full surface (`scaled`), Z is {', '.join(cases)}."


def alone_markdown(alone):
    """Z of subsets that stand alone, then its dependence on the linking distance."""
    own = alone[alone["scale"] == SCALE]
    text = [f"{r.Z:.2f} ({r.low:.2f} .. {r.high:.2f}) at {r.n_S_percent:.1f} %" for r in own.itertuples()]
    table = own.assign(text=text).pivot(index="sampler", columns="percent", values="text")
    table = table.rename(columns=lambda p: f"{p:g} %").reset_index()
    scales = alone.pivot_table(index=["sampler", "percent"], columns="scale", values="Z").reset_index()
    scales = scales.rename(columns=lambda c: c if isinstance(c, str) else f"{c:g}")
    scales["percent"] = scales["percent"].map("{:g}".format)
    note = f"`{DOTTED}`: our own surface laid with so many dots in the first place, the molecule turned at random.\n\n"
    spread = pd.DataFrame(alone.groupby(["sampler", "percent"])["Z"].agg(np.ptp))["Z"].max()
    return (
        f"Dots linked within {SCALE:g} times their mean spacing, 95 % intervals in brackets; {note}{markdown(table)}\n"
        f"Z by that factor, a choice of ours ({SCALE:g} has no other source); it changes Z by {spread:.2f} at most:\n\n"
        f"{markdown(scales)}"
    )
