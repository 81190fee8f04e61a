"""Detect coordinates that cannot belong to a molecule: wrong units, another order of atoms, damaged numbers."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import InputError
from sparsurf.files import pluralise
from sparsurf.molecules.formats import IN_NM, suffix
from sparsurf.molecules.residues import AMINO_ACIDS, HEAVY_ATOMS, PEPTIDE, count_heavy_atoms, standard_name

if TYPE_CHECKING:
    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

MAX_COORDINATE = 1e5  # Å; a larger one is a damaged number
MIN_NEIGHBOUR_DISTANCE = 0.5  # Å; half of the shortest bond, and more than any bond in nm
SAMPLED_ATOMS = 100  # whose neighbours are examined
MIN_ATOMS_TO_JUDGE = 10  # fewer may be half-occupied atoms
# Å, diagonal of the box around a residue of HEAVY_ATOMS; at most 13.7 in 230 structures and trajectories
MAX_RESIDUE_WIDTH = 20.0
MAX_GAP = 500.0  # Å, between the parts of a molecule
MAX_BOND = 2.0  # Å, between heavy atoms of one residue (C-Br 1.95)
BROKEN_BOND = 3.0  # Å; bonds of simulations stay below 2.0
MAX_ATOMS_BETWEEN_BONDED = 40  # in the order of a residue's atoms
MIN_BONDED_SHARE = (
    0.7  # of atoms, or of peptide bonds, with a bonded neighbour; at least 0.98 in the same structures
)
FRAMES_AT_ONCE = 64
# Å, bonds of backbones; half of them are within 2 % of these lengths in the same structures
USUAL_LENGTHS = {
    ("N", "CA"): 1.46, ("CA", "C"): 1.525, ("C", "O"): 1.23, ("C4'", "C3'"): 1.52, ("P", "O5'"): 1.59,
}  # fmt: skip
# Median deviation from these lengths that is refused, and that causes a warning: a morph between two conformations may
# have it. It is at most .015 in 300 structures, and .03 at 300 K.
DEVIATION_TO_REFUSE, DEVIATION_TO_WARN = 0.15, 0.04
ODD_BOND = 0.25  # deviation of one bond that causes a warning; of 671 structures one has a bond beyond .18
CLASH = 1.2  # Å; atoms of two residues are never that close, bonded or not
# Deviation of a chain's bonds from their usual length along any direction that causes a warning. It is at most .03 in 700
# structures and trajectories; fewer bonds than MIN_BONDS_OF_LONG_CHAIN vary more.
STRETCH_TO_WARN, STRETCH_OF_SHORT_CHAIN, MIN_BONDS_OF_LONG_CHAIN = 0.05, 0.09, 40
CERTAINTY = 0.02  # weight, per bond, of the usual lengths in directions that no bond has
MAX_RATIO = 1.6  # of a bond's length to its usual length, or the reverse; bonds beyond are ignored when stretch is estimated
MIN_RESIDUES_OF_MIRROR = 3  # of a chain whose handedness is compared with that of the first frame
SAME_PLACE = 0.5  # Å; two atoms are never that close
SAME_RESIDUE = 1.0  # Å; C-alpha atoms of neighbours are 2.8 Å apart at least
LOST_ATOM = 3.0  # Å, from the nearest atom of its residue
CUBE = 1.6  # Å, of a grid in which overlapping atoms are found
SHARE_TO_REPORT = 0.1  # of atoms; below it, an irregularity is an odd detail of the structure
ELEMENT_OF_LETTER = {
    "H": "H",
    "D": "H",
    "C": "C",
    "N": "N",
    "O": "O",
    "S": "S",
}  # by the first letter of a name


def refuse_impossible(
    molecule: Molecule,
    path: str | os.PathLike[str],
    topology: str | os.PathLike[str] | None = None,
    whole: bool = True,
    unit: str | None = None,
) -> None:
    """Raise InputError, with frame and atoms, if coordinates cannot belong to the molecule.

    Parameters
    ----------
    molecule : Molecule, all frames
    path : file of the coordinates, named in messages
    topology : file of the names, if it is another one
    whole : bool, whether no molecule is cut by the periodic box
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
        links, distance = _peptide_bonds(molecule)
        bonds, bonded_share = _bonds(molecule, links, distance < PEPTIDE.max_length)
        _refuse_unbonded(bonded_share, path, topology)
        _refuse_odd_lengths(molecule, path, remedy)
        _refuse_broken(molecule, bonds, path)
        _warn_of_doubts(molecule, links, distance, path)
        _warn_of_odd_bonds(molecule, path)
        _warn_of_stretched_chains(molecule, path)
        _warn_of_mirror_images(molecule, path)
        _warn_of_shared_places(molecule, path)
        _warn_of_overlaps(molecule, path)


def refuse_invalid_coordinates(xyz: np.ndarray, path: str | os.PathLike[str], begin: int = 0) -> None:
    """Raise InputError if coordinates (F, A, 3), Å, from frame `begin` are NaN, beyond MAX_COORDINATE, or all the same."""
    bad = ~(np.abs(xyz) < MAX_COORDINATE).all(axis=(1, 2))  # nan too
    if bad.any():
        raise InputError(
            f"{path} has coordinates that are not numbers or beyond {MAX_COORDINATE:.0e} Å in frame {begin + bad.argmax()}: "
            "repair or copy it again."
        )
    if xyz.shape[1] > 1 and (np.ptp(xyz, axis=1) == 0).all(axis=1).any():
        raise InputError(f"{path} has all atoms at one position: give a file with coordinates.")


def _refuse_crowded(xyz: np.ndarray, path: str | os.PathLike[str], unit: str) -> None:
    """Raise InputError if atoms of the first frame are closer than bonds allow."""
    sample = xyz[0, :: -(-xyz.shape[1] // SAMPLED_ATOMS)]
    if len(sample) < MIN_ATOMS_TO_JUDGE:
        return
    gap = np.median([np.partition(np.linalg.norm(xyz[0] - atom, axis=1), 1)[1] for atom in sample])
    if 0 < gap < MIN_NEIGHBOUR_DISTANCE:
        raise InputError(
            f"{path} has atoms {gap:.2f} Å apart, but bonds are 1 Å or longer: give lengths in {unit}."
        )


def _refuse_wide_residues(molecule: Molecule, path: str | os.PathLike[str], remedy: str) -> None:
    """Raise InputError if a residue is wider than MAX_RESIDUE_WIDTH."""
    start = np.flatnonzero(np.diff(molecule.residue_index, prepend=-1))
    box = np.maximum.reduceat(molecule.xyz, start, axis=1) - np.minimum.reduceat(molecule.xyz, start, axis=1)
    known = [standard_name(name) in HEAVY_ATOMS for name in molecule.residue_name[start]]
    extent = np.where(known, np.linalg.norm(box, axis=2), 0)
    wide = np.argwhere(extent > MAX_RESIDUE_WIDTH)
    if len(wide):
        frame, residue = wide[0]
        xyz = np.split(molecule.xyz[frame], start[1:])[residue]
        atom = start[residue] + np.linalg.norm(xyz - np.median(xyz, axis=0), axis=1).argmax()
        raise InputError(
            f"{path}: {residue_label(molecule, atom)} is {extent[frame, residue]:.0f} Å wide in frame {frame} (atom "
            f"{molecule.name[atom]} is farthest out) instead of below {MAX_RESIDUE_WIDTH:.0f} Å; {remedy}."
        )


def _refuse_gaps(molecule: Molecule, path: str | os.PathLike[str], remedy: str) -> None:
    """Raise InputError if an empty slab across an axis, wider than MAX_GAP, separates the atoms."""
    for frame in np.flatnonzero((np.ptp(molecule.xyz, axis=1) > MAX_GAP).any(axis=1)):
        gap, atom = widest_gap(molecule.xyz[frame])
        if gap > MAX_GAP:
            raise InputError(
                f"{path}: {molecule.name[atom]} of {residue_label(molecule, atom)} lies {gap:.0f} Å from the "
                f"other atoms in frame {frame}; {remedy}."
            )


def widest_gap(xyz: np.ndarray) -> tuple[float, int]:
    """Find the widest slab across x, y or z that contains none of the points (N, 3).

    Returns
    -------
    width : float
    point : int
        Index of the point next to the slab on the side with fewer points.
    """
    if len(xyz) < 2:
        return 0.0, 0
    order = np.argsort(xyz, axis=0)
    gaps = np.diff(np.take_along_axis(xyz, order, axis=0), axis=0)
    before, axis = np.unravel_index(gaps.argmax(), gaps.shape)
    return float(gaps[before, axis]), int(order[before + (2 * (before + 1) >= len(xyz)), axis])


def _bonds(molecule: Molecule, links: np.ndarray, linked: np.ndarray) -> tuple[np.ndarray, float]:
    """Find the bonds of the first frame, and the share of atoms or peptide bonds that are bonded, whichever is lower.

    A bond (L, 2) joins heavy atoms of a residue closer than MAX_BOND, or is one of the `links` (P, 2) between residues
    that are `linked` (P,).
    """
    xyz, index = molecule.xyz[0], molecule.residue_index
    heavy = molecule.heavy
    nearest, pairs = np.full(len(xyz), np.inf), [np.empty((0, 2), int)]
    for step in range(1, min(MAX_ATOMS_BETWEEN_BONDED, len(xyz))):
        first = np.flatnonzero(index[step:] == index[:-step])
        length = np.linalg.norm(xyz[first + step] - xyz[first], axis=1)
        np.minimum.at(nearest, first, length)
        np.minimum.at(nearest, first + step, length)
        bonded = (length < MAX_BOND) & heavy[first] & heavy[first + step]
        pairs.append(np.column_stack([first, first + step])[bonded])
    polymer = np.isfinite(nearest) & np.isin(molecule.kind, ["protein", "nucleic"])
    bonded_lists = nearest[polymer] < MAX_BOND, linked
    shares = [float(bonded.mean()) for bonded in bonded_lists if len(bonded) >= MIN_ATOMS_TO_JUDGE]
    return np.concatenate([*pairs, links[linked]]), min(shares, default=1.0)


def _peptide_bonds(molecule: Molecule) -> tuple[np.ndarray, np.ndarray]:
    """Find C and N (L, 2) of residues with consecutive numbers in a chain, and their distance in the first frame."""
    last, first = PEPTIDE.last, PEPTIDE.first
    ends: dict[str, dict[tuple[str, int], int]] = {last: {}, first: {}}
    for atom in np.flatnonzero(np.isin(molecule.name, [last, first]) & (molecule.kind == "protein")):
        label = molecule.residue[atom]
        if label.removeprefix("-").isdecimal():
            ends[molecule.name[atom]].setdefault((molecule.chain[atom], int(label)), int(atom))
    pairs = [
        (atom, ends[first][chain, number + 1])
        for (chain, number), atom in ends[last].items()
        if (chain, number + 1) in ends[first]
    ]
    links = np.array(pairs, int).reshape(-1, 2)
    return links, np.linalg.norm(molecule.xyz[0][links[:, 0]] - molecule.xyz[0][links[:, 1]], axis=1)


def _refuse_unbonded(
    bonded_share: float, path: str | os.PathLike[str], topology: str | os.PathLike[str] | None
) -> None:
    """Raise InputError if too few atoms have the neighbours that their names imply."""
    if bonded_share < MIN_BONDED_SHARE:
        remedy = f"; give its atoms in the order of {topology}" if topology else "; copy it again"
        raise InputError(
            f"{path}: only {bonded_share:.0%} of the bonds that its names imply exist in frame 0{remedy}."
        )


def _refuse_broken(molecule: Molecule, bonds: np.ndarray, path: str | os.PathLike[str]) -> None:
    """Raise InputError if a bond of the first frame is longer than BROKEN_BOND in another."""
    for begin in range(1, molecule.n_frames, FRAMES_AT_ONCE):
        xyz = molecule.xyz[begin : begin + FRAMES_AT_ONCE]
        length = np.linalg.norm(xyz[:, bonds[:, 0]] - xyz[:, bonds[:, 1]], axis=2)
        if (length > BROKEN_BOND).any():
            frame, bond = np.argwhere(length > BROKEN_BOND)[0]
            a, b = bonds[bond]
            raise InputError(
                f"{path}: the bond {molecule.name[a]}-{molecule.name[b]} of {residue_label(molecule, a)} is "
                f"{length[frame, bond]:.1f} Å long in frame {begin + frame}; repair that frame or leave it out."
            )


def _refuse_odd_lengths(molecule: Molecule, path: str | os.PathLike[str], remedy: str) -> None:
    """Raise InputError if half of the backbone's bonds deviate by more than DEVIATION_TO_REFUSE from their usual length."""
    pairs, usual = _backbone_bonds(molecule)
    a, b = pairs.T
    chains = _chains_to_judge(molecule, a)
    for begin in range(0, molecule.n_frames if len(a) >= MIN_ATOMS_TO_JUDGE else 0, FRAMES_AT_ONCE):
        xyz = molecule.xyz[begin : begin + FRAMES_AT_ONCE]
        flat = (np.ptp(xyz, axis=1) == 0).any(axis=1)
        if flat.any():
            raise InputError(f"{path} has all atoms in one plane in frame {begin + flat.argmax()}; {remedy}.")
        ratio = np.linalg.norm(xyz[:, a] - xyz[:, b], axis=2) / usual
        deviation = np.median(np.abs(ratio - 1), axis=1)
        for chain in chains[1:] and chains:  # of several, one may be odd
            of_chain = np.median(np.abs(ratio[:, chain] - 1), axis=1)
            ratio_of_chain = np.median(ratio[:, chain], axis=1)
            frame = int(of_chain.argmax())
            if of_chain[frame] > DEVIATION_TO_REFUSE >= deviation[frame]:
                raise InputError(
                    f"{path}: bonds of the chain of {residue_label(molecule, a[chain][0])} are {ratio_of_chain[frame]:.2f} times "
                    f"as long as usual in frame {begin + frame}; {remedy}."
                )
        if DEVIATION_TO_WARN < deviation.max() <= DEVIATION_TO_REFUSE:
            message = (
                "%s: half of the bonds of the backbone differ by %.0f %% from their usual length in frame %d"
            )
            log.warning(message, path, 100 * deviation.max(), begin + deviation.argmax())
        if (deviation > DEVIATION_TO_REFUSE).any():
            frame = int(np.argmax(deviation > DEVIATION_TO_REFUSE))
            raise InputError(
                f"{path}: bonds of the backbone are {np.median(ratio[frame]):.2f} times as long as usual in frame "
                f"{begin + frame}, and half of them differ by {deviation[frame]:.0%} or more; {remedy}."
            )


def _backbone_bonds(molecule: Molecule) -> tuple[np.ndarray, np.ndarray]:
    """Find the bonds (L, 2) of USUAL_LENGTHS, and their usual lengths (L,)."""
    atom_of, pairs, usual = _atoms_by_name(molecule), [np.empty((0, 2), int)], []
    for (first, second), length in USUAL_LENGTHS.items():
        both = np.column_stack([atom_of(first), atom_of(second)])
        pairs.append(both[(both >= 0).all(axis=1)])
        usual += [length] * len(pairs[-1])
    return np.concatenate(pairs), np.array(usual)


def _chains_to_judge(molecule: Molecule, atoms: np.ndarray) -> list[np.ndarray]:
    """Return the positions in a list of atoms of each chain that occurs often enough to be judged."""
    _, chain, count = np.unique(molecule.chain[atoms], return_inverse=True, return_counts=True)
    return [np.flatnonzero(chain == k) for k in np.flatnonzero(count >= MIN_ATOMS_TO_JUDGE)]


def _warn_of_odd_bonds(molecule: Molecule, path: str | os.PathLike[str]) -> None:
    """Warn of the backbone bond that differs most from its usual length, if by more than ODD_BOND."""
    pairs, usual = _backbone_bonds(molecule)
    a, b = pairs.T
    for begin in range(0, molecule.n_frames if len(a) else 0, FRAMES_AT_ONCE):
        xyz = molecule.xyz[begin : begin + FRAMES_AT_ONCE]
        ratio = np.linalg.norm(xyz[:, a] - xyz[:, b], axis=2) / usual
        frame, bond = np.unravel_index(np.abs(ratio - 1).argmax(), ratio.shape)
        if abs(ratio[frame, bond] - 1) > ODD_BOND:
            names = f"{molecule.name[a[bond]]}-{molecule.name[b[bond]]}"
            message = (
                "%s: the bond %s of %s is %.1f Å long instead of %.1f Å in frame %d; repair its coordinates"
            )
            length = ratio[frame, bond] * usual[bond]
            log.warning(
                message, path, names, residue_label(molecule, a[bond]), length, usual[bond], begin + frame
            )
            return


def _warn_of_stretched_chains(molecule: Molecule, path: str | os.PathLike[str]) -> None:
    """Warn if the bonds of a chain are longer or shorter along a direction than usual, in any frame."""
    pairs, usual = _backbone_bonds(molecule)
    for chain in _chains_to_judge(molecule, pairs[:, 0]):
        (a, b), long = pairs[chain].T, len(chain) >= MIN_BONDS_OF_LONG_CHAIN
        limit = STRETCH_TO_WARN if long else STRETCH_OF_SHORT_CHAIN
        for begin in range(0, molecule.n_frames, FRAMES_AT_ONCE):
            xyz = molecule.xyz[begin : begin + FRAMES_AT_ONCE]
            stretch = _stretch((xyz[:, a] - xyz[:, b]) / usual[chain][:, None])
            frame, axis = np.unravel_index(np.abs(stretch - 1).argmax(), stretch.shape)
            if abs(stretch[frame, axis] - 1) > limit:
                message = (
                    "%s: bonds of the chain of %s are %.2f times as long as usual along one direction in frame %d; "
                    "are all lengths in one unit?"
                )
                where = residue_label(molecule, a[0])
                log.warning(message, path, where, stretch[frame, axis], begin + frame)
                return


def _stretch(bonds: np.ndarray) -> np.ndarray:
    """Find how many times too long bonds are along three directions (F, 3).

    The symmetric matrix G with u G u = 1 for all bonds u is found by least squares; where no bond determines it, it is 1.

    Parameters
    ----------
    bonds : (F, n, 3) float, each divided by its usual length
    """
    ratio = np.linalg.norm(bonds, axis=2)
    x, y, z = np.moveaxis(
        np.where((ratio > 1 / MAX_RATIO) & (ratio < MAX_RATIO), 1.0, 0.0)[:, :, None] * bonds, 2, 0
    )
    terms = np.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z], axis=2)
    rest = np.where(x * x + y * y + z * z > 0, 1 - terms[:, :, :3].sum(axis=2), 0.0)
    square = terms.swapaxes(1, 2) @ terms + CERTAINTY * bonds.shape[1] * np.eye(6)
    solved = np.linalg.solve(square, terms.swapaxes(1, 2) @ rest[:, :, None])[:, :, 0]
    matrix = np.eye(3) + solved[:, [[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
    return 1 / np.sqrt(np.maximum(np.linalg.eigvalsh(matrix), 0.01))


def _warn_of_mirror_images(molecule: Molecule, path: str | os.PathLike[str]) -> None:
    """Warn if a chain is the mirror image of an L-peptide in any frame."""
    atom_of = _atoms_by_name(molecule)
    atoms = np.stack([atom_of(name) for name in ("N", "CA", "C", "CB")])
    atoms = atoms[:, (atoms >= 0).all(axis=0)]
    everything = np.arange(atoms.shape[1])
    chain_of = molecule.chain[atoms[1]]
    for residues in (everything, *(everything[chain_of == chain] for chain in np.unique(chain_of))):
        handed = np.empty((0, len(residues)), bool)  # of the first frame
        n, ca, c, cb = atoms[:, residues]
        for begin in range(0, molecule.n_frames if len(ca) >= MIN_RESIDUES_OF_MIRROR else 0, FRAMES_AT_ONCE):
            xyz = molecule.xyz[begin : begin + FRAMES_AT_ONCE]
            to_n, to_c, to_cb = (xyz[:, atom] - xyz[:, ca] for atom in (n, c, cb))
            left = (np.cross(to_n, to_c) * to_cb).sum(axis=2) >= 0
            handed = left[0] if begin == 0 else handed
            mirrored = (left != handed).mean(axis=1) > 0.5
            if len(ca) >= MIN_ATOMS_TO_JUDGE:
                mirrored |= left.mean(axis=1) < 0.5
            if mirrored.any():
                message = (
                    "%s: the chain of %s is a mirror image, of D-amino acids, in frame %d; "
                    "does an axis have the wrong sign?"
                )
                log.warning(message, path, residue_label(molecule, ca[0]), begin + int(mirrored.argmax()))
                return


def _warn_of_shared_places(molecule: Molecule, path: str | os.PathLike[str]) -> None:
    """Warn of residues and atoms of the first frame that overlap with another, and of atoms far from their residue."""
    xyz, index = molecule.xyz[0], molecule.residue_index
    ca = np.flatnonzero((molecule.name == "CA") & (molecule.kind == "protein"))
    twin = np.flatnonzero(np.linalg.norm(np.diff(xyz[ca], axis=0), axis=1) < SAME_RESIDUE)
    twin = twin[np.diff(index[ca])[twin] > 0]
    if len(twin):
        first, second = (residue_label(molecule, ca[k]) for k in (twin[0], twin[0] + 1))
        log.warning("%s: %s and %s lie in one place; keep one of them", path, first, second)
    heavy = np.flatnonzero(molecule.heavy)
    nearest = np.full(len(heavy), np.inf)
    same = np.empty((0, 2), int)
    for step in range(1, min(MAX_ATOMS_BETWEEN_BONDED, len(heavy))):
        a, b = heavy[:-step], heavy[step:]
        pair = np.flatnonzero(index[a] == index[b])
        if not len(pair):
            break
        length = np.linalg.norm(xyz[a[pair]] - xyz[b[pair]], axis=1)
        np.minimum.at(nearest, pair, length)
        np.minimum.at(nearest, pair + step, length)
        close = pair[(length < SAME_PLACE) & (molecule.name[a[pair]] != molecule.name[b[pair]])]
        same = np.concatenate([same, np.column_stack([heavy[close], heavy[close + step]])])
    if len(same):
        a, b = same[0]
        message = "%s: %s and %s of %s lie in one place (%s); repair its coordinates"
        count = pluralise(len(same), "such pair")
        log.warning(message, path, molecule.name[a], molecule.name[b], residue_label(molecule, a), count)
    present, expected = count_heavy_atoms(molecule.residue_name, index, molecule.element)
    complete = ((expected > 0) & (present == expected))[index[heavy]]
    lost = np.flatnonzero(complete & np.isfinite(nearest) & (nearest > LOST_ATOM))
    if len(lost):
        message = "%s: %s of %s lies %.1f Å from the nearest atom of its residue; repair its coordinates"
        atom = heavy[lost[0]]
        log.warning(message, path, molecule.name[atom], residue_label(molecule, atom), nearest[lost[0]])


def _warn_of_overlaps(molecule: Molecule, path: str | os.PathLike[str]) -> None:
    """Warn if heavy atoms of two residues lie in one place, in any frame: a wrong box, or one chain on top of another."""
    heavy = np.flatnonzero(molecule.heavy)
    if len(heavy) < MIN_ATOMS_TO_JUDGE:
        return
    index, names = molecule.residue_index[heavy], molecule.name[heavy]
    ca = names == "CA"
    twins = set(
        index[ca][1:][
            np.linalg.norm(np.diff(molecule.xyz[0][heavy][ca], axis=0), axis=1) < SAME_RESIDUE
        ].tolist()
    )
    for begin in range(0, molecule.n_frames, FRAMES_AT_ONCE):
        xyz = molecule.xyz[begin : begin + FRAMES_AT_ONCE, heavy]
        frame, a, b, distance = _pairs_in_cubes(xyz, index)
        keep = (distance < SAME_PLACE) & ~np.isin(index[a], [*twins]) & ~np.isin(index[b], [*twins])
        if keep.any():
            k = np.flatnonzero(keep)[0]
            message = "%s: %s of %s and %s of %s lie %.1f Å apart in frame %d; is the box right, or is a molecule there twice?"
            ends = (
                names[a[k]],
                residue_label(molecule, heavy[a[k]]),
                names[b[k]],
                residue_label(molecule, heavy[b[k]]),
            )
            log.warning(message, path, *ends, distance[k], begin + frame[k])
            return


def _pairs_in_cubes(
    xyz: np.ndarray, index: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Find most of the pairs of atoms of two residues that share a cube of CUBE, in one of two shifted grids.

    Parameters
    ----------
    xyz : (F, A, 3) float, Å
    index : (A,) int, residue of each atom

    Returns
    -------
    frame, a, b : (P,) int
    distance : (P,) float, Å
    """
    pairs = []
    for shift in (0.0, CUBE / 2):
        cube = np.floor((xyz + shift) / CUBE).astype(np.int64)
        cube -= cube.min(axis=1, keepdims=True)
        key = (cube[:, :, 0] << 42) | (cube[:, :, 1] << 21) | cube[:, :, 2]
        order = np.argsort(key, axis=1)
        key = np.take_along_axis(key, order, axis=1)
        for step in (1, 2, 3):
            frame, k = np.nonzero(key[:, step:] == key[:, :-step])
            a, b = order[frame, k], order[frame, k + step]
            other = index[a] != index[b]
            frame, a, b = frame[other], a[other], b[other]
            pairs.append((frame, a, b, np.linalg.norm(xyz[frame, a] - xyz[frame, b], axis=1)))
    frame, a, b, distance = (np.concatenate(parts) for parts in zip(*pairs, strict=True))
    return frame, a, b, distance


def _atoms_by_name(molecule: Molecule) -> Callable[[str], np.ndarray]:
    """Return a function that finds the atom of a name in each residue, (R,) int; -1 if there is none."""

    def atom_of(name: str) -> np.ndarray:
        """Find the atoms of one name."""
        index = np.full(molecule.residue_index.max() + 1, -1)
        atoms = np.flatnonzero(molecule.name == name)
        index[molecule.residue_index[atoms]] = atoms
        return index

    return atom_of


def _refuse_other_elements(molecule: Molecule, path: str | os.PathLike[str]) -> None:
    """Raise InputError if the elements of amino acids contradict the first letters of the atom names."""
    known = np.array([standard_name(name) in AMINO_ACIDS for name in molecule.residue_name])
    letters = [name.lstrip("0123456789'*")[:1].upper() for name in molecule.name]
    of_name = np.array([ELEMENT_OF_LETTER.get(letter, "") for letter in letters])
    element = np.where(molecule.element == "D", "H", molecule.element)
    wrong = known & (of_name != "") & (of_name != element) & (element != "SE")
    atom = int(np.argmax(wrong)) if wrong.any() else 0
    if known.sum() < MIN_ATOMS_TO_JUDGE or not wrong.any():
        return
    if wrong.sum() <= SHARE_TO_REPORT * known.sum():
        message = "%s: %s of %s has the element %s; %s an element that contradicts the name"
        count = pluralise(int(wrong.sum()), "atom") + (" has" if wrong.sum() == 1 else " have")
        log.warning(
            message, path, molecule.name[atom], residue_label(molecule, atom), molecule.element[atom], count
        )
    else:
        raise InputError(
            f"{path}: {molecule.name[atom]} of {residue_label(molecule, atom)} has the element {molecule.element[atom]}; "
            f"{wrong.sum()} atoms have an element that contradicts their name. Repair the elements or leave them blank."
        )


def _warn_of_doubts(
    molecule: Molecule, links: np.ndarray, distance: np.ndarray, path: str | os.PathLike[str]
) -> None:
    """Warn of what is possible but unlikely: one atom, overlapping copies, a broken chain."""
    xyz, index = molecule.xyz[0], molecule.residue_index
    if molecule.n_atoms == 1:
        log.warning("%s: a single atom is used; its surface is a sphere", path)
    sample = range(0, len(xyz), -(-len(xyz) // SAMPLED_ATOMS))
    close = [
        ((np.abs(xyz - xyz[k]).sum(axis=1) < 2 * CLASH) & (index != index[k])).nonzero()[0] for k in sample
    ]
    clashes = [
        (np.linalg.norm(xyz[near] - xyz[k], axis=1) < CLASH).any()
        for k, near in zip(sample, close, strict=True)
    ]
    if len(clashes) >= MIN_ATOMS_TO_JUDGE and np.mean(clashes) > SHARE_TO_REPORT:
        message = "%s: %.0f %% of its atoms lie inside other residues; does it hold a molecule twice?"
        log.warning(message, path, 100 * np.mean(clashes))
    broken = np.flatnonzero(distance >= PEPTIDE.max_length)
    if len(broken):
        a, b = links[broken[0]]
        message = "%s: %s missing, the first between %s and %s, %.1f Å apart"
        words = pluralise(len(broken), "peptide bond") + (" is" if len(broken) == 1 else " are")
        log.warning(
            message, path, words, residue_label(molecule, a), residue_label(molecule, b), distance[broken[0]]
        )


def residue_label(molecule: Molecule, atom: int) -> str:
    """Return the label of an atom's residue, as 'GLU 209 A'."""
    return f"{molecule.residue_name[atom]} {molecule.residue[atom]} {molecule.chain[atom]}".strip()
