"""Samplers of a surface, one interface: (evaluator, n, rng) -> n dots in the order of choice.

`evaluator` is anything with `points` (N, 3), `index`, `roughness` (N,), `cover` and
`corrected_cover` (see `evaluator.Evaluator`). To add a sampler, write one function and put
`@sampler(...)` above it, with what `Sampler` holds. All keep exactly n dots but the paper's,
whose n_S is left to chance.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from sparsurf import InputError
from sparsurf.patches.index import select_separated
from sparsurf.sampling import law
from sparsurf.sampling.combination import OF_PAPER
from sparsurf.sampling.spreading import denser_where_rough, spread

SAMPLERS = {}
HINDSIGHT = "paper_in_hindsight"  # in tables only: `paper` with the combinations that proved best
SURPLUS = 0.005  # a length that gives this share of dots too many is good enough: they are left out at random


class Sampler(NamedTuple):
    """A sampler, called like its function.

    function : (evaluator, n, rng) -> (n,) int64 dots
    words, text : str, what figures and pages call it
    nested : bool, whether its shorter subsets are the beginnings of its longer ones (from the same stream)
    choosing : bool, whether it takes the paper's `choices` as well
    """

    function: Callable
    words: str
    text: str
    nested: bool = False
    choosing: bool = False

    def __call__(self, *args, **options):
        return self.function(*args, **options)


def sampler(words="", text="", **needs):
    """Register the function below under its name, which also stands for words that are not given."""
    if callable(words):  # @sampler alone
        return sampler()(words)

    def register(function):
        name = function.__name__
        SAMPLERS[name] = Sampler(function, words or name, text or name, **needs)
        return function

    return register


def called(name):
    """Sampler with the words for a name of a table; a name that no sampler has stands for itself."""
    if name == HINDSIGHT:
        return Sampler(paper, "paper's, in hindsight", "paper (best in hindsight)", choosing=True)
    return SAMPLERS.get(name) or Sampler(None, name, name)


def named(names, key, choices=OF_PAPER):
    """Dict of the samplers called `names`; `key` is where the config gives them.

    `choices` are the combinations that the paper's samplers take, see `combination.Choices`.

    Raises
    ------
    InputError : a name that no sampler has
    """
    for name in names:
        if name not in list(SAMPLERS):  # a list: what a user gives may have no hash
            raise InputError(f"{key}: there is no sampler {name!r}; the samplers are {', '.join(SAMPLERS)}.")
    chosen = {name: SAMPLERS[name] for name in names}
    return {
        name: own._replace(function=partial(own.function, choices=choices)) if own.choosing else own
        for name, own in chosen.items()
    }


@sampler("paper's sampling", choosing=True)
def paper(evaluator, n, rng, choices=OF_PAPER):
    """The roughness-dependent sampling, with what its own criterion d chose for this range of n_S.

    alpha is set so that the expected n_S is n; where even alpha = 1 keeps fewer, the choice for the next range
    takes its place. n_S itself is left to chance.
    """
    return _paper(evaluator.cover, choices, n, rng)


@sampler("paper's, corrected", "paper (corrected)", choosing=True)
def paper_corrected(evaluator, n, rng, choices=OF_PAPER):
    """The same with distances from the dot itself and one draw per dot."""
    return _paper(evaluator.corrected_cover, choices, n, rng)


def _paper(cover, choices, n, rng):
    choices = choices.from_n_s(100 * n / cover.n_dots)
    reach = law.expected_n_s(cover, [(1.0, *choice[1:]) for choice in choices])
    choice = choices[int(np.argmax(reach >= n)) if (reach >= n).any() else int(np.argmax(reach))]
    return law.sample(cover, tune_alpha(cover, choice, n), rng)


def tune_alpha(cover, combination, n):
    """`combination` with the alpha in (0, 1] whose expected n_S is nearest to n; n_S grows with alpha."""
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = (low + high) / 2
        few = law.expected_n_s(cover, [(middle, *combination[1:])])[0] < n
        low, high = (middle, high) if few else (low, middle)
    return (high, *combination[1:])


@sampler("uniform draw", nested=True)
def uniform(evaluator, n, rng):
    """Every subset of n dots is equally likely."""
    return rng.permutation(len(evaluator.points))[:n]


@sampler("roughness-weighted", nested=True)
def roughness(evaluator, n, rng):
    """Without replacement, each draw with a chance proportional to 1 - R_i."""
    return denser_where_rough(evaluator, n, rng, 1.0, even=False)


@sampler("every k-th dot")
def stride(evaluator, n, rng):
    """Every (N / n)-th dot in the order of the surface, from a random start."""
    n_dots = len(evaluator.points)
    return (rng.integers(n_dots) + n_dots * np.arange(n)) // n


@sampler("one per voxel")
def voxel(evaluator, n, rng):
    """One dot per cubic voxel, the one nearest to the mean of its dots; grid placed at random.

    The side is as large as n voxels allow; surplus dots are left out at random.
    """
    corner = evaluator.points.min(axis=0)
    shift = rng.random(3)  # of a side
    return _longest(
        lambda side: _voxel_dots(evaluator.points - corner + shift * side, side), evaluator, n, rng
    )


def _voxel_dots(points, side):
    """One dot of each voxel; coordinates are positive."""
    a, b, c = np.floor(points / side).astype(np.int64).T
    voxel_of = (a * (b.max() + 1) + b) * (c.max() + 1) + c
    order = np.argsort(voxel_of, kind="stable")
    begin = np.flatnonzero(np.diff(voxel_of[order], prepend=-1))
    count = np.diff(begin, append=len(points))
    mean = np.add.reduceat(points[order], begin) / count[:, None]
    gap = np.sum((points[order] - np.repeat(mean, count, axis=0)) ** 2, axis=1)
    return order[np.lexsort((gap, voxel_of[order]))[begin]]


@sampler("Poisson disk")
def poisson(evaluator, n, rng):
    """Poisson disk: dots in random order, each kept unless an earlier one lies within a radius.

    The radius is as large as n dots allow; surplus dots are left out at random.
    """
    order = rng.permutation(len(evaluator.points))
    return _longest(
        lambda radius: select_separated(evaluator.index, order, radius, len(order), 0), evaluator, n, rng
    )


def _longest(dots_at, evaluator, n, rng):
    """`dots_at(length)` at nearly the largest length that gives n dots, cut to n at random."""
    low, high, best = 0.0, np.inf, np.arange(len(evaluator.points))
    length = 1.0  # Å
    for _ in range(40):
        if n <= len(best) <= (1 + SURPLUS) * n:
            break
        dots = dots_at(length)
        if len(dots) >= n:
            low, best = length, dots
        else:
            high = length
        # dots on a surface become fewer with the square of the length
        length *= np.sqrt(len(dots) / ((1 + SURPLUS / 2) * n))
        if not low < length < high:
            length = (low + high) / 2 if np.isfinite(high) else 2 * low
        if high - low < 1e-4 * low:
            break
    return rng.permutation(best)[:n]


@sampler("farthest point", nested=True)
def farthest(evaluator, n, rng):
    """Farthest-point sampling (Gonzalez 1985): each dot is the one farthest from all before it, the first one random."""
    return spread(evaluator.index, n, rng)


@sampler("centres of patches", "centres", nested=True)
def centres(evaluator, n, rng):
    """The centres of the paper's patches, which its sampling always keeps, filled up uniformly: a control for it."""
    always = np.unique(evaluator.cover.centre)
    rest = np.setdiff1d(np.arange(len(evaluator.points)), always)
    return np.concatenate([rng.permutation(always), rng.permutation(rest)])[:n]


def weights(points, subset):
    """Number of surface dots nearest to each kept dot (itself included).

    Parameters
    ----------
    points : (N, 3) float64
    subset : (n,) int, dot indices

    Returns
    -------
    (n,) int64, their sum is N.
    """
    return np.bincount(nearest_kept(points, subset)[0], minlength=len(subset))


def nearest_kept(points, subset, threads=1):
    """Place in `subset` of the kept dot nearest to every dot, (N,) int64, and its distance, (N,) Å."""
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second, and most jobs need no tree

    gap, place = cKDTree(points[subset]).query(points, workers=threads)
    return place, gap
