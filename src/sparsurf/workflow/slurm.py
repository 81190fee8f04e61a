"""Slurm: jobs of a study that it will never start."""

import subprocess
import threading

# Reasons of a pending job that will never clear
PERMANENT_REASONS = (
    "PartitionConfig", "BadConstraints", "InvalidAccount", "InvalidQOS", "AccountNotAllowed", "QOSNotAllowed",
    "PartitionNodeLimit", "PartitionTimeLimit",
)  # fmt: skip
SECONDS_BETWEEN_QUESTIONS = 60


def stop_at_impossible_job(process: subprocess.Popen, prefix: str) -> None:
    """Watch a process of Snakemake, and end it with a sentence once Slurm will never start one of its jobs.

    `prefix` begins the names of the study's jobs.
    """

    def watch() -> None:
        while process.poll() is None:
            for job, reason in impossible_jobs(prefix):
                print(
                    f"Slurm will never start job {job} ({reason}). Ask for less, or name another partition.",
                    flush=True,
                )
                process.terminate()
                return
            waiting.wait(SECONDS_BETWEEN_QUESTIONS)

    waiting = threading.Event()
    threading.Thread(target=watch, daemon=True).start()


def impossible_jobs(prefix: str) -> list[tuple[str, str]]:
    """Return (id, reason) of the pending jobs whose name begins with `prefix` and whose reason is permanent."""
    command = ["squeue", "--me", "--noheader", "--states=PENDING", "--format=%i %j %r"]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False).stdout
    rows = [line.replace("(", "").replace(")", "").split(None, 2) for line in answer.splitlines()]
    jobs_of_run = [row for row in rows if len(row) == 3 and row[1].startswith(prefix)]
    return [(job, reason) for job, _, reason in jobs_of_run if reason.startswith(PERMANENT_REASONS)]
