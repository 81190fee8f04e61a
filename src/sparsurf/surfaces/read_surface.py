"""Read a surface from a file of any supported format."""

from __future__ import annotations

import codecs
from pathlib import Path

import numpy as np

from sparsurf import registry
from sparsurf.arguments import public
from sparsurf.errors import FILE, InputError, naming_file
from sparsurf.files import decode_text, read_bytes
from sparsurf.surfaces.formats import csv
from sparsurf.surfaces.surface import Surface, SurfaceFormat

BYTES_TO_RECOGNISE = 100_000  # A format is recognised by so much of the start of a file.


@public()
def read_surface(path: Path | str) -> Surface:
    """Read the dots of a surface from a file.

    Parameters
    ----------
    path : str or Path
        A DMS file with normals, a CSV with x, y, z, nx, ny, nz, a PLY whose vertices are the dots, the vertices of MSMS (.vert),
        or an npz that `write` wrote; each also compressed (.gz). The content and not the name of the file determines its
        format.

    Returns
    -------
    Surface
        The dots in the order of the file, in Å. Of dots that occur twice the first one is kept, and normals are scaled to
        length 1.

    Raises
    ------
    InputError
        The file has another format, no dots or no normals, numbers that are not finite, or normals of length 0.

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.read_surface("protein.dms")  # doctest: +SKIP
    >>> dots.points, dots.normals, dots.area  # doctest: +SKIP
    """
    with naming_file(path):
        content, surface_format = _recognised(path)
        return surface_format.read(content)


def read_points(path: Path | str) -> np.ndarray:
    """Read points (T, 3), Å, from a CSV with x, y, z or from a file of dots, whose content determines the format."""
    with naming_file(path):
        content, surface_format = _recognised(path)
        if surface_format is csv.FORMAT:
            return csv.read_points_of_csv(content)
        return surface_format.read(content).points


def _recognised(path: Path | str) -> tuple[bytes, SurfaceFormat]:
    """Return the unpacked bytes of a file of dots, and its format."""
    content = read_bytes(path)
    for name in registry.formats_read():
        surface_format = _format_of(name, path)
        if surface_format.sniff(content[:BYTES_TO_RECOGNISE]):
            return content, surface_format
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        decode_text(content)  # which refuses it
    raise InputError(
        f"{FILE} holds no dots; give a DMS file, a CSV with x,y,z,nx,ny,nz, a PLY, a .vert of MSMS or an npz. The command "
        "`sparsurf surface` places dots on a structure."
    )


def _format_of(name: str, path: Path | str) -> SurfaceFormat:
    """Return the format of a name: how its files are recognised and read; a user's function is told the path as well."""
    choice, found = registry.load("format", name, "format")
    if isinstance(found, SurfaceFormat):
        return found
    assert choice.sniff is not None  # `register` asks for it

    def read(content: bytes) -> Surface:
        dots = found(content, path)
        if not isinstance(dots, Surface):
            raise InputError(
                f"the surface format {name!r} returns a {type(dots).__name__}; it must return a Surface."
            )
        return dots

    return SurfaceFormat(choice.sniff, read)
