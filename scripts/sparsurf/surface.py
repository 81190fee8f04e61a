"""The molecular surface as dots with normals, read from files and stored."""

import io
import logging
import re
import zipfile
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.atoms import read_text

log = logging.getLogger("sparsurf")

CONTACT, SADDLE, CONCAVE = 0, 1, 2  # kinds of dots
KINDS = {"SC": CONTACT, "SS": SADDLE, "SR": CONCAVE}
DOT_TYPE = re.compile(r"\s(SC|SS|SR)\d*(?=\s)")
FARTHEST = 1e6  # Å, largest coordinate
ROUNDED = 2e-3  # normals of three decimals are this near to unit length: sqrt(3) * 0.0005 and a reserve


@dataclass(frozen=True)
class Surface:
    """Dots of a molecular surface; their order is part of it, since the method sweeps them in it.

    Attributes
    ----------
    points : (N, 3) float64, Å
    normals : (N, 3) float64, outward, unit length but for the rounding of a file (three decimals)
    area : (N,) float64, Å^2; NaN where unknown
    kind : (N,) int8, 0 contact, 1 saddle, 2 concave; -1 where unknown
    atom : (N,) int32, index into the structure; -1 where unknown

    Raises
    ------
    InputError : no dots, shapes that disagree, NaN or infinite values, normals that are not unit vectors
    """

    points: np.ndarray
    normals: np.ndarray
    area: np.ndarray = None
    kind: np.ndarray = None
    atom: np.ndarray = None

    def __post_init__(self):
        n = len(self.points)
        types = {"points": float, "normals": float, "area": float, "kind": np.int8, "atom": np.int32}
        for name, dtype in types.items():
            value = getattr(self, name)
            if value is None:
                value = np.full(n, np.nan if name == "area" else -1)
            object.__setattr__(self, name, np.ascontiguousarray(value, dtype))
            shape = (n, 3) if name in ("points", "normals") else (n,)
            if getattr(self, name).shape != shape:
                raise InputError(f"surface: {name} has the shape {getattr(self, name).shape}, not {shape}.")
        if n == 0:
            raise InputError("surface: there are no dots.")
        if not (np.isfinite(self.points).all() and np.isfinite(self.normals).all()):
            raise InputError("surface: coordinates or normals are NaN or infinite.")
        if np.abs(np.linalg.norm(self.normals, axis=1) - 1).max() > ROUNDED:
            raise InputError("surface: normals are not of unit length.")

    def __len__(self):
        return len(self.points)


def read_surface(path):
    """Read dots from a DMS file (with normals), the authors' CSV or our npz; all but npz also as .gz.

    Parameters
    ----------
    path : told apart by content

    Returns
    -------
    Surface, in the order of the file; normals as they are where only rounding keeps them from unit length (the
    authors' descriptors follow from the rounded ones: a dot in 40 changes its pixel otherwise), else of unit
    length. `atom` counts the atoms of a DMS file.

    Raises
    ------
    InputError : not such a file, no normals, NaN or infinite numbers, normals of length 0, no dots
    """
    try:
        with open(path, "rb") as stream:
            archive = stream.read(2) == b"PK"
    except OSError:
        archive = False  # read_text finds the words for it
    if archive:
        columns = _read_npz(path)
    else:
        text = read_text(path)
        columns = (_read_csv if "," in text.split("\n", 1)[0] else _read_dms)(text, path)
    columns = {name: np.asarray(value) for name, value in columns.items()}
    points, normals = (columns[name].reshape(-1, 3) for name in ("points", "normals"))
    if len(points) == 0:
        raise InputError(f"{path} holds no dots; expected a DMS file, a CSV with x,y,z,nx,ny,nz, or an npz.")
    if not (np.isfinite(points).all() and np.isfinite(normals).all()):
        raise InputError(f"{path} has NaN or infinite coordinates or normals: remove those dots.")
    length = np.linalg.norm(normals, axis=1)
    short = np.flatnonzero(length < 0.5)
    if len(short):
        raise InputError(f"{path}: dot {short[0] + 1} has a normal of length {length[short[0]]:.3f}, not 1.")
    far = np.abs(length - 1) > ROUNDED
    columns["normals"] = np.where(far[:, None], normals / length[:, None], normals)
    _, first = np.unique(np.hstack([points, normals]), axis=0, return_index=True)
    if len(first) < len(points):
        log.warning("%s: %d dots that occur twice are removed", path, len(points) - len(first))
        columns = {name: value[np.sort(first)] for name, value in columns.items()}
    return Surface(**columns)


def _read_dms(text, path):
    """Columns of a DMS file, read from the type of the dot both ways, since the columns before it shift."""
    rows, kinds, atoms, atom = [], [], [], -1
    for number, line in enumerate(text.split("\n"), 1):
        found = list(DOT_TYPE.finditer(line))
        if not found:
            atom += line.rstrip().endswith(" A")
            continue
        head, rest = line[: found[-1].start()], line[found[-1].end() :].split()
        if len(rest) == 1:
            raise InputError(f"{path} has no normals: run dms again with the option -n.")
        row = _floats(head.split()[-3:] + rest)
        if row is None:  # long numbers touch each other: by columns then
            x = head[-27:-18] if head[-27:-26] == "-" else head[-26:-18]
            row = _floats([x, head[-18:-9], head[-9:], *rest])
        if row is None or len(row) != 7:
            raise InputError(f"{path}, line {number}: not a dot with its area and normal: {line.strip()!r}.")
        rows.append(row)
        kinds.append(KINDS[found[-1].group(1)])
        atoms.append(atom)
    table = np.array(rows, dtype=float).reshape(-1, 7)
    points, area, normals = table[:, :3], table[:, 3], table[:, 4:]
    return {"points": points, "normals": normals, "area": area, "kind": kinds, "atom": atoms}


def _floats(words):
    """The numbers, or None where one is none."""
    try:
        return [float(word) for word in words]
    except ValueError:
        return None


def _read_csv(text, path):
    """Columns of a table with x, y, z, nx, ny, nz in its header, in any case."""
    try:
        table = pd.read_csv(io.StringIO(text), skipinitialspace=True)
    except (pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise InputError(f"{path} is not a table of dots: {error}.") from None
    table.columns = [str(name).strip().lower() for name in table.columns]
    names = ["x", "y", "z", "nx", "ny", "nz"]
    wrong = [name for name in names if list(table.columns).count(name) != 1]
    if wrong:
        raise InputError(f"{path} needs one column {wrong[0]}; its header must name x, y, z, nx, ny, nz.")
    values = table[names].apply(pd.to_numeric, errors="coerce").to_numpy(float)
    return {"points": values[:, :3], "normals": values[:, 3:]}


def _read_npz(path):
    """Columns of a file of `write_npz`."""
    try:
        with np.load(path, allow_pickle=False) as file:
            columns = {name: file[name] for name in Surface.__dataclass_fields__}
    except (KeyError, ValueError, TypeError, OSError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{path} is not a surface written by this program: {error}.") from None
    n = columns["points"].shape[:1]
    shapes = {"points": (*n, 3), "normals": (*n, 3)}
    sound = [
        value.dtype.kind in "fiu" and value.shape == shapes.get(name, n) for name, value in columns.items()
    ]
    if not all(sound):
        raise InputError(f"{path} is not a surface written by this program: its arrays do not fit together.")
    return columns


def write_npz(path, surface):
    """Store a surface as numpy arrays; the same surface gives the same bytes."""
    with open(path, "wb") as stream:
        np.savez(stream, **{name: getattr(surface, name) for name in Surface.__dataclass_fields__})
