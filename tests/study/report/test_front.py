"""The first page of a run: its answers and sections against its tables."""

import base64
import hashlib
import io
import itertools
import json
import re

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text
from PIL import Image

from parsed_pages import Page
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.version import __version__
from sparsurf.views import layout
from sparsurf_study.report import page as pages
from sparsurf_study.report.first_page import surfaces
from sparsurf_study.report.first_page.pairs import verdict_of
from sparsurf_study.report.front import warned, write_front
from sparsurf_study.report.provenance import RunOrigin
from sparsurf_study.report.summaries import summarise_comparison, summarise_pairs

D = {"kept": [0.5, 2.42, 2.6, 0.2], "full": [-0.13, -0.26, -0.3, -0.1]}  # by range
BEST = (1.0, 0.0, 4.0, 6.0)  # of the second range
ALPHA = {"kept": 0.8, "full": 0.6}  # of the others


def write_run(folder, places=("p/c1",), errors=(0.02,)):
    """Write the tables of surfaces with a grid, of unequal sizes, and return the paths of the run."""
    rows = [
        {"protein": place.split("/")[0], "conformation": place.split("/")[1], "reading": reading, "range": k + 1}
        | dict(zip(("alpha", "beta", "gamma", "delta"), BEST if k == 1 else (ALPHA[reading], 0.2, 2.0 * k, 10.0), strict=True))
        | {"n_S_low_percent": 25.0 * k, "n_S_high_percent": 25.0 * k + 25, "n_S": 100.0 * k + 30, "n_S_percent": 25 * k + 18.0}
        | {"d_kept_scaled": -0.5 - k, "d_low_kept_scaled": -0.6 - k, "d_high_kept_scaled": -0.4 - k}
        | {"d_cv": d + s, "d_cv_low": d + s - 0.25, "d_cv_high": d + s + 0.3, "Z_tS": 3.0 - k, "Z_mean_descriptor": 1.5}
        for s, place in zip((0, 1, 2, 5, *range(6, 99)), places, strict=False)  # the mean of four is not their median
        for reading, of in D.items()
        for k, d in enumerate(of)
    ]  # fmt: skip
    summary = pd.DataFrame(rows)
    surfaces = pd.DataFrame([place.split("/") for place in places], columns=["protein", "conformation"])
    n = np.arange(1, len(places) + 1)
    surfaces = surfaces.assign(
        N=1000 * n, area=200.0 * n, mean_roughness=0.5 + 0.1 * n, minimal_n_S=40 + 5 * n, minimal_n_S_percent=8.0 / n,
        minimal_n_S_percent_low=7.0 / n, minimal_n_S_percent_high=9.0 / n, minimal_density=0.2 * n**2,
        recovered_mean=errors, recovered_high_99=5 * np.array(errors), recovered_largest=10 * np.array(errors),
        recovered_Z_published=0.5, recovered_Z_rotation_robust=0.7, best_kept="x", best_full="x",
    )  # fmt: skip
    relation = summary.drop_duplicates(["reading", "range"]).assign(p=[0.01, 0.5, np.nan, 0.02] * 2)
    relation["d"] = relation["d_cv"]
    for name, table in (("summary", summary), ("surfaces", surfaces), ("relation", relation)):
        folder.mkdir(parents=True, exist_ok=True)
        table.to_csv(folder / f"{name}.csv", index=False)
    of_all = summary[(summary["reading"] == "kept") & (summary["range"] == 2)].iloc[0].to_dict()
    winner = of_all | {
        "d_cv": 9.99,
        "d_cv_low": 9.0,
        "d_cv_high": 11.0,
        "n_best_set": 36,
    }  # as chosen over the whole grid: not shown
    none = {"answer": "No combination keeps so few."}
    best = {"combinations": 1296, "max_n_S_percent": 20, "references": {"Z_mean_descriptor": 1.5}}
    best |= {reading: {"unrestricted": winner, "under_max_n_S": none} for reading in D}
    grid = pd.DataFrame({"n_S_percent": [winner["n_S_percent"], 99.99995]})
    for place in places:
        (folder / place / "figures").mkdir(parents=True)
        (folder / place / "pictures").mkdir()
        (folder / place / "best.json").write_text(json.dumps(best))
        (folder / place / "recovered.csv").write_text("where\n")
        grid.to_csv(folder / place / "grid.csv", index=False)
        Image.new("RGB", (200, 100), "red").save(folder / place / "figures" / "d_over_grid.png")
    return [path.relative_to(folder).as_posix() for path in sorted(folder.rglob("*.*"))]


def text_of(folder):
    """What a reader sees of the first page, without its glossary."""
    return page_of(folder).words


def page_of(folder):
    """The first page of a run."""
    return Page((folder / "index.html").read_text())


def enlarged(page):
    """The pictures of a page that a click enlarges."""
    return page.find("img", inside="zoom")


@pytest.mark.parametrize(
    ("n_atoms", "words"),
    [([57], "57 atoms (0.28 per Å²{})"), ([300, 92, 60], "92 atoms (0.23 per Å²{})")],
)
def test_the_card_of_the_dots_says_how_many_atoms_determine_the_surface(tmp_path, n_atoms, words):
    """Of surfaces of 200, 400 and 600 Å²: the median of the densities is not the density of the medians."""
    places = [f"{name}/c1" for name in "abc"[: len(n_atoms)]]
    files = write_run(tmp_path, places, [0.02] * len(places))
    paths = [f"{place}/surface_atoms.csv" for place in places]
    for path, n in zip(paths, n_atoms, strict=True):
        pd.DataFrame({"atom": range(n)}).to_csv(tmp_path / path, index=False)
    answers = write_front(tmp_path / "index.html", [*files, *paths], {})
    page, sentence = page_of(tmp_path), f"{words} determine the surface exactly"
    assert sentence.format(", median" * (len(places) > 1)) in page.words
    assert any(sentence.format("") in answer for answer in answers)
    of_card = [link.attributes["href"] for link in page.find("a", inside="card")]
    assert (paths[0] in of_card) == (len(places) == 1)


@pytest.mark.parametrize(
    ("structure", "is_own"), [("my/protein.pdb", True), ("data/tdp43/topology.pdb", False)]
)
def test_the_page_of_a_protein_of_the_reader_begins_with_its_residues(tmp_path, structure, is_own):
    files = [*write_run(tmp_path), "p/c1/residues.csv"]
    residues = pd.DataFrame({"chain": ["A"], "residue": "7", "residue_name": "ALA", "mean_roughness": 0.6})
    residues.assign(area=22.4, dots=70).to_csv(tmp_path / "p/c1/residues.csv", index=False)
    write_front(tmp_path / "index.html", files, {}, origin=RunOrigin(inputs=[structure]))
    text = page_of(tmp_path).words
    is_asked = page_of(tmp_path).find("h1")[0].text.startswith("Which dots")
    assert is_asked != is_own
    assert (text.index("Which residues are rough?") < text.index("better than random dots?")) == is_own


def test_the_answer_that_counts_is_the_first_and_the_best_combination_has_one_value_everywhere(tmp_path):
    files = write_run(tmp_path)
    answers = write_front(tmp_path / "index.html", files, {})
    condition = "only the largest island is kept"
    assert answers == [
        "Is the paper's sampling better than random dots? No: in none of the 4 size ranges is the sampling significantly"
        " better than random dots on the full surface.",
        "The authors' own test says yes in 3 of 4, but it also counts how patches fall apart.",
        "Best parameters: (α, β, γ, δ) = (1, 0, 4, 6), which keep 43 % of the dots; the cross-validated d is"
        " 2.42 (2.17 to 2.72) if"
        f" {condition} in each subset, as in the authors' code. 35 other combinations are statistically"
        " indistinguishable.",
        "Sufficient subset (minimal.csv): 45 dots, 8.0 % of all, 0.20 per Å². The surface reconstructed from it deviates"
        " by 0.020 Å on average, 99 % of it by up to 0.100 Å, and no part by more than 0.20 Å.",
    ]
    page = page_of(tmp_path)
    text = page.words
    assert (
        f"(1, 0, 4, 6) 43 % of the dots are kept; the cross-validated d is 2.42 (2.17 to 2.72) if {condition} in each"
        " subset, as in the authors' code. 35 other combinations are" in text
    )
    assert text.index("No: in none of the 4 size") < text.index("says yes in 3 of 4,") and "9.99" not in text
    assert (
        "45 dots The dots are 8.0 % of all, 0.20 per Å². The surface reconstructed from these dots"
        " deviates by 0.020 Å on average, 99 % of it by up to 0.100 Å, and no part by more than 0.20 Å."
        in text
    )
    of_range = next(row for row in page.rows if row[0] == "25 to 50 %")
    assert of_range[:3] == ["25 to 50 %", "(1, 0, 4, 6) best", "2.42 (2.17 to 2.72)"]
    assert of_range[4:] == ["−0.26 (−0.51 to 0.04)", "(1, 0, 4, 6)"]
    assert of_range[3].startswith("(1, 0, 4, 6) keeps 43.0 % of the dots")  # on hover over the drawing
    of_range = next(row for row in page.rows if row[0] == "50 to 75 %")
    assert of_range[1:3] == ["(0.8, 0.2, 4, 10)", "2.60 (2.35 to 2.90)"]
    assert of_range[4:] == ["−0.30 (−0.55 to 0.00)", "(0.6, 0.2, 4, 10)"]
    assert [row[1].endswith("best") for row in page.rows if "to" in row[0]] == [False, True, False, False]


@pytest.mark.parametrize(
    ("n_surfaces", "readings", "full", "kept", "answer", "other"),
    [
        (1, "both", -1, 1, "No: in none of the 4 size ranges is", "yes in 4 of 4, but"),
        (1, "both", 1, 1, "Yes: in all 4 size ranges the", "yes in 4 of 4, but"),
        (2, "both", -1, -1, "No: in none of the 8 size ranges of both surfaces is", "yes in none of 8."),
        (3, "both", 1, -1, "Yes: in all 12 size ranges of all 3 surfaces the", "yes in none of 12."),
        (1, "both", np.nan, np.nan, "Undecided: d", "own test is undecided."),
        (1, "kept", 0, 1, "Yes: in all 4 size ranges the", "This is the authors' own test,"),
    ],
)
def test_the_answer_counts_size_ranges_and_surfaces(
    tmp_path, n_surfaces, readings, full, kept, answer, other
):
    files = write_run(tmp_path, [f"{name}/c1" for name in "abc"[:n_surfaces]], [0.02] * n_surfaces)
    summary = pd.read_csv(tmp_path / "summary.csv")
    d = summary["reading"].map({"full": full, "kept": kept}).astype(float)
    summary = summary.assign(d_cv=d, d_cv_low=d - 0.1, d_cv_high=d + 0.1)
    if readings == "kept":
        summary = summary[summary["reading"] == "kept"]
        surfaces = pd.read_csv(tmp_path / "surfaces.csv").drop(columns="best_full")
        surfaces.to_csv(tmp_path / "surfaces.csv", index=False)
    summary.to_csv(tmp_path / "summary.csv", index=False)
    answers = " ".join(write_front(tmp_path / "index.html", files, {}))
    for text in (answers, text_of(tmp_path)):
        assert answer in text and other in text and text.index(answer) < text.index(other)


@pytest.mark.parametrize(
    ("decided_by", "minimal", "limit", "reconstruction", "words"),
    [
        ("99 % back", {"error": 0.02}, "1 % of the reconstructed surface may deviate by more than 0.1 Å;",
         "spheres", "atoms are inferred"),
        ("99 % forth", {"error": 0.03, "error_99": 0.2}, "1 % of the true surface may deviate by more than 0.2 Å;",
         "interpolant", "interpolated between"),
    ],
)  # fmt: skip
def test_the_second_limit_of_the_error_and_the_reconstruction_are_named(
    tmp_path, decided_by, minimal, limit, reconstruction, words
):
    """The limit where it decides, on the page and, of the reconstruction, on the terminal as well."""
    files = write_run(tmp_path)
    table = pd.DataFrame({"decided_by": [decided_by], "reconstruction": reconstruction})
    table.to_csv(tmp_path / "p/c1/recovered.csv", index=False)
    answers = write_front(tmp_path / "index.html", files, {}, minimal=minimal)
    assert limit in text_of(tmp_path) and f"below {minimal['error']} Å." in text_of(tmp_path)
    assert words in text_of(tmp_path) and words in answers[-1]


def test_d_is_drawn_in_its_row_to_scale(tmp_path):
    """Left of the line at 0 where the sampling is worse, and as far from it as d says."""
    write_front(tmp_path / "index.html", write_run(tmp_path), {})
    page = page_of(tmp_path)
    zero = float(page.find("zero")[0].attributes["x1"])
    dots = [dot.attributes for dot in page.find("circle")]
    drawn = [float(dot["cx"]) - zero for dot in dots if dot["r"] == "3.5"]
    scale = drawn[2] / D["kept"][1]
    expected = [d * scale for pair in zip(D["kept"], D["full"], strict=True) for d in pair]
    np.testing.assert_allclose(drawn, expected, atol=0.11)
    assert scale > 20
    bars = [line.attributes for line in page.find("line", inside="mark")]
    ends = [(float(bar["x1"]) - zero, float(bar["x2"]) - zero) for bar in bars]
    wanted = [
        (scale * (d - 0.25), scale * (d + 0.3))
        for pair in zip(D["kept"], D["full"], strict=True)
        for d in pair
    ]
    np.testing.assert_allclose(ends, wanted, atol=0.15)
    numbers = {float(mark.text.replace("−", "-")): float(mark.attributes["x"]) for mark in page.find("text")}
    assert len(numbers) > 3 and min(numbers) < 0
    np.testing.assert_allclose([x - zero for x in numbers.values()], [scale * d for d in numbers], atol=0.15)
    said = [drawing.attributes["aria-label"] for drawing in page.find("svg", inside="tbody")]
    for words, row in zip(said, [row for row in page.rows if "to" in row[0]], strict=True):
        assert row[2] in words and row[4] in words


def test_subsets_that_fall_apart_are_marked_where_the_table_says_so(tmp_path):
    files = write_run(tmp_path)
    summary = pd.read_csv(tmp_path / "summary.csv")
    write_front(tmp_path / "index.html", files, {})
    assert "fragmented" not in text_of(tmp_path) and "link / spacing" not in text_of(tmp_path)
    summary = summary.assign(link_over_spacing=0.8, share_in_island=[0.2, 0.6, 0.4, 0.9] * 2)
    summary.to_csv(tmp_path / "summary.csv", index=False)
    write_front(tmp_path / "index.html", files, {})
    rows = [row for row in page_of(tmp_path).rows if "to" in row[0]]
    assert [row[4] for row in rows] == ["0.80 fragmented", "0.80", "0.80 fragmented", "0.80"]
    assert "2 of the 3 better subsets are fragmented." in text_of(tmp_path)


def test_a_page_says_what_the_run_was_started_with(tmp_path):
    (tmp_path / "p.pdb").write_text("a structure")
    (tmp_path / "q.pdb").write_text("another")
    origin = RunOrigin(
        "make run CONFIG=mine.yaml",
        [str(tmp_path / f"{name}.pdb") for name in ("p", "gone", "q")],
        3,
        ["numpy 1.9 and 2.4", "numba 0.61"],
    )
    write_front(tmp_path / "index.html", write_run(tmp_path), {}, origin=origin)
    page = page_of(tmp_path)
    text = " ".join([page.words, *(told.text for told in page.find("dl"))])
    assert "with make run CONFIG=mine.yaml" in text
    assert "Computed with numpy 1.9 and 2.4, numba 0.61." in text
    places = [text.rindex(hashlib.sha256(content).hexdigest()) for content in (b"a structure", b"another")]
    assert text.rindex("p.pdb") < places[0] < text.rindex("q.pdb") < places[1]  # each beside its file
    assert "gone.pdb" not in text and __version__ in text


def test_a_winner_that_keeps_the_most_dots_stands_below_the_ranges_though_they_are_rounded(tmp_path):
    files, path = write_run(tmp_path), tmp_path / "p/c1/best.json"
    best = json.loads(path.read_text())
    best["full"]["unrestricted"] |= {"alpha": 1.0, "delta": 0.0, "n_S_percent": 99.99995, "Z_tS": 0.0}
    path.write_text(json.dumps(best))
    write_front(tmp_path / "index.html", files, {})
    assert text_of(tmp_path).count("leaves it out of the last range") == 1
    assert (
        "Outside of these ranges, (1, 0, 4, 0) has d = 9.99 (9.00 to 11.00) on the full surface."
        in text_of(tmp_path)
    )


def test_answers_count_ranges_and_surfaces_where_there_are_many(tmp_path):
    places = ["a/c1", "b/c1", "c/c1", "d/c1"]
    files = write_run(tmp_path, places, (0.02, 0.03, 0.05, 0.09))
    summary = pd.read_csv(tmp_path / "summary.csv")
    lost = (summary["protein"] == "b") & (summary["reading"] == "full") & (summary["range"] == 1)
    summary.assign(d_cv_low=summary["d_cv_low"].mask(lost, -0.1)).to_csv(
        tmp_path / "summary.csv", index=False
    )
    answers = write_front(tmp_path / "index.html", files, {})
    above = sum(d + s - 0.25 > 0 for s in range(4) for d in D["full"]) - 1  # b still has others
    assert f"In {above} of 16 size ranges, on 3 of 4 surfaces," in answers[0]
    assert answers[2].startswith(
        "Best parameters on average over 4 surfaces: (α, β, γ, δ) = (0.8, 0.2, 4, 10)"
    )
    assert "median of 4 surfaces: 3.3 % of the dots, 1.30 per Å²." in answers[3]
    assert "by 0.040 Å on average, 99 % of it by up to 0.450 Å, and no part by more than" in answers[3]
    page = page_of(tmp_path)
    (row,) = [row for row in page.rows if row[0].startswith("25 ") and "to 7.42" in row[2]]
    assert row[:3] == ["25 to 50 %", "(1, 0, 4, 6)", "3.92 (2.42 to 7.42)"]
    assert row[3:] == ["(1, 0, 4, 6)", "1.24 (−0.26 to 4.74)"]
    text = text_of(tmp_path)
    assert "In 4 of 6 tests" in text and "the reconstructed and the true surface is 0.90 Å" in text


def test_fields_are_those_of_the_minimal_subset(tmp_path):
    """The median over the surfaces, which is not the mean."""
    places = {"p/c1": 0.912, "q/c1": 0.6, "r/c1": 0.4}
    files = write_run(tmp_path, [*places], (0.02, 0.03, 0.04))
    for place, r in places.items():
        rows = [("charge", "minimal", r), ("charge", "farthest", 0.5), ("flat", "minimal", np.nan)]
        table = pd.DataFrame(rows, columns=["field", "subset", "r"])
        table.to_csv(tmp_path / place / "fields.csv", index=False)
    write_front(tmp_path / "index.html", [*files, *(f"{place}/fields.csv" for place in places)], {})
    assert "correlate with the true ones at the other dots: charge (r = 0.600)." in text_of(tmp_path)


def test_failures_and_warnings_stand_above_the_sections(tmp_path):
    files = write_run(tmp_path)
    rows = [("p", "c1", "j", "/x/p.pdb: it lacks 3 atoms"), ("q", "", "j", "/x/q.pdb: it lacks 12 atoms")]
    pd.DataFrame(rows, columns=["protein", "conformation", "job", "sentence"]).to_csv(
        tmp_path / "warnings.csv", index=False
    )
    assert warned(tmp_path / "warnings.csv") == [(["p/c1", "q"], "p.pdb: it lacks 3 atoms")]
    write_front(tmp_path / "index.html", files, {"bad": "holds no <atoms>"})
    text = text_of(tmp_path)
    assert text.index("holds no <atoms>") < text.index("it lacks 3 atoms") < text.index("Best parameters by")


def test_forms_are_listed_by_their_change_over_the_larger_floor(tmp_path):
    folder = tmp_path / "changes" / "opening"
    folder.mkdir(parents=True)
    table = pd.DataFrame(
        {"chain": "A", "residue": range(1, 41), "residue_name": "GLY", "residue_name_second": "GLY"}
    )
    table = table.assign(
        total=np.arange(40.0), total_floor=2.0, total_moved=np.where(table.index == 39, 100, 1.0)
    )
    table["above_moved"] = table["total"] > table[["total_floor", "total_moved"]].max(axis=1)
    table = table.assign(shape=1.0, shape_floor=0.5, potential_difference=-1.26, hydropathy_difference=0.04)
    table = table.assign(potential=2.0, potential_floor=1.5, hydropathy=0.9, hydropathy_floor=0.2)
    table.loc[5, ["total", "above_moved"]] = np.nan, False
    table.loc[[5, 38], "residue_name_second"] = "ALA"  # also of a buried residue
    table.to_csv(folder / "changes.csv", index=False)
    answers = write_front(tmp_path / "index.html", ["changes/opening/changes.csv"], {})
    assert "opening: 35 of 39 residues change more" in answers[0] and "about 2 would" in answers[0]
    assert answers[0].endswith("Most residues exceed the noise floor: use the ranking, not the count.")
    assert "Which residues of opening change most? A:GLY39 → ALA, A:GLY38, A:GLY37 35 of 39" in text_of(
        tmp_path
    )
    assert "1 residue is buried in one form or both and has no value." in text_of(tmp_path)
    assert "2 residues have another name in the second form." in text_of(tmp_path)
    page = page_of(tmp_path)
    shown = [row for row in page.rows if row[0].startswith("A:")]
    assert [row[0] for row in shown[:2]] == ["A:GLY39 → ALA", "A:GLY38"] and len(shown) == 10
    assert shown[0][1:] == ["19.0", "38.00", "2.00", "1.00", "hydropathy, shape", "−1.3", "0.0"]
    other = tmp_path / "changes" / "closing"
    other.mkdir()
    chained = table.assign(chain=np.where(table.index < 20, "", "B"), total=table["total"][::-1].to_numpy())
    chained.assign(above_moved=table.index < 3).to_csv(other / "changes.csv", index=False)
    both = [f"changes/{name}/changes.csv" for name in ("opening", "closing")]
    answers = write_front(tmp_path / "index.html", both, {})
    assert [answer.split(" residues")[0] for answer in answers] == ["opening: 35 of 39", "closing: 3 of 39"]
    assert "Which residues of closing change most? GLY1, GLY2, GLY3 3 of 39" in text_of(tmp_path)
    table.loc[:10, ["total", "above_moved"]] = np.nan, False
    table.to_csv(folder / "changes.csv", index=False)
    answers = write_front(tmp_path / "index.html", ["changes/opening/changes.csv"], {})
    assert (
        "opening: 28 of 29 residues" in answers[0] and "about 1 would" in answers[0]
    )  # 5 % of 29, not of 40


def test_a_run_with_a_grid_and_forms_and_frames_answers_each_once(tmp_path):
    """First the grid, then the subset, the forms and the frames, on the page as on the terminal."""
    files = write_run(tmp_path)
    (tmp_path / "changes/bend").mkdir(parents=True)
    names = {"chain": "A", "residue": [7, 8], "residue_name": "GLY", "residue_name_second": "GLY"}
    table = pd.DataFrame(names).assign(
        total=[1.0, 3], total_floor=2.0, total_moved=1.0, above_moved=[False, True]
    )
    table = table.assign(potential_difference=0.0, hydropathy_difference=0.0)
    table.to_csv(tmp_path / "changes/bend/changes.csv", index=False)
    frames = pd.DataFrame(
        {"N": [1000, 1100], "area": [200.0, 210], "n_S_percent": [40.0, 41], "mean_roughness": 0.5}
    )
    frames.to_csv(tmp_path / "p/ensemble.csv", index=False)
    answers = write_front(tmp_path / "index.html", [*files, "changes/bend/changes.csv", "p/ensemble.csv"], {})
    starts = [
        "Is the paper's sampling",
        "The authors' own test",
        "Best parameters",
        "Sufficient",
        "bend: 1 of 2",
        "p: over 2",
    ]
    assert [answer[: len(start)] for answer, start in zip(answers, starts, strict=True)] == starts
    page = page_of(tmp_path)
    shown = [row[0] for row in page.rows if row[0].startswith("A:") or row[0] == "mean roughness"]
    assert shown == ["A:GLY8", "A:GLY7", "mean roughness"]
    text = text_of(tmp_path)
    heads = [
        "Best parameters (α",
        "How many dots are enough?",
        "Which residues of bend",
        "How many dots of p are kept",
    ]
    assert [text.count(head) for head in heads] == [1] * 4 and sorted(heads, key=text.index) == heads


@pytest.mark.parametrize("touching", [0, 1, 2])
def test_pairs_are_judged_next_to_protrusion(tmp_path, touching):
    rows = [
        {
            "complex": f"c{k}",
            "partner": side,
            "score": score,
            "auc": auc + 0.1 * k,
            "low": auc - 0.1,
            "high": auc + 0.1,
        }
        for k in range(touching)
        for side in (1, 2)
        for score, auc in (("propensity_smoothed", 0.4 + 0.1 * side), ("protrusion", 0.7))
    ]
    columns = ["complex", "partner", "score", "auc", "low", "high"]
    files = [
        "pairs/pairs.csv",
        *(f"pairs/c{k}/book.png" for k in range(2)),
        "pairs/c1/open.pml",
        "pairs/c1/view.html",
    ]
    (tmp_path / "pairs").mkdir()
    pd.DataFrame(rows, columns=columns).to_csv(tmp_path / "pairs" / "pairs.csv", index=False)
    (answer,) = write_front(tmp_path / "index.html", files, {})
    words = [
        "no interface to find",
        "0.50 (0.40 to 0.60) and 0.60 (0.50 to 0.70) on its two",
        "with an AUC of 0.60",
    ]
    assert words[touching] in answer
    rows = page_of(tmp_path).tables[0][1:]
    if touching == 2:
        assert re.search(r"protrusion alone has 0\.75 \(", answer) and "over 2 pairs that touch" in answer
        assert "AUC of 0.60 (0.00 to 1.00)" in text_of(tmp_path) and "over 2 pairs that touch" in text_of(
            tmp_path
        )
        assert rows[2:] == [
            ["c1", "1", "0.60 (0.40 to 0.60)", "0.80 (0.60 to 0.80)", "view.html open.pml"],
            ["", "2", "0.70 (0.50 to 0.70)", "0.80 (0.60 to 0.80)", ""],
        ]
    elif touching == 1:
        card = "AUC of 0.50 (0.40 to 0.60) and 0.60 (0.50 to 0.70) on partners 1 and 2; 0.5 is chance."
        assert card in text_of(tmp_path)
    elif touching == 0:
        assert rows[1] == ["c1", "", "no interface", "", "view.html open.pml"]


@pytest.mark.parametrize(
    ("aucs", "words"),
    [
        ((0.7, 0.8), "Better than chance"),
        ((0.55, 0.8), "Better than chance on partner 2 only"),
        ((0.8, 0.2), "Better than chance on partner 1 only"),
        ((0.55, 0.45), "No better than chance"),
        ((0.1, 0.2), "Worse than chance"),
    ],
)
def test_a_pair_is_judged_by_both_partners(aucs, words):
    assert verdict_of([[auc, auc - 0.1, auc + 0.1] for auc in aucs]) == words


@pytest.mark.parametrize(
    ("minimal", "question", "words"),
    [
        (
            {"error": 0.03},
            "How many dots are enough?",
            "reconstructed with a mean error of at most 0.03 Å, with nothing but the positions",
        ),
        (
            {"max_z": 1.5},
            "How many dots are enough?",
            "such that Z on the full surface is at most 1.5, with nothing",
        ),
        ({"percent": 20}, "How well do the kept dots", "The config asks for 20 % of the dots."),
        ({"n_dots": 4000}, "How well do the kept dots", "The config asks for 4,000 dots."),
        ({"density": 0.6}, "How well do the kept dots", "The config asks for 0.6 dots per Å²."),
        (
            {"sampler": "paper", "combination": [1, 0, 6, 0]},
            "How well do the kept dots",
            "asks for the dots that the combination (1, 0, 6, 0) keeps.",
        ),
    ],
)
def test_only_a_subset_that_was_asked_to_be_good_enough_is_called_sufficient(
    tmp_path, minimal, question, words
):
    (answer,) = write_front(tmp_path / "index.html", write_run(tmp_path), {}, minimal=minimal)[-1:]
    text = text_of(tmp_path)
    assert question in text and words in text
    assert answer.startswith("Sufficient subset" if "enough" in question else "Minimal subset (")
    assert ("sufficient" in text) == ("enough" in question)


@pytest.mark.parametrize(
    ("p", "n_runs", "n_combinations", "word"),
    [
        (0.06, 200, 1296, "Yes"),
        (0.04, 200, 1296, "No"),
        (0.06, 39, 1296, "Undecided"),
        (0.04, 40, 1296, "No"),
        (0.06, 200, 1295, "Undecided"),
    ],
)
def test_one_test_of_all_rows_decides_whether_table_1_is_reproduced(
    tmp_path, p, n_runs, n_combinations, word
):
    files = write_run(tmp_path)
    values = [(0.1, 0.2, 0.4, 0.6, 0.8, 1), (0, 0.2, 0.4, 0.6, 0.8, 1), range(0, 11, 2), range(0, 11, 2)]
    grid = pd.DataFrame(itertools.product(*values), columns=PARAMETERS).assign(n_S_percent=50.0)
    grid[:n_combinations].to_csv(tmp_path / "p/c1/grid.csv", index=False)
    places = pd.DataFrame(
        {"range": [1, 2, 3, 4], "d_inside": [1, 0, 0, 0], "Z_tS_inside": [1, 1, 0, 0], "n_runs": n_runs}
    )
    places = places.assign(
        alpha=1.0, beta=0.0, gamma=[6.0, 5, 4, 3], delta=0.0, d_published=[2.69, 1.5, -0.5, 0]
    )
    places = places[::-1]  # in whatever order
    tests = pd.DataFrame({"measure": ["d", "together"], "p": [p / 2, p]})
    for name, table in (("paper_places.csv", places), ("paper_tests.csv", tests)):
        table.to_csv(tmp_path / name, index=False)
    answer = write_front(tmp_path / "index.html", [*files, "paper_places.csv", "paper_tests.csv"], {})[0]
    assert f"Is Table I of the paper reproduced? {word}" in text_of(tmp_path)
    counted = "1 of 4 published values of d and 2 of 4"
    if word == "Undecided":
        counted = (
            "39 runs were made as published" if n_runs < 40 else "has 1,295 of the paper's 1,296 combinations"
        )
    assert counted in text_of(tmp_path)
    assert "verdict.html" not in page_of(tmp_path).links  # which this run does not have
    rows = [row[:3] for row in page_of(tmp_path).rows if "to" in row[0]]
    wanted = [
        ("(1, 0, 6, 0)", "2.69"),
        ("(1, 0, 5, 0)", "1.50"),
        ("(1, 0, 4, 0)", "−0.50"),
        ("(1, 0, 3, 0)", "0.00"),
    ]
    assert rows == [[f"{25 * k} to {25 * k + 25} %", *of] for k, of in enumerate(wanted)]
    starts = {
        "Yes": "Table I is reproduced",
        "No": "Table I is not reproduced",
        "Undecided": "It is undecided",
    }
    assert answer.startswith(starts[word]) and counted in answer
    if word == "Yes":
        more = ["paper_places.csv", "paper_tests.csv", "verdict.html", "table1.png"]
        write_front(tmp_path / "index.html", [*files, *more], {})
        page = page_of(tmp_path)
        (drawn,) = [picture for picture in enlarged(page) if picture.attributes["src"] == "table1.png"]
        counts = re.findall(r"\d+ of 4|\d+ runs", drawn.attributes["alt"])
        assert counts == ["1 of 4", "2 of 4", f"{n_runs} runs"] and "verdict.html" in page.links


def test_frames_are_summed_up_by_their_mean_and_their_ends(tmp_path):
    """By hand: the median of each column is another number than its mean."""
    (tmp_path / "p").mkdir()
    frames = pd.DataFrame({"N": [1000, 1100, 1800], "area": [200.0, 210, 280], "n_S_percent": [40.0, 41, 48]})
    frames = frames.assign(mean_roughness=[0.5, 0.52, 0.6], d_kept=[1.0, 2, 6], d_full=[-1.0, -2, -6])
    frames.to_csv(tmp_path / "p/ensemble.csv", index=False)
    files = ["p/ensemble.csv", "p/residues.csv", "p/figures/ensemble.png", "p/figures/residues.png"]
    (tmp_path / "a").mkdir()
    frames[:2].assign(n_S_percent=[20.0, 30]).to_csv(tmp_path / "a/ensemble.csv", index=False)
    (_, other) = write_front(
        tmp_path / "index.html",
        [
            *files,
            "a/ensemble.csv",
            "p/residues_over_time.csv",
            "a/figures/simulation.png",
            "a/simulation/quality.csv",
        ],
        {},
    )
    lines = text_of(tmp_path)
    assert "The simulation of a" in lines and "The simulation of p" not in lines
    sources = [picture.attributes["src"] for picture in enlarged(page_of(tmp_path))]
    assert "a/figures/simulation.png" in sources and "a/simulation/quality.csv" in page_of(tmp_path).links
    assert "residues_over_time.csv: the roughness of each residue in every frame" in lines
    assert "residues.csv: the roughness of each residue, mean over all frames" in lines
    assert other == (
        "a: over 2 frames, one combination keeps 25.0 % of the dots on average (20.0 to 30.0 %), and the mean roughness is"
        " 0.51 (0.50 to 0.52)."
    )
    assert "43 % (40 to 48 %) in 3 frames" in text_of(
        tmp_path
    ) and "25 % (20 to 30 %) in 2 frames" in text_of(tmp_path)
    answers = write_front(tmp_path / "index.html", files, {})
    assert answers == [
        "p: over 3 frames, one combination keeps 43.0 % of the dots on average (40.0 to 48.0 %), and the mean roughness is"
        " 0.54 (0.50 to 0.60)."
    ]
    page = page_of(tmp_path)
    text = page.words
    assert "How does the surface of" not in text and "43 % (40 to 48 %) in 3 frames" in text
    assert "The mean roughness is 0.54 (0.50 to 0.60)." in text and "One combination over 3 frames" in text
    assert page.rows == [
        ["measure", "mean", "standard deviation", "lowest", "highest"],
        ["dots", "1,300", "436", "1,000", "1,800"],
        ["area (Å²)", "230", "44", "200", "280"],
        ["mean roughness", "0.540", "0.053", "0.500", "0.600"],
        ["nS (%)", "43.0", "4.4", "40.0", "48.0"],
        ["d among the kept dots", "3.00", "2.65", "1.00", "6.00"],
        ["d on the full surface", "−3.00", "2.65", "−6.00", "−1.00"],
    ]
    kept = "The share of dots kept is 43.0 % on average, from 40.0 to 48.0 %."
    assert any(words.endswith(kept) for words in page.alternatives) and "p/residues.csv" in page.links


def test_each_part_of_a_surface_has_its_own_numbers_and_pictures(tmp_path, monkeypatch):
    files = write_run(tmp_path)
    pictures = [f"p/c1/pictures/{name}.png" for name in ("minimal", "roughness", "sampled")]
    for path in [*pictures, "p/c1/figures/roughness.png"]:
        Image.new("RGB", (640, 480), "red").save(tmp_path / path)
    residues = pd.DataFrame({"chain": "A", "residue": ["7", "8", "9"], "residue_name": ["ALA", "GLY", "LYS"]})
    residues = residues.assign(mean_roughness=[0.61, np.nan, 0.42], area=[22.4, 0, 30.6], dots=[70, 0, 1200])
    residues.assign(mean_hbond=[-0.5, np.nan, 0.25]).to_csv(tmp_path / "p/c1/residues.csv", index=False)
    files += [*pictures, "p/c1/figures/roughness.png", "p/c1/view.html", "p/c1/residues.csv"]
    files += ["p/c1/minimal.csv", "p/c1/ranges.csv", "summary.csv"]
    write_front(tmp_path / "index.html", files, {})
    page = page_of(tmp_path)
    text = page.words
    shown = [picture.attributes["alt"] for picture in enlarged(page)]
    assert shown[:3] == [
        "The surface of p in the colours of its roughness, with a mean of 0.60",
        "The dots that the best parameters keep on p: 43 % of all",
        "The 45 dots of the minimal subset of p",
    ]
    assert "with the best parameters keeps 43 % of the dots." in text and "45 dots are enough" in text
    assert "The 95 % interval of its share is 7.0 to 9.0 %." in text and "is 0.20 Å." in text
    alt = "The minimal subset has 0.20 dots per Å² and deviates by 0.020 Å on average."
    assert alt not in shown  # the figure is not among the files
    assert "How rough is the surface of p, and" in text and "1,296 combinations" in text
    assert "No combination keeps so few." in text
    heads = ["roughest residues", "mean roughness (1 is flat)", "area (Å²)", "dots", "mean hbond"]
    rows = [["LYS 9 A", "0.42", "31", "1,200", "0.25"], ["ALA 7 A", "0.61", "22", "70", "−0.50"]]
    assert [heads, *rows] in page.tables
    ends = "ranges from 0.42 (LYS 9 A) to 0.61 (ALA 7 A)."
    assert any(words.endswith(ends) for words in page.alternatives)
    assert {"p/c1/view.html", "p/c1/minimal.csv", "p/c1/residues.csv", "p/c1/ranges.csv"} <= {*page.links}
    surface = next(row for row in page.rows if row[1] == "p")
    assert surface[2:] == ["1,000", "200", "0.60", "45", "8.0", "0.020", "0.50", "0.70",
                           "minimal.csv residues.csv"]  # fmt: skip
    maps = next(words for words in shown if words.startswith("Maps of d"))
    assert re.findall(r"2\.42|\(1, 0, 4, 6\)|\d+ %", maps) == ["2.42", "(1, 0, 4, 6)", "43 %"]
    assert "This page is self-contained." in text
    size = max(len(picture.attributes["src"]) for picture in enlarged(page))
    monkeypatch.setattr(pages, "MAX_PAGE_BYTES", 2 * size + 9)
    write_front(tmp_path / "index.html", files, {})
    sources = [picture.attributes["src"] for picture in enlarged(page_of(tmp_path))]
    outside = [source for source in sources if not source.startswith("data:")]
    assert 1 < len(outside) < len(sources) and f"last {len(outside)} figures." in text_of(tmp_path)


def test_a_winner_of_few_dots_has_the_d_of_its_own_range(tmp_path):
    files, path = write_run(tmp_path), tmp_path / "p/c1/best.json"
    best = json.loads(path.read_text())
    own = {
        "alpha": 0.8,
        "beta": 0.2,
        "gamma": 0.0,
        "delta": 10.0,
        "n_S_percent": 18.0,
        "d_cv": 7.7,
        "d_cv_low": 7.0,
    }
    best["kept"]["under_max_n_S"] = own | {"d_cv_high": 8.0, "n_best_set": 1}
    path.write_text(json.dumps(best))
    write_front(tmp_path / "index.html", files, {})
    assert (
        "Among the combinations that keep at most 20 % of the dots, (0.8, 0.2, 0, 10) is best among the kept dots: it keeps"
        " 18.0 %, with d = 0.50 (0.25 to 0.80)." in text_of(tmp_path)
    )


def test_many_surfaces_stand_by_their_share_and_only_the_first_of_them(tmp_path, monkeypatch):
    places = ["a/c1", "b/f1", "b/f2", "d/c1"]
    files = [*write_run(tmp_path, places, (0.02, 0.03, 0.05, 0.09)), "surfaces.csv", "relation.csv"]
    files += [f"{place}/minimal.csv" for place in places]
    monkeypatch.setattr(surfaces, "MAX_ROWS", 3)
    write_front(tmp_path / "index.html", files, {"d/c1": "too `small`", "e": "gone"})
    page = page_of(tmp_path)
    assert [link.attributes["href"] for link in page.find("a", inside="card")] == ["surfaces.csv"]
    text = page.words
    rows = next(table for table in page.tables if table[0][1] == "surface")[1:]
    assert [row[1] for row in rows] == ["d", "b/f2", "b/f1"]  # 2, 2.7 and 4 %; c1 alone is not named
    assert rows[0][2:10] == ["4,000", "800", "0.90", "60", "2.0", "0.090", "0.50", "0.70"]
    assert "1 more surfaces are in surfaces.csv." in text
    assert "4 surfaces ·" in text and "How rough are the surfaces of a, b and d, and" in text
    assert "2 parts of this run could not be finished." in text and "d/c1: too small" in text
    assert (
        "Medians over 4 surfaces." in text and "are best on average over 4 surfaces: 68 % of the dots" in text
    )
    assert (
        "are kept; the cross-validated d is 2.60 if all but the largest" in text
        and "The 95 % interval of its share is 2.9 to 3.8 % (medians)." in text
    )
    cells = [cell for cell in page.find("td") if cell.text in ("4,000", "2.0")]
    keys = [cell.attributes["data-key"] for cell in cells if "data-key" in cell.attributes]
    assert keys == ["4000", "2.0"]


def test_two_surfaces_are_named_one_by_one(tmp_path):
    files = write_run(tmp_path, ["a/c1", "b/c1"], (0.02, 0.03))
    best = json.loads((tmp_path / "b/c1/best.json").read_text())
    best["kept"]["unrestricted"]["n_S_percent"] += 1
    (tmp_path / "b/c1/best.json").write_text(json.dumps(best))
    for place in ("a/c1", "b/c1"):
        Image.new("RGB", (640, 480), "red").save(tmp_path / place / "pictures/sampled.png")
        files.append(f"{place}/pictures/sampled.png")
    answers = write_front(tmp_path / "index.html", files, {})
    condition = "if only the largest island is kept in each subset, as in the authors' code"
    others = "35 other combinations are statistically indistinguishable."
    assert answers[2:4] == [
        "a: Best parameters: (α, β, γ, δ) = (1, 0, 4, 6), which keep 43 % of the dots; the cross-validated d is"
        " 2.42 (2.17 to 2.72)"
        f" {condition}. {others}",
        "b: Best parameters: (α, β, γ, δ) = (1, 0, 4, 6), which keep 44 % of the dots; the cross-validated d is"
        " 3.42 (3.17 to 3.72)"
        f" {condition}. {others}",
    ]
    text = text_of(tmp_path)
    assert "In 4 of 8 size ranges, on 1 of 2 surfaces," in text and "says yes in 7 of 8," in text
    assert "How rough are the surfaces of a and b, and how few dots describe them?" in text
    captions = re.findall(r"with the best parameters keeps (\d+)\s+% of the dots", text)
    assert captions == ["43", "44"]


@pytest.mark.parametrize("name", ["NA", "07"])
def test_each_surface_has_its_own_parts_where_one_was_not_sampled(tmp_path, name):
    """Whatever the order of the rows of a table; names remain as they are."""
    places = ["012/c1", f"{name}/c1"]
    files = write_run(tmp_path, places, (0.02, 0.03))
    for kind in ("summary", "surfaces"):
        table = pd.read_csv(tmp_path / f"{kind}.csv", dtype={"protein": str}, keep_default_na=False)
        table = table[table["protein"] == name] if kind == "summary" else table  # sampling: false of 012
        table[::-1].to_csv(tmp_path / f"{kind}.csv", index=False)
    for k, place in enumerate(places):
        rows = {"chain": ["B", "A"], "residue": ["7", "8"], "residue_name": "ALA", "area": 29.0, "dots": 70}
        table = pd.DataFrame(rows).assign(mean_roughness=[0.5 + 0.1 * k, 0.3 + 0.1 * k])
        table.to_csv(tmp_path / place / "residues.csv", index=False)
        pictures = [f"pictures/{picture}.png" for picture in ("roughness", "sampled", "minimal")]
        figures = ["figures/roughness.png", "figures/subsets.png"]
        for picture in pictures + figures:
            Image.new("RGB", (640, 480), ("red", "blue")[k]).save(tmp_path / place / picture)
        drawn = pictures + figures if k else [pictures[0], figures[0]]
        names = ("residues.csv", "minimal.csv", *drawn)
        files += [f"{place}/{each}" for each in names]
    write_front(tmp_path / "index.html", files, {})
    page = page_of(tmp_path)
    text = page.words
    rough = [[row[:2] for row in rows[1:]] for rows in page.tables if rows[0][0] == "roughest residues"]
    assert rough == [[["ALA 8 A", "0.30"], ["ALA 7 B", "0.50"]], [["ALA 8 A", "0.40"], ["ALA 7 B", "0.60"]]]
    shown = [picture.attributes["alt"] for picture in enlarged(page)]
    first, second = (
        np.asarray(Image.open(io.BytesIO(base64.b64decode(picture.attributes["src"].split(",")[1]))))[9, 9]
        for picture in enlarged(page)[:2]
    )
    assert first.argmax() == 0 and second.argmax() == 2  # red, and blue
    assert shown[:4] == [
        "The surface of 012 in the colours of its roughness, with a mean of 0.60",
        f"The surface of {name} in the colours of its roughness, with a mean of 0.70",
        f"The dots that the best parameters keep on {name}: 43 % of all",
        f"The 50 dots of the minimal subset of {name}",
    ]
    assert [each.split(": ")[0] for each in shown[-3:]] == [
        "012",
        name,
        name,
    ]  # one roughness and the subsets
    of_second = [table.around for table in page.find("ranges")]
    assert [[each.attributes["class"] for each in around if each.is_of("place")] for around in of_second] == [
        ["place place-1"]
    ]
    assert [head.text for head in page.find("h3", inside="place-1")].count(name) >= 1
    assert "was not applied to 012." in text and f"not applied to {name}" not in text
    assert "Yes: in all 4 size ranges the sampling" in text  # of the sampled one alone
    rows = [row[1:3] for row in page.rows if len(row) > 9 and row[1] in ("012", name)]
    assert rows == [["012", "1,000"], [name, "2,000"]]
    assert "Medians over 2 surfaces." in text and "6.0 % 0.50 per Å²" in text
    linked = [link.attributes["href"] for link in page.find("a", inside="card")]
    assert linked == [f"{place}/minimal.csv" for place in places]
    of_first = [
        link.attributes["href"] for link in page.find("a", inside="li") if "/" in link.attributes["href"]
    ]
    assert "belong to 012." in text and {path.split("/")[0] for path in of_first} == {"012"}


def test_a_run_on_pairs_shows_its_surfaces_and_does_not_ask_how_few_dots_are_enough(tmp_path):
    files = [path for path in write_run(tmp_path) if path not in ("summary.csv", "relation.csv")]
    (tmp_path / "pairs").mkdir()
    rows = [("x", side, score, 0.7) for side in (1, 2) for score in ("propensity_smoothed", "protrusion")]
    table = pd.DataFrame(rows, columns=["complex", "partner", "score", "auc"]).assign(low=0.6, high=0.8)
    table.to_csv(tmp_path / "pairs/pairs.csv", index=False)
    shown = []
    for more in ([], ["pairs/pairs.csv", "pairs/x/book.png"]):
        answers = write_front(tmp_path / "index.html", [*files, *more], {})
        page = page_of(tmp_path)
        assert any(row[1:3] == ["p", "1,000"] for row in page.rows)  # the table of surfaces
        asked = [head.text for head in page.find("h2") if head.text.startswith("How many dots")]
        assert bool(asked) != bool(more) == (not any("minimal.csv" in answer for answer in answers))
        shown.append((page.find("h1")[0].text, page.find("lede")[0].text))
    assert shown[0][0] != shown[1][0] and "partner" in shown[1][1] and "partner" not in shown[0][1]


def test_many_proteins_are_counted_in_the_heading(tmp_path):
    """Proteins, not their conformations."""
    places = ["a/f0", *(f"{name}/f1" for name in "abcdefg")]
    write_front(tmp_path / "index.html", write_run(tmp_path, places, [0.02] * len(places)), {})
    assert "the surfaces of 7 proteins, and" in page_of(tmp_path).find("h1")[0].text


def test_a_table_of_surfaces_is_sorted_by_its_numbers_and_searched(tmp_path, browser):
    places = [f"{name}/c1" for name in ("b", "7", "a", "e", "c")]
    errors = (0.02, 0.5, 0.03, 0.04, 0.01)
    write_front(tmp_path / "index.html", write_run(tmp_path, places, errors), {})
    browser.open(tmp_path / "index.html")
    shown = "return [...document.querySelector('.sortable').tBodies[0].rows].filter(row => !row.hidden)"
    shown += ".map(row => row.cells[1].textContent).join('')"
    head = "[...document.querySelectorAll('.sortable th button')].find(b => b.textContent === '{}').click();"
    for heading, clicks, order in (
        ("area (Å²)", 1, "cea7b"),  # 1,000 Å^2 and then 800
        ("area (Å²)", 1, "b7aec"),
        ("surface", 1, "7abce"),
        ("mean error (Å)", 1, "7eabc"),
        ("surface", 2, "ecba7"),
    ):
        assert browser.run(clicks * head.format(heading) + shown) == order
    find = "const e = document.querySelector('[type=search]'); e.value = '{}'; e.dispatchEvent(new Event('input'));"
    assert browser.run(find.format("0.500") + shown) == "7"
    assert browser.run(find.format("") + shown) == "ecba7"


def test_warnings_are_counted_and_alike_ones_stand_together(tmp_path):
    files = write_run(tmp_path)
    rows = [
        ("p", "c1", "j", "a gap"),
        ("q", "", "j", "a gap"),
        ("r", "", "j", "a gap"),
        ("s", "", "j", "a hole"),
    ]
    table = pd.DataFrame(rows, columns=["protein", "conformation", "job", "sentence"])
    table.to_csv(tmp_path / "warnings.csv", index=False)
    parts = {f"part {k}": f"reason {k}" for k in range(23)}
    write_front(tmp_path / "index.html", files, parts, broken=[("a.csv", "is `odd`.")])
    text = text_of(tmp_path)
    assert "4 warnings p and 2 others alike: a gap s: a hole All are in warnings.csv." in text
    assert "contradict one another" in text and "a.csv: is odd." in text
    blocks = page_of(tmp_path).blocks
    at = blocks.index("3 more")
    assert blocks[at - 1 : at + 2] == ["part 19: reason 19", "3 more", "part 20: reason 20"]
    assert "23 parts of this run" in text


@pytest.mark.parametrize(
    ("failed", "card"), [(["x", "y"], "2 structures failed"), (["x"], "1 structure failed")]
)
def test_a_run_in_batches_counts_its_surfaces_and_failures(tmp_path, failed, card):
    """By hand: the median of the roughness is not its mean, and the share is that of all dots."""
    of = pd.DataFrame({"protein": ["a", "b", "c"], "N": [1000, 2000, 9000], "minimal_n_S": [100, 300, 500]})
    of = of.assign(masked_residues=[3.0, np.nan, 4.0], residues=[50, 70, 90], atoms=[1500, 700, 3100])
    of = of.assign(mean_roughness=[0.5, 0.55, 0.9], area=[411.2, 1422.8, 10.0], volume=[2000.4, 30.0, 1.0])
    of = of.assign(components=[1, 2, 3], cavities=[4, 5, 6], deviation=[7.25, 8.0, 9.0], unusual="atoms")
    batches = {"surfaces": of, "unusual": of[:1], "failures": [("no atoms", failed)], "n_batches": 2}
    answers = write_front(tmp_path / "index.html", ["distributions.png"], {}, batches)
    assert answers == [
        "3 surfaces of molecules of 700 to 3,100 atoms: the minimal subsets keep 7.5 % of 12,000 dots, and the median of the"
        " mean roughness is 0.55 (0.50 to 0.90)."
    ]
    page = page_of(tmp_path)
    text = page.words
    n = 3 + len(failed)
    assert f"How many structures have a surface? 3 of {n} {card}: failures.csv says why." in text
    assert (
        "How rough are they? 0.55 is the median of the mean roughness, which ranges from 0.50 to 0.90;"
        in text
    )
    assert "How many dots are enough? 900 of 12,000 dots (7.5 %) are in the minimal subsets" in text
    assert (
        f"3 surfaces of {n} structures were computed in 2 batches. The molecules have 700 to 3,100 atoms."
        in text
    )
    assert "7 of 147 residues of 2 predicted models are left out" in text
    assert f"3 of {n} structures, and a sufficient subset" in text
    median = "Distributions over all surfaces. The median of the mean roughness is 0.55, from 0.50 to 0.90."
    assert median in page.alternatives
    row = ["a", "7.2", "atoms", "1,500", "411", "2,000", "0.50", "1", "4"]
    assert page.rows[1] == row and f"{', '.join(failed)}: no atoms" in text
    assert {"surfaces/", "residues/", "dots/", "failures.csv"} <= {*page.links}


def test_a_run_in_batches_without_failures_or_surfaces(tmp_path):
    of = pd.DataFrame(
        {"protein": ["a"], "N": [1000], "minimal_n_S": [100], "masked_residues": [np.nan], "residues": [9]}
    )
    of = of.assign(
        atoms=[70], mean_roughness=0.5, area=1.0, volume=1.0, components=1, cavities=0, deviation=1.0
    )
    batches = {"surfaces": of, "unusual": of[:0], "failures": [], "n_batches": 1}
    write_front(tmp_path / "index.html", [], {}, batches)
    text = text_of(tmp_path)
    assert "1 of 1 No structure failed." in text and "in 1 batch." in text and "predicted models" not in text
    assert "A surface was computed for each of 1 structures" in text
    none = batches | {"surfaces": of[:0], "failures": [("no atoms", [f"s{k}" for k in range(25)])]}
    answers = write_front(tmp_path / "index.html", [], {}, none)
    text = text_of(tmp_path)
    assert answers == ["No structure has a surface."] and "0 of 25 25 structures failed" in text
    assert "s19 and 5 more: no atoms" in text


@pytest.mark.parametrize(
    ("places", "subject", "band"),
    [
        (["a/c1"], "a/c1", "1 conformation"),
        (["a/c1", "a/c2"], "mean of 2 conformations", "2 conformations"),
        (["a/c1", "b/c1", "b/c2"], "mean of 2 proteins", "2 proteins"),
    ],
)
def test_a_comparison_over_all_says_what_its_means_are_over(tmp_path, monkeypatch, places, subject, band):
    figures = []
    monkeypatch.setattr(layout, "save", lambda figure, path: figures.append(figure))
    paths = [tmp_path / place / "compare.csv" for place in places]
    for k, path in enumerate(paths):
        rows = [
            (name, 10.0, 10.5, "surface", "Z full", z + k)
            for name, z in (("farthest", 1.0), ("uniform", 2.0))
        ]
        table = pd.DataFrame(rows, columns=["sampler", "percent", "n_S_percent", "use", "measure", "value"])
        path.parent.mkdir(parents=True)
        table.assign(low=0.9, high=9.0, Z_mean_descriptor=3.0, Z_resampled=0.4).to_csv(path, index=False)
    summarise_comparison(paths, tmp_path / "compare.csv", tmp_path / "compare.png")
    (figure,) = figures
    texts = " ".join(text.get_text() for text in figure.findobj(Text))
    assert f"{subject}: farthest point errs least" in texts and f"lowest to highest of {band}." in texts
    means = pd.read_csv(tmp_path / "compare.csv").set_index("sampler")
    wanted = {1: (1.0, 1.0, 1.0), 2: (1.5, 1.0, 2.0), 3: (1.75, 1.0, 2.5)}[len(places)]  # b: the mean of two
    assert means.loc["farthest", ["value", "lowest", "highest"]].tolist() == pytest.approx(wanted)
    shaded = figure.axes[0].collections[0].get_paths()[0].vertices[:, 1]  # of the first sampler
    assert (shaded.min(), shaded.max()) == pytest.approx(wanted[1:])


def test_a_word_is_explained_once_by_the_lengths_of_the_config(tmp_path):
    lengths = {"r_patch": 3.5, "r_zernike": 5.25, "interface": 2.5}
    write_front(tmp_path / "index.html", write_run(tmp_path), {}, lengths=lengths)
    page = page_of(tmp_path)
    patch = "the dots near a dot: within 3.5 Å for roughness and sampling, within 5.25 Å for descriptors"
    terms = page.find("abbr")
    explained = [term.text for term in terms if term.attributes["title"] == patch]
    assert len(explained) == 1 and explained[0].startswith("patch")
    listed = {head.text: told.text for head, told in zip(page.find("dt"), page.find("dd"), strict=True)}
    marked = {term.text for term in terms}
    assert listed["patch"] == patch and "interface" not in listed  # which this page does not name
    assert {word.removesuffix("es").removesuffix("s") for word in marked} >= {"dot", "Z", "d", "patch"}
    assert "island" in marked and "descriptor" in listed  # a word of the meaning of Z


def test_pairs_that_do_not_touch_have_no_rows(tmp_path):
    (tmp_path / "far").mkdir()
    columns = "partner,score,auc,low,high,dots,interface,blocks\n"
    (tmp_path / "far" / "agreement.csv").write_text(columns)
    outputs = [str(tmp_path / name) for name in ("pairs.csv", "pairs.png")]
    summarise_pairs([tmp_path / "far" / "agreement.csv"], "x", *outputs)
    assert len(pd.read_csv(outputs[0])) == 0 and (tmp_path / "pairs.png").exists()
