"""When a choice by mean roughness is supported: each condition alone, at its limit."""

import gzip
import re

import numpy as np
import pandas as pd
import pytest

from sparsurf.report.numbers import interval, number
from sparsurf.report.recommendation import (
    EVIDENCE,
    against_uniform,
    beaten,
    read_run,
    reasons,
    recommend,
    rows_for,
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
    ("change", "roughness", "reason"),
    [
        ({"n_proteins": 9}, 0.55, "few"),
        ({}, 0.611, "outside"),
        ({}, 0.489, "outside"),
        ({"n_shared": 4}, 0.55, "shared"),
        ({"p": 0.05}, 0.55, "unrelated"),
        ({"p": np.nan}, 0.55, "unrelated"),
        ({"gain_low": 0.0}, 0.55, "far"),
        ({"gain_low": np.nan}, 0.55, "far"),
        ({"over_all_low": 0.0}, 0.55, "all"),
        ({"over_all_low": np.nan}, 0.55, "all"),
    ],
)
def test_one_condition_fails(change, roughness, reason):
    assert list(reasons(rows(), SUPPORTED | change, roughness)) == [reason]


def test_p_just_below_five_percent_is_enough_and_one_surface_shares_nothing():
    assert not list(reasons(rows(), SUPPORTED | {"p": 0.0499}, 0.55))
    assert not list(reasons(rows(1), SUPPORTED | {"n_shared": 1}, 0.5))


def test_proteins_that_look_like_numbers_or_gaps_keep_their_names(tmp_path):
    names = {"1ubi": "1E96", "1fas": "NA"}
    for path in EVIDENCE.glob("*.csv.gz"):
        text = gzip.decompress(path.read_bytes()).decode()
        for old, new in names.items():
            text = re.sub(rf"^{old},", f"{new},", text, flags=re.M)
        (tmp_path / path.name.removesuffix(".gz")).write_text(text)
    proteins = set(read_run(tmp_path)["summary"]["protein"])
    assert {"1E96", "NA"} <= proteins and not names.keys() & proteins


def test_a_range_holds_its_limits():
    table = pd.DataFrame({"n_S_low_percent": [0.0, 10.0, 20.0], "n_S_high_percent": [10.0, 20.0, 30.0]})
    table = table.assign(
        reading="as_coded", n_combinations=[1, 2, 0], protein="p", conformation=["a", "b", "c"]
    )
    for percent, names in ((0, ["a"]), (10, ["a", "b"]), (15, ["b"]), (20, ["b"]), (25, [])):
        assert rows_for(table, "as_coded", percent)["conformation"].tolist() == names, percent
    assert rows_for(table, "as_written", 15).empty
    # a surface whose fewest or most dots are nearly as requested counts: within a twentieth
    for percent, names in ((9.6, ["a", "b"]), (9.4, ["a"]), (20.9, ["b"]), (21.1, [])):
        assert rows_for(table, "as_coded", percent)["conformation"].tolist() == names, percent


def of_uniform(d, half):
    table = pd.DataFrame({"d_cv": d, "d_cv_low": np.subtract(d, half), "d_cv_high": np.add(d, half)})
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
    ("d", "by"),
    [
        ([0.9, 1.0, 1.1], None),
        ([-0.5, 1.0, 1.5], "none"),
        ([0.5, -1.0, -1.5], "none"),
        ([-0.9, -1.0, -1.1], "uniform"),
    ],
)
def test_the_papers_sampling_is_advised_only_where_it_beats_a_uniform_subset(d, by):
    rows = of_uniform(d, [0.1] * 3)
    assert beaten(rows) == (by and {"by": by, "d": interval(*against_uniform(rows))})


def test_each_reading_gets_the_advice_that_is_of_use_under_it():
    said = recommend(read_run(EVIDENCE), 0.6, 85, np.random.default_rng(0)).split("As written")
    assert len(said) == 2
    assert "n_S_percent: 85" not in said[0] and "sampler: farthest, n_S_percent: 85" in said[1]


def test_all_surfaces_answer_for_all_dots():
    evidence = read_run(EVIDENCE)
    summary = evidence["summary"]
    assert len(rows_for(summary, "as_coded", 100)) == summary["protein"].nunique() == 65


def test_the_answer_for_all_is_that_of_the_range_of_most_surfaces():
    evidence = read_run(EVIDENCE)
    ranges = rows_for(evidence["summary"], "as_coded", 22)["range"]
    assert ranges.min() < ranges.mode()[0] == 3
    pooled = evidence["relation"].set_index(["reading", "range"]).loc[("as_coded", 3)]
    said = recommend(evidence, 0.6, 22, np.random.default_rng(0))
    assert f"{pooled['n_S_percent']:.0f} % of the dots, d = {number(pooled['d'])}" in said
