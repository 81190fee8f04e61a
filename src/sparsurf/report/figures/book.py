"""Two partners opened like a book: the side that each turns to the other, as pages beside each other."""

import numpy as np
from matplotlib import colormaps, colors
from matplotlib.cm import ScalarMappable

from sparsurf.report.figures import layout, render
from sparsurf.report.figures.layout import styled

INSIDE, OUTSIDE = "#D55E00", "#DDDDDD"  # of the interface
WIDTH, HEIGHT = 78, 62  # mm of a page


@styled
def book_figure(name, surfaces, tables):
    """Smoothed propensity above, the interface below (or, where they do not touch, the smoothed similarity).

    Parameters
    ----------
    name : str
    surfaces : two Surface
    tables : two DataFrames, the rows of propensity.csv of each partner

    Returns
    -------
    matplotlib.figure.Figure
    """
    touching = [table["interface"].to_numpy() == 1 for table in tables]
    both = all(mask.any() for mask in touching)
    pages = opened(surfaces, touching if both else None)
    cameras = [
        render.aim(surface.points, page, layout.pixels(WIDTH, HEIGHT))
        for surface, page in zip(surfaces, pages, strict=True)
    ]
    scale = min(camera.scale for camera in cameras)
    cameras = [camera._replace(scale=scale) for camera in cameras]
    figure = layout.sheet(layout.PAGE, 148)
    layout.text(figure, 4, 1, f"{name}: partner 1 left, partner 2 right, each seen from the other")
    _row(
        figure,
        7,
        surfaces,
        cameras,
        tables,
        "propensity_smoothed",
        "propensity, smoothed\n(low: good match)",
    )
    if both:
        for side in (0, 1):
            colour = np.where(touching[side][:, None], colors.to_rgb(INSIDE), colors.to_rgb(OUTSIDE))
            _page(figure, side, 77, surfaces[side], colour, cameras[side])
        layout.text(figure, 162, 80, "interface: dots\nthat touch the\nother partner", color=INSIDE)
    else:
        _row(
            figure, 77, surfaces, cameras, tables, "similarity_smoothed", "similarity, smoothed\n(low: alike)"
        )
    return figure


def _row(figure, y, surfaces, cameras, tables, column, label):
    """Both pages in the colours of a column, on one scale."""
    values = [table[column].to_numpy() for table in tables]
    low, high = np.quantile(np.concatenate(values), [0.01, 0.99])
    scale = ScalarMappable(colors.Normalize(low, max(high, low + 1e-6), clip=True), colormaps["viridis"])
    for side in (0, 1):
        _page(figure, side, y, surfaces[side], scale.to_rgba(values[side])[:, :3], cameras[side])
    figure.colorbar(scale, cax=layout.axes(figure, 162, y + 5, 2.5, 50), extend="both").set_label(label)


def _page(figure, side, y, surface, colour, camera):
    scene = render.draw_surface(surface.points, surface.normals, colour, camera)
    layout.show(layout.axes(figure, 2 + side * (WIDTH + 2), y, WIDTH, HEIGHT), render.picture(scene), camera)


def opened(surfaces, touching=None):
    """Rotations that look at each partner from the other, with a common upright hinge between the pages.

    Parameters
    ----------
    surfaces : two Surface
    touching : two (N,) bool, optional
        The interface; without it the line between the middles tells where they face each other.

    Returns
    -------
    two (3, 3) float64, rows point right, up and to the viewer
    """
    first, second = surfaces
    if touching is None:
        facing, around = second.points.mean(axis=0) - first.points.mean(axis=0), first.points
    else:
        facing = first.normals[touching[0]].mean(axis=0) - second.normals[touching[1]].mean(axis=0)
        around = first.points[touching[0]]
    length = np.linalg.norm(facing)
    facing = facing / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])
    x = around - around.mean(axis=0)
    x = x - np.outer(x @ facing, facing)
    up = np.linalg.eigh(x.T @ x - 1e6 * len(x) * np.outer(facing, facing))[1][:, -1]
    up = up if up[np.argmax(np.abs(up))] > 0 else -up
    return [np.array([np.cross(up, front), up, front]) for front in (facing, -facing)]
