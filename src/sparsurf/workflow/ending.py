"""The end of a run: whether its results are complete, what goes on without what failed, the lines that say what came out."""

import csv
import os
import shutil
import statistics
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import yaml

from sparsurf import InputError
from sparsurf.texts import short
from sparsurf.workflow.files_of_sites import DESCRIBE, asked_for
from sparsurf.workflow.job_logs import FULL, failure, place
from sparsurf.workflow.jobs import conformations_of, plain
from sparsurf.workflow.outputs import ALL_FRAMES
from sparsurf.workflow.results import LOGS, recorded

FAILED = "_SPARSURF_FAILED"  # environment variable: file to which the logs of failed jobs are added
PROFILE = "Using workflow specific profile"  # begins what Snakemake always says
PAGE, REPORT, WARNINGS, SURFACES = "index.html", "report.html", "warnings.csv", "surfaces.csv"
# Jobs of a protein that lead to its frames: without one of them there is none of it
BEFORE_FRAMES = ("choose_frames", "fetch_", "prepare_system", "simulate_", "judge_simulation")


def make_writable(folder):
    """Create a folder, or say why nothing can be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(FULL // 10))
    except OSError as error:
        raise InputError(f"{folder}/ cannot be written ({error.strerror}). Repair that first.") from None


@contextmanager
def failed_jobs():
    """List that in the end holds the logs of the jobs that failed."""
    failed = []
    with tempfile.NamedTemporaryFile("r", encoding="utf-8") as file:
        os.environ[FAILED] = file.name
        yield failed
        tried = dict.fromkeys(file.read().splitlines())
        failed += [
            log for log in tried if failure(log) is not None
        ]  # not what a second attempt brought to its end


def left_out(config, results, logs_of_failed):
    """The config's `without` for a second try, with the failed places and the pairs and sites that need them.

    Parameters
    ----------
    config : dict, as `config.check` gives it
    results : path of the run's folder
    logs_of_failed : paths of logs
    """
    without = dict(config["without"])
    for path in logs_of_failed:
        protein, conformation, job = place(path, results / "logs")
        known = not job.startswith(BEFORE_FRAMES)
        names = (protein, conformation or (ALL_FRAMES if known and protein in config["proteins"] else ""))
        names = (*names, job) if job == DESCRIBE else names  # only sites need it
        without["/".join(filter(None, names)) or job] = f"{job}: {failure(path)}"
    for protein, entry in config["proteins"].items():
        chosen = _chosen(entry, results / protein)
        if chosen and not left_of(protein, chosen, without):
            without.setdefault(protein, "None of its conformations could be finished.")
    for asked, named in asked_for(config).items():
        for each in named:
            protein, _, conformation = each.partition("/")
            chosen = _chosen(config["proteins"][protein], results / protein)
            own = f"{protein}/{conformation or next(iter(chosen), 'c1')}"
            if {protein, own, f"{own}/{DESCRIBE}"} & without.keys():
                without.setdefault(asked, f"{each} could not be finished.")
    return without


def left_of(protein, chosen, without):
    """Those of its conformations that a protein is not without."""
    gone = {plain(place) for place in without}
    return [each for each in chosen if plain(f"{protein}/{each}") not in gone]


def _chosen(protein, folder):
    """The conformations of a protein, its entry in the config, as far as its frames are chosen in its folder."""
    if "surface" in protein:
        return ["c1"]
    frames = folder / "frames.csv"
    return conformations_of(frames) if frames.is_file() else []


def something_is_left(config, results, without):
    """Whether any conformation or pair of a config is not left out."""
    for name, protein in config["proteins"].items():
        if name not in without and left_of(name, _chosen(protein, results / name), without):
            return True
    return any(f"pairs/{name}" not in without for name in config["pairs"])


def write_without(without, path):
    """A config file that leaves these out."""
    Path(path).write_text(yaml.safe_dump({"without": without}, allow_unicode=True), encoding="utf-8")
    return path


def is_complete(folder):
    """Whether the first page, which every result leads to, is the newest of all."""
    return (folder / PAGE).is_file() and not is_older(folder / PAGE, folder)


def is_older(page, folder):
    """Whether a page is not there, or older than what a job of the run wrote."""
    if not page.is_file():
        return True
    since = page.stat().st_mtime
    files = map(Path, recorded(folder / LOGS))  # a file of somebody else's says nothing
    return any(path.is_file() and path.stat().st_mtime > since for path in files)


def incomplete(folder, code, failed):
    """Say what a run did not make; returns its exit code."""
    if code:
        _unsuccessful(folder, code, failed)
        if (folder / PAGE).is_file():
            print(f"{folder / PAGE} is of an earlier run.", file=sys.stderr)
        return code
    print(f"\nWhat was asked for is in {folder}/. The rest of the study was not made, nor its report.")
    return code


def _unsuccessful(folder, code, failed):
    """Say why not everything could be made."""
    places = (each for each in (folder, Path(".snakemake")) if each.is_dir())
    full = next((each for each in places if shutil.disk_usage(each).free < FULL), None)
    if full:
        print(
            f"The disk of {full}/ is full. Free some space and run again: what was made stays.",
            file=sys.stderr,
        )
    reasons = [f"- {Path(log).relative_to(folder / LOGS).with_suffix('')}: {failure(log)}" for log in failed]
    if not reasons and (said := _last_line(folder / LOGS / "snakemake.err")):
        print(f"\n{said}", file=sys.stderr)
    more = (
        ""
        if reasons or full
        else f" See {folder / LOGS}/snakemake.err and the newest file of .snakemake/log/."
    )
    print(
        f"\nNot everything could be made. What was made is in {folder}/.{more}",
        *reasons,
        sep="\n",
        file=sys.stderr,
    )
    return code


def _last_line(path):
    """The last line of a file that says something; empty without."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines() if path.is_file() else []
    said = [line.strip() for line in lines if line.strip() and not line.startswith(PROFILE)]
    return short(said[-1]) if said else ""


def summary(config, folder, code, failed, begin, torn=0):
    """Say how long a run took, what came out, what it warned of and where to look; returns the exit code.

    A report that is `torn` is removed.
    """
    code = _unsuccessful(folder, code or 1, failed) if failed or code or torn else 0
    if torn:
        (folder / REPORT).unlink(missing_ok=True)
    seconds = round(time.time() - begin)
    print(f"\nTime      {seconds // 60} min {seconds % 60} s")
    if parts := [*_minimal_percents(folder / SURFACES)] if config["proteins"] else ():
        what = "are enough" if "floor" in config["minimal"] else "are in minimal.csv, as the config asks"
        median = f" (median of {len(parts)} surfaces)" if len(parts) > 1 else ""
        print(f"Answer    {statistics.median(parts):.1f} % of the dots {what}{median}.")
    print(f"Warnings  {_rows(folder / WARNINGS)} in {folder / WARNINGS}")
    print(f"Look at   {folder / PAGE}")
    print(
        f"All       {folder / REPORT if (folder / REPORT).is_file() else 'no report could be written'}, {folder}/"
    )
    return code


def _minimal_percents(path):
    """n_S of the minimal subset of each surface, % of its dots, which the first page tells too."""
    if path.is_file():
        with path.open(encoding="utf-8", newline="") as stream:
            yield from (float(row["minimal_n_S_percent"]) for row in csv.DictReader(stream))


def _rows(path):
    """Rows of a table without its header; 0 where there is none."""
    if not path.is_file():
        return 0
    with path.open("rb") as stream:
        return max(0, sum(1 for _ in stream) - 1)
