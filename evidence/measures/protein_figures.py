"""Figures of the study of many proteins: d, mean roughness, sufficient dots, Z by n_S."""

from collections.abc import Sequence

import pandas as pd
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from sparsurf import registry
from sparsurf.patches.readings import FULL_READING, GRID_READINGS, KEPT_READING, words_of
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling.samplers import sampler_label
from sparsurf.views import layout
from sparsurf.views.layout import PALETTE, styled

COLOURS = {FULL_READING: PALETTE[0], KEPT_READING: PALETTE[5], RECOVERED: PALETTE[2]}
WORDS = {reading: words_of(reading) for reading in GRID_READINGS} | {
    RECOVERED: "reconstructed, a quarter of the grid"
}
READINGS_SHOWN = [name for name in GRID_READINGS if name in COLOURS]
AXIS = "$n_S$ (% of the dots)"


@styled
def d(stored: dict[str, pd.DataFrame]) -> Figure:
    """Return d by range of n_S: each protein's own best, and what all others choose for it; of the recovered grid, the means."""
    figure = layout.sheet(layout.PAGE_WIDTH, 80)
    summary = stored["summary"]
    table = pd.concat([stored["d"], stored.get("recovered")])
    shown = [*READINGS_SHOWN, RECOVERED] if "recovered" in stored else READINGS_SHOWN
    apart = (layout.PAGE_WIDTH - 3) / len(shown)
    for k, reading in enumerate(shown):
        left = 13 + apart * k
        ax = layout.axes(figure, left, 9, apart - 14, 44)
        rows = table[(table["reading"] == reading) & (table["range"] > 0)]
        own = summary[(summary["reading"] == reading) & summary["d_cv"].notna()]
        if len(own):
            ax.plot(own["n_S_percent"], own["d_cv"], ".", color="#BBBBBB", markersize=2, label="one protein")
        error = rows[["own", "own_low", "own_high"]].to_numpy().T
        ax.errorbar(
            rows["n_S_percent"], error[0], [error[0] - error[1], error[2] - error[0]],
            color=COLOURS[reading], marker="o", capsize=2, label="own best, mean (95 %)",
        )  # fmt: skip
        ax.plot(rows["n_S_percent"], rows["from_all"], "k_", markersize=9, label="choice of all others, mean")
        ax.axhline(0, color="black", linewidth=0.5)
        ax.set(xlabel=AXIS, ylabel="cross-validated d" if k == 0 else "")
        layout.letter(figure, left - 11, 2, "ABC"[k])
        layout.text(figure, left - 6, 2.3, WORDS[reading])
        layout.legend(figure, left, 66, ax.get_legend_handles_labels()[0])
    return figure


@styled
def needed(stored: dict[str, pd.DataFrame]) -> Figure:
    """Draw Z by n_S over the proteins, as they are and recovered, with the noise floor."""
    figure = layout.sheet(layout.PAGE_WIDTH, 82)
    table, surfaces = stored["by_n_s"], stored["surfaces"]
    floor = surfaces["Z_resampled"].mean()
    for k, reading in enumerate((FULL_READING, RECOVERED)):
        ax = layout.axes(figure, 16 + 88 * k, 9, 72, 54)
        for sampler, rows in table[table["reading"] == reading].groupby("sampler", sort=False):
            colour, width, marker = registry.TABLE["sampler"][sampler].line
            ax.fill_between(
                rows["percent"], rows["Z_low"], rows["Z_high"], color=colour, alpha=0.2, linewidth=0
            )
            style = {
                "color": colour,
                "linewidth": width,
                "marker": marker,
                "label": sampler_label(sampler),
                "linestyle": "-"
                if width > 1
                else "--",  # a thin line that coincides with a wide one lets it be seen
            }
            ax.plot(rows["percent"], rows["Z"], **style)
        ax.axhline(floor, color="#4D4D4D", linewidth=0.5, linestyle=":")
        if k == 0:
            offset = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
            ax.annotate("fresh dots", (0, floor), (3, -1), va="top", **offset)
        ax.set(
            xscale="log",
            xlabel=AXIS,
            ylabel="Z (mean and 95 % over proteins)" if k == 0 else "",
            ylim=(0, 2.6),
        )
        _percents(ax.xaxis)
        layout.letter(figure, 2 + 88 * k, 2, "AB"[k])
        layout.text(
            figure,
            7 + 88 * k,
            2.3,
            "the surface reconstructed from the dots" if k else "the dots as they are",
        )
        if k == 0:
            layout.legend(figure, 16, 75, ax.get_legend_handles_labels()[0], ncols=4)
    return figure


def _percents(axis: Axis) -> None:
    """Return ticks at round percents of a logarithmic axis."""
    _ticks(axis, [1, 2, 5, 10, 20, 40, 60])


def _ticks(axis: Axis, values: Sequence[float]) -> None:
    """Return ticks at these values of a logarithmic axis and nowhere else."""
    axis.set_ticks(values, [f"{x:g}" for x in values])
    axis.set_minor_locator(NullLocator())


FIGURES = {"d": d, "needed": needed}  # docs/proteins_<name>.png
