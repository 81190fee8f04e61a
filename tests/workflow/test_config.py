"""The config: defaults, and one sentence for every kind of mistake."""

import copy
import datetime
import json
import os
import re
import subprocess
import sys

import pytest
import yaml

from conftest import ROOT
from sparsurf.dot_fields.registry import FIELDS
from sparsurf.errors import InputError
from sparsurf.patches.descriptors import DESCRIPTORS
from sparsurf.patches.roughness import ROUGHNESS
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.surfaces.read_surface import FORMATS
from sparsurf.workflow import config_reference, listing, memory, names
from sparsurf.workflow.config import Protein, check_config, proteins, read_config

DEFAULT = yaml.safe_load((ROOT / "config.yaml").read_text())


@pytest.fixture(autouse=True)
def at_root(monkeypatch):
    monkeypatch.chdir(ROOT)


def refuse(config, words):
    """Check that a config is refused with these words, a regular expression."""
    with pytest.raises(InputError, match=words):
        check_config(config)


def changed(path, value):
    config = copy.deepcopy(DEFAULT)
    *parents, last = path.split(".")
    place = config
    for key in parents:
        place = place.setdefault(key, {})
    place[last] = value
    return config


def test_the_default_config_is_valid_and_states_every_default():
    checked = check_config(DEFAULT, [ROOT / "config.yaml"])
    bare = check_config({"proteins": DEFAULT["proteins"]})
    assert {k: v for k, v in checked.items() if k != "run"} == {k: v for k, v in bare.items() if k != "run"}


def test_a_config_without_proteins_changes_the_default_study(tmp_path, monkeypatch):
    given = {"minimal": {"n_S": 100}, "evaluation": {"draws": 2}}
    assert check_config({}) == check_config(DEFAULT)
    monkeypatch.chdir(tmp_path)  # whose folder has no config.yaml
    refuse(given, "the config lacks the key 'proteins'")
    whole = check_config(given, home=ROOT)
    assert whole["minimal"]["n_S"] == 100 and whole["evaluation"]["test_dots"] == 200
    assert whole["proteins"]["tdp43"]["structure"] == str(ROOT / "data" / "tdp43" / "topology.pdb")
    (tmp_path / "config.yaml").write_text("run: own\nproteins: {a: {pdb: 1ubi}}\n")
    own = check_config({"seed": 5}, home=ROOT)
    assert (own["run"], own["proteins"], own["seed"]) == ("own", {"a": {"pdb": "1ubi"}}, 5)
    assert check_config({"proteins": {"b": {"pdb": "1fas"}}}, home=ROOT)["run"] == "default"


def test_a_section_that_runs_or_not_may_be_true_or_false():
    plain = {"proteins": DEFAULT["proteins"]}
    bare = check_config(plain)
    for key in ("sampling", "compare", "ensemble"):
        for value in (True, False):
            assert check_config(plain | {key: value}) == bare | {key: bare[key] | {"run": value}}
    large = {"sampling": {"alpha": [k / 100 for k in range(1, 101)]}, "evaluation": {"draws": 10000}}
    refuse(plain | large, "GB of memory")
    check_config(plain | large | {"sampling": False})
    check_config(plain | large | {"sampling": "false"})  # of snakemake --config sampling=false
    sampled = {name: protein | {"sampling": True} for name, protein in plain["proteins"].items()}
    refuse(large | {"sampling": large["sampling"] | {"run": False}, "proteins": sampled}, "GB of memory")
    check_config(large | {"proteins": {name: {**sampled[name], "sampling": False} for name in sampled}})
    refuse(plain | {"patches": False}, "patches")


def test_every_key_is_described():
    page = config_reference.reference_page()
    rows = [line.split("|") for line in page.splitlines() if line.startswith("| `")]
    assert len(rows) > 70 and all(row[2].strip() and row[-2].strip() for row in rows)


def test_the_schema_and_the_reference_page_are_those_of_the_models():
    """Run `python -m sparsurf.workflow.config` to write them."""
    text = config_reference.SCHEMA_FILE.read_text(encoding="utf-8")
    assert json.loads(text) == config_reference.json_schema()
    assert config_reference.PAGE.read_text(encoding="utf-8") == config_reference.reference_page()


@pytest.mark.parametrize("path", [ROOT / "config.yaml", *sorted((ROOT / "studies").glob("*.yaml"))])
def test_every_study_is_valid_and_names_its_schema(path, monkeypatch):
    monkeypatch.setattr(memory, "memory_of_machine", lambda: float("inf"))
    schema = "config/schema.json" if path.parent == ROOT else "../config/schema.json"
    assert path.read_text().startswith(f"# yaml-language-server: $schema={schema}\n")
    config = read_config(path)
    if config.get("pairs") == {"folder": "data/complexes/bound"}:
        del config["pairs"]  # these files are not part of the repository
    assert check_config(config, [path])["run"] == config.get("run", "default")


def test_the_import_takes_no_numpy():
    code = "import sys, sparsurf.workflow.config; print({'numpy', 'pandas'} & {*sys.modules})"
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.stdout == "set()\n", done.stderr


def test_the_default_config_lists_all_samplers():
    line = re.search(r"^  sampler: (\w+) # or (.*)$", (ROOT / "config.yaml").read_text(), re.M)
    assert {line[1], *line[2].split(", ")} == set(SAMPLERS)


@pytest.mark.parametrize(
    "path, value, words",
    [
        ("seed", "seven", ["seed is 'seven'", "must be a whole number"]),
        ("seed", -1, ["seed is -1", "0 or more"]),
        ("sampling.alpha", [0.5, 1.5], ["sampling.alpha.1 is 1.5", "1 or less"]),
        ("sampling.alpha", [0.0], ["sampling.alpha.0 is 0.0", "more than 0"]),
        ("sampling.beta", [-0.2], ["sampling.beta.0 is -0.2", "0 or more"]),
        ("sampling.gamma", [], ["sampling.gamma is [], but must be a list of 1 or more"]),
        ("sampling.delta", [2, 2], ["sampling.delta holds a value twice"]),
        ("sampling.gama", [1], ["unknown key 'gama' in sampling", "did you mean 'gamma'?"]),
        ("evalution", {}, ["unknown key 'evalution'", "did you mean 'evaluation'?"]),
        ("proteins", {}, ["proteins is empty"]),
        (
            "proteins.tdp43.structure",
            "no/such.pdb",
            [f"proteins.tdp43.structure: there is no file 'no/such.pdb' (paths start at {ROOT})."],
        ),
        (
            "proteins.tdp43.structure",
            "config.yaml/a.pdb",
            ["'config.yaml/a.pdb' leads into a file; unpack an archive first"],
        ),
        (
            "proteins.tdp43.structure",
            "a<x>b/s.pdb",
            ["'a<x>b/s.pdb' holds a wildcard of Snakemake, {x} or <x>"],
        ),
        ("proteins.tdp43.structure", "{y}.pdb", ["'{y}.pdb' holds a wildcard of Snakemake, {x} or <x>"]),
        ("proteins.tdp43.surface", "x.dms", ["exactly one of 'structure'", "'surface'"]),
        ("proteins.TDP43", {"structure": "data/tdp43/topology.pdb"}, ["differ in upper and lower case only"]),
        (
            "proteins.bad/name",
            {"structure": "data/tdp43/topology.pdb"},
            ["'bad/name'", "cannot name a folder"],
        ),
        ("proteins...", {"structure": "x"}, ["cannot name a folder"]),
        ("run", "../elsewhere", ["'../elsewhere'", "cannot name a folder"]),
        ("patches.D_link", 5.0, ["patches.D_link is 5 Å", "smaller than R_patch"]),
        (
            "evaluation.readings",
            ["recovered"],
            ["evaluation.readings is ['recovered'], but needs kept or full"],
        ),
        (
            "evaluation.readings",
            ["kept", "both"],
            ["evaluation.readings.1 is 'both'", "kept, full"],
        ),
        ("evaluation.test_dots", "many", ["evaluation.test_dots is 'many'"]),
        ("frames.clusters", 0, ["frames.clusters is 0, but must be 1 or more ("]),
        ("frames.selection", [0, "a"], ["frames.selection.1 is 'a', but must be a whole number"]),
        (
            "complementarity.centres",
            {"sampler": "farthest", "n_S": 5, "n_s_percent": 5},
            ["unknown key 'n_s_percent' in complementarity.centres; did you mean 'n_S_percent'?"],
        ),
        ("frames.selection", [], ["frames.selection is [], but must be a list of 1 or more"]),
        (
            "frames.selection",
            5,
            ["frames.selection is 5, but must be one of clusters, all or a list in brackets"],
        ),
        (
            "proteins",
            {"a": {"structure": "data/tdp43/topology.pdb", "ligands": ["XK2", False]}},
            ["proteins.a.ligands.1 is False, but must be a string; put it in quotes ("],
        ),
        ("compare.percents", [120], ["compare.percents.0 is 120", "less than 100"]),
        ("surface.radii", "vdw", ["surface.radii is 'vdw'", "dms, bondi"]),
        ("patches", 7, ["patches is 7", "must be a mapping"]),
        ("fields", ["colour"], ["fields.0 is 'colour'", "must be one of hydropathy, potential, bfactor"]),
        (
            "proteins.tdp43.residues",
            "209-",
            ["residues is '209-', but must be of the form A:10-52A,60,-5--3 ("],
        ),
        ("proteins.tdp43.residues", "A:209-222,", ["residues is 'A:209-222,', but must be of the form"]),
        ("minimal.sampler", "farthst", ["minimal.sampler is 'farthst'", "did you mean 'farthest'?"]),
        ("compare.percents", [10, 100], ["compare.percents.1 is 100, but must be less than 100"]),
        ("compare.samplers", ["uniform", "best"], ["compare.samplers.1 is 'best'", "one of paper,"]),
        ("patches.D_link", float("nan"), ["patches.D_link is nan, but must be a number"]),
        ("patches.R_patch", float("inf"), ["patches.R_patch is inf, but must be a number"]),
        ("sampling.alpha", [0.5, float("nan")], ["sampling.alpha.1 is nan"]),
        ("sampling.gamma", [float("inf")], ["sampling.gamma.0 is inf"]),
        ("evaluation.draws", 2.5, ["evaluation.draws is 2.5", "a whole number"]),
        ("evaluation.draws", 100_000_000, ["evaluation.draws is 100000000", "10000 or less"]),
        ("tables.ranges", 100_000_000, ["tables.ranges is 100000000", "1000 or less"]),
        ("frames.stride", 10**12, ["frames.stride is 1000000000000", "1000000000 or less"]),
        (
            "sampling.beta",
            [k / 100 for k in range(101)],
            ["sampling.beta is [0.0, 0.01", "a list of 100 or fewer"],
        ),
        ("run", "x\n", ["cannot name a folder"]),
        ("run", "x" * 300, ["in run cannot name a folder", "(302 characters)"]),
        ("run", "..", ["cannot name a folder"]),
        ("proteins", {"x\n": {"structure": "data/tdp43/topology.pdb"}}, ["cannot name a folder"]),
        ("proteins", {"x" * 300: {"structure": "data/tdp43/topology.pdb"}}, ["cannot name a folder"]),
        (
            "proteins",
            {1: {"structure": "data/tdp43/topology.pdb"}},
            ["the key 1 in proteins is not read as a string"],
        ),
        ("proteins", {"a": {"pdb": "1ubi\n"}}, ["proteins.a.pdb is '1ubi\\n'"]),
        ("proteins", {"a": {"pdb": 453}}, ["proteins.a.pdb is '453', but must be of the form 1ubi ("]),
        (
            "proteins",
            {"a": {"pdb": 1e10}},
            ["proteins.a.pdb is 10000000000.0, but", "a string; put it in quotes ("],
        ),
        ("minimal", {"n_S": 5, "Z": 1.0}, ["minimal needs exactly one of", "but has n_S, Z"]),
        ("sampling.alpha", 0.5, ["sampling.alpha is 0.5, but must be a list in brackets"]),
        (
            "evaluation.readings",
            "kept",
            ["evaluation.readings is 'kept', but must be a list in brackets"],
        ),
        ("seed", "1e3", ["seed is '1e3'", "a whole number without quotes"]),
        ("run", datetime.date(2026, 1, 2), ["run is 2026-01-02, but must be a string; put it in quotes ("]),
        ("draws", 3, ["unknown key 'draws' in the config; it belongs to evaluation."]),
        ("pairs", {"q": {"complex": "x.pdb"}}, ["pairs.q needs exactly one of 'proteins', 'files' and"]),
        ("fields", ["hydropaty"], ["fields.0 is 'hydropaty'", "did you mean 'hydropathy'?"]),
        ("fields", ["potential", "potential"], ["fields holds a value twice"]),
        ("fields", "potential", ["fields is 'potential', but must be a list in brackets"]),
        ("paper", "none", ["paper is 'none'", "none of the proteins tdp43"]),
        (
            "proteins.tdp43.pdbfile",
            "a.pdb",
            ["unknown key 'pdbfile' in proteins.tdp43; did you mean 'structure'?"],
        ),
        ("frames", None, ["frames is None, but must be a mapping"]),
        ("surface.density", -1, ["surface.density is -1, but must be more than 0"]),
        ("complementarity.centres", "some", ["centres is 'some', but must be all or a mapping"]),
        ("complementarity.centres", {"n_S": 5}, ["complementarity.centres lacks the key 'sampler'."]),
        ("complementarity.centres", {"sampler": "farthest"}, ["exactly one of 'n_S_percent' and 'n_S'"]),
        (
            "complementarity.centres",
            {"sampler": "farthest", "n_S": 5, "n_S_percent": 5},
            ["exactly one of 'n_S_percent'"],
        ),
        ("ensemble.combination", [0, 1, 1, 1], ["ensemble.combination is [0, 1, 1, 1]", "alpha"]),
        (
            "ensemble.combination",
            [1, 1, 1],
            ["ensemble.combination is [1, 1, 1], but must be a list of 4 or more"],
        ),
        ("changes", {"s": ["a/x/2", "b"]}, ["changes.s.0 is 'a/x/2'", "my_protein/c2"]),
        ("changes", {"s": ["a", "tdp43"]}, ["changes.s: 'a' is none of the proteins; these are"]),
        ("changes", {"s": ["tdp43"]}, ["changes.s is ['tdp43'], but must be a list of 2 or more"]),
        ("changes", {"s": "tdp43"}, ["changes.s is 'tdp43', but must be a list"]),
        ("proteins", "none.csv", ["proteins is 'none.csv', but there is no such table."]),
        ("proteins.tdp43.simulate", {"water": "../tip3p"}, ["proteins.tdp43.simulate.water is '../tip3p'"]),
        ("exclude", {"tdp43": 3}, ["exclude.tdp43 is 3, but must be a string"]),
        ("seed", True, ["seed is True, but must be a whole number"]),
        ("seed", 2**64, ["seed is 18446744073709551616, but must be 18446744073709551615 or less"]),
    ],
)
def test_a_mistake_is_answered_with_a_sentence(path, value, words):
    config = changed(path, value) if path != "proteins..." else DEFAULT | {"proteins": {"..": value}}
    with pytest.raises(InputError) as error:
        check_config(config)
    for word in words:
        assert word in str(error.value)


def test_a_field_may_be_a_column_of_every_table(tmp_path):
    for name, head in (("a", 'chain, residue ,"a\nnote",score\n'), ("b", '\nresidue, "score",other\n')):
        row = "1,2,3,4" if name == "a" else "1,2,3"
        (tmp_path / f"{name}.csv").write_text(f"{head}{row}\n")
    (tmp_path / "taken.csv").write_text("residue,points,score\n1,2,3\n")
    plain = DEFAULT["proteins"]["tdp43"]
    taken = {"a": plain | {"table": str(tmp_path / "taken.csv")}}
    entries = {name: plain | {"table": str(tmp_path / f"{name}.csv")} for name in "ab"} | {"c": plain}
    assert check_config({"proteins": entries, "fields": ["score", "potential"]})["fields"] == [
        "score",
        "potential",
    ]
    for config, said in (
        ({"proteins": entries, "fields": ["other"]}, "fields.0 is 'other', but must be one of hydropathy"),
        ({"proteins": {"c": plain}, "fields": ["potential", "score"]}, "fields.1 is 'score'"),
        ({"proteins": taken, "fields": ["points"]}, "fields.0 is 'points', but must be one of hydropathy"),
        ({"proteins": entries, "fields": ["score"], "seed": -1}, "seed is -1, but must be 0 or more"),
        ({"proteins": {"a": {"surface": "x.dms", "table": "t.csv"}}}, "remove `table`: it applies to"),
        ({"proteins": {"a": plain | {"table": "no.csv"}}}, "proteins.a.table: there is no file 'no.csv'"),
        (
            {"proteins": {"a": entries["a"]}, "fields": ["potential"]},
            "table: `fields` names none of its columns",
        ),
        ({"proteins": {"a": plain | {"table": 3}}, "fields": ["score"]}, "proteins.a.table is 3"),
        ({"proteins": {"a": entries["a"]}, "fields": [["score"]]}, "fields.0 is ['score']"),
    ):
        with pytest.raises(InputError, match=re.escape(said)) as error:
            check_config(config)
        assert said[:6] == "fields" or "fields." not in str(error.value)


def test_the_minimal_subset_has_an_error_where_no_other_wish_is_given():
    for own in ({"sampler": "poisson"}, {}):
        assert check_config(DEFAULT | {"minimal": own})["minimal"] == DEFAULT["minimal"] | own
    assert "error" not in check_config(DEFAULT | {"minimal": {"n_S": 9}})["minimal"]


def test_what_is_excluded_is_a_part_of_the_study():
    plain = {"proteins": DEFAULT["proteins"]}
    for place in ("tdp43", "tdp43/c2", "tdp43/*"):
        assert check_config(plain | {"exclude": {place: "why"}})["exclude"] == {place: "why"}
        assert check_config(plain | {"exclude": [place]})["exclude"] == {place: ""}
    unknown = ["tdp34", "tdp34/c2", "tdp43/foo", "tdp43/c99x", "pairs/ab", "changes/x", "pairs"]
    for place in (*unknown, "tdp43/c1/draw_view", "summarise_run"):
        refuse(
            plain | {"exclude": {place: "why"}},
            rf"exclude: '{re.escape(place)}' is not part of the study; remove it",
        )


def test_forms_that_the_structures_lack_are_named_before_any_job():
    own = {"structure": str(ROOT / "data" / "tdp43" / "topology.pdb")}
    both = {"proteins": {"a": own, "b": own}}
    refuse(both | {"changes": {"s": ["a/c2", "b"]}}, "changes.s: there is no 'a/c2', as a has a single form")
    assert check_config(both | {"changes": {"s": ["a", "b/c1"]}})["changes"] == {"s": ["a", "b/c1"]}
    both["proteins"]["a"] = own | {"trajectory": str(ROOT / "data" / "tdp43" / "trajectory.xtc")}
    assert check_config(both | {"changes": {"s": ["a/c7", "b"]}})  # known once frames are chosen


def test_what_needs_an_excluded_protein_is_excluded_too():
    own = DEFAULT["proteins"]["tdp43"]
    both = {"proteins": {"a": own, "b": own}, "pairs": {"ab": {"proteins": ["a", "b"]}}}
    both["changes"] = {"s": ["a/c1", "b"], "t": ["a", "b"]}
    for excluded, place, name in (
        ({"b": ""}, "pairs/ab", "b"),
        ({"b": "", "pairs/ab": ""}, "changes/s", "b"),
        ({"a/c01": "", "pairs/ab": "", "changes/t": ""}, "changes/s", "a/c1"),
        ({"a/c1": ""}, "pairs/ab", "a"),  # whose first conformation the pair takes
        ({"b/c1": "", "pairs/ab": "", "changes/s": ""}, "changes/t", "b"),
    ):
        refuse(
            both | {"exclude": excluded},
            f"exclude: {place} needs '{name}', which is excluded; exclude {place} too",
        )
    every = {"b": "", "pairs/ab": "", "changes/s": "", "changes/t": ""}
    assert check_config(both | {"exclude": every})["exclude"] == every
    assert check_config(both | {"exclude": {"a/c2": "", "b/f0": ""}})
    refuse(
        both | {"exclude": {"b/f0000": "", "changes/s": "", "changes/t": ""}, "frames": {"selection": "all"}},
        "exclude: pairs/ab needs 'b'",
    )


STRUCTURE = {"structure": "data/tdp43/topology.pdb"}
READY = {"proteins": {"a": {"surface": "README.md"}}}  # any file: it is not read
MIXED = {"proteins": READY["proteins"] | DEFAULT["proteins"]}
PAIRS = {"pairs": {"ab": {"files": ["data/tdp43/topology.pdb", "README.md"]}}}
MOVED_ATOMS = {"minimal": {"floor": "atoms moved 0.1 Å"}}
FETCHED = {"url": "https://a.org/b.pdb", "sha256": 64 * "0"}
OWN = {"proteins": DEFAULT["proteins"]}


@pytest.mark.parametrize(
    ("config", "said"),
    [
        (OWN | {"sampling": False, "compare": True}, "sampling is false, but `compare` needs its grid"),
        (
            OWN | {"sampling": False, "paper": "tdp43"},
            "sampling is false, but `paper` needs the grid of tdp43",
        ),
        (
            {"proteins": {"a": STRUCTURE, "b": STRUCTURE | {"sampling": False}}, "paper": "b"},
            "sampling is false, but `paper` needs the grid of b",
        ),
        ({"proteins": {"a": STRUCTURE | {"sampling": False}}, "compare": True}, "`compare` needs its grid"),
        (
            {"proteins": {"a": STRUCTURE | {"sampling": True}}, "batch": 5, "sampling": False},
            "batch needs `sampling: false`",
        ),
        (PAIRS | {"compare": True}, "compare.run is true, but there are no surfaces to sample"),
        (OWN | {"compare": {"samplers": ["farthest"]}}, "compare.samplers names farthest alone"),
        (
            READY | {"compare": {"samplers": ["poisson", "paper"]}},
            "neither uniform nor farthest, which proteins.a",
        ),
        (OWN | {"paper": "tdp43", "tables": {"ranges": 5}}, "tables.ranges is 5, but `paper` has 10"),
        (OWN | {"paper": "tdp43", "tables": {"ranges": 12}}, "tables.ranges is 12, but `paper` has 10"),
        (OWN | {"paper": "tdp43", "evaluation": {"readings": ["kept"]}}, "but `paper` needs both"),
        (
            OWN | {"paper": "tdp43", "frames": {"selection": [0, 7]}},
            "frames.selection is [0, 7], but `paper` compares",
        ),
        ({"proteins": {"a": STRUCTURE | {"simulate": {}, "ligands": True}}}, "only the protein is simulated"),
        (
            {"proteins": {"a": STRUCTURE | {"simulate": {}, "ligands": ["XK2"]}}},
            "only the protein is simulated",
        ),
        (
            {"proteins": {"a": STRUCTURE | {"sha256": 64 * "0"}}},
            "proteins.a.sha256 is for a file that is fetched",
        ),
        (READY | {"ensemble": {"run": True}}, "ensemble.run is true, but every protein is a ready surface"),
        (READY | {"fields": ["hydropathy"]}, "fields names hydropathy, which needs atoms"),
        (READY | MOVED_ATOMS, "'atoms moved 0.1 Å', but proteins.a is a ready surface"),
        (OWN | {"pages": ["tdp43"]}, "pages is for a study with `batch`, and this one gives every protein"),
        (MIXED | {"changes": {"s": ["tdp43", "a"]}}, "changes.s: 'a' is a ready surface without residues"),
        (OWN | {"changes": {"s": ["tdp43/c1", "tdp43/c1"]}}, "changes.s: 'tdp43/c1' is on both sides"),
        (OWN | {"patches": {"D_link": 4.0}}, "patches.D_link is 4 Å, but must be smaller than R_patch and"),
        (
            OWN | {"patches": {"D_link": 3.0, "R_zernike": 3.0, "R_patch": 4.0}},
            "patches.D_link is 3 Å, but must be smaller than R_patch and R_zernike.",
        ),
    ],
)
def test_keys_that_exclude_each_other_are_refused(config, said):
    refuse(config, re.escape(said))


@pytest.mark.parametrize(
    "config",
    [
        OWN | {"compare": {"samplers": ["poisson", "farthest"]}},
        READY | {"compare": {"samplers": ["poisson", "uniform"]}},
        OWN | {"paper": "tdp43"},
        READY | {"paper": "a", "frames": {"selection": [0, 7]}},  # has no frames
        {"proteins": {"a": STRUCTURE | {"simulate": {"ns": 1}, "ligands": False}}},
        {"proteins": {"a": FETCHED}},
        MIXED | {"ensemble": {"run": True}, "fields": ["hydropathy"]},
        READY | {"minimal": {"floor": "turned"}},
        OWN | MOVED_ATOMS,
    ],
)
def test_keys_that_go_together_are_taken(config):
    assert check_config(config)


def test_a_combination_stands_without_another_sampler():
    own = {"combination": [1.0, 0.0, 6.0, 0.0]}
    for sampler in ({}, {"sampler": "paper"}, {"sampler": "paper_corrected"}):
        checked = check_config(DEFAULT | {"minimal": own | sampler})
        assert checked["minimal"] == own | {"sampler": "paper"} | sampler
        assert check_config(checked) == checked
    for sampler in ("farthest", "uniform"):
        with pytest.raises(InputError) as error:
            check_config(DEFAULT | {"minimal": own | {"sampler": sampler}})
        assert str(error.value) == (
            f"config: minimal.sampler is {sampler}, but minimal.combination belongs to the paper's; remove one of the two."
        )


def test_the_grid_is_the_papers_unless_reported():
    values = (
        [0.1, 0.2, 0.4, 0.6, 0.8, 1.0],
        [0, 0.2, 0.4, 0.6, 0.8, 1.0],
        list(range(0, 11, 2)),
        list(range(0, 11, 2)),
    )
    found = check_config({"proteins": DEFAULT["proteins"]})["sampling"]
    assert tuple(found[key] for key in ("alpha", "beta", "gamma", "delta")) == values


@pytest.mark.parametrize(
    "path, value, whole",
    [
        ("seed", 1.0, 1),
        ("evaluation.draws", 2.0, 2),
        ("evaluation.test_dots", 40.0, 40),
        ("tables.ranges", 3.0, 3),
        ("minimal", {"n_S": 100.0}, 100),
        ("frames.clusters", 4.0, 4),
        ("frames.selection", [0.0, 7.0], [0, 7]),
        ("proteins.tdp43.model", 1.0, 1),
    ],
)
def test_a_whole_number_may_have_a_point(path, value, whole):
    config = changed(path, value)
    if path.endswith("model"):
        del config["proteins"]["tdp43"]["trajectory"]
    found = check_config(config)
    for key in path.split("."):
        found = found[key]
    found = found["n_S"] if isinstance(found, dict) else found
    assert found == whole and "." not in str(found)


def test_defaults_that_are_written_out_or_moved_change_nothing():
    bare = check_config({"proteins": DEFAULT["proteins"], "patches": {"R_patch": 5.0}})
    patches = {"D_link": 0.5, "R_zernike": 6, "R_patch": 5.0}
    told = check_config({"patches": patches, "proteins": DEFAULT["proteins"], "frames": {"stride": 1}})
    assert repr(told) == repr(bare)


def test_exponents_stay_as_they_are():
    assert str(check_config(changed("sampling.gamma", [2.0]))["sampling"]["gamma"]) == "[2.0]"


def test_more_memory_than_the_machine_has_is_reported_before_anything_runs(monkeypatch):
    monkeypatch.setattr(memory, "memory_of_machine", lambda: 2.0**30)
    evaluation = {"draws": 3, "test_dots": 400}
    check_config(DEFAULT | {"evaluation": evaluation})
    refuse(
        DEFAULT | {"evaluation": evaluation | {"draws": 1000}},
        r"need 23\.2 GB of memory .*, but this machine has 1\.0 GB",
    )
    check_config(DEFAULT | {"evaluation": evaluation | {"draws": 1000}}, here=False)  # jobs run elsewhere
    check_config(changed("evaluation.test_dots", "published"))


@pytest.mark.parametrize(
    "name", ["summary.csv", "Verdict.HTML", "logs", "Logs", "PAIRS", "compare.png", "report.html", "x.json"]
)
def test_a_protein_is_not_called_like_a_file_of_the_run(name):
    refuse({"proteins": {name: DEFAULT["proteins"]["tdp43"]}}, "is a file or folder of the study itself")


def test_no_file_or_folder_of_a_run_can_be_the_name_of_a_protein(study):
    own = yaml.safe_load((study / "config.yaml").read_text())["proteins"]
    names = {path.name for path in (study / "results" / "small").iterdir()} - own.keys()
    assert len(names) > 20
    for name in names:
        refuse({"proteins": {name: DEFAULT["proteins"]["tdp43"]}}, "is a file or folder of the study itself")


def test_a_run_is_not_called_like_a_file_in_results():
    refuse(changed("run", "README.md"), r"results/README\.md is a file; choose another name")


def test_a_template_that_snakemake_would_run_is_refused():
    refuse(DEFAULT | {"__use_yte__": True}, "unknown key '__use_yte__'")


def test_names_are_those_of_the_library():
    assert (*SAMPLERS,) == names.SAMPLERS
    assert tuple(name for name in SAMPLERS if SAMPLERS[name].choosing) == names.SAMPLERS_OF_COMBINATIONS
    assert (*ROUGHNESS,) == names.ROUGHNESSES and (*DESCRIPTORS,) == names.DESCRIPTORS
    assert (*FIELDS,) == names.FIELDS
    readable = [suffix for file_format in FORMATS for suffix in file_format.suffixes]
    assert sorted(names.SURFACE_SUFFIXES) == sorted(readable)
    assert {"fresh dots", "turned"} < {*names.FLOORS}


def test_a_protein_says_where_it_is_from_how_it_is_read():
    config = {"proteins": {"a": {"pdb": "1ubi", "chains": ["A"], "ligands": True}, "b": {"surface": "x.dms"}}}
    a, b = proteins(config).values()
    assert a.source.endswith("/1UBI.cif.gz") and a.download == "1UBI.cif.gz" and a.files == {}
    assert a.molecule_options == {"chains": ["A"], "ligands": True}
    assert b.source is None and b.download is None and b.molecule_options == {} and b.surface == "x.dms"
    assert Protein(structure="x.gro", trajectory="x.xtc").files == {
        "structure": "x.gro",
        "trajectory": "x.xtc",
    }
    assert Protein(structure="x.pdb", table="t.csv").files == {"structure": "x.pdb"}
    asked = {"selection": "all", "chains": ["A"], "residues": "1-9", "model": 2, "altloc": "B"}
    asked |= {"hydrogens": "remove", "ligands": True}
    assert Protein(structure="x.pdb", **asked).file_options == asked
    assert Protein(surface="x.dms", model=1, trajectory="t.xtc").keys_of_atoms == ["model", "trajectory"]
    simulated = Protein(structure="x.pdb", residues="1-9", hydrogens="keep", simulate={})
    assert simulated.file_options == {
        "residues": "1-9",
        "hydrogens": "keep",
    } and simulated.molecule_options == {"hydrogens": "keep"}


@pytest.mark.parametrize(
    "content, words",
    [
        ("", "mine.yaml is empty; it must hold keys"),
        ("# only a comment\n", "mine.yaml is empty; it must hold keys"),
        ("- a\n- b\n", "mine.yaml holds a list; it must hold keys"),
        ("just a text\n", "mine.yaml holds no keys; it must hold keys"),
        ("42\n", "mine.yaml holds no keys"),
        ("run: a\n---\nrun: b\n", r"is not valid YAML in line 2: but found another document"),
        ("run: a\nfrom:\n\tx: 1\n", r"is not valid YAML in line 3: found character '\\t'"),
        (
            "run: a\nseed: !!python/object/apply:os.system [ls]\n",
            "is not valid YAML in line 2: could not determine",
        ),
        ("proteins:\n  p: {structure: a.pdb\nseed: 1\n", r"is not valid YAML in line"),
        (
            "proteins:\n  p: {structure: a.pdb}\n  p: {structure: b.pdb}\n",
            "the key 'p' occurs twice, .* in line 3;",
        ),
        (
            "proteins:\n  123: {structure: a.pdb}\n",
            "the key 123 in line 2 is not read as a string; put it in quotes",
        ),
        ("proteins:\n  yes: {structure: a.pdb}\n", "the key yes in line 2 is not read as a string"),
        ("a:\n  1.5: 2\n", "the key 1.5 in line 2"),
        ("? [1, 2]\n: 3\n", "the key of several parts in line 1"),
        ("a: &x {b: 1}\nc:\n  <<: *x\n  <<: *x\n", "the key '<<' occurs twice, again in line 4"),
        ("a: *nowhere\n", "is not valid YAML in line 1: found undefined alias"),
        ("run: a\nname: Grüße\n".encode("latin-1"), "is not UTF-8, see line 2"),
        (b"run: a\n\x00\x01\n", "is not valid YAML in line 2"),
        (b"\x89PNG\r\n\x1a\n\xff\xfe", "is not UTF-8, see line 1"),
        ("a: " + "[" * 5000, "mine.yaml is not valid YAML"),
        ("seed: 2024-99-99\n", "is not valid YAML: month must be in 1..12"),
        ("seed: " + "9" * 5000, "is not valid YAML"),
        ("proteins: &x {a: *x}\n", "its aliases stand for more than 40000 values"),
        ("seed: 1:30\n", "1:30 in line 1 is the number 90 in YAML"),
        ("a: 1\nresidues: [10:52]\n", "10:52 in line 2 is the number 652"),
        ("seed: -010\n", "-010 in line 1 is the number -8"),
        ("a: 1:30.5\n", "is the number 90.5"),
        ("a: [" + "0.5, " * 50_000 + "]", "it has more than 40000 values"),
        ("a: " + "x" * 2**21, "or 2097152 bytes"),
    ],
)
def test_a_file_that_is_no_config_is_one_sentence(tmp_path, content, words):
    path = tmp_path / "mine.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError, match=words) as error:
        read_config(path)
    assert "\n" not in str(error.value)


def test_numbers_in_plain_digits_stay_numbers(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("a: [0, -7, 1_000, 0x1F, 0.50, 1.5e+3, .5, '1:30', 10-52, A:10-52, 1:a]")
    assert read_config(path)["a"] == [0, -7, 1000, 31, 0.5, 1500, 0.5, "1:30", "10-52", "A:10-52", "1:a"]


@pytest.mark.parametrize("residues", ["209", "A:209-222", " 209-212A, B:-5--3 ,:7", "AA:1,-5-3"])
def test_residues_may_be_ranges_of_chains_or_of_all(residues):
    assert (
        check_config(changed("proteins.tdp43.residues", residues))["proteins"]["tdp43"]["residues"]
        == residues
    )


def test_all_mistakes_are_reported_at_once():
    wrong = {"seed": -1, "draws": 3, "patches": {"R_patch": 0}, "proteins": {"a/b": {"pdb": 453}}}
    with pytest.raises(InputError) as error:
        check_config(wrong)
    assert str(error.value).count("\n") == 4


def test_of_many_mistakes_the_first_are_reported():
    with pytest.raises(InputError) as error:
        check_config(DEFAULT | {"compare": {"run": True, "percents": [*range(101, 200)]}})
    assert str(error.value).count("\n") == 20 and str(error.value).endswith(" 79 more mistakes.")


def test_merge_keys_and_a_byte_order_mark_work(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("\ufeffproteins:\n  a: &a {structure: x.pdb, model: 1}\n  b: {<<: *a, model: 2}\n")
    assert read_config(path)["proteins"]["b"] == {"structure": "x.pdb", "model": 2}


def test_a_config_that_is_not_there_or_no_file_is_one_sentence(tmp_path):
    for path in (tmp_path, tmp_path / "none.yaml"):
        with pytest.raises(InputError, match=r"cannot be read"):
            read_config(path)


def test_structures_come_by_id_from_a_folder_where_it_is_named(tmp_path, monkeypatch):
    for name in ("1ABC.cif.gz", "1abcd.pdb", "2xyz.pdb", "4530.pdb"):
        (tmp_path / name).write_text("")
    monkeypatch.setenv("SPARSURF_STRUCTURES", str(tmp_path))
    listed = {
        "a": {"pdb": "1abc", "model": 1},
        "b": {"pdb": "2XYZ", "sha256": "0" * 64},
        "c": {"pdb": "3enl"},
        "d": {"pdb": 4530},
        "e": {"pdb": 4531},
    }
    found = check_config({"proteins": listed})["proteins"]
    assert found["a"] == {"structure": str(tmp_path / "1ABC.cif.gz"), "model": 1}
    assert found["b"] == {"structure": str(tmp_path / "2xyz.pdb")}
    assert found["c"] == {"pdb": "3enl"}
    assert found["d"] == {"structure": str(tmp_path / "4530.pdb")} and found["e"] == {"pdb": "4531"}
    for wrong in (45.3, ["1abc"], None):
        refuse({"proteins": {"a": {"pdb": wrong}}}, r"proteins.a.pdb is .*, but must be a string")
    monkeypatch.setenv("SPARSURF_STRUCTURES", str(tmp_path / "none"))
    refuse({"proteins": listed}, r"SPARSURF_STRUCTURES is '.*none', but there is no such folder")


@pytest.mark.parametrize("name", ["dots.csv.gz", "dots.PLY"])
def test_a_local_surface_in_place_of_a_structure_may_be_packed_or_in_capitals(tmp_path, monkeypatch, name):
    (tmp_path / name).write_text("")
    monkeypatch.setenv("SPARSURF_A", str(tmp_path / name))
    found = check_config({"proteins": {"a": {"pdb": "1abc", "model": 1}}})["proteins"]
    assert found == {"a": {"surface": str(tmp_path / name)}}


def test_the_study_of_proteins_lists_ids_once_with_one_convention_for_hydrogens():
    proteins = listing.from_table(ROOT / "studies" / "proteins.csv")
    assert len(proteins) >= 30 and len({entry["pdb"] for entry in proteins.values()}) == len(proteins)
    assert {entry["hydrogens"] for entry in proteins.values()} == {"remove"}
