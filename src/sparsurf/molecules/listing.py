"""Files of structures: those of a folder and of all folders below it, or of a list, each by a name of its own."""

from __future__ import annotations

import logging
import os
from collections import Counter
from pathlib import Path
from typing import Any

from sparsurf.errors import InputError
from sparsurf.files import StrPath, as_path, pluralise, shorten
from sparsurf.molecules.formats import STRUCTURES, stem, usual_suffix
from sparsurf.molecules.source import open_source

log = logging.getLogger("sparsurf")


def structures_below(folder: StrPath, report: bool = False) -> list[Path]:
    """Return the files of structures in a folder and in all folders below it, in the order of their names.

    Hidden files and folders are left out, and a folder to which several links lead is read once. Files compressed with zstd
    and zip are among them, whose reader refuses them in a sentence. With `report`, files of another name that hold structures are
    told.
    """
    seen: set[str] = set()
    paths: list[Path] = []
    for place, folders, files in os.walk(folder, followlinks=True):
        real = os.path.realpath(place)
        folders[:] = () if real in seen else sorted(name for name in folders if name[0] != ".")
        paths += () if real in seen else (Path(place, name) for name in files if name[0] != ".")
        seen.add(real)
    unpacked = {
        path: usual_suffix(path.name.lower().removesuffix(".zst").removesuffix(".zip")) for path in paths
    }
    # a broken link is told, and no pipe is read
    chosen = [
        path for path in paths if unpacked[path] in STRUCTURES and (path.is_file() or not path.exists())
    ]
    unread = {*paths} - {*chosen} if report else ()
    if left := [
        path for path in sorted(unread) if unpacked[path] not in STRUCTURES and holds_a_structure(path)
    ]:
        message = "%s: left out %s that %s not end in %s, such as %s; rename them, or give them as a list"
        verb = "holds a structure and does" if len(left) == 1 else "hold structures and do"
        log.warning(message, folder, pluralise(len(left), "file"), verb, " ".join(STRUCTURES), left[0].name)
    return sorted(chosen, key=lambda path: (str(path.parent / stem(path)), path.name))


def holds_a_structure(path: Path) -> bool:
    """Return whether a file is a structure by its content."""
    try:
        source = open_source(path)
    except (InputError, OSError):
        return False
    return source.recognised and source.format.models


def structures_in(given: Any) -> dict[str, Path]:
    """Return the structures of a folder, or of a list of files and folders, by name.

    The name is the path below the folder, or in a list the shortest end of the path that no other file has, without the suffix
    where that is enough.
    """
    several = isinstance(given, list | tuple)
    paths: list[Path] = []
    for path in map(as_path, given if several else [given]):
        if os.path.isdir(path):  # unlike that of a Path, for names of any length
            paths += structures_below(path, report=True)
        elif several and os.path.isfile(path):
            paths.append(path)
        else:
            kind = "file" if several else "folder"
            raise InputError(
                f"there is no {kind} {shorten(path)}; name a folder of structures, or a list of their files."
            )
    if not paths:
        where = "the list of files" if several else given
        raise InputError(
            f"{where} holds no structure at any depth ({', '.join(STRUCTURES)}, also compressed)."
        )
    shown = {path: os.path.relpath(path, os.sep if several else given) for path in paths}
    # bytes that are not UTF-8 are replaced
    parts = {
        path: text.encode("utf-8", "surrogateescape").decode("utf-8", "replace").split(os.sep)
        for path, text in shown.items()
    }
    deepest = max(map(len, parts.values()))
    names: dict[Path, str] = {}
    for last in (stem, str):
        for depth in range(1 if several else deepest, deepest + 1):
            left = [path for path in parts if path not in names]
            ends = {path: "/".join((*parts[path][-depth:-1], last(parts[path][-1]))) for path in left}
            counts = Counter([*names.values(), *ends.values()])
            names |= {path: end for path, end in ends.items() if counts[end] == 1}
        if last is stem and len(names) < len(parts):
            twin = next(path for path in parts if path not in names)
            log.warning("%s and another file differ in their suffix alone, which their names keep.", twin)
    if len(names) < len(parts):
        raise InputError(f"{left[0]} has the name of another file; rename or remove one of them.")
    return {names[path]: path for path in parts}
