"""Partial charges of atoms: from a built-in table, from pdb2pqr, or from a PQR file.

charges.csv holds PARSE (Sitkoff, Sharp & Honig, J. Phys. Chem. 98:1978, 1994; RNA: Tang et al., J. Mol. Biol. 366:1475,
2007), and AMBER ff99 for DNA, which PARSE lacks. Most structures have no hydrogens. A row therefore has the charge of a
heavy atom, the total charge of its hydrogens, and their number. Hydrogens that a file lacks are built.
"""

from __future__ import annotations

import logging
import os
import shutil
import subprocess
import tempfile
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import FILE, InputError, naming_file
from sparsurf.files import read_text
from sparsurf.molecules.names import usual_name
from sparsurf.molecules.pqr import read_pqr
from sparsurf.molecules.residues import VARIANTS, first_atoms, standard_name
from sparsurf.surfaces.grid import pairs_within

if TYPE_CHECKING:
    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

MAX_HEAVY_BOND = 2.0  # Å, between two heavy atoms
MAX_BOND_TO_HYDROGEN = 1.4  # Å
HYDROGEN_BOND_LENGTH = 1.0  # Å, of a bond to a hydrogen that is built
# Degrees about the bond of an atom with one neighbour, by the number of its hydrogens. The hydrogen of a hydroxyl turns
# freely, so that its charge is spread over a ring.
DIHEDRALS = {1: (0, 60, 120, 180, 240, 300), 2: (0, 180), 3: (60, 180, 300)}
MAX_DISULPHIDE_BOND = 2.5  # Å, between two SG
# Names that force fields give to protonation states, by the name in the table
STATES = {
    "HIE": "HIE HSE HISE HISB", "HIP": "HIP HSP HISH HISP", "ASH": "ASH ASPH ASPP", "GLH": "GLH GLUH GLUP",
    "LYN": "LYN LSN LYSN", "CYX": "CYX", "CYM": "CYM", "ARN": "ARN ARGN", "TYM": "TYM",
}  # fmt: skip
STATE_OF = {variant: state for state, variants in STATES.items() for variant in variants.split()}
N_TERMINUS = {"N": (-0.32, 0.99, 3), "CA": (0.33, 0.0, 0.0)}  # PARSE, BK+
C_TERMINUS = {"C": (0.10, 0.0, 0.0), "O": (-0.55, 0.0, 0.0), "OXT": (-0.55, 0.0, 0.0)}  # PARSE, BK-
SHIFT_TO_WARN = 0.3  # Å; a force field may have relaxed the atoms, or they are of another frame
SHIFT_TO_REFUSE = 1.0  # Å; they are of another structure


def table_charges(molecule: Molecule) -> tuple[np.ndarray, np.ndarray]:
    """Look up charges, neutral if unknown: positions (Q, 3), Å, of heavy atoms and polar hydrogens, and charges (Q,), e."""
    xyz, heavy = molecule.xyz[0], molecule.heavy
    rows = _table_rows(molecule, heavy)
    charged = rows[:, 0] != 0
    hydrogens, atom = _polar_hydrogens(xyz, heavy, np.flatnonzero(rows[:, 1] != 0), rows[:, 2])
    hydrogen_charges = rows[atom, 1] / np.bincount(atom, minlength=1)[atom]
    return np.concatenate([xyz[charged], hydrogens]), np.concatenate([rows[charged, 0], hydrogen_charges])


@cache
def _table() -> dict[tuple[str, str], tuple[float, ...]]:
    """Read the table: (residue, atom) -> charge, total charge of its hydrogens, their number."""
    import pandas as pd

    table = pd.read_csv(Path(__file__).with_name("charges.csv"), keep_default_na=False)
    keys, values = table[["residue", "atom"]], table[["charge", "hydrogens", "number"]]
    return dict(zip(keys.itertuples(index=False, name=None), map(tuple, values.to_numpy(float)), strict=True))


def _table_rows(molecule: Molecule, heavy: np.ndarray) -> np.ndarray:
    """Return the row of the table of each atom, (A, 3); zeros for hydrogens and atoms that the table lacks."""
    table, out = _table(), np.zeros((molecule.n_atoms, 3))
    listed_residues = {residue for residue, _ in table} | {"ALA", "GLY", "ILE", "LEU", "VAL", "MSE"}
    states, unknown = protonation_states(molecule), set()
    n_termini, c_termini = _chain_ends(molecule)
    for i in np.flatnonzero(heavy):
        residue, atom = (
            molecule.residue_index[i],
            usual_name(str(molecule.residue_name[i]), str(molecule.name[i])),
        )
        state = states[residue]
        terminus = N_TERMINUS if residue in n_termini else {}
        terminus = terminus | C_TERMINUS if residue in c_termini else terminus
        row = terminus.get(atom) or table.get((state, atom))
        if row is None and molecule.kind[i] == "protein":
            row = table.get(("backbone", atom))
        if row is not None:
            out[i] = row
        if state not in listed_residues and molecule.kind[i] != "water":
            unknown.add(state)
    if unknown:
        names = ", ".join(sorted(unknown))
        log.warning("potential: %s have no charges in the table and count as neutral", names)
    return out


def protonation_states(molecule: Molecule) -> list[str]:
    """Return the name in the table of each residue, by its name, its hydrogens and disulphide bonds."""
    first_atom = first_atoms(molecule.residue_index)
    names = [str(name) for name in molecule.residue_name[first_atom]]
    states = [_state_of_name(name) or standard_name(name) for name in names]
    with_hydrogen = {
        name: set(molecule.residue_index[molecule.name == name].tolist()) for name in ("HD1", "HE2")
    }
    bridged = _disulphide_residues(molecule)
    for residue, state in enumerate(states):
        if state == "HIS" and residue in with_hydrogen["HE2"]:
            states[residue] = "HIP" if residue in with_hydrogen["HD1"] else "HIE"
        if state == "CYS" and residue in bridged:
            states[residue] = "CYX"
    return states


def _state_of_name(name: str) -> str | None:
    """Return the protonation state that a residue's name says; None if it says the standard one."""
    return STATE_OF.get(name[-3:], STATE_OF.get(name)) if name in VARIANTS else name


def _disulphide_residues(molecule: Molecule) -> set[int]:
    """Find the residues whose SG is bonded to another SG."""
    sulphur = np.flatnonzero(molecule.name == "SG")
    if len(sulphur) < 2:
        return set()
    xyz = molecule.xyz[0, sulphur]
    first, second = pairs_within(xyz, xyz, MAX_DISULPHIDE_BOND)
    return set(molecule.residue_index[sulphur[first[first != second]]].tolist())


def _chain_ends(molecule: Molecule) -> tuple[set[int], set[int]]:
    """Find the residues with charged amino and carboxyl ends: the first and last protein residue of each chain."""
    protein = np.flatnonzero(molecule.kind == "protein")
    first, last = set(), set()
    for chain in dict.fromkeys(molecule.chain[protein].tolist()):
        atoms = protein[molecule.chain[protein] == chain]
        first.add(int(molecule.residue_index[atoms[0]]))
        last.add(int(molecule.residue_index[atoms[-1]]))
    return first, last


def _polar_hydrogens(
    xyz: np.ndarray, heavy: np.ndarray, atoms: np.ndarray, n_hydrogens: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (H, 3) of the polar hydrogens of heavy atoms, and the atom of each; from the file, else built."""
    hydrogens, heavy_xyz = xyz[~heavy], xyz[heavy]
    bonded = _lists_within(hydrogens, xyz[atoms], MAX_BOND_TO_HYDROGEN)
    near, place = _lists_within(heavy_xyz, heavy_xyz, MAX_HEAVY_BOND), np.cumsum(heavy) - 1
    positions, owner = [], []
    for atom, in_file in zip(atoms, bonded, strict=True):
        arms = _apart(heavy_xyz, near[place[atom]], xyz[atom])
        if len(in_file):
            added = list(hydrogens[in_file])
        else:
            beyond = _apart(heavy_xyz, near[arms[0]], xyz[atom]) if len(arms) == 1 else arms
            added = _build_hydrogens(xyz[atom], heavy_xyz[arms], heavy_xyz[beyond], int(n_hydrogens[atom]))
        positions.extend(added)
        owner.extend([atom] * len(added))
    return np.array(positions).reshape(-1, 3), np.array(owner, int)


def _lists_within(points: np.ndarray, positions: np.ndarray, distance: float) -> list[np.ndarray]:
    """Return the points within a distance, Å, of each position, by index."""
    position, point = pairs_within(points, positions, distance)
    ends = np.searchsorted(position, np.arange(len(positions) + 1))
    return [point[start:end] for start, end in pairwise(ends)]


def _apart(xyz: np.ndarray, atoms: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the atoms that do not lie in a place."""
    return atoms[np.linalg.norm(xyz[atoms] - place, axis=1) > 0.1]


def _build_hydrogens(atom: np.ndarray, arms: np.ndarray, beyond: np.ndarray, number: int) -> list[np.ndarray]:
    """Place `number` hydrogens of an atom: opposite to several bonded neighbours, or around its only one, from those beyond."""
    if len(arms) != 1:
        away = -sum(((arm - atom) / np.linalg.norm(arm - atom) for arm in arms), np.zeros(3))
        return [atom + HYDROGEN_BOND_LENGTH * away / max(float(np.linalg.norm(away)), 1e-9)] * number
    axis = (atom - arms[0]) / np.linalg.norm(atom - arms[0])
    beyond = beyond[np.linalg.norm(beyond - arms[0], axis=1) > 0.1]
    side = (beyond[0] if len(beyond) else arms[0] + axis[[1, 2, 0]]) - arms[0]
    side = side - (side @ axis) * axis
    side = side / max(float(np.linalg.norm(side)), 1e-9)
    up = np.cross(axis, side)
    bend = np.deg2rad(60.0 if number == 2 else 70.5)  # of a planar and of a tetrahedral atom
    return [
        atom
        + HYDROGEN_BOND_LENGTH
        * (np.cos(bend) * axis + np.sin(bend) * (np.cos(dihedral) * side + np.sin(dihedral) * up))
        for dihedral in np.deg2rad(DIHEDRALS[number])
    ]


def pqr_charges(
    path: str | os.PathLike[str], molecule: Molecule | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Read positions (Q, 3), Å, and charges (Q,), e, of a PQR file, at whose atoms the heavy atoms of the molecule must lie."""
    with naming_file(path):
        atoms = read_pqr(read_text(path))
        if molecule is not None:
            _check_positions(atoms.xyz, molecule)
    return atoms.xyz, atoms.charge


def _check_positions(positions: np.ndarray, molecule: Molecule) -> None:
    """Raise InputError if the charges lie far from the heavy atoms of the molecule; warn if they are moved a little."""
    heavy = molecule.xyz[0, molecule.heavy]
    from scipy.spatial import cKDTree

    shift = np.median(cKDTree(positions).query(heavy)[0]) if len(heavy) else 0
    if shift > SHIFT_TO_REFUSE:
        raise InputError(
            f"{FILE}: its atoms lie {shift:.1f} Å from those of the molecule; give charges of this structure, in Å."
        )
    if shift > SHIFT_TO_WARN:
        message = "%s: its atoms lie %.1f Å from those of the molecule, perhaps in another frame"
        log.warning(message, FILE, shift)


def pdb2pqr_charges(molecule: Molecule) -> tuple[np.ndarray, np.ndarray]:
    """Compute charges with pdb2pqr, which adds hydrogens and uses PARSE: positions (Q, 3), Å, and charges (Q,), e."""
    program = shutil.which("pdb2pqr")
    if program is None:
        raise InputError("charges: pdb2pqr is not on the PATH; install it, or use the built-in table.")
    with tempfile.TemporaryDirectory() as folder:
        structure, result = Path(folder, "molecule.pdb"), Path(folder, "molecule.pqr")
        molecule.write_pdb(structure)
        run = subprocess.run(
            [program, "--ff=PARSE", "--whitespace", structure, result],
            capture_output=True,
            text=True,
            check=False,
        )
        if run.returncode or not result.is_file():
            reason = (run.stderr.strip().splitlines() or ["no message"])[-1][:120]
            raise InputError(f"charges: pdb2pqr failed ({reason}); use the built-in table.")
        return pqr_charges(result)
