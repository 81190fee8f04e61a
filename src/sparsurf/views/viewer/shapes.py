"""The triangles of a surface and the atoms below it, as small as a page can hold them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.residues import first_atoms, standard_name
from sparsurf.molecules.selection import POLYMERS
from sparsurf.surfaces.mesh import Mesh
from sparsurf.surfaces.thinning import coarsened
from sparsurf.views.viewer.packing import flat_normals

SPARSER = 0.7  # While a page is too large, its mesh gets this share of its density.
LEAST_DENSITY = 0.25  # A mesh keeps at least so many corners per Å^2.
SHAPE_STEP = 0.02  # Å, of positions on a page
B_STEP = 0.01  # Å^2
TRACE_ATOMS = ("CA", "P")
MAX_DRAWN_ATOMS = 60_000  # heavy atoms of a page; of larger molecules it holds those of the trace alone
TYPES = {
    "hydrophobic": ("ALA VAL LEU ILE MET PHE TRP PRO GLY CYS", (214, 190, 120)),
    "polar": ("SER THR ASN GLN TYR HIS", (120, 180, 130)),
    "positive": ("LYS ARG", (70, 110, 220)),
    "negative": ("ASP GLU", (215, 70, 60)),
    "nucleotide": ("A C G U DA DC DG DT DU", (150, 110, 180)),
    "other": ("", (230, 150, 60)),
}
TYPE_OF_NAME = {name: k for k, (names, _) in enumerate(TYPES.values()) for name in names.split()}
CHAIN_COLOURS = (
    (86, 180, 233), (230, 159, 0), (0, 158, 115), (204, 121, 167), (240, 228, 66), (0, 114, 178), (213, 94, 0), (150, 150, 150),
)  # fmt: skip


class Shape(NamedTuple):
    """The surface and the atoms of one frame, in Å; without a mesh where dots enclose nothing."""

    mesh: Mesh | None
    atoms: np.ndarray  # (A, 3), of `DrawnAtoms`

    @property
    def corners(self) -> np.ndarray:
        """Positions of the corners of the mesh, (V, 3)."""
        return np.empty((0, 3)) if self.mesh is None else self.mesh.vertices.points

    @property
    def atom_of_corners(self) -> np.ndarray:
        """Atom of each corner, (V,), -1 where it is not known."""
        return np.empty(0, int) if self.mesh is None else self.mesh.vertices.atom

    def in_order(self) -> Shape:
        """Return the shape with its corners in the order of their first use, so that most steps between them are small."""
        if self.mesh is None:
            return self
        used, first, place = np.unique(self.mesh.triangles, return_index=True, return_inverse=True)
        order = np.argsort(first)
        renumbered = np.empty(len(used), int)
        renumbered[order] = np.arange(len(used))
        vertices = self.mesh.vertices.take(used[order])
        return Shape(Mesh(vertices, renumbered[place].reshape(-1, 3)), self.atoms)

    def sparser(self) -> Shape:
        """Return a shape whose mesh has fewer corners; itself where these are so few that dots go instead."""
        if self.mesh is None:
            return self
        density = len(self.corners) / float(self.mesh.vertices.area.sum())
        return (
            self if density <= LEAST_DENSITY else Shape(coarsened(self.mesh, SPARSER * density), self.atoms)
        )


class DrawnAtoms:
    """The atoms that a page holds, of the molecule that has the surface and of others around it, which come after it.

    Attributes
    ----------
    molecule : all of them
    n_surfaced : number of residues that have the surface, which are the first
    chosen : (A,) indices of the atoms that the page holds
    is_trace : whether these are those of the trace alone, and of ligands
    """

    def __init__(self, molecule: Molecule, n_surfaced: int) -> None:
        self.molecule, self.n_surfaced = molecule, n_surfaced
        self.is_trace = int(molecule.heavy.sum()) > MAX_DRAWN_ATOMS
        shown = is_trace(molecule) | ~np.isin(molecule.kind, POLYMERS) if self.is_trace else molecule.heavy
        self.chosen = np.flatnonzero(shown)
        self.first_atoms = first_atoms(molecule.residue_index)  # of the residues

    def placed(self, xyz: np.ndarray) -> np.ndarray:
        """Return those of the positions of all atoms, (n, 3), that the page holds, (A, 3)."""
        return xyz[self.chosen]

    def header(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """Return what a page says of the atoms and residues: entries of its header, and columns."""
        molecule, first = self.molecule, self.first_atoms
        elements, element = np.unique(molecule.element[self.chosen], return_inverse=True)
        names, name = np.unique(molecule.name[self.chosen], return_inverse=True)
        residue_names, chains = molecule.residue_name[first], molecule.chain[first]
        chain_names, chain = np.unique(chains, return_inverse=True)
        kind = molecule.kind[first]
        parts = zip(residue_names.tolist(), molecule.residue[first].tolist(), chains.tolist(), strict=True)
        types = [TYPE_OF_NAME.get(standard_name(name), len(TYPES) - 1) for name in residue_names.tolist()]
        header = {
            "residues": [molecule.residue_label(atom) for atom in first], "parts": [list(map(str, part)) for part in parts],
            "surfaced": self.n_surfaced, "trace": self.is_trace,
            "elements": elements.tolist(), "names": names.tolist(),
            "types": [[kind_name, rgb] for kind_name, (_, rgb) in TYPES.items()],
            "chains": [[chain_name, CHAIN_COLOURS[k % len(CHAIN_COLOURS)]] for k, chain_name in enumerate(chain_names.tolist())],
        }  # fmt: skip
        columns = {
            "element": element, "name": name, "residue of atom": molecule.residue_index[self.chosen], "chain": chain,
            "type": np.array(types, int), "kinds": np.where(kind == POLYMERS[0], 0, np.where(kind == POLYMERS[1], 1, 2)),
            "b": np.rint(np.nan_to_num(molecule.b_factor[self.chosen]) / B_STEP).astype(int),
        }  # fmt: skip
        return header, columns


def is_trace(molecule: Molecule) -> np.ndarray:
    """Return which atoms the trace of a polymer runs through, (A,) bool."""
    return np.isin(molecule.name, TRACE_ATOMS) & np.isin(molecule.kind, POLYMERS)


def coded_triangles(triangles: np.ndarray) -> np.ndarray:
    """Encode triangles, numbered by their first use: how far each corner lies before the next new one, 0 if it is new."""
    corners = triangles.ravel()
    new = np.zeros(len(corners), int)
    new[np.unique(corners, return_index=True)[1]] = 1
    return np.cumsum(new) - new - corners


def shape_columns(shapes: Sequence[Shape], residues: Sequence[np.ndarray]) -> dict[str, np.ndarray]:
    """Return the columns of the shapes of all frames, with the residues of their corners; atoms as steps between frames."""
    columns: dict[str, np.ndarray] = {}
    before = np.zeros_like(shapes[0].atoms, int)
    for frame, (shape, residue) in enumerate(zip(shapes, residues, strict=True)):
        normals, triangles = np.empty((0, 3)), np.empty((0, 3), int)
        if shape.mesh is not None:
            normals, triangles = shape.mesh.vertices.normals, shape.mesh.triangles
        points = np.rint(shape.corners / SHAPE_STEP).astype(int)
        atoms = np.rint(shape.atoms / SHAPE_STEP).astype(int)
        columns |= {f"{axis}{frame}": points[:, k] for k, axis in enumerate("xyz")}
        columns |= {f"atom {axis}{frame}": (atoms - before)[:, k] for k, axis in enumerate("xyz")}
        columns |= dict(zip((f"u{frame}", f"v{frame}"), flat_normals(normals).T, strict=True))
        columns |= {f"triangles{frame}": coded_triangles(triangles), f"residue{frame}": residue}
        before = atoms
    return columns
