"""Summarise the comparison of samplers at equal n_S over all conformations and proteins of a study."""

from pathlib import Path

import pandas as pd

from sparsurf.report.comparison_page import TEMPLATE, comparison_page
from sparsurf.report.figures import layout
from sparsurf.report.figures.comparison_figure import comparison_figure, comparison_panels
from sparsurf.report.page import write
from sparsurf.rounding import write_table
from sparsurf.study.comparison.equal_error import factors_over_proteins, means_by_protein, means_over_proteins
from sparsurf.workflow.jobs import job


def main(tables: list[str], table: str, needed: str, page: str, png: str, panels: str, run: str) -> None:
    """Write the means and the spread between proteins, as tables, page and figure.

    Parameters
    ----------
    tables : paths that end in <protein>/<conformation>/compare.csv
    """
    comparisons = {(Path(path).parts[-3], Path(path).parts[-2]): pd.read_csv(path) for path in tables}
    units = means_by_protein(comparisons)
    several = "proteins" if len({protein for protein, _ in comparisons}) > 1 else "conformations"
    kind = several if len(units) > 1 else "conformation"
    means, needed_table = means_over_proteins(units), factors_over_proteins(units)
    write_table(table, means)
    write_table(needed, needed_table)
    write(page, TEMPLATE, **comparison_page(run, means, needed_table, of=kind, n=len(units)))
    subject = f"mean of {len(units)} {kind}" if len(units) > 1 else next(iter(units))
    drawn = means.rename(columns={"lowest": "low", "highest": "high"})
    band = f"lowest to highest of {len(units)} {kind}"
    for draw, path in ((comparison_figure, png), (comparison_panels, panels)):
        layout.save(draw(drawn, subject, band), path)


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=list(snakemake.input.tables),
            table=snakemake.output.table,
            needed=snakemake.output.needed,
            page=snakemake.output.page,
            png=snakemake.output.png,
            panels=snakemake.output.panels,
            run=snakemake.wildcards.run,
        )
