"""Which points lie inside a closed surface of oriented dots, by its winding number.

Each dot adds the solid angle under which its surroundings are seen, so that the sum is the same for all points inside, and 0 for
all outside. Dots of a distant cube are seen as one, and so are cubes of a block that is farther away.
"""

from __future__ import annotations

import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.vectors import Vector, dot, point, slots, subtract
from sparsurf.threads import parallel_map

EDGE_OF_CUBES = 8.0  # Å, edge of the cubes whose dots are seen as one from afar
CUBES_PER_BLOCK = 4  # along an edge, of the blocks whose cubes are seen as one from farther away
FAR = 2.0  # edges, from the middle of a cube or block: there the sum of its dots differs by less than a hundredth
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
        cube = ((points - points.min(axis=0)) // EDGE_OF_CUBES).astype(np.int64)
        block, within = np.divmod(cube, CUBES_PER_BLOCK)
        key = np.ravel_multi_index((*block.T, *within.T), (*block.max(axis=0) + 1, *[CUBES_PER_BLOCK] * 3))
        order = np.argsort(key, kind="stable")
        points, normals, key = points[order], normals[order], key[order]
        first = _starts(key)
        blocks = _starts(key[first[:-1]] // CUBES_PER_BLOCK**3)
        self._levels = (
            (points, normals),
            _together(points, normals, first),
            _together(points, normals, first[blocks]),
        )
        self._lists = first, blocks
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
            lambda begin, end: _solid_angles(points[begin:end], *self._levels, *self._lists),
            len(points),
            threads,
            PLACES_PER_TASK,
        )
        return np.concatenate([*parts, np.empty(0)])


def _starts(key: np.ndarray) -> np.ndarray:
    """Return where each of the equal ascending keys begins, and their number."""
    return np.append(np.flatnonzero(np.diff(key, prepend=-1)), len(key))


def _together(points: np.ndarray, normals: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean position of the dots of each list, and the sum of their normals."""
    middle = np.add.reduceat(points, first[:-1], axis=0) / np.diff(first)[:, None]
    return middle, np.add.reduceat(normals, first[:-1], axis=0)


@njit(cache=True, nogil=True)
def _solid_angles(
    places: np.ndarray,
    dots: tuple[np.ndarray, np.ndarray],
    cubes: tuple[np.ndarray, np.ndarray],
    blocks: tuple[np.ndarray, np.ndarray],
    first: np.ndarray,
    first_cube: np.ndarray,
) -> np.ndarray:
    """Return the sum over the dots of (dot - place) . normal / distance^3 at each place; a distant cube or block is one dot."""
    out, far2 = np.empty(len(places)), (FAR * EDGE_OF_CUBES) ** 2
    for i in range(len(places)):
        place, total = point(places, i), 0.0
        for b in range(len(first_cube) - 1):
            angle, d2 = _solid_angle(blocks, b, place, 0.0)
            if d2 > CUBES_PER_BLOCK**2 * far2:
                total += angle
                continue
            for k in slots(first_cube, b):
                angle, d2 = _solid_angle(cubes, k, place, 0.0)
                if d2 > far2:
                    total += angle
                    continue
                for q in slots(first, k):
                    total += _solid_angle(dots, q, place, ADDED_TO_SQUARES)[0]
        out[i] = total
    return out


@njit(cache=True, nogil=True)
def _solid_angle(
    dots: tuple[np.ndarray, np.ndarray], k: int, place: Vector, added: float
) -> tuple[float, float]:
    """Return the solid angle of dot k at a place, up to a factor, and the square of its distance."""
    w = subtract(point(dots[0], k), place)
    d2 = dot(w, w) + added
    return dot(w, point(dots[1], k)) / (d2 * math.sqrt(d2) + 1e-300), d2
