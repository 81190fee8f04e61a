"""Partial charges of atoms: from a built-in table, from pdb2pqr, or from a PQR file.

charges.csv holds PARSE (Sitkoff, Sharp & Honig, J. Phys. Chem. 98:1978, 1994; RNA: Tang et al., J. Mol. Biol. 366:1475,
2007), and AMBER ff99 for DNA, which PARSE lacks. Most structures have no hydrogens, so a row has the charge of a
heavy atom, the sum of those of its hydrogens, and their number; hydrogens that a file lacks are built.
"""

import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from sparsurf import InputError
from sparsurf.files import read_text
from sparsurf.molecules.residues import VARIANTS, standard_name
from sparsurf.molecules.selection import log

BOND = 2.0  # Å, longest between two heavy atoms of a molecule
BOND_TO_H = 1.4  # Å, longest to a hydrogen
LENGTH = 1.0  # Å, of a bond to a hydrogen that is built
# Degrees about the bond, of hydrogens of an atom with one neighbour; that of a hydroxyl turns, and is spread over a ring
TURNS = {1: (0, 60, 120, 180, 240, 300), 2: (0, 180), 3: (60, 180, 300)}
DISULPHIDE = 2.5  # Å, between two SG
# What force fields call protonation states, by the name in the table
STATES = {
    "HIE": "HIE HSE HISE HISB", "HIP": "HIP HSP HISH HISP", "ASH": "ASH ASPH ASPP", "GLH": "GLH GLUH GLUP",
    "LYN": "LYN LSN LYSN", "CYX": "CYX", "CYM": "CYM", "ARN": "ARN ARGN", "TYM": "TYM",
}  # fmt: skip
STATE_OF = {variant: state for state, variants in STATES.items() for variant in variants.split()}
N_TERMINUS = {"N": (-0.32, 0.99, 3), "CA": (0.33, 0.0, 0.0)}  # PARSE, BK+
C_TERMINUS = {"C": (0.10, 0.0, 0.0), "O": (-0.55, 0.0, 0.0), "OXT": (-0.55, 0.0, 0.0)}  # PARSE, BK-
# Of a PQR file: e, charge that no atom has; e, median that radii have and charges have not; Å, between an atom and its own where
# a force field has relaxed it, and where it is another's
MOST, RADIUS, RELAXED, ELSEWHERE = 10, 0.5, 0.3, 1.0
OTHER_NAMES = {"OT1": "O", "OT2": "OXT", "O1P": "OP1", "O2P": "OP2", "C5M": "C7"}


def table_charges(molecule):
    """Places and charges of a molecule's first frame by the built-in table.

    Parameters
    ----------
    molecule : Molecule, with or without hydrogens

    Returns
    -------
    (Q, 3) float64, Å, and (Q,) float64, elementary charges: heavy atoms and polar hydrogens.
    Residues that the table does not have are neutral, with a warning.
    """
    xyz, heavy = molecule.xyz[0], ~np.isin(molecule.element, ["H", "D"])
    rows = _rows(molecule, heavy)
    found = rows[:, 0] != 0
    places, atom = _hydrogens(xyz, heavy, np.flatnonzero(rows[:, 1] != 0), rows[:, 2])
    shared = rows[atom, 1] / np.bincount(atom, minlength=1)[atom]
    return np.concatenate([xyz[found], places]), np.concatenate([rows[found, 0], shared])


@cache
def _table():
    """(residue, atom) -> charge, charge of its hydrogens, their number."""
    table = pd.read_csv(Path(__file__).with_name("charges.csv"), keep_default_na=False)
    keys, values = table[["residue", "atom"]], table[["charge", "hydrogens", "number"]]
    return dict(zip(keys.itertuples(index=False, name=None), map(tuple, values.to_numpy(float)), strict=True))


def _rows(molecule, heavy):
    """(A, 3): the row of the table of each atom; zeros for hydrogens and for what the table does not have."""
    table, out = _table(), np.zeros((molecule.n_atoms, 3))
    known = {residue for residue, _ in table} | {"ALA", "GLY", "ILE", "LEU", "VAL", "MSE"}
    states, unknown = _states(molecule), set()
    first, last = _ends(molecule)
    for i in np.flatnonzero(heavy):
        state, atom = states[molecule.residue_index[i]], OTHER_NAMES.get(molecule.name[i], molecule.name[i])
        end = N_TERMINUS if molecule.residue_index[i] in first else {}
        end = end | C_TERMINUS if molecule.residue_index[i] in last else end
        row = end.get(atom) or table.get((state, atom))
        if row is None and molecule.kind[i] == "protein":
            row = table.get(("backbone", atom))
        if row is not None:
            out[i] = row
        if state not in known and molecule.kind[i] != "water":
            unknown.add(state)
    if unknown:
        log.warning(
            "potential: %s have no charges in the table and count as neutral", ", ".join(sorted(unknown))
        )
    return out


def _states(molecule):
    """Name in the table of each residue: its protonation state, by name, hydrogens and disulphide bonds."""
    n = molecule.n_residues
    first = np.unique(molecule.residue_index, return_index=True)[1]
    names = [str(name) for name in molecule.residue_name[first]]
    own = [name if name not in VARIANTS else STATE_OF.get(name[-3:], STATE_OF.get(name)) for name in names]
    states = [state or standard_name(name) for state, name in zip(own, names, strict=True)]
    has = {name: set(molecule.residue_index[molecule.name == name].tolist()) for name in ("HD1", "HE2")}
    bridged = _bridged(molecule)
    for k in range(n):
        if states[k] == "HIS" and k in has["HE2"]:
            states[k] = "HIP" if k in has["HD1"] else "HIE"
        if states[k] == "CYS" and k in bridged:
            states[k] = "CYX"
    return states


def _bridged(molecule):
    """Residues whose SG is bonded to another SG."""
    sulphur = np.flatnonzero(molecule.name == "SG")
    if len(sulphur) < 2:
        return set()
    pairs = cKDTree(molecule.xyz[0, sulphur]).query_pairs(DISULPHIDE)
    return {int(molecule.residue_index[sulphur[k]]) for pair in pairs for k in pair}


def _ends(molecule):
    """Residues with a charged amino end, and with a charged carboxyl end: the first and the last protein residue
    of each chain, if no cap follows."""
    protein = np.flatnonzero(molecule.kind == "protein")
    first, last = set(), set()
    for chain in dict.fromkeys(molecule.chain[protein].tolist()):
        own = protein[molecule.chain[protein] == chain]
        first.add(int(molecule.residue_index[own[0]]))
        last.add(int(molecule.residue_index[own[-1]]))
    return first, last


def _hydrogens(xyz, heavy, atoms, number):
    """Places (H, 3) of the polar hydrogens of some heavy atoms, and the atom of each: those in the file, else built."""
    own = (
        cKDTree(xyz[~heavy]).query_ball_point(xyz[atoms], BOND_TO_H) if (~heavy).any() else [[]] * len(atoms)
    )
    others = xyz[heavy]
    tree = cKDTree(others)
    near = [np.array(each, int) for each in tree.query_ball_point(xyz[atoms], BOND)]
    places, of_atom = [], []
    for atom, there, neighbours in zip(atoms, own, near, strict=True):
        arms = others[neighbours]
        arms = arms[np.linalg.norm(arms - xyz[atom], axis=1) > 0.1]
        built = xyz[~heavy][there] if len(there) else _built(xyz[atom], arms, int(number[atom]), tree)
        places.extend(built)
        of_atom.extend([atom] * len(built))
    return np.array(places).reshape(-1, 3), np.array(of_atom, int)


def _built(atom, arms, number, tree):
    """Places of `number` hydrogens of an atom: opposite to two or more bonded neighbours, else around the only one."""
    if len(arms) != 1:
        away = -sum(((arm - atom) / np.linalg.norm(arm - atom) for arm in arms), np.zeros(3))
        return [atom + LENGTH * away / max(np.linalg.norm(away), 1e-9)] * number
    axis = (atom - arms[0]) / np.linalg.norm(atom - arms[0])
    beyond = tree.data[tree.query_ball_point(arms[0], BOND)]
    beyond = beyond[
        (np.linalg.norm(beyond - arms[0], axis=1) > 0.1) & (np.linalg.norm(beyond - atom, axis=1) > 0.1)
    ]
    side = (beyond[0] if len(beyond) else arms[0] + axis[[1, 2, 0]]) - arms[0]
    side = side - (side @ axis) * axis
    side = side / max(np.linalg.norm(side), 1e-9)
    up, turns = np.cross(axis, side), TURNS[number]
    bend = np.deg2rad(60.0 if number == 2 else 70.5)  # of a planar and of a tetrahedral atom
    return [
        atom + LENGTH * (np.cos(bend) * axis + np.sin(bend) * (np.cos(turn) * side + np.sin(turn) * up))
        for turn in np.deg2rad(turns)
    ]


def pqr_charges(path, molecule=None):
    """Places (Q, 3), Å, and charges (Q,) of a PQR file, whose last two columns are charge and radius.

    Raises
    ------
    InputError : no atoms, a line without five numbers or with what no atom has, or none of the atoms of the Molecule
    """
    rows = []
    for number, line in enumerate(read_text(path).split("\n"), 1):
        if not line.startswith(("ATOM", "HETATM")):
            continue
        try:
            x, y, z, charge, _ = map(float, line.split()[-5:])
        except ValueError:
            raise InputError(
                f"{path}, line {number}: a PQR line ends in x, y, z, charge and radius."
            ) from None
        if not (np.isfinite((x, y, z)).all() and abs(charge) <= MOST):
            raise InputError(f"{path}, line {number}: no atom has such a place or charge; repair it.")
        rows.append((x, y, z, charge))
    if not rows:
        raise InputError(f"{path} holds no atoms: give a PQR file, as pdb2pqr writes it.")
    table = np.array(rows)
    places, charges = table[:, :3].copy(), table[:, 3].copy()
    if np.median(charges) > RADIUS:
        raise InputError(f"{path}: half of its charges are above {RADIUS} e; exchange charge and radius.")
    heavy = [] if molecule is None else molecule.xyz[0, ~np.isin(molecule.element, ["H", "D"])]
    gap = np.median(cKDTree(places).query(heavy)[0]) if len(heavy) else 0
    if gap > ELSEWHERE:
        raise InputError(
            f"{path}: its atoms lie {gap:.1f} Å from those of the molecule; give charges of this structure, in Å."
        )
    if gap > RELAXED:
        log.warning(
            "%s: its atoms lie %.1f Å from those of the molecule, as those of another frame may", path, gap
        )
    return places, charges


def pdb2pqr_charges(molecule):
    """Places and charges by the program pdb2pqr (hydrogens added and turned, PARSE), where it is on the PATH.

    Raises
    ------
    InputError : it is not there, or fails
    """
    program = shutil.which("pdb2pqr")
    if program is None:
        raise InputError("charges: pdb2pqr is not on the PATH; install it, or take the built-in table.")
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
            raise InputError(f"charges: pdb2pqr failed ({reason}); take the built-in table.")
        return pqr_charges(result)
