"""Coarsen meshes for pictures quickly: short edges are collapsed in one pass for each length, in the order of the mesh.

The mesh stays closed and its parts and handles the same, as in `decimation`, which takes the shortest edge first and chooses its
triangles with more care, in ten times as long.
"""

from __future__ import annotations

import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.chosen_points import on_steps
from sparsurf.surfaces.half_edges import (
    around,
    may_collapse,
    next_edge,
    remaining,
    remove_start,
    squared_length,
    triangle_normal,
    twins,
)
from sparsurf.surfaces.mesh import Mesh, MeshSize, build_mesh
from sparsurf.surfaces.surface import SurfaceOrigin
from sparsurf.surfaces.triangulation import molecular_mesh
from sparsurf.surfaces.vectors import dot, point

DENSITY_OF_PICTURES = 1.2  # vertices per Å^2
PICTURED = MeshSize(step=1.39)  # the coarsest for which no edge is collapsed with care
EDGES_PER_AREA = 0.43  # density of a coarsened mesh, in vertices on the squared length of the edges that go
PASSES = (0.5, 0.7, 0.85, 1.0)  # of the length of an edge: short edges go first
MIN_FACING = 0.3  # cosine of a new triangle with the normals of its corners


def mesh_of_picture(origin: SurfaceOrigin) -> Mesh:
    """Return the mesh of the atoms of an origin as coarse as a picture shows it."""
    rules = origin.rules
    mesh = molecular_mesh(origin.xyz.round(3), origin.radii, rules.probe_radius, PICTURED, rules.cavities)
    return coarsened(mesh, DENSITY_OF_PICTURES)


def coarsened(mesh: Mesh, density: float) -> Mesh:
    """Collapse the short edges of a closed mesh until about `density` vertices per Å^2 are left, where no triangle folds."""
    length = math.sqrt(EDGES_PER_AREA / density)
    points, normals = on_steps(mesh.vertices.points), on_steps(mesh.vertices.normals)
    origin = np.array(mesh.triangles, np.int32).ravel()
    dead = _collapse_short(points, normals, origin, twins(origin, len(points)), length * np.array(PASSES))
    kept, triangles = remaining(origin, dead)
    vertices = mesh.vertices.take(kept)
    return build_mesh(vertices.points, vertices.normals, triangles, vertices.kind, vertices.atom)


@njit()
def _collapse_short(
    points: np.ndarray, normals: np.ndarray, origin: np.ndarray, twin: np.ndarray, lengths: np.ndarray
) -> np.ndarray:
    """Collapse edges up to each of the lengths, and return which triangles are gone."""
    dead = np.zeros(len(origin) // 3, np.bool_)
    seen, stamp = np.zeros(len(points), np.int64), 0
    for length in lengths:
        for h in range(len(origin)):
            if dead[h // 3] or squared_length(points, origin[h], origin[twin[h]]) >= length * length:
                continue
            stamp += 1
            if may_collapse(h, origin, twin, seen, stamp) and not _folds(h, points, normals, origin, twin):
                remove_start(h, origin, twin, dead)
    return dead


@njit()
def _folds(h: int, points: np.ndarray, normals: np.ndarray, origin: np.ndarray, twin: np.ndarray) -> bool:
    """Return whether a triangle would turn away from the normals of its corners if the start of an edge went into its end."""
    v = origin[twin[h]]
    e = around(h, twin)
    while e != h:
        a, b = origin[next_edge(e)], origin[next_edge(next_edge(e))]
        if v not in (a, b):
            normal, _ = triangle_normal(points, v, a, b)
            for w in (v, a, b):
                if dot(normal, point(normals, w)) < MIN_FACING:
                    return True
        e = around(e, twin)
    return False
