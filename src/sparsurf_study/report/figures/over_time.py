"""Figures of a trajectory frame by frame: one combination, and the roughness of the residues."""

from __future__ import annotations

from collections.abc import Sequence
from string import ascii_uppercase
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import colormaps, colors
from matplotlib.cm import ScalarMappable
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from sparsurf import registry
from sparsurf.recovery.readings import readings_of_columns
from sparsurf.surfaces.formats.colours import ROUGHNESS_LIMITS
from sparsurf.views import layout
from sparsurf.views.layout import DARK, PAGE_WIDTH, PALE, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WINDOWS_OF_TRAJECTORY = 20  # per trajectory; the moving mean is over one
MAX_RESIDUE_LABELS = 14
BURIED_COLOUR = "#BBBBBB"


@styled
def ensemble_figure(table: pd.DataFrame, combination: Sequence[float], name: str = "") -> Figure:
    """Draw n_S, mean roughness and d of one combination over time, and their distributions."""
    table = table.sort_values("frame", ignore_index=True)
    panels = {"n_S_percent": "$n_S$ (% of the dots)", "mean_roughness": "mean roughness"}
    panels |= {f"d_{r}": "$d = Z_{tR} - Z_{tS}$" for r in readings_of_columns(table, "d_")}
    time, unit = time_axis(table)
    # Odd, so that a running mean is centred on its frame
    window = (len(table) // WINDOWS_OF_TRAJECTORY) | 1 if len(table) >= 3 * WINDOWS_OF_TRAJECTORY else 0
    figure = layout.constrained(PAGE_WIDTH, 18 + 32 * len(panels), name)
    rows = figure.subplots(len(panels), 2, width_ratios=[4, 1], squeeze=False)
    for letter, (ax, side), (column, label) in zip(ascii_uppercase, rows, panels.items(), strict=False):
        reading = registry.TABLE["reading"].get(column.removeprefix("d_"))
        layout.panel_title(ax, letter, reading.label if reading else "")
        _over_time(ax, time, table[column], window)
        ax.set_ylabel(label)
        error = table[column.replace("d_", "d_se_")].mean() if reading else np.nan
        _distribution(side, table[column], ax.get_ylim(), error)
    for ax in rows[:-1, 0]:
        ax.tick_params(labelbottom=False)
    rows[-1, 0].set_xlabel(unit)
    title = ", ".join(f"{greek} = {value:g}" for greek, value in zip("αβγδ", combination, strict=True))
    handles = [Line2D([], [], color=PALE if window else DARK, label="each frame")]
    if window:
        handles.append(Line2D([], [], color=DARK, linewidth=1.2, label=f"moving mean, {window} frames"))
    bar: dict[str, Any] = {"color": "black", "marker": "|", "markersize": 6, "linestyle": ""}
    handles.append(Line2D([], [], **bar, label="mean standard error of a frame's $d$"))
    figure.legend(handles=handles, loc="outside lower left", ncols=3, title=title, alignment="left")
    return layout.fix_layout(figure)


def time_axis(table: pd.DataFrame) -> tuple[pd.Series, str]:
    """Return times in a suitable unit, or numbers of frames if the times are unknown."""
    time = table.time_ps
    if time.isna().any():
        return table.frame, "frame"
    return (time / 1000, "time (ns)") if time.max() >= 10_000 else (time, "time (ps)")


def _over_time(ax: Axes, time: pd.Series, values: pd.Series, window: int) -> None:
    """Draw values over time, pale below their moving mean if there is a window."""
    ax.plot(
        time, values, color=PALE if window else DARK, linewidth=0.4, marker="." if len(time) < 100 else ""
    )
    if window:
        mean = values.rolling(window, center=True, min_periods=window // 2 + 1).mean()
        ax.plot(time, mean, color=DARK, linewidth=1.0)
    if values.min() < 0 < values.max():
        ax.axhline(0, color="black", linewidth=0.4, zorder=0)
    ax.margins(0.01, 0.1)
    ax.yaxis.set_major_locator(MaxNLocator(4))
    if len(time) == 1:  # limits around one point would be too close for labels
        ax.set(xlim=(time.iloc[0] - 1, time.iloc[0] + 1), ylim=(values.iloc[0] - 1, values.iloc[0] + 1))


def _distribution(ax: Axes, values: pd.Series, limits: tuple[float, float], error: float) -> None:
    """Draw the distribution of values on the scale of the panel to the left."""
    bins = min(30, 4 + int(np.sqrt(len(values))))
    ax.hist(values, bins=np.linspace(*limits, bins + 1).tolist(), orientation="horizontal", color=PALE)
    sd = values.std(ddof=1)
    decimals = int(np.clip(1 - np.floor(np.log10(sd)), 0, 6)) if sd > 0 else 2  # two digits of the sd
    title = f"mean {values.mean():.{decimals}f}" + ("" if np.isnan(sd) else f", sd {sd:.{decimals}f}")
    ax.set(ylim=limits, title=title.replace("-", "−"), xticks=[], yticks=[])
    ax.spines["bottom"].set_visible(False)
    if np.isfinite(error):
        right = 1.05 * ax.get_xlim()[1]
        ax.errorbar(right, values.mean(), error, color="black", elinewidth=0.8, capsize=2, clip_on=False)


@styled
def residues_figure(over_time: pd.DataFrame, residues: pd.DataFrame, name: str = "") -> Figure:
    """Draw mean R_i of every residue (a column of `over_time`) against time, and its mean and standard deviation."""
    over_time = over_time.sort_values("frame", ignore_index=True)
    values = over_time.iloc[:, 2:].to_numpy(float)
    time, label = time_axis(over_time)
    n = len(residues)
    figure = layout.sheet(layout.COLUMN, 97, name)
    colours = colormaps["viridis"].with_extremes(bad=BURIED_COLOUR)
    scale = ScalarMappable(colors.Normalize(*ROUGHNESS_LIMITS), colours)
    ax = layout.axes(figure, 15, 6, 40, 60)
    half = np.diff(time).mean() / 2 if len(time) > 1 else 0.5
    extent = (time.iloc[0] - half, time.iloc[-1] + half, n - 0.5, -0.5)
    shown: dict[str, Any] = {"norm": scale.norm, "cmap": scale.cmap, "interpolation": "nearest"}
    ax.imshow(values.T, aspect="auto", extent=extent, **shown)
    _name_residues(ax, residues)
    ax.set_xlabel(label)
    ax.xaxis.set_major_locator(MaxNLocator(4))
    layout.letter(figure, 1, 1, "A")
    profile = layout.axes(figure, 61, 6, 24, 60)
    position, mean, sd = np.arange(n), residues["mean_roughness"], residues["sd_roughness"].fillna(0)
    profile.fill_betweenx(position, mean - sd, mean + sd, color=PALE, linewidth=0)
    profile.plot(mean, position, color=DARK, linewidth=0.8)
    profile.set(ylim=(n - 0.5, -0.5), xlabel="mean $R_i$ ± sd")
    profile.xaxis.set_major_locator(MaxNLocator(3))
    profile.set_yticks(ax.get_yticks(), [])
    layout.letter(figure, 57, 1, "B")
    bar = figure.colorbar(
        scale, cax=layout.axes(figure, 15, 76.5, 40, 2), orientation="horizontal", extend="both"
    )
    bar.ax.xaxis.set_major_locator(MaxNLocator(4))
    grey = "\ngrey: buried" if np.isnan(values).any() else ""
    bar.set_label("mean $R_i$ of the residue\n(low: rough, high: flat)" + grey)
    return figure


def _name_residues(ax: Axes, residues: pd.DataFrame) -> None:
    """Label some residues, with the chain if there are several, and draw a line at the end of each chain."""
    chain = residues["chain"].fillna("").to_numpy(str)
    several = len(np.unique(chain)) > 1
    positions = np.arange(0, len(residues), -(-len(residues) // MAX_RESIDUE_LABELS))
    names = [
        f"{chain[k]} {residues['residue'].iloc[k]}" if several else residues["residue"].iloc[k]
        for k in positions
    ]
    ax.set_yticks(positions, names)
    ax.set_ylabel("residue")
    for end in np.flatnonzero(chain[1:] != chain[:-1]):
        ax.axhline(end + 0.5, color="white", linewidth=0.8)
