"""Versions of the code, parameters of the rules: Snakemake compares the date of a script, and not the modules that it imports."""

import hashlib
import importlib.metadata
from collections.abc import Iterable, Iterator
from contextlib import suppress
from importlib.util import find_spec
from itertools import chain
from pathlib import Path

from sparsurf import registry

SOURCES = Path(__file__).parents[2]
PACKAGES = ("sparsurf", "sparsurf_study")
SIMULATION = "sparsurf_study/simulation/"
PAGES = ("sparsurf/views/", "sparsurf_study/report/")  # no number follows from these
# Nothing follows from commands, from the frame of jobs and from the names of outputs, which pages have among their parameters
WITHOUT_RESULTS = (
    "sparsurf/cli/",
    "sparsurf_study/workflow/",
    "sparsurf_study/config/",
    "sparsurf_study/run_study.",
    "sparsurf_study/check_run.",
    "sparsurf_study/manifest.",
    "sparsurf_study/debug.",
    "sparsurf_study/columns.",
    "sparsurf_study/catalogue.",
)
LIBRARIES = ("numpy", "scipy", "mdtraj", "gemmi", "numba")  # The libraries that compute results.


def versions_of_code() -> dict[str, str]:
    """Return the version of the code of simulations, of numbers, and of pages, with the packages and libraries that they use.

    A simulation takes days: it is not run again for another version of numpy, or for an edit elsewhere.
    """
    sources = chain.from_iterable(files_below(SOURCES / package) for package in PACKAGES)
    files = [path for path in sources if not named(path).startswith(WITHOUT_RESULTS)]
    further = [*libraries(), *packages()]
    return {
        "simulation": version_of(path for path in files if named(path).startswith(SIMULATION)),
        "numbers": version_of((path for path in files if not named(path).startswith(PAGES)), further),
        "pages": version_of(files, further),
    }


def version_of(files: Iterable[Path], further: Iterable[str] = ()) -> str:
    """Return a short hash of files, of their names and of further words."""
    digest = hashlib.sha256(" ".join(further).encode())
    for path in files:
        digest.update(named(path).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def named(path: Path) -> str:
    """Return the name of a file from src/ on."""
    return path.relative_to(SOURCES).as_posix() if path.is_relative_to(SOURCES) else path.name


def files_below(place: Path) -> Iterator[Path]:
    """Yield a file itself, or the files below a folder, without bytecode."""
    for path in sorted(place.rglob("*")) if place.is_dir() else [place]:
        if "__pycache__" not in path.parts and path.is_file():
            yield path


def packages() -> Iterator[str]:
    """Yield the names and versions of the installed packages whose samplers, say, the config names, with a hash of their code."""
    for choice in [choice for kind in registry.TABLE for choice in registry.plugins_in_use(kind).values()]:
        # the name of a package without a dot, for which `find_spec` imports nothing
        spec = find_spec(str(choice.source).partition(":")[0].partition(".")[0])
        places = [*(spec.submodule_search_locations or [spec.origin or ""])] if spec else []
        code = [path for place in places for path in files_below(Path(str(place))) if path.suffix == ".py"]
        yield f"{choice.package} {version_of(code)}"


def libraries() -> list[str]:
    """Return the libraries that compute, with their versions: numpy 2.4.6."""
    found = []
    for name in LIBRARIES:
        with suppress(importlib.metadata.PackageNotFoundError):
            found.append(f"{name} {importlib.metadata.version(name)}")
    return found
