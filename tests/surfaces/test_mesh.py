"""Meshes: closed and turned outwards whatever the values, with their corners on the surface, readable by others."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from conftest import ROOT
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.recovery.mesh import _assign_sides, _height, recovered_mesh
from sparsurf.recovery.recovering import recover
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.streams import Streams
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces import mesh as meshes
from sparsurf.surfaces.mesh import grid_step_for_density, marching_tetrahedra, molecular_mesh
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii

ATOMS = np.array([[0, 0, 0], [1.5, 0, 0], [2.2, 1.3, 0.2], [3.7, 1.4, 0.3], [4.3, 2.7, 0.9], [5, 5, 1]])
RADII = np.array([1.9, 1.5, 1.9, 1.4, 1.85, 1.7])
TURN = np.linspace(0, 2 * np.pi, 12, endpoint=False)
RING = np.column_stack([5 * np.cos(TURN), 5 * np.sin(TURN), 0 * TURN])
# the probe's way around the last two reaches as far from the middle one as an arc can
ROD = np.array([[0.0, 0, 0], [3.0, 0, 0], [8.0, 0, 0]])


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


def test_a_plane_is_met_exactly():
    """Values that are linear: the mesh of a half space lies on its plane."""
    x, y, z = np.indices((12, 12, 12)) - 5.2
    inside = np.minimum(4.5 - np.abs([x, y, z]).max(axis=0), 0.3 * x + 0.5 * y - 0.2 * z)
    vertices, triangles = marching_tetrahedra(inside)
    closed(triangles, len(vertices))
    height = (vertices - 5.2) @ [0.3, 0.5, -0.2]
    assert (np.abs(height) < 1e-9).sum() > 200


def test_a_sphere():
    mesh = molecular_mesh(np.ones((1, 3)), np.array([2.0]), step=0.3)
    assert closed(mesh.triangles, len(mesh.vertices)) == (2, 1)
    outward = mesh.vertices.points - 1
    assert np.linalg.norm(outward, axis=1) == pytest.approx(2, abs=1e-6)
    assert outward / 2 == pytest.approx(mesh.vertices.normals, abs=1e-6)
    assert mesh.vertices.area.sum() == pytest.approx(16 * np.pi, rel=5e-3)
    assert mesh.volume == pytest.approx(32 / 3 * np.pi, rel=1e-2) and mesh.volume < 32 / 3 * np.pi


def test_a_step_is_at_most_half_the_probes_radius():
    one = np.zeros((1, 3)), np.array([1.5])
    assert len(molecular_mesh(*one, probe=0.4).vertices) == len(molecular_mesh(*one, 0.4, 0.2).vertices)


def test_a_grid_goes_beyond_all_points_alike():
    low, shape = meshes.grid_around(np.array([[0.0, 0, 0], [1, 2, 3]]), 1.0, 0.5)
    assert low.tolist() == [-2, -2, -2] and (low + 0.5 * (shape - 1)).tolist() == [3, 4, 5]


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
    ("xyz", "sizes", "handles"), [(ATOMS, RADII, 0), (RING, np.full(12, 1.7), 1), (ROD, np.full(3, 1.7), 0)]
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
    k = np.arange(60) + 0.5
    polar, azimuth = np.arccos(1 - 2 * k / 60), np.pi * (1 + 5**0.5) * k
    unit = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=1)
    mesh = molecular_mesh(5 * unit, np.full(60, 1.7))
    assert closed(mesh.triangles, len(mesh.vertices)) == (4, 2)
    assert mesh.volume == pytest.approx(by_gauss(molecular_surface(5 * unit, np.full(60, 1.7))), rel=0.02)


def test_threads_and_places_do_not_matter():
    one, two = (molecular_mesh(ATOMS, RADII, threads=t) for t in (1, 2))
    assert np.array_equal(one.vertices.points, two.vertices.points)
    moved = molecular_mesh(ATOMS + 64.0, RADII)
    assert np.array_equal(moved.triangles, one.triangles)
    assert moved.vertices.points - 64 == pytest.approx(one.vertices.points, abs=1e-9)


def test_a_grid_that_is_too_fine_is_refused(monkeypatch):
    monkeypatch.setattr(meshes, "MAX_GRID_POINTS", 1000)
    with pytest.raises(InputError, match="Å would have"):
        molecular_mesh(ATOMS, RADII)


def test_the_recovered_surface_as_a_mesh():
    dots = molecular_surface(ATOMS, RADII)
    prepared = PreparedSurface(dots, streams=Streams(1))
    kept = SAMPLERS["farthest"](prepared, len(dots) // 8, np.random.default_rng(0))
    mesh, true = recovered_mesh(dots.points[kept], dots.normals[kept]), molecular_mesh(ATOMS, RADII)
    assert closed(mesh.triangles, len(mesh.vertices)) == (2, 1)
    assert mesh.volume == pytest.approx(true.volume, rel=0.015)
    assert mesh.vertices.area.sum() == pytest.approx(true.vertices.area.sum(), rel=0.03)
    again = recovered_mesh(dots.points[kept], dots.normals[kept], threads=2)
    assert np.array_equal(mesh.vertices.points, again.vertices.points)


def test_a_recovered_mesh_is_cut_where_distances_are_known_and_lies_on_the_surface(monkeypatch):
    k = np.arange(60) + 0.5
    z, turn = 1 - 2 * k / 60, np.pi * (1 + 5**0.5) * k
    unit = np.stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z], axis=1)
    seen = []
    monkeypatch.setattr(
        "sparsurf.recovery.mesh.marching_tetrahedra",
        lambda values: (seen.append(values), marching_tetrahedra(values))[1],
    )
    mesh, (dense, outward) = recovered_mesh(3 * unit, unit, step=0.3), recover(3 * unit, unit)
    low, high = slice(None, -1), slice(1, None)
    for step in np.ndindex(2, 2, 2):
        here, there = (
            seen[0][tuple(way[c] for c in step)] for way in ((slice(None), low), (slice(None), high))
        )
        cut = (here > 0) != (there > 0)
        # rooms inside and outside are filled with 1 and -1
        assert not np.isin([here[cut], there[cut]], [1, -1]).any()
    # a third step would move nothing
    assert np.abs(_height(cKDTree(dense), outward, mesh.vertices.points, 1)[0]).max() < 1e-5


def test_rooms_take_the_side_of_their_walls_and_the_corner_is_outside():
    values, near = np.ones((5, 5, 5)), np.ones((5, 5, 5), bool)
    values[:, :, 3:] = -1
    near[1, 1, 1] = near[3, 3, 4] = near[1, 3, 2] = False
    values[~near] = 0
    filled, agreed = _assign_sides(values, near)
    # five walls inside, one outside, of the third room
    assert filled[1, 1, 1] == 1 and filled[3, 3, 4] == -1 and filled[1, 3, 2] == 1
    assert not agreed
    near[1, 3, 2], values[1, 3, 2] = True, 1
    filled, agreed = _assign_sides(values, near)
    assert agreed and np.array_equal(filled[near], values[near])
    near[0, 0, 0] = False
    filled, agreed = _assign_sides(values, near)
    assert filled[0, 0, 0] == -1 and not agreed


def test_a_place_is_seen_from_the_dots_of_its_own_side():
    sheet = np.array([[0.0, 0, 0], [0.5, 0, 0], [0, 0.5, 0]])
    dense, outward = (
        np.concatenate([sheet, sheet - [0, 0, 0.3]]),
        np.repeat([[0, 0, 1.0], [0, 0, -1.0]], 3, axis=0),
    )
    height, across = _height(cKDTree(dense), outward, np.array([[0.1, 0.1, 0.2]]), 1)
    assert height == pytest.approx([0.2]) and across == pytest.approx(np.array([[0, 0, 1.0]]))


def test_holes_are_closed_and_an_end_is_reported(caplog):
    """Dots of a ball without those of a cap: the inside stays one; a sheet has none."""
    k = np.arange(700) + 0.5
    z, turn = 1 - 2 * k / len(k), np.pi * (1 + 5**0.5) * k
    unit = np.stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z], axis=1)
    unit = unit[unit[:, 2] < 0.92]  # a hole of 5 Å, where the recovered surface goes on by half an Å
    mesh = recovered_mesh(6 * unit, unit)
    assert closed(mesh.triangles, len(mesh.vertices)) == (2, 1)
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 6**3, rel=0.03)
    assert not caplog.records
    sheet = recovered_mesh(6 * unit[unit[:, 2] < 0], unit[unit[:, 2] < 0])
    closed(sheet.triangles, len(sheet.vertices))
    assert "leave holes wider than 8.0 Å" in caplog.text


@pytest.mark.parametrize("name", ["ala3_3res.pdb", "A6PA6_13res_nochain.pdb", "7etn_tiny.cif.gz", "1ubi.pdb"])
def test_proteins_close(shared, name):
    """The mesh of the atoms, and that of a tenth of their dots."""
    molecule = read_molecule(shared / "data" / "structures" / name, selection=None)
    xyz, sizes = molecule.xyz[0], radii(molecule, "dms")
    true, dots = molecular_mesh(xyz, sizes), molecular_surface(xyz, sizes)
    closed(true.triangles, len(true.vertices))
    assert true.vertices.area.sum() == pytest.approx(dots.area.sum(), rel=0.005)
    kept = SAMPLERS["farthest"](PreparedSurface(dots), len(dots) // 10, np.random.default_rng(0))
    back = recovered_mesh(dots.points[kept], dots.normals[kept])
    closed(back.triangles, len(back.vertices))
    assert back.volume == pytest.approx(true.volume, rel=0.015)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Meshes as the command line writes them: of a peptide, and of what an eighth of its dots gives back."""
    place = tmp_path_factory.mktemp("meshes")
    read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-213").write_pdb(
        place / "protein.pdb"
    )
    calls = [
        ["surface", "protein.pdb", "--mesh", "-o", "true.ply"],
        ["minimal", "protein.pdb", "--percent", "12", "-o", "few.csv"],
        ["recover", "few.csv", "--mesh", "-o", "back.ply"],
        ["recover", "few.csv", "--mesh", "--density", "15", "-o", "fine.ply"],
    ]
    for name, *rest in calls:
        words = [str(place / word) if "." in word else word for word in rest]
        assert command.main([name, *words]) == 0
    return place


def test_written_meshes_are_closed(files):
    found = {}
    for name in ("true", "back", "fine"):
        lines = (files / f"{name}.ply").read_text().splitlines()
        n, m = (int(line.split()[2]) for line in lines if line.startswith("element"))
        body = lines[lines.index("end_header") + 1 :]
        points = np.array([line.split()[:3] for line in body[:n]], float)
        triangles = np.array([line.split() for line in body[n:]], int)[:, 1:]
        assert len(triangles) == m and closed(triangles, n)[0] <= 2
        found[name] = volume(points, triangles), n
    assert found["back"][0] == pytest.approx(found["true"][0], rel=0.02)
    assert found["fine"][1] > 2 * found["back"][1]
    assert grid_step_for_density(4 * 5.35) == pytest.approx(grid_step_for_density(5.35) / 2)


def test_a_mesh_is_a_ply(files, capsys):
    assert command.main(["surface", str(files / "protein.pdb"), "--mesh", "-o", str(files / "x.csv")]) == 1
    assert "cannot be written as '.csv'" in capsys.readouterr().err
