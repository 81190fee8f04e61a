"""Minimal representations of a molecular surface, after Grassmann et al.

Glossary (the paper's symbols and the field's words; lengths in Å everywhere)

dot            one point of the molecular surface, with its outward unit normal
N              number of dots of the full surface
patch          dots within R_patch (roughness, sampling) or R_zernike (descriptors) of a
               dot, cut down to the largest island
island         connected component of a patch, two dots being linked when closer than D_link
centre         dot around which the sampling lays a patch
cover          the centres and their patches; every dot lies in at least one
R_i            roughness of the patch of dot i: 1 is flat, 0 is rough
n_S            number of dots that a sampling keeps
combination    one choice of (alpha, beta, gamma, delta)
draw           one random realisation of a combination, or of a uniform subset
test dot       dot at which the descriptors of two surfaces are compared
z              vector of the 121 Zernike invariants |c_nm| of a patch
Z_tS, Z_tR     mean |z_tot - z_S|, mean |z_tot - z_R| over the test dots
d              Z_tR - Z_tS: positive where the sampling beats the uniform subset
reading        how 'the points not connected are removed' is understood:
               'kept' among the kept dots, 'surface' on the full surface
range          one of ten equal intervals of n_S
conformation   one frame, structure or surface that enters the study
"""

import atexit
import hashlib
import os
import re
import shutil
import tempfile
from pathlib import Path


class InputError(ValueError):
    """Something the user gave is wrong; the message is one sentence for them."""


def _kernel_sources():
    """Text of the modules that hold kernels, and of those that these import: constants are compiled in."""
    sources = {path.stem: path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))}
    kernels = {name for name, source in sources.items() if b"njit" in source}
    for name in list(kernels):
        for words in re.findall(rb"^from sparsurf(?:\.(\w+)|) import (.*)", sources[name], re.M):
            kernels.update(re.findall(r"\w+", b" ".join(words).decode()))
    return b"".join(source for name, source in sources.items() if name in kernels)


def _use_cache_of_these_sources():
    """Compiled kernels go to a folder named after their sources: numba does not see edits in another file.

    Where that folder cannot be written, they go to a temporary one, shared with child processes.
    """
    digest = hashlib.sha256(_kernel_sources()).hexdigest()[:16]
    base = Path(os.environ.get("NUMBA_CACHE_DIR") or Path(__file__).parents[2] / ".cache" / "numba")
    if base.name.startswith("sources-"):  # set by a parent process
        base = base.parent
    folder = base / f"sources-{digest}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        base = tempfile.mkdtemp(prefix="sparsurf-")
        atexit.register(shutil.rmtree, base, ignore_errors=True)
        folder = Path(base) / f"sources-{digest}"
        folder.mkdir()
    os.environ["NUMBA_CACHE_DIR"] = str(folder)


_use_cache_of_these_sources()
