"""Where a measured curve comes down to a noise floor, and whether the interval of that holds it."""

import numpy as np
import pytest

from sparsurf.evaluation.crossing import _draw_weights, first_crossing, fitted_crossing, near

SIZES = np.array([10.0, 15, 20, 30, 40, 60, 80, 120, 160, 240, 320, 480, 640])
N = 1000


def z_of(n):
    return 0.9 + 30 / n + 200 / n**2 - 0.02 * np.log(n)


def constant(values, draws=2, tests=3):
    return np.tile(np.asarray(values)[:, None, None], (draws, tests))


@pytest.mark.parametrize("floor", [0.5, 1.0, 2.0])
def test_a_curve_of_the_fitted_form_is_met_where_it_crosses(floor):
    """Where z_of(n) = 1.2 floors: found by bisection, and by the fit."""
    low, high = 1.0, 1000.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if z_of(middle) > 1.2 else (low, middle)
    found = fitted_crossing(
        SIZES, floor * constant(z_of(SIZES)), np.full((10, 3), floor), 1.2, N, np.random.default_rng(0)
    )
    assert found.n == pytest.approx(high, rel=2e-4)  # 400 steps over ln n
    assert (found.low, found.high) == pytest.approx((high, high), rel=2e-4)  # nothing varies


def test_an_error_that_all_share_moves_nothing():
    """Rough places have a larger Z, of the subsets and of the floor alike; the ratio does not depend on which are drawn."""
    rng = np.random.default_rng(1)
    hard = rng.lognormal(0, 1, 100)
    distances, floor = constant(z_of(SIZES), 3, 100) * hard, np.tile(hard, (10, 1))
    found = fitted_crossing(SIZES, distances, floor, 1.2, N, rng)
    assert found.high / found.low == pytest.approx(1, abs=1e-6)


def test_the_interval_holds_the_truth_in_95_of_100_cases():
    """150 surfaces with noise of test dots (shared by all sizes, in part by the floor), of draws, and of the floor.

    The share of intervals that hold the truth has a standard error of 1.8 %. What each draw adds at each test dot is small
    here: both bootstraps count it, so that more of it gives wider intervals than needed.
    """
    truth = fitted_crossing(SIZES, constant(z_of(SIZES)), np.ones((2, 3)), 1.2, N, np.random.default_rng(0)).n
    held, answers = 0, []
    for seed in range(150):
        rng = np.random.default_rng(seed)
        tests = rng.gamma(4, 1 / 4, 60)
        apart = tests * (1 + 0.2 * rng.normal(size=60))
        noise = 1 + 0.05 * rng.normal(size=(len(SIZES), 3, 1)) + 0.1 * rng.normal(size=(len(SIZES), 3, 60))
        floor = tests * (1 + 0.05 * rng.normal(size=(10, 1)) + 0.1 * rng.normal(size=(10, 60)))
        found = fitted_crossing(SIZES, constant(z_of(SIZES), 3, 60) * apart * noise, floor, 1.2, N, rng)
        held += found.low <= truth <= found.high
        answers.append(found.n)
        assert found.low <= found.n <= found.high <= N
    assert 0.91 <= held / 150 <= 0.985
    assert np.median(answers) == pytest.approx(truth, rel=0.05)


@pytest.mark.parametrize("draws", [2, 3, 10])
def test_weights_of_few_draws_vary_as_the_mean_of_the_draws_does(draws):
    """Plain bootstrap weights have the standard deviation sqrt((K - 1) / K) / K, too little by that root; rescaled ones 1 / K."""
    weights = _draw_weights(draws, (50_000,), np.random.default_rng(0))
    np.testing.assert_allclose(weights.sum(axis=1), 1)
    np.testing.assert_allclose(weights.mean(axis=0), 1 / draws, rtol=0.02)
    np.testing.assert_allclose(weights.std(axis=0), 1 / draws, rtol=0.02)


def test_the_interval_ends_at_all_dots_where_the_curve_may_stay_above():
    rng = np.random.default_rng(3)
    noise = 1 + 0.3 * rng.normal(size=(len(SIZES), 3, 40))
    flat = constant(1.19 + 2 / SIZES, 3, 40)
    found = fitted_crossing(SIZES, flat * noise, np.ones((10, 40)), 1.2, N, rng)
    assert found.high == N and found.low < found.n


def test_beyond_the_measured_sizes_nothing_is_fitted():
    rng = np.random.default_rng(0)
    above = fitted_crossing(SIZES, constant(z_of(SIZES)), np.full((2, 3), 0.1), 1.2, N, rng)
    below = fitted_crossing(SIZES, constant(z_of(SIZES)), np.full((2, 3), 99.0), 1.2, N, rng)
    assert (above.n, below.n) == (np.inf, 0) and np.isnan([above.low, below.high]).all()
    few = fitted_crossing(SIZES[4:8], constant(z_of(SIZES[4:8])), np.ones((2, 3)), 1.2, N, rng)
    assert 30 < few.n < 120 and np.isnan(few.low)  # by straight lines of ln Z over ln n


def test_straight_lines_cross_first_where_they_first_come_down():
    x = np.array([0.0, 1, 2, 3])
    assert first_crossing(x, np.array([1.0, -1, 1, -1])) == 0.5
    assert first_crossing(x, np.array([3.0, 1, 1, -1])) == 2.5
    assert first_crossing(x, np.array([0.0, -1, -1, -1])) == 0
    assert first_crossing(x, np.array([-0.1, 1, 1, -1])) == -np.inf
    assert first_crossing(x, np.ones(4)) == np.inf


def test_sizes_near_a_crossing():
    sizes = np.array([10.0, 20, 22, 44, 100, 220, 221])
    assert near(sizes, 44.0).tolist() == [False, True, True, True, True, True, False]
    assert near(sizes, 44.0, 2.0).tolist() == [True] * 7
