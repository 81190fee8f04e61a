"""The paper's Table I beside ours, what it rests on, and a verdict on each of its claims."""

import json
from pathlib import Path

import numpy as np

from sparsurf.paper import published_runs, replication
from sparsurf.report.figures import layout
from sparsurf.report.figures.table1 import table1_figure
from sparsurf.report.page import embedded, write
from sparsurf.report.paper_page import TEMPLATE, paper_page, surface_of
from sparsurf.sampling import law
from sparsurf.study import tables
from sparsurf.study.evaluator import Evaluator, number_of_tests
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import reporter, run


def main(inputs, outputs, settings, name, threads, path_to_surface):
    """Write the tables of the comparison and the page of verdicts."""
    surface = read_npz(inputs["surface"])
    rough = tables.read_roughness(inputs["roughness"], surface)
    ranges = tables.read_table(inputs["ranges"])
    best = json.loads(Path(inputs["best"]).read_text(encoding="utf-8"))
    grid = tables.read_table(inputs["grid"], best["combinations"], "combinations")
    evaluator = Evaluator.from_settings(surface, settings, rough, name, threads)
    combinations = law.grid(**settings["sampling"])
    n_tests = number_of_tests(settings["evaluation"]["test_dots"], len(surface))
    draws = settings["evaluation"]["draws"]

    runs = published_runs.as_published(
        evaluator, combinations, progress=reporter(f"{name} as published", "runs of the grid")
    )
    places = published_runs.place_of_published(runs)
    results = {
        "runs": runs,
        "places": places,
        "tests": published_runs.tests_of_table_1(places, published_runs.centres_in_any_order(evaluator)),
        "rows": replication.published_rows(evaluator, n_tests, draws),
        "links": replication.sweep_links(evaluator, replication.LINKS, n_tests, draws),
        "defects": replication.compare_defects(evaluator, n_tests, draws),
        "family": replication.tuned_family(evaluator, combinations[:, 1:], n_tests=n_tests, draws=draws),
    }
    for key, table in results.items():
        tables.with_references(table, best["references"]).to_csv(outputs[key], index=False)
    page = paper_page(
        results
        | {
            "grid": grid,
            "ranges": ranges,
            "best": best,
            "bias": published_runs.selection_bias(runs, grid),
            "signs": replication.sign_changes(results["links"]),
            "bins": tables.read_table(inputs["bins"]),
            "enough": tables.read_table(inputs["enough"]),
            "family": replication.best_of_family(results["family"]),
            "uniform": {"median": float(np.median(np.bincount(evaluator.cover.dot)))},
            "surface": surface_of(evaluator, settings["surface"], path_to_surface),
        }
    )
    figure = table1_figure(results["places"], results["rows"])
    layout.save(figure, outputs["png"].removesuffix(".png"))
    write(outputs["html"], TEMPLATE, **page, first=name, figure=embedded(outputs["png"]))


if __name__ == "__main__":
    run(main, snakemake)
