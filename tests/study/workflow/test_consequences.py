"""What follows from what: another value of a key changes its outputs and no others; rules follow from their code.

consequences.yaml holds the tables. Plans are dry runs of Snakemake; a job runs as Snakemake runs it, alone.
"""

import filecmp
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from pydantic import BaseModel

import sparsurf
import warm_python
from conftest import ROOT
from peptides import peptide
from small_study import SETTINGS, changed, copy_of, planned_jobs, run_job, write_study
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf_study import catalogue
from sparsurf_study.batches.tables import read_parquet
from sparsurf_study.config.models import Config, Pair, Protein
from sparsurf_study.workflow.code import versions_of_code

pytestmark = pytest.mark.slow

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


def plan(folder, config, **choices):
    """Return what each job of a finished study would be given with another config, by rule and wildcards."""
    options = ("--rerun-triggers", "mtime", "--forcerun", "close_run")
    return by_rule(planned_jobs(folder, config, *options, all_jobs=True, **choices))


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


@pytest.mark.release
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


def apart(paths, others):
    """Those of some paths that are neither among others, nor in a folder or folders of them."""
    whole = {str(part) for path in others for part in (path, *Path(path).parents)}
    return {p for p in paths if p not in whole and not {*map(str, Path(p).parents)} & {*others}}


def opened_files(folder):
    """Files below the folder of a study that each job has read, by its log."""
    opened = {}
    for notes in (folder / warm_python.OPENED).iterdir():
        rows = [line.split("\t") for line in notes.read_text().splitlines()]
        read, written = ({path for way, path in rows if way == mode} for mode in "rw")
        (log,) = (path for path in written if path.endswith(".log"))
        opened[log] = apart(read - written, [".snakemake"])
    return opened


def test_no_job_compiles_a_kernel(study):
    """After the kernels that `make setup` compiles, as the warm Python did before the study."""
    notes = [file.read_text() for file in (study / warm_python.OPENED).iterdir()]
    rows = [line.split("\t") for text in notes for line in text.splitlines()]
    assert rows and not {kernel for way, kernel in rows if way == warm_python.COMPILED}


LARGE_GRID = """
import numpy as np
import sparsurf
from numba.core.dispatcher import Dispatcher
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches import descriptors, subset_patches
from sparsurf_study.analysis.grid import evaluate_grid
from sparsurf_study.compile_kernels import compile_study

def forms():
    kernels = {**vars(descriptors), **vars(subset_patches)}.items()
    return {(name, str(form)) for name, each in kernels if isinstance(each, Dispatcher) for form in each.signatures}

compile_study()
before = forms()
molecule = sparsurf.read_molecule("data/tdp43/topology.pdb", residues="209-214")
prepared = PreparedSurface(sparsurf.surface(molecule))
grid = evaluate_grid(prepared, [[alpha, 0, 0, 0] for alpha in np.linspace(0.1, 1, 24)], 4)
assert len(np.unique(grid.n_s)) == 24
print(forms() - before or "none")
"""


def test_a_grid_with_many_sizes_of_subsets_compiles_no_kernel():
    """The study above has few combinations; the random subsets of many are compared as nested ones, by other kernels."""
    call = [sys.executable, "-c", LARGE_GRID]
    run = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=True)
    assert run.stdout == "none\n"


def test_a_job_reads_its_inputs_and_nothing_else(study, given):
    """As noted when the study ran. What it reads besides might be missing or old, and what it does not read be the wrong file."""
    opened = opened_files(study)
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
        ):  # the warnings of all jobs, and checksums of the files that the config names and that only jobs read
            inputs |= {"results/small/logs"} | {path for path in read if "/" not in path}
            listed = {path: catalogue.output_of(path.removeprefix("results/small/")) for path in read}
            inputs |= {path for path, output in listed.items() if output and output.intermediate}
        assert not apart(read, inputs) and not unread, job["rule"]


@pytest.mark.parametrize("key", SWITCHES)
def test_a_key_adds_and_leaves_out_its_rules_and_no_others(study, config, given, key):
    after = plan(study, changed(config, key, SWITCHES[key]["value"]))
    assert {job[0] for job in {*given} - {*after}} == rules_of(SWITCHES[key]["gone"])
    assert rules_given_something_else(given, after) == rules_of(SWITCHES[key]["rules"])


def test_a_whole_protein_or_what_is_over_its_frames_is_left_out(study, config, given):
    """Its conformations, and pairs and changes of them, stay where only the latter is excluded."""
    after = plan(study, config | {"exclude": {"moving/*": "by hand", "loaded": "by hand"}})
    of_frames = {"draw_frames", "draw_ensemble", "follow_frames", "follow_ensemble"}
    gone = {job for job in given if "loaded" in job or ("moving" in job and job[0] in of_frames)}
    assert {*given} - {*after} == gone and len(gone) > 10 and not {*after} - {*given}
    assert rules_given_something_else(given, after) == {"summarise_surfaces", "close_run"}
    reasons = after["close_run",]["params"].exclude
    assert reasons == {"moving/*": "by hand", "loaded": "by hand"}


@pytest.mark.parametrize(
    ("names", "cores"), [("still", 7), ("still ready", 3), ("still moving", 2), ("still loaded", 7)]
)
def test_grids_share_the_cores_of_this_machine(folder, names, cores):
    """Of 7 cores; `moving` has two conformations, and `loaded` has no grid."""
    proteins = {"still": {"structure": "still.pdb"}, "ready": {"surface": "ready.npz"}}
    proteins["moving"] = {"structure": "topology.pdb", "trajectory": "trajectory.xtc"}
    proteins["loaded"] = {"structure": "loaded.pdb", "sampling": False}
    config = SETTINGS | {"proteins": {name: proteins[name] for name in names.split()}}
    jobs = planned_jobs(folder, config, "--forceall", "--cores", "7", asks=True)
    job = next(job for job in jobs if job["rule"] == "evaluate_grid" and "still" in job["wildcards"])
    assert job["asks"][0]["_cores"] == cores


def test_a_page_of_one_of_several_conformations_names_it(study, config, tmp_path):
    """The frames are written by hand here; with the checksums of the run they would be chosen again."""
    folder = copy_of(study, tmp_path / "own")
    (folder / "results/small/SHA256SUMS").unlink()
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


def test_the_papers_sampler_takes_the_best_of_its_surface(study, config, given):
    after = plan(study, changed(config, "minimal.sampler", "paper"))
    jobs = [job for job in given if job[0] == "select_minimal_subset"]
    assert {job[1] for job in jobs} > {"loaded"}
    for job in jobs:
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
    assert np.allclose(residues["area"], sparsurf.areas(molecule).residues["excluded"], atol=0.01)


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


def test_every_rule_but_a_download_has_a_version_of_the_code(study, config, folder, simulated, batch):
    """No number is computed from a page, whose code is not among that of the numbers."""
    jobs = [*plan(study, config).values()]
    for other in (simulated, batch):
        jobs += planned_jobs(folder, other, "--forceall")
    found = {
        job["rule"]: (Path(job["script"]).stem, job["params"].get("code")) for job in jobs if job["script"]
    }
    assert found.pop("fetch_structure") == ("fetch_structure", None)
    versions = versions_of_code()
    assert {code for _, code in found.values()} == {*versions.values()} and len({*versions.values()}) == 3
    pages = {rule for rule, (_, code) in found.items() if code == versions["pages"]}
    beside = pages | {"all", "complete_protein"}
    assert not {need for job in jobs if job["rule"] not in beside for need, *_ in job["needs"]} & pages
    texts = [path.read_text() for path in (ROOT / "Snakefile", *(ROOT / "rules").glob("*.smk"))]
    rules = re.findall(r"^ *(?:rule|checkpoint|use rule \w+ as) (\w+)\b", "\n".join(texts), re.M)
    assert found.keys() == {*rules} - {"all", "complete_protein", "fetch_structure"}


def test_what_is_downloaded_is_checked_however_it_is_named(tmp_path):
    named = {"pdb": "1ubi"}, {"url": "https://example.org/a.pdb"}
    proteins = {f"p{k}": given | {"sha256": f"{k}" * 64} for k, given in enumerate(named)}
    jobs = planned_jobs(tmp_path, {"run": "new", "proteins": proteins, "sampling": False})
    asked = {job["wildcards"][1]: job["params"].sha256[0] for job in jobs if job["rule"] == "fetch_structure"}
    assert asked == {"p0": "0", "p1": "1"}


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
    of_simulation = {"prepare_system", "simulate_stage", "extract_trajectory", "judge_simulation"}
    assert rules_given_something_else(before, after) & of_simulation == {*rules.split()}
    for stage, earlier in (("nvt", "minimise"), ("npt", "nvt"), ("production", "npt")):
        assert before["simulate_stage", "water", stage]["input"][0].endswith(f"simulation/{earlier}")


def test_a_simulation_reads_what_its_stages_wrote(folder, simulated):
    """And its frames are those of its trajectory; a file alone would be a single structure."""
    jobs = by_rule(planned_jobs(folder, simulated))
    place = "results/small/water/simulation"
    files = {job: [path.removeprefix(f"{place}/") for path in jobs[job]["input"]] for job in jobs}
    assert files["prepare_system", "water"] == ["two.pdb"]
    stages = ["minimise", "nvt", "npt", "production"]
    assert files["extract_trajectory", "water"] == ["system", "production"]
    assert files["judge_simulation", "water"] == [*stages, "topology.pdb", "trajectory.xtc"]
    assert files["simulate_stage", "water", "minimise"] == ["system"]
    assert all(files["simulate_stage", "water", stage][1] == "system" for stage in stages[1:])
    assert files["choose_frames", "water"] == ["topology.pdb", "trajectory.xtc"]
    for stage in stages:
        given = jobs["simulate_stage", "water", stage]
        assert given["params"].stage == stage and given["params"].unfinished == f"{place}/.running/{stage}"


def test_the_page_of_a_simulation_lists_its_tables(folder, simulated, tmp_path):
    """Where all of it is there, with frames that were chosen."""
    folder = copy_of(folder, tmp_path / "own")
    jobs = [job for job in planned_jobs(folder, simulated) if job["script"]]
    for path in [path for job in jobs for path in job["output"]]:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        if Path(path).suffix:
            (folder / path).write_text("conformation\nf0000\n")
        else:
            (folder / path).mkdir(exist_ok=True)
    config = simulated | {"ensemble": {"run": True}}
    after = by_rule(planned_jobs(folder, config, "--rerun-triggers", "mtime"))
    own = {path for path in after["close_run",]["input"] if path.startswith("results/small/water/")}
    names = {path.removeprefix("results/small/water/") for path in own}
    simulation = {f"simulation/{name}.csv" for name in ("energies", "motion", "quality")}
    assert (
        simulation | {"figures/simulation.png", "frames.csv", "structures", "ensemble.csv", "residues.csv"}
        <= names
    )
    assert not {name for name in names if name.startswith("simulation/")} - simulation
    assert ("follow_ensemble", "water") in after and "f0000/minimal.csv" in names


def test_every_result_is_asked_for_beside_the_first_page(given, study, config):
    """Where a job fails there is no first page, and what does not need the job must be there all the same."""
    everything = planned_jobs(
        study, config, "--rerun-triggers", "mtime", "--forcerun", "close_run", all_jobs=True
    )
    needs = {(job["rule"], *job["wildcards"][1:]): job["needs"] for job in everything}
    (all_results,) = (job["needs"] for job in everything if job["rule"] == "all")
    reached, waiting = set(), [job for job in all_results if job[0] != "close_run"]
    while waiting:
        if (job := waiting.pop()) not in reached:
            reached.add(job)
            waiting += needs[job]
    over_all = {
        "summarise_surfaces",
        "summarise_best",
        "summarise_comparison",
        "summarise_pairs",
        "close_run",
    }
    assert {job[0] for job in given.keys() - reached} == over_all


def test_a_second_attempt_asks_for_more_memory_and_time_and_a_grid_for_that_of_its_distances(study, config):
    given = plan(study, config, asks=True)
    asks = {job: given[job]["asks"] for job in given}
    for (rule, *_), (first, second) in asks.items():
        for name in ("mem_mb", "runtime"):
            if isinstance(first[name], int):
                assert second[name] == pytest.approx(2 * first[name], abs=2), (rule, name)
    known = {job[0] for job in asks if isinstance(asks[job][0]["mem_mb"], int)}
    assert known >= rules_of(
        "evaluate_grid tabulate_best compute_surface measure_floors follow_frames draw_view"
    )
    large = plan(study, changed(config, "evaluation.draws", 2002), asks=True)
    more = (
        8 * 8 * 2000 * 20 * (2 + 4) / 1e6
    )  # MB of 8 combinations, 2000 draws and 20 test dots, see config/memory.py
    for rule in ("evaluate_grid", "tabulate_best"):
        job = next(job for job in given if job[0] == rule)
        assert large[job]["asks"][0]["mem_mb"] - asks[job][0]["mem_mb"] == pytest.approx(1.5 * more, abs=2)


@pytest.fixture(scope="module")
def analysed(folder, batch):
    """Folder of the finished batch, and its job."""
    jobs = {job["rule"]: job for job in planned_jobs(folder, batch) if job["script"]}
    (folder / warm_python.OPENED).mkdir()
    for rule in ("analyse_batch", "summarise_batches"):
        process = run_job(folder, jobs[rule])
        assert process.returncode == 0, process.stderr
    opened = opened_files(folder)
    (folder / warm_python.OPENED).rename(folder / ".opened_by_batch")
    for rule in ("analyse_batch", "summarise_batches"):
        jobs[rule]["read"] = {path for path in opened[jobs[rule]["log"][0]] if not path.startswith("job.p")}
    return folder, jobs


def jobs_of_batch(folder, config):
    """Return what the batch and the job of its page are given with a config."""
    jobs = planned_jobs(folder, config, "--forcerun", "analyse_batch", "--rerun-triggers", "mtime")
    return {job["rule"]: job for job in jobs if job["script"]}


def test_a_batch_reads_its_inputs_and_nothing_else(analysed):
    _, jobs = analysed
    assert {*jobs["analyse_batch"]["input"]} == {"still.pdb", "scores.csv", "complex.pdb"}
    for job in (jobs["analyse_batch"], jobs["summarise_batches"]):
        assert not apart(job["read"] - {"still.pdb", "scores.csv", "complex.pdb"}, job["input"])
    unread = apart(jobs["analyse_batch"]["input"], jobs["analyse_batch"]["read"])
    assert not unread and {*jobs["summarise_batches"]["input"]} == {*jobs["analyse_batch"]["output"]}


def test_a_table_of_a_finished_batch_that_is_deleted_is_made_again(analysed, batch, tmp_path):
    """Nothing but the end of the run asks for it: the page was written from it before."""
    folder = copy_of(analysed[0], tmp_path / "own")
    options = ("--rerun-triggers", "mtime")
    assert not [job for job in planned_jobs(folder, batch, *options) if job["script"]]
    for table, rules in (
        ("dots/0001.parquet", {"analyse_batch", "summarise_batches"}),
        ("checks.csv", {"summarise_batches"}),
    ):
        shutil.move(folder / "results/small" / table, folder / "away")
        assert {job["rule"] for job in planned_jobs(folder, batch, *options) if job["script"]} == rules
        shutil.move(folder / "away", folder / "results/small" / table)


def test_values_of_a_batch_are_those_of_its_structures_and_their_own_tables(analysed):
    """Of two structures, one has a table of scores: residues 2 and 5 of `still` have 1 and 0."""
    folder, _ = analysed
    results = folder / "results/small"
    dots, residues = (read_parquet(results, name) for name in ("dots", "residues"))
    for name, file in (("still", "still.pdb"), ("both", "complex.pdb")):
        own = sparsurf.fields(sparsurf.surface(folder / file), ["hydropathy"])["hydropathy"]
        of_one = dots[dots["protein"] == name]
        assert len(of_one) == 60 and np.allclose(of_one["hydropathy"], own[of_one["dot"]], atol=1e-5)
        mean = residues[residues["protein"] == name].set_index(["chain", "residue"])["mean_score"]
        assert (mean["A"]["2"] > 0.8 and mean["A"]["5"] < 0.2) if name == "still" else mean.isna().all()
        assert of_one["score"].isna().all() == (name == "both")


@pytest.mark.release
@pytest.mark.parametrize("key", BATCH)
def test_a_key_changes_its_tables_of_a_batch_and_no_others(analysed, batch, tmp_path, key):
    """The page of the run says how subsets and patches were chosen."""
    folder, before = analysed
    after = jobs_of_batch(folder, changed(batch, key, BATCH[key]["value"]))
    of_page = {"summarise_batches"} if key.startswith("minimal.") or key == "patches.r_patch" else set()
    found = rules_given_something_else(*({(rule,): jobs[rule] for rule in jobs} for jobs in (before, after)))
    assert found == {"analyse_batch"} | of_page
    differ = outputs_that_differ(folder, tmp_path / "after", after["analyse_batch"])
    assert differ == {*BATCH[key]["outputs"].split()}


@pytest.mark.parametrize(
    ("key", "value"), [("evaluation.draws", 3), ("sampling.alpha", [1.0]), ("tables.ranges", 5)]
)
def test_a_batch_does_not_follow_the_keys_of_the_grid(analysed, batch, key, value):
    after = jobs_of_batch(analysed[0], changed(batch, key, value))["analyse_batch"]
    assert not rules_given_something_else({("batch",): analysed[1]["analyse_batch"]}, {("batch",): after})


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
            "1 has 2",
        ),
        (
            "pairs.chains.chains",
            [["A"], ["X"]],
            "compute_partner_surfaces",
            "chain X:",
        ),
        (
            "changes.bend",
            ["moving/f0", "moving/f5"],
            "compare_forms",
            "no 'moving/f5'; moving has f0*, f0*700",
        ),
        ("proteins.still.chains", ["B"], "choose_single_frame", "no chain B"),
    ],
)
def test_a_job_that_cannot_be_done_says_the_key_and_why(study, config, tmp_path, key, value, rule, words):
    folder = copy_of(study, tmp_path / "own")
    (folder / "models.pdb").write_text(models(2))
    jobs = plan(folder, changed(config | {"frames": {"selection": "all"}}, key, value))
    process = run_job(folder, next(jobs[job] for job in jobs if job[0] == rule and key.split(".")[1] in job))
    assert process.returncode == 1 and re.search(words, process.stderr)
