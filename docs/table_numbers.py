"""Numbers of the pages, written from evidence/tables as docs/numbers.yaml says.

An entry of a page is a phrase with the format of its numbers in braces, and the row of a table, by its cells. The phrase stands
once on the page; {} is a number that another entry writes. `stated` are the numbers that no table holds, such as settings:

    docs/proteins.md:
      stated: [0.5, 5 %]
      entries:
      - phrase: d is {own:+.2f} ({own_low:+.2f} to {own_high:+.2f}) on average
        row: proteins_d.csv reading=kept range=5

A table is an entry with its header. Each of its parts writes all rows that its conditions leave, in their order:

      - header: '| dots / % | Z |'
        rows:
        - row: t.csv "sampler=farthest dots"
          form: '| {percent:g} | {Z:.2f} |'

A condition with spaces is quoted, and | separates alternatives, as in percent=5|10. Rows of several selections are joined by +,
in their order; columns of the second selection end in _2, those of the third in _3:

    row: t.csv sampler=farthest + t.csv sampler=uniform

For a new number, type ? on the page, and its entry here, and run docs/renew.py.
"""

import re
import shlex
import string
from functools import cache
from pathlib import Path

import pandas as pd
import yaml

HERE = Path(__file__).parent
TABLES = HERE.parent / "evidence" / "tables"
NUMBER = r"[+−-]?(?:\d{1,3}(?:,\d{3})+|\d+)(?:\.\d+)?(?:e[+−-]?\d+)?%?"
TEXT = r"(?:\([^()\n]*\)|[^\s|(]+)"
RULE = r"\n\|(?: *:?-+:? *\|)+ *\n"  # between the header of a table and its rows


# Not the prose of a page: blocks, code, formulas, addresses, headings and the names of versions
HIDDEN = r"(?ms)^```.*?^```|`[^`\n]*`|\$[^$\n]*\$|\]\([^)]*\)|<[^>]*>|^#.*?$|(?:Python|MSMS|doi:)\s*[\d./]+"
MEASURED = r"(?<![\w.−])[+−]?(?:\d+(?:,\d{3})*\.\d+(?: %)?|\d+ %)"


@cache
def of_pages() -> dict[str, dict]:
    """Return the entries and the stated numbers of each page, by its path in the repository."""
    return yaml.safe_load((HERE / "numbers.yaml").read_text(encoding="utf-8"))


def renewed(text: str, page: dict, folder: Path = TABLES) -> str:
    """Return a page with each number as its table gives it; ValueError names what does not fit."""
    covered = [False] * len(text)
    for entry in page.get("entries", []):
        write = _with_rows if "header" in entry else _with_numbers
        start, end, new = write(text, entry, folder)
        text = text[:start] + new + text[end:]
        covered[start:end] = [True] * len(new)
    for hidden in re.finditer(HIDDEN, text):
        covered[hidden.start() : hidden.end()] = [True] * len(hidden[0])
    for number in re.finditer(MEASURED, text):
        if not covered[number.start()] and "stated" in page and number[0] not in map(str, page["stated"]):
            line = text.count("\n", 0, number.start()) + 1
            raise ValueError(
                f"line {line}: no entry of docs/numbers.yaml writes {number[0]}; add one, or the number to `stated` if no "
                "table holds it."
            )
    return text


def _with_numbers(text: str, entry: dict, folder: Path) -> tuple[int, int, str]:
    """The place of a phrase on a page, and the phrase with its numbers renewed."""
    phrase = entry["phrase"]
    row, *others = _cells(entry["row"], phrase, phrase, folder)
    if others:
        raise ValueError(f"{phrase}: {len(others) + 1} rows, not one.")
    found = _found(text, _pattern(phrase, row), phrase)
    shown = iter(_shown(phrase, row).split("\0"))  # without the numbers of other entries
    new = "".join(between + next(shown, "") for between in ["", *found.groups()])
    same = "".join(found[0].split()) == "".join(new.split())
    return *found.span(), found[0] if same else _wrapped_as(found[0], new)


def _wrapped_as(old: str, new: str) -> str:
    """A text with the breaks of lines of an older form, which has as many words."""
    spaces = iter(re.findall(r"\s+", old))
    return re.sub(r"\s+", lambda _: next(spaces, " "), new)


def _with_rows(text: str, entry: dict, folder: Path) -> tuple[int, int, str]:
    """The place of the rows of a table on a page, and the rows renewed."""
    header = entry["header"]
    found = _found(text, rf"(?<![^\n]){re.escape(header)}{RULE}((?:\|.*\n)*)", header)
    rows = [
        _shown(part["form"], row)
        for part in entry["rows"]
        for row in _cells(part["row"], part["form"], header, folder)
    ]
    return *found.span(1), "".join(f"{row}\n" for row in rows)


def _found(text: str, pattern: str, words: str) -> re.Match[str]:
    """The only place of a pattern on a page; ValueError if there is none, or another."""
    places = [*re.finditer(pattern, text)]
    if len(places) != 1:
        lines = "".join(f", line {text.count(chr(10), 0, place.start()) + 1}" for place in places)
        raise ValueError(f"{words}: stands {len(places)} times on the page{lines}; it must stand once.")
    return places[0]


def _cells(rows: str, form: str, words: str, folder: Path) -> list[dict]:
    """The cells of each row that the conditions leave; those of several selections side by side."""
    selections = [_selected(one, words, folder) for one in re.split(r" \+ (?=\w+\.csv)", rows)]
    if len({*map(len, selections)}) > 1:
        raise ValueError(
            f"{words}: its selections have {' and '.join(str(len(one)) for one in selections)} rows."
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
            f"{words}: evidence/tables/{rows.split()[0]} has no such cell ({error!r})."
        ) from None
    return cells


def _selected(rows: str, words: str, folder: Path) -> list[dict]:
    """The cells of each row of a table that the conditions leave."""
    file, *conditions = shlex.split(rows)
    try:
        table = pd.read_csv(folder / file)
        for column, _, values in (condition.partition("=") for condition in conditions):
            kind = float if pd.api.types.is_numeric_dtype(table[column]) else str
            table = table[table[column].isin([kind(value) for value in values.split("|")])]
        cells = table.to_dict("records")
    except (OSError, KeyError, ValueError) as error:
        raise ValueError(f"{words}: evidence/tables/{file} has no such cell ({error!r}).") from None
    if not cells:
        raise ValueError(f"{words}: evidence/tables/{file} has no such row.")
    return cells


def _shown(form: str, row: dict) -> str:
    """The format with the cells of a row, with true minus signs; empty cells of a table for values that are missing."""
    parts = [
        re.sub(r"\S.*\S|\S", "", part)
        if any(pd.isna(row[name]) for name in _names(part))
        else part.replace("{}", "\0").format_map(row)
        for part in form.split("|")
    ]
    return re.sub(r"(?<![\w.])-(?=[\d.])", "−", "|".join(parts))


def _names(form: str) -> list[str]:
    """The columns whose values a format takes."""
    return [name for _, name, _, _ in string.Formatter().parse(form) if name]


def _pattern(phrase: str, row: dict) -> str:
    """What a phrase looks like on the page, with a group for each number of another entry; a break of a line is a space."""
    parts = []
    for words, name, _, _ in string.Formatter().parse(phrase):
        parts.append(r"\s+".join(re.escape(word) for word in re.split(r"\s+", words)))
        if name == "":
            parts.append(f"({NUMBER})")
        elif name:
            parts.append(TEXT if isinstance(row[name], str) else rf"(?:\?|{NUMBER})")
    return rf"(?<![\w.,−+]){''.join(parts)}(?![\w%]|[.,]\d)"
