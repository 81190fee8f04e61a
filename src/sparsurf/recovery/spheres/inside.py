"""Which points lie inside a closed surface of oriented dots, by its winding number.

Each dot adds the solid angle under which its surroundings are seen, so that the sum is the same for all points inside, and 0 for
all outside. Dots of a distant cube are seen as one.
"""

from __future__ import annotations

import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, build_grid
from sparsurf.surfaces.vectors import point, slots
from sparsurf.threads import parallel_map

EDGE_OF_CUBES = 8.0  # Å, edge of the cubes whose dots are seen as one from afar
FAR = 2.0  # edges, from the middle of a cube: there the sum of its dots differs by less than a hundredth
ADDED_TO_SQUARES = (
    0.01  # Å^2, added to squared distances, so that a dot next to a point does not decide alone
)
SAMPLE = 300  # dots, next to which inside and outside are measured
PLACES_PER_TASK = 1024


class Inside:
    """A closed surface of dots (n, 3) with outward unit normals, asked which points lie inside."""

    def __init__(
        self, points: np.ndarray, normals: np.ndarray, outside: np.ndarray, inside: np.ndarray
    ) -> None:
        """Sort the dots into cubes, and measure the sums at points known to lie outside (m, 3) and inside (m, 3)."""
        self._grid = build_grid(points, normals, EDGE_OF_CUBES)
        first, last = self._grid.start[:-1], self._grid.start[1:]
        filled = np.flatnonzero(last > first)
        self._first = np.append(first[filled], len(points))
        count = np.diff(self._first)
        self._middle = np.add.reduceat(self._grid.xyz, self._first[:-1], axis=0) / count[:, None]
        self._normal = np.add.reduceat(self._grid.normals, self._first[:-1], axis=0)
        sample = slice(None, None, max(1, len(outside) // SAMPLE))
        self._outside = float(np.median(self._sums(outside[sample])))
        self._inside = float(np.median(self._sums(inside[sample])))

    def winding_numbers(self, points: np.ndarray, threads: int = 1) -> np.ndarray:
        """Return the winding number of points, (m,): 1 inside and 0 outside."""
        return (self._sums(points, threads) - self._outside) / (self._inside - self._outside)

    def _sums(self, points: np.ndarray, threads: int = 1) -> np.ndarray:
        """Return the sum of the solid angles of all dots at points (m, 3), up to a factor."""
        points = np.ascontiguousarray(points)
        parts = parallel_map(
            lambda begin, end: _solid_angles(
                points[begin:end], self._grid, self._first, self._middle, self._normal
            ),
            len(points),
            threads,
            PLACES_PER_TASK,
        )
        return np.concatenate([*parts, np.empty(0)])


@njit()
def _solid_angles(
    points: np.ndarray, grid: PatchIndex, first: np.ndarray, middle: np.ndarray, normal: np.ndarray
) -> np.ndarray:
    """Return the sum over the dots of (dot - point) . normal / distance^3 at each point."""
    out, far2 = np.empty(len(points)), (FAR * grid.lattice.side) ** 2
    for i in range(len(points)):
        total = 0.0
        x, y, z = point(points, i)
        for k in range(len(middle)):
            u, v, w = middle[k, 0] - x, middle[k, 1] - y, middle[k, 2] - z
            d2 = u * u + v * v + w * w
            if d2 > far2:
                total += (u * normal[k, 0] + v * normal[k, 1] + w * normal[k, 2]) / (d2 * math.sqrt(d2))
                continue
            for q in slots(first, k):
                u, v, w = grid.xyz[q, 0] - x, grid.xyz[q, 1] - y, grid.xyz[q, 2] - z
                d2 = u * u + v * v + w * w + ADDED_TO_SQUARES
                along = u * grid.normals[q, 0] + v * grid.normals[q, 1] + w * grid.normals[q, 2]
                total += along / (d2 * math.sqrt(d2))
        out[i] = total
    return out
