"""Distributions over the surfaces of a run in batches."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import LogLocator, MaxNLocator

from sparsurf.views import layout
from sparsurf.views.layout import styled

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

PANELS = {  # column of `summary.measures` and what is written at its axis
    "atoms": "atoms",
    "mean_roughness": "mean roughness",
    "area_per_atom": "area per atom (Å²)",
    "cavity_percent": "dots in cavities (%)",
}
BINS = 40


@styled
def figure(measures: pd.DataFrame) -> Figure:
    """Draw a histogram of each of `batches.summary.measures`, with the median as a line."""
    figure = layout.constrained(layout.PAGE_WIDTH, 90)
    for k, ((column, label), ax) in enumerate(zip(PANELS.items(), figure.subplots(2, 2).flat, strict=True)):
        values = measures[column].dropna().to_numpy(float)
        if column == "atoms":
            ax.set_xscale("log")
            ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            ax.xaxis.set_major_formatter("{x:,.0f}")
            ax.xaxis.set_minor_formatter("")
        if len(values):
            low, high = values.min(), values.max()
            if column == "atoms" and high > low:
                edges = np.geomspace(low, high, BINS + 1)
            else:
                edges = np.linspace(low, high if high > low else low + 1, BINS + 1)
            ax.hist(values, edges, color=layout.PALE, edgecolor=layout.DARK, linewidth=0.3)
            ax.axvline(float(np.median(values)), color=layout.SAMPLED)
        ax.yaxis.set_major_locator(MaxNLocator(5, integer=True))
        ax.set_xlabel(label)
        ax.set_ylabel("surfaces")
        ax.set_title("ABCD"[k], loc="left", fontweight="bold")
    return layout.fix_layout(figure)
