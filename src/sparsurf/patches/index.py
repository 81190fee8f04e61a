"""Patches of a dot surface: cell grid and linking graph.

The dots are sorted into cubic cells once, and dots closer than d_link are linked once, for the whole surface. Finding a
patch is then one walk over a few contiguous runs of dots, and finding its largest island one breadth-first search on the
graph. No search structure is built per patch.

Positions number the dots in cell order, dots in the order of the surface.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sparsurf.arguments import D_LINK as D_LINK  # re-exported: most users import them from here
from sparsurf.arguments import R_PATCH as R_PATCH
from sparsurf.arguments import R_ZERNIKE as R_ZERNIKE
from sparsurf.kernels import njit
from sparsurf.surfaces.grid import Lattice, cells_within, columns_around, in_column, sort_into_grid
from sparsurf.surfaces.vectors import Vector, point, squared_distance

CELL_SIDE = 2.0  # Å; a third of R_ZERNIKE is the fastest
MIN_LINKS_PER_DOT = 6  # a constant number of iterations avoids mispredicted loop ends
GROUP_SIZE = 64  # dots of a group, one for each bit of a word
ALL_BITS = np.uint64(2**64 - 1)
N_SHELLS = 64  # around a group, in which dots are sorted by their distance
ROUNDING_MARGIN = 1e-9  # Å, far above rounding


class PatchIndex(NamedTuple):
    """A surface prepared for patches; `build_index` makes it, the kernels read it."""

    xyz: np.ndarray  # (N, 3) float64, Å, by position
    normals: np.ndarray  # (N, 3) float64, unit vectors
    dot: np.ndarray  # (N,) int32, at each position
    position: np.ndarray  # (N,) int32, of each dot
    start: np.ndarray  # (cells + 1,) int64, first position of each cell
    lattice: Lattice
    link_start: np.ndarray  # (N + 1,) int64
    link: np.ndarray  # int32, linked positions, rows padded with N up to `MIN_LINKS_PER_DOT`


def build_index(points: np.ndarray, normals: np.ndarray, d_link: float = D_LINK) -> PatchIndex:
    """Sort dots into cells and link those closer than `d_link` (Å, strict); the index takes about 100 bytes per dot."""
    d_link = float(d_link)  # an int would compile the kernels again
    grid = build_grid(points, normals, max(CELL_SIDE, d_link))
    links = _link(grid, d_link)
    return grid._replace(link_start=links[0], link=links[1])


def build_grid(points: np.ndarray, normals: np.ndarray | None = None, side: float = CELL_SIDE) -> PatchIndex:
    """Sort dots into cells of `side` Å without linking them: 70 bytes per dot, and enough for `ball`."""
    xyz, dot, start, lattice = sort_into_grid(points, side)
    position = np.empty(len(dot), np.int32)
    position[dot] = np.arange(len(dot), dtype=np.int32)
    normals = np.zeros((0, 3)) if normals is None else np.asarray(normals, np.float64)[dot]
    return PatchIndex(
        xyz, normals, dot, position, start, lattice, np.zeros(0, np.int64), np.zeros(0, np.int32)
    )


@njit()
def _link(grid: PatchIndex, d_link: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions closer than `d_link` to each, as CSR rows that are padded to `MIN_LINKS_PER_DOT`."""
    xyz, n = grid.xyz, len(grid.xyz)
    d2 = d_link * d_link
    link_start = np.zeros(n + 1, np.int64)
    link = np.full(2 * MIN_LINKS_PER_DOT * n, n, np.int32)
    for i in range(n):
        x, y, z = point(xyz, i)
        columns = columns_around(grid.lattice, (x, y, z), d_link)
        first = m = link_start[i]
        for c in range(columns.n):
            run = in_column(grid.start, columns, c)
            if m + len(run) + MIN_LINKS_PER_DOT > len(link):
                link = np.concatenate((link, np.full(len(link) + len(run), n, np.int32)))
            for q in run:
                p = np.uintp(q)
                ex, ey, ez = xyz[p, 0] - x, xyz[p, 1] - y, xyz[p, 2] - z
                link[np.uintp(m)] = q  # without a branch: entries that do not count are overwritten
                m += 1 if (ex * ex + ey * ey + ez * ez < d2) & (q != i) else 0
        for k in range(m, first + MIN_LINKS_PER_DOT):
            link[k] = n
        link_start[i + 1] = max(m, first + MIN_LINKS_PER_DOT)
    return link_start, link[: link_start[n]].copy()


@njit()
def room_around(index: PatchIndex, centre: Vector, radius: float) -> int:
    """Return an upper bound on the dots within a radius of a point, Å."""
    n, columns = 0, columns_around(index.lattice, centre, radius)
    for c in range(columns.n):
        n += len(in_column(index.start, columns, c))
    return n


@njit()
def ball_bound(index: PatchIndex, points: np.ndarray, radius: float) -> int:
    """Return an upper bound on the dots within a radius of any point (Å): the buffer size of `ball`."""
    bound = 0
    for t in range(len(points)):
        bound = max(bound, room_around(index, point(points, t), radius))
    return bound


@njit()
def ball(index: PatchIndex, centre: Vector, radius: float, out: np.ndarray) -> int:
    """Write the positions of the dots within a radius (Å, inclusive) of a point into `out`, and return their number."""
    n = 0
    r2 = radius * radius
    origin, (n_x, n_y, n_z), side = index.lattice
    x, y, z = centre
    a0, a1 = cells_within(x, radius, origin[0], side, n_x)
    b0, b1 = cells_within(y, radius, origin[1], side, n_y)
    c0, c1 = cells_within(z, radius, origin[2], side, n_z)
    for a in range(a0, a1 + 1):
        low = origin[0] + a * side - x
        dx = max(0.0, max(low, -low - side))
        for b in range(b0, b1 + 1):
            low = origin[1] + b * side - y
            dy = max(0.0, max(low, -low - side))
            if dx * dx + dy * dy > r2 or c1 < c0:
                continue
            row = (a * n_y + b) * n_z
            for q in range(index.start[row + c0], index.start[row + c1 + 1]):
                out[np.uintp(n)] = q
                n += 1 if squared_distance(point(index.xyz, np.uintp(q)), centre) <= r2 else 0
    return n


@njit()
def compact_groups(xyz: np.ndarray) -> np.ndarray:
    """Order positions so that each run of `GROUP_SIZE` is compact: boxes are divided along their longest side."""
    order, n_stacked = np.arange(len(xyz)).astype(np.int32), 1
    stack = np.zeros((64, 2), np.int64)  # a box is at most half of the one before
    stack[0, 1] = len(xyz)
    while n_stacked > 0:
        n_stacked -= 1
        begin, end = stack[n_stacked, 0], stack[n_stacked, 1]
        if end - begin <= GROUP_SIZE:
            continue
        axis, longest = 0, -1.0
        for c in range(3):
            low = high = xyz[order[begin], c]
            for k in range(begin + 1, end):
                low, high = min(low, xyz[order[k], c]), max(high, xyz[order[k], c])
            if high - low > longest:
                axis, longest = c, high - low
        # A multiple of the size of a group, so that only the last group of all has fewer dots
        middle = begin + (end - begin + GROUP_SIZE) // (2 * GROUP_SIZE) * GROUP_SIZE
        _divide(xyz, axis, order, begin, end, middle)
        stack[n_stacked, 0], stack[n_stacked, 1] = begin, middle
        stack[n_stacked + 1, 0], stack[n_stacked + 1, 1] = middle, end
        n_stacked += 2
    return order


@njit()
def _divide(xyz: np.ndarray, axis: int, order: np.ndarray, begin: int, end: int, middle: int) -> None:
    """Reorder order[begin:end] until no entry before `middle` is above one after it along an axis (quickselect)."""
    low, high = begin, end - 1
    while low < high:
        # The median of three: dots of a file are often sorted, for which an end as the pivot takes quadratic time
        a, b, c = xyz[order[low], axis], xyz[order[(low + high) // 2], axis], xyz[order[high], axis]
        pivot = max(min(a, b), min(max(a, b), c))
        left, right = low, high
        while left <= right:
            while xyz[order[left], axis] < pivot:
                left += 1
            while xyz[order[right], axis] > pivot:
                right -= 1
            if left <= right:
                order[left], order[right] = order[right], order[left]
                left += 1
                right -= 1
        if middle <= right:
            high = right
        elif middle >= left:
            low = left
        else:
            return


@njit()
def middle(xyz: np.ndarray, members: np.ndarray) -> tuple[Vector, float, int]:
    """Return the middle of the box around positions, its distance to the farthest of them, and the nearest one."""
    halfway, farthest, nearest, best = np.empty(3), 0.0, np.inf, members[0]
    for c in range(3):
        low = high = xyz[members[0], c]
        for p in members:
            low, high = min(low, xyz[p, c]), max(high, xyz[p, c])
        halfway[c] = (low + high) / 2
    centre = (halfway[0], halfway[1], halfway[2])
    for p in members:
        d2 = squared_distance(point(xyz, p), centre)
        farthest = max(farthest, d2)
        if d2 < nearest:
            nearest, best = d2, p
    return centre, math.sqrt(farthest) + ROUNDING_MARGIN, best


@njit()
def balls(
    index: PatchIndex,
    members: np.ndarray,
    centre: Vector,
    extent: float,
    radius: float,
    bits: np.ndarray,
    centres: np.ndarray,
    ids: np.ndarray,
    bit_words: np.ndarray,
    work: np.ndarray,
) -> int:
    """Find the dots within a radius (Å, inclusive) of up to 64 dots, those near the middle of the group first.

    Writes their positions into `ids` and the bits of the members that each is near to into `bit_words`; returns their number.
    With fewer than 64 members, bits that no member has are those of the first. `centres` and `work` are overwritten.
    """
    for b in range(GROUP_SIZE):
        p = members[b if b < len(members) else 0]
        centres[0, b], centres[1, b], centres[2, b] = point(index.xyz, p)
    n = ball(index, centre, radius + extent, work)
    shells = np.zeros(N_SHELLS + 1, np.int64)
    scale = (N_SHELLS - 1) / (radius + extent)
    for k in range(n):
        apart = math.sqrt(squared_distance(point(index.xyz, np.uintp(work[k])), centre))
        shells[int(scale * apart) + 1] += 1
    for s in range(N_SHELLS):
        shells[s + 1] += shells[s]
    for k in range(n):
        s = int(scale * math.sqrt(squared_distance(point(index.xyz, np.uintp(work[k])), centre)))
        ids[shells[s]] = work[k]
        shells[s] += 1
    # Within `inner` of the middle, a dot lies in the balls of all members, which needs no comparison
    n_near, inner = 0, max(0.0, radius - extent)
    for k in range(n):
        px, py, pz = place = point(index.xyz, np.uintp(ids[k]))
        if squared_distance(place, centre) < inner * inner:
            word = ALL_BITS
        else:
            word = np.uint64(0)
            for b in range(GROUP_SIZE):
                ex, ey, ez = px - centres[0, b], py - centres[1, b], pz - centres[2, b]
                word |= bits[b] if ex * ex + ey * ey + ez * ez <= radius * radius else np.uint64(0)
        ids[n_near], bit_words[n_near] = ids[k], word
        n_near += word != 0
    return n_near


@njit()
def select_separated(
    index: PatchIndex, order: np.ndarray, radius: float, max_dots: int, n_fixed: int
) -> np.ndarray:
    """Select at most `max_dots` dots in order, the first `n_fixed` always, others not within a radius (Å) of a selected one."""
    blocked, r2 = np.zeros(len(index.dot), np.bool_), radius * radius
    out, m = np.empty(min(max_dots, len(order)), np.int64), 0
    for k in range(len(order)):
        if m == len(out):
            break
        p = index.position[order[k]]
        if k < n_fixed or not blocked[p]:
            out[m] = order[k]
            m += 1
            centre = point(index.xyz, p)
            columns = columns_around(index.lattice, centre, radius)
            for c in range(columns.n):
                for j in in_column(index.start, columns, c):
                    q = np.uintp(j)
                    blocked[q] |= squared_distance(point(index.xyz, q), centre) <= r2
    return out[:m].copy()
