"""Figure that compares samplers: error against the number of kept dots."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from sparsurf import registry
from sparsurf.sampling.samplers import sampler_label
from sparsurf.views import layout
from sparsurf.views.layout import COLUMN_AND_A_HALF, GREY, HALO, SPARE, styled
from sparsurf_study.analysis.comparison import smallest_n_s

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MEASURE = "Z full"
COMPARISON_REFERENCES: dict[str, tuple[Any, str]] = {  # columns of Z: line style, name
    "Z_mean_descriptor": ("--", "mean descriptor for every patch"),
    "Z_resampled": ("-.", "fresh dots of the surface"),
}
ARROW_PERCENT = 20.0  # n_S near which the gain over the paper's sampler is marked


@styled
def comparison_figure(
    table: pd.DataFrame, subject: str, band: str = "95 % over draws and test dots"
) -> Figure:
    """Draw Z under `full` against n_S, a line per sampler; `subject` is what was compared, `band` the meaning of low and high."""
    part = table[table["measure"] == MEASURE]
    best = str(part.groupby("sampler")["value"].mean().idxmin())
    subject = layout.headed(subject, f"{sampler_label(best)} errs least")
    figure = layout.constrained(COLUMN_AND_A_HALF, 96, subject)
    ax = figure.subplots()
    handles = [*_draw_samplers(ax, part), *_draw_references(ax, part)]
    percents = np.unique(part["percent"])
    ax.set(xlabel="dots kept (% of the surface)", ylabel="error Z of the descriptors (0: none)", xscale="log")
    highest = np.nanmax([part["value"].max(), part["high"].max(), part["Z_mean_descriptor"].mean()])
    kept = part["n_S_percent"]
    ax.set(ylim=(0, 1.06 * highest))
    ax.set_xlim(0.88 * min(percents[0], kept.min()), 1.12 * max(percents[-1], kept.max()))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xticks(percents, [f"{p:g}" for p in percents])
    _mark_gain(ax, part)
    title = f"Shaded, of the bold lines: {band}."
    figure.legend(handles=handles, loc="outside lower left", ncols=2, title=title, alignment="left")
    return layout.fix_layout(figure)


def _draw_samplers(ax: Axes, table: pd.DataFrame) -> list[Line2D]:
    """Draw a line per sampler, the bold ones on top with their intervals; return the entries of the legend."""
    handles, spare = [], iter(SPARE * len(table))
    for name, rows in table.groupby("sampler", sort=False):
        choice = registry.choice_of("sampler", str(name))
        colour, width, marker = (choice.line if choice else None) or (next(spare), 0.8, "o")
        style: dict[str, Any] = {"color": colour, "linewidth": width, "marker": marker, "markersize": 2.2}
        rows = rows.sort_values("n_S_percent", kind="stable")
        x, order = rows["n_S_percent"], 2 + width
        if width > 1:
            ax.fill_between(x, rows["low"], rows["high"], color=colour, alpha=0.2, linewidth=0, zorder=order)
        ax.plot(x, rows["value"], zorder=order, **style)
        handles.append(Line2D([], [], label=sampler_label(str(name)), **style))
    return handles


def _draw_references(ax: Axes, table: pd.DataFrame) -> list[Line2D]:
    """Draw the reference values of Z; return the entries of the legend."""
    handles = []
    for column, (dashes, name) in COMPARISON_REFERENCES.items():
        if column in table:
            value = float(table[column].mean())
            ax.axhline(value, color=GREY, linewidth=0.6, linestyle=dashes, zorder=1)
            label = f"{name}: {value:.2f}"
            handles.append(Line2D([], [], color=GREY, linewidth=0.6, linestyle=dashes, label=label))
    return handles


def _mark_gain(ax: Axes, table: pd.DataFrame) -> None:
    """Draw an arrow from the paper's sampler to a farthest-point subset of the same Z."""
    curves = {name: rows.sort_values("n_S_percent") for name, rows in table.groupby("sampler")}
    if not {"paper", "farthest"} <= curves.keys():
        return
    # not at the right end, where the words have no room
    rows = curves["paper"][curves["paper"]["percent"] < table["percent"].max()]
    if rows.empty:
        return
    row = rows.iloc[int(np.argmin(np.abs(rows["percent"] - ARROW_PERCENT)))]
    n_s = smallest_n_s(row["value"], *curves["farthest"][["n_S_percent", "value"]].to_numpy().T)
    if 0 < n_s < row["n_S_percent"]:
        ends = (n_s, row["value"]), (row["n_S_percent"], row["value"])
        arrow = {"arrowstyle": "->", "linewidth": 1, "shrinkA": 3, "shrinkB": 3}
        ax.annotate("", *ends, arrowprops=arrow, zorder=9)
        note = f"same Z:\n{row['n_S_percent'] / n_s:.1f} times\nfewer dots"
        ax.annotate(
            note, ends[1], (4, 1), textcoords="offset points", va="bottom", path_effects=HALO, zorder=9
        )
