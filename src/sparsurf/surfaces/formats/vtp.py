"""VTP files: triangles with numbers at their corners, as VTK, PyVista and ParaView read them; only written."""

import base64

import numpy as np

from sparsurf.surfaces.formats.ply import triangles
from sparsurf.surfaces.surface import Format

TYPES = {"f": ("Float32", "<f4"), "i": ("Int32", "<i4"), "u": ("Int32", "<i4")}


def write_vtp(path, surface, columns=None, faces=None):
    """Write a VTP file whose points are the dots, in their order.

    Parameters
    ----------
    path : file to write
    surface : Surface
    columns : dict, name -> (N,) numbers
    faces : (F, 3) triangles between the dots; computed where they are not known
    """
    faces = triangles(surface) if faces is None else faces
    numbers = {"Normals": surface.normals} | {
        name: np.asarray(each) for name, each in (columns or {}).items()
    }
    ends = 3 * np.arange(1, len(faces) + 1)
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
        f'<PolyData><Piece NumberOfPoints="{len(surface)}" NumberOfPolys="{len(faces)}">\n'
        f'<PointData Normals="Normals">\n{"".join(_array(*each) for each in numbers.items())}</PointData>\n'
        f"<Points>\n{_array('Points', surface.points)}</Points>\n"
        f"<Polys>\n{_array('connectivity', faces.ravel())}{_array('offsets', ends)}</Polys>\n"
        "</Piece></PolyData>\n</VTKFile>\n"
    )
    with open(path, "w", encoding="ascii", newline="\n") as stream:
        stream.write(text)


def _array(name, values):
    """One array in base64, its number of bytes before it."""
    words, kind = TYPES[values.dtype.kind]
    content = np.ascontiguousarray(values, kind).tobytes()
    packed = base64.b64encode(np.uint64(len(content)).tobytes() + content).decode()
    components = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
    return f'<DataArray type="{words}" Name="{name}"{components} format="binary">{packed}</DataArray>\n'


FORMAT = Format("VTP", (".vtp",), lambda head: False, write=write_vtp)
