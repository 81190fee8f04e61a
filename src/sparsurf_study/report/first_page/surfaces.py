"""The surfaces on the first page: how many dots are enough, which residues are rough, and the table of all surfaces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from sparsurf.sampling.combination import Combination
from sparsurf.settings import BY_BACK, BY_FORTH, DECISIONS, DEFAULT_ERROR, TAIL_PER_ERROR
from sparsurf.views.numbers import number
from sparsurf.views.page.profile import columns_of_means, labels_of, panels, roughest
from sparsurf_study.report.first_page.run import MAX_CARDS, MAX_ROWS, MAX_SHOWN, Cell, Figure, Run, TableLink

Z_OF_RECOVERED = ("recovered_Z_published", "recovered_Z_rotation_robust")  # Columns of surfaces.csv.
DEFAULT_MINIMAL = {"error": DEFAULT_ERROR}  # the section `minimal` of a config


class SubsetRequest(NamedTuple):
    """What the config asks of the minimal subset: dots that are enough, or a number of dots."""

    is_enough: bool  # the subset has as few dots as this needs
    phrase: str  # how good it is, or the dots that it keeps


MODEL_SENTENCES = {
    "spheres": " The atoms are inferred from the dots, and the surface is rebuilt on them.",
    "interpolant": " The surface is interpolated between the dots.",
}


def requested_subset(minimal: Mapping[str, Any]) -> SubsetRequest:
    """Say what the section `minimal` of a config asks for."""
    phrases = {
        "error": (True, "with a mean error of at most {:g}\xa0Å"),
        "max_z": (True, "such that Z on the full surface is at most {:g}"),
        "percent": (False, "{:g}\xa0% of the dots"),
        "n_dots": (False, "{:,} dots"),
        "density": (False, "{:g} dots per Å²"),
        "combination": (False, "the dots that the combination {} keeps"),
    }
    key = next(key for key in phrases if key in minimal)
    is_enough, form = phrases[key]
    value = Combination(*minimal[key]) if key == "combination" else minimal[key]
    return SubsetRequest(is_enough, form.format(value))


def _of_all(run: Run, column: str) -> str:
    """Return the text in the first row of a column of recovered.csv, where it is the same for all surfaces, or nothing."""
    tables = [run.read(f"{place}/recovered.csv") for place in run.ending("recovered.csv")]
    texts = {table[column].iloc[0] for table in tables if column in table}
    return str(texts.pop()) if len(texts) == 1 else ""


def _decision(decided_by: str, minimal: Mapping[str, Any]) -> str:
    """Say which limit of the section `minimal` decides how many dots are enough; nothing where that differs."""
    if decided_by not in (BY_FORTH, BY_BACK):
        return DECISIONS.get(decided_by, "")
    error_99 = minimal.get("error_99", TAIL_PER_ERROR * minimal["error"])
    side = "true" if decided_by == BY_FORTH else "reconstructed"
    return (
        f"Besides, at most 1\xa0% of the {side} surface may deviate by more than {error_99:g}\xa0Å; this second limit decides "
        f"here, which is why the mean error is below {minimal['error']:g}\xa0Å."
    )


def of_dots(run: Run, minimal: Mapping[str, Any] = DEFAULT_MINIMAL) -> dict[str, Any] | None:
    """Collect how many dots are enough, as medians over the surfaces; None where the run has no surface."""
    if not len(run.surfaces):
        return None
    medians, n = run.surfaces.median(numeric_only=True), len(run.surfaces)
    own_figure, path = f"{run.places[0]}/figures/required_dots.png", "required_dots.png"
    path = own_figure if n == 1 and run.has(own_figure) else path
    return {
        "n_surfaces": n,
        "n_dots": int(run.surfaces["minimal_n_S"].iloc[0]),
        "N": int(medians["N"]),
        "percent": medians["minimal_n_S_percent"],
        "low": medians["minimal_n_S_percent_low"],
        "high": medians["minimal_n_S_percent_high"],
        "density": medians["minimal_density"],
        "mean": medians["recovered_mean"],
        "high_99": run.surfaces["recovered_high_99"].max(),
        "reconstruction": MODEL_SENTENCES.get(_of_all(run, "reconstruction"), ""),
        "decision": _decision(_of_all(run, "decided_by"), minimal),
        "largest": run.surfaces["recovered_largest"].max(),
        "files": _subset_files(run),
        "atoms": _surface_atoms(run),
        "figure": run.figure(path),
        "fields": [*_fields(run)],
    }


def _subset_files(run: Run) -> list[tuple[str, str]]:
    """Return names and paths of the subsets; of many surfaces, those of the table that describes them."""
    paths = {place: f"{place}/minimal.csv" for place in run.places if run.has(f"{place}/minimal.csv")}
    if len(paths) > MAX_CARDS:
        return [("surfaces.csv", "surfaces.csv")]
    if len(paths) == 1:
        return [("minimal.csv", path) for path in paths.values()]
    return [(f"{run.shown[place]}/minimal.csv", path) for place, path in paths.items()]


def _surface_atoms(run: Run) -> dict[str, Any] | None:
    """Return how many atoms determine the surfaces exactly, as medians, and their file; None for surfaces without atoms."""
    paths = {place: f"{place}/surface_atoms.csv" for place in run.places}
    numbers = pd.Series(
        {place: len(run.read(path)) for place, path in paths.items() if run.has(path)}, dtype=float
    )
    if not len(numbers):
        return None
    density = numbers / run.surfaces["area"].loc[numbers.index]
    path = paths[str(numbers.index[0])] if len(numbers) == 1 else ""
    return {"n": int(numbers.median()), "density": float(density.median()), "path": path}


def _fields(run: Run) -> Iterator[tuple[str, float]]:
    """Yield each field with the correlation between its values and those interpolated from the minimal subset."""
    if tables := [run.read(f"{place}/fields.csv") for place in run.ending("fields.csv")]:
        minimal = pd.concat(tables).query("subset == 'minimal'").dropna(subset=["r"])
        for name, r in minimal.groupby("field", sort=False)["r"].median().items():
            yield str(name), float(r)


def of_strip(run: Run) -> list[dict[str, Any]]:
    """Collect the pictures below the cards for each of the first surfaces, by what they show."""
    found = []
    for k, place in enumerate(run.places[:MAX_SHOWN]):
        pictures = {Path(picture.path).stem: picture for picture in run.figures(place, "strip")}
        row: Any = run.surfaces.loc[place] if len(run.surfaces) else {}
        view = f"{place}/view.html"
        found.append(
            {
                "k": k,
                "name": run.shown[place],
                "pictures": pictures,
                "view": view if run.has(view) else "",
                "mean_roughness": row.get("mean_roughness", np.nan),
                "n_dots": row.get("minimal_n_S", 0),
            }
        )
    return found


def of_residues(run: Run) -> list[dict[str, Any]]:
    """Collect the roughness of the residues of the first surfaces: the profile along each chain, and the roughest residues."""
    found = []
    for k, place in enumerate(run.places[:MAX_SHOWN]):
        path = f"{place}/residues.csv"
        if not run.has(path):
            continue
        table = run.read(path)
        rough = roughest(table)
        columns = columns_of_means(table)
        rows = []
        for label, row in zip(labels_of(rough), rough.to_dict("records"), strict=True):
            cells = [label, number(row["mean_roughness"]), number(row["area"], 0), f"{row['dots']:,.0f}"]
            rows.append(cells + [number(row[name]) for name in columns])
        found.append(
            {
                "k": k,
                "name": run.shown[place],
                "path": path,
                "panels": panels(table),
                "rough": rows,
                "means": [name.removeprefix("mean_").replace("_", " ") for name in columns],
            }
        )
    return [surface for surface in found if surface["panels"]]


def of_surfaces(run: Run) -> dict[str, Any] | None:
    """Collect the table of all surfaces, and the figures of the first ones."""
    if not len(run.surfaces):
        return None
    several = len(run.surfaces) > MAX_CARDS
    table = run.surfaces.sort_values("minimal_n_S_percent", kind="stable") if several else run.surfaces
    rows: list[list[Any]] = []
    for place, row in table.head(MAX_ROWS).iterrows():
        view, picture = f"{place}/view.html", f"{place}/view.png"
        values = [
            (row["N"], f"{row['N']:,}"),
            (row["area"], f"{row['area']:,.0f}"),
            (row["mean_roughness"], number(row["mean_roughness"])),
            (row["minimal_n_S"], f"{row['minimal_n_S']:,}"),
            (row["minimal_n_S_percent"], number(row["minimal_n_S_percent"], 1)),
            (row["recovered_mean"], number(row["recovered_mean"], 3)),
            *((row[name], number(row[name])) for name in Z_OF_RECOVERED),
        ]
        name, cells = run.shown[str(place)], [Cell(text, key=str(value)) for value, text in values]
        first = Cell(name, picture=picture) if run.has(picture) else Cell("")
        files = run.file_cells(str(place), "row")
        rows.append([first, Cell(name, view if run.has(view) else ""), *cells, files])
    columns = ["picture", "surface", "dots", "area (Å²)", "mean roughness", "minimal subset", "its share (%)"]
    columns += ["mean error (Å)", "Z", "Z, rotation-robust", "files"]
    figures: list[Figure] = []
    proteins = dict.fromkeys(place.split("/")[0] for place in run.places[:MAX_SHOWN])
    for folder in [*proteins, *run.places[:MAX_SHOWN]]:
        name = f"{run.shown.get(folder, folder)}: " if len(run.places) > 1 else ""
        figures += run.figures(folder, "gallery", name)
    shown = len(rows)
    return {
        "table": TableLink(columns, rows, several),
        "n_hidden": len(run.surfaces) - shown,
        "figures": figures,
        "links": run.links("", "surfaces"),
    }


def of_files(run: Run) -> dict[str, Any] | None:
    """Collect the files of the first surface."""
    if not run.places or not (found := run.links(run.places[0], "files")):
        return None
    return {"name": run.shown[run.places[0]], "several": len(run.places) > 1, "links": found}
