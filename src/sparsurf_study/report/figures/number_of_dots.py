"""Figure 2 of the paper: n_S over alpha, beta, gamma and delta."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.lines import Line2D

from sparsurf.views import layout
from sparsurf.views.layout import PAGE_WIDTH, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf_study.report.figures.results import Results

SIMULATED_STYLE: dict[str, Any] = {"marker": "o", "markersize": 1.8, "linestyle": ""}
SINGLE_PANEL = 74.0, 50.0  # mm, of a figure with one panel


def draw(results: Results) -> Figure:
    """Draw n_S of every combination."""
    return figure(results.grid, results.name)


@styled
def figure(grid: pd.DataFrame, name: str = "") -> Figure:
    """Draw n_S against delta, a line per gamma, a panel per (alpha, beta)."""
    grid = grid.assign(expected=grid.n_S_expected * grid.n_S_percent / grid.n_S).sort_values("delta")
    alphas, betas, gammas = (np.unique(grid[p]) for p in ("alpha", "beta", "gamma"))
    deltas, shape = np.unique(grid.delta), (len(alphas), len(betas))
    pitch = min(SINGLE_PANEL[0] if shape == (1, 1) else 39.0, 164 / len(betas))
    gap = max(3.0, layout.label_width(deltas) - 0.08 * pitch), 3.0
    size = pitch - gap[0], min(SINGLE_PANEL[1] if shape == (1, 1) else 31.0, 165 / len(alphas) - 3)
    lines = _handles(gammas)
    key = -(-len(lines) // 4) if shape == (1, 1) else 1 + (len(lines) > 8)  # rows of the legend
    top = 10 + 4 * key
    wide = max(20 + (size[0] + gap[0]) * shape[1], 72 + 17 * min(6, len(gammas)) if shape != (1, 1) else 0)
    figure = layout.sheet(min(PAGE_WIDTH, wide), top + (size[1] + gap[1]) * shape[0] + 8, name)
    margin = 0.05 * max(np.ptp(deltas), 1)
    tiles = layout.Tiles(
        figure, 12, top, shape, size, gap, (deltas[0] - margin, deltas[-1] + margin), (0, 102)
    )
    for gamma, line in zip(gammas, lines, strict=False):
        _draw(tiles, grid[grid.gamma == gamma], alphas, betas, line.get_color(), len(deltas) == 1)
    tiles.frame(box=False)
    tiles.ticks(deltas, np.array([0, 25, 50, 75, 100] if size[1] > 22 else [0, 50, 100]))
    _name_panels(tiles, alphas, betas)
    columns = -(-len(lines) // key)
    layout.legend(figure, 12, 2, lines, ncols=columns, handlelength=1.5, handletextpad=0.4)
    bottom = top + (size[1] + gap[1]) * shape[0]
    layout.text(figure, 2, (top + bottom) / 2, "$n_S$ (% of the dots)", rotation=90, va="center")
    layout.text(figure, 11 + (size[0] + gap[0]) * shape[1] / 2, bottom + 1.5, "δ", ha="center")
    return figure


def _draw(
    tiles: layout.Tiles, rows: pd.DataFrame, alphas: np.ndarray, betas: np.ndarray, colour: Any, alone: bool
) -> None:
    """Draw one gamma in all panels: the expected n_S as a line, interrupted between panels, the drawn n_S as dots."""
    expected, drawn = [], []
    for (alpha, beta), cell in rows.groupby(["alpha", "beta"]):
        row, column = np.flatnonzero(alphas == alpha)[0], np.flatnonzero(betas == beta)[0]
        delta = cell.delta.to_numpy()
        expected += [tiles.places(row, column, delta, cell.expected.to_numpy()), np.full((1, 2), np.nan)]
        drawn.append(tiles.places(row, column, delta, cell.n_S_percent.to_numpy()))
    dash: dict[str, Any] = {"marker": "_", "markersize": 8} if alone else {}  # a single point has no line
    tiles.ax.plot(*np.concatenate(expected).T, color=colour, clip_on=False, **dash)
    tiles.ax.plot(*np.concatenate(drawn).T, color=colour, clip_on=False, **SIMULATED_STYLE)


def _name_panels(tiles: layout.Tiles, alphas: np.ndarray, betas: np.ndarray) -> None:
    """Write beta above the columns, alpha right of the rows."""
    w, h = tiles.size
    for column, beta in enumerate(betas):
        x, _ = tiles.corner(0, column)
        title = f"α = {alphas[0]:g}, β = {beta:g}" if len(alphas) == len(betas) == 1 else f"β = {beta:g}"
        tiles.ax.text(x + w / 2, -1, title, ha="center", va="bottom")
    for row, alpha in enumerate(alphas):
        x, y = tiles.corner(row, len(betas) - 1)
        if len(alphas) * len(betas) > 1:
            tiles.ax.text(x + w + 1, y + h / 2, f"α = {alpha:g}", rotation=270, va="center")


def _handles(gammas: np.ndarray) -> list[Line2D]:
    """Return the entries of the legend: the colours of gamma first."""
    shades = colormaps["viridis"](np.linspace(0, 0.92, len(gammas)))
    lines = [Line2D([], [], color=shade, label=f"γ = {g:g}") for g, shade in zip(gammas, shades, strict=True)]
    lines.append(Line2D([], [], color="black", label="expected"))
    return [*lines, Line2D([], [], color="black", label="drawn", **SIMULATED_STYLE)]
