"""Read the atoms of objects of other libraries, such as mdtraj, biotite and MDAnalysis: those of `WITH_ATOMS`.

Each is converted to the table of `atom_table`, and built like a file. The libraries need not be installed.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from sparsurf.errors import FILE, InputError, naming_file
from sparsurf.molecules.atom_table import ATOM_COLUMNS, AtomFile, AtomTable, atom_table, box_vectors
from sparsurf.molecules.build import molecule_of_frames, molecule_of_models
from sparsurf.molecules.mdtraj_process import atom_rows, lattice, table_of_rows
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.plausibility import refuse_impossible
from sparsurf.molecules.selection import SelectionKeys
from sparsurf.molecules.text_frames import ANGSTROM_PER_NM
from sparsurf.molecules.trajectory import TrajectoryFrames

if TYPE_CHECKING:
    import gemmi
    import mdtraj
    import parmed
    from Bio.PDB.Entity import Entity
    from biotite.structure import AtomArray, AtomArrayStack
    from MDAnalysis import AtomGroup, Universe
    from openmm.app import Modeller, PDBFile, PDBxFile
    from prody.atomic import Atomic
    from rdkit.Chem import Mol

WITH_ATOMS = "mdtraj, biotite, MDAnalysis, gemmi, Biopython, ProDy, OpenMM, ParmEd or RDKit"
# Columns of the table, and the attributes of atoms that hold them
BIOTITE = {
    "name": "atom_name", "residue_name": "res_name", "chain": "chain_id", "number": "res_id", "insertion": "ins_code",
    "element": "element", "hetero": "hetero", "altloc": "altloc_id", "occupancy": "occupancy", "b_factor": "b_factor",
    "segid": "segment_id",
}  # fmt: skip
MDANALYSIS = {
    "name": "names", "residue_name": "resnames", "chain": "chainIDs", "number": "resids", "insertion": "icodes",
    "element": "elements", "hetero": "record_types", "altloc": "altLocs", "occupancy": "occupancies",
    "b_factor": "tempfactors", "segid": "segids",
}  # fmt: skip
PRODY = {
    "name": "Names", "residue_name": "Resnames", "chain": "Chids", "number": "Resnums", "insertion": "Icodes",
    "element": "Elements", "altloc": "Altlocs", "occupancy": "Occupancies", "b_factor": "Betas", "segid": "Segnames",
}  # fmt: skip


@naming_file("the trajectory")
def from_mdtraj(trajectory: mdtraj.Trajectory, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert a trajectory of mdtraj; its nanometres become Å. Selection keys as in `read_molecule`."""
    xyz = _positions(trajectory.xyz) * ANGSTROM_PER_NM
    has_box = trajectory.unitcell_lengths is not None
    box = np.asarray(lattice(trajectory), dtype=float) * ANGSTROM_PER_NM if has_box else None
    atoms = table_of_rows(atom_rows(trajectory.topology))
    frames = TrajectoryFrames(xyz, np.asarray(trajectory.time, float), np.arange(len(xyz)), box)
    return _built(atoms, frames, "nm, as in mdtraj", len(xyz) > 1, keys)


@naming_file("the AtomArray")
def from_biotite(atoms: AtomArray | AtomArrayStack, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert an AtomArray or AtomArrayStack of biotite, whose models become frames; altlocs if it was read with altloc="all"."""
    frames = _frames(atoms.coord, atoms.box)
    return _built(_table(atoms, BIOTITE, frames.xyz.shape[1]), frames, "Å", False, keys)


@naming_file("the AtomGroup")
def from_mdanalysis(atoms: AtomGroup | Universe, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert an AtomGroup, or all atoms of a Universe, of MDAnalysis at the current frame of their trajectory."""
    group = atoms.atoms
    if not hasattr(group.universe, "trajectory"):
        raise InputError("the Universe has no coordinates: give it a trajectory.")
    step = group.universe.trajectory.ts
    names = MDANALYSIS | ({} if hasattr(group, "chainIDs") else {"chain": "segids"})
    table = _table(group, names, len(group))
    box = None if step.dimensions is None else np.asarray(step.triclinic_dimensions, float)[None]
    time = np.array([float(step.data.get("time", np.nan))])  # in ps; structures have none
    frames = TrajectoryFrames(_positions(group.positions), time, np.array([0]), box)
    moving = group.universe.trajectory.n_frames > 1
    return _built(table, frames, "Å", moving, keys)


@naming_file("the structure of gemmi")
def from_gemmi(structure: gemmi.Structure | gemmi.Model, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert a Structure of gemmi, whose models become frames, or a Model."""
    models: Any = structure if hasattr(structure, "spacegroup_hm") else [structure]
    rows = []
    for number, model in enumerate(models, 1):
        for chain in model:
            for unit, residue in enumerate(chain):
                label = f"{residue.seqid.num}{residue.seqid.icode.strip()}".removeprefix("None")
                of_residue = number, residue.het_flag == "H"
                for atom in residue:
                    names = atom.name, residue.name, chain.name, residue.segment, atom.element.name.upper()
                    place = atom.occ, *atom.pos.tolist(), atom.b_iso
                    rows.append((*of_residue, *names, atom.altloc.strip("\0"), label, *place, unit))
    cell = getattr(structure, "cell", None)
    box = box_vectors(cell.a, cell.b, cell.c, cell.alpha, cell.beta, cell.gamma) if cell else None
    return _built_of_rows(rows, box, keys)


@naming_file("the structure of Biopython")
def from_biopython(entity: Entity, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert a Structure of Biopython, whose models become frames, or a Model or Chain."""
    models: Any = entity if entity.level == "S" else [entity]
    rows = []
    for number, model in enumerate(models, 1):
        for chain in [model] if model.level == "C" else model:
            for residue in chain.get_unpacked_list():
                hetero, position, code = residue.id
                label = f"{position}{code.strip()}"
                names = residue.resname.strip(), chain.id.strip(), residue.segid.strip()
                for atom in residue.get_unpacked_list():
                    occupancy = 1.0 if atom.occupancy is None else atom.occupancy
                    element, altloc = (atom.element or "").upper(), atom.altloc.strip()
                    place = occupancy, *map(float, atom.coord), atom.bfactor
                    rows.append((number, hetero != " ", atom.name, *names, element, altloc, label, *place, 0))
    return _built_of_rows(rows, None, keys)


@naming_file("the atoms of ProDy")
def from_prody(atoms: Atomic, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert an AtomGroup of ProDy, or a part of one, whose coordinate sets become frames."""
    held = {column: getattr(atoms, f"get{name}")() for column, name in PRODY.items()}
    held = {column: values for column, values in held.items() if values is not None}
    source = SimpleNamespace(**held, hetero=np.asarray(atoms.getFlags("hetatm"), bool))
    table = _table(source, {column: column for column in (*PRODY, "hetero")}, atoms.numAtoms())
    return _built(table, _frames(atoms.getCoordsets()), "Å", False, keys)


@naming_file("the atoms of OpenMM")
def from_openmm(held: PDBFile | PDBxFile | Modeller, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert what holds a topology and positions of OpenMM, whose models become frames; nanometres become Å."""
    from openmm.unit import angstrom  # whoever holds such an object has it

    several = held.getNumFrames() if hasattr(held, "getNumFrames") else 0
    positions = [held.getPositions(frame=k) for k in range(several)] or [held.positions]
    xyz = [[tuple(place) for place in frame.value_in_unit(angstrom)] for frame in positions]
    rows = []
    for residue in held.topology.residues():
        of_residue = residue.name, residue.chain.id, residue.id, residue.insertionCode
        for atom in residue.atoms():
            rows.append((atom.name, *of_residue, atom.element.symbol if atom.element else ""))
    return _built(_table_of_rows(rows), _frames(xyz), "nm, as in OpenMM", False, keys)


@naming_file("the structure of ParmEd")
def from_parmed(structure: parmed.Structure, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert a Structure of ParmEd, whose sets of coordinates become frames."""
    rows = [
        (
            atom.name, atom.residue.name, atom.residue.chain, atom.residue.number, atom.residue.insertion_code,
            atom.element_name if atom.atomic_number > 0 else "", atom.residue.segid, atom.altloc, atom.occupancy, atom.bfactor,
        )
        for atom in structure.atoms
    ]  # fmt: skip
    if structure.get_coordinates() is None:
        raise InputError(f"{FILE} has no coordinates: give it those of its atoms.")
    box = None if structure.box is None else box_vectors(*structure.box)
    return _built(_table_of_rows(rows), _frames(structure.get_coordinates(), box), "Å", False, keys)


@naming_file("the Mol of RDKit")
def from_rdkit(mol: Mol, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert a Mol of RDKit, whose conformers become frames; all its atoms are taken if it names no residues."""
    if not mol.GetNumConformers():
        raise InputError(
            f"{FILE} has no conformer: embed one, or read the molecule from a file with coordinates."
        )
    atoms = [(atom.GetSymbol(), atom.GetPDBResidueInfo()) for atom in mol.GetAtoms()]
    n_without = sum(residue is None for _, residue in atoms)
    if n_without == len(atoms):  # a small molecule
        keys = {"selection": "all", **keys}
        rows: list[Any] = [
            (f"{symbol}{k}", "UNL", "", 1, "", symbol) for k, (symbol, _) in enumerate(atoms, 1)
        ]
    elif n_without:
        raise InputError(
            f"{FILE} has {n_without} atoms without a residue: add hydrogens by AddHs(mol, addCoords=True, addResidueInfo=True)."
        )
    else:
        rows = [
            (
                residue.GetName(), residue.GetResidueName(), residue.GetChainId(), residue.GetResidueNumber(),
                residue.GetInsertionCode(), symbol, "", residue.GetAltLoc(), residue.GetOccupancy(), residue.GetTempFactor(),
                residue.GetIsHeteroAtom(),
            )
            for symbol, residue in atoms
        ]  # fmt: skip
    xyz = [conformer.GetPositions() for conformer in mol.GetConformers()]
    return _built(_table_of_rows(rows), _frames(xyz), "Å", False, keys)


def _frames(xyz: Any, box: np.ndarray | None = None) -> TrajectoryFrames:
    """Return coordinates (F, A, 3), Å, as frames without times, in the same box."""
    xyz = _positions(xyz)
    boxes = None if box is None else np.broadcast_to(np.asarray(box, float), (len(xyz), 3, 3))
    return TrajectoryFrames(xyz, np.full(len(xyz), np.nan), np.arange(len(xyz)), boxes)


def _table_of_rows(rows: list[Any]) -> AtomTable:
    """Return the table of rows, one for each atom, in the order of `columns`; the last ones may be missing."""
    columns = (
        "name", "residue_name", "chain", "number", "insertion", "element", "segid", "altloc", "occupancy", "b_factor", "hetero",
    )  # fmt: skip
    held = dict(zip(columns, zip(*rows, strict=True), strict=False))
    return _table(SimpleNamespace(**held), {column: column for column in columns}, len(rows))


def _positions(xyz: Any) -> np.ndarray:
    """Return coordinates (F, A, 3); raise InputError if there are none, or masked ones."""
    if np.ma.is_masked(xyz):
        raise InputError(f"{FILE} has masked coordinates: leave these atoms out.")
    xyz = np.asarray(xyz, dtype=float)
    xyz = xyz[None] if xyz.ndim == 2 else xyz
    if not xyz.shape[0] or not xyz.shape[1]:
        raise InputError(f"{FILE} has {xyz.shape[0]} frames of {xyz.shape[1]} atoms: give one with both.")
    return xyz


def _table(source: Any, names: dict[str, str], n_atoms: int) -> AtomTable:
    """Return the table of `atom_table` from arrays (A,) of an object by their names there, some of which it may lack."""
    columns = {
        column: np.asarray(
            getattr(source, name) if hasattr(source, name) else [ATOM_COLUMNS.get(column, "")] * n_atoms
        )
        for column, name in names.items()
    }
    numbers, codes = (columns.pop(name).tolist() for name in ("number", "insertion"))
    residue = [f"{number}{str(code).strip()}" for number, code in zip(numbers, codes, strict=True)]
    texts = ("name", "residue_name", "chain", "segid", "altloc", "element")
    columns |= {name: np.char.strip(columns[name].astype(str)) for name in texts}
    columns["altloc"] = np.where(columns["altloc"] == ".", "", columns["altloc"])
    for name in ("chain", "segid"):
        columns[name] = np.where(columns[name] == "SYSTEM", "", columns[name])  # MDAnalysis' name for none
    if columns["hetero"].dtype != bool:
        columns["hetero"] = columns["hetero"].astype(str) == "HETATM"
    return atom_table(**columns | {"element": np.char.upper(columns["element"]), "residue": residue})


def _built(
    table: AtomTable, frames: TrajectoryFrames, unit: str, join: bool, keys: SelectionKeys
) -> Molecule:
    """Return the selected atoms of a table with frames; `unit` is that of the lengths in the user's object."""
    molecule = molecule_of_frames(table, frames, keys, join)
    refuse_impossible(molecule, unit=unit)
    return molecule


def _built_of_rows(rows: list[tuple[Any, ...]], box: np.ndarray | None, keys: SelectionKeys) -> Molecule:
    """Return the selected atoms of rows, one for each atom, in the order of `columns`."""
    if not rows:
        raise InputError(f"{FILE} has no atoms: give one with atoms.")
    columns = (
        "model", "hetero", "name", "residue_name", "chain", "segid", "element", "altloc", "residue", "occupancy",
        "x", "y", "z", "b_factor", "unit",
    )  # fmt: skip
    atoms = atom_table(**dict(zip(columns, zip(*rows, strict=True), strict=True)))
    molecule = molecule_of_models(AtomFile(atoms, box), keys)
    refuse_impossible(molecule, unit="Å")
    return molecule
