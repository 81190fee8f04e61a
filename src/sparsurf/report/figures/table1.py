"""Table I of the paper, each published value upon the range of runs made as published, and the other reading."""

from matplotlib.lines import Line2D

from sparsurf.patches.readings import WRITTEN_READING
from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import RANDOM, SAMPLED, styled
from sparsurf.report.numbers import share

MEASURES = {"d": "d: Z of a uniform subset minus Z of the sampling", "Z_tS": "$Z_{tS}$: error of the subset"}
RUNS = {"color": "#C9CDD2", "linewidth": 5, "solid_capstyle": "round"}
PUBLISHED = {"marker": "D", "markersize": 4, "linestyle": "", "zorder": 3}
OTHER = {
    "marker": "o",
    "markersize": 3.5,
    "linestyle": "",
    "color": RANDOM,
    "markerfacecolor": "none",
    "zorder": 2,
}


@styled
def table1_figure(places, rows, binning="half-open"):
    """The figure, two columns of a journal wide: d on the left, Z_tS on the right, a line for each row of Table I.

    Parameters
    ----------
    places : DataFrame
        See `published_runs.place_of_published`.
    rows : DataFrame
        See `replication.published_rows`.
    binning : str
        Under which the runs chose their winners.
    """
    own = places[places["binning"] == binning].reset_index(drop=True)
    figure = layout.sheet(layout.PAGE, 82)
    panels = [layout.axes(figure, x, 12, 66, 58) for x in (44, 115)]
    for ax, (name, words) in zip(panels, MEASURES.items(), strict=True):
        _panel(ax, own, rows, name)
        ax.set_xlabel(words)
    panels[0].axvline(0, color="black", linewidth=0.5, zorder=0)
    panels[0].set_yticks(range(len(rows)), [_label(row) for _, row in rows.iterrows()])
    panels[1].set_yticks([])
    layout.legend(figure, 44, 3, _handles(own), ncols=4, columnspacing=1.5, handlelength=1.6)
    return figure


def _panel(ax, own, rows, name):
    """One measure: a bar from the lowest to the highest run, the published value, the value as written."""
    for y, row in own.iterrows():
        low, high, said = (row[f"{name}_{key}"] for key in ("lowest", "highest", "published"))
        ax.plot([low, high], [y, y], **RUNS)
        ax.plot([said], [y], color="black" if low <= said <= high else SAMPLED, **PUBLISHED)
    ax.plot(rows[f"{name}_{WRITTEN_READING}"], range(len(rows)), **OTHER)
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)


def _label(row):
    parameters = ", ".join(f"{row[name]:g}" for name in ("alpha", "beta", "gamma", "delta"))
    return f"{share(row['n_S_low_percent'])}–{share(row['n_S_high_percent'])} %   ({parameters})"


def _handles(own):
    n = int(own["n_runs"].max())
    return [
        Line2D([], [], label=f"{n} runs as published", **RUNS),
        Line2D([], [], color="black", label="published", **PUBLISHED),
        Line2D([], [], color=SAMPLED, label="published, outside of the runs", **PUBLISHED),
        Line2D([], [], label="as the paper's text reads", **OTHER),
    ]
