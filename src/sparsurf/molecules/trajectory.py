"""Read the frames of trajectories; nanometres become Å here and in `text_frames`, and nowhere else.

Binary formats are read by mdtraj, whose readers ignore truncated frames, wrong headers and repeated frames. This module detects
them.
"""

from __future__ import annotations

import logging
import struct
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sparsurf.errors import FILE, InputError, argument
from sparsurf.files import StrPath, existing_file, pluralise
from sparsurf.messages import no_warnings
from sparsurf.molecules.mdtraj_process import EVERY_FRAME, FrameSelection, iterate_frames
from sparsurf.molecules.plausibility import refuse_invalid_coordinates
from sparsurf.molecules.source import Source
from sparsurf.molecules.text_frames import ANGSTROM_PER_NM, TextFrame, frames_of_text

log = logging.getLogger("sparsurf")

TIME_TOLERANCE = 0.01  # ps, between a frame and a requested time
BYTES_OF_A_CHUNK = 2**24
DCD_CELL_BYTES = 48  # The record of the cell of a DCD frame has this length.
# A frame of TRR begins with a number, the length of a name twice, the name, and the sizes of what follows
TRR_MAGIC, TRR_HEAD, TRR_SIZES = 1993, struct.Struct(">3i"), struct.Struct(">13i")
MAX_TRR_VERSION = 100  # bytes of the name
# A frame of XTC begins with its magic number (1995, or 2023 where the size has eight bytes) and number of atoms. Behind its head
# stand the precision of compressed positions, the steps per nm to which they are rounded, and later their size
XTC_BEGIN, XTC_HEAD, XTC_PRECISION, XTC_SIZE = struct.Struct(">2i"), 56, struct.Struct(">f"), 88
XTC_SIZES = {1995: struct.Struct(">i"), 2023: struct.Struct(">q")}
MIN_COMPRESSED_ATOMS = 10  # XTC stores fewer atoms without rounding.
REFUSED_STEP, ROUNDED = 0.5, 0.02  # Å, steps of positions that are refused, and warned of
MIN_ATOMS_TO_COMPARE = 10  # fewer may stand still in the precision of a file
BYTES_IN_MEMORY = 2**25  # Frames that need more lie in a temporary file.

# xyz (F, A, 3), Å; time (F,), ps; box (F, 3, 3), Å, or (0, 3, 3)
LabelledPart = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class TrajectoryFrames:
    """Frames of a trajectory."""

    xyz: np.ndarray  # (F, A, 3) float64, Å
    time_ps: np.ndarray  # (F,) float64, ps; nan where the file has no times
    number: np.ndarray  # (F,) int, position in the file, from 0
    box: np.ndarray | None  # (F, 3, 3) float64, Å, lattice vectors as rows; None without a box


def read_first_frame(source: Source, n_atoms: int, topology_path: StrPath) -> np.ndarray:
    """Read the first frame (A, 3), float64, Å; refuse what is no trajectory, or has another number of atoms than the topology."""
    if not source.format.places:
        raise InputError(
            f"{FILE} is no trajectory by its content, and holds no coordinates: give the trajectory of {topology_path}."
        )
    if source.packing and not source.format.text:
        raise InputError(f"{FILE} is compressed, which is not supported for trajectories: uncompress it.")
    if not source.format.text and not source.recognised:
        raise InputError(
            f"{FILE} cannot be read: its first bytes are not those of {source.format.label}; check its name, or copy it again."
        )
    if source.format.name == "xtc":
        check_xtc(source)
    stored, _ = _frames_with_positions(source)
    late = () if stored is None or not stored[0] else stored[:1]
    xyz, _, _ = next(
        iterate_parts(source, n_atoms, FrameSelection(only=np.array(late, int), first=not len(late)))
    )
    if xyz.shape[1] != n_atoms:
        raise InputError(
            f"{FILE} has {xyz.shape[1]} atoms and {topology_path} has {n_atoms}: give the topology that the "
            "trajectory was written with."
        )
    return xyz[0]


def iterate_parts(
    source: Source, n_atoms: int, chosen: FrameSelection = EVERY_FRAME
) -> Iterator[LabelledPart]:
    """Yield frames in parts, Å; a frame that the end of a text file cuts is left out, with a warning."""
    if source.format.text:
        yield from _parts_of_text(source, n_atoms, chosen)
        return
    for xyz, time, box in iterate_frames(source, n_atoms, chosen):
        yield xyz.astype(float) * ANGSTROM_PER_NM, time, box.astype(float) * ANGSTROM_PER_NM


def _parts_of_text(source: Source, n_atoms: int, chosen: FrameSelection) -> Iterator[LabelledPart]:
    """Yield frames of a text file as `iterate_parts` does."""
    only, frames, n_found, number = {*np.asarray(chosen.only).tolist()}, list[TextFrame](), 0, -1
    in_part = max(1, BYTES_OF_A_CHUNK // (24 * n_atoms))
    for number, parse in enumerate(frames_of_text(source, n_atoms)):
        if parse is None:
            if not chosen.first:
                report_cut(number, n_found, chosen.span)
            break
        if not only and chosen.span.stop is not None and number >= chosen.span.stop:
            break
        if number not in (only or range(number + 1)[chosen.span]):
            continue
        frame = parse()
        n_found += 1
        if chosen.first:
            yield frame.xyz[None], np.array([frame.time_ps]), np.empty((0, 3, 3))
            return
        if len(frame.xyz) != n_atoms:
            raise InputError(
                f"{FILE} has {len(frame.xyz)} atoms in frame {number} and {n_atoms} in the first one: give a trajectory of "
                "one molecule."
            )
        frames.append(frame)
        if len(frames) == in_part:
            yield _joined(frames, chosen.atoms)
            frames = []
    if frames:
        yield _joined(frames, chosen.atoms)
    if not n_found and number <= 0:
        report_cut(0, 0, EVERY_FRAME.span) if number >= 0 else None
        raise InputError(f"{FILE} holds no frames: copy it again.")


def _joined(frames: list[TextFrame], atoms: np.ndarray | None) -> LabelledPart:
    """Return frames as one part, with some of their atoms; the box of frames that have none is not a number."""
    no_box = np.full((3, 3), np.nan)
    boxes = np.stack([no_box if frame.box is None else frame.box for frame in frames])
    xyz = np.stack([frame.xyz if atoms is None else frame.xyz[atoms] for frame in frames])
    return xyz, np.array([frame.time_ps for frame in frames]), boxes


def read_frames(
    source: Source,
    n_atoms: int,
    atoms: np.ndarray,
    span: slice,
    times: Sequence[float] | None,
    change: Callable[[np.ndarray, np.ndarray | None, np.ndarray], np.ndarray],
) -> TrajectoryFrames:
    """Read the frames `span` of a trajectory, or the first one and those at `times`, ps; memory does not grow with it.

    Frames that repeat the one before are left out, as readers do with those of TRR that have no positions. `change`
    makes other positions of some (F, A, 3), Å, their boxes (F, 3, 3), or None, and their numbers in the file (F,).
    """
    stored, boxed = _frames_with_positions(source)
    if times is not None:
        time_ps = _times(source, n_atoms, stored)
        number = _frames_at(time_ps, times)
        time_ps, only = time_ps[number], number if stored is None else stored[number]
    elif stored is not None:
        only = stored[span]
    else:
        only = np.empty(0, int)
    order = np.argsort(atoms, kind="stable")
    store, before, n_read = FrameStore(), np.empty((0, 0, 3)), 0
    keep: list[bool] = []
    time_parts: list[np.ndarray] = []
    number_parts: list[np.ndarray] = []
    chosen = FrameSelection(np.asarray(atoms)[order], span, only)
    for raw, time, box in iterate_parts(source, n_atoms, chosen):
        n_read += len(raw)
        xyz = np.empty(raw.shape)
        xyz[:, order] = raw
        moved = _differ_from_before(xyz, before)
        before = xyz[-1:].copy()
        places = len(keep) + np.arange(len(xyz))
        numbers = span.start + span.step * places if times is None else number[places]
        refuse_invalid_coordinates(xyz, numbers)
        cells = box[moved] if len(box) and boxed else None
        xyz = change(xyz[moved], cells, numbers[moved])
        store.append(xyz)
        keep += moved.tolist()
        time_parts.append(time)
        number_parts.append(numbers)
    if times is None:
        if not n_read or (span.step > 1 and n_read == 1):
            check_frames(len(_times(source, n_atoms, stored)), span)
        else:
            _report_end(n_read, span)
        if source.format.name == "dcd" and span.stop is None:
            check_dcd(source, n_atoms, n_read, span)
        time_ps, number = np.concatenate(time_parts), np.concatenate(number_parts)
    xyz = store.frames()
    if n_repeats := len(keep) - len(xyz):
        message = "%s: %s the one before, the first is frame %d: left out"
        log.warning(message, FILE, pluralise(n_repeats, "frame", "repeats"), number[keep.index(False)])
    time_ps, number = time_ps[keep], number[keep]
    if times is None:
        warn_of_repeats(source, xyz, time_ps, number)
    if not source.format.timed or not (np.diff(time_ps) > 0).all():
        time_ps = np.full(len(xyz), np.nan)
    return TrajectoryFrames(xyz, time_ps, number, None)


def _differ_from_before(xyz: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return which frames (F, A, 3) differ from the one before; the first one follows `before`, (1, A, 3) or empty."""
    if xyz.shape[1] < MIN_ATOMS_TO_COMPARE:
        return np.ones(len(xyz), bool)
    repeats = (xyz[1:] == xyz[:-1]).all(axis=(1, 2))
    return ~np.append(len(before) > 0 and np.array_equal(xyz[:1], before), repeats)


def check_frames(n_frames: int, span: slice) -> None:
    """Raise InputError if a file has none of the frames `span`; warn if a stride leaves one of several, or frames are missing."""
    if n_frames <= span.start:
        raise InputError(
            f"{argument('start')}: {FILE} has {pluralise(n_frames, 'frame')}, the first at position 0, and none at {span.start}."
        )
    if 1 < n_frames - span.start <= span.step and span.stop is None:
        message = "%s has %d frames, of which a stride of %d leaves only the first: take a smaller stride"
        log.warning(message, FILE, n_frames, span.step)
    _report_end(len(range(n_frames)[span]), span)


def _report_end(n_read: int, span: slice) -> None:
    """Warn if a file has fewer frames than were asked for."""
    if span.stop is not None and n_read < len(range(span.stop)[span]):
        message = (
            "%s ends before position %d, the requested end: the last frame that is used is at position %d"
        )
        log.warning(message, FILE, span.stop, span.start + span.step * (n_read - 1))


def _times(source: Source, n_atoms: int, stored: np.ndarray | None) -> np.ndarray:
    """Read the times of all frames with positions, ps; nan where the format has none."""
    with no_warnings():  # of what the reading of the frames tells
        time = np.concatenate(
            [part[1] for part in iterate_parts(source, n_atoms, FrameSelection(np.array([0])))]
        )
    time = time if stored is None else time[stored]
    return time if source.format.timed and (np.diff(time) > 0).all() else np.full(len(time), np.nan)


def _frames_at(time_ps: np.ndarray, times: Sequence[float]) -> np.ndarray:
    """Return the numbers of the first frame and of those at some times, ps."""
    distance = np.abs(time_ps[:, None] - np.asarray(times, float)).min(axis=1, initial=np.inf)
    near = distance < TIME_TOLERANCE  # False for nan, of a file without times
    if not near.any():
        log.warning("%s has no frame at any of the requested times: only its first frame is read", FILE)
    return np.flatnonzero(near | (np.arange(len(near)) == 0))


def _frames_with_positions(source: Source) -> tuple[np.ndarray | None, bool]:
    """Return the numbers of the frames of a TRR file that have positions, and whether all these have a box.

    A frame may hold velocities or forces alone. mdtraj returns the positions of the frame before for it, and any numbers
    for a box that is absent. The numbers are None for another format, if all frames have positions, or a header is damaged.
    """
    if source.format.name != "trr":
        return None, True
    numbers, n_frames, offset, boxed = list[int](), 0, 0, True
    size = existing_file(source).stat().st_size
    with Path(source).open("rb") as file:
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

    def __init__(self) -> None:
        self.file, self.n_frames = tempfile.SpooledTemporaryFile(BYTES_IN_MEMORY), 0  # noqa: SIM115

    def append(self, xyz: np.ndarray) -> None:
        """Append frames (F, A, 3)."""
        self.shape, self.n_frames = xyz.shape[1:], self.n_frames + len(xyz)
        try:
            self.file.write(xyz.tobytes())
        except OSError as error:
            raise InputError(
                f"the frames of {FILE} do not fit into {tempfile.gettempdir()} ({error.strerror}): set TMPDIR to another folder."
            ) from None

    def frames(self) -> np.ndarray:
        """Return all frames, float64; those of a file can be read only."""
        shape, n_bytes = (self.n_frames, *self.shape), self.file.tell()
        if n_bytes > BYTES_IN_MEMORY:
            self.file.flush()
            return np.memmap(self.file, float, "r", shape=shape)
        self.file.seek(0)
        return np.frombuffer(bytearray(self.file.read())).reshape(shape)


def report_cut(n_complete: int, n_read: int, span: slice) -> None:
    """Warn that the last frame of a trajectory is truncated; raise InputError if it is the first one."""
    if n_complete == 0:
        raise InputError(f"{FILE} is cut short within its first frame: copy it again.")
    message = "%s is cut short: its incomplete last frame is left out, %d were read (stride %d)"
    log.warning(message, FILE, min(n_read, len(range(n_complete)[span])), span.step)


def warn_of_repeats(source: Source, xyz: np.ndarray, time: np.ndarray, number: np.ndarray) -> None:
    """Warn if a trajectory (F, A, 3) with times (F,), nan where the file has none, and numbers (F,) seems to be written twice."""
    half = len(xyz) // 2
    repeated = all(np.array_equal(xyz[k], xyz[half + k]) for k in range(half))
    if half > 1 and repeated and any((xyz[0] != xyz[k]).any() for k in range(1, half)):
        log.warning("%s: its second half repeats the first; was it written twice?", FILE)
    elif source.format.timed and (np.diff(time) < 0).any():
        frame = int(np.argmax(np.diff(time) < 0)) + 1
        message = "%s: time goes back to %g ps at frame %d; were two trajectories joined?"
        log.warning(message, FILE, time[frame], number[frame])


def check_xtc(source: Source) -> None:
    """Raise InputError if frames of an XTC file have other atoms than the first, or are rounded too coarsely; mdtraj reads on."""
    n_first, number, offset = 0, 0, 0
    size = existing_file(source).stat().st_size
    with Path(source).open("rb") as file:
        while offset + XTC_HEAD <= size:
            file.seek(offset)
            content = file.read(XTC_SIZE + 8).ljust(XTC_SIZE + 8, b"\0")
            magic, n_atoms = XTC_BEGIN.unpack_from(content)
            if magic not in XTC_SIZES or n_atoms <= 0:
                return  # damaged, which its reader tells
            n_first = n_first or n_atoms
            if n_atoms != n_first:
                raise InputError(
                    f"{FILE} has {n_atoms} atoms in frame {number} and {n_first} in the first one: give a trajectory of one "
                    "molecule."
                )
            if n_atoms < MIN_COMPRESSED_ATOMS:
                offset += XTC_HEAD + 12 * n_atoms
            else:
                if number == 0:
                    _check_precision(XTC_PRECISION.unpack_from(content, XTC_HEAD)[0])
                n_bytes = XTC_SIZES[magic].unpack_from(content, XTC_SIZE)[0]
                offset += XTC_SIZE + XTC_SIZES[magic].size + -(-n_bytes // 4) * 4
            number += 1


def _check_precision(precision: float) -> None:
    """Raise InputError if positions are rounded so coarsely that no surface follows from them; or warn."""
    step = ANGSTROM_PER_NM / precision if precision > 0 else 0
    rounded = f"its positions are rounded to {step:g} Å (an XTC precision of {precision:g})"
    if step >= REFUSED_STEP:
        raise InputError(f"{FILE}: {rounded}, too coarse for a surface; write it with a precision of 1000.")
    if step > ROUNDED:
        log.warning("%s: %s", FILE, rounded)


def check_dcd(source: Source, n_atoms: int, n_read: int, span: slice) -> None:
    """Warn if a DCD file holds fewer or more frames than its header says (a killed run, two joined runs)."""
    with Path(source).open("rb") as file:
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
    if n_read < len(range(n_announced)[span]):
        # DIMS and other runs end when they reach their target, so that whole frames alone do not tell that a copy is cut
        n_held = n_read if span == EVERY_FRAME.span else size // frame_bytes
        message = "%s holds %d frames, and its header announces %d: it is cut short, or its run ended earlier"
        log.warning(message, FILE, n_held, n_announced)
    elif n_announced > 0 and size > (n_announced + 0.5) * frame_bytes:
        message = "%s continues after the %d frames that its header announces; was it written twice?"
        log.warning(message, FILE, n_announced)
