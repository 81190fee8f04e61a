"""Close a run in batches: its first page, the figure of its distributions, failures and warnings, and the crate."""

from pathlib import Path

import pandas as pd

from close_run import write_crate
from sparsurf.batches.assignment import TABLES
from sparsurf.batches.summary import grouped_reasons, measures, most_unusual
from sparsurf.batches.tables import read_parquet
from sparsurf.report.figures import distributions, layout
from sparsurf.report.front import MAX_ROWS, write_front
from sparsurf.rounding import write_table
from sparsurf.workflow.job_logs import collected_warnings
from sparsurf.workflow.jobs import job

JOB = "analyse_batch"


def main(
    tables: list[str],
    studied: list[str],
    page: str,
    failures: str,
    warnings: str,
    png: str,
    crate: str,
    exclude: dict[str, str],
    logs: str,
    jobs: list[str],
) -> None:
    """Write index.html, distributions.png, failures.csv, warnings.csv and the crate.

    Parameters
    ----------
    tables : Parquet files of all batches; others in their folders are left from an earlier study and are removed
    studied : files of the structures that have pages of their own
    exclude : reason for each excluded part of the study
    logs : folder of the logs
    jobs : names of the rules of the study
    """
    run = Path(page).parent
    remove_others(run, tables)
    surfaces = read_parquet(run, "surfaces").sort_values("protein", ignore_index=True)
    failed = read_parquet(run, "failures").sort_values("protein", ignore_index=True)
    excluded = pd.DataFrame(exclude.items(), columns=["protein", "reason"])
    write_table(failures, pd.concat([excluded, failed]).set_axis(["place", "reason"], axis=1))
    listed = read_parquet(run, "warnings").sort_values("protein", kind="stable")
    listed = listed.assign(conformation="", job=JOB)[["protein", "conformation", "job", "sentence"]]
    rows = collected_warnings(studied, logs, jobs) if studied else []
    listed = pd.concat([listed, pd.DataFrame(rows, columns=list(listed))])
    write_table(warnings, listed.drop_duplicates(["protein", "sentence"]))
    layout.save(distributions.figure(measures(surfaces)), png)
    batches = {
        "surfaces": surfaces,
        "unusual": most_unusual(surfaces, MAX_ROWS),
        "failures": grouped_reasons(failed),
        "n_batches": len({Path(path).name for path in tables}),
    }
    files = [Path(path).relative_to(run).as_posix() for path in (png, *studied)]
    answers = write_front(page, files, exclude, batches)
    write_crate([*tables, png, *studied, page, failures, warnings], crate, answers)


def remove_others(run: Path, tables: list[str]) -> None:
    """Remove tables of batches that the study no longer has, so that a folder holds one run."""
    paths = set(map(Path, tables))
    for table in TABLES:
        for path in (run / table).glob("*.parquet"):
            if path not in paths:
                path.unlink()


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=snakemake.input.tables,
            studied=snakemake.input.studied,
            page=snakemake.output.page,
            failures=snakemake.output.failures,
            warnings=snakemake.output.warnings,
            png=snakemake.output.png,
            crate=snakemake.output.crate,
            exclude=snakemake.params.exclude,
            logs=snakemake.params.logs,
            jobs=snakemake.params.jobs,
        )
