"""The first page of a run: its answers, then a section for each thing that the run made, read from its tables.

To show something more, write a function that returns a `Section`, and name it in `sections`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import pandas as pd

from sparsurf.patches.readings import KEPT_READING
from sparsurf.recovery.readings import READINGS, readings_of_columns
from sparsurf.views.numbers import interval, number, share, signed, span
from sparsurf_study.pairs.ranking import BASELINE, MAIN_SCORE, means_over_pairs
from sparsurf_study.paper.verdict import is_one_more_run
from sparsurf_study.report.figure_names import GALLERY
from sparsurf_study.report.numbers import (
    auc_of,
    beyond_ranges,
    combination,
    is_fragmented,
    left_in_island,
    most_of,
    short_names,
)
from sparsurf_study.report.page import DEFAULT_LENGTHS, embedded_figures, write
from sparsurf_study.report.texts import (
    BATCH_TABLES,
    DOWNLOADS,
    FILES_OF_ALL,
    FILES_OF_CHANGES,
    FILES_OF_PAIR,
    FILES_OVER_TIME,
    TEXT,
    caption,
)

TEMPLATE = "front.html.j2"
NAMES = ["protein", "conformation"]
MAX_SHOWN = 20  # surfaces, pairs or comparisons that the page shows one by one
MAX_ROWS = 100  # of a table
MAX_ANSWERS = 3  # surfaces with a sentence each
N_RESIDUES = 10  # that change most
SIGNIFICANT = 0.05
Z_OF_RECOVERED = ("recovered_Z_published", "recovered_Z_rotation_robust")  # of surfaces.csv
# Small figures
PARAMETERS = "α,\u00a0β,\u00a0γ,\u00a0δ"
OF_ISLANDS = ["link / spacing", "left in island"]
FILES_OF_SURFACE = ("surface.html", "minimal.csv", "residues.csv")
SCORES = {MAIN_SCORE: "complementarity", BASELINE: "protrusion"}


class Cell(NamedTuple):
    """A cell of a table: its text, the file it links, a picture that opens on a click, and the key it is sorted by."""

    text: str
    path: str = ""
    picture: str = ""
    key: str = ""


class Table(NamedTuple):
    """A table of texts or cells; `about` stands above it, and all tables of a section but the first are folded under it."""

    columns: list[str]
    rows: list[list[Any]]
    about: str = ""
    sortable: bool = False


class Figure(NamedTuple):
    """A picture of the run with its caption, the page that it opens if there is one, and whether it is one of a gallery."""

    path: str
    caption: str
    page: str = ""
    small: bool = False


@dataclass
class Section:
    """What one part of the run has to say: a title, sentences, figures, tables, and links to files."""

    title: str
    text: list[str] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    links: list[tuple[str, str]] = field(default_factory=list)
    formula: bool = False  # of the paper's sampling, below the sentences
    folded: str = ""  # what the folded tables are of


@dataclass
class Run:
    """A run as its first page sees it: the folder, and the files that the page may read and link."""

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


def write_front(
    page: Path | str,
    files: Iterable[str],
    exclude: Mapping[str, str],
    batches: Mapping[str, Any] | None = None,
    lengths: Mapping[str, float] = DEFAULT_LENGTHS,
    broken: Sequence[tuple[str, str]] = (),
) -> list[str]:
    """Write the first page of a run in the folder of its `files`, and return its answers.

    `exclude` has reasons for parts that are left out, and `broken` files that contradict others, with a sentence for each.
    """
    run = Run(Path(page).parent, list(dict.fromkeys(files)))
    all_sections = sections(run, batches)
    figures = [figure.path for section in all_sections for figure in section.figures]
    figures += [
        cell.picture
        for section in all_sections for table in section.tables for row in table.rows for cell in row
        if isinstance(cell, Cell) and cell.picture
    ]  # fmt: skip
    images = embedded_figures(run.folder, figures)
    found = answers(run, batches)
    write(
        page,
        TEMPLATE,
        lengths,
        title=title(run),
        answers=found,
        without=list(exclude.items()),
        broken=broken,
        warnings=warned(run.folder / "warnings.csv", run.shown),
        sections=all_sections,
        images=images,
        n_outside=len({*figures} - images.keys()),
    )
    return found


def title(run: Run) -> str:
    """Return the question of a run."""
    proteins = list(dict.fromkeys(place.split("/")[0] for place in run.grids or run.places))
    names = ", ".join(proteins) if len(proteins) <= 6 else f"{len(proteins)} proteins"
    if run.grids:
        return f"Which parameters sample the surface of {names} best?"
    if changed := run.ending("changes.csv"):
        return f"What changes in {', '.join(path.split('/')[-1] for path in changed)}?"
    if run.has("pairs/pairs.csv"):
        return "Do matching shapes show where two proteins touch?"
    return f"How few dots describe the surface of {names}?" if names else run.folder.name


def answers(run: Run, batches: Mapping[str, Any] | None = None) -> list[str]:
    """Return what a run found, a sentence each; the terminal prints the same."""
    found = [sentence_of_grid(run, place) for place in run.grids]
    if len(found) > MAX_ANSWERS:
        found = [sentence_over_all(run, reading) for reading in run.readings]
    if run.has("paper_places.csv"):
        found.insert(0, sentence_of_paper(*map(run.read, ("paper_places.csv", "paper_tests.csv"))))
    if len(run.surfaces):
        found.append(sentence_of_dots(run))
    changed = [
        f"{folder.split('/')[-1]}: {sentence_of_changes(run.read(f'{folder}/changes.csv'))}"
        for folder in run.ending("changes.csv")
    ]
    found = found + changed if run.grids else changed + found
    if run.has("pairs/pairs.csv"):
        found.append(sentence_of_pairs(run.read("pairs/pairs.csv")))
    return found + ([sentence_of_batches(batches["surfaces"])] if batches else [])


def sections(run: Run, batches: Mapping[str, Any] | None = None) -> list[Section]:
    """Return the sections of the page, in order; those of things that the run does not have are left out."""
    found = list(of_batches(batches)) if batches else []
    if run.has("verdict.html"):
        table = "table1.png"
        figures = [Figure(table, caption("table1"), "verdict.html")] if run.has(table) else []
        found.append(Section("The paper", [], figures, links=[("verdict.html", "the paper, claim by claim")]))
    found += of_grid(run) if run.grids else of_changes(run)
    found += of_dots(run)
    found += of_changes(run) if run.grids else ()
    return [*found, *of_pairs(run), *of_frames(run), *of_surfaces(run), *of_files(run)]


def links(run: Run, folder: str, words: Mapping[str, str]) -> list[tuple[str, str]]:
    """Return the files of a folder that the run has, with what they contain."""
    paths = {f"{folder}/{name}".removeprefix("/"): text for name, text in words.items()}
    return [(path, text) for path, text in paths.items() if run.has(path)]


def file_cells(run: Run, folder: str, names: Iterable[str]) -> list[Cell]:
    """Return the files of a folder that the run has, for a table."""
    return [Cell(path.split("/")[-1], path) for path, _ in links(run, folder, dict.fromkeys(names, ""))]


def of_range(low: float, high: float) -> str:
    """Format a range of n_S."""
    return f"{number(low, 1)} – {number(high, 1)}"


# The paper's sampling


def sentence_of_grid(run: Run, place: str) -> str:
    """Say the best combination of a surface under the first reading, and whether any beats uniform dots under the others."""
    rows = run.grids[place]
    first, *others = run.readings
    winner = run.best(place)[first]["unrestricted"]
    d, kept = d_of(winner_row(winner, rows, first)), share(winner["n_S_percent"])
    n_best = int(winner["n_best_set"])
    which = f", one of {n_best} that may be the best" if n_best > 1 else ""
    parts = [
        f"Best (α, β, γ, δ) = {combination(winner)}{which}: keeps {kept} % of the dots, d {d} {READINGS[first].words}"
    ]
    if first == KEPT_READING and is_fragmented(winner):
        parts[0] += ", but the subset is fragmented"
    for reading in others:
        above, total = beaten(rows, reading)
        parts.append(
            f"{READINGS[reading].words} the sampling beats uniform dots in {above or 'none'} of {total} ranges"
        )
    name = f"{run.shown[place]}: " if len(run.places) > 1 else ""
    return f"{name}{'; '.join(parts)}."


def sentence_over_all(run: Run, reading: str) -> str:
    """Say in how many ranges of how many surfaces the best combination beats uniform dots."""
    counts = [beaten(rows, reading) for rows in run.grids.values()]
    above, total = (sum(pair[k] for pair in counts) for k in (0, 1))
    words = f"{READINGS[reading].words.capitalize()}, the paper's sampling beats uniform dots in {above} of {total} ranges"
    return f"{words}, on {sum(above > 0 for above, _ in counts)} of {len(counts)} surfaces."


def winner_row(winner: Mapping[str, Any], rows: pd.DataFrame, reading: str) -> Mapping[Any, Any]:
    """Return the row of the range that a best combination won, so that one value of d stands for it everywhere; else itself."""
    of_reading = rows[rows["reading"] == reading].dropna(subset=["alpha"]).to_dict("records")
    return next((row for row in of_reading if combination(row) == combination(winner)), winner)


def d_of(row: Mapping[Any, Any]) -> str:
    """Format d of a row, cross-validated, with its 95 % interval."""
    return interval(row["d_cv"], row["d_cv_low"], row["d_cv_high"])


def beaten(rows: pd.DataFrame, reading: str) -> tuple[int, int]:
    """Count the ranges in which d of the best combination lies above 0 with its 95 % interval, and all."""
    known = rows[(rows["reading"] == reading) & rows["d_cv"].notna()]
    return int((known["d_cv_low"] > 0).sum()), len(known)


def of_grid(run: Run) -> Iterator[Section]:
    """Yield the section of the best combinations by range, and the maps of d."""
    words = [READINGS[reading].words for reading in run.readings]
    remark = TEXT["d"]
    if len(words) > 1:
        remark += " " + TEXT["readings"].format(first=words[0], last=words[-1])
    shown = list(run.grids)[:MAX_SHOWN]
    tables = [ranges_table_of(run, place) for place in shown]
    others = shown[1:]  # whose tables are folded
    if len(run.grids) > MAX_ANSWERS and run.has("relation.csv"):
        tables, others = [table_over_all(run), *tables], shown
    few = len(others) <= MAX_ANSWERS
    folded = ", ".join(run.shown[place] for place in others) if few else f"each of {len(others)} surfaces"
    figures = []
    for k, place in enumerate(shown):
        name, small = f"{run.shown[place]}: " if len(run.grids) > 1 else "", k >= MAX_ANSWERS
        path = f"{place}/figures/d_over_grid.png"
        figures.append(Figure(path, name + caption("d_over_grid"), small=small))
    figures = [figure for figure in figures if run.has(figure.path)]
    text = [TEXT["sampling"], remark]
    yield Section("Best combination by number of dots", text, figures, tables, formula=True, folded=folded)


def ranges_table_of(run: Run, place: str) -> Table:
    """Tabulate the best combination of a surface in each range of n_S, and of all; beside the published one if it is known."""
    rows, best = run.grids[place], run.best(place)
    published = run.read("paper_places.csv") if run.has("paper_places.csv") and len(run.grids) == 1 else None
    columns, blank = ["range of n_S / %"], []
    if published is not None:
        columns += [f"published: {PARAMETERS}", "d"]
        blank = ["", ""]
    for reading in run.readings:
        columns += [f"{READINGS[reading].words}: {PARAMETERS}", "its\u00a0n_S\u00a0/\u00a0%", "d (95 %)"]
        columns += OF_ISLANDS if reading == KEPT_READING else []
    outside = beyond_ranges(run.read(f"{place}/grid.csv")["n_S_percent"])  # as exact as in best.json

    def cells(row: Mapping[Any, Any], reading: str, mark: str = "") -> list[str]:
        line = [combination(row), number(row["n_S_percent"], 1), d_of(row) + mark]
        of_islands = [number(row["link_over_spacing"]), left_in_island(row)]
        return line + (of_islands if reading == KEPT_READING else [])

    table = []
    for k, in_range in rows.groupby("range"):
        by = in_range.set_index("reading")
        line = [of_range(by["n_S_low_percent"].iloc[0], by["n_S_high_percent"].iloc[0])]
        if published is not None:
            row: Any = published[published["range"] == k].iloc[0]
            line += [combination(row), number(row["d_published"])]
        for reading in run.readings:
            row = by.loc[reading]
            line += cells(row, reading)
        table.append(line)
    below = f"best below {best['max_n_S_percent']:g} %"
    for words, key in (("best at the largest α", "unrestricted"), (below, "under_max_n_S")):
        line = [words, *blank]
        for reading in run.readings:
            if "answer" in (winner := best[reading][key]):
                line += ["–", "", ""] + [""] * len(OF_ISLANDS) * (reading == KEPT_READING)
            else:
                mark = " ‡" if winner["n_S_percent"] == outside else ""
                line += cells(winner_row(winner, rows, reading), reading, mark)
        table.append(line)
    about = [f"{run.shown[place]}: {TEXT['ranges']}"]
    if any("‡" in cell for line in table for cell in line):
        about.append(TEXT["most"])
    return Table(columns, table, " ".join(about))


def table_over_all(run: Run) -> Table:
    """Tabulate the combination that is best on average over the surfaces in each range, and d of each surface's own best."""
    relation, rows = run.read("relation.csv"), pd.concat(run.grids.values())
    columns = ["range of n_S / %"]
    for reading in run.readings:
        columns += [f"{READINGS[reading].words}: {PARAMETERS}", "median d (lowest to highest)"]
    table = []
    for k, in_range in relation.groupby("range"):
        by = in_range.set_index("reading")
        line = [of_range(by["n_S_low_percent"].iloc[0], by["n_S_high_percent"].iloc[0])]
        for reading in run.readings:
            d = rows[(rows["reading"] == reading) & (rows["range"] == k)]["d_cv"].dropna()
            best: Any = by.loc[reading]
            line += [combination(best), interval(d.median(), d.min(), d.max()) if len(d) else ""]
        table.append(line)
    about, tested = [TEXT["over_all"].format(n=len(run.grids))], relation["p"].dropna()
    if len(tested):
        about.append(TEXT["relation"].format(related=int((tested < SIGNIFICANT).sum()), tested=len(tested)))
    return Table(columns, table, " ".join(about))


def sentence_of_paper(places: pd.DataFrame, tests: pd.DataFrame) -> str:
    """Say whether Table I is reproduced, and how many published d and Z lie within 95 % of the runs made as published."""
    d, z = (int(places[f"{name}_inside"].sum()) for name in ("d", "Z_tS"))
    n, word = len(places), "" if is_one_more_run(tests) else "not "
    return (
        f"As the authors' code does it, Table I is {word}reproduced: {d} of {n} published d and {z} of {n} published Z lie in the"
        f" middle 95 % of {int(places['n_runs'].max())} runs made as published."
    )


# Few dots


def sentence_of_dots(run: Run) -> str:
    """Say how many dots give the surface back, and how closely."""
    table, n = run.surfaces, len(run.surfaces)
    of = table.median(numeric_only=True)
    percent, density = share(of["minimal_n_S_percent"]), number(of["minimal_density"])
    words = f"For few dots take minimal.csv: {percent} % of the dots ({density} per Å²"
    if table["minimal_n_S_percent_low"].notna().any():
        low, high = table["minimal_n_S_percent_low"].min(), table["minimal_n_S_percent_high"].max()
        words += f"; 95 % interval{'s within' if n > 1 else ''} {number(low, 1)} to {number(high, 1)} %"
    off = f"99 % within {number(of['recovered_high_99'])} Å, the farthest {number(table['recovered_largest'].max())} Å off"
    several = f", median of {n} surfaces" if n > 1 else ""
    return f"{words}) recover the surface to {number(of['recovered_mean'], 3)} Å on average ({off}){several}."


def of_dots(run: Run) -> Iterator[Section]:
    """Yield the section of how many dots are needed, and of how well they recover fields."""
    if not len(run.surfaces):
        return
    text, own = [TEXT["dots"]], f"{run.places[0]}/figures/required_dots.png"
    path = own if len(run.places) == 1 and run.has(own) else "required_dots.png"
    if tables := [run.read(f"{place}/fields.csv") for place in run.ending("fields.csv")]:
        minimal = pd.concat(tables).query("subset == 'minimal'").dropna(subset=["r"])
        medians = minimal.groupby("field", sort=False)["r"].median()
        values = ", ".join(f"{name} r = {number(r, 3)}" for name, r in medians.items())
        text += [f"The minimal subset gives fields back at the other dots: {values}."] if values else []
    figures = [Figure(path, caption("required_dots"))] if run.has(path) else []
    yield Section("How few dots are enough", text, figures)


# Two forms


def sentence_of_changes(table: pd.DataFrame) -> str:
    """Say how many residues change from one form to the other."""
    from sparsurf_study.pairs.changes import SHARE_ABOVE_FLOOR  # here: it loads every kernel

    known, moved = int(table["total"].count()), int(table["above_moved"].sum())
    more = " They differ all over: go by the order of the residues." if most_of(moved, known) else ""
    chance = round(SHARE_ABOVE_FLOOR * known)
    words = f"{moved} of {known} residues change more than if all atoms moved by 0.3 Å"
    return f"{words}; about {chance} would by chance.{more}"


def residue_name(row: Mapping[Any, Any]) -> str:
    """Name the residue of a row, such as A:SER195, with its other name on a mutant."""
    name = (f"{row['chain']}:" if row["chain"] else "") + f"{row['residue_name']}{row['residue']}"
    other = row["residue_name_second"]
    return name if row["residue_name"] == other else f"{name} → {other}"


def above_floor(row: Mapping[Any, Any]) -> str:
    """Name the two channels of a residue that are farthest above their floors; fewer if others are below."""
    names = [key.removesuffix("_floor") for key in [*row][::-1] if key.endswith("_floor")]
    channels = [name for name in names if name != "total"]
    ordered = sorted(channels, key=lambda name: -row[name] / row[f"{name}_floor"])
    return ", ".join(name for name in ordered[:2] if row[name] > row[f"{name}_floor"])


def of_changes(run: Run) -> Iterator[Section]:
    """Yield a section for each two forms that are compared."""
    from sparsurf_study.pairs.changes import over_floor  # as above

    columns = ["residue", "change", "floor: other dots", "floor: moved atoms", "most in"]
    columns += ["potential / kT/e", "hydropathy"]
    for folder in run.ending("changes.csv")[:MAX_SHOWN]:
        table = run.read(f"{folder}/changes.csv")
        known = table.dropna(subset=["total"])
        order = over_floor(known).sort_values(ascending=False).index[:N_RESIDUES]
        rows: list[list[Any]] = []
        for row in table.loc[order].to_dict("records"):
            line = [number(row[name]) for name in ("total", "total_floor", "total_moved")]
            fields = [signed(row[f"{name}_difference"], 1) for name in ("potential", "hydropathy")]
            rows.append([residue_name(row), *line, above_floor(row), *fields])
        text = [sentence_of_changes(table), TEXT["changes"], TEXT["floors_of_changes"]]
        if buried := len(table) - len(known):
            text.append(f"{buried} residues are buried on one form or both, and have no change.")
        if mutated := int((table["residue_name"] != table["residue_name_second"]).sum()):
            text.append(f"{mutated} residues have another name on the second form.")
        figures = [Figure(f"{folder}/changes.png", caption("changes"))]
        tables = [Table(columns, rows, TEXT["most_changed"])]
        name = folder.split("/")[-1]
        yield Section(f"What changes in {name}", text, figures, tables, links(run, folder, FILES_OF_CHANGES))


# Two partners


def sentence_of_pairs(table: pd.DataFrame) -> str:
    """Say how well the maps find the interface, next to protrusion."""
    n = table["complex"].nunique()
    if not n:
        return "No partners touch, so there is no interface to find."
    if n > 1:
        means, where = means_over_pairs(table).set_index("score"), f"over {n} pairs that touch"
        aucs = [auc_of(means, score, "mean") for score in SCORES]
    else:
        sides = [rows.set_index("score") for _, rows in table.groupby("partner")]
        where = "on its two partners"
        aucs = [" and ".join(auc_of(rows, score, "auc") for rows in sides) for score in SCORES]
    own, baseline = aucs
    return f"Complementarity finds the interface with AUC {own} {where}; protrusion alone has {baseline}; 0.5 is chance."


def of_pairs(run: Run) -> Iterator[Section]:
    """Yield the section of the pairs of partners."""
    if not run.has("pairs/pairs.csv"):
        return
    table = run.read("pairs/pairs.csv")
    names = [folder.split("/")[1] for folder in run.ending("book.png")]
    rows: list[list[Any]] = []
    for name in names[:MAX_ROWS]:
        files = file_cells(run, f"pairs/{name}", FILES_OF_PAIR)
        sides = list(table[table["complex"] == name].groupby("partner"))
        for k, (side, scores) in enumerate(sides):
            aucs = [auc_of(scores.set_index("score"), score, "auc") for score in SCORES]
            rows.append([name if k == 0 else "", str(side), *aucs, files if k == 0 else ""])
        if not sides:
            rows.append([name, "", "no interface", "", files])
    figures = []
    if table["complex"].nunique() > 1 and run.has("pairs/pairs.png"):
        figures.append(Figure("pairs/pairs.png", caption("pairs")))
    several = len(names) > 1
    for name in names[:MAX_SHOWN]:
        view = f"pairs/{name}/view.html"
        words = name if several else caption("book")
        figures.append(Figure(f"pairs/{name}/book.png", words, view if run.has(view) else "", several))
    columns = ["pair", "partner", "complementarity: AUC (95 %)", "protrusion: AUC (95 %)", "files"]
    text, files_of_all = [TEXT["pairs"], TEXT["auc"]], [("pairs/pairs.csv", "all scores")]
    yield Section(
        "Do matching shapes show the interface", text, figures, [Table(columns, rows)], files_of_all
    )


# Frames


def of_frames(run: Run) -> Iterator[Section]:
    """Yield a section for each protein whose frames were followed with one combination."""
    for protein in run.ending("ensemble.csv")[:MAX_SHOWN]:
        table = run.read(f"{protein}/ensemble.csv")
        measured = {"N": ("dots", 0), "area": ("area / Å²", 0), "mean_roughness": ("mean roughness", 3)}
        measured["n_S_percent"] = ("n_S / %", 1)
        for reading in readings_of_columns(table, "d_"):
            measured[f"d_{reading}"] = (f"d {READINGS[reading].words}", 2)
        rows: list[list[Any]] = []
        for column, (words, digits) in measured.items():
            values = table[column].agg(["mean", "std", "min", "max"])
            rows.append([words, *(number(x, digits) for x in values)])
        paths = {"ensemble": "ensemble.png", "residues_over_time": "residues.png"}
        drawn = [(name, f"{protein}/figures/{file}") for name, file in paths.items()]
        figures = [Figure(path, caption(name)) for name, path in drawn if run.has(path)]
        tables = [Table(["", "mean", "sd", "lowest", "highest"], rows)]
        files = links(run, protein, FILES_OVER_TIME)
        yield Section(f"{protein} over time", [TEXT["frames"].format(n=len(table))], figures, tables, files)


# Every surface


def of_surfaces(run: Run) -> Iterator[Section]:
    """Yield the table of all surfaces, and the figures of the first ones."""
    if not len(run.surfaces):
        return
    several = len(run.surfaces) > MAX_ANSWERS
    table = run.surfaces.sort_values("minimal_n_S_percent", kind="stable") if several else run.surfaces
    rows: list[list[Any]] = []
    for place, row in table.head(MAX_ROWS).iterrows():
        view, picture = f"{place}/view.html", f"{place}/view.png"
        values = [
            (row["N"], f"{row['N']:,}"),
            (row["area"], number(row["area"], 0)),
            (row["mean_roughness"], number(row["mean_roughness"])),
            (row["minimal_n_S"], f"{row['minimal_n_S']:,}"),
            (row["minimal_n_S_percent"], f"{share(row['minimal_n_S_percent'])} %"),
            (row["recovered_mean"], number(row["recovered_mean"], 3)),
            *((row[name], number(row[name])) for name in Z_OF_RECOVERED),
        ]
        name, cells = run.shown[str(place)], [Cell(text, key=str(value)) for value, text in values]
        first = Cell(name, picture=picture) if run.has(picture) else Cell("")
        files = file_cells(run, str(place), FILES_OF_SURFACE)
        rows.append([first, Cell(name, view if run.has(view) else ""), *cells, files])
    columns = ["", "surface", "dots", "area / Å²", "mean roughness", "minimal subset", "its share"]
    columns += ["mean error / Å", "Z", "Z, rotation-robust", "files"]
    figures = [Figure("compare.png", caption("compare"), small=True)] if run.has("compare.png") else []
    gallery = [*GALLERY, "required_dots"] if len(run.places) > 1 else GALLERY
    proteins = dict.fromkeys(place.split("/")[0] for place in run.places[:MAX_SHOWN])
    for folder in [*proteins, *run.places[:MAX_SHOWN]]:
        name = f"{run.shown.get(folder, folder)}: " if len(run.places) > 1 else ""
        paths = {figure: f"{folder}/figures/{figure}.png" for figure in gallery}
        figures += [
            Figure(path, name + caption(key), small=True) for key, path in paths.items() if run.has(path)
        ]
    tables = [Table(columns, rows, TEXT["surfaces"], several)]
    yield Section("Every surface", [], figures, tables, links(run, "", FILES_OF_ALL))


def of_files(run: Run) -> Iterator[Section]:
    """Yield the list of files of the first surface."""
    if run.places and (found := links(run, run.places[0], DOWNLOADS)):
        more = "; the other surfaces have theirs in their own folders" if len(run.places) > 1 else ""
        yield Section("Files", [f"Of {run.shown[run.places[0]]}{more}."], links=found)


# Thousands of structures


def sentence_of_batches(surfaces: pd.DataFrame) -> str:
    """Say how many surfaces there are, and how rough they are."""
    if surfaces.empty:
        return "No structure has a surface."
    kept = share(100 * surfaces["minimal_n_S"].sum() / surfaces["N"].sum())
    roughness = surfaces["mean_roughness"]
    atoms = span(surfaces["atoms"], "{:,.0f}".format)
    return (
        f"{len(surfaces):,} surfaces of molecules of {atoms} atoms: {kept} % of {surfaces['N'].sum():,} dots are kept;"
        f" the median of the mean roughness is {number(roughness.median())} ({span(roughness)})."
    )


def of_batches(batches: Mapping[str, Any]) -> Iterator[Section]:
    """Yield the distributions, the most unusual surfaces and the failures by reason."""
    surfaces, failures = batches["surfaces"], batches["failures"]
    n_failed = sum(len(names) for _, names in failures)
    if len(surfaces):
        n = f"{len(surfaces):,} surfaces of {len(surfaces) + n_failed:,} structures, in {batches['n_batches']} batches."
        models = surfaces[surfaces["masked_residues"].notna()]
        text, masked = [n], int(models["masked_residues"].sum())
        if len(models):
            total = masked + int(models["residues"].sum())
            text.append(TEXT["masked"].format(masked=masked, total=total, models=len(models)))
        yield Section("All surfaces", text, [Figure("distributions.png", caption("distributions"))])
        columns = ["structure", "deviation", "in", "atoms", "area / Å²", "volume / Å³", "mean roughness"]
        columns += ["components", "cavities"]
        form = {"deviation": "{:.1f}", "area": "{:.0f}", "volume": "{:.0f}", "mean_roughness": "{:.2f}"}
        rows: list[list[Any]] = []
        for row in batches["unusual"].to_dict("records"):
            measured = ("deviation", "atoms", "area", "volume", "mean_roughness", "components", "cavities")
            cells = [Cell(form.get(k, "{:,}").format(row[k]), key=str(row[k])) for k in measured]
            rows.append([row["protein"], cells[0], row["unusual"], *cells[1:]])
        files = [
            (f"{name}/", f"a Parquet file for each batch: {words}") for name, words in BATCH_TABLES.items()
        ]
        tables = [Table(columns, rows, TEXT["unusual"], sortable=True)]
        yield Section("The most unusual surfaces", [], [], tables, files)
    if failures:
        text = []
        for reason, names in failures:
            more = f" and {len(names) - MAX_SHOWN:,} more" if len(names) > MAX_SHOWN else ""
            text.append(f"{len(names):,}: {reason} ({', '.join(names[:MAX_SHOWN])}{more})")
        yield Section(f"{n_failed:,} structures failed", text, links=[("failures.csv", "all of them")])


def warned(path: Path, shown: Mapping[str, str] = MappingProxyType({})) -> list[tuple[list[str], str]]:
    """Read (places, sentence) from warnings.csv, if any; warnings that differ only in numbers are merged into the first."""
    if not path.is_file():
        return []
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    places = ["/".join(filter(None, place)) for place in table[NAMES].to_numpy().tolist()]
    merged: dict[str, tuple[str, list[str]]] = {}
    for place, sentence in dict.fromkeys(zip(places, table["sentence"], strict=True)):
        text = re.sub(r"^\S*/(?=\S+: )", "", sentence.removeprefix(f"{place}: "))
        names = "|".join(re.escape(name) for name in place.split("/"))
        kind = re.sub(rf"\b({names})\b|[0-9][0-9.,]*", "", text)
        merged.setdefault(kind, (text, []))[1].append(shown.get(place, place))
    return [(places_, text) for text, places_ in merged.values()]
