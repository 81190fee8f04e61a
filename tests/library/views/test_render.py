"""The renderer against spheres whose picture is known, against a slow twin, and turned about."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from conftest import ball
from sparsurf.views import render

RED, BLUE = (0.8, 0.1, 0.1), (0.1, 0.1, 0.8)
LAMP = render.LIGHT / np.linalg.norm(render.LIGHT)


def lumpy(n, seed):
    """Points and normals of a closed surface without any symmetry, the normals from its gradient."""
    _, unit = ball(n, 1.0)
    lobes = Rotation.random(6, random_state=seed).as_matrix()[:, 0] * np.linspace(1, 3, 6)[:, None]
    bump = np.exp(4 * (unit @ lobes.T / np.linalg.norm(lobes, axis=1) - 1)) * np.linspace(1, 4, 6)
    radius = 6 + bump.sum(axis=1)
    slope = 4 * bump @ (lobes / np.linalg.norm(lobes, axis=1)[:, None])
    slope -= (slope * unit).sum(axis=1)[:, None] * unit
    normals = unit - slope / radius[:, None]
    return radius[:, None] * unit, normals / np.linalg.norm(normals, axis=1)[:, None]


def plane(z, side=4.0, step=0.25):
    x, y = np.mgrid[-side : side + step / 2 : step, -side : side + step / 2 : step]
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)])
    return points, np.tile([0.0, 0.0, 1.0], (len(points), 1))


def camera(scale=10.0, shape=(240, 280), rotation=None):
    return render.Camera(np.eye(3) if rotation is None else rotation, np.zeros(3), scale, shape)


def drawn(picture):
    return (picture < 255).any(axis=2)


def test_sphere_has_the_area_of_a_disc_and_no_holes():
    points, normals = ball(20000, 10.0)
    picture = render.picture(render.draw_surface(points, normals, RED, camera()))
    radius = render.closing_radius(points)
    # discs at the rim stick out by r^2 / 2R; the edge is known to half a drawn pixel, 0.025 Å
    area = drawn(picture).sum() / 100
    assert np.pi * (10 - 0.025) ** 2 < area < np.pi * (10 + radius**2 / 20 + 0.05) ** 2
    x, y = np.meshgrid(np.arange(280) - 139.5, 119.5 - np.arange(240))
    assert drawn(picture)[np.hypot(x, y) < 99].all()


def test_the_bar_of_a_small_picture_is_ten_angstrom_long():
    """A ball of 15 Å across is half as wide again, seen from anywhere, but for the width of a pixel."""
    points, normals = ball(3000, 7.5)
    picture = render.thumbnail(points, normals, np.full(len(points), 0.6))
    bar = (picture == 0).all(axis=2).any(axis=0).sum()
    seen = drawn(picture[: picture.shape[0] - 10]).any(axis=0).sum()
    assert seen / bar == pytest.approx(1.5, abs=0.1)


@pytest.mark.parametrize(("upper", "seen"), [(RED, 0), (BLUE, 2)])
def test_front_hides_back(upper, seen):
    other = BLUE if upper == RED else RED
    (near, up), (far, _) = plane(3.0), plane(-3.0)
    colours = np.repeat([other, upper], len(near), axis=0)
    scene = render.draw_surface(np.vstack([far, near]), np.vstack([up, up]), colours, camera())
    picture = render.picture(scene).astype(int)
    assert (picture[drawn(picture)].argmax(axis=1) == seen).all()
    assert not (picture[drawn(picture)][:, 2 - seen] > picture[drawn(picture)][:, 1] + 1).any()


def test_what_faces_away_or_lies_behind_gets_no_dots():
    points, normals = ball(5000, 8.0)
    scene = render.draw_surface(points, normals, render.PALE_RGB, camera())
    back = points[:, 2] < -0.5
    dotted = render.draw_dots(scene, points[back], normals[back], RED)
    np.testing.assert_array_equal(render.picture(dotted), render.picture(scene))
    behind, up = plane(-5.0)  # faces the viewer, but the sphere is in front
    inside = np.hypot(*behind[:, :2].T) < 5
    dotted = render.draw_dots(scene, behind[inside], up[inside], RED)
    np.testing.assert_array_equal(render.picture(dotted), render.picture(scene))


def slow_twin(points, normals, colours, camera, radius, slack):
    """Depth and blended sums by testing every pixel against every disc in Å."""
    k = render.SUPERSAMPLING
    rows, columns = (k * n for n in camera.shape)
    step = 1 / (camera.scale * k)
    x, y = (np.arange(columns) + 0.5 - columns / 2) * step, (rows / 2 - np.arange(rows) - 0.5) * step
    depth, layers = np.full((rows, columns), -np.inf), []
    for p, n, colour in zip(
        (points - camera.centre) @ camera.rotation.T, normals @ camera.rotation.T, colours, strict=True
    ):
        if n[2] < render.MIN_VIEW_COSINE:
            continue
        z = p[2] - (n[0] * (x - p[0]) + n[1] * (y[:, None] - p[1])) / n[2]
        r = np.sqrt((x - p[0]) ** 2 + (y[:, None] - p[1]) ** 2 + (z - p[2]) ** 2)
        depth = np.where(r <= radius, np.maximum(depth, z), depth)
        layers.append((z, r, n, colour))
    sums = np.zeros((rows, columns, 7))
    for z, r, n, colour in layers:
        weight = np.where((r <= radius) & (z >= depth - slack), (1 - (r / radius) ** 2) ** 2 + 1e-6, 0)
        sums += weight[..., None] * np.concatenate([[1], n * [1, -1, 1], colour])
    return depth, sums


@settings(max_examples=15)
@given(st.integers(0, 10**6), st.integers(1, 15), st.floats(0.2, 3.0))
def test_kernels_equal_a_slow_twin(seed, n, radius):
    rng = np.random.default_rng(seed)
    points, colours = rng.uniform(-3, 3, (n, 3)), rng.random((n, 3))
    normals = rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    view = render.Camera(Rotation.random(random_state=seed).as_matrix(), rng.random(3), 7.0, (31, 40))
    depth = np.full((62, 80), -np.inf)
    sums = np.zeros((62, 80, 7))
    xyz, turned = render._project(points, normals, view)
    render.draw_discs(xyz, turned, radius * 14, depth)
    render.draw_discs(xyz, turned, radius * 14, depth, colours, 0.7 * radius * 14, sums)
    slow_depth, slow_sums = slow_twin(points, normals, colours, view, radius, 0.7 * radius)
    # the same numbers in pixels and in Å; steep discs lose up to three digits in dz
    np.testing.assert_allclose(depth / 14, slow_depth, atol=1e-9)
    np.testing.assert_allclose(sums, slow_sums, atol=1e-9)


def test_turned_molecule_gives_the_same_picture():
    points, normals = lumpy(3000, 2)
    colours = np.random.default_rng(0).random(points.shape)
    pictures = []
    for turn in Rotation.random(4, random_state=3):
        p, n = turn.apply(points) + 5.0, turn.apply(normals)
        rotation = render.along_smallest_axis(p)
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(rotation) == pytest.approx(1)
        pictures.append(
            render.picture(render.draw_surface(p, n, colours, render.aim(p, rotation, (150, 200))))
        )
    # rounding may move the rim of a disc across the middle of a pixel, seldom
    first, *others = np.array(pictures, int)
    assert all((np.abs(other - first) > 1).mean() < 1e-3 for other in others)
