"""Numbers in Markdown, each followed by a comment that names the cells of evidence/tables from which it is written.

In a sentence or in a cell, the comment follows the number. It names a table, a row by its cells, and a format over the columns:

    d is +2.28 (+2.06 to +2.51)<!--proteins_d.csv reading=kept range=5: {own:+.2f} ({own_low:+.2f} to {own_high:+.2f})-->.

After a table, on lines of its own, a comment describes all rows below the header. Each of its lines stands for all rows that its
conditions leave, in their order:

    | dots / % | Z |
    | --- | --- |
    | 5 | 0.56 |
    | 10 | 0.45 |
    <!--t.csv "sampler=farthest dots": | {percent:g} | {Z:.2f} |-->

A condition with spaces is quoted, and | separates alternatives, as in percent=5|10, except in a cell, which a | would end.
Rows of several selections are joined by +, in their order; columns of the second selection end in _2, those of the third in _3:

    <!--t.csv sampler=farthest + t.csv sampler=uniform: | {percent:g} | {Z:.2f} | {Z_2:.2f} |-->

For a new number, type ? and its comment, and run docs/renew.py. Neither GitHub nor the book shows a comment.
"""

import re
import shlex
import string
from pathlib import Path

import pandas as pd

TABLES = Path(__file__).parent.parent / "evidence" / "tables"
ROWS = r'\w+\.csv(?:\.gz)?(?: +(?:"[^"\n]*"|[^\s"]+?))*?'
SOURCE = re.compile(rf"<!--(?={ROWS}:\s)(?P<lines>.*?)-->", re.S)
LINE = re.compile(rf"(?P<rows>{ROWS}):\s+(?P<form>\S.*)", re.S)
HEADER = re.compile(r"^\|(?: *:?-+:? *\|)+ *\n", re.M)
NUMBER = r"[+−-]?(?:\d{1,3}(?:,\d{3})+|\d+)(?:\.\d+)?(?:e[+−-]?\d+)?%?"
TEXT = r"(?:\([^()\n]*\)|[^\s|(]+)"


def renewed(text: str, folder: Path = TABLES) -> str:
    """Return a page with each number as its table gives it; ValueError names the comment that has no cell or no number."""
    parts, end = [], 0
    for source in SOURCE.finditer(text):
        parts += [_renewed(text[end : source.start()], source, folder), source[0]]
        end = source.end()
    return "".join(parts) + text[end:]


def _renewed(before: str, source: re.Match[str], folder: Path) -> str:
    """The text before a comment, with its number or the rows of its table renewed."""
    lines = [_parsed(line, source[0]) for line in source["lines"].strip().splitlines()]
    if before.endswith("\n"):
        if not (header := HEADER.search(before, before.rstrip("\n").rfind("\n\n") + 1)):
            raise ValueError(f"{source[0]}: it begins a line, but does not follow a table.")
        rows = [_shown(form, row) for rows, form in lines for row in _cells(rows, form, source[0], folder)]
        return before[: header.end()] + "".join(f"{row}\n" for row in rows)
    ((rows, form),) = lines
    row, *others = _cells(rows, form, source[0], folder)
    if others:
        raise ValueError(f"{source[0]}: {len(others) + 1} rows, not one.")
    if not (old := re.search(rf"(?:\?|{_pattern(form, row)})\Z", before)):
        raise ValueError(f"{source[0]}: no number of this format stands before it; type ? there.")
    new = _shown(form, row)
    return before if old[0].split() == new.split() else before[: old.start()] + new


def _parsed(line: str, comment: str) -> tuple[str, str]:
    """The conditions and the format of a line of a comment."""
    if not (found := LINE.fullmatch(line)):
        raise ValueError(f"{comment}: no format follows the row.")
    return found["rows"], found["form"]


def _cells(rows: str, form: str, comment: str, folder: Path) -> list[dict]:
    """The cells of each row that the conditions leave; those of several selections side by side."""
    selections = [_selected(one, comment, folder) for one in re.split(r" \+ (?=\w+\.csv)", rows)]
    if len({*map(len, selections)}) > 1:
        raise ValueError(
            f"{comment}: its selections have {' and '.join(str(len(one)) for one in selections)} rows."
        )
    cells = []
    for parts in zip(*selections, strict=True):
        later = {f"{name}_{k}": cell for k, part in enumerate(parts[1:], 2) for name, cell in part.items()}
        cells.append(later | parts[0])
    try:
        for row in cells:
            _shown(form, row)
    except (KeyError, ValueError) as error:
        raise ValueError(
            f"{comment}: evidence/tables/{rows.split()[0]} has no such cell ({error!r})."
        ) from None
    return cells


def _selected(rows: str, comment: str, folder: Path) -> list[dict]:
    """The cells of each row of a table that the conditions leave."""
    file, *conditions = shlex.split(rows)
    try:
        table = pd.read_csv(folder / file)
        for column, _, values in (condition.partition("=") for condition in conditions):
            kind = float if pd.api.types.is_numeric_dtype(table[column]) else str
            table = table[table[column].isin([kind(value) for value in values.split("|")])]
        cells = table.to_dict("records")
    except (OSError, KeyError, ValueError) as error:
        raise ValueError(f"{comment}: evidence/tables/{file} has no such cell ({error!r}).") from None
    if not cells:
        raise ValueError(f"{comment}: evidence/tables/{file} has no such row.")
    return cells


def _shown(form: str, row: dict) -> str:
    """The format with the cells of a row, with true minus signs; empty cells of a table for values that are missing."""
    parts = [
        re.sub(r"\S.*\S|\S", "", part)
        if any(pd.isna(row[name]) for name in _names(part))
        else part.format_map(row)
        for part in form.split("|")
    ]
    return re.sub(r"(?<![\w.])-(?=[\d.])", "−", "|".join(parts))


def _names(form: str) -> list[str]:
    return [name for _, name, _, _ in string.Formatter().parse(form) if name]


def _pattern(form: str, row: dict) -> str:
    """What an older text of a format looks like; a break of a line counts as a space."""
    parts = []
    for words, name, _, _ in string.Formatter().parse(form):
        parts.append(r"\s+".join(re.escape(word) for word in re.split(r"\s+", words)))
        parts.append("" if name is None else TEXT if isinstance(row[name], str) else NUMBER)
    return "".join(parts)
