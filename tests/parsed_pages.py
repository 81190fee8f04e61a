"""What a written HTML page holds, for tests."""

from html.parser import HTMLParser


class Page(HTMLParser):
    """What a page holds: texts by class, cells of its tables, targets of links and pictures."""

    def __init__(self, text):
        super().__init__()
        self.text, self.rows, self.links, self.sources, self._open = {}, [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        known = dict(attributes)
        self.links += [known["href"]] if "href" in known else []
        self.sources += [known["src"]] if "src" in known else []
        self.rows += [[]] if tag == "tr" else []
        if tag in ("td", "th"):
            self.rows[-1].append("")
        if tag not in ("meta", "img", "br", "!doctype"):
            self._open.append((tag, known.get("class", "")))

    def handle_endtag(self, tag):
        while self._open and self._open.pop()[0] != tag:
            pass

    def handle_data(self, data):
        if any(tag in ("td", "th") for tag, _ in self._open):
            self.rows[-1][-1] += data
        for _, name in self._open:
            self.text[name] = self.text.get(name, "") + data
