"""Spacing of the dots of a surface, the area that they cover, and whether the spacing suits a linking distance."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from sparsurf import InputError
from sparsurf.kernel_cache import njit
from sparsurf.surfaces.surface import DENSITY as DENSITY  # re-exported: most users import it from here
from sparsurf.surfaces.surface import nearest_neighbours
from sparsurf.surfaces.vectors import Cells, point, sort_into_cells, squared_distance

if TYPE_CHECKING:
    from sparsurf.surfaces.surface import Surface

MIN_D_LINK_PER_SPACING = 1.3  # below this many median spacings, D_link breaks patches into pieces
N_NEIGHBOURS = 6  # that estimate the area: within 2 % on surfaces whose area is known
SAMPLE_SIZE = 16  # dots that the size of the cubes is estimated from
MAX_CUBES_PER_AXIS = 1e6
DENSER_SURFACE_REMEDY = (
    "use a denser surface (of a structure, leave out its density; of a subset, `sparsurf recover` makes one)"
)


def area_of(surface: Surface) -> tuple[float, bool]:
    """Return the area of a surface, or an estimate from the spacing of its dots.

    Parameters
    ----------
    surface : Surface, or any object with `points` and, where known, `area`

    Returns
    -------
    area : float, Å^2; NaN for a single dot of unknown area
    estimated : bool, whether the area is an estimate
    """
    from scipy.spatial import (
        cKDTree,
    )  # imported here: it takes half a second, and most surfaces know their area

    area = getattr(surface, "area", np.nan)
    if np.isfinite(area).all():
        return float(np.sum(area)), False
    k = min(N_NEIGHBOURS, len(surface.points) - 1)
    if k == 0:
        return float("nan"), True
    radius = np.asarray(cKDTree(surface.points).query(surface.points, k=k + 1)[0])[:, k]
    return float(np.pi * np.sum(radius**2) / k), True


def spacing(points: np.ndarray, cube: float | None = None) -> float:
    """Return the median distance from a dot to its nearest other dot, Å; NaN for a single dot.

    Parameters
    ----------
    points, cube : as for `nearest_distances`
    """
    if len(points) < 2:
        return float("nan")
    return float(np.median(nearest_distances(points, cube)))


def nearest_distances(points: np.ndarray, cube: float | None = None) -> np.ndarray:
    """Measure the distance from every dot to its nearest other dot.

    Parameters
    ----------
    points : (N, 3) float64, Å, at least two
    cube : float, optional
        Å, edge of the cubes in which neighbours are sought first; it changes the time and not the distances. Without it,
        the distances of a few dots tell it.

    Returns
    -------
    (N,) float64, Å
    """
    points = np.ascontiguousarray(points, dtype=float)
    if cube is None:
        gaps, _ = nearest_neighbours(points, np.arange(0, len(points), -(-len(points) // SAMPLE_SIZE)))
        cube = 2 * float(np.median(gaps))
    # Cubes that hold the neighbours of most dots; twice as large for the dots that find none
    size = max(cube, np.ptp(points, axis=0).max() / MAX_CUBES_PER_AXIS) or 1.0
    distances = np.full(len(points), np.inf)
    while np.isinf(distances).any():
        cells = sort_into_cells(points, size)
        _search_cubes(points[cells.order], cells, distances)
        size *= 2
    return distances


@njit(cache=True, nogil=True)
def _search_cubes(points: np.ndarray, cells: Cells, distances: np.ndarray) -> None:
    """Fill in the distances that are still infinite, where they are at most the edge of a cube.

    `points` are in the order of the cells. From cube to cube, the dots of each of the nine columns around it only move on.
    """
    n, begin = len(cells.key), 0
    first, last = np.zeros(9, np.int64), np.zeros(9, np.int64)
    while begin < n:
        key, end = cells.key[begin], begin + 1
        while end < n and cells.key[end] == key:
            end += 1
        for c in range(9):
            low = key + ((c // 3 - 1) * cells.shape[0] + c % 3 - 1) * cells.shape[1] - 1
            while first[c] < n and cells.key[first[c]] < low:
                first[c] += 1
            last[c] = max(last[c], first[c])
            while last[c] < n and cells.key[last[c]] <= low + 2:
                last[c] += 1
        for i in range(begin, end):
            if distances[cells.order[i]] < np.inf:
                continue
            position, best = point(points, i), np.inf
            for c in range(9):
                for k in range(first[c], last[c]):
                    if k != i:
                        best = min(best, squared_distance(point(points, k), position))
            if best <= cells.size**2:
                distances[cells.order[i]] = math.sqrt(best)
        begin = end


def refuse_sparse(
    points: np.ndarray,
    d_link: float,
    name: str,
    remedy: str = f"{DENSER_SURFACE_REMEDY} or a larger D_link",
) -> None:
    """Raise an error if D_link is too short for the dots.

    Parameters
    ----------
    points : (N, 3) float64, Å
    d_link : float, Å
    name : str, name of the surface in the message
    remedy : str, end of the message

    Raises
    ------
    InputError
        D_link is below `MIN_D_LINK_PER_SPACING` median spacings, or there is only one dot.
    """
    if len(points) == 1:
        raise InputError(f"{name}: one dot alone makes no patch; give the dots of a surface.")
    gap = spacing(points)
    if d_link < MIN_D_LINK_PER_SPACING * gap:
        raise InputError(
            f"{name}: D_link = {d_link:g} Å is below {MIN_D_LINK_PER_SPACING} times the median distance between "
            f"neighbouring dots ({gap:.3f} Å), so every patch would fall apart; {remedy}."
        )
