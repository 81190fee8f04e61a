"""Figures of sites: the site and its hits side by side, all seen from the same side."""

import numpy as np
from matplotlib import colors
from scipy.spatial import cKDTree

from sparsurf.report.figures import layout, render
from sparsurf.report.figures.layout import PALETTE, styled

AROUND = 12.0  # Å around the site that the pictures show
ON_IT = 1.5  # Å; dots of a hit nearer to the site laid on it take its colour
WIDTH, HEIGHT = 86, 60  # mm of a picture
LEGEND = 6  # residues that a line names
REST = render.PALE


def carried(surface, site, pose):
    """A hit in the frame of the site, and which of the site's residues each of its dots lies on.

    Parameters
    ----------
    surface : Surface, of the hit
    site : (points (n, 3), residue (n,) int) of the site's dots
    pose : (turn (3, 3), shift (3,)), which lays the site on the hit

    Returns
    -------
    points, normals (N, 3), and (N,) int, -1 for none
    """
    turn, shift = pose
    points, normals = (surface.points - shift) @ turn.T, surface.normals @ turn.T
    gap, nearest = cKDTree(site[0]).query(points, distance_upper_bound=ON_IT)
    return points, normals, np.where(np.isfinite(gap), site[1][np.minimum(nearest, len(site[1]) - 1)], -1)


@styled
def site_figure(name, panels, residues):
    """The site and its best hits.

    Parameters
    ----------
    name : str
    panels : list of (title, points (N, 3), normals (N, 3), residue (N,) int), in one frame; the site first, -1 elsewhere
    residues : list of str, names of the residues that are counted

    Returns
    -------
    matplotlib.figure.Figure
    """
    _, points, normals, residue = panels[0]
    site = residue >= 0
    rotation = render.oblique(points[site], normals[site], 90)
    middle = points[site].mean(axis=0)
    reach = np.linalg.norm(points[site] - middle, axis=1).max() + AROUND
    near = np.linalg.norm(points - middle, axis=1) < reach
    camera = render.aim(points[near], rotation, layout.pixels(WIDTH, HEIGHT))
    rows = (len(panels) + 1) // 2
    lines = -(-len(residues) // LEGEND)
    figure = layout.sheet(layout.PAGE, rows * (HEIGHT + 12) + 4 * lines + 2, name)
    palette = np.array([colors.to_rgb(each) for each in PALETTE] + [REST])
    for k, (title, points, normals, residue) in enumerate(panels):
        x, y = 2 + (WIDTH + 6) * (k % 2), (HEIGHT + 12) * (k // 2)
        layout.text(figure, x, y + 1, title)
        shown = palette[np.where(residue < 0, len(PALETTE), residue % len(PALETTE))]
        scene = render.draw_surface(points, normals, shown, camera)
        layout.show(layout.axes(figure, x, y + 5, WIDTH, HEIGHT), render.picture(scene), camera, k == 0)
    for k, residue in enumerate(residues):
        x, y = 2 + 30 * (k % LEGEND), rows * (HEIGHT + 12) + 4 * (k // LEGEND)
        layout.text(figure, x, y, f"■ {residue}", color=PALETTE[k % len(PALETTE)])
    return figure
