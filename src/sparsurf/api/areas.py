"""Accessible, excluded and buried areas by atom, residue, chain and group, and what touches what."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sparsurf.api.inputs import (
    MoleculeLike,
    as_spheres,
    molecule_of_groups,
    opened_source,
    refuse_dots,
)
from sparsurf.arguments import EACH_RESIDUE, TOUCHED_AREA, RadiiLike, public
from sparsurf.errors import InputError
from sparsurf.messages import no_warnings
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.overlaps import refuse_overlapping_partners, without_overlaps
from sparsurf.molecules.read_molecule import molecule_of_files
from sparsurf.molecules.residues import first_atoms, standard_name
from sparsurf.molecules.selection import POLYMERS, Groups, Partners, groups_of_atoms, partners_of_atoms
from sparsurf.molecules.source import Source
from sparsurf.surfaces.areas import areas_of_spheres, contacts_of_rolled
from sparsurf.surfaces.dot_placement import roll_checked
from sparsurf.surfaces.radii import PROBE_RADIUS, check_radii
from sparsurf.surfaces.radii import radii as radii_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    import pandas as pd
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")

# Å^2, the largest accessible area that a residue X can have in Gly-X-Gly: theoretical values of Tien et al., PLoS ONE 8:e80635
MAX_ACCESSIBLE_AREA = {
    "ALA": 129.0, "ARG": 274.0, "ASN": 195.0, "ASP": 193.0, "CYS": 167.0, "GLN": 225.0, "GLU": 223.0, "GLY": 104.0, "HIS": 224.0,
    "ILE": 197.0, "LEU": 201.0, "LYS": 236.0, "MET": 224.0, "PHE": 240.0, "PRO": 159.0, "SER": 155.0, "THR": 172.0, "TRP": 285.0,
    "TYR": 263.0, "VAL": 174.0,
}  # fmt: skip
MAIN_CHAIN = ("N", "CA", "C", "O", "OXT", "OT1", "OT2", "P", "OP1", "OP2", "OP3", "O1P", "O2P", "O3P")
POLAR_ELEMENTS = ("N", "O")
MAX_PAIRS_IN_TABLE = 2_000_000  # of atoms: for more a tree takes less time, its import included


@dataclass(frozen=True, eq=False)
class Areas:
    """Exact areas of the atoms of a molecule.

    Attributes
    ----------
    accessible : (A,) float64, Å^2, solvent-accessible area, where the centre of a probe that touches the atom can be
    excluded : (A,) float64, Å^2, area of the solvent-excluded surface, which the probe touches or bridges
    buried : (A,) float64, Å^2, accessible area of the atom where its partner is alone that the other partners take
    probe_radius : float, Å, of the probe
    table : table of radii, None for spheres
    molecule : Molecule, or None for spheres
    frame : int, position of its frame
    partners : the partner of each atom, its group or by default its chain or ligand; None for spheres
    has_groups : bool, whether groups were named
    with_ligands : returns the molecule with all ligands of its file, which `contacts` adds; None if it was said what is read
    """

    accessible: NDArray[np.float64]
    excluded: NDArray[np.float64]
    buried: NDArray[np.float64]
    probe_radius: float
    table: RadiiLike | None = None
    molecule: Molecule | None = None
    frame: int = 0
    partners: Partners | None = None
    has_groups: bool = False
    with_ligands: Callable[[], Molecule] | None = None

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
        return _frame(self.columns("atoms"))

    @cached_property
    def residues(self) -> pd.DataFrame:
        """Table of residues: chain, residue, residue_name, accessible, excluded, relative, buried, and parts of `accessible`.

        The relative area is the accessible one over the largest that the residue can have (Tien et al., PLoS ONE 8:e80635, 2013);
        NaN for residues that have no such maximum, such as nucleotides and ligands. The parts are those of `main_chain` and
        `side_chain` of polymers, neither of which counts ligands, and of `polar` atoms (N and O) and all others (`apolar`);
        hydrogens count as the atom that they are bonded to. `share_buried` is the share that other partners bury of the area
        without them.
        """
        return _frame(self.columns("residues"))

    @cached_property
    def chains(self) -> pd.DataFrame:
        """Table of chains of polymers, and of each ligand by itself: chain, and the areas of `residues`."""
        return _frame(self.columns("chains"))

    @cached_property
    def groups(self) -> pd.DataFrame:
        """Table of groups, by default those of `chains`: group, and the areas of `residues`."""
        return _frame(self.columns("groups"))

    @cached_property
    def contacts(self) -> pd.DataFrame:
        """Table of contacts: chain, residue, residue_name, partner, the area that it buries, Å^2, and their distance.

        The area is that of the residue's group and the partner where only these two are present, and the distance, Å, that of
        their nearest atoms. Pairs that bury nothing are left out. All ligands of a path are partners here, although all other
        areas are those without them; of a Molecule, those that it has.
        """
        return _frame(self.columns("contacts"))

    @cached_property
    def pairs(self) -> pd.DataFrame:
        """Table of pairs of partners: chain, or group, other, and the accessible area that `other` buries where both are alone.

        Each pair has two rows, one for each of the two; pairs that bury nothing are left out.
        """
        return _frame(self.columns("pairs"))

    def columns(self, table: str) -> dict[str, np.ndarray]:
        """Return the columns of the table of this name, such as 'residues', by their names: NumPy arrays of one length."""
        columns: dict[str, np.ndarray] = getattr(self, f"_columns_of_{table}")()
        return columns

    def _columns_of_atoms(self) -> dict[str, np.ndarray]:
        numbers = np.arange(len(self))
        if self.molecule is None:
            return {"atom": numbers, "accessible": self.accessible, "excluded": self.excluded}
        return self.molecule.label_columns(numbers) | self._areas

    def _columns_of_residues(self) -> dict[str, np.ndarray]:
        molecule, _ = self._known("residues")
        labels, sums = molecule.residue_columns(), self._sums(molecule.residue_index)
        relative = sums["accessible"] / maximal_areas(labels["residue_name"])
        first = {name: sums.pop(name) for name in ("accessible", "excluded")}
        with np.errstate(invalid="ignore"):
            share = sums["buried"] / (first["accessible"] + sums["buried"])
        return labels | first | {"relative": relative} | sums | {"share_buried": share}

    def _columns_of_chains(self) -> dict[str, np.ndarray]:
        return self._sums_of("chain", partners_of_atoms(self._known("chains")[0]))

    def _columns_of_groups(self) -> dict[str, np.ndarray]:
        return self._sums_of("group", self._known("groups")[1])

    def _columns_of_contacts(self) -> dict[str, np.ndarray]:
        molecule, partners = self._known("contacts")
        if self.with_ligands is not None:
            with no_warnings():  # of what the first reading told
                whole = self.with_ligands()
            molecule = without_overlaps(whole, self.frame)
            partners = partners_of_atoms(molecule)
        return columns_of_contacts(molecule, self.frame, partners, *self._contacts(molecule, partners))

    def _columns_of_pairs(self) -> dict[str, np.ndarray]:
        molecule, partners = self._known("pairs")
        atom, other, buried = self._contacts(molecule, partners)
        names, n = np.array(partners.names), len(partners.names)
        pair = partners.number[atom] * n + other
        sums = np.bincount(pair, buried, n * n)
        listed = sorted(np.flatnonzero(sums).tolist(), key=lambda k: (*sorted(divmod(k, n)), k))
        first, second = np.divmod(np.array(listed, int), n)
        column = "group" if self.has_groups else "chain"
        return {column: names[first], "other": names[second], "buried": sums[listed]}

    def _contacts(self, molecule: Molecule, partners: Partners) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return atoms, the partners that bury some of their area, and that area."""
        xyz, radii = molecule.xyz[self.frame].round(3), radii_of(molecule, self.table or "dms")
        rolled = roll_checked(xyz, radii, self.probe_radius, in_order=True)
        return contacts_of_rolled(rolled, partners.number)

    @property
    def _areas(self) -> dict[str, np.ndarray]:
        return {"accessible": self.accessible, "excluded": self.excluded, "buried": self.buried}

    def _sums(self, groups: np.ndarray) -> dict[str, np.ndarray]:
        """Return the sums of the areas, and of parts of the accessible one, over atoms of the same number, (A,) from 0."""
        parts = parts_of_residues(self._known("sums")[0], self.frame)
        parts = {name: mask * self.accessible for name, mask in parts.items()}
        return {name: np.bincount(groups, values) for name, values in (self._areas | parts).items()}

    def _sums_of(self, name: str, partners: Partners) -> dict[str, np.ndarray]:
        """Return the names of partners, and the sums of the areas over the atoms of each."""
        return {name: np.array(partners.names)} | self._sums(partners.number)

    def _known(self, table: str) -> tuple[Molecule, Partners]:
        """Return the molecule and its partners; raise InputError for spheres, which have no table of residues and chains."""
        if self.molecule is None or self.partners is None:
            raise InputError(f"areas: spheres have no {table}; give a structure, or use the table of atoms.")
        return self.molecule, self.partners


@public()
def areas(
    molecule: MoleculeLike | tuple[ArrayLike, ArrayLike],
    *,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    radii: RadiiLike = "dms",
    groups: Groups | None = None,
) -> Areas:
    """Compute the solvent-accessible and solvent-excluded area of atoms, residues and chains, and what these bury, exactly.

    Parameters
    ----------
    molecule : path, Molecule, atoms of another library, or pair (xyz, radii)
        As in `surface`.
    frame, probe_radius, radii : as in `surface`
        With the same defaults, for which `excluded` is the area of the dots of `surface`.
    groups : str or sequence, optional
        Partners that bury each other, as 'H,L+G' or ["H,L", "G"]. A group lists chains, ranges of residues such as 'A:10-52' and
        names of ligands; an atom belongs to the group that names it most closely: by its ligand, else by its range, else by its
        chain, whose letter ligands may bear. Atoms of no group are absent. By default, each chain of polymers and each ligand
        that is read is a partner by itself, and all waters together are one. 'residues' makes each residue a partner.

    Returns
    -------
    Areas
        `accessible`, `excluded` and `buried` (A,) in Å^2; the tables `atoms`, `residues`, `chains` and `groups` with their sums.
        That of residues has the accessible area as a share of the largest possible one (`relative`), and all but that of atoms
        have the accessible area of main chains, side chains, polar and apolar atoms. The table `pairs` has the area of each
        partner that each other one buries, and the table `contacts` that of each residue, with its
        distance. `contacts` of a path has rows of all ligands of the file; all other areas are those without them.

    Raises
    ------
    InputError
        The molecule cannot be read or holds dots, atoms of two partners coincide, or groups or another argument do not fit.

    Notes
    -----
    Formulas of the rolled probe, without dots, yield the areas (Lee and Richards, J. Mol. Biol. 55:379, 1971; Connolly, J. Appl.
    Cryst. 16:548, 1983), also of cavities in which it fits. Where the probe touches several atoms, the excluded surface is
    divided as the dots of `surface` are: a saddle halfway between its two atoms, a concave triangle by nearest atom. The maxima
    of Tien et al., PLoS ONE 8:e80635 (2013), are for residues without hydrogens and depend on the radii, so shares may exceed 1.

    Examples
    --------
    >>> import sparsurf
    >>> areas = sparsurf.areas("data/tdp43/topology.pdb")
    >>> areas.residues[["residue_name", "accessible", "relative"]].head(2).round(2).to_numpy().tolist()
    [['GLU', 193.3, 0.87], ['PHE', 47.28, 0.2]]
    """
    radii = check_radii(radii)
    refuse_dots("areas", molecule)
    by_residue = isinstance(groups, str) and groups == EACH_RESIDUE
    if groups is not None and not by_residue:
        molecule = molecule_of_groups(molecule, groups)
    atoms, xyz, atom_radii = as_spheres(molecule, frame, radii)
    if atoms is None:
        if by_residue:
            raise InputError("areas: spheres have no residues; leave groups out.")
        computed = areas_of_spheres(xyz, atom_radii, probe_radius, np.zeros(len(atom_radii), int))
        return Areas(computed.accessible, computed.excluded, computed.buried, probe_radius)
    partners = (
        groups_of_atoms(atoms, groups) if groups and not by_residue else partners_of_atoms(atoms, by_residue)
    )
    refuse_overlapping_partners(atoms, partners, xyz)
    computed = areas_of_spheres(xyz, atom_radii, probe_radius, partners.number)
    source = opened_source(molecule)
    is_default = groups is None and isinstance(source, Source)
    return Areas(
        computed.accessible, computed.excluded, computed.buried, probe_radius, radii, atoms, frame, partners,
        groups is not None, partial(molecule_of_files, source, None, {"ligands": True}) if is_default else None,
    )  # fmt: skip


def parts_of_residues(molecule: Molecule, frame: int) -> dict[str, np.ndarray]:
    """Return masks (A,) of atoms of main chains and side chains, polar and apolar; hydrogens are as what they bind to."""
    bound = np.arange(molecule.n_atoms)
    if not molecule.heavy.all():
        heavy = np.flatnonzero(molecule.heavy)
        xyz = molecule.xyz[frame]
        bound[~molecule.heavy] = heavy[nearest(xyz[heavy], xyz[~molecule.heavy])]
    name = molecule.name[bound].astype(str)
    of_sugar = (molecule.kind == "nucleic") & (np.char.endswith(name, "'") | np.char.endswith(name, "*"))
    polymer = np.isin(molecule.kind, POLYMERS)
    main_chain = polymer & (np.isin(name, MAIN_CHAIN) | of_sugar)
    polar = np.isin(molecule.element[bound], POLAR_ELEMENTS)
    return {"main_chain": main_chain, "side_chain": polymer & ~main_chain, "polar": polar, "apolar": ~polar}


def nearest(points: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return which of the points (N, 3) is nearest to each place (M, 3), (M,); few points need no scipy, which loads slowly."""
    if len(points) * len(places) > MAX_PAIRS_IN_TABLE:
        from scipy.spatial import cKDTree

        return np.asarray(cKDTree(points).query(places)[1])
    squared = sum((places[:, None, k] - points[:, k]) ** 2 for k in range(3))
    return np.asarray(squared).argmin(axis=1)


def _frame(columns: dict[str, np.ndarray]) -> pd.DataFrame:
    """Return columns as a DataFrame."""
    import pandas as pd  # here: it takes long to load

    return pd.DataFrame(columns)


def columns_of_contacts(
    molecule: Molecule,
    frame: int,
    partners: Partners,
    atom: np.ndarray,
    partner: np.ndarray,
    buried: np.ndarray,
) -> dict[str, np.ndarray]:
    """Return the columns of contacts of atoms (n,) with partners (n,), summed by residue, with the least distance, Å."""
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    n, xyz = len(partners.names), molecule.xyz[frame]
    sums = np.bincount(molecule.residue_index[atom] * n + partner, buried)
    listed = np.flatnonzero(sums)
    residue, other = np.divmod(listed, n)
    trees = {k: cKDTree(xyz[partners.number == k]) for k in np.unique(other).tolist()}
    atoms = np.split(xyz, first_atoms(molecule.residue_index)[1:])
    distance = [
        np.min(trees[k].query(atoms[row])[0]) for row, k in zip(residue.tolist(), other.tolist(), strict=True)
    ]
    labels = {name: column[residue] for name, column in molecule.residue_columns().items()}
    names = np.array(partners.names)[other]
    return labels | {"partner": names, "buried": sums[listed], "distance": np.array(distance, float)}


def contacts_over_frames(
    molecule: Molecule, partners: Partners, contacts: Iterable[np.ndarray], n_frames: int
) -> pd.DataFrame:
    """Return the table of contacts of some frames, numbered by the residue, from their rows of `sums_of_contacts`."""
    names = np.array(partners.names)
    keys, sums = np.zeros(0, int), np.zeros((3, 0))  # number of frames, sum and highest of the buried area
    for part in contacts:
        residue, partner = part[:, :2].astype(int).T
        buried, n_before = part[:, 2], len(keys)
        keys, row = np.unique(np.concatenate([keys, residue * len(names) + partner]), return_inverse=True)
        new = np.zeros((3, len(keys)))
        new[:, row[:n_before]] = sums
        np.add.at(new[0], row[n_before:], buried >= TOUCHED_AREA)
        np.add.at(new[1], row[n_before:], buried)
        np.maximum.at(new[2], row[n_before:], buried)
        sums = new
    occupancy, mean = sums[:2] / n_frames
    table = molecule.residues.iloc[keys // len(names)]
    return table.assign(partner=names[keys % len(names)], occupancy=occupancy, mean=mean, highest=sums[2])


def sums_of_contacts(residue: np.ndarray, partner: np.ndarray, buried: np.ndarray) -> np.ndarray:
    """Return residue, partner and the area that the partner buries of it, (m, 3), from the rows of atoms."""
    pairs, row = np.unique(np.column_stack([residue, partner]), axis=0, return_inverse=True)
    return np.column_stack([pairs, np.bincount(row.ravel(), buried, len(pairs))])


def maximal_areas(residue_name: np.ndarray) -> np.ndarray:
    """Return the largest accessible area that residues (n,) can have, Å^2; NaN where none is known."""
    return np.array(
        [MAX_ACCESSIBLE_AREA.get(standard_name(name), np.nan) for name in residue_name.tolist()], float
    )
