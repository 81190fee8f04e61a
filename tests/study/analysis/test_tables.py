"""Tables from made-up distances whose answers are known."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from sparsurf.evaluation.statistics import cross_validated, estimate, reference_values
from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.surface import Surface
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


def test_held_out_value_is_free_of_selection_bias(monkeypatch):
    monkeypatch.setattr(
        "sparsurf_study.analysis.best_set.SIMULATED_OUTCOMES", 50
    )  # its set does not matter here
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
    grid = made_up([1.0, 2.0, 3.0], [45, 30, 60])
    best = tables.best_combinations(tables.grid_table(grid), grid, 2)
    answer = best["kept"]["under_max_n_S"]["answer"]
    assert "No combination of the grid keeps 2 % of the dots or fewer; the smallest n_S is 30.00 %" in answer


def two_readings():
    """A grid of four combinations and two readings with scatter, whose winners differ between the readings."""
    combos = [[0.5, 0, 2, 0], [0.5, 1, 4, 2], [0.8, 0, 2, 1], [0.8, 1, 6, 3]]
    one = made_up([1.0, 2.0, 0.5, 0.4], [4, 8, 30, 90], draws=3, noise=0.5, combinations=combos)
    two = made_up([2.0, 1.0, 0.1, 0.6], [4, 8, 30, 90], draws=3, noise=0.7)
    z_ts = np.concatenate([one.z_ts, two.z_ts]) * [[[[2.0]]], [[[3.0]]]]
    z_ts = z_ts + np.random.default_rng(1).normal(size=z_ts.shape)
    sizes = np.arange(16.0).reshape(2, 2, 4)
    z_tr = np.concatenate([one.z_tr, two.z_tr]) + z_ts - 1
    n_s = one.n_s + np.array([0, 1, 5])  # mean 2
    expected = np.array([41.0, 281, 150, 899])
    return replace(
        one, z_ts=z_ts, z_tr=z_tr, median_patch_size=sizes, readings=("kept", "full"), n_s=n_s,
        n_s_expected=expected,
    )  # fmt: skip


def test_every_column_of_a_winner_is_that_of_its_combination_and_reading():
    grid, floors = two_readings(), {"fresh dots": 0.25, "others": 0.5}
    table = tables.grid_table(grid)
    assert table["n_S"].tolist() == [42, 82, 302, 902] and table["n_S_expected"].tolist() == [
        41,
        281,
        150,
        899,
    ]
    assert table["n_S_percent"].tolist() == pytest.approx([4.2, 8.2, 30.2, 90.2])
    ranges = tables.ranges_table(table, grid, 2, floors)
    assert ranges["reading"].tolist() == ["kept", "kept", "full", "full"]
    assert ranges["n_S_low_percent"].tolist() == pytest.approx([4.2, 47.2] * 2)
    assert ranges["n_S_high_percent"].tolist() == pytest.approx([47.2, 90.2] * 2)
    assert ranges["n_combinations"].tolist() == [3, 0, 3, 0]
    references = reference_values(grid.z_tot)
    for name in ("Z_empty", "Z_mean_descriptor"):
        assert ranges[name].tolist() == [references[name]] * 4
    assert ranges["Z_resampled"].tolist() == [0.25] * 4
    best = tables.best_combinations(table, grid, 20, floors)
    head = {"N": 1000, "combinations": 4, "draws": 3, "max_n_S_percent": 20}
    assert {key: best[key] for key in head} == head
    assert best["references"] == references | {"floors": floors}
    assert tables.best_combinations(table, grid, 20)["references"] == references
    for r, (reading, few, many) in enumerate((("kept", 1, 2), ("full", 0, 3))):
        d = grid.z_tr[r] - grid.z_ts[r]
        for row, winner, inside in (
            (ranges.iloc[2 * r], few, [0, 1, 2]), (best[reading]["under_max_n_S"], few, [0, 1]),
            (best[reading]["unrestricted"], many, [2, 3]),
        ):  # fmt: skip
            assert [row[name] for name in PARAMETERS] == grid.combinations[winner].tolist()
            assert row["n_S"] == [42, 82, 302, 902][winner] and row["n_S_percent"] == row["n_S"] / 10
            assert row["n_combinations"] == len(inside)
            for name, values in (("d", d), ("Z_tS", grid.z_ts[r]), ("Z_tR", grid.z_tr[r])):
                assert row[name] == pytest.approx(values[winner].mean())
            own, held = estimate(d[winner]), cross_validated(d[inside])
            assert [row["d_low"], row["d_high"]] == pytest.approx([own.low, own.high])
            assert [row[f"d_cv{end}"] for end in ("", "_low", "_high")] == pytest.approx(
                [held.mean, held.low, held.high]
            )
            assert row["median_patch_size"] == grid.median_patch_size[r, 0, winner]
            assert row["n_best_set"] == len(row["best_set"].split("; "))
    for name, r, reading in (("Z_tS", 1, "full"), ("Z_tR", 0, "kept")):
        means = estimate((grid.z_ts if name == "Z_tS" else grid.z_tr)[r])
        for key, values in (
            ("", means.mean),
            ("se_", means.error),
            ("low_", means.low),
            ("high_", means.high),
        ):
            assert np.allclose(table[f"{name}_{key}{reading}"], values)
    assert table["median_patch_size_uniform_full"].tolist() == [12, 13, 14, 15]
    assert "Z_resampled" not in tables.ranges_table(table, grid, 2)
    assert len(tables.ranges_table(table, grid)) == 2 * 10


def test_floors_by_their_name():
    assert tables.floors_by_name(pd.DataFrame({"floor": ["a", "b"], "Z": [1, 2.5], "se": 9.0})) == {
        "a": 1,
        "b": 2.5,
    }


def test_chains_without_a_name_and_those_called_na_are_read_as_they_are(tmp_path):
    (tmp_path / "r.csv").write_text("chain,residue,area,kept\n,007,1.5,2\nNA,-1A,,0\n")
    table = tables.read_residues(tmp_path / "r.csv")
    assert table["chain"].tolist() == ["", "NA"] and table["residue"].tolist() == ["007", "-1A"]
    assert table["area"].isna().tolist() == [False, True] and table["kept"].tolist() == [2, 0]


def test_a_surface_is_prepared_from_its_files(blob, tmp_path):
    write_npz(tmp_path / "s.npz", Surface(*blob))
    rough = np.linspace(0, 1, 3000)
    pd.DataFrame({"roughness": rough}).to_csv(tmp_path / "r.csv", index=False)
    settings, streams = Settings(patches={"d_link": 0.9}), Streams(4, "p/c")
    found = tables.read_prepared(str(tmp_path / "s.npz"), str(tmp_path / "r.csv"), settings, streams, 2)
    assert np.array_equal(found.roughness, rough) and len(found) == 3000
    assert (found.patches.d_link, found.stream, found.threads) == (0.9, streams, 2)
