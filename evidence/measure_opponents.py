"""Other ways to store the surface of one structure in as many bytes."""

from measures import opponents, rebuilding
from measures.molecules import atoms_of
from sparsurf.workflow.jobs import job

MAX_ATOMS_FOR_MESHES = 3_000  # meshes of larger structures take minutes each


def main(
    structure: str,
    table: str,
    where: str,
    protein: str,
    percents: list[float],
    test_dots: int,
    seed: int,
    threads: int,
) -> None:
    """Write a row per method and n_S, and where each has errors; some need the package pymeshlab."""
    xyz, radii = atoms_of(structure)
    meshes = len(xyz) <= MAX_ATOMS_FOR_MESHES and rebuilding.installed()
    simplify, rebuilders = (rebuilding.simplify, rebuilding.rebuilders()) if meshes else (None, {})
    errors, errors_where = opponents.measure(
        protein, xyz, radii, simplify, rebuilders, test_dots, percents, seed, threads
    )
    errors.to_csv(table, index=False)
    errors_where.to_csv(where, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            table=snakemake.output.table,
            where=snakemake.output.where,
            protein=snakemake.wildcards.protein,
            percents=snakemake.params.percents,
            test_dots=snakemake.params.test_dots,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
