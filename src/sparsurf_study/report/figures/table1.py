"""Table I of the paper: each published value on the range of runs made as published, and the other reading."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd
from matplotlib.lines import Line2D

from sparsurf.patches.readings import FULL_READING, words_of
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.views import layout
from sparsurf.views.layout import DARK, SAMPLED, styled
from sparsurf.views.numbers import share

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MEASURE_LABELS = {
    "d": "d: Z of a random subset minus Z of the sampling",
    "Z_tS": "$Z_{tS}$: error of the subset",
}
RUNS_STYLE: dict[str, Any] = {"color": "#C9CDD2", "linewidth": 5, "solid_capstyle": "round"}
PUBLISHED_STYLE: dict[str, Any] = {"marker": "D", "markersize": 4, "linestyle": "", "zorder": 3}
OTHER: dict[str, Any] = {"marker": "o", "markersize": 3.5, "linestyle": "", "zorder": 2}
OTHER |= {"color": DARK, "markerfacecolor": "none"}


@styled
def table1_figure(places: pd.DataFrame, rows: pd.DataFrame) -> Figure:
    """Draw d on the left and Z_tS on the right, with a line for each row of Table I."""
    figure = layout.constrained(layout.PAGE_WIDTH, 82)
    panels = figure.subplots(1, 2)
    for ax, (name, label) in zip(panels, MEASURE_LABELS.items(), strict=True):
        _panel(ax, places, rows, name)
        ax.set_xlabel(label)
    panels[0].axvline(0, color="black", linewidth=0.5, zorder=0)
    names = []
    for low, high, *combination in rows[["n_S_low_percent", "n_S_high_percent", *PARAMETERS]].to_numpy():
        values = ", ".join(f"{value:g}" for value in combination)
        names.append(f"{share(low)}–{share(high)} %   ({values})")
    panels[0].set_yticks(range(len(rows)), names)
    panels[1].set_yticks([])
    handles = [
        Line2D([], [], label=f"{int(places['n_runs'].max())} runs as published", **RUNS_STYLE),
        Line2D([], [], color="black", label="published", **PUBLISHED_STYLE),
        Line2D([], [], color=SAMPLED, label="published, outside of the central 95 %", **PUBLISHED_STYLE),
        Line2D([], [], label=f"ours, {words_of(FULL_READING)}", **OTHER),
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=4)
    return layout.fix_layout(figure)


def _panel(ax: Axes, places: pd.DataFrame, rows: pd.DataFrame, name: str) -> None:
    """Draw one measure: a bar from the lowest to the highest run, the published value, the value on the full surface."""
    for y, row in enumerate(places.to_dict("records")):
        ends = [row[f"{name}_lowest"], row[f"{name}_highest"]]
        ax.plot(ends, [y, y], **RUNS_STYLE)
        is_outside = row[f"{name}_inside"] == 0  # unknown with too few runs
        ax.plot([row[f"{name}_published"]], [y], color=SAMPLED if is_outside else "black", **PUBLISHED_STYLE)
    ax.plot(rows[f"{name}_{FULL_READING}"], range(len(rows)), **OTHER)
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)
