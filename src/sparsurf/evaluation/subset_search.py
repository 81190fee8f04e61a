"""Search for the smallest subset of a surface with a requested n_S, error or Z, or the Z of a noise floor."""

import logging
from collections.abc import Mapping, Sequence

import numpy as np

from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.required_dots import Trials, required_for_error, required_to_recover
from sparsurf.evaluation.statistics import estimate
from sparsurf.patches.readings import FULL_READING
from sparsurf.sampling.combination import PUBLISHED_CHOICES, Choices
from sparsurf.sampling.samplers import get_samplers, subset_weights

log = logging.getLogger("sparsurf")

MAX_DIFFERENCE = 0.1  # warn if the number of dots differs from the request by more than this share


def find_subset(
    prepared: PreparedSurface,
    sampler: str = "farthest",
    n_s: int | None = None,
    z: float | None = None,
    combination: Sequence[float] | None = None,
    n_tests: int = 400,
    choices: Choices = PUBLISHED_CHOICES,
) -> tuple[np.ndarray, np.ndarray]:
    """Find a subset with a requested number of dots, a requested Z or a given combination, and the dots that each represents.

    `n_s` is exact except for the paper's samplers; the smallest n_S that reaches `z` under `full` is used. `combination` is one
    draw of the paper's sampling, or of paper_corrected if that is the sampler. Dots are in the order of choice.
    """
    get_samplers([sampler], "minimal.sampler", choices)  # raises if it is unknown
    n_dots = len(prepared.points)
    if combination is not None:
        if sampler == "paper_corrected":
            prepared = prepared.changed(cover=prepared.corrected_cover)
        subset = prepared.pair(combination, 0)[0]
    elif z is not None:
        if not z >= 0:
            raise InputError(f"minimal.max_z is {z:g}, but a distance cannot be negative.")
        subset = _smallest_for_z(z, Trials(prepared, sampler, n_tests, choices))
    else:
        if n_s is None or not 1 <= n_s <= n_dots:
            raise InputError(
                f"minimal.n_dots is {n_s}, but {prepared.name} has {n_dots} dots; give 1 to {n_dots}, or percent."
            )
        subset = draw_subset(prepared, sampler, n_s, choices)
    return subset, subset_weights(prepared.points, subset)


def draw_subset(
    prepared: PreparedSurface, sampler: str, n_s: int, choices: Choices = PUBLISHED_CHOICES
) -> np.ndarray:
    """Draw about `n_s` dots with a sampler, from the random stream of the minimal subset; warn if the number differs."""
    function = get_samplers([sampler], "minimal.sampler", choices)[sampler]
    subset = function(prepared, n_s, prepared.stream("minimal", sampler))
    warn_if_number_differs(sampler, n_s, len(subset))
    return subset


def warn_if_number_differs(sampler: str, requested: int, n: int) -> None:
    """Warn if the number of dots differs from the request by more than a tenth."""
    if abs(n - requested) > MAX_DIFFERENCE * requested:
        log.warning(
            "%s keeps %d dots instead of %d: its number of dots is random, and limited by its combinations",
            sampler, n, requested,
        )  # fmt: skip


def _smallest_for_z(z: float, trials: Trials) -> np.ndarray:
    """Find the smallest subset whose Z under `full` is at most z."""
    name, all_dots = trials.prepared.name, trials.draw(trials.n_dots)
    least = trials.distances([all_dots], FULL_READING).mean()
    if least > z + 1e-9:  # Z of the full surface is 0 except for rounding
        raise InputError(
            f"minimal.max_z is {z:g}, but {trials.sampler} reaches only {least:.3g} with the {len(all_dots)} dots that it can "
            "keep; request a larger Z, or choose a sampler that can keep every dot."
        )
    subset = _search(trials, z)
    reached = estimate(trials.distances([subset], FULL_READING))
    log.info(
        "%s: %s reaches Z = %.3f (95 %%: %.3f to %.3f) with %d of %d dots",
        name, trials.sampler, reached.mean, reached.low, reached.high, len(subset), trials.n_dots,
    )  # fmt: skip
    return subset


def smallest_recovered_subset(
    trials: Trials, floors: Mapping[str, np.ndarray], floor: str
) -> tuple[np.ndarray, tuple[float, float] | None]:
    """Find the smallest subset recovered with a Z within a fifth of a floor: dots in order, the interval of their number."""
    name = trials.prepared.name
    if floor not in floors:
        raise InputError(
            f"minimal.floor is {floor!r}, but {name} only has {', '.join(floors)}; choose one of these."
        )
    required = required_to_recover(trials, floors[floor])
    interval = (required.low, required.high) if np.isfinite(required.low) else None
    subset = trials.draw(required.n_s)
    log.info(
        "%s: recovered from %d of %d dots by %s%s, Z is within a fifth of the floor '%s', %.3f",
        name, len(subset), trials.n_dots, trials.sampler,
        f" (95 %: {interval[0]:.0f} to {interval[1]:.0f})" if interval else "", floor, floors[floor].mean(),
    )  # fmt: skip
    return subset, interval


def smallest_subset_of_error(trials: Trials, error: float) -> tuple[np.ndarray, tuple[float, float] | None]:
    """Find the smallest subset recovered `error` Å off on average: dots in order, and the interval of their number, or None."""
    required = required_for_error(trials, error)
    interval = (required.low, required.high) if np.isfinite(required.low) else None
    subset = trials.draw(required.n_s)
    log.info(
        "%s: recovered from %d of %d dots by %s%s, the surface is %g Å off on average",
        trials.prepared.name, len(subset), trials.n_dots, trials.sampler,
        f" (95 %: {interval[0]:.0f} to {interval[1]:.0f})" if interval else "", error,
    )  # fmt: skip
    return subset, interval


def _search(trials: Trials, limit: float) -> np.ndarray:
    """Find the smallest subset whose Z under `full` is at most `limit`, by bisection below the first size that is enough."""
    first = trials.first_size(FULL_READING, limit)
    too_few, enough = [0, *map(int, trials.sizes), trials.n_dots][first : first + 2]
    while enough - too_few > 1:
        middle = (too_few + enough) // 2
        reached = trials.measured([middle], FULL_READING)[1][0] <= limit
        too_few, enough = (too_few, middle) if reached else (middle, enough)
    return trials.draw(enough)
