"""Draw the page on which one surface is turned, sampled, and its dots are picked."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image  # matplotlib takes longer to import than all of this to draw

from sparsurf.dot_fields.registry import FIELDS
from sparsurf.molecules.read_molecule import residue_labels
from sparsurf.recovery.errors import distance_to_recovered
from sparsurf.recovery.readings import RECOVERED
from sparsurf.report.figures import render
from sparsurf.report.numbers import enough_dots
from sparsurf.report.viewer.page import MAX_DOTS, Values
from sparsurf.report.viewer.page import page as viewer_page
from sparsurf.sampling.samplers import farthest
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.tables import read_minimal, read_roughness, read_table
from sparsurf.surfaces.components import COMPONENT_FIELD, fields_without_component
from sparsurf.surfaces.formats.npz import read_npz, with_fields
from sparsurf.surfaces.formats.ply import viridis
from sparsurf.workflow.jobs import job

PICTURE_PIXELS = 180, 240  # rows and columns
SCALE_BAR, MARGIN = 10, 6  # Å, and pixels from the corner


def main(
    surface: str,
    roughness: str,
    minimal: str,
    fields: str,
    structure: str | None,
    grid: str | None,
    best: str | None,
    required_dots: str,
    page: str,
    picture: str,
    settings: Settings,
    seed: int,
    name: str,
    title: str,
    threads: int = 1,
) -> None:
    """Write view.html and a small picture of it.

    Parameters
    ----------
    structure : names the residues of the dots; None for a ready surface
    grid, best : results of the sampling; None where it was left out
    name : protein/conformation
    title : its name on the page
    """
    dots = with_fields(read_npz(surface), fields)
    rough = read_roughness(roughness, dots)
    streams = Streams(seed, name, shared=True)
    prepared = PreparedSurface(dots, settings, rough, streams)
    results = json.loads(Path(best).read_text(encoding="utf-8")) if best else None
    # the random stream of minimal.csv, so that both have the same dots where that is farthest-point sampling
    order = farthest(prepared, min(len(dots), MAX_DOTS), streams("minimal", "farthest"))
    subset = read_minimal(minimal, dots)
    points, normals = subset[["x", "y", "z"]].to_numpy(), subset[["nx", "ny", "nz"]].to_numpy()
    distance = distance_to_recovered(dots.points, points, normals, threads)
    shown = [
        Values("distance from the surface recovered from minimal.csv", "off", " Å", distance, "on it", "off")
    ]
    components = dots.fields.get(COMPONENT_FIELD)
    if components is not None and components.max() > 0:
        shown.append(Values("component of the surface", "component", "", components, "largest", "smallest"))
    for field, numbers in fields_without_component(dots).items():
        words, unit = FIELDS[field][1:] if field in FIELDS else (field.replace("_", " "), "")
        shown.append(Values(words, field, f" {unit}".rstrip(), numbers))
    text = viewer_page(
        title,
        dots,
        rough,
        prepared.cover,
        settings.patches.R_patch,
        {"farthest": order},
        read_table(grid, results["combinations"], "combinations") if grid and results else None,
        results,
        residue_labels(structure),
        shown,
        subset["dot"].tolist() if "dot" in subset else [],
        turn=render.along_smallest_axis(dots.points),
        says=_enough(read_table(required_dots), settings.minimal.floor),
    )
    Path(page).write_text(text, encoding="utf-8")
    camera = render.aim(dots.points, render.along_smallest_axis(dots.points), PICTURE_PIXELS)
    # two values more, so that the colours have the same range on every surface
    colours = viridis(np.append(rough.clip(*render.ROUGHNESS_LIMITS), render.ROUGHNESS_LIMITS))[:-2] / 255
    scene = render.draw_surface(dots.points, dots.normals, colours, camera)
    image = render.picture(scene)
    left, bottom, length = MARGIN, image.shape[0] - MARGIN, round(SCALE_BAR * camera.scale)
    image[bottom - 2 : bottom, left : left + length] = 0
    Image.fromarray(image).save(picture)


def _enough(required_dots: pd.DataFrame, floor: str | None) -> str:
    """Say how many dots are enough; empty if no floor sets the size of the minimal subset."""
    rows = required_dots[(required_dots["floor"] == floor) & (required_dots["reading"] == RECOVERED)]
    if rows.empty:
        return ""
    row = rows.iloc[0]
    return enough_dots(row["n_S_percent"], row["n_S_percent_low"], row["n_S_percent_high"], row["bound"])


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            minimal=snakemake.input.minimal,
            fields=snakemake.input.fields,
            structure=snakemake.input.structure or None,
            grid=snakemake.input.grid or None,
            best=snakemake.input.best or None,
            required_dots=snakemake.input.required_dots,
            page=snakemake.output.page,
            picture=snakemake.output.picture,
            settings=Settings.of(snakemake.params),
            seed=snakemake.params.seed,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            title=snakemake.params.title,
            threads=snakemake.threads,
        )
