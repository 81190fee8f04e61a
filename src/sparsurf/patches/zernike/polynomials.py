"""2D Zernike polynomials on a pixel grid, as one matrix product for many images.

Conventions. Z_nm = R_nm(r) exp(i m t) for n = 0..20, m = 0..n, n - m even, ordered by n, then m: 121 of them. An image has
25 x 25 pixels, row 0 at the top. The authors enlarge it 16 times, so that column k has x = k/199 - 1 and row k has
y = (399 - k)/199 - 1 for k = 0..399. Only the M pixels whose indices lie within 199.5 of (199.5, 199.5) count. Then
c_nm = (n + 1)/M sum F conj(Z_nm): enlarging equals summing the basis over blocks of 16 x 16.

Folding. Swapping x and y maps the pixel grid onto itself, and exp(-i m t) r^m to (-i)^m times its conjugate. After a
rotation by exp(i pi m/4), the real part of the basis is even under the swap and the imaginary part odd, so one product
splits into two of half the size. The rotation does not change |c_nm|.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np

N_MAX = 20  # highest order (authors' scripts)
PIXELS = 25  # pixels along a side of the image (authors' scripts)
ENLARGED = 400  # pixels along a side after enlargement (authors' scripts)
DISC = 12  # radius of the disc in pixels; everything outside is zero (authors' scripts)


def indices(n_max: int = N_MAX) -> list[tuple[int, int]]:
    """Return the pairs (n, m) in the order of the descriptor vector."""
    return [(n, m) for n in range(n_max + 1) for m in range(n % 2, n + 1, 2)]


def radial(m: int, r2: np.ndarray, n_max: int = N_MAX) -> Iterator[tuple[int, np.ndarray]]:
    """Yield (n, R_nm / r^m) for n = m, m + 2, .. n_max.

    R_nm(r) = r^m P_k^(0, m)(2 r^2 - 1) with k = (n - m)/2 (Born & Wolf), by the three-term recurrence of the Jacobi
    polynomials. The sum over powers in the paper loses seven digits at n = 20.
    """
    x = 2 * r2 - 1
    before, now = np.zeros_like(x), np.ones_like(x)
    for k in range((n_max - m) // 2 + 1):
        yield m + 2 * k, now
        s = 2 * k + m
        if k == 0:
            before, now = now, 1 + (m + 2) * (x - 1) / 2
        else:
            up = (s + 1) * ((s + 2) * s * x - m * m) * now - 2 * k * (k + m) * (s + 2) * before
            before, now = now, up / (2 * (k + 1) * (k + m + 1) * s)


@cache
def basis(n_max: int = N_MAX) -> np.ndarray:
    """Compute the block sums of (n + 1)/M conj(Z_nm), (len(indices), 25, 25); c_nm of an image F is the sum of basis[nm] * F."""
    half = ENLARGED // 2 - 1
    k = np.arange(ENLARGED)
    x, y = np.meshgrid(k / half - 1.0, k[::-1] / half - 1.0)
    middle = (ENLARGED - 1) / 2
    # The middle of the indices, not of x and y, which differ by half a pixel: so do the authors' scripts
    inside = (k[:, None] - middle) ** 2 + (k[None, :] - middle) ** 2 <= middle**2
    counted = inside.sum()
    r2 = (x * x + y * y)[inside]
    turn = (x - 1j * y)[inside]  # r exp(-i t)
    block = (k[:, None] // (ENLARGED // PIXELS) * PIXELS + k[None, :] // (ENLARGED // PIXELS))[inside]

    def block_sum(values: np.ndarray) -> np.ndarray:
        real = np.bincount(block, values.real, PIXELS**2)
        return real + 1j * np.bincount(block, values.imag, PIXELS**2)

    out = {}
    sector = np.ones(len(r2), complex)
    for m in range(n_max + 1):
        for n, polynomial in radial(m, r2, n_max):
            out[n, m] = block_sum(polynomial * sector) * ((n + 1) / counted)
        sector *= turn
    return np.array([out[nm].reshape(PIXELS, PIXELS) for nm in indices(n_max)])


class DiscPixels(NamedTuple):
    """Flat pixels inside the disc; `pixels_in_disc` makes it."""

    first: np.ndarray  # (A,) int32, of each pair that swapping x and y exchanges
    second: np.ndarray  # (A,) int32
    diagonal: np.ndarray  # (D,) int32, that the swap leaves in place


def pixels_in_disc() -> DiscPixels:
    """List the pixels that a folded image, (first + second, diagonal) and first - second, comes from."""
    flat = np.arange(PIXELS**2)
    row, column = np.divmod(flat, PIXELS)
    swapped = (PIXELS - 1 - column) * PIXELS + PIXELS - 1 - row
    in_disc = (row - DISC) ** 2 + (column - DISC) ** 2 <= DISC**2
    first, diagonal = flat[in_disc & (flat < swapped)], flat[in_disc & (flat == swapped)]
    return DiscPixels(first.astype(np.int32), swapped[first].astype(np.int32), diagonal.astype(np.int32))


class Fold(NamedTuple):
    """The folded basis; `fold` makes it."""

    even: np.ndarray  # (A + D, 121) float64
    odd: np.ndarray  # (A, 110) float64
    order: np.ndarray  # (121,) int64, index in `indices()` of each folded column; m > 0 first


@cache
def fold() -> Fold:
    """Compute the matrices that turn folded images into c_nm, which takes a tenth of a second."""
    first, second, diagonal = pixels_in_disc()
    m = np.array([m for _, m in indices()])
    order = np.concatenate([np.flatnonzero(m > 0), np.flatnonzero(m == 0)])
    turned = (basis() * np.exp(0.25j * np.pi * m)[:, None, None]).reshape(len(m), -1)[order].T
    even, odd = turned.real, turned.imag[:, : np.count_nonzero(m)]
    return Fold(
        np.concatenate([(even[first] + even[second]) / 2, even[diagonal]]),
        np.ascontiguousarray(odd[first] - odd[second]) / 2,
        order,
    )
