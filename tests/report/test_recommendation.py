"""When a choice by mean roughness is supported: each condition alone, at its limit."""

import numpy as np
import pandas as pd
import pytest

from sparsurf.report.recommendation import (
    EVIDENCE,
    against_uniform,
    read_run,
    reasons,
    recommend,
    rows_for,
    uniform_first,
)
from sparsurf.sampling.combination import PARAMETERS

SUPPORTED = {
    "n_proteins": 10,
    "n_shared": 3,
    "shared": "(1, 0, 2, 0)",
    "p": 0.01,
    "gain": 0.3,
    "gain_low": 0.1,
}
SUPPORTED |= {"gain_high": 0.5, "over_all": 0.2, "over_all_low": 0.1, "over_all_high": 0.3}
SUPPORTED |= {f"rho_{p}{end}": np.nan for p in PARAMETERS for end in ("", "_low", "_high")}


def rows(n=4, proteins=1):
    table = pd.DataFrame({"mean_roughness": np.linspace(0.50, 0.60, n)})
    return table.assign(protein=[f"p{k % proteins}" for k in range(n)])


def test_all_conditions_hold():
    assert not list(reasons(rows(), SUPPORTED, 0.55))
    assert not list(reasons(rows(), SUPPORTED, 0.609)), "as rough as the roughest but for a hundredth"
    assert not list(reasons(rows(), SUPPORTED, 0.491))


@pytest.mark.parametrize(
    ("change", "roughness", "words"),
    [
        (
            {"n_proteins": 9},
            0.55,
            "only 9 proteins have an answer in this range of n_S, and a relation needs at least 10",
        ),
        ({"n_proteins": 1}, 0.55, "only 1 protein has an answer"),
        ({}, 0.611, r"0.611 lies outside of what was seen, 0.500 .. 0.600"),
        ({}, 0.489, "0.489 lies outside"),
        (
            {"n_shared": 4},
            0.55,
            r"one combination, \(1, 0, 2, 0\), may be the best on each of the 4",
        ),
        ({"p": 0.05}, 0.55, "no more correlated in rank with mean roughness than by chance"),
        ({"p": np.nan}, 0.55, "no more correlated"),
        ({"gain_low": 0.0}, 0.55, "gives no higher d than one chosen on the farthest"),
        ({"gain_low": np.nan}, 0.55, "gives no higher d"),
        ({"over_all_low": 0.0}, 0.55, "gives no higher d than one chosen on all"),
        ({"over_all_low": np.nan}, 0.55, "gives no higher d than one chosen on all"),
    ],
)
def test_one_condition_fails(change, roughness, words):
    (found,) = reasons(rows(), SUPPORTED | change, roughness)
    assert pd.Series([found]).str.contains(words).all(), found


def test_p_just_below_five_percent_is_enough_and_one_surface_shares_nothing():
    assert not list(reasons(rows(), SUPPORTED | {"p": 0.0499}, 0.55))
    assert not list(reasons(rows(1), SUPPORTED | {"n_shared": 1}, 0.5))


def test_a_range_holds_its_limits():
    table = pd.DataFrame({"n_S_low_percent": [0.0, 10.0, 20.0], "n_S_high_percent": [10.0, 20.0, 30.0]})
    table = table.assign(islands="kept", n_combinations=[1, 2, 0], protein="p", conformation=["a", "b", "c"])
    for percent, names in ((0, ["a"]), (10, ["a", "b"]), (15, ["b"]), (20, ["b"]), (25, [])):
        assert rows_for(table, "kept", percent)["conformation"].tolist() == names, percent
    assert rows_for(table, "surface", 15).empty
    # a surface whose fewest or most dots are nearly as wished counts: within a twentieth
    for percent, names in ((9.6, ["a", "b"]), (9.4, ["a"]), (20.9, ["b"]), (21.1, [])):
        assert rows_for(table, "kept", percent)["conformation"].tolist() == names, percent


def of_uniform(d, half):
    table = pd.DataFrame(
        {"d_held_out": d, "d_held_out_low": np.subtract(d, half), "d_held_out_high": np.add(d, half)}
    )
    columns = ["mean_roughness", *PARAMETERS, "d", "d_from_near", "d_from_far", "d_from_all"]
    return table.assign(protein=[f"p{k}" for k in range(len(d))], **dict.fromkeys(columns, 1.0))


def test_few_surfaces_have_the_error_of_their_test_dots():
    assert against_uniform(of_uniform([1.0], [0.4])) == pytest.approx((1.0, 0.6, 1.4))
    # two of half width .3 and .4: their mean has sqrt(.09 + .16) / 2
    assert against_uniform(of_uniform([1.0, 2.0], [0.3, 0.4])) == pytest.approx((1.5, 1.25, 1.75))


def test_three_surfaces_have_students_interval_of_their_scatter():
    # 1, 2, 3: mean 2, sd 1, t(.975, 2) = 4.3027
    found = against_uniform(of_uniform([1.0, 2.0, 3.0], [9.0, 9.0, 9.0]))
    assert found == pytest.approx((2, 2 - 4.3027 / np.sqrt(3), 2 + 4.3027 / np.sqrt(3)), abs=1e-4)


@pytest.mark.parametrize(
    ("d", "words"),
    [
        ([0.9, 1.0, 1.1], None),
        ([-0.5, 1.0, 1.5], "cannot be told from a uniform subset"),
        ([0.5, -1.0, -1.5], "cannot be told from a uniform subset"),
        ([-0.9, -1.0, -1.1], "is worse than a uniform subset"),
    ],
)
def test_the_papers_sampling_is_advised_only_where_it_beats_a_uniform_subset_for_certain(d, words):
    said = " ".join(uniform_first(of_uniform(d, [0.1] * 3), "kept", 20))
    assert (words in said) if words else not said
    assert "farthest-point" not in said  # of use under the other reading


def test_all_surfaces_answer_for_all_dots_and_a_mean_of_more_than_answer_says_so():
    evidence = read_run(EVIDENCE)
    summary = evidence["summary"]
    assert len(rows_for(summary, "kept", 100)) == summary["protein"].nunique() == 65
    said = recommend(evidence, 0.6, 30, np.random.default_rng(0))
    assert "on average; it lies in" in said and "on average of" not in said
    few = summary[summary["protein"].isin(summary["protein"].unique()[:3])]
    assert "on average of 65 surfaces; it lies in" in recommend(
        evidence | {"summary": few}, 0.6, 30, np.random.default_rng(0)
    )


def test_the_answer_for_all_is_that_of_the_range_of_most_surfaces():
    evidence = read_run(EVIDENCE)
    ranges = rows_for(evidence["summary"], "kept", 22)["range"]
    assert ranges.min() < ranges.mode()[0] == 3
    pooled = evidence["relation"].set_index(["islands", "range"]).loc[("kept", 3)]
    said = recommend(evidence, 0.6, 22, np.random.default_rng(0))
    assert f"n_S = {pooled['n_S_percent']:.1f} %, d = {pooled['d']:+.2f}" in said
