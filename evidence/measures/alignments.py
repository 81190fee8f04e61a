"""Where places of one protein lie on another by an alignment: of sequences with a local fit, or of structures (TM-align)."""

import logging
from collections.abc import Callable

import gemmi
import numpy as np
from scipy.spatial import cKDTree

from sparsurf import InputError
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.residues import standard_name
from sparsurf.sites.pose_search import rigid_fit

log = logging.getLogger("sparsurf")

SEQUENCE, STRUCTURE = ALIGNMENTS = "sequence alignment, local fit", "TM-align"
LOCAL = 8  # aligned C-alpha atoms nearest to a place, whose fit moves it


def aligned_residues(first: Molecule, second: Molecule) -> tuple[np.ndarray, np.ndarray]:
    """Align two sequences, all chains of a molecule in a row; return the residues that face each other, (n,) int each."""
    names = [[standard_name(str(name)) for name in each.residues["residue_name"]] for each in (first, second)]
    alignment = gemmi.align_string_sequences(*names, [], gemmi.AlignmentScoring("b"))
    gapped = [alignment.add_gaps(gemmi.one_letter_code(own), k) for k, own in enumerate(names, 1)]
    residue_index = [np.cumsum([letter != "-" for letter in row]) - 1 for row in gapped]
    paired = np.array([a != "-" != b for a, b in zip(*gapped, strict=True)])
    return residue_index[0][paired], residue_index[1][paired]


def alpha(molecule: Molecule) -> np.ndarray:
    """Return the C-alpha atom of each residue, (R,) int; where there is none, the first atom."""
    first = np.unique(molecule.residue_index, return_index=True)[1]
    atoms = np.flatnonzero(molecule.name == "CA")
    first[molecule.residue_index[atoms]] = atoms
    return first


def by_sequence(query: Molecule, target: Molecule, places: np.ndarray) -> np.ndarray:
    """Move places (P, 3) with the `LOCAL` nearest aligned C-alpha atoms of the query onto those of the target."""
    rows = aligned_residues(query, target)
    here, there = (each.xyz[0][alpha(each)][own] for each, own in zip((query, target), rows, strict=True))
    near = cKDTree(here).query(places, k=min(LOCAL, len(here)))[1]
    out = np.empty_like(places, float)
    for k, (place, atoms) in enumerate(zip(places, near, strict=True)):
        try:
            rotation, shift = rigid_fit(here[atoms], there[atoms], np.ones(len(atoms)))
        except InputError:  # atoms on a line: the place moves with their middle
            rotation, shift = np.eye(3), (there[atoms] - here[atoms]).mean(axis=0)
        out[k] = place @ rotation + shift
    return out


def by_structure(query: Molecule, target: Molecule, places: np.ndarray) -> np.ndarray:
    """Move places (P, 3) with the superposition by TM-align."""
    rotation, shift, _ = tm_align(query, target)
    return places @ rotation + shift


def tm_align(query: Molecule, target: Molecule) -> tuple[np.ndarray, np.ndarray, float]:
    """Superpose by TM-align (Zhang & Skolnick, Nucleic Acids Res. 33:2302, 2005), by the package tmtools.

    Returns
    -------
    rotation, shift : (3, 3) and (3,), so that x @ rotation + shift lies on the target
    score : float, TM-score over the length of the shorter protein
    """
    import tmtools

    both = []
    for each in (query, target):
        atoms = np.flatnonzero(each.name == "CA")
        names = each.residues["residue_name"].to_numpy()[each.residue_index[atoms]]
        sequence = gemmi.one_letter_code([standard_name(str(name)) for name in names])
        both.append((each.xyz[0][atoms].astype(float), sequence))
    found = tmtools.tm_align(both[0][0], both[1][0], both[0][1], both[1][1])
    return found.u.T, found.t, max(found.tm_norm_chain1, found.tm_norm_chain2)


def alignments() -> dict[str, Callable[[Molecule, Molecule, np.ndarray], np.ndarray]]:
    """Return ways to move places of one protein onto another, by name; TM-align where the package tmtools is installed."""
    ways = {SEQUENCE: by_sequence, STRUCTURE: by_structure}
    try:
        import tmtools  # noqa: F401
    except ImportError as error:
        log.warning("%s is left out (%s): pip install tmtools.", STRUCTURE, error)
        del ways[STRUCTURE]
    return ways
