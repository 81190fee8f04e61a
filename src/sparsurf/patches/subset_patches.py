"""Dots of patches: those of a whole surface and of many of its subsets around many points.

Up to 64 subsets share the work per point: its ball is found once, and each subset is one bit of a word per dot. Of more than
64, equal patches are found by their hashes. Nested subsets, each with the dots of all smaller ones, share more: a patch is
listed only where it differs from that of the next smaller subset.
Descriptors of the patches are computed elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sparsurf.bit_operations import lowest_bit
from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, ball
from sparsurf.patches.islands import drop_small_islands, largest_island, mark_all
from sparsurf.surfaces.vectors import point, slots

MAX_SUBSETS = 64  # per pass
MIN_SUBSETS_FOR_JOINT_SEARCH = 16  # fewer subsets are faster to search one by one


def pack_subsets(index: PatchIndex, subsets: Sequence[np.ndarray]) -> np.ndarray:
    """Store up to 64 subsets as bits, (N,) uint64: one word per position, bit b set if subset b keeps the dot."""
    bit_words = np.zeros(len(index.dot), np.uint64)
    for bit, subset in enumerate(subsets):
        add_subset(bit_words, index, subset, bit)
    return bit_words


def add_subset(bit_words: np.ndarray, index: PatchIndex, subset: np.ndarray, bit: int) -> None:
    """Set one bit (0 to 63) of the words of `pack_subsets` at the dots of a subset, in place."""
    _set_bit(bit_words, index.position, np.asarray(subset, np.int64), np.uint64(1 << int(bit)))


@njit()
def _set_bit(bit_words: np.ndarray, position: np.ndarray, subset: np.ndarray, bit: np.uint64) -> None:
    """Set a bit in the words of a subset's dots."""
    for j in subset:
        bit_words[position[j]] |= bit


@njit()
def _copy(source: np.ndarray, target: np.ndarray, n: int) -> None:
    """Copy `n` elements; numba takes seconds to compile the assignment of a slice to a slice."""
    for k in range(n):
        target[k] = source[k]


@njit()
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


@njit()
def patches_of(
    index: PatchIndex,
    tests: np.ndarray,
    bit_words: np.ndarray,
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
    """List the dots of every patch: of each test (T, 3), Å, its whole patch if requested, then the subsets' under each reading.

    `bit_words` are from `pack_subsets`, and `weights` (B, N) by position, or (0, 0) if all are 1. `among_kept` says which
    readings remove all but the largest island among the kept dots. `buffer_size` exceeds the dots in a ball; `mark` and
    `around`, (N + 1,), are 0, also on return. Written are `sizes`, (T, whole + readings B); `ids`, patch i being
    ids[start[i]:start[i + 1]]; and their `weight`.
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
        n = ball(index, point(tests, t), radius, in_ball)
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
                word[k] = bit_words[np.uintp(dots[k])]
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


@njit()
def hashes_of_dots(n_dots: int) -> np.ndarray:
    """Return a hash of each number from 0 to n_dots - 1, (n_dots,) uint64 (the finaliser of SplitMix64)."""
    out = np.empty(n_dots, np.uint64)
    for k in range(n_dots):
        x = np.uint64(k + 1) * np.uint64(0x9E3779B97F4A7C15)
        x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        out[k] = x ^ (x >> np.uint64(31))
    return out


@njit()
def new_patches(
    ids: np.ndarray,
    start: np.ndarray,
    per_test: int,
    hashes: np.ndarray,
    keys: np.ndarray,
    places: np.ndarray,
    rows: np.ndarray,
) -> int:
    """Find the patches that are not yet in a hash table, and the place of every patch in it; return the number of new ones.

    Patch i, ids[start[i]:start[i + 1]], is of test i // per_test. Two patches of a test are equal if their `hashes` have equal
    sums. `keys` is the table, a power of two in length, 0 where it is free. Written are `keys`, the `places` (rows,) of the
    patches and the first `rows` of new ones; new patches are moved to the front of `ids` and `start`.
    """
    mask, n, end = len(keys) - 1, np.intp(0), np.intp(0)
    begin = start[0]
    for i in range(len(places)):
        stop = start[i + 1]
        # The same dots around another test dot are another patch
        key = hashes[i // per_test] * np.uint64(3) + np.uint64(stop - begin)
        for k in range(begin, stop):
            key += hashes[ids[k]]
        key |= np.uint64(1)  # 0 marks a free place
        # Not by the lowest bits, of which one is set in every key
        place = np.int64((key >> np.uint64(20)) & np.uint64(mask))
        while keys[place] != 0 and keys[place] != key:
            place = (place + 1) & mask
        if keys[place] == 0:
            keys[place], rows[n] = key, i
            for k in range(begin, stop):
                ids[end] = ids[k]
                end += 1
            n += 1
            start[n] = end
        places[i] = place
        begin = stop
    return int(n)


@njit()
def nested_patches_of(
    index: PatchIndex,
    tests: np.ndarray,
    rank: np.ndarray,
    n_kept: np.ndarray,
    radius: float,
    among_kept: np.ndarray,
    buffer_size: int,
    ids: np.ndarray,
    start: np.ndarray,
    test: np.ndarray,
    patch: np.ndarray,
) -> int:
    """List the dots of the patches of nested subsets under each reading, each distinct patch once; return their number.

    A subset of n dots holds those of `rank` (by position) 0 to n - 1, for the ascending `n_kept` (S,). Dots join in this order,
    so the largest island is known without a search. Written are `ids` and `start` of the patches, the `test` of each, and
    `patch`, (readings, S, T), that of each subset. The others are as for `patches_of`.
    """
    in_ball, queue = np.empty(buffer_size, np.int32), np.empty(buffer_size, np.int32)
    mark, slot = np.zeros(len(rank) + 1, np.uint8), np.full(len(rank) + 1, -1, np.int32)
    parent, count = np.empty(buffer_size, np.int32), np.empty(buffer_size, np.int32)
    first = np.empty(buffer_size, np.int32)  # smallest dot of each island
    patches = end_of_ids = np.intp(0)
    start[0] = 0
    for t in range(len(tests)):
        for r in range(len(among_kept)):
            m = ball(index, point(tests, t), radius, in_ball)
            if not among_kept[r]:  # the island on the full surface serves all subsets
                mark_all(mark, in_ball, m)
                begin, end = largest_island(in_ball, m, mark, index.link_start, index.link, index.dot, queue)
                m = end - begin
                _copy(queue[begin:end], in_ball, m)
            n_ranked = _first_by_rank(in_ball, m, rank, n_kept[-1])
            n_in, is_new = np.intp(0), True
            best: int | np.integer = np.intp(0)
            for s in range(len(n_kept)):
                while n_in < n_ranked and rank[in_ball[n_in]] < n_kept[s]:
                    is_new |= not among_kept[r]
                    if among_kept[r]:
                        root = _join(index, in_ball, n_in, slot, parent, count, first)
                        # The island of before may have been merged into another one, whose root counts from now on
                        best = _root(parent, best)
                        if (
                            root == best
                            or count[root] > count[best]
                            or (count[root] == count[best] and first[root] < first[best])
                        ):
                            best, is_new = root, True
                    n_in += 1
                if is_new:
                    for k in range(n_in):
                        if not among_kept[r] or _root(parent, np.intp(k)) == best:
                            ids[end_of_ids] = in_ball[k]
                            end_of_ids += 1
                    test[patches] = t
                    patches += 1
                    start[patches] = end_of_ids
                    is_new = False
                patch[r, s, t] = patches - 1
            # Only what was set: clearing all N slots for each test would take longer than the search
            for k in range(n_in):
                slot[in_ball[k]] = -1
    return int(patches)


@njit()
def _first_by_rank(ids: np.ndarray, n: int, rank: np.ndarray, end: int) -> np.integer:
    """Move those of `ids[:n]` with a rank below `end` to the front, sorted by rank, and return their number.

    Shell sort: numba takes seconds to compile its own sorting.
    """
    m = np.intp(0)
    for k in range(n):
        if rank[ids[k]] < end:
            ids[m] = ids[k]
            m += 1
    for gap in (301, 132, 57, 23, 10, 4, 1):  # Ciura's
        for k in range(gap, m):
            i, slot = ids[k], k
            while slot >= gap and rank[ids[slot - gap]] > rank[i]:
                ids[slot] = ids[slot - gap]
                slot -= gap
            ids[slot] = i
    return m


@njit()
def _root(parent: np.ndarray, k: int | np.integer) -> int | np.integer:
    """Return the root of the island of slot k, and shorten the way to it."""
    while parent[k] != k:
        parent[k] = parent[parent[k]]
        k = parent[k]
    return k


@njit()
def _join(
    index: PatchIndex,
    ids: np.ndarray,
    k: int | np.integer,
    slot: np.ndarray,
    parent: np.ndarray,
    count: np.ndarray,
    first: np.ndarray,
) -> int | np.integer:
    """Add `ids[k]` as slot k, merge the islands that it links, and return the root; `slot` (N + 1,) is -1 of dots to come."""
    i = ids[k]
    slot[i], parent[k], count[k], first[k] = k, k, 1, index.dot[i]
    root = k
    for e in slots(index.link_start, i):
        neighbour = slot[index.link[e]]
        if neighbour >= 0:
            other = _root(parent, np.intp(neighbour))
            if other != root:
                if count[other] > count[root]:
                    other, root = root, other
                parent[other] = root
                count[root] += count[other]
                first[root] = min(first[root], first[other])
    return root
