"""Distances, errors and references: plain references, exact cases, independence of cores and order."""

from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest

import naive
from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import mean_and_error, reference_values
from sparsurf.sampling import combination, published
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf_study.analysis import grid as grids

GRID = published.parameter_grid([0.4, 1.0], [0, 0.5], [0, 4], [2])


def prepared(blob, threads=1, name="blob", seed=42):
    surface = SimpleNamespace(points=blob[0], normals=blob[1])
    return PreparedSurface(
        surface, Settings(patches={"d_link": 0.8}), streams=Streams(seed, name), threads=threads
    )


@pytest.fixture(scope="module")
def grid(blob):
    return grids.evaluate_grid(prepared(blob), GRID, 30, 2)


def test_distances_equal_the_plain_method(blob, grid):
    points, normals = blob
    plain = prepared(blob)
    k, draw = 5, 1
    sampled, random = plain.pair(GRID[k], draw)
    assert len(sampled) == len(random) == grid.n_s[k, draw]
    for t in (0, 17):
        i = grid.tests[t]
        ball = np.flatnonzero(np.linalg.norm(points - points[i], axis=1) <= 6.0)
        whole = naive.island(points, ball, 0.8)
        z_tot = naive.descriptor(points[whole], normals[whole])
        for subset, z in ((sampled, grid.z_ts), (random, grid.z_tr)):
            kept = naive.island(points, np.intersect1d(ball, subset), 0.8)
            on_surface = np.intersect1d(whole, subset)
            for r, ids in enumerate((kept, on_surface)):
                distance = np.linalg.norm(z_tot - naive.descriptor(points[ids], normals[ids]))
                assert z[r, k, draw, t] == pytest.approx(distance, rel=1e-6)  # stored in single precision


def test_a_grid_holds_what_it_was_asked_and_the_sizes_of_the_patches(blob, grid):
    plain = prepared(blob)
    assert np.array_equal(grid.combinations, GRID) and (grid.n_dots, grid.readings) == (
        3000,
        ("kept", "full"),
    )
    assert np.array_equal(grid.n_s_expected, published.expected_n_s(plain.cover, GRID))
    assert np.array_equal(grid.tests, plain.draw_tests(30))
    assert np.array_equal(grid.z_tot, plain.describe(grid.tests)[0])
    for r, reading in enumerate(grid.readings):
        pairs = [plain.pair(GRID[5], draw) for draw in range(2)]
        sizes = [plain.distances(pair, grid.tests, grid.z_tot, reading)[1] for pair in pairs]
        assert grid.median_patch_size[r, :, 5].tolist() == np.median(sizes, axis=(0, 2)).tolist()


@pytest.fixture(scope="module")
def nested(blob):
    """Distances and sizes of random subsets of many n_S, some of which leave single dots, pairs and ties."""
    plain = prepared(blob)
    tests = plain.draw_tests(20)
    n_s = np.unique(np.concatenate([[1, 2, 3], np.linspace(30, 3000, 150).astype(int)]))
    z_tot, _ = plain.describe(tests)
    return (plain, tests, n_s, z_tot, *plain.compare_uniform(1, n_s, tests, ("kept", "full"), z_tot))


def test_nested_subsets_are_those_that_are_measured_one_by_one(nested):
    plain, tests, n_s, z_tot, z, sizes = nested
    subsets = [plain.uniform(n, 1) for n in n_s]
    for r, reading in enumerate(("kept", "full")):
        distances, counts = plain.distances(subsets, tests, z_tot, reading)
        assert np.array_equal(sizes[r], counts)
        assert np.allclose(z[r], distances, rtol=0, atol=1e-9)
    few = np.array([40, 400, 2000])  # alone, with other threads
    again = plain.with_threads(2).compare_uniform(1, few, tests, ("full",), z_tot)[0][0]
    assert np.allclose(again, plain.distances([plain.uniform(n, 1) for n in few], tests, z_tot, "full")[0])


def test_only_as_published_every_combination_has_a_uniform_subset_of_its_own(blob):
    plain, twice = prepared(blob), np.array([[0.4, 0, 0, 2], [0.4, 0, 0, 2]])
    together = grids.evaluate_grid(plain, twice, 20, 2)
    assert np.array_equal(together.z_tr[:, 0], together.z_tr[:, 1])
    apart = grids.evaluate_grid(plain, GRID[:1], 20, 2, shared=False)
    keys = combination.Combination(*GRID[0]).keys()
    subset = published.uniform_subset(3000, apart.n_s[0, 1], plain.stream("uniform", *keys, 1))
    z_tot, _ = plain.describe(apart.tests[0])
    z, _ = plain.distances([subset], apart.tests[0], z_tot, "full")
    assert apart.z_tr[1, 0, 1] == pytest.approx(z[0], rel=1e-6)


@pytest.mark.parametrize("shared", [True, False])
def test_cores_and_order_change_nothing(blob, shared):
    # bit-identical: the combination in another order and company, with two threads
    one = grids.evaluate_grid(prepared(blob), GRID, 20, 2, shared=shared)
    two = grids.evaluate_grid(prepared(blob, threads=2), GRID, 20, 2, shared=shared)
    back = grids.evaluate_grid(prepared(blob, threads=2), GRID[::-1], 20, 2, shared=shared)
    assert np.array_equal(one.z_ts, two.z_ts) and np.array_equal(one.z_tr, two.z_tr)
    assert np.array_equal(one.n_s, back.n_s[::-1])
    assert np.allclose(one.z_ts, back.z_ts[:, ::-1], rtol=1e-6)


def test_another_seed_or_conformation_draws_again(blob):
    one = prepared(blob)
    pair, tests = one.pair(GRID[0], 0), one.draw_tests(600)
    for other in (prepared(blob, name="other"), prepared(blob, seed=43)):
        assert not np.array_equal(pair[0], other.pair(GRID[0], 0)[0])
        # random subsets and test dots share no more than by chance, n m / N within five standard deviations
        for a, b in ((pair[1], other.pair(GRID[0], 0)[1]), (tests, other.draw_tests(600))):
            chance = len(a) * len(b) / len(blob[0])
            assert abs(len(np.intersect1d(a, b)) - chance) < 5 * np.sqrt(chance)
    again = prepared(blob).pair(GRID[0], 0)
    assert all(np.array_equal(a, b) for a, b in zip(pair, again, strict=True))


def test_keeping_everything_costs_nothing(blob):
    # alpha 1, all exponents 0 keeps every covered dot; on the full surface the few uncovered ones are all that is missing
    grid = grids.evaluate_grid(prepared(blob), np.array([[1.0, 0, 0, 0]]), 40)
    assert grid.n_s[0, 0] > 2900
    assert grid.z_ts[1].mean() < 0.05


def test_fresh_test_dots_differ_between_combinations(blob):
    grid = grids.evaluate_grid(prepared(blob), GRID, 20, shared=False)
    assert grid.tests.shape == (len(GRID), 20)
    assert not np.array_equal(grid.tests[0], grid.tests[1])
    # the references, which need descriptors of one set of dots, are the same either way
    assert np.allclose(grid.z_tot, grids.evaluate_grid(prepared(blob), GRID[:1], 20).z_tot)


def test_grid_survives_the_disk(grid, tmp_path):
    for name in ("a.npz", "b.npz"):
        grids.write_grid(tmp_path / name, grid)
    back = grids.read_grid(tmp_path / "a.npz")
    assert back.readings == grid.readings and back.n_dots == grid.n_dots
    assert np.array_equal(back.z_ts, grid.z_ts)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert [getattr(back, f.name).tolist() for f in fields(grid)[2:-1]] == [
        getattr(grid, f.name).tolist() for f in fields(grid)[2:-1]
    ]
    np.savez(tmp_path / "other.npz", n_s=grid.n_s)
    whole = (tmp_path / "b.npz").read_bytes()  # whose disk may have been full
    for damaged in (whole[:1000], b"", (tmp_path / "other.npz").read_bytes()):
        (tmp_path / "a.npz").write_bytes(damaged)
        with pytest.raises(
            InputError, match=r"a.npz is damaged \(.*\): delete it, it will be computed again.$"
        ):
            grids.read_grid(tmp_path / "a.npz")


def test_references_of_two_opposite_vectors():
    z = np.zeros((2, 121))
    z[:, 0] = [1.0, 3.0]
    assert reference_values(z) == {"Z_empty": 2.0, "Z_mean_descriptor": 1.0, "Z_two_patches": 2.0}
    three = np.array([[0.0, 0.0], [3.0, 4.0], [0.0, 4.0]])  # a triangle with sides of 5, 4 and 3
    found = reference_values(three)
    assert found["Z_two_patches"] == 4.0 and found["Z_empty"] == 3.0
    # from the mean (1, 8 / 3): the roots of 73, 52 and 25, thirds
    assert found["Z_mean_descriptor"] == pytest.approx((73**0.5 + 52**0.5 + 25**0.5) / 9)


def test_references_of_a1(a1):
    # over 2000 test dots the s.e. of |z_tot| is 0.05 and of the null model 0.02
    surface = PreparedSurface(a1, streams=Streams(5, "a1"), threads=2)
    z_tot, _ = surface.describe(surface.draw_tests(2000))
    sticks = reference_values(z_tot)
    assert sticks["Z_empty"] == pytest.approx(9.61, abs=0.15)
    assert sticks["Z_mean_descriptor"] == pytest.approx(1.54, abs=0.1)
    assert sticks["Z_two_patches"] == pytest.approx(2.17, abs=0.15)


def test_published_rows_of_a1(a1, shared):
    # reference: 40 replicates of 100 test dots. With 1500 shared test dots and 4 draws our error is about that of
    # the reference's mean; 5 % of the value or 3 joint standard errors
    rows = combination.PUBLISHED_ROWS
    grid = grids.evaluate_grid(PreparedSurface(a1, streams=Streams(1, "a1"), threads=2), rows, 1500, 4)
    n_s = 100 * grid.n_s.mean(axis=1) / 20045
    assert np.allclose(n_s, [12.4, 21.3, 26.0, 37.3, 45.7, 53.4, 61.4, 74.0, 83.4, 97.1], atol=0.6)
    d, error = mean_and_error(grid.z_tr.astype(float) - grid.z_ts)
    reference = np.array([1.27, 1.66, 1.90, 2.28, 2.35, 2.13, 1.19, 0.12, -0.12, -0.04])
    scatter = np.array([0.13, 0.17, 0.18, 0.27, 0.26, 0.23, 0.26, 0.10, 0.07, 0.02]) / np.sqrt(40)
    assert (np.abs(d[0] - reference) < 3 * np.hypot(error[0], scatter) + 0.01).all()
    on_surface = [-0.39, -0.39, -0.37, -0.32, -0.32, -0.30, -0.26, -0.24, -0.20, -0.05]
    assert np.allclose(d[1], on_surface, atol=0.05)
    z_ts = [7.59, 6.78, 6.32, 5.22, 4.28, 3.36, 2.59, 1.29, 0.76, 0.26]
    assert np.allclose(grid.z_ts[0].mean(axis=(1, 2)), z_ts, atol=0.25)
