"""A closed mesh of the surface that few dots with normals describe."""

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from sparsurf.recovery.recovering import REACH, STEPS, recover
from sparsurf.surfaces.marching import march
from sparsurf.surfaces.mesh import STEP, grid_around, mesh_of
from sparsurf.surfaces.spacing import DENSITY

AROUND = 6  # dense dots whose tangent planes a place is seen from
BAND = 2.0  # steps of the grid, how far from the surface its distance is measured; an edge of a tetrahedron has sqrt(3)


def recovered_mesh(points, normals, step=STEP, density=DENSITY, reach=REACH, steps=STEPS, threads=1):
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
    InputError : a grid of too many points
    """
    dense, outward = recover(points, normals, density, reach, steps, threads)
    low, shape = grid_around(dense, BAND * step, step)
    tree = cKDTree(dense)
    near = _near(dense, low, shape, step)
    values = np.zeros(shape)
    places = low + step * np.argwhere(near)
    values[near] = -_height(tree, outward, places, threads)[0]
    values = _filled(values, near)
    vertices, triangles = march(values)
    vertices = low + step * vertices
    for _ in range(2):
        height, across = _height(tree, outward, vertices, threads)
        vertices = vertices - height[:, None] * across
    return mesh_of(vertices, across, triangles)


def _near(dense, low, shape, step):
    """(X, Y, Z) bool: points of the grid within `BAND` steps of a dense dot, or little more."""
    near = np.zeros(shape, bool)
    near[tuple(np.round((dense - low) / step).astype(int).T)] = True
    ball = np.linalg.norm(np.indices((7, 7, 7)) - 3, axis=0) <= BAND + 0.5
    return ndimage.binary_dilation(near, ball)


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
    """Values where there were none: each room between the layers near the surface lies on the side that most of its walls say."""
    rooms, n = ndimage.label(~near)
    votes = np.zeros(n + 1)
    for axis in range(3):
        a, b = np.moveaxis(rooms, axis, 0), np.moveaxis(values, axis, 0)
        for there, here in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
            wall = (a[there] > 0) & (a[here] == 0)
            votes += np.bincount(a[there][wall], np.sign(b[here][wall]), n + 1)
    votes[rooms[0, 0, 0]] = -1  # the corner of the grid is outside
    return np.where(near, values, np.sign(votes)[rooms])
