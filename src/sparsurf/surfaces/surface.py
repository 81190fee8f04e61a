"""The molecular surface as dots with normals, and the checks that the dots of any file pass."""

import logging
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module  # of what matplotlib and pandas draw: few ask for it
from typing import NamedTuple

import numpy as np

from sparsurf import InputError
from sparsurf.molecules.geometry import MAX_GAP, widest_gap

log = logging.getLogger("sparsurf")

CONTACT, SADDLE, CONCAVE = 0, 1, 2  # kinds of dots
# Dots per Å^2 that count as DMS's `-d 1.0`; A1 of TDP-43 gets 20045 dots on 3742 Å^2.
DENSITY = 5.35
ROUNDED = 2e-3  # normals of three decimals are this near to unit length: sqrt(3) * 0.0005 and a reserve
ODD = 0.05  # normals so far from unit length may be something else
ARRAYS = ("points", "normals", "area", "kind", "atom")
# Columns of this program's own files, and of other programs', that are no field
NO_FIELDS = frozenset(
    ["x", "y", "z", "nx", "ny", "nz", "area", "kind", "dot", "weight", "spacing", "reach", "kept", "index", "id", "frame",
     "chain", "residue", "residue_name", "atom_name", "atom", "red", "green", "blue", "alpha"]
)  # fmt: skip
FARTHEST = 2e6  # Å; atoms lie within half of it, a damaged number does not
LARGEST = 1.3e5  # Å^2, the whole of the largest sphere (100 Å)
UNLIKE = 1000  # times the median area; areas of one surface differ by 10
SAMPLE = 200  # dots that are compared with their nearest neighbours
FEWEST = 50  # dots of a surface that is judged
CLOSE = 1.8  # Å, neighbours that belong to the same part of a surface; a twentieth of the dots lies so close
ALIKE = 0.8  # share of neighbours whose normals point to one side; .97 and more on surfaces, .5 by chance
# Å, distance of neighbours by the angle between their normals: 1.5 to 2.3 on molecular surfaces of all densities
ROUNDEST, FLATTEST = 0.4, 10.0
DENSE, MANY = (
    0.8,
    1000,
)  # Å, and dots: of such a surface the normals cancel to .01, of a half of it to .07 or more
OPEN = 0.03


class Origin(NamedTuple):
    """The atoms that dots were placed on.

    molecule : Molecule
    frame : int, its position
    rules : dict, probe, density, radii, d_link and cavities of the call
    components : function of all dots to the component of each, (N,); what comes of dots needs no such search
    points : (N, 3), where the dots were placed, Å
    """

    molecule: object
    frame: int
    rules: dict
    components: Callable
    points: np.ndarray


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
    origin : Origin, where `sparsurf.surface` placed the dots on a molecule

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
    origin: Origin | None = None

    def __repr__(self):
        return f"Surface of {len(self):,} dots"

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
        return Surface(*(getattr(self, name)[dots] for name in ARRAYS), fields, self.origin)

    @property
    def placed(self):
        """The origin of dots that are all that were placed, where they were placed; None of others."""
        return self.origin if self.origin and np.array_equal(self.points, self.origin.points) else None

    def to_frame(self, molecule=None, **columns):
        """DataFrame of the dots: place, normal, area, kind; labels of their atoms, given the molecule; `columns`, (N,) each."""
        return import_module("sparsurf.surfaces.showing").to_frame(self, molecule, **columns)

    def plot(self, values=None, ax=None):
        """Picture by matplotlib, coloured by `values` (N,) or by kind; returns the Axes."""
        return import_module("sparsurf.surfaces.showing").plot(self, values, ax)

    def show(self, values=None):
        """View to turn by PyVista or py3Dmol, coloured as in `plot`."""
        return import_module("sparsurf.surfaces.showing").show(self, values)


@dataclass(frozen=True)
class Format:
    """A kind of file that holds a surface.

    Attributes
    ----------
    name : what people call it
    suffixes : endings of its files, in lower case; a file may also be packed (.gz)
    sniff : first bytes of a file, unpacked -> whether it is of this format
    read : (bytes of the file, unpacked; path for messages) -> Surface; None for a format that is only written
    write : (path, surface, and what else the format shows); None for a format that is only read
    """

    name: str
    suffixes: tuple
    sniff: Callable
    read: Callable | None = None
    write: Callable | None = None


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
        message = (
            "%s: dots that occur twice are removed (%d); numbers of dots count those that remain, from 0"
        )
        log.warning(message, path, len(points) - len(first))
        columns = {name: value[np.sort(first)] for name, value in columns.items()}
    fields = {name: columns.pop(name) for name in list(columns) if name not in ARRAYS}
    return Surface(**columns, fields=fields)


def is_field(name):
    """Whether a column of a file of dots is taken for a field, by its name."""
    return name not in NO_FIELDS and re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII) is not None


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


def refuse_implausible(points, normals, path, where):
    """Raise InputError, or warn, where dots are not those of a molecular surface in Å.

    Parameters
    ----------
    points, normals : (N, 3) float, finite
    path : named in messages
    where : function of the index of a dot, how a message calls it
    """
    if len(points) < FEWEST:
        return
    gap, dot = widest_gap(points)
    if gap > MAX_GAP:
        raise InputError(f"{path}: {where(dot)} lies {gap:.0f} Å from all other dots: remove or repair it.")
    some = np.linspace(0, len(points) - 1, SAMPLE).astype(int)
    distance, other = nearest_of(points, some)
    cosine = (normals[some] * normals[other]).sum(axis=1)
    spacing, alike = float(np.median(distance)), float((cosine > 0).mean())
    if spacing < CLOSE and alike < ALIKE:
        raise InputError(
            f"{path}: {1 - alike:.0%} of neighbouring dots have normals that oppose each other: give outward normals."
        )
    bend = math.acos(min(1.0, float(np.median(cosine))))
    radius = spacing / bend if bend > 0 else math.inf
    if 0 < radius < ROUNDEST:
        raise InputError(
            f"{path}: dots lie {spacing:.3f} Å apart on curves of {radius:.2f} Å: lengths seem to be nm, give Å."
        )
    if FLATTEST < radius < 10 * FLATTEST:
        log.warning("%s: dots lie on curves of %.0f Å; are lengths in Å?", path, radius)
    if len(points) > MANY and spacing < DENSE:
        _warn_of_open(points, normals, path)


def _warn_of_open(points, normals, path):
    rest = np.linalg.norm(normals.mean(axis=0))
    if rest > OPEN:
        message = "%s: the dots do not close around a molecule (%.0f %% of the normals do not cancel); is it cut short?"
        log.warning(message, path, 100 * rest)
    elif ((points - points.mean(axis=0)) * normals).sum() < 0:
        log.warning("%s: normals point inwards; the method wants them outwards", path)


def nearest_of(points, some):
    """Distance from the dots of index `some` to their nearest other dot, and its index, without a kernel."""
    distances, others = np.empty(len(some)), np.empty(len(some), int)
    for n, i in enumerate(some):
        squared = ((points - points[i]) ** 2).sum(axis=1)
        squared[i] = np.inf
        others[n] = squared.argmin()
        distances[n] = math.sqrt(squared[others[n]])
    return distances, others


def number_of_dot(dot):
    """How messages call a dot of which no line is known."""
    return f"dot {dot + 1}"


def refuse_impossible_values(points, area, kind, atom, path, where):
    """Raise InputError where a value of a dot, called `where(its index)`, cannot be; kind and atom may be None."""
    area, kind, atom = (
        np.asarray(np.full(len(points), default) if value is None else value, float)
        for value, default in ((area, np.nan), (kind, -1), (atom, -1))
    )
    unknown = np.isnan(area)
    usual = np.median(area) if len(area) >= FEWEST and not unknown.any() else 0
    largest = min(LARGEST, UNLIKE * usual or LARGEST)
    wrong = {
        f"a coordinate beyond {FARTHEST:.0e} Å": (np.abs(points) >= FARTHEST).any(axis=1),
        "an area that is NaN, unlike others": unknown & (not unknown.all()),
        "a negative area": area < 0,
        f"an area above {largest:.3g} Å^2": area > largest,
        "a kind other than 0, 1 or 2 (-1: unknown)": ~np.isin(kind, range(-1, 3)),
        "an atom that is no index": ~((atom >= -1) & (atom % 1 == 0)),
    }
    for what, rows in wrong.items():
        if rows.any():
            dot = int(np.argmax(rows))
            value = points[dot] if "coordinate" in what else None
            raise InputError(f"{path}: {where(dot)} has {what}{_of(value)}: repair or remove it.")


def _of(place):
    return "" if place is None else " (" + ", ".join(f"{x:g}" for x in place) + ")"
