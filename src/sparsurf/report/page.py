"""Pages of a run: the templates hold every sentence, this module turns numbers into their text and lays out the page."""

import base64
import re
from functools import cache
from pathlib import Path
from urllib.parse import quote

import jinja2
from markupsafe import Markup, escape

from sparsurf.report.numbers import number, share

TEMPLATES = Path(__file__).with_name("templates")
# Bytes of a figure inside a page; a browser shows no page above 1.5 MB inside Snakemake's report
LARGEST = 500_000


def embedded(path):
    """The picture at `path` as part of a page; None where it is missing, or too large."""
    path = Path(path)
    if not path.is_file() or path.stat().st_size > LARGEST:
        return None
    kind = {".svg": "svg+xml"}.get(path.suffix, path.suffix[1:])
    return f"data:image/{kind};base64," + base64.b64encode(path.read_bytes()).decode()


def code(sentence):
    """A sentence whose `names` are set as code; all else of it is escaped."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(sentence))))


def symbols(words):
    """Words with the indices of n_S and Z_tS set as such; all else of them is escaped."""
    return Markup(re.sub(r"\b(n|Z)_(t?[SR])\b", r"\1<sub>\2</sub>", str(escape(words))))


@cache
def _templates():
    found = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=lambda name: ".html" in name,
        undefined=jinja2.StrictUndefined,
        lstrip_blocks=True,
    )
    found.filters |= {"number": number, "share": share, "code": code, "symbols": symbols}
    return found


def render(template, **known):
    """A page, by the name of its template and what that asks for."""
    page = _templates().get_template(template).render({"in_report": False} | known)
    return re.sub(r"\n\s*\n+", "\n", page).lstrip() if ".html" in template else page


def write(path, template, **known):
    """Render a page into the file `path`."""
    Path(path).write_text(render(template, **known), encoding="utf-8")


def linked_in_report(page, folder, held):
    """The page as a part of Snakemake's report: links to what is `held` there, paths below `folder`, open it there."""
    held = {quote(path, safe="/") for path in held}

    def lead(found):
        if found.group(1) not in held:
            return found.group()
        place = quote(f"{folder}/", safe="/") + found.group(1)
        return f"href=\"javascript:app.showResultInfo('{place}')\""

    return re.sub(r'href="([^"]+)"', lead, page)
