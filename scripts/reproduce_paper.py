"""The paper's Table I beside ours, what it rests on, and a verdict on each of its claims."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import paper, sampling, tables
from sparsurf.evaluation import Evaluator, number_of_tests
from sparsurf.surface import read_surface
from sparsurf.verdict import as_html, rough_and_flat, verdict
from sparsurf.workflow import job, reporter

MOST_TESTS = 4000  # test dots of the comparison of rough with flat patches


def main(inputs, outputs, settings, name, threads):
    """Write the tables of the comparison and the page of verdicts."""
    surface = read_surface(inputs["surface"])
    rough = pd.read_csv(inputs["roughness"])["roughness"].to_numpy()
    grid, ranges = pd.read_csv(inputs["grid"]), pd.read_csv(inputs["ranges"])
    best = json.loads(Path(inputs["best"]).read_text(encoding="utf-8"))
    evaluator = Evaluator.from_settings(surface, settings, rough, name, threads)
    lists = settings["sampling"]
    combinations = sampling.grid(lists["alpha"], lists["beta"], lists["gamma"], lists["delta"])
    n_tests = number_of_tests(settings["evaluation"]["test_dots"], len(surface))
    draws = settings["evaluation"]["draws"]

    report = reporter(f"{name} as published", "runs of the grid")
    selected = paper.as_published(evaluator, combinations, progress=report)
    bias = paper.selection_bias(selected, grid)
    rows = paper.rows_table(
        paper.replicate_rows(evaluator), bias, paper.rows_with_shared_tests(evaluator, n_tests, draws)
    )
    own = {
        "roughness_values": rough,
        "seed": settings["seed"],
        "name": name,
        "threads": threads,
        **{key.lower(): value for key, value in settings["patches"].items()},
    }
    links = paper.sweep_links(surface, paper.LINKS, n_tests, draws, **own)
    defects = paper.compare_defects(surface, n_tests, draws, **own)
    bins = rough_and_flat(*paper.by_roughness(evaluator, best, MOST_TESTS))
    numbered = pd.concat([one.assign(run=k + 1) for k, one in enumerate(selected)], ignore_index=True)
    results = {"selected": numbered, "rows": rows, "links": links, "defects": defects, "bins": bins}
    for key, table in results.items():
        tables.with_yardsticks(table, best["yardsticks"]).to_csv(outputs[key], index=False)
    page = verdict(
        {
            "grid": grid,
            "ranges": ranges,
            "best": best,
            "rows": rows,
            "links": links,
            "defects": defects,
            "selected": selected,
            "bins": bins,
            "uniform": {"median": float(np.median(np.bincount(evaluator.cover.dot)))},
            "surface": paper.surface_sentence(evaluator, settings["made"]),
        },
        {key: Path(path).name for key, path in (inputs | outputs).items()},
    )
    page += "\n" + tables.rows_markdown(rows)
    Path(outputs["verdict"]).write_text(page, encoding="utf-8")
    Path(outputs["html"]).write_text(as_html(page), encoding="utf-8")


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            inputs={key: snakemake.input[key] for key in ("surface", "roughness", "grid", "ranges", "best")},
            outputs={
                key: output[key]
                for key in ("selected", "rows", "links", "defects", "bins", "verdict", "html")
            },
            settings=snakemake.params.settings,
            name=snakemake.params.name,
            threads=snakemake.threads,
        )
