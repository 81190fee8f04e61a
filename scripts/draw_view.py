"""Draw the page on which one surface is turned, sampled, and its dots are picked, and a small picture of it."""

import json
from pathlib import Path

from PIL import Image  # matplotlib takes longer to import than all of this to draw

from sparsurf_study.workflow.jobs import job
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.sampling.samplers import farthest
from sparsurf.surfaces.formats.npz import read_npz, with_fields_of_file
from sparsurf.views.render import along_smallest_axis, thumbnail
from sparsurf.views.viewer.page import MAX_DOTS, page, values_of
from sparsurf_study.analysis.reconstructed import read_reconstructed
from sparsurf_study.analysis.tables import read_minimal, read_roughness, read_table
from sparsurf_study.report.page_origin import origin_of_page, with_atoms
from sparsurf_study.structures import residue_labels

FIRST_PAGE = "surface.html"  # of draw_roughness, in the same folder

with job(snakemake) as s:
    dots = with_fields_of_file(read_npz(s.input.surface), s.input.fields or None)
    roughness, subset = read_roughness(s.input.roughness, dots), read_minimal(s.input.minimal, dots)
    # the random stream of minimal.csv, so that both have the same dots where that is farthest-point sampling
    streams = s.streams(shared=True)
    prepared = PreparedSurface(dots, s.settings, roughness, streams)
    order = farthest(prepared, min(len(dots), MAX_DOTS), streams("minimal", "farthest"))
    _, distance = read_reconstructed(s.input.reconstructed, len(dots))
    best = json.loads(Path(s.input.best).read_text(encoding="utf-8")) if s.input.best else None
    on_atoms = with_atoms(dots, s.input.structure, s.settings)
    text = page(
        s.params.title,
        prepared,
        {"farthest": order},
        read_table(s.input.grid, best["combinations"], "combinations") if best else None,
        best,
        residue_labels(s.input.structure or None),
        values_of(dots, distance),
        subset["dot"].tolist() if "dot" in subset else [],
        turn=along_smallest_axis(dots.points),
        first=FIRST_PAGE,
        origin=origin_of_page(on_atoms, s.input.structure or s.input.surface),
        atoms=on_atoms.origin,
    )
    Path(s.output.page).write_text(text, encoding="utf-8")
    Image.fromarray(thumbnail(dots.points, dots.normals, roughness)).save(s.output.picture)
