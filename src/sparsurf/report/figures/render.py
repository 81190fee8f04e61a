"""Pictures of a dot surface: every dot an oriented disc, in an orthographic view.

A first pass over the discs finds the depth of the front surface at every pixel; a second one
blends normals and colours of the discs that lie in that front layer. The order of the dots
does not matter, and memory goes with the pixels only.
Sources: Zwicker et al., Surface splatting, SIGGRAPH 2001 (here without its filter); darkened
hollows: Luft et al., Image enhancement by unsharp masking the depth buffer, SIGGRAPH 2006.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

SUPERSAMPLING = 2  # pixels drawn per pixel of the picture, along each side
EDGE_ON = 0.05  # discs with a smaller cosine to the viewer are not drawn, nor are those that face away
LIGHT = np.array([-0.45, 0.55, 0.70])  # direction of the lamp: above left, in front
AMBIENT = 0.45  # brightness of what the lamp does not reach
HAZE = 0.25  # share of white in the colour of the farthest dot
HOLLOW = 1.2  # Å, size and depth of the hollows that are darkened
STEP = 2.0  # Å, jump in depth from which on a contour is drawn
DOT = 0.2  # Å, radius of the disc of a kept dot
LARGEST = 1.2  # Å, of discs that stand for the surface around a dot: the curvature of a hydrogen
ROUGH = 0.2, 0.9  # R_i at the ends of the colours: the same for all surfaces, so that they can be compared
PALE = (0.92, 0.92, 0.92)  # surface behind the dots of a subset


class Camera(NamedTuple):
    """Orthographic view.

    rotation : (3, 3) float64, rows point right, up and to the viewer
    centre : (3,) float64, Å, point in the middle of the picture
    scale : float, pixels per Å
    shape : rows and columns of the picture
    """

    rotation: np.ndarray
    centre: np.ndarray
    scale: float
    shape: tuple

    @property
    def extent(self):
        """Left, right, bottom and top of the picture in Å."""
        height, width = (n / self.scale / 2 for n in self.shape)
        return -width, width, -height, height


class Scene(NamedTuple):
    """A drawn surface, to which dots can be added; R and C are rows and columns drawn.

    camera : Camera
    colour : (R, C, 3) float32, 0..1
    depth : (R, C) float64, drawn pixels towards the viewer, -inf where nothing is
    dark : (R, C) float64, factor for hollows and contours
    slack : float, drawn pixels below the front that still count as front
    """

    camera: Camera
    colour: np.ndarray
    depth: np.ndarray
    dark: np.ndarray
    slack: float


def along_smallest_axis(points):
    """Rotation that looks along the smallest principal axis, the largest one lying across.

    The longer tail of an axis points right or up, so that the view does not depend on how the
    molecule was turned.
    """
    x = points - points.mean(axis=0)
    axes = np.linalg.eigh(x.T @ x)[1].T[::-1]
    axes = axes * np.where(((x @ axes.T) ** 3).sum(axis=0) < 0, -1.0, 1.0)[:, None]
    return np.array([axes[0], axes[1], np.cross(axes[0], axes[1])])


def oblique(points, normals, tilt=40.0):
    """Rotation that turns the mean normal up and then `tilt` degrees to the viewer; the widest side lies across."""
    up = normals.mean(axis=0)
    length = np.linalg.norm(up)
    up = up / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])
    x = points - points.mean(axis=0)
    x = x - np.outer(x @ up, up)
    across = np.linalg.eigh(x.T @ x - 1e6 * len(x) * np.outer(up, up))[1][:, -1]
    front = np.cross(across, up)
    c, s = math.cos(math.radians(tilt)), math.sin(math.radians(tilt))
    return np.array([across, c * up - s * front, s * up + c * front])


def aim(points, rotation, shape, margin=LARGEST):
    """Camera that holds all points with `margin` Å around them in a picture of `shape` pixels."""
    seen = points @ rotation.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    width, height, _ = high - low + 2 * margin
    scale = min(shape[0] / height, shape[1] / width)
    return Camera(rotation, rotation.T @ ((low + high) / 2), float(scale), tuple(shape))


def closing_radius(points):
    """Radius in Å of discs that leave no gaps: nearly all reach their eighth neighbour, within `LARGEST`."""
    from scipy.spatial import cKDTree

    some = points[:: max(1, len(points) // 5000)]
    reach = cKDTree(points).query(some, k=[min(9, len(points))])[0]
    return float(np.clip(np.quantile(reach, 0.95), DOT, LARGEST))


def draw_surface(points, normals, colours, camera, radius=None):
    """Draw a closed surface.

    Parameters
    ----------
    points, normals : (N, 3) float64
        Å; unit outward normals. Dots that face away from the viewer are left out.
    colours : (N, 3) float64, or 3 numbers for all
        Red, green, blue in 0..1.
    camera : Camera
    radius : float, optional
        Of the discs, in Å; `closing_radius` without.

    Returns
    -------
    Scene
    """
    scale = camera.scale * SUPERSAMPLING
    disc = max((closing_radius(points) if radius is None else radius) * scale, 1.0)
    depth = np.full([n * SUPERSAMPLING for n in camera.shape], -np.inf)
    draw_discs(*_project(points, normals, camera), disc, depth)
    scene = Scene(camera, np.ones((*depth.shape, 3), np.float32), depth, _darkness(depth, scale), disc)
    return _paint(scene, points, normals, colours, disc)


def draw_dots(scene, points, normals, colours, radius=DOT):
    """Draw dots of a surface as small discs upon it; arguments as in `draw_surface`."""
    return _paint(scene, points, normals, colours, max(radius * scene.camera.scale * SUPERSAMPLING, 1.0))


def picture(scene):
    """Finished picture, (rows, columns, 3) uint8, white where nothing was drawn."""
    out = np.empty((*scene.camera.shape, 3), np.uint8)
    _shrink(scene.colour, scene.dark, out)
    return out


@njit(cache=True, nogil=True)
def _shrink(colour, dark, out):
    """Means of the drawn pixels behind each pixel, darkened, as whole numbers."""
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            for k in range(3):
                total = 0.0
                for a in range(row * SUPERSAMPLING, (row + 1) * SUPERSAMPLING):
                    for b in range(column * SUPERSAMPLING, (column + 1) * SUPERSAMPLING):
                        total += colour[a, b, k] * dark[a, b]
                mean = min(max(total / SUPERSAMPLING**2, 0.0), 1.0)
                out[row, column, k] = math.floor(255 * mean + 0.5)


def _project(points, normals, camera):
    """Dots in drawn pixels: column, row (downwards) and height to the viewer; and their normals."""
    turn = camera.rotation * np.array([[1.0], [-1.0], [1.0]])
    xyz = (points - camera.centre) @ turn.T * (camera.scale * SUPERSAMPLING)
    xyz[:, :2] += np.array(camera.shape[::-1]) * SUPERSAMPLING / 2
    return xyz, normals @ turn.T


@njit(cache=True, nogil=True)
def _box(middle, half, pixels):
    """First and last pixel whose centre lies within `half` of `middle`."""
    return max(0, math.ceil(middle - half - 0.5)), min(pixels - 1, math.floor(middle + half - 0.5))


@njit(cache=True, nogil=True)
def draw_discs(xyz, normals, radius, depth, colours=None, slack=0.0, sums=None):
    """Raise `depth` (R, C) to the discs at `xyz` (N, 3), without `sums`; all lengths in drawn pixels.

    With `sums` (R, C, 7), add weight, normal and colour of those that lie at most `slack` below `depth`.
    """
    for i in range(len(xyz)):
        x, y, z = xyz[i, 0], xyz[i, 1], xyz[i, 2]
        a, b, c = normals[i, 0], normals[i, 1], normals[i, 2]
        if c < EDGE_ON:
            continue
        left, right = _box(x, radius * math.sqrt(max(0.0, 1 - a * a)), depth.shape[1])
        top, bottom = _box(y, radius * math.sqrt(max(0.0, 1 - b * b)), depth.shape[0])
        for row in range(top, bottom + 1):
            dy = row + 0.5 - y
            for column in range(left, right + 1):
                dx = column + 0.5 - x
                dz = -(a * dx + b * dy) / c
                r2 = dx * dx + dy * dy + dz * dz
                if sums is None:  # known to the compiler: two kernels of one text
                    if r2 <= radius * radius:
                        depth[row, column] = max(depth[row, column], z + dz)
                    continue
                if r2 > radius * radius or z + dz < depth[row, column] - slack:
                    continue
                near = 1.0 - r2 / (radius * radius)
                weight = near * near + 1e-6  # the middle of a disc counts most, its rim still counts
                pixel = sums[row, column]
                pixel[0] += weight
                for k in range(3):
                    pixel[1 + k] += weight * normals[i, k]
                    pixel[4 + k] += weight * colours[i, k]


def _paint(scene, points, normals, colours, disc):
    """Scene with shaded discs (radius in drawn pixels) on those of its pixels that they reach."""
    sums = np.zeros((*scene.depth.shape, 7), np.float32)
    colours = np.ascontiguousarray(np.broadcast_to(np.asarray(colours, np.float64), points.shape))
    draw_discs(*_project(points, normals, scene.camera), disc, scene.depth, colours, scene.slack, sums)
    image = scene.colour.copy()
    lamp = LIGHT * np.array([1, -1, 1]) / np.linalg.norm(LIGHT)
    _shade(sums, scene.depth, lamp, image)
    return scene._replace(colour=image)


@njit(cache=True, nogil=True)
def _shade(sums, depth, lamp, image):
    """Lambert shading, paler with depth, of blended pixels (R, C, 7) into `image` (R, C, 3)."""
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
            shine = (pixel[1] * lamp[0] + pixel[2] * lamp[1] + pixel[3] * lamp[2]) / length
            bright = AMBIENT + (1 - AMBIENT) * max(shine, 0.0)
            haze = HAZE * ((front - here) / max(front - back, 1e-9))
            for k in range(3):
                image[row, column, k] = (1 - haze) * pixel[4 + k] / pixel[0] * bright + haze


def _darkness(depth, scale):
    """Factor (R, C) that darkens hollows and draws the contour of what lies in front of something."""
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
    dark[drawn] *= 1 - 0.55 * ((step - STEP) / STEP).clip(0, 1)
    return dark
