"""Samplers of a surface, one interface: (surface, n, rng) -> n dots in the order of choice.

`surface` is anything with `points` (N, 3), `index`, `roughness` (N,), `cover` and
`corrected_cover` (see `evaluator.Evaluator`). To add a sampler, write one function and put
`@sampler(...)` above it, with what `Sampler` holds. All keep exactly n dots but the paper's,
whose n_S is left to chance.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numba import njit

from sparsurf import InputError
from sparsurf.patches.index import apart, ball
from sparsurf.sampling import law
from sparsurf.sampling.published import OF_PAPER

SAMPLERS = {}
HINDSIGHT = "paper_in_hindsight"  # in tables only: `paper` with the combinations that proved best
SURPLUS = 0.005  # a length that gives this share of dots too many is good enough: they are left out at random


class Sampler(NamedTuple):
    """A sampler, called like its function.

    function : (surface, n, rng) -> (n,) int64 dots
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

    `choices` are the combinations that the paper's samplers take, see `published.Choices`.

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
def paper(surface, n, rng, choices=OF_PAPER):
    """The roughness-dependent sampling, with what its own criterion d chose for this range of n_S.

    alpha is set so that the expected n_S is n; where even alpha = 1 keeps fewer, the choice for the next range
    takes its place. n_S itself is left to chance.
    """
    return _paper(surface.cover, choices, n, rng)


@sampler("paper's, corrected", "paper (corrected)", choosing=True)
def paper_corrected(surface, n, rng, choices=OF_PAPER):
    """The same with distances from the dot itself and one draw per dot."""
    return _paper(surface.corrected_cover, choices, n, rng)


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
def uniform(surface, n, rng):
    """Every subset of n dots is equally likely."""
    return rng.permutation(len(surface.points))[:n]


@sampler("roughness-weighted", nested=True)
def roughness(surface, n, rng):
    """Without replacement, each draw with a chance proportional to 1 - R_i (Efraimidis & Spirakis 2006)."""
    with np.errstate(divide="ignore"):
        keys = rng.standard_exponential(len(surface.points)) / (1 - surface.roughness)
    return np.argsort(keys, kind="stable")[:n]


@sampler("every k-th dot")
def stride(surface, n, rng):
    """Every (N / n)-th dot in the order of the surface, from a random start."""
    n_dots = len(surface.points)
    return (rng.integers(n_dots) + n_dots * np.arange(n)) // n


@sampler("one per voxel")
def voxel(surface, n, rng):
    """One dot per cubic voxel, the one nearest to the mean of its dots; grid placed at random.

    The side is as large as n voxels allow; surplus dots are left out at random.
    """
    corner = surface.points.min(axis=0)
    shift = rng.random(3)  # of a side
    return _longest(lambda side: _voxel_dots(surface.points - corner + shift * side, side), surface, n, rng)


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
def poisson(surface, n, rng):
    """Poisson disk: dots in random order, each kept unless an earlier one lies within a radius.

    The radius is as large as n dots allow; surplus dots are left out at random.
    """
    order = rng.permutation(len(surface.points))
    return _longest(lambda radius: apart(surface.index, order, radius, len(order), 0), surface, n, rng)


def _longest(dots_at, surface, n, rng):
    """`dots_at(length)` at nearly the largest length that gives n dots, cut to n at random."""
    low, high, best = 0.0, np.inf, np.arange(len(surface.points))
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
def farthest(surface, n, rng):
    """Farthest-point sampling (Gonzalez 1985): each dot is the one farthest from all before it.

    Starts at a random dot. A new dot comes nearer than those before it only to dots within the largest
    distance so far, so no others are looked at, and no N x n distances are kept.
    """
    start = int(rng.integers(len(surface.points)))
    return surface.index.dot[_farthest(surface.index, int(surface.index.position[start]), n)].astype(np.int64)


@njit(cache=True, nogil=True)
def _farthest(index, first, n):
    n_dots = len(index.dot)
    found, out = np.empty(n_dots + 1, np.int32), np.empty(n, np.int32)
    diagonal2 = np.sum((index.shape * index.side) ** 2)
    gap = np.full(n_dots, 4.0 * diagonal2)  # Å^2, to the nearest chosen dot
    leaves = 1
    while leaves < n_dots:
        leaves *= 2
    winner = np.full(2 * leaves, -1, np.int32)  # knockout of the gaps: the largest stands at 1
    for q in range(n_dots):
        winner[leaves + q] = q
    for node in range(leaves - 1, 0, -1):
        winner[node] = _larger(gap, index.dot, winner[2 * node], winner[2 * node + 1])
    p = first
    for k in range(n):
        out[k] = p
        x, y, z = index.xyz[p, 0], index.xyz[p, 1], index.xyz[p, 2]
        m = ball(index, x, y, z, 1.000001 * np.sqrt(gap[p]), found)
        for e in range(m):
            q = found[e]
            d2 = (index.xyz[q, 0] - x) ** 2 + (index.xyz[q, 1] - y) ** 2 + (index.xyz[q, 2] - z) ** 2
            if q == p:
                d2 = -1.0  # never again, not even before a dot at the place of another
            if d2 < gap[q]:
                gap[q] = d2
                node = (leaves + q) // 2
                while node > 0 and winner[node] == q:  # a smaller gap matters only where it won
                    winner[node] = _larger(gap, index.dot, winner[2 * node], winner[2 * node + 1])
                    node //= 2
        p = winner[1]
    return out


@njit(cache=True, nogil=True)
def _larger(gap, dot, p, q):
    """The position with the larger gap; on a tie the lower dot; -1 stands for none."""
    if p < 0 or q < 0:
        return max(p, q)
    if gap[p] != gap[q]:
        return p if gap[p] > gap[q] else q
    return p if dot[p] < dot[q] else q


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
