"""Figures of the study, ready for print: arrays and tables in, matplotlib figures out.

Figures 1 to 5 are those of the paper; 2 and 3 stand in `grid_figures`.
"""

from string import ascii_uppercase
from textwrap import fill

import numpy as np
from matplotlib import colormaps, colors, patheffects
from matplotlib.cm import ScalarMappable
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from sparsurf import page, render
from sparsurf.grid_figures import figure2, figure3
from sparsurf.page import READINGS, save, styled

__all__ = ["figure1", "figure2", "figure3", "figure4", "figure5", "frames_projection", "save"]

SAMPLED, RANDOM, WHOLE = "#D55E00", "#0072B2", "#4D4D4D"  # vermillion and blue of Okabe and Ito; grey
YARDSTICKS = {"empty_patch": ("empty patch", "--"), "null_model": ("null model", ":")}
NAMED = 24  # more conformations than this are not named in the projection
FEW = 5  # values that a box plot needs at least
COMPONENTS = 10  # shown in the panel of explained variance


@styled
def frames_projection(projection, labels, chosen, names, explained, silhouettes):
    """Frames in the plane of the first two principal components, explained variance and silhouette.

    Parameters
    ----------
    projection : (F, k) float64
        Å.
    labels : (F,) int
        Cluster of each frame.
    chosen : (C,) int
        Frames that became conformations.
    names : (C,) str
    explained : (k,) float64
        Share of the variance of each component, 0..1; may be empty.
    silhouettes : dict
        Mean silhouette for each number of clusters K; may be empty.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = page.sheet(page.PAGE, 66)
    plane = np.column_stack([projection, np.zeros((len(projection), 2))])[:, :2]
    ax = page.axes(figure, 14, 7, 69, 49)
    _clusters(ax, plane, labels, np.asarray(chosen, int), names, explained)
    page.letter(figure, 1, 1, "A")
    if len(explained):
        _explained(page.axes(figure, 101, 7, 32, 49), 100 * np.asarray(explained)[:COMPONENTS])
        page.letter(figure, 87, 1, "B")
    if len(silhouettes):
        _silhouettes(page.axes(figure, 149, 7, 32, 49), silhouettes, len(np.unique(labels)))
        page.letter(figure, 137, 1, "C")
    return figure


def _clusters(ax, plane, labels, chosen, names, explained):
    colour = np.array(page.PALETTE)[np.unique(labels, return_inverse=True)[1] % len(page.PALETTE)]
    ax.scatter(*plane.T, s=5, c=colour, alpha=0.5, linewidths=0, rasterized=True)
    ax.scatter(*plane[chosen].T, s=22, c=colour[chosen], edgecolors="black", linewidths=0.8, zorder=3)
    share = [f", {100 * e:.0f} % of the variance" for e in explained[:2]] + ["", ""]
    ax.set(xlabel=f"PC 1 (Å){share[0]}", ylabel=f"PC 2 (Å){share[1]}")
    ax.set_title("colours: clusters, ringed: chosen frames")
    ax.margins(0.1)
    if len(names) <= NAMED:
        _name_points(ax, plane[chosen], names)


def _name_points(ax, points, names):
    """Write each name at the nearest place that no other name and no chosen point takes."""
    renderer = ax.figure.canvas.get_renderer()
    inside, dots = ax.get_window_extent(renderer), ax.transData.transform(points)
    places = [(far, angle) for far in (8, 14, 22, 32) for angle in np.radians(np.arange(45, 405, 45))]
    taken = []
    for point, name in zip(points, names, strict=True):
        for far, angle in places:
            words = _annotate(ax, name, point, far, angle)
            box = words.get_window_extent(renderer)
            inner = inside.fully_containsx(box.x0) and inside.fully_containsx(box.x1)
            inner = inner and inside.fully_containsy(box.y0) and inside.fully_containsy(box.y1)
            if inner and not box.count_contains(dots) and not box.count_overlaps(taken):
                taken.append(box)
                break
            words.remove()  # where no place is free, no name is better than two on top of each other


def _annotate(ax, name, point, far, angle):
    """Name at `far` typographic points from a point, with a leader where it is not the closest place."""
    leader = {"arrowstyle": "-", "linewidth": 0.4, "shrinkA": 3, "shrinkB": 2} if far > 8 else None
    words = ax.annotate(
        name,
        point,
        (far * np.cos(angle), far * np.sin(angle)),
        textcoords="offset points",
        ha="center",
        va="center",
        arrowprops=leader,
        zorder=4,
    )
    words.set_path_effects([patheffects.withStroke(linewidth=1.5, foreground="white")])
    return words


def _silhouettes(ax, silhouettes, chosen):
    k = sorted(silhouettes)
    ax.plot(k, [silhouettes[n] for n in k], "o-", color="black", markerfacecolor="white")
    if chosen in silhouettes:
        ax.plot([chosen], [silhouettes[chosen]], "o", color=SAMPLED, markersize=5)
        ax.set_title(f"K = {chosen} chosen", color=SAMPLED)
    ax.set(xlabel="number of clusters K", ylabel="mean silhouette")
    ax.margins(0.08, 0.12)
    page.ticks(ax.xaxis, np.arange(k[0], k[-1] + 1), 32)


def _explained(ax, percent):
    k = np.arange(1, len(percent) + 1)
    ax.bar(k, percent, color=["#7F7F7F" if n <= 2 else "#D9D9D9" for n in k], edgecolor="black", label="each")
    ax.plot(k, np.cumsum(percent), "ko-", markerfacecolor="white", clip_on=False, label="cumulative")
    ax.set(xlabel="principal component", ylabel="explained variance (%)", ylim=(0, 100))
    ax.set_xlim(0.3, max(len(k), 3) + 0.7)
    ax.legend(
        loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, borderpad=0, handlelength=1.2, columnspacing=1
    )
    page.ticks(ax.xaxis, k, 32)


@styled
def figure1(points, normals, roughness):
    """The surface coloured by roughness, and the distribution of the roughness.

    Parameters
    ----------
    points, normals : (N, 3) float64
        Å; unit vectors.
    roughness : (N,) float64
        R_i.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = page.sheet(page.COLUMN, 105)
    low, middle, high = np.quantile(
        roughness, [0.01, 0.5, 0.99]
    )  # a few extreme dots must not take most colours
    limits = min(low, middle - 0.1), max(high, middle + 0.1)
    scale = ScalarMappable(colors.Normalize(*limits, clip=True), colormaps["viridis"])
    camera = render.aim(points, render.along_smallest_axis(points), page.pixels(68, 55))
    scene = render.draw_surface(points, normals, scale.to_rgba(roughness)[:, :3], camera)
    page.show(page.axes(figure, 4, 3, 68, 55), render.picture(scene), camera)
    bar = figure.colorbar(scale, cax=page.axes(figure, 73.5, 8, 2.5, 45), extend="both")
    bar.set_label("roughness $R_i$ (low: rough, high: flat)")
    _distribution(page.axes(figure, 13, 70, 73, 26), roughness, scale)
    page.letter(figure, 1, 1, "A")
    page.letter(figure, 1, 65, "B")
    return figure


def _distribution(ax, roughness, scale):
    """Histogram in the colours of the surface, with the mean."""
    count, edges = np.histogram(roughness, 50)
    ax.bar(edges[:-1], count, np.diff(edges), align="edge", color=scale.to_rgba((edges[:-1] + edges[1:]) / 2))
    mean = float(np.mean(roughness))
    ax.axvline(mean, color="black", linestyle="--")
    ax.text(mean, 1.02, f"mean {mean:.2f}", transform=ax.get_xaxis_transform(), ha="center", va="bottom")
    ax.set(xlabel="roughness $R_i$", ylabel="number of dots", xlim=(edges[0], edges[-1]))
    ax.yaxis.set_major_locator(MaxNLocator(4, integer=True))


@styled
def figure4(roughness, distances, patches, rng, yardsticks=None, bins=10):
    """A rough and a flat patch, and Z_tS(j), Z_tR(j) by the roughness of the patch.

    Parameters
    ----------
    roughness : (T,) float64
        R_i of the test dots.
    distances : dict
        For each reading the pair Z_tS(j), Z_tR(j), each (T,) float64.
    patches : list
        Per patch: title, points (n, 3), normals (n, 3), and which of its dots the sampling and
        the uniform subset keep (int, counted within the patch).
    rng : numpy.random.Generator
        Picks the test patches of each bin.
    yardsticks : dict, optional
        `empty_patch` and `null_model`; a line is drawn where a value falls into the range.
    bins : int
        Equal-width intervals of roughness.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = page.sheet(page.PAGE, 113)
    for k, patch in enumerate(patches):
        page.letter(figure, 1 + 91 * k, 1, ascii_uppercase[k])
        _patch(figure, 6 + 91 * k, 1.3, *patch)
    edges, chosen = _equal_bins(np.asarray(roughness), rng, bins)
    handles = [
        Patch(facecolor=SAMPLED, edgecolor="black", label="$Z_{tS}(j)$, sampled"),
        Patch(facecolor=RANDOM, edgecolor="black", label="$Z_{tR}(j)$, random"),
    ]
    pitch = 182 / len(distances)
    for k, (reading, (z_ts, z_tr)) in enumerate(distances.items()):
        page.letter(figure, 1 + pitch * k, 52, ascii_uppercase[len(patches) + k])
        page.text(figure, 6 + pitch * k, 52.3, READINGS.get(reading, reading))
        ax = page.axes(figure, 12 + pitch * k, 57, pitch - 15, 46)
        _boxes(ax, edges, chosen, np.asarray(z_ts), np.asarray(z_tr))
        known = [handle.get_label() for handle in handles]
        handles += [line for line in _lines(ax, yardsticks or {}) if line.get_label() not in known]
    n = len(next(iter(chosen.values())))
    handles.append(Line2D([], [], linestyle="", label=f"{n} {'patch' if n == 1 else 'patches'} in each bin"))
    page.legend(figure, 12, 46, handles, ncols=len(handles), handlelength=1.8)
    return figure


def _patch(figure, x, y, title, points, normals, sampled, random):
    """A patch whole, sampled and random, from the same oblique view."""
    page.text(figure, x, y, title)
    camera = render.aim(points, render.oblique(points, normals), page.pixels(27, 27))
    behind = render.draw_surface(points, normals, render.PALE, camera)
    whole = np.arange(len(points))
    columns = [("whole", whole, WHOLE), ("sampled", sampled, SAMPLED), ("random", random, RANDOM)]
    for k, (name, kept, colour) in enumerate(columns):
        kept = np.asarray(kept, int)
        scene = render.draw_dots(behind, points[kept], normals[kept], colors.to_rgb(colour))
        ax = page.axes(figure, x + 28 * k, y + 8, 27, 27)
        page.show(ax, render.picture(scene), camera, scale_bar=k == 0)
        ax.set_title(f"{name}, {len(kept)} dots", color=colour)


def _equal_bins(roughness, rng, bins):
    """Edges of equal-width bins and, by bin, as many test dots as the smallest non-empty bin holds."""
    low, high = roughness.min(), roughness.max()
    edges = np.linspace(low, high, bins + 1) if high > low else np.array([low - 0.05, low + 0.05])
    bin_of = np.digitize(roughness, edges[1:-1])
    filled, size = np.unique(bin_of, return_counts=True)
    chosen = {k: rng.choice(np.flatnonzero(bin_of == k), size.min(), replace=False) for k in filled}
    return edges, chosen


def _boxes(ax, edges, chosen, z_ts, z_tr):
    """Two box plots per bin; whiskers reach at most 1.5 times the box, what lies beyond is a dot.

    Fewer than `FEW` values make no box: they are drawn as they are.
    """
    width = edges[1] - edges[0]
    for z, colour, side in ((z_ts, SAMPLED, -0.2), (z_tr, RANDOM, 0.2)):
        values = [z[dots][np.isfinite(z[dots])] for dots in chosen.values()]
        places = [edges[k] + (0.5 + side) * width for k in chosen]
        if len(next(iter(chosen.values()))) < FEW:
            ax.plot(np.repeat(places, [len(v) for v in values]), np.concatenate(values), "o", color=colour)
            continue
        ax.boxplot(
            values,
            positions=places,
            widths=0.34 * width,
            manage_ticks=False,
            patch_artist=True,
            boxprops={"facecolor": colour, "linewidth": 0.5},
            medianprops={"color": "black", "linewidth": 1},
            whiskerprops={"linewidth": 0.5},
            capprops={"linewidth": 0.5},
            flierprops={"marker": ".", "markersize": 2, "markerfacecolor": colour, "markeredgecolor": colour},
        )
    for edge in edges[1:]:
        ax.axvline(edge, color="#E0E0E0", linewidth=0.4, zorder=0)
    ax.set_xticks(edges, [f"{e:.2f}" for e in edges])
    ax.set(xlim=(edges[0], edges[-1]), xlabel="roughness $R_i$ of the patch (low: rough, high: flat)")
    ax.set_ylabel("$Z_{tS}(j)$, $Z_{tR}(j)$")
    ax.set_ylim(bottom=0)


def _lines(ax, yardsticks):
    """Reference lines that fall into the range, with their legend entries."""
    top = ax.get_ylim()[1]
    return [
        ax.axhline(y, color="black", linestyle=dashes, linewidth=0.6, zorder=0.5, label=f"{words}, {y:.2f}")
        for key, (words, dashes) in YARDSTICKS.items()
        if (y := yardsticks.get(key, np.nan)) <= top
    ]


@styled
def figure5(points, normals, subsets):
    """The surface and subsets of it, in one view.

    Parameters
    ----------
    points, normals : (N, 3) float64
        Å; unit vectors.
    subsets : list
        Title and dots of each picture: the whole surface first, then pairs of a sampling and
        the random subset of the same size, a row per pair.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = page.sheet(page.PAGE, 1 + 57 * max(1, len(subsets) // 2))
    camera = render.aim(points, render.along_smallest_axis(points), page.pixels(58, 45))
    behind = render.draw_surface(points, normals, render.PALE, camera)
    radius = max(render.DOT, 2 / camera.scale)  # at least two pixels, for large molecules
    for k, (title, kept) in enumerate(subsets):
        column, row = (1 + (k - 1) % 2, (k - 1) // 2) if k else (0, 0)
        x, y, colour = 1 + 61 * column, 1 + 57 * row, (WHOLE, SAMPLED, RANDOM)[column]
        kept = np.asarray(kept, int)
        scene = render.draw_dots(behind, points[kept], normals[kept], colors.to_rgb(colour), radius)
        page.show(page.axes(figure, x + 1, y + 9.5, 58, 45), render.picture(scene), camera, scale_bar=k == 0)
        page.letter(figure, x, y, ascii_uppercase[k])
        page.text(figure, x + 5, y + 0.3, f"{fill(title, 38)}\n{len(kept)} dots", color=colour)
    if len(subsets) > 3:
        words = "Each disc is a kept dot, drawn with a radius of"
        words = f"{words} {radius:.2g} Å upon a pale rendering of the full surface."
        page.text(figure, 6, 70, fill(words, 36))
    return figure
