"""Mean R_i of every residue against time, and how it spreads."""

import numpy as np
from matplotlib import colormaps, colors
from matplotlib.cm import ScalarMappable
from matplotlib.ticker import MaxNLocator

from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import DARK, PALE, styled
from sparsurf.report.figures.summary_figures import time_axis

LABELS = 14  # residues named along the axis at most
BURIED = "#BBBBBB"


@styled
def draw(over_time, residues):
    """The figure, one column of a journal wide.

    Parameters
    ----------
    over_time : DataFrame
        See `ensemble.apart`.
    residues : DataFrame
        See `residues.over_frames`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    values = over_time.iloc[:, 2:].to_numpy(float)
    time, label = time_axis(over_time)
    n = len(residues)
    figure = layout.sheet(layout.COLUMN, 88)
    scale = ScalarMappable(colors.Normalize(np.nanmin(values), np.nanmax(values)), _colours())
    ax = layout.axes(figure, 15, 6, 40, 60)
    half = np.diff(time).mean() / 2 if len(time) > 1 else 0.5
    extent = (time.iloc[0] - half, time.iloc[-1] + half, n - 0.5, -0.5)
    ax.imshow(
        values.T, aspect="auto", extent=extent, norm=scale.norm, cmap=scale.cmap, interpolation="nearest"
    )
    _name_residues(ax, residues)
    ax.set_xlabel(label)
    ax.xaxis.set_major_locator(MaxNLocator(4))
    layout.letter(figure, 1, 1, "A")
    beside = layout.axes(figure, 61, 6, 24, 60)
    place, mean, sd = np.arange(n), residues["mean_roughness"], residues["sd_roughness"].fillna(0)
    beside.fill_betweenx(place, mean - sd, mean + sd, color=PALE, linewidth=0)
    beside.plot(mean, place, color=DARK, linewidth=0.8)
    beside.set(ylim=(n - 0.5, -0.5), xlabel="mean $R_i$ ± sd")
    beside.xaxis.set_major_locator(MaxNLocator(3))
    beside.set_yticks(ax.get_yticks(), [])
    layout.letter(figure, 57, 1, "B")
    bar = figure.colorbar(scale, cax=layout.axes(figure, 15, 77, 40, 2), orientation="horizontal")
    bar.ax.xaxis.set_major_locator(MaxNLocator(4))
    layout.text(figure, 60, 75.5, "mean $R_i$ of the residue\n(low: rough, high: flat)" + _grey(values))
    return figure


def _colours():
    return colormaps["viridis"].with_extremes(bad=BURIED)


def _grey(values):
    return "\ngrey: buried" if np.isnan(values).any() else ""


def _name_residues(ax, residues):
    """Numbers of some residues, and a line where a chain ends; the chain is named where there are several."""
    chain = residues["chain"].fillna("").to_numpy(str)
    several = len(np.unique(chain)) > 1
    places = np.arange(0, len(residues), -(-len(residues) // LABELS))
    names = [
        f"{chain[k]} {residues['residue'].iloc[k]}" if several else residues["residue"].iloc[k]
        for k in places
    ]
    ax.set_yticks(places, names)
    ax.set_ylabel("residue")
    for end in np.flatnonzero(chain[1:] != chain[:-1]):
        ax.axhline(end + 0.5, color="white", linewidth=0.8)
