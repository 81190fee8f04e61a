"""Figure 3 of the paper: d over beta, gamma and delta at the largest alpha."""

from __future__ import annotations

from string import ascii_uppercase
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import colormaps, colors
from matplotlib.cm import ScalarMappable
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from scipy.interpolate import PchipInterpolator

from sparsurf.patches.readings import words_of
from sparsurf.recovery.readings import readings_of_columns
from sparsurf.views import layout
from sparsurf.views.layout import PAGE_WIDTH, styled
from sparsurf.views.numbers import share
from sparsurf_study.report.numbers import better_than_uniform, beyond_ranges

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf_study.report.figures.results import Results

BEST: dict[str, Any] = {"marker": "o", "markersize": 4, "markerfacecolor": "white"}
BEST |= {"markeredgewidth": 0.6, "color": "black"}
BEST_OF_ALL: dict[str, Any] = BEST | {"marker": "*", "markersize": 8, "markerfacecolor": "#F0E442"}
N_FINE = 101  # values along each side of an interpolated map
SIDE = 40.0  # mm, of a map


def draw(results: Results) -> Figure:
    """Draw a map for every beta."""
    return figure(results.grid, results.name)


@styled
def figure(grid: pd.DataFrame, name: str = "") -> Figure:
    """Draw d over (gamma, delta) at the largest alpha, interpolated; a map per beta, a row per reading."""
    readings, alpha = readings_of_columns(grid, "d_"), grid.alpha.max()
    grid = grid[grid.alpha == alpha].reset_index(drop=True)
    scale, limits, levels = _scale(pd.concat([grid[f"d_{reading}"] for reading in readings]))
    better = {words_of(reading): better_than_uniform(grid, reading) for reading in readings}
    message = beats_uniform(better, f"combinations with α = {alpha:g}")
    largest = "" if alpha == 1 else " (the largest of the grid)"
    gap = layout.label_width(np.unique(grid.delta))
    side = min(SIDE, (PAGE_WIDTH - 27) / grid.beta.nunique() - gap)
    pitch = side + 20
    head = layout.headed(name, message)
    used = min(PAGE_WIDTH, max(32 + (side + gap) * grid.beta.nunique(), layout.BOLD_LETTER_WIDTH * len(head)))
    figure = layout.sheet(used, 5 + pitch * len(readings), head)
    for row, reading in enumerate(readings):
        y = 1 + pitch * row
        layout.letter(figure, 1, y, ascii_uppercase[row])
        best = _maps(figure, grid, f"d_{reading}", (scale, levels), (12, y + 9), side, gap)
        title = f"{words_of(reading)}, α = {alpha:g}{largest}: {best}"
        layout.text(figure, 6, y + 0.3, title)
    height = pitch * (len(readings) - 1) + side
    bar = figure.colorbar(scale, cax=layout.axes(figure, used - 17, 10, 2.5, height))
    bar.set_label("$d = Z_{tR} - Z_{tS}$ (above 0: better)")
    bar.ax.set_ylim(limits)
    bar.ax.hlines(levels, 0, 1, colors="black", linewidths=0.3)  # of the contours
    marks = {"highest $d$ at this β": BEST, "highest $d$ of all": BEST_OF_ALL}
    handles = [Line2D([], [], **mark, linestyle="", label=label) for label, mark in marks.items()]
    layout.legend(figure, 12, 1 + pitch * len(readings), handles, ncols=2, handletextpad=0.2)
    return figure


def _maps(
    figure: layout.Sheet,
    grid: pd.DataFrame,
    column: str,
    colours: tuple[ScalarMappable, np.ndarray],
    corner: tuple[float, float],
    side: float,
    gap: float,
) -> str:
    """Draw one row of maps from a corner in mm on; return where d is highest."""
    betas, gammas, deltas = (np.unique(grid[name]) for name in ("beta", "gamma", "delta"))
    best = grid.iloc[int(np.nanargmax(grid[column]))] if grid[column].notna().any() else None
    tables = [
        grid[grid.beta == beta].pivot_table(column, "gamma", "delta").reindex(index=gammas, columns=deltas)
        for beta in betas
    ]
    fine_x, fine_y, _ = _interpolated(deltas, gammas, tables[0].to_numpy())
    ends = [(axis[0], axis[-1]) for axis in (fine_x, fine_y)]
    tiles = layout.Tiles(figure, *corner, (1, len(betas)), (side, side), (gap, 0), *ends)
    for k, (beta, table) in enumerate(zip(betas, tables, strict=True)):
        fine = _interpolated(deltas, gammas, table.to_numpy())[2]
        _map(tiles, k, (deltas, gammas), table.to_numpy(), fine, colours)
        evaluated = grid[(grid.beta == beta) & grid[column].notna()]
        if best is not None and len(evaluated):
            top = evaluated.iloc[int(evaluated[column].argmax())]
            mark = (BEST_OF_ALL if top.name == best.name else BEST) | {"clip_on": False, "zorder": 3}
            tiles.ax.plot(*tiles.places(0, k, np.array([top.delta]), np.array([top.gamma])).T, **mark)
        x, _ = tiles.corner(0, k)
        if len(betas) > 1:
            tiles.ax.text(x + side / 2, -1, f"β = {beta:g}", ha="center", va="bottom")
        tiles.ax.text(x + side / 2, side + 5, "δ", ha="center", va="top")
    tiles.ax.text(-7, side / 2, "γ", rotation=90, va="center", ha="right")
    tiles.frame(box=True)
    tiles.ticks(deltas, gammas)
    if best is None:
        return "no value"
    kept = f"{share(best.n_S_percent)} % of the dots"
    kept += ", more than in any range" if best.n_S_percent == beyond_ranges(grid["n_S_percent"]) else ""
    return f"highest at β = {best.beta:g}, γ = {best.gamma:g}, δ = {best.delta:g}, {kept}"


def _map(
    tiles: layout.Tiles,
    k: int,
    knots: tuple[np.ndarray, np.ndarray],
    table: np.ndarray,
    fine: np.ndarray,
    colours: tuple[ScalarMappable, np.ndarray],
) -> None:
    """Draw interpolated colours with contours, and tiny dots at the computed values."""
    extent, (scale, levels) = tiles.extent(0, k), colours
    tiles.ax.imshow(fine, extent=extent, origin="lower", aspect="auto", norm=scale.norm, cmap=scale.cmap)  # type: ignore[arg-type]
    if np.isfinite(fine).any() and np.nanmin(fine) < np.nanmax(fine):
        x, y = np.linspace(*extent[:2], N_FINE), np.linspace(*extent[2:], N_FINE)
        tiles.ax.contour(x, y, fine, levels, colors="black", linewidths=0.3, linestyles="solid")
    row, column = np.nonzero(np.isfinite(table))
    x, y = knots
    tiles.ax.plot(*tiles.places(0, k, x[column], y[row]).T, "k.", markersize=0.8, clip_on=False)
    tiles.ax.set(xlim=tiles.width, ylim=tiles.height)  # which images change


def _scale(values: pd.Series) -> tuple[ScalarMappable, tuple[float, float], np.ndarray]:
    """Return colours (centred at 0 if signs mix), lowest and highest value, and contour levels between them."""
    finite = values[np.isfinite(values)]
    low, high = (finite.min(), finite.max()) if len(finite) else (0.0, 0.0)
    if low == high:
        low, high = low - 0.5, high + 0.5
    levels = np.asarray(MaxNLocator(10).tick_values(low, high))
    norm: colors.Normalize = colors.Normalize(low, high)
    name = "viridis"
    if low < 0 < high:
        norm, name = colors.CenteredNorm(0, max(-low, high)), "RdBu_r"
    return ScalarMappable(norm, colormaps[name]), (low, high), levels[(levels > low) & (levels < high)]


def _interpolated(
    x: np.ndarray, y: np.ndarray, table: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Interpolate `table` (y, x) on fine axes by monotone cubics; a single value is a strip, missing ones take the nearest."""
    fine = []
    for axis, knots in ((1, x), (0, y)):
        pad = 0.0 if len(knots) > 1 else 0.5
        fine.append(np.linspace(knots[0] - pad, knots[-1] + pad, N_FINE))
        if len(knots) > 1 and np.isfinite(table).all():
            table = PchipInterpolator(knots, table, axis=axis)(fine[-1])
        else:
            nearest = np.abs(fine[-1][:, None] - knots).argmin(axis=1)
            table = np.take(table, nearest, axis=axis)
    return fine[0], fine[1], table


def beats_uniform(better: dict[str, tuple[int, int]], unit: str) -> str:
    """Say how many of a `unit` (such as combinations) beat a random subset under each reading."""
    (first, (n_first, total)), *other_readings = better.items()
    clauses = "".join(f", {n or 'none'} {reading}" for reading, (n, _) in other_readings)
    return f"{n_first} of {total} {unit} beat a random subset {first}{clauses}"
