"""The minimal subset of a surface, the noise floors that measure it, and the surface recovered from it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from sparsurf.api.inputs import DENSITY as DENSITIES
from sparsurf.api.inputs import (
    ERROR,
    NUMBER_OF_DOTS,
    PERCENT,
    DotsLike,
    Limits,
    SurfaceLike,
    as_dots,
    as_molecule,
    has_atoms,
    refuse_other_rules,
    refuse_placement,
)
from sparsurf.api.subsets import prepare
from sparsurf.api.surfaces import surface, surface_settings
from sparsurf.errors import InputError
from sparsurf.molecules.molecule import Molecule
from sparsurf.patches.index import D_LINK
from sparsurf.recovery.fields import interpolate_fields
from sparsurf.recovery.recovering import NEWTON_STEPS, REACH
from sparsurf.recovery.recovering import recover as recovered_dots
from sparsurf.streams import DEFAULT_SEED
from sparsurf.study.floors import floors_table, measure_floors
from sparsurf.study.minimal_subset import Subset, select_minimal_subset
from sparsurf.study.prepared_surface import number_of_tests
from sparsurf.study.required_dots import Trials
from sparsurf.surfaces.components import fields_without_component
from sparsurf.surfaces.molecular_surface import surface_generator
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.radii import radii as atomic_radii
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd

    # what places other dots on atoms, and their positions
    Generator: TypeAlias = tuple[Callable[[np.ndarray], Surface] | None, np.ndarray | None]

TEST_DOTS = 200  # as in a study
DEFAULT_ERROR = 0.02  # Å, as in a study
DISTANCE = Limits(0, 10)  # Å
REACHES = Limits(0, 10)  # spacings; at 20, dots lie 15 Å and more off the surface of a peptide
STEPS = Limits(0, 1000, whole=True)


def minimal(
    surface: SurfaceLike,
    *,
    percent: float | None = None,
    n_dots: int | None = None,
    error: float | None = None,
    max_z: float | None = None,
    sampler: str = "farthest",
    seed: int = DEFAULT_SEED,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    density: float | str = "auto",
    radii: str = "dms",
    d_link: float = D_LINK,
    cavities: str = "keep",
) -> Subset:
    """Select the few dots that represent a surface; a study and the command select the same with the same seed.

    Parameters
    ----------
    surface : molecule as in `surface`, or dots as in `prepare`
    percent, n_dots, error, max_z : float, int, float, float, at most one of them
        Share of all dots, number of dots, mean distance in Å of the recovered surface from the true one, or largest Z of the
        dots as they are. Without any, error is 0.02 Å.
    sampler : str
        As in `sample`.
    seed : int
    frame, probe_radius, density, radii, d_link, cavities : as in `surface`

    Returns
    -------
    Subset
        `dots` (n,), `weight` (n,), `points` and `normals` (n, 3), `surface` of the kept dots, `table`, a DataFrame, and
        `interval`, the 95 % interval of their number where an error is given.

    Examples
    --------
    >>> import sparsurf
    >>> few = sparsurf.minimal("data/tdp43/topology.pdb", percent=10)
    >>> few
    Subset of 2,460 dots of 24,600
    >>> len(few), few.points.shape, list(few.table)[:4]
    (2460, (2460, 3), ['dot', 'x', 'y', 'z'])

    `sample` chooses the same dots:

    >>> kept = sparsurf.sample("data/tdp43/topology.pdb", percent=10)
    >>> bool((kept == few.dots).all())
    True
    """
    sizes = {
        "n_S_percent": None if percent is None else PERCENT.check(percent, "percent"),
        "n_S": None if n_dots is None else NUMBER_OF_DOTS.check(n_dots, "n_dots"),
        "error": None if error is None else DISTANCE.check(error, "error"),
        "Z": None if max_z is None else ERROR.check(max_z, "max_z"),
    }
    request = {key: value for key, value in sizes.items() if value is not None}
    if len(request) > 1:
        raise InputError("minimal: give only one of percent, n_dots, error and max_z.")
    rules = {
        "probe_radius": probe_radius, "density": density, "radii": radii, "d_link": d_link, "cavities": cavities,
    }  # fmt: skip
    dots, _, molecule = _dots_and_generator(surface, frame, rules)
    if n_dots is not None and n_dots > len(dots):
        raise InputError(f"minimal: n_dots is {n_dots}, more than the {len(dots)} dots of the surface.")
    prepared, n_tests = prepare(dots, d_link=d_link, seed=seed), number_of_tests(TEST_DOTS, len(dots))
    trials = Trials(prepared, sampler, n_tests)
    return select_minimal_subset(trials, request or {"error": DEFAULT_ERROR}, molecule=molecule)


def floors(
    surface: SurfaceLike,
    *,
    seed: int = DEFAULT_SEED,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    density: float | str = "auto",
    radii: str = "dms",
    d_link: float = D_LINK,
    cavities: str = "keep",
) -> pd.DataFrame:
    """Measure the noise floors: Z between two descriptions of one surface.

    Parameters
    ----------
    surface, seed, frame, probe_radius, density, radii, d_link, cavities : as in `minimal`

    Returns
    -------
    DataFrame
        floor, Z, se, low, high (95 %), draws, test_dots: other dots of the surface, of the turned molecule, and, for a
        structure, of moved atoms.

    Examples
    --------
    >>> import sparsurf
    >>> table = sparsurf.floors("protein.pdb")  # doctest: +SKIP
    """
    rules = {
        "probe_radius": probe_radius, "density": density, "radii": radii, "d_link": d_link, "cavities": cavities,
    }  # fmt: skip
    dots, generator, _ = _dots_and_generator(surface, frame, rules)
    prepared = prepare(dots, d_link=d_link, seed=seed)
    return floors_table(measure_floors(prepared, number_of_tests(TEST_DOTS, len(dots)), *generator))


def recover(
    few: DotsLike, *, density: float = DENSITY, reach: float = REACH, steps: int = NEWTON_STEPS
) -> Surface:
    """Place dense dots on the surface that a few dots with normals describe; nothing else is needed.

    Parameters
    ----------
    few : a Subset from `minimal`, a Surface of the few dots, the path of a file of them, or the pair (points, normals)
    density : float
        Dots per Å^2 requested.
    reach : float
        How far the surface extends around a dot, in units of the local spacing of the dots. 2 closes holes between uneven
        dots; larger values place dots where there is no surface.
    steps : int
        Largest number of Newton steps.

    Returns
    -------
    Surface
        The given dots, unchanged, then the new ones between them, with interpolated fields.

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> dense = sparsurf.recover(dots[sparsurf.sample(dots, percent=10)])
    >>> len(dense)
    28436

    Their mean distance in Å from the nearest dot of the molecule, whose own dots are about 0.4 Å apart:

    >>> from scipy.spatial import cKDTree
    >>> distance = cKDTree(dots.points).query(dense.points)[0]
    >>> round(float(distance.mean()), 2)
    0.16
    """
    density, reach = DENSITIES.check(density, "density"), REACHES.check(reach, "reach")
    steps, kept = STEPS.check(steps, "steps"), as_dots(few)
    points, normals = recovered_dots(kept.points, kept.normals, density, reach, steps, available_cores())
    fields = fields_without_component(kept)
    between = interpolate_fields(kept.points, fields, points[len(kept) :])
    fields = {name: np.concatenate([fields[name], values]) for name, values in between.items()}
    return Surface(points, normals, fields=fields)


def _dots_and_generator(
    source: SurfaceLike, frame: int, rules: dict[str, Any]
) -> tuple[Surface, Generator, Molecule | None]:
    """Return dots, what places other dots on the atoms, and the molecule; the last two are None for dots alone."""
    placement = {key: value for key, value in rules.items() if key != "d_link"}  # which serves all dots
    if isinstance(source, Surface) and source.placed:
        origin = source.placed
        refuse_other_rules(origin, "minimal", frame=frame, **placement)
        return source, _generator(origin.molecule, origin.frame, **origin.rules), origin.molecule
    if not has_atoms(source):
        dots: Any = source
        refuse_placement("minimal", frame=frame, **placement)
        return as_dots(dots), (None, None), None
    atoms: Any = source
    molecule = as_molecule(atoms)
    return surface(molecule, frame=frame, **rules), _generator(molecule, frame, **rules), molecule


def _generator(
    molecule: Molecule,
    frame: int,
    probe_radius: float,
    density: float | str,
    radii: str,
    d_link: float,
    cavities: str,
) -> Generator:
    """Return what places other dots on the atoms of one frame."""
    settings = surface_settings(probe_radius, density, cavities)
    return surface_generator(molecule, frame, atomic_radii(molecule, radii), settings, d_link, "surface")
