"""The house itself: which way imports point, where arithmetic lives, what is written down once."""

import ast
import re
import subprocess

import pytest
import yaml

from conftest import ROOT

LIBRARY = ROOT / "scripts" / "sparsurf"
# A module may import only modules that stand before it.
ORDER = [
    *("__init__", "parallel"),
    *("residues", "radii", "isolated", "atoms", "pdb", "mmcif", "selection", "trajectory", "whole"),
    *("molecule", "structure", "frames"),
    *("vectors", "analytic", "areas", "surface", "exports", "placement"),
    *(
        "patches",
        "dots",
        "roughness",
        "sampling",
        "samplers",
        "zernike",
        "images",
        "descriptors",
        "evaluation",
    ),
    *("tables", "paper", "verdict", "minimal", "relation", "summary", "ensemble"),
    *("comparison", "comparison_tables", "comparison_text", "comparison_summary"),
    *("page", "render", "grid_figures", "figures", "comparison_figure", "summary_figures", "recommendation"),
    *("download", "listing", "config", "workflow", "timing"),
]
SCRIPTS = sorted((ROOT / "scripts").glob("*.py"))
RUN_BY_HAND = {"study.py", "bench.py", "recommend.py"}


def imported(path):
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module == "sparsurf":
            names |= {alias.name for alias in node.names if (LIBRARY / f"{alias.name}.py").is_file()}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("sparsurf."):
            names.add(node.module.removeprefix("sparsurf."))
    return names


def test_every_module_has_its_place():
    assert {path.stem for path in LIBRARY.glob("*.py")} == set(ORDER)


@pytest.mark.parametrize("module", ORDER)
def test_imports_point_one_way(module):
    above = set(ORDER[: ORDER.index(module)])
    assert imported(LIBRARY / f"{module}.py") <= above


def test_zernike_knows_nothing_of_proteins():
    assert not imported(LIBRARY / "zernike.py")


@pytest.mark.parametrize("path", [*SCRIPTS, *sorted(LIBRARY.glob("*.py"))], ids=lambda path: path.name)
def test_every_file_and_public_function_says_what_it_is(path):
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), path.name
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
            assert ast.get_docstring(node), f"{path.name}: {node.name}"


@pytest.mark.parametrize(
    "path", [path for path in SCRIPTS if path.name not in RUN_BY_HAND], ids=lambda path: path.name
)
def test_a_script_is_one_verb(path):
    tree = ast.parse(path.read_text())
    public = [
        node.name for node in tree.body if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
    ]
    assert public[0] == "main" or "main" in public
    last = tree.body[-1]
    assert isinstance(last, ast.If) and ast.unparse(last.test) == "__name__ == '__main__'"
    assert f"scripts/{path.name}" in (ROOT / "Snakefile").read_text(), "no rule runs this script"


def test_every_rule_names_the_code_it_depends_on():
    text = (ROOT / "Snakefile").read_text()
    for script in re.findall(r'script:\s+"scripts/(\w+\.py)"', text):
        assert f'code=digest("{script}")' in text, script


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


def test_every_parameter_of_the_config_reaches_the_readme_of_outputs_or_config():
    schema = yaml.safe_load((ROOT / "scripts" / "config.schema.yaml").read_text())
    text = (ROOT / "config.yaml").read_text()
    for key in schema["properties"]:
        assert key in text or key == "paper", key
