"""Patches of a dot surface: cell grid, linking graph, islands.

The dots are sorted into cubic cells once; dots closer than D_link are linked once, for the
whole surface. A patch is then one walk over a few contiguous runs of dots, and its largest
island one breadth-first search on the graph: no search structure is built per patch.

Positions number the dots in cell order, dots in the order of the surface.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from sparsurf import InputError

R_PATCH = 4.0  # Å, roughness and sampling (authors' scripts)
R_ZERNIKE = 6.0  # Å, descriptors (paper, Materials and Methods)
D_LINK = 0.5  # Å, dots closer than this are linked (authors' scripts)
CELL = 2.0  # Å, side of a cell: a third of R_ZERNIKE was the fastest
ROW = 6  # links stored per dot at least: a constant trip count spares mispredicted loop ends
SPARSE = 1.3  # D_link must exceed this many times the median spacing, else patches shatter


class Index(NamedTuple):
    """A surface prepared for patches; made by `build_index`, read by the kernels.

    xyz, normals : (N, 3) float64, Å and unit vectors, by position
    dot, position : (N,) int32, dot at each position and position of each dot
    origin, shape, side, start : the cell grid; `start` (cells + 1,) int64
    link_start, link : (N + 1,) int64 and int32; linked positions, rows padded with N up to `ROW`
    """

    xyz: np.ndarray
    normals: np.ndarray
    dot: np.ndarray
    position: np.ndarray
    origin: np.ndarray
    shape: np.ndarray
    side: float
    start: np.ndarray
    link_start: np.ndarray
    link: np.ndarray


def build_index(points, normals, d_link=D_LINK):
    """Sort dots into cells and link those closer than `d_link`.

    Parameters
    ----------
    points, normals : (N, 3) float64
        Å; unit outward normals.
    d_link : float
        Linking distance D_link in Å (strict).

    Returns
    -------
    Index
        Memory: about 100 bytes per dot.
    """
    points = np.ascontiguousarray(points, np.float64)
    side = _cell_side(points, max(CELL, d_link))
    origin = points.min(axis=0) - 1e-6
    shape = ((points.max(axis=0) - origin) / side).astype(np.int64) + 1
    start, dot = _sort_into_cells(points, origin, shape, side)
    position = np.empty(len(dot), np.int32)
    position[dot] = np.arange(len(dot), dtype=np.int32)
    xyz = points[dot]
    links = _link(xyz, origin, shape, side, start, d_link)
    return Index(xyz, np.asarray(normals, np.float64)[dot], dot, position, origin, shape, side, start, *links)


def _cell_side(points, side):
    """Cell side in Å, enlarged where few dots span a huge box, so that cells never outnumber dots by far."""
    extent = np.maximum(points.max(axis=0) - points.min(axis=0), side)
    while np.prod(extent / side) > 50 * len(points) + 1e6:
        side *= 2
    return float(side)


@njit(cache=True, nogil=True)
def _sort_into_cells(points, origin, shape, side):
    n = len(points)
    cell = np.empty(n, np.int64)
    start = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int64)
    for i in range(n):
        a = int((points[i, 0] - origin[0]) / side)
        b = int((points[i, 1] - origin[1]) / side)
        c = int((points[i, 2] - origin[2]) / side)
        cell[i] = (a * shape[1] + b) * shape[2] + c
        start[cell[i] + 1] += 1
    for k in range(len(start) - 1):
        start[k + 1] += start[k]
    fill = start[:-1].copy()
    dot = np.empty(n, np.int32)
    for i in range(n):
        dot[fill[cell[i]]] = i
        fill[cell[i]] += 1
    return start, dot


@njit(cache=True, nogil=True)
def _span(x, radius, origin, side, cells):
    """First and last cell, along one axis, that a sphere can touch."""
    first = max(0, int((x - radius - origin) / side))
    return first, min(cells - 1, int((x + radius - origin) / side))


@njit(cache=True, nogil=True)
def _link(xyz, origin, shape, side, start, d_link):
    """CSR rows of the positions closer than `d_link`; counted in a first pass, stored in a second."""
    n = len(xyz)
    d2 = d_link * d_link
    link_start = np.zeros(n + 1, np.int64)
    link = np.empty(0, np.int32)
    for store in range(2):
        if store:
            for i in range(n):
                link_start[i + 1] += link_start[i]
            link = np.full(link_start[n], n, np.int32)
        for i in range(n):
            x, y, z = xyz[i, 0], xyz[i, 1], xyz[i, 2]
            a0, a1 = _span(x, d_link, origin[0], side, shape[0])
            b0, b1 = _span(y, d_link, origin[1], side, shape[1])
            c0, c1 = _span(z, d_link, origin[2], side, shape[2])
            found = 0
            for a in range(a0, a1 + 1):
                for b in range(b0, b1 + 1):
                    row = (a * shape[1] + b) * shape[2]
                    for q in range(start[row + c0], start[row + c1 + 1]):
                        d = (xyz[q, 0] - x) ** 2 + (xyz[q, 1] - y) ** 2 + (xyz[q, 2] - z) ** 2
                        if d < d2 and q != i:
                            if store:
                                link[link_start[i] + found] = q
                            found += 1
            if not store:
                link_start[i + 1] = max(found, ROW)
    return link_start, link


@njit(cache=True, nogil=True)
def ball_bound(index, points, radius):
    """Upper bound on the dots within `radius` (Å) of any of `points` (T, 3): the buffer size of `ball`."""
    most = 0
    for t in range(len(points)):
        a0, a1 = _span(points[t, 0], radius, index.origin[0], index.side, index.shape[0])
        b0, b1 = _span(points[t, 1], radius, index.origin[1], index.side, index.shape[1])
        c0, c1 = _span(points[t, 2], radius, index.origin[2], index.side, index.shape[2])
        n = 0
        for a in range(a0, a1 + 1):
            for b in range(b0, b1 + 1):
                row = (a * index.shape[1] + b) * index.shape[2]
                n += index.start[row + c1 + 1] - index.start[row + c0] if c1 >= c0 else 0
        most = max(most, n)
    return most


@njit(cache=True, nogil=True)
def ball(index, x, y, z, radius, out):
    """Positions of the dots within `radius` (Å, inclusive) of (x, y, z), into `out`; returns their number."""
    n = 0
    r2 = radius * radius
    side = index.side
    a0, a1 = _span(x, radius, index.origin[0], side, index.shape[0])
    b0, b1 = _span(y, radius, index.origin[1], side, index.shape[1])
    c0, c1 = _span(z, radius, index.origin[2], side, index.shape[2])
    for a in range(a0, a1 + 1):
        low = index.origin[0] + a * side - x
        dx = max(0.0, max(low, -low - side))
        for b in range(b0, b1 + 1):
            low = index.origin[1] + b * side - y
            dy = max(0.0, max(low, -low - side))
            if dx * dx + dy * dy > r2 or c1 < c0:
                continue
            row = (a * index.shape[1] + b) * index.shape[2]
            for q in range(index.start[row + c0], index.start[row + c1 + 1]):
                p = np.uintp(q)
                ex, ey, ez = index.xyz[p, 0] - x, index.xyz[p, 1] - y, index.xyz[p, 2] - z
                out[np.uintp(n)] = q
                n += 1 if ex * ex + ey * ey + ez * ez <= r2 else 0
    return n


@njit(cache=True, nogil=True)
def mark_all(mark, ids, n):
    """Set `mark` at `ids[:n]`."""
    for k in range(n):
        mark[np.uintp(ids[k])] = 1


@njit(cache=True, nogil=True)
def largest_island(ids, n, mark, link_start, link, key, queue):
    """Largest connected component of `ids[:n]`, as the slice begin:end of `queue`.

    `mark` is 1 at every id that takes part and 0 elsewhere (also at the padding id); it is all 0
    on return. On a tie the island that holds the smallest `key` wins. `queue` needs n + 1 places.
    Unsigned indices spare numba's test for negative ones: half of the time.
    """
    tail = 0
    begin = end = 0
    best_key = np.int64(-1)
    for s in range(n):
        if n - tail < end - begin:
            break
        if mark[np.uintp(ids[s])] == 0:
            continue
        head = first = tail
        queue[tail] = ids[s]
        tail += 1
        mark[np.uintp(ids[s])] = 0
        while head < tail:
            i = np.uintp(queue[np.uintp(head)])
            row, row_end = link_start[i], link_start[i + np.uintp(1)]
            head += 1
            for e in range(ROW):  # push without a branch: an id that does not count is overwritten
                j = link[np.uintp(row + e)]
                queue[np.uintp(tail)] = j
                tail += mark[np.uintp(j)]
                mark[np.uintp(j)] = 0
            for e in range(row + ROW, row_end):
                j = link[np.uintp(e)]
                queue[np.uintp(tail)] = j
                tail += mark[np.uintp(j)]
                mark[np.uintp(j)] = 0
        if tail - first > end - begin:
            begin, end, best_key = first, tail, -1
        elif tail - first == end - begin:
            if best_key < 0:
                best_key = _smallest_key(queue, begin, end, key)
            this_key = _smallest_key(queue, first, tail, key)
            if this_key < best_key:
                begin, end, best_key = first, tail, this_key
    for s in range(n):
        mark[np.uintp(ids[s])] = 0
    return begin, end


@njit(cache=True, nogil=True)
def _smallest_key(queue, begin, end, key):
    smallest = np.int64(key[queue[begin]])
    for k in range(begin + 1, end):
        smallest = min(smallest, np.int64(key[queue[k]]))
    return smallest


@njit(cache=True, nogil=True)
def patch_of(index, p, radius, found, mark, queue):
    """Patch of the dot at position `p`, cut to its largest island: the slice begin:end of `queue`."""
    n = ball(index, index.xyz[p, 0], index.xyz[p, 1], index.xyz[p, 2], radius, found)
    mark_all(mark, found, n)
    place = 0
    for k in range(n):
        place = k if found[k] == p else place
    found[0], found[place] = found[place], found[0]  # the search starts at p: mostly in the largest island
    return largest_island(found, n, mark, index.link_start, index.link, index.dot, queue)


def patch(index, dot, radius):
    """Dots of the patch of one dot, islands removed.

    Parameters
    ----------
    index : Index
    dot : int
    radius : float
        Å.

    Returns
    -------
    (n,) int32, ascending dot indices. Source: paper, 'Zernike 2D procedure'.
    """
    p = index.position[dot]
    room = ball_bound(index, index.xyz[p : p + 1], radius) + 1
    queue = np.empty(room, np.int32)
    mark = np.zeros(len(index.dot) + 1, np.uint8)
    begin, end = patch_of(index, p, radius, np.empty(room, np.int32), mark, queue)
    return np.sort(index.dot[queue[begin:end]])


def spacing(index):
    """Median distance in Å from a dot to its nearest other dot (NaN for a single dot)."""
    from scipy.spatial import cKDTree

    if len(index.xyz) < 2:
        return float("nan")
    return float(np.median(cKDTree(index.xyz).query(index.xyz, k=2)[0][:, 1]))


def refuse_sparse(index, d_link, name):
    """Raise InputError where `d_link` is too short for the dots of the surface called `name`."""
    gap = spacing(index)
    if d_link < SPARSE * gap:
        raise InputError(
            f"{name}: D_link = {d_link:g} Å is below {SPARSE} times the median distance between neighbouring dots "
            f"({gap:.3f} Å), so every patch would fall apart; use a denser surface or a larger linking_distance."
        )
