"""The test of Table I: how often it notices other rules, on simulated runs."""

import numpy as np
import pandas as pd
import pytest

from measures import power


def runs(rng, n, shift=0.0):
    """Winners of n runs in four ranges, normal around the range's own mean."""
    rows = [
        (r, "closed", k, k + rng.normal() + shift, -k + rng.normal()) for r in range(n) for k in range(1, 5)
    ]
    return pd.DataFrame(rows, columns=["run", "binning", "range", "d", "Z_tS"]).assign(centres=182)


def test_a_run_of_the_same_kind_is_noticed_as_often_as_chance_says():
    # the mean of 60 references: s.e. of a share of 0.05 over 20 runs of each is 0.006
    rng, found = np.random.default_rng(0), []
    for _ in range(60):
        found.append(power.power(runs(rng, 10), runs(rng, 20)))
    assert pd.concat(found).groupby("measure")["power"].mean().to_list() == pytest.approx(
        [0.05, 0.05], abs=0.02
    )


def test_a_shift_is_noticed_in_its_own_measure():
    rng = np.random.default_rng(1)
    found = power.power(runs(rng, 40), runs(rng, 40, shift=4.0)).set_index("measure")
    assert found.loc["d", "power"] == 1 and found.loc["Z_tS", "power"] < 0.3
    assert found.loc["d", "n_runs"] == 40 and (found["centres"] == 182).all()


def test_the_statistic_is_the_sum_of_squared_t():
    reference = pd.DataFrame({"run": [1, 2, 3], "range": 1, "d": [1.0, 2.0, 3.0]}).set_index(
        ["run", "range"]
    )["d"]
    total, freedom = power.statistic(pd.Series({1: 4.0, 2: np.nan}), reference)
    assert total == pytest.approx((2 / (1 * np.sqrt(1 + 1 / 3))) ** 2) and freedom == (3,)


def test_alphas_are_scaled_and_nothing_else():
    assert power.law_of([[0.4, 1, 2, 3]], 1.05).tolist() == [[pytest.approx(0.42), 1, 2, 3]]
