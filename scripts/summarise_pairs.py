"""Summarise the agreement of the maps with the interface, over all pairs of a run."""

from pathlib import Path

import pandas as pd

from sparsurf.report.figures import layout
from sparsurf.report.figures.pair_figures import over_pairs
from sparsurf.rounding import write_table
from sparsurf.workflow.jobs import job


def main(tables: list[str], table: str, png: str, run: str) -> None:
    """Write pairs.csv, a row per pair, partner and score, and the figure of the means over pairs.

    Parameters
    ----------
    tables : paths that end in <pair>/agreement.csv
    """
    paths = [Path(path) for path in tables]
    scores = pd.concat([pd.read_csv(path).assign(complex=path.parent.name) for path in paths])
    write_table(table, scores)
    layout.save(over_pairs(run, scores), png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=list(snakemake.input.tables),
            table=snakemake.output.table,
            png=snakemake.output.png,
            run=snakemake.wildcards.run,
        )
