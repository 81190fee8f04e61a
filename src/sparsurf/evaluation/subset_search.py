"""Search for the smallest subset of a surface with a requested n_S, density, error or Z."""

import logging
import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from sparsurf import registry
from sparsurf.errors import InputError, argument
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import CONFIDENCE_LEVEL, estimate
from sparsurf.evaluation.trials import MIN_RECONSTRUCTED_DOTS, MeasuredError, Trials
from sparsurf.progress import tell
from sparsurf.recovery.law import start_density
from sparsurf.recovery.reconstructing import MIN_SHARE
from sparsurf.recovery.spheres.votes import MIN_DOTS
from sparsurf.sampling.combination import PUBLISHED_CHOICES, Choices
from sparsurf.sampling.samplers import SamplerLike, get_samplers
from sparsurf.settings import BY_ALL, BY_FEWEST, BY_MEAN

log = logging.getLogger("sparsurf")

# n_S that are tried for a requested Z, % of the dots
SEARCHED_PERCENTS = (1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 70, 80, 90)
NEAR = 0.02  # the search for an error ends once the logarithm of a measured one is so near
MOST_MEASUREMENTS = 8  # two or three are enough for evenly spread dots
STEEPEST, FLATTEST = -3.0, -0.3  # slope of the logarithm of the error over that of n_S
# Of the surface of dots that determine their atoms: one is enough for nine of ten structures, two for nearly all others
MOST_RECONSTRUCTIONS = 4
MAX_DIFFERENCE = 0.1  # warn if the number of dots differs from the request by more than this share


class Found(NamedTuple):
    """The smallest subset of an error: its dots in order, the 95 % interval of their number, and what decided the number."""

    dots: np.ndarray
    interval: tuple[float, float] | None
    decided_by: str  # a key of settings.DECISIONS


def find_subset(
    prepared: PreparedSurface,
    sampler: SamplerLike = "farthest",
    n_s: int | None = None,
    z: float | None = None,
    combination: Sequence[float] | None = None,
    n_tests: int = 400,
    choices: Choices = PUBLISHED_CHOICES,
) -> np.ndarray:
    """Find a subset with a requested number of dots, a requested Z or a given combination.

    `n_s` is exact except for the paper's samplers; the smallest n_S that reaches `z` under `full` is used. `combination` is one
    draw of the paper's sampling, or of paper_corrected if that is the sampler. Dots are in the order of choice.
    """
    get_samplers([sampler], "minimal.sampler", choices)  # raises if it cannot be used
    n_dots = len(prepared.points)
    if combination is not None:
        if sampler == "paper_corrected":
            prepared = prepared.with_cover(prepared.corrected_cover)
        return prepared.pair(combination, 0)[0]
    if z is not None:
        if not z >= 0:
            raise InputError(f"{argument('minimal.max_z')} is {z:g}, but a distance cannot be negative.")
        return _smallest_for_z(z, Trials(prepared, sampler, n_tests, choices))
    if n_s is None or not 1 <= n_s <= n_dots:
        raise InputError(
            f"{argument('minimal.n_dots')} is {n_s}, but {prepared.name} has {n_dots} dots; give 1 to {n_dots}, "
            f"or {argument('minimal.percent')}."
        )
    return draw_subset(prepared, sampler, n_s, choices)


def draw_subset(
    prepared: PreparedSurface, sampler: SamplerLike, n_s: int, choices: Choices = PUBLISHED_CHOICES
) -> np.ndarray:
    """Draw about `n_s` dots with a sampler, from the random stream of the minimal subset; warn if the number differs."""
    ((name, function),) = get_samplers([sampler], "minimal.sampler", choices).items()
    subset = function(prepared, n_s, prepared.stream("minimal", name))
    warn_if_number_differs(name, n_s, len(subset))
    return subset


def warn_if_number_differs(sampler: str, requested: int, n: int) -> None:
    """Warn if the number of dots differs from the request by more than a tenth."""
    if abs(n - requested) > MAX_DIFFERENCE * requested:
        is_random = sampler in registry.samplers_of_combinations()
        reason = ": its number of dots is random, and limited by its combinations" if is_random else ""
        log.warning("%s keeps %d dots instead of %d%s", sampler, n, requested, reason)


def _smallest_for_z(z: float, trials: Trials) -> np.ndarray:
    """Find the smallest subset whose Z under `full` is at most z."""
    name, all_dots = trials.prepared.name, trials.draw(trials.n_dots)
    least = trials.z(trials.n_dots)
    if least > z + 1e-9:  # Z of the full surface is 0 except for rounding
        raise InputError(
            f"{argument('minimal.max_z')} is {z:g}, but {trials.sampler} reaches only {least:.3g} with the "
            f"{len(all_dots)} dots that it can "
            "keep; request a larger Z, or choose a sampler that can keep every dot."
        )
    subset = trials.draw(_fewest(trials, z))
    reached = estimate(trials.distances(subset)[None])
    log.info(
        "%s: %s reaches Z = %.3f (95 %%: %.3f to %.3f) with %d of %d dots",
        name, trials.sampler, reached.mean, reached.low, reached.high, len(subset), trials.n_dots,
    )  # fmt: skip
    return subset


def _fewest(trials: Trials, limit: float) -> int:
    """Find the smallest n_S with a Z of at most `limit`, by bisection below the first of `SEARCHED_PERCENTS` that is enough."""
    sizes = np.round(np.array(SEARCHED_PERCENTS) / 100 * trials.n_dots).astype(int)
    too_few = 0
    for sufficient in (
        *map(int, np.unique(sizes.clip(min(MIN_RECONSTRUCTED_DOTS, trials.n_dots)))),
        trials.n_dots,
    ):
        if trials.z(sufficient) <= limit:
            break
        too_few = sufficient
    while sufficient - too_few > 1:
        middle = (too_few + sufficient) // 2
        too_few, sufficient = (too_few, middle) if trials.z(middle) <= limit else (middle, sufficient)
    return sufficient


def smallest_subset_of_error(
    trials: Trials, error: float, hydrogens: bool, error_99: float | None = None
) -> Found:
    """Find the smallest subset from which the surface is reconstructed with a mean `error`, Å, and the interval of its size.

    With `error_99`, Å, 99 % of the surface also deviates by at most as much.

    The search starts where the law of `recovery.law` has that error, and follows straight lines through the logarithms of the
    numbers of dots and of the errors that it measures. The interval follows from the standard error of the measured error; it
    is None where the smallest number that is tried is enough, or no number is.
    """
    name, sampler, n_dots = trials.prepared.name, trials.sampler, trials.n_dots
    fewest = min(MIN_RECONSTRUCTED_DOTS, n_dots)
    n, slope = _clip(trials.prepared.area * start_density(error, hydrogens), fewest, n_dots), -1.0
    tried: dict[int, MeasuredError] = {}
    while n not in tried and len(tried) < MOST_MEASUREMENTS:
        tell(
            f"measuring the error of {n:,} of {n_dots:,} dots, number {len(tried) + 1} of at most {MOST_MEASUREMENTS}"
        )
        tried[n] = trials.error(n)
        if n == n_dots:
            break
        over = {m: found.over(error, error_99) for m, found in tried.items()}
        nearest = sorted(tried, key=lambda m: (abs(math.log(over[m])), m))[:2]
        start = tried[nearest[0]]
        if len(nearest) == 2:
            rise = math.log(over[nearest[1]] / over[nearest[0]])
            slope = min(max(rise / math.log(nearest[1] / nearest[0]), STEEPEST), FLATTEST)
        n = _clip(nearest[0] * over[nearest[0]] ** (-1 / slope), fewest, n_dots)
        if abs(math.log(over[nearest[0]])) <= NEAR:
            break
    interval = None
    if fewest < n < n_dots:
        factor = math.exp(NormalDist().inv_cdf((1 + CONFIDENCE_LEVEL) / 2) * start.log_error / -slope)
        interval = max(n / factor, fewest), min(n * factor, n_dots)
    subset = trials.draw(n)
    log.info(
        "%s: reconstructed from %d of %d dots by %s%s, the surface deviates by %g Å on average",
        name, len(subset), n_dots, sampler,
        f" (95 %: {interval[0]:.0f} to {interval[1]:.0f})" if interval else "", error,
    )  # fmt: skip
    decided_by = BY_ALL if n == n_dots else BY_FEWEST if n == fewest else start.decided_by(error, error_99)
    return Found(subset, interval, decided_by)


def smallest_cover(trials: Trials, error: float, error_99: float) -> Found | None:
    """Find few dots that determine their atoms, and whose reconstructed surface has a mean and a 99 % error, Å.

    The 99 % error bounds the distances of the true surface from the reconstructed one and those of the reconstructed surface from
    the true one, so that no part is missing and none is invented. It is not bounded, and nothing is measured, if it is infinite.
    The dots are chosen by predicted errors, and then the surface is reconstructed and measured once; where it exceeds an error,
    dots are added where it does. The result is None where the dots do not determine their spheres, or do not reach the errors.
    """
    cover, chosen = trials.cover, trials.cover.for_error(error, error_99)
    if len(chosen) < MIN_DOTS:
        return None
    if math.isinf(error_99):
        return Found(chosen, None, BY_MEAN)
    for k in range(1, MOST_RECONSTRUCTIONS + 1):
        tell(f"measuring the error of {len(chosen):,} dots, number {k} of at most {MOST_RECONSTRUCTIONS}")
        if trials.reconstructed(chosen).share < MIN_SHARE:
            return None
        measured = trials.error_of(chosen)
        if measured.over(error, error_99) <= 1:
            return Found(chosen, None, measured.decided_by(error, error_99))
        errors = trials.errors_around(chosen)
        is_tail = measured.decided_by(error, error_99) != BY_MEAN
        weight = trials.prepared.surface.area * (errors > error_99 if is_tail else errors)
        chosen = np.concatenate([chosen, cover.to_add(chosen, errors, weight, 0.5 * weight.sum())])
    return None


def _clip(n: float, fewest: int, largest: int) -> int:
    """Round a number of dots up, and keep it between `fewest` and `largest`."""
    return int(np.clip(math.ceil(n - 1e-6), fewest, largest))
