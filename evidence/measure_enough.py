"""How many dots of one surface are enough, by an error in Å and by noise floors; the coverage of the interval of the former."""

import pandas as pd

from measures import enough, fragments
from sparsurf.evaluation.required_dots import Trials
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import Surface
from sparsurf.surfaces.molecular_surface import surface_generator
from sparsurf.surfaces.radii import radii
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    name, params = snakemake.wildcards.protein, snakemake.params
    prepared = fragments.prepare(snakemake.input.structure, params, f"enough {name}", snakemake.threads)
    molecule, settings = (
        read_molecule(snakemake.input.structure),
        Surface(**params.surface | {"reentrant": params.dots}),
    )
    generator = surface_generator(
        molecule, 0, radii(molecule, "dms"), settings, prepared.patches.d_link, name
    )
    table = enough.enough_table(prepared, *generator, params.test_dots, params.error)
    trials = Trials(prepared, enough.SAMPLER, params.test_dots)
    covered = enough.coverage_of_error(trials, params.error, params.draws, params.replicates)
    table.insert(0, "surface", name)
    table.to_csv(snakemake.output.table, index=False)
    pd.DataFrame([{"surface": name} | covered]).to_csv(snakemake.output.coverage, index=False)
