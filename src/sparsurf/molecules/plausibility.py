"""Detect coordinates that cannot belong to a molecule: wrong units, another order of atoms, damaged numbers."""

from __future__ import annotations

import logging
import mmap
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.files import StrPath, pluralise
from sparsurf.molecules.residues import (
    AMINO_ACIDS,
    HEAVY_ATOMS,
    PEPTIDE,
    VARIANTS,
    atoms_of_residues,
    count_heavy_atoms,
    first_atoms,
    first_letters,
    split_label,
    standard_name,
)

if TYPE_CHECKING:
    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

MAX_ATOM_COORDINATE = 1e5  # Å; a larger one is a damaged number
MIN_NEIGHBOUR_DISTANCE = 0.5  # Å; half of the shortest bond, and more than any bond in nm
SAMPLED_ATOMS = 100  # The neighbours of so many atoms are examined.
MIN_ATOMS_TO_JUDGE = 10  # fewer may be half-occupied atoms
# Å, diagonal of the box around a residue of HEAVY_ATOMS; at most 13.7 in 230 structures and trajectories
MAX_RESIDUE_WIDTH = 20.0
MAX_MOLECULE_GAP = 500.0  # Å, between the parts of a molecule
MAX_PLAUSIBLE_BOND = 2.0  # Å, between heavy atoms of one residue (C-Br 1.95)
BROKEN_BOND = 3.0  # Å; bonds of simulations stay below 2.0
MAX_ATOMS_BETWEEN_BONDED = 40  # Bonded atoms are at most so far apart in the order of a residue's atoms.
# Share of atoms, or of peptide bonds, with a bonded neighbour; at least 0.98 in the same structures
MIN_BONDED_SHARE = 0.7
FRAMES_AT_ONCE, DISTANCES_AT_ONCE = 64, 16_000
# Å, bonds of backbones; half of them are within 2 % of these lengths in the same structures
USUAL_LENGTHS = {
    ("N", "CA"): 1.46, ("CA", "C"): 1.525, ("C", "O"): 1.23, ("C4'", "C3'"): 1.52, ("P", "O5'"): 1.59,
}  # fmt: skip
# Median deviation from these lengths that is refused, and that causes a warning: a morph between two conformations may
# have it. It is at most .015 in 300 structures, and .03 at 300 K.
DEVIATION_TO_REFUSE, DEVIATION_TO_WARN = 0.15, 0.04
ODD_BOND = 0.25  # deviation of one bond that causes a warning; of 671 structures one has a bond beyond .18
CLASH = 1.2  # Å; atoms of two residues are never that close, bonded or not
SAME_ATOM_PLACE = 0.5  # Å; two atoms are never that close
LOST_ATOM = 3.0  # Å, from the nearest atom of its residue
CUBE = 1.6  # Å, of a grid in which overlapping atoms are found
SHARE_TO_REPORT = 0.1  # An irregularity of a smaller share of the atoms is an odd detail of the structure.
# The element of an atom by the first letter of its name.
ELEMENT_OF_LETTER = dict(zip("HCNOSDhcnosd", "HCNOSHHCNOSH", strict=True))


class AtomCheck(NamedTuple):
    """A measure that a sound molecule keeps below a limit in every frame."""

    measure: Callable[[np.ndarray], np.ndarray]  # frames (F, A, 3), Å -> values (F, K) at K places
    limit: float  # a larger value is wrong
    # the sentence on a value, from the positions of its frame (A, 3), its place, itself, and ' in frame 3'
    tell: Callable[[np.ndarray, int, float, str], str]
    refuse: bool = True  # or warn


def refuse_impossible(
    molecule: Molecule, topology: StrPath | None = None, whole: bool = True, unit: str = "Å"
) -> None:
    """Raise InputError, with frame and atoms, if coordinates cannot belong to the molecule; warn of what is doubtful.

    `topology` is the file of the names, if it is another one than that of the coordinates; `whole` says that no molecule is
    cut by the box; `unit` is that of the lengths in the file.
    """
    refuse_crowded(molecule.xyz[0], unit)
    if not whole or not molecule.n_atoms:
        return
    _check_elements(molecule)
    order = f"and atoms in the order of {topology}" if topology else "or repair the file"
    checks = [*_checks(molecule, f"give lengths in {unit}, {order}", topology)]
    told: dict[int, str] = {}  # by the place of a check, in the order in which they count
    for begin, part in parts_of(molecule.xyz, FRAMES_AT_ONCE):
        for k, check in enumerate(checks):
            values = check.measure(part) if k not in told else np.zeros((1, 1))
            wrong = values > check.limit
            if wrong.any():
                frame = int(wrong.any(axis=1).argmax())
                place, number = int(values[frame].argmax()), int(molecule.frame_number[begin + frame])
                told[k] = check.tell(part[frame], place, float(values[frame, place]), f" in frame {number}")
    for k in sorted(told, key=lambda k: (not checks[k].refuse, k)):
        if checks[k].refuse:
            raise InputError(f"{FILE}: {told[k]}.")
        log.warning("%s: %s", FILE, told[k])


def parts_of(xyz: np.ndarray, n_frames: int) -> Iterator[tuple[int, np.ndarray]]:
    """Yield frames (F, A, 3) in parts, with the number of frames before each; those of a file leave the memory again."""
    for begin in range(0, len(xyz), n_frames):
        yield begin, np.array(xyz[begin : begin + n_frames])
        if isinstance(xyz, np.memmap):
            xyz._mmap.madvise(mmap.MADV_DONTNEED)  # type: ignore[attr-defined]


def _checks(molecule: Molecule, remedy: str, topology: StrPath | None) -> Iterator[AtomCheck]:
    """Yield what is checked, in the order in which it counts."""
    label, name, index = molecule.residue_label, molecule.name, molecule.residue_index
    first = np.array(molecule.xyz[0])
    start = np.flatnonzero(np.diff(index, prepend=-1))
    is_amino_acid = np.array(
        [standard_name(residue) in HEAVY_ATOMS for residue in molecule.residue_name[start]]
    )

    def in_first(value: float, sentence: str, refuse: bool = False) -> AtomCheck:
        return AtomCheck(lambda xyz: np.full((1, 1), float(value)), 0, lambda *_: sentence, refuse)

    def widths(xyz: np.ndarray) -> np.ndarray:
        box = np.maximum.reduceat(xyz, start, axis=1) - np.minimum.reduceat(xyz, start, axis=1)
        return np.where(is_amino_acid, np.linalg.norm(box, axis=2), 0)

    def too_wide(xyz: np.ndarray, k: int, width: float, frame: str) -> str:
        places = np.split(xyz, start[1:])[k]
        far = name[start[k] + np.linalg.norm(places - np.median(places, axis=0), axis=1).argmax()]
        return (
            f"{label(start[k])} is {width:.0f} Å wide{frame} (atom {far} is farthest out) instead of below "
            f"{MAX_RESIDUE_WIDTH:.0f} Å; {remedy}"
        )

    def gaps(xyz: np.ndarray) -> np.ndarray:
        extended = (np.ptp(xyz, axis=1) > MAX_MOLECULE_GAP).any(axis=1)
        return np.array(
            [[widest_gap(places)[0] if far else 0.0] for places, far in zip(xyz, extended, strict=True)]
        )

    def too_far(xyz: np.ndarray, _: int, gap: float, frame: str) -> str:
        atom = widest_gap(xyz)[1]
        return f"{name[atom]} of {label(atom)} lies {gap:.0f} Å from the other atoms{frame}; {remedy}"

    yield AtomCheck(widths, MAX_RESIDUE_WIDTH, too_wide)
    yield AtomCheck(gaps, MAX_MOLECULE_GAP, too_far)
    links = _peptide_links(molecule)
    length_of_links = np.linalg.norm(first[links[:, 0]] - first[links[:, 1]], axis=1)
    linked = length_of_links < PEPTIDE.max_length
    pairs, length, nearest = _pairs_in_residues(molecule, np.arange(molecule.n_atoms))
    polymer = np.isfinite(nearest) & np.isin(molecule.kind, ["protein", "nucleic"])
    bonded = nearest[polymer] < MAX_PLAUSIBLE_BOND, linked
    share = min((float(flags.mean()) for flags in bonded if len(flags) >= MIN_ATOMS_TO_JUDGE), default=1.0)
    again = f"give its atoms in the order of {topology}" if topology else "copy it again"
    sentence = f"only {100 * share:.0f} % of the bonds that its names imply exist in frame 0; {again}"
    yield in_first(share < MIN_BONDED_SHARE, sentence, refuse=True)
    yield from _checks_of_lengths(molecule, remedy)
    bonds = np.concatenate(
        [pairs[(length < MAX_PLAUSIBLE_BOND) & molecule.heavy[pairs].all(axis=1)], links[linked]]
    )

    def lengths(xyz: np.ndarray) -> np.ndarray:
        return np.linalg.norm(xyz[:, bonds[:, 0]] - xyz[:, bonds[:, 1]], axis=2)

    def broken(_: np.ndarray, k: int, length: float, frame: str) -> str:
        a, b = bonds[k]
        return f"the bond {name[a]}-{name[b]} of {label(a)} is {length:.1f} Å long{frame}; repair that frame or leave it out"

    yield AtomCheck(lengths, BROKEN_BOND, broken)
    yield in_first(molecule.n_atoms == 1, "a single atom is used; its surface is a sphere")
    share = _share_of_clashes(molecule)
    sentence = f"{100 * share:.0f} % of its atoms lie inside other residues; does it hold a molecule twice?"
    yield in_first(share > SHARE_TO_REPORT, sentence)
    if not linked.all():
        (a, b), counted = links[~linked][0], pluralise(int((~linked).sum()), "peptide bond", "is")
        first_of = "the first " if (~linked).sum() > 1 else ""
        apart = f"{length_of_links[~linked][0]:.1f} Å apart"
        yield in_first(1, f"{counted} missing, {first_of}between {label(a)} and {label(b)}, {apart}")
    present, expected = count_heavy_atoms(molecule.residue_name, index, molecule.element)
    complete = np.flatnonzero(((expected > 0) & (present == expected))[index] & molecule.heavy)
    nearest_heavy = _pairs_in_residues(molecule, np.flatnonzero(molecule.heavy))[2]
    lost = complete[np.isfinite(nearest_heavy[complete]) & (nearest_heavy[complete] > LOST_ATOM)]
    if len(lost):
        far = f"lies {nearest_heavy[lost[0]]:.1f} Å from the nearest atom of its residue; repair its coordinates"
        yield in_first(1, f"{name[lost[0]]} of {label(lost[0])} {far}")
    yield _check_of_shared_places(molecule)


def _checks_of_lengths(molecule: Molecule, remedy: str) -> Iterator[AtomCheck]:
    """Yield the checks of the bonds of the backbone: the median length in all chains and in each, and every single bond."""
    atom_of = {name: _atoms_named(molecule, name) for names in USUAL_LENGTHS for name in names}
    rows = [
        (atom_of[a], atom_of[b], np.full(len(atom_of[a]), usual)) for (a, b), usual in USUAL_LENGTHS.items()
    ]
    a, b, usual = (np.concatenate(column) for column in zip(*rows, strict=True))
    a, b, usual = (column[(a >= 0) & (b >= 0)] for column in (a, b, usual))
    _, chain, count = np.unique(molecule.chain[a], return_inverse=True, return_counts=True)
    chains = [np.flatnonzero(chain == k) for k in np.flatnonzero(count >= MIN_ATOMS_TO_JUDGE)]
    groups = [np.arange(len(a)), *chains]

    def ratios(xyz: np.ndarray) -> np.ndarray:
        return np.linalg.norm(xyz[:, a] - xyz[:, b], axis=2) / usual

    def deviations(xyz: np.ndarray) -> np.ndarray:
        off = np.abs(ratios(xyz) - 1)
        return np.stack([np.median(off[:, members], axis=1) for members in groups], axis=1)

    def too_long(xyz: np.ndarray, k: int, off: float, frame: str) -> str:
        ratio, residue = np.median(ratios(xyz[None])[0, groups[k]]), molecule.residue_label(a[groups[k][0]])
        return (
            f"bonds of {f'the chain of {residue}' if k else 'the backbone'} are {ratio:.2f} times as long as usual{frame}, and "
            f"half of them differ by {100 * off:.0f} % or more; {remedy}"
        )

    def unusual(_: np.ndarray, _k: int, off: float, frame: str) -> str:
        return f"half of the bonds of the backbone differ by {100 * off:.0f} % from their usual length{frame}"

    def odd(xyz: np.ndarray, k: int, _: float, frame: str) -> str:
        bond = f"the bond {molecule.name[a[k]]}-{molecule.name[b[k]]} of {molecule.residue_label(a[k])}"
        lengths = f"{ratios(xyz[None])[0, k] * usual[k]:.1f} Å long instead of {usual[k]:.1f} Å"
        return f"{bond} is {lengths}{frame}; repair its coordinates"

    if len(a) >= MIN_ATOMS_TO_JUDGE:
        yield AtomCheck(
            lambda xyz: (np.ptp(xyz, axis=1) == 0).any(axis=1)[:, None],
            0,
            lambda _xyz, _k, _n, frame: f"all atoms are in one plane{frame}; {remedy}",
        )
        yield AtomCheck(deviations, DEVIATION_TO_REFUSE, too_long)
        yield AtomCheck(lambda xyz: deviations(xyz)[:, :1], DEVIATION_TO_WARN, unusual, refuse=False)
    if len(a):
        yield AtomCheck(lambda xyz: np.abs(ratios(xyz) - 1), ODD_BOND, odd, refuse=False)


def _check_of_shared_places(molecule: Molecule) -> AtomCheck:
    """Return the check of heavy atoms that lie in one place, unless they have one name in one residue, which is told before."""
    heavy = np.flatnonzero(molecule.heavy)
    twin = molecule.residue_index[heavy] * 1_000_003 + np.unique(molecule.name[heavy], return_inverse=True)[1]

    def pairs(xyz: np.ndarray) -> tuple[np.ndarray, ...]:
        found = _pairs_in_cubes(xyz[:, heavy], twin)
        return tuple(column[found[3] < SAME_ATOM_PLACE] for column in found)

    def tell(xyz: np.ndarray, _k: int, _n: float, frame: str) -> str:
        _, a, b, distance = (column[0] for column in pairs(xyz[None]))
        first, second = (
            f"{molecule.name[atom]} of {molecule.residue_label(atom)}" for atom in (heavy[a], heavy[b])
        )
        return f"{first} and {second} lie {distance:.1f} Å apart{frame}; is the box right, or is a molecule there twice?"

    def counts(xyz: np.ndarray) -> np.ndarray:
        return np.bincount(pairs(xyz)[0], minlength=len(xyz))[:, None]

    return AtomCheck(counts, 0, tell, refuse=False)


def _share_of_clashes(molecule: Molecule) -> float:
    """Return the share of atoms that lie inside other residues in the first frame; 0 for few atoms."""
    index = molecule.residue_index
    inside: list[bool] = []
    for block, distance in _distances_of_sample(np.array(molecule.xyz[0])):
        inside += ((distance < CLASH) & (index != index[block, None])).any(axis=1).tolist()
    return float(np.mean(inside)) if len(inside) >= MIN_ATOMS_TO_JUDGE else 0.0


def refuse_invalid_coordinates(xyz: np.ndarray, number: np.ndarray) -> None:
    """Raise InputError if coordinates (F, A, 3), Å, of frames `number` (F,) are NaN, beyond MAX_ATOM_COORDINATE, or all equal."""
    bad = ~(np.abs(xyz) < MAX_ATOM_COORDINATE).all(axis=(1, 2))  # nan too
    if bad.any():
        raise InputError(
            f"{FILE} has coordinates that are not numbers or beyond {MAX_ATOM_COORDINATE:.0e} Å in frame "
            f"{number[bad.argmax()]}: repair or copy it again."
        )
    if xyz.shape[1] > 1 and (np.ptp(xyz, axis=1) == 0).all(axis=1).any():
        raise InputError(f"{FILE} has all atoms at one position: give a file with coordinates.")


def refuse_crowded(xyz: np.ndarray, unit: str = "Å", n_to_judge: int = MIN_ATOMS_TO_JUDGE) -> float:
    """Raise InputError if atoms (A, 3), Å, are closer than bonds allow; `n_to_judge` of them suffice to know.

    Return the usual distance of an atom from the nearest other one, 0 of fewer.
    """
    if min(len(xyz), SAMPLED_ATOMS) < n_to_judge:
        return 0.0
    nearest = [np.partition(distance, 1, axis=1)[:, 1] for _, distance in _distances_of_sample(xyz)]
    gap = float(np.median(np.concatenate(nearest)))
    if 0 < gap < MIN_NEIGHBOUR_DISTANCE:
        raise InputError(
            f"{FILE} has atoms {gap:.2f} Å apart, but bonds are 1 Å or longer: give lengths in {unit}."
        )
    return gap


def _distances_of_sample(xyz: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield about SAMPLED_ATOMS of atoms (A, 3), Å, in parts, with the distances (n, A) of all atoms from those of a part."""
    sampled = np.arange(0, len(xyz), -(-len(xyz) // SAMPLED_ATOMS))
    axes = np.ascontiguousarray(xyz.T)
    for block in np.array_split(sampled, min(len(sampled), 1 + len(sampled) * len(xyz) // DISTANCES_AT_ONCE)):
        yield block, np.sqrt(sum((axis - axis[block, None]) ** 2 for axis in axes))


def widest_gap(xyz: np.ndarray) -> tuple[float, int]:
    """Return the width of the widest slab across x, y or z without points (N, 3), and the point beside it on the emptier side."""
    if len(xyz) < 2:
        return 0.0, 0
    order = np.argsort(xyz, axis=0)
    gaps = np.diff(np.take_along_axis(xyz, order, axis=0), axis=0)
    before, axis = np.unravel_index(gaps.argmax(), gaps.shape)
    return float(gaps[before, axis]), int(order[before + (2 * (before + 1) >= len(xyz)), axis])


def _pairs_in_residues(molecule: Molecule, atoms: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find pairs (P, 2) of some atoms of one residue in the first frame, their distances, and the nearest of each atom (A,)."""
    axes, index = molecule.xyz[0][atoms].T, molecule.residue_index[atoms]
    behind = np.append(index, np.full(MAX_ATOMS_BETWEEN_BONDED - 1, -1))
    steps = np.lib.stride_tricks.sliding_window_view(behind, len(index))[1:]
    step, first = np.nonzero(steps == index)
    second = first + step + 1
    length = np.linalg.norm(axes[:, second] - axes[:, first], axis=0)
    nearest = np.full(molecule.n_atoms, np.inf)
    np.minimum.at(nearest, atoms[first], length)
    np.minimum.at(nearest, atoms[second], length)
    return np.column_stack([atoms[first], atoms[second]]), length, nearest


def _peptide_links(molecule: Molecule) -> np.ndarray:
    """Find C and N (L, 2) of residues of a chain whose numbers follow each other, or stand side by side with insertion codes."""
    first = first_atoms(molecule.residue_index)
    labels = [split_label(label) for label in molecule.residue[first].tolist()]
    number = np.array([int(digits or 0) for digits, _ in labels])
    order = np.lexsort([number, molecule.chain[first]])
    step, chain = np.diff(number[order]), molecule.chain[first][order]
    coded = np.array([bool(code) for _, code in labels])[order]
    last, start = (_atoms_named(molecule, name)[order] for name in (PEPTIDE.last, PEPTIDE.first))
    protein = (molecule.kind[first] == "protein")[order]
    follows = (step == 1) | ((step == 0) & (coded[1:] | coded[:-1]))
    follows &= (chain[1:] == chain[:-1]) & (last[:-1] >= 0) & (start[1:] >= 0) & protein[1:] & protein[:-1]
    return np.column_stack([last[:-1], start[1:]])[follows]


def _pairs_in_cubes(
    xyz: np.ndarray, index: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Find most pairs of atoms of two residues in frames (F, A, 3) that share a cube of CUBE: frame, both atoms, distance, Å.

    The cubes are those of two shifted grids.
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


def _atoms_named(molecule: Molecule, name: str) -> np.ndarray:
    """Find the atom of a name in each residue, (R,) int; -1 if there is none."""
    index = molecule.residue_index
    return atoms_of_residues(index, molecule.name == name, index.max() + 1)


def _check_elements(molecule: Molecule) -> None:
    """Raise InputError if the elements of amino acids contradict the first letters of the atom names."""
    is_amino_acid = np.isin(molecule.residue_name, [*AMINO_ACIDS, *VARIANTS])
    of_name = np.array(
        [ELEMENT_OF_LETTER.get(letter, "") for letter in first_letters(molecule.name).tolist()]
    )
    element = np.where(molecule.element == "D", "H", molecule.element)
    wrong = is_amino_acid & (of_name != "") & (of_name != element) & (element != "SE")
    atom = int(np.argmax(wrong)) if wrong.any() else 0
    if is_amino_acid.sum() < MIN_ATOMS_TO_JUDGE or not wrong.any():
        return
    if wrong.sum() <= SHARE_TO_REPORT * is_amino_acid.sum():
        message = "%s: %s of %s has the element %s; %s an element that contradicts the name"
        count = pluralise(int(wrong.sum()), "atom", "has")
        log.warning(
            message, FILE, molecule.name[atom], molecule.residue_label(atom), molecule.element[atom], count
        )
    else:
        raise InputError(
            f"{FILE}: {molecule.name[atom]} of {molecule.residue_label(atom)} has the element {molecule.element[atom]}; "
            f"{wrong.sum()} atoms have an element that contradicts their name. Repair the elements or leave them blank."
        )
