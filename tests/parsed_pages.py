"""What a written HTML page holds, for tests."""

import re
from dataclasses import dataclass, field
from html.parser import HTMLParser

BLOCKS = re.compile("p|li|td|th|dd|dt|figcaption|h1|h2|h3|summary|title|div|tr|br").fullmatch
UNSEEN = {"script", "style"}
EMPTY = {"area", "base", "br", "col", "hr", "img", "input", "link", "meta", "source", "wbr"}  # have no end


@dataclass
class Element:
    """An element of a page: its tag, attributes, seen text, and the elements around it, from the outside in."""

    tag: str
    attributes: dict[str, str]
    around: list["Element"]
    texts: list[str] = field(default_factory=list)

    @property
    def text(self):
        """Its seen text on one line."""
        return " ".join("".join(self.texts).split())

    def is_of(self, word):
        """Return whether a word is its tag or one of its classes."""
        return word in (self.tag, *self.attributes.get("class", "").split())


class Page(HTMLParser):
    """What a page holds: its texts, one for each block, cells of its tables, targets of links and pictures, and anchors.

    `words` are all that a reader sees, tables included and the glossary left out, on one line.
    """

    def __init__(self, text):
        super().__init__()
        self.blocks, self.tables, self.links, self.sources, self.anchors = [""], [], [], [], []
        self._cell, self._unseen, self._open, self._elements, self._words = False, 0, [], [], []
        self.feed(text)
        self.blocks = [" ".join(block.split()) for block in self.blocks if block.strip()]
        self.text, self.words = "\n".join(self.blocks), " ".join("".join(self._words).split())

    def find(self, word, inside=None):
        """Return the elements of a tag or class in the order of the page, all or those inside of one of another."""
        return [
            element
            for element in self._elements
            if element.is_of(word) and (inside is None or any(each.is_of(inside) for each in element.around))
        ]

    @property
    def alternatives(self):
        """What its pictures and drawings say to who does not see them."""
        return [
            element.attributes.get("alt") or element.attributes.get("aria-label", "")
            for element in self._elements
            if element.tag in ("img", "svg")
        ]

    @property
    def rows(self):
        """Rows of all tables."""
        return [row for table in self.tables for row in table]

    def handle_starttag(self, tag, attributes):
        known = dict(attributes)
        self._elements.append(Element(tag, {key: value or "" for key, value in attributes}, [*self._open]))
        if tag not in EMPTY:
            self._open.append(self._elements[-1])
        for name, values in (("href", self.links), ("src", self.sources), ("id", self.anchors)):
            values += [known[name]] if name in known else []
        self._unseen += tag in UNSEEN
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("td", "th"):
            self._cell = True
            self.tables[-1][-1].append("")
        elif BLOCKS(tag) and not self._cell:
            self.blocks.append("")

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        self._close(tag)

    def _close(self, tag):
        """Close the innermost open element of a tag, and those in it, whose end may be left out."""
        for k in range(len(self._open) - 1, -1, -1):
            if self._open[k].tag == tag:
                del self._open[k:]
                break

    def handle_endtag(self, tag):
        self._unseen -= tag in UNSEEN
        self._close(tag)
        if tag in ("td", "th"):
            self._cell = False
            self.tables[-1][-1][-1] = " ".join(self.tables[-1][-1][-1].split())
        elif BLOCKS(tag) and not self._cell:
            self.blocks.append("")

    def handle_data(self, data):
        if self._unseen:
            return
        for element in self._open:
            element.texts.append(data)
        if not any(element.tag == "dl" for element in self._open):
            self._words.append(data)
        if self._cell:
            self.tables[-1][-1][-1] += data
        else:
            self.blocks[-1] += data


def origin_of(path):
    """The block of origin of a page, by the name of each row."""
    page = Page(path.read_text(encoding="utf-8"))
    names, values = ([row.text for row in page.find(kind, "origin")] for kind in ("dt", "dd"))
    return dict(zip(names, values, strict=True))
