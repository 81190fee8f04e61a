"""Read the atoms of an AMBER topology (prmtop, parm7): names, residues, labels, elements and bonds.

The format: https://ambermd.org/prmtop.pdf. Files of CHAMBER and ParmEd have the same flags, and some have the numbers, chains
and insertion codes of the residues of the PDB file besides. Files from before AMBER 7 (2002) have no flags and are refused.
"""

from __future__ import annotations

import re

import gemmi
import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.molecules.atom_table import AtomFile, atom_table, molecules_of_bonds
from sparsurf.molecules.source import Source

FORTRAN_FORMAT = re.compile(r"%FORMAT\s*\(\s*\d*\s*([aAiIeEfF])(\d+)")
POINTER_N_ATOMS, POINTER_N_RESIDUES = 0, 11  # places in POINTERS
FIELDS_OF_BOND = 3  # two atoms, times 3, and a type


def read_parm7(source: Source) -> AtomFile:
    """Read the atoms of an AMBER topology, with coordinates nan; raise InputError if it is none, or cut short."""
    fields = _fields(source)
    pointers = _numbers(fields, "POINTERS")
    if len(pointers) <= POINTER_N_RESIDUES:
        raise InputError(f"{FILE} has no POINTERS, which count its atoms: copy it again.")
    n_atoms, n_residues = int(pointers[POINTER_N_ATOMS]), int(pointers[POINTER_N_RESIDUES])
    if n_atoms < 1:
        raise InputError(f"{FILE} holds no atoms: give a topology with atoms.")
    names = _of_size(fields, "ATOM_NAME", n_atoms)
    residue_names = _of_size(fields, "RESIDUE_LABEL", n_residues)
    starts = _numbers(fields, "RESIDUE_POINTER") - 1
    sound = len(starts) == n_residues and n_residues and starts[0] == 0 and starts[-1] < n_atoms
    if not (sound and (np.diff(starts) > 0).all()):
        raise InputError(
            f"{FILE} has no RESIDUE_POINTER for each of its {n_residues} residues: copy it again."
        )
    residue = np.repeat(np.arange(n_residues), np.diff([*starts, n_atoms]))
    numbers = _of_residues(fields, "RESIDUE_NUMBER", [str(k + 1) for k in range(n_residues)])
    codes = _of_residues(fields, "RESIDUE_ICODE", [""] * n_residues)
    labels = [f"{number}{code}" for number, code in zip(numbers, codes, strict=True)]
    chains = _of_residues(fields, "RESIDUE_CHAINID", [""] * n_residues)
    atoms = atom_table(
        name=names,
        residue_name=np.array(residue_names)[residue],
        chain=np.array(chains)[residue],
        residue=np.array(labels)[residue],
        element=_elements(fields, n_atoms),
        unit=residue,
    )
    bonds = np.concatenate([_bonds(fields, f"BONDS_{kind}_HYDROGEN", n_atoms) for kind in ("INC", "WITHOUT")])
    return AtomFile(atoms.assign(molecule=molecules_of_bonds(atoms, bonds)))


def _fields(source: Source) -> dict[str, list[str]]:
    """Return the words of every flag, in columns of the width that its format says."""
    lines = source.text().split("\n")
    if not source.recognised:
        raise InputError(
            f"{FILE} is not an AMBER topology by its content: check its name, or copy it again; one from before AMBER 7 (2002) "
            "has no flags, and ParmEd writes it with them."
        )
    fields: dict[str, list[str]] = {}
    values, width = list[str](), 4
    for line in lines:
        if line.startswith("%FLAG"):
            values = fields.setdefault("".join(line.split()[1:2]), [])
        elif match := FORTRAN_FORMAT.match(line):
            width = int(match[2])
        elif not line.startswith("%"):
            values += [line.rstrip()[k : k + width].strip() for k in range(0, len(line.rstrip()), width)]
    return fields


def _of_size(fields: dict[str, list[str]], flag: str, size: int) -> list[str]:
    """Return the words of a flag, whose number is that in POINTERS."""
    values = fields.get(flag, [])
    if len(values) != size:
        raise InputError(
            f"{FILE} has {len(values)} of {size} values of {flag}: it is cut short or damaged; copy it again."
        )
    return values


def _of_residues(fields: dict[str, list[str]], flag: str, default: list[str]) -> list[str]:
    """Return a word for each residue; the default where the file lacks the flag. Empty words at the end are not written."""
    if flag not in fields:
        return default
    values = fields[flag] + [""] * (len(default) - len(fields[flag]))
    if len(values) != len(default) or (
        flag == "RESIDUE_NUMBER" and not all(re.fullmatch(r"-?\d+", word) for word in values)
    ):
        raise InputError(f"{FILE} has no {flag} for each of its {len(default)} residues: copy it again.")
    return values


def _numbers(fields: dict[str, list[str]], flag: str) -> np.ndarray:
    """Return the whole numbers of a flag; none if the file lacks it."""
    try:
        return np.array([int(word) for word in fields.get(flag, [])], int)
    except ValueError:
        raise InputError(f"{FILE} has a value of {flag} that is not a whole number: copy it again.") from None


def _elements(fields: dict[str, list[str]], n_atoms: int) -> list[str]:
    """Return the element of each atom by its number; empty where the file has none, EP for an extra point."""
    numbers = _numbers(fields, "ATOMIC_NUMBER")
    if len(numbers) not in (0, n_atoms):
        raise InputError(
            f"{FILE} has {len(numbers)} of {n_atoms} values of ATOMIC_NUMBER: it is cut short or damaged; copy it again."
        )
    if not len(numbers) or not (numbers > 0).any():
        return [""] * n_atoms
    return [gemmi.Element(number).name.upper() if 0 < number < 119 else "EP" for number in numbers.tolist()]


def _bonds(fields: dict[str, list[str]], flag: str, n_atoms: int) -> np.ndarray:
    """Return bonds (B, 2), numbers of atoms from 0, which the file multiplies by 3."""
    numbers = _numbers(fields, flag)
    bonds = numbers[: len(numbers) // FIELDS_OF_BOND * FIELDS_OF_BOND].reshape(-1, FIELDS_OF_BOND)[:, :2] // 3
    if len(bonds) and not 0 <= bonds.min() <= bonds.max() < n_atoms:
        raise InputError(f"{FILE} has bonds of atoms that it does not hold: copy it again.")
    return bonds
