"""Stored kernels: loaded without what compiles them, and as numba loads them where another numba lacks what this needs."""

import subprocess
import sys

from numba.core.caching import FunctionCache

from sparsurf import kernels

CALL_ALL = """
import sys
from sparsurf import compile_kernels
for part in compile_kernels.PARTS.values():
    part()
print(*{"numba.np.polynomial.polynomial_core", "numba.typed.typeddict"} & set(sys.modules))  # which no kernel uses
"""


def double(x):
    """A function to compile."""
    return 2 * x


def test_stored_kernels_load_without_what_compiles_them():
    for _ in range(2):  # the first may compile some
        run = subprocess.run([sys.executable, "-c", CALL_ALL], capture_output=True, text=True, check=True)
        if run.stdout == "\n":
            break
    assert run.stdout == "\n"


def test_another_numba_loads_kernels_as_it_does(monkeypatch):
    assert type(kernels.njit(cache=True)(double)._cache) is kernels.LightCache
    monkeypatch.setattr(kernels, "NUMBA_OFFERS_IT", False)
    kernel = kernels.njit(cache=True)(double)
    assert type(kernel._cache) is FunctionCache and kernel(21) == 42


def test_a_kernel_that_is_not_stored_stays_as_numba_makes_it():
    kernel = kernels.njit()(double)
    assert kernel(21) == 42 and kernel.stats.cache_path is None
