"""The nearest descriptors of two sets, all against all, without ever holding all distances.

Squared distances come block by block from one matrix product, and each block serves both sides. Blocks have one
size whatever the number of threads, BLAS runs in one thread each, and ties go to the lower place, so that the
result is the same bit by bit for any number of threads.
"""

from threading import Lock
from typing import NamedTuple

import numpy as np
from numba import njit

from sparsurf import InputError
from sparsurf.threads import parallel_map

ROWS, COLUMNS = 256, 2048  # of a block of distances: 4 MB per thread


class Nearest(NamedTuple):
    """The k nearest vectors of the other set, nearest first.

    distance : (n, k) float64
    partner : (n, k) int64, places in the other set
    """

    distance: np.ndarray
    partner: np.ndarray

    def mean(self):
        """(n,) float64, mean distance of the k nearest."""
        return self.distance.mean(axis=1)


def nearest(a, b, k=1, threads=1):
    """The k nearest vectors of `b` to each of `a`, and of `a` to each of `b`.

    Parameters
    ----------
    a, b : (n_A, M) and (n_B, M) float64
        Descriptors; those of one side 'up', of the other 'down' for complementarity, both 'up' for similarity.
    k : int
    threads : int

    Returns
    -------
    Nearest of `a` (n_A rows) and Nearest of `b` (n_B rows). Time follows n_A n_B M; memory n_A k + threads n_B k.

    Raises
    ------
    InputError : fewer vectors than k on one side

    Source: paper, 'Complementarity evaluation'; the smallest distance of each dot is the authors' binding propensity.
    """
    if not 1 <= k <= min(len(a), len(b)):
        raise InputError(
            f"the mean of the {k} nearest patches needs at least {k} patches on both sides, "
            f"but there are {len(a)} and {len(b)}; lower `nearest` or take more centres."
        )
    # |a - b|^2 as one product: (-2 a, 1, |a|^2) . (b, |b|^2, 1)
    left = np.column_stack([-2 * a, np.ones(len(a)), (a * a).sum(axis=1)])
    right = np.ascontiguousarray(np.column_stack([b, (b * b).sum(axis=1), np.ones(len(b))]).T)
    of_a, of_b, lock = _none_yet(len(a), k), _none_yet(len(b), k), Lock()

    def rows(first, last):
        mine = _none_yet(len(b), k)
        for column in range(0, len(b), COLUMNS):
            block = left[first:last] @ right[:, column : column + COLUMNS]
            _scan(block, first, column, *(part[first:last] for part in of_a), *mine)
        with lock:
            _merge(*mine, *of_b)

    parallel_map(rows, len(a), threads, ROWS)
    return _measured(a, b, of_a[1]), _measured(b, a, of_b[1])


def _none_yet(n, k):
    """Squared distances and places of the k nearest, none found."""
    return np.full((n, k), np.inf), np.full((n, k), np.iinfo(np.int64).max)


def _measured(a, b, partner):
    """The chosen ones with distances from the differences themselves: near 0 the product loses half of the digits."""
    partner = np.sort(partner, axis=1)
    distance = np.empty(partner.shape)
    for j in range(partner.shape[1]):
        distance[:, j] = np.linalg.norm(a - b[partner[:, j]], axis=1)
    order = np.argsort(distance, axis=1, kind="stable")
    return Nearest(*(np.take_along_axis(part, order, axis=1) for part in (distance, partner)))


@njit(cache=True, nogil=True)
def _insert(square, place, distances, places):
    """Put a candidate into an ascending row if it is nearer than its last; on a tie the lower place wins."""
    k = len(distances) - 1
    if square > distances[k] or (square == distances[k] and place > places[k]):
        return
    while k > 0 and (square < distances[k - 1] or (square == distances[k - 1] and place < places[k - 1])):
        distances[k], places[k] = distances[k - 1], places[k - 1]
        k -= 1
    distances[k], places[k] = square, place


@njit(cache=True, nogil=True)
def _scan(block, first_row, first_column, row_distances, row_places, column_distances, column_places):
    """Offer every squared distance of a block to its row and to its column."""
    last = row_distances.shape[1] - 1
    for i in range(len(block)):
        for j in range(block.shape[1]):
            square, column = block[i, j], first_column + j
            if square <= row_distances[i, last]:
                _insert(square, column, row_distances[i], row_places[i])
            if square <= column_distances[column, last]:
                _insert(square, first_row + i, column_distances[column], column_places[column])


@njit(cache=True, nogil=True)
def _merge(distances, places, into_distances, into_places):
    """Offer the nearest found in one slice to those found so far; the order of the slices does not matter."""
    for i in range(len(distances)):
        for j in range(distances.shape[1]):
            _insert(distances[i, j], places[i, j], into_distances[i], into_places[i])
