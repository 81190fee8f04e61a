"""Summarise all sites on all surfaces that were searched for them."""

from pathlib import Path

import pandas as pd

from sparsurf.report.figures import layout
from sparsurf.report.figures.site_figures import matrix_figure
from sparsurf.report.site_page import is_found
from sparsurf.rounding import write_table
from sparsurf.workflow.jobs import job

COLUMNS = ("target", "score", "p", "places")


def main(hits: list[str], matrix: str, png: str, run: str) -> None:
    """Write matrix.csv, a row per site and target, and its picture.

    Parameters
    ----------
    hits : paths that end in <site>/hits.csv
    """
    tables = {Path(path).parent.name: pd.read_csv(path, usecols=COLUMNS) for path in hits}
    marked = [table.assign(found=is_found(table).astype(int)) for table in tables.values()]
    rows = pd.concat(marked, keys=tables).droplevel(1).rename_axis("site").reset_index()
    rows = rows[["site", *COLUMNS, "found"]]
    write_table(matrix, rows)
    layout.save(matrix_figure(run, rows), png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            hits=list(snakemake.input.hits),
            matrix=snakemake.output.matrix,
            png=snakemake.output.png,
            run=snakemake.wildcards.run,
        )
