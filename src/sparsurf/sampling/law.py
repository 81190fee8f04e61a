"""Subsets of a surface: the roughness-dependent sampling of the paper and the uniform one.

The sweep that lays the patches depends neither on the parameters nor on chance, so it runs once
(`build_cover`); each combination and draw is then one pass over its (centre, dot) pairs.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from sparsurf.patches.index import R_PATCH, ball_bound
from sparsurf.patches.islands import patch_of

BLOCK = 1 << 16  # pairs drawn at a time: their random numbers stay in the cache of a core


class Cover(NamedTuple):
    """The centres of a surface and the dots that each may keep; made by `build_cover`.

    centre : (C,) int32, dot that stands for each patch and is always kept
    origin : (C,) int32, dot that r_ij is measured from
    roughness : (C,) float64, R_i of each patch
    start : (C + 1,) int64, pairs of patch c are start[c]:start[c + 1]
    dot : (P,) int32, dot of each pair
    fall : (P,) float64, -ln(r_ij / R_patch); +inf at the centre itself
    n_dots : int, N
    """

    centre: np.ndarray
    origin: np.ndarray
    roughness: np.ndarray
    start: np.ndarray
    dot: np.ndarray
    fall: np.ndarray
    n_dots: int


def build_cover(index, roughness, radius=R_PATCH, moved_centre=True, every_patch=True):
    """Lay patches over the surface until each dot was looked at.

    Dots are swept in index order; one that no earlier patch holds starts a patch. Where the
    island of that patch does not contain the dot itself, the patch's centre is its dot nearest
    to it.

    Parameters
    ----------
    index : PatchIndex
    roughness : (N,) float64
        R_i of every dot.
    radius : float
        R_patch in Å.
    moved_centre : bool
        True, as published: r_ij is measured from the patch's centre, so that it can exceed
        R_patch and p can exceed 1. False: from the dot that started the patch.
    every_patch : bool
        True, as published: a dot has a chance in every patch that holds it. False: only in the first.

    Returns
    -------
    Cover
    """
    radius = float(radius)  # an int would compile kernels anew
    room = ball_bound(index, index.xyz, radius) + 1
    starter, *rest = _cover(index, radius, moved_centre, every_patch, room)
    centre, *pairs = rest
    return Cover(centre, centre if moved_centre else starter, roughness[starter], *pairs, len(roughness))


@njit(cache=True, nogil=True)
def _cover(index, radius, moved_centre, every_patch, room):
    n = len(index.dot)
    found, queue = np.empty(room, np.int32), np.empty(room, np.int32)
    mark, covered = np.zeros(n + 1, np.uint8), np.zeros(n, np.bool_)
    starter, centre, start = np.empty(n, np.int32), np.empty(n, np.int32), np.zeros(n + 1, np.int64)
    dot, fall = np.empty(4 * n + room, np.int32), np.empty(4 * n + room)
    patches = pairs = 0
    for i in range(n):
        p = np.intp(index.position[i])
        if covered[p]:
            continue
        begin, end = patch_of(index, p, radius, found, mark, queue)
        c = _nearest(index, p, queue, begin, end)
        origin = index.xyz[c] if moved_centre else index.xyz[p]
        if pairs + end - begin > len(dot):
            dot = np.concatenate((dot, np.empty(len(dot) + room, np.int32)))
            fall = np.concatenate((fall, np.empty(len(fall) + room)))
        for k in range(begin, end):
            j = queue[k]
            if every_patch or not covered[j]:
                r = math.sqrt(_distance2(index.xyz[j], origin))
                dot[pairs] = index.dot[j]
                fall[pairs] = -math.log(r / radius) if r > 0 else np.inf
                pairs += 1
            covered[j] = True
        starter[patches], centre[patches] = i, index.dot[c]
        patches += 1
        start[patches] = pairs
    return (
        starter[:patches].copy(),
        centre[:patches].copy(),
        start[: patches + 1].copy(),
        dot[:pairs].copy(),
        fall[:pairs].copy(),
    )


@njit(cache=True, nogil=True)
def _distance2(a, b):
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


@njit(cache=True, nogil=True)
def _nearest(index, p, queue, begin, end):
    """Position of the patch nearest to p (p itself where it belongs); on a tie the lower dot."""
    best, best_d2 = queue[begin], np.inf
    for k in range(begin, end):
        d2 = _distance2(index.xyz[queue[k]], index.xyz[p])
        if d2 < best_d2 or (d2 == best_d2 and index.dot[queue[k]] < index.dot[best]):
            best, best_d2 = queue[k], d2
    return best


def expected_n_s(cover, combinations):
    """Closed form of the expected number of kept dots, sum_j [1 - prod_i (1 - p_ij)].

    Parameters
    ----------
    cover : Cover
    combinations : (K, 4) float64
        alpha, beta, gamma, delta.

    Returns
    -------
    (K,) float64
    """
    combinations = np.ascontiguousarray(combinations, np.float64)
    out = np.empty(len(combinations))
    by_power = np.lexsort((combinations[:, 3], combinations[:, 2]))
    out[by_power] = _expected_n_s(cover, combinations[by_power])
    return out


@njit(cache=True, nogil=True)
def _expected_n_s(cover, combinations):
    """Expected number of kept dots; where gamma and delta repeat, (r / R_patch)^power is that of the row before."""
    out = np.empty(len(combinations))
    share, left_out = np.empty(len(cover.dot)), np.empty(cover.n_dots)
    for k in range(len(combinations)):
        alpha, beta, gamma, delta = combinations[k]
        if k == 0 or gamma != combinations[k - 1, 2] or delta != combinations[k - 1, 3]:
            for c in range(len(cover.centre)):
                power = gamma * (1.0 + cover.roughness[c]) + delta
                for q in range(cover.start[c], cover.start[c + 1]):
                    share[q] = math.exp(-power * cover.fall[q]) if power > 0 else 1.0
        left_out[:] = 1.0
        for c in range(len(cover.centre)):
            most = alpha * (1.0 - cover.roughness[c]) ** beta
            for q in range(cover.start[c], cover.start[c + 1]):
                left_out[np.uintp(cover.dot[q])] *= 1.0 - min(most * share[q], 1.0)
        for c in range(len(cover.centre)):
            left_out[cover.centre[c]] = 0.0
        out[k] = cover.n_dots - left_out.sum()
    return out


@njit(cache=True, nogil=True)
def _log_p(alpha, beta, gamma, delta, r):
    """ln p of a pair is log_a - power * fall (paper, eq. 2), with 0^0 = 1."""
    flat = 1.0 - r
    log_a = math.log(alpha)
    if beta > 0:
        log_a += beta * math.log(flat) if flat > 0 else -np.inf
    return log_a, gamma * (1.0 + r) + delta


def sample(cover, combination, rng):
    """One draw of the roughness-dependent sampling.

    A pair is kept when a uniform number lies below p; -ln of a uniform number is a standard
    exponential one, so the test needs neither a power nor a logarithm.

    Parameters
    ----------
    cover : Cover
    combination : sequence of 4 floats
        alpha, beta, gamma, delta.
    rng : numpy.random.Generator

    Returns
    -------
    (n_S,) int64, ascending dot indices. Source: paper, eq. 2.
    """
    keep = np.zeros(cover.n_dots, np.bool_)
    block = np.unique(np.searchsorted(cover.start, np.arange(0, cover.start[-1], BLOCK)))
    luck = np.empty(BLOCK + np.diff(cover.start).max())
    for first, last in zip(block, [*block[1:], len(cover.centre)], strict=True):
        rng.standard_exponential(out=luck[: cover.start[last] - cover.start[first]])
        _sample(cover, first, last, *map(float, combination), luck, keep)
    return np.flatnonzero(keep)


@njit(cache=True, nogil=True)
def _sample(cover, first, last, alpha, beta, gamma, delta, luck, keep):
    """The dots that the patches of centres first:last keep, for one exponential number per pair."""
    dot, fall, before = cover.dot, cover.fall, cover.start[first]
    for c in range(first, last):
        log_a, power = _log_p(alpha, beta, gamma, delta, cover.roughness[c])
        for q in range(cover.start[c], cover.start[c + 1]):
            pair = np.uintp(q)
            least = power * fall[pair] - log_a if power > 0 else -log_a
            keep[np.uintp(dot[pair])] |= luck[np.uintp(q - before)] > least
        keep[cover.centre[c]] = True


def uniform(n_dots, n_s, rng):
    """Uniform random subset of exactly `n_s` of `n_dots` dots; (n_s,) int64, ascending."""
    keep = np.zeros(n_dots, np.bool_)
    keep[rng.choice(n_dots, n_s, replace=False, shuffle=False)] = True
    return np.flatnonzero(keep)  # ascending; faster than to sort


def grid(alpha, beta, gamma, delta, **_):
    """All combinations of the lists of a config's `sampling`, (K, 4) float64, the last parameter running fastest."""
    return np.array(np.meshgrid(alpha, beta, gamma, delta, indexing="ij"), np.float64).reshape(4, -1).T
