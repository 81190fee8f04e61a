"""Compare the paper's Table I and its claims with results on the same protein."""

import json
from pathlib import Path

import numpy as np

from sparsurf.paper import published_runs, replication
from sparsurf.report.figures import layout
from sparsurf.report.figures.table1 import table1_figure
from sparsurf.report.page import embedded, write
from sparsurf.report.paper_page import TEMPLATE, paper_page, surface_of
from sparsurf.rounding import write_table
from sparsurf.sampling import published
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.study.tables import add_reference_columns, read_roughness, read_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job, reporter


def main(
    surface: str,
    roughness: str,
    grid: str,
    ranges: str,
    best: str,
    required_dots: str,
    bins: str,
    page: str,
    tables: dict[str, str],
    png: str,
    svg: str,
    settings: Settings,
    seed: int,
    a1: str,
    path_to_surface: str | None,
    threads: int = 1,
) -> None:
    """Write the tables of the comparison, the figure of Table I and the page of verdicts.

    Parameters
    ----------
    grid, ranges, best, required_dots, bins : results of the conformation that is the paper's A1
    tables : paths to be written, by the names runs, places, tests, rows, links, defects and family
    a1 : protein/conformation
    path_to_surface : file of the surface where the config names one; None for a surface that was computed
    """
    dots = read_npz(surface)
    rough = read_roughness(roughness, dots)
    best_results = json.loads(Path(best).read_text(encoding="utf-8"))
    grid_table = read_table(grid, best_results["combinations"], "combinations")
    prepared = PreparedSurface(dots, settings, rough, Streams(seed, a1), threads)
    sampling, evaluation = settings.sampling, settings.evaluation
    combinations = published.parameter_grid(sampling.alpha, sampling.beta, sampling.gamma, sampling.delta)
    n_tests, draws = number_of_tests(evaluation.test_dots, len(dots)), evaluation.draws

    progress = reporter(f"{a1} as published", "runs of the grid")
    runs = published_runs.runs_as_published(prepared, combinations, progress=progress)
    ranks = published_runs.place_published_values(runs)
    n_centres = published_runs.centres_in_random_orders(prepared)
    results = {
        "runs": runs,
        "places": ranks,
        "tests": published_runs.tests_of_table_1(ranks, n_centres),
        "rows": replication.published_rows(prepared, n_tests, draws),
        "links": replication.sweep_links(prepared, replication.LINK_DISTANCES, n_tests, draws),
        "defects": replication.compare_defects(prepared, n_tests, draws),
        "family": replication.tuned_family(prepared, combinations[:, 1:], n_tests=n_tests, draws=draws),
    }
    for key, result in results.items():
        write_table(tables[key], add_reference_columns(result, best_results["references"]))
    facts = paper_page(
        results
        | {
            "grid": grid_table,
            "ranges": read_table(ranges),
            "best": best_results,
            "bias": published_runs.selection_bias(runs, grid_table),
            "signs": replication.sign_changes(results["links"]),
            "bins": read_table(bins),
            "required_dots": read_table(required_dots),
            "family": replication.best_of_family(results["family"]),
            "gathering": replication.gathering_by_roughness(prepared, draws),
            "uniform": {"median": float(np.median(np.bincount(prepared.cover.dot)))},
            "surface": surface_of(prepared, settings.surface, path_to_surface),
        }
    )
    figure = table1_figure(results["places"], results["rows"])
    for path in (svg, png):
        layout.save(figure, path)
    write(page, TEMPLATE, **facts, first=a1, figure=embedded(png))


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            grid=snakemake.input.grid,
            ranges=snakemake.input.ranges,
            best=snakemake.input.best,
            required_dots=snakemake.input.required_dots,
            bins=snakemake.input.bins,
            page=snakemake.output.page,
            tables={
                "runs": snakemake.output.runs,
                "places": snakemake.output.places,
                "tests": snakemake.output.tests,
                "rows": snakemake.output.rows,
                "links": snakemake.output.links,
                "defects": snakemake.output.defects,
                "family": snakemake.output.family,
            },
            png=snakemake.output.png,
            svg=snakemake.output.svg,
            settings=Settings.of(snakemake.params),
            seed=snakemake.params.seed,
            a1=snakemake.params.a1,
            path_to_surface=snakemake.params.path_to_surface,
            threads=snakemake.threads,
        )
