"""The study of coverage: by hand on one replicate, on a pool whose truth is known, and its stored page."""

import numpy as np
import pandas as pd
import pytest

import measure_coverage
from conftest import ROOT
from sparsurf.report.coverage_page import coverage_markdown
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.study import coverage
from sparsurf.study.statistics import estimate, held_out


def test_one_replicate_by_hand():
    x = np.random.default_rng(0).normal(size=(3, 4, 20)) + np.array([0.0, 0.1, 3.0])[:, None, None]
    truth, found = np.array([0.0, 9.0, 3.0]), estimate(x)
    seen = coverage.one_replicate(x, truth)
    assert seen["fixed_t"] == np.mean([found.low[k] <= truth[k] <= found.high[k] for k in range(3)])
    assert seen["selected_bias"] == pytest.approx(found.mean[2] - 3.0)  # the third is the winner
    assert seen["held_out_bias"] == pytest.approx(held_out(x).mean - 3.0)
    off = np.abs(found.mean - truth) / found.error
    assert seen["fixed_normal"] == np.mean(off <= 1.95996)
    assert seen["half_width"] == pytest.approx(held_out(x).half)
    assert seen["best_in_set"] == False and seen["set_size"] == 1  # noqa: E712


def test_intervals_of_just_that_width_hold_their_truth():
    # means 0 and 1 with errors of 1 / sqrt(20) but for the scatter of the draws
    x = np.random.default_rng(2).normal(size=(2, 6, 20)) + np.array([0.0, 1.0])[:, None, None]
    found = estimate(x)
    for errors, normal, by_t in ((1.9, 1, 1), (1.97, 0, 1), (9.0, 0, 0)):
        seen = coverage.one_replicate(x, found.mean - errors * found.error, sets=False)
        assert (seen["fixed_normal"], seen["fixed_t"], seen["winner"]) == (normal, by_t, by_t)
        assert seen["selected_bias"] == pytest.approx(errors * found.error[1])


def test_the_pool_holds_the_contenders_of_every_range(monkeypatch):
    monkeypatch.setattr(coverage, "CONTENDERS", 2)
    monkeypatch.setattr(coverage, "N_RANGES", 2)
    monkeypatch.setattr(coverage.grid, "run", lambda evaluator, rows, tests, draws, readings: rows)
    monkeypatch.setattr(coverage, "difference", lambda rows, r: rows[:, 2] + 10 * r)
    table = pd.DataFrame(
        {
            "n_S_percent": [0.0, 1, 2, 3, 60, 80, 100],
            "d_kept": [4.0, 3, 2, 1, 1, 2, 3],
            "d_surface": [4.0, 2, 1, 3, 3, 2, 1],
            **{name: np.arange(7.0) for name in PARAMETERS},
        }
    )
    d, member = coverage.pool(None, table, ("kept", "surface"))
    # kept: 0 and 1 of the lower range, 6 and 5 of the upper one; surface: 0 and 3, 4 and 5
    assert d.tolist() == [[0, 1, 3, 4, 5, 6], [10, 11, 13, 14, 15, 16]]
    assert member.tolist() == [0, 0, 0, 1, 1, 1]


def test_sets_are_made_for_the_default_design_of_every_surface_and_reading(tmp_path, monkeypatch):
    pools = {"c1": 1.0, "c2": 3.0}
    monkeypatch.setattr(
        measure_coverage, "pool_of", lambda folder: ([pools[folder.name], pools[folder.name] + 1], None)
    )
    monkeypatch.setattr(
        coverage,
        "replicates",
        lambda d, *_: pd.DataFrame(
            {"range": [1], "pool": d, "drawn": _[-2].random(), "third": 1 / 3, "sets": _[-1]}
        ),
    )
    monkeypatch.setattr(measure_coverage, "coverage_markdown", lambda table: f"{len(table)} rows")
    folders = [tmp_path / "p" / name for name in pools]
    measure_coverage.main(folders, 7, tmp_path / "table.csv", tmp_path / "page.md")
    table = pd.read_csv(tmp_path / "table.csv")
    assert (tmp_path / "page.md").read_text() == "12 rows" and (table["replicates"] == 7).all()
    assert table.groupby(["surface", "islands"], sort=False)["pool"].unique().explode().to_dict() == {
        ("p/c1", "kept"): 1, ("p/c1", "surface"): 2, ("p/c2", "kept"): 3, ("p/c2", "surface"): 4,
    }  # fmt: skip
    assert table[table["sets"]][["draws", "test_dots"]].to_numpy().tolist() == 4 * [[6, 200]]
    assert (table["third"] == 0.3333).all()
    # each surface, reading and number of draws has random numbers of its own
    assert table["drawn"].nunique() == len(table[["surface", "islands", "draws"]].drop_duplicates()) > 4


def test_the_pool_of_a_surface_is_computed_once(tmp_path, monkeypatch):
    asked = []
    for name in ("roughness", "grid"):
        pd.DataFrame({name: [0.5]}).to_csv(tmp_path / f"{name}.csv")
    monkeypatch.setattr(measure_coverage, "read_npz", lambda _: None)
    monkeypatch.setattr(measure_coverage, "Evaluator", lambda *_, **__: None)
    monkeypatch.setattr(coverage, "pool", lambda *_: asked.append(_) or (np.array([1.5]), np.array([2])))
    for _ in range(2):
        d, member = measure_coverage.pool_of(tmp_path)
        assert (d.tolist(), member.tolist()) == ([1.5], [2])
    assert len(asked) == 1


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
