"""Subsets of one structure that are denser where it is rough, or where it is flat."""

from measures.exponents import measure
from measures.molecules import atoms_of
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.workflow.jobs import job


def main(
    structure: str,
    table: str,
    protein: str,
    exponents: list[float],
    percents: list[float],
    test_dots: int,
    draws: int,
    seed: int,
    threads: int,
) -> None:
    """Write Z for every exponent, n_S and sampler."""
    surface = molecular_surface(*atoms_of(structure))
    prepared = PreparedSurface(surface, seed=seed, name=protein, threads=threads)
    z = measure(prepared, exponents, percents, test_dots, draws)
    z.assign(protein=protein).to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            table=snakemake.output.table,
            protein=snakemake.wildcards.protein,
            exponents=snakemake.params.exponents,
            percents=snakemake.params.percents,
            test_dots=snakemake.params.test_dots,
            draws=snakemake.params.draws,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
