"""Garbage collection in a process that ends soon: a command, or a job of a study.

numba, pandas and matplotlib create half a million objects when they are imported. Python searches them for cycles hundreds of
times meanwhile, and once more when the process ends, which took a third of the 1.2 CPU s that the imports cost.
"""

import atexit
import gc
import os
import sys
import threading
from functools import cache
from typing import NoReturn

NEW_OBJECTS_PER_SEARCH, SEARCHES_PER_OLDER_ONE = 50_000, 10


@cache
def collect_rarely() -> None:
    """Let this process search for garbage rarely, and not when it ends; its memory is then freed as a whole."""
    gc.set_threshold(NEW_OBJECTS_PER_SEARCH, SEARCHES_PER_OLDER_ONE, SEARCHES_PER_OLDER_ONE)
    atexit.register(gc.freeze)


def end_process(code: int) -> NoReturn:
    """End this process after its exit functions, without taking its memory apart, which takes 30 to 60 ms."""
    if threading.active_count() == 1:
        atexit._run_exitfuncs()
        try:
            sys.stdout.flush()
            sys.stderr.flush()
        except OSError:  # Python reports what could not be written
            sys.exit(code)
        os._exit(code)
    sys.exit(code)
