"""Trajectories and the topologies that mdtraj reads; nanometres become Å here and nowhere else.

Readers pass over torn frames, other headers and repeated frames in silence: whether a file is whole is found here.
"""

import logging
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.files import existing_file
from sparsurf.molecules.formats import AMBER, SELF_CONTAINED, TIMED, TRAJECTORIES, suffix
from sparsurf.molecules.mdtraj_process import frames, names

log = logging.getLogger("sparsurf")

ANGSTROM = 10.0  # per nm
AT = 0.01  # ps; a frame so near a time is of that time
BESIDE_ATOMS = {".xyz": 2, ".lammpstrj": 9, ".gro": 3}  # lines of a frame beside those of its atoms
MDCRD = (
    ".mdcrd",
    ".crd",
)  # a title, then ten numbers of eight characters on a line, a frame and its box apart
NUMBERS, WIDTH = 10, 8
CHUNK = 2**24  # bytes read at once
CELL = 48  # bytes of the cell of a DCD frame


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


def frames_of_use(path, n_atoms, found, stride):
    """How many of the frames found are whole; a warning tells what a header or the frames' order does not fit.

    Parameters
    ----------
    path : trajectory
    n_atoms : int, of the whole file
    found : int, frames that its reader found, every `stride`-th
    stride : int

    Raises
    ------
    InputError : it ends within its first frame
    """
    if suffix(path) == ".dcd":
        _check_dcd(path, n_atoms, found, stride)
    whole, torn = whole_frames(path, n_atoms) or (stride * found, False)
    if torn and whole == 0:
        raise InputError(f"{path} is cut short within its first frame: copy it again.")
    count = min(found, -(-whole // stride))
    if torn:
        message = "%s is cut short: the frame in which it ends is left out, %d were read (stride %d)"
        log.warning(message, path, count, stride)
    return count


def warn_of_repeats(path, xyz, time):
    """Warn where a trajectory seems to be written twice.

    Parameters
    ----------
    path : named in the message
    xyz : (F, A, 3), frames read
    time : (F,), nan where the file tells none
    """
    half = len(xyz) // 2
    moves = half > 1 and (xyz[0] != xyz[1:half]).any()
    if moves and np.array_equal(xyz[:half], xyz[half : 2 * half]):
        log.warning("%s: its second half repeats the first; was it written twice?", path)
    elif suffix(path) in TIMED and (np.diff(time) < 0).any():
        at = int(np.argmax(np.diff(time) < 0)) + 1
        message = "%s: time goes back to %g ps at frame %d; were two trajectories joined?"
        log.warning(message, path, time[at], at)


def check_gro(path):
    """Raise InputError, with the line, where the first frame of a GRO file is not in the columns of the format."""
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


def _numbers(text):
    """The numbers of a text; none where a word is no number."""
    try:
        return [float(word) for word in text.replace("-", " -").split()]
    except ValueError:
        return []


def _check_dcd(path, n_atoms, found, stride):
    """Warn if a DCD file holds fewer or more frames than its header says (a run that was killed, two that were joined)."""
    with Path(path).open("rb") as file:
        head = file.read(12)
        order = "<" if head[:4] == struct.pack("<i", 84) else ">"
        promised = struct.unpack(order + "i", head[8:12])[0]
        file.seek(0)
        for _ in range(3):  # header, titles, number of atoms
            length = struct.unpack(order + "i", file.read(4))[0]
            file.seek(length + 4, 1)
        start, first = file.tell(), struct.unpack(order + "i", file.read(4).ljust(4, b"\0"))[0]
        size = file.seek(0, 2) - start
    frame = 3 * (4 * n_atoms + 8) + (first + 8 if first == CELL else 0)
    if found < -(-promised // stride):
        message = "%s is cut short: its header announces %d frames, %d were read (stride %d)"
        log.warning(message, path, promised, found, stride)
    elif promised > 0 and size > (promised + 0.5) * frame:
        message = "%s goes on after the %d frames that its header announces; was it written twice?"
        log.warning(message, path, promised)


def whole_frames(path, n_atoms):
    """Frames of a text trajectory that are there from their first to their last line.

    Parameters
    ----------
    path : file that has been read, so that its frames are of this format and have `n_atoms` atoms
    n_atoms : int

    Returns
    -------
    (int, bool) : frames, and whether a torn one follows; None for formats that are no text
    """
    suffix = Path(path).suffix.lower()
    if suffix in MDCRD:
        title, per_frame = 1, -(-3 * n_atoms // NUMBERS)
        box = _has_box(path, per_frame)
        per_frame += box
    elif suffix in BESIDE_ATOMS:
        title, box, per_frame = 0, False, n_atoms + BESIDE_ATOMS[suffix]
    else:
        return None
    lines, last = _lines(path)
    in_columns = suffix in MDCRD and not box  # where numbers may touch
    cut = bool(len(last) % WIDTH) if in_columns else _ends_within_a_number(last)
    frames, rest = divmod(lines - title - cut, per_frame)
    return frames, bool(rest)


def _has_box(path, per_frame):
    """Whether the line after the first frame of an mdcrd file holds the three lengths of a box."""
    with Path(path).open("rb") as file:
        lines = [file.readline() for _ in range(per_frame + 2)]
    return per_frame > 1 and len(lines[-1].split()) == 3


def _ends_within_a_number(line):
    """Whether the last number of a line has not the decimals of the one before it."""
    decimals = [len(number.partition(b".")[2]) for number in line.split()[-2:]]
    return len(set(decimals)) > 1


def _lines(path):
    """Number of lines without empty ones at the end, and the last one if no newline ends it."""
    count, tail = 0, b""
    with Path(path).open("rb") as file:
        while chunk := file.read(CHUNK):
            count += chunk.count(b"\n")
            tail = (tail + chunk)[-CHUNK:]
    last = tail.rsplit(b"\n", 1)[-1].rstrip()
    empty = tail[len(tail.rstrip()) :].count(b"\n") - 1
    return count + bool(last) - max(empty, 0), last
