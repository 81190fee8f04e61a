"""Subsets of a surface, chosen and compared with the whole."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pandas as pd

from sparsurf.api.inputs import SurfaceLike, subset_indices
from sparsurf.api.surfaces import as_surface
from sparsurf.arguments import (
    ALPHA,
    DEFAULT_TEST_DOTS,
    EXPONENT,
    LENGTH,
    PERCENT,
    SEED,
    TEST_DOTS,
    Limits,
    check_choice,
)
from sparsurf.errors import InputError
from sparsurf.evaluation.minimal_subset import Subset
from sparsurf.evaluation.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.evaluation.statistics import mean_and_error, reference_values
from sparsurf.evaluation.subset_search import draw_subset, find_subset
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE
from sparsurf.recovery.errors import TAIL_QUANTILE, distance_to_recovered, kept_out
from sparsurf.recovery.readings import READINGS
from sparsurf.sampling import published
from sparsurf.sampling.combination import Combination
from sparsurf.sampling.samplers import get_samplers
from sparsurf.settings import SAMPLERS_OF_COMBINATIONS, Patches, Settings
from sparsurf.streams import DEFAULT_SEED, Streams
from sparsurf.suggestions import public
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")

# dots per Å^2: the dots of every sampler that are as dense hold the surface together
DENSITY_WITHOUT_GAPS = 0.5
MAX_GAP = PROBE_RADIUS  # Å: what lies farther off could let a water in
PreparedLike: TypeAlias = "SurfaceLike | PreparedSurface"


@public(of_dots=True)
def prepare(
    surface: PreparedLike,
    *,
    r_patch: float = R_PATCH,
    r_zernike: float = R_ZERNIKE,
    d_link: float = D_LINK,
    seed: int = DEFAULT_SEED,
) -> PreparedSurface:
    """Prepare a surface for `sample` and `compare`, which otherwise repeat this in every call.

    Parameters
    ----------
    surface : dots from `surface` or `read_surface`, the path of a file of dots, the pair (points, normals),
        or a molecule as in `surface`, whose dots are placed
    r_patch, r_zernike, d_link : float
        Å.
    seed : int
        Of the random streams.

    Returns
    -------
    PreparedSurface
        Its `roughness` is R_i of every dot.

    Examples
    --------
    >>> import sparsurf
    >>> ready = sparsurf.prepare(sparsurf.surface("data/tdp43/topology.pdb"))
    >>> [len(sparsurf.sample(ready, n_dots=n)) for n in (100, 200)]
    [100, 200]
    """
    if isinstance(surface, PreparedSurface):
        if (r_patch, r_zernike, d_link, seed) != (R_PATCH, R_ZERNIKE, D_LINK, DEFAULT_SEED):
            raise InputError(
                "prepare: this surface is prepared already; give its dots to prepare it with other settings."
            )
        return surface
    r_patch, r_zernike = LENGTH.check(r_patch, "r_patch"), LENGTH.check(r_zernike, "r_zernike")
    d_link, seed = LENGTH.check(d_link, "d_link"), SEED.check(seed, "seed")
    dots = as_surface(surface, d_link)
    refuse_sparse(dots.points, d_link, "surface")
    patches = Patches(r_patch=r_patch, r_zernike=r_zernike, d_link=d_link)
    return PreparedSurface(dots, Settings(patches=patches), None, Streams(seed), available_cores())


@public(of_dots=True)
def sample(
    surface: PreparedLike,
    *,
    percent: float | None = None,
    n_dots: int | None = None,
    sampler: str | None = None,
    combination: Sequence[float] | None = None,
    seed: int | None = None,
) -> np.ndarray:
    """Choose dots that represent a surface; `minimal` and a study choose the same with the same seed.

    Parameters
    ----------
    surface : as in `prepare`, or its result
    percent, n_dots : float or int, one of them
        Share of all dots, or number of dots. The paper's samplers keep about that many.
    sampler : str
        How the dots are chosen, by one of the names in `sparsurf.sampling.samplers.SAMPLERS`: "farthest" (the default) takes
        dots that are as far from one another as possible, "uniform" a random subset, "paper" the sampling of the paper.
    combination : (alpha, beta, gamma, delta), optional
        Instead of a size: one draw of the paper's sampling, or of paper_corrected.
    seed : int, optional
        Seed of the draw; by default that of the prepared surface, or 20261120.

    Returns
    -------
    (n_dots,) int64
        Dots. The first m dots of a nested sampler (farthest, uniform, ...) are its subset of m dots.

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> kept = sparsurf.sample(dots, percent=10)
    >>> len(kept), dots.points[kept].shape
    (2460, (2460, 3))
    >>> len(sparsurf.sample(dots, combination=(1, 0, 6, 0)))
    11344
    """
    prepared = prepare(surface)
    if seed is not None:
        prepared = prepared.changed(stream=replace(prepared.stream, seed=SEED.check(seed, "seed")))
    sizes = [name for name, value in (("percent", percent), ("n_dots", n_dots)) if value is not None]
    if combination is not None:
        kept = _draw_combination(prepared, combination, sampler, sizes)
    else:
        if len(sizes) != 1:
            raise InputError("sample: give either percent or n_dots, such as percent=10.")
        sampler, n = "farthest" if sampler is None else sampler, len(prepared.points)
        if n_dots is None:
            n_dots = max(1, round(PERCENT.check(percent, "percent") / 100 * n))
        n_dots = Limits(1, n, whole=True, open_low=False).check(n_dots, "n_dots")
        get_samplers([sampler], "sampler")  # names an unknown one
        kept = draw_subset(prepared, sampler, n_dots)
    warn_of_gaps("sample", prepared, kept)
    return kept


def warn_of_gaps(name: str, prepared: PreparedSurface, kept: np.ndarray) -> None:
    """Warn if the surface that the kept dots give back lies too far from the full one to be the same surface."""
    if len(kept) == len(prepared) or len(kept) > DENSITY_WITHOUT_GAPS * prepared.area:
        return
    few = prepared.surface.take(kept)
    distances = distance_to_recovered(prepared.points, few.points, few.normals, available_cores())
    far = np.quantile(kept_out(distances, kept), TAIL_QUANTILE)
    if far > MAX_GAP:
        log.warning(
            "%s: too few dots (%d) to hold the surface together: 1 %% of it lies %.1f Å or more from what they give back; "
            "keep more", name, len(kept), far,
        )  # fmt: skip


def _draw_combination(
    prepared: PreparedSurface, combination: Sequence[float], sampler: str | None, sizes: list[str]
) -> np.ndarray:
    """Return one draw of the paper's sampling by a combination."""
    if sizes:
        raise InputError(
            f"sample: a combination leaves the number of dots to chance; leave out {sizes[0]} or the combination."
        )
    if sampler not in (None, *SAMPLERS_OF_COMBINATIONS):
        names = " and ".join(SAMPLERS_OF_COMBINATIONS)
        raise InputError(f"sample: {names} draw by a combination, not {sampler!r}; leave out one of the two.")
    sampler = sampler or SAMPLERS_OF_COMBINATIONS[0]
    return find_subset(prepared, sampler, combination=_combination(combination))[0]


@public(of_dots=True)
def compare(
    surface: PreparedLike,
    subsets: ArrayLike | Subset | Mapping[str, ArrayLike | Subset],
    *,
    reading: str = "full",
    test_dots: int | str = DEFAULT_TEST_DOTS,
) -> pd.DataFrame:
    """Compare how well subsets describe a surface, next to uniform subsets of the same size.

    Parameters
    ----------
    surface : as in `prepare`, or its result
    subsets : (n,) int dots or (N,) bool, a Subset of the same dots from `minimal`, or a dict of several by name
    reading : {'kept', 'kept_scaled', 'full', 'recovered'}
        Whether the islands of a patch are removed on the full surface or among the kept dots, these linked by their own
        spacing if 'kept_scaled'; 'recovered': patches of the surface that the kept dots give back.
    test_dots : int or 'published'
        Dots at which the descriptors are compared, the same for all subsets.

    Returns
    -------
    DataFrame, one row per subset
        n_S, n_S_percent, Z (mean distance of the descriptors, 0 is the surface itself), Z_se, Z_uniform, d (Z_uniform
        - Z: positive if the subset is better than chance), d_se, and the references Z_empty (an empty patch)
        and Z_mean_descriptor (every patch given the mean descriptor).

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> ready = sparsurf.prepare(dots)
    >>> table = sparsurf.compare(ready, {"farthest": sparsurf.sample(ready, percent=10)})
    >>> print(table[["n_S", "Z", "Z_uniform", "d"]].round(2))
               n_S     Z  Z_uniform     d
    subset
    farthest  2460  1.07        1.4  0.33
    """
    prepared = prepare(surface)
    by_name: Mapping[str, Any] = subsets if isinstance(subsets, Mapping) else {"subset": subsets}
    if not by_name:
        raise InputError("subsets: there are none; give at least one.")
    check_choice(reading, list(READINGS), "reading")
    test_dots, n = TEST_DOTS.check(test_dots, "test_dots", "published"), len(prepared.points)
    kept = [subset_indices(name, subset, n) for name, subset in by_name.items()]
    for (name, subset), dots in zip(by_name.items(), kept, strict=True):
        if isinstance(subset, Subset) and not np.array_equal(subset.points, prepared.points[dots]):
            raise InputError(f"{name}: this subset was chosen from other dots; compare its own dots.")
    tests = prepared.draw_tests(number_of_tests(test_dots, n))
    uniform = [published.uniform_subset(n, len(dots), prepared.stream("compare", len(dots))) for dots in kept]
    z_tot, _ = prepared.describe(tests)
    distances, _ = prepared.distances(kept + uniform, tests, z_tot, reading)
    references = reference_values(z_tot)
    rows = []
    for dots, of_subset, other in zip(kept, distances, distances[len(kept) :], strict=False):
        (z, z_se), (d, d_se) = mean_and_error(of_subset[None]), mean_and_error((other - of_subset)[None])
        size = {"n_S": len(dots), "n_S_percent": 100 * len(dots) / n}
        rows.append(
            size
            | {"Z": z, "Z_se": z_se, "Z_uniform": other.mean(), "d": d, "d_se": d_se}
            | {"Z_empty": references["Z_empty"], "Z_mean_descriptor": references["Z_mean_descriptor"]}
        )
    return pd.DataFrame(rows, index=pd.Index(list(by_name), name="subset"))


def _combination(values: Sequence[float]) -> Combination:
    """Return the Combination of four numbers, after a check of each."""
    try:
        combination = Combination(*values)
    except TypeError:
        raise InputError(
            f"combination is {values!r}; it must be the four numbers alpha, beta, gamma and delta."
        ) from None
    limits = (ALPHA, EXPONENT, EXPONENT, EXPONENT)
    checked = [
        limit.check(value, f"combination: {name}")
        for limit, value, name in zip(limits, combination, Combination._fields, strict=True)
    ]
    return Combination(*checked)
