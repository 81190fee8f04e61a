"""A smooth field at the nodes of a square grid from values at scattered dots, its gaps filled from all sides at once.

At every node stands the mean of the dots around it under a smooth round bump; where these are too few, bumps of twice
the width take over, and so on up to the mean of all. Bumps are B-splines of degree 7: nearly Gaussians, and one of
twice the width is a sum of nine narrow ones (Unser, IEEE Signal Process. Mag. 16:22, 1999), so that coarse sums follow
from fine ones exactly. Places are in steps of the grid, from its corner.
"""

from functools import cache
from math import comb, factorial

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from sparsurf.patches.zernike.images import FAST

SIDES = (25, 13, 7, 4)  # nodes along a side, of bumps of width 1, 2, 4, 8
NODES = SIDES[0]
TAPS = 8  # nodes that a bump reaches along a side
PAD = 4  # nodes beside the grid that bumps reach
WIDE, MIDDLE = NODES + 2 * PAD, NODES // 2
PLACES = 256  # of a dot between two nodes in the table of the bumps
ENOUGH = 0.1  # sum of the bumps at which the dots weigh as much as what wider bumps say; one dot at a node gives 0.23
SPLIT = tuple(comb(TAPS, k) / 2 ** (TAPS - 1) for k in range(TAPS + 1))  # a wide bump from narrow ones


@cache
def bumps():
    """Value of the bump at the 8 nodes around a dot, (PLACES + 2, 8), for dots k / PLACES of a step beyond the fourth."""
    t = np.arange(PLACES + 2)[:, None] / PLACES + 3 - np.arange(TAPS)
    power = np.maximum(t[..., None] + 4 - np.arange(TAPS + 1), 0.0) ** 7
    return power @ [(-1) ** k * comb(TAPS, k) / factorial(7) for k in range(TAPS + 1)]


def _eight(step):
    """An intrinsic on eight neighbouring float64 of flat arrays at once: `step(builder, load)` gives what is stored.

    Loops of eight are not vectorised by themselves, since the compiler cannot tell the arrays apart.
    """

    @intrinsic
    def run(typing, to, at, source, first, factor):
        def build(context, builder, signature, args):
            def pointer(k, place):
                array = context.make_array(signature.args[k])(context, builder, value=args[k])
                return builder.bitcast(
                    builder.gep(array.data, [place]), ir.VectorType(ir.DoubleType(), 8).as_pointer()
                )

            def load(k, place):
                return builder.load(pointer(k, place), align=8)

            one = ir.Constant(ir.VectorType(ir.DoubleType(), 8), ir.Undefined)
            zero = ir.Constant(ir.IntType(32), 0)
            lanes = ir.Constant(ir.VectorType(ir.IntType(32), 8), [0] * 8)
            factors = builder.shuffle_vector(builder.insert_element(one, args[4], zero), one, lanes)
            value = step(builder, load, args, factors)
            builder.store(value, pointer(0, args[1]), align=8)
            return context.get_dummy_value()

        return types.none(to, types.intp, source, types.intp, types.float64), build

    return run


def _fma(builder, a, b, c):
    return builder.fadd(builder.fmul(a, b, flags=("contract",)), c, flags=("contract",))


# to[at : at + 8] += factor * source[first : first + 8]
_add_eight = _eight(
    lambda builder, load, args, factor: _fma(builder, factor, load(2, args[3]), load(0, args[1]))
)


def _between(builder, load, args, factor):
    low = load(2, args[3])
    high = load(2, builder.add(args[3], ir.Constant(args[3].type, TAPS)))
    return _fma(builder, factor, builder.fsub(high, low), low)


# to[at : at + 8] = what lies between source[first : first + 8] and the eight after them, by the share `factor`
_between_eight = _eight(_between)


@njit(cache=True, nogil=True, fastmath=FAST)
def lay(dots, bumps, sums):
    """Sums over the dots of r times bump and of the bump at every node; `PAD` nodes beside the grid included.

    `bumps` and `sums` are flat.
    """
    sums[:] = 0.0
    along = np.empty(2 * TAPS)
    for k in range(dots.shape[1]):
        column, row = np.intp(dots[0, k]), np.intp(dots[1, k])
        place = (dots[0, k] - column) * PLACES
        _between_eight(along, 0, bumps, TAPS * np.intp(place), place - np.floor(place))
        place = (dots[1, k] - row) * PLACES
        _between_eight(along, TAPS, bumps, TAPS * np.intp(place), place - np.floor(place))
        gr, g = dots[2, k], dots[3, k]
        at = (row + 1) * WIDE + column + 1
        for b in range(TAPS):
            part = along[np.uintp(TAPS + b)]
            _add_eight(sums, at, along, 0, gr * part)
            _add_eight(sums, at + WIDE * WIDE, along, 0, g * part)
            at += WIDE


@njit(cache=True, nogil=True, fastmath=FAST)
def widen(fine, side, wide_side, spare, flipped, wide):
    """Sums of bumps of twice the width at every second node, rows and columns exchanged."""
    n, m = side + 2 * PAD, wide_side + 2 * PAD
    for q in range(2):
        _widen_columns(fine[q], n, n, m, spare)
        for i in range(m):
            for j in range(n):
                flipped[j, i] = spare[i, j]
        _widen_columns(flipped, n, m, m, wide[q])


@njit(cache=True, nogil=True, fastmath=FAST)
def _widen_columns(fine, n, width, m, wide):
    """Rows 2 i - 8 .. 2 i of `fine` (n rows) weighted into row i of `wide` (m rows); both have `width` columns."""
    for i in range(m):
        for j in range(width):
            wide[i, j] = 0.0
        for k in range(max(0, TAPS - 2 * i), min(TAPS + 1, n + TAPS - 2 * i)):
            row, part = 2 * i + k - TAPS, SPLIT[k]
            for j in range(width):
                wide[i, j] += part * fine[row, j]


@njit(cache=True, nogil=True, fastmath=FAST)
def fill(sums, mean, field, spare, flipped):
    """The field at the nodes: means under the narrow bumps where these hold enough dots, else under wider ones."""
    field[:] = mean
    for level in range(len(SIDES) - 1, -1, -1):
        side = SIDES[level]
        if level < len(SIDES) - 1:
            half = SIDES[level + 1]
            _refine_columns(field, half, half, spare)
            for i in range(side):
                for j in range(half):
                    flipped[j, i] = spare[i, j]
            _refine_columns(flipped, half, side, field)
        for i in range(side):
            for j in range(side):
                above, below = sums[level, 0, i + PAD, j + PAD], sums[level, 1, i + PAD, j + PAD]
                field[i, j] = (above + ENOUGH * field[i, j]) / (below + ENOUGH)


@njit(cache=True, nogil=True, fastmath=FAST)
def _refine_columns(coarse, n, width, fine):
    """Rows of `coarse` (n rows, `width` columns) with one more between any two, by cubic interpolation."""
    for i in range(n):
        for j in range(width):
            fine[2 * i, j] = coarse[i, j]
    for i in range(n - 1):
        before, after = max(i - 1, 0), min(i + 2, n - 1)
        for j in range(width):
            near, far = coarse[i, j] + coarse[i + 1, j], coarse[before, j] + coarse[after, j]
            fine[2 * i + 1, j] = 0.5625 * near - 0.0625 * far
