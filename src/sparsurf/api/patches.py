"""The roughness of every dot, and 2D Zernike descriptors of patches."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sparsurf import registry
from sparsurf.api.inputs import SurfaceLike
from sparsurf.api.surfaces import as_index, as_surface
from sparsurf.api.whole_surface import with_patches
from sparsurf.arguments import index_array, public
from sparsurf.errors import InputError, argument
from sparsurf.patches.descriptors import PUBLISHED, DescriptorLike, describe_patches
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE, PatchIndex
from sparsurf.patches.roughness import RoughnessFunction
from sparsurf.settings import PatchesSettings
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")


@public(of_dots=True)
@registry.with_choices
def roughness(
    surface: SurfaceLike,
    *,
    r_patch: float = R_PATCH,
    d_link: float = D_LINK,
    roughness: str | RoughnessFunction = PUBLISHED,
) -> NDArray[np.float64]:
    """Compute the local roughness R_i of every dot: the mean cosine between the normals of its patch and their mean.

    Parameters
    ----------
    surface : Surface, path, pair (points, normals), or molecule
        Dots from `surface` or `read_surface`, a file of dots, a pair of (N, 3) arrays with unit normals, or a molecule as in
        `surface`, whose dots are placed with the defaults.
    r_patch : float
        Radius of a patch, Å (default 4).
    d_link : float
        Distance below which two dots are linked, Å (default 0.5). A patch is the largest linked island of dots within
        `r_patch`.
    roughness : str or callable
        Definition of the roughness (default 'published', equation 1 of the preprint by Grassmann et al., published in PLoS ONE
        17(4), e0266004, 2022). A function (index, radius, threads) of a PatchIndex, Å and a number that returns (N,) numbers from
        0 (rough) to 1, or a name given to `register`, may take the place of these names:

        {choices of roughness}

    Returns
    -------
    (N,) float64
        Roughness of each dot: 1 is flat and 0 is rough. Where patches of the dots would be fragmented, as those of a subset, it
        is measured on the whole surface of their atoms, or else on the surface reconstructed from them (`recover`), and a
        warning says so.

    Raises
    ------
    InputError
        The surface cannot be used, the dots are too few to reconstruct it, or an argument is outside of its limits.

    Examples
    --------
    >>> import sparsurf
    >>> R = sparsurf.roughness("data/tdp43/topology.pdb")
    >>> R.shape, round(float(R.mean()), 3)
    ((24600,), 0.594)
    """
    registry.load("roughness", roughness, "roughness")  # refused before dots are placed
    patches = PatchesSettings(r_patch=r_patch, d_link=d_link).model_copy(update={"roughness": roughness})
    whole = with_patches("roughness", as_surface(surface, d_link), patches)
    refuse_sparse(whole.surface.points, d_link, "surface", radii={"r_patch": r_patch})
    values = whole.roughness(patches)
    if len(values) > len(whole.nearest):
        log.warning("roughness: the mean roughness of their surface is %.3f", values.mean())
    return values[whole.nearest]


@public(of_dots=True)
@registry.with_choices
def descriptors(
    surface: SurfaceLike,
    at: ArrayLike | None = None,
    *,
    r_zernike: float = R_ZERNIKE,
    up: bool = True,
    d_link: float = D_LINK,
    descriptor: DescriptorLike = PUBLISHED,
) -> NDArray[np.float64]:
    """Compute the 2D Zernike descriptors of patches.

    Parameters
    ----------
    surface : Surface, path, pair (points, normals), or molecule
        The dots from which patches are cut, as in `roughness`.
    at : (T,) int, (N,) bool, or (T, 3) float, optional
        Centres of the patches: indices of dots, a mask of all dots, or points in Å. By default every dot is a centre.
    r_zernike : float
        Radius of a patch, Å (default 6).
    up : bool
        Whether the mean normal of a patch is turned to +z (default True) or to -z, as for the partner in a complex.
    d_link : float
        Distance below which two dots of a patch are linked, Å (default 0.5). A patch is the linked island of its centre.
    descriptor : str or callable
        Kind of descriptor (default 'published'); a `d_link` of 0.6 Å suits 'rotation_robust' best. A function (patches) of
        `Patches` that returns numbers (P, width), or a name given to `register`, may take the place of these names:

        {choices of descriptor}

    Returns
    -------
    (T, 121) float64
        ``|c_nm|`` in the order of n, then m, up to order 20, as in Grassmann et al., PLoS ONE 17(4), e0266004 (2022); (T, width)
        of a function. A centre without a patch has zeros, and a warning says so.

    Raises
    ------
    InputError
        A centre is not a dot of the surface or not finite, or an argument is outside of its limits.

    Examples
    --------
    The distance between two descriptors says how different the patches are:

    >>> import sparsurf
    >>> z = sparsurf.descriptors(sparsurf.surface("data/tdp43/topology.pdb"), [0, 100, 200])
    >>> z.shape, round(float(((z[0] - z[1]) ** 2).sum() ** 0.5), 2)
    ((3, 121), 1.74)
    """
    registry.load("descriptor", descriptor, "descriptor")  # refused before dots are placed
    index = as_index(surface, d_link, r_zernike, "r_zernike")
    return describe_points(index, _points_at(index, at), r_zernike, up, argument("at"), descriptor)


def describe_points(
    index: PatchIndex,
    points: np.ndarray,
    radius: float,
    up: bool,
    name: str,
    descriptor: DescriptorLike = PUBLISHED,
) -> np.ndarray:
    """Return descriptors (T, width) of the patches around points (T, 3), called `name`; warn of points without a patch."""
    z, sizes = describe_patches(index, points, radius, up, available_cores(), descriptor)
    if n_empty := np.count_nonzero(sizes == 0):
        message = "%s: %d of %d points have no patch, as no dot lies within %g Å; their descriptors are zeros"
        log.warning(message, name, n_empty, len(points), radius)
    return z


def _points_at(index: PatchIndex, spots: Any) -> np.ndarray:
    """Return the points (T, 3), Å, of what `descriptors` takes as `at`."""
    points, n = index.xyz[index.position], len(index.dot)
    if spots is None:
        return points
    spots = index_array(spots, n, "at")
    if spots.ndim == 2 and spots.shape[1] == 3:
        if spots.dtype.kind not in "iuf" or not np.isfinite(spots).all():
            raise InputError(f"{argument('at')}: some points have NaN or infinity; leave them out.")
        return np.ascontiguousarray(spots, dtype=float)
    if spots.ndim != 1 or spots.dtype.kind not in "iu":
        raise InputError(
            f"{argument('at')}: give (T,) numbers of dots or (T, 3) points, not {spots.dtype} of shape {spots.shape}."
        )
    if len(spots) and not (spots.min() >= 0 and spots.max() < n):
        wrong = spots.min() if spots.min() < 0 else spots.max()
        raise InputError(f"{argument('at')}: there is no dot {wrong}; the dots are numbered 0 to {n - 1}.")
    return points[spots]
