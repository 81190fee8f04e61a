"""What a result may replace: never a file that is read, and beside the named file only what this program wrote there before."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from sparsurf.errors import InputError
from sparsurf.files import beginning

# Files that are written besides the named one, each with the test of an existing file that may be replaced there
Companions = Mapping[Path, Callable[[Path], bool]]

LEADING_BYTES = 4096
OF_MSMS = b"# MSMS solvent excluded surface "
AREAS_OF_MSMS = b" Atom#"
COLUMNS_OF_MSMS = {".vert": (9, 10), ".face": (5,)}
OWN_PAGE = b'<meta name="generator" content="sparsurf '
FRAME_COLUMNS = ("area", "volume", "components", "cavities", "dots", "mean_roughness", "accessible", "buried")
COLUMNS_OF_FRAMES = ("frame", "time_ps", *FRAME_COLUMNS)  # The columns of the table of frames.
COLUMNS_OF_CHANGES = ("quantity", "frames", "mean", "sd", "lowest", "highest", "range")
# of the table of ranked residues
COLUMNS_OF_RANKING = ("chain", "residue", "residue_name", "rank", *COLUMNS_OF_CHANGES, "mean_area")
COLUMNS_OF_CONTACTS = ("chain", "residue", "residue_name", "partner", "occupancy", "mean", "highest")


def refuse_replacing(
    output: str | Path, inputs: Iterable[Any] = (), companions: Companions | None = None
) -> None:
    """Raise InputError if writing would replace a file that is read, or a file of another origin that nobody named.

    `inputs` are all things that the result follows from; paths and molecules among them tell the files. `companions` are the
    files that are written besides the output.
    """
    files = [file for given in inputs for file in files_read(given)]
    for path in (Path(output), *(companions or {})):
        where = "" if path == Path(output) else f", which is written next to {output},"
        if os.path.isfile(path) and any(
            os.path.samefile(file, path) for file in files if os.path.exists(file)
        ):
            raise InputError(f"{path}{where} is an input file; name another file to write.")
    for path, is_own in (companions or {}).items():
        if os.path.lexists(path) and (path.is_symlink() or not (path.is_file() and is_own(path))):
            where = "" if path == Path(output) else f", which would be written next to {output},"
            raise InputError(
                f"{path}{where} exists and was not written by sparsurf as such a file; name another file to write, or rename "
                "this one."
            )


def files_read(given: Any) -> Iterator[str]:
    """Yield the files that something given was read from: a path, all files of a folder, or those of the molecule of a result."""
    if isinstance(given, list):
        for path in given:
            if isinstance(path, str | os.PathLike):
                yield from files_read(path)
    elif isinstance(given, str | os.PathLike):
        path = os.fspath(given)
        yield from (entry.path for entry in os.scandir(path)) if os.path.isdir(path) else (path,)
    elif type(given).__module__.startswith("sparsurf."):
        surface = getattr(given, "vertices", None) or getattr(given, "surface", given)
        yield from getattr(getattr(surface, "molecule", given), "files", ())


def path_of_faces(path: str | Path) -> Path | None:
    """Return the path of the triangles of a mesh, next to its vertices: mesh.face for mesh.vert; None for another format."""
    if names := re.fullmatch(r"(.*)\.vert(\.gz)?", Path(path).name, re.IGNORECASE):
        return Path(path).with_name(f"{names[1]}.face{names[2] or ''}")
    return None


def path_of_frames(path: str | Path, table: str = "frames") -> Path:
    """Return the path of the table of 'frames', 'ranking' or 'contacts' next to that of residues: run_frames.csv for run.csv."""
    name = re.sub(r"(\.(?:csv|parquet)(?:\.gz)?)$", rf"_{table}\1", Path(path).name, flags=re.IGNORECASE)
    return Path(path).with_name(name)


def beside_mesh(path: str | Path) -> Companions:
    """Return the file of triangles of a mesh; one that names the vertices next to it may be replaced."""
    from sparsurf.surfaces.formats.msms import (
        name_in_header,
    )  # here: the command of MSMS starts without numpy

    faces = path_of_faces(path)
    name = re.escape(name_in_header(Path(path).name).encode())
    return (
        {faces: lambda file: bool(re.match(OF_MSMS + b"faces for " + name + b"\\s", head(file)))}
        if faces
        else {}
    )


def beside_script(path: str | Path) -> Companions:
    """Return the files that a script for ChimeraX opens; those of an earlier script of this name may be replaced."""
    from sparsurf.api.scenes import is_opened_by  # here: other formats need none of its modules

    script = Path(path)
    if script.suffix.lower() != ".cxc":
        return {}
    files = (script.with_name(f"{script.stem}{end}") for end in ("_dots.bild", "_molecule.pdb"))
    return dict.fromkeys(files, lambda file: is_opened_by(script, file))


def beside_frames(path: str | Path) -> Companions:
    """Return the files of the tables of frames, ranked residues and contacts; one with its columns may be replaced."""
    return {
        path_of_frames(path): lambda file: (
            _has_columns(file, COLUMNS_OF_FRAMES) or _has_columns(file, COLUMNS_OF_FRAMES[:-2])  # of 4.0.0
        ),
        path_of_frames(path, "ranking"): lambda file: (
            _has_columns(file, COLUMNS_OF_RANKING)
            or _has_columns(file, ("chain", "residue", "residue_name", *COLUMNS_OF_CHANGES))  # of 5.0.0
        ),
        path_of_frames(path, "contacts"): lambda file: _has_columns(file, COLUMNS_OF_CONTACTS),
    }


def is_own_page(path: Path) -> bool:
    """Return whether a file is a page of this program."""
    return OWN_PAGE in head(path)


def is_of_msms(path: Path) -> bool:
    """Return whether a file is empty or a file of MSMS: with its comment, or with its numbers in the first line."""
    begin = head(path)
    line = begin.split(b"\n")[0].split()
    is_table = len(line) in COLUMNS_OF_MSMS.get(path.suffix, ()) and all(
        re.fullmatch(rb"[-+.\d]+", word) for word in line[:9]
    )
    return not begin or begin.startswith((OF_MSMS, AREAS_OF_MSMS)) or is_table


def head(path: Path) -> bytes:
    """Return the beginning of the content of a file; nothing of one that cannot be uncompressed."""
    return beginning(path, LEADING_BYTES)


def _has_columns(path: Path, columns: tuple[str, ...]) -> bool:
    """Return whether a CSV or a Parquet file has the columns of a table."""
    if not path.name.lower().endswith(".parquet"):
        return head(path).split(b"\n")[0].strip() == ",".join(columns).encode()
    from sparsurf.files import import_pyarrow  # here, as in the function: only such files need it

    pyarrow = import_pyarrow()
    try:
        return tuple(pyarrow.parquet.read_schema(path).names) == columns
    except (OSError, pyarrow.ArrowInvalid):
        return False
