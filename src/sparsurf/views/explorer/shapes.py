"""The triangles of a surface and the atoms below it, as small as a page can hold them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sparsurf.molecules.molecule import Molecule
from sparsurf.surfaces.mesh import Mesh

MERGED_CELL = 1.0  # Å, edge of the cells within which corners are merged, at first
COARSER = 1.2  # from one cell to the next, while a page is too large
SHAPE_STEP = 0.02  # Å, of positions on a page
# Atoms through which the tube of a chain runs, and the distance, Å, below which two of them are those of bonded residues
TRACE_ATOMS = {"CA": 5, "C4'": 9, "C4*": 9}
MAX_STICK_ATOMS = (
    60_000  # heavy atoms that a page holds; of larger molecules it holds those of the trace alone
)


class Shape(NamedTuple):
    """The surface and the atoms of one frame, in Å."""

    points: np.ndarray  # (V, 3), corners of the triangles
    triangles: np.ndarray  # (F, 3)
    residue: np.ndarray  # (V,) int, of each corner
    atoms: np.ndarray  # (A, 3), of `atoms_to_draw`


def shape_of(mesh: Mesh, molecule: Molecule, atoms: np.ndarray, frame: int) -> Shape:
    """Collect what is drawn of a mesh of a molecule's frame, and of its `atoms` (indices)."""
    residue = molecule.residue_index[mesh.vertices.atom]
    return Shape(mesh.vertices.points, mesh.triangles, residue, molecule.xyz[frame][atoms])


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


def reduced(shape: Shape, cell: float) -> tuple[Shape, np.ndarray]:
    """Merge the corners within each cell, Å, into the one nearest to their mean; also return the corners that are kept."""
    cells = np.floor((shape.points - shape.points.min(axis=0)) / cell).astype(np.int64)
    number = np.ravel_multi_index(tuple(cells.T), tuple(cells.max(axis=0) + 1))
    _, group, count = np.unique(number, return_inverse=True, return_counts=True)
    mean = np.stack([np.bincount(group, shape.points[:, k]) for k in range(3)], axis=1) / count[:, None]
    gap = ((shape.points - mean[group]) ** 2).sum(axis=1)
    order = np.lexsort((gap, group))
    kept = order[np.cumsum(count) - count]
    triangles = group[shape.triangles]
    first = triangles.argmin(axis=1)
    triangles = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    triangles = triangles[(triangles[:, 0] != triangles[:, 1]) & (triangles[:, 1] != triangles[:, 2])]
    triangles = np.unique(triangles[triangles[:, 0] != triangles[:, 2]], axis=0)
    used, place = np.unique(triangles.ravel(), return_index=True)
    used = used[
        np.argsort(place)
    ]  # in the order of their first use, so that most steps between them are small
    renumbered = np.empty(len(kept), int)
    renumbered[used] = np.arange(len(used))
    kept = kept[used]
    return Shape(shape.points[kept], renumbered[triangles], shape.residue[kept], shape.atoms), kept


def coded_triangles(triangles: np.ndarray) -> np.ndarray:
    """Encode triangles, numbered by their first use: how far each corner lies before the next new one, 0 if it is new."""
    corners = triangles.ravel()
    new = np.zeros(len(corners), int)
    new[np.unique(corners, return_index=True)[1]] = 1
    return np.cumsum(new) - new - corners


def shape_columns(shapes: Sequence[Shape]) -> dict[str, np.ndarray]:
    """Return the columns of the shapes of all frames; atoms of a frame as steps from the frame before."""
    columns: dict[str, np.ndarray] = {}
    before = np.zeros_like(shapes[0].atoms, int)
    for frame, shape in enumerate(shapes):
        points = np.rint(shape.points / SHAPE_STEP).astype(int)
        atoms = np.rint(shape.atoms / SHAPE_STEP).astype(int)
        columns |= {f"{axis}{frame}": points[:, k] for k, axis in enumerate("xyz")}
        columns |= {f"atom {axis}{frame}": (atoms - before)[:, k] for k, axis in enumerate("xyz")}
        columns |= {f"triangles{frame}": coded_triangles(shape.triangles), f"residue{frame}": shape.residue}
        before = atoms
    return columns
