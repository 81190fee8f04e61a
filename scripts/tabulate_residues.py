"""Tabulate a surface residue by residue, and write the structure with the mean R_i of its residues for other programs."""

from pathlib import Path

import numpy as np

from sparsurf_study.workflow.jobs import job
from sparsurf.api.scenes import write_bild
from sparsurf.evaluation.residues import residue_table
from sparsurf.surfaces.components import stored_components
from sparsurf.surfaces.formats.npz import read_npz, with_fields_of_file
from sparsurf.surfaces.molecular_surface import roll_frame
from sparsurf.surfaces.radii import radii
from sparsurf_study.analysis.tables import read_minimal, read_roughness
from sparsurf_study.report.scenes import script_text
from sparsurf_study.rounding import write_rounded
from sparsurf_study.structures import read_study_structure

BURIED = -1.0  # The B factor of residues without dots outside of cavities.

with job(snakemake) as s:
    dots = with_fields_of_file(read_npz(s.input.surface), s.input.fields or None)
    molecule, subset = read_study_structure(s.input.structure), read_minimal(s.input.minimal, dots)
    kept = subset["dot"].to_numpy(), subset["weight"].to_numpy()
    roughness = read_roughness(s.input.roughness, dots)
    rules, areas = s.settings.surface, None
    if rules.reentrant == "exact":
        areas = roll_frame(molecule.xyz[0], radii(molecule, rules.radii), rules).areas_by_kind(
            molecule.n_atoms
        )
    residues = residue_table(dots, roughness, molecule, *kept, stored_components(dots), areas=areas)
    write_rounded(s.output.table, residues)
    b_factor = np.nan_to_num(residues["mean_roughness"].to_numpy(), nan=BURIED)[molecule.residue_index]
    molecule.write_pdb(s.output.pdb, b_factor=b_factor)
    for path in (s.output.pml, s.output.cxc):
        Path(path).write_text(script_text(Path(path).name), encoding="utf-8")
    write_bild(s.output.bild, subset[["x", "y", "z"]].to_numpy())
