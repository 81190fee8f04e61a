"""Meshes for viewers and other programs: OBJ, glTF (.glb) and STL by trimesh, and VTK's PolyData (.vtp)."""

from __future__ import annotations

import base64
import importlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sparsurf.errors import InputError

BY_TRIMESH = (".obj", ".glb", ".stl")
VTK_TYPES = {"f": ("Float32", np.float32), "i": ("Int32", np.int32), "u": ("UInt8", np.uint8)}
VTP = """\
<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<PolyData>
<Piece NumberOfPoints="{n}" NumberOfVerts="{n_verts}" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{n_polys}">
<PointData Normals="normals">
{arrays}
</PointData>
<Points>
{points}
</Points>
<{cells}>
{connectivity}
{offsets}
</{cells}>
</Piece>
</PolyData>
</VTKFile>
"""


def import_trimesh(path: Path | str) -> Any:
    """Return the package that writes meshes of a suffix; raise InputError, which names the file, if it is not installed."""
    try:
        return importlib.import_module("trimesh")
    except ImportError:
        raise InputError(
            f"{path}: {Path(path).suffix} files are written by trimesh, which is not installed: run pip install trimesh, "
            "or name a .ply, .vtp or .npz file."
        ) from None


def write_by_trimesh(
    path: Path | str,
    points: np.ndarray,
    normals: np.ndarray,
    triangles: np.ndarray,
    colours: np.ndarray | None = None,
) -> None:
    """Write a mesh of vertices (V, 3), Å, with normals (V, 3) and colours (V, 3) uint8, in the format of the suffix."""
    trimesh = import_trimesh(path)
    mesh = trimesh.Trimesh(points, triangles, vertex_normals=normals, vertex_colors=colours, process=False)
    suffix = Path(path).suffix.lower().removeprefix(".")
    options = {"include_normals": True} if suffix in ("obj", "glb") else {}
    content = mesh.export(file_type=suffix, **options)
    Path(path).write_bytes(content.encode() if isinstance(content, str) else content)


def write_vtp(
    path: Path | str,
    points: np.ndarray,
    normals: np.ndarray,
    columns: Mapping[str, np.ndarray],
    triangles: np.ndarray | None = None,
) -> None:
    """Write dots or a mesh for VTK, ParaView and PyVista, with numbers (N,) by name at the points."""
    n = len(points)
    cells = np.arange(n)[:, None] if triangles is None else triangles
    arrays = {"normals": normals.astype(float)} | {
        str(name): np.asarray(column) for name, column in columns.items()
    }
    text = VTP.format(
        n=n,
        n_verts=n if triangles is None else 0,
        n_polys=0 if triangles is None else len(triangles),
        arrays="\n".join(_array(name, values) for name, values in arrays.items()),
        points=_array("points", points),
        cells="Verts" if triangles is None else "Polys",
        connectivity=_array("connectivity", cells.ravel()),
        offsets=_array("offsets", cells.shape[1] * np.arange(1, len(cells) + 1)),
    )
    Path(path).write_text(text, encoding="utf-8")


def _array(name: str, values: np.ndarray) -> str:
    """Return an array as an element of XML: its length in bytes and its numbers, in base64."""
    from xml.sax.saxutils import quoteattr  # here: it loads the modules of the network

    kind, dtype = VTK_TYPES[values.dtype.kind]
    content = np.ascontiguousarray(values, np.dtype(dtype).newbyteorder("<")).tobytes()
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
    encoded = base64.b64encode(np.uint64(len(content)).astype("<u8").tobytes() + content).decode()
    return f'<DataArray type="{kind}" Name={quoteattr(name)}{width} format="binary">{encoded}</DataArray>'
