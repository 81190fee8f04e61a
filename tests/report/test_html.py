"""Pages: their numbers are those of the tables, they need no other site, they escape what a user named."""

import base64
import io
import json
import os
import re
from pathlib import Path
from urllib.parse import quote, unquote

import numpy as np
import pandas as pd
import pytest
from PIL import Image

import check_run
import close_run
import sparsurf
from browser import Browser, programs
from parsed_pages import Page
from sparsurf.report import ensemble_page, summary_page
from sparsurf.report.first_page import TEMPLATE, first_page, galleries, main_figure, pair_galleries
from sparsurf.report.numbers import against_zero, interval, number, share, short_names, span
from sparsurf.report.page import TEMPLATES, code, embedded, embedded_figures, render
from sparsurf.report.pairs_section import pairs_section

READINGS = ("kept", "full")
D = {"kept": 2.51, "full": -0.28}  # of the best range


def summary_rows(protein, conformation):
    rows = []
    for reading in READINGS:
        for k, share_of_best in enumerate((0.5, 1.0, 0.2), 1):
            d = D[reading] * share_of_best
            rows.append(
                {"protein": protein, "conformation": conformation, "mean_roughness": 0.6, "reading": reading}
                | {"range": k, "n_S_low_percent": 30.0 * k - 30, "n_S_high_percent": 30.0 * k, "n_S_percent": 30.0 * k - 5}
                | {"alpha": 1.0, "beta": 0.0, "gamma": 2.0 * k, "delta": 0.0}
                | {"d_cv": d, "d_cv_low": d - 0.1, "d_cv_high": d + 0.1}
            )  # fmt: skip
    return rows


def write_run(folder, places=(("p", "c1"),)):
    """The tables of a run that its first page is made of, and files that it leads to; their paths from the folder."""
    rows = [row for place in places for row in summary_rows(*place)]
    summary = pd.DataFrame(rows)
    names = dict.fromkeys(places)
    surfaces = pd.DataFrame(
        [
            {"protein": p, "conformation": c, "N": 2000 + k, "mean_roughness": 0.6}
            | {f"best_{reading}": "(1, 0, 4, 0)" for reading in READINGS}
            for k, (p, c) in enumerate(names)
        ]
    )
    relation = summary.drop_duplicates(["reading", "range"]).assign(d=1.0)
    for name, table in (("summary", summary), ("surfaces", surfaces), ("relation", relation)):
        folder.mkdir(parents=True, exist_ok=True)
        table.to_csv(folder / f"{name}.csv", index=False)
    files = ["summary.csv", "surfaces.csv", "relation.csv"]
    for k, (p, c) in enumerate(places):
        own = folder / p / c
        (own / "figures").mkdir(parents=True)
        required_dots = [("farthest", "fresh dots", 0.5, reading, 100, percent + k, 0.55)
                  for reading, percent in (("full", 60.0), ("recovered", 6.4))]  # fmt: skip
        columns = ["sampler", "floor", "Z_floor", "reading", "n_S", "n_S_percent", "Z"]
        pd.DataFrame(required_dots, columns=columns).to_csv(own / "required_dots.csv", index=False)
        for name in (
            "best.json",
            "minimal.csv",
            "grid.csv",
            "view.html",
            "ranges.html",
        ):
            (own / name).write_text("x")
        for name in ("roughness", "required_dots"):
            Image.new("RGB", (200, 100), "red").save(own / f"figures/{name}.png")
        made = (
            "required_dots.csv",
            "view.html",
            "ranges.html",
            "minimal.csv",
            "figures/roughness.png",
            "figures/required_dots.png",
        )
        files += [f"{p}/{c}/{name}" for name in made]
    return files


def first(folder, files, **more):
    return render(TEMPLATE, **first_page(folder, files, **more))


def test_texts_of_numbers():
    assert number(-0.004) == "0.00" and number(-0.006) == "−0.01" and number(np.nan) == number(None) == ""
    assert [share(x) for x in (6.44, 7.0, 9.94, 9.96, 45.2, 99.7, 100.0)] == [
        *("6.4", "7", "9.9", "10", "45", "99.7", "100")
    ]
    assert span([1.0, 1.001]) == "1.00" and span([2.0, 1.0]) == "1.00 to 2.00"
    assert interval(1.0, 0.5, 1.5) == "1.00 (0.50 to 1.50)" and interval(1.0, np.nan, np.nan) == "1.00"
    ends = [(0.1, 0.2), (-0.2, -0.1), (-0.1, 0.1), (np.nan, np.nan)]
    assert [against_zero(*each) for each in ends] == ["above", "below", "around", "unknown"]
    assert code("set `a<b`, <i>") == "set <code>a&lt;b</code>, &lt;i&gt;"


def test_the_card_of_fields_holds_medians_of_the_minimal_subsets(tmp_path):
    places = [("p", "c1"), ("p", "c2"), ("q", "c1")]
    files = write_run(tmp_path / "run", places)
    assert first_page(tmp_path / "run", files, ())["fields"] == []
    for (p, c), r in zip(places, (0.9, 0.95, 0.99), strict=True):
        rows = [("charge", "minimal", r), ("charge", "farthest", 0.1), ("flat", "minimal", np.nan)]
        pd.DataFrame(rows, columns=["field", "subset", "r"]).to_csv(tmp_path / "run" / p / c / "fields.csv")
        files.append(f"{p}/{c}/fields.csv")
    assert first_page(tmp_path / "run", files, ())["fields"] == [("charge", "0.950")]
    assert "r = 0.950" in Page(first(tmp_path / "run", files)).text["card"]


def test_the_cards_hold_what_the_tables_say(tmp_path):
    page = Page(first(tmp_path / "run", write_run(tmp_path / "run")))
    blue, coded = page.text["card"], page.text["card coded"]
    assert "6.4 %" in blue
    assert "d = 2.51" in coded and "d = −0.28" in coded and "55 % of the dots" in coded
    assert "beats a uniform" in coded and "loses to a uniform" in coded
    rows = [row for row in page.rows if row[0] == "30 – 60"]
    assert rows == [
        ["30 – 60", "(1, 0, 4, 0)", "2.51 (2.41 to 2.61)", "(1, 0, 4, 0)", "−0.28 (−0.38 to −0.18)"]
    ]


def test_the_card_of_d_says_what_z_it_stands_for(tmp_path):
    folder = tmp_path / "run"
    files = write_run(folder, [("p", "c1"), ("p", "c2")])
    assert "mean patch" not in Page(first(folder, files)).text["card coded"]
    summary = pd.read_csv(folder / "summary.csv").assign(Z_tS=4.1, Z_tR=6.6, Z_mean_descriptor=1.7)
    summary.to_csv(folder / "summary.csv", index=False)
    coded = Page(first(folder, files)).text["card coded"]
    assert "Its Z is 4.1, that of the uniform subset 6.6." in coded and "would be 1.7." in coded
    assert "95 % intervals lie within 2.41 to 2.61." in " ".join(coded.split())
    assert coded.strip().endswith("Z would be 1.7. So both subsets are worse than the mean patch.")
    summary.assign(Z_tS=1.1).to_csv(folder / "summary.csv", index=False)
    assert Page(first(folder, files)).text["card coded"].strip().endswith("would be 1.7.")
    summary.to_csv(folder / "summary.csv", index=False)
    for conformation, z in (("c1", 2.0), ("c2", 2.8)):
        best = json.dumps({"references": {"Z_two_patches": z}})
        (folder / "p" / conformation / "best.json").write_text(best)
    files += ["p/c1/best.json", "p/c2/best.json"]
    assert (
        "would be 1.7; between two different patches it is 2.4."
        in Page(first(folder, files)).text["card coded"]
    )


def test_z_is_reported_by_the_first_physical_floor_that_was_measured(tmp_path):
    folder = tmp_path / "run"
    files = write_run(folder, [("p", "c1"), ("p", "c2")])
    assert "give Z =" not in first(folder, files)
    surfaces = pd.read_csv(folder / "surfaces.csv").assign(**{"Z_atoms_moved_0.3_Å": [0.8, 1.0]})
    surfaces.to_csv(folder / "surfaces.csv", index=False)
    assert "Atoms moved at random by 0.3 Å give Z = 0.9" in first(folder, files)
    surfaces["Z_frames_1_ps_apart"] = [1.1, 1.3]
    surfaces.to_csv(folder / "surfaces.csv", index=False)
    assert "Two frames of the simulation 1 ps apart give Z = 1.2" in first(folder, files)


def test_the_first_page_is_headed_by_its_question_and_the_proteins(tmp_path):
    page = first(tmp_path / "run", write_run(tmp_path / "run", [("p", "c1"), ("q", "c1")]))
    assert "<h1>How few dots describe the surface of p, q?</h1>" in page
    assert "<title>How few dots describe the surface of p, q?</title>" in page


def test_without_a_grid_the_first_page_begins_with_what_changes(tmp_path):
    folder = tmp_path / "run"
    files = write_run(folder, [("p", "c1"), ("q", "c1")])
    (folder / "changes/opening").mkdir(parents=True)
    (folder / "changes/opening/changes.csv").write_text("total,above_moved\n1,1\n2,0\n3,1\n,0\n")
    files.append("changes/opening/changes.csv")
    sampled = first(folder, files)
    assert "<h1>How few dots describe the surface of p, q?</h1>" in sampled
    assert sampled.index("d = 2.5") < sampled.index("2 of 3") and sampled.count("2 of 3</b> residues of") == 1
    surfaces = pd.read_csv(folder / "surfaces.csv").assign(
        area=380.4, minimal_n_S=90, minimal_n_S_percent=4.5
    )
    surfaces.to_csv(folder / "surfaces.csv", index=False)
    alone = first(folder, [path for path in files if path not in ("summary.csv", "relation.csv")])
    assert "<h1>What changes in opening?</h1>" in alone
    assert "all atoms moved by 0.3 Å</a>. By chance, about 0 would." in alone
    assert alone.index("2 of 3</b> residues of") < alone.index("of the dots bring Z near its floor")
    assert alone.count("2 of 3</b> residues") == 1


def test_d_full_is_that_of_the_range_where_d_kept_is_largest(tmp_path):
    folder = tmp_path / "run"
    files = write_run(folder)
    summary = pd.read_csv(folder / "summary.csv")
    summary.loc[(summary["reading"] == "full") & (summary["range"] == 3), "d_cv"] = 9.0
    summary.to_csv(folder / "summary.csv", index=False)
    assert [card["d"] for card in first_page(folder, files, ())["surfaces"]["d"]] == ["2.51", "−0.28"]


def test_names_that_look_like_numbers_or_gaps_stay_names(tmp_path):
    for names in (["1E96"], ["NA", "012"]):
        folder = tmp_path / names[0]
        files = write_run(folder, [(name, "c1") for name in names])
        table = pd.DataFrame({"protein": names, "conformation": "", "job": "", "sentence": "Odd."})
        table.to_csv(folder / "warnings.csv", index=False)
        known = first_page(folder, files, ())
        assert known["surfaces"]["proteins"] == names and known["warnings"] == [(names, "Odd.")]


def test_without_a_grid_each_surface_has_a_row_and_a_picture(tmp_path):
    folder = tmp_path / "run"
    files = [*write_run(folder, [("p", "c1"), ("q", "c1")]), "p/c1/view.png"]
    Image.new("RGB", (200, 100), "red").save(folder / "p/c1/view.png")
    of_grid = (
        "summary.csv",
        "relation.csv",
        "ranges.html",
        "figures/roughness.png",
        "figures/required_dots.png",
    )
    files = [path for path in files if not path.endswith(of_grid)]
    surfaces = pd.read_csv(folder / "surfaces.csv")
    surfaces = surfaces.assign(area=[380.4, 420.0], minimal_n_S=[1234, 90], minimal_n_S_percent=[4.51, 12.2])
    surfaces.to_csv(folder / "surfaces.csv", index=False)
    text = first(folder, files)
    page = Page(text)
    assert [row[1:-1] for row in page.rows[1:]] == [
        ["p", "2,000", "380", "0.60", "1,234", "4.5"],
        ["q", "2,001", "420", "0.60", "90", "12"],
    ]
    assert [source[:23] for source in page.sources] == ["data:image/webp;base64,"]
    assert {"p/c1/view.html", "q/c1/minimal.csv"} <= set(page.links)
    assert "d = " not in text and "Best" not in text and "Look closer" not in text
    assert "cross-validated" not in text
    asked = Page(first(folder, files, floor=None)).text["card"]
    assert (
        "8.4 % of the dots are in the minimal subset" in asked
        and "6.9 % of the dots bring Z near its floor" in asked
    )


def test_several_surfaces_are_counted_and_spread(tmp_path):
    folder = tmp_path / "run"
    files = write_run(folder, [("p", f"c{k}") for k in range(1, 6)])
    known = first_page(folder, files, ())
    assert known["surfaces"]["required_dots"]["percent"] == "8.4"  # 6.4 to 10.4
    assert known["surfaces"]["required_dots"]["span"] == "6.4 to 10"
    assert known["surfaces"]["d"][0]["places"]["above"] == 5
    text = render(TEMPLATE, **known)
    assert "on all surfaces" in text and text.count("<details") == 1  # the galleries beyond three
    places = [heading for heading, *_ in known["galleries"]]
    assert places == [f"p/c{k}" for k in range(1, 6)]


def test_a_run_begins_with_what_failed_and_its_warnings(tmp_path):
    folder = tmp_path / "run"
    files = write_run(folder)
    table = pd.DataFrame(
        [("p", "c1", "make_surface", "Left out: `HEM` <x>."), ("q", "", "", "Cut short.")] * 2,
        columns=["protein", "conformation", "job", "sentence"],
    )
    table.to_csv(folder / "warnings.csv", index=False)
    text = first(folder, files, exclude=[("<b>bad</b>", "no atoms & no hope.")])
    note = Page(text).text["note"]
    assert "<b>bad</b>" in note and "no atoms & no hope." in note and "<b>bad" not in text
    assert "2 warnings" in note and "p: Left out: HEM <x>." in note and "q: Cut short." in note
    assert '<details class="note" open>' in text
    assert text.index('class="note"') < text.index('class="cards"')
    many = pd.DataFrame(
        {"protein": "p", "conformation": "c1", "job": "", "sentence": [f"No {'x' * k}." for k in range(50)]}
    )
    many.to_csv(folder / "warnings.csv", index=False)
    text = first(folder, files)
    assert "50 warnings" in text and '<details class="note">' in text and 'href="warnings.csv"' in text


def test_warnings_that_differ_in_numbers_only_are_reported_once(tmp_path):
    folder = tmp_path / "run"
    files = write_run(folder)
    sentences = [("p", "c1", "p/c1: 5.6 dots, A/7: few"), ("q", "c1", "q/c1: 5.71 dots, A/12: few")]
    sentences += [
        ("q", "", f"/far/away/{name}.pdb: left out 1 {what}") for name, what in (("qX", "X"), ("qY", "Y"))
    ]
    sentences += [("r", "", "/far/r.pdb: left out 1 X")]
    sentences += [("pairs", name, f"{name}, partner {k}: odd") for name in ("ab", "bc") for k in (1, 2)]
    table = pd.DataFrame(sentences, columns=["protein", "conformation", "sentence"]).assign(job="")
    table.to_csv(folder / "warnings.csv", index=False)
    text = first(folder, files)
    note = Page(text).text["note"]
    assert "9 warnings" in note and "pairs/ab and 3 others alike: ab, partner 1: odd" in note
    assert "p and 1 other alike: 5.6 dots, A/7: few" in note
    assert "5.71" not in note and "far" not in note and 'href="warnings.csv"' in text
    assert "q: qX.pdb: left out 1 X" in note
    assert '<details class="note">' in text


def test_other_parts_of_a_run_have_a_card_each(tmp_path):
    folder = tmp_path / "run"
    files = write_run(folder)
    places = [{"d_inside": d, "Z_tS_inside": 1, "n_runs": 40} for d in (1, 0)]
    pd.DataFrame(places).to_csv(folder / "paper_places.csv", index=False)
    (folder / "pairs").mkdir()
    scores = {"propensity_smoothed": (0.56, 0.6, 0.58, 0.58), "protrusion": (0.7, 0.7, 0.8, 0.6)}
    rows = [(pair, side, score, auc, auc - 0.1, auc + 0.1) for score, aucs in scores.items()
            for (pair, side), auc in zip((("007", 1), ("007", 2), ("b", 1), ("b", 2)), aucs, strict=True)]  # fmt: skip
    table = pd.DataFrame(rows, columns=["complex", "partner", "score", "auc", "low", "high"])
    table.to_csv(folder / "pairs" / "pairs.csv", index=False)
    pd.DataFrame({"d_kept": [2.0, 3.0]}).to_csv(folder / "p" / "ensemble.csv", index=False)
    files += [
        "paper_places.csv",
        "pairs/pairs.csv",
        "p/ensemble.html",
        *(f"pairs/{name}/agreement.csv" for name in ("007", "b", "apart")),
        "pairs/b/propensity.csv",
    ]
    known = first_page(folder, files, ())
    assert known["paper"] == {"d": 1, "Z_tS": 2, "rows": 2, "runs": 40}
    assert known["pairs"] == {
        "n": 3,
        "touching": 2,
        "auc": "0.58 (0.58 to 0.58)",
        "baseline": "0.70 (0.70 to 0.70)",
        "place": "above",
        "partners": [],
        "rows": [
            ("007", [], [(1, "0.56 (0.46 to 0.66)", "0.70 (0.60 to 0.80)"),
                         (2, "0.60 (0.50 to 0.70)", "0.70 (0.60 to 0.80)")]),
            ("b", ["pairs/b/propensity.csv"], [(1, "0.58 (0.48 to 0.68)", "0.80 (0.70 to 0.90)"),
                                               (2, "0.58 (0.48 to 0.68)", "0.60 (0.50 to 0.70)")]),
            ("apart", [], []),
        ],
    }  # fmt: skip
    alone = pairs_section(table[table["complex"] == "b"], files)
    said = " ".join(Page(render(TEMPLATE, **known | {"pairs": alone})).text["cards"].split())
    assert "AUC 0.58 (0.48 to 0.68) on partner 1, AUC 0.58 (0.48 to 0.68) on partner 2 for smoothed" in said
    assert "Protrusion alone has 0.80 (0.70 to 0.90) and 0.60 (0.50 to 0.70)." in said
    none = render(TEMPLATE, **known | {"pairs": pairs_section(table[:0], files)})
    assert "No interface among 3 pairs." in " ".join(Page(none).text["cards"].split())
    assert known["ensembles"] == [("p", {"frames": 2, "reading": "kept", "d": "2.5", "sd": "0.7"})]
    text = render(TEMPLATE, **known)
    assert {"verdict.html", "pairs/pairs.csv", "p/ensemble.html"} <= set(Page(text).links)
    said = (
        " ".join(Page(text).text["cards"].split()) if "cards" in Page(text).text else " ".join(text.split())
    )
    assert "over 2 frames of p, one combination," in said and "among the kept dots" in said


def test_the_samplers_of_several_surfaces_are_compared_in_one_figure():
    files = ["compare.csv", "compare.png", "p/c1/view.html"]
    figure = ("All surfaces", [("compare.csv", "compare")], [("compare.png", "compare.png", "compare")])
    assert galleries([("p", "c1"), ("q", "c1")], files)[0] == figure
    assert figure not in galleries([("p", "c1")], files)


@pytest.mark.parametrize(("touching", "name"), [("ab", "pairs"), ("b", "book"), ("", "book")])
def test_fewer_than_two_pairs_that_touch_show_their_map_on_the_first_page(tmp_path, touching, name):
    (tmp_path / "pairs").mkdir()
    pd.DataFrame({"complex": [*touching]}).to_csv(tmp_path / "pairs" / "pairs.csv", index=False)
    files = [
        "pairs/pairs.csv",
        "pairs/pairs.png",
        "pairs/a/book.png",
        "pairs/b/book.png",
        "pairs/b/view.html",
    ]
    main = main_figure(tmp_path, files, "")
    assert main == {"path": {"pairs": "pairs/pairs.png", "book": "pairs/a/book.png"}[name], "name": name}
    shown = [picture for _, _, items in pair_galleries(files, main["path"]) for _, picture, _ in items]
    assert shown == ["pairs/a/book.png"] * (name == "pairs") + ["pairs/b/book.png", ""]


def test_one_frame_has_no_spread(tmp_path):
    table = pd.DataFrame(
        {"N": [100], "area": 10.0, "mean_roughness": 0.5, "n_S_percent": 40.0, "d_kept": 2.0}
    )
    page = Page(render(ensemble_page.TEMPLATE, **ensemble_page.ensemble_page("p", table, [1, 0, 6, 0])))
    assert "Over 1 frame," in page.text["answer"] and "±" not in page.text["answer"]
    files = write_run(tmp_path)
    table.to_csv(tmp_path / "p" / "ensemble.csv", index=False)
    card = Page(first(tmp_path, [*files, "p/ensemble.html"])).text["card coded"]
    assert "d = 2.0 over 1 frame of p" in card


def test_only_readings_that_were_tried_are_reported(tmp_path):
    files = write_run(tmp_path)
    assert "removed in two ways: among the kept dots" in first(tmp_path, files)
    for name in ("summary", "relation"):
        table = pd.read_csv(tmp_path / f"{name}.csv")
        table[table["reading"] == "full"].to_csv(tmp_path / f"{name}.csv", index=False)
    surfaces = pd.read_csv(tmp_path / "surfaces.csv")
    surfaces.drop(columns="best_kept").to_csv(tmp_path / "surfaces.csv", index=False)
    page = first(tmp_path, files)
    assert "in two ways" not in page and "d = −0.06" in page


def test_the_page_stands_alone_and_is_small(tmp_path):
    folder = tmp_path / "run"
    page = first(folder, write_run(folder, [(f"p{k}", "c1") for k in range(65)]))
    assert len(page.encode()) < 60_000
    assert {source[:23] for source in Page(page).sources} == {"data:image/webp;base64,"}
    for path in Page(page).links:
        assert not re.match(r"\w+:|//", path), path
        assert path == "#words" or (folder / path).is_file()


def test_figures_beyond_the_size_of_a_page_are_read_from_the_folder(tmp_path, monkeypatch):
    files = write_run(tmp_path, [(f"p{k}", "c1") for k in range(3)])
    url = len(embedded_figures(tmp_path, ["p0/c1/figures/roughness.png"]).popitem()[1])
    monkeypatch.setattr("sparsurf.report.page.MAX_PAGE_BYTES", 2 * url)
    page = Page(first(tmp_path, files))
    outside = [source for source in page.sources if not source.startswith("data:")]
    assert outside == [
        f"p{k}/c1/figures/{name}.png" for k in (1, 2) for name in ("roughness", "required_dots")
    ]
    assert "holds its figures, except the last 4" in page.text["soft"]


def test_a_figure_inside_a_page_is_the_picture_of_its_file_but_smaller(tmp_path):
    Image.new("RGBA", (3200, 800), (0, 80, 160, 255)).save(tmp_path / "a.png")
    urls = embedded_figures(tmp_path, ["a.png", "missing.png", "a.png"])
    assert list(urls) == ["a.png"]
    picture = Image.open(io.BytesIO(base64.b64decode(urls["a.png"].removeprefix("data:image/webp;base64,"))))
    assert picture.size == (1600, 400)
    assert np.allclose(np.asarray(picture.convert("RGB")).mean(axis=(0, 1)), (0, 80, 160), atol=4)


@pytest.mark.skipif(None in programs(), reason="chromium and chromedriver are not installed")
def test_a_page_that_was_sent_alone_enlarges_its_figures(tmp_path):
    page, browser = tmp_path / "sent.html", Browser(tmp_path)
    page.write_text(first(tmp_path / "run", write_run(tmp_path / "run")))
    try:
        browser.open(page.as_uri())
        assert browser.run("return [...document.querySelectorAll('.zoom img')].map(i => i.naturalWidth)") == [
            200,
            200,
            200,
        ]
        arrow = "return getComputedStyle(document.querySelector(arguments[0]), '::after').content"
        assert browser.run(arrow, "a[href$='view.html']").endswith('↗"')
        assert browser.run(arrow, "a[href='#words']") == "none"
        browser.click(".zoom")
        assert browser.run("return document.querySelector('dialog').open")
        assert browser.run("return document.querySelector('dialog img').naturalWidth") == 200
        browser.click("dialog")
        assert not browser.run("return document.querySelector('dialog').open")
        browser.screen(400, 800)
        assert browser.run("return document.documentElement.scrollWidth") <= 400
        assert browser.complaints() == []
    finally:
        browser.close()


def test_a_single_structure_goes_by_its_name_alone():
    places = [("p", "c1"), ("q", "c1"), ("q", "c2"), ("r", "f0000")]
    assert list(short_names(places).values()) == ["p", "q/c1", "q/c2", "r/f0000"]


@pytest.mark.parametrize(
    ("places", "offered"),
    [
        ([("p", "c1"), ("p", "c2")], ["p/c1/minimal.csv", "p/c1/required_dots.csv"]),
        ([("p", "c1"), ("q", "c1")], []),
    ],
)
def test_files_are_offered_of_a_single_protein_only(tmp_path, places, offered):
    known = first_page(tmp_path / "run", write_run(tmp_path / "run", places), ())
    assert [path for path, _ in known["taken"]] == offered


def test_names_are_escaped_everywhere(tmp_path):
    name = "<b>x&y"
    known = first_page(tmp_path / "run", write_run(tmp_path / "run"), ())
    known["run"], known["galleries"] = name, [(name, [], [(f"{name}/view.html", "", "view")])]
    known["taken"] = [(f"{name}/minimal.csv", name)]
    known["pairs"] = pairs_section(
        pd.DataFrame(columns=["complex", "partner"]), [f"pairs/{name}/propensity.csv"]
    )
    page = render(TEMPLATE, **known)
    assert "<b>x" not in page and "&lt;b&gt;x&amp;y" in page
    assert not [path for path in Page(page).links if "<" in path]


def test_the_script_writes_the_first_page_and_what_failed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = Path("results", "run")
    results = [str(folder / path) for path in write_run(folder)]
    names = ("index.html", "failures.csv", "warnings.csv", "crate.json")
    page, failures, warnings, crate = paths = [folder / name for name in names]
    close_run.main(results, *map(str, paths), {"q": "too few dots."}, "fresh dots", f"{folder}/logs", [])
    assert warnings.read_text() == "protein,conformation,job,sentence\n" and crate.is_file()
    assert "q: too few dots." in Page(page.read_text()).text["note"]
    assert failures.read_text() == "place,reason\nq,too few dots.\n"
    assert (
        page.read_text().count("data:image/webp;base64,") == 3  # the main figure, and both of the gallery
        and "prefers-color-scheme" in page.read_text()
    )


def test_the_crate_lists_every_file_of_the_run_with_its_size(tmp_path):
    folder = tmp_path / "run"
    files = [*write_run(folder), "p/a b.csv"]
    (folder / "p/laid").mkdir()
    (folder / "p/laid/1.pdb").write_text("END\n")
    (folder / "p/a b.csv").write_text("x\n1\n")
    outputs = {"crate": folder / "c.json"}
    close_run.write_crate([str(folder / path) for path in [*files, "p/laid"]], str(outputs["crate"]))
    by = {each["@id"]: each for each in json.loads(outputs["crate"].read_text())["@graph"]}
    listed = [unquote(each["@id"]) for each in by["./"]["hasPart"]]
    assert listed == [*files, "p/laid/1.pdb"] and "p/a%20b.csv" in by
    for path in listed:
        assert by[quote(path)]["contentSize"] == str((folder / path).stat().st_size)
    assert by["p/a%20b.csv"]["encodingFormat"] == "text/csv"
    assert by["p/c1/minimal.csv"]["description"].startswith("the minimal subset")
    assert by["ro-crate-metadata.json"]["about"] == {"@id": "./"} and by["./"]["@type"] == "Dataset"
    assert by["#sparsurf"]["version"] == sparsurf.__version__


def test_check_names_files_that_were_changed_with_their_time_kept_or_are_missing(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(check_run, "RESULTS", tmp_path / "results")
    folder, config = tmp_path / "results" / "mine", tmp_path / "mine.yaml"
    config.write_text("run: mine\n")
    assert check_run.main(config) == 2 and "There is no " in capsys.readouterr().err
    folder.mkdir(parents=True)
    files = [folder / name for name in ("a b.csv", "grid.csv", "roughness.csv", "view.html")]
    for path in files:
        path.write_text("x\n1\n2\n")
    close_run.write_crate(list(map(str, files)), str(folder / close_run.CRATE))
    assert check_run.main(config) == 0 and capsys.readouterr().out.startswith("4 of 4 files in results/mine/")
    for path, text in ((files[1], "x\n1\n3\n"), (files[2], "x\n1")):
        times = path.stat().st_atime_ns, path.stat().st_mtime_ns
        path.write_text(text)
        os.utime(path, ns=times)
    files[3].unlink()
    assert check_run.main(config) == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(". ")[0] for line in lines[:3]] == [
        "results/mine/grid.csv differs from what the run wrote",
        "results/mine/roughness.csv differs from what the run wrote",
        "results/mine/view.html is missing",
    ]
    assert len(lines) == 4
    (folder / close_run.CRATE).write_text("{")
    assert check_run.main(config) == 2 and "is damaged" in capsys.readouterr().err


def test_figures_that_are_missing_or_too_large_stay_outside(tmp_path, monkeypatch):
    path = tmp_path / "a.png"
    assert embedded(path) is None
    path.write_bytes(b"x")
    assert embedded(path) == "data:image/png;base64,eA=="
    monkeypatch.setattr("sparsurf.report.page.MAX_FIGURE_BYTES", 0)
    assert embedded(path) is None


def test_frames_are_summarised_by_mean_and_spread():
    columns = {
        "N": [100, 200, 200],
        "area": 10.0,
        "mean_roughness": [0.5, 0.6, 0.6],
        "n_S_percent": [40.0, 40, 55],
    }
    table = pd.DataFrame(columns | {"d_kept": [2.0, 3.0, 3.0], "d_full": -0.25})
    page = Page(render(ensemble_page.TEMPLATE, **ensemble_page.ensemble_page("p", table, [1, 0, 6, 0])))
    assert ["n_S / %", "45.0", "8.7", "40.0", "55.0"] in page.rows
    assert ["d among the kept dots", "2.67", "0.58", "2.00", "3.00"] in page.rows
    assert ["d on the full surface", "−0.25", "0.00", "−0.25", "−0.25"] in page.rows
    assert "(1, 0, 6, 0) keeps 45.0 ± 8.7 %" in page.text["answer"]


@pytest.mark.parametrize("related, tests", [(1, 20), (3, 20), (4, 20), (1, 2), (0, 0)])
def test_the_answer_on_mean_roughness_follows_from_the_tests(related, tests):
    known = {"surfaces": [], "floors": []} | {
        "run": "r",
        "relations": {},
        "draws": 6,
        "readings": [],
    }
    known |= {
        "related": related,
        "rows_tested": tests,
        "by_chance": {20: 3, 2: 0, 0: 0}[tests],
    }
    page = Page(render(summary_page.TEMPLATE, **known | {"floors": [["turned", "7", "5"]]}))
    header = ["noise floor", "dots as they are / %", "surface recovered from them / %"]
    assert page.rows[page.rows.index(["turned", "7", "5"]) - 1] == header
    answer = page.text["answer"]
    said = [words for words in ("does not predict", "goes with", "can tell") if words in answer]
    wanted = {1: "does not predict", 3: "does not predict", 4: "goes with"}
    assert said == [wanted[related] if tests == 20 else "goes with" if tests else "can tell"]


def test_every_answer_is_short_and_no_sentence_long():
    for path in TEMPLATES.glob("*.html.j2"):
        text = re.sub(r"(?s)\{[{%#].*?[}%#]\}", " x ", path.read_text(encoding="utf-8"))
        paragraphs = re.split(r"</?(?:p|li|td|th|dd|figcaption|div|h\d)\b[^>]*>|\n", text)
        for sentence in (s for part in paragraphs for s in re.split(r"(?<=[.!?])\s", part)):
            words = [word for word in re.sub(r"<[^>]+>", " ", sentence).split() if word != "x"]
            assert len(words) <= 28, f"{path.name}: {' '.join(words)}"
