"""What a run says at its end, and which of its parts could not be computed."""

import csv
import json
from collections.abc import Iterator
from pathlib import Path

from sparsurf.files import pluralise
from sparsurf_study.batches.assignment import batched_structures
from sparsurf_study.config.check import needed_conformations
from sparsurf_study.config.conformations import first_column, without_zeros
from sparsurf_study.workflow import job_logs, stopping
from sparsurf_study.workflow.job_logs import failures_since, place_of_log

# Jobs that lead to the conformations of a protein: without one of them there are none
BEFORE_CONFORMATIONS = ("choose_frames", "fetch_", "prepare_system", "simulate_", "extract_", "judge_")
MAX_CONTRADICTIONS = 10  # So many are told in words; all are in checks.csv.


def answers_of_run(run: Path, is_paper: bool = False) -> str:
    """Return the answers, the number of warnings and the first page of a run."""
    crate = json.loads((run / "ro-crate-metadata.json").read_text(encoding="utf-8"))
    answers = next(entry["abstract"] for entry in crate["@graph"] if "abstract" in entry)
    broken, failed = rows_of(run / "checks.csv"), len(rows_of(run / "failures.csv"))
    checks = pluralise(len(broken), "contradiction") if broken else "all results agree with one another"
    return "\n".join(
        [
            "",
            *(f"Answer    {text}" for text in answers),
            *([f"Failed    {pluralise(failed, 'part')}, see {run / 'failures.csv'}"] if failed else []),
            f"Warnings  {len(rows_of(run / 'warnings.csv'))} in {run / 'warnings.csv'}",
            f"Checks    {checks}",
            *(f"          {run / row['file']}: {row['sentence']}" for row in broken[:MAX_CONTRADICTIONS]),
            f"Look at   {run / ('verdict.html' if is_paper and (run / 'verdict.html').is_file() else 'index.html')}",
        ]
    )


def rows_of(path: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV table."""
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def reasons(run: Path, begin: float) -> Iterator[str]:
    """Yield why some results of a run that began at a time are missing."""
    failures = [(log, reason) for log, reason in failures_since(begin, run / "logs")]
    if stopping.SIGNALLED.is_set() or any(reason == job_logs.STOPPED for _, reason in failures):
        yield stopping.NOTICE
        return
    yield f"\nSome results could not be computed. Finished results are in {run}/."
    for log, reason in failures:
        yield f"- {log.relative_to(run / 'logs').with_suffix('')}: {reason}"


def failed_places(config: dict, run: Path, begin: float) -> dict[str, str]:
    """Return the parts of a run that failed since it began and what needs them, with reasons, as `exclude` of a config."""
    places = {}
    for log, reason in failures_since(begin, run / "logs"):
        protein, conformation, job = place_of_log(log, run / "logs")
        over_frames = protein in config["proteins"] and not job.startswith(BEFORE_CONFORMATIONS)
        # of a batch, the page of a structure failed, and its batch keeps it
        whole = "*" if over_frames or batched_structures(config) else ""
        if protein:  # a job over all proteins has no place
            places["/".join(filter(None, (protein, conformation or whole)))] = f"{job}: {reason}"
    excluded = {without_zeros(place) for place in places}
    for place, needed in needed_conformations(config).items():
        for name in needed:
            protein, _, conformation = name.partition("/")
            frames = run / protein / "frames.csv"
            first = first_column(frames)[0] if frames.is_file() else "c1"
            if excluded & {protein, without_zeros(f"{protein}/{conformation or first}")}:
                places.setdefault(place, f"{name} could not be finished.")
    return places
