"""The molecular surface as dots with normals, and the checks that the dots of every file pass."""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from sparsurf.arguments import (
    MODELS,
    PROBE,
    PROBE_RADIUS,
    RADII_TABLES,
    Auto,
    Cavities,
    Model,
    Reentrant,
    index_array,
)
from sparsurf.display import Shown
from sparsurf.errors import FILE, InputError, argument, naming_file
from sparsurf.files import pluralise, shorten
from sparsurf.surfaces.plausibility import MIN_DOTS_TO_JUDGE, areas_are_known, check_plausibility

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike, DTypeLike

    from sparsurf.molecules.molecule import Molecule
    from sparsurf.settings import SurfaceSettings as SurfaceSettings

log = logging.getLogger("sparsurf")

CONTACT, SADDLE, CONCAVE = 0, 1, 2  # kinds of dots
COMPONENT_FIELD = "component"  # field of a Surface: component of each dot
# Å, median distance from dots to the centres of their atoms: at most the largest radius and that of a large probe
MAX_DISTANCE_OF_ATOM = 6.0
# Dots per Å^2 that correspond to `-d 1.0` of DMS: A1 of TDP-43 gets 20045 dots on 3742 Å^2.
DENSITY = 5.35
# Normals with three decimals deviate from unit length by at most sqrt(3) * 0.0005; the rest is a reserve.
ROUNDING_OF_NORMALS = 2e-3
SUSPICIOUS_NORMAL_DEVIATION = 0.05  # Normals that deviate so much from unit length may be other columns.
MIN_NORMAL_LENGTH = 1e-6
ARRAY_TYPES = {"points": float, "normals": float, "area": float, "kind": np.int8, "atom": np.int32}
ARRAY_NAMES = tuple(ARRAY_TYPES)
# Columns of the files of this program and of others that are not fields
RESERVED_COLUMNS = frozenset(
    ["x", "y", "z", "nx", "ny", "nz", "area", "kind", "dot", "weight", "spacing", "reach", "kept", "index", "id", "frame",
     "chain", "residue", "residue_name", "atom_name", "atom", "probe_radius", "radii", "reconstruction", "model",
     "red", "green", "blue", "alpha"]
)  # fmt: skip
FORBIDDEN_FIELDS = frozenset(["points", "normals", "self", "file", "allow_pickle"])  # names of arguments
# Of these, how the surface is reconstructed; files of versions before 6 have `model` in place of `reconstruction`
RECONSTRUCTION_COLUMNS = ("probe_radius", "radii", "reconstruction", "model")
MAX_DOT_COORDINATE = 2e6  # Å; atoms lie within half of it, damaged numbers do not
MAX_ATOM = np.iinfo(np.int32).max
MAX_AREA = 1.3e5  # Å^2 of one dot: the whole of the largest sphere (100 Å)
MAX_AREA_PER_MEDIAN = 1000  # areas on one surface differ by a factor of 10
# The labels of atoms by which the dots of a molecule are recognised.
LABELS = ("chain", "residue", "residue_name", "name")
MAX_ATOM_SHIFT = 0.01  # Å, between positions of the same atom; files hold three decimals
MIN_SHARE_OF_ATOMS = 0.5  # share of the dots' atoms that another molecule must contain


@dataclass(frozen=True)
class Placement:
    """How dots are placed on a molecule; the section `surface` of a config has the same keys and defaults."""

    probe_radius: float = PROBE_RADIUS  # Å
    density: float | Auto = "auto"  # dots per Å^2, or as many as d_link needs
    radii: Any = "dms"  # table of atomic radii, or those of the user
    cavities: Cavities = "keep"  # or remove
    reentrant: Reentrant = "exact"  # or dms


Rules: TypeAlias = "Placement | SurfaceSettings"


class Reconstruction(NamedTuple):
    """How the surface is reconstructed from dots of a subset; the files of a subset say it."""

    probe_radius: float  # Å, with which the dots were placed
    radii: str | None  # table of atomic radii; None where it is not known
    model: Model  # 'spheres', 'interpolant' or 'auto', as in `recover`

    @classmethod
    def of_columns(cls, columns: Mapping[str, Any]) -> Reconstruction | None:
        """Return what a file says by these columns, which hold one value each; None if it says nothing."""
        *names, old = RECONSTRUCTION_COLUMNS
        names = names if names[-1] in columns else [*names[:-1], old]
        values = [columns[name][0] if name in columns and len(columns[name]) else None for name in names]
        probe, radii, model = (None if value != value else value for value in values)
        number = isinstance(probe, float | int | np.number) and PROBE.allow(float(probe))
        if not number or model not in MODELS or radii not in (None, "", *RADII_TABLES):
            return None
        return cls(float(probe), str(radii) if radii else None, str(model))  # type: ignore[arg-type]

    @property
    def is_uneven(self) -> bool:
        """Whether the dots may lie far from evenly, so that their distances say nothing about the file."""
        return self.model == "spheres"

    @property
    def columns(self) -> dict[str, float | str]:
        """The same as columns of a table, blank where a value is not known."""
        return {"probe_radius": self.probe_radius, "radii": self.radii or "", "reconstruction": self.model}


@dataclass(frozen=True, eq=False)
class SurfaceOrigin:
    """The atoms that dots were placed on, and what follows from them."""

    molecule: Molecule | None  # None for spheres that the user gave
    frame: int  # its position
    xyz: np.ndarray  # (A, 3), of the atoms in that frame, Å
    rules: Rules  # by which the dots were placed
    d_link: float  # Å, that the density suits
    radii: np.ndarray  # (A,), of the atoms, Å
    rolled: Any  # RolledFrame from which all dots were placed; None for a part of them
    points: np.ndarray  # (N, 3), where the dots were placed, Å
    generator: Callable[[], tuple[Callable[[np.ndarray], Surface], np.ndarray]]  # see `surface_generator`
    # centres (B, 3) and radii (B,), Å, of the atoms of other groups, which were absent where the dots were placed
    partner: tuple[np.ndarray, np.ndarray] | None = None

    @classmethod
    def of_atoms(
        cls,
        molecule: Molecule | None,
        frame: int,
        xyz: np.ndarray,
        rules: Rules,
        d_link: float,
        radii: np.ndarray,
    ) -> SurfaceOrigin:
        """Make the origin of a part of the dots of a placement; it keeps no rolled probe."""
        nowhere = np.empty((0, 3))
        return cls(molecule, frame, xyz, rules, d_link, radii, None, nowhere, _not_placed)

    def components(self, surface: Surface) -> np.ndarray:
        """Return the component of each dot, (N,) int, of the Surface of all dots."""
        return _not_placed() if self.rolled is None else self.rolled.components(surface)

    @cached_property
    def areas_by_kind(self) -> np.ndarray:
        """Contact, saddle and concave area of each atom, (A, 3), Å^2, of all dots of a placement."""
        return _not_placed() if self.rolled is None else self.rolled.areas_by_kind(len(self.xyz))

    @property
    def table(self) -> str | None:
        """Name of the table of their radii; None for spheres with radii of the user."""
        return self.rules.radii if self.molecule is not None and isinstance(self.rules.radii, str) else None

    def reconstruction(self, model: Model) -> Reconstruction:
        """Return how the surface is reconstructed from some of the dots."""
        return Reconstruction(self.rules.probe_radius, self.table, model)

    @property
    def atoms_alone(self) -> SurfaceOrigin:
        """The same atoms and rules, without what places the dots again."""
        alone = SurfaceOrigin.of_atoms(
            self.molecule, self.frame, self.xyz, self.rules, self.d_link, self.radii
        )
        return replace(alone, partner=self.partner)

    def refuse_molecule(
        self, function: str, molecule: Molecule, frame: int | None, whole: bool = True
    ) -> None:
        """Raise InputError unless the dots lie on these atoms, of any frame if None; on half of them unless `whole`."""
        if self.molecule is None or (self.molecule is molecule and frame in (self.frame, None)):
            return
        matches = self._has_labels_of(molecule) if whole else True
        if matches and frame is not None:
            if self.frame != frame and self.frame < molecule.n_frames:
                raise InputError(
                    f"{function}: the dots are those of frame {self.frame}; give frame={self.frame}."
                )
            matches = self._has_positions_of(molecule.xyz[frame], whole)
        if not matches:
            remedy = "give their molecule, or none" if whole else ""
            remedy = remedy or "give their molecule and frame, or the pair (points, normals)"
            raise InputError(f"{function}: the dots were placed on other atoms; {remedy}.")

    def refuse_spheres(self, function: str, xyz: np.ndarray, radii: np.ndarray) -> None:
        """Raise InputError unless the dots lie on spheres at positions (A, 3) with radii (A,), Å."""
        for given, placed in ((xyz, self.xyz), (radii, self.radii)):
            if given.shape != placed.shape or not np.abs(given - placed).max() < MAX_ATOM_SHIFT:
                raise InputError(
                    f"{function}: the dots were placed on other spheres; give theirs, or the dots alone."
                )

    def _has_labels_of(self, molecule: Molecule) -> bool:
        return (
            self.molecule is not None
            and self.molecule.n_atoms == molecule.n_atoms
            and all(np.array_equal(getattr(self.molecule, key), getattr(molecule, key)) for key in LABELS)
        )

    def _has_positions_of(self, xyz: np.ndarray, whole: bool) -> bool:
        """Return whether all atoms, or half of the heavy ones in any order, are at positions (A, 3), Å."""
        assert self.molecule is not None
        if whole:
            return bool(np.abs(self.molecule.xyz[self.frame] - xyz).max() < MAX_ATOM_SHIFT)
        from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

        heavy = self.molecule.heavy
        positions = self.molecule.xyz[self.frame][heavy if heavy.any() else slice(None)]
        return bool(
            np.mean(np.asarray(cKDTree(xyz).query(positions)[0]) < MAX_ATOM_SHIFT) >= MIN_SHARE_OF_ATOMS
        )


class Recovered(NamedTuple):
    """Of which dots a surface was reconstructed: their number, and the share of them that lies on spheres of inferred atoms."""

    n_kept: int
    on_spheres: float


@dataclass(frozen=True, eq=False, init=False)
class Surface(Shown):
    """Dots of a molecular surface.

    The order of the dots matters, since the method visits them in this order. The arrays are copied.

    Attributes
    ----------
    points : (N, 3) float64, Å
    normals : (N, 3) float64, outward, of unit length up to the rounding of a file (three decimals)
    area : (N,) float64, Å^2; NaN where unknown
    kind : (N,) int8, 0 contact, 1 saddle, 2 concave; -1 where unknown
    atom : (N,) int32, index into the structure; -1 where unknown
    fields : dict, name -> (N,) float64, further values at the dots, such as a potential; NaN where unknown
    origin : SurfaceOrigin, if `sparsurf.surface` placed the dots, else None
    reconstruction : Reconstruction, if these are the dots of a subset whose probe and radii are known, else None
    recovered : Recovered, if `recover` made the surface of a few dots, which come first, else None

    Raises
    ------
    InputError
        There are no dots, shapes disagree, values are NaN, infinite or impossible, or normals are not unit vectors.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    area: NDArray[np.float64]
    kind: np.ndarray
    atom: np.ndarray
    fields: dict[str, np.ndarray]
    origin: SurfaceOrigin | None
    reconstruction: Reconstruction | None
    recovered: Recovered | None

    def __init__(
        self,
        points: ArrayLike,
        normals: ArrayLike,
        area: ArrayLike | None = None,
        kind: ArrayLike | None = None,
        atom: ArrayLike | None = None,
        fields: Mapping[str, ArrayLike] = MappingProxyType({}),
        origin: SurfaceOrigin | None = None,
        reconstruction: Reconstruction | None = None,
        recovered: Recovered | None = None,
    ) -> None:
        arrays = {"points": points, "normals": normals, "area": area, "kind": kind, "atom": atom}
        numbers = {
            name: real_numbers(value, f"surface: {name}")
            for name, value in arrays.items()
            if value is not None
        }
        if masks := [name for name, value in numbers.items() if value.dtype == bool]:
            raise InputError(f"surface: {masks[0]} holds True and False: give numbers.")
        n = len(numbers.get("points", ()))
        if "points" in numbers:
            with naming_file("surface"):
                warn_of_float16(numbers["points"])
        for name in ARRAY_NAMES:
            value = numbers.get(name, np.full(n, np.nan if name == "area" else -1))
            expected = (n, 3) if name in ("points", "normals") else (n,)
            if value.shape != expected:
                requested = "(N, 3), a row for each dot" if name == "points" else expected
                raise InputError(f"surface: {name} has the shape {value.shape}, not {requested}.")
            with np.errstate(invalid="ignore"):  # check_values sees values that the conversion damages
                object.__setattr__(self, name, np.array(value, ARRAY_TYPES[name], order="C"))
        object.__setattr__(self, "fields", _fields(fields, n))
        object.__setattr__(self, "origin", origin)
        object.__setattr__(self, "reconstruction", reconstruction)
        object.__setattr__(self, "recovered", recovered)
        if n == 0:
            raise InputError("surface: there are no dots.")
        if not (np.isfinite(self.points).all() and np.isfinite(self.normals).all()):
            raise InputError("surface: coordinates or normals are NaN or infinite.")
        if np.abs(np.linalg.norm(self.normals, axis=1) - 1).max() > ROUNDING_OF_NORMALS:
            raise InputError("surface: normals are not of unit length; divide each by its length.")
        columns = {name: numbers.get(name) for name in ("area", "kind", "atom")}
        with naming_file("surface"):
            check_values(self.points, columns["area"], columns["kind"], columns["atom"], dot_label)

    @classmethod
    def of_placed(
        cls, points: np.ndarray, normals: np.ndarray, area: np.ndarray, kind: np.ndarray, atom: np.ndarray
    ) -> Surface:
        """Make a surface that holds the arrays of dots as they were placed, of the types above: they are not copied."""
        if len(points) == 0:
            raise InputError("surface: there are no dots.")
        if not np.isfinite(area).all():
            raise InputError("surface: the area of a dot is not finite; give more dots per Å^2.")
        surface = object.__new__(cls)
        attributes = dict(zip(ARRAY_NAMES, (points, normals, area, kind, atom), strict=True))
        surface.__dict__.update(attributes, fields={}, origin=None, reconstruction=None, recovered=None)
        return surface

    def with_origin(self, origin: SurfaceOrigin) -> Surface:
        """Return the same dots with where they were placed; their arrays are not copied."""
        surface = object.__new__(type(self))
        surface.__dict__.update(self.__dict__, origin=origin)
        return surface

    def __repr__(self) -> str:
        return f"Surface of {pluralise(len(self), 'dot', separator=',')}"

    def __len__(self) -> int:
        return len(self.points)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> np.ndarray:
        """Return the points, (N, 3), as `numpy.asarray` asks for them."""
        if copy is False and dtype is not None and np.dtype(dtype) != self.points.dtype:
            raise ValueError(f"the points cannot be {np.dtype(dtype)} without a copy")
        return self.points.astype(self.points.dtype if dtype is None else dtype, copy=bool(copy))

    def __getitem__(self, dots: ArrayLike | slice) -> Surface:
        """Return the surface of some dots: a mask, indices, a slice, or the index of one dot."""
        if isinstance(dots, slice):
            return self.take(dots)
        return self.take(np.atleast_1d(index_array(dots, len(self), "dots")))

    def take(self, dots: np.ndarray | slice) -> Surface:
        """Return the surface of only `dots`, a mask or indices, with all that is known of them."""
        fields = {name: value[dots] for name, value in self.fields.items()}
        points, normals, area, kind, atom = (getattr(self, name)[dots] for name in ARRAY_NAMES)
        return Surface(points, normals, area, kind, atom, fields, self.origin, self.reconstruction)

    @property
    def molecule(self) -> Molecule | None:
        """The molecule that the dots were placed on, if it is known."""
        return self.origin.molecule if self.origin else None

    @property
    def exact_areas(self) -> np.ndarray | None:
        """Contact, saddle and concave area of each atom, (A, 3), Å^2; None unless these are all dots of a placement.

        Dots that are placed as DMS places them have no exact areas.
        """
        return (
            None if self.placed is None or self.placed.rules.reentrant == "dms" else self.placed.areas_by_kind
        )

    @property
    def total_area(self) -> float:
        """Area of the surface, Å^2: exact for all dots of a placement, otherwise the sum over the dots."""
        return float(self.area.sum() if self.exact_areas is None else self.exact_areas.sum())

    def area_of_walls(self, cavity: np.ndarray) -> float:
        """Return the area of the walls of cavities, Å^2, on which dots `cavity` (N,) bool lie; exact where `total_area` is."""
        if not cavity.any() or self.placed is None or self.exact_areas is None:
            return float(self.area[cavity].sum())
        outside = self.placed.rolled._replace(cavities="remove").areas_by_kind(len(self.placed.xyz))
        return float(self.exact_areas.sum() - outside.sum())

    def known_molecule(self, function: str) -> Molecule:
        """Return the molecule of the dots; raise InputError, in the name of a function, if they carry none."""
        if self.molecule is None:
            raise InputError(
                f"{function}: these dots carry no molecule; give it before them: {function}(molecule, dots, ...)."
            )
        return self.molecule

    def known_components(self, function: str) -> np.ndarray:
        """Return the component of each dot, (N,) int, 0 the largest; raise InputError unless these are all dots as placed."""
        if self.placed is None:
            raise InputError(
                f"{function}: this Surface is a subset; pass the complete surface that surface() returned."
            )
        return self.placed.components(self)

    @property
    def generator(self) -> tuple[Callable[[np.ndarray], Surface], np.ndarray] | tuple[None, None]:
        """What places other dots on moved atoms, and the atoms' positions; (None, None) unless `placed`."""
        return self.placed.generator() if self.placed else (None, None)

    @property
    def placed(self) -> SurfaceOrigin | None:
        """The origin, if the surface still has all dots where they were placed; else None."""
        return self.origin if self.origin and np.array_equal(self.points, self.origin.points) else None

    def to_frame(self, molecule: Molecule | None = None, **columns: np.ndarray) -> pd.DataFrame:
        """Tabulate position, normal, area, kind and fields of the dots, and labels of their atoms where these are known.

        Parameters
        ----------
        molecule : Molecule, optional
            That of the dots, where they carry none.
        **columns : (N,) arrays
            Further columns by name.
        """
        import pandas as pd  # here: it takes long to load

        return pd.DataFrame(self.columns(molecule, columns))

    def columns(
        self, molecule: Molecule | None = None, columns: Mapping[str, np.ndarray] | None = None
    ) -> dict[str, np.ndarray]:
        """Return the columns of `to_frame` by name."""
        if molecule is not None:
            _refuse_other_molecule(self, molecule)
        names = ("x", "y", "z", "nx", "ny", "nz")
        table: dict[str, np.ndarray] = dict(zip(names, [*self.points.T, *self.normals.T], strict=True))
        table |= {"area": self.area, "kind": self.kind}
        if self.placed:
            table[COMPONENT_FIELD] = self.placed.components(self)
        table |= columns or {}
        molecule = self.molecule if molecule is None else molecule
        table |= {} if molecule is None else molecule.label_columns(self.atom)
        return table | {name: values for name, values in self.fields.items() if name not in table}


def _not_placed(*_: Any) -> Any:
    """Stand for what only all dots of a placement have; `Surface.placed` is None where an origin holds it."""
    raise InputError("surface: this Surface is a subset; pass the complete surface that surface() returned.")


def _refuse_other_molecule(surface: Surface, molecule: Molecule) -> None:
    """Raise InputError if the atoms of the dots are not those of a molecule."""
    atom = surface.atom
    if not (hasattr(molecule, "labels") and hasattr(molecule, "n_atoms")):
        raise InputError("to_frame: the molecule must come from read_molecule; give one, or leave it out.")
    if atom.min() < 0:
        raise InputError("to_frame: the atoms of the dots are unknown; leave out the molecule.")
    far = atom.max() >= molecule.n_atoms or not any(
        np.median(np.linalg.norm(surface.points - xyz[atom], axis=1)) < MAX_DISTANCE_OF_ATOM
        for xyz in molecule.xyz
    )
    described = surface.molecule or molecule
    alike = described.n_atoms == molecule.n_atoms and np.array_equal(
        described.residue_name, molecule.residue_name
    )
    if far or not alike:
        raise InputError("to_frame: the dots were placed on other atoms; give their molecule, or none.")


def real_numbers(value: Any, name: str) -> np.ndarray:
    """Return an array of real numbers with an axis at least; raise InputError for anything else, which it calls `name`."""
    try:
        array = np.asarray(value)
        array = array.astype(float) if array.dtype.kind == "O" else array
    except (TypeError, ValueError, OverflowError):
        array = np.array("")
    if array.dtype.kind not in "biuf" or array.ndim == 0:
        raise InputError(f"{argument(name)} must hold real numbers, in rows of equal length.")
    if np.ma.is_masked(value):
        raise InputError(f"{argument(name)} has masked values; leave these dots out.")
    return array


def _fields(fields: Any, n: int) -> dict[str, np.ndarray]:
    """Return the fields of n dots, a mapping or a DataFrame, as arrays; raise InputError for anything else."""
    if not hasattr(fields, "items") or not all(isinstance(name, str) for name in fields):
        raise InputError("surface: fields must be a dictionary of names and arrays.")
    for name in fields:
        if not is_field_name(name):
            raise InputError(
                f"surface: a field cannot be called {name!r}: use letters, digits and _, and no column of dots such as area."
            )
    arrays = {
        name: real_numbers(value, f"surface: the field {name}").astype(float)
        for name, value in fields.items()
    }
    for name, array in arrays.items():
        if array.shape != (n,):
            raise InputError(f"surface: the field {name} has the shape {array.shape}, not {(n,)}.")
        if np.isinf(array).any():
            raise InputError(f"surface: the field {name} is infinite at a dot; put NaN where it is unknown.")
    return arrays


class SurfaceFormat(NamedTuple):
    """A file format that holds a surface."""

    # from the first bytes of an unpacked file to whether it has this format
    sniff: Callable[[bytes], bool]
    # from the unpacked bytes of a file, which messages call FILE
    read: Callable[[bytes], Surface]


def surface_of_columns(
    columns: Mapping[str, ArrayLike],
    lines: list[int] | np.ndarray | None = None,
    weighted: bool = False,
    judge: bool = True,
    reconstruction: Reconstruction | None = None,
) -> Surface:
    """Make a surface from the columns of a file: points, normals, other attributes of `Surface`, and fields, by name.

    Normals that deviate from unit length only by rounding stay as they are: the authors' descriptors follow from the
    rounded normals, and one dot in 40 changes its pixel otherwise. Of dots that occur twice, the first is kept. Messages name
    the `lines` (N,) of the dots. If `weighted`, each dot stands for several, and some own much more area than others.
    Unless `judge`, the distances and normals of neighbouring dots are not judged, which takes a quarter of a second; those of an
    uneven subset never are.
    """
    judge = judge and not (reconstruction and reconstruction.is_uneven)
    arrays = {name: np.asarray(value) for name, value in columns.items()}
    points, normals = (arrays[name].reshape(-1, 3) for name in ("points", "normals"))
    if len(points) == 0:
        raise InputError(f"{FILE} holds no dots.")

    def where(dot: int) -> str:
        return f"line {lines[dot]}" if lines is not None else dot_label(dot)

    finite = np.isfinite(points).all(axis=1) & np.isfinite(normals).all(axis=1)
    if not finite.all():
        raise InputError(
            f"{FILE}: {where(int(np.argmin(finite)))} has NaN or infinite coordinates or normals: repair or remove it."
        )
    check_values(points, arrays.get("area"), arrays.get("kind"), arrays.get("atom"), where)
    length = _checked_lengths(points, normals, where)
    to_scale = np.abs(length - 1) > ROUNDING_OF_NORMALS
    arrays["normals"] = np.where(to_scale[:, None], normals / length[:, None], normals)
    _, first = np.unique(np.hstack([points, normals]), axis=0, return_index=True)
    if len(first) < len(points):
        message = (
            "%s: dots that occur twice are removed (%d); numbers of dots count those that remain, from 0"
        )
        log.warning(message, FILE, len(points) - len(first))
    # In the order of the file, on which the sampling depends
    first = np.sort(first)
    arrays = {name: value[first] for name, value in arrays.items()}
    if judge:
        check_plausibility(arrays["points"], arrays["normals"], lambda dot: where(int(first[dot])))
    if "area" in arrays and not areas_are_known(arrays["points"], arrays["area"], weighted, judge):
        del arrays["area"]
    fields = {name: arrays.pop(name) for name in list(arrays) if name not in ARRAY_NAMES}
    for name, values in fields.items():
        if np.isinf(values).any():
            dot = int(first[np.argmax(np.isinf(values))])
            raise InputError(f"{FILE}: {where(dot)} has an infinite {name}: put NaN where it is unknown.")
    area, kind, atom = (arrays.get(name) for name in ("area", "kind", "atom"))
    return Surface(
        arrays["points"], arrays["normals"], area, kind, atom, fields, reconstruction=reconstruction
    )


def reconstruction_of_file(columns: Mapping[str, Any]) -> Reconstruction | None:
    """Return what a file says by its columns; warn of columns of these names that say something else, since no field has them."""
    reconstruction = Reconstruction.of_columns(columns)
    names = [name for name in Reconstruction._fields if np.size(columns.get(name, ()))]
    if reconstruction is None and names:
        message = "%s: the columns %s are left out, since these names say how a surface is reconstructed; rename them"
        log.warning(message, FILE, ", ".join(names))
    return reconstruction


def warn_of_float16(points: np.ndarray) -> None:
    """Warn of positions in half precision."""
    if points.dtype == np.float16 and points.size:
        largest = np.abs(points[np.isfinite(points)]).max(initial=0)
        message = "%s: its positions are float16, which rounds them by up to %.1g Å; give float32 or float64"
        log.warning(message, FILE, math.sqrt(3) / 2 * float(np.spacing(largest)))


def is_field_name(name: str) -> bool:
    """Return whether a column of this name in a file of dots is a field."""
    return (
        name.lower() not in RESERVED_COLUMNS | FORBIDDEN_FIELDS
        and re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII) is not None
    )


def warn_of_field_names(names: Iterable[str]) -> None:
    """Warn of numbers of the dots of a file that cannot be fields, because of their names."""
    for name in names:
        if name and name.lower() not in RESERVED_COLUMNS and not is_field_name(name):
            message = "%s: the column %s is left out: the name of a field may contain only letters, digits and _; rename it"
            log.warning(message, FILE, shorten(repr(name)))


def _checked_lengths(points: np.ndarray, normals: np.ndarray, where: Callable[[int], str]) -> np.ndarray:
    """Return the lengths of normals (N,); raise an error for lengths near 0, warn of lengths far from 1."""
    length = np.linalg.norm(normals, axis=1)
    short = np.flatnonzero(length < MIN_NORMAL_LENGTH)
    if len(short):
        raise InputError(
            f"{FILE}: {where(short[0])} has a normal of length 0: remove it, or give its direction."
        )
    suspicious = np.abs(length - 1).max() > SUSPICIOUS_NORMAL_DEVIATION
    if suspicious and np.abs(np.linalg.norm(points, axis=1) - 1).max() < SUSPICIOUS_NORMAL_DEVIATION:
        raise InputError(
            f"{FILE} has normals of length {length.min():.3g} to {length.max():.3g} and positions of length 1: exchange the "
            "columns x,y,z and nx,ny,nz."
        )
    if suspicious:
        log.warning("%s: normals of length %.3g to %.3g are scaled to 1", FILE, length.min(), length.max())
    return length


def dot_label(dot: int) -> str:
    """Name a dot in a message where its line in the file is unknown."""
    return f"dot {dot + 1}"


def largest_area(areas: np.ndarray) -> float:
    """Return the largest area of one dot, Å^2, that dots with these areas (N,) can have."""
    # The median of a few dots of a subset says nothing: one of them may own most of the surface
    median = np.median(areas) if len(areas) >= MIN_DOTS_TO_JUDGE else 0
    return float(min(MAX_AREA, MAX_AREA_PER_MEDIAN * median or MAX_AREA))


def check_values(
    points: np.ndarray,
    area: ArrayLike | None,
    kind: ArrayLike | None,
    atom: ArrayLike | None,
    where: Callable[[int], str],
) -> None:
    """Raise InputError if a coordinate, an area, a kind or an atom, each (N,) or None, is not possible; `where` names a dot."""

    def known_or(value: ArrayLike | None, unknown: float) -> np.ndarray:
        return np.full(len(points), unknown, float) if value is None else np.asarray(value, float)

    areas, kinds, atoms = known_or(area, np.nan), known_or(kind, -1), known_or(atom, -1)
    unknown = np.isnan(areas)
    largest = MAX_AREA if unknown.any() else largest_area(areas)
    wrong = {
        f"a coordinate beyond {MAX_DOT_COORDINATE:.0e} Å": (np.abs(points) >= MAX_DOT_COORDINATE).any(axis=1),
        "an area that is NaN, unlike others": unknown & (not unknown.all()),
        "a negative area": areas < 0,
        f"an area above {largest:.3g} Å^2": areas > largest,
        "a kind other than 0, 1 or 2 (-1: unknown)": ~np.isin(kinds, range(-1, 3)),
        "an atom that is not an index": ~((atoms >= -1) & (atoms % 1 == 0) & (atoms <= MAX_ATOM)),
    }
    for problem, rows in wrong.items():
        if rows.any():
            dot = int(np.argmax(rows))
            value = f" ({', '.join(f'{x:g}' for x in points[dot])})" if "coordinate" in problem else ""
            raise InputError(f"{FILE}: {where(dot)} has {problem}{value}: repair or remove it.")
