"""Figure 4 of the paper: Z by the roughness of the patch, for the sampling and for a random subset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from string import ascii_uppercase
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from sparsurf.patches.readings import words_of
from sparsurf.views import layout
from sparsurf.views.layout import styled
from sparsurf_study.analysis.rough_and_flat import N_BINS
from sparsurf_study.analysis.tables import bin_index, range_limits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sparsurf_study.analysis.rough_and_flat import ByRoughness
    from sparsurf_study.report.figures.results import Results

GAIN_REFERENCES = {
    "Z_empty": ("empty patch", "--"),
    "Z_mean_descriptor": ("mean patch for all", ":"),
    "fresh dots": ("fresh dots", "-."),
}
TOPS_THAT_DIFFER = 1.2  # largest end of an axis of Z over the smallest, above which the figure says so
MIN_PATCHES_OF_BIN = 5  # patches of a bin that is drawn
POINTS_OF_A_CURVE = 20  # points of a curve between two bins that a name is kept away from
# Where the name of a line stands, across the axes.
PLACES_OF_NAMES = {"right": 0.99, "left": 0.01, "center": 0.5}
PANEL = 70.0, 40.0  # mm
PITCH = 57.0  # mm, from panel to panel
CURVES = ("the paper's sampling", layout.SAMPLED), ("random subset", layout.RANDOM)
BAND = "#BBBBBB"  # The colour of a band in the legend.


def draw(results: Results) -> Figure:
    """Draw the figure of one surface and its best combination: Z around kept dots by the roughness of the patch."""
    name = layout.headed(results.name, message(results.rough_and_flat["panels"]))
    return figure(**results.rough_and_flat, name=name)


def content_of_figure(around: Mapping[str, ByRoughness], references: Mapping[str, Any]) -> dict[str, Any]:
    """Collect the panels around kept dots, one for each reading: arguments of `figure`."""
    kept_dots = around["kept dots"]
    panels = [
        (f"around kept dots, {words_of(reading)}", kept_dots.roughness[0], *z[:, 0])
        for reading, z in kept_dots.z.items()
    ]
    return {"panels": panels, "references": references}


def message(panels: Sequence[tuple[str, np.ndarray, np.ndarray, np.ndarray]]) -> str:
    """Say where the median patch of the sampling errs less than that of a random subset: on rough ones, on flat ones."""
    signs = [np.sign(np.nanmedian(z_tr) - np.nanmedian(z_ts)) for *_, z_ts, z_tr in panels]
    better = []
    for kind, flat in (("rough", False), ("flat", True)):
        differences = []
        for _, roughness, z_ts, z_tr in panels:
            side = (np.asarray(roughness) > np.median(roughness)) == flat
            differences.append(np.nanmedian(np.asarray(z_tr)[side]) - np.nanmedian(np.asarray(z_ts)[side]))
        if min(differences) > 0:
            better.append(kind)
        elif max(differences) > 0:
            readings = [title.partition(", ")[2] for title, *_ in panels]
            first, second = (" and ".join(np.array(readings)[np.array(signs) == sign]) for sign in (1, -1))
            if first and second:
                return f"the sampling errs less than a random subset {first}, more {second}"
            return "whether the sampling errs less depends on the roughness"
    if not better:
        return "a random subset errs less everywhere"
    return f"the sampling errs less on {' and '.join(better)} patches"


@styled
def figure(
    panels: Sequence[tuple[str, np.ndarray, np.ndarray, np.ndarray]],
    references: Mapping[str, Any] | None = None,
    bins: int = N_BINS,
    name: str = "",
) -> Figure:
    """Draw Z_tS(j), Z_tR(j) by the roughness of the patch in bins of equal width: the median, and the middle half as a band.

    Panels, one below the other, have a title, then for T test dots roughness, Z_tS(j) and Z_tR(j). References in the range
    are lines.
    """
    figure = layout.sheet(layout.COLUMN, 7 + PITCH * len(panels), name)
    drawn_axes: list[Axes] = []
    for k, (title, roughness, z_ts, z_tr) in enumerate(panels):
        y = 8 + PITCH * k
        layout.letter(figure, 1, y - 1, ascii_uppercase[k])
        layout.text(figure, 5, y - 0.7, title)
        ax = layout.axes(figure, 14, y + 4, *PANEL)
        edges, chosen = _binned(np.asarray(roughness), bins)
        drawn = [
            _curve(ax, edges, chosen, np.asarray(of_dots), label, colour)
            for of_dots, (label, colour) in zip((z_ts, z_tr), CURVES, strict=True)
        ]
        ax.set(xlim=(edges[0], edges[-1]), xlabel="roughness $R_i$ of the patch (low: rough, high: flat)")
        ax.set_ylabel("error $Z$ of a patch")
        ax.set_ylim(bottom=0)
        ax.yaxis.set_major_locator(MaxNLocator(4))
        _lines(ax, references or {}, np.concatenate(drawn, axis=1))
        drawn_axes.append(ax)
    if len(drawn_axes) > 1 and _tops_differ(drawn_axes):
        for ax in drawn_axes:
            ax.set_ylabel("error $Z$ of a patch (scales differ)")
    handles = [Line2D([], [], color=colour, marker="o", label=label) for label, colour in CURVES]
    band = Patch(color=BAND, label="middle half")
    layout.legend(figure, 5, 1.5, [*handles, band], ncols=3, columnspacing=1, handlelength=1.6)
    return figure


def _tops_differ(drawn_axes: Sequence[Axes]) -> bool:
    """Return whether the axes of Z end at so different values that heights cannot be compared."""
    tops = [ax.get_ylim()[1] for ax in drawn_axes]
    return max(tops) > TOPS_THAT_DIFFER * min(tops)


def _curve(
    ax: Axes, edges: np.ndarray, chosen: dict[int, np.ndarray], z: np.ndarray, label: str, colour: str
) -> np.ndarray:
    """Draw the median of each bin with at least `MIN_PATCHES_OF_BIN` values, and a band from the first to the third quartile.

    Return the drawn points of the medians and of the ends of the band, (3, n, 2).
    """
    values = {k: z[dots][np.isfinite(z[dots])] for k, dots in chosen.items()}
    drawn_bins = [k for k, z_of_bin in values.items() if len(z_of_bin) >= MIN_PATCHES_OF_BIN]
    if not drawn_bins:
        return np.empty((3, 0, 2))
    low, middle, high = np.array([np.quantile(values[k], [0.25, 0.5, 0.75]) for k in drawn_bins]).T
    centres = (edges[drawn_bins] + edges[np.array(drawn_bins) + 1]) / 2
    ax.fill_between(centres, low, high, color=colour, alpha=0.22, linewidth=0)
    ax.plot(centres, middle, "o-", color=colour, linewidth=1.4, markersize=3.5, label=label)
    steps = np.linspace(0, len(centres) - 1, POINTS_OF_A_CURVE * len(centres))
    lines = [np.interp(steps, np.arange(len(centres)), values_) for values_ in (centres, middle, low, high)]
    return np.stack([np.stack([lines[0], line], axis=1) for line in lines[1:]])


def _binned(roughness: np.ndarray, bins: int) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    """Return edges of bins of equal width, and the test dots of each bin that has any."""
    edges = range_limits(roughness, bins)
    if edges[0] == edges[-1]:
        edges = edges[0] + np.array([-0.05, 0.05])
    bin_of = bin_index(roughness, edges)
    return edges, {k: np.flatnonzero(bin_of == k) for k in np.unique(bin_of)}


def _lines(ax: Axes, references: Mapping[str, Any], drawn: np.ndarray) -> None:
    """Draw the reference lines that lie in the range, each with its name where it touches the least of what is `drawn`.

    `drawn` are points of the medians and of the ends of the bands, (3, n, 2).
    """
    top, values = ax.get_ylim()[1], {**references, **references.get("floors", {})}
    taken: list[float] = []
    for key, (name, dashes) in GAIN_REFERENCES.items():
        if (y := values.get(key, np.nan)) <= top:
            ax.axhline(y, color="black", linestyle=dashes, linewidth=0.6, zorder=0.5)
            if all(abs(y - other) > 0.09 * top for other in taken):
                taken.append(y)
                _name_line(ax, y, f"{name}, {y:.2f}", drawn)


def _name_line(ax: Axes, y: float, label: str, drawn: np.ndarray) -> None:
    """Write the name of a line above or below it, where it touches the fewest medians, then the fewest bands."""
    name = ax.text(0.99, y, label, transform=ax.get_yaxis_transform(), path_effects=layout.HALO)
    touched: dict[tuple[str, str], tuple[int, int]] = {}
    for side, x in PLACES_OF_NAMES.items():
        for va in ("bottom", "top"):
            name.set(x=x, ha=side, va=va)
            box = name.get_window_extent().transformed(ax.transData.inverted())
            if box.y0 < 0 or box.y1 > ax.get_ylim()[1]:
                continue
            inside = np.all((drawn >= box.min) & (drawn <= box.max), axis=2)
            touched[side, va] = (int(inside[0].sum()), int(inside[1:].sum()))
    side, va = min(touched, key=lambda place: touched[place], default=("right", "bottom"))
    name.set(x=PLACES_OF_NAMES[side], ha=side, va=va)
