"""Draw what shows a surface first, without the grid: the figure of its roughness, and the page with roughness and residues."""

from pathlib import Path

from sparsurf_study.workflow.jobs import job
from sparsurf.api.page_metadata import About
from sparsurf.api.pages import page_of_surface
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.views import layout
from sparsurf_study.analysis.tables import read_roughness
from sparsurf_study.report import pictures
from sparsurf_study.report.figures.roughness import figure
from sparsurf_study.report.page_origin import with_atoms

LINKS = ("view.html", "Sample its dots"), ("../../index.html", "All of this run")

with job(snakemake) as s:
    dots = read_npz(s.input.surface)
    roughness = read_roughness(s.input.roughness, dots)
    drawn = figure(dots.points, dots.normals, roughness, s.place)
    for path in (s.output.svg, s.output.png):
        layout.save(drawn, path)
    pictures.draw_roughness_picture(s.output.picture, dots, roughness)
    settings = s.settings
    dots = with_atoms(dots, s.input.structure, settings)
    about = About(
        s.params.title, patches=settings.patches, roughness=roughness, is_whole=True, links=LINKS,
        files=(s.input.structure or s.input.surface,), is_dated=False,
    )  # fmt: skip
    Path(s.output.page).write_text(page_of_surface(dots, about), encoding="utf-8")
