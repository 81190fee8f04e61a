"""Numbers and tables of the book, put in from evidence/tables when it is built.

A placeholder names a table, its rows by their cells, and a format over the columns:

    d is {{ proteins_d.csv reading=kept range=5 | {own:+.2f} ({own_low:+.2f} to {own_high:+.2f}) }}.

In a sentence it stands for one row. Alone on its line it stands for as many lines as there are rows, in the order of the table.
A condition with spaces is quoted, and | separates alternatives: "sampler=farthest dots|uniform dots" percent=10.
"""

import re
import shlex
import string
from pathlib import Path

import pandas as pd

TABLES = Path(__file__).parent.parent / "evidence" / "tables"
PLACEHOLDER = re.compile(r"\{\{ (.*?) \}\}")
LINE = re.compile(rf"(?m)^{PLACEHOLDER.pattern}$")


def filled(text, folder=TABLES):
    """A page with its placeholders replaced; ValueError names the placeholder that has no cell."""
    text = LINE.sub(lambda found: "\n".join(_texts(found, folder)), text)
    return PLACEHOLDER.sub(lambda found: _only(_texts(found, folder), found), text)


def _texts(found, folder):
    """One text for each row that the placeholder names."""
    rows, _, form = found[1].partition(" | ")
    file, *conditions = shlex.split(rows)
    try:
        table = pd.read_csv(folder / file)
        for column, _, values in (condition.partition("=") for condition in conditions):
            kind = float if pd.api.types.is_numeric_dtype(table[column]) else str
            table = table[table[column].isin([kind(value) for value in values.split("|")])]
        texts = [_shown(form, row) for row in table.to_dict("records")]
    except (OSError, KeyError, ValueError) as error:
        raise ValueError(f"{found[0]}: evidence/tables/{file} has no such cell ({error!r}).") from None
    if not (texts and form):
        raise ValueError(f"{found[0]}: evidence/tables/{file} has no such row, or no format follows it.")
    return texts


def _only(texts, found):
    if len(texts) > 1:
        raise ValueError(f"{found[0]}: {len(texts)} rows, not one.")
    return texts[0]


def _shown(form, row):
    """The format with the cells of a row, with true minus signs; empty cells of a table for values that are missing."""
    parts = [
        re.sub(r"\S.*\S|\S", "", part)
        if any(pd.isna(row[name]) for name in _names(part))
        else part.format_map(row)
        for part in form.split("|")
    ]
    return re.sub(r"(?<![\w.])-(?=[\d.])", "−", "|".join(parts))


def _names(form):
    return [name for _, name, _, _ in string.Formatter().parse(form) if name]


def fill(app, name, source):
    """The same, as Sphinx calls it."""
    try:
        source[0] = filled(source[0])
    except ValueError as error:
        from sphinx.errors import ExtensionError

        raise ExtensionError(f"{name}: {error}") from None
