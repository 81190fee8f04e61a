"""Winners and mean roughness: cases small enough to count by hand."""

import numpy as np
import pandas as pd
import pytest

from sparsurf.sampling.combination import PARAMETERS, Combination, join_combinations
from sparsurf_study.analysis.relation import (
    relate_to_roughness,
    rho_interval,
    roughness_correlations,
    winner_changes,
)

A, B, C = "a", "b", "c"


@pytest.mark.parametrize(
    ("plateaus", "apart"),
    [
        ([[A], [B]], 1),
        ([[A, B], [B]], 0),  # one of the two may be the other: they cannot be told apart
        ([[A], [B, A]], 0),
        ([[A, B], [B, A]], 0),
    ],
)
def test_winners_are_apart_only_if_each_lies_outside_the_plateau_of_the_other(plateaus, apart):
    found = winner_changes(np.array([0.5, 0.505]), [A, B], plateaus)
    assert found == {"n_pairs": 1, "n_changes": 1, "n_distinct": apart}


def test_only_surfaces_within_a_hundredth_are_equally_rough():
    found = winner_changes(np.array([0.5, 0.509, 0.518, 0.53]), [A, B, B, C], [[A], [B], [B], [C]])
    assert found == {"n_pairs": 2, "n_changes": 1, "n_distinct": 1}


def rows(winners, plateaus):
    """Rows of a summary: surfaces of mean roughness .50, .51, ..., combinations by their gamma."""
    table = pd.DataFrame([Combination(1, 0, gamma, 0) for gamma in winners], columns=PARAMETERS)
    table["best_set"] = [
        join_combinations(Combination(1, 0, gamma, 0) for gamma in each) for each in plateaus
    ]
    table["protein"], table["mean_roughness"] = "p", 0.5 + 0.02 * np.arange(len(winners))
    return table.assign(d=1.0, d_cv=1.0, d_from_near=1.0, d_from_far=0.5, d_from_all=1.0)


def test_shared_is_what_lies_in_most_plateaus_and_of_those_what_wins_most_often():
    rng = np.random.default_rng(0)
    found = relate_to_roughness(rows([1, 2, 2], [[1, 3], [2, 3], [2, 3]]), rng)
    assert (found["shared"], found["n_shared"]) == ("(1, 0, 3, 0)", 3)
    found = relate_to_roughness(rows([1, 2, 2], [[1, 2, 3], [1, 2, 3], [3, 2, 1]]), rng)
    assert (found["shared"], found["n_shared"]) == ("(1, 0, 2, 0)", 3)
    assert found["n_winners"] == 2


def test_the_interval_of_rho_has_the_width_of_bonett_and_wright():
    # rho .5 of 20: atanh .5 = .54931, error sqrt((1 + .125) / 17) = .25725; tanh(.54931 -+ 1.95996 x .25725)
    low, high = rho_interval(np.array([0.5]), 20)
    assert low[0] == pytest.approx(0.04507, abs=2e-5)
    assert high[0] == pytest.approx(0.78318, abs=2e-5)
    # 5 surfaces: half as certain, and with rho = 0 as wide on either side
    low, high = rho_interval(np.array([0.0]), 5)
    assert high[0] == -low[0] == pytest.approx(np.tanh(1.959964 / np.sqrt(2)), abs=1e-6)
    # a rho of 1 counts as one of 1 - 6 / 120, and three surfaces tell nothing
    assert rho_interval(np.array([1.0]), 5)[0] == pytest.approx(
        np.tanh(np.arctanh(0.95) - 1.959964 * np.sqrt(0.75)), abs=1e-6
    )
    assert np.isnan(rho_interval(np.array([0.5]), 3)).all()


def test_all_orders_of_six_surfaces_are_taken():
    values = np.repeat(np.arange(6.0)[:, None], 4, axis=1)
    assert roughness_correlations(np.arange(6.0), values, None)["p"] == pytest.approx(2 / 720)
