"""The confidence set of the best on simulated distances whose best is known."""

import numpy as np
import pytest
from scipy.stats import t

from sparsurf_study.analysis import best_set as module
from sparsurf_study.analysis.best_set import best_set, scatter


def drawn(rng, truth, draws=6, tests=60, of_draw=0.1, rest=1.0):
    """d of combinations with these true means at shared test dots; test dots differ between combinations, too."""
    k = len(truth)
    x = np.asarray(truth, float)[:, None, None] + rng.normal(size=(1, 1, tests))
    return (
        x
        + 0.5 * rng.normal(size=(k, 1, tests))
        + of_draw * rng.normal(size=(k, draws, 1))
        + rest * rng.normal(size=(k, draws, tests))
    )


def test_scatter_of_the_means_is_that_of_repetitions():
    rng = np.random.default_rng(0)
    many = [scatter(drawn(rng, [0, 1])) for _ in range(600)]
    means = np.array([one.mean for one in many])
    apart = means[:, 1] - means[:, 0]
    assumed = np.mean([((o.by_test[1] - o.by_test[0]) ** 2).sum() + o.of_draws.sum() for o in many])
    assert assumed == pytest.approx(apart.var(ddof=1), rel=0.15)


def test_scatter_of_two_draws_at_two_test_dots_by_hand():
    # means of the test dots 3 and 7, of the draws 2 and 8, of all 5; the rest is +1, -1, -1, +1: mean square 4
    found = scatter([[[1.0, 3.0], [5.0, 11.0]]])
    assert found.mean.tolist() == [5.0]
    assert found.by_test[0] == pytest.approx(
        [-(2**0.5), 2**0.5]
    )  # their variance 8 / 2 tests is the sum of squares
    assert found.of_draws[0] == pytest.approx((2 * 18 - 4) / 4)


@pytest.mark.parametrize(
    "truth", [np.zeros(12), np.r_[0, np.linspace(-0.4, -0.05, 11)]], ids=["equal", "graded"]
)
def test_the_best_is_held_in_95_percent(truth, monkeypatch):
    # 200 repetitions: s.e. of the share 0.015; the best of equal ones is each of them
    monkeypatch.setattr(module, "SIMULATED_OUTCOMES", 300)
    rng = np.random.default_rng(1)
    best = truth == truth.max()
    held = [best_set(drawn(rng, truth))[best].mean() for _ in range(200)]
    assert 0.925 <= np.mean(held) <= 1.0


def test_a_set_is_larger_than_pairwise_tests_and_no_larger_than_needed(monkeypatch):
    monkeypatch.setattr(module, "SIMULATED_OUTCOMES", 500)
    rng = np.random.default_rng(2)
    found = best_set(drawn(rng, [2.0, 1.95, 1.9, 0.0, -1.0], of_draw=0.02))
    assert found[0] and not found[3:].any()
    alone = best_set(drawn(rng, np.r_[5.0, np.zeros(30)]))
    assert alone.tolist() == [True] + [False] * 30


def test_of_many_the_best_are_simulated(monkeypatch):
    """Of 130 that cannot be told apart the worst ten are left out, whatever their place in the grid."""
    monkeypatch.setattr(module, "SIMULATED_OUTCOMES", 50)
    x = drawn(np.random.default_rng(5), np.zeros(130), draws=2, tests=20)
    found, worst = best_set(x), np.argsort(x.mean(axis=(1, 2)))[:10]
    assert found[x.mean(axis=(1, 2)).argmax()] and not found[worst].any() and found.sum() > 60


def test_combinations_that_only_their_draws_tell_apart_are_not_excluded():
    """Five equal ones at test dots that scatter not at all; a sixth lies twenty errors of its draws below."""
    rng = np.random.default_rng(6)
    x = drawn(rng, [0, 0, 0, 0, 0, -10], tests=20, of_draw=0.5, rest=0.01)
    x -= x.mean(axis=1, keepdims=True) - x.mean(axis=(1, 2), keepdims=True)
    assert best_set(x).tolist() == [True] * 5 + [False]


def test_how_far_bad_combinations_scatter_does_not_count():
    """Of two that their draws tell apart only the better is in the set, however the draws of bad ones differ."""
    rng = np.random.default_rng(3)
    x = np.concatenate([drawn(rng, [0, -0.5], of_draw=0.1), drawn(rng, np.full(8, -500), of_draw=20.0)])
    assert best_set(x).tolist() == [True] + [False] * 9


def test_the_set_is_the_same_every_time():
    x = drawn(np.random.default_rng(4), np.zeros(8))
    assert np.array_equal(best_set(x), best_set(x))
    assert np.array_equal(best_set(x), best_set(1024 * x)) and best_set(x).sum() > 4  # no unit of d counts


def test_two_equal_combinations_are_compared_by_students_t():
    """All scatter is of the draws: pooled over two combinations of three draws it has 2 x 2 degrees of freedom."""
    candidates = module.Scatter(np.zeros(2), np.zeros((2, 5)), np.full(2, 0.3))
    critical = module._critical_values(candidates, np.zeros((2, 2)), np.zeros((2, 2)), 3)
    assert critical == pytest.approx([t.ppf(0.95, 4)] * 2, rel=0.04)  # 2.13; of 2 degrees it would be 2.92
