"""A molecule with its frames, everything in Å."""

from dataclasses import dataclass, fields, replace
from functools import cached_property
from string import ascii_letters

import numpy as np
import pandas as pd

from sparsurf.molecules.pdb import write_pdb
from sparsurf.molecules.selection import chosen_atoms


@dataclass(frozen=True, eq=False)
class Molecule:
    """Atoms of a molecule in one or more frames.

    Attributes
    ----------
    xyz : (F, A, 3) float64, Å
    time_ps : (F,) float64, ps; nan where the file tells no times
    frame_number : (F,) int, position of the frame in its file, from 0
    name, residue_name, chain : (A,) str, as given
    element : (A,) str, upper case, plausible for the residue
    residue : (A,) str, number with insertion code: '52A', '-5'
    residue_index : (A,) int, 0, 1, 2, ...: equal for the atoms of one residue, even if labels repeat
    kind : (A,) str, 'protein', 'nucleic', 'water' or 'other'
    b_factor : (A,) float64, Å^2; nan where the file tells none
    """

    xyz: np.ndarray
    time_ps: np.ndarray
    frame_number: np.ndarray
    name: np.ndarray
    residue_name: np.ndarray
    chain: np.ndarray
    element: np.ndarray
    residue: np.ndarray
    residue_index: np.ndarray
    kind: np.ndarray
    b_factor: np.ndarray

    @property
    def n_frames(self):
        return len(self.xyz)

    @property
    def n_atoms(self):
        return self.xyz.shape[1]

    @property
    def n_residues(self):
        return len(np.unique(self.residue_index))

    @property
    def residues(self):
        """DataFrame with chain, residue and residue_name of every residue, a new one each time."""
        first = np.unique(self.residue_index, return_index=True)[1]
        columns = ("chain", "residue", "residue_name")
        return pd.DataFrame({name: getattr(self, name)[first] for name in columns})

    def labels(self, atoms):
        """DataFrame with chain, residue, residue_name, atom_name and atom (its index from 0) of atoms (N,)."""
        columns = {
            "chain": "chain",
            "residue": "residue",
            "residue_name": "residue_name",
            "atom_name": "name",
        }
        return pd.DataFrame({key: getattr(self, name)[atoms] for key, name in columns.items()}).assign(
            atom=atoms
        )

    def take(self, atoms):
        """The molecule with only `atoms`, a mask or indices."""
        names = [each.name for each in fields(self)][3:]
        chosen = {name: getattr(self, name)[atoms] for name in names}
        chosen["residue_index"] = np.unique(chosen["residue_index"], return_inverse=True)[1]
        return replace(self, xyz=self.xyz[:, atoms], **chosen)

    def select(self, path="the molecule", **keys):
        """The molecule with only the atoms that `selection.chosen_atoms` chooses by the keys."""
        return self.take(chosen_atoms(self, path, **keys))

    def frame(self, index):
        """The molecule with only the frame at position `index`."""
        at = slice(index, index + 1)
        return replace(self, xyz=self.xyz[at], time_ps=self.time_ps[at], frame_number=self.frame_number[at])

    def write_pdb(self, path, frame=0, b_factor=None):
        """Write one frame as a PDB file of one model, in Å, with a number (A,) per atom in the B-factor column; without,
        the molecule's own."""
        b_factor = np.clip(np.nan_to_num(self.b_factor), -99.99, 999.99) if b_factor is None else b_factor
        write_pdb(path, self.xyz[frame], self, b_factor)

    @cached_property
    def topology(self):
        """mdtraj.Topology without bonds, for selection expressions; `segname` is the chain id."""
        import mdtraj  # here: few ask for an expression, and it takes a quarter of a second

        def element(symbol):
            try:
                return mdtraj.element.get_by_symbol(symbol)
            except KeyError:
                return mdtraj.element.virtual

        topology, chains, residues = mdtraj.Topology(), {}, {}
        for i, index in enumerate(self.residue_index.tolist()):
            chain = str(self.chain[i])
            if chain not in chains:
                chains[chain] = topology.add_chain(chain)
            if index not in residues:
                number = int(self.residue[i].rstrip(ascii_letters) or 0)
                residues[index] = topology.add_residue(
                    str(self.residue_name[i]), chains[chain], number, chain
                )
            topology.add_atom(str(self.name[i]), element(str(self.element[i])), residues[index])
        return topology
