"""Coarse closed meshes: edges of a fine mesh are collapsed, so that every vertex that is left stays where it was.

The shortest edge goes first, and one of its ends into the other (Hoppe, SIGGRAPH 96:99). An edge may go if its ends have
exactly two neighbours in common, which keeps the mesh closed, manifold and of the same genus (Dey et al., Publ. Inst. Math.
66:23, 1999). An edge whose collapse would tilt triangles or make slivers counts as longer, and one
whose collapse would fold the mesh stays.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable

import numpy as np

from sparsurf.errors import InputError
from sparsurf.kernels import njit
from sparsurf.surfaces.chosen_points import on_steps
from sparsurf.surfaces.half_edges import (
    LEAST_FACING,
    around,
    mark_neighbours,
    may_collapse,
    n_folds,
    next_edge,
    remaining,
    remove_start,
    squared_length,
    triangle_normal,
    twins,
)
from sparsurf.surfaces.mesh import Mesh, MeshSize, build_mesh
from sparsurf.surfaces.molecular_surface import MAX_DENSITY
from sparsurf.surfaces.slivers import UPRIGHT
from sparsurf.surfaces.surface import Surface
from sparsurf.surfaces.vectors import dot, point

MIN_VERTICES = 4
GRID_STEP = 0.5  # Å, of the grid of a mesh between dots
WIDEST_STEP = 0.7  # Å, half the radius of a probe of water: wider ones miss narrow clefts
MIN_REDUCTION = 2.0  # vertices of the fine mesh for each that is left: its own sides are uneven
RESERVE = 0.9
# By which an edge counts as longer at most. On meshes of 512 and 2,048 vertices, a maximum of 2 leaves triangles of half the
# quality, and without a maximum the longest edges never go and the triangles between them become slivers.
MAX_PENALTY = 5.0
# Twice the area over the square of the longest side, .87 in an equilateral triangle, below which an edge counts as longer. At .1
# the worst triangles have half the quality; at .5 the mesh lies a sixth farther from the surface.
SLIVER = 0.3
# Below this penalty all new triangles face within 60 degrees of the normals of their corners, so that none is folded
FACING = 1.5

# Of the shortest edges, as many as may wait while others go first
EDGES_PER_VERTEX_TO_GO = 6

LOW_BITS = (1 << 32) - 1  # the second of two numbers in one


def sized_mesh(generate: Callable[[float], Mesh], size: MeshSize) -> Mesh:
    """Generate a mesh of a grid, whose step in Å is the argument of `generate`, and reduce it to the vertices that are requested.

    A mesh of `WIDEST_STEP` is reduced, or a finer one if it has too few vertices.
    """
    if size.n_vertices is None and size.density is None:
        return generate(min(size.step or GRID_STEP, WIDEST_STEP))
    mesh, step = generate(WIDEST_STEP), WIDEST_STEP
    while True:
        n = n_vertices_of(size, float(mesh.vertices.area.sum()))
        if (ratio := len(mesh.vertices) / n) >= MIN_REDUCTION:
            return decimate(mesh, n)
        # The vertices grow with the square of 1 / step; the reserve makes a second attempt rare
        step *= math.sqrt(RESERVE * ratio / MIN_REDUCTION)
        mesh = generate(step)


def n_vertices_of(size: MeshSize, area: float) -> int:
    """Return the number of vertices that is requested of a surface of an area, Å^2, at most 100 per Å^2."""
    n = size.n_vertices or max(MIN_VERTICES, round((size.density or 0.0) * area))
    if n > MAX_DENSITY * area and size.density is None:
        raise InputError(
            f"mesh: {n:,} vertices on {area:,.0f} Å^2 are more than {MAX_DENSITY} per Å^2; ask for fewer."
        )
    return n


def decimate(mesh: Mesh, n_vertices: int) -> Mesh:
    """Reduce a closed mesh to `n_vertices` in float32 of the same topology; InputError if its parts and handles need more."""
    points, normals = on_steps(mesh.vertices.points), on_steps(mesh.vertices.normals)
    origin = np.array(mesh.triangles, np.int32).ravel()
    dead, steep = np.zeros(len(mesh.triangles), bool), np.zeros(len(points), bool)
    reduce_to(n_vertices, points, normals, origin, twins(origin, len(points)), dead, steep, len(points))
    return mesh_that_is_left(mesh.vertices, origin, dead)


def reduce_to(
    n_vertices: int,
    points: np.ndarray,
    normals: np.ndarray,
    origin: np.ndarray,
    twin: np.ndarray,
    dead: np.ndarray,
    steep: np.ndarray,
    alive: int,
) -> None:
    """Collapse edges of a mesh that has `alive` vertices until `n_vertices` are left; InputError if it needs more.

    No new triangle is tilted where the surface is steep, (V,) bool.
    """
    alive = _collapse(points, normals, origin, twin, dead, steep, alive, max(n_vertices, MIN_VERTICES))
    if alive > n_vertices:
        raise InputError(
            f"mesh: this surface needs {alive:,} vertices at least, so that its parts and handles stay; ask for more."
        )


def mesh_that_is_left(vertices: Surface, origin: np.ndarray, dead: np.ndarray) -> Mesh:
    """Return the mesh of the triangles that are left, in float32."""
    kept, triangles = remaining(origin, dead)
    vertices = vertices.take(kept)
    points, normals = (
        values.astype(np.float32).astype(float) for values in (vertices.points, vertices.normals)
    )
    return build_mesh(points, normals, triangles, vertices.kind, vertices.atom)


@njit()
def _penalty(
    h: int, points: np.ndarray, normals: np.ndarray, origin: np.ndarray, twin: np.ndarray
) -> tuple[float, float]:
    """Return by which factor an edge counts as longer if its start goes into its end, and the least cosine at a new corner."""
    u, v = origin[h], origin[twin[h]]
    turn = tilt = 1.0
    shape = SLIVER
    e = around(h, twin)
    while e != h:
        x, y = origin[next_edge(e)], origin[next_edge(next_edge(e))]
        if x != v and y != v:
            before, _ = triangle_normal(points, u, x, y)
            after, size = triangle_normal(points, v, x, y)
            longest = max(
                squared_length(points, v, x), squared_length(points, x, y), squared_length(points, y, v)
            )
            shape = min(shape, size / longest)
            turn = min(turn, dot(before, after))
            for w in (v, x, y):
                tilt = min(tilt, dot(point(normals, w), after))
        e = around(e, twin)
    penalty = 1.0 + 2.0 * (1.0 - turn) + (1.0 - tilt) + 2.0 * (SLIVER / max(shape, 0.01) - 1.0)
    return min(MAX_PENALTY, penalty), tilt


@njit()
def _are_faced(h: int, faced: np.ndarray, origin: np.ndarray, twin: np.ndarray) -> bool:
    """Return whether all neighbours of the start of a half-edge are faced."""
    e = h
    while True:
        if not faced[origin[twin[e]]]:
            return False
        e = around(e, twin)
        if e == h:
            return True


@njit()
def _best_collapse(
    h: int,
    points: np.ndarray,
    normals: np.ndarray,
    origin: np.ndarray,
    twin: np.ndarray,
    faced: np.ndarray,
    steep: np.ndarray,
    seen: np.ndarray,
    stamp: int,
    may_fold: bool,
) -> tuple[int, float, float, int]:
    """Return the half-edge by whose collapse an edge goes best, or -1, its penalty and least cosine, and the last stamp.

    Where the edge itself may not go, around the neck of a tunnel, one of its ends goes into another neighbour.
    """
    best, least, least_tilt = -1, np.inf, 1.0
    stamp += 1
    locked = not may_collapse(h, origin, twin, seen, stamp)
    for side in range(2):
        e = end = int(twin[h]) if side else h
        while True:
            stamp += 1
            if not locked or may_collapse(e, origin, twin, seen, stamp):
                penalty, tilt = _penalty(e, points, normals, origin, twin)
                # Where all triangles face their corners' normals, before and after, none folds: most need no count
                folds = (
                    not may_fold
                    and FACING <= penalty < least
                    and not (tilt >= LEAST_FACING and _are_faced(e, faced, origin, twin))
                    and (
                        n_folds(e, True, points, normals, origin, twin)
                        > n_folds(e, False, points, normals, origin, twin)
                    )
                )
                if penalty < least and not folds and (tilt >= UPRIGHT or not steep[origin[e]]):
                    best, least, least_tilt = e, penalty, tilt
            e = around(e, twin)
            if e == end or not locked:
                break
    return best, least, least_tilt, stamp


@njit()
def _entry(
    h: int, cost: float, origin: np.ndarray, twin: np.ndarray, latest: np.ndarray
) -> tuple[float, int, int]:
    """Return the entry of an edge in the heap; earlier ones of it no longer count."""
    latest[h] += 1
    u, v = origin[h], origin[twin[h]]
    # After the cost the vertices, so that a tie of lengths is decided by the mesh and not by the order of the heap
    return cost, min(u, v) << 32 | max(u, v), h << 32 | latest[h]


@njit()
def _in_order(values: np.ndarray, k: int) -> float:
    """Return value number k in ascending order by Hoare's selection: for `partition`, numba loads scipy.linalg."""
    low, high = 0, len(values) - 1
    while low < high:
        pivot, i, j = values[(low + high) // 2], low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i, j = i + 1, j - 1
        if k <= j:
            high = j
        elif k >= i:
            low = i
        else:
            break
    return values[k]


@njit()
def _longest_to_go(
    n: int, points: np.ndarray, origin: np.ndarray, twin: np.ndarray, dead: np.ndarray
) -> float:
    """Return a squared length of edges that is enough for n vertices to go, so that longer ones need no place in the heap."""
    lengths, m = np.empty(len(origin) // 2), 0
    for h in range(len(origin)):
        if not dead[h // 3] and h < twin[h]:
            lengths[m] = squared_length(points, origin[h], origin[twin[h]])
            m += 1
    n_shortest = EDGES_PER_VERTEX_TO_GO * n
    return _in_order(lengths[:m], n_shortest) if n_shortest < m else np.inf


@njit()
def _collapse(
    points: np.ndarray,
    normals: np.ndarray,
    origin: np.ndarray,
    twin: np.ndarray,
    dead: np.ndarray,
    steep: np.ndarray,
    alive: int,
    n_vertices: int,
) -> int:
    """Collapse edges until `n_vertices` are left or none may go; mark the triangles that are gone, return how many are left."""
    seen, stamp = np.zeros(len(points), np.int64), 0
    # vertices whose triangles all face their normals, where that is known
    faced = np.ones(len(points), np.bool_)
    for h in range(len(origin)):
        if dead[h // 3]:
            continue
        u = origin[h]
        normal, _ = triangle_normal(points, u, origin[next_edge(h)], origin[next_edge(next_edge(h))])
        faced[u] &= dot(normal, point(normals, u)) >= LEAST_FACING
    before = alive + 1
    # entry of the heap that counts, of the lower half-edge of each edge
    latest = np.zeros(len(origin), np.int64)
    may_fold, longest = False, 0.0  # only where nothing else makes the mesh coarse enough
    while alive > n_vertices and (alive < before or not may_fold):
        stalled = alive == before
        may_fold = stalled and longest == np.inf
        longest = np.inf if stalled else _longest_to_go(alive - n_vertices, points, origin, twin, dead)
        before = alive
        heap = [(0.0, 0, 0) for _ in range(0)]
        for h in range(len(origin)):
            if not dead[h // 3] and h < twin[h]:
                cost = squared_length(points, origin[h], origin[twin[h]])
                if cost <= longest:
                    heap.append(_entry(h, cost, origin, twin, latest))
        heapq.heapify(heap)
        while len(heap) > 0 and alive > n_vertices:
            cost, _, entry = heapq.heappop(heap)
            h, entry = entry >> 32, entry & LOW_BITS
            if dead[h // 3] or entry != latest[h] or h > twin[h]:
                continue
            u, v = origin[h], origin[twin[h]]
            best, least, tilt, stamp = _best_collapse(
                h, points, normals, origin, twin, faced, steep, seen, stamp, may_fold
            )
            if best < 0:
                continue
            now = squared_length(points, u, v) * least * least
            # The penalty is computed when its edge comes up, since most edges change before; a dearer one waits again
            if now > cost:
                heapq.heappush(heap, _entry(h, now, origin, twin, latest))
                continue
            h, v = best, origin[twin[best]]
            stamp += 1
            mark_neighbours(h, origin, twin, seen, stamp)
            remove_start(h, origin, twin, dead)
            alive -= 1
            faced[v] &= tilt >= LEAST_FACING
            start = e = twin[next_edge(next_edge(h))]
            while True:
                w = origin[twin[e]]
                if seen[w] == stamp:  # the others keep their length and their triangles
                    faced[w] &= tilt >= LEAST_FACING
                    cost = squared_length(points, v, w)
                    if cost <= longest:
                        heapq.heappush(heap, _entry(min(e, twin[e]), cost, origin, twin, latest))
                e = around(e, twin)
                if e == start:
                    break
    return alive
