"""The minimal subset of a surface, the noise floor that measures it, and the surface recovered from it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.inputs import DotsLike, SurfaceLike, as_dots
from sparsurf.api.subsets import prepare, warn_of_gaps
from sparsurf.api.surfaces import as_surface
from sparsurf.arguments import (
    DEFAULT_TEST_DOTS,
    DISTANCE,
    ERROR,
    LENGTH,
    NUMBER_OF_DOTS,
    PERCENT,
    SEED,
    Limits,
)
from sparsurf.arguments import DENSITY as DENSITIES
from sparsurf.errors import InputError
from sparsurf.evaluation.floors import floors_table, fresh_dots
from sparsurf.evaluation.minimal_subset import Representation, Subset, represent
from sparsurf.evaluation.prepared_surface import number_of_tests
from sparsurf.patches.index import D_LINK
from sparsurf.recovery.fields import interpolate_fields
from sparsurf.recovery.recovering import NEWTON_STEPS, REACH
from sparsurf.recovery.recovering import recover as recovered_dots
from sparsurf.sampling.samplers import get_samplers
from sparsurf.settings import Minimal, Patches, Settings
from sparsurf.streams import DEFAULT_SEED, Streams
from sparsurf.suggestions import public
from sparsurf.surfaces.components import fields_without_component
from sparsurf.surfaces.spacing import DENSITY, refuse_sparse
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd

REACHES = Limits(0, 10)  # spacings; at 20, dots lie 15 Å and more off the surface of a peptide
STEPS = Limits(0, 1000, whole=True)
SIZES = {
    "percent": PERCENT,
    "n_dots": NUMBER_OF_DOTS,
    "density": DENSITIES,
    "error": DISTANCE,
    "max_z": ERROR,
}


@public(of_dots=True)
def minimal(
    surface: SurfaceLike,
    *,
    percent: float | None = None,
    n_dots: int | None = None,
    density: float | None = None,
    error: float | None = None,
    max_z: float | None = None,
    sampler: str = "farthest",
    d_link: float = D_LINK,
    seed: int = DEFAULT_SEED,
) -> Subset:
    """Select the few dots that represent a surface; a study and the command select the same with the same seed.

    Parameters
    ----------
    surface : molecule as in `surface`, or dots as in `prepare`
        Dots are placed by other rules in `surface`: `minimal(surface(path, probe_radius=2.0))`. A path alone is placed
        with the defaults.
    percent, n_dots, density, error, max_z : float, int, float, float, float, at most one of them
        Share of all dots, number of dots, number of dots per Å^2, mean distance in Å of the recovered surface from the true
        one, or largest Z of the dots as they are. Without any, error is 0.02 Å. `density_for` says which density an error
        takes: 0.6 dots per Å^2 for 0.02 Å on any protein without explicit hydrogens.
    sampler : str
        As in `sample`.
    d_link : float
        Å, distance below which two dots of a patch are linked.
    seed : int

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
    sizes = {"percent": percent, "n_dots": n_dots, "density": density, "error": error, "max_z": max_z}
    return represented(surface, sizes, sampler, seed, d_link).subset


def represented(
    source: SurfaceLike, sizes: dict[str, Any], sampler: str, seed: int, d_link: float
) -> Representation:
    """Return a surface and its subset of a size; those of `sizes` that are None are not requested."""
    request = {key: SIZES[key].check(value, key) for key, value in sizes.items() if value is not None}
    if len(request) > 1:
        raise InputError("minimal: give only one of percent, n_dots, density, error and max_z.")
    dots = _linked_dots(source, d_link)
    if request.get("n_dots", 0) > len(dots):
        raise InputError(
            f"minimal: n_dots is {request['n_dots']}, more than the {len(dots)} dots of the surface."
        )
    get_samplers([sampler], "minimal.sampler")  # names an unknown one
    seed = SEED.check(seed, "seed")
    wanted = Minimal(**request).model_copy(update={"sampler": sampler})
    settings = Settings(patches=Patches(d_link=d_link)).model_copy(update={"minimal": wanted})
    molecule = dots.molecule if dots.placed else None
    result = represent(dots, settings, Streams(seed), molecule, threads=available_cores())
    warn_of_gaps("minimal", result.trials.prepared, result.subset.dots)
    return result


@public(of_dots=True)
def floors(surface: SurfaceLike, *, d_link: float = D_LINK, seed: int = DEFAULT_SEED) -> pd.DataFrame:
    """Measure the noise floor: Z between two sets of dots of one surface, with which any other Z is compared.

    Parameters
    ----------
    surface, d_link, seed : as in `minimal`

    Returns
    -------
    DataFrame
        One row: floor ("fresh dots", other dots of the same surface), Z, se, low, high (95 %), draws, test_dots.

    Examples
    --------
    >>> import sparsurf
    >>> table = sparsurf.floors("protein.pdb")  # doctest: +SKIP
    """
    dots = _linked_dots(surface, d_link)
    prepared = prepare(dots, d_link=d_link, seed=seed)
    return floors_table(fresh_dots(prepared, number_of_tests(DEFAULT_TEST_DOTS, len(dots)), *dots.generator))


@public()
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


def _linked_dots(source: SurfaceLike, d_link: float) -> Surface:
    """Return the dots of all that `as_surface` takes, dense enough for `d_link`, Å."""
    dots = as_surface(source, LENGTH.check(d_link, "d_link"))
    refuse_sparse(dots.points, d_link, "surface")
    return dots
