"""Samplers compared at equal n_S over all conformations and proteins of a study."""

from pathlib import Path

import pandas as pd

from sparsurf.report.comparison_over_proteins_page import summary_markdown
from sparsurf.report.figures import layout
from sparsurf.report.figures.comparison_figure import comparison_figure
from sparsurf.study.comparison_over_proteins import by_protein, needed_over_proteins, over_proteins
from sparsurf.study.dots_needed import ranking
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
    rankings = {name: ranking(own) for name, own in units.items()}
    with open(outputs["page"], "w", encoding="utf-8") as stream:
        stream.write(summary_markdown(table, fewer, rankings, of, len(tables)))
    drawn = table.rename(columns={"lowest": "low", "highest": "high"})
    subject = f"mean of {len(units)} {of}" if len(units) > 1 else next(iter(units))
    figure = comparison_figure(drawn, subject, f"lowest to highest of {len(units)} {of}")
    layout.save(figure, outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
