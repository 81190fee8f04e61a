"""A few points with normals on the surface of a molecule, or of every structure of a folder, for whoever learns on surfaces."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sparsurf.api.field_values import check_fields, refuse_maps, with_fields
from sparsurf.api.folders import ResultsOfFolder
from sparsurf.api.inputs import MoleculeLike, as_spheres, first_group
from sparsurf.api.surfaces import placement
from sparsurf.arguments import Cavities, RadiiLike, public
from sparsurf.errors import InputError
from sparsurf.molecules.listing import structures_in
from sparsurf.molecules.selection import Groups
from sparsurf.patches.index import D_LINK, build_grid
from sparsurf.sampling.farthest_point import farthest_points
from sparsurf.streams import DEFAULT_SEED, stream
from sparsurf.surfaces.chosen_points import NamedPoints, Points, on_steps
from sparsurf.surfaces.molecular_surface import MAX_DENSITY, RolledFrame, roll_spheres
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.spacing import DENSITY as PUBLISHED_DENSITY
from sparsurf.surfaces.surface import MAX_AREA, Rules, Surface, SurfaceOrigin
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from sparsurf.dot_fields.named_fields import FieldLike

log = logging.getLogger("sparsurf")

N_POINTS = 1024
DOTS_PER_POINT = 2.0  # placed for each point that is chosen, at least


class PointsRequest(NamedTuple):
    """What is requested of every structure, checked."""

    n_dots: int | None
    density: float | None
    seed: int
    rules: Rules
    fields: tuple[FieldLike, ...]


@public()
def points(
    molecule: MoleculeLike | tuple[ArrayLike, ArrayLike],
    n_dots: int | None = None,
    *,
    density: float | None = None,
    fields: FieldLike | Sequence[FieldLike] = (),
    seed: int = DEFAULT_SEED,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    radii: RadiiLike = "dms",
    cavities: Cavities = "remove",
    groups: Groups | None = None,
) -> Points:
    """Choose points with normals on the solvent-excluded surface of a molecule, as far from one another as possible.

    Parameters
    ----------
    molecule : path, Molecule, atoms of another library, or pair (xyz, radii)
        The molecule, as for `surface`.
    n_dots, density : int, float, optional
        The number of points (default 1024), or in its place their number per Å^2.
    fields : str, callable, or sequence of these
        Values at the points (default none): 'roughness', that of the dense surface there, and any name that `fields` accepts.
    seed : int
        Seed for the choice of the first point, from which all others follow, on every machine alike (default 20261120).
    frame, probe_radius, radii : as in `surface`
        The frame of the molecule, the radius of the probe and the atomic radii, with the same defaults.
    cavities : {'remove', 'keep'}
        Whether closed cavities inside the molecule are left without points (default 'remove').
    groups : str or sequence, optional
        As in `areas` (default all atoms): they lie on the surface of the first group; 'burial' is the depth below that of all.

    Returns
    -------
    Points
        The pair of `points`, exactly on the surface, and analytic `normals`, (n_dots, 3) float32 each, Å; its length is 2, and
        `n_dots` the number of points. The first m points are spread as far as m points can be by this method. `area` (Å^2 of each
        point), `kind`, `atom`, `fields` and `to_frame`, which names residues and atoms, are further attributes.

    Raises
    ------
    InputError
        The molecule cannot be read, an argument is outside of its limits, or so many points cannot be placed.

    Examples
    --------
    >>> import sparsurf
    >>> points, normals = sparsurf.points("data/tdp43/topology.pdb", n_dots=512)
    >>> points.shape, normals.dtype
    ((512, 3), dtype('float32'))
    >>> few = sparsurf.points("data/tdp43/topology.pdb", density=0.5, fields=["roughness", "hydropathy"])
    >>> few.n_dots, list(few.to_frame())[6:]
    (2241, ['area', 'kind', 'chain', 'residue', 'residue_name', 'atom_name', 'atom', 'roughness', 'hydropathy'])
    """
    request = _checked(n_dots, density, fields, seed, probe_radius, radii, cavities)
    return _chosen(molecule, request, frame, groups)


def _checked(
    n_dots: int | None,
    density: float | None,
    fields: FieldLike | Sequence[FieldLike],
    seed: int,
    probe_radius: float,
    radii: RadiiLike,
    cavities: Cavities,
) -> PointsRequest:
    """Check the arguments of `points` and `points_of`."""
    if n_dots is not None and density is not None:
        raise InputError("points: give either n_dots or density, not both.")
    if density is None:
        n_dots = N_POINTS if n_dots is None else n_dots
    rules = placement(probe_radius, "auto", radii, cavities)
    return PointsRequest(n_dots, density, seed, rules, check_fields(fields, "points"))


def _chosen(molecule: Any, request: PointsRequest, frame: int = 0, groups: Groups | None = None) -> Points:
    """Choose points of one molecule, or of the first of some groups."""
    rules, partner = request.rules, None
    if groups is not None:
        molecule, partner = first_group(molecule, frame, groups, rules.radii)
    atoms, xyz, atom_radii = as_spheres(molecule, frame, rules.radii)
    rolled = roll_spheres(xyz, atom_radii, rules.probe_radius, cavities=rules.cavities)
    dots, n, placed = _dense_dots(rolled, request.n_dots, request.density)
    chosen, nearest = farthest_points(build_grid(on_steps(dots.points)), n, stream(request.seed, "points"))
    area = np.bincount(nearest, dots.area, n)
    origin = SurfaceOrigin.of_atoms(atoms, frame, xyz, rules, D_LINK, atom_radii)
    origin = replace(origin, partner=partner)
    few = Surface(
        dots.points[chosen].astype(np.float32),
        dots.normals[chosen].astype(np.float32),
        area if area.max() < MAX_AREA else None,
        dots.kind[chosen],
        dots.atom[chosen],
        origin=origin,
    )

    def dense() -> Surface:
        published = dots if placed == PUBLISHED_DENSITY else None
        return rolled.surface_for_d_link("auto", D_LINK, "points", published)[0]

    return Points(with_fields(few, request.fields, dense, "points", available_cores()))


def _dense_dots(rolled: RolledFrame, n_dots: int | None, density: float | None) -> tuple[Surface, int, float]:
    """Place dots from which points can be chosen, and return the number of points and the density of the dots, per Å^2."""
    placed = max(PUBLISHED_DENSITY, DOTS_PER_POINT * (density or 0.0))
    while True:
        placed = min(placed, float(MAX_DENSITY))
        dots = rolled.surface(placed)
        n = max(1, round(density * float(dots.area.sum()))) if density else n_dots
        assert n is not None  # one of both is given
        if len(dots) >= DOTS_PER_POINT * n or (placed == MAX_DENSITY and len(dots) >= n):
            return dots, n, placed
        if placed == MAX_DENSITY:
            raise InputError(
                f"points: {n:,} points on {dots.area.sum():,.0f} Å^2 are more than {MAX_DENSITY} per Å^2; ask for fewer."
            )
        placed *= 1.05 * DOTS_PER_POINT * n / len(dots)


class PointsOfFolder(ResultsOfFolder):
    """The points of each structure of a folder, one after the other by name.

    Attributes
    ----------
    failures : dict, name -> str, why a structure is left out; complete at the end
    """

    def __next__(self) -> NamedPoints:
        return NamedPoints.of_points(*super().__next__())


@public()
def points_of(
    folder: str | Path | Sequence[str | Path],
    n_dots: int | None = None,
    *,
    density: float | None = None,
    fields: FieldLike | Sequence[FieldLike] = (),
    seed: int = DEFAULT_SEED,
    probe_radius: float = PROBE_RADIUS,
    radii: RadiiLike = "dms",
    cavities: Cavities = "remove",
    jobs: int = 1,
) -> PointsOfFolder:
    """Choose points with normals on the surface of every structure of a folder, or of a list of files.

    Parameters
    ----------
    folder : str or Path, or list of these
        Folder whose .pdb, .ent, .cif and .mmcif files are read, also compressed and in folders below it, or a list of files.
    n_dots : int, optional
        Number of points on each structure (default 1024, unless `density` is given).
    density : float, optional
        Instead of `n_dots`, the number of points per Å^2.
    fields, seed, probe_radius, radii, cavities : as in `points`
        Values at the points, the seed, and how the surface is made, with the same defaults.
    jobs : int
        Number of processes (default 1); the results do not depend on it.

    Yields
    ------
    name : str
        Path of the file below the folder without its suffixes, as job1/model, and in a list the shortest end of it that no
        other file has; the structures follow one another in the order of their names, and those of a list in its order.
    points, normals : (n_dots, 3) float32
        Å and unit vectors. The triple of name, points and normals also has the attributes of `Points`, such as `atom`,
        `fields` and `to_frame`. A structure that fails is left out: the attribute `failures` of the iterator holds its name
        and the reason. At the end, one warning sums up these failures, and one more sums up each kind of warning.

    Raises
    ------
    InputError
        An argument is outside of its limits, a file of the list does not exist, or there is no structure.

    Examples
    --------
    >>> import sparsurf
    >>> results = sparsurf.points_of("data/tdp43", n_dots=256, fields="roughness")
    >>> for few in results:
    ...     print(few.name, few.points.shape, few.atom.shape, few.fields["roughness"].dtype)
    topology (256, 3) (256,) float32
    >>> results.failures
    {}
    """
    request = _checked(n_dots, density, fields, seed, probe_radius, radii, cavities)
    refuse_maps(request.fields, "points_of")
    return PointsOfFolder(structures_in(folder), partial(_chosen, request=request), jobs)
