"""Versions of the library's code, as parameters of rules: Snakemake runs a job again when its code has changed."""

import hashlib
from pathlib import Path

LIBRARY = Path(__file__).parents[1]
DRAWING = ("report",)  # packages that draw figures and write pages
NOT_COMPUTING = (*DRAWING, "cli", "workflow")


def code_version(*packages: str) -> str:
    """Return a short hash of the bytes of all source files in packages of the library.

    Parameters
    ----------
    packages : names of folders in src/sparsurf
    """
    paths = sorted(path for package in packages for path in (LIBRARY / package).rglob("*") if path.is_file())
    sources = [path for path in paths if "__pycache__" not in path.parts]
    digest = hashlib.sha256()
    for path in sources:
        digest.update(path.relative_to(LIBRARY).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def computing_packages() -> list[str]:
    """Return the names of the packages whose code decides the numbers of a study."""
    folders = (path.name for path in LIBRARY.iterdir() if (path / "__init__.py").is_file())
    return sorted(name for name in folders if name not in NOT_COMPUTING)


METHOD = code_version(*computing_packages())
REPORT = code_version(*DRAWING)
