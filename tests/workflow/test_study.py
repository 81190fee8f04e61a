"""`make run` from its outside: what is said before and after, signals, the exit code; Snakemake itself is played."""

import errno
import fcntl
import os
import shutil
import signal
import subprocess
import sys
import time
from base64 import b64encode
from contextlib import chdir, contextmanager, suppress
from pathlib import Path

import pytest
import yaml

import study
from conftest import ROOT
from sparsurf.workflow import cluster, ending, needs
from sparsurf.workflow.results import made

STRUCTURE = {"structure": str(ROOT / "data" / "tdp43" / "topology.pdb")}


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """An empty checkout; Snakemake leaves its options in `calls`, does the next of `work` and ends with the next of `codes`."""

    class Checkout:
        root, calls, codes, work = tmp_path / "checkout", [], [], []

        def config(self, **keys):
            path = tmp_path / "mine.yaml"
            given = {"proteins": {"p": STRUCTURE}, "run": "mine"} | keys
            path.write_text(yaml.safe_dump(given, sort_keys=False))
            return str(path)

        def make(self, *files):
            for file in files:
                path = own.root / "results" / "mine" / file
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text("minimal_n_S_percent\n4.5\n" if file == "surfaces.csv" else "a\n1\n")
                if not file.startswith(("logs/", "report.")):
                    self.record(file)

        def record(self, file):
            """Have the file in the log of a job, as what the job made."""
            log = own.root / "results" / "mine" / "logs" / f"{file.replace('/', '_')}.log"
            log.parent.mkdir(parents=True, exist_ok=True)
            with chdir(own.root):
                log.write_text("".join(f"{line}\n" for line in made([f"results/mine/{file}"])))
            note = b64encode(f"results/mine/{file}".encode(), b"_-").decode()  # as Snakemake keeps them
            (own.root / ".snakemake" / "metadata").mkdir(parents=True, exist_ok=True)
            (own.root / ".snakemake" / "metadata" / note).write_text("{}")

    own = Checkout()
    own.root.mkdir()
    (own.root / "config.yaml").write_bytes((ROOT / "config.yaml").read_bytes())
    for name in ("data", "profiles"):
        (own.root / name).symlink_to(ROOT / name)

    def played(root, files, *options, errors=None, begun=None):
        own.calls.append([*map(str, options)])
        own.files = [Path(path).name for path in files]
        if own.work:
            own.work.pop(0)()
        elif "--report" in options:
            own.make("report.html")
        return own.codes.pop(0) if own.codes else 0

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(study, "ROOT", own.root)
    monkeypatch.setattr(needs, "memory_of_machine", lambda: 4.1e9)
    monkeypatch.setattr(study, "snakemake", played)
    return own


def test_a_study_ends_with_a_report_and_five_lines(checkout, capsys):
    made = ("surfaces.csv", "warnings.csv", "index.html")
    checkout.work = [lambda: checkout.make(*made)]
    assert study.main(checkout.config(), "--cores", "2") == 0
    first, report = checkout.calls
    assert first == ["--logger", "sparsurf", "--resources=mem_mb=4100", "--cores", "2"]
    assert report == ["--quiet", "all", "--report", "results/mine/report.html"]
    lines = capsys.readouterr().out.strip().splitlines()
    assert [line.split()[0] for line in lines] == ["Time", "Answer", "Warnings", "Look", "All"]
    assert lines[1].endswith(" 4.5 % of the dots are enough.") and lines[2].split()[1] == "1"
    checkout.calls.clear()
    (checkout.root / "results/mine/surfaces.csv").write_text("minimal_n_S_percent\n4\n7\n5\n")
    os.utime(checkout.root / "results/mine/surfaces.csv", (0, 0))
    checkout.record("surfaces.csv")
    (checkout.root / "results/mine/session.pse").write_text("somebody else's, newer than the pages")
    assert study.main(checkout.config()) == 0 and len(checkout.calls) == 1  # nothing is newer
    assert "5.0 % of the dots are enough (median of 3 surfaces)." in capsys.readouterr().out
    os.utime(checkout.root / "results/mine/report.html", (0, 0))
    assert study.main(checkout.config()) == 0 and len(checkout.calls) == 3


def test_a_part_of_a_study_ends_without_a_report(checkout, capsys):
    said = "What was asked for is in results/mine/. The rest of the study was not made, nor its report."
    checkout.work = [lambda: checkout.make("p/c1/surface.npz")]
    assert study.main(checkout.config(), "--until", "make_surface") == 0 and len(checkout.calls) == 1
    assert said in capsys.readouterr().out
    checkout.make("index.html", "report.html")
    os.utime(checkout.root / "results/mine/index.html", (1e9, 1e9))  # of an earlier run, beside newer tables
    assert study.main(checkout.config(), "results/mine/p/c1/surface.npz") == 0 and len(checkout.calls) == 2
    assert said in capsys.readouterr().out


def failing(checkout, *logs):
    """Work of a Snakemake of which some jobs failed."""

    def work():
        checkout.make(*(f"logs/{log}.log" for log in logs))
        for log in logs:
            (checkout.root / f"results/mine/logs/{log}.log").write_text(f"INFO fine\nERROR {log} is bad.\n")
        with open(os.environ[ending.FAILED], "a") as stream:
            stream.writelines(f"results/mine/logs/{log}.log\n" for log in logs)

    return work


def test_where_one_protein_failed_the_pages_and_the_report_of_the_others_come_out(checkout, capsys):
    checkout.make("q/frames.csv")
    checkout.work = [failing(checkout, "p/choose_frames"), lambda: checkout.make("index.html")]
    checkout.codes = [1, 0, 0]
    assert study.main(checkout.config(proteins={"p": STRUCTURE, "q": STRUCTURE})) == 1
    assert [call[0] for call in checkout.calls] == ["--logger", "--logger", "--quiet"]
    assert checkout.files == ["mine.yaml", "without.yaml"]
    without = yaml.safe_load((checkout.root / ".snakemake" / "without.yaml").read_text())
    assert without == {"without": {"p": "choose_frames: p/choose_frames is bad."}}
    said = capsys.readouterr()
    assert "- p/choose_frames: p/choose_frames is bad." in said.err and "Look at" in said.out


def test_where_nothing_is_left_there_is_no_second_try(checkout, capsys):
    checkout.work, checkout.codes = [failing(checkout, "p/choose_frames")], [1]
    assert study.main(checkout.config()) == 1 and len(checkout.calls) == 1
    assert "Not everything could be made. What was made is in results/mine/." in capsys.readouterr().err


def test_what_snakemake_alone_complains_of_is_said(checkout, capsys):
    checkout.make("index.html")  # of an earlier run

    def complain():
        (checkout.root / "results" / "mine" / "logs" / "snakemake.err").write_text(
            f"{ending.PROFILE} profiles/default\nusage: many\nlines\nsnakemake: error: four is no number\n\n"
        )

    checkout.codes, checkout.work = [1], [complain]
    assert study.main(checkout.config(), "--no-such-option") == 1
    said = capsys.readouterr()
    assert "\nsnakemake: error: four is no number\n" in said.err and "usage" not in said.err
    assert "See results/mine/logs/snakemake.err and the newest file" in said.err
    assert "results/mine/index.html is of an earlier run." in said.err and "Look at" not in said.out


def test_an_answer_of_another_config_is_not_given_for_this_one(checkout, capsys):
    """The pages of a run before are there, and all that this one should make failed."""
    checkout.make("surfaces.csv", "index.html")
    assert ending.is_complete(checkout.root / "results" / "mine")
    checkout.work, checkout.codes = [failing(checkout, "p/choose_frames")], [1]
    assert study.main(checkout.config()) == 1
    said = capsys.readouterr()
    assert "Answer" not in said.out and "results/mine/index.html is of an earlier run." in said.err


@pytest.mark.parametrize("options", [[], ["--forceall"]])
def test_results_of_which_nothing_is_known_are_not_taken_for_this_config(checkout, capsys, options):
    checkout.make("index.html", "surfaces.csv")
    shutil.rmtree(checkout.root / ".snakemake" / "metadata")
    assert study.main(checkout.config(), *options) == (0 if options else 2)
    assert bool(checkout.calls) == bool(options)
    if not options:
        said = capsys.readouterr().err
        assert "results/mine was made in another checkout" in said and "--forceall" in said


def test_words_before_the_config_are_options_of_the_default_study(checkout):
    for words in (["compare"], ["-n"], ["--cores", "2"]):
        checkout.calls.clear()
        study.main(*words)
        assert checkout.calls and checkout.files[0] == "config.yaml"
    assert "2" in checkout.calls[0]


def test_a_comparison_that_cannot_be_is_refused_before_anything_runs(checkout, capsys):
    assert study.main(checkout.config(sampling=False), "compare") == 2 and not checkout.calls
    assert "sampling is false, but `compare` needs its grid" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("logs", "without"),
    [
        (["p/c2/make_surface"], {"p/c2": "make_surface: ?", "pairs/both": "?", "sites/one": "?"}),
        (["p/fetch_x.pdb"], {"p": "fetch_x.pdb: ?", "pairs/both": "?", "sites/one": "?", "sites/two": "?"}),
        (["p/draw_frames"], {"p/*": "draw_frames: ?"}),
        (["p/c3/draw_view", "p/c3/draw_figures"], {"p/c3": "draw_figures: ?", "sites/two": "?"}),
        (["pairs/files/draw_pair"], {"pairs/files": "draw_pair: ?"}),
        (["p/c3/describe_places"], {"p/c3/describe_places": "describe_places: ?", "sites/two": "?"}),
        (["sites/two/find_site"], {"sites/two": "find_site: ?"}),
        (["reproduce_paper"], {"reproduce_paper": "reproduce_paper: ?"}),
    ],
)
def test_what_failed_is_left_out_with_what_needs_it(tmp_path, logs, without):
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "frames.csv").write_text("conformation\nc2\nc3\n")
    pairs = {"both": {"proteins": ["q", "p"]}, "files": {"files": ["a", "b"]}}
    config = {"without": {}, "proteins": {"p": {}, "q": {"surface": "x"}}, "pairs": pairs}
    config["sites"] = {"one": {"query": "p"}, "two": {"query": "p/c3", "targets": ["q"]}}
    found = ending.left_out(config, tmp_path, [tmp_path / "logs" / f"{log}.log" for log in logs])
    assert found.keys() == without.keys()
    assert all(found[key].startswith(said.rstrip("?")) for key, said in without.items())
    assert ending.something_is_left(config, tmp_path, found)
    everything = found | dict.fromkeys(["p", "q/c1", "pairs/both", "pairs/files"], "x")
    assert not ending.something_is_left(config, tmp_path, everything)
    assert ending.something_is_left(
        config, tmp_path, {"q": "", "p/c2": "", "pairs/both": "", "pairs/files": ""}
    )


def test_a_protein_without_any_conformation_is_left_out_itself(tmp_path):
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "frames.csv").write_text("conformation\nf0002\nf0013\n")
    config = {"without": {"p/f13": "asked for"}, "proteins": {"p": {}}, "pairs": {"files": {}}, "sites": {}}
    config["pairs"]["files"] = {"files": ["a", "b"]}
    found = ending.left_out(config, tmp_path, [tmp_path / "logs/p/f0002/make_surface.log"])
    assert found["p"] == "None of its conformations could be finished." and len(found) == 3
    assert ending.left_out(config, tmp_path, []).keys() == {"p/f13"}
    ready = config | {"without": {}, "proteins": {"q": {"surface": "x"}}}
    assert {*ending.left_out(ready, tmp_path, [tmp_path / "logs/q/c1/take_surface.log"])} == {"q", "q/c1"}
    assert not ending.something_is_left(config | {"pairs": {}}, tmp_path, found)


def test_results_of_another_run_are_not_touched(checkout, capsys):
    """The folder of a run may be a copy of another's, whose logs name the files there."""
    checkout.make("p/c1/grid.csv")
    there = checkout.root / "results" / "other" / "p" / "c1" / "grid.csv"
    there.parent.mkdir(parents=True)
    there.write_text("made anew since\n")
    log = checkout.root / "results/mine/logs/p/c1/evaluate_grid.log"
    log.parent.mkdir(parents=True)
    log.write_text("MADE 4 0 0123456789abcdef results/other/p/c1/grid.csv\n")
    study.main(checkout.config())
    assert there.read_text() == "made anew since\n" and "regenerated" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("compare", "kept_up"), [(None, True), ({"percents": [5, 10]}, True), (False, False), (True, False)]
)
def test_a_comparison_is_kept_up_unless_the_config_says(checkout, capsys, compare, kept_up):
    checkout.make("compare.csv")
    asked = {} if compare is None else {"compare": compare}
    study.main(checkout.config(**asked), "--dry-run")
    assert (
        ("keeps up its comparison" in capsys.readouterr().out)
        == kept_up
        == ("compare.yaml" in checkout.files)
    )


def test_a_result_that_was_changed_is_regenerated(checkout, capsys):
    checkout.make("p/c1/grid.csv", "p/c1/ranges.csv", "logs/p/c1/evaluate_grid.log")
    log = checkout.root / "results/mine/logs/p/c1/evaluate_grid.log"
    log.write_text("MADE 4 0 0123456789abcdef results/mine/p/c1/grid.csv\n")
    study.main(checkout.config())
    assert not (checkout.root / "results/mine/p/c1/grid.csv").exists()
    assert (checkout.root / "results/mine/p/c1/ranges.csv").exists()
    assert (
        "results/mine/p/c1/grid.csv is not what the study wrote: it is regenerated."
        in capsys.readouterr().out
    )


def test_a_full_disk_is_told(checkout, capsys, monkeypatch):
    monkeypatch.setattr(ending.shutil, "disk_usage", lambda _: needs_free(0))
    checkout.codes = [1]
    assert study.main(checkout.config()) == 1
    said = capsys.readouterr().err
    assert "The disk of results/mine/ is full. Free some space and run again" in said
    assert "snakemake.err" not in said and said.count("is full") == 1


def test_a_full_disk_of_snakemake_alone_is_told(checkout, capsys, monkeypatch):
    monkeypatch.setattr(
        ending.shutil, "disk_usage", lambda path: needs_free(0 if str(path) == ".snakemake" else 10**9)
    )
    checkout.codes = [1]
    assert study.main(checkout.config()) == 1
    assert "The disk of .snakemake/ is full." in capsys.readouterr().err


def test_a_disk_that_is_full_at_once_or_while_a_report_is_written_is_a_sentence(
    checkout, capsys, monkeypatch
):
    def without_room():
        raise OSError(errno.ENOSPC, "No space left on device", "results/mine/x")

    checkout.work = [without_room]
    assert study.main(checkout.config()) == 2
    said = capsys.readouterr().err
    assert said == "results/mine/x: No space left on device. Free or repair the disk and run again.\n"
    files = ("surfaces.csv", "warnings.csv", "index.html")
    checkout.work = [lambda: checkout.make(*files), lambda: checkout.make("report.html")]
    checkout.codes = [0, 1]
    assert study.main(checkout.config()) == 1
    assert "no report could be written" in capsys.readouterr().out
    assert not (checkout.root / "results/mine/report.html").exists()


def needs_free(free):
    return type("Usage", (), {"free": free})


@pytest.mark.parametrize("odd", [" ", "(", "'", "$"])
def test_a_path_that_no_job_starts_by_is_refused_at_once(checkout, monkeypatch, capsys, odd):
    monkeypatch.setattr(study.sys, "executable", f"/home/my{odd}work [1] ü/.venv/bin/python")
    assert study.main(checkout.config()) == 2 and checkout.calls == []
    assert f"Snakemake starts no job by a path with {odd!r}. Move" in capsys.readouterr().err
    monkeypatch.setattr(study.sys, "executable", "/home/my-work.[1]_ü,@+=~/.venv/bin/python")
    assert study.main(checkout.config()) == 0


@pytest.mark.parametrize("word", ["-h", "--help"])
def test_help_is_given_and_nothing_made(checkout, capsys, word):
    assert study.main(word) == 0 and checkout.calls == []
    assert "`python scripts/study.py [config.yaml]" in capsys.readouterr().out
    assert study.main(checkout.config(), word) == 0 and checkout.calls[0][-1] == word  # Snakemake's own


@pytest.mark.parametrize("options", [("--config", "seed=3"), ("-C", "seed=3"), ("--configfile=b.yaml",)])
def test_a_second_config_is_refused(checkout, capsys, options):
    path = checkout.config()
    assert study.main(path, *options) == 2 and not checkout.calls
    assert f"{options[0]}: a study has one config file. Write into {path}" in capsys.readouterr().err


@pytest.mark.parametrize("word", ["-n", "-np", "--dry-run", "--dryrun"])
def test_a_dry_run_writes_nothing(checkout, word):
    checkout.codes = [7]
    assert study.main(checkout.config(), word) == 7
    assert len(checkout.calls) == 1 and not (checkout.root / "results").exists()


@pytest.mark.parametrize(
    "config, sentence",
    [
        ({"run": "../.."}, "'../..' in run cannot name a folder"),
        ({"run": "README.md"}, "results/README.md is a file"),
        ({"minimal": {"sampler": "farthst", "n_S": 3}}, "did you mean 'farthest'?"),
    ],
)
def test_a_bad_config_ends_before_anything_runs(checkout, capsys, config, sentence):
    (checkout.root / "results").mkdir()
    (checkout.root / "results" / "README.md").write_text("")
    assert study.main(checkout.config(**config)) == 2
    assert sentence in capsys.readouterr().err and not checkout.calls
    assert study.main("none.yaml") == 2
    assert "There is no config file 'none.yaml'; give one with CONFIG=" in capsys.readouterr().err


def test_a_config_without_proteins_changes_the_default_study(checkout, tmp_path):
    (tmp_path / "seed.yaml").write_text("seed: 5\nrun: other\n")
    assert study.main("seed.yaml") == 0
    assert (checkout.root / "results" / "other").is_dir()
    pair = {"complex": STRUCTURE["structure"], "chains": [["A"], ["B"]]}
    (tmp_path / "pairs.yaml").write_text(yaml.safe_dump({"run": "two", "pairs": {"mine": pair}}))
    found = study.checked_config(tmp_path / "pairs.yaml", "pairs.yaml")
    assert found["proteins"] == {} and list(found["pairs"]) == ["mine"]


def test_a_comparison_is_part_of_the_study_and_a_run_that_was_compared_stays_so(checkout, capsys):
    assert study.main(checkout.config(), "--cores", "2", "compare") == 0
    assert "compare" not in checkout.calls[0] and checkout.files == ["mine.yaml", "compare.yaml"]
    assert yaml.safe_load(study.COMPARE.read_text()) == {"compare": {"run": True}}
    assert study.main(checkout.config()) == 0 and checkout.files == ["mine.yaml"]
    checkout.make("compare.csv")
    assert study.main(checkout.config()) == 0 and checkout.files == ["mine.yaml", "compare.yaml"]
    assert "results/mine keeps up its comparison of samplers." in capsys.readouterr().out
    assert study.main(checkout.config(compare={"percents": [5]})) == 0 and len(checkout.files) == 2
    for own in ({"sampling": False}, {"compare": {"run": False}}):
        assert study.main(checkout.config(**own)) == 0 and checkout.files == ["mine.yaml"]


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


def test_memory_counts_where_jobs_run_on_this_machine(checkout, monkeypatch, capsys):
    monkeypatch.setattr(cluster, "_answer", lambda *command: "")
    monkeypatch.setattr(study, "TELL", 10**7)
    assert study.main(checkout.config(evaluation={"draws": 3, "test_dots": 400})) == 0
    assert "The grid of one surface will need about 0.1 GB of memory." in capsys.readouterr().out
    large, checkout.calls[:] = checkout.config(evaluation={"draws": 1000, "test_dots": 400}), []
    assert study.main(large) == 2 and not checkout.calls
    assert study.main(large, "--cluster", "slurm") == study.main(large, "--executor", "lsf") == 0
    assert "--resources=mem_mb=4100" not in [word for call in checkout.calls for word in call]
    checkout.calls.clear()
    assert study.main(checkout.config(), "--resources", "mem_mb=1000") == 0
    assert checkout.calls[0][-2:] == ["--resources", "mem_mb=1000"]  # Snakemake takes the last


@pytest.mark.parametrize(("options", "given"), [([], "none"), (["foo"], "foo")])
def test_a_cluster_that_is_not_known_is_a_sentence(checkout, capsys, options, given):
    assert study.main(checkout.config(), "--cluster", *options) == 2 and not checkout.calls
    said = capsys.readouterr().err
    assert said == f"--cluster needs the name of a folder in profiles/, as slurm, but has {given}.\n"


NODES = "main* 16\nmain* 4+\nlarge 64\n"
NO_ACCOUNTS = ["--slurm-status-command", "squeue", "--slurm-no-account"]


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        ({"sacct": "", "sinfo": NODES}, ["--max-threads", "15"]),
        ({"sinfo": NODES}, [*NO_ACCOUNTS, "--max-threads", "15"]),
        (
            {"sacct": "", "sinfo": "main* 1\n"},
            ["--max-threads", "1", "--groups", "compare_samplers=conformation"],
        ),
        ({}, NO_ACCOUNTS),
    ],
)
def test_a_cluster_is_asked_for_no_more_than_it_has(monkeypatch, answers, words):
    monkeypatch.setattr(cluster, "_answer", lambda program, *_: answers.get(program))
    found = cluster.replaced(cluster.parted(["--cluster=slurm", "-n"]), ROOT / "profiles")
    own = ["--slurm-jobname-prefix", cluster.NAME]
    assert found == ["-n", "--workflow-profile", str(ROOT / "profiles" / "slurm"), *own, *words]
    fewer = cluster.replaced(cluster.parted(["--cluster", "slurm", "--max-threads=2"]), ROOT / "profiles")
    assert fewer[:2] == ["--max-threads", "2"] and "--max-threads" not in fewer[2:]
    assert cluster.replaced(["--cores", "2"], ROOT / "profiles") == ["--cores", "2"]


def test_on_nodes_of_few_cores_fewer_rules_run_side_by_side(monkeypatch):
    monkeypatch.setattr(
        cluster, "_answer", lambda program, *_: {"sacct": "", "sinfo": "main* 2\n"}.get(program)
    )
    found = cluster.replaced(["--cluster", "slurm"], ROOT / "profiles")
    groups = dict(each.split("=") for each in found[found.index("--groups") + 1 :])
    assert {*groups.values()} == {"conformation"} and {"evaluate_grid", "measure_floors"} <= groups.keys()
    assert not {"tabulate_residues", "compare_samplers"} & groups.keys()


def test_a_job_that_never_begins_ends_the_run_in_a_sentence(monkeypatch, capsys):
    rows = [("7", "Priority"), ("8", "PartitionConfig"), ("9", "Resources"), ("10", "PartitionTimeLimit")]
    lines = "".join(f"{job} {cluster.NAME}_x ({reason})\n" for job, reason in rows)
    lines += "11 somebodys_job (PartitionConfig)\n\n"
    monkeypatch.setattr(cluster, "_answer", lambda *_: lines)
    assert cluster.never_begins() == [("8", "PartitionConfig"), ("10", "PartitionTimeLimit")]
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    cluster.watch(process)
    assert process.wait(timeout=30) != 0
    assert "Slurm will never start job 8 (PartitionConfig). Ask for less" in capsys.readouterr().out


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
    for part in ("scripts", "src"):
        shutil.copytree(ROOT / part, checkout.root / part, ignore=shutil.ignore_patterns("__pycache__"))
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
    assert said.splitlines()[-1].startswith("Stopped. ") and "study.py" not in said


def test_sigterm_is_passed_on(checkout):
    with long_study(checkout) as (process, _):
        process.terminate()
        said = process.communicate(timeout=30)[1]
    assert process.returncode == 143 and (checkout.root / "cancelled").exists()
    assert said == "\nStopped. What was made stays; the same command continues where it was.\n"


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


def test_the_answer_is_that_of_surfaces_of_this_study(tmp_path, capsys):
    (tmp_path / "surfaces.csv").write_text("minimal_n_S_percent\n12.0\n")  # of an earlier one in its folder
    for proteins, told in (({"p": STRUCTURE}, True), ({}, False)):
        ending.summary({"proteins": proteins, "minimal": {"floor": "turned"}}, tmp_path, 0, [], time.time())
        assert ("Answer    12.0 % of the dots are enough." in capsys.readouterr().out) is told
