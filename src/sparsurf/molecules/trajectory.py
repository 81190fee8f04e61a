"""Trajectories and the topologies that mdtraj reads; nanometres become Å here and nowhere else."""

import logging
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.molecules.completeness import check_gro, frames_of_use, warn_of_repeats
from sparsurf.molecules.formats import AMBER, SELF_CONTAINED, TIMED, TRAJECTORIES, suffix
from sparsurf.molecules.mdtraj_process import frames, names

log = logging.getLogger("sparsurf")

ANGSTROM = 10.0  # per nm
AT = 0.01  # ps; a frame so near a time is of that time


@dataclass(frozen=True)
class Frames:
    """Frames of a trajectory.

    Attributes
    ----------
    xyz : (F, A, 3) float64, Å
    time_ps : (F,) float64, ps; nan where the file tells no times
    number : (F,) int, position in the file, from 0
    box : (F, 3, 3) float64, Å, lattice vectors as rows; None without a box
    """

    xyz: np.ndarray
    time_ps: np.ndarray
    number: np.ndarray
    box: np.ndarray | None


def read_topology(path):
    """Atoms of a topology file as the table of `atoms`, coordinates nan.

    Parameters
    ----------
    path : PSF, AMBER parm7/prmtop, GRO or HDF5

    Raises
    ------
    InputError : unreadable, or no atoms
    """
    if suffix(path) == ".gro":
        check_gro(path)
    rows = names(path)
    if not rows:
        raise InputError(f"{path} holds no atoms: give the topology of the trajectory.")
    # mdtraj counts AMBER's residues from 0, AMBER and its users from 1
    return table_of(rows, first_number=int(suffix(path) in AMBER))


def table_of(rows, first_number=0):
    """The table of `atom_table`, coordinates nan, of rows as `mdtraj_process.names` gives them."""
    atoms = pd.DataFrame(rows, columns=["name", "residue_name", "chain", "number", "element", "index"])
    number = atoms.pop("number") + first_number
    terminated = atoms.pop("index").diff().fillna(0) != 0  # mdtraj knows where a residue ends
    return atoms.assign(
        residue=number.astype(str), model=1, hetero=False, altloc="", occupancy=1.0, x=np.nan, y=np.nan, z=np.nan,
        b_factor=np.nan, terminated=terminated,
    )  # fmt: skip


def first_frame(path, n_atoms, topology_path):
    """(A, 3) float64, Å: the first frame, after a check that the trajectory has `n_atoms` atoms."""
    known = TRAJECTORIES + SELF_CONTAINED
    if suffix(path) not in known:
        raise InputError(f"{path} is no trajectory by its extension: give one of {', '.join(known)}.")
    if str(path).lower().endswith(".gz"):
        raise InputError(f"{path} is packed, which no trajectory can be: unpack it with gunzip.")
    xyz, _, _ = frames(path, n_atoms, first=True)
    if xyz.shape[1] != n_atoms:
        raise InputError(
            f"{path} has {xyz.shape[1]} atoms and {topology_path} has {n_atoms}: give the topology that the "
            "trajectory was written with."
        )
    return xyz[0].astype(float) * ANGSTROM


def read_frames(path, n_atoms, atoms, stride=1):
    """Every `stride`-th frame of a trajectory.

    Parameters
    ----------
    path : any format that mdtraj reads
    n_atoms : int, atoms of the topology, checked by `first_frame`
    atoms : (A,) int, those to read
    stride : int

    Returns
    -------
    Frames
    """
    xyz, time_ps, box = frames(path, n_atoms, atoms, stride)
    extension = suffix(path)
    count = frames_of_use(path, n_atoms, len(xyz), stride)
    xyz, time_ps, box = xyz[:count], time_ps[:count], box[:count]
    warn_of_repeats(path, xyz, time_ps)
    if extension not in TIMED or not (np.diff(time_ps) > 0).all():
        time_ps = np.full(len(xyz), np.nan)
    return _in_angstrom(xyz, time_ps, stride * np.arange(len(xyz)), box)


def read_frames_at(path, n_atoms, atoms, times):
    """As `read_frames`, the first frame and those at some of `times`, ps; no other is held."""
    every = read_frames(path, n_atoms, atoms[:1])
    far = np.abs(every.time_ps[:, None] - np.asarray(times)).min(axis=1, initial=np.inf)
    if not (far < AT).any():  # nan, too: a file that tells no times
        log.warning(
            "%s has no frame at any of the times that are asked for: its first frame alone is read", path
        )
    number = np.flatnonzero((far < AT) | (every.number == 0))
    xyz, _, box = frames(path, n_atoms, atoms, only=number)
    return _in_angstrom(xyz, every.time_ps[number], number, box)


def _in_angstrom(xyz, time_ps, number, box):
    """Frames of what mdtraj gives in nanometres."""
    box = box.astype(float) * ANGSTROM if len(box) else None
    return Frames(xyz.astype(float) * ANGSTROM, time_ps, number, box)
