"""The study of coverage: by hand on one replicate, on a pool whose truth is known, and its stored page."""

import numpy as np
import pandas as pd
import pytest

from measures import coverage
from sparsurf.evaluation.statistics import cross_validated, estimate
from sparsurf.sampling.combination import PARAMETERS


def test_one_replicate_by_hand():
    x = np.random.default_rng(0).normal(size=(3, 4, 20)) + np.array([0.0, 0.1, 3.0])[:, None, None]
    truth, found = np.array([0.0, 9.0, 3.0]), estimate(x)
    seen = coverage.one_replicate(x, truth)
    assert seen["fixed_t"] == np.mean([found.low[k] <= truth[k] <= found.high[k] for k in range(3)])
    assert seen["selected_bias"] == pytest.approx(found.mean[2] - 3.0)  # the third is the winner
    assert seen["cv_bias"] == pytest.approx(cross_validated(x).mean - 3.0)
    off = np.abs(found.mean - truth) / found.error
    assert seen["fixed_normal"] == np.mean(off <= 1.95996)
    assert seen["half_width"] == pytest.approx(cross_validated(x).half)
    assert seen["best_in_set"] == False and seen["set_size"] == 1  # noqa: E712


def test_the_pool_holds_the_contenders_of_every_range(monkeypatch):
    monkeypatch.setattr(coverage, "CONTENDERS", 2)
    monkeypatch.setattr(coverage, "N_RANGES", 2)
    monkeypatch.setattr(coverage.grid, "evaluate_grid", lambda prepared, rows, tests, draws, readings: rows)
    monkeypatch.setattr(coverage, "d_values", lambda rows, r: rows[:, 2] + 10 * r)
    table = pd.DataFrame(
        {
            "n_S_percent": [0.0, 1, 2, 3, 60, 80, 100],
            "d_kept": [4.0, 3, 2, 1, 1, 2, 3],
            "d_full": [4.0, 2, 1, 3, 3, 2, 1],
            **{name: np.arange(7.0) for name in PARAMETERS},
        }
    )
    d, member = coverage.pool(None, table, ("kept", "full"))
    # kept: 0 and 1 of the lower range, 5 and 4 of the upper one, without the largest; surface: 0 and 3, 4 and 5
    assert d.tolist() == [[0, 1, 3, 4, 5], [10, 11, 13, 14, 15]]
    assert member.tolist() == [0, 0, 0, 1, 1]


def test_combinations_of_a_replicate_share_their_draws():
    # draws scatter 100 times as much as combinations differ, all alike: the last is always first
    rng = np.random.default_rng(3)
    pool = 0.01 * np.arange(4)[:, None, None] + rng.normal(size=(1, 24, 1)) + np.zeros((4, 24, 30))
    row = coverage.replicates(pool, np.zeros(4, int), 6, 20, 10, rng).iloc[0]
    assert row["best_in_set"] == 1 and row["winner"] == row["fixed_t"]


def test_a_normal_pool_is_covered():
    # 8 combinations, 200 replicates: s.e. of the share of fixed intervals below 0.01
    rng = np.random.default_rng(1)
    pool = (
        rng.normal(size=(8, 1, 1)) * 0.02 + 0.1 * rng.normal(size=(8, 24, 1)) + rng.normal(size=(1, 1, 400))
    )
    pool = pool + 0.7 * rng.normal(size=(8, 24, 400))
    table = coverage.replicates(pool, np.array([2] * 8), 6, 60, 200, rng, sets=False)
    row = table.iloc[0]
    assert row["range"] == 3 and row["n_combinations"] == 8
    assert row["fixed_t"] == pytest.approx(0.95, abs=0.025) and row["fixed_normal"] < row["fixed_t"]
    assert row["selected_bias"] > 0.03 and abs(row["cv_bias"]) < 0.03
