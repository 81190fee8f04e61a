"""The comparison with the paper: agreement, bias and sentences from made-up numbers, and a run on a small surface."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import reproduce_paper
from sparsurf.report import table_1
from sparsurf.report.html import as_html
from sparsurf.report.verdict import surface_sentence, verdict
from sparsurf.sampling import law
from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.sampling.published import PUBLISHED_ROWS, TABLE_1
from sparsurf.study import (
    grid,
    paper_facts,
    published_runs,
    replication,
    rough_and_flat,
    tables,
    tuned,
    two_readings,
)
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.ranges import range_of
from sparsurf.study.statistics import estimate

ENOUGH = pd.DataFrame(
    [
        ("farthest", "fresh dots", 0.45, "surface", 80.0, 0.44),
        ("farthest", "turned", 0.7, "surface", 20.0, 0.72),
        ("farthest", "fresh dots", 0.45, "recovered", 7.0, 0.48),
        ("farthest", "turned", 0.7, "recovered", 2.5, 0.74),
    ],
    columns=["sampler", "floor", "Z_floor", "islands", "n_S_percent", "Z"],
)


def runs(shift=0.0, sd=0.1, n=40):
    """Winners of as-published runs around the published values, shifted; the published combinations win."""
    rng, out = np.random.default_rng(0), []
    table = pd.DataFrame(TABLE_1)
    for run in range(1, n + 1):
        for binning in published_runs.BINNINGS:
            one = table.assign(
                run=run, binning=binning, range=range(1, 11), n_combinations=5, n_S_percent=50.0
            )
            out.append(
                one.assign(
                    d=one["d"] + shift + sd * rng.normal(size=10), Z_tS=one["Z_tS"] + sd * rng.normal(size=10)
                )
            )
    return pd.concat(out, ignore_index=True)


def test_runs_of_the_same_kind_agree_and_shifted_ones_do_not():
    places = published_runs.place_of_published(runs())
    own = places[places["binning"] == "closed"]
    assert (own["n_won"] == 40).all() and own["d_n_below"].between(5, 35).all()
    assert published_runs.all_rows_at_once(own, "d")["p"] > 0.3
    far = published_runs.place_of_published(runs(shift=-0.3))
    assert (far["d_n_below"] >= 38).all() and (far["d_p"] < 0.1).all()
    assert published_runs.all_rows_at_once(far[far["binning"] == "closed"], "d")["p"] < 1e-3
    assert published_runs.all_rows_at_once(far[far["binning"] == "closed"], "Z_tS")["p"] > 0.3


def test_one_test_of_all_rows_keeps_its_level(monkeypatch):
    monkeypatch.setattr(published_runs, "SIMULATED", 4000)
    # published values drawn as one more run: p < 0.05 in 5 % of 300 cases (standard deviation 1.3 %)
    rng, p = np.random.default_rng(1), []
    for _ in range(300):
        x = rng.normal(size=(11, 6))
        places = pd.DataFrame({"range": range(1, 7), "n_runs": 10, "d_published": x[10]})
        places["d_mean"], places["d_sd"] = x[:10].mean(axis=0), x[:10].std(axis=0, ddof=1)
        p.append(published_runs.all_rows_at_once(places, "d")["p"])
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.04)


def test_places_among_three_runs_by_hand():
    """Table I's first row has d 0.95 and Z_tS 2.85."""
    own = runs(sd=0.0, n=3)
    own = own[(own["binning"] == "closed") & (own["range"] == 1)].assign(
        d=[0.95, 0.9, 1.0], Z_tS=[2.9, 3.0, 3.1]
    )
    own.loc[own["run"] == 3, "gamma"] += 1
    published = TABLE_1[0]
    own["d"] = published["d"] + np.array([0.0, -0.1, 0.1])
    own["Z_tS"] = published["Z_tS"] + np.array([0.1, 0.2, 0.3])
    place = published_runs.place_of_published(own).iloc[0]
    assert (place["n_runs"], place["n_won"]) == (3, 2)
    assert (place["d_n_below"], place["Z_tS_n_below"]) == (1, 0)
    assert place["d_p"] == 1.0  # 2 (1 + 1) / (3 + 1)
    assert place["Z_tS_p"] == 0.5  # 2 (0 + 1) / (3 + 1)
    assert place["Z_tS_mean"] - place["Z_tS_published"] == pytest.approx(0.2)
    assert place["Z_tS_sd"] == pytest.approx(0.1)


def test_one_row_alone_is_tested_by_students_t():
    # (2 - 0) / (0.5 sqrt(1 + 1/4)) = 3.578; t of 3 degrees lies beyond with p = 0.0373
    places = pd.DataFrame(
        {"range": [1, 2], "n_runs": [4, 4], "d_published": [2.0, 9.0], "d_mean": 0.0, "d_sd": 0.5}
    )
    found = published_runs.all_rows_at_once(places, "d", leave_out=[2])
    assert found["n_rows"] == 1
    assert found["statistic"] == pytest.approx(12.8)
    assert found["p"] == pytest.approx(0.0373, abs=0.002)


def test_runs_as_published_have_one_draw_and_test_dots_of_their_own(blob, monkeypatch):
    asked, run = [], grid.run
    monkeypatch.setattr(grid, "run", lambda *args, **keys: asked.append((args, keys)) or run(*args, **keys))
    surface = SimpleNamespace(points=blob[0], normals=blob[1])
    evaluator = Evaluator(surface, d_link=0.8, seed=1, name="blob")
    found = published_runs.as_published(evaluator, PUBLISHED_ROWS[:1], 2)
    for args, keys in asked:
        assert (args[2:], keys) == ((15, 1, ("kept",)), {"shared": False})  # 3000 dots / 200
    assert found["run"].unique().tolist() == [1, 2]
    assert found.dropna(subset="d").groupby("run")["d"].first().nunique() == 2


def test_one_row_off_is_named_and_left_out():
    far = runs()
    last = (far["range"] == 10) & (far["binning"] == "closed")
    far.loc[last, "d"] += 1.0
    far.loc[last, ["alpha", "beta"]] = 1.0, 0.0
    places = published_runs.place_of_published(far)
    bias = pd.DataFrame({"binning": ["closed"], "d_bias": [0.2]})
    sentences = " ".join(table_1.against_runs(places, bias))
    assert "outside of all runs: row 10 (-0.01; runs" in sentences and "without it" in sentences
    assert "wins in 0 of 40 runs where the range holds the largest n_S" in sentences
    assert "and in 40 of 40 where it does not" in sentences


def test_the_largest_number_of_dots_belongs_to_the_last_range_or_to_none():
    percent = np.array([0.0, 5.0, 9.9, 10.0, 95.0, 100.0])
    limits = np.linspace(0, 100, 11)
    assert range_of(percent, limits).tolist() == [0, 0, 0, 1, 9, 9]
    assert range_of(percent, limits, closed=False).tolist() == [0, 0, 0, 1, 9, 10]
    d = np.array([1.0, 3, 2, 0, 4, 9])
    found = pd.DataFrame(published_runs.winners(np.arange(24.0).reshape(6, 4), percent, d, -d))
    last = found[found["range"] == 10].set_index("binning")
    assert last.loc["closed", "d"] == 9 and last.loc["half-open", "d"] == 4
    assert found[found["range"] == 1]["d"].tolist() == [3, 3] and found[found["range"] == 5]["d"].isna().all()


def test_bias_is_the_winner_minus_its_true_value():
    winners = pd.DataFrame(PUBLISHED_ROWS, columns=PARAMETERS).assign(
        d=2.0, Z_tS=3.0, binning="closed", range=range(1, 11)
    )
    truth = pd.DataFrame(PUBLISHED_ROWS, columns=PARAMETERS).assign(d_kept=1.5, Z_tS_kept=3.25)
    bias = published_runs.selection_bias(pd.concat([winners, winners]), truth)
    assert len(bias) == 10 and np.allclose(bias["d_bias"], 0.5) and np.allclose(bias["Z_tS_bias"], -0.25)


def test_signs_that_are_certain():
    d = {
        0.5: (1.0, 0.8, 1.2),
        0.6: (1.4, 1.2, 1.6),
        0.7: (0.1, -0.1, 0.3),
        0.8: (-0.1, -0.2, 0.1),
        0.9: (-0.5, -0.6, -0.4),
    }
    links = pd.DataFrame(
        [
            {"D_link": k, "row": 1, "n_S_percent": 12.0, "d": a, "d_low": b, "d_high": c}
            for k, (a, b, c) in d.items()
        ]
    )
    row = replication.sign_changes(links).iloc[0]
    assert (row["D_link_best"], row["positive_to"], row["negative_from"]) == (0.6, 0.6, 0.9)
    never = replication.sign_changes(links.assign(d_low=-1.0, d_high=1.0)).iloc[0]
    assert np.isnan(never["positive_to"]) and np.isnan(never["negative_from"])


def test_bins_of_roughness_by_hand():
    r = np.tile([0.0, 0.05, 0.95, 1.0], (2, 1))
    z = np.array([np.zeros((2, 4)), [[1.0, 3, 5, 7], [2.0, 4, 6, 8]]])
    found = rough_and_flat.ByRoughness(np.zeros((2, 4), int), r, {"kept": z})
    bins = rough_and_flat.bins_table(found, kept=True, bins=2).set_index("bin")
    assert bins["d_kept"].tolist() == [2.5, 6.5, 2.5, 6.5] and bins["n"].tolist() == [2, 2, 2, 2]
    # two draws whose means differ by 1: half width t(0.975, 1) * 0.5
    assert bins.loc["1", "d_high_kept"] == pytest.approx(2.5 + 12.7062 * 0.5, abs=1e-3)
    one_rough = rough_and_flat.ByRoughness(found.dots, np.array([r[0], [0.95, 0.95, 1, 1]]), found.z)
    assert (
        rough_and_flat.bins_table(one_rough, True, 2).set_index("bin")["d_kept"].isna().tolist()
        == [
            True,
            False,
        ]
        * 2
    )  # a draw has no rough patch
    crossed = rough_and_flat.bins_table(found, kept=False, bins=2).set_index("bin")
    assert crossed.loc["1", "d_high_kept"] == pytest.approx(estimate(z[1][:, :2]).high)


@pytest.mark.parametrize("kept", [True, False])
def test_d_of_a_bin_is_what_its_means_differ_by(kept):
    # three rough and one flat test dot in the first draw, around kept dots one and three in the second
    r = np.array([[0.0, 0.1, 0.2, 1.0], [0.0, 0.8, 0.9, 1.0] if kept else [0.0, 0.1, 0.2, 1.0]])
    z = np.array([[[1.0, 2, 3, 4], [5.0, 6, 7, 8]], [[2.0, 4, 9, 4], [4.0, 8, 8, 8]]])
    found = rough_and_flat.ByRoughness(np.zeros((2, 4), int), r, {"kept": z})
    bins = rough_and_flat.bins_table(found, kept, bins=2).set_index("bin")
    assert np.allclose(bins["d_kept"], bins["Z_tR_kept"] - bins["Z_tS_kept"], rtol=0, atol=1e-12)
    # the mean of 2 and 5, or of all six; of 5 and 4, or of all six
    assert bins.loc["1", ["Z_tS_kept", "Z_tR_kept"]].tolist() == pytest.approx(
        [3.5, 4.5] if kept else [4.0, 35 / 6]
    )
    missing = rough_and_flat.ByRoughness(found.dots, np.array([r[0], [0.8, 0.8, 0.9, 1]]), found.z)
    row = rough_and_flat.bins_table(missing, True, 2).set_index("bin").loc["1"]
    assert row[["Z_tS_kept", "Z_tR_kept", "d_kept"]].isna().all()  # a draw has no rough patch


def test_patches_lie_around_kept_dots_or_any(blob):
    evaluator = Evaluator(SimpleNamespace(points=blob[0], normals=blob[1]), d_link=0.8, seed=1, name="blob")
    combination = Combination(0.8, 0.0, 4.0, 0.0)
    kept = rough_and_flat.by_roughness(evaluator, combination, ["kept"], 100, 2, True)
    for draw in range(2):
        assert np.isin(kept.dots[draw], evaluator.pair(combination, draw)[0]).all()
    assert not np.array_equal(*kept.dots)
    any_dots = rough_and_flat.by_roughness(evaluator, combination, ["kept"], 100, 2, False)
    assert np.array_equal(*any_dots.dots) and any_dots.z["kept"].shape == (2, 2, 100)
    tests, pair = any_dots.dots[0], evaluator.pair(combination, 1)
    z, _ = evaluator.distances(pair, tests, evaluator.describe(tests)[0], "kept")
    assert np.allclose(any_dots.z["kept"][:, 1], z)


def test_the_family_is_tuned_to_the_wished_number(blob):
    evaluator = Evaluator(SimpleNamespace(points=blob[0], normals=blob[1]), d_link=0.8, seed=1, name="blob")
    exponents = [(0, 0, 0), (0, 6, 0), (1, 0, 10), (1, 0, 10)]
    table = tuned.tuned_family(evaluator, exponents, (20.0, 90.0), 30, 2)
    assert np.allclose(table["n_S_percent"], table["percent"], rtol=0.1)
    # beta 1 with delta 10 keeps too few at any alpha; named twice, it would be measured once
    reach = law.expected_n_s(evaluator.cover, [(1.0, *row) for row in exponents[:3]]) / 30
    assert len(table) == (reach >= 20).sum() + (reach >= 90).sum() < 6
    assert (table["alpha"] <= 1).all()
    assert np.allclose(table["d"], table["Z_tR"] - table["Z_tS"], atol=1e-6)


def test_the_best_of_a_family_by_hand():
    table = pd.DataFrame(
        {
            "percent": [5.0, 5, 5, 10],
            **{name: [1.0, 2, 3, 4] for name in PARAMETERS},
            "Z_tS": [1.2, 1.1, 1.3, 0.9],
            "Z_tR": [1.3, 1.4, 1.5, 0.8],
            "d": [0.1, 0.3, -0.05, -0.1],
            "d_low": [0.05, 0.2, -0.2, -0.2],
            "d_high": [0.3, 0.4, 0.1, -0.05],
        }
    )
    five, ten = tuned.best_of_family(table).to_dict("records")
    assert (five["members"], five["n_better"], five["n_worse"]) == (3, 2, 0)
    assert (five["largest_d"], five["Z_best"], five["gamma"]) == (0.3, 1.1, 2)
    assert five["Z_uniform"] == pytest.approx(1.4)
    assert (ten["members"], ten["n_better"], ten["n_worse"], ten["alpha"]) == (1, 0, 1, 4)


def test_correlation_within_tenths_by_hand():
    x = np.arange(40.0)
    table = pd.DataFrame({"n_S_percent": x[::-1], "d_kept": x % 4, "d_surface": -(x % 4)})
    assert two_readings.correlation(table) == pytest.approx(-1)
    assert np.allclose(two_readings.correlation_by_tenths(table), -1)
    # six combinations make two parts of three: both readings go together in the lower one, apart in the upper one
    few = pd.DataFrame({"n_S_percent": [9.0, 1, 8, 2, 7, 3], "d_kept": [1.0, 1, 3, 3, 2, 2]})
    few["d_surface"] = few["d_kept"] * np.where(few["n_S_percent"] < 5, 1, -1)
    assert np.allclose(two_readings.correlation_by_tenths(few), [1, -1])


def test_shattered_patches_by_hand():
    table = pd.DataFrame(
        {
            "d_kept": [1.0, 2.0, 3.0, 4.0],
            "fragment_kept": [3.0, 29.0, 30.0, 90.0],
            "fragment_surface": 100.0,
            "fragment_uniform_kept": np.array([3.0, 29.0, 30.0, 90.0]) / np.exp([1.0, 2.0, 3.0, 4.0]),
        }
    )
    assert two_readings.shattered(table) == 0.5  # 3 and 29 of 100 are below 30 %, 30 is not
    assert two_readings.follows_fragments(table) == pytest.approx(1)


def test_the_facts_of_the_readme_come_from_their_columns(tmp_path):
    """Four combinations, two published rows, one binning's worth of runs: every value can be read off."""
    own = tmp_path / "A1" / "c1"
    own.mkdir(parents=True)
    uniform = [0.2, 0.0, 0.0, 0.0]
    grid = pd.DataFrame([[1, 0, 2, 0], uniform, [0.2, 0, 2, 0], [1, 1, 0, 0]], columns=PARAMETERS)
    grid = grid.assign(
        n_S_percent=[50.0, 19.9, 7.0, 90.0], d_kept=[1.0, -1, 2, 0], d_surface=[-1.0, 1, -2, 0]
    )
    grid.assign(Z_tS_kept=[1.0, 2, 3, 4], Z_tS_surface=[3.5, 3.5, 3.5, 2]).to_csv(own / "grid.csv")
    halves = [(a, h) for a in ("kept dots", "any dots") for h in ("rougher half", "flatter half")]
    bins = pd.DataFrame(halves, columns=["around", "bin"]).assign(d_kept=[1.0, 2, 3, 4])
    bins.assign(d_surface=-bins["d_kept"]).to_csv(own / "rough_and_flat.csv")
    winner = {"alpha": 1, "beta": 0, "gamma": 2, "delta": 0, "n_S_percent": 50.0, "d": 0.12345}
    winner |= {"d_held_out": 0.11, "d_held_out_low": 0.1, "d_held_out_high": 0.12, "n_best_set": 3}
    best = {reading: {"unrestricted": winner} for reading in ("kept", "surface")}
    (own / "best.json").write_text(json.dumps(best | {"yardsticks": {"null_model": 3.0}}))
    places = published_runs.place_of_published(runs(n=4))
    first = (places["binning"] == "closed") & (places["range"] == 1)
    last = (places["binning"] == "closed") & (places["range"] == 10)
    measures = [f"{m}_{k}" for m in ("d", "Z_tS") for k in ("published", "lowest", "highest")]
    places[measures] = [0.5, 0.0, 1.0] * 2  # inside of the runs, but for one above and one below
    places.loc[first, "d_published"], places.loc[last, "d_published"] = 1.5, -0.5
    places.loc[last, "n_won"] = 1
    places.to_csv(tmp_path / "paper_places.csv")
    rows = {"d_kept": [-1.0, 5], "d_surface": [2.0, 3], "Z_tS_kept": [3.5, 2], "Z_tS_surface": [3.5, 4]}
    pd.DataFrame(rows).to_csv(tmp_path / "paper_rows.csv")
    links = {
        "row": 1,
        "D_link": [0.5, 0.6],
        "n_S_percent": 9.0,
        "d": [0.0, 1.0],
        "d_low": -1.0,
        "d_high": 2.0,
    }
    pd.DataFrame(links).to_csv(tmp_path / "paper_links.csv")
    pd.DataFrame({"d_low": [-0.1, 0.1, 0.2]}).to_csv(tmp_path / "paper_family.csv")
    facts = paper_facts.paper_facts(tmp_path).set_index("name")["value"]
    wanted = {
        "n_combinations": "4", "null_model": "3", "n_runs": "4",
        "best_kept": str(Combination(1, 0, 2, 0)), "best_d_kept": "0.1235", "best_n_best_set_surface": "3",
        "n_positive_kept": "2", "n_positive_surface": "1",
        "n_above_null_kept": "1", "n_above_null_surface": "3",
        "n_rows_above_null_kept": "1", "n_rows_above_null_surface": "2",
        "rows_d_lowest_kept": "-1", "rows_d_highest_surface": "3",
        "d_rougher_kept_dots_kept": "1", "d_flatter_kept_dots_kept": "2",
        "d_rougher_any_dots_surface": "-3", "d_flatter_any_dots_surface": "-4",
        "correlation": "-1", "family_n_better": "2", "family_members": "3", "uniform_0.2_percent": "19.9",
        "d_outside_closed": "1 10", "d_outside_half-open": "none", "Z_tS_outside_closed": "none",
        "won_last_closed": "1", "won_last_half-open": "4",
        "link_best_row_1": "0.6", "link_negative_row_1": "nan",
    }  # fmt: skip
    assert {name: facts[name] for name in wanted} == wanted


@pytest.fixture(scope="module")
def page(blob):
    """Data of a verdict on a small surface, everything but the published values computed."""
    surface = SimpleNamespace(points=blob[0], normals=blob[1])
    own = {"d_link": 0.8, "seed": 1, "name": "blob"}
    evaluator = Evaluator(surface, **own)
    result = grid.run(evaluator, PUBLISHED_ROWS, 40, 2)
    table = tables.grid_table(result)
    runs = published_runs.as_published(evaluator, PUBLISHED_ROWS, 3)
    best = tables.best(table, result, 20)
    links = replication.sweep_links(evaluator, (0.8, 1.2), 20, 2)
    combination, bins = Combination.of(best["kept"]["unrestricted"]), []
    for around, kept in rough_and_flat.AROUND.items():
        found = rough_and_flat.by_roughness(evaluator, combination, ["kept", "surface"], 600, 2, kept)
        bins.append(rough_and_flat.bins_table(found, kept).assign(around=around))
    return {
        "grid": table,
        "ranges": tables.ranges_table(table, result),
        "best": best,
        "rows": replication.published_rows(evaluator, 20, 2),
        "places": published_runs.place_of_published(runs),
        "bias": published_runs.selection_bias(runs, table),
        "links": links,
        "signs": replication.sign_changes(links),
        "defects": replication.compare_defects(evaluator, 20, 1),
        "bins": pd.concat(bins),
        "family": tuned.best_of_family(tuned.tuned_family(evaluator, PUBLISHED_ROWS[:, 1:], (10.0,), 20, 2)),
        "enough": ENOUGH,
        "uniform": {"median": 3.0},
        "surface": surface_sentence(evaluator, {"reentrant": "exact", "density": 5}, "a/blob.dms"),
    }


FILES = {
    key: f"{key}.csv"
    for key in (
        "grid",
        "ranges",
        "best",
        "rows",
        "links",
        "defects",
        "places",
        "bins",
        "family",
        "enough",
        "floors",
    )
}


def test_every_claim_has_numbers_and_a_file(page):
    text = verdict(page, FILES)
    for heading in text.split("\n## ")[1:]:
        assert any(c.isdigit() for c in heading)
        assert ".csv`" in heading, heading.splitlines()[0]
    assert "the dots of blob.dms, as they are; N = 3000 dots" in text
    assert as_html(text).count("<h2>") == text.count("\n## ")


def test_the_verdict_begins_with_its_answer(page):
    rows = page["rows"].assign(d_kept=np.linspace(1, 2.5, 10), d_surface=-0.25)
    grid = page["grid"].assign(d_low_kept=0.1, d_high_kept=0.3, d_high_surface=-0.1, Z_tS_kept=9.0)
    grid.loc[grid.index[:5], "d_low_kept"] = -0.1
    lines = verdict(page | {"rows": rows, "grid": grid}, FILES).splitlines()
    assert lines[3].startswith(
        "- `kept`: d of the ten published rows is 1.00 to 2.50; the sampling beats a uniform draw for certain in 50 % of"
    )
    assert "in 100 % its subset describes a patch worse than the mean of all patches does" in lines[3]
    assert "and loses to it in 0 %;" in lines[3]
    assert "-0.25 to -0.25" in lines[4] and "loses to it in 100 %" in lines[4]
    named = [
        f"{name} ({binning} ranges)"
        for name in published_runs.MEASURES
        for binning in published_runs.BINNINGS
    ]
    assert all(name in lines[2] for name in named)


def test_sentences_hold_the_numbers_of_their_tables(page):
    columns = {f"{key}_{reading}": x for key, x in (("d", 1.25), ("d_low", 0.5), ("d_high", 2.0)) for reading in
               ("kept", "surface")}  # fmt: skip
    grid, bins = page["grid"].assign(**columns), page["bins"].assign(**columns | {"n": 50})
    text = verdict(page | {"grid": grid, "bins": bins}, FILES)
    for reading in ("kept", "surface"):
        assert (
            f"`{reading}`: d is positive in 10 of 10 combinations, above zero with its whole 95 % interval in 10 and below "
            "in 0; mean 1.25, largest 1.25." in text
        )
        for around in ("kept dots", "any dots"):
            assert (
                f"Patches around {around}, `{reading}`: d is 1.25 (0.50 .. 2.00) in the rougher half of the bins and 1.25 "
                "(0.50 .. 2.00) in the flatter half: no difference for certain" in text
            )
    signs = f"peaks at a D_link between {page['signs']['D_link_best'].min():.1f} and"
    assert signs in text
    outlook = text[text.index("## Outlook") :]
    assert "has a Z of 0.48 where other dots of the same surface, all kept, have 0.45" in outlook


def test_links_keep_the_samplings_and_change_the_islands(page):
    links = page["links"].set_index(["D_link", "row"])
    assert np.allclose(links.loc[0.8]["n_S_percent"], links.loc[1.2]["n_S_percent"])
    assert (links.loc[1.2]["fragment"] >= links.loc[0.8]["fragment"]).all()
    # at the surface's own D_link the sweep is the table of the published rows
    assert np.allclose(links.loc[0.8]["d"], page["rows"]["d_kept"], atol=1e-6)
    assert np.allclose(links.loc[0.8]["Z_tS"], page["rows"]["Z_tS_kept"], atol=1e-6)
    assert links.loc[0.8]["fragment"].tolist() == page["rows"]["fragment_kept"].tolist()


def test_rows_stand_beside_what_the_paper_says_of_them(page):
    rows = page["rows"]
    for column in ("n_S_low_percent", "n_S_high_percent"):
        assert rows[column].tolist() == list(TABLE_1[column])
    for column in ("d", "Z_tS"):
        assert rows[f"{column}_published"].tolist() == list(TABLE_1[column])


def test_one_draw_per_dot_keeps_fewer(page):
    percent = page["defects"].pivot(index="row", columns="sampling", values="n_S_percent")
    assert (percent["one draw per dot"] <= percent["as published"] + 1e-9).all()


def test_each_defect_has_its_own_cover(page, blob):
    surface = SimpleNamespace(points=blob[0], normals=blob[1])
    view = Evaluator(surface, d_link=0.8, seed=1, name="blob")
    percent = page["defects"].pivot(index="row", columns="sampling", values="n_S_percent")
    for name, moved, every in (
        ("distances from the dot itself", False, True),
        ("one draw per dot", True, False),
        ("both corrected", False, False),
    ):
        cover = law.build_cover(
            view.index, view.roughness, view.r_patch, moved_centre=moved, every_patch=every
        )
        assert np.allclose(percent[name], 100 * law.expected_n_s(cover, PUBLISHED_ROWS) / 3000)


def test_the_comparison_with_the_paper_is_made_of_what_the_config_wishes(tmp_path, monkeypatch):
    cover = SimpleNamespace(dot=np.array([0, 0, 0, 1, 2]))  # three, one and one patch
    rows = []

    def table(*words):
        rows.append(words)
        return pd.DataFrame({"what": [" ".join(map(str, words))]})

    for module, name, made in (
        (reproduce_paper, "read_npz", lambda _: range(8000)),
        (reproduce_paper.Evaluator, "from_settings", lambda *_: SimpleNamespace(cover=cover)),
        (published_runs, "as_published", lambda _, grid, progress: table("runs", *grid[1])),
        (published_runs, "place_of_published", lambda runs: table("places of", runs["what"][0])),
        (published_runs, "selection_bias", lambda runs, grid: f"{runs['what'][0]}, {grid['what'][0]}"),
        (replication, "published_rows", lambda _, *given: table("rows", *given)),
        (replication, "sweep_links", lambda _, links, *given: table("links", len(links), *given)),
        (replication, "compare_defects", lambda _, *given: table("defects", *given)),
        (replication, "sign_changes", lambda links: links["what"][0]),
        (tuned, "tuned_family", lambda _, some, n_tests, draws: table("family", *some[1], n_tests, draws)),
        (tuned, "best_of_family", lambda family: family["what"][0]),
        (reproduce_paper, "surface_sentence", lambda _, rules, path: f"{rules} of {path}"),
        (reproduce_paper, "verdict", lambda results, names: told.append((results, names)) or "# Page\n"),
    ):
        monkeypatch.setattr(module, name, made)
    told, names = [], ("surface", "roughness", "grid", "ranges", "best", "bins", "enough")
    inputs = {name: str(tmp_path / f"{name}.csv") for name in names}
    for name in names:
        pd.DataFrame({"roughness": [0.5], "what": name}).to_csv(inputs[name])
    Path(inputs["best"]).write_text(json.dumps({"yardsticks": {"empty_patch": 9.5, "null_model": 1.5}}))
    made = ("runs", "places", "rows", "links", "defects", "family", "verdict", "html")
    outputs = {name: str(tmp_path / f"of_{name}") for name in made}
    sampling = {"alpha": [0.5, 1.0], "beta": [0.2], "gamma": [2, 3], "delta": [4, 5, 6]}
    settings = {
        "sampling": sampling,
        "evaluation": {"test_dots": "published", "draws": 3},
        "surface": "rules",
    }
    reproduce_paper.main(inputs, outputs, settings, "p/c1", 1, "a.pdb")
    wished = {
        "runs": "runs 0.5 0.2 2.0 5.0",
        "places": "places of runs 0.5 0.2 2.0 5.0",
        "rows": "rows 40 3",
        "links": f"links {len(replication.LINKS)} 40 3",
        "defects": "defects 40 3",
        "family": "family 0.2 2.0 5.0 40 3",
    }
    for name, words in wished.items():
        stored = pd.read_csv(outputs[name])
        assert stored.to_dict("records") == [{"what": words, "empty_patch": 9.5, "null_model": 1.5}]
    ((results, called),) = told
    assert results["bias"] == f"{wished['runs']}, grid" and results["signs"] == wished["links"]
    assert results["family"] == wished["family"] and results["surface"] == "rules of a.pdb"
    assert results["uniform"] == {"median": 1.0}
    assert (called["bins"], called["runs"]) == ("bins.csv", "of_runs")
    assert (
        Path(outputs["verdict"]).read_text() == "# Page\n" and "<h1>Page" in Path(outputs["html"]).read_text()
    )
