"""Sample a surface with every combination of the grid and compare the subsets with the whole surface."""

from sparsurf.sampling import published
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study import grid as grids
from sparsurf.study.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.study.tables import grid_table, read_roughness
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job, reporter


def main(
    surface: str,
    roughness: str,
    grid: str,
    distances: str,
    settings: Settings,
    seed: int,
    name: str,
    threads: int = 1,
) -> None:
    """Write grid.csv and the distances behind it.

    Parameters
    ----------
    name : protein/conformation
    """
    dots = read_npz(surface)
    prepared = PreparedSurface(dots, settings, read_roughness(roughness, dots), Streams(seed, name), threads)
    sampling, evaluation = settings.sampling, settings.evaluation
    result = grids.evaluate_grid(
        prepared,
        published.parameter_grid(sampling.alpha, sampling.beta, sampling.gamma, sampling.delta),
        number_of_tests(evaluation.test_dots, len(dots)),
        evaluation.draws,
        tuple(evaluation.readings),
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
            settings=Settings.of(snakemake.params),
            seed=snakemake.params.seed,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
