"""The project's own files of surfaces: numpy arrays, nothing rounded."""

import io
import zipfile
from dataclasses import replace

import numpy as np

from sparsurf import InputError
from sparsurf.files import MAX_BYTES, no_warnings, read_bytes
from sparsurf.surfaces.surface import ARRAYS, Format, is_field, surface_of_columns


def _sniff(head):
    """Whether it is an archive."""
    return head.startswith(b"PK")


def read_npz(path):
    """Surface of a file of `write_npz` that a study wrote itself: what there is to warn of was said before."""
    with no_warnings():
        return _read(read_bytes(path), path)


def _read(content, path):
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            unpacked = sum(each.file_size for each in archive.infolist())
        if unpacked > MAX_BYTES:
            raise InputError(f"{path} unpacks to more than {MAX_BYTES // 2**20} MB.")
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            names = [*ARRAYS, *(name for name in file.files if name not in ARRAYS and is_field(name))]
            columns = {name: file[name] for name in names}
            columns = {k: v for k, v in columns.items() if k in ARRAYS or v.dtype.kind in "fiu"}
    except InputError:
        raise
    except (KeyError, ValueError, TypeError, OSError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{path} is not a surface written by this program, or damaged: {error}.") from None
    n = columns["points"].shape[:1]
    shapes = {"points": (*n, 3), "normals": (*n, 3)}
    sound = [
        value.dtype.kind in "fiu" and value.shape == shapes.get(name, n) for name, value in columns.items()
    ]
    if not all(sound):
        raise InputError(f"{path} is not a surface written by this program: its arrays do not fit together.")
    columns |= {name: columns[name].astype(float) for name in ("points", "normals", "area")}
    return surface_of_columns(columns, path)


def write_npz(path, surface):
    """Store a surface as numpy arrays; the same surface gives the same bytes."""
    with open(path, "wb") as stream:
        np.savez(stream, **{name: getattr(surface, name) for name in ARRAYS}, **surface.fields)


def with_fields(surface, path):
    """A surface with the fields of a file of arrays (N,) by name besides its own; as it is without a file."""
    if not path:
        return surface
    with np.load(path, allow_pickle=False) as file:
        return replace(surface, fields=surface.fields | {name: file[name] for name in file.files})


FORMAT = Format("npz", (".npz",), _sniff, _read, write_npz)
