"""A closed mesh of the surface that few dots with normals describe."""

import logging

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from sparsurf import InputError
from sparsurf.recovery.recovering import REACH, STEPS, recover
from sparsurf.surfaces.mesh import GRID_STEP, build_mesh, grid_around, marching_tetrahedra
from sparsurf.surfaces.spacing import DENSITY

log = logging.getLogger("sparsurf")

AROUND = 6  # dense dots whose tangent planes a place is seen from
# Steps of the grid, how far from the surface its distance is measured: an edge of a tetrahedron has sqrt(3). More only where
# the dots leave holes, which a wider layer closes.
BANDS = (2.0, 4.0, 8.0)
DISSENT = 0.02  # share of the walls of rooms that may be on the other side


def recovered_mesh(points, normals, step=GRID_STEP, density=DENSITY, reach=REACH, steps=STEPS, threads=1):
    """Triangles of the recovered surface: those where the signed distance to its dense dots changes its sign.

    Parameters
    ----------
    points, normals : (n, 3) float64, Å and outward unit vectors
    step : Å, of the grid
    density, reach, steps, threads : as for `recover`

    Returns
    -------
    Mesh

    Raises
    ------
    InputError : a grid of too many points, or of too few
    """
    dense, outward = recover(points, normals, density, reach, steps, threads)
    if np.sum(outward * (dense - dense.mean(axis=0))) < 0:  # three times the volume, of a closed surface
        log.warning("the normals point inward: turn them around, or the mesh is that of the space outside")
    low, shape = grid_around(dense, BANDS[-1] * step, step)
    tree = cKDTree(dense)
    gap = _gap(dense, low, shape, step)
    for band in BANDS:
        near = gap <= band + 0.5
        values = np.zeros(shape)
        values[near] = -_height(tree, outward, low + step * np.argwhere(near), threads)[0]
        values, agreed = _filled(values, near)
        if agreed:
            break
    else:
        log.warning("the dots leave holes wider than %.1f Å: the mesh has walls there", 2 * band * step)
    vertices, triangles = marching_tetrahedra(values)
    if len(triangles) == 0:
        raise InputError("the mesh is too coarse to hold the surface; ask for a higher density.")
    vertices = low + step * vertices
    for _ in range(2):
        height, across = _height(tree, outward, vertices, threads)
        vertices = vertices - height[:, None] * across
    return build_mesh(vertices, across, triangles)


def _gap(dense, low, shape, step):
    """Steps from each point of the grid to the nearest that has a dense dot beside it, (X, Y, Z)."""
    empty = np.ones(shape, bool)
    empty[tuple(np.round((dense - low) / step).astype(int).T)] = False
    return ndimage.distance_transform_edt(empty)


def _height(tree, outward, places, threads):
    """Height of places (n, 3) above the dense dots around them, (n,), Å, and the normal there, (n, 3)."""
    gap, dots = tree.query(places, k=min(AROUND, tree.n), workers=threads)
    gap, dots = gap.reshape(len(places), -1), dots.reshape(len(places), -1)
    weight = np.exp(-((gap / (gap[:, :1] + 1e-9)) ** 2))
    same = np.einsum("ikc,ic->ik", outward[dots], outward[dots[:, 0]]) > 0
    weight *= same
    weight /= weight.sum(axis=1, keepdims=True)
    height = np.einsum("ik,ikc,ikc->i", weight, outward[dots], places[:, None] - tree.data[dots])
    across = np.einsum("ik,ikc->ic", weight, outward[dots])
    return height, across / np.linalg.norm(across, axis=1, keepdims=True)


def _filled(values, near):
    """Values where there were none, and whether the walls agree on them.

    Each room between the layers near the surface lies on the side that most of its walls say. Where the inside and the
    outside are one room, through a hole that no layer closes, they say both.
    """
    rooms, n = ndimage.label(~near)
    inside, outside = np.zeros(n + 1), np.zeros(n + 1)
    for axis in range(3):
        a, b = np.moveaxis(rooms, axis, 0), np.moveaxis(values, axis, 0)
        for there, here in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
            wall = (a[there] > 0) & (a[here] == 0)
            inside += np.bincount(a[there][wall], b[here][wall] > 0, n + 1)
            outside += np.bincount(a[there][wall], b[here][wall] <= 0, n + 1)
    side = np.where(inside > outside, 1.0, -1.0)
    side[rooms[0, 0, 0]] = -1.0  # the corner of the grid is outside
    wrong = np.where(side > 0, outside, inside).sum()
    return np.where(near, values, side[rooms]), wrong <= DISSENT * (inside.sum() + outside.sum())
