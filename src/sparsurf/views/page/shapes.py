"""The triangles of a surface and the atoms below it, as small as a page can hold them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.residues import standard_name
from sparsurf.molecules.selection import POLYMERS
from sparsurf.surfaces.mesh import Mesh
from sparsurf.surfaces.surface import Surface
from sparsurf.surfaces.thinning import coarsened
from sparsurf.views.page.packing import flat_normals

SPARSER = 0.7  # of the density of a mesh, while a page is too large
SHAPE_STEP = 0.02  # Å, of positions on a page
B_STEP = 0.01  # Å^2
TRACE_ATOMS = ("CA", "C4'", "C4*")
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
    """The surface and the atoms of one frame, in Å."""

    mesh: Mesh
    atoms: np.ndarray  # (A, 3), of `DrawnAtoms`

    def in_order(self) -> Shape:
        """Return the shape with its corners in the order of their first use, so that most steps between them are small."""
        used, first, place = np.unique(self.mesh.triangles, return_index=True, return_inverse=True)
        order = np.argsort(first)
        renumbered = np.empty(len(used), int)
        renumbered[order] = np.arange(len(used))
        vertices = self.mesh.vertices.take(used[order])
        return Shape(Mesh(vertices, renumbered[place].reshape(-1, 3)), self.atoms)

    def sparser(self) -> Shape:
        """Return a shape whose mesh has fewer corners."""
        vertices = self.mesh.vertices
        if not len(vertices):
            return self
        return Shape(coarsened(self.mesh, SPARSER * len(vertices) / float(vertices.area.sum())), self.atoms)


def no_mesh() -> Mesh:
    """Return a mesh without triangles, of dots that enclose nothing."""
    nothing = np.empty((0, 3))
    return Mesh(Surface(nothing, nothing, np.empty(0)), np.empty((0, 3), np.int64))


class DrawnAtoms:
    """The atoms that a page holds, of the molecule that has the surface and of others around it, which come after it.

    Attributes
    ----------
    chosen : one array of indices for each molecule, of its atoms that the page holds
    n_residues : of all of them; n_surfaced : of the first
    is_trace : whether the page holds the atoms of the trace alone
    """

    def __init__(self, molecule: Molecule, around: Molecule | None = None) -> None:
        self.around = around
        self.parts = [molecule] if around is None else [molecule, around]
        self.n_surfaced = molecule.n_residues
        self.n_residues = sum(part.n_residues for part in self.parts)
        self.is_trace = sum(int(part.heavy.sum()) for part in self.parts) > MAX_DRAWN_ATOMS
        self.chosen = [
            np.flatnonzero(is_trace(part) | ~np.isin(part.kind, POLYMERS) if self.is_trace else part.heavy)
            for part in self.parts
        ]

    def xyz(self, frame: int) -> np.ndarray:
        """Return the positions of the atoms in a frame, (A, 3), Å."""
        return self.placed(np.concatenate([part.xyz[frame] for part in self.parts]))

    def placed(self, xyz: np.ndarray) -> np.ndarray:
        """Return those of the positions of all atoms, (n, 3), that the page holds, (A, 3)."""
        first = np.cumsum([0, *(part.n_atoms for part in self.parts)])
        return xyz[np.concatenate([begin + atoms for begin, atoms in zip(first, self.chosen, strict=False)])]

    def of_atoms(self, name: str) -> np.ndarray:
        """Return an attribute of the atoms, (A,)."""
        return np.concatenate(
            [getattr(part, name)[atoms] for part, atoms in zip(self.parts, self.chosen, strict=True)]
        )

    def residue_of_atom(self) -> np.ndarray:
        """Return the residue of each atom, (A,), numbered through all molecules."""
        first = np.cumsum([0, *(part.n_residues for part in self.parts)])
        return np.concatenate([
            number + part.residue_index[atoms]
            for number, part, atoms in zip(first, self.parts, self.chosen, strict=False)
        ])  # fmt: skip

    def of_residues(self, name: str) -> np.ndarray:
        """Return an attribute of the residues, (R,)."""
        return np.concatenate([
            getattr(part, name)[np.unique(part.residue_index, return_index=True)[1]] for part in self.parts
        ])  # fmt: skip

    def labels(self) -> list[str]:
        """Return the labels of the residues."""
        return [
            part.residue_label(atom)
            for part in self.parts
            for atom in np.unique(part.residue_index, return_index=True)[1]
        ]

    def header(self) -> tuple[dict[str, object], dict[str, np.ndarray]]:
        """Return what a page says of the atoms and residues: entries of its header, and columns."""
        elements, element = np.unique(self.of_atoms("element"), return_inverse=True)
        names, name = np.unique(self.of_atoms("name"), return_inverse=True)
        residue_names, chains = self.of_residues("residue_name"), self.of_residues("chain")
        chain_names, chain = np.unique(chains, return_inverse=True)
        kind = self.of_residues("kind")
        parts = zip(
            residue_names.tolist(), self.of_residues("residue").tolist(), chains.tolist(), strict=True
        )
        types = [TYPE_OF_NAME.get(standard_name(name), len(TYPES) - 1) for name in residue_names.tolist()]
        header = {
            "residues": self.labels(), "parts": [list(map(str, part)) for part in parts], "surfaced": self.n_surfaced,
            "elements": elements.tolist(), "names": names.tolist(),
            "types": [[kind_name, rgb] for kind_name, (_, rgb) in TYPES.items()],
            "chains": [[chain_name, CHAIN_COLOURS[k % len(CHAIN_COLOURS)]] for k, chain_name in enumerate(chain_names.tolist())],
        }  # fmt: skip
        columns = {
            "element": element, "name": name, "residue of atom": self.residue_of_atom(), "chain": chain,
            "type": np.array(types, int), "kinds": np.where(kind == POLYMERS[0], 0, np.where(kind == POLYMERS[1], 1, 2)),
            "b": np.rint(np.nan_to_num(self.of_atoms("b_factor")) / B_STEP).astype(int),
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
        vertices = shape.mesh.vertices
        points = np.rint(vertices.points / SHAPE_STEP).astype(int)
        atoms = np.rint(shape.atoms / SHAPE_STEP).astype(int)
        columns |= {f"{axis}{frame}": points[:, k] for k, axis in enumerate("xyz")}
        columns |= {f"atom {axis}{frame}": (atoms - before)[:, k] for k, axis in enumerate("xyz")}
        columns |= dict(zip((f"u{frame}", f"v{frame}"), flat_normals(vertices.normals).T, strict=True))
        columns |= {f"triangles{frame}": coded_triangles(shape.mesh.triangles), f"residue{frame}": residue}
        before = atoms
    return columns
