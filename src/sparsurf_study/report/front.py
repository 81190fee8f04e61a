"""The first page of a run: the modules of `first_page` supply values, and the templates say them.

To show something more, collect its values in a module of `first_page`, name it in `values_of_front`, and write a template in
templates/first_page that front.html.j2 includes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pandas as pd

from sparsurf.evaluation.ranking import MIN_AREA
from sparsurf.version import __version__
from sparsurf_study.paper.verdict import count_inside, is_one_more_run, said_of_grid, why_undecided
from sparsurf_study.report.first_page.batches import of_batches
from sparsurf_study.report.first_page.frames import of_frames, of_simulations
from sparsurf_study.report.first_page.grid import of_grid
from sparsurf_study.report.first_page.pairs import of_changes, of_pairs
from sparsurf_study.report.first_page.run import (
    MAX_CARDS,
    MAX_ROWS,
    MAX_SHOWN,
    NAMES,
    Cell,
    Figure,
    Run,
    TableLink,
)
from sparsurf_study.report.first_page.surfaces import (
    DEFAULT_MINIMAL,
    of_dots,
    of_files,
    of_residues,
    of_strip,
    of_surfaces,
    requested_subset,
)
from sparsurf_study.report.page import DEFAULT_LENGTHS, embedded_figures, render, write_rendered
from sparsurf_study.report.provenance import UNKNOWN_ORIGIN, RunOrigin, provenance

__all__ = ["MAX_ROWS", "MAX_SHOWN", "warned", "write_front"]

FRONT_TEMPLATE = "front.html.j2"
ANSWERS = "answers.txt.j2"
MAX_PROTEINS = 6  # The heading names at most so many proteins.
PAPER_FOLDER = "data/tdp43/"  # The page of the paper's protein begins with the paper's question.


def write_front(
    page: Path | str,
    files: Iterable[str],
    exclude: Mapping[str, str],
    batches: Mapping[str, Any] | None = None,
    lengths: Mapping[str, float] = DEFAULT_LENGTHS,
    broken: Sequence[tuple[str, str]] = (),
    origin: RunOrigin = UNKNOWN_ORIGIN,
    minimal: Mapping[str, Any] = DEFAULT_MINIMAL,
    folder: Path | None = None,
) -> list[str]:
    """Write the first page of a run in the folder of its `files`, and return its answers, which the terminal prints.

    `exclude` has reasons for parts that are left out, and `broken` files that contradict others, with a sentence for each.
    `minimal` is that section of the config. `folder` is that of the run, by default that of the page, where warnings.csv lies.
    """
    run = Run(folder or Path(page).parent, list(dict.fromkeys(files)))
    values = values_of_front(run, batches, minimal)
    figures = [*dict.fromkeys(figures_in(values))]
    images = embedded_figures(run.folder, figures, Path(page).parent)
    write_rendered(
        page,
        FRONT_TEMPLATE,
        lengths,
        **values,
        is_own=values["paper"] is None and not any(PAPER_FOLDER in path for path in origin.inputs),
        without=list(exclude.items()),
        broken=broken,
        warnings=warned(Path(page).with_name("warnings.csv"), run.shown),
        images=images,
        n_outside=len({*figures} - images.keys()),
        provenance=provenance(origin),
        version=__version__,
    )
    return [line for line in render(ANSWERS, lengths, **values).splitlines() if line]


def values_of_front(
    run: Run, batches: Mapping[str, Any] | None, minimal: Mapping[str, Any]
) -> dict[str, Any]:
    """Collect what the page and the terminal say of a run; None or nothing for what the run does not have."""
    grid, changes, pairs = of_grid(run), of_changes(run), of_pairs(run)
    proteins = list(dict.fromkeys(place.split("/")[0] for place in run.grids or run.places))
    # A run on two forms or partners does not ask how few dots are enough
    few = bool(grid) or not (changes or pairs)
    return {
        "run_name": run.folder.name,
        "proteins": proteins if len(proteins) <= MAX_PROTEINS else [],
        "n_proteins": len(proteins),
        "n_surfaces": len(run.places),
        "several": few and not batches and len(run.places) > 1,
        "batches": of_batches(batches),
        "paper": of_paper(run),
        "grid": grid,
        "dots": of_dots(run, minimal) if few else None,
        "request": requested_subset(minimal),
        "changes": changes,
        "pairs": pairs,
        "frames": of_frames(run),
        "simulations": of_simulations(run),
        "compare": run.figure("compare.png"),
        "strip": of_strip(run) if few and not batches else [],
        "residues": of_residues(run) if few and not batches else [],
        "surfaces": of_surfaces(run),
        "files": of_files(run),
        "max_cards": MAX_CARDS,
        "min_residue_area": MIN_AREA,
    }


def of_paper(run: Run) -> dict[str, Any] | None:
    """Collect whether Table I is reproduced; None where the run was not compared with the paper."""
    if not run.has("paper_places.csv"):
        return None
    places, tests = run.read("paper_places.csv"), run.read("paper_tests.csv")
    grid = run.read(run.ending("grid.csv")[0] + "/grid.csv")  # the same for all surfaces
    return {
        "n_runs": int(places["n_runs"].max()),
        "inside": count_inside(places),
        "undecided": why_undecided(places, said_of_grid(grid)),
        "reproduced": is_one_more_run(tests),
        "page": "verdict.html" if run.has("verdict.html") else "",
        "figure": run.figure("table1.png"),
    }


def figures_in(value: Any) -> Iterator[str]:
    """Yield the paths of all pictures in some values, in their order."""
    if isinstance(value, Figure):
        yield value.path
    elif isinstance(value, Cell):
        if value.picture:
            yield value.picture
    elif isinstance(value, TableLink):
        yield from figures_in(value.rows)
    elif isinstance(value, Mapping):
        yield from figures_in(list(value.values()))
    elif isinstance(value, list | tuple):
        for part in value:
            yield from figures_in(part)


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
