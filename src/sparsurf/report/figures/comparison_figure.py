"""Figures that compare samplers: error against the number of kept dots."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import COLUMN_AND_A_HALF, GREY, HALO, LINES, SPARE, styled
from sparsurf.sampling.samplers import sampler_label
from sparsurf.study.comparison.equal_error import dots_needed, factor_with_bound, measured_ranges

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MEASURES = [  # measure, title, label of the y axis
    ("Z as_written", "Z of the kept dots,\nas written", "error Z of the descriptors (0: none)"),
    ("Z scaled", "surface unknown: islands\ncut by the dots' spacing", "error Z"),
    ("Z as_coded", "islands cut at $D_{link}$ like\nthe paper: subsets break up", "error Z"),
    ("Z recovered", "the surface recovered\nfrom the kept dots", "error Z"),
    ("Z centres", "kept dots as centres\nof patches of all dots", "error Z"),
    ("position", "from any dot to the\nnearest kept one", "distance (Å)"),
    ("normal", "normals of any dot and\nthe nearest kept one", "angle (degrees)"),
]
REFERENCES: dict[str, tuple[Any, str]] = {  # columns of Z: line style, name
    "Z_mean_descriptor": ("--", "mean descriptor for every patch"),
    "Z_empty": (":", "empty patches"),
    "Z_resampled": ("-.", "fresh dots of the surface"),
}
AXIS = "dots kept (% of the surface)"
ARROW_PERCENT = 20.0  # n_S near which the gain over the paper's sampler is marked


MAX_LINES = 5  # of the figure with one panel; all are in the other


@styled
def comparison_figure(
    table: pd.DataFrame, subject: str, band: str = "95 % over draws and test dots"
) -> Figure:
    """Draw Z against n_S as written, of the three samplers of the ranking and of the best others.

    Parameters
    ----------
    table : DataFrame
        Columns sampler, percent, n_S_percent, measure, value, low, high, Z_mean_descriptor, Z_empty.
    subject : str
        What was compared: a conformation, or a number of proteins.
    band : str
        Meaning of low and high.

    Returns
    -------
    matplotlib.figure.Figure
    """
    measure, _, label = MEASURES[0]
    means = table[table["measure"] == measure].groupby("sampler")["value"].mean().sort_values()
    lines = _lines(table)
    bold = [name for name, (_, width, _) in lines.items() if width > 1]
    shown = [*bold, *means.index.difference(bold, sort=False)][:MAX_LINES]
    part = table[table["sampler"].isin(shown)].drop(columns="Z_empty")  # far above
    figure = layout.constrained(COLUMN_AND_A_HALF, 96, layout.headed(subject, _message(table)))
    ax = figure.subplots()
    _panel(ax, part, measure, {name: line for name, line in lines.items() if name in shown})
    ax.set(xlabel=AXIS, ylabel=label)
    _mark_gain(ax, table)
    _add_legend(figure, part, lines, band, 2)
    return layout.fix_layout(figure)


@styled
def comparison_panels(
    table: pd.DataFrame, subject: str, band: str = "95 % over draws and test dots"
) -> Figure:
    """Draw the error of every sampler against n_S for each measure; parameters as in `comparison_figure`."""
    figure, lines = layout.constrained(layout.PAGE, 150, subject), _lines(table)
    panels = figure.subplot_mosaic("ABC;ADE;AFG", width_ratios=[1.5, 1, 1])
    for ax, letter, (measure, title, label) in zip(panels.values(), panels, MEASURES, strict=True):
        _panel(ax, table, measure, lines)
        layout.panel_title(ax, letter, title)
        ax.set(xlabel=AXIS if letter in "AFG" else "", ylabel=label)
    _add_legend(figure, table, lines, band, 4)
    return layout.fix_layout(figure)


def _lines(table: pd.DataFrame) -> dict[str, tuple[str, float, str]]:
    """Return colour, line width and marker of each sampler of a table."""
    names = list(table["sampler"].unique())
    spare = iter(SPARE * len(names))
    return {name: LINES.get(name) or (next(spare), 0.8, "o") for name in names}


def _add_legend(
    figure: Figure, table: pd.DataFrame, lines: dict[str, tuple[str, float, str]], band: str, ncols: int
) -> None:
    """Name the samplers of a table and the reference values below the panels."""
    shown = set(table["sampler"])
    handles = _legend_handles(table, {name: line for name, line in lines.items() if name in shown})
    title = f"Shaded, of the bold lines: {band}."
    figure.legend(handles=handles, loc="outside lower left", ncols=ncols, title=title, alignment="left")


def _message(table: pd.DataFrame) -> str:
    """Say which sampler errs least by the first measure, on average over the numbers of dots; empty if none was measured."""
    part = table[(table["measure"] == MEASURES[0][0]) & table["value"].notna()]
    if part.empty:
        return ""
    best = str(part.groupby("sampler")["value"].mean().idxmin())
    return f"{sampler_label(best)} errs least"


def _panel(ax: Axes, table: pd.DataFrame, measure: str, lines: dict[str, tuple[str, float, str]]) -> None:
    """Draw one measure against n_S, a line per sampler, the bold ones on top, and the reference values of Z."""
    part = table[table["measure"] == measure]
    for name, (colour, width, marker) in lines.items():
        rows = part[part["sampler"] == name]
        x, order = rows["n_S_percent"], 2 + width
        if width > 1:
            ax.fill_between(x, rows["low"], rows["high"], color=colour, alpha=0.2, linewidth=0, zorder=order)
        ax.plot(x, rows["value"], color=colour, linewidth=width, marker=marker, markersize=2.2, zorder=order)
    percents = np.unique(table["percent"])
    references = _references(part) if measure.startswith("Z ") else {}
    top = np.nanmax([part["value"].max(), part["high"].max(), references.get("Z_mean_descriptor", 0.0)])
    for name, value in references.items():
        if name != "Z_empty" or measure == "Z as_coded":
            ax.axhline(value, color=GREY, linewidth=0.6, linestyle=REFERENCES[name][0], zorder=1)
    if measure == "Z as_coded":
        top = 1.18 * references["Z_empty"]
    ax.set(xscale="log", ylim=(0, 1.06 * top))
    ax.set_xlim(
        0.88 * min(percents[0], part["n_S_percent"].min()),
        1.12 * max(percents[-1], part["n_S_percent"].max()),
    )
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xticks(percents, [f"{p:g}" for p in percents])


def _references(table: pd.DataFrame) -> dict[str, float]:
    """Return the mean reference values of Z by column."""
    return {name: float(table[name].mean()) for name in REFERENCES if name in table}


def _legend_handles(table: pd.DataFrame, lines: dict[str, tuple[str, float, str]]) -> list[Line2D]:
    """Return the entries of the legend: every sampler, then every reference value."""
    handles = [
        Line2D(
            [],
            [],
            color=colour,
            linewidth=width,
            marker=marker,
            markersize=2.2,
            label=sampler_label(name),
        )
        for name, (colour, width, marker) in lines.items()
    ]
    for name, value in _references(table).items():
        dashes, words = REFERENCES[name]
        label = f"{words}: {value:.2f}"
        handles.append(Line2D([], [], color=GREY, linewidth=0.6, linestyle=dashes, label=label))
    return handles


def _mark_gain(ax: Axes, table: pd.DataFrame) -> None:
    """Draw an arrow from the paper's sampler to a farthest-point subset of the same Z."""
    rows = dots_needed(table)
    # not at the right end, where the words have no room
    rows = rows[(rows["sampler"] == "paper") & (rows["percent"] < rows["percent"].max())]
    if len(rows) and "farthest" in rows:
        row = rows.iloc[int(np.argmin(np.abs(rows["percent"] - ARROW_PERCENT)))]
        factor, bound = factor_with_bound(row, "farthest", measured_ranges(table))
        if factor > 1 and not bound:
            ends = (row["farthest"], row["Z"]), (row["paper"], row["Z"])
            ax.annotate(
                "",
                *ends,
                arrowprops={"arrowstyle": "->", "linewidth": 1, "shrinkA": 3, "shrinkB": 3},
                zorder=9,
            )
            words = f"same Z:\n{factor:.1f} times\nfewer dots"
            ax.annotate(
                words, ends[1], (4, 1), textcoords="offset points", va="bottom", path_effects=HALO, zorder=9
            )
