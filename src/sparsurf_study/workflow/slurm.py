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
QUEUE_ALONE = "--slurm-status-command"  # the option that is given where sacct does not answer
ASKS_SACCT = "Falling back to 'sacct'"  # in Snakemake's log
SECONDS_BETWEEN_QUESTIONS = 60
SECONDS_TO_ASK_AGAIN = 10  # where Slurm did not answer
SECONDS_TO_END = 8.0  # that Snakemake has after each signal


def slurm_options(profile: Path) -> list[str]:
    """Return Snakemake's options for a Slurm that keeps no accounts, or whose nodes have few cores; say what is special."""
    settings = yaml.safe_load((profile / "config.yaml").read_text(encoding="utf-8"))
    options = ["--slurm-jobname-prefix", JOB_PREFIX]
    if "slurm-status-command" not in settings and _answer("sacct", "--allocations") is None:
        print("sacct does not answer: squeue is asked which jobs have ended.", flush=True)
        options += [QUEUE_ALONE, "squeue"]
    resources = settings.get("default-resources") or {}
    items = resources if isinstance(resources, list) else [f"{key}={resources[key]}" for key in resources]
    partition = dict(word.split("=", 1) for word in items).get("slurm_partition")
    of_partition = [f"--partition={partition}"] if partition else []
    nodes = _answer("sinfo", "--noheader", "--exact", "--format=%c %P", *of_partition)
    if nodes is None:
        raise InputError("sinfo does not answer: run this where jobs can be submitted to Slurm.")
    cores = [int(line.split()[0]) for line in nodes.splitlines() if partition or line.endswith("*")]
    if cores and max(cores) < settings.get("max-threads", math.inf):
        print(f"No node has more than {max(cores)} cores: no job asks for more.", flush=True)
        options += ["--max-threads", str(max(cores))]
    return options


def wait_on_slurm(process: subprocess.Popen, received: list[int]) -> int | None:
    """Wait for Snakemake and return its exit code; end it soon after a signal, or if Slurm will never start one of its jobs.

    `received` holds the signals so far. By itself, Snakemake ends only after its next question, up to 180 s later. None is
    returned where it has lost sight of its jobs, which were ended, and is to be started again.
    """
    begin, unanswered, due, again = time.time(), 0, SECONDS_BETWEEN_QUESTIONS, False
    for second in itertools.count(1):
        with suppress(subprocess.TimeoutExpired):
            process.wait(1)
        jobs: list[tuple[str, str]] | None = []
        if second >= due and process.poll() is None:
            jobs = _own_jobs()
            unanswered = _say_if_slurm_answers(jobs is not None, unanswered)
            again = jobs is not None and QUEUE_ALONE in str(process.args) and _lost_jobs(begin)
            due = second + (SECONDS_TO_ASK_AGAIN if unanswered else SECONDS_BETWEEN_QUESTIONS)
        for job, reason in [row for row in jobs or () if row[1].startswith(PERMANENT_REASONS)][:1]:
            remedy = "Ask for less or name another partition in profiles/slurm/config.yaml."
            print(f"Slurm will never start job {job} ({reason}). {remedy}", flush=True)
            received.append(signal.SIGTERM)
        if again:
            print("The jobs that ran when Slurm did not answer are started again.", flush=True)
        if again or received or process.poll() is not None:
            break
    for number in (signal.SIGINT, signal.SIGINT, signal.SIGKILL):  # its second does not wait for the question
        process.send_signal(number)
        with suppress(subprocess.TimeoutExpired):
            process.wait(SECONDS_TO_END)
    left = _own_jobs()
    if left is None or (left and _answer("scancel", *[job for job, _ in left]) is None):
        named = f"`squeue --me` lists them as {JOB_PREFIX}..., `scancel` ends them"
        print(f"Slurm does not answer, so that jobs of this study may run on: {named}.", flush=True)
    for folder in Path(".snakemake").glob("tmp.*"):
        if folder.stat().st_ctime > begin:
            shutil.rmtree(folder)
    code = process.wait()
    return None if again else code


def _lost_jobs(begin: float) -> bool:
    """Return whether Snakemake asks sacct since Slurm did not answer, and so never hears of its jobs without accounts."""
    logs = [path for path in Path(".snakemake", "log").glob("*.log") if path.stat().st_mtime > begin]
    return any(ASKS_SACCT in log.read_text(encoding="utf-8", errors="replace") for log in logs)


def _say_if_slurm_answers(answered: bool, unanswered: int) -> int:
    """Return the number of questions without an answer; say so after the second, and when it answers again."""
    if answered:
        if unanswered > 1:
            print("Slurm answers again.", flush=True)
        return 0
    if unanswered == 1:
        print("Slurm has not answered for more than a minute; the study goes on when it does.", flush=True)
    return unanswered + 1


def _own_jobs() -> list[tuple[str, str]] | None:
    """Return (id, reason to wait) of the jobs of this run that wait or run; None where Slurm does not answer."""
    answer = _answer("squeue", "--me", "--noheader", "--format=%i %j %r")
    if answer is None:
        return None
    rows = [line.replace("(", "").replace(")", "").split(None, 2) for line in answer.splitlines()]
    return [(row[0], row[2]) for row in rows if len(row) == 3 and row[1].startswith(JOB_PREFIX)]


def _answer(*command: str) -> str | None:
    """Return what a command of Slurm prints; None where it fails, is missing or takes too long."""
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=30, check=True).stdout
    except (OSError, subprocess.SubprocessError):
        return None
