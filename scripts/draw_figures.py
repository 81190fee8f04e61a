"""The figures of one surface: one per output, each by the module of that name in sparsurf.report.figures."""

import json
from importlib import import_module
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.patches.islands import patch
from sparsurf.recovery.readings import READINGS, readings_in
from sparsurf.recovery.recovering import recover
from sparsurf.report.figures import layout
from sparsurf.report.figures.results import Results
from sparsurf.sampling.combination import Combination
from sparsurf.study import rough_and_flat
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.off_recovered import off
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run

SPARSE = Combination(1.0, 1.0, 10.0, 0.0)  # Fig. 5 D of the paper: few dots, where the surface is rough
MOST_TESTS = 8_000  # test dots by roughness: the rarest roughness decides how many each bin may show
PER_TEST = 40  # test dots by roughness for each of the grid: a study of fewer is a quick one
DRAWS = 6  # of the combination, for the numbers by roughness


def main(inputs, outputs, settings, name, threads):
    """Draw and save every figure that `outputs` names."""
    surface = read_npz(inputs["surface"])
    rough = pd.read_csv(inputs["roughness"])["roughness"].to_numpy()
    grid = pd.read_csv(inputs["grid"])
    best = json.loads(Path(inputs["best"]).read_text(encoding="utf-8"))
    readings = readings_in(best)
    combination = Combination.of(best[readings[0]]["unrestricted"])
    evaluator = Evaluator.from_settings(surface, settings, rough, name, threads)
    sampled, random = evaluator.pair(combination, 0)
    sparse, random_sparse = evaluator.pair(SPARSE, 0)
    subsets = [
        ("all dots", np.arange(len(surface))),
        (f"sampled, {combination}", sampled),
        ("random, as many", random),
        (f"sampled, {SPARSE}", sparse),
        ("random, as many", random_sparse),
    ]
    wished = settings["evaluation"]["test_dots"]
    n_tests = MOST_TESTS if wished == "published" else min(MOST_TESTS, PER_TEST * wished)
    fourth = _rough_and_flat(evaluator, combination, readings, n_tests, best["yardsticks"], outputs["bins"])
    recovered = [
        _recovered(surface, f"recovered from {letter}", kept)
        for letter, (_, kept) in zip("DE", subsets[3:], strict=True)
    ]
    results = Results(surface, rough, grid, best, subsets, fourth, recovered)
    for figure in outputs.keys() - {"svgs", "bins"}:
        draw = import_module(f"sparsurf.report.figures.{figure}").draw
        layout.save(draw(results), outputs[figure].removesuffix(".png"))


def _recovered(surface, title, kept):
    """Title, points and normals of the surface that kept dots give back, and its distance from the whole one."""
    points, normals = recover(surface.points[kept], surface.normals[kept])
    return title, points, normals, off(points, surface.points, surface.normals)


def _rough_and_flat(evaluator, combination, readings, n_tests, yardsticks, path_to_bins):
    """What Figure 4 shows, its numbers being written to a table: patches around kept dots, beside those around any dots."""
    found = {
        around: rough_and_flat.by_roughness(evaluator, combination, readings, n_tests, DRAWS, kept)
        for around, kept in rough_and_flat.AROUND.items()
    }
    tables = [
        rough_and_flat.bins_table(found[around], kept).assign(around=around)
        for around, kept in rough_and_flat.AROUND.items()
    ]
    pd.concat(tables, ignore_index=True).to_csv(path_to_bins, index=False)
    panels = [
        (f"{around}, {READINGS[reading].words}", own.roughness[0], *own.z[reading][:, 0])
        for reading in readings
        for around, own in found.items()
    ]
    anywhere, patches = found["any dots"], []
    ranked = anywhere.dots[0][np.argsort(anywhere.roughness[0], kind="stable")]
    for title, dot in (("rough", ranked[len(ranked) // 20]), ("flat", ranked[-len(ranked) // 20])):
        ids = patch(evaluator.index, dot, evaluator.r_zernike)
        of_patch = [np.flatnonzero(np.isin(ids, subset)) for subset in evaluator.pair(combination, 0)]
        title = f"{title} patch, R = {evaluator.roughness[dot]:.2f}"
        patches.append((title, evaluator.points[ids], evaluator.normals[ids], *of_patch))
    return {
        "panels": panels,
        "patches": patches,
        "rng": evaluator.stream("figure 4"),
        "yardsticks": yardsticks,
    }


if __name__ == "__main__":
    run(main, snakemake)
