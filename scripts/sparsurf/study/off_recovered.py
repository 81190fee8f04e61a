"""How far the surface recovered from a subset and the whole one lie apart."""

import numpy as np
from scipy.spatial import cKDTree

from sparsurf.recovery.recovering import recover


def off_recovered(points, kept, normals, threads=1):
    """Distance of every dot from the surface that the kept ones describe.

    Parameters
    ----------
    points : (N, 3) float64, Å
    kept, normals : (n, 3) float64
        Places and normals of the subset.
    threads : int

    Returns
    -------
    (N,) float64, Å, see `off`.
    """
    return off(points, *recover(kept, normals, threads=threads), threads)


def off(points, places, outward, threads=1):
    """Distance of points (M, 3) from the surface of dense dots, their places and normals (N, 3); (M,) float64, Å.

    To the tangent plane of the nearest dot, or to that dot itself where it lies farther than the dots lie apart.
    """
    gap, nearest = cKDTree(places).query(points, workers=threads)
    aside = np.abs(np.einsum("ij,ij->i", points - places[nearest], outward[nearest]))
    apart = np.median(cKDTree(places).query(places, k=2)[0][:, 1]) if len(places) > 1 else 0.0
    return np.where(gap <= 2 * apart, aside, gap)
