"""A stand-in for PyMesh, which PyPI does not serve, for clients of MSMS: it holds a mesh and saves it, and repairs nothing."""

from collections.abc import Callable

import numpy as np


class Mesh:
    """A mesh with the attributes that clients read."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        """Keep vertices (V, 3) and faces (F, 3)."""
        self.vertices, self.faces = np.asarray(vertices, float), np.asarray(faces, int)
        self.num_vertices, self.num_faces = len(self.vertices), len(self.faces)
        self.bbox = self.vertices.min(axis=0), self.vertices.max(axis=0)
        self.attributes: dict[str, np.ndarray] = {}

    def enable_connectivity(self) -> None:
        """Find the neighbours of each vertex."""
        self.neighbours: list[set[int]] = [set() for _ in self.vertices]
        for a, b in np.concatenate(
            [self.faces[:, [0, 1]], self.faces[:, [1, 2]], self.faces[:, [2, 0]]]
        ).tolist():
            self.neighbours[a].add(b)
            self.neighbours[b].add(a)

    def get_vertex_adjacent_vertices(self, vertex: int) -> list[int]:
        """Return the neighbours of a vertex."""
        return sorted(self.neighbours[vertex])

    def add_attribute(self, name: str) -> None:
        """Add an attribute of vertices."""
        self.attributes[name] = np.zeros(self.num_vertices)

    def set_attribute(self, name: str, values: np.ndarray) -> None:
        """Set an attribute of vertices."""
        self.attributes[name] = np.asarray(values, float)

    def get_attribute_names(self) -> list[str]:
        """Return the names of the attributes."""
        return list(self.attributes)


def form_mesh(vertices: np.ndarray, faces: np.ndarray) -> Mesh:
    """Return a mesh."""
    return Mesh(vertices, faces)


def save_mesh(path: str, mesh: Mesh, *names: str, **_: object) -> None:
    """Save vertices, faces and attributes as npz under the given name."""
    with open(path, "wb") as stream:
        np.savez(
            stream, verts=mesh.vertices, faces=mesh.faces, **{name: mesh.attributes[name] for name in names}
        )


def __getattr__(name: str) -> Callable[..., object]:
    """Return a repair that leaves a mesh as it is, with or without a report as PyMesh has it."""
    if name.startswith("__"):
        raise AttributeError(name)
    alone = name in ("resolve_self_intersection", "compute_outer_hull")
    return lambda mesh, *_, **__: mesh if alone else (mesh, {})
