"""How far apart the dots of a surface lie, what area they cover, and whether that suits a linking distance."""

import math

import numpy as np
from numba import njit

from sparsurf import InputError
from sparsurf.surfaces.surface import DENSITY as DENSITY  # which users of spacings know from here
from sparsurf.surfaces.surface import nearest_of
from sparsurf.surfaces.vectors import apart2, cells_of, column, point

SPARSE = 1.3  # D_link must exceed this many times the median spacing, else patches shatter
NEIGHBOURS = 6  # for the area from dots alone: within 2 % on surfaces whose area is known
SAMPLE = 16  # dots that tell what cubes suit the others
MOST_CUBES = 1e6  # along an edge of the box
DENSER = (
    "use a denser surface (of a structure, leave out its density; of a subset, `sparsurf recover` makes one)"
)


def area_of(surface):
    """Area of a surface in Å^2, and whether it had to be estimated from the spacing of the dots; NaN of a single dot."""
    from scipy.spatial import cKDTree  # here: it takes half a second, and most surfaces know their area

    area = getattr(surface, "area", np.nan)
    if np.isfinite(area).all():
        return float(np.sum(area)), False
    k = min(NEIGHBOURS, len(surface.points) - 1)
    if k == 0:
        return float("nan"), True
    radius = cKDTree(surface.points).query(surface.points, k=k + 1)[0][:, k]
    return float(np.pi * np.sum(radius**2) / k), True


def spacing(points):
    """Median distance in Å from a dot to its nearest other dot (NaN for a single dot), for `points` (N, 3)."""
    if len(points) < 2:
        return float("nan")
    return float(np.median(nearest(points)))


def nearest(points):
    """Distance in Å from every dot to its nearest other dot, (N,), for `points` (N, 3) of at least two dots."""
    points = np.ascontiguousarray(points, dtype=float)
    gaps, _ = nearest_of(points, np.arange(0, len(points), -(-len(points) // SAMPLE)))
    # Cubes that hold the neighbours of most dots; larger ones for those that find none there
    size = max(2 * np.median(gaps), np.ptp(points, axis=0).max() / MOST_CUBES) or 1.0
    found = np.full(len(points), np.inf)
    while np.isinf(found).any():
        _look(points, cells_of(points, size), found)
        size *= 2
    return found


@njit(cache=True, nogil=True)
def _look(points, cells, found):
    """Fill in the distances that are not known yet, where they are at most the edge of a cube."""
    for i in range(len(points)):
        if found[i] < np.inf:
            continue
        place, best = point(points, i), np.inf
        for c in range(9):
            slot, last = column(cells, place, c)
            while slot < len(cells.key) and cells.key[slot] <= last:
                k = cells.order[slot]
                slot += 1
                if k != i:
                    best = min(best, apart2(point(points, k), place))
        if best <= cells.size**2:
            found[i] = math.sqrt(best)


def refuse_sparse(points, d_link, name, remedy=f"{DENSER} or a larger D_link"):
    """Raise InputError, with what to do, where `d_link` is too short for the dots of the surface called `name`."""
    if len(points) == 1:
        raise InputError(f"{name}: one dot alone makes no patch; give the dots of a surface.")
    gap = spacing(points)
    if d_link < SPARSE * gap:
        raise InputError(
            f"{name}: D_link = {d_link:g} Å is below {SPARSE} times the median distance between neighbouring dots "
            f"({gap:.3f} Å), so every patch would fall apart; {remedy}."
        )
