"""Exact distances from the solvent-excluded surface of spheres, without dots or a mesh of it.

The surface lies at the probe's radius from all places that the probe's centre can take. So the distance of a point from it is
the probe's radius minus that to the nearest of these places, which lies on the accessible patch of a sphere of centres, on an arc
or at a fixed probe of `rolling_probe`. A point at such a place itself is as far from the surface as from the nearest sphere.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.components import are_accessible, enclosed_of
from sparsurf.surfaces.grid import PointGrid, columns_around, in_column, sort_into_grid
from sparsurf.surfaces.rolling_probe import (
    ARC_RADIUS,
    E1,
    E2,
    THETA_I,
    THETA_J,
    EnclosedCentres,
    Rolling,
    T,
    U,
    blocker,
    is_enclosed,
    nearest_on_arc,
)
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE
from sparsurf.surfaces.vectors import (
    Vector,
    add_scaled,
    cross,
    dot,
    point,
    scaled,
    set_point,
    slots,
    squared_distance,
    subtract,
    vector_at,
)
from sparsurf.threads import parallel_map

if TYPE_CHECKING:
    from sparsurf.surfaces.dot_placement import Rolled

POSITIONS_PER_TASK = 4096
FIRST_DEPTH = 0.5  # Å, to which all points are searched; only those that lie deeper are searched twice as deep each time
DEEPEST = 10.0  # Å
# Å^2, far above the rounding of squared distances, so that no nearer place is passed over
ROUNDING_OF_SQUARES = 1e-9
# Å, between the centre of a probe and a sphere that it touches: above the shift of the spheres, far below what errors show
ROUNDING_OF_TOUCH = 1e-7


def exact_distance(
    points: np.ndarray, rolled: Rolled, deepest: float = DEEPEST, threads: int = 1
) -> np.ndarray:
    """Compute the signed distance of points from the solvent-excluded surface of the spheres that a probe was rolled over.

    It is exact to the 1e-8 Å by which the spheres are shifted before the probe is rolled. Places in cavities count unless
    `rolled` removes these. The surface is that of `reentrant` 'exact' whatever `rolled` says.

    Parameters
    ----------
    points : (N, 3) float, Å
    rolled : result of `roll_spheres` or `roll_frame`
    deepest : depth to which places of the probe are searched, Å, default 10
    threads : number of threads, default 1

    Returns
    -------
    (N,) float64, Å: positive outside of the surface; negative inside, down to -`deepest`, which all deeper points get

    Examples
    --------
    >>> from sparsurf.surfaces.molecular_surface import roll_spheres
    >>> rolled = roll_spheres([[0.0, 0.0, 0.0]], [1.5], probe=1.4)
    >>> exact_distance(np.array([[1.6, 0.0, 0.0], [0.0, 0.5, 0.0], [9.0, 0.0, 0.0]]), rolled).round(6)
    array([ 0.1, -1. ,  7.5])
    """
    rolling, probe, enclosed = rolled.rolling, rolled.probe, enclosed_of(rolled)
    positions = np.asarray(points, float) - rolled.origin
    grid = sort_into_grid(rolling.atoms.centre, rolling.atoms.reach.max() + probe)
    height = np.empty(len(positions))
    parallel_map(
        lambda a, b: _write_heights(positions[a:b], rolling, enclosed, grid, height[a:b]),
        len(positions),
        threads,
        POSITIONS_PER_TASK,
    )
    distance, remaining, depth = probe + height, np.flatnonzero(height < 0), min(FIRST_DEPTH, deepest)
    while len(remaining):
        gap, *_ = nearest_centres(positions[remaining], rolling, enclosed, probe + depth, threads)
        is_deeper = gap >= probe + depth
        distance[remaining] = np.where(is_deeper, -depth, probe - gap)
        if depth == deepest:
            break
        remaining, depth = remaining[is_deeper], min(2 * depth, deepest)
    return distance


def distance_of_dots(points: np.ndarray, normals: np.ndarray, rolled: Rolled, threads: int = 1) -> np.ndarray:
    """Compute the distance (N,), Å, of dots with unit normals from the surface of `exact_distance`, on either side of it.

    Most dots of a surface that was reconstructed from atoms lie on it: their own probe says so, and they need no search.
    """
    rolling, probe, enclosed = rolled.rolling, rolled.probe, enclosed_of(rolled)
    positions, normals = np.asarray(points, float) - rolled.origin, np.ascontiguousarray(normals)
    grid = sort_into_grid(rolling.atoms.centre, rolling.atoms.reach.max() + ROUNDING_OF_TOUCH)
    lies_on = np.empty(len(positions), bool)
    parallel_map(
        lambda a, b: _write_lies_on(
            positions[a:b], normals[a:b], probe, rolling, enclosed, grid, lies_on[a:b]
        ),
        len(positions),
        threads,
        POSITIONS_PER_TASK,
    )
    distance = np.zeros(len(positions))
    distance[~lies_on] = np.abs(exact_distance(points[~lies_on], rolled, threads=threads))
    return distance


@njit()
def _write_lies_on(
    positions: np.ndarray,
    normals: np.ndarray,
    probe: float,
    rolling: Rolling,
    enclosed: EnclosedCentres,
    grid: PointGrid,
    lies_on: np.ndarray,
) -> None:
    """Write for each dot of a slice whether its probe proves that it lies on the surface.

    A dot x lies on the surface if the centre q of its probe is free, and x lies in the convex hull of q and the centres c of
    spheres that the probe touches. Proof: |y - c| >= |q - c| for every free centre y, hence 2 (y - q) . (c - q) <= |y - q|^2.
    With x - q = sum of a (c - q), where no a is negative and their sum is at most 1, it follows that
    |y - x|^2 = |x - q|^2 + |y - q|^2 - 2 (y - q) . (x - q) >= |x - q|^2: no free centre is nearer to x than q is.
    """
    centre, reach = rolling.atoms.centre, rolling.atoms.reach
    touched = np.empty(3, np.int64)
    for n in range(len(positions)):
        inward = scaled(-probe, point(normals, n))
        place, m, is_free = subtract(point(positions, n), inward), 0, True
        columns = columns_around(grid.lattice, place, grid.lattice.side)
        for c in range(columns.n):
            for q in in_column(grid.start, columns, c):
                k, d2 = grid.dot[q], squared_distance(point(grid.xyz, q), place)
                if d2 < (reach[k] + ROUNDING_OF_TOUCH) ** 2:
                    is_free &= d2 > (reach[k] - ROUNDING_OF_TOUCH) ** 2
                    if m < 3:
                        touched[m] = k
                    m += 1
        lies_on[n] = (
            is_free
            and 0 < m <= 3
            and _is_in_hull(inward, place, centre, touched[:m])
            and not is_enclosed(place, touched[0], rolling, enclosed)
        )


@njit()
def _is_in_hull(inward: Vector, place: Vector, centre: np.ndarray, touched: np.ndarray) -> bool:
    """Return whether the way from a place lies in the hull of the ways to one, two or three touched centres, and 0."""
    a = subtract(point(centre, touched[0]), place)
    if len(touched) == 1:
        x, y, z = dot(inward, a) / dot(a, a), 0.0, 0.0
        b = c = a
    else:
        b = subtract(point(centre, touched[1]), place)
        normal = cross(a, b)
        c = subtract(point(centre, touched[2]), place) if len(touched) == 3 else normal
        whole = dot(normal, c)
        if whole == 0.0:
            return False
        x, y, z = (
            dot(inward, cross(b, c)) / whole,
            dot(inward, cross(c, a)) / whole,
            dot(inward, normal) / whole,
        )
        if len(touched) == 2:
            z = 0.0
    x, y, z = max(x, 0.0), max(y, 0.0), max(z, 0.0)
    remainder = add_scaled(add_scaled(add_scaled(inward, -x, a), -y, b), -z, c)
    return x + y + z <= 1.0 and dot(remainder, remainder) < ROUNDING_OF_TOUCH**2


@njit()
def _write_heights(
    positions: np.ndarray, rolling: Rolling, enclosed: EnclosedCentres, grid: PointGrid, heights: np.ndarray
) -> None:
    """Write the height of each position of a slice over the spheres of centres, below 0 where no probe's centre can be.

    The way from a position in no sphere to the nearest sphere is free, so that the nearest place there tells about cavities.
    """
    centre, reach = rolling.atoms.centre, rolling.atoms.reach
    largest = 0.0  # not `reach.max()`, for which numba loads scipy.linalg
    for radius in reach:
        largest = max(largest, radius)
    certain = grid.lattice.side - largest  # no sphere beyond the side of the grid is nearer than this
    for n in range(len(positions)):
        position, nearest, height = point(positions, n), -1, certain
        columns = columns_around(grid.lattice, position, grid.lattice.side)
        for c in range(columns.n):
            for q in in_column(grid.start, columns, c):
                k = grid.dot[q]
                above = math.sqrt(squared_distance(point(centre, k), position)) - reach[k]
                if above < height:
                    nearest, height = k, above
        if nearest < 0:
            height = np.inf
            for k in range(len(centre)):
                above = math.sqrt(squared_distance(point(centre, k), position)) - reach[k]
                if above < height:
                    nearest, height = k, above
        heights[n] = height
        if height >= 0:
            w = subtract(position, point(centre, nearest))
            touching = add_scaled(point(centre, nearest), reach[nearest] / (height + reach[nearest]), w)
            if is_enclosed(touching, nearest, rolling, enclosed):
                heights[n] = -1.0


def nearest_centres(
    positions: np.ndarray,
    rolling: Rolling,
    enclosed: EnclosedCentres,
    limit: float,
    threads: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Find the nearest accessible centre that is not enclosed, less than `limit` Å away.

    Return distance (n,), which is `limit` where there is none, centre (n, 3), kind and atom (n,).
    """
    n = len(positions)
    gap, centres, kind, atom = np.empty(n), np.zeros((n, 3)), np.zeros(n, np.int8), np.zeros(n, np.int64)
    probes, exposed = sort_into_grid(rolling.probes, limit), _exposed_atoms(rolling)
    atoms = sort_into_grid(rolling.atoms.centre[exposed], rolling.atoms.reach.max() + limit)
    atoms = atoms._replace(dot=exposed[atoms.dot].astype(np.int32))
    parallel_map(
        lambda a, b: _search_centres(
            positions[a:b],
            rolling,
            enclosed,
            probes,
            atoms,
            limit,
            gap[a:b],
            centres[a:b],
            kind[a:b],
            atom[a:b],
        ),
        n,
        threads,
        POSITIONS_PER_TASK,
    )
    return gap, centres, kind, atom


def _exposed_atoms(rolling: Rolling) -> np.ndarray:
    """Return the atoms that the probe touches, ascending: those on arcs, and those whose sphere no other one meets."""
    centre, reach = rolling.atoms.centre, rolling.atoms.reach
    exposed = are_accessible(centre + reach[:, None] * [1.0, 0.0, 0.0], rolling.atoms)
    exposed[rolling.pair] = True
    return np.flatnonzero(exposed)


@njit()
def _search_centres(
    positions: np.ndarray,
    rolling: Rolling,
    enclosed: EnclosedCentres,
    probes: PointGrid,
    atoms: PointGrid,
    limit: float,
    gap: np.ndarray,
    centres: np.ndarray,
    kind: np.ndarray,
    atom: np.ndarray,
) -> None:
    """Fill in `nearest_centres` of a slice: among the fixed probes, then on the arcs and the patches of the atoms around.

    The atom is that which a dot at this place belongs to, by the rules of `dot_placement`.
    """
    for n in range(len(positions)):
        position, best, nearest = point(positions, n), limit * limit, (0.0, 0.0, 0.0)
        source = -1  # the fixed probe, the arc or the atom
        columns = columns_around(probes.lattice, position, limit)
        for c in range(columns.n):
            for q in in_column(probes.start, columns, c):
                k, d2 = probes.dot[q], squared_distance(point(probes.xyz, q), position)
                if d2 < best and not enclosed.probes[k]:
                    nearest, kind[n], source, best = point(probes.xyz, q), CONCAVE, k, d2
        root = math.sqrt(best)
        columns = columns_around(atoms.lattice, position, atoms.lattice.side)
        for c in range(columns.n):
            for q in in_column(atoms.start, columns, c):
                k = atoms.dot[q]
                centre, reach = point(rolling.atoms.centre, k), rolling.atoms.reach[k]
                w = subtract(position, centre)
                d2 = dot(w, w)
                if d2 > (reach + root) ** 2 + ROUNDING_OF_SQUARES:  # most atoms; their root takes longer
                    continue
                d = math.sqrt(d2)
                if abs(d - reach) > root:
                    continue
                for b in slots(rolling.first_arc, k):
                    if enclosed.arcs[b] or not _may_be_nearer(position, rolling.arcs[b], best):
                        continue
                    candidate, is_on_arc = nearest_on_arc(position, rolling.arcs[b])
                    if is_on_arc and squared_distance(candidate, position) < best:
                        nearest, kind[n], best = candidate, SADDLE, squared_distance(candidate, position)
                        source = b
                if (d - reach) ** 2 < best and d > 0:
                    candidate = add_scaled(centre, reach / d, w)
                    accessible = blocker(candidate, k, rolling.atoms, -1) < 0
                    if accessible and not is_enclosed(candidate, k, rolling, enclosed):
                        nearest, kind[n], best = candidate, CONTACT, (d - reach) ** 2
                        source = k
                root = math.sqrt(best)
        gap[n] = math.sqrt(best)
        if source >= 0:
            atom[n] = _owner(position, nearest, kind[n], source, rolling)
        set_point(centres, n, nearest)


@njit()
def _may_be_nearer(position: Vector, arc: np.ndarray, best: float) -> bool:
    """Return whether the circle of an arc passes at less than a squared distance from a position, without its nearest point."""
    w = subtract(position, vector_at(arc, T))
    height, p1, p2 = dot(w, vector_at(arc, U)), dot(w, vector_at(arc, E1)), dot(w, vector_at(arc, E2))
    off = math.sqrt(p1 * p1 + p2 * p2) - arc[ARC_RADIUS]
    return height * height + off * off < best + ROUNDING_OF_SQUARES


@njit()
def _owner(position: Vector, centre: Vector, kind: int, source: int, rolling: Rolling) -> int:
    """Return the atom that the point below a probe at `centre` belongs to; `source` is the atom, the arc or the fixed probe."""
    if kind == CONTACT:
        return source
    if kind == SADDLE:
        arc, w = rolling.arcs[source], subtract(position, centre)
        theta = math.asin(min(1.0, max(-1.0, dot(w, vector_at(arc, U)) / math.sqrt(dot(w, w)))))
        return rolling.pair[source, int(2 * theta > arc[THETA_I] + arc[THETA_J])]
    owner = rolling.triple[source, 0]
    for c in range(1, 3):
        other = rolling.triple[source, c]
        nearest = squared_distance(point(rolling.atoms.centre, owner), position)
        if squared_distance(point(rolling.atoms.centre, other), position) < nearest:
            owner = other
    return owner
