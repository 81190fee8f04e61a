"""The molecular surface as dots with normals, and the checks that the dots of any file pass."""

import logging
import re
from dataclasses import dataclass, field
from importlib import import_module  # of what matplotlib and pandas draw: few ask for it

import numpy as np

from sparsurf import InputError
from sparsurf.surfaces.plausible import number_of_dot, refuse_implausible, refuse_impossible_values

log = logging.getLogger("sparsurf")

CONTACT, SADDLE, CONCAVE = 0, 1, 2  # kinds of dots
# Dots per Å^2 that count as DMS's `-d 1.0`; A1 of TDP-43 gets 20045 dots on 3742 Å^2.
DENSITY = 5.35
ROUNDED = 2e-3  # normals of three decimals are this near to unit length: sqrt(3) * 0.0005 and a reserve
ODD = 0.05  # normals so far from unit length may be something else
ARRAYS = ("points", "normals", "area", "kind", "atom")
# Columns of this program's own files, and of other programs', that are no field
NO_FIELDS = frozenset(
    {
        "x",
        "y",
        "z",
        "nx",
        "ny",
        "nz",
        "area",
        "kind",
        "dot",
        "weight",
        "spacing",
        "reach",
        "kept",
        "index",
        "id",
    }
    | {"chain", "residue", "residue_name", "atom_name", "atom", "red", "green", "blue", "alpha"}
)


@dataclass(frozen=True, eq=False)
class Surface:
    """Dots of a molecular surface; their order is part of it, since the method sweeps them in it. The arrays are copied.

    Attributes
    ----------
    points : (N, 3) float64, Å
    normals : (N, 3) float64, outward, unit length but for the rounding of a file (three decimals)
    area : (N,) float64, Å^2; NaN where unknown
    kind : (N,) int8, 0 contact, 1 saddle, 2 concave; -1 where unknown
    atom : (N,) int32, index into the structure; -1 where unknown
    fields : dict, name -> (N,) float64, further numbers at the dots, such as a potential; NaN where unknown

    Raises
    ------
    InputError : no dots, shapes that disagree, NaN, infinite or impossible values, normals that are not unit vectors
    """

    points: np.ndarray
    normals: np.ndarray
    area: np.ndarray = None
    kind: np.ndarray = None
    atom: np.ndarray = None
    fields: dict = field(default_factory=dict)

    def __post_init__(self):
        n = len(self.points)
        given = self.area, self.kind, self.atom  # before they are cut to their types
        types = {"points": float, "normals": float, "area": float, "kind": np.int8, "atom": np.int32}
        for name, dtype in types.items():
            value = getattr(self, name)
            if value is None:
                value = np.full(n, np.nan if name == "area" else -1)
            with np.errstate(invalid="ignore"):  # what is lost is noticed below
                object.__setattr__(self, name, np.array(value, dtype, order="C"))
            shape, found = ((n, 3) if name in ("points", "normals") else (n,)), getattr(self, name).shape
            if found != shape:
                requested = "(N, 3), a row for each dot" if name == "points" else shape
                raise InputError(f"surface: {name} has the shape {found}, not {requested}.")
        object.__setattr__(self, "fields", {k: np.array(v, float) for k, v in self.fields.items()})
        for name, value in self.fields.items():
            if value.shape != (n,):
                raise InputError(f"surface: the field {name} has the shape {value.shape}, not {(n,)}.")
        if n == 0:
            raise InputError("surface: there are no dots.")
        if not (np.isfinite(self.points).all() and np.isfinite(self.normals).all()):
            raise InputError("surface: coordinates or normals are NaN or infinite.")
        if np.abs(np.linalg.norm(self.normals, axis=1) - 1).max() > ROUNDED:
            raise InputError("surface: normals are not of unit length; divide each by its length.")
        refuse_impossible_values(self.points, *given, "surface", number_of_dot)

    def __len__(self):
        return len(self.points)

    def take(self, dots):
        """The surface of only `dots`, a mask or indices, with all that is known of them."""
        fields = {name: value[dots] for name, value in self.fields.items()}
        return Surface(*(getattr(self, name)[dots] for name in ARRAYS), fields)

    def to_frame(self, molecule=None, **columns):
        """DataFrame of the dots, see `showing.to_frame`."""
        return import_module("sparsurf.surfaces.showing").to_frame(self, molecule, **columns)

    def plot(self, values=None, ax=None):
        """Picture by matplotlib, see `showing.plot`."""
        return import_module("sparsurf.surfaces.showing").plot(self, values, ax)

    def show(self, values=None):
        """View to turn by PyVista or py3Dmol, see `showing.show`."""
        return import_module("sparsurf.surfaces.showing").show(self, values)


def surface_of_columns(columns, path, lines=None):
    """The surface of the columns that a file holds.

    Parameters
    ----------
    columns : dict of arrays: points and normals, any other attribute of `Surface`, and fields by their names
    path : named in messages
    lines : (N,) int, line of the file that each dot stands in, for messages

    Returns
    -------
    Surface, in the order of the file; normals as they are where only rounding keeps them from unit length (the
    authors' descriptors follow from the rounded ones: a dot in 40 changes its pixel otherwise), else of unit
    length; of dots that occur twice the first

    Raises
    ------
    InputError : NaN or infinite numbers, normals of length 0, no dots, values that no surface in Å has
    """
    columns = {name: np.asarray(value) for name, value in columns.items()}
    points, normals = (columns[name].reshape(-1, 3) for name in ("points", "normals"))
    if len(points) == 0:
        raise InputError(f"{path} holds no dots.")

    def where(dot):
        return f"line {lines[dot]}" if lines is not None else number_of_dot(dot)

    finite = np.isfinite(points).all(axis=1) & np.isfinite(normals).all(axis=1)
    if not finite.all():
        raise InputError(
            f"{path}: {where(int(np.argmin(finite)))} has NaN or infinite coordinates or normals: repair or remove it."
        )
    others = (columns.get(name) for name in ("area", "kind", "atom"))
    refuse_impossible_values(points, *others, path, where)
    length = _checked_lengths(points, normals, path, where)
    far = np.abs(length - 1) > ROUNDED
    columns["normals"] = np.where(far[:, None], normals / length[:, None], normals)
    refuse_implausible(points, columns["normals"], path, where)
    _, first = np.unique(np.hstack([points, normals]), axis=0, return_index=True)
    if len(first) < len(points):
        message = "%s: %d dots that occur twice are removed; numbers of dots count those that remain, from 0"
        log.warning(message, path, len(points) - len(first))
        columns = {name: value[np.sort(first)] for name, value in columns.items()}
    fields = {name: columns.pop(name) for name in list(columns) if name not in ARRAYS}
    return Surface(**columns, fields=fields)


def is_field(name):
    """Whether a column of a file of dots is taken for a field, by its name."""
    return name not in NO_FIELDS and re.fullmatch(r"[A-Za-z]\w*", name) is not None


def _checked_lengths(points, normals, path, where):
    """Lengths of normals (N,), none near 0; a warning where they are not about 1."""
    length = np.linalg.norm(normals, axis=1)
    short = np.flatnonzero(length < 0.5)
    if len(short):
        raise InputError(f"{path}: {where(short[0])} has a normal of length {length[short[0]]:.3f}, not 1.")
    odd = np.abs(length - 1).max() > ODD
    if odd and np.abs(np.linalg.norm(points, axis=1) - 1).max() < ODD:
        raise InputError(
            f"{path} has normals of length {length.min():.3g} to {length.max():.3g} and places of length 1: exchange the "
            "columns x,y,z and nx,ny,nz."
        )
    if odd:
        log.warning("%s: normals of length %.3g to %.3g are scaled to 1", path, length.min(), length.max())
    return length
