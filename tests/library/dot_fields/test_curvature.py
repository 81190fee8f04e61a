"""Curvature at dots in closed form: on one sphere, two and three, and over closed surfaces as a whole."""

import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.errors import InputError

NAMES = ["mean_curvature", "gaussian_curvature", "shape_index"]
PROBE = 1.4


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


def test_two_spheres():
    """The torus around the axis x: its height is that of the probe's centre minus the height above the dot."""
    r, d = 1.7, 3.0
    few, mean, gaussian, shape = curvature(([[0.0, 0, 0], [d, 0, 0]], [r, r]))
    contact, saddle = few.kind == 0, few.kind == 1
    assert mean[contact] == pytest.approx(1 / r) and saddle.sum() > 200 and (contact | saddle).all()
    rho = np.hypot(*few.surface.points[saddle, 1:].T)
    around = (
        (np.sqrt((r + PROBE) ** 2 - d**2 / 4) - rho) / PROBE / rho
    )  # cosine of the normal to the radius, over rho
    assert mean[saddle] == pytest.approx((around - 1 / PROBE) / 2, rel=1e-4)
    assert gaussian[saddle] == pytest.approx(-around / PROBE, rel=1e-4)
    k1, k2 = around, -1 / PROBE
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


def test_three_spheres_have_a_concave_triangle():
    few, mean, gaussian, shape = curvature(([[0.0, 0, 0], [2.6, 0, 0], [1.3, 2.2, 0]], [1.7, 1.7, 1.7]))
    concave = few.kind == 2
    assert concave.sum() > 20 and mean[concave] == pytest.approx(-1 / PROBE)
    assert gaussian[concave] == pytest.approx(1 / PROBE**2) and shape[concave] == pytest.approx(-1.0)
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


def test_curvature_needs_dots_that_were_placed():
    path = ROOT / "data/tdp43/topology.pdb"
    dots = sparsurf.surface(path)
    with pytest.raises(InputError, match="curvature follows from the atoms that the dots were placed on"):
        sparsurf.fields(path, (dots.points, dots.normals), "mean_curvature")
