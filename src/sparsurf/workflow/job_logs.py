"""The logs of jobs: lines that begin with one of a few words, written by `jobs.job` and read by who watches a run."""

import os
import re
import shutil
from pathlib import Path

ERROR, WARNING, PROGRESS, USED, MADE = "ERROR ", "WARNING ", "PROGRESS ", "USED ", "MADE "
TAIL = 2000  # bytes
FULL = 10**6  # bytes of a disk on which nothing more can be made
NO_ROOM = "no space is left on the disk"
NO_WORD = "it ended without a word: killed, out of memory, or stopped as logs/snakemake.err says"


def lines(path, word):
    """What stands behind a word at the beginning of a log's lines; nothing where there is no log."""
    try:
        text = Path(path).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    return [line[len(word) :] for line in text.splitlines() if line.startswith(word)]


def warnings_in(path):
    """Sentences that a job warned with, each once."""
    return list(dict.fromkeys(lines(path, WARNING)))


def failure(path):
    """Why a job failed, in a sentence; None for one that came to its end."""
    if lines(path, USED):
        return None
    if found := lines(path, ERROR):
        return found[-1]
    folder = Path(path).parent
    return NO_ROOM if folder.is_dir() and shutil.disk_usage(folder).free < FULL else NO_WORD


def progress(path):
    """(done, of, seconds to go) of a running job's last line of progress; zeros without."""
    with open(path, "rb") as stream:
        stream.seek(-min(TAIL, os.fstat(stream.fileno()).st_size), os.SEEK_END)
        tail = stream.read().decode("utf-8", "replace")
    found = re.findall(rf"^{PROGRESS}.*?(\d+) of (\d+) .*?(\d+) s to go", tail, re.M)
    return tuple(map(int, found[-1])) if found else (0, 0, 0)


def place(path, logs):
    """(protein, conformation, job) that a log is of; empty strings where it is of none."""
    *above, job = Path(path).relative_to(logs).with_suffix("").parts
    if above[:1] in (["pairs"], ["sites"]):
        return "/".join(above), "", job
    return *[*above, "", ""][:2], job
