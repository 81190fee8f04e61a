"""Search for the smallest subset of a surface with a requested n_S, a requested Z, or the Z of a noise floor."""

import logging
from collections.abc import Sequence

import numpy as np
import pandas as pd

from sparsurf import InputError, progress
from sparsurf.patches.readings import WRITTEN_READING
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling.combination import PUBLISHED_CHOICES, Choices
from sparsurf.sampling.samplers import get_samplers, subset_weights
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.required_dots import FLOOR_FACTOR, MIN_DOTS, Trials
from sparsurf.study.statistics import estimate

log = logging.getLogger("sparsurf")

MAX_DIFFERENCE = 0.1  # warn if the number of dots differs from the request by more than this share
HALVINGS = 3  # of the step between two n_S of the curve; each recovers a surface


def find_subset(
    prepared: PreparedSurface,
    sampler: str = "farthest",
    n_s: int | None = None,
    z: float | None = None,
    combination: Sequence[float] | None = None,
    n_tests: int = 400,
    choices: Choices = PUBLISHED_CHOICES,
) -> tuple[np.ndarray, np.ndarray]:
    """Find the subset for a number of dots, a Z or a combination; give one of them.

    Parameters
    ----------
    prepared : PreparedSurface
    sampler : str
        A name in `samplers.SAMPLERS`.
    n_s : int, optional
        Requested number of dots; exact except for the paper's samplers.
    z : float, optional
        Requested Z under `as_written`: the smallest n_S that reaches it at the test dots of the study.
    combination : sequence of 4 floats, optional
        One draw of the paper's sampling with this combination, or of paper_corrected if that is the sampler.
    n_tests : int
    choices : combination.Choices
        Combinations from which the paper's samplers take their parameters.

    Returns
    -------
    (n,) int64 dots, in the order of choice, and (n,) int64 weights, the number of dots that each represents.

    Raises
    ------
    InputError
        If the sampler is unknown, n_S exceeds N, or Z cannot be reached.
    """
    get_samplers([sampler], "minimal.sampler", choices)  # names an unknown one
    n_dots = len(prepared.points)
    if combination is not None:
        if sampler == "paper_corrected":
            prepared = prepared.changed(cover=prepared.corrected_cover)
        subset = prepared.pair(combination, 0)[0]
    elif z is not None:
        if not z >= 0:
            raise InputError(f"minimal.Z is {z:g}, but a distance cannot be negative.")
        subset = _smallest_for_z(z, Trials(prepared, sampler, n_tests, choices))
    else:
        if n_s is None or not 1 <= n_s <= n_dots:
            raise InputError(
                f"minimal.n_S is {n_s}, but {prepared.name} has {n_dots} dots; give 1 to {n_dots}, or n_S_percent."
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
            "%s keeps %d dots instead of %d: its combinations leave the number to chance, within what they can give",
            sampler, n, requested,
        )  # fmt: skip


def _smallest_for_z(z: float, trials: Trials) -> np.ndarray:
    """Find the smallest subset whose Z as written is at most z."""
    name, all_dots = trials.prepared.name, trials.draw(trials.n_dots)
    least = trials.distances([all_dots], WRITTEN_READING).mean()
    if least > z + 1e-9:  # Z of the full surface is 0 except for rounding
        raise InputError(
            f"minimal.Z is {z:g}, but {trials.sampler} reaches only {least:.3g}, with all the "
            f"{len(all_dots)} dots that it can keep; request a larger Z, or choose a sampler that can keep every dot."
        )
    subset = search_smallest_subset(trials, WRITTEN_READING, z, 0, trials.n_dots)
    reached = estimate(trials.distances([subset], WRITTEN_READING))
    log.info(
        "%s: %s reaches Z = %.3f (95 %%: %.3f to %.3f) with %d of %d dots",
        name, trials.sampler, reached.mean, reached.low, reached.high, len(subset), trials.n_dots,
    )  # fmt: skip
    return subset


def smallest_recovered_subset(trials: Trials, floors: pd.DataFrame, floor: str) -> np.ndarray:
    """Find the smallest subset whose recovered Z comes within a tenth of a noise floor.

    Parameters
    ----------
    trials : Trials
    floors : DataFrame, of `floors.noise_floors`
    floor : str, a row of `floors`

    Returns
    -------
    (n,) int64 dots, in the order of choice.

    Raises
    ------
    InputError
        If this surface lacks the floor.
    """
    name = trials.prepared.name
    if floor not in set(floors["floor"]):
        raise InputError(
            f"minimal.floor is {floor!r}, but {name} has {', '.join(floors['floor'])} only; name one of them."
        )
    limit = float(floors.loc[floors["floor"] == floor, "Z"].iloc[0])
    subset = search_smallest_subset(trials, RECOVERED, FLOOR_FACTOR * limit, MIN_DOTS, HALVINGS)
    log.info(
        "%s: recovered from %d of %d dots of %s, Z is that of %s, %.3f, within a tenth",
        name, len(subset), trials.n_dots, trials.sampler, floor, limit,
    )  # fmt: skip
    return subset


def search_smallest_subset(
    trials: Trials, reading: str, limit: float, too_few: int, halvings: int
) -> np.ndarray:
    """Find the smallest subset whose Z is at most `limit`.

    The search takes the first n_S of the curve that reaches it, then halves the step before it. If no n_S of the curve is
    enough, the step is that from the largest to all dots.

    Parameters
    ----------
    trials : Trials
    reading : str
    limit : float, Z
    too_few : int
        A number of dots that is not tried.
    halvings : int
        Maximum number of halvings.

    Returns
    -------
    (n,) int64 dots
    """
    sizes = [too_few, *map(int, trials.sizes), trials.n_dots]
    first = _first_size(trials, reading, limit)
    low, high = sizes[first], sizes[first + 1]
    for _ in range(halvings):
        middle = (low + high) // 2
        if not low < middle < high:
            break
        reached = trials.measured([middle], reading)[1][0] <= limit
        low, high = (low, middle) if reached else (middle, high)
    return trials.draw(high)


def _first_size(trials: Trials, reading: str, limit: float) -> int:
    """Return the index in `trials.sizes` of the first whose Z is at most `limit`, or their number if there is none.

    Sizes are measured in blocks of as many as there are threads, and only until one is enough.
    """
    sizes, threads = trials.sizes, trials.prepared.threads
    for a in progress.progress_bar(range(0, len(sizes), threads), "trying numbers of dots"):
        reached = trials.measured(sizes[a : a + threads], reading)[1] <= limit
        if reached.any():
            return a + int(np.argmax(reached))
    return len(sizes)
