"""The first page of a run: its answers and sections against its tables."""

import html
import json
import re

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from parsed_pages import Page
from sparsurf_study.report.front import warned, write_front
from sparsurf_study.report.summaries import summarise_pairs

D = {"kept": [0.5, 2.42, 2.6, 0.2], "full": [-0.13, -0.26, -0.3, -0.1]}  # by range
BEST = (1.0, 0.0, 4.0, 6.0)  # of the second range


def write_run(folder, places=("p/c1",), errors=(0.02,)):
    """Write the tables of surfaces with a grid, of unequal sizes, and return the paths of the run."""
    rows = [
        {"protein": place.split("/")[0], "conformation": place.split("/")[1], "reading": reading, "range": k + 1}
        | dict(zip(("alpha", "beta", "gamma", "delta"), BEST if k == 1 else (0.8, 0.2, 2.0 * k, 10.0), strict=True))
        | {"n_S_low_percent": 25.0 * k, "n_S_high_percent": 25.0 * k + 25, "n_S": 100.0 * k + 30, "n_S_percent": 25 * k + 18.0}
        | {"link_over_spacing": 0.5 + 0.3 * k, "share_in_island": (0.05, 0.234, 0.5, 1.0)[k]}
        | {"d_cv": d + s, "d_cv_low": d + s - 0.25, "d_cv_high": d + s + 0.3, "Z_tS": 3.0 - k, "Z_mean_descriptor": 1.5}
        for s, place in enumerate(places)
        for reading, of in D.items()
        for k, d in enumerate(of)
    ]  # fmt: skip
    summary = pd.DataFrame(rows)
    surfaces = pd.DataFrame([place.split("/") for place in places], columns=["protein", "conformation"])
    n = np.arange(1, len(places) + 1)
    surfaces = surfaces.assign(
        N=1000 * n, area=200.0 * n, mean_roughness=0.5 + 0.1 * n, minimal_n_S=40 + 5 * n, minimal_n_S_percent=8.0 / n,
        minimal_n_S_percent_low=7.0 / n, minimal_n_S_percent_high=9.0 / n, minimal_density=0.2 * n,
        recovered_mean=errors, recovered_high_99=5 * np.array(errors), recovered_largest=10 * np.array(errors),
        recovered_Z_published=0.5, recovered_Z_rotation_robust=0.7, best_kept="x", best_full="x",
    )  # fmt: skip
    relation = summary.drop_duplicates(["reading", "range"]).assign(p=[0.01, 0.5, np.nan, 0.02] * 2)
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
    best = {"max_n_S_percent": 20, "references": {"Z_mean_descriptor": 1.5}}
    best |= {reading: {"unrestricted": winner, "under_max_n_S": none} for reading in D}
    grid = pd.DataFrame({"n_S_percent": [winner["n_S_percent"], 99.99995]})
    for place in places:
        (folder / place / "figures").mkdir(parents=True)
        (folder / place / "best.json").write_text(json.dumps(best))
        (folder / place / "recovered.csv").write_text("where\n")
        grid.to_csv(folder / place / "grid.csv", index=False)
        Image.new("RGB", (200, 100), "red").save(folder / place / "figures" / "d_over_grid.png")
    return [path.relative_to(folder).as_posix() for path in sorted(folder.rglob("*.*"))]


def text_of(folder):
    """The text of the page without its tags and its styles."""
    page = re.sub(r"(?s)<(style|script|dl).*?</\1>", "", (folder / "index.html").read_text())
    return " ".join(html.unescape(re.sub(r"<[^>]+>", "", page)).split())


def test_the_best_combination_is_the_first_answer_and_has_one_value_everywhere(tmp_path):
    files = write_run(tmp_path)
    answers = write_front(tmp_path / "index.html", files, {})
    assert answers == [
        "Best (α, β, γ, δ) = (1, 0, 4, 6), one of 36 that may be the best: keeps 43 % of the dots, d 2.42 (2.17 to 2.72) among"
        " the kept dots, but the subset is fragmented; on the full surface the sampling"
        " beats uniform dots in none of 4 ranges.",
        "For few dots take minimal.csv: 8 % of the dots (0.20 per Å²; 95 % interval 7.0 to 9.0 %) recover the surface to"
        " 0.020 Å on average (99 % within 0.10 Å, the farthest 0.20 Å off).",
    ]
    page = Page((tmp_path / "index.html").read_text())
    assert all(answer in text_of(tmp_path) for answer in answers) and "9.99" not in text_of(tmp_path)
    of_range = next(row for row in page.rows if row[0].startswith("25.0"))
    assert of_range[1:] == [
        "(1, 0, 4, 6)",
        "43.0",
        "2.42 (2.17 to 2.72)",
        "0.80",
        "23 %, fragmented",
        "(1, 0, 4, 6)",
        "43.0",
        "−0.26 (−0.51 to 0.04)",
    ]
    of_all = next(row for row in page.rows if row[0].startswith("best at the largest"))
    assert of_all[1:6] == of_range[1:6]
    half = next(row for row in page.rows if row[0].startswith("50.0"))
    assert half[4:6] == ["1.10", "50 %"]  # not below one half


def test_a_winner_that_keeps_the_most_dots_is_marked_though_ranges_are_rounded(tmp_path):
    files, path = write_run(tmp_path), tmp_path / "p/c1/best.json"
    best = json.loads(path.read_text())
    best["full"]["unrestricted"] |= {"alpha": 1.0, "delta": 0.0, "n_S_percent": 99.99995, "Z_tS": 0.0}
    path.write_text(json.dumps(best))
    write_front(tmp_path / "index.html", files, {})
    rows = Page((tmp_path / "index.html").read_text()).rows
    assert [row[0] for row in rows if any("‡" in cell for cell in row)] == ["best at the largest α"]
    assert "leaves it out of the last range" in text_of(tmp_path)


def test_answers_count_ranges_and_surfaces_where_there_are_many(tmp_path):
    places = ["a/c1", "b/c1", "c/c1", "d/c1"]
    answers = write_front(tmp_path / "index.html", write_run(tmp_path, places, (0.02, 0.03, 0.05, 0.09)), {})
    above = sum(d + s - 0.25 > 0 for s in range(4) for d in D["full"])
    assert f"in {above} of 16 ranges, on 3 of 4 surfaces" in answers[1]
    assert (
        "0.040 Å on average (99 % within 0.20 Å, the farthest 0.90 Å off), median of 4 surfaces" in answers[2]
    )
    assert "95 % intervals within 1.8 to 9.0 %" in answers[2]
    page = Page((tmp_path / "index.html").read_text())
    (row,) = [row for row in page.rows if row[0].startswith("25.0") and "to 5.42" in row[2]]
    assert row[2] == "3.92 (2.42 to 5.42)"
    assert "4 of 6 tests find" in text_of(tmp_path)


def test_fields_are_those_of_the_minimal_subset(tmp_path):
    files = [*write_run(tmp_path), "p/c1/fields.csv"]
    rows = [("charge", "minimal", 0.912), ("charge", "farthest", 0.5), ("flat", "minimal", np.nan)]
    pd.DataFrame(rows, columns=["field", "subset", "r"]).to_csv(tmp_path / "p/c1/fields.csv", index=False)
    write_front(tmp_path / "index.html", files, {})
    assert "gives fields back at the other dots: charge r = 0.912." in text_of(tmp_path)


def test_failures_and_warnings_stand_above_the_sections(tmp_path):
    files = write_run(tmp_path)
    rows = [("p", "c1", "j", "/x/p.pdb: it lacks 3 atoms"), ("q", "", "j", "/x/q.pdb: it lacks 12 atoms")]
    pd.DataFrame(rows, columns=["protein", "conformation", "job", "sentence"]).to_csv(
        tmp_path / "warnings.csv", index=False
    )
    assert warned(tmp_path / "warnings.csv") == [(["p/c1", "q"], "p.pdb: it lacks 3 atoms")]
    write_front(tmp_path / "index.html", files, {"bad": "holds no <atoms>"})
    text = text_of(tmp_path)
    assert text.index("holds no <atoms>") < text.index("it lacks 3 atoms") < text.index("Best combination by")


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
    table.loc[5, ["total", "above_moved"]] = np.nan, False
    table.loc[38, "residue_name_second"] = "ALA"
    table.to_csv(folder / "changes.csv", index=False)
    answers = write_front(tmp_path / "index.html", ["changes/opening/changes.csv"], {})
    assert "opening: 35 of 39 residues change more" in answers[0] and "about 2 would" in answers[0]
    page = Page((tmp_path / "index.html").read_text())
    shown = [row for row in page.rows if row[0].startswith("A:")]
    assert [row[0] for row in shown[:2]] == ["A:GLY39 → ALA", "A:GLY38"] and len(shown) == 10
    assert shown[0][1:] == ["38.00", "2.00", "1.00", "shape", "−1.3", "0.0"]


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
    files = ["pairs/pairs.csv", *(f"pairs/c{k}/book.png" for k in range(2))]
    (tmp_path / "pairs").mkdir()
    pd.DataFrame(rows, columns=columns).to_csv(tmp_path / "pairs" / "pairs.csv", index=False)
    (answer,) = write_front(tmp_path / "index.html", files, {})
    words = [
        "no interface to find",
        "0.50 (0.40 to 0.60) and 0.60 (0.50 to 0.70) on its two",
        "with AUC 0.60",
    ]
    assert words[touching] in answer
    if touching == 2:
        assert re.search(r"protrusion alone has 0\.75 \(", answer)


@pytest.mark.parametrize(("p", "word"), [(0.06, ""), (0.04, "not ")])
def test_one_test_of_all_rows_decides_whether_table_1_is_reproduced(tmp_path, p, word):
    files = write_run(tmp_path)
    places = pd.DataFrame(
        {"range": [1, 2, 3, 4], "d_inside": [1, 0, 0, 0], "Z_tS_inside": [1, 1, 0, 0], "n_runs": 200}
    )
    places = places.assign(alpha=1.0, beta=0.0, gamma=6.0, delta=0.0, d_published=2.69)
    tests = pd.DataFrame({"measure": ["d", "together"], "p": [0.5, p]})
    for name, table in (("paper_places.csv", places), ("paper_tests.csv", tests)):
        table.to_csv(tmp_path / name, index=False)
    answer = write_front(tmp_path / "index.html", [*files, "paper_places.csv", "paper_tests.csv"], {})[0]
    assert (
        f"is {word}reproduced: 1 of 4 published d and 2 of 4 published Z" in answer
        and "95 % of 200 runs" in answer
    )


def test_pairs_that_do_not_touch_have_no_rows(tmp_path):
    (tmp_path / "far").mkdir()
    columns = "partner,score,auc,low,high,dots,interface,blocks\n"
    (tmp_path / "far" / "agreement.csv").write_text(columns)
    outputs = [str(tmp_path / name) for name in ("pairs.csv", "pairs.png")]
    summarise_pairs([tmp_path / "far" / "agreement.csv"], "x", *outputs)
    assert len(pd.read_csv(outputs[0])) == 0 and (tmp_path / "pairs.png").exists()
