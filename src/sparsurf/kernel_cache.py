"""numba's `njit` for the kernels of this package, with a cache that notices edits in every file.

numba stores the compiled code of a function and compiles it again when the file of this function changes. It does not
notice that a function that is called, or a constant that is compiled in, has changed in another file. Kernels of this
package are therefore stored in a folder that is named after all their sources.
"""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba

LIBRARY = Path(__file__).parent
CONFIG: Any = numba.config  # numba sets its attributes at run time
Function = TypeVar("Function", bound=Callable[..., Any])


def njit(**options: Any) -> Callable[[Function], Function]:
    """Compile a function with `numba.njit(**options)`; with `cache=True`, store it in `cache_folder()`."""

    def decorate(function: Function) -> Function:
        folder = cache_folder()
        before, CONFIG.CACHE_DIR = CONFIG.CACHE_DIR, folder
        try:
            kernel: Any = numba.njit(**options | {"cache": options.get("cache", False) and bool(folder)})
            return kernel(function)
        finally:
            CONFIG.CACHE_DIR = before

    return decorate


@cache
def cache_folder() -> str:
    """Make the folder of the compiled kernels; empty if no folder can be written, where nothing is stored."""
    name = "sources-" + hashlib.sha256(kernel_sources()).hexdigest()[:16]
    for parent in _parent_folders():
        folder = parent / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError:
            continue
        return str(folder)
    return ""


def kernel_sources() -> bytes:
    """Text of the modules that hold kernels, and of those that they import: constants are compiled in."""
    sources = {
        ".".join(path.relative_to(LIBRARY).with_suffix("").parts): path.read_bytes()
        for path in sorted(LIBRARY.rglob("*.py"))
        if path != Path(__file__)
    }
    kernels = {name for name, source in sources.items() if b"@njit(" in source}
    for name in list(kernels):
        for module, names in re.findall(rb"^from sparsurf\.?([\w.]*) import (.*)", sources[name], re.M):
            kernels.add(module.decode())
            kernels |= {
                f"{module.decode()}.{word.decode()}".lstrip(".") for word in re.findall(rb"\w+", names)
            }
    return b"".join(source for name, source in sources.items() if name in kernels)


def _parent_folders() -> list[Path]:
    """Return folders that may hold the kernels, the best first: NUMBA_CACHE_DIR, the checkout, the user's cache."""
    if CONFIG.CACHE_DIR:
        return [Path(CONFIG.CACHE_DIR)]
    checkout, home = LIBRARY.parents[1], os.path.expanduser("~")
    folders = [checkout / ".cache" / "numba"] if (checkout / "Snakefile").is_file() else []
    user = os.environ.get("XDG_CACHE_HOME") or (f"{home}/.cache" if home != "~" else None)
    return folders + ([Path(user, "sparsurf", "numba")] if user else [])
