"""The minimal subset of a surface, the noise floors that measure it, and the surface recovered from it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.inputs import DENSITY as DENSITIES
from sparsurf.api.inputs import (
    ERROR,
    LENGTH,
    NUMBER_OF_DOTS,
    PERCENT,
    SEED,
    DotsLike,
    Limits,
    SurfaceLike,
    as_dots,
    has_atoms,
    refuse_placement,
)
from sparsurf.api.subsets import prepare
from sparsurf.api.surfaces import surface
from sparsurf.errors import InputError
from sparsurf.patches.index import D_LINK
from sparsurf.recovery.fields import interpolate_fields
from sparsurf.recovery.recovering import NEWTON_STEPS, REACH
from sparsurf.recovery.recovering import recover as recovered_dots
from sparsurf.sampling.samplers import get_samplers
from sparsurf.settings import Distance, Minimal, Patches, Settings
from sparsurf.streams import DEFAULT_SEED, Streams
from sparsurf.study.floors import floors_table, measure_floors
from sparsurf.study.minimal_subset import Subset, represent
from sparsurf.study.prepared_surface import number_of_tests
from sparsurf.surfaces.components import fields_without_component
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.spacing import DENSITY, refuse_sparse
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd

TEST_DOTS = 200  # as in a study
DISTANCE = Limits.of(Distance)  # Å
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
        "percent": None if percent is None else PERCENT.check(percent, "percent"),
        "n_dots": None if n_dots is None else NUMBER_OF_DOTS.check(n_dots, "n_dots"),
        "error": None if error is None else DISTANCE.check(error, "error"),
        "max_z": None if max_z is None else ERROR.check(max_z, "max_z"),
    }
    request = {key: value for key, value in sizes.items() if value is not None}
    if len(request) > 1:
        raise InputError("minimal: give only one of percent, n_dots, error and max_z.")
    dots = _dots(
        surface,
        frame=frame,
        probe_radius=probe_radius,
        density=density,
        radii=radii,
        d_link=d_link,
        cavities=cavities,
    )
    if n_dots is not None and n_dots > len(dots):
        raise InputError(f"minimal: n_dots is {n_dots}, more than the {len(dots)} dots of the surface.")
    get_samplers([sampler], "minimal.sampler")  # names an unknown one
    seed = SEED.check(seed, "seed")
    wanted = Minimal(**request).model_copy(update={"sampler": sampler})
    settings = Settings(patches=Patches(d_link=d_link)).model_copy(update={"minimal": wanted})
    molecule = dots.placed.molecule if dots.placed else None
    return represent(dots, settings, Streams(seed), molecule, threads=available_cores()).subset


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
    dots = _dots(
        surface,
        frame=frame,
        probe_radius=probe_radius,
        density=density,
        radii=radii,
        d_link=d_link,
        cavities=cavities,
    )
    prepared = prepare(dots, d_link=d_link, seed=seed)
    return floors_table(measure_floors(prepared, number_of_tests(TEST_DOTS, len(dots)), *dots.generator))


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


def _dots(source: SurfaceLike, **rules: Any) -> Surface:
    """Return dots that suit d_link; those of a molecule know it."""
    d_link = LENGTH.check(rules["d_link"], "d_link")
    placement = {key: value for key, value in rules.items() if key != "d_link"}  # which serves all dots
    if isinstance(source, Surface) and source.placed:
        source.placed.refuse_rules("minimal", **placement)
        dots = source
    elif has_atoms(source):
        atoms: Any = source
        dots = surface(atoms, **rules)
    else:
        refuse_placement("minimal", **placement)
        few: Any = source
        dots = as_dots(few)
    refuse_sparse(dots.points, d_link, "surface")
    return dots
