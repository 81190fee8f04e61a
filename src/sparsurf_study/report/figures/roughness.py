"""Figure 1 of the paper: the surface coloured by roughness, and the distribution of roughness."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sparsurf.surfaces.formats.colours import ROUGHNESS_LIMITS
from sparsurf.views import layout, render
from sparsurf.views.layout import styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf_study.report.figures.results import Results


def draw(results: Results) -> Figure:
    """Draw the figure of one surface."""
    return figure(results.surface.points, results.surface.normals, results.roughness, results.name)


@styled
def figure(points: np.ndarray, normals: np.ndarray, roughness: np.ndarray, name: str = "") -> Figure:
    """Draw the surface coloured by roughness, on the scale of all surfaces, and the distribution of the roughness."""
    mean = f"{roughness.mean():.2f}"
    figure = layout.sheet(layout.COLUMN, 105, layout.headed(name, f"mean roughness {mean}"))
    scale = layout.scale(*ROUGHNESS_LIMITS)
    camera = render.aim(points, render.along_smallest_axis(points), layout.pixels(68, 55))
    scene = render.draw_surface(points, normals, layout.colours(scale, roughness), camera)
    layout.draw_picture(layout.axes(figure, 4, 3, 68, 55), render.picture(scene), camera)
    bar = figure.colorbar(scale, cax=layout.axes(figure, 73.5, 8, 2.5, 45), extend="both")
    bar.set_label("roughness $R_i$ (low: rough, high: flat)")
    ax = layout.axes(figure, 13, 70, 73, 26)
    layout.histogram(ax, roughness, scale, "roughness $R_i$", f"mean {mean}")
    layout.letter(figure, 1, 1, "A")
    layout.letter(figure, 1, 65, "B")
    return figure
