"""Closed meshes between dense dots, whose atoms are not known: a signed distance on a grid, and its triangles.

The triangles are those of marching tetrahedra. Every cube of the grid is divided into the six tetrahedra around its
diagonal (Freudenthal, Ann. Math. 43:580, 1942); those of neighbouring cubes match face to face. The surface crosses a
tetrahedron in one triangle or two, whose corners lie on its edges and are shared with all tetrahedra around them. So
every edge of the mesh belongs to two triangles, whatever the values are. How many handles it has depends on the grid.
"""

from __future__ import annotations

import logging
from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import InputError
from sparsurf.kernels import njit
from sparsurf.surfaces.decimation import GRID_STEP
from sparsurf.surfaces.mesh import Mesh, build_mesh
from sparsurf.threads import bytes_of_memory, parallel_map

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

log = logging.getLogger("sparsurf")

# No value on a side of the grid may lie inside, or the mesh would be open there
MARGIN_STEPS = 2  # of the grid around the surface
MAX_GRID_POINTS = 400_000_000  # more would take over 4 GB
MIN_SHARE_OF_EDGE = 0.02  # between a vertex and the end of its edge
BYTES_PER_GRID_POINT = 20  # values, distances and cut edges
# Of the nearest dense dots; the height of a point is their weighted mean. One plane would jump half way between two dots; 3 to
# 20 of them change the mean error of a mesh by less than .0002 Å.
TANGENT_PLANES = 6
# Width, in steps of the grid, of the layer around the surface in which distances are computed. An edge of a tetrahedron is
# sqrt(3) long. Wider layers are used only if the dots leave holes, which they close.
BANDS = (2.0, 4.0, 8.0)
# Share of the regions' boundary faces that may indicate the other side. It is below .0001 on whole surfaces, and
# .1 to .4 where a hole connects inside and outside, as one of 2 Å does before a wider layer closes it.
MAX_DISSENT = 0.02


def mesh_of_dense(dense: np.ndarray, outward: np.ndarray, step: float = GRID_STEP, threads: int = 1) -> Mesh:
    """Triangulate a surface by a grid of `step` Å, where the signed distance to its dense dots (N, 3) changes sign."""
    if np.sum(outward * (dense - dense.mean(axis=0))) < 0:  # proportional to the volume of a closed surface
        log.warning("the normals point inward, so that the mesh encloses the outside: reverse them")
    low, shape = grid_around(dense, BANDS[-1] * step, step)
    from scipy.spatial import cKDTree  # here, as below: scipy takes a quarter of a second to load

    tree = cKDTree(dense)
    distance = _steps_to_dots(dense, low, tuple(shape), step)
    for band in BANDS:
        near = distance <= band + 0.5
        values = np.zeros(shape)
        values[near] = -_height(tree, outward, low + step * np.argwhere(near), threads)[0]
        values, consistent = _assign_sides(values, near)
        if consistent:
            break
    else:
        log.warning(
            "the dots leave holes wider than %.1f Å, and the mesh has artificial walls there", 2 * band * step
        )
    vertices, triangles = marching_tetrahedra(values)
    if len(triangles) == 0:
        raise InputError("the mesh is too coarse for the surface; give a smaller step.")
    vertices = low + step * vertices
    # Twice, as the planes that a vertex is measured by change once it has moved
    for _ in range(2):
        height, vertex_normals = _height(tree, outward, vertices, threads)
        vertices = vertices - height[:, None] * vertex_normals
    return build_mesh(vertices, vertex_normals, triangles)


def _steps_to_dots(dense: np.ndarray, low: np.ndarray, shape: tuple[int, ...], step: float) -> np.ndarray:
    """Return the distance of each grid point to the nearest grid point at a dense dot, in steps, (X, Y, Z)."""
    from scipy import ndimage

    empty = np.ones(shape, bool)
    empty[tuple(np.round((dense - low) / step).astype(int).T)] = False
    return ndimage.distance_transform_edt(empty)


def _height(
    tree: cKDTree, outward: np.ndarray, points: np.ndarray, threads: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the height of points (n, 3) above the dense dots around them, (n,), Å, and the normal there, (n, 3)."""
    height, normals = np.empty(len(points)), np.empty((len(points), 3))

    def fill_in(begin: int, end: int) -> None:
        """Fill in one slice, whose planes fit into the cache."""
        of_slice = points[begin:end]
        distance, dots = tree.query(of_slice, k=min(TANGENT_PLANES, tree.n))
        distance, dots = (np.reshape(array, (len(of_slice), -1)) for array in (distance, dots))
        weight = np.exp(-((distance / (distance[:, :1] + 1e-9)) ** 2))
        planes = outward[dots]
        # The dots across a thin wall, whose planes face the other way, do not count
        weight *= np.einsum("ikc,ic->ik", planes, planes[:, 0]) > 0
        weight /= weight.sum(axis=1, keepdims=True)
        height[begin:end] = np.einsum("ik,ikc,ikc->i", weight, planes, of_slice[:, None] - tree.data[dots])
        normal = np.einsum("ik,ikc->ic", weight, planes)
        normals[begin:end] = normal / np.linalg.norm(normal, axis=1, keepdims=True)

    parallel_map(fill_in, len(points), threads)
    return height, normals


def _assign_sides(values: np.ndarray, near: np.ndarray) -> tuple[np.ndarray, bool]:
    """Fill in the values away from the surface, and return whether the boundary faces agree on them.

    Each connected region is assigned to the side that most of its boundary faces indicate. Faces disagree if inside and
    outside are connected through a hole that no layer closes.
    """
    from scipy import ndimage

    regions, n = ndimage.label(~near)
    inside, outside = np.zeros(n + 1), np.zeros(n + 1)
    for axis in range(3):
        a, b = np.moveaxis(regions, axis, 0), np.moveaxis(values, axis, 0)
        for upper, lower in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
            face = (a[upper] > 0) & (a[lower] == 0)
            inside += np.bincount(a[upper][face], b[lower][face] > 0, n + 1)
            outside += np.bincount(a[upper][face], b[lower][face] <= 0, n + 1)
    side = np.where(inside > outside, 1.0, -1.0)
    side[regions[0, 0, 0]] = -1.0  # the corner of the grid is outside
    wrong = np.where(side > 0, outside, inside).sum()
    consistent = bool(wrong <= MAX_DISSENT * (inside.sum() + outside.sum()))
    return np.where(near, values, side[regions]), consistent


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
