"""Tables of dots, as the authors of the method keep them: a CSV with x, y, z, nx, ny, nz in its header."""

import io

import pandas as pd

from sparsurf import InputError
from sparsurf.surfaces.formats.format import Format
from sparsurf.surfaces.surface import surface_of_columns
from sparsurf.texts import text_of


def _sniff(head):
    """Whether the first line has a comma."""
    return b"," in head.replace(b"\r", b"\n").split(b"\n", 1)[0]


def read_csv(content, path):
    """Surface of a table with x, y, z, nx, ny, nz in its header, in any case."""
    try:
        table = pd.read_csv(io.StringIO(text_of(content, path)), skipinitialspace=True)
    except (pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise InputError(f"{path} is not a table of dots: {error}.") from None
    table.columns = [str(name).strip().lower() for name in table.columns]
    names = ["x", "y", "z", "nx", "ny", "nz"]
    wrong = [name for name in names if list(table.columns).count(name) != 1]
    if wrong:
        raise InputError(f"{path} needs one column {wrong[0]}; its header must name x, y, z, nx, ny, nz.")
    values = table[names].apply(pd.to_numeric, errors="coerce").to_numpy(float)
    return surface_of_columns({"points": values[:, :3], "normals": values[:, 3:]}, path)


FORMAT = Format("CSV", (".csv",), _sniff, read_csv)
