"""Proteins and pairs listed in a table or lying in a folder, as the config's mappings of them."""

import csv
import io
import logging
import os
import re
from collections import Counter
from pathlib import Path

from sparsurf import InputError
from sparsurf.molecules.formats import SELF_CONTAINED, STRUCTURES, TOPOLOGIES, TRAJECTORIES, suffix
from sparsurf.texts import read_text, short
from sparsurf.workflow.registries import surface_suffixes
from sparsurf.workflow.schema import keys_of_protein

log = logging.getLogger("sparsurf")

FILES = keys_of_protein("file")
NUMBERS = keys_of_protein("type", "integer")
LISTS = (
    *keys_of_protein("type", "array"),
    "ligands",
)  # columns of a table that hold several values, separated by spaces
OF_PAIRS = "name and either first and second (two files) or complex, chains_1 and chains_2"
SIDES = (("_r", "_l"), ("_1", "_2"))  # ends of the two names of a pair in a folder


def from_table(path):
    """Proteins of a CSV table: a column `name` and any keys of a protein; empty cells are left out.

    Parameters
    ----------
    path : str

    Returns
    -------
    dict of name to the protein's keys; files are sought beside the table.

    Raises
    ------
    InputError
    """
    folder = Path(path).parent
    return {
        name: {key: _cell(key, value, folder) for key, value in cells.items()}
        for _, name, cells in _named_rows("proteins", path, "the column name")
    }


def pairs_from_table(path):
    """Pairs of a CSV table; files are sought beside it, chains are separated by spaces. Else as `from_table`."""
    pairs, folder = {}, Path(path).parent
    for number, name, cells in _named_rows("pairs", path, OF_PAIRS):
        if set(cells) == {"first", "second"}:
            pairs[name] = {"files": [str(folder / cells[key]) for key in ("first", "second")]}
        elif set(cells) == {"complex", "chains_1", "chains_2"}:
            chains = [cells[key].split() for key in ("chains_1", "chains_2")]
            pairs[name] = {"complex": str(folder / cells["complex"]), "chains": chains}
        else:
            raise InputError(f"config: line {number} of {path} needs {OF_PAIRS}.")
    return pairs


def _named_rows(key, path, columns):
    """Rows of a CSV table of the config's `key`: (number of the line, name, dict of its other cells that are not blank).

    `columns` says what the header needs, among it `name`.

    Raises
    ------
    InputError
    """
    if not os.path.isfile(path):
        raise InputError(f"config: {key} is {short(repr(path))}, but there is no such table.")
    reader = csv.DictReader(io.StringIO(read_text(path), ""), strict=True)
    try:
        rows = [(reader.line_num, row) for row in reader]
    except csv.Error as error:
        raise InputError(f"config: {path} is not a CSV table ({error}); store it as CSV in UTF-8.") from None
    headers = [header.strip() for header in reader.fieldnames] if rows else []
    if not rows or "name" not in headers:
        raise InputError(
            f"config: {path} needs a header with {columns}, separated by commas, and at least one row."
        )
    if twice := [header for header in headers if headers.count(header) > 1]:
        raise InputError(f"config: {path} has the column {twice[0]!r} twice; remove or rename one.")
    out, names = [], set()
    for number, row in rows:
        if None in row or None in row.values():
            raise InputError(
                f"config: line {number} of {path} has not as many cells as the header; quote cells with commas."
            )
        cells = {header.strip(): value.strip() for header, value in row.items() if value.strip()}
        name = cells.pop("name", "")
        if not name or name in names:
            raise InputError(
                f"config: line {number} of {path} has {'a name given before' if name else 'no name'}; give it its own."
            )
        names.add(name)
        out.append((number, name, cells))
    return out


def _cell(key, value, folder):
    if key in FILES:
        return str(folder / value)
    if key in NUMBERS and value.isascii() and value.isdecimal():
        return int(value)
    if key == "ligands" and value.lower() in ("true", "false"):
        return value.lower() == "true"
    return value.split() if key in LISTS else value


def from_folder(path):
    """Every structure, surface and trajectory of a folder as a protein, named after its file.

    A trajectory belongs to the topology or structure whose name it begins with; that file is then no protein of its
    own. A topology without a trajectory, and the reverse, are left out and named on the terminal. Files of other kinds
    and hidden ones are passed over.

    Returns
    -------
    dict of name to the protein's keys

    Raises
    ------
    InputError : no such folder, or nothing in it
    """
    files = _files("proteins", path)
    owners = {f: _topology_of(f, files) for f, kind in files.items() if kind == "trajectory"}
    alike, proteins = Counter(_stem(f).lower() for f in files if f not in owners), {}
    for file, kind in files.items():
        entry = _entry(file, kind, owners)
        if entry:
            name = _stem(file) if alike[_stem(file).lower()] < 2 else f"{_stem(file)}_{suffix(file)[1:]}"
            proteins[_free_name(name, "protein", proteins)] = entry
    if not proteins:
        known = " ".join(STRUCTURES + SELF_CONTAINED + TOPOLOGIES + TRAJECTORIES + surface_suffixes())
        raise InputError(
            f"config: the folder {path!r} holds no protein: none of its files ends in one of {known}."
        )
    return proteins


def pairs_from_folder(path):
    """Pairs of structures whose names differ only in _r and _l, or _1 and _2, at their end, named by what they share.

    Structures without such a partner are left out and named on the terminal. Else as `from_folder`.
    """
    files = [file for file in _files("pairs", path) if suffix(file) in STRUCTURES]
    pairs = {}
    for file in files:
        for first, second in SIDES:
            partner = file.with_name(
                f"{_stem(file).removesuffix(first)}{second}{file.name[len(_stem(file)) :]}"
            )
            if _stem(file).endswith(first) and partner.is_file():
                shared = _stem(file).removesuffix(first)
                pairs[_free_name(shared, "pair", pairs)] = {"files": [str(file), str(partner)]}
    if not pairs:
        raise InputError(
            f"config: the folder {path!r} holds no two structures NAME_r and NAME_l (or NAME_1 and NAME_2), such as "
            "1A2K_r.pdb and 1A2K_l.pdb."
        )
    paired = {path for pair in pairs.values() for path in pair["files"]}
    lacks = "partner (they are called NAME_r and NAME_l, or NAME_1 and NAME_2, with the same ending)"
    for file in files:
        if str(file) not in paired:
            log.warning("%s is left out: beside it lies no %s.", file, lacks)
    return pairs


def _files(key, path):
    """Files of the folder that the config's `key` names, with their kinds, in alphabetical order."""
    folder = Path(path)
    if not os.path.isdir(folder):
        raise InputError(f"config: {key}.folder is {short(repr(path))}, but there is no such folder.")
    files = sorted(f for f in folder.iterdir() if f.is_file() and not f.name.startswith("."))
    return {file: kind for file in files if (kind := _kind(file))}


def _entry(file, kind, owners):
    """The protein of a file; None where the file is only a part of one."""
    owned = file in owners.values()
    if owners.get(file):
        return {"structure": str(owners[file]), "trajectory": str(file)}
    if kind == "trajectory" or (kind == "topology" and not owned):
        lacks = "topology or structure whose name it begins with" if kind == "trajectory" else "trajectory"
        log.warning("%s is left out: beside it lies no %s.", file, lacks)
        return None
    return None if owned else {"surface" if kind == "surface" else "structure": str(file)}


def _kind(file):
    kinds = {
        "structure": STRUCTURES + SELF_CONTAINED,
        "topology": TOPOLOGIES,
        "trajectory": TRAJECTORIES,
        "surface": surface_suffixes(),
    }
    return next((kind for kind, suffixes in kinds.items() if suffix(file) in suffixes), None)


def _stem(file):
    return file.name[: len(file.name.lower().removesuffix(".gz")) - len(suffix(file))]


def _topology_of(trajectory, files):
    """The structure or topology whose name the trajectory's begins with, the longest one; None without."""
    fitting = [
        f
        for f, kind in files.items()
        if kind in ("structure", "topology") and _begins_with(_stem(trajectory), _stem(f))
    ]
    return max(fitting, key=lambda f: len(_stem(f)), default=None)


def _begins_with(name, stem):
    """Whether a name begins with another; run10 does not begin with run1."""
    rest = name.removeprefix(stem)
    return name.startswith(stem) and not (stem[-1:].isdigit() and rest[:1].isdigit())


def _free_name(text, spare, taken):
    """A name for results/ that differs from those taken in more than case; `spare` where the text holds no letter for one."""
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", text).lstrip(".-_") or spare
    while name.lower() in map(str.lower, taken):
        name += "_"
    return name
