"""Check the numbers of README.md and docs/ against evidence/tables, and fill their tables: `python evidence/pages.py`.

The list evidence/pages.yaml says for each page which cell a number comes from, and which rows and columns a table shows:

    docs/recover.md:
      numbers:
      - text: the surface is recovered {} Å off on average.
        cells: [recover_means.csv sampler=farthest percent=10 distance]
      tables:
      - rows: recover_means.csv sampler=farthest percent=5|10
        columns:
          dots / %: "{percent:g}"
          Z (95 %): "{Z:.2f} ({Z_low:.2f} to {Z_high:.2f})"

In a text, {} stands for a number; the page holds the text once, over line breaks as well. A cell is a file, the row and the
column. A table stands in the page with the headers of its columns; of tables with equal headers the first in the list is the
first in the page. Each column is a format string over the cells of a row, and | separates alternatives of the rows.

The program fills the tables. Numbers that differ are only reported, as the sentence around one may need another word.
"""

import re
import shlex
import string
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from sparsurf import InputError

ROOT = Path(__file__).parent.parent
TABLES = Path(__file__).with_name("tables")
LIST = Path(__file__).with_name("pages.yaml")
NUMBER = r"([−+-]?\d[\d,]*(?:\.\d+)?)"
TABLE = re.compile(r"^\|[^\n]*\n\| *---(?:[^\n]+\n)+", re.M)  # header, rule and rows of a Markdown table


def read_list(path: Path = LIST) -> dict[str, dict[str, Any]]:
    """Return the numbers and tables of each page."""
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def rows_of(file: str, conditions: Sequence[str], folder: Path = TABLES) -> pd.DataFrame:
    """Return the rows of a table that fulfil every `column=value|value`, in the order of the file."""
    path = Path(folder) / file
    if not path.is_file():
        raise InputError(f"{file} is not in {folder}.")
    table = pd.read_csv(path)
    for condition in conditions:
        column, _, values = condition.partition("=")
        if column not in table:
            raise InputError(f"{file} has no column {column!r}.")
        cells = table[column]
        wanted = [
            float(value) if pd.api.types.is_numeric_dtype(cells) else value for value in values.split("|")
        ]
        table = table[cells.isin(wanted)]
    return table


def cell(text: str, folder: Path = TABLES) -> str | float:
    """Return the value that 'file.csv key=value ... column' names.

    Raises
    ------
    InputError : no such file, row or column, or several such rows
    """
    file, *conditions, column = shlex.split(text)
    rows = rows_of(file, conditions, folder)
    if len(rows) != 1 or column not in rows:
        raise InputError(
            f"{text}: {len(rows)} rows, {'with' if column in rows else 'without'} such a column."
        )
    return rows[column].iloc[0]


def differing(page: str, numbers: Sequence[Mapping[str, Any]], folder: Path = TABLES) -> list[str]:
    """Report the numbers of a page that are not those of their cells, rounded to as many decimals."""
    out = []
    for number in numbers:
        found = re.findall(_pattern(number["text"]), page)
        if len(found) != 1:
            out.append(f"{number['text']!r} is found {len(found)} times, not once")
            continue
        groups = found[0] if isinstance(found[0], tuple) else found
        for shown, source in zip(groups, number["cells"], strict=True):
            value = float(cell(source, folder))
            digits = shown.replace("−", "-").replace(",", "")
            decimals = len(digits.partition(".")[2])
            same = f"{value:.{decimals}f}".removeprefix("-") == digits.lstrip("+-")
            if not same or (value < 0) != digits.startswith("-"):
                out.append(f"{shown} is {value:.{decimals + 1}f} in {source}")
    return out


def filled(page: str, tables: Sequence[Mapping[str, Any]], folder: Path = TABLES) -> str:
    """Return a page with its tables made from their files.

    Raises
    ------
    InputError : the page has no table with such headers
    """
    ends: dict[str, int] = {}  # header -> end of the last table with that header
    for table in tables:
        header = _line(table["columns"])
        place = page.find(f"{header}| --- |", ends.get(header, 0))
        match = TABLE.match(page, place) if place >= 0 else None
        if match is None:
            raise InputError(f"{table['rows']}: the page has no table {header.strip()}.")
        file, *conditions = shlex.split(table["rows"])
        rows = rows_of(file, conditions, folder).to_dict("records")
        lines = [header, _line(["---"] * len(table["columns"]))]
        lines += [_line([_shown(form, row) for form in table["columns"].values()]) for row in rows]
        made = "".join(lines)
        longer = len(made) - len(match[0])
        ends = {key: end + longer * (end > place) for key, end in ends.items()}
        ends[header] = place + len(made)
        page = page[:place] + made + page[match.end() :]
    return page


def _pattern(text: str) -> str:
    """Return the regular expression of a text whose {} are numbers, with any white space between words."""
    return r"\s+".join(NUMBER.join(re.escape(part) for part in word.split("{}")) for word in text.split())


def _line(cells: Any) -> str:
    """Return a row of a Markdown table."""
    return f"| {' | '.join(cells)} |\n"


def _shown(form: str, row: Mapping[str, Any]) -> str:
    """Format one cell; empty where one of its values is missing."""
    names = [name for _, name, _, _ in string.Formatter().parse(form) if name]
    if any(pd.isna(row[name]) for name in names):
        return ""
    return re.sub(r"(?<![\w.])-(?=[\d.])", "−", form.format_map(row))


def main() -> list[str]:
    """Fill the tables of all pages; return a sentence for each number that differs."""
    wrong = []
    for name, entries in read_list().items():
        path = ROOT / name
        text = path.read_text(encoding="utf-8")
        path.write_text(filled(text, entries.get("tables", ())), encoding="utf-8")
        wrong += [f"{name}: {sentence}" for sentence in differing(text, entries.get("numbers", ()))]
    return wrong


if __name__ == "__main__":
    try:
        sys.exit("\n".join(main()) or 0)
    except InputError as error:
        sys.exit(str(error))
