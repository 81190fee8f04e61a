"""Collect what the jobs of a run warned about in one table."""

import csv
from pathlib import Path

from sparsurf.workflow.job_logs import place_of_log, warnings_in
from sparsurf.workflow.jobs import job

COLUMNS = ("protein", "conformation", "job", "sentence")


def main(results: list[str], table: str, logs: str, jobs: list[str]) -> None:
    """Write warnings.csv from the logs of a run.

    Logs of proteins, pairs, sites and conformations without results, and of jobs that the study does not have, are left from
    earlier studies in the same folder and do not count.

    Parameters
    ----------
    results : files of the run
    logs : folder of the logs
    jobs : names of the rules of the study
    """
    run = Path(table).parent
    folders = {folder.relative_to(run).as_posix() for path in results for folder in Path(path).parents[:-2]}
    rows: dict[tuple[str, str, str], tuple[str, str, str, str]] = {}
    for log in sorted(Path(logs).rglob("*.log")):
        protein, conformation, job_name = place_of_log(log, logs)
        folder = "/".join(filter(None, (protein, conformation))) or "."
        if folder in folders and job_name.startswith(tuple(jobs)):
            for sentence in warnings_in(log):  # once, also where two jobs give it
                rows.setdefault(
                    (protein, conformation, sentence), (protein, conformation, job_name, sentence)
                )
    with open(table, "w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *rows.values()])


if __name__ == "__main__":
    with job(snakemake):
        main(
            results=snakemake.input.results,
            table=snakemake.output.table,
            logs=snakemake.params.logs,
            jobs=snakemake.params.jobs,
        )
