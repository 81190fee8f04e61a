"""Scripts called with plain arguments, where the small study has one case of several."""

import ast
import json
from importlib import import_module
from inspect import signature
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import choose_frames
import match_partners
import prepare_system
import simulate_stage
import tabulate_residues
from conftest import ROOT
from peptides import peptide, write
from small_study import EMBEDDED
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.pairs import matching
from sparsurf.simulation.protocol import DEFAULTS
from sparsurf.streams import stream
from sparsurf.study.prepared_surface import prepare_surface
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow.config import check_config

SCRIPTS = sorted((ROOT / "scripts").glob("*.py"))
SEQUENCE = ("ALA", "LEU", "LYS", "GLY")
FRAMES = check_config({"proteins": {"p": {"structure": str(ROOT / EMBEDDED["structure"])}}})["frames"]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_no_table_begins_with_the_numbers_of_its_rows(path):
    calls = [node for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.Call)]
    written = [node for node in calls if isinstance(node.func, ast.Attribute) and node.func.attr == "to_csv"]
    keywords = [{word.arg: ast.unparse(word.value) for word in call.keywords} for call in written]
    assert all(words.get("index") == "False" for words in keywords)


@pytest.mark.parametrize("script", ["evaluate_grid", "measure_floors", "select_minimal_subset", "draw_view"])
@pytest.mark.parametrize("moved", [True, False])
def test_the_two_rules_of_the_published_sampling_are_not_exchanged(script, moved, monkeypatch):
    module, given = import_module(script), []

    def record(*args, **kwargs):
        given.append(signature(prepare_surface).bind(*args, **kwargs).arguments)
        raise InputError("that is enough")

    dots = Surface(np.eye(3), np.eye(3))
    for name, own in {
        "prepare_surface": record,
        "read_npz": lambda _: dots,
        "with_fields": lambda surface, _: surface,
        "read_roughness": lambda *_: np.ones(3),
    }.items():
        monkeypatch.setattr(module, name, own, raising=False)
    rules = {"distance_from_moved_centre": moved, "chance_in_every_patch": not moved}
    values = dict.fromkeys(signature(module.main).parameters) | rules | {"sampling": rules, "field_names": []}
    with pytest.raises(InputError):
        module.main(**{name: values[name] for name in signature(module.main).parameters})
    assert {name: given[0][name] for name in rules} == rules


def test_residues_do_not_count_the_walls_of_cavities(monkeypatch):
    given, dots = [], Surface(np.eye(3), np.eye(3))

    def record(*args):
        given.extend(args)
        raise InputError("that is enough")

    for name, own in {
        "with_fields": lambda *_: dots,
        "read_npz": lambda _: dots,
        "read_study_structure": lambda _: None,
        "read_minimal": lambda *_: pd.DataFrame({"dot": [1], "weight": [2.0]}),
        "read_roughness": lambda *_: np.ones(3),
        "stored_components": lambda surface: ("components", surface),
        "residue_table": record,
    }.items():
        monkeypatch.setattr(tabulate_residues, name, own)
    with pytest.raises(InputError):
        tabulate_residues.main(**dict.fromkeys(signature(tabulate_residues.main).parameters, "x"))
    assert given[5] == ("components", dots)


def test_the_interface_of_the_config_counts_in_every_table_of_a_pair(tmp_path, monkeypatch):
    given, table = (
        {},
        pd.DataFrame({"similarity_smoothed": [1.0], "interface": [0], "propensity_smoothed": [1.0]}),
    )
    fake = SimpleNamespace(
        AREAS=matching.AREAS,
        CONTACTS=matching.CONTACTS,
        match=lambda *_: None,
        maps=lambda *_: None,
        by_dot=lambda match, position, maps, interface: given.update(dots=interface) or table.copy(),
        agreement=lambda match, position, maps, interface, **_: given.update(agreement=interface),
        best_pairs=lambda _: pd.DataFrame(),
        contacts=lambda first, second, interface, *_: given.update(contacts=interface),
    )
    for name, own in {
        "matching": fake,
        "read_partners": lambda *_: [SimpleNamespace(surface=None, residues=None)] * 2,
        "select_centres": lambda *_: None,
        "write_ply": lambda *_: None,
    }.items():
        monkeypatch.setattr(match_partners, name, own)
    outputs = {name: str(tmp_path / f"{name}.csv") for name in ("dots", "best", "agreement", "contacts")}
    values = dict.fromkeys(signature(match_partners.main).parameters, 1) | outputs | {"interface": 4.5}
    match_partners.main(**values | {"patches": {"descriptor": "published", "R_zernike": 6.0, "D_link": 0.5}})
    assert given == dict.fromkeys(("dots", "agreement", "contacts"), 4.5)


def models(path, n):
    """Write a file of n models of a peptide whose last atoms stand elsewhere in each."""
    texts = [peptide(SEQUENCE) + peptide(("VAL",), "B", origin=(0, 6 + k**2, 0.5 * k)) for k in range(n)]
    return write(path, "".join(f"MODEL {k + 1}\n{text}ENDMDL\n" for k, text in enumerate(texts)) + "END\n")


def choose(folder, structure, trajectory=None, options=None, **settings):
    """Run the script; return the names of the conformations."""
    names = ("frames", "silhouette", "projection", "explained")
    choose_frames.main(
        structure=str(structure),
        trajectory=trajectory,
        **{name: str(folder / f"{name}.csv") for name in names},
        structures=str(folder / "structures"),
        settings=FRAMES | settings,
        molecule_options=options or {},
        seed=3,
        name="p",
    )
    return pd.read_csv(folder / "frames.csv")["conformation"].to_list()


@pytest.mark.parametrize(
    ("n", "options", "settings", "names"),
    [
        (1, {}, {"selection": [3]}, ["f0"]),  # frames are those of the trajectories beside it
        (1, {}, {"selection": [3], "stride": 2}, ["f0"]),
        (1, {}, {"selection": "clusters", "clusters": 3}, ["c1"]),
        (3, {"model": 2}, {"selection": [7], "stride": 2}, ["f1"]),
        (2, {}, {"selection": [1]}, ["f1"]),
        (2, {}, {"selection": "all", "stride": 2}, ["f0"]),
        (5, {}, {"selection": "clusters", "clusters": 2}, ["c1", "c2"]),
    ],
)
def test_conformations_of_a_file_with_one_or_several_models(tmp_path, n, options, settings, names):
    assert choose(tmp_path, models(tmp_path / "m.pdb", n), options=options, **settings) == names


@pytest.mark.parametrize(
    ("settings", "key"),
    [({"selection": [1]}, "selection"), ({"selection": "clusters", "clusters": 3}, "clusters")],
)
def test_the_one_frame_that_a_stride_leaves_is_no_single_structure(tmp_path, settings, key):
    structure, trajectory = (str(ROOT / EMBEDDED[name]) for name in ("structure", "trajectory"))
    with pytest.raises(InputError, match=rf"^frames\.{key}: "):
        choose(tmp_path, models(tmp_path / "m.pdb", 2), stride=2, **settings)
    with pytest.raises(InputError, match=rf"^frames\.{key}: "):
        choose(tmp_path, structure, trajectory, {"residues": "209-212"}, stride=10**6, **settings)


def test_conformations_are_the_frames_that_are_named_in_the_tables(tmp_path):
    structure = models(tmp_path / "m.pdb", 5)
    assert choose(tmp_path, structure, selection="all", stride=2) == ["f0", "f2", "f4"]
    projection = pd.read_csv(tmp_path / "projection.csv")
    assert projection.columns.to_list() == ["frame", "pc1", "pc2", "cluster"]
    assert projection["frame"].to_list() == [0, 2, 4]
    assert pd.read_csv(tmp_path / "explained.csv")["explained"].sum() == pytest.approx(1)
    assert (tmp_path / "silhouette.csv").read_text() == "K,silhouette,inertia\n"
    for k in (0, 2, 4):
        atoms = read_molecule(tmp_path / "structures" / f"f{k}.pdb").xyz[0]
        assert np.array_equal(atoms, read_molecule(structure).xyz[k])


def spy(monkeypatch, module, name, instead=None):
    """Return a list that collects the calls of a function, positional and named arguments in one row."""
    calls, work = [], instead or getattr(module, name)

    def note(*args, **keywords):
        calls.append((*args, *keywords.values()))
        return work(*args, **keywords)

    monkeypatch.setattr(module, name, note)
    return calls


def test_conformations_are_chosen_as_the_config_asks(tmp_path, monkeypatch):
    calls = spy(monkeypatch, choose_frames, "choose_frames")
    choose(tmp_path, models(tmp_path / "m.pdb", 5), selection="clusters", clusters=2)
    ((molecule, *arguments, rng),) = calls
    assert molecule.n_frames == 5 and arguments == [2, None]
    assert rng.random() == stream(3, "p", "clusters").random()


def test_a_simulation_follows_the_config(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(prepare_system, "select_protein", lambda path, options: f"{options} of {path}")
    calls = spy(monkeypatch, prepare_system, "prepare_system", lambda *_: {"waters": 7})
    system, contents = tmp_path / "system", tmp_path / "system.json"
    prepare_system.main("a.pdb", str(system), str(contents), {"ns": 1}, {"chains": ["A"]}, 3)
    assert calls == [("{'chains': ['A']} of a.pdb", "a.pdb", DEFAULTS | {"ns": 1}, 3, system)]
    assert system.is_dir() and json.loads(contents.read_text()) == {"waters": 7}

    (tmp_path / "work").mkdir()
    calls = spy(monkeypatch, simulate_stage, "run_stage", lambda *args: args[-1](4, 4) or tmp_path / "work")
    folder = tmp_path / "nvt"
    simulate_stage.main("minimise", "system", str(folder), {"ns": 1}, "nvt", "running", 3, "p", 2)
    assert calls[0][:-1] == ("nvt", "system", "minimise", DEFAULTS | {"ns": 1}, 3, "running", 2)
    assert "PROGRESS p: nvt: 4 of 4 steps" in capsys.readouterr().err
    assert folder.is_dir() and not (tmp_path / "work").exists()
