"""The patch of a dot and its islands: the connected components of the dots linked within d_link."""

from __future__ import annotations

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import (
    D_LINK,
    MIN_LINKS_PER_DOT,
    R_PATCH,
    PatchIndex,
    ball,
    ball_bound,
    build_index,
)
from sparsurf.surfaces.spacing import MIN_D_LINK_PER_SPACING, spacing
from sparsurf.surfaces.vectors import point

JUDGED_PATCHES = 200  # by which the patches of dots are judged
# Median share of the dots of a patch that its largest island holds. It is .98 to 1 on surfaces of `surface` and DMS. Where random
# dots are left out, the mean roughness is .003 to .007 too high at .97, .03 at .83, .09 at .48 and .21 at .21.
MIN_SHARE_IN_ISLAND = 0.9


@njit()
def mark_all(mark: np.ndarray, ids: np.ndarray, n: int) -> None:
    """Set `mark` to 1 at `ids[:n]`."""
    for k in range(n):
        mark[np.uintp(ids[k])] = 1


@njit()
def largest_island(
    ids: np.ndarray,
    n: int,
    mark: np.ndarray,
    link_start: np.ndarray,
    link: np.ndarray,
    key: np.ndarray,
    queue: np.ndarray,
) -> tuple[int, int]:
    """Find the largest island of `ids[:n]`, as the slice begin:end of `queue` (n + 1,); of equal ones, that with the least `key`.

    `mark` is 1 at every id that takes part and 0 elsewhere (also at the padding id); on return it is all 0. Unsigned indices
    avoid numba's test for negative ones, which takes half of the time.
    """
    tail = begin = end = np.intp(0)  # with a plain 0, numba compiles the called kernels twice
    best_key = np.int64(-1)
    for s in range(n):
        # Fewer dots are left than the largest island has; as many could still form an equal one with a lower key
        if n - tail < end - begin:
            break
        if mark[np.uintp(ids[s])] == 0:
            continue
        head = first = tail
        queue[tail] = ids[s]
        tail += 1
        mark[np.uintp(ids[s])] = 0
        while head < tail:
            i = np.uintp(queue[np.uintp(head)])
            row, row_end = link_start[i], link_start[i + np.uintp(1)]
            head += 1
            for e in range(MIN_LINKS_PER_DOT):  # without a branch: an id that does not count is overwritten
                j = link[np.uintp(row + e)]
                queue[np.uintp(tail)] = j
                tail += mark[np.uintp(j)]
                mark[np.uintp(j)] = 0
            for e in range(row + MIN_LINKS_PER_DOT, row_end):
                j = link[np.uintp(e)]
                queue[np.uintp(tail)] = j
                tail += mark[np.uintp(j)]
                mark[np.uintp(j)] = 0
        if tail - first > end - begin:
            begin, end, best_key = first, tail, np.int64(-1)
        elif tail - first == end - begin:
            if best_key < 0:
                best_key = _smallest_key(queue, begin, end, key)
            this_key = _smallest_key(queue, first, tail, key)
            if this_key < best_key:
                begin, end, best_key = first, tail, this_key
    for s in range(n):
        mark[np.uintp(ids[s])] = 0
    return int(begin), int(end)


@njit()
def spread_words(
    ids: np.ndarray,
    word: np.ndarray,
    n: int,
    link_start: np.ndarray,
    link: np.ndarray,
    reached: np.ndarray,
    waiting: np.ndarray,
) -> None:
    """Spread bits along links: each dot gets those bits of its word that a linked dot has, until nothing changes.

    `word[k]` is that of `ids[k]`, for the first n. `reached` (N + 1,) holds the bits at the start, and all on return. It is
    fastest with `ids` in about the order in which the bits arrive. `waiting` needs n elements.
    """
    end = 0
    for k in range(n):
        _, lacks = _update(np.uintp(ids[k]), word[k], link_start, link, reached)
        waiting[end] = k
        end += lacks
    begin, changed = 0, True
    # Backwards and forwards in turn: bits that travel against the order of the dots need one sweep as well
    while changed:
        changed, first, last = False, end, begin
        for slot in range(end - 1, begin - 1, -1):
            k = waiting[slot]
            gained, lacks = _update(np.uintp(ids[k]), word[k], link_start, link, reached)
            changed |= gained
            if lacks:
                first -= 1
                waiting[first] = k
        begin = last = first
        for slot in range(begin, end):
            k = waiting[slot]
            gained, lacks = _update(np.uintp(ids[k]), word[k], link_start, link, reached)
            changed |= gained
            if lacks:
                waiting[last] = k
                last += 1
        end = last


@njit()
def _update(
    i: np.uintp, word: np.uint64, link_start: np.ndarray, link: np.ndarray, reached: np.ndarray
) -> tuple[bool, bool]:
    """Give a dot the bits of its word that linked dots have; return whether it got any, and whether it lacks some."""
    before = bits = reached[i]
    for e in range(link_start[i], link_start[i + np.uintp(1)]):
        if bits == word:
            break
        bits |= reached[np.uintp(link[np.uintp(e)])] & word
    reached[i] = bits
    return bits != before, bits != word


@njit()
def drop_small_islands(
    ids: np.ndarray, word: np.ndarray, link_start: np.ndarray, link: np.ndarray, around: np.ndarray
) -> None:
    """Clear the bits of dots whose island cannot be the largest; bit b of `word[k]` says whether subset b keeps `ids[k]`.

    A dot with two kept neighbours is in an island of three or more dots, as are these two, and every dot of such an island is one
    or the other: all other dots are dropped, or, without such a dot, single ones. `around` (N + 1,) is 0, also on return.
    """
    linked, crowded = np.empty(len(ids), np.uint64), np.empty(len(ids), np.uint64)
    of_two = of_three = np.uint64(0)
    for k in range(len(ids)):
        around[np.uintp(ids[k])] = word[k]
    for k in range(len(ids)):
        i = np.uintp(ids[k])
        of_one_neighbour = of_two_neighbours = np.uint64(0)
        for e in range(link_start[i], link_start[i + np.uintp(1)]):
            neighbour_word = around[np.uintp(link[np.uintp(e)])]
            of_two_neighbours |= of_one_neighbour & neighbour_word
            of_one_neighbour |= neighbour_word
        linked[k], crowded[k] = word[k] & of_one_neighbour, word[k] & of_two_neighbours
        of_two |= linked[k]
        of_three |= crowded[k]
    for k in range(len(ids)):
        around[np.uintp(ids[k])] = crowded[k]
    for k in range(len(ids)):
        i = np.uintp(ids[k])
        near = crowded[k]
        for e in range(link_start[i], link_start[i + np.uintp(1)]):
            near |= around[np.uintp(link[np.uintp(e)])]
        word[k] &= near | (linked[k] & ~of_three) | ~(of_three | of_two)
    for k in range(len(ids)):
        around[np.uintp(ids[k])] = np.uint64(0)


@njit()
def _smallest_key(
    queue: np.ndarray, begin: int | np.integer, end: int | np.integer, key: np.ndarray
) -> np.int64:
    """Return the smallest key of `queue[begin:end]`."""
    smallest = np.int64(key[queue[begin]])
    for k in range(begin + 1, end):
        smallest = min(smallest, np.int64(key[queue[k]]))
    return smallest


@njit()
def patch_of(
    index: PatchIndex,
    p: int | np.integer,
    radius: float,
    in_ball: np.ndarray,
    mark: np.ndarray,
    queue: np.ndarray,
) -> tuple[int, int]:
    """Find the patch of the dot at position `p`, cut to its largest island, as the slice begin:end of `queue`."""
    n = ball(index, point(index.xyz, p), radius, in_ball)
    mark_all(mark, in_ball, n)
    slot_of_dot = 0
    for k in range(n):
        slot_of_dot = k if in_ball[k] == p else slot_of_dot
    # The search starts at p, which is mostly in the largest island
    in_ball[0], in_ball[slot_of_dot] = in_ball[slot_of_dot], in_ball[0]
    return largest_island(in_ball, n, mark, index.link_start, index.link, index.dot, queue)


def patch(index: PatchIndex, dot: int, radius: float) -> np.ndarray:
    """Return the dots of the largest island of one dot's patch (the paper, 'Zernike 2D procedure'), ascending."""
    p = int(index.position[dot])
    room = ball_bound(index, index.xyz[p : p + 1], radius) + 1
    queue = np.empty(room, np.int32)
    mark = np.zeros(len(index.dot) + 1, np.uint8)
    begin, end = patch_of(index, p, radius, np.empty(room, np.int32), mark, queue)
    return np.sort(index.dot[queue[begin:end]])


def are_fragmented(
    points: np.ndarray, normals: np.ndarray, d_link: float = D_LINK, radius: float = R_PATCH
) -> bool:
    """Return whether patches of dots (N, 3) consist of several islands, as the dots are too sparse or too unevenly spread.

    Such patches are too small, and their roughness is too high.
    """
    if len(points) == 1 or d_link < MIN_D_LINK_PER_SPACING * spacing(points):
        return True
    index = build_index(points, normals, d_link)
    in_ball = np.empty(ball_bound(index, index.xyz, radius) + 1, np.int32)
    shares = []
    for dot in np.linspace(0, len(points) - 1, min(len(points), JUDGED_PATCHES)).astype(int):
        centre = point(index.xyz, index.position[dot])
        shares.append(len(patch(index, dot, radius)) / ball(index, centre, radius, in_ball))
    return bool(np.median(shares) < MIN_SHARE_IN_ISLAND)
