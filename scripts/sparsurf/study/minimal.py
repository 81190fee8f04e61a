"""The subset of a surface that is handed out, for a wished n_S or a wished Z."""

import logging

import numpy as np

from sparsurf import InputError
from sparsurf.patches.readings import TEXT
from sparsurf.sampling.published import OF_PAPER
from sparsurf.sampling.samplers import named, weights
from sparsurf.study.statistics import estimate

log = logging.getLogger("sparsurf")

OTHERWISE = 0.1  # share of the wished number of dots by which one differs that is told
STEPS = 16  # sizes that are tried in each round of the search


def minimal_subset(
    evaluator, sampler="farthest", n_s=None, z=None, combination=None, n_tests=400, choices=OF_PAPER
):
    """The subset that is handed out.

    Parameters
    ----------
    evaluator : Evaluator
    sampler : str
        A name of `samplers.SAMPLERS`.
    n_s : int, optional
        Wished number of dots; exact but for the paper's sampler.
    z : float, optional
        Wished Z under `surface`: the smallest n_S that reaches it is sought, on the test dots of the study.
    combination : sequence of 4 floats, optional
        One draw of the paper's sampling with this combination, of paper_corrected where that is the sampler.
    choices : published.Choices
        What the paper's sampler takes its parameters from.

    Returns
    -------
    (n,) int64 dots, in the order of choice, and (n,) int64 weights, the number of dots each stands for.

    Raises
    ------
    InputError : an unknown sampler, more dots than there are, a Z that cannot be reached
    """
    function = named([sampler], "minimal.sampler", choices)[sampler]
    n_dots = len(evaluator.points)
    if combination is not None:
        if sampler == "paper_corrected":
            evaluator = evaluator.changed(cover=evaluator.corrected_cover)
        kept = evaluator.pair(combination, 0)[0]
        return kept, weights(evaluator.points, kept)

    def draw(n):
        return function(evaluator, n, evaluator.stream("minimal", sampler))

    if z is None:
        if not 1 <= n_s <= n_dots:
            raise InputError(
                f"minimal.n_S is {n_s}, but {evaluator.name} has {n_dots} dots; give 1 to {n_dots}, or n_S_percent."
            )
        kept = draw(n_s)
        tell_of_another_number(sampler, n_s, len(kept))
    else:
        if not z >= 0:
            raise InputError(f"minimal.Z is {z:g}, but a distance cannot be negative.")
        if function.nested:  # one draw holds all of them
            longest = draw(n_dots)
            draw = lambda n: longest[:n]  # noqa: E731
        kept = _smallest(evaluator, sampler, draw, z, n_tests)
    return kept, weights(evaluator.points, kept)


def tell_of_another_number(sampler, wished, n):
    """Warn where a sampler keeps clearly more or fewer dots than are wished."""
    if abs(n - wished) > OTHERWISE * wished:
        log.warning(
            "%s keeps %d dots instead of %d: its combinations leave the number to chance, within what they can give",
            sampler, n, wished,
        )  # fmt: skip


def _smallest(evaluator, sampler, draw, z, n_tests):
    """The smallest subset whose Z is at most z: the first of a row of sizes that reaches it, then between
    that and the one before, until they are neighbours."""
    tests = evaluator.draw_tests(n_tests)
    z_tot, _ = evaluator.describe(tests)

    def reached(subsets):
        return evaluator.distances(subsets, tests, z_tot, TEXT)[0]

    low, high, best = 0, len(evaluator.points), draw(len(evaluator.points))
    distances = reached([best])
    if distances.mean() > z + 1e-9:  # of the whole surface it is 0 but for rounding
        raise InputError(
            f"minimal.Z is {z:g}, but {sampler} comes down to {distances.mean():.3g} only, with all the "
            f"{len(best)} dots that it can keep; wish for more, or choose a sampler that can keep every dot."
        )
    while high - low > 1:
        sizes = np.unique(np.geomspace(low + 1, high, STEPS).round().astype(int))[:-1]
        subsets = [draw(int(n)) for n in sizes]
        found = reached(subsets)
        first = np.flatnonzero(found.mean(axis=1) <= z)[:1]
        if len(first):
            k = int(first[0])
            low, high = (int(sizes[k - 1]) if k else low), int(sizes[k])
            best, distances = subsets[k], found[k : k + 1]
        else:
            low = int(sizes[-1])
    value = estimate(distances)
    log.info(
        "%s: %s reaches Z = %.3f (95 %%: %.3f to %.3f) with %d of %d dots",
        evaluator.name, sampler, value.mean, value.low, value.high, len(best), len(evaluator.points),
    )  # fmt: skip
    return best
