"""Samplers compared at equal n_S over all conformations and proteins of a study."""

from pathlib import Path

import pandas as pd

from sparsurf.report.comparison_page import TEMPLATE, comparison_page
from sparsurf.report.figures import layout
from sparsurf.report.figures.comparison_figure import comparison_figure
from sparsurf.report.page import write
from sparsurf.study.comparison.fewer import by_protein, needed_over_proteins, over_proteins
from sparsurf.workflow.jobs import run


def main(inputs, outputs):
    """Write the means and the spread between proteins, as table, page and figure.

    The tables that come in end in <protein>/<conformation>/compare.csv.
    """
    tables = {Path(path).parts[-3:-1]: pd.read_csv(path) for path in inputs["tables"]}
    units = by_protein(tables)
    several = "proteins" if len({protein for protein, _ in tables}) > 1 else "conformations"
    of = several if len(units) > 1 else "conformation"
    table = over_proteins(units)
    fewer = needed_over_proteins(units)
    table.to_csv(outputs["table"], index=False)
    fewer.to_csv(outputs["needed"], index=False)
    run_name = Path(inputs["tables"][0]).parts[-4]
    write(outputs["page"], TEMPLATE, **comparison_page(run_name, table, fewer, of=of, n=len(units)))
    drawn = table.rename(columns={"lowest": "low", "highest": "high"})
    subject = f"mean of {len(units)} {of}" if len(units) > 1 else next(iter(units))
    figure = comparison_figure(drawn, subject, f"lowest to highest of {len(units)} {of}")
    layout.save(figure, outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
