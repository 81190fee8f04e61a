"""A page to look at one surface, to sample it and to pick dots from it."""

import json
from pathlib import Path

import numpy as np
from PIL import Image  # matplotlib takes longer to import than all of this to draw

from sparsurf.dot_fields.registry import FIELDS
from sparsurf.molecules.read_molecule import residue_names
from sparsurf.recovery.errors import off_recovered
from sparsurf.report.figures import render
from sparsurf.report.viewer.page import MOST_DOTS, Values, page
from sparsurf.sampling.samplers import farthest
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.tables import read_minimal, read_roughness, read_table
from sparsurf.surfaces.components import FIELD, fields_alone
from sparsurf.surfaces.formats.npz import read_npz, with_fields
from sparsurf.surfaces.formats.ply import viridis
from sparsurf.workflow.jobs import run

PICTURE = 180, 240  # pixels, rows and columns


def main(inputs, outputs, settings, name, threads):
    """Write view.html and a small picture of it; the residues of the dots are known where there is a structure."""
    surface = with_fields(read_npz(inputs["surface"]), inputs.get("fields"))
    rough = read_roughness(inputs["roughness"], surface)
    evaluator = Evaluator.from_settings(surface, settings, rough, name, 1)
    best = json.loads(Path(inputs["best"]).read_text(encoding="utf-8")) if "best" in inputs else None
    # the stream of minimal.csv: the same dots, where that is farthest-point sampling
    order = farthest(
        evaluator, min(len(surface), MOST_DOTS), evaluator.nameless.stream("minimal", "farthest")
    )
    minimal = read_minimal(inputs["minimal"], surface)
    kept, normals = minimal[["x", "y", "z"]].to_numpy(), minimal[["nx", "ny", "nz"]].to_numpy()
    off = off_recovered(surface.points, kept, normals, threads)
    shown = [Values("distance from the surface recovered from minimal.csv", "off", " Å", off, "on it", "off")]
    parts = surface.fields.get(FIELD)
    if parts is not None and parts.max() > 0:
        shown.append(Values("component of the surface", "component", "", parts, "largest", "smallest"))
    for field, numbers in fields_alone(surface).items():
        words, unit = FIELDS[field][1:] if field in FIELDS else (field.replace("_", " "), "")
        shown.append(Values(words, field, f" {unit}".rstrip(), numbers))
    text = page(
        name,
        surface,
        rough,
        evaluator.cover,
        evaluator.r_patch,
        {"farthest": order},
        None if best is None else read_table(inputs["grid"], best["combinations"], "combinations"),
        best,
        residue_names(inputs["structure"]),
        shown,
        minimal.get("dot", []),
    )
    Path(outputs["page"]).write_text(text, encoding="utf-8")
    camera = render.aim(surface.points, render.along_smallest_axis(surface.points), PICTURE)
    colours = viridis(np.append(rough.clip(*render.ROUGH), render.ROUGH))[:-2] / 255  # whatever the surface
    scene = render.draw_surface(surface.points, surface.normals, colours, camera)
    Image.fromarray(render.picture(scene)).save(outputs["picture"])


if __name__ == "__main__":
    run(main, snakemake)
