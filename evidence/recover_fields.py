"""Fields of one structure recovered from few dots."""

from dataclasses import replace

import sparsurf
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.recovery.fields import SUBSET_PERCENTS, recovery_table
from sparsurf.workflow.jobs import job


def main(structure: str, table: str, protein: str) -> None:
    """Write a row per field and share of the dots."""
    molecule = read_molecule(structure)
    dots = sparsurf.surface(molecule)
    fields = sparsurf.fields(molecule, dots)
    surface = replace(dots, fields=fields)
    recovered = recovery_table(surface, sparsurf.sample(surface, percent=SUBSET_PERCENTS[-1]))
    percent = [*SUBSET_PERCENTS] * fields.shape[1]
    recovered.assign(protein=protein, percent=percent).to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            table=snakemake.output.table,
            protein=snakemake.wildcards.protein,
        )
