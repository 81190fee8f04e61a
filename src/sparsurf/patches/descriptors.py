"""Descriptors of patches, for many subsets of one surface in one pass.

Which dots a patch holds is settled by `kept_dots`, which numbers describe them by one of `DESCRIPTORS`. To add a
descriptor, write one file like `zernike/published.py` and enter it here.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numba import njit

from sparsurf.patches.index import R_ZERNIKE, ball_bound
from sparsurf.patches.kept_dots import BITS, add, pack, patches_of
from sparsurf.patches.readings import READINGS
from sparsurf.patches.zernike import published, steady
from sparsurf.threads import parallel_map

__all__ = ["BITS", "DESCRIPTORS", "PUBLISHED", "Descriptor", "add", "compare", "describe", "evaluate", "pack"]

ROWS = 512  # patches per call of a descriptor; fixed, so that results do not depend on the cores
PUBLISHED = "published"


class Descriptor(NamedTuple):
    """One way to describe patches by numbers.

    width : int, numbers per patch
    order : function that returns (width,) int, place of each of the kernel's columns in the vector that users get
    describe : function of
        index : patches.Index
        ids : int32 positions and start : (P + 1,) int64; patch i holds the dots ids[start[i]:start[i + 1]]
        centres : (P, 3) float64, Å, the points around which the patches are cut
        weights : float64 beside `ids`, or empty where all dots weigh 1
        radius : float, R_zernike in Å
        up : bool, whether the mean normal is turned to +z or to -z
        that returns (P, width) float64, zero for a patch that has no descriptor
    """

    width: int
    order: Callable
    describe: Callable


DESCRIPTORS = {
    PUBLISHED: Descriptor(published.N_Z, published.order, published.describe),
    "steady": Descriptor(steady.N_Z, steady.order, steady.describe),
}


def describe(index, tests, radius=R_ZERNIKE, up=True, threads=1, descriptor=PUBLISHED):
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
    descriptor : str
        Name in `DESCRIPTORS`.

    Returns
    -------
    z : (T, width) float64
        |c_nm| in the order of `zernike.indices`.
    sizes : (T,) int32
        Dots in each patch.
    """
    kind = DESCRIPTORS[descriptor]
    out = np.empty((len(tests), kind.width))

    def keep(a, b, z):
        out[a:b] = z

    sizes = _described(kind, index, tests, np.empty(0, np.uint64), 0, (), 1, radius, up, threads, None, keep)
    return _in_order(kind, out), sizes[:, 0]


def describe_fields(index, tests, values, radius=R_ZERNIKE, threads=1):
    """Zernike invariants of fields over the patches of a whole surface, by the steady descriptor's image.

    Parameters
    ----------
    index : patches.Index
    tests : (T, 3) float64
        Å, points around which the patches are cut.
    values : (F, N) float64
        Fields, a number at each dot of the surface.
    radius : float
        Of the patches, Å.
    threads : int

    Returns
    -------
    (T, F, 121) float64, |c_nm| in the order of `zernike.indices` and in the units of each field; a constant field has
    its value at n = 0 and zeros elsewhere
    """
    values = np.ascontiguousarray(np.asarray(values, np.float64)[:, index.dot])
    kind = Descriptor(len(values) * steady.N_Z, steady.order, partial(steady.describe_fields, values=values))
    out = np.empty((len(tests), len(values), steady.N_Z))

    def keep(a, b, z):
        out[a:b] = z.reshape(b - a, len(values), -1)

    _described(kind, index, tests, np.empty(0, np.uint64), 0, (), 1, radius, True, threads, None, keep)
    ordered = np.empty_like(out)
    ordered[:, :, steady.order()] = out
    return ordered


def evaluate(
    index, tests, words, n_subsets, reading, z_tot=None, weights=None, radius=R_ZERNIKE, up=True, threads=1,
    descriptor=PUBLISHED,
):  # fmt: skip
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
    reading : str
        One of `readings.OF_GRID`.
    z_tot : (T, width) float64, optional
        Descriptors of the whole surface, in the order of `describe`.
    weights : (B, N) float64, optional
        Weight of each dot, by position; 1 without.

    Returns
    -------
    (T, B) float64 distances |z_tot - z| where `z_tot` is given, else (T, B, width) descriptors in
    the kernel's own order; and (T, B) int32, dots in each evaluated patch.
    """
    if z_tot is not None:
        readings = (reading,)
        return compare(
            index, tests, words, n_subsets, readings, z_tot, weights, radius, up, threads, descriptor
        )[1:]
    kind = DESCRIPTORS[descriptor]
    out = np.empty((len(tests), n_subsets, kind.width))

    def keep(a, b, z):
        out[a:b] = z.reshape(b - a, n_subsets, -1)

    sizes = _described(
        kind, index, tests, words, n_subsets, (reading,), 0, radius, up, threads, weights, keep
    )
    return out, sizes


def compare(
    index, tests, words, n_subsets, readings, z_tot=None, weights=None, radius=R_ZERNIKE, up=True, threads=1,
    descriptor=PUBLISHED,
):  # fmt: skip
    """Distances of the patches of several subsets to those of the whole surface, under R readings in one pass.

    Parameters
    ----------
    index, tests, words, n_subsets, weights : as for `evaluate`
    readings : tuple of str
    z_tot : (T, width) float64, optional
        Descriptors of the whole surface where already known; its dots always have the weight 1.

    Returns
    -------
    z_tot : (T, width) float64
    z : (T, R B) float64, |z_tot - z| of all subsets under the first reading, then under the next
    sizes : (T, R B) int32, dots in each evaluated patch
    """
    kind, whole = DESCRIPTORS[descriptor], int(z_tot is None)
    target = np.empty((len(tests), kind.width)) if whole else np.ascontiguousarray(z_tot[:, kind.order()])
    out = np.empty((len(tests), len(readings) * n_subsets))

    def keep(a, b, z):
        if whole:
            target[a:b] = z[:: out.shape[1] + 1]
        _distances(z, whole, target[a:b], out[a:b])

    sizes = _described(
        kind, index, tests, words, n_subsets, readings, whole, radius, up, threads, weights, keep
    )
    return _in_order(kind, target) if whole else z_tot, out, sizes[:, whole:]


def _in_order(kind, z):
    """Descriptors in the kernel's order to that of users."""
    out = np.empty_like(z)
    out[:, kind.order()] = z
    return out


def _described(kind, index, tests, words, n_subsets, readings, whole, radius, up, threads, weights, keep):
    """Hand the descriptors of slices of the tests to `keep(begin, end, z)`; returns patch sizes.

    The patches of a test: its whole patch (`whole` 1, or 0 for none), those of the subsets under the first reading,
    under the next.
    """
    tests = np.ascontiguousarray(tests, np.float64)
    radius = float(radius)  # an int would compile kernels anew
    weights = np.empty((0, 0)) if weights is None else weights
    kept = np.array([READINGS[reading].among_kept for reading in readings], np.bool_)
    room = ball_bound(index, tests, radius) + 1
    sizes = np.empty((len(tests), whole + len(readings) * n_subsets), np.int32)

    spare = []  # working arrays of threads that wait

    def block(a, b):
        n = len(index.dot) + 1
        mark, around = spare.pop() if spare else (np.zeros(n, np.uint8), np.zeros(n, np.uint64))
        rows = (b - a) * sizes.shape[1]
        ids, start = np.empty(rows * room, np.int32), np.empty(rows + 1, np.int64)
        weight = np.empty(len(ids) if len(weights) else 0)
        patches_of(
            index, tests[a:b], words, n_subsets, weights, radius, kept, room, mark, around, sizes[a:b], ids, start, weight
        )  # fmt: skip
        spare.append((mark, around))
        centres = np.repeat(tests[a:b], sizes.shape[1], axis=0)
        keep(a, b, kind.describe(index, ids, start, centres, weight, radius, up))

    parallel_map(block, len(tests), threads, max(1, ROWS // sizes.shape[1]))
    return sizes


@njit(cache=True, nogil=True, fastmath={"nnan", "ninf", "nsz", "arcp", "contract", "reassoc"})
def _distances(z, skip, target, out):
    """Distances to the target of each test; of its rows the first `skip` are left out."""
    for t in range(len(out)):
        for b in range(out.shape[1]):
            i = t * (skip + out.shape[1]) + skip + b
            total = 0.0
            for k in range(z.shape[1]):
                total += (z[i, k] - target[t, k]) ** 2
            out[t, b] = math.sqrt(total)
