"""The numbers and tables of README.md and docs/ are those of evidence/tables (how they name a cell: evidence/pages.py)."""

import re

import pytest

import pages
from conftest import ROOT
from sparsurf import InputError
from sparsurf.cli.recover import EXAMPLES

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
TABLE = "name,percent,Z,low\nfarthest,5,0.564,-0.02\nfarthest,10,0.514,\nuniform,10,1234.56,0.5\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "t.csv").write_text(TABLE)
    return tmp_path


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_a_page_shows_the_numbers_of_its_tables(path):
    text = path.read_text(encoding="utf-8")
    assert pages.differing(text) == []
    assert pages.filled(text) == text, "run python evidence/pages.py README.md docs/*.md"


@pytest.mark.parametrize(
    "shown",
    ["0.56", "0.6", "0.564", "+0.56", "0.56 Å", "1,235 %<!-- t.csv name=uniform percent=10 Z --> and 0.56"],
)
def test_a_number_is_rounded_as_it_is_shown(folder, shown):
    assert pages.differing(f"Z is {shown}<!-- t.csv name=farthest percent=5 Z -->.", folder) == []


@pytest.mark.parametrize(
    ("shown", "column"), [("0.57", "Z"), ("0.02", "low"), ("-0.03", "low"), ("-0.56", "Z")]
)
def test_another_number_or_sign_is_named(folder, shown, column):
    (sentence,) = pages.differing(f"It is {shown}<!-- t.csv name=farthest percent=5 {column} -->.", folder)
    assert sentence.startswith(f"{shown} is ")


@pytest.mark.parametrize(
    "cell", ["t.csv percent=10 Z", "t.csv name=farthest percent=5 W", "u.csv a=1 Z", "t.csv a=1 Z"]
)
def test_a_cell_that_is_not_there_once_is_refused(folder, cell):
    with pytest.raises(InputError):
        pages.cell(cell, folder)


def test_a_table_is_filled_up_to_the_blank_line(folder):
    mark = (
        "<!-- table t.csv name=farthest percent=5|10\ndots / %: {percent:g}\nZ: {Z:.2f} ({low:+.2f})\n-->\n"
    )
    text = f"Before.\n\n{mark}| old |\n| --- |\n\nBehind.\n"
    made = pages.filled(text, folder)
    assert (
        made
        == f"Before.\n\n{mark}| dots / % | Z |\n| --- | --- |\n| 5 | 0.56 (−0.02) |\n| 10 |  |\n\nBehind.\n"
    )
    assert pages.filled(made, folder) == made


def test_the_help_of_recover_has_the_errors_of_the_table():
    rows = [pages.rows_of("recover_where_means.csv", ["sampler=farthest dots", "where=everywhere", f"percent={p}"])
            for p in (10, 2.5)]  # fmt: skip
    told = [f"{row[key].iloc[0]:.2f}" for row in rows for key in ("mean", "high_99", "largest")]
    assert re.findall(r"\d\.\d\d(?= |,)", EXAMPLES) == told
