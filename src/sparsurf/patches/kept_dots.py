"""Which dots: the patches of a whole surface and of many of its subsets around many points.

Up to 64 subsets share the work per point: its ball is found once, and each subset is one bit of a word per dot.
What a patch is described by is none of this module's business.
"""

import numpy as np
from numba import njit

from sparsurf.bits import lowest_bit
from sparsurf.patches.index import ball
from sparsurf.patches.islands import largest_island, leave_small_islands, mark_all

BITS = 64  # subsets per pass
MANY = 16  # subsets from which on it pays to look at all their islands at once


def pack(index, subsets):
    """One word per position, bit b set where subset b keeps the dot.

    Parameters
    ----------
    index : patches.Index
    subsets : sequence of at most 64 arrays of dot indices

    Returns
    -------
    (N,) uint64
    """
    words = np.zeros(len(index.dot), np.uint64)
    for bit, subset in enumerate(subsets):
        add(words, index, subset, bit)
    return words


def add(words, index, subset, bit):
    """Set one bit at the dots of a subset, (n,) int, in the words of `pack`."""
    _set_bit(words, index.position, np.asarray(subset, np.int64), np.uint64(1 << int(bit)))


@njit(cache=True, nogil=True)
def _set_bit(words, position, subset, bit):
    for j in subset:
        words[position[j]] |= bit


@njit(cache=True, nogil=True)
def _copy(source, to, n):
    """`n` of a source; numba takes seconds to compile slices that are set from slices."""
    for k in range(n):
        to[k] = source[k]


@njit(cache=True, nogil=True)
def _deal(dots, word, lists, count):
    """Hand each dot to the subsets whose bit its word has; subset b gets lists[b, :count[b]], in the order of `dots`."""
    count[:] = 0
    for k in range(len(dots)):
        left = word[k]
        while left:
            b = np.uintp(lowest_bit(left))
            lists[b, np.uintp(count[b])] = dots[k]
            count[b] += 1
            left &= left - np.uint64(1)


@njit(cache=True, nogil=True)
def patches_of(
    index, tests, words, n_subsets, weights, radius, kept, room, mark, around, sizes, ids, start, weight
):
    """Dots of every patch, one after another: of a test its whole patch, those of the subsets under each reading.

    Parameters
    ----------
    tests : (T, 3) float64, Å
    words : (N,) uint64, see `pack`
    weights : (B, N) float64 by position, or (0, 0): all weigh 1
    kept : (readings,) bool, whether each removes islands among the kept dots
    room : int, dots that a ball holds at most, plus 1
    mark : (N + 1,) uint8 and around : (N + 1,) uint64, all 0, also on return
    sizes : (T, whole + readings B) int32, written; `whole` is 1 where the whole patch is requested
    ids : int32 positions, written, and start : (patches + 1,) int64: patch i is ids[start[i]:start[i + 1]]
    weight : float64 beside `ids`, or empty as `weights`
    """
    lists, count = np.empty((n_subsets, room), np.int32), np.empty(n_subsets, np.intp)
    found, queue = np.empty(room, np.int32), np.empty(room, np.int32)
    island, word = np.empty(room, np.int32), np.empty(room, np.uint64)
    whole = sizes.shape[1] - len(kept) * n_subsets
    of_surface = whole > 0
    for r in range(len(kept)):
        of_surface |= not kept[r]
    row = end_of_ids = np.intp(0)  # of a plain 0 numba compiles what it is given to once more
    start[0] = 0
    for t in range(len(tests)):
        n = ball(index, tests[t, 0], tests[t, 1], tests[t, 2], radius, found)
        if of_surface:  # its island of the full surface comes once for all subsets
            mark_all(mark, found, n)
            begin, end = largest_island(found, n, mark, index.link_start, index.link, index.dot, queue)
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
        for r in range(len(kept)):
            dots = found[:n] if kept[r] else island[:n_island]
            for k in range(len(dots)):
                word[k] = words[np.uintp(dots[k])]
            if kept[r] and n_subsets >= MANY:
                leave_small_islands(dots, word, index.link_start, index.link, around)
            _deal(dots, word, lists, count)
            for b in range(n_subsets):
                m, chosen = count[b], lists[b]
                if kept[r]:
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
