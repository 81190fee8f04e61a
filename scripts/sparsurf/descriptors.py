"""Zernike descriptors of patches, for many subsets of one surface in one pass.

Up to 64 subsets share the work per test dot: its ball is found once, and each subset is one bit
of a word per dot. Images leave the kernel folded (see `zernike`) and become descriptors in two
matrix products per block. Source of every step: paper, 'Zernike 2D procedure'.
"""

import math

import numpy as np
from numba import njit

from sparsurf import zernike
from sparsurf.images import FAST, N_EVEN, N_ODD, PLACES, TABLES, WEIGHT, WIDTH, fill_gaps, fold_image, project
from sparsurf.parallel import over_slices
from sparsurf.patches import R_ZERNIKE, ball, ball_bound, largest_island, mark_all

__all__ = ["BITS", "TABLES", "WIDTH", "add", "compare", "describe", "evaluate", "fill_gaps", "pack"]

BITS = 64  # subsets per pass
ROWS = 1024  # images per matrix product; fixed, so that results do not depend on the cores

_FOLD = zernike.fold()
N_COMPLEX, N_Z = _FOLD.odd.shape[1], _FOLD.even.shape[1]


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


def describe(index, tests, radius=R_ZERNIKE, up=True, threads=1):
    """Descriptors of the patches of a whole surface.

    Parameters
    ----------
    index : patches.Index
    tests : (T, 3) float64
        Å, points around which the patches are cut.
    radius : float
        R_zernike in Å.
    up : bool
        Whether the mean normal is turned to +z ('up') or to -z ('down').
    threads : int

    Returns
    -------
    z : (T, 121) float64
        |c_nm| in the order of `zernike.indices`; zero for an empty image (a patch of one dot).
    sizes : (T,) int32
        Dots in each patch.
    """
    out = np.empty((len(tests), N_Z))

    def keep(a, b, real, imaginary):
        _moduli(real, imaginary, out[a:b])

    sizes = _images(index, tests, np.empty(0, np.uint64), 0, (), 1, radius, up, threads, None, keep)
    return _in_order(out), sizes[:, 0]


def evaluate(
    index, tests, words, n_subsets, reading, z_tot=None, weights=None, radius=R_ZERNIKE, up=True, threads=1
):
    """Descriptors of the patches of several subsets, or their distances to given ones.

    Parameters
    ----------
    index : patches.Index
    tests : (T, 3) float64
        Å.
    words : (N,) uint64
        See `pack`.
    n_subsets : int
        B, at most 64.
    reading : {'kept', 'surface'}
        Islands are removed among the kept dots, or once on the full surface.
    z_tot : (T, 121) float64, optional
        Descriptors of the whole surface, in the order of `describe`.
    weights : (B, N) float64, optional
        Weight of each dot, by position, in centroid, mean normal and pixel means; 1 without.

    Returns
    -------
    (T, B) float64 distances |z_tot - z| where `z_tot` is given, else (T, B, 121) descriptors in
    the kernel's own order; and (T, B) int32, dots in each evaluated patch.
    """
    if z_tot is not None:
        return compare(index, tests, words, n_subsets, (reading,), z_tot, weights, radius, up, threads)[1:]
    out = np.empty((len(tests), n_subsets, N_Z))

    def keep(a, b, real, imaginary):
        _moduli(real, imaginary, out[a:b].reshape(-1, N_Z))

    sizes = _images(index, tests, words, n_subsets, (reading,), 0, radius, up, threads, weights, keep)
    return out, sizes


def compare(
    index, tests, words, n_subsets, readings, z_tot=None, weights=None, radius=R_ZERNIKE, up=True, threads=1
):
    """Distances of the patches of several subsets to those of the whole surface, under R readings in one pass.

    Parameters
    ----------
    index, tests, words, n_subsets, weights : as for `evaluate`
    readings : tuple of {'kept', 'surface'}
    z_tot : (T, 121) float64, optional
        Descriptors of the whole surface where already known.

    Returns
    -------
    z_tot : (T, 121) float64
    z : (T, R B) float64, |z_tot - z| of all subsets under the first reading, then under the next
    sizes : (T, R B) int32, dots in each evaluated patch
    """
    whole = int(z_tot is None)
    target = np.empty((len(tests), N_Z)) if whole else np.ascontiguousarray(z_tot[:, _FOLD.order])
    out = np.empty((len(tests), len(readings) * n_subsets))

    def keep(a, b, real, imaginary):
        if whole:
            rows = slice(None, None, out.shape[1] + 1)
            _moduli(np.ascontiguousarray(real[rows]), np.ascontiguousarray(imaginary[rows]), target[a:b])
        _distances(real, imaginary, whole, target[a:b], out[a:b])

    sizes = _images(index, tests, words, n_subsets, readings, whole, radius, up, threads, weights, keep)
    return _in_order(target) if whole else z_tot, out, sizes[:, whole:]


def _in_order(z):
    """Descriptors in the kernel's order to that of `zernike.indices`."""
    out = np.empty_like(z)
    out[:, _FOLD.order] = z
    return out


def _images(index, tests, words, n_subsets, readings, whole, radius, up, threads, weights, keep):
    """Hand c_nm of the images of slices of the tests to `keep(begin, end, real, imaginary)`; returns patch sizes.

    The images of a test: that of its whole patch (`whole` 1, or 0 for none), of the subsets under the first reading,
    under the next.
    """
    tests = np.ascontiguousarray(tests, np.float64)
    weights = np.empty((0, 0)) if weights is None else weights
    kept = np.array([reading == "kept" for reading in readings], np.bool_)
    room = ball_bound(index, tests, radius) + 1
    sizes = np.empty((len(tests), whole + len(readings) * n_subsets), np.int32)
    sign = 1.0 if up else -1.0

    def block(a, b):
        images = np.empty(((b - a) * sizes.shape[1], N_EVEN + N_ODD))
        patch_images(
            index, tests[a:b], words, n_subsets, weights, radius, sign, kept, room, images, sizes[a:b], TABLES
        )
        keep(a, b, images[:, :N_EVEN] @ _FOLD.even, images[:, N_EVEN:] @ _FOLD.odd)

    over_slices(block, len(tests), threads, max(1, ROWS // sizes.shape[1]))
    return sizes


@njit(cache=True, nogil=True, fastmath=FAST)
def _moduli(real, imaginary, out):
    for i in range(len(real)):
        for k in range(N_COMPLEX):
            out[i, k] = math.sqrt(real[i, k] ** 2 + imaginary[i, k] ** 2)
        for k in range(N_COMPLEX, N_Z):
            out[i, k] = abs(real[i, k])


@njit(cache=True, nogil=True, fastmath=FAST)
def _distances(real, imaginary, skip, target, out):
    """Distances to the target of each test; of its rows the first `skip` are left out."""
    for t in range(len(out)):
        for b in range(out.shape[1]):
            i = t * (skip + out.shape[1]) + skip + b
            total = 0.0
            for k in range(N_COMPLEX):
                total += (math.sqrt(real[i, k] ** 2 + imaginary[i, k] ** 2) - target[t, k]) ** 2
            for k in range(N_COMPLEX, N_Z):
                total += (abs(real[i, k]) - target[t, k]) ** 2
            out[t, b] = math.sqrt(total)


@njit(cache=True, nogil=True)
def patch_images(index, tests, words, n_subsets, weights, radius, sign, kept, room, images, sizes, tables):
    """Folded images in the order of `_images`; `kept`: whether each reading removes islands among the kept dots."""
    found, queue, ids = np.empty(room, np.int32), np.empty(room, np.int32), np.empty(room, np.int32)
    island, word, work = np.empty(room, np.int32), np.empty(room, np.uint64), np.empty((9, room))
    work[WEIGHT] = 1.0
    mark = np.zeros(len(index.dot) + 1, np.uint8)
    image, filled = np.empty((2, PLACES + WIDTH)), np.empty(zernike.PIXELS, np.uint32)
    whole = sizes.shape[1] - len(kept) * n_subsets
    row = 0
    for t in range(len(tests)):
        n = ball(index, tests[t, 0], tests[t, 1], tests[t, 2], radius, found)
        if whole > 0 or not kept.all():  # the island of the full surface comes once for all subsets
            mark_all(mark, found, n)
            begin, end = largest_island(found, n, mark, index.link_start, index.link, index.dot, queue)
            n_island = end - begin
            island[:n_island] = queue[begin:end]
        if whole > 0:
            sizes[t, 0] = n_island
            _image(index, island[:n_island], tests[t], sign, work, image, filled, tables, images[row])
            row += 1
        for r in range(len(kept)):
            dots = found[:n] if kept[r] else island[:n_island]
            for k in range(len(dots)):
                word[k] = words[np.uintp(dots[k])]
            for b in range(n_subsets):
                m, shift = 0, np.uint64(b)
                for k in range(len(dots)):
                    ids[np.uintp(m)] = dots[k]
                    m += np.intp((word[k] >> shift) & np.uint64(1))
                chosen = ids[:m]
                if kept[r]:
                    mark_all(mark, ids, m)
                    begin, end = largest_island(ids, m, mark, index.link_start, index.link, index.dot, queue)
                    chosen = queue[begin:end]
                if len(weights):
                    for k in range(len(chosen)):
                        work[WEIGHT, k] = weights[b, chosen[k]]
                sizes[t, whole + r * n_subsets + b] = len(chosen)
                _image(index, chosen, tests[t], sign, work, image, filled, tables, images[row])
                row += 1


@njit(cache=True, nogil=True)
def _image(index, ids, centre, sign, work, image, filled, tables, out):
    """Folded image of one patch; all zero where it has no extent."""
    out[:] = 0.0
    if len(ids) > 1 and project(index.xyz, index.normals, ids, centre, sign, work, image, filled):
        fill_gaps(image[0], filled, tables[3], tables[4])
        fold_image(image[0], tables[0], tables[1], tables[2], out)
