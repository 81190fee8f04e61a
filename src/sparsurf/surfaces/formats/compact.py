"""Compact files of dots: 12 bytes for each, places to 0.0025 Å and normals to 0.01 degrees.

A file is the text MAGIC, the CRC-32 of the rest (uint32), the lowest corner as three float64 (Å), then a uint64 and two int16
for each dot, all little-endian.
The integer holds x, y and z above the corner in steps of STEP, 21 bits each from the lowest on. The two int16 are the normal
on an octahedron unfolded to a square (Meyer et al., Computer Graphics Forum 29:1405, 2010).
"""

import zlib

import numpy as np

from sparsurf import InputError
from sparsurf.surfaces.surface import Format, surface_of_columns

MAGIC = b"sparsurf minimal 1\n"
HEAD = len(MAGIC) + 4
STEP = 0.005  # Å
BITS = 21  # for each coordinate: 10 µm, more than any molecule
FULL = 32767  # largest int16
DOT = np.dtype([("place", "<u8"), ("normal", "<i2", 2)])


def write_compact(path, surface):
    """Write the places and normals of a Surface; nothing else of it is kept.

    Raises
    ------
    InputError : a surface wider than the integers can tell
    """
    low = surface.points.min(axis=0)
    steps = np.rint((surface.points - low) / STEP)
    if steps.max() >= 2**BITS:
        raise InputError(f"surface: it is wider than {2**BITS * STEP:.0f} Å; write it as npz.")
    dots = np.empty(len(surface), DOT)
    x, y, z = steps.astype(np.uint64).T
    dots["place"] = x | y << np.uint64(BITS) | z << np.uint64(2 * BITS)
    dots["normal"] = np.rint(FULL * _folded(surface.normals))
    rest = low.astype("<f8").tobytes() + dots.tobytes()
    with open(path, "wb") as stream:
        stream.write(MAGIC + zlib.crc32(rest).to_bytes(4, "little") + rest)


def read_compact(content, path):
    """Surface of the bytes of such a file."""
    rest = content[HEAD:]
    if not content.startswith(MAGIC):
        raise InputError(f"{path} is of another version of this program: write it again, or update sparsurf.")
    whole = len(rest) >= 24 and (len(rest) - 24) % DOT.itemsize == 0
    if not whole or zlib.crc32(rest) != int.from_bytes(content[len(MAGIC) : HEAD], "little"):
        raise InputError(f"{path} is cut short or damaged: copy it again.")
    dots = np.frombuffer(rest, DOT, offset=24)
    mask = np.uint64(2**BITS - 1)
    steps = np.column_stack([dots["place"] >> np.uint64(k * BITS) & mask for k in range(3)])
    points = np.frombuffer(rest, "<f8", 3) + STEP * steps
    normals = _unfolded(dots["normal"] / FULL)
    return surface_of_columns({"points": points, "normals": normals}, path)


def _folded(normals):
    """Unit vectors (N, 3) on the square [-1, 1]^2, (N, 2)."""
    flat = normals / np.abs(normals).sum(axis=1, keepdims=True)
    below = (1 - np.abs(flat[:, 1::-1])) * _signs(flat[:, :2])
    return np.where(flat[:, 2:] >= 0, flat[:, :2], below)


def _unfolded(square):
    """The unit vectors (N, 3) of places on the square (N, 2)."""
    height = 1 - np.abs(square).sum(axis=1)
    below = (1 - np.abs(square[:, ::-1])) * _signs(square)
    vectors = np.column_stack([np.where(height[:, None] >= 0, square, below), height])
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _signs(values):
    return np.where(values >= 0, 1.0, -1.0)


def _sniff(head):
    return head.startswith(MAGIC[:-2])


FORMAT = Format("compact", (".minimal",), _sniff, read_compact, write_compact)
