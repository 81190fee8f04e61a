"""Dots of patches: those of a whole surface and of many of its subsets around many points.

Up to 64 subsets share the work per point: its ball is found once, and each subset is one bit of a word per dot.
Descriptors of the patches are computed elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sparsurf.bits import lowest_bit
from sparsurf.kernel_cache import njit
from sparsurf.patches.index import PatchIndex, ball
from sparsurf.patches.islands import drop_small_islands, largest_island, mark_all

MAX_SUBSETS = 64  # per pass
MIN_SUBSETS_FOR_JOINT_SEARCH = 16  # fewer subsets are faster to search one by one


def pack_subsets(index: PatchIndex, subsets: Sequence[np.ndarray]) -> np.ndarray:
    """Store up to 64 subsets as bits: one word per position, bit b set if subset b keeps the dot.

    Parameters
    ----------
    index : PatchIndex
    subsets : sequence of at most 64 arrays of dot indices

    Returns
    -------
    (N,) uint64
    """
    words = np.zeros(len(index.dot), np.uint64)
    for bit, subset in enumerate(subsets):
        add_subset(words, index, subset, bit)
    return words


def add_subset(words: np.ndarray, index: PatchIndex, subset: np.ndarray, bit: int) -> None:
    """Set one bit at the dots of a subset, in place.

    Parameters
    ----------
    words : (N,) uint64, see `pack_subsets`
    index : PatchIndex
    subset : (n,) int, dot indices
    bit : int, 0 to 63
    """
    _set_bit(words, index.position, np.asarray(subset, np.int64), np.uint64(1 << int(bit)))


@njit(cache=True, nogil=True)
def _set_bit(words: np.ndarray, position: np.ndarray, subset: np.ndarray, bit: np.uint64) -> None:
    """Set a bit in the words of a subset's dots."""
    for j in subset:
        words[position[j]] |= bit


@njit(cache=True, nogil=True)
def _copy(source: np.ndarray, target: np.ndarray, n: int) -> None:
    """Copy `n` elements; numba takes seconds to compile the assignment of a slice to a slice."""
    for k in range(n):
        target[k] = source[k]


@njit(cache=True, nogil=True)
def _distribute(dots: np.ndarray, word: np.ndarray, lists: np.ndarray, count: np.ndarray) -> None:
    """Append each dot to the lists of the subsets whose bit is set; subset b gets lists[b, :count[b]], in the order of `dots`."""
    count[:] = 0
    for k in range(len(dots)):
        remaining = word[k]
        while remaining:
            b = np.uintp(lowest_bit(remaining))  # type: ignore[call-arg]  # numba's stub counts the typing context
            lists[b, np.uintp(count[b])] = dots[k]
            count[b] += 1
            remaining &= remaining - np.uint64(1)


@njit(cache=True, nogil=True)
def patches_of(
    index: PatchIndex,
    tests: np.ndarray,
    words: np.ndarray,
    n_subsets: int,
    weights: np.ndarray,
    radius: float,
    among_kept: np.ndarray,
    buffer_size: int,
    mark: np.ndarray,
    around: np.ndarray,
    sizes: np.ndarray,
    ids: np.ndarray,
    start: np.ndarray,
    weight: np.ndarray,
) -> None:
    """List the dots of every patch: of a test dot its whole patch, then those of the subsets under each reading.

    Parameters
    ----------
    index : PatchIndex
    tests : (T, 3) float64, Å
    words : (N,) uint64, see `pack_subsets`
    n_subsets : int
    weights : (B, N) float64 by position, or (0, 0): all have the weight 1
    radius : float, Å
    among_kept : (readings,) bool, whether each reading removes islands among the kept dots
    buffer_size : int, dots in a ball at most, plus 1
    mark : (N + 1,) uint8 and around : (N + 1,) uint64, all 0, also on return
    sizes : (T, whole + readings B) int32, written; `whole` is 1 where the whole patch is requested
    ids : int32 positions, written, and start : (patches + 1,) int64: patch i is ids[start[i]:start[i + 1]]
    weight : float64 for each of `ids`, or empty like `weights`
    """
    lists, count = np.empty((n_subsets, buffer_size), np.int32), np.empty(n_subsets, np.intp)
    in_ball, queue = np.empty(buffer_size, np.int32), np.empty(buffer_size, np.int32)
    island, word = np.empty(buffer_size, np.int32), np.empty(buffer_size, np.uint64)
    whole = sizes.shape[1] - len(among_kept) * n_subsets
    needs_surface_island = whole > 0
    for r in range(len(among_kept)):
        needs_surface_island |= not among_kept[r]
    row = end_of_ids = np.intp(0)  # with a plain 0, numba compiles the called kernels twice
    start[0] = 0
    for t in range(len(tests)):
        n = ball(index, tests[t, 0], tests[t, 1], tests[t, 2], radius, in_ball)
        if needs_surface_island:  # the island on the full surface serves all subsets
            mark_all(mark, in_ball, n)
            begin, end = largest_island(in_ball, n, mark, index.link_start, index.link, index.dot, queue)
            n_island = end - begin
            _copy(queue[begin:end], island, n_island)
        if whole > 0:
            sizes[t, 0] = n_island
            _copy(island, ids[end_of_ids:], n_island)
            if len(weight):
                for k in range(n_island):
                    weight[end_of_ids + k] = 1.0
            end_of_ids += n_island
            row += 1
            start[row] = end_of_ids
        for r in range(len(among_kept)):
            dots = in_ball[:n] if among_kept[r] else island[:n_island]
            for k in range(len(dots)):
                word[k] = words[np.uintp(dots[k])]
            if among_kept[r] and n_subsets >= MIN_SUBSETS_FOR_JOINT_SEARCH:
                drop_small_islands(dots, word, index.link_start, index.link, around)
            _distribute(dots, word, lists, count)
            for b in range(n_subsets):
                m, chosen = count[b], lists[b]
                if among_kept[r]:
                    mark_all(mark, chosen, m)
                    begin, end = largest_island(
                        chosen, m, mark, index.link_start, index.link, index.dot, queue
                    )
                    m, chosen = end - begin, queue[begin:end]
                _copy(chosen, ids[end_of_ids:], m)
                if len(weight):
                    for k in range(m):
                        weight[end_of_ids + k] = weights[b, chosen[k]]
                sizes[t, whole + r * n_subsets + b] = m
                end_of_ids += m
                row += 1
                start[row] = end_of_ids
