"""Curvature at dots in closed form: on one sphere, two and three, and over closed surfaces; smoothed, against fine meshes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT
from sparsurf.dot_fields import named_fields
from sparsurf.errors import InputError

NAMES = ["mean_curvature", "gaussian_curvature", "shape_index"]


def curvature(spheres, n=2000, **rules):
    few = sparsurf.points(spheres, n, fields=NAMES, **rules)
    return few, *(few.surface.fields[name] for name in NAMES)


def test_one_sphere():
    _, mean, gaussian, shape = curvature(([[1.0, 2, 3]], [1.7]))
    assert (
        mean == pytest.approx(1 / 1.7)
        and gaussian == pytest.approx(1 / 1.7**2)
        and shape == pytest.approx(1.0)
    )


@pytest.mark.parametrize("probe", [1.4, 1.8])
def test_two_spheres(probe):
    """The torus around the axis x: its height is that of the probe's centre minus the height above the dot."""
    r, d = 1.7, 3.0
    few, mean, gaussian, shape = curvature(([[0.0, 0, 0], [d, 0, 0]], [r, r]), probe_radius=probe)
    contact, saddle = few.kind == 0, few.kind == 1
    assert mean[contact] == pytest.approx(1 / r) and saddle.sum() > 200 and (contact | saddle).all()
    rho = np.hypot(*few.surface.points[saddle, 1:].T)
    around = (
        (np.sqrt((r + probe) ** 2 - d**2 / 4) - rho) / probe / rho
    )  # cosine of the normal to the radius, over rho
    assert mean[saddle] == pytest.approx((around - 1 / probe) / 2, rel=1e-4)
    assert gaussian[saddle] == pytest.approx(-around / probe, rel=1e-4)
    k1, k2 = around, -1 / probe
    assert shape[saddle] == pytest.approx(2 / np.pi * np.arctan((k1 + k2) / (k1 - k2)), abs=1e-4)


@pytest.mark.parametrize(
    "spheres",
    [
        ([[0.0, 0, 0], [3, 0, 0]], [1.7, 1.5]),
        ([[0.0, 0, 0], [2.6, 0, 0], [1.3, 2.2, 0]], [1.7, 1.6, 1.8]),  # with two concave triangles
    ],
)
def test_the_whole_of_a_closed_surface_has_the_curvature_of_a_sphere(spheres):
    """Gauss and Bonnet: the integral of the Gaussian curvature is 4 pi."""
    dots = sparsurf.surface(spheres, density=60.0)
    few = sparsurf.points(spheres, density=20.0, fields="gaussian_curvature")
    assert set(few.kind) == set(dots.kind) and len(set(dots.kind)) == len(spheres[1])
    assert few.area @ few.fields["gaussian_curvature"] == pytest.approx(4 * np.pi, rel=0.03)


@pytest.mark.parametrize("probe", [1.4, 1.6])
def test_three_spheres_have_a_concave_triangle(probe):
    spheres = [[0.0, 0, 0], [2.6, 0, 0], [1.3, 2.2, 0]], [1.7, 1.7, 1.7]
    few, mean, gaussian, shape = curvature(spheres, probe_radius=probe)
    concave = few.kind == 2
    assert concave.sum() > 20 and mean[concave] == pytest.approx(-1 / probe)
    assert gaussian[concave] == pytest.approx(1 / probe**2) and shape[concave] == pytest.approx(-1.0)
    assert (gaussian[few.kind == 1] < 0).all()


def test_a_protein_has_curvature_at_every_dot_and_point():
    path = ROOT / "data/tdp43/topology.pdb"
    dots = sparsurf.surface(path)
    table = sparsurf.fields(dots, NAMES)
    assert table.notna().all().all() and table["shape_index"].abs().max() <= 1
    saddle = dots.kind == 1
    assert (table["gaussian_curvature"][saddle] < 0).all() and (
        table["gaussian_curvature"][~saddle] > 0
    ).all()
    few = sparsurf.points(path, 400, fields=NAMES, cavities="keep")
    rows = {row.tobytes(): n for n, row in enumerate(dots.points.astype(np.float32))}
    chosen = [rows[row.tobytes()] for row in few.points]
    for name in NAMES:
        assert few.fields[name] == pytest.approx(table[name].to_numpy()[chosen], rel=1e-3, abs=1e-4)
    mesh = sparsurf.mesh(path, 400, fields=NAMES)
    assert np.isfinite(mesh.vertices.fields["mean_curvature"]).all()


def integrals_of_mesh(mesh):
    """Mean and Gaussian curvature around each vertex times area: by the angles at its edges, and by its angle defect."""
    corners, triangles = mesh.vertices.points, mesh.triangles
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    n, (u, v) = len(corners), np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]).T
    order = np.argsort(u * n + v)  # every edge occurs once in each direction
    left = np.tile(np.arange(len(triangles)), 3)
    right = left[order[np.searchsorted(u * n + v, v * n + u, sorter=order)]]
    edge = corners[v] - corners[u]
    length = np.linalg.norm(edge, axis=1)
    sine = (np.cross(normals[left], normals[right]) * edge).sum(axis=1) / length
    turn = np.arctan2(sine, (normals[left] * normals[right]).sum(axis=1))
    mean = np.bincount(u, length * turn / 4, n)  # a half of length * turn / 2; v gets the other half
    gaussian = np.full(n, 2 * np.pi)
    for k in range(3):
        here, one, two = (corners[triangles[:, (k + step) % 3]] for step in range(3))
        one, two = one - here, two - here
        cosine = (one * two).sum(axis=1) / np.linalg.norm(one, axis=1) / np.linalg.norm(two, axis=1)
        np.subtract.at(gaussian, triangles[:, k], np.arccos(cosine))
    return {"mean_curvature": mean, "gaussian_curvature": gaussian}


def smoothed(mesh, name, radius):
    """Mean over the patch around each of 400 vertices, of the field and of the mesh."""
    corners, area = mesh.vertices.points, mesh.vertices.area
    patches = cKDTree(corners).query_ball_point(corners[:: max(1, len(corners) // 400)], radius)
    exact, of_mesh = area * mesh.vertices.fields[name], integrals_of_mesh(mesh)[name]
    return np.array([[exact[p].sum(), of_mesh[p].sum()] / area[p].sum() for p in patches]).T


@pytest.mark.parametrize("name", ["mean_curvature", "gaussian_curvature"])
@pytest.mark.parametrize(
    "spheres",
    [
        ([[0.0, 0, 0], [3, 0, 0]], [1.7, 1.5]),
        ([[0.0, 0, 0], [2.6, 0, 0], [1.3, 2.2, 0]], [1.7, 1.6, 1.8]),
    ],
)
def test_smoothed_curvature_is_that_of_a_fine_mesh(spheres, name):
    """Measured: 0.003 to 0.016 rms at densities of 17 to 30, of a standard deviation of 0.1 to 0.15."""
    exact, of_mesh = smoothed(sparsurf.mesh(spheres, density=25.0, fields=name), name, 2.0)
    assert np.sqrt(np.mean((exact - of_mesh) ** 2)) < 0.013 and np.corrcoef(exact, of_mesh)[0, 1] > 0.99


def test_smoothed_mean_curvature_of_a_protein_is_that_of_its_mesh():
    """But for ridges where concave parts meet, at which only a mesh has curvature. Measured: 0.974 and 0.023 of 0.18 1/Å."""
    mesh = sparsurf.mesh(ROOT / "data/tdp43/topology.pdb", fields="mean_curvature")
    exact, of_mesh = smoothed(mesh, "mean_curvature", 3.0)
    assert np.corrcoef(exact, of_mesh)[0, 1] > 0.96 and np.median(np.abs(exact - of_mesh)) < 0.03


def test_buried_atoms_do_not_count_however_many_are_nearer():
    """Forty in one of two spheres, nearer to the probe than the other sphere."""
    spheres, inside = ([[0.0, 0, 0], [3, 0, 0]], [1.5, 1.9]), np.random.default_rng(0).normal(size=(40, 3))
    crowded = np.vstack([spheres[0], 0.05 * inside]), [*spheres[1], *[0.5] * 40]
    dots, of_crowd = (sparsurf.surface(each) for each in (spheres, crowded))
    assert np.allclose(of_crowd.points, dots.points)
    for name in NAMES:
        wanted, found = (getattr(named_fields, name)(each) for each in (dots, of_crowd))
        assert np.allclose(found, wanted, atol=1e-6)


def test_dots_of_unknown_kind_have_no_curvature():
    dots = sparsurf.surface(([[0.0, 0, 0], [3, 0, 0]], [1.7, 1.5]))
    unknown = np.arange(len(dots)) % 3 == 0
    lacking = replace(dots, kind=np.where(unknown, -1, dots.kind))
    for name in NAMES:
        whole, found = (getattr(named_fields, name)(each) for each in (dots, lacking))
        assert np.isnan(found[unknown]).all() and np.array_equal(found[~unknown], whole[~unknown])


def test_curvature_needs_dots_that_were_placed():
    path = ROOT / "data/tdp43/topology.pdb"
    dots = sparsurf.surface(path)
    with pytest.raises(InputError, match="curvature follows"):
        sparsurf.fields(path, (dots.points, dots.normals), "mean_curvature")
