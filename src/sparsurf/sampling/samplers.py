"""Samplers with one interface: (prepared surface, n, rng) -> n dots in the order of choice.

`registry` lists them. Every sampler of the library keeps exactly n dots, except those of the paper, whose n_S is random.
"""

from collections.abc import Callable, Iterable
from functools import partial
from typing import NamedTuple

import numpy as np

from sparsurf import registry
from sparsurf.errors import InputError
from sparsurf.patches.index import select_separated
from sparsurf.sampling import published
from sparsurf.sampling.combination import PUBLISHED_CHOICES, Choices
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.sampling.published import SampledSurface
from sparsurf.surfaces.chosen_points import on_steps
from sparsurf.surfaces.grid import nearest_of

MAX_SURPLUS = 0.005  # largest accepted share of dots above n; the surplus is discarded at random


SamplerLike = str | Callable[..., np.ndarray]


class Sampler(NamedTuple):
    """A sampler, called like its function.

    Attributes
    ----------
    function : (prepared, n, rng) -> (n,) int64 dots
    nested : bool, whether smaller subsets are the beginnings of larger ones (from the same random stream)
    """

    function: Callable[..., np.ndarray]
    nested: bool = False

    def __call__(self, prepared: SampledSurface, n: int, rng: np.random.Generator) -> np.ndarray:
        return self.function(prepared, n, rng)


def sampler_label(name: str) -> str:
    """Return how figures and pages call a sampler of a table; the name itself if it is not registered."""
    return registry.label("sampler", name)


def get_samplers(
    values: Iterable[SamplerLike], key: str, choices: Choices = PUBLISHED_CHOICES
) -> dict[str, Sampler]:
    """Return the samplers of names or functions, by name; an error names the config `key` that gives them."""
    samplers = {}
    for value in values:
        choice, function = registry.load("sampler", value, key)
        if choice.takes_combinations:
            function = partial(function, choices=choices)
        elif not choice.is_built_in:
            function = partial(_checked, function, choice.name)
        samplers[choice.name] = Sampler(function, choice.nested)
    return samplers


def get_sampler(value: SamplerLike) -> Sampler:
    """Return the sampler of a name or function."""
    return next(iter(get_samplers([value], "sampler").values()))


def _checked(
    function: Callable[..., np.ndarray],
    name: str,
    prepared: SampledSurface,
    n: int,
    rng: np.random.Generator,
) -> np.ndarray:
    """Call a sampler of the user; raise InputError, which names it, unless it returns dots of the surface, each once."""
    try:
        returned, n_dots = function(prepared, n, rng), len(prepared.points)
    except InputError as error:
        if str(error).startswith("the sampler "):  # it says which one already
            raise
        raise InputError(f"the sampler {name!r}: {error}") from error
    dots = np.asarray(returned) if np.iterable(returned) else np.empty((0, 0))
    if dots.ndim != 1 or dots.dtype.kind not in "iu" or not len(dots):
        described = (
            f"an array of {dots.dtype} and shape {dots.shape}"
            if dots.size
            else f"a {type(returned).__name__}"
        )
        raise InputError(
            f"the sampler {name!r} returns {described}; it must return the indices (n,) of dots."
        )
    if not 0 <= dots.min() <= dots.max() < n_dots:
        raise InputError(
            f"the sampler {name!r} returns indices from {dots.min()} to {dots.max()}; it must return indices of dots, from 0 to "
            f"{n_dots - 1}."
        )
    if n_repeated := len(dots) - len(np.unique(dots)):
        raise InputError(
            f"the sampler {name!r} returns {len(dots)} dots, of which {n_repeated} repeat another; it must return each dot once."
        )
    return dots.astype(np.int64)


def paper(
    prepared: SampledSurface, n: int, rng: np.random.Generator, choices: Choices = PUBLISHED_CHOICES
) -> np.ndarray:
    """Sample by roughness with the combination that the paper's criterion d chose for this range of n_S, which is random.

    alpha is set so that the expected n_S is n. If even alpha = 1 keeps fewer dots, the next range's combination is used.
    """
    return _sample_about(prepared.cover, choices, n, rng)


def paper_corrected(
    prepared: SampledSurface, n: int, rng: np.random.Generator, choices: Choices = PUBLISHED_CHOICES
) -> np.ndarray:
    """Sample like `paper`, with distances from the dot itself and one chance per dot."""
    return _sample_about(prepared.corrected_cover, choices, n, rng)


def _sample_about(cover: published.Cover, choices: Choices, n: int, rng: np.random.Generator) -> np.ndarray:
    """Draw about n dots with the first combination that can keep n."""
    rows = choices.from_n_s(100 * n / cover.n_dots)
    expected = published.expected_n_s(cover, [(1.0, *row[1:]) for row in rows])
    # alpha = 1 keeps the most, so that a combination that keeps too few with it cannot keep n
    row = rows[int(np.argmax(expected >= n)) if (expected >= n).any() else int(np.argmax(expected))]
    return published.sample_cover(cover, tune_alpha(cover, row, n), rng)


def tune_alpha(cover: published.Cover, combination: Iterable[float], n: float) -> tuple[float, ...]:
    """Return `combination` with the alpha in (0, 1] whose expected n_S is nearest to n; n_S grows with alpha."""
    _, *exponents = combination
    low, high = 0.0, 1.0
    # Halved until no digit of n_S depends on it
    for _ in range(40):
        middle = (low + high) / 2
        too_few = published.expected_n_s(cover, [(middle, *exponents)])[0] < n
        low, high = (middle, high) if too_few else (low, middle)
    # The upper end, which keeps n dots or more wherever any alpha does
    return (high, *exponents)


def uniform(prepared: SampledSurface, n: int, rng: np.random.Generator) -> np.ndarray:
    """Draw n dots at random; every subset of n dots is equally likely."""
    return rng.permutation(len(prepared.points))[:n]


def poisson(prepared: SampledSurface, n: int, rng: np.random.Generator) -> np.ndarray:
    """Visit the dots in random order and keep those outside a radius of earlier ones, as large as n allows (Poisson disk)."""
    order = rng.permutation(len(prepared.points))
    return _at_largest_length(
        lambda radius: select_separated(prepared.index, order, radius, len(order), 0), prepared, n, rng
    )


def _at_largest_length(
    dots_at: Callable[[float], np.ndarray], prepared: SampledSurface, n: int, rng: np.random.Generator
) -> np.ndarray:
    """Return `dots_at(length)` at nearly the largest length that gives n dots, reduced to n at random."""
    low, high, best = 0.0, np.inf, np.arange(len(prepared.points))
    length = 1.0  # Å
    for _ in range(40):
        if n <= len(best) <= (1 + MAX_SURPLUS) * n:
            break
        dots = dots_at(length)
        if len(dots) >= n:
            low, best = length, dots
        else:
            high = length
        # the number of dots on a surface falls with the square of the length
        length *= np.sqrt(len(dots) / ((1 + MAX_SURPLUS / 2) * n))
        # The law may leave the bracket where dots are uneven; halving does not
        if not low < length < high:
            length = (low + high) / 2 if np.isfinite(high) else 2 * low
        if high - low < 1e-4 * low:
            break
    return rng.permutation(best)[:n]


def farthest(prepared: SampledSurface, n: int, rng: np.random.Generator) -> np.ndarray:
    """Add the dot farthest from all chosen dots, starting from a random dot (farthest-point sampling, Gonzalez 1985)."""
    return farthest_point_sampling(prepared.index, n, rng)


def weights_and_areas(
    points: np.ndarray, area: np.ndarray, subset: np.ndarray, threads: int
) -> tuple[np.ndarray, np.ndarray]:
    """Count the dots that are nearest to each kept dot, (n,) int64, and sum their areas, (n,) float64, Å^2."""
    nearest = nearest_chosen(points, subset, threads)
    return np.bincount(nearest, minlength=len(subset)), np.bincount(nearest, area, len(subset))


def nearest_chosen(points: np.ndarray, subset: np.ndarray, threads: int = 1) -> np.ndarray:
    """Find which kept dot is nearest to every dot, (N,) indices into `subset`; of equally near ones, that chosen first.

    The squares of the distances between positions on steps are exact, so that no rounding decides.
    """
    positions = on_steps(points)
    return nearest_of(positions[subset], positions, threads)[0]


def nearest_kept(points: np.ndarray, subset: np.ndarray, threads: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Find the kept dot nearest to every dot: (N,) indices into `subset`, and (N,) distances in Å."""
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    distance, nearest = cKDTree(points[subset]).query(points, workers=threads)
    return np.asarray(nearest), np.asarray(distance)
