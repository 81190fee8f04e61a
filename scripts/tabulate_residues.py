"""The surface residue by residue, and the structure with the mean R_i of its residues for other programs to colour."""

import numpy as np
import pandas as pd

from sparsurf.molecules.mmcif import write_mmcif
from sparsurf.molecules.reading import read_molecule
from sparsurf.study.residues import residue_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run

BURIED = -1.0  # in the B-factor column, of residues without dots


def main(inputs, outputs, name):
    """Write residues.csv, structure_roughness.pdb and structure_roughness.cif."""
    surface = read_npz(inputs["surface"])
    rough = pd.read_csv(inputs["roughness"])["roughness"].to_numpy()
    molecule = read_molecule(inputs["structure"], selection="all", whole=False)
    minimal = pd.read_csv(inputs["minimal"])
    table = residue_table(surface, rough, molecule, minimal["dot"], minimal["weight"])
    table.to_csv(outputs["table"], index=False)
    shown = np.nan_to_num(table["mean_roughness"].to_numpy(), nan=BURIED)[molecule.residue_index]
    molecule.write_pdb(outputs["pdb"], b_factor=shown)
    write_mmcif(outputs["cif"], name, molecule.xyz[0], molecule, shown)


if __name__ == "__main__":
    run(main, snakemake)
