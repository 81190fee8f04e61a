"""Subsets of a surface, chosen and compared with the whole."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from sparsurf import registry
from sparsurf.api.inputs import SurfaceLike, subset_indices
from sparsurf.api.surfaces import as_surface
from sparsurf.arguments import (
    ALPHA,
    DEFAULT_TEST_DOTS,
    EXPONENT,
    Limits,
    public,
)
from sparsurf.errors import InputError, argument
from sparsurf.evaluation.minimal_subset import Subset
from sparsurf.evaluation.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.evaluation.statistics import mean_and_error, reference_values
from sparsurf.evaluation.subset_search import draw_subset, find_subset
from sparsurf.files import pluralise
from sparsurf.patches.descriptors import PUBLISHED, DescriptorLike
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE
from sparsurf.patches.readings import ReadingLike, reading_of
from sparsurf.patches.roughness import RoughnessFunction
from sparsurf.recovery.errors import TAIL_QUANTILE, distance_to_recovered, kept_out
from sparsurf.sampling import published
from sparsurf.sampling.combination import Combination
from sparsurf.sampling.samplers import SamplerLike, get_samplers
from sparsurf.settings import PatchesSettings, Settings
from sparsurf.streams import DEFAULT_SEED, Streams
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")

# dots per Å^2: the dots of every sampler that are as dense hold the surface together
DENSITY_WITHOUT_GAPS = 0.5
MAX_SUBSET_GAP = PROBE_RADIUS  # Å: what lies farther off could let a water in
PreparedLike: TypeAlias = "SurfaceLike | PreparedSurface"


@public(of_dots=True)
def prepare(
    surface: PreparedLike,
    *,
    r_patch: float = R_PATCH,
    r_zernike: float = R_ZERNIKE,
    d_link: float = D_LINK,
    seed: int = DEFAULT_SEED,
    roughness: str | RoughnessFunction = PUBLISHED,
    descriptor: DescriptorLike = PUBLISHED,
) -> PreparedSurface:
    """Prepare a surface for many calls of `sample` and `compare`, which otherwise prepare it each time.

    Parameters
    ----------
    surface : Surface, path, pair (points, normals), or molecule
        Dots from `surface` or `read_surface`, a file of dots, a pair of (N, 3) arrays, or a molecule as in `surface`, whose
        dots are placed with the defaults.
    r_patch : float
        Radius of the patches of the roughness and of the paper's sampling, Å (default 4).
    r_zernike : float
        Radius of the patches that are described, Å (default 6).
    d_link : float
        Distance below which two dots of a patch are linked, Å (default 0.5).
    seed : int
        Seed for every random choice (default 20261120).
    roughness : str or callable
        Definition of the roughness, as in `roughness` (default 'published'). The paper's sampling follows it.
    descriptor : str or callable
        Descriptor of a patch, as in `descriptors` (default 'published'). `compare` uses it.

    Returns
    -------
    PreparedSurface
        An object for `sample` and `compare`; its `roughness` (N,) is that of `roughness`.

    Raises
    ------
    InputError
        The surface cannot be used, is prepared already, or an argument is outside of its limits.

    Examples
    --------
    >>> import sparsurf
    >>> ready = sparsurf.prepare(sparsurf.surface("data/tdp43/topology.pdb"))
    >>> [len(sparsurf.sample(ready, n_dots=n)) for n in (100, 200)]
    [100, 200]
    """
    if isinstance(surface, PreparedSurface):
        defaults = (R_PATCH, R_ZERNIKE, D_LINK, DEFAULT_SEED, PUBLISHED, PUBLISHED)
        if (r_patch, r_zernike, d_link, seed, roughness, descriptor) != defaults:
            raise InputError(
                "prepare: this surface is prepared already; give its dots to prepare it with other settings."
            )
        return surface
    registry.load("roughness", roughness, "roughness")  # refused before dots are placed
    registry.load("descriptor", descriptor, "descriptor")
    patches = PatchesSettings(r_patch=r_patch, r_zernike=r_zernike, d_link=d_link)
    return _prepared(
        surface, patches.model_copy(update={"roughness": roughness, "descriptor": descriptor}), seed
    )


def _prepared(surface: Any, patches: PatchesSettings, seed: int = DEFAULT_SEED) -> PreparedSurface:
    """Prepare a surface, or return one that is prepared already."""
    if isinstance(surface, PreparedSurface):
        return surface
    dots = as_surface(surface, patches.d_link)
    radii = {"r_patch": patches.r_patch, "r_zernike": patches.r_zernike}
    refuse_sparse(dots.points, patches.d_link, "surface", radii=radii)
    return PreparedSurface(dots, Settings(patches=patches), None, Streams(seed), available_cores())


def _link_of(surface: PreparedLike) -> float:
    """Return the link, Å, of the dots that `surface` placed for one; the default for all others."""
    origin = surface.origin if isinstance(surface, Surface) else None
    return D_LINK if origin is None else max(D_LINK, origin.d_link)


@public(of_dots=True)
@registry.with_choices
def sample(
    surface: PreparedLike,
    *,
    percent: float | None = None,
    n_dots: int | None = None,
    sampler: SamplerLike | None = None,
    combination: Sequence[float] | None = None,
    seed: int | None = None,
) -> NDArray[np.int64]:
    """Choose a subset of dots by a sampler or by a combination of the paper's four parameters.

    Parameters
    ----------
    surface : PreparedSurface, Surface, path, pair (points, normals), or molecule
        The whole surface, as in `prepare`, or the result of `prepare`. Dots that `surface` placed for a larger `d_link` are
        sampled with that link.
    percent : float, optional
        Share of all dots, %. Exactly one of percent, n_dots and combination is given. The paper's samplers keep about the number
        that is asked for.
    n_dots : int, optional
        Number of dots.
    sampler : str or callable, optional
        How the dots are chosen (default 'farthest'). A function (prepared, n, rng) that returns the indices (n,) of dots, or a
        name given to `register`, may take the place of these names:

        {choices of sampler}
    combination : (alpha, beta, gamma, delta), optional
        Parameters of one draw of the paper's sampling, equation 2 of the preprint by Grassmann et al., published in PLoS ONE
        17(4), e0266004 (2022), or of the sampler 'paper_corrected'.
    seed : int, optional
        Seed of the draw (default that of the prepared surface, or 20261120). `minimal` and a study choose the same dots with it.

    Returns
    -------
    (n,) int64
        Indices of the kept dots. The first m dots of a nested sampler, such as 'farthest' or 'uniform', are its subset of m dots.

    Raises
    ------
    InputError
        No size or several sizes are given, the surface has fewer dots, or a parameter is outside of its limits.

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> len(sparsurf.sample(dots, percent=10)), len(sparsurf.sample(dots, combination=(1, 0, 6, 0)))
    (2460, 11344)
    """
    prepared = _prepared(surface, PatchesSettings(d_link=_link_of(surface)))
    if seed is not None:
        prepared = prepared.with_streams(replace(prepared.stream, seed=seed))
    sizes = [name for name, value in (("percent", percent), ("n_dots", n_dots)) if value is not None]
    if combination is not None:
        kept = _draw_combination(prepared, combination, sampler, sizes)
    else:
        if len(sizes) != 1:
            raise InputError("sample: give either percent or n_dots, such as percent=10.")
        sampler, n = "farthest" if sampler is None else sampler, len(prepared.points)
        if percent is not None:
            n_dots = max(1, round(percent / 100 * n))
        n_dots = Limits(1, n, whole=True, open_low=False).check(n_dots, "n_dots")
        get_samplers([sampler], "sampler")  # names an unknown one
        kept = draw_subset(prepared, sampler, n_dots)
    warn_of_gaps("sample", prepared, kept)
    return kept


def warn_of_gaps(name: str, prepared: PreparedSurface, kept: np.ndarray) -> None:
    """Warn if the surface that is reconstructed from the kept dots deviates too far from the full one."""
    if len(kept) == len(prepared) or len(kept) > DENSITY_WITHOUT_GAPS * prepared.area:
        return
    few = prepared.surface.take(kept)
    distances = distance_to_recovered(prepared.points, few.points, few.normals, available_cores())
    far = np.quantile(kept_out(distances, kept), TAIL_QUANTILE)
    if far > MAX_SUBSET_GAP:
        log.warning(
            "%s: %s too few to reconstruct the surface: 1 %% of it deviates by %.1f Å or more; "
            "keep more", name, pluralise(len(kept), "dot", "is"), far,
        )  # fmt: skip


def _draw_combination(
    prepared: PreparedSurface, combination: Sequence[float], sampler: SamplerLike | None, sizes: list[str]
) -> np.ndarray:
    """Return one draw of the paper's sampling by a combination."""
    if sizes:
        raise InputError(
            f"sample: a combination leaves the number of dots to chance; leave out {sizes[0]} or the combination."
        )
    samplers = registry.samplers_of_combinations()
    if sampler is not None and sampler not in samplers:
        names = " and ".join(samplers)
        raise InputError(f"sample: {names} draw by a combination, not {sampler!r}; leave out one of the two.")
    sampler = sampler or samplers[0]
    return find_subset(prepared, sampler, combination=_combination(combination))


@public(of_dots=True)
@registry.with_choices
def compare(
    surface: PreparedLike,
    subsets: ArrayLike | Subset | Mapping[str, ArrayLike | Subset],
    *,
    reading: ReadingLike = "full",
    test_dots: int | str = DEFAULT_TEST_DOTS,
) -> pd.DataFrame:
    """Compare the descriptors of subsets with those of the whole surface, beside random subsets of the same sizes.

    Parameters
    ----------
    surface : PreparedSurface, Surface, path, pair (points, normals), or molecule
        The whole surface, as in `prepare`, or the result of `prepare`.
    subsets : (n,) int, (N,) bool, Subset, or dict of these by name
        Kept dots: their indices, a mask of all N dots, or a Subset from `minimal` of the same dots. The names of a dict
        become the index of the table.
    reading : str or callable
        From which dots the patches of a subset are cut (default 'full'). A function (points, normals, d_link, area, density)
        that returns the PatchIndex of a surface of the kept dots may take the place of these names:

        {choices of reading}
    test_dots : int or 'published'
        Number of dots whose patches are compared (default 200), the same for all subsets; 'published' is the authors'
        choice of dots.

    Returns
    -------
    DataFrame, one row per subset
        n_S and n_S_percent; Z, the mean distance between the descriptors of a patch on the whole surface and on the subset
        (0 if they are equal), and its standard error Z_se; Z_uniform of a random subset of the same size; d = Z_uniform - Z,
        positive where the subset is better than a random one, and d_se; and two references: Z_empty of empty patches and
        Z_mean_descriptor of the mean descriptor in place of every patch. Z and d are those of Grassmann et al., PLoS ONE 17(4),
        e0266004 (2022).

    Raises
    ------
    InputError
        A subset names dots that the surface does not have, or the reading or the number of test dots is not allowed.

    Examples
    --------
    >>> import sparsurf
    >>> ready = sparsurf.prepare(sparsurf.surface("data/tdp43/topology.pdb"))
    >>> table = sparsurf.compare(ready, {"farthest": sparsurf.sample(ready, percent=10)})
    >>> table[["n_S", "Z", "Z_uniform", "d"]].round(2).to_dict("index")
    {'farthest': {'n_S': 2460, 'Z': 1.07, 'Z_uniform': 1.4, 'd': 0.33}}
    """
    prepared = _prepared(surface, PatchesSettings(d_link=_link_of(surface)))
    by_name: Mapping[str, Any] = subsets if isinstance(subsets, Mapping) else {"subset": subsets}
    if not by_name:
        raise InputError("subsets: there are none; give at least one.")
    reading_of(reading)  # names an unknown one
    n = len(prepared.points)
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
    import pandas as pd  # here: it takes long to load

    return pd.DataFrame(rows, index=pd.Index(list(by_name), name="subset"))


def _combination(values: Sequence[float]) -> Combination:
    """Return the Combination of four numbers, after a check of each."""
    try:
        combination = Combination(*values)
    except TypeError:
        raise InputError(
            f"{argument('combination')} is {values!r}; it must be the four numbers alpha, beta, gamma and delta."
        ) from None
    limits = (ALPHA, EXPONENT, EXPONENT, EXPONENT)
    checked = [
        limit.check(value, f"combination: {name}")
        for limit, value, name in zip(limits, combination, Combination._fields, strict=True)
    ]
    return Combination(*checked)
