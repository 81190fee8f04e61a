"""Other ways to store the surface of one structure in as many bytes; meshes need the package pymeshlab."""

from measures import opponents, rebuilding
from measures.molecules import atoms_of
from sparsurf_study.workflow.jobs import job

MAX_ATOMS_FOR_MESHES = 3_000  # meshes of larger structures take minutes each

with job(snakemake):
    xyz, radii = atoms_of(snakemake.input.structure)
    meshes = len(xyz) <= MAX_ATOMS_FOR_MESHES and rebuilding.installed()
    simplify, rebuilders = (rebuilding.simplify, rebuilding.rebuilders()) if meshes else (None, {})
    opponents.measure(
        snakemake.wildcards.protein,
        xyz,
        radii,
        simplify,
        rebuilders,
        snakemake.params.test_dots,
        snakemake.params.percents,
        snakemake.params.seed,
        snakemake.threads,
    ).to_csv(snakemake.output.table, index=False)
