"""Points sorted into the cells of a grid, so that those around a place are a few runs of them.

Positions number the points in the order of their cells, dots in the order in which they were given.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.vectors import Vector, doubled, point, squared_distance
from sparsurf.threads import parallel_map

OUT_OF_REACH = 1e7  # Å, at which no point is looked for


class Lattice(NamedTuple):
    """The cells of a grid, all of one edge."""

    origin: Vector  # Å, lowest corner
    shape: tuple[int, int, int]  # cells along each axis
    side: float  # Å


class PointGrid(NamedTuple):
    """Points by cell."""

    xyz: np.ndarray  # (N, 3) float64, Å, by position
    dot: np.ndarray  # (N,) int32, the number of the point at each position
    start: np.ndarray  # (cells + 1,) int64, first position of each cell
    lattice: Lattice


def sort_into_grid(points: np.ndarray, side: float) -> PointGrid:
    """Sort points (N, 3) into cells of `side` Å, or more where so small cells were far more than the points."""
    points = np.ascontiguousarray(points, np.float64)
    low, high = _bounding_box(points) if len(points) else np.zeros((2, 3))
    side = _cell_side(high - low, len(points), side)
    origin = low - 1e-6
    shape = ((high - origin) / side).astype(np.int64) + 1
    lattice = Lattice(tuple(origin.tolist()), tuple(shape.tolist()), side)
    start, dot = _sort_into_cells(points, lattice)
    return PointGrid(points[dot], dot, start, lattice)


@njit()
def _bounding_box(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest coordinates, (3,) each; numpy takes ten times as long along the first axis."""
    low, high = points[0].copy(), points[0].copy()
    for i in range(1, len(points)):
        for c in range(3):
            low[c], high[c] = min(low[c], points[i, c]), max(high[c], points[i, c])
    return low, high


def _cell_side(extent: np.ndarray, n: int, side: float) -> float:
    """Enlarge the cell side, Å, where n dots span a huge box (3,), so that there are not far more cells than dots."""
    # an axis along which the box is thinner than a cell still has one cell
    while np.prod(np.maximum(extent / side, 1.0)) > 50 * n + 1e6:
        side *= 2
    return float(side)


@njit()
def _sort_into_cells(points: np.ndarray, lattice: Lattice) -> tuple[np.ndarray, np.ndarray]:
    """Return the first slot of every cell and the dots in the order of their cells."""
    n, (origin, shape, side) = len(points), lattice
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


@njit()
def cells_within(x: float, radius: float, origin: float, side: float, cells: int) -> tuple[int, int]:
    """Return the first and last cell along one axis that a sphere can touch."""
    first = max(0, int((x - radius - origin) / side))
    return first, min(cells - 1, int((x + radius - origin) / side))


class ColumnsAround(NamedTuple):
    """The cells that a sphere can touch, in columns along z: a kernel walks over them by `in_column`."""

    n: int
    first: int  # cell of the first column
    deep: int  # cells of a column
    step: int  # from a column to the next along y
    turn: int  # further, from the last along y to the first of the next along x
    share: float  # of a column in those along y: a product takes less time than a division


@njit()
def columns_around(lattice: Lattice, centre: Vector, radius: float) -> ColumnsAround:
    """Return the columns of cells that a sphere around a point can touch."""
    (x, y, z), (n_x, n_y, n_z), side = lattice
    a0, a1 = cells_within(centre[0], radius, x, side, n_x)
    b0, b1 = cells_within(centre[1], radius, y, side, n_y)
    c0, c1 = cells_within(centre[2], radius, z, side, n_z)
    wide = b1 - b0 + 1
    n = (a1 - a0 + 1) * wide if min(b1 - b0, c1 - c0) >= 0 else 0
    first, turn = (a0 * n_y + b0) * n_z + c0, (n_y - wide) * n_z
    return ColumnsAround(n, first, c1 - c0 + 1, n_z, turn, 1.0 / max(wide, 1))


@njit()
def in_column(start: np.ndarray, columns: ColumnsAround, c: int) -> range:
    """Return the positions in column c, given `start` of the grid: passing all of it would take as long as the walk."""
    cell = columns.first + c * columns.step + int((c + 0.5) * columns.share) * columns.turn
    return range(start[cell], start[cell + columns.deep])


def pairs_within(points: np.ndarray, positions: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Find the points (N, 3) within a distance of each position (M, 3): both numbers of each pair, in order, (P,) each."""
    grid, positions = sort_into_grid(points, distance), np.ascontiguousarray(positions, float)
    position, found = _pairs(grid, positions, float(distance)).T
    order = np.lexsort((found, position))
    return position[order], found[order]


@njit()
def _pairs(grid: PointGrid, positions: np.ndarray, distance: float) -> np.ndarray:
    """Return each position and a point within the distance of it, (P, 2)."""
    pairs, n = np.empty((len(positions) + 1, 2), np.int64), 0
    for i in range(len(positions)):
        columns = columns_around(grid.lattice, point(positions, i), distance)
        for c in range(columns.n):
            for q in in_column(grid.start, columns, c):
                if squared_distance(point(grid.xyz, q), point(positions, i)) <= distance * distance:
                    pairs = pairs if n < len(pairs) else doubled(pairs)
                    pairs[n, 0], pairs[n, 1] = i, grid.dot[q]
                    n += 1
    return pairs[:n]


def nearest_of(points: np.ndarray, positions: np.ndarray, threads: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Find the point (N, 3) nearest to each position (M, 3), the lowest of equally near ones, and its distance, Å, (M,) each."""
    points = np.ascontiguousarray(points, np.float64)
    edge = max(float(np.prod(np.maximum(np.ptp(points, axis=0), 1e-3)) / len(points)) ** (1 / 3), 1e-3)
    positions = np.ascontiguousarray(positions, np.float64)
    return nearest_dots(sort_into_grid(points, edge), positions, edge, threads=threads)


def nearest_dots(
    grid: PointGrid,
    points: np.ndarray,
    first: float,
    itself: np.ndarray | None = None,
    threads: int = 1,
) -> tuple[np.ndarray, np.ndarray]:
    """Find the dot nearest to each point (m, 3), the lowest of equally near ones, and its distance, Å, (m,) each.

    It is looked for within `first` Å, and then twice as far each time. `itself` (m,) are positions that do not count.
    """
    dot, distance = np.full(len(points), -1), np.full(len(points), np.inf)
    itself = np.full(len(points), -1) if itself is None else itself
    parallel_map(
        lambda a, b: _write_nearest(grid, points[a:b], itself[a:b], float(first), dot[a:b], distance[a:b]),
        len(points),
        threads,
    )
    return dot, distance


@njit()
def _write_nearest(
    grid: PointGrid,
    points: np.ndarray,
    itself: np.ndarray,
    first: float,
    dot: np.ndarray,
    distance: np.ndarray,
) -> None:
    """Write the nearest dot of each point of a slice, and its distance."""
    for i in range(len(points)):
        centre = point(points, i)
        found, best, within = np.int64(-1), 0.0, first
        while found < 0 and within < OUT_OF_REACH:
            best = within * within
            columns = columns_around(grid.lattice, centre, within)
            for c in range(columns.n):
                for q in in_column(grid.start, columns, c):
                    d2 = squared_distance(point(grid.xyz, q), centre)
                    if q != itself[i] and (d2 < best or (d2 == best and grid.dot[q] < found)):
                        best, found = d2, np.int64(grid.dot[q])
            within *= 2.0
        if found >= 0:
            dot[i], distance[i] = found, math.sqrt(best)
