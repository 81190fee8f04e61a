"""The published descriptor: an image of 25 x 25 pixels, its gaps filled in scan order (paper, 'Zernike 2D procedure').

Images leave the kernel folded (see `polynomials`) and become descriptors in two matrix products.
"""

import math

import numpy as np
from numba import njit

from sparsurf.patches.zernike import polynomials
from sparsurf.patches.zernike.images import (
    FAST,
    N_EVEN,
    N_ODD,
    PLACES,
    TABLES,
    WEIGHT,
    WIDTH,
    fill_gaps,
    fold_image,
    project,
)

N_Z = len(polynomials.indices())
N_COMPLEX = sum(m > 0 for _, m in polynomials.indices())


def describe(index, ids, start, centres, weights, radius, up):
    """Zernike invariants |c_nm| of patches; `radius` has no part in it: the image reaches to the outermost dot.

    See `descriptors.Descriptor` for what is given and returned.
    """
    images = np.empty((len(start) - 1, N_EVEN + N_ODD))
    _images(index.xyz, index.normals, ids, start, centres, weights, 1.0 if up else -1.0, images, TABLES)
    return moments(images)


def moments(images):
    """|c_nm| of folded images (see `polynomials`), (n, N_EVEN + N_ODD), in two matrix products: (n, N_Z)."""
    out, fold = np.empty((len(images), N_Z)), polynomials.fold()
    _moduli(images[:, :N_EVEN] @ fold.even, images[:, N_EVEN:] @ fold.odd, out)
    return out


def order():
    """Place of each column of `describe` in `polynomials.indices()`."""
    return polynomials.fold().order


@njit(cache=True, nogil=True, fastmath=FAST)
def _moduli(real, imaginary, out):
    for i in range(len(real)):
        for k in range(N_COMPLEX):
            out[i, k] = math.sqrt(real[i, k] ** 2 + imaginary[i, k] ** 2)
        for k in range(N_COMPLEX, N_Z):
            out[i, k] = abs(real[i, k])


@njit(cache=True, nogil=True)
def _images(xyz, normals, ids, start, centres, weights, sign, images, tables):
    """Folded images of patches; all zero where one has no extent."""
    room = 1
    for i in range(len(images)):
        room = max(room, start[i + 1] - start[i])
    work = np.empty((9, room))
    work[WEIGHT] = 1.0
    image, filled = np.empty((2, PLACES + WIDTH)), np.empty(polynomials.PIXELS, np.uint32)
    for i in range(len(images)):
        patch, out = ids[start[i] : start[i + 1]], images[i]
        if len(weights):
            for k in range(len(patch)):
                work[WEIGHT, k] = weights[start[i] + k]
        out[:] = 0.0
        if len(patch) > 1 and project(xyz, normals, patch, centres[i], sign, work, image, filled):
            fill_gaps(image[0], filled, tables[3], tables[4])
            fold_image(image[0], tables[0], tables[1], tables[2], out)
