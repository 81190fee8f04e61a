"""The dense surface back from a few of its dots."""

from sparsurf.calls.inputs import as_surface
from sparsurf.calls.limits import DENSITY as DENSITIES
from sparsurf.recovery.recovering import recover as recovered_dots
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores


def recover(surface, *, density=DENSITY):
    """Dense dots of the surface that a few dots with normals describe; nothing else is needed.

    Parameters
    ----------
    surface : Surface of the few dots, the path of a file of them (what `sparsurf minimal` wrote, say), or the pair
        (points, normals)
    density : float
        Dots per Å^2 wished.

    Returns
    -------
    Surface
        The given dots first, unchanged, then those between them.

    Examples
    --------
    >>> import numpy as np, sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> kept = sparsurf.sample(dots, 0.1)
    >>> dense = sparsurf.recover((dots.points[kept], dots.normals[kept]))
    >>> len(kept), len(dense)
    (2460, 28470)

    Their distance in Å from the nearest dot of the molecule, whose dots lie about 0.4 Å apart:

    >>> from scipy.spatial import cKDTree
    >>> far = cKDTree(dots.points).query(dense.points)[0]
    >>> round(float(far.mean()), 2)
    0.16
    """
    density, few = DENSITIES.check(density, "density"), as_surface(surface)
    return Surface(*recovered_dots(few.points, few.normals, density, threads=available_cores()))
