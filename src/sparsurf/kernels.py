"""`njit` of numba for the kernels of this package: a compiled kernel is loaded without the modules that compile.

Before numba loads a stored kernel, it prepares to compile one: it imports all that kernels may call, scipy.linalg included,
which takes a third of a second of every process. A stored kernel needs the functions that manage memory and nothing else.
numba still prepares itself before it compiles. Kernels of users stay as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core import caching, runtime

from sparsurf import progress

Function = TypeVar("Function", bound=Callable[..., Any])

# what `LightCache.load_overload` uses of numba, which does not document it
USED = ("load_overload", "_load_overload", "_guard_against_spurious_io_errors")
NUMBA_OFFERS_IT = (
    hasattr(caching, "FunctionCache")
    and all(hasattr(caching.FunctionCache, name) for name in USED)
    and hasattr(getattr(runtime, "rtsys", None), "initialize")
)
Cache: Any = caching.FunctionCache if NUMBA_OFFERS_IT else object


class LightCache(Cache):
    """numba's cache of the compiled forms of one kernel, which are loaded without `target_context.refresh()`."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the stored form for a signature; None if it is not stored."""
        runtime.rtsys.initialize(target_context)
        stored = None
        with self._guard_against_spurious_io_errors():
            stored = self._load_overload(sig, target_context)
        if stored is None and progress.before_compiling is not None:
            progress.before_compiling()
        return stored


def njit(**options: Any) -> Callable[[Function], Function]:
    """Compile a function with `numba.njit(**options)`, and load it as `LightCache` does where this numba allows it."""

    def decorate(function: Function) -> Function:
        kernel: Any = numba.njit(**options)(function)
        if NUMBA_OFFERS_IT and type(getattr(kernel, "_cache", None)) is caching.FunctionCache:
            kernel._cache = LightCache(function)
        return kernel

    return decorate
