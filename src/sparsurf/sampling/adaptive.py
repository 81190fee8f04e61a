"""Dots where the surface that the kept dots give back errs most."""

import math

import numpy as np
from numba import njit

from sparsurf.patches.index import ball, select_separated
from sparsurf.recovery.interpolants import SLICE, fit, value
from sparsurf.sampling.samplers import farthest, sampler
from sparsurf.threads import parallel_map

FIRST = 0.01  # of the dots are farthest-point dots: enough to tell where the surface bends
FEWEST = 50
GROWTH = 1.2  # of the subset from one round to the next
POSITION, NORMAL = 0.1, 1.0  # Å and rad that count alike; more weight on the normals made every error larger
CLEAR = 0.7  # spacings; new dots of one round keep this distance, as one may cure the error of the other


@sampler(nested=True)
def adaptive(evaluator, n, rng):
    """Dots where the surface recovered from those before errs most, in position and in normal.

    Farthest-point dots first; then, in rounds that each add a fifth, the dots of the largest error that are not too
    near to each other.
    """
    n_dots = len(evaluator.points)
    size = min(n_dots, max(FEWEST, round(FIRST * n_dots)))
    chosen = farthest(evaluator, size, rng)
    while len(chosen) < min(n, n_dots):
        size = min(n_dots, max(len(chosen) + 1, round(GROWTH * len(chosen))))
        chosen = np.concatenate([chosen, _worst(evaluator, chosen, size - len(chosen))])
    return chosen[:n]


def _worst(evaluator, chosen, wanted):
    """`wanted` dots by falling error, none near to another of them as long as there are enough."""
    error = errors(evaluator.points, evaluator.normals, chosen)
    order = np.argsort(-error, kind="stable")
    order = order[~np.isin(order, chosen)]
    clear = select_separated(
        evaluator.index, order, CLEAR * math.sqrt(evaluator.area / len(chosen)), wanted, 0
    )
    rest = order[~np.isin(order, clear)]
    return np.concatenate([clear, rest[: wanted - len(clear)]])


def errors(points, normals, chosen, threads=1):
    """What the surface recovered from some dots errs by at every dot.

    Parameters
    ----------
    points, normals : (N, 3) float64, Å and unit vectors
    chosen : (n,) int, the kept dots
    threads : int

    Returns
    -------
    (N,) float64: distance over `POSITION` plus angle over `NORMAL`; 0 at the kept dots.
    """
    points, normals = (np.ascontiguousarray(each, np.float64) for each in (points, normals))
    functions = fit(points[chosen], normals[chosen], threads)
    out = np.empty(len(points))
    parallel_map(lambda a, b: _error(functions, points, normals, a, b, out), len(points), threads, 8 * SLICE)
    out[chosen] = 0.0
    return out


@njit(cache=True, nogil=True)
def _error(functions, points, normals, begin, end, out):
    """Errors at the dots of a slice, by the function of the kept dot nearest to each."""
    index = functions.index
    found = np.empty(len(index.dot) + 1, np.int32)
    typical = np.median(functions.spacing)
    for t in range(begin, end):
        x, y, z = points[t]
        radius, best, nearest = typical, np.inf, -1
        while nearest < 0:
            for e in range(ball(index, x, y, z, radius, found)):
                j = found[e]
                along = 0.0
                for c in range(3):
                    along += index.normals[j, c] * normals[t, c]
                d2 = (index.xyz[j, 0] - x) ** 2 + (index.xyz[j, 1] - y) ** 2 + (index.xyz[j, 2] - z) ** 2
                if along < 0.0:
                    d2 *= 4.0  # a dot of another side is not the one that this place is recovered from
                if d2 < best:
                    best, nearest = d2, j
            radius *= 1.5
        f, u, v, w = value(functions, nearest, x, y, z)
        g = math.sqrt(u * u + v * v + w * w)
        cosine = (u * normals[t, 0] + v * normals[t, 1] + w * normals[t, 2]) / max(g, 1e-9)
        angle = math.acos(min(1.0, max(-1.0, cosine)))
        out[t] = abs(f) / max(g, 0.2) / POSITION + angle / NORMAL
