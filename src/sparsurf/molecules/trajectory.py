"""Read trajectories and the topologies that mdtraj knows; nanometres become Å here and nowhere else.

mdtraj's readers ignore truncated frames, wrong headers and repeated frames. This module detects them.
"""

from __future__ import annotations

import logging
import struct
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np

from sparsurf.errors import InputError
from sparsurf.files import StrPath, existing_file, pluralise
from sparsurf.molecules.atom_table import AtomTable, atom_table
from sparsurf.molecules.formats import AMBER, SELF_CONTAINED, TIMED, TRAJECTORIES, suffix
from sparsurf.molecules.geometry import refuse_invalid_coordinates
from sparsurf.molecules.mdtraj_process import AtomRow, iterate_frames, load_atoms, load_frames

log = logging.getLogger("sparsurf")

ANGSTROM_PER_NM = 10.0
TIME_TOLERANCE = 0.01  # ps, between a frame and a requested time
HEADER_LINES = {".xyz": 2, ".lammpstrj": 9, ".gro": 3}  # lines of a frame besides those of its atoms
# A title, then ten numbers of eight characters per line; each frame and each box begins a new line
MDCRD = (".mdcrd", ".crd")
NUMBERS_PER_LINE, CHARACTERS_PER_NUMBER = 10, 8
BYTES_AT_ONCE = 2**24
DCD_CELL_BYTES = 48  # of the cell of a DCD frame
# A frame of TRR begins with a number, the length of a name twice, the name, and the sizes of what follows
TRR_MAGIC, TRR_HEAD, TRR_SIZES = 1993, struct.Struct(">3i"), struct.Struct(">13i")
MAX_TRR_VERSION = 100  # bytes of the name
MIN_ATOMS_TO_COMPARE = 10  # fewer may stand still in the precision of a file
BYTES_IN_MEMORY = 2**25  # of frames; more lie in a temporary file


@dataclass(frozen=True)
class Frames:
    """Frames of a trajectory."""

    xyz: np.ndarray  # (F, A, 3) float64, Å
    time_ps: np.ndarray  # (F,) float64, ps; nan where the file has no times
    number: np.ndarray  # (F,) int, position in the file, from 0
    box: np.ndarray | None  # (F, 3, 3) float64, Å, lattice vectors as rows; None without a box


def read_topology(path: StrPath) -> AtomTable:
    """Read the atoms of a topology file (PSF, AMBER parm7/prmtop, GRO or HDF5) as a table with coordinates nan."""
    if suffix(path) == ".gro":
        check_gro(path)
    rows = load_atoms(path)
    if not rows:
        raise InputError(f"{path} holds no atoms: give the topology of the trajectory.")
    # mdtraj numbers AMBER's residues from 0, AMBER and its users from 1
    return table_of_rows(rows, first_number=int(suffix(path) in AMBER))


def table_of_rows(rows: Sequence[AtomRow], first_number: int = 0) -> AtomTable:
    """Return the table of `atom_table`, with coordinates nan, from rows of `mdtraj_process.load_atoms`."""
    columns = ("name", "residue_name", "chain", "segid", "number", "element", "unit", "molecule")
    table = dict(zip(columns, map(list, zip(*rows, strict=True)), strict=True))
    table["residue"] = [str(number + first_number) for number in table.pop("number")]
    table["chain"] = [chain.strip() for chain in table["chain"]]
    return atom_table(**table)


def read_first_frame(path: StrPath, n_atoms: int, topology_path: StrPath) -> np.ndarray:
    """Read the first frame (A, 3), float64, Å; refuse what is no trajectory, or has another number of atoms than the topology."""
    known = TRAJECTORIES + SELF_CONTAINED
    if suffix(path) not in known:
        raise InputError(f"{path} is not a trajectory by its extension: give one of {', '.join(known)}.")
    if str(path).lower().endswith(".gz"):
        raise InputError(
            f"{path} is compressed, which is not supported for trajectories: uncompress it with gunzip."
        )
    stored, _ = _frames_with_positions(path)
    late = () if stored is None or not stored[0] else stored[:1]
    xyz, _, _ = load_frames(path, n_atoms, first=not len(late), only=late)
    if xyz.shape[1] != n_atoms:
        raise InputError(
            f"{path} has {xyz.shape[1]} atoms and {topology_path} has {n_atoms}: give the topology that the "
            "trajectory was written with."
        )
    return xyz[0].astype(float) * ANGSTROM_PER_NM


def read_frames(
    path: StrPath,
    n_atoms: int,
    atoms: np.ndarray,
    stride: int = 1,
    times: Sequence[float] | None = None,
    change: Callable[[np.ndarray, np.ndarray | None, np.ndarray], np.ndarray] = lambda xyz, box, number: xyz,
) -> Frames:
    """Read every `stride`-th frame of a trajectory, or the first one and those at `times`, ps; memory does not grow with it.

    Frames that repeat the one before are left out, as readers do with those of TRR that have no positions. `change`
    makes other positions of some (F, A, 3), Å, their boxes (F, 3, 3), or None, and their numbers in the file (F,).
    """
    stored, boxed = _frames_with_positions(path)
    if times is not None:
        time_ps = _times(path, n_atoms, stored)
        number = _frames_at(path, time_ps, times)
        time_ps, only = time_ps[number], number if stored is None else stored[number]
    elif stored is not None:
        only = stored[::stride]
    else:
        only = np.empty(0, int)
    complete = count_complete_frames(path, n_atoms)
    n_usable = -(-complete[0] // stride) if complete and times is None else 2**62
    order = np.argsort(atoms, kind="stable")
    store, before, n_read = FrameStore(path), np.empty((0, 0, 3)), 0
    keep: list[bool] = []
    time_parts: list[np.ndarray] = []
    number_parts: list[np.ndarray] = []
    for part in iterate_frames(path, n_atoms, np.asarray(atoms)[order], stride, only=only):
        n_read += len(part[0])
        raw, time, box = (array[: max(0, n_usable - len(keep))] for array in part)
        if not len(raw):
            continue
        xyz = np.empty(raw.shape)
        xyz[:, order] = raw
        xyz *= ANGSTROM_PER_NM
        moved = _differ_from_before(xyz, before)
        before = xyz[-1:].copy()
        places = len(keep) + np.arange(len(xyz))
        numbers = stride * places if times is None else number[places]
        refuse_invalid_coordinates(xyz, path, numbers)
        cells = box[moved].astype(float) * ANGSTROM_PER_NM if len(box) and boxed else None
        xyz = change(xyz[moved], cells, numbers[moved])
        store.append(xyz)
        keep += moved.tolist()
        time_parts.append(time)
        number_parts.append(numbers)
    if times is None:
        if suffix(path) == ".dcd":
            check_dcd(path, n_atoms, n_read, stride)
        if complete and complete[1]:
            report_cut(path, complete[0], n_read, stride)
        time_ps, number = np.concatenate(time_parts), np.concatenate(number_parts)
    xyz = store.frames()
    if n_repeats := len(keep) - len(xyz):
        message = "%s: %s the one before, the first is frame %d: left out"
        log.warning(message, path, pluralise(n_repeats, "frame", "repeats"), number[keep.index(False)])
    time_ps, number = time_ps[keep], number[keep]
    if times is None:
        warn_of_repeats(path, xyz, time_ps, number)
    if suffix(path) not in TIMED or not (np.diff(time_ps) > 0).all():
        time_ps = np.full(len(xyz), np.nan)
    return Frames(xyz, time_ps, number, None)


def _differ_from_before(xyz: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return which frames (F, A, 3) differ from the one before; the first one follows `before`, (1, A, 3) or empty."""
    if xyz.shape[1] < MIN_ATOMS_TO_COMPARE:
        return np.ones(len(xyz), bool)
    repeats = (xyz[1:] == xyz[:-1]).all(axis=(1, 2))
    return ~np.append(len(before) > 0 and np.array_equal(xyz[:1], before), repeats)


def _times(path: StrPath, n_atoms: int, stored: np.ndarray | None) -> np.ndarray:
    """Read the times of all frames with positions, ps; nan where the format has none."""
    time = np.concatenate([part[1] for part in iterate_frames(path, n_atoms, np.array([0]))])
    time = time if stored is None else time[stored]
    return time if suffix(path) in TIMED and (np.diff(time) > 0).all() else np.full(len(time), np.nan)


def _frames_at(path: StrPath, time_ps: np.ndarray, times: Sequence[float]) -> np.ndarray:
    """Return the numbers of the first frame and of those at some times, ps."""
    distance = np.abs(time_ps[:, None] - np.asarray(times, float)).min(axis=1, initial=np.inf)
    near = distance < TIME_TOLERANCE  # False for nan, of a file without times
    if not near.any():
        log.warning("%s has no frame at any of the requested times: only its first frame is read", path)
    return np.flatnonzero(near | (np.arange(len(near)) == 0))


def _frames_with_positions(path: StrPath) -> tuple[np.ndarray | None, bool]:
    """Return the numbers of the frames of a TRR file that have positions, and whether all these have a box.

    A frame may hold velocities or forces alone. mdtraj returns the positions of the frame before for it, and any numbers
    for a box that is absent. The numbers are None for another format, if all frames have positions, or a header is damaged.
    """
    if suffix(path) != ".trr":
        return None, True
    numbers, n_frames, offset, boxed = list[int](), 0, 0, True
    size = existing_file(path).stat().st_size
    with Path(path).open("rb") as file:
        while offset + TRR_HEAD.size <= size:
            file.seek(offset)
            magic, _, length = TRR_HEAD.unpack(file.read(TRR_HEAD.size))
            padded = -(-length // 4) * 4
            content = file.read(padded + TRR_SIZES.size)[padded:]
            if magic != TRR_MAGIC or not 0 < length < MAX_TRR_VERSION or len(content) < TRR_SIZES.size:
                return None, boxed
            *sizes, n_atoms, _, _ = TRR_SIZES.unpack(content)
            box, positions = sizes[2], sizes[7]
            double = (positions or sizes[8] or sizes[9]) == 24 * n_atoms or box == 72
            if min(sizes) < 0 or n_atoms <= 0:
                return None, boxed
            if positions:
                numbers.append(n_frames)
                boxed &= box > 0
            n_frames += 1
            offset += TRR_HEAD.size + padded + TRR_SIZES.size + 2 * (8 if double else 4) + sum(sizes)
    return np.array(numbers) if numbers and len(numbers) < n_frames else None, boxed


class FrameStore:
    """Frames that are appended one part after another; beyond BYTES_IN_MEMORY they lie in a temporary file."""

    def __init__(self, path: StrPath) -> None:
        self.path, self.parts, self.n_bytes, self.n_frames = path, list[np.ndarray](), 0, 0
        self.file: IO[bytes] | None = None

    def append(self, xyz: np.ndarray) -> None:
        """Append frames (F, A, 3)."""
        self.shape = xyz.shape[1:]
        self.parts.append(xyz)
        self.n_bytes += xyz.nbytes
        self.n_frames += len(xyz)
        if self.file is not None or self.n_bytes > BYTES_IN_MEMORY:
            try:
                self.file = self.file or tempfile.TemporaryFile()  # noqa: SIM115, open as long as its frames are
                for part in self.parts:
                    self.file.write(part.tobytes())
            except OSError as error:
                raise InputError(
                    f"the frames of {self.path} do not fit into {tempfile.gettempdir()} ({error.strerror}): "
                    "set TMPDIR to another folder."
                ) from None
            self.parts = []

    def frames(self) -> np.ndarray:
        """Return all frames, float64; those of a file can be read only."""
        if self.file is None:
            return np.concatenate(self.parts)
        self.file.flush()
        return np.memmap(self.file, float, "r", shape=(self.n_frames, *self.shape))


def report_cut(path: StrPath, n_complete: int, n_read: int, stride: int) -> None:
    """Warn that the last frame of a trajectory is truncated; raise InputError if it is the first one."""
    if n_complete == 0:
        raise InputError(f"{path} is cut short within its first frame: copy it again.")
    message = "%s is cut short: its incomplete last frame is left out, %d were read (stride %d)"
    log.warning(message, path, min(n_read, -(-n_complete // stride)), stride)


def warn_of_repeats(path: StrPath, xyz: np.ndarray, time: np.ndarray, number: np.ndarray) -> None:
    """Warn if a trajectory (F, A, 3) with times (F,), nan where the file has none, and numbers (F,) seems to be written twice."""
    half = len(xyz) // 2
    repeated = all(np.array_equal(xyz[k], xyz[half + k]) for k in range(half))
    if half > 1 and repeated and any((xyz[0] != xyz[k]).any() for k in range(1, half)):
        log.warning("%s: its second half repeats the first; was it written twice?", path)
    elif suffix(path) in TIMED and (np.diff(time) < 0).any():
        frame = int(np.argmax(np.diff(time) < 0)) + 1
        message = "%s: time goes back to %g ps at frame %d; were two trajectories joined?"
        log.warning(message, path, time[frame], number[frame])


def check_gro(path: StrPath) -> None:
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
        box = file.readline()
        if len(_numbers(box)) not in (3, 9):
            if box.count(".") in (3, 9) and not box.strip(" \n.-+0123456789"):
                raise InputError(
                    f"{path}: the numbers of the box in line {n_atoms + 3} touch: put blanks between them."
                )
            raise InputError(f"{path}: line {n_atoms + 3} is not a box of 3 or 9 numbers: add it, or zeros.")


def _numbers(text: str) -> list[float]:
    """Return the numbers of a string; none if a word is not a number."""
    try:
        return [float(word) for word in text.replace("-", " -").split()]
    except ValueError:
        return []


def check_dcd(path: StrPath, n_atoms: int, n_read: int, stride: int) -> None:
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


def count_complete_frames(path: StrPath, n_atoms: int) -> tuple[int, bool] | None:
    """Return the number of complete frames of a text trajectory, and whether a truncated one follows; None if it is binary."""
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


def _has_box(path: StrPath, per_frame: int) -> bool:
    """Return whether the line after the first frame of an mdcrd file holds the three lengths of a box."""
    with Path(path).open("rb") as file:
        lines = [file.readline() for _ in range(per_frame + 2)]
    return per_frame > 1 and len(lines[-1].split()) == 3


def _ends_within_a_number(line: bytes) -> bool:
    """Return whether the last two numbers of a line differ in their decimals."""
    decimals = [len(number.partition(b".")[2]) for number in line.split()[-2:]]
    return len(set(decimals)) > 1


def _count_lines(path: StrPath) -> tuple[int, bytes]:
    """Count lines without empty ones at the end; also return the last line if no newline ends it."""
    count, tail = 0, b""
    with Path(path).open("rb") as file:
        while chunk := file.read(BYTES_AT_ONCE):
            count += chunk.count(b"\n")
            tail = (tail + chunk)[-BYTES_AT_ONCE:]
    last = tail.rsplit(b"\n", 1)[-1].rstrip()
    empty = tail[len(tail.rstrip()) :].count(b"\n") - 1
    return count + bool(last) - max(empty, 0), last
