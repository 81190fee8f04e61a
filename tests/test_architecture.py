"""The house itself: which way imports point, where arithmetic lives, what is written down once."""

import ast
import re
import subprocess
import sys
from functools import cache

import pytest
import yaml

from conftest import ROOT
from sparsurf.workflow.models import Config

LIBRARY = ROOT / "src" / "sparsurf"
# A package may import only itself and the packages above it.
PACKAGES = [
    "top",  # what everyone needs and nobody owns: the modules beside the packages
    "molecules",  # atoms in Å from any file; knows no surface
    "simulation",  # a structure becomes a trajectory, by GROMACS; knows no surface
    "surfaces",  # dots with normals: made, read, written; knows no patch
    "dot_fields",  # numbers at dots, from the molecule; knows no patch
    "patches",  # what lies around one dot, and its numbers; arrays in, arrays out
    "recovery",  # a dense surface from few dots with normals; knows no descriptor
    "sampling",  # which dots are kept
    "study",  # numbers about subsets: arrays and tables, no sentence, no figure
    "pairs",  # two surfaces: what the patches of one say of the other
    "paper",  # the paper beside ours: its runs made again, its claims
    "batches",  # thousands of structures: a job for many, a table for all
    "report",  # tables become sentences and pictures; computes nothing
    "api",  # the functions for users: they check what users hold and call the packages above
    "cli",  # the command line: it parses, calls the functions for users, and writes
    "workflow",  # what the Snakefile asks; imported by nobody else
]
MODULES = sorted(path.relative_to(LIBRARY) for path in LIBRARY.rglob("*.py"))
SCRIPTS = sorted((ROOT / "scripts").glob("*.py"))


def package(path):
    """Package of a module, by its path inside the library."""
    if path.name in ("__main__.py", "compile_kernels.py"):  # programs that call everything
        return "cli"
    return path.parts[0] if len(path.parts) > 1 else "top"


def imported(path, for_hints=True):
    """Modules of the library that a file imports, as paths inside the library; without `for_hints` those at run time."""
    found, tree = set(), ast.parse(path.read_text())
    blocks = [node for node in ast.walk(tree) if isinstance(node, ast.If)]
    hints = [block for block in blocks if ast.unparse(block.test) == "TYPE_CHECKING"]
    skipped = set() if for_hints else {node for block in hints for node in ast.walk(block)}
    for node in set(ast.walk(tree)) - skipped:
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "sparsurf":
            module = LIBRARY.parent.joinpath(*node.module.split("."))
            files = [module.with_suffix(".py"), *(module / f"{alias.name}.py" for alias in node.names)]
            found |= {file.relative_to(LIBRARY) for file in files if file.is_file()}
        assert not (isinstance(node, ast.ImportFrom) and node.level), "imports are absolute"
    return found


@pytest.mark.parametrize("module", MODULES, ids=str)
def test_imports_point_one_way(module):
    above = PACKAGES[: PACKAGES.index(package(module)) + 1]
    hints = module.name != "__init__.py"  # which shows the functions for users to type checkers
    assert {package(other) for other in imported(LIBRARY / module, hints)} <= set(above)


SIZES = {"library, modules": 195, "files of a package": 25}  # at most


def outer_imports(path):
    """First names of the modules that a Python file imports."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield (node.module or "").split(".")[0]


def test_the_library_needs_neither_scripts_nor_evidence():
    outside = {path.stem for folder in ("scripts", "evidence") for path in (ROOT / folder).rglob("*.py")}
    outside |= {"scripts", "evidence"} | {
        path.name for path in (ROOT / "evidence").iterdir() if path.is_dir()
    }
    for module in MODULES:
        assert not outside & set(outer_imports(LIBRARY / module)) - set(sys.stdlib_module_names), module


def sentences(path):
    """Strings of a Python file that read as a sentence with more than one clause; docstrings aside."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    told = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    errors = {id(part) for node in ast.walk(tree) if isinstance(node, ast.Raise) for part in ast.walk(node)}
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and not {id(node)} & (told | errors)
        ):
            words = re.findall(r"[A-Za-z]{2,}", node.value)
            if len(words) >= 12 and re.search(r"[,;:] [a-z]", node.value) and "<" not in node.value:
                yield node.lineno, node.value


def test_sentences_of_pages_stand_in_templates():
    for module in MODULES:
        if module.parts[0] == "report":
            assert not list(sentences(LIBRARY / module)), module


def test_the_house_has_the_size_that_one_can_see_through():
    files = {}
    for module in MODULES:
        files.setdefault(module.parent, []).append(module)
    assert len([module for module in MODULES if module.name != "__init__.py"]) <= SIZES["library, modules"]
    assert max(map(len, files.values())) <= SIZES["files of a package"]


def test_each_package_has_the_tests_in_the_folder_of_its_name():
    packages = {module.parts[0] for module in MODULES if len(module.parts) > 1}
    folders = {path.parent.name for path in (ROOT / "tests").glob("*/test_*.py")}
    assert packages <= folders and folders - packages <= {"docs", "evidence"}


def test_every_file_of_tests_has_a_name_of_its_own():
    names = [path.name for path in (ROOT / "tests").rglob("test_*.py")]
    assert len(names) == len({*names})


def test_every_name_that_is_imported_from_the_library_is_there():
    files = [*SCRIPTS, *(ROOT / "tests").rglob("*.py"), *(LIBRARY / module for module in MODULES)]
    for path in files:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "sparsurf":
                there = names_in(LIBRARY.parent.joinpath(*node.module.split(".")))
                missing = {alias.name for alias in node.names} - there
                assert not missing, f"{path.relative_to(ROOT)} imports {missing} from {node.module}"


@cache
def names_in(module):
    """What can be imported from a module or a package: names of its top level, modules of its folder."""
    file = module.with_suffix(".py") if module.with_suffix(".py").is_file() else module / "__init__.py"
    found = {each.stem for each in module.glob("*.py")} | {each.name for each in module.glob("*/")}
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            found.add(node.name)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            found |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
    return found


def test_no_two_modules_import_each_other():
    imports = {module: imported(LIBRARY / module, for_hints=False) - {module} for module in MODULES}
    while imports:
        free = [module for module, needs in imports.items() if not needs & imports.keys()]
        assert free, f"a circle among {', '.join(map(str, imports))}"
        imports = {module: needs for module, needs in imports.items() if module not in free}


def test_zernike_knows_nothing_of_proteins():
    for module in MODULES:
        if module.parts[:2] == ("patches", "zernike"):
            known = {("bits.py",), ("patches", "zernike")}
            assert {other.parts[:2] for other in imported(LIBRARY / module)} <= known


@pytest.mark.parametrize("path", [*SCRIPTS, *(LIBRARY / module for module in MODULES)], ids=str)
def test_every_file_and_public_function_says_what_it_is(path):
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), path
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
            assert ast.get_docstring(node), f"{path.name}: {node.name}"


def test_docstrings_refer_to_functions_that_exist():
    """`tables.ranges_table` in a docstring: some module tables.py holds that name."""
    texts: dict[str, str] = {}
    for module in MODULES:
        stem = module.parent.name if module.stem == "__init__" else module.stem
        texts[stem] = texts.get(stem, "") + (LIBRARY / module).read_text()
    for path in [*SCRIPTS, *(LIBRARY / module for module in MODULES)]:
        for reference in re.findall(r"(?<!`)`([a-z_.]+)\.(\w+)(?:\(\))?`(?!`)", path.read_text()):
            module, name = reference[0].rpartition(".")[2], reference[1]
            if module in texts and name not in texts:  # else `package.module`
                assert re.search(rf"\b{name}\b", texts[module]), f"{path.name}: {module}.{name}"


@pytest.mark.parametrize(
    "path",
    [path for path in SCRIPTS if path.name not in ("study.py", "close_partial_run.py")],
    ids=lambda path: path.name,
)
def test_a_script_is_one_verb(path):
    tree = ast.parse(path.read_text())
    public = [
        node.name for node in tree.body if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
    ]
    assert public[0] == "main" or "main" in public
    last = tree.body[-1]
    assert isinstance(last, ast.If) and ast.unparse(last.test) == "__name__ == '__main__'"


def test_conda_and_pip_name_the_same_versions():
    text = (ROOT / "envs" / "requirements.txt").read_text()
    lock = set(re.findall(r"^([a-z0-9_.-]+==[0-9]+\.[0-9]+(?:\.[0-9]+)?)", text, re.M))
    for line in yaml.safe_load((ROOT / "envs" / "study.yaml").read_text())["dependencies"]:
        name, version = line.split("=", 1)
        if name != "python":
            assert f"{'tables' if name == 'pytables' else name}=={version}" in lock, line


def test_results_are_not_committed_and_no_file_is_huge():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("no git checkout")
    files = [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).is_file()]
    assert [f.name for f in files if f.parent.name == "results"] == ["README.md"]
    assert max(f.stat().st_size for f in files) < 5_000_000


def test_every_section_of_the_config_is_in_the_default_config():
    text = (ROOT / "config.yaml").read_text()
    for key in Config.model_fields:
        assert key in text or key == "paper", key


def test_reading_a_config_imports_nothing_heavy():
    """Every start of snakemake pays for what these import; numpy and pandas take longer than all the rest."""
    modules = [path.stem for path in (LIBRARY / "workflow").glob("*.py") if path.stem != "__init__"]
    code = f"import sys, {', '.join(f'sparsurf.workflow.{name}' for name in sorted(modules))}; "
    code += "print(*{'numpy', 'pandas', 'scipy', 'matplotlib', 'numba'} & set(sys.modules))"
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=LIBRARY.parent, capture_output=True, text=True, check=True
    )
    assert run.stdout == "\n"


def test_no_kernel_lets_the_compiler_change_a_result():
    """Reordered sums, fused products and products with an inverse differ from one compilation and processor to the next."""
    for module in MODULES:
        text = (LIBRARY / module).read_text(encoding="utf-8")
        assert not re.search(r"fastmath=True|\"(reassoc|contract|arcp|afn|fast)\"", text), module
