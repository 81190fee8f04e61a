"""The propensity by residue: a table, and both structures with it in the column of the B factor."""

from pathlib import Path

import pandas as pd

from sparsurf.pairs.matching import by_residue, on_atoms
from sparsurf.report import viewer
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import SIDES, structure_of

OPENERS = {end: Path(viewer.__file__).with_name(f"open_pair.{end}") for end in ("pml", "cxc")}
ENDS = {"%LOW%": 0.05, "%HIGH%": 0.95}  # of the colours: quantiles over the residues
BURIED = -1.0  # in the B-factor column, of residues without dots


def main(inputs, outputs):
    """Write residues.csv, a PDB file of each partner, and what opens both in PyMOL and ChimeraX."""
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
    table = pd.concat(tables)
    table.to_csv(outputs["residues"], index=False, float_format="%.6g")
    for end, path in OPENERS.items():
        text = path.read_text(encoding="utf-8")
        for mark, share in ENDS.items():
            text = text.replace(mark, f"{table['propensity_smoothed'].quantile(share):.3f}")
        Path(outputs[end]).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    run(main, snakemake)
