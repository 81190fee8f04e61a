"""How much of d the always-kept centres of patches contribute on one surface of the study of many proteins."""

from sparsurf.study.centres import centres_table
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.tables import read_roughness, read_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job


def main(
    surface: str,
    roughness: str,
    grid: str,
    ranges: str,
    table: str,
    protein: str,
    readings: list[str],
    test_dots: int,
    draws: int,
    seed: int,
    threads: int,
) -> None:
    """Write a row for each of these readings and each range."""
    dots = read_npz(surface)
    prepared = PreparedSurface(
        dots, roughness_values=read_roughness(roughness, dots), seed=seed, name=protein, threads=threads
    )
    centres = centres_table(prepared, read_table(grid), read_table(ranges), test_dots, draws)
    centres = centres[centres["reading"].isin(readings)]
    centres.assign(protein=protein).to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            grid=snakemake.input.grid,
            ranges=snakemake.input.ranges,
            table=snakemake.output.table,
            protein=snakemake.wildcards.protein,
            readings=snakemake.params.readings,
            test_dots=snakemake.params.test_dots,
            draws=snakemake.params.draws,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
