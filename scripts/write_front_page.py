"""Write the first page of a run and the table of failures."""

from pathlib import Path

import pandas as pd

from sparsurf.report.first_page import FRESH, TEMPLATE, first_page
from sparsurf.report.page import write
from sparsurf.rounding import write_table
from sparsurf.workflow.jobs import job


def main(
    results: list[str], page: str, failures: str, exclude: dict[str, str], floor: str | None = FRESH
) -> None:
    """Write index.html and failures.csv.

    Parameters
    ----------
    results : files and folders of the run, which the page leads to
    exclude : reason for each excluded part of the study
    floor : the noise floor that the minimal subset goes by; None where the config asks for something else
    """
    folder = Path(page).parent
    files = [Path(path).relative_to(folder).as_posix() for path in results]
    write(page, TEMPLATE, **first_page(folder, files, list(exclude.items()), floor))
    write_table(failures, pd.DataFrame(exclude.items(), columns=["place", "reason"]))


if __name__ == "__main__":
    with job(snakemake):
        main(
            results=snakemake.input.results,
            page=snakemake.output.page,
            failures=snakemake.output.failures,
            exclude=snakemake.params.exclude,
            floor=snakemake.params.floor,
        )
