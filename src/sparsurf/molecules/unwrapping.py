"""Make molecules whole that the periodic box cuts."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.molecules.atom_table import MIN_BOX_VOLUME

if TYPE_CHECKING:
    from scipy.sparse import csr_array

# Å. Atoms of one residue, or of neighbours in the sequence, are linked if they are closer than this. It is longer than
# any bond (S-S 2.05); a link between second neighbours does no harm.
MAX_LINK = 2.5
MIN_BOX = 15.0  # Å; a shorter lattice vector is a dummy, or shorter than one residue
MAX_MOLECULES = 100  # more molecules (all waters selected) are not moved next to each other
MAX_ATOMS_PER_CONTACT = 200  # atoms of each molecule that are searched for contacts


class Unwrapping:
    """Moves atoms by lattice vectors so that the box cuts no molecule, in any frames after the first one is known.

    The links are found once, in the first frame, under the minimum image convention. With `join`, the molecules (chains,
    pieces of a chain with a gap) are also moved next to each other: each is linked by its shortest contact in the first
    frame, so that a complex stays a complex. Atoms that need not move keep their exact coordinates. That frame has the
    places xyz (A, 3), Å, lattice vectors as rows of `box`, and residues in the order of the sequence.
    """

    def __init__(
        self, xyz: np.ndarray, box: np.ndarray, residue_index: np.ndarray, join: bool = True
    ) -> None:
        self.links = _links(xyz, box, residue_index)
        self.join = join
        if join:
            whole = self._shifted(xyz[None], box[None])[0]
            self.links = np.concatenate([self.links, _contacts(whole, box, self.links)])
            del self._tree  # of fewer links

    def __call__(self, xyz: np.ndarray, box: np.ndarray) -> np.ndarray:
        """Return frames (F, A, 3) with boxes (F, 3, 3), made whole."""
        if has_no_box(box):
            return xyz
        vectors = xyz[:, self.links[:, 0]] - xyz[:, self.links[:, 1]]
        if not self.join and not _lattice_vectors(vectors, box).any():
            return xyz  # nothing is cut, as in most structures
        return self._shifted(xyz, box)

    @cached_property
    def _tree(self) -> tuple[list[int], np.ndarray]:
        """Atoms after the ones that they are linked to, and the latter (A,); the first of each piece is its own."""
        from scipy.sparse.csgraph import breadth_first_order, connected_components

        n_atoms = int(self.n_atoms)
        graph = _graph(self.links, n_atoms)
        _, label = connected_components(graph, directed=False)
        steps: list[int] = []
        parent = np.arange(n_atoms)
        for root in np.unique(label, return_index=True)[1]:
            order, before = breadth_first_order(graph, root, directed=False)
            steps.extend(order[1:])
            parent[order[1:]] = before[order[1:]]
        return steps, parent

    def _shifted(self, xyz: np.ndarray, box: np.ndarray) -> np.ndarray:
        """Shift every atom to the image nearest to the atom it is linked to, from the first atom of each piece."""
        self.n_atoms = xyz.shape[1]
        steps, parent = self._tree
        crossings = _lattice_vectors(xyz - xyz[:, parent], box).astype(int)  # to the parent
        cut = np.flatnonzero(crossings.any(axis=(1, 2)))
        shift = crossings[cut]
        for atom in steps:  # parents come before their children
            shift[:, atom] += shift[:, parent[atom]]
        whole = xyz.copy()
        whole[cut] -= shift @ box[cut]
        return whole


def make_whole(xyz: np.ndarray, box: np.ndarray, residue_index: np.ndarray, join: bool = True) -> np.ndarray:
    """Return frames (F, A, 3) with boxes (F, 3, 3), made whole, see `Unwrapping`."""
    return xyz if has_no_box(box) else Unwrapping(xyz[0], box[0], residue_index, join)(xyz, box)


def has_no_box(box: np.ndarray) -> bool:
    """Return whether boxes (F, 3, 3) are dummies, flat or no numbers."""
    if not np.isfinite(box).all():
        return True
    lengths = np.linalg.norm(box, axis=2)
    return bool(
        (lengths < MIN_BOX).any()
        or (np.abs(np.linalg.det(box)) < MIN_BOX_VOLUME * lengths.prod(axis=1)).any()
    )


def _lattice_vectors(vectors: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return the number of lattice vectors, rounded, that vectors (..., 3) span."""
    return np.rint(vectors @ np.linalg.inv(box))


def _minimum_image(vectors: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Shift vectors (..., 3) by lattice vectors to be as short as possible."""
    return vectors - _lattice_vectors(vectors, box) @ box


def _links(xyz: np.ndarray, box: np.ndarray, residue_index: np.ndarray) -> np.ndarray:
    """Find pairs (L, 2) of atoms closer than MAX_LINK, in one residue or in two consecutive ones."""
    edges = np.flatnonzero(np.diff(residue_index)) + 1
    starts = np.concatenate([[0], edges, [len(xyz)]])
    links = []
    for start, stop, next_stop in zip(starts[:-1], starts[1:], [*starts[2:], len(xyz)], strict=True):
        vectors = xyz[start:stop, None] - xyz[None, start:next_stop]
        close = np.linalg.norm(_minimum_image(vectors, box), axis=2) < MAX_LINK
        links.append(np.argwhere(np.triu(close, k=1)) + start)
    return np.concatenate(links)


def _contacts(xyz: np.ndarray, box: np.ndarray, links: np.ndarray) -> np.ndarray:
    """Find the shortest contacts (molecules - 1, 2) that join all molecules, among some atoms of each."""
    from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

    n_molecules, label = connected_components(_graph(links, len(xyz)), directed=False)
    if not 1 < n_molecules <= MAX_MOLECULES:
        return np.empty((0, 2), int)
    members = [np.flatnonzero(label == molecule) for molecule in range(n_molecules)]
    members = [atoms[:: len(atoms) // MAX_ATOMS_PER_CONTACT + 1] for atoms in members]
    distance, pair = np.zeros((n_molecules, n_molecules)), {}
    for i, first in enumerate(members):
        for j, second in enumerate(members[:i]):
            vectors = _minimum_image(xyz[first][:, None] - xyz[second][None], box)
            lengths = np.linalg.norm(vectors, axis=2)
            nearest = np.unravel_index(lengths.argmin(), lengths.shape)
            distance[i, j] = lengths[nearest] + 1e-6  # a zero would be no edge
            pair[i, j] = first[nearest[0]], second[nearest[1]]
    tree = minimum_spanning_tree(distance).tocoo()
    return np.array([pair[int(i), int(j)] for i, j in zip(tree.row, tree.col, strict=True)])


def _graph(links: np.ndarray, n_atoms: int) -> csr_array:
    """Return the links as a sparse matrix."""
    from scipy.sparse import (
        coo_array,  # here and above: takes half a second, which most structures do not need
    )

    return coo_array((np.ones(len(links)), links.T), shape=(n_atoms, n_atoms)).tocsr()
