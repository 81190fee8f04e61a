"""The logs of jobs: lines that begin with one of a few words, written by `jobs.job` and read by those who watch a run."""

import os
import re
import shutil
from collections.abc import Iterable
from pathlib import Path

ERROR_MARK, WARNING_MARK, PROGRESS = "ERROR ", "WARNING ", "PROGRESS "
USED_MARK = "USED "  # last line of a job that finished
FAILED_JOBS = "_SPARSURF_FAILED_JOBS"  # environment variable: file for the paths of the logs of failed jobs
OF_GROMACS = r"\d+ \[file .*\]:$"  # WARNING 1 [file topol.top, line 2315]:
TAIL_BYTES = 2000
FULL_DISK_BYTES = 10**6  # free bytes of a disk on which nothing more can be written
NO_SPACE = "no space is left on the disk"
STOPPED = "it was stopped, by someone or by a time limit"
NO_REASON = "it was killed, ran out of memory, or was stopped before it could give a reason"


def lines_after(path: str | Path, word: str) -> list[str]:
    """Return the rest of each line of a log that begins with a word; an empty list if there is no log."""
    try:
        text = Path(path).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    return [line[len(word) :] for line in text.splitlines() if line.startswith(word)]


def warnings_in(path: str | Path) -> list[str]:
    """Return the sentences that a job warned with, each once; the headings that GROMACS writes above its own are none."""
    lines = lines_after(path, WARNING_MARK)
    return list(dict.fromkeys(line for line in lines if not re.match(OF_GROMACS, line)))


def collected_warnings(
    files: Iterable[str], logs: str | Path, jobs: Iterable[str]
) -> list[tuple[str, str, str, str]]:
    """Collect what the `jobs` (rules) of a run warned about: (protein, conformation, job, sentence), no earlier studies'."""
    run = Path(logs).parent
    parents = {folder for path in files for folder in Path(path).parents if folder.is_relative_to(run)}
    folders = {folder.relative_to(run).as_posix() for folder in parents}
    rows: dict[tuple[str, str, str], tuple[str, str, str, str]] = {}
    for log in sorted(Path(logs).rglob("*.log")):
        protein, conformation, job_name = place_of_log(log, logs)
        folder = "/".join(filter(None, (protein, conformation))) or "."
        if folder in folders and job_name.startswith(tuple(jobs)):
            for sentence in warnings_in(log):  # once, also where two jobs give it
                row = (protein, conformation, job_name, sentence)
                rows.setdefault((protein, conformation, sentence), row)
    return list(rows.values())


def failure(path: str | Path) -> str | None:
    """Return why a job failed, in a sentence; None for a job that finished."""
    if lines_after(path, USED_MARK):
        return None
    errors = lines_after(path, ERROR_MARK)
    if errors:
        return errors[-1]
    folder = Path(path).parent
    is_full = folder.is_dir() and shutil.disk_usage(folder).free < FULL_DISK_BYTES
    return NO_SPACE if is_full else NO_REASON


def progress(path: str | Path) -> tuple[int, int, int]:
    """Return (done, total, seconds to go) of a running job; zeros where its log has none."""
    with open(path, "rb") as stream:
        stream.seek(-min(TAIL_BYTES, os.fstat(stream.fileno()).st_size), os.SEEK_END)
        tail = stream.read().decode("utf-8", "replace")
    matches = re.findall(rf"^{PROGRESS}.*?(\d+) of (\d+) .*?(\d+) s to go", tail, re.M)
    done, total, left = map(int, matches[-1]) if matches else (0, 0, 0)
    return done, total, left


def place_of_log(path: str | Path, logs: str | Path) -> tuple[str, str, str]:
    """Return (protein or pairs/<name>, conformation, job) of a log in the folder `logs`; empty strings where it is about none."""
    *folders, name = Path(path).relative_to(logs).with_suffix("").parts
    if folders[:1] in (["pairs"], ["changes"]):
        return "/".join(folders), "", name
    protein, conformation = [*folders, "", ""][:2]
    return protein, conformation, name
