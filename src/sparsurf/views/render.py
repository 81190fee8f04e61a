"""Render a dot surface: every dot an oriented disc, in an orthographic view.

A first pass over the discs finds the depth of the front surface at every pixel. A second pass blends normals and colours of
the discs in that front layer. The order of the dots does not matter, and memory depends on the number of pixels only.
Sources: Zwicker et al., Surface splatting, SIGGRAPH 2001 (here without its filter); darkened
hollows: Luft et al., Image enhancement by unsharp masking the depth buffer, SIGGRAPH 2006.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.orientation import principal_axes
from sparsurf.surfaces.formats.colours import scale_of

SUPERSAMPLING = 2  # rendered pixels per pixel of the picture, along each side
MIN_MEAN_NORMAL = 1e-6  # length of a mean normal that has a direction; shorter ones are rounding errors
MIN_VIEW_COSINE = 0.05  # discs seen edge-on or from behind are not drawn
LIGHT = np.array([-0.45, 0.55, 0.70])  # direction of the light: from above left, in front
AMBIENT = 0.45  # brightness in the shade
HAZE = 0.25  # share of white in the colour of the farthest dot
HOLLOW = 1.2  # Å, size and depth of the hollows that are darkened
CONTOUR_DEPTH = 2.0  # Å, jump in depth at which a contour begins
DISC_RADIUS = 0.2  # Å, of the disc of a kept dot
MAX_DISC_RADIUS = 1.2  # Å, of discs that cover the surface around a dot: the curvature of a hydrogen
DISTANCE_LIMITS = 0.0, 0.1  # Å, of a surface from the reconstructed one, at the ends of the colours
THUMBNAIL_PIXELS = 180, 240  # rows and columns
SCALE_BAR, CAMERA_MARGIN = 10, 6  # Å, and pixels from the corner
PALE_RGB = (0.92, 0.92, 0.92)  # surface behind the dots of a subset


class Camera(NamedTuple):
    """Orthographic view."""

    rotation: np.ndarray  # (3, 3) float64, rows point right, up and to the viewer
    centre: np.ndarray  # (3,) float64, Å, in the middle of the picture
    scale: float  # pixels per Å
    shape: tuple  # rows and columns of the picture

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Return left, right, bottom and top of the picture in Å."""
        height, width = (n / self.scale / 2 for n in self.shape)
        return -width, width, -height, height


class Scene(NamedTuple):
    """A rendered surface, to which dots can be added; R and C are rendered rows and columns."""

    camera: Camera
    colour: np.ndarray  # (R, C, 3) float32, 0..1
    depth: np.ndarray  # (R, C) float64, rendered pixels towards the viewer, -inf where nothing is
    dark: np.ndarray  # (R, C) float64, factor for hollows and contours
    slack: float  # rendered pixels below the front that still count as front


def along_smallest_axis(points: np.ndarray) -> np.ndarray:
    """Return the rotation, rows right, up and to the viewer, along the smallest principal axis, the largest horizontal."""
    axes = principal_axes(points)
    return np.array([axes[0], axes[1], np.cross(axes[0], axes[1])])


def oblique(points: np.ndarray, normals: np.ndarray, tilt: float = 40.0) -> np.ndarray:
    """Return the rotation that turns the mean normal up and then `tilt` degrees to the viewer, the widest side horizontal."""
    up = normals.mean(axis=0)
    length = np.linalg.norm(up)
    up = up / length if length > MIN_MEAN_NORMAL else np.array([0.0, 0.0, 1.0])
    across = principal_axes(points, up)[0]
    front = np.cross(across, up)
    c, s = math.cos(math.radians(tilt)), math.sin(math.radians(tilt))
    return np.array([across, c * up - s * front, s * up + c * front])


def aim(points: np.ndarray, rotation: np.ndarray, shape: tuple[int, int]) -> Camera:
    """Return the camera that shows all points with MAX_DISC_RADIUS around them in a picture of `shape` pixels."""
    seen = points @ rotation.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    width, height, _ = high - low + 2 * MAX_DISC_RADIUS
    scale = min(shape[0] / height, shape[1] / width)
    return Camera(rotation, rotation.T @ ((low + high) / 2), float(scale), tuple(shape))


def closing_radius(points: np.ndarray) -> float:
    """Return the radius in Å of discs without gaps: nearly all reach their eighth neighbour, within `MAX_DISC_RADIUS`."""
    from scipy.spatial import cKDTree

    checked = points[:: max(1, len(points) // 5000)]
    reach = cKDTree(points).query(checked, k=[min(9, len(points))])[0]
    return float(np.clip(np.quantile(reach, 0.95), DISC_RADIUS, MAX_DISC_RADIUS))


def draw_surface(
    points: np.ndarray,
    normals: np.ndarray,
    colours: np.ndarray | tuple[float, float, float],
    camera: Camera,
) -> Scene:
    """Draw a closed surface of dots (N, 3), Å, those that face the viewer, as discs without gaps in colours of 0..1."""
    scale = camera.scale * SUPERSAMPLING
    disc = max(closing_radius(points) * scale, 1.0)
    depth = np.full([n * SUPERSAMPLING for n in camera.shape], -np.inf)
    draw_discs(*_project(points, normals, camera), disc, depth)
    scene = Scene(camera, np.ones((*depth.shape, 3), np.float32), depth, _darkness(depth, scale), disc)
    return _paint(scene, points, normals, colours, disc)


def draw_dots(
    scene: Scene,
    points: np.ndarray,
    normals: np.ndarray,
    colours: np.ndarray | tuple[float, float, float],
    radius: float = DISC_RADIUS,
) -> Scene:
    """Draw dots of a surface as small discs on it; arguments as in `draw_surface`."""
    return _paint(scene, points, normals, colours, max(radius * scene.camera.scale * SUPERSAMPLING, 1.0))


def picture(scene: Scene) -> np.ndarray:
    """Return the finished picture, (rows, columns, 3) uint8, with a white background."""
    out = np.empty((*scene.camera.shape, 3), np.uint8)
    _shrink(scene.colour, scene.dark, out)
    return out


def thumbnail(points: np.ndarray, normals: np.ndarray, roughness: np.ndarray) -> np.ndarray:
    """Draw a small picture of a surface in the colours of its roughness, with a scale bar."""
    camera = aim(points, along_smallest_axis(points), THUMBNAIL_PIXELS)
    colours = scale_of("roughness", roughness).colours / 255
    image = picture(draw_surface(points, normals, colours, camera))
    left, bottom, length = CAMERA_MARGIN, image.shape[0] - CAMERA_MARGIN, round(SCALE_BAR * camera.scale)
    image[bottom - 2 : bottom, left : left + length] = 0
    return image


@njit()
def _shrink(colour: np.ndarray, dark: np.ndarray, out: np.ndarray) -> None:
    """Average the darkened rendered pixels of each pixel and round them."""
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            for k in range(3):
                total = 0.0
                for a in range(row * SUPERSAMPLING, (row + 1) * SUPERSAMPLING):
                    for b in range(column * SUPERSAMPLING, (column + 1) * SUPERSAMPLING):
                        total += colour[a, b, k] * dark[a, b]
                mean = min(max(total / SUPERSAMPLING**2, 0.0), 1.0)
                out[row, column, k] = math.floor(255 * mean + 0.5)


def _project(points: np.ndarray, normals: np.ndarray, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Convert dots to rendered pixels (column, row downwards, height to the viewer) and rotate their normals."""
    turn = camera.rotation * np.array([[1.0], [-1.0], [1.0]])
    xyz = (points - camera.centre) @ turn.T * (camera.scale * SUPERSAMPLING)
    xyz[:, :2] += np.array(camera.shape[::-1]) * SUPERSAMPLING / 2
    return xyz, normals @ turn.T


@njit()
def _box(middle: float, half: float, pixels: int) -> tuple[int, int]:
    """Return the first and last pixel whose centre lies within `half` of `middle`."""
    return max(0, math.ceil(middle - half - 0.5)), min(pixels - 1, math.floor(middle + half - 0.5))


@njit()
def draw_discs(
    xyz: np.ndarray,
    normals: np.ndarray,
    radius: float,
    depth: np.ndarray,
    colours: np.ndarray | None = None,
    slack: float = 0.0,
    sums: np.ndarray | None = None,
) -> None:
    """Raise `depth` (R, C) to the discs at `xyz` (N, 3), in rendered pixels.

    With `sums` (R, C, 7), add weight, normal and colour of the discs that lie at most `slack` below `depth` instead.
    """
    for i in range(len(xyz)):
        x, y, z = xyz[i, 0], xyz[i, 1], xyz[i, 2]
        a, b, c = normals[i, 0], normals[i, 1], normals[i, 2]
        if c < MIN_VIEW_COSINE:
            continue
        left, right = _box(x, radius * math.sqrt(max(0.0, 1 - a * a)), depth.shape[1])
        top, bottom = _box(y, radius * math.sqrt(max(0.0, 1 - b * b)), depth.shape[0])
        for row in range(top, bottom + 1):
            dy = row + 0.5 - y
            for column in range(left, right + 1):
                dx = column + 0.5 - x
                dz = -(a * dx + b * dy) / c
                r2 = dx * dx + dy * dy + dz * dz
                if sums is None:  # known at compile time: two kernels from one source
                    if r2 <= radius * radius:
                        depth[row, column] = max(depth[row, column], z + dz)
                    continue
                if r2 > radius * radius or z + dz < depth[row, column] - slack:
                    continue
                near = 1.0 - r2 / (radius * radius)
                weight = near * near + 1e-6  # the centre of a disc counts most
                pixel = sums[row, column]
                pixel[0] += weight
                for k in range(3):
                    pixel[1 + k] += weight * normals[i, k]
                    pixel[4 + k] += weight * colours[i, k]  # type: ignore[index]


def _paint(
    scene: Scene,
    points: np.ndarray,
    normals: np.ndarray,
    colours: np.ndarray | tuple[float, float, float],
    disc: float,
) -> Scene:
    """Add shaded discs (radius in rendered pixels) to a scene."""
    sums = np.zeros((*scene.depth.shape, 7), np.float32)
    # a copy: what is broadcast is read-only, which would be another form of the kernel
    colours = np.array(np.broadcast_to(np.asarray(colours, np.float64), points.shape), order="C")
    draw_discs(*_project(points, normals, scene.camera), disc, scene.depth, colours, scene.slack, sums)
    image = scene.colour.copy()
    light = LIGHT * np.array([1, -1, 1]) / np.linalg.norm(LIGHT)
    _shade(sums, scene.depth, light, image)
    return scene._replace(colour=image)


@njit()
def _shade(sums: np.ndarray, depth: np.ndarray, light: np.ndarray, image: np.ndarray) -> None:
    """Shade blended pixels (R, C, 7) by Lambert's law, paler with depth, into `image` (R, C, 3)."""
    front, back = -np.inf, np.inf
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            front = max(front, depth[row, column])
            if depth[row, column] > -np.inf:
                back = min(back, depth[row, column])
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            pixel, here = sums[row, column], depth[row, column]
            if pixel[0] <= 0 or here == -np.inf:
                continue
            length = math.sqrt(pixel[1] ** 2 + pixel[2] ** 2 + pixel[3] ** 2)
            shine = (pixel[1] * light[0] + pixel[2] * light[1] + pixel[3] * light[2]) / length
            bright = AMBIENT + (1 - AMBIENT) * max(shine, 0.0)
            haze = HAZE * ((front - here) / max(front - back, 1e-9))
            for k in range(3):
                image[row, column, k] = (1 - haze) * pixel[4 + k] / pixel[0] * bright + haze


def _darkness(depth: np.ndarray, scale: float) -> np.ndarray:
    """Return the factor (R, C) that darkens hollows and draws contours at jumps in depth."""
    from scipy.ndimage import maximum_filter, uniform_filter

    drawn = np.isfinite(depth)
    if not drawn.any():
        return np.ones(depth.shape)
    height = np.where(drawn, depth / scale, 0.0).astype(np.float32)
    size = int(2 * HOLLOW * scale) | 1
    around, share = height, drawn.astype(np.float32)
    for _ in range(2):
        around, share = uniform_filter(around, size), uniform_filter(share, size)
    below = around / np.maximum(share, 1e-9) - height
    step = maximum_filter(depth, 2 * SUPERSAMPLING + 1)[drawn] / scale - height[drawn]
    dark = np.ones(depth.shape)
    dark[drawn] = 1 - 0.35 * (below[drawn] / HOLLOW).clip(0, 1)
    dark[drawn] *= 1 - 0.55 * ((step - CONTOUR_DEPTH) / CONTOUR_DEPTH).clip(0, 1)
    return dark
