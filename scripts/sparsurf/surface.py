"""The molecular surface as dots with normals: made from atoms, read from files, stored."""

import io
import logging
import re
import shutil
import subprocess
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.atoms import read_text
from sparsurf.exports import write_dms, write_ply
from sparsurf.placement import CONCAVE, CONTACT, LATTICE, SADDLE, lay_dots

__all__ = [
    "DENSITY",
    "Surface",
    "molecular_surface",
    "read_surface",
    "surface_by_dms_program",
    "write_dms",
    "write_npz",
    "write_ply",
]

log = logging.getLogger("sparsurf")

# Dots per Å^2 that count as DMS's `-d 1.0`; A1 of TDP-43 gets 20045 dots on 3742 Å^2.
DENSITY = 5.35
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


def molecular_surface(xyz, radii, probe=1.4, density=DENSITY, reentrant="exact"):
    """Solvent-excluded surface of a set of spheres (Connolly, J. Appl. Cryst. 16:548, 1983).

    Parameters
    ----------
    xyz : (A, 3), centres of the atoms, Å
    radii : (A,), Å
    probe : radius of the probe, Å
    density : dots per Å^2; DENSITY gives the dots of DMS at `-d 1.0`
    reentrant : 'exact' for the surface itself; 'dms' for the dots that DMS gives, with its concave dots inside
        other probes, its uncovered narrow saddles and, on a few buried atoms, dots that no probe can touch

    Returns
    -------
    Surface, dots grouped by atom in the order of `xyz`

    Raises
    ------
    InputError
    """
    xyz, radii = np.asarray(xyz, dtype=float), np.asarray(radii, dtype=float)
    if xyz.ndim != 2 or xyz.shape[1] != 3 or len(xyz) == 0 or radii.shape != (len(xyz),):
        raise InputError(f"surface: needs (A, 3) centres and (A,) radii, not {xyz.shape} and {radii.shape}.")
    if not (np.abs(xyz) < FARTHEST).all():
        raise InputError(f"surface: coordinates must be numbers below {FARTHEST:.0f} Å.")
    if not (np.isfinite(radii) & (radii > 0)).all():
        raise InputError("surface: atomic radii must be positive numbers.")
    for name, value in (("probe_radius", probe), ("density", density)):
        if not 0 < value < np.inf:
            raise InputError(f"surface.{name} is {value}; it must be a positive number.")
    if reentrant not in ("exact", "dms"):
        raise InputError(f"surface.reentrant is {reentrant!r}; it must be 'exact' or 'dms'.")
    kept = _distinct(xyz, radii)
    lattice = LATTICE * (density / DENSITY)
    exact = reentrant == "exact"
    points, normals, area, kind, atom = lay_dots(xyz[kept], radii[kept], float(probe), lattice, exact)
    return Surface(points, normals, area, kind, kept[atom])


def _distinct(xyz, radii):
    """Indices of the atoms without those at the place of another (to 0.001 Å); the largest of each stays."""
    _, place = np.unique(np.round(xyz - xyz[0], 3), axis=0, return_inverse=True)
    by_place = np.lexsort((-radii, place))
    first = np.append(True, np.diff(place[by_place]) != 0)
    left_out = np.sort(by_place[~first])
    if len(left_out):
        message = "surface: %d atoms lie at the place of another and are left out, the first is number %d"
        log.warning(message, len(left_out), left_out[0] + 1)
    return np.sort(by_place[first])


def surface_by_dms_program(path_to_pdb, probe=1.4, density=DENSITY, program="dms"):
    """Surface by UCSF's program DMS, if there is one.

    Parameters
    ----------
    path_to_pdb : PDB file of one model, all of whose atoms are used
    probe : Å
    density : dots per Å^2, as for `molecular_surface`
    program : name looked up on the PATH

    Returns
    -------
    Surface; `atom` counts the atoms of the PDB file

    Raises
    ------
    InputError : no such program, or it fails
    """
    executable = shutil.which(program)
    if executable is None:
        raise InputError(f"surface.method dms needs the program {program} on the PATH; else use analytic.")
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(path_to_pdb, Path(folder, "in.pdb"))
        command = [executable, "in.pdb", "-a", "-n", "-d", f"{density / DENSITY:.6g}"]
        command += ["-w", f"{probe:.6g}", "-o", "out.dms"]
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace")
        output = Path(folder, "out.dms")
        if run.returncode != 0 or not output.is_file():
            reason = (run.stderr.strip().splitlines() or [f"exit status {run.returncode}"])[-1]
            raise InputError(f"{program} made no surface of {path_to_pdb}: {reason}")
        return read_surface(output)


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
