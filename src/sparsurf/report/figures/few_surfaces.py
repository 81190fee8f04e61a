"""Best parameters and their d against n_S, for a run of so few surfaces that nothing can be said of roughness."""

from string import ascii_uppercase

import numpy as np
from matplotlib.lines import Line2D

from sparsurf.recovery.readings import READINGS, readings_in
from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import PAGE, styled
from sparsurf.report.figures.summary_figures import GREEK

FEW = 3  # surfaces, from which on parameters are drawn against mean roughness
MARKERS = "os^"


@styled
def draw(summary):
    """The figure: the winner of every range of n_S, one colour and mark for each surface.

    Parameters
    ----------
    summary : pandas.DataFrame
        See `summary.summary_table`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    readings = readings_in(summary.reading.unique())
    pitch = (PAGE - 3) / max(2, len(readings))
    surfaces = list(summary.groupby(["protein", "conformation"], sort=False))
    figure = layout.sheet(PAGE, 142)
    for k, reading in enumerate(readings):
        x = 16 + pitch * k
        layout.letter(figure, x - 15, 1, ascii_uppercase[k])
        layout.text(figure, x - 10, 1.3, layout.folded(READINGS[reading].words, pitch - 5))
        panels = _panels(figure, x, pitch - 18)
        winners = summary[(summary.reading == reading) & summary.d.notna()]
        for s, (place, _) in enumerate(surfaces):
            own = (winners.protein == place[0]) & (winners.conformation == place[1])
            _surface(panels, winners[own], s)
        for panel, parameter in zip(panels, GREEK, strict=False):
            known = np.unique(winners[parameter])
            layout.ticks(panel.yaxis, known, 18)
            panel.set_ylim(known[0] - 0.2 * (np.ptp(known) or 1), known[-1] + 0.2 * (np.ptp(known) or 1))
        for panel, words in zip(panels, (*GREEK.values(), "$d$, held out"), strict=True):
            panel.set_ylabel(words if k == 0 else "")
    handles = [
        Line2D(
            [],
            [],
            marker=MARKERS[s],
            color=layout.PALETTE[s],
            label=f"{name[0]}/{name[1]}, mean roughness {r:.2f}",
        )
        for s, (name, r) in enumerate((name, rows.mean_roughness.iloc[0]) for name, rows in surfaces)
    ]
    layout.legend(figure, 16, 136, handles, ncols=2)
    return figure


def _panels(figure, x, width):
    """Five axes, one below the other, over the same n_S."""
    panels = [layout.axes(figure, x, 8 + 21 * row, width, 18 if row < 4 else 32) for row in range(5)]
    for panel in panels:
        panel.set_xlim(0, 100)
        panel.tick_params(labelbottom=panel is panels[-1])
    panels[-1].set_xlabel("$n_S$ (% of the dots)")
    panels[-1].axhline(0, color="black", linewidth=0.4, zorder=0)
    return panels


def _surface(panels, rows, s):
    """The winners of one surface, number s."""
    rows = rows.sort_values("n_S_percent")
    style = {"color": layout.PALETTE[s], "marker": MARKERS[s], "linewidth": 0.6, "clip_on": False}
    for panel, name in zip(panels, GREEK, strict=False):
        panel.plot(rows.n_S_percent, rows[name], **style)
    panels[-1].plot(rows.n_S_percent, rows.d_held_out, **style)
