"""PLY files: a mesh whose vertices are the dots, with values and colours for viewers; of any program's the vertices are read."""

import codecs
import logging
from pathlib import Path

import numpy as np

from sparsurf import InputError
from sparsurf.surfaces.surface import Format, is_field, surface_of_columns

log = logging.getLogger("sparsurf")

KIND_COLOURS = np.array([[86, 180, 233], [230, 159, 0], [0, 158, 115], [160, 160, 160]], np.uint8)
AXES, CHANNELS = ("x", "y", "z", "nx", "ny", "nz"), ("red", "green", "blue")
GREY = np.array([160, 160, 160], np.uint8)
VIRIDIS = np.load(
    Path(__file__).with_name("viridis.npy")
)  # (256, 3) uint8, matplotlib's, which users need not have
NOISE = 1e-4  # Å, by which dots are moved before they are joined: many lie on one sphere, which would take twice the time
FLAT = 1e-3  # Å, a height about which nothing is plain
DOUBTFUL = 2.0  # of 4: how far the four normals may agree on the side of a tetrahedron that is in doubt
VOTE = 0.1  # Å^2 of boundary that a normal of a doubtful tetrahedron outweighs; with 0.03 more dots stay without a triangle
FINEST, WIDEST = 1e5, 1e9  # parts of an Å^2 that areas are counted in, and most of them together
MANY_DOTS = 500_000  # beyond which the triangles would take minutes
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}  # of the bytes of a number
TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"}
TYPES |= {f"{name}{8 * size}": f"{name[0]}{size}" for name in ("int", "uint") for size in (1, 2, 4)}
TYPES |= {"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"}


def write_ply(
    path, surface, values=None, name="roughness", columns=None, mesh=True, faces=None, binary=False
):
    """Write a PLY mesh whose vertices are the dots, in their order, as text or binary.

    Parameters
    ----------
    path : file to write
    surface : Surface
    values : (N,), shown as colours (viridis from the smallest to the largest, grey for NaN) and as a
        property; without them the colours tell contact (blue), saddle (orange) and concave (green) dots
    name : of that property
    columns : further properties, name -> (N,); like `values` written as int where they hold integers, else as float
    mesh : whether triangles between the dots are written, which takes seconds on 20 thousand dots
    faces : (F, 3) triangles between the dots where they are known
    binary : whether numbers are written as bytes, which is faster to read and half as long

    Raises
    ------
    InputError : values of another length
    """
    properties = dict(columns or {}) if values is None else {name: values, **(columns or {})}
    whole = [key for key, column in properties.items() if np.asarray(column).dtype.kind in "iu"]
    properties = {key: np.asarray(column, float) for key, column in properties.items()}
    for key, column in properties.items():
        if len(column) != len(surface):
            raise InputError(f"surface: {len(column)} values of {key} for {len(surface)} dots.")
    if faces is None:
        few = len(surface) <= MANY_DOTS
        if mesh and not few:
            log.warning("%d dots are too many for triangles between them: the PLY has none", len(surface))
        faces = triangles(surface) if mesh and few else np.empty((0, 3), int)
    colours = KIND_COLOURS[surface.kind] if values is None else viridis(values)
    table = {
        axis: column
        for axis, column in zip(AXES, np.hstack([surface.points, surface.normals]).T, strict=True)
    }
    table |= dict(zip(CHANNELS, colours.T, strict=True)) | properties
    header = [
        "ply",
        f"format {'binary_little_endian' if binary else 'ascii'} 1.0",
        f"element vertex {len(surface)}",
    ]
    types = dict.fromkeys(CHANNELS, "uchar") | dict.fromkeys(whole, "int")
    header += [f"property {types.get(key, 'float')} {key}" for key in table]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    if binary:
        _write_bytes(path, header, table, types, faces)
        return
    last = ["%d" if key in whole else "%.6g" for key in properties]
    row = " ".join(["%.4f"] * len(AXES) + ["%d"] * len(CHANNELS) + last)
    with open(path, "w", encoding="ascii", newline="\n") as stream:
        stream.write("\n".join(header) + "\n")
        stream.writelines(
            f"{row % each}\n" for each in zip(*map(np.ndarray.tolist, table.values()), strict=True)
        )
        stream.writelines(f"3 {a} {b} {c}\n" for a, b, c in faces.tolist())


def _write_bytes(path, header, table, types, faces):
    """Write the columns of the vertices and the triangles behind the lines of a header."""
    kinds = {"uchar": "u1", "int": "<i4"}
    rows = np.empty(
        len(next(iter(table.values()))), [(key, kinds.get(types.get(key), "<f4")) for key in table]
    )
    for key, column in table.items():
        rows[key] = column
    corners = np.empty(len(faces), [("n", "u1"), ("corners", "<i4", 3)])
    corners["n"], corners["corners"] = 3, faces
    with open(path, "wb") as stream:
        stream.write(("\n".join(header) + "\n").encode() + rows.tobytes() + corners.tobytes())


def viridis(values):
    """(N, 3) uint8 colours; evenly bright and safe for the colour-blind."""
    values = np.asarray(values, dtype=float)
    known = np.isfinite(values)
    low, high = (values[known].min(), values[known].max()) if known.any() else (0.0, 0.0)
    scaled = (values - low) / (high - low) if high > low else np.full(len(values), 0.5)
    colours = VIRIDIS[np.minimum(np.where(known, scaled, 0) * len(VIRIDIS), len(VIRIDIS) - 1).astype(int)]
    return np.where(known[:, None], colours, GREY)


def triangles(surface):
    """Triangles between dots, (M, 3), counterclockwise seen from outside: the boundary of what lies inside.

    The dots' Delaunay tetrahedra lie inside or outside the molecule; the normals tell which. Their common boundary is
    closed whatever they tell. A triangle may be missing its dot where dots crowd (DMS's own inside other probes).
    """
    from scipy.spatial import Delaunay, QhullError

    shaken = surface.points + NOISE * np.random.default_rng(0).uniform(-1, 1, surface.points.shape)
    try:
        cells = Delaunay(shaken)
    except (QhullError, ValueError):  # fewer than five dots, or all in one plane
        return np.empty((0, 3), int)
    inside, neighbours = _inside(surface, cells), cells.neighbors
    faces = []
    for corner in range(4):
        outward = inside & ~np.append(inside, False)[neighbours[:, corner]]  # -1, no neighbour, is outside
        face, apex = np.delete(cells.simplices[outward], corner, axis=1), cells.simplices[outward, corner]
        a, b, c = (shaken[face[:, k]] for k in range(3))
        clockwise = np.einsum("ij,ij->i", np.cross(b - a, c - a), shaken[apex] - a) > 0
        faces.append(np.where(clockwise[:, None], face[:, ::-1], face))
    return np.concatenate(faces)


def _inside(surface, cells):
    """(T,) bool: tetrahedra inside the molecule.

    The centre of the ball through the four dots lies behind them, against their normals, if the tetrahedron is inside,
    which is plain for all but the flat ones between dots side by side. Those are shared out so that the boundary is smallest,
    but for what the normals tell of them.
    """
    corners = surface.points[cells.simplices]
    edges = corners[:, 1:] - corners[:, :1]
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    solid = np.abs(np.linalg.det(edges)) > FLAT * longest**2
    centre = np.zeros((len(corners), 3))  # from the first corner; all four are as far from it
    centre[solid] = np.linalg.solve(edges[solid], (edges[solid] ** 2).sum(axis=2)[..., None] / 2)[..., 0]
    rays = centre[:, None] - (corners - corners[:, :1])
    towards = np.einsum("ijk,ijk->i", rays, surface.normals[cells.simplices])
    towards[solid] /= np.linalg.norm(centre[solid], axis=1)
    plain = solid & (np.abs(towards) >= DOUBTFUL)
    inside = np.append(plain & (towards < 0), False)  # the last, -1, is outside of all
    doubtful = np.flatnonzero(~plain)
    if len(doubtful):
        area = np.stack([_areas(np.delete(corners[doubtful], each, axis=1)) for each in range(4)], axis=1)
        votes = VOTE * np.where(solid, towards, 0)[doubtful]
        inside[doubtful] = _smallest_boundary(cells.neighbors[doubtful], area, votes, doubtful, inside)
    return inside[:-1]


def _smallest_boundary(opposite, area, votes, doubtful, inside):
    """(D,) bool: which of the doubtful tetrahedra are inside where the boundary is smallest, a minimum cut.

    Parameters
    ----------
    opposite, area : (D, 4), the tetrahedron behind each side, and the area of the side in Å^2
    votes : (D,), Å^2 that the boundary may be larger for if the tetrahedron comes inside (below 0) or stays outside
    doubtful : (D,), their numbers; inside : (T + 1,) bool, of the others
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    n = len(doubtful)
    number = np.full(len(inside), -1)
    number[doubtful] = np.arange(n)
    fine = min(FINEST, WIDEST / area.sum())
    width, votes = np.round(area * fine).astype(np.int64) + 1, np.round(votes * fine).astype(np.int64)
    other, row = number[opposite], np.arange(n).repeat(4).reshape(n, 4)
    joined = other >= 0
    from_inside = np.where(~joined & inside[opposite], width, 0).sum(axis=1) + np.maximum(-votes, 0)
    to_outside = np.where(~joined & ~inside[opposite], width, 0).sum(axis=1) + np.maximum(votes, 0)
    rows = np.concatenate([row[joined], np.full(n, n), np.arange(n)])
    columns = np.concatenate([other[joined], np.arange(n), np.full(n, n + 1)])
    widths = np.concatenate([width[joined], from_inside, to_outside]).astype(np.int32)
    graph = coo_array((widths, (rows, columns)), shape=(n + 2, n + 2)).tocsr()
    left = graph - maximum_flow(graph, n, n + 1).flow
    left.data[left.data < 0] = 0
    left.eliminate_zeros()
    reached = breadth_first_order(left, n, return_predecessors=False)
    found = np.zeros(n + 2, bool)
    found[reached] = True
    return found[:n]


def _areas(corners):
    """Areas of triangles (T, 3, 3)."""
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def read_ply(content, path):
    """Surface of the vertices of a PLY file, text or binary, with their normals; triangles are passed over.

    Source of the format: G. Turk, The PLY polygon file format (1994).
    """
    head, _, rest = content.partition(b"end_header")
    order, n, properties = _header(head.decode("latin-1"), path)
    names = [name for _, name in properties]
    wrong = [axis for axis in AXES if names.count(axis) != 1]
    if wrong:
        raise InputError(
            f"{path} needs one {wrong[0]} of every vertex; its vertices must have x, y, z, nx, ny, nz."
        )
    try:
        if order:
            types = np.dtype([(str(k), order + kind) for k, (kind, _) in enumerate(properties)])
            rest = rest[rest.index(b"\n") + 1 :]
            table, more = np.frombuffer(rest, types, n), len(rest) >= (n + 1) * types.itemsize
            with np.errstate(invalid="ignore"):
                columns = [table[key].astype(float) for key in types.names]
        else:
            words = rest.split(None, n * len(names))
            more = words[n * len(names) :]
            columns = np.array(words[: n * len(names)], float).reshape(n, len(names)).T
    except ValueError:
        raise InputError(f"{path} is cut short or damaged: its {n} vertices cannot be read.") from None
    if more and head.count(b"\nelement ") == 1:
        raise InputError(f"{path} holds more than the {n} vertices that its header announces: copy it again.")
    x, y, z, u, v, w = (columns[names.index(axis)] for axis in AXES)
    fields = {name: column for name, column in zip(names, columns, strict=True) if is_field(name)}
    return surface_of_columns(
        fields | {"points": np.column_stack([x, y, z]), "normals": np.column_stack([u, v, w])}, path
    )


def _header(text, path):
    """Order of the bytes (none: text), number of vertices, and the type and name of each of their properties."""
    order, elements = None, []
    for words in (line.split() for line in text.splitlines()):
        if words[:1] == ["format"] and words[1:2] and words[1] in ORDERS:
            order = ORDERS[words[1]]
        elif words[:1] == ["element"] and len(words) == 3 and words[2].isdecimal() and len(words[2]) < 13:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"] and len(words) > 2 and elements:
            elements[-1][2].append((TYPES.get(words[1]), words[-1]))
    if order is None or not elements or elements[0][0] != "vertex" or None in dict(elements[0][2]):
        raise InputError(
            f"{path} is no PLY file that can be read: its vertices must come first, without lists."
        )
    return order, *elements[0][1:]


def _sniff(head):
    return head.removeprefix(codecs.BOM_UTF8).lstrip().startswith(b"ply")


FORMAT = Format("PLY", (".ply",), _sniff, read_ply, write_ply)
