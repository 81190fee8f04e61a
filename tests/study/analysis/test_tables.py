"""Tables from made-up distances whose answers are known."""

from dataclasses import replace

import numpy as np
import pytest

from sparsurf.sampling.combination import Combination
from sparsurf_study.analysis import tables
from sparsurf_study.analysis.grid import Grid


def made_up(d, n_s_percent, draws=2, tests=40, noise=0.0, combinations=None):
    """Grid of one reading whose d is as requested; Z_tS = 1."""
    rng = np.random.default_rng(0)
    k = len(d)
    combinations = (
        np.tile([1.0, 0, 0, 0], (k, 1)) if combinations is None else np.asarray(combinations, float)
    )
    n_s = np.tile(np.round(np.asarray(n_s_percent) * 10).astype(int)[:, None], draws)
    z_ts = np.ones((1, k, draws, tests))
    z_tr = z_ts + np.asarray(d, float)[None, :, None, None] + noise * rng.normal(size=z_ts.shape)
    z_tot = rng.normal(size=(tests, 121))
    return Grid(
        combinations,
        1000,
        n_s,
        n_s[:, 0] * 1.0,
        np.arange(tests),
        z_tot,
        z_ts,
        z_tr,
        np.full((1, 2, k), 7.0),
        ("kept",),
    )


def test_grid_table_has_the_contract_columns():
    median_patch_size = np.array([[[7.0, 8], [9, 10]]])
    table = tables.grid_table(replace(made_up([0.5, 1.5], [10, 20]), median_patch_size=median_patch_size))
    assert list(table.columns[:7]) == [
        "alpha",
        "beta",
        "gamma",
        "delta",
        "n_S",
        "n_S_percent",
        "n_S_expected",
    ]
    assert table["n_S_percent"].tolist() == [10, 20]
    assert np.allclose(table["d_kept"], [0.5, 1.5])
    assert np.allclose(table["d_se_kept"], 0)
    assert table["median_patch_size_kept"].tolist() == [7, 8]
    assert table["median_patch_size_uniform_kept"].tolist() == [9, 10]


def test_ranges_are_equal_and_hold_every_combination_but_the_last():
    percent = np.array([2.0, 5, 5.1, 22, 30, 71, 100])
    grid = made_up(np.arange(7.0), percent)
    ranges = tables.ranges_table(tables.grid_table(grid), grid, 10)
    assert np.allclose(np.diff(ranges["n_S_low_percent"]), 9.8)
    assert ranges["n_combinations"].sum() == 6  # the largest n_S belongs to none
    first = ranges.iloc[0]
    assert first["d"] == pytest.approx(2.0) and first["n_S_percent"] == pytest.approx(5.1)
    assert ranges.iloc[4]["n_combinations"] == 0 and np.isnan(ranges.iloc[4]["d"])


def test_the_confidence_set_lists_what_may_be_the_best():
    combos = [[1, 0, g, 0] for g in range(3)]
    grid = made_up([1.0, 0.99, 0.2], [10, 10, 10], tests=200, noise=0.3, combinations=combos)
    row = tables.ranges_table(tables.grid_table(grid), grid, 1).iloc[0]
    assert row["n_best_set"] == 2
    assert set(row["best_set"].split("; ")) == {"(1, 0, 0, 0)", "(1, 0, 1, 0)"}


def test_held_out_value_is_free_of_selection_bias():
    # 200 equal combinations of pure noise: the best looks good, held out it is 0 within its error
    rng = np.random.default_rng(3)
    grid = made_up(np.zeros(200), np.full(200, 10.0), tests=100, noise=1.0, combinations=rng.random((200, 4)))
    row = tables.ranges_table(tables.grid_table(grid), grid, 1).iloc[0]
    assert row["d"] > 0.15
    assert abs(row["d_cv"]) < 3 / np.sqrt(100)


def test_best_is_sought_at_alpha_one_and_under_the_maximum():
    combos = [[0.5, 0, 0, 0], [1, 0, 2, 0], [1, 0, 4, 0]]
    grid = made_up([3.0, 1.0, 2.0], [5, 30, 40], combinations=combos)
    best = tables.best_combinations(tables.grid_table(grid), grid, 35)
    assert str(Combination.from_row(best["kept"]["unrestricted"])) == "(1, 0, 4, 0)"
    assert str(Combination.from_row(best["kept"]["under_max_n_S"])) == "(0.5, 0, 0, 0)"
    assert [best["kept"][key]["n_combinations"] for key in ("unrestricted", "under_max_n_S")] == [2, 2]


def test_an_answer_is_given_when_nothing_is_that_small():
    grid = made_up([1.0], [30])
    best = tables.best_combinations(tables.grid_table(grid), grid, 2)
    answer = best["kept"]["under_max_n_S"]["answer"]
    assert "No combination of the grid keeps 2 % of the dots or fewer; the smallest n_S is 30.00 %" in answer
