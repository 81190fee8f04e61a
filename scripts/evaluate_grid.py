"""Sample a surface with every combination of the grid and compare the subsets with the whole surface."""

from sparsurf.sampling import published
from sparsurf.study import grid as grids
from sparsurf.study.prepared_surface import number_of_tests, prepare_surface
from sparsurf.study.tables import grid_table, read_roughness
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job, reporter


def main(
    surface: str,
    roughness: str,
    grid: str,
    distances: str,
    patches: dict,
    sampling: dict,
    evaluation: dict,
    seed: int,
    name: str,
    threads: int = 1,
) -> None:
    """Write grid.csv and the distances behind it.

    Parameters
    ----------
    patches, sampling, evaluation : dict, sections of the config
    name : protein/conformation
    """
    dots = read_npz(surface)
    prepared = prepare_surface(
        dots,
        patches,
        read_roughness(roughness, dots),
        seed,
        name,
        threads,
        sampling["distance_from_moved_centre"],
        sampling["chance_in_every_patch"],
    )
    result = grids.evaluate_grid(
        prepared,
        published.parameter_grid(sampling["alpha"], sampling["beta"], sampling["gamma"], sampling["delta"]),
        number_of_tests(evaluation["test_dots"], len(dots)),
        evaluation["draws"],
        tuple(evaluation["readings"]),
        progress=reporter(name),
    )
    grids.write_grid(distances, result)
    grid_table(result).to_csv(grid, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            grid=snakemake.output.grid,
            distances=snakemake.output.distances,
            patches=snakemake.params.patches,
            sampling=snakemake.params.sampling,
            evaluation=snakemake.params.evaluation,
            seed=snakemake.params.seed,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
