"""Figure 2 of the paper: n_S over alpha, beta, gamma and delta."""

import numpy as np
from matplotlib import colormaps
from matplotlib.lines import Line2D

from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import PAGE, styled

SIMULATED = {"marker": "o", "markersize": 1.8, "linestyle": ""}


def draw(results):
    """The figure of one grid."""
    return figure(results.grid)


@styled
def figure(grid):
    """n_S against delta, a line per gamma, a panel per (alpha, beta).

    Parameters
    ----------
    grid : pandas.DataFrame
        Columns alpha, beta, gamma, delta, n_S, n_S_percent, n_S_expected, as in grid.csv.

    Returns
    -------
    matplotlib.figure.Figure
    """
    expected = grid.n_S_expected * grid.n_S_percent / grid.n_S
    grid = grid.assign(expected=expected).sort_values("delta")
    alphas, betas, gammas = (np.unique(grid[p]) for p in ("alpha", "beta", "gamma"))
    deltas = np.unique(grid.delta)
    width, height = min(40.0, 164 / len(betas)), min(34.0, 168 / len(alphas))
    gap = max(2.0, layout.label_width(deltas) - 0.08 * width)
    colour = dict(zip(gammas, colormaps["viridis"](np.linspace(0, 0.92, len(gammas))), strict=True))
    used = max(19 + width * len(betas), 72 + 17 * min(6, len(gammas)))  # mm, panels or legend
    figure = layout.sheet(min(PAGE, used), 24 + height * len(alphas))
    for row, alpha in enumerate(alphas):
        for column, beta in enumerate(betas):
            ax = layout.axes(figure, 12 + width * column, 13 + height * row, width - gap, height - 3)
            for gamma, line in grid[(grid.alpha == alpha) & (grid.beta == beta)].groupby("gamma"):
                # no line joins one point
                alone = {"marker": "_", "markersize": 8} if len(deltas) == 1 else {}
                ax.plot(line.delta, line.expected, color=colour[gamma], **alone)
                ax.plot(line.delta, line.n_S_percent, color=colour[gamma], clip_on=False, **SIMULATED)
            _frame(ax, deltas, width - gap, height)
            ax.tick_params(labelbottom=row == len(alphas) - 1, labelleft=column == 0)
            if row == 0:
                ax.set_title(f"β = {beta:g}")
            if column == len(betas) - 1:
                ax.text(1.02, 0.5, f"α = {alpha:g}", transform=ax.transAxes, rotation=270, va="center")
    bottom = 13 + height * len(alphas)
    layout.text(figure, 2, (13 + bottom) / 2, "$n_S$ (% of the dots)", rotation=90, va="center")
    layout.text(figure, 11 + width * len(betas) / 2, bottom + 3, "δ", ha="center")
    _key(figure, gammas, colour)
    return figure


def _frame(ax, deltas, width, height):
    """The same limits and ticks for every panel."""
    margin = 0.05 * max(np.ptp(deltas), 1)
    ax.set(xlim=(deltas[0] - margin, deltas[-1] + margin), ylim=(0, 102))
    layout.ticks(ax.xaxis, deltas, width)
    layout.ticks(ax.yaxis, np.array([0, 25, 50, 75, 100] if height > 25 else [0, 50, 100]), height)


def _key(figure, gammas, colour):
    """One legend for all panels, in columns of two."""
    lines = [Line2D([], [], color=colour[g], label=f"γ = {g:g}") for g in gammas]
    lines.append(Line2D([], [], color="black", label="expected (closed form)"))
    lines.append(Line2D([], [], color="black", label="simulated", **SIMULATED))
    rows = 1 if len(lines) <= 8 else 2
    layout.legend(figure, 12, 2, lines, ncols=-(-len(lines) // rows), handlelength=1.5, handletextpad=0.4)
