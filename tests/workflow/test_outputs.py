"""Outputs of rules and how the report shows them."""

import re

from conftest import ROOT, WORKFLOW
from sparsurf.workflow.outputs import figure, inside, shown


def test_files_of_a_folder_have_names():
    assert inside("a/{b}", x="x.csv", y="z.md") == {"x": "a/{b}/x.csv", "y": "a/{b}/z.md"}
    assert inside("a") == {}


def test_the_report_shows_a_file_among_those_of_its_protein():
    whole = shown("r/summary.csv", "All", "summary").flags["report"]
    assert (whole.category, whole.subcategory, whole.labels) == ("All surfaces", None, {"result": "All"})
    of_protein = shown("r/{protein}/frames.png", "F", "frames").flags["report"]
    assert (of_protein.category, of_protein.subcategory) == ("{protein}", None)
    of_conformation = shown("r/{protein}/{conformation}/x.png", "F", "frames").flags["report"]
    assert (of_conformation.category, of_conformation.subcategory) == ("{protein}", "{conformation}")
    assert shown("r/pairs/{pair}/x.png", "F", "book", "Pairs").flags["report"].category == "Pairs"


def test_a_caption_may_be_missing_only_where_there_is_none():
    assert shown("x.png", "F", "frames").flags["report"].caption == "scripts/report/frames.rst"
    assert shown("x.png", "F", "no such").flags["report"].caption is None
    named = re.findall(r'(?:shown|figure)\((?:f?".*?"), "[^"]*", "(\w+)"', WORKFLOW)
    assert len(named) > 15
    assert all((ROOT / "scripts" / "report" / f"{name}.rst").is_file() for name in named)


def test_a_figure_is_two_files():
    found = figure("r/a", "A", "frames")
    assert found == {"png": "r/a.png", "svg": "r/a.svg"}
    assert found["png"].flags["report"].labels == {"result": "A"}
