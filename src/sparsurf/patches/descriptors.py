"""Descriptors of patches, for many subsets of one surface in one pass.

`subset_patches` decides which dots a patch holds, and a descriptor of `registry` which numbers describe them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from sparsurf import registry
from sparsurf.arguments import checked_result
from sparsurf.kernels import njit
from sparsurf.patches.index import R_ZERNIKE, PatchIndex, ball_bound, build_index
from sparsurf.patches.readings import ReadingLike, reading_of
from sparsurf.patches.subset_patches import (
    MAX_SUBSETS,
    add_subset,
    hashes_of_dots,
    nested_patches_of,
    new_patches,
    pack_subsets,
    patches_of,
)
from sparsurf.patches.zernike import rotation_robust
from sparsurf.patches.zernike.images import Descriptor, Patches
from sparsurf.threads import parallel_map

__all__ = [
    "MAX_SUBSETS",
    "PUBLISHED",
    "add_subset",
    "compare_descriptors",
    "compare_many",
    "compare_nested",
    "describe_patches",
    "descriptor_of",
    "pack_subsets",
    "patch_sizes",
]

PATCHES_PER_CALL = 512  # of a descriptor; fixed, so that results do not depend on the number of cores
# Test dots whose patches in many subsets share one table of descriptors. Equal patches occur at the same test dot alone, so that
# a table of more test dots would be larger and find no more.
TESTS_PER_SLICE = 4
PUBLISHED = "published"


DescriptorLike = str | Callable[[Patches], np.ndarray]
# Dots along a side of a flat patch, and its radius, Å: the patch shows how many numbers a function returns
PROBE_DOTS, FLAT_PATCH_RADIUS = 12, 2.0


def descriptor_of(value: DescriptorLike) -> Descriptor:
    """Return the descriptor of a name or a function; raise InputError if it returns no table of numbers."""
    choice, found = registry.load("descriptor", value, "descriptor")
    if isinstance(found, Descriptor):
        return found
    name = f"the descriptor {choice.name!r}"
    side = np.linspace(-FLAT_PATCH_RADIUS, FLAT_PATCH_RADIUS, PROBE_DOTS)
    flat = np.zeros((PROBE_DOTS**2, 3))
    flat[:, :2] = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    index = build_index(flat, np.tile([0.0, 0.0, 1.0], (len(flat), 1)), FLAT_PATCH_RADIUS)
    ids, start = np.arange(len(flat), dtype=np.int32), np.array([0, len(flat)])
    probe = Patches(index, ids, start, np.zeros((1, 3)), np.empty(0), FLAT_PATCH_RADIUS, True)
    width = checked_result(found(probe), name, (1, None)).shape[1]

    def describe_patches(patches: Patches) -> np.ndarray:
        return checked_result(found(patches), name, (len(patches.centres), width))

    return Descriptor(width, lambda: np.arange(width), describe_patches)


def describe_patches(
    index: PatchIndex,
    tests: np.ndarray,
    radius: float = R_ZERNIKE,
    up: bool = True,
    threads: int = 1,
    descriptor: DescriptorLike = PUBLISHED,
) -> tuple[np.ndarray, np.ndarray]:
    """Compute descriptors (T, width) of patches at `tests` (T, 3), Å, turned to +z (`up`) or -z; and the dots in each, (T,)."""
    kind = descriptor_of(descriptor)
    z, sizes = _describe_whole(kind, index, tests, radius, up, threads)
    return _in_order(kind, z), sizes


def describe_fields_of_patches(
    index: PatchIndex, tests: np.ndarray, values: np.ndarray, radius: float = R_ZERNIKE, threads: int = 1
) -> np.ndarray:
    """Compute Zernike invariants (T, F, 121) of fields (F, N), by dot, over patches at `tests` (T, 3), Å, in their units."""
    values = np.ascontiguousarray(np.asarray(values, np.float64)[:, index.dot])
    describe_values = partial(rotation_robust.describe_fields, values=values)
    kind = Descriptor(len(values) * rotation_robust.N_Z, rotation_robust.order, describe_values)
    z = _describe_whole(kind, index, tests, radius, True, threads)[0].reshape(len(tests), len(values), -1)
    ordered = np.empty_like(z)
    ordered[:, :, rotation_robust.order()] = z
    return ordered


def _describe_whole(
    kind: Descriptor, index: PatchIndex, tests: np.ndarray, radius: float, up: bool, threads: int
) -> tuple[np.ndarray, np.ndarray]:
    """Compute descriptors of whole patches in the kernel's order, (T, width), and the dots in each, (T,)."""
    out = np.empty((len(tests), kind.width))

    def store(a: int, b: int, z: np.ndarray) -> None:
        out[a:b] = z

    no_subsets = np.empty(0, np.uint64)
    sizes = _describe_slices(kind, index, tests, no_subsets, 0, (), True, radius, up, threads, None, store)
    return out, sizes[:, 0]


def compare_descriptors(
    index: PatchIndex,
    tests: np.ndarray,
    bit_words: np.ndarray,
    n_subsets: int,
    readings: Sequence[ReadingLike],
    z_tot: np.ndarray | None = None,
    weights: np.ndarray | None = None,
    radius: float = R_ZERNIKE,
    up: bool = True,
    threads: int = 1,
    descriptor: DescriptorLike = PUBLISHED,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Compute distances of patches of subsets to those of the whole surface, whose weights are 1, under R readings in one pass.

    The B <= 64 subsets are the `bit_words` of `pack_subsets`, with `weights` (B, N) by position, and `tests` (T, 3) in Å. Returns
    z_tot, (T, width), which is computed if not given; the distances |z_tot - z|, reading by reading, and the dots, (T, R B).
    """
    kind, n_whole = descriptor_of(descriptor), int(z_tot is None)
    out = np.empty((len(tests), len(readings) * n_subsets))
    in_kernel_order = np.empty((len(tests), kind.width)) if z_tot is None else z_tot[:, kind.order()]
    target = np.ascontiguousarray(in_kernel_order)

    def store(a: int, b: int, z: np.ndarray) -> None:
        if n_whole:
            target[a:b] = z[:: out.shape[1] + 1]
        test = np.repeat(np.arange(a, b), n_whole + out.shape[1])
        out[a:b] = _distances(z, target, test).reshape(b - a, -1)[:, n_whole:]

    sizes = _describe_slices(
        kind, index, tests, bit_words, n_subsets, readings, n_whole > 0, radius, up, threads, weights, store
    )
    return _in_order(kind, target) if z_tot is None else z_tot, out, sizes[:, n_whole:]


def patch_sizes(
    index: PatchIndex,
    tests: np.ndarray,
    bit_words: np.ndarray,
    n_subsets: int,
    readings: Sequence[ReadingLike],
    radius: float = R_ZERNIKE,
    threads: int = 1,
) -> np.ndarray:
    """Count the dots of patches of subsets, (T, R B), without describing them; arguments are those of `compare_descriptors`."""
    undescribed = Descriptor(0, lambda: np.arange(0), lambda patches: np.empty((len(patches.centres), 0)))
    return _describe_slices(
        undescribed, index, tests, bit_words, n_subsets, readings, False, radius, True, threads, None, lambda *_: None
    )  # fmt: skip


def compare_nested(
    index: PatchIndex,
    tests: np.ndarray,
    order: np.ndarray,
    n_kept: np.ndarray,
    readings: Sequence[ReadingLike],
    z_tot: np.ndarray,
    radius: float = R_ZERNIKE,
    threads: int = 1,
    descriptor: DescriptorLike = PUBLISHED,
) -> tuple[np.ndarray, np.ndarray]:
    """Compute distances to the whole surface, and dots in patches, (R, S, T), of the first `n_kept` (S,) dots of `order`."""
    tests, radius, among_kept, buffer_size = _for_kernels(index, tests, radius, readings)
    n_kept, kind = np.ascontiguousarray(n_kept, np.int64), descriptor_of(descriptor)
    rank = np.empty(len(order), np.int64)
    rank[index.position[order]] = np.arange(len(order))
    target = np.ascontiguousarray(z_tot[:, kind.order()])
    shape = (len(readings), len(n_kept), len(tests))
    z, sizes = np.empty(shape), np.empty(shape, np.int32)

    def compare_slice(a: int, b: int) -> None:
        rows = (b - a) * len(readings) * min(len(n_kept), buffer_size)
        ids, start = np.empty(rows * buffer_size, np.int32), np.empty(rows + 1, np.int64)
        test, patch = np.empty(rows, np.int64), np.empty((*shape[:2], b - a), np.int64)
        n = nested_patches_of(
            index, tests[a:b], rank, n_kept, radius, among_kept, buffer_size, ids, start, test, patch
        )
        start, test = start[: n + 1], test[:n] + a
        patches = Patches(index, ids, start, tests[test], np.empty(0), radius, True)
        described = kind.describe(patches)
        z[:, :, a:b] = _distances(described, target, test)[patch]
        sizes[:, :, a:b] = np.diff(start)[patch]

    parallel_map(
        compare_slice, len(tests), threads, max(1, PATCHES_PER_CALL // (len(readings) * len(n_kept)))
    )
    return z, sizes


def compare_many(
    index: PatchIndex,
    tests: np.ndarray,
    bit_words: np.ndarray,
    n_subsets: int,
    readings: Sequence[ReadingLike],
    z_tot: np.ndarray,
    radius: float = R_ZERNIKE,
    threads: int = 1,
    descriptor: DescriptorLike = PUBLISHED,
) -> tuple[np.ndarray, np.ndarray]:
    """Compute distances to the whole surface, and dots in patches, (R, B, T), of any number of subsets B.

    Row w of `bit_words`, (B / 64, N) uint64, holds subsets 64 w to 64 w + 63 as `pack_subsets` does. Subsets that share most dots
    have many equal patches: each distinct patch of a test is described once.
    """
    tests, radius, among_kept, buffer_size = _for_kernels(index, tests, radius, readings)
    kind, hashes = descriptor_of(descriptor), hashes_of_dots(max(len(index.dot), len(tests)))
    target = np.ascontiguousarray(z_tot[:, kind.order()])
    z = np.empty((len(readings), n_subsets, len(tests)))
    sizes = np.empty(z.shape, np.int32)
    # At most half of the table is in use, so that a free place is always found, and soon
    n_keys = 1 << (2 * len(readings) * n_subsets * TESTS_PER_SLICE).bit_length()
    no_weights = np.empty((0, 0)), np.empty(0)

    def compare_slice(a: int, b: int) -> None:
        mark, around = np.zeros(len(index.dot) + 1, np.uint8), np.zeros(len(index.dot) + 1, np.uint64)
        keys, distances = np.zeros(n_keys, np.uint64), np.empty(n_keys)
        max_patches = (b - a) * len(readings) * min(MAX_SUBSETS, n_subsets)
        ids, start = np.empty(max_patches * buffer_size, np.int32), np.empty(max_patches + 1, np.int64)
        places, rows = np.empty(max_patches, np.int64), np.empty(max_patches, np.int64)
        # The table outlives the words: a patch that subsets of two words share is described once
        for w, word in enumerate(bit_words):
            subsets = slice(w * MAX_SUBSETS, min((w + 1) * MAX_SUBSETS, n_subsets))
            width = subsets.stop - subsets.start
            size = np.empty((b - a, len(readings) * width), np.int32)
            patches_of(
                index, tests[a:b], word, width, no_weights[0], radius, among_kept, buffer_size, mark, around, size,
                ids, start, no_weights[1],
            )  # fmt: skip
            place = places[: size.size]
            n = new_patches(ids, start, size.shape[1], hashes, keys, place, rows)
            test = a + rows[:n] // size.shape[1]
            described = kind.describe(
                Patches(index, ids, start[: n + 1], tests[test], no_weights[1], radius, True)
            )
            distances[place[rows[:n]]] = _distances(described, target, test)
            shape = (b - a, len(readings), width)
            z[:, subsets, a:b] = distances[place].reshape(shape).transpose(1, 2, 0)
            sizes[:, subsets, a:b] = size.reshape(shape).transpose(1, 2, 0)

    parallel_map(compare_slice, len(tests), threads, TESTS_PER_SLICE)
    return z, sizes


def _for_kernels(
    index: PatchIndex, tests: np.ndarray, radius: float, readings: Sequence[ReadingLike]
) -> tuple[np.ndarray, float, np.ndarray, int]:
    """Return centres and radius as kernels take them, which readings link only kept dots, and the size of a buffer of a patch."""
    tests = np.ascontiguousarray(tests, np.float64)
    radius = float(radius)  # an int would compile the kernels again
    among_kept = np.array([reading_of(reading).among_kept for reading in readings], np.bool_)
    return tests, radius, among_kept, ball_bound(index, tests, radius) + 1


def _in_order(kind: Descriptor, z: np.ndarray) -> np.ndarray:
    """Bring descriptors from the kernel's order to that of users."""
    out = np.empty_like(z)
    out[:, kind.order()] = z
    return out


def _describe_slices(
    kind: Descriptor,
    index: PatchIndex,
    tests: np.ndarray,
    bit_words: np.ndarray,
    n_subsets: int,
    readings: Sequence[ReadingLike],
    whole: bool,
    radius: float,
    up: bool,
    threads: int,
    weights: np.ndarray | None,
    store: Callable[[int, int, np.ndarray], None],
) -> np.ndarray:
    """Pass descriptors of slices of the tests (whole patch, then each reading) to `store(begin, end, z)`; return patch sizes."""
    tests, radius, among_kept, buffer_size = _for_kernels(index, tests, radius, readings)
    weights = np.empty((0, 0)) if weights is None else weights
    sizes = np.empty((len(tests), int(whole) + len(readings) * n_subsets), np.int32)
    idle_buffers: list[tuple[np.ndarray, np.ndarray]] = []  # of threads that wait

    def describe_slice(a: int, b: int) -> None:
        # The kernel leaves the buffers 0, so that later slices need not allocate and clear them again
        n = len(index.dot) + 1
        buffers = idle_buffers.pop() if idle_buffers else (np.zeros(n, np.uint8), np.zeros(n, np.uint64))
        rows = (b - a) * sizes.shape[1]
        ids, start = np.empty(rows * buffer_size, np.int32), np.empty(rows + 1, np.int64)
        weight = np.empty(len(ids) if len(weights) else 0)
        patches_of(
            index, tests[a:b], bit_words, n_subsets, weights, radius, among_kept, buffer_size, buffers[0], buffers[1],
            sizes[a:b], ids, start, weight,
        )  # fmt: skip
        idle_buffers.append(buffers)
        centres = np.repeat(tests[a:b], sizes.shape[1], axis=0)
        store(a, b, kind.describe(Patches(index, ids, start, centres, weight, radius, up)))

    parallel_map(describe_slice, len(tests), threads, max(1, PATCHES_PER_CALL // sizes.shape[1]))
    return sizes


@njit()
def _distances(z: np.ndarray, target: np.ndarray, test: np.ndarray) -> np.ndarray:
    """Compute the distance of each descriptor to the target of its test."""
    out = np.empty(len(z))
    for i in range(len(z)):
        total = 0.0
        for k in range(z.shape[1]):
            total += (z[i, k] - target[test[i], k]) ** 2
        out[i] = math.sqrt(total)
    return out
