"""The study of coverage: by hand on one replicate, on a pool whose truth is known, and its stored page."""

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT
from sparsurf.report.coverage_page import coverage_markdown
from sparsurf.study import coverage
from sparsurf.study.statistics import estimate, held_out


def test_one_replicate_by_hand():
    x = np.random.default_rng(0).normal(size=(3, 4, 20)) + np.array([0.0, 0.1, 3.0])[:, None, None]
    truth, found = np.array([0.0, 9.0, 3.0]), estimate(x)
    seen = coverage.one_replicate(x, truth)
    assert seen["fixed_t"] == np.mean([found.low[k] <= truth[k] <= found.high[k] for k in range(3)])
    assert seen["selected_bias"] == pytest.approx(found.mean[2] - 3.0)  # the third is the winner
    assert seen["held_out_bias"] == pytest.approx(held_out(x).mean - 3.0)
    assert seen["best_in_set"] == False and seen["set_size"] == 1  # noqa: E712


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
    assert row["selected_bias"] > 0.03 and abs(row["held_out_bias"]) < 0.03


def test_the_page_is_that_of_the_stored_table():
    table = pd.read_csv(ROOT / "docs" / "tables" / "coverage.csv")
    assert (ROOT / "docs" / "coverage.md").read_text(encoding="utf-8") == coverage_markdown(table)
    own = table[(table["draws"] == 6) & (table["test_dots"] == 200)]
    means = own.groupby(["surface", "islands"])[["fixed_t", "held_out", "best_in_set"]].mean()
    assert (own["replicates"] >= 200).all() and len(means) == 4
    assert means["fixed_t"].between(0.93, 0.97).all() and (means["best_in_set"] >= 0.93).all()
