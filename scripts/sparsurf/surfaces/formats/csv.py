"""Tables of dots, as the authors of the method keep them: a CSV with x, y, z, nx, ny, nz in its header."""

import codecs
import io
import re

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.surfaces.formats.format import Format
from sparsurf.surfaces.surface import surface_of_columns
from sparsurf.texts import text_of

# Lines before the header that are empty or begin with #, but for a header whose first column does (#,x,y,z or #id,x,y,z).
REMARKS = re.compile(r"(?:[ \t]*\n|#(?!.*,[ \t]*[zZ][ \t]*[,\n]).*\n)*")


def _sniff(head):
    """Whether the first line, but for remarks, has a comma, or names x, y and z without one."""
    text = head.removeprefix(codecs.BOM_UTF8).decode("latin-1").replace("\r", "\n")
    line = text[REMARKS.match(text).end() :].split("\n", 1)[0]
    return "," in line or {"x", "y", "z"} <= set(re.split(r'[;\s"]+', line.lower()))


def read_csv(content, path):
    """Surface of a table with x, y, z, nx, ny, nz in its header, in any case."""
    values = _columns(content, path, ["x", "y", "z", "nx", "ny", "nz"])
    return surface_of_columns({"points": values[:, :3], "normals": values[:, 3:]}, path)


def read_places(content, path):
    """(T, 3) places of a table with x, y, z in its header, in any case; in its order, also those that occur twice."""
    places = _columns(content, path, ["x", "y", "z"])
    wrong = np.flatnonzero(~np.isfinite(places).all(axis=1))
    if len(wrong):
        raise InputError(
            f"{path}: x, y and z of row {wrong[0] + 1} below the header are not three numbers: mend it."
        )
    if len(places) == 0:
        raise InputError(f"{path} holds no places.")
    return np.ascontiguousarray(places)


def _columns(content, path, names):
    """(N, names) float64 of a table, NaN where there is no number."""
    text = text_of(content, path)
    text = text[REMARKS.match(text).end() :]
    if "," not in text.split("\n", 1)[0]:
        raise InputError(
            f"{path} has no commas in its header: put commas between columns, and points into numbers."
        )
    try:
        table = pd.read_csv(io.StringIO(text), skipinitialspace=True)
    except (pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise InputError(f"{path} is not a table of dots: {str(error).strip()}.") from None
    if not isinstance(table.index, pd.RangeIndex):  # pandas takes the first values for names of the rows
        raise InputError(
            f"{path}: its rows have more values than its header has names; name every column, and end no row with a comma."
        )
    # numpy's savetxt names the first column "# x"
    table.columns = [str(name).removeprefix("# ").strip().lower() for name in table.columns]
    wrong = [name for name in names if list(table.columns).count(name) != 1]
    if wrong:
        raise InputError(f"{path} needs one column {wrong[0]}; its header must name {', '.join(names)}.")
    return table[names].apply(pd.to_numeric, errors="coerce").to_numpy(float)


FORMAT = Format("CSV", (".csv",), _sniff, read_csv)
