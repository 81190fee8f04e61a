"""The subset of a surface that is handed out, for a requested n_S, a requested Z, or a noise floor."""

import logging

import numpy as np

from sparsurf import InputError, progress
from sparsurf.patches.readings import TEXT
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling.combination import PUBLISHED_CHOICES
from sparsurf.sampling.samplers import get_samplers, subset_weights
from sparsurf.study.required_dots import FLOOR_FACTOR, MIN_DOTS, Trials
from sparsurf.study.statistics import estimate

log = logging.getLogger("sparsurf")

OTHERWISE = 0.1  # warn if the number of dots differs from the request by more than this share
HALVINGS = 3  # of the step between two n_S of the curve; each recovers a surface


def find_subset(
    evaluator, sampler="farthest", n_s=None, z=None, combination=None, n_tests=400, choices=PUBLISHED_CHOICES
):
    """The subset that is handed out for a number of dots, a Z or a combination.

    Parameters
    ----------
    evaluator : Evaluator
    sampler : str
        A name of `samplers.SAMPLERS`.
    n_s : int, optional
        Requested number of dots; exact but for the paper's sampler.
    z : float, optional
        Requested Z under `as_written`: the smallest n_S that reaches it is sought, on the test dots of the study.
    combination : sequence of 4 floats, optional
        One draw of the paper's sampling with this combination, of paper_corrected where that is the sampler.
    choices : combination.Choices
        What the paper's sampler takes its parameters from.

    Returns
    -------
    (n,) int64 dots, in the order of choice, and (n,) int64 weights, the number of dots each stands for.

    Raises
    ------
    InputError : an unknown sampler, more dots than there are, a Z that cannot be reached
    """
    function, n_dots = get_samplers([sampler], "minimal.sampler", choices)[sampler], len(evaluator.points)
    if combination is not None:
        if sampler == "paper_corrected":
            evaluator = evaluator.changed(cover=evaluator.corrected_cover)
        kept = evaluator.pair(combination, 0)[0]
    elif z is None:
        if not 1 <= n_s <= n_dots:
            raise InputError(
                f"minimal.n_S is {n_s}, but {evaluator.name} has {n_dots} dots; give 1 to {n_dots}, or n_S_percent."
            )
        kept = function(evaluator, n_s, evaluator.stream("minimal", sampler))
        warn_if_number_differs(sampler, n_s, len(kept))
    else:
        if not z >= 0:
            raise InputError(f"minimal.Z is {z:g}, but a distance cannot be negative.")
        kept = _smallest_at(z, Trials(evaluator, sampler, n_tests, choices))
    return kept, subset_weights(evaluator.points, kept)


def warn_if_number_differs(sampler, requested, n):
    """Warn where a sampler keeps clearly more or fewer dots than are requested."""
    if abs(n - requested) > OTHERWISE * requested:
        log.warning(
            "%s keeps %d dots instead of %d: its combinations leave the number to chance, within what they can give",
            sampler, n, requested,
        )  # fmt: skip


def _smallest_at(z, trials):
    """The smallest subset whose Z as written is at most z."""
    name, every = trials.evaluator.name, trials.draw(trials.n_dots)
    least = trials.distances([every], TEXT).mean()
    if least > z + 1e-9:  # of the whole surface it is 0 but for rounding
        raise InputError(
            f"minimal.Z is {z:g}, but {trials.sampler} comes down to {least:.3g} only, with all the "
            f"{len(every)} dots that it can keep; asked for more, or choose a sampler that can keep every dot."
        )
    best = searched(trials, TEXT, z, 0, trials.n_dots)
    value = estimate(trials.distances([best], TEXT))
    log.info(
        "%s: %s reaches Z = %.3f (95 %%: %.3f to %.3f) with %d of %d dots",
        name, trials.sampler, value.mean, value.low, value.high, len(best), trials.n_dots,
    )  # fmt: skip
    return best


def smallest_recovered_subset(trials, floors, floor):
    """The smallest subset whose recovered Z comes near a floor.

    Parameters
    ----------
    trials : Trials
    floors : DataFrame, of `floors.floors`
    floor : str, a row of `floors`

    Returns
    -------
    (n,) int64 dots, in the order of choice.

    Raises
    ------
    InputError : a floor that this surface has not
    """
    name = trials.evaluator.name
    if floor not in set(floors["floor"]):
        raise InputError(
            f"minimal.floor is {floor!r}, but {name} has {', '.join(floors['floor'])} only; name one of them."
        )
    limit = floors.set_index("floor").loc[floor, "Z"]
    best = searched(trials, RECOVERED, FLOOR_FACTOR * limit, MIN_DOTS, HALVINGS)
    log.info(
        "%s: recovered from %d of %d dots of %s, Z is that of %s, %.3f, within a tenth",
        name, len(best), trials.n_dots, trials.sampler, floor, limit,
    )  # fmt: skip
    return best


def searched(trials, reading, limit, too_few, halvings):
    """The smallest subset whose Z is at most `limit`: the first n_S of the curve, then halves of the step before it.

    Where no n_S of the curve is enough, the step is that from the largest to all dots.

    Parameters
    ----------
    trials : Trials
    reading : str
    limit : float, Z
    too_few : int, a number of dots that is not tried
    halvings : int, at most

    Returns
    -------
    (n,) int64 dots
    """
    steps = [too_few, *map(int, trials.sizes), trials.n_dots]
    first = _first(trials, reading, limit)
    low, high = steps[first], steps[first + 1]
    for _ in range(halvings):
        middle = (low + high) // 2
        if not low < middle < high:
            break
        reached = trials.measured([middle], reading)[1][0] <= limit
        low, high = (low, middle) if reached else (middle, high)
    return trials.draw(high)


def _first(trials, reading, limit):
    """Position in `trials.sizes` of the first whose Z is at most `limit`, their number if none; the rest is not measured."""
    sizes, side_by_side = trials.sizes, trials.evaluator.threads
    for a in progress.each(range(0, len(sizes), side_by_side), "trying numbers of dots"):
        reached = trials.measured(sizes[a : a + side_by_side], reading)[1] <= limit
        if reached.any():
            return a + int(np.argmax(reached))
    return len(sizes)
