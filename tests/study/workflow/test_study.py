"""`make run` from its outside: what is said before and after, the exit code; Snakemake itself is played."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from conftest import ROOT
from sparsurf_study import run_study as study
from sparsurf_study.config import memory
from sparsurf_study.workflow import ends, folders
from sparsurf_study.workflow.ends import BEFORE_CONFORMATIONS, failed_places
from sparsurf_study.workflow.job_logs import USED_MARK

CRATE = '{"@graph": [{"@id": "ro-crate-metadata.json"}, {"@id": "./", "abstract": ["first", "second"]}]}'
STRUCTURE = {"structure": str(ROOT / "data" / "tdp43" / "topology.pdb")}
CLOSING = ("failures.csv", "warnings.csv", "checks.csv", "index.html", "ro-crate-metadata.json")


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
                path.write_text(CRATE if "crate" in file else "file\n" if "checks" in file else "a\n1\n")

    def play(files, *options):
        played_checkout.calls.append([*map(str, options)])
        played_checkout.files, played_checkout.paths = [path.name for path in files], files
        if played_checkout.work:
            played_checkout.work.pop(0)()
        return (played_checkout.codes.pop(0) if played_checkout.codes else 0), False

    played_checkout = Checkout()
    played_checkout.root.mkdir()
    (played_checkout.root / "config.yaml").write_bytes((ROOT / "config.yaml").read_bytes())
    for name in ("Snakefile", "data", "profiles", "src", "studies"):
        (played_checkout.root / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(folders, "CHECKOUT", played_checkout.root)
    for module in (study, memory):
        monkeypatch.setattr(module, "memory_of_machine", lambda: 4.1e9)
    monkeypatch.setattr(study, "snakemake", play)
    return played_checkout


def test_a_study_without_anything_to_do_says_its_answers_and_where_to_look(checkout, capsys):
    checkout.make(*CLOSING, "SHA256SUMS")
    os.utime(checkout.root / "results/mine/SHA256SUMS", (10**9, 10**9))
    assert study.main(checkout.config(), "--cores", "2") == 0
    assert checkout.calls == [["--resources=mem_mb=4100", "--cores", "2"]]
    lines = capsys.readouterr().out.strip().splitlines()
    assert [line.split()[0] for line in lines[:4]] == ["Answer", "Answer", "Failed", "Warnings"]
    assert (
        lines[:2] == ["Answer    first", "Answer    second"] and "1 in results/mine/warnings.csv" in lines[3]
    )
    assert lines[-1] == "Look at   results/mine/index.html"
    for is_there in (False, True):  # of the paper's study, once it has compared the tables
        if is_there:
            checkout.make("verdict.html")
        look = ends.answers_of_run(checkout.root / "results/mine", is_paper=True).splitlines()[-1]
        assert look.endswith(("index.html", "verdict.html")[is_there])


@pytest.mark.parametrize(
    "words", [[], ["-n"], ["--cores", "3"], ["compare"], ["mine.yaml"], ["sub/../mine.yaml", "-n"]]
)
def test_the_config_is_that_of_the_checkout_or_lies_where_the_command_was_given(checkout, words):
    own, named = Path(checkout.config()), [word for word in words if word.endswith(".yaml")]
    (own.parent / "sub").mkdir()
    assert study.main(*words) == 0
    wanted = own if named else checkout.root / "config.yaml"
    assert checkout.paths[0].resolve() == wanted and len(checkout.paths) == 1 + ("compare" in words)
    options = [word for word in words if word.startswith("-") or word.isdigit()]
    assert checkout.calls[0][len(checkout.calls[0]) - len(options) :] == options


def write_log(run, job, text=""):
    """Write the log of a job of a run."""
    path = run / "logs" / f"{job}.log"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def test_a_run_with_failed_jobs_is_closed_by_a_second_start_without_them(checkout):
    """The exit code is that of the first; a job that fails again is not tried a third time."""

    def fail():
        write_log(checkout.root / "results/mine", "p/c1/draw_view", "ERROR too small\n")

    checkout.codes, checkout.work = [1, 0], [fail, fail]
    both = {"p": STRUCTURE, "q": STRUCTURE}
    assert study.main(checkout.config(proteins=both)) == 1
    first, second = checkout.calls
    assert second == first
    assert yaml.safe_load(checkout.paths[-1].read_text()) == {"exclude": {"p/c1": "draw_view: too small"}}
    checkout.codes, checkout.calls[:], checkout.work = [1], [], [fail]
    assert study.main(checkout.config(exclude={"p/c1": "by hand"}, proteins=both)) == 1
    assert len(checkout.calls) == 1
    checkout.codes, checkout.calls[:], checkout.work = [1], [], [fail]  # nothing is left
    assert study.main(checkout.config()) == 1 and len(checkout.calls) == 1


def test_a_run_is_not_closed_where_a_job_of_a_batch_was_killed(checkout):
    """Structures without a row are neither surfaces nor failures."""
    checkout.codes = [1]
    checkout.work = [lambda: write_log(checkout.root / "results/mine", "analyse_batch_0001")]
    structures = {f"p{k}": STRUCTURE for k in range(12)}
    assert study.main(checkout.config(proteins=structures, sampling=False)) == 1 and len(checkout.calls) == 1


@pytest.mark.parametrize(
    ("logs", "exclude"),
    [
        (["p/c2/compute_surface"], {"p/c2": "compute_surface: ?", "pairs/both": "?", "changes/one": "?"}),
        *(
            ([f"p/{job}"], {"p": f"{job}: ?", "pairs/both": "?", "changes/one": "?", "changes/two": "?"})
            for job in (
                "fetch_x.pdb",
                "prepare_system",
                "simulate_nvt",
                "extract_trajectory",
                "choose_frames",
            )
        ),
        (["p/draw_frames"], {"p/*": "draw_frames: ?"}),
        (["p/c3/draw_view", "p/c3/draw_figures"], {"p/c3": "draw_view: ?", "changes/two": "?"}),
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
    """Not what failed in an earlier run, or what a second attempt finished."""
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "frames.csv").write_text("conformation\nc2\nc3\n")
    pairs = {"both": {"proteins": ["q", "p"]}, "files": {"files": ["a", "b"]}}
    config = {"exclude": {}, "sampling": {"run": True}, "pairs": pairs}
    config["proteins"] = {"p": {}, "q": {"surface": "x"}}
    config["changes"] = {"one": ["p", "p/c2"], "two": ["p/c3", "q"]}
    for log in logs:
        write_log(tmp_path, log)
    write_log(tmp_path, "q/c1/measure_floors", f"ERROR no memory.\n{USED_MARK}1 s\n")
    write_log(tmp_path, "q/c1/draw_roughness")
    os.utime(tmp_path / "logs/q/c1/draw_roughness.log", (10**9, 10**9))
    found = failed_places(config, tmp_path, 2e9 / 2 + 1)
    assert found.keys() == exclude.keys()
    assert all(found[place].startswith(reason.rstrip("?")) for place, reason in exclude.items())


def test_every_job_of_a_protein_is_known_to_come_before_or_after_its_conformations():
    """A job that comes before them and is not listed would stop the run of the other proteins."""
    rules = "".join(path.read_text() for path in (ROOT / "Snakefile", *(ROOT / "rules").glob("*.smk")))
    jobs = set(re.findall(r'"results/\{run\}/logs/\{protein\}/(\w+)[^/"]*\.log"', rules))
    after = {job for job in jobs if not job.startswith(BEFORE_CONFORMATIONS)}
    assert after == {"draw_frames", "follow_frames_", "follow_ensemble", "draw_ensemble"}


@pytest.mark.parametrize(
    ("config", "options", "words"),
    [
        ({"run": "../.."}, [], "run cannot name"),
        ({"run": "README.md"}, [], "results/README.md is a file"),
        ({"minimal": {"sampler": "farthst", "n_dots": 3}}, [], "you mean 'farthest'"),
        ({"sampling": False}, ["compare"], "false.* `compare`"),
        ({"sampling": False, "compare": {"run": False}}, ["compare"], "false.* `compare`"),
        ({"compare": {"samplers": ["paper"]}}, ["compare"], "compare.samplers names paper"),
        (None, [], "none.yaml"),
        (".snakemake", [], ".snakemake"),
    ],
)
def test_a_mistake_ends_before_anything_runs(checkout, capsys, config, options, words):
    if isinstance(config, str):
        (checkout.root / config).symlink_to("/proc/no/such/place")  # where even root may not write
        config = {}
    elif config:
        (checkout.root / "results").mkdir()
        (checkout.root / "results" / "README.md").write_text("")
    path = "none.yaml" if config is None else checkout.config(**config)
    assert study.main(path, *options) == 2 and not checkout.calls
    assert re.search(words, " ".join(capsys.readouterr().err.split()))


@pytest.mark.parametrize(
    ("name", "run"),
    [
        ("my study (2).yaml", "my_study__2_"),
        ("default_of_mine.yml", "default_of_mine"),
        (f"{'a' * 120}.yaml", "a" * 100),
    ],
)
def test_a_config_without_a_run_gives_its_name_to_the_results(checkout, tmp_path, capsys, name, run):
    """Also one that changes the default study key by key, so that it does not overwrite its results."""
    for content in ({"proteins": {"p": STRUCTURE}}, {"seed": 3}):
        (tmp_path / name).write_text(yaml.safe_dump(content))
        for file in (*CLOSING, "SHA256SUMS"):
            checkout.make(f"../{run}/{file}")
            os.utime(checkout.root / "results" / run / file, (10**9, 10**9))
        assert study.main(str(tmp_path / name)) == 0
        assert f"results/{run}/index.html" in capsys.readouterr().out


def test_a_config_whose_name_names_no_folder_needs_a_run(checkout, tmp_path, capsys):
    """Two of them would write into one folder, or into that of the default study."""
    for name in ("é.yaml", "ü.yaml", "_.yml"):
        (tmp_path / name).write_text("seed: 3\n")
        assert study.main(str(tmp_path / name)) == 2 and not checkout.calls
        assert "`run` into" in capsys.readouterr().err
    (tmp_path / "é.yaml").write_text("run: own\nseed: 3\n")
    assert study.main(str(tmp_path / "é.yaml")) == 0


def test_a_comparison_is_added_to_the_study(checkout):
    assert study.main(checkout.config(), "--cores", "2", "compare") == 0
    assert "compare" not in checkout.calls[0] and checkout.files == ["mine.yaml", "compare.yaml"]
    assert yaml.safe_load(checkout.paths[1].read_text()) == {"compare": {"run": True}}
    assert study.main(checkout.config()) == 0 and checkout.files == ["mine.yaml"]
    assert study.main(checkout.config(compare={"run": False, "percents": [30]}), "compare") == 0


def test_memory_counts_where_jobs_run_on_this_machine(checkout):
    large = checkout.config(evaluation={"draws": 1000, "test_dots": 400})
    assert study.main(large) == 2 and not checkout.calls
    (checkout.root / "p").mkdir()
    (checkout.root / "p" / "config.yaml").write_text("jobs: 1\n")
    assert study.main(checkout.config(), "--workflow-profile", str(checkout.root / "p")) == 0
    assert study.main(checkout.config(), "--resources", "mem_mb=1000") == 0
    assert "--resources=mem_mb=4100" not in checkout.calls[0]
    assert checkout.calls[1][-2:] == ["--resources", "mem_mb=1000"]  # Snakemake takes the last


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
def test_make_takes_a_config_with_a_blank_and_refuses_an_unknown_cluster_and_folders_that_fail(tmp_path):
    def make(*options, folder=ROOT, targets=("run",)):
        ours = ("MAKEFLAGS", "CLUSTER", "CONFIG", "CORES")  # given to `make test`
        alone = {name: value for name, value in os.environ.items() if name not in ours}
        command = ["make", "-n", *targets, *options]
        return subprocess.run(command, cwd=folder, env=alone, capture_output=True, text=True, check=False)

    assert '-m sparsurf_study run "my study.yaml" --cores' in make("CONFIG=my study.yaml").stdout
    assert "--workflow-profile profiles/slurm" in make("CLUSTER=slurm").stdout
    for cluster in ((), ("CLUSTER=slurm",)):  # into a folder where nothing is set up
        said = make(f"VENV={tmp_path / 'none'}", *cluster).stdout
        assert ("requirements-slurm.txt" in said) == bool(cluster)
    keys = ("CONFIG=my study.yaml", "PROFILE=my own", "CORES=3")
    said = make(*keys, targets=("paper", "compare", "check")).stdout.splitlines()
    assert [line.partition("bin/python ")[2] for line in said if "sparsurf_study " in line] == [
        '-m sparsurf_study run studies/paper.yaml --workflow-profile "my own"',
        '-m sparsurf_study run "my study.yaml" --workflow-profile "my own" compare',
        '-m sparsurf_study check "my study.yaml"',
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
        assert refused.returncode and "make run CONFIG=my.yaml" in refused.stderr
        assert "sparsurf_study" not in refused.stdout
    (tmp_path / "other").mkdir()
    (tmp_path / "link").symlink_to("other")  # whose environment would be cleared
    refused = make(f"VENV={tmp_path / 'link'}")
    assert refused.returncode and "link: remove" in refused.stderr
    for name, wrong in (("é<x>", None), ("a b", "space"), ("a:b", ":"), ("{x}", "{")):
        shutil.copytree(ROOT / "envs", tmp_path / name / "envs")
        for file in ("Makefile", "pyproject.toml"):
            shutil.copy(ROOT / file, tmp_path / name)
        (tmp_path / name / "src" / "sparsurf").mkdir(parents=True)
        said = make(folder=tmp_path / name).stderr
        assert f"has a {wrong} in its name" in said if wrong else not said
