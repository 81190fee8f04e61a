"""From a molecule to its surface: dots, triangles and connected components."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.field_values import check_fields, with_fields
from sparsurf.api.inputs import (
    DotsLike,
    MoleculeLike,
    SurfaceLike,
    as_dots,
    as_molecule,
    as_spheres,
    check_frame,
    first_group,
    has_atoms,
    is_file_of_dots,
    is_file_of_spheres,
    is_pair,
    is_subset,
    opened_source,
)
from sparsurf.api.surface_atoms import surface_of_atoms
from sparsurf.arguments import (
    Auto,
    Boundary,
    Cavities,
    Model,
    RadiiLike,
    Reentrant,
    public,
)
from sparsurf.errors import InputError, argument
from sparsurf.molecules.selection import Groups
from sparsurf.patches.index import D_LINK, PatchIndex, build_index
from sparsurf.surfaces.chosen_points import Points
from sparsurf.surfaces.components import components_of_rolled, fields_without_component, table_of_components
from sparsurf.surfaces.dot_placement import roll_checked
from sparsurf.surfaces.molecular_surface import accessible_surface, surface_of_molecule, surface_of_spheres
from sparsurf.surfaces.radii import PROBE_RADIUS, check_radii
from sparsurf.surfaces.spacing import DENSITY as PUBLISHED_DENSITY
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.surfaces.surface import Placement, Surface, SurfaceOrigin
from sparsurf.surfaces.surface_atoms import SurfaceAtoms
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd
    from numpy.typing import ArrayLike

    from sparsurf.dot_fields.named_fields import FieldLike
    from sparsurf.surfaces.mesh import Mesh, MeshSize
    from sparsurf.surfaces.surface import Rules


@public()
def surface(
    molecule: MoleculeLike | SurfaceAtoms | tuple[ArrayLike, ArrayLike],
    *,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    density: float | Auto = "auto",
    radii: RadiiLike = "dms",
    d_link: float = D_LINK,
    cavities: Cavities = "keep",
    reentrant: Reentrant = "exact",
    boundary: Boundary = "excluded",
    groups: Groups | None = None,
) -> Surface:
    """Place dots with analytic normals on the solvent-excluded or solvent-accessible surface of a molecule.

    Parameters
    ----------
    molecule : path, Molecule, atoms of another library, or pair (xyz, radii)
        A structure, a file with radii (.xyzr, .xyzrn, .pqr) or of a small molecule (.sdf, .mol, .mol2), the centres (A, 3) and
        radii (A,) of spheres in Å, or SurfaceAtoms from `surface_atoms`, on which the surface is the same as on all atoms.
    frame : int
        Position of the frame, from 0 (default 0); an AtomGroup of MDAnalysis has one, the current frame of its trajectory.
    probe_radius, density, d_link : float
        Radius of the probe, Å (default 1.4); dots per Å^2 (default 'auto': 5.35, or more where `d_link` needs it); distance below
        which two dots of a patch will count as linked, Å (default 0.5).
    radii : {'dms', 'bondi'}, dict, or path
        Table of atomic radii (default 'dms'), or radii of your own in Å: by element, or a CSV with the column `radius` and
        `residue_name`, `atom` or `element`, of which the row that names an atom most closely counts.
    cavities, reentrant : {'keep', 'remove'}, {'exact', 'dms'}
        Whether the dots of closed cavities are kept (default 'keep'), and whether concave dots inside other probes are removed
        (default 'exact') or kept, as by the program DMS.
    boundary : {'excluded', 'accessible'}
        Whether the surface bounds the space that the probe cannot enter (default 'excluded') or that its centre cannot enter,
        whose area is that of `areas`. Dots of the latter are of kind 0 and carry no molecule.
    groups : str or sequence, optional
        As in `areas` (default all atoms): dots lie on the surface of the first group; `burial` is their depth below that of all.

    Returns
    -------
    Surface
        `points` and `normals` (N, 3) in Å, `area` (N,) in Å^2, `kind` (N,) (0 contact, 1 saddle, 2 concave) and `atom` (N,), the
        index of the atom that each dot belongs to. The dots carry their molecule.

    Raises
    ------
    InputError
        The molecule cannot be read, or an argument is outside of its limits.

    Examples
    --------
    >>> import sparsurf
    >>> sparsurf.surface("data/tdp43/topology.pdb")
    Surface of 24,600 dots
    """
    rules = placement(probe_radius, density, radii, cavities, reentrant)
    if groups is not None:
        if boundary == "accessible":
            raise InputError(f"{argument('groups')}: the accessible surface has no groups; leave them out.")
        atoms, partner = first_group(molecule, frame, groups, radii)
        dots = surface_of_molecule(atoms, rules, d_link, "surface", frame)
        assert dots.origin is not None
        return dots.with_origin(replace(dots.origin, partner=partner))
    if boundary == "accessible":
        return _accessible(molecule, frame, rules, d_link)
    if isinstance(molecule, SurfaceAtoms):
        return surface_of_atoms(molecule, rules, d_link)
    if not isinstance(molecule, tuple) and not is_file_of_spheres(molecule):
        atoms = as_molecule(molecule)
        check_frame(atoms, frame, "the molecule")
        return surface_of_molecule(atoms, rules, d_link, "surface", frame)
    _, xyz, sphere_radii = as_spheres(molecule, 0, radii)
    return surface_of_spheres(xyz, sphere_radii, rules, d_link, "surface")


def _accessible(molecule: Any, frame: int, rules: Placement, d_link: float) -> Surface:
    """Place dots on the accessible surface; raise InputError for what it does not have."""
    if rules.reentrant != "exact":
        raise InputError(
            "surface: reentrant applies to concave dots, which the accessible surface does not have; remove it."
        )
    if isinstance(molecule, SurfaceAtoms):
        raise InputError(
            "surface: give the molecule, of which the accessible surface is placed on all atoms."
        )
    _, xyz, atom_radii = as_spheres(molecule, frame, rules.radii)
    return accessible_surface(xyz, atom_radii, rules, d_link, "surface")


@public(of_dots=True)
def components(
    molecule: MoleculeLike | Surface | tuple[ArrayLike, ArrayLike], dots: DotsLike | None = None
) -> tuple[np.ndarray, pd.DataFrame]:
    """Find the connected components of a surface: the outside of each molecule, and its closed cavities.

    Parameters
    ----------
    molecule : path, Molecule, atoms of another library, pair (xyz, radii), or Surface
        The molecule, as for `surface`, on which dots are placed with the defaults. Dots from `surface` carry their molecule
        and the rules of their placement, as in `components(surface(path, probe_radius=2.0))`.
    dots : Surface, path, or pair (points, normals), optional
        Dots of the same molecule that carry no molecule, such as those of a file.

    Returns
    -------
    component : (N,) int
        Component of each dot; component 0 has the most dots.
    table : DataFrame
        One row per component: component, dots, and exactly, not by dots, area (Å^2), volume (Å^3, positive), cavity (bool),
        handles (int) and narrowest_handle (Å). The volume of the molecule is that of the others less that of its cavities. Two
        components that meet in a cusp, where their probes overlap and none passes, are closed there by a disc; the handles of
        their surface stand in the first of the two rows, and are missing in the other. A width is the diameter of a circle of
        the area that a closed cusp spans: that of the narrowest cusp on one probe along which the surface can be cut without
        falling apart. It is NaN where no handle has such a cusp. With `reentrant="dms"`, the numbers are those of the exact
        surface of the same spheres.

    Raises
    ------
    InputError
        The dots are not those of the molecule, are only a part of their surface, or carry no molecule.

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> component, table = sparsurf.components(dots)
    >>> table["dots"].tolist(), table["cavity"].tolist()
    ([24174, 224, 103, 85, 14], [False, True, True, True, True])
    >>> int(table["handles"].sum()), round(float(table["volume"][0] - table["volume"][1:].sum()), 1)
    (1, 7896.1)
    """
    if isinstance(molecule, Surface) and dots is not None:
        raise InputError("components: give the molecule first, then its dots.")
    source: Any = molecule if isinstance(molecule, Surface) else dots
    target = surface(molecule) if source is None else as_dots(source)
    if target.origin is not None:
        if source is dots and (is_pair(molecule) or is_file_of_spheres(molecule)):
            _, xyz, atom_radii = as_spheres(molecule, 0, "dms")
            target.origin.refuse_spheres("components", xyz, atom_radii)
        elif source is dots:
            atoms = as_molecule(molecule)
            frame = min(target.origin.frame, atoms.n_frames - 1)
            target.origin.refuse_molecule("components", atoms, frame)
        component = target.known_components("components")
    elif source is molecule:
        raise InputError(
            "components: these dots carry no molecule, as those of a file, or lie on the accessible surface, which has no "
            "components; pass the molecule first, then dots of its excluded surface."
        )
    else:
        _, xyz, atom_radii = as_spheres(molecule, 0, "dms")
        if not 0 <= target.atom.min() <= target.atom.max() < len(atom_radii):
            raise InputError(
                "components: the dots are not those of the molecule; give its dots from surface()."
            )
        rolled = roll_checked(xyz, atom_radii, PROBE_RADIUS)
        return components_of_rolled(target, rolled), table_of_components(target, rolled)
    return component, table_of_components(target)


@public(of_dots=True)
def mesh(
    surface: SurfaceLike | tuple[ArrayLike, ArrayLike],
    n_vertices: int | None = None,
    *,
    density: float | None = None,
    step: float | None = None,
    cavities: Cavities | None = None,
    fields: FieldLike | Sequence[FieldLike] = (),
    boundary: Boundary = "excluded",
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    radii: RadiiLike = "dms",
    table: str | Path | None = None,
    smooth: float | None = None,
    charges: str | Path = "table",
    reconstruction: Model = "auto",
    reach: float = 1.0,
) -> Mesh:
    """Triangulate the solvent-excluded surface of a molecule, or the surface reconstructed from a few dots.

    Parameters
    ----------
    surface : path, Molecule, atoms of another library, pair (xyz, radii), Surface, Points, or Subset
        A molecule, whose mesh follows the defaults of `surface`; or all dots that `surface` placed, whose mesh follows the rules
        of their placement, as in `mesh(surface(path, probe_radius=2.0))`. From any other dots (a Subset from `minimal`, a file of
        dots, some of the dots) the surface is reconstructed first.
    n_vertices, density : int, float, optional
        Number of vertices, at most 100 per Å^2, or in its place their number per Å^2 of the surface. Edges of a finer mesh are
        collapsed until so many are left; every vertex lies on the surface with its analytic normal (at a cusp, the mean of those
        of the pieces that meet), and the handles stay those of the surface.
    step : float, optional
        Instead of a number of vertices, about 4.5 / step^2 of them per Å^2 (default 0.5 Å, 18 vertices per Å^2; at least 0.1 Å).
        Between dots whose atoms are not known, it is the step of the grid whose triangles are kept, at most 0.7 Å.
    cavities : {'keep', 'remove'}, optional
        Whether the walls of closed cavities are part of the mesh. By default those of a molecule are removed, as in `points`, and
        a Surface keeps the rule of its placement. Where the wall of a cavity that is removed crosses that of the outside, the
        mesh closes the gap that dots leave. A mesh that is reconstructed from other dots has the cavities that these dots have.
    fields : str, callable, or sequence of these
        Fields of the vertices (default none): 'roughness', of the nearest dot of the dense surface, and any name of `fields`.
    boundary : {'excluded', 'accessible'}
        The surface of the space that the probe cannot enter (default), or that of the positions of its centre, whose vertices
        have atoms, and no molecule and no fields.
    frame, probe_radius, radii : as in `surface`
        Of a molecule, with the same defaults; dots that `surface` placed have theirs.
    table, smooth, charges : as in `fields`
        Values of the atoms of a molecule, how widely they are averaged, and the charges of the potential.
    reconstruction, reach : as in `recover`
        How the surface is reconstructed from other dots, with the same defaults.

    Returns
    -------
    Mesh
        `vertices` (a Surface with the atom, the molecule and the fields of each vertex), `triangles` (F, 3) int, counterclockwise
        from outside, and `volume` in Å^3. The mesh is closed: every edge belongs to two triangles. That of a molecule is made of
        the pieces of its surface and has exactly its handles; where a warning says otherwise, or between dots, those of a grid.

    Raises
    ------
    InputError
        The molecule or the dots cannot be used, several sizes are given, or the number of vertices is too high.

    Examples
    --------
    >>> import sparsurf
    >>> coarse = sparsurf.mesh("data/tdp43/topology.pdb", n_vertices=1024)
    >>> len(coarse.vertices), round(coarse.volume, -3), list(coarse.to_frame())[8:]
    (1024, 8000.0, ['chain', 'residue', 'residue_name', 'atom_name', 'atom'])
    >>> round(sparsurf.mesh(sparsurf.minimal("data/tdp43/topology.pdb", percent=10)).volume, -2)
    7900.0
    """
    size = mesh_size(n_vertices, density, step)
    names = check_fields(fields, "mesh", has_table=table is not None)
    source = opened_source(surface)
    are_dots = isinstance(source, Surface | Points) or is_subset(source) or is_file_of_dots(source)
    given, defaults = (
        ({"frame": frame, "probe_radius": probe_radius, "radii": radii}, (0, PROBE_RADIUS, "dms"))
        if are_dots
        else ({"reconstruction": reconstruction, "reach": reach}, ("auto", 1.0))
    )
    for (name, value), default in zip(given.items(), defaults, strict=True):
        if not (type(value) is type(default) and value == default):
            content = (
                "dots, which are placed: give it to surface()" if are_dots else "a molecule: leave it out"
            )
            raise InputError(f"mesh: {argument(name)} has no meaning for {content}.")
    values_of_atoms = {"table": table, "smooth": smooth, "charges": charges}
    is_default = isinstance(charges, str) and charges == "table"  # they may be an array
    if not names and (table is not None or smooth is not None or not is_default):
        raise InputError("mesh: table, smooth and charges are about fields; name these, or leave them out.")
    if isinstance(source, Surface) and source.placed:
        origin = source.placed.atoms_alone
        if cavities is not None:
            origin = replace(origin, rules=replace(placement_of(origin.rules), cavities=cavities))
        made = mesh_of_atoms(origin, size, names, boundary, **values_of_atoms)
        return made if boundary == "accessible" else _with_fields_of(source, made)
    if are_dots:
        if cavities is not None or boundary == "accessible":
            name = "boundary" if cavities is None else "cavities"
            raise InputError(
                f"mesh: {name} applies to a molecule, or to all dots that surface() placed; remove it, or give the molecule."
            )
        return _mesh_of_dots(as_dots(source), size, names, values_of_atoms, reconstruction, reach)
    rules = placement(probe_radius, "auto", radii, cavities or "remove")
    molecule, xyz, atom_radii = as_spheres(source, frame, rules.radii)
    origin = SurfaceOrigin.of_atoms(molecule, frame, xyz, rules, D_LINK, atom_radii)
    return mesh_of_atoms(origin, size, names, boundary, **values_of_atoms)


def mesh_size(
    n_vertices: int | None = None, density: float | None = None, step: float | None = None
) -> MeshSize:
    """Return the size of a mesh; raise InputError unless at most one of the arguments sets it."""
    from sparsurf.surfaces.mesh import MeshSize  # here: dots need none of its kernels

    if sum(value is not None for value in (n_vertices, density, step)) > 1:
        raise InputError("mesh: give either n_vertices or density or step, not several of them.")
    return MeshSize(n_vertices, density, step)


def placement_of(rules: Rules) -> Placement:
    """Return rules of a placement, which may be the section of a config."""
    return Placement(rules.probe_radius, rules.density, rules.radii, rules.cavities, rules.reentrant)


def _mesh_of_dots(
    few: Surface,
    size: MeshSize,
    names: Sequence[FieldLike],
    values_of_atoms: Mapping[str, Any],
    reconstruction: Model,
    reach: float,
) -> Mesh:
    """Return the mesh recovered from few dots; each vertex has the atom of the nearest of them, and interpolated fields."""
    from sparsurf.sampling.samplers import nearest_kept

    made, dense = _reconstructed_mesh(few, size, reconstruction, reach)
    vertices = made.vertices
    all_points = np.concatenate([few.points, vertices.points])
    nearest = nearest_kept(all_points, np.arange(len(few)))[0][len(few) :]
    origin = few.origin and few.origin.atoms_alone
    vertices = replace(vertices, atom=few.atom[nearest], origin=origin)
    vertices = with_fields(vertices, names, lambda: dense, "mesh", available_cores(), values_of_atoms)
    return _with_fields_of(few, replace(made, vertices=vertices))


def _reconstructed_mesh(
    few: Surface, size: MeshSize, reconstruction: Model, reach: float
) -> tuple[Mesh, Surface]:
    """Return the mesh reconstructed from few dots, without atoms and fields, and the dense dots between which it lies."""
    from sparsurf.recovery.interpolated_surface import NEWTON_STEPS
    from sparsurf.recovery.reconstructing import reconstruct
    from sparsurf.surfaces.decimation import GRID_STEP, WIDEST_STEP, sized_mesh
    from sparsurf.surfaces.grid_mesh import mesh_of_dense

    if size.step is not None and size.step > WIDEST_STEP:
        raise InputError(
            f"{argument('step')} is {size.step:g} Å; it must be at most {WIDEST_STEP:g} Å for dots. "
            f"For fewer triangles, give {argument('n_vertices')} in its place."
        )
    # the dense dots are as fine as the vertices, which lie on planes through these dots
    fineness = (GRID_STEP / (size.step or GRID_STEP)) ** 2
    density = max(PUBLISHED_DENSITY * max(1.0, fineness), size.density or 0.0)
    threads = available_cores()
    dense, outward, *_ = reconstruct(few, density, reconstruction, reach, NEWTON_STEPS, threads)
    made = sized_mesh(partial(mesh_of_dense, dense, outward, threads=threads), size)
    return made, Surface(dense, outward)


def _with_fields_of(dots: Surface, made: Mesh) -> Mesh:
    """Return a mesh whose vertices have the fields of dots, interpolated, besides those that they have."""
    from sparsurf.recovery.fields import interpolate_fields

    dot_values = {
        name: values
        for name, values in fields_without_component(dots).items()
        if name not in made.vertices.fields
    }
    between = interpolate_fields(dots.points, dot_values, made.vertices.points)
    return replace(made, vertices=replace(made.vertices, fields=between | made.vertices.fields))


def mesh_of_atoms(
    origin: SurfaceOrigin,
    size: MeshSize,
    names: Sequence[FieldLike] = (),
    boundary: Boundary = "excluded",
    **values_of_atoms: Any,
) -> Mesh:
    """Return the mesh of the atoms of an origin, which its vertices carry; size and fields are as in `mesh` and `with_fields`."""
    from sparsurf.surfaces.dot_placement import roll_checked
    from sparsurf.surfaces.triangulation import accessible_mesh, mesh_of_rolled

    xyz, radii, rules = origin.xyz, origin.radii, origin.rules
    rolled = roll_checked(xyz.round(3), radii, rules.probe_radius, cavities=rules.cavities, in_order=True)
    if boundary == "accessible":
        if names:
            raise InputError(
                f"mesh: {argument('fields')} are those of the excluded surface; leave them out, or {argument('boundary')}."
            )
        return accessible_mesh(rolled, size)

    def dense() -> Surface:
        return surface_of_spheres(xyz, radii, rules, D_LINK, "mesh")

    made = mesh_of_rolled(rolled, size)
    vertices = replace(made.vertices, origin=origin)
    return replace(
        made, vertices=with_fields(vertices, names, dense, "mesh", available_cores(), values_of_atoms)
    )


def as_surface(source: SurfaceLike, d_link: float = D_LINK) -> Surface:
    """Return dots from all that `as_dots` takes, and those of a molecule with default settings for `d_link`, Å."""
    given = opened_source(source)
    if isinstance(given, SurfaceAtoms):
        return surface_of_atoms(given, d_link=d_link)
    if not has_atoms(given):
        return as_dots(given)
    return surface_of_molecule(as_molecule(given), Placement(), d_link, "surface", 0)


def as_index(source: SurfaceLike, d_link: float, radius: float, name: str) -> PatchIndex:
    """Return the index of all that `as_surface` takes; its dots must suit `d_link`, and patches of a radius called `name`."""
    dots = as_surface(source, d_link)
    refuse_sparse(dots.points, d_link, "surface", radii={name: radius})
    return build_index(dots.points, dots.normals, d_link)


def placement(
    probe_radius: float = PROBE_RADIUS,
    density: float | Auto = "auto",
    radii: RadiiLike = "dms",
    cavities: Cavities = "keep",
    reentrant: Reentrant = "exact",
) -> Placement:
    """Return how dots are placed for what the functions and commands were given; a density or 'auto'."""
    return Placement(probe_radius, density, check_radii(radii), cavities, reentrant)
