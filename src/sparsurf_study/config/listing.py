"""Proteins and pairs that a config lists in a CSV table or a folder."""

import csv
import io
import logging
import os
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sparsurf import registry
from sparsurf.errors import InputError
from sparsurf.files import pluralise, read_text, shorten
from sparsurf.molecules.formats import (
    SELF_CONTAINED,
    STRUCTURES,
    TOPOLOGIES,
    TRAJECTORIES,
    stem,
    usual_suffix,
)
from sparsurf.molecules.listing import holds_a_structure, structures_below
from sparsurf_study.config.protein_keys import FILE_KEYS

log = logging.getLogger("sparsurf")

LIST_KEYS = ("chains", "ligands")  # columns of a table that hold several values, separated by spaces
SWITCHES = ("assembly", "ligands", "sampling")  # columns that hold true or false
TABLE_NUMBER = re.compile(r"\d+(\.\d*)?", re.ASCII)
PAIR_COLUMNS = "name and either first and second (two files) or complex, chains_1 and chains_2"
PARTNER_SUFFIXES = (("_r", "_l"), ("_1", "_2"))  # ends of the two names of a pair in a folder
SUFFIXES = {
    "structure": STRUCTURES + SELF_CONTAINED,
    "topology": TOPOLOGIES,
    "trajectory": TRAJECTORIES,
    "surface": registry.suffixes(is_read=True),
}


def list_proteins(value: Any) -> Any:
    """Replace a table or a folder of proteins by their mapping; return other values unchanged."""
    return _listed("proteins", value, from_table, from_folder)


def list_pairs(value: Any) -> Any:
    """Replace a table or a folder of pairs by their mapping; return other values unchanged."""
    return _listed("pairs", value, pairs_from_table, pairs_from_folder)


def _listed(key: str, value: Any, from_table: Callable, from_folder: Callable) -> Any:
    if isinstance(value, str):
        return from_table(value)
    if not (isinstance(value, dict) and isinstance(value.get("folder"), str)):
        return value
    if further_keys := ", ".join(str(name) for name in value if name != "folder"):
        raise InputError(
            f"{key}.folder cannot stand next to other keys ({further_keys}); name every entry, or use a table."
        )
    return from_folder(value["folder"])


def from_table(path: str) -> dict[str, dict]:
    """Read proteins from a CSV table: a column `name` and any keys of a protein; paths start at its folder."""
    folder = Path(path).parent
    return {
        name: {key: _cell(key, value, folder) for key, value in cells.items()}
        for _, name, cells in _named_rows("proteins", path, "the column name")
    }


def pairs_from_table(path: str) -> dict[str, dict]:
    """Read pairs from a CSV table. Paths start at its folder; chains are separated by spaces."""
    pairs: dict[str, dict] = {}
    folder = Path(path).parent
    for number, name, cells in _named_rows("pairs", path, PAIR_COLUMNS):
        if set(cells) == {"first", "second"}:
            pairs[name] = {"files": [str(folder / cells[key]) for key in ("first", "second")]}
        elif set(cells) == {"complex", "chains_1", "chains_2"}:
            chains = [cells[key].split() for key in ("chains_1", "chains_2")]
            pairs[name] = {"complex": str(folder / cells["complex"]), "chains": chains}
        else:
            raise InputError(f"line {number} of {path} needs {PAIR_COLUMNS}.")
    return pairs


def _named_rows(key: str, path: str, columns: str) -> list[tuple[int, str, dict[str, str]]]:
    """Read the rows of a CSV table: line number, name, and the other cells that are not empty."""
    if not os.path.isfile(path):
        raise InputError(
            f"{key} is {shorten(repr(path))}, but there is no such table; name a CSV table, write {{folder: path}}, or list "
            f"the {key} by name."
        )
    reader = csv.DictReader(io.StringIO(read_text(path), ""), strict=True)
    try:
        rows = [(reader.line_num, row) for row in reader]
    except csv.Error as error:
        raise InputError(f"{path} is not a CSV table ({error}); store it as CSV in UTF-8.") from None
    while rows and _is_empty(rows[-1][1]):  # a spreadsheet writes lines of commas below a table
        rows.pop()
    headers = [header.strip() for header in reader.fieldnames or ()]
    if not rows or "name" not in headers:
        raise InputError(f"{path} needs a header with {columns}, separated by commas, and at least one row.")
    if repeated := [header for header in headers if headers.count(header) > 1]:
        raise InputError(f"{path} has the column {repeated[0]!r} twice; remove or rename one.")
    named: dict[str, tuple[int, str, dict[str, str]]] = {}
    for number, row in rows:
        if None in row or None in row.values():
            raise InputError(
                f"line {number} of {path} has a different number of cells than the header; quote cells with commas."
            )
        cells = {header.strip(): value.strip() for header, value in row.items() if value.strip()}
        name = cells.pop("name", "")
        if not name or name in named:
            reason = "the name of an earlier line" if name else "no name"
            raise InputError(f"line {number} of {path} has {reason}; give it its own.")
        named[name] = (number, name, cells)
    return [*named.values()]


def _is_empty(row: dict[str | None, Any]) -> bool:
    """Return whether no cell of a row holds anything, also beyond the header."""
    for value in row.values():
        cells = value if isinstance(value, list) else [value]
        if any(cell and cell.strip() for cell in cells):
            return False
    return True


def _cell(key: str, value: str, folder: Path) -> Any:
    if key in FILE_KEYS:
        return str(folder / value)
    if key == "model" and value.isascii() and value.isdecimal():
        return int(value)
    if key in SWITCHES and value.lower() in ("true", "false"):
        return value.lower() == "true"
    if key == "plddt" and TABLE_NUMBER.fullmatch(value):
        return float(value)
    return value.split() if key in LIST_KEYS else value


def from_folder(path: str) -> dict[str, dict]:
    """List every structure, surface and trajectory of a folder as a protein, named after its file.

    A trajectory belongs to the topology or structure whose name it begins with; one without the other is left out (warning).
    """
    kinds = _files("proteins", path)
    topologies = {file: _topology_of(file, kinds) for file, kind in kinds.items() if kind == "trajectory"}
    stems = Counter(stem(file).lower() for file in kinds if file not in topologies)
    proteins: dict[str, dict] = {}
    names: set[str] = set()
    for file, kind in kinds.items():
        if entry := _entry(file, kind, topologies):
            name = stem(file) if stems[stem(file).lower()] < 2 else file.name.replace(".", "_")
            proteins[_free_name(name, "protein", names)] = entry
    if not proteins:
        endings = " ".join(ending for suffixes in SUFFIXES.values() for ending in suffixes)
        raise InputError(f"the folder {path!r} holds no protein: none of its files ends in one of {endings}.")
    return proteins


def pairs_from_folder(path: str) -> dict[str, dict]:
    """List pairs of structures, by what their names share, that differ only in _r and _l, or _1 and _2, at their end."""
    files = [file for file in _files("pairs", path) if usual_suffix(file) in STRUCTURES]
    pairs: dict[str, dict] = {}
    names: set[str] = set()
    for file in files:
        name = stem(file)
        for first, second in PARTNER_SUFFIXES:
            shared = name.removesuffix(first)
            partner = file.with_name(f"{shared}{second}{file.name[len(name) :]}")
            if name.endswith(first) and partner.is_file():
                pairs[_free_name(shared, "pair", names)] = {"files": [str(file), str(partner)]}
    if not pairs:
        raise InputError(
            f"the folder {path!r} holds no two structures NAME_r and NAME_l (or NAME_1 and NAME_2), such as "
            "1A2K_r.pdb and 1A2K_l.pdb."
        )
    paired = {partner for pair in pairs.values() for partner in pair["files"]}
    for file in files:
        if str(file) not in paired:
            _warn_left_out(
                file, "partner (named NAME_r and NAME_l, or NAME_1 and NAME_2, with the same ending)"
            )
    return pairs


def _warn_left_out(file: Path, missing: str) -> None:
    log.warning("%s is left out: its folder has no %s.", file, missing)


def _files(key: str, path: str) -> dict[Path, str]:
    """Return files of a folder that may be parts of proteins, with their kinds, in alphabetical order."""
    if not os.path.isdir(path):
        raise InputError(f"{key}.folder is {shorten(repr(path))}, but there is no such folder.")
    files = sorted(file for file in Path(path).iterdir() if file.is_file() and not file.name.startswith("."))
    kind_of = {ending: kind for kind, suffixes in reversed(SUFFIXES.items()) for ending in suffixes}
    left = [file for file in files if usual_suffix(file) not in kind_of and holds_a_structure(file)]
    left += [file for file in structures_below(path) if file.parent != Path(path)]
    if left:
        message = "%s: left out %s, such as %s: name structures so that they end in %s, in this folder and not below it"
        log.warning(message, path, pluralise(len(left), "file"), left[0], " ".join(STRUCTURES))
    return {file: kind_of[usual_suffix(file)] for file in files if usual_suffix(file) in kind_of}


def _entry(file: Path, kind: str, topologies: dict[Path, Path | None]) -> dict[str, str] | None:
    """Return the protein of a file; None where the file is only a part of one."""
    if topology := topologies.get(file):
        return {"structure": str(topology), "trajectory": str(file)}
    if file in topologies.values():
        return None
    if kind in ("trajectory", "topology"):
        missing = "topology or structure whose name it begins with" if kind == "trajectory" else "trajectory"
        _warn_left_out(file, missing)
        return None
    return {kind: str(file)}


def _topology_of(trajectory: Path, kinds: dict[Path, str]) -> Path | None:
    """Return the structure or topology with the longest name that the trajectory's name begins with."""
    candidates = [
        file
        for file, kind in kinds.items()
        if kind in ("structure", "topology") and _begins_with(stem(trajectory), stem(file))
    ]
    return max(candidates, key=lambda file: len(stem(file)), default=None)


def _begins_with(name: str, start: str) -> bool:
    """Return whether a name begins with another; run10 does not begin with run1."""
    remainder = name.removeprefix(start)
    return name.startswith(start) and not (start[-1:].isdigit() and remainder[:1].isdigit())


def _free_name(text: str, default: str, taken: set[str]) -> str:
    """Return a name for a folder, or `default`, that differs from those taken, in lower case, to which it is added."""
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", text).lstrip(".-_") or default
    while name.lower() in taken:
        name += "_"
    taken.add(name.lower())
    return name
