"""Figure 4 of the paper: a rough and a flat patch, and Z by the roughness of the patch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from string import ascii_uppercase
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colors
from matplotlib.patches import Patch

from sparsurf.patches import islands
from sparsurf.recovery.readings import READINGS
from sparsurf.views import layout, render
from sparsurf.views.layout import styled
from sparsurf.views.numbers import span
from sparsurf_study.analysis.rough_and_flat import N_BINS
from sparsurf_study.analysis.tables import bin_index, range_limits

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from sparsurf.evaluation.prepared_surface import PreparedSurface
    from sparsurf.sampling.combination import Combination
    from sparsurf_study.analysis.rough_and_flat import ByRoughness
    from sparsurf_study.report.figures.results import Results

REFERENCES = {
    "Z_empty": ("empty patch", "--"),
    "Z_mean_descriptor": ("mean patch for all", ":"),
    "fresh dots": ("fresh dots", "-."),
}
BOX_OF_UNIFORM = "#A0A0A0"  # grey, as the median of a black box could not be seen
MIN_VALUES = 5  # of a box plot
PITCH, PICTURE = 61.0, 18.5  # mm, from panel to panel, and side of the picture of a patch


def draw(results: Results) -> Figure:
    """Draw the figure of one surface and its best combination: a rough and a flat patch, and Z around kept dots."""
    name = layout.headed(results.name, message(results.rough_and_flat["panels"]))
    return figure(**results.rough_and_flat, name=name)


def content(
    prepared: PreparedSurface,
    combination: Combination,
    around: Mapping[str, ByRoughness],
    references: Mapping[str, Any],
) -> dict[str, Any]:
    """Collect the panels around kept dots, and cut a rough and a flat patch to show: arguments of `figure`."""
    kept_dots, anywhere = around["kept dots"], around["any dots"]
    panels = [
        (f"around kept dots, {READINGS[reading].words}", kept_dots.roughness[0], *z[:, 0])
        for reading, z in kept_dots.z.items()
    ]
    patches = []
    ranked = anywhere.dots[0][np.argsort(anywhere.roughness[0], kind="stable")]
    for kind, dot in (("rough", ranked[len(ranked) // 20]), ("flat", ranked[-len(ranked) // 20])):
        dots = islands.patch(prepared.index, dot, prepared.patches.r_zernike)
        kept = [np.flatnonzero(np.isin(dots, subset)) for subset in prepared.pair(combination, 0)]
        title = f"{kind} patch, R = {prepared.roughness[dot]:.2f}"
        patches.append((title, prepared.points[dots], prepared.normals[dots], *kept))
    return {"panels": panels, "patches": patches, "references": references}


def message(panels: Sequence[tuple[str, np.ndarray, np.ndarray, np.ndarray]]) -> str:
    """Say where the median patch of the sampling errs less than that of a uniform subset: on rough ones, on flat ones."""
    signs = [np.sign(np.nanmedian(z_tr) - np.nanmedian(z_ts)) for *_, z_ts, z_tr in panels]
    better = []
    for words, flat in (("rough", False), ("flat", True)):
        differences = []
        for _, roughness, z_ts, z_tr in panels:
            side = (np.asarray(roughness) > np.median(roughness)) == flat
            differences.append(np.nanmedian(np.asarray(z_tr)[side]) - np.nanmedian(np.asarray(z_ts)[side]))
        if min(differences) > 0:
            better.append(words)
        elif max(differences) > 0:
            readings = [title.partition(", ")[2] for title, *_ in panels]
            first, second = (" and ".join(np.array(readings)[np.array(signs) == sign]) for sign in (1, -1))
            if first and second:
                return f"the sampling errs less than a uniform subset {first}, more {second}"
            return "whether the sampling errs less depends on the roughness"
    if not better:
        return "a uniform subset errs less everywhere"
    return f"the sampling errs less on {' and '.join(better)} patches"


@styled
def figure(
    panels: Sequence[tuple[str, np.ndarray, np.ndarray, np.ndarray]],
    patches: Sequence[tuple],
    references: dict[str, Any] | None = None,
    bins: int = N_BINS,
    name: str = "",
) -> Figure:
    """Draw a rough and a flat patch, and Z_tS(j), Z_tR(j) by the roughness of the patch in bins of equal width.

    Panels, two in a row, have a title, then for T test dots roughness, Z_tS(j) and Z_tR(j). Patches have a title, points and
    normals (n, 3), and which of these dots the sampling and the uniform subset keep. References in the range are lines.
    """
    top = 46  # mm, of the first panels
    figure = layout.sheet(2 * PITCH, top + 58 * -(-len(panels) // 2), name)
    for k, patch in enumerate(patches):
        layout.letter(figure, 1 + PITCH * k, 1, ascii_uppercase[k])
        _patch(figure, 5 + PITCH * k, 1.3, *patch)
    handles: list[Artist] = [
        Patch(facecolor=layout.SAMPLED, edgecolor="black", label="$Z_{tS}(j)$, sampled"),
        Patch(facecolor=BOX_OF_UNIFORM, edgecolor="black", label="$Z_{tR}(j)$, uniform"),
    ]
    for k, (title, roughness, z_ts, z_tr) in enumerate(panels):
        x, y = PITCH * (k % 2), top + 58 * (k // 2)
        edges, chosen = _binned(np.asarray(roughness), bins)
        layout.letter(figure, 1 + x, y, ascii_uppercase[len(patches) + k])
        n = span([len(dots) for dots in chosen.values()], "{:,}".format)
        title = title.replace(", ", "\n", 1)  # the patches, and below them the reading
        layout.text(figure, 5 + x, y + 0.3, f"{title}\n{n} patches a bin")
        ax = layout.axes(figure, 11 + x, y + 11, PITCH - 15, 37)
        _boxes(ax, edges, chosen, np.asarray(z_ts), np.asarray(z_tr))
        known = [handle.get_label() for handle in handles]
        handles += [line for line in _lines(ax, references or {}) if line.get_label() not in known]
    layout.legend(figure, 5, top - 7, handles, ncols=3, handlelength=1.8)
    return figure


def _patch(
    figure: layout.Sheet,
    x: float,
    y: float,
    title: str,
    points: np.ndarray,
    normals: np.ndarray,
    sampled: np.ndarray,
    random: np.ndarray,
) -> None:
    """Draw a patch whole, sampled and as uniform subset, from the same oblique view."""
    layout.text(figure, x, y, title)
    camera = render.aim(points, render.oblique(points, normals), layout.pixels(PICTURE, PICTURE))
    behind = render.draw_surface(points, normals, render.PALE, camera)
    whole = np.arange(len(points))
    columns = [("whole", whole, layout.WHOLE), ("sampled", sampled, layout.SAMPLED)]
    for k, (name, kept, colour) in enumerate([*columns, ("uniform", random, layout.RANDOM)]):
        kept = np.asarray(kept, int)
        scene = render.draw_dots(behind, points[kept], normals[kept], colors.to_rgb(colour))
        ax = layout.axes(figure, x + PICTURE * k, y + 10, PICTURE, PICTURE)
        layout.show(ax, render.picture(scene), camera, scale_bar=k == 0)
        ax.set_title(f"{name}\n{len(kept)} dots", color=colour)


def _binned(roughness: np.ndarray, bins: int) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    """Return edges of bins of equal width, and the test dots of each bin that has any."""
    edges = range_limits(roughness, bins)
    if edges[0] == edges[-1]:
        edges = edges[0] + np.array([-0.05, 0.05])
    bin_of = bin_index(roughness, edges)
    return edges, {k: np.flatnonzero(bin_of == k) for k in np.unique(bin_of)}


def _boxes(
    ax: Axes, edges: np.ndarray, chosen: dict[int, np.ndarray], z_ts: np.ndarray, z_tr: np.ndarray
) -> None:
    """Draw two box plots per bin, whiskers at most 1.5 times the box; fewer than `MIN_VALUES` values are drawn as dots."""
    width = edges[1] - edges[0]
    for of_dots, colour, side in ((z_ts, layout.SAMPLED, -0.2), (z_tr, BOX_OF_UNIFORM, 0.2)):
        values = [of_dots[dots][np.isfinite(of_dots[dots])] for dots in chosen.values()]
        centres = [edges[k] + (0.5 + side) * width for k in chosen]
        few = np.array([len(z) < MIN_VALUES for z in values])
        alone = [(np.full(len(z), x), z) for z, x, is_few in zip(values, centres, few, strict=True) if is_few]
        if alone:
            ax.plot(*np.concatenate(alone, axis=1), "o", color=colour)
        if not few.all():
            boxed = [z for z, is_few in zip(values, few, strict=True) if not is_few]
            _box_plots(ax, boxed, np.array(centres)[~few], 0.34 * width, colour)
    for edge in edges[1:]:
        ax.axvline(edge, color="#E0E0E0", linewidth=0.4, zorder=0)
    ax.set_xticks(edges, [f"{e:.2f}" if k % 2 == 0 else "" for k, e in enumerate(edges)])
    ax.set(xlim=(edges[0], edges[-1]), xlabel="roughness $R_i$ of the patch (high: flat)")
    ax.set_ylabel("error $Z$ of a patch")
    ax.set_ylim(bottom=0)


def _box_plots(ax: Axes, values: list[np.ndarray], centres: np.ndarray, width: float, colour: str) -> None:
    """Draw box plots with five artists in all; `boxplot` takes six for each box."""
    low, middle, high = np.array([np.quantile(z, [0.25, 0.5, 0.75]) for z in values]).T
    limits = zip(values, low - 1.5 * (high - low), high + 1.5 * (high - low), strict=True)
    ends = [(z[z >= lowest].min(), z[z <= highest].max()) for z, lowest, highest in limits]
    bottom, top = np.array(ends).T
    thin: dict[str, Any] = {"color": "black", "linewidth": 0.5}
    ax.bar(centres, high - low, width, low, facecolor=colour, edgecolor="black", linewidth=0.5)
    ax.hlines(middle, centres - width / 2, centres + width / 2, color="black", linewidth=1)
    ax.vlines(np.tile(centres, 2), np.append(bottom, high), np.append(low, top), **thin)
    left, right = np.tile(centres - width / 4, 2), np.tile(centres + width / 4, 2)
    ax.hlines(np.append(bottom, top), left, right, **thin)
    beyond = [z[(z < a) | (z > b)] for z, (a, b) in zip(values, ends, strict=True)]
    far = np.repeat(centres, [len(z) for z in beyond])
    ax.plot(far, np.concatenate(beyond), ".", markersize=2, color=colour)


def _lines(ax: Axes, references: dict[str, Any]) -> list[Line2D]:
    """Draw the reference lines that lie in the range; return their legend entries."""
    top, values = ax.get_ylim()[1], references | references.get("floors", {})
    return [
        ax.axhline(y, color="black", linestyle=dashes, linewidth=0.6, zorder=0.5, label=f"{words}, {y:.2f}")
        for key, (words, dashes) in REFERENCES.items()
        if (y := values.get(key, np.nan)) <= top
    ]
