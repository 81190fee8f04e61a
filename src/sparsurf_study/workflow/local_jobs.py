"""Jobs on this machine: a study that is stopped ends them within seconds, with every process that they started."""

import signal
import subprocess
import time
from contextlib import suppress

import psutil

SECONDS_OF_PATIENCE = 2.0  # with jobs that the signal has reached by itself, as Ctrl-C does
SECONDS_TO_KILL = 5.0  # after the signal: a kernel that computes for minutes does not notice another one
# After these, Snakemake itself is killed; it has removed the outputs of these jobs by then
SECONDS_FOR_JOBS_TO_END = 8.0
SECONDS_BETWEEN_LOOKS = 0.1


def wait_here(process: subprocess.Popen, received: list[int]) -> int:
    """Wait for Snakemake and return its exit code; end its jobs after a signal, as it would wait until they have finished.

    `received` holds the signals so far.
    """
    while not received and process.poll() is None:
        with suppress(subprocess.TimeoutExpired):
            process.wait(1)
    if received and process.poll() is None:
        _end_jobs(process)
    return process.wait()


def _end_jobs(process: subprocess.Popen) -> None:
    """End the processes below Snakemake, and at last Snakemake."""
    snakemake, begin = psutil.Process(process.pid), time.monotonic()
    jobs, signalled = set[psutil.Process](), set[psutil.Process]()
    while (seconds := time.monotonic() - begin) < SECONDS_FOR_JOBS_TO_END:
        with suppress(psutil.NoSuchProcess):
            # Those found before are kept: they are no longer below Snakemake once their parent has ended
            jobs |= {*snakemake.children(recursive=True)}
        jobs = {job for job in jobs if _runs(job)}
        if process.poll() is not None and not jobs:
            return
        if seconds > SECONDS_OF_PATIENCE and snakemake not in signalled:
            process.terminate()  # a terminal sends Ctrl-C to Snakemake too, and `kill -INT` does not
            signalled.add(snakemake)
        elif seconds > SECONDS_TO_KILL:
            for job in jobs:
                _send(job, signal.SIGKILL)
        elif seconds > SECONDS_OF_PATIENCE:
            for job in jobs - signalled:
                _send(job, signal.SIGTERM)
            signalled |= jobs
        time.sleep(SECONDS_BETWEEN_LOOKS)
    process.kill()


def _send(job: psutil.Process, number: int) -> None:
    """Send a signal to a process that may have ended."""
    with suppress(psutil.NoSuchProcess):
        job.send_signal(number)


def _runs(job: psutil.Process) -> bool:
    """Return whether a process has not ended."""
    try:
        return job.is_running() and job.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
