"""Bit operations for kernels: instructions of the processor that numba has no name for."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.extending import intrinsic


@intrinsic
def lowest_bit(_typing_context: Any, x: Any) -> Any:
    """Return the index of the lowest set bit of an unsigned integer (undefined for 0)."""

    def build(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 1))

    return x(x), build


@intrinsic
def count_bits(_typing_context: Any, x: Any) -> Any:
    """Return the number of set bits of an unsigned integer."""
    return x(x), lambda context, builder, signature, args: builder.ctpop(args[0])
