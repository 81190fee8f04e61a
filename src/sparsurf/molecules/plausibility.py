"""Detect coordinates that cannot belong to a molecule: wrong units, another order of atoms, damaged numbers.

What is measured stands in a table of checks (`_checks`), in the order in which they count. One loop over the frames feeds
all of them.
"""

from __future__ import annotations

import logging
import mmap
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

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
    first_letters,
    split_label,
    standard_name,
)

if TYPE_CHECKING:
    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

MAX_ATOM_COORDINATE = 1e5  # Å; a larger one is a damaged number
MIN_NEIGHBOUR_DISTANCE = 0.5  # Å; half of the shortest bond, and more than any bond in nm
SAMPLED_ATOMS = 100  # whose neighbours are examined
MIN_ATOMS_TO_JUDGE = 10  # fewer may be half-occupied atoms
# Å, diagonal of the box around a residue of HEAVY_ATOMS; at most 13.7 in 230 structures and trajectories
MAX_RESIDUE_WIDTH = 20.0
MAX_MOLECULE_GAP = 500.0  # Å, between the parts of a molecule
MAX_PLAUSIBLE_BOND = 2.0  # Å, between heavy atoms of one residue (C-Br 1.95)
BROKEN_BOND = 3.0  # Å; bonds of simulations stay below 2.0
MAX_ATOMS_BETWEEN_BONDED = 40  # in the order of a residue's atoms
# Share of atoms, or of peptide bonds, with a bonded neighbour; at least 0.98 in the same structures
MIN_BONDED_SHARE = 0.7
FRAMES_AT_ONCE, DISTANCES_AT_ONCE = 64, 16_000
# Å, bonds of backbones: both atoms, and the step to the residue of the second; half of them are within 2 % of these
# lengths in the same structures
USUAL_LENGTHS = {
    ("N", "CA", 0): 1.46, ("CA", "C", 0): 1.525, ("C", "O", 0): 1.23, ("C4'", "C3'", 0): 1.52, ("P", "O5'", 0): 1.59,
}  # fmt: skip
# Median deviation from these lengths that is refused, and that causes a warning: a morph between two conformations may
# have it. It is at most .015 in 300 structures, and .03 at 300 K.
DEVIATION_TO_REFUSE, DEVIATION_TO_WARN = 0.15, 0.04
ODD_BOND = 0.25  # deviation of one bond that causes a warning; of 671 structures one has a bond beyond .18
CLASH = 1.2  # Å; atoms of two residues are never that close, bonded or not
# Å, the same for distances along a chain that depend on bonds and their angles
USUAL_DISTANCES = {
    ("N", "CA", 0): 1.459, ("CA", "C", 0): 1.525, ("C", "O", 0): 1.232, ("C", "N", 1): 1.331, ("N", "C", 0): 2.463,
    ("CA", "O", 0): 2.399, ("CA", "N", 1): 2.432, ("O", "N", 1): 2.251, ("C", "CA", 1): 2.437, ("CA", "CB", 0): 1.532,
    ("N", "CB", 0): 2.458, ("C", "CB", 0): 2.507,
}  # fmt: skip
# Deviation of a chain's bonds from their usual length along any direction that causes a warning. It is at most .03 in 700
# structures and trajectories; fewer bonds than MIN_BONDS_OF_LONG_CHAIN vary more.
STRETCH_TO_WARN, STRETCH_OF_SHORT_CHAIN, MIN_BONDS_OF_LONG_CHAIN = 0.05, 0.09, 40
# Of the distances of a chain along one direction to those along another that causes a warning: at most .025 in 1,065 chains
# of about eight residues or more, at least .034 if one axis is 5 % longer
SKEW_TO_WARN, MIN_DISTANCES = 0.033, 90
MIN_DISTANCES_OF_FRAMES = 200  # fewer vary more at 300 K: at most .029 in 1,100 frames of such chains
NEAR_AXIS = 0.95  # cosine of a direction with an axis that is then named
CERTAINTY = 0.02  # weight, per bond, of the usual lengths in directions that no bond has
MAX_RATIO = 1.6  # of a bond's length to its usual length, or the reverse; bonds beyond are ignored when stretch is estimated
MIN_RESIDUES_OF_MIRROR = 3  # of a chain whose handedness is compared with that of the first frame
SAME_ATOM_PLACE = 0.5  # Å; two atoms are never that close
SAME_RESIDUE = 1.0  # Å; C-alpha atoms of neighbours are 2.8 Å apart at least
LOST_ATOM = 3.0  # Å, from the nearest atom of its residue
CUBE = 1.6  # Å, of a grid in which overlapping atoms are found
SHARE_TO_REPORT = 0.1  # of atoms; below it, an irregularity is an odd detail of the structure
NO_ATOMS = np.empty((1, 0), int)
ELEMENT_OF_LETTER = dict(zip("HCNOSDhcnosd", "HCNOSHHCNOSH", strict=True))  # by the first letter of a name


class Finding(NamedTuple):
    """Where a check found something wrong: number of the frame, its positions (A, 3), the place there, and the value."""

    frame: int
    xyz: np.ndarray
    place: int
    value: float


class AtomCheck(NamedTuple):
    """A measure that a sound molecule keeps below a limit.

    `sentence` has {value}, {frame}, names {a} and {b} of atoms and {A} and {B} of their residues, and what
    `further_values` returns.
    """

    measure: Callable[[np.ndarray], np.ndarray]  # frames (F, A, 3), Å -> values (F, K) at K places
    limit: float  # a larger value is wrong
    sentence: str
    atoms: np.ndarray | Callable[[Finding], Sequence[int]] = NO_ATOMS  # (K, n) int, one or two of each place
    refuse: bool = False  # or warn
    first: bool = False  # only the first frame is measured
    worst: bool = True  # the place of the largest value is named, or else the first one
    further_values: Callable[[Finding], dict[str, Any]] = lambda found: {}


def refuse_impossible(
    molecule: Molecule,
    topology: StrPath | None = None,
    whole: bool = True,
    unit: str = "Å",
) -> None:
    """Raise InputError, with frame and atoms, if coordinates cannot belong to the molecule; warn of what is doubtful.

    `topology` is the file of the names, if it is another one than that of the coordinates; `whole` says that no molecule is
    cut by the box; `unit` is that of the lengths in the file.
    """
    refuse_crowded(molecule.xyz[0], unit)
    if whole and molecule.n_atoms:
        _check_elements(molecule)
        _run([*_checks(molecule, unit, topology)], molecule)


def _run(checks: list[AtomCheck], molecule: Molecule) -> None:
    """Measure all frames; raise InputError by the first check that refuses, warn by the others."""
    findings: dict[int, Finding] = {}
    for begin, part in parts_of(molecule.xyz, FRAMES_AT_ONCE):
        for k, check in enumerate(checks):
            if k in findings or (check.first and begin):
                continue
            values = check.measure(part[:1] if check.first else part)
            wrong = values > check.limit
            if wrong.any():
                frame = int(wrong.any(axis=1).argmax())
                place = int((values if check.worst else wrong)[frame].argmax())
                number = int(molecule.frame_number[begin + frame])
                findings[k] = Finding(number, part[frame], place, float(values[frame, place]))
    for k, found in sorted(findings.items()):
        check = checks[k]
        atoms = check.atoms(found) if callable(check.atoms) else check.atoms[found.place]
        names = dict(zip("ab", (molecule.name[atom] for atom in atoms), strict=False))
        names |= dict(zip("AB", (molecule.residue_label(atom) for atom in atoms), strict=False))
        named_values = {"value": found.value, "frame": found.frame} | names | check.further_values(found)
        if check.refuse:
            raise InputError(f"{FILE}: {check.sentence.format(**named_values)}.")
        log.warning("%s: %s", FILE, check.sentence.format(**named_values))


def parts_of(xyz: np.ndarray, n_frames: int) -> Iterator[tuple[int, np.ndarray]]:
    """Yield frames (F, A, 3) in parts, with the number of frames before each; those of a file leave the memory again."""
    for begin in range(0, len(xyz), n_frames):
        yield begin, np.array(xyz[begin : begin + n_frames])
        if isinstance(xyz, np.memmap):
            xyz._mmap.madvise(mmap.MADV_DONTNEED)  # type: ignore[attr-defined]


def _checks(molecule: Molecule, unit: str, topology: StrPath | None) -> Iterator[AtomCheck]:
    """Yield what is checked, in the order in which it counts."""
    order = f"and atoms in the order of {topology}" if topology else "or repair the file"
    remedy = f"give lengths in {unit}, {order}".replace("{", "{{").replace("}", "}}")
    yield from _checks_of_places(molecule, remedy)
    links, distance = _peptide_bonds(molecule)
    bonds, bonded_share = _bonds(molecule, links, distance < PEPTIDE.max_length)
    again = order.removeprefix("and ").replace("atoms", "give its atoms") if topology else "copy it again"
    yield _in_first(
        1 - bonded_share,
        1 - MIN_BONDED_SHARE,
        f"only {100 * bonded_share:.0f} % of the bonds that its names imply exist in frame 0; {again}",
        refuse=True,
    )
    yield from _checks_of_lengths(molecule, remedy)
    yield AtomCheck(
        lambda xyz: np.linalg.norm(xyz[:, bonds[:, 0]] - xyz[:, bonds[:, 1]], axis=2),
        BROKEN_BOND,
        "the bond {a}-{b} of {A} is {value:.1f} Å long in frame {frame}; repair that frame or leave it out",
        bonds,
        refuse=True,
    )
    yield _in_first(molecule.n_atoms == 1, 0, "a single atom is used; its surface is a sphere")
    yield _in_first(
        100 * _share_of_clashes(molecule),
        100 * SHARE_TO_REPORT,
        "{value:.0f} % of its atoms lie inside other residues; does it hold a molecule twice?",
    )
    broken = np.flatnonzero(distance >= PEPTIDE.max_length)
    counted, first = pluralise(len(broken), "peptide bond", "is"), "the first " if len(broken) > 1 else ""
    far = f"{distance[broken[0]]:.1f} Å apart" if len(broken) else ""
    yield _in_first(
        len(broken), 0, f"{counted} missing, {first}between {{A}} and {{B}}, {far}", links[broken[:1]]
    )
    yield from _checks_of_bonds(molecule)
    yield from _checks_of_handedness(molecule)
    yield from _checks_of_shared_places(molecule)


def _in_first(
    value: float, limit: float, sentence: str, atoms: np.ndarray = NO_ATOMS, refuse: bool = False
) -> AtomCheck:
    """Return the check of a value of the first frame that is measured already."""
    return AtomCheck(lambda xyz: np.full((1, 1), float(value)), limit, sentence, atoms, refuse, first=True)


def _checks_of_places(molecule: Molecule, remedy: str) -> Iterator[AtomCheck]:
    """Yield the checks of residues that are too wide, and of parts that are too far away."""
    start = np.flatnonzero(np.diff(molecule.residue_index, prepend=-1))
    is_amino_acid = np.array([standard_name(name) in HEAVY_ATOMS for name in molecule.residue_name[start]])

    def extents(xyz: np.ndarray) -> np.ndarray:
        box = np.maximum.reduceat(xyz, start, axis=1) - np.minimum.reduceat(xyz, start, axis=1)
        return np.where(is_amino_acid, np.linalg.norm(box, axis=2), 0)

    def farthest(found: Finding) -> list[int]:
        xyz = np.split(found.xyz, start[1:])[found.place]
        return [start[found.place] + np.linalg.norm(xyz - np.median(xyz, axis=0), axis=1).argmax()]

    def gaps(xyz: np.ndarray) -> np.ndarray:
        extended = (np.ptp(xyz, axis=1) > MAX_MOLECULE_GAP).any(axis=1)
        pairs = zip(xyz, extended, strict=True)
        return np.array([[widest_gap(frame)[0] if far else 0.0] for frame, far in pairs])

    yield AtomCheck(
        extents,
        MAX_RESIDUE_WIDTH,
        "{A} is {value:.0f} Å wide in frame {frame} (atom {a} is farthest out) instead of below "
        f"{MAX_RESIDUE_WIDTH:.0f} Å; {remedy}",
        farthest,
        refuse=True,
        worst=False,
    )
    sentence = "{a} of {A} lies {value:.0f} Å from the other atoms in frame {frame}; " + remedy
    yield AtomCheck(gaps, MAX_MOLECULE_GAP, sentence, lambda found: [widest_gap(found.xyz)[1]], refuse=True)


def _checks_of_lengths(molecule: Molecule, remedy: str) -> Iterator[AtomCheck]:
    """Yield the checks of the median length of the bonds of the backbone, of all chains and of each of several."""
    pairs, usual = _pairs_of(molecule, USUAL_LENGTHS)
    a, b = pairs.T
    if len(a) < MIN_ATOMS_TO_JUDGE:
        return
    chains = _chains_to_judge(molecule, a)

    def ratios(xyz: np.ndarray) -> np.ndarray:
        return np.linalg.norm(xyz[:, a] - xyz[:, b], axis=2) / usual

    def deviations(xyz: np.ndarray) -> np.ndarray:
        return np.median(np.abs(ratios(xyz) - 1), axis=1)[:, None]

    def of_chains(xyz: np.ndarray) -> np.ndarray:  # of several, one may be odd
        ratio = np.abs(ratios(xyz) - 1)
        medians = np.stack([np.median(ratio[:, chain], axis=1) for chain in chains], axis=1)
        return np.where(np.median(ratio, axis=1)[:, None] > DEVIATION_TO_REFUSE, 0, medians)

    def ratio_of_chain(found: Finding) -> dict[str, Any]:
        return {"ratio": np.median(ratios(found.xyz[None])[0, chains[found.place]])}

    flat = f"all atoms are in one plane in frame {{frame}}; {remedy}"
    yield AtomCheck(lambda xyz: (np.ptp(xyz, axis=1) == 0).any(axis=1)[:, None], 0, flat, refuse=True)
    if len(chains) > 1:
        yield AtomCheck(
            of_chains,
            DEVIATION_TO_REFUSE,
            f"bonds of the chain of {{A}} are {{ratio:.2f}} times as long as usual in frame {{frame}}; {remedy}",
            np.array([a[chain[:1]] for chain in chains]),
            refuse=True,
            further_values=ratio_of_chain,
        )
    yield AtomCheck(
        deviations,
        DEVIATION_TO_REFUSE,
        "bonds of the backbone are {ratio:.2f} times as long as usual in frame {frame}, and half of them differ by "
        f"{{percent:.0f}} % or more; {remedy}",
        refuse=True,
        further_values=lambda found: {
            "ratio": np.median(ratios(found.xyz[None])),
            "percent": 100 * found.value,
        },
    )
    yield AtomCheck(
        lambda xyz: 100 * deviations(xyz),
        100 * DEVIATION_TO_WARN,
        "half of the bonds of the backbone differ by {value:.0f} % from their usual length in frame {frame}",
    )


def _checks_of_bonds(molecule: Molecule) -> Iterator[AtomCheck]:
    """Yield the checks of single bonds of the backbone, and of the bonds of a chain along any direction."""
    pairs, usual = _pairs_of(molecule, USUAL_LENGTHS)
    a, b = pairs.T
    if not len(a):
        return

    def lengths(xyz: np.ndarray) -> np.ndarray:
        return np.linalg.norm(xyz[:, a] - xyz[:, b], axis=2)

    yield AtomCheck(
        lambda xyz: np.abs(lengths(xyz) / usual - 1),
        ODD_BOND,
        "the bond {a}-{b} of {A} is {length:.1f} Å long instead of {usual:.1f} Å in frame {frame}; repair its coordinates",
        pairs,
        further_values=lambda found: {
            "length": lengths(found.xyz[None])[0, found.place],
            "usual": usual[found.place],
        },
    )
    for chain in _chains_to_judge(molecule, a):
        yield _check_of_stretch(pairs[chain], usual[chain])
    far, apart = _pairs_of(molecule, USUAL_DISTANCES)
    for chain in _chains_to_judge(molecule, far[:, 0], MIN_DISTANCES):
        yield from _checks_of_skew(molecule, far[chain], apart[chain])


def _check_of_stretch(pairs: np.ndarray, usual: np.ndarray) -> AtomCheck:
    """Return the check of the bonds (L, 2) of one chain along the direction where they differ most from their usual length."""
    return AtomCheck(
        lambda xyz: np.abs(_stretch(xyz, pairs, usual)[0] - 1),
        STRETCH_TO_WARN if len(pairs) >= MIN_BONDS_OF_LONG_CHAIN else STRETCH_OF_SHORT_CHAIN,
        "bonds of the chain of {A} are {ratio:.2f} times as long as usual along one direction in frame {frame}; "
        "are all lengths in one unit?",
        lambda found: [int(pairs[0, 0])],
        further_values=lambda found: {"ratio": _stretch(found.xyz[None], pairs, usual)[0][0, found.place]},
    )


def _checks_of_skew(molecule: Molecule, pairs: np.ndarray, usual: np.ndarray) -> Iterator[AtomCheck]:
    """Yield the checks of the distances (L, 2) of one chain along one direction against those along another.

    Of later frames, whose bonds vary, only an axis counts, and only in long chains.
    """

    def skew(xyz: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return how much longer bonds are along one direction (F, 1), whether the odd one is longer, and its axis."""
        values, axes = _stretch(xyz, pairs, usual)
        from_median = values - np.median(values, axis=1, keepdims=True)
        odd = np.abs(from_median).argmax(axis=1)
        frames = np.arange(len(odd))
        size = np.abs(axes[frames, :, odd])
        axis = np.where(size.max(axis=1) > NEAR_AXIS, size.argmax(axis=1), 3)
        return (values.max(axis=1) / values.min(axis=1) - 1)[:, None], from_median[frames, odd] > 0, axis

    def along_axes(xyz: np.ndarray) -> np.ndarray:
        values, _, axis = skew(xyz)
        return np.where(axis[:, None] < 3, values, 0)

    def skew_in_words(found: Finding) -> dict[str, Any]:
        _, longer, axis = skew(found.xyz[None])
        return {
            "percent": 100 * found.value,
            "longer": "longer" if longer[0] else "shorter",
            "axis": ("x", "y", "z", "one direction")[axis[0]],
        }

    check = AtomCheck(
        lambda xyz: skew(xyz)[0],
        SKEW_TO_WARN,
        "bonds of the chain of {A} are {percent:.0f} % {longer} along {axis} than across it in frame {frame}; "
        "are all lengths in one unit?",
        lambda found: [int(pairs[0, 0])],
        first=True,
        further_values=skew_in_words,
    )
    yield check
    several = molecule.n_frames > 1 and len(pairs) >= MIN_DISTANCES_OF_FRAMES
    if several and skew(np.array(molecule.xyz[:1]))[0] <= SKEW_TO_WARN:
        yield check._replace(measure=along_axes, first=False)


def _checks_of_handedness(molecule: Molecule) -> Iterator[AtomCheck]:
    """Yield the check of all residues, and of each chain, for being the mirror image of an L-peptide."""
    atoms = np.stack([_atoms_named(molecule, name) for name in ("N", "CA", "C", "CB")])
    atoms = atoms[:, (atoms >= 0).all(axis=0)]
    chain_of = molecule.chain[atoms[1]]
    everything = np.arange(atoms.shape[1])
    groups = [everything, *(everything[chain_of == chain] for chain in np.unique(chain_of))]
    groups = [group for group in groups if len(group) >= MIN_RESIDUES_OF_MIRROR]

    def left_handed(xyz: np.ndarray) -> np.ndarray:
        n, ca, c, cb = (xyz[:, members] for members in atoms)
        return (np.cross(n - ca, c - ca) * (cb - ca)).sum(axis=2) >= 0

    def mirrored(xyz: np.ndarray) -> np.ndarray:
        left = left_handed(xyz)
        changed = [(left[:, group] != first[group]).mean(axis=1) > 0.5 for group in groups]
        odd = [(left[:, group].mean(axis=1) < 0.5) & (len(group) >= MIN_ATOMS_TO_JUDGE) for group in groups]
        return np.stack([a | b for a, b in zip(changed, odd, strict=True)], axis=1)

    if groups:
        first = left_handed(np.array(molecule.xyz[:1]))[0]
        sentence = "the chain of {A} is a mirror image, of D-amino acids, in frame {frame}; does an axis have the wrong sign?"
        ends = np.array([atoms[1, group[:1]] for group in groups])
        yield AtomCheck(mirrored, 0, sentence, ends, worst=False)


def _share_of_clashes(molecule: Molecule) -> float:
    """Return the share of atoms that lie inside other residues in the first frame; 0 for few atoms."""
    index = molecule.residue_index
    inside: list[bool] = []
    for block, distance in _distances_of_sample(np.array(molecule.xyz[0])):
        inside += ((distance < CLASH) & (index != index[block, None])).any(axis=1).tolist()
    return float(np.mean(inside)) if len(inside) >= MIN_ATOMS_TO_JUDGE else 0.0


def _checks_of_shared_places(molecule: Molecule) -> Iterator[AtomCheck]:
    """Yield the checks of residues and atoms that lie in one place, and of atoms far from their residue."""
    index, first = molecule.residue_index, np.array(molecule.xyz[0])
    ca = np.flatnonzero((molecule.name == "CA") & (molecule.kind == "protein"))
    step = np.linalg.norm(np.diff(first[ca], axis=0), axis=1)
    twins = np.flatnonzero((step < SAME_RESIDUE) & (np.diff(index[ca]) > 0))[:1]
    heavy = np.flatnonzero(molecule.heavy)
    pairs, length, nearest = _pairs_in_residues(molecule, heavy)
    names = molecule.name[pairs]
    coinciding = pairs[(length < SAME_ATOM_PLACE) & (names[:, 0] != names[:, 1])]
    present, expected = count_heavy_atoms(molecule.residue_name, index, molecule.element)
    complete = ((expected > 0) & (present == expected))[index[heavy]]
    lost = np.flatnonzero(complete & np.isfinite(nearest) & (nearest > LOST_ATOM))[:1]
    left_out = np.unique(index[ca[1:]][step < SAME_RESIDUE])

    def overlaps(xyz: np.ndarray) -> tuple[np.ndarray, ...]:
        """Find pairs of atoms of two residues in one place: frame, both atoms, and distance."""
        frame, a, b, distance = _pairs_in_cubes(xyz[:, heavy], index[heavy])
        a, b = heavy[a], heavy[b]
        keep = (distance < SAME_ATOM_PLACE) & ~np.isin(index[a], left_out) & ~np.isin(index[b], left_out)
        return frame[keep], a[keep], b[keep], distance[keep]

    yield _in_first(
        len(twins),
        0,
        "{A} and {B} lie in one place; keep one of them",
        np.column_stack([ca[twins], ca[twins + 1]]),
    )
    several = pluralise(len(coinciding), "such pair")
    yield _in_first(
        len(coinciding),
        0,
        f"{{a}} and {{b}} of {{A}} lie in one place ({several}); repair its coordinates",
        coinciding,
    )
    far = f"lies {nearest[lost[0]]:.1f} Å from the nearest atom of its residue" if len(lost) else ""
    yield _in_first(len(lost), 0, f"{{a}} of {{A}} {far}; repair its coordinates", heavy[lost][:, None])
    if len(heavy) >= MIN_ATOMS_TO_JUDGE:
        yield AtomCheck(
            lambda xyz: np.bincount(overlaps(xyz)[0], minlength=len(xyz))[:, None],
            0,
            "{a} of {A} and {b} of {B} lie {distance:.1f} Å apart in frame {frame}; is the box right, or is a molecule there "
            "twice?",
            lambda found: [int(atoms[0]) for atoms in overlaps(found.xyz[None])[1:3]],
            further_values=lambda found: {"distance": overlaps(found.xyz[None])[3][0]},
        )


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


def _bonds(molecule: Molecule, links: np.ndarray, linked: np.ndarray) -> tuple[np.ndarray, float]:
    """Find the bonds of the first frame, and the share of atoms or peptide bonds that are bonded, whichever is lower.

    A bond (L, 2) joins heavy atoms of a residue closer than MAX_PLAUSIBLE_BOND, or is one of the `links` (P, 2) between residues
    that are `linked` (P,).
    """
    pairs, length, nearest = _pairs_in_residues(molecule, np.arange(molecule.n_atoms))
    bonds = pairs[(length < MAX_PLAUSIBLE_BOND) & molecule.heavy[pairs].all(axis=1)]
    polymer = np.isfinite(nearest) & np.isin(molecule.kind, ["protein", "nucleic"])
    bonded_lists = nearest[polymer] < MAX_PLAUSIBLE_BOND, linked
    shares = [float(bonded.mean()) for bonded in bonded_lists if len(bonded) >= MIN_ATOMS_TO_JUDGE]
    return np.concatenate([bonds, links[linked]]), min(shares, default=1.0)


def _pairs_in_residues(molecule: Molecule, atoms: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find pairs (P, 2) of some atoms (n,) of one residue in the first frame, their distances, and each atom's nearest (n,)."""
    axes, index = molecule.xyz[0][atoms].T, molecule.residue_index[atoms]
    behind = np.append(index, np.full(MAX_ATOMS_BETWEEN_BONDED - 1, -1))
    steps = np.lib.stride_tricks.sliding_window_view(behind, len(atoms))[1:]
    step, first = np.nonzero(steps == index)
    second = first + step + 1
    length = np.linalg.norm(axes[:, second] - axes[:, first], axis=0)
    nearest = np.full(len(atoms), np.inf)
    np.minimum.at(nearest, first, length)
    np.minimum.at(nearest, second, length)
    return np.column_stack([atoms[first], atoms[second]]), length, nearest


def _peptide_bonds(molecule: Molecule) -> tuple[np.ndarray, np.ndarray]:
    """Find C and N (L, 2) of residues that follow each other in a chain, and their distance in the first frame.

    They have consecutive numbers, or stand next to each other where one has an insertion code: these may be in any order.
    """
    ends: dict[str, dict[tuple[str, int], int]] = {PEPTIDE.last: {}, PEPTIDE.first: {}}
    first = np.unique(molecule.residue_index, return_index=True)[1]
    chains, labels = (
        molecule.chain[first].tolist(),
        [split_label(label) for label in molecule.residue[first].tolist()],
    )
    places = [(chain, int(number or 0)) for chain, (number, _) in zip(chains, labels, strict=True)]
    coded = {place for place, (_, code) in zip(places, labels, strict=True) if code}
    found = np.flatnonzero(np.isin(molecule.name, [*ends]) & (molecule.kind == "protein"))
    columns = found, molecule.residue_index[found], molecule.name[found]
    for atom, residue, name in zip(*(column.tolist() for column in columns), strict=True):
        place = places[residue]
        # a cap may have the number of the residue that it ends: its C comes before, its N behind
        if labels[residue][0] and place not in coded and (
            name == PEPTIDE.last or place not in ends[PEPTIDE.first]
        ):  # fmt: skip
            ends[name][place] = atom
    starts = ends[PEPTIDE.first]
    pairs = [
        (atom, starts[chain, number + 1])
        for (chain, number), atom in ends[PEPTIDE.last].items()
        if (chain, number + 1) in starts
    ]
    if coded:
        last, next_first = (_atoms_named(molecule, name).tolist() for name in (PEPTIDE.last, PEPTIDE.first))
        ca = _atoms_named(molecule, "CA")
        for k, (a, b) in enumerate(pairwise(places)):
            are_neighbours = a[0] == b[0] and (a in coded or b in coded) and abs(b[1] - a[1]) <= 1
            atoms = last[k], next_first[k + 1]
            apart = np.linalg.norm(molecule.xyz[0][ca[k + 1]] - molecule.xyz[0][ca[k]]) > SAME_RESIDUE
            if are_neighbours and apart and min(atoms) >= 0 and (molecule.kind[[*atoms]] == "protein").all():
                pairs.append(atoms)
    links = np.array(pairs, int).reshape(-1, 2)
    return links, np.linalg.norm(molecule.xyz[0][links[:, 0]] - molecule.xyz[0][links[:, 1]], axis=1)


def _pairs_of(
    molecule: Molecule, lengths: dict[tuple[str, str, int], float]
) -> tuple[np.ndarray, np.ndarray]:
    """Find the pairs of atoms (L, 2) of a table in residues that are the same or bonded, and their usual lengths (L,)."""
    names = {name for a, b, _ in lengths for name in (a, b)} | {PEPTIDE.last, PEPTIDE.first}
    atom_of = {name: _atoms_named(molecule, name) for name in names}
    last, first = atom_of[PEPTIDE.last][:-1], atom_of[PEPTIDE.first][1:]
    bonded = np.linalg.norm(molecule.xyz[0][last] - molecule.xyz[0][first], axis=1) < PEPTIDE.max_length
    bonded &= (last >= 0) & (first >= 0)
    pairs, usual = [np.empty((0, 2), int)], list[float]()
    for (a, b, step), length in lengths.items():
        atom_pairs = np.column_stack([atom_of[a][:-1], atom_of[b][1:]] if step else [atom_of[a], atom_of[b]])
        pairs.append(atom_pairs[(atom_pairs >= 0).all(axis=1) & (bonded if step else True)])
        usual += [length] * len(pairs[-1])
    return np.concatenate(pairs), np.array(usual)


def _chains_to_judge(
    molecule: Molecule, atoms: np.ndarray, least: int = MIN_ATOMS_TO_JUDGE
) -> list[np.ndarray]:
    """Return the positions in a list of atoms of each chain that occurs often enough to be judged."""
    _, chain, count = np.unique(molecule.chain[atoms], return_inverse=True, return_counts=True)
    return [np.flatnonzero(chain == k) for k in np.flatnonzero(count >= least)]


def _stretch(xyz: np.ndarray, pairs: np.ndarray, usual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find how many times too long bonds (L, 2) are along three directions (F, 3), and these as columns (F, 3, 3).

    The symmetric matrix G with u G u = 1 for all bonds u is found by least squares; where no bond determines it, it is 1.
    """
    bonds = (xyz[:, pairs[:, 0]] - xyz[:, pairs[:, 1]]) / usual[:, None]
    ratio = np.linalg.norm(bonds, axis=2)
    x, y, z = np.moveaxis(
        np.where((ratio > 1 / MAX_RATIO) & (ratio < MAX_RATIO), 1.0, 0.0)[:, :, None] * bonds, 2, 0
    )
    terms = np.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z], axis=2)
    remainder = np.where(x * x + y * y + z * z > 0, 1 - terms[:, :, :3].sum(axis=2), 0.0)
    square = terms.swapaxes(1, 2) @ terms + CERTAINTY * bonds.shape[1] * np.eye(6)
    solved = np.linalg.solve(square, terms.swapaxes(1, 2) @ remainder[:, :, None])[:, :, 0]
    matrix = np.eye(3) + solved[:, [[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
    values, directions = np.linalg.eigh(matrix)
    return 1 / np.sqrt(np.maximum(values, 0.01)), directions


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
