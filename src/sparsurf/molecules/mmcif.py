"""Read and write mmCIF files: gemmi parses the syntax, the atom table keeps the order of the file.

Names are those of the authors (auth_...), as in the PDB file of the same entry.
"""

from __future__ import annotations

import logging
import re
from collections import defaultdict
from collections.abc import Iterable
from functools import partial
from typing import Any

import gemmi
import numpy as np
from gemmi import cif

from sparsurf.errors import FILE, InputError
from sparsurf.files import shorten
from sparsurf.molecules.assemblies import assemblies_of_mmcif
from sparsurf.molecules.atom_table import AtomFile, AtomTable, atom_table, box_vectors
from sparsurf.molecules.plddt import origin_of_mmcif
from sparsurf.molecules.residues import HEAVY_ATOMS, standard_name

log = logging.getLogger("sparsurf")

# Columns of the table, and the items of _atom_site that may hold them; the first that an atom has is used.
ITEMS = {
    "hetero": ["group_PDB"],
    "name": ["auth_atom_id", "label_atom_id"],
    "altloc": ["label_alt_id"],
    "residue_name": ["auth_comp_id", "label_comp_id"],
    "chain": ["auth_asym_id"],
    "segid": ["label_asym_id"],
    "number": ["auth_seq_id"],
    "position": ["label_seq_id"],
    "insertion": ["pdbx_PDB_ins_code"],
    "x": ["Cartn_x"],
    "y": ["Cartn_y"],
    "z": ["Cartn_z"],
    "occupancy": ["occupancy"],
    "b_factor": ["B_iso_or_equiv"],
    "element": ["type_symbol"],
    "model": ["pdbx_PDB_model_num"],
}
REQUIRED_ITEMS = ("name", "residue_name", "x", "y", "z")
# What a CIF file without the atoms of a structure holds, by an item of it
OTHER_CONTENT = {
    "_atom_site_label": "is a CIF of a small molecule or crystal (core dictionary), which is not read: give its molecule as SDF, "
    "MOL2 or PDB",
    "_chem_comp_atom.atom_id": "describes components of the dictionary and no structure: give the structure, or the component as "
    "SDF",
    "_refln.index_h": "holds reflections and no atoms: give the mmCIF file of the structure",
}
CIF_RESIDUE_LABEL = re.compile(r"(-?\d{1,7}[A-Za-z0-9]?)?")
NUMERIC = ("x", "y", "z", "occupancy", "b_factor", "model")


def read_mmcif(text: str) -> AtomFile:
    """Read the atoms of an mmCIF file; raise InputError if it is none, cut short or damaged, or holds no atoms."""
    try:
        document = cif.read_string(text)
    except (ValueError, RuntimeError) as error:
        reason = str(error).splitlines()[0].removeprefix("string:").strip()
        raise InputError(
            f"{FILE} is not a readable mmCIF file ({reason}): copy it again or rename it."
        ) from None
    for block in document:
        _place_fractions(block)
    blocks = [block for block in document if len(block.find_values("_atom_site.Cartn_x"))]
    if not blocks:
        for item, content in OTHER_CONTENT.items():
            if any(len(block.find_values(item)) for block in document):
                raise InputError(f"{FILE} {content}.")
        raise InputError(f"{FILE} holds no atoms: give a file with an _atom_site loop.")
    if len(blocks) > 1:
        log.warning("%s has %d data blocks with atoms: the first is read", FILE, len(blocks))
    block = blocks[0]
    box = _box(block)
    atoms = _atoms(block)
    _report_absent(block, text)
    origin = origin_of_mmcif(block, box is not None)
    assemblies = partial(assemblies_of_mmcif, block)
    return AtomFile(atoms, box, _sequences(block), _crosslinked(block), origin, assemblies=assemblies)


def _place_fractions(block: cif.Block) -> None:
    """Add Cartesian coordinates, Å, to a block that has fractions of the cell instead."""
    fractions = block.find("_atom_site.", [f"fract_{axis}" for axis in "xyz"])
    if not len(fractions) or len(block.find_values("_atom_site.Cartn_x")):
        return
    lengths, angles = _cell(block)
    if not np.isfinite(lengths + angles).all() or min(lengths) <= 0:
        raise InputError(
            f"{FILE} has fractional coordinates and no cell: add the lengths and angles of _cell."
        )
    cell = gemmi.UnitCell(*lengths, *angles)
    places = [cell.orthogonalize(gemmi.Fractional(*map(cif.as_number, row))).tolist() for row in fractions]
    columns = [[f"{value:.6f}" for value in values] for values in zip(*places, strict=True)]
    loop = block.find_loop("_atom_site.fract_x").get_loop()
    loop.add_columns([f"_atom_site.Cartn_{axis}" for axis in "xyz"], "?")
    for axis, values in zip("xyz", columns, strict=True):
        column = block.find_loop(f"_atom_site.Cartn_{axis}")
        for k, value in enumerate(values):
            column[k] = value


def _atoms(block: cif.Block) -> AtomTable:
    """Return the table of atoms of a data block."""
    values_of: dict[str, list[Any]] = {
        name: _numbers(block, *items) if name in NUMERIC else _strings(block, items)
        for name, items in ITEMS.items()
    }
    absent = sorted(name for name in REQUIRED_ITEMS if not values_of[name])
    if absent:
        raise InputError(f"{FILE} has no {', '.join(absent)} in its _atom_site loop: copy it again.")
    length = len(values_of["name"])
    numbers = {name: np.array(values_of.pop(name) or [np.nan] * length) for name in NUMERIC}
    columns = {name: values or [""] * length for name, values in values_of.items()}
    columns["chain"] = _filled(columns["chain"], columns["segid"], columns["segid"])
    residues = zip(columns["chain"], columns["number"], strict=True)
    columns["segid"] = _filled(columns["segid"], residues, columns["segid"])
    position = columns.pop("position")
    positions = (
        chain_position and (segid, chain_position)
        for segid, chain_position in zip(columns["segid"], position, strict=True)
    )
    columns["number"] = _filled(columns["number"], positions, position)
    labels = [a + b for a, b in zip(columns.pop("number"), columns.pop("insertion"), strict=True)]
    malformed = next(
        (label for label in dict.fromkeys(labels) if not CIF_RESIDUE_LABEL.fullmatch(label)), None
    )
    if malformed is not None:
        raise InputError(f"{FILE} has a residue numbered '{malformed}': repair its _atom_site loop.")
    return atom_table(
        **columns
        | {axis: numbers[axis] for axis in "xyz"}
        | {
            "model": np.where(np.abs(numbers["model"]) < 1e9, numbers["model"], 1).astype(int),
            "hetero": np.array([group == "HETATM" for group in columns["hetero"]]),
            "residue": labels,
            "occupancy": np.nan_to_num(numbers["occupancy"], nan=1.0),
            "b_factor": numbers["b_factor"],
            "element": [element.upper() for element in columns["element"]],
            "unit": _units(labels, columns["name"]),
        }
    )


def _filled(authors: list[str], labels: Iterable[Any], fallback: list[str]) -> list[str]:
    """Return the authors' values; where one is null, that of another atom with this label, or else the label itself."""
    if all(authors):
        return authors
    labels = list(labels)
    author_of = {label: value for label, value in zip(labels, authors, strict=True) if value and label}
    rows = zip(authors, labels, fallback, strict=True)
    return [value or author_of.get(label, text) for value, label, text in rows]


def _units(residues: list[str], names: list[str]) -> np.ndarray:
    """Tell residues without a number, such as waters, apart: the next one begins where the name of an atom repeats."""
    if all(residues):
        return np.zeros(len(residues), int)
    begins, seen = [], set[str]()
    for residue, name in zip(residues, names, strict=True):
        begins.append(not residue and name in seen)
        seen = (set() if begins[-1] else seen) | {name} if not residue else set()
    return np.cumsum(begins)


def _report_absent(block: cif.Block, text: str) -> None:
    """Warn of chains that a file announces and that have no atoms; raise InputError if it ends within a line."""
    present = set(block.find_values("_atom_site.label_asym_id"))
    missing = [row for row in block.find("_struct_asym.", ["id", "?entity_id"]) if row[0] not in present]
    if not present or not missing:
        return
    names = ", ".join(sorted(row[0] for row in missing))
    if not text.endswith("\n"):
        raise InputError(f"{FILE} is cut short: it has no atoms for {names} of its _struct_asym list.")
    polymers = {row[0] for row in block.find("_entity.", ["id", "type"]) if row[1] == "polymer"}
    is_polymer = any(not row.has(1) or not polymers or row[1] in polymers for row in missing)
    message = (
        "%s has no atoms for %s of its _struct_asym list; if you did not remove them, copy the file again"
    )
    log.log(logging.WARNING if is_polymer else logging.INFO, message, FILE, shorten(names))


def _strings(block: cif.Block, items: list[str]) -> list[str]:
    """Return the value of each atom in the first item that has one, null values as ''; empty if no item has any."""
    result: list[str] = []
    for item in items:
        written = _written(block, item)
        if not written:
            continue
        strings = {value: _string(value) for value in set(written)}
        values = [strings[value] for value in written]
        result = [a or b for a, b in zip(result, values, strict=True)] if result else values
        if all(result):
            break
    return result if any(result) else []


def _numbers(block: cif.Block, item: str) -> list[float]:
    """Return the number of each atom in an item, nan where there is none; empty if the item has no values."""
    written = _written(block, item)
    numbers = [*map(cif.as_number, written)]
    unknown = np.flatnonzero(np.isnan(numbers)).tolist()
    if len(unknown) == len(written) and not any(map(_string, written)):
        return []
    for k in unknown:  # it may stand in quotes
        numbers[k] = cif.as_number(_string(written[k]))
    return numbers


def _written(block: cif.Block, item: str) -> list[str]:
    """Return the value of each atom in an item as it is written; empty if it is absent, or outside of the loop of atoms."""
    written = list(block.find_values(f"_atom_site.{item}"))
    return written if len(written) == len(block.find_values("_atom_site.Cartn_x")) else []


def _string(written: str) -> str:
    """Return a value without its quotes, which may enclose blanks around a name; '' for a null value."""
    return cif.as_string(written).strip()


def _box(block: cif.Block) -> np.ndarray | None:
    """Return the lattice vectors of a data block."""
    lengths, angles = _cell(block)
    return box_vectors(*lengths, *angles) if np.isfinite(lengths + angles).all() else None


def _cell(block: cif.Block) -> tuple[list[float], list[float]]:
    """Return the lengths (Å) and the angles (degrees) of the cell of a data block; nan where they are absent."""
    names = "length_a", "length_b", "length_c", "angle_alpha", "angle_beta", "angle_gamma"
    values = [cif.as_number(block.find_value(f"_cell.{name}") or "?") for name in names]
    return values[:3], values[3:]


def _sequences(block: cif.Block) -> dict[str, list[str]]:
    """Return residue names of the full sequence of each chain."""
    # by (molecule, position): alternatives at one position count once
    sequences: dict[str, dict[tuple[str, str], str]] = defaultdict(dict)
    items = ["asym_id", "seq_id", "pdb_strand_id", "mon_id"]
    for asym, position, chain, name in block.find("_pdbx_poly_seq_scheme.", items):
        sequences[chain][asym, position] = name
    return {chain: list(names.values()) for chain, names in sequences.items()}


def _crosslinked(block: cif.Block) -> frozenset[tuple[str, str]]:
    """Return chain and label of polymer residues that a covalent bond besides the backbone joins."""
    ends = [
        [f"{kind}_asym_id", f"{kind}_seq_id", f"?{code}_PDB_ins_code", f"{kind}_comp_id"]
        for kind, code in (("ptnr1_auth", "pdbx_ptnr1"), ("ptnr2_auth", "pdbx_ptnr2"))
    ]
    residues = set()
    for row in block.find("_struct_conn.", ["conn_type_id", *ends[0], *ends[1]]):
        values = [cif.as_string(row[k]) if row.has(k) else "" for k in range(1, 9)]
        parts = values[:4], values[4:]
        if row[0] == "covale" and all(standard_name(part[3]) in HEAVY_ATOMS for part in parts):
            residues |= {(chain, number + code) for chain, number, code, _ in parts}
    return frozenset(residues)
