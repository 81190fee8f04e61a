"""Distance of dots from the surface recovered from a few of them."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import conftest
from sparsurf.patches.index import build_grid
from sparsurf.recovery.errors import (
    MIN_CURVATURE,
    curvature,
    distance_to_recovered,
    distance_to_surface,
    error_table,
)
from sparsurf.surfaces.molecular_surface import roll_spheres


@pytest.fixture(scope="module")
def sphere():
    """Dots of a sphere of 8 Å, 5.4 per Å^2, with their normals."""
    return conftest.ball(4300, 8)


def test_a_tenth_of_a_sphere_gives_it_back(sphere):
    points, normals = sphere
    off = distance_to_recovered(points, points[::10], normals[::10])
    assert off[::10].max() < 1e-9
    assert off.max() < 0.05


def test_a_dot_off_the_surface_is_reported_by_how_much(sphere):
    points, normals = sphere
    moved = points.copy()
    moved[5] += 0.3 * normals[5]
    moved[7] -= 0.3 * normals[7]
    moved[9] += 5 * normals[9]
    off = distance_to_recovered(moved, points[::10], normals[::10], 2)
    assert off[[5, 7]] == pytest.approx(0.3, abs=0.03)
    assert off[9] == pytest.approx(5, abs=0.1)


def test_a_missing_cap_is_far(sphere):
    points, normals = sphere
    below = points[:, 2] < 4
    off = distance_to_recovered(points, points[below][::10], normals[below][::10])
    top = np.argmax(points[:, 2])
    assert off[top] > 1.0
    assert np.median(off[points[:, 2] < 3]) < 0.05


def test_a_plane_by_hand():
    # dots 1 Å apart on z = 0: above one of them the plane tells, 3 Å beyond the edge the nearest dot
    x, y = np.meshgrid(np.arange(5.0), np.arange(5.0))
    places = np.stack([x.ravel(), y.ravel(), np.zeros(25)], axis=1)
    up = np.tile([0.0, 0, 1], (25, 1))
    points = np.array([[2.3, 2.0, 0.5], [2.3, 2.0, -0.5], [7.0, 2.0, 0.0], [2.0, 2.0, 2.5], [2.0, 2.3, 0.0]])
    assert distance_to_surface(points, places, up) == pytest.approx([0.5, 0.5, 3.0, 2.5, 0.0])
    # 2 Å beyond the edge still lies within two spacings, 2.1 Å no more; of a single dot nothing but itself is near
    beyond = np.array([[6.0, 2, 0.0], [6.1, 2, 0.0]])
    assert distance_to_surface(beyond, places, up) == pytest.approx([0, 2.1])
    assert distance_to_surface(points[:1] * [0.2, 0, 1], places[:1], up[:1]) == pytest.approx(
        [np.hypot(0.46, 0.5)]
    )


def test_distances_are_those_of_the_nearest_of_all_dots(blob):
    dots, normals = blob
    rng = np.random.default_rng(5)
    # up to 12 Å from the surface: beyond 4 Å the nearest dot is found in another way
    points = dots[::7] + rng.uniform(0, 12, len(dots[::7]))[:, None] * normals[::7]
    surface, up = dots[::3], normals[::3]
    difference = points[:, None] - surface
    distances = np.sqrt((difference**2).sum(axis=2))
    nearest, least = distances.argmin(axis=1), distances.min(axis=1)
    apart = np.sqrt(((surface[::16, None] - surface) ** 2).sum(axis=2))
    spacing = np.median(np.sort(apart, axis=1)[:, 1])
    height = np.abs(((points - surface[nearest]) * up[nearest]).sum(axis=1))
    expected = np.where(least <= 2 * spacing, height, least)
    assert (least > 5).sum() > 20
    assert (least < 2 * spacing).sum() > 20
    assert np.abs(distance_to_surface(points, surface, up) - expected).max() < 1e-12


@pytest.mark.parametrize(("reentrant", "largest"), [("exact", 1e-6), ("dms", 0.05)])
def test_dots_of_known_spheres_deviate_by_nothing(reentrant, largest):
    """Planes of dots, which DMS's concave parts inside other probes need, deviate from a curved surface between its dots."""
    xyz = np.array([[0.0, 0, 0], [3, 0, 0], [1.5, 2.5, 0], [1.5, 1, 2.5]])
    rolled = roll_spheres(xyz, np.full(4, 1.7), 1.4, reentrant)
    points, dense = rolled.surface(8.0).points, rolled.surface(30.0)
    by_planes = distance_to_surface(points, dense.points, dense.normals)
    exact = distance_to_surface(points, dense.points, dense.normals, true=rolled)
    assert by_planes.mean() > 0.001 and exact.max() < largest
    assert (exact.max() < 1e-6) == (reentrant == "exact")
    # raised along the normals, by the height; and across a hole, by the distance from the nearest dot
    raised = distance_to_surface(points, dense.points + 0.05 * dense.normals, dense.normals, true=rolled)
    assert np.median(raised) == pytest.approx(0.05, abs=1e-6 if reentrant == "exact" else 2e-3)
    part = dense.take(np.flatnonzero(dense.points[:, 2] < 0))
    above = points[:, 2] > 1.5
    across = distance_to_surface(points[above], part.points, part.normals, true=rolled)
    assert across == pytest.approx(cKDTree(part.points).query(points[above])[0])


@pytest.mark.parametrize("radius", [4.0, 6.0])
def test_a_sphere_bends_by_one_over_its_radius_outside_and_inside(sphere, radius):
    points, normals = sphere
    for sign in (1, -1):
        bend = curvature(build_grid(points, sign * normals), radius)
        assert bend == pytest.approx(sign / 8, rel=0.01)  # exact but for dots that are not spread evenly


def test_without_another_radius_curvature_is_that_within_6(blob):
    index = build_grid(*blob)
    assert np.array_equal(curvature(index), curvature(index, 6.0, threads=2))
    assert not np.array_equal(curvature(index), curvature(index, 5.0))


def test_a_plane_does_not_bend_and_a_cylinder_half_as_much_as_a_sphere():
    u, v = (x.ravel() for x in np.meshgrid(np.arange(-15, 15, 0.5), np.arange(-15, 15, 0.5)))
    inner = np.hypot(u, v) < 8
    flat = np.c_[u, v, np.zeros(len(u))]
    assert np.abs(curvature(build_grid(flat, np.tile([0, 0, 1.0], (len(u), 1))))).max() < 1e-12
    a = 60.0  # wide against the 6 Å of a patch
    out = np.c_[np.sin(u / a), np.zeros(len(u)), np.cos(u / a)]
    bend = curvature(build_grid(a * out + np.c_[0 * u, v, 0 * u], out))
    assert bend[inner] == pytest.approx(1 / (2 * a), rel=0.02)


def test_the_wall_across_a_cleft_bends_nothing():
    points, up = np.random.default_rng(0).uniform(0, 20, (4000, 3)), np.zeros((4000, 3))
    points[:, 2] = np.where(np.arange(4000) % 2, 3.0, 0.0)
    up[:, 2] = np.where(np.arange(4000) % 2, -1.0, 1.0)  # two planes that face each other
    assert np.abs(curvature(build_grid(points, up))).max() < 1e-12
    assert curvature(build_grid(np.zeros((1, 3)), up[:1])).tolist() == [0]


def test_tails_by_hand():
    distance = np.arange(400.0)
    bend = np.repeat([-2 * MIN_CURVATURE, MIN_CURVATURE, -MIN_CURVATURE, 2 * MIN_CURVATURE], 100)
    found = error_table(distance, bend, np.empty(0, int)).set_index("where")
    assert found["dots"].to_dict() == {"everywhere": 400, "clefts": 100, "flats": 200, "ridges": 100}
    assert found["dots_percent"].tolist() == [100, 25, 50, 25]
    assert found["mean"].tolist() == [199.5, 49.5, 199.5, 349.5]
    assert found["high_99"].tolist() == pytest.approx([395.01, 98.01, 297.01, 398.01])
    assert found["largest"].tolist() == [399, 99, 299, 399]
    rest = error_table(distance, bend, np.arange(0, 400, 2)).set_index("where")  # odd ones were not kept
    assert rest["dots"].tolist() == [200, 50, 100, 50] and rest.loc["everywhere", "mean"] == 200
    assert rest["dots_percent"].tolist() == [100, 25, 50, 25]
    clefts = error_table(distance, np.ones(400), np.empty(0, int)).set_index("where").loc["clefts"]
    assert clefts[["dots", "dots_percent"]].tolist() == [0, 0] and clefts[["mean", "largest"]].isna().all()
