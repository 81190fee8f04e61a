"""Summarise the comparison of samplers at equal n_S over all conformations and proteins of a study."""

from pathlib import Path

import pandas as pd

from sparsurf.report.figures import layout
from sparsurf.report.figures.comparison_figure import comparison_figure
from sparsurf.rounding import write_table
from sparsurf.study.comparison import means_by_protein, means_over_proteins
from sparsurf.workflow.jobs import job


def main(tables: list[str], table: str, png: str) -> None:
    """Write the means and the spread between proteins, as table and figure.

    Parameters
    ----------
    tables : paths that end in <protein>/<conformation>/compare.csv
    """
    comparisons = {(Path(path).parts[-3], Path(path).parts[-2]): pd.read_csv(path) for path in tables}
    units = means_by_protein(comparisons)
    several = "proteins" if len({protein for protein, _ in comparisons}) > 1 else "conformations"
    kind = several if len(units) > 1 else "conformation"
    means = means_over_proteins(units)
    write_table(table, means)
    subject = f"mean of {len(units)} {kind}" if len(units) > 1 else next(iter(units))
    drawn = means.rename(columns={"lowest": "low", "highest": "high"})
    layout.save(comparison_figure(drawn, subject, f"lowest to highest of {len(units)} {kind}"), png)


if __name__ == "__main__":
    with job(snakemake):
        main(tables=list(snakemake.input.tables), table=snakemake.output.table, png=snakemake.output.png)
