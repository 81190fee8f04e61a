"""The recipes of CONTRIBUTING.md, carried out to the letter in a copy of the tree, and then tested."""

import filecmp
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
import yaml

from conftest import ROOT
from peptides import peptide, write

TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
RECIPES = dict(re.findall(r"^## (An? .*?)\n(.*?)(?=^## |\Z)", TEXT, re.M | re.S))
BLOCK = r"\n\n```\w+\n(?P<block>.*?)```"
STEP = re.compile(
    rf"^New file `(?P<new>[^`]+)`:{BLOCK}"
    rf"|^At the end of `(?P<end>[^`]+)`:{BLOCK.replace('block', 'last')}"
    rf"|^In (?:the rule `(?P<rule>\w+)` of )?`(?P<path>[^`]+)`, (?P<side>after|before) `(?P<line>[^\n]+)`:"
    rf"{BLOCK.replace('block', 'inner')}"
    r"|^In `(?P<file>[^`]+)`, replace `(?P<old>[^\n]+)` by `(?P<by>[^\n]+)`\.$",
    re.M | re.S,
)
COPIED = (
    "src",
    "scripts",
    "rules",
    "tests",
    "config",
    "docs",
    "results/README.md",
    "config.yaml",
    "Snakefile",
    "CONTRIBUTING.md",
)
LINKED = ("data", "envs", "profiles", "studies", "pyproject.toml", "evidence", "README.md", "CHANGELOG.md")
STRUCTURE = ("ALA", "LEU", "LYS", "GLY", "SER", "VAL")
# Snakemake, whose jobs are forks of a Python that has imported the packages of the tree
WARM = """
import subprocess, sys
sys.path.append(sys.argv[1])
import warm_python
sys.exit(subprocess.run([warm_python.interpreter(), "-m", "snakemake", *sys.argv[2:]]).returncode)
"""


def copy_tree(folder):
    """Copy what a recipe edits, with its compiled kernels, and link the rest."""
    for name in COPIED:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
        extra = (
            {"ignore": shutil.ignore_patterns("_build", "_gallery", "baseline", "corpus")}
            if copy is shutil.copytree
            else {"follow_symlinks": False}
        )
        copy(ROOT / name, folder / name, **extra)
    for name in LINKED:
        (folder / name).symlink_to(ROOT / name)
    return folder


def carry_out(recipe, tree):
    """Do what a recipe says in a copy of the tree; every step must find its one place."""
    steps = [*STEP.finditer(RECIPES[recipe])]
    assert len(steps) == len(
        re.findall(r"^(?:New file|At the end|In (?:the rule )?`[^`]+`)", RECIPES[recipe], re.M)
    ), recipe
    for step in steps:
        if step["new"]:
            assert not (tree / step["new"]).exists()
            (tree / step["new"]).write_text(step["block"], encoding="utf-8")
            continue
        path = tree / (step["end"] or step["path"] or step["file"])
        text = path.read_text(encoding="utf-8")
        if step["end"]:
            text += ("\n\n" if path.parent.name != "scripts" else "") + step["last"]
        elif step["file"]:
            assert text.count(step["old"]) == 1, (
                f"{recipe}: {step['old']} stands {text.count(step['old'])} times in {path}"
            )
            text = text.replace(step["old"], step["by"])
        else:
            lines = text.splitlines(keepends=True)
            begin = lines.index(f"rule {step['rule']}:\n") if step["rule"] else 0
            found = [k for k, line in enumerate(lines) if k >= begin and line.startswith(step["line"])]
            found = found[:1] if step["rule"] else found
            assert len(found) == 1, f"{recipe}: {step['line']} begins {len(found)} lines of {path}"
            lines.insert(found[0] + (step["side"] == "after"), step["inner"])
            text = "".join(lines)
        path.write_text(text, encoding="utf-8")


def make_schema(tree):
    """Write the schema of the config and the pages that follow from the code."""
    call(tree, "docs/config_reference.py")
    call(tree, "docs/renew.py")


def call(tree, *arguments):
    """Run Python with the packages of a tree; return what it prints."""
    environment = os.environ | {"PYTHONPATH": str(tree / "src"), "OPENBLAS_NUM_THREADS": "1"}
    # The tests in it share no folder with those of other workers
    environment.pop("PYTEST_XDIST_WORKER", None)
    command = [sys.executable, *map(str, arguments)]
    done = subprocess.run(command, cwd=tree, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


@pytest.fixture(scope="module")
def edited(tmp_path_factory):
    """A copy of the tree with the edits of all recipes but that of a default."""
    tree = copy_tree(tmp_path_factory.mktemp("extended"))
    for recipe in RECIPES:
        if recipe != "A default":
            carry_out(recipe, tree)
    return tree


@pytest.fixture(scope="module")
def extended(edited):
    """The same after `make schema`, with which most recipes end."""
    make_schema(edited)
    return edited


@pytest.fixture(scope="module")
def results(extended, tmp_path_factory):
    """Folder of a conformation in a study that uses what the recipes added."""
    folder = tmp_path_factory.mktemp("study")
    write(folder / "protein.pdb", peptide(STRUCTURE) + "END\n")
    config = {
        "run": "own",
        "proteins": {"p": {"structure": "protein.pdb"}},
        "patches": {"roughness": "steepest", "descriptor": "extent"},
        "fields": ["from_centre"],
        "minimal": {"sampler": "highest", "percent": 10},
        "sampling": {"alpha": [0.5, 1.0], "beta": [0.0], "gamma": [0, 6], "delta": [0]},
        "evaluation": {"test_dots": 20, "draws": 2},
        "tables": {"ranges": 2, "smallest_area": 70.0},
    }
    (folder / "config.yaml").write_text(yaml.safe_dump(config))
    where = ["--snakefile", extended / "Snakefile", "--directory", folder]
    options = [*where, "--configfile", folder / "config.yaml", "--cores", "2"]
    call(extended, "-c", WARM, extended / "tests", *options)
    return folder / "results" / "own" / "p" / "c1"


def test_every_recipe_has_steps_that_can_be_followed():
    assert RECIPES.keys() >= {
        "A sampler", "A roughness", "A descriptor", "A field", "A surface format",
        "A column", "A figure", "A key of the config", "A default", "An output", "A rule",
    }  # fmt: skip
    assert all(STEP.search(text) for text in RECIPES.values())


def test_the_code_of_the_recipes_uses_what_there_is(edited):
    """Not slow, so that whoever renames something in the library learns of a recipe that uses it."""
    code = """
from sparsurf import registry
from sparsurf_study.report.figures import sizes
names = {"sampler": "highest", "roughness": "steepest", "descriptor": "extent", "field": "from_centre", "format": "xyzn"}
print(*(registry.load(kind, name, kind)[0].label for kind, name in names.items()), sep=",")
"""
    assert call(edited, "-c", code) == "highest dots,steepest slope,extent,distance from the centre,XYZN\n"


@pytest.mark.parametrize(
    ("recipe", "n_files"), [("A figure", 3), ("An output", 3), ("A rule", 3), ("A column", 2)]
)
def test_what_a_recipe_adds_to_the_outputs_is_said_in_few_files(recipe, n_files):
    steps = STEP.finditer(RECIPES[recipe])
    assert len({step["new"] or step["end"] or step["path"] or step["file"] for step in steps}) == n_files


@pytest.mark.release
def test_what_the_registries_touch_passes_after_the_recipes(extended):
    """The suites of samplers, descriptors, options, residues, the config, the catalogue, and the rules of the repository.

    Those that need a whole run are left out, since the fixture `results` is one, and one that gives a script its parameters
    by hand, of which the recipe of a key adds one.
    """
    files = (
        "library/test_registry.py", "library/sampling/test_samplers.py", "library/patches/test_descriptors.py",
        "library/cli/test_options.py",
        "study/test_columns.py", "study/workflow/test_config.py", "test_architecture.py", "docs/test_table_numbers.py",
        "library/evaluation/test_residues.py", "study/test_catalogue.py",
        "study/workflow/test_consequences.py::test_every_key_of_the_config_has_its_consequences",
    )  # fmt: skip
    paths = [f"tests/{name}" for name in files]
    left_out = "of_a_run or browser or damaged or commit or file_of_the_repository or buried"
    # which compare the results of options and descriptors that no recipe changes, and take half of the time
    left_out += " or is_that_of_the_function or is_that_argument_of_the_function or the_plain_method"
    chosen = f"not ({left_out})"
    said = call(extended, "-m", "pytest", "-x", *paths, "-k", chosen)
    assert int(re.search(r"(\d+) passed", said)[1]) > 150
    if (ROOT / ".mypy_cache").is_dir():  # of `make test`
        shutil.copytree(ROOT / ".mypy_cache", extended / ".mypy_cache")
    sources = [
        path.relative_to(extended) for name in ("src", "scripts") for path in (extended / name).rglob("*.py")
    ]
    edited = [
        path
        for path in sources
        if not (ROOT / path).is_file() or not filecmp.cmp(ROOT / path, extended / path, False)
    ]
    assert len(edited) > 8
    call(extended, "-m", "mypy", *edited)


def test_a_choice_takes_two_files():
    for recipe in ("A sampler", "A roughness", "A descriptor", "A field", "A surface format"):
        files = {
            step["new"] or step["end"] or step["path"] or step["file"]
            for step in STEP.finditer(RECIPES[recipe])
        }
        assert len(files) == 2 and "src/sparsurf/registry.py" in files, recipe


@pytest.mark.release
def test_the_field_is_at_every_kept_dot(results):
    table = pd.read_csv(results / "minimal.csv")
    surface = np.load(results / "surface.npz")
    assert table["from_centre"].between(0, np.ptp(surface["points"], axis=0).max()).all()
    assert table["from_centre"].std() > 0.1


@pytest.mark.release
def test_the_tables_of_batches_have_the_column(extended):
    code = "from sparsurf_study.batches.tables import columns_of_batch; print(columns_of_batch('residues')['heavy_atoms'])"
    assert call(extended, "-c", code) == "int32\n"


@pytest.mark.release
def test_the_roughness_the_sampler_and_the_descriptor_are_those_of_the_recipes(results):
    with np.load(results / "surface.npz") as dots:
        points, normals = dots["points"], dots["normals"]
    rough = pd.read_csv(results / "roughness.csv")["roughness"]
    assert (
        rough.min() == 0 and 0 < rough.max() <= 1
    )  # smallest cosines, 0 where a patch turns by a right angle
    minimal = pd.read_csv(results / "minimal.csv")
    n = round(len(points) / 10)
    assert sorted(minimal["dot"]) == sorted(np.argsort(-points[:, 2], kind="stable")[:n])
    with np.load(results / "distances.npz") as grid:
        sizes = grid["z_tot"][:, 0]
    assert grid and (sizes == sizes.round()).all() and sizes.min() > 1  # numbers of dots of patches
    assert normals.shape == points.shape


@pytest.mark.release
def test_the_command_tabulates_the_descriptor_of_the_recipe(extended, tmp_path):
    """Its width differs from that of the moments."""
    pdb = write(tmp_path / "protein.pdb", peptide(STRUCTURE) + "END\n")
    call(
        extended,
        "-m",
        "sparsurf",
        "descriptors",
        pdb,
        "--at",
        "0,9",
        "--descriptor",
        "extent",
        "-o",
        tmp_path / "d.csv",
    )
    table = pd.read_csv(tmp_path / "d.csv")
    assert list(table) == ["dot", "x", "y", "z", "z_0", "z_1"] and (table["z_0"] > 1).all()


@pytest.mark.release
def test_the_column_the_figure_the_key_and_the_output_are_in_the_results(results):
    residues = pd.read_csv(results / "residues.csv")
    assert residues["area"].min() >= 70 and 0 < len(residues) < len(STRUCTURE)
    assert {*residues["heavy_atoms"]} <= set(range(4, 10))
    assert (results / "figures" / "sizes.png").stat().st_size > 1000
    roughest = pd.read_csv(results / "roughest.csv")
    roughness = pd.read_csv(results / "roughness.csv")["roughness"]
    assert roughest["roughness"].tolist() == roughness[roughest["dot"]].tolist() == sorted(roughness)[:10]
    assert pd.read_csv(results / "sizes.csv")["dots"].sum() == len(pd.read_csv(results / "roughness.csv"))
    page = (results.parents[1] / "index.html").read_text(encoding="utf-8")
    assert "combinations keep." in page


@pytest.mark.release
def test_a_surface_format_is_read(extended, tmp_path):
    dots = np.random.default_rng(0).normal(size=(200, 3))
    dots /= np.linalg.norm(dots, axis=1, keepdims=True)
    np.savetxt(tmp_path / "dots.xyzn", np.hstack([5 * dots, dots]), fmt="%.9f")
    code = "import sparsurf, sys; s = sparsurf.read_surface(sys.argv[1]); print(len(s), (s.points * s.normals).sum().round(3))"
    assert call(extended, "-c", code, tmp_path / "dots.xyzn") == "200 1000.0\n"


@pytest.mark.release
def test_a_default_is_that_of_functions_commands_and_the_config(tmp_path):
    tree = copy_tree(tmp_path)
    carry_out("A default", tree)
    make_schema(tree)
    assert (tree / "docs" / "reference" / "config.md").read_text(encoding="utf-8").count("| `4.25` |") == 1
    code = """
import inspect, sparsurf
from sparsurf_study.config.check import check_config
print(check_config({"proteins": {"a": {"pdb": "1ubi"}}})["patches"]["r_patch"])
print(*(inspect.signature(call).parameters["r_patch"].default for call in (sparsurf.roughness, sparsurf.prepare)))
"""
    assert call(tree, "-c", code) == "4.25\n4.25 4.25\n"
    # not of a run, which would compile every kernel for another radius
    call(tree, "-m", "pytest", "-q", "-x", "tests/study/workflow/test_config.py", "-k", "not of_a_run")
