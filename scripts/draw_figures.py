"""The figures of one surface: one per output, each by the module of that name in sparsurf.report.figures."""

import json
from importlib import import_module
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.patches.islands import patch
from sparsurf.recovery.errors import off
from sparsurf.recovery.readings import READINGS, fair_density, readings_in
from sparsurf.recovery.recovering import recover
from sparsurf.report.figures import layout
from sparsurf.report.figures.results import Results
from sparsurf.sampling.combination import Combination
from sparsurf.sampling.samplers import called
from sparsurf.study import rough_and_flat
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.floors import FRESH
from sparsurf.study.tables import read_minimal, read_roughness, read_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow.jobs import run

TABLES = ("curves", "floors", "enough")
MOST_TESTS = 8_000  # test dots by roughness
PER_TEST = 10  # test dots by roughness for each of the grid: a study of fewer is a quick one
DRAWS = 6  # of the combination, for the numbers by roughness


def main(inputs, outputs, settings, name, threads):
    """Draw and save every figure that `outputs` names."""
    surface = read_npz(inputs["surface"])
    rough = read_roughness(inputs["roughness"], surface)
    best = json.loads(Path(inputs["best"]).read_text(encoding="utf-8"))
    tables = {key: read_table(inputs[key]) for key in TABLES}
    tables["grid"] = read_table(inputs["grid"], best["combinations"], "combinations")
    readings = readings_in(best)
    combination = Combination.of(best[readings[0]]["unrestricted"])
    evaluator = Evaluator.from_settings(surface, settings, rough, name, threads)
    minimal = read_minimal(inputs["minimal"], surface)
    handed_out = Surface(minimal[["x", "y", "z"]].to_numpy(), minimal[["nx", "ny", "nz"]].to_numpy())
    subsets = [
        (f"the paper's sampling, its best here, {combination}", layout.SAMPLED),
        ("uniform subset of the same size", layout.LINES["uniform"][0]),
    ]
    pair = [Surface(surface.points[dots], surface.normals[dots]) for dots in evaluator.pair(combination, 0)]
    subsets = [(words, own, colour) for (words, colour), own in zip(subsets, pair, strict=True)]
    requested = settings["evaluation"]["test_dots"]
    n_tests = MOST_TESTS if requested == "published" else min(MOST_TESTS, PER_TEST * requested)
    results = Results(
        name=name,
        surface=surface,
        roughness=rough,
        best=best,
        floor=settings["minimal"].get("floor", FRESH),
        subsets=[
            *subsets,
            (f"minimal.csv, {called(_sampler(settings['minimal'])).words}", handed_out, layout.DARK),
        ],
        recovered=_recovered(evaluator, handed_out, threads),
        rough_and_flat=_rough_and_flat(
            evaluator, combination, readings, n_tests, best["references"], outputs["bins"]
        ),
        **tables,
    )
    for figure in outputs.keys() - {"svgs", "bins"}:
        draw = import_module(f"sparsurf.report.figures.{figure}").draw
        layout.save(draw(results), outputs[figure].removesuffix(".png"))


def _sampler(asked):
    """What chose the dots of minimal.csv: a combination is of the paper's sampling, by default, too."""
    return "paper" if "combination" in asked and asked["sampler"] == "farthest" else asked["sampler"]


def _recovered(evaluator, kept, threads):
    """Title and surface of what kept dots give back, and its distance from the whole one."""
    density = fair_density(evaluator.density, evaluator.d_link)
    back = Surface(*recover(kept.points, kept.normals, density, threads=threads))
    return "recovered from minimal.csv", back, off(back.points, evaluator.points, evaluator.normals, threads)


def _rough_and_flat(evaluator, combination, readings, n_tests, references, path_to_bins):
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
        (f"patches around {around}, {READINGS[reading].words}", own.roughness[0], *own.z[reading][:, 0])
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
        "references": references,
    }


if __name__ == "__main__":
    run(main, snakemake)
