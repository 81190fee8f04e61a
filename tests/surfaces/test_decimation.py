"""Coarse meshes: closed, of the same topology, every vertex one of the fine mesh, sides about equally long."""

from dataclasses import replace

import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.errors import InputError
from sparsurf.surfaces.decimation import decimate
from sparsurf.surfaces.mesh import molecular_mesh

TURN = np.linspace(0, 2 * np.pi, 12, endpoint=False)
RING = np.column_stack([5 * np.cos(TURN), 5 * np.sin(TURN), 0 * TURN])


@pytest.fixture(scope="module")
def ring():
    """A torus, and a ball beside it."""
    xyz = np.vstack([RING, [[20, 0, 0]]])
    return molecular_mesh(xyz, np.full(len(xyz), 1.7))


def euler_of_closed(mesh):
    """Euler number, after a check that each edge belongs to two triangles, in opposite directions, and each vertex to a disc."""
    corners = mesh.triangles
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    directed = {tuple(edge) for edge in edges.tolist()}
    assert len(directed) == len(edges) and all((b, a) in directed for a, b in directed)
    after = {
        (a, b): c for triangle in corners.tolist() for a, b, c in (np.roll(triangle, k) for k in range(3))
    }
    for vertex in range(len(mesh.vertices)):
        around = [b for a, b in after if a == vertex]
        walk = [around[0]]
        while (following := after[vertex, walk[-1]]) != walk[0]:
            walk.append(following)
        assert len(walk) == len(around)
    return len(mesh.vertices) - len(edges) // 2 + len(corners)


def test_a_ring_stays_a_ring_whose_vertices_are_those_of_the_fine_mesh(ring):
    coarse = decimate(ring, 60)
    assert len(coarse.vertices) == 60 and euler_of_closed(coarse) == 2
    rows = {
        np.float32(row).tobytes() for row in np.hstack([ring.vertices.points, ring.vertices.normals]).tolist()
    }
    kept = np.hstack([coarse.vertices.points, coarse.vertices.normals]).astype(np.float32)
    assert all(row.tobytes() in rows for row in kept)
    with pytest.raises(InputError, match="at least"):
        decimate(ring, 8)


def test_sides_are_about_equally_long_and_close_the_volume():
    path = ROOT / "data/tdp43/topology.pdb"
    mesh = sparsurf.mesh(path, 1024)
    points, corners = mesh.vertices.points, mesh.triangles
    sides = np.linalg.norm(points[corners] - points[np.roll(corners, 1, axis=1)], axis=2)
    assert len(mesh.vertices) == 1024 and (sides < 0.3 * np.median(sides)).mean() < 0.01
    assert mesh.volume == pytest.approx(7870, rel=0.03)


def test_rounding_on_another_machine_changes_no_choice(ring):
    noise = np.random.default_rng(0).uniform(-1e-13, 1e-13, ring.vertices.points.shape)
    other = replace(ring, vertices=replace(ring.vertices, points=ring.vertices.points + noise))
    assert np.array_equal(decimate(other, 100).triangles, decimate(ring, 100).triangles)


def test_a_density_and_a_number_of_vertices_are_honoured():
    spheres = ([[0.0, 0, 0], [3, 0, 0]], [1.5, 1.5])
    fine = sparsurf.mesh(spheres, density=3.0)
    for density in (2.0, 0.5):
        coarse = sparsurf.mesh(spheres, density=density)
        assert len(coarse.vertices) == pytest.approx(density * fine.vertices.area.sum(), abs=1)
    assert len(sparsurf.mesh(spheres, 3 * len(fine.vertices)).vertices) == 3 * len(fine.vertices)
    with pytest.raises(InputError, match="either n_vertices or density"):
        sparsurf.mesh(spheres, 100, density=1.0)
