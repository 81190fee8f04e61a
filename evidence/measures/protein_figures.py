"""Figures of the study of many proteins: d, mean roughness, sufficient dots, Z by n_S."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from sparsurf.patches.readings import CODED_READING, GRID_READINGS, WRITTEN_READING
from sparsurf.recovery.readings import RECOVERED
from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import LINES, PALETTE, styled
from sparsurf.report.figures.summary_figures import GREEK
from sparsurf.sampling.samplers import sampler_label

FAIR = "atoms moved 0.3 Å"
COLOURS = {WRITTEN_READING: PALETTE[0], CODED_READING: PALETTE[5], RECOVERED: PALETTE[2]}
WORDS = {reading: reading.replace("_", " ") for reading in GRID_READINGS} | {
    RECOVERED: "recovered, a quarter of the grid"
}
READINGS_SHOWN = [name for name in GRID_READINGS if name in COLOURS]
AXIS = "$n_S$ (% of the dots)"


@styled
def d(stored: dict[str, pd.DataFrame]) -> Figure:
    """Return d by range of n_S: each protein's own best, and what all others choose for it; of the recovered grid, the means."""
    figure = layout.sheet(layout.PAGE, 80)
    summary = stored["summary"]
    table = pd.concat([stored["d"], stored.get("recovered")])
    shown = [*READINGS_SHOWN, RECOVERED] if "recovered" in stored else READINGS_SHOWN
    apart = (layout.PAGE - 3) / len(shown)
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
def roughness(stored: dict[str, pd.DataFrame]) -> Figure:
    """Rank correlation of the best parameters with mean roughness, and what a choice by it gains."""
    figure = layout.sheet(layout.PAGE, 112)
    relation, critical = stored["relation"], stored["power"]["critical"].min()
    for k, reading in enumerate(READINGS_SHOWN):
        rows, left = relation[relation["reading"] == reading], 16 + 88 * k
        ax = layout.axes(figure, left, 9, 72, 42)
        ax.axhspan(-critical, critical, color="#EEEEEE", label="largest of four by chance, 95 %")
        for k_parameter, (name, greek) in enumerate(GREEK.items()):
            values = rows[[f"rho_{name}{end}" for end in ("", "_low", "_high")]].to_numpy().T
            error = [values[0] - values[1], values[2] - values[0]]
            x = rows["range"] + 0.16 * (k_parameter - 1.5)
            ax.errorbar(x, values[0], error, color=PALETTE[k_parameter], fmt="o", capsize=1, label=greek)
        ax.set(
            ylim=(-1, 1),
            xticks=rows["range"],
            ylabel="rank correlation with\nmean roughness" if k == 0 else "",
        )
        if k == 0:
            ax.legend(
                loc="lower left", ncols=5, bbox_to_anchor=(0, -0.34), columnspacing=1, handletextpad=0.3
            )
        layout.letter(figure, left - 14, 2, "AB"[k])
        layout.text(figure, left - 9, 2.3, WORDS[reading])
        ax = layout.axes(figure, left, 70, 72, 30)
        values = rows[["gain", "gain_low", "gain_high"]].to_numpy().T
        error = [values[0] - values[1], values[2] - values[0]]
        ax.errorbar(rows["range"], values[0], error, color=COLOURS[reading], fmt="o", capsize=2)
        ax.axhline(0, color="black", linewidth=0.5)
        ax.set(xticks=rows["range"], xlabel="range of $n_S$", ylabel="d, near less far" if k == 0 else "")
        layout.letter(figure, left - 14, 64, "CD"[k])
    return figure


@styled
def required(stored: dict[str, pd.DataFrame]) -> Figure:
    """Draw how many dots are enough on each protein with its interval, by size, for each noise floor."""
    figure = layout.sheet(layout.PAGE, 62)
    table = stored["required"]
    known = stored["surfaces"].set_index("protein")["N"] / 1000
    floors = list(table["floor"].unique())
    for k, floor in enumerate(floors):
        rows = table[table["floor"] == floor]
        x, n = known.reindex(rows["protein"]).to_numpy(), rows["n_S_percent"].to_numpy()
        error = np.nan_to_num([n - rows["n_S_percent_low"], rows["n_S_percent_high"] - n])
        ax = layout.axes(figure, 16 + 41 * k, 10, 37, 38)
        ax.errorbar(x, n, error, fmt="o", markersize=2, linewidth=0.6, color=PALETTE[0])
        ax.axhline(np.median(n), color="black", linestyle="--")
        ax.set(xscale="log", yscale="log", ylim=(0.9, 70), xlim=(9, 1.1 * known.max()))
        ax.set(xlabel="dots (thousand)", ylabel=AXIS if k == 0 else "")
        _percents(ax.yaxis)
        _ticks(ax.xaxis, [10, 20, 40, 80, 160])
        layout.letter(figure, (2 if k == 0 else 12) + 41 * k, 2, "ABCD"[k])
        layout.text(figure, (7 if k == 0 else 17) + 41 * k, 2.3, f"{floor}\nmedian {np.median(n):.1f} %")
    return figure


@styled
def needed(stored: dict[str, pd.DataFrame]) -> Figure:
    """Draw Z by n_S over the proteins, as they are and recovered, with the noise floors."""
    figure = layout.sheet(layout.PAGE, 82)
    table, surfaces = stored["by_n_s"], stored["surfaces"]
    floors = {"fresh dots": surfaces["Z_resampled"].mean(), "turned": surfaces["Z_turned"].mean()}
    floors[FAIR] = surfaces["Z_atoms_moved_0.3_Å"].mean()
    for k, reading in enumerate((WRITTEN_READING, RECOVERED)):
        ax = layout.axes(figure, 16 + 88 * k, 9, 72, 54)
        for sampler, rows in table[table["reading"] == reading].groupby("sampler", sort=False):
            colour, width, marker = LINES[sampler]
            ax.fill_between(
                rows["percent"], rows["Z_low"], rows["Z_high"], color=colour, alpha=0.2, linewidth=0
            )
            style = {
                "color": colour,
                "linewidth": width,
                "marker": marker,
                "label": sampler_label(sampler),
            }
            ax.plot(rows["percent"], rows["Z"], **style)
        for words, z in floors.items():
            ax.axhline(z, color="#4D4D4D", linewidth=0.5, linestyle=":")
            if k == 0:
                below = words != "turned"
                offset = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
                ax.annotate(words, (0, z), (3, -1 if below else 1), va="top" if below else "bottom", **offset)
        ax.set(
            xscale="log",
            xlabel=AXIS,
            ylabel="Z (mean and 95 % over proteins)" if k == 0 else "",
            ylim=(0, 2.6),
        )
        _percents(ax.xaxis)
        layout.letter(figure, 2 + 88 * k, 2, "AB"[k])
        layout.text(
            figure, 7 + 88 * k, 2.3, "the surface recovered from the dots" if k else "the dots as they are"
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


FIGURES = {"d": d, "roughness": roughness, "required": required, "needed": needed}  # docs/proteins_<name>.png
