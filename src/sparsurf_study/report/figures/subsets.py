"""Figure 5 of the paper: the surface, subsets of it, and the surface reconstructed from the minimal subset."""

from __future__ import annotations

from collections.abc import Sequence
from string import ascii_uppercase
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colors

from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout, render
from sparsurf.views.layout import styled
from sparsurf.views.numbers import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf.views.render import Scene
    from sparsurf_study.report.figures.results import Results

MAX_DISTANCE = render.DISTANCE_LIMITS[1]
# The grey of a surface where nothing deviates, so that what does is seen
DISTANCE_COLOURS = colors.LinearSegmentedColormap.from_list("distance", ["#EBEBEB", "#D55E00", "#500000"])
ENDS_OF_BARS = np.geomspace(
    1e-4, 1, 41
)  # Å, since most distances are a thousand times smaller than the largest
CELL_WIDTH, CELL_HEIGHT = 61.0, 60.0  # mm, of a picture with its title


def draw(results: Results) -> Figure:
    """Draw the figure of one surface."""
    error = results.recovered_errors["mean"].iloc[0]
    return figure(results.surface, results.subsets, results.recovered, results.name, error)


def recovered_from(
    points: np.ndarray, surface: Surface, distance: np.ndarray, name: str = "the minimal subset"
) -> tuple[str, Surface, np.ndarray, np.ndarray]:
    """Return what `figure` shows of the `surface` that was reconstructed from a subset, which `name` describes.

    These are a title, the surface, the `distance`, Å, of each dot of the whole surface, at `points`, from it, and the number of
    the nearest one of these dots for each dot of the reconstructed surface.
    """
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    _, nearest = cKDTree(points).query(surface.points)
    return f"reconstructed from {name}", surface, distance, np.asarray(nearest)


@styled
def figure(
    surface: Surface,
    subsets: Sequence[tuple[str, Surface, str]],
    recovered: tuple[str, Surface, np.ndarray, np.ndarray] | None = None,
    name: str = "",
    error: float | None = None,
) -> Figure:
    """Draw the surface, subsets (title, Surface, colour) in one view, and a reconstructed one, as `recovered_from` returns it."""
    cells = len(subsets) + (3 if recovered else 1)
    columns = 2 if cells == 4 else 3
    if recovered:
        off = "" if error is None else f" to {error:.3f} Å on average"
        name = layout.headed(name, f"{len(subsets[-1][1]):,} dots reconstruct the surface{off}")
    figure = layout.sheet(CELL_WIDTH * columns, 1 + CELL_HEIGHT * -(-cells // columns), name)
    corners = [(1 + CELL_WIDTH * (k % columns), 1 + CELL_HEIGHT * (k // columns)) for k in range(cells)]
    camera = render.aim(surface.points, render.along_smallest_axis(surface.points), layout.pixels(58, 45))
    behind = render.draw_surface(surface.points, surface.normals, render.PALE_RGB, camera)
    radius = max(render.DISC_RADIUS, 2 / camera.scale)  # at least two pixels, for large molecules
    _show(figure, corners, 0, behind, f"the surface\n{len(surface):,} dots", layout.WHOLE)
    for k, (caption, subset, colour) in enumerate(subsets, 1):
        scene = render.draw_dots(behind, subset.points, subset.normals, colors.to_rgb(colour), radius)
        percent = number(100 * len(subset) / len(surface), 1)
        _show(figure, corners, k, scene, f"{fill(caption, 38)}\n{len(subset):,} dots, {percent} %", colour)
    if recovered is None:
        return figure
    title, back, distance, nearest = recovered
    scale = layout.scale(0, MAX_DISTANCE, DISTANCE_COLOURS)
    scene = render.draw_surface(back.points, back.normals, layout.colours(scale, distance[nearest]), camera)
    caption = f"{title},\nin the colours of its distance"
    _show(figure, corners, cells - 2, scene, caption, layout.RECONSTRUCTED_COLOUR)
    x, y = corners[cells - 2]
    bar = figure.colorbar(
        scale, cax=layout.axes(figure, x + 5, y + 54, 22, 1.8), orientation="horizontal", extend="max"
    )
    bar.set_ticks([0, MAX_DISTANCE / 2, MAX_DISTANCE])
    layout.text(figure, x + 31, y + 53.4, "distance (Å)")
    caption = f"how far the dots of panel A lie\nfrom the surface of panel {ascii_uppercase[cells - 2]}"
    x, y = _cell(figure, corners, cells - 1, caption, "black")
    label = "distance (Å; end bars hold the rest)"
    ax = layout.axes(figure, x + 12, y + 14, 44, 32)
    layout.histogram(ax, distance, scale, label, f"mean {distance.mean():.2g}", ENDS_OF_BARS)
    ax.set(xscale="log", yscale="log", ylim=(0.7, None))  # one bar holds most of the dots
    ax.xaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_major_formatter("{x:g}")
    return figure


def _cell(
    figure: layout.Sheet, corners: list[tuple[float, float]], k: int, title: str, colour: str
) -> tuple[float, float]:
    """Write letter and title of cell k; return its upper left corner in mm."""
    x, y = corners[k]
    layout.letter(figure, x, y, ascii_uppercase[k])
    layout.text(figure, x + 5, y + 0.3, title, color=colour)
    return x, y


def _show(
    figure: layout.Sheet, corners: list[tuple[float, float]], k: int, scene: Scene, title: str, colour: str
) -> None:
    """Show picture k with its letter and title."""
    x, y = _cell(figure, corners, k, title, colour)
    ax = layout.axes(figure, x + 1, y + 9.5, 58, 45)
    layout.draw_picture(ax, render.picture(scene), scene.camera, scale_bar=k == 0)
