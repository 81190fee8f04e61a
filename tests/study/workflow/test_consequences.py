"""What follows from what: another value of a key changes its outputs and no others; rules follow from their code.

consequences.yaml holds the tables. Plans are dry runs of Snakemake; a job runs as Snakemake runs it, alone.
"""

import filecmp
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from pydantic import BaseModel

import warm_python
from conftest import ROOT
from peptides import peptide
from small_study import SETTINGS, changed, copy_of, planned_jobs, run_job, write_study
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.views.numbers import share
from sparsurf_study.batches.tables import read_parquet
from sparsurf_study.workflow.code_version import code_of
from sparsurf_study.workflow.models import Config, Pair, Protein

TABLES = yaml.safe_load(Path(__file__).with_name("consequences.yaml").read_text(encoding="utf-8"))
KEYS, SWITCHES, BATCH = (TABLES[name] for name in ("keys", "switches", "batch"))
WITHOUT_PAPER = (
    "tables.ranges",
    "evaluation.readings",
)  # which the comparison with the paper needs as they are
# Protein or pair of the job that runs; else `still` and `files`
PLACES = {"follow_frames": "moving", "choose_frames": "moving", "evaluate_grid": "moving"}


def rules_of(text):
    """Return the names of rules in a text that may name groups of them."""
    groups = TABLES["groups"]
    return {rule for name in text.split() for rule in (rules_of(groups[name]) if name in groups else [name])}


@pytest.fixture(scope="module")
def config(study):
    return yaml.safe_load((study / "config.yaml").read_text())


@pytest.fixture(scope="module")
def given(study, config):
    """What each job of the small study is given."""
    return plan(study, config)


def plan(folder, config):
    """Return what each job of a finished study would be given with another config, by rule and wildcards."""
    options = ("--rerun-triggers", "mtime", "--forcerun", "close_run")
    return by_rule(planned_jobs(folder, config, *options, all_jobs=True))


def by_rule(jobs):
    """Return the jobs that have a script by rule and wildcards."""
    return {(job["rule"], *job["wildcards"][1:]): job for job in jobs if job["script"]}


def rules_given_something_else(before, after):
    """Return the rules of jobs whose params or inputs differ."""
    both = [(job, kind) for job in before.keys() & after.keys() for kind in ("params", "input")]
    return {job[0] for job, kind in both if [*before[job][kind]] != [*after[job][kind]]}


def job_of(rule, jobs):
    """Return the job of a rule that is run."""
    places = {"files", PLACES.get(rule, "still")}
    of_rule = [job for job in jobs if job[0] == rule]
    return next((job for job in of_rule if places & {*job}), of_rule[0])


@pytest.fixture(scope="module")
def finished(study, tmp_path_factory):
    """Function that gives a folder with the outputs of a job: where the study does not keep one, the job has run again, once."""
    folders = {}

    def folder_of(job):
        if not all((study / path).exists() for path in job["output"]) and job["rule"] not in folders:
            folders[job["rule"]] = copy_of(study, tmp_path_factory.mktemp("before") / "own")
            assert run_job(folders[job["rule"]], job).returncode == 0
        return folders.get(job["rule"], study)

    return folder_of


def outputs_that_differ(study, folder, after):
    """Run a job as it is given with another config; return the names of its outputs that differ from those of the study."""
    folder = copy_of(study, folder)
    if run_job(folder, after).returncode:
        return {"fails"}
    names = {name: path for name, path in after["output"].items() if isinstance(path, str)}
    return {name for name, path in names.items() if differ(study / path, folder / path)}


def differ(path, other):
    """Return whether two files, or the files of two folders, differ in a byte."""
    if path.is_file():
        return not filecmp.cmp(path, other, shallow=False)
    names = {each.name for folder in (path, other) for each in folder.glob("[!.]*")}
    return {*filecmp.cmpfiles(path, other, names, shallow=False)[0]} != names


@pytest.mark.parametrize("key", KEYS)
def test_a_key_changes_its_outputs_and_no_others(study, config, given, finished, tmp_path, key):
    plain = {name: section for name, section in config.items() if name != "paper"}
    after = plan(study, changed(plain if key in WITHOUT_PAPER else config, key, KEYS[key]["value"]))
    new = set() if key in WITHOUT_PAPER else {job[0] for job in {*given} ^ {*after}}
    assert rules_given_something_else(given, after) | new == rules_of(KEYS[key]["rules"])
    expected, found = KEYS[key].get("outputs", {}), {}
    for rule in expected:
        job = job_of(rule, given)
        found[rule] = outputs_that_differ(finished(given[job]), tmp_path / rule, after[job])
    assert found == {rule: {*names.split()} for rule, names in expected.items()}


def test_a_job_reads_its_inputs_and_nothing_else(study, given):
    """As noted when the study ran. What it reads besides might be missing or old, and what it does not read be the wrong file."""

    def apart(paths, others):
        """Those of some paths that are neither among others, nor in a folder or folders of them."""
        whole = {str(part) for path in others for part in (path, *Path(path).parents)}
        return {p for p in paths if p not in whole and not {*map(str, Path(p).parents)} & {*others}}

    opened = {}
    for notes in (study / warm_python.OPENED).iterdir():
        rows = [line.split("\t") for line in notes.read_text().splitlines()]
        read, written = ({path for way, path in rows if way == mode} for mode in "rw")
        (log,) = (path for path in written if path.startswith("results/small/logs/"))
        opened[log] = apart(read - written, [".snakemake"])
    assert opened.keys() == {job["log"][0] for job in given.values()}
    for job in given.values():
        read, inputs = opened[job["log"][0]], {*job["input"]}
        unread = {path for path in apart(inputs, read) if not path.endswith(".xtc")}  # not read by Python
        if job["rule"] == "tabulate_pair_residues":  # it takes the atoms of partners alone
            unread = {path for path in unread if "/surface" not in path}
        if job["rule"] == "follow_ensemble":  # parts without a frame are empty
            unread = {path for path in unread if "/ensemble/" not in path}
        if (
            job["rule"] == "close_run"
        ):  # the warnings of all jobs, and checksums of the files that the config names
            inputs |= {"results/small/logs"} | {path for path in read if "/" not in path}
        assert not apart(read, inputs) and not unread, job["rule"]


@pytest.mark.parametrize("key", SWITCHES)
def test_a_key_adds_and_leaves_out_its_rules_and_no_others(study, config, given, key):
    after = plan(study, changed(config, key, SWITCHES[key]["value"]))
    assert {job[0] for job in {*given} - {*after}} == rules_of(SWITCHES[key]["gone"])
    assert rules_given_something_else(given, after) == rules_of(SWITCHES[key]["rules"])


def test_a_page_of_one_of_several_conformations_names_it(study, config, tmp_path):
    folder = copy_of(study, tmp_path / "own")
    frames = folder / "results/small/moving/frames.csv"
    text = frames.read_text().replace("f0000", "c1").replace("f0700", "c2")
    frames.unlink()
    frames.write_text(text)
    clusters = {"frames": {"clusters": 2}, "changes": {}, "pairs": {}, "paper": None}
    jobs = plan(
        folder, {name: section for name, section in (config | clusters).items() if section is not None}
    )
    titles = {job[1:]: jobs[job]["params"].title for job in jobs if job[0] == "draw_roughness"}
    assert titles[("moving", "c1")] == "moving/c1" and titles[("moving", "c2")] == "moving/c2"
    assert [titles[(name, "c1")] for name in ("still", "ready")] == ["still", "ready"]


def test_a_single_structure_is_not_several_frames(given):
    for rule in ("draw_frames", "draw_ensemble"):
        assert [job[1:] for job in given if job[0] == rule] == [("moving",)]


def test_the_papers_sampler_takes_the_best_of_its_surface(study, config, given):
    after = plan(study, changed(config, "minimal.sampler", "paper"))
    for job in [job for job in given if job[0] == "select_minimal_subset"]:
        best = f"results/small/{job[1]}/{job[2]}/ranges.csv"
        assert best not in given[job]["input"] and (best in after[job]["input"]) == (job[1] != "loaded")


def test_the_walls_of_a_cavity_are_of_no_residue(tmp_path):
    config = SETTINGS | {
        "sampling": False,
        "proteins": {"p": {"structure": str(ROOT / "data/tdp43/topology.pdb")}},
    }
    config |= {"frames": {"selection": [0]}, "minimal": {"n_dots": 50}, "surface": {"density": 3.0}}
    config |= {"patches": {"d_link": 0.8}}
    jobs = {job["rule"]: job for job in planned_jobs(tmp_path, config)}
    rules = "choose_single_frame compute_surface measure_roughness measure_floors select_minimal_subset tabulate_residues"
    for rule in rules.split():
        assert run_job(tmp_path, jobs[rule]).returncode == 0
    results = tmp_path / "results/small/p/f0"
    residues, roughness = (pd.read_csv(results / f"{name}.csv") for name in ("residues", "roughness"))
    dots, molecule = read_npz(results / "surface.npz"), read_molecule(results / "structure.pdb")
    outside = dots.fields["component"] == 0
    mean = roughness["roughness"][outside].groupby(molecule.residue_index[dots.atom[outside]]).mean()
    assert residues["dots"].sum() == len(dots) > outside.sum()
    assert np.allclose(residues["mean_roughness"][mean.index], mean)


def keys_of(model, prefix=""):
    """Yield the keys of a model of the config, those of its sections included."""
    for name, field in model.model_fields.items():
        if isinstance(field.default, BaseModel):
            yield from keys_of(type(field.default), f"{name}.")
        else:
            yield f"{prefix}{name}"


def test_every_key_of_the_config_has_its_consequences():
    keys = {*keys_of(Config)} - {"proteins", "pairs"} | {
        *keys_of(Protein, "proteins."),
        *keys_of(Pair, "pairs."),
    }
    rows = {re.sub(r"^(proteins|pairs)\.\w+|^(changes)\.bend", r"\1\2", key) for key in (*KEYS, *SWITCHES)}
    assert keys == rows | {*TABLES["elsewhere"]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the files of the small study, and no results."""
    write_study(folder := tmp_path_factory.mktemp("planned") / "study")
    return folder


@pytest.fixture(scope="module")
def simulated():
    """Config of a simulation."""
    water = {"structure": "two.pdb", "residues": "2-4", "simulate": {"ns": 0.01}}
    return SETTINGS | {"proteins": {"water": water}}


@pytest.fixture(scope="module")
def batch():
    """Config of two structures of unequal size in one batch, each with the same number of dots."""
    proteins = {
        "still": {"structure": "still.pdb", "table": "scores.csv"},
        "both": {"structure": "complex.pdb"},
    }
    config = {"run": "small", "sampling": {"run": False}, "pages": [], "proteins": proteins}
    config |= {"minimal": {"n_dots": 60}, "evaluation": {"test_dots": 20}}
    return config | {"fields": ["hydropathy", "score"]}


def test_every_rule_follows_from_the_code_of_its_script(study, config, folder, simulated, batch):
    jobs = [*plan(study, config).values()]
    for other in (simulated, batch):
        jobs += planned_jobs(folder, other, "--forceall")
    found = {
        job["rule"]: (Path(job["script"]).stem, job["params"].get("code")) for job in jobs if job["script"]
    }
    assert found.pop("fetch_structure") == ("fetch_structure", None)
    assert all(code == code_of(script) for script, code in found.values())
    assert len({code for _, code in found.values()}) > len(found) / 2
    texts = [path.read_text() for path in (ROOT / "Snakefile", *(ROOT / "rules").glob("*.smk"))]
    rules = re.findall(r"^ *(?:rule|checkpoint|use rule \w+ as) (\w+)\b", "\n".join(texts), re.M)
    assert found.keys() == {*rules} - {"all", "complete_protein", "fetch_structure"}


@pytest.mark.parametrize(
    ("key", "value", "rules"),
    [
        ("seed", 7, "prepare_system simulate_stage"),
        ("proteins.water.simulate.ns", 0.02, "prepare_system simulate_stage judge_simulation"),
        ("proteins.water.residues", "2-3", "prepare_system"),
        ("proteins.water.structure", "one.pdb", "prepare_system"),
    ],
)
def test_a_simulation_follows_the_keys_of_its_protein(folder, simulated, key, value, rules):
    configs = simulated, changed(simulated, key, value)
    before, after = (by_rule(planned_jobs(folder, config)) for config in configs)
    of_simulation = {"prepare_system", "simulate_stage", "judge_simulation"}
    assert rules_given_something_else(before, after) & of_simulation == {*rules.split()}
    for stage, earlier in (("nvt", "minimise"), ("npt", "nvt"), ("production", "npt")):
        assert before["simulate_stage", "water", stage]["input"][0].endswith(f"simulation/{earlier}")


@pytest.fixture(scope="module")
def analysed(folder, batch):
    """Folder of the finished batch, and its job."""
    jobs = {job["rule"]: job for job in planned_jobs(folder, batch) if job["script"]}
    for rule in ("analyse_batch", "summarise_batches"):
        process = run_job(folder, jobs[rule])
        assert process.returncode == 0, process.stderr
    return folder, jobs["analyse_batch"]


def job_of_batch(folder, config):
    """Return what the batch is given with a config."""
    jobs = planned_jobs(folder, config, "--forcerun", "analyse_batch", "--rerun-triggers", "mtime")
    return next(job for job in jobs if job["rule"] == "analyse_batch")


@pytest.mark.parametrize("key", BATCH)
def test_a_key_changes_its_tables_of_a_batch_and_no_others(analysed, batch, tmp_path, key):
    folder, before = analysed
    after = job_of_batch(folder, changed(batch, key, BATCH[key]["value"]))
    assert rules_given_something_else({("batch",): before}, {("batch",): after})
    assert outputs_that_differ(folder, tmp_path / "after", after) == {*BATCH[key]["outputs"].split()}


@pytest.mark.parametrize(
    ("key", "value"), [("evaluation.draws", 3), ("sampling.alpha", [1.0]), ("tables.ranges", 5)]
)
def test_a_batch_does_not_follow_the_keys_of_the_grid(analysed, batch, key, value):
    after = job_of_batch(analysed[0], changed(batch, key, value))
    assert not rules_given_something_else({("batch",): analysed[1]}, {("batch",): after})


def test_the_page_of_a_batch_has_the_share_of_all_dots(analysed):
    """Not the mean of the shares, which differs where structures are of unequal size."""
    results = analysed[0] / "results/small"
    surfaces = read_parquet(results, "surfaces")
    shares = 100 * surfaces["minimal_n_S"] / surfaces["N"]
    of_all = 100 * surfaces["minimal_n_S"].sum() / surfaces["N"].sum()
    page = (results / "index.html").read_text(encoding="utf-8")
    assert share(of_all) != share(shares.mean())
    assert f"{share(of_all)}&nbsp;%" in page and f"{share(shares.mean())}&nbsp;%" not in page


def models(n):
    """Text of a PDB file of n models whose second chains lie elsewhere in each."""
    first, others = peptide(), [peptide(("VAL",), "B", origin=(0, 6 + k**2, 0.5 * k)) for k in range(n)]
    return "".join(f"MODEL {k}\n{first}{other}ENDMDL\n" for k, other in enumerate(others, 1)) + "END\n"


@pytest.mark.parametrize(
    ("n", "keys", "frames", "names"),
    [
        (1, {}, {"selection": [3]}, "f0"),  # frames are those of the trajectories beside it
        (1, {}, {"selection": [3], "stride": 2}, "f0"),
        (1, {}, {"clusters": 3}, "c1"),
        (3, {"model": 2}, {"selection": [7], "stride": 2}, "f1"),
        (2, {}, {"selection": [1]}, "f1"),
        (2, {}, {"selection": "all", "stride": 2}, "f0"),
        (5, {}, {"selection": "all", "stride": 2}, "f0 f2 f4"),
        (5, {}, {"clusters": 2}, "c1 c2"),
        (
            2,
            {},
            {"selection": [1], "stride": 2},
            "",
        ),  # the one frame that a stride leaves is no single structure
        (2, {}, {"clusters": 3, "stride": 2}, ""),
    ],
)
def test_conformations_of_a_file_with_one_or_several_models(tmp_path, n, keys, frames, names):
    (tmp_path / "m.pdb").write_text(models(n))
    config = {"run": "small", "sampling": False, "frames": frames}
    config["proteins"] = {"m": {"structure": "m.pdb"} | keys}
    planned = planned_jobs(tmp_path, config)
    process = run_job(tmp_path, next(job for job in planned if "choose" in job["rule"]))
    if not names:
        assert process.returncode == 1 and re.match(rf"\s*frames\.{next(iter(frames))}: ", process.stderr)
        return
    results = tmp_path / "results/small/m"
    table, atoms = pd.read_csv(results / "frames.csv"), read_molecule(tmp_path / "m.pdb").xyz
    assert table["conformation"].to_list() == names.split()
    for name, frame in zip(table["conformation"], table["frame"], strict=True):
        assert (read_molecule(results / "structures" / f"{name}.pdb").xyz[0] == atoms[frame]).all()


@pytest.mark.parametrize(
    ("key", "value", "rule", "words"),
    [
        (
            "pairs.files.files",
            ["models.pdb", "one.pdb"],
            "compute_partner_surfaces",
            "files: partner 1 has 2 models",
        ),
        (
            "pairs.chains.chains",
            [["A"], ["X"]],
            "compute_partner_surfaces",
            "no chain X: its chains are A, B",
        ),
        ("changes.bend", ["moving/f0", "moving/f5"], "compare_forms", "changes.bend .* does not have"),
        ("proteins.still.chains", ["B"], "choose_single_frame", "no chain B"),
    ],
)
def test_a_job_that_cannot_be_done_says_the_key_and_why(study, config, tmp_path, key, value, rule, words):
    folder = copy_of(study, tmp_path / "own")
    (folder / "models.pdb").write_text(models(2))
    jobs = plan(folder, changed(config, key, value))
    process = run_job(folder, next(jobs[job] for job in jobs if job[0] == rule and key.split(".")[1] in job))
    assert process.returncode == 1 and re.search(words, process.stderr)
