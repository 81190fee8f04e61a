"""Figure of the comparison of samplers: error against the number of kept dots."""

import numpy as np
from matplotlib.ticker import NullLocator

from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import GREY, HALO, LINES, SPARE, styled
from sparsurf.sampling.samplers import lookup_sampler
from sparsurf.study.comparison.equal_error import (
    dots_needed,
    factor_with_bound,
    measure_matrix,
    measured_ranges,
)

SMALL = [  # measure, title, label of the y axis; two panels in each row
    ("Z scaled", "as A, surface unknown: islands\ncut by the kept dots' spacing", "error Z"),
    ("Z as_coded", "as A, islands cut at $D_{link}$ like\nthe paper: subsets break up", "error Z"),
    ("Z recovered", "as A, after the surface has been\nrecovered from the kept dots", "error Z"),
    ("Z centres", "the kept dots serve as centres\nof patches of all dots", "error Z"),
    ("position", "from any dot to the nearest\nkept one", "distance (Å)"),
    ("normal", "between the normals of any dot\nand the nearest kept one", "angle (degrees)"),
]
AXIS = "dots kept (% of the surface)"
TALL = 103.0  # mm, height of panel A
ARROW = 20.0  # n_S in % near which the gain over the paper's sampler is marked


@styled
def comparison_figure(table, subject, band="95 % over draws and test dots"):
    """Error of each sampler against n_S, in both uses and without descriptors.

    Parameters
    ----------
    table : DataFrame
        Columns sampler, percent, n_S_percent, measure, value, low, high, null_model, empty_patch.
    subject : str
        What was compared: a conformation, or so many proteins.
    band : str
        What low and high are.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = layout.sheet(layout.PAGE, 129, subject)
    names = list(table["sampler"].unique())
    spare = iter(SPARE * len(names))
    lines = {name: LINES.get(name) or (next(spare), 0.8, "o") for name in names}
    layout.letter(figure, 1, 1, "A")
    layout.text(figure, 6, 1.3, "Z of the kept dots,\nas written")
    ax = layout.axes(figure, 12, 12, 46, TALL)
    _panel(ax, table, "Z as_written", lines)
    ax.set(xlabel=AXIS, ylabel="error Z of the descriptors (0: none)")
    _name_lines(ax, table, lines)
    _mark_gain(ax, table)
    for k, (measure, title, label) in enumerate(SMALL):
        x, y = 100 + 47 * (k % 2), 1 + 40 * (k // 2)
        layout.letter(figure, x - 12, y, "BCDEFG"[k])
        layout.text(figure, x - 8, y + 0.3, title)
        small = layout.axes(figure, x, y + 8.5, 34, 25)
        _panel(small, table, measure, lines)
        small.set(xlabel=AXIS if k > 3 else "", ylabel=label)
    words = f"Shaded, of the bold lines: {band}. Colours in B to G as in A."
    layout.text(figure, 12, 126, words, color=GREY)
    return figure


def _panel(ax, table, measure, lines):
    """One measure against n_S, a line per sampler, the bold ones on top."""
    part = table[table["measure"] == measure]
    for name, own in part.groupby("sampler", sort=False):
        colour, width, marker = lines[name]
        x, order = own["n_S_percent"], 2 + width
        if width > 1:
            ax.fill_between(x, own["low"], own["high"], color=colour, alpha=0.2, linewidth=0, zorder=order)
        ax.plot(x, own["value"], color=colour, linewidth=width, marker=marker, markersize=2.2, zorder=order)
    percents = np.unique(table["percent"])
    of_z = measure.startswith("Z ")
    top = np.nanmax([part["value"].max(), part["high"].max(), part["null_model"].mean() if of_z else 0])
    ax.set(xscale="log", ylim=(0, 1.06 * top))
    ax.set_xlim(
        0.88 * min(percents[0], part["n_S_percent"].min()),
        1.12 * max(percents[-1], part["n_S_percent"].max()),
    )
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xticks(percents, [f"{p:g}" for p in percents])
    if of_z:
        ax.axhline(part["null_model"].mean(), color=GREY, linewidth=0.6, linestyle="--", zorder=1)
        if "fresh_dots" in part:
            fresh = part["fresh_dots"].mean()
            ax.axhline(fresh, color=GREY, linewidth=0.6, linestyle="-.", zorder=1)
            if measure == "Z as_written":
                _name(ax, f"fresh dots of the surface: {fresh:.2f}", fresh, above=False)
    if measure == "Z as_coded":
        _explain(ax, part)


def _explain(ax, part):
    """The references of Z, where both fall into the range."""
    null, empty = part["null_model"].mean(), part["empty_patch"].mean()
    ax.axhline(empty, color=GREY, linewidth=0.6, linestyle="--", zorder=1)
    ax.set_ylim(top=1.25 * empty)
    _name(ax, "empty patches", empty)
    _name(ax, "mean descriptor", null)


def _name(ax, words, value, above=True):
    """Name of a reference at its left end, where no line crosses it but by chance."""
    ax.annotate(
        words,
        (0.03, value),
        (0, 1 if above else -2),
        xycoords=ax.get_yaxis_transform(),
        textcoords="offset points",
        va="bottom" if above else "top",
        color=GREY,
        path_effects=HALO,
        zorder=8,
    )


def _name_lines(ax, table, lines):
    """Name of each line at its right end, and of the reference, moved apart where they would touch."""
    matrix = measure_matrix(table, "Z as_written")
    ends = measure_matrix(table, "Z as_written", "n_S_percent").iloc[:, -1]
    null, empty = table["null_model"].mean(), table["empty_patch"].mean()
    words = f"mean descriptor for\nevery patch: {null:.2f}\n(empty patches: {empty:.1f})"
    labels = [(null, None, words, GREY, "normal")]
    for name, value in matrix.iloc[:, -1].items():
        colour, width, _ = lines[name]
        weight = "bold" if width > 1 else "normal"
        labels.append((value, ends[name], lookup_sampler(name).words, colour, weight))
    labels.sort(key=lambda label: label[0])
    height = ax.get_ylim()[1]
    room = np.array([3.1 * (1 + words.count("\n")) + 0.3 for _, _, words, _, _ in labels]) / TALL * height
    places = layout.apart(np.array([label[0] for label in labels]), room, height)
    for (value, end, words, colour, weight), place in zip(labels, places / height, strict=True):
        ax.text(1.06, place, words, transform=ax.transAxes, color=colour, va="center", fontweight=weight)
        leader = {"arrowstyle": "-", "linewidth": 0.4, "color": colour, "shrinkA": 0, "shrinkB": 2}
        if end is not None:
            at = {"textcoords": "axes fraction", "annotation_clip": False}
            ax.annotate("", (end, value), (1.05, place), arrowprops=leader, **at)


def _mark_gain(ax, table):
    """Arrow from the paper's sampler to as good a subset of the farthest-point one."""
    rows = dots_needed(table)
    # at the right end the lines have their names
    rows = rows[(rows["sampler"] == "paper") & (rows["percent"] < rows["percent"].max())]
    if len(rows) and "farthest" in rows:
        row = rows.iloc[int(np.argmin(np.abs(rows["percent"] - ARROW)))]
        factor, bound = factor_with_bound(row, "farthest", measured_ranges(table))
        if factor > 1 and not bound:
            ends = (row["farthest"], row["Z"]), (row["paper"], row["Z"])
            ax.annotate(
                "",
                *ends,
                arrowprops={"arrowstyle": "->", "linewidth": 1, "shrinkA": 3, "shrinkB": 3},
                zorder=9,
            )
            words = f"same Z:\n{factor:.1f} times\nfewer dots"  # narrow, so that it ends before the names
            ax.annotate(
                words, ends[1], (4, 1), textcoords="offset points", va="bottom", path_effects=HALO, zorder=9
            )
