"""Selection of atoms: the protein by default, or chains, residue ranges, an expression, ligands."""

from __future__ import annotations

import logging
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple, TypeAlias, TypedDict, cast

import numpy as np

from sparsurf.arguments import Hydrogens, split_names
from sparsurf.errors import FILE, InputError, argument
from sparsurf.files import shorten
from sparsurf.molecules.atoms import AtomsLike
from sparsurf.molecules.names import other_spellings
from sparsurf.molecules.residues import first_atoms, split_label

log = logging.getLogger("sparsurf")

POLYMERS = ("protein", "nucleic")
LONGEST_SELECTION = 10_000  # characters of an expression; mdtraj takes about 2 s for so many
QUOTES = "''"  # a chain without a name
# '[chain:]first[-last]'; a residue is a number, possibly negative, possibly with an insertion code.
RANGE = re.compile(r"(?:(?P<chain>[^:]*):)?(?P<first>-?\d+[A-Za-z]?)(?:-(?P<last>-?\d+[A-Za-z]?))?")
ALL_LIGANDS = {"all", "true", "True"}  # as the file of a config and Python write it
WATER = "water"  # the kind of waters, and the partner that they are together
BY_CHAIN, BY_RANGE, BY_LIGAND = 1, 2, 3  # how closely an item of a group names an atom

Groups: TypeAlias = "str | Sequence[str | Sequence[str]]"


class SelectionKeys(TypedDict, total=False):
    """Keys of `select_atoms` that a user may give."""

    selection: str | None
    chains: str | Sequence[str] | None
    residues: str | Sequence[str] | None
    hydrogens: Hydrogens
    ligands: bool | str | Sequence[str]
    groups: Groups | None


class Partners(NamedTuple):
    """What buries what: the partner of each atom."""

    number: np.ndarray  # (A,) int, from 0; -1 for an atom of no group
    names: list[str]

    @property
    def labels(self) -> np.ndarray:
        """Name (A,) of the partner of each atom."""
        return np.array([*self.names, ""])[self.number]


def select_atoms(
    molecule: AtomsLike,
    *,
    selection: str | None = None,
    chains: str | Sequence[str] | None = None,
    residues: str | Sequence[str] | None = None,
    hydrogens: Hydrogens = "keep",
    ligands: bool | str | Sequence[str] = False,
    groups: Groups | None = None,
    split: Mapping[str, Sequence[str]] = MappingProxyType({}),
    report: bool = True,
) -> np.ndarray:
    """Select atoms, (A,) bool, by the keys of `read_molecule`; raise InputError for malformed keys, or if nothing is selected.

    Without `selection`, these are the protein residues, or all polymer residues if chains are named (as in 'A:10-52'),
    and the named ligands. With it, these are the atoms of the expression, and the ligands. Chains and residues restrict
    either. In ranges, a chain applies to those after it; in a chain with insertion codes, they follow its order. `ligands`
    True, or 'all', is all but waters and ions; of several names, those that the input has. With `groups`, only atoms of these
    groups are selected: of all polymers, and of the ligands that are named among them or by `ligands`.
    `split` are chains of the input that hold several molecules with the same residue numbers, and their identifiers.
    With `report`, the residues that are left out are logged.
    """
    ranges = None if residues is None else _as_list(residues, "residues", "A:10-52A,60")
    names_of_ligands = _names_of_ligands(ligands)
    in_chains = _in_chains(molecule, chains)
    in_residues = _in_residues(molecule, ranges, report, in_chains, split)
    within = in_chains & in_residues
    if selection is None:
        chain_named = chains is not None or groups is not None or any(":" in item for item in ranges or ())
        pool = np.isin(molecule.kind, POLYMERS if chain_named else ["protein"])
    else:
        pool = atoms_of_expression(molecule, selection)
    in_ligands = _in_ligands(molecule, names_of_ligands)
    selected = (pool | in_ligands) & within
    if groups is not None:
        in_ligands |= ligands_of_groups(molecule, groups)
        selected = (pool | in_ligands) & within
        in_groups = groups_of_atoms(molecule, groups, selected).number >= 0
        if report:
            _report_ungrouped(molecule, selected & ~in_groups)
        selected &= in_groups
        within = within & (in_groups | ~np.isin(molecule.kind, POLYMERS))
    if names_of_ligands is not None:
        _refuse_ligands_outside(molecule, in_ligands, in_chains, in_residues)
    if report:
        _report_left_out(molecule, selected, within)
        if selection is not None and groups is None:
            _report_absent(molecule, selected, within)
    if isinstance(hydrogens, str) and hydrogens == "remove":
        selected &= molecule.heavy
    elif not (isinstance(hydrogens, str) and hydrogens == "keep"):
        raise InputError(
            f"{argument('hydrogens')}: '{hydrogens}' is neither keep nor remove: choose one of them."
        )
    if not selected.any():
        by_default = all(key is None for key in (selection, chains, residues))
        nothing = "there is no protein" if by_default else "the selection contains no atoms"
        nucleic = np.flatnonzero(within & (molecule.kind == "nucleic"))
        remedy = _remedy_for_nucleic(molecule, nucleic, ranges) if selection is None and len(nucleic) else ""
        if selection is not None:
            names = re.findall(r"[\w'*]+", selection)
            spelt = other_spellings(dict.fromkeys(names), molecule.residue_name, molecule.name)
            remedy += "".join(f"; it calls {word} {name}" for word, name in spelt.items())
        raise InputError(f"{FILE}: {nothing}; the file has {_inventory(molecule)}{remedy}.")
    return selected


def _remedy_for_nucleic(molecule: AtomsLike, atoms: np.ndarray, ranges: list[str] | None) -> str:
    """Return the remedy where nucleic acids are meant: they are selected by their chains."""
    chains = list(dict.fromkeys(molecule.chain[atoms].tolist()))
    if ranges is None:
        return (
            f": name the chains of the nucleic acids, as `{argument('chains')}` {','.join(chains) or QUOTES}"
        )
    labels = molecule.residue[atoms][molecule.chain[atoms] == chains[0]]
    return f": name the chain of nucleic acids, as in {chains[0]}:{labels[0]}-{labels[-1]}"


def _in_chains(molecule: AtomsLike, chains: str | Sequence[str] | None) -> np.ndarray:
    """Return the mask (A,) of atoms in the chains."""
    if chains is None:
        return np.ones(len(molecule.chain), bool)
    names = [name.strip() for name in _as_list(chains, "chains", "A,B")]  # '' is a chain without a name
    absent = [name for name in names if name not in molecule.chain]
    if not names or "" in absent:
        raise InputError(
            f"{argument('chains')}: empty chain name; the chains of {FILE} are {_chains(molecule)}."
        )
    if absent and not any(molecule.chain):
        raise InputError(f"{FILE} has one chain, which has no name: leave out `{argument('chains')}`.")
    if absent:
        raise InputError(
            f"{FILE} has no chain {shorten(', '.join(absent))}: its chains are {_chains(molecule)}."
        )
    return np.isin(molecule.chain, names)


def _in_residues(
    molecule: AtomsLike,
    ranges: list[str] | None,
    report: bool,
    in_chains: np.ndarray,
    split: Mapping[str, Sequence[str]],
    key: str = "residues",
) -> np.ndarray:
    """Return the mask (A,) of atoms in the residue ranges, which the user gave by the argument `key`."""
    if ranges is None:
        return np.ones(len(molecule.chain), bool)
    selected, chain, chain_of = np.zeros(len(molecule.chain), bool), None, molecule.chain
    labels, inverse = np.unique(molecule.residue, return_inverse=True)
    rank = np.array([_rank(label) for label in labels])[inverse]
    coded, place = _chains_with_codes(molecule), molecule.residue_index
    for item in (part.strip() for text in ranges for part in text.split(",")):
        parsed = RANGE.fullmatch(item)
        if not parsed:
            raise InputError(
                f"{argument(key)}: '{shorten(item)}' is not of the form chain:first-last, such as A:10-52A or -5--3."
            )
        chain = parsed["chain"] if parsed["chain"] is not None else chain
        ends = parsed["first"], parsed["last"] or parsed["first"]
        first, last = map(_rank, ends)
        inside = (rank >= first) & (rank <= last)
        backwards = last < first
        for chain_name in coded if chain is None else {chain: coded[chain]} if chain in coded else ():
            members, begin, stop = coded[chain_name].residues(*ends)
            inside[members] = (place[members] >= begin) & (place[members] < stop)
            backwards = stop < begin
        if chain is not None:
            inside &= chain_of == chain
        if backwards and not inside.any():
            raise InputError(
                f"{argument(key)}: '{shorten(item)}' ends before it begins: swap the two numbers."
            )
        if not inside.any():
            raise InputError(
                f"{argument(key)}: '{shorten(item)}' is not in {FILE}, which has {_extents(molecule)}."
            )
        chosen = chain_of[inside & in_chains]
        several = [[chain_name for chain_name in ids if chain_name in chosen] for ids in split.values()]
        if chain is None and any(len(ids) > 1 for ids in several):
            ids = next(ids for ids in several if len(ids) > 1)
            raise InputError(
                f"{argument(key)}: '{shorten(item)}' of {FILE} are in {shorten(', '.join(ids))}: name one, as "
                f"in {ids[0]}:{item}."
            )
        present = {label.upper() for label in labels[np.unique(inverse[inside])].tolist()}
        absent = [end for end in dict.fromkeys(ends) if end.upper() not in present]
        if absent and report:
            message = "%s has no residue %s of '%s': it has %s"
            log.warning(message, FILE, " and ".join(absent), item, _extents(molecule))
        selected |= inside
    return selected


class _ChainWithCodes(NamedTuple):
    """A polymer chain with insertion codes: its atoms, and its residues in the order of the chain."""

    atoms: np.ndarray  # (n,) int
    place: np.ndarray  # (R,) int, `residue_index` of each residue
    label: list[str]  # in upper case

    def residues(self, first: str, last: str) -> tuple[np.ndarray, int, int]:
        """Return the atoms, and the places where a range begins and where what follows it begins.

        An end that the chain lacks stands for the first or last residue whose number lies in the range.
        """
        low, high = (int(split_label(text)[0]) for text in (first, last))
        within = [
            k for k, label in enumerate(self.label) if low <= int(split_label(label)[0] or low - 1) <= high
        ]
        begin, end = (within[0], within[-1]) if within else (-1, -1)
        if first.upper() in self.label:
            begin = self.label.index(first.upper())
        if last.upper() in self.label:
            end = self.label.index(last.upper())
        if min(begin, end) < 0:
            return self.atoms, 0, 0
        return self.atoms, int(self.place[begin]), int(self.place[end]) + 1 if end >= begin else -1


def _chains_with_codes(molecule: AtomsLike) -> dict[str, _ChainWithCodes]:
    """Return the polymer chains that have insertion codes, whose order the numbers do not tell."""
    polymer = np.isin(molecule.kind, POLYMERS)
    coded = polymer & np.char.isalpha(np.char.lstrip(molecule.residue.astype(str), "-0123456789"))
    chains = {}
    for name in dict.fromkeys(molecule.chain[coded].tolist()):
        atoms = np.flatnonzero(polymer & (molecule.chain == name))
        place, first = np.unique(molecule.residue_index[atoms], return_index=True)
        chains[name] = _ChainWithCodes(
            atoms, place, [label.upper() for label in molecule.residue[atoms][first].tolist()]
        )
    return chains


def _as_list(value: object, key: str, example: str) -> list[str]:
    """Return the items of a string with commas or of a list."""
    if isinstance(value, str):
        return value.split(",")
    try:
        return [str(item) for item in cast(Iterable, value)]
    except TypeError:  # a number, or an array without a dimension
        raise InputError(
            f"{argument(key)} is {value!r}; it must be a string such as '{example}', or a list."
        ) from None


def _rank(label: str) -> float:
    """Return the sort key of a residue label: insertion codes come after their number."""
    number, code = split_label(label)
    return float(number or "nan") + (ord(code.upper()) / 256 if code else 0.0)


def atoms_of_expression(molecule: AtomsLike, selection: str) -> np.ndarray:
    """Return the mask (A,) of the atoms that an mdtraj expression, or 'all', selects."""
    if not isinstance(selection, str):
        raise InputError(
            f"{argument('selection')} is {selection!r}; it must be an mdtraj expression, or 'all'."
        )
    if selection.strip() == "all":
        return np.ones(len(molecule.chain), bool)
    if not selection.strip():
        raise InputError(f"{argument('selection')} is empty: give an mdtraj expression, or leave it out.")
    if len(selection) > LONGEST_SELECTION:
        raise InputError(
            f"{argument('selection')} has {len(selection):,} characters, more than {LONGEST_SELECTION:,}: name ranges, as in "
            f"'resSeq 10 to 52', or use `{argument('residues')}`."
        )
    try:
        indices = np.asarray(molecule.topology.select(selection), dtype=int)
    except Exception as error:  # mdtraj compiles the expression, which can raise any exception
        reason = (str(error).splitlines() or [""])[0]
        remedy = f", or choose chains by `{argument('chains')}`" if re.search(r"\bchain\b", selection) else ""
        raise InputError(
            f"{argument('selection')}: '{shorten(selection)}' is not an mdtraj expression ({shorten(reason)}): "
            f"see mdtraj.org{remedy}."
        ) from None
    selected = np.zeros(len(molecule.chain), bool)
    selected[indices] = True
    return selected


def _asked_for(ligands: bool | str | Sequence[str]) -> bool:
    """Return whether ligands are named; an array has no truth value of its own."""
    try:
        return len(cast(Sequence, ligands)) > 0
    except TypeError:  # a flag, or an array without a dimension
        return ligands is not None and not (isinstance(ligands, bool | np.bool_) and not ligands)


def _names_of_ligands(ligands: bool | str | Sequence[str]) -> list[str] | None:
    """Return the names of the ligands, or None for all of them."""
    if ligands is True:
        return None
    if not (isinstance(ligands, str) or _asked_for(ligands)):
        return []
    names = split_names(",".join(_as_list(ligands, "ligands", "HEM,ZN")), "ligands", "HEM,ZN")
    if not (wildcards := ALL_LIGANDS & {*names}):
        return names
    if len(names) > 1:
        raise InputError(
            f"{argument('ligands')}: {wildcards.pop()} means every ligand; write it without other names, or names alone."
        )
    return None


def _in_ligands(molecule: AtomsLike, names: list[str] | None) -> np.ndarray:
    """Return the mask (A,) of atoms in the ligands of some names, or in all."""
    if names is None:
        atoms_of_residue = np.bincount(molecule.residue_index)[molecule.residue_index]
        return (molecule.kind == "other") & (atoms_of_residue > 1)
    absent = [name for name in names if name not in molecule.residue_name]
    if absent and len(absent) < len(names):  # such as a list for all structures of a folder
        log.warning("%s has no ligand %s", FILE, ", ".join(absent))
    elif absent:
        present = set(molecule.residue_name[~np.isin(molecule.kind, POLYMERS)].tolist())
        listed = ", ".join(sorted(present)) or "nothing"
        raise InputError(
            f"{FILE} has no ligand {shorten(', '.join(absent))}: besides polymers, the file contains {listed}."
        )
    return np.isin(molecule.residue_name, names)


def _refuse_ligands_outside(
    molecule: AtomsLike,
    in_ligands: np.ndarray,
    in_chains: np.ndarray,
    in_residues: np.ndarray,
) -> None:
    """Raise InputError if all of a named ligand lies outside of the chains and residues."""
    for name in dict.fromkeys(molecule.residue_name[in_ligands].tolist()):
        atoms = np.flatnonzero(in_ligands & (molecule.residue_name == name))
        if not (in_chains & in_residues)[atoms].any():
            first = atoms[0]
            chain = molecule.chain[first]
            add = [] if in_chains[first] else [f"{chain} to the chains"]
            add += [] if in_residues[first] else [f"{chain}:{molecule.residue[first]} to the residues"]
            raise InputError(
                f"{argument('ligands')}: {name} of {FILE} lies outside of the requested chains and residues: add "
                f"{' and '.join(add)}."
            )


def _report_left_out(molecule: AtomsLike, selected: np.ndarray, within: np.ndarray) -> None:
    """Log names and numbers of residues within the chains and ranges that are not selected."""
    taken = set(molecule.residue_index[selected].tolist())
    first = first_atoms(molecule.residue_index)
    sizes = np.bincount(molecule.residue_index)
    # water and ions, which few users want, are logged separately
    counts: dict[int, Counter[str]] = {logging.WARNING: Counter(), logging.INFO: Counter()}
    for atom, size in zip(first, sizes, strict=True):
        if within[atom] and int(molecule.residue_index[atom]) not in taken:
            is_ion = size == 1 and molecule.kind[atom] == "other"
            level = logging.INFO if is_ion or molecule.kind[atom] == "water" else logging.WARNING
            counts[level][str(molecule.residue_name[atom])] += 1
    for level, of_level in counts.items():
        if of_level:
            listed = ", ".join(f"{count} {name}" for name, count in of_level.most_common())
            log.log(level, "%s: left out %s", FILE, listed)


def _report_ungrouped(molecule: AtomsLike, absent: np.ndarray) -> None:
    """Log how many atoms of polymers and ligands are in no group, and thus absent."""
    n_absent = int((absent & molecule.heavy).sum())
    if n_absent:
        log.warning("%s: %d heavy atoms of no group are absent", FILE, n_absent)


def _report_absent(molecule: AtomsLike, selected: np.ndarray, within: np.ndarray) -> None:
    """Log that an expression takes atoms without the rest of their chains, which then shields and buries nothing."""
    near = np.isin(molecule.kind, POLYMERS) & np.isin(molecule.chain, molecule.chain[selected])
    n_absent = int((near & within & molecule.heavy & ~selected).sum())
    if n_absent:
        message = (
            "%s: the selection is measured alone, without the other %d heavy atoms of its chains; to report a part of the "
            "whole, choose rows of the whole by their residues (--residues)"
        )
        log.warning(message, FILE, n_absent)


def partners_of_atoms(molecule: AtomsLike, by_residue: bool = False) -> Partners:
    """Return the default partners: each chain of polymers, each ligand by itself, as 'HEM 154 A', and all waters together.

    With `by_residue`, each residue of polymers is a partner as well.
    """
    _, first, residue = np.unique(molecule.residue_index, return_index=True, return_inverse=True)
    labels, counts = molecule.chain[first].tolist(), Counter[str]()
    for k in np.flatnonzero(by_residue | ~np.isin(molecule.kind[first], POLYMERS)).tolist():
        atom = first[k]
        label = f"{molecule.residue_name[atom]} {molecule.residue[atom]} {molecule.chain[atom]}".strip()
        counts[label] += 1
        if molecule.kind[atom] == WATER:
            label = WATER
        elif counts[label] > 1:  # a file without chains may have several ligands of one number
            label += f" ({counts[label]})"
        labels[k] = label
    position = {label: number for number, label in enumerate(dict.fromkeys(labels))}
    return Partners(np.array([position[label] for label in labels], int)[residue], list(position))


def groups_of_atoms(molecule: AtomsLike, groups: Groups, within: np.ndarray | None = None) -> Partners:
    """Return the group of each atom among those `within` (A,), by default all, and the names of the groups.

    A group lists chains, ranges of residues, or names of ligands, as 'H,L' or 'A:10-52' or 'HEM'. An atom belongs to the group
    that names it most closely: by its ligand, else by its range, else by its chain.
    """
    within = np.ones(len(molecule.chain), bool) if within is None else within
    number, best = np.full(len(within), -1), np.zeros(len(within), int)
    lists = _lists_of_groups(groups)
    found = [(k, *item) for k, items in enumerate(lists) for item in _items_of_group(molecule, items)]
    for *_, mask, closeness in found:
        best = np.where(mask & within, np.maximum(best, closeness), best)
    for k, item, mask, closeness in found:
        taken = mask & within & (best == closeness)
        if (taken & (number >= 0) & (number != k)).any():
            raise InputError(
                f"{argument('groups')}: '{shorten(item)}' is in two groups of {FILE}; name its atoms in one."
            )
        number[taken] = k
    names = [",".join(items) for items in lists]
    empty = [name for k, name in enumerate(names) if not (number == k).any()]
    if empty:
        raise InputError(
            f"{argument('groups')}: no atom that is read of {FILE} is left for the group '{shorten(empty[0])}'; name chains, "
            "ranges or ligands that are read, and that no other group names as closely."
        )
    return Partners(number, names)


def ligands_of_groups(molecule: AtomsLike, groups: Groups) -> np.ndarray:
    """Return the mask (A,) of the ligands that groups name, by name or by the letter of a chain without a polymer."""
    mask = np.zeros(len(molecule.chain), bool)
    for items in _lists_of_groups(groups):
        for _, atoms, closeness in _items_of_group(molecule, items):
            if closeness == BY_LIGAND:
                mask |= atoms
            elif closeness == BY_CHAIN and not np.isin(molecule.kind[atoms], POLYMERS).any():
                mask |= atoms & (molecule.kind != WATER)
    return mask


def _lists_of_groups(groups: Groups) -> list[list[str]]:
    """Return the items of each group; raise InputError if there are fewer than two groups, or an empty one."""
    given = groups.split("+") if isinstance(groups, str) else groups
    try:
        in_order = list(given)
    except TypeError:  # a number, or an array without a dimension
        raise InputError(
            f"{argument('groups')} is {given!r}; it must be groups such as H,L+G, or a list."
        ) from None
    lists = [[item.strip() for item in _as_list(group, "groups", "H,L")] for group in in_order]
    if len(lists) < 2:
        raise InputError(
            f"{argument('groups')}: one group has no partner; name two or more with + between, as in H,L+G."
        )
    if not all(items and all(items) for items in lists):
        raise InputError(f"{argument('groups')}: a group or a name in it is empty; write them as in H,L+G.")
    return lists


def _items_of_group(molecule: AtomsLike, items: list[str]) -> Iterator[tuple[str, np.ndarray, int]]:
    """Yield the items of a group, the mask (A,) of the atoms that each names, and how closely it names them."""
    chain = ""  # of the ranges after one with a chain
    polymer, everywhere = np.isin(molecule.kind, POLYMERS), np.ones(len(molecule.chain), bool)
    for item in items:
        ligand = (molecule.residue_name == item) & ~polymer
        parsed = RANGE.fullmatch(item)
        if item in molecule.chain:
            yield item, molecule.chain == item, BY_CHAIN
        elif ligand.any():
            yield item, ligand, BY_LIGAND
        elif parsed:
            chain = parsed["chain"] or chain
            text = item if parsed["chain"] or not chain else f"{chain}:{item}"
            mask = _in_residues(molecule, [text], False, everywhere, {}, "groups")
            chains = np.unique(molecule.chain[mask & polymer])
            if len(chains) > 1:
                raise InputError(
                    f"{argument('groups')}: residues '{item}' are in several chains of {FILE}; name one, as in "
                    f"{chains[0]}:{item}."
                )
            yield item, mask, BY_RANGE
        else:
            present = ", ".join(sorted({*molecule.residue_name[~polymer].tolist()}))
            besides = f", and besides polymers {shorten(present)}" if present else ""
            raise InputError(
                f"{argument('groups')}: '{shorten(item)}' is no chain, range or ligand of {FILE}, which has the chains "
                f"{_chains(molecule)}{besides}."
            )


def _chains(molecule: AtomsLike) -> str:
    """Return the names of the chains, for messages."""
    names = [name or "one without a name" for name in dict.fromkeys(molecule.chain.tolist())]
    return ", ".join(names)


def _extents(molecule: AtomsLike) -> str:
    """Return the extents of the polymer chains, as 'residues A 1 to 99, B 1 to 99'."""
    polymer, coded = np.isin(molecule.kind, POLYMERS), _chains_with_codes(molecule)
    extents = []
    for chain in dict.fromkeys(molecule.chain[polymer].tolist()):
        labels = [*dict.fromkeys(molecule.residue[polymer & (molecule.chain == chain)].tolist())]
        labels = labels if chain in coded else sorted(labels, key=_rank)
        extents.append(f"{chain} {labels[0]} to {labels[-1]}".strip())
    return f"residues {', '.join(extents)}" if extents else "no polymer"


def _inventory(molecule: AtomsLike) -> str:
    """Return the content of a molecule, as 'the chains A, B with 198 protein residues, 2 HOH'."""
    first = first_atoms(molecule.residue_index)
    names = np.where(
        np.isin(molecule.kind, POLYMERS), np.char.add(molecule.kind, " residues"), molecule.residue_name
    )
    counts = Counter(names[first].tolist()).most_common(8)
    listed = ", ".join(f"{count} {name}" for name, count in counts)
    chains = np.unique(molecule.chain).tolist()
    if chains == [""]:
        return f"one chain without a name with {listed}"
    return f"{'chains' if len(chains) > 1 else 'chain'} {_chains(molecule)} with {listed}"
