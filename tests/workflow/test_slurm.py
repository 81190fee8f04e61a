"""A study on a real Slurm of one node: the tables of a local run, a killed job tried again, a cancelled run continued."""

import shutil
import subprocess
import sys
import time
from contextlib import ExitStack

import pytest
import yaml

import slurm_node
import study
import warm_python
from conftest import ROOT
from peptides import peptide, write
from small_study import EMBEDDED, SEQUENCE, SETTINGS
from sparsurf.workflow.slurm import impossible_jobs, stop_at_impossible_job

ONE = SETTINGS | {"frames": {"selection": [0]}}
ONE["proteins"] = {
    "moving": {name: str(ROOT / path) for name, path in EMBEDDED.items()} | {"residues": "209-216"}
}
SOON = ["--slurm-init-seconds-before-status-checks", "10"]  # one conformation is done before the profile asks
TABLES = [
    f"results/small/moving/f0000/{name}.csv" for name in ("ranges", "required_dots", "residues")
]  # and all before
MOST_SECONDS = 600  # of a run; a minute where nothing else runs


@pytest.fixture(scope="module")
def slurm(tmp_path_factory):
    """Environment of a running Slurm."""
    pytest.importorskip(
        "snakemake_executor_plugin_slurm", reason="envs/requirements-slurm.txt is not installed"
    )
    if reason := slurm_node.missing():
        pytest.skip(reason)
    with ExitStack() as stack:
        try:
            yield stack.enter_context(slurm_node.running(tmp_path_factory.mktemp("slurm")))
        except slurm_node.DidNotStart as error:
            pytest.skip(str(error))


def command(folder, *options, settings=ONE, targets=TABLES, python=sys.executable):
    """Snakemake's, for a small study in a folder of its own."""
    folder.mkdir(exist_ok=True)
    config = folder / "config.yaml"
    config.write_text(yaml.safe_dump(settings))
    where = ["--snakefile", ROOT / "Snakefile", "--directory", folder, "--configfile", config, "--nolock"]
    return [python, "-m", "snakemake", *targets, *map(str, where), *options]


def on_slurm(folder, slurm, *options, **what):
    """The same on a cluster without accounting whose node has few cores."""
    profile = study.cluster_options(["--cluster", "slurm"])
    no_accounts = ["--slurm-status-command", "squeue", "--slurm-no-account"]
    return command(folder, *profile, *no_accounts, "--max-threads", "2", *SOON, *options, **what)


def wait_for(condition, process):
    """The first true answer of `condition`, while `process` runs."""
    deadline = time.monotonic() + MOST_SECONDS
    while time.monotonic() < deadline and process.poll() is None:
        if answer := condition():
            return answer
        time.sleep(0.2)
    raise AssertionError(f"it did not happen; exit code {process.poll()}")


def running_jobs(slurm):
    """Ids of the jobs that run."""
    answer = subprocess.run(
        ["squeue", "-h", "-t", "RUNNING", "-o", "%i"], env=slurm, capture_output=True, text=True, check=False
    )
    return answer.stdout.split()


def tables(folder):
    """Bytes of every table of the run, by name."""
    results = folder / "results" / ONE["run"]
    return {str(path.relative_to(results)): path.read_bytes() for path in sorted(results.rglob("*.csv"))}


def test_a_cancelled_study_continues_and_a_killed_job_is_tried_again(slurm, tmp_path):
    local = subprocess.run(
        command(tmp_path / "local", "--cores", "2", python=warm_python.interpreter()),
        capture_output=True,
        text=True,
        check=False,
    )
    assert local.returncode == 0, local.stdout + local.stderr

    folder, log = tmp_path / "cluster", tmp_path / "log"
    # scancel of everything, no second attempt: the run ends with what there is
    with open(log, "w", encoding="utf-8") as out:
        first = subprocess.Popen(on_slurm(folder, slurm, "--retries", "0"), env=slurm, stdout=out, stderr=out)
        wait_for(lambda: running_jobs(slurm), first)
        subprocess.run(["scancel", "--user", "root"], env=slurm, check=True)
        assert first.wait(MOST_SECONDS) != 0
    # again; now a job of a conformation is killed in the middle, and tried again with more memory
    with open(log, "w", encoding="utf-8") as out:
        second = subprocess.Popen(on_slurm(folder, slurm), env=slurm, stdout=out, stderr=out)
        wait_for(lambda: list(folder.glob("results/small/moving/*/surface.npz")), second)
        killed = running_jobs(slurm)[0]
        subprocess.run(["scancel", killed], env=slurm, check=True)
        code = second.wait(MOST_SECONDS)
    said = log.read_text()
    assert code == 0, said
    assert "Trying to restart" in said
    assert tables(folder) == tables(tmp_path / "local") and len(tables(folder)) > 8
    queue = ["squeue", "-h", "-t", "all", "-o", "%i %m %C"]
    jobs = subprocess.run(queue, env=slurm, capture_output=True, text=True, check=True).stdout.splitlines()
    asked = {job: (memory, cores) for job, memory, cores in map(str.split, jobs)}
    memory, cores = asked[killed]
    doubled = str(2 * int(memory.rstrip("M"))) + "M"
    assert (doubled, cores) in asked.values()
    shutil.rmtree(folder)


def test_batches_on_slurm_give_the_bytes_of_a_local_run(slurm, tmp_path):
    pytest.importorskip("pyarrow", reason="pyarrow is installed by the extra `many`")
    structures = tmp_path / "structures"
    structures.mkdir()
    for k in range(4):
        write(structures / f"p{k}.pdb", peptide(SEQUENCE[: 3 + k % 2], origin=(k, 0, 0)) + "END\n")
    write(structures / "empty.pdb", "END\n")
    batches = {"run": "many", "sampling": False, "batch": 2, "proteins": {"folder": str(structures)}}
    page = {"settings": batches, "targets": ["results/many/index.html"]}
    for folder, arguments, environment in (
        (
            "local",
            command(tmp_path / "local", "--cores", "2", python=warm_python.interpreter(), **page),
            None,
        ),
        ("cluster", on_slurm(tmp_path / "cluster", slurm, **page), slurm),
    ):
        process = subprocess.run(arguments, env=environment, capture_output=True, text=True, check=False)
        assert process.returncode == 0, folder + process.stdout + process.stderr
    results = [tmp_path / folder / "results/many" for folder in ("local", "cluster")]
    paths = sorted(path.relative_to(results[0]) for path in results[0].rglob("*.parquet"))
    assert len(paths) == 10  # five tables of two batches
    for path in [*paths, "index.html", "failures.csv", "warnings.csv"]:
        assert (results[0] / path).read_bytes() == (results[1] / path).read_bytes(), path


def test_a_job_that_slurm_will_never_start_ends_the_run_in_a_sentence(slurm, capsys, monkeypatch, tmp_path):
    for name, value in slurm.items():
        monkeypatch.setenv(name, value)
    for name, minutes in (("mine-1_x", 60), ("other-1_x", 60)):
        options = [f"--job-name={name}", "--partition=short", f"--time={minutes}", "--wrap=true"]
        subprocess.run(["sbatch", *options], cwd=tmp_path, check=True, capture_output=True)
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(100)"])
    try:
        wait_for(lambda: impossible_jobs("mine-1"), process)
        stop_at_impossible_job(process, "mine-1")
        assert process.wait(timeout=30) != 0
    finally:
        process.kill()
    printed = capsys.readouterr().out
    assert (
        printed.count("Slurm will never start job") == 1
        and "). Ask for less, or name another partition." in printed
    )
