"""A molecule with its frames, everything in Å."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sparsurf.display import Shown
from sparsurf.errors import naming_file
from sparsurf.files import StrPath, pluralise
from sparsurf.molecules.residues import first_atoms, split_label
from sparsurf.molecules.selection import select_atoms

if TYPE_CHECKING:
    import mdtraj
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Molecule(Shown):
    """Atoms of a molecule in one or more frames.

    Attributes
    ----------
    xyz : (F, A, 3) float64, Å
    time_ps : (F,) float64, ps; nan where the file has no times
    frame_number : (F,) int, position of the frame in its file, from 0
    name, residue_name, chain : (A,) str, as in the file
    element : (A,) str, upper case, possible for the residue
    residue : (A,) str, number with insertion code: '52A', '-5'
    residue_index : (A,) int, 0, 1, 2, ...: the residue of each atom, even if labels repeat
    kind : (A,) str, 'protein', 'nucleic', 'water' or 'other'
    b_factor : (A,) float64, Å^2; nan where the file has none
    masked_residues : int, residues left out for their pLDDT; None without a bound, or if the model is not a predicted one
    files : the files that it was read from, which `write` never replaces
    is_prediction : whether its file says that the B factors are the confidence of a prediction (pLDDT)
    """

    xyz: NDArray[np.float64]
    time_ps: NDArray[np.float64]
    frame_number: np.ndarray
    name: np.ndarray
    residue_name: np.ndarray
    chain: np.ndarray
    element: np.ndarray
    residue: np.ndarray
    residue_index: np.ndarray
    kind: np.ndarray
    b_factor: NDArray[np.float64]
    masked_residues: int | None = None
    files: tuple[str, ...] = ()
    is_prediction: bool = False

    def __repr__(self) -> str:
        numbers = [(self.n_atoms, "atom"), (self.n_residues, "residue"), (self.n_frames, "frame")]
        atoms, residues, frames = (pluralise(number, noun) for number, noun in numbers)
        return f"Molecule of {atoms} in {residues}, {frames}"

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.xyz)

    @property
    def n_atoms(self) -> int:
        """Number of atoms."""
        return self.xyz.shape[1]

    @property
    def n_residues(self) -> int:
        """Number of residues."""
        return len(np.unique(self.residue_index))

    @property
    def counted_residues(self) -> str:
        """How many residues of chains, ligands and waters there are, in words, as '198 residues and 1 ligand'."""
        kind = self.kind[first_atoms(self.residue_index)]
        of_kind = {"ligand": int((kind == "other").sum()), "water": int((kind == "water").sum())}
        of_kind = {"residue": len(kind) - sum(of_kind.values())} | of_kind
        counts = [pluralise(n, noun, separator=",") for noun, n in of_kind.items() if n]
        return " and ".join([", ".join(counts[:-1]), counts[-1]] if len(counts) > 1 else counts)

    @property
    def heavy(self) -> np.ndarray:
        """Mask (A,) of the atoms that are not hydrogens."""
        return ~np.isin(self.element, ["H", "D"])

    @property
    def residues(self) -> pd.DataFrame:
        """DataFrame with chain, residue and residue_name of every residue; a new one at each call."""
        import pandas as pd  # here: it takes long to load

        return pd.DataFrame(self.residue_columns())

    def residue_columns(self) -> dict[str, np.ndarray]:
        """Return the columns of `residues` by name."""
        first = first_atoms(self.residue_index)
        return {name: getattr(self, name)[first] for name in ("chain", "residue", "residue_name")}

    def residue_label(self, atom: int) -> str:
        """Return the label of an atom's residue, as 'GLU 209 A'."""
        return f"{self.residue_name[atom]} {self.residue[atom]} {self.chain[atom]}".strip()

    def labels(self, atoms: np.ndarray) -> pd.DataFrame:
        """Return chain, residue, residue_name, atom_name and atom (its index from 0) of atoms (N,)."""
        import pandas as pd  # here: it takes long to load

        return pd.DataFrame(self.label_columns(atoms))

    def label_columns(self, atoms: np.ndarray) -> dict[str, np.ndarray]:
        """Return the columns of `labels` by name."""
        labels = {name: getattr(self, name)[atoms] for name in ("chain", "residue", "residue_name")}
        return labels | {"atom_name": self.name[atoms], "atom": atoms}

    def to_frame(self, frame: int = 0) -> pd.DataFrame:
        """Tabulate chain, residue, residue_name, atom_name, atom and element of all atoms, and x, y, z in a frame, Å."""
        import pandas as pd  # here: it takes long to load

        columns = self.label_columns(np.arange(self.n_atoms)) | {"element": self.element}
        return pd.DataFrame(columns | dict(zip("xyz", self.xyz[frame].T, strict=True)))

    def take(self, atoms: np.ndarray | slice) -> Molecule:
        """Return the molecule with only `atoms`, a mask or indices."""
        names = [attribute.name for attribute in fields(self)][3:-3]
        chosen = {name: getattr(self, name)[atoms] for name in names}
        chosen["residue_index"] = np.unique(chosen["residue_index"], return_inverse=True)[1]
        return replace(self, xyz=self.xyz[:, atoms], **chosen)

    def select(self, path: StrPath = "the molecule", **keys: Any) -> Molecule:
        """Return the molecule with only the atoms that `selection.select_atoms` selects by the keys."""
        with naming_file(path):
            return self.take(select_atoms(self, **keys))

    def frame(self, index: int) -> Molecule:
        """Return the molecule with only the frame at position `index`."""
        frames = slice(index, index + 1)
        return replace(
            self, xyz=self.xyz[frames], time_ps=self.time_ps[frames], frame_number=self.frame_number[frames]
        )

    def write_pdb(self, path: StrPath, frame: int = 0, b_factor: np.ndarray | None = None) -> None:
        """Write one frame as a PDB file of one model, in Å.

        Parameters
        ----------
        path : str or Path
        frame : int
            Position of the frame.
        b_factor : (A,) float, optional
            Numbers for the B-factor column; by default the molecule's B factors.
        """
        from sparsurf.molecules.pdb import pdb_b_factor, write_pdb  # here: it loads gemmi

        b_factor = pdb_b_factor(self.b_factor) if b_factor is None else b_factor
        write_pdb(path, self.xyz[frame], self, b_factor)

    @cached_property
    def topology(self) -> mdtraj.Topology:
        """mdtraj.Topology without bonds, for selection expressions; `segname` is the chain id.

        mdtraj has no insertion codes. A residue with one has a number between those of its neighbours in the chain, such as
        52.5 for 52A, so that `residue 52` is 52 alone and `residue 52 to 53` includes 52A.
        """
        import mdtraj  # takes a quarter of a second, and expressions are rare

        def element(symbol: str) -> mdtraj.core.element.Element:
            """Return mdtraj's element of a symbol; a virtual site if there is none."""
            try:
                return mdtraj.element.get_by_symbol(symbol)
            except KeyError:
                return mdtraj.element.virtual

        topology, numbers = mdtraj.Topology(), self._numbers()
        chains: dict[str, Any] = {}
        residues: dict[int, Any] = {}
        for i, index in enumerate(self.residue_index.tolist()):
            chain = str(self.chain[i])
            if chain not in chains:
                chains[chain] = topology.add_chain(chain)
            if index not in residues:
                residues[index] = topology.add_residue(
                    str(self.residue_name[i]), chains[chain], numbers[index], chain
                )
            topology.add_atom(str(self.name[i]), element(str(self.element[i])), residues[index])
        return topology

    def _numbers(self) -> dict[int, float]:
        """Return the number of each residue by its index; half a step away from it for one with an insertion code."""
        first = first_atoms(self.residue_index)
        labels = [split_label(label) for label in self.residue[first].tolist()]
        chains = self.chain[first].tolist()
        plain = {
            (chain, label[0]): k
            for k, (chain, label) in enumerate(zip(chains, labels, strict=True))
            if not label[1]
        }
        numbers: dict[int, float] = {}
        for k, (chain, (number, code)) in enumerate(zip(chains, labels, strict=True)):
            before = k < plain.get((chain, number), -1)
            numbers[int(self.residue_index[first[k]])] = int(number or 0) + (0.5 - before if code else 0)
        return numbers
