"""How far the surface recovered from a subset lies from the dots of the whole one."""

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
    (N,) float64, Å: to the tangent plane of the nearest recovered dot, or to that dot itself where it lies farther
    than the recovered dots lie apart.
    """
    places, outward = recover(kept, normals, threads=threads)
    gap, nearest = cKDTree(places).query(points, workers=threads)
    aside = np.abs(np.einsum("ij,ij->i", points - places[nearest], outward[nearest]))
    apart = np.median(cKDTree(places).query(places, k=2)[0][:, 1]) if len(places) > 1 else 0.0
    return np.where(gap <= 2 * apart, aside, gap)
