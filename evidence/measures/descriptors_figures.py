"""The quality of samplers with each descriptor, a figure of docs/descriptors.md."""

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter, NullLocator

from sparsurf.report.figures.layout import PAGE, PALETTE, axes, legend, letter, sheet, styled
from sparsurf.sampling.samplers import sampler_label

COLOURS = {"published": PALETTE[1], "rotation_robust": PALETTE[0]}
MARKS = ("o", "s", "^", "D")
SHOWN = ("farthest", "poisson", "uniform", "paper")  # samplers


@styled
def samplers(changes: pd.DataFrame, table: pd.DataFrame) -> Figure:
    """Draw Z of the samplers against n_S in units of the descriptor's own floor, a panel per descriptor; means over surfaces."""
    figure = sheet(PAGE, 68)
    for d, name in enumerate(COLOURS):
        panel = axes(figure, 16 + 88 * d, 8, 74, 42)
        floors = floors_of(changes, name)
        rows = table[table["descriptor"] == name]
        rows = rows.assign(ratio=rows["Z"] / rows["surface"].map(floors))
        for sampler, colour, mark in zip(SHOWN, PALETTE, MARKS, strict=False):
            means = rows[rows["sampler"] == sampler].groupby("percent")[["n_S_percent", "ratio"]].mean()
            size = 7 if sampler == SHOWN[0] else 4  # the next one is drawn over it
            panel.plot(means["n_S_percent"], means["ratio"], color=colour, marker=mark, markersize=size)
        panel.axhline(1, color="0.5", linewidth=0.5, linestyle=":")
        panel.set(
            xscale="log", yscale="log", xlabel="n_S / % of the dots", ylabel="Z / floor", ylim=(0.7, 15)
        )
        panel.set_title(f"{name}: floor {floors.mean():.2f}")
        panel.set_xticks([2.5, 5, 10, 20, 40], ["2.5", "5", "10", "20", "40"])
        panel.set_yticks([1, 2, 5, 10], ["1", "2", "5", "10"])
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_minor_locator(NullLocator())
            axis.set_minor_formatter(NullFormatter())
        letter(figure, 2 + 90 * d, 2, "ab"[d])
    handles = [
        Line2D([], [], color=colour, marker=mark, label=sampler_label(sampler))
        for sampler, colour, mark in zip(SHOWN, PALETTE, MARKS, strict=False)
    ]
    legend(figure, 16, 63, handles, ncols=4)
    return figure


def floors_of(changes: pd.DataFrame, descriptor: str, change: str = "turned, fresh dots") -> pd.Series:
    """Return Z between two descriptions of the same surface at the lowest density, by surface."""
    rows = changes[(changes["descriptor"] == descriptor) & (changes["change"] == change)]
    return rows[rows["density"] == rows["density"].min()].set_index("surface")["Z"]
