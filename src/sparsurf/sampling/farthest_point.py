"""Farthest-point sampling."""

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, ball


def farthest_point_sampling(index: PatchIndex, n: int, rng: np.random.Generator) -> np.ndarray:
    """Choose dots, in order, that are as far from one another as possible (Gonzalez, Theor. Comput. Sci. 38:293, 1985).

    The first dot is random; then the dot that is farthest from all chosen ones is added until `n` are chosen. A new dot only
    changes distances within the largest one so far: only those dots are visited.
    """
    start = int(index.position[int(rng.integers(len(index.dot)))])
    return index.dot[_farthest_positions(index, start, n)].astype(np.int64)


@njit(cache=True, nogil=True)
def _farthest_positions(index: PatchIndex, first: int, n: int) -> np.ndarray:
    """Return positions in the order of choice, (n,) int32; `gap` is the squared distance to the nearest chosen dot."""
    n_dots = len(index.dot)
    nearby, out = np.empty(n_dots + 1, np.int32), np.empty(n, np.int32)
    diagonal2 = np.sum((index.shape * index.side) ** 2)
    gap = np.full(n_dots, 4.0 * diagonal2)
    leaves = 1
    while leaves < n_dots:
        leaves *= 2
    # Tournament tree of the gaps: the position of the largest gap is at 1
    winner = np.full(2 * leaves, -1, np.int32)
    for q in range(n_dots):
        winner[leaves + q] = q
    for node in range(leaves - 1, 0, -1):
        winner[node] = _larger_gap(gap, index.dot, winner[2 * node], winner[2 * node + 1])
    p = first
    for k in range(n):
        out[k] = p
        x, y, z = index.xyz[p, 0], index.xyz[p, 1], index.xyz[p, 2]
        m = ball(index, x, y, z, 1.000001 * np.sqrt(gap[p]), nearby)
        for e in range(m):
            q = nearby[e]
            d2 = (index.xyz[q, 0] - x) ** 2 + (index.xyz[q, 1] - y) ** 2 + (index.xyz[q, 2] - z) ** 2
            # a chosen dot is never chosen again, not even before a dot that coincides with another one
            d2 = -1.0 if q == p else d2
            if d2 < gap[q]:
                gap[q] = d2
                node = (leaves + q) // 2
                while node > 0 and winner[node] == q:  # a smaller gap matters only where it was the largest
                    winner[node] = _larger_gap(gap, index.dot, winner[2 * node], winner[2 * node + 1])
                    node //= 2
        p = winner[1]
    return out


@njit(cache=True, nogil=True)
def _larger_gap(gap: np.ndarray, dot: np.ndarray, p: int, q: int) -> int:
    """Return the position with the larger gap; on a tie that of the lower dot. -1 stands for no position."""
    if p < 0 or q < 0:
        return max(p, q)
    if gap[p] != gap[q]:
        return p if gap[p] > gap[q] else q
    return p if dot[p] < dot[q] else q
