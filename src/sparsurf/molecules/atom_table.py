"""The atoms of a structure file as one table, whatever the format; what all formats have to go through.

The table has one row per atom in the order of the file:
model         int, number of the model
hetero        bool, not part of a polymer according to the file (HETATM)
name, residue_name, chain, element, altloc    str, empty where the file says nothing
residue       str, number with insertion code: '52A', '-5'
terminated    bool, the residue before was the last of its molecule (TER)
occupancy, x, y, z    float, Å
b_factor      float, Å^2, nan where the file says nothing
"""

import logging
from dataclasses import dataclass, field

import gemmi
import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.files import pluralise

log = logging.getLogger("sparsurf")

FLAT = 1e-6  # of its volume at right angles: a box has more


@dataclass(frozen=True)
class AtomFile:
    """What a structure file holds.

    Attributes
    ----------
    atoms : DataFrame, the table described above
    box : (3, 3) float, Å, lattice vectors as rows; None where there is none
    promised : dict, residue names of each chain's full sequence, where the file tells it
    linked : set of (chain, residue), those that a bond beside the backbone joins to another residue of the polymer
    """

    atoms: pd.DataFrame
    box: np.ndarray | None = None
    promised: dict = field(default_factory=dict)
    linked: frozenset = frozenset()


def box_vectors(a, b, c, alpha, beta, gamma):
    """Lattice vectors (3, 3) in Å from lengths (Å) and angles (degrees); None for a dummy box of 1 Å, and an impossible one."""
    try:
        cell = gemmi.UnitCell(a, b, c, alpha, beta, gamma)
        impossible = cell.is_crystal() and not cell.volume > FLAT * a * b * c
    except RuntimeError:  # an angle of 0 or 180 degrees
        impossible = True
    if impossible:
        edges, angles = (", ".join(f"{x:g}" for x in each) for each in ((a, b, c), (alpha, beta, gamma)))
        log.warning("a box of %s Å with angles of %s° is impossible: it counts as missing", edges, angles)
        return None
    return np.array(cell.orth.mat.tolist()).T if cell.is_crystal() and cell.volume > 1 else None


def number_residues(atoms):
    """(A,) int: residue of each atom, 0, 1, 2, ... in the order of the file, starting again in each model.

    A residue ends where chain, number or insertion code change, at TER, or where the name changes; not
    where the name changes between alternate locations of one residue.
    """
    before = atoms.shift()
    differs = (atoms[["model", "chain", "residue"]] != before[["model", "chain", "residue"]]).any(axis=1)
    alternates = (atoms.altloc != "") & (before.altloc != "")
    renamed = (atoms.residue_name != before.residue_name) & ~alternates
    number = (differs | renamed | atoms.terminated).cumsum()
    return (number - number.groupby(atoms.model).transform("min")).to_numpy()


def missing_residues(atoms, promised):
    """Chains that lack residues of their full sequence, in the first model.

    Returns
    -------
    dict : chain -> (number of residues found, number of residues promised)
    """
    residues = atoms[atoms.model == atoms.model[0]].drop_duplicates(["chain", "residue"])
    counts = {
        chain: (int((residues.residue_name[residues.chain == chain].isin(sequence)).sum()), len(sequence))
        for chain, sequence in promised.items()
    }
    return {chain: (found, full) for chain, (found, full) in counts.items() if found < full}


def choose_altlocs(atoms, altloc, path):
    """The table with one location of every atom.

    Each residue keeps one location throughout: the first in the file ('first'), the one of highest mean
    occupancy ('highest') or the given letter where the residue has it, else the first. An atom that only
    other locations of the same residue hold is kept too, so that no hole arises.
    """
    if altloc not in ("first", "highest") and not (isinstance(altloc, str) and len(altloc.strip()) == 1):
        raise InputError(f"altloc: '{altloc}' is neither first, highest nor one letter: choose one of them.")
    letters = sorted(set(atoms.altloc) - {""})
    if not letters:
        if altloc not in ("first", "highest"):
            log.warning("%s has no alternate locations: altloc %s changes nothing", path, altloc)
        return atoms
    if altloc not in ("first", "highest", *letters):
        message = "%s has no alternate location %s (it has %s): the first is taken"
        log.warning(message, path, altloc, ", ".join(letters))
    keep = pd.Series(True, index=atoms.index)
    located = atoms.groupby(["model", "chain", "residue"]).altloc.transform("max") != ""
    for _, residue in atoms[located].groupby(["model", "chain", "residue"], sort=False):
        keep[residue.index] = _kept_of_residue(residue, altloc)
    return atoms[keep].reset_index(drop=True)


def report_duplicates(atoms, path):
    """Warn of atoms of one name in one residue (a line that stands twice); the surface counts a place once."""
    first_model = atoms[atoms.model == atoms.model[0]]
    identity = first_model.assign(number=number_residues(first_model))[["number", "residue_name", "name"]]
    count = int(identity.duplicated().sum())
    if count:
        words = "stands twice in its residue" if count == 1 else "stand twice in their residues"
        log.warning("%s: %s %s", path, pluralise(count, "atom"), words)


def _kept_of_residue(residue, altloc):
    labelled = residue[residue.altloc != ""]
    letters = list(dict.fromkeys(labelled.altloc))
    if altloc == "highest":
        occupancy = labelled.groupby("altloc").occupancy.mean()
        letters.sort(key=lambda letter: -occupancy[letter])  # stable: the first wins a tie
    chosen = altloc if altloc in letters else letters[0]
    keep = residue.altloc.isin(["", chosen])
    name_kept = residue.residue_name.isin(residue.residue_name[residue.altloc == chosen])
    missing = name_kept & ~residue.name.isin(residue.name[keep])
    return keep | (missing & ~residue[missing].duplicated("name").reindex(residue.index, fill_value=True))
