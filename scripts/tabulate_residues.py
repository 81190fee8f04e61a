"""Tabulate a surface residue by residue, and write the structure with the mean R_i of its residues for other programs."""

from pathlib import Path

import numpy as np

from sparsurf.api.scenes import write_bild
from sparsurf.molecules.mmcif import write_mmcif
from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.report import viewer
from sparsurf.rounding import write_table
from sparsurf.study.residues import residue_table
from sparsurf.study.tables import read_minimal, read_roughness
from sparsurf.surfaces.components import stored_components
from sparsurf.surfaces.formats.npz import read_npz, with_fields
from sparsurf.workflow.jobs import job

VIEWER = Path(viewer.__file__).parent
BURIED = -1.0  # B factor of residues without dots outside of cavities


def main(
    surface: str,
    roughness: str,
    minimal: str,
    fields: str,
    structure: str,
    table: str,
    pdb: str,
    cif: str,
    pml: str,
    cxc: str,
    bild: str,
    name: str,
) -> None:
    """Write residues.csv, the structure with roughness as B factor, and the files that open it in PyMOL and ChimeraX."""
    dots = with_fields(read_npz(surface), fields)
    molecule, subset = read_study_structure(structure), read_minimal(minimal, dots)
    residues = residue_table(
        dots,
        read_roughness(roughness, dots),
        molecule,
        subset["dot"].to_numpy(),
        subset["weight"].to_numpy(),
        stored_components(dots),
    )
    write_table(table, residues)
    b_factor = np.nan_to_num(residues["mean_roughness"].to_numpy(), nan=BURIED)[molecule.residue_index]
    molecule.write_pdb(pdb, b_factor=b_factor)
    write_mmcif(cif, name, molecule.xyz[0], molecule, b_factor)
    Path(pml).write_text((VIEWER / "open.pml").read_text(encoding="utf-8"), encoding="utf-8")
    Path(cxc).write_text((VIEWER / "open.cxc").read_text(encoding="utf-8"), encoding="utf-8")
    write_bild(bild, subset[["x", "y", "z"]].to_numpy())


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            minimal=snakemake.input.minimal,
            fields=snakemake.input.fields,
            structure=snakemake.input.structure,
            table=snakemake.output.table,
            pdb=snakemake.output.pdb,
            cif=snakemake.output.cif,
            pml=snakemake.output.pml,
            cxc=snakemake.output.cxc,
            bild=snakemake.output.bild,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
        )
