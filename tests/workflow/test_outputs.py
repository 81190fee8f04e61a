"""Outputs of rules and how the report shows them."""

import re
from pathlib import Path

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


def test_what_every_output_is_can_be_read():
    """results/README.md names the files and folders of all rules; pictures also by their beginning."""
    said = (ROOT / "results" / "README.md").read_text(encoding="utf-8")
    named = re.findall(r"^ *output:\n.*?^ *log:|^[A-Z_]+ = [^\n]*$", WORKFLOW, re.S | re.M)
    paths = [path.replace("{side}", "1") for path in re.findall(r'f?"([^" ]+)"', "\n".join(named))]
    files = {Path(path) for path in paths if re.fullmatch(r"\w[^{}]*\.\w+", path.rpartition("/")[2])}
    pictures = {path.stem for path in files if path.suffix in (".png", ".svg")}
    pictures |= {path.rpartition("/")[2] for path in re.findall(r'figure\(f?"([^"]*)"', WORKFLOW)}
    tables = {path.name for path in files if path.stem not in pictures and not path.stem.startswith("paper_")}
    papers = {f"`{path.stem}`" for path in files if path.stem.startswith("paper_")}
    folders = {f"{path.split('/')[1]}/" for path in re.findall(r"{PROTEIN}/\w+/?", "\n".join(named))}
    folders -= {"figures/", "ensemble/"}  # full of pictures, of temporary tables
    assert len(tables) > 50 and len(papers) > 5 and folders >= {"structures/", "download/"}
    assert [name for name in sorted(tables | papers | folders) if name not in said] == []
    assert [name for name in sorted(pictures) if not re.search(rf"\b{name}(\.|`)", said)] == []
