"""Coordinates that no molecule of these names can have: other units, another order of atoms, damaged numbers."""

import numpy as np

from sparsurf import InputError
from sparsurf.molecules.formats import IN_NM, suffix
from sparsurf.molecules.residues import HEAVY_ATOMS, PEPTIDE, standard_name

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
        remedy = f"give lengths in {unit}, " + (
            f"and atoms in the order of {topology}" if topology else "or repair the file"
        )
        _refuse_wide_residues(molecule, path, remedy)
        _refuse_gaps(molecule, path, remedy)
        bonds, bonded = _bonds(molecule)
        _refuse_unbonded(molecule, bonded, path, topology)
        _refuse_broken(molecule, bonds, path)


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


def _bonds(molecule):
    """Bonds of the first frame, (L, 2), and the share of atoms and of peptide bonds that have what belongs to them.

    A bond joins heavy atoms of a residue closer than BOND, or C and N of residues that follow each other.
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
    links = _peptide_bonds(molecule)
    linked = np.linalg.norm(xyz[links[:, 0]] - xyz[links[:, 1]], axis=1) < PEPTIDE[3]
    shares = [part.mean() for part in (nearest[polymer] < BOND, linked) if len(part) >= FEWEST_ATOMS]
    return np.concatenate([*pairs, links[linked]]), min(shares, default=1.0)


def _peptide_bonds(molecule):
    """(L, 2) int: C and N of residues of one chain whose numbers follow each other."""
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
    return np.array(found, int).reshape(-1, 2)


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


def _residue(molecule, atom):
    """'GLU 209 A'."""
    return f"{molecule.residue_name[atom]} {molecule.residue[atom]} {molecule.chain[atom]}".strip()
