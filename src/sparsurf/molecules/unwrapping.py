"""Molecules that the periodic box cuts are put together again."""

import numpy as np

# Å. Atoms of one residue or of neighbours in the sequence that are closer than this belong together: longer
# than any bond (S-S 2.05), and it does no harm where it links second neighbours.
LINK = 2.5
SMALLEST_BOX = 15.0  # Å; a shorter lattice vector is a dummy, or shorter than one residue
MOST_MOLECULES = 100  # beyond that (all waters selected) molecules are not moved next to each other


def make_whole(xyz, box, residue_index, join=True):
    """Move atoms by lattice vectors so that no molecule is cut by the box.

    The links are found once, in the first frame, under the minimum image convention. With `join`, the
    molecules (chains, pieces of a chain with a gap) are moved next to each other as well: each is linked by
    its shortest contact in the first frame, so that a complex stays a complex.

    Parameters
    ----------
    xyz : (F, A, 3) float64, Å
    box : (F, 3, 3) float64, Å, lattice vectors as rows
    residue_index : (A,) int, residues in the order of the sequence
    join : bool

    Returns
    -------
    (F, A, 3) float64, Å ; atoms that need not move keep their exact coordinates
    """
    if not np.isfinite(box).all() or np.linalg.norm(box, axis=2).min() < SMALLEST_BOX:
        return xyz
    links = _bonds(xyz[0], box[0], residue_index)
    if not join and not _lattice_vectors(xyz[:, links[:, 0]] - xyz[:, links[:, 1]], box).any():
        return xyz  # as most files of structures: nothing is cut
    if join:
        whole = _walk(xyz[:1], box[:1], links)[0]
        links = np.concatenate([links, _contacts(whole, box[0], links)])
    return _walk(xyz, box, links)


def _lattice_vectors(vectors, box):
    """How many lattice vectors, rounded, a vector (..., 3) spans."""
    return np.rint(vectors @ np.linalg.inv(box))


def _minimum_image(vectors, box):
    return vectors - _lattice_vectors(vectors, box) @ box


def _bonds(xyz, box, residue_index):
    """(L, 2) int: pairs of atoms closer than LINK, in one residue or in two that follow each other."""
    edges = np.flatnonzero(np.diff(residue_index)) + 1
    starts = np.concatenate([[0], edges, [len(xyz)]])
    links = []
    for start, stop, next_stop in zip(starts[:-1], starts[1:], [*starts[2:], len(xyz)], strict=True):
        vectors = xyz[start:stop, None] - xyz[None, start:next_stop]
        close = np.linalg.norm(_minimum_image(vectors, box), axis=2) < LINK
        links.append(np.argwhere(np.triu(close, k=1)) + start)
    return np.concatenate(links)


def _contacts(xyz, box, links):
    """(molecules - 1, 2) int: the shortest contacts that join all molecules, of at most 200 atoms of each."""
    from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

    n_molecules, label = connected_components(_graph(links, len(xyz)), directed=False)
    if not 1 < n_molecules <= MOST_MOLECULES:
        return np.empty((0, 2), int)
    members = [np.flatnonzero(label == each) for each in range(n_molecules)]
    members = [atoms[:: len(atoms) // 200 + 1] for atoms in members]
    distance, pair = np.zeros((n_molecules, n_molecules)), {}
    for i, first in enumerate(members):
        for j, second in enumerate(members[:i]):
            vectors = _minimum_image(xyz[first][:, None] - xyz[second][None], box)
            lengths = np.linalg.norm(vectors, axis=2)
            nearest = np.unravel_index(lengths.argmin(), lengths.shape)
            distance[i, j] = lengths[nearest] + 1e-6  # a zero would be no edge
            pair[i, j] = first[nearest[0]], second[nearest[1]]
    tree = minimum_spanning_tree(distance).tocoo()
    return np.array([pair[i, j] for i, j in zip(tree.row, tree.col, strict=True)])


def _graph(links, n_atoms):
    from scipy.sparse import coo_array  # here and above: half a second that most structures need not wait

    return coo_array((np.ones(len(links)), links.T), shape=(n_atoms, n_atoms)).tocsr()


def _walk(xyz, box, links):
    """Shift every atom to the image nearest to the atom it is linked to, from the first atom of each piece."""
    from scipy.sparse.csgraph import breadth_first_order, connected_components

    graph = _graph(links, xyz.shape[1])
    _, label = connected_components(graph, directed=False)
    roots = np.unique(label, return_index=True)[1]
    steps, parent = [], np.arange(xyz.shape[1])
    for root in roots:
        order, before = breadth_first_order(graph, root, directed=False)
        steps.extend(order[1:])
        parent[order[1:]] = before[order[1:]]
    crossings = _lattice_vectors(xyz - xyz[:, parent], box).astype(int)  # to the parent
    cut = np.flatnonzero(crossings.any(axis=(1, 2)))
    shift = crossings[cut]
    for atom in steps:  # parents come before their children
        shift[:, atom] += shift[:, parent[atom]]
    whole = xyz.copy()
    whole[cut] -= shift @ box[cut]
    return whole
