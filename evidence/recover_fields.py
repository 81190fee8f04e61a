"""What few dots of one structure give back of its fields."""

from dataclasses import replace

import sparsurf
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.recovery.fields import PERCENTS, recovery_table
from sparsurf.workflow.jobs import run


def main(inputs, outputs, name):
    """Write a row per field and share of the dots."""
    molecule = read_molecule(inputs["structure"])
    dots = sparsurf.surface(molecule)
    fields = sparsurf.fields(molecule, dots)
    own = replace(dots, fields=fields)
    table = recovery_table(own, sparsurf.sample(own, percent=PERCENTS[-1]))
    percent = [*PERCENTS] * fields.shape[1]
    table.assign(protein=name, percent=percent).to_csv(outputs["table"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
