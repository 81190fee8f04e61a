"""Choose the folders where numba stores compiled kernels and matplotlib its list of fonts, before either is loaded.

numba looks for one beside the package and in the user's cache, and fails with a traceback where it may write to neither, as
in a container whose package is read-only, under an account without a home; matplotlib warns there. A folder of the user under
the temporary directory takes their place.
"""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from functools import cache
from pathlib import Path

from sparsurf.errors import InputError

VARIABLE, OF_MATPLOTLIB = "NUMBA_CACHE_DIR", "MPLCONFIGDIR"
PACKAGE = Path(__file__).resolve().parent


def choose_kernel_cache() -> None:
    """Name a folder under the temporary directory in NUMBA_CACHE_DIR if numba would find no other; also for child processes."""
    if not _has_kernel_cache(os.environ.get(VARIABLE)) and (folder := _temporary_folder()):
        os.environ[VARIABLE] = folder
        if numba := sys.modules.get("numba"):
            numba.config.CACHE_DIR = folder


def choose_matplotlib_folder() -> None:
    """Name a folder under the temporary directory in MPLCONFIGDIR if matplotlib would find no other; also for child processes."""
    named, home = os.environ.get(OF_MATPLOTLIB), os.path.expanduser("~")
    if named:
        folders = [named]
    elif sys.platform.startswith(("linux", "freebsd")):
        bases = {"XDG_CONFIG_HOME": ".config", "XDG_CACHE_HOME": ".cache"}
        folders = [
            os.path.join(os.environ.get(variable) or os.path.join(home, name), "matplotlib")
            for variable, name in bases.items()
        ]
    else:
        folders = [os.path.join(home, ".matplotlib")]
    # the home of an account that has none is "~"
    usable = all(os.path.isabs(folder) and _can_write(Path(folder)) for folder in folders)
    if not usable and (folder := _temporary_folder()):
        os.environ[OF_MATPLOTLIB] = os.path.join(folder, "matplotlib")


def require_kernel_cache() -> None:
    """Raise InputError if compiled kernels can be stored nowhere."""
    if not _has_kernel_cache(os.environ.get(VARIABLE)):
        raise InputError(
            "no folder can be written for the compiled kernels, neither beside the package nor in the user's cache nor in the "
            f"temporary directory: set {VARIABLE} to one that can."
        )


@cache
def _has_kernel_cache(named: str | None) -> bool:
    """Return whether numba may write to the folder that the user names, beside every kernel, or to the user's cache."""
    if named and _can_write(Path(named)):
        return True
    packages = [path.parent for path in PACKAGE.rglob("__init__.py")]
    if all(_can_write(folder / "__pycache__") for folder in packages):
        return True
    return can_write_cache("numba")


def can_write_cache(folder: str) -> bool:
    """Return whether the cache of the user, or a folder in it, can be written; an account without a home has none."""
    cache_of_user = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    return cache_of_user.is_absolute() and _can_write(cache_of_user / folder)


def _can_write(folder: Path) -> bool:
    """Return whether files can be made in a folder, or the folder itself where it does not exist."""
    while not os.path.lexists(folder) and folder != folder.parent:
        folder = folder.parent
    return folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)


def _temporary_folder() -> str:
    """Return a folder under the temporary directory to which this user alone may write; empty if there is none."""
    try:
        folder = os.path.join(tempfile.gettempdir(), f"sparsurf-kernels-{os.getuid()}")
        os.makedirs(folder, mode=0o700, exist_ok=True)
        found = os.lstat(folder)
        is_private = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022
        # compiled kernels are loaded as code, so that nobody else may put them there
        return (
            folder
            if is_private and os.access(folder, os.W_OK)
            else tempfile.mkdtemp(prefix="sparsurf-kernels-")
        )
    except OSError:
        return ""
