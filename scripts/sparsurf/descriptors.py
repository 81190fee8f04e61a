"""Zernike descriptors of patches, for many subsets of one surface in one pass.

Up to 64 subsets share the work per test dot: the patch of the full surface is found and its
links are copied once, and each subset is one bit of a word per dot. Images leave the kernel
folded (see `zernike`) and become descriptors in two matrix products per block.
Source of every step: paper, 'Zernike 2D procedure'; values the text omits: authors' scripts.
"""

import math

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from sparsurf import zernike
from sparsurf.parallel import over_slices
from sparsurf.patches import R_ZERNIKE, ROW, ball, ball_bound, largest_island

MARGIN = 1.01  # the image reaches this many times the largest distance from the axis
ROUNDS = 50  # of gap filling, at most
WIDTH = 32  # pixels stored per image row: a row's occupancy is one machine word
BITS = 64  # subsets per pass
ROWS = 1024  # images per matrix product; fixed, so that results do not depend on the cores
FAST = {"nnan", "ninf", "nsz", "arcp", "contract", "reassoc"}

_FOLD = zernike.fold()
_wide = lambda flat: (flat // zernike.PIXELS * WIDTH + flat % zernike.PIXELS).astype(np.int32)  # noqa: E731
_FIRST, _SECOND, _DIAGONAL = _wide(_FOLD.first), _wide(_FOLD.second), _wide(_FOLD.diagonal)
N_EVEN, N_ODD = len(_FOLD.even), len(_FOLD.odd)
N_COMPLEX, N_Z = _FOLD.odd.shape[1], _FOLD.even.shape[1]


def _open_disc():
    """Word per image row: the pixels strictly inside the disc, where gaps are filled."""
    k = np.arange(zernike.PIXELS)
    inside = (k[:, None] - zernike.DISC) ** 2 + (k[None, :] - zernike.DISC) ** 2 < zernike.DISC**2
    return (inside * (1 << k)[None, :]).sum(axis=1).astype(np.uint32)


_OPEN = _open_disc()
_INVERSE = np.concatenate([[0.0], 1.0 / np.arange(1, 10)])


@intrinsic
def _lowest_bit(typing, x):
    """Index of the lowest set bit of a uint32 (undefined for 0)."""

    def build(context, builder, signature, args):
        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 0))

    return types.uint32(types.uint32), build


@intrinsic
def _count_bits(typing, x):
    """Number of set bits of a uint32."""
    return types.uint32(types.uint32), lambda context, builder, signature, args: builder.ctpop(args[0])


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
        _set_bit(words, index.position, np.asarray(subset, np.int64), np.uint64(1 << bit))
    return words


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
    everything = np.ones(len(index.dot), np.uint64)
    z, sizes = evaluate(index, tests, everything, 1, "surface", radius=radius, up=up, threads=threads)
    out = np.empty_like(z[:, 0])
    out[:, _FOLD.order] = z[:, 0]
    return out, sizes[:, 0]


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
    tests = np.ascontiguousarray(tests, np.float64)
    weights = np.empty((0, 0)) if weights is None else weights
    target = np.empty((0, N_Z)) if z_tot is None else np.ascontiguousarray(z_tot[:, _FOLD.order])
    room = ball_bound(index, tests, radius) + 1
    shape = (len(tests), n_subsets)
    out = np.empty((*shape, N_Z)) if z_tot is None else np.empty(shape)
    sizes = np.empty(shape, np.int32)
    sign = 1.0 if up else -1.0

    def block(a, b):
        images = np.empty(((b - a) * n_subsets, N_EVEN + N_ODD))
        patch_images(
            index,
            tests[a:b],
            words,
            weights,
            radius,
            sign,
            reading == "kept",
            room,
            images,
            sizes[a:b],
            TABLES,
        )
        real, imaginary = images[:, :N_EVEN] @ _FOLD.even, images[:, N_EVEN:] @ _FOLD.odd
        if z_tot is None:
            _moduli(real, imaginary, out[a:b].reshape(-1, N_Z))
        else:
            _distances(real, imaginary, target[a:b], out[a:b])

    over_slices(block, len(tests), threads, max(1, ROWS // n_subsets))
    return out, sizes


@njit(cache=True, nogil=True, fastmath=FAST)
def _moduli(real, imaginary, out):
    for i in range(len(real)):
        for k in range(N_COMPLEX):
            out[i, k] = math.sqrt(real[i, k] ** 2 + imaginary[i, k] ** 2)
        for k in range(N_COMPLEX, N_Z):
            out[i, k] = abs(real[i, k])


@njit(cache=True, nogil=True, fastmath=FAST)
def _distances(real, imaginary, target, out):
    n_subsets = out.shape[1]
    for i in range(len(real)):
        t = i // n_subsets
        total = 0.0
        for k in range(N_COMPLEX):
            total += (math.sqrt(real[i, k] ** 2 + imaginary[i, k] ** 2) - target[t, k]) ** 2
        for k in range(N_COMPLEX, N_Z):
            total += (abs(real[i, k]) - target[t, k]) ** 2
        out[t, i - t * n_subsets] = math.sqrt(total)


@njit(cache=True, nogil=True)
def patch_images(index, tests, words, weights, radius, sign, kept, room, images, sizes, tables):
    """Folded image of every (test, subset); rows of `images` run over the subsets of one test first."""
    n_dots, n_subsets = len(index.dot), sizes.shape[1]
    local = np.full(n_dots + 1, -1, np.int32)  # place of a position in the ball at hand
    found, queue, ids = np.empty(room, np.int32), np.empty(room, np.int32), np.empty(room, np.int32)
    key, mark, word = np.empty(room, np.int32), np.zeros(room, np.uint8), np.empty(room, np.uint64)
    link_start, link = np.empty(room + 1, np.int64), np.empty(room * (ROW + 4), np.int32)
    geometry, work = np.empty((room, 6)), np.empty((6, room))
    work[5] = 1.0  # the weights
    image, filled = np.empty((2, zernike.PIXELS * WIDTH + WIDTH)), np.empty(zernike.PIXELS, np.uint32)
    for t in range(len(tests)):
        n = ball(index, tests[t, 0], tests[t, 1], tests[t, 2], radius, found)
        link = _local_graph(index, tests[t], words, found, n, local, geometry, key, word, link_start, link)
        mark[n] = 0
        if not kept:  # the island of the full surface comes first, once for all subsets
            for k in range(n):
                mark[k], ids[k] = 1, k
            begin, end = largest_island(ids, n, mark, link_start, link, key, queue)
            island = queue[begin:end].copy()
        for b in range(n_subsets):
            m = 0
            shift = np.uint64(b)
            if kept:
                for k in range(n):
                    bit = np.uint8((word[k] >> shift) & np.uint64(1))
                    mark[k], ids[m] = bit, k
                    m += bit
                begin, end = largest_island(ids, m, mark, link_start, link, key, queue)
                chosen, m = queue[begin:end], end - begin
            else:
                for k in island:
                    ids[m] = k
                    m += np.intp((word[k] >> shift) & np.uint64(1))
                chosen = ids[:m]
            if len(weights):
                for k in range(m):
                    work[5, k] = weights[b, found[chosen[k]]]
            sizes[t, b] = m
            row = images[t * n_subsets + b]
            row[:] = 0.0
            if m > 1 and project(geometry, chosen, sign, work, image, filled):
                fill_gaps(image[0], filled, tables[3], tables[4])
                _fold_image(image[0], tables[0], tables[1], tables[2], row)


@njit(cache=True, nogil=True)
def _local_graph(index, centre, words, found, n, local, geometry, key, word, link_start, link):
    """Copy the ball `found[:n]`: coordinates relative to its centre, normals, words, keys and links."""
    for k in range(n):
        local[found[k]] = k
    tail = 0
    for k in range(n):
        p = found[k]
        for c in range(3):
            geometry[k, c] = index.xyz[p, c] - centre[c]
            geometry[k, 3 + c] = index.normals[p, c]
        key[k], word[k], link_start[k] = index.dot[p], words[p], tail
        row, row_end = index.link_start[p], index.link_start[p + 1]
        if tail + row_end - row + ROW > len(link):
            link = np.concatenate((link, np.empty(len(link) + row_end - row, np.int32)))
        least = tail + ROW
        for e in range(row, row_end):
            j = local[index.link[e]]
            link[tail] = j
            tail += 1 if j >= 0 else 0
        while tail < least:
            link[tail] = n
            tail += 1
    link_start[n] = tail
    for k in range(n):
        local[found[k]] = -1
    return link


@njit(cache=True, nogil=True, fastmath=FAST)
def project(geometry, ids, sign, work, image, filled):
    """Orient a patch, set the cone and average the distances to its apex per pixel.

    Fills image[0] with the mean distance r (0 where no dot falls) and `filled` with its
    occupancy. Returns False where all dots lie on the axis, so that the image has no extent.
    """
    n = len(ids)
    u, v, w, r, pixel, weight = work
    cx = cy = cz = mx = my = mz = total = 0.0
    for k in range(n):
        a = ids[k]
        g = weight[k]
        u[k], v[k], w[k] = geometry[a, 0], geometry[a, 1], geometry[a, 2]
        cx += g * u[k]
        cy += g * v[k]
        cz += g * w[k]
        mx += g * geometry[a, 3]
        my += g * geometry[a, 4]
        mz += g * geometry[a, 5]
        total += g
    cx, cy, cz = cx / total, cy / total, cz / total
    across = math.sqrt(mx * mx + my * my)
    length = math.sqrt(across * across + mz * mz)
    c1, s1 = (my / across, mx / across) if across > 0.0 else (1.0, 0.0)
    c2, s2 = (sign * mz / length, sign * across / length) if length > 0.0 else (sign, 0.0)
    furthest = 0.0
    apex = np.inf
    for k in range(n):  # about z into the y-z plane, then about x onto the z axis
        x, y, z = u[k] - cx, v[k] - cy, w[k] - cz
        y1 = s1 * x + c1 * y
        u[k] = c1 * x - s1 * y
        v[k] = c2 * y1 - s2 * z
        w[k] = s2 * y1 + c2 * z
        r[k] = u[k] * u[k] + v[k] * v[k]
        furthest = max(furthest, r[k])
        apex = min(apex, w[k] - math.sqrt(r[k]))
    if furthest == 0.0:
        return False
    edge = math.sqrt(furthest) * MARGIN
    scale = zernike.PIXELS / (2 * edge)
    offset = edge * scale
    for k in range(n):
        column = max(math.ceil(u[k] * scale + offset) - 1.0, 0.0)
        row = max(math.ceil(offset - v[k] * scale) - 1.0, 0.0)
        pixel[k] = row * WIDTH + column
        z = w[k] - apex
        r[k] = math.sqrt(r[k] + z * z)
    image[:] = 0.0
    for k in range(n):
        p = np.intp(pixel[k])
        image[0, p] += weight[k] * r[k]
        image[1, p] += weight[k]
    for p in range(zernike.PIXELS * WIDTH):
        image[0, p] /= image[1, p] if image[1, p] > 0.0 else 1.0
    for i in range(zernike.PIXELS):
        bits = np.uint32(0)
        for j in range(zernike.PIXELS):
            bits |= np.uint32(image[0, i * WIDTH + j] != 0.0) << np.uint32(j)
        filled[i] = bits
    return True


@njit(cache=True, nogil=True, inline="always")
def _block_mean(image, filled, i, j, inverse):
    """Mean of the filled pixels of the 3 x 3 block around an empty pixel."""
    p = np.intp(i * WIDTH + j)
    above = image[p - WIDTH - 1] + image[p - WIDTH] + image[p - WIDTH + 1]
    below = image[p + WIDTH - 1] + image[p + WIDTH] + image[p + WIDTH + 1]
    shift, three = np.uint32(j - 1), np.uint32(7)
    n = (filled[i - 1] >> shift) & three
    n |= ((filled[i] >> shift) & three) << np.uint32(3)
    n |= ((filled[i + 1] >> shift) & three) << np.uint32(6)
    return (above + below + (image[p - 1] + image[p + 1])) * inverse[_count_bits(np.uint32(n))]


@njit(cache=True, nogil=True)
def fill_gaps(image, filled, open_disc, inverse):
    """Fill empty pixels strictly inside the disc, in place and in row-major order.

    First, while anything changes: pixels between two filled ones of their row or column, then
    pixels between two filled ones of a diagonal. After that every pixel with a filled
    neighbour. Rows are words, so that finding the next pixel to fill is bit arithmetic.
    """
    one = np.uint32(1)
    last = zernike.PIXELS - 1
    for _ in range(ROUNDS):
        changed = False
        left = np.uint32(0)
        for i in range(1, last):
            todo = np.uint32(open_disc[i] & ~filled[i])
            column = np.uint32(filled[i - 1] & filled[i + 1])
            while todo:  # a pixel filled here can enable the next ones of its row
                here = filled[i]
                ready = np.uint32(todo & (column | ((here << one) & (here >> one))))
                if ready == 0:
                    break
                bit = np.uint32(one << _lowest_bit(ready))
                j = np.intp(_lowest_bit(ready))
                image[i * WIDTH + j] = _block_mean(image, filled, i, j, inverse)
                filled[i] = here | bit
                todo = np.uint32(todo & ~(bit | (bit - one)))
                changed = True
        for i in range(1, last):
            todo = np.uint32(open_disc[i] & ~filled[i])
            up, down = filled[i - 1], filled[i + 1]
            ready = np.uint32(todo & (((down >> one) & (up << one)) | ((up >> one) & (down << one))))
            left |= todo & ~ready
            while ready:
                j = np.intp(_lowest_bit(ready))
                image[i * WIDTH + j] = _block_mean(image, filled, i, j, inverse)
                filled[i] |= ready & (~ready + one)
                ready = np.uint32(ready & (ready - one))
                changed = True
        if left == 0:
            return
        if not changed:
            break
    for _ in range(ROUNDS):
        changed = False
        left = np.uint32(0)
        for i in range(1, last):
            todo = np.uint32(open_disc[i] & ~filled[i])
            beside = np.uint32(filled[i - 1] | filled[i + 1])
            beside = np.uint32(beside | (beside << one) | (beside >> one))
            while todo:
                here = filled[i]
                ready = np.uint32(todo & (beside | (here << one) | (here >> one)))
                if ready == 0:
                    break
                bit = np.uint32(one << _lowest_bit(ready))
                j = np.intp(_lowest_bit(ready))
                image[i * WIDTH + j] = _block_mean(image, filled, i, j, inverse)
                filled[i] = here | bit
                todo = np.uint32(todo & ~(bit | (bit - one)))
                changed = True
            left |= open_disc[i] & ~filled[i]
        if left == 0 or not changed:
            return


@njit(cache=True, nogil=True)
def _fold_image(image, first, second, diagonal, out):
    for k in range(len(first)):
        a, b = image[first[k]], image[second[k]]
        out[k] = a + b
        out[N_EVEN + k] = a - b
    for k in range(len(diagonal)):
        out[len(first) + k] = image[diagonal[k]]


TABLES = (_FIRST, _SECOND, _DIAGONAL, _OPEN, _INVERSE)
