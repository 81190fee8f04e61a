"""A run as its first page sees it: its folder, its files, and the tables that several parts of the page read."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sparsurf.recovery.readings import readings_of_columns
from sparsurf_study import catalogue
from sparsurf_study.report.numbers import short_names

NAMES = ["protein", "conformation"]
MAX_SHOWN = 20  # surfaces, pairs or comparisons that the page shows one by one
MAX_ROWS = 100  # A table of the page has at most so many rows.
MAX_CARDS = 3  # surfaces that the cards name one by one


class Cell(NamedTuple):
    """A cell of a table: its text, the file that it links, a picture that opens on a click, and the key it is sorted by."""

    text: str
    path: str = ""
    picture: str = ""
    key: str = ""


class TableLink(NamedTuple):
    """A table of texts and cells; one that is sortable has a field for a search above it."""

    columns: list[str]
    rows: list[list[Any]]
    sortable: bool = False


class Figure(NamedTuple):
    """A picture of the run: its path, its caption, and the page that it links."""

    path: str
    caption: str
    page: str = ""


@dataclass
class Run:
    """A run: the folder, and the files that the page may read and link."""

    folder: Path
    files: list[str]

    def read(self, path: str) -> pd.DataFrame:
        """Read a table of the run; names remain strings, "012", "1E96" and "NA" too."""
        names = dict.fromkeys([*NAMES, "complex", "bound", "chain", "residue"], str)
        table = pd.read_csv(self.folder / path, dtype=names, keep_default_na=False, na_values=[""])
        texts = [name for name in ("bound", "chain") if name in table]
        return table.fillna(dict.fromkeys(texts, ""))

    def has(self, path: str) -> bool:
        """Return whether the page may link a file."""
        return path in self._known

    def ending(self, end: str) -> list[str]:
        """Return the folders of the files that end in /`end`."""
        return [path.removesuffix(f"/{end}") for path in self.files if path.endswith(f"/{end}")]

    @cached_property
    def _known(self) -> frozenset[str]:
        return frozenset(self.files)

    @cached_property
    def places(self) -> list[str]:
        """Folders of the surfaces, protein/conformation."""
        return [place for place in self.ending("recovered.csv") if place.count("/") == 1]

    @cached_property
    def shown(self) -> dict[str, str]:
        """Name of each surface on the page."""
        return short_names(place.split("/") for place in self.places)

    @cached_property
    def surfaces(self) -> pd.DataFrame:
        """The rows of surfaces.csv, by protein/conformation, in the order of `places`; empty if there is no such table."""
        if not self.has("surfaces.csv"):
            return pd.DataFrame()
        table = self.read("surfaces.csv")
        return table.set_index(table["protein"] + "/" + table["conformation"]).loc[self.places]

    @cached_property
    def grids(self) -> dict[str, pd.DataFrame]:
        """The rows of summary.csv of each surface with a grid."""
        if not self.has("summary.csv"):
            return {}
        table = self.read("summary.csv")
        names = table["protein"] + "/" + table["conformation"]
        return {str(place): rows for place, rows in table.groupby(names, sort=False)}

    @cached_property
    def readings(self) -> list[str]:
        """Readings of the grid."""
        return readings_of_columns(self.surfaces, "best_")

    def best(self, place: str) -> dict[str, Any]:
        """Read best.json of a surface."""
        return json.loads((self.folder / place / "best.json").read_text(encoding="utf-8"))

    def listed(self, folder: str, section: str) -> Iterator[tuple[str, catalogue.Output]]:
        """Yield the files of a folder that the run has and that a section of the page shows, in the order of the catalogue."""
        for output in catalogue.in_section(section):
            path = f"{folder}/{output.name}".removeprefix("/")
            if self.has(path) and catalogue.output_of(path) is output:
                yield path, output

    def links(self, folder: str, section: str) -> list[tuple[str, str]]:
        """Return the files of a folder that a section of the page lists, with what they contain."""
        return [(path, output.content) for path, output in self.listed(folder, section)]

    def file_cells(self, folder: str, section: str) -> list[Cell]:
        """Return the files of a folder that stand in its row of a table."""
        return [Cell(path.split("/")[-1], path) for path, _ in self.listed(folder, section)]

    def figures(self, folder: str, section: str, prefix: str = "") -> list[Figure]:
        """Return the figures of a folder that a section of the page shows, each with a prefix and its caption."""
        return [Figure(path, prefix + output.caption) for path, output in self.listed(folder, section)]

    def figure(self, path: str) -> Figure | None:
        """Return a figure with its caption; None where the run does not have it."""
        output = catalogue.output_of(path)
        return Figure(path, output.caption) if output and self.has(path) else None
