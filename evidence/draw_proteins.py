"""Figures of the study of many proteins: d, mean roughness, sufficient dots, Z by n_S."""

import pandas as pd

from measures import protein_figures
from sparsurf.workflow.jobs import job


def main(tables: dict[str, str], figures: dict[str, str]) -> None:
    """Draw every figure from the stored tables; both are paths by name."""
    stored = {name: pd.read_csv(path) for name, path in tables.items()}
    for name, draw in protein_figures.FIGURES.items():
        draw(stored).savefig(figures[name], dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    with job(snakemake):
        main(tables=dict(snakemake.input.items()), figures=dict(snakemake.output.items()))
