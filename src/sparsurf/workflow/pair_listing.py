"""Pairs listed in a table or lying in a folder, as the config's mapping of pairs."""

import logging
import os
import re
from pathlib import Path

from sparsurf import InputError
from sparsurf.molecules.formats import STRUCTURES
from sparsurf.texts import short
from sparsurf.workflow.listing import free_name, named_rows

log = logging.getLogger("sparsurf")

COLUMNS = "name and either first and second (two files) or complex, chains_1 and chains_2"
SIDES = (("_r", "_l"), ("_1", "_2"))  # ends of the two names of a pair in a folder


def from_table(path):
    """Pairs of a CSV table; files are sought beside it, chains are separated by spaces.

    Parameters
    ----------
    path : str

    Returns
    -------
    dict of name to the pair's keys

    Raises
    ------
    InputError
    """
    pairs, folder = {}, Path(path).parent
    for number, name, cells in named_rows("pairs", path, COLUMNS):
        if set(cells) == {"first", "second"}:
            pairs[name] = {"files": [str(folder / cells[key]) for key in ("first", "second")]}
        elif set(cells) == {"complex", "chains_1", "chains_2"}:
            chains = [cells[key].split() for key in ("chains_1", "chains_2")]
            pairs[name] = {"complex": str(folder / cells["complex"]), "chains": chains}
        else:
            raise InputError(f"config: line {number} of {path} needs {COLUMNS}.")
    return pairs


def from_folder(path):
    """Pairs of structures whose names differ only in _r and _l, or _1 and _2, at their end, named by what they share.

    Structures without such a partner are left out and named on the terminal.

    Returns
    -------
    dict of name to the pair's keys

    Raises
    ------
    InputError : no such folder, or no two such files in it
    """
    folder = Path(path)
    if not os.path.isdir(folder):
        raise InputError(f"config: pairs.folder is {short(repr(path))}, but there is no such folder.")
    pairs, files = {}, []
    for file in sorted(folder.iterdir()):
        stem = re.sub(r"\.gz$", "", file.name, flags=re.I)
        if Path(stem).suffix.lower() not in STRUCTURES or file.name.startswith("."):
            continue
        files.append(file)
        stem = Path(stem).stem
        for first, second in SIDES:
            partner = file.with_name(file.name.replace(f"{stem}.", f"{stem[: -len(first)]}{second}.", 1))
            if stem.endswith(first) and partner.is_file():
                pairs[free_name(stem[: -len(first)], "pair", pairs)] = {"files": [str(file), str(partner)]}
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
