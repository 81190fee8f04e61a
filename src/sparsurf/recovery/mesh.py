"""A closed mesh of the surface reconstructed from few dots with normals."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import InputError
from sparsurf.recovery.interpolated_surface import NEWTON_STEPS, REACH, interpolate_surface
from sparsurf.surfaces.mesh import GRID_STEP, Mesh, build_mesh, grid_around, marching_tetrahedra
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.threads import parallel_map

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

log = logging.getLogger("sparsurf")

# Of the nearest dense dots; the height of a point is their weighted mean. One plane would jump half way between two dots; 3 to
# 20 of them change the mean error of a mesh by less than .0002 Å.
TANGENT_PLANES = 6
# Width, in steps of the grid, of the layer around the surface in which distances are computed. An edge of a tetrahedron is
# sqrt(3) long. Wider layers are used only if the dots leave holes, which they close.
BANDS = (2.0, 4.0, 8.0)
# Share of the regions' boundary faces that may indicate the other side. It is below .0001 on whole surfaces, and
# .1 to .4 where a hole connects inside and outside, as one of 2 Å does before a wider layer closes it.
MAX_DISSENT = 0.02


def recovered_mesh(
    points: np.ndarray,
    normals: np.ndarray,
    step: float = GRID_STEP,
    density: float = DENSITY,
    reach: float = REACH,
    steps: int = NEWTON_STEPS,
    threads: int = 1,
) -> Mesh:
    """Triangulate the surface that `recover` interpolates between dots, see `mesh_of_dense`."""
    return mesh_of_dense(*interpolate_surface(points, normals, density, reach, steps, threads), step, threads)


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
