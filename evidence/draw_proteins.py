"""Figures of the study over many proteins: d, mean roughness, dots that are enough, Z by n_S."""

import pandas as pd

from measures import protein_figures
from sparsurf.workflow.jobs import run


def main(inputs, outputs):
    """Draw them from the stored tables."""
    stored = {name.removeprefix("proteins_"): pd.read_csv(path) for name, path in inputs.items()}
    for name, draw in protein_figures.FIGURES.items():
        draw(stored).savefig(outputs[f"proteins_{name}"], dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    run(main, snakemake)
