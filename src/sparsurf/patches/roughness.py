"""Local roughness R_i of every dot: the published one (paper, eq. 1), or another definition of `registry`."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from sparsurf import registry
from sparsurf.arguments import checked_result
from sparsurf.bit_operations import lowest_bit
from sparsurf.errors import InputError
from sparsurf.kernels import njit
from sparsurf.patches.index import (
    ALL_BITS,
    GROUP_SIZE,
    R_PATCH,
    PatchIndex,
    balls,
    compact_groups,
    middle,
    room_around,
)
from sparsurf.patches.islands import patch_of, spread_words
from sparsurf.surfaces.vectors import point
from sparsurf.threads import parallel_map

PUBLISHED_ROUGHNESS = "published"
# Sums over a patch: of the normals, of the unit normals, of ones; the last makes a line of the cache full
N_SUMS, COUNT_OF_SUMS = 8, 6
SLICES_PER_THREAD = 4
RoughnessFunction = Callable[[PatchIndex, float, int], np.ndarray]


def roughness_of_patches(
    index: PatchIndex,
    radius: float = R_PATCH,
    threads: int = 1,
    definition: str | RoughnessFunction = PUBLISHED_ROUGHNESS,
) -> np.ndarray:
    """Compute the roughness of the patch of every dot, (N,): 1 is flat, 0 is rough."""
    choice, function = registry.load("roughness", definition, "roughness")
    values = function(index, float(radius), threads)  # an int would compile the kernels again
    if choice.is_built_in:
        return values
    values = checked_result(values, f"the roughness {choice.name!r}", (len(index.dot),))
    if not 0 <= values.min() <= values.max() <= 1:
        raise InputError(
            f"the roughness {choice.name!r} returns numbers from {values.min():g} to {values.max():g}; they must lie "
            "between 0 (rough) and 1 (flat)."
        )
    return values


def published(index: PatchIndex, radius: float, threads: int) -> np.ndarray:
    """Compute the mean cosine between the normals of a patch and their mean; 1 for a patch of one dot."""
    out, order = np.empty(len(index.dot)), compact_groups(index.xyz)
    n_groups = -(-len(out) // GROUP_SIZE)
    # Several slices for each thread, since groups in crowded places take longer; each dot has its own sum, whatever the slice
    size = -(-n_groups // (SLICES_PER_THREAD * threads))
    parallel_map(lambda a, b: _roughness(index, order, a, b, radius, out), n_groups, threads, size)
    return out


@njit()
def _roughness(
    index: PatchIndex, order: np.ndarray, first: int, last: int, radius: float, out: np.ndarray
) -> None:
    """Fill in the roughness of the groups first:last of `order`, of each member in its ball.

    The dots that links connect with the middle of the group, or else with the member, are its patch if they are more than half.
    """
    n_dots = len(index.dot)
    bits = np.uint64(1) << np.arange(GROUP_SIZE).astype(np.uint64)
    reached, mark = np.zeros(n_dots + 1, np.uint64), np.zeros(n_dots + 1, np.uint8)
    room = 1
    ids, bit_words, work = np.empty(room, np.int32), np.empty(room, np.uint64), np.empty(room, np.int32)
    centres, sums = np.empty((3, GROUP_SIZE)), np.empty((GROUP_SIZE, N_SUMS))
    table, missed = np.empty((16, 16, N_SUMS)), np.empty(GROUP_SIZE, np.int64)
    for g in range(first, last):
        members = order[g * GROUP_SIZE : min((g + 1) * GROUP_SIZE, n_dots)]
        centre, extent, root = middle(index.xyz, members)
        needed = room_around(index, centre, radius + extent) + 1
        if needed > room:
            room = 2 * needed
            ids, bit_words, work = (
                np.empty(room, np.int32),
                np.empty(room, np.uint64),
                np.empty(room, np.int32),
            )
        n = balls(index, members, centre, extent, radius, bits, centres, ids, bit_words, work)
        for k in range(n):
            if ids[k] == root:
                reached[root] = bit_words[k]
        for b in range(len(members)):
            if reached[root] & bits[b] == 0:
                reached[members[b]] |= bits[b]
        spread_words(ids, bit_words, n, index.link_start, index.link, reached, work)
        _sum_normals(index.normals, ids, bit_words, n, reached, table, sums, missed)
        for b in range(len(members)):
            p = members[b]
            # An island of more than half of the dots is the largest one; otherwise it must be searched for
            if sums[b, COUNT_OF_SUMS] > missed[b]:
                out[index.dot[p]] = _cosine(
                    sums[b, 0],
                    sums[b, 1],
                    sums[b, 2],
                    sums[b, 3],
                    sums[b, 4],
                    sums[b, 5],
                    sums[b, COUNT_OF_SUMS],
                )
            else:
                begin, end = patch_of(index, p, radius, ids, mark, work)
                out[index.dot[p]] = mean_cosine(index.normals, work, begin, end)


@njit()
def _sum_normals(
    normals: np.ndarray,
    ids: np.ndarray,
    bit_words: np.ndarray,
    n: int,
    reached: np.ndarray,
    table: np.ndarray,
    sums: np.ndarray,
    missed: np.ndarray,
) -> None:
    """Sum normals, unit normals and ones over the dots that have each bit, and count in `missed` those that should have it.

    `table[j, v]` takes the sums of the dots whose bits 4 j to 4 j + 3 are v. On return `reached` is 0 again.
    """
    table[:], missed[:] = 0.0, 0
    a = np.zeros(N_SUMS)
    everywhere = np.zeros(N_SUMS)
    for k in range(n):
        i = np.uintp(ids[k])
        word, lacking = reached[i], bit_words[k] ^ reached[i]
        reached[i] = np.uint64(0)
        while lacking:
            lowest: np.uint64 = lowest_bit(lacking)  # type: ignore[call-arg]  # numba's stub counts the typing context
            missed[np.uintp(lowest)] += 1
            lacking &= lacking - np.uint64(1)
        if word == 0:
            continue
        x, y, z = point(normals, i)
        inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
        a[0], a[1], a[2], a[3], a[4], a[5], a[6] = x, y, z, x * inverse, y * inverse, z * inverse, 1.0
        if word == ALL_BITS:
            for c in range(N_SUMS):
                everywhere[c] += a[c]
            continue
        for j in range(16):
            v = np.uintp(word & np.uint64(15))
            word >>= np.uint64(4)
            for c in range(N_SUMS):
                table[np.uintp(j), v, np.uintp(c)] += a[np.uintp(c)]
    for m in range(GROUP_SIZE):
        for c in range(N_SUMS):
            total = everywhere[c]
            for value in range(16):
                if value >> (m & 3) & 1:
                    total += table[m >> 2, value, c]
            sums[m, c] = total


@njit()
def mean_cosine(normals: np.ndarray, ids: np.ndarray, begin: int, end: int) -> float:
    """Return the mean over ids[begin:end] of cos(n_j, mean normal), at least 0; 1 for one normal. Normals have any length."""
    mx = my = mz = ux = uy = uz = 0.0
    for k in range(begin, end):
        x, y, z = point(normals, ids[k])
        inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
        mx += x
        my += y
        mz += z
        ux += x * inverse
        uy += y * inverse
        uz += z * inverse
    return _cosine(mx, my, mz, ux, uy, uz, float(end - begin))


@njit()
def _cosine(mx: float, my: float, mz: float, ux: float, uy: float, uz: float, n: float) -> float:
    """Return the mean cosine of n unit vectors with the sum (ux, uy, uz) to (mx, my, mz), at least 0; 1 for a single one."""
    # As in the authors' code, a patch of one dot is flat, and a negative mean is 0
    if n <= 1:
        return 1.0
    length = math.sqrt(mx * mx + my * my + mz * mz)
    return max(0.0, (mx * ux + my * uy + mz * uz) / (length * n)) if length > 0.0 else 0.0
