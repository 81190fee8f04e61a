"""Closed meshes of molecular surfaces: a signed distance on a grid, its triangles, their corners moved onto the surface.

Triangles are those of marching tetrahedra. Every cube of the grid is cut into the six tetrahedra around its diagonal
(Freudenthal, Ann. Math. 43:580, 1942), those of neighbouring cubes fitting face to face. A tetrahedron is crossed in one
triangle or two, whose corners lie on its edges and belong to all tetrahedra around them: so every edge of the mesh belongs
to two triangles, whatever the values are.
"""

import math
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numba import njit

from sparsurf import InputError
from sparsurf.surfaces.placing_dots import relative_places, some_probes, spheres
from sparsurf.surfaces.rolling_probe import E1, E2, PHI_0, PHI_1, RADIUS, T, blocker, roll
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE, Surface
from sparsurf.surfaces.vectors import along, apart2, cells_of, column, dot, minus, part, point
from sparsurf.threads import parallel_map

STEP = 0.5  # Å, of the grid, where dots have the density DENSITY
MARGIN = 2  # steps of the grid around the surface
SLICE = 4096  # places per task
MOST_POINTS = 400_000_000  # of a grid; beyond, it would take more than 4 GB
NEAREST_CORNER = 0.02  # share of an edge that stays between a vertex and the end of the edge


@dataclass(frozen=True)
class Mesh:
    """A closed surface of triangles.

    Attributes
    ----------
    vertices : Surface, whose areas are a third of those of the triangles around each
    triangles : (F, 3) int64, counterclockwise seen from outside; every edge belongs to two of them
    """

    vertices: Surface
    triangles: np.ndarray

    def __repr__(self):
        return f"Mesh of {len(self.triangles):,} triangles"

    @property
    def volume(self):
        """Å^3; what lies in cavities does not count."""
        a, b, c = (self.vertices.points[self.triangles[:, k]] for k in range(3))
        return float(np.sum(a * np.cross(b, c)) / 6)


def outside(mesh):
    """The Mesh without the parts that face inwards, which are its cavities."""
    from scipy.sparse import coo_array  # here: few ask for it
    from scipy.sparse.csgraph import connected_components

    corners, n = mesh.triangles, len(mesh.vertices)
    edges = coo_array(
        (np.ones(2 * len(corners)), (np.repeat(corners[:, 0], 2), corners[:, 1:].ravel())), (n, n)
    )
    label = connected_components(edges, directed=False)[1]
    a, b, c = (mesh.vertices.points[corners[:, k]] for k in range(3))
    cavity = np.bincount(label[corners[:, 0]], (a * np.cross(b, c)).sum(axis=1)) < 0
    kept = ~cavity[label]
    number = np.cumsum(kept) - 1
    return Mesh(mesh.vertices.take(kept), number[corners[kept[corners[:, 0]]]])


def step_of(density):
    """Å, step of a grid whose triangles are as much finer as dots of this density (per Å^2) are."""
    return STEP * math.sqrt(DENSITY / density)


def mesh_of(points, normals, triangles, kind=None):
    """The Mesh of places (V, 3), unit normals (V, 3) and triangles (F, 3)."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    third = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6
    area = np.bincount(triangles.ravel(), np.repeat(third, 3), len(points))
    return Mesh(Surface(points, normals, area, kind), triangles)


def grid_around(points, reach, step):
    """Corner (3,) and numbers of points (3,) of a grid of `step` that goes beyond all `points` (N, 3) by `reach`, Å.

    Raises
    ------
    InputError : more points than fit
    """
    low = points.min(axis=0) - reach - MARGIN * step
    shape = np.ceil((points.max(axis=0) + reach - low) / step).astype(np.int64) + MARGIN + 1
    if np.prod(shape.astype(float)) > MOST_POINTS:
        raise InputError(
            f"mesh: a grid of {step:g} Å would have {' x '.join(map(str, shape))} points, more than {MOST_POINTS:.0e}; "
            "take a wider one."
        )
    return low, shape


def molecular_mesh(xyz, radii, probe=1.4, step=STEP, threads=1):
    """Solvent-excluded surface of spheres as triangles, each of their corners on the surface itself.

    The surface is what lies a probe's radius from all places where the probe's centre may be. So the distance to the
    nearest of these places tells which side a point is on, and the point of the surface nearest to it.

    Parameters
    ----------
    xyz, radii : (A, 3) and (A,), Å
    probe : Å
    step : Å, of the grid, at most half the probe's radius
    threads : int

    Returns
    -------
    Mesh

    Raises
    ------
    InputError : a grid of too many points, and what `molecular_surface.molecular_surface` refuses
    """
    xyz, radii, _ = spheres(xyz, radii, probe)
    step = min(step, probe / 2)  # no edge of the grid may reach through the room between surface and centres
    relative = np.add(*relative_places(xyz))
    rolling = roll(relative, radii + probe)
    limit = probe + math.sqrt(3) * step
    far = cells_of(some_probes(rolling.probes), limit), cells_of(relative, (radii + probe).max() + limit)
    low, shape = grid_around(relative, radii.max(), step)
    values = _deepest(relative, radii, low, shape, step, -2 * probe)
    # neither in an atom nor where a centre may be
    doubtful = np.flatnonzero((values > -probe) & (values <= 0))
    places = low + step * np.stack(np.unravel_index(doubtful, values.shape), axis=1)
    gap, _, _ = _nearest_centres(places, rolling, far, limit, threads)
    values.ravel()[doubtful] = gap - probe
    vertices, triangles = march(values)
    vertices = low + step * vertices
    gap, centres, kind = _nearest_centres(vertices, rolling, far, limit, threads)
    outward = (centres - vertices) / gap[:, None]
    return mesh_of(centres - probe * outward + xyz[0], outward, triangles, kind)


def _nearest_centres(places, rolling, far, limit, threads):
    """Distance (n,) to the nearest centre of an accessible probe, `limit` at most, that centre (n, 3) and its kind."""
    gap, centres, kind = np.empty(len(places)), np.zeros((len(places), 3)), np.zeros(len(places), np.int8)
    parallel_map(
        lambda a, b: _search(places[a:b], rolling, *far, limit, gap[a:b], centres[a:b], kind[a:b]),
        len(places),
        threads,
        SLICE,
    )
    return gap, centres, kind


@njit(cache=True, nogil=True)
def _deepest(centre, radii, low, shape, step, lowest):
    """Depth below the surface of the deepest sphere around each point of a grid, (X, Y, Z); `lowest` at least."""
    values = np.full((shape[0], shape[1], shape[2]), lowest)
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    for a in range(len(centre)):
        for c in range(3):
            first[c] = max(0, math.ceil((centre[a, c] - radii[a] + lowest - low[c]) / step))
            last[c] = min(shape[c] - 1, math.floor((centre[a, c] + radii[a] - lowest - low[c]) / step))
        for i in range(first[0], last[0] + 1):
            x = low[0] + i * step - centre[a, 0]
            for j in range(first[1], last[1] + 1):
                y = low[1] + j * step - centre[a, 1]
                for k in range(first[2], last[2] + 1):
                    z = low[2] + k * step - centre[a, 2]
                    depth = radii[a] - math.sqrt(x * x + y * y + z * z)
                    if depth > values[i, j, k]:
                        values[i, j, k] = depth
    return values


@njit(cache=True, nogil=True)
def _search(places, rolling, probe_cells, atom_cells, limit, gap, centres, kind):
    """`_nearest_centres` of a slice: among the fixed probes, then on the arcs and the patches of the atoms around."""
    for n in range(len(places)):
        place, best, found = point(places, n), limit * limit, (0.0, 0.0, 0.0)
        for c in range(9):
            slot, last = column(probe_cells, place, c)
            while slot < len(probe_cells.key) and probe_cells.key[slot] <= last:
                k = probe_cells.order[slot]
                slot += 1
                if k < len(rolling.probes) and apart2(point(rolling.probes, k), place) < best:
                    found, kind[n] = point(rolling.probes, k), CONCAVE
                    best = apart2(found, place)
        for c in range(9):
            slot, last = column(atom_cells, place, c)
            while slot < len(atom_cells.key) and atom_cells.key[slot] <= last:
                k = atom_cells.order[slot]
                slot += 1
                centre, reach = point(rolling.atoms.centre, k), rolling.atoms.reach[k]
                w = minus(place, centre)
                d = math.sqrt(dot(w, w))
                if d > reach + math.sqrt(best):
                    continue
                for b in range(rolling.first_arc[k], rolling.first_arc[k + 1]):
                    there, on = _on_arc(place, rolling.arcs[b])
                    if on and apart2(there, place) < best:
                        found, kind[n], best = there, SADDLE, apart2(there, place)
                if (d - reach) ** 2 < best and d > 0:
                    there = along(centre, reach / d, w)
                    if blocker(there, k, rolling.atoms, -1) < 0:
                        found, kind[n], best = there, CONTACT, (d - reach) ** 2
        gap[n] = math.sqrt(best)
        centres[n, 0], centres[n, 1], centres[n, 2] = found


@njit(cache=True, nogil=True)
def _on_arc(place, arc):
    """The point of the arc's circle that is nearest to a place, and whether it belongs to the arc."""
    w = minus(place, part(arc, T))
    p1, p2 = dot(w, part(arc, E1)), dot(w, part(arc, E2))
    flat = math.hypot(p1, p2)
    if flat == 0.0:
        return part(arc, T), False
    phi = math.atan2(p2, p1) - arc[PHI_0]
    on = phi - 2 * math.pi * math.floor(phi / (2 * math.pi)) < arc[PHI_1] - arc[PHI_0]
    there = along(part(arc, T), arc[RADIUS] * p1 / flat, part(arc, E1))
    return along(there, arc[RADIUS] * p2 / flat, part(arc, E2)), on


def _tetrahedra():
    """Corners of the six tetrahedra of a cube, (6, 4), bit a for a step along axis a, the odd ones turned round."""
    found = []
    for p, q, r in permutations(range(3)):
        corners = [0, 1 << p, 1 << p | 1 << q, 7]
        odd = (p > q) + (p > r) + (q > r) & 1
        found.append([corners[0], corners[2], corners[1], corners[3]] if odd else corners)
    return np.array(found)


def _crossings():
    """Edges that bear the corners of the triangles of a tetrahedron, (16, 2, 3, 2), and how many triangles, (16,).

    By bit mask of its corners inside; the triangles run counterclockwise seen from outside.
    """
    edges, count = np.zeros((16, 2, 3, 2), np.int64), np.zeros(16, np.int64)
    even = [t for t in permutations(range(4)) if np.linalg.det(np.eye(4)[list(t)]) > 0]
    for mask in range(1, 15):
        inside = [c for c in range(4) if mask >> c & 1]
        first = inside if len(inside) < 3 else [c for c in range(4) if c not in inside]
        a, b, c, d = next(t for t in even if list(t[: len(first)]) == first)
        if len(inside) == 1:
            found = [[(a, b), (a, c), (a, d)]]
        elif len(inside) == 3:
            found = [[(a, b), (a, d), (a, c)]]
        else:
            found = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
        edges[mask, : len(found)], count[mask] = found, len(found)
    return edges, count


TETRAHEDRA = _tetrahedra()
CROSSED, N_CROSSED = _crossings()
BITS = np.array([bin(k).count("1") for k in range(256)], np.int64)


def march(values):
    """The surface between what is inside, above 0, and the rest.

    Parameters
    ----------
    values : (X, Y, Z) float, at most 0 on all six sides

    Returns
    -------
    vertices (V, 3) float64, in steps of the grid, and triangles (F, 3) int64, counterclockwise seen from outside
    """
    cut = _cut_edges(values)
    first = np.zeros(values.size + 1, np.int64)
    np.cumsum(BITS[cut.ravel()], out=first[1:])
    vertices = _vertices(values, cut, first)
    return vertices, _triangles(values, cut, first)


@njit(cache=True, nogil=True)
def _cut_edges(values):
    """Bit d - 1 of each point: whether the edge from it in direction d (bits as of corners) crosses the surface."""
    nx, ny, nz = values.shape
    cut = np.zeros((nx, ny, nz), np.uint8)
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                inside = values[i, j, k] > 0
                for d in range(1, 8):
                    x, y, z = i + (d & 1), j + (d >> 1 & 1), k + (d >> 2)
                    if x < nx and y < ny and z < nz and (values[x, y, z] > 0) != inside:
                        cut[i, j, k] |= 1 << (d - 1)
    return cut


@njit(cache=True, nogil=True)
def _vertices(values, cut, first):
    """Place of the vertex on every edge that is cut, where the values between its ends pass 0."""
    nx, ny, nz = values.shape
    vertices = np.empty((first[-1], 3))
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if cut[i, j, k] == 0:
                    continue
                at = first[(i * ny + j) * nz + k]
                for d in range(1, 8):
                    if cut[i, j, k] >> (d - 1) & 1:
                        a, b = d & 1, d >> 1 & 1
                        c = d >> 2
                        here, there = values[i, j, k], values[i + a, j + b, k + c]
                        t = min(max(here / (here - there), NEAREST_CORNER), 1 - NEAREST_CORNER)
                        vertices[at, 0], vertices[at, 1], vertices[at, 2] = i + t * a, j + t * b, k + t * c
                        at += 1
    return vertices


@njit(cache=True, nogil=True)
def _triangles(values, cut, first):
    """Vertices of all triangles; counted in a first pass, stored in a second."""
    nx, ny, nz = values.shape
    triangles = np.empty((0, 3), np.int64)
    for store in range(2):
        n = 0
        for i in range(nx - 1):
            for j in range(ny - 1):
                for k in range(nz - 1):
                    inside = 0
                    for c in range(8):
                        if values[i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)] > 0:
                            inside |= 1 << c
                    if inside == 0 or inside == 255:
                        continue
                    for t in range(6):
                        mask = 0
                        for c in range(4):
                            mask |= (inside >> TETRAHEDRA[t, c] & 1) << c
                        if store:
                            for f in range(N_CROSSED[mask]):
                                for e in range(3):
                                    a, b = (
                                        TETRAHEDRA[t, CROSSED[mask, f, e, 0]],
                                        TETRAHEDRA[t, CROSSED[mask, f, e, 1]],
                                    )
                                    low, bit = a & b, (a ^ b) - 1  # one corner's bits hold the other's
                                    x, y, z = i + (low & 1), j + (low >> 1 & 1), k + (low >> 2)
                                    before = cut[x, y, z] & ((1 << bit) - 1)
                                    triangles[n + f, e] = first[(x * ny + y) * nz + z] + BITS[before]
                        n += N_CROSSED[mask]
        if not store:
            triangles = np.empty((n, 3), np.int64)
    return triangles
