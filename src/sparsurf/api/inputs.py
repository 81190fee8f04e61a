"""Molecules, dots and numbers that the functions for users take; the limits of numbers are those of the config."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeGuard

import numpy as np

from sparsurf.arguments import RadiiLike, index_array
from sparsurf.errors import InputError, argument, naming_file
from sparsurf.files import shorten
from sparsurf.molecules.formats import FILE_OF_DOTS, suffix
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.selection import Groups, groups_of_atoms
from sparsurf.molecules.source import Source, open_source
from sparsurf.surfaces.chosen_points import Points
from sparsurf.surfaces.plausibility import check_plausibility
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.spheres import SPHERE_FORMATS, read_spheres
from sparsurf.surfaces.surface import Surface, dot_label, real_numbers

if TYPE_CHECKING:
    import gemmi
    from Bio.PDB.Entity import Entity
    from biotite.structure import AtomArray, AtomArrayStack
    from MDAnalysis import AtomGroup, Universe
    from mdtraj import Trajectory
    from numpy.typing import ArrayLike
    from openmm.app import Modeller, PDBFile, PDBxFile
    from parmed import Structure
    from prody.atomic import Atomic
    from rdkit.Chem import Mol

    from sparsurf.evaluation.minimal_subset import Subset

# What the functions take as a molecule, and as dots; a molecule is also taken for the dots on it.
MoleculeLike: TypeAlias = (
    "str | Path | Molecule | Trajectory | AtomArray | AtomArrayStack | AtomGroup | Universe"
    " | gemmi.Structure | gemmi.Model | Entity | Atomic | Modeller | PDBFile | PDBxFile | Structure | Mol"
)
DotsLike: TypeAlias = "str | Path | Surface | Points | Subset | tuple[ArrayLike, ArrayLike]"
SurfaceLike: TypeAlias = "DotsLike | MoleculeLike"


# What converts atoms of another library, by the attributes that these have; atoms of ParmEd also have those of OpenMM
ATTRIBUTES_OF_ATOMS = {
    "from_mdtraj": ("topology", "xyz"), "from_biotite": ("coord", "atom_name"), "from_mdanalysis": ("universe", "atoms"),
    "from_prody": ("getCoordsets", "getResnums"), "from_parmed": ("atoms", "get_coordinates"),
    "from_openmm": ("topology", "positions"), "from_rdkit": ("GetConformers", "GetAtoms"),
}  # fmt: skip


def opened_source(source: Any) -> Any:
    """Return the Source of a path, recognised by its content; anything else as it is. Functions for users begin with it."""
    return open_source(source) if isinstance(source, str | Path) else source


def as_molecule(source: MoleculeLike, groups: Groups | None = None) -> Molecule:
    """Return a Molecule from itself, a path, or atoms of another library, with only the atoms of `groups` if these are given.

    Raise InputError for anything else.
    """
    source = opened_source(source)
    if isinstance(source, Source):
        from sparsurf.molecules.read_molecule import molecule_of_files  # here, as below: pairs need no reader

        return molecule_of_files(source, None, {"groups": groups})
    if isinstance(source, Molecule):
        return source if groups is None else source.select(selection="all", groups=groups)
    from sparsurf.molecules import libraries

    try:
        if name := _converter(source):
            convert = getattr(libraries, name)
            return convert(source) if groups is None else convert(source, groups=groups)
        reason = ""
    except InputError:
        raise
    except Exception as error:  # an object of another library may raise any
        reason = f" that can be read ({shorten(f'{type(error).__name__}: {error}')})"
    raise InputError(
        f"{_with_article(source)} is not a molecule{reason}: give the path of a structure, a molecule from read_molecule, "
        f"or atoms of {libraries.WITH_ATOMS}."
    )


def attribute(source: Any, name: str) -> Any:
    """Return an attribute of an object of another library; None where it has none, or where its property raises an error."""
    try:
        return getattr(source, name, None)
    except Exception:  # such as the ImportError of a package that it needs
        return None


def _converter(source: Any) -> str | None:
    """Return the name of what converts atoms of another library, known by their attributes; None for anything else."""
    if type(source).__module__ == "gemmi":
        return "from_gemmi" if type(source).__name__ in ("Structure", "Model") else None
    for name, attributes in ATTRIBUTES_OF_ATOMS.items():
        if all(attribute(source, key) is not None for key in attributes):
            return name
    is_entity = attribute(source, "get_atoms") is not None and attribute(source, "level") in ("S", "M", "C")
    return "from_biopython" if is_entity else None


def as_dots(source: DotsLike) -> Surface:
    """Return a Surface from itself, Points, a Subset, the path of a file of dots, or the pair (points, normals) of (N, 3) arrays.

    Normals of a file are normalised; those of arrays must be unit vectors. Raise InputError for anything else.
    """
    if isinstance(source, Surface):
        return source
    if isinstance(source, Points) or is_subset(source):
        return source.surface
    given = opened_source(source)
    if is_file_of_dots(given):
        return read_surface(given.name)
    if has_atoms(given):
        name = given if isinstance(given, Source) else _with_article(given)
        raise InputError(f"{name} holds atoms: give the dots that surface() places on them.")
    if is_pair(source):
        dots = Surface(*source)
        with naming_file("surface"):
            check_plausibility(dots.points, dots.normals, dot_label)
        return dots
    if isinstance(attribute(source, "surface"), Surface):
        raise InputError(
            "a prepared surface is for sample and compare only: give the dots that it was prepared from."
        )
    raise InputError(
        f"{_with_article(source)} is not a surface: give the path of a file, dots from surface(), or "
        "the pair (points, normals)."
    )


def _with_article(value: Any) -> str:
    """Return the name of a type with its article."""
    name = type(value).__name__
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"


def subset_indices(name: str, subset: Any, n_dots: int) -> np.ndarray:
    """Return the dots of a subset, (n,) int64; raise InputError unless they are dots of the surface, each once."""
    subset = index_array(subset.dots if is_subset(subset) else subset, n_dots, name)
    valid = subset.ndim == 1 and subset.dtype.kind in "iu" and len(subset) > 0
    if not (valid and subset.min() >= 0 and subset.max() < n_dots and len(np.unique(subset)) == len(subset)):
        raise InputError(
            f"{argument(name)}: expected unique dot indices between 0 and {n_dots - 1} (at least one)."
        )
    return subset.astype(np.int64)


def field_names(names: Any, key: str) -> tuple[Any, ...]:
    """Return fields, names, paths of maps or functions, from one or several; `key` names the argument in the error."""
    try:
        result = (names,) if isinstance(names, str) else tuple(names)
    except TypeError:  # a function, a path, a number, or an array without a dimension
        result = (names,)
    result = tuple(str(name) if isinstance(name, Path) else name for name in result)
    if not all(isinstance(name, str) or callable(name) for name in result):
        raise InputError(
            f"{argument(key)} is {names!r}; it must be names such as ('hydropathy', 'potential')."
        )
    return result


def check_frame(molecule: Molecule, frame: Any, name: str) -> None:
    """Raise InputError if a molecule, called `name`, has no frame at that position."""
    if frame not in range(molecule.n_frames):
        frames = f"the frames 0 to {molecule.n_frames - 1}" if molecule.n_frames > 1 else "one frame, 0"
        raise InputError(f"{name} has {frames}: there is no frame {frame}.")


def as_spheres(source: Any, frame: int, table: RadiiLike) -> tuple[Molecule | None, np.ndarray, np.ndarray]:
    """Return the molecule, None for spheres, and the centres in a frame and radii, Å, of all that `surface` takes."""
    if is_file_of_spheres(source):
        spheres = read_spheres(source)
        source = spheres.xyz, spheres.radii
    if is_pair(source):
        if frame != 0:
            raise InputError(f"the molecule has one frame, 0: there is no frame {frame}.")
        xyz, values = (real_numbers(part, "molecule: a part of the pair").astype(float) for part in source)
        return None, xyz.round(3), values
    molecule = as_molecule(source)
    check_frame(molecule, frame, "the molecule")
    return molecule, molecule.xyz[frame].round(3), radii(molecule, table)


def molecule_of_groups(source: Any, groups: Groups) -> Molecule:
    """Return a molecule with only the atoms of `groups`; raise InputError for spheres."""
    if is_pair(source) or is_file_of_spheres(source):
        raise InputError(f"{argument('groups')}: spheres have no chains; give a structure.")
    return as_molecule(source, groups)


def first_group(
    source: Any, frame: int, groups: Groups, table: RadiiLike
) -> tuple[Molecule, tuple[np.ndarray, np.ndarray]]:
    """Return the molecule of the first group, and the centres and radii of the atoms of the others in a frame."""
    molecule = molecule_of_groups(source, groups)
    check_frame(molecule, frame, "the molecule")
    number, xyz = groups_of_atoms(molecule, groups).number, molecule.xyz[frame].round(3)
    return molecule.take(number == 0), (xyz[number > 0], radii(molecule, table)[number > 0])


def is_subset(source: Any) -> TypeGuard[Subset]:
    """Return whether the user gave a Subset; known by its attributes, so that its module need not be loaded."""
    return attribute(source, "weight") is not None and isinstance(attribute(source, "surface"), Surface)


def is_pair(source: Any) -> TypeGuard[tuple[Any, Any]]:
    """Return whether the user gave a pair, as of the centres and radii of spheres."""
    return isinstance(source, tuple) and len(source) == 2


def is_file_of_spheres(source: Any) -> bool:
    """Return whether the user gave the path of a file with radii, or of a small molecule, by its suffix."""
    name = source.name if isinstance(source, Source) else source
    return isinstance(name, str | Path) and suffix(name) in SPHERE_FORMATS


def is_file_of_dots(source: Any) -> bool:
    """Return whether the user gave the path of a file that holds dots rather than atoms."""
    if is_file_of_spheres(source):
        return False
    source = opened_source(source)
    return isinstance(source, Source) and source.format.name == FILE_OF_DOTS


def refuse_dots(function: str, source: Any) -> None:
    """Raise InputError, in the name of a function that needs atoms, for dots and files of dots."""
    if isinstance(source, Surface | Points) or is_subset(source) or is_file_of_dots(source):
        raise InputError(f"{function}: dots hold no atoms; give the molecule that they lie on.")


def has_atoms(source: Any) -> bool:
    """Return whether the user gave the path of a molecule, a Molecule, or atoms of another library, rather than dots."""
    source = opened_source(source)
    if isinstance(source, Source):
        return source.format.name != FILE_OF_DOTS or is_file_of_spheres(source)
    return isinstance(source, Molecule) or _converter(source) is not None
