"""Local roughness R_i of every dot: the published one (paper, eq. 1), and room for others.

To add one, write a function like `published` with `@registered` above it.
"""

import math

import numpy as np
from numba import njit

from sparsurf.patches.index import R_PATCH, ball_bound
from sparsurf.patches.islands import patch_of
from sparsurf.threads import parallel_map

PUBLISHED = "published"
ROUGHNESS = {}


def registered(function):
    """Register a roughness, a function of (index, radius, threads), under its name."""
    ROUGHNESS[function.__name__] = function
    return function


def roughness(index, radius=R_PATCH, threads=1, kind=PUBLISHED):
    """Roughness of the patch of every dot.

    Parameters
    ----------
    index : patches.Index
    radius : float
        R_patch in Å.
    threads : int
    kind : str
        Name in `ROUGHNESS`.

    Returns
    -------
    (N,) float64 in [0, 1], by dot: 1 is flat, 0 is rough.
    """
    return ROUGHNESS[kind](index, float(radius), threads)  # an int would compile kernels anew


@registered
def published(index, radius, threads):
    """Mean cosine between the normals of a patch and their mean; 1 for a patch of one dot."""
    out = np.empty(len(index.dot))
    room = ball_bound(index, index.xyz, radius) + 1
    parallel_map(lambda a, b: _roughness(index, a, b, radius, room, out), len(out), threads)
    return out


@njit(cache=True, nogil=True)
def _roughness(index, first, last, radius, room, out):
    found, queue = np.empty(room, np.int32), np.empty(room, np.int32)
    mark = np.zeros(len(index.dot) + 1, np.uint8)
    for p in range(first, last):
        begin, end = patch_of(index, p, radius, found, mark, queue)
        out[index.dot[p]] = mean_cosine(index.normals, queue, begin, end)


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "arcp", "nsz"})
def mean_cosine(normals, ids, begin, end):
    """Mean over ids[begin:end] of cos(n_j, mean normal), clipped at 0; 1 for a single normal.

    Normals of a DMS file are unit only to three decimals, so each cosine divides by the length.
    A mean normal of length 0 has no direction and counts as rough.
    """
    if end - begin <= 1:
        return 1.0
    mx = my = mz = ux = uy = uz = 0.0
    for k in range(begin, end):
        x, y, z = normals[ids[k], 0], normals[ids[k], 1], normals[ids[k], 2]
        inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
        mx += x
        my += y
        mz += z
        ux += x * inverse
        uy += y * inverse
        uz += z * inverse
    length = math.sqrt(mx * mx + my * my + mz * mz)
    return max(0.0, (mx * ux + my * uy + mz * uz) / (length * (end - begin))) if length > 0.0 else 0.0
