"""Find the nearest descriptors of two sets, all against all, without storing all distances.

Squared distances are computed in blocks by a matrix product, and each block is used for both sides. The size of the blocks
does not depend on the number of threads, BLAS runs in one thread each, and ties go to the lower index. The result is therefore
bitwise the same for any number of threads. Squares are rounded to the precision that the product has on every processor.
"""

from __future__ import annotations

from threading import Lock
from typing import NamedTuple

import numpy as np

from sparsurf.errors import InputError
from sparsurf.kernels import njit
from sparsurf.threads import parallel_map

BLOCK_ROWS, COLUMNS = 256, 2048  # of a block of distances: 4 MB per thread
SMALLEST = 1e-200  # lower limit of the squared length, so that zero vectors have a step too
# Relative to the largest squared length: 1000 rounding errors of a square; relative distances of a millionth are 0
RESOLVED = 2.0**-40


class Nearest(NamedTuple):
    """The k nearest vectors of the other set, nearest first."""

    distance: np.ndarray  # (n, k) float64
    partner: np.ndarray  # (n, k) int64, indices into the other set

    def mean(self) -> np.ndarray:
        """Return the mean distance of the k nearest, (n,) float64."""
        return self.distance.mean(axis=1)


def nearest(a: np.ndarray, b: np.ndarray, k: int = 1, threads: int = 1) -> tuple[Nearest, Nearest]:
    """Find the k nearest vectors of `b` to each of `a`, and of `a` to each of `b` (paper, 'Complementarity evaluation').

    The smallest distance of each dot is the authors' binding propensity. Time grows as n_A n_B M.
    """
    if not 1 <= k <= min(len(a), len(b)):
        raise InputError(
            f"the mean of the {k} nearest patches needs at least {k} patches on both sides, "
            f"but there are {len(a)} and {len(b)}; take more centres."
        )
    # |a - b|^2 as one product: (-2 a, 1, |a|^2) . (b, |b|^2, 1)
    left = np.column_stack([-2 * a, np.ones(len(a)), (a * a).sum(axis=1)])
    right = np.ascontiguousarray(np.column_stack([b, (b * b).sum(axis=1), np.ones(len(b))]).T)
    step = 2.0 ** np.ceil(np.log2(max(left[:, -1].max(), right[-2].max(), SMALLEST) * RESOLVED))
    of_a, of_b, lock = _empty(len(a), k), _empty(len(b), k), Lock()

    def rows(first: int, last: int) -> None:
        """Compare the vectors `first` to `last` of `a` with all of `b`."""
        slice_of_b = _empty(len(b), k)
        for column in range(0, len(b), COLUMNS):
            block = left[first:last] @ right[:, column : column + COLUMNS]
            _scan(block, step, first, column, of_a[0][first:last], of_a[1][first:last], *slice_of_b)
        with lock:
            _merge(*slice_of_b, *of_b)

    parallel_map(rows, len(a), threads, BLOCK_ROWS)
    return _measure(a, b, of_a[1]), _measure(b, a, of_b[1])


def _empty(n: int, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Return initial squared distances and indices of the k nearest."""
    return np.full((n, k), np.inf), np.full((n, k), np.iinfo(np.int64).max)


def _measure(a: np.ndarray, b: np.ndarray, partner: np.ndarray) -> Nearest:
    """Compute the distances of the nearest from differences, since near 0 the product loses half of the digits."""
    partner = np.sort(partner, axis=1)  # the stable sort below then gives ties to the lower index
    distance = np.empty(partner.shape)
    for j in range(partner.shape[1]):
        distance[:, j] = np.linalg.norm(a - b[partner[:, j]], axis=1)
    order = np.argsort(distance, axis=1, kind="stable")
    return Nearest(np.take_along_axis(distance, order, axis=1), np.take_along_axis(partner, order, axis=1))


@njit()
def _insert(square: float, index: int, distances: np.ndarray, indices: np.ndarray) -> None:
    """Put a candidate into an ascending row if it is nearer than the last; on a tie the lower index wins."""
    k = len(distances) - 1
    if square > distances[k] or (square == distances[k] and index > indices[k]):
        return
    while k > 0 and (square < distances[k - 1] or (square == distances[k - 1] and index < indices[k - 1])):
        distances[k], indices[k] = distances[k - 1], indices[k - 1]
        k -= 1
    distances[k], indices[k] = square, index


@njit()
def _scan(
    block: np.ndarray,
    step: float,
    first_row: int,
    first_column: int,
    row_distances: np.ndarray,
    row_indices: np.ndarray,
    column_distances: np.ndarray,
    column_indices: np.ndarray,
) -> None:
    """Offer every squared distance of a block, rounded to multiples of `step`, to its row and to its column."""
    last = row_distances.shape[1] - 1
    for i in range(len(block)):
        for j in range(block.shape[1]):
            square, column = block[i, j] - step, first_column + j
            if square <= row_distances[i, last]:
                _insert(np.rint(block[i, j] / step) * step, column, row_distances[i], row_indices[i])
            if square <= column_distances[column, last]:
                rounded = np.rint(block[i, j] / step) * step
                _insert(rounded, first_row + i, column_distances[column], column_indices[column])


@njit()
def _merge(
    distances: np.ndarray, indices: np.ndarray, into_distances: np.ndarray, into_indices: np.ndarray
) -> None:
    """Offer the nearest of one slice to the nearest so far; the order of the slices does not matter."""
    for i in range(len(distances)):
        for j in range(distances.shape[1]):
            _insert(distances[i, j], indices[i, j], into_distances[i], into_indices[i])
