"""`make run` from its outside: what is said before and after, signals, the exit code; Snakemake itself is played."""

import fcntl
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace

import psutil
import pytest
import yaml

import study
from conftest import ROOT
from small_study import snakemake
from sparsurf.errors import InputError
from sparsurf_study import catalogue
from sparsurf_study.batches import assignment
from sparsurf_study.report import closing
from sparsurf_study.workflow import job_logs, ledger, memory, running, slurm
from sparsurf_study.workflow.checksums import Checksums
from sparsurf_study.workflow.ledger import Record

CRATE = '{"@graph": [{"@id": "ro-crate-metadata.json"}, {"@id": "./", "abstract": ["first", "second"]}]}'
STRUCTURE = {"structure": str(ROOT / "data" / "tdp43" / "topology.pdb")}


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """An empty checkout; Snakemake leaves its options in `calls`, does the next of `work` and ends with the next of `codes`."""

    class Checkout:
        root, calls, codes, work = tmp_path / "checkout", [], [], []

        def config(self, **keys):
            path = tmp_path / "mine.yaml"
            content = {"proteins": {"p": STRUCTURE}, "run": "mine"} | keys
            path.write_text(yaml.safe_dump(content, sort_keys=False))
            return str(path)

        def make(self, *files):
            for file in files:
                path = played_checkout.root / "results" / "mine" / file
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(CRATE if "crate" in file else "a\n1\n")

    def play(root, files, *options, errors=None, wait=None):
        played_checkout.calls.append([*map(str, options)])
        played_checkout.files, played_checkout.paths = [path.name for path in files], files
        played_checkout.wait = wait
        if played_checkout.work:
            played_checkout.work.pop(0)()
        return played_checkout.codes.pop(0) if played_checkout.codes else 0

    played_checkout = Checkout()
    played_checkout.root.mkdir()
    (played_checkout.root / "config.yaml").write_bytes((ROOT / "config.yaml").read_bytes())
    for name in ("data", "profiles"):
        (played_checkout.root / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(study, "ROOT", played_checkout.root)
    for module in (study, memory):
        monkeypatch.setattr(module, "memory_of_machine", lambda: 4.1e9)
    monkeypatch.setattr(study, "run_snakemake", play)
    return played_checkout


def test_a_study_ends_with_its_answers_and_where_to_look(checkout, capsys):
    checkout.work = [lambda: checkout.make("warnings.csv", "index.html", "ro-crate-metadata.json")]
    assert study.main(checkout.config(), "--cores", "2") == 0
    assert checkout.calls == [["--logger", "sparsurf", "--resources=mem_mb=4100", "--cores", "2"]]
    lines = capsys.readouterr().out.strip().splitlines()
    assert [line.split()[0] for line in lines] == [
        "Time",
        "Answer",
        "Answer",
        "Warnings",
        "Checks",
        "Look",
        "All",
    ]
    assert lines[1:3] == ["Answer    first", "Answer    second"] and lines[3].split()[1] == "1"
    assert "all results agree" in lines[4]


@pytest.mark.parametrize(
    "words", [[], ["-n"], ["--cores", "3"], ["compare"], ["mine.yaml"], ["sub/../mine.yaml", "-n"]]
)
def test_the_config_is_that_of_the_checkout_or_lies_where_the_command_was_given(checkout, capsys, words):
    """And a run that was not closed says where its results so far are."""
    own, named = Path(checkout.config()), [word for word in words if word.endswith(".yaml")]
    (own.parent / "sub").mkdir()
    assert study.main(*words) == 0
    wanted = own if named else checkout.root / "config.yaml"
    assert checkout.paths[0].resolve() == wanted and len(checkout.paths) == 1 + ("compare" in words)
    options = [word for word in words if word.startswith("-") or word.isdigit()]
    assert checkout.calls[0][len(checkout.calls[0]) - len(options) :] == options
    run = "mine" if named else "default"
    assert ("-n" in words) or capsys.readouterr().out == f"\nThe results so far are in results/{run}/.\n"


@pytest.mark.parametrize("word", ["-h", "--help"])
def test_help_starts_nothing(checkout, capsys, word):
    assert study.main(word) == 0 and not checkout.calls
    assert capsys.readouterr().out.startswith("Run a study: ")


def test_the_comparison_with_the_paper_is_where_to_look_once_it_is_there(checkout, capsys):
    config, files = checkout.config(paper="p"), ["index.html", "ro-crate-metadata.json"]
    for file, page in (("index.html", "index"), ("verdict.html", "verdict")):
        checkout.work = [lambda file=file: checkout.make(*files, file)]
        assert study.main(config) == 0
        assert f"Look at   results/mine/{page}.html\n" in capsys.readouterr().out


def test_a_study_in_batches_says_how_many_structures_failed(checkout, capsys):
    structures = {f"p{k}": STRUCTURE for k in range(12)}

    def finish():
        checkout.make("index.html", "ro-crate-metadata.json")
        rows = "place,reason\np3,by hand\np7,no atoms\n"
        (checkout.root / "results" / "mine" / "failures.csv").write_text(rows)

    checkout.work = [finish] * 2
    assert study.main(checkout.config(proteins=structures, sampling=False, exclude=["p3"])) == 0
    assert "Failed    2 of 12 structures, see results/mine/failures.csv\n" in capsys.readouterr().out
    assert (
        study.main(
            checkout.config(
                exclude=["changes/x"], changes={"x": ["p", "q"]}, proteins={"p": STRUCTURE, "q": STRUCTURE}
            )
        )
        == 0
    )
    assert "Failed" not in capsys.readouterr().out


def test_a_run_is_not_closed_without_the_tables_of_a_batch(checkout, capsys, monkeypatch):
    """One of two jobs was killed, as was that of a page: structures without a row are neither surfaces nor failures."""
    size = os.path.getsize(STRUCTURE["structure"])
    monkeypatch.setattr(assignment, "BATCH_BYTES", 6 * size)  # of twelve structures
    structures = {f"p{k}": STRUCTURE for k in range(12)}

    def fail():
        for log in ("p3/c1/draw_view", "analyse_batch_0001"):
            checkout.make(f"logs/{log}.log")
            with open(os.environ[job_logs.FAILED_JOBS], "a") as stream:
                stream.write(f"results/mine/logs/{log}.log\n")
        checkout.make(*(f"{table}/0002.parquet" for table in assignment.BATCH_FOLDERS))

    checkout.codes, checkout.work = [1], [fail]
    config = checkout.config(proteins=structures, sampling=False, pages=["p3"])
    assert study.main(config) == 1
    said = capsys.readouterr()
    assert "The results so far are in results/mine/.\n" in said.out
    results = checkout.root / "results" / "mine"
    assert not (results / "index.html").exists() and not (results / "logs" / "close_run.log").exists()
    assert "- p3/c1/draw_view: " in said.err and "- analyse_batch_0001: " in said.err


@pytest.mark.parametrize("n", [1, 12])
def test_contradictions_among_the_results_reach_the_terminal(checkout, capsys, n):
    def finish():
        checkout.make("warnings.csv", "index.html", "ro-crate-metadata.json")
        rows = "file,sentence\n" + "".join(f"p/c{k}/minimal.csv,its weights sum to {k}\n" for k in range(n))
        (checkout.root / "results" / "mine" / "checks.csv").write_text(rows)

    checkout.work = [finish]
    assert study.main(checkout.config(), "--cores", "2") == 0
    lines = capsys.readouterr().out.splitlines()
    first = lines.index("Checks    1 contradiction" if n == 1 else "Checks    12 contradictions") + 1
    shown = [f"          results/mine/p/c{k}/minimal.csv: its weights sum to {k}" for k in range(min(n, 10))]
    assert lines[first : first + len(shown)] == shown and lines[first + len(shown)].startswith("Look at")


def test_errors_of_snakemake_itself_are_printed(checkout, capsys):
    def complain():
        (checkout.root / "results" / "mine" / "logs" / "snakemake.err").write_text(
            f"{running.SNAKEMAKES_GREETING} profiles/default\nusage\nsnakemake: error: four is no number\n\n"
        )

    checkout.codes, checkout.work = [1], [complain]
    assert study.main(checkout.config(), "--no-such-option") == 1
    printed = capsys.readouterr().err
    assert "\nsnakemake: error: four is no number\n" in printed and "usage" not in printed
    assert "See results/mine/logs/snakemake.err and the newest file" in printed
    checkout.codes = [1]  # the next run ends with nothing said: what an earlier one said is not repeated
    assert study.main(checkout.config()) == 1 and "four is no number" not in capsys.readouterr().err


def test_a_killed_snakemake_is_named_beside_the_jobs_that_had_failed_before(checkout, capsys):
    def fail():
        checkout.make("logs/p/c1/draw_view.log")
        Path(os.environ[job_logs.FAILED_JOBS]).write_text("results/mine/logs/p/c1/draw_view.log\n")

    checkout.codes, checkout.work = [-signal.SIGKILL], [fail]
    assert study.main(checkout.config()) == -signal.SIGKILL
    said = capsys.readouterr().err
    assert "\n- p/c1/draw_view: it was killed" in said and "\nSnakemake was killed (SIGKILL)" in said


@pytest.mark.parametrize(
    ("logs", "exclude"),
    [
        (["p/c2/compute_surface"], {"p/c2": "compute_surface: ?", "pairs/both": "?", "changes/one": "?"}),
        *(
            ([f"p/{job}"], {"p": f"{job}: ?", "pairs/both": "?", "changes/one": "?", "changes/two": "?"})
            for job in ("fetch_x.pdb", "prepare_system", "simulate_nvt", "judge_simulation", "choose_frames")
        ),
        (["p/draw_frames"], {"p/*": "draw_frames: ?"}),
        (["p/c3/draw_view", "p/c3/draw_figures"], {"p/c3": "draw_figures: ?", "changes/two": "?"}),
        (["pairs/files/draw_pair"], {"pairs/files": "draw_pair: ?"}),
        (["changes/two/draw_changes"], {"changes/two": "draw_changes: ?"}),
        (["q/c1/draw_view"], {"q/c1": "?", "pairs/both": "?", "changes/two": "?"}),
        (  # its own reason, though it needs a part that failed as well
            ["pairs/both/draw_pair", "q/c1/draw_view"],
            {"q/c1": "?", "pairs/both": "draw_pair: ?", "changes/two": "?"},
        ),
        (["summarise_best"], {}),
    ],
)
def test_what_failed_and_what_needs_it_is_named_with_its_reason(tmp_path, logs, exclude):
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "frames.csv").write_text("conformation\nc2\nc3\n")
    pairs = {"both": {"proteins": ["q", "p"]}, "files": {"files": ["a", "b"]}}
    config = {"exclude": {}, "sampling": {"run": True}, "pairs": pairs}
    config["proteins"] = {"p": {}, "q": {"surface": "x"}}
    config["changes"] = {"one": ["p", "p/c2"], "two": ["p/c3", "q"]}
    failed = [str(tmp_path / "logs" / f"{log}.log") for log in logs]
    found = running.failed_places(config, tmp_path, failed)
    assert found.keys() == exclude.keys()
    assert all(found[place].startswith(reason.rstrip("?")) for place, reason in exclude.items())


def test_every_job_of_a_protein_is_known_to_come_before_or_after_its_conformations():
    """A job that comes before them and is not listed would stop the run of the other proteins."""
    rules = "".join(path.read_text() for path in (ROOT / "Snakefile", *(ROOT / "rules").glob("*.smk")))
    jobs = set(re.findall(r'"results/\{run\}/logs/\{protein\}/(\w+)[^/"]*\.log"', rules))
    after = {job for job in jobs if not job.startswith(running.BEFORE_CONFORMATIONS)}
    assert after == {"draw_frames", "follow_frames_", "follow_ensemble", "draw_ensemble"}


def write_outputs(folder, part, conditions=()):
    """Write all outputs of a part of a run; return their paths in the order of the catalogue."""
    paths = [folder / output.name for output in catalogue.requested(part, conditions)]
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("conformation\nc1\n")
    return paths


def test_only_conformations_that_are_finished_are_summarised(tmp_path):
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "frames.csv").write_text("conformation\nf0002\nf0013\nf0020\nf0021\n")
    of_surface = "<protein>/<conformation>"
    written = {
        name: write_outputs(tmp_path / "p" / name, of_surface, {"molecule", "sampled"})
        for name in ("f0002", "f0013", "f0020", "f0021")
    }
    written["f0021"][-1].unlink()  # its last job never ran
    config = {"exclude": {"p/f13": "by hand"}, "proteins": {"p": {}}, "pairs": {}, "changes": {}}
    config |= {"sampling": {"run": True}, "compare": {"run": False}, "fields": []}
    found = running.failed_places(config, tmp_path, [f"{tmp_path}/logs/p/f0002/compute_surface.log"])
    assert found.keys() == {"p/f13", "p/f0002"}
    assert running.finished_conformations(config, tmp_path, found) == [tmp_path / "p/f0020"]
    own, of_frame = tmp_path / "p/frames.csv", {*written["f0020"]}
    for failures, wanted in (
        (found, {own, *of_frame}),
        (found | {"p/*": "?"}, of_frame),
        (found | {"p": "?"}, set()),
    ):
        assert {*running.finished_parts(config, tmp_path, failures).files} == wanted
    for place in ("pairs/lost", "pairs/left"):
        write_outputs(tmp_path / place, "pairs/<pair>", {"residues"})
    write_outputs(tmp_path / "changes/lost", "changes/<comparison>")
    of_earlier = config | {"pairs": {"lost": {}, "left": {}}, "changes": {"lost": []}}
    lost = found | {"pairs/lost": "?", "changes/lost": "?"}
    finished = running.finished_parts(of_earlier, tmp_path, lost)
    assert finished.pairs == [tmp_path / "pairs/left"] and not any(
        "lost" in path.parts for path in finished.files
    )
    pending = of_earlier | {"pairs": {"left": {}, "pending": {}}}  # it has no table yet
    assert running.finished_parts(pending, tmp_path, found).pairs == [tmp_path / "pairs/left"]
    nothing = running.finished_parts(config, tmp_path, failed := found | {"p/f20": "?"})
    assert not closing.close_partial_run(config, tmp_path, failed, nothing, [], list)


def test_what_is_finished_stands_in_the_order_of_the_config_and_of_the_catalogue(tmp_path):
    """Proteins as listed, not by name; of the paper, what there is where its protein is finished."""
    of_q = write_outputs(tmp_path / "q/c1", "<protein>/<conformation>", {"fields"})
    of_p = write_outputs(tmp_path / "p/c1", "<protein>/<conformation>", {"molecule", "fields"})
    of_y = write_outputs(tmp_path / "pairs/y", "pairs/<pair>", {"residues"})
    for name in ("p/c1/.hidden", "p/c1/notes.txt", "p/structures/c1.pdb", "p/frames.csv", "table1.png", "verdict.html",
                 "paper_rows.csv", "other.csv", "changes/x/changes.csv"):  # fmt: skip
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("conformation\nc1\n")
    config = {"proteins": {"q": {"surface": "x"}, "p": {}}, "pairs": {"y": {}}, "changes": {"x": []}}
    config |= {"exclude": {}, "sampling": {"run": False}, "paper": "q", "compare": {"run": False}}
    config["fields"] = ["hydropathy"]
    of_p = [tmp_path / "p/frames.csv", tmp_path / "p/structures/c1.pdb", *of_p]
    of_paper = [tmp_path / name for name in ("verdict.html", "table1.png", "paper_rows.csv")]
    of_x = tmp_path / "changes/x/changes.csv"
    for failures, wanted in (
        ({}, [*of_q, *of_p, of_x, *of_paper, *of_y]),
        ({"q/c1": "?"}, [*of_p, of_x, *of_y]),
    ):
        found = running.finished_parts(config, tmp_path, failures)
        assert found.files == wanted and found.sampled == []


def test_snakemake_is_given_all_configs_and_the_options(tmp_path, monkeypatch):
    """A signal of the caller's own is heard again afterwards, and none is taken for an end."""
    called = []
    monkeypatch.setattr(running, "_start", lambda command, errors: called.append((command, errors)))
    before, codes = signal.getsignal(signal.SIGTERM), [None, 5]
    configs, errors = [tmp_path / "b.yaml", tmp_path / "a.yaml"], tmp_path / "errors"
    assert running.run_snakemake(tmp_path, configs, "-n", errors=errors, wait=lambda *_: codes.pop(0)) == 5
    assert called[0][0] == called[1][0] and signal.getsignal(signal.SIGTERM) is before
    command = called[0][0]
    place = command.index("--configfile")
    assert command[place + 1 :] == [*map(str, configs), "-n"]
    assert command[command.index("--directory") + 1] == str(tmp_path) and called[0][1].name == str(errors)


@pytest.mark.parametrize("full", ["results/mine", ".snakemake"])
def test_a_disk_that_becomes_full_is_one_sentence(checkout, capsys, monkeypatch, full):
    free = {full: 0}
    monkeypatch.setattr(
        running.shutil, "disk_usage", lambda path: SimpleNamespace(free=free.get(str(path), 10**9))
    )
    checkout.codes = [1]
    assert study.main(checkout.config()) == 1
    assert f"The disk of {full}/ is full. Free some space and run again" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("config", "options", "words"),
    [
        ({}, ["--config", "seed=3"], "--config.* one config file"),
        ({}, ["-C", "seed=3"], "-C.* one config file"),
        ({}, ["--configfile=b.yaml"], "--configfile.* one config file"),
        ({}, ["--cluster"], "--cluster .* has none"),
        ({}, ["--cluster", "foo"], "--cluster .* has foo"),
        ({"run": "../.."}, [], "run cannot name a folder"),
        ({"run": "README.md"}, [], "results/README.md is a file"),
        ({"minimal": {"sampler": "farthst", "n_dots": 3}}, [], "did you mean 'farthest'"),
        ({"sampling": False}, ["compare"], "sampling is false.* `compare`"),
        ({"sampling": False, "compare": {"run": False}}, ["compare"], "sampling is false.* `compare`"),
        ({"compare": {"samplers": ["paper"]}}, ["compare"], "compare.samplers names paper alone"),
        (None, [], "no config file 'none.yaml'.* CONFIG="),
        (".snakemake", [], ".snakemake.* cannot be written"),
        ("results", [], "results.* cannot be written"),
        ("results/mine/.ledger", [], "results/mine/.ledger.* cannot be written"),
    ],
)
def test_a_mistake_ends_before_anything_runs(checkout, capsys, config, options, words):
    if isinstance(config, str):
        (checkout.root / config).parent.mkdir(parents=True, exist_ok=True)
        (checkout.root / config).symlink_to("/proc/no/such/place")  # where even root may not write
        config = {}
    elif config:
        (checkout.root / "results").mkdir()
        (checkout.root / "results" / "README.md").write_text("")
    path = "none.yaml" if config is None else checkout.config(**config)
    assert study.main(path, *options) == 2 and not checkout.calls
    assert re.search(words, " ".join(capsys.readouterr().err.split()))


@pytest.mark.parametrize("word", ["-n", "-np", "--dry-run", "--dryrun"])
def test_a_dry_run_writes_nothing(checkout, word):
    checkout.codes = [7]
    assert study.main(checkout.config(), word) == 7
    assert len(checkout.calls) == 1 and not (checkout.root / "results").exists()


def test_a_dry_run_is_planned_beside_a_study_that_runs(checkout):
    (checkout.root / ".snakemake").mkdir()
    with open(checkout.root / ".snakemake" / "study.lock", "w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        assert study.main(checkout.config(), "-n") == 0 and len(checkout.calls) == 1
        assert study.main(checkout.config()) == 2 and len(checkout.calls) == 1


@pytest.mark.parametrize(
    ("words", "kept"), [([], None), (["--profile", "own"], "theirs"), (["--profile=own"], "theirs")]
)
def test_a_profile_of_the_login_file_counts_only_beside_one_that_is_given(
    checkout, tmp_path, monkeypatch, words, kept
):
    """It is for other workflows, and its options would be added to those of the study."""
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "config.yaml").write_text("")
    monkeypatch.setenv(running.SNAKEMAKES_PROFILE, "theirs")
    found = []
    checkout.work = [lambda: found.append(os.environ.get(running.SNAKEMAKES_PROFILE))]
    assert study.main(checkout.config(), *words) == 0 and found == [kept]


@pytest.mark.parametrize(
    ("name", "run"),
    [
        ("my study (2).yaml", "my_study__2_"),
        ("default_of_mine.yml", "default_of_mine"),
        (f"{'a' * 120}.yaml", "a" * 100),
    ],
)
def test_a_config_without_a_run_gives_its_name_to_the_results(checkout, tmp_path, name, run):
    """Also one that changes the default study key by key, so that it does not overwrite its results."""
    for content in ({"proteins": {"p": STRUCTURE}}, {"seed": 3}):
        (tmp_path / name).write_text(yaml.safe_dump(content))
        assert study.main(str(tmp_path / name)) == 0
        assert [path.name for path in (checkout.root / "results").iterdir()] == [run]
        shutil.rmtree(checkout.root / "results")
    (tmp_path / name).write_text("run: own\nseed: 3\n")
    assert study.main(str(tmp_path / name)) == 0 and (checkout.root / "results/own").is_dir()


def test_a_config_whose_name_names_no_folder_needs_a_run(checkout, tmp_path, capsys):
    """Two of them would write into one folder, or into that of the default study."""
    for name in ("é.yaml", "ü.yaml", "_.yml"):
        (tmp_path / name).write_text("seed: 3\n")
        assert study.main(str(tmp_path / name)) == 2 and not checkout.calls
        assert "write a `run` into it" in capsys.readouterr().err
    (tmp_path / "é.yaml").write_text("run: own\nseed: 3\n")
    assert study.main(str(tmp_path / "é.yaml")) == 0 and (checkout.root / "results/own").is_dir()


def test_a_config_that_replaces_the_results_of_another_says_so(checkout, tmp_path, capsys):
    """An edited config, a moved one, a link to it and a copy of it do not."""
    first, second = checkout.root / "studies" / "mine.yaml", tmp_path / "other" / "mine.yaml"

    def told(path, text=None):
        """Whether the run says before it starts whose results it replaces."""
        path.parent.mkdir(exist_ok=True)
        if text is not None:
            path.write_text(text)
        checkout.work = [lambda: before.append(capsys.readouterr().out)]
        before = []
        assert study.main(str(path)) == 0
        capsys.readouterr()
        return before[0]

    assert (
        told(first, "seed: 1\n") == told(first) == told(first, "seed: 2\n") == told(second, "seed: 2\n") == ""
    )
    assert told(first, "seed: 1\n") == ""  # as there are no results yet
    record(checkout.root / "results/mine/a.csv", "1")
    assert told(second, "seed: 1\n") == ""
    link = tmp_path / "linked" / "mine.yaml"
    link.parent.mkdir()
    link.symlink_to(second)
    assert told(link) == ""
    named = "results/mine/ contains the results of {}, and this run of {} replaces them."
    assert told(first, "seed: 3\n").startswith(named.format(second, "studies/mine.yaml"))
    (checkout.root / "mine.yml").write_text("seed: 4\n")
    assert told(checkout.root / "mine.yml").startswith(named.format("studies/mine.yaml", "mine.yml"))
    shutil.move(checkout.root / "mine.yml", second)
    assert told(second) == told(second, "seed: 5\n") == ""
    (checkout.root / "results/mine" / ledger.FOLDER / ledger.CONFIG).write_text("[")
    assert told(first) == ""


def test_snakemake_says_whose_results_it_replaces(tmp_path):
    """Without `make run`; nothing is computed."""
    run, former = tmp_path / "results" / "own", tmp_path / "former.yaml"
    record(run / "p" / "c1" / "surface.npz", "1")
    (tmp_path / "p.npz").write_text("of no use here")
    former.write_text("run: own\n")
    ledger.note_config(run, former)
    config = {"run": "own", "proteins": {"p": {"surface": "p.npz"}}}
    done = snakemake(
        tmp_path, config, "--touch", "--forcerun", "read_surface", "--", "results/own/p/c1/surface.npz"
    )
    said = f"contains the results of {former}, and this run of config.yaml replaces them."
    assert done.returncode == 0 and done.stderr.count(said) == 1


def record(path, text, **keys):
    """Write a result and the record of its job."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    run, name = path.parents[len(path.parts) - path.parts.index("results") - 3], path.name
    outputs = {str(path.relative_to(run.parents[1])): Checksums().of(path)}
    Record("work", outputs, **keys).write(run / ledger.FOLDER / f"{name}.json")


def test_what_disagrees_with_the_records_is_handed_to_snakemake(checkout, capsys):
    """With its metadata, which it has of none of these; lines about the run come before it starts."""
    run, handed = checkout.root / "results" / "mine", []
    for name in ("a.csv", "b.csv"):
        record(run / "p" / name, "1", versions={"numpy": "1.0"})
        path = ledger.path_of_metadata(checkout.root / ".snakemake/metadata", f"results/mine/p/{name}")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("{}")
    (run / "p" / "a.csv").write_text("2")
    path.unlink()
    (run / "p" / ".job.new").mkdir()  # of a killed job

    def look():
        handed.append(json.loads(Path(os.environ[ledger.TO_MAKE_AGAIN]).read_text()))
        assert "2 jobs of results/mine/ computed with numpy 1.0" in capsys.readouterr().out

    checkout.work = [look]
    assert study.main(checkout.config()) == 0
    assert handed == [
        {
            "results/mine/p/a.csv": "a.csv of p was changed after its job: it is computed again.",
            "results/mine/p/b.csv": "b.csv of p has lost its metadata in .snakemake/: it is computed again.",
        }
    ]
    assert ledger.TO_MAKE_AGAIN not in os.environ and not (run / "p" / ".job.new").exists()


def test_records_of_a_newer_version_start_nothing(checkout, capsys):
    record(checkout.root / "results/mine/a.csv", "1", format=2)
    assert study.main(checkout.config()) == 2 and not checkout.calls
    assert capsys.readouterr().err.startswith("results/mine/ was written by a newer version of sparsurf")
    assert (checkout.root / "results/mine/a.csv").read_text() == "1"


@pytest.mark.parametrize("code", [0, 1])
def test_a_download_of_an_earlier_version_is_kept_before_anything_runs(checkout, capsys, code):
    """Snakemake touches it, so that it takes it for up to date; where that fails, nothing else starts."""
    folder = checkout.root / "results/mine/p/download"
    folder.mkdir(parents=True)
    (folder / "1UBI.cif.gz").write_text("x")
    origin = {
        "url": "https://files.rcsb.org/download/1UBI.cif.gz",
        "sha256": Checksums().of(folder / "1UBI.cif.gz"),
    }
    (folder / "1UBI.cif.gz.json").write_text(json.dumps(origin))
    checkout.codes = [code]
    assert study.main(checkout.config(proteins={"p": {"pdb": "1ubi"}})) == 2 * code
    said = capsys.readouterr()
    assert "Kept as they are in results/mine/, without a complete record: 1 download." in said.out
    touched = [f"results/mine/p/download/1UBI.cif.gz{end}" for end in ("", ".json")]
    assert (
        checkout.calls[0] == ["--quiet", "all", "--touch", "--force", *touched]
        and len(checkout.calls) == 2 - code
    )
    records = ledger.read_records(checkout.root / "results/mine")
    assert len(records) == 1 - code and ("Nothing was changed" in said.err) == bool(code)


def test_a_comparison_is_added_to_the_study(checkout):
    assert study.main(checkout.config(), "--cores", "2", "compare") == 0
    assert "compare" not in checkout.calls[0] and checkout.files == ["mine.yaml", "compare.yaml"]
    assert yaml.safe_load(study.COMPARE.read_text()) == {"compare": {"run": True}}
    assert study.main(checkout.config()) == 0 and checkout.files == ["mine.yaml"]
    assert study.main(checkout.config(compare={"run": False, "percents": [30]}), "compare") == 0
    assert study.main(checkout.config(compare=False), "compare") == 0 and checkout.files[1] == "compare.yaml"


def test_one_study_at_a_time(checkout, capsys):
    (checkout.root / ".snakemake").mkdir()
    with open(checkout.root / ".snakemake" / "study.lock", "w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        assert study.main(checkout.config()) == 2
    assert capsys.readouterr().err == "Another study runs in this folder; wait for it to end.\n"
    assert study.main(checkout.config()) == 0


def test_memory_counts_where_jobs_run_on_this_machine(checkout, monkeypatch, capsys):
    monkeypatch.setattr(study, "REPORTED_MEMORY", 10**7)
    assert study.main(checkout.config(evaluation={"draws": 3, "test_dots": 400})) == 0
    assert "The grid of one surface will need about 0.1 GB of memory." in capsys.readouterr().out
    large, checkout.calls[:] = checkout.config(evaluation={"draws": 1000, "test_dots": 400}), []
    assert study.main(large) == 2 and not checkout.calls
    assert study.main(large, "--workflow-profile", "p") == study.main(large, "--executor", "lsf") == 0
    assert "--resources=mem_mb=4100" not in [word for call in checkout.calls for word in call]
    checkout.calls.clear()
    assert study.main(checkout.config(), "--resources", "mem_mb=1000") == 0
    assert checkout.calls[0][-2:] == ["--resources", "mem_mb=1000"]  # Snakemake takes the last


@pytest.fixture
def commands(tmp_path, monkeypatch):
    """Function that gives a command of Slurm a script of one's own."""
    (folder := tmp_path / "bin").mkdir()
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")

    def give(**scripts):
        for name, script in scripts.items():
            (folder / name).write_text(f"#!/bin/sh\n{script}\n")
            (folder / name).chmod(0o755)

    return give


@pytest.mark.parametrize("word", ["--cluster=slurm", "--cluster slurm"])
def test_a_cluster_is_a_profile_of_snakemake(checkout, commands, word):
    commands(sacct="exit 0", sinfo="echo '32 main*'")
    assert study.main(checkout.config(), "-n", *word.split(), "--max-threads", "2") == 0
    prefix = ["--slurm-jobname-prefix", slurm.JOB_PREFIX]
    profile = ["--workflow-profile", str(checkout.root / "profiles" / "slurm")]
    assert checkout.calls == [[*profile, *prefix, "-n", "--max-threads", "2"]]  # Snakemake takes the last
    for words, wait in ((word.split(), slurm.wait_on_slurm), ([], None)):
        assert study.main(checkout.config(), *words) == 0 and checkout.wait is wait


@pytest.mark.parametrize(
    "words", ["-n --profile my/own --quiet", "-n --profile=my/own --quiet", "--profile {}/my/own -n --quiet"]
)
@pytest.mark.parametrize("file", ["config.yaml", "config.v8+.yaml"])
def test_a_profile_lies_where_the_command_was_given(checkout, tmp_path, words, file):
    """And is Snakemake's; a folder of that name in profiles/ is another."""
    (tmp_path / "my" / "own").mkdir(parents=True)
    (tmp_path / "my" / "own" / file).write_text("")
    assert study.main(checkout.config(), *words.format(tmp_path).split()) == 0
    assert checkout.calls == [["--workflow-profile", str(tmp_path / "my" / "own"), "-n", "--quiet"]]


def test_a_slurm_without_accounts_and_with_small_nodes_is_used_as_it_is(commands, capsys, tmp_path):
    commands(sacct="exit 1", sinfo="printf '2 main*\\n4 main*\\n64 other\\n'")
    options = slurm.slurm_options(ROOT / "profiles" / "slurm")
    assert options[2:] == ["--slurm-status-command", "squeue", "--max-threads", "4"]
    said = "sacct does not answer: squeue is asked which jobs have ended.\nNo node has more than 4 cores: "
    assert capsys.readouterr().out.startswith(said)
    (tmp_path / "config.yaml").write_text("default-resources: {slurm_partition: short}")
    commands(sinfo="test $4 = --partition=short && printf '2 short\\n8 short\\n'")  # the default is another
    assert slurm.slurm_options(tmp_path)[-2:] == ["--max-threads", "8"]
    for threads, given in ((8, False), (9, True)):  # of the profile itself, whose resources are a list
        listed = f"{{default-resources: [mem_mb=5, slurm_partition=short], max-threads: {threads}}}"
        (tmp_path / "config.yaml").write_text(listed)
        assert ("--max-threads" in slurm.slurm_options(tmp_path)) == given
    commands(sacct="exit 0")
    assert "squeue" not in slurm.slurm_options(tmp_path)
    commands(sinfo="exit 1")
    with pytest.raises(InputError, match="sinfo does not answer"):
        slurm.slurm_options(ROOT / "profiles" / "slurm")


def test_a_job_that_slurm_will_never_start_ends_the_run_in_a_sentence(
    commands, capsys, tmp_path, monkeypatch
):
    rows = [("7", "Priority"), ("8", "PartitionConfig"), ("9", "None")]
    lines = "".join(f"{job} {slurm.JOB_PREFIX}_x ({reason})\\n" for job, reason in rows)
    commands(squeue=f"printf '{lines}11 somebodys_job (PartitionConfig)\\n\\n'")
    commands(scancel=f"echo $* > {tmp_path}/cancelled")
    monkeypatch.setattr(slurm, "SECONDS_BETWEEN_QUESTIONS", 1)
    heard = {
        "preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    }  # also if the tests run in the background
    received, process = [], subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"], **heard)
    assert slurm.wait_on_slurm(process, received) == -signal.SIGINT and received
    assert "Slurm will never start job 8 (PartitionConfig). Ask for less" in capsys.readouterr().out
    assert (tmp_path / "cancelled").read_text() == "7 8 9\n"
    commands(squeue="exit 1")
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"], **heard)
    assert slurm.wait_on_slurm(process, [signal.SIGTERM]) == -signal.SIGINT
    assert (
        "Slurm does not answer, so that jobs of this study may run on: `squeue --me`"
        in capsys.readouterr().out
    )


@pytest.mark.parametrize("forgotten", [True, False])
def test_a_slurm_that_does_not_answer_is_named_and_jobs_that_snakemake_lost_are_started_again(
    commands, capsys, tmp_path, monkeypatch, forgotten
):
    """Silent twice; the next time it answers, and Snakemake ends by itself, or waits for sacct in vain."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(slurm, "SECONDS_BETWEEN_QUESTIONS", 1)
    monkeypatch.setattr(slurm, "SECONDS_TO_ASK_AGAIN", 1)
    commands(squeue="echo >> asked; test $(wc -l < asked) -gt 2", scancel="exit 0")
    wait = "import pathlib, time; pathlib.Path('.snakemake/log').mkdir()\n"
    wait += f"pathlib.Path('.snakemake/log/a.log').write_text({forgotten} * \"Falling back to 'sacct'\")\n"
    wait += "pathlib.Path('.snakemake/tmp.new').mkdir()\n"
    wait += "time.sleep(60 if pathlib.Path('.snakemake/log/a.log').read_text() else 6)"
    (tmp_path / ".snakemake" / "tmp.old").mkdir(parents=True)  # of another process
    heard = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
    process = subprocess.Popen([sys.executable, "-c", wait, "--slurm-status-command", "squeue"], **heard)
    assert slurm.wait_on_slurm(process, []) == (None if forgotten else 0)
    words = ["Slurm has not answered for more than a minute; the study goes on when it does."]
    words += ["Slurm answers again."]
    words += ["The jobs that ran when Slurm did not answer are started again."] * forgotten
    assert capsys.readouterr().out.splitlines() == words
    assert [path.name for path in tmp_path.glob(".snakemake/tmp.*")] == ["tmp.old"]


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
def test_make_takes_a_config_with_a_blank_and_refuses_an_unknown_cluster_and_folders_that_fail(tmp_path):
    def make(*options, folder=ROOT, targets=("run",)):
        ours = ("MAKEFLAGS", "CLUSTER", "CONFIG", "CORES")  # given to `make test`
        alone = {name: value for name, value in os.environ.items() if name not in ours}
        command = ["make", "-n", *targets, *options]
        return subprocess.run(command, cwd=folder, env=alone, capture_output=True, text=True, check=False)

    assert 'scripts/study.py "my study.yaml" --cores' in make("CONFIG=my study.yaml").stdout
    assert "--cluster slurm" in make("CLUSTER=slurm").stdout
    for cluster in ((), ("CLUSTER=slurm",)):  # into a folder where nothing is set up
        said = make(f"VENV={tmp_path / 'none'}", *cluster).stdout
        assert ("requirements-slurm.txt" in said) == bool(cluster)
    keys = ("CONFIG=my study.yaml", "PROFILE=my own", "CORES=3")
    said = make(*keys, targets=("paper", "compare", "check")).stdout.splitlines()
    assert [line.partition("bin/python ")[2] for line in said if "scripts/" in line] == [
        'scripts/study.py studies/paper.yaml --profile "my own"',
        'scripts/study.py "my study.yaml" --profile "my own" compare',
        'scripts/check_run.py "my study.yaml"',
    ]
    assert "studies/paper.yaml --cores 3\n" in make("CORES=3", targets=("paper",)).stdout
    refused = make("CLUSTER=foo")
    assert refused.returncode and "CLUSTER is foo, but only CLUSTER=slurm is known" in refused.stderr
    assert len(refused.stderr.splitlines()) == 1
    for options, targets in (
        ((), ("run", "my.yaml")),
        (("config=my.yaml",), ("run",)),
    ):  # not the default study
        refused = make(*options, targets=targets)
        assert refused.returncode and "write make run CONFIG=my.yaml" in refused.stderr
        assert "scripts/" not in refused.stdout
    (tmp_path / "other").mkdir()
    (tmp_path / "link").symlink_to("other")  # whose environment would be cleared
    refused = make(f"VENV={tmp_path / 'link'}")
    assert refused.returncode and "link is a link: remove it" in refused.stderr
    for name, wrong in (("é<x>", None), ("a b", "space"), ("a:b", ":"), ("{x}", "{")):
        shutil.copytree(ROOT / "envs", tmp_path / name / "envs")
        for file in ("Makefile", "pyproject.toml"):
            shutil.copy(ROOT / file, tmp_path / name)
        (tmp_path / name / "src" / "sparsurf").mkdir(parents=True)
        said = make(folder=tmp_path / name).stderr
        assert f"has a {wrong} in its name" in said if wrong else not said


LONG = """
import os, pathlib, signal, sys, time
signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
try:
    pathlib.Path("pid").write_text(str(os.getpid()))
    time.sleep(60)
finally:
    time.sleep(1)  # jobs are cancelled
    pathlib.Path("cancelled").touch()
"""


# A Snakemake that waits for its job, which hears no signal but SIGKILL. It has started a process that ends at SIGTERM, and leaves
# one behind that hears no other signal either
DEAF = """
import os, pathlib, signal, subprocess, sys, time
if sys.argv[-1] in ("job", "below"):
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.argv[-1] == "job":
        subprocess.run([sys.executable, __file__, "below"])
    else:
        left = subprocess.Popen(["sleep", "100"])
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        pathlib.Path("pid").write_text(f"{os.getppid()} {os.getpid()} {left.pid}")
    time.sleep(100)
else:
    signal.signal(signal.SIGTERM, lambda *_: None)
    subprocess.run([sys.executable, __file__, "job"])
    pathlib.Path("cancelled").touch()
    sys.exit(1)
"""


@contextmanager
def long_study(checkout, snakemake=LONG, command=()):
    """Give the process of study.py, or of a command, with a Snakemake that runs for a minute, and the ids in the file `pid`."""
    (checkout.root / "src").symlink_to(ROOT / "src")
    (checkout.root / "scripts").mkdir()
    shutil.copy(ROOT / "scripts" / "study.py", checkout.root / "scripts")
    (checkout.root / "snakemake.py").write_text(snakemake)
    command = [*command] or [sys.executable, checkout.root / "scripts" / "study.py", checkout.config()]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    ours = ("MAKEFLAGS", "MAKELEVEL", "CLUSTER", "CONFIG", "CORES")  # given to `make test`
    environment = {name: value for name, value in os.environ.items() if name not in ours}
    environment |= {"PYTHONPATH": str(ROOT / "src")}

    def hear_all_signals():
        """A job in the background of a shell passes on that Ctrl-C is ignored, and nohup the same of a closed terminal."""
        for number in (signal.SIGINT, signal.SIGHUP):
            signal.signal(number, signal.SIG_DFL)

    signals = {"start_new_session": True, "preexec_fn": hear_all_signals}
    process = subprocess.Popen(command, cwd=checkout.root, env=environment, **streams, **signals)
    pid, deadline = checkout.root / "pid", time.monotonic() + 60
    while not (pid.is_file() and pid.read_text()):
        assert process.poll() is None and time.monotonic() < deadline, process.communicate()
        time.sleep(0.05)
    time.sleep(0.2)  # until both wait
    try:
        yield process, *map(int, pid.read_text().split())
    finally:
        with suppress(ProcessLookupError):  # both have ended
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def test_ctrl_c_waits_until_jobs_are_cancelled_and_ends_with_a_sentence(checkout):
    with long_study(checkout) as (process, _):
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to both
        printed = process.communicate(timeout=30)[1]
    assert process.returncode == 130 and (checkout.root / "cancelled").exists()
    assert printed.splitlines()[-1].startswith("Stopped. ") and "study.py" not in printed


@pytest.mark.parametrize(
    ("prefix", "stops"), [([], ["SIGTERM"]), ([], ["SIGHUP"]), (["nohup"], ["SIGHUP", "SIGTERM"])]
)
def test_a_signal_is_passed_on(checkout, prefix, stops):
    """A closed terminal is one, but not for a study that goes on without it."""
    command = [*prefix, sys.executable, checkout.root / "scripts" / "study.py", checkout.config()]
    with long_study(checkout, command=command) as (process, _):
        for stop in stops:
            process.send_signal(signal.Signals[stop])
        printed = process.communicate(timeout=30)[1]
    assert process.returncode == 128 + signal.Signals[stops[-1]] and (checkout.root / "cancelled").exists()
    assert printed == "\nStopped. Finished results stay; the same command continues where it was.\n"


@pytest.mark.parametrize("stop", [signal.SIGTERM, signal.SIGINT])
def test_jobs_that_hear_no_signal_end_within_ten_seconds_with_all_that_they_started(checkout, stop):
    with long_study(checkout, DEAF) as (process, *jobs):
        begin = time.monotonic()
        process.send_signal(stop)
        printed = process.communicate(timeout=30)[1]
        assert time.monotonic() - begin < 10 and process.returncode == 128 + stop
        assert not [
            job for job in jobs if psutil.pid_exists(job) and psutil.Process(job).status() != "zombie"
        ]
    assert (checkout.root / "cancelled").exists()  # Snakemake had the time to remove the outputs of its jobs
    assert "Stopped. Finished results stay" in printed


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
def test_a_signal_to_the_process_that_make_started_ends_the_study(checkout):
    """No shell between them ends in its place and leaves the study running."""
    for name in ("Makefile", "envs"):
        (checkout.root / name).symlink_to(ROOT / name)
    python = checkout.root / ".venv" / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    command = ["make", "-o", "setup", "run", f"CONFIG={checkout.config()}", "CORES=2"]
    with long_study(checkout, command=command) as (process, snakemake):
        (started,) = psutil.Process(process.pid).children()
        started.terminate()
        assert "Stopped. Finished results stay" in process.communicate(timeout=30)[1]
        assert not psutil.pid_exists(snakemake)
    assert (checkout.root / "cancelled").exists()


def test_the_lock_lasts_as_long_as_snakemake_and_its_refusal_names_the_process(checkout, capsys):
    with long_study(checkout) as (process, snakemake):
        for pid in (process.pid, snakemake):
            assert study.main(checkout.config()) == 2
            said = f"Another study runs in this folder (process {pid}). Wait for it to end, or end it with `kill {pid}`.\n"
            assert capsys.readouterr().err == said
            process.kill()
            process.wait()
        os.kill(snakemake, signal.SIGKILL)
        deadline = time.monotonic() + 30
        while study.main(checkout.config()) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert checkout.calls


def test_a_job_that_a_second_attempt_finished_has_not_failed(tmp_path):
    logs = [tmp_path / f"{name}.log" for name in ("failed", "finished")]
    logs[0].write_text(f"{job_logs.ERROR_MARK}it is too small.\n")
    logs[1].write_text(f"{job_logs.ERROR_MARK}no memory.\n{job_logs.USED_MARK}1 s\n")
    with running.failed_jobs() as failed, open(os.environ[job_logs.FAILED_JOBS], "a") as stream:
        stream.writelines(f"{path}\n" for path in (*logs, logs[0]))
    assert failed == [str(logs[0])]
