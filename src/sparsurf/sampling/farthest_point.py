"""Farthest-point sampling."""

from __future__ import annotations

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex
from sparsurf.surfaces.grid import cells_within
from sparsurf.surfaces.vectors import point

# A full list forces a comparison, and a longer one takes memory for every cell
WAITING = 8  # chosen dots that a cell may have to compare with its dots


def farthest_point_sampling(index: PatchIndex, n: int, rng: np.random.Generator) -> np.ndarray:
    """Choose dots, in order, that are as far from one another as possible (Gonzalez, Theor. Comput. Sci. 38:293, 1985).

    The first dot is random; then the dot that is farthest from all chosen ones is added until `n` are chosen; of several that
    are as far, the one with the lowest number. Cells of dots have a limit above all distances of their dots; these are only
    compared where the limit is the largest of all (after QuickFPS, Han et al., IEEE Trans. CAD, 2023).
    """
    return farthest_after(index, np.array([rng.integers(len(index.dot))]), n)


def farthest_after(index: PatchIndex, chosen: np.ndarray, n: int) -> np.ndarray:
    """Return the first n of some chosen dots (at least one) followed by dots that are as far as possible from all before."""
    first = index.position[chosen].astype(np.int64)
    return index.dot[_farthest_positions(index, first, n, False)[0]].astype(np.int64)


def farthest_points(index: PatchIndex, n: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return the dots of `farthest_point_sampling`, (n,), and for every dot the chosen one nearest to it, (N,), from 0.

    Of several that are as near, it is the one that was chosen first.
    """
    first = index.position[np.array([rng.integers(len(index.dot))])].astype(np.int64)
    positions, nearest = _farthest_positions(index, first, n, True)
    nearest_of_dot = np.empty(len(nearest), np.int64)
    nearest_of_dot[index.dot] = nearest
    return index.dot[positions].astype(np.int64), nearest_of_dot


@njit()
def _farthest_positions(
    index: PatchIndex, first: np.ndarray, n: int, with_nearest: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return positions in the order of choice, (n,) int32, and the chosen one nearest to each, (N,) int32, if asked for."""
    n_dots = len(index.dot)
    origin, (n_x, n_y, depth), side = index.lattice
    n_columns = n_x * n_y
    # The cells that have dots, one after the other along z: `begin` is the first position of each
    n_cells = 0
    for cell in range(len(index.start) - 1):
        n_cells += index.start[cell + 1] > index.start[cell]
    begin, column = np.empty(n_cells + 1, np.int32), np.empty(n_columns + 1, np.int32)
    k = 0
    for c in range(n_columns):
        column[c] = k
        for cell in range(c * depth, (c + 1) * depth):
            if index.start[cell + 1] > index.start[cell]:
                begin[k] = index.start[cell]
                k += 1
    begin[n_cells], column[n_columns] = n_dots, n_cells
    # no np.sum, np.full or copy: a stored kernel that calls them imports scipy.linalg when it is loaded
    # Larger than any squared distance, and finite, since its root becomes the number of a cell
    unlimited = 4.0 * side**2 * (n_x**2 + n_y**2 + depth**2)
    gap, nearest = np.empty(n_dots), np.zeros(n_dots, np.int32)  # squared distance to the nearest chosen dot
    for q in range(n_dots):
        gap[q] = unlimited
    box = np.empty((n_cells, 6))  # lowest and highest coordinates of the dots of each cell
    limit = np.empty(n_cells)  # that no gap of the cell exceeds; the largest of them where no dot waits
    best = np.empty(n_cells, np.int32)  # the position with that gap
    waiting, n_waiting = np.empty((n_cells, WAITING), np.int32), np.zeros(n_cells, np.int32)
    for k in range(n_cells):
        limit[k], best[k] = unlimited, begin[k]
        x0, y0, z0 = point(index.xyz, begin[k])
        x1, y1, z1 = x0, y0, z0
        for q in range(begin[k] + 1, begin[k + 1]):
            x, y, z = point(index.xyz, q)
            x0, y0, z0 = min(x0, x), min(y0, y), min(z0, z)
            x1, y1, z1 = max(x1, x), max(y1, y), max(z1, z)
        box[k, 0], box[k, 1], box[k, 2], box[k, 3], box[k, 4], box[k, 5] = x0, y0, z0, x1, y1, z1
    leaves = 1
    while leaves < n_cells:
        leaves *= 2
    # A tournament tree: the cell with the largest limit is at 1, and -1 stands for none
    winner = np.empty(2 * leaves, np.int32)
    for k in range(leaves):
        winner[leaves + k] = k if k < n_cells else -1
    # All limits are equal at first, and cells fill the leaves from the left: the left one is missing only with the right one
    for node in range(leaves - 1, 0, -1):
        winner[node] = winner[2 * node]
    out = np.empty(n, np.int32)
    p, reach2 = first[0], unlimited
    for i in range(n):
        out[i] = p
        x, y, z = point(index.xyz, p)
        # Wider than rounding, which might leave out a cell; a cell too many costs one comparison
        radius = 1.000001 * np.sqrt(reach2)
        a0, a1 = cells_within(x, radius, origin[0], side, n_x)
        b0, b1 = cells_within(y, radius, origin[1], side, n_y)
        for a in range(a0, a1 + 1):
            c = a * n_y
            for k in range(column[c + b0], column[c + b1 + 1]):
                # to the nearest and to the farthest point of the box: rounded as the distances of its dots, which lie between
                dx = max(box[k, 0] - x, x - box[k, 3], 0.0)
                dy = max(box[k, 1] - y, y - box[k, 4], 0.0)
                dz = max(box[k, 2] - z, z - box[k, 5], 0.0)
                holds_dot = begin[k] <= p < begin[k + 1]
                if dx * dx + dy * dy + dz * dz >= limit[k] and not holds_dot:
                    continue
                if n_waiting[k] == WAITING:
                    _compare(
                        index, begin[k], begin[k + 1], out, waiting, n_waiting, k, gap, nearest, limit, best
                    )
                waiting[k, n_waiting[k]] = i
                n_waiting[k] += 1
                dx, dy = max(x - box[k, 0], box[k, 3] - x), max(y - box[k, 1], box[k, 4] - y)
                dz = max(z - box[k, 2], box[k, 5] - z)
                limit[k] = min(limit[k], dx * dx + dy * dy + dz * dz)
                _play(k, leaves, winner, limit, n_waiting, best, index.dot)
        while i + 1 < n and n_waiting[winner[1]] > 0:
            k = winner[1]
            _compare(index, begin[k], begin[k + 1], out, waiting, n_waiting, k, gap, nearest, limit, best)
            _play(k, leaves, winner, limit, n_waiting, best, index.dot)
        p, reach2 = best[winner[1]], limit[winner[1]]
        if i + 1 < len(first):
            p = first[i + 1]
    if with_nearest:
        for k in range(n_cells):
            _compare(index, begin[k], begin[k + 1], out, waiting, n_waiting, k, gap, nearest, limit, best)
    return out, nearest


@njit()
def _compare(
    index: PatchIndex,
    begin: int,
    end: int,
    out: np.ndarray,
    waiting: np.ndarray,
    n_waiting: np.ndarray,
    k: int,
    gap: np.ndarray,
    nearest: np.ndarray,
    limit: np.ndarray,
    best: np.ndarray,
) -> None:
    """Compare the dots of cell k, from `begin` to `end`, with the chosen ones that wait for it."""
    for w in range(n_waiting[k]):
        i = waiting[k, w]
        p = out[i]
        x, y, z = point(index.xyz, p)
        for q in range(begin, end):
            dx, dy, dz = index.xyz[q, 0] - x, index.xyz[q, 1] - y, index.xyz[q, 2] - z
            d2 = dx * dx + dy * dy + dz * dz
            if d2 < gap[q]:
                gap[q], nearest[q] = d2, i
        if begin <= p < end:  # never chosen again, not even before a dot that coincides with it
            gap[p], nearest[p] = -1.0, i
    n_waiting[k] = 0
    top = begin
    for q in range(begin + 1, end):
        if gap[q] > gap[top] or (gap[q] == gap[top] and index.dot[q] < index.dot[top]):
            top = q
    best[k], limit[k] = top, gap[top]


@njit()
def _play(
    k: int,
    leaves: int,
    winner: np.ndarray,
    limit: np.ndarray,
    n_waiting: np.ndarray,
    best: np.ndarray,
    dot: np.ndarray,
) -> None:
    """Repeat the matches that cell k has won, as its limit is lower; on a tie with compared dots, the lower dot wins."""
    node = (leaves + k) // 2
    while node > 0 and winner[node] == k:
        a, b = winner[2 * node], winner[2 * node + 1]
        if a < 0 or b < 0:
            winner[node] = max(a, b)
        elif limit[a] != limit[b]:
            winner[node] = a if limit[a] > limit[b] else b
        elif n_waiting[a] > 0 or n_waiting[b] > 0:  # whose dots are compared first
            winner[node] = a if n_waiting[a] > 0 else b
        else:
            winner[node] = a if dot[best[a]] < dot[best[b]] else b
        node //= 2
