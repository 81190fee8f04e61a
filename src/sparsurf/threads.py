"""Threads for kernels that release the GIL; results never depend on how many there are."""

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cache

from threadpoolctl import ThreadpoolController


def available_cores():
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def parallel_map(kernel, n, threads=1, size=2048):
    """Call `kernel(begin, end)` on slices of range(n), in threads; returns the results in order.

    BLAS runs in one thread within each: its own would only stand in their way.
    """
    bounds = [(a, min(a + size, n)) for a in range(0, n, size)]
    with _libraries().limit(limits=1, user_api="blas"):
        if threads == 1 or len(bounds) == 1:
            return [kernel(a, b) for a, b in bounds]
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(lambda ab: kernel(*ab), bounds))


@cache
def _libraries():
    """The libraries that have threads of their own; looking for them takes as long as a small kernel."""
    return ThreadpoolController()
