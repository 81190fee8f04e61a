"""Render the pages of a run: templates hold the sentences, filters format the numbers."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup, escape

from sparsurf import registry
from sparsurf.patches.index import R_PATCH, R_ZERNIKE
from sparsurf.views import page as page_of_molecule
from sparsurf.views.numbers import interval, number, share
from sparsurf_study.pairs.partners import INTERFACE
from sparsurf_study.report.numbers import combination, interval_of, left_in_island, p_value

TEMPLATES = Path(__file__).with_name("templates")
PAGE_OF_MOLECULE = Path(
    page_of_molecule.__file__
).parent  # the page on one surface, which draws residues in the same way
MAX_FIGURE_BYTES = 500_000  # A larger figure is not put into a page.
# All figures inside a page have at most this size together, so that it can be sent.
MAX_PAGE_BYTES = 10_000_000
MAX_FIGURE_PIXELS = 1600  # across a figure inside a page
FILTERS = (number, share, interval, interval_of, combination, left_in_island, p_value)  # filters of templates
DEFAULT_LENGTHS = {"r_patch": R_PATCH, "r_zernike": R_ZERNIKE, "interface": INTERFACE}  # Å
WEBP: dict[str, Any] = {"quality": 85, "method": 2}  # 1 MB becomes 0.15 MB that looks the same, quickly


def embedded(path: Path | str) -> str | None:
    """Encode the PNG at `path` as a data URL; None if it is missing or too large."""
    path = Path(path)
    if not path.is_file() or path.stat().st_size > MAX_FIGURE_BYTES:
        return None
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()


def embedded_figures(folder: Path, paths: Iterable[str], page_folder: Path | None = None) -> dict[str, str]:
    """Encode pictures as data URLs, small enough to be sent: the first that fit into MAX_PAGE_BYTES, by path from `folder`.

    Those that are written together with the page lie in the folder `page_folder`.
    """
    from PIL import Image  # comes with matplotlib

    urls: dict[str, str] = {}
    size = 0
    for path in dict.fromkeys(paths):
        place = next((place for place in (page_folder or folder, folder) if (place / path).is_file()), None)
        if place is None:
            continue
        with Image.open(place / path) as stored:
            picture = stored.convert("RGB")
        picture.thumbnail((MAX_FIGURE_PIXELS, MAX_FIGURE_PIXELS))
        encoded = io.BytesIO()
        picture.save(encoded, "WEBP", **WEBP)
        url = "data:image/webp;base64," + base64.b64encode(encoded.getvalue()).decode()
        size += len(url)
        if size > MAX_PAGE_BYTES:
            break
        urls[path] = url
    return urls


def code(sentence: str) -> Markup:
    """Escape a sentence, with its `names` as HTML code and the indices of n_S and Z_tS as subscripts."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(symbols(sentence))))


def symbols(text: str) -> Markup:
    """Escape a text, with the indices of n_S and Z_tS as subscripts."""
    return Markup(re.sub(r"\b(n|Z)_(t?[SR])\b", r"\1<sub>\2</sub>", str(escape(text))))


@cache
def _templates() -> jinja2.Environment:
    """Return the environment of the templates."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader([TEMPLATES, PAGE_OF_MOLECULE]),
        autoescape=lambda name: ".html" in (name or ""),
        undefined=jinja2.StrictUndefined,
        lstrip_blocks=True,
    )
    environment.filters |= {"code": code, "symbols": symbols, "words": _explained} | {
        form.__name__: form for form in FILTERS
    }
    readings = registry.TABLE["reading"].items()
    environment.globals |= {
        "labels_of_readings": {name: choice.label for name, choice in readings},
        "conditions_of_readings": {name: choice.condition for name, choice in readings},
    }
    return environment


class Glossary:
    """Words of a page that are explained: each has its meaning on hover where it first stands, and in a list."""

    def __init__(self, lengths: Mapping[str, float]) -> None:
        module: Any = _templates().get_template("words.html.j2").make_module(dict(lengths))
        self.meanings: dict[str, str] = module.meanings
        self.used: set[str] = set()
        alternatives = "|".join(map(re.escape, sorted(self.meanings, key=len, reverse=True)))
        self.pattern = re.compile(rf"(?<![\w/.])((?:{alternatives})(?:e?s)?\b)(?![/.]\w)")

    def mark(self, sentence: str) -> Markup:
        """Escape a sentence; mark the words that no sentence before it has."""
        parts = []
        for k, part in enumerate(self.pattern.split(sentence)):
            word = self.word(part)
            if k % 2 == 0 or word in self.used:
                parts.append(symbols(part))
                continue
            self.used.add(word)
            parts.append(Markup('<abbr title="{}">{}</abbr>').format(self.meanings[word], symbols(part)))
        return Markup("").join(parts)

    def explained(self) -> list[tuple[str, str]]:
        """Return the words that were marked, and those that their meanings hold, with their meanings."""
        listed, added = set[str](), set(self.used)
        while added:
            listed |= added
            found = {self.word(part) for word in added for part in self.pattern.findall(self.meanings[word])}
            added = found - listed
        return [(word, meaning) for word, meaning in self.meanings.items() if word in listed]

    def word(self, text: str) -> str:
        """Return the word that a text is, in the singular; empty if it is none."""
        return next((word for word in (text, text[:-1], text[:-2]) if word in self.meanings), "")


@jinja2.pass_context
def _explained(context: jinja2.runtime.Context, sentence: str) -> Markup:
    """Mark the words of a sentence in the glossary of the page."""
    return context["glossary"].mark(sentence)


def render(template: str, lengths: Mapping[str, float] = DEFAULT_LENGTHS, **values: Any) -> str:
    """Render a template with the values that it uses; `lengths` are those of the config that the glossary names, Å."""
    glossary = Glossary(lengths)
    values |= {"glossary": glossary, "explained_words": glossary.explained}
    page = _templates().get_template(template).render(values)
    return re.sub(r"\n\s*\n+", "\n", page).lstrip() if ".html" in template else page


def write_rendered(
    path: Path | str, template: str, lengths: Mapping[str, float] = DEFAULT_LENGTHS, **values: Any
) -> None:
    """Render a page into the file `path`, see `render`."""
    Path(path).write_text(render(template, lengths, **values), encoding="utf-8")
