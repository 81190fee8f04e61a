"""Molecules, dots and numbers that the functions for users take; the limits of numbers are those of the config."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Sequence
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeGuard, cast

import numpy as np

from sparsurf.errors import InputError
from sparsurf.molecules.formats import SELF_CONTAINED, STRUCTURES, TOPOLOGIES, suffix
from sparsurf.molecules.libraries import (
    from_biopython,
    from_biotite,
    from_gemmi,
    from_mdanalysis,
    from_mdtraj,
)
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.molecular_surface import MAX_DENSITY
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.surface import Origin, Surface, check_plausibility, dot_label

if TYPE_CHECKING:
    import gemmi
    from Bio.PDB.Entity import Entity
    from biotite.structure import AtomArray, AtomArrayStack
    from MDAnalysis import AtomGroup, Universe
    from mdtraj import Trajectory
    from numpy.typing import ArrayLike

    from sparsurf.study.minimal_subset import Subset

# What the functions take as a molecule, and as dots; a molecule is also taken for the dots on it.
MoleculeLike: TypeAlias = (
    "str | Path | Molecule | Trajectory | AtomArray | AtomArrayStack | AtomGroup | Universe"
    " | gemmi.Structure | gemmi.Model | Entity"
)
DotsLike: TypeAlias = "str | Path | Surface | Subset | tuple[ArrayLike, ArrayLike]"
SurfaceLike: TypeAlias = "DotsLike | MoleculeLike"

log = logging.getLogger("sparsurf")

MOLECULES = STRUCTURES + SELF_CONTAINED + TOPOLOGIES
LABELS = ("chain", "residue", "residue_name", "name")  # of atoms; the dots of a molecule are known by them
MAX_SHIFT = 0.01  # Å, between positions of the same atom; files hold three decimals
MIN_SHARE_OF_ATOMS = 0.5  # share of the dots' atoms that another molecule must contain
MAX_DISTANCE_FROM_ATOMS = 8.0  # Å; dots lie within the radii of an atom and the probe
MIN_DOTS_TO_COMPARE, MAX_DOTS_TO_COMPARE = 10, 200
# Settings that place dots, with their defaults
PLACEMENT_DEFAULTS = {
    "frame": 0,
    "probe_radius": PROBE_RADIUS,
    "density": "auto",
    "radii": "dms",
    "cavities": "keep",
}


class Limits(NamedTuple):
    """Finite numbers above `low` (or from it on), at most `high`."""

    low: float
    high: float = math.inf
    whole: bool = False
    open_low: bool = True

    def allow(self, value: float) -> bool:
        """Return whether a real number lies within the limits; NaN and infinity never do."""
        above = self.low < value or (value == self.low and not self.open_low)
        return above and value <= self.high and value < math.inf and (not self.whole or value % 1 == 0)

    @property
    def words(self) -> str:
        """Allowed numbers in words."""
        number = f"a {'whole ' * self.whole}number"
        if self.high < math.inf:
            least = f"more than {self.low:g} and at most" if self.open_low else f"{self.low:g} to"
            return f"{number}, {least} {self.high if self.whole else f'{self.high:g}'}"
        return f"{number}, more than {self.low:g}" if self.open_low else f"{number}, {self.low:g} or more"

    def check(self, value: Any, name: str, word: str | None = None) -> Any:
        """Return the number that the user gave as `name`, a float or, of whole numbers, an int.

        Parameters
        ----------
        value : anything
        name : str
        word : str, optional
            Allowed as well, and returned as it is.

        Raises
        ------
        InputError
            Not a number, or a number outside the limits.
        """
        if word is not None and isinstance(value, str) and value == word:
            return value
        is_number = isinstance(value, Real) and not isinstance(value, bool)
        if not is_number or not self.allow(value):
            either = "" if word is None else f"{word!r} or "
            raise InputError(f"{name} is {value!r}; it must be {either}{self.words}.")
        return int(value) if self.whole else float(value)


LENGTH = Limits(0, 100)  # Å: R_patch, R_zernike, D_link
PROBE = Limits(0, 10)  # Å
DENSITY = Limits(0, MAX_DENSITY)  # dots per Å^2
PERCENT = Limits(0, 100)
ALPHA = Limits(0, 1)
EXPONENT = Limits(0, 1000, open_low=False)  # beta, gamma, delta
SEED = Limits(0, 2**64 - 1, whole=True, open_low=False)
TEST_DOTS = Limits(2, 1_000_000, whole=True, open_low=False)
NUMBER_OF_DOTS = Limits(0, whole=True)
ERROR = Limits(0, open_low=False)  # Z


def as_molecule(source: MoleculeLike) -> Molecule:
    """Return a Molecule from itself, a path, or the atoms of mdtraj, biotite, MDAnalysis, gemmi or Biopython.

    Raises
    ------
    InputError
        None of these.
    """
    if isinstance(source, Molecule):
        return source
    if isinstance(source, str | Path):
        return read_molecule(source)
    convert = _converter(source)
    if convert is None:
        raise InputError(
            f"{_with_article(source)} is not a molecule: give the path of a structure, a molecule from read_molecule, "
            "or atoms of mdtraj, biotite, MDAnalysis, gemmi or Biopython."
        )
    return convert(source)


def _converter(source: Any) -> Any:
    """Return the function that converts atoms of another library, known by their attributes; None for anything else."""
    if hasattr(source, "topology") and hasattr(source, "xyz"):
        return from_mdtraj
    if hasattr(source, "coord") and hasattr(source, "atom_name"):
        return from_biotite
    if hasattr(source, "universe") and hasattr(source, "atoms"):
        return from_mdanalysis
    if type(source).__module__ == "gemmi":
        return {"Structure": from_gemmi, "Model": from_gemmi}.get(type(source).__name__)
    if getattr(source, "level", None) in ("S", "M", "C") and hasattr(source, "get_atoms"):
        return from_biopython
    return None


def as_dots(source: DotsLike) -> Surface:
    """Return a Surface from itself, a Subset, the path of a file of dots, or the pair (points, normals) of (N, 3) arrays.

    Normals of a file are normalised; those of arrays must be unit vectors.

    Raises
    ------
    InputError
        None of these.
    """
    if isinstance(source, Surface):
        return source
    if is_subset(source):
        return source.surface
    if is_file_of_dots(source):
        return read_surface(cast(str | Path, source))
    if has_atoms(source):
        name = source if isinstance(source, str | Path) else _with_article(source)
        raise InputError(f"{name} holds atoms: give the dots that surface() places on them.")
    if isinstance(source, tuple) and len(source) == 2:
        dots = Surface(*source)
        check_plausibility(dots.points, dots.normals, "surface", dot_label)
        return dots
    if isinstance(getattr(source, "surface", None), Surface):
        raise InputError(
            "a prepared surface is for sample and compare only: give the dots that it was prepared from."
        )
    raise InputError(
        f"{_with_article(source)} is not a surface: give the path of a file, dots from surface(), or "
        "the pair (points, normals)."
    )


def known_origin(dots: Surface, name: str) -> Origin:
    """Return the origin of dots; raise InputError, in the name of a function, if they know no molecule."""
    if dots.origin is None:
        raise InputError(f"{name}: these dots know no molecule; give it, too.")
    return dots.origin


def refuse_other_rules(origin: Origin, name: str, **requested: Any) -> None:
    """Raise InputError if dots were placed by other rules than requested; a default requests nothing."""
    rules = origin.rules | {"frame": origin.frame}
    for key, value in requested.items():
        if value not in (PLACEMENT_DEFAULTS[key], rules[key]):
            raise InputError(
                f"{name}: the dots were placed with {key}={rules[key]!r}; give their molecule for {value!r}."
            )


def refuse_placement(name: str, **requested: Any) -> None:
    """Raise InputError if dots that know no molecule are to be placed by a rule."""
    for key, value in requested.items():
        if value != PLACEMENT_DEFAULTS[key]:
            raise InputError(
                f"{name}: {key}={value!r} is about placing dots; leave it out, or give the molecule."
            )


def refuse_other_frame(dots: Any, molecule: Molecule, frame: int, name: str) -> None:
    """Raise InputError if dots know that they belong to another frame of a molecule with several."""
    origin = getattr(dots, "origin", None)
    if origin is not None and origin.frame != frame and origin.frame < molecule.n_frames:
        raise InputError(f"{name}: the dots are those of frame {origin.frame}; give frame={origin.frame}.")


def refuse_other_atoms(dots: Any, molecule: Molecule, frame: int | None, name: str) -> None:
    """Raise InputError if dots know that they were placed on other atoms than those of a frame (None: of any frame)."""
    origin = getattr(dots, "origin", None)
    if origin is None:
        distance = _distance_from_atoms(dots, molecule, frame)
        if distance > MAX_DISTANCE_FROM_ATOMS:
            raise InputError(
                f"{name}: half of the dots lie {distance:.0f} Å or more from the atoms; give the molecule of these dots."
            )
    if origin is None or (origin.molecule is molecule and frame in (origin.frame, None)):
        return
    same = origin.molecule.n_atoms == molecule.n_atoms and all(
        np.array_equal(getattr(origin.molecule, key), getattr(molecule, key)) for key in LABELS
    )
    if same and frame is not None:
        refuse_other_frame(dots, molecule, frame, name)
        same = np.abs(origin.molecule.xyz[origin.frame] - molecule.xyz[frame]).max() < MAX_SHIFT
    if not same:
        raise InputError(f"{name}: the dots were placed on other atoms; give their molecule, or none.")


def refuse_other_molecule(dots: Any, molecule: Molecule, frame: int, name: str) -> None:
    """Raise InputError if a frame of a molecule lacks half of the atoms that dots know they were placed on.

    It may have more atoms, or lack hydrogens and ligands.
    """
    origin = getattr(dots, "origin", None)
    if (
        origin is None
        and (distance := _distance_from_atoms(as_dots(dots), molecule, frame)) > MAX_DISTANCE_FROM_ATOMS
    ):
        message = "%s: half of the dots lie %.0f Å or more from the atoms; is it the molecule of these dots?"
        log.warning(message, name, distance)
    if origin is None or (origin.molecule is molecule and frame == origin.frame):
        return
    from scipy.spatial import cKDTree

    heavy = origin.molecule.heavy
    positions = origin.molecule.xyz[origin.frame][heavy if heavy.any() else slice(None)]
    distances = np.asarray(cKDTree(molecule.xyz[frame]).query(positions)[0])
    if np.mean(distances < MAX_SHIFT) < MIN_SHARE_OF_ATOMS:
        raise InputError(
            f"{name}: the dots were placed on other atoms; give their molecule and frame, or the pair (points, normals)."
        )


def _distance_from_atoms(dots: Any, molecule: Molecule, frame: int | None) -> float:
    """Return the median distance, Å, of some of many dots from the nearest atom of a frame (None: of the nearest frame)."""
    from scipy.spatial import cKDTree

    points = getattr(dots, "points", np.empty((0, 3)))
    if len(points) < MIN_DOTS_TO_COMPARE:
        return 0.0
    sample = points[:: -(-len(points) // MAX_DOTS_TO_COMPARE)]
    frames = range(molecule.n_frames) if frame is None else [frame]
    return min(float(np.median(cKDTree(molecule.xyz[k]).query(sample)[0])) for k in frames)


def _with_article(value: Any) -> str:
    """Return the name of a type with its article."""
    name = type(value).__name__
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"


def number_arrays(values: Iterable[Any], name: str) -> list[np.ndarray]:
    """Return float arrays of the user's values, called `name`.

    Raises
    ------
    InputError
        Something else than numbers, rows of unequal length, or masked values.
    """
    parts: list[Any] = []
    arrays: list[np.ndarray] | None = None
    try:
        parts = [*values]
        arrays = [np.asarray(part) for part in parts]
        if any(array.dtype.kind in "cmMSU" for array in arrays):  # numpy would convert them
            arrays = None
        else:
            arrays = [np.asarray(array, dtype=float) for array in arrays]
    except (TypeError, ValueError):
        arrays = None
    if arrays is None or any(array.ndim == 0 for array in arrays):
        raise InputError(f"{name}: the arrays hold something else than numbers, or rows of unequal length.")
    if any(np.ma.is_masked(part) for part in parts):
        raise InputError(f"{name}: the arrays have masked values; leave these dots out.")
    return arrays


def index_array(values: Any, n_dots: int, name: str) -> np.ndarray:
    """Return the user's values as one array: of whole numbers if empty, of dots if they are a mask of all `n_dots`.

    Raises
    ------
    InputError
        Rows, called `name`, of unequal lengths, or masked values.
    """
    if np.ma.is_masked(values):
        raise InputError(f"{name}: the array has masked values; leave these dots out.")
    try:
        array = np.asarray(values)
    except ValueError:
        raise InputError(f"{name}: give one array, not several of unequal length.") from None
    if array.shape == (0,):  # an empty list has no type of its own
        return array.astype(np.int64)
    return np.flatnonzero(array) if array.dtype == bool and array.shape == (n_dots,) else array


def subset_indices(name: str, subset: Any, n_dots: int) -> np.ndarray:
    """Return the dots of a subset, (n,) int64; raise InputError unless they are dots of the surface, each once."""
    subset = index_array(subset.dots if is_subset(subset) else subset, n_dots, name)
    valid = subset.ndim == 1 and subset.dtype.kind in "iu" and len(subset) > 0
    if not (valid and subset.min() >= 0 and subset.max() < n_dots and len(np.unique(subset)) == len(subset)):
        raise InputError(f"{name}: a subset is numbers from 0 to {n_dots - 1}, each once, at least one.")
    return subset.astype(np.int64)


def field_names(names: Any, key: str) -> tuple[str, ...]:
    """Return names of fields from one name or several; `key` names the argument in the error."""
    result = (names,) if isinstance(names, str) or not hasattr(names, "__iter__") else tuple(names)
    if not all(isinstance(name, str) for name in result):
        raise InputError(f"{key} is {names!r}; it must be names such as ('hydropathy', 'potential').")
    return result


def check_choice(value: Any, choices: Sequence[str], name: str) -> str:
    """Return a value of the user that is one of the choices.

    Raises
    ------
    InputError
        Another value.
    """
    if value not in list(choices):  # a list: the value may have no hash
        words = " or ".join(choices) if len(choices) == 2 else f"one of {', '.join(choices)}"
        raise InputError(f"{name} is {value!r}; it must be {words}.")
    return value


def check_flag(value: Any, name: str) -> None:
    """Raise InputError if a value that the user gave as `name` is not True or False."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{name} is {value!r}; it must be True or False.")


def check_frame(molecule: Molecule, frame: Any, name: str) -> None:
    """Raise InputError if a molecule, called `name`, has no frame at that position."""
    if not isinstance(frame, Integral) or frame not in range(molecule.n_frames):
        frames = f"the frames 0 to {molecule.n_frames - 1}" if molecule.n_frames > 1 else "one frame, 0"
        raise InputError(f"{name} has {frames}: there is no frame {frame}.")


def is_subset(source: Any) -> TypeGuard[Subset]:
    """Return whether the user gave a Subset; known by its attributes, so that its module need not be loaded."""
    return hasattr(source, "weight") and isinstance(getattr(source, "surface", None), Surface)


def is_structure(path: str | Path) -> bool:
    """Return whether a file holds atoms rather than dots, by its suffix."""
    return suffix(path) in MOLECULES


def is_file_of_dots(source: Any) -> bool:
    """Return whether the user gave the path of a file that holds dots rather than atoms."""
    return isinstance(source, str | Path) and not is_structure(source)


def has_atoms(source: Any) -> bool:
    """Return whether the user gave the path of a structure, a Molecule, or atoms of another library, rather than dots."""
    if isinstance(source, str | Path):
        return is_structure(source)
    return isinstance(source, Molecule) or _converter(source) is not None
