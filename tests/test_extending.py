"""Every recipe of docs/extending.md, carried out on a small surface."""

import re
import types

import numpy as np
import pandas as pd
import pytest
import yaml

from conftest import ROOT
from sparsurf.patches import descriptors, roughness
from sparsurf.patches.index import build_index
from sparsurf.patches.islands import patch
from sparsurf.report.figures.results import Results
from sparsurf.sampling import samplers
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.minimal import minimal_subset
from sparsurf.surfaces import reading
from sparsurf.surfaces.surface import Surface

TEXT = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
RECIPES = dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", TEXT, re.M | re.S))
SCHEMA = yaml.safe_load((ROOT / "scripts/sparsurf/workflow/config.schema.yaml").read_text(encoding="utf-8"))


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


@pytest.mark.parametrize("recipe", RECIPES)
def test_a_recipe_is_short_and_names_files_that_are_there(recipe):
    lines = [line for line in RECIPES[recipe].splitlines() if line and not line.startswith("```")]
    assert len(lines) <= 15
    for path in re.findall(r"`(scripts/[\w./]+)`", RECIPES[recipe]):
        new = re.search(rf"file `{re.escape(path)}`|caption.*\s`{re.escape(path)}`", RECIPES[recipe])
        assert (ROOT / path).is_file() != bool(new), path


def test_a_sampler(surface, monkeypatch):
    monkeypatch.setattr(samplers, "SAMPLERS", dict(samplers.SAMPLERS))
    carried_out("A sampler", sampler=samplers.sampler, np=np)
    assert SCHEMA["$defs"]["sampler"]["enum"]
    assert samplers.called("highest")[1:] == ("highest dots", "highest", True, False)
    evaluator = Evaluator(surface)
    dots, weight = minimal_subset(evaluator, "highest", 10)
    assert sorted(dots) == sorted(np.argsort(surface.points[:, 2])[-10:]) and weight.sum() == 800
    assert np.array_equal(minimal_subset(evaluator, "highest", 4)[0], dots[:4])  # nested


def test_a_roughness(surface, monkeypatch):
    monkeypatch.setattr(roughness, "ROUGHNESS", dict(roughness.ROUGHNESS))
    carried_out("A roughness", registered=roughness.registered, np=np, patch=patch)
    assert (
        SCHEMA["properties"]["patches"]["properties"]["roughness"]["enum"] == list(roughness.ROUGHNESS)[:-1]
    )
    index = build_index(surface.points, surface.normals, 0.9)
    values = roughness.roughness(index, 4.0, kind="steepest")
    own = surface.normals[patch(index, 7, 4.0)] @ surface.normals[7]
    assert values[7] == pytest.approx(max(0.0, own.min()), abs=1e-12)
    evaluator = Evaluator(surface, d_link=0.9, kind="steepest")
    np.testing.assert_array_equal(evaluator.roughness, values)


def test_a_figure(surface):
    draw = carried_out("A figure").draw
    grid = pd.DataFrame({"n_S_percent": np.linspace(1, 100, 50)})
    figure = draw(Results(surface, None, grid, {}, [], {}))
    assert sum(bar.get_height() for bar in figure.axes[0].patches) == 50
    assert re.search(r"^FIGURES = \{", (ROOT / "Snakefile").read_text(), re.M)


def test_a_surface_format(surface, tmp_path, monkeypatch):
    monkeypatch.setattr(reading, "FORMATS", (*reading.FORMATS, carried_out("A surface format").FORMAT))
    path = tmp_path / "dots.xyzn"
    np.savetxt(path, np.hstack([surface.points, surface.normals]), fmt="%.9f")
    back = reading.read_surface(path)
    np.testing.assert_allclose(back.points, surface.points, atol=1e-8)
    np.testing.assert_allclose(back.normals, surface.normals, atol=1e-8)


def test_a_descriptor(surface, monkeypatch):
    extent = carried_out("A descriptor")
    line = re.search(r'"extent": (Descriptor\(.*\))`', RECIPES["A descriptor"]).group(1)
    entry = eval(line, {"Descriptor": descriptors.Descriptor, "extent": extent, "np": np})
    monkeypatch.setitem(descriptors.DESCRIPTORS, "extent", entry)
    enum = SCHEMA["properties"]["patches"]["properties"]["descriptor"]["enum"]
    assert enum == [name for name in descriptors.DESCRIPTORS if name != "extent"]
    evaluator = Evaluator(surface, d_link=0.9, descriptor="extent")
    z, _ = evaluator.describe(np.array([3, 400]))
    ids = patch(evaluator.index, 3, 6.0)
    far = np.linalg.norm(surface.points[ids] - surface.points[3], axis=1).mean()
    np.testing.assert_allclose(z[0], [len(ids), far], rtol=1e-12)
