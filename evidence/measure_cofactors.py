"""Sites of cofactors sought on proteins of other folds, by `find` and by simpler ways."""

from pathlib import Path

import numpy as np
import pandas as pd

from measures import cofactors
from measures.tables import write_tables
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.workflow.jobs import job


def main(sites: str, table: str, means: str) -> None:
    """Write a row per query, target and method, and their means; files of each site lie next to the table of sites."""
    entries, folder = pd.read_csv(sites), Path(sites).parent
    rows = cofactors.measure(
        entries["name"].to_list(),
        entries["class"].to_list(),
        [text.split() for text in entries["site_residues"]],
        [read_molecule(folder / f"{name}.pdb.gz") for name in entries["name"]],
        [np.loadtxt(folder / f"{name}.lig.gz", ndmin=2) for name in entries["name"]],
    )
    write_tables({table: rows, means: cofactors.means(rows)}, "%.4g")


if __name__ == "__main__":
    with job(snakemake):
        main(
            sites=snakemake.input.sites,
            table=snakemake.output.table,
            means=snakemake.output.means,
        )
