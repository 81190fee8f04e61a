"""How far apart the dots of a surface lie, what area they cover, and whether that suits a linking distance."""

import numpy as np
from scipy.spatial import cKDTree

from sparsurf import InputError

# Dots per Å^2 that count as DMS's `-d 1.0`; A1 of TDP-43 gets 20045 dots on 3742 Å^2.
DENSITY = 5.35
SPARSE = 1.3  # D_link must exceed this many times the median spacing, else patches shatter
NEIGHBOURS = 6  # for the area from dots alone: within 2 % on surfaces whose area is known


def area_of(surface):
    """Area of a surface in Å^2, and whether it had to be estimated from the spacing of the dots."""
    area = getattr(surface, "area", np.nan)
    if np.isfinite(area).all():
        return float(np.sum(area)), False
    k = min(NEIGHBOURS, len(surface.points) - 1)
    radius = cKDTree(surface.points).query(surface.points, k=k + 1)[0][:, k]
    return float(np.pi * np.sum(radius**2) / k), True


def spacing(points):
    """Median distance in Å from a dot to its nearest other dot (NaN for a single dot), for `points` (N, 3)."""
    if len(points) < 2:
        return float("nan")
    return float(np.median(cKDTree(points).query(points, k=2)[0][:, 1]))


def refuse_sparse(points, d_link, name):
    """Raise InputError where `d_link` is too short for the dots of the surface called `name`."""
    gap = spacing(points)
    if d_link < SPARSE * gap:
        raise InputError(
            f"{name}: D_link = {d_link:g} Å is below {SPARSE} times the median distance between neighbouring dots "
            f"({gap:.3f} Å), so every patch would fall apart; use a denser surface or a larger patches.D_link."
        )
