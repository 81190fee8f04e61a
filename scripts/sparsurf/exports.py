"""Surfaces for other programs: PLY meshes with values and colours, DMS files."""

import gzip

import numpy as np
from matplotlib import colormaps
from scipy.spatial import Delaunay, QhullError, cKDTree

from sparsurf import InputError

KIND_COLOURS = np.array([[86, 180, 233], [230, 159, 0], [0, 158, 115], [160, 160, 160]], np.uint8)
GREY = np.array([160, 160, 160], np.uint8)
DMS_TYPES = np.array(["SC0", "SS0", "SR0"])
WIDEST_FACE = 1.6  # circumradius of a triangle in units of the median distance between nearest dots
MANY_DOTS = 500_000  # beyond which the triangles would take minutes


def write_ply(path, surface, values=None, name="roughness", columns=None):
    """Write a binary PLY mesh whose vertices are the dots, in their order.

    Parameters
    ----------
    path : file to write
    surface : Surface
    values : (N,), shown as colours (viridis from the smallest to the largest, grey for NaN) and as a float
        property; without them the colours tell contact (blue), saddle (orange) and concave (green) dots
    name : of that property
    columns : further float properties, name -> (N,)

    Raises
    ------
    InputError : values of another length
    """
    properties = dict(columns or {}) if values is None else {name: values, **(columns or {})}
    fields = [(axis, "<f4") for axis in ("x", "y", "z", "nx", "ny", "nz")]
    fields += [(channel, "u1") for channel in ("red", "green", "blue")]
    vertices = np.empty(len(surface), fields + [(key, "<f4") for key in properties])
    place = np.hstack([surface.points, surface.normals])
    colours = KIND_COLOURS[surface.kind] if values is None else _viridis(values)
    for key, column in zip(vertices.dtype.names, [*place.T, *colours.T, *properties.values()], strict=True):
        if len(column) != len(surface):
            raise InputError(f"surface: {len(column)} values of {key} for {len(surface)} dots.")
        vertices[key] = column
    triangles = _triangles(surface) if len(surface) <= MANY_DOTS else np.empty((0, 3), int)
    faces = np.empty(len(triangles), [("n", "u1"), ("vertex", "<i4", 3)])
    faces["n"], faces["vertex"] = 3, triangles
    kinds = {"<f4": "float", "|u1": "uchar"}
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property {kinds[vertices.dtype[key].str]} {key}" for key in vertices.dtype.names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    with open(path, "wb") as stream:
        stream.write("\n".join(header).encode("ascii") + vertices.tobytes() + faces.tobytes())


def _viridis(values):
    """(N, 3) uint8 colours; evenly bright and safe for the colour-blind."""
    values = np.asarray(values, dtype=float)
    known = np.isfinite(values)
    low, high = (values[known].min(), values[known].max()) if known.any() else (0.0, 0.0)
    scaled = (values - low) / (high - low) if high > low else np.full(len(values), 0.5)
    colours = colormaps["viridis"](np.where(known, scaled, 0), bytes=True)[:, :3]
    return np.where(known[:, None], colours, GREY)


def _triangles(surface):
    """Triangles between dots, (M, 3), counterclockwise seen from outside.

    The Gabriel triangles of the dots (those whose smallest ball holds no other dot) that are small and lie
    along the normals: viewers that show meshes only thus show the surface. Not a watertight mesh.
    """
    try:
        corners = Delaunay(surface.points).simplices
    except (QhullError, ValueError):  # fewer than five dots, or all in one plane
        return np.empty((0, 3), int)
    faces = np.concatenate([np.delete(corners, opposite, axis=1) for opposite in range(4)])
    apex = np.concatenate([corners[:, opposite] for opposite in range(4)])
    a, b, c = (surface.points[faces[:, corner]] for corner in range(3))
    normal = np.cross(b - a, c - a)
    square = np.maximum((normal**2).sum(axis=1), 1e-12)[:, None]
    ab2, ac2 = ((b - a) ** 2).sum(axis=1)[:, None], ((c - a) ** 2).sum(axis=1)[:, None]
    to_centre = (ab2 * np.cross(c - a, normal) + ac2 * np.cross(normal, b - a)) / (2 * square)
    radius2 = (to_centre**2).sum(axis=1)
    gabriel = ((surface.points[apex] - a - to_centre) ** 2).sum(axis=1) >= radius2
    outward = surface.normals[faces].mean(axis=1)
    along = (normal * outward).sum(axis=1)
    spacing = np.median(cKDTree(surface.points).query(surface.points, k=2)[0][:, 1])
    good = (radius2 < (WIDEST_FACE * spacing) ** 2) & (np.abs(along) > 0.5 * np.sqrt(square[:, 0]))
    faces = np.where(along[:, None] > 0, faces, faces[:, ::-1])
    # A triangle between two tetrahedra came twice and must be good on both sides.
    _, place, times = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    both = np.bincount(place, gabriel & good) == times
    return faces[np.unique(place, return_index=True)[1]][both]


def write_dms(path, surface, residue_names, residue_labels, atom_names, xyz):
    """Write a DMS file with normals, each atom followed by its dots; packed if the name ends in .gz.

    Parameters
    ----------
    path : file to write
    surface : Surface of known atoms and kinds
    residue_names, residue_labels, atom_names : (A,) str; a label is a number, with a chain letter or not
    xyz : (A, 3), Å

    Raises
    ------
    InputError : dots without atom or kind
    """
    if surface.atom.min() < 0 or surface.kind.min() < 0 or surface.atom.max() >= len(xyz):
        raise InputError("surface: a DMS file needs the atom and the kind of every dot.")
    # Labels with a letter shift the columns by one, as in DMS's own files; so do long numbers, not to touch.
    shifted = any(str(label)[-1:].isalpha() for label in residue_labels) or np.abs(xyz).max() >= 99.9
    width = 9 if shifted else 8
    by_atom = np.argsort(surface.atom, kind="stable")
    first = np.searchsorted(surface.atom[by_atom], np.arange(len(xyz) + 1))
    lines = []
    for i, labels in enumerate(zip(residue_names, residue_labels, atom_names, strict=True)):
        residue, label, atom = labels
        head = f"{residue:<3s}{label:>5s}{atom:>5s}"
        x, y, z = xyz[i]
        lines.append(f"{head}{x:{width}.3f}{y:9.3f}{z:9.3f} A\n")
        for n in by_atom[first[i] : first[i + 1]]:
            (x, y, z), (u, v, w), area = surface.points[n], surface.normals[n], np.nan_to_num(surface.area[n])
            place = f"{x:{width}.3f}{y:9.3f}{z:9.3f}"
            lines.append(f"{head}{place} {DMS_TYPES[surface.kind[n]]}{area:7.3f}{u:7.3f}{v:7.3f}{w:7.3f}\n")
    content = "".join(lines).encode("ascii", "replace")
    with open(path, "wb") as stream:
        stream.write(gzip.compress(content, mtime=0) if str(path).endswith(".gz") else content)
