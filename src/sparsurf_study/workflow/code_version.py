"""Version of the code that a script calls, as a parameter of its rule: Snakemake runs a job again when that code has changed."""

import ast
import hashlib
import os
import re
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from sparsurf import kinds

ROOT = Path(__file__).parents[3]  # of the checkout
SOURCES = ROOT / "src"
IMPORT = re.compile(r"^[ \t]*((?:import|from)\b[^(\n]*(?:\([^)]*\))?)", re.MULTILINE)
IMPORT_AFTER_ANOTHER = re.compile(r"[:;][ \t]*(?:import|from)\b")  # in one line with another statement
LOAD_OF_A_KIND = re.compile(r'kinds\.load\(\s*"(\w+)"')
LARGEST_FILE_READ = 10**7  # bytes, of a file of an installed package
PACKAGES = ("sparsurf", "sparsurf_study")
# No number follows from the frame of jobs or the names of columns and outputs; pages have the catalogue among their parameters
FILES_WITHOUT_RESULTS = ("sparsurf_study/workflow/", "sparsurf_study/columns.", "sparsurf_study/catalogue.")


@cache
def code_of(script: str) -> str:
    """Return a short hash of all modules that a script of scripts/ imports, directly or through others, and of their data files.

    An import below `if TYPE_CHECKING` counts as well: at worst, a job is run again in vain. So does the code of an installed
    package whose sampler, say, the config names: only jobs that sample run again when it changes.
    """
    digest = hashlib.sha256()
    sources = sorted(sources_of(ROOT / "scripts" / f"{script}.py"))
    for kind in sorted({kind for path in sources for kind in kinds_loaded_by(path)}):
        for choice in kinds.plugins_in_use(kind).values():
            digest.update(code_of_package(choice))
    for path in sources:
        digest.update(counted(path))
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
def counted(path: Path) -> bytes:
    """Return what the hash contains of a file: its name and content; nothing of a file from which no number follows."""
    name = path.relative_to(SOURCES).as_posix()
    return b"" if name.startswith(FILES_WITHOUT_RESULTS) else name.encode() + b"\0" + path.read_bytes()


@cache
def needed_by(path: Path) -> frozenset[Path]:
    """Return the modules of this project that a Python file imports, and the data beside it that it names in quotes."""
    text = path.read_text(encoding="utf-8")
    names = {name for node in statements(tree_of_imports(text, path)) for name in imported_names(node, path)}
    files: set[Path] = set()
    for name in names:
        if name.partition(".")[0] in PACKAGES:
            files |= {*files_of_module(name)}
    if "import_module(" in text:  # the only expression that imports; a walk over all of them takes long
        files |= {file for node in ast.walk(ast.parse(text)) for file in imported_by_name(node)}
    files |= {file for kind in kinds_loaded_by(path) for file in files_of_kind(kind)}
    for name, data in data_in(path.parent).items():
        if f'"{name}"' in text:
            files.update(data)
    return frozenset(files)


def tree_of_imports(text: str, path: Path) -> ast.Module:
    """Return the syntax tree of the imports of a file; that of the whole file where its lines alone do not tell them.

    Each call of Snakemake reads all modules of the project, and parsing them takes twenty times as long as parsing their imports.
    """
    found = [*IMPORT.finditer(text)]
    in_a_string = any(text.count('"""', 0, match.start()) % 2 for match in found)
    if not in_a_string and not IMPORT_AFTER_ANOTHER.search(text):
        try:
            return ast.parse("\n".join(match[1] for match in found))
        except SyntaxError:  # an import over several lines without parentheses, or a line of another string
            pass
    return ast.parse(text, str(path))


def statements(tree: ast.Module) -> Iterator[ast.AST]:
    """Yield all statements of a file, also those within functions and conditions, whose imports a job may reach as well."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        for block in ("body", "orelse", "handlers", "finalbody", "cases"):
            inner = getattr(node, block, ())
            waiting += inner if isinstance(inner, list) else ()  # that of a lambda is an expression


def imported_names(statement: ast.AST, path: Path) -> Iterator[str]:
    """Yield the full names that a statement of a file imports: modules, and the names within them."""
    if isinstance(statement, ast.Import):
        yield from (alias.name for alias in statement.names)
    elif isinstance(statement, ast.ImportFrom):
        module = [statement.module] if statement.module else []
        if statement.level:  # a relative import, counted from the package that holds the file
            module = [*path.relative_to(SOURCES).parts[: -statement.level], *module]
        yield ".".join(module)
        yield from (".".join([*module, alias.name]) for alias in statement.names)


def imported_by_name(node: ast.AST) -> list[Path]:
    """Return the modules that a call of import_module may import: one, or for f"package.{name}" all of a package."""
    if not (isinstance(node, ast.Call) and node.args):
        return []
    function = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", None)
    name = node.args[0]
    first = name.values[0] if isinstance(name, ast.JoinedStr) else name
    if function != "import_module" or not isinstance(first, ast.Constant):
        return []
    package, _, module = str(first.value).rpartition(".")
    if package.partition(".")[0] not in PACKAGES:
        return []
    if first is name:
        return files_of_module(f"{package}.{module}")
    return [*SOURCES.joinpath(*package.split(".")).glob(f"{module}*.py")]


@cache
def kinds_loaded_by(path: Path) -> frozenset[str]:
    """Return the kinds of `sparsurf.kinds` whose functions a Python file loads by name."""
    return (
        frozenset(LOAD_OF_A_KIND.findall(path.read_text(encoding="utf-8")))
        if path.suffix == ".py"
        else frozenset()
    )


def files_of_kind(kind: str) -> list[Path]:
    """Return the files of the modules that hold the library's functions of a kind."""
    return [file for module in kinds.modules(kind) for file in files_of_module(module)]


@cache
def code_of_package(choice: kinds.Choice) -> bytes:
    """Return a hash of an installed package that adds a choice: its name and version, and the files of its module or folder.

    A file of more than 10 MB, such as the weights of a network, counts by its name and size: each job computes this hash.
    """
    digest = hashlib.sha256(choice.package.encode())
    # The name of a package without a dot, for which `find_spec` imports nothing
    spec = find_spec(str(choice.source).partition(":")[0].partition(".")[0])
    folders = list(spec.submodule_search_locations or ()) if spec else []
    files = [Path(spec.origin)] if spec and spec.origin and not folders else []
    for folder in folders:
        for path in Path(folder).rglob("*"):
            is_bytecode = path.suffix == ".pyc" or "__pycache__" in path.parts
            if path.is_file() and not is_bytecode:
                files.append(path)
    for path in sorted(files):
        size = path.stat().st_size
        content = path.read_bytes() if size <= LARGEST_FILE_READ else str(size).encode()
        digest.update(path.name.encode() + b"\0" + content)
    return digest.digest()


@cache
def files_of_module(name: str) -> list[Path]:
    """Return the file of a module and the __init__.py of its packages, but not that of the root, which loads lazily."""
    parts = name.split(".")
    packages = ["/".join([*parts[:k], "__init__.py"]) for k in range(2, len(parts) + 1)]
    return [
        SOURCES / file for file in ("/".join(parts) + ".py", *packages) if os.path.isfile(f"{SOURCES}/{file}")
    ]


@cache
def data_in(folder: Path) -> dict[str, list[Path]]:
    """Return the files of data of a folder, and the folders of data with their files, by name."""
    found = {}
    for path in folder.iterdir():
        if path.suffix != ".py" and path.name != "__pycache__" and not (path / "__init__.py").is_file():
            files = [path] if path.is_file() else path.rglob("*")
            found[path.name] = [file for file in files if file.is_file() and "__pycache__" not in file.parts]
    return found
