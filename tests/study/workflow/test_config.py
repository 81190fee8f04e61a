"""The config: defaults, and one sentence for every kind of mistake."""

import copy
import datetime
import json
import re

import pytest
import yaml

import config_reference
from conftest import ROOT
from sparsurf import registry
from sparsurf.errors import InputError
from sparsurf_study.config import memory
from sparsurf_study.config.check import Protein, check_config, read_config, with_absolute_paths

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
    given = {"minimal": {"n_dots": 100}, "evaluation": {"draws": 2}}
    assert check_config({}) == check_config(DEFAULT)
    monkeypatch.chdir(tmp_path)  # whose folder has no config.yaml
    refuse(given, "key 'proteins'")
    whole = check_config(given, home=ROOT)
    assert whole["minimal"]["n_dots"] == 100 and whole["evaluation"]["test_dots"] == 200
    assert whole["proteins"]["tdp43"]["structure"] == str(ROOT / "data" / "tdp43" / "topology.pdb")
    for own in (False, True):  # a file that lies in both places is that of the working folder
        (tmp_path / "README.md").write_text("") if own else None
        ready = check_config({"proteins": {"a": {"surface": "README.md"}}}, home=ROOT)["proteins"]["a"]
        assert ready["surface"] == ("README.md" if own else str(ROOT / "README.md"))
    (tmp_path / "config.yaml").write_text("run: own\nproteins: {a: {pdb: 1ubi}}\n")
    own = check_config({"seed": 5})
    assert (own["run"], own["proteins"], own["seed"]) == ("own", {"a": {"pdb": "1ubi"}}, 5)
    assert check_config({"proteins": {"b": {"pdb": "1fas"}}}, home=ROOT)["run"] == "default"


def test_a_prefix_of_another_workflow_leaves_all_input_files_where_they_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    files = {"structure": "a.pdb", "trajectory": "in/a.xtc", "table": "a.csv"}
    config = {
        "proteins": {"a": files | {"residues": "1-3"}, "b": {"surface": "/data/b.npz"}, "c": {"pdb": "1ubi"}}
    }
    config["pairs"] = {
        "p": {"files": ["a.pdb", "b.pdb"]}, "q": {"complex": "q.pdb", "chains": [["A"], ["B"]]}, "r": {"proteins": ["a", "b"]}
    }  # fmt: skip
    found = with_absolute_paths(config | {"seed": 3})
    absolute = {key: str(tmp_path / path) for key, path in files.items()}
    proteins = {"a": absolute | {"residues": "1-3"}, "b": {"surface": "/data/b.npz"}, "c": {"pdb": "1ubi"}}
    pairs = config["pairs"] | {"p": {"files": [str(tmp_path / "a.pdb"), str(tmp_path / "b.pdb")]}}
    pairs["q"] = config["pairs"]["q"] | {"complex": str(tmp_path / "q.pdb")}
    assert found == {"proteins": proteins, "pairs": pairs, "seed": 3}


def test_an_id_of_the_pdb_is_the_address_of_its_mmcif_file():
    own, other = Protein(pdb="1ubi"), Protein(url="https://a.org/x/b.pdb?c=1")
    assert own.source == "https://files.rcsb.org/download/1UBI.cif.gz" and own.download == "1UBI.cif.gz"
    assert (other.source, other.download) == ("https://a.org/x/b.pdb?c=1", "b.pdb")
    local = Protein(
        structure="a.pdb", chains=["B"], ligands=True, hydrogens="remove", sampling=False, table="t.csv"
    )
    assert local.source is local.download is None and local.keys_of_atoms == []
    assert local.file_options == {"chains": ["B"], "ligands": True, "hydrogens": "remove"}  # no others
    assert {*Protein(surface="a.npz", chains=["B"], table="t", sampling=True).keys_of_atoms} == {
        "chains",
        "table",
    }


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
    """Run `make schema` to write them."""
    text = config_reference.SCHEMA_FILE.read_text(encoding="utf-8")
    assert json.loads(text) == config_reference.json_schema()
    assert config_reference.REFERENCE_PAGE.read_text(encoding="utf-8") == config_reference.reference_page()


DEFAULT_FILE = ROOT / "config" / "config.yaml"  # which a deployed workflow copies with its folder


def test_the_default_config_of_a_clone_is_that_of_a_deployed_workflow():
    assert (ROOT / "config.yaml").samefile(DEFAULT_FILE)


@pytest.mark.parametrize("path", [DEFAULT_FILE, *sorted((ROOT / "studies").glob("*.yaml"))])
def test_every_study_is_valid_and_names_its_schema(path, monkeypatch):
    monkeypatch.setattr(memory, "memory_of_machine", lambda: float("inf"))
    schema = "schema.json" if path == DEFAULT_FILE else "../config/schema.json"
    assert path.read_text().startswith(f"# yaml-language-server: $schema={schema}\n")
    config = read_config(path)
    if config.get("pairs") == {"folder": "data/complexes/bound"}:
        del config["pairs"]  # these files are not part of the repository
    assert check_config(config, [path])["run"] == config.get("run", path.stem)


TOPOLOGY = {"structure": "data/tdp43/topology.pdb"}
MISTAKES = [  # key, value, a word of the remedy
    ("sampling.alpha", [0.5, 1.5], "alpha.1 is 1.5"),
    ("sampling.beta", [k / 100 for k in range(101)], "100 or fewer"),
    ("sampling.gamma", [], "list of 1 or more"),
    ("sampling.delta", [2, 2], "twice"),
    ("evalution", {}, "unknown key 'evalution' in the config; did you mean 'evaluation'?"),
    ("changes", {"S": ["tdp43/c1", "tdp43/c2"], "s": ["tdp43/c1", "tdp43/c3"]}, "upper and lower case"),
    ("changes", {"x.csv": ["tdp43/c1", "tdp43/c2"]}, "of the study itself"),
    ("pairs", {"p": {"proteins": ["a", "tdp43"]}}, "'a' is none of the proteins; these are tdp43"),
    ("proteins.tdp43.plddt", 70, "trajectory or a simulation"),
    ("draws", 3, "belongs to evaluation"),
    ("plddt", "high", "whose pLDDT is lower)"),  # the first sentence on the key
    ("complementarity.centres", {"n_dots": 5}, "centres lacks the key 'sampler'"),
    ("ensemble.jobs", 8, "delete the key, and pass `--set-scatter frames=8`"),
    ("proteins.tdp43.pdbfile", "a.pdb", "did you mean 'structure'?"),
    ("proteins.tdp43.CIF", "a.cif", "did you mean 'structure'?"),
    ("patches.path", "a.pdb", "did you mean 'r_patch'?"),
    ("proteins.tdp43.zzzz", 1, "unknown key 'zzzz' in proteins.tdp43; the keys here are structure"),
    ("proteins.tdp43", 5, "must be a mapping of keys to values, such as {structure: ...} ("),
    ("proteins.tdp43.structure", "", "a string that is not empty"),
    ("sampling.alpha", 0.5, "a list in square brackets"),
    ("pairs", {"q": {"files": ["a", "b"], "proteins": ["a", "b"]}}, "pairs.q needs exactly one"),
    ("pairs", {"q": {"files": ["a", "b"], "chains": [["A"], ["B"]]}}, "pairs.q needs exactly one"),
    ("proteins", {}, "is empty"),
    ("proteins.tdp43.structure", "no/such.pdb", f"paths start at {ROOT}"),
    ("proteins.tdp43.structure", "config.yaml/a.pdb", "unpack an archive"),
    ("proteins.tdp43.structure", "a<x>b/s.pdb", "wildcard of Snakemake"),
    ("proteins.tdp43.surface", "x.dms", "exactly one of 'structure'"),
    ("proteins.TDP43", TOPOLOGY, "upper and lower case"),
    ("proteins.tdp43.simulate", {"water": "../tip3p"}, "simulate.water"),
    ("proteins", {"..": TOPOLOGY}, "cannot name a folder"),
    ("proteins", {1: TOPOLOGY}, "the key 1 in proteins is"),
    ("proteins", {"a": TOPOLOGY | {"ligands": ["XK2", False]}}, "ligands.1 is False"),
    ("proteins", {"a": {"pdb": "1ubi\n"}}, "proteins.a.pdb"),
    ("proteins", {"a": {"pdb": 453}}, "of the form 1ubi"),
    ("proteins", "none.csv", "no such table"),
    ("run", "../elsewhere", "cannot name a folder"),
    ("run", "README.md", "choose another name"),
    ("run", datetime.date(2026, 1, 2), "in quotes"),
    ("patches.d_link", 5.0, "smaller than r_patch"),
    ("evaluation.draws", 100_000_000, "10000 or less"),
    ("frames.selection", [0, "a"], "selection.1 is 'a'"),
    ("frames", None, "a mapping"),
    ("complementarity.centres", {"sampler": "farthest", "n_dots": 5, "percent": 5}, "exactly one of"),
    ("compare.percents", [120], "less than 100"),
    ("tables.max_n_S_percent", 0, "is 0, but must be 1 or more"),
    ("tables.max_n_S_percent", 101, "is 101, but must be 100 or less"),
    ("tables.max_n_S_percent", "20 %", "is '20 %', but must be a number"),
    ("fields", ["hydropaty"], "did you mean 'hydropathy'?"),
    ("minimal", {"n_dots": 5, "max_z": 1.0}, "but has n_dots, max_z"),
    ("pairs", {"q": {"complex": "x.pdb"}}, "pairs.q needs exactly one"),
    ("paper", "none", "none of the proteins tdp43"),
    ("ensemble.combination", [0, 1, 1, 1], "alpha"),
    ("changes", {"s": ["a/x/2", "b"]}, "my_protein/c2"),
    ("changes", {"s": ["a", "tdp43"]}, "none of the proteins"),
    ("minimal.sampler", "mine", " or one of an installed package"),
    ("fields", ["mine"], "hbond or one of an installed package"),
    ("evaluation.readings", ["mine"], "one of kept, kept_scaled, full, recovered ("),
    ("exclude", {"tdp43": 3}, "a string"),
    ("__use_yte__", True, "unknown key"),  # a template that Snakemake would run
]


@pytest.mark.parametrize(("path", "value", "word"), MISTAKES)
def test_a_mistake_is_answered_with_the_key_and_the_remedy(path, value, word):
    with pytest.raises(InputError) as error:
        check_config(changed(path, value))
    assert word in str(error.value) and all(key in str(error.value) for key in path.split("."))


def test_a_field_may_be_a_column_of_every_table(tmp_path, monkeypatch):
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
    of_a = {"proteins": {"a": entries["a"]}}
    for config, key, words in (
        ({"proteins": entries, "fields": ["other"]}, "fields.0", "hydropathy, potential"),
        ({"proteins": {"c": plain}, "fields": ["potential", "score"]}, "fields.1", "'score'"),
        ({"proteins": taken, "fields": ["points"]}, "fields.0", "hydropathy, potential"),
        (of_a | {"fields": ["potential"]}, "table", "none of its columns"),
        (of_a | {"fields": [["score"]]}, "fields.0", "['score']"),
        ({"proteins": {"a": {"surface": "x.dms", "table": "t.csv"}}}, "table", "remove"),
        ({"proteins": {"a": plain | {"table": "no.csv"}}}, "proteins.a.table", "no file 'no.csv'"),
        ({"proteins": {"a": plain | {"table": 3}}, "fields": ["score"]}, "proteins.a.table", "is 3"),
    ):
        with pytest.raises(InputError) as error:
            check_config(config)
        assert key in str(error.value) and words in str(error.value)
    score = registry.Choice(lambda molecule, points: ..., "s", package="mine 1.0")
    monkeypatch.setitem(registry._registered["field"], "score", score)
    monkeypatch.setattr(registry, "_plugins_in_use", {})
    with pytest.raises(InputError, match=r"mine 1\.0"):
        check_config(of_a | {"fields": ["score"]})


def test_the_minimal_subset_has_an_error_where_no_other_wish_is_given():
    for own in ({"sampler": "poisson"}, {}):
        assert check_config(DEFAULT | {"minimal": own})["minimal"] == DEFAULT["minimal"] | own
    assert "error" not in check_config(DEFAULT | {"minimal": {"n_dots": 9}})["minimal"]


FORMS = {
    "moving": DEFAULT["proteins"]["tdp43"],
    "still": {"structure": DEFAULT["proteins"]["tdp43"]["structure"]},
    "ready": {"surface": "README.md"},  # any file: it is not read
}
PAIR_OF_FILES = {"pairs": {"ab": {"files": ["data/tdp43/topology.pdb", "README.md"]}}}


def test_what_is_excluded_is_a_part_of_the_study():
    plain = {"proteins": DEFAULT["proteins"] | {"kept": DEFAULT["proteins"]["tdp43"]}}
    for place in ("tdp43", "tdp43/c2", "tdp43/*"):
        assert check_config(plain | {"exclude": {place: "why"}})["exclude"] == {place: "why"}
        assert check_config(plain | {"exclude": [place]})["exclude"] == {place: ""}
    unknown = ["tdp34", "tdp34/c2", "tdp43/foo", "tdp43/c99x", "pairs/ab", "changes/x", "pairs"]
    for place in (*unknown, "tdp43/c1/draw_view", "summarise_run"):
        refuse(
            plain | {"exclude": {place: "why"}},
            rf"exclude: '{re.escape(place)}' is not part of the study; remove it",
        )


def test_conformations_that_are_excluded_exist_as_far_as_they_are_known():
    chosen = {"proteins": {"a": FORMS["moving"], "b": FORMS["still"]}, "frames": {"selection": [0, 97]}}
    refuse(chosen | {"exclude": ["a/f96"]}, "exclude: there is no 'a/f96'; a has f0, f97")
    refuse(chosen | {"exclude": ["b/f97"]}, "exclude: there is no 'b/f97'; b has f0")
    refuse(chosen | {"exclude": ["b/c1"]}, "exclude: there is no 'b/c1'; b has f0")
    assert check_config(chosen | {"exclude": ["a/f0097", "b/f00"]})
    clustered = {"proteins": chosen["proteins"], "exclude": ["a/c7"]}
    assert check_config(clustered)  # how many clusters there are is known later
    refuse(clustered | {"exclude": ["b/c2"]}, "exclude: there is no 'b/c2'; b has c1")


def test_forms_that_the_structures_lack_are_named_before_any_job():
    own = {"structure": str(ROOT / "data" / "tdp43" / "topology.pdb")}
    both = {"proteins": {"a": own, "b": own}}
    refuse(both | {"changes": {"s": ["a/c2", "b"]}}, "changes.s: there is no 'a/c2', as a has a single form")
    assert check_config(both | {"changes": {"s": ["a", "b/c1"]}})["changes"] == {"s": ["a", "b/c1"]}
    both["proteins"]["a"] = own | {"trajectory": str(ROOT / "data" / "tdp43" / "trajectory.xtc")}
    assert check_config(both | {"changes": {"s": ["a/c7", "b"]}})  # known once frames are chosen
    both["frames"] = {"selection": [0, 97]}
    refuse(both | {"changes": {"s": ["a/f00", "a/f96"]}}, "changes.s: there is no 'a/f96'; a has f0, f97")
    assert check_config(both | {"changes": {"s": ["a/f00", "a/f0097"]}})


@pytest.mark.parametrize(
    ("proteins", "keys", "left_out", "kept"),
    [
        (["moving"], {}, ["moving"], ["moving/c1"]),  # how many clusters there are is known later
        (["moving"], {"frames": {"selection": [700, 0]}}, ["moving/f0700", "moving/f0"], ["moving/f0"]),
        (["still", "moving"], {}, ["still/c01", "moving"], ["still/c01", "moving/c2"]),
        (["still"], {"frames": {"selection": "all"}}, ["still/f0"], ["still/*"]),
        (["still", "ready"], {}, ["still", "ready/c1"], ["still/*", "ready"]),
        (["still"], PAIR_OF_FILES, ["still", "pairs/ab"], ["still"]),
    ],
)
def test_a_study_of_which_everything_is_excluded_is_refused(proteins, keys, left_out, kept):
    config = {"proteins": {name: FORMS[name] for name in proteins}} | keys
    refuse(config | {"exclude": left_out}, "exclude leaves nothing")
    assert [*check_config(config | {"exclude": kept})["exclude"]] == kept


@pytest.mark.parametrize(
    ("forms", "selection"),
    [
        (["still", "still/c1"], "clusters"),
        (["moving/c01", "moving/c1"], "clusters"),
        (["moving", "moving/c1"], "clusters"),
        (["moving/f0000", "moving"], "all"),
        (["moving", "moving/f0700"], [700, 0]),
    ],
)
def test_a_form_is_not_compared_with_itself_by_another_name(forms, selection):
    config = {"proteins": FORMS, "frames": {"selection": selection}}
    refuse(config | {"changes": {"s": forms}}, rf"changes.s: '{forms[0]}' is on both sides")
    other = "moving/f0" if selection == [700, 0] else "moving/c2" if selection == "clusters" else "moving/f1"
    assert check_config(config | {"changes": {"s": [forms[1], other]}})


@pytest.mark.parametrize("share", [0.7, 1, 1.0, 0.01])
def test_a_share_is_no_bound_of_plddt(share):
    words = f"is {share:g}, which looks like a share; pLDDT runs from 0 to 100, so give {100 * share:g}"
    refuse({"proteins": {"still": FORMS["still"]}, "plddt": share}, f"config: plddt {words}")
    refuse({"proteins": {"still": FORMS["still"] | {"plddt": share}}}, rf"proteins\.still\.plddt {words}")
    for bound in (0, 1.5, 70):
        assert check_config({"proteins": {"still": FORMS["still"]}, "plddt": bound})["plddt"] == bound


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
        "pairs/ab needs 'b'",
    )


READY = {"proteins": {"a": {"surface": "README.md"}}}  # any file: it is not read
MIXED = {"proteins": READY["proteins"] | DEFAULT["proteins"]}
FETCHED = {"url": "https://a.org/b.pdb", "sha256": 64 * "0"}
OWN = {"proteins": DEFAULT["proteins"]}
COMPARE = {"compare": {"samplers": ["farthest"]}}


def of_a(**keys):
    """A config of one structure with further keys."""
    return {"proteins": {"a": TOPOLOGY | keys}}


def pair_of(**keys):
    """A config of one pair."""
    return {"pairs": {"p": keys}}


@pytest.mark.parametrize(
    ("config", "key", "words"),
    [
        (OWN | {"sampling": False, "compare": True}, "sampling", "`compare` needs its grid"),
        (OWN | {"sampling": False, "paper": "tdp43"}, "sampling", "`paper` needs the grid of tdp43"),
        (of_a(sampling=False) | {"compare": True}, "sampling", "`compare` needs its grid"),
        (of_a(sampling=True) | {"pages": [], "sampling": False}, "pages", "`sampling: false`"),
        (PAIR_OF_FILES | {"compare": True}, "compare.run", "no surfaces to sample"),
        (OWN | COMPARE, "compare.samplers", "farthest alone"),
        (
            READY | {"compare": {"samplers": ["poisson", "paper"]}},
            "proteins.a",
            "neither uniform nor farthest",
        ),
        (OWN | {"paper": "tdp43", "tables": {"ranges": 5}}, "tables.ranges", "`paper` has 10"),
        (OWN | {"paper": "tdp43", "tables": {"ranges": 12}}, "tables.ranges", "`paper` has 10"),
        (OWN | {"paper": "tdp43", "evaluation": {"readings": ["kept"]}}, "readings", "`paper` needs both"),
        (OWN | {"paper": "tdp43", "frames": {"selection": [0, 7]}}, "frames.selection", "`paper` compares"),
        (of_a(simulate={}, ligands=True), "ligands", "only the protein is simulated"),
        (of_a(simulate={}, ligands=["XK2"]), "ligands", "only the protein is simulated"),
        (of_a(simulate={}, trajectory="data/tdp43/trajectory.xtc"), "proteins.a", "asks to simulate one"),
        (of_a(sha256=64 * "0"), "proteins.a.sha256", "downloaded"),
        (READY | {"ensemble": {"run": True}}, "ensemble.run", "ready surface"),
        (READY | {"fields": ["hydropathy"]}, "fields", "needs atoms"),
        (OWN | {"pages": ["tdp43"]}, "pages", "`sampling: false`"),
        (MIXED | {"changes": {"s": ["tdp43", "a"]}}, "changes.s", "'a' is a ready surface"),
        (OWN | {"changes": {"s": ["tdp43/c1", "tdp43/c1"]}}, "changes.s", "on both sides"),
        (OWN | {"patches": {"d_link": 4.0, "r_patch": 4.0}}, "patches.d_link", "smaller than r_patch"),
        (OWN | {"patches": {"d_link": 3.0, "r_zernike": 3.0}}, "patches.d_link", "r_zernike"),
        (
            OWN | {"minimal": {"combination": [1, 0, 6, 0], "sampler": "uniform"}},
            "minimal.sampler",
            "remove one",
        ),
        (pair_of(complex="https://a.org/b.pdb", chains=[["A"], ["B"]]), "pairs.p", "is a URL; give a file"),
        (pair_of(complex="no.pdb", chains=[["A"], ["B"]]), "pairs.p", "there is no file 'no.pdb'"),
        (pair_of(files=["README.md", "no.pdb"]), "pairs.p", "there is no file 'no.pdb'"),
        (pair_of(complex="README.md"), "pairs.p", "chains"),
        (pair_of(complex="README.md", chains=[["A"], ["A", "B"]]), "pairs.p", "chain A is on both sides"),
        (pair_of(complex="README.md", chains=[["A"]]), "pairs.p", "must be a list of 2 or more"),
        (pair_of(files=["README.md", "README.md"]), "pairs.p", "is on both sides; name two partners"),
        (pair_of(proteins=["a", "b"]), "pairs.p", "'a' is none of the proteins; these are none"),
        (pair_of(file="README.md"), "pairs.p", "did you mean 'files'"),
        ({"proteins": {"summary.csv": TOPOLOGY}}, "summary.csv", "of the study itself"),
        ({"proteins": {"Verdict.HTML": TOPOLOGY}}, "Verdict.HTML", "of the study itself"),
        ({"proteins": {"PAIRS": TOPOLOGY}}, "PAIRS", "of the study itself"),
    ],
)
def test_keys_that_exclude_each_other_are_refused(config, key, words):
    for part in (key, words):
        refuse(config, re.escape(part))


@pytest.mark.parametrize(
    "config",
    [
        OWN | {"compare": {"samplers": ["poisson", "farthest"]}},
        READY | {"compare": {"samplers": ["poisson", "uniform"]}},
        READY | {"compare": {"samplers": ["poisson", "farthest"]}},
        PAIR_OF_FILES,
        OWN | {"paper": "tdp43"},
        READY | {"paper": "a", "frames": {"selection": [0, 7]}},  # has no frames
        of_a(simulate={"ns": 1}, ligands=False),
        {"proteins": {"a": FETCHED}},
        MIXED | {"ensemble": {"run": True}, "fields": ["hydropathy"]},
        READY | {"minimal": {"density": 0.6}},
    ],
)
def test_keys_that_go_together_are_taken(config):
    assert check_config(config)


def test_a_combination_stands_without_another_sampler():
    own = {"combination": [1.0, 0.0, 6.0, 0.0]}
    for sampler in ({}, {"sampler": "paper"}, {"sampler": "paper_corrected"}):
        checked = check_config(DEFAULT | {"minimal": own | sampler})
        assert checked["minimal"] == own | {"sampler": "paper", "reconstruction": "auto"} | sampler
        assert check_config(checked) == checked


@pytest.mark.parametrize(
    ("path", "value"), [("seed", 1.0), ("minimal.n_dots", 100.0), ("frames.selection", [0.0, 7.0])]
)
def test_a_whole_number_may_have_a_point(path, value):
    config = changed(path, value)
    config["minimal"].pop("error") if path == "minimal.n_dots" else None
    found = check_config(config)
    for key in path.split("."):
        found = found[key]
    assert found == value and "." not in str(found)


def test_defaults_that_are_written_out_or_moved_change_nothing():
    bare = check_config({"proteins": DEFAULT["proteins"], "patches": {"r_patch": 5.0}})
    patches = {"d_link": 0.5, "r_zernike": 6, "r_patch": 5.0}
    told = check_config({"patches": patches, "proteins": DEFAULT["proteins"], "frames": {"stride": 1}})
    assert repr(told) == repr(bare)


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
    grid = {"alpha": [1], "beta": [0, 1], "gamma": [0, 1, 2], "delta": [0, 1, 2, 3, 4]}
    for dots in (100, "published"):  # of a surface of 20,000 dots
        config = check_config(DEFAULT | {"sampling": grid, "evaluation": {"draws": 10, "test_dots": dots}})
        assert memory.memory_of_grid(config) == 8 * (2 * 3 * 5) * 10 * 100 * (2 + 4)


def test_a_key_that_occurs_twice_is_found_in_the_file_again(tmp_path):
    (tmp_path / "mine.yaml").write_text("seed: 1\nseed: 2\n")
    with pytest.raises(InputError, match="'seed' occurs twice"):
        check_config(DEFAULT, [tmp_path / "mine.yaml"])


def test_the_bound_of_plddt_is_that_of_each_structure_without_its_own():
    config = {"plddt": 60, "proteins": FORMS | {"own": FORMS["still"] | {"plddt": 40}}}
    found = check_config(config)["proteins"]
    assert {name: protein.get("plddt") for name, protein in found.items()} == {
        "moving": None,
        "still": 60,
        "ready": None,
        "own": 40,
    }


def test_no_file_or_folder_of_a_run_can_be_the_name_of_a_protein(study):
    own = yaml.safe_load((study / "config.yaml").read_text())["proteins"]
    names = {path.name for path in (study / "results" / "small").glob("[!.]*")} - own.keys()
    assert len(names) > 20
    for name in names:
        refuse({"proteins": {name: DEFAULT["proteins"]["tdp43"]}}, "study itself")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "is empty"),
        ("- a\n- b\n", "contains a list"),
        ("just a text\n", "contains no keys"),
        ("run: a\n---\nrun: b\n", "line 2: but found another document"),
        ("run: a\nseed: !!python/object/apply:os.system [ls]\n", "line 2: could not determine"),
        ("proteins:\n  p: {structure: a.pdb\nseed: 1\n", "not valid YAML in line"),
        ("proteins:\n  p: {structure: a.pdb}\n  p: {structure: b.pdb}\n", "'p' occurs twice, .* line 3"),
        ("proteins:\n  123: {structure: a.pdb}\n", "the key 123 in line 2 .* in quotes"),
        ("proteins:\n  yes: {structure: a.pdb}\n", "the key yes in line 2"),
        ("a: &x {b: 1}\nc:\n  <<: *x\n  <<: *x\n", "'<<' occurs twice, .* line 4"),
        ("run: a\nname: Grüße\n".encode("latin-1"), "not UTF-8, see line 2"),
        (b"run: a\n\x00\x01\n", "not valid YAML in line 2"),
        ("a: " + "[" * 5000, "not valid YAML"),
        ("seed: " + "9" * 5000, "not valid YAML"),
        ("seed: 1:30\n", "1:30 in line 1 is the number 90"),
        ("a: 1\nresidues: [10:52]\n", "10:52 in line 2 is the number 652"),
        ("a: [" + "0.5, " * 50_000 + "]", "more than 40000 values"),
        ("a: " + "x" * 2**21, "2097152 bytes"),
        ("a:\n" + "- [1, 2]\n" * 20_000, "more than 40000 values"),
        ("a: " + "[" * 5000, "nested too deeply"),
    ],
)
def test_a_file_that_is_no_config_is_one_sentence_with_the_line(tmp_path, content, words):
    path = tmp_path / "mine.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError, match=f"mine.yaml.*{words}") as error:
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


def test_all_mistakes_are_reported_at_once_but_of_many_the_first():
    wrong = {
        "seed": -1, "draws": 3, "patches": {"r_patch": 0}, "proteins": {"a/b": {"pdb": 453}},
        "evaluation": {"test_dots": 0},  # a number or a word: one mistake all the same
    }  # fmt: skip
    many = DEFAULT | {"compare": {"run": True, "percents": [*range(101, 200)]}}
    for config, n, end in ((wrong, 5, ""), (many, 20, " 79 more mistakes.")):
        with pytest.raises(InputError) as error:
            check_config(config)
        assert str(error.value).count("\n") == n and str(error.value).endswith(end)


def test_merge_keys_and_a_byte_order_mark_work(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("\ufeffproteins:\n  a: &a {structure: x.pdb, model: 1}\n  b: {<<: *a, model: 2}\n")
    assert read_config(path)["proteins"]["b"] == {"structure": "x.pdb", "model": 2}
    for path in (tmp_path, tmp_path / "none.yaml"):
        with pytest.raises(InputError, match=r"cannot be read"):
            read_config(path)


def test_structures_come_by_id_from_a_folder_where_it_is_named(tmp_path, monkeypatch):
    for name in ("1ABC.cif.gz", "1abcd.pdb", "2xyz.pdb", "4530.pdb"):
        (tmp_path / name).write_text("")
    monkeypatch.setenv("SPARSURF_STRUCTURES", str(tmp_path))
    listed = {
        "a": {"pdb": "1abc", "model": 0},
        "b": {"pdb": "2XYZ", "sha256": "0" * 64},
        "c": {"pdb": "3enl"},
        "d": {"pdb": 4530},
        "e": {"pdb": 4531},
    }
    found = check_config({"proteins": listed})["proteins"]
    assert found["a"] == {"structure": str(tmp_path / "1ABC.cif.gz"), "model": 0}
    assert found["b"] == {"structure": str(tmp_path / "2xyz.pdb")}
    assert found["c"] == {"pdb": "3enl"}
    assert found["d"] == {"structure": str(tmp_path / "4530.pdb")} and found["e"] == {"pdb": "4531"}
    for wrong in (45.3, ["1abc"], None):
        refuse({"proteins": {"a": {"pdb": wrong}}}, r"proteins.a.pdb is .*, but must be a string")
    monkeypatch.setenv("SPARSURF_STRUCTURES", str(tmp_path / "none"))
    refuse({"proteins": listed}, "SPARSURF_STRUCTURES is '.*none',")


@pytest.mark.parametrize("name", ["dots.csv.gz", "dots.PLY"])
def test_a_local_surface_in_place_of_a_structure_may_be_packed_or_in_capitals(tmp_path, monkeypatch, name):
    (tmp_path / name).write_text("")
    monkeypatch.setenv("SPARSURF_A", str(tmp_path / name))
    found = check_config({"proteins": {"a": {"pdb": "1abc", "model": 1}}})["proteins"]
    assert found == {"a": {"surface": str(tmp_path / name)}}
