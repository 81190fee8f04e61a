"""VTP files for VTK, PyVista and ParaView: triangles with values at their corners. They are only written."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.surfaces.surface import Format, Surface
from sparsurf.surfaces.triangulation import triangulate

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

VTK_TYPES = {"f": ("Float32", "<f4"), "i": ("Int32", "<i4"), "u": ("Int32", "<i4")}


def write_vtp(
    path: Path | str,
    surface: Surface,
    columns: Mapping[str, ArrayLike] | None = None,
    faces: np.ndarray | None = None,
) -> None:
    """Write a VTP file whose points are the dots, in their order.

    Parameters
    ----------
    path : file to write
    surface : Surface
    columns : dict, name -> (N,) numbers
    faces : (F, 3) triangles between the dots; computed if they are not known
    """
    faces = triangulate(surface) if faces is None else faces
    arrays = {name: np.asarray(values) for name, values in (columns or {}).items()}
    arrays = {"Normals": surface.normals} | arrays
    offsets = 3 * np.arange(1, len(faces) + 1)
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
        f'<PolyData><Piece NumberOfPoints="{len(surface)}" NumberOfPolys="{len(faces)}">\n'
        f'<PointData Normals="Normals">\n{"".join(_data_array(*item) for item in arrays.items())}</PointData>\n'
        f"<Points>\n{_data_array('Points', surface.points)}</Points>\n"
        f"<Polys>\n{_data_array('connectivity', faces.ravel())}{_data_array('offsets', offsets)}</Polys>\n"
        "</Piece></PolyData>\n</VTKFile>\n"
    )
    with open(path, "w", encoding="ascii", newline="\n") as stream:
        stream.write(text)


def _data_array(name: str, values: np.ndarray) -> str:
    """Format one array in base64 after its number of bytes."""
    vtk_type, dtype = VTK_TYPES[values.dtype.kind]
    content = np.ascontiguousarray(values, dtype).tobytes()
    encoded = base64.b64encode(np.uint64(len(content)).tobytes() + content).decode()
    components = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
    return f'<DataArray type="{vtk_type}" Name="{name}"{components} format="binary">{encoded}</DataArray>\n'


FORMAT = Format("VTP", (".vtp",), lambda head: False, write=write_vtp)
