"""The propensity by residue: a table, and both structures with it in the column of the B factor."""

import pandas as pd

from sparsurf.pairs.matching import by_residue, on_atoms
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import SIDES, structure_of

BURIED = -1.0  # in the B-factor column, of residues without dots


def main(inputs, outputs):
    """Write residues.csv and a PDB file of each partner."""
    dots = pd.read_csv(
        inputs["dots"], dtype={"chain": str, "residue": str}, keep_default_na=False, na_values=[""]
    )
    tables = []
    for side in SIDES:
        table = by_residue(dots[dots["partner"] == int(side)].fillna({"chain": ""}))
        table.insert(0, "partner", int(side))
        tables.append(table)
        molecule = structure_of(inputs, side)
        molecule.write_pdb(
            outputs[f"pdb_{side}"], b_factor=on_atoms(molecule, table, "propensity_smoothed", BURIED)
        )
    pd.concat(tables).to_csv(outputs["residues"], index=False, float_format="%.6g")


if __name__ == "__main__":
    run(main, snakemake)
