"""Compact files of dots: 12 bytes per dot, positions to 0.0025 Å and normals to 0.01 degrees.

A file consists of the text MAGIC, the CRC-32 of the rest (uint32), the lowest corner as three float64 (Å), then a uint64
and two int16 per dot, all little-endian. The uint64 holds x, y and z above the corner in steps of STEP, 21 bits each from
the lowest on. The two int16 are the normal on an octahedron unfolded to a square (Meyer et al., Computer Graphics Forum
29:1405, 2010).
"""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np

from sparsurf import InputError
from sparsurf.surfaces.surface import Format, Surface, surface_of_columns

MAGIC = b"sparsurf minimal 1\n"
HEADER_BYTES = len(MAGIC) + 4
CORNER_BYTES = 24
STEP = 0.005  # Å
BITS_PER_COORDINATE = 21  # 10 µm, more than any molecule
MAX_INT16 = 32767
DOT = np.dtype([("position", "<u8"), ("normal", "<i2", 2)])


def write_compact(path: Path | str, surface: Surface) -> None:
    """Write the positions and normals of a surface, and nothing else.

    Parameters
    ----------
    path : file to write
    surface : Surface

    Raises
    ------
    InputError
        The surface is wider than the integers can hold.
    """
    low = surface.points.min(axis=0)
    steps = np.rint((surface.points - low) / STEP)
    if steps.max() >= 2**BITS_PER_COORDINATE:
        raise InputError(f"surface: it is wider than {2**BITS_PER_COORDINATE * STEP:.0f} Å; write it as npz.")
    dots = np.empty(len(surface), DOT)
    x, y, z = steps.astype(np.uint64).T
    dots["position"] = x | y << np.uint64(BITS_PER_COORDINATE) | z << np.uint64(2 * BITS_PER_COORDINATE)
    dots["normal"] = np.rint(MAX_INT16 * _fold_to_square(surface.normals))
    rest = low.astype("<f8").tobytes() + dots.tobytes()
    with open(path, "wb") as stream:
        stream.write(MAGIC + zlib.crc32(rest).to_bytes(4, "little") + rest)


def read_compact(content: bytes, path: Path | str) -> Surface:
    """Read a surface from the bytes of a compact file.

    Parameters
    ----------
    content : bytes of the file, unpacked
    path : named in messages

    Returns
    -------
    Surface

    Raises
    ------
    InputError
        The file is damaged, or of another version.
    """
    rest = content[HEADER_BYTES:]
    if not content.startswith(MAGIC):
        raise InputError(f"{path} is of another version of this program: write it again, or update sparsurf.")
    complete = len(rest) >= CORNER_BYTES and (len(rest) - CORNER_BYTES) % DOT.itemsize == 0
    if not complete or zlib.crc32(rest) != int.from_bytes(content[len(MAGIC) : HEADER_BYTES], "little"):
        raise InputError(f"{path} is cut short or damaged: copy it again.")
    dots = np.frombuffer(rest, DOT, offset=CORNER_BYTES)
    mask = np.uint64(2**BITS_PER_COORDINATE - 1)
    shifts = [np.uint64(k * BITS_PER_COORDINATE) for k in range(3)]
    steps = np.column_stack([dots["position"] >> shift & mask for shift in shifts])
    points = np.frombuffer(rest, "<f8", 3) + STEP * steps
    normals = _unfold_from_square(dots["normal"] / MAX_INT16)
    return surface_of_columns({"points": points, "normals": normals}, path)


def _fold_to_square(normals: np.ndarray) -> np.ndarray:
    """Map unit vectors (N, 3) to the square [-1, 1]^2, (N, 2)."""
    flat = normals / np.abs(normals).sum(axis=1, keepdims=True)
    below = (1 - np.abs(flat[:, 1::-1])) * _signs(flat[:, :2])
    return np.where(flat[:, 2:] >= 0, flat[:, :2], below)


def _unfold_from_square(square: np.ndarray) -> np.ndarray:
    """Map points of the square (N, 2) to unit vectors (N, 3)."""
    height = 1 - np.abs(square).sum(axis=1)
    below = (1 - np.abs(square[:, ::-1])) * _signs(square)
    vectors = np.column_stack([np.where(height[:, None] >= 0, square, below), height])
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _signs(values: np.ndarray) -> np.ndarray:
    """Return 1 for values of at least 0, else -1."""
    return np.where(values >= 0, 1.0, -1.0)


def _sniff(head: bytes) -> bool:
    """Return whether the file begins as a compact file of any version."""
    return head.startswith(MAGIC[:-2])


FORMAT = Format("compact", (".minimal",), _sniff, read_compact, write_compact)
