"""What lies around each dot: its roughness and its descriptors."""

import logging

import numpy as np

from sparsurf import InputError
from sparsurf.calls.inputs import as_array, as_surface
from sparsurf.calls.limits import LENGTH
from sparsurf.patches.descriptors import describe
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE, build_index
from sparsurf.patches.roughness import roughness as roughness_of_dots
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.threads import available_cores

log = logging.getLogger("sparsurf")


def roughness(surface, *, radius=R_PATCH, d_link=D_LINK):
    """Local roughness R_i of every dot: the mean cosine between the normals of its patch and their mean.

    Parameters
    ----------
    surface : what `surface` or `read_surface` gave, the path of a file of dots, or the pair (points, normals)
        Normals of a file are brought to unit length, those of the pair must have it.
    radius : float
        R_patch in Å.
    d_link : float
        Å; dots closer than this are linked, and a patch is the largest linked island.

    Returns
    -------
    (N,) float64, 1 is flat and 0 is rough

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> R = sparsurf.roughness(dots)
    >>> R.shape, round(float(R.mean()), 3)
    ((24600,), 0.594)

    Without the files of this project, from arrays:

    >>> R = sparsurf.roughness((dots.points, dots.normals))
    """
    radius = LENGTH.check(radius, "radius")
    return roughness_of_dots(prepared(surface, d_link), radius, available_cores())


def descriptors(surface, at=None, *, radius=R_ZERNIKE, up=True, d_link=D_LINK):
    """2D Zernike descriptors of patches.

    Parameters
    ----------
    surface : as in `roughness`
    at : (T,) int dots, (N,) bool, or (T, 3) float places in Å, around which the patches are cut; every dot without
    radius : float
        R_zernike in Å.
    up : bool
        Whether the mean normal of a patch is turned to +z, or to -z as for the partner of a complex.
    d_link : float
        Å; dots closer than this are linked, and a patch is the largest linked island.

    Returns
    -------
    (T, 121) float64, |c_nm| by n, then m; zeros where there is no patch, with a warning

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> z = sparsurf.descriptors(dots, [0, 100, 200])
    >>> z.shape
    (3, 121)

    Two patches are as different as their descriptors are far apart:

    >>> import numpy as np
    >>> round(float(np.linalg.norm(z[0] - z[1])), 2)
    1.74
    """
    radius = LENGTH.check(radius, "radius")
    if not isinstance(up, bool | np.bool_):
        raise InputError(f"up is {up!r}; it must be True or False.")
    index = prepared(surface, d_link)
    return described(index, _places(index, at), radius, up, "at")


def described(index, places, radius, up, name):
    """Descriptors (T, 121) of the patches around places (T, 3), called `name`; a warning where there is none."""
    z, sizes = describe(index, places, radius, up, available_cores())
    if n_empty := np.count_nonzero(sizes == 0):
        message = "%s: %d of %d places have no patch, as no dot lies within %g Å; their descriptors are zeros"
        log.warning(message, name, n_empty, len(places), radius)
    return z


def prepared(surface, d_link=D_LINK):
    """Index of a surface whose dots lie close enough for `d_link`."""
    d_link, dots = LENGTH.check(d_link, "d_link"), as_surface(surface)
    refuse_sparse(dots.points, d_link, "surface")
    return build_index(dots.points, dots.normals, d_link)


def _places(index, at):
    """(T, 3) places, Å, of what `descriptors` takes as `at`."""
    points, n = index.xyz[index.position], len(index.dot)
    if at is None:
        return points
    at = as_array(at, n, "at")
    if at.ndim == 2 and at.shape[1] == 3:
        if at.dtype.kind not in "iuf" or not np.isfinite(at).all():
            raise InputError("at: some of the places are no numbers; leave them out.")
        return np.ascontiguousarray(at, dtype=float)
    if at.ndim != 1 or at.dtype.kind not in "iu":
        raise InputError(
            f"at: give (T,) numbers of dots or (T, 3) places, not {at.dtype} of shape {at.shape}."
        )
    if len(at) and not (at.min() >= 0 and at.max() < n):
        raise InputError(f"at: dots {at.min()} to {at.max()} are asked for, the surface has 0 to {n - 1}.")
    return points[at]
