"""Render the page of one surface: the template holds the sentences, and these functions supply the numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd

from sparsurf.dot_fields.named_fields import label_and_unit
from sparsurf.evaluation.ranking import MIN_AREA
from sparsurf.surfaces.components import COMPONENT_FIELD
from sparsurf.version import __version__
from sparsurf.views.numbers import number
from sparsurf.views.page.profile import PROFILE_CSS, columns_of_means, labels_of, panels, roughest
from sparsurf.views.viewer import library
from sparsurf.views.viewer.scene import (
    MAX_BYTES,
    MAX_BYTES_IN_REPORT,
    DotValues,
    PageScene,
    ResidueValues,
    script_of_page,
)

if TYPE_CHECKING:
    import jinja2


PAGE, DOTS = "page.html.j2", "base.html.j2"
FOLDERS = Path(__file__).parent, Path(library.__file__).parent
MAX_PROFILED = 8_000  # Residues beyond these have no profile, so that a page stays small.
MAX_PAIRS = 12  # The table of contacts lists at most so many pairs of partners.
N_OPEN = 8  # chains whose profile is not folded


@dataclass(frozen=True)
class Notes:
    """What reading a molecule said of it.

    Attributes
    ----------
    left_out : numbers and names of the residues of the file that are not part of the molecule; None where it was not read
    sentences : what else was noticed, one full sentence each
    """

    left_out: Sequence[str] | None = None
    sentences: Sequence[str] = ()


class Extent(NamedTuple):
    """How much of a surface the dots of a page are."""

    area: float = np.nan  # Å^2; NaN where it is not known, or is that of a selection
    walls: float = 0.0  # Å^2, of it on the walls of cavities
    is_known: bool = False  # whether these dots stand for a whole surface
    selected_of: int = 0  # number of dots of the whole, if they are a selection
    cavities_are_removed: bool = False
    volume: str = ""  # exact, with the handles, of a whole surface on atoms


class Facts(NamedTuple):
    """What a page says of its surface.

    Attributes
    ----------
    subset : number of dots of a subset; dots : of the surface
    extent : how much of a surface the dots are
    mean : roughness, NaN where it is not known
    reconstructed_from : number of dots that the surface was reconstructed from, 0 if it was not
    chosen_from : number of dots of a large surface of which the page shows these, 0 if it shows all
    why : why there is no roughness, or where it is from
    r_patch, d_link, probe : Å
    """

    subset: int
    dots: int
    extent: Extent
    mean: float
    reconstructed_from: int
    chosen_from: int
    why: str
    r_patch: float
    d_link: float
    probe: float | None


def render_page(
    title: str,
    scene: PageScene,
    surface: Facts,
    residues: pd.DataFrame | None = None,
    *,
    max_bytes: int = MAX_BYTES,
    notes: Notes = Notes(),
    missing: Sequence[str] = (),
    counts: str = "",
    links: Sequence[tuple[str, str]] = (),
    origin: Sequence[tuple[str, str]] = (),
    answer: str = "",
) -> str:
    """Render the page of a surface, in one file of at most `max_bytes`.

    `residues` is the table of `evaluation.residues`, `missing` names fields without a value, `counts` tells how large the
    molecule is, `links` are addresses and words of other pages on the surface, `origin` says in pairs where the page is from, and
    `answer` is what the page begins with.
    """
    context = {
        "title": title, "surface": surface, 
        "fields": [_range(field) for field in scene.values if field.symbol != COMPONENT_FIELD],
        "notes": notes.sentences, "missing": missing,
        "left_out": notes.left_out, "counts": counts, "links": links, "origin": origin,
        "answer": answer,
    }  # fmt: skip
    context |= residue_words(residues) | largest_contacts(scene)
    return scene.around(lambda data: render_template(PAGE, data=data, **context), max_bytes)


def render_page_of_dots(
    title: str,
    scene: PageScene,
    answer: str,
    links: Sequence[tuple[str, str]],
    origin: Sequence[tuple[str, str]],
) -> str:
    """Render the page of dots that are sampled and picked, without the tables of residues, for a report."""
    context = {"title": title, "answer": answer, "links": links, "origin": origin}
    return scene.around(lambda data: render_template(DOTS, data=data, **context), MAX_BYTES_IN_REPORT)


def largest_contacts(scene: PageScene) -> dict[str, Any]:
    """Return `pairs` of partners, the area that the second one buries of the first, Å^2, and the number of residues.

    Where several partners touch one, a row of `together` says what they bury of it together.
    """
    if scene.contacts is None:
        return {"pairs": [], "together": []}
    pairs = scene.contacts.groupby(["own", "partner"], sort=False)["mean"].agg(["sum", "size"])
    together = scene.contacts.drop_duplicates("number").groupby("own")["together"].agg(["sum", "size"])
    together = together[pairs.groupby("own").size() > 1]
    together.index = pd.MultiIndex.from_product([together.index, ["all partners"]])
    return {"pairs": _largest(pairs), "together": _largest(together)}


def _largest(contacts: pd.DataFrame) -> list[tuple[Any, ...]]:
    """Return the names and the numbers of the largest contacts."""
    rows = contacts.sort_values("sum", ascending=False, kind="stable").head(MAX_PAIRS)
    return [(*names, *row) for names, row in zip(rows.index, rows.to_numpy(), strict=True)]


def in_list(residues: pd.DataFrame) -> tuple[list[int], int]:
    """Return the positions of residues in the order of the list of a page, and how many of them are ranked."""
    ranked = roughest(residues, n=None).index
    return [*ranked, *residues.index.difference(ranked)], len(ranked)


def numbers_of_residues(residues: pd.DataFrame) -> Iterator[ResidueValues]:
    """Yield the numbers of residues that the page shows, first that of the list, from the table of `evaluation.residues`."""
    rough = residues["mean_roughness"].to_numpy(float)[None]
    yield ResidueValues("mean roughness", "", rough, 2, "rough", "flat", "mean_roughness")
    area = residues["area"].to_numpy(float)[None]
    yield ResidueValues("area", "Å²", np.where(area > 0, area, np.nan), 0)
    for column in columns_of_means(residues):
        field = named_field(column.removeprefix("mean_"))
        yield ResidueValues(f"mean {field['name']}", field["unit"], residues[column].to_numpy(float)[None])


def render_residues(title: str, residues: pd.DataFrame, origin: Sequence[tuple[str, str]]) -> str:
    """Render a page of residues alone: their profile, the roughest, and where the page is from."""
    return render_template(PAGE, title=title, has_picture=False, origin=origin, **residue_words(residues))


def residue_words(residues: pd.DataFrame | None) -> dict[str, Any]:
    """Return what the template needs of the residues."""
    if residues is None:
        return {"table": None, "panels": [], "rough": [], "means": []}
    columns = columns_of_means(residues)
    rough = roughest(residues)
    rows = [row | {"means": [row[name] for name in columns]} for row in labelled_rows(rough)]
    means = [named_field(str(name).removeprefix("mean_")) for name in columns]
    return {
        "table": True, "panels": panels(residues.head(MAX_PROFILED)), "rough": rows, "means": means, "min_area": MIN_AREA,
        "n_unprofiled": len(residues) - MAX_PROFILED,
    }  # fmt: skip


def labelled_rows(residues: pd.DataFrame) -> Iterator[dict[Any, Any]]:
    """Yield the rows of a table of residues, with the `label` of each and `residue`, its number on the page."""
    for label, position, row in zip(
        labels_of(residues), residues.index, residues.to_dict("records"), strict=True
    ):
        yield row | {"label": label, "residue": position}


def named_field(name: str) -> dict[str, str]:
    """Return the name of a field for people, and its unit."""
    label, unit = label_and_unit(name)
    return {"name": label, "unit": unit.replace("^2", "²")}


def _range(values: DotValues) -> dict[str, Any]:
    """Return the name, the ends, the mean and the unit of some values."""
    finite = values.values[np.isfinite(values.values)]
    low, mean, high = (finite.min(), finite.mean(), finite.max()) if len(finite) else (np.nan,) * 3
    return {"name": values.name, "unit": values.unit.strip(), "low": low, "mean": mean, "high": high}


def render_template(template: str, **context: Any) -> str:
    """Render a template of this folder."""
    from markupsafe import Markup

    drawn_by = {
        "version": library.VERSION, "notice": Markup(library.notice()),
        "packed": library.packed_library(), "script": Markup(script_of_page()),
    }  # fmt: skip
    sheets = FOLDERS[1] / "page.css", FOLDERS[0] / PROFILE_CSS
    style = Markup("".join(sheet.read_text(encoding="utf-8") for sheet in sheets))
    shared = {
        "version": __version__, "style": style, "library": drawn_by, "n_open": N_OPEN, "data": "", "has_picture": True,
        "surface": None, "pairs": (), "fields": (), "notes": (), "missing": (), "left_out": None, "counts": "",
        "links": (),
    }  # fmt: skip
    text = _templates().get_template(template).render(shared | context)
    return "\n".join(line for line in text.lstrip().splitlines() if line.strip()) + "\n"


@cache
def _templates() -> jinja2.Environment:
    """Return the environment of the templates."""
    import jinja2  # here: only pages need it

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDERS),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = number
    return environment
