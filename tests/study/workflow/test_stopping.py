"""SIGTERM or SIGHUP ends a study within seconds, with every process of its jobs, and the next run ends in equal bytes."""

import os
import signal
import subprocess
import sys
import time
from functools import partial

import psutil
import pytest

import kills
from conftest import ROOT
from sparsurf_study.workflow.signals import on_stop

ROUGHNESS = "results/one/one/c1/roughness.csv"
SNAKEFILE = """
from sparsurf_study.workflow.stopping import end_jobs_on_sigterm

onstart:
    end_jobs_on_sigterm()

rule all:
    input: "a", "b"

rule deaf:  # a process that ignores the signal, as a kernel does, below a shell that does not
    output: "{name}"
    shell: "(trap '' TERM INT HUP; touch {wildcards.name}.begun; sleep 600); touch {output}"
"""


def wait_for(condition, process):
    """Return the first true answer, while a process runs."""
    deadline = time.monotonic() + 300
    while time.monotonic() < deadline and process.poll() is None:
        if answer := condition():
            return answer
        time.sleep(0.1)
    raise AssertionError(f"it did not happen; exit code {process.poll()}")


def hear_all_signals():
    """The shell of a test may let it ignore Ctrl-C, and nohup the end of its terminal."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def below(process):
    """Return the processes that another has started, and those that they have."""
    return psutil.Process(process.pid).children(recursive=True)


def still_running(jobs):
    """Return the processes that do not end in a minute; one that has ended may wait long until process 1 asks for its code."""
    deadline = time.monotonic() + 60
    while (running := [job for job in jobs if is_running(job)]) and time.monotonic() < deadline:
        time.sleep(0.1)
    return running


def is_running(job):
    try:
        return job.is_running() and job.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_jobs_that_ignore_the_signal_end_with_snakemake(tmp_path, number):
    (tmp_path / "Snakefile").write_text(SNAKEFILE)
    command = [sys.executable, "-m", "snakemake", "--cores", "2"]
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    process = subprocess.Popen(command, cwd=tmp_path, env=environment, preexec_fn=hear_all_signals)
    wait_for(lambda: all((tmp_path / f"{name}.begun").exists() for name in "ab"), process)
    jobs = below(process)
    assert len(jobs) >= 2
    process.send_signal(number)
    assert process.wait(60) != 0
    assert not still_running(jobs)


def test_a_study_under_nohup_goes_on_without_its_terminal(monkeypatch):
    handlers = {signal.SIGTERM: signal.SIG_DFL, signal.SIGHUP: signal.SIG_IGN}
    monkeypatch.setattr(signal, "getsignal", handlers.get)
    monkeypatch.setattr(signal, "signal", handlers.__setitem__)
    on_stop(print)
    assert handlers == {signal.SIGTERM: print, signal.SIGHUP: signal.SIG_IGN}


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A checkout whose study has run up to the roughness of its surface."""
    folder = kills.checkout(tmp_path_factory.mktemp("stops") / "undisturbed")
    assert kills.run(kills.study("one", ROUGHNESS), folder).returncode == 0
    return folder


@pytest.mark.parametrize(
    ("command", "signals"),
    [
        ("-m sparsurf_study run one.yaml", [signal.SIGTERM]),
        ("-m snakemake --configfile one.yaml", [signal.SIGTERM]),
        ("-m sparsurf_study run one.yaml", [signal.SIGINT]),
        ("-m sparsurf_study run one.yaml", [signal.SIGINT] * 2),
        ("-m sparsurf_study run one.yaml", [signal.SIGHUP]),
    ],
)
def test_a_stopped_study_continues_to_the_bytes_of_an_undisturbed_one(
    undisturbed, tmp_path, command, signals
):
    """SIGTERM reaches what the user has started alone; Ctrl-C, and the end of the terminal, all of its processes."""
    folder, said = kills.checkout(tmp_path / "stopped"), tmp_path / "said"
    whole = [*command.split(), "--cores", "2", ROUGHNESS]
    own = {"env": os.environ | {"PYTHONPATH": str(ROOT / "src")}, "start_new_session": True}
    own["preexec_fn"] = hear_all_signals
    with said.open("w") as stream:
        process = subprocess.Popen([sys.executable, *whole], cwd=folder, stdout=stream, stderr=stream, **own)
        wait_for((folder / "results/one/logs/one/c1/compute_surface.log").exists, process)
        jobs = below(process)
        for number in signals:
            (process.send_signal if number == signal.SIGTERM else partial(os.killpg, process.pid))(number)
            time.sleep(0.5)
        assert process.wait(60) != 0
    assert jobs and not still_running(jobs)
    text = said.read_text()
    # Of a terminal that is closed nobody reads whether the jobs ended before Snakemake heard of it.
    assert ("Failed" not in text or signal.SIGHUP in signals) and "Traceback" not in text, text
    assert "Stopped. Finished results stay" in text or len(signals) > 1, text
    assert kills.run(kills.study("one", ROUGHNESS), folder).returncode == 0
    known, found = (kills.content(root / "results" / "one" / "one") for root in (undisturbed, folder))
    assert found == known
