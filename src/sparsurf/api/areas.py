"""Accessible, excluded and buried areas by atom, residue and chain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sparsurf.api.inputs import MoleculeLike, as_spheres, refuse_dots
from sparsurf.arguments import PROBE, RadiiTable, check_choice
from sparsurf.errors import InputError
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.residues import standard_name
from sparsurf.suggestions import public
from sparsurf.surfaces.areas import areas_of_spheres
from sparsurf.surfaces.radii import PROBE_RADIUS, RADII
from sparsurf.surfaces.radii import radii as radii_of

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike

# Å^2, the largest accessible area that a residue X can have in Gly-X-Gly: theoretical values of Tien et al., PLoS ONE 8:e80635
MAX_ACCESSIBLE_AREA = {
    "ALA": 129.0, "ARG": 274.0, "ASN": 195.0, "ASP": 193.0, "CYS": 167.0, "GLN": 225.0, "GLU": 223.0, "GLY": 104.0, "HIS": 224.0,
    "ILE": 197.0, "LEU": 201.0, "LYS": 236.0, "MET": 224.0, "PHE": 240.0, "PRO": 159.0, "SER": 155.0, "THR": 172.0, "TRP": 285.0,
    "TYR": 263.0, "VAL": 174.0,
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Areas:
    """Exact areas of the atoms of a molecule.

    Attributes
    ----------
    accessible : (A,) float64, Å^2, solvent-accessible area, where the centre of a probe that touches the atom can be
    excluded : (A,) float64, Å^2, area of the solvent-excluded surface, which the probe touches or bridges
    buried : (A,) float64, Å^2, accessible area of the atom's chain alone that the other chains take
    probe_radius : float, Å, of the probe
    table : name of the table of radii, None for spheres
    molecule : Molecule, or None for spheres
    frame : int, position of its frame
    """

    accessible: NDArray[np.float64]
    excluded: NDArray[np.float64]
    buried: NDArray[np.float64]
    probe_radius: float
    table: str | None = None
    molecule: Molecule | None = None
    frame: int = 0

    def __repr__(self) -> str:
        return (
            f"Areas of {len(self):,} atoms: {self.accessible.sum():,.0f} Å^2 accessible, "
            f"{self.excluded.sum():,.0f} Å^2 excluded"
        )

    def __len__(self) -> int:
        return len(self.accessible)

    @cached_property
    def atoms(self) -> pd.DataFrame:
        """Table of atoms: chain, residue, residue_name, atom_name, atom, accessible, excluded and buried.

        Spheres have only their number, from 0, and the first two areas.
        """
        import pandas as pd  # here: it takes long to load

        numbers = np.arange(len(self))
        if self.molecule is None:
            return pd.DataFrame({"atom": numbers, "accessible": self.accessible, "excluded": self.excluded})
        return pd.DataFrame(self.molecule.label_columns(numbers) | self._areas)

    @cached_property
    def residues(self) -> pd.DataFrame:
        """Table of residues: chain, residue, residue_name, accessible, excluded, relative and buried.

        The relative area is the accessible one over the largest that the residue can have (Tien et al., PLoS ONE 8:e80635, 2013);
        NaN for residues that have no such maximum, such as nucleotides and ligands.
        """
        molecule = self._known_molecule("residues")
        table = molecule.residues.assign(**self._sums(molecule.residue_index))
        table.insert(5, "relative", table["accessible"] / maximal_areas(table["residue_name"].to_numpy(str)))
        return table

    @cached_property
    def chains(self) -> pd.DataFrame:
        """Table of chains: chain, accessible, excluded and buried."""
        import pandas as pd

        chain = self._known_molecule("chains").chain
        numbers, names = pd.factorize(chain)
        return pd.DataFrame({"chain": names} | self._sums(numbers))

    @cached_property
    def pairs(self) -> pd.DataFrame:
        """Table of pairs of chains: chain, other, and the accessible area of `chain` that `other` buries where both are alone.

        Each pair has two rows, one for each of its chains; pairs that bury nothing are left out.
        """
        import pandas as pd

        molecule = self._known_molecule("pairs")
        xyz, radii = molecule.xyz[self.frame].round(3), radii_of(molecule, self.table or "dms")
        reach = 2 * (radii.max() + self.probe_radius)
        rows = []
        for names in combinations(dict.fromkeys(molecule.chain.tolist()), 2):
            of_chain = [molecule.chain == name for name in names]
            low = np.array([xyz[mask].min(axis=0) for mask in of_chain])
            high = np.array([xyz[mask].max(axis=0) for mask in of_chain])
            if (low.max(axis=0) - high.min(axis=0) > reach).any():
                continue
            together = of_chain[0] | of_chain[1]
            chain = molecule.chain[together]
            areas_of_two = areas_of_spheres(
                xyz[together], radii[together], self.probe_radius, chain, with_excluded=False
            )
            buried = areas_of_two.buried
            if buried.any():
                rows += [(a, b, buried[chain == a].sum()) for a, b in (names, names[::-1])]
        return pd.DataFrame(rows, columns=["chain", "other", "buried"])

    @property
    def _areas(self) -> dict[str, np.ndarray]:
        return {"accessible": self.accessible, "excluded": self.excluded, "buried": self.buried}

    def _sums(self, groups: np.ndarray) -> dict[str, np.ndarray]:
        """Return the sums of the areas over atoms of the same number, (A,) from 0."""
        return {name: np.bincount(groups, values) for name, values in self._areas.items()}

    def _known_molecule(self, table: str) -> Molecule:
        """Return the molecule; raise InputError for spheres, which have no table of residues and chains."""
        if self.molecule is None:
            raise InputError(f"areas: spheres have no {table}; give a structure, or use the table of atoms.")
        return self.molecule


@public()
def areas(
    molecule: MoleculeLike | tuple[ArrayLike, ArrayLike],
    *,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    radii: RadiiTable = "dms",
) -> Areas:
    """Compute the solvent-accessible and solvent-excluded area of each atom, residue and chain, and what chains bury, exactly.

    All areas follow from the positions of the rolled probe by formulas, without dots. They count the walls of cavities in which a
    probe fits.

    Parameters
    ----------
    molecule : path, Molecule, atoms of another library, or pair (xyz, radii)
        As in `surface`.
    frame : int
        Position of the frame, from 0 (default 0).
    probe_radius : float
        Radius of the probe, Å (default 1.4).
    radii : {'dms', 'bondi'}
        Table of atomic radii (default 'dms', with which `excluded` is the area of the dots of `surface`).

    Returns
    -------
    Areas
        `accessible`, `excluded` and `buried` (A,) in Å^2; the tables `atoms`, `residues` and `chains` with their sums, of which
        that of residues has the accessible area as a share of the largest possible one (`relative`); and the table `pairs`, with
        the area of each chain that each other chain buries.

    Raises
    ------
    InputError
        The molecule cannot be read or holds dots, atoms of two chains have the same position, or an argument is outside of its
        limits.

    Notes
    -----
    The accessible area is that of Lee and Richards, J. Mol. Biol. 55:379 (1971), and the excluded surface that of Connolly, J.
    Appl. Cryst. 16:548 (1983). Where the probe touches several atoms at once, the excluded surface is divided among them as the
    dots of `surface` are: a saddle halfway between its two atoms, and a concave triangle by nearest atom. The maxima of Tien et
    al., PLoS ONE 8:e80635 (2013), are for residues without hydrogens and depend on the radii, so that shares may exceed 1.

    Examples
    --------
    >>> import sparsurf
    >>> a = sparsurf.areas("data/tdp43/topology.pdb")
    >>> a
    Areas of 953 atoms: 5,806 Å^2 accessible, 4,558 Å^2 excluded
    >>> a.residues[["residue_name", "accessible", "relative"]].head(2).round(2).to_numpy().tolist()
    [['GLU', 193.3, 0.87], ['PHE', 47.28, 0.2]]

    One sphere and its probe:

    >>> sparsurf.areas(([[0, 0, 0]], [1.6])).accessible.round(3)
    array([113.097])
    """
    probe_radius = PROBE.check(probe_radius, "probe_radius")
    check_choice(radii, [*RADII], "radii")
    refuse_dots("areas", molecule)
    atoms, frame, atom_radii = as_spheres(molecule, frame, radii)
    xyz, of_molecule = atoms.xyz[frame].round(3), atoms if isinstance(atoms, Molecule) else None
    chain = np.zeros(len(atom_radii), int) if of_molecule is None else of_molecule.chain
    if of_molecule is not None:
        refuse_overlapping_chains(of_molecule, xyz)
    computed = areas_of_spheres(xyz, atom_radii, probe_radius, chain)
    return Areas(
        computed.accessible,
        computed.excluded,
        computed.buried,
        probe_radius,
        None if of_molecule is None else radii,
        of_molecule,
        frame,
    )


def maximal_areas(residue_name: np.ndarray) -> np.ndarray:
    """Return the largest accessible area that residues (n,) can have, Å^2; NaN where none is known."""
    return np.array(
        [MAX_ACCESSIBLE_AREA.get(standard_name(name), np.nan) for name in residue_name.tolist()], float
    )


def refuse_overlapping_chains(molecule: Molecule, xyz: np.ndarray) -> None:
    """Raise InputError if atoms of two chains have the same position: which chain buries which cannot be said."""
    if len(np.unique(molecule.chain)) == 1:
        return
    _, first, position = np.unique(xyz, axis=0, return_index=True, return_inverse=True)
    twin = first[position.ravel()]
    twice = np.flatnonzero(molecule.chain != molecule.chain[twin])
    if len(twice):
        labels = " and ".join(molecule.residue_label(atom) for atom in (twin[twice[0]], twice[0]))
        raise InputError(
            f"areas: {len(twice)} atoms lie at the position of an atom of another chain, the first ones in {labels}; choose "
            "chains that do not overlap."
        )
