"""Samplers compared at equal n_S over all conformations and proteins of a study."""

from pathlib import Path

import pandas as pd

from sparsurf import comparison_summary, page
from sparsurf.comparison_figure import comparison_figure
from sparsurf.comparison_tables import ranking
from sparsurf.workflow import job


def main(paths_to_tables, paths_to_outputs):
    """Write the means and the spread between proteins, as table, page and figure.

    `paths_to_tables` end in <protein>/<conformation>/compare.csv.
    """
    tables = {Path(path).parts[-3:-1]: pd.read_csv(path) for path in paths_to_tables}
    units = comparison_summary.by_protein(tables)
    of = "proteins" if len({protein for protein, _ in tables}) > 1 else "conformations"
    table = comparison_summary.summary(units)
    fewer = comparison_summary.needed_summary(units)
    table.to_csv(paths_to_outputs["table"], index=False)
    fewer.to_csv(paths_to_outputs["needed"], index=False)
    rankings = {name: ranking(own) for name, own in units.items()}
    with open(paths_to_outputs["page"], "w", encoding="utf-8") as stream:
        stream.write(comparison_summary.summary_markdown(table, fewer, rankings, of, len(tables)))
    drawn = table.rename(columns={"lowest": "low", "highest": "high"})
    subject = f"mean of {len(units)} {of}" if len(units) > 1 else next(iter(units))
    figure = comparison_figure(drawn, subject, f"lowest to highest of {len(units)} {of}")
    page.save(figure, paths_to_outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            paths_to_tables=list(snakemake.input),
            paths_to_outputs={key: output[key] for key in ("table", "needed", "page", "png")},
        )
