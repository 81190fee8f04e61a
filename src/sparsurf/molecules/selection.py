"""Which atoms of a molecule take part: protein by default, or chains, residue ranges, an expression, ligands."""

import logging
import re
from collections import Counter
from collections.abc import Iterable

import numpy as np

from sparsurf import InputError
from sparsurf.files import shorten

log = logging.getLogger("sparsurf")

POLYMERS = ("protein", "nucleic")
# '[chain:]first[-last]', each residue a number, negative or not, with an insertion code or not.
RANGE = re.compile(r"(?:(?P<chain>[^:]*):)?(?P<first>-?\d+[A-Za-z]?)(?:-(?P<last>-?\d+[A-Za-z]?))?")


def chosen_atoms(
    molecule,
    path,
    *,
    selection=None,
    chains=None,
    residues=None,
    hydrogens="keep",
    ligands=False,
    report=True,
):
    """Atoms that the user's keys choose.

    Without `selection`: the protein residues, or all polymer residues where chains are named (as 'A:10-52' does), and
    the ligands named. With it: whatever the expression selects, and the ligands. Chains and residues
    narrow down either.

    Parameters
    ----------
    molecule : molecule.Molecule
    path : named in messages
    selection : str, mdtraj selection expression, or 'all'
    chains : list of str, or 'A,B'
    residues : str or list of str, such as 'A:10-52A,60,B:-5--3': [chain:]first[-last], both ends included,
        numbers before insertion codes (52 < 52A < 53); a chain holds for the ranges after it, and ranges
        before any chain hold for all
    hydrogens : 'keep' as they are, or 'remove' (with deuterium)
    ligands : list of residue names to include beside the polymer (cofactors, ions, glycans); True for all but
        waters and single atoms (ions), False for none
    report : bool, log what is left out

    Returns
    -------
    (A,) bool

    Raises
    ------
    InputError : malformed keys, nothing selected, or a ligand that is named outside of the chains and residues
    """
    residues = None if residues is None else _texts(residues, "residues", "A:10-52A,60")
    within = _in_chains(molecule, path, chains), _in_residues(molecule, path, residues, report)
    narrowed = within[0] & within[1]
    if selection is None:
        named = chains is not None or _names_chains(residues)
        pool = np.isin(molecule.kind, POLYMERS if named else ["protein"])
    else:
        pool = atoms_of_expression(molecule, selection)
    wanted = _ligands(molecule, path, ligands)
    chosen = (pool | wanted) & narrowed
    if ligands is not True:
        _refuse_outside(molecule, path, wanted, *within)
    if report:
        _report_left_out(molecule, path, chosen, narrowed)
    if hydrogens == "remove":
        chosen &= ~np.isin(molecule.element, ["H", "D"])
    elif hydrogens != "keep":
        raise InputError(f"hydrogens: '{hydrogens}' is neither keep nor remove: choose one of them.")
    if not chosen.any():
        nucleic = np.flatnonzero(narrowed & (molecule.kind == "nucleic") & (residues is not None))
        remedy = f": {_name_chain(molecule, nucleic)}" if selection is None and len(nucleic) else ""
        raise InputError(
            f"{path}: the selection holds no atoms; the file has {_inventory(molecule)}{remedy}."
        )
    return chosen


def _name_chain(molecule, atoms):
    """How residues of nucleic acids are asked for."""
    first = atoms[0]
    last = atoms[molecule.chain[atoms] == molecule.chain[first]][-1]
    place = f"{molecule.chain[first]}:{molecule.residue[first]}-{molecule.residue[last]}"
    return f"name the chain of nucleic acids, as {place}"


def _in_chains(molecule, path, chains):
    if chains is None:
        return np.ones(len(molecule.chain), bool)
    wanted = [each.strip() for each in _texts(chains, "chains", "A,B")]
    absent = [each for each in wanted if each not in molecule.chain]
    if not wanted or "" in absent:
        raise InputError(
            f"chains: no name or an empty one: name some of the chains of {path}, {_chains(molecule)}."
        )
    if absent:
        raise InputError(
            f"{path} has no chain {shorten(', '.join(absent))}: its chains are {_chains(molecule)}."
        )
    return np.isin(molecule.chain, wanted)


def _names_chains(residues):
    return residues is not None and any(":" in each for each in residues)


def _in_residues(molecule, path, residues, report):
    if residues is None:
        return np.ones(len(molecule.chain), bool)
    wanted, chain = np.zeros(len(molecule.chain), bool), None
    labels, inverse = np.unique(molecule.residue, return_inverse=True)
    place = np.array([_place(label) for label in labels])[inverse]
    for item in (part.strip() for each in residues for part in each.split(",")):
        parsed = RANGE.fullmatch(item)
        if not parsed:
            raise InputError(
                f"residues: '{shorten(item)}' is not of the form chain:first-last, such as A:10-52A or -5--3."
            )
        chain = parsed["chain"] if parsed["chain"] is not None else chain
        first, last = _place(parsed["first"]), _place(parsed["last"] or parsed["first"])
        inside = (place >= first) & (place <= last)
        if chain is not None:
            inside &= molecule.chain == chain
        if last < first:
            raise InputError(f"residues: '{shorten(item)}' ends before it begins: exchange both ends.")
        if not inside.any():
            raise InputError(f"residues: '{shorten(item)}' is not in {path}, which has {_extents(molecule)}.")
        there = set(labels[np.unique(inverse[inside])].tolist())
        absent = [end for end in dict.fromkeys((parsed["first"], parsed["last"])) if end and end not in there]
        if absent and report:
            message = "%s has no residue %s of '%s': it has %s"
            log.warning(message, path, " and ".join(absent), item, _extents(molecule))
        wanted |= inside
    return wanted


def _texts(given, key, example):
    """The items of a string with commas or of a list."""
    if isinstance(given, str):
        return given.split(",")
    if not isinstance(given, Iterable):
        raise InputError(f"{key} is {given!r}; it must be a string such as '{example}', or a list.")
    return [str(each) for each in given]


def _place(label):
    """Sort key of a residue label: insertion codes come after their number."""
    number, code = re.fullmatch(r"(-?\d*)(.?)", label).groups()
    return float(number or "nan") + (ord(code.upper()) / 256 if code else 0.0)


def atoms_of_expression(molecule, selection):
    """(A,) bool: the atoms that an mdtraj expression, or 'all', selects."""
    if not isinstance(selection, str):
        raise InputError(f"selection is {selection!r}; it must be an mdtraj expression, or 'all'.")
    if selection.strip() == "all":
        return np.ones(len(molecule.chain), bool)
    try:
        indices = np.asarray(molecule.topology.select(selection), dtype=int)
    except Exception as error:  # mdtraj compiles the expression: any exception can come out
        reason = (str(error).splitlines() or [""])[0]
        raise InputError(
            f"selection: '{shorten(selection)}' is no mdtraj expression ({shorten(reason)}): see mdtraj.org."
        ) from None
    chosen = np.zeros(len(molecule.chain), bool)
    chosen[indices] = True
    return chosen


def _ligands(molecule, path, ligands):
    if ligands is True:
        atoms_of_residue = np.bincount(molecule.residue_index)[molecule.residue_index]
        return (molecule.kind == "other") & (atoms_of_residue > 1)
    names = [each.strip() for each in _texts(ligands, "ligands", "HEM,ZN")] if ligands else []
    absent = [name for name in names if name not in molecule.residue_name]
    if absent:
        others = set(molecule.residue_name[~np.isin(molecule.kind, POLYMERS)].tolist())
        listed = ", ".join(sorted(others)) or "none"
        raise InputError(
            f"{path} has no ligand {shorten(', '.join(absent))}: beside the polymers it has {listed}."
        )
    return np.isin(molecule.residue_name, names)


def _refuse_outside(molecule, path, wanted, in_chains, in_residues):
    """Raise InputError where all of a ligand that is named lies outside of the chains and residues."""
    for name in dict.fromkeys(molecule.residue_name[wanted].tolist()):
        own = np.flatnonzero(wanted & (molecule.residue_name == name))
        if not (in_chains & in_residues)[own].any():
            chain = molecule.chain[own[0]]
            add = [] if in_chains[own[0]] else [f"{chain} to the chains"]
            add += [] if in_residues[own[0]] else [f"{chain}:{molecule.residue[own[0]]} to the residues"]
            raise InputError(
                f"ligands: {name} of {path} lies outside of the requested chains and residues: add {' and '.join(add)}."
            )


def _report_left_out(molecule, path, chosen, narrowed):
    """Log by name and count the residues of the chains and ranges in question that are not chosen."""
    taken = set(molecule.residue_index[chosen].tolist())
    first = np.unique(molecule.residue_index, return_index=True)[1]
    sizes = np.bincount(molecule.residue_index)
    for minor in (False, True):  # what could have been meant, and what hardly ever is: water and ions
        counts = Counter(
            str(molecule.residue_name[atom])
            for atom, size in zip(first, sizes, strict=True)
            if narrowed[atom] and int(molecule.residue_index[atom]) not in taken
            and minor == (molecule.kind[atom] == "water" or (size == 1 and molecule.kind[atom] == "other"))
        )  # fmt: skip
        if counts:
            listed = ", ".join(f"{count} {name}" for name, count in counts.most_common())
            log.log(logging.INFO if minor else logging.WARNING, "%s: left out %s", path, listed)


def _chains(molecule):
    names = [name or "one without a name" for name in dict.fromkeys(molecule.chain.tolist())]
    return ", ".join(names)


def _extents(molecule):
    """'A 1 to 99, B 1 to 99' of the polymer residues."""
    polymer = np.isin(molecule.kind, POLYMERS)
    extents = []
    for chain in dict.fromkeys(molecule.chain[polymer].tolist()):
        labels = sorted(set(molecule.residue[polymer & (molecule.chain == chain)].tolist()), key=_place)
        extents.append(f"{chain} {labels[0]} to {labels[-1]}".strip())
    return ", ".join(extents) or "no polymer"


def _inventory(molecule):
    """'chains A, B with 198 protein residues, 2 HOH'."""
    first = np.unique(molecule.residue_index, return_index=True)[1]
    names = np.where(
        np.isin(molecule.kind, POLYMERS), np.char.add(molecule.kind, " residues"), molecule.residue_name
    )
    counts = Counter(names[first].tolist()).most_common(8)
    return f"chains {_chains(molecule)} with " + ", ".join(f"{count} {name}" for name, count in counts)
