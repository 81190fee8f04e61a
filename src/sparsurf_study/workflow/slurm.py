"""Slurm: what it answers, the cores of its nodes, jobs that it will never start, and the end of a run that is stopped."""

import itertools
import math
import shutil
import signal
import subprocess
import time
import uuid
from contextlib import suppress
from pathlib import Path

import yaml

from sparsurf.errors import InputError

JOB_PREFIX = f"sparsurf-{uuid.uuid4().hex[:12]}"  # begins the names of the jobs of this process
# Reasons of a pending job that will never clear
PERMANENT_REASONS = (
    "PartitionConfig", "BadConstraints", "InvalidAccount", "InvalidQOS", "AccountNotAllowed", "QOSNotAllowed",
    "PartitionNodeLimit", "PartitionTimeLimit",
)  # fmt: skip
SECONDS_BETWEEN_QUESTIONS = 60
SECONDS_TO_END = 8.0  # that Snakemake has after each signal


def slurm_options(profile: Path) -> list[str]:
    """Return Snakemake's options for a Slurm that keeps no accounts, or whose nodes have few cores; say what is special."""
    settings = yaml.safe_load((profile / "config.yaml").read_text(encoding="utf-8"))
    options = ["--slurm-jobname-prefix", JOB_PREFIX]
    if "slurm-status-command" not in settings and _answer("sacct", "--allocations") is None:
        print("sacct does not answer: squeue is asked which jobs have ended.", flush=True)
        options += ["--slurm-status-command", "squeue"]
    resources = settings.get("default-resources") or {}
    words = resources if isinstance(resources, list) else [f"{key}={resources[key]}" for key in resources]
    partition = dict(word.split("=", 1) for word in words).get("slurm_partition")
    of_partition = [f"--partition={partition}"] if partition else []
    nodes = _answer("sinfo", "--noheader", "--exact", "--format=%c %P", *of_partition)
    if nodes is None:
        raise InputError("sinfo does not answer: run this where jobs can be submitted to Slurm.")
    cores = [int(line.split()[0]) for line in nodes.splitlines() if partition or line.endswith("*")]
    if cores and max(cores) < settings.get("max-threads", math.inf):
        print(f"No node has more than {max(cores)} cores: no job asks for more.", flush=True)
        options += ["--max-threads", str(max(cores))]
    return options


def wait_on_slurm(process: subprocess.Popen, received: list[int]) -> int:
    """Wait for Snakemake and return its exit code; end it soon after a signal, or if Slurm will never start one of its jobs.

    `received` holds the signals so far. By itself, Snakemake ends only after its next question, up to 180 s later.
    """
    begin = time.time()
    for second in itertools.count(1):
        with suppress(subprocess.TimeoutExpired):
            process.wait(1)
        jobs = _own_jobs() if second % SECONDS_BETWEEN_QUESTIONS == 0 else []
        for job, reason in [row for row in jobs if row[1].startswith(PERMANENT_REASONS)][:1]:
            remedy = "Ask for less or name another partition in profiles/slurm/config.yaml."
            print(f"Slurm will never start job {job} ({reason}). {remedy}", flush=True)
            received.append(signal.SIGTERM)
        if received or process.poll() is not None:
            break
    for number in (signal.SIGINT, signal.SIGINT, signal.SIGKILL):  # its second does not wait for the question
        process.send_signal(number)
        with suppress(subprocess.TimeoutExpired):
            process.wait(SECONDS_TO_END)
    if left := [job for job, _ in _own_jobs()]:
        _answer("scancel", *left)
    for folder in Path(".snakemake").glob("tmp.*"):
        if folder.stat().st_ctime > begin:
            shutil.rmtree(folder)
    return process.wait()


def _own_jobs() -> list[tuple[str, str]]:
    """Return (id, reason to wait) of the jobs of this run that wait or run."""
    lines = (_answer("squeue", "--me", "--noheader", "--format=%i %j %r") or "").splitlines()
    rows = [line.replace("(", "").replace(")", "").split(None, 2) for line in lines]
    return [(row[0], row[2]) for row in rows if len(row) == 3 and row[1].startswith(JOB_PREFIX)]


def _answer(*command: str) -> str | None:
    """Return what a command of Slurm prints; None where it fails, is missing or takes too long."""
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=30, check=True).stdout
    except (OSError, subprocess.SubprocessError):
        return None
