"""Meshes: closed and turned outwards whatever the values, with their corners on the surface, readable by others."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import sparsurf
from conftest import ROOT, ball, sphere
from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.recovery.interpolated_surface import recovered_mesh
from sparsurf.sampling.samplers import farthest
from sparsurf.streams import Streams
from sparsurf.surfaces import grid_mesh, triangulation
from sparsurf.surfaces.decimation import decimate
from sparsurf.surfaces.grid_mesh import marching_tetrahedra
from sparsurf.surfaces.mesh import MeshSize
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii

ATOMS = np.array([[0, 0, 0], [1.5, 0, 0], [2.2, 1.3, 0.2], [3.7, 1.4, 0.3], [4.3, 2.7, 0.9], [5, 5, 1]])
RADII = np.array([1.9, 1.5, 1.9, 1.4, 1.85, 1.7])
TURN = np.linspace(0, 2 * np.pi, 12, endpoint=False)
RING = np.column_stack([5 * np.cos(TURN), 5 * np.sin(TURN), 0 * TURN])
# the probe's way around the last two reaches as far from the middle one as an arc can
SPHERES = ([[0.0, 0, 0], [3, 0, 0]], [1.5, 1.5])
ROD = np.array([[0.0, 0, 0], [3.0, 0, 0], [8.0, 0, 0]])


def molecular_mesh(xyz, sizes, probe=1.4, step=0.5):
    return triangulation.molecular_mesh(xyz, sizes, probe, MeshSize(step=step))


def closed(triangles, n):
    """Euler number and number of parts of a mesh of n vertices, after a check that it is closed and turned alike."""
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, edge, times = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    assert (times == 2).all(), "an edge does not belong to two triangles"
    ways = np.bincount(edge.ravel(), np.where(directed[:, 0] < directed[:, 1], 1, -1))
    assert (ways == 0).all(), "two triangles run along an edge in one direction"
    assert len(np.unique(triangles)) == n, "a vertex is in no triangle"
    links = coo_matrix((np.ones(len(directed)), directed.T), shape=(n, n))
    return n - len(times) + len(triangles), connected_components(links, directed=False)[0]


def volume(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.sum(a * np.cross(b, c)) / 6


def area(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def by_gauss(dots):
    """Volume from dots: a third of the sum of area times distance along the normal."""
    return np.sum(dots.area * np.sum(dots.points * dots.normals, axis=1)) / 3


@pytest.mark.parametrize("share", [0.03, 0.3, 0.7, 1.0])
def test_any_values_give_a_closed_mesh(share):
    """Even noise: each point of the grid inside by chance."""
    rng = np.random.default_rng(3)
    values = np.full((9, 10, 11), -1.0)
    values[1:-1, 1:-1, 1:-1] = rng.uniform(0, 1, (7, 8, 9)) * np.where(rng.random((7, 8, 9)) < share, 1, -1)
    values[3, 3, 3] = 0.0  # counts as outside
    vertices, triangles = marching_tetrahedra(values)
    closed(triangles, len(vertices))
    assert volume(vertices, triangles) > 0
    assert len(marching_tetrahedra(np.full((4, 4, 4), -1.0))[1]) == 0


@pytest.mark.parametrize("inside, outside, share", [(1.0, -1.0, 0.5), (1e-9, -1.0, 0.02), (1.0, -1e-9, 0.98)])
def test_no_triangle_shrinks_to_a_point_of_the_grid(inside, outside, share):
    """One point inside: a vertex on each of its fourteen edges, at a share of the way that leaves a rest at both ends."""
    values = np.full((3, 3, 3), outside)
    values[1, 1, 1] = inside
    vertices, triangles = marching_tetrahedra(values)
    assert len(vertices) == 14 and closed(triangles, 14) == (2, 1)
    assert np.abs(vertices - 1).max(axis=1) == pytest.approx(share)


def test_a_sphere():
    mesh = molecular_mesh(np.ones((1, 3)), np.array([2.0]), step=0.3)
    assert closed(mesh.triangles, len(mesh.vertices)) == (2, 1)
    outward = mesh.vertices.points - 1
    assert np.linalg.norm(outward, axis=1) == pytest.approx(2, abs=1e-6)
    assert outward / 2 == pytest.approx(mesh.vertices.normals, abs=1e-6)
    assert mesh.vertices.area.sum() == pytest.approx(16 * np.pi, rel=5e-3)
    a, b, c = mesh.vertices.points[mesh.triangles[(mesh.triangles == 7).any(axis=1)]].transpose(1, 0, 2)
    around = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    assert mesh.vertices.area[7] == pytest.approx(around.sum() / 3)
    assert mesh.volume == pytest.approx(32 / 3 * np.pi, rel=1e-2) and mesh.volume < 32 / 3 * np.pi


def test_two_spheres_and_the_saddle_between_them():
    """Volume by its closed form: two cut balls and the room under the arc of the probe between them."""
    d, r, p = 3.0, 1.7, 1.4
    mesh = molecular_mesh(np.array([[0, 0, 0], [d, 0, 0]]), np.full(2, r), p, 0.2)
    x = np.linspace(-r, d / 2, 200_001)
    height = np.sqrt((r + p) ** 2 - d**2 / 4)
    touch = d / 2 * r / (r + p)
    ball = np.sqrt(np.maximum(r**2 - x**2, 0))
    saddle = height - np.sqrt(p**2 - (np.clip(x, touch, None) - d / 2) ** 2)
    profile = np.where(x < touch, ball, saddle)
    exact = 2 * np.pi * np.trapezoid(profile**2, x)
    assert closed(mesh.triangles, len(mesh.vertices)) == (2, 1)
    assert mesh.volume == pytest.approx(exact, rel=5e-3)
    assert set(mesh.vertices.kind) == {0, 1}


@pytest.mark.parametrize(
    ("xyz", "sizes", "handles"),
    [
        (ATOMS, RADII, 0),
        (RING, np.full(12, 1.7), 1),
        (ROD, np.full(3, 1.7), 0),
        (ROD[:2], np.array([1.2, 3.4]), 0),
    ],
)
def test_corners_lie_on_the_surface(xyz, sizes, handles):
    """The probe that touches a corner along its normal overlaps no atom and touches as many as its kind says."""
    mesh = molecular_mesh(xyz, sizes)
    assert closed(mesh.triangles, len(mesh.vertices)) == (2 - 2 * handles, 1)
    centre = mesh.vertices.points + 1.4 * mesh.vertices.normals
    gap = np.linalg.norm(centre[:, None] - xyz, axis=2) - sizes - 1.4
    assert gap.min() > -1e-6
    assert ((gap < 1e-6).sum(axis=1) >= mesh.vertices.kind + 1).all()
    dots = molecular_surface(xyz, sizes, density=20)
    assert mesh.vertices.area.sum() == pytest.approx(dots.area.sum(), rel=0.01)
    assert mesh.volume == pytest.approx(by_gauss(dots), rel=0.02)


def test_a_cavity_is_closed_from_within():
    """Of a shell of atoms."""
    unit = sphere(60)[0]
    mesh = molecular_mesh(5 * unit, np.full(60, 1.7))
    assert closed(mesh.triangles, len(mesh.vertices)) == (4, 2)
    assert mesh.volume == pytest.approx(by_gauss(molecular_surface(5 * unit, np.full(60, 1.7))), rel=0.02)


def test_places_and_steps():
    one, moved = molecular_mesh(ATOMS, RADII), molecular_mesh(ATOMS + 64.0, RADII)
    assert np.array_equal(moved.triangles, one.triangles)
    assert moved.vertices.points - 64 == pytest.approx(one.vertices.points, abs=1e-9)
    wide, fine = (len(molecular_mesh(ATOMS, RADII, step=step).vertices) for step in (0.5, 0.25))
    assert 3 < fine / wide < 5  # as the square of the step
    assert 15 < wide / one.area < 21  # as many as a grid of this step would give


def test_a_grid_between_dots_has_a_largest_size(monkeypatch):
    with monkeypatch.context() as patch, pytest.raises(InputError, match="Å would have"):
        patch.setattr(grid_mesh, "MAX_GRID_POINTS", 1000)
        recovered_mesh(*ball(60, 3))
    monkeypatch.setattr(grid_mesh, "bytes_of_memory", lambda: 1e4)
    with pytest.raises(InputError, match="more than the 0 GB of this machine"):
        recovered_mesh(*ball(60, 3))


def test_the_recovered_surface_as_a_mesh():
    dots = molecular_surface(ATOMS, RADII)
    prepared = PreparedSurface(dots, streams=Streams(1))
    kept = farthest(prepared, len(dots) // 8, np.random.default_rng(0))
    mesh, true = recovered_mesh(dots.points[kept], dots.normals[kept]), molecular_mesh(ATOMS, RADII)
    assert closed(mesh.triangles, len(mesh.vertices)) == (2, 1)
    assert mesh.volume == pytest.approx(true.volume, rel=0.015)
    assert mesh.vertices.area.sum() == pytest.approx(true.vertices.area.sum(), rel=0.03)
    again = recovered_mesh(dots.points[kept], dots.normals[kept], threads=2)
    assert np.array_equal(mesh.vertices.points, again.vertices.points)


def test_the_corners_of_a_thin_wall_lie_on_its_two_sides():
    unit, inner = sphere(180)[0], sphere(120)[0]
    mesh = recovered_mesh(np.concatenate([3 * unit, 2.5 * inner]), np.concatenate([unit, -inner]), density=2)
    radius = np.linalg.norm(mesh.vertices.points, axis=1)
    assert np.abs(np.where(radius > 2.75, radius - 3, radius - 2.5)).max() < 0.1


def test_holes_are_closed_and_an_end_is_reported(caplog):
    """Dots of a ball without those of a cap: the inside stays one; a sheet has none."""
    unit = sphere(700)[0]
    unit = unit[unit[:, 2] < 0.92]  # a hole of 5 Å, where the recovered surface goes on by half an Å
    mesh = recovered_mesh(6 * unit, unit)
    assert closed(mesh.triangles, len(mesh.vertices)) == (2, 1)
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 6**3, rel=0.03)
    radius = np.linalg.norm(mesh.vertices.points[mesh.vertices.points[:, 2] < 4], axis=1)
    assert np.abs(radius - 6).max() < 0.02 and not caplog.records
    sheet = recovered_mesh(6 * unit[unit[:, 2] < 0], unit[unit[:, 2] < 0])
    closed(sheet.triangles, len(sheet.vertices))
    assert "8.0 Å" in caplog.text


@pytest.mark.parametrize("name", ["ala3_3res.pdb", "A6PA6_13res_nochain.pdb", "7etn_tiny.cif.gz", "1ubi.pdb"])
def test_proteins_close(shared, name):
    """The mesh of the atoms, and that of a tenth of their dots."""
    molecule = read_molecule(shared / "data" / "structures" / name, selection=None)
    xyz, sizes = molecule.xyz[0], radii(molecule, "dms")
    true, dots = molecular_mesh(xyz, sizes), molecular_surface(xyz, sizes)
    closed(true.triangles, len(true.vertices))
    assert true.vertices.area.sum() == pytest.approx(dots.area.sum(), rel=0.005)
    kept = farthest(PreparedSurface(dots), len(dots) // 10, np.random.default_rng(0))
    back = recovered_mesh(dots.points[kept], dots.normals[kept])
    closed(back.triangles, len(back.vertices))
    assert back.volume == pytest.approx(true.volume, rel=0.015)


@pytest.mark.parametrize(
    "path",
    [
        "structures/1fas.cif",
        "structures/1ubi.pdb",
        "structures/1a8o_mse.pdb",
        "chains/2k2d_A.pdb.gz",
        "chains/1a52_A.pdb.gz",
    ],
)
def test_finer_meshes_tend_to_the_exact_volume_and_area(shared, path):
    """The error of flat triangles falls with their size, so that of two meshes the finer one errs by half as much."""
    path = shared / "data" / path
    _, table = sparsurf.components(path)
    coarse, fine = (sparsurf.mesh(path, density=density, cavities="keep") for density in (16, 32))
    volume = table["volume"] @ np.where(table["cavity"], -1, 1)
    assert 2 * fine.volume - coarse.volume == pytest.approx(volume, rel=1e-4)
    assert 2 * fine.area - coarse.area == pytest.approx(table["area"].sum(), rel=3e-4)


# ---- coarse meshes


@pytest.fixture(scope="module")
def ring():
    """A torus, and a ball beside it."""
    return molecular_mesh(np.vstack([RING, [[20, 0, 0]]]), np.full(13, 1.7))


def test_a_ring_stays_a_ring_whose_vertices_are_those_of_the_fine_mesh(ring):
    coarse = decimate(ring, 60)
    assert closed(coarse.triangles, 60) == (2, 2)
    assert coarse.vertices.area.sum() == pytest.approx(area(coarse.vertices.points, coarse.triangles))
    fine, kept = (
        np.hstack([mesh.vertices.points, mesh.vertices.normals]).astype("f4") for mesh in (ring, coarse)
    )
    assert {row.tobytes() for row in kept} <= {row.tobytes() for row in fine}
    with pytest.raises(InputError, match="at least"):
        decimate(ring, 8)
    noise = np.random.default_rng(0).uniform(-1e-13, 1e-13, ring.vertices.points.shape)  # of another machine
    other = replace(ring, vertices=replace(ring.vertices, points=ring.vertices.points + noise))
    assert np.array_equal(decimate(other, 60).triangles, coarse.triangles)


def test_sides_are_about_equally_long_and_close_the_volume():
    mesh = sparsurf.mesh(ROOT / "data/tdp43/topology.pdb", 1024)
    assert np.array_equal(np.asarray(mesh), mesh.vertices.points)
    points, corners = mesh.vertices.points, mesh.triangles
    sides = np.linalg.norm(points[corners] - points[np.roll(corners, 1, axis=1)], axis=2)
    assert len(mesh.vertices) == 1024 and (sides < 0.3 * np.median(sides)).mean() < 0.01
    assert mesh.volume == pytest.approx(7870, rel=0.03)


@pytest.mark.parametrize("density", [0.5, 2.72, 2.74, 20.0])
def test_a_density_is_a_number_of_vertices_per_area(density):
    area_of_fine_mesh = sparsurf.mesh(SPHERES).vertices.area.sum()
    mesh = sparsurf.mesh(SPHERES, density=density)
    assert len(mesh.vertices) == pytest.approx(density * area_of_fine_mesh, rel=0.02, abs=1)


@pytest.mark.parametrize(
    "size", [{}, {"density": 1.0}, {"density": 3.0}, {"n_vertices": 1024}, {"n_vertices": 4096}]
)
def test_nothing_is_folded(size):
    """Triangles face along the normals of their corners, and the triangles around a vertex along its own: networks use both."""
    mesh = sparsurf.mesh(ROOT / "data/tdp43/topology.pdb", **size)
    a, b, c = (mesh.vertices.points[mesh.triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    assert (np.sum(across * mesh.vertices.normals[mesh.triangles].sum(axis=1), axis=1) > 0).all()
    for weighted in (across, across / np.linalg.norm(across, axis=1)[:, None]):
        of_mesh = np.zeros_like(mesh.vertices.points)
        np.add.at(of_mesh, mesh.triangles.ravel(), np.repeat(weighted, 3, axis=0))
        assert (np.sum(of_mesh * mesh.vertices.normals, axis=1) > 0).all()
    closed(mesh.triangles, len(mesh.vertices))


def test_a_mesh_has_the_size_that_is_requested():
    fine = sparsurf.mesh(SPHERES)
    assert len(sparsurf.mesh(SPHERES, 3 * len(fine.vertices)).vertices) == 3 * len(fine.vertices)
    assert np.array_equal(sparsurf.mesh(SPHERES, step=0.5).vertices.points, fine.vertices.points)
    ratio = len(sparsurf.mesh(SPHERES, step=0.25).vertices) / len(fine.vertices)
    assert ratio == pytest.approx(4, rel=0.1)
    for sizes in ({"density": 1.0}, {"step": 0.3}):
        with pytest.raises(InputError, match="either n_vertices"):
            sparsurf.mesh(SPHERES, 100, **sizes)


def test_a_volume_far_from_the_origin_keeps_its_digits():
    near, far = (sparsurf.mesh((np.add(SPHERES[0], shift), SPHERES[1]), step=0.3) for shift in (0, 9e5))
    assert far.volume == pytest.approx(near.volume, rel=1e-4)


# A hollow ball of 300 atoms, with one more in its middle
HOLLOW = 9.5 * np.array([[np.cos(k * 2.4) * np.sqrt(1 - z * z), np.sin(k * 2.4) * np.sqrt(1 - z * z), z]
                         for k, z in enumerate(np.linspace(-1, 1, 300))] + [[0.0, 0, 0]])  # fmt: skip


@pytest.mark.parametrize("turn", [0, 1])
def test_walls_of_cavities_are_no_part_of_the_mesh_of_a_molecule(turn):
    """Cavities of this protein meet the outside at cusps; an atom floats in a second cavity, and a molecule lies beside."""
    molecule = sparsurf.read_molecule(ROOT / "data/tdp43/topology.pdb")
    xyz = np.vstack([molecule.xyz[0], HOLLOW + np.array([80, 0, 0]), [[80, 30, 0]]])
    xyz = xyz @ Rotation.random(rng=np.random.default_rng(turn)).as_matrix()
    sizes = np.append(radii(molecule, "dms"), np.full(302, 1.9))
    keep, remove = (sparsurf.mesh((xyz, sizes), cavities=each) for each in ("keep", "remove"))
    assert closed(remove.triangles, len(remove.vertices))[1] == 3
    parts_of_dots = sparsurf.components((xyz, sizes), sparsurf.surface((xyz, sizes)))[1]
    assert parts_of_dots["cavity"].sum() == 5 and closed(keep.triangles, len(keep.vertices))[1] > 4
    outside = sparsurf.surface((xyz, sizes), cavities="remove")
    atom = len(xyz) - 2  # in the cavity of the ball, where it has dots of its own
    expected = outside.area[outside.atom != atom].sum()
    assert remove.vertices.area.sum() == pytest.approx(expected, rel=0.005)
    assert atom not in remove.vertices.atom and atom in keep.vertices.atom


def test_a_mesh_of_dots_is_that_of_their_spheres_with_or_without_cavities():
    spheres = (HOLLOW, np.full(301, 1.9))
    keep, remove = (sparsurf.mesh(spheres, cavities=each) for each in ("keep", "remove"))
    assert [closed(mesh.triangles, len(mesh.vertices))[1] for mesh in (keep, remove)] == [3, 1]
    given = sparsurf.surface(spheres)
    assert np.array_equal(sparsurf.mesh(given).triangles, keep.triangles)
    assert np.array_equal(sparsurf.mesh(given, cavities="remove").triangles, remove.triangles)
    assert np.array_equal(sparsurf.mesh(spheres).triangles, remove.triangles)
    with pytest.raises(InputError, match="cavities applies"):
        sparsurf.mesh(given.take(slice(0, 900)), cavities="remove")


@pytest.mark.parametrize("n_vertices", [None, 1500])
def test_a_vertex_belongs_to_the_atom_of_the_dots_there(n_vertices):
    dots = sparsurf.surface(ROOT / "data/tdp43/topology.pdb", density=60.0)
    mesh = sparsurf.mesh(dots, n_vertices)
    vertices, origin = mesh.vertices, mesh.vertices.origin
    gap = np.linalg.norm(vertices.points - origin.xyz[vertices.atom], axis=1) - origin.radii[vertices.atom]
    assert np.abs(gap[vertices.kind == 0]).max() < 1e-5 and (gap > -1e-5).all()
    of_dots = dots.atom[cKDTree(dots.points).query(vertices.points, k=4)[1]]
    is_inside = (of_dots == of_dots[:, :1]).all(axis=1)  # elsewhere the border between two atoms may pass
    assert is_inside.sum() > 300 and (of_dots[:, 0] == vertices.atom)[is_inside].mean() > 0.98
    table = mesh.to_frame()
    atoms = dots.molecule.labels(vertices.atom)
    assert all(np.array_equal(table[name], atoms[name]) for name in atoms)


def test_a_vertex_belongs_to_the_larger_of_two_atoms_in_one_place():
    xyz, sizes = np.array([[0, 0, 0], [3.0, 0, 0], [0, 0, 0], [3, 0, 0]]), np.array([1.2, 1.7, 1.7, 1.5])
    vertices = molecular_mesh(xyz, sizes).vertices
    assert set(vertices.atom) == {1, 2}
    assert np.array_equal(vertices.atom == 1, vertices.points[:, 0] > 1.5)


def test_vertices_have_fields():
    dots = sparsurf.surface(ROOT / "data/tdp43/topology.pdb", cavities="remove", probe_radius=1.7)
    mesh = sparsurf.mesh(dots, 800, fields=["roughness", "hydropathy"])
    fields, points = mesh.vertices.fields, mesh.vertices.points
    nearest = cKDTree(dots.points).query(points)[1]
    assert np.array_equal(fields["roughness"], sparsurf.roughness(dots)[nearest])
    assert np.array_equal(fields["hydropathy"], sparsurf.fields(mesh, "hydropathy")["hydropathy"])
    with pytest.raises(InputError, match="no field 'roughnes'; did you mean 'roughness'"):
        sparsurf.mesh(dots, 800, fields="roughnes")


def test_fields_of_dots_pass_to_their_mesh():
    dots = sparsurf.surface(([[0.0, 0, 0], [3, 0, 0]], [1.5, 1.5]))
    dots = replace(dots, fields={"x_of_dot": dots.points[:, 0]})
    vertices = sparsurf.mesh(dots, 100).vertices
    assert vertices.fields["x_of_dot"] == pytest.approx(vertices.points[:, 0], abs=0.05)


def test_vertices_have_a_bound_per_area():
    one = ([[0.0, 0, 0]], [1.5])
    assert len(sparsurf.mesh(one, 2000).vertices) == 2000
    with pytest.raises(
        InputError, match=r"10,000 vertices on 28 Å\^2 are more than 100 per Å\^2; ask for fewer"
    ):
        sparsurf.mesh(one, 10_000)
