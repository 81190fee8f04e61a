"""The config: defaults, and one sentence for every kind of mistake."""

import copy

import pytest
import yaml

from conftest import ROOT
from sparsurf import InputError
from sparsurf.config import SCHEMA, check, refuse_double_keys

DEFAULT = yaml.safe_load((ROOT / "config.yaml").read_text())


@pytest.fixture(autouse=True)
def at_root(monkeypatch):
    monkeypatch.chdir(ROOT)


def changed(path, value):
    config = copy.deepcopy(DEFAULT)
    *parents, last = path.split(".")
    place = config
    for key in parents:
        place = place.setdefault(key, {})
    place[last] = value
    return config


def test_the_default_config_is_valid_and_states_every_default():
    checked = check(DEFAULT, [ROOT / "config.yaml"])
    bare = check({"proteins": DEFAULT["proteins"]})
    assert {k: v for k, v in checked.items() if k != "run"} == {k: v for k, v in bare.items() if k != "run"}


def test_every_key_of_the_default_config_is_described():
    def walk(schema, values, path):
        for key, value in values.items():
            rule = schema["properties"][key]
            assert rule.get("description"), f"{path}{key} has no description"
            if isinstance(value, dict) and "properties" in rule:
                walk(rule, value, f"{path}{key}.")

    walk(SCHEMA, {k: v for k, v in DEFAULT.items() if k != "proteins"}, "")


@pytest.mark.parametrize(
    "path, value, words",
    [
        ("seed", "seven", ["seed is 'seven'", "type integer"]),
        ("seed", -1, ["seed is -1", "0 or more"]),
        ("sampling.alpha", [0.5, 1.5], ["sampling.alpha.1 is 1.5", "1 or less"]),
        ("sampling.alpha", [0.0], ["sampling.alpha.0 is 0.0", "more than 0"]),
        ("sampling.beta", [-0.2], ["sampling.beta.0 is -0.2", "0 or more"]),
        ("sampling.gamma", [], ["sampling.gamma is [], but needs at least 1 value"]),
        ("sampling.delta", [2, 2], ["sampling.delta holds a value twice"]),
        ("sampling.gama", [1], ["unknown key 'gama' in sampling", "did you mean 'gamma'?"]),
        ("evalution", {}, ["unknown key 'evalution'", "did you mean 'evaluation'?"]),
        ("proteins", {}, ["proteins is empty"]),
        (
            "proteins.tdp43.structure",
            "no/such.pdb",
            ["there is no file 'no/such.pdb'", "proteins.tdp43.structure"],
        ),
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
        ("evaluation.islands", ["kept", "both"], ["evaluation.islands.1 is 'both'", "kept, surface"]),
        ("evaluation.test_dots", "many", ["evaluation.test_dots is 'many'"]),
        ("frames.clusters", 0, ["frames.clusters is 0"]),
        ("tables.max_n_S_percent", 120, ["tables.max_n_S_percent is 120", "100 or less"]),
        ("surface.method", "msms", ["surface.method is 'msms'", "analytic, dms"]),
        ("patches", 7, ["patches is 7", "type object"]),
    ],
)
def test_a_mistake_is_answered_with_a_sentence(path, value, words):
    config = changed(path, value) if path != "proteins..." else DEFAULT | {"proteins": {"..": value}}
    with pytest.raises(InputError) as error:
        check(config)
    for word in words:
        assert word in str(error.value)


def test_a_config_without_proteins_is_refused():
    with pytest.raises(InputError, match="lacks the key 'proteins'"):
        check({"run": "x"})


def test_two_proteins_of_one_name_are_refused(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("proteins:\n  p: {structure: a.pdb}\n  p: {structure: b.pdb}\n")
    with pytest.raises(
        InputError, match=r"the key 'p' stands twice, the second time in line 3 of mine\.yaml"
    ):
        refuse_double_keys(path)


def test_broken_yaml_is_refused_with_its_line(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("proteins:\n  p: {structure: a.pdb\nseed: 1\n")
    with pytest.raises(InputError, match=r"mine\.yaml is not valid YAML in line"):
        refuse_double_keys(path)
