"""Figures 1 to 5 of the paper for one surface."""

import json

import numpy as np
import pandas as pd

from sparsurf import figures, grid_figures, page
from sparsurf.evaluation import Evaluator
from sparsurf.patches import patch
from sparsurf.surface import read_surface
from sparsurf.tables import PARAMETERS, combination_text
from sparsurf.workflow import job

SPARSE = (1.0, 1.0, 10.0, 0.0)  # Fig. 5 D of the paper: few dots, gathered where the surface is rough
MOST_TESTS = 30_000  # test dots of the box plots: the rarest roughness decides how many each bin may show


def main(paths_to_inputs, path_to_figure, settings, name, threads):
    """Draw and save the five figures; `path_to_figure` maps 1..5 to a path without suffix."""
    surface = read_surface(paths_to_inputs["surface"])
    rough = pd.read_csv(paths_to_inputs["roughness"])["roughness"].to_numpy()
    grid = pd.read_csv(paths_to_inputs["grid"])
    with open(paths_to_inputs["best"], encoding="utf-8") as stream:
        best = json.load(stream)
    readings = [reading for reading in ("kept", "surface") if reading in best]
    row = best[readings[0]]["unrestricted"]
    combination = [row[p] for p in PARAMETERS]
    evaluator = Evaluator.from_settings(surface, settings, rough, name, threads)
    sampled, random = evaluator.pair(combination, 0)
    sparse, random_sparse = evaluator.pair(SPARSE, 0)

    page.save(figures.figure1(surface.points, surface.normals, rough), path_to_figure[1])
    page.save(grid_figures.figure2(grid), path_to_figure[2])
    page.save(grid_figures.figure3(grid, readings), path_to_figure[3])
    page.save(_figure4(evaluator, sampled, random, readings, best["yardsticks"]), path_to_figure[4])
    subsets = [
        ("all dots", np.arange(len(surface))),
        (f"sampled, {combination_text(row)}", sampled),
        ("random, as many", random),
        (f"sampled, {combination_text(dict(zip(PARAMETERS, SPARSE, strict=True)))}", sparse),
        ("random, as many", random_sparse),
    ]
    page.save(figures.figure5(surface.points, surface.normals, subsets), path_to_figure[5])


def _figure4(evaluator, sampled, random, readings, yardsticks):
    """Box plots over many test dots, and the patch of a rough and of a flat dot (5th and 95th percentile)."""
    tests = evaluator.draw_tests(MOST_TESTS, "figure 4")
    z_tot, _ = evaluator.describe(tests)
    distances = {}
    for reading in readings:
        z, _ = evaluator.distances([sampled, random], tests, z_tot, reading)
        distances[reading] = (z[0], z[1])
    ranked = tests[np.argsort(evaluator.roughness[tests], kind="stable")]
    patches = []
    for title, dot in (("rough", ranked[len(ranked) // 20]), ("flat", ranked[-len(ranked) // 20])):
        ids = patch(evaluator.index, dot, evaluator.r_zernike)
        kept = [np.flatnonzero(np.isin(ids, subset)) for subset in (sampled, random)]
        title = f"{title} patch, R = {evaluator.roughness[dot]:.2f}"
        patches.append((title, evaluator.points[ids], evaluator.normals[ids], *kept))
    rng = evaluator.stream("figure 4")
    return figures.figure4(evaluator.roughness[tests], distances, patches, rng, yardsticks)


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            paths_to_inputs={key: snakemake.input[key] for key in ("surface", "roughness", "grid", "best")},
            path_to_figure={k: output[f"png{k}"].removesuffix(".png") for k in range(1, 6)},
            settings=snakemake.params.settings,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
