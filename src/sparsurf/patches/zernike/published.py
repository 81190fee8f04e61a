"""The published descriptor: an image of 25 x 25 pixels whose gaps are filled in scan order (paper, 'Zernike 2D procedure').

The kernel returns images folded (see `polynomials`), and two matrix products turn them into descriptors.
"""

from __future__ import annotations

import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.zernike import polynomials
from sparsurf.patches.zernike.images import (
    FAST,
    FOLDING_TABLES,
    IMAGE_SIZE,
    N_EVEN,
    N_ODD,
    ROW_STRIDE,
    WEIGHT,
    WORK_ROWS,
    Descriptor,
    Patches,
    fill_gaps,
    fold_image,
    project,
)

N_Z = len(polynomials.indices())
N_COMPLEX = sum(m > 0 for _, m in polynomials.indices())


def describe(patches: Patches) -> np.ndarray:
    """Compute the Zernike invariants |c_nm| of patches, (P, N_Z); the image reaches to the outermost dot, not to r_zernike."""
    dots, ids, start, centres, weights, _, up = patches
    images = np.empty((len(start) - 1, N_EVEN + N_ODD))
    _images(dots.xyz, dots.normals, ids, start, centres, weights, 1.0 if up else -1.0, images, FOLDING_TABLES)
    return moments(images)


def moments(images: np.ndarray) -> np.ndarray:
    """Compute |c_nm| of folded images (see `polynomials`), (n, N_EVEN + N_ODD), in two matrix products: (n, N_Z)."""
    out, fold = np.empty((len(images), N_Z)), polynomials.fold()
    _moduli(images[:, :N_EVEN] @ fold.even, images[:, N_EVEN:] @ fold.odd, out)
    return out


def order() -> np.ndarray:
    """Return the index in `polynomials.indices()` of each column of `describe`."""
    return polynomials.fold().order


DESCRIPTOR = Descriptor(N_Z, order, describe)


@njit(fastmath=FAST)
def _moduli(real: np.ndarray, imaginary: np.ndarray, out: np.ndarray) -> None:
    """Compute the moduli of coefficients with m > 0, then those with m = 0."""
    for i in range(len(real)):
        for k in range(N_COMPLEX):
            out[i, k] = math.sqrt(real[i, k] ** 2 + imaginary[i, k] ** 2)
        for k in range(N_COMPLEX, N_Z):
            out[i, k] = abs(real[i, k])


@njit()
def _images(
    xyz: np.ndarray,
    normals: np.ndarray,
    ids: np.ndarray,
    start: np.ndarray,
    centres: np.ndarray,
    weights: np.ndarray,
    sign: float,
    images: np.ndarray,
    tables: tuple[np.ndarray, ...],
) -> None:
    """Compute the folded images of patches; all zero for a patch without extent."""
    buffer_size = 1
    for i in range(len(images)):
        buffer_size = max(buffer_size, start[i + 1] - start[i])
    work = np.empty((WORK_ROWS, buffer_size))
    work[WEIGHT] = 1.0
    image, filled = np.empty((2, IMAGE_SIZE + ROW_STRIDE)), np.empty(polynomials.PIXELS, np.uint32)
    for i in range(len(images)):
        patch, out = ids[start[i] : start[i + 1]], images[i]
        if len(weights):
            for k in range(len(patch)):
                work[WEIGHT, k] = weights[start[i] + k]
        out[:] = 0.0
        # One dot has no extent: its image is empty, and its descriptor 0, as in the authors' code
        if len(patch) > 1 and project(xyz, normals, patch, centres[i], sign, work, image, filled):
            fill_gaps(image[0], filled, tables[3], tables[4])
            fold_image(image[0], tables[0], tables[1], tables[2], out)
