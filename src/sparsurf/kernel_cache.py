"""numba's `njit` for the kernels of this package, with a cache that notices edits in every file.

numba stores the compiled code of a function and compiles it again when the file of this function changes. It does not
notice that a function that is called, or a constant that is compiled in, has changed in another file. Kernels of this
package are therefore stored in a folder that is named after all their sources.

The folder belongs to these kernels alone: numba's settings, and so the kernels of a user, stay as they are. A kernel that is
stored is loaded without the modules with which numba compiles, which takes a quarter of a second of every process.
"""

from __future__ import annotations

import gc
import hashlib
import os
import re
import tempfile
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator
from numba.core.runtime import rtsys

LIBRARY = Path(__file__).parent
CONFIG: Any = numba.config  # numba sets its attributes at run time
Function = TypeVar("Function", bound=Callable[..., Any])


class KernelLocator(UserProvidedCacheLocator):
    """Where numba stores a kernel: in `cache_folder()`, whatever the folder of numba's own settings."""

    def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
        super().__init__(py_func, py_file)
        self._cache_path = os.path.join(cache_folder(), self.get_suitable_cache_subpath(py_file))

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> KernelLocator:
        """Return the path of a kernel."""
        return cls(py_func, py_file)


class KernelCacheFiles(CompileResultCacheImpl):
    """The files of a kernel, found by `KernelLocator`."""

    def __init__(self, py_func: Callable[..., Any]) -> None:
        self._locator_classes = [KernelLocator]
        super().__init__(py_func)


class KernelCache(FunctionCache):
    """The cache of a kernel, which loads what numba compiles with only if the kernel is not stored."""

    _impl_class = KernelCacheFiles

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load the compiled kernel of a signature; None if it is not stored."""
        rtsys.initialize(target_context)  # memory management, which stored kernels call
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)


def njit(**options: Any) -> Callable[[Function], Function]:
    """Compile a function with `numba.njit(**options)`; with `cache=True`, store it in `cache_folder()`."""
    stored = options.pop("cache", False)

    def decorate(function: Function) -> Function:
        kernel: Any = numba.njit(**options)(function)
        if getattr(numba.config, "DISABLE_JIT", False):  # numba sets its attributes at run time
            return kernel
        if stored and cache_folder():
            kernel._cache = KernelCache(function)
        kernel._compiler.compile = without_collecting(kernel._compiler.compile)
        return kernel

    return decorate


def without_collecting(compile_function: Function) -> Function:
    """Return the function with the garbage collector off while it runs: a compiler leaves little, and looking costs a tenth."""

    @wraps(compile_function)
    def run(*args: Any) -> Any:
        collecting = gc.isenabled()
        gc.disable()
        try:
            return compile_function(*args)
        finally:
            if collecting:
                gc.enable()

    return run  # type: ignore[return-value]


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
    """Return the text of the modules that hold kernels, and of those that they import: constants are compiled in."""
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
