"""Figure 5 of the paper: the surface and subsets of it."""

from string import ascii_uppercase
from textwrap import fill

import numpy as np
from matplotlib import colors

from sparsurf.report.figures import layout, render
from sparsurf.report.figures.layout import styled


def draw(results):
    """The figure of one surface and its best combination."""
    return figure(results.surface.points, results.surface.normals, results.subsets)


@styled
def figure(points, normals, subsets):
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
    figure = layout.sheet(layout.PAGE, 1 + 57 * max(1, len(subsets) // 2))
    camera = render.aim(points, render.along_smallest_axis(points), layout.pixels(58, 45))
    behind = render.draw_surface(points, normals, render.PALE, camera)
    radius = max(render.DOT, 2 / camera.scale)  # at least two pixels, for large molecules
    for k, (title, kept) in enumerate(subsets):
        column, row = (1 + (k - 1) % 2, (k - 1) // 2) if k else (0, 0)
        x, y, colour = 1 + 61 * column, 1 + 57 * row, (layout.WHOLE, layout.SAMPLED, layout.RANDOM)[column]
        kept = np.asarray(kept, int)
        scene = render.draw_dots(behind, points[kept], normals[kept], colors.to_rgb(colour), radius)
        layout.show(
            layout.axes(figure, x + 1, y + 9.5, 58, 45), render.picture(scene), camera, scale_bar=k == 0
        )
        layout.letter(figure, x, y, ascii_uppercase[k])
        layout.text(figure, x + 5, y + 0.3, f"{fill(title, 38)}\n{len(kept)} dots", color=colour)
    if len(subsets) > 3:
        words = "Each disc is a kept dot, drawn with a radius of"
        words = f"{words} {radius:.2g} Å upon a pale rendering of the full surface."
        layout.text(figure, 6, 70, fill(words, 36))
    return figure
