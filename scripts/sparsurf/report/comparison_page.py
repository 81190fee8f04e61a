"""Pages for people about the comparison of samplers."""

import numpy as np

from sparsurf.report import comparison_answer
from sparsurf.report.comparison_answer import spoken
from sparsurf.report.pages import bounded, markdown
from sparsurf.sampling.published import OF_PAPER
from sparsurf.study.dots_needed import RANKING, REFERENCE, needed, ranking, times_fewer, values_of

AT = 10.0  # n_S in % that the sentences speak of, or the nearest that was measured
TWO_USES = """A subset can serve in two ways, which this page keeps apart:

- as the **surface** itself: nothing but the kept dots is known, and a patch holds what was kept of it;
- as patch **centres**: patches are still cut from the full surface, only fewer of them are described.

Z is the mean distance |z_tot - z| between the descriptor of a test dot's patch on the full surface and what the
subset gives in its place. Samplers are compared at equal n_S, in % of the dots.
"""
STRIDE = (
    "`stride` takes every k-th dot in the order of the file, which goes from atom to atom: what it gives depends on that "
    "order, and a file in another order gives something else.\n"
)
INTERVALS = "± is half a 95 % interval over draws and test dots.\n"
ABOUT = {
    "Z surface": "Z, patches cut on the full surface (islands: `surface`)",
    "Z surface weighted": "The same, each kept dot counting for the dots nearest to it",
    "Z recovered": "Z of the dense surface recovered from the kept dots and their normals alone (islands: `recovered`)",
    "Z scaled": "Z, surface unknown: islands removed among the kept dots, linked by their own spacing (islands: `scaled`)",
    "Z kept": "Z, islands removed among the kept dots, linked within D_link (islands: `kept`, the published table)",
    "fragment kept": "What is left of the median patch under `kept`, % of its kept dots",
    "Z centres": "Z of the nearest kept centre",
    "position": "Distance from a dot to the nearest kept one, Å",
    "normal": "Angle between their normals, degrees",
    "seconds": "Milliseconds of one draw (index and cover being there)",
}


def facts(n_dots, area, estimated, n_tests, draws, choices):
    """What was compared and how, in sentences."""
    how = ", estimated from the spacing of the dots, as the surface comes without areas" if estimated else ""
    source = (
        "Table I of the paper"
        if choices is OF_PAPER
        else "this surface's own ranges.csv, the winners under `kept`"
    )
    return (
        f"{n_dots} dots on {area:.0f} Å^2{how} ({n_dots / area:.2f} per Å^2); {n_tests} test dots, {draws} draws of each "
        f"subset. `paper` takes beta, gamma and delta from {source}, and alpha such that it keeps the wished n_S on "
        "average; in hindsight, those of grid.csv with the lowest Z under `surface` on these test dots among the "
        "combinations that keep within 10 % of n_S at their own alpha (or the nearest), which then gets another alpha, so "
        "that it can do worse than `paper`. The others keep exactly n_S.\n"
    )


def compare_markdown(table, name, facts, pairs=None, fewer=None, alone=None):
    """compare.csv as a page.

    Parameters
    ----------
    table : DataFrame
        See `comparison.compare`.
    name : str
        Conformation.
    facts : str
        Sentences on the surface and on how it was measured.
    pairs, fewer, alone : DataFrame, optional
        See `comparison_intervals.paired`, `times_fewer_intervals` and `without_the_surface.stand_alone`.
    """
    sticks = table.dropna(subset="null_model").iloc[0]
    yardsticks = (
        f"Yardsticks of Z: every patch given the mean descriptor costs {sticks['null_model']:.2f} (null model: above "
        f"it a subset tells less of a patch than the mean over all patches does), an empty patch {sticks['empty_patch']:.2f} "
        "(mean |z_tot|)."
        + (
            f" Other dots of the same surface cost {sticks['fresh_dots']:.2f} and those of the molecule turned "
            f"{sticks['turned']:.2f}, with all dots kept."
            if "fresh_dots" in sticks
            else ""
        )
        + "\n"
    )
    parts = [
        f"# Samplers compared at equal n_S: {name}\n",
        *comparison_answer.answer(table, pairs, fewer, alone),
        "## How it was measured\n",
        facts,
        STRIDE,
        TWO_USES,
        INTERVALS,
        "## Finding by finding\n",
        *_findings(table),
    ]
    got = values_of(table, "Z surface", "n_S_percent")
    chance = got[got.sub(got.columns, axis=1).abs().gt(0.01 * got.columns).any(axis=1)]
    if len(chance):
        parts += ["\nn_S as it came out, %:\n", matrix_markdown(chance)]
    parts += ["\n## The kept dots as the surface\n", yardsticks]
    parts += _sections(
        table, ["Z surface", "Z recovered", "Z surface weighted", "Z scaled", "Z kept", "fragment kept"]
    )
    parts += ["## The kept dots as centres of patches\n", yardsticks, *_sections(table, ["Z centres"])]
    parts += ["## The nearest kept dot, without descriptors\n", *_sections(table, ["position", "normal"])]
    parts += ["## Dots needed for the same Z\n", _needed_markdown(table, "Z surface", "as the surface")]
    parts += [_needed_markdown(table, "Z centres", "as centres")]
    if alone is not None:
        parts += ["## Nothing known of the full surface\n", comparison_answer.alone_markdown(alone)]
    parts += ["## Time\n", *_sections(table, ["seconds"])]
    return "\n".join(parts)


def _sections(table, measures):
    """Caption and matrix of each measure."""
    out = []
    for measure in measures:
        value, low = values_of(table, measure), values_of(table, measure, "low")
        if measure == "seconds":
            value = 1000 * value
        half = (value - low).map(lambda x: "" if np.isnan(x) else f" ± {x:.2f}")
        out += [f"{ABOUT[measure]}:\n", matrix_markdown(value.map("{:.2f}".format) + half)]
    return out


def matrix_markdown(matrix):
    """Samplers down, wished n_S across."""
    short = matrix.rename(columns=lambda p: f"{p:g} %").reset_index()
    return markdown(short.assign(sampler=short["sampler"].map(spoken)))


def _at(table):
    percents = table["percent"].unique()
    return float(percents[np.argmin(np.abs(percents - AT))])


def _needed_markdown(table, measure, use):
    """The full matrix at one n_S: what the sampler of a column needs for the Z of the sampler of a row."""
    at, measured = _at(table), table["n_S_percent"]
    rows = needed(table, measure)
    rows = rows[rows["percent"] == at].drop(columns=["use", "measure", "percent"])
    names = [column for column in rows if column not in ("sampler", "Z")]
    for name in names:
        rows[name] = [_per_cent(x, measured.min(), measured.max()) for x in rows[name]]
    rows["sampler"] = [spoken(name) for name in rows["sampler"]]
    rows = rows.rename(
        columns={"sampler": f"for what this one reaches at {at:g} %", **{n: spoken(n) for n in names}}
    )
    return f"n_S in % that the sampler of a column needs {use} (needed.csv has every n_S):\n\n" + markdown(
        rows
    )


def _per_cent(x, smallest, largest):
    if x == 0:
        return f"< {smallest:.1f}"
    return f"> {largest:.0f}" if np.isinf(x) else f"{x:.1f}"


def _findings(table):
    """The honest reading, a sentence each, of the numbers at hand."""
    at = _at(table)
    z = values_of(table, "Z surface")[at].sort_values()
    lines = [f"As the surface, at {at:g} %: {_listed(z)}."]
    lines += [_ranking_sentence(ranking(table))] if set(RANKING) <= set(z.index) else []
    lines += [_lowest_sentence(table, "Z surface", "Lowest Z")]
    lines += [
        _lowest_sentence(table, "Z surface weighted", "Each kept dot counting for the dots nearest to it")
    ]
    recovered = values_of(table, "Z recovered")[at].sort_values()
    lines += [f"Made a dense surface again from the kept dots alone, at {at:g} %: {_listed(recovered)}."]
    for than in (REFERENCE, "paper", "paper_in_hindsight"):
        if {"farthest", than} <= set(z.index):
            lines.append(_fewer_sentence(table, than, at))
    lines.append(_null_sentence(table))
    weighted = values_of(table, "Z surface weighted")[at]
    pairs = [
        f"{spoken(n)} {z[n]:.2f} to {weighted[n]:.2f}" for n in ("paper", "uniform", "farthest") if n in z
    ]
    if pairs:
        words = "Counting each kept dot for the dots nearest to it changes Z"
        lines.append(f"{words} at {at:g} %: {'; '.join(pairs)}.")
    lines.append(_kept_sentence(table, z, at))
    lines.append(f"As centres, at {at:g} %: {_listed(values_of(table, 'Z centres')[at].sort_values())}.")
    return [f"- {line}" for line in lines if line]


def _lowest_sentence(table, measure, words):
    """Who has the lowest Z at which n_S."""
    best = values_of(table, measure).idxmin()
    cases = [
        f"{spoken(name)} at {', '.join(f'{p:g}' for p in best.index[best == name])} %"
        for name in best.unique()
    ]
    return f"{words}: {'; '.join(cases)}."


def _listed(values):
    return ", ".join(f"{spoken(name)} {value:.2f}" for name, value in values.items())


def _ranking_sentence(holds):
    names = " < ".join(RANKING)
    if holds.all():
        return f"Z {names} holds at every n_S."
    yes, no = ([f"{p:g}" for p in holds.index[holds == truth]] for truth in (True, False))
    return (
        f"Z {names} "
        + (f"holds at {', '.join(yes)} %, but " if yes else "does ")
        + f"not at {', '.join(no)} %."
    )


def _fewer_sentence(table, than, at):
    factor, bound = times_fewer(table, "farthest", than, at)
    which = {"paper": "paper (its own choice by d)"}.get(than, spoken(than))
    return f"farthest needs {bound}{bounded(factor, bound)} times fewer dots than {which} at {at:g} % for the same Z."


def _null_sentence(table):
    """Where a subset is worth less than the mean descriptor."""
    z, null = values_of(table, "Z surface"), table["null_model"].mean()
    cases = [
        f"at {percent:g} % "
        + ("every sampler" if (column > null).all() else ", ".join(map(spoken, column.index[column > null])))
        for percent, column in z.items()
        if (column > null).any()
    ]
    return (
        f"Worse than the null model: {'; '.join(cases)}." if cases else "Every Z lies below the null model."
    )


def _kept_sentence(table, z, at):
    """Whether `kept` tells samplers apart by their shape or by how they break up."""
    kept, left = (values_of(table, measure)[at] for measure in ("Z kept", "fragment kept"))
    pair = [name for name in ("paper", "farthest") if name in z]
    if len(pair) < 2 or left[pair].min() > 30:
        return ""
    return (
        f"Under `kept` the order at {at:g} % is {', '.join(spoken(n) for n in kept.sort_values().index)}: there Z tells how a "
        f"subset breaks up at D_link (of the median patch {left['paper']:.0f} % is left for paper, "
        f"{left['farthest']:.0f} % for farthest), not how well it keeps the shape."
    )
