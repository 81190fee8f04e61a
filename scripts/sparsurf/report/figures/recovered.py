"""A surface, the few dots kept of it, and the surface that these give back."""

import numpy as np
from matplotlib import colormaps, colors
from matplotlib.cm import ScalarMappable

from sparsurf.report.figures import layout, render
from sparsurf.report.figures.layout import styled

FARTHEST = 0.3  # Å, where the colours end


@styled
def figure(whole, kept, recovered, distance, words):
    """Three pictures in one view, the recovered surface coloured by its distance from the true one.

    Parameters
    ----------
    whole, kept, recovered : pairs of points (N, 3), Å, and unit normals (N, 3)
    distance : (M,) float64, Å, of the recovered dots
    words : three titles

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = layout.sheet(layout.PAGE, 62)
    camera = render.aim(whole[0], render.along_smallest_axis(whole[0]), layout.pixels(52, 44))
    scale = ScalarMappable(colors.Normalize(0, FARTHEST, clip=True), colormaps["viridis"])
    pale = render.draw_surface(*whole, render.PALE, camera)
    dots = render.draw_dots(pale, *kept, colors.to_rgb(layout.SAMPLED), max(render.DOT, 2 / camera.scale))
    scenes = [
        render.draw_surface(*whole, colors.to_rgb("0.75"), camera),
        dots,
        render.draw_surface(*recovered, scale.to_rgba(np.asarray(distance))[:, :3], camera),
    ]
    for k, (scene, title) in enumerate(zip(scenes, words, strict=True)):
        x = 1 + 55 * k
        layout.letter(figure, x, 1, "ABC"[k])
        layout.text(figure, x + 5, 1.3, title)
        layout.show(layout.axes(figure, x, 14, 52, 44), render.picture(scene), camera, scale_bar=k == 0)
    bar = figure.colorbar(scale, cax=layout.axes(figure, 168, 18, 2.2, 34), extend="max")
    bar.set_label("distance from A / Å")
    return figure
