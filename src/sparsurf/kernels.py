"""`njit` of numba for the kernels of this package: a compiled kernel is loaded without the modules that compile.

Before numba loads a stored kernel, it prepares to compile one: it imports all that kernels may call, scipy.linalg included,
which takes a third of a second of every process. A stored kernel needs the functions that manage memory and nothing else.
numba still prepares itself before it compiles. Kernels of users stay as they are.
"""

from __future__ import annotations

import glob
import hashlib
import inspect
import os
import re
import sys
import uuid
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import caching, runtime

from sparsurf import progress

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

Function = TypeVar("Function", bound=Callable[..., Any])

LIBRARY = Path(__file__).resolve().parent
COMPILED = (b"@njit(", b"@intrinsic")  # in a source with kernels
IMPORTED = re.compile(rb"^from (sparsurf\w*(?:\.\w+)+) import ([^\n(]*)", re.MULTILINE)
# what `LightCache` uses of numba, which does not document it
NUMBA_INTERNALS = {
    "FunctionCache": ("load_overload", "_index_key", "_guard_against_spurious_io_errors"),
    "IndexDataCacheFile": ("save", "_load_index", "_save_index", "_save_data"),
}
NUMBA_OFFERS_IT = all(
    hasattr(getattr(caching, owner, None), name) for owner, names in NUMBA_INTERNALS.items() for name in names
) and hasattr(getattr(runtime, "rtsys", None), "initialize")
Cache: Any = caching.FunctionCache if NUMBA_OFFERS_IT else object
Files: Any = caching.IndexDataCacheFile if NUMBA_OFFERS_IT else object


class StoredForms(Files):
    """The files of the compiled forms of one kernel: an index, and a file of each form under a name of its own.

    numba numbers these files, and writes the index before the file that it names. A process that reads in between, or after a
    kill there, would load a form of an older version, or of another signature.
    """

    def __init__(self, folder: str, name: str, stamp: Any) -> None:
        """Name the files as numba does, and stamp the index with numba's version and what the kernels are compiled from."""
        super().__init__(folder, name, stamp)
        self._folder, self._name = Path(folder), name
        # The version is compared before the rest of a file is read: the types that another version of this package names there
        # may be gone
        self._version: Any = (numba.__version__, stamp)

    def save(self, key: Any, data: Any) -> None:
        """Store a form, then name it in the index, then remove the forms that the index does not name."""
        file = f"{self._name}.{uuid.uuid4().hex[:16]}.nbc"
        with _locked(self._folder):  # another process may have stored a form that it has not named yet
            self._save_data(file, data)
            forms = self._load_index() | {key: file}
            self._save_index(forms)
            for path in self._folder.glob(f"{glob.escape(self._name)}.*.nbc"):
                if path.name not in forms.values():
                    path.unlink(missing_ok=True)


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the lock of a folder, where its system has such locks."""
    with ExitStack() as stack:
        if fcntl is not None:
            place = os.open(folder, os.O_RDONLY)
            stack.callback(os.close, place)
            with suppress(OSError):  # a file system without locks
                fcntl.flock(place, fcntl.LOCK_EX)
        yield


class LightCache(Cache):
    """numba's cache of the compiled forms of one kernel, which are loaded without `target_context.refresh()`.

    numba stamps a stored kernel with its own source alone, although it contains what it calls from other sources: after an
    upgrade, kernels of the older version would run. Here the stamp is `hash_of_kernels`. The kernels that were installed with
    the package are read first, also where numba stores new ones in another folder.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        """Keep the function; most kernels of a process are never called, and their files are not looked for."""
        self._function = function

    def __getattr__(self, name: str) -> Any:
        """Choose the folders as numba does, and the `__pycache__` beside the source, when an attribute is first read."""
        if "_impl" in vars(self) or name.startswith("__"):
            raise AttributeError(name)
        function = self._function
        super().__init__(function)
        source = inspect.getfile(function)
        package = (function.__module__ or "").partition(".")[0]
        stamp: Any = hash_of_kernels(package)
        if not _is_inside(source, package):  # a function of another project
            stamp = stamp, self._impl.locator.get_source_stamp()
        folder_of_source = os.path.join(os.path.dirname(source), "__pycache__")
        self._installed, self._cache_file = (
            StoredForms(folder, self._impl.filename_base, stamp)
            for folder in (folder_of_source, self._cache_path)
        )
        return getattr(self, name)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the stored form for a signature; None if it is not stored."""
        runtime.rtsys.initialize(target_context)
        stored = None
        with self._guard_against_spurious_io_errors():
            if self._enabled:
                key = self._index_key(sig, target_context.codegen())
                stored = self._installed.load(key) or self._cache_file.load(key)
        if stored is not None:
            return self._impl.rebuild(target_context, stored)
        if progress.before_compiling is not None:
            progress.before_compiling()
        return None


@cache
def hash_of_kernels(package: str) -> bytes:
    """Return a hash of the sources from which kernels are compiled: of the library, and of the package that calls it.

    These are the sources with kernels and those from which they import constants.
    """
    digest = hashlib.sha256()
    for folder in dict.fromkeys((LIBRARY, _folder_of(package) or LIBRARY)):
        sources = {path: path.read_bytes() for path in folder.rglob("*.py")}
        compiled = {path for path, text in sources.items() if any(word in text for word in COMPILED)}
        for path in [*compiled]:
            for module, names in IMPORTED.findall(sources[path]):
                parts = module.decode().split(".")[1:]
                for below in ([], *([name.strip()] for name in names.decode().split(","))):
                    compiled.add(folder.joinpath(*parts, *below).with_suffix(".py"))
        for path in sorted(compiled & sources.keys()):
            digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + sources[path])
    return digest.digest()


def _folder_of(package: str) -> Path | None:
    """Return the folder of a package that is imported; None for a module of one file."""
    module = sys.modules.get(package)
    file = getattr(module, "__file__", None)
    return Path(file).resolve().parent if file and hasattr(module, "__path__") else None


def _is_inside(source: str, package: str) -> bool:
    """Return whether a source lies in the folder of its package, all of whose kernels are hashed."""
    folder = _folder_of(package)
    return folder is not None and Path(source).resolve().is_relative_to(folder)


def njit(**options: Any) -> Callable[[Function], Function]:
    """Compile a function with `numba.njit(cache=True, nogil=True, **options)`, and store it as `LightCache` does.

    Where this numba lacks what `LightCache` uses, kernels are compiled in each process: a stored one might be that of another
    version.
    """
    options = {"cache": NUMBA_OFFERS_IT, "nogil": True} | options
    is_stored = NUMBA_OFFERS_IT and options.pop("cache")

    def decorate(function: Function) -> Function:
        kernel: Any = numba.njit(**options)(function)
        if is_stored and hasattr(kernel, "_cache"):  # not where numba is told to compile nothing
            kernel._cache = LightCache(function)
        return kernel

    return decorate
