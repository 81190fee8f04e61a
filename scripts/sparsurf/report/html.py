"""Markdown pages for a browser."""

import re
from html import escape
from pathlib import Path
from urllib.parse import quote

from markdown_it import MarkdownIt

STYLE = (
    "body{font:16px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse;display:block;overflow-x:auto}"
    "td,th{padding:2px 8px;text-align:right;border-bottom:1px solid #ddd}"
)
# Snakemake's report centres what it shows, which puts the top of a long page and the left of a wide one out of reach, and
# sets the graph of rules beside the text; here it follows.
IN_REPORT = (
    "<style>.h-screen.items-center{align-items:flex-start!important;justify-content:flex-start!important;min-width:0}"
    ".h-screen>.items-start{flex-direction:column;min-width:0}.h-screen>.items-start>*{max-width:100%}"
    ".prose{max-width:48rem!important}.prose table{display:block;overflow-x:auto}</style>"
)


def write_first_page(page, folder, outputs, held):
    """Write the page of a run, whose results lie in `folder`: as Markdown, `md`, as HTML, and as the first page of the
    report, `part`; those of them that `outputs` has a path for. `held`: see `in_report`."""
    texts = {"md": page, "html": as_html(page, folder.name), "part": in_report(page, folder, held)}
    for key in texts.keys() & outputs.keys():
        Path(outputs[key]).write_text(texts[key], encoding="utf-8")


def as_html(page, title="Verdict"):
    """The page by itself."""
    return (
        f"<!doctype html><html lang='en'><meta charset='utf-8'><title>{escape(title)}</title><style>{STYLE}</style>"
        f"<meta name='viewport' content='width=device-width, initial-scale=1'>{_body(page)}</html>"
    )


def in_report(page, folder, held):
    """The page as a part of Snakemake's report: its links to what lies under `folder` and is `held` in the report, paths
    from there, show that; the others lead to the files beside the report."""
    held = {quote(path, safe="/") for path in held}

    def lead(found):
        if found.group(1) not in held:
            return found.group()
        place = quote(f"{folder}/", safe="/") + found.group(1)
        return f"href=\"javascript:app.showResultInfo('{place}')\""

    return IN_REPORT + re.sub(r'href="([^"]+)"', lead, _body(page))


def _body(page):
    return MarkdownIt("commonmark", {"html": False}).enable("table").render(page)
