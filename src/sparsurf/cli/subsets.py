"""`prepare`, `sample` and `compare`: subsets of a surface, chosen and compared with the whole."""

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.cli.inputs import (
    ALPHA,
    EXPONENT,
    LENGTH,
    PERCENT,
    SEED,
    TEST_DOTS,
    Limits,
    as_array,
    as_surface,
)
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE
from sparsurf.recovery.readings import READINGS
from sparsurf.sampling import published
from sparsurf.sampling.combination import Combination
from sparsurf.sampling.samplers import get_samplers
from sparsurf.study.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.study.statistics import mean_and_error, reference_values
from sparsurf.study.subset_search import warn_if_number_differs
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.threads import available_cores

OF_COMBINATION = ("paper", "paper_corrected")  # samplers that draw by alpha, beta, gamma and delta


def prepare(surface, *, r_patch=R_PATCH, r_zernike=R_ZERNIKE, d_link=D_LINK, seed=0):
    """A surface made ready for `sample` and `compare`, which otherwise do this anew in every call.

    Parameters
    ----------
    surface : what `surface` or `read_surface` gave, the path of a file of dots, or the pair (points, normals)
    r_patch, r_zernike, d_link : float
        Å.
    seed : int
        Of the random streams.

    Returns
    -------
    Evaluator
        Its `roughness` is R_i of every dot.

    Examples
    --------
    >>> import sparsurf
    >>> ready = sparsurf.prepare(sparsurf.surface("data/tdp43/topology.pdb"))
    >>> [len(sparsurf.sample(ready, n=n)) for n in (100, 200)]
    [100, 200]
    """
    if isinstance(surface, PreparedSurface):
        if (r_patch, r_zernike, d_link, seed) != (R_PATCH, R_ZERNIKE, D_LINK, 0):
            raise InputError("prepare: this surface is ready; give its dots to make it ready otherwise.")
        return surface
    r_patch, r_zernike = LENGTH.check(r_patch, "r_patch"), LENGTH.check(r_zernike, "r_zernike")
    d_link, seed = LENGTH.check(d_link, "d_link"), SEED.check(seed, "seed")
    dots = as_surface(surface)
    refuse_sparse(dots.points, d_link, "surface")
    return PreparedSurface(dots, r_patch, r_zernike, d_link, seed=seed, threads=available_cores())


def sample(surface, *old, percent=None, n=None, sampler=None, combination=None, seed=0):
    """Choose dots that stand for a surface.

    Parameters
    ----------
    surface : what `prepare` takes or gave
    percent, n : float or int, one of them
        Of the dots, or their number. The paper's samplers keep about that many.
    sampler : str
        farthest, voxel, poisson, stride, uniform, roughness, centres, adaptive, paper, paper_corrected
        Without: farthest.
    combination : (alpha, beta, gamma, delta), instead of both: one draw of the paper's sampling, or of paper_corrected
    seed : int
        Another seed, another draw.

    Returns
    -------
    (n,) int64 dots; of a nested sampler (farthest, uniform, ...) the first m are its subset of m dots

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> kept = sparsurf.sample(dots, percent=10)
    >>> len(kept), dots.points[kept].shape
    (2460, (2460, 3))
    >>> len(sparsurf.sample(dots, combination=(1, 0, 6, 0)))
    11311
    """
    if old:
        raise InputError(f"sample: say percent= or n=, such as percent=10 or n=500, not {old[0]!r} alone.")
    ready, seed = prepare(surface), SEED.check(seed, "seed")
    given = [name for name, value in (("percent", percent), ("n", n)) if value is not None]
    if combination is not None:
        return _drawn(ready, combination, sampler, given, seed)
    if len(given) != 1:
        raise InputError("sample: give either percent or n, such as percent=10.")
    sampler = "farthest" if sampler is None else sampler
    n_dots = len(ready.points)
    if n is None:
        n = max(1, round(PERCENT.check(percent, "percent") / 100 * n_dots))
    n = Limits(1, n_dots, whole=True, open_low=False).check(n, "n")
    kept = get_samplers([sampler], "sampler")[sampler](ready, n, ready.stream("sample", sampler, seed))
    warn_if_number_differs(sampler, n, len(kept))
    return kept


def _drawn(ready, combination, sampler, given, seed):
    """One draw of the paper's sampling by a combination."""
    if given:
        raise InputError(
            f"sample: a combination leaves n to chance; leave out {given[0]} or the combination."
        )
    if sampler not in (None, *OF_COMBINATION):
        raise InputError(
            f"sample: {' and '.join(OF_COMBINATION)} draw by a combination, not {sampler!r}; leave out one of the two."
        )
    sampler = sampler or OF_COMBINATION[0]
    cover = ready.cover if sampler == OF_COMBINATION[0] else ready.corrected_cover
    return published.sample(cover, _combination(combination), ready.stream("sample", sampler, seed))


def compare(surface, subsets, *, reading="as_written", test_dots=400):
    """How well subsets describe a surface, beside uniform subsets of the same size.

    Parameters
    ----------
    surface : what `prepare` takes or gave
    subsets : (n,) int dots or (N,) bool, or a dict of several by name
    reading : {'as_written', 'as_coded', 'scaled', 'recovered'}
        Whether the islands of a patch are removed on the full surface or among the kept dots, these linked by their own
        spacing where 'scaled'; 'recovered': patches of the surface that the kept dots give back.
    test_dots : int or 'published'
        Dots at which the descriptors are compared, the same for all subsets.

    Returns
    -------
    DataFrame, one row per subset
        n_S, n_S_percent, Z (mean distance of the descriptors, 0 is the surface itself), Z_se, Z_uniform, d (Z_uniform
        - Z: positive where the subset is better than chance), d_se, and the references Z_empty (an empty patch)
        and Z_mean_descriptor (every patch given the mean descriptor)

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> ready = sparsurf.prepare(dots)
    >>> table = sparsurf.compare(ready, {"farthest": sparsurf.sample(ready, percent=10)})
    >>> print(table[["n_S", "Z", "Z_uniform", "d"]].round(2))
               n_S     Z  Z_uniform     d
    subset
    farthest  2460  1.01       1.28  0.28
    """
    ready = prepare(surface)
    if not isinstance(subsets, dict):
        subsets = {"subset": subsets}
    if not subsets:
        raise InputError("subsets: there are none; give one at least.")
    if reading not in list(READINGS):  # a list: what a user gives may have no hash
        raise InputError(f"reading is {reading!r}; it must be one of {', '.join(READINGS)}.")
    test_dots = TEST_DOTS.check(test_dots, "test_dots", "published")
    kept = [as_subset(name, subset, len(ready.points)) for name, subset in subsets.items()]
    tests = ready.draw_tests(number_of_tests(test_dots, len(ready.points)))
    uniform = [
        published.uniform_subset(len(ready.points), len(subset), ready.stream("compare", len(subset)))
        for subset in kept
    ]
    z_tot, _ = ready.describe(tests)
    distances, _ = ready.distances(kept + uniform, tests, z_tot, reading)
    sticks = reference_values(z_tot)
    rows = []
    for subset, own, other in zip(kept, distances, distances[len(kept) :], strict=False):
        (z, z_se), (d, d_se) = mean_and_error(own[None]), mean_and_error((other - own)[None])
        size = {"n_S": len(subset), "n_S_percent": 100 * len(subset) / len(ready.points)}
        rows.append(
            size
            | {"Z": z, "Z_se": z_se, "Z_uniform": other.mean(), "d": d, "d_se": d_se}
            | {"Z_empty": sticks["Z_empty"], "Z_mean_descriptor": sticks["Z_mean_descriptor"]}
        )
    return pd.DataFrame(rows, index=pd.Index(list(subsets), name="subset"))


def _combination(given):
    """The Combination of four numbers, after a check of each."""
    try:
        values = Combination(*given)
    except TypeError:
        raise InputError(
            f"combination is {given!r}; it must be the four numbers alpha, beta, gamma and delta."
        ) from None
    limits = (ALPHA, EXPONENT, EXPONENT, EXPONENT)
    names = [f"combination: {name}" for name in Combination._fields]
    return Combination(*(Limits.check(*each) for each in zip(limits, values, names, strict=True)))


def as_subset(name, subset, n_dots):
    """(n,) int64, after a check that they are dots of the surface, each once."""
    subset = as_array(subset, n_dots, name)
    sound = subset.ndim == 1 and subset.dtype.kind in "iu" and len(subset)
    if not (sound and subset.min() >= 0 and subset.max() < n_dots and len(np.unique(subset)) == len(subset)):
        raise InputError(f"{name}: a subset is numbers from 0 to {n_dots - 1}, each once, at least one.")
    return subset.astype(np.int64)
