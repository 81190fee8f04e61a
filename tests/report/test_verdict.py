"""Sentences on the paper's claims, from tables small enough to say by hand what each must read."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT
from sparsurf.report import pages, table_1, verdict
from sparsurf.report.rough_and_flat import claims
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.sampling.published import PUBLISHED_ROWS
from sparsurf.study.statistics import FOLDS


def winner(n, low, d, high, **others):
    """A row of ranges.csv: (1, 0, n, 0) keeps 10 n % of the dots."""
    row = dict(zip(PARAMETERS, (1.0, 0.0, float(n), 0.0), strict=True)) | {"islands": "kept"}
    row |= {
        "n_S": 100.0 * n,
        "n_S_percent": 10.0 * n,
        "n_S_low_percent": 9.0 * n,
        "n_S_high_percent": 11.0 * n,
    }
    row |= {"d_held_out_low": low, "d_held_out": d, "d_held_out_high": high, "d": d + 0.5, "Z_tS": 1.25}
    return row | {"n_combinations": 7, "fragment": 12.0, "n_best_set": 3.0} | others


STICKS = {"empty_patch": 4.0, "null_model": 2.5, "two_patches": 3.5}


def test_a_table_in_markdown():
    table = pd.DataFrame({"name": ["a", "b"], "n": [1, 20], "x": [0.125, np.nan]})
    assert (
        pages.markdown(table, 3)
        == "| name | n | x |\n| --- | --- | --- |\n| a | 1 | 0.125 |\n| b | 20 |  |\n"
    )


def test_the_page_of_the_ranges_counts_what_is_certain():
    rows = [winner(1, 0.1, 0.3, 0.5), winner(2, 0.0, 0.6, 1.2), winner(3, -0.4, -0.2, 0.0)]
    rows += [winner(4, -0.9, -0.6, -0.3), winner(5, -0.5, -0.3, -0.1)]
    page = pages.ranges_markdown(pd.DataFrame(rows), STICKS | {"floors": {"fresh dots": 0.45, "turned": 0.7}})
    assert (
        "`kept`: of 5 ranges the best combination beats a uniform draw of as many dots for certain in 1 and loses to it "
        "for certain in 2; d is largest, 0.60 (0.00 .. 1.20), with (1, 0, 2, 0) at 20.0 % of the dots."
        in page
    )
    line = "| 9.00 - 11.00 | 7 | (1, 0, 1, 0) | 10.00 | 0.30 | 0.10 .. 0.50 | 0.80 | 1.25 | 12.00 | 3 |"
    assert line in page
    assert "an empty patch costs 4.00 (mean |z_tot|), every patch given the mean descriptor 2.50" in page
    assert "two different patches differ by 3.50" in page
    assert "Z of fresh dots 0.45; turned 0.70: below" in page
    unknown = pages.ranges_markdown(pd.DataFrame([winner(1, np.nan, np.nan, np.nan)]), STICKS)
    assert "too few test dots and draws to tell" in unknown


def test_what_is_held_out_is_told_by_the_number_of_draws():
    assert FOLDS == (3, 5)
    dealt = "two thirds of the draws and four fifths of the test dots and measured on the rest"
    one = "on the one draw that also chose: held out over test dots only, too high (on the embedded trajectory by 0.2 "
    assert dealt in pages.held_out() == pages.held_out(6) and one not in pages.held_out()
    assert "chosen on half of the draws and four fifths of" in pages.held_out(2)
    assert one in pages.held_out(1) and "of the draws" not in pages.held_out(1)
    rows = {"unrestricted": winner(6, 2.0, 2.5, 3.0), "under_max_n_S": winner(1, 0.1, 0.3, 0.5)}
    for draws in (1, 2, 6):
        best = {"kept": rows, "draws": draws, "max_n_S_percent": 20, "yardsticks": STICKS}
        ranges = pd.DataFrame([winner(1, 0.1, 0.3, 0.5)])
        for page in (pages.best_markdown(best), pages.ranges_markdown(ranges, STICKS, draws)):
            assert f"d held out: {pages.held_out(draws)}" in page
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert f"*held out*: {pages.held_out(6)}." in readme


def test_the_page_of_the_best():
    rows = {"unrestricted": winner(6, 2.0, 2.5, 3.0), "under_max_n_S": winner(1, 0.1, 0.3, 0.5, n_best_set=1)}
    page = pages.best_markdown({"kept": rows, "max_n_S_percent": 20, "yardsticks": STICKS})
    assert (
        "- Unrestricted, largest alpha: (alpha, beta, gamma, delta) = (1, 0, 6, 0), n_S = 600 (60.00 %), d held out = "
        "2.50 (2.00 .. 3.00; as selected 3.00), Z_tS = 1.25; the 95 % confidence set of the best holds 3 combinations"
        in page
    )
    assert "- n_S at most 20 %: (alpha, beta, gamma, delta) = (1, 0, 1, 0)" in page
    assert "Z_tS = 1.25; it is the best with 95 % confidence." in page
    alone = rows | {"under_max_n_S": winner(1, 0.1, 0.3, 0.5, n_best_set=1, n_combinations=1)}
    page = pages.best_markdown({"kept": alone, "max_n_S_percent": 20, "yardsticks": STICKS})
    assert "Z_tS = 1.25; no other combination was there to compare with." in page


def places(p_of_d):
    """Two ranges of each binning: published d and Z_tS, and runs whose means lie 0 or many sd off."""
    rows = []
    for binning, off in (("closed", p_of_d), ("half-open", 0.0)):
        for k in (9, 10):
            row = {"binning": binning, "range": k, "n_runs": 40, "n_won": k if binning == "closed" else 2 * k}
            row |= dict(zip(PARAMETERS, PUBLISHED_ROWS[k - 1], strict=True))
            row |= {"d_published": 1.0 + off * (k == 10), "d_mean": 1.0, "d_sd": 0.1, "d_lowest": 0.8}
            row |= {"d_highest": 1.2, "Z_tS_published": 3.0, "Z_tS_mean": 3.0, "Z_tS_sd": 0.2}
            row |= {"Z_tS_lowest": 2.5, "Z_tS_highest": 3.5, "d_n_below": 20, "Z_tS_n_below": 21}
            rows.append(row)
    return pd.DataFrame(rows)


def emptied(table, binning, n_runs=0):
    """The same where the last range of a binning has a winner in no run or one: then nothing is known of the runs."""
    last = (table["binning"] == binning) & (table["range"] == 10)
    of_runs = [name for name in table.columns if name.startswith(("d_", "Z_tS_"))]
    table = table.astype({name: float for name in of_runs})
    table.loc[last, of_runs], table.loc[last, ["n_runs", "n_won"]] = float("nan"), [n_runs, 0]
    return table


def test_published_values_beside_the_runs():
    bias = pd.DataFrame({"binning": ["closed", "closed", "half-open"], "d_bias": [0.1, 0.5, 9.0]})
    said = table_1.against_runs(places(0.9), bias)
    # 9 sd off: 81 / (1 + 1 / 40)
    assert said[0].startswith(
        "The largest n_S in the last range, d: the 2 published values together do not agree with the winners of 40 runs "
        "made as published (sum of squares 79.0 for 2 rows, p < 0.0001); outside of all runs: row 10 (1.90; runs 0.80 .. "
        "1.20); without it 0.0 for 1 rows, p = 1"
    )
    assert "Z_tS: the 2 published values together agree with" in said[1]
    assert said[1].endswith("p = 1); each lies within the range of the runs.")
    assert said[2].startswith(
        "Half-open ranges (the largest n_S in none), d: the 2 published values together agree"
    )
    assert "wins in 10 of 40 runs where the range holds the largest n_S (winners' mean d 1.00)" in said[4]
    assert "and in 20 of 40 where it does not" in said[4]
    assert "lies 0.30 on average and 0.50 at most above" in said[5]
    empty = emptied(places(0.9), "half-open")
    assert table_1.against_runs(empty, bias)[4].endswith(
        "(winners' mean d 1.00), and where it does not, no combination of the grid lies in it."
    )
    alone = emptied(places(0.9), "half-open", n_runs=1)
    assert table_1.against_runs(alone, bias)[4].endswith("and in 0 of 1 where it does not.")
    below = table_1.against_runs(places(-0.9), bias)
    assert "outside of all runs: row 10 (0.10;" in below[0]
    assert table_1.against_runs(places(-0.1), bias)[0].endswith("; each lies within the range of the runs.")
    assert table_1.all_agree(places(0.9)) == {
        True: ["d (half-open ranges)", "Z_tS (closed ranges)", "Z_tS (half-open ranges)"],
        False: ["d (closed ranges)"],
    }
    # 2.1 sd off: not unlikely among two rows (p = 0.12), unlikely if the limit were 0.2
    assert table_1.all_agree(places(0.21))[False] == []
    assert [table_1.p_text(p) for p in (0.00009, 0.0123, 0.5)] == ["p < 0.0001", "p = 0.012", "p = 0.5"]


def test_winners_beside_the_published_combinations():
    rows = [dict(zip(PARAMETERS, row, strict=True)) for row in PUBLISHED_ROWS[:3]]
    ranges = pd.DataFrame(rows).assign(islands="kept", best_set=table_1.texts_of(pd.DataFrame(rows)))
    ranges.loc[1, "gamma"] = 99.0  # wins there, the published one is in the set only
    ranges.loc[2, ["gamma", "best_set"]] = 99.0, "(9, 9, 9, 9)"
    both = pd.concat([ranges, ranges.assign(islands="surface", best_set="")])
    first, second = table_1.winners(both, places(0.0))
    assert "is the published one in 1 of 3 ranges" in first and "confidence set of the best in 2." in first
    assert "Of 40 runs made as published, each row's combination wins its range in 18 to 20." in second


def test_a_subset_at_the_null_model_is_not_worse():
    grid = pd.DataFrame({"Z_tS_kept": [2.4, 2.5, 2.6, 2.7], "Z_tS_surface": 1.0})
    grid.attrs["null_model"] = 2.5
    rows = pd.DataFrame({"Z_tS_kept": [2.6, 2.0], "Z_tS_surface": [2.0, 2.0]})
    kept, surface = table_1.null_model(grid, rows)
    assert "in 2 of 4 combinations and in 1 of the 2 published rows" in kept
    assert "in 0 of 4 combinations and in 0 of the 2 published rows" in surface


def test_the_table_row_by_row():
    rows = pd.DataFrame(PUBLISHED_ROWS[:1], columns=PARAMETERS).assign(n_S_percent=12.5)
    for name, d in (("kept", 1.0), ("surface", -1.0)):
        ends = {f"d_{name}": d, f"d_low_{name}": d - 0.25, f"d_high_{name}": d + 0.5, f"Z_tS_{name}": 3 + d}
        rows = rows.assign(**ends)
    page = table_1.places_markdown(places(0.9), rows)
    assert "| 10 of 40 | 1.90 | 1.00 (0.80 .. 1.20) | 20 | 3.00 | 3.00 (2.50 .. 3.50) | 21 |" in page
    page = table_1.places_markdown(emptied(places(0.9), "closed"), rows)
    assert "| 10 | (1, 0.2, 0, 0) | 0 of 0 |  |  |  |  |  |  |\n" in page and "nan" not in page
    assert "Empty where no more than one run has a combination in the range." in page
    assert "| 12.50 | 1.00 (0.75 .. 1.50) | 4.00 | -1.00 (-1.25 .. -0.50) | 2.00 |" in page


def test_the_span_of_n_s_is_held_against_the_papers():
    grid = pd.DataFrame({"n_S_percent": [2.7, 99.7], "n_S": [27.0, 997.0], "n_S_expected": [26.0, 998.0]})
    (said,) = verdict._span(grid)
    assert said.startswith(
        "Here 2.70 % to 99.70 %, the mean of the draws (closed form: 2.60 % to 99.80 %): agrees"
    )
    assert "does not agree" in verdict._span(grid.assign(n_S_percent=[2.7, 98.0]))[0]
    assert "does not agree" in verdict._span(grid.assign(n_S_percent=[3.7, 99.7]))[0]


def test_the_best_beside_the_papers():
    grid = pd.DataFrame([[1, 0, 6, 0], [1, 0, 2, 0]], columns=PARAMETERS)
    for name, d in (("kept", 2.0), ("surface", -2.0)):
        columns = {f"d_{name}": [d, 9.0], f"d_low_{name}": [d - 0.5, 9], f"d_high_{name}": [d + 0.25, 9]}
        grid = grid.assign(**columns)
    held = {"kept": "(1, 0, 2, 0); (1, 0, 6, 0)", "surface": "(1, 0, 2, 0)"}
    best = {name: {"unrestricted": winner(2, 0.1, 0.3, 0.5, best_set=text)} for name, text in held.items()}
    kept, surface = verdict._best(best, grid)
    assert "the best is (1, 0, 2, 0), d held out = 0.30 (0.10 .. 0.50), 0.80 as selected" in kept
    assert kept.endswith("(1, 0, 6, 0) gives d = 2.00 (1.50 .. 2.25) and lies in it.")
    assert surface.endswith("(1, 0, 6, 0) gives d = -2.00 (-2.50 .. -1.75) and lies not in it.")


def test_how_often_d_is_positive_for_certain():
    grid = pd.DataFrame({"d": [-2.0, 0.0, 1.0, 3.0], "d_low": [-3.0, -1, 0, 2], "d_high": [-1.0, 1, 2, 4]})
    grid = grid.add_suffix("_kept").join(grid.mul(-1).rename(columns={"d_low": "d_high", "d_high": "d_low"})
                                         .add_suffix("_surface"))  # fmt: skip
    kept, surface = verdict._positive(grid)
    assert (
        "in 2 of 4 combinations, above zero with its whole 95 % interval in 1 and below in 1; mean 0.50, "
        in kept
    )
    assert kept.endswith("largest 3.00.")
    assert (
        "in 1 of 4 combinations, above zero with its whole 95 % interval in 1 and below in 1; mean -0.50"
        in surface
    )


def test_the_family_at_equal_n_s():
    family = pd.DataFrame(
        {
            "percent": [5.0, 20.0],
            "members": [3, 4],
            "n_better": [0, 0],
            "Z_best": [1.5, 1.0],
            "Z_uniform": [1.2, 0.9],
        }
    )
    (said,) = verdict._family(family)
    assert "(7 cases): none of them above zero" in said
    assert said.endswith("5 %: 1.50 against 1.20; 20 %: 1.00 against 0.90.")
    assert "(7 cases): 2 of them above" in verdict._family(family.assign(n_better=[0, 2]))[0]


def test_what_alpha_keeps():
    grid = pd.DataFrame([[0.2, 0, 0, 0], [0.5, 0, 1, 0], [1, 0, 0, 0]], columns=PARAMETERS)
    said, patches = verdict._uniform(grid.assign(n_S_percent=[50.0, 7, 99]), {"median": 3.0})
    assert said == "alpha 0.2 keeps 50.0 %, alpha 1 keeps 99.0 %."
    assert patches.startswith("A dot lies in 3 patches")


def test_linking_distances_at_which_rows_turn():
    signs = pd.DataFrame(
        {"row": [1, 2, 3], "D_link_best": [0.9, 0.6, 0.7], "negative_from": [np.nan, 1.1, 1.1]}
    )
    peak, turned = verdict._links(signs)
    assert "between 0.6 and 0.9 Å" in peak
    assert len(verdict._links(signs.assign(negative_from=np.nan))) == 1
    assert turned == "Rows below zero with their whole interval from a D_link on, of 3: 1.1 Å: 2, 3."
    links = pd.DataFrame(
        {"row": [1, 1], "D_link": [0.5, 1.0], "d": [1.0, 2], "d_low": [0.5, 1], "d_high": [2.0, 4]}
    )
    assert "| 1 | 1.00 (0.50 .. 2.00) | 2.00 (1.00 .. 4.00) |" in verdict.links_markdown(links)


def test_what_the_defects_change():
    one = pd.DataFrame(
        {"row": [1, 2], "n_S_percent": [10.0, 20], "d_kept": [1.0, 2], "d_surface": [0.5, 0.5]}
    )
    other = one.assign(n_S_percent=[9.0, 18], d_kept=[1.5, 2], d_surface=[0.0, 0.5])
    (said,) = verdict._defects(
        pd.concat([one.assign(sampling="as published"), other.assign(sampling="one draw")])
    )
    assert said == (
        "one draw: n_S of the ten rows changes by -1.5 points on average, d by +0.25 under `kept` and -0.25 under `surface`."
    )


@pytest.mark.parametrize(
    ("rules", "path", "words"),
    [
        (
            {"method": "exact"},
            None,
            "our own analytic dots, re-entrant part `exact`, density 5 (dots per Å^2)",
        ),
        ({"method": "dms"}, None, "dots of the program DMS"),
        ({"method": "dms"}, "a/b.dms", "the dots of b.dms, as they are"),
    ],
)
def test_which_dots_the_page_is_about(rules, path, words):
    view = SimpleNamespace(
        points=np.zeros((3, 3)),
        roughness=np.array([0.2, 0.5, 0.8]),
        cover=SimpleNamespace(centre=np.arange(2)),
    )
    said = verdict.surface_sentence(view, {"reentrant": "exact", "density": 5} | rules, path)
    assert (
        said.startswith(f"Surface: {words}; N = 3 dots") and "2 centres (181), mean roughness 0.5000" in said
    )


def bins(rough, flat, flattest, n=20):
    """Half and single bins with d, its lower and upper end, the same under both readings."""
    rows = [("1", 0.1, rough, 20), ("2", 0.6, flattest, n), ("3", 0.9, (9.0, 9.0, 9.0), 9)]
    rows += [("rougher half", 0.0, rough, 40), ("flatter half", 0.5, flat, 40)]
    out = pd.DataFrame(
        [(name, low, count) for name, low, _, count in rows], columns=["bin", "roughness_low", "n"]
    )
    for reading in ("kept", "surface"):
        out[[f"d_{reading}", f"d_low_{reading}", f"d_high_{reading}"]] = [d for _, _, d, _ in rows]
        out[f"Z_tR_{reading}"] = 4.0
    return out.assign(around="any dots")


@pytest.mark.parametrize(
    ("rough", "flat", "words"),
    [
        ((2.0, 1.5, 2.5), (1.0, 0.5, 1.4), "rough patches gain more"),
        ((1.0, 0.5, 1.4), (2.0, 1.5, 2.5), "rough patches gain less"),
        ((2.0, 1.5, 2.5), (1.0, 0.5, 1.5), "no difference for certain"),
        ((-1.0, -1.2, -0.8), (-2.0, -2.2, -1.8), "both lose, rough patches less"),
        ((-2.0, -2.2, -1.8), (-1.0, -1.2, -0.8), "both lose, rough patches more"),
    ],
)
def test_rough_against_flat(rough, flat, words):
    said, _ = claims(bins(rough, flat, (0.1, 0.0, 0.2)))
    d, low, high = rough
    assert f"d is {d:.2f} ({low:.2f} .. {high:.2f}) in the rougher half of the bins and" in said
    assert f"in the flatter half: {words};" in said
    assert said.endswith(
        "(R_i from 0.60 on) 0.10 (0.00 .. 0.20): sampled and uniform dots cannot be told apart there."
    )


def test_a_flattest_bin_that_is_not_equal():
    said, _ = claims(bins((1.0, 1, 1), (1.0, 1, 1), (-0.2, -0.3, -0.1)))
    assert said.endswith("not equal, 5 % of Z_tR.")
    few, _ = claims(bins((2.0, 1.9, 2.1), (1.0, 1, 1), (0.2, 0.1, 0.3), n=9))
    assert "(R_i from 0.10 on) 2.00" in few  # a bin of 9 does not count
    ten, _ = claims(bins((2.0, 1.9, 2.1), (1.0, 1, 1), (0.2, 0.1, 0.3), n=10))
    assert "(R_i from 0.60 on) 0.20" in ten


def test_the_outlook_names_what_is_recovered():
    rows = [
        ("farthest", "fresh dots", 0.45, "surface", 80.0, 0.44),
        ("farthest", "turned", 0.7, "surface", 20.0, 0.72),
        ("farthest", "fresh dots", 0.45, "recovered", 7.0, 0.48),
        ("farthest", "turned", 0.7, "recovered", 2.5, 0.74),
    ]
    enough = pd.DataFrame(rows, columns=["sampler", "floor", "Z_floor", "islands", "n_S_percent", "Z"])
    fresh, turned = verdict._outlook(enough)
    assert "has a Z of 0.48 where other dots of the same surface, all kept, have 0.45" in fresh
    assert "7 % of the dots suffice instead of 80 %" in fresh
    assert turned.startswith(
        "To come within a tenth of 0.70, what turning the molecule and laying its dots anew costs, 2.5 % of the dots suffice "
        "instead of 20 %"
    )
