"""Numbers and lists of the pages are those of evidence/tables and of the code, and read without the book."""

import re
import urllib.parse
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

import renew
import table_numbers
from conftest import ROOT
from parsed_pages import Page
from sparsurf.cli.recover import EXAMPLES

PAGES = pytest.mark.parametrize("page", renew.PAGES, ids=lambda path: str(path.relative_to(ROOT)))
FARTHEST = 'recover_opponents_means.csv "sampler=farthest dots" percent=10'


def html(page: Path) -> str:
    """A page as GitHub shows it: tables and comments, but no directive of the book."""
    return MarkdownIt("commonmark").enable("table").render(page.read_text(encoding="utf-8"))


def headings(page: Path) -> set[str]:
    """The anchors that GitHub and the book give the headings of a page."""
    text = re.sub(r"(?ms)^```.*?^```", "", page.read_text(encoding="utf-8"))
    return {
        re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-")
        for title in re.findall(r"(?m)^#+ (.*)$", text)
    }


@PAGES
def test_a_page_is_up_to_date(page: Path) -> None:
    old, new = (content.splitlines() for content in (page.read_text(encoding="utf-8"), renew.renewed(page)))
    stale = [pair for pair in zip(old, new, strict=False) if pair[0] != pair[1]]
    assert old == new, f"run .venv/bin/python docs/renew.py: {page.name} has {stale[:3]}"


@PAGES
def test_a_page_shows_nothing_raw(page: Path) -> None:
    shown = re.sub(r"(?s)<!--.*?-->|<code[^>]*>.*?</code>|\$+.*?\$+", "", html(page))
    assert not re.search(r"\{\{|\}\}|:::|\{(?:figure|toctree|eval-rst|include)\}|--&gt;|&lt;!--", shown)
    assert 'class="language-{' not in html(page)


def test_pages_hold_no_comment_and_entries_belong_to_pages() -> None:
    for page in [ROOT / "README.md", *ROOT.glob("docs/*.md")]:
        assert "<!--" not in page.read_text(encoding="utf-8"), page
    assert {ROOT / name for name in table_numbers.of_pages()} <= {*renew.PAGES}


@PAGES
def test_every_row_of_a_table_has_as_many_cells_as_its_header(page: Path) -> None:
    lines = re.sub(r"(?ms)^```.*?^```|<!--.*?-->", "", page.read_text(encoding="utf-8"))
    for table in re.findall(r"(?m)(?:^\|.*\n)+", lines):
        cells = {len(re.findall(r"(?<!\\)\|", row)) for row in table.splitlines()}
        assert len(cells) == 1, table


@PAGES
def test_every_link_and_picture_of_a_page_is_a_file_of_the_repository(page: Path) -> None:
    shown = Page(html(page))
    for link in {*shown.links, *shown.sources}:
        address, _, anchor = link.partition("#")
        if "://" in address:
            continue
        target = (page.parent / urllib.parse.unquote(address)).resolve() if address else page
        assert target.exists() and not {"_gallery", "_build"} & {*target.parts}, link
        if anchor and target.suffix == ".md":
            assert urllib.parse.unquote(anchor) in headings(target), link


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "t.csv").write_text(
        "name,percent,Z,best\nfarthest dots,5,-0.564,(1; 0)\nfarthest dots,10,,(1; 0)\nuniform,10,1234.56,(2; 0)\n"
    )
    return tmp_path


@pytest.mark.parametrize(
    ("old", "phrase", "new"),
    [
        ("Z is 999", "Z is {Z:,.0f}", "Z is 1,235"),
        ("Z is 1,235", "Z is {Z:,.0f}", "Z is 1,235"),
        ("Z is ?", "Z is {Z:.2f}", "Z is 1234.56"),
        ("Of (2, 11 (−3\nto 7)", "(2, {percent} ({Z:.0f} to {Z:.0f})", "Of (2, 10 (1235\nto 1235)"),
        ("Z\nis 999", "Z is {Z:.0f}", "Z\nis 1235"),
        ("Z is 7.5 and 999", "Z is {} and {Z:.0f}", "Z is 7.5 and 1235"),
        ("1 Z, 11 Z", "11 Z", "1 Z, 11 Z"),
        ("see (1; 9)", "see {best}", "see (2; 0)"),
        ("+0.1%", "{Z:+.1%}", "+123456.0%"),
        ("here (random)", "({name}).", "here (uniform)"),
    ],
)
def test_the_numbers_of_a_phrase_are_those_of_its_row(folder: Path, old: str, phrase: str, new: str) -> None:
    entry = {"phrase": phrase, "row": "t.csv name=uniform"}
    assert table_numbers.renewed(f"{old}.\n", {"entries": [entry]}, folder) == f"{new}.\n"


def test_the_rows_of_a_table_are_those_of_its_entry(folder: Path) -> None:
    head, tail = "| a | b |\n| - | --: |\n| 1 | 2 |\n\nText | 3\n\n| % | Z |\n|---|:-:|\n", "\nZ is 4.\n"
    entry = {
        "header": "| % | Z |",
        "rows": [
            {"row": 't.csv "name=farthest dots"', "form": "| {percent:g} | {Z:.2f} |"},
            {"row": "t.csv name=uniform", "form": "| all: | {Z:.0f} |"},
        ],
    }
    rows = "| 5 | −0.56 |\n| 10 |  |\n| all: | 1235 |\n"
    for old in ("", "| 5 | 7 |\n", rows):
        assert table_numbers.renewed(head + old + tail, {"entries": [entry]}, folder) == head + rows + tail


def test_selections_are_joined_row_by_row(folder: Path) -> None:
    form = "| {name} | {Z:.2f} | {name_2} {Z_2:.2f} |"
    entry = {
        "header": "| a | b | c |",
        "rows": [{"row": "t.csv percent=5 + t.csv name=uniform", "form": form}],
    }
    head = "| a | b | c |\n|---|---|---|\n"
    assert (
        table_numbers.renewed(head, {"entries": [entry]}, folder)
        == f"{head}| farthest dots | −0.56 | uniform 1234.56 |\n"
    )


@pytest.mark.parametrize(
    ("text", "phrase", "row", "message"),
    [
        ("3 a", "{Z} a", "t.csv percent=10 + t.csv percent=5", "its selections have 2 and 1 rows"),
        ("3 a", "{Z} a", "u.csv a=1", "evidence/tables/u.csv has no such cell"),
        ("3 a", "{Z} a", "t.csv a=1", "no such cell"),
        ("3 a", "{Z} a", "t.csv name=b", "no such row"),
        ("3 a", "{W} a", "t.csv name=uniform", "no such cell"),
        ("3 a", "{Z} a", "t.csv percent=x", "no such cell"),
        ("3 a", "{Z} a", "t.csv percent=10", "2 rows, not one"),
        ("three a", "{Z} a", "t.csv name=uniform", "stands 0 times on the page; it must stand once"),
        ("3 a\n\n4 a", "{Z} a", "t.csv name=uniform", "stands 2 times on the page, line 1, line 3"),
        ("13 a", "3 a", "t.csv name=uniform", "stands 0 times"),
    ],
)
def test_an_entry_that_does_not_fit_is_named_with_its_fault(
    folder: Path, text: str, phrase: str, row: str, message: str
) -> None:
    with pytest.raises(ValueError, match=rf"{re.escape(phrase)}: .*{re.escape(message)}"):
        table_numbers.renewed(text, {"entries": [{"phrase": phrase, "row": row}]}, folder)


def test_a_number_that_no_table_writes_is_named_unless_it_is_stated(folder: Path) -> None:
    page = {"entries": [{"phrase": "Z is {Z:.2f}", "row": "t.csv name=uniform"}], "stated": [0.5, "5 %"]}
    text = "Z is 1234.56, at 0.5 Å and 5 %, `0.7`, of 12.\n"
    assert table_numbers.renewed(text, page, folder) == text
    for typed in ("0.6", "−0.5", "5.0 %", "7 %", "1234.56"):
        with pytest.raises(ValueError, match=rf"line 3: no entry of docs/numbers\.yaml writes {typed}"):
            table_numbers.renewed(f"{text}\nd is {typed}.\n", page, folder)


def test_every_page_that_differs_is_written_and_named(tmp_path: Path, monkeypatch, capsys) -> None:
    names = {path.relative_to(ROOT).as_posix() for path in renew.PAGES}
    assert names >= {"README.md", "evidence/README.md", "docs/few_dots.md", "docs/reference/config.md"}
    known, entry = (
        [tmp_path / f"{name}.md" for name in "abc"],
        {"phrase": "is {distance:.3f}", "row": FARTHEST},
    )
    right = table_numbers.renewed("is 9.999", {"entries": [entry]})
    for path, text in zip(known, (right, "is 9.999", "none"), strict=True):
        path.write_text(text, encoding="utf-8")
    monkeypatch.setattr(renew, "ROOT", tmp_path)
    monkeypatch.setattr(renew, "PAGES", known)
    monkeypatch.setattr(
        table_numbers, "of_pages", lambda: {name: {"entries": [entry]} for name in ("a.md", "b.md")}
    )
    renew.main()
    assert capsys.readouterr().out == "renewed b.md\n"
    assert [path.read_text(encoding="utf-8") for path in known] == [
        right,
        right,
        "none",
    ] and "9.999" not in right
    known[0].write_text("nothing", encoding="utf-8")
    with pytest.raises(SystemExit, match=r"\{distance:\.3f\}: stands 0"):
        renew.main()


def test_the_help_of_recover_has_the_errors_of_the_table() -> None:
    entry = {"phrase": "{distance:.2f} {distance_99:.2f}", "row": FARTHEST}
    assert (
        re.findall(r"\d\.\d\d(?= |,)", EXAMPLES) == table_numbers.renewed("? ?", {"entries": [entry]}).split()
    )


def test_the_cost_of_a_long_trajectory_follows_from_that_of_a_frame() -> None:
    """Within the rounding of the page and of a measurement; a job has 8 cores for an hour."""
    page = (ROOT / "docs" / "cluster.md").read_text(encoding="utf-8")
    row = 'bench.csv "what=a frame of an ensemble, 953 atoms"'
    shown = table_numbers.renewed("?", {"entries": [{"phrase": "{value}", "row": row}]})
    rows = re.findall(r"ps \| ([\d,]+) \| ([\d.]+) \| (\d+) \|", page)
    assert len(rows) == 3
    for frames, hours, jobs in rows:
        assert float(hours) == pytest.approx(int(frames.replace(",", "")) * float(shown) / 3600, rel=0.15)
        assert int(jobs) == max(1, round(float(hours) / 8))


def test_the_cost_of_many_structures_follows_from_that_of_one() -> None:
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    number = r"([\d.,]+)"
    found = re.search(
        rf"{number} proteins of .* {number} CPU s and {number} kB each: {number} CPU minutes, {number} GB",
        page,
    )
    proteins, cpu_s, kilobytes, minutes, gigabytes = (float(one.replace(",", "")) for one in found.groups())
    assert minutes == pytest.approx(proteins * cpu_s / 60, rel=0.1)
    assert gigabytes == pytest.approx(proteins * kilobytes / 1e6, rel=0.1)
