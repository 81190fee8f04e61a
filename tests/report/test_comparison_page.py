"""Pages on samplers and on all surfaces, from tables small enough to say by hand what each must read."""

import numpy as np
import pandas as pd
import pytest

from sparsurf.report import comparison_answer, comparison_page, summary_page
from sparsurf.report.pages import bounded, held_out
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.sampling.published import OF_PAPER
from sparsurf.study.comparison import NEAR

SURFACE = {"farthest": (2.0, 1.0), "uniform": (3.0, 1.5), "paper": (4.0, 2.0)}  # Z at 8 and 32 %


def comparison(**others):
    """compare.csv of three samplers at 8 and 32 %; Z halves as n_S grows fourfold."""
    z = {measure: SURFACE for measure in comparison_page.ABOUT} | others
    rows = [
        {
            "sampler": name,
            "percent": p,
            "n_S_percent": p,
            "measure": measure,
            "use": "surface",
            "value": value,
        }
        | {"low": value - 0.25, "high": value + 0.25, "null_model": 3.5, "empty_patch": 9.0}
        for measure, values in z.items()
        for name, both in values.items()
        for p, value in zip((8.0, 32.0), both, strict=True)
    ]
    return pd.DataFrame(rows)


PAIRS = pd.DataFrame(
    [
        ("Z surface", "uniform", "farthest", 8.0, -1.0, -1.25, -0.75),
        ("Z surface", "uniform", "paper", 8.0, 1.0, 0.5, 1.5),
        ("Z surface", "uniform", "voxel", 8.0, 0.1, 0.0, 0.2),
        ("Z surface", "uniform", "stride", 8.0, -0.1, -0.3, 0.1),
        ("Z surface", "uniform", "poisson", 32.0, -9.0, -9.5, -8.5),
        ("Z surface", "farthest", "poisson", 8.0, -9.0, -9.5, -8.5),
        ("Z centres", "uniform", "poisson", 8.0, -9.0, -9.5, -8.5),
    ],
    columns=["measure", "than", "sampler", "percent", "difference", "low", "high"],
)
FEWER = pd.DataFrame(
    [
        ("Z surface", "uniform", "farthest", 8.0, 2.25, 2.0, 2.25, "more than "),
        ("Z surface", "uniform", "paper", 8.0, 0.5, 0.4, 0.6, ""),
        ("Z surface", "paper", "farthest", 32.0, 9.0, 9.0, 9.0, ""),
        ("Z centres", "paper", "farthest", 8.0, 9.0, 9.0, 9.0, ""),
    ],
    columns=["measure", "than", "sampler", "percent", "factor", "low", "high", "bound"],
)
ALONE = pd.DataFrame(
    [
        ("uniform", 8.0, 8.1, comparison_answer.SCALE, 2.0, 1.9, 2.1),
        ("dotted", 8.0, 7.9, comparison_answer.SCALE, 1.0, 0.9, 1.1),
        ("uniform", 8.0, 8.1, 9.0, 2.25, 2.0, 2.5),
        ("dotted", 32.0, 32.0, comparison_answer.SCALE, 0.5, 0.4, 0.6),
    ],
    columns=["sampler", "percent", "n_S_percent", "scale", "Z", "low", "high"],
)


def test_the_answer_of_a_comparison():
    recovered = {"farthest": (0.75, 0.5), "uniform": (1.25, 0.5), "paper": (0.5, 0.5)}
    table = comparison(**{"Z recovered": recovered})
    lines = comparison_answer.answer(table, PAIRS, FEWER, ALONE)
    assert lines[:5] == [
        "- At 8 % of the dots farthest describes the surface best: Z = 2.00.",  # 8 is nearer to 10 than 32
        "- The surface recovered from the kept dots alone: Z = 0.50 from those of paper, 1.25 from a uniform draw.",
        "- For certain better than a uniform draw, by (paired 95 % interval): farthest -1.00 (-1.25 .. -0.75).",
        "- For certain worse than a uniform draw, by (paired 95 % interval): paper +1.00 (+0.50 .. +1.50).",
        "- For the Z they reach there, farthest needs more than 2.2 (2.0 or more) times fewer than uniform.",
    ]
    assert lines[5].startswith("\nZ, patches cut")  # five at most
    assert "| farthest | 2.00 | 1.00 |" in lines[6] and "| farthest | 0.75 | 0.50 |" in lines[8]
    floor = comparison_answer.answer(table.assign(fresh_dots=0.4), None, None, ALONE)
    assert floor[1].endswith("from a uniform draw; other dots of the same surface, all kept, cost 0.40.")
    assert floor[2] == (
        "- With nothing known of the full surface (`scaled`), Z is dotted 1.00 (0.90 .. 1.10), uniform 2.00 (1.90 .. 2.10)."
    )


def test_who_cannot_be_told_from_the_best_is_named_with_it():
    rows = [
        ("farthest", "poisson", 8.0, 0.25),
        ("uniform", "farthest", 8.0, 0.0),
        ("uniform", "voxel", 8.0, 0.2),
    ]
    rows += [("farthest", "stride", 8.0, -0.05), ("farthest", "adaptive", 32.0, 0.25)]
    pairs = pd.DataFrame(
        [("Z surface", *row[:3], 0.1, 0.1 - row[3], 0.1 + row[3]) for row in rows], columns=PAIRS.columns
    )
    begin = "- At 8 % of the dots farthest describes the surface best: Z = 2.00"
    assert (
        comparison_answer.answer(comparison(), pairs)[0] == f"{begin}; poisson cannot be told from it."
    )  # of farthest and uniform, of others the interval leaves 0
    pairs.loc[1, "low"] = -0.5
    assert (
        comparison_answer.answer(comparison(), pairs)[0]
        == f"{begin}; poisson and uniform cannot be told from it."
    )
    alike = comparison(**{"Z surface": SURFACE | {"uniform": (2.004, 1.5)}})
    assert comparison_answer.answer(alike)[0] == f"{begin}; uniform has the same Z."
    alike = comparison(**{"Z surface": SURFACE | {"uniform": (2.004, 1.5), "paper": (2.004, 2.0)}})
    assert comparison_answer.answer(alike)[0] == f"{begin}; uniform and paper have the same Z."


def test_a_bound_has_the_limit_of_its_free_side_and_without_scatter_none():
    def told(**values):
        fewer = FEWER[:1].assign(**values)
        return next(line for line in comparison_answer.answer(comparison(), None, fewer) if "needs" in line)

    assert "needs more than 2.2 times fewer than uniform." in told(low=np.nan, high=np.nan)
    assert "needs more than 2.2 times fewer than uniform." in told(low=2.25, high=2.249)
    assert "needs 2.2 (2.2 .. 2.2) times fewer than uniform." in told(low=2.21, high=2.24, bound="")
    assert "needs more than 2.2 (1.8 or more) times fewer than uniform." in told(low=1.8)
    less = {"low": 2.25, "high": 2.6, "bound": "less than "}
    assert "needs less than 2.3 (2.6 or less) times fewer than uniform." in told(**less)
    assert "needs 2.2 (1.8 .. 2.2) times fewer than uniform." in told(low=1.8, bound="")
    # the spread of several proteins: their mean is at no bound
    for bound, words in (("more than ", "more than 2.2"), ("less than ", "less than 2.3")):
        assert f"needs {words} (1.8 .. 4.0) times fewer than uniform." in told(low=1.8, high=4.0, bound=bound)


@pytest.mark.parametrize(
    ("factor", "bound", "words"),
    [
        (0.97, "more than ", "0.9"),
        (2.3, "more than ", "2.3"),
        (0.3 / 0.1, "more than ", "3.0"),  # 2.9999999999999996
        (2.29, "more than ", "2.2"),
        (1.04, "less than ", "1.1"),
        (1.1, "less than ", "1.1"),
        (0.97, "", "1.0"),
        (0.97, "about ", "1.0"),
    ],
)
def test_a_bound_is_not_rounded_into_a_claim(factor, bound, words):
    fewer = FEWER[:1].assign(factor=factor, bound=bound, low=np.nan, high=np.nan)
    assert bounded(factor, bound) == words
    if bound:
        lines = comparison_answer.answer(comparison(), None, fewer)
        assert (
            lines[2]
            == f"- For the Z they reach there, farthest needs {bound}{words} times fewer than uniform."
        )


def test_subsets_that_stand_alone_in_a_table():
    page = comparison_answer.alone_markdown(ALONE)
    assert "| dotted | 1.00 (0.90 .. 1.10) at 7.9 % | 0.50 (0.40 .. 0.60) at 32.0 % |" in page
    assert "it changes Z by 0.25 at most" in page


def test_findings_of_a_comparison():
    said = "\n".join(comparison_page._findings(comparison()))
    assert "As the surface, at 8 %: farthest 2.00, uniform 3.00, paper 4.00." in said
    assert "Z farthest < uniform < paper holds at every n_S." in said
    assert "Lowest Z: farthest at 8, 32 %." in said
    # Z = 2 sqrt(8 / n): 3 is beyond what was measured of farthest; so farthest at 8 % or fewer
    assert "farthest needs more than 1.0 times fewer dots than uniform at 8 % for the same Z." in said
    by_chance = comparison()
    by_chance.loc[by_chance["sampler"] == "uniform", "n_S_percent"] *= 0.97
    said_then = "\n".join(comparison_page._findings(by_chance))
    assert "farthest needs more than 0.9 times fewer dots than uniform at 8 % for the same Z." in said_then
    assert "Worse than the null model: at 8 % paper." in said
    turned = {"farthest": (2.0, 3.0), "uniform": (3.0, 1.5), "paper": (4.0, 3.6)}
    other = "\n".join(comparison_page._findings(comparison(**{"Z surface": turned})))
    assert "holds at 8 %, but not at 32 %." in other
    assert "Lowest Z: farthest at 8 %; uniform at 32 %." in other
    assert "Worse than the null model: at 8 % paper; at 32 % paper." in other
    all_bad = comparison(**{"Z surface": {name: (9.0, 9.0) for name in SURFACE}})
    assert "at 8 % every sampler; at 32 % every sampler" in "\n".join(comparison_page._findings(all_bad))
    one_equal = comparison(**{"Z surface": {"farthest": (3.5, 1), "uniform": (9, 1), "paper": (9, 1)}})
    assert "null model: at 8 % uniform, paper." in "\n".join(comparison_page._findings(one_equal))
    never = comparison(**{"Z surface": {name: (3.5, 1.0) for name in SURFACE}})
    assert "Every Z lies below the null model." in "\n".join(comparison_page._findings(never))


def test_what_kept_tells_is_said_where_patches_break_up():
    broken = {"farthest": (60.0, 60.0), "uniform": (50.0, 60.0), "paper": (20.0, 60.0)}
    kept = {"farthest": (5.0, 1.0), "uniform": (6.0, 1.0), "paper": (1.0, 1.0)}
    said = "\n".join(comparison_page._findings(comparison(**{"fragment kept": broken, "Z kept": kept})))
    assert "Under `kept` the order at 8 % is paper, farthest, uniform" in said
    assert "of the median patch 20 % is left for paper, 60 % for farthest" in said
    whole = {name: (31.0, 31.0) for name in SURFACE}
    said = "\n".join(comparison_page._findings(comparison(**{"fragment kept": whole})))
    assert "Under `kept`" not in said


def test_matrices_of_a_comparison():
    seconds = {name: (0.004, 0.008) for name in SURFACE}
    table = comparison(seconds=seconds)
    table.loc[table["measure"] == "seconds", "low"] = np.nan
    page = comparison_page.compare_markdown(table, "a/c1", "Facts.\n")
    assert "| farthest | 2.00 ± 0.25 | 1.00 ± 0.25 |" in page
    assert "| farthest | 4.00 | 8.00 |" in page  # milliseconds
    # for Z = 3 farthest needs fewer than 8 %, paper 8 (4 / 3)^2 = 14.2 %
    assert "| uniform | 3.00 | < 8.0 | 8.0 | 14.2 |" in page
    assert "| farthest | 2.00 | 8.0 | 18.0 | 32.0 |" in page
    assert comparison_page._per_cent(np.inf, 8.0, 32.0) == "> 32"
    assert "n_S as it came out" not in page
    by_chance = table.assign(n_S_percent=table["n_S_percent"] + 0.5 * (table["sampler"] == "paper"))
    page = comparison_page.compare_markdown(by_chance, "a/c1", "Facts.\n")
    assert (
        "n_S as it came out, %:\n\n| sampler | 8 % | 32 % |\n| --- | --- | --- |\n| paper | 8.50 | 32.50 |\n\n"
        in page
    )


def test_facts_of_a_comparison():
    said = comparison_page.facts(3000, 600.0, True, 200, 3, OF_PAPER)
    assert said.startswith("3000 dots on 600 Å^2, estimated from the spacing")
    assert "(5.00 per Å^2); 200 test dots, 3 draws" in said and "from Table I of the paper" in said
    assert (
        "within 10 % of n_S at their own alpha (or the nearest)" in said
        and "can do worse than `paper`" in said
    )
    assert f"{NEAR:.0%}" == "110%"
    assert "this surface's own ranges.csv" in comparison_page.facts(3000, 600.0, False, 200, 3, None)


def test_the_page_of_all_surfaces():
    surfaces = pd.DataFrame(
        {
            "protein": ["a", "b", "c"],
            "conformation": "c1",
            "N": [1000, 2000, 3000],
            "area": [200.4, 400.0, 600.0],
            "mean_roughness": [0.6, 0.61, 0.62],
            "enough_fresh_dots_surface": [80.0, 60.0, 90.0],
            "enough_fresh_dots_recovered": [7.0, 8.0, np.nan],
        }
    )
    ends = {"kept": (2.0, 1.5, 2.5), "recovered": (-0.0001, -0.5, 0.5)}
    for name, (d, low, high) in ends.items():
        surfaces = surfaces.assign(**{f"best_{name}": "(1, 0, 6, 0)", f"d_{name}": d + 0.5})
        surfaces = surfaces.assign(**{f"d_held_out_{name}": d, f"n_S_percent_{name}": 46.0})
        surfaces = surfaces.assign(**{f"d_held_out_low_{name}": low, f"d_held_out_high_{name}": high})
    row = dict(zip(PARAMETERS, (1.0, 0.0, 6.0, 0.0), strict=True)) | {
        "islands": "kept",
        "d": 2.0,
        "d_sd": 0.5,
    }
    row |= {"n_S_low_percent": 3.0, "n_S_high_percent": 12.5, "n_winners": 2, "n_surfaces": 3, "n_shared": 1}
    row |= {f"rho_{name}": k / 10 for k, name in enumerate(PARAMETERS)} | {"n_proteins": 3, "p": 0.04}
    row |= {"gain": 0.3, "gain_low": 0.1, "gain_high": 0.5}
    unknown = row | {"d": np.nan, "d_sd": np.nan, "gain_low": np.nan, "gain_high": np.nan}
    relations = pd.DataFrame([row, unknown, row | {"islands": "surface", "d": 7.77}])
    page = summary_page.summary_markdown(surfaces, relations)
    assert "| fresh dots | 80 (60 to 90) | 7.5 (7 to 8) |" in page
    assert "| a | c1 | 1000 | 200 Å^2 | 0.600 | (1, 0, 6, 0) | 2.000 | (1, 0, 6, 0) | 0.000 |" in page
    line = "| 3.0 - 12.5 | (1, 0, 6, 0) | 2.00 | 0.50 | 2 of 3 | 1 | 0.00 | 0.10 | 0.20 | 0.30 | 3 | 0.04 | 0.30 |"
    assert f"{line} 0.10 .. 0.50 |" in page
    assert "| 3.0 - 12.5 |  |  |  | 2 of 3 |" in page
    assert f"d held out: {held_out(6)}.\n" in page
    assert (
        "can lie outside of a surface's own range, by which winners and sets go; its d is as selected" in page
    )
    assert f"d held out: {held_out(1)}.\n" in summary_page.summary_markdown(surfaces, relations, 1)
    assert "7.77" not in page  # that reading was not studied
    assert summary_page.enough_markdown(surfaces[["protein"]]) == []
