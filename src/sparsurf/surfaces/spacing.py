"""Spacing of the dots of a surface, the area that they cover, and whether the spacing suits a linking distance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import InputError, argument
from sparsurf.kernels import njit
from sparsurf.surfaces.surface import DENSITY as DENSITY  # re-exported: most users import it from here
from sparsurf.surfaces.vectors import point, squared_distance

if TYPE_CHECKING:
    from sparsurf.surfaces.surface import Surface

MIN_RADIUS_PER_SPACING = 2  # a smaller patch holds a dot and its next neighbours, whose normals hardly differ
MIN_D_LINK_PER_SPACING = 1.3  # below this many median spacings, d_link breaks patches into pieces
N_NEIGHBOURS = 6  # that estimate the area: within 2 % on surfaces whose area is known
SPACING_SAMPLE = 16  # dots that the size of the cubes is estimated from
CUBE_PER_SPACING = 1.2  # edge of a cube per median spacing of a few dots
CUBES_PER_DOT = 4
MAX_CUBES_PER_AXIS = 1e6
DENSER_SURFACE_REMEDY = (
    "use a denser surface (of a structure, leave out its density; of a subset, `sparsurf recover` makes one)"
)


def area_of(surface: Surface) -> tuple[float, bool]:
    """Return the area of a surface, Å^2, and whether it is an estimate from the spacing of its dots; NaN for a single dot."""
    area = getattr(surface, "area", np.nan)
    if np.isfinite(area).all() and np.sum(area) > 0:
        return float(np.sum(area)), False
    return float(np.sum(estimated_areas(surface.points, np.arange(len(surface.points))))), True


def estimated_areas(points: np.ndarray, dots: np.ndarray) -> np.ndarray:
    """Estimate the area, (n,) Å^2, of some dots of a surface (N, 3) from their distances to others; NaN for a single dot."""
    from scipy.spatial import cKDTree  # here: it takes long to load, and most surfaces know their area

    k = min(N_NEIGHBOURS, len(points) - 1)
    if k == 0:
        return np.full(len(dots), np.nan)
    return np.pi * np.asarray(cKDTree(points).query(points[dots], k=k + 1)[0])[:, k] ** 2 / k


def spacing(points: np.ndarray, cube: float | None = None, near: float = 0.0) -> float:
    """Return the median distance from a dot to its nearest other dot, Å; NaN for one dot. If at most `near`, it is a bound."""
    if len(points) < 2:
        return float("nan")
    middle = [(len(points) - 1) // 2, len(points) // 2]
    distances = nearest_distances(points, cube, middle[1] + 1, near)
    low, high = np.partition(distances, middle)[middle]
    if low <= near < high:  # the median may lie above `near`, and one of both is not exact
        return spacing(points, cube)
    return float(np.median(distances))


def nearest_distances(
    points: np.ndarray, cube: float | None = None, n_shortest: int | None = None, near: float = 0.0
) -> np.ndarray:
    """Measure the distance from every dot (N, 3) to its nearest other dot, (N,) Å.

    The edge `cube` of the cubes in which neighbours are searched first changes the time only. Only the `n_shortest` distances are
    needed, others may be infinite. The search for the nearest dot ends at a dot that is at most `near` away.
    """
    points = np.ascontiguousarray(points, dtype=float)
    if cube is None:
        gaps, _ = nearest_neighbours(points, np.arange(0, len(points), -(-len(points) // SPACING_SAMPLE)))
        cube = CUBE_PER_SPACING * float(np.median(gaps))
    n_needed = len(points) if n_shortest is None else n_shortest
    # Cubes that hold the neighbours of most dots; twice as large for the dots that find none
    low = np.array([axis.min() for axis in points.T])  # ten times faster than over axis 0
    extent = np.array([axis.max() for axis in points.T]) - low
    size = max(cube, extent.max() / MAX_CUBES_PER_AXIS) or 1.0
    distances = np.full(len(points), np.inf)
    while np.count_nonzero(distances < np.inf) < n_needed:
        n_y, n_z = (extent[1:] // size).astype(np.int64) + 3
        # Columns along z share places in the table of cubes, so that it grows with the dots and not with the box
        n_columns = 1 << max(0, int(CUBES_PER_DOT * len(points) / n_z).bit_length())
        _search_cubes(points, low, size, n_y, n_z, n_columns, near, distances)
        size *= 2
    return distances


@njit(error_model="numpy")
def _search_cubes(
    points: np.ndarray,
    low: np.ndarray,
    size: float,
    n_y: int,
    n_z: int,
    n_columns: int,
    near: float,
    distances: np.ndarray,
) -> None:
    """Fill in the distances that are still infinite, where they are at most the edge of a cube, for dots sorted by cube.

    The column of cubes `x n_y + y` stands at its number modulo `n_columns`, a power of 2.
    """
    n = len(points)
    first = np.zeros(n_columns * n_z + 1, np.int32)  # of each cube, the first dot among the sorted ones
    cube = np.empty(n, np.int32)
    for i in range(n):
        x, y, z = point(points, i)
        column = (int((x - low[0]) / size) + 1) * n_y + int((y - low[1]) / size) + 1
        cube[i] = (column & (n_columns - 1)) * n_z + int((z - low[2]) / size) + 1
        first[cube[i] + 1] += 1
    for c in range(n_columns * n_z):
        first[c + 1] += first[c]
    order, place = np.empty(n, np.int32), first[:-1].copy()
    for i in range(n):
        order[place[cube[i]]] = i
        place[cube[i]] += 1
    sorted_points = np.empty((n, 3))
    for k in range(n):
        for a in range(3):
            sorted_points[k, a] = points[order[k], a]
    for k in range(n):
        i = order[k]
        if distances[i] < np.inf:
            continue
        position, best = point(sorted_points, k), np.inf
        x, y = int((position[0] - low[0]) / size), int((position[1] - low[1]) / size)
        z = int((position[2] - low[2]) / size)
        for c in range(4, 13):  # the column of the dot itself first
            column = ((x + c % 9 // 3) * n_y + y + c % 3) & (n_columns - 1)
            for other in range(first[column * n_z + z], first[column * n_z + z + 3]):
                squared = squared_distance(point(sorted_points, other), position)
                if squared < best and other != k:
                    best = squared
            if best <= near**2:
                break
        if best <= size**2:
            distances[i] = math.sqrt(best)


def refuse_sparse(
    points: np.ndarray,
    d_link: float,
    name: str,
    remedy: str = f"{DENSER_SURFACE_REMEDY} or a larger {argument('patches.d_link')}",
    radii: Mapping[str, float] = MappingProxyType({}),
) -> None:
    """Raise InputError if the dots lie too far apart for d_link or for radii of patches, by name, or there is only one dot."""
    if len(points) == 1:
        raise InputError(f"{name}: a single dot has no patch; give all dots of a surface.")
    gap = spacing(points)
    if d_link < MIN_D_LINK_PER_SPACING * gap:
        raise InputError(
            f"{name}: {argument('patches.d_link')} = {d_link:g} Å is below {MIN_D_LINK_PER_SPACING} times the median "
            "distance between "
            f"neighbouring dots ({gap:.3f} Å), so every patch would be fragmented; {remedy}."
        )
    for key, radius in radii.items():
        if radius < MIN_RADIUS_PER_SPACING * gap:
            raise InputError(
                f"{name}: {argument(key)} = {radius:g} Å is below {MIN_RADIUS_PER_SPACING} times the median distance between "
                f"neighbouring dots ({gap:.3f} Å), so that a patch would hold little more than its own dot; give a larger "
                "radius, in Å."
            )


def nearest_neighbours(points: np.ndarray, sample: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the nearest other dot of a few dots, without a compiled kernel: distances (n,), Å, and indices (n,)."""
    distances, neighbours = np.empty(len(sample)), np.empty(len(sample), int)
    x, y, z = np.ascontiguousarray(points.T)
    for n, i in enumerate(sample):
        squared = (x - x[i]) ** 2 + (y - y[i]) ** 2 + (z - z[i]) ** 2  # three times faster than a sum
        squared[i] = np.inf
        neighbours[n] = squared.argmin()
        distances[n] = math.sqrt(squared[neighbours[n]])
    return distances, neighbours
