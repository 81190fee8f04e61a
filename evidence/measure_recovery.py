"""Quality of the surfaces recovered from subsets of one structure."""

from measures import recovery
from measures.molecules import atoms_of
from sparsurf.workflow.jobs import job

MAX_ATOMS_FOR_ALL_SAMPLERS = 20_000  # larger structures: the farthest-point sampler only


def main(
    structure: str,
    subsets: str,
    floors: str,
    protein: str,
    percents: list[float],
    test_dots: int,
    seed: int,
    threads: int,
) -> None:
    """Write a row per sampler and n_S, and the noise floors."""
    xyz, radii = atoms_of(structure)
    samplers = recovery.NAMES[:1] if len(xyz) > MAX_ATOMS_FOR_ALL_SAMPLERS else recovery.NAMES
    floor_table, subset_table = recovery.measure(
        protein, xyz, radii, test_dots, percents, samplers, seed, threads
    )
    floor_table.to_csv(floors, index=False)
    subset_table.to_csv(subsets, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            subsets=snakemake.output.subsets,
            floors=snakemake.output.floors,
            protein=snakemake.wildcards.protein,
            percents=snakemake.params.percents,
            test_dots=snakemake.params.test_dots,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
