"""The pictures of a surface below the answers of the first page, drawn at the size at which the page shows them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import colors
from PIL import Image

from sparsurf.surfaces.formats.colours import ROUGHNESS_LIMITS
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout, render

# Rows and columns: a column of the page is 320 px wide, and a sharp screen shows two pixels for each of them
PICTURE_PIXELS = 480, 640
SMALLEST_DOT = 2.0  # pixels, radius of a kept dot, which would vanish on a large molecule


def draw_roughness_picture(path: Path | str, surface: Surface, roughness: np.ndarray) -> None:
    """Draw a surface in the colours of its roughness, on the scale of all surfaces."""
    of_dots = layout.colours(layout.scale(*ROUGHNESS_LIMITS), roughness)
    _save(path, render.draw_surface(surface.points, surface.normals, of_dots, _camera(surface)))


def draw_subset_pictures(surface: Surface, pictures: Sequence[tuple[Path | str, Surface, str]]) -> None:
    """Draw the dots of subsets on the pale surface: a picture (path, dots, colour) of each."""
    camera = _camera(surface)
    behind = render.draw_surface(surface.points, surface.normals, render.PALE_RGB, camera)
    radius = max(render.DISC_RADIUS, SMALLEST_DOT / camera.scale)
    for path, subset, colour in pictures:
        _save(path, render.draw_dots(behind, subset.points, subset.normals, colors.to_rgb(colour), radius))


def _camera(surface: Surface) -> render.Camera:
    """Return the camera of all pictures of a surface, the same for each, so that they can be compared."""
    return render.aim(surface.points, render.along_smallest_axis(surface.points), PICTURE_PIXELS)


def _save(path: Path | str, scene: render.Scene) -> None:
    """Store a picture."""
    Image.fromarray(render.picture(scene)).save(path)
