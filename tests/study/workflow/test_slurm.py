"""A study on a real Slurm of one node, with and without accounting: stopped, continued, a job killed, as a local run."""

import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import ExitStack, suppress

import pytest

import kills
import slurm_node
from conftest import ROOT

pytestmark = pytest.mark.slow

MOST_SECONDS = 600  # of a run; two minutes where nothing else runs
SECONDS_TO_STOP = 90  # 12 where nothing else runs
ROUGHNESS = "results/one/one/c1/roughness.csv"
COMMAND = ["-m", "sparsurf_study", "run", "one.yaml", "--workflow-profile", "profiles/slurm", ROUGHNESS]


@pytest.fixture(params=[False, True], ids=["no accounts", "accounts"], scope="module")
def node(request, tmp_path_factory):
    """Environment of a running Slurm, and whether sacct answers there."""
    pytest.importorskip(
        "snakemake_executor_plugin_slurm", reason="envs/requirements-slurm.txt is not installed"
    )
    if reason := slurm_node.missing(request.param):
        pytest.skip(reason)
    with ExitStack() as stack:
        folder = tmp_path_factory.mktemp("slurm")
        try:
            yield stack.enter_context(slurm_node.running(folder, request.param)), request.param
        except slurm_node.DidNotStart as error:
            pytest.skip(str(error))


@pytest.fixture
def start():
    """Function that starts a command in a checkout, as a terminal does; it prints into `said`."""
    started = []

    def run(folder, environment, *options):
        with open(folder / "said", "w", encoding="utf-8") as out:
            streams = {"stdout": out, "stderr": out, "start_new_session": True}
            command = [sys.executable, *COMMAND, *options]
            environment = environment | {"PYTHONPATH": str(ROOT / "src")}
            started.append(subprocess.Popen(command, cwd=folder, env=environment, **streams))
        return started[-1]

    yield run
    for process in started:
        with suppress(ProcessLookupError):  # it has ended
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def checkout(folder):
    """Make a checkout whose profile asks for the two cores that the node has."""
    kills.checkout(folder)
    (folder / "profiles").unlink()
    shutil.copytree(ROOT / "profiles", folder / "profiles")
    profile = folder / "profiles" / "slurm" / "config.yaml"
    profile.write_text(profile.read_text().replace("max-threads: 8", "max-threads: 2"))
    return folder


def wait_for(condition, process):
    """Return the first true answer of `condition`, while `process` runs."""
    deadline = time.monotonic() + MOST_SECONDS
    while time.monotonic() < deadline and process.poll() is None:
        if answer := condition():
            return answer
        time.sleep(0.2)
    raise AssertionError(f"it did not happen; exit code {process.poll()}")


def jobs(environment, states="PENDING,RUNNING"):
    """Return (id, memory) of jobs."""
    command = ["squeue", "-h", "-t", states, "-o", "%i %m"]
    answer = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    return [line.split() for line in answer.splitlines()]


def said(folder):
    """Return what the command in a checkout has printed."""
    return (folder / "said").read_text(encoding="utf-8")


def test_a_study_is_stopped_and_continues_to_the_bytes_of_a_local_run(node, start, tmp_path):
    """Without accounts, a job that is cancelled is tried again with twice its memory, and Slurm does not answer for a while."""
    environment, has_accounts = node
    local, cluster = (checkout(tmp_path / name) for name in ("local", "cluster"))
    first = start(cluster, environment)
    wait_for(lambda: jobs(environment, "RUNNING"), first)
    first.terminate()
    assert first.wait(SECONDS_TO_STOP) != 0 and jobs(environment) == []
    assert "Stopped. Finished results" in said(cluster) and "Failed" not in said(cluster)
    assert ("sacct does not answer: squeue is asked" in said(cluster)) == (not has_accounts)

    second = start(cluster, environment)
    killed, memory = wait_for(lambda: jobs(environment, "RUNNING"), second)[0]
    if not has_accounts:
        subprocess.run(["scancel", killed], env=environment, check=True)
        with slurm_node.without_controller(environment):
            time.sleep(15)
    assert second.wait(MOST_SECONDS) == 0, said(cluster)
    asked = [job[1] for job in jobs(environment, "all")]
    assert has_accounts or str(2 * int(memory.rstrip("M"))) + "M" in asked
    assert kills.run(kills.study("one", ROUGHNESS), local).returncode == 0
    known, found = (kills.content(folder / "results" / "one" / "one") for folder in (local, cluster))
    assert found == known


def test_a_run_stops_at_a_job_that_slurm_will_never_start(node, start, tmp_path):
    environment, _ = node
    folder = checkout(tmp_path / "impossible")
    process = start(folder, environment, "--default-resources", "slurm_partition=short", "runtime=60")
    assert process.wait(MOST_SECONDS) != 0 and jobs(environment) == []
    assert "Slurm will never" in said(folder) and "(PartitionTimeLimit)" in said(folder)
