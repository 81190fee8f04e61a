"""Draw the best parameters of all surfaces against mean roughness, with their page."""

import pandas as pd

from sparsurf.report.figures import layout, summary_figures
from sparsurf.report.page import write
from sparsurf.report.summary_page import TEMPLATE, summary_page
from sparsurf.workflow.jobs import job

NAMES = {"protein": str, "conformation": str}


def main(surfaces: str, summary: str, relation: str, page: str, png: str, draws: int, run: str) -> None:
    """Write the page and the figure of surfaces.csv, summary.csv and relation.csv."""
    of_surfaces, best = (
        pd.read_csv(path, dtype=NAMES, keep_default_na=False, na_values=[""]) for path in (surfaces, summary)
    )
    relations = pd.read_csv(relation)
    sampled = of_surfaces.merge(best[[*NAMES]].drop_duplicates())
    write(page, TEMPLATE, **summary_page(run, sampled, relations, draws))
    layout.save(summary_figures.summary_figure(best, relations), png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surfaces=snakemake.input.surfaces,
            summary=snakemake.input.summary,
            relation=snakemake.input.relation,
            page=snakemake.output.page,
            png=snakemake.output.png,
            draws=snakemake.params.draws,
            run=snakemake.wildcards.run,
        )
