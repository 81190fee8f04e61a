"""Compute the molecular surface of one conformation, and its components."""

import shutil
from dataclasses import replace
from pathlib import Path

from sparsurf_study.workflow.jobs import job
from sparsurf.surfaces.components import COMPONENT_FIELD, table_of_components
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.molecular_surface import surface_of_molecule
from sparsurf.surfaces.surface_atoms import atoms_of_dots
from sparsurf_study.structures import read_study_structure

with job(snakemake) as s:
    path = Path(s.input.structures, f"{s.wildcards.conformation}.pdb")
    dots = surface_of_molecule(read_study_structure(path), s.settings.surface, s.params.d_link, s.place)
    component = dots.known_components(s.place)
    table_of_components(dots).to_csv(s.output.components, index=False, float_format="%.2f")
    atoms_of_dots(dots).to_frame().to_csv(s.output.surface_atoms, index=False)
    write_npz(s.output.surface, replace(dots, fields={COMPONENT_FIELD: component}))
    shutil.copyfile(path, s.output.structure)
