"""Pages of the small study: what a reader looks for is that of the tables, each link leads to a file."""

import base64
import io
import re
from urllib.parse import unquote, urldefrag

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from accessibility import inaccessible
from parsed_pages import Page
from sparsurf.cli.minimal import share_kept
from sparsurf.views.numbers import decimals, interval, number, share, signed
from sparsurf_study.report import page as pages
from sparsurf_study.report.numbers import against_zero, interval_of, left_in_island, p_value, short_names
from sparsurf_study.report.page import code, embedded_figures


@pytest.fixture(scope="module")
def run(study):
    """Folder of the results."""
    return study / "results" / "small"


@pytest.fixture(scope="module")
def shown(run):
    """What each page of the run holds."""
    return {path: Page(path.read_text(encoding="utf-8")) for path in run.rglob("[!.]*.html")}


def facts(run):
    """Yield what a reader looks for: the name of each fact, and its texts, which stand in one row of a page."""
    for path in sorted(run.glob("*/*/ranges.csv")):
        for row in pd.read_csv(path).dropna(subset="d_cv").to_dict("records"):
            d = interval(row["d_cv"], row["d_cv_low"], row["d_cv_high"])
            yield (
                f"{path.parent}, {row['reading']}, from {row['n_S_low_percent']} %",
                [f"{number(row['n_S_low_percent'], 0)} to {number(row['n_S_high_percent'], 0)} %", d],
            )
    surfaces = pd.read_csv(run / "surfaces.csv")
    for row in surfaces[surfaces["best_kept"].isna()].to_dict("records"):
        texts = [
            f"{row['N']:,}",
            f"{row['area']:,.0f}",
            number(row["mean_roughness"]),
            f"{row['minimal_n_S']:,}",
        ]
        texts += [number(row["minimal_n_S_percent"], 1), number(row["recovered_mean"], 3)]
        texts += [number(row[f"recovered_Z_{kind}"]) for kind in ("published", "rotation_robust")]
        yield row["protein"], [row["protein"], *texts]
    pairs = pd.read_csv(run / "pairs/pairs.csv").query("score in ('propensity_smoothed', 'protrusion')")
    for (name, side), rows in pairs.groupby(["complex", "partner"]):
        yield f"{name}, partner {side}", [str(side), *map(interval, rows["auc"], rows["low"], rows["high"])]
    frames = pd.read_csv(run / "moving/ensemble.csv")
    digits = {"N": 0, "area": 0, "mean_roughness": 3, "n_S_percent": 1, "d_kept": 2, "d_full": 2}
    for column, n in digits.items():
        yield (
            f"{column} over time",
            [number(x, n) if n else f"{x:,.0f}" for x in frames[column].agg(["mean", "std", "min", "max"])],
        )
    changes = pd.read_csv(run / "changes/bend/changes.csv")
    floors = ["total_floor", "total_moved"]
    changes = changes.assign(over=changes["total"] / changes[floors].max(axis=1)).nlargest(10, "over")
    for row in changes.to_dict("records"):
        name = f"{row['residue_name']}{row['residue']}"
        yield name, [name, *(number(row[column]) for column in ("total", *floors))]


def test_what_a_reader_looks_for_stands_on_a_page_as_in_its_table(run, shown):
    """In any row of any page, in the order of its cells."""
    rows = [row for page in shown.values() for row in page.rows]
    wanted = [*facts(run)]
    found = [
        any(all(any(text in cell for cell in cells) for text in texts) for cells in map(iter, rows))
        for _, texts in wanted
    ]
    assert len(found) > 50 and not [name for (name, _), known in zip(wanted, found, strict=True) if not known]


def test_a_page_states_area_volume_and_handles_of_the_tables(run, shown):
    """Exact areas differ from the sums over dots by some Å^2, and its page states them, too."""
    surfaces = pd.read_csv(run / "surfaces.csv").set_index(["protein", "conformation"])["area"]
    for (protein, conformation), area in surfaces.items():
        folder = run / protein / conformation
        if (folder / "residues.csv").is_file():
            assert area == pytest.approx(pd.read_csv(folder / "residues.csv")["area"].sum(), rel=1e-5)
            assert area != pytest.approx(np.load(folder / "surface.npz")["area"].sum(), rel=1e-5)
            words = shown[folder / "surface.html"].words.replace("\xa0", " ")
            assert f" has an area of {area:,.0f} Å²" in words
            parts = pd.read_csv(folder / "components.csv")
            volume = np.where(parts["cavity"], -1, 1) @ parts["volume"]
            assert f"a volume of {volume:,.0f} Å³, {parts['handles'].sum():.0f} handle" in words


def test_each_link_leads_to_a_file_and_its_place(shown):
    """On every page, so that a folder of results can be sent; nothing is read from another site."""
    assert len(shown) > 8
    for path, page in shown.items():
        for link in {*page.links, *(source for source in page.sources if not source.startswith("data:"))}:
            address, anchor = urldefrag(unquote(link))
            target = (path.parent / address).resolve() if address else path
            assert target.exists(), f"{path}: {link}"
            assert not anchor or anchor in shown[target].anchors, f"{path}: {link}"


def test_no_page_shows_a_value_of_the_program(shown):
    for path, page in shown.items():
        assert not re.search(r"\b(nan|None|inf|NaN)\b|\{\{|\bTrue\b|<[a-z]", page.text), path


def test_a_page_that_was_sent_alone_enlarges_its_figures(run, tmp_path, browser):
    (sent := tmp_path / "sent.html").write_bytes((run / "index.html").read_bytes())
    browser.open(sent)
    widths = browser.run("return [...document.querySelectorAll('.zoom img')].map(i => i.naturalWidth)")
    assert widths and min(widths) > 100
    browser.run("document.querySelector('.zoom').click()")
    assert browser.run("return document.querySelector('dialog').open")
    assert browser.run("return document.querySelector('dialog img').naturalWidth") == widths[0]
    browser.click("dialog")
    assert not browser.run("return document.querySelector('dialog').open")
    browser.screen(400, 800)
    assert browser.run("return document.documentElement.scrollWidth") <= 400


def test_one_choice_shows_a_surface_in_every_section(run, browser):
    browser.open(run / "index.html")
    shown = "return [...document.querySelectorAll('div.place')].filter(e => e.checkVisibility()).map(e => e.className)"
    assert {*browser.run(shown)} == {"place place-0"}
    browser.press("input[name=place]", "ArrowRight")  # the arrow key, to the second
    found = browser.run(shown)
    assert {*found} == {"place place-1"} and len(found) >= 4  # pictures, ranges, maps and residues
    browser.media(media="print")
    assert {"place place-0", "place place-1"} <= {*browser.run(shown)}


def test_the_answers_are_on_the_first_screen(run, browser):
    browser.open(run / "index.html")
    ends = browser.run(
        "return [...document.querySelectorAll('.card')].map(e => e.getBoundingClientRect().bottom)"
    )
    assert len(ends) == 8 and max(ends[:4]) < 500 and max(ends) < 800


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_are_accessible(run, shown, browser, scheme):
    """Names, text alternatives and contrast (WCAG 2, AA); with axe-core as well where npm has it."""
    browser.media(scheme)
    pages_of_run = [path for path in shown if path.name in ("index.html", "verdict.html")]
    assert len(pages_of_run) == 2
    for path in pages_of_run:
        browser.open(path)
        assert inaccessible(browser) == [], path


@pytest.mark.parametrize("name", ["roughness", "sampled", "minimal"])
def test_a_picture_of_the_first_page_shows_the_whole_surface_and_its_dots(run, name):
    """It has the size at which the page shows it, the surface touches two sides at most, and kept dots have their colour."""
    with Image.open(run / f"moving/f0000/pictures/{name}.png") as stored:
        picture = np.asarray(stored.convert("RGB")).astype(int)
    assert picture.shape == (480, 640, 3)
    red, _, blue = np.moveaxis(picture, 2, 0)
    coloured = {
        "roughness": abs(red - blue) > 60,
        "sampled": (red > 150) & (blue < 60),
        "minimal": (blue > 90) & (red < 60),
    }
    corners = picture[[0, 0, -1, -1], [0, -1, 0, -1]]
    assert corners.min() == 255 and 0.005 < coloured[name].mean() < 0.6


def test_a_page_holds_its_figures_smaller_and_up_to_its_size(tmp_path, monkeypatch):
    for name in ("a b", "c", "d"):
        Image.new("RGBA", (3200, 800), (0, 80, 160, 255)).save(tmp_path / f"{name}.png")
    urls = embedded_figures(tmp_path, ["a b.png", "missing.png", "c.png", "a b.png", "d.png"])
    assert [*urls] == ["a b.png", "c.png", "d.png"]
    picture = Image.open(io.BytesIO(base64.b64decode(urls["c.png"].removeprefix("data:image/webp;base64,"))))
    assert picture.size == (1600, 400)
    assert np.allclose(np.asarray(picture.convert("RGB")).mean(axis=(0, 1)), (0, 80, 160), atol=4)
    monkeypatch.setattr(pages, "MAX_PAGE_BYTES", 2 * len(urls["c.png"]) + 9)
    assert [*embedded_figures(tmp_path, ["a b.png", "c.png", "d.png"])] == ["a b.png", "c.png"]


def test_texts_of_numbers():
    assert number(-0.004) == "0.00" and number(-0.006) == "−0.01" and number(np.nan) == number(None) == ""
    texts = {6.44: "6.4", 7.0: "7", 9.94: "9.9", 9.96: "10", 45.2: "45", 99.7: "99.7", 100: "100"}
    assert [share(x) for x in texts] == [*texts.values()]
    assert interval(1.0, 0.5, 1.5) == "1.00 (0.50 to 1.50)" and interval(1.0, np.nan, np.nan) == "1.00"
    assert [signed(x, 1) for x in (0.04, -1.26, 0.06, np.nan)] == ["0.0", "−1.3", "+0.1", ""]
    shares = {0.456: "46 %, fragmented", 0.5: "50 %", 0.8: "80 %", np.nan: "–"}
    assert [left_in_island({"share_in_island": x}) for x in shares] == [*shares.values()]
    assert [p_value(p) for p in (0.02345, 0.5, 1e-4, 9e-5)] == ["0.023", "0.5", "0.0001", "below 0.0001"]
    row = {"d": 1.0, "d_low": 0.5, "d_high": 2.0, "d_full": -1.0, "d_low_full": -2.0, "d_high_full": 0.25}
    assert interval_of(row, "d") == "1.00 (0.50 to 2.00)"
    assert interval_of(row, "d", "full") == "−1.00 (−2.00 to 0.25)"
    ends = [(0.1, 0.2), (-0.2, -0.1), (-0.1, 0.1), (np.nan, np.nan)]
    assert [against_zero(*each) for each in ends] == ["above", "below", "around", "unknown"]
    places = [("p", "c1"), ("q", "c1"), ("q", "c2"), ("r", "f0000")]
    assert [*short_names(places).values()] == ["p", "q/c1", "q/c2", "r/f0000"]
    assert code("set `a<b`, <i>") == "set <code>a&lt;b</code>, &lt;i&gt;"


def test_shares_and_densities_of_very_few_dots_have_two_digits():
    """39 of 24,600 dots were written as 0.2 % with an interval from 0.1 to 0.1 %, and as 0.00 per Å^2."""
    assert share_kept(39, 24600, (33, 45)) == "0.16 %; 95 % interval 0.13 to 0.18 %"
    assert share_kept(39, 24600, None) == "0.16 %" and share_kept(1230, 24600, None) == "5 %"
    assert [number(x, decimals(x, 2)) for x in (39 / 4560, 0.1234, 5.351)] == ["0.0086", "0.12", "5.35"]
