"""Trajectories and the topologies that mdtraj reads; nanometres become Å here and nowhere else."""

import logging
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.isolated import ONE_FRAME, frames, names

log = logging.getLogger("sparsurf")

ANGSTROM = 10.0  # per nm
AMBER = (".prmtop", ".parm7", ".prm7")
TOPOLOGIES = (".psf", *AMBER)
SELF_CONTAINED = (".gro", ".h5", ".hdf5")  # names and coordinates in one file
TRAJECTORIES = (
    ".xtc", ".trr", ".dcd", ".nc", ".ncdf", ".netcdf", *SELF_CONTAINED, ".mdcrd", ".crd", ".lammpstrj", ".xyz",
    *ONE_FRAME,
)  # fmt: skip
TIMED = (".xtc", ".trr", ".nc", ".ncdf", ".netcdf", ".h5", ".hdf5", ".gro")


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
    rows = names(path)
    if not rows:
        raise InputError(f"{path} holds no atoms: give the topology of the trajectory.")
    atoms = pd.DataFrame(rows, columns=["name", "residue_name", "chain", "number", "element", "index"])
    # mdtraj counts AMBER's residues from 0, AMBER and its users from 1
    number = atoms.pop("number") + (Path(path).suffix.lower() in AMBER)
    terminated = atoms.pop("index").diff().fillna(0) != 0  # mdtraj knows where a residue ends
    return atoms.assign(
        residue=number.astype(str), model=1, hetero=False, altloc="", occupancy=1.0, x=np.nan, y=np.nan, z=np.nan,
        terminated=terminated,
    )  # fmt: skip


def first_frame(path, n_atoms, topology_path):
    """(A, 3) float64, Å: the first frame, after a check that the trajectory has `n_atoms` atoms."""
    if Path(path).suffix.lower() not in TRAJECTORIES:
        raise InputError(f"{path} is no trajectory by its extension: give one of {', '.join(TRAJECTORIES)}.")
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
    extension = Path(path).suffix.lower()
    if extension == ".dcd":
        _check_dcd_count(path, len(xyz), stride)
    if extension not in TIMED or not (np.diff(time_ps) > 0).all():
        time_ps = np.full(len(xyz), np.nan)
    return Frames(
        xyz.astype(float) * ANGSTROM, time_ps, stride * np.arange(len(xyz)),
        box.astype(float) * ANGSTROM if len(box) else None,
    )  # fmt: skip


def _check_dcd_count(path, found, stride):
    """Warn if a DCD file holds fewer frames than its header says (a run that was killed, a copy that stopped)."""
    with Path(path).open("rb") as file:
        head = file.read(12)
    order = "<" if head[:4] == struct.pack("<i", 84) else ">"
    promised = struct.unpack(order + "i", head[8:12])[0]
    if found < -(-promised // stride):
        message = "%s is cut short: its header announces %d frames, %d were read (stride %d)"
        log.warning(message, path, promised, found, stride)
