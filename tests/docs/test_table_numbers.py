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
    text = page.read_text(encoding="utf-8")
    old, new = (content.splitlines() for content in (text, renew.renewed(text)))
    stale = [pair for pair in zip(old, new, strict=False) if pair[0] != pair[1]]
    assert old == new, f"run .venv/bin/python docs/renew.py: {page.name} has {stale[:3]}"


@PAGES
def test_a_page_shows_nothing_raw(page: Path) -> None:
    shown = re.sub(r"(?s)<!--.*?-->|<code[^>]*>.*?</code>|\$+.*?\$+", "", html(page))
    assert not re.search(r"\{\{|\}\}|:::|\{(?:figure|toctree|eval-rst|include)\}|--&gt;|&lt;!--", shown)
    assert 'class="language-{' not in html(page)
    assert not [
        found[0] for found in table_numbers.SOURCE.finditer(page.read_text("utf-8")) if "--" in found["lines"]
    ]


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
    ("old", "form", "new"),
    [
        ("Z is 999", "{Z:,.0f}", "Z is 1,235"),
        ("Z is 1,235", "{Z:,.0f}", "Z is 1,235"),
        ("Z is ?", "{Z:.2f}", "Z is 1234.56"),
        ("Of (2, 11 (−3\nto 7)", "{percent} ({Z:.0f} to {Z:.0f})", "Of (2, 10 (1235 to 1235)"),
        ("Z is 1235\nto 1235", "{Z:.0f} to {Z:.0f}", "Z is 1235\nto 1235"),
        ("see (1; 9)", "{best}", "see (2; 0)"),
        ("[11", "{percent}", "[10"),
        ("+0.1%", "{Z:+.1%}", "+123456.0%"),
        ("here (random", "{name}", "here (uniform"),
    ],
)
def test_a_number_is_that_of_the_row_in_the_comment_after_it(
    folder: Path, old: str, form: str, new: str
) -> None:
    comment = f"<!--t.csv name=uniform: {form}-->"
    assert table_numbers.renewed(f"{old}{comment}.\n", folder) == f"{new}{comment}.\n"


def test_a_comment_after_a_table_writes_its_rows(folder: Path) -> None:
    head, tail = "| a | b |\n| - | --: |\n| 1 | 2 |\n\nText | 3\n\n| % | Z |\n|---|:-:|\n", "\nZ is 4.\n"
    comment = '<!--t.csv "name=farthest dots": | {percent:g} | {Z:.2f} |\nt.csv name=uniform: | all: | {Z:.0f} |-->\n'
    for old in ("", "| 5 | 7 |\n", "| 5 | −0.56 |\n| 10 |  |\n| all: | 1235 |\n"):
        new = table_numbers.renewed(head + old + comment + tail, folder)
        assert new == head + "| 5 | −0.56 |\n| 10 |  |\n| all: | 1235 |\n" + comment + tail


def test_selections_are_joined_row_by_row(folder: Path) -> None:
    comment = "<!--t.csv percent=5 + t.csv name=uniform: | {name} | {Z:.2f} | {name_2} {Z_2:.2f} |-->\n"
    head = "| a | b | c |\n|---|---|---|\n"
    assert (
        table_numbers.renewed(head + comment, folder)
        == f"{head}| farthest dots | −0.56 | uniform 1234.56 |\n{comment}"
    )


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("3<!--t.csv percent=10 + t.csv percent=5: {Z}-->", "its selections have 2 and 1 rows"),
        ("3<!--u.csv a=1: {Z}-->", "evidence/tables/u.csv has no such cell"),
        ("3<!--t.csv a=1: {Z}-->", "no such cell"),
        ("3<!--t.csv name=b: {Z}-->", "no such row"),
        ("3<!--t.csv name=uniform: {W}-->", "no such cell"),
        ("3<!--t.csv percent=x: {Z}-->", "no such cell"),
        ("3<!--t.csv percent=10: {Z}-->", "2 rows, not one"),
        ("three<!--t.csv name=uniform: {Z}-->", "no number of this format stands before it; type ? there"),
        ("a\n<!--t.csv name=uniform: {Z}-->", "does not follow a table"),
        ("3<!--t.csv name=uniform: -->", "no format follows the row"),
    ],
)
def test_a_wrong_comment_is_named_with_its_fault(folder: Path, wrong: str, message: str) -> None:
    with pytest.raises(
        ValueError, match=rf"(?s){re.escape(wrong[wrong.index('<') :])}.*{re.escape(message)}"
    ):
        table_numbers.renewed(wrong, folder)


def test_every_page_that_differs_is_written_and_named(tmp_path: Path, monkeypatch, capsys) -> None:
    names = {path.relative_to(ROOT).as_posix() for path in renew.PAGES}
    assert names >= {"README.md", "evidence/README.md", "docs/few_dots.md", "docs/reference/config.md"}
    known, comment = [tmp_path / f"{name}.md" for name in "abc"], f"<!--{FARTHEST}: {{distance:.3f}}-->"
    right = table_numbers.renewed(f"9.999{comment}")
    for path, text in zip(known, (right, f"9.999{comment}", "none"), strict=True):
        path.write_text(text, encoding="utf-8")
    monkeypatch.setattr(renew, "ROOT", tmp_path)
    monkeypatch.setattr(renew, "PAGES", known)
    renew.main()
    assert capsys.readouterr().out == "renewed b.md\n"
    assert [path.read_text(encoding="utf-8") for path in known] == [
        right,
        right,
        "none",
    ] and "9.999" not in right
    known[2].write_text("3<!--u.csv a=1: {Z}-->", encoding="utf-8")
    with pytest.raises(SystemExit, match=r"c\.md: "):
        renew.main()


def test_the_help_of_recover_has_the_errors_of_the_table() -> None:
    shown = table_numbers.renewed(f"? ?<!--{FARTHEST}: {{distance:.2f}} {{distance_99:.2f}}-->")
    assert re.findall(r"\d\.\d\d(?= |,)", EXAMPLES) == re.findall(r"\d\.\d\d(?= |<)", shown)


def test_the_cost_of_a_long_trajectory_follows_from_that_of_a_frame() -> None:
    """Within the rounding of the page and of a measurement; a job has 8 cores for an hour."""
    page = (ROOT / "docs" / "cluster.md").read_text(encoding="utf-8")
    shown = table_numbers.renewed('?<!--bench.csv "what=a frame of an ensemble, 953 atoms": {value}-->')
    rows = re.findall(r"ps \| ([\d,]+) \| ([\d.]+) \| (\d+) \|", page)
    assert len(rows) == 3
    for frames, hours, jobs in rows:
        assert float(hours) == pytest.approx(
            int(frames.replace(",", "")) * float(shown.split("<")[0]) / 3600, rel=0.15
        )
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
