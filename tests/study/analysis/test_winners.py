"""Who wins a range, who may be the best instead, how wide intervals are: cases with one answer."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from sparsurf.evaluation.statistics import estimate
from sparsurf_study.analysis import tables
from sparsurf_study.analysis.best_set import best_set
from sparsurf_study.analysis.tables import bin_index, range_index, range_limits

TESTS = 400


def test_a_limit_belongs_to_the_range_above_it_and_the_largest_value_to_none_or_to_the_last_bin():
    limits = range_limits([0.0, 3.0, 30.0], 3)
    assert limits.tolist() == [0, 10, 20, 30]
    values = [0, 9.999, 10, 19.999, 20, 30]
    assert range_index(values, limits).tolist() == [0, 0, 1, 1, 2, 3]
    assert bin_index(values, limits).tolist() == [0, 0, 1, 1, 2, 2]
    assert range_index([5, 5], range_limits([5, 5], 3)).tolist() == [0, 0]  # the only value has a range


def test_the_table_of_the_grid_has_students_intervals_of_every_mean():
    rng = np.random.default_rng(4)
    _, grid = grid_of([1.0], [10], [1])
    grid = replace(grid, z_tr=grid.z_tr + rng.normal(size=grid.z_tr.shape), z_ts=grid.z_ts * 2)
    table = tables.grid_table(grid).iloc[0]
    for name, values in (("d", grid.z_tr[0] - grid.z_ts[0]), ("Z_tR", grid.z_tr[0])):
        found = estimate(values)
        half = student.ppf(0.975, found.df[0]) * table[f"{name}_se_kept"]
        assert table[f"{name}_kept"] == pytest.approx(values.mean())
        assert table[f"{name}_low_kept"] == pytest.approx(values.mean() - half)
        assert table[f"{name}_high_kept"] == pytest.approx(values.mean() + half)


def against_the_best(gap):
    """d of the best combination and of one that is `gap` standard errors of their difference below it.

    What they share scatters a hundred times more than what tells them apart.
    """
    rng = np.random.default_rng(4)
    shared, own = 10 * rng.normal(size=(1, TESTS)), rng.normal(size=(1, TESTS))
    own = (own - own.mean()) / own.std(ddof=1)  # its mean has the standard error 1 / sqrt(TESTS)
    return np.stack([shared, shared + 0.1 * own - gap * 0.1 / np.sqrt(TESTS)])


@pytest.mark.parametrize(("gap", "equal"), [(0.0, True), (1.5, True), (1.8, False), (5.0, False)])
def test_who_may_be_the_best_is_reported_from_paired_differences(gap, equal):
    """One other can be told from the best at 1.645 errors, on one side of the paired difference."""
    assert best_set(against_the_best(gap)).tolist() == [True, equal]


def grid_of(d, percent, alpha):
    """Table and raw d of combinations without any scatter."""
    from test_tables import made_up

    grid = made_up(d, percent, combinations=[[a, 0, k, 0] for k, a in enumerate(alpha)])
    return tables.grid_table(grid), grid


def test_a_combination_that_keeps_just_the_maximum_may_win():
    best = tables.best_combinations(*grid_of([1.0, 2.0, 3.0], [10, 20, 20.1], [1, 1, 1]), 20)["kept"]
    assert best["under_max_n_S"]["gamma"] == 1
    assert best["unrestricted"]["gamma"] == 2


def test_of_equal_combinations_the_first_of_the_grid_wins_and_all_may_be_the_best():
    table, grid = grid_of([1.0, 2.0, 2.0], [10, 10, 10], [1, 1, 1])
    winner = tables.ranges_table(table, grid, 1).iloc[0]
    assert winner["gamma"] == 1
    assert winner["best_set"] == "(1, 0, 1, 0); (1, 0, 2, 0)"
    assert winner["n_best_set"] == 2


def test_the_variance_of_a_mean_is_at_least_that_of_the_rest():
    """Draws and test dots that agree on average by chance: nothing but the rest is left."""
    assert estimate(np.array([[1.0, -1.0], [-1.0, 1.0]])).error == 1


def test_an_error_has_a_degree_of_freedom_at_least():
    # all three mean squares are 1, each of one degree: Satterthwaite gives a third
    assert estimate(np.array([[1.5, -0.5], [-0.5, -0.5]])).df == 1
