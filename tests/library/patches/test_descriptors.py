"""Descriptors: exact cases, invariances, the plain method to 1e-9, the authors' numbers to 1e-6."""

import itertools

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from sparsurf.patches import descriptors
from sparsurf.patches.index import build_index
from sparsurf.patches.subset_patches import MIN_SUBSETS_FOR_JOINT_SEARCH
from sparsurf.patches.zernike import images, polynomials
from subset_descriptors import evaluate

D_LINK = 0.8


@pytest.fixture(scope="module")
def index(blob):
    return build_index(*blob, D_LINK)


def in_order(z):
    """Kernel order to the order of `zernike.indices`."""
    out = np.empty_like(z)
    out[..., polynomials.fold().order] = z
    return out


@pytest.mark.parametrize("up", [True, False])
def test_equals_the_plain_method(blob, index, up):
    points, normals = blob
    tests = np.arange(0, 3000, 430)
    z, sizes = descriptors.describe_patches(index, points[tests], up=up)
    for k, i in enumerate(tests):
        ids = naive.patch(points, i, 6.0, D_LINK)
        assert sizes[k] == len(ids)
        assert np.abs(z[k] - naive.descriptor(points[ids], normals[ids], up)).max() < 1e-9


@pytest.mark.parametrize("reading", ["kept", "full"])
@pytest.mark.parametrize("share", [0.02, 0.1, 0.5, 0.9])
@pytest.mark.parametrize("n_subsets", [3, MIN_SUBSETS_FOR_JOINT_SEARCH])  # few and many go different ways
def test_subsets_equal_the_plain_method(blob, index, reading, share, n_subsets):
    points, normals = blob
    rng = np.random.default_rng(int(100 * share))
    subsets = [np.flatnonzero(rng.random(len(points)) < share) for _ in range(n_subsets)]
    tests = rng.choice(len(points), 3 if n_subsets == 3 else 1, replace=False)
    words = descriptors.pack_subsets(index, subsets)
    z, sizes = evaluate(index, points[tests], words, n_subsets, reading)
    for k, i in enumerate(tests):
        ball = np.flatnonzero(np.linalg.norm(points - points[i], axis=1) <= 6.0)
        for b, subset in enumerate(subsets):
            if reading == "kept":
                ids = naive.island(points, np.intersect1d(ball, subset), D_LINK)
            else:
                ids = np.intersect1d(naive.island(points, ball, D_LINK), subset)
            assert sizes[k, b] == len(ids)
            if b < 3:  # the plain way takes its time
                assert np.abs(in_order(z[k, b]) - naive.descriptor(points[ids], normals[ids])).max() < 1e-9


def test_weights_equal_the_plain_method(blob, index):
    points, normals = blob
    rng = np.random.default_rng(9)
    weights = rng.uniform(0.2, 5, (2, len(points)))
    everything = descriptors.pack_subsets(index, [np.arange(len(points))] * 2)
    z, _ = evaluate(index, points[:5], everything, 2, "full", weights=weights[:, index.dot])
    for i, b in itertools.product(range(5), range(2)):
        ids = naive.patch(points, i, 6.0, D_LINK)
        expected = naive.descriptor(points[ids], normals[ids], weights=weights[b, ids])
        assert np.abs(in_order(z[i, b]) - expected).max() < 1e-9


@pytest.mark.parametrize("weights", [None, [1.0, 1, 1, 1, 1], [1.0, 1, 0, 1, 1]], ids=str)
def test_a_pixel_without_distance_or_weight_is_empty(weights):
    """The last dot lies at the apex of the cone, r = 0; the third of the last case is alone in its pixel."""
    points = np.array([[1.0, 0, 0.5], [-1, 0, 0.5], [0, 1, 0.5], [0, -1, 0.5], [0, 0, -2]])
    if weights and not weights[2]:
        points[3] = points[2] * [1, -0.5, 1]
    normals = np.tile([0.0, 0, 1], (5, 1))
    index, words = build_index(points, normals, 9.0), np.ones(5, np.uint64)
    given = None if weights is None else np.array([weights])[:, index.dot]
    z, _ = evaluate(index, points[:1], words, 1, "full", weights=given)
    expected = naive.descriptor(points, normals, weights=None if weights is None else np.array(weights))
    assert np.abs(in_order(z[0, 0]) - expected).max() < 1e-9


def test_weights_of_subsets_leave_the_whole_patch_alone(blob, index):
    points, _ = blob
    rng = np.random.default_rng(10)
    tests = points[::300]
    words = descriptors.pack_subsets(index, [np.flatnonzero(rng.random(len(points)) < 0.4) for _ in range(2)])
    weights = rng.uniform(0.2, 5, (2, len(points)))
    z_tot, _ = descriptors.describe_patches(index, tests)
    for readings in (("kept",), ("full",), ("kept", "full")):
        together = descriptors.compare_descriptors(index, tests, words, 2, readings, None, weights)
        apart = descriptors.compare_descriptors(index, tests, words, 2, readings, z_tot, weights)
        assert np.allclose(together[0], z_tot, rtol=0, atol=1e-9)
        assert np.allclose(together[1], apart[1], rtol=0, atol=1e-9)


def test_distances_go_with_the_weights_the_radius_and_the_side(blob, index):
    points, _ = blob
    rng = np.random.default_rng(14)
    tests, weights = points[::300], rng.uniform(0.2, 5, (2, len(points)))
    words = descriptors.pack_subsets(
        index, [np.flatnonzero(rng.random(len(points)) < share) for share in (0.3, 0.6)]
    )
    asked = weights, 5.0, False
    z_tot, _ = descriptors.describe_patches(index, tests, *asked[1:])
    together = descriptors.compare_descriptors(index, tests, words, 2, ("full", "kept"), None, *asked)
    for k, reading in enumerate(("full", "kept")):
        z, sizes = evaluate(index, tests, words, 2, reading, *asked)
        _, distances, counted = descriptors.compare_descriptors(
            index, tests, words, 2, (reading,), z_tot, *asked
        )
        assert np.allclose(distances, np.linalg.norm(in_order(z) - z_tot[:, None], axis=2), rtol=1e-12)
        assert np.allclose(together[1][:, 2 * k : 2 * k + 2], distances, rtol=1e-12)
        assert np.array_equal(counted, sizes) and np.array_equal(together[2][:, 2 * k : 2 * k + 2], sizes)


def test_patches_that_neighbouring_test_dots_share_have_a_distance_for_each(blob, index):
    """Of a sparse subset two test dots side by side have the same dots, and not the same distance."""
    points, _ = blob
    rng = np.random.default_rng(8)
    tests = points[np.argsort(np.linalg.norm(points - points[0], axis=1))[:10]]
    subsets = [np.flatnonzero(rng.random(len(points)) < 0.02) for _ in range(70)]
    words = np.stack([descriptors.pack_subsets(index, some) for some in (subsets[:64], subsets[64:])])
    z_tot, _ = descriptors.describe_patches(index, tests)
    for reading in ("kept", "full"):
        found, _ = descriptors.compare_many(index, tests, words, 70, (reading,), z_tot)
        for word, some in ((words[0], slice(64)), (words[1], slice(64, 70))):
            n = len(subsets[some])
            _, alone, _ = descriptors.compare_descriptors(index, tests, word, n, (reading,), z_tot)
            assert np.allclose(found[0, some], alone.T, rtol=0, atol=1e-9)


def test_the_whole_surface_is_at_distance_zero(blob, index):
    points, _ = blob
    z_tot, _ = descriptors.describe_patches(index, points[:20])
    words = descriptors.pack_subsets(index, [np.arange(len(points))] * 64)
    for reading in ("kept", "full"):
        _, distances, _ = descriptors.compare_descriptors(index, points[:20], words, 64, (reading,), z_tot)
        assert np.abs(distances).max() < 1e-9


def test_empty_patches_single_dots_and_dots_one_above_the_other_are_the_zero_vector(blob, index):
    points, _ = blob
    words = descriptors.pack_subsets(index, [[], [17]])
    z, sizes = evaluate(index, points[17:18], words, 2, "kept")
    assert sizes.tolist() == [[0, 1]]
    assert not z.any()
    points, normals = np.array([[0.0, 0, 0], [0, 0, 1]]), np.tile([0.0, 0, 1], (2, 1))
    z, sizes = descriptors.describe_patches(build_index(points, normals, 2.0), points)
    assert sizes.tolist() == [2, 2]
    assert not z.any()


@pytest.mark.parametrize("up", [True, False])
def test_normals_that_cancel_turn_a_patch_over_or_not_at_all(up):
    points, normals = (
        np.random.default_rng(4).normal(size=(40, 3)),
        np.tile([[0.0, 0, 1], [0, 0, -1]], (20, 1)),
    )
    z, _ = descriptors.describe_patches(build_index(points, normals, 9.0), points[:1], up=up)
    assert np.abs(z[0] - naive.descriptor(points, normals, up)).max() < 1e-9


def test_threads_company_and_the_order_of_the_dots_change_nothing(blob, index):
    # bit-identical with more threads; and a subset's result does not depend on the subsets beside it but for
    # the last digits of the matrix product
    points, _ = blob
    rng = np.random.default_rng(12)
    subsets = [np.flatnonzero(rng.random(len(points)) < 0.3) for _ in range(64)]
    words = descriptors.pack_subsets(index, subsets)
    one, _ = evaluate(index, points[:100], words, 64, "kept", threads=1)
    two, _ = evaluate(index, points[:100], words, 64, "kept", threads=2)
    assert np.array_equal(one, two)
    alone, _ = evaluate(index, points[:100], descriptors.pack_subsets(index, subsets[5:6]), 1, "kept")
    assert np.allclose(alone[:, 0], one[:, 5], atol=1e-12)
    points, normals = blob
    order = np.random.default_rng(13).permutation(len(points))
    z = [
        descriptors.describe_patches(build_index(p, n, D_LINK), points[:40])[0]
        for p, n in ((points, normals), (points[order], normals[order]))
    ]
    # sums run in another order, and a dot on a pixel's edge may change sides: allow one patch in forty
    assert (np.abs(z[0] - z[1]).max(axis=1) < 1e-9).sum() >= 39


@settings(max_examples=30)
@given(st.integers(2, 120), st.integers(0, 10**6), st.booleans())
def test_random_patches_equal_the_plain_method(n, seed, up):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, 3)) * [2, 2, 0.5]
    normals = rng.normal(size=(n, 3)) * 0.3 + [0, 0, 1]
    z, _ = descriptors.describe_patches(build_index(points, normals, 20.0), points[:1], 20.0, up)
    assert np.abs(z[0] - naive.descriptor(points, normals, up)).max() < 1e-9


@settings(max_examples=200)
@given(st.integers(0, 10**9), st.floats(0.003, 0.9))
def test_gap_filling_equals_the_plain_sweeps(seed, share):
    rng = np.random.default_rng(seed)
    picture = np.where(rng.random((25, 25)) < share, rng.uniform(1, 9, (25, 25)), 0.0)
    wide = np.zeros(25 * images.ROW_STRIDE + images.ROW_STRIDE)
    wide[: 25 * images.ROW_STRIDE].reshape(25, -1)[:, :25] = picture
    filled = ((picture != 0) * (1 << np.arange(25))).sum(axis=1).astype(np.uint32)
    images.fill_gaps(wide, filled, *images.FOLDING_TABLES[3:])
    result = wide[: 25 * images.ROW_STRIDE].reshape(25, -1)[:, :25]
    i, j = np.mgrid[:25, :25]
    inside = (i - 12) ** 2 + (j - 12) ** 2 <= 144
    assert np.allclose(result[inside], naive.fill(picture)[inside], rtol=1e-13)


@pytest.mark.parametrize("name", ["up", "down"])
def test_equals_the_authors_descriptors_of_a1(a1, shared, name):
    published = pd.read_csv(shared / "oracle" / f"a1_descriptors_{name}.csv")
    index = build_index(a1.points, a1.normals)
    z, sizes = descriptors.describe_patches(index, a1.points[published["point"]], up=name == "up")
    assert np.array_equal(sizes, published["n_points"])
    assert np.abs(z - published.iloc[:, 2:].to_numpy()).max() < 1e-6


@pytest.mark.parametrize("percent", [5, 20, 50])
def test_equals_the_authors_descriptors_of_subsets_of_a1(a1, shared, percent):
    published = pd.read_csv(shared / "oracle" / f"a1_subset_{percent}pct_descriptors_up.csv")
    subset = pd.read_csv(shared / "oracle" / f"a1_subset_{percent}pct_indices.csv")["point"]
    index = build_index(a1.points, a1.normals)
    words = descriptors.pack_subsets(index, [subset])
    z, sizes = evaluate(index, a1.points[published["point"]], words, 1, "kept")
    assert np.array_equal(sizes[:, 0], published["n_points"])
    assert np.abs(in_order(z[:, 0]) - published.iloc[:, 2:].to_numpy()).max() < 1e-6


def test_equals_the_published_coefficients_of_1a1u(shared):
    from sparsurf.surfaces.read_surface import read_surface

    surface = read_surface(shared / "data" / "1a1u" / "1a1u_A.dms.gz")
    published = np.loadtxt(shared / "data" / "1a1u" / "1a1u_A_up_coeff.csv")
    z, _ = descriptors.describe_patches(build_index(surface.points, surface.normals), surface.points[:1])
    assert np.abs(z[0] - published).max() < 1e-5
