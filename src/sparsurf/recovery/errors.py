"""Distances between a reconstructed surface and the full one, overall and in clefts, flats and ridges."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import R_ZERNIKE, PatchIndex, ball, ball_bound
from sparsurf.recovery.interpolated_surface import CELL, interpolate_surface
from sparsurf.surfaces.exact_distance import distance_of_dots
from sparsurf.surfaces.grid import nearest_dots, sort_into_grid
from sparsurf.surfaces.molecular_surface import RolledFrame
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.vectors import point
from sparsurf.threads import parallel_map

if TYPE_CHECKING:
    import pandas as pd

# Dots per Å^2 of the reconstructed surface from which errors are measured; three times as many change them by 2 %.
DENSITY_FOR_ERRORS = 20.0
MIN_CURVATURE = 0.05  # 1/Å, that of a sphere of 20 Å: a more curved patch is a cleft or a ridge
EVERYWHERE = "everywhere"
EVERY = 16  # n-th dot of a surface whose spacing is measured
FIRST_REACH = (
    0.25  # Å, around a point in which the nearest dot is first looked for: dense dots are so far apart
)
TAIL_QUANTILE = 0.99  # of the distances, reported next to mean and largest


def distance_to_recovered(
    points: np.ndarray, kept: np.ndarray, normals: np.ndarray, threads: int = 1, density: float = DENSITY
) -> np.ndarray:
    """Compute the distance of every dot from the surface reconstructed from the kept ones (n, 3), (N,) Å, at `density` per Å²."""
    return distance_to_surface(points, *interpolate_surface(kept, normals, density, threads=threads), threads)


def distance_to_surface(
    points: np.ndarray,
    surface_points: np.ndarray,
    surface_normals: np.ndarray,
    threads: int = 1,
    true: RolledFrame | None = None,
) -> np.ndarray:
    """Compute the distance (M,), Å, of points from dense dots: from the plane of the nearest, or from it if farther off.

    If the points lie on the surface of known spheres, `true`, the exact distance of the nearest dot from that surface takes the
    place of the plane, from which a curved surface deviates by about 0.002 Å between dots. A surface with the concave parts
    that DMS leaves inside other probes is not that of its spheres, and is measured by planes.
    """
    cells = sort_into_grid(surface_points, CELL)
    points = np.ascontiguousarray(points, float)
    nearest, distance = nearest_dots(cells, points, FIRST_REACH, threads=threads)
    if true is not None and true.exact:
        used, place = np.unique(nearest, return_inverse=True)  # points between few dots share the nearest one
        height = distance_of_dots(surface_points[used], surface_normals[used], true, threads)[place]
    else:
        height = np.abs(np.einsum("ij,ij->i", points - surface_points[nearest], surface_normals[nearest]))
    spacing = 0.0
    if len(surface_points) > 1:
        measured = np.argsort(cells.dot)[::EVERY]  # positions of every so manyth dot
        spacing = np.median(nearest_dots(cells, cells.xyz[measured], FIRST_REACH, measured, threads)[1])
    # A dot says nothing beyond its neighbours: over a hole, a height of 0 would hide the error
    return np.where(distance <= 2 * spacing, height, distance)


def curvature(index: PatchIndex, radius: float = R_ZERNIKE, threads: int = 1) -> np.ndarray:
    """Compute the mean curvature at every dot, 1/Å, by a paraboloid within `radius` Å: 1 / a on a sphere, concave below 0."""
    out, max_dots = np.zeros(len(index.dot)), ball_bound(index, index.xyz, radius) + 1
    parallel_map(
        lambda begin, end: _curvature(index, begin, end, float(radius), max_dots, out), len(out), threads
    )
    return out


@njit()
def _curvature(
    index: PatchIndex, begin: int, end: int, radius: float, max_dots: int, out: np.ndarray
) -> None:
    """Write the curvature at the positions of a slice."""
    nearby, mean_normal, sum_of_offsets = np.empty(max_dots, np.int32), np.zeros(3), np.zeros(3)
    for p in range(begin, end):
        m = ball(index, point(index.xyz, p), radius, nearby)
        mean_normal[:], sum_of_offsets[:], squares = 0.0, 0.0, 0.0
        for e in range(m):
            q = nearby[e]
            cosine = 0.0
            for c in range(3):
                cosine += index.normals[p, c] * index.normals[q, c]
            # Dots that face the other way lie on the far side of a thin wall
            if cosine > 0.0:
                for c in range(3):
                    offset = index.xyz[q, c] - index.xyz[p, c]
                    mean_normal[c] += index.normals[q, c]
                    sum_of_offsets[c] += offset
                    squares += offset**2
        length = math.sqrt(np.sum(mean_normal**2))
        if squares > 0.0 and length > 0.0:
            out[index.dot[p]] = -2.0 * np.sum(sum_of_offsets * mean_normal) / (length * squares)


def kept_out(values: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Return the values of the dots that are not among the kept ones: these lie on the reconstructed surface by construction."""
    return np.delete(values, kept, axis=0)


def error_table(distance: np.ndarray, curvature: np.ndarray | None, kept: np.ndarray) -> pd.DataFrame:
    """Summarise the errors (Å) of the dots that were not kept, everywhere, in clefts, flats and ridges: rows of recovered.csv.

    Without a curvature there is the first row alone.
    """
    distance = kept_out(distance, kept)
    regions = {EVERYWHERE: np.full(len(distance), True)}
    if curvature is not None:
        bend = kept_out(curvature, kept)
        regions |= {"clefts": bend < -MIN_CURVATURE, "flats": np.abs(bend) <= MIN_CURVATURE}
        regions["ridges"] = bend > MIN_CURVATURE
    rows = []
    for name, inside in regions.items():
        errors = distance[inside] if inside.any() else np.array([np.nan])
        rows.append(
            {
                "where": name,
                "dots": int(inside.sum()),
                "dots_percent": 100 * inside.mean() if len(inside) else np.nan,
                "mean": errors.mean(),
                "high_99": np.quantile(errors, TAIL_QUANTILE),
                "largest": errors.max(),
            }
        )
    import pandas as pd  # here: it takes long to load

    return pd.DataFrame(rows)
