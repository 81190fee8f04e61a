"""Bits of a machine word that kernels walk over: instructions of the processor that numba has no name for."""

from llvmlite import ir
from numba.extending import intrinsic


@intrinsic
def lowest_bit(typing, x):
    """Index of the lowest set bit of an unsigned integer (undefined for 0)."""

    def build(context, builder, signature, args):
        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 1))

    return x(x), build


@intrinsic
def count_bits(typing, x):
    """Number of set bits of an unsigned integer."""
    return x(x), lambda context, builder, signature, args: builder.ctpop(args[0])
