"""Every recipe of docs/extending.md, carried out on a small surface."""

import os
import re
import shutil
import subprocess
import sys
import types

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT
from small_study import output, snakemake
from sparsurf import settings
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.subset_search import find_subset
from sparsurf.patches import descriptors, roughness
from sparsurf.patches.index import build_index
from sparsurf.patches.islands import patch
from sparsurf.sampling import samplers
from sparsurf.surfaces import read_surface as surface_files
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.surface import Surface
from sparsurf_study.report.figures.results import Results

TEXT = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
RECIPES = dict(re.findall(r"^## (An? .*?)\n(.*?)(?=^## |\Z)", TEXT, re.M | re.S))


@pytest.fixture
def surface(blob):
    """A few dots of the bumpy surface."""
    points, normals = blob
    return Surface(points[:800], normals[:800])


def carried_out(recipe, **names):
    """The module that the code of a recipe makes, with the names that its place in the library has."""
    module = types.ModuleType("recipe")
    vars(module).update(names)
    exec(re.search(r"```python\n(.*?)```", RECIPES[recipe], re.S).group(1), vars(module))
    return module


@pytest.fixture
def checkout(tmp_path):
    """The library and the files that `make schema` reads and writes, to be changed."""
    shutil.copytree(
        ROOT / "src" / "sparsurf", tmp_path / "src" / "sparsurf", ignore=shutil.ignore_patterns("__pycache__")
    )
    for name in ("config.yaml", "config/schema.json", "docs/config.md"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def replace_once(path, old, new):
    """Change the one place of a file that matches a regular expression."""
    text, n = re.subn(old, new, path.read_text(encoding="utf-8"), flags=re.M)
    assert n == 1, f"{path}: {old}"
    path.write_text(text, encoding="utf-8")


def printed(checkout, *arguments):
    """What Python prints with the changed library."""
    environment = os.environ | {
        "PYTHONPATH": str(checkout / "src"),
        "NUMBA_DISABLE_JIT": "1",
    }  # slower to compile
    done = subprocess.run(
        [sys.executable, *arguments], cwd=checkout, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("recipe", RECIPES)
def test_a_recipe_is_short_and_names_files_that_are_there(recipe):
    lines = [line for line in RECIPES[recipe].splitlines() if line and not line.startswith("```")]
    assert len(lines) <= 15
    for path in re.findall(r"`(scripts/[\w./]+)`", RECIPES[recipe]):
        new = re.search(rf"file `{re.escape(path)}`|caption.*\s`{re.escape(path)}`", RECIPES[recipe])
        assert (ROOT / path).is_file() != bool(new), path


@pytest.mark.parametrize("recipe", ["A sampler", "A roughness", "A descriptor"])
def test_a_recipe_adds_its_name_to_those_of_the_config(recipe):
    name = re.search(r"`(\w+)` of\s`src/sparsurf/settings.py`", RECIPES[recipe])[1]
    assert name == recipe.split()[1].capitalize() and hasattr(settings, name)


def with_patches(**added):
    """Settings with names that a recipe adds to `settings.py`, which checks them in vain here."""
    patches = settings.Settings().patches.model_copy(update={"d_link": 0.9, **added})
    return settings.Settings().model_copy(update={"patches": patches})


def test_a_sampler(surface, monkeypatch):
    monkeypatch.setattr(samplers, "SAMPLERS", dict(samplers.SAMPLERS))
    carried_out("A sampler", sampler=samplers.sampler, np=np)
    assert samplers.SAMPLERS["highest"][1:] == ("highest dots", True, False)
    prepared = PreparedSurface(surface)
    dots, weight = find_subset(prepared, "highest", 10)
    assert sorted(dots) == sorted(np.argsort(surface.points[:, 2])[-10:]) and weight.sum() == 800
    assert np.array_equal(find_subset(prepared, "highest", 4)[0], dots[:4])  # nested


def test_a_roughness(surface, monkeypatch):
    monkeypatch.setattr(roughness, "ROUGHNESS", dict(roughness.ROUGHNESS))
    carried_out("A roughness", registered=roughness.registered, np=np, patch=patch)
    index = build_index(surface.points, surface.normals, 0.9)
    values = roughness.roughness(index, 4.0, roughness_kind="steepest")
    own = surface.normals[patch(index, 7, 4.0)] @ surface.normals[7]
    assert values[7] == pytest.approx(max(0.0, own.min()), abs=1e-12)
    prepared = PreparedSurface(surface, with_patches(roughness="steepest"))
    np.testing.assert_array_equal(prepared.roughness, values)


def test_a_figure(surface):
    draw = carried_out("A figure").draw
    grid = pd.DataFrame({"n_S_percent": np.linspace(1, 100, 50)})
    figure = draw(Results("p/c1", surface, grid=grid))
    assert sum(bar.get_height() for bar in figure.axes[0].patches) == 50


def test_a_surface_format(surface, tmp_path, monkeypatch):
    monkeypatch.setattr(
        surface_files, "FORMATS", (*surface_files.FORMATS, carried_out("A surface format").FORMAT)
    )
    path = tmp_path / "dots.xyzn"
    np.savetxt(path, np.hstack([surface.points, surface.normals]), fmt="%.9f")
    back = surface_files.read_surface(path)
    np.testing.assert_allclose(back.points, surface.points, atol=1e-8)
    np.testing.assert_allclose(back.normals, surface.normals, atol=1e-8)


def test_a_descriptor(surface, monkeypatch):
    extent = carried_out("A descriptor")
    line = re.search(r'"extent": (Descriptor\(.*\))`', RECIPES["A descriptor"]).group(1)
    entry = eval(line, {"Descriptor": descriptors.Descriptor, "extent": extent, "np": np})
    monkeypatch.setitem(descriptors.DESCRIPTORS, "extent", entry)
    prepared = PreparedSurface(surface, with_patches(descriptor="extent"))
    z, _ = prepared.describe(np.array([3, 400]))
    ids = patch(prepared.index, 3, 6.0)
    far = np.linalg.norm(surface.points[ids] - surface.points[3], axis=1).mean()
    np.testing.assert_allclose(z[0], [len(ids), far], rtol=1e-12)


def test_a_column(checkout):
    """The table has it, and so has the list of all columns, for a study in batches, too."""
    line, meaning = re.findall(r"```(?:text|python)\n(.*?)\n```", RECIPES["A column"], re.S)
    library = checkout / "src" / "sparsurf"
    replace_once(library / "study" / "residues.py", r'^    table\["dots"\] = .*$', rf"\g<0>\n    {line}")
    replace_once(
        library / "columns.yaml",
        r"^      - dots: .int, dots, its dots.\n(?=      - (?:\w+: .*\n      - )?cavity_dots)",
        rf"\g<0>      {meaning}\n",
    )
    replace_once(
        library / "batches" / "tables.py", '^        "dots": INT,$', r'\g<0>\n        "heavy_atoms": INT,'
    )
    code = """
import sparsurf
from sparsurf_study import columns
from sparsurf_study.batches.tables import columns_of
molecule = sparsurf.read_molecule("topology.pdb", residues="209-210")
dots = sparsurf.surface(molecule)
table = sparsurf.residues(dots, molecule, roughness_values=[0.5] * len(dots))
listed = [column.name for column in columns.tables()["<protein>/<conformation>/residues.csv"].columns]
print(table["heavy_atoms"].tolist(), list(table) == [name for name in listed if "<" not in name] == [*columns_of("residues")][1:])
"""
    shutil.copy(ROOT / "data" / "tdp43" / "topology.pdb", checkout)
    assert printed(checkout, "-c", code) == "[9, 11] True\n"  # of GLU and PHE


def test_a_default(checkout):
    """Functions, the command line, a study without the key, the schema and the reference page have the new radius."""
    for key in re.findall(r"`(probe_radius|r_\w+)`", RECIPES["A default"]):
        replace_once(checkout / "src/sparsurf/settings.py", rf"^(    {key}: \w+ = key\()[\d.]+", r"\g<1>4.25")
        replace_once(checkout / "config.yaml", rf"^(  {key}: )[\d.]+", r"\g<1>4.25")
    printed(checkout, "-m", "sparsurf_study.workflow.config")
    assert (checkout / "config" / "schema.json").read_text(encoding="utf-8").count('"default": 4.25') == 3
    assert (checkout / "docs" / "config.md").read_text(encoding="utf-8").count("| `4.25` |") == 3
    code = """
import inspect, sparsurf
from sparsurf_study.workflow.config import check_config
from sparsurf.patches.index import R_ZERNIKE
checked = check_config({"proteins": {"a": {"pdb": "1ubi"}}})
print(checked["surface"]["probe_radius"], checked["patches"]["r_patch"], checked["patches"]["r_zernike"])
print(*(inspect.signature(call).parameters[name].default for call, name in (
    (sparsurf.surface, "probe_radius"), (sparsurf.roughness, "r_patch"), (sparsurf.descriptors, "r_zernike"))))
"""
    assert printed(checkout, "-c", code) == "4.25 4.25 4.25\n4.25 4.25 4.25\n"
    assert "(default 4.25)" in printed(checkout, "-m", "sparsurf", "surface", "--help")


def test_an_output(surface, tmp_path):
    """The rule names it, and the script writes it: then every run has it."""
    rule, lines = re.findall(r"```(?:text|python)\n(.*?)```", RECIPES["An output"], re.S)
    checkout = tmp_path / "checkout"
    checkout.mkdir()
    for name in ("src", "profiles", "envs", "scripts", "config.yaml", "rules"):
        (checkout / name).symlink_to(ROOT / name)
    text = (ROOT / "Snakefile").read_text(encoding="utf-8")
    place = """    output:
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
"""
    assert text.count(place) == 1
    (checkout / "Snakefile").write_text(text.replace(place, f"{place}        {rule}"), encoding="utf-8")
    write_npz(tmp_path / "dots.npz", surface)
    config = {"run": "r", "proteins": {"ready": {"surface": str(tmp_path / "dots.npz")}}}
    planned = snakemake(tmp_path / "w", config, "--dry-run", root=checkout)
    assert "results/r/ready/c1/histogram.csv" in planned.stdout, output(planned)
    s = types.SimpleNamespace(output=types.SimpleNamespace(histogram=tmp_path / "h.csv"))
    exec(lines, {"np": np, "pd": pd, "values": np.array([0.05, 0.15, 0.15]), "s": s})
    assert pd.read_csv(tmp_path / "h.csv")["dots"].to_list() == [1, 2, *[0] * 8]
