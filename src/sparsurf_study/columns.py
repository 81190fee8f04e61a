"""Columns of every CSV of a run and of the command line: type, unit and meaning, from catalogue.yaml."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from sparsurf import registry
from sparsurf_study import catalogue

PLACEHOLDERS = {
    "<reading>": f"(?:{'|'.join(registry.TABLE['reading'])})",
    "<residue>": r"[^:]*:\w+",
    "<n>": r"\d+",
    "<m>": r"\d+",
    "<row>": "[123]",
    "<axis>": "[xyz]",
}
ANY_NAME = r"\S+"  # The name of a field or sampler.


@dataclass(frozen=True)
class Column:
    """One column of a table."""

    name: str  # a part such as <reading> stands for several names
    type: str  # 'text', 'int', 'float', 'bool' or 'bytes'
    unit: str  # empty without one
    meaning: str
    optional: bool = False  # some tables lack it

    def matches(self, name: str) -> bool:
        """Return whether a column of that name is described here."""
        return bool(_pattern(self.name).fullmatch(name))


@dataclass(frozen=True)
class TableDescription:
    """A table: what each of its rows is, and its columns in order."""

    row: str
    columns: tuple[Column, ...]

    def column(self, name: str) -> Column | None:
        """Return the description of a column; the most specific one."""
        matching = [column for column in self.columns if column.matches(name)]
        return min(matching, key=lambda column: (column.name.count("<"), -len(column.name)), default=None)


@cache
def tables() -> dict[str, TableDescription]:
    """Return all tables by their path below results/<run>/, or by their command."""
    listed = catalogue.content()
    shared = {name: Column(name, *definition) for name, definition in listed["columns"].items()}
    with_rows = {name: entry for name, entry in listed["outputs"].items() if "row" in entry}
    return {
        name: TableDescription(table["row"], tuple(_columns_of(table, shared, listed["suffixes"])))
        for name, table in (with_rows | listed["commands"]).items()
    }


def missing_columns(name: str, columns: Iterable[str]) -> list[str]:
    """Return the columns that a table lacks, in the one of the tables named like ranges.csv that it is most like."""
    present = list(columns)
    named_alike = [table for key, table in tables().items() if key.rpartition("/")[2] == name]
    lacking = []
    for table in named_alike:
        required = [column.name for column in table.columns if "<" not in column.name and not column.optional]
        lacking.append([column for column in required if column not in present])
    return min(lacking, key=len, default=[])


def _columns_of(
    table: Mapping[str, Any], shared: Mapping[str, Column], suffixes: Mapping[str, str]
) -> Iterator[Column]:
    """Resolve the columns of one table, in order."""
    entries: list[Any] = []
    for part in table["columns"]:
        entries += part if isinstance(part, list) else [part]
    of_table = {name: Column(name, *definition) for name, definition in table.get("own", {}).items()}
    for entry in entries:
        if isinstance(entry, Mapping):
            ((label, definition),) = entry.items()
            name = label.removesuffix("?")
            of_table[name] = Column(name, *definition)
        else:
            label, name = entry, entry.removesuffix("?")
        column = _known(name, {**shared, **of_table}, suffixes)
        yield replace(column, name=name, optional=label.endswith("?"))


def _known(name: str, columns: Mapping[str, Column], suffixes: Mapping[str, str]) -> Column:
    """Return a described column, or derive an interval end, error or spread from the column that it belongs to."""
    if name in columns:
        return columns[name]
    for suffix, meaning in suffixes.items():
        base, reading = name.removesuffix("_<reading>"), "_<reading>" * name.endswith("_<reading>")
        if base.endswith(f"_{suffix}"):
            base = base.removesuffix(f"_{suffix}")
            column = columns[f"{base}{reading}"]
            return replace(column, type="float", meaning=meaning.format(f"`{base}{reading}`"))
    raise KeyError(f"catalogue.yaml does not explain the column {name}")


@cache
def _pattern(name: str) -> re.Pattern[str]:
    """Return the regular expression of the names that a column stands for."""
    parts = re.split("(<[a-z]+>)", name)
    return re.compile(
        "".join(PLACEHOLDERS.get(part, ANY_NAME) if part[:1] == "<" else re.escape(part) for part in parts)
    )
