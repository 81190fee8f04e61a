"""PLY files: meshes whose vertices are the dots, with values and colours for viewers.

Of a file by another program, the vertices are read.
"""

from __future__ import annotations

import codecs
import logging
from collections.abc import Mapping
from contextlib import suppress
from itertools import chain, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.surfaces.formats.colours import KIND_COLOURS, Scale
from sparsurf.surfaces.surface import (
    Reconstruction,
    Surface,
    SurfaceFormat,
    is_field_name,
    surface_of_columns,
    warn_of_field_names,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")

AXES, COLOUR_CHANNELS = ("x", "y", "z", "nx", "ny", "nz"), ("red", "green", "blue")
BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"}
PLY_TYPES |= {f"{name}{8 * size}": f"{name[0]}{size}" for name in ("int", "uint") for size in (1, 2, 4)}
PLY_TYPES |= {"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"}
Element = tuple[str, int, list[tuple[str, ...]]]  # name, number, name and types of each property
SAID = "sparsurf"  # first word of the comment that says how the surface is reconstructed
MAX_DIGITS_OF_COUNT = 12  # A longer number of vertices in a header is damaged.


def write_ply(
    path: Path | str,
    surface: Surface,
    scale: Scale | None = None,
    columns: Mapping[str, ArrayLike] | None = None,
    faces: np.ndarray | None = None,
    coloured: bool = True,
) -> None:
    """Write a PLY file of the dots, in their order: a point cloud, or a mesh with triangles `faces` (F, 3) between them.

    The values of the `scale` are a property and its colours; without it, the colours show contact (blue), saddle (orange) and
    concave (green) dots. `columns` are further properties, (N,) by name; integers stay such.
    Unless `coloured`, there are no colours, and all properties are floats: readers of meshes for networks take no other.
    """
    raw = ({} if scale is None else {scale.name: scale.values}) | dict(columns or {})
    integers = [key for key, column in raw.items() if np.asarray(column).dtype.kind in "iu"]
    properties = {key: np.asarray(column, float) for key, column in raw.items()}
    for key, column in properties.items():
        if len(column) != len(surface):
            raise InputError(f"surface: {len(column)} values of {key} for {len(surface)} dots.")
    colours = KIND_COLOURS[surface.kind] if scale is None else scale.colours
    table = dict(zip(AXES, np.hstack([surface.points, surface.normals]).T, strict=True))
    types = dict.fromkeys([*AXES, *properties], "float")
    if coloured:
        table |= dict(zip(COLOUR_CHANNELS, colours.T, strict=True))
        types = dict.fromkeys([*AXES, *COLOUR_CHANNELS], "float") | types
        types |= dict.fromkeys(COLOUR_CHANNELS, "uchar") | dict.fromkeys(integers, "int")
    table |= properties
    comments = _comments(surface) + ([scale.comment] if scale else [])
    header = ["ply", "format ascii 1.0", *comments, f"element vertex {len(surface)}"]
    header += [f"property {kind} {key}" for key, kind in types.items()]
    if faces is not None:
        header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    _write_text(
        path, [*header, "end_header"], table, integers, np.empty((0, 3), int) if faces is None else faces
    )


def _comments(surface: Surface) -> list[str]:
    """Return the line of the header that says how the surface is reconstructed from the dots, if that is known."""
    reconstruction = surface.reconstruction
    if reconstruction is None:
        return []
    return [
        f"comment {SAID} {' '.join(f'{name} {value}' for name, value in reconstruction.columns.items() if value != '')}"
    ]


def _reconstruction(header: str) -> Reconstruction | None:
    """Return what such a line says."""
    for texts in (line.split() for line in header.splitlines()):
        if texts[:2] == ["comment", SAID]:
            values: dict[str, Any] = dict(zip(texts[2::2], texts[3::2], strict=False))
            with suppress(KeyError, ValueError):
                values["probe_radius"] = float(values["probe_radius"])
            return Reconstruction.of_columns({name: [value] for name, value in values.items()})
    return None


def _write_text(
    path: Path | str, header: list[str], table: dict[str, np.ndarray], integers: list[str], faces: np.ndarray
) -> None:
    """Write header, vertices and triangles as text."""
    formats = dict.fromkeys(table, "%.6g") | dict.fromkeys(AXES, "%.4f")
    formats |= dict.fromkeys([key for key in (*COLOUR_CHANNELS, *integers) if key in table], "%d")
    row = " ".join(formats.values())
    with open(path, "w", encoding="ascii", newline="\n") as stream:
        stream.write("\n".join(header) + "\n")
        columns = (column.tolist() for column in table.values())
        stream.writelines(f"{row % values}\n" for values in zip(*columns, strict=True))
        stream.writelines(f"3 {a} {b} {c}\n" for a, b, c in faces.tolist())


def read_ply(content: bytes) -> Surface:
    """Read the vertices of a PLY file (G. Turk, 1994), text or binary, with their normals and fields; triangles are ignored.

    This reader is not `plyfile`, since it accepts a byte-order mark and damaged triangles, and names what is wrong.
    """
    header, _, body = content.partition(b"end_header")
    byte_order, elements = _parse_header(header.decode("latin-1"))
    *before, (_, n, properties) = elements
    names = [name for name, *_ in properties]
    wrong = [axis for axis in AXES if names.count(axis) != 1]
    if wrong:
        raise InputError(
            f"{FILE} needs one {wrong[0]} of every vertex; its vertices must have x, y, z, nx, ny, nz."
        )
    try:
        if byte_order:
            body = _bytes_after(body[body.index(b"\n") + 1 :], byte_order, before)
            columns, has_more = _binary_columns(body, byte_order, n, [types[0] for _, *types in properties])
        else:
            texts = body.split(None, -1 if before else n * len(names))
            texts = texts[_count_words(texts, before) :]
            has_more = len(texts) > n * len(names)
            columns = list(np.array(texts[: n * len(names)], float).reshape(n, len(names)).T)
    except (ValueError, IndexError):
        raise InputError(f"{FILE} is cut short or damaged: its {n} vertices cannot be read.") from None
    if header.count(b"\nelement vertex ") > 1:
        raise InputError(f"{FILE} holds several lists of vertices: give a file with one.")
    if has_more and header.count(b"\nelement ") == 1:
        raise InputError(f"{FILE} holds more than the {n} vertices that its header announces: copy it again.")
    table = dict(zip(names, columns, strict=True))
    points = np.column_stack([table[axis] for axis in AXES[:3]])
    normals = np.column_stack([table[axis] for axis in AXES[3:]])
    warn_of_field_names(table)
    fields = {name: column for name, column in table.items() if is_field_name(name)}
    fields |= {"points": points, "normals": normals} | {k: v for k, v in table.items() if k == "area"}
    reconstruction = _reconstruction(header.decode("latin-1"))
    return surface_of_columns(fields, None, "weight" in table, reconstruction=reconstruction)


def _binary_columns(body: bytes, byte_order: str, n: int, types: list[str]) -> tuple[list[np.ndarray], bool]:
    """Return the properties of n vertices, and whether another vertex fits into the rest; ValueError if cut short."""
    row = np.dtype([(str(k), byte_order + kind) for k, kind in enumerate(types)])
    table = np.frombuffer(body, row, n)
    with np.errstate(invalid="ignore"):
        columns = [table[str(k)].astype(float) for k in range(len(types))]
    return columns, len(body) >= (n + 1) * row.itemsize


def _bytes_after(body: bytes, byte_order: str, elements: list[Element]) -> bytes:
    """Return the bytes after some elements; ValueError or IndexError if they are cut short."""
    offset = 0
    for _, n, properties in elements:
        types = [[np.dtype(byte_order + kind) for kind in kinds] for _, *kinds in properties]
        if all(len(kinds) == 1 for kinds in types):
            offset += n * sum(kinds[0].itemsize for kinds in types)
            continue
        for kinds in chain.from_iterable(repeat(types, n)):  # a list begins with its length
            length = int(np.frombuffer(body, kinds[0], 1, offset)[0]) if len(kinds) > 1 else 0
            offset += kinds[0].itemsize + max(0, length) * kinds[-1].itemsize
    return body[offset:]


def _count_words(texts: list[bytes], elements: list[Element]) -> int:
    """Count the words of some elements; ValueError or IndexError if they are cut short."""
    position = 0
    for _, n, properties in elements:
        lists = [len(kinds) > 1 for _, *kinds in properties]
        if not any(lists):
            position += n * len(lists)
            continue
        for is_list in chain.from_iterable(repeat(lists, n)):
            length = int(texts[position]) if is_list else 0  # IndexError where they end
            position += 1 + max(0, length)
            if position > len(texts):
                raise ValueError
    return position


def _parse_header(text: str) -> tuple[str, list[Element]]:
    """Return the byte order (empty: text), and the elements up to the vertices."""
    byte_order, elements = None, list[Element]()
    is_readable = True
    for texts in (line.split() for line in text.splitlines()):
        if texts[:1] == ["format"] and texts[1:2] and texts[1] in BYTE_ORDERS:
            byte_order = BYTE_ORDERS[texts[1]]
        elif texts[:1] == ["element"] and len(texts) == 3 and _is_count(texts[2]):
            if elements and elements[-1][0] == "vertex":
                break
            elements.append((texts[1], int(texts[2]), []))
        elif texts[:1] == ["property"] and len(texts) > 2 and elements:
            kinds = texts[2:-1] if texts[1] == "list" else texts[1:2]
            is_readable &= bool(kinds) and all(kind in PLY_TYPES for kind in kinds)
            name = texts[-1].lower() if texts[-1].lower() in AXES else texts[-1]
            elements[-1][2].append((name, *(PLY_TYPES.get(kind, "") for kind in kinds)))
    vertices = elements[-1][2] if elements and elements[-1][0] == "vertex" else []
    if byte_order is None or not is_readable or not vertices or any(len(kinds) > 1 for _, *kinds in vertices):
        raise InputError(
            f"{FILE} is no PLY file that can be read: vertex properties must be scalars, not lists."
        )
    return byte_order, elements


def _is_count(word: str) -> bool:
    """Return whether a word is a number of vertices or faces that a file can have."""
    return word.isdecimal() and len(word) <= MAX_DIGITS_OF_COUNT


def _sniff(head: bytes) -> bool:
    """Return whether the file begins with 'ply', after a byte-order mark or empty lines."""
    return head.removeprefix(codecs.BOM_UTF8).lstrip().startswith(b"ply")


FORMAT = SurfaceFormat(_sniff, read_ply)
