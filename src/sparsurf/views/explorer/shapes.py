"""The triangles of a surface and the atoms below it, as small as a page can hold them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sparsurf.molecules.molecule import Molecule
from sparsurf.surfaces.mesh import Mesh
from sparsurf.surfaces.thinning import coarsened
from sparsurf.views.viewer.packing import flat_normals

SPARSER = 0.7  # of the density, while a page is too large
SHAPE_STEP = 0.02  # Å, of positions on a page
# Atoms through which the tube of a chain runs, and the distance, Å, below which two of them are those of bonded residues
TRACE_ATOMS = {"CA": 5, "C4'": 9, "C4*": 9}
MAX_STICK_ATOMS = (
    60_000  # heavy atoms that a page holds; of larger molecules it holds those of the trace alone
)


class Shape(NamedTuple):
    """The surface and the atoms of one frame, in Å."""

    mesh: Mesh
    atoms: np.ndarray  # (A, 3), of `atoms_to_draw`

    def in_order(self) -> Shape:
        """Return the shape with its corners in the order of their first use, so that most steps between them are small."""
        used, first, place = np.unique(self.mesh.triangles, return_index=True, return_inverse=True)
        order = np.argsort(first)
        renumbered = np.empty(len(used), int)
        renumbered[order] = np.arange(len(used))
        vertices = self.mesh.vertices.take(used[order])
        return Shape(Mesh(vertices, renumbered[place].reshape(-1, 3)), self.atoms)


def sparser(shape: Shape) -> Shape:
    """Return a shape whose mesh has fewer corners."""
    vertices = shape.mesh.vertices
    return Shape(coarsened(shape.mesh, SPARSER * len(vertices) / float(vertices.area.sum())), shape.atoms)


def atoms_to_draw(molecule: Molecule) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the atoms that a page holds, and of each residue the place of its trace atom, or -1, and how far it reaches, Å."""
    is_trace = np.isin(molecule.name, [*TRACE_ATOMS]) & np.isin(molecule.kind, ("protein", "nucleic"))
    atoms = np.flatnonzero(molecule.heavy)
    if len(atoms) > MAX_STICK_ATOMS:
        atoms = np.flatnonzero(is_trace)
    trace = np.full(molecule.n_residues, -1)
    place = np.flatnonzero(is_trace[atoms])[::-1]  # the first of several locations is written last
    trace[molecule.residue_index[atoms[place]]] = place
    names = molecule.name[atoms[trace]]
    reach = np.array(
        [0 if place < 0 else TRACE_ATOMS[name] for place, name in zip(trace, names, strict=True)]
    )
    return atoms, trace, reach


def coded_triangles(triangles: np.ndarray) -> np.ndarray:
    """Encode triangles, numbered by their first use: how far each corner lies before the next new one, 0 if it is new."""
    corners = triangles.ravel()
    new = np.zeros(len(corners), int)
    new[np.unique(corners, return_index=True)[1]] = 1
    return np.cumsum(new) - new - corners


def shape_columns(shapes: Sequence[Shape], residue_of_atom: np.ndarray) -> dict[str, np.ndarray]:
    """Return the columns of the shapes of all frames; atoms of a frame as steps from the frame before."""
    columns: dict[str, np.ndarray] = {}
    before = np.zeros_like(shapes[0].atoms, int)
    for frame, shape in enumerate(shapes):
        vertices = shape.mesh.vertices
        points = np.rint(vertices.points / SHAPE_STEP).astype(int)
        atoms = np.rint(shape.atoms / SHAPE_STEP).astype(int)
        columns |= {f"{axis}{frame}": points[:, k] for k, axis in enumerate("xyz")}
        columns |= {f"atom {axis}{frame}": (atoms - before)[:, k] for k, axis in enumerate("xyz")}
        columns |= dict(zip((f"u{frame}", f"v{frame}"), flat_normals(vertices.normals).T, strict=True))
        columns |= {f"triangles{frame}": coded_triangles(shape.mesh.triangles)}
        columns |= {f"residue{frame}": residue_of_atom[vertices.atom]}
        before = atoms
    return columns
