"""The atoms of a structure file as one table, whatever the format, and the steps that all formats share.

The table has one row per atom in the order of the file:
model         int, number of the model
hetero        bool, not part of a polymer according to the file (HETATM)
name, residue_name, chain, element, altloc    str, empty where the file has none
residue       str, number with insertion code: '52A', '-5'
terminated    bool, the previous residue was the last of its molecule (TER)
occupancy, x, y, z    float, Å
b_factor      float, Å^2, nan where the file has none
"""

from __future__ import annotations

import logging
import os
from dataclasses import dataclass, field

import gemmi
import numpy as np
import pandas as pd

from sparsurf.errors import InputError
from sparsurf.files import pluralise

log = logging.getLogger("sparsurf")

MIN_BOX_VOLUME = 1e-6  # share of the volume of the same box at right angles; a flat box is impossible


@dataclass(frozen=True)
class AtomFile:
    """Content of a structure file.

    Attributes
    ----------
    atoms : DataFrame, the table described above
    box : (3, 3) float, Å, lattice vectors as rows; None where there is none
    sequences : dict, residue names of each chain's full sequence, where the file has it
    crosslinked : set of (chain, residue) that a bond besides the backbone joins to another residue of the polymer
    has_plddt : bool, whether a predicted model says that its B factors are pLDDT; None if the file is not a predicted model
    """

    atoms: pd.DataFrame
    box: np.ndarray | None = None
    sequences: dict[str, list[str]] = field(default_factory=dict)
    crosslinked: frozenset[tuple[str, str]] = frozenset()
    has_plddt: bool | None = None


def box_vectors(a: float, b: float, c: float, alpha: float, beta: float, gamma: float) -> np.ndarray | None:
    """Return lattice vectors (3, 3), Å, from lengths (Å) and angles (degrees); None for an impossible box or a dummy of 1 Å."""
    try:
        cell = gemmi.UnitCell(a, b, c, alpha, beta, gamma)
        impossible = cell.is_crystal() and not cell.volume > MIN_BOX_VOLUME * a * b * c
    except RuntimeError:  # an angle of 0 or 180 degrees
        impossible = True
    if impossible:
        edges, angles = (", ".join(f"{x:g}" for x in values) for values in ((a, b, c), (alpha, beta, gamma)))
        log.warning("a box of %s Å with angles of %s° is impossible: it counts as missing", edges, angles)
        return None
    return np.array(cell.orth.mat.tolist()).T if cell.is_crystal() and cell.volume > 1 else None


def number_residues(atoms: pd.DataFrame) -> np.ndarray:
    """Assign the residues the numbers 0, 1, 2, ... in the order of the file, starting again in each model.

    A residue ends where chain, number or insertion code change, at TER, or where the name changes. A change of the
    name between alternate locations of one residue does not count.

    Returns
    -------
    (A,) int
        Residue of each atom.
    """
    before = atoms.shift()
    differs = (atoms[["model", "chain", "residue"]] != before[["model", "chain", "residue"]]).any(axis=1)
    alternates = (atoms.altloc != "") & (before.altloc != "")
    renamed = (atoms.residue_name != before.residue_name) & ~alternates
    number = (differs | renamed | atoms.terminated).cumsum()
    return (number - number.groupby(atoms.model).transform("min")).to_numpy()


def missing_residues(atoms: pd.DataFrame, sequences: dict[str, list[str]]) -> dict[str, tuple[int, int]]:
    """Find chains that lack residues of their full sequence, in the first model.

    Returns
    -------
    dict
        chain -> (number of residues with atoms, number of residues in the sequence)
    """
    residues = atoms[atoms.model == atoms.model[0]].drop_duplicates(["chain", "residue"])
    counts = {
        chain: (int((residues.residue_name[residues.chain == chain].isin(sequence)).sum()), len(sequence))
        for chain, sequence in sequences.items()
    }
    return {chain: (present, full) for chain, (present, full) in counts.items() if present < full}


def choose_altlocs(atoms: pd.DataFrame, altloc: str, path: str | os.PathLike[str]) -> pd.DataFrame:
    """Keep one location of every atom.

    All atoms of a residue keep the same location: the first in the file ('first'), the one of highest mean
    occupancy ('highest') or the requested letter where the residue has it, else the first. An atom that only
    other locations of the residue have is kept too, so that there is no hole.

    Parameters
    ----------
    atoms : DataFrame
    altloc : 'first', 'highest' or a letter
    path : str or Path
        Named in messages.

    Raises
    ------
    InputError
        `altloc` is something else, or is 'highest' and an occupancy is none.
    """
    if not isinstance(altloc, str) or (altloc not in ("first", "highest") and len(altloc.strip()) != 1):
        raise InputError(f"altloc: '{altloc}' is neither first, highest nor one letter: choose one of them.")
    letters = sorted(set(atoms.altloc) - {""})
    if not letters:
        if altloc not in ("first", "highest"):
            log.warning("%s has no alternate locations: altloc %s changes nothing", path, altloc)
        return atoms
    if altloc == "highest" and not atoms.occupancy[atoms.altloc != ""].between(0, 1).all():
        raise InputError(
            f"{path} has an alternate location whose occupancy is not between 0 and 1: name a letter as altloc, or 'first'."
        )
    if altloc not in ("first", "highest", *letters):
        message = "%s has no alternate location %s (it has %s): the first is used"
        log.warning(message, path, altloc, ", ".join(letters))
    keep = pd.Series(True, index=atoms.index)
    keys = [atoms.model, atoms.chain, atoms.residue, atoms.terminated.cumsum()]  # TER ends a molecule
    located = atoms.groupby(keys).altloc.transform("max") != ""
    for _, residue in atoms[located].groupby([key[located] for key in keys], sort=False):
        keep[residue.index] = _choose_location(residue, altloc)
    return atoms[keep].reset_index(drop=True)


def refuse_control_characters(atoms: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Raise InputError if a name has characters that cannot be printed, such as escape codes for a terminal."""
    for column in ("name", "residue_name", "chain", "element", "residue"):
        damaged = next(
            (text for text in atoms[column].unique().tolist() if not str(text).isprintable()), None
        )
        if damaged is not None:
            raise InputError(
                f"{path} has an atom whose {column.replace('_', ' ')} is {damaged!r}: repair the file."
            )


def report_duplicates(atoms: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Warn of repeated atom names in a residue (a repeated line); the surface counts a position once."""
    first_model = atoms[atoms.model == atoms.model[0]]
    identity = first_model.assign(number=number_residues(first_model))[["number", "residue_name", "name"]]
    count = int(identity.duplicated().sum())
    if count:
        words = "is repeated in its residue" if count == 1 else "are repeated in their residues"
        log.warning("%s: %s %s", path, pluralise(count, "atom"), words)


def report_occupancies(atoms: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Warn of occupancies that are no share; they count only where they decide between alternate locations."""
    impossible = ~atoms.occupancy.between(0, 1)
    if impossible.any():
        message = "%s: %s an occupancy outside 0 to 1, such as %g; is another quantity in its column?"
        count = int(impossible.sum())
        words = f"{pluralise(count, 'atom')} {'has' if count == 1 else 'have'}"
        log.warning(message, path, words, atoms.occupancy[impossible].iloc[0])


def _choose_location(residue: pd.DataFrame, altloc: str) -> pd.Series:
    """Return which atoms of a residue are kept, a bool per row."""
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
