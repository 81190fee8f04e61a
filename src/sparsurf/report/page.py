"""Render the pages of a run: templates hold the sentences, filters format the numbers."""

from __future__ import annotations

import base64
import re
from functools import cache
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup, escape

from sparsurf.report.numbers import number, share

TEMPLATES = Path(__file__).with_name("templates")
# Of a figure inside a page; browsers show no page above 1.5 MB inside Snakemake's report
MAX_FIGURE_BYTES = 500_000


def embedded(path: Path | str) -> str | None:
    """Encode the picture at `path` as a data URL; None if it is missing or too large."""
    path = Path(path)
    if not path.is_file() or path.stat().st_size > MAX_FIGURE_BYTES:
        return None
    kind = {".svg": "svg+xml"}.get(path.suffix, path.suffix[1:])
    return f"data:image/{kind};base64," + base64.b64encode(path.read_bytes()).decode()


def code(sentence: str) -> Markup:
    """Escape a sentence, with its `names` as HTML code."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(sentence))))


def symbols(words: str) -> Markup:
    """Escape words, with the indices of n_S and Z_tS as subscripts."""
    return Markup(re.sub(r"\b(n|Z)_(t?[SR])\b", r"\1<sub>\2</sub>", str(escape(words))))


@cache
def _templates() -> jinja2.Environment:
    """Return the environment of the templates."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=lambda name: ".html" in (name or ""),
        undefined=jinja2.StrictUndefined,
        lstrip_blocks=True,
    )
    environment.filters |= {"number": number, "share": share, "code": code, "symbols": symbols}
    return environment


def render(template: str, **known: Any) -> str:
    """Render a template with the values that it uses."""
    page = _templates().get_template(template).render(known)
    return re.sub(r"\n\s*\n+", "\n", page).lstrip() if ".html" in template else page


def write(path: Path | str, template: str, **known: Any) -> None:
    """Render a page into the file `path`."""
    Path(path).write_text(render(template, **known), encoding="utf-8")
