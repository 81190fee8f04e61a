"""d of the published combinations on one protein with R_i and with other values in its place, on the same random numbers."""

from measures import null_result
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import Settings
from sparsurf.settings import Surface as SurfaceSettings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import surface_of_molecule
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    name, params, threads = snakemake.wildcards.protein, snakemake.params, snakemake.threads
    molecule = read_molecule(snakemake.input.structure, model=1, hydrogens=params.hydrogens)
    settings = Settings(patches=params.patches)
    rules = SurfaceSettings(**params.surface)
    surface = surface_of_molecule(molecule, rules, settings.patches.d_link, name, 0)
    streams = Streams(params.seed, f"null result {name}")
    table = null_result.differences(
        surface, settings, streams, params.readings, params.test_dots, params.draws, threads
    )
    table.insert(0, "protein", name)
    table.to_csv(snakemake.output.table, index=False)
