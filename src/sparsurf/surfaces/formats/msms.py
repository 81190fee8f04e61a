"""Files of the program MSMS: vertices (.vert), triangles (.face) and areas of atoms (.area).

Their columns are those that MSMS 2.6.1 writes. Numbers of vertices, spheres and faces count from 1, and atoms in .area from 0.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.files import decode_text, shorten
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE, Surface, SurfaceFormat, surface_of_columns

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# Codes of MSMS for the kinds CONTACT, SADDLE and CONCAVE: the level of a vertex and the type of a triangle
LEVEL = np.array([1, 2, 3])
FACE_TYPE = np.array([1, 3, 2])
KIND_OF_LEVEL = {1: CONTACT, 2: SADDLE, 3: CONCAVE}
N_VERTEX_COLUMNS = 9  # and the name of the sphere, if there is one
THREE_DECIMALS = r"[+-]?\d+\.\d{3}"
VERTEX = re.compile(rf"^\s*(?:{THREE_DECIMALS}\s*){{6}}\s-?\d+\s+\d+\s+[123](?:[ \t]\S+)?\s*$", re.M)


class Header(NamedTuple):
    """What the first three lines of a file say besides the numbers of vertices or triangles and of spheres."""

    name: str  # of the file of spheres
    density: float  # vertices per Å^2
    probe: float  # Å, radius


def _number(word: str) -> float | None:
    """Return a word as a number, or None."""
    try:
        return float(word)
    except ValueError:
        return None


def _sniff(head: bytes) -> bool:
    """Return whether a line of the first ones is a vertex of MSMS."""
    text = head.decode("latin-1")
    return VERTEX.search(text, 0, len(text)) is not None and text[:1] not in "p{<"


def read_vertices(content: bytes) -> Surface:
    """Read the vertices of MSMS as dots; `atom` counts the spheres, from 0."""
    rows: list[list[float]] = []
    lines: list[int] = []
    n_announced = None
    for number, line in enumerate(decode_text(content).split("\n"), 1):
        if line.startswith("#") or not line.strip():
            continue
        texts = line.split()
        if not lines and len(texts) in (2, 4):  # vertices, spheres, density and probe radius
            n_announced = _number(texts[0])
            continue
        values = [_number(word) for word in texts[:N_VERTEX_COLUMNS]]
        if len(values) < N_VERTEX_COLUMNS or None in values or values[8] not in KIND_OF_LEVEL:
            raise InputError(
                f"{FILE}: line {number} is not a vertex with position, normal, face, sphere and level: "
                f"{shorten(repr(line.strip()))}; repair it."
            )
        rows.append([float(value or 0) for value in values])
        lines.append(number)
    if n_announced is not None and len(rows) != n_announced:
        raise InputError(
            f"{FILE} has {len(rows)} vertices and announces {n_announced:.0f}: it is cut short or was edited; copy it again."
        )
    table = np.array(rows, float).reshape(-1, N_VERTEX_COLUMNS)
    kind = [KIND_OF_LEVEL[int(level)] for level in table[:, 8]]
    columns: dict[str, ArrayLike] = {
        "points": table[:, :3],
        "normals": table[:, 3:6],
        "kind": kind,
        "atom": table[:, 7] - 1,
    }
    return surface_of_columns(columns, lines, weighted=True)


def write_vertices(
    path: Path | str,
    surface: Surface,
    faces: np.ndarray,
    n_spheres: int,
    names: Sequence[str] | None = None,
    header: Header | None = None,
) -> None:
    """Write the vertices of a mesh, or dots, with the names (A,) of their spheres where these are known.

    `faces` (N,) are the numbers of their analytical faces. Without a `header`, the file begins with the first vertex.
    """
    face = np.where(surface.kind == SADDLE, -1, 1) * faces
    last = np.array([f" {name}" if name else "" for name in names or [""] * n_spheres])[surface.atom]
    numbers = *surface.points.T, *surface.normals.T, face, surface.atom + 1, LEVEL[surface.kind], last
    with open(path, "w", encoding="ascii", errors="replace") as stream:
        if header is not None:
            stream.write(_comments("vertices", header) + "#vertex #sphere density probe_r\n")
            stream.write(f"{len(surface):7d} {n_spheres:7d} {header.density:5.2f} {header.probe:5.2f}\n")
        # a row as a whole: the numbers one by one take four times as long
        row = " ".join(["%9.3f"] * 6 + ["%7d", "%7d", "%2d%s\n"])
        stream.writelines(
            row % values for values in zip(*(column.tolist() for column in numbers), strict=True)
        )


def write_faces(
    path: Path | str,
    surface: Surface,
    faces: np.ndarray,
    triangles: np.ndarray,
    n_spheres: int,
    header: Header | None = None,
) -> None:
    """Write triangles (F, 3) between the vertices of a surface, turned outwards; the rest is that of `write_vertices`."""
    kinds = np.sort(surface.kind[triangles], axis=1)
    # The kind of at least two corners; where all three differ, the saddle, which lies between the others
    kind = kinds[:, 1]
    corner = np.argmax(surface.kind[triangles] == kind[:, None], axis=1)
    face = faces[triangles[np.arange(len(triangles)), corner]]
    with open(path, "w", encoding="ascii") as stream:
        if header is not None:
            stream.write(_comments("faces", header) + "#faces  #sphere density probe_r\n")
            stream.write(f"{len(triangles):7d} {n_spheres:7d} {header.density:5.2f} {header.probe:5.2f}\n")
        row = " ".join(["%6d"] * 3 + ["%2d", "%6d\n"])
        columns = *(triangles.T + 1), FACE_TYPE[kind], face
        stream.writelines(
            row % values for values in zip(*(column.tolist() for column in columns), strict=True)
        )


def write_areas(
    path: Path | str, areas: Sequence[tuple[np.ndarray, np.ndarray]], names: Sequence[str]
) -> None:
    """Write the area of the excluded and of the accessible surface, (A,) each, Å^2, of the atoms in each component."""
    heads = "   ".join(f"ses_{k}   sas_{k}" for k in range(len(areas)))
    with open(path, "w", encoding="ascii", errors="replace") as stream:
        stream.write(f" Atom#    {heads}  \n")
        for atom, name in enumerate(names):
            columns = " ".join(f"{ses[atom]:7.4f} {sas[atom]:7.4f} {name}" for ses, sas in areas)
            stream.write(f"{atom:6d} {columns}\n")


def _comments(kind: str, header: Header) -> str:
    """Return the first line of a file; readers tell it from a vertex by its eight words."""
    return f"# MSMS solvent excluded surface {kind} for {name_in_header(header.name)}\n"


def name_in_header(name: str) -> str:
    """Return the name of a file as the header has it: one word."""
    return re.sub(r"[^!-~]", "_", name)


FORMAT = SurfaceFormat(_sniff, read_vertices)
