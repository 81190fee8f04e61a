"""Collect what the jobs of a run warned about in one table."""

import csv

from sparsurf.workflow.job_logs import collected_warnings
from sparsurf.workflow.jobs import job

COLUMNS = ("protein", "conformation", "job", "sentence")


def main(results: list[str], table: str, logs: str, jobs: list[str]) -> None:
    """Write warnings.csv from the logs of a run.

    Parameters
    ----------
    results : files of the run
    logs : folder of the logs
    jobs : names of the rules of the study
    """
    with open(table, "w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *collected_warnings(results, logs, jobs)])


if __name__ == "__main__":
    with job(snakemake):
        main(
            results=snakemake.input.results,
            table=snakemake.output.table,
            logs=snakemake.params.logs,
            jobs=snakemake.params.jobs,
        )
