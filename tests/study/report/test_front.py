"""The first page of a run: its answers and sections against its tables."""

import base64
import hashlib
import io
import itertools
import json
import os
import re

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text
from PIL import Image

from conftest import ROOT
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
REVIEWED = (
    ROOT / "tests" / "study" / "report" / "pages"
)  # BASELINE=new writes them anew; read them before a commit


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


# ---- pages that are stored as texts


def one_surface(folder, **options):
    """The page of a surface with a grid."""
    return write_front(folder / "index.html", write_run(folder), {}, **options)


def surfaces_whose_d_is(full, kept, n_surfaces, readings=("kept", "full")):
    """Function that writes a page of surfaces with these d."""

    def write(folder):
        files = write_run(folder, [f"{name}/c1" for name in "abc"[:n_surfaces]], [0.02] * n_surfaces)
        summary = pd.read_csv(folder / "summary.csv")
        d = summary["reading"].map({"full": full, "kept": kept}).astype(float)
        summary = summary.assign(d_cv=d, d_cv_low=d - 0.1, d_cv_high=d + 0.1)
        summary[summary["reading"].isin(readings)].to_csv(folder / "summary.csv", index=False)
        if "full" not in readings:
            table = pd.read_csv(folder / "surfaces.csv").drop(columns="best_full")
            table.to_csv(folder / "surfaces.csv", index=False)
        return write_front(folder / "index.html", files, {})

    return write


def decided_by(limit, reconstruction, minimal):
    """Function that writes a page of a subset that a limit decided."""

    def write(folder):
        files = write_run(folder)
        table = pd.DataFrame({"decided_by": [limit], "reconstruction": reconstruction})
        table.to_csv(folder / "p/c1/recovered.csv", index=False)
        return write_front(folder / "index.html", files, {}, minimal=minimal)

    return write


def winner_outside(folder):
    """The page of a winner that keeps all dots, rounded, and of one with few dots that lies in a range."""
    files, path = write_run(folder), folder / "p/c1/best.json"
    best = json.loads(path.read_text())
    best["full"]["unrestricted"] |= {"alpha": 1.0, "delta": 0.0, "n_S_percent": 99.99995, "Z_tS": 0.0}
    own = {"alpha": 0.8, "beta": 0.2, "gamma": 0.0, "delta": 10.0, "n_S_percent": 18.0}
    best["kept"]["under_max_n_S"] = own | {"d_cv": 7.7, "d_cv_low": 7.0, "d_cv_high": 8.0, "n_best_set": 1}
    path.write_text(json.dumps(best))
    return write_front(folder / "index.html", files, {})


def four_surfaces(folder):
    """The page of four surfaces, of which one loses a range, with the fields of the subsets."""
    places = ["a/c1", "b/c1", "c/c1", "d/c1"]
    files = write_run(folder, places, (0.02, 0.03, 0.05, 0.09))
    summary = pd.read_csv(folder / "summary.csv")
    lost = (summary["protein"] == "b") & (summary["reading"] == "full") & (summary["range"] == 1)
    summary = summary.assign(d_cv_low=summary["d_cv_low"].mask(lost, -0.1))
    summary.to_csv(folder / "summary.csv", index=False)
    for place, r in zip(places, (0.912, 0.6, 0.4, 0.5), strict=True):  # the median is not the mean
        rows = [("charge", "minimal", r), ("charge", "farthest", 0.5), ("flat", "minimal", np.nan)]
        table = pd.DataFrame(rows, columns=["field", "subset", "r"])
        table.to_csv(folder / place / "fields.csv", index=False)
    return write_front(
        folder / "index.html", [*files, *(f"{place}/fields.csv" for place in places)], {"d/c1": "too `small`"}
    )


def ten_chains(folder):
    """The page of a surface of ten chains."""
    files = [*write_run(folder), "p/c1/residues.csv"]
    table = pd.DataFrame(
        {"chain": [*"ABCDEFGHIJ"], "residue": "7", "residue_name": "ALA", "area": 29.0, "dots": 70}
    )
    table = table.assign(mean_roughness=np.linspace(0.3, 0.7, 10))
    table.to_csv(folder / "p/c1/residues.csv", index=False)
    return write_front(folder / "index.html", files, {})


def two_surfaces(folder):
    """The page of two surfaces, whose best combinations keep other shares."""
    files = write_run(folder, ["a/c1", "b/c1"], (0.02, 0.03))
    best = json.loads((folder / "b/c1/best.json").read_text())
    best["kept"]["unrestricted"]["n_S_percent"] += 1
    (folder / "b/c1/best.json").write_text(json.dumps(best))
    for place in ("a/c1", "b/c1"):
        Image.new("RGB", (640, 480), "red").save(folder / place / "pictures/sampled.png")
        files.append(f"{place}/pictures/sampled.png")
    return write_front(folder / "index.html", files, {})


def failures_and_warnings(folder):
    """The page of a run with failures, warnings and contradictions."""
    files = write_run(folder)
    sentences = {"p": "a gap", "q": "a gap", "r": "a gap", "s": "a hole"}
    rows = [(name, "c1" * (name == "p"), "j", sentence) for name, sentence in sentences.items()]
    table = pd.DataFrame(rows, columns=["protein", "conformation", "job", "sentence"])
    table.to_csv(folder / "warnings.csv", index=False)
    parts = {f"part {k}": f"reason {k}" for k in range(23)} | {"bad": "holds no <atoms>"}
    return write_front(folder / "index.html", files, parts, broken=[("a.csv", "is `odd`.")])


def forms(folder, names=("opening",), unknown=5):
    """The page of residues that change between two forms; in `closing` the other way round, with chains."""
    table = pd.DataFrame(
        {"chain": "A", "residue": range(1, 41), "residue_name": "GLY", "residue_name_second": "GLY"}
    )
    table = table.assign(
        total=np.arange(40.0), total_floor=2.0, total_moved=np.where(table.index == 39, 100, 1.0)
    )
    table["above_moved"] = table["total"] > table[["total_floor", "total_moved"]].max(axis=1)
    table = table.assign(shape=1.0, shape_floor=0.5, potential_difference=-1.26, hydropathy_difference=0.04)
    table = table.assign(potential=2.0, potential_floor=1.5, hydropathy=0.9, hydropathy_floor=0.2)
    table.loc[unknown, ["total", "above_moved"]] = np.nan, False
    table.loc[[5, 38], "residue_name_second"] = "ALA"  # also of a buried residue
    chained = table.assign(chain=np.where(table.index < 20, "", "B"), total=table["total"][::-1].to_numpy())
    tables = {"opening": table, "closing": chained.assign(above_moved=table.index < 3)}
    for name in names:
        (folder / "changes" / name).mkdir(parents=True, exist_ok=True)
        tables[name].to_csv(folder / "changes" / name / "changes.csv", index=False)
    return write_front(folder / "index.html", [f"changes/{name}/changes.csv" for name in names], {})


def pairs(folder, touching):
    """The page of two pairs, of which some touch."""
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
    files = [
        "pairs/pairs.csv",
        *(f"pairs/c{k}/book.png" for k in range(2)),
        "pairs/c1/open.pml",
        "pairs/c1/view.html",
    ]
    (folder / "pairs").mkdir()
    columns = ["complex", "partner", "score", "auc", "low", "high"]
    pd.DataFrame(rows, columns=columns).to_csv(folder / "pairs" / "pairs.csv", index=False)
    return write_front(folder / "index.html", files, {})


def frames(folder, other=False):
    """The page of a protein over its frames, and of another one; the median of each column is not its mean."""
    table = pd.DataFrame({"N": [1000, 1100, 1800], "area": [200.0, 210, 280], "n_S_percent": [40.0, 41, 48]})
    table = table.assign(mean_roughness=[0.5, 0.52, 0.6], d_kept=[1.0, 2, 6], d_full=[-1.0, -2, -6])
    for name in "pa":
        (folder / name).mkdir()
    table.to_csv(folder / "p/ensemble.csv", index=False)
    table[:2].assign(n_S_percent=[20.0, 30]).to_csv(folder / "a/ensemble.csv", index=False)
    files = ["p/ensemble.csv", "p/residues.csv", "p/figures/ensemble.png", "p/figures/residues.png"]
    more = [
        "a/ensemble.csv",
        "p/residues_over_time.csv",
        "a/figures/simulation.png",
        "a/simulation/quality.csv",
    ]
    return write_front(folder / "index.html", files + more * other, {})


def all_questions(folder):
    """The page of a run with a grid, forms and frames: first the grid, then the subset, the forms and the frames."""
    files = write_run(folder)
    forms(folder)
    table = pd.DataFrame(
        {"N": [1000, 1100], "area": [200.0, 210], "n_S_percent": [40.0, 41], "mean_roughness": 0.5}
    )
    table.to_csv(folder / "p/ensemble.csv", index=False)
    return write_front(folder / "index.html", [*files, "changes/opening/changes.csv", "p/ensemble.csv"], {})


def paper(p, n_runs, n_combinations=1296, more=()):
    """Function that writes the page of a run that is compared with Table I."""

    def write(folder):
        files = write_run(folder)
        values = [(0.1, 0.2, 0.4, 0.6, 0.8, 1), (0, 0.2, 0.4, 0.6, 0.8, 1), range(0, 11, 2), range(0, 11, 2)]
        grid = pd.DataFrame(itertools.product(*values), columns=PARAMETERS).assign(n_S_percent=50.0)
        grid[:n_combinations].to_csv(folder / "p/c1/grid.csv", index=False)
        places = pd.DataFrame(
            {"range": [1, 2, 3, 4], "d_inside": [1, 0, 0, 0], "Z_tS_inside": [1, 1, 0, 0], "n_runs": n_runs}
        )
        places = places.assign(
            alpha=1.0, beta=0.0, gamma=[6.0, 5, 4, 3], delta=0.0, d_published=[2.69, 1.5, -0.5, 0]
        )
        places[::-1].to_csv(folder / "paper_places.csv", index=False)  # in whatever order
        tests = pd.DataFrame({"measure": ["d", "together"], "p": [p / 2, p]})
        tests.to_csv(folder / "paper_tests.csv", index=False)
        return write_front(folder / "index.html", [*files, "paper_places.csv", "paper_tests.csv", *more], {})

    return write


def batches(folder, failed, empty=False):
    """The page of a run in batches; the median of the roughness is not its mean, and the share is that of all dots."""
    of = pd.DataFrame({"protein": ["a", "b", "c"], "N": [1000, 2000, 9000], "minimal_n_S": [100, 300, 500]})
    of = of.assign(masked_residues=[3.0, np.nan, 4.0], residues=[50, 70, 90], atoms=[1500, 700, 3100])
    of = of.assign(mean_roughness=[0.5, 0.55, 0.9], area=[411.2, 1422.8, 10.0], volume=[2000.4, 30.0, 1.0])
    of = of.assign(components=[1, 2, 3], cavities=[4, 5, 6], deviation=[7.25, 8.0, 9.0], unusual="atoms")
    of = of[:0] if empty else of
    failures = [("no atoms", failed)] * bool(failed)
    content = {"surfaces": of, "unusual": of[:1], "failures": failures, "n_batches": 2}
    return write_front(folder / "index.html", ["distributions.png"], {}, content)


CASES = {
    "one surface": one_surface,
    "20 percent": lambda folder: one_surface(folder, minimal={"percent": 20}),
    "4000 dots": lambda folder: one_surface(folder, minimal={"n_dots": 4000}),
    "a density": lambda folder: one_surface(folder, minimal={"density": 0.6}),
    "a Z": lambda folder: one_surface(folder, minimal={"max_z": 1.5}),
    "a combination": lambda folder: one_surface(folder, minimal={"sampler": "paper", "combination": [1, 0, 6, 0]}),
    "ten chains": ten_chains,
    "two surfaces": two_surfaces,
    "three surfaces without d": surfaces_whose_d_is(np.nan, np.nan, 3),
    "one surface in one reading": surfaces_whose_d_is(0, 1, 1, ["kept"]),
    "four surfaces": four_surfaces,
    "decided back": decided_by("99 % back", "spheres", {"error": 0.02}),
    "decided forth": decided_by("99 % forth", "interpolant", {"error": 0.03, "error_99": 0.2}),
    "a winner outside": winner_outside,
    "failures": failures_and_warnings,
    "forms": lambda folder: forms(folder, ("opening", "closing")),
    **{f"{n} touching pairs": lambda folder, n=n: pairs(folder, n) for n in range(3)},
    "frames": frames,
    "frames of two": lambda folder: frames(folder, True),
    "all questions": all_questions,
    "Table I reproduced": paper(0.06, 200, more=["verdict.html", "table1.png"]),
    "Table I not reproduced": paper(0.04, 200),
    "too few runs": paper(0.06, 39),
    "too few combinations": paper(0.06, 200, 1295),
    "batches": lambda folder: batches(folder, ["x", "y"]),
    "batches without failures": lambda folder: batches(folder, []),
    "batches without surfaces": lambda folder: batches(folder, [f"s{k}" for k in range(25)], True),
}  # fmt: skip


def lines_of(folder, answers):
    """What a reader sees: what the terminal says, the text of the page, its tables, and what pictures say."""
    page = page_of(folder)
    lines = [*answers, *page.blocks, *(" | ".join(row) for row in page.rows), *page.alternatives]
    changing = rf"\d{{4}}-\d\d-\d\d|{re.escape(__version__)}|{folder.name}"
    return list(dict.fromkeys(re.sub(changing, "…", line) for line in lines if line))


@pytest.mark.parametrize("name", CASES)
def test_a_page_reads_as_it_was_reviewed(tmp_path, name):
    """Of other pages than the first, what that does not say."""
    (folder := tmp_path / "folder_of_run").mkdir()
    lines = lines_of(folder, CASES[name](folder))
    stored, first = REVIEWED / f"{name}.txt", REVIEWED / "one surface.txt"
    if name != "one surface":
        common = {*first.read_text(encoding="utf-8").splitlines()}
        lines = [line for line in lines if line not in common]
    if os.environ.get("BASELINE") == "new":
        stored.write_text("\n".join(lines) + "\n", encoding="utf-8")
    assert lines == stored.read_text(encoding="utf-8").splitlines()


# ---- its numbers


@pytest.mark.parametrize(
    ("n_atoms", "words"),
    [([57], "57 atoms (0.28"), ([300, 92, 60], "92 atoms (0.23")],
)
def test_the_card_of_the_dots_says_how_many_atoms_determine_the_surface(tmp_path, n_atoms, words):
    """Of surfaces of 200, 400 and 600 Å²: the median of the densities is not the density of the medians."""
    places = [f"{name}/c1" for name in "abc"[: len(n_atoms)]]
    files = write_run(tmp_path, places, [0.02] * len(places))
    paths = [f"{place}/surface_atoms.csv" for place in places]
    for path, n in zip(paths, n_atoms, strict=True):
        pd.DataFrame({"atom": range(n)}).to_csv(tmp_path / path, index=False)
    answers = write_front(tmp_path / "index.html", [*files, *paths], {})
    page = page_of(tmp_path)
    assert words in page.words and any(words in answer for answer in answers)
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
    heads = " ".join(head.text for head in page_of(tmp_path).find("h2"))
    is_asked = page_of(tmp_path).find("h1")[0].text.startswith("Which dots")
    assert is_asked != is_own
    assert (heads.index("are rough?") < heads.index("random dots?")) == is_own


def test_the_best_combination_has_one_value_everywhere(tmp_path):
    answers = one_surface(tmp_path)
    page = page_of(tmp_path)
    assert "9.99" not in page.words and all(
        "2.42 (2.17 to 2.72)" in text for text in (answers[2], page.words)
    )
    of_range = next(row for row in page.rows if row[0] == "25 to 50 %")
    assert of_range[:3] == ["25 to 50 %", "(1, 0, 4, 6) best", "2.42 (2.17 to 2.72)"]
    assert of_range[4:] == ["−0.26 (−0.51 to 0.04)", "(1, 0, 4, 6)"]
    assert of_range[3].startswith("(1, 0, 4, 6) keeps 43.0 %")  # on hover over the drawing
    of_range = next(row for row in page.rows if row[0] == "50 to 75 %")
    assert of_range[1:3] == ["(0.8, 0.2, 4, 10)", "2.60 (2.35 to 2.90)"]
    assert of_range[4:] == ["−0.30 (−0.55 to 0.00)", "(0.6, 0.2, 4, 10)"]
    assert [row[1].endswith("best") for row in page.rows if "to" in row[0]] == [False, True, False, False]


@pytest.mark.parametrize(
    ("n_surfaces", "readings", "full", "kept", "answer", "other"),
    [
        (1, "both", -1, 1, "No: none 4", "yes 4 4"),
        (1, "both", 1, 1, "Yes: 4", "yes 4 4"),
        (2, "both", -1, -1, "No: none 8", "yes none 8"),
        (3, "both", 1, -1, "Yes: 12 3", "yes none 12"),
        (1, "both", np.nan, np.nan, "Undecided:", "undecided"),
        (1, "kept", 0, 1, "Yes: 4", ""),
    ],
)
def test_the_answer_counts_size_ranges_and_surfaces(
    tmp_path, n_surfaces, readings, full, kept, answer, other
):
    named = ("kept", "full") if readings == "both" else ("kept",)
    answers = surfaces_whose_d_is(full, kept, n_surfaces, named)(tmp_path)
    told = [
        " ".join(re.findall(r"(?:Yes|No|Undecided):|yes|none|undecided|\b\d+\b", each))
        for each in answers[: 1 + bool(other)]
    ]
    assert told == [answer, other][: len(told)] and answers[0].split("?")[1].strip() in text_of(tmp_path)


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
    assert "2 of the 3" in text_of(tmp_path)


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
    assert "run CONFIG=mine.yaml" in text and "2.4, numba 0.61" in text
    places = [text.rindex(hashlib.sha256(content).hexdigest()) for content in (b"a structure", b"another")]
    assert text.rindex("p.pdb") < places[0] < text.rindex("q.pdb") < places[1]  # each beside its file
    assert "gone.pdb" not in text and __version__ in text


def test_answers_count_ranges_and_surfaces_where_there_are_many(tmp_path):
    answers = four_surfaces(tmp_path)
    above = sum(d + s - 0.25 > 0 for s in range(4) for d in D["full"]) - 1  # b still has others
    assert re.findall(r"\d+", answers[0]) == [str(above), "16", "3", "4"]
    assert "(0.8, 0.2, 4, 10)" in answers[2]
    assert re.findall(r"[\d.]+\d", answers[3])[:5] == ["3.3", "1.30", "0.040", "99", "0.450"]
    (row,) = [row for row in page_of(tmp_path).rows if row[0].startswith("25 ") and "to 7.42" in row[2]]
    assert row == [
        "25 to 50 %",
        "(1, 0, 4, 6)",
        "3.92 (2.42 to 7.42)",
        "(1, 0, 4, 6)",
        "1.24 (−0.26 to 4.74)",
    ]
    r = np.median([0.912, 0.6, 0.4, 0.5])
    assert "4 of 6" in text_of(tmp_path) and f"(r = {r:.3f})" in text_of(tmp_path)


def test_failures_and_warnings_stand_above_the_sections(tmp_path):
    rows = [("p", "c1", "j", "/x/p.pdb: it lacks 3 atoms"), ("q", "", "j", "/x/q.pdb: it lacks 12 atoms")]
    table = pd.DataFrame(rows, columns=["protein", "conformation", "job", "sentence"])
    table.to_csv(tmp_path / "warnings.csv", index=False)
    assert [places for places, _ in warned(tmp_path / "warnings.csv")] == [["p/c1", "q"]]
    failures_and_warnings(tmp_path)
    text = text_of(tmp_path)
    assert text.index("no <atoms>") < text.index("a hole") < text.index("Best parameters by")


def test_forms_are_listed_by_their_change_over_the_larger_floor(tmp_path):
    answers = forms(tmp_path)
    assert re.findall(r"(\d+) of (\d+).*about (\d+)", answers[0]) == [("35", "39", "2")]
    shown = [row for row in page_of(tmp_path).rows if row[0].startswith("A:")]
    assert [row[0] for row in shown[:2]] == ["A:GLY39 → ALA", "A:GLY38"] and len(shown) == 10
    assert shown[0][1:] == ["19.0", "38.00", "2.00", "1.00", "hydropathy, shape", "−1.3", "0.0"]
    answers = forms(tmp_path, ("opening", "closing"))
    assert [answer.split(" residues")[0] for answer in answers] == ["opening: 35 of 39", "closing: 3 of 39"]
    answers = forms(tmp_path, unknown=[*range(11)])
    assert re.findall(r"(\d+) of (\d+).*about (\d+)", answers[0]) == [
        ("28", "29", "1")
    ]  # 5 % of 29, not of 40


@pytest.mark.parametrize("touching", [0, 2])
def test_pairs_are_judged_next_to_protrusion(tmp_path, touching):
    (answer,) = pairs(tmp_path, touching)
    rows = page_of(tmp_path).tables[0][1:]
    if touching:
        assert "0.60" in answer and "0.75" in answer
        assert rows[2:] == [
            ["c1", "1", "0.60 (0.40 to 0.60)", "0.80 (0.60 to 0.80)", "view.html open.pml"],
            ["", "2", "0.70 (0.50 to 0.70)", "0.80 (0.60 to 0.80)", ""],
        ]
    else:
        assert rows[1] == ["c1", "", "no interface", "", "view.html open.pml"]


@pytest.mark.parametrize(
    ("aucs", "words"),
    [
        ((0.7, 0.8), "Better than"),
        ((0.55, 0.8), "on partner 2"),
        ((0.8, 0.2), "on partner 1"),
        ((0.55, 0.45), "No better than"),
        ((0.1, 0.2), "Worse than"),
    ],
)
def test_a_pair_is_judged_by_both_partners(aucs, words):
    assert verdict_of([[auc, auc - 0.1, auc + 0.1] for auc in aucs]).find(words) >= 0


@pytest.mark.parametrize(
    ("p", "n_runs", "n_combinations", "word"),
    [
        (0.06, 200, 1296, "Yes"), (0.04, 200, 1296, "No"), (0.06, 39, 1296, "Undecided"), (0.04, 40, 1296, "No"),
        (0.06, 200, 1295, "Undecided"),
    ],
)  # fmt: skip
def test_one_test_of_all_rows_decides_whether_table_1_is_reproduced(
    tmp_path, p, n_runs, n_combinations, word
):
    paper(p, n_runs, n_combinations)(tmp_path)
    page = page_of(tmp_path)
    assert f"reproduced? {word}" in page.words and "verdict.html" not in page.links
    wanted = [
        ("(1, 0, 6, 0)", "2.69"),
        ("(1, 0, 5, 0)", "1.50"),
        ("(1, 0, 4, 0)", "−0.50"),
        ("(1, 0, 3, 0)", "0.00"),
    ]
    rows = [row[:3] for row in page.rows if "to" in row[0]]
    assert rows == [[f"{25 * k} to {25 * k + 25} %", *of] for k, of in enumerate(wanted)]


def test_frames_are_summed_up_by_their_mean_and_their_ends(tmp_path):
    frames(tmp_path)
    page = page_of(tmp_path)
    assert page.rows == [
        ["measure", "mean", "standard deviation", "lowest", "highest"],
        ["dots", "1,300", "436", "1,000", "1,800"],
        ["area (Å²)", "230", "44", "200", "280"],
        ["mean roughness", "0.540", "0.053", "0.500", "0.600"],
        ["nS (%)", "43.0", "4.4", "40.0", "48.0"],
        ["d among the kept dots", "3.00", "2.65", "1.00", "6.00"],
        ["d on the full surface", "−3.00", "2.65", "−6.00", "−1.00"],
    ]
    assert "p/residues.csv" in page.links


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
    shown = [picture.attributes["alt"] for picture in enlarged(page)]
    assert [re.findall(r"\d+\.\d+|\d+ %|\b\d+\b", alt) for alt in shown[:3]] == [["0.60"], ["43 %"], ["45"]]
    heads = ["roughest residues", "mean roughness (1 is flat)", "area (Å²)", "dots", "mean hbond"]
    rows = [["LYS 9 A", "0.42", "31", "1,200", "0.25"], ["ALA 7 A", "0.61", "22", "70", "−0.50"]]
    assert [heads, *rows] in page.tables
    ends = ["0.42 (LYS 9 A)", "0.61 (ALA 7 A)"]
    assert any(re.findall(r"[\d.]+ \(.*?\)", words) == ends for words in page.alternatives)
    assert {"p/c1/view.html", "p/c1/minimal.csv", "p/c1/residues.csv", "p/c1/ranges.csv"} <= {*page.links}
    surface = next(row for row in page.rows if row[1] == "p")
    assert surface[2:] == ["1,000", "200", "0.60", "45", "8.0", "0.020", "0.50", "0.70",
                           "minimal.csv residues.csv"]  # fmt: skip
    maps = next(words for words in shown if words.startswith("Maps of d"))
    assert re.findall(r"2\.42|\(1, 0, 4, 6\)|\d+ %", maps) == ["2.42", "(1, 0, 4, 6)", "43 %"]
    size = max(len(picture.attributes["src"]) for picture in enlarged(page))
    monkeypatch.setattr(pages, "MAX_PAGE_BYTES", 2 * size + 9)
    write_front(tmp_path / "index.html", files, {})
    sources = [picture.attributes["src"] for picture in enlarged(page_of(tmp_path))]
    outside = [source for source in sources if not source.startswith("data:")]
    assert 1 < len(outside) < len(sources) and f"last {len(outside)} figures" in text_of(tmp_path)


def test_many_surfaces_stand_by_their_share_and_only_the_first_of_them(tmp_path, monkeypatch):
    places = ["a/c1", "b/f1", "b/f2", "d/c1"]
    files = [*write_run(tmp_path, places, (0.02, 0.03, 0.05, 0.09)), "surfaces.csv", "relation.csv"]
    files += [f"{place}/minimal.csv" for place in places]
    monkeypatch.setattr(surfaces, "MAX_ROWS", 3)
    write_front(tmp_path / "index.html", files, {"d/c1": "too `small`", "e": "gone"})
    page = page_of(tmp_path)
    assert [link.attributes["href"] for link in page.find("a", inside="card")] == ["surfaces.csv"]
    rows = next(table for table in page.tables if table[0][1] == "surface")[1:]
    assert [row[1] for row in rows] == ["d", "b/f2", "b/f1"]  # 2, 2.7 and 4 %; c1 alone is not named
    assert rows[0][2:10] == ["4,000", "800", "0.90", "60", "2.0", "0.090", "0.50", "0.70"]
    text = page.words
    assert "1 more surfaces" in text and "a, b and d," in text and "4 surfaces ·" in text
    assert "2.60 if" in text and "2.9 to 3.8" in text  # medians
    cells = [cell for cell in page.find("td") if cell.text in ("4,000", "2.0")]
    keys = [cell.attributes["data-key"] for cell in cells if "data-key" in cell.attributes]
    assert keys == ["4000", "2.0"]


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
    numbers = [re.findall(rf"of ({name}|012)\b|on ({name})\b|(\d\.\d+|\d+) ?", alt) for alt in shown[:4]]
    found = [{part for parts in each for part in parts if part} for each in numbers]
    assert found[:3] == [{"012", "0.60"}, {name, "0.70"}, {name, "43"}] and {"50"} <= found[3]
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
    chosen = [
        "checked" in each.attributes for each in page.find("input") if each.attributes.get("type") == "radio"
    ]
    assert chosen == [True, False]
    assert "applied to 012" in text and f"applied to {name}" not in text
    assert "all 4 size" in text  # of the sampled one alone
    rows = [row[1:3] for row in page.rows if len(row) > 9 and row[1] in ("012", name)]
    assert rows == [["012", "1,000"], [name, "2,000"]]
    assert "over 2 surfaces" in text and "6.0 % 0.50" in text
    linked = [link.attributes["href"] for link in page.find("a", inside="card")]
    assert linked == [f"{place}/minimal.csv" for place in places]
    of_first = [
        link.attributes["href"] for link in page.find("a", inside="li") if "/" in link.attributes["href"]
    ]
    assert "to 012." in text and {path.split("/")[0] for path in of_first} == {"012"}


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
        asked = [head.text for head in page.find("h2") if head.text.startswith("How many")]
        assert bool(asked) != bool(more) == (not any("minimal.csv" in answer for answer in answers))
        shown.append((page.find("h1")[0].text, page.find("lede")[0].text))
    assert shown[0][0] != shown[1][0] and "partner" in shown[1][1] and "partner" not in shown[0][1]


def test_many_proteins_are_counted_in_the_heading(tmp_path):
    """Proteins, not their conformations."""
    places = ["a/f0", *(f"{name}/f1" for name in "abcdefg")]
    write_front(tmp_path / "index.html", write_run(tmp_path, places, [0.02] * len(places)), {})
    assert "of 7 proteins" in page_of(tmp_path).find("h1")[0].text


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


def test_alike_warnings_and_the_last_failures_are_folded(tmp_path):
    failures_and_warnings(tmp_path)
    blocks = page_of(tmp_path).blocks
    at = blocks.index("4 more")
    assert blocks[at - 1 : at + 2] == ["part 19: reason 19", "4 more", "part 20: reason 20"]


@pytest.mark.parametrize("failed", [["x", "y"], ["x"]])
def test_a_run_in_batches_counts_its_surfaces_and_failures(tmp_path, failed):
    (answer,) = batches(tmp_path, failed)
    numbers = re.findall(r"[\d.,]*\d", answer)
    assert numbers == ["3", "700", "3,100", "7.5", "12,000", "0.55", "0.50", "0.90"]
    page = page_of(tmp_path)
    assert f"3 of {3 + len(failed)}" in page.words and "7 of 147" in page.words
    assert f"{', '.join(failed)}: no atoms" in page.words
    assert page.rows[1] == ["a", "7.2", "atoms", "1,500", "411", "2,000", "0.50", "1", "4"]
    assert {"surfaces/", "residues/", "dots/", "failures.csv"} <= {*page.links}


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
    assert f"{subject}: farthest" in texts and f"of {band}." in texts
    means = pd.read_csv(tmp_path / "compare.csv").set_index("sampler")
    wanted = {1: (1.0, 1.0, 1.0), 2: (1.5, 1.0, 2.0), 3: (1.75, 1.0, 2.5)}[len(places)]  # b: the mean of two
    assert means.loc["farthest", ["value", "lowest", "highest"]].tolist() == pytest.approx(wanted)
    shaded = figure.axes[0].collections[0].get_paths()[0].vertices[:, 1]  # of the first sampler
    assert (shaded.min(), shaded.max()) == pytest.approx(wanted[1:])


def test_a_word_is_explained_once_by_the_lengths_of_the_config(tmp_path):
    lengths = {"r_patch": 3.5, "r_zernike": 5.25, "interface": 2.5}
    write_front(tmp_path / "index.html", write_run(tmp_path), {}, lengths=lengths)
    page = page_of(tmp_path)
    terms = page.find("abbr")
    explained = [
        term.text for term in terms if re.findall(r"[\d.]+\d", term.attributes["title"]) == ["3.5", "5.25"]
    ]
    assert len(explained) == 1 and explained[0].startswith("patch")
    listed = {head.text: told.text for head, told in zip(page.find("dt"), page.find("dd"), strict=True)}
    marked = {term.text for term in terms}
    assert "3.5 Å" in listed["patch"] and "interface" not in listed  # which this page does not name
    assert {word.removesuffix("es").removesuffix("s") for word in marked} >= {"dot", "Z", "d", "patch"}
    assert "island" in marked and "descriptor" in listed  # a word of the meaning of Z


def test_pairs_that_do_not_touch_have_no_rows(tmp_path):
    (tmp_path / "far").mkdir()
    columns = "partner,score,auc,low,high,dots,interface,blocks\n"
    (tmp_path / "far" / "agreement.csv").write_text(columns)
    outputs = [str(tmp_path / name) for name in ("pairs.csv", "pairs.png")]
    summarise_pairs([tmp_path / "far" / "agreement.csv"], "x", *outputs)
    assert len(pd.read_csv(outputs[0])) == 0 and (tmp_path / "pairs.png").exists()
