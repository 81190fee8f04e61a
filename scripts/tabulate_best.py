"""Tabulate the best combination in each range of n_S, and the best of all."""

import json
from pathlib import Path

from sparsurf.rounding import write_table
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study import tables
from sparsurf.study.grid import add_scaled_link, read_grid
from sparsurf.study.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job


def main(
    surface: str,
    roughness: str,
    grid: str,
    distances: str,
    floors: str,
    ranges: str,
    best: str,
    settings: Settings,
    seed: int,
    name: str,
    n_ranges: int,
    threads: int = 1,
) -> None:
    """Write ranges.csv and best.json.

    Parameters
    ----------
    name : protein/conformation
    n_ranges : number of equal ranges of n_S
    """
    result = read_grid(distances)
    table = tables.read_table(grid, len(result.combinations), "combinations")
    noise_floors = tables.floors_by_name(tables.read_table(floors))
    dots = read_npz(surface)
    rough, evaluation = tables.read_roughness(roughness, dots), settings.evaluation
    prepared = PreparedSurface(dots, settings, rough, Streams(seed, name), threads)
    best_in_ranges = add_scaled_link(
        tables.ranges_table(table, result, n_ranges, noise_floors),
        prepared,
        number_of_tests(evaluation.test_dots, len(dots)),
        evaluation.draws,
    )
    best_of_all = tables.best_combinations(table, result, tables.MAX_N_S_PERCENT, noise_floors)
    write_table(ranges, best_in_ranges)
    Path(best).write_text(json.dumps(best_of_all, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            grid=snakemake.input.grid,
            distances=snakemake.input.distances,
            floors=snakemake.input.floors,
            ranges=snakemake.output.ranges,
            best=snakemake.output.best,
            settings=Settings.of(snakemake.params),
            seed=snakemake.params.seed,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            n_ranges=snakemake.params.ranges,
            threads=snakemake.threads,
        )
