"""Names that columns and readings of tables had in earlier releases, answered with those of today."""

from sparsurf import InputError

COLUMNS = {"islands": "reading"}
READINGS = {"kept": "as_coded", "surface": "as_written"}
MEASURES = (
    "d_",
    "Z_",
    "fragment_",
    "best_set_",
    "n_best_set_",
)  # beginnings of columns that end in a reading


def refuse_old_names(table, path):
    """Refuse a table of an earlier release.

    Raises
    ------
    InputError : with the old name and the new one
    """
    found = [(old, new) for old, new in COLUMNS.items() if old in table]
    for column in table:
        start, _, end = column.rpartition("_")
        if column.startswith(MEASURES) and end in READINGS:
            found.append((column, f"{start}_{READINGS[end]}"))
    if "reading" in table:
        found += [(old, new) for old, new in READINGS.items() if (table["reading"] == old).any()]
    if found:
        old, new = found[0]
        raise InputError(f"{path} is of an earlier release: {old!r} is now {new!r}. Run its study again.")
