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
        f"a {type(given).__name__} is no molecule: give the path of a structure, a molecule that read_molecule gave, "
        "or an mdtraj.Trajectory."
    )


def as_surface(given):
    """A Surface from itself, the path of a file of dots, or the pair (points, normals) of (N, 3) arrays.

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
    raise InputError(
        f"a {type(given).__name__} is no surface: give the path of a file of dots, what surface() gave, or "
        "the pair (points, normals)."
    )


def arrays(given, name):
    """Arrays of numbers of the parts of `given`; raises InputError where one, called `name`, is none."""
    try:
        found = [np.asarray(each, dtype=float) for each in given]
    except (TypeError, ValueError):
        found = None
    if found is None or any(each.ndim == 0 for each in found):
        raise InputError(f"{name}: the arrays hold something else than numbers, or rows of unequal length.")
    return found


def as_array(given, n_dots, name):
    """An array of what is given, the numbers of dots where it is a mask of all `n_dots`.

    Raises
    ------
    InputError : rows, called `name`, of unequal lengths
    """
    try:
        found = np.asarray(given)
    except ValueError:
        raise InputError(f"{name}: one array is asked for, not several of unequal length.") from None
    return np.flatnonzero(found) if found.dtype == bool and found.shape == (n_dots,) else found


def check_frame(molecule, frame, name):
    """Raise InputError where a Molecule, called `name`, has no frame of that position."""
    if not isinstance(frame, Integral) or frame not in range(molecule.n_frames):
        there = f"the frames 0 to {molecule.n_frames - 1}" if molecule.n_frames > 1 else "one frame, 0"
        raise InputError(f"{name} has {there}: there is no frame {frame}.")


def is_structure(path):
    """Whether a file holds atoms rather than dots, by its suffix."""
    return suffix(path) in MOLECULES
