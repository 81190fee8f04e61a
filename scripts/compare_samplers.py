"""Compare samplers at equal n_S on one surface."""

from sparsurf.report.figures import layout
from sparsurf.report.figures.comparison_figure import comparison_figure
from sparsurf.rounding import write_table
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study import comparison
from sparsurf.study.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.study.tables import floors_by_name, read_roughness, read_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job, reporter


def main(
    surface: str,
    roughness: str,
    ranges: str,
    floors: str,
    table: str,
    png: str,
    settings: Settings,
    percents: list[float],
    samplers: list[str] | None,
    seed: int,
    name: str,
    title: str,
    threads: int = 1,
) -> None:
    """Write compare.csv and its figure.

    Parameters
    ----------
    percents : n_S in % of the dots
    samplers : names; None for all
    name : protein/conformation
    title : its name in the figure
    """
    dots = read_npz(surface)
    rough, best = read_roughness(roughness, dots), read_table(ranges)
    prepared = PreparedSurface(dots, settings, rough, Streams(seed, name), threads)
    compared = comparison.compare_samplers(
        prepared,
        comparison.select_methods(prepared, samplers, best),
        percents,
        number_of_tests(settings.evaluation.test_dots, len(dots)),
        settings.evaluation.draws,
        reporter(f"{name}: comparison", "samplers"),
        floors_by_name(read_table(floors)),
    )
    write_table(table, compared)
    layout.save(comparison_figure(compared, title), png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            ranges=snakemake.input.ranges,
            floors=snakemake.input.floors,
            table=snakemake.output.table,
            png=snakemake.output.png,
            settings=Settings.of(snakemake.params),
            percents=snakemake.params.percents,
            samplers=snakemake.params.samplers,
            seed=snakemake.params.seed,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            title=snakemake.params.title,
            threads=snakemake.threads,
        )
