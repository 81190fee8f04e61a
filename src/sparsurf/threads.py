"""Threads for kernels that release the GIL, and processes. Results never depend on their number."""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, TypeVar

from threadpoolctl import ThreadpoolController

Task = TypeVar("Task")
TaskResult = TypeVar("TaskResult")
SECONDS_BETWEEN_LOOKS_AT_PARENT = 1.0
_function: Callable[[Any], Any] | None = None  # of the pool that this process belongs to


def ignore_numba_threads() -> None:
    """Remove the number of numba's own threads, which no kernel uses: numba does not load where it is 0."""
    os.environ.pop("NUMBA_NUM_THREADS", None)


def available_cores() -> int:
    """Return the number of cores that this process may use; each of a pool uses one."""
    if _function is not None:
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_processes(
    function: Callable[[Task], TaskResult],
    tasks: Iterable[Task],
    jobs: int,
    waiting_per_job: int,
) -> Iterator[TaskResult]:
    """Yield the results of a function of each task in order, from several processes; few of them wait at a time.

    A process that is forked shares what the function holds, and ends with this one, also where this one is killed. If the
    iterator is closed or interrupted, tasks that wait are cancelled.
    """
    import multiprocessing  # here: one process needs no others
    from concurrent.futures import Future, ProcessPoolExecutor

    methods = multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("fork" if "fork" in methods else None)
    waiting: deque[Future[TaskResult]] = deque()
    with ProcessPoolExecutor(jobs, context, _begin_process, (os.getpid(), function)) as pool:
        try:
            for task in tasks:
                waiting.append(pool.submit(_run, task))
                if len(waiting) >= waiting_per_job * jobs:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _begin_process(parent: int, function: Callable[[Any], Any]) -> None:
    """Begin a process of a pool, which would wait for tasks for ever where its parent was killed."""
    global _function
    _function = function

    def end_with_parent() -> None:
        while os.getppid() == parent:
            time.sleep(SECONDS_BETWEEN_LOOKS_AT_PARENT)
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()


def _run(task: Any) -> Any:
    """Return what the function of this pool returns."""
    return _function(task)  # type: ignore[misc]


def bytes_of_memory() -> float:
    """Return the memory of this machine, bytes; infinity where the system does not tell it."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return float("inf")


def parallel_map(
    function: Callable[[int, int], TaskResult], n: int, threads: int, size: int = 2048
) -> list[TaskResult]:
    """Call `function(begin, end)` on slices of range(n), in threads with BLAS limited to one; return the results in order."""
    slices = [(begin, min(begin + size, n)) for begin in range(0, n, size)]
    with _thread_pools().limit(limits=1, user_api="blas"):
        if threads == 1 or len(slices) == 1:
            return [function(begin, end) for begin, end in slices]
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(lambda bounds: function(*bounds), slices))


@cache
def _thread_pools() -> ThreadpoolController:
    """Find the libraries with thread pools, once: the search takes as long as a small kernel."""
    return ThreadpoolController()
