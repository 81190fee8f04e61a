"""Read trajectories and the topologies that mdtraj knows; nanometres become Å here and nowhere else.

mdtraj's readers ignore truncated frames, wrong headers and repeated frames. This module detects them.
"""

from __future__ import annotations

import logging
import os
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.errors import InputError
from sparsurf.files import existing_file
from sparsurf.molecules.formats import AMBER, SELF_CONTAINED, TIMED, TRAJECTORIES, suffix
from sparsurf.molecules.mdtraj_process import AtomRow, load_atoms, load_frames

log = logging.getLogger("sparsurf")

ANGSTROM_PER_NM = 10.0
TIME_TOLERANCE = 0.01  # ps, between a frame and a requested time
HEADER_LINES = {".xyz": 2, ".lammpstrj": 9, ".gro": 3}  # lines of a frame besides those of its atoms
# A title, then ten numbers of eight characters per line; each frame and each box begins a new line
MDCRD = (".mdcrd", ".crd")
NUMBERS_PER_LINE, CHARACTERS_PER_NUMBER = 10, 8
BYTES_AT_ONCE = 2**24
DCD_CELL_BYTES = 48  # of the cell of a DCD frame


@dataclass(frozen=True)
class Frames:
    """Frames of a trajectory.

    Attributes
    ----------
    xyz : (F, A, 3) float64, Å
    time_ps : (F,) float64, ps; nan where the file has no times
    number : (F,) int, position in the file, from 0
    box : (F, 3, 3) float64, Å, lattice vectors as rows; None without a box
    """

    xyz: np.ndarray
    time_ps: np.ndarray
    number: np.ndarray
    box: np.ndarray | None


def read_topology(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read the atoms of a topology file as the table of `atom_table`, with coordinates nan.

    Parameters
    ----------
    path : PSF, AMBER parm7/prmtop, GRO or HDF5

    Raises
    ------
    InputError
        Unreadable, or no atoms.
    """
    if suffix(path) == ".gro":
        check_gro(path)
    rows = load_atoms(path)
    if not rows:
        raise InputError(f"{path} holds no atoms: give the topology of the trajectory.")
    # mdtraj numbers AMBER's residues from 0, AMBER and its users from 1
    return table_of_rows(rows, first_number=int(suffix(path) in AMBER))


def table_of_rows(rows: Sequence[AtomRow], first_number: int = 0) -> pd.DataFrame:
    """Return the table of `atom_table`, with coordinates nan, from rows of `mdtraj_process.load_atoms`."""
    atoms = pd.DataFrame(rows, columns=["name", "residue_name", "chain", "number", "element", "index"])
    number = atoms.pop("number") + first_number
    terminated = atoms.pop("index").diff().fillna(0) != 0  # mdtraj knows where a residue ends
    return atoms.assign(
        residue=number.astype(str), model=1, hetero=False, altloc="", occupancy=1.0, x=np.nan, y=np.nan, z=np.nan,
        b_factor=np.nan, terminated=terminated,
    )  # fmt: skip


def read_first_frame(
    path: str | os.PathLike[str], n_atoms: int, topology_path: str | os.PathLike[str]
) -> np.ndarray:
    """Read the first frame.

    Parameters
    ----------
    path : trajectory
    n_atoms : int, atoms of the topology
    topology_path : named in messages

    Returns
    -------
    (A, 3) float64, Å

    Raises
    ------
    InputError
        Not a trajectory, or with another number of atoms.
    """
    known = TRAJECTORIES + SELF_CONTAINED
    if suffix(path) not in known:
        raise InputError(f"{path} is not a trajectory by its extension: give one of {', '.join(known)}.")
    if str(path).lower().endswith(".gz"):
        raise InputError(
            f"{path} is compressed, which is not supported for trajectories: uncompress it with gunzip."
        )
    xyz, _, _ = load_frames(path, n_atoms, first=True)
    if xyz.shape[1] != n_atoms:
        raise InputError(
            f"{path} has {xyz.shape[1]} atoms and {topology_path} has {n_atoms}: give the topology that the "
            "trajectory was written with."
        )
    return xyz[0].astype(float) * ANGSTROM_PER_NM


def read_frames(path: str | os.PathLike[str], n_atoms: int, atoms: np.ndarray, stride: int = 1) -> Frames:
    """Read every `stride`-th frame of a trajectory.

    Parameters
    ----------
    path : any format that mdtraj reads
    n_atoms : int, atoms of the topology, checked by `read_first_frame`
    atoms : (A,) int, the atoms to read
    stride : int

    Returns
    -------
    Frames
    """
    xyz, time_ps, box = load_frames(path, n_atoms, atoms, stride)
    extension = suffix(path)
    count = count_usable_frames(path, n_atoms, len(xyz), stride)
    xyz, time_ps, box = xyz[:count], time_ps[:count], box[:count]
    warn_of_repeats(path, xyz, time_ps)
    if extension not in TIMED or not (np.diff(time_ps) > 0).all():
        time_ps = np.full(len(xyz), np.nan)
    return _in_angstrom(xyz, time_ps, stride * np.arange(len(xyz)), box)


def read_frames_at(
    path: str | os.PathLike[str], n_atoms: int, atoms: np.ndarray, times: Sequence[float]
) -> Frames:
    """Read the first frame and those at `times`, ps, as `read_frames` does, without loading the others."""
    every = read_frames(path, n_atoms, atoms[:1])
    distance = np.abs(every.time_ps[:, None] - np.asarray(times)).min(axis=1, initial=np.inf)
    near = distance < TIME_TOLERANCE  # False for nan, of a file without times
    if not near.any():
        log.warning("%s has no frame at any of the requested times: only its first frame is read", path)
    number = np.flatnonzero(near | (every.number == 0))
    xyz, _, box = load_frames(path, n_atoms, atoms, only=number)
    return _in_angstrom(xyz, every.time_ps[number], number, box)


def _in_angstrom(xyz: np.ndarray, time_ps: np.ndarray, number: np.ndarray, box: np.ndarray) -> Frames:
    """Return frames of mdtraj, whose lengths are nanometres, in Å."""
    box_or_none = box.astype(float) * ANGSTROM_PER_NM if len(box) else None
    return Frames(xyz.astype(float) * ANGSTROM_PER_NM, time_ps, number, box_or_none)


def count_usable_frames(path: str | os.PathLike[str], n_atoms: int, n_read: int, stride: int) -> int:
    """Count the complete frames; warn if the header announces another number or the last frame is truncated.

    Parameters
    ----------
    path : trajectory
    n_atoms : int, of the whole file
    n_read : int, frames that were read, every `stride`-th
    stride : int

    Raises
    ------
    InputError
        The file ends within its first frame.
    """
    if suffix(path) == ".dcd":
        _check_dcd(path, n_atoms, n_read, stride)
    n_complete, truncated = count_complete_frames(path, n_atoms) or (stride * n_read, False)
    if truncated and n_complete == 0:
        raise InputError(f"{path} is cut short within its first frame: copy it again.")
    count = min(n_read, -(-n_complete // stride))
    if truncated:
        message = "%s is cut short: its incomplete last frame is left out, %d were read (stride %d)"
        log.warning(message, path, count, stride)
    return count


def warn_of_repeats(path: str | os.PathLike[str], xyz: np.ndarray, time: np.ndarray) -> None:
    """Warn if a trajectory seems to be written twice.

    Parameters
    ----------
    path : named in the message
    xyz : (F, A, 3), frames read
    time : (F,), nan where the file has no times
    """
    half = len(xyz) // 2
    moves = half > 1 and (xyz[0] != xyz[1:half]).any()
    if moves and np.array_equal(xyz[:half], xyz[half : 2 * half]):
        log.warning("%s: its second half repeats the first; was it written twice?", path)
    elif suffix(path) in TIMED and (np.diff(time) < 0).any():
        frame = int(np.argmax(np.diff(time) < 0)) + 1
        message = "%s: time goes back to %g ps at frame %d; were two trajectories joined?"
        log.warning(message, path, time[frame], frame)


def check_gro(path: str | os.PathLike[str]) -> None:
    """Raise InputError, with the line, if the first frame of a GRO file violates the columns of the format."""
    with existing_file(path).open(encoding="latin-1") as file:
        lines = [file.readline() for _ in range(2)]
        if not lines[1].strip().isdecimal():
            raise InputError(f"{path}: line 2 is not the number of atoms: give a GRO file.")
        n_atoms = int(lines[1])
        for number in range(3, n_atoms + 3):
            line = file.readline()
            if not line:
                raise InputError(
                    f"{path} is cut short: it has {number - 3} of {n_atoms} atoms; copy it again."
                )
            if len(_numbers(line[20:])) < 3:
                raise InputError(f"{path}: line {number} has no three coordinates: repair the line.")
        if len(_numbers(file.readline())) not in (3, 9):
            raise InputError(f"{path}: line {n_atoms + 3} is not a box of 3 or 9 numbers: add it, or zeros.")


def _numbers(text: str) -> list[float]:
    """Return the numbers of a string; none if a word is not a number."""
    try:
        return [float(word) for word in text.replace("-", " -").split()]
    except ValueError:
        return []


def _check_dcd(path: str | os.PathLike[str], n_atoms: int, n_read: int, stride: int) -> None:
    """Warn if a DCD file holds fewer or more frames than its header says (a killed run, two joined runs)."""
    with Path(path).open("rb") as file:
        head = file.read(12)
        order = "<" if head[:4] == struct.pack("<i", 84) else ">"
        n_announced = struct.unpack(order + "i", head[8:12])[0]
        file.seek(0)
        for _ in range(3):  # header, titles, number of atoms
            length = struct.unpack(order + "i", file.read(4))[0]
            file.seek(length + 4, 1)
        start, record = file.tell(), struct.unpack(order + "i", file.read(4).ljust(4, b"\0"))[0]
        size = file.seek(0, 2) - start
    frame_bytes = 3 * (4 * n_atoms + 8) + (record + 8 if record == DCD_CELL_BYTES else 0)
    if n_read < -(-n_announced // stride):
        message = "%s is cut short: its header announces %d frames, %d were read (stride %d)"
        log.warning(message, path, n_announced, n_read, stride)
    elif n_announced > 0 and size > (n_announced + 0.5) * frame_bytes:
        message = "%s continues after the %d frames that its header announces; was it written twice?"
        log.warning(message, path, n_announced)


def count_complete_frames(path: str | os.PathLike[str], n_atoms: int) -> tuple[int, bool] | None:
    """Count the frames of a text trajectory that are complete from their first to their last line.

    Parameters
    ----------
    path : a file that mdtraj has read, so that its format and number of atoms are right
    n_atoms : int

    Returns
    -------
    (int, bool)
        Complete frames, and whether a truncated one follows. None for binary formats.
    """
    extension = Path(path).suffix.lower()
    if extension in MDCRD:
        title, per_frame = 1, -(-3 * n_atoms // NUMBERS_PER_LINE)
        box = _has_box(path, per_frame)
        per_frame += box
    elif extension in HEADER_LINES:
        title, box, per_frame = 0, False, n_atoms + HEADER_LINES[extension]
    else:
        return None
    n_lines, last = _count_lines(path)
    in_columns = extension in MDCRD and not box  # numbers may touch
    cut = bool(len(last) % CHARACTERS_PER_NUMBER) if in_columns else _ends_within_a_number(last)
    n_frames, rest = divmod(n_lines - title - cut, per_frame)
    return n_frames, bool(rest)


def _has_box(path: str | os.PathLike[str], per_frame: int) -> bool:
    """Return whether the line after the first frame of an mdcrd file holds the three lengths of a box."""
    with Path(path).open("rb") as file:
        lines = [file.readline() for _ in range(per_frame + 2)]
    return per_frame > 1 and len(lines[-1].split()) == 3


def _ends_within_a_number(line: bytes) -> bool:
    """Return whether the last two numbers of a line differ in their decimals."""
    decimals = [len(number.partition(b".")[2]) for number in line.split()[-2:]]
    return len(set(decimals)) > 1


def _count_lines(path: str | os.PathLike[str]) -> tuple[int, bytes]:
    """Count lines without empty ones at the end; also return the last line if no newline ends it."""
    count, tail = 0, b""
    with Path(path).open("rb") as file:
        while chunk := file.read(BYTES_AT_ONCE):
            count += chunk.count(b"\n")
            tail = (tail + chunk)[-BYTES_AT_ONCE:]
    last = tail.rsplit(b"\n", 1)[-1].rstrip()
    empty = tail[len(tail.rstrip()) :].count(b"\n") - 1
    return count + bool(last) - max(empty, 0), last
