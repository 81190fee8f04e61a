"""Build a Molecule from the table of atoms of any input, always by the same ordered steps.

Residues are gathered, one location of every atom is kept, residues get their kind and place by their bonds, molecules a
chain identifier of their own where the input repeats one, and atoms their element. Then atoms are selected, the same in
all frames. Each step logs what it changed.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from numbers import Integral
from typing import Any

import numpy as np

from sparsurf.errors import FILE, InputError, argument, naming_file
from sparsurf.files import pluralise
from sparsurf.molecules.assemblies import copies
from sparsurf.molecules.atom_table import (
    AtomFile,
    AtomTable,
    choose_altlocs,
    gather_residues,
    missing_residues,
    refuse_control_characters,
    report_duplicates,
    report_occupancies,
    settle_segments,
    unite_names,
)
from sparsurf.molecules.conformations import superpose
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.pdb import identifiers
from sparsurf.molecules.plausibility import refuse_invalid_coordinates
from sparsurf.molecules.residues import (
    count_heavy_atoms,
    element_of,
    find_particles,
    first_atoms,
    known_kind,
    residue_kinds,
    split_label,
)
from sparsurf.molecules.selection import POLYMERS, SelectionKeys, select_atoms
from sparsurf.molecules.source import Source
from sparsurf.molecules.trajectory import (
    EVERY_FRAME,
    TrajectoryFrames,
    check_frames,
    read_first_frame,
    read_frames,
)
from sparsurf.molecules.unwrapping import Unwrapping, has_no_box, make_whole

log = logging.getLogger("sparsurf")

# A protein whose residues hold less than this share of their heavy atoms is a model of its backbone. C-alpha atoms
# alone are 13 %, backbone with C-beta 62 %. The sparsest crystal structure of the reference data has 97 %.
MIN_HEAVY_ATOM_SHARE = 0.7
IDENTITY = ("name", "residue_name", "chain", "residue")  # arrays that identify an atom
# columns that are the same in most models
OF_ATOMS = (*IDENTITY, "residue_index", "element", "hetero", "segid")
MIN_RESIDUES_TO_JUDGE = 3  # a fragment with fewer residues is accepted as it is
# So many residues of glycine alone are a model: designed backbones before they get a sequence.
MIN_RESIDUES_OF_MODEL = 10
BACKBONE_NAMES = ("N", "CA", "C", "O", "OXT", "CB", "P", "OP1", "OP2", "O5'", "C5'", "C4'", "C3'", "O3'")
UNKNOWN_AMINO_ACID = "UNK"
SAME_SHAPE = 0.05  # Å, deviation of models that are copies of one; coordinates have three decimals
OTHER_PLACE = 1.0  # Å, by which they are apart at least
MIN_ATOMS_OF_COPY = 10
MIN_PART_SEPARATION = 2.0  # Å, median distance from the atoms of one part of an assembly to those of another


@dataclass(frozen=True)
class Everything:
    """All atoms of a table, in one frame."""

    molecule: Molecule
    row: np.ndarray  # (A,) int, position of each atom among those of the table
    split: dict[str, list[str]]  # chain identifiers of the input that several molecules had -> theirs
    # (R,) bool, whether a bond besides the backbone joins the residue to another of the polymer
    crosslinked: np.ndarray
    following: np.ndarray  # (R,) int, next residue of the polymer, -1 for none


def prepare_table(file: AtomFile, altloc: str) -> AtomTable:
    """Return the table with its residues gathered and numbered, and one location of every atom."""
    refuse_control_characters(file.atoms)
    report_occupancies(file.atoms)
    gathered = gather_residues(settle_segments(file.atoms))
    atoms = choose_altlocs(unite_names(gathered), altloc)
    report_duplicates(atoms)
    return atoms


def arrange(
    atoms: AtomTable,
    xyz: np.ndarray,
    row: np.ndarray,
    file: AtomFile,
    report: bool = True,
) -> Everything:
    """Return all atoms of one model of a prepared table, with the positions xyz (A, 3), Å."""
    atoms, xyz, row = _without_particles(atoms, xyz, row, report)
    index, names = atoms.residue_index, atoms.name.astype(str)
    residue_names = atoms.residue_name.astype(str)
    with np.errstate(
        over="ignore", invalid="ignore"
    ):  # positions that no distance can hold are refused later, in a sentence
        kind, following = residue_kinds(residue_names, index, names, atoms.hetero, xyz)
    place = _places(following)
    order = np.argsort(place[index], kind="stable")
    place_of = np.argsort(place)
    kind, following = kind[place_of], np.append(place, -1)[following[place_of]]
    atoms, xyz, index = atoms.take(order), xyz[order], place[index][order]
    residues = atoms.take(np.unique(index, return_index=True)[1])
    chain, split = _chains(residues, kind, following, index, xyz)
    if report:
        for name, ids in split.items():
            message = "%s: %s holds several molecules with the same residue numbers; they are called %s"
            log.warning(message, FILE, f"chain {name}" if name else "a chain without a name", ", ".join(ids))
    labels = zip(residues.chain, residues.residue, strict=True)
    alone = np.bincount(index)[index] == 1
    polymer = np.isin(kind, POLYMERS)[index]
    columns = (column.tolist() for column in (atoms.element, atoms.name, atoms.residue_name, polymer, alone))
    molecule = Molecule(
        xyz[None],
        np.array([np.nan]),
        np.array([0]),
        name=names[order],
        residue_name=residue_names[order],
        chain=chain[index],
        element=np.array([*map(element_of, *columns)]),
        residue=atoms.residue.astype(str),
        residue_index=index,
        kind=kind[index],
        b_factor=atoms.b_factor.astype(float),
    )
    crosslinked = np.array([label in file.crosslinked for label in labels])
    return Everything(molecule, row[order], split, crosslinked, following)


def _without_particles(
    atoms: AtomTable, xyz: np.ndarray, row: np.ndarray, report: bool
) -> tuple[AtomTable, np.ndarray, np.ndarray]:
    """Return the table, positions and rows without the particles that are not atoms; say how many there are."""
    name, residue_name = atoms.name.astype(str), atoms.residue_name.astype(str)
    index, element = atoms.residue_index, atoms.element.astype(str)
    found = find_particles(name, residue_name, index, element, xyz)
    if not found.any():
        return atoms, xyz, row
    if found.all():
        raise InputError(f"{FILE} holds no atoms but particles such as {name[0]}: give a file with atoms.")
    if report:
        names = dict.fromkeys(name[found].tolist())
        listed = ", ".join([*names][:4]) + (", ..." if len(names) > 4 else "")
        of_water = all(known_kind(residue) == "water" for residue in set(residue_name[found].tolist()))
        message = "%s: left out %s (pseudoatoms, lone pairs, virtual sites or Drude particles, which are not atoms): %s"
        count = pluralise(int(found.sum()), "particle")
        log.log(logging.INFO if of_water else logging.WARNING, message, FILE, count, listed)
    kept = atoms.take(~found)
    return (
        kept.assign(residue_index=np.unique(index[~found], return_inverse=True)[1]),
        xyz[~found],
        row[~found],
    )


def _places(following: np.ndarray) -> np.ndarray:
    """Return the new place of each residue (R,): the parts of a chain stand in the order of its bonds."""
    numbers = np.arange(len(following))
    start = np.flatnonzero(np.append(True, following[:-1] != numbers[1:]))
    part_of_start = {int(residue): part for part, residue in enumerate(start)}
    ends = following[np.append(start[1:], len(following)) - 1].tolist()
    after = {part: part_of_start[residue] for part, residue in enumerate(ends) if residue in part_of_start}
    if not after:
        return numbers
    heads = sorted(set(range(len(start))) - set(after.values()))
    parts: dict[int, None] = {}
    for first in [*heads, *range(len(start))]:  # the parts of a ring have no head
        part: int | None = first
        while part is not None and part not in parts:
            parts[part] = None
            part = after.get(part)
    pieces = np.split(numbers, start[1:])
    return np.argsort(np.concatenate([pieces[part] for part in parts]))


def _chains(
    residues: AtomTable, kind: np.ndarray, following: np.ndarray, index: np.ndarray, xyz: np.ndarray
) -> tuple[np.ndarray, dict[str, list[str]]]:
    """Return the chain identifier of each residue (R,), and those that took the place of one that says too little.

    Molecules of one identifier whose residues have the same numbers get one each: that of their segments, or the next
    free letter. So do molecules without an identifier in several segments.
    """
    chain, segid = residues.chain.copy(), residues.segid.astype(str)
    label, molecule = residues.residue.astype(str), residues.molecule
    polymer = np.isin(kind, POLYMERS)
    used, split = set(chain), dict[str, list[str]]()
    for name in dict.fromkeys(chain[polymer]):
        members = np.flatnonzero(polymer & (chain == name))
        part = _parts(members, following, label, segid, molecule)
        segments = {
            segment: members[segid[members] == segment] for segment in dict.fromkeys(segid[members].tolist())
        }
        if part[-1] == 0 and (name or "" in segments or len(segments) == 1):
            continue
        single = all(
            _parts(rows_of_segment, following, label, segid, molecule)[-1] == 0
            for rows_of_segment in segments.values()
        )
        if single and "" not in segments and segments.keys().isdisjoint(used - {name}):
            of_chain = np.flatnonzero((chain == name) & (segid != ""))
            chain[of_chain] = segid[of_chain]
            split[name] = [*segments]
        else:
            free = (identifier for identifier in identifiers() if identifier not in used)
            ids = [name or next(free), *(next(free) for _ in range(part[-1]))]
            chain[members] = np.array(ids, object)[part]
            other_residues = np.flatnonzero(np.isin(kind, ["other"]) & (chain == name))
            chain[other_residues] = chain[members][_nearest(members, other_residues, index, xyz)]
            split[name] = ids
        used |= set(split[name])
    return chain.astype(str), split


def _parts(
    members: np.ndarray, following: np.ndarray, label: np.ndarray, segid: np.ndarray, molecule: np.ndarray
) -> np.ndarray:
    """Assign some residues of one chain identifier the numbers (M,) of their molecules; a next one begins where a label repeats.

    It begins at the last end of a molecule before: TER, another segment, or a number that falls without a bond.
    """
    numbers = [int(split_label(text)[0] or 0) for text in label[members].tolist()]
    before, after = members[:-1], members[1:]
    falls = np.diff(numbers) < 0
    ends = (following[before] != after) & (
        falls | (segid[before] != segid[after]) | (molecule[before] != molecule[after])
    )
    part: list[int] = []
    seen: set[str] = set()
    for piece in np.split(members, np.flatnonzero(ends) + 1):
        labels = set(label[piece].tolist())
        new = bool(part) and not seen.isdisjoint(labels)
        seen = labels if new else seen | labels
        part += [(part[-1] if part else 0) + new] * len(piece)
    return np.array(part)


def _nearest(
    members: np.ndarray, other_residues: np.ndarray, index: np.ndarray, xyz: np.ndarray
) -> np.ndarray:
    """Return the position among `members`, residues, of the one nearest to each of some other residues."""
    from scipy.spatial import cKDTree  # takes long to load, and few inputs need it

    atoms = np.flatnonzero(np.isin(index, members) & np.isfinite(xyz).all(axis=1))
    first = np.searchsorted(index, other_residues)
    if not len(atoms) or not np.isfinite(xyz[first]).all():
        return np.zeros(len(other_residues), int)
    nearest = np.asarray(cKDTree(xyz[atoms]).query(xyz[first])[1], int)
    return np.searchsorted(members, index[atoms[nearest]])


def molecule_of_models(
    file: AtomFile,
    keys: SelectionKeys,
    altloc: str = "first",
    model: int | None = None,
    span: slice = EVERY_FRAME.span,
    whole: bool = True,
    assembly: bool | str = False,
) -> Molecule:
    """Return the selected atoms of an input whose models are its frames, or with `assembly` parts of one molecule."""
    tables = _select_models(prepare_table(file, altloc), model)
    if assembly:
        if len(tables) == 1:
            tables = copies(tables[0], file.assemblies(), assembly)
        elif assembly is not True:
            raise InputError(
                f"{argument('assembly')}: {FILE} has {len(tables)} models, which `{argument('assembly')}` joins: leave out the "
                "name, or give a file of one model."
            )
        else:
            _refuse_conformations(tables)
        tables = {0: _joined(tables)}
    check_frames(len(tables), span)
    numbers = np.array(list(tables))[span]
    first = _of_model(tables[numbers[0]], file)
    selected = select_complete(first, keys, file)
    frames = [first.molecule.take(selected)]
    for number in numbers[1:].tolist():  # waters may differ between models; the selected atoms may not
        table = tables[number]
        if _same(table, tables[numbers[0]], OF_ATOMS):
            xyz = table.xyz[first.row[selected]]
            frames.append(replace(frames[0], xyz=xyz[None]))
        else:
            other = _of_model(table, file, report=False)
            mask = select_atoms(other.molecule, split=other.split, report=False, **keys)
            frames.append(other.molecule.take(mask))
    if not all(_same(frame, frames[0]) for frame in frames):
        counts = " ".join(str(frame.n_atoms) for frame in frames[:9])
        raise InputError(
            f"{FILE} has models of different atoms (selected atoms: {counts}): choose one by `{argument('model')}`, "
            "or take all models as "
            f"one molecule by `{argument('assembly')}`."
        )
    xyz = np.concatenate([frame.xyz for frame in frames])
    # crystals pass unchanged: no bond there is cut
    cells = [file.box_of(int(tables[number].model[0])) for number in numbers.tolist() if whole]
    boxes = [cell for cell in cells if cell is not None]
    box = np.stack(boxes) if len(boxes) == len(numbers) else None
    return _with_frames(frames[0], TrajectoryFrames(xyz, np.full(len(xyz), np.nan), numbers, box), join=False)


def _of_model(table: AtomTable, file: AtomFile, report: bool = True) -> Everything:
    """Return all atoms of the table of one model."""
    return arrange(table, table.xyz, np.arange(len(table)), file, report)


def _select_models(atoms: AtomTable, model: int | None) -> dict[int, AtomTable]:
    """Return the tables of all models, or of the requested one, by their position in the file."""
    order = np.argsort(atoms.model, kind="stable")
    ends = np.flatnonzero(np.diff(atoms.model[order])) + 1
    rows = sorted(np.split(order, ends), key=lambda rows_of_model: int(rows_of_model[0]))
    tables = dict(enumerate(map(atoms.take, rows)))
    if model is None:
        return tables
    numbers = [int(table.model[0]) for table in tables.values()]
    listed = ", ".join(map(str, numbers[:9])) + (", ..." if len(numbers) > 9 else "")
    if not isinstance(model, Integral) or isinstance(model, bool):
        raise InputError(f"{argument('model')}: {model!r} is not a whole number: {FILE} has {listed}.")
    if model not in numbers:
        models = "models are" if len(numbers) > 1 else "only model is"
        raise InputError(f"{FILE} has no model {model}: its {models} {listed}.")
    return {numbers.index(model): tables[numbers.index(model)]}


def _refuse_conformations(tables: dict[int, AtomTable]) -> None:
    """Raise InputError if models lie within one another, as conformations of a molecule do and parts of one cannot."""
    from scipy.spatial import cKDTree  # takes long to load, and few inputs need it

    first, *further = tables.values()
    tree = cKDTree(first.xyz)
    if any(np.median(tree.query(other.xyz)[0]) < MIN_PART_SEPARATION for other in further):
        raise InputError(
            f"{argument('assembly')}: the models of {FILE} lie within one another, so they are conformations and not "
            "parts of one molecule; "
            f"leave out `{argument('assembly')}`."
        )


def _joined(tables: dict[int, AtomTable]) -> AtomTable:
    """Return the tables of all models as one, with the number of each model but the first behind its chains."""
    parts, n_residues = [], 0
    for number, table in tables.items():
        copy = table.assign(
            residue_index=table.residue_index + n_residues, molecule=table.molecule + 1_000_000 * number
        )
        if number:
            copy = copy.assign(chain=copy.chain + f"-{number + 1}")
        parts.append(copy)
        n_residues = int(copy.residue_index.max()) + 1
    columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns}
    return AtomTable(columns, np.arange(len(columns["name"])))


def _same(first: Any, second: Any, names: Sequence[str] = IDENTITY) -> bool:
    """Return whether two tables or molecules have the same atoms in the same order."""
    return all(np.array_equal(getattr(first, name), getattr(second, name)) for name in names)


def molecule_of_frames(
    atoms: AtomTable, frames: TrajectoryFrames, keys: SelectionKeys, join: bool
) -> Molecule:
    """Return the selected atoms of a table with frames in memory; `join`: see `Unwrapping`."""
    atoms = atoms.assign(**dict(zip("xyz", frames.xyz[0].T, strict=True)))
    file = AtomFile(atoms)
    table = prepare_table(file, "first")
    first = arrange(table, frames.xyz[0][table.row], table.row, file)
    selected = select_complete(first, keys, file)
    frames = replace(frames, xyz=frames.xyz[:, first.row[selected]])
    return _with_frames(first.molecule.take(selected), frames, join)


def _with_frames(molecule: Molecule, frames: TrajectoryFrames, join: bool) -> Molecule:
    """Return a molecule with other frames of its atoms, made whole."""
    xyz = frames.xyz
    refuse_invalid_coordinates(xyz, frames.number)
    if frames.box is not None:
        xyz = make_whole(xyz, frames.box, molecule.residue_index, join)
    molecule = replace(molecule, xyz=xyz, time_ps=frames.time_ps, frame_number=frames.number)
    report_copies(molecule)
    return molecule


def molecule_of_trajectory(
    file: AtomFile,
    topology: Source,
    trajectory: Source,
    keys: SelectionKeys,
    altloc: str = "first",
    model: int | None = None,
    span: slice = EVERY_FRAME.span,
    whole: bool = True,
    times: Sequence[float] | None = None,
) -> Molecule:
    """Return the selected atoms of a topology with the frames of a trajectory."""
    atoms = file.atoms
    if np.isnan(atoms.x).all():  # the topology holds names only
        with naming_file(trajectory):
            first_frame = read_first_frame(trajectory, len(atoms), topology)
        file = replace(file, atoms=atoms.assign(**dict(zip("xyz", first_frame.T, strict=True))))
    table = next(iter(_select_models(prepare_table(file, altloc), model).values()))
    row = np.argsort(np.argsort(table.row))  # place in the trajectory
    with naming_file(trajectory):
        first_frame = read_first_frame(trajectory, len(table), topology)
    first = arrange(table, first_frame[row], row, file)
    selected = select_complete(first, keys, file)
    molecule = first.molecule.take(selected)
    unwrap: list[Unwrapping] = []

    def make_frames_whole(xyz: np.ndarray, box: np.ndarray | None, number: np.ndarray) -> np.ndarray:
        if not whole or box is None or not len(xyz) or has_no_box(box):
            return xyz
        if not unwrap:
            unwrap.append(Unwrapping(xyz[0], box[0], molecule.residue_index))
        return unwrap[0](xyz, box, number)

    with naming_file(trajectory):
        frames = read_frames(trajectory, len(table), first.row[selected], span, times, make_frames_whole)
    return replace(molecule, xyz=frames.xyz, time_ps=frames.time_ps, frame_number=frames.number)


def report_copies(molecule: Molecule) -> None:
    """Warn of models that are the first one at other places, or the one before at the same place."""
    heavy = molecule.xyz[:, molecule.heavy]
    repeated = 1 + np.flatnonzero((molecule.xyz[1:] == molecule.xyz[:-1]).all(axis=(1, 2)))
    if len(repeated):
        message = "%s: %s the one before, the first is frame %d"
        counted = pluralise(len(repeated), "frame", "repeats")
        log.warning(message, FILE, counted, molecule.frame_number[repeated[0]])
    if len(heavy) < 2 or heavy.shape[1] < MIN_ATOMS_OF_COPY:
        return
    moved = superpose(heavy, slice(None), any_rotation=True) - heavy[0]
    deviation = np.sqrt((moved**2).sum(axis=2).mean(axis=1))
    distance = np.linalg.norm(heavy - heavy[0], axis=2).max(axis=1)
    copies = (deviation < SAME_SHAPE) & (distance > OTHER_PLACE)
    if copies.any():
        message = (
            "%s: %d of its %d models are copies of the first at other places; `assembly` takes all models as one molecule, "
            "`model` takes one"
        )
        log.warning(message, FILE, copies.sum() + 1, len(heavy))


def select_complete(everything: Everything, keys: SelectionKeys, file: AtomFile) -> np.ndarray:
    """Select atoms (A,) by the keys; raise InputError if they are a backbone only, warn of what is missing."""
    molecule = everything.molecule
    selected = select_atoms(molecule, split=everything.split, **keys)
    residues = np.unique(molecule.residue_index[selected])
    touched = molecule.take(np.isin(molecule.residue_index, residues))
    columns = touched.residue_name, touched.residue_index, touched.element, touched.name
    present, expected = count_heavy_atoms(*columns, touched.xyz[0])
    share = present.sum() / max(expected.sum(), 1)
    if (expected > 0).sum() >= MIN_RESIDUES_TO_JUDGE and share < MIN_HEAVY_ATOM_SHARE:
        lacking = "has no heavy atoms in its residues, only hydrogens"
        if touched.heavy.any():
            is_backbone = np.isin(
                touched.name[touched.heavy & (touched.kind != "other")], BACKBONE_NAMES
            ).all()
            parts = "C-alpha atoms or a backbone only" if is_backbone else "parts of residues, as of a pocket"
            lacking = f"has {100 * share:.0f} % of the heavy atoms of its residues ({parts})"
        raise InputError(f"{FILE} {lacking}: give a structure with all atoms.")
    first = first_atoms(touched.residue_index)
    protein = touched.residue_name[first][touched.kind[first] == "protein"]
    side_chain = touched.heavy & ~np.isin(touched.name, BACKBONE_NAMES)
    bare = touched.residue_name[first][
        (touched.kind[first] == "protein") & ~np.isin(residues, touched.residue_index[side_chain])
    ]
    unknown = int((bare == UNKNOWN_AMINO_ACID).sum())
    if len(protein) >= MIN_RESIDUES_OF_MODEL and (protein == "GLY").all():
        message = "%s: all its %d residues are glycines; is it a backbone that still needs its sequence and side chains?"
        log.warning(message, FILE, len(protein))
    elif unknown:
        message = "%s: %s unknown (UNK) without a side chain, and the surface lacks it; does the file need its sequence?"
        log.warning(message, FILE, pluralise(unknown, "residue", "is"))
    # one atom leaves when a crosslink forms
    incomplete = first[present + everything.crosslinked[residues] < expected]
    if len(incomplete):
        count = pluralise(len(incomplete), "residue", "lacks")
        message = "%s: %s heavy atoms, the first is %s; the surface will have artificial dents there: rebuild the missing atoms"
        log.warning(message, FILE, count, touched.residue_label(incomplete[0]))
    _report_missing(everything, residues, file)
    return selected


def _report_missing(everything: Everything, residues: np.ndarray, file: AtomFile) -> None:
    """Warn of residues of the sequence without coordinates, or that numbers say are missing within a chain."""
    molecule = everything.molecule
    lacking = {
        chain: full - present
        for chain, (present, full) in missing_residues(file.atoms, file.sequences).items()
        if chain in molecule.chain[np.isin(molecule.residue_index, residues)]
    }
    if lacking:
        listed = ", ".join(f"{count} in chain {chain}" for chain, count in list(lacking.items())[:5])
        further = f" and {pluralise(len(lacking) - 5, 'more chain')}" if len(lacking) > 5 else ""
        counted = pluralise(sum(lacking.values()), "residue")
        log.warning("%s: no coordinates for %s of the sequence: %s%s", FILE, counted, listed, further)
    first = first_atoms(molecule.residue_index)
    chain, kind = molecule.chain[first], molecule.kind[first]
    number = np.array([int(split_label(label)[0] or 0) for label in molecule.residue[first].tolist()])
    a, b = residues[:-1], residues[1:]
    gap = (b == a + 1) & (everything.following[a] != b) & (chain[a] == chain[b]) & (number[b] - number[a] > 1)
    inside = (kind == "protein") & np.isin(
        np.arange(len(first)), molecule.residue_index[molecule.name == "CA"]
    )
    gap &= inside[a] & inside[b] & ~np.isin(chain[a], [*file.sequences])
    if gap.any():
        k = int(np.argmax(gap))
        message = "%s: %s missing within its chains, %sbetween %s and %s; the surface covers the ends there"
        counted = pluralise(int((number[b] - number[a] - 1)[gap].sum()), "residue", "is")
        ends = (molecule.residue_label(first[r]) for r in (a[k], b[k]))
        log.warning(message, FILE, counted, "the first " if gap.sum() > 1 else "", *ends)
