"""Summarise the agreement of the maps with the interface, over all pairs of a run."""

from pathlib import Path

import pandas as pd

from sparsurf.pairs.complexes import means_over_complexes
from sparsurf.report.figures import layout
from sparsurf.report.figures.pair_figures import over_pairs
from sparsurf.report.page import write
from sparsurf.report.pair_page import OF_ALL, pairs_page
from sparsurf.rounding import write_table
from sparsurf.workflow.jobs import job


def main(tables: list[str], table: str, means: str, page: str, png: str, run: str) -> None:
    """Write pairs.csv, a row per pair, partner and score, the means over pairs, their figure and page.

    Parameters
    ----------
    tables : paths that end in <pair>/agreement.csv
    """
    paths = [Path(path) for path in tables]
    scores = pd.concat([pd.read_csv(path).assign(complex=path.parent.name) for path in paths])
    mean_scores = means_over_complexes(scores, ["score"])
    write_table(table, scores)
    write_table(means, mean_scores)
    layout.save(over_pairs(run, scores, mean_scores), png)
    n_touching = scores["complex"].nunique()
    write(page, OF_ALL, **pairs_page(run, mean_scores, len(paths), n_touching, scores))


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=list(snakemake.input.tables),
            table=snakemake.output.table,
            means=snakemake.output.means,
            page=snakemake.output.page,
            png=snakemake.output.png,
            run=snakemake.wildcards.run,
        )
