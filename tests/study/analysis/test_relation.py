"""Winners and mean roughness: cases small enough to count by hand."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import spearmanr

from sparsurf.evaluation.statistics import mean_interval
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
    found = winner_changes(np.array([0.5, 0.501, 0.502]), [A, B, C], [[A, B], [B], [C]])
    assert found == {"n_pairs": 3, "n_changes": 3, "n_distinct": 2}  # A may be B


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


def test_gains_and_rhos_are_those_of_the_means_of_proteins():
    """Four proteins, the first of two conformations; roughness ranks 1 to 4."""
    values = [[1, 0, 1, 3], [0.2, 1, 9, 3], [0.4, 2, 4, 3], [0.8, 3, 7, 3], [1, 4, 2, 3]]
    table = pd.DataFrame(values, columns=PARAMETERS, dtype=float)
    table["protein"], table["mean_roughness"] = list("aabcd"), [0.1, 0.3, 0.4, 0.5, 0.6]
    table["best_set"], table["d"], table["d_cv"] = "", 1.0, 1.0
    table["d_from_near"], table["d_from_far"] = [4.0, 6, 7, 9, np.nan], [1.0, 2, 2, 9, 4]
    table["d_from_all"] = [3.0, 3, 7, 5, 1]
    found = relate_to_roughness(table, np.random.default_rng(0))
    assert (found["n_surfaces"], found["n_proteins"], found["n_winners"]) == (5, 4, 5)
    assert (found["shared"], found["n_shared"]) == ("", 0)
    for name, gains in (("gain", [3.5, 5, 0]), ("over_all", [2, 0, 4])):
        ends = [found[f"{name}{end}"] for end in ("", "_low", "_high")]
        assert ends == pytest.approx(mean_interval(gains)) and ends[1] < ends[0] < ends[2]
    means = table.groupby("protein")[[*PARAMETERS, "mean_roughness"]].mean()
    for name in ("alpha", "beta", "gamma"):
        rho = spearmanr(means["mean_roughness"], means[name]).statistic
        low, high = rho_interval(np.array([rho]), 4)
        ends = [found[f"rho_{name}{end}"] for end in ("", "_low", "_high")]
        assert ends == pytest.approx([rho, low[0], high[0]])
    assert np.isnan(found["rho_delta"])
    few = relate_to_roughness(table[2:4], np.random.default_rng(0))
    assert (
        few["gain"] == 2.5 and np.isnan([few["gain_low"], few["gain_high"], few["rho_beta"], few["p"]]).all()
    )


def test_of_seven_surfaces_a_sample_of_the_orders_counts_the_one_that_was_seen():
    """Perfect order of one parameter: 2 of 5040 orders are as large, so that p is about 1 / 2000."""
    values = np.column_stack([np.arange(7.0), np.ones((7, 3))])
    p = [roughness_correlations(np.arange(7.0), values, np.random.default_rng(k))["p"] for k in range(5)]
    assert all(
        2000 * each == pytest.approx(round(2000 * each)) and 1 <= round(2000 * each) <= 6 for each in p
    )
    assert len(set(p)) > 1
