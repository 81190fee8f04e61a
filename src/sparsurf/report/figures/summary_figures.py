"""Figures of a whole run: best parameters against mean roughness, and one combination over a trajectory."""

from string import ascii_uppercase

import numpy as np
from matplotlib import colormaps, colors
from matplotlib.cm import ScalarMappable
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from sparsurf.recovery.readings import READINGS, readings_in
from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import DARK, PAGE, PALE, styled
from sparsurf.sampling.combination import PARAMETERS

GREEK = dict(zip(PARAMETERS, "αβγδ", strict=True))
SIGNIFICANT = 0.05
GAIN = {"marker": "o", "markersize": 3.5, "linestyle": "", "color": "black", "markeredgewidth": 0.6}
SMOOTH = 20  # moving means are taken over one frame in so many


@styled
def summary_figure(summary, relations):
    """Best parameters and their d against mean roughness, and what a choice by mean roughness gains.

    Parameters
    ----------
    summary : pandas.DataFrame
        See `summary.summary_table`.
    relations : pandas.DataFrame
        See `summary.relation_table`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    readings = readings_in(summary.reading.unique())
    pitch = 160 / max(2, len(readings))
    width = pitch - 16
    limits = np.append(relations.n_S_low_percent[: relations.range.max()], relations.n_S_high_percent.max())
    norm = colors.BoundaryNorm(limits, 256) if np.ptp(limits) > 0 else colors.Normalize()
    scale = ScalarMappable(norm, colormaps["viridis"])
    compared = relations.gain.notna().any()  # else there are too few surfaces to choose from: no empty panels
    figure = layout.sheet(PAGE, 187 if compared else 137)
    widest = max(0.01, np.nanmax(np.append(relations[["gain_low", "gain_high"]].abs().to_numpy(), 0)))
    for k, reading in enumerate(readings):
        rows = summary[(summary.reading == reading) & summary.d.notna()]
        x = 16 + pitch * k
        layout.letter(figure, x - 15, 1, ascii_uppercase[k])
        layout.text(figure, x - 10, 1.3, layout.folded(READINGS[reading].words, pitch - 5))
        _parameters(figure, x, width, rows, scale, limits, left=k == 0)
        if compared:
            layout.letter(figure, x - 15, 137, ascii_uppercase[len(readings) + k])
            words = "choice of the nearest surfaces against the farthest"
            layout.text(figure, x - 10, 137.3, layout.folded(words, pitch - 5))
            ax = layout.axes(figure, x, 144, width, 26)
            _gain(ax, relations[relations.reading == reading], 1.1 * widest, left=k == 0)
    if compared:
        _gain_key(figure)
    bar = figure.colorbar(scale, cax=layout.axes(figure, 169, 8, 2.5, 116), spacing="proportional")
    bar.set_ticks(limits, labels=[f"{limit:.0f}" for limit in limits])
    bar.set_label("range of $n_S$ (% of the dots)")
    return figure


def _gain_key(figure):
    dots = {"parameters correlate with mean roughness, p < 0.05": "black", "no such correlation": "white"}
    handles = [
        Line2D([], [], **GAIN | {"markerfacecolor": face}, label=words) for words, face in dots.items()
    ]
    layout.legend(figure, 16, 181.5, handles, ncols=2)


def _parameters(figure, x, width, rows, scale, limits, left):
    """Alpha, beta, gamma, delta and d of the winners, one below the other, over the same mean roughness."""
    colour = scale.to_rgba(((limits[:-1] + limits[1:]) / 2)[rows.range.to_numpy() - 1])
    rough = rows.mean_roughness.to_numpy()
    margin = 0.06 * np.ptp(rough) + 0.002
    for k, name in enumerate(PARAMETERS):
        ax = layout.axes(figure, x, 8 + 21 * k, width, 18)
        values = rows[name].to_numpy(float)
        known = np.unique(values)
        step = np.diff(known).min() if len(known) > 1 else 1.0
        aside = 0.5 * step * ((rows.range - 0.5) / (len(limits) - 1) - 0.5)  # ranges side by side, not on top
        ax.scatter(rough, values + aside, s=5, c=colour, linewidths=0, clip_on=False)
        _fit(ax, rough, margin, GREEK[name], left)
        ax.set_ylim(known[0] - 0.4 * step, known[-1] + 0.4 * step)
        layout.ticks(ax.yaxis, known, 18)
        ax.tick_params(labelbottom=False)
    ax = layout.axes(figure, x, 92, width, 32)
    half = ((rows.d_held_out_high - rows.d_held_out_low) / 2).to_numpy()
    for place, d, error, own in zip(rough, rows.d_held_out, half, colour, strict=True):
        ax.errorbar(place, d, error, fmt="o", color=own, markersize=2, elinewidth=0.4)
    ax.axhline(0, color="black", linewidth=0.4, zorder=0)
    _fit(ax, rough, margin, "$d$, held out", left)
    ax.set_xlabel(layout.folded("mean roughness of the surface (low: rough, high: flat)", width + 16))


def _fit(ax, rough, margin, label, left):
    ax.set_xlim(rough.min() - margin, rough.max() + margin)
    ax.xaxis.set_major_locator(MaxNLocator(5))
    ax.set_ylabel(label if left else "")


def _gain(ax, rows, limit, left):
    """d with the choice of near surfaces minus d with that of far ones, per range of n_S."""
    ax.set(xlim=(0, 100), ylim=(-limit, limit), xlabel="$n_S$ (%), middle of the range")
    ax.set_ylabel("gain in $d$" if left else "")
    ax.axhline(0, color="black", linewidth=0.4, zorder=0)
    rows = rows[rows.gain.notna()]
    if rows.empty:
        ax.text(50, 0.3 * limit, "needs 3 proteins or more", ha="center", va="bottom")
    middle = (rows.n_S_low_percent + rows.n_S_high_percent) / 2
    half = ((rows.gain_high - rows.gain_low) / 2).fillna(0)
    ax.errorbar(middle, rows.gain, half, fmt="none", ecolor="black", elinewidth=0.5, capsize=1.5)
    for related, face in ((True, "black"), (False, "white")):
        these = (rows.p < SIGNIFICANT) == related
        ax.plot(middle[these], rows.gain[these], **GAIN | {"markerfacecolor": face})


@styled
def ensemble_figure(table, combination):
    """n_S, mean roughness and d of one combination over time, and how they are distributed.

    Parameters
    ----------
    table : pandas.DataFrame
        See `ensemble.follow`.
    combination : sequence of 4 floats

    Returns
    -------
    matplotlib.figure.Figure
    """
    panels = {"n_S_percent": "$n_S$ (% of the dots)", "mean_roughness": "mean roughness"}
    panels |= {f"d_{r}": "$d = Z_{tR} - Z_{tS}$" for r in readings_in(table, "d_")}
    time, label = time_axis(table)
    window = (len(table) // SMOOTH) | 1 if len(table) >= 3 * SMOOTH else 0  # odd
    figure = layout.sheet(PAGE, 18 + 32 * len(panels))
    for k, (column, name) in enumerate(panels.items()):
        y = 12 + 32 * k
        layout.letter(figure, 1, y - 5, ascii_uppercase[k])
        ax = layout.axes(figure, 15, y, 122, 25)
        _over_time(ax, time, table[column], window)
        ax.set_ylabel(name)
        ax.tick_params(labelbottom=k == len(panels) - 1)
        reading = column.removeprefix("d_")
        if reading in READINGS:
            layout.text(figure, 15, y - 4.7, READINGS[reading].words)
        error = table[f"d_se_{reading}"].mean() if reading in READINGS else np.nan
        _distribution(layout.axes(figure, 142, y, 30, 25), table[column], ax.get_ylim(), error)
    ax.set_xlabel(label)
    _ensemble_key(figure, combination, window)
    return figure


def time_axis(table):
    """Times, in the unit that reads best, or numbers of frames where there are none."""
    time = table.time_ps
    if time.isna().any():
        return table.frame, "frame"
    return (time / 1000, "time (ns)") if time.max() >= 10_000 else (time, "time (ps)")


def _over_time(ax, time, values, window):
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


def _distribution(ax, values, limits, error):
    """How often each value occurs, on the scale of the panel to the left."""
    bins = min(30, 4 + int(np.sqrt(len(values))))
    ax.hist(values, bins=np.linspace(*limits, bins + 1), orientation="horizontal", color=PALE)
    sd = values.std(ddof=0)
    decimals = int(np.clip(1 - np.floor(np.log10(sd)), 0, 6)) if sd > 0 else 2  # two figures of the sd
    words = f"mean {values.mean():.{decimals}f}, sd {sd:.{decimals}f}".replace("-", "−")
    ax.set(ylim=limits, title=words, xticks=[], yticks=[])
    ax.spines["bottom"].set_visible(False)
    if np.isfinite(error):
        place = 1.05 * ax.get_xlim()[1]
        ax.errorbar(place, values.mean(), error, color="black", elinewidth=0.8, capsize=2, clip_on=False)


def _ensemble_key(figure, combination, window):
    text = ", ".join(
        f"{GREEK[name]} = {value:g}" for name, value in zip(PARAMETERS, combination, strict=True)
    )
    handles = [Line2D([], [], color=PALE if window else DARK, label="each frame")]
    if window:
        handles.append(Line2D([], [], color=DARK, linewidth=1.2, label=f"moving mean, {window} frames"))
    handles.append(
        Line2D(
            [],
            [],
            color="black",
            marker="|",
            markersize=6,
            linestyle="",
            label="mean standard error of a frame's $d$",
        )
    )
    layout.text(figure, 15, 1.5, text)
    layout.legend(figure, 62, 1.5, handles, ncols=3)
