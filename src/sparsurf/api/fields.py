"""Fields: numbers at the dots of a surface that are computed from the atoms; and a table by residue."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Sequence
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from sparsurf import registry
from sparsurf.api.field_values import ROUGHNESS, with_fields
from sparsurf.api.inputs import (
    DotsLike,
    MoleculeLike,
    SurfaceLike,
    as_dots,
    as_molecule,
    check_frame,
    field_names,
    has_atoms,
    subset_indices,
)
from sparsurf.api.surfaces import as_surface
from sparsurf.api.whole_surface import WholeSurface, patches_or_none, whole_surface
from sparsurf.arguments import F, index_array, public
from sparsurf.dot_fields.depth import depth_of_atoms, depth_of_residues
from sparsurf.dot_fields.maps import is_map
from sparsurf.dot_fields.named_fields import FieldLike, compute_fields
from sparsurf.errors import InputError, argument
from sparsurf.evaluation.minimal_subset import Subset
from sparsurf.evaluation.residues import residue_columns, residue_table
from sparsurf.settings import PatchesSettings
from sparsurf.surfaces.chosen_points import Points
from sparsurf.surfaces.surface import Surface, real_numbers
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike

    from sparsurf.surfaces.mesh import Mesh

log = logging.getLogger("sparsurf")

DEFAULT_FIELDS = ("hydropathy", "potential")


@public(of_dots=True)
@registry.with_choices
def fields(
    molecule: MoleculeLike | Surface | Points | Mesh,
    dots: Any = None,
    names: FieldLike | Sequence[FieldLike] = DEFAULT_FIELDS,
    *,
    frame: int = 0,
    charges: str | Path = "table",
    table: str | Path | None = None,
    smooth: float | None = None,
) -> pd.DataFrame:
    """Compute fields, such as the electrostatic potential, at the dots of a surface.

    Parameters
    ----------
    molecule : as in `surface`
        Dots from `surface`, points from `points` or a mesh, which carry their molecule, may take its place.
    dots : Surface, path of a file of dots, or pair (points, normals), optional
        Dots that carry no molecule of their own.
    names : str, callable, or sequence of these
        A field of this list or of `register`, a column of `table`, a path of a map (.dx, .ccp4, .map, .mrc; Å), interpolated
        linearly and NaN outside (the column of apbs.dx is apbs_dx), or a function (molecule, points) that returns (N,) numbers:

        {choices of field}

        Hydropathy is averaged over 2.5 Å. A value of an atom, such as its B factor, belongs to its dots: where it has none, the
        nearest atom of its residue that has one counts, and dots of no known atom belong to the one whose centre is nearest.
        Dots on spheres have those that follow from dots, and 'roughness'. `burial` needs `groups` of `surface` or `points`.
        Curvatures are exact, of the sphere or torus that a dot lies on. An atom that donates and accepts hydrogen bonds has
        (donated - accepted) / (donated + accepted) of them, by its name, without
        hydrogens: this is no energy, has no direction and does not say whether a bond is formed.
    frame : int
        Position of the frame, from 0 (default 0).
    charges : str
        Of the potential: 'table' (default; PARSE, with missing hydrogens), 'pdb2pqr', if installed, or the path of a PQR file.
    table : path, optional
        CSV of a value for each residue or atom: columns residue (for a scale residue_name), chain, atom and those of `names`.
    smooth : float, optional
        Width of the Gaussian over which B factors (then bfactor_smooth) and columns of `table` are averaged, Å (default none).

    Returns
    -------
    DataFrame, (N, F)
        One column per name; that of a function is called by its `__name__`.

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> fields = sparsurf.fields(dots)
    >>> fields.shape, list(fields)
    ((24600, 2), ['hydropathy', 'potential'])
    """
    import pandas as pd  # here: it takes long to load

    return pd.DataFrame(columns_of_fields(molecule, dots, names, frame, charges, table, smooth))


def columns_of_fields(
    molecule: MoleculeLike | Surface | Points | Mesh,
    dots: Any = None,
    names: FieldLike | Sequence[FieldLike] = DEFAULT_FIELDS,
    frame: int = 0,
    charges: str | Path = "table",
    table: str | Path | None = None,
    smooth: float | None = None,
) -> dict[str, np.ndarray]:
    """Return the columns of `fields` by name."""
    molecule, dots = labelled(molecule), labelled(dots)
    if isinstance(molecule, Surface):
        # of a field, in the place of `names`
        is_name = is_map(dots) or (isinstance(dots, str) and not Path(dots).is_file())
        if not is_name and has_atoms(dots):
            raise InputError("fields: give the molecule first, then its dots.")
        names = names if dots is None else dots
        dots, atoms = molecule, molecule.molecule
        if dots.origin is None:
            dots.known_molecule("fields")  # which says that there is none
        assert dots.origin is not None
        if frame not in (0, dots.origin.frame):
            raise InputError(
                f"fields: the dots were placed on frame {dots.origin.frame}; leave frame={frame!r} out."
            )
        frame = dots.origin.frame
    else:
        atoms = as_molecule(molecule)
        if dots is None or _are_names(dots):
            raise InputError(
                "fields: dots are missing; call sparsurf.fields(sparsurf.surface(molecule), names)."
            )
    surface = as_dots(dots)
    if atoms is not None:
        check_frame(atoms, frame, "the molecule")
    if atoms is not None and surface.origin:
        surface.origin.refuse_molecule("fields", atoms, frame, whole=False)
    names = field_names(names, "names")
    if not names:
        raise InputError(f"{argument('names')}: there are no fields; give at least one, such as 'potential'.")
    if atoms is None:  # of spheres
        bare, of_atoms = replace(surface, fields={}), {"charges": charges, "table": table, "smooth": smooth}
        return dict(with_fields(bare, names, lambda: surface, "fields", available_cores(), of_atoms).fields)
    return compute_fields(names, atoms.frame(frame), surface.points, charges, table, surface, smooth)


def _are_names(value: Any) -> bool:
    """Return whether a value names fields, in the place of dots."""
    if isinstance(value, (list, tuple)):
        return bool(value) and all(isinstance(name, str) or callable(name) for name in value)
    return callable(value) or is_map(value) or (isinstance(value, str) and registry.has("field", value))


def labelled(source: Any) -> Any:
    """Return the Surface of points, or that of the vertices of a mesh; anything else as it is."""
    if isinstance(source, Points):
        return source.surface
    return source.vertices if hasattr(source, "triangles") else source


def _molecule_first(function: F) -> F:
    """Let `residues(dots, molecule)`, as before version 6, do the same as `residues(molecule, dots)`, with a warning."""

    @wraps(function)
    def ordered(*values: Any, **keywords: Any) -> Any:
        first = values[0] if values else None
        second = values[1] if len(values) > 1 else keywords.get("molecule")
        if first is not None and second is not None and not has_atoms(first) and has_atoms(second):
            warnings.warn(
                "residues: write residues(molecule, dots) in place of residues(dots, molecule), which version 8 will refuse.",
                DeprecationWarning,
                stacklevel=2,
            )
            keywords.pop("molecule", None)
            values = (second, first, *values[2:])
        return function(*values, **keywords)

    return cast(F, ordered)


@_molecule_first
@public(of_dots=True)
def residues(
    molecule: SurfaceLike | Mesh | None = None,
    dots: DotsLike | Mesh | None = None,
    *,
    roughness_values: ArrayLike | None = None,
    kept: ArrayLike | Subset = (),
    weight: ArrayLike | None = None,
) -> pd.DataFrame:
    """Tabulate the area, the roughness, the fields and the kept dots of each residue.

    Parameters
    ----------
    molecule : path, Molecule, or atoms of another library
        Molecule, whose dots are placed unless they are given. Dots that carry their molecule may take its place.
    dots : Surface, Points, Mesh, path, or pair (points, normals), optional
        Dots of the molecule. The roughness of points and of vertices is that of the whole surface if they have the field
        'roughness', and NaN if not.
    roughness_values : (N,) float, optional
        Roughness of every dot, if it is known (default that of `roughness`).
    kept : (n,) int, (N,) bool, or Subset
        Dots of a subset, to be counted by residue (default none).
    weight : (n,) int, optional
        How many dots each kept dot represents (default 1, or the weights of a Subset).

    Returns
    -------
    DataFrame, one row per residue
        Its name, its area in total and by kind of dots (Å^2), its mean and lowest roughness (NaN where it is buried or lies
        only in cavities), the mean of each field, its depth (Å, as in `depth`, where the dots carry their molecule), and the
        numbers of its dots and, where `kept` is given, of its kept dots. The reference of outputs lists every column. The
        roughness of a few dots is that of the whole surface of their atoms, or else of the surface reconstructed from them
        (`recover`), as a warning says; it is NaN where they are too few.

    Raises
    ------
    InputError
        The dots do not say to which atoms they belong, or an array does not fit them.

    Examples
    --------
    >>> import sparsurf
    >>> table = sparsurf.residues(sparsurf.surface("data/tdp43/topology.pdb"))
    >>> len(table), list(table)[:4]
    (61, ['chain', 'residue', 'residue_name', 'area'])
    """
    import pandas as pd  # here: it takes long to load

    return pd.DataFrame(columns_of_residues(molecule, dots, roughness_values, kept, weight))


def columns_of_residues(
    molecule: SurfaceLike | Mesh | None,
    dots: DotsLike | Mesh | None = None,
    roughness_values: ArrayLike | None = None,
    kept: ArrayLike | Subset = (),
    weight: ArrayLike | None = None,
) -> dict[str, Any]:
    """Return the columns of `residues` by name."""
    given = molecule if dots is None else dots
    if given is None:
        raise InputError("residues needs a molecule, or dots that carry theirs.")
    is_sparse = isinstance(given, Points) or hasattr(given, "triangles")
    if dots is None or molecule is None:
        surface = as_surface(labelled(given))
        atoms = surface.known_molecule("residues")
    else:
        atoms, surface = as_molecule(molecule), as_dots(labelled(dots))
    if surface.origin:
        surface.origin.refuse_molecule("residues", atoms, None)
    if not 0 <= surface.atom.min() <= surface.atom.max() < atoms.n_atoms:
        raise InputError("residues: these dots do not say which atom of the molecule they belong to.")
    if roughness_values is None and is_sparse:
        fields = dict(surface.fields)
        roughness_values = fields.pop(ROUGHNESS, np.full(len(surface), np.nan))
        surface = replace(surface, fields=fields)
    dots_kept, weights = _kept_dots(kept, weight, len(surface))
    values, whole, of_whole = _roughness_of(surface, roughness_values, is_sparse)
    component = surface.placed.components(surface) if surface.placed else None
    if whole is None or whole.surface is surface:
        table: dict[str, Any] = residue_columns(surface, values, atoms, dots_kept, weights, component)
    else:
        cavity = whole.cavity[whole.nearest]
        of_dots = residue_table(surface, values, atoms, dots_kept, weights, component, cavity)
        if np.allclose(values, of_whole[whole.nearest], atol=1e-6):
            of_dots = whole.with_roughness(of_dots, of_whole, atoms)
        table = {str(name): column for name, column in of_dots.items()}
    if surface.origin and surface.molecule is not None:
        of_atoms = depth_of_atoms(surface.origin.xyz, surface.origin.radii, surface.origin.rules.probe_radius)
        following = [*table][[*table].index("dots") :]
        table["depth"] = depth_of_residues(atoms, of_atoms)
        table |= {name: table.pop(name) for name in following}
    if isinstance(kept, tuple) and not kept and weight is None:
        del table["kept"], table["weight"]
    return table


def _roughness_of(
    surface: Surface, given: ArrayLike | None, is_sparse: bool
) -> tuple[np.ndarray, WholeSurface | None, np.ndarray]:
    """Return R_i of dots, (N,), the surface whose patches tell it, if it is needed, and R_i of all its dots."""
    n, whole, patches = len(surface), None, PatchesSettings()
    values = None if given is None else real_numbers(given, "roughness_values").astype(float)
    if values is not None and values.shape != (n,):
        raise InputError(f"residues: roughness_values has the shape {values.shape}; the dots are {n}.")
    n_unknown = 0 if values is None else np.isnan(values).sum()
    if n_unknown and not is_sparse:
        raise InputError(
            f"residues: roughness_values is NaN at {n_unknown:,} of {n:,} dots; give the roughness of every dot, or leave it out."
        )
    if values is None or (is_sparse and surface.origin is not None and not n_unknown):
        # the patches of a part would end at its border
        is_part = surface.origin is not None and surface.placed is None
        whole = whole_surface(surface) if is_part else patches_or_none("residues", surface, patches)
    of_whole = np.empty(0) if whole is None else whole.roughness(patches)
    if values is None:
        values = np.full(n, np.nan) if whole is None else of_whole[whole.nearest]
    return values, whole, of_whole


def _kept_dots(
    kept: ArrayLike | Subset, weight: ArrayLike | None, n_dots: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the dots that are kept, (n,) int64, and how many dots each of them stands for, (n,)."""
    if isinstance(kept, Subset):
        weight = kept.weight if weight is None else weight
        kept = kept.dots
    dots = index_array(kept, n_dots, "kept")
    if dots.size:
        dots = subset_indices("kept", dots, n_dots)
    weights = np.ones(len(dots), int) if weight is None else real_numbers(weight, "weight")
    if not (weights >= 0).all():
        raise InputError(
            "residues: weight has negative values or NaN; give the number of dots that each kept dot stands for."
        )
    if weights.shape != dots.shape:
        raise InputError(f"residues: weight has the shape {weights.shape}; the kept dots are {len(dots)}.")
    return dots, weights
