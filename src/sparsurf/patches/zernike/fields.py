"""A smooth field at the nodes of a square grid from values at scattered dots, whose gaps are filled from all sides at once.

The value at a node is the mean of the dots around it under a smooth round bump. Where these dots are too few, bumps of
twice the width take over, and so on up to the mean of all dots. Bumps are B-splines of degree 7: nearly Gaussians, and one
of twice the width is a sum of nine narrow ones (Unser, IEEE Signal Process. Mag. 16:22, 1999), so that coarse sums follow
from fine ones exactly. Positions are in steps of the grid, from its corner.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import comb, factorial
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from sparsurf.kernels import njit
from sparsurf.patches.zernike.images import FAST

N_NODES = (25, 13, 7, 4)  # along a side of the grid, for bumps of width 1, 2, 4, 8
BUMP_NODES = 8  # nodes that a bump reaches along a side
PAD_NODES = 4  # nodes beyond each edge of the grid that bumps reach
PADDED_SIDE, MIDDLE = N_NODES[0] + 2 * PAD_NODES, N_NODES[0] // 2
# Positions of a dot between two nodes in the table of bumps. Values between them are interpolated linearly, with an error of
# 3e-6 of the highest value; with 64 positions it would be 4e-5.
N_TABLE = 256
# Sum of the bumps at which the dots weigh as much as the wider bumps; one dot at a node gives 0.23.
HALF_WEIGHT = 0.1
# Weights of narrow bumps in a wide one
SPLIT = tuple(comb(BUMP_NODES, k) / 2 ** (BUMP_NODES - 1) for k in range(BUMP_NODES + 1))


@cache
def bumps() -> np.ndarray:
    """Return the bump at the 8 nodes around a dot, (N_TABLE + 2, 8); row k: k / N_TABLE of a step beyond the fourth node."""
    t = np.arange(N_TABLE + 2)[:, None] / N_TABLE + 3 - np.arange(BUMP_NODES)
    power = np.maximum(t[..., None] + 4 - np.arange(BUMP_NODES + 1), 0.0) ** 7
    return power @ [(-1) ** k * comb(BUMP_NODES, k) / factorial(7) for k in range(BUMP_NODES + 1)]


def _eight(step: Callable[..., Any]) -> Any:
    """Make an intrinsic on eight neighbouring float64 of flat arrays, which the compiler would not vectorise as a loop."""

    @intrinsic
    def run(_typing: Any, to: Any, _at: Any, source: Any, _first: Any, _factor: Any) -> tuple[Any, Any]:
        def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            def pointer(k: int, offset: Any) -> Any:
                array = context.make_array(signature.args[k])(context, builder, value=args[k])
                return builder.bitcast(
                    builder.gep(array.data, [offset]), ir.VectorType(ir.DoubleType(), 8).as_pointer()
                )

            def load(k: int, offset: Any) -> Any:
                return builder.load(pointer(k, offset), align=8)

            undefined = ir.Constant(ir.VectorType(ir.DoubleType(), 8), ir.Undefined)
            zero = ir.Constant(ir.IntType(32), 0)
            lanes = ir.Constant(ir.VectorType(ir.IntType(32), 8), [0] * 8)
            factors = builder.shuffle_vector(
                builder.insert_element(undefined, args[4], zero), undefined, lanes
            )
            value = step(builder, load, args, factors)
            builder.store(value, pointer(0, args[1]), align=8)
            return context.get_dummy_value()

        return types.none(to, types.intp, source, types.intp, types.float64), build

    return run


def _multiply_add(builder: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, rounded twice as on processors that cannot fuse the two."""
    return builder.fadd(builder.fmul(a, b), c)


# to[at : at + 8] += factor * source[first : first + 8]
_add_eight = _eight(
    lambda builder, load, args, factor: _multiply_add(builder, factor, load(2, args[3]), load(0, args[1]))
)


def _between(builder: Any, load: Callable[..., Any], args: Any, factor: Any) -> Any:
    """Interpolate between eight numbers and the eight after them."""
    low = load(2, args[3])
    high = load(2, builder.add(args[3], ir.Constant(args[3].type, BUMP_NODES)))
    return _multiply_add(builder, factor, builder.fsub(high, low), low)


# to[at : at + 8] = source[first : first + 8] and the eight after them, interpolated by the share `factor`
_between_eight = _eight(_between)


@njit(fastmath=FAST)
def add_dots(dots: np.ndarray, bumps: np.ndarray, sums: np.ndarray) -> None:
    """Sum r times bump, and bump, over `dots` (4, n) at every node; `PAD_NODES` nodes beyond the grid are included.

    `dots` holds x and y in steps of the grid, r times weight, and weight. `bumps` and `sums` are flat.
    """
    sums[:] = 0.0
    axis_bumps = np.empty(2 * BUMP_NODES)
    for k in range(dots.shape[1]):
        column, row = np.intp(dots[0, k]), np.intp(dots[1, k])
        table_position = (dots[0, k] - column) * N_TABLE
        first, share = BUMP_NODES * np.intp(table_position), table_position - np.floor(table_position)
        _between_eight(axis_bumps, 0, bumps, first, share)
        table_position = (dots[1, k] - row) * N_TABLE
        first, share = BUMP_NODES * np.intp(table_position), table_position - np.floor(table_position)
        _between_eight(axis_bumps, BUMP_NODES, bumps, first, share)
        gr, g = dots[2, k], dots[3, k]
        node = (row + 1) * PADDED_SIDE + column + 1
        for b in range(BUMP_NODES):
            factor = axis_bumps[np.uintp(BUMP_NODES + b)]
            _add_eight(sums, node, axis_bumps, 0, gr * factor)
            _add_eight(sums, node + PADDED_SIDE * PADDED_SIDE, axis_bumps, 0, g * factor)
            node += PADDED_SIDE


@njit(fastmath=FAST)
def widen(
    fine: np.ndarray, side: int, wide_side: int, spare: np.ndarray, flipped: np.ndarray, wide: np.ndarray
) -> None:
    """Compute the sums for bumps of twice the width at every second node, with rows and columns exchanged."""
    n, m = side + 2 * PAD_NODES, wide_side + 2 * PAD_NODES
    for q in range(2):
        _widen_columns(fine[q], n, n, m, spare)
        for i in range(m):
            for j in range(n):
                flipped[j, i] = spare[i, j]
        _widen_columns(flipped, n, m, m, wide[q])


@njit(fastmath=FAST)
def _widen_columns(fine: np.ndarray, n: int, width: int, m: int, wide: np.ndarray) -> None:
    """Weight rows 2 i - 8 to 2 i of `fine` (n rows) into row i of `wide` (m rows); both have `width` columns."""
    for i in range(m):
        for j in range(width):
            wide[i, j] = 0.0
        for k in range(max(0, BUMP_NODES - 2 * i), min(BUMP_NODES + 1, n + BUMP_NODES - 2 * i)):
            row, factor = 2 * i + k - BUMP_NODES, SPLIT[k]
            for j in range(width):
                wide[i, j] += factor * fine[row, j]


@njit(fastmath=FAST)
def fill(sums: np.ndarray, mean: float, field: np.ndarray, spare: np.ndarray, flipped: np.ndarray) -> None:
    """Compute the field at the nodes: the mean under narrow bumps where they hold enough dots, else under wider ones."""
    field[:] = mean
    # From wide to narrow bumps, so that each gap takes the value of the narrowest ones that reach dots
    for level in range(len(N_NODES) - 1, -1, -1):
        side = N_NODES[level]
        if level < len(N_NODES) - 1:
            half = N_NODES[level + 1]
            _refine_columns(field, half, half, spare)
            for i in range(side):
                for j in range(half):
                    flipped[j, i] = spare[i, j]
            _refine_columns(flipped, half, side, field)
        for i in range(side):
            for j in range(side):
                above, below = (
                    sums[level, 0, i + PAD_NODES, j + PAD_NODES],
                    sums[level, 1, i + PAD_NODES, j + PAD_NODES],
                )
                field[i, j] = (above + HALF_WEIGHT * field[i, j]) / (below + HALF_WEIGHT)


@njit(fastmath=FAST)
def _refine_columns(coarse: np.ndarray, n: int, width: int, fine: np.ndarray) -> None:
    """Insert a row between any two rows of `coarse` (n rows, `width` columns) by cubic interpolation."""
    for i in range(n):
        for j in range(width):
            fine[2 * i, j] = coarse[i, j]
    for i in range(n - 1):
        before, after = max(i - 1, 0), min(i + 2, n - 1)
        for j in range(width):
            near, far = coarse[i, j] + coarse[i + 1, j], coarse[before, j] + coarse[after, j]
            fine[2 * i + 1, j] = 0.5625 * near - 0.0625 * far
