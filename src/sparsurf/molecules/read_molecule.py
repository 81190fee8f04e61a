"""Reading of a molecule from any structure file or trajectory.

What would give a wrong surface is refused in one sentence, what is left out is logged.
"""

import logging
from dataclasses import replace
from numbers import Integral

import numpy as np

from sparsurf import InputError
from sparsurf.files import no_warnings, pluralise, read_text
from sparsurf.molecules.atom_table import (
    AtomFile,
    choose_altlocs,
    missing_residues,
    number_residues,
    report_duplicates,
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
from sparsurf.molecules.geometry import refuse_impossible, refuse_no_numbers
from sparsurf.molecules.mdtraj_process import rows_of
from sparsurf.molecules.mmcif import read_mmcif
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.pdb import read_pdb
from sparsurf.molecules.residues import element_of, heavy_atoms_found, residue_kinds
from sparsurf.molecules.selection import chosen_atoms
from sparsurf.molecules.trajectory import (
    ANGSTROM,
    first_frame,
    read_frames,
    read_frames_at,
    read_topology,
    table_of,
)
from sparsurf.molecules.unwrapping import make_whole

log = logging.getLogger("sparsurf")

READERS = dict.fromkeys(PDB, read_pdb) | dict.fromkeys(MMCIF, read_mmcif)
# A protein whose residues hold less than this share of their heavy atoms is a model of its backbone: C-alpha
# atoms alone are 13 %, backbone with C-beta 62 %; the sparsest crystal structure of the reference data has 97 %.
LEAST_HEAVY_ATOMS = 0.7
FEWEST_RESIDUES = 3  # below that, a fragment is taken as it is


def read_molecule(
    path,
    trajectory=None,
    *,
    selection=None,
    chains=None,
    residues=None,
    model=None,
    altloc="first",
    hydrogens="keep",
    ligands=False,
    stride=1,
    times=None,
    whole=True,
):
    """Read a molecule: a structure, an ensemble of models, or a topology with its trajectory.

    Parameters
    ----------
    path : str or Path
        PDB or mmCIF file, also gzipped (.pdb .ent .cif .mmcif), GRO or HDF5; with a trajectory also PSF or AMBER.
    trajectory : any trajectory that mdtraj reads; without it, the models of the structure are the frames
    selection : mdtraj expression, or 'all'; without it the protein
    chains : list of str, or 'A,B'
    residues : ranges such as 'A:10-52A,60', both ends included
    hydrogens : 'keep' or 'remove'
    ligands : list of residue names to take along, or True for all but waters and ions
    model : int, read only the model of this number
    altloc : 'first', 'highest' (occupancy) or a letter
    stride : int, keep every stride-th frame
    times : floats, ps
        Of a trajectory keep the first frame and those at these times only, whatever the stride.
    whole : bool, put molecules together that the periodic box cuts

    Returns
    -------
    Molecule

    Raises
    ------
    InputError : one sentence on what is wrong with the file or the keys

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
    keys = {
        "selection": selection, "chains": chains, "residues": residues, "hydrogens": hydrogens, "ligands": ligands,
    }  # fmt: skip
    ending = suffix(path)
    if ending in READERS:
        file = READERS[ending](read_text(path), path)
        atoms = choose_altlocs(file.atoms, altloc, path)
        report_duplicates(atoms, path)
        models = _models(atoms, model, path)
    elif ending in TOPOLOGIES + SELF_CONTAINED:
        if model is not None:
            raise InputError(f"{path} has frames and no models: leave out the model, and name the frame.")
        file = AtomFile(read_topology(path))
        models = {0: file.atoms}
        trajectory = path if trajectory is None and ending in SELF_CONTAINED else trajectory
        if trajectory is None:
            raise InputError(f"{path} holds no coordinates: give the trajectory that belongs to it.")
    elif ending in TRAJECTORIES:
        raise InputError(
            f"{path} is a trajectory: give it as the trajectory, and its topology as the structure."
        )
    else:
        known = ", ".join(STRUCTURES + TOPOLOGIES + SELF_CONTAINED)
        raise InputError(
            f"{path} is no structure by its extension: give one of {known}, the first four also .gz."
        )
    if trajectory is None:
        molecule = _from_models(models, file, stride, whole, path, keys)
        refuse_impossible(molecule, path, whole=whole)
    else:
        molecule = _from_trajectory(
            next(iter(models.values())), path, trajectory, stride, times, whole, keys, file.linked
        )
        refuse_impossible(molecule, trajectory, path if trajectory != path else None, whole)
    _report_missing(molecule, missing_residues(file.atoms, file.promised), path)
    return molecule


def from_mdtraj(trajectory, *, selection=None, chains=None, residues=None, hydrogens="keep", ligands=False):
    """The molecule of a trajectory that mdtraj holds in memory; its nanometres become Å.

    Parameters
    ----------
    trajectory : mdtraj.Trajectory, of whole molecules
    selection : mdtraj expression, or 'all'; without it the protein
    chains : list of str, or 'A,B'
    residues : ranges such as 'A:10-52A,60', both ends included
    hydrogens : 'keep' or 'remove'
    ligands : list of residue names to take along, or True for all but waters and ions

    Returns
    -------
    Molecule

    Raises
    ------
    InputError : nothing selected, or coordinates that are no numbers
    """
    path = "the trajectory"
    if trajectory.n_atoms == 0 or trajectory.n_frames == 0:
        raise InputError(
            f"{path} has {trajectory.n_frames} frames of {trajectory.n_atoms} atoms: give one with both."
        )
    xyz = np.asarray(trajectory.xyz, dtype=float) * ANGSTROM
    whole = _molecule(table_of(rows_of(trajectory.topology)), xyz[0])
    chosen = np.flatnonzero(
        chosen_atoms(
            whole,
            path,
            selection=selection,
            chains=chains,
            residues=residues,
            hydrogens=hydrogens,
            ligands=ligands,
        )
    )
    number, time_ps = np.arange(len(xyz)), np.asarray(trajectory.time, dtype=float)
    molecule = replace(whole.take(chosen), xyz=xyz[:, chosen], time_ps=time_ps, frame_number=number)
    refuse_no_numbers(molecule.xyz, path)
    refuse_impossible(molecule, path, unit="nm, as mdtraj has them")
    return molecule


def _models(atoms, model, path):
    """Tables of the models wanted, by their position in the file."""
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


def _from_models(models, file, stride, whole, path, keys):
    """The chosen atoms with the models as frames."""
    numbers = np.array(list(models))[::stride]
    molecules = [_molecule(models[number]) for number in numbers]
    chosen = _chosen(molecules[0], path, keys, file.linked)
    # waters may differ between models; what is chosen may not
    alike = [_same_atoms(each, molecules[0]) for each in molecules]
    masks = [
        chosen if same else chosen_atoms(each, path, report=False, **keys)
        for each, same in zip(molecules, alike, strict=True)
    ]
    frames = [each.take(mask) for each, mask in zip(molecules, masks, strict=True)]
    if not all(_same_atoms(each, frames[0]) for each in frames):
        counts = " ".join(str(each.n_atoms) for each in frames[:9])
        raise InputError(
            f"{path} has models of different atoms (atoms chosen: {counts}): choose one by `model`."
        )
    xyz = np.concatenate([each.xyz for each in frames])
    refuse_no_numbers(xyz, path)
    if whole and file.box is not None:  # crystals pass unchanged: nothing there is cut
        box = np.repeat(file.box[None], len(xyz), axis=0)
        xyz = make_whole(xyz, box, frames[0].residue_index, join=False)
    return replace(frames[0], xyz=xyz, time_ps=np.full(len(xyz), np.nan), frame_number=numbers)


def _from_trajectory(atoms, path, trajectory, stride, times, whole, keys, linked):
    """The chosen atoms of a topology with the frames of a trajectory."""
    first = _molecule(atoms, first_frame(trajectory, len(atoms), path))
    chosen = np.flatnonzero(_chosen(first, path, keys, linked))
    if times is None:
        frames = read_frames(trajectory, len(atoms), chosen, stride)
    else:
        frames = read_frames_at(trajectory, len(atoms), chosen, times)
    molecule = first.take(chosen)
    xyz = frames.xyz
    refuse_no_numbers(xyz, trajectory)
    if whole and frames.box is not None:
        xyz = make_whole(xyz, frames.box, molecule.residue_index)
    return replace(molecule, xyz=xyz, time_ps=frames.time_ps, frame_number=frames.number)


def _molecule(atoms, xyz=None):
    """One frame of every atom of a table; its coordinates, unless others are given."""
    xyz = atoms[["x", "y", "z"]].to_numpy(float) if xyz is None else xyz
    names = {each: np.array(atoms[each], dtype=str) for each in ("name", "residue_name", "chain", "residue")}
    residue_index = number_residues(atoms)
    kind = residue_kinds(names["residue_name"], residue_index, names["name"], atoms.hetero.to_numpy(), xyz)
    alone = np.bincount(residue_index)[residue_index] == 1
    polymer = np.isin(kind, ["protein", "nucleic"])
    columns = atoms.element, names["name"], names["residue_name"], polymer, alone
    element = np.array([element_of(*each) for each in zip(*columns, strict=True)])
    return Molecule(
        xyz[None],
        np.array([np.nan]),
        np.array([0]),
        element=element,
        residue_index=residue_index,
        kind=kind,
        b_factor=atoms.b_factor.to_numpy(float),
        **names,
    )


def _same_atoms(first, second):
    names = ("name", "residue_name", "chain", "residue")
    return all(np.array_equal(getattr(first, each), getattr(second, each)) for each in names)


def _chosen(molecule, path, keys, linked=()):
    """(A,) bool: the atoms chosen by the keys, their residues being more than a backbone."""
    chosen = chosen_atoms(molecule, path, **keys)
    touched = molecule.take(np.isin(molecule.residue_index, molecule.residue_index[chosen]))
    found, expected = heavy_atoms_found(touched.residue_name, touched.residue_index, touched.element)
    share = found.sum() / max(expected.sum(), 1)
    if (expected > 0).sum() >= FEWEST_RESIDUES and share < LEAST_HEAVY_ATOMS:
        raise InputError(
            f"{path} has {share:.0%} of the heavy atoms of its residues (C-alpha atoms or a backbone only): "
            "give a structure with all atoms."
        )
    first = np.unique(touched.residue_index, return_index=True)[1]
    places = zip(touched.chain[first].tolist(), touched.residue[first].tolist(), strict=True)
    spared = np.array(
        [place in linked for place in places], int
    )  # the one atom that left when the link formed
    incomplete = first[found + spared < expected]
    if len(incomplete):
        atom = incomplete[0]
        label = f"{touched.residue_name[atom]} {touched.chain[atom]} {touched.residue[atom]}"
        lacking = pluralise(len(incomplete), "residue") + (" lacks" if len(incomplete) == 1 else " lack")
        log.warning("%s: %s heavy atoms, the first is %s; the surface has holes there", path, lacking, label)
    return chosen


def _report_missing(molecule, missing, path):
    """Warn of residues that the sequence has and the coordinates have not (disorder, as a rule)."""
    lacking = {chain: full - found for chain, (found, full) in missing.items() if chain in molecule.chain}
    if lacking:
        listed = ", ".join(f"{count} in chain {chain}" for chain, count in list(lacking.items())[:5])
        more = f" and {pluralise(len(lacking) - 5, 'more chain')}" if len(lacking) > 5 else ""
        missing = pluralise(sum(lacking.values()), "residue")
        log.warning("%s: no coordinates for %s of the sequence: %s%s", path, missing, listed, more)


def read_own(path):
    """The Molecule of a structure that a study wrote itself: what there is to warn of was said of the file it came from."""
    with no_warnings():
        return read_molecule(path, selection="all", whole=False)


def residue_names(path):
    """Name of the residue of each atom of a structure, as LEU 212 A, a list; empty without a path."""
    if not path:
        return []
    molecule = read_own(path)
    parts = zip(molecule.residue_name, molecule.residue, molecule.chain, strict=True)
    return [" ".join(part).strip() for part in parts]
