"""Dots and tables written in the format of a file's suffix, or to standard output."""

import gzip
import importlib
import logging
import os
import re
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.cli.inputs import as_molecule, same_atoms
from sparsurf.dot_fields.columns import RESERVED_NAMES
from sparsurf.files import shorten
from sparsurf.surfaces.formats.compact import write_compact
from sparsurf.surfaces.formats.csv import write_csv
from sparsurf.surfaces.formats.dms import write_dms
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.surfaces.formats.vtp import write_vtp
from sparsurf.surfaces.surface import ARRAY_NAMES, Surface, is_field_name
from sparsurf.surfaces.triangulation import MAX_DOTS_TO_TRIANGULATE, triangulate

log = logging.getLogger("sparsurf")

BY_TRIMESH = (".obj", ".glb", ".stl", ".off")  # where trimesh is installed
MESHES = (".ply", ".vtp", *BY_TRIMESH)
NUMBERS = (".csv", ".npz", ".ply", ".vtp")  # which have room for numbers at the dots
DOTS_ALONE = (".csv", ".npz", ".minimal", *MESHES)
DOTS = (".dms", *DOTS_ALONE)  # DMS names the atom of every dot
TABLES = (".csv", ".npz")
PLACE = ("x", "y", "z", "nx", "ny", "nz")
LONGEST_NAME = 255  # bytes
FRAME = "{frame}"  # in the name of a file: its number


@dataclass(frozen=True)
class Dots:
    """Dots to write.

    surface : Surface
    table : DataFrame of N rows, the columns besides places and normals; a column `dot` comes first
    shown : the column that gives colours; the kind of the dots without
    molecule : Molecule of the dots, and its frame, without which they cannot be written as DMS
    faces : (F, 3) triangles between them where they are known
    words : what is told when they are written
    """

    surface: Surface
    table: pd.DataFrame
    shown: str | None = None
    molecule: object = None
    frame: int = 0
    faces: np.ndarray | None = None
    words: str = ""

    @property
    def numbers(self):
        """The columns that hold numbers, by name; `dot` first."""
        columns = {name: self._all[name].to_numpy() for name in self._all if name not in PLACE}
        columns = {name: columns[name] for name in sorted(columns, key=lambda name: name != "dot")}
        return {name: column for name, column in columns.items() if column.dtype.kind in "iuf"}

    @property
    def _all(self):
        """The table, before the fields of the surface."""
        own = {name: values for name, values in self.surface.fields.items() if name not in self.table}
        return self.table.join(pd.DataFrame(own, index=self.table.index)) if own else self.table

    def to_frame(self):
        """DataFrame of all columns, in the order of a CSV."""
        place = self.surface.to_frame()[list(PLACE)]
        rest = self._all[[name for name in self._all if name not in PLACE]]
        dot = [name for name in ("dot",) if name in rest]
        return pd.concat([rest[dot], place, rest.drop(columns=dot)], axis=1)


def check(asked, formats):
    """Raise InputError where `write` would, before anything is computed.

    Parameters
    ----------
    asked : namespace with `output`, `format` and the files that it reads
    formats : tuple of suffixes
    """
    read = [getattr(asked, key, None) for key in ("file", "trajectory", "around", "table", "charges")]
    if any(_writes_to(asked.output, file) for file in filter(None, [*read, *getattr(asked, "targets", ())])):
        raise InputError(f"{asked.output} is a file that is read; name another one to write.")
    suffix = _place(asked.output, asked.format, formats)[0]
    if suffix in BY_TRIMESH:
        _trimesh(asked.output)
    if suffix in BY_TRIMESH and getattr(asked, "plain", False):
        raise InputError(f"--plain: {suffix} holds triangles only; leave it out, or name a file in .ply.")
    if suffix != ".ply" and getattr(asked, "binary", False):
        raise InputError(f"--binary is about a PLY, and {asked.output} is none; leave it out.")
    if suffix in {*DOTS} - {*NUMBERS} and getattr(asked, "fields", None):
        raise InputError(f"--fields: {suffix} has no room for them; name a file in {', '.join(NUMBERS)}.")
    every_model = getattr(asked, "model", None) == "all" and asked.frame is None
    several = getattr(asked, "frames", None) or every_model
    if several and suffix != ".csv" and FRAME not in str(asked.output):
        raise InputError(
            f"{asked.output}: several frames need a CSV or {FRAME} in the name, such as dots_{FRAME}.ply."
        )


def _writes_to(output, file):
    """Whether `output`, for some frame where its name has {frame}, is a file that is there."""
    folder, name = os.path.split(output)
    if FRAME not in name:
        return os.path.isfile(output) and os.path.exists(file) and os.path.samefile(file, output)
    of_frame = re.escape(name).replace(re.escape(FRAME), r"\d+")
    own, there = os.path.dirname(file) or ".", folder or "."
    return bool(re.fullmatch(of_frame, os.path.basename(file))) and (
        os.path.isdir(own) and os.path.isdir(there) and os.path.samefile(own, there)
    )


def _place(output, format_given, formats):
    """Suffix that decides, whether the file is packed (named .gz), and its folder, None for a stream; see `write`."""
    name = str(output)
    if "\0" in name or len(os.path.basename(name).encode(errors="surrogateescape")) > LONGEST_NAME:
        raise InputError(
            f"{shorten(repr(name))} cannot name a file; take a shorter name, of letters and digits."
        )
    if name != "-" and os.path.isdir(name):
        raise InputError(f"{name} is a folder; name a file.")
    bare = name[:-3] if name.lower().endswith(".gz") else name
    suffix = f".{format_given}" if format_given else ".csv" if name == "-" else Path(bare).suffix.lower()
    if suffix not in formats:
        why = f"this cannot be written as {suffix!r}" if suffix else "the name has no suffix"
        if format_given or name == "-":
            raise InputError(f"{name}: {why}; give --format {', '.join(each[1:] for each in formats)}.")
        raise InputError(f"{name}: {why}; name a file in {', '.join(formats)}.")
    stream = name == "-" or (os.path.exists(name) and not os.path.isfile(name))  # a pipe or a device
    folder = None if stream else Path(os.path.realpath(name)).parent
    if folder is not None and not folder.is_dir():
        raise InputError(f"{name}: there is no folder {folder}; make it first.")
    if folder is not None and not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{name}: nothing may be written into {folder}; name another folder.")
    return suffix, bare != name, folder


def write(output, format_given, formats, writers):
    """Write a result under its final name once it is whole; what is a link, a pipe or a device stays one.

    Parameters
    ----------
    output : path, packed if its name ends in .gz, or '-'
    format_given : str or None, without the dot; else the suffix of `output` decides, csv for '-'
    formats : tuple of suffixes
    writers : dict, suffix -> function of a path

    Raises
    ------
    InputError : a suffix that is none of the formats, no folder to write the file into, or a folder instead of it
    """
    suffix, packed, folder = _place(output, format_given, formats)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".sparsurf-") as place:
        path = Path(place, f"part{suffix}")
        writers[suffix](path)
        if packed:
            path.write_bytes(gzip.compress(path.read_bytes(), mtime=0))
        if folder is not None:
            os.replace(path, os.path.realpath(output))
        elif str(output) != "-":
            Path(output).write_bytes(path.read_bytes())
        else:
            with open(path, "rb") as content:
                shutil.copyfileobj(content, sys.stdout.buffer)
            sys.stdout.buffer.flush()


def write_dots(output, format_given, dots, plain=False, binary=False):
    """Write Dots; `plain` leaves out the triangles between them, `binary` is how a PLY is written.

    Parameters
    ----------
    output, format_given : see `write`
    """
    surface = dots.surface

    def faces():
        if dots.faces is None and not plain and len(surface) > MAX_DOTS_TO_TRIANGULATE:
            log.warning("%d dots are too many for triangles between them: %s has none", len(surface), output)
        if dots.faces is None and (plain or len(surface) > MAX_DOTS_TO_TRIANGULATE):
            return np.empty((0, 3), int)
        return triangulate(surface) if dots.faces is None else dots.faces

    def solid(path):
        if not len(found := faces()):
            raise InputError(f"{output} would hold no triangles, and holds nothing else; write a PLY.")
        _by_trimesh(path, surface, found)

    def refuse_names():
        odd = [name for name in surface.fields if not is_field_name(name)]
        if odd:
            raise InputError(
                f"{output} has no room for a field called {odd[0]!r}; rename it, to letters, digits and _."
            )

    def vtp(path):
        refuse_names()
        write_vtp(path, surface, dots.numbers, faces())

    def ply(path):
        refuse_names()
        values = dots.numbers
        colours = values.pop(dots.shown).astype(float) if dots.shown else None
        write_ply(path, surface, colours, dots.shown or "", values, faces=faces(), binary=binary)

    def dms(path):
        own = dots.molecule
        write_dms(path, surface, own.residue_name, own.residue, own.name, own.xyz[dots.frame])

    def npz(path):
        if taken := sorted(RESERVED_NAMES & surface.fields.keys()):
            raise InputError(
                f"{output}: npz has no room for a field called {taken[0]}; rename it, or write CSV."
            )
        arrays = {name: getattr(surface, name) for name in ARRAY_NAMES}
        arrays |= {name: values for name, values in surface.fields.items() if name not in dots.table}
        _npz(path, arrays | {name: column for name, column in dots.table.items() if name not in arrays})

    writers = {
        ".csv": lambda path: write_csv(path, dots.to_frame(), surface.fields.keys() - {*dots.table}),
        ".npz": npz,
        ".ply": ply,
        ".dms": dms,
        ".minimal": lambda path: write_compact(path, surface),
        ".vtp": vtp,
    }
    writers |= dict.fromkeys(BY_TRIMESH, solid)
    write(output, format_given, DOTS if dots.molecule is not None else DOTS_ALONE, writers)


def mesh_dots(mesh):
    """A Mesh as Dots: its vertices with the area around each."""
    words = f"{len(mesh.triangles):,} triangles, {mesh.volume:,.0f} Å^3"
    return Dots(mesh.vertices, pd.DataFrame({"area": mesh.vertices.area}), faces=mesh.triangles, words=words)


def write_table(output, format_given, table, arrays=None):
    """Write a DataFrame as CSV, or arrays by name (its columns without) as npz; see `write`. A named index is a column."""
    table = table.reset_index() if table.index.name else table
    writers = {
        ".csv": lambda path: _csv(path, table, "%.10g"),
        ".npz": lambda path: _npz(path, dict(table.items()) if arrays is None else arrays),
    }
    write(output, format_given, TABLES, writers)


def write_result(thing, path, molecule=None, frame=0):
    """Write what a function gave, in the format of the suffix of a path (.csv, .npz, .ply, .vtp, .minimal, ...; also .gz).

    Parameters
    ----------
    thing : Surface, what `minimal` gave, Mesh, or DataFrame
    path : str or Path
    molecule : path of a structure, or what `read_molecule` gave, which a DMS file needs and a table names; that of the dots
        without
    frame : int, of the molecule

    Raises
    ------
    InputError : a suffix that does not fit, or no such folder

    Examples
    --------
    >>> import sparsurf
    >>> sparsurf.write(sparsurf.surface("data/tdp43/topology.pdb"), "/tmp/dots.ply")
    """
    if isinstance(thing, pd.DataFrame):
        write_table(path, None, thing)
        return
    molecule = molecule if molecule is None else as_molecule(molecule)
    if isinstance(thing, Surface) and thing.origin:
        if molecule is None:
            molecule, frame, *_ = thing.origin
        same_atoms(thing, molecule, frame, "write")
    if hasattr(thing, "triangles"):
        thing = mesh_dots(thing)
    elif hasattr(thing, "weight"):
        thing = Dots(thing.surface, thing.table, "weight")
    elif isinstance(thing, Surface):
        thing = Dots(thing, thing.to_frame(molecule), molecule=molecule, frame=frame)
    else:
        raise InputError(f"write: give dots, a mesh or a table, not the type {type(thing).__name__}.")
    write_dots(path, None, thing)


def write_each(asked, results):
    """Write the results of one frame or of several, and tell of each.

    Parameters
    ----------
    asked : namespace of a command
    results : iterable of (frame, Dots); of several frames one table with a column `frame`, or a file for each
    """
    how = asked.plain, asked.binary
    tables, fields = [], set()
    for frame, dots in results:
        if FRAME in str(asked.output):
            output = str(asked.output).replace(FRAME, str(frame))
            write_dots(output, asked.format, dots, *how)
            wrote(asked, output, dots.words)
        elif asked.frames:
            tables.append(dots.to_frame())
            tables[-1].insert(0, "frame", frame)
            fields |= dots.surface.fields.keys() - {*dots.table}
        else:
            write_dots(asked.output, asked.format, dots, *how)
            wrote(asked, asked.output, dots.words)
    if tables:
        table = pd.concat(tables, ignore_index=True)
        write(asked.output, asked.format, (".csv",), {".csv": lambda path: write_csv(path, table, fields)})
        wrote(asked, asked.output, f"{len(table):,} dots of {len(tables)} frames")


def wrote(asked, output, words):
    """Say what was written, unless it went to standard output or --quiet was given."""
    if str(output) != "-" and not asked.quiet:
        print(f"wrote {output}: {words}", file=sys.stderr, flush=True)


def _by_trimesh(path, surface, faces):
    """Write triangles in a format that trimesh knows."""
    mesh = _trimesh(path).Trimesh(surface.points, faces, vertex_normals=surface.normals, process=False)
    mesh.export(path)


def _trimesh(output):
    try:
        return importlib.import_module("trimesh")
    except ImportError:
        raise InputError(
            f"{output} needs trimesh: run pip install trimesh, or name a file in .ply."
        ) from None


def _csv(path, table, digits):
    table.to_csv(path, index=False, float_format=digits)


def _npz(path, arrays):
    """Numpy arrays; texts are kept as such, so that nothing must be unpickled."""
    arrays = {name: np.asarray(each) for name, each in arrays.items()}
    with open(path, "wb") as stream:
        np.savez(stream, **{n: a.astype(str) if a.dtype == object else a for n, a in arrays.items()})
