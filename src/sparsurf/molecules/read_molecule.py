"""Read a molecule from any structure file or trajectory.

Input that would give a wrong surface is refused in one sentence. Atoms that are left out are logged.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from sparsurf.arguments import Hydrogens, check_flag, check_plddt, frames_between, public
from sparsurf.errors import FILE, InputError, argument, naming_file
from sparsurf.files import StrPath, pluralise, shorten
from sparsurf.molecules.atom_table import AtomFile
from sparsurf.molecules.build import molecule_of_models, molecule_of_trajectory
from sparsurf.molecules.formats import MOLECULE_FORMATS
from sparsurf.molecules.mdtraj_process import load_atoms, table_of_rows
from sparsurf.molecules.mmcif import read_mmcif
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.parm7 import read_parm7
from sparsurf.molecules.pdb import read_pdb
from sparsurf.molecules.plausibility import refuse_impossible
from sparsurf.molecules.plddt import PREDICTED, doubtful_residues
from sparsurf.molecules.psf import read_psf
from sparsurf.molecules.selection import POLYMERS, Groups, SelectionKeys
from sparsurf.molecules.source import Source, open_source, what_is_no_structure
from sparsurf.molecules.text_frames import read_card, read_gro
from sparsurf.molecules.trajectory import EVERY_FRAME

log = logging.getLogger("sparsurf")

ASSEMBLY_OF_MODELS = "assembly: it takes all models of a structure; leave out the trajectory and the model."
# The reader of each format that names its atoms
MOLECULE_READERS: dict[str, Callable[[Source], AtomFile]] = {
    "pdb": lambda source: read_pdb(source.text()),
    "mmcif": lambda source: read_mmcif(source.text()),
    "gro": read_gro,
    "card": read_card,
    "psf": read_psf,
    "parm7": read_parm7,
    "hdf5": lambda source: AtomFile(table_of_rows(load_atoms(source))),
}


@public()
def read_molecule(
    path: StrPath | Source,
    trajectory: StrPath | Source | None = None,
    *,
    selection: str | None = None,
    chains: str | Sequence[str] | None = None,
    residues: str | Sequence[str] | None = None,
    model: int | None = None,
    altloc: str = "first",
    hydrogens: Hydrogens = "keep",
    ligands: bool | str | Sequence[str] = False,
    stride: int = 1,
    start: int = 0,
    stop: int | None = None,
    times: Sequence[float] | None = None,
    whole: bool = True,
    plddt: float | None = None,
    assembly: bool | str = False,
    groups: Groups | None = None,
) -> Molecule:
    """Read a molecule: a structure, an ensemble of models, or a topology with its trajectory.

    Parameters
    ----------
    path : str or Path
        PDB, mmCIF, GRO or CHARMM CARD file, each also compressed, or HDF5 of mdtraj; with a trajectory also a PSF or AMBER parm7
        file. The content determines the format. Names and labels are those of the file.
    trajectory : str or Path, optional
        XTC, TRR, DCD, NetCDF, HDF5, AMBER mdcrd or restart, XYZ, LAMMPS dump or data, or coordinates in any format of a
        structure. Without it, the models of the structure are the frames.
    selection : str, optional
        Atoms as an expression of mdtraj, or 'all' for every atom. By default the protein is read.
    chains, residues : str or list of str, optional
        Identifiers of chains, such as 'A,B', and ranges of residues, such as 'A:10-52A,60', both ends included (default all).
    model : int, optional
        Number of the one model to read (default all models).
    altloc : str
        Alternate location of an atom: 'first' (default), 'highest' occupancy, or a letter.
    hydrogens : {'keep', 'remove'}
        Whether explicit hydrogens are read (default 'keep').
    ligands : bool, str or list of str
        Names of ligands to read with the protein, of which one at least must be there, or True or 'all' for all but waters and
        ions (default False, none).
    stride, start, stop, times : int; sequence of float, optional
        Every stride-th frame is read (default 1, all frames), from position `start` (default 0) up to the one before `stop`
        (default to the end), or only the first frame and those at these times, ps.
    whole : bool
        Whether molecules that the periodic box cuts are made whole (default True).
    plddt : float, optional
        Lowest pLDDT (0 to 100, not a share) of the residues of a predicted model that are read; other structures are read whole.
    assembly : bool or str
        Whether a biological assembly is read (default False): all models as one molecule or, where there is one model, its copies
        by the operators (REMARK 350, _pdbx_struct_assembly_gen) of the first assembly or of the one that is named, such as '2'.
        The chains of the second model or copy become A-2, B-2, ...
    groups : str or sequence, optional
        Groups of partners, as in `areas`: only their atoms are read, with the ligands that they name (default None).

    Returns
    -------
    Molecule
        Its atoms, residues and chains, and `xyz`, (frames, atoms, 3) in Å.

    Raises
    ------
    InputError
        The file cannot be read or has no such atoms, or an argument does not fit it; one sentence says what to do.

    Examples
    --------
    >>> import sparsurf
    >>> molecule = sparsurf.read_molecule("data/tdp43/topology.pdb", residues="209-222", hydrogens="remove")
    >>> molecule.n_atoms, molecule.n_residues, molecule.xyz.shape
    (119, 14, (1, 119, 3))
    """
    span = frames_between(start, stop, stride)
    if not isinstance(assembly, str):
        check_flag(assembly, "assembly")
    if plddt is not None:
        plddt = check_plddt(plddt)
    if times is not None:
        try:
            times = np.atleast_1d(np.asarray(times, float)).tolist()
        except (TypeError, ValueError):
            raise InputError(
                f"{argument('times')} is {shorten(repr(times))}; it must be a list of numbers, ps."
            ) from None
    keys: SelectionKeys = {
        "selection": selection, "chains": chains, "residues": residues, "hydrogens": hydrogens, "ligands": ligands,
        "groups": groups,
    }  # fmt: skip
    if assembly and (trajectory is not None or model is not None):
        raise InputError(ASSEMBLY_OF_MODELS)
    if plddt is not None and trajectory is not None:
        raise InputError(
            f"{argument('plddt')}: a trajectory has none; remove `{argument('plddt')}`, or choose the residues."
        )
    options = model, altloc, span, times, bool(whole), plddt, assembly
    return molecule_of_files(
        open_source(path), None if trajectory is None else open_source(trajectory), keys, *options
    )


def molecule_of_files(
    source: Source,
    frames: Source | None = None,
    keys: SelectionKeys | None = None,
    model: int | None = None,
    altloc: str = "first",
    span: slice = EVERY_FRAME.span,
    times: Sequence[float] | None = None,
    whole: bool = True,
    plddt: float | None = None,
    assembly: bool | str = False,
) -> Molecule:
    """Return the molecule of a structure, or of a topology and a trajectory, as `read_molecule` does."""
    keys = keys or {}
    if assembly and not source.format.models:
        raise InputError(ASSEMBLY_OF_MODELS)
    if not source.format.atoms:
        raise InputError(_what_names_no_atoms(source))
    has_frames = source.format.places and not source.format.models
    if times is not None and frames is None and not has_frames:
        raise InputError(
            f"{argument('times')}: there is no trajectory to take frames from; give one, or leave out the times."
        )
    if model is not None and not source.format.models:
        raise InputError(f"{source} has frames and no models: leave out the model, and name the frame.")
    with naming_file(source):
        file = MOLECULE_READERS[source.format.name](source)
        if frames is None and not source.format.places:
            raise InputError(f"{FILE} holds no coordinates: give the trajectory that belongs to it.")
        if frames is None and has_frames:
            frames = source
            if plddt is not None:
                log.warning("%s: plddt is not applied; such files have no B factors", FILE)
        if frames is None:
            molecule = molecule_of_models(file, keys, altloc, model, span, whole, assembly)
            if plddt is not None:
                molecule = _without_doubtful(molecule, file.origin, plddt)
            refuse_impossible(molecule, whole=whole)
            return replace(molecule, files=(os.path.abspath(source),), is_prediction=file.origin == PREDICTED)
        options = altloc, model, span, whole, times
        molecule = molecule_of_trajectory(file, source, frames, keys, *options)
    names = source if frames is not source else None
    with naming_file(frames):
        refuse_impossible(molecule, names, whole, frames.format.unit)
    return replace(molecule, files=(os.path.abspath(source), os.path.abspath(frames)))


def _what_names_no_atoms(source: Source) -> str:
    """Return the sentence that refuses a file of another kind in place of a structure."""
    if source.format.places:
        return f"{source} is a trajectory: give it as the trajectory, and its topology as the structure."
    labels = ", ".join(file_format.label for file_format in MOLECULE_FORMATS.values() if file_format.atoms)
    return what_is_no_structure(source, f"a file of one of the formats {labels}")


def _without_doubtful(molecule: Molecule, origin: str, plddt: float) -> Molecule:
    """Return a predicted model without the residues of a pLDDT below a bound; warn of their number."""
    polymer = np.isin(molecule.kind, POLYMERS)
    doubtful = doubtful_residues(
        molecule.b_factor, molecule.residue_index, origin, plddt, polymer if polymer.any() else None
    )
    if doubtful is None:
        return molecule
    if doubtful.all():
        raise InputError(
            f"{FILE} has no residue with a pLDDT of {plddt:g} or more: lower the bound, or exclude it."
        )
    confident = molecule.take(~doubtful)
    n_masked = molecule.n_residues - confident.n_residues
    if n_masked:
        message = "%s: left out %d of %s, whose pLDDT is below %g"
        log.warning(message, FILE, n_masked, pluralise(molecule.n_residues, "residue"), plddt)
    return replace(confident, masked_residues=n_masked)
