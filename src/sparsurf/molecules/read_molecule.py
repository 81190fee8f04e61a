"""Read a molecule from any structure file or trajectory.

Input that would give a wrong surface is refused in one sentence. Atoms that are left out are logged.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Sequence
from dataclasses import replace
from numbers import Integral
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from sparsurf.errors import InputError
from sparsurf.files import no_warnings, pluralise, read_text
from sparsurf.molecules.atom_table import (
    AtomFile,
    choose_altlocs,
    missing_residues,
    number_residues,
    refuse_control_characters,
    report_duplicates,
    report_occupancies,
)
from sparsurf.molecules.formats import (
    MMCIF,
    PDB,
    SELF_CONTAINED,
    STRUCTURES,
    TOPOLOGIES,
    TRAJECTORIES,
    suffix,
)
from sparsurf.molecules.geometry import refuse_impossible, refuse_invalid_coordinates
from sparsurf.molecules.mdtraj_process import atom_rows
from sparsurf.molecules.mmcif import read_mmcif
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.pdb import read_pdb
from sparsurf.molecules.plddt import doubtful_residues
from sparsurf.molecules.residues import count_heavy_atoms, element_of, residue_kinds
from sparsurf.molecules.selection import SelectionKeys, select_atoms
from sparsurf.molecules.trajectory import (
    ANGSTROM_PER_NM,
    read_first_frame,
    read_frames,
    read_frames_at,
    read_topology,
    table_of_rows,
)
from sparsurf.molecules.unwrapping import make_whole

if TYPE_CHECKING:
    import gemmi
    import mdtraj
    import pandas as pd
    from Bio.PDB.Entity import Entity
    from biotite.structure import AtomArray, AtomArrayStack
    from MDAnalysis import AtomGroup, Universe

log = logging.getLogger("sparsurf")

READERS = dict.fromkeys(PDB, read_pdb) | dict.fromkeys(MMCIF, read_mmcif)
# A protein whose residues hold less than this share of their heavy atoms is a model of its backbone. C-alpha atoms
# alone are 13 %, backbone with C-beta 62 %. The sparsest crystal structure of the reference data has 97 %.
MIN_HEAVY_ATOM_SHARE = 0.7
IDENTITY = ("name", "residue_name", "chain", "residue")  # arrays that identify an atom
MIN_RESIDUES_TO_JUDGE = 3  # a fragment with fewer residues is accepted as it is


def read_molecule(
    path: str | os.PathLike[str],
    trajectory: str | os.PathLike[str] | None = None,
    *,
    selection: str | None = None,
    chains: str | Sequence[str] | None = None,
    residues: str | Sequence[str] | None = None,
    model: int | None = None,
    altloc: str = "first",
    hydrogens: str = "keep",
    ligands: bool | str | Sequence[str] = False,
    stride: int = 1,
    times: Sequence[float] | None = None,
    whole: bool = True,
    plddt: float | None = None,
) -> Molecule:
    """Read a molecule: a structure, an ensemble of models, or a topology with its trajectory.

    Parameters
    ----------
    path : str or Path
        PDB or mmCIF file, also gzipped (.pdb .ent .cif .mmcif), GRO or HDF5; with a trajectory also PSF or AMBER.
    trajectory : any trajectory that mdtraj reads. Without it, the models of the structure are the frames.
    selection : mdtraj expression, or 'all'; without it the protein
    chains : list of str, or 'A,B'
    residues : ranges such as 'A:10-52A,60', both ends included
    hydrogens : 'keep' or 'remove'
    ligands : list of residue names to include, or True for all but waters and ions
    model : int, read only the model of this number
    altloc : 'first', 'highest' (occupancy) or a letter
    stride : int, keep every stride-th frame
    times : floats, ps
        Keep only the first frame of a trajectory and those at these times; the stride is ignored.
    whole : bool, make molecules whole that the periodic box cuts
    plddt : float, 0 to 100
        Leave out the residues of a predicted model whose pLDDT is below; other files stay as they are.

    Returns
    -------
    Molecule

    Raises
    ------
    InputError
        One sentence on what is wrong with the file or the keys.

    Examples
    --------
    >>> import sparsurf
    >>> molecule = sparsurf.read_molecule("data/tdp43/topology.pdb", residues="209-222", hydrogens="remove")
    >>> molecule.n_atoms, molecule.n_residues, molecule.xyz.shape
    (119, 14, (1, 119, 3))
    """
    if not (isinstance(stride, int) and stride > 0):
        raise InputError(f"stride: {stride} is not a whole number above 0: give 1 for every frame.")
    if not isinstance(whole, bool | np.bool_):
        raise InputError(f"whole is {whole!r}; it must be True or False.")
    if times is not None and trajectory is None and suffix(path) not in SELF_CONTAINED:
        raise InputError(
            "times: there is no trajectory to take frames from; give one, or leave out the times."
        )
    if plddt is not None and trajectory is not None:
        raise InputError("plddt: a trajectory has none; remove `plddt`, or choose the residues.")
    keys: SelectionKeys = {
        "selection": selection, "chains": chains, "residues": residues, "hydrogens": hydrogens, "ligands": ligands,
    }  # fmt: skip
    file, models = _read_structure(path, model, altloc)
    if trajectory is None and suffix(path) in SELF_CONTAINED:
        trajectory = path
    if trajectory is None and suffix(path) in TOPOLOGIES:
        raise InputError(f"{path} holds no coordinates: give the trajectory that belongs to it.")
    if trajectory is None:
        molecule = _from_models(models, file, stride, bool(whole), path, keys)
        if plddt is not None and file.has_plddt is not None:
            molecule = _without_doubtful(molecule, file.has_plddt, plddt, path)
        refuse_impossible(molecule, path, whole=bool(whole))
    else:
        atoms = next(iter(models.values()))
        molecule = _from_trajectory(
            atoms, path, trajectory, stride, times, bool(whole), keys, file.crosslinked
        )
        refuse_impossible(molecule, trajectory, path if trajectory != path else None, bool(whole))
    _report_missing(molecule, missing_residues(file.atoms, file.sequences), path)
    return molecule


def _read_structure(
    path: str | os.PathLike[str], model: int | None, altloc: str
) -> tuple[AtomFile, dict[int, pd.DataFrame]]:
    """Read a structure or topology file, and return it with the tables of its models, by position in the file."""
    extension = suffix(path)
    if extension in READERS:
        file = READERS[extension](read_text(path), path)
        refuse_control_characters(file.atoms, path)
        report_occupancies(file.atoms, path)
        atoms = choose_altlocs(file.atoms, altloc, path)
        report_duplicates(atoms, path)
        return file, _select_models(atoms, model, path)
    if extension in TOPOLOGIES + SELF_CONTAINED:
        if model is not None:
            raise InputError(f"{path} has frames and no models: leave out the model, and name the frame.")
        file = AtomFile(read_topology(path))
        refuse_control_characters(file.atoms, path)
        return file, {0: file.atoms}
    if extension in TRAJECTORIES:
        raise InputError(
            f"{path} is a trajectory: give it as the trajectory, and its topology as the structure."
        )
    known = ", ".join(STRUCTURES + TOPOLOGIES + SELF_CONTAINED)
    raise InputError(
        f"{path} is not a structure by its extension: give one of {known}, the first four also .gz."
    )


def from_mdtraj(trajectory: mdtraj.Trajectory, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert a trajectory of mdtraj; its nanometres become Å.

    Parameters
    ----------
    trajectory : mdtraj.Trajectory, of whole molecules
    keys : selection, chains, residues, hydrogens and ligands, as in `read_molecule`

    Returns
    -------
    Molecule

    Raises
    ------
    InputError
        Nothing selected, or coordinates that are not numbers.
    """
    if trajectory.n_atoms == 0 or trajectory.n_frames == 0:
        raise InputError(
            f"the trajectory has {trajectory.n_frames} frames of {trajectory.n_atoms} atoms: give one with both."
        )
    xyz = np.asarray(trajectory.xyz, dtype=float) * ANGSTROM_PER_NM
    atoms = table_of_rows(atom_rows(trajectory.topology))
    return _from_table(
        atoms, xyz, np.asarray(trajectory.time, float), "the trajectory", "nm, as in mdtraj", keys
    )


def from_biotite(atoms: AtomArray | AtomArrayStack, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert atoms of biotite; the models of a stack become frames.

    Parameters
    ----------
    atoms : biotite.structure.AtomArray or AtomArrayStack, Å
    keys : selection, chains, residues, hydrogens and ligands, as in `read_molecule`

    Returns
    -------
    Molecule

    Raises
    ------
    InputError
        Nothing selected, or coordinates that are not numbers.
    """
    xyz = np.asarray(atoms.coord, dtype=float)
    xyz = xyz[None] if xyz.ndim == 2 else xyz
    numbers = zip(atoms.res_id.tolist(), atoms.ins_code.tolist(), strict=True)
    table = _table_of_atoms(
        name=atoms.atom_name,
        residue_name=atoms.res_name,
        chain=atoms.chain_id,
        element=np.char.upper(np.asarray(atoms.element, dtype=str)),
        residue=[f"{number}{code.strip()}" for number, code in numbers],
        hetero=np.asarray(atoms.hetero, dtype=bool),
        b_factor=atoms.b_factor if "b_factor" in atoms.get_annotation_categories() else np.nan,
    )
    return _from_table(table, xyz, np.full(len(xyz), np.nan), "the AtomArray", "Å", keys)


def from_mdanalysis(atoms: AtomGroup | Universe, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert atoms of MDAnalysis at the current frame of their trajectory.

    Parameters
    ----------
    atoms : MDAnalysis.AtomGroup, or a Universe for all its atoms
    keys : selection, chains, residues, hydrogens and ligands, as in `read_molecule`

    Returns
    -------
    Molecule
        One frame.

    Raises
    ------
    InputError
        Nothing selected, or coordinates that are not numbers.
    """
    group = atoms.atoms

    def attribute(name: str, missing: Any = "") -> Any:
        """Return an attribute of all atoms, or a value for every atom if the topology lacks it."""
        return getattr(group, name) if hasattr(group, name) else np.full(len(group), missing)

    time = group.universe.trajectory.ts.data.get("time", np.nan)  # in ps; structures have none
    numbers = zip(group.resids.tolist(), np.asarray(attribute("icodes"), dtype=str).tolist(), strict=True)
    table = _table_of_atoms(
        name=attribute("names"),
        residue_name=attribute("resnames"),
        chain=attribute("chainIDs") if hasattr(group, "chainIDs") else attribute("segids"),
        element=np.char.upper(np.asarray(attribute("elements"), dtype=str)),
        residue=[f"{number}{code.strip()}" for number, code in numbers],
        hetero=np.asarray(attribute("record_types"), dtype=str) == "HETATM",
        b_factor=attribute("tempfactors", np.nan),
    )
    xyz = np.asarray(group.positions, dtype=float)[None]
    return _from_table(table, xyz, np.array([float(time)]), "the AtomGroup", "Å", keys)


def from_gemmi(structure: gemmi.Structure | gemmi.Model, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert a structure or model of gemmi; the models of a structure become frames.

    Parameters
    ----------
    structure : gemmi.Structure or gemmi.Model, Å
    keys : selection, chains, residues, hydrogens and ligands, as in `read_molecule`

    Returns
    -------
    Molecule
        With the first of alternate locations, as from a file.

    Raises
    ------
    InputError
        Nothing selected, or coordinates that are not numbers.
    """
    models: Any = structure if hasattr(structure, "spacegroup_hm") else [structure]
    rows = [
        (
            number, residue.het_flag == "H", atom.name, residue.name, chain.name, atom.element.name.upper(),
            atom.altloc.strip("\0"), f"{residue.seqid.num}{residue.seqid.icode.strip()}",
            atom.occ, *atom.pos.tolist(), atom.b_iso,
        )
        for number, model in enumerate(models, 1) for chain in model for residue in chain for atom in residue
    ]  # fmt: skip
    return _from_rows(rows, "the structure of gemmi", keys)


def from_biopython(entity: Entity, **keys: Unpack[SelectionKeys]) -> Molecule:
    """Convert a structure, model or chain of Biopython; the models of a structure become frames.

    Parameters
    ----------
    entity : Bio.PDB.Structure.Structure, Model or Chain, Å
    keys, returns, errors : as for `from_gemmi`
    """
    models: Any = entity if entity.level == "S" else [entity]
    rows = []
    for number, model in enumerate(models, 1):
        for chain in [model] if model.level == "C" else model:
            for residue in chain.get_unpacked_list():
                hetero, position, code = residue.id
                label = f"{position}{code.strip()}"
                rows += [
                    (
                        number, hetero != " ", atom.name, residue.resname.strip(), chain.id, (atom.element or "").upper(),
                        atom.altloc.strip(), label, atom.occupancy or 0.0, *atom.coord.tolist(), atom.bfactor,
                    )
                    for atom in residue.get_unpacked_list()
                ]  # fmt: skip
    return _from_rows(rows, "the structure of Biopython", keys)


def _from_rows(rows: list[tuple[Any, ...]], name: str, keys: SelectionKeys) -> Molecule:
    """Return the selected atoms of rows, one for each atom, in the order of `columns`."""
    import pandas as pd

    if not rows:
        raise InputError(f"{name} has no atoms: give one with atoms.")
    columns = [
        "model", "hetero", "name", "residue_name", "chain", "element", "altloc", "residue", "occupancy",
        "x", "y", "z", "b_factor",
    ]  # fmt: skip
    atoms = pd.DataFrame(rows, columns=columns).assign(terminated=False)
    atoms["chain"] = atoms["chain"].str.strip()
    file = AtomFile(choose_altlocs(atoms, "first", name))
    molecule = _from_models(_select_models(file.atoms, None, name), file, 1, False, name, keys)
    refuse_impossible(molecule, name, unit="Å")
    return molecule


def _table_of_atoms(**columns: Any) -> pd.DataFrame:
    """Return the table of `atom_table` from the atoms of another library; coordinates are nan."""
    import pandas as pd

    table = pd.DataFrame(columns | {"model": 1, "altloc": "", "terminated": False})
    table[["x", "y", "z"]], table["occupancy"] = np.nan, 1.0
    names = ["name", "residue_name", "chain", "element"]
    table[names] = table[names].astype(str)
    return table


def _from_table(
    atoms: pd.DataFrame, xyz: np.ndarray, time_ps: np.ndarray, name: str, unit: str, keys: SelectionKeys
) -> Molecule:
    """Return the selected atoms of a table with frames (F, A, 3), Å; `name` and `unit` are those of the user's object."""
    if not xyz.shape[0] or not xyz.shape[1]:
        raise InputError(f"{name} has {xyz.shape[0]} frames of {xyz.shape[1]} atoms: give one with both.")
    everything = _molecule(atoms.assign(chain=atoms["chain"].str.strip()), xyz[0])
    selected = np.flatnonzero(select_atoms(everything, name, **keys))
    number = np.arange(len(xyz))
    molecule = replace(everything.take(selected), xyz=xyz[:, selected], time_ps=time_ps, frame_number=number)
    refuse_invalid_coordinates(molecule.xyz, name)
    refuse_impossible(molecule, name, unit=unit)
    return molecule


def _select_models(
    atoms: pd.DataFrame, model: int | None, path: str | os.PathLike[str]
) -> dict[int, pd.DataFrame]:
    """Return the tables of all models, or of the requested one, by their position in the file."""
    tables = dict(enumerate(table.reset_index(drop=True) for _, table in atoms.groupby("model", sort=False)))
    if model is None:
        return tables
    numbers = [int(table.model[0]) for table in tables.values()]
    listed = ", ".join(map(str, numbers[:9])) + (", ..." if len(numbers) > 9 else "")
    if not isinstance(model, Integral) or isinstance(model, bool):
        raise InputError(f"model: {model!r} is not a whole number: {path} has {listed}.")
    if model not in numbers:
        raise InputError(f"{path} has no model {model}: it has {listed}.")
    return {numbers.index(model): tables[numbers.index(model)]}


def _from_models(
    models: dict[int, pd.DataFrame],
    file: AtomFile,
    stride: int,
    whole: bool,
    path: str | os.PathLike[str],
    keys: SelectionKeys,
) -> Molecule:
    """Return the selected atoms with the models as frames."""
    numbers = np.array(list(models))[::stride]
    molecules = [_molecule(models[number]) for number in numbers]
    selected = _select_complete(molecules[0], path, keys, file.crosslinked)
    # waters may differ between models; the selected atoms may not
    masks = [
        selected
        if _same_atoms(molecule, molecules[0])
        else select_atoms(molecule, path, report=False, **keys)
        for molecule in molecules
    ]
    frames = [molecule.take(mask) for molecule, mask in zip(molecules, masks, strict=True)]
    if not all(_same_atoms(frame, frames[0]) for frame in frames):
        counts = " ".join(str(frame.n_atoms) for frame in frames[:9])
        raise InputError(
            f"{path} has models of different atoms (selected atoms: {counts}): choose one by `model`."
        )
    xyz = np.concatenate([frame.xyz for frame in frames])
    refuse_invalid_coordinates(xyz, path)
    if whole and file.box is not None:  # crystals pass unchanged: nothing there is cut
        box = np.repeat(file.box[None], len(xyz), axis=0)
        xyz = make_whole(xyz, box, frames[0].residue_index, join=False)
    return replace(frames[0], xyz=xyz, time_ps=np.full(len(xyz), np.nan), frame_number=numbers)


def _without_doubtful(
    molecule: Molecule, has_plddt: bool, plddt: float, path: str | os.PathLike[str]
) -> Molecule:
    """Return a predicted model without the residues of a pLDDT below a bound; warn of their number."""
    doubtful = doubtful_residues(molecule.b_factor, molecule.residue_index, has_plddt, plddt, path)
    if doubtful.all():
        raise InputError(
            f"{path} has no residue with a pLDDT of {plddt:g} or more: lower the bound, or exclude it."
        )
    confident = molecule.take(~doubtful)
    n_masked = molecule.n_residues - confident.n_residues
    if n_masked:
        message = "%s: left out %d of %s, whose pLDDT is below %g"
        log.warning(message, path, n_masked, pluralise(molecule.n_residues, "residue"), plddt)
    return replace(confident, masked_residues=n_masked)


def _from_trajectory(
    atoms: pd.DataFrame,
    path: str | os.PathLike[str],
    trajectory: str | os.PathLike[str],
    stride: int,
    times: Sequence[float] | None,
    whole: bool,
    keys: SelectionKeys,
    crosslinked: frozenset[tuple[str, str]],
) -> Molecule:
    """Return the selected atoms of a topology with the frames of a trajectory."""
    first = _molecule(atoms, read_first_frame(trajectory, len(atoms), path))
    selected = np.flatnonzero(_select_complete(first, path, keys, crosslinked))
    if times is None:
        frames = read_frames(trajectory, len(atoms), selected, stride)
    else:
        frames = read_frames_at(trajectory, len(atoms), selected, times)
    molecule = first.take(selected)
    xyz = frames.xyz
    refuse_invalid_coordinates(xyz, trajectory)
    if whole and frames.box is not None:
        xyz = make_whole(xyz, frames.box, molecule.residue_index)
    return replace(molecule, xyz=xyz, time_ps=frames.time_ps, frame_number=frames.number)


def _molecule(atoms: pd.DataFrame, xyz: np.ndarray | None = None) -> Molecule:
    """Return one frame of every atom of a table, with its coordinates or the given ones."""
    xyz = atoms[["x", "y", "z"]].to_numpy(float) if xyz is None else xyz
    names = {key: np.array(atoms[key], dtype=str) for key in IDENTITY}
    residue_index = number_residues(atoms)
    kind = residue_kinds(names["residue_name"], residue_index, names["name"], atoms.hetero.to_numpy(), xyz)
    alone = np.bincount(residue_index)[residue_index] == 1
    polymer = np.isin(kind, ["protein", "nucleic"])
    columns = atoms.element, names["name"], names["residue_name"], polymer, alone
    element = np.array([element_of(*row) for row in zip(*columns, strict=True)])
    return Molecule(
        xyz[None],
        np.array([np.nan]),
        np.array([0]),
        element=element,
        residue_index=residue_index,
        kind=kind,
        b_factor=atoms.b_factor.to_numpy(float),
        masked_residues=None,
        **names,
    )


def _same_atoms(first: Molecule, second: Molecule) -> bool:
    """Return whether two molecules have the same atoms in the same order."""
    return all(np.array_equal(getattr(first, key), getattr(second, key)) for key in IDENTITY)


def _select_complete(
    molecule: Molecule,
    path: str | os.PathLike[str],
    keys: SelectionKeys,
    crosslinked: frozenset[tuple[str, str]],
) -> np.ndarray:
    """Select atoms (A,) by the keys; raise InputError if they are a backbone only, warn of incomplete residues."""
    selected = select_atoms(molecule, path, **keys)
    touched = molecule.take(np.isin(molecule.residue_index, molecule.residue_index[selected]))
    present, expected = count_heavy_atoms(touched.residue_name, touched.residue_index, touched.element)
    share = present.sum() / max(expected.sum(), 1)
    if (expected > 0).sum() >= MIN_RESIDUES_TO_JUDGE and share < MIN_HEAVY_ATOM_SHARE:
        raise InputError(
            f"{path} has {share:.0%} of the heavy atoms of its residues (C-alpha atoms or a backbone only): "
            "give a structure with all atoms."
        )
    first = np.unique(touched.residue_index, return_index=True)[1]
    labels = zip(touched.chain[first].tolist(), touched.residue[first].tolist(), strict=True)
    # one atom leaves when a crosslink forms
    n_left = np.array([label in crosslinked for label in labels], int)
    incomplete = first[present + n_left < expected]
    if len(incomplete):
        atom = incomplete[0]
        label = f"{touched.residue_name[atom]} {touched.chain[atom]} {touched.residue[atom]}"
        residues = pluralise(len(incomplete), "residue") + (" lacks" if len(incomplete) == 1 else " lack")
        message = (
            "%s: %s heavy atoms, the first is %s; the surface is dented there: rebuild the missing atoms"
        )
        log.warning(message, path, residues, label)
    return selected


def _report_missing(
    molecule: Molecule, missing: dict[str, tuple[int, int]], path: str | os.PathLike[str]
) -> None:
    """Warn of residues of the sequence without coordinates, which are usually disordered."""
    lacking = {chain: full - present for chain, (present, full) in missing.items() if chain in molecule.chain}
    if lacking:
        listed = ", ".join(f"{count} in chain {chain}" for chain, count in list(lacking.items())[:5])
        more = f" and {pluralise(len(lacking) - 5, 'more chain')}" if len(lacking) > 5 else ""
        residues = pluralise(sum(lacking.values()), "residue")
        log.warning("%s: no coordinates for %s of the sequence: %s%s", path, residues, listed, more)


def read_study_structure(path: str | os.PathLike[str]) -> Molecule:
    """Read a structure that a study wrote, without warnings: they were given for the file that it came from."""
    with no_warnings():
        return read_molecule(path, selection="all", whole=False)


def residue_labels(path: str | os.PathLike[str] | None) -> list[str]:
    """Return the residue of each atom of a study's structure, as 'LEU 212 A'; empty without a path."""
    if not path:
        return []
    molecule = read_study_structure(path)
    parts = zip(molecule.residue_name, molecule.residue, molecule.chain, strict=True)
    return [" ".join(part).strip() for part in parts]
