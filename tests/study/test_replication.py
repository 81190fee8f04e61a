"""The comparison with the paper: agreement, bias and sentences from made-up numbers, and a run on a small surface."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from sparsurf.report import table_1
from sparsurf.report.html import as_html
from sparsurf.report.verdict import surface_sentence, verdict
from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.sampling.published import PUBLISHED_ROWS, TABLE_1
from sparsurf.study import grid, published_runs, replication, rough_and_flat, tables, tuned, two_readings
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


def test_one_test_of_all_rows_keeps_its_level():
    # published values drawn as one more run: p < 0.05 in 5 % of 300 cases (standard deviation 1.3 %)
    rng, p = np.random.default_rng(1), []
    for _ in range(300):
        x = rng.normal(size=(11, 6))
        places = pd.DataFrame({"range": range(1, 7), "n_runs": 10, "d_published": x[10]})
        places["d_mean"], places["d_sd"] = x[:10].mean(axis=0), x[:10].std(axis=0, ddof=1)
        p.append(published_runs.all_rows_at_once(places, "d")["p"])
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.04)


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
    found = pd.DataFrame(published_runs.winners(np.arange(24.0).reshape(6, 4), percent, d, d))
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
    crossed = rough_and_flat.bins_table(found, kept=False, bins=2).set_index("bin")
    assert crossed.loc["1", "d_high_kept"] == pytest.approx(estimate(z[1][:, :2]).high)


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
    assert table["percent"].tolist() == [20.0, 20.0, 90.0] or len(table) >= 2
    best = tuned.best_of_family(table.assign(d_low=[0.1] + [-0.1] * (len(table) - 1)))
    assert best["n_better"].tolist()[0] == 1 and best["members"].sum() == len(table)


def test_correlation_within_tenths_by_hand():
    x = np.arange(40.0)
    table = pd.DataFrame({"n_S_percent": x[::-1], "d_kept": x % 4, "d_surface": -(x % 4)})
    assert two_readings.correlation(table) == pytest.approx(-1)
    assert np.allclose(two_readings.correlation_by_tenths(table), -1)


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
    grid = page["grid"].assign(d_low_kept=0.1, d_high_surface=-0.1, Z_tS_kept=9.0)
    grid.loc[grid.index[:5], "d_low_kept"] = -0.1
    lines = verdict(page | {"rows": rows, "grid": grid}, FILES).splitlines()
    assert lines[3].startswith(
        "- `kept`: d of the ten published rows is 1.00 to 2.50; the sampling beats a uniform draw for certain in 50 % of"
    )
    assert "in 100 % its subset describes a patch worse than the mean of all patches does" in lines[3]
    assert "-0.25 to -0.25" in lines[4] and "loses to it in 100 %" in lines[4]
    named = [
        f"{name} ({binning} ranges)"
        for name in published_runs.MEASURES
        for binning in published_runs.BINNINGS
    ]
    assert all(name in lines[2] for name in named)


def test_sentences_change_when_numbers_do(page):
    text = verdict(page, FILES)
    turned = page["grid"].assign(d_kept=-page["grid"]["d_kept"])
    other = verdict(page | {"grid": turned}, FILES)
    assert text != other
    flipped = page["bins"].assign(d_kept=-page["bins"]["d_kept"])
    assert verdict(page | {"bins": flipped}, FILES) != text
    outlook = text[text.index("## Outlook") :]
    assert "has a Z of 0.48 where other dots of the same surface, all kept, have 0.45" in outlook
    assert (
        "For a Z of 0.70, what turning the molecule costs, 2.5 % of the dots suffice instead of 20 %"
        in outlook
    )


def test_links_keep_the_samplings_and_change_the_islands(page):
    links = page["links"].set_index(["D_link", "row"])
    assert np.allclose(links.loc[0.8]["n_S_percent"], links.loc[1.2]["n_S_percent"])
    assert (links.loc[1.2]["fragment"] >= links.loc[0.8]["fragment"]).all()


def test_one_draw_per_dot_keeps_fewer(page):
    percent = page["defects"].pivot(index="row", columns="sampling", values="n_S_percent")
    assert (percent["one draw per dot"] <= percent["as published"] + 1e-9).all()
