"""Slurm without accounting, and jobs that it will never start: its plugin waits for both forever, without a word."""

import os
import signal
import subprocess
import sys
import threading
import time

# Reasons of a pending job that will never clear
PERMANENT_REASONS = (
    "PartitionConfig", "BadConstraints", "InvalidAccount", "InvalidQOS", "AccountNotAllowed", "QOSNotAllowed",
    "PartitionNodeLimit", "PartitionTimeLimit",
)  # fmt: skip
JOB_PREFIX = "sparsurf_"  # slurm-jobname-prefix in the profile
SECONDS_BETWEEN_QUESTIONS = 60


def guard_slurm() -> None:
    """Ask squeue alone which jobs have ended where sacct does not answer, and stop a run with an impossible job."""
    if _answer("sacct", "--allocations") is None:
        print("sacct does not answer: squeue is asked which jobs have ended.", flush=True)
        # The plugin asks sacct wherever that is installed, again and again
        sys.modules["snakemake_executor_plugin_slurm"].is_query_tool_available = lambda tool: tool != "sacct"  # type: ignore[attr-defined]
    threading.Thread(target=_watch, daemon=True).start()


def _watch() -> None:
    """Stop this process once Slurm will never start one of the jobs."""
    while True:
        time.sleep(SECONDS_BETWEEN_QUESTIONS)
        for line in (_answer("squeue", "--me", "--noheader", "--format=%j %i %r") or "").splitlines():
            name, job, reason = [*line.split(None, 2), "", ""][:3]
            if name.startswith(JOB_PREFIX) and reason.strip("()").startswith(PERMANENT_REASONS):
                remedy = "Ask for less, or name another partition, in profiles/slurm/config.yaml."
                print(f"Slurm will never start job {job} ({reason}). {remedy}", flush=True)
                return os.kill(os.getpid(), signal.SIGTERM)


def _answer(*command: str) -> str | None:
    """Return what a command of Slurm prints; None where it fails, is missing or takes too long."""
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=30, check=True).stdout
    except (OSError, subprocess.SubprocessError):
        return None
