"""Roughness: exact cases, invariances, the plain formula, the authors' own numbers."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import naive
from conftest import sphere
from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness_of_patches


def plane(n=20, gap=0.3):
    x, y = np.meshgrid(np.arange(n) * gap, np.arange(n) * gap)
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    return points, np.tile([0.0, 0, 1], (len(points), 1))


def test_planes_and_lonely_dots_are_flat_and_opposite_normals_rough():
    assert np.allclose(roughness_of_patches(build_index(*plane())), 1.0, atol=1e-12)
    points = np.array([[0.0, 0, 0], [10, 0, 0], [10.2, 0, 0]])
    normals = np.array([[0.0, 0, 1], [0, 0, 1], [0, 0, -1]])
    assert roughness_of_patches(build_index(points, normals)).tolist() == [1.0, 0.0, 0.0]


def test_a_sphere_has_the_analytic_value():
    # A cap of a sphere of radius a cut by a ball of radius R around its pole has half-angle t with
    # cos t = 1 - R^2 / (2 a^2); the mean of the cosine to its axis is (1 + cos t)/2. The dots are a
    # spiral of near-equal areas: ragged edges leave an error of about the dot spacing over R, here 2 %.
    n, a, radius = 20000, 10.0, 4.0
    unit = sphere(n)[0]
    values = roughness_of_patches(build_index(a * unit, unit), radius)
    assert np.allclose(values, (1 + 1 - radius**2 / (2 * a**2)) / 2, rtol=1e-3)


def test_equals_the_plain_formula(blob):
    """Even of normals that are unit vectors only about, as those of DMS files are."""
    points, normals = blob[0], blob[1] * np.random.default_rng(5).uniform(0.9, 1.1, (len(blob[0]), 1))
    values = roughness_of_patches(build_index(points, normals, 0.8), 3.0)
    for i in range(0, len(points), 53):
        assert values[i] == pytest.approx(naive.roughness(points, normals, i, 3.0, 0.8), abs=1e-12)


@pytest.mark.parametrize(
    ("n", "d_link", "side"), [(63, 1.2, 7), (500, 0.9, 7), (900, 0.75, 7), (150, 6.0, 18)]
)
def test_patches_in_pieces_equal_the_plain_formula(n, d_link, side):
    """Scattered dots: some largest islands hold less than half of their ball, and not every dot is in its own patch."""
    rng = np.random.default_rng(n)
    points, normals = rng.uniform(0, side, (n, 3)), rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    values = roughness_of_patches(build_index(points, normals, d_link), 3.0)
    expected = [naive.roughness(points, normals, i, 3.0, d_link) for i in range(n)]
    assert np.abs(values - expected).max() < 1e-12


def test_a_rigid_motion_changes_nothing(blob):
    points, normals = blob
    turn = Rotation.random(rng=4).as_matrix()
    moved = roughness_of_patches(build_index(points @ turn.T + [5, -7, 3], normals @ turn.T, 0.8))
    assert np.allclose(moved, roughness_of_patches(build_index(points, normals, 0.8)), atol=1e-9)


def test_threads_change_nothing_and_4_is_the_radius_without_another(blob):
    index = build_index(*blob)
    assert np.array_equal(roughness_of_patches(index, threads=1), roughness_of_patches(index, 4.0, threads=3))


def test_equals_the_authors_values_on_a1(a1, shared):
    published = pd.read_csv(shared / "oracle" / "a1_roughness_R4.csv")["roughness"].to_numpy()
    values = roughness_of_patches(build_index(a1.points, a1.normals), 4.0)
    assert len(values) == 20045
    assert np.abs(values - published).max() < 1e-9
