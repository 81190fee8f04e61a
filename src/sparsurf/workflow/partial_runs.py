"""Runs in which jobs failed: what is excluded from the second attempt, and the message at the end."""

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import yaml

from sparsurf import InputError
from sparsurf.workflow.config import needed_conformations
from sparsurf.workflow.conformations import first_column, without_zeros
from sparsurf.workflow.job_logs import FULL_DISK_BYTES, failure, place_of_log

FAILED_JOBS = (
    "_SPARSURF_FAILED_JOBS"  # environment variable: file to which the terminal adds the logs of failed jobs
)
SNAKEMAKES_GREETING = "Using workflow specific profile"
# Jobs that lead to the conformations of a protein: without one of them there are none
BEFORE_CONFORMATIONS = (
    "choose_frames",
    "fetch_",
    "prepare_system",
    "simulate_",
    "judge_",
)


def make_writable(folder: Path) -> None:
    """Create a folder; raise InputError if it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(FULL_DISK_BYTES // 10))
    except OSError as error:
        raise InputError(f"{folder}/ cannot be written ({error.strerror}). Repair that first.") from None


@contextmanager
def failed_jobs() -> Iterator[list[str]]:
    """Yield a list that receives the logs of the failed jobs on exit."""
    failed: list[str] = []
    with tempfile.NamedTemporaryFile("r", encoding="utf-8") as file:
        os.environ[FAILED_JOBS] = file.name
        yield failed
        logs = dict.fromkeys(file.read().splitlines())
        failed += [log for log in logs if failure(log) is not None]  # a second attempt may have finished


def exclude_failures(config: dict, run: Path, failed: list[str]) -> dict[str, str]:
    """Return the config's `exclude` with the places of failed jobs, and the pairs and comparisons that need them.

    Parameters
    ----------
    config : dict, checked
    run : folder of the results
    failed : logs of the jobs that failed
    """
    exclude = dict(config["exclude"])
    whole = "/*" if "batch" in config else ""  # the page of a structure failed, and its batch keeps it
    for log in failed:
        protein, conformation, job = place_of_log(log, run / "logs")
        over_frames = protein in config["proteins"] and not job.startswith(BEFORE_CONFORMATIONS)
        part = "/".join(filter(None, (protein, conformation or ("*" if over_frames else ""))))
        part += whole if part and part == protein else ""
        if part:  # a job over all proteins has no part
            exclude[part] = f"{job}: {failure(log)}"
    for protein in config["proteins"]:
        chosen = chosen_conformations(config, run, protein)
        if chosen and all(_is_in(exclude, f"{protein}/{name}") for name in chosen):
            exclude.setdefault(protein + whole, "None of its conformations could be finished.")
    for part, needed in needed_conformations(config).items():
        for name in needed:
            protein, _, conformation = name.partition("/")
            first = next(iter(chosen_conformations(config, run, protein)), "c1")
            if protein in exclude or _is_in(exclude, f"{protein}/{conformation or first}"):
                exclude.setdefault(part, f"{name} could not be finished.")
    return exclude


def chosen_conformations(config: dict, run: Path, protein: str) -> list[str]:
    """Return the conformations of a protein, none where its frames are not chosen yet."""
    if "surface" in config["proteins"][protein]:
        return ["c1"]
    frames = run / protein / "frames.csv"
    return first_column(frames) if frames.is_file() else []


def _is_in(exclude: dict[str, str], part: str) -> bool:
    """Return whether a conformation is excluded, by any way to write its name."""
    return without_zeros(part) in map(without_zeros, exclude)


def something_is_left(config: dict, run: Path, exclude: dict[str, str]) -> bool:
    """Return whether any batch, any protein with conformations, or any pair, is not excluded."""
    proteins = [name for name in config["proteins"] if name not in exclude]
    if "batch" in config or any(chosen_conformations(config, run, name) for name in proteins):
        return True
    return any(f"pairs/{name}" not in exclude for name in config["pairs"])


def write_exclude(exclude: dict[str, str], path: Path) -> Path:
    """Write a config file that excludes these places; return its path."""
    path.write_text(yaml.safe_dump({"exclude": exclude}, allow_unicode=True), encoding="utf-8")
    return path


def say_what_failed(run: Path, failed: list[str]) -> None:
    """Print on standard error why some results are missing."""
    folders = [folder for folder in (run, Path(".snakemake")) if folder.is_dir()]
    for folder in folders:
        if shutil.disk_usage(folder).free < FULL_DISK_BYTES:
            print(
                f"The disk of {folder}/ is full. Free some space and run again: finished results stay.",
                file=sys.stderr,
            )
            break
    reasons = [f"- {Path(log).relative_to(run / 'logs').with_suffix('')}: {failure(log)}" for log in failed]
    if not reasons:
        errors = run / "logs" / "snakemake.err"
        lines = errors.read_text(encoding="utf-8", errors="replace").splitlines() if errors.is_file() else []
        reasons = [line for line in lines if line.strip() and not line.startswith(SNAKEMAKES_GREETING)][-1:]
        reasons.append(f"See {errors} and the newest file of .snakemake/log/.")
    print(
        f"\nSome results could not be computed. Finished results are in {run}/.",
        *reasons,
        sep="\n",
        file=sys.stderr,
    )
