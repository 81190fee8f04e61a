"""Tables of dots, as the authors of the method keep them: a CSV with x, y, z, nx, ny, nz in its header."""

import codecs
import csv
import io
import logging
import re

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.files import decode_text, shorten
from sparsurf.surfaces.surface import NO_FIELDS, Format, is_field, surface_of_columns

log = logging.getLogger("sparsurf")

DIGITS = "%.4f"  # of the floats of dots that are written: places to 0.00005 Å
FIELD_DIGITS = "%.6g"  # of fields, which may be small
NEVER = frozenset(["points", "normals", "self"])  # names that a field cannot have
MOST_COLUMNS = 1000
PLACE_AND_NORMAL = ["x", "y", "z", "nx", "ny", "nz"]
LAST = 10  # lines whose decimals tell how numbers are written
# Lines before the header that are empty or begin with #, but for a header whose first column does (#,x,y,z or #id,x,y,z).
REMARKS = re.compile(r"(?:[ \t]*\n|#(?!.*,[ \t]*[zZ][ \t]*[,\n]).*\n)*")


def _sniff(head):
    """Whether the first line, but for remarks, has a comma, or names x, y and z without one."""
    text = head.removeprefix(codecs.BOM_UTF8).decode("latin-1").replace("\r", "\n")
    line = text[REMARKS.match(text).end() :].split("\n", 1)[0]
    return "," in line or {"x", "y", "z"} <= set(re.split(r'[;\s"]+', line.lower()))


def read_csv(content, path):
    """Surface of a table with x, y, z, nx, ny, nz in its header, in any case."""
    values, fields, lines = _columns(content, path, PLACE_AND_NORMAL)
    return surface_of_columns({"points": values[:, :3], "normals": values[:, 3:]} | fields, path, lines)


def read_places(content, path):
    """(T, 3) places of a table with x, y, z in its header, in any case; in its order, also those that occur twice."""
    places, _, lines = _columns(content, path, ["x", "y", "z"])
    wrong = np.flatnonzero(~np.isfinite(places).all(axis=1))
    if len(wrong):
        raise InputError(f"{path}: line {lines[wrong[0]]} has no three numbers x, y and z: repair it.")
    if len(places) == 0:
        raise InputError(f"{path} holds no places.")
    return np.ascontiguousarray(places)


def write_csv(path, table, fields=()):
    """Write a table of dots; the columns `fields` with six digits whatever their size, other floats with four decimals."""
    texts = {
        name: [FIELD_DIGITS % value if value == value else "" for value in table[name].tolist()]
        for name in fields
    }
    table.assign(**texts).to_csv(path, index=False, float_format=DIGITS)


def _columns(content, path, names):
    """(N, names) float64 of a table, NaN where there is no number; its fields, (N,) by name; the line of each row."""
    text = decode_text(content, path)
    before = text[: REMARKS.match(text).end()].count("\n")
    text = text[REMARKS.match(text).end() :]
    if "," not in text.split("\n", 1)[0]:
        raise InputError(
            f"{path} has no commas in its header: put commas between columns, and points into numbers."
        )
    if max(line.count(",") for line in text.split("\n")) > MOST_COLUMNS:
        raise InputError(f"{path} has a line of more than {MOST_COLUMNS} values: repair it.")
    try:
        table = pd.read_csv(io.StringIO(text), skipinitialspace=True)
        header = next(
            csv.reader(io.StringIO(text, ""), skipinitialspace=True)
        )  # pandas changes one of two like names
    except (pd.errors.ParserError, pd.errors.EmptyDataError, csv.Error) as error:
        found = re.search(r"Expected (\d+) fields in line (\d+), saw (\d+)", str(error))
        reason = (
            f"line {before + int(found[2])} has {found[3]} values, not {found[1]}"
            if found
            else "it is damaged"
        )
        raise InputError(f"{path} is not a table of dots: {reason}; repair it.") from None
    if not isinstance(table.index, pd.RangeIndex):  # pandas takes the first values for names of the rows
        raise InputError(
            f"{path}: its rows have more values than its header has names; name every column, and end no row with a comma."
        )
    # numpy's savetxt names the first column "# x"
    given = [name.removeprefix("# ").strip() for name in header]
    table.columns = [name.lower() for name in given]
    if names == PLACE_AND_NORMAL and list(table.columns).count("frame") == 1 and table["frame"].nunique() > 1:
        raise InputError(
            f"{path} holds the dots of {table['frame'].nunique()} frames: give those of one, "
            "such as a file that -o dots_{frame}.csv writes."
        )
    wrong = [name for name in names if list(table.columns).count(name) != 1]
    if wrong:
        raise InputError(f"{path} needs one column {wrong[0]}; its header must name {', '.join(names)}.")
    numbers = [k for k in range(len(given)) if pd.api.types.is_numeric_dtype(table.dtypes.iloc[k])]
    of_fields = [k for k in range(len(given)) if is_field(table.columns[k]) and given[k] not in NEVER]
    if names == PLACE_AND_NORMAL:
        _tell_left_out(path, table, given, numbers, of_fields)
    numbers = [k for k in numbers if k in of_fields]
    if twice := [given[k] for k in numbers if given.count(given[k]) > 1]:
        raise InputError(f"{path} has the column {twice[0]!r} twice; remove or rename one.")
    try:
        fields = {given[k]: table.iloc[:, k].to_numpy(float) for k in numbers}
        values = table[names].apply(pd.to_numeric, errors="coerce").to_numpy(float)
    except OverflowError:
        raise InputError(f"{path} holds a number above 1e308: repair it.") from None
    lines = _lines_of_rows(text, before)
    if not text.endswith("\n") and _ends_within_a_number(text):
        raise InputError(f"{path} is cut short: line {lines[-1]} ends within a number; copy it again.")
    return values, fields, lines


def _tell_left_out(path, table, given, numbers, of_fields):
    """Warn of columns of numbers that are no fields: by their names, or by a cell that is no number."""
    for k, name in enumerate(given):
        if k in of_fields and k not in numbers:
            column = table.iloc[:, k]
            wrong = column[pd.to_numeric(column, errors="coerce").isna() & column.notna()]
            if 0 < len(wrong) < len(column) / 2:
                log.warning(
                    "%s: the column %s is left out: it holds %s, which is no number",
                    path,
                    name,
                    shorten(repr(wrong.iloc[0])),
                )
        elif k in numbers and k not in of_fields and name and table.columns[k] not in NO_FIELDS:
            log.warning(
                "%s: the column %s is left out: a field has another name, of letters, digits and _",
                path,
                shorten(repr(name)),
            )


def _lines_of_rows(text, before):
    """The line in which each row begins, behind `before` lines and the header; empty lines are no rows."""
    if '"' not in text:  # else a cell may hold the end of a line
        return [number for number, line in enumerate(text.split("\n"), before + 1) if line.strip(" ")][1:]
    reader, begin, found = csv.reader(io.StringIO(text, ""), skipinitialspace=True), before + 1, []
    for row in reader:
        if row not in ([], [""]):
            found.append(begin)
        begin = before + reader.line_num + 1
    return found[1:]


def _ends_within_a_number(text):
    """Whether the last number has fewer decimals than that of all of the lines before it, which have as many."""
    ends = [line.rpartition(",")[2].strip() for line in text.rstrip().split("\n")[-LAST:]]
    decimals = [len(end.partition(".")[2]) for end in ends]
    return len(ends) == LAST and len(set(decimals[:-1])) == 1 and decimals[-1] < decimals[0]


FORMAT = Format("CSV", (".csv",), _sniff, read_csv)
