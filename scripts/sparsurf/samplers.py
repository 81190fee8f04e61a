"""Samplers of a surface, one interface: (surface, n, rng) -> n dots in the order of choice.

`surface` is anything with `points` (N, 3), `index`, `roughness` (N,), `cover` and
`choices_of_paper` (see `evaluation.Evaluator`). To add a sampler, write one function and put
`@sampler` above it. All keep exactly n dots but the paper's, whose n_S is left to chance.
"""

import numpy as np
from numba import njit

from sparsurf import sampling
from sparsurf.patches import build_index, spacing

SAMPLERS = {}


def sampler(function):
    """Register a sampler under its name."""
    SAMPLERS[function.__name__] = function
    return function


@sampler
def paper(surface, n, rng):
    """The roughness-dependent sampling, with what its own criterion d chose for this range of n_S.

    alpha is set so that the expected n_S is n; where even alpha = 1 keeps fewer, the choice for the next range
    takes its place. n_S itself is left to chance.
    """
    return _paper(surface, surface.cover, n, rng)


@sampler
def paper_corrected(surface, n, rng):
    """The same with distances from the dot itself and one draw per dot."""
    return _paper(surface, surface.corrected_cover, n, rng)


def _paper(surface, cover, n, rng):
    choices = surface.choices_of_paper(n)
    reach = sampling.expected_n_s(cover, [(1.0, *choice[1:]) for choice in choices])
    choice = choices[int(np.argmax(reach >= n)) if (reach >= n).any() else int(np.argmax(reach))]
    return sampling.sample(cover, tune_alpha(cover, choice, n), rng)


def tune_alpha(cover, combination, n):
    """`combination` with the alpha in (0, 1] whose expected n_S is nearest to n; n_S grows with alpha."""
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = (low + high) / 2
        few = sampling.expected_n_s(cover, [(middle, *combination[1:])])[0] < n
        low, high = (middle, high) if few else (low, middle)
    return (high, *combination[1:])


@sampler
def uniform(surface, n, rng):
    """Every subset of n dots is equally likely."""
    return rng.permutation(len(surface.points))[:n]


@sampler
def roughness(surface, n, rng):
    """Without replacement, each draw with a chance proportional to 1 - R_i (Efraimidis & Spirakis 2006)."""
    with np.errstate(divide="ignore"):
        keys = rng.standard_exponential(len(surface.points)) / (1 - surface.roughness)
    return np.argsort(keys, kind="stable")[:n]


@sampler
def stride(surface, n, rng):
    """Every (N / n)-th dot in the order of the surface, from a random start."""
    step = len(surface.points) / n
    return (
        np.floor(rng.random() * step + step * np.arange(n)).astype(np.int64).clip(0, len(surface.points) - 1)
    )


@sampler
def voxel(surface, n, rng):
    """One dot per cubic voxel, the one nearest to the mean of its dots; grid placed at random.

    The side is the largest that gives n voxels or more; surplus dots are left out at random.
    """
    origin = surface.points.min(axis=0) - rng.random(3) * 10.0
    return _most_with(lambda side: _voxel_dots(surface.points, origin, side), surface, n, rng)


def _voxel_dots(points, origin, side):
    cell = np.floor((points - origin) / side).astype(np.int64)
    _, voxel_of = np.unique(cell, axis=0, return_inverse=True)
    count = np.bincount(voxel_of)
    mean = np.stack([np.bincount(voxel_of, x) / count for x in points.T], axis=1)
    gap = np.sum((points - mean[voxel_of]) ** 2, axis=1)
    first = np.lexsort((gap, voxel_of))
    return first[np.concatenate([[0], np.cumsum(count)[:-1]])]


@sampler
def poisson(surface, n, rng):
    """Poisson disk: dots in random order, each kept unless one within the radius was; as many radii as n asks for."""
    order = rng.permutation(len(surface.points))
    return _most_with(lambda radius: order[_darts(surface.points[order], radius)], surface, n, rng)


def _darts(points, radius):
    """Places of the dots that no earlier kept dot is within `radius` of."""
    index = build_index(points, points, radius)
    return np.flatnonzero(_throw(index.position, index.link_start, index.link))


@njit(cache=True, nogil=True)
def _throw(position, link_start, link):
    n = len(position)
    blocked, kept = np.zeros(n + 1, np.bool_), np.zeros(n, np.bool_)
    for i in range(n):
        p = position[i]
        if not blocked[p]:
            kept[i] = True
            for e in range(link_start[p], link_start[p + 1]):
                blocked[link[e]] = True
    return kept


def _most_with(dots_at, surface, n, rng):
    """`dots_at(length)` at the largest length that gives at least n dots, cut to n at random."""
    low, high, best = 0.0, None, np.arange(len(surface.points))
    length = 0.7 * spacing(surface.index) * np.sqrt(len(surface.points) / n)
    for _ in range(24):
        dots = dots_at(length)
        if len(dots) >= n:
            low, best = length, dots
        else:
            high = length
        if len(best) == n or (high is not None and high - low < 1e-4 * high):
            break
        length = 1.4 * length if high is None else (low + high) / 2
    return rng.permutation(best)[:n]


@sampler
def farthest(surface, n, rng):
    """Farthest-point sampling (Gonzalez 1985): each dot is the one farthest from all before it; nested.

    Starts at a random dot. A new dot changes distances only within the largest one so far, so the
    cells in that reach are visited and no N x n distances are kept.
    """
    start = int(rng.integers(len(surface.points)))
    return surface.index.dot[_farthest(surface.index, int(surface.index.position[start]), n)].astype(np.int64)


@njit(cache=True, nogil=True)
def _farthest(index, first, n):
    n_dots, side, shape, origin = len(index.dot), index.side, index.shape, index.origin
    gap = np.full(n_dots, np.inf)  # squared distance to the nearest chosen dot
    leaves = 1
    while leaves < len(index.start) - 1:
        leaves *= 2
    champion = np.full(2 * leaves, -1, np.int32)  # tournament over cells: position with the largest gap
    out = np.empty(n, np.int32)
    p = first
    for k in range(n):
        out[k] = p
        reach = np.sqrt(gap[p]) if k > 0 else np.inf
        x, y, z = index.xyz[p, 0], index.xyz[p, 1], index.xyz[p, 2]
        a0, a1, b0, b1, c0, c1 = 0, shape[0] - 1, 0, shape[1] - 1, 0, shape[2] - 1
        if k > 0:
            a0, a1 = (
                max(a0, int((x - reach - origin[0]) / side)),
                min(a1, int((x + reach - origin[0]) / side)),
            )
            b0, b1 = (
                max(b0, int((y - reach - origin[1]) / side)),
                min(b1, int((y + reach - origin[1]) / side)),
            )
            c0, c1 = (
                max(c0, int((z - reach - origin[2]) / side)),
                min(c1, int((z + reach - origin[2]) / side)),
            )
        for a in range(a0, a1 + 1):
            for b in range(b0, b1 + 1):
                for c in range(c0, c1 + 1):
                    cell = (a * shape[1] + b) * shape[2] + c
                    if index.start[cell] == index.start[cell + 1]:
                        continue
                    best, changed = -1, False
                    for q in range(index.start[cell], index.start[cell + 1]):
                        d2 = (
                            (index.xyz[q, 0] - x) ** 2
                            + (index.xyz[q, 1] - y) ** 2
                            + (index.xyz[q, 2] - z) ** 2
                        )
                        if d2 < gap[q]:
                            gap[q], changed = d2, True
                        best = _better(gap, index.dot, best, q)
                    if changed:
                        node = leaves + cell
                        champion[node] = best
                        while node > 1:
                            node //= 2
                            champion[node] = _better(
                                gap, index.dot, champion[2 * node], champion[2 * node + 1]
                            )
        p = champion[1]
    return out


@njit(cache=True, nogil=True)
def _better(gap, dot, p, q):
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


def nearest_kept(points, subset):
    """Place in `subset` of the kept dot nearest to every dot, (N,) int64, and its distance, (N,) Å."""
    from scipy.spatial import cKDTree

    gap, place = cKDTree(points[subset]).query(points)
    return place, gap
