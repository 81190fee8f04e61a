"""Compiled kernels go to a folder named after their sources: numba does not see edits in another file."""

import atexit
import hashlib
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

LIBRARY = Path(__file__).parent


def kernel_sources():
    """Text of the modules that hold kernels, and of those that these import: constants are compiled in."""
    sources = {
        ".".join(path.relative_to(LIBRARY).with_suffix("").parts): path.read_bytes()
        for path in sorted(LIBRARY.rglob("*.py"))
        if path != Path(__file__)
    }
    kernels = {name for name, source in sources.items() if b"njit" in source}
    for name in list(kernels):
        for module, words in re.findall(rb"^from sparsurf\.?([\w.]*) import (.*)", sources[name], re.M):
            module = module.decode()
            kernels.add(module)
            kernels.update(f"{module}.{word}".lstrip(".") for word in re.findall(r"\w+", words.decode()))
    return b"".join(source for name, source in sources.items() if name in kernels)


def use():
    """Point numba at the folder of these sources, shared with child processes.

    It lies in the checkout; of an installed package, or a checkout that cannot be written, in the user's cache; and
    where that cannot be written either, in a temporary folder.
    """
    name = "sources-" + hashlib.sha256(kernel_sources()).hexdigest()[:16]
    for base in _places():
        folder = base / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
            break
        except OSError:
            continue
    else:
        base = tempfile.mkdtemp(prefix="sparsurf-")
        atexit.register(shutil.rmtree, base, ignore_errors=True)
        folder = Path(base) / name
        folder.mkdir()
    os.environ["NUMBA_CACHE_DIR"] = str(folder)


def mark(*what):
    """File in that folder which says that some kernels were compiled: by this Python and numba, on this machine."""
    from importlib.metadata import version  # not worth its time where nobody asks

    compiler = (sys.implementation.cache_tag, f"numba{version('numba')}", os.uname().nodename)
    return Path(os.environ["NUMBA_CACHE_DIR"], "-".join(("compiled", *what, *compiler)))


def _places():
    """Folders that may hold the kernels, the best first."""
    told = os.environ.get("NUMBA_CACHE_DIR")
    if told:
        base = Path(told)
        return [base.parent if base.name.startswith("sources-") else base]  # set by a parent process
    checkout, home = LIBRARY.parents[1], os.path.expanduser("~")
    places = [checkout / ".cache" / "numba"] if (checkout / "Snakefile").is_file() else []
    user = os.environ.get("XDG_CACHE_HOME") or (f"{home}/.cache" if home != "~" else None)
    return places + ([Path(user, "sparsurf", "numba")] if user else [])
