"""Versions of the library's code, as parameters of rules: Snakemake runs a job again when its code has changed."""

import hashlib
from pathlib import Path

LIBRARY = Path(__file__).parents[1]
DRAWING = ("report",)  # packages that draw figures and write pages
NOT_COMPUTING = (*DRAWING, "api", "cli", "workflow", "__init__", "__main__", "compile_kernels", "version")


def code_version(*parts: str) -> str:
    """Return a short hash of the bytes of all source files in packages or modules of src/sparsurf."""
    candidates = (path for part in parts for path in (LIBRARY / f"{part}.py", *(LIBRARY / part).rglob("*")))
    paths = sorted(path for path in candidates if path.is_file())
    sources = [path for path in paths if "__pycache__" not in path.parts]
    digest = hashlib.sha256()
    for path in sources:
        digest.update(path.relative_to(LIBRARY).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def computing_parts() -> list[str]:
    """Return the names of the packages and modules whose code decides the numbers of a study."""
    names = {
        path.stem for path in LIBRARY.iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()
    }
    return sorted(names - {*NOT_COMPUTING})


METHOD = code_version(*computing_parts())
REPORT = code_version(*DRAWING)
