"""Dots and tables written in the format of a file's suffix, or to standard output."""

import gzip
import os
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.surfaces.formats.dms import write_dms
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.surfaces.surface import Surface

DOTS_ALONE = (".csv", ".npz", ".ply")
DOTS = (*DOTS_ALONE, ".dms")  # which names the atom of every dot
TABLES = (".csv", ".npz")
MESHES = (".ply",)


def check(wish, formats):
    """Raise InputError where `write` would, before anything is computed; with --mesh only a PLY will do.

    Parameters
    ----------
    wish : namespace with `output`, `format` and, of a command that has them, `mesh` and the files that it reads
    formats : tuple of suffixes
    """
    for given in (getattr(wish, key, None) for key in ("file", "trajectory", "around")):
        there = given and os.path.isfile(wish.output) and os.path.exists(given)
        if there and os.path.samefile(given, wish.output):
            raise InputError(f"{wish.output} is a file that is read; name another one to write.")
    _place(wish.output, wish.format, MESHES if getattr(wish, "mesh", False) else formats)


def _place(output, format_given, formats):
    """Suffix that decides, whether the file is packed (named .gz), and its folder, None for a stream; see `write`."""
    name = str(output)
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


def write_dots(wish, surface, columns, shown=None, molecule=None):
    """Write dots with further columns, as the options -o, --format and --mesh of a command say.

    Parameters
    ----------
    wish : namespace with `output`, `format` and `mesh`
    surface : Surface
    columns : dict, name -> (N,)
    shown : str, the column that gives a PLY its colours; the kind of the dots without
    molecule : Molecule of the dots, without which they cannot be written as a DMS file
    """

    def ply(path):
        values = dict(columns)
        colours = values.pop(shown) if shown else None
        write_ply(path, surface, colours, shown or "", values, mesh=wish.mesh)

    def dms(path):
        names = molecule.residue_name, molecule.residue, molecule.name
        write_dms(path, surface, *names, molecule.xyz[wish.frame])

    place = dict(zip(("x", "y", "z", "nx", "ny", "nz"), [*surface.points.T, *surface.normals.T], strict=True))
    write(
        wish.output,
        wish.format,
        DOTS if molecule else DOTS_ALONE,
        {
            ".csv": lambda path: pd.DataFrame(place | columns).to_csv(
                path, index=False, float_format="%.10g"
            ),
            ".npz": lambda path: _npz(
                path, {n: getattr(surface, n) for n in Surface.__dataclass_fields__} | columns
            ),
            ".ply": ply,
            ".dms": dms,
        },
    )


def write_mesh(wish, mesh):
    """Write a Mesh, as the options -o and --format of a command say: the vertices with the area around each."""
    write(
        wish.output,
        wish.format,
        MESHES,
        {
            ".ply": lambda path: write_ply(
                path, mesh.vertices, columns={"area": mesh.vertices.area}, faces=mesh.triangles
            )
        },
    )


def write_table(wish, table, arrays):
    """Write a DataFrame as CSV or arrays by name as npz, as the options -o and --format of a command say."""
    write(
        wish.output,
        wish.format,
        TABLES,
        {
            ".csv": lambda path: table.to_csv(path, index=False, float_format="%.10g"),
            ".npz": lambda path: _npz(path, arrays),
        },
    )


def _npz(path, arrays):
    with open(path, "wb") as stream:
        np.savez(stream, **arrays)
