"""Values of pages worked out by hand, on tables in which another row, column or mean gives another answer."""

import math

import numpy as np
import pandas as pd
import pytest

from sparsurf.report import first_page, ranges_page, summary_page
from sparsurf.report.page import render

READINGS = ["kept", "full"]
NAN = math.nan


@pytest.mark.parametrize(
    ("percents", "bounds", "bound", "every_dot"),
    [
        ([4.0, 100.0, 6.0], ["at most", "more", "at most"], "", False),
        ([4.0, 5.0, 9.0], ["at most"] * 3, "at most", False),
        ([100.0] * 3, ["more"] * 3, "more", True),
    ],
)
def test_the_card_of_the_dots_that_are_enough(percents, bounds, bound, every_dot):
    rows = pd.DataFrame(
        {"floor": "fresh dots", "reading": "recovered", "sampler": "farthest", "n_S_percent": percents}
        | {"n_S_percent_low": [3.0, NAN, 5.0], "n_S_percent_high": [6.0, NAN, 8.0], "bound": bounds}
    )
    others = (
        rows.assign(reading="full", n_S_percent=77.0),
        rows.assign(floor="turned", n_S_percent=88.0),
    )
    surfaces = pd.DataFrame({"minimal_n_S_percent": [1.0, 2.0, 9.0]})
    card = first_page.required_dots_card(surfaces, pd.concat([*others, rows]), "fresh dots")
    assert (card["bound"], card["every_dot"], card["interval"]) == (bound, every_dot, "3 to 8")
    assert card["percent"] == first_page.share(np.median(percents)) and card["handed_out"] == ""
    assert first_page.required_dots_card(surfaces, rows, None)["handed_out"] == "2"
    assert first_page.required_dots_card(surfaces, rows, "atoms moved 0.1 Å") is None


def summary_of(d, ranges=2):
    """Rows of summary.csv: `d` of each surface in the first range under both readings, and less in the next."""
    return pd.DataFrame(
        [
            {"protein": f"p{s}", "conformation": "c1", "reading": reading, "range": k + 1}
            | {"d_cv": value - k - r, "d_cv_low": value - k - r - 0.5, "d_cv_high": value - k - r + 0.5}
            | {"n_S_low_percent": 10.0 * k, "n_S_high_percent": 10.0 * k + 10, "n_S_percent": 5 + 10 * k + s}
            for s, value in enumerate(d)
            for r, reading in enumerate(READINGS)
            for k in range(ranges)
        ]
    )


def test_d_is_the_median_over_the_surfaces_in_the_range_that_is_best_kept():
    summary = summary_of([1.0, 2.0, 9.0])
    card = first_page.d_card(summary, "kept", "kept")
    assert (card["d"], card["n_S"], card["n"], card["worth"]) == ("2.00", "6", 3, None)
    written = first_page.d_card(summary, "full", "kept")
    assert (written["d"], written["places"]) == ("1.00", {"above": 2, "below": 0, "around": 1, "unknown": 0})


def test_over_all_surfaces_d_has_its_lowest_and_highest():
    combination = dict(zip(("alpha", "beta", "gamma", "delta"), (1.0, 0.5, 6.0, 0.0), strict=True))
    relation = pd.DataFrame(
        [
            {"reading": reading, "range": k, "n_S_low_percent": 10 * k - 10, "n_S_high_percent": 10 * k}
            | combination
            for k in (1, 2)
            for reading in READINGS
        ]
    )
    rows = first_page.over_all(summary_of([1.0, 2.0, 9.0, 3.0]), relation, READINGS)
    best = "(1, 0.5, 6, 0)"
    assert rows[0] == ["0 – 10", best, "2.50 (1.00 to 9.00)", best, "1.50 (0.00 to 8.00)"]
    assert rows[1][2] == "1.50 (0.00 to 8.00)"


def test_a_z_is_explained_by_the_first_floor_that_any_surface_has():
    surfaces = pd.DataFrame({"Z_frames_1_ps_apart": [NAN, 1.15, 1.35], "Z_atoms_moved_0.3_Å": 0.6})
    assert first_page.scale_of_z(surfaces) == {"words": "Two frames of the simulation 1 ps apart", "Z": "1.2"}
    assert first_page.scale_of_z(surfaces.assign(Z_frames_1_ps_apart=NAN))["Z"] == "0.6"
    assert first_page.scale_of_z(pd.DataFrame({"N": [1]})) is None


def test_a_row_of_the_relation_says_who_won_and_what_roughness_gains():
    row = {"n_S_low_percent": 0.0, "n_S_high_percent": 12.4, "d": 1.25, "d_sd": 0.5, "p": 0.034}
    row |= dict(zip(("alpha", "beta", "gamma", "delta"), (1.0, 0.0, 6.0, 0.0), strict=True))
    row |= {"n_winners": 3, "n_shared": 5, "n_surfaces": 7}
    row |= {"gain": 0.1, "gain_low": 0.05, "gain_high": 0.2}
    row |= {"over_all": 0.9, "over_all_low": 0.8, "over_all_high": 1.0}
    cells = ["0 – 12", "(1, 0, 6, 0)", "1.25 ± 0.50", "3 of 7", "5 of 7", "0.034", "0.10 (0.05 to 0.20)"]
    assert summary_page.relation_rows(pd.DataFrame([row | {"reading": "kept"}])) == [cells]
    relation = pd.DataFrame([row, row | {"p": NAN}]).assign(reading="kept", range=[1, 2])
    surfaces = pd.DataFrame({"protein": ["p"], "conformation": "c1", "N": 9000, "mean_roughness": 0.61234})
    surfaces = surfaces.assign(best_kept="1, 0, 6, 0", d_cv_kept=1.0)
    surfaces = surfaces.assign(d_cv_low_kept=0.5, d_cv_high_kept=1.5)
    page = summary_page.summary_page("run", surfaces, relation)
    assert [len(line) for line in page["relations"]["kept"]] == [7, 7]
    assert (page["related"], page["rows_tested"]) == (1, 1)
    assert page["surfaces"] == [["p", "9,000", "0.612", "1, 0, 6, 0", "1.00 (0.50 to 1.50)"]]
    untested = summary_page.summary_page("run", surfaces, relation.assign(p=NAN))
    assert [len(line) for line in untested["relations"]["kept"]] == [5, 5] and untested["related"] == 0


def test_a_row_of_ranges_has_the_numbers_of_its_columns():
    row = {"n_S_low_percent": 2.63, "n_S_high_percent": 12.34, "n_S_percent": 11.11, "Z_tS": 1.456}
    row |= dict(zip(("alpha", "beta", "gamma", "delta"), (1.0, 0.0, 6.0, 0.0), strict=True))
    row |= {"d_cv": 0.5, "d_cv_low": 0.25, "d_cv_high": 0.75, "median_patch_size": 61.0}
    row |= {"d_kept_scaled": -0.5, "d_low_kept_scaled": -0.75, "d_high_kept_scaled": -0.25}
    d = ["0.50 (0.25 to 0.75)", "−0.50 (−0.75 to −0.25)"]
    cells = ["2.6 – 12.3", "(1, 0, 6, 0)", "11.1", *d, "1.46", "61"]
    assert ranges_page.rows_of(pd.DataFrame([row])) == [cells]


@pytest.mark.parametrize(
    ("draws", "words"), [(1, "a single draw"), (2, "half of the draws"), (3, "two thirds of")]
)
def test_how_winners_were_chosen_follows_the_number_of_draws(draws, words):
    text = render("cross_validated.j2", draws=draws)
    said = [part for part in ("a single draw", "half of the draws", "two thirds of") if part in text]
    assert said == [words]


def test_the_limits_of_d_are_the_widest_and_empty_if_unknown():
    rows = pd.DataFrame({"d_cv_low": [-0.1, -0.304, 0.2], "d_cv_high": [0.4, 0.2, 1.256]})
    assert first_page.limits(rows) == "−0.30 to 1.26"
    assert first_page.limits(rows * NAN) == ""
