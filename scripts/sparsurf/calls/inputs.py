"""What the functions and commands take for a molecule and for a surface."""

from numbers import Integral
from pathlib import Path

import numpy as np

from sparsurf import InputError
from sparsurf.molecules.formats import SELF_CONTAINED, STRUCTURES, TOPOLOGIES, suffix
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.reading import from_mdtraj, read_molecule
from sparsurf.surfaces.reading import read_surface
from sparsurf.surfaces.surface import Surface

MOLECULES = STRUCTURES + SELF_CONTAINED + TOPOLOGIES


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
    """A Surface from itself, the path of a file of dots, or the pair (points, normals) of (N, 3) arrays.

    Normals of a file are brought to unit length, those of arrays must have it.

    Raises
    ------
    InputError : nothing of the kind
    """
    if isinstance(given, Surface):
        return given
    if isinstance(given, str | Path):
        return read_surface(given)
    if isinstance(given, tuple) and len(given) == 2:
        return Surface(*arrays(given, "surface"))
    if isinstance(getattr(given, "surface", None), Surface):
        raise InputError(
            "what prepare() gave serves sample and compare only: give the dots that it was made of."
        )
    raise InputError(
        f"{_kind(given)} is no surface: give the path of a file of dots, what surface() gave, or "
        "the pair (points, normals)."
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


def check_frame(molecule, frame, name):
    """Raise InputError where a Molecule, called `name`, has no frame of that position."""
    if not isinstance(frame, Integral) or frame not in range(molecule.n_frames):
        there = f"the frames 0 to {molecule.n_frames - 1}" if molecule.n_frames > 1 else "one frame, 0"
        raise InputError(f"{name} has {there}: there is no frame {frame}.")


def is_structure(path):
    """Whether a file holds atoms rather than dots, by its suffix."""
    return suffix(path) in MOLECULES
