"""Tabulate the propensity by residue, and write both structures with it in the column of the B factor."""

from pathlib import Path

from sparsurf_study.workflow.jobs import job
from sparsurf_study.analysis.tables import read_residues
from sparsurf_study.pairs.matching import by_residue, on_atoms
from sparsurf_study.report.scenes import script_text
from sparsurf_study.structures import read_study_structure

COLOUR_QUANTILES = [0.05, 0.95]  # over the residues: both ends of the colour scale
B_FACTOR_OF_BURIED = -1.0  # The B factor of residues without dots.

with job(snakemake) as s:
    residues = by_residue(read_residues(s.input.dots))
    residues.to_csv(s.output.residues, index=False, float_format="%.6g")
    for side in (1, 2):
        molecule = read_study_structure(s.input[f"structure_{side}"])
        of_side = residues[residues["partner"] == side]
        b_factor = on_atoms(molecule, of_side, "propensity_smoothed", B_FACTOR_OF_BURIED)
        molecule.write_pdb(s.output[f"pdb_{side}"], b_factor=b_factor)
    for script in (s.output.pml, s.output.cxc):
        limits = residues["propensity_smoothed"].quantile(COLOUR_QUANTILES).tolist()
        text = script_text(f"open_pair{Path(script).suffix}", limits)
        Path(script).write_text(text, encoding="utf-8")
