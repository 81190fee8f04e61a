"""Numbers and tables of Markdown pages, each with the cell it comes from: `python evidence/pages.py README.md docs/*.md`.

A number in prose is followed by a comment with its file in evidence/tables, the row and the column:

    comes back 0.02<!-- recover_means.csv sampler=farthest percent=10 distance --> Å off

A table follows a comment with its file, the rows (alternatives with |) and one line for each column, which is a format
string over the cells of a row. It ends at the first blank line:

    <!-- table recover_means.csv sampler=farthest percent=5|10
    dots / %: {percent:g}
    Z (95 %): {Z:.2f} ({Z_low:.2f} to {Z_high:.2f})
    -->

This program fills the tables. Of numbers it only names those that differ: the sentence around one may need another word.
"""

import re
import shlex
import string
import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from sparsurf import InputError

TABLES = Path(__file__).with_name("tables")
NUMBER = re.compile(r"(?P<number>[−+-]?\d[\d,]*(?:\.\d+)?)(?: ?[%Å°])?<!-- (?P<cell>\S+\.csv [^>]*?) -->")
TABLE = re.compile(
    r"(?P<mark><!-- table (?P<rows>\S+\.csv[^\n]*)\n(?P<columns>.*?)-->\n)(?P<body>(?:[^\n]+\n)*)", re.S
)


def rows_of(file: str, conditions: Sequence[str], folder: Path = TABLES) -> pd.DataFrame:
    """Rows of a table that fulfil every `column=value|value`, in the order of the file."""
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
    """The value that 'file.csv key=value ... column' names.

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


def differing(text: str, folder: Path = TABLES) -> list[str]:
    """Sentences on the numbers of a page that are not those of their cells, rounded to as many decimals."""
    out = []
    for match in NUMBER.finditer(text):
        shown = match["number"].replace("−", "-").replace(",", "")
        value = float(cell(match["cell"], folder))
        decimals = len(shown.partition(".")[2])
        if f"{value:.{decimals}f}".removeprefix("-") != shown.lstrip("+-") or (value < 0) != shown.startswith(
            "-"
        ):
            out.append(f"{match['number']} is {value:.{decimals + 1}f} in {match['cell']}")
    return out


def filled(text: str, folder: Path = TABLES) -> str:
    """A page with its tables made from their files."""

    def one(match: re.Match) -> str:
        file, *conditions = shlex.split(match["rows"])
        columns = [line.split(": ", 1) for line in match["columns"].strip().splitlines()]
        rows = rows_of(file, conditions, folder).to_dict("records")
        lines = [[header.strip() for header, _ in columns], ["---"] * len(columns)]
        lines += [[_shown(form.strip(), row) for _, form in columns] for row in rows]
        return match["mark"] + "".join(f"| {' | '.join(line)} |\n" for line in lines)

    return TABLE.sub(one, text)


def _shown(form: str, row: dict) -> str:
    """One cell; empty where one of its values is missing."""
    names = [name for _, name, _, _ in string.Formatter().parse(form) if name]
    if any(pd.isna(row[name]) for name in names):
        return ""
    return re.sub(r"(?<![\w.])-(?=[\d.])", "−", form.format_map(row))


def main(paths: Sequence[str]) -> list[str]:
    """Fill the tables of pages; the sentences of all numbers that differ."""
    wrong = []
    for path in map(Path, paths):
        text = path.read_text(encoding="utf-8")
        path.write_text(filled(text), encoding="utf-8")
        wrong += [f"{path}: {sentence}" for sentence in differing(text)]
    return wrong


if __name__ == "__main__":
    try:
        sys.exit("\n".join(main(sys.argv[1:])) or 0)
    except InputError as error:
        sys.exit(str(error))
