"""Draw n_S, roughness and d of one combination over time, and the roughness of the residues."""

import pandas as pd

from sparsurf.report.figures import layout
from sparsurf.report.figures.over_time import ensemble_figure, residues_figure
from sparsurf.study.tables import read_residues
from sparsurf.workflow.jobs import job


def main(
    table: str,
    over_time: str,
    residues: str,
    png: str,
    residues_png: str,
    combination: list[float],
    name: str,
) -> None:
    """Write the two figures.

    Parameters
    ----------
    table, over_time, residues : tables of the ensemble
    combination : alpha, beta, gamma and delta
    name : of the protein
    """
    frames = pd.read_csv(table)
    layout.save(ensemble_figure(frames, combination, name), png)
    figure = residues_figure(read_residues(over_time), read_residues(residues), name)
    layout.save(figure, residues_png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            table=snakemake.input.table,
            over_time=snakemake.input.over_time,
            residues=snakemake.input.residues,
            png=snakemake.output.png,
            residues_png=snakemake.output.residues_png,
            combination=snakemake.params.combination,
            name=snakemake.wildcards.protein,
        )
