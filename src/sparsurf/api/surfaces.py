"""From a molecule to its surface: dots, triangles and connected components."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.field_values import check_fields, with_fields
from sparsurf.api.inputs import (
    DotsLike,
    MoleculeLike,
    SurfaceLike,
    as_dots,
    as_molecule,
    check_frame,
    has_atoms,
    is_file_of_dots,
    is_subset,
    opened,
)
from sparsurf.arguments import CAVITIES, DENSITY, LENGTH, NUMBER_OF_DOTS, PROBE, REENTRANT, check_choice
from sparsurf.errors import InputError
from sparsurf.molecules.formats import DOTS
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import molecule_of_files
from sparsurf.molecules.source import Source
from sparsurf.patches.index import D_LINK, PatchIndex, build_index
from sparsurf.suggestions import public
from sparsurf.surfaces.chosen_points import Points
from sparsurf.surfaces.components import components_of, fields_without_component, table_of_components
from sparsurf.surfaces.molecular_surface import surface_of_molecule, surface_of_spheres
from sparsurf.surfaces.radii import PROBE_RADIUS, RADII
from sparsurf.surfaces.radii import radii as atomic_radii
from sparsurf.surfaces.spacing import DENSITY as PUBLISHED_DENSITY
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.surfaces.surface import Origin, Placement, Surface, real_numbers
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike

    from sparsurf.dot_fields.registry import FieldLike
    from sparsurf.surfaces.mesh import Mesh
    from sparsurf.surfaces.surface import Rules


@public()
def surface(
    molecule: MoleculeLike | tuple[ArrayLike, ArrayLike],
    *,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    density: float | str = "auto",
    radii: str = "dms",
    d_link: float = D_LINK,
    cavities: str = "keep",
    reentrant: str = "exact",
) -> Surface:
    """Place dots with analytic normals on the solvent-excluded surface of a molecule.

    Parameters
    ----------
    molecule : path, Molecule, atoms of another library, or pair (xyz, radii)
        Path of a structure, a Molecule, atoms of mdtraj, biotite, MDAnalysis, gemmi or Biopython, or the centres (A, 3) and
        radii (A,) of spheres in Å.
    frame : int
        Position of the frame, from 0 (default 0). An AtomGroup of MDAnalysis has one, the current frame of its trajectory.
    probe_radius : float
        Radius of the probe, Å (default 1.4).
    density : float or 'auto'
        Dots per Å^2 (default 'auto': 5.35, or more where `d_link` needs it).
    radii : {'dms', 'bondi'}
        Table of atomic radii (default 'dms').
    d_link : float
        Distance below which two dots of a patch will count as linked, Å (default 0.5).
    cavities : {'keep', 'remove'}
        Whether the dots of closed cavities inside the molecule are kept (default 'keep').
    reentrant : {'exact', 'dms'}
        Whether concave dots inside other probes are removed (default 'exact') or kept, as by the program DMS.

    Returns
    -------
    Surface
        `points` and `normals` (N, 3) in Å, `area` (N,) in Å^2, `kind` (N,) (0 contact, 1 saddle, 2 concave) and `atom` (N,),
        the index of the atom that each dot belongs to. The dots carry their molecule.

    Raises
    ------
    InputError
        The molecule cannot be read, or an argument is outside of its limits.

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> len(dots), dots.points.shape, round(dots.area.sum())
    (24600, (24600, 3), 4560)

    A trajectory of mdtraj; nanometres become Å:

    >>> import mdtraj
    >>> trajectory = mdtraj.load("data/tdp43/trajectory.xtc", top="data/tdp43/topology.pdb", stride=500)
    >>> [len(sparsurf.surface(trajectory, frame=f)) for f in range(2)]
    [24600, 23274]

    Two spheres:

    >>> len(sparsurf.surface(([[0, 0, 0], [3, 0, 0]], [1.5, 1.5])))
    364
    """
    probe_radius, d_link = PROBE.check(probe_radius, "probe_radius"), LENGTH.check(d_link, "d_link")
    density = DENSITY.check(density, "density", "auto")
    rules = placement(probe_radius, density, radii, cavities, reentrant)
    if not isinstance(molecule, tuple):
        atoms = as_molecule(molecule)
        check_frame(atoms, frame, "the molecule")
        return surface_of_molecule(atoms, rules, d_link, "surface", frame)
    atoms, _, sphere_radii = _spheres(molecule, 0, radii)
    return surface_of_spheres(atoms.xyz[0], sphere_radii, rules, d_link, "surface")


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
        One row per component: component, dots, area (Å^2), volume (Å^3) and cavity (bool).

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
    ([24376, 224], [False, True])
    """
    if isinstance(molecule, Surface) and dots is not None:
        raise InputError("components: give the molecule first, then its dots.")
    source: Any = molecule if isinstance(molecule, Surface) else dots
    target = surface(molecule) if source is None else as_dots(source)
    if target.origin is not None:
        if source is dots and not isinstance(molecule, tuple):
            atoms = as_molecule(molecule)
            frame = min(target.origin.frame, atoms.n_frames - 1)
            target.origin.refuse_molecule("components", atoms, frame)
        component = target.known_components("components")
    elif source is molecule:
        raise InputError("components: these dots carry no molecule; pass it first, then the dots.")
    else:
        atoms, frame, atom_radii = _spheres(molecule, 0, "dms")
        if not 0 <= target.atom.min() <= target.atom.max() < len(atom_radii):
            raise InputError(
                "components: the dots are not those of the molecule; give its dots from surface()."
            )
        component = components_of(target, atoms.xyz[frame].round(3), atom_radii, PROBE_RADIUS)
    return component, table_of_components(target, component)


@public(of_dots=True)
def mesh(
    surface: SurfaceLike | tuple[ArrayLike, ArrayLike],
    n_vertices: int | None = None,
    *,
    density: float | None = None,
    fields: FieldLike | Sequence[FieldLike] = (),
) -> Mesh:
    """Triangulate the solvent-excluded surface of a molecule, or the surface reconstructed from a few dots.

    Parameters
    ----------
    surface : path, Molecule, atoms of another library, pair (xyz, radii), Surface, Points, or Subset
        A molecule, whose mesh follows the defaults of `surface`; or all dots that `surface` placed, whose mesh follows the
        rules of their placement, as in `mesh(surface(path, probe_radius=2.0))`. From any other dots (a Subset from
        `minimal`, a file of dots, some of the dots) the surface is reconstructed first.
    n_vertices : int, optional
        Number of vertices, at most 100 per Å^2. Edges of a finer mesh are collapsed until so many are left; every vertex
        lies on the surface with its analytic normal, and the topology stays the same.
    density : float, optional
        Instead of `n_vertices`, the fineness of the triangles, as the number of dots per Å^2 that are as fine (default 5.35).
        Below 2.73 (with a probe of 1.4 Å) a finer mesh is reduced to as many vertices per Å^2.
    fields : str, callable, or sequence of these
        Fields of the vertices (default none): 'roughness', taken from the nearest dot of the dense surface, and any name
        that `fields` accepts.

    Returns
    -------
    Mesh
        `vertices` (a Surface with the atom, the molecule and the fields of each vertex), `triangles` (F, 3) int,
        counterclockwise from outside, and `volume` in Å^3. The mesh is closed.

    Raises
    ------
    InputError
        The molecule or the dots cannot be used, both sizes are given, or the number of vertices is too high.

    Examples
    --------
    >>> import sparsurf
    >>> triangles = sparsurf.mesh("data/tdp43/topology.pdb")
    >>> round(triangles.volume, -2)
    7900.0
    >>> coarse = sparsurf.mesh("data/tdp43/topology.pdb", n_vertices=1024)
    >>> len(coarse.vertices), round(coarse.volume, -3)
    (1024, 8000.0)
    >>> list(coarse.to_frame())[8:]
    ['chain', 'residue', 'residue_name', 'atom_name', 'atom']
    >>> few = sparsurf.minimal("data/tdp43/topology.pdb", percent=10)
    >>> round(sparsurf.mesh(few).volume, -2)
    7900.0
    """
    if n_vertices is not None and density is not None:
        raise InputError("mesh: give either n_vertices or density, not both.")
    n_vertices = None if n_vertices is None else NUMBER_OF_DOTS.check(n_vertices, "n_vertices")
    density = DENSITY.check(PUBLISHED_DENSITY if density is None else density, "density")
    names = check_fields(fields, "mesh")
    source = opened(surface)
    if isinstance(source, Surface) and source.placed:
        made = mesh_of_atoms(source.placed.atoms_alone, n_vertices, density, names)
        return _with_fields_of(source, made)
    if isinstance(source, Surface | Points) or is_subset(source) or is_file_of_dots(source):
        return _mesh_of_dots(as_dots(source), n_vertices, density, names)
    atoms, frame, atom_radii = _spheres(source, 0, "dms")
    molecule = atoms if isinstance(atoms, Molecule) else None
    rules = Placement()
    origin = Origin.of_atoms(molecule, frame, atoms.xyz[frame].round(3), rules, D_LINK, atom_radii)
    return mesh_of_atoms(origin, n_vertices, density, names)


def _mesh_of_dots(few: Surface, n_vertices: int | None, density: float, names: Sequence[FieldLike]) -> Mesh:
    """Return the mesh recovered from few dots; each vertex has the atom of the nearest of them, and interpolated fields."""
    from sparsurf.recovery.mesh import mesh_of_dense
    from sparsurf.recovery.reconstructing import reconstruct
    from sparsurf.sampling.samplers import nearest_kept
    from sparsurf.surfaces.mesh import grid_step_for_density

    threads = available_cores()
    dense, outward, _ = reconstruct(few, density, threads=threads)
    build = partial(mesh_of_dense, dense, outward, threads=threads)
    made = _sized(build, grid_step_for_density(density), n_vertices, density)
    vertices = made.vertices
    both = np.concatenate([few.points, vertices.points])
    nearest = nearest_kept(both, np.arange(len(few)))[0][len(few) :]
    origin = few.origin and few.origin.atoms_alone
    vertices = replace(vertices, atom=few.atom[nearest], origin=origin)
    vertices = with_fields(vertices, names, lambda: Surface(dense, outward), "mesh", threads)
    return _with_fields_of(few, replace(made, vertices=vertices))


def _with_fields_of(dots: Surface, made: Mesh) -> Mesh:
    """Return a mesh whose vertices have the fields of dots, interpolated, besides those that they have."""
    from sparsurf.recovery.fields import interpolate_fields

    known = {
        name: values
        for name, values in fields_without_component(dots).items()
        if name not in made.vertices.fields
    }
    between = interpolate_fields(dots.points, known, made.vertices.points)
    return replace(made, vertices=replace(made.vertices, fields=between | made.vertices.fields))


def mesh_of_atoms(
    origin: Origin, n_vertices: int | None, density: float, names: Sequence[FieldLike] = ()
) -> Mesh:
    """Return the mesh of the atoms of an origin, which its vertices carry; its size and its fields are as in `mesh`."""
    made = _mesh_of_spheres(origin.xyz, origin.radii, origin.rules, n_vertices, density)

    def dense() -> Surface:
        return surface_of_spheres(origin.xyz, origin.radii, origin.rules, D_LINK, "mesh")

    vertices = replace(made.vertices, origin=origin)
    return replace(made, vertices=with_fields(vertices, names, dense, "mesh", available_cores()))


def _mesh_of_spheres(
    xyz: np.ndarray, radii: np.ndarray, rules: Rules, n_vertices: int | None, density: float
) -> Mesh:
    """Return the mesh of spheres at `xyz` (A, 3) with `radii` (A,), Å; its size is as in `mesh`."""
    from sparsurf.surfaces.mesh import grid_step_for_density, molecular_mesh, outer_mesh, widest_step

    widest = widest_step(rules.probe_radius)
    step = min(grid_step_for_density(density) if n_vertices is None else widest_step(PROBE_RADIUS), widest)

    def build(step: float) -> Mesh:
        fine = molecular_mesh(xyz.round(3), radii, rules.probe_radius, step, threads=available_cores())
        return outer_mesh(fine) if rules.cavities == "remove" else fine

    return _sized(build, step, n_vertices, density)


def _sized(build: Callable[[float], Mesh], step: float, n_vertices: int | None, density: float) -> Mesh:
    """Build a mesh on a grid of `step` Å, and reduce it where fewer vertices are requested."""
    from sparsurf.surfaces.decimation import decimate, sized_mesh  # here: dots need none of these kernels
    from sparsurf.surfaces.mesh import grid_step_for_density

    if n_vertices is not None:
        return sized_mesh(build, step, n_vertices)
    fine = build(step)
    if step == grid_step_for_density(density):
        return fine
    return decimate(fine, round(density * float(fine.vertices.area.sum())))


def as_surface(source: SurfaceLike, d_link: float = D_LINK) -> Surface:
    """Return dots from all that `as_dots` takes, and those of a molecule with default settings for `d_link`, Å."""
    given = opened(source)
    if isinstance(given, Source) and given.format.name != DOTS:
        return surface_of_molecule(molecule_of_files(given), Placement(), d_link, "surface", 0)
    if not has_atoms(given):
        return as_dots(given)
    return surface_of_molecule(as_molecule(given), Placement(), d_link, "surface", 0)


def as_index(source: SurfaceLike, d_link: float) -> PatchIndex:
    """Return the index of all that `as_surface` takes; its dots must lie close enough for `d_link`."""
    d_link = LENGTH.check(d_link, "d_link")
    dots = as_surface(source, d_link)
    refuse_sparse(dots.points, d_link, "surface")
    return build_index(dots.points, dots.normals, d_link)


def placement(
    probe_radius: float, density: float | str, radii: str, cavities: str, reentrant: str = "exact"
) -> Placement:
    """Return how dots are placed for what the functions and commands were given; a density or 'auto'."""
    check_choice(cavities, CAVITIES, "cavities")
    check_choice(radii, [*RADII], "radii")
    check_choice(reentrant, REENTRANT, "reentrant")
    return Placement(probe_radius, density, radii, cavities, reentrant)


def _spheres(source: Any, frame: int, table: str) -> tuple[Any, int, np.ndarray]:
    """Return a molecule, a frame of it, and the radii of its atoms, from all that `surface` takes."""
    if isinstance(source, tuple) and len(source) == 2:
        xyz, values = (real_numbers(part, "molecule: a part of the pair").astype(float) for part in source)
        return SimpleNamespace(xyz=xyz[None]), 0, values
    molecule = as_molecule(source)
    check_frame(molecule, frame, "the molecule")
    return molecule, frame, atomic_radii(molecule, table)
