"""The logs of jobs: lines that begin with one of a few words, written by `jobs.job` and read at the end of a run."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

ERROR_MARK, WARNING_MARK, PROGRESS = "ERROR ", "WARNING ", "PROGRESS "
USED_MARK = "USED "  # last line of a job that finished
SHOWN = "SPARSURF_SHOWN"  # variable of the environment: the terminal shows the errors of the logs
COMPILING = "Compiling kernels (once, about half a minute)"
OF_GROMACS = r"\d+ \[file .*\]:$"  # WARNING 1 [file topol.top, line 2315]:
STOPPED = "it was stopped, by someone or by a time limit"
NO_REASON = "it was killed, ran out of memory or disk, or was stopped before it could give a reason"


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


def failures_since(begin: float, logs: Path) -> Iterator[tuple[Path, str]]:
    """Yield the logs of the jobs that began after a time and did not finish, each with the reason in a sentence."""
    for log in sorted(logs.rglob("*.log")):
        if log.stat().st_mtime >= begin and not lines_after(log, USED_MARK):
            yield log, reason_of(log)


def reason_of(log: str | Path) -> str:
    """Return why a job did not finish, in a sentence."""
    return [NO_REASON, *lines_after(log, ERROR_MARK)][-1]


def place_of_log(path: str | Path, logs: str | Path) -> tuple[str, str, str]:
    """Return (protein or pairs/<name>, conformation, job) of a log in the folder `logs`; empty strings where it is about none."""
    *folders, name = Path(path).relative_to(logs).with_suffix("").parts
    if folders[:1] in (["pairs"], ["changes"]):
        return "/".join(folders), "", name
    protein, conformation = [*folders, "", ""][:2]
    return protein, conformation, name
