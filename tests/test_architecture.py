"""Rules of the repository that no linter knows; which way imports point: `lint-imports`, in pyproject.toml."""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

import sparsurf
from conftest import ROOT
from sparsurf_study.config.models import Config

SOURCES = ROOT / "src"
# A variable is called by what it holds, and these words hold nothing
FUNCTION_WORDS = {
    *("asked", "at", "beside", "both", "by", "each", "enough", "it", "known", "many", "more", "most", "of", "on", "one"),
    *("others", "own", "rest", "said", "same", "some", "there", "what", "which", "words"),
}  # fmt: skip
# Arguments of exported functions keep the name that users type
NAMED_BY_USERS = {"src/sparsurf/api/patches.py at", "src/sparsurf/arguments.py words"}


def test_conda_and_pip_name_the_same_versions_and_the_package_of_these_rules():
    text = (ROOT / "envs" / "requirements.txt").read_text()
    lock = set(re.findall(r"^([a-z0-9_.-]+==[0-9]+\.[0-9]+(?:\.[0-9]+)?)", text, re.M))
    *lines, pip = yaml.safe_load((ROOT / "envs" / "study.yaml").read_text())["dependencies"]
    assert pip == {"pip": [f"sparsurf=={sparsurf.__version__}"]} and lines.pop() == "pip"
    for line in lines:
        name, version = line.split("=", 1)
        if name != "python":
            assert f"{'tables' if name == 'pytables' else name}=={version}" in lock, line


@pytest.fixture(scope="module")
def files():
    """The files of the repository."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("no git checkout")
    return [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).is_file()]


def test_the_tree_of_contributing_has_every_folder_and_package(files):
    (tree,) = re.findall(r"^```\n(Snakefile.*?)^```", (ROOT / "CONTRIBUTING.md").read_text(), re.M | re.S)
    begins = re.findall(r"^ *((?:\S+/ +)+)", tree, re.M)
    names = {name.rstrip("/") for begin in begins for name in begin.split()}
    parts = [file.relative_to(ROOT).parts[:-1] for file in files]
    packages = {folders[2] for folders in parts if folders[:1] == ("src",) and len(folders) > 2}
    folders = {"/".join(folders[: 2 if folders[0] == "src" else 1]) for folders in parts if folders}
    assert names >= folders | packages, folders | packages - names
    places = [ROOT / place for place in ("", "src/sparsurf", "src/sparsurf_study")]
    assert not [name for name in names if not any((place / name).is_dir() for place in places)]


def test_results_are_not_committed_and_no_file_is_huge(files):
    assert [f.name for f in files if f.parent.name == "results"] == ["README.md"]
    assert max(f.stat().st_size for f in files) < 5_000_000


def test_every_section_of_the_config_is_in_the_default_config():
    text = (ROOT / "config.yaml").read_text()
    for key in Config.model_fields:
        assert re.search(rf"^(# ?)?{key}:", text, re.MULTILINE) or key == "paper", key


def test_reading_a_config_imports_nothing_heavy():
    """Every start of snakemake pays for what these import; numpy and pandas take longer than all the rest."""
    modules = [
        f"sparsurf_study.{name}.{path.stem}"
        for name in ("config", "workflow")
        for path in (SOURCES / "sparsurf_study" / name).glob("*.py")
        if path.stem != "__init__"
    ]
    code = f"import sys, {', '.join(sorted(modules))}; "
    code += "print(*{'numpy', 'pandas', 'scipy', 'matplotlib', 'numba'} & set(sys.modules))"
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=SOURCES, capture_output=True, text=True, check=True
    )
    assert run.stdout == "\n"


@pytest.mark.parametrize(
    ("start", "heavy"),
    [
        (
            "sparsurf.cli.command show {molecule} --no-open -o {out}.html",
            "scipy.spatial scipy.special matplotlib",
        ),
        (
            "sparsurf.cli.msms -if {spheres} -of {out}",
            "scipy.spatial pandas pydantic sparsurf.molecules.build",
        ),
    ],
)
def test_a_command_loads_nothing_heavy_that_it_does_not_need(start, heavy, tmp_path):
    """Each takes a tenth of a second, and what these commands compute is done after one."""
    spheres = tmp_path / "few.xyzr"
    spheres.write_text("0 0 0 1.7\n3 0 0 1.7\n0 3 0 1.5\n")
    molecule = ROOT / "data" / "tdp43" / "topology.pdb"
    module, *words = start.format(molecule=molecule, spheres=spheres, out=tmp_path / "out").split()
    code = f"import sys; from {module} import main; main({words}); print(*{set(heavy.split())} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.endswith("\n\n") or run.stdout == "\n", run.stdout


def test_no_kernel_lets_the_compiler_change_a_result():
    """Reordered sums, fused products and products with an inverse differ from one compilation and processor to the next."""
    for path in SOURCES.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"fastmath=True|\"(reassoc|contract|arcp|afn|fast)\"", text), path


def variables_of(path: Path) -> Iterator[tuple[int, str]]:
    """The line and the name of every variable and argument that a file assigns."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg


def test_no_variable_is_called_by_a_function_word():
    found = []
    for path in [*SOURCES.rglob("*.py"), *(ROOT / "scripts").glob("*.py")]:
        file = path.relative_to(ROOT).as_posix()
        for line, name in variables_of(path):
            if name in FUNCTION_WORDS and f"{file} {name}" not in NAMED_BY_USERS:
                found.append(f"{file}:{line} {name}")
    assert found == []
