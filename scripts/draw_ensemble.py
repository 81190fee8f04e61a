"""n_S, roughness and d of one combination over time."""

import pandas as pd

from sparsurf import page, summary_figures
from sparsurf.workflow import job


def main(path_to_table, path_to_figure, combination):
    """Draw and save the figure."""
    page.save(summary_figures.ensemble_figure(pd.read_csv(path_to_table), combination), path_to_figure)


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            path_to_table=snakemake.input.table,
            path_to_figure=output["png"].removesuffix(".png"),
            combination=snakemake.params.combination,
        )
