"""Coordinates that no molecule of these names can have: other units, another order of atoms, damaged numbers."""

import logging

import numpy as np

from sparsurf import InputError
from sparsurf.files import pluralise
from sparsurf.molecules.formats import IN_NM, suffix
from sparsurf.molecules.residues import AMINO_ACIDS, HEAVY_ATOMS, PEPTIDE, standard_name

log = logging.getLogger("sparsurf")

FARTHEST = 1e5  # Å; no molecule is there, a damaged number is
CROWDED = 0.5  # Å; half of the shortest bond, and more than any bond in nm
SAMPLE = 100  # atoms whose nearest neighbours tell the unit
FEWEST_ATOMS = 10  # that do; fewer may be half-occupied ones
# Å, diagonal of the box around a residue of HEAVY_ATOMS; 13.7 at most in 230 structures and trajectories
WIDEST_RESIDUE = 20.0
APART = 500.0  # Å, between the parts of a molecule
BOND = 2.0  # Å, longest between heavy atoms of one residue (C-Br 1.95)
BROKEN = 3.0  # Å; bonds of simulations stay below 2.0
REACH = 40  # atoms of a residue that come between two bonded ones, at most
# A share of the atoms, or of the peptide bonds, with a bonded neighbour; at least .98 in the same structures.
LEAST_BONDED = 0.7
FRAMES = 64  # whose bonds are measured at once
# Å, bonds of backbones; half of them are within 2 % of it in the same structures
USUAL = {("N", "CA"): 1.46, ("CA", "C"): 1.525, ("C", "O"): 1.23, ("C4'", "C3'"): 1.52, ("P", "O5'"): 1.59}
MOST_ODD, ODD = 0.15, 0.08  # refused, and told: a morph between two conformations may be so
INSIDE = 1.2  # Å; atoms of two residues are never so close, bonded or not
MANY = 0.1  # share of atoms from which on something is no odd detail of a structure
LETTERS = {
    "H": "H",
    "D": "H",
    "C": "C",
    "N": "N",
    "O": "O",
    "S": "S",
}  # first of an atom's name, and its element


def refuse_impossible(molecule, path, topology=None, whole=True, unit=None):
    """Raise InputError, with the frame and the atoms, where coordinates cannot be those of a molecule.

    Parameters
    ----------
    molecule : molecule.Molecule, all frames
    path : file of the coordinates, named in messages
    topology : file of the names, where it is another one
    whole : bool, whether no molecule is cut by a periodic box
    unit : str, of the lengths in the file; by default the one of its format
    """
    unit = unit or ("nm" if suffix(path) in IN_NM else "Å")
    _refuse_crowded(molecule.xyz, path, unit)
    if whole and molecule.n_atoms:
        _refuse_other_elements(molecule, path)
        remedy = f"give lengths in {unit}, " + (
            f"and atoms in the order of {topology}" if topology else "or repair the file"
        )
        _refuse_wide_residues(molecule, path, remedy)
        _refuse_gaps(molecule, path, remedy)
        links, apart = _peptide_bonds(molecule)
        bonds, bonded = _bonds(molecule, links, apart < PEPTIDE[3])
        _refuse_unbonded(molecule, bonded, path, topology)
        _refuse_odd_lengths(molecule, path, remedy)
        _refuse_broken(molecule, bonds, path)
        _warn_of_doubts(molecule, links, apart, path)


def refuse_no_numbers(xyz, path):
    """Raise InputError where coordinates (F, A, 3), Å, are NaN or beyond FARTHEST, or all the same."""
    bad = ~(np.abs(xyz) < FARTHEST).all(axis=(1, 2))  # nan too
    if bad.any():
        raise InputError(
            f"{path} has coordinates that are no numbers or beyond {FARTHEST:.0e} Å in frame {bad.argmax()}: "
            "repair or copy it again."
        )
    if xyz.shape[1] > 1 and (np.ptp(xyz, axis=1) == 0).all(axis=1).any():
        raise InputError(f"{path} has all atoms in one place: give a file with coordinates.")


def _refuse_crowded(xyz, path, unit):
    """Raise InputError where the atoms of the first frame are nearer than bonds allow."""
    some = xyz[0, :: -(-xyz.shape[1] // SAMPLE)]
    if len(some) < FEWEST_ATOMS:
        return
    gap = np.median([np.partition(np.linalg.norm(xyz[0] - each, axis=1), 1)[1] for each in some])
    if 0 < gap < CROWDED:
        raise InputError(
            f"{path} has atoms {gap:.2f} Å apart, where bonds are 1 Å and more: give lengths in {unit}."
        )


def _refuse_wide_residues(molecule, path, remedy):
    start = np.flatnonzero(np.diff(molecule.residue_index, prepend=-1))
    box = np.maximum.reduceat(molecule.xyz, start, axis=1) - np.minimum.reduceat(molecule.xyz, start, axis=1)
    known = [standard_name(name) in HEAVY_ATOMS for name in molecule.residue_name[start]]
    extent = np.where(known, np.linalg.norm(box, axis=2), 0)
    wide = np.argwhere(extent > WIDEST_RESIDUE)
    if len(wide):
        frame, residue = wide[0]
        xyz = np.split(molecule.xyz[frame], start[1:])[residue]
        atom = start[residue] + np.linalg.norm(xyz - np.median(xyz, axis=0), axis=1).argmax()
        raise InputError(
            f"{path}: {_residue(molecule, atom)} is {extent[frame, residue]:.0f} Å wide in frame {frame} (atom "
            f"{molecule.name[atom]} is farthest out), not below {WIDEST_RESIDUE:.0f} Å; {remedy}."
        )


def _refuse_gaps(molecule, path, remedy):
    """Raise InputError where a plane across an axis parts the atoms by more than APART."""
    for frame in np.flatnonzero((np.ptp(molecule.xyz, axis=1) > APART).any(axis=1)):
        gap, atom = widest_gap(molecule.xyz[frame])
        if gap > APART:
            raise InputError(
                f"{path}: {molecule.name[atom]} of {_residue(molecule, atom)} lies {gap:.0f} Å from the "
                f"other atoms in frame {frame}; {remedy}."
            )


def widest_gap(xyz):
    """Width of the widest slab across x, y or z without any of the places (N, 3), and a place on its emptier side."""
    if len(xyz) < 2:
        return 0.0, 0
    order = np.argsort(xyz, axis=0)
    gaps = np.diff(np.take_along_axis(xyz, order, axis=0), axis=0)
    at, axis = np.unravel_index(gaps.argmax(), gaps.shape)
    return float(gaps[at, axis]), int(order[at + (2 * (at + 1) >= len(xyz)), axis])


def _bonds(molecule, links, linked):
    """Bonds of the first frame, (L, 2), and the share of atoms and of peptide bonds that have what belongs to them.

    A bond joins heavy atoms of a residue closer than BOND, or is one of the `links` (P, 2) between residues that are `linked`.
    """
    xyz, index = molecule.xyz[0], molecule.residue_index
    heavy = ~np.isin(molecule.element, ["H", "D"])
    nearest, pairs = np.full(len(xyz), np.inf), [np.empty((0, 2), int)]
    for step in range(1, min(REACH, len(xyz))):
        first = np.flatnonzero(index[step:] == index[:-step])
        length = np.linalg.norm(xyz[first + step] - xyz[first], axis=1)
        np.minimum.at(nearest, first, length)
        np.minimum.at(nearest, first + step, length)
        bonded = (length < BOND) & heavy[first] & heavy[first + step]
        pairs.append(np.column_stack([first, first + step])[bonded])
    polymer = np.isfinite(nearest) & np.isin(molecule.kind, ["protein", "nucleic"])
    shares = [part.mean() for part in (nearest[polymer] < BOND, linked) if len(part) >= FEWEST_ATOMS]
    return np.concatenate([*pairs, links[linked]]), min(shares, default=1.0)


def _peptide_bonds(molecule):
    """C and N of residues of one chain whose numbers follow each other, (L, 2) int, and their distance in the first frame."""
    _, last, first, _ = PEPTIDE
    ends = {name: {} for name in (last, first)}
    for atom in np.flatnonzero(np.isin(molecule.name, [last, first]) & (molecule.kind == "protein")):
        label = molecule.residue[atom]
        if label.removeprefix("-").isdecimal():
            ends[molecule.name[atom]].setdefault((molecule.chain[atom], int(label)), atom)
    found = [
        (atom, ends[first][chain, number + 1])
        for (chain, number), atom in ends[last].items()
        if (chain, number + 1) in ends[first]
    ]
    links = np.array(found, int).reshape(-1, 2)
    return links, np.linalg.norm(molecule.xyz[0][links[:, 0]] - molecule.xyz[0][links[:, 1]], axis=1)


def _refuse_unbonded(molecule, bonded, path, topology):
    if bonded < LEAST_BONDED:
        whose = f"; give its atoms in the order of {topology}" if topology else "; copy it again"
        raise InputError(
            f"{path}: only {bonded:.0%} of the bonds that its names imply are there in frame 0{whose}."
        )


def _refuse_broken(molecule, bonds, path):
    """Raise InputError where a bond of the first frame is longer than BROKEN in another."""
    for begin in range(1, molecule.n_frames, FRAMES):
        xyz = molecule.xyz[begin : begin + FRAMES]
        length = np.linalg.norm(xyz[:, bonds[:, 0]] - xyz[:, bonds[:, 1]], axis=2)
        if (length > BROKEN).any():
            frame, bond = np.argwhere(length > BROKEN)[0]
            a, b = bonds[bond]
            raise InputError(
                f"{path}: the bond {molecule.name[a]}-{molecule.name[b]} of {_residue(molecule, a)} is "
                f"{length[frame, bond]:.1f} Å long in frame {begin + frame}; repair that frame or leave it out."
            )


def _refuse_odd_lengths(molecule, path, remedy):
    """Raise InputError where half of the bonds of the backbone differ from their usual length by more than MOST_ODD; warn
    of ODD."""
    place, pairs, usual = _places(molecule), [np.empty((0, 2), int)], []
    for (first, second), length in USUAL.items():
        both = np.column_stack([place(first), place(second)])
        pairs.append(both[(both >= 0).all(axis=1)])
        usual += [length] * len(pairs[-1])
    a, b = np.concatenate(pairs).T
    for begin in range(0, molecule.n_frames if len(a) >= FEWEST_ATOMS else 0, FRAMES):
        xyz = molecule.xyz[begin : begin + FRAMES]
        flat = (np.ptp(xyz, axis=1) == 0).any(axis=1)
        if flat.any():
            raise InputError(f"{path} has all atoms in one plane in frame {begin + flat.argmax()}; {remedy}.")
        share = np.linalg.norm(xyz[:, a] - xyz[:, b], axis=2) / usual
        odd = np.median(np.abs(share - 1), axis=1)
        if ODD < odd.max() <= MOST_ODD:
            message = (
                "%s: half of the bonds of the backbone differ by %.0f %% from their usual length in frame %d"
            )
            log.warning(message, path, 100 * odd.max(), begin + odd.argmax())
        if (odd > MOST_ODD).any():
            frame = int(np.argmax(odd > MOST_ODD))
            raise InputError(
                f"{path}: bonds of the backbone are {np.median(share[frame]):.2f} times as long as usual in frame "
                f"{begin + frame}, and half of them differ by {odd[frame]:.0%} or more; {remedy}."
            )


def _places(molecule):
    """Function of a name: the atom of that name in each residue, (R,) int, -1 where there is none."""

    def place(name):
        found = np.full(molecule.residue_index.max() + 1, -1)
        at = np.flatnonzero(molecule.name == name)
        found[molecule.residue_index[at]] = at
        return found

    return place


def _refuse_other_elements(molecule, path):
    """Raise InputError where elements are not those that the names of the atoms of amino acids begin with."""
    known = np.array([standard_name(name) in AMINO_ACIDS for name in molecule.residue_name])
    told = np.array([LETTERS.get(name.lstrip("0123456789'*")[:1].upper(), "") for name in molecule.name])
    given = np.where(molecule.element == "D", "H", molecule.element)
    wrong = known & (told != "") & (told != given) & (given != "SE")
    if known.sum() >= FEWEST_ATOMS and wrong.sum() > MANY * known.sum():
        atom = int(np.argmax(wrong))
        raise InputError(
            f"{path}: {molecule.name[atom]} of {_residue(molecule, atom)} has the element {molecule.element[atom]}, as "
            f"{wrong.sum()} atoms have another than their names say; repair the elements or leave their column blank."
        )


def _warn_of_doubts(molecule, links, apart, path):
    """Warn of what may be meant and hardly ever is: one atom, a mirror image, copies in one another, a broken chain."""
    xyz, index = molecule.xyz[0], molecule.residue_index
    if molecule.n_atoms == 1:
        log.warning("%s: one atom alone is taken; its surface is a sphere", path)
    place = _places(molecule)
    n, ca, c, cb = (place(name) for name in ("N", "CA", "C", "CB"))
    whole = np.flatnonzero((np.stack([n, ca, c, cb]) >= 0).all(axis=0))
    to_n, to_c, to_cb = (xyz[each[whole]] - xyz[ca[whole]] for each in (n, c, cb))
    mirrored = (np.cross(to_n, to_c) * to_cb).sum(axis=1) < 0
    if len(whole) >= FEWEST_ATOMS and mirrored.mean() > 0.5:
        log.warning("%s: it is a mirror image, of D-amino acids; does an axis have the wrong sign?", path)
    some = range(0, len(xyz), -(-len(xyz) // SAMPLE))
    inside = [
        ((np.abs(xyz - xyz[k]).sum(axis=1) < 2 * INSIDE) & (index != index[k])).nonzero()[0] for k in some
    ]
    crowded = [
        (np.linalg.norm(xyz[near] - xyz[k], axis=1) < INSIDE).any()
        for k, near in zip(some, inside, strict=True)
    ]
    if len(crowded) >= FEWEST_ATOMS and np.mean(crowded) > MANY:
        message = "%s: %.0f %% of its atoms lie inside other residues; does it hold a molecule twice?"
        log.warning(message, path, 100 * np.mean(crowded))
    broken = np.flatnonzero(apart >= PEPTIDE[3])
    if len(broken):
        a, b = links[broken[0]]
        message = "%s: %s missing, the first between %s and %s, %.1f Å apart"
        words = pluralise(len(broken), "peptide bond") + (" is" if len(broken) == 1 else " are")
        log.warning(message, path, words, _residue(molecule, a), _residue(molecule, b), apart[broken[0]])


def _residue(molecule, atom):
    """'GLU 209 A'."""
    return f"{molecule.residue_name[atom]} {molecule.residue[atom]} {molecule.chain[atom]}".strip()
