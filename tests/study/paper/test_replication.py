"""The comparison with the paper: agreement, bias and sentences from made-up numbers, and a run on a small surface."""

import json
import re
from functools import partial
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

from conftest import make_blob
from parsed_pages import Page
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.patches.descriptors import describe_patches
from sparsurf.patches.index import build_index
from sparsurf.patches.readings import words_of
from sparsurf.sampling import published
from sparsurf.sampling.combination import PARAMETERS, PUBLISHED_ROWS, TABLE_1, Combination
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.surface import Surface
from sparsurf.views.numbers import interval, number
from sparsurf_study.analysis import grid, islands, rough_and_flat, tables
from sparsurf_study.paper import published_runs, replication, verdict
from sparsurf_study.report.numbers import left_in_island
from sparsurf_study.report.page import render
from sparsurf_study.report.paper_page import (
    LIMIT_CASES,
    PAPER_TEMPLATE,
    curve,
    defects,
    describe_uniform,
    limit_case,
    paper_page,
    surface_of,
)

RECOVERED = pd.DataFrame(
    [
        {
            "n_S_percent": 13.4,
            "density": 0.72,
            "mean": 0.0199,
            "high_99": 0.094,
            "largest": 0.48,
            "Z_published": 0.31,
            "reconstruction": "interpolant",
        }
    ]
)


@pytest.fixture(scope="module")
def prepared(blob):
    """The bumpy surface."""
    surface = SimpleNamespace(points=blob[0], normals=blob[1])
    return PreparedSurface(surface, Settings(patches={"d_link": 0.8}), streams=Streams(1, "blob"))


def runs(shift=0.0, sd=0.1, n=40):
    """Winners of as-published runs around the published values, shifted; the published combinations win."""
    rng, out = np.random.default_rng(0), []
    table = pd.DataFrame(TABLE_1)
    for run in range(1, n + 1):
        one = table.assign(run=run, range=range(1, 11), n_combinations=5, n_S_percent=50.0)
        d, z = (one[name] + sd * rng.normal(size=10) for name in ("d", "Z_tS"))
        out.append(one.assign(d=d + shift, Z_tS=z))
    return pd.concat(out, ignore_index=True)


def test_runs_of_the_same_kind_agree_and_shifted_ones_do_not():
    own = published_runs.place_published_values(runs())
    assert own["d_inside"].all() and own["Z_tS_inside"].all()
    assert (own["n_won"] == 40).all() and own["d_n_below"].between(5, 35).all()
    assert published_runs.joint_test(own, "d")["p"] > 0.3
    far = published_runs.place_published_values(runs(shift=-0.3))
    assert (far["d_n_below"] >= 38).all() and (far["d_p"] < 0.1).all()
    assert far["d_inside"].tolist() == (far["d_p"] >= 0.05).astype(int).tolist() and not far["d_inside"].all()
    assert published_runs.joint_test(far, "d")["p"] < 1e-3
    assert published_runs.joint_test(far, "Z_tS")["p"] > 0.3


def test_one_test_of_all_rows_keeps_its_level(monkeypatch):
    monkeypatch.setattr(published_runs, "SIMULATED_SUMS", 4000)
    # published values drawn as one more run: p < 0.05 in 5 % of 300 cases (standard deviation 1.3 %)
    rng, p = np.random.default_rng(1), []
    for _ in range(300):
        x = rng.normal(size=(11, 6))
        places = pd.DataFrame({"range": range(1, 7), "n_runs": 10, "d_published": x[10]})
        places["d_mean"], places["d_sd"] = x[:10].mean(axis=0), x[:10].std(axis=0, ddof=1)
        p.append(published_runs.joint_test(places, "d")["p"])
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.04)


def test_places_among_three_runs_by_hand():
    """Table I's first row has d 0.95 and Z_tS 2.85."""
    own = runs(sd=0.0, n=3)
    own = own[own["range"] == 1].assign(d=[0.95, 0.9, 1.0], Z_tS=[2.9, 3.0, 3.1])
    own.loc[own["run"] == 3, "gamma"] += 1
    published = TABLE_1[0]
    own["d"] = published["d"] + np.array([0.0, -0.1, 0.1])
    own["Z_tS"] = published["Z_tS"] + np.array([0.1, 0.2, 0.3])
    place = published_runs.place_published_values(own).iloc[0]
    assert (place["n_runs"], place["n_won"]) == (3, 2)
    assert (place["d_n_below"], place["Z_tS_n_below"]) == (1, 0)
    assert place["d_p"] == 1.0  # 2 (1 + 1) / (3 + 1)
    assert place["Z_tS_p"] == 0.5  # 2 (0 + 1) / (3 + 1)
    assert place["Z_tS_mean"] - place["Z_tS_published"] == pytest.approx(0.2)
    assert place["Z_tS_sd"] == pytest.approx(0.1)


def test_a_row_that_few_runs_won_is_undecided_however_far_it_lies(page):
    """Row 2, published 1.98, with three runs of 2.21 to 2.60; with 40 such runs it lies outside."""
    for n, inside, said in (
        (3, [np.nan], "too few runs"),
        (39, [np.nan], "too few runs"),
        (40, [0.0], "no, yes"),
    ):
        own = runs(sd=0.0, n=n)
        own = own[own["range"] == 2]
        own = own.assign(d=np.linspace(2.21, 2.6, n), Z_tS=np.linspace(6, 7, n))
        place = published_runs.place_published_values(own)
        np.testing.assert_array_equal(place["d_inside"], inside)
        places = pd.concat([page["places"].assign(d_inside=1, Z_tS_inside=1, n_runs=200)[:9], place])
        found = paper_page(page | {"places": places})["table1"]
        assert found["rows"][9]["inside"] == said and found["rows"][0]["inside"] == "yes, yes"
        decided = 10 - (n < 40)
        assert found["inside"] == {"d": 9, "Z_tS": decided, "n": decided, "too_few": 10 - decided}
        assert found["outside"] == ([] if n < 40 else ["d of row 2"])


def test_one_row_alone_is_tested_by_students_t():
    # (2 - 0) / (0.5 sqrt(1 + 1/4)) = 3.578; t of 3 degrees lies beyond with p = 0.0373
    places = pd.DataFrame(
        {"range": [1, 2], "n_runs": [4, 4], "d_published": [2.0, 9.0], "d_mean": 0.0, "d_sd": 0.5}
    )
    far = published_runs.joint_test(places.assign(d_published=1e9), "d")
    assert far["p"] == 1 / (published_runs.SIMULATED_SUMS + 1)  # never 0
    found = published_runs.joint_test(places, "d", leave_out=[2])
    assert found["n_rows"] == 1
    assert found["statistic"] == pytest.approx(12.8)
    assert found["p"] == pytest.approx(0.0373, abs=0.002)


def test_the_number_of_centres_is_a_test_of_its_own():
    """Of 178, 180, 182 the mean is 180 and the standard deviation 2: 190 lies 10 / (2 sqrt(4 / 3)) = 4.33 away."""
    places, centres = published_runs.place_published_values(runs()), np.array([178, 180, 182])
    found = published_runs.tests_of_table_1(places, centres, 190).set_index("measure")
    assert found.loc["centres", "p"] == pytest.approx(0.04943, abs=1e-4)  # t of two degrees
    assert found.loc["centres", ["n_rows", "statistic"]].tolist() == pytest.approx([1, 18.75])
    assert found.loc["together", "p"] == pytest.approx(3 * 0.04943, abs=3e-4)
    same = published_runs.tests_of_table_1(places, centres, 180)
    assert (same["p"] > 0.2).all() and same["measure"].tolist() == ["d", "Z_tS", "centres", "together"]


def test_centres_depend_on_the_order_of_the_dots_and_on_the_patches(prepared):
    found = published_runs.centres_in_random_orders(prepared, 5)
    assert len(set(found)) > 1 and abs(found.mean() - len(prepared.cover.centre)) < 0.15 * found.mean()
    settings = Settings(patches={"r_patch": 3.0, "d_link": 0.8})
    smaller = PreparedSurface(prepared.surface, settings, streams=Streams(1, "blob"))
    assert published_runs.centres_in_random_orders(smaller, 2).min() > found.max()


def test_runs_as_published_have_one_draw_and_test_dots_of_their_own(prepared, monkeypatch):
    asked, told, run = [], [], grid.evaluate_grid

    def evaluate(*args, **keys):
        asked.append((args, keys, run(*args, **keys)))
        return asked[-1][2]

    monkeypatch.setattr(grid, "evaluate_grid", evaluate)
    found = published_runs.runs_as_published(prepared, PUBLISHED_ROWS[:1], 2, lambda *done: told.append(done))
    for args, keys, _ in asked:
        assert (args[2:], keys) == ((15, 1, ("kept",)), {"shared": False})  # 3000 dots / 200
    assert found["run"].unique().tolist() == [1, 2] and told == [(1, 2), (2, 2)]
    by_run = found.dropna(subset="d").groupby("run")[["d", "Z_tS"]].first()
    means = np.array([[z.mean(dtype=float) for z in (each.z_tr, each.z_ts)] for *_, each in asked])
    assert np.allclose(by_run, np.column_stack([means[:, 0] - means[:, 1], means[:, 1]]))
    assert by_run["d"].nunique() == 2


def test_the_largest_number_of_dots_belongs_to_no_range():
    percent = np.array([0.0, 5.0, 9.9, 10.0, 95.0, 100.0])
    d = np.array([1.0, 3, 2, 0, 4, 9])
    found = pd.DataFrame(published_runs.winners(np.arange(24.0).reshape(6, 4), percent, d, -d))
    assert found["d"].dropna().tolist() == [3, 0, 4]  # 9, of all dots, wins nothing
    assert found["n_combinations"].tolist() == [3, 1, *7 * [0], 1]


def test_bias_is_the_winner_minus_its_true_value():
    winners = pd.DataFrame(PUBLISHED_ROWS, columns=PARAMETERS).assign(d=2.0, Z_tS=3.0, range=range(1, 11))
    truth = pd.DataFrame(PUBLISHED_ROWS, columns=PARAMETERS).assign(d_kept=1.5, Z_tS_kept=3.25)
    truth = truth.assign(d_kept=1.5 - np.arange(10))[::-1]  # each its own, and in another order
    bias = published_runs.selection_bias(pd.concat([winners, winners.assign(d=3.0)]), truth)
    assert bias["range"].tolist() == [*range(1, 11)] and np.allclose(bias["d_bias"], 1 + np.arange(10))
    assert np.allclose(bias["Z_tS_bias"], -0.25)


def test_bins_of_roughness_by_hand():
    r = np.tile([0.0, 0.05, 0.95, 1.0], (2, 1))
    z = np.array([np.zeros((2, 4)), [[1.0, 3, 5, 7], [2.0, 4, 6, 8]]])
    found = rough_and_flat.ByRoughness(np.zeros((2, 4), int), r, {"kept": z})
    bins = rough_and_flat.bins_table(found, kept=True, bins=2).set_index("bin")
    assert bins["d_kept"].tolist() == [2.5, 6.5, 2.5, 6.5] and bins["n"].tolist() == [2, 2, 2, 2]
    # two draws whose means differ by 1: half width t(0.975, 1) * 0.5
    assert bins.loc["1", "d_high_kept"] == pytest.approx(2.5 + 12.7062 * 0.5, abs=1e-3)
    one_rough = rough_and_flat.ByRoughness(found.dots, np.array([r[0], [0.95, 0.95, 1, 1]]), found.z)
    without = rough_and_flat.bins_table(one_rough, kept=True, bins=2)  # a draw has no rough patch
    assert without["d_kept"].isna().tolist() == [True, False, True, False]
    crossed = rough_and_flat.bins_table(found, kept=False, bins=2).set_index("bin")
    assert crossed.loc["1", "d_high_kept"] == pytest.approx(estimate(z[1][:, :2]).high)


def test_halves_of_four_bins_have_their_limits_and_dots():
    r = np.tile([0.0, 0.1, 0.3, 0.6, 0.8, 0.9, 1.0], (2, 1))
    z = np.stack([np.zeros((2, 7)), np.tile([1.0, 3, 8, 5, 2, 4, 6], (2, 1))])
    found = rough_and_flat.ByRoughness(np.zeros((2, 7), int), r, {"kept": z})
    bins = rough_and_flat.bins_table(found, kept=True, bins=4)
    rows = bins[["bin", "roughness_low", "roughness_high", "n", "d_kept"]].to_numpy().tolist()
    assert rows == [
        ["1", 0.0, 0.25, 2.0, 2.0],
        ["2", 0.25, 0.5, 1.0, 8.0],
        ["3", 0.5, 0.75, 1.0, 5.0],
        ["4", 0.75, 1.0, 3.0, 4.0],
        ["rougher half", 0.0, 0.5, 3.0, 4.0],
        ["flatter half", 0.5, 1.0, 4.0, 4.25],
    ]


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


def test_patches_lie_around_kept_dots_or_any(prepared):
    combination = Combination(0.8, 0.0, 4.0, 0.0)
    kept = rough_and_flat.by_roughness(prepared, combination, ["kept"], 100, 2, True)
    for draw in range(2):
        assert np.isin(kept.dots[draw], prepared.pair(combination, draw)[0]).all()
    assert not np.array_equal(*kept.dots)
    fewest = min(100, *(len(prepared.pair(combination, draw)[0]) for draw in range(2)))
    assert kept.dots.shape == (2, fewest) and kept.z["kept"].shape == (2, 2, fewest)
    any_dots = rough_and_flat.by_roughness(prepared, combination, ["kept"], 100, 2, False)
    assert np.array_equal(*any_dots.dots) and any_dots.z["kept"].shape == (2, 2, 100)
    tests, pair = any_dots.dots[0], prepared.pair(combination, 1)
    z, _ = prepared.distances(pair, tests, prepared.describe(tests)[0], "kept")
    assert np.allclose(any_dots.z["kept"][:, 1], z)


@pytest.fixture(scope="module")
def page(prepared):
    """Data of a verdict on a small surface, everything but the published values computed."""
    result = grid.evaluate_grid(prepared, PUBLISHED_ROWS, 40, 2)
    table = tables.grid_table(result)
    runs = published_runs.runs_as_published(prepared, PUBLISHED_ROWS, 3)
    best = tables.best_combinations(table, result, 20, {"fresh dots": 0.6})
    ranges = islands.add_islands(tables.ranges_table(table, result), best, prepared, 40, 2)
    links = replication.sweep_links(prepared, (0.8, 1.2), 20, 2)
    combination, bins = Combination.from_row(best["kept"]["unrestricted"]), []
    for around, kept in rough_and_flat.AROUND.items():
        found = rough_and_flat.by_roughness(prepared, combination, ["kept", "full"], 600, 2, kept)
        bins.append(rough_and_flat.bins_table(found, kept).assign(around=around))
    return {
        "grid": table,
        "ranges": grid.add_scaled_link(ranges, prepared, 40, 2),
        "best": best,
        "rows": replication.published_rows(prepared, 20, 2),
        "places": published_runs.place_published_values(runs),
        "tests": published_runs.tests_of_table_1(
            published_runs.place_published_values(runs), np.array([30, 31, 33])
        ),
        "bias": published_runs.selection_bias(runs, table),
        "links": links,
        "defects": replication.compare_defects(prepared, 20, 1),
        "bins": pd.concat(bins),
        "family": replication.best_of_family(
            replication.tuned_family(prepared, PUBLISHED_ROWS[:, 1:], (10.0,), 20, 2)
        ),
        "recovered": RECOVERED,
        "turned": 0.7,
        "gathering": replication.gathering_by_roughness(prepared, 2),
        "uniform": {"median": 3.0},
        "surface": surface_of(prepared, {"reentrant": "exact"}, "a/blob.dms"),
    }


@pytest.fixture
def whole(monkeypatch):
    """Let the ten combinations of this small run be all that the paper chose among."""
    monkeypatch.setattr(verdict, "GRID", pd.MultiIndex.from_arrays(PUBLISHED_ROWS.T))


def html_of(page):
    return render(PAPER_TEMPLATE, **paper_page(page), first="p/c1", figure=None)


def test_a_reduced_grid_tests_no_claim_on_the_best_of_all(page):
    """Whatever the runs say, ten combinations are not the 1,296 among which the paper chose."""
    places = page["places"].assign(n_runs=200, d_inside=1, Z_tS_inside=1)
    found, text = paper_page(page | {"places": places}), Page(html_of(page | {"places": places})).text
    untested = {name for name, holds in found["claims"] if holds["kept"] == "not tested"}
    assert untested == {"table1", "winners", "best", "span", "uniform"}
    assert text.count("The grid has 10 of the paper's 1,296 combinations") >= 4
    assert "Is Table I reproduced?\nUndecided" in text and "significantly worse than the best" not in text


@pytest.mark.usefixtures("whole")
def test_every_claim_has_a_chapter_and_a_table(page):
    text = html_of(page)
    answers = "yes|no|as printed yes, in the code no|the complete set yes, up to order 20 no|not tested|"
    answers += r"too few runs|one of \d+|\d+ of 10"
    claims = re.findall(rf'href="#(\w+)">({answers})<', text)
    assert len(claims) == 32 and len({name for name, _ in claims}) == 16
    for name in {name for name, _ in claims} - {"univocal", "fewer", "gather"}:
        chapter = text.split(f'<h2 id="{name}">')[1].split("<h2")[0]
        assert ".csv" in chapter or ".json" in chapter, name
    assert "3,000" in text and not re.search(r"\b(nan|None|inf)\b", text)


def test_d_is_correlated_with_the_other_reading_and_with_the_sizes_of_patches(page):
    """By hand: d on the full surface is twice d among the kept dots; ln of the ratio of the sizes has another order."""
    d = np.array([1.0, 2.0, 4.0])
    sizes = {"median_patch_size_kept": [10.0, 80.0, 20.0], "median_patch_size_uniform_kept": 10.0}
    columns = {"d_kept": d, "d_full": 2 * d, "median_patch_size_full": 100.0} | sizes
    found = paper_page(page | {"grid": page["grid"][:3].assign(**columns)})["links"]
    assert found["correlation"] == pytest.approx(1)
    assert found["fragments"] == pytest.approx(np.corrcoef(d, [0, 3, 1])[0, 1])


@pytest.mark.usefixtures("whole")
def test_the_verdict_says_what_the_runs_and_the_readings_say(page):
    places = page["places"].assign(d_inside=[0, *9 * [1]], Z_tS_inside=1, n_runs=200)
    tests, rows = page["tests"], page["rows"]
    lost = rows.assign(d_high_kept_scaled=-0.3, d_high_full=-0.2)

    def said(p, rows, n_runs=200):
        own = {"places": places.assign(n_runs=n_runs), "tests": tests.assign(p=p), "rows": rows}
        return Page(html_of(page | own)).text

    words = "9 of 10 published values of d and 10 of 10 of Z lie in the central 95 % of {} runs made as published."
    for p, n_runs, answer in (
        (0.5, 200, "Yes"),
        (0.01, 200, "No"),
        (0.5, 39, "Undecided"),
        (0.01, 40, "No"),
    ):
        counted = (
            words.format(n_runs)
            if n_runs >= 40
            else "39 runs were made as published, and the comparison needs at"
        )
        assert f"Is Table I reproduced?\n{answer}\n{counted}" in said(p, lost, n_runs)
    ends = {"d_low_kept": [*7 * [0.1], *3 * [-0.2]], "d_high_kept": [*8 * [0.3], *2 * [-0.1]]}
    ends |= {"d_low_kept_scaled": [*2 * [0.1], *8 * [-0.5]], "d_low_full": [*4 * [0.1], *6 * [-0.5]]}
    ends |= {"share_in_island": [*6 * [0.4], *4 * [0.5]]}
    counted = said(0.5, lost.assign(**ends, d_high_full=[*9 * [-0.2], 0.1]))
    assert "in 7 of 10 rows among the kept dots, in 2 with a link that grows with the spacing" in counted
    assert "spacing of the kept dots, and in 4 on the full surface." in counted
    assert "It is significantly worse in 2, 10 and 9 rows. In 6 rows the subset is fragmented." in counted


def test_the_curve_is_d_over_link_and_spacing(page):
    """Here with a spacing of 2 Å, so that an axis of links in Å would give other numbers."""
    links = pd.DataFrame({"d_link": [1.0, 2.0, 4.0], "row": 1, "d": [2.0, 1.0, -1.0]})
    links = links.assign(link_over_spacing=links["d_link"] / 2)
    other = links.assign(
        row=2, d=[0.5, 3.0, -2.0], link_over_spacing=[0.25, 0.5, 1.0]
    )  # of dots farther apart
    found = curve(pd.concat([links, other[::-1], other.assign(row=3, d=1.0)]))
    assert found["top"] == (0.5, 3.0) and found["crossing"] == pytest.approx(
        (0.8, 1.5)
    )  # between the links; the third stays above 0
    assert [row for row, _ in found["lines"]] == [1, 2, 3]
    x, y = np.array([[float(v) for v in point.split(",")] for point in found["lines"][0][1].split()]).T
    places = (
        {value: place for place, value in found["ticks"]},
        {value: place for place, value in found["levels"]},
    )
    assert x[1:] == pytest.approx([places[0][1], places[0][2]]) and y == pytest.approx(
        [places[1][k] for k in (2, 1, -1)]
    )


@pytest.mark.usefixtures("whole")
def test_claims_follow_from_the_numbers(page):
    def holds(**changed):
        found = paper_page(page | changed)
        return {name: tuple(of.values()) for name, of in found["claims"]}

    grid, bins = page["grid"], page["bins"]
    ends = {"d_low_kept": 0.1, "d_high_kept": 0.3, "d_low_full": -0.3, "d_high_full": -0.1}
    rows = page["rows"].assign(**ends)
    assert holds(rows=rows)["positive"] == ("10 of 10", "0 of 10")
    some = rows.assign(d_low_kept=np.where(np.arange(10) < 3, -0.1, 0.1))
    assert holds(rows=some)["positive"] == ("7 of 10", "0 of 10")
    assert holds(rows=rows)["table1"][1] == "no"  # eight published d are above 0
    assert holds(rows=rows.assign(d_published=-0.1))["table1"][1] == "yes"
    above = rows.assign(d_published=-0.1, d_low_full=0.1, d_high_full=0.3)
    assert holds(rows=above)["table1"][1] == "no"
    null = page["best"]["references"]["Z_mean_descriptor"]
    z = rows.assign(Z_tS_kept=null + 1, Z_tS_full=null - 0.1, Z_tS_high_full=null - 0.05)
    z.loc[2, "Z_tS_high_full"] = null + 0.01
    assert holds(rows=z)["describe"] == ("0 of 10", "10 of 10")
    assert paper_page(page | {"rows": z})["describe"]["open"]["full"] == [3]
    assert paper_page(page | {"rows": some})["positive"]["open"] == [1, 2, 3]
    surface = page["surface"]
    for largest, p in ((1.0, "yes"), (1.2, "as printed yes, in the code no")):
        assert holds(surface=surface | {"largest_r": largest})["probability"] == (p, p)
    for turned, free in ((0.5, "yes"), (0.7, "no")):
        assert holds(turned=turned)["orientation"] == (free, free)
    assert holds(grid=grid.assign(n_S_percent=np.linspace(2.63, 99.73, len(grid))))["span"] == ("yes", "yes")
    assert holds(grid=grid.assign(n_S_percent=np.linspace(3.63, 99.73, len(grid))))["span"] == ("no", "no")
    rough, flat = bins["bin"] == "rougher half", ~(bins["bin"] == "rougher half")
    one = bins.assign(n=50.0, Z_tR_kept=1.0, Z_tR_full=1.0)
    for reading in ("kept", "full"):
        one.loc[rough, [f"d_low_{reading}", f"d_high_{reading}"]] = 0.5, 0.9
        one.loc[flat, [f"d_low_{reading}", f"d_high_{reading}"]] = -0.1, 0.2
    assert holds(bins=one)["rough"] == holds(bins=one)["flat"] == ("yes", "yes")
    lower = one.assign(d_low_kept=one["d_low_kept"] - 0.9, d_high_kept=one["d_high_kept"] - 0.9)
    assert holds(bins=lower)["rough"] == ("no", "yes")  # above the flatter half, but not above 0
    around = one["around"] == one["around"].iloc[0]
    split = one.assign(d_low_full=one["d_low_full"].mask(around & rough, -0.5))
    assert holds(bins=split)["rough"] == ("yes", "no")  # not around the dots of the first kind
    for low, equal in ((0.09, "yes"), (0.11, "no")):  # a tenth of Z of the random subset is nearly equal
        one.loc[flat, ["d_low_kept", "d_high_kept"]] = low, 0.2
        assert (holds(bins=one)["rough"], holds(bins=one)["flat"]) == (("yes", "yes"), (equal, "yes"))
    one.loc[bins["bin"] == "flatter half", ["d_low_kept", "d_high_kept"]] = -0.1, 0.7
    assert holds(bins=one)["rough"] == ("no", "yes")  # above 0, but not above the flatter half
    few = one["bin"] == one["bin"][~one["bin"].isin(["rougher half", "flatter half"])].iloc[-1]
    one.loc[few, ["n", "d_low_full", "d_high_full"]] = 9.0, 0.15, 0.2
    assert holds(bins=one)["flat"] == ("no", "yes")  # a bin of nine test dots says nothing


@pytest.mark.parametrize(("share", "answer"), [(42.0, "yes"), (41.0, "no"), (40.0, "no")])
def test_a_uniform_subset_keeps_more_dots_with_a_larger_alpha(share, answer):
    """In whatever order the grid has its combinations; those with other parameters do not count."""
    grid = pd.DataFrame({"alpha": [0.5, 0.1, 0.9], "beta": [0.0, 0, 1], "gamma": 0.0, "delta": 0.0})
    found = describe_uniform(grid.assign(n_S_percent=[share, 41.0, 30]), 7.0)
    assert found["holds"] == {"kept": answer, "full": answer} and len(found["rows"]) == 2


def test_the_tables_of_the_page_are_counted_and_averaged_by_hand(page):
    bias = pd.DataFrame({"d_bias": [0.1, 0.3, 0.8]})
    assert paper_page(page | {"bias": bias})["table1"]["bias"] == pytest.approx(0.4)
    ends = {f"{name}_{end}": x for name in ("d", "Z_tS") for end, x in (("lowest", -9.0), ("highest", 9.0))}
    places = page["places"].assign(**ends | {"d_lowest": [5.0, *9 * [-9.0]]}, n_won=[0, 0, *8 * [3]])
    found = paper_page(page | {"places": places})["table1"]
    assert (found["in_span"], found["won"]) == (19, 8)
    values = {"row": [1, 2], "n_S_percent": [10.0, 20], "d_kept": [1.0, 2], "d_full": [-1.0, 0]}
    corrected = {"row": [1, 2], "n_S_percent": [14.0, 22], "d_kept": [0.5, 2], "d_full": [-1.0, 1]}
    table = [
        pd.DataFrame(values).assign(sampling="as published"),
        pd.DataFrame(corrected).assign(sampling="x"),
    ]
    ends = {"d_low_kept": -0.5, "d_high_kept": 0.0, "d_low_full": 0.0, "d_high_full": 1.0}
    assert defects(pd.concat(table))["x"] == {"n_S_percent": 3.0, "d_kept": -0.25, "d_full": 0.5} | ends
    distances = np.linspace(0.5, 1.5, 11).round(1)
    links = pd.DataFrame({"d_link": np.tile(distances, 10), "row": np.arange(1, 11).repeat(11), "d": 1.0})
    links["d_high"] = np.where((links["d_link"] > 1.45) & (links["row"] > 7), -0.1, 0.1)
    shown = paper_page(page | {"links": links.assign(link_over_spacing=1.0)})["links"]
    assert shown["below"] == 3 and shown["tried"] == (0.5, 1.5)
    assert shown["distances"] == pytest.approx([0.5, 0.7, 0.9, 1.1, 1.3, 1.5])  # from the first to the last


@pytest.mark.usefixtures("whole")
def test_the_published_best_must_be_among_ours(page):
    def best(best_set, ours):
        results = json.loads(json.dumps(page["best"]))
        results["kept"]["unrestricted"] |= {"best_set": best_set} | dict(zip(PARAMETERS, ours, strict=True))
        found = paper_page(page | {"best": results})["best"]
        return found["holds"]["kept"], found["is_ours"]

    assert best("(1, 0, 6, 0); (1, 0, 2, 4)", (1, 0, 6, 0)) == ("one of 2", True)
    assert best("(1, 0, 6, 0); (1, 0, 2, 4)", (1, 0, 2, 4)) == ("one of 2", False)
    assert best("(1, 0, 6, 0)", (1, 0, 6, 0)) == ("yes", True)
    assert best("(1, 0, 2, 4)", (1, 0, 2, 4)) == ("no", False)


def test_limit_cases_are_the_best_of_their_parameters(page):
    """By hand: of six combinations, two do not depend on R, two not on the distance and one is steepest."""
    grid = pd.DataFrame(
        {
            "alpha": [1.0, 1, 1, 1, 1, 0.4],
            "beta": [0.0, 0, 0.4, 0, 1, 1],
            "gamma": [0.0, 0, 0, 6, 2, 2],
            "delta": [0.0, 4, 0, 0, 0, 0],
        }
    )
    for reading, d in (("kept", [0.1, 0.5, 0.3, 9, -1, 9]), ("full", [-0.1, -0.5, -0.3, 9, -1, 9])):
        grid = grid.assign(**{f"d{end}_{reading}": d for end in ("", "_low", "_high")})
    of_r, of_distance, steepest = (limit_case(grid, fixed) for fixed in LIMIT_CASES.values())
    assert (of_r["kept"]["delta"], of_r["full"]["delta"]) == (4, 0)
    assert (of_distance["kept"]["beta"], of_distance["full"]["beta"]) == (0.4, 0)
    assert steepest["kept"]["d_kept"] == steepest["full"]["d_full"] == -1
    assert limit_case(grid[3:4], {"gamma": 0, "delta": 0}) == {"kept": None, "full": None}


def test_kept_dots_are_counted_from_rough_to_flat(page, prepared):
    kept = pd.DataFrame({"combination": "(1, 0, 6, 0)", "tenth": range(1, 11), "uniform_percent": 45.0})
    sizes = {
        "kept": [9.0] * 9 + [30.0],
        "uniform_kept": 20.0,
        "full": [300.0] * 9 + [72.0],
        "uniform_full": 80.0,
    }
    kept = kept.assign(**{f"median_patch_size_{name}": of for name, of in sizes.items()})
    found = paper_page(
        page | {"gathering": kept.assign(kept_percent=[60.0, 70, 55, 50, 48, 45, 40, 35, 20, 30])}
    )["gather"]
    row = {"combination": "(1, 0, 6, 0)", "roughest": 60.0, "flattest": 30.0, "all": 45.0}
    assert found["holds"]["kept"] == "yes" and found["rows"] == [row]
    html = html_of(page | {"gathering": kept.assign(kept_percent=[60.0, 70, 55, 50, 48, 45, 40, 35, 20, 30])})
    shown = re.search(r"roughest tenth \(%\).*?<td>(.*?)</tr>", html, re.S)[1]
    assert re.findall(r"[^<>]+(?=</td>)", shown) == ["(1, 0, 6, 0)", "60.0", "30.0", "45.0"]
    assert ["(1, 0, 6, 0)", "30.0", "20.0", "72.0", "80.0"] in Page(html).rows  # of the flattest tenth alone
    assert paper_page(page | {"gathering": kept.assign(kept_percent=45.0)})["fewer"]["holds"] == {
        "kept": "no", "full": "yes",
    }  # fmt: skip
    even = paper_page(page | {"gathering": kept.assign(kept_percent=45.0)})["gather"]
    assert even["holds"]["full"] == "no"
    both = pd.concat([kept.assign(kept_percent=np.linspace(*ends, 10), combination=name)
                      for name, ends in (("a", (60.0, 30.0)), ("b", (30.0, 60.0)))])  # fmt: skip
    both.loc[both["combination"].eq("b"), "median_patch_size_full"] = 80.0
    found = paper_page(page | {"gathering": both})
    assert found["gather"]["holds"]["kept"] == found["fewer"]["holds"]["full"] == "no"  # one of the two does
    # the blob: every tenth is a tenth of its dots, and together they are what is kept
    own = page["gathering"]
    means = own.groupby("combination")[["kept_percent", "uniform_percent"]].mean()
    assert len(own) == 20 and np.allclose(means["kept_percent"], means["uniform_percent"])
    assert own.groupby("combination")["roughness"].apply(lambda of: of.is_monotonic_increasing).all()
    # dots of the flattest tenth within r_zernike, and those that are linked to the largest island
    flattest = np.argsort(prepared.roughness, kind="stable")[-300::2]
    row, pairs = own.iloc[9], [prepared.pair((1, 0, 6, 0), draw) for draw in range(2)]
    for which, key in enumerate(("", "uniform_")):
        counted, linked = [], []
        for subset in (pair[which] for pair in pairs):
            points = prepared.points[subset]
            for centre in prepared.points[flattest]:
                patch = points[np.linalg.norm(points - centre, axis=1) <= prepared.patches.r_zernike]
                near = np.linalg.norm(patch[:, None] - patch, axis=2) <= prepared.patches.d_link
                islands = np.bincount(connected_components(near)[1]) if len(patch) else [0]
                counted.append(len(patch))
                linked.append(max(islands))
        assert row[f"median_patch_size_{key}kept"] == np.median(linked)
        assert row[f"median_patch_size_{key}full"] <= np.median(
            counted
        )  # without dots on islands of all dots
        assert row[f"median_patch_size_{key}full"] >= np.median(linked)


def test_links_keep_the_samplings_and_change_the_islands(page, prepared):
    links = page["links"].set_index(["d_link", "row"])
    assert np.allclose(links.loc[0.8]["n_S_percent"], links.loc[1.2]["n_S_percent"])
    assert (links.loc[1.2]["median_patch_size"] >= links.loc[0.8]["median_patch_size"]).all()
    # at the surface's own d_link the sweep is the table of the published rows
    assert np.allclose(links.loc[0.8]["d"], page["rows"]["d_kept"], atol=1e-6)
    assert np.allclose(links.loc[0.8]["Z_tS"], page["rows"]["Z_tS_kept"], atol=1e-6)
    linked = prepared.with_link(1.2)
    tests, pairs = prepared.draw_tests(20), [prepared.pair(PUBLISHED_ROWS[3], draw) for draw in range(2)]
    z = [linked.distances(pair, tests, linked.describe(tests)[0], "kept")[0].mean(axis=1) for pair in pairs]
    assert links.loc[(1.2, 4), ["Z_tS", "Z_tR"]].tolist() == pytest.approx(np.mean(z, axis=0), abs=1e-6)
    for name in ("n_S_percent", "link_over_spacing", "share_in_island"):
        assert np.allclose(links.loc[0.8][name], page["rows"][name])
    assert links.loc[0.8]["median_patch_size"].tolist() == page["rows"]["median_patch_size_kept"].tolist()


def test_the_family_counts_each_side_and_has_its_lowest_z():
    table = pd.DataFrame(
        {"percent": [5.0, 5, 5, 10], "Z_tS": [2.0, 1.5, 3.0, 1.0], "Z_tR": [2.0, 2.4, 2.5, 9.0]}
    )
    table = table.assign(d=[0.1, 0.9, -0.5, 8.0], d_low=[-0.1, 0.2, -0.9, 7.0], d_high=[0.3, 1.5, -0.1, 9.0])
    table = table.assign(alpha=[0.1, 0.2, 0.3, 0.4], beta=0.5, gamma=6.0, delta=2.0)
    first = replication.best_of_family(table).iloc[0]
    names = ["percent", "members", "n_better", "n_worse", "largest_d", "Z_best", "Z_uniform", "alpha"]
    assert first[names].tolist() == pytest.approx([5, 3, 1, 1, 0.9, 1.5, 2.3, 0.2])


def test_a_turn_changes_the_descriptors_unless_it_is_none(prepared, monkeypatch):
    turn = Rotation.from_euler("xyz", [40, 100, 250], degrees=True).as_matrix()
    monkeypatch.setattr(replication, "random_rotation", lambda rng: np.eye(3))
    assert replication.turned_z(prepared, 20) == pytest.approx(0, abs=1e-9)
    monkeypatch.setattr(replication, "random_rotation", lambda rng: turn)
    tests = prepared.draw_tests(20)
    index = build_index(prepared.points @ turn.T, prepared.normals @ turn.T, 0.8)
    turned, _ = describe_patches(index, (prepared.points @ turn.T)[tests], 6.0, True)
    wanted = np.linalg.norm(turned - prepared.describe(tests)[0], axis=1).mean()
    assert replication.turned_z(prepared, 20) == pytest.approx(wanted, rel=0.05) and wanted > 0.01


def test_the_family_keeps_as_many_dots_as_are_asked_for(prepared):
    exponents = np.array([[0.0, 6, 0], [0.4, 0, 2], [0.0, 6, 0]])
    table = replication.tuned_family(prepared, exponents, (5.0, 20.0), 20, 3)
    assert table[["percent", "beta", "gamma", "delta"]].to_numpy().tolist() == [
        [percent, *row] for percent in (5.0, 20.0) for row in ([0, 6, 0], [0.4, 0, 2])
    ]
    assert np.abs(table["n_S_percent"] - table["percent"]).max() < 1 and table["alpha"].max() <= 1
    assert np.allclose(table["d"], table["Z_tR"] - table["Z_tS"], atol=1e-6)
    assert (table["d_low"] < table["d"]).all() and (table["d"] < table["d_high"]).all()
    assert len(replication.tuned_family(prepared, exponents, (99.9, 20.0), 20, 2)) < 4  # alpha would exceed 1


def test_each_defect_has_its_own_cover(page, prepared):
    percent = page["defects"].pivot(index="row", columns="sampling", values="n_S_percent")
    for name, moved, every in (
        ("distances from the dot itself", False, True),
        ("one draw per dot", True, False),
        ("both changed", False, False),
    ):
        cover = published.build_cover(
            prepared.index,
            prepared.roughness,
            prepared.patches.r_patch,
            distance_from_moved_centre=moved,
            chance_in_every_patch=every,
        )
        assert np.allclose(percent[name], 100 * published.expected_n_s(cover, PUBLISHED_ROWS) / 3000)


def test_the_tables_of_a_study_follow_its_settings(monkeypatch):
    """Each with the numbers of test dots and draws of the config; what the page says is made of these tables."""
    settings = Settings(
        patches={"d_link": 2.0},
        sampling={"alpha": [0.5, 1.0], "beta": [0.0, 0.4], "gamma": [0.0, 6.0], "delta": [1.0]},
        evaluation={"test_dots": 7, "draws": 2},
    )
    prepared = PreparedSurface(Surface(*make_blob(400)), settings, streams=Streams(1, "blob"))
    for name in ("runs_as_published", "centres_in_random_orders"):
        monkeypatch.setattr(published_runs, name, partial(getattr(published_runs, name), runs=2))
    monkeypatch.setattr(replication, "LINK_DISTANCES", (2.0, 2.5))
    told = []
    found = replication.reproduce(prepared, settings, lambda *done: told.append(done))
    grid_of_config = published.parameter_grid([0.5, 1.0], [0.0, 0.4], [0.0, 6.0], [1.0])
    wanted = {
        "runs": published_runs.runs_as_published(prepared, grid_of_config),
        "rows": replication.published_rows(prepared, 7, 2),
        "links": replication.sweep_links(prepared, (2.0, 2.5), 7, 2),
        "defects": replication.compare_defects(prepared, 7, 2),
        "family": replication.tuned_family(prepared, grid_of_config[:, 1:], n_tests=7, draws=2),
    }
    wanted["places"] = published_runs.place_published_values(wanted["runs"])
    centres = published_runs.centres_in_random_orders(prepared)
    wanted["tests"] = published_runs.tests_of_table_1(wanted["places"], centres)
    assert found.keys() == wanted.keys() and told == [(done, 52) for done in (1, 2, 43, 46, 49, 52)]
    for name, table in wanted.items():
        pd.testing.assert_frame_equal(found[name], table)
    table = tables.grid_table(grid.evaluate_grid(prepared, grid_of_config, 7, 2))
    facts = replication.facts_for_page(prepared, found, table, 7, 2)
    assert facts.pop("turned") == replication.turned_z(prepared, 7)
    assert facts.pop("uniform") == {"median": np.median(np.bincount(prepared.cover.dot))}
    wanted = {
        "bias": published_runs.selection_bias(found["runs"], table),
        "family": replication.best_of_family(found["family"]),
        "gathering": replication.gathering_by_roughness(prepared, 2),
    }
    assert facts.keys() == wanted.keys() and all(facts[name].equals(of) for name, of in wanted.items())


@pytest.mark.usefixtures("whole")
def test_the_numbers_of_the_chapters_are_those_of_their_tables(page, prepared):
    """Each by another way than on the page, from tables in which the alternatives differ."""
    names = [str(Combination(*row)) for row in PUBLISHED_ROWS]
    won = pd.DataFrame(PUBLISHED_ROWS, columns=PARAMETERS).assign(reading="kept", best_set="(1, 1, 1, 1)")
    won = won.assign(n_combinations=3, d_cv=1.5, d_cv_low=1.0, d_cv_high=2.0)
    won.loc[3:, "alpha"] = 0.05
    won.loc[[0, 1, 5], "best_set"] = [f"(1, 1, 1, 1); {names[k]}" for k in (0, 1, 5)]
    other = won.assign(reading="full", alpha=0.05, best_set=[f"(1, 1, 1, 1); {name}" for name in names])
    links = pd.DataFrame({"d_link": [0.9, 0.5, 0.7] * 10, "row": np.arange(1, 11).repeat(3)})
    links = links.assign(
        d=np.tile([0.1, 2.0, -0.4], 10) + 0.01 * links["row"], link_over_spacing=links["d_link"], d_high=1.0
    )
    links.loc[links["row"].eq(10) & links["d_link"].eq(0.9), "d"] = 2.5  # the best of the last row
    family = pd.DataFrame(
        {"percent": [5.0, 10], "members": [7, 5], "n_better": [3, 1], "Z_best": 1.0, "Z_uniform": 2.0}
    )
    rows = page["rows"].assign(d_published=[1.0, -1, *8 * [1.0]], d_low_kept=0.5, d_high_kept=1.5, d_kept=1.0)
    rows = rows.assign(Z_tS_published=3.0, Z_tS_low_kept=[*4 * [2.0], *6 * [3.5]], Z_tS_high_kept=4.0)
    places = page["places"].assign(n_runs=[*9 * [2], 3])
    changed = {
        "ranges": pd.concat([won, other]),
        "links": links,
        "family": family,
        "rows": rows,
    }
    found = paper_page(page | changed | {"places": places})
    winners = found["winners"]
    assert (winners["same"], winners["among"]) == ({"kept": 3, "full": 0}, {"kept": 3, "full": 10})
    assert winners["holds"] == {"kept": "3 of 10", "full": "10 of 10"}
    assert found["parameter_free"]["links"] == pytest.approx(np.array([[0.5, 2.05], [0.7, -0.35]]))
    assert found["links"]["best"] == (0.5, 0.9) and found["links"]["distances"] == [0.5, 0.7, 0.9]
    positive, table1 = found["positive"], found["table1"]
    assert (positive["members"], positive["better"], positive["published"]) == (12, 4, 9)
    assert table1["means"] == {"d": 9, "Z_tS": 4} and (table1["n"], table1["runs"]) == (10, 3)
    run = page["places"].set_index("range").loc[5]
    assert found["best"]["run"]["d_n_below"] == run["d_n_below"]
    grid = page["grid"]
    assert found["span"]["measured"] == (grid["n_S_percent"].min(), grid["n_S_percent"].max())
    cover = prepared.cover
    start = np.repeat(np.arange(len(cover.centre)), np.diff(cover.start))
    gap = np.linalg.norm(prepared.points[cover.dot] - prepared.points[cover.origin[start]], axis=1)
    assert surface_of(prepared, Settings().surface) == {
        "source": "exact", "n_dots": 3000, "n_centres": len(cover.centre),
        "mean_roughness": pytest.approx(prepared.roughness.mean()),
        "roughness": (prepared.roughness.min(), prepared.roughness.max()),
        "largest_r": pytest.approx(gap.max() / 4, rel=1e-6),
    }  # fmt: skip
    assert surface_of(prepared, Settings().surface, "a/blob.dms")["source"] == "file"
    figures = [(n, name, [key for key, _ in claims]) for n, name, claims in found["figures"]]
    assert figures[1] == (2, "number_of_dots", ["span", "uniform"]) and len(figures) == 5


MADE_UP = {  # of chapters of the page: all different
    "table1": {"inside": {"d": 3, "Z_tS": 4, "n": 9, "too_few": 1},
               "in_span": 12, "won": 6, "runs": 217, "undecided": "", "compared": 18, "same": True, "bias": 0.137,
               "means": {"d": 2, "Z_tS": 8}, "tests": [{"measure": "d", "p": 0.2134}, {"measure": "together", "p": 5e-5}]},
    "winners": {"same": {"kept": 5, "full": 9}, "among": {"kept": 7, "full": 8}},
    "best": {"run": {"n_runs": 217, "d_n_below": 31, "range": 5}},
    "positive": {"published": 8, "open": [8, 9], "n": 1296, "better": 55, "members": 77},
    "describe": {"null": 1.23},
    "span": {"measured": (2.31, 98.76)},
    "uniform": {"patches": 3.5, "rows": [{"alpha": 0.25, "n_S_percent": 61.23}
                                            | {"d_kept": 0.93, "d_low_kept": 0.63, "d_high_kept": 1.24}]},
    "range_of_roughness": {"measured": (0.123, 0.987)},
    "probability": {"largest_r": 1.19, "rows": [[1, -0.11, 0.22]]},
    "orientation": {"holds": {"kept": "no", "full": "no"}, "turned": 0.69, "fresh": 0.48, "two_patches": 1.87},
    "parameter_free": {"links": [[0.5, 2.42], [1.5, -0.37]]},
    "links": {"fragments": -0.91, "correlation": 0.62, "best": (0.52, 0.88), "tried": (0.4, 1.6), "below": 4, "rows": 9},
    "curve": {"top": (0.61, 2.9), "crossing": (1.31, 1.74)},
    "surface": {"n_dots": 12345, "n_centres": 167, "mean_roughness": 0.61234, "source": "dms"},
}  # fmt: skip
SENTENCES = [
    "3 of 9 published values of d and 4 of 9 of Z lie in the central 95 % of 217 runs made as published. 1 more row has too",
    "The whole grid was run 217 times as published",
    "Of the 18 values of a range with at least two runs, 12 lie between the lowest and the highest run.",
    "Of the 10 published combinations, 6 were the best",
    "too high by 0.14 on average. The intervals of the means contain 2 of the 10 published d.",
    "the best here in 5 of 9 ranges, and it is statistically indistinguishable from the best in 7.",
    "Of 217 runs made as published, 31 have a lower d in range 5 of Table I than the published 2.69.",
    "8 of the published d are above 0. Among the kept dots, the 95 % interval of d contains 0 in row 8, 9: with other dots,",
    "With α tuned to the same nS, 55 of 77 cases on the full surface lie significantly above 0.",
    "A subset whose Z exceeds 1.23",
    "Here it is 15 and 30 % of this Z among the kept dots, and −20 and −40 % of this Z on the full surface (around kept dots,",
    "runs from 2.31 % to 98.76 %. The answer is yes if both ends are less than 0.2 percentage points",
    "A dot lies in 3.5 patches (median)",
    "Here R runs from 0.12 to 0.99.",
    "r reaches 1.19 rpatch",
    "Their Z is 0.69, larger than that of other dots of the same surface, 0.48; two different patches have 1.87.",
    "d of (1, 0, 6, 0) is 2.42 at dlink = 0.5 Å, −0.37 at dlink = 1.5 Å.",
    "121 of 231 real numbers remain",
    "the ratio of the median sizes of patches, sampled to random, is −0.91.",
    "d on the full surface is 0.62 over the grid.",
    "Of the links from 0.4 to 1.6 Å, d of a row is highest at 0.5 to 0.9 Å. With the longest link, 4 of 9 rows",
    "falls below it, at 1.31 to 1.74 spacings.",
    "has 13.4 % of the dots, 0.72 per Å².",
    "deviates by 0.020 Å on average (99 %: 0.09 Å, largest: 0.48 Å). Its Z is 0.31. These dots are spread evenly,",
    "placed by sparsurf as DMS places them",
]  # fmt: skip


@pytest.mark.usefixtures("whole")
def test_each_sentence_has_its_own_numbers(page):
    """Made-up numbers, all different, stand in the sentence and the row that they belong to."""
    values = paper_page(page)
    values |= {name: values[name] | made for name, made in MADE_UP.items()}
    values["winners"]["rows"] = values["winners"]["rows"][:9]
    for k, bins in enumerate(values["rough"]["table"].values(), 1):
        bins[2] = {**bins[2], "d_kept": 0.3 * k, "Z_tR_kept": 2.0, "d_full": -0.1 * k, "Z_tR_full": 0.5}
    html = render(PAPER_TEMPLATE, **values, first="p/c1", figure="data:image/png;base64,")
    shown, text = Page(html), " ".join(Page(html).text.split())
    assert not [each for each in SENTENCES if each not in text]
    assert "The highest d is 2.90, at 0.61 spacings. d falls below 0 at 1.31 to 1.74 spacings." in html
    rows = [["dots", "12,345", "20,045"], ["centres of patches", "167", "181"], ["d", "0.21"]]
    rows += [["mean roughness", "0.6123", "0.6263"], ["together", "below 0.0001"], ["1", "−0.11", "0.22"]]
    rows += [["0.25", "25", "61.2", "0.93 (0.63 to 1.24)"]]
    assert not [row for row in rows if row not in shown.rows]


@pytest.mark.usefixtures("whole")
@pytest.mark.parametrize(
    ("is_ours", "kept", "full", "card", "words"),
    [
        (True, "yes", "no", "Yes", ["(1, 0, 6, 0) also has the highest d", "On the full surface, it is significantly worse"]),
        (False, "one of 36", "one of 8", "One of 36", ["one of 36 combinations that are statistically indistinguishable from the "
         "best, (0.8, 0.2, 4, 10).", "the kept dots, (1, 0, 6, 0) is one of 36 c", "On the full surface, it is statistically"]),
        (False, "no", "no", "No", ["(0.8, 0.2, 4, 10) has a significantly higher d.", "Among the kept dots, (1, 0, 6, 0) is s"]),
    ],
)  # fmt: skip
def test_the_place_of_the_published_best_is_said_of_both_readings(page, is_ours, kept, full, card, words):
    values = paper_page(page)
    best = values["best"]["ours"]["kept"] | dict(zip(PARAMETERS, (0.8, 0.2, 4.0, 10.0), strict=True))
    own = {"kept": best | {"n_best_set": 36.0}, "full": values["best"]["ours"]["full"]}
    holds = {"kept": kept, "full": full}
    among = {reading: answer != "no" for reading, answer in holds.items()}
    values["best"] |= {"is_ours": is_ours, "holds": holds, "among": among, "ours": own}
    text = " ".join(Page(render(PAPER_TEMPLATE, **values, first="p/c1", figure=None)).text.split())
    assert f"best combination at α = 1? {card} " in text
    assert not [each for each in words if each not in text]


def test_every_row_of_the_page_is_that_of_its_table(page):
    """Each table of the page, by the columns of the tables that it is made of, and the answers to each claim."""
    found, html = paper_page(page), Page(html_of(page))
    shown, (grid, rows, readings) = html.rows, (page["grid"], page["rows"], ("kept", "full"))
    claims = {name: [*holds.values()] for name, holds in found["claims"]}
    links = [(link.attributes["href"], link.text) for link in html.find("a", inside="text")]
    assert {name: [text for href, text in links if href == f"#{name}"] for name in claims} == claims
    assert any(kept != full for kept, full in claims.values())
    titles = {
        row[0]: row[1:] for table in html.tables if table[0][0].startswith("the claim") for row in table[1:]
    }
    of_figures = [
        row for table in html.tables if table[0][0].startswith("claims on which Fig.") for row in table[1:]
    ]
    assert of_figures and all(titles[title] == answers for title, *answers in of_figures)
    assert [answer.text.rstrip(",") for answer in html.find("span", inside="big")] == claims["positive"]
    words = {reading: words_of(reading) for reading in readings}
    null = page["best"]["references"]["Z_mean_descriptor"]

    def measured(row, reading):
        return interval(*(row[f"d{end}_{reading}"] for end in ("", "_low", "_high"))) or "–"

    def of_runs(row, name):
        return interval(*(row[f"{name}_{end}"] for end in ("mean", "lowest", "highest"))) or "–"

    wanted = []
    by_combination = grid.set_index(PARAMETERS)
    for reading in readings:
        of_all = page["best"][reading]["unrestricted"]
        d = interval(*(of_all[f"d_cv{end}"] for end in ("", "_low", "_high")))
        of_published = by_combination.loc[(1, 0, 6, 0)]
        wanted.append([words[reading], str(Combination.from_row(of_all)), d, f"{of_all['n_best_set']:.0f}"])
        wanted[-1].append(measured(of_published, reading))
    for name, fixed in LIMIT_CASES.items():
        cells = []
        for reading in readings:
            of_case = grid[(grid[[*fixed]] == [*fixed.values()]).all(axis=1)]
            top = of_case.nlargest(1, f"d_{reading}").to_dict("records")
            cells += [
                cell for row in top for cell in (str(Combination.from_row(row)), measured(row, reading))
            ]
        wanted.append([name, *(cells or 4 * ["–"])])
    assert sum(row[1] != "–" for row in wanted) > 2
    best = [page["ranges"][page["ranges"]["reading"] == reading].to_dict("records") for reading in readings]
    for k, (row, run) in enumerate(
        zip(rows.to_dict("records"), page["places"].to_dict("records"), strict=True), 1
    ):
        d, z = (number(row[f"{name}_published"]) for name in ("d", "Z_tS"))
        won, own = (
            f"{run['n_won']} of {run['n_runs']}" if run["n_runs"] else "–",
            str(Combination.from_row(row)),
        )
        d_of_readings = [measured(row, reading) for reading in ("kept", "kept_scaled", "full")]
        of_islands = [number(row["link_over_spacing"]), left_in_island(row)]
        wanted.append([str(k), d, d_of_readings[0], *of_islands, *d_of_readings[1:]])
        inside = "too few runs"  # of this short run
        wanted.append([str(k), own, d, of_runs(run, "d"), z, of_runs(run, "Z_tS"), inside, won])
        kept, full = (table[k - 1] for table in best)
        if kept["n_combinations"] and full["n_combinations"]:
            d = interval(*(kept[f"d_cv{end}"] for end in ("", "_low", "_high")))
            ours = [
                str(Combination.from_row(kept)),
                d,
                measured(kept, "kept_scaled"),
                str(Combination.from_row(full)),
            ]
            wanted.append([str(k), own, *ours])
    halves = page["bins"].set_index(["around", "bin"])
    for reading in readings:
        d, low, high = (grid[f"{key}_{reading}"] for key in ("d", "d_low", "d_high"))
        counts = map(str, ((d > 0).sum(), (low > 0).sum(), (high < 0).sum()))
        wanted.append([words[reading], *counts, number(d.mean()), number(d.max())])
        above = [table[f"Z_tS_{reading}"] > null for table in (grid, rows)]
        ends = (rows[f"Z_tS_{end}_{reading}"] for end in ("low", "high"))
        of_open = [str(k) for k, (low, high) in enumerate(zip(*ends, strict=True), 1) if low <= null <= high]
        counts = (f"{of.sum()} of {len(of)}" for of in above)
        wanted.append([words[reading], *counts, ", ".join(of_open) or "–"])
        for around, own in page["bins"].query("n >= 10").groupby("around"):
            flattest = own[~own["bin"].str.endswith("half")]["bin"].iloc[-1]
            of_bins = [halves.loc[around, name] for name in ("rougher half", "flatter half", flattest)]
            wanted.append([around, words[reading], *(measured(row, reading) for row in of_bins)])
    wanted += [
        [f"{of.percent:g}", number(of.Z_best), number(of.Z_uniform)] for of in page["family"].itertuples()
    ]
    links = page["links"].pivot(index="row", columns="d_link", values="d")
    wanted += [
        [str(k), *map(number, values)] for k, values in zip(links.index, links.to_numpy(), strict=True)
    ]
    defects = page["defects"].set_index(["sampling", "row"])
    for name in {*defects.index.levels[0]} - {"as published"}:
        change = defects.loc[name] - defects.loc["as published"]
        d = (change[f"d_{of}"] for of in readings)
        ranges = [interval(of.mean(), of.min(), of.max()) for of in d]
        wanted.append([name, number(change["n_S_percent"].mean(), 1), *ranges])
    assert not [row for row in wanted if row not in shown]
