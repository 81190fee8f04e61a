"""Biological assemblies: copies of chains by the operators that a PDB or mmCIF file declares."""

from __future__ import annotations

import logging
import re
from collections.abc import Sequence

import gemmi
import numpy as np
from gemmi import cif

from sparsurf.errors import FILE, InputError, argument
from sparsurf.files import shorten
from sparsurf.molecules.atom_table import AtomTable

log = logging.getLogger("sparsurf")

CATEGORIES = ("_pdbx_struct_assembly.", "_pdbx_struct_assembly_gen.", "_pdbx_struct_oper_list.")
# The columns of a line of REMARK 350.
COLUMNS_OF_OPERATOR = (slice(23, 33), slice(33, 43), slice(43, 53), slice(53, 68))
# Of the product of a rotation with its transpose; files state three to ten decimals
ROUNDING_OF_ROTATION = 0.01


def assemblies_of_pdb(remarks: Sequence[str]) -> list[gemmi.Assembly]:
    """Return the assemblies that the lines of REMARK 350 of a PDB file declare."""
    operators = [line for line in remarks if re.match(r"REMARK 350\s+BIOMT\d", line)]
    for line in operators:
        try:
            _ = [float(line[columns]) for columns in COLUMNS_OF_OPERATOR]
        except ValueError:
            raise InputError(
                f"{argument('assembly')}: the line '{line.strip()}' of {FILE} holds no row of an operator: repair it."
            ) from None
    assemblies = list(gemmi.read_pdb_string("\n".join([*remarks, "END", ""])).assemblies)
    n_read = sum(len(generator.operators) for assembly in assemblies for generator in assembly.generators)
    if len(operators) != 3 * n_read:
        raise InputError(
            f"{argument('assembly')}: REMARK 350 of {FILE} is incomplete: each operator has three lines, and follows the line "
            "of its chains; repair it."
        )
    return assemblies


def assemblies_of_mmcif(block: cif.Block) -> list[gemmi.Assembly]:
    """Return the assemblies that a data block declares."""
    tables = {name: block.get_mmcif_category(name) for name in CATEGORIES}
    if not all(tables.values()):
        return []
    of_assemblies = tables[CATEGORIES[0]]
    # gemmi reads no assembly without this column, which many files lack
    of_assemblies.setdefault("method_details", [None] * len(of_assemblies["id"]))
    few = cif.Block("assemblies")
    for name, table in tables.items():
        few.set_mmcif_category(name, table)
    return list(gemmi.make_structure_from_block(few).assemblies)


def copies(atoms: AtomTable, assemblies: Sequence[gemmi.Assembly], name: bool | str) -> dict[int, AtomTable]:
    """Return the tables of the copies in an assembly, the first one or that of a name, by their position from 0.

    A copy holds all that one operator moves. Its residues are numbered from 0.
    """
    names = [assembly.name for assembly in assemblies]
    if not names:
        raise InputError(
            f"{argument('assembly')}: {FILE} has one model and declares no assembly (REMARK 350 or _pdbx_struct_assembly_gen): "
            f"leave out `{argument('assembly')}`, or give the file of the assembly."
        )
    if name is not True and name not in names:
        raise InputError(
            f"{argument('assembly')}: {FILE} declares the assemblies {', '.join(names)}, not {shorten(str(name))}."
        )
    chosen = assemblies[0 if name is True else names.index(str(name))]
    moved: dict[bytes, tuple[np.ndarray, np.ndarray, list[np.ndarray]]] = {}  # rotation, shift and rows
    absent: list[str] = []
    for generator in chosen.generators:
        # A PDB file names chains by the letters of its atoms, an mmCIF file by label_asym_id
        by_letter = bool(generator.chains)
        labels, wanted = (atoms.chain, generator.chains) if by_letter else (atoms.segid, generator.subchains)
        if not generator.operators:
            raise InputError(
                f"{argument('assembly')}: {FILE} declares no operator for the chains {', '.join(wanted)} of assembly "
                f"{chosen.name}: repair it, or give the file of the assembly."
            )
        absent += [label for label in wanted if label not in labels]
        for operator in generator.operators:
            rotation, shift = (
                np.array(part.tolist()) for part in (operator.transform.mat, operator.transform.vec)
            )
            is_rotation = np.allclose(rotation @ rotation.T, np.eye(3), atol=ROUNDING_OF_ROTATION)
            if not is_rotation or np.linalg.det(rotation) < 0 or not np.isfinite(shift).all():
                raise InputError(
                    f"{argument('assembly')}: operator {operator.name} of assembly {chosen.name} of {FILE} is no rotation and "
                    "shift: repair it, or give the file of the assembly."
                )
            key = np.concatenate([rotation.ravel(), shift]).tobytes()
            moved.setdefault(key, (rotation, shift, []))[2].append(np.flatnonzero(np.isin(labels, wanted)))
    tables: dict[int, AtomTable] = {}
    for rotation, shift, parts in moved.values():
        rows = np.unique(np.concatenate(parts))
        if not len(rows):
            continue
        copy, xyz = atoms.take(rows), atoms.xyz[rows] @ rotation.T + shift
        index = np.unique(copy.residue_index, return_inverse=True)[1]
        tables[len(tables)] = copy.assign(residue_index=index, **dict(zip("xyz", xyz.T, strict=True)))
    if not tables:
        raise InputError(
            f"{argument('assembly')}: assembly {chosen.name} of {FILE} has none of its chains: leave out "
            f"`{argument('assembly')}`, or give the file of the assembly."
        )
    size = f" ({chosen.oligomeric_details.lower()})" if chosen.oligomeric_details else ""
    counted = f"{len(tables)} {'copy' if len(tables) == 1 else 'copies'}"
    further = [label for label in names if label != chosen.name]
    declared = f"; it also declares {', '.join(further)}" if further else ""
    lacking = f"; it lacks the chains {', '.join(dict.fromkeys(absent))} of the assembly" if absent else ""
    n_atoms = sum(map(len, tables.values()))
    message = "%s: assembly %s%s: %s, %s atoms%s%s"
    log.warning(message, FILE, chosen.name, size, counted, f"{n_atoms:,}", declared, lacking)
    return tables
