"""The surface residue by residue, and the structure with the mean R_i of its residues for other programs to colour."""

from pathlib import Path

import numpy as np

from sparsurf.molecules.mmcif import write_mmcif
from sparsurf.molecules.read_molecule import read_own
from sparsurf.report import viewer
from sparsurf.study.residues import residue_table
from sparsurf.study.tables import read_minimal, read_roughness
from sparsurf.surfaces.formats.npz import read_npz, with_fields
from sparsurf.workflow.jobs import run

VIEWER = Path(viewer.__file__).parent
OPENERS = {"pml": VIEWER / "open.pml", "cxc": VIEWER / "open.cxc"}
BURIED = -1.0  # in the B-factor column, of residues without dots


def main(inputs, outputs, name):
    """Write residues.csv, the structure with roughness as PDB and mmCIF, and what opens it in PyMOL and ChimeraX."""
    surface = with_fields(read_npz(inputs["surface"]), inputs.get("fields"))
    rough = read_roughness(inputs["roughness"], surface)
    molecule = read_own(inputs["structure"])
    minimal = read_minimal(inputs["minimal"], surface)
    table = residue_table(surface, rough, molecule, minimal["dot"], minimal["weight"])
    table.to_csv(outputs["table"], index=False)
    shown = np.nan_to_num(table["mean_roughness"].to_numpy(), nan=BURIED)[molecule.residue_index]
    molecule.write_pdb(outputs["pdb"], b_factor=shown)
    write_mmcif(outputs["cif"], name, molecule.xyz[0], molecule, shown)
    for key, path in OPENERS.items():
        Path(outputs[key]).write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
    spheres = [".sphere {:.3f} {:.3f} {:.3f} 0.3".format(*dot) for dot in minimal[["x", "y", "z"]].to_numpy()]
    Path(outputs["bild"]).write_text("\n".join([".color 0.84 0.37 0", *spheres, ""]), encoding="ascii")


if __name__ == "__main__":
    run(main, snakemake)
