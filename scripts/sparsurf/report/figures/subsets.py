"""Figure 5 of the paper: the surface and subsets of it; and the surface that the sparsest ones give back."""

from string import ascii_uppercase
from textwrap import fill

import numpy as np
from matplotlib import colormaps, colors
from matplotlib.cm import ScalarMappable

from sparsurf.report.figures import layout, render
from sparsurf.report.figures.layout import styled

FARTHEST = 0.1  # Å, where the colours of recovered surfaces end


def draw(results):
    """The figure of one surface and its best combination."""
    return figure(results.surface.points, results.surface.normals, results.subsets, results.recovered)


@styled
def figure(points, normals, subsets, recovered=()):
    """The surface and subsets of it, in one view.

    Parameters
    ----------
    points, normals : (N, 3) float64
        Å; unit vectors.
    subsets : list
        Title and dots of each picture: the whole surface first, then pairs of a sampling and
        the random subset of the same size, a row per pair.
    recovered : sequence
        Title, points, normals and distance (Å) from the whole surface of each recovered one, for a row of two.

    Returns
    -------
    matplotlib.figure.Figure
    """
    rows = max(1, len(subsets) // 2) + (len(recovered) > 0)
    figure = layout.sheet(layout.PAGE, 1 + 57 * rows)
    camera = render.aim(points, render.along_smallest_axis(points), layout.pixels(58, 45))
    behind = render.draw_surface(points, normals, render.PALE, camera)
    radius = max(render.DOT, 2 / camera.scale)  # at least two pixels, for large molecules
    for k, (title, kept) in enumerate(subsets):
        cell = (1 + (k - 1) % 2, (k - 1) // 2) if k else (0, 0)
        kept, colour = np.asarray(kept, int), (layout.WHOLE, layout.SAMPLED, layout.RANDOM)[cell[0]]
        scene = render.draw_dots(behind, points[kept], normals[kept], colors.to_rgb(colour), radius)
        _show(figure, cell, k, scene, f"{fill(title, 38)}\n{len(kept)} dots", colour)
    if len(subsets) > 3:
        words = "Each disc is a kept dot, drawn with a radius of"
        words = f"{words} {radius:.2g} Å upon a pale rendering of the full surface."
        layout.text(figure, 6, 70, fill(words, 36))
    if len(recovered):
        _show_recovered(figure, camera, recovered, rows - 1, len(subsets))
    return figure


def _show(figure, cell, k, scene, words, colour):
    """Picture k with its letter and words in a cell, (column, row)."""
    x, y = 1 + 61 * cell[0], 1 + 57 * cell[1]
    ax = layout.axes(figure, x + 1, y + 9.5, 58, 45)
    layout.show(ax, render.picture(scene), scene.camera, scale_bar=k == 0)
    layout.letter(figure, x, y, ascii_uppercase[k])
    layout.text(figure, x + 5, y + 0.3, words, color=colour)


def _show_recovered(figure, camera, recovered, row, first):
    """A row of recovered surfaces, coloured by their distance from the whole one, with the scale beside it."""
    scale = ScalarMappable(colors.Normalize(0, FARTHEST, clip=True), colormaps["viridis"])
    for column, (title, points, normals, distance) in enumerate(recovered):
        scene = render.draw_surface(points, normals, scale.to_rgba(np.asarray(distance))[:, :3], camera)
        words = f"{title}\nmean distance from A {np.mean(distance):.3f} Å"
        _show(
            figure, (1 + column, row), first + column, scene, words, (layout.SAMPLED, layout.RANDOM)[column]
        )
    y = 1 + 57 * row
    bar = figure.colorbar(
        scale, cax=layout.axes(figure, 6, y + 26, 44, 2.2), extend="max", orientation="horizontal"
    )
    bar.set_label("distance from A / Å")
    layout.text(
        figure, 6, y + 13, fill("The surface that the kept dots and their normals alone give back.", 36)
    )
