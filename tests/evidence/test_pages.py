"""The numbers and tables of README.md and docs/ are those of evidence/tables, as evidence/pages.yaml lists them."""

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


@pytest.mark.parametrize("name", pages.read_list())
def test_a_page_shows_the_numbers_of_its_tables(name):
    text, entries = (ROOT / name).read_text(encoding="utf-8"), pages.read_list()[name]
    assert pages.differing(text, entries.get("numbers", ())) == []
    assert pages.filled(text, entries.get("tables", ())) == text, "run python evidence/pages.py"


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_the_source_of_a_page_names_no_cells(path):
    assert not re.findall(r"<!--[^>]*\.csv", path.read_text(encoding="utf-8")), (
        "list them in evidence/pages.yaml"
    )


def number(text, *cells):
    return [{"text": text, "cells": list(cells)}]


@pytest.mark.parametrize("shown", ["0.56", "0.6", "0.564", "+0.56"])
def test_a_number_is_rounded_as_it_is_shown(folder, shown):
    one = number("Z is {}.", "t.csv name=farthest percent=5 Z")
    assert pages.differing(f"Here, Z is {shown}.", one, folder) == []


def test_several_numbers_of_one_text_stand_in_its_order_over_line_breaks(folder):
    two = number("Z is {} % and {} there", "t.csv name=uniform Z", "t.csv name=farthest percent=5 low")
    assert pages.differing("Z\nis 1,235 % and\n−0.02 there", two, folder) == []
    (sentence,) = pages.differing("Z is 1,235 % and 0.02 there", two, folder)
    assert sentence.startswith("0.02 is -0.020 in")


@pytest.mark.parametrize(
    ("shown", "column"), [("0.57", "Z"), ("0.02", "low"), ("-0.03", "low"), ("-0.56", "Z")]
)
def test_another_number_or_sign_is_named(folder, shown, column):
    one = number("It is {}.", f"t.csv name=farthest percent=5 {column}")
    (sentence,) = pages.differing(f"It is {shown}.", one, folder)
    assert sentence.startswith(f"{shown} is ")


@pytest.mark.parametrize("page", ["It was 0.56.", "It is 0.56. It is 0.56."])
def test_a_text_that_the_page_does_not_hold_once_is_named(folder, page):
    (sentence,) = pages.differing(page, number("It is {}.", "t.csv name=farthest percent=5 Z"), folder)
    assert "not once" in sentence


@pytest.mark.parametrize(
    "cell", ["t.csv percent=10 Z", "t.csv name=farthest percent=5 W", "u.csv a=1 Z", "t.csv a=1 Z"]
)
def test_a_cell_that_is_not_there_once_is_refused(folder, cell):
    with pytest.raises(InputError):
        pages.cell(cell, folder)


def test_tables_are_filled_and_equal_headers_go_in_order(folder):
    columns = {"dots / %": "{percent:g}", "Z": "{Z:.2f} ({low:+.2f})"}
    tables = [{"rows": f"t.csv {rows}", "columns": columns} for rows in ("percent=5|10", "name=uniform")]
    tables.insert(1, {"rows": "t.csv name=uniform", "columns": {"name": "{name}"}})
    old = "| dots / % | Z |\n| --- | --- |\n| old | |\n"
    made = pages.filled(f"A\n\n{old}\nB\n\n| name |\n| --- |\n| old |\n\n{old}", tables, folder)
    head = "| dots / % | Z |\n| --- | --- |\n"
    assert made == (
        f"A\n\n{head}| 5 | 0.56 (−0.02) |\n| 10 |  |\n| 10 | 1234.56 (+0.50) |\n"
        f"\nB\n\n| name |\n| --- |\n| uniform |\n\n{head}| 10 | 1234.56 (+0.50) |\n"
    )
    assert pages.filled(made, tables, folder) == made
    with pytest.raises(InputError, match="no table"):
        pages.filled("| name |\n", tables, folder)


def test_the_help_of_recover_has_the_errors_of_the_table():
    row = pages.rows_of(
        "recover_where_means.csv", ["sampler=farthest dots", "where=everywhere", "percent=10"]
    )
    told = [f"{row[key].iloc[0]:.2f}" for key in ("mean", "high_99")]
    assert re.findall(r"\d\.\d\d(?= |,)", EXAMPLES) == told
