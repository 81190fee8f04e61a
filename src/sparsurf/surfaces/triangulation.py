"""Triangles between the dots of a surface, from their Delaunay tetrahedra."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sparsurf.surfaces.surface import Surface

if TYPE_CHECKING:
    from scipy.spatial import Delaunay

MAX_DOTS_TO_TRIANGULATE = 500_000  # more would take minutes
# Å, random movement of the dots before the triangulation: many lie on one sphere, which would double the time.
JITTER = 1e-4
MIN_RELATIVE_HEIGHT = 1e-3  # flatter tetrahedra are doubtful
# Sum over the four dots of the cosine between normal and ray to the centre; below it, the side of a tetrahedron is doubtful.
MIN_AGREEMENT = 2.0
# Å^2 of boundary that one normal of a doubtful tetrahedron outweighs; with 0.03 more dots stay without a triangle.
AREA_PER_NORMAL = 0.1
# Areas are counted in integers for the minimum cut: at most this many per Å^2, and this many in total.
MAX_UNITS_PER_AREA, MAX_UNITS = 1e5, 1e9


def triangulate(surface: Surface) -> np.ndarray:
    """Triangulate the dots of a surface: (M, 3) indices, counterclockwise seen from outside; none for fewer than five dots.

    The triangles are the boundary between the Delaunay tetrahedra that lie inside the molecule, as the normals show, and the
    others. Crowded dots may be in no triangle, such as those that DMS places inside other probes.
    """
    from scipy.spatial import Delaunay, QhullError

    points = surface.points + JITTER * np.random.default_rng(0).uniform(-1, 1, surface.points.shape)
    try:
        tetrahedra = Delaunay(points)
    except (QhullError, ValueError):  # fewer than five dots, or all in one plane
        return np.empty((0, 3), int)
    inside = _inside(surface, tetrahedra)
    simplices, neighbours = tetrahedra.simplices, tetrahedra.neighbors
    faces = []
    for corner in range(4):
        outward = inside & ~np.append(inside, False)[neighbours[:, corner]]  # no neighbour, -1, means outside
        face, apex = np.delete(simplices[outward], corner, axis=1), simplices[outward, corner]
        a, b, c = (points[face[:, k]] for k in range(3))
        clockwise = np.einsum("ij,ij->i", np.cross(b - a, c - a), points[apex] - a) > 0
        faces.append(np.where(clockwise[:, None], face[:, ::-1], face))
    return np.concatenate(faces)


def _inside(surface: Surface, tetrahedra: Delaunay) -> np.ndarray:
    """Return which tetrahedra lie inside the molecule, (T,) bool.

    The centre of the sphere through the dots of a tetrahedron inside lies behind them, against their normals. Where it is not
    clear, the boundary is the smallest, weighed against what their normals indicate.
    """
    corners = surface.points[tetrahedra.simplices]
    edges = corners[:, 1:] - corners[:, :1]
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    solid = np.abs(np.linalg.det(edges)) > MIN_RELATIVE_HEIGHT * longest**2
    centre = np.zeros((len(corners), 3))  # relative to the first corner; all four are equally far from it
    centre[solid] = np.linalg.solve(edges[solid], (edges[solid] ** 2).sum(axis=2)[..., None] / 2)[..., 0]
    rays = centre[:, None] - (corners - corners[:, :1])
    agreement = np.einsum("ijk,ijk->i", rays, surface.normals[tetrahedra.simplices])
    agreement[solid] /= np.linalg.norm(centre[solid], axis=1)
    clear = solid & (np.abs(agreement) >= MIN_AGREEMENT)
    inside = np.append(clear & (agreement < 0), False)  # the last, index -1, is outside of all
    doubtful = np.flatnonzero(~clear)
    if len(doubtful):
        sides = [np.delete(corners[doubtful], k, axis=1) for k in range(4)]
        area = np.stack([_areas(side) for side in sides], axis=1)
        votes = AREA_PER_NORMAL * np.where(solid, agreement, 0)[doubtful]
        inside[doubtful] = _smallest_boundary(tetrahedra.neighbors[doubtful], area, votes, doubtful, inside)
    return inside[:-1]


def _smallest_boundary(
    opposite: np.ndarray, area: np.ndarray, votes: np.ndarray, doubtful: np.ndarray, inside: np.ndarray
) -> np.ndarray:
    """Choose which of D doubtful tetrahedra lie inside, (D,) bool, so that the boundary is smallest, by a minimum cut.

    `opposite` and `area` (D, 4) are the tetrahedron behind each side and the side's area, Å^2. By `votes` (D,), Å^2, the
    boundary may grow if the tetrahedron is inside (negative) or outside (positive). `inside` (T + 1,) is of the others.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    n = len(doubtful)
    number = np.full(len(inside), -1)
    number[doubtful] = np.arange(n)
    units = min(MAX_UNITS_PER_AREA, MAX_UNITS / area.sum())
    width, votes = np.round(area * units).astype(np.int64) + 1, np.round(votes * units).astype(np.int64)
    other, row = number[opposite], np.arange(n).repeat(4).reshape(n, 4)
    between = other >= 0  # both tetrahedra are doubtful
    from_inside = np.where(~between & inside[opposite], width, 0).sum(axis=1) + np.maximum(-votes, 0)
    to_outside = np.where(~between & ~inside[opposite], width, 0).sum(axis=1) + np.maximum(votes, 0)
    rows = np.concatenate([row[between], np.full(n, n), np.arange(n)])
    columns = np.concatenate([other[between], np.arange(n), np.full(n, n + 1)])
    widths = np.concatenate([width[between], from_inside, to_outside]).astype(np.int32)
    graph = coo_array((widths, (rows, columns)), shape=(n + 2, n + 2)).tocsr()
    residual = graph - maximum_flow(graph, n, n + 1).flow
    residual.data[residual.data < 0] = 0
    residual.eliminate_zeros()
    reached = np.zeros(n + 2, bool)
    reached[breadth_first_order(residual, n, return_predecessors=False)] = True
    return reached[:n]


def _areas(corners: np.ndarray) -> np.ndarray:
    """Return the areas of triangles (T, 3, 3)."""
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
