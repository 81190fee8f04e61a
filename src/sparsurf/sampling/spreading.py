"""Dots spread over a surface: as far from each other as can be, and denser where a weight says so."""

import numpy as np
from numba import njit

from sparsurf.patches.index import ball

SMOOTHEST = 0.01  # 1 - R counts as at least that, so that no weight is 0 or infinite


def spread(index, n, rng, weight=None):
    """Farthest-point sampling (Gonzalez 1985): each dot is the one farthest from all before it.

    Starts at a random dot. With weights, distances count more where the weight is large, so that the density of the chosen
    dots is proportional to it: squared distances are multiplied by it. A new dot comes nearer than those before it only to
    dots within the largest distance so far, so no others are looked at, and no N x n distances are kept.

    Parameters
    ----------
    index : PatchIndex
    n : int
    rng : numpy.random.Generator
    weight : (N,) float64, by dot, above 0; all alike without

    Returns
    -------
    (n,) int64 dots, in the order of choice; the first m of them are those for m
    """
    weight = np.ones(len(index.dot)) if weight is None else np.asarray(weight, float)[index.dot]
    start = int(index.position[int(rng.integers(len(index.dot)))])
    return index.dot[_farthest(index, start, n, weight)].astype(np.int64)


def denser_where_rough(evaluator, n, rng, k, even=True):
    """Dots whose density is proportional to (1 - R_i)^k, the first m of them those for m.

    Parameters
    ----------
    evaluator : Evaluator
    n : int
    rng : numpy.random.Generator
    k : float
        0 knows no roughness; above 0 dots are denser where the surface is rough, below where it is flat.
    even : bool
        Spread evenly at each roughness, see `spread`; else drawn at random, without replacement (Efraimidis & Spirakis,
        Inf. Process. Lett. 97:181, 2006).

    Returns
    -------
    (n,) int64 dots, in the order of choice
    """
    weight = np.clip(1 - evaluator.roughness, SMOOTHEST, None) ** k
    if even:
        return spread(evaluator.index, n, rng, weight)
    return np.argsort(rng.standard_exponential(len(weight)) / weight, kind="stable")[:n]


@njit(cache=True, nogil=True)
def _farthest(index, first, n, weight):
    """Positions in the order of choice, (n,) int32; `gap` is the squared distance to the nearest chosen dot times the weight."""
    n_dots = len(index.dot)
    found, out = np.empty(n_dots + 1, np.int32), np.empty(n, np.int32)
    diagonal2 = np.sum((index.shape * index.side) ** 2)
    gap = 4.0 * diagonal2 * weight
    least = weight.min()
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
        m = ball(index, x, y, z, 1.000001 * np.sqrt(gap[p] / least), found)
        for e in range(m):
            q = found[e]
            d2 = (index.xyz[q, 0] - x) ** 2 + (index.xyz[q, 1] - y) ** 2 + (index.xyz[q, 2] - z) ** 2
            d2 = (
                -1.0 if q == p else weight[q] * d2
            )  # never again, not even before a dot at the place of another
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
