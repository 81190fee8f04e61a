"""How far the surface recovered from a subset and the whole one lie apart, with tails, and where: clefts, flats, ridges."""

import math

import numpy as np
import pandas as pd
from numba import njit
from scipy.spatial import cKDTree

from sparsurf.patches.index import R_ZERNIKE, ball, ball_bound
from sparsurf.recovery.recovering import recover
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.threads import parallel_map

DENSE = 20.0  # dots per Å^2 of a recovered surface from which errors are measured; three times as many change them by 2 %
BEND = 0.05  # 1/Å: a patch that bends more, as a sphere of 20 Å does, is a cleft or a ridge
EVERYWHERE = "everywhere"
TAIL = 0.99  # share of the dots whose largest error is told


def off_recovered(points, kept, normals, threads=1, density=DENSITY):
    """Distance of every dot from the surface that the kept ones describe.

    Parameters
    ----------
    points : (N, 3) float64, Å
    kept, normals : (n, 3) float64
        Places and normals of the subset.
    threads : int
    density : float
        Dots per Å^2 of the recovered surface.

    Returns
    -------
    (N,) float64, Å, see `off`.
    """
    return off(points, *recover(kept, normals, density, threads=threads), threads)


def off(points, places, outward, threads=1):
    """Distance of points (M, 3) from the surface of dense dots, their places and normals (N, 3); (M,) float64, Å.

    To the tangent plane of the nearest dot, or to that dot itself where it lies farther than the dots lie apart.
    """
    gap, nearest = cKDTree(places).query(points, workers=threads)
    aside = np.abs(np.einsum("ij,ij->i", points - places[nearest], outward[nearest]))
    apart = np.median(cKDTree(places).query(places, k=2)[0][:, 1]) if len(places) > 1 else 0.0
    return np.where(gap <= 2 * apart, aside, gap)


def curvature(index, radius=R_ZERNIKE, threads=1):
    """How the surface bends around every dot: 1 / a on a sphere of radius a, negative where it is hollow.

    A paraboloid along the mean normal of the dots on the same side within `radius`, fitted to their places.

    Parameters
    ----------
    index : PatchIndex
    radius : float, Å
    threads : int

    Returns
    -------
    (N,) float64, 1/Å, by dot; 0 for a dot without others
    """
    out, room = np.zeros(len(index.dot)), ball_bound(index, index.xyz, radius) + 1
    parallel_map(lambda a, b: _bend(index, a, b, float(radius), room, out), len(out), threads)
    return out


@njit(cache=True, nogil=True)
def _bend(index, begin, end, radius, room, out):
    found, mean, sum_of = np.empty(room, np.int32), np.zeros(3), np.zeros(3)
    for p in range(begin, end):
        m = ball(index, index.xyz[p, 0], index.xyz[p, 1], index.xyz[p, 2], radius, found)
        mean[:], sum_of[:], squares = 0.0, 0.0, 0.0
        for e in range(m):
            q = found[e]
            cosine = 0.0
            for c in range(3):
                cosine += index.normals[p, c] * index.normals[q, c]
            if cosine > 0.0:
                for c in range(3):
                    aside = index.xyz[q, c] - index.xyz[p, c]
                    mean[c] += index.normals[q, c]
                    sum_of[c] += aside
                    squares += aside**2
        length = math.sqrt(np.sum(mean**2))
        if squares > 0.0 and length > 0.0:
            out[index.dot[p]] = -2.0 * np.sum(sum_of * mean) / (length * squares)


def tails(distance, bend):
    """Mean, 99 % quantile and largest error, everywhere and by how the surface bends.

    Parameters
    ----------
    distance : (N,) float64, Å, of every dot, see `off_recovered`
    bend : (N,) float64, 1/Å, see `curvature`

    Returns
    -------
    DataFrame, a row each for everywhere, clefts (`bend` below -`BEND`), flats and ridges: where, dots, dots_percent, mean,
    high_99, largest (Å; NaN where there is no such dot)
    """
    places = {EVERYWHERE: np.full(len(bend), True), "clefts": bend < -BEND}
    places |= {"flats": np.abs(bend) <= BEND, "ridges": bend > BEND}
    rows = []
    for where, inside in places.items():
        own = distance[inside] if inside.any() else np.array([np.nan])
        row = {"where": where, "dots": int(inside.sum()), "dots_percent": 100 * inside.mean()}
        rows.append(row | {"mean": own.mean(), "high_99": np.quantile(own, TAIL), "largest": own.max()})
    return pd.DataFrame(rows)
