"""Render the page of one surface: the template holds the sentences, and these functions supply the numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd

from sparsurf.dot_fields.registry import label_and_unit
from sparsurf.evaluation.ranking import MIN_AREA
from sparsurf.surfaces.components import COMPONENT_FIELD
from sparsurf.surfaces.formats.ply import ROUGHNESS_LIMITS
from sparsurf.version import __version__
from sparsurf.views import explorer
from sparsurf.views.explorer.page import (
    MAX_EXPLORER_BYTES,
    DotsBelow,
    ResidueValues,
    around_molecule,
    explorer_script,
    explorer_style,
)
from sparsurf.views.explorer.shapes import Shape
from sparsurf.views.numbers import number
from sparsurf.views.overview.profile import PROFILE_CSS, labels_of, panels, roughest
from sparsurf.views.render import along_smallest_axis
from sparsurf.views.viewer import page as viewer

if TYPE_CHECKING:
    import jinja2

    from sparsurf.evaluation.prepared_surface import PreparedSurface
    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.mesh import Mesh

PAGE = "page.html.j2"
MAX_LARGE_BYTES = 4_000_000  # of the page of a large surface, which stays smooth to turn
N_OPEN = 8  # chains whose profile is not folded


@dataclass(frozen=True)
class Notes:
    """What reading a molecule said of it.

    Attributes
    ----------
    left_out : numbers and names of the residues of the file that are not part of the molecule; None where it was not read
    sentences : what else was noticed, one full sentence each
    """

    left_out: tuple[str, ...] | None = None
    sentences: tuple[str, ...] = ()


class Extent(NamedTuple):
    """How much of a surface the dots of a page are."""

    area: float = np.nan  # Å^2; NaN where it is not known, or is that of a selection
    walls: float = 0.0  # Å^2, of it on the walls of cavities
    is_known: bool = False  # whether these dots stand for a whole surface
    selected_of: int = 0  # number of dots of the whole, if they are a selection
    cavities_are_removed: bool = False


NO_EXTENT = Extent()


def overview(
    title: str,
    prepared: PreparedSurface,
    order: np.ndarray,
    residues: pd.DataFrame | None = None,
    *,
    labels: Sequence[str] = (),
    values: Sequence[viewer.DotValues] = (),
    kept: Sequence[int] | np.ndarray = (),
    opens: tuple[str, int | str] | None = None,
    notes: Notes = Notes(),
    missing: Sequence[str] = (),
    counts: str = "",
    probe: float | None = None,
    extent: Extent = NO_EXTENT,
    links: Sequence[tuple[str, str]] = (),
    mean: float | None = None,
    reconstructed_from: int = 0,
    chosen_from: int = 0,
    why: str = "",
    drawn: DrawnMolecule | None = None,
    origin: Sequence[tuple[str, str]] = (),
) -> str:
    """Render the page of a surface, in one file.

    Where the surface is `drawn` as triangles, its list, its profile and its residues are linked; else its dots are shown:
    `order` are the dots in the order of farthest-point sampling, `residues` is the table of `evaluation.residues`, `labels`
    names the residue of each atom, `values` are further values of the dots, and `kept` the dots of a subset. `opens` is as of
    the viewer. `missing` names fields without a value, `counts` tells how large the molecule is, `probe` is its radius, Å,
    `extent` says how much of a surface the dots are, `links` are addresses and words of other pages on the surface, and `origin`
    says in pairs where the page is from. `mean` is the mean roughness of the surface, by default that of the dots, whose
    roughness is NaN where it is not known. `reconstructed_from` is the number of dots that the surface was reconstructed from,
    0 if it was not, `chosen_from` that of a large surface of which the page shows these dots, 0 if it shows all, and `why` says
    so, or why there is no roughness.
    """
    surface, rough, patches = prepared.surface, prepared.roughness, prepared.patches
    facts = {
        "subset": len(kept), "dots": len(surface), "extent": extent,
        "mean": float(rough.mean()) if mean is None else mean, "reconstructed_from": reconstructed_from, "why": why,
        "chosen_from": chosen_from,
        "r_patch": patches.r_patch, "d_link": patches.d_link,
        "probe": probe,
    }  # fmt: skip
    shown = [*values]
    if has_roughness := bool(np.isfinite(rough).any()):
        scale = "rough", "flat"
        shown = [viewer.DotValues("roughness", "R_i", "", rough, *scale, limits=ROUGHNESS_LIMITS), *values]
    names = ["the roughness"] * has_roughness + [field.name for field in values]
    context = {
        "title": title, "surface": facts, "names": listed(names or ["the kinds of the dots"]),
        "fields": [_range(field) for field in shown if field.symbol != COMPONENT_FIELD],
        "notes": notes.sentences, "missing": missing,
        "left_out": None if notes.left_out is None else ", ".join(notes.left_out), "counts": counts,
        "links": links, "origin": origin, "linked": drawn is not None, "n_frames": 1, "orders": "the roughest",
    }  # fmt: skip
    context |= residue_words(residues)

    def fill(data: str) -> str:
        """Return the page around packed dots."""
        return render_template(PAGE, data=data, **context)

    if drawn is not None and residues is not None:
        colour = opens[1] if opens else 0
        dots = DotsBelow(
            shown, surface.kind, surface.points, "kind" if colour == "kind" else f"corner {colour}"
        )
        numbers, ranked = [*numbers_of_residues(residues)], roughest(residues, n=None).index
        in_list = [*ranked, *residues.index.difference(ranked)]
        limit = MAX_LARGE_BYTES if chosen_from else MAX_EXPLORER_BYTES
        limit = viewer.MAX_VIEWER_BYTES if links else limit
        shape = Shape(drawn.mesh, drawn.atoms)
        return around_molecule(fill, drawn.molecule, [shape], numbers, in_list, dots, max_bytes=limit)
    return viewer.around_dots(
        fill, prepared, {"farthest": order}, residues=labels, values=values, minimal=kept, opens=opens or ("all", 0),
        turn=along_smallest_axis(surface.points),
        minimal_is="the given dots" if len(kept) == reconstructed_from else "the kept dots",
    )  # fmt: skip


@dataclass(frozen=True)
class DrawnMolecule:
    """The surface of a molecule as triangles, and the positions of the atoms below it, (A, 3) Å."""

    molecule: Molecule
    mesh: Mesh
    atoms: np.ndarray


def numbers_of_residues(residues: pd.DataFrame) -> Iterator[ResidueValues]:
    """Yield the numbers of residues that the page shows, first that of the list, from the table of `evaluation.residues`."""
    rough = residues["mean_roughness"].to_numpy(float)[None]
    yield ResidueValues("mean roughness", "", rough, 2, "rough", "flat", ROUGHNESS_LIMITS)
    area = residues["area"].to_numpy(float)[None]
    yield ResidueValues("area", "Å²", np.where(area > 0, area, np.nan), 0)
    for column in columns_of_means(residues):
        field = named_field(column.removeprefix("mean_"))
        yield ResidueValues(f"mean {field['name']}", field["unit"], residues[column].to_numpy(float)[None])


def columns_of_means(residues: pd.DataFrame) -> list[str]:
    """Return the columns with the mean of a field."""
    return [str(name) for name in residues if str(name).startswith("mean_") and name != "mean_roughness"]


def render_residues(title: str, residues: pd.DataFrame, origin: Sequence[tuple[str, str]] = ()) -> str:
    """Render a page of residues alone: their profile, the roughest, and where the page is from."""
    context = {
        "surface": None,
        "fields": (),
        "left_out": None,
        "notes": (),
        "missing": (),
        "counts": "",
        "links": (),
        "origin": origin,
        "linked": False,
        "n_frames": 1,
    }
    return render_template(PAGE, title=title, **context, **residue_words(residues))


def residue_words(residues: pd.DataFrame | None) -> dict[str, Any]:
    """Return what the template needs of the residues."""
    if residues is None:
        return {"table": None, "panels": [], "rough": [], "means": []}
    columns = columns_of_means(residues)
    rough = roughest(residues)
    rows = []
    for label, position, row in zip(labels_of(rough), rough.index, rough.to_dict("records"), strict=True):
        shown = {"label": label, "residue": position, "roughness": row["mean_roughness"]}
        shown |= {"area": row["area"], "dots": row["dots"], "means": [row[name] for name in columns]}
        rows.append(shown)
    means = [named_field(str(name).removeprefix("mean_")) for name in columns]
    return {"table": True, "panels": panels(residues), "rough": rows, "means": means, "min_area": MIN_AREA}


def named_field(name: str) -> dict[str, str]:
    """Return the name of a field for people, and its unit."""
    label, unit = label_and_unit(name)
    return {"name": label, "unit": unit.replace("^2", "²")}


def _range(values: viewer.DotValues) -> dict[str, Any]:
    """Return the name, the ends, the mean and the unit of some values."""
    finite = values.values[np.isfinite(values.values)]
    low, mean, high = (finite.min(), finite.mean(), finite.max()) if len(finite) else (np.nan,) * 3
    return {"name": values.name, "unit": values.unit.strip(), "low": low, "mean": mean, "high": high}


def listed(names: Sequence[str]) -> str:
    """Return names as a list in a sentence: 'a, b and c'."""
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def render_template(template: str, **context: Any) -> str:
    """Render a template of this folder."""
    from markupsafe import Markup

    is_linked = context["linked"]
    parts = {
        "style": Markup(explorer_style() if is_linked else viewer.style()),
        "main": Markup(viewer.main_html()),
        "script": Markup(explorer_script() if is_linked else viewer.script()),
    }
    names = (PROFILE_CSS, "page.css")
    style = Markup("".join(Path(__file__).with_name(name).read_text(encoding="utf-8") for name in names))
    shared = {"version": __version__, "style": style, "viewer": parts, "n_open": N_OPEN, "data": ""}
    text = _templates().get_template(template).render(shared | context)
    return "\n".join(line for line in text.lstrip().splitlines() if line.strip()) + "\n"


@cache
def _templates() -> jinja2.Environment:
    """Return the environment of the templates."""
    import jinja2  # here: only pages need it

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader([Path(__file__).parent, Path(explorer.__file__).parent]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = number
    return environment
