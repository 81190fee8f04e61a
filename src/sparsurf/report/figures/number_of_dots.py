"""Figure 2 of the paper: n_S over alpha, beta, gamma and delta."""

import numpy as np
from matplotlib import colormaps
from matplotlib.lines import Line2D

from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import PAGE, styled

SIMULATED = {"marker": "o", "markersize": 1.8, "linestyle": ""}
ONE = 74.0, 50.0  # mm, the panel of a figure that has one


def draw(results):
    """The panel of the largest alpha and the smallest beta; the title counts all combinations."""
    grid = results.grid
    off = 100 * (grid.n_S - grid.n_S_expected).abs().max() / len(results.surface)
    title = f"drawn and expected $n_S$ of all {len(grid):,} combinations\ndiffer by at most {off:.2g} % of the dots"
    shown = (grid.alpha == grid.alpha.max()) & (grid.beta == grid.beta.min())
    return figure(grid[shown], results.name, title)


@styled
def figure(grid, name="", title=""):
    """n_S against delta, a line per gamma, a panel per (alpha, beta).

    Parameters
    ----------
    grid : pandas.DataFrame
        Columns alpha, beta, gamma, delta, n_S, n_S_percent, n_S_expected, as in grid.csv.
    name, title : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    grid = grid.assign(expected=grid.n_S_expected * grid.n_S_percent / grid.n_S).sort_values("delta")
    alphas, betas, gammas = (np.unique(grid[p]) for p in ("alpha", "beta", "gamma"))
    deltas, shape = np.unique(grid.delta), (len(alphas), len(betas))
    pitch = min(ONE[0] if shape == (1, 1) else 39.0, 164 / len(betas))
    gap = max(3.0, layout.label_width(deltas) - 0.08 * pitch), 3.0
    size = pitch - gap[0], min(ONE[1] if shape == (1, 1) else 31.0, 165 / len(alphas) - 3)
    lines = _handles(gammas)
    key = -(-len(lines) // 4) if shape == (1, 1) else 1 + (len(lines) > 8)  # rows of the legend
    top = 10 + 4 * key + (4 if title else 0)
    wide = max(20 + (size[0] + gap[0]) * shape[1], 72 + 17 * min(6, len(gammas)) if shape != (1, 1) else 0)
    figure = layout.sheet(min(PAGE, wide), top + (size[1] + gap[1]) * shape[0] + 8, name)
    margin = 0.05 * max(np.ptp(deltas), 1)
    tiles = layout.Tiles(
        figure, 12, top, shape, size, gap, (deltas[0] - margin, deltas[-1] + margin), (0, 102)
    )
    for gamma, line in zip(gammas, lines, strict=False):
        _draw(tiles, grid[grid.gamma == gamma], alphas, betas, line.get_color(), len(deltas) == 1)
    tiles.frame(box=False)
    tiles.ticks(deltas, np.array([0, 25, 50, 75, 100] if size[1] > 22 else [0, 50, 100]))
    _name_panels(tiles, alphas, betas)
    layout.text(figure, 12, 1, title)
    layout.legend(
        figure,
        12,
        2 + (8 if title else 0),
        lines,
        ncols=-(-len(lines) // key),
        handlelength=1.5,
        handletextpad=0.4,
    )
    bottom = top + (size[1] + gap[1]) * shape[0]
    layout.text(figure, 2, (top + bottom) / 2, "$n_S$ (% of the dots)", rotation=90, va="center")
    layout.text(figure, 11 + (size[0] + gap[0]) * shape[1] / 2, bottom + 1.5, "δ", ha="center")
    return figure


def _draw(tiles, rows, alphas, betas, colour, alone):
    """One gamma in all panels: what is expected as a line, broken between panels, and what was drawn as dots."""
    expected, drawn = [], []
    for (alpha, beta), own in rows.groupby(["alpha", "beta"]):
        cell = np.searchsorted(alphas, alpha), np.searchsorted(betas, beta)
        expected += [tiles.places(*cell, own.delta, own.expected), [[np.nan, np.nan]]]
        drawn.append(tiles.places(*cell, own.delta, own.n_S_percent))
    dash = {"marker": "_", "markersize": 8} if alone else {}  # no line joins one point
    tiles.ax.plot(*np.concatenate(expected).T, color=colour, clip_on=False, **dash)
    tiles.ax.plot(*np.concatenate(drawn).T, color=colour, clip_on=False, **SIMULATED)


def _name_panels(tiles, alphas, betas):
    """beta above the columns, alpha right of the rows."""
    w, h = tiles.size
    for column, beta in enumerate(betas):
        x, _ = tiles.corner(0, column)
        words = f"α = {alphas[0]:g}, β = {beta:g}" if len(alphas) == len(betas) == 1 else f"β = {beta:g}"
        tiles.ax.text(x + w / 2, -1, words, ha="center", va="bottom")
    for row, alpha in enumerate(alphas):
        x, y = tiles.corner(row, len(betas) - 1)
        if len(alphas) * len(betas) > 1:
            tiles.ax.text(x + w + 1, y + h / 2, f"α = {alpha:g}", rotation=270, va="center")


def _handles(gammas):
    """Entries of the legend: the colours of gamma first."""
    shades = colormaps["viridis"](np.linspace(0, 0.92, len(gammas)))
    lines = [Line2D([], [], color=shade, label=f"γ = {g:g}") for g, shade in zip(gammas, shades, strict=True)]
    lines.append(Line2D([], [], color="black", label="expected"))
    return [*lines, Line2D([], [], color="black", label="drawn", **SIMULATED)]
