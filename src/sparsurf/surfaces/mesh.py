"""Closed surfaces of triangles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sparsurf.display import Shown
from sparsurf.kernels import njit
from sparsurf.surfaces.surface import Surface
from sparsurf.surfaces.vectors import cross, dot, point, subtract

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import DTypeLike


class MeshSize(NamedTuple):
    """How many vertices a mesh has: one of the three, or a step of 0.5 Å."""

    n_vertices: int | None = None
    density: float | None = None  # vertices per Å^2
    step: float | None = (
        None  # Å, of the grid of a mesh between dots; a mesh of atoms has as many vertices as such a grid
    )


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
