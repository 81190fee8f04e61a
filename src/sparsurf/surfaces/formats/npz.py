"""The project's own files of surfaces: numpy arrays without rounding.

Dots have `points` and `normals`, and `area`, `kind` and `atom` where they are known; a mesh has `vertices` in place of
points, and `faces`. Other numbers of each dot are fields.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from sparsurf.errors import FILE, InputError, naming_file
from sparsurf.files import read_archive, read_bytes
from sparsurf.messages import no_warnings
from sparsurf.surfaces.surface import (
    ARRAY_NAMES,
    Surface,
    SurfaceFormat,
    is_field_name,
    reconstruction_of_file,
    surface_of_columns,
    warn_of_field_names,
    warn_of_float16,
)

REQUIRED_ARRAYS = ("points", "normals")


def _sniff(head: bytes) -> bool:
    """Return whether the file is a zip archive."""
    return head.startswith(b"PK")


def read_npz(path: Path | str) -> Surface:
    """Read a surface that a study wrote with `write_npz`; it was judged when the study placed or read its dots."""
    with no_warnings(), naming_file(path):
        return _read(read_bytes(path), judge=False)


def _read(content: bytes, judge: bool = True) -> Surface:
    """Read a surface from the bytes of a file, and unless it is known, judge whether it can be that of a molecule."""
    problem = "is not a surface written by this program, or damaged"
    arrays = read_archive(content, problem)
    if "points" not in arrays and "vertices" in arrays:  # a mesh: its vertices are the dots
        arrays["points"] = arrays.pop("vertices")
        arrays.pop("faces", None)
    if absent := [name for name in REQUIRED_ARRAYS if name not in arrays]:
        raise InputError(f"{FILE} is not a surface written by this program: it has no {absent[0]}.")
    columns = {}
    for name, values in arrays.items():
        is_field = is_field_name(name) and values.dtype.kind in "fiu"
        if name in ARRAY_NAMES or is_field:
            columns[name] = values
    reconstruction = reconstruction_of_file(arrays)
    n = columns["points"].shape[:1]
    further = {k: v for k, v in arrays.items() if k not in columns and k not in ARRAY_NAMES}
    warn_of_field_names((k for k, v in further.items() if v.dtype.kind in "fiu" and v.shape == n))
    shapes = {"points": (*n, 3), "normals": (*n, 3)}
    if not all(v.dtype.kind in "fiu" and v.shape == shapes.get(k, n) for k, v in columns.items()):
        raise InputError(f"{FILE} is not a surface written by this program: its arrays do not fit together.")
    warn_of_float16(columns["points"])
    columns |= {
        name: columns[name].astype(float) for name in ("points", "normals", "area") if name in columns
    }
    return surface_of_columns(columns, None, "weight" in arrays, judge, reconstruction)


def write_npz(path: Path | str, surface: Surface) -> None:
    """Store a surface as numpy arrays; the same surface gives the same bytes."""
    arrays = {name: getattr(surface, name) for name in ARRAY_NAMES} | surface.fields
    with open(path, "wb") as stream:
        np.savez(stream, **arrays)


def with_fields_of_file(surface: Surface, path: Path | str | None) -> Surface:
    """Add the fields of a file of arrays (N,) by name to a surface; nothing is added without a path."""
    if not path:
        return surface
    with np.load(path, allow_pickle=False) as file:
        return replace(surface, fields=surface.fields | {name: file[name] for name in file.files})


FORMAT = SurfaceFormat(_sniff, _read)
