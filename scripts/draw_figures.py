"""Draw the figures of one surface, each by the module of its name in sparsurf_study.report.figures."""

import json
from importlib import import_module
from pathlib import Path

from sparsurf_study.workflow.jobs import job
from sparsurf.patches.readings import words_of
from sparsurf.recovery.readings import readings_of_columns
from sparsurf.sampling.combination import Combination
from sparsurf.sampling.samplers import sampler_label
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout
from sparsurf_study.analysis.reconstructed import read_reconstructed
from sparsurf_study.analysis.rough_and_flat import kept_and_any, table_of_bins
from sparsurf_study.analysis.tables import read_minimal, read_table, surface_of_minimal
from sparsurf_study.report import pictures
from sparsurf_study.report.figures import rough_and_flat, subsets
from sparsurf_study.report.figures.results import Results
from sparsurf_study.rounding import write_rounded

with job(snakemake) as s:
    best = json.loads(Path(s.input.best).read_text(encoding="utf-8"))
    readings = readings_of_columns(best)
    combination = Combination.from_row(best[readings[0]]["unrestricted"])
    prepared = s.prepared(s.streams())
    table = read_minimal(s.input.minimal, prepared.surface)
    minimal, errors = surface_of_minimal(table), read_table(s.input.recovered)
    sampled, uniform = (
        Surface(prepared.points[kept], prepared.normals[kept]) for kept in prepared.pair(combination, 0)
    )
    around = kept_and_any(prepared, combination, readings, s.settings.evaluation.test_dots)
    write_rounded(s.output.bins, table_of_bins(around))
    title = f"the paper's sampling, highest d {words_of(readings[0])}, {combination}"
    results = Results(
        name=s.place,
        surface=prepared.surface,
        roughness=prepared.roughness,
        best=best,
        subsets=[
            (title, sampled, layout.SAMPLED),
            ("random subset of the same size", uniform, layout.RANDOM),
            (f"minimal subset, {sampler_label(errors['sampler'].iloc[0])}", minimal, layout.DARK),
        ],
        recovered=subsets.recovered_from(
            prepared.points, *read_reconstructed(s.input.reconstructed, len(prepared))
        ),
        rough_and_flat=rough_and_flat.content_of_figure(around, best["references"]),
        grid=read_table(s.input.grid, best["combinations"], "combinations"),
        recovered_errors=errors,
    )
    no_figures = {s.output.bins, s.output.picture_sampled, s.output.picture_minimal}
    drawn = [Path(path) for path in s.output if path not in no_figures]
    for name in dict.fromkeys(path.stem for path in drawn):  # drawn once for all formats of a figure
        figure = import_module(f"sparsurf_study.report.figures.{name}").draw(results)
        for path in [path for path in drawn if path.stem == name]:
            layout.save(figure, path)
    of_subsets = (
        (s.output.picture_sampled, sampled, layout.SAMPLED),
        (s.output.picture_minimal, minimal, layout.DARK),
    )
    pictures.draw_subset_pictures(prepared.surface, of_subsets)
