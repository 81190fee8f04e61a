"""Whether a trajectory in a text format ends within a frame: its readers pass over a torn one in silence."""

from pathlib import Path

BESIDE_ATOMS = {".xyz": 2, ".lammpstrj": 9, ".gro": 3}  # lines of a frame beside those of its atoms
MDCRD = (
    ".mdcrd",
    ".crd",
)  # below a title, ten numbers of eight characters on a line, a frame and its box apart
NUMBERS, WIDTH = 10, 8
CHUNK = 2**24  # bytes read at once


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
