"""Scripts that no other test calls by itself: what they hand on, and what their tables hold."""

import ast
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import take_all_steps
from noted import noted

import choose_frames
import draw_ensemble
import fetch_structure
import follow_ensemble
import follow_frames
import prepare_system
import simulate_stage
from conftest import ROOT
from peptides import peptide, write
from small_study import SMALL
from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.report.figures import layout
from sparsurf.simulation.protocol import DEFAULTS
from sparsurf.streams import stream
from sparsurf.workflow.config import check

SCRIPTS = sorted((ROOT / "scripts").glob("*.py"))
SEQUENCE = ("ALA", "LEU", "LYS", "GLY")


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_no_table_begins_with_the_numbers_of_its_rows(path):
    calls = [each for each in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(each, ast.Call)]
    written = [each for each in calls if isinstance(each.func, ast.Attribute) and each.func.attr == "to_csv"]
    named = [{key.arg: ast.unparse(key.value) for key in each.keywords} for each in written]
    assert all(keys.get("index") == "False" for keys in named)


def models(path, n):
    """A file of n models of a peptide whose last atoms stand elsewhere in each."""
    each = [peptide(SEQUENCE) + peptide(("VAL",), "B", origin=(0, 6 + k**2, 0.5 * k)) for k in range(n)]
    return write(path, "".join(f"MODEL {k + 1}\n{text}ENDMDL\n" for k, text in enumerate(each)) + "END\n")


def chosen(folder, inputs, options=None, **asked):
    """Names of the conformations that become of a molecule."""
    outputs = {name: folder / f"of_{name}" for name in ("frames", "silhouette", "projection", "explained")}
    settings = {"frames": check(SMALL)["frames"] | asked, "seed": 3}
    structures = {"structures": folder / "structures"}
    choose_frames.main(inputs, outputs | structures, options or {}, settings, "p")
    return pd.read_csv(outputs["frames"])["conformation"].to_list()


@pytest.mark.parametrize(
    ("n", "options", "asked", "names"),
    [
        (1, {}, {"use": [3]}, ["f0"]),  # frames are those of the trajectories beside it
        (1, {}, {"use": [3], "stride": 2}, ["f0"]),
        (1, {}, {"use": "clusters", "clusters": 3}, ["c1"]),
        (3, {"model": 2}, {"use": [7], "stride": 2}, ["f1"]),
        (2, {}, {"use": [1]}, ["f1"]),
        (2, {}, {"use": "all", "stride": 2}, ["f0"]),
        (5, {}, {"use": "clusters", "clusters": 2}, ["c1", "c2"]),
    ],
)
def test_of_a_single_structure_there_is_one_conformation(tmp_path, n, options, asked, names):
    structure = models(tmp_path / "m.pdb", n)
    assert chosen(tmp_path, {"structure": structure}, options, **asked) == names


@pytest.mark.parametrize(
    ("asked", "word"), [({"use": [1]}, "use"), ({"use": "clusters", "clusters": 3}, "clusters")]
)
def test_a_frame_that_a_stride_has_left_is_no_single_structure(tmp_path, asked, word):
    two = {"structure": models(tmp_path / "m.pdb", 2)}
    tdp43 = {key: SMALL["proteins"]["tdp43"][key] for key in ("structure", "trajectory")}
    for inputs, stride, options in ((two, 2, {}), (tdp43, 10**6, {"residues": "209-212"})):
        with pytest.raises(InputError, match=f"^frames.{word}: "):
            chosen(tmp_path, inputs, options, stride=stride, **asked)


def test_conformations_are_the_frames_that_are_named_in_the_tables(tmp_path):
    structure = models(tmp_path / "m.pdb", 5)
    assert chosen(tmp_path, {"structure": structure}, use="all", stride=2) == ["f0", "f2", "f4"]
    projection = pd.read_csv(tmp_path / "of_projection")
    assert projection.columns.to_list() == ["frame", "pc1", "pc2", "cluster"]
    assert projection["frame"].to_list() == [0, 2, 4]
    assert pd.read_csv(tmp_path / "of_explained")["explained"].sum() == pytest.approx(1)
    assert (tmp_path / "of_silhouette").read_text() == "K,silhouette,inertia\n"
    for k in (0, 2, 4):
        own = read_molecule(tmp_path / "structures" / f"f{k}.pdb").xyz[0]
        assert np.array_equal(own, read_molecule(structure).xyz[k])


@pytest.mark.parametrize(("asked", "atoms"), [("auto", None), ("name CB", "name CB")])
def test_conformations_are_chosen_as_the_config_asks(tmp_path, monkeypatch, asked, atoms):
    calls = noted(monkeypatch, choose_frames, "choose_frames")
    chosen(
        tmp_path, {"structure": models(tmp_path / "m.pdb", 5)}, use="clusters", clusters=2, pca_atoms=asked
    )
    ((molecule, *given, rng),) = calls
    assert molecule.n_frames == 5 and given == [2, None, atoms]
    assert rng.random() == stream(3, "p", "clusters").random()


def test_a_trajectory_is_followed_gathered_and_shown(tmp_path, monkeypatch, capsys):
    settings = check(SMALL) | {
        "ensemble": {"combination": [1.0, 0.0, 6.0, 0.0], "test_dots": 20, "draws": 2, "stride": 2}
    }
    calls = noted(monkeypatch, follow_frames, "follow")
    inputs, rest = {"structure": models(tmp_path / "m.pdb", 4)}, tmp_path / "rest.part"
    rows = [tmp_path / "ensemble" / f"{k}of2.csv" for k in (1, 2)]
    rows[0].parent.mkdir()
    for k, path in enumerate(rows, 1):
        follow_frames.main(inputs, {"rows": path}, {}, settings, "p", (k, 2), 1, rest, "code")
        assert f"PROGRESS p, part {k} of 2: 1 of 1 frames" in capsys.readouterr().err and not rest.exists()
    molecule, *given = calls[0]
    assert molecule.frame_number.tolist() == [0, 2]
    assert (*given[:5], given[-1]) == (settings, "p", 1, rest, "code", (1, 2))
    tables = {key: tmp_path / f"{key}.csv" for key in ("table", "over_time", "residues")}
    follow_ensemble.main(inputs | {"rows": [*map(str, rows)]}, tables, {})
    assert pd.read_csv(tables["table"])["frame"].to_list() == [0, 2]
    assert pd.read_csv(tables["residues"])["residue_name"].to_list() == [*SEQUENCE, "VAL"]
    figures = [
        noted(monkeypatch, draw_ensemble.over_time, f"{name}_figure", lambda *_: layout.sheet(9, 9))
        for name in ("ensemble", "residues")
    ]
    pictures = {key: str(tmp_path / f"of_{key}.png") for key in ("png", "residues")}
    draw_ensemble.main(tables, pictures | {"page": tmp_path / "p.html"}, settings, "p")
    (((table, combination, name),), ((over_time, residues, own),)) = figures
    assert len(table) == len(over_time) == 2 and len(residues) == 5
    assert combination == [1.0, 0.0, 6.0, 0.0] and name == own == "p"
    assert all(Path(path).is_file() for path in pictures.values())
    assert (tmp_path / "p.html").read_text("utf-8").count("<html") == 1


def test_a_simulation_gets_what_the_config_asks_for(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(prepare_system, "chosen_protein", lambda path, asked: f"{asked} of {path}")
    calls = noted(monkeypatch, prepare_system, "prepare", lambda *_: {"waters": 7})
    outputs = {"system": tmp_path / "system", "contents": tmp_path / "system.json"}
    prepare_system.main({"structure": "a.pdb"}, outputs, "chain A", {"ns": 1}, {"seed": 3})
    assert calls == [("chain A of a.pdb", "a.pdb", DEFAULTS | {"ns": 1}, 3, outputs["system"])]
    assert outputs["system"].is_dir() and json.loads(outputs["contents"].read_text()) == {"waters": 7}

    (tmp_path / "work").mkdir()
    calls = noted(
        monkeypatch, simulate_stage, "run_stage", lambda *given: given[-1](4, 4) or tmp_path / "work"
    )
    inputs, outputs = {"system": "system", "before": "minimise"}, {"folder": tmp_path / "nvt"}
    simulate_stage.main(inputs, outputs, {"ns": 1}, {"seed": 3}, "nvt", "running", "p", 2)
    assert calls[0][:-1] == ("nvt", "system", "minimise", DEFAULTS | {"ns": 1}, 3, "running", 2)
    assert "PROGRESS p: nvt: 4 of 4 steps" in capsys.readouterr().err
    assert outputs["folder"].is_dir() and not (tmp_path / "work").exists()


def test_a_structure_is_fetched_with_its_checksum(monkeypatch):
    calls = noted(monkeypatch, fetch_structure, "fetch", lambda *_: None)
    fetch_structure.main({"structure": "a.pdb", "record": "a.json"}, "https://a", "0f", "p")
    assert calls == [("https://a", "0f", "a.pdb", "a.json", "p")]


def test_all_steps_of_a_conformation_go_by_what_those_before_have_made(monkeypatch):
    calls = {
        step.__name__: noted(monkeypatch, step, "main", lambda *_, **__: None)
        for step in take_all_steps.STEPS
    }
    own = {step: {"made": f"{step}.x"} for step in calls}
    own["make_surface"] = {"surface": "surface.npz", "structure": "structure.pdb"}
    own["measure_roughness"], own["measure_floors"] = {"roughness": "roughness.csv"}, {"floors": "floors.csv"}
    own["take_minimal"] = {"table": "minimal.csv", "fields": "fields.npz", "ply": "minimal.ply"}
    inputs = {"structures": "structures", "structure": "p.pdb", "trajectory": "p.xtc", "table": "p.csv"}
    outputs = {f"{step}_{key}": path for step, files in own.items() for key, path in files.items()}
    take_all_steps.main(inputs, outputs, "settings", "options", "p/c1", 2)
    made = own["make_surface"] | own["measure_roughness"] | own["measure_floors"]
    made |= {"minimal": "minimal.csv", "fields": "fields.npz"}
    atoms = inputs | {"surface": "surface.npz", "roughness": "roughness.csv", "own": "structure.pdb"}
    rest = ("settings", "p/c1", 2)
    for step, given in {
        "make_surface": (inputs, *rest[:2], False),
        "measure_roughness": (made, *rest),
        "measure_floors": (atoms, "settings", "options", "p/c1", 2),
        "take_minimal": (made | {"table": "p.csv"}, *rest, False),
        "draw_view": (made, *rest),
        "tabulate_residues": (made, "p/c1"),
    }.items():
        assert calls[step] == [(given[0], own[step], *given[1:])], step
