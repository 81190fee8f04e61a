"""What a written HTML page holds, for tests."""

import re
from html.parser import HTMLParser

BLOCKS = re.compile("p|li|td|th|dd|dt|figcaption|h1|h2|h3|summary|title|div|tr|br").fullmatch
UNSEEN = {"script", "style"}


class Page(HTMLParser):
    """What a page holds: its texts, one for each block, cells of its tables, targets of links and pictures, and anchors."""

    def __init__(self, text):
        super().__init__()
        self.blocks, self.tables, self.links, self.sources, self.anchors = [""], [], [], [], []
        self._cell, self._unseen = False, 0
        self.feed(text)
        self.blocks = [" ".join(block.split()) for block in self.blocks if block.strip()]
        self.text = "\n".join(self.blocks)

    @property
    def rows(self):
        """Rows of all tables."""
        return [row for table in self.tables for row in table]

    def handle_starttag(self, tag, attributes):
        known = dict(attributes)
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

    def handle_endtag(self, tag):
        self._unseen -= tag in UNSEEN
        if tag in ("td", "th"):
            self._cell = False
            self.tables[-1][-1][-1] = " ".join(self.tables[-1][-1][-1].split())
        elif BLOCKS(tag) and not self._cell:
            self.blocks.append("")

    def handle_data(self, data):
        if self._unseen:
            return
        if self._cell:
            self.tables[-1][-1][-1] += data
        else:
            self.blocks[-1] += data
