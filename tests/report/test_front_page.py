"""The first page of a run: its sentences follow from the tables, its links lead somewhere."""

import json
import os
import re

import numpy as np
import pandas as pd
import pytest

import write_front_page
from sparsurf.report.front_page import (
    best_sentence,
    enough_sentence,
    front_page,
    recovered_sentence,
    sampler_sentence,
    studied,
)
from sparsurf.report.html import as_html, in_report
from sparsurf.report.pages import held_out
from sparsurf.study.enough import enough

GRID = pd.DataFrame(
    {
        "n_S_percent": [5.0, 10.0, 20.0, 40.0],
        "Z_tR_surface": [2.0, 1.5, 1.0, 0.5],
        "Z_tR_high_surface": [2.2, 2.1, 1.2, 0.7],
        "Z_tS_surface": [2.5, 2.2, 1.9, 1.4],
        "Z_tS_high_surface": [2.7, 2.4, 2.1, np.nan],
    }
)
LINKS = [("c1", [("look", "p/c1/view.html"), ("x", "p/c1/a b.csv")])]


def surfaces(n=1, more=()):
    row = {"protein": "p", "N": 2000, "mean_roughness": 0.6}
    for reading, d in (("kept", 2.5), ("surface", -0.1), *more):
        row |= {f"best_{reading}": "(1, 0, 6, 0)", f"n_S_percent_{reading}": 46.0, f"d_{reading}": d}
        row |= {f"d_held_out_low_{reading}": d - 0.3, f"d_held_out_high_{reading}": d + 0.1}
        row[f"d_held_out_{reading}"] = d - 0.1
    return pd.DataFrame([row | {"conformation": f"c{k + 1}"} for k in range(n)])


def handed_out(n=1, dots=400):
    return pd.DataFrame({"protein": "p", "conformation": [f"c{k + 1}" for k in range(n)], "dots": dots})


def reached(percent=5.0):
    """enough.csv of one surface."""
    rows = [
        ("poisson", "fresh dots", 0.53, "surface", 1600, 80.0, 0.6),
        ("poisson", "turned", 0.8, "recovered", 40, 2.0, 0.9),
        ("poisson", "fresh dots", 0.53, "recovered", 100, percent, 0.58),
    ]
    return pd.DataFrame(rows, columns=["sampler", "floor", "Z_floor", "islands", "n_S", "n_S_percent", "Z"])


def test_enough_is_the_smallest_n_s_surely_below_the_null_model():
    table = enough(GRID, 2.0, {"better": 0.4}).set_index(["sampler", "yardstick"])["n_S_percent"]
    assert table["uniform", "null_model"] == 20  # the interval of 1.5 reaches above 2
    assert table["paper", "null_model"] == 40  # so does that of 1.9
    assert table.isna().tolist() == [False, True, False, True]
    assert not enough(GRID, 2.0, {})["smallest"].any()
    assert enough(GRID, 9.0, {})["smallest"].all()


def test_sentences_of_one_surface():
    one = surfaces()
    assert studied(one) == "Studied: 1 surface of 1 protein (p), 2,000 dots each, mean roughness 0.60.\n"
    said = best_sentence(one)
    assert (
        "(1, 0, 6, 0) is best: it keeps 46.0 % of the dots with d = 2.40 (held out; 95 %: 2.20 to 2.60; as selected 2.50)"
        in said
    )
    assert "d = -0.20 (held out; 95 %: -0.40 to 0.00" in said
    found = enough_sentence(enough(GRID, 2.0, {}))
    assert "below 2.00," in found and "from 20 % of the dots on with a uniform draw and" in found
    near = enough_sentence(enough(GRID, 2.0, {"turned": 1.7}))
    assert (
        "; Z comes within a tenth of 1.70, what turning the molecule and laying its dots anew costs, from "
        in near
    )
    assert (
        "and from 40 % of the dots on with whichever combination of the paper's sampling needs the fewest."
        in found
    )


def test_the_reading_of_recovered_surfaces_is_told_where_it_was_studied():
    said = best_sentence(surfaces(more=[("recovered", 0.5)]))
    told = "; with the surface recovered from the kept dots alone (1, 0, 6, 0) is best: it keeps 46.0 % of the dots with d = "
    assert said.endswith(f"{told}0.40 (held out; 95 %: 0.20 to 0.60; as selected 0.50).")
    page = front_page(
        "run",
        surfaces(more=[("recovered", 0.5)]),
        enough(GRID, 2.0, {}),
        reached(),
        handed_out(),
        None,
        LINKS,
    )
    assert f"d held out: {held_out(6)}.\n" in page
    assert "| best, recovered | d, recovered |" in page and "| (1, 0, 6, 0) | 0.40 |\n" in page


def test_a_best_that_keeps_every_dot_is_told_as_that():
    whole = surfaces().assign(n_S_percent_surface=100.0, d_held_out_surface=0.0)
    said = best_sentence(whole)
    assert said.endswith(
        "(1, 0, 6, 0) is best: it keeps every dot, as a uniform draw of as many does, so that d is 0."
    )
    assert "it keeps 46.0 % of the dots with d = 2.40" in said
    assert "every dot" not in best_sentence(whole.assign(n_S_percent_surface=99.9))


def test_sentences_of_several_surfaces():
    three = surfaces(3)
    three.loc[2, ["best_kept", "d_kept"]] = ["(1, 0, 0, 8)", 9.0]
    three.loc[1, ["d_held_out_kept", "d_held_out_high_kept"]] = [3.0, 3.3]
    proteins = pd.concat([surfaces().assign(protein=name) for name in "abcd"])
    assert "3 surfaces of 3 proteins (a, b, c)," in studied(proteins[:3])
    assert "4 surfaces of 4 proteins," in studied(proteins)
    said = best_sentence(three)
    assert "(1, 0, 6, 0) is best on 2 of 3 surfaces" in said
    assert "d = 2.40 to 3.00 (held out; 95 % intervals within 2.20 to 3.30; as selected 2.50)" in said
    three.loc[0, "best_kept"] = "(1, 0, 8, 0)"
    said = best_sentence(three)
    place = f"{three.loc[1, 'protein']}/{three.loc[1, 'conformation']}"
    assert f"no two surfaces have the same best; the highest d has (1, 0, 6, 0) on {place}: it keeps " in said
    assert "d = 3.00 (held out; 95 %: 2.20 to 3.30" in said
    both = pd.concat(
        [
            enough(GRID, 2.0, {}),
            enough(GRID.assign(n_S_percent=[9, 12, 30, 50]), 2.0, {}),
        ]
    )
    assert "from 25 % (20 to 30 %) of the dots on with a uniform draw" in enough_sentence(both)
    alike = pd.concat(
        [
            enough(GRID, 2.0, {}),
            enough(GRID.assign(n_S_percent=[5, 10, 20.4, 40]), 2.0, {}),
        ]
    )
    assert "from 20 % of the dots on with a uniform draw" in enough_sentence(alike)
    smallest = pd.concat([enough(GRID, 9.0, {}), enough(GRID, 2.0, {})])
    assert "the smallest n_S of the grid" not in enough_sentence(smallest)
    never = pd.concat([enough(GRID, 2.0, {}), enough(GRID, 0.1, {})])
    assert "at no n_S of the grid on 1 of 2 surfaces" in enough_sentence(never)
    assert "at no n_S of the grid with a uniform" in enough_sentence(never[never["n_S_percent"].isna()])


def test_the_share_of_dots_that_gives_the_surface_back():
    said = recovered_sentence(reached(), surfaces(), handed_out(1, 88))
    assert (
        "From 5 % of the dots on (by the steps of enough.csv), taken by the sampler poisson, the surface is recovered to "
        "within a tenth of what other dots" in said
    )
    assert "(Z 0.58 beside 0.53; the dots as they are need 80 %)" in said
    assert "As the config's `minimal` asks, `minimal.csv` hands out 4.4 % of the dots." in said
    both = pd.concat([reached(), reached(7.0)])
    said = recovered_sentence(both, surfaces(2), handed_out(2, [88, 2000]))
    assert "From 5 to 7 % of" in said and "hands out 4.4 to 100.0 % of the dots." in said


NEEDED = pd.DataFrame(
    [
        ("Z surface", "uniform", "farthest", 10.0, 1.9, ""),
        ("Z surface", "uniform", "farthest", 40.0, 9.0, ""),
        ("Z surface", "uniform", "paper", 10.0, 0.5, ""),
        ("Z centres", "uniform", "voxel", 10.0, 7.0, ""),
    ],
    columns=["measure", "than", "sampler", "percent", "factor", "bound"],
)


def test_samplers_where_they_were_compared():
    assert "not compared" in sampler_sentence(None)
    assert "compared on single surfaces" in sampler_sentence(None, True)
    said = sampler_sentence(NEEDED)
    assert "uniform draw of 10 % of the dots, farthest needs 1.9 times fewer dots" in said
    assert "paper's sampling 2.0 times more dots" in said
    ahead = NEEDED.assign(factor=NEEDED["factor"].where(NEEDED["sampler"] != "paper", 3.0))
    assert sampler_sentence(ahead).endswith("of the dots, paper needs 3.0 times fewer dots.")
    more = pd.DataFrame([NEEDED.iloc[0]]).assign(sampler="poisson", factor=1.94)
    said = sampler_sentence(pd.concat([NEEDED, more]))
    assert "% of the dots, poisson and farthest need 1.9 times fewer dots, the paper's" in said
    said = sampler_sentence(pd.concat([NEEDED, more.assign(factor=1.84)]))
    assert "% of the dots, farthest needs 1.9 times fewer dots, the paper's" in said
    bounds = {"farthest": "more than ", "paper": "less than "}
    bounded = sampler_sentence(NEEDED.assign(bound=NEEDED["sampler"].map(bounds)))
    assert "farthest needs more than 1.9 times fewer" in bounded
    assert "paper's sampling more than 2.0 times more" in bounded
    just = sampler_sentence(NEEDED.assign(factor=NEEDED["factor"].clip(upper=0.8), bound="more than "))
    assert (
        "farthest needs less than 1.3 times more dots" in just
    )  # 1.25: less than 1.2 would say more than is known
    just = sampler_sentence(NEEDED.assign(factor=2.19, bound="more than "))
    assert "farthest needs more than 2.1 times fewer dots" in just
    for factor, bound, words in (
        (0.96, "", "as many"),
        (0.99, "more than ", "no more"),
        (1.04, "less than ", "no fewer"),
        (1.06, "more than ", "no more"),
        (0.95, "less than ", "no fewer"),
        (1.02, "about ", "about as many"),
    ):
        said = sampler_sentence(NEEDED.assign(factor=factor, bound=bound))
        assert f"needs {words} dots, the paper's sampling {words} dots." in said


def test_samplers_that_were_compared_without_the_uniform_one():
    papers = NEEDED[NEEDED["sampler"] == "farthest"].assign(than="paper")
    assert sampler_sentence(papers).startswith(
        "For the Z of the paper's sampling of 10 % of the dots, farthest needs 1.9"
    )
    assert "none of them is uniform or the paper's" in sampler_sentence(NEEDED[:0])


def test_a_comparison_of_some_surfaces_is_told():
    def page(links):
        rows = enough(GRID, 2.0, {})
        return front_page("run", surfaces(2), rows, reached(), handed_out(2), None, links)

    assert "were not compared in this run" in page(LINKS)
    assert "were compared on single surfaces" in page(
        [*LINKS, ("p/c", [("samplers compared", "p/c/compare.md")])]
    )


@pytest.mark.parametrize("n", [1, 25])
def test_the_page_begins_with_the_answer(n):
    page = front_page("run", surfaces(n), enough(GRID, 2.0, {}), reached(), handed_out(n), None, LINKS)
    answer = page.index("## The answer")
    assert answer < 200 + page.index("# Results") and answer < page.index("| protein")
    assert len(re.findall(r"^\d\. ", page, re.M)) == 3
    assert page.count("| p | c") == min(n, 20)
    assert ("all in surfaces.csv" in page) == (n > 20)


def test_links_of_the_page_and_of_the_report():
    page = "# T\n\n[look](p/c1/view.html) [away](https://example.org)\n"
    assert 'href="p/c1/view.html"' in as_html(page, "T")
    part = in_report(
        page + "[x](p/a%20b.csv) [y](p/x.csv)\n", "results/my run", ["p/c1/view.html", "p/a b.csv"]
    )
    assert "href=\"javascript:app.showResultInfo('results/my%20run/p/c1/view.html')\"" in part
    assert 'href="https://example.org"' in part
    assert "showResultInfo('results/my%20run/p/a%20b.csv')" in part
    assert 'href="p/x.csv"' in part  # not in the report, but beside it


def test_a_comparison_a_simulation_and_pairs_are_led_to():
    pages = [
        "compare.md",
        "compare.png",
        "pairs/pairs.md",
        "p/figures/simulation.png",
        "p/simulation/quality.csv",
    ]
    pages += ["p/c1/compare.md", "p/c1/figures/compare.png", "q/c1/view.html"]
    found = write_front_page.links_to([("p", "c1")], pages)
    assert [heading for heading, _ in found] == ["the run", "p", "p/c1"]
    assert {path for _, links in found for _, path in links} == set(pages[:-1])


def test_a_run_that_failed_in_part_has_a_first_page(tmp_path, capsys):
    run = tmp_path / "results" / "mine"
    table = pd.concat(
        [surfaces().assign(protein=name, N=n) for name, n in (("5", 9000), ("012", 2000), ("7", 4000))]
    )
    for name, files in {"5": 3, "012": 4, "7": 4}.items():
        folder = run / name / "c1"
        folder.mkdir(parents=True)
        GRID.assign(d_surface=0.0).to_csv(folder / "grid.csv", index=False)
        best = {
            "surface": {},
            "draws": 1,
            "yardsticks": {"null_model": 2.0, "floors": {"fresh dots": 1.0, "moved": 0.1}},
        }
        (folder / "best.json").write_text(json.dumps(best))
        reached().to_csv(folder / "enough.csv", index=False)
        if files == 4:  # else its minimal.csv was not made any more
            pd.DataFrame({"dot": range(200)}).to_csv(folder / "minimal.csv", index=False)
        (folder / "view.html").write_text("")
    with pytest.raises(SystemExit):
        write_front_page.by_hand([str(run)])
    assert "has no surfaces.csv" in capsys.readouterr().err
    table[table["protein"] == "5"].to_csv(run / "surfaces.csv", index=False)
    with pytest.raises(SystemExit, match=r"mine holds no finished conformation: there is nothing to write"):
        write_front_page.by_hand([str(run)])
    assert not capsys.readouterr().err and not (run / "index.md").exists()
    table.to_csv(run / "surfaces.csv", index=False)
    (run / ".front_page.html").write_text("of an earlier run")
    (run / "pairs").mkdir()
    (run / "pairs" / "pairs.md").write_text("")
    (run / "report.html").write_text("of an earlier run")
    write_front_page.by_hand([str(run), "--without", "5", "c1/take_minimal: a <defect>."])
    page = (run / "index.md").read_text()
    assert "**1 protein could not be finished; what follows is of what was made." in page
    assert "- 5: c1/take_minimal: a <defect>." in page and page.index("- 5:") < page.index(
        "Studied: 2 surfaces"
    )
    assert f"0 is rough. d held out: {held_out(1)}.\n" in page
    assert "(012, 7), 2,000 to 4,000 dots each" in page  # in their order, each with its own
    assert "hands out 5.0 to 10.0 % of" in page
    assert "[to turn and sample](7/c1/view.html)" in page and "(5/c1/view.html)" not in page
    assert "- pairs.md" not in page and "report.html" not in page
    html = (run / "index.html").read_text()
    assert "<li>5: c1/take_minimal: a &lt;defect&gt;.</li>" in html
    assert not (run / ".front_page.html").exists()  # Snakemake makes the page anew as soon as all is there
    assert "not compared in this run" in page
    NEEDED.to_csv(run / "compare_needed.csv", index=False)
    pairs = ["--without", "pairs/a", "not finished", "--without", "pairs/b", "draw_pair: too far."]
    write_front_page.by_hand([str(run), *pairs])
    assert "**2 pairs could not be finished;" in (run / "index.md").read_text()
    write_front_page.by_hand([str(run), "--without", "5", "not finished", *pairs])
    assert "**1 protein and 2 pairs could not be finished;" in (run / "index.md").read_text()
    assert "farthest needs 1.9 times fewer dots" in (run / "index.md").read_text()
    os.utime(run / "compare_needed.csv", (0, 0))  # of grids that were made anew since
    write_front_page.by_hand([str(run)])
    assert "not compared in this run" in (run / "index.md").read_text()
    (run / "7" / "c1" / "surface.npz").touch()
    os.utime(run / "7" / "c1" / "surface.npz", (4e9, 4e9))  # made anew, as nothing that follows from it was
    write_front_page.by_hand([str(run)])
    assert "of 1 protein (012)" in (run / "index.md").read_text()
