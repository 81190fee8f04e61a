"""Pages of invented tables: what the small study does not have, such as a single surface, failures and no grid."""

import re

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from parsed_pages import Page
from sparsurf.pairs.changes import SHARE_ABOVE_FLOOR
from sparsurf.report import changes_page, ensemble_page, first_page, pairs_section, summary_page
from sparsurf.report.page import embedded_figures, render
from sparsurf.report.ranges_page import best_of

READINGS = ("kept", "full")
D = {"kept": 2.51, "full": -0.28}  # of the best range
COMBINATION = {"alpha": 1.0, "beta": 0.0, "gamma": 6.0, "delta": 0.0}
OF_GRID = ("summary.csv", "relation.csv", "ranges.html", "figures/roughness.png", "figures/required_dots.png")


def write_run(folder, places=(("p", "c1"),)):
    """Write the tables that a first page is made of, and files that it leads to; return their paths from the folder."""
    summary = pd.DataFrame(
        [
            {"protein": p, "conformation": c, "mean_roughness": 0.6, "reading": reading, "range": k} | COMBINATION
            | {"n_S_low_percent": 30.0 * k - 30, "n_S_high_percent": 30.0 * k, "n_S_percent": 30.0 * k - 5}
            | {"d_cv": (d := D[reading] * of_best), "d_cv_low": d - 0.1, "d_cv_high": d + 0.2}
            for p, c in places
            for reading in READINGS
            for k, of_best in enumerate((0.5, 1.0, 0.2), 1)
        ]
    )  # fmt: skip
    surfaces = pd.DataFrame(places, columns=["protein", "conformation"])
    surfaces = surfaces.assign(N=2000 + surfaces.index, mean_roughness=0.6, area=380.4, minimal_n_S=1234)
    surfaces = surfaces.assign(minimal_n_S_percent=4.51, best_kept="(1, 0, 4, 0)", best_full="(1, 0, 4, 0)")
    relation = summary.drop_duplicates(["reading", "range"]).assign(d=1.0)
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in (("summary", summary), ("surfaces", surfaces), ("relation", relation)):
        table.to_csv(folder / f"{name}.csv", index=False)
    files = ["summary.csv", "surfaces.csv", "relation.csv"]
    for k, place in enumerate("/".join(place) for place in places):
        (folder / place / "figures").mkdir(parents=True)
        rows = [("farthest", "fresh dots", *of) for of in (("full", 60.0 + k), ("recovered", 6.4 + k))]
        required = pd.DataFrame(rows, columns=["sampler", "floor", "reading", "n_S_percent"])
        required.to_csv(folder / place / "required_dots.csv", index=False)
        for name in ("minimal.csv", "view.html", "ranges.html"):
            (folder / place / name).write_text("x")
        for name in ("view", "figures/roughness", "figures/required_dots"):
            Image.new("RGB", (200, 100), "red").save(folder / place / f"{name}.png")
        files += [str(path.relative_to(folder)) for path in sorted((folder / place).rglob("*.*"))]
    return files


def values_of(folder, files, **more):
    return first_page.first_page(folder, files, **more)


def first(folder, files, **more):
    return Page(html_of(folder, files, **more))


def html_of(folder, files, **more):
    return render(first_page.TEMPLATE, **values_of(folder, files, **more))


def without_grid(files):
    return [path for path in files if not path.endswith(OF_GRID)]


def test_a_single_surface_has_its_answers_with_their_intervals(tmp_path):
    page = first(tmp_path, write_run(tmp_path))
    assert (
        "How few dots describe the surface of p?" in page.blocks
        and "6.4 % of the dots bring Z near its floor:" in page.text
    )
    assert (
        "d = 2.51 for the paper's sampling among the kept dots, at its best with 55 % of the dots: it beats a uniform"
        in page.text
    )
    assert (
        "d = −0.28 for the paper's sampling on the full surface, in the same range of nS, with 55 %: it loses to"
        in page.text
    )
    row = ["30 – 60", "(1, 0, 6, 0)", "2.51 (2.41 to 2.71)", "(1, 0, 6, 0)", "−0.28 (−0.38 to −0.08)"]
    assert row in page.rows and {"p/c1/minimal.csv", "p/c1/required_dots.csv"} <= {*page.links}


@pytest.mark.parametrize(
    ("bounds", "percents", "words"),
    [
        (["at most", "at most"], [4.0, 5.0], "≤ 4.5 % of the dots bring Z near its floor (median; surfaces from 4 to 5 %)"),
        (["more", "more"], [100.0, 100.0], "All dots are needed"),
        (["at most", "more"], [4.0, 100.0], "52 % of the dots bring Z near its floor (median; surfaces from 4 to 100 %)"),
    ],
)  # fmt: skip
def test_bounds_on_the_dots_that_are_enough(tmp_path, bounds, percents, words):
    files = write_run(tmp_path, [("p", "c1"), ("q", "c1")])
    for place, bound, percent in zip(("p/c1", "q/c1"), bounds, percents, strict=True):
        path = tmp_path / place / "required_dots.csv"
        pd.read_csv(path).assign(bound=bound, n_S_percent=percent).to_csv(path, index=False)
    page = first(tmp_path, files)
    assert words in page.text and "q/c1/minimal.csv" not in page.links  # only the files of a single protein


def test_without_a_grid_each_surface_has_a_row_a_picture_and_its_share(tmp_path):
    files = without_grid(write_run(tmp_path, [("p", "c1"), ("q", "c1")]))
    page = first(tmp_path, files)
    assert [row[1:-1] for row in page.rows[1:]] == [
        ["p", "2,000", "380", "0.60", "1,234", "4.5"], ["q", "2,001", "380", "0.60", "1,234", "4.5"],
    ]  # fmt: skip
    assert [source[:23] for source in page.sources] == ["data:image/webp;base64,"] * 2
    assert {"p/c1/view.html", "q/c1/minimal.csv"} <= {*page.links} and "summary.html" not in page.links
    assert "d = " not in page.text and "Best" not in page.text and "cross-validated" not in page.text
    asked = first(tmp_path, files, floor=None).text
    assert (
        "4.5 % of the dots are in the minimal subset" in asked
        and "6.9 % of the dots bring Z near its floor" in asked
    )


def test_without_a_grid_the_first_page_begins_with_what_changes(tmp_path):
    files = [*write_run(tmp_path), "changes/opening/changes.csv"]
    (tmp_path / "changes/opening").mkdir(parents=True)
    (tmp_path / files[-1]).write_text("total,above,above_moved\n1,1,1\n2,1,0\n3,1,1\n,0,0\n")
    sampled, alone = first(tmp_path, files).text, first(tmp_path, without_grid(files)).text
    assert sampled.index("d = 2.51") < sampled.index("2 of 3 residues of opening")
    assert alone.startswith("What changes in opening?")
    assert alone.index("2 of 3 residues of opening") < alone.index("of the dots bring Z near its floor")


def test_names_that_look_like_numbers_or_gaps_stay_names(tmp_path):
    for names in (["1E96"], ["NA", "012"]):
        files = write_run(folder := tmp_path / names[0], [(name, "c1") for name in names])
        table = pd.DataFrame({"protein": names, "conformation": "", "job": "", "sentence": "Odd."})
        table.to_csv(folder / "warnings.csv", index=False)
        known = values_of(folder, files)
        assert known["surfaces"]["proteins"] == names and known["warnings"] == [(names, "Odd.")]


def test_a_run_begins_with_what_failed_and_its_warnings(tmp_path):
    files, name = write_run(tmp_path), "<b>bad</b>"
    warnings = [("p", "c1", "", "Left out: `HEM` <x>."), ("q", "", "", "Cut short.")] * 2
    columns = ["protein", "conformation", "job", "sentence"]
    pd.DataFrame(warnings, columns=columns).to_csv(tmp_path / "warnings.csv", index=False)
    text = html_of(tmp_path, files, exclude=[(name, "no atoms & no hope.")])
    shown = Page(text).text
    assert "<b>bad" not in text and "1 part of this run could not be finished." in shown
    wanted = [
        f"{name}: no atoms & no hope.",
        "2 warnings",
        "p: Left out: HEM <x>.",
        "q: Cut short.",
        "d = 2.51",
    ]
    assert [shown.index(words) for words in wanted] == sorted(shown.index(words) for words in wanted)
    assert '<details class="note" open>' in text
    many = pd.DataFrame([("p", "c1", "", f"No {'x' * k}.") for k in range(50)], columns=columns)
    many.to_csv(tmp_path / "warnings.csv", index=False)
    text = html_of(tmp_path, files)
    assert "50 warnings" in text and '<details class="note">' in text and "warnings.csv" in Page(text).links


def test_warnings_that_differ_in_numbers_only_are_reported_once(tmp_path):
    sentences = [("p", "c1", "p/c1: 5.6 dots, A/7: few"), ("q", "c1", "q/c1: 5.71 dots, A/12: few")]
    sentences += [("q", "", f"/far/away/q{name}.pdb: left out 1 {name}") for name in "XY"]
    sentences += [("pairs", name, f"{name}, partner {k}: odd") for name in ("ab", "bc") for k in (1, 2)]
    table = pd.DataFrame(sentences, columns=["protein", "conformation", "sentence"])
    table.assign(job="").to_csv(tmp_path / "warnings.csv", index=False)
    text = first(tmp_path, write_run(tmp_path)).text
    assert "8 warnings" in text and "pairs/ab and 3 others alike: ab, partner 1: odd" in text
    assert "p and 1 other alike: 5.6 dots, A/7: few" in text and "5.71" not in text
    assert "q: qX.pdb: left out 1 X" in text and "far/" not in text


def test_pairs_are_answered_over_all_or_by_partner(tmp_path):
    scores = {"propensity_smoothed": (0.56, 0.6, 0.58, 0.58), "protrusion": (0.7, 0.7, 0.8, 0.6)}
    rows = [
        (pair, side, score, auc, auc - 0.1, auc + 0.2)
        for score, aucs in scores.items()
        for (pair, side), auc in zip((("007", 1), ("007", 2), ("b", 1), ("b", 2)), aucs, strict=True)
    ]
    table = pd.DataFrame(rows, columns=["complex", "partner", "score", "auc", "low", "high"])
    files = [f"pairs/{name}/agreement.csv" for name in ("007", "b", "apart")] + ["pairs/b/propensity.csv"]
    known = values_of(tmp_path, write_run(tmp_path))

    def shown(table):
        return Page(
            render(first_page.TEMPLATE, **known | {"pairs": pairs_section.pairs_section(table, files)})
        )

    page = shown(table)
    assert (
        "AUC 0.58 (0.58 to 0.58) for smoothed complementarity finding the interface, over 2 pairs"
        in page.text
    )
    assert "It beats a coin. Protrusion alone has 0.70 (0.70 to 0.70)." in page.text
    rows = [
        ["007", "1", "0.56 (0.46 to 0.76)", "0.70 (0.60 to 0.90)", ""],
        ["apart", "", "no interface", "–", ""],
    ]
    assert all(row in page.rows for row in rows) and "pairs/b/propensity.csv" in page.links
    single = shown(table[table["complex"] == "b"]).text
    assert "AUC 0.58 (0.48 to 0.78) on partner 1, AUC 0.58 (0.48 to 0.78) on partner 2 for smoothed" in single
    assert "No interface among 3 pairs." in shown(table[:0]).text


def test_the_page_stands_alone_and_is_small(tmp_path):
    text = html_of(tmp_path, write_run(tmp_path, [(f"p{k}", "c1") for k in range(65)]))
    assert len(text.encode()) < 60_000 and {source[:23] for source in Page(text).sources} == {
        "data:image/webp;base64,"
    }
    assert not [link for link in Page(text).links if re.match(r"\w+:|//", link)]


def test_figures_beyond_the_size_of_a_page_are_read_from_the_folder(tmp_path, monkeypatch):
    files = write_run(tmp_path, [(f"p{k}", "c1") for k in range(3)])
    url = len(embedded_figures(tmp_path, ["p0/c1/figures/roughness.png"]).popitem()[1])
    monkeypatch.setattr("sparsurf.report.page.MAX_PAGE_BYTES", 2 * url)
    page = first(tmp_path, files)
    outside = [source for source in page.sources if not source.startswith("data:")]
    assert (
        outside
        and {*outside} <= {*files}
        and f"holds its figures, except the last {len({*outside})}" in page.text
    )


def test_names_are_escaped_everywhere(tmp_path):
    name = "<b>x&y"
    known = values_of(tmp_path, write_run(tmp_path))
    known["run"], known["galleries"] = name, [(name, [], [(f"{name}/view.html", "", "view")])]
    known["taken"], known["changes"] = (
        [(f"{name}/minimal.csv", name)],
        [(name, {"n": 1, "residues": 3, "chance": 0})],
    )
    text = render(first_page.TEMPLATE, **known)
    assert (
        "<b>x" not in text
        and "&lt;b&gt;x&amp;y" in text
        and not [link for link in Page(text).links if "<" in link]
    )


def test_one_frame_has_no_spread():
    table = pd.DataFrame(
        {"N": [100], "area": 10.0, "mean_roughness": 0.5, "n_S_percent": 40.0, "d_kept": 2.0}
    )
    page = Page(render(ensemble_page.TEMPLATE, **ensemble_page.ensemble_page("p", table, [1, 0, 6, 0])))
    assert "Over 1 frame, combination (1, 0, 6, 0) keeps 40.0 % of the dots." in page.text
    assert ["d among the kept dots", "2.00", "–", "2.00", "2.00"] in page.rows


@pytest.mark.parametrize(
    ("related", "tests", "words"),
    [
        (1, 20, "does not predict"),
        (3, 20, "does not predict"),
        (4, 20, "goes with"),
        (0, 0, "No range of n_S can tell"),
    ],
)
def test_the_page_on_all_surfaces(related, tests, words):
    """The answer follows from the tests of ten proteins; rows and floors are those of the tables."""
    row = {
        "n_S_low_percent": 0.0,
        "n_S_high_percent": 12.4,
        "d": 1.25,
        "d_sd": 0.5,
        "n_winners": 3,
        "n_shared": 5,
    }
    row |= COMBINATION | {
        "n_surfaces": 7,
        "gain": 0.1,
        "gain_low": 0.05,
        "gain_high": 0.2,
        "reading": "kept",
    }
    p = [0.034] * related + [0.5] * (tests - related) + [np.nan]
    relation = pd.DataFrame([row] * len(p)).assign(p=p, range=range(1, len(p) + 1))
    surfaces = pd.DataFrame({"protein": [f"p{k}" for k in range(10)], "conformation": "c1", "N": 9000})
    surfaces = surfaces.assign(
        mean_roughness=0.61234, best_kept="1, 0, 6, 0", d_cv_kept=1.0, d_cv_low_kept=0.5
    )
    surfaces = surfaces.assign(d_cv_high_kept=1.5, required_percent_turned_full=[7.0] * 9 + [30.0])
    surfaces = surfaces.assign(required_percent_turned_recovered=[5.0] * 9 + [100.0])
    known = summary_page.summary_page("run", surfaces, relation, 3)
    page = Page(render(summary_page.TEMPLATE, **known))
    assert words in page.text and "two thirds of the draws" in page.text
    assert ["turned", "7 (7 to 30)", "5 (5 to all)"] in page.rows
    assert ["p0", "9,000", "0.612", "1, 0, 6, 0", "1.00 (0.50 to 1.50)"] in page.rows
    cells = ["0 – 12", "(1, 0, 6, 0)", "1.25 ± 0.50", "3 of 7", "5 of 7", "0.034", "0.10 (0.05 to 0.20)"]
    assert (cells if related else cells[:5]) in page.rows or related == 0


def test_two_forms_with_a_gap_a_mutation_and_a_buried_residue():
    table = pd.DataFrame({"chain": "", "residue": ["7", "8", "9"], "residue_name": ["LYS", "ALA", "GLY"]})
    table = table.assign(
        residue_name_second=["GLU", "ALA", "GLY"], total=[0.6, np.nan, 0.3], total_moved=[0.3, np.nan, 0.1]
    )
    table = table.assign(
        total_floor=[0.2, np.nan, 0.2], above=[1, 0, 1], above_moved=[1, 0, 1], charge=0.4, charge_floor=0.3
    )
    table = table.assign(
        potential_difference=-1.26, hydropathy_difference=0.04, potential=0.9, potential_floor=0.3
    )
    own = changes_page.changes_page("opening", ["open", "closed/f7"], table, SHARE_ABOVE_FLOOR, ["", "A:1-5"])
    page = Page(render(changes_page.TEMPLATE, **own))
    assert "2 of 2 residues change more than fresh dots explain; 0 would by chance. 2 change" in page.text
    assert ["LYS7 → GLU", "0.60", "0.20", "0.30", "potential, charge", "−1.3", "0.0"] in page.rows
    for words in (
        "differ all over",
        "A:1-5 of closed/f7",
        "1 residue has another name",
        "1 residue is buried",
    ):
        assert words in page.text
    assert "differ all over" not in render(changes_page.TEMPLATE, **own | {"n_moved": 1})


@pytest.mark.parametrize(("percent", "every"), [(99.99, False), (99.996, True), (100.0, True)])
def test_every_dot_is_kept_where_all_decimals_say_so(percent, every):
    row = COMBINATION | {
        "n_S_percent": percent,
        "n_best_set": 3.0,
        "d_cv": 0.2,
        "d_cv_low": 0.1,
        "d_cv_high": 0.3,
    }
    assert best_of(row)["every_dot"] is every
