"""The image of a patch: orientation, cone, pixels, gaps (paper, 'Zernike 2D procedure').

An image is a flat array of `PIXELS` rows of `ROW_STRIDE` elements. So the occupancy of a row is one machine word, and filling
gaps is bit arithmetic. Values that the text omits are from the authors' scripts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from sparsurf.bit_operations import count_bits, lowest_bit
from sparsurf.kernels import njit
from sparsurf.patches.zernike import polynomials
from sparsurf.patches.zernike.polynomials import DISC, PIXELS

if TYPE_CHECKING:
    from sparsurf.patches.index import PatchIndex

MARGIN_FACTOR = 1.01  # the image reaches this many times the largest distance from the axis
MAX_FILL_ROUNDS = 50  # of gap filling
ROW_STRIDE = 32  # elements stored per image row
IMAGE_SIZE = PIXELS * ROW_STRIDE
# Rows of the working array of `project`: position, r (first rho^2, then times the weight), element of the image, weight
X, Y, Z, R, PIXEL, WEIGHT = range(6)
WORK_ROWS = 6
# Lets the compiler assume finite numbers, and do nothing that changes a result: reordered sums and fused products differ with
# the processor, and from one compilation to the next.
FAST = {"nnan", "ninf", "nsz"}

_DISC_PIXELS = polynomials.pixels_in_disc()
N_EVEN, N_ODD = len(_DISC_PIXELS.first) + len(_DISC_PIXELS.diagonal), len(_DISC_PIXELS.first)


class Patches(NamedTuple):
    """P patches of one surface, as a descriptor receives them; patch i holds the dots ids[start[i]:start[i + 1]]."""

    dots: PatchIndex  # with `xyz` and `normals`
    ids: np.ndarray  # int32 positions in `dots`
    start: np.ndarray  # (P + 1,) int64
    centres: np.ndarray  # (P, 3) float64, Å, the points around which the patches are cut
    weights: np.ndarray  # float64 for each of `ids`, or empty if all dots have the weight 1
    radius: float  # R_zernike, Å
    up: bool  # whether the mean normal is turned to +z or to -z


class Descriptor(NamedTuple):
    """One way to describe patches by numbers."""

    width: int  # numbers per patch
    order: Callable[[], np.ndarray]  # (width,) int, the element for users that each column of `describe` is
    describe: Callable[[Patches], np.ndarray]  # (P, width) float64, zero for a patch without a descriptor


def _open_disc() -> np.ndarray:
    """Return a word per image row: the pixels strictly inside the disc, where gaps are filled."""
    k = np.arange(PIXELS)
    inside = (k[:, None] - DISC) ** 2 + (k[None, :] - DISC) ** 2 < DISC**2
    return (inside * (1 << k)[None, :]).sum(axis=1).astype(np.uint32)


def _padded(flat: np.ndarray) -> np.ndarray:
    """Return the indices of flat pixels in an image with rows of `ROW_STRIDE`."""
    return (flat // PIXELS * ROW_STRIDE + flat % PIXELS).astype(np.uint32)


_INVERSE = np.concatenate([[0.0], 1.0 / np.arange(1, 10)])
# For the kernels: pixels to fold (first, second, diagonal), the open disc, 1 / n
FOLDING_TABLES = (*map(_padded, _DISC_PIXELS), _open_disc(), _INVERSE)


def _extreme(name: str) -> Any:
    """Make an intrinsic for the larger ('maxnum') or smaller ('minnum') of two numbers that lets loops be vectorised."""

    @intrinsic
    def choose(_typing: Any, _x: Any, _y: Any) -> tuple[Any, Any]:
        def build(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            double = ir.DoubleType()
            function = ir.FunctionType(double, [double, double])
            function = builder.module.declare_intrinsic(f"llvm.{name}", [double], function)
            return builder.call(function, args, fastmath=("nnan", "nsz"))

        return types.float64(types.float64, types.float64), build

    return choose


_larger, _smaller = _extreme("maxnum"), _extreme("minnum")


@njit(fastmath=FAST)
def project(
    xyz: np.ndarray,
    normals: np.ndarray,
    ids: np.ndarray,
    centre: np.ndarray,
    sign: float,
    work: np.ndarray,
    image: np.ndarray,
    filled: np.ndarray,
) -> bool:
    """Turn a patch and average the distances to the cone's apex per pixel; False if all dots lie on the axis, without an extent.

    Fills image[0] with the mean distance r (0 where no dot falls) and `filled` with its occupancy. `work` (6, n) holds a column
    per dot of the patch, see `X`..; the caller sets the weights.
    """
    n = len(ids)
    cx = cy = cz = mx = my = mz = total = 0.0
    for k in range(n):
        a = np.uintp(ids[k])
        g, x, y, z = work[WEIGHT, k], xyz[a, 0] - centre[0], xyz[a, 1] - centre[1], xyz[a, 2] - centre[2]
        work[X, k], work[Y, k], work[Z, k] = x, y, z
        cx += g * x
        cy += g * y
        cz += g * z
        mx += g * normals[a, 0]
        my += g * normals[a, 1]
        mz += g * normals[a, 2]
        total += g
    cx, cy, cz = cx / total, cy / total, cz / total
    across = math.sqrt(mx * mx + my * my)
    length = math.sqrt(across * across + mz * mz)
    # As in the authors' code: first about z, then about x. Another way to the same axis turns the pixels, and so the gaps
    c1, s1 = (my / across, mx / across) if across > 0.0 else (1.0, 0.0)
    c2, s2 = (sign * mz / length, sign * across / length) if length > 0.0 else (sign, 0.0)
    max_rho2, apex = 0.0, np.inf
    for k in range(n):  # about z into the y-z plane, then about x onto the z axis
        x, y, z = work[X, k] - cx, work[Y, k] - cy, work[Z, k] - cz
        y1 = s1 * x + c1 * y
        x = c1 * x - s1 * y
        y = c2 * y1 - s2 * z
        z = s2 * y1 + c2 * z
        rho2 = x * x + y * y
        work[X, k], work[Y, k], work[Z, k], work[R, k] = x, y, z, rho2
        max_rho2 = _larger(max_rho2, rho2)
        apex = _smaller(apex, z - math.sqrt(rho2))
    if max_rho2 == 0.0:
        return False
    edge = math.sqrt(max_rho2) * MARGIN_FACTOR
    scale = PIXELS / (2 * edge)
    offset = edge * scale
    for k in range(n):
        # As in the authors' code, a pixel is open at its lower end in x and closed at its upper one, and mirrored in y
        column = _larger(np.ceil(work[X, k] * scale + offset) - 1.0, 0.0)
        row = _larger(np.ceil(offset - work[Y, k] * scale) - 1.0, 0.0)
        work[PIXEL, k] = row * ROW_STRIDE + column
        z = work[Z, k] - apex
        work[R, k] = work[WEIGHT, k] * math.sqrt(work[R, k] + z * z)
    image[:] = 0.0
    for k in range(n):
        p = np.uintp(work[PIXEL, k])
        image[0, p] += work[R, k]
        image[1, p] += work[WEIGHT, k]
    filled[:] = 0
    for k in range(n):  # over dots, not elements: most patches of sparse subsets have few dots
        p = np.uintp(work[PIXEL, k])
        weight = image[1, p]
        mean = image[0, p] / (weight if weight > 0.0 else 1.0)
        image[0, p], image[1, p] = mean, 1.0
        # As in the authors' code, 0 marks an empty pixel, also that of a dot at the apex itself
        filled[p // np.uintp(ROW_STRIDE)] |= np.uint32(mean != 0.0) << np.uint32(p % np.uintp(ROW_STRIDE))
    return True


@njit(inline="always")
def _fill_pixels(
    image: np.ndarray,
    i: int,
    ready: np.uint32,
    above: np.uint32,
    here: np.uint32,
    below: np.uint32,
    inverse: np.ndarray,
) -> np.uint32:
    """Give the `ready` pixels of row i the mean of the filled ones of their 3 x 3 blocks; return the new occupancy `here`."""
    while ready:
        j: np.uint32 = lowest_bit(ready)  # type: ignore[call-arg]  # numba's stub counts the typing context
        shift, lowest, three_bits = np.uint32(j - np.uint32(1)), np.uint32(1), np.uint32(7)
        n = (above >> shift) & three_bits
        n |= ((here >> shift) & three_bits) << np.uint32(3)
        n |= ((below >> shift) & three_bits) << np.uint32(6)
        here = np.uint32(here | (lowest << j))
        ready = np.uint32(ready & (ready - lowest))
        p, next_, last = np.intp(i) * ROW_STRIDE + np.intp(j), np.uintp(1), np.uintp(2)
        a, b, c = np.uintp(p - ROW_STRIDE - 1), np.uintp(p - 1), np.uintp(p + ROW_STRIDE - 1)
        # The last bit of the sum depends on its order, which is therefore written out
        total = (image[a] + image[a + next_] + image[a + last]) + (
            image[c] + image[c + next_] + image[c + last]
        )
        image[b + next_] = ((total + image[b + last]) + image[b]) * inverse[count_bits(np.uint32(n))]
    return here


@njit()
def fill_gaps(image: np.ndarray, filled: np.ndarray, open_disc: np.ndarray, inverse: np.ndarray) -> None:
    """Fill empty pixels strictly inside the disc, in place and in row-major order; rows are words of bits.

    First, while anything changes: pixels between two filled ones of their row or column, then pixels between two filled ones of
    a diagonal. After that, every pixel with a filled neighbour.
    """
    step = np.uint32(1)
    last = PIXELS - 1
    for _ in range(MAX_FILL_ROUNDS):
        changed = False
        remaining = np.uint32(0)
        for i in range(1, last):
            above, here, below = filled[i - 1], filled[i], filled[i + 1]
            todo = np.uint32(open_disc[i] & ~here)
            ready = np.uint32(todo & ((above & below) | ((here << step) & (here >> step))))
            if ready:  # and what these enable to their right, before a filled one
                ready |= np.uint32(todo & (ready << step) & (here >> step))
                filled[i] = _fill_pixels(image, i, ready, above, here, below, inverse)
                changed = True
        for i in range(1, last):
            above, here, below = filled[i - 1], filled[i], filled[i + 1]
            todo = np.uint32(open_disc[i] & ~here)
            ready = np.uint32(
                todo & (((below >> step) & (above << step)) | ((above >> step) & (below << step)))
            )
            remaining |= todo & ~ready
            if ready:
                filled[i] = _fill_pixels(image, i, ready, above, here, below, inverse)
                changed = True
        if remaining == 0:
            return
        if not changed:
            break
    for _ in range(MAX_FILL_ROUNDS):
        changed = False
        remaining = np.uint32(0)
        for i in range(1, last):
            above, here, below = filled[i - 1], filled[i], filled[i + 1]
            todo = np.uint32(open_disc[i] & ~here)
            vertical = np.uint32(above | below)
            column = np.uint32(vertical | here)
            ready = np.uint32(todo & (vertical | (column << step) | (column >> step)))
            if ready:  # and what these enable, to the right end of their gap
                ready = np.uint32(todo & (((ready + todo) ^ todo) | ready))
                changed = True
                remaining |= todo & ~ready
                filled[i] = _fill_pixels(image, i, ready, above, here, below, inverse)
            else:
                remaining |= todo
        if remaining == 0 or not changed:
            return


@njit()
def fold_image(
    image: np.ndarray, first: np.ndarray, second: np.ndarray, diagonal: np.ndarray, out: np.ndarray
) -> None:
    """Compute sums and differences of the pixels that the swap of x and y exchanges, see `polynomials`."""
    for k in range(len(first)):
        a, b = image[first[k]], image[second[k]]
        out[k] = a + b
        out[N_EVEN + k] = a - b
    for k in range(len(diagonal)):
        out[len(first) + k] = image[diagonal[k]]
