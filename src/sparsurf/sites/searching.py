"""Exact search of the nearest places among many, in blocks of one matrix product each."""

import numpy as np

from sparsurf.threads import over_slices

BLOCK = 16384  # places of a block: with 50 queries 3 MB of distances


def nearest_places(query, targets, k, threads=1):
    """The k places nearest to each query.

    Parameters
    ----------
    query : (Q, M) float32
    targets : (P, M) float32, P >= k
    k : int
    threads : int

    Returns
    -------
    distance : (Q, k) float32, ascending
    place : (Q, k) int64; of equal distances the lower place first
    """
    norms = np.einsum("ij,ij->i", targets, targets)
    double = -2 * query

    def best(a, b):
        square = double @ targets[a:b].T
        square += norms[a:b]
        few = min(k, b - a)
        place = (
            np.argpartition(square, few - 1, axis=1)[:, :few]
            if few < b - a
            else np.tile(np.arange(b - a), (len(query), 1))
        )
        return np.take_along_axis(square, place, axis=1), place + a

    found = over_slices(best, len(targets), threads, BLOCK)
    square, place = (np.concatenate([part[c] for part in found], axis=1) for c in (0, 1))
    order = np.lexsort((place, square), axis=1)[:, :k]
    square, place = np.take_along_axis(square, order, axis=1), np.take_along_axis(place, order, axis=1)
    own = np.einsum("ij,ij->i", query, query)[:, None]
    return np.sqrt(np.maximum(square + own, 0)), place
