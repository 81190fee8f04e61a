"""How many dots of one surface are enough for an error in Å, and the coverage of the interval of that number."""

import pandas as pd

from measures import enough, fragments
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    name, params = snakemake.wildcards.protein, snakemake.params
    prepared = fragments.prepare(snakemake.input.structure, params, f"enough {name}", snakemake.threads)
    hydrogens = not read_molecule(snakemake.input.structure).heavy.all()
    table = enough.enough_table(prepared, params.error, hydrogens)
    covered = enough.coverage_of_error(prepared, params.error, hydrogens, params.seeds)
    table.insert(0, "surface", name)
    table.to_csv(snakemake.output.table, index=False)
    pd.DataFrame([{"surface": name} | covered]).to_csv(snakemake.output.coverage, index=False)
