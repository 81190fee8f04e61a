"""The renderer against spheres whose picture is known, against a slow twin, and turned about."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sparsurf.report.figures import render

RED, BLUE = (0.8, 0.1, 0.1), (0.1, 0.1, 0.8)
LAMP = render.LIGHT / np.linalg.norm(render.LIGHT)


def sphere(n, radius):
    """Points and normals of an evenly covered sphere (golden spiral)."""
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    normals = np.column_stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z])
    return radius * normals, normals


def lumpy(n, seed):
    """Points and normals of a closed surface without any symmetry, the normals from its gradient."""
    _, unit = sphere(n, 1.0)
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
    points, normals = sphere(20000, 10.0)
    picture = render.picture(render.draw_surface(points, normals, RED, camera()))
    radius = render.closing_radius(points)
    # discs at the rim stick out by r^2 / 2R; the edge is known to half a drawn pixel, 0.025 Å
    area = drawn(picture).sum() / 100
    assert np.pi * (10 - 0.025) ** 2 < area < np.pi * (10 + radius**2 / 20 + 0.05) ** 2
    x, y = np.meshgrid(np.arange(280) - 139.5, 119.5 - np.arange(240))
    assert drawn(picture)[np.hypot(x, y) < 99].all()


def test_sphere_is_shaded_by_lambert():
    points, normals = sphere(20000, 10.0)
    scene = render.draw_surface(points, normals, (1.0, 1.0, 1.0), camera())
    y, x = np.mgrid[0 : scene.depth.shape[0], 0 : scene.depth.shape[1]] + 0.5
    x, y = (x - x.mean()) / 20, (y.mean() - y) / 20
    inner = np.hypot(x, y) < 9  # the haze is white upon a white surface: only the lamp is left to see
    normal = np.stack([x, y, np.sqrt(np.maximum(100 - x**2 - y**2, 0))], axis=-1)[inner] / 10
    bright = render.AMBIENT + (1 - render.AMBIENT) * (normal @ LAMP).clip(0)
    z = (10 - 10 * normal[:, 2]) / 10  # depth below the front over the depth of the visible half
    expected = bright + render.HAZE * z * (1 - bright)
    # blended normals differ from the sphere's by less than the spacing of the dots, 0.025 in radians
    np.testing.assert_allclose(scene.colour[inner][:, 0], expected, atol=0.03)
    np.testing.assert_allclose(scene.depth[inner] / 20, 10 * normal[:, 2], atol=0.1)


def test_a_picture_is_the_mean_of_what_was_drawn_darkened():
    rng = np.random.default_rng(0)
    colour, dark = rng.random((12, 20, 3)).astype(np.float32), rng.random((12, 20))
    scene = render.Scene(camera(shape=(6, 10)), colour, np.zeros((12, 20)), dark, 1.0)
    expected = 255 * (colour * dark[..., None]).reshape(6, 2, 10, 2, 3).mean(axis=(1, 3))
    found = render.picture(scene)
    assert found.dtype == np.uint8 and found.shape == (6, 10, 3)
    assert np.abs(found - expected).max() <= 0.5 + 1e-4  # rounded; single precision


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
    points, normals = sphere(5000, 8.0)
    scene = render.draw_surface(points, normals, render.PALE, camera())
    back = points[:, 2] < -0.5
    dotted = render.draw_dots(scene, points[back], normals[back], RED)
    np.testing.assert_array_equal(render.picture(dotted), render.picture(scene))
    behind, up = plane(-5.0)  # faces the viewer, but the sphere is in front
    inside = np.hypot(*behind[:, :2].T) < 5
    dotted = render.draw_dots(scene, behind[inside], up[inside], RED)
    np.testing.assert_array_equal(render.picture(dotted), render.picture(scene))


def test_dot_has_the_area_of_its_disc():
    points, normals = plane(0.0)
    scene = render.draw_surface(points, normals, render.PALE, camera(scale=40.0))
    tilt = Rotation.from_euler("x", 60, degrees=True).apply(normals)
    for normal, share in ((normals, 1.0), (tilt, 0.5)):
        dotted = render.draw_dots(scene, points[:1] * 0, normal[:1], RED, radius=0.5)
        red = (dotted.colour != scene.colour).any(axis=2).sum() / 80**2
        # a circle of 40 drawn pixels in radius covers its area to within 1 %
        assert red == pytest.approx(np.pi * 0.25 * share, rel=0.01)


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


@settings(max_examples=15, deadline=None)
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


def test_order_of_the_dots_does_not_matter():
    points, normals = lumpy(3000, 1)
    colours = np.random.default_rng(0).random(points.shape)
    view = render.aim(points, render.along_smallest_axis(points), (150, 200))
    shuffled = np.random.default_rng(1).permutation(len(points))
    one, other = (
        render.picture(render.draw_surface(points[i], normals[i], colours[i], view, radius=0.6))
        for i in (np.arange(len(points)), shuffled)
    )
    np.testing.assert_array_equal(one, other)


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


def test_views():
    points, normals = lumpy(2000, 4)
    extent = np.ptp(points @ render.along_smallest_axis(points).T, axis=0)
    spread = np.std(points @ render.along_smallest_axis(points).T, axis=0)
    assert spread[0] >= spread[1] >= spread[2]
    view = render.aim(points, render.along_smallest_axis(points), (120, 200))
    left, right, bottom, top = view.extent
    margin = 2 * render.MAX_DISC_RADIUS - 1e-9
    assert right - left >= extent[0] + margin and top - bottom >= extent[1] + margin
    # and no wider than that: one side is full
    assert min(right - left - extent[0], top - bottom - extent[1]) == pytest.approx(
        2 * render.MAX_DISC_RADIUS
    )
    cap = normals @ [0.6, 0.0, 0.8] > 0.5
    rotation = render.oblique(points[cap], normals[cap], tilt=40)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    mean = normals[cap].mean(axis=0)
    expected = [0, np.cos(np.radians(40)), np.sin(np.radians(40))]
    np.testing.assert_allclose(rotation @ mean / np.linalg.norm(mean), expected, atol=1e-6)


@pytest.mark.parametrize("n", [1, 2, 3, 30])
def test_few_dots(n):
    points, normals = sphere(n, 3.0)
    normals = np.abs(normals) + np.array([0, 0, 0.2])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    for rotation in (render.along_smallest_axis(points), render.oblique(points, normals)):
        scene = render.draw_surface(points, normals, RED, render.aim(points, rotation, (60, 80)))
        assert render.picture(render.draw_dots(scene, points[:0], normals[:0], BLUE)).shape == (60, 80, 3)
    front = render.draw_surface(points, normals, RED, camera())
    assert drawn(render.picture(front)).any()


def test_many_dots_in_a_small_picture():
    points, normals = sphere(300_000, 70.0)
    picture = render.picture(
        render.draw_surface(points, normals, RED, render.aim(points, np.eye(3), (60, 60)))
    )
    # 60 pixels hold 2 * (70 + 1.2) Å
    assert drawn(picture).sum() == pytest.approx(np.pi * (30 * 70 / 71.2) ** 2, rel=0.03)
