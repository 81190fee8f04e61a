"""Sampler that adds dots where the surface recovered from the dots so far has the largest error."""

import math

import numpy as np
from numba import njit

from sparsurf.patches.index import ball, select_separated
from sparsurf.recovery.interpolants import DOTS_PER_TASK, Interpolants, fit_interpolants, interpolant_value
from sparsurf.sampling.published import SampledSurface
from sparsurf.sampling.samplers import farthest, sampler
from sparsurf.threads import parallel_map

FIRST_SHARE = 0.01  # of all dots, chosen by farthest points first: enough to show where the surface is curved
MIN_FIRST_DOTS = 50
GROWTH = 1.2  # factor by which the subset grows in each round
# A position error of 0.1 Å counts like a normal error of 1 rad. With more weight on the normals, all errors were larger.
POSITION_SCALE, NORMAL_SCALE = 0.1, 1.0
MIN_SEPARATION = (
    0.7  # in mean spacings, between the new dots of one round: each also reduces the error around it
)


@sampler("adaptive", nested=True)
def adaptive(prepared: SampledSurface, n: int, rng: np.random.Generator) -> np.ndarray:
    """Choose dots where the surface recovered from the previous dots has the largest errors in position and normal.

    The first dots are farthest-point dots. Each round then adds a fifth more: the dots with the largest errors that are not
    too close to each other.
    """
    n_dots = len(prepared.points)
    size = min(n_dots, max(MIN_FIRST_DOTS, round(FIRST_SHARE * n_dots)))
    subset = farthest(prepared, size, rng)
    while len(subset) < min(n, n_dots):
        size = min(n_dots, max(len(subset) + 1, round(GROWTH * len(subset))))
        subset = np.concatenate([subset, _dots_of_largest_error(prepared, subset, size - len(subset))])
    return subset[:n]


def _dots_of_largest_error(prepared: SampledSurface, subset: np.ndarray, n_new: int) -> np.ndarray:
    """Return the `n_new` dots of largest error; dots too close to a better one are taken only if there are no others."""
    error = recovery_errors(prepared.points, prepared.normals, subset)
    order = np.argsort(-error, kind="stable")
    order = order[~np.isin(order, subset)]
    distance = MIN_SEPARATION * math.sqrt(prepared.area / len(subset))
    separated = select_separated(prepared.index, order, distance, n_new, 0)
    rest = order[~np.isin(order, separated)]
    return np.concatenate([separated, rest[: n_new - len(separated)]])


def recovery_errors(
    points: np.ndarray, normals: np.ndarray, subset: np.ndarray, threads: int = 1
) -> np.ndarray:
    """Compute the error at every dot of the surface that is recovered from a subset.

    Parameters
    ----------
    points, normals : (N, 3) float64, Å and unit vectors
    subset : (n,) int, indices of the kept dots
    threads : int

    Returns
    -------
    (N,) float64: distance over `POSITION_SCALE` plus angle over `NORMAL_SCALE`; 0 at the kept dots.
    """
    points, normals = (np.ascontiguousarray(array, np.float64) for array in (points, normals))
    functions = fit_interpolants(points[subset], normals[subset], threads)
    error = np.empty(len(points))
    parallel_map(
        lambda begin, end: _write_errors(functions, points, normals, begin, end, error),
        len(points),
        threads,
        8 * DOTS_PER_TASK,
    )
    error[subset] = 0.0
    return error


@njit(cache=True, nogil=True)
def _write_errors(
    functions: Interpolants, points: np.ndarray, normals: np.ndarray, begin: int, end: int, out: np.ndarray
) -> None:
    """Write the errors at the dots of a slice, using the interpolant of the nearest kept dot."""
    index = functions.index
    candidates = np.empty(len(index.dot) + 1, np.int32)
    typical = np.median(functions.spacing)
    for t in range(begin, end):
        x, y, z = points[t]
        radius, best, nearest = typical, np.inf, -1
        while nearest < 0:
            for e in range(ball(index, x, y, z, radius, candidates)):
                j = candidates[e]
                cosine_of_normals = 0.0
                for c in range(3):
                    cosine_of_normals += index.normals[j, c] * normals[t, c]
                d2 = (index.xyz[j, 0] - x) ** 2 + (index.xyz[j, 1] - y) ** 2 + (index.xyz[j, 2] - z) ** 2
                if cosine_of_normals < 0.0:
                    d2 *= 4.0  # a dot on the opposite side does not recover this point
                if d2 < best:
                    best, nearest = d2, j
            radius *= 1.5
        f, u, v, w = interpolant_value(functions, nearest, x, y, z)
        g = math.sqrt(u * u + v * v + w * w)
        cosine = (u * normals[t, 0] + v * normals[t, 1] + w * normals[t, 2]) / max(g, 1e-9)
        angle = math.acos(min(1.0, max(-1.0, cosine)))
        out[t] = abs(f) / max(g, 0.2) / POSITION_SCALE + angle / NORMAL_SCALE
