"""Results that are still what the study wrote: a job's log holds size, time and checksum of its outputs."""

import base64
import hashlib
import os
from functools import cache
from pathlib import Path

from sparsurf import InputError
from sparsurf.workflow.job_logs import MADE, lines

LONGEST_NAME = 250  # characters of a file that Snakemake calls so
LOGS = "logs"  # folder of a run
STAMP = ".snakemake_timestamp"  # Snakemake's, in a folder that is an output


def made(outputs):
    """Lines on outputs for the log of the job that made them."""
    for path in _files(outputs):
        found = os.stat(path)
        yield f"{MADE}{found.st_size} {found.st_mtime_ns} {checksum(path)} {path}"


def refuse_unknown(root, logs, options):
    """Raise InputError where results are there, and what they followed from is not known: Snakemake's record of it is gone."""
    there = [path for path in recorded(logs) if os.path.isfile(path)]
    notes = [root / ".snakemake" / kind for kind in ("metadata", "incomplete")]
    if there and "--forceall" not in options and not any(_noted(path, notes) for path in there):
        raise InputError(
            f"{logs.parent} was made in another checkout, or .snakemake was removed: what its results follow from is not known. "
            "Name another `run`, move the folder away, or have all made again with scripts/study.py and --forceall."
        )


def _noted(path, notes):
    """Whether Snakemake has a note of a file, in folders where it calls it by its path in base64."""
    name = base64.b64encode(path.encode(), b"_-").decode()
    return len(name) > LONGEST_NAME or any((folder / name).is_file() for folder in notes)


def damaged(log, paths=None):
    """Files that are there and are not what some job wrote.

    Parameters
    ----------
    log : path of any log of the run, or of the folder of logs
    paths : files and folders in the run's folder, as the rules name them; those without a record pass. All recorded files if None
    """
    logs = next((each for each in (log, *log.parents) if each.name == LOGS), log)
    if paths is None:
        records = _records(sorted(logs.rglob("*.log")))
        asked = [
            path for path in records if Path(path).is_relative_to(logs.parent)
        ]  # not of a run it was copied from
    else:
        asked = [*_files(paths)]
        records = _records(sorted({each for path in asked for each in _logs_of(path, logs)}))
    return [
        path
        for path in asked
        if path in records and os.path.isfile(path) and not _is_same(path, *records[path])
    ]


@cache
def _logs_of_folder(folder):
    return [*folder.glob("*.log")]


def _logs_of(path, logs):
    """Logs of the jobs that may have written a file: they lie as deep, in folders of the same names."""
    try:
        folders = Path(path).relative_to(logs.parent).parts[:-1]
    except ValueError:  # it is not of this run
        return
    for depth in range(len(folders) + 1):
        yield from _logs_of_folder(logs.joinpath(*folders[:depth]))


def _records(logs):
    """Size, time and checksum by path; of two logs of one path the newer one counts."""
    return {path: record for _, path, record in _made_by(logs)}


def replaced(logs):
    """Those of some logs whose job made nothing that a later one has not made anew."""
    made_by = [(log, path) for log, path, _ in _made_by(logs)]
    last = {path: log for log, path in made_by}
    return {log for log, _ in made_by} - {*last.values()}


def recorded(logs):
    """Paths of the files that the jobs of a run wrote; `logs` is their folder."""
    return {path for _, path, _ in _made_by(logs.rglob("*.log"))}


def _made_by(logs):
    """A log, and path and (size, time, checksum) of an output that it tells of, the oldest log first."""
    for log in sorted(logs, key=lambda path: path.stat().st_mtime):
        for line in lines(log, MADE):
            size, time, digest, path = line.split(" ", 3)
            yield log, path, (int(size), int(time), digest)


def _is_same(path, size, time, digest):
    found = os.stat(path)
    if found.st_size != size:
        return False
    return found.st_mtime_ns == time or checksum(path) == digest


def checksum(path):
    """Digest of a file's content."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()[:16]


def _files(paths):
    """Files among paths, and those within the folders among them."""
    for path in map(Path, paths):
        inside = sorted(path.rglob("*")) if path.is_dir() else [path]
        yield from (str(each) for each in inside if each.is_file() and each.name != STAMP)
