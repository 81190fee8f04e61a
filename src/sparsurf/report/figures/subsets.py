"""Figure 5 of the paper: the surface and subsets of it, and the surface that the handed out subset gives back."""

from string import ascii_uppercase
from textwrap import fill

import numpy as np
from matplotlib import colors

from sparsurf.report.figures import layout, render
from sparsurf.report.figures.layout import styled

FARTHEST = 0.2  # Å, where the colours of a recovered surface end
WIDE, HIGH = 61, 60  # mm of a picture with its words


def draw(results):
    """The figure of one surface."""
    return figure(results.surface, results.subsets, results.recovered, results.name)


@styled
def figure(surface, subsets, recovered, name=""):
    """The surface, subsets of it in one view, and one that was recovered with its distance from the first.

    Parameters
    ----------
    surface : Surface
    subsets : list of (title, Surface, colour)
    recovered : (title, Surface, (M,) float64 distance in Å)
    name : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    title, back, distance = recovered
    cells = len(subsets) + 3
    columns = 2 if cells == 4 else 3
    figure = layout.sheet(WIDE * columns, 1 + HIGH * -(-cells // columns), name)
    places = [(1 + WIDE * (k % columns), 1 + HIGH * (k // columns)) for k in range(cells)]
    camera = render.aim(surface.points, render.along_smallest_axis(surface.points), layout.pixels(58, 45))
    behind = render.draw_surface(surface.points, surface.normals, render.PALE, camera)
    radius = max(render.DOT, 2 / camera.scale)  # at least two pixels, for large molecules
    _show(figure, places, 0, behind, f"the surface\n{len(surface):,} dots", layout.WHOLE)
    for k, (words, subset, colour) in enumerate(subsets, 1):
        scene = render.draw_dots(behind, subset.points, subset.normals, colors.to_rgb(colour), radius)
        share = 100 * len(subset) / len(surface)
        _show(figure, places, k, scene, f"{fill(words, 38)}\n{len(subset):,} dots, {share:.3g} %", colour)
    scale = layout.scale(0, FARTHEST)
    scene = render.draw_surface(back.points, back.normals, layout.colours(scale, distance), camera)
    _show(
        figure,
        places,
        cells - 2,
        scene,
        f"{title}\nin the colours of panel {ascii_uppercase[cells - 1]}",
        layout.DARK,
    )
    x, y = _cell(figure, places, cells - 1, "how far the recovered surface lies\nfrom the true one", "black")
    mean = f"mean {np.mean(distance):.3f} Å"
    ends = np.linspace(0, FARTHEST, 41)
    layout.histogram(
        layout.axes(figure, x + 12, y + 14, 44, 32),
        np.clip(distance, 0, FARTHEST),
        scale,
        f"distance (Å; last bar: {FARTHEST:g} and more)",
        mean,
        ends,
    )
    return figure


def _cell(figure, places, k, words, colour):
    """Letter and words of cell k; returns where its upper left corner is, mm."""
    x, y = places[k]
    layout.letter(figure, x, y, ascii_uppercase[k])
    layout.text(figure, x + 5, y + 0.3, words, color=colour)
    return x, y


def _show(figure, places, k, scene, words, colour):
    """Picture k with its letter and words."""
    x, y = _cell(figure, places, k, words, colour)
    ax = layout.axes(figure, x + 1, y + 9.5, 58, 45)
    layout.show(ax, render.picture(scene), scene.camera, scale_bar=k == 0)
