"""Best parameters and their d over all surfaces of a run, against mean roughness."""

from __future__ import annotations

from string import ascii_uppercase
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import colormaps, colors
from matplotlib.cm import ScalarMappable
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from sparsurf.recovery.readings import READINGS, readings_of_columns
from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import PAGE, styled
from sparsurf.sampling.combination import PARAMETERS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GREEK = dict(zip(PARAMETERS, "αβγδ", strict=True))
SIGNIFICANT = 0.05
GAIN: dict[str, Any] = {
    "marker": "o",
    "markersize": 3.5,
    "linestyle": "",
    "color": "black",
    "markeredgewidth": 0.6,
}


@styled
def summary_figure(summary: pd.DataFrame, relations: pd.DataFrame) -> Figure:
    """Draw best parameters and their d against mean roughness, and the gain of a choice by it."""
    readings = readings_of_columns(summary.reading.unique())
    pitch = 160 / max(2, len(readings))
    width = pitch - 16
    limits = np.append(relations.n_S_low_percent[: relations.range.max()], relations.n_S_high_percent.max())
    norm = colors.BoundaryNorm(limits, 256) if np.ptp(limits) > 0 else colors.Normalize()
    scale = ScalarMappable(norm, colormaps["viridis"])
    gains = (relations.gain_low > 0).any()
    message = (
        "choosing by roughness gains d in some ranges" if gains else "choosing by roughness gains nothing"
    )
    figure = layout.sheet(PAGE, 187, message)
    widest = max(0.01, np.nanmax(np.append(relations[["gain_low", "gain_high"]].abs().to_numpy(), 0)))
    for k, reading in enumerate(readings):
        rows = summary[(summary.reading == reading) & summary.d.notna()]
        x = 16 + pitch * k
        layout.letter(figure, x - 15, 1, ascii_uppercase[k])
        layout.text(figure, x - 10, 1.3, layout.folded(READINGS[reading].words, pitch - 5))
        _parameters(figure, x, width, rows, scale, limits, left=k == 0)
        layout.letter(figure, x - 15, 137, ascii_uppercase[len(readings) + k])
        words = "choice of the nearest surfaces against the farthest"
        layout.text(figure, x - 10, 137.3, layout.folded(words, pitch - 5))
        ax = layout.axes(figure, x, 144, width, 26)
        _gain(ax, relations[relations.reading == reading], 1.1 * widest, left=k == 0)
    _gain_key(figure)
    bar = figure.colorbar(scale, cax=layout.axes(figure, 169, 8, 2.5, 116), spacing="proportional")
    bar.set_ticks(limits.tolist(), labels=[f"{limit:.0f}" for limit in limits])
    bar.set_label("range of $n_S$ (% of the dots)")
    return figure


def _gain_key(figure: layout.Sheet) -> None:
    """Add the legend of the gain."""
    dots = {"parameters correlate with mean roughness, p < 0.05": "black", "no such correlation": "white"}
    handles = [
        Line2D([], [], **GAIN | {"markerfacecolor": face}, label=words) for words, face in dots.items()
    ]
    layout.legend(figure, 16, 181.5, handles, ncols=2)


def _parameters(
    figure: layout.Sheet,
    x: float,
    width: float,
    rows: pd.DataFrame,
    scale: ScalarMappable,
    limits: np.ndarray,
    left: bool,
) -> None:
    """Draw alpha, beta, gamma, delta and d of the winners, one below the other, against mean roughness."""
    colour = scale.to_rgba(((limits[:-1] + limits[1:]) / 2)[rows.range.to_numpy() - 1])
    rough = rows.mean_roughness.to_numpy()
    margin = 0.06 * np.ptp(rough) + 0.002
    for k, name in enumerate(PARAMETERS):
        ax = layout.axes(figure, x, 8 + 21 * k, width, 18)
        values = rows[name].to_numpy(float)
        known = np.unique(values)
        step = np.diff(known).min() if len(known) > 1 else 1.0
        offset = 0.5 * step * ((rows.range - 0.5) / (len(limits) - 1) - 0.5)  # separates the ranges
        ax.scatter(rough, values + offset, s=5, c=colour, linewidths=0, clip_on=False)
        _fit(ax, rough, margin, GREEK[name], left)
        ax.set_ylim(known[0] - 0.4 * step, known[-1] + 0.4 * step)
        layout.ticks(ax.yaxis, known, 18)
        ax.tick_params(labelbottom=False)
    ax = layout.axes(figure, x, 92, width, 32)
    half = ((rows.d_cv_high - rows.d_cv_low) / 2).to_numpy()
    for x_, d, error, rgba in zip(rough, rows.d_cv, half, colour, strict=True):
        ax.errorbar(x_, d, error, fmt="o", color=rgba, markersize=2, elinewidth=0.4)
    ax.axhline(0, color="black", linewidth=0.4, zorder=0)
    _fit(ax, rough, margin, "$d$, cross-validated", left)
    ax.set_xlabel(layout.folded("mean roughness of the surface (low: rough, high: flat)", width + 16))


def _fit(ax: Axes, rough: np.ndarray, margin: float, label: str, left: bool) -> None:
    """Set the limits and the label of a panel."""
    ax.set_xlim(rough.min() - margin, rough.max() + margin)
    ax.xaxis.set_major_locator(MaxNLocator(5))
    ax.set_ylabel(label if left else "")


def _gain(ax: Axes, rows: pd.DataFrame, limit: float, left: bool) -> None:
    """Draw d with the choice of near surfaces minus d with that of far ones, per range of n_S."""
    ax.set(xlim=(0, 100), ylim=(-limit, limit), xlabel="$n_S$ (%), middle of the range")
    ax.set_ylabel("gain in $d$" if left else "")
    ax.axhline(0, color="black", linewidth=0.4, zorder=0)
    rows = rows[rows.gain.notna()]
    middle = (rows.n_S_low_percent + rows.n_S_high_percent) / 2
    half = ((rows.gain_high - rows.gain_low) / 2).fillna(0)
    ax.errorbar(middle, rows.gain, half, fmt="none", ecolor="black", elinewidth=0.5, capsize=1.5)
    for related, face in ((True, "black"), (False, "white")):
        selected = (rows.p < SIGNIFICANT) == related
        ax.plot(middle[selected], rows.gain[selected], **GAIN | {"markerfacecolor": face})
