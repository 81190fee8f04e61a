"""Render the page on a surface: the template holds the sentences, and these functions supply the numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from sparsurf.dot_fields.registry import label_and_unit
from sparsurf.patches.index import D_LINK
from sparsurf.surfaces.components import COMPONENT_FIELD
from sparsurf.version import __version__
from sparsurf.views.numbers import number
from sparsurf.views.overview.profile import PROFILE_CSS, labels_of, panels, roughest
from sparsurf.views.render import along_smallest_axis
from sparsurf.views.viewer import page as viewer

if TYPE_CHECKING:
    import jinja2

    from sparsurf.evaluation.prepared_surface import PreparedSurface

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
    links: Sequence[tuple[str, str]] = (),
) -> str:
    """Render the page of a surface, in one file.

    `order` are the dots in the order of farthest-point sampling, `residues` is the table of `evaluation.residues`, `labels`
    names the residue of each atom, `values` are further values of the dots, and `kept` the dots of a subset. `opens` is as of
    the viewer. `missing` names fields without a value, `counts` tells how large the molecule is, `probe` is its radius, Å, and
    `links` are addresses and words of other pages on the surface.
    """
    surface, rough, patches = prepared.surface, prepared.roughness, prepared.patches
    facts = {
        "subset": len(kept), "dots": len(surface), "area": float(surface.area.sum()) if np.isfinite(surface.area).all() else 0.0,
        "mean": float(rough.mean()), "r_patch": patches.r_patch, "d_link": patches.d_link,
        "sparse": float(f"{patches.d_link:.2g}") > D_LINK,  # as the page shows it
        "probe": probe,
    }  # fmt: skip
    shown = [viewer.DotValues("roughness", "R_i", "", rough), *values]
    context = {
        "title": title, "surface": facts, "names": listed(["the roughness", *[field.name for field in values]]),
        "fields": [_range(field) for field in shown if field.symbol != COMPONENT_FIELD],
        "notes": notes.sentences, "missing": missing,
        "left_out": None if notes.left_out is None else ", ".join(notes.left_out), "counts": counts,
        "links": links,
    }  # fmt: skip
    context |= residue_words(residues)

    def fill(data: str) -> str:
        """Return the page around packed dots."""
        return render_template(data=data, **context)

    return viewer.around_dots(
        fill, prepared, {"farthest": order}, residues=labels, values=values, minimal=kept, opens=opens or ("all", 0),
        turn=along_smallest_axis(surface.points),
        minimal_is="the kept dots",
    )  # fmt: skip


def render_residues(title: str, residues: pd.DataFrame) -> str:
    """Render a page of residues alone: their profile and the roughest."""
    context = {
        "surface": None,
        "fields": (),
        "left_out": None,
        "notes": (),
        "missing": (),
        "counts": "",
        "links": (),
    }
    return render_template(title=title, **context, **residue_words(residues))


def residue_words(residues: pd.DataFrame | None) -> dict[str, Any]:
    """Return what the template needs of the residues."""
    if residues is None:
        return {"table": None, "panels": [], "rough": [], "means": []}
    columns = [name for name in residues if str(name).startswith("mean_") and name != "mean_roughness"]
    rough = roughest(residues)
    rows = [
        {"label": label, "roughness": row["mean_roughness"], "area": row["area"], "dots": row["dots"],
         "means": [row[name] for name in columns]}
        for label, row in zip(labels_of(rough), rough.to_dict("records"), strict=True)
    ]  # fmt: skip
    means = [named_field(str(name).removeprefix("mean_")) for name in columns]
    return {"table": True, "panels": panels(residues), "rough": rows, "means": means}


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


def render_template(**context: Any) -> str:
    """Render the template."""
    from markupsafe import Markup

    parts = {
        "style": Markup(viewer.style()),
        "main": Markup(viewer.main_html()),
        "script": Markup(viewer.script()),
    }
    names = (PROFILE_CSS, "page.css")
    style = Markup("".join(Path(__file__).with_name(name).read_text(encoding="utf-8") for name in names))
    shared = {"version": __version__, "style": style, "viewer": parts, "n_open": N_OPEN, "data": ""}
    text = _template().render(shared | context)
    return "\n".join(line for line in text.lstrip().splitlines() if line.strip()) + "\n"


@cache
def _template() -> jinja2.Template:
    """Load the template."""
    import jinja2  # here: only pages need it

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = number
    return environment.get_template("page.html.j2")
