"""Closed meshes of molecular surfaces: a signed distance on a grid, its triangles, their corners moved onto the surface.

The triangles are those of marching tetrahedra. Every cube of the grid is divided into the six tetrahedra around its
diagonal (Freudenthal, Ann. Math. 43:580, 1942); those of neighbouring cubes match face to face. The surface crosses a
tetrahedron in one triangle or two, whose corners lie on its edges and are shared with all tetrahedra around them. So
every edge of the mesh belongs to two triangles, whatever the values are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import permutations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sparsurf.arguments import Cavities
from sparsurf.display import Shown
from sparsurf.errors import InputError
from sparsurf.kernels import njit
from sparsurf.surfaces.components import all_other_centres, enclosed_of
from sparsurf.surfaces.dot_placement import Rolled, roll_checked
from sparsurf.surfaces.exact_distance import nearest_centres
from sparsurf.surfaces.half_edges import unfold
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.rolling_probe import (
    ARC_RADIUS,
    OPEN,
    EnclosedCentres,
    Rolling,
    T,
    is_enclosed,
)
from sparsurf.surfaces.surface import Surface
from sparsurf.surfaces.vectors import (
    add_scaled,
    cross,
    dot,
    point,
    subtract,
)
from sparsurf.threads import bytes_of_memory

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike, DTypeLike

GRID_STEP = 0.5  # Å
# No value on a side of the grid may lie inside, or the mesh would be open there
MARGIN_STEPS = 2  # of the grid around the surface
MAX_GRID_POINTS = 400_000_000  # more would take over 4 GB
MIN_SHARE_OF_EDGE = 0.02  # between a vertex and the end of its edge
# values, distances and cut edges of a mesh between dots; one of spheres takes a quarter of it
BYTES_PER_GRID_POINT = 20
SAME_DEPTH = 1e-9  # Å; of two spheres that are equally near, either decides
SLAB_POINTS = 4_000_000  # of the grid whose values are held at once
# Where the deepest sphere puts a grid point: far from all, where a probe's centre may be, in reach of a probe, in a sphere
OUTSIDE_PROBE, AT_PROBE, BETWEEN, IN_SPHERE = 0, 1, 2, 3


@dataclass(frozen=True)
class Mesh(Shown):
    """A closed surface of triangles; `numpy.asarray` returns the points of its vertices, (V, 3).

    Attributes
    ----------
    vertices : Surface; the area of each is a third of that of the triangles around it, and `atom` is the index of the atom
        that it lies on, as for dots
    triangles : (F, 3) int64, counterclockwise seen from outside; every edge belongs to two of them
    """

    vertices: Surface
    triangles: NDArray[np.int64]

    def to_frame(self) -> pd.DataFrame:
        """Tabulate position, normal, area, kind, labels of the atom and fields of the vertices, as `to_frame` of a Surface."""
        return self.vertices.to_frame()

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> np.ndarray:
        """Return the points of the vertices, (V, 3), for `numpy.asarray`."""
        return self.vertices.__array__(dtype, copy)

    def __repr__(self) -> str:
        return f"Mesh of {len(self.triangles):,} triangles"

    @property
    def area(self) -> float:
        """Area of the triangles, Å^2."""
        return float(self.vertices.area.sum())

    @property
    def volume(self) -> float:
        """Volume in Å^3, without that of cavities."""
        # from one of the vertices, so that the terms do not grow with the distance from the origin
        points = self.vertices.points - self.vertices.points[:1]
        a, b, c = (points[self.triangles[:, k]] for k in range(3))
        return float(np.sum(a * np.cross(b, c)) / 6)


@njit()
def _areas_around(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return a third of the area of the triangles around each point, (V,)."""
    area = np.zeros(len(points))
    for f in range(len(triangles)):
        a = point(points, triangles[f, 0])
        w = cross(subtract(point(points, triangles[f, 1]), a), subtract(point(points, triangles[f, 2]), a))
        third = math.sqrt(dot(w, w)) / 6
        for k in range(3):
            area[triangles[f, k]] += third
    return area


def widest_step(probe: float) -> float:
    """Return the widest step of a grid, Å, for a probe: no edge may cross the space between surface and centres."""
    return probe / 2


def build_mesh(
    points: np.ndarray,
    normals: np.ndarray,
    triangles: NDArray[np.int64],
    kind: np.ndarray | None = None,
    atom: np.ndarray | None = None,
) -> Mesh:
    """Make a Mesh of points (V, 3), Å, normals (V, 3), triangles (F, 3) and, where known, kinds and atoms of the points (V,)."""
    area = _areas_around(np.ascontiguousarray(points, float), triangles)
    return Mesh(Surface(points, normals, area, kind, atom), triangles)


def grid_around(points: np.ndarray, reach: float, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Place a grid of at most `MAX_GRID_POINTS` that extends by `reach` Å beyond all points: its lowest corner and its shape."""
    low = points.min(axis=0) - reach - MARGIN_STEPS * step
    with np.errstate(over="ignore"):  # of a step near 0
        steps = np.ceil((points.max(axis=0) + reach - low) / step) + MARGIN_STEPS + 1
        too_fine = np.prod(steps) > MAX_GRID_POINTS
    if too_fine:
        raise InputError(
            f"mesh: a grid of {step:g} Å would have {' x '.join(f'{n:.12g}' for n in steps)} points, more than "
            f"{MAX_GRID_POINTS:.0e}; give a wider step, or a smaller density."
        )
    shape = steps.astype(np.int64)
    needed, present = float(np.prod(shape)) * BYTES_PER_GRID_POINT, bytes_of_memory()
    if needed > present:
        raise InputError(
            f"mesh: a grid of {step:g} Å needs {needed / 1e9:.0f} GB, more than the {present / 1e9:.0f} GB of this machine; "
            "give a wider step, or a smaller density."
        )
    return low, shape


def molecular_mesh(
    xyz: ArrayLike,
    radii: ArrayLike,
    probe: float = PROBE_RADIUS,
    step: float = GRID_STEP,
    threads: int = 1,
    cavities: Cavities = "keep",
) -> Mesh:
    """Generate the solvent-excluded surface of spheres, (A, 3) and (A,) Å, as a Mesh whose corners lie on the surface.

    The surface lies at the probe's radius from all positions that the probe's centre can take: the nearest of these determines
    on which side a point is, and which point of the surface is nearest to it. `step` is at most half the probe's radius.
    Where `cavities` are to be removed, only positions from which the probe can leave count, so that the mesh is closed although
    walls of cavities touch the outside at cusps.
    """
    spheres = roll_checked(xyz, radii, probe, cavities=cavities, in_order=True)
    step, enclosed = min(step, widest_step(probe)), enclosed_of(spheres)
    low, shape = grid_around(spheres.rolling.atoms.centre, spheres.radii.max(), step)
    return _mesh_of_grid(spheres, enclosed, enclosed, False, MeshGrid(low, shape, step), threads)


def cavity_mesh(spheres: Rolled, cavity: EnclosedCentres, step: float, threads: int = 1) -> Mesh:
    """Generate the wall of one cavity as a Mesh of its own, also where the walls of two cavities meet at a cusp.

    The spheres were rolled over in their order, `cavity` is one of their `centres_of_cavities`, and `step` that of
    `molecular_mesh`.
    """
    step, arcs = min(step, widest_step(spheres.probe)), spheres.rolling.arcs[cavity.arcs]
    reach = arcs[:, ARC_RADIUS, None]
    around = np.concatenate([arcs[:, T : T + 3] - reach, arcs[:, T : T + 3] + reach])
    low, shape = grid_around(around, spheres.probe, step)
    return _mesh_of_grid(
        spheres, cavity, all_other_centres(cavity), True, MeshGrid(low, shape, step), threads
    )


class MeshGrid(NamedTuple):
    """A grid of points in cubes."""

    low: np.ndarray  # (3,) Å, its lowest corner, relative to the first sphere
    shape: np.ndarray  # (3,) int64
    step: float  # Å


def _mesh_of_grid(
    spheres: Rolled,
    enclosed: EnclosedCentres,
    left_out: EnclosedCentres,
    is_wall: bool,
    grid: MeshGrid,
    threads: int,
) -> Mesh:
    """Return the mesh around all grid points that are nearer than a probe's radius to no centre, but for those that are left out.

    Only the side of points near a sphere is in doubt, and of those that reach `enclosed` centres, or of all others where it is
    the wall of these. Values are held for some planes of the grid at a time.
    """
    rolling, probe = spheres.rolling, spheres.probe
    # A point that an edge of the grid joins to the surface lies at most a diagonal of a cube from it
    limit = probe + math.sqrt(3) * grid.step
    n_planes, *plane = grid.shape.tolist()
    thickness = max(2, SLAB_POINTS // math.prod(plane))
    slabs = [(a, min(a + thickness, n_planes)) for a in range(0, n_planes, thickness)]
    kinds, is_enclosed_at = np.empty(grid.shape, np.uint8), np.zeros(grid.shape, np.bool_)
    for a, b in slabs:
        values, near = _deepest_of_slab(spheres, grid, a, b)
        _classify(values, probe, kinds[a:b])
        _mark_enclosed(values, rolling, enclosed, spheres.radii, near, *grid, a, probe, is_enclosed_at)
    _flood(kinds, is_enclosed_at)
    is_doubtful = np.logical_not(is_enclosed_at, out=is_enclosed_at) if is_wall else is_enclosed_at
    inside, cut = np.zeros(grid.shape, np.bool_), np.zeros(grid.shape, np.uint8)
    vertices, last = [], np.empty((0, *plane))
    for a, b in slabs:
        if len(slabs) > 1:
            values, _ = _deepest_of_slab(spheres, grid, a, b)
        doubtful = _doubtful(kinds, is_doubtful, values, a, limit - probe)
        i, j, k = np.unravel_index(doubtful, values.shape)
        positions = grid.low + grid.step * np.stack([i + a, j, k], axis=1)
        gap, *_ = nearest_centres(positions, rolling, left_out, limit, threads)
        values.ravel()[doubtful] = gap - probe
        inside[a:b] = values > 0
        # The edges of the last plane lead into the next slab
        together, first = np.concatenate([last, values]), a - len(last)
        edges = _cut_edges(together)
        edges[len(together) - (b < n_planes) :] = 0
        cut[first:b] = edges
        vertices.append(_vertices(together, edges, first))
        last = values[-1:].copy()
    del values, together, edges, kinds, is_enclosed_at, is_doubtful
    triangles = _triangles(inside, cut)
    del inside, cut
    corners = grid.low + grid.step * np.concatenate(vertices)
    gap, centres, kind, atom = nearest_centres(corners, rolling, left_out, limit, threads)
    outward = (centres - corners) / gap[:, None]
    points = centres - probe * outward + spheres.origin
    del corners, centres, gap, vertices
    kept, triangles = unfold(points, outward, triangles)
    return build_mesh(points[kept], outward[kept], triangles, kind[kept], spheres.atom[atom[kept]])


def _deepest_of_slab(spheres: Rolled, grid: MeshGrid, begin: int, end: int) -> tuple[np.ndarray, np.ndarray]:
    """Return `_deepest` of the planes from one to another of the grid, and the spheres near them."""
    deepest, centre = 2 * spheres.probe, spheres.rolling.atoms.centre
    half = grid.step * (end - 1 - begin) / 2
    distance = np.abs(centre[:, 0] - (grid.low[0] + grid.step * begin + half))
    near = np.flatnonzero(distance <= half + spheres.radii + deepest + grid.step)
    return _deepest(centre, spheres.radii, near, *grid, begin, end, -deepest), near


@njit()
def _deepest(
    centre: np.ndarray,
    radii: np.ndarray,
    near: np.ndarray,
    low: np.ndarray,
    shape: np.ndarray,
    step: float,
    begin: int,
    end: int,
    lowest: float,
) -> np.ndarray:
    """Return the depth below the surface of the deepest sphere around each point of some planes, (X, Y, Z), at least `lowest`."""
    values = np.full((end - begin, shape[1], shape[2]), lowest)
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    for a in near:
        for c in range(3):
            first[c] = max(0, math.ceil((centre[a, c] - radii[a] + lowest - low[c]) / step))
            last[c] = min(shape[c] - 1, math.floor((centre[a, c] + radii[a] - lowest - low[c]) / step))
        for i in range(max(begin, first[0]), min(end - 1, last[0]) + 1):
            x = low[0] + i * step - centre[a, 0]
            for j in range(first[1], last[1] + 1):
                y = low[1] + j * step - centre[a, 1]
                for k in range(first[2], last[2] + 1):
                    z = low[2] + k * step - centre[a, 2]
                    depth = radii[a] - math.sqrt(x * x + y * y + z * z)
                    if depth > values[i - begin, j, k]:
                        values[i - begin, j, k] = depth
    return values


@njit()
def _classify(values: np.ndarray, probe: float, kinds: np.ndarray) -> None:
    """Write where each grid point of a slab is."""
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            for k in range(values.shape[2]):
                v = values[i, j, k]
                kinds[i, j, k] = (
                    OUTSIDE_PROBE
                    if v <= -2 * probe
                    else AT_PROBE
                    if v <= -probe
                    else BETWEEN
                    if v <= 0
                    else IN_SPHERE
                )


@njit()
def _mark_enclosed(
    values: np.ndarray,
    rolling: Rolling,
    enclosed: EnclosedCentres,
    radii: np.ndarray,
    near: np.ndarray,
    low: np.ndarray,
    shape: np.ndarray,
    step: float,
    begin: int,
    probe: float,
    found: np.ndarray,
) -> None:
    """Mark the points of a slab from which the centre of a probe reaches a cavity, and not the outside.

    This tells the sphere nearest to a point that lies up to a probe's radius from it.
    """
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    centre, reach = rolling.atoms.centre, rolling.atoms.reach
    for a in near:
        if enclosed.atoms[a] == OPEN:
            continue
        for c in range(3):
            first[c] = max(0, math.ceil((centre[a, c] - radii[a] - 2 * probe - low[c]) / step))
            last[c] = min(shape[c] - 1, math.floor((centre[a, c] + radii[a] + 2 * probe - low[c]) / step))
        for i in range(max(begin, first[0]), min(begin + len(values) - 1, last[0]) + 1):
            for j in range(first[1], last[1] + 1):
                for k in range(first[2], last[2] + 1):
                    value = values[i - begin, j, k]
                    if not -2 * probe < value <= -probe or found[i, j, k]:
                        continue
                    position = (low[0] + i * step, low[1] + j * step, low[2] + k * step)
                    w = subtract(position, point(centre, a))
                    d = math.sqrt(dot(w, w))
                    if radii[a] - d < value - SAME_DEPTH:
                        continue  # another sphere is nearer
                    touching = add_scaled(point(centre, a), reach[a] / d, w)
                    if is_enclosed(touching, a, rolling, enclosed):
                        found[i, j, k] = True


@njit()
def _flood(kinds: np.ndarray, found: np.ndarray) -> None:
    """Mark the points far from all spheres that are joined to marked ones: side by side, they lie in one cavity."""
    waiting = [(0, 0, 0) for _ in range(0)]
    nx, ny, nz = kinds.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if not found[i, j, k] or kinds[i, j, k] != AT_PROBE:
                    continue
                waiting.append((i, j, k))
                while len(waiting) > 0:
                    x, y, z = waiting.pop()
                    for c in range(6):
                        side = 1 if c % 2 else -1
                        u, v, w = x + side * (c // 2 == 0), y + side * (c // 2 == 1), z + side * (c // 2 == 2)
                        if kinds[u, v, w] == OUTSIDE_PROBE and not found[u, v, w]:
                            found[u, v, w] = True
                            waiting.append((u, v, w))


@njit()
def _doubtful(
    kinds: np.ndarray, is_doubtful: np.ndarray, values: np.ndarray, begin: int, beyond: float
) -> np.ndarray:
    """Return the points of a slab whose distance from the nearest centre is needed, by their number there.

    Between doubtful points that are far from all spheres, no edge is cut: they get the value `beyond`.
    """
    out, n = np.empty(1024, np.int64), 0
    nx, ny, nz = kinds.shape
    for i in range(begin, begin + len(values)):
        for j in range(ny):
            for k in range(nz):
                if kinds[i, j, k] == IN_SPHERE or not (kinds[i, j, k] == BETWEEN or is_doubtful[i, j, k]):
                    continue
                is_alone = kinds[i, j, k] == OUTSIDE_PROBE
                for x in range(max(i - 1, 0), min(i + 2, nx) if is_alone else 0):
                    for y in range(max(j - 1, 0), min(j + 2, ny)):
                        for z in range(max(k - 1, 0), min(k + 2, nz)):
                            is_alone &= is_doubtful[x, y, z] and kinds[x, y, z] == OUTSIDE_PROBE
                if is_alone:
                    values[i - begin, j, k] = beyond
                    continue
                if n == len(out):
                    longer = np.empty(2 * n, np.int64)
                    longer[:n] = out
                    out = longer
                out[n] = ((i - begin) * ny + j) * nz + k
                n += 1
    return out[:n].copy()


def _tetrahedra() -> np.ndarray:
    """Return the corners of a cube's six tetrahedra, (6, 4), equally oriented; bit a of a corner means a step along axis a."""
    tetrahedra = []
    for p, q, r in permutations(range(3)):
        corners = [0, 1 << p, 1 << p | 1 << q, 7]
        odd = (p > q) + (p > r) + (q > r) & 1
        tetrahedra.append([corners[0], corners[2], corners[1], corners[3]] if odd else corners)
    return np.array(tetrahedra)


def _crossings() -> tuple[np.ndarray, np.ndarray]:
    """Return the edges of a tetrahedron's triangles, (16, 2, 3, 2), and their number, by the bit mask of the corners inside."""
    edges, count = np.zeros((16, 2, 3, 2), np.int64), np.zeros(16, np.int64)
    even = [t for t in permutations(range(4)) if np.linalg.det(np.eye(4)[list(t)]) > 0]
    for mask in range(1, 15):
        inside = [c for c in range(4) if mask >> c & 1]
        first = inside if len(inside) < 3 else [c for c in range(4) if c not in inside]
        a, b, c, d = next(t for t in even if list(t[: len(first)]) == first)
        if len(inside) == 1:
            triangles = [[(a, b), (a, c), (a, d)]]
        elif len(inside) == 3:
            triangles = [[(a, b), (a, d), (a, c)]]
        else:
            triangles = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
        edges[mask, : len(triangles)], count[mask] = triangles, len(triangles)
    return edges, count


TETRAHEDRA = _tetrahedra()
CROSSED, N_CROSSED = _crossings()
N_BITS = np.array([bin(k).count("1") for k in range(256)], np.int64)


def marching_tetrahedra(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangulate the surface around values (X, Y, Z) above 0, none on a side: vertices (V, 3) in steps, triangles (F, 3)."""
    cut = _cut_edges(values)
    return _vertices(values, cut, 0), _triangles(values > 0, cut)


@njit()
def _cut_edges(values: np.ndarray) -> np.ndarray:
    """Set bit d - 1 of each point if the edge from it in direction d (bits as for corners) crosses the surface."""
    nx, ny, nz = values.shape
    cut = np.zeros((nx, ny, nz), np.uint8)
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                inside = values[i, j, k] > 0
                for d in range(1, 8):
                    x, y, z = i + (d & 1), j + (d >> 1 & 1), k + (d >> 2)
                    if x < nx and y < ny and z < nz and (values[x, y, z] > 0) != inside:
                        cut[i, j, k] |= 1 << (d - 1)
    return cut


@njit()
def _vertices(values: np.ndarray, cut: np.ndarray, begin: int) -> np.ndarray:
    """Return the vertex on every edge that is cut, where the interpolated value is 0; the first plane has the number `begin`."""
    nx, ny, nz = values.shape
    vertices, row = np.empty((_row_starts(cut)[1], 3)), 0
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if cut[i, j, k] == 0:
                    continue
                for d in range(1, 8):
                    if cut[i, j, k] >> (d - 1) & 1:
                        a, b = d & 1, d >> 1 & 1
                        c = d >> 2
                        value, neighbour = values[i, j, k], values[i + a, j + b, k + c]
                        # Kept from the ends, where several edges meet: vertices in one place would make triangles without area
                        t = min(max(value / (value - neighbour), MIN_SHARE_OF_EDGE), 1 - MIN_SHARE_OF_EDGE)
                        vertices[row, 0], vertices[row, 1], vertices[row, 2] = (
                            begin + i + t * a,
                            j + t * b,
                            k + t * c,
                        )
                        row += 1
    return vertices


@njit()
def _row_starts(cut: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the first vertex of each row of the grid, (X, Y) int64, and the number of all."""
    nx, ny, nz = cut.shape
    start, n = np.empty((nx, ny), np.int64), 0
    for i in range(nx):
        for j in range(ny):
            start[i, j] = n
            for k in range(nz):
                n += N_BITS[cut[i, j, k]]
    return start, n


@njit()
def _triangles(inside_at: np.ndarray, cut: np.ndarray) -> np.ndarray:
    """Return the vertices of all triangles; a first pass counts them, a second stores them.

    The first vertices of the corners of a cube are counted along the four rows that its row of cubes lies between.
    """
    nx, ny, nz = cut.shape
    start, _ = _row_starts(cut)
    triangles = np.empty((0, 3), np.int64)
    first = np.empty((2, 2, 2), np.int64)
    for store in range(2):
        n = 0
        for i in range(nx - 1):
            for j in range(ny - 1):
                for p in range(2):
                    for q in range(2):
                        first[p, q, 1] = start[i + p, j + q]
                for k in range(nz - 1):
                    inside = 0
                    for c in range(8):
                        if inside_at[i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)]:
                            inside |= 1 << c
                    for p in range(2):
                        for q in range(2):
                            first[p, q, 0] = first[p, q, 1]
                            first[p, q, 1] += N_BITS[cut[i + p, j + q, k]]
                    if inside == 0 or inside == 255:
                        continue
                    for t in range(6):
                        mask = 0
                        for c in range(4):
                            mask |= (inside >> TETRAHEDRA[t, c] & 1) << c
                        if store:
                            for f in range(N_CROSSED[mask]):
                                for e in range(3):
                                    a, b = (
                                        TETRAHEDRA[t, CROSSED[mask, f, e, 0]],
                                        TETRAHEDRA[t, CROSSED[mask, f, e, 1]],
                                    )
                                    low, bit = a & b, (a ^ b) - 1  # one corner's bits include the other's
                                    p, q, r = low & 1, low >> 1 & 1, low >> 2
                                    before = cut[i + p, j + q, k + r] & ((1 << bit) - 1)
                                    triangles[n + f, e] = first[p, q, r] + N_BITS[before]
                        n += N_CROSSED[mask]
        if not store:
            triangles = np.empty((n, 3), np.int64)
    return triangles
