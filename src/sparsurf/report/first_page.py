"""First page of a run: what was studied, the answers as cards, the figure, the ranges, links."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pandas as pd

from sparsurf.pairs.changes import SHARE_ABOVE_FLOOR
from sparsurf.recovery.readings import RECOVERED, readings_of_columns
from sparsurf.report.numbers import (
    against_zero,
    combination,
    interval,
    number,
    share,
    short_names,
    span,
)
from sparsurf.report.page import embedded_figures
from sparsurf.report.pairs_section import pairs_in, pairs_section
from sparsurf.study.floors import FRESH

TEMPLATE = "first.html.j2"
Gallery = tuple[
    str, list[tuple[str, str]], list[tuple[str, str, str]]
]  # heading, (page, name), (page, picture, name)
Rows = list[tuple[str, str, str, list[str], list[str]]]  # of surfaces: place, page, picture, files, numbers
NAMES = ["protein", "conformation"]
WORTH = ("Z_tS", "Z_tR", "Z_mean_descriptor")  # of summary.csv, shown next to d
SCALES = {  # columns of surfaces.csv that tell what a Z means, the first that was measured
    "Z_frames_1_ps_apart": "Two frames of the simulation 1 ps apart",
    "Z_atoms_moved_0.3_Å": "Atoms moved at random by 0.3 Å",
}
MAX_WITH_PICTURES = 20  # surfaces, or pairs
TABLES_OF_ALL = ("surfaces", "summary", "relation")  # over all surfaces; the last two need a grid
FILES_OF_ROW = ("minimal.csv", "residues.csv")  # linked from the row of a surface
MAX_RANGE_TABLES = 3  # surfaces with a table of ranges
PAGES = ("ranges", "ensemble")  # linked from the heading of a surface or a protein
DOWNLOADS = {  # files of a surface and what they contain
    "minimal.csv": "the minimal subset: places, normals, weights",
    "minimal.ply": "the same for 3D programs",
    "surface.ply": "the whole surface with its roughness",
    "residues.csv": "area, roughness and fields of each residue",
    "structure_roughness.pdb": "the structure, roughness as B factors",
    "open.pml": "opens all of this in PyMOL",
    "open.cxc": "opens all of this in ChimeraX",
    "ranges.csv": "the best combination per range of n_S",
    "grid.csv": "Z and d of every combination",
    "floors.csv": "the noise floors",
    "required_dots.csv": "how many dots reach each floor",
    "fields.csv": "how well few dots recover each field",
}


def first_page(
    folder: Path,
    paths: Iterable[str],
    exclude: Sequence[tuple[str, str]] = (),
    floor: str | None = FRESH,
) -> dict[str, Any]:
    """Collect the values of the page of a run.

    The page may read and link `paths`, from `folder`. `exclude` lists what was not finished: protein, pairs/<name> or
    changes/<name>, and the reason. `floor` sets the size of the minimal subset; None if the config sets it otherwise.
    """
    folder, files = Path(folder), dict.fromkeys(paths)
    names = [
        tuple(path.split("/")[:2])
        for path in files
        if path.count("/") == 2 and path.endswith("/required_dots.csv")
    ]
    first = "/".join(names[0]) if names else ""
    surfaces = of_surfaces(folder, files, names, floor) if names else None
    in_rows = {page for _, page, *_ in surfaces["rows"]} if surfaces else set()
    main = main_figure(folder, files, first)
    known = {
        "run": folder.name,
        "without": list(exclude),
        "warnings": warned(folder / "warnings.csv", short_names(names)),
        "surfaces": surfaces,
        "summary_page": "summary.html" in files,
        "fields": of_fields([read(folder, path) for path in files if path.endswith("/fields.csv")]),
        "paper": of_paper(read(folder, "paper_places.csv")) if "paper_places.csv" in files else None,
        "pairs": pairs_section(read(folder, "pairs/pairs.csv"), files)
        if "pairs/pairs.csv" in files
        else None,
        "changes": [
            (path.split("/")[1], of_changes(read(folder, path)))
            for path in files
            if path.endswith("/changes.csv")
        ],
        "ensembles": [
            (path.split("/")[0], of_ensemble(read(folder, path.replace(".html", ".csv"))))
            for path in files
            if path.endswith("/ensemble.html")
        ],
        "main_figure": main,
        "galleries": galleries(names, [path for path in files if path not in in_rows])
        + pair_galleries(files, main["path"] if main else "")
        + changes_galleries(files),
        "taken_from": short_names(names).get(first, first),
        "taken": [
            (f"{first}/{name}", words) for name, words in DOWNLOADS.items() if f"{first}/{name}" in files
        ]
        if len({protein for protein, _ in names}) == 1
        else [],
    }
    figures = [path for path in figures_of(known) if path]
    images = embedded_figures(folder, figures)
    return known | {"images": images, "n_outside": len({*figures} - images.keys())}


def figures_of(known: dict[str, Any]) -> Iterator[str]:
    """Yield the figures that the page shows, in order."""
    if known["main_figure"]:
        yield known["main_figure"]["path"]
    for _, _, picture, *_ in known["surfaces"]["rows"] if known["surfaces"] else []:
        yield picture
    for _, _, items in known["galleries"]:
        yield from (picture for _, picture, _ in items)


def read(folder: Path, path: str) -> pd.DataFrame:
    """Read a table of the run; names remain strings, "012", "1E96" and "NA" too."""
    names = dict.fromkeys([*NAMES, "complex", "bound"], str)
    table = pd.read_csv(folder / path, dtype=names, keep_default_na=False, na_values=[""])
    return table.fillna({"bound": ""})


def of_surfaces(
    folder: Path, files: Iterable[str], names: list[tuple[str, ...]], floor: str | None
) -> dict[str, Any]:
    """Collect the values of the surfaces `names`: `numbers` of the sampled ones, and a row for each other, see `rows_of`."""
    tables = {name: read(folder, f"{name}.csv") for name in TABLES_OF_ALL if f"{name}.csv" in files}
    surfaces = tables.pop("surfaces").set_index(NAMES).loc[names].reset_index()
    sampled = surfaces.iloc[:0]
    if tables:
        summary = tables["summary"].set_index(NAMES)
        sampled = surfaces[surfaces.set_index(NAMES).index.isin(summary.index)]
        tables["summary"] = summary.loc[[*sampled[NAMES].itertuples(index=False)]].reset_index()
    required_dots = pd.concat([read(folder, f"{'/'.join(place)}/required_dots.csv") for place in names])
    known = {
        "proteins": surfaces["protein"].drop_duplicates().tolist(),
        "dots": span(surfaces["N"], "{:,.0f}".format),
        "roughness": span(surfaces["mean_roughness"]),
        "n_surfaces": len(surfaces),
        "sampled": sampled["protein"].drop_duplicates().tolist(),
        "n_sampled": len(sampled),
        "scale": scale_of_z(surfaces),
        "two_patches": two_patches(folder, files, names),
        "required_dots": required_dots_card(surfaces, required_dots, floor),
        "recovered": recovered_card(surfaces),
        "d": [],
        "rows": rows_of(surfaces.drop(sampled.index), files),
    }
    return known | (numbers(sampled, **tables) if tables else {})


def rows_of_surfaces(folder: Path, files: list[str]) -> Rows:
    """Format the rows of surfaces.csv, if it is one of the files of a run; see `rows_of`."""
    return rows_of(read(folder, "surfaces.csv"), files) if "surfaces.csv" in files else []


def rows_of(surfaces: pd.DataFrame, files: Iterable[str]) -> Rows:
    """Format a row per surface: its name, its page, the picture of that, files, and its numbers.

    The share of the minimal subset has its 95 % interval if an error or a floor sets its size.
    """
    ends = [f"minimal_n_S_percent_{end}" for end in ("low", "high")]
    rows, shown = [], short_names(surfaces[NAMES].itertuples(index=False))
    for row in surfaces.to_dict("records"):
        start = f"{row['protein']}/{row['conformation']}/"
        page, picture, *taken = (f"{start}{name}" for name in ("view.html", "view.png", *FILES_OF_ROW))
        cells = [f"{row['N']:,}", number(row["area"], 0), number(row["mean_roughness"])]
        low, high = (row.get(end, math.nan) for end in ends)
        limits = "" if math.isnan(low) else f" ({share(low)} to {share(high)})"
        cells += [f"{row['minimal_n_S']:,}", share(row["minimal_n_S_percent"]) + limits]
        taken = [path for path in taken if path in files]
        rows.append((shown[start[:-1]], page, picture if picture in files else "", taken, cells))
    return rows


def main_figure(folder: Path, files: Iterable[str], first: str) -> dict[str, str] | None:
    """Choose the main figure: that over all surfaces, else that of the first, else that of the pairs."""
    paths = ["required_dots.png", f"{first}/figures/required_dots.png", f"{first}/figures/d_over_grid.png"]
    if pairs := pairs_in(files):
        several = read(folder, "pairs/pairs.csv")["complex"].nunique() > 1  # that touch
        paths.append("pairs/pairs.png" if several else f"pairs/{pairs[0]}/book.png")
    path = next((path for path in paths if path in files), None)
    return {"path": path, "name": Path(path).stem} if path else None


def numbers(surfaces: pd.DataFrame, summary: pd.DataFrame, relation: pd.DataFrame) -> dict[str, Any]:
    """Collect the values of the grids from surfaces.csv, summary.csv and relation.csv."""
    readings = readings_of_columns(surfaces, "best_")
    names = surfaces[NAMES].drop_duplicates().to_numpy().tolist()
    shown = short_names(names)
    return {
        "d": [d_card(summary, reading, readings[0]) for reading in readings],
        "readings": readings,
        "ranges": [
            (shown["/".join(name)], ranges_rows(summary[(summary[NAMES] == name).all(axis=1)], readings))
            for name in names[:MAX_RANGE_TABLES]
        ],
        "over_all": over_all(summary, relation, readings) if len(names) > 1 else [],
    }


def required_dots_card(
    surfaces: pd.DataFrame, required_dots: pd.DataFrame, floor: str | None
) -> dict[str, Any] | None:
    """Collect the share of the dots from which the surface is recovered within a floor; None if that was not measured.

    If no floor sets the minimal subsets, `handed_out` is their share, and the card reports how many dots reach the floor of
    fresh dots.
    """
    rows = required_dots[
        (required_dots["floor"] == (floor or FRESH)) & (required_dots["reading"] == RECOVERED)
    ]
    if rows.empty:
        return None
    minimal = surfaces.get("minimal_n_S_percent")
    percents, bounds = rows["n_S_percent"], set(rows.get("bound", ()))
    return {
        "bound": bounds.pop() if len(bounds) == 1 else "",
        "percent": share(percents.median()),
        "span": span(percents, share),
        "interval": answer_interval(rows),
        "floor": floor or FRESH,
        "handed_out": "" if floor or minimal is None else share(minimal.median()),
        "sampler": rows["sampler"].iloc[0],
        "every_dot": bool((percents >= 100).all()),
    }


def recovered_card(surfaces: pd.DataFrame) -> dict[str, str] | None:
    """Collect the size of the minimal subset and the errors of the surface recovered from it, medians over the surfaces."""
    if "recovered_mean" not in surfaces or surfaces["recovered_mean"].isna().all():
        return None
    low, high = surfaces["minimal_n_S_percent_low"].min(), surfaces["minimal_n_S_percent_high"].max()
    median = surfaces.median(numeric_only=True)
    return {
        "percent": share(median["minimal_n_S_percent"]),
        "interval": "" if math.isnan(low) else f"{number(low, 1)} to {number(high, 1)}",
        "density": number(median["minimal_density"]),
        "mean": number(median["recovered_mean"], 3),
        "high_99": number(median["recovered_high_99"]),
        "largest": number(surfaces["recovered_largest"].max()),
        "Z": number(median["recovered_Z_published"]),
        "Z_robust": number(median["recovered_Z_rotation_robust"]),
    }


def answer_interval(rows: pd.DataFrame) -> str:
    """Format the 95 % interval of the share of dots that are enough; of several surfaces the widest limits."""
    if "n_S_percent_low" not in rows or rows["n_S_percent_low"].isna().all():
        return ""
    return f"{share(rows['n_S_percent_low'].min())} to {share(rows['n_S_percent_high'].max())}"


def scale_of_z(surfaces: pd.DataFrame) -> dict[str, str] | None:
    """Return the size of a Z by something physical: its words and its median Z; None if no such floor was measured."""
    for column, words in SCALES.items():
        if column in surfaces and surfaces[column].notna().any():
            return {"words": words, "Z": number(surfaces[column].median(), 1)}
    return None


def two_patches(folder: Path, files: Iterable[str], names: list[tuple[str, ...]]) -> str:
    """Format the median Z of two different patches of a surface; empty without a grid."""
    paths = [path for name in names if (path := f"{'/'.join(name)}/best.json") in files]
    known = [json.loads((folder / path).read_text(encoding="utf-8")) for path in paths]
    values = [best["references"]["Z_two_patches"] for best in known]
    return number(pd.Series(values).median(), 1) if values else ""


def d_card(summary: pd.DataFrame, reading: str, first: str) -> dict[str, Any]:
    """Collect d of the best combination, in the range of n_S in which d under the reading `first` is largest."""
    best = summary[(summary["reading"] == first) & summary["d_cv"].notna()]
    best = best.loc[best.groupby(NAMES)["d_cv"].idxmax().to_list(), [*NAMES, "range"]]
    rows = summary[summary["reading"] == reading].merge(best, on=[*NAMES, "range"])
    rows = rows.dropna(subset=["d_cv"])
    if rows.empty:
        return {"reading": reading, "d": None}
    places = [against_zero(*ends) for ends in rows[["d_cv_low", "d_cv_high"]].to_numpy()]
    return {
        "reading": reading,
        "d": number(rows["d_cv"].median()),
        "n_S": share(rows["n_S_percent"].median()),
        "n": len(rows),
        "interval": limits(rows),
        "worth": {name: number(rows[name].median(), 1) for name in WORTH}
        if rows.columns.isin(WORTH).sum() == len(WORTH)
        else None,
        "places": {name: places.count(name) for name in ("above", "below", "around", "unknown")},
    }


def limits(rows: pd.DataFrame) -> str:
    """Format the 95 % interval of d; of several surfaces the widest limits; empty if unknown."""
    low, high = rows["d_cv_low"].min(), rows["d_cv_high"].max()
    return "" if math.isnan(low) else f"{number(low)} to {number(high)}"


def ranges_rows(summary: pd.DataFrame, readings: list[str]) -> list[list[str]]:
    """Format a row per range of one surface: n_S, then combination and d with its interval by reading."""
    rows = []
    for _, of_range in summary.groupby("range"):
        by = of_range.set_index("reading")
        row = [f"{number(by['n_S_low_percent'].iloc[0], 0)} – {number(by['n_S_high_percent'].iloc[0], 0)}"]
        for reading in readings:
            best: Any = by.loc[reading]
            row += [combination(best), interval(*best[["d_cv", "d_cv_low", "d_cv_high"]])]
        rows.append(row)
    return rows


def over_all(summary: pd.DataFrame, relation: pd.DataFrame, readings: list[str]) -> list[list[str]]:
    """Format a row per range over several surfaces: the combination that is best on average, median d (lowest to highest)."""
    rows = []
    for k, of_range in relation.groupby("range"):
        by = of_range.set_index("reading")
        row = [f"{number(by['n_S_low_percent'].iloc[0], 0)} – {number(by['n_S_high_percent'].iloc[0], 0)}"]
        for reading in readings:
            d = summary[(summary["reading"] == reading) & (summary["range"] == k)]["d_cv"].dropna()
            d_text = interval(d.median(), d.min(), d.max()) if len(d) else ""
            best: Any = by.loc[reading]
            row += [combination(best), d_text]
        rows.append(row)
    return rows


def of_fields(tables: list[pd.DataFrame]) -> list[tuple[str, str]]:
    """List how well the minimal subset recovers each field, the median over surfaces: (field, r)."""
    if not tables:
        return []
    minimal = pd.concat(tables).query("subset == 'minimal'").dropna(subset=["r"])
    medians = minimal.groupby("field", sort=False)["r"].median()
    return [(str(name), number(r, 3)) for name, r in medians.items()]


def of_paper(places: pd.DataFrame) -> dict[str, int]:
    """Count the rows of Table I whose published d and Z lie within 95 % of the runs made as published."""
    inside = {name: int(places[f"{name}_inside"].sum()) for name in ("d", "Z_tS")}
    return inside | {"rows": len(places), "runs": int(places["n_runs"].max())}


def of_changes(table: pd.DataFrame) -> dict[str, int]:
    """Count the residues that change from one form to another by more than moved atoms do, and how many would by chance."""
    n = int(table["total"].count())
    return {"n": int(table["above_moved"].sum()), "residues": n, "chance": round(SHARE_ABOVE_FLOOR * n)}


def of_ensemble(table: pd.DataFrame) -> dict[str, Any]:
    """Collect d of one combination over the frames of a trajectory, under the first reading of the table."""
    reading = readings_of_columns(table, "d_")[0]
    d = table[f"d_{reading}"].dropna()
    sd = number(d.std(ddof=1), 1)
    return {"frames": len(table), "reading": reading, "d": number(d.mean(), 1), "sd": sd}


def galleries(surfaces: list[tuple[str, ...]], files: Iterable[str]) -> list[Gallery]:
    """Collect the pictures of each protein and each surface, the first ones of many; `files` are those that the page may link."""
    shown = short_names(surfaces)
    all_galleries: list[Gallery] = []
    if len(surfaces) > 1 and "compare.png" in files:
        compared = [("compare.png", "compare.png", "compare")]
        all_galleries.append(("All surfaces", [("compare.csv", "compare")], compared))
    for protein in list(dict.fromkeys(protein for protein, _ in surfaces))[:MAX_WITH_PICTURES]:
        folders = [f"{p}/{c}/" for p, c in surfaces[:MAX_WITH_PICTURES] if p == protein]
        for start in [f"{protein}/", *folders]:
            view = f"{start}view.html"
            picture = f"{start}view.png"
            items = [(view, picture if picture in files else "", "view")] * (view in files)
            items += [(path, path, name) for path, name in pictures(start, files)]
            linked = [(f"{start}{name}.html", name) for name in PAGES if f"{start}{name}.html" in files]
            all_galleries.append((shown.get(start[:-1], start[:-1]), linked, items))
    return [gallery for gallery in all_galleries if gallery[2]]


def pictures(start: str, pages: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield the figures directly below the folder `start`, with their names."""
    begin = f"{start}figures/"
    for path in pages:
        name = path.removeprefix(begin).removesuffix(".png")
        if path == f"{begin}{name}.png" and "/" not in name:
            yield path, name


def pair_galleries(files: Iterable[str], main: str) -> list[Gallery]:
    """Collect the pictures of pairs, as `galleries` does, without the main figure."""
    all_galleries: list[Gallery] = []
    for name in pairs_in(files)[:MAX_WITH_PICTURES]:
        picture, page = f"pairs/{name}/book.png", f"pairs/{name}/view.html"
        items = [(picture, picture, "book"), (page, "", "partners")]
        all_galleries.append((name, [], [item for item in items if item[0] in files and item[0] != main]))
    return [gallery for gallery in all_galleries if gallery[2]]


def changes_galleries(files: Iterable[str]) -> list[Gallery]:
    """Collect the pictures of forms that were compared, as `galleries` does."""
    all_galleries: list[Gallery] = []
    for path in files:
        folder, _, file = path.rpartition("/")
        if folder.startswith("changes/") and file == "changes.html":
            items = [(f"{folder}/changes.png", f"{folder}/changes.png", "changes")]
            items += [(f"{folder}/view_{side}.html", "", f"view_{side}") for side in (1, 2)]
            shown = [item for item in items if item[0] in files]
            all_galleries.append((folder.split("/")[1], [(path, "changes")], shown))
    return all_galleries[:MAX_WITH_PICTURES]


def warned(path: Path, shown: Mapping[str, str] = MappingProxyType({})) -> list[tuple[list[str], str]]:
    """Read (places, sentence) from the warnings.csv of a run; warnings that differ only in numbers are merged into the first.

    A file is named without its folder, a place by its name in `shown`. Empty if there is no such table.
    """
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
