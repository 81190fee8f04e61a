"""Make molecules whole that the periodic box cuts.

A bond that is whole is never shifted, and a repair that would stretch one, or lay molecules onto each other, is refused: the
box is then not that of the coordinates.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.molecules.atom_table import MIN_BOX_VOLUME

if TYPE_CHECKING:
    from scipy.sparse import csr_array

# Å. Atoms of one residue, or of neighbours in the sequence, are linked if they are closer than this. It is longer than
# any bond (S-S 2.05); a link between second neighbours does no harm.
MAX_LINK = 2.5
MIN_BOX = 15.0  # Å; a shorter lattice vector is a dummy, or shorter than one residue
MAX_MOLECULES = 100  # more molecules (all waters selected) are not moved next to each other
MAX_ATOMS_PER_CONTACT = 200  # atoms of each molecule that are searched for contacts
# Å; atoms that are linked in the first frame are no farther apart in another where they are whole
STILL_LINKED = 3.5
# Å, by which a repair may lengthen a link; it is 0 but for rounding if the box is right
MAX_LINK_STRETCH = 0.5
PAIRS_AT_ONCE = 16_000  # The distances of so many pairs of atoms are measured at once.
BOND_ACROSS = 1.65  # Å; atoms of two neighbouring residues are that close only if they are bonded
IN_ONE_PLACE = 1.0  # Å; atoms of two molecules are never that close


class Unwrapping:
    """Moves atoms by lattice vectors so that the box cuts no molecule, in any frames after the first one is known.

    The links are found once, in the first frame: those that are whole there, and under the minimum image convention those
    between the pieces that are left. With `join`, the molecules (chains, pieces of a chain with a gap) are also moved next to
    each other: each is linked by its shortest contact in the first frame, so that a complex stays a complex; with None, this
    is done if a bond crosses the border of the box there. Atoms that need not move keep their exact coordinates. That frame
    has the places xyz (A, 3), Å, lattice vectors as rows of `box`, and residues in the order of the sequence.
    """

    def __init__(
        self,
        xyz: np.ndarray,
        box: np.ndarray,
        residue_index: np.ndarray,
        join: bool | None = True,
    ) -> None:
        near = _near_pairs(xyz, box, residue_index)
        self.links = self.bonds = _links(near, len(xyz))
        self.join = _bond_crosses(near, residue_index) if join is None else join
        if self.join:
            whole = self._shifted(xyz[None], box[None])[0]
            self.links = np.concatenate([self.links, _contacts(whole, box, self.links)])
            del self._tree  # of fewer links

    def __call__(self, xyz: np.ndarray, box: np.ndarray, number: np.ndarray | None = None) -> np.ndarray:
        """Return frames (F, A, 3) with boxes (F, 3, 3), made whole; `number` are the numbers of the frames in the file."""
        if has_no_box(box):
            return xyz
        vectors = xyz[:, self.links[:, 0]] - xyz[:, self.links[:, 1]]
        if not self.join and not _crossings(vectors, box).any():
            return xyz  # nothing is cut, as in most structures
        whole = self._shifted(xyz, box)
        self._refuse_damage(xyz, whole, np.arange(len(xyz)) if number is None else number)
        return whole

    def _refuse_damage(self, before: np.ndarray, after: np.ndarray, number: np.ndarray) -> None:
        """Raise InputError if a repair stretches a bond of any frame, or lays molecules onto each other."""
        lengths = [
            np.linalg.norm(xyz[:, self.bonds[:, 0]] - xyz[:, self.bonds[:, 1]], axis=2)
            for xyz in (before, after)
        ]
        stretched = (lengths[0] < STILL_LINKED) & (lengths[1] > lengths[0] + MAX_LINK_STRETCH)
        for frame in np.flatnonzero((before != after).any(axis=(1, 2))).tolist():
            problem = ""
            if stretched[frame].any():
                problem = f"would stretch a bond to {lengths[1][frame][stretched[frame]].max():.1f} Å"
            elif len(self.links) > len(self.bonds) and self._overlaps(after[frame]) > self._overlaps(
                before[frame]
            ):
                problem = "would lay atoms of one molecule onto another"
            if problem:
                raise InputError(
                    f"{FILE}: the box and the coordinates in frame {number[frame]} do not fit together, since making "
                    f"molecules whole {problem}: correct that frame, or leave it out."
                )

    def _overlaps(self, xyz: np.ndarray) -> int:
        """Count the pairs of atoms of two molecules that lie in one place."""
        from scipy.spatial import cKDTree

        pairs = cKDTree(xyz).query_pairs(IN_ONE_PLACE, output_type="ndarray")
        return int((self._molecule[pairs[:, 0]] != self._molecule[pairs[:, 1]]).sum())

    @cached_property
    def _molecule(self) -> np.ndarray:
        """Number of the molecule of each atom (A,): what bonds join."""
        return pieces(self.bonds, int(self.n_atoms))

    @cached_property
    def _tree(self) -> tuple[list[int], np.ndarray]:
        """Atoms after the ones that they are linked to, and the latter (A,); the first of each piece is its own."""
        from scipy.sparse.csgraph import breadth_first_order

        n_atoms = int(self.n_atoms)
        graph, label = _graph(self.links, n_atoms), pieces(self.links, n_atoms)
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
        crossings = _crossings(xyz - xyz[:, parent], box).astype(int)  # to the parent
        cut = np.flatnonzero(crossings.any(axis=(1, 2)))
        shift = crossings[cut]
        for atom in steps:  # parents come before their children
            shift[:, atom] += shift[:, parent[atom]]
        whole = xyz.copy()
        whole[cut] -= shift @ box[cut]
        return whole


def make_whole(xyz: np.ndarray, box: np.ndarray, residue_index: np.ndarray, join: bool = True) -> np.ndarray:
    """Return frames (F, A, 3) with boxes (F, 3, 3), made whole, see `Unwrapping`.

    Without `join`, molecules are moved next to each other only if a bond crosses the border of the box in the first frame: the
    box is then that of a simulation, not of a crystal.
    """
    if has_no_box(box):
        return xyz
    return Unwrapping(xyz[0], box[0], residue_index, join or None)(xyz, box)


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


def _crossings(vectors: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return the number of lattice vectors, rounded, that vectors (F, N, 3) between linked atoms span; 0 for a whole link."""
    crossings = _lattice_vectors(vectors, box)
    if crossings.any():
        crossings[np.linalg.norm(vectors, axis=2) < STILL_LINKED] = 0
    return crossings


# Pairs of atoms (P, 2), their distance, and that across the border
Near = tuple[np.ndarray, np.ndarray, np.ndarray]


def _links(near: Near, n_atoms: int) -> np.ndarray:
    """Return the pairs (L, 2) closer than MAX_LINK; across the border of the box, those of pieces that no other pairs join."""
    pairs, length, across = near
    direct, image = pairs[length < MAX_LINK], pairs[(length >= MAX_LINK) & (across < MAX_LINK)]
    if len(image):
        piece = pieces(direct, n_atoms)
        image = image[piece[image[:, 0]] != piece[image[:, 1]]]
    return np.concatenate([direct, image])


def _near_pairs(xyz: np.ndarray, box: np.ndarray, residue_index: np.ndarray) -> Near:
    """Find pairs (P, 2) of atoms of one residue or two consecutive ones, near or across the border, and both distances."""
    atoms, axes = np.arange(len(xyz)), np.ascontiguousarray(xyz.T)
    begins = np.append(True, np.diff(residue_index) != 0)
    end_of_next = np.append(np.flatnonzero(begins), [len(xyz)] * 2)[np.cumsum(begins) + 1]
    n_behind = end_of_next - atoms - 1  # in the residue of each atom and the next one
    n_before = np.cumsum(n_behind) - n_behind
    # Only half of a lattice vector or more can be shorter across the border; less by what is lost in rounding
    may_cross = 0.49 / np.linalg.norm(np.linalg.inv(box), axis=0).max()
    pairs, lengths, images = [np.empty((0, 2), int)], [np.empty(0)], [np.empty(0)]
    for block in np.split(atoms, np.flatnonzero(np.diff(n_before // PAIRS_AT_ONCE)) + 1):
        first = np.repeat(block, n_behind[block])
        second = (
            first
            + 1
            + np.arange(len(first))
            - np.repeat(n_before[block] - n_before[block[:1]], n_behind[block])
        )
        vectors = axes.take(first, axis=1) - axes.take(second, axis=1)
        direct = np.linalg.norm(vectors, axis=0)
        across, far = direct.copy(), np.flatnonzero(direct > may_cross)
        across[far] = np.linalg.norm(_minimum_image(vectors.T[far], box), axis=1)
        near = np.minimum(direct, across) < MAX_LINK
        pairs.append(np.column_stack([first[near], second[near]]))
        lengths.append(direct[near])
        images.append(across[near])
    return np.concatenate(pairs), np.concatenate(lengths), np.concatenate(images)


def _bond_crosses(near: Near, residue_index: np.ndarray) -> bool:
    """Return whether the border of the box cuts a residue, or the bond between two consecutive ones."""
    pairs, length, across = near
    in_one_residue = residue_index[pairs[:, 0]] == residue_index[pairs[:, 1]]
    return bool(((length > STILL_LINKED) & (across < np.where(in_one_residue, MAX_LINK, BOND_ACROSS))).any())


def _contacts(xyz: np.ndarray, box: np.ndarray, links: np.ndarray) -> np.ndarray:
    """Find the shortest contacts (molecules - 1, 2) that join all molecules, among some atoms of each."""
    from scipy.sparse.csgraph import minimum_spanning_tree

    label = pieces(links, len(xyz))
    n_molecules = label.max() + 1
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


def pieces(links: np.ndarray, n: int) -> np.ndarray:
    """Return the number of the piece that each of n points belongs to, (n,): points that links (L, 2) connect are one.

    The pieces are numbered in the order of their first points.
    """
    first, before = np.arange(n), np.empty(0, np.intp)  # of the piece of each point, as far as it is known
    while not np.array_equal(first, before):
        before = first.copy()
        ends = before[links]
        np.minimum.at(first, ends.ravel(), np.repeat(ends.min(axis=1), 2))
        while (first[first] != first).any():
            first = first[first]
    return np.unique(first, return_inverse=True)[1]


def _graph(links: np.ndarray, n_atoms: int) -> csr_array:
    """Return the links as a sparse matrix."""
    # here and above: it takes half a second to load, and most structures do not need it
    from scipy.sparse import coo_array

    return coo_array((np.ones(len(links)), links.T), shape=(n_atoms, n_atoms)).tocsr()
