"""Tables of dots: CSV files with x, y, z, nx, ny, nz in their header, as the authors of the method write them."""

from __future__ import annotations

import codecs
import csv
import io
import logging
import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.files import decode_text, ends_within_a_row, shorten
from sparsurf.surfaces.surface import (
    RECONSTRUCTION_COLUMNS,
    Surface,
    SurfaceFormat,
    is_field_name,
    reconstruction_of_file,
    surface_of_columns,
    warn_of_field_names,
)

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger("sparsurf")

DOT_FORMAT = "%.4f"  # Positions, normals and areas are written so: positions to 0.00005 Å.
FIELD_FORMAT = "%.6g"  # Fields, which may be small, are written so.
TABLE_FORMAT = "%.10g"  # Floats of tables that are no dots are written so.
MAX_COLUMNS = 1000
COLUMNS_OF_DOTS = ["x", "y", "z", "nx", "ny", "nz"]
# Empty lines, Excel's line sep=, and comments before the header.
# A header whose first column begins with # (#,x,y,z or #id,x,y,z) is not a comment.
COMMENTS = re.compile(r"(?:[ \t,;]*\n|[sS][eE][pP]=.?\n|#(?!.*,[ \t]*[zZ][ \t]*[,\n]).*\n)*")


def _sniff(head: bytes) -> bool:
    """Return whether the first line after comments has a comma, or names x, y and z without one."""
    text = head.removeprefix(codecs.BOM_UTF8).decode("latin-1").replace("\r", "\n")
    line = text[_length_of_comments(text) :].split("\n", 1)[0]
    if head.startswith(b"PK"):  # an npz, whose bytes may hold a comma
        return False
    return "," in line or {"x", "y", "z"} <= set(re.split(r'[;\s"]+', line.lower()))


def _length_of_comments(text: str) -> int:
    """Count the characters before the header."""
    match = COMMENTS.match(text)
    return match.end() if match else 0


def read_csv(content: bytes) -> Surface:
    """Read a surface from a table with x, y, z, nx, ny, nz in its header, in upper or lower case."""
    import pandas as pd  # here: it takes long to load

    values, fields, lines, table = _columns(content, COLUMNS_OF_DOTS)
    reconstruction = reconstruction_of_file(
        {name: table[name].to_numpy() for name in table.columns.unique() if name in RECONSTRUCTION_COLUMNS}
    )
    columns = {"points": values[:, :3], "normals": values[:, 3:]} | fields
    if list(table.columns).count("area") == 1 and pd.api.types.is_numeric_dtype(table["area"]):
        columns["area"] = table["area"].to_numpy(float)
    return surface_of_columns(columns, lines, "weight" in table, reconstruction=reconstruction)


def read_points_of_csv(content: bytes) -> np.ndarray:
    """Read the points (T, 3), Å, of a table with x, y, z in its header, in upper or lower case; points that occur twice stay."""
    points, _, lines, _ = _columns(content, ["x", "y", "z"])
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(wrong):
        raise InputError(
            f"{FILE}: line {lines[wrong[0]]} does not have the three numbers x, y and z: repair it."
        )
    if len(points) == 0:
        raise InputError(f"{FILE} holds no points.")
    return np.ascontiguousarray(points)


def write_csv(
    path: Path | str,
    columns: pd.DataFrame | Mapping[str, np.ndarray],
    fields: Collection[str] = (),
    form: str = DOT_FORMAT,
) -> None:
    """Write a table: `fields` with six significant digits, other floats in another form, by default four decimals."""
    cells = []
    for name, column in columns.items():
        if name in fields or column.dtype.kind == "f":  # half the time of `to_csv`
            cell = (FIELD_FORMAT if name in fields else form).__mod__
            cells.append([cell(value) if value == value else "" for value in column.tolist()])
        elif isinstance(column, np.ndarray):
            cells.append(column.tolist())
        else:
            cells.append(column.astype(object).where(column.notna(), "").tolist())
    with open(path, "w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*cells, strict=True))


def _columns(
    content: bytes, names: list[str]
) -> tuple[np.ndarray, dict[str, np.ndarray], list[int], pd.DataFrame]:
    """Return the columns `names`, (N, names) float64 with NaN for other text, fields by name, the line of each row, and all."""
    import pandas as pd  # here: it takes long to load

    text = decode_text(content)
    n_skipped = text[: _length_of_comments(text)].count("\n")
    text = text[_length_of_comments(text) :]
    table, header = _parse_table(text, n_skipped)
    table.columns = pd.Index([name.lower() for name in header])
    if list(table.columns).count("frame") == 1 and not {"x", "y", "z"} & {*table.columns}:
        rows = "residues in each frame" if "residue" in table else "frames"
        raise InputError(
            f"{FILE} is a table of the {rows} of a trajectory, as `sparsurf frames` writes it, and holds no dots: give the "
            "structure, and the trajectory with --trajectory (in Python, trajectory=...)."
        )
    if names == COLUMNS_OF_DOTS and list(table.columns).count("frame") == 1 and table["frame"].nunique() > 1:
        raise InputError(
            f"{FILE} holds the dots of {table['frame'].nunique()} frames: keep the rows of one frame alone."
        )
    wrong = [name for name in names if list(table.columns).count(name) != 1]
    if wrong:
        how_many = "several columns" if wrong[0] in list(table.columns) else "no column"
        raise InputError(
            f"{FILE} has {how_many} {wrong[0]}; its first line must name the columns {', '.join(names)} once each."
        )
    numeric = [k for k in range(len(header)) if pd.api.types.is_numeric_dtype(table.dtypes.iloc[k])]
    possible_fields = [k for k in range(len(header)) if is_field_name(header[k])]
    if names == COLUMNS_OF_DOTS:
        _warn_of_omitted_columns(table, header, numeric, possible_fields)
    numeric = [k for k in numeric if k in possible_fields]
    if twice := [header[k] for k in numeric if header.count(header[k]) > 1]:
        raise InputError(f"{FILE} has the column {twice[0]!r} twice; remove or rename one.")
    try:
        fields = {header[k]: table.iloc[:, k].to_numpy(float) for k in numeric}
        values = table[names].apply(pd.to_numeric, errors="coerce").to_numpy(float)
    except OverflowError:
        raise InputError(f"{FILE} holds a number above 1e308: repair it.") from None
    lines = _lines_of_rows(text, n_skipped)
    if names == COLUMNS_OF_DOTS:
        _check_sizes(table, lines)
    if ends_within_a_row(text, lambda line: next(csv.reader([line], skipinitialspace=True), [""])):
        raise InputError(f"{FILE} is cut short: line {lines[-1]} is not complete; copy it again.")
    return values, fields, lines, table


def _parse_table(text: str, n_skipped: int) -> tuple[pd.DataFrame, list[str]]:
    """Parse a table and the names in its header, which follows `n_skipped` lines of the file."""
    import pandas as pd

    if "," not in text.split("\n", 1)[0]:
        raise InputError(
            f"{FILE} has no commas in its header: separate the columns with commas, and write decimals with a point (1.5)."
        )
    if max(line.count(",") for line in text.split("\n")) > MAX_COLUMNS:
        raise InputError(f"{FILE} has a line of more than {MAX_COLUMNS} values: repair it.")
    try:
        table = pd.read_csv(io.StringIO(text), skipinitialspace=True)
        header = next(csv.reader(io.StringIO(text, ""), skipinitialspace=True))  # pandas renames duplicates
    except (pd.errors.ParserError, pd.errors.EmptyDataError, csv.Error) as error:
        match = re.search(r"Expected (\d+) fields in line (\d+), saw (\d+)", str(error))
        reason = "it is damaged"
        if match:
            reason = f"line {n_skipped + int(match[2])} has {match[3]} values, not {match[1]}"
        raise InputError(f"{FILE} is not a table of dots: {reason}; repair it.") from None
    if not isinstance(table.index, pd.RangeIndex):  # pandas takes the first values for names of the rows
        raise InputError(f"{FILE}: its rows have more values than its header has names; name every column.")
    # numpy's savetxt names the first column "# x"
    return table, [name.removeprefix("# ").strip() for name in header]


def _check_sizes(table: pd.DataFrame, lines: list[int]) -> None:
    """Raise InputError if an area or a weight is negative or infinite."""
    import pandas as pd

    for name in table.columns.intersection(["area", "weight"]):
        numbers = table.loc[:, [name]].apply(pd.to_numeric, errors="coerce").to_numpy(float)
        wrong = np.flatnonzero(((numbers < 0) | np.isinf(numbers)).any(axis=1))
        if len(wrong):
            raise InputError(
                f"{FILE}: line {lines[wrong[0]]} has a negative or infinite {name}: repair or remove it."
            )


def _warn_of_omitted_columns(
    table: pd.DataFrame, header: list[str], numeric: list[int], possible_fields: list[int]
) -> None:
    """Warn of columns of numbers that cannot be fields because of their name or of a cell that is not a number."""
    import pandas as pd

    for k, name in enumerate(header):
        if k in possible_fields and k not in numeric:
            column = table.iloc[:, k]
            wrong = column[pd.to_numeric(column, errors="coerce").isna() & column.notna()]
            if 0 < len(wrong) < len(column) / 2:
                message = "%s: the column %s is left out: it holds %s, which is not a number"
                log.warning(message, FILE, name, shorten(repr(wrong.iloc[0])))
    warn_of_field_names([header[k] for k in numeric])


def _lines_of_rows(text: str, n_skipped: int) -> list[int]:
    """List the line of the file in which each row begins; empty lines are not rows."""
    if '"' not in text:  # otherwise a cell may contain line breaks
        lines = enumerate(text.split("\n"), n_skipped + 1)
        return [number for number, line in lines if line.strip(" ")][1:]
    reader = csv.reader(io.StringIO(text, ""), skipinitialspace=True)
    begin, numbers = n_skipped + 1, []
    for row in reader:
        if row not in ([], [""]):
            numbers.append(begin)
        begin = n_skipped + reader.line_num + 1
    return numbers[1:]


FORMAT = SurfaceFormat(_sniff, read_csv)
