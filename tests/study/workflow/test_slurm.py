"""The documented command on a real Slurm of one node of two cores: stopped, continued, a job killed, as a local run."""

import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import ExitStack, suppress

import pytest
import yaml

import slurm_node
from conftest import ROOT
from peptides import peptide, write
from small_study import SEQUENCE

pytestmark = pytest.mark.slow

MOST_SECONDS = 600  # of a run; three minutes where nothing else runs
SECONDS_TO_STOP = 60  # half where nothing else runs


@pytest.fixture(scope="module")
def node(tmp_path_factory):
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


def checkout(folder):
    """Make a checkout that is set up: its Python is that of the tests."""
    shutil.copytree(ROOT / "scripts", folder / "scripts")  # study.py runs the checkout that it lies in
    for name in (
        "Makefile",
        "Snakefile",
        "rules",
        "src",
        "data",
        "envs",
        "profiles",
        "studies",
        "config.yaml",
    ):
        (folder / name).symlink_to(ROOT / name)
    python = folder / ".venv" / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    return folder


@pytest.fixture
def start():
    """Function that starts the command of docs/cluster.md, without its set-up, as a terminal does; it prints into `said`."""
    started = []

    def run(folder, config, *variables, environment=None):
        command = ["make", "-o", "setup", "run", f"CONFIG={config}", *variables]
        own = {"start_new_session": True, "preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
        with open(folder / "said", "w", encoding="utf-8") as out:
            started.append(
                subprocess.Popen(command, cwd=folder, env=environment, stdout=out, stderr=out, **own)
            )
        return started[-1]

    yield run
    for process in started:
        with suppress(ProcessLookupError):  # it has ended
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def wait_for(condition, process):
    """Return the first true answer of `condition`, while `process` runs."""
    deadline = time.monotonic() + MOST_SECONDS
    while time.monotonic() < deadline and process.poll() is None:
        if answer := condition():
            return answer
        time.sleep(0.2)
    raise AssertionError(f"it did not happen; exit code {process.poll()}")


def jobs(node, states="PENDING,RUNNING"):
    """Return (id, memory, cores) of jobs."""
    command = ["squeue", "-h", "-t", states, "-o", "%i %m %C"]
    answer = subprocess.run(command, env=node, capture_output=True, text=True, check=True).stdout
    return [line.split() for line in answer.splitlines()]


def said(folder):
    """Return what the command in a checkout has printed."""
    return (folder / "said").read_text(encoding="utf-8")


def files(folder, end):
    """Return the bytes of the files of all runs with an end, by path."""
    paths = sorted((folder / "results").rglob(f"*{end}"))
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def test_the_documented_command_is_stopped_continues_and_gives_the_tables_of_a_local_run(
    node, start, tmp_path
):
    local, cluster = (checkout(tmp_path / name) for name in ("local", "cluster"))
    alone = start(local, "studies/short.yaml", "CORES=2")
    first = start(cluster, "studies/short.yaml", "CLUSTER=slurm", environment=node)
    wait_for(lambda: jobs(node, "RUNNING"), first)
    os.killpg(first.pid, signal.SIGINT)
    assert first.wait(SECONDS_TO_STOP) != 0
    said = (cluster / "said").read_text()
    assert "sacct does not answer: squeue is asked" in said and "No node has more than 2 cores" in said
    assert "\nStopped. Finished results stay" in said and "Failed" not in said
    assert jobs(node) == [] and not list((cluster / ".snakemake").glob("tmp.*"))

    second = start(cluster, "studies/short.yaml", "CLUSTER=slurm", environment=node)
    wait_for(lambda: list(cluster.glob("results/short/tdp43/*/surface.npz")), second)
    killed, memory, cores = wait_for(lambda: jobs(node, "RUNNING"), second)[0]
    subprocess.run(["scancel", killed], env=node, check=True)
    assert second.wait(MOST_SECONDS) == 0, (cluster / "said").read_text()
    asked = [job[1:] for job in jobs(node, "all")]
    assert [str(2 * int(memory.rstrip("M"))) + "M", cores] in asked  # it was tried again
    assert alone.wait(MOST_SECONDS) == 0, (local / "said").read_text()
    tables = files(cluster, ".csv")
    assert tables == files(local, ".csv") and len(tables) > 20


def test_batches_on_slurm_give_the_bytes_of_a_local_run_though_its_controller_is_killed(
    node, start, tmp_path
):
    pytest.importorskip("pyarrow", reason="pyarrow is installed by the extra `many`")
    (structures := tmp_path / "structures").mkdir()
    for k in range(4):
        write(structures / f"p{k}.pdb", peptide(SEQUENCE[: 3 + k % 2], origin=(k, 0, 0)) + "END\n")
    write(structures / "empty.pdb", "END\n")
    config = {"run": "many", "sampling": False, "pages": [], "proteins": {"folder": str(structures)}}
    (tmp_path / "many.yaml").write_text(yaml.safe_dump(config))
    local, cluster = (checkout(tmp_path / name) for name in ("local", "cluster"))
    alone = start(local, tmp_path / "many.yaml", "CORES=2")
    shared = start(cluster, tmp_path / "many.yaml", "CLUSTER=slurm", environment=node)
    wait_for(lambda: jobs(node, "RUNNING"), shared)
    with slurm_node.without_controller(node):
        wait_for(lambda: "Slurm has not answered for more than a minute" in said(cluster), shared)
    for process, folder in ((alone, local), (shared, cluster)):
        assert process.wait(MOST_SECONDS) == 0, (folder / "said").read_text()
    assert "Slurm answers again.\nThe jobs that ran when" in said(cluster)
    assert len(files(cluster, ".parquet")) == 5  # tables of a batch
    for end in (".parquet", ".csv", "index.html"):
        assert files(cluster, end) == files(local, end)
