"""Triangles of the pieces of a surface: the handles that the surface has, on it, none thin, none through another."""

import itertools
import logging

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces import triangulation
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.mesh import MeshSize
from sparsurf.surfaces.molecular_surface import roll_spheres
from sparsurf.surfaces.radii import radii

THREE = MeshSize(density=3.0)
TURN = np.arange(6) * np.pi / 3


def euler_numbers(mesh):
    """V - E + F of each part of a mesh, ascending, after a check that each edge has two triangles that run against each other."""
    t, n = mesh.triangles, len(mesh.vertices)
    directed = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    key = directed[:, 0] * n + directed[:, 1]
    assert len(np.unique(key)) == len(key)
    assert np.array_equal(np.sort(key), np.sort(directed[:, 1] * n + directed[:, 0]))
    _, part = connected_components(coo_matrix((np.ones(len(directed)), directed.T), shape=(n, n)), False)
    return sorted((np.bincount(part) - np.bincount(part[t[:, 0]]) // 2).tolist())


def angles(points, triangles):
    """The smallest angle of each triangle, degrees."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    found = []
    for at, left, right in ((a, b, c), (b, c, a), (c, a, b)):
        u, v = left - at, right - at
        found.append(np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1)))
    return np.degrees(np.min(found, axis=0))


def n_cuts(points, triangles):
    """How many triangles are met by a side of another one with which they share no corner."""
    corners = points[triangles]
    centre = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    tree, cut = cKDTree(centre), set()
    pairs = tree.query_pairs(2 * reach.max(), output_type="ndarray")
    pairs = pairs[
        np.linalg.norm(centre[pairs[:, 0]] - centre[pairs[:, 1]], axis=1) < reach[pairs].sum(axis=1)
    ]
    apart = (triangles[pairs[:, 0]][:, :, None] != triangles[pairs[:, 1]][:, None, :]).all(axis=(1, 2))
    for one, other in (pairs[apart].T, pairs[apart][:, ::-1].T):
        a, b, c = corners[one].transpose(1, 0, 2)
        u, v = b - a, c - a
        for k in range(3):
            start = corners[other][:, k]
            way = corners[other][:, (k + 1) % 3] - start
            h = np.cross(way, v)
            det = (u * h).sum(axis=1)
            with np.errstate(divide="ignore", invalid="ignore"):
                s = start - a
                x = (s * h).sum(axis=1) / det
                q = np.cross(s, u)
                y, t = (way * q).sum(axis=1) / det, (v * q).sum(axis=1) / det
                cut |= set(one[(x > 0) & (y > 0) & (x + y < 1) & (t > 0) & (t < 1)].tolist())
    return len(cut)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("2k2d_A", [0, 2]),
        ("1a52_A", [-10, 2, 2, 2, 2]),
        ("3bd9_A", [-8, 2, 2, 2]),
        ("1zbu_B", [-26, 2, 2]),
    ],
)
def test_a_chain_has_its_handles_and_good_triangles(shared, name, expected):
    molecule = read_molecule(shared / f"data/chains/{name}.pdb.gz")
    xyz, sizes = molecule.xyz[0], radii(molecule)
    mesh = triangulation.molecular_mesh(xyz, sizes, size=THREE)
    assert euler_numbers(mesh) == expected
    points, triangles = mesh.vertices.points, mesh.triangles
    area = sparsurf.areas((xyz, sizes)).atoms["excluded"].sum()
    assert len(points) == round(3 * area) and -0.013 < mesh.area / area - 1 < 0
    smallest = angles(points, triangles)
    assert smallest.min() > 2 and (smallest < 5).mean() < 5e-4 and (smallest < 10).mean() < 0.001
    rolled = roll_spheres(xyz.round(3), sizes, 1.4)
    some = np.arange(0, len(triangles), 9)
    assert np.abs(exact_distance(points[triangles[some]].mean(axis=1), rolled)).max() < 0.2
    assert np.abs(exact_distance(points[::9], rolled)).max() < 1e-5


# Without a search for such triangles, one at least passes through another on each of these
@pytest.mark.parametrize(
    "name",
    ["1b6c_F", "1pl8_C", "1r54_A", "2bel_A", "2gf2_A", "2jr7_A", "2k2d_A", "3lea_B", "4liq_E", "4rsu_F"],
)
def test_no_triangle_of_a_chain_passes_through_another(shared, name):
    molecule = read_molecule(shared / f"data/chains/{name}.pdb.gz")
    mesh = triangulation.molecular_mesh(molecule.xyz[0], radii(molecule), size=THREE)
    assert n_cuts(mesh.vertices.points, mesh.triangles) == 0


def test_no_triangle_passes_through_another():
    for size in (THREE, MeshSize(density=0.8), MeshSize(step=0.7)):
        mesh = sparsurf.mesh(
            ROOT / "data/tdp43/topology.pdb", **{k: v for k, v in size._asdict().items() if v}
        )
        assert n_cuts(mesh.vertices.points, mesh.triangles) == 0
    tetrahedron = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    assert n_cuts(np.concatenate([tetrahedron, tetrahedron + 0.2]), np.concatenate([faces, faces + 4])) > 0


def lattice(step, n=4):
    """The atoms of a cubic lattice."""
    return step * np.array(list(itertools.product(range(n), repeat=3)), float)


@pytest.mark.parametrize(
    ("xyz", "expected"),
    [
        (4.0 * np.column_stack([np.cos(TURN), np.sin(TURN), 0 * TURN]), [0]),
        (5.0 * np.column_stack([np.cos(TURN), np.sin(TURN), 0 * TURN]), [0]),
        (6.0 * np.column_stack([np.cos(TURN), np.sin(TURN), 0 * TURN]), [2] * 6),
        (lattice(4.5), [-160]),
        (np.zeros((1, 3)), [2]),
        (np.array([[0, 0, 0], [5.5, 0, 0.0]]), [2]),
        (np.array([[0, 0, 0], [5.8, 0, 0.0]]), [2, 2]),  # the saddle between them comes to a point
    ],
)
@pytest.mark.parametrize("size", [THREE, MeshSize()])
def test_models_whose_handles_are_counted_by_hand(xyz, expected, size, caplog):
    mesh = triangulation.molecular_mesh(xyz, np.full(len(xyz), 1.7), size=size)
    assert euler_numbers(mesh) == expected and not caplog.records


@pytest.mark.parametrize("size", [{"density": 3.0}, {}])
def test_the_accessible_surface_is_closed_at_the_reach_of_its_atoms(size):
    """Its area is the sum of those of the atoms; two far atoms and a ring of six have it as by hand."""
    mesh = sparsurf.mesh(ROOT / "data/tdp43/topology.pdb", boundary="accessible", **size)
    molecule = read_molecule(ROOT / "data/tdp43/topology.pdb")
    vertices, reach = mesh.vertices, radii(molecule) + 1.4
    some = vertices.take(slice(None, None, 1 + len(vertices) // 2000))
    gap = np.linalg.norm(some.points[:, None] - molecule.xyz[0].round(3), axis=2) - reach
    assert np.abs(gap[np.arange(len(gap)), some.atom]).max() < 1e-5 and gap.min() > -1e-5
    exact = sparsurf.areas(molecule).atoms["accessible"].sum()
    assert -0.02 < mesh.area / exact - 1 < 0 and euler_numbers(mesh) == [-8]
    ring = 4.5 * np.column_stack([np.cos(TURN), np.sin(TURN), 0 * TURN])
    assert euler_numbers(sparsurf.mesh((ring, np.full(6, 1.7)), boundary="accessible", **size)) == [0]


def test_degenerate_pieces_are_told_and_dots_take_their_place(caplog):
    """Twelve atoms in a circle touch one probe on both sides of it, but for some 0.0003 Å."""
    turn, sizes = np.arange(12) * np.pi / 6, np.full(12, 1.7)
    regular = 3.0 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    xyz = regular + np.random.default_rng(8).normal(size=regular.shape) * 3e-4
    _, exact = sparsurf.components((regular, sizes))
    with caplog.at_level(logging.WARNING):
        _, found = sparsurf.components((xyz, sizes))
    assert "handles of this surface cannot be counted" in caplog.text
    assert found["handles"].isna().all() and exact["handles"].tolist() == [1]
    assert found["area"].sum() == pytest.approx(exact["area"].sum(), rel=0.01)
    assert found["volume"].sum() == pytest.approx(exact["volume"].sum(), rel=0.04)
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        mesh = sparsurf.mesh((xyz, sizes), density=3.0)
    assert "handles is that of the grid" in caplog.text and len(euler_numbers(mesh)) == 1
    assert mesh.volume == pytest.approx(exact["volume"].sum(), rel=0.04)
    nearest = cKDTree(xyz).query(mesh.vertices.points)[1]
    assert (mesh.vertices.atom == nearest).mean() > 0.9


def test_fewer_vertices_than_the_handles_need_are_refused():
    with pytest.raises(InputError, match=r"needs \d+ vertices at least"):
        triangulation.molecular_mesh(lattice(4.5), np.full(64, 1.7), size=MeshSize(n_vertices=40))
