"""Figure 1 of the paper: the surface coloured by roughness, and how roughness is distributed."""

import numpy as np
from matplotlib import colormaps, colors
from matplotlib.cm import ScalarMappable
from matplotlib.ticker import MaxNLocator

from sparsurf.report.figures import layout, render
from sparsurf.report.figures.layout import styled


def draw(results):
    """The figure of one surface."""
    return figure(results.surface.points, results.surface.normals, results.roughness)


@styled
def figure(points, normals, roughness):
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
    figure = layout.sheet(layout.COLUMN, 105)
    # a few extreme dots must not take most colours
    low, middle, high = np.quantile(roughness, [0.01, 0.5, 0.99])
    limits = min(low, middle - 0.1), max(high, middle + 0.1)
    scale = ScalarMappable(colors.Normalize(*limits, clip=True), colormaps["viridis"])
    camera = render.aim(points, render.along_smallest_axis(points), layout.pixels(68, 55))
    scene = render.draw_surface(points, normals, scale.to_rgba(roughness)[:, :3], camera)
    layout.show(layout.axes(figure, 4, 3, 68, 55), render.picture(scene), camera)
    bar = figure.colorbar(scale, cax=layout.axes(figure, 73.5, 8, 2.5, 45), extend="both")
    bar.set_label("roughness $R_i$ (low: rough, high: flat)")
    _distribution(layout.axes(figure, 13, 70, 73, 26), roughness, scale)
    layout.letter(figure, 1, 1, "A")
    layout.letter(figure, 1, 65, "B")
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
