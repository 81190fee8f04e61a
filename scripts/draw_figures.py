"""Draw the figures of one surface, each by the module of its name in sparsurf.report.figures."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.patches.islands import patch
from sparsurf.recovery.errors import distance_to_surface
from sparsurf.recovery.readings import READINGS, comparable_density, readings_of_columns
from sparsurf.recovery.recovering import recover
from sparsurf.report.figures import (
    d_over_grid,
    layout,
    number_of_dots,
    required_dots,
    rough_and_flat,
    roughness,
    subsets,
)
from sparsurf.report.figures.results import Results
from sparsurf.rounding import write_table
from sparsurf.sampling.combination import Combination
from sparsurf.sampling.samplers import sampler_label
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study import rough_and_flat as by_roughness
from sparsurf.study.floors import FRESH
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.tables import read_minimal, read_roughness, read_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow.jobs import job

FIGURES = {
    "required_dots": required_dots,
    "roughness": roughness,
    "number_of_dots": number_of_dots,
    "d_over_grid": d_over_grid,
    "rough_and_flat": rough_and_flat,
    "subsets": subsets,
}
MAX_TEST_DOTS = 8_000  # by roughness
TEST_DOTS_PER_TEST_DOT = 10  # test dots by roughness for each of the grid: a study of fewer is a quick one
DRAWS = 6  # of the combination, for the numbers by roughness


def main(
    surface: str,
    roughness: str,
    grid: str,
    best: str,
    floors: str,
    required_dots: str,
    curves: str,
    minimal: str,
    figures: list[str],
    bins: str,
    settings: Settings,
    seed: int,
    name: str,
    threads: int = 1,
) -> None:
    """Draw and save every figure, as PNG and SVG, and write the numbers of the one by roughness.

    Parameters
    ----------
    figures : paths of PNG and SVG files, called as in `FIGURES`
    bins : table of Z by roughness, to be written
    name : protein/conformation
    """
    dots = read_npz(surface)
    rough = read_roughness(roughness, dots)
    results_of_grid = json.loads(Path(best).read_text(encoding="utf-8"))
    readings = readings_of_columns(results_of_grid)
    combination = Combination.from_row(results_of_grid[readings[0]]["unrestricted"])
    prepared = PreparedSurface(dots, settings, rough, Streams(seed, name), threads)
    table = read_minimal(minimal, dots)
    subset = Surface(table[["x", "y", "z"]].to_numpy(), table[["nx", "ny", "nz"]].to_numpy())
    sampled, uniform = (
        Surface(dots.points[kept], dots.normals[kept]) for kept in prepared.pair(combination, 0)
    )
    n_tests, test_dots = MAX_TEST_DOTS, settings.evaluation.test_dots
    if isinstance(test_dots, int):
        n_tests = min(MAX_TEST_DOTS, TEST_DOTS_PER_TEST_DOT * test_dots)
    sampler = sampler_label(settings.minimal.sampler)
    results = Results(
        name=name,
        surface=dots,
        roughness=rough,
        best=results_of_grid,
        floor=settings.minimal.floor or FRESH,
        subsets=[
            (
                f"the paper's sampling, highest d {READINGS[readings[0]].words}, {combination}",
                sampled,
                layout.SAMPLED,
            ),
            ("uniform subset of the same size", uniform, layout.LINES["uniform"][0]),
            (f"minimal.csv, {sampler}", subset, layout.DARK),
        ],
        recovered=_recovered(prepared, subset, threads),
        rough_and_flat=_rough_and_flat(
            prepared, combination, readings, n_tests, results_of_grid["references"], bins
        ),
        grid=read_table(grid, results_of_grid["combinations"], "combinations"),
        floors=read_table(floors),
        required_dots=read_table(required_dots),
        curves=read_table(curves),
    )
    for figure, module in FIGURES.items():
        drawn = module.draw(results)
        for path in figures:
            if Path(path).stem == figure:
                layout.save(drawn, path)


def _recovered(prepared: PreparedSurface, subset: Surface, threads: int) -> tuple[str, Surface, np.ndarray]:
    """Recover the surface from the minimal subset: title, surface, and its distance from the whole one."""
    density = comparable_density(prepared.density, prepared.patches.D_link)
    surface = Surface(*recover(subset.points, subset.normals, density, threads=threads))
    distance = distance_to_surface(surface.points, prepared.points, prepared.normals, threads)
    return "recovered from minimal.csv", surface, distance


def _rough_and_flat(
    prepared: PreparedSurface,
    combination: Combination,
    readings: list[str],
    n_tests: int,
    references: dict,
    path_to_bins: str,
) -> dict:
    """Measure Z by roughness around kept dots and around any dots, write it to a table, and cut two patches to show."""
    results = {
        around: by_roughness.by_roughness(prepared, combination, readings, n_tests, DRAWS, kept)
        for around, kept in by_roughness.AROUND.items()
    }
    tables = [
        by_roughness.bins_table(results[around], kept).assign(around=around)
        for around, kept in by_roughness.AROUND.items()
    ]
    write_table(path_to_bins, pd.concat(tables, ignore_index=True))
    kept_dots = results["kept dots"]
    panels = [
        (
            f"around kept dots, {READINGS[reading].words}",
            kept_dots.roughness[0],
            *kept_dots.z[reading][:, 0],
        )
        for reading in readings
    ]
    anywhere, patches = results["any dots"], []
    ranked = anywhere.dots[0][np.argsort(anywhere.roughness[0], kind="stable")]
    for kind, dot in (("rough", ranked[len(ranked) // 20]), ("flat", ranked[-len(ranked) // 20])):
        dots = patch(prepared.index, dot, prepared.patches.R_zernike)
        kept = [np.flatnonzero(np.isin(dots, subset)) for subset in prepared.pair(combination, 0)]
        title = f"{kind} patch, R = {prepared.roughness[dot]:.2f}"
        patches.append((title, prepared.points[dots], prepared.normals[dots], *kept))
    return {"panels": panels, "patches": patches, "references": references}


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            grid=snakemake.input.grid,
            best=snakemake.input.best,
            floors=snakemake.input.floors,
            required_dots=snakemake.input.required_dots,
            curves=snakemake.input.curves,
            minimal=snakemake.input.minimal,
            figures=[*snakemake.output.svg, *(snakemake.output[figure] for figure in FIGURES)],
            bins=snakemake.output.bins,
            settings=Settings.of(snakemake.params),
            seed=snakemake.params.seed,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
