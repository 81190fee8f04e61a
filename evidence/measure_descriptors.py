"""How far a rotation and fresh dots change each descriptor on one structure."""

import pandas as pd

from measures.molecules import atoms_of
from measures.steadiness import steadiness
from sparsurf.streams import stream
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    protein, seed = snakemake.wildcards.protein, snakemake.params.seed
    xyz, radii = atoms_of(snakemake.input.structure)
    points = molecular_surface(xyz, radii).points
    tests = points[stream(seed, protein, "tests").permutation(len(points))[: snakemake.params.test_dots]]
    tables = [
        steadiness(xyz, radii, tests, stream(seed, protein, "turns"), density, snakemake.threads)
        for density in snakemake.params.densities
    ]
    pd.concat(tables).assign(surface=protein).to_csv(snakemake.output.changes, index=False)
