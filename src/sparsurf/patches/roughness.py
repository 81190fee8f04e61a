"""Local roughness R_i of every dot: the published one (paper, eq. 1), and a registry for others.

To add one, write a function like `published` with `@registered` above it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numba import njit

from sparsurf.patches.index import R_PATCH, PatchIndex, ball_bound
from sparsurf.patches.islands import patch_of
from sparsurf.threads import parallel_map

PUBLISHED = "published"
RoughnessFunction = Callable[[PatchIndex, float, int], np.ndarray]
ROUGHNESS = dict[str, RoughnessFunction]()


def registered(function: RoughnessFunction) -> RoughnessFunction:
    """Register a roughness, a function of (index, radius, threads), under its name."""
    ROUGHNESS[function.__name__] = function
    return function


def roughness(
    index: PatchIndex, radius: float = R_PATCH, threads: int = 1, roughness_kind: str = PUBLISHED
) -> np.ndarray:
    """Compute the roughness of the patch of every dot, (N,): 1 is flat, 0 is rough."""
    return ROUGHNESS[roughness_kind](index, float(radius), threads)  # an int would compile the kernels again


@registered
def published(index: PatchIndex, radius: float, threads: int) -> np.ndarray:
    """Compute the mean cosine between the normals of a patch and their mean; 1 for a patch of one dot."""
    out = np.empty(len(index.dot))
    buffer_size = ball_bound(index, index.xyz, radius) + 1
    parallel_map(lambda a, b: _roughness(index, a, b, radius, buffer_size, out), len(out), threads)
    return out


@njit(cache=True, nogil=True)
def _roughness(
    index: PatchIndex, first: int, last: int, radius: float, buffer_size: int, out: np.ndarray
) -> None:
    """Fill in the roughness of the dots at the positions first:last."""
    in_ball, queue = np.empty(buffer_size, np.int32), np.empty(buffer_size, np.int32)
    mark = np.zeros(len(index.dot) + 1, np.uint8)
    for p in range(first, last):
        begin, end = patch_of(index, p, radius, in_ball, mark, queue)
        out[index.dot[p]] = mean_cosine(index.normals, queue, begin, end)


@njit(cache=True, nogil=True)
def mean_cosine(normals: np.ndarray, ids: np.ndarray, begin: int, end: int) -> float:
    """Return the mean over ids[begin:end] of cos(n_j, mean normal), at least 0; 1 for a single normal.

    Normals of a DMS file are unit vectors only to three decimals, so each cosine is divided by the length. A mean normal
    of length 0 has no direction and counts as rough.
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
