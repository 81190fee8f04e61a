"""Threads for kernels that release the GIL; results never depend on how many there are."""

import os
from concurrent.futures import ThreadPoolExecutor


def available_cores():
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def over_slices(kernel, n, threads=1, size=2048):
    """Call `kernel(begin, end)` on slices of range(n), in threads; returns the results in order."""
    bounds = [(a, min(a + size, n)) for a in range(0, n, size)]
    if threads == 1 or len(bounds) == 1:
        return [kernel(a, b) for a, b in bounds]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(lambda ab: kernel(*ab), bounds))
