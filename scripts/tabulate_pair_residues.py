"""Tabulate the propensity by residue, and write both structures with it in the column of the B factor."""

from pathlib import Path

import pandas as pd

from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.pairs.matching import by_residue, on_atoms
from sparsurf.report import viewer
from sparsurf.workflow.jobs import job

COLOUR_QUANTILES = {"%LOW%": 0.05, "%HIGH%": 0.95}  # over the residues: both ends of the colour scale
B_FACTOR_OF_BURIED = -1.0  # of residues without dots


def main(
    structure_1: str,
    structure_2: str,
    dots: str,
    pdb_1: str,
    pdb_2: str,
    residues: str,
    pml: str,
    cxc: str,
) -> None:
    """Write residues.csv, a PDB file of each partner, and scripts that open both in PyMOL and ChimeraX."""
    text_columns = {"chain": str, "residue": str}
    dot_table = pd.read_csv(dots, dtype=text_columns, keep_default_na=False, na_values=[""])
    tables = []
    for side, structure, pdb in ((1, structure_1, pdb_1), (2, structure_2, pdb_2)):
        table = by_residue(dot_table[dot_table["partner"] == side].fillna({"chain": ""}))
        if table is None:
            continue
        table.insert(0, "partner", side)
        tables.append(table)
        molecule = read_study_structure(structure)
        b_factor = on_atoms(molecule, table, "propensity_smoothed", B_FACTOR_OF_BURIED)
        molecule.write_pdb(pdb, b_factor=b_factor)
    residue_table = pd.concat(tables)
    residue_table.to_csv(residues, index=False, float_format="%.6g")
    for script in (pml, cxc):
        template = Path(viewer.__file__).with_name(f"open_pair{Path(script).suffix}")
        text = template.read_text(encoding="utf-8")
        for mark, quantile in COLOUR_QUANTILES.items():
            text = text.replace(mark, f"{residue_table['propensity_smoothed'].quantile(quantile):.3f}")
        Path(script).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure_1=snakemake.input.structure_1,
            structure_2=snakemake.input.structure_2,
            dots=snakemake.input.dots,
            pdb_1=snakemake.output.pdb_1,
            pdb_2=snakemake.output.pdb_2,
            residues=snakemake.output.residues,
            pml=snakemake.output.pml,
            cxc=snakemake.output.cxc,
        )
