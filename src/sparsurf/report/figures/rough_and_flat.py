"""Figure 4 of the paper: a rough and a flat patch, and Z by the roughness of the patch."""

from string import ascii_uppercase

import numpy as np
from matplotlib import colors
from matplotlib.patches import Patch

from sparsurf.report.figures import layout, render
from sparsurf.report.figures.layout import styled
from sparsurf.report.numbers import span
from sparsurf.study.rough_and_flat import N_BINS
from sparsurf.study.tables import range_index, range_limits

REFERENCES = {
    "empty_patch": ("empty patch", "--"),
    "null_model": ("null model", ":"),
    "fresh dots": ("fresh dots", "-."),
}
FEW = 5  # values that a box plot needs at least


def draw(results):
    """The figure of one surface and its best combination."""
    return figure(**results.rough_and_flat, name=results.name)


@styled
def figure(panels, patches, references=None, bins=N_BINS, name=""):
    """A rough and a flat patch, and Z_tS(j), Z_tR(j) by the roughness of the patch.

    Parameters
    ----------
    panels : list
        Per panel, two in a row: title, then for its test dots roughness, Z_tS(j) and Z_tR(j), each (T,) float64.
    patches : list
        Per patch: title, points (n, 3), normals (n, 3), and which of its dots the sampling and
        the uniform subset keep (int, counted within the patch).
    references : dict, optional
        `empty_patch`, `null_model` and among its `floors` `fresh dots`; a line is drawn where a value falls into the range.
    bins : int
        Equal-width intervals of roughness.
    name : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = layout.sheet(layout.PAGE, 52 + 61 * -(-len(panels) // 2), name)
    for k, patch in enumerate(patches):
        layout.letter(figure, 1 + 91 * k, 1, ascii_uppercase[k])
        _patch(figure, 6 + 91 * k, 1.3, *patch)
    handles = [
        Patch(facecolor=layout.SAMPLED, edgecolor="black", label="$Z_{tS}(j)$, sampled"),
        Patch(facecolor=layout.RANDOM, edgecolor="black", label="$Z_{tR}(j)$, uniform"),
    ]
    for k, (title, roughness, z_ts, z_tr) in enumerate(panels):
        x, y = 91 * (k % 2), 52 + 61 * (k // 2)
        edges, chosen = _binned(np.asarray(roughness), bins)
        layout.letter(figure, 1 + x, y, ascii_uppercase[len(patches) + k])
        n = span([len(dots) for dots in chosen.values()], "{:,}".format)
        layout.text(figure, 6 + x, y + 0.3, f"{title}; {n} patches a bin")
        ax = layout.axes(figure, 12 + x, y + 5, 76, 46)
        _boxes(ax, edges, chosen, np.asarray(z_ts), np.asarray(z_tr))
        known = [handle.get_label() for handle in handles]
        handles += [line for line in _lines(ax, references or {}) if line.get_label() not in known]
    layout.legend(figure, 12, 46, handles, ncols=len(handles), handlelength=1.8)
    return figure


def _patch(figure, x, y, title, points, normals, sampled, random):
    """A patch whole, sampled and its uniform subset, from the same oblique view."""
    layout.text(figure, x, y, title)
    camera = render.aim(points, render.oblique(points, normals), layout.pixels(27, 27))
    behind = render.draw_surface(points, normals, render.PALE, camera)
    whole = np.arange(len(points))
    columns = [
        ("whole", whole, layout.WHOLE),
        ("sampled", sampled, layout.SAMPLED),
        ("uniform", random, layout.RANDOM),
    ]
    for k, (name, kept, colour) in enumerate(columns):
        kept = np.asarray(kept, int)
        scene = render.draw_dots(behind, points[kept], normals[kept], colors.to_rgb(colour))
        ax = layout.axes(figure, x + 28 * k, y + 8, 27, 27)
        layout.show(ax, render.picture(scene), camera, scale_bar=k == 0)
        ax.set_title(f"{name}, {len(kept)} dots", color=colour)


def _binned(roughness, bins):
    """Edges of bins of equal width, and the test dots of each that has any."""
    edges = range_limits(roughness, bins)
    if edges[0] == edges[-1]:
        edges = edges[0] + np.array([-0.05, 0.05])
    bin_of = range_index(roughness, edges)
    return edges, {k: np.flatnonzero(bin_of == k) for k in np.unique(bin_of)}


def _boxes(ax, edges, chosen, z_ts, z_tr):
    """Two box plots per bin; whiskers reach at most 1.5 times the box, what lies beyond is a dot.

    Fewer than `FEW` values of a bin make no box: they are drawn as they are.
    """
    width = edges[1] - edges[0]
    for z, colour, side in ((z_ts, layout.SAMPLED, -0.2), (z_tr, layout.RANDOM, 0.2)):
        values = [z[dots][np.isfinite(z[dots])] for dots in chosen.values()]
        places = [edges[k] + (0.5 + side) * width for k in chosen]
        few = np.array([len(own) < FEW for own in values])
        alone = [(np.full(len(own), x), own) for own, x in zip(values, places, strict=True) if len(own) < FEW]
        if alone:
            ax.plot(*np.concatenate(alone, axis=1), "o", color=colour)
        if not few.all():
            boxed = [own for own in values if len(own) >= FEW]
            _box_plots(ax, boxed, np.array(places)[~few], 0.34 * width, colour)
    for edge in edges[1:]:
        ax.axvline(edge, color="#E0E0E0", linewidth=0.4, zorder=0)
    ax.set_xticks(edges, [f"{e:.2f}" for e in edges])
    ax.set(xlim=(edges[0], edges[-1]), xlabel="roughness $R_i$ of the patch (low: rough, high: flat)")
    ax.set_ylabel("$Z_{tS}(j)$, $Z_{tR}(j)$")
    ax.set_ylim(bottom=0)


def _box_plots(ax, values, places, width, colour):
    """Box plots in five artists, where `boxplot` takes six for each."""
    low, middle, high = np.array([np.quantile(own, [0.25, 0.5, 0.75]) for own in values]).T
    reach = 1.5 * (high - low)
    ends = [
        (own[own >= a - r].min(), own[own <= b + r].max())
        for own, a, b, r in zip(values, low, high, reach, strict=True)
    ]
    bottom, top = np.array(ends).T
    thin = {"color": "black", "linewidth": 0.5}
    ax.bar(places, high - low, width, low, facecolor=colour, edgecolor="black", linewidth=0.5)
    ax.hlines(middle, places - width / 2, places + width / 2, color="black", linewidth=1)
    ax.vlines(np.tile(places, 2), np.append(bottom, high), np.append(low, top), **thin)
    ax.hlines(np.append(bottom, top), np.tile(places - width / 4, 2), np.tile(places + width / 4, 2), **thin)
    beyond = [own[(own < a) | (own > b)] for own, (a, b) in zip(values, ends, strict=True)]
    far = np.repeat(places, [len(own) for own in beyond])
    ax.plot(far, np.concatenate(beyond), ".", markersize=2, color=colour)


def _lines(ax, references):
    """Reference lines that fall into the range, with their legend entries."""
    top, values = ax.get_ylim()[1], references | references.get("floors", {})
    return [
        ax.axhline(y, color="black", linestyle=dashes, linewidth=0.6, zorder=0.5, label=f"{words}, {y:.2f}")
        for key, (words, dashes) in REFERENCES.items()
        if (y := values.get(key, np.nan)) <= top
    ]
