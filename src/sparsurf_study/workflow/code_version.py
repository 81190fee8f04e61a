"""Version of the code that a script calls, as a parameter of its rule: Snakemake runs a job again when that code has changed."""

import hashlib
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[3]  # of the checkout
SOURCES = ROOT / "src"
IMPORT_OF_ANY = re.compile(r'import_module\(f"([\w.]+)\.\{')  # a module of a package, by a name
PACKAGES = ("sparsurf", "sparsurf_study")
NO_RESULTS = (
    "sparsurf_study/workflow/",
    "sparsurf_study/columns.",
)  # frames of jobs, names of columns: no number follows
IMPORT = re.compile(r"^\s*(?:from\s+([\w.]+)\s+import\s+(\([^)]*\)|[^\n#]+)|import\s+([\w.]+))", re.MULTILINE)


@cache
def code_of(script: str) -> str:
    """Return a short hash of all modules that a script of scripts/ imports, directly or through others, and of their data files.

    An import below `if TYPE_CHECKING` counts as well: at worst, a job is run again in vain.
    """
    digest = hashlib.sha256()
    for path in sorted(sources_of(ROOT / "scripts" / f"{script}.py")):
        name = path.relative_to(SOURCES).as_posix()
        if not name.startswith(NO_RESULTS):
            digest.update(name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def sources_of(script: Path) -> set[Path]:
    """Return the files of this project that a script needs: modules, and the data files that these name."""
    found: set[Path] = set()
    waiting = [*needed_by(script)]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += needed_by(path) if path.suffix == ".py" else ()
    return found


@cache
def needed_by(path: Path) -> frozenset[Path]:
    """Return the modules of this project that a Python file imports, and the data beside it that it names in quotes."""
    text = path.read_text(encoding="utf-8")
    modules = set()
    for package, names, module in IMPORT.findall(text):
        if (package or module).partition(".")[0] in PACKAGES:
            modules |= {module or package}
            modules |= {
                f"{package}.{name.split()[0]}" for name in re.split(r"[(),\n]", names) if name.strip()
            }
    files = {file for module in modules for file in files_of_module(module)}
    for package in IMPORT_OF_ANY.findall(text):
        files |= {*SOURCES.joinpath(*package.split(".")).glob("*.py")}
    return frozenset(
        files
        | {file for data in path.parent.iterdir() if f'"{data.name}"' in text for file in all_files(data)}
    )


def files_of_module(name: str) -> list[Path]:
    """Return the file of a module and the __init__.py of its packages, but not that of the root, which loads lazily."""
    parts = name.split(".")
    module = SOURCES.joinpath(*parts).with_suffix(".py")
    packages = [SOURCES.joinpath(*parts[:k], "__init__.py") for k in range(2, len(parts) + 1)]
    return [file for file in (module, *packages) if file.is_file()]


def all_files(path: Path) -> list[Path]:
    """Return a file of data, or those of a folder; none of a package."""
    if path.is_file():
        return [path] if path.suffix != ".py" else []
    if (path / "__init__.py").is_file():
        return []
    return [file for file in path.rglob("*") if file.is_file() and "__pycache__" not in file.parts]
