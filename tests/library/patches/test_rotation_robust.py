"""The rotation-robust descriptor: exact shapes in any position, the plain method, few dots; and the registry it stands in."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import naive
from sparsurf import registry
from sparsurf.patches import descriptors
from sparsurf.patches.index import build_index
from sparsurf.patches.zernike import quadrature, rotation_robust
from sparsurf.patches.zernike.polynomials import indices
from subset_descriptors import evaluate

D_LINK = 0.8
TURNS = Rotation.random(4, random_state=3).as_matrix()
N, M = np.array(indices()).T


@pytest.fixture(scope="module")
def index(blob):
    return build_index(*blob, D_LINK)


def describe(points, normals, centre=(0.0, 0.0, 0.0), up=True):
    """Descriptor of the patch around one place, its dots linked whatever their distance."""
    z, _ = descriptors.describe_patches(
        build_index(points, normals, 3.0), np.array([centre]), up=up, descriptor="rotation_robust"
    )
    return z[0]


def sheet(height, slope, n=900):
    """Dots of z = height(x, y), 5.7 per Å^2 as seen from above, with unit normals."""
    k = np.arange(n) + 0.5
    r, t = 7.1 * np.sqrt(k / n), 2.399963 * k
    x, y = r * np.cos(t), r * np.sin(t)
    normals = np.stack([*(-s for s in slope(x, y)), np.ones(n)], axis=1)
    return np.stack([x, y, height(x, y)], axis=1), normals / np.linalg.norm(normals, axis=1)[:, None]


PLANE = sheet(lambda x, y: 0 * x, lambda x, y: (0 * x, 0 * x))
SPHERE = sheet(
    lambda x, y: np.sqrt(100 - x * x - y * y) - 10,
    lambda x, y: (-x / np.sqrt(100 - x * x - y * y), -y / np.sqrt(100 - x * x - y * y)),
)
SADDLE = sheet(lambda x, y: (x * x - y * y) / 24, lambda x, y: (x / 12, -y / 12))
SHAPES = {"plane": PLANE, "sphere": SPHERE, "saddle": SADDLE}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("up", [True, False])
def test_a_shape_is_the_same_after_any_rotation(shape, up):
    points, normals = SHAPES[shape]
    z = describe(points, normals, up=up)
    for turn in TURNS:
        w = describe(points @ turn.T, normals @ turn.T, up=up)
        assert np.linalg.norm(z - w) < 1e-3 * np.linalg.norm(z)


def exact(shape):
    """|c_nm| of r on a disc that the shape fills to its rim: r = distance to an apex 6 sqrt(2) Å below."""
    x, y, weight = quadrature.integration_points()
    height = {
        "plane": 0 * x,
        "sphere": np.sqrt(100 - 36 * (x * x + y * y)) - 10,
        "saddle": 1.5 * (x * x - y * y),
    }
    r = np.sqrt(36 * (x * x + y * y) + (height[shape] + 6 * np.sqrt(2)) ** 2)
    # both shapes are even in x and in y: a quarter gives all, sines vanish
    return np.abs(4 * (quadrature.harmonics(x, y).real * (M % 2 == 0)[:, None]) @ (weight * r))


@pytest.mark.parametrize("shape, error", [("plane", 1e-6), ("sphere", 0.4), ("saddle", 0.4)])
def test_shapes_have_the_descriptor_of_their_formula(shape, error):
    # but for the rim, where dots fade out and the field turns to the mean of wider bumps: in Å, of |z| = 9 Å
    assert np.linalg.norm(describe(*SHAPES[shape]) - exact(shape)) < error


def test_a_plane_has_coefficients_of_m_0_only():
    z = describe(*PLANE)
    assert np.abs(z[M > 0]).max() < 1e-9
    assert z[0] == pytest.approx(6 * 2 / 3 * (3**1.5 - 2**1.5), rel=1e-9)  # mean of sqrt(r^2 + 2) on the disc


def test_equals_the_plain_method(blob, index):
    points, normals = blob
    tests = np.arange(0, 3000, 600)
    for up in (True, False):
        z, sizes = descriptors.describe_patches(index, points[tests], up=up, descriptor="rotation_robust")
        for k, i in enumerate(tests):
            ids = naive.patch(points, i, 6.0, D_LINK)
            assert sizes[k] == len(ids)
            # the bumps come from a table of 256 places, exact to 2e-6
            assert (
                np.abs(z[k] - naive.rotation_robust(points[ids], normals[ids], points[i], up=up)).max() < 2e-5
            )


@pytest.mark.parametrize("share", [0.01, 0.2])
def test_subsets_and_weights_equal_the_plain_method(blob, index, share):
    points, normals = blob
    rng = np.random.default_rng(7)
    subset, tests = np.flatnonzero(rng.random(len(points)) < share), np.arange(5, 3000, 1000)
    weights = rng.uniform(0.2, 5, len(points))
    z, sizes = evaluate(
        index, points[tests], descriptors.pack_subsets(index, [subset]), 1, "full", weights=weights[index.dot][None],
        descriptor="rotation_robust",
    )  # fmt: skip
    for k, i in enumerate(tests):
        ids = np.intersect1d(naive.patch(points, i, 6.0, D_LINK), subset)
        plain = naive.rotation_robust(points[ids], normals[ids], points[i], weights=weights[ids])
        assert sizes[k, 0] == len(ids)
        assert np.abs(z[k, 0] - plain[rotation_robust.order()]).max() < 2e-5


@pytest.mark.parametrize("up", [True, False])
@pytest.mark.parametrize("cancel", [False, True])
def test_dots_that_face_all_ways_equal_the_plain_method(cancel, up):
    """In a ball of another radius; with two normals that cancel, nothing is turned but over."""
    points, normals = np.array([[1.0, 0.5, -0.5], [-0.5, 0.5, 1.0]]), np.array([[0.0, 0, 1], [0, 0, -1]])
    if not cancel:
        points, normals = np.random.default_rng(6).normal(size=(2, 90, 3))
        normals[:, 2] += 0.3
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    z, _ = descriptors.describe_patches(
        build_index(points, normals, 9.0), np.zeros((1, 3)), 4.5, up, descriptor="rotation_robust"
    )
    plain = naive.rotation_robust(points, normals, np.zeros(3), 4.5, up)
    assert np.abs(z[0] - plain).max() < 2e-5


def test_distances_are_those_of_the_descriptors(blob, index):
    points, _ = blob
    rng = np.random.default_rng(11)
    words = descriptors.pack_subsets(index, [np.flatnonzero(rng.random(len(points)) < 0.4) for _ in range(3)])
    z_tot, z, _ = descriptors.compare_descriptors(
        index, points[::300], words, 3, ("kept", "full"), descriptor="rotation_robust"
    )
    raw, _ = evaluate(index, points[::300], words, 3, "full", descriptor="rotation_robust")
    expected = np.linalg.norm(raw - z_tot[:, None, rotation_robust.order()], axis=2)
    assert np.allclose(z[:, 3:], expected, rtol=1e-12)
    _, alone, _ = descriptors.compare_descriptors(
        index, points[::300], words, 3, ("full",), z_tot, descriptor="rotation_robust"
    )
    assert np.allclose(alone, expected, rtol=1e-12)


def test_no_dot_is_the_zero_vector_and_one_dot_a_plane_through_it():
    up = np.array([[0.0, 0, 1]])
    index = build_index(np.array([[0.0, 0, 0], [0.3, 0, 0]]), np.repeat(up, 2, axis=0), 0.5)
    words = descriptors.pack_subsets(index, [[], [0], [1]])
    z, sizes = evaluate(index, np.zeros((1, 3)), words, 3, "kept", descriptor="rotation_robust")
    assert sizes.tolist() == [[0, 1, 1]]
    assert not z[0, 0].any()
    assert np.allclose(z[0, 1], describe(*PLANE)[rotation_robust.order()], atol=1e-9)
    assert np.allclose(z[0, 2], z[0, 1], atol=1e-9)


def test_dots_in_a_line_or_with_normals_that_cancel_have_a_descriptor():
    line = np.stack([np.linspace(-5, 5, 9), np.zeros(9), np.zeros(9)], axis=1)
    for normals in (np.tile([0.0, 0, 1], (9, 1)), np.tile([1.0, 0, 0], (9, 1))):
        assert np.isfinite(describe(line, normals)).all()
    ends = np.array([[0.0, 0, 1], [0.0, 0, -1]])
    assert np.isfinite(describe(np.array([[1.0, 0, 0], [-1.0, 0, 0]]), ends)).all()


def test_a_mirror_image_and_the_other_side_are_consistent(blob):
    points, normals = blob
    flip = np.array([1.0, -1.0, 1.0])
    z, mirrored, other = (
        descriptors.describe_patches(build_index(p, n, D_LINK), c, up=up, descriptor="rotation_robust")[0]
        for p, n, c, up in (
            (points, normals, points[::100], True),
            (points * flip, normals * flip, points[::100] * flip, True),
            (points, -normals, points[::100], False),  # seen from where the normals pointed
        )
    )
    assert np.abs(z - mirrored).max() < 0.02 * np.linalg.norm(z, axis=1).min()
    assert np.allclose(z, other, atol=1e-9)


def test_turning_moves_it_ten_times_less_than_the_published_one(blob, index):
    points, normals = blob
    turn = TURNS[0]
    turned = build_index(points @ turn.T, normals @ turn.T, D_LINK)
    share = {}
    for name in registry.TABLE["descriptor"]:
        z, w = (
            descriptors.describe_patches(i, p, descriptor=name)[0]
            for i, p in ((index, points[::60]), (turned, points[::60] @ turn.T))
        )
        share[name] = np.linalg.norm(z - w, axis=1).mean() / np.linalg.norm(z[1:] - z[:-1], axis=1).mean()
    assert share["rotation_robust"] < share["published"] / 10


@pytest.mark.parametrize("n, m", [(0, 0), (1, 1), (2, 0), (2, 2), (3, 1), (4, 2)])
def test_a_field_that_is_a_polynomial_has_its_one_coefficient(n, m):
    # cubic interpolation is exact to second order, so orders beyond 2 are approximate
    tables = quadrature.quarters(11)
    node = np.arange(-12, 13) / 11
    x, y = (k.ravel() for k in np.meshgrid(node, node))
    z = quadrature.harmonics(x, y)[indices().index((n, m))] * np.pi / (n + 1)
    parts = np.empty((4, 1, len(tables.row)))
    field = (z.real + 0.5 * z.imag).reshape(25, 25)
    rotation_robust._split(field, tables.row, tables.column, parts[:, 0])
    out = np.empty((1, 121))
    products = [a @ b for a, b in zip(parts, (*tables.even, *tables.odd), strict=True)]
    rotation_robust._moduli(*products, np.zeros(11), np.array([0, 1]), 1, out)
    expected = np.zeros(121)
    expected[indices().index((n, m))] = 1 if m == 0 else np.hypot(0.5, 0.25)
    assert np.abs(out[0] - expected[tables.order]).max() < (1e-9 if n <= 2 else 5e-3)


def test_a_field_in_place_of_the_height():
    """A constant field is its value at n = 0; a linear one along the patch has |c_11| of the plane; turns change nothing."""
    n = 4000
    rng = np.random.default_rng(3)
    r, t = 9 * np.sqrt(rng.random(n)), 2 * np.pi * rng.random(n)
    points = np.column_stack([r * np.cos(t), r * np.sin(t), np.zeros(n)])
    normals = np.tile([0, 0, 1.0], (n, 1))
    fields = np.array([np.full(n, 2.5), points[:, 0] / 6.0, np.sin(points[:, 1])])
    z = descriptors.describe_fields_of_patches(build_index(points, normals, 0.6), np.zeros((1, 3)), fields)[0]
    assert z[0, 0] == pytest.approx(2.5) and np.abs(z[0, 1:]).max() < 1e-9
    # x = r cos t on the unit disc: c_11 = (n + 1)/pi int r cos t R_11 e^{-it} = 1/2; the bumps flatten it by some percent
    assert z[1, 1] == pytest.approx(0.5, rel=0.1) and z[1, 0] == pytest.approx(0, abs=0.05)
    index, narrow = build_index(points, normals, 0.6), points[None, :, 0] / 4.0
    for threads in (1, 2):
        z_4 = descriptors.describe_fields_of_patches(index, np.zeros((1, 3)), narrow, 4.0, threads)[0, 0]
        assert z_4[1] == pytest.approx(0.5, rel=0.1)
    turn = TURNS[0]
    turned = descriptors.describe_fields_of_patches(
        build_index(points @ turn.T, normals @ turn.T, 0.6), np.zeros((1, 3)), fields
    )[0]
    np.testing.assert_allclose(turned, z, atol=0.05)  # the grid lies otherwise on the dots


def test_the_height_as_a_field_has_the_coefficients_of_the_surface(blob, index):
    """But for those of m = 0, to which the height of the plane is added."""
    points, normals = blob
    for i in (0, 600, 1800):
        ids, values = naive.patch(points, i, 6.0, D_LINK), np.zeros((2, len(points)))
        values[1, ids] = naive.robust_values(points[ids], normals[ids], points[i])[1]
        z, _ = descriptors.describe_patches(index, points[i : i + 1], descriptor="rotation_robust")
        of_field = descriptors.describe_fields_of_patches(index, points[i : i + 1], values)[0]
        assert np.abs(of_field[1] - z[0])[M > 0].max() < 1e-9 and not of_field[0].any()


def test_fields_of_several_patches_are_those_of_each_alone():
    rng = np.random.default_rng(4)
    points = np.column_stack([rng.uniform(-9, 9, (4000, 2)), np.zeros(4000)])
    index = build_index(points, np.tile([0, 0, 1.0], (4000, 1)), 0.6)
    fields, tests = rng.normal(size=(2, 4000)), points[:5]
    together = descriptors.describe_fields_of_patches(index, np.vstack([tests, [[99.0, 0, 0]]]), fields)
    for k in range(5):
        np.testing.assert_allclose(
            together[k],
            descriptors.describe_fields_of_patches(index, tests[k : k + 1], fields)[0],
            atol=1e-12,
        )
    assert (together[5] == 0).all()  # no dots there
