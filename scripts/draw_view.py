"""Draw the page on which one surface is turned, sampled, and its dots are picked, and a small picture of it."""

import json
from pathlib import Path

from PIL import Image  # matplotlib takes longer to import than all of this to draw

from sparsurf_study.workflow.jobs import job
from sparsurf.api.pages import LINKS_OF_VIEW, page_of_dots, values_of_fields
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.sampling.samplers import farthest
from sparsurf.surfaces.components import COMPONENT_FIELD
from sparsurf.surfaces.formats.npz import read_npz, with_fields_of_file
from sparsurf.views.render import DISTANCE_LIMITS, along_smallest_axis, thumbnail
from sparsurf.views.viewer.dots import MAX_DOTS, ShownDots
from sparsurf.views.viewer.scene import DotValues
from sparsurf_study.analysis.reconstructed import read_reconstructed
from sparsurf_study.analysis.tables import read_minimal, read_roughness, read_table
from sparsurf_study.report.page_origin import origin_of_page, with_atoms

DISTANCE = "distance from the surface reconstructed from minimal.csv"

with job(snakemake) as s:
    dots = with_fields_of_file(read_npz(s.input.surface), s.input.fields or None)
    roughness, subset = read_roughness(s.input.roughness, dots), read_minimal(s.input.minimal, dots)
    # the random stream of minimal.csv, so that both have the same dots where that is farthest-point sampling
    streams = s.streams(shared=True)
    on_atoms = with_atoms(dots, s.input.structure, s.settings)
    prepared = PreparedSurface(on_atoms, s.settings, roughness, streams)
    order = farthest(prepared, min(len(dots), MAX_DOTS), streams("minimal", "farthest"))
    _, distance = read_reconstructed(s.input.reconstructed, len(dots))
    best = json.loads(Path(s.input.best).read_text(encoding="utf-8")) if s.input.best else {}
    grid = read_table(s.input.grid, best["combinations"], "combinations") if best else None
    kept = subset["dot"].tolist() if "dot" in subset else []
    values = [DotValues(DISTANCE, "distance", " Å", distance, "on it", "off", limits=DISTANCE_LIMITS)]
    text = page_of_dots(
        s.params.title,
        ShownDots(prepared, order, kept, samples=True, grid=grid, best=best),
        [*values, *values_of_fields(dots, dots.fields.get(COMPONENT_FIELD))],
        turn=along_smallest_axis(dots.points),
        links=LINKS_OF_VIEW,
        origin=origin_of_page(on_atoms, s.input.structure or s.input.surface),
    )
    Path(s.output.page).write_text(text, encoding="utf-8")
    Image.fromarray(thumbnail(dots.points, dots.normals, roughness)).save(s.output.picture)
