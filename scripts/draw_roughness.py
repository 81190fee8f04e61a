"""Draw what shows a surface first, without the grid: the figure of its roughness, and the page with roughness and residues."""

from dataclasses import replace
from pathlib import Path

from sparsurf_study.workflow.jobs import job
from sparsurf.api.about import About
from sparsurf.api.pages import page_of_surface
from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.surface import SurfaceOrigin
from sparsurf.views import layout
from sparsurf_study.analysis.tables import read_roughness
from sparsurf_study.report import pictures
from sparsurf_study.report.figures.roughness import figure

LINKS = ("view.html", "Sample its dots"), ("../../index.html", "All of this run")

with job(snakemake) as s:
    dots = read_npz(s.input.surface)
    roughness = read_roughness(s.input.roughness, dots)
    drawn = figure(dots.points, dots.normals, roughness, s.place)
    for path in (s.output.svg, s.output.png):
        layout.save(drawn, path)
    pictures.draw_roughness_picture(s.output.picture, dots, roughness)
    settings = s.settings
    if s.input.structure:
        molecule = read_study_structure(s.input.structure)
        atoms = (
            molecule.xyz[0],
            settings.surface,
            settings.patches.d_link,
            radii(molecule, settings.surface.radii),
        )
        dots = replace(dots, origin=SurfaceOrigin.of_atoms(molecule, 0, *atoms))
    about = About(
        s.params.title, patches=settings.patches, roughness=roughness, is_whole=True, links=LINKS,
        files=(s.input.structure or s.input.surface,), is_dated=False,
    )  # fmt: skip
    Path(s.output.page).write_text(page_of_surface(dots, about), encoding="utf-8")
