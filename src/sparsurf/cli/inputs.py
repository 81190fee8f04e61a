"""What the functions and commands take for a molecule, a surface and a number; numbers as in the config's schema."""

import argparse
import math
from numbers import Integral, Real
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sparsurf import InputError
from sparsurf.molecules.formats import SELF_CONTAINED, STRUCTURES, TOPOLOGIES, suffix
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import from_mdtraj, read_molecule
from sparsurf.patches.index import build_index
from sparsurf.surfaces.molecular_surface import MAX_DENSITY
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.surfaces.surface import Surface, check_plausibility, dot_label

MOLECULES = STRUCTURES + SELF_CONTAINED + TOPOLOGIES
LABELS = ("chain", "residue", "residue_name", "name")  # of atoms, that the dots of a molecule go by
NEAR = 0.01  # Å; places are written with three decimals
PLACED_BY = {"frame": 0, "probe": 1.4, "density": "auto", "radii": "dms", "cavities": "keep"}  # unless told


def as_molecule(given):
    """A Molecule from itself, the path of a structure file, or an mdtraj.Trajectory.

    Raises
    ------
    InputError : nothing of the kind
    """
    if isinstance(given, Molecule):
        return given
    if isinstance(given, str | Path):
        return read_molecule(given)
    if hasattr(given, "topology") and hasattr(given, "xyz"):
        return from_mdtraj(given)
    raise InputError(
        f"{_kind(given)} is no molecule: give the path of a structure, a molecule that read_molecule gave, "
        "or an mdtraj.Trajectory."
    )


def as_surface(given):
    """A Surface from itself, what `minimal` gave, the path of a file of dots, or the pair (points, normals) of (N, 3) arrays.

    Normals of a file are brought to unit length, those of arrays must have it.

    Raises
    ------
    InputError : nothing of the kind
    """
    if isinstance(given, Surface):
        return given
    if is_file_of_dots(given):
        return read_surface(given)
    if has_atoms(given):
        name = given if isinstance(given, str | Path) else _kind(given)
        raise InputError(f"{name} holds atoms: give the dots that surface() places on them.")
    if isinstance(given, tuple) and len(given) == 2:
        dots = Surface(*arrays(given, "surface"))
        check_plausibility(dots.points, dots.normals, "surface", dot_label)
        return dots
    own = getattr(given, "surface", None)
    if isinstance(own, Surface) and hasattr(given, "weight"):
        return own  # of the kept dots that minimal() gave
    if isinstance(own, Surface):
        raise InputError(
            "what prepare() gave serves sample and compare only: give the dots that it was made of."
        )
    raise InputError(
        f"{_kind(given)} is no surface: give the path of a file of dots, what surface() gave, or "
        "the pair (points, normals)."
    )


def origin_of(dots, name):
    """Origin of dots that know their molecule.

    Raises
    ------
    InputError : of `name`, they do not
    """
    if getattr(dots, "origin", None) is None:
        raise InputError(f"{name}: these dots know no molecule; give it, too.")
    return dots.origin


def agreed(origin, name, **wishes):
    """The origin of dots, where each rule that is wished is that by which the dots were placed, or a default.

    Raises
    ------
    InputError : of `name`, they were placed by another rule
    """
    known = origin.rules | {"frame": origin.frame}
    for key, value in wishes.items():
        if value not in (PLACED_BY[key], known[key]):
            raise InputError(
                f"{name}: the dots were placed with {key}={known[key]!r}; give their molecule for {value!r}."
            )
    return origin


def placed_already(name, **wishes):
    """Raise InputError where dots that know no molecule are to be placed by a rule."""
    for key, value in wishes.items():
        if value != PLACED_BY[key]:
            raise InputError(
                f"{name}: {key}={value!r} is about placing dots; leave it out, or give the molecule."
            )


def same_frame(dots, molecule, frame, name):
    """Raise InputError where dots know that they are of another frame of a molecule with several."""
    own = getattr(dots, "origin", None)
    if own is not None and own.frame != frame and own.frame < molecule.n_frames:
        raise InputError(f"{name}: the dots are those of frame {own.frame}; give frame={own.frame}.")


def same_atoms(dots, molecule, frame, name):
    """Raise InputError where dots know that they were placed on other atoms than those of a frame, or of any where it is None."""
    own = getattr(dots, "origin", None)
    if own is None or (own.molecule is molecule and frame in (own.frame, None)):
        return
    same = own.molecule.n_atoms == molecule.n_atoms and all(
        np.array_equal(getattr(own.molecule, key), getattr(molecule, key)) for key in LABELS
    )
    if same and frame is not None:
        same_frame(dots, molecule, frame, name)
        same = np.abs(own.molecule.xyz[own.frame] - molecule.xyz[frame]).max() < NEAR
    if not same:
        raise InputError(f"{name}: the dots were placed on other atoms; give their molecule, or none.")


def around_the_same(dots, molecule, frame, name):
    """Raise InputError where dots know that they were placed on atoms of which the frame of a molecule has not even half.

    It may have more, or lack hydrogens and ligands.
    """
    own = getattr(dots, "origin", None)
    if own is None or (own.molecule is molecule and frame == own.frame):
        return
    from scipy.spatial import cKDTree

    heavy = ~np.isin(own.molecule.element, ["H", "D"])
    places = own.molecule.xyz[own.frame][heavy if heavy.any() else slice(None)]
    if (cKDTree(molecule.xyz[frame]).query(places)[0] < NEAR).mean() < 0.5:
        raise InputError(
            f"{name}: the dots were placed on other atoms; give their molecule and frame, or the pair (points, normals)."
        )


def _kind(given):
    """What something is, with its article."""
    name = type(given).__name__
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"


def arrays(given, name):
    """Arrays of numbers of the parts of `given`; raises InputError where one, called `name`, is none or lacks values."""
    try:
        given = [*given]
        found = [np.asarray(each) for each in given]
        other = any(each.dtype.kind in "cSU" for each in found)  # numpy would make numbers of them
        found = None if other else [np.asarray(each, dtype=float) for each in found]
    except (TypeError, ValueError):
        found = None
    if found is None or any(each.ndim == 0 for each in found):
        raise InputError(f"{name}: the arrays hold something else than numbers, or rows of unequal length.")
    if any(np.ma.is_masked(each) for each in given):
        raise InputError(f"{name}: the arrays have masked values; leave these dots out.")
    return found


def as_array(given, n_dots, name):
    """An array of what is given: whole numbers where it is empty, those of dots where it is a mask of all `n_dots`.

    Raises
    ------
    InputError : rows, called `name`, of unequal lengths
    """
    try:
        found = np.asarray(given)
    except ValueError:
        raise InputError(f"{name}: one array is asked for, not several of unequal length.") from None
    if found.shape == (0,):  # an empty list has no kind of its own
        return found.astype(np.int64)
    return np.flatnonzero(found) if found.dtype == bool and found.shape == (n_dots,) else found


def names_of_fields(given, key):
    """Names of fields as a tuple, from one name or several; `key` is what the caller calls them."""
    names = (given,) if isinstance(given, str) or not hasattr(given, "__iter__") else tuple(given)
    if not all(isinstance(name, str) for name in names):
        raise InputError(f"{key} is {given!r}; it must be names such as ('hydropathy', 'potential').")
    return names


def check_frame(molecule, frame, name):
    """Raise InputError where a Molecule, called `name`, has no frame of that position."""
    if not isinstance(frame, Integral) or frame not in range(molecule.n_frames):
        there = f"the frames 0 to {molecule.n_frames - 1}" if molecule.n_frames > 1 else "one frame, 0"
        raise InputError(f"{name} has {there}: there is no frame {frame}.")


def is_structure(path):
    """Whether a file holds atoms rather than dots, by its suffix."""
    return suffix(path) in MOLECULES


def is_file_of_dots(given):
    """Whether that is the path of a file that holds dots rather than atoms."""
    return isinstance(given, str | Path) and not is_structure(given)


def has_atoms(given):
    """Whether that is the path of a structure, a molecule or an mdtraj.Trajectory, rather than dots."""
    is_path = isinstance(given, str | Path)
    return is_structure(given) if is_path else isinstance(given, Molecule) or hasattr(given, "topology")


def as_index(surface, d_link):
    """Index of all that `as_surface` takes; its dots must lie close enough for `d_link`."""
    d_link, dots = LENGTH.check(d_link, "d_link"), as_surface(surface)
    refuse_sparse(dots.points, d_link, "surface")
    return build_index(dots.points, dots.normals, d_link)


class Limits(NamedTuple):
    """Finite numbers above `low` (or from it on), at most `high`."""

    low: float
    high: float = math.inf
    whole: bool = False
    open_low: bool = True

    def hold(self, value):
        """Whether they allow a number; NaN and infinity never."""
        above = self.low < value or (value == self.low and not self.open_low)
        return above and value <= self.high and value < math.inf and (not self.whole or value % 1 == 0)

    @property
    def words(self):
        """What they allow."""
        number = f"a {'whole ' * self.whole}number"
        if self.high < math.inf:
            least = f"more than {self.low:g} and at most" if self.open_low else f"{self.low:g} to"
            return f"{number}, {least} {self.high if self.whole else f'{self.high:g}'}"
        return f"{number}, more than {self.low:g}" if self.open_low else f"{number}, {self.low:g} or more"

    def check(self, value, name, word=None):
        """The number that is given as `name`, a float or, of whole ones, an int; `word` is allowed as well.

        Raises
        ------
        InputError : no number, or one beyond the limits
        """
        if word is not None and isinstance(value, str) and value == word:
            return value
        if isinstance(value, bool) or not isinstance(value, Real) or not self.hold(value):
            either = "" if word is None else f"{word!r} or "
            raise InputError(f"{name} is {value!r}; it must be {either}{self.words}.")
        return int(value) if self.whole else float(value)

    def parse(self, text):
        """The number that an option of a command is given as text; argparse tells what it should be."""
        try:
            value = int(text) if self.whole else float(text)
        except ValueError:
            value = math.nan
        if not self.hold(value):
            raise argparse.ArgumentTypeError(f"{text!r} must be {self.words}")
        return value


LENGTH = Limits(0, 100)  # Å: R_patch, R_zernike, D_link
PROBE = Limits(0, 10)  # Å
DENSITY = Limits(0, MAX_DENSITY)  # dots per Å^2
PERCENT = Limits(0, 100)
ALPHA = Limits(0, 1)
EXPONENT = Limits(0, 1000, open_low=False)  # beta, gamma, delta
SEED = Limits(0, 2**64 - 1, whole=True, open_low=False)
TEST_DOTS = Limits(2, 1_000_000, whole=True, open_low=False)
