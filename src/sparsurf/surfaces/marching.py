"""Triangles of the surface on which values on a grid change their sign: marching tetrahedra.

Every cube of the grid is cut into the six tetrahedra around its diagonal (Freudenthal, Ann. Math. 43:580, 1942), those of
neighbouring cubes fitting face to face. A tetrahedron is crossed in one triangle or two, whose corners lie on its edges
and belong to all tetrahedra around them: so every edge of the mesh belongs to two triangles, whatever the values are.
"""

from itertools import permutations

import numpy as np
from numba import njit

MOST_POINTS = 400_000_000  # of a grid; beyond, it would take more than 4 GB
NEAREST_CORNER = 0.02  # share of an edge that stays between a vertex and the end of the edge


def _tetrahedra():
    """Corners of the six tetrahedra of a cube, (6, 4), bit a for a step along axis a, the odd ones turned round."""
    found = []
    for p, q, r in permutations(range(3)):
        corners = [0, 1 << p, 1 << p | 1 << q, 7]
        odd = (p > q) + (p > r) + (q > r) & 1
        found.append([corners[0], corners[2], corners[1], corners[3]] if odd else corners)
    return np.array(found)


def _crossings():
    """Edges that bear the corners of the triangles of a tetrahedron, (16, 2, 3, 2), and how many triangles, (16,).

    By bit mask of its corners inside; the triangles run counterclockwise seen from outside.
    """
    edges, count = np.zeros((16, 2, 3, 2), np.int64), np.zeros(16, np.int64)
    even = [t for t in permutations(range(4)) if np.linalg.det(np.eye(4)[list(t)]) > 0]
    for mask in range(1, 15):
        inside = [c for c in range(4) if mask >> c & 1]
        first = inside if len(inside) < 3 else [c for c in range(4) if c not in inside]
        a, b, c, d = next(t for t in even if list(t[: len(first)]) == first)
        if len(inside) == 1:
            found = [[(a, b), (a, c), (a, d)]]
        elif len(inside) == 3:
            found = [[(a, b), (a, d), (a, c)]]
        else:
            found = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
        edges[mask, : len(found)], count[mask] = found, len(found)
    return edges, count


TETRAHEDRA = _tetrahedra()
CROSSED, N_CROSSED = _crossings()
BITS = np.array([bin(k).count("1") for k in range(256)], np.int64)


def march(values):
    """The surface between what is inside, above 0, and the rest.

    Parameters
    ----------
    values : (X, Y, Z) float, at most 0 on all six sides

    Returns
    -------
    vertices (V, 3) float64, in steps of the grid, and triangles (F, 3) int64, counterclockwise seen from outside
    """
    cut = _cut_edges(values)
    first = np.zeros(values.size + 1, np.int64)
    np.cumsum(BITS[cut.ravel()], out=first[1:])
    vertices = _vertices(values, cut, first)
    return vertices, _triangles(values, cut, first)


@njit(cache=True, nogil=True)
def _cut_edges(values):
    """Bit d - 1 of each point: whether the edge from it in direction d (bits as of corners) crosses the surface."""
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


@njit(cache=True, nogil=True)
def _vertices(values, cut, first):
    """Place of the vertex on every edge that is cut, where the values between its ends pass 0."""
    nx, ny, nz = values.shape
    vertices = np.empty((first[-1], 3))
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if cut[i, j, k] == 0:
                    continue
                at = first[(i * ny + j) * nz + k]
                for d in range(1, 8):
                    if cut[i, j, k] >> (d - 1) & 1:
                        a, b = d & 1, d >> 1 & 1
                        c = d >> 2
                        here, there = values[i, j, k], values[i + a, j + b, k + c]
                        t = min(max(here / (here - there), NEAREST_CORNER), 1 - NEAREST_CORNER)
                        vertices[at, 0], vertices[at, 1], vertices[at, 2] = i + t * a, j + t * b, k + t * c
                        at += 1
    return vertices


@njit(cache=True, nogil=True)
def _triangles(values, cut, first):
    """Vertices of all triangles; counted in a first pass, stored in a second."""
    nx, ny, nz = values.shape
    triangles = np.empty((0, 3), np.int64)
    for store in range(2):
        n = 0
        for i in range(nx - 1):
            for j in range(ny - 1):
                for k in range(nz - 1):
                    inside = 0
                    for c in range(8):
                        if values[i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)] > 0:
                            inside |= 1 << c
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
                                    low, bit = a & b, (a ^ b) - 1  # one corner's bits hold the other's
                                    x, y, z = i + (low & 1), j + (low >> 1 & 1), k + (low >> 2)
                                    before = cut[x, y, z] & ((1 << bit) - 1)
                                    triangles[n + f, e] = first[(x * ny + y) * nz + z] + BITS[before]
                        n += N_CROSSED[mask]
        if not store:
            triangles = np.empty((n, 3), np.int64)
    return triangles
