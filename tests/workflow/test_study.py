"""`make run` from its outside: what is said before and after, signals, the exit code; Snakemake itself is played."""

import fcntl
import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
import yaml

import study
from conftest import ROOT
from sparsurf.workflow import needs

STRUCTURE = {"structure": str(ROOT / "data" / "tdp43" / "topology.pdb")}


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """An empty checkout; Snakemake leaves its options in `calls` and ends with the next of `codes`."""

    class Checkout:
        root, calls, codes, done = tmp_path / "checkout", [], [], []

        def config(self, **keys):
            path = tmp_path / "mine.yaml"
            path.write_text(
                yaml.safe_dump({"proteins": {"p": STRUCTURE}, "run": "mine"} | keys, sort_keys=False)
            )
            return str(path)

    own = Checkout()
    own.root.mkdir()
    (own.root / "config.yaml").write_bytes((ROOT / "config.yaml").read_bytes())
    for name in ("data", "profiles"):
        (own.root / name).symlink_to(ROOT / name)

    def played(files, *options):
        own.calls.append(options)
        own.files = [path.name for path in files]
        for work in own.done:
            work()
        code, end = own.codes.pop(0) if own.codes else 0, own.root / "results" / "mine" / "p" / ".complete"
        part = options[-1].startswith(("make_", "draw_", "results/"))
        if code == 0 and not part and "--until=make_surface" not in options and not end.is_file():
            end.parent.mkdir(parents=True, exist_ok=True)
            end.write_text("")
        return code

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(study, "ROOT", own.root)
    monkeypatch.setattr(needs, "memory_of_machine", lambda: 4.1e9)
    monkeypatch.setattr(study, "snakemake", played)
    return own


def test_a_study_ends_with_a_report_that_is_made_when_something_is_newer(checkout, capsys):
    results = checkout.root / "results" / "mine"
    assert study.main(checkout.config(), "--cores", "2") == 0
    first, report = checkout.calls
    assert first == ("--nolock", "--resources=mem_mb=4100", "--cores", "2")
    assert report[-2:] == (
        "--report",
        str(results / "report.html"),
    )
    assert "Results: results/mine/" in capsys.readouterr().out
    (results / "report.html").write_text("")
    checkout.calls.clear()
    assert study.main(checkout.config()) == 0
    assert len(checkout.calls) == 1  # nothing is newer
    (results / "p" / "table.csv").write_text("")
    os.utime(results / "report.html", (0, 0))
    assert study.main(checkout.config()) == 0
    assert len(checkout.calls) == 3


def test_a_study_that_failed_says_what_went_wrong_and_sums_up_with_its_own_settings(
    checkout, capsys, monkeypatch
):
    summed = []
    monkeypatch.setattr(study, "called", lambda *command: summed.append([*map(str, command)]) or 0)

    def work():
        log = checkout.root / "results" / "mine" / "logs" / "p" / "choose_frames.log"
        log.parent.mkdir(parents=True, exist_ok=True)
        log.write_text("INFO fine\nERROR x.pdb holds no atoms.\n")
        made(checkout.root / "results" / "mine", "q/c10", "q/c2", "old/c1", "r/c1")
        (checkout.root / "results" / "mine" / "q" / "frames.csv").write_text("conformation\nc2\nc10\nc11\n")

    checkout.done, checkout.codes = [work], [1]
    proteins = {"r": {"surface": STRUCTURE["structure"]}, "p": STRUCTURE, "q": STRUCTURE}
    config = checkout.config(proteins=proteins, patches={"R_patch": 5.0, "D_link": 0.75}, seed=3)
    assert study.main(config) == 1
    assert len(checkout.calls) == 1  # no report of half a study
    assert "- p/choose_frames: x.pdb holds no atoms." in capsys.readouterr().err
    assert summed[0][0] == sys.executable
    assert summed[0][2:] == [
        str(checkout.root / "results" / "mine"), "r/c1", "q/c2", "q/c10",  # in their order, not those of earlier runs
        "--R-patch", "5.0", "--D-link", "0.75", "--seed", "3",
    ]  # fmt: skip
    assert [Path(command[1]).name for command in summed] == ["summarise_run.py", "write_front_page.py"]
    assert summed[1][2:] == [
        str(checkout.root / "results" / "mine"), "--without", "r", "not finished",
        "--without", "p", "choose_frames: x.pdb holds no atoms.", "--without", "q", "not finished",
    ]  # fmt: skip


def made(results, *places, files=("ranges.csv", "minimal.csv")):
    """What some conformations have."""
    for place in places:
        (results / place).mkdir(parents=True, exist_ok=True)
        for file in (*study.LED_TO_RANGES, *files):
            (results / place / file).write_text("")


def test_where_no_conformation_is_finished_there_is_no_first_page(checkout, monkeypatch):
    summed = []
    monkeypatch.setattr(study, "called", lambda *command: summed.append(Path(command[1]).name) or 0)
    made(checkout.root / "results" / "mine", "p/c1", "p/c2", files=["ranges.csv"])
    (checkout.root / "results" / "mine" / "p" / "frames.csv").write_text("conformation\nc1\nc2\n")
    checkout.codes = [1, 1]
    assert study.main(checkout.config()) == 1 and summed == ["summarise_run.py"]
    made(checkout.root / "results" / "mine", "p/c2")
    assert study.main(checkout.config()) == 1 and summed[1:] == ["summarise_run.py", "write_front_page.py"]


@pytest.mark.parametrize("odd", [" ", "(", "'", "$"])
def test_a_path_that_no_job_starts_by_is_refused_at_once(checkout, monkeypatch, capsys, odd):
    monkeypatch.setattr(study.sys, "executable", f"/home/my{odd}work [1] ü/.venv/bin/python")
    assert study.main(checkout.config()) == 2 and checkout.calls == []
    assert f"Snakemake starts no job by a path with {odd!r}; move" in capsys.readouterr().err
    monkeypatch.setattr(study.sys, "executable", "/home/my-work.[1]_ü,@+=~/.venv/bin/python")
    assert study.main(checkout.config()) == 0


def test_of_a_protein_that_failed_only_what_fits_together_counts(tmp_path):
    for name in ("good", "bad"):
        made(tmp_path, *(f"{name}/c{k}" for k in range(1, 5)))
        (tmp_path / name / "frames.csv").write_text("conformation\nc1\nc2\nc3\nc4\n")
        for file, when in (("c1/grid.csv", 1e9), ("c2/grid.csv", 3e9), ("c3/surface.npz", 3e9)):
            os.utime(tmp_path / name / file, (when, when))
        (tmp_path / name / "c4" / "roughness.csv").unlink()  # what a job that failed wrote before
    proteins = {"good": {}, "bad": {}}
    all_of_them = [f"{name}/c{k}" for name in proteins for k in range(1, 5)]
    assert [*study.places_of(proteins, tmp_path, {})] == all_of_them
    assert [*study.places_of(proteins, tmp_path, {"bad": "x"})] == [*all_of_them[:4], "bad/c1"]


def test_pages_of_an_earlier_run_do_not_stay_where_nothing_of_this_one_does(checkout, monkeypatch):
    results, codes = checkout.root / "results" / "mine", {}
    monkeypatch.setattr(study, "called", lambda *command: codes.get(Path(command[1]).stem, 0))
    made(results, "p/c1")
    (results / "p" / "frames.csv").write_text("conformation\nc1\n")
    pages = (*study.SUMS, *study.FIRST_PAGE)
    for code, stay in (({}, pages), ({"write_front_page": 1}, study.SUMS), ({"summarise_run": 1}, ())):
        for file in pages:
            (results / file).write_text("")
        codes.update(code)
        checkout.codes = [1]
        assert study.main(checkout.config()) == 1
        assert sorted(path.name for path in results.iterdir() if path.is_file()) == sorted(stay)


def test_the_first_page_stays_where_every_protein_has_its_end(checkout, monkeypatch):
    summed = []
    monkeypatch.setattr(study, "called", lambda *command: summed.append(Path(command[1]).name) or 0)
    results = checkout.root / "results" / "mine"
    made(results, "p/c1")
    (results / "p" / "frames.csv").write_text("conformation\nc1\n")
    (results / "p" / ".complete").write_text("")
    checkout.codes = [1]  # the report, say
    assert study.main(checkout.config()) == 1 and summed == []
    (results / "p" / ".complete").unlink()  # killed before its end: nothing is in the logs
    assert study.unfinished({"proteins": {"p": {}}, "pairs": {}}, results, 0) == {"p": "not finished"}


@pytest.mark.parametrize("word", ["-h", "--help"])
def test_help_is_given_and_nothing_made(checkout, capsys, word):
    assert study.main(word) == 0 and checkout.calls == []
    said = capsys.readouterr().out
    assert said.startswith("Run a study and write its report: `python scripts/study.py [config.yaml]")
    assert "Without a config, that is the default study, config.yaml, on all cores.\n" in said
    assert study.main(checkout.config(), word) == 0  # Snakemake's own
    assert len(checkout.calls) == 1 and checkout.calls[0][-1] == word
    assert capsys.readouterr().out == ""  # no results to look at


def test_of_a_pair_without_its_partner_the_partner_is_named(tmp_path):
    for done in ("b", "pairs/made"):
        (tmp_path / done).mkdir(parents=True)
        (tmp_path / done / ".complete").write_text("")
    (tmp_path / "a" / "c1").mkdir(parents=True)
    (tmp_path / "a" / "c1" / "surface.npz").touch()
    os.utime(tmp_path / "a" / "c1" / "surface.npz", (1e9, 1e9))  # from which the pair `made` was made
    (tmp_path / "logs" / "pairs" / "own").mkdir(parents=True)
    (tmp_path / "logs" / "pairs" / "own" / "draw_pair.log").write_text("ERROR too far.\n")
    pairs = {name: {"proteins": ["a", "b"]} for name in ("lost", "made", "own")}
    pairs |= {
        "both": {"proteins": ["c", "a"]},
        "files": {"files": ["a", "b"]},
        "here": {"proteins": ["b", "b"]},
    }
    found = study.unfinished({"proteins": {"a": {}, "b": {}, "c": {}}, "pairs": pairs}, tmp_path, 0)
    assert found == {
        "a": "not finished",
        "c": "not finished",
        "pairs/lost": "not finished, as a is not",
        "pairs/own": "draw_pair: too far.",
        "pairs/both": "not finished, as c and a is not",
        "pairs/files": "not finished",
        "pairs/here": "not finished",
    }


def test_a_pair_of_an_earlier_surface_of_a_partner_that_failed_is_not_finished(tmp_path):
    pairs = {name: {"proteins": ["a", "b"]} for name in ("before", "after")}
    for name, when in {"pairs/before": 1e9, "a/f3": 2e9, "pairs/after": 3e9, "b": 1e9}.items():
        (tmp_path / name).mkdir(parents=True)
        file = tmp_path / name / ("surface.npz" if name == "a/f3" else ".complete")
        file.touch()
        os.utime(file, (when, when))
    (tmp_path / "a" / "frames.csv").write_text("conformation\nf3\nf9\n")
    config = {"proteins": {"a": {}, "b": {}}, "pairs": pairs}
    lost = {"a": "not finished", "pairs/before": "not finished, as a is not"}
    assert study.unfinished(config, tmp_path, 4e9) == lost
    (tmp_path / "a" / "f3" / "surface.npz").unlink()
    lost["pairs/after"] = "not finished, as a is not"
    assert study.unfinished(config, tmp_path, 4e9) == lost


def test_a_pair_that_failed_is_named_on_the_first_page(checkout, monkeypatch):
    summed = []
    monkeypatch.setattr(study, "called", lambda *command: summed.append([*map(str, command[1:])]) or 0)
    results = checkout.root / "results" / "mine"

    def work():
        made(results, "p/c1", "pairs/fine", "pairs/two")
        (results / "p" / "frames.csv").write_text("conformation\nc1\n")
        for name in ("p", "pairs/fine"):
            (results / name / ".complete").write_text("")
        for job, said in (
            ("pairs/two/make_partners", "they do not touch."),
            ("summarise_pairs", "no pairs."),
        ):
            (results / "logs" / job).parent.mkdir(parents=True, exist_ok=True)
            (results / "logs" / f"{job}.log").write_text(f"ERROR {said}\n")

    checkout.done, checkout.codes = [work], [1]
    pairs = {name: {"files": [STRUCTURE["structure"]] * 2} for name in ("fine", "two")}
    assert study.main(checkout.config(pairs=pairs)) == 1
    scripts = ["summarise_pairs.py", "summarise_run.py", "write_front_page.py"]
    assert [Path(command[0]).name for command in summed] == scripts
    without = ["--without", "pairs/two", "make_partners: they do not touch."]
    assert summed[0][1:] == [str(results), "fine"] and summed[2][1:] == [str(results), *without]
    summed.clear()
    checkout.codes = [1]
    assert study.main(checkout.config(pairs=pairs, proteins={})) == 1  # the first page is that of the pairs
    assert [command[1:] for command in summed] == [[str(results), "fine", *without]]


def test_a_part_of_a_study_ends_without_a_report(checkout, capsys):
    for finished in (False, True):
        checkout.calls.clear()
        if finished:  # before: a report would tell of old tables beside new ones
            assert study.main(checkout.config()) == 0
            assert "Report:" in capsys.readouterr().out
        for options in (("--until", "make_surface"), ("--until=make_surface",), ("-O", "draw_view")):
            checkout.calls.clear()
            assert study.main(checkout.config(), *options) == 0
            assert [call[-1] for call in checkout.calls] == [options[-1]]
            said = capsys.readouterr()
            assert "What was asked for is in results/mine/; the rest of the study was not made" in said.out
            assert "Report:" not in said.out and not said.err


def test_a_part_that_follows_from_frames_not_chosen_yet_is_told(checkout, capsys):
    proteins = {
        "p": STRUCTURE,
        "q": STRUCTURE,
        "ready": {"surface": str(ROOT / "data" / "tdp43" / "topology.pdb")},
    }
    config = checkout.config(proteins=proteins)
    told = "Of p, q the frames are not chosen yet (--until choose_frames): nothing that follows from them was made.\n"
    assert study.main(config, "--until", "make_surface") == 0 and told in capsys.readouterr().out
    for name in "pq":
        (checkout.root / "results" / "mine" / name).mkdir()
        (checkout.root / "results" / "mine" / name / "frames.csv").touch()
    assert study.main(config, "--until", "make_surface") == 0
    assert "frames are not" not in capsys.readouterr().out


def test_a_file_of_a_study_is_made_without_the_rest(checkout, capsys):
    assert study.main(checkout.config(), "results/mine/p/c1/surface.npz") == 0 and len(checkout.calls) == 1
    assert "the rest of the study was not made" in capsys.readouterr().out


def test_what_snakemake_alone_complains_of_stands_above(checkout, capsys):
    checkout.codes = [1]
    assert study.main(checkout.config(), "--no-such-option") == 1
    assert capsys.readouterr().err.endswith(
        "What was made is in results/mine/. What went wrong stands above.\n"
    )


@pytest.mark.parametrize("options", [("--config", "seed=3"), ("-C", "seed=3"), ("--configfile=b.yaml",)])
def test_a_second_config_is_refused(checkout, capsys, options):
    path = checkout.config()
    assert study.main(path, *options) == 2 and not checkout.calls
    told = f"{options[0]}: a study has one config file; write into {path} what is to change."
    assert capsys.readouterr().err.strip() == told


def test_a_dry_run_writes_nothing(checkout):
    checkout.codes = [7]
    assert study.main(checkout.config(), "-n") == 7
    assert len(checkout.calls) == 1 and not (checkout.root / "results").exists()


@pytest.mark.parametrize(
    "config, sentence",
    [
        ({"run": "../.."}, "'../..' in run cannot name a folder"),
        ({"run": "README.md"}, "results/README.md is a file"),
        ({"run": "x" * 300}, "cannot name a folder"),
        ({"minimal": {"sampler": "farthst", "n_S": 3}}, "did you mean 'farthest'?"),
    ],
)
def test_a_bad_config_ends_before_anything_runs(checkout, capsys, config, sentence):
    (checkout.root / "results").mkdir()
    (checkout.root / "results" / "README.md").write_text("")
    assert study.main(checkout.config(**config)) == 2
    said = capsys.readouterr()
    assert sentence in said.err and "results/../" not in said.err and not said.out
    assert not checkout.calls


def test_no_config_or_no_yaml_is_a_sentence(checkout, capsys, tmp_path):
    assert study.main("none.yaml") == 2
    assert "There is no config file 'none.yaml'; give one with CONFIG=" in capsys.readouterr().err
    (tmp_path / "list.yaml").write_text("- a\n")
    assert study.main(str(tmp_path / "list.yaml")) == 2
    assert "list.yaml holds a list" in capsys.readouterr().err


def test_a_config_without_proteins_changes_the_default_study(checkout, tmp_path):
    (tmp_path / "seed.yaml").write_text("seed: 5\nrun: other\n")
    assert study.main("seed.yaml") == 0
    assert (checkout.root / "results" / "other").is_dir()


def test_a_config_of_pairs_alone_leaves_the_default_study_out(checkout, tmp_path):
    pair = {"files": [STRUCTURE["structure"]] * 2}
    (tmp_path / "pairs.yaml").write_text(yaml.safe_dump({"run": "two", "pairs": {"mine": pair}}))
    found = study.checked_config(tmp_path / "pairs.yaml", "pairs.yaml")
    assert found["proteins"] == {} and list(found["pairs"]) == ["mine"]


@pytest.mark.parametrize(("options", "given"), [([], "none"), (["foo"], "foo")])
def test_a_cluster_that_is_not_known_is_a_sentence(checkout, capsys, options, given):
    assert study.main(checkout.config(), "--cluster", *options) == 2
    said = capsys.readouterr().err
    assert said == f"--cluster needs the name of a folder in profiles/, as slurm, but has {given}.\n"
    assert not checkout.calls
    assert study.main(checkout.config(), "--cluster", "slurm", "-n") == 0
    assert checkout.calls[0][:3] == (
        "--nolock",
        "--workflow-profile",
        str(checkout.root / "profiles" / "slurm"),
    )


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
def test_make_takes_a_config_with_a_blank_and_refuses_an_unknown_cluster():
    def make(*options):
        given = ("MAKEFLAGS", "CLUSTER", "CONFIG", "CORES")  # to `make test`
        alone = {name: value for name, value in os.environ.items() if name not in given}
        command = ["make", "-n", "run", *options]
        return subprocess.run(command, cwd=ROOT, env=alone, capture_output=True, text=True, check=False)

    assert 'scripts/study.py "my study.yaml" --cores' in make("CONFIG=my study.yaml").stdout
    assert "--cluster slurm" in make("CLUSTER=slurm").stdout
    refused = make("CLUSTER=foo")
    assert refused.returncode and "CLUSTER is foo, but only CLUSTER=slurm is known" in refused.stderr
    assert len(refused.stderr.splitlines()) == 1


def test_a_comparison_is_part_of_the_study_and_of_its_report(checkout):
    assert study.main(checkout.config(), "--cores", "2", "compare") == 0
    assert [options[:3] for options in checkout.calls] == [
        ("--nolock", "--resources=mem_mb=4100", "--cores"),
        ("--nolock", "--quiet", "all"),
    ]
    assert checkout.files == ["mine.yaml", "compare.yaml"]
    assert yaml.safe_load(study.COMPARE.read_text()) == {"compare": {"run": True}}


def test_a_run_that_was_compared_stays_so(checkout):
    (checkout.root / "results" / "mine").mkdir(parents=True)
    assert study.main(checkout.config()) == 0 and checkout.files == ["mine.yaml"]
    (checkout.root / "results" / "mine" / "compare.md").touch()
    assert study.main(checkout.config()) == 0 and checkout.files == ["mine.yaml", "compare.yaml"]
    assert study.main(checkout.config(run="other")) == 0 and checkout.files == ["mine.yaml"]


def test_one_study_at_a_time(checkout, capsys):
    (checkout.root / ".snakemake").mkdir()
    with open(checkout.root / ".snakemake" / "study.lock", "w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        assert study.main(checkout.config()) == 2
    assert "Another study runs in this folder" in capsys.readouterr().err
    assert study.main(checkout.config()) == 0


@pytest.mark.parametrize("place", [".snakemake", "results"])
def test_a_folder_that_may_not_be_written_is_a_sentence(checkout, capsys, place):
    (checkout.root / place).symlink_to("/proc/no/such/place")  # a place where even root may not write
    assert study.main(checkout.config()) == 2
    said = capsys.readouterr().err
    assert "cannot be written (" in said and place in said and len(said.splitlines()) == 1
    assert not checkout.calls


def test_the_memory_of_a_large_grid_is_told(checkout, capsys, monkeypatch):
    monkeypatch.setattr(study, "TELL", 10**7)
    assert study.main(checkout.config(evaluation={"draws": 3, "test_dots": 400})) == 0
    assert "The grid of one surface will need about 0.1 GB of memory." in capsys.readouterr().out


def test_memory_of_this_machine_counts_where_jobs_run_on_it(checkout, monkeypatch):
    monkeypatch.setattr(study, "accounting", lambda: True)
    large = checkout.config(evaluation={"draws": 1000, "test_dots": 400})
    assert study.main(large) == 2 and not checkout.calls
    assert study.main(large, "--cluster", "slurm") == study.main(large, "--executor", "lsf") == 0
    assert "--resources=mem_mb=4100" not in [word for call in checkout.calls for word in call]
    checkout.calls.clear()
    assert study.main(checkout.config(), "--resources", "mem_mb=1000") == 0
    assert checkout.calls[0][-2:] == ("--resources", "mem_mb=1000")  # Snakemake takes the last
    checkout.calls.clear()
    monkeypatch.setattr(needs, "memory_of_machine", lambda: float("inf"))
    assert study.main(checkout.config()) == 0 and checkout.calls[0] == ("--nolock",)


def test_what_an_earlier_run_said_is_not_said_again(checkout, capsys):
    logs = checkout.root / "results" / "mine" / "logs"
    logs.mkdir(parents=True)
    for name, when in (("old.log", 1000), ("new.log", 3000)):
        (logs / name).write_text(f"INFO begins\nERROR {name} went wrong\n")
        os.utime(logs / name, (when, when))
    study.print_results(logs.parent, 1, 2000, {"p": "not finished", "new": "new.log went wrong"})
    said = capsys.readouterr().err
    assert said.count("new.log") == 1 and said.endswith("- new: new.log went wrong\n- p: not finished\n")
    assert "- new: new.log went wrong" in said and "old" not in said and "begins" not in said
    assert "read first" not in said
    (logs.parent / "index.html").write_text("")
    study.print_results(logs.parent, 1, 2000, {})
    assert "Of the rest, read first: results/mine/index.html" in capsys.readouterr().err


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


@contextmanager
def long_study(checkout):
    """study.py as a process with a Snakemake that runs for a minute; its process and Snakemake's id."""
    shutil.copytree(ROOT / "scripts", checkout.root / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
    (checkout.root / "snakemake.py").write_text(LONG)
    command = [sys.executable, checkout.root / "scripts" / "study.py", checkout.config()]
    said = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    # a job in the background of a shell passes on that Ctrl-C is ignored
    heed = {"start_new_session": True, "preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
    process = subprocess.Popen(command, **said, **heed)
    pid, deadline = checkout.root / "pid", time.monotonic() + 60
    while not (pid.is_file() and pid.read_text()):
        assert process.poll() is None and time.monotonic() < deadline, process.communicate()
        time.sleep(0.05)
    time.sleep(0.2)  # until both wait
    try:
        yield process, int(pid.read_text())
    finally:
        with suppress(ProcessLookupError):  # both have ended
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def test_ctrl_c_waits_until_jobs_are_cancelled_and_ends_with_a_sentence(checkout):
    with long_study(checkout) as (process, _):
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to both
        said = process.communicate(timeout=30)[1]
    assert process.returncode == 130 and (checkout.root / "cancelled").exists()
    assert said.splitlines()[-1].startswith("Stopped; ") and "study.py" not in said


def test_sigterm_is_passed_on(checkout):
    with long_study(checkout) as (process, _):
        process.terminate()
        said = process.communicate(timeout=30)[1]
    assert process.returncode == 143 and (checkout.root / "cancelled").exists()
    assert said == "\nStopped; what was made stays, and the same command continues where it was.\n"


def test_the_lock_lasts_as_long_as_snakemake(checkout, capsys):
    with long_study(checkout) as (process, snakemake):
        process.kill()
        process.wait()
        assert study.main(checkout.config()) == 2
        assert "Another study runs in this folder" in capsys.readouterr().err
        os.kill(snakemake, signal.SIGKILL)
        deadline = time.monotonic() + 30
        while study.main(checkout.config()) and time.monotonic() < deadline:
            time.sleep(0.05)
    assert "Results: results/mine/" in capsys.readouterr().out


def test_ctrl_c_between_two_steps_is_a_sentence_too(checkout, capsys, monkeypatch):
    def pressed(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(study, "finish", pressed)
    assert study.main(checkout.config()) == 130
    assert capsys.readouterr().err.startswith("\nStopped; what was made stays")
