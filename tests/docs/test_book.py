"""The book: its tables are those of the code. Once `make docs` has built it, its links lead somewhere and a browser shows it."""

import json
import re
import urllib.parse

import pytest
import yaml

import reference
import sparsurf
from conftest import ROOT
from parsed_pages import Page

pytestmark = pytest.mark.slow

BOOK = ROOT / "docs" / "_build" / "html"
built = pytest.mark.skipif(not BOOK.is_dir(), reason="make docs has not been run")
PAGES = ("few_dots", "method", "_gallery/index")


def test_an_example_is_short():
    lengths = {path.name: len(path.read_text().splitlines()) for path in ROOT.glob("docs/gallery/*.py")}
    assert lengths and max(lengths.values()) <= 40, lengths


def test_every_function_for_users_is_in_the_reference():
    text = (ROOT / "docs" / "reference" / "functions.rst").read_text(encoding="utf-8")
    listed = re.findall(r"auto(?:function|class|exception):: (?:[\w.]+\.)?(\w+)", text)
    assert sorted(listed) == sorted(
        [*sparsurf.FUNCTIONS, *sparsurf.CLASSES, "FrameTables", "InputError", "View"]
    )


def test_the_commands_show_their_options():
    text = "".join(reference.commands())
    assert {"--percent", "--mesh", "--d-link"} <= {*re.findall(r"--[a-z-]+", text)}


def test_the_release_is_one():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    metadata = json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8"))
    releases = re.findall(r"^## (\S+) \(([^)]*)\)\n(.*?)(?=^## |\Z)", changes, re.M | re.S)
    version, date, _ = releases[releases[0][1] == "unreleased"]
    assert citation["version"] == sparsurf.__version__ == version == metadata["version"]
    assert date == str(citation["date-released"])
    assert f"with sparsurf {version}," in (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    assert all(len(re.findall(r"^- ", text, re.M)) <= 20 for _, _, text in releases[:2])


@built
def test_every_link_of_the_book_leads_somewhere():
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in BOOK.rglob("*.html")}
    broken = []
    for path, page in pages.items():
        for link in {*page.links, *page.sources}:
            address = urllib.parse.urlsplit(link)
            if address.scheme or address.netloc:
                continue
            target = (path.parent / urllib.parse.unquote(address.path)).resolve() if address.path else path
            anchor = urllib.parse.unquote(address.fragment)
            if not target.exists() or (target in pages and anchor not in {"", *pages[target].anchors}):
                broken.append(f"{path.relative_to(BOOK)}: {link}")
    assert len(pages) > 20 and not broken


@built
def test_the_book_loads_nothing_from_the_network():
    for path in BOOK.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"<(script|link|img)[^>]*(src|href)=\"(https?:)?//", text), path


@built
def test_a_browser_shows_the_book(browser):
    for page in PAGES:
        browser.open(BOOK / f"{page}.html")
        drawn = "return [...document.images].every((image) => image.complete && image.naturalWidth > 0)"
        assert browser.run(drawn) and browser.run("return document.images.length") > 0
        assert browser.run("return document.body.scrollWidth <= innerWidth")
    browser.open(BOOK / "method.html")
    assert browser.run("return document.querySelector('math').getBoundingClientRect().height") > 10
