"""Summarise the best parameters of all surfaces, and compare them with mean roughness."""

from pathlib import Path

import pandas as pd

from sparsurf.report.figures import layout, summary_figures
from sparsurf.report.page import write
from sparsurf.report.summary_page import TEMPLATE, summary_page
from sparsurf.rounding import write_table
from sparsurf.streams import stream
from sparsurf.study.summary import read_result, relation_table, summary_table
from sparsurf.workflow.jobs import job


def main(
    surfaces: list[str], table: str, summary: str, relation: str, page: str, png: str, seed: int, run: str
) -> None:
    """Write summary.csv and relation.csv, their page and figure.

    Parameters
    ----------
    surfaces : paths that end in <protein>/<conformation>/surface.npz; the other results lie in the same folders
    table : surfaces.csv
    """
    results = [read_result(Path(path).parent) for path in surfaces]
    best = summary_table(results)
    relations = relation_table(results, best, stream(seed, "summary"))
    write_table(summary, best)
    write_table(relation, relations)
    names = {"protein": str, "conformation": str}
    all_surfaces = pd.read_csv(table, dtype=names, keep_default_na=False, na_values=[""])
    sampled = all_surfaces.merge(best[[*names]].drop_duplicates())
    write(page, TEMPLATE, **summary_page(run, sampled, relations, (results[0].best or {}).get("draws")))
    layout.save(summary_figures.summary_figure(best, relations), png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surfaces=snakemake.input.surfaces,
            table=snakemake.input.table,
            summary=snakemake.output.summary,
            relation=snakemake.output.relation,
            page=snakemake.output.page,
            png=snakemake.output.png,
            seed=snakemake.params.seed,
            run=snakemake.wildcards.run,
        )
