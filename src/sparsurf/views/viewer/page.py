"""Interactive page of one surface: dots to rotate and pick, the paper's sampling live, d and Z of the grid."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from sparsurf import kinds
from sparsurf.dot_fields.registry import label_and_unit
from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.messages import no_warnings
from sparsurf.patches.readings import words_of
from sparsurf.recovery.mesh import recovered_mesh
from sparsurf.recovery.readings import readings_of_columns
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.sampling.samplers import farthest, sampler_label
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.components import COMPONENT_FIELD, fields_without_component
from sparsurf.surfaces.formats.ply import ROUGHNESS_LIMITS, viridis
from sparsurf.surfaces.spacing import spacing
from sparsurf.surfaces.thinning import DENSITY_OF_PICTURES, mesh_of_picture
from sparsurf.views.page import dots as dots_of_pages
from sparsurf.views.page.dots import (
    COORDINATE_STEP,
    COVER_COLUMNS,
    MAX_DOTS,
    cover_columns,
    places_of,
    presets,
)
from sparsurf.views.page.packing import OCTAHEDRON, flat_normals, in_steps, pack
from sparsurf.views.page.scene import MAX_BYTES_IN_REPORT, N_COLOUR_STOPS, DotValues, named_kinds, scale_of
from sparsurf.views.render import DISTANCE_LIMITS

if TYPE_CHECKING:
    from sparsurf.surfaces.surface import Surface, SurfaceOrigin

MAX_VIEWER_BYTES = MAX_BYTES_IN_REPORT
SHARED_SCRIPTS = ("unpack.js", "sampling.js")  # of the page of a molecule
VIEWER_SCRIPTS = ("gl.js", "scene.js", "drawing.js", "page.js")
SHEET_STEP = 0.02  # Å, of the corners of the surface below the dots
SHEET_GRID = 0.7, 2.6  # Å, steps of the finest and the coarsest grid from which it is made
SHEET_DENSITY, MIN_SHEET_DOTS = 1.0, 100  # dots per Å^2 from which it is reconstructed, and at least so many
CORNERS_PER_CELL, MAX_CORNERS = 4.2, 30_000  # corners on an area of a squared step, and of a page
MAX_SHARE_OF_SHEET = 0.2  # of the bytes of a page


def page(
    title: str,
    prepared: PreparedSurface,
    orders: dict[str, np.ndarray],
    grid: pd.DataFrame | None = None,
    best: dict[str, Any] | None = None,
    residues: Sequence[str] = (),
    values: Sequence[DotValues] = (),
    minimal: Sequence[int] | np.ndarray = (),
    opens: tuple[str, int | str] | None = None,
    up: str = "../../index.html",
    turn: np.ndarray | None = None,
    first: str = "",
    origin: Sequence[tuple[str, str]] = (),
    atoms: SurfaceOrigin | None = None,
) -> str:
    """Render the page, with everything in one file of at most MAX_VIEWER_BYTES.

    `orders` hold dots in the order in which nested samplers choose them; if a
    surface is too large for a page, the first dots of the first sampler are shown. Without `grid` (the rows of a grid.csv)
    the page has no d and Z; `best` is the content of a best.json. `residues` names that of each atom of the
    structure, `values` are further values to colour by, and `minimal` the dots of the minimal subset. `opens` is the sampler
    that is shown first, and its colour: 0 for R_i, then those of `values`, or 'kind'. `up` links to the page of the run,
    rows of `turn`, the rotation of the first view, point right, up and to the viewer, and `first` links to the page with the
    roughness of the surface and its residues. `origin` says in pairs where the page is from, and `atoms` lie below the dots.
    """
    rough = prepared.roughness
    named = {first: "Roughness and residues", up: "All of this run"}
    links = [f'<a href="{escape(path)}">{label}</a>' for path, label in named.items() if path]
    parts = {
        "%TITLE%": escape(title),
        "%ANSWER%": f"{len(rough):,} dots, mean roughness {rough.mean():.2f}.",
        "%UP%": f'<span id="up">{", ".join(links)}</span>' if links else "",
        "%STYLE%": style(),
        "%MAIN%": main_html(),
        "%ORIGIN%": _origin_html(origin),
        "%SCRIPT%": script(),
    }

    def fill(data: str) -> str:
        """Return the page around packed dots."""
        text = _read("page.html")
        for mark, part in (parts | {"%DATA%": data}).items():
            text = text.replace(mark, part)
        return text

    return around_dots(
        fill, prepared, orders, grid, best, residues, values, minimal, opens, turn, origin=atoms
    )


def _origin_html(origin: Sequence[tuple[str, str]]) -> str:
    """Return the folded list that says where a page is from."""
    rows = "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in origin)
    return f'<details class="origin"><summary>Origin</summary><dl>{rows}</dl></details>' if rows else ""


def around_dots(
    fill: Callable[[str], str],
    prepared: PreparedSurface,
    orders: dict[str, np.ndarray],
    grid: pd.DataFrame | None = None,
    best: dict[str, Any] | None = None,
    residues: Sequence[str] = (),
    values: Sequence[DotValues] = (),
    minimal: Sequence[int] | np.ndarray = (),
    opens: tuple[str, int | str] | None = None,
    turn: np.ndarray | None = None,
    minimal_is: str = "the subset minimal.csv",
    origin: SurfaceOrigin | None = None,
) -> str:
    """Return the page that `fill` makes around the packed dots, of at most MAX_VIEWER_BYTES; the rest is as of `page`.

    The page needs `style`, `main` and `script`, and the packed dots as `PACKED`. `minimal_is` names the dots of `minimal`. The
    surface below the dots is that of the atoms of `origin`, or else reconstructed.
    """
    surface = prepared.surface
    grid, best = pd.DataFrame(columns=[*PARAMETERS, "n_S_percent"]) if grid is None else grid, best or {}
    has_roughness = bool(np.isfinite(prepared.roughness).any())
    if has_roughness:
        scale = "rough", "flat"
        of_dots = DotValues("roughness R_i", "R_i", "", prepared.roughness, *scale, limits=ROUGHNESS_LIMITS)
        values = [of_dots, *values]
    sheet, max_dots = sheet_columns(prepared, next(iter(orders.values())), origin), MAX_DOTS
    if len(pack({}, sheet)) > MAX_SHARE_OF_SHEET * MAX_VIEWER_BYTES:
        sheet = {name: values[:0] for name, values in sheet.items()}
    while True:
        dots = np.sort(next(iter(orders.values()))[:max_dots])
        whole = {name: order for name, order in orders.items() if np.isin(dots, order).all()}
        header = _header(surface, dots, prepared.patches.r_patch, whole, grid, best, values, minimal)
        header["turn"] = np.round(np.eye(3) if turn is None else turn, 6).ravel().tolist()
        header["sampler"], header["colour"] = opens or (next(iter(header["samplers"])), 0)
        columns = dot_columns(surface, dots, whole, residues, values, header)
        cover = (
            cover_columns(surface, dots, prepared.cover)
            if has_roughness
            else dict.fromkeys(COVER_COLUMNS, np.empty(0, int))
        )
        if not has_roughness:  # which the paper's sampling needs
            for name in kinds.samplers_of_combinations():
                header["samplers"].pop(name, None)
        if len(minimal):
            header["samplers"]["minimal"] = minimal_is
            columns["minimal"] = np.isin(dots, minimal).astype(int)
        text = fill(pack(header, columns | cover | sheet))
        if len(text.encode()) <= MAX_VIEWER_BYTES:
            return text
        # A little less than in proportion, so that the next attempt mostly fits, and the loop ends
        max_dots = int(0.95 * len(dots) * MAX_VIEWER_BYTES / len(text))


def style() -> str:
    """Return the style sheet of the viewer, which is that of its own page."""
    return _read("page.css")


def main_html() -> str:
    """Return the HTML of the viewer: its picture and its controls."""
    return _read("main.html").rstrip("\n")


def script() -> str:
    """Return the JavaScript of the viewer, which reads the packed dots from the constant `PACKED`."""
    shared = (
        Path(dots_of_pages.__file__).with_name(name).read_text(encoding="utf-8") for name in SHARED_SCRIPTS
    )
    return "".join([*shared, *map(_read, VIEWER_SCRIPTS)])


def coloured_page(
    title: str,
    surface: Surface,
    settings: Settings,
    streams: Streams,
    values: Sequence[DotValues],
    residues: Sequence[str] = (),
    origin: Sequence[tuple[str, str]] = (),
) -> str:
    """Render the page of a surface without a grid, which opens with all dots in the colours of the first values."""
    prepared = PreparedSurface(surface, settings, None, streams)
    order = farthest(prepared, min(len(surface), MAX_DOTS), prepared.stream("view"))
    return page(
        title, prepared, {"farthest": order}, residues=residues, values=values, opens=("all", 1),
        origin=origin,
    )  # fmt: skip


def values_of(surface: Surface, distance: np.ndarray) -> list[DotValues]:
    """Return what the dots of a surface show: their distance from the reconstructed one, component, and fields."""
    name = "distance from the surface reconstructed from minimal.csv"
    shown = [DotValues(name, "distance", " Å", distance, "on it", "off", limits=DISTANCE_LIMITS)]
    components = surface.fields.get(COMPONENT_FIELD)
    if components is not None and components.max() > 0:
        shown.append(
            DotValues("component of the surface", "component", "", components, "largest", "smallest")
        )
    for field, numbers in fields_without_component(surface).items():
        label, unit = label_and_unit(field)
        shown.append(DotValues(label, field, f" {unit}".rstrip().replace("^2", "²"), numbers))
    return shown


def _read(name: str) -> str:
    """Read a file of this folder."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def _header(
    surface: Surface,
    dots: np.ndarray,
    radius: float,
    orders: dict[str, np.ndarray],
    grid: pd.DataFrame,
    best: dict[str, Any],
    values: Sequence[DotValues],
    minimal: Sequence[int] | np.ndarray,
) -> dict[str, Any]:
    """Collect what the page needs besides the dots."""
    readings = readings_of_columns(grid, "d_")
    columns = [*PARAMETERS, "n_S_percent"]
    columns += [f"{name}_{reading}" for reading in readings for name in ("Z_tS", "Z_tR", "d")]
    numbers = grid[columns].to_numpy(float)
    samplers = {"minimal": "the subset minimal.csv"} if len(minimal) else {}
    # from the most even subsets to the paper's, which is the last of the list since its parameters stand below it
    in_browser = [name for name, choice in reversed(kinds.TABLE["sampler"].items()) if choice.in_browser]
    samplers |= {name: sampler_label(name) for name in (*orders, *in_browser)}
    return {
        "total": len(surface),
        "stored": len(dots),
        "minimal": len(minimal),
        "step": COORDINATE_STEP,
        "meshStep": SHEET_STEP,
        "radius": radius,
        "octahedron": OCTAHEDRON,
        "spacing": spacing(surface.points[dots]) if len(dots) > 1 else 1.0,
        "samplers": samplers | {"all": "all dots"},
        "readings": [words_of(reading) for reading in readings],
        "grid": [[float(f"{x:.5g}") if np.isfinite(x) else None for x in row] for row in numbers],
        "presets": presets(best),
        "values": [scale_of(field) for field in values],
        "kinds": named_kinds(),
        "stops": viridis(np.linspace(0, 1, N_COLOUR_STOPS)).tolist(),
    }


def dot_columns(
    surface: Surface,
    dots: np.ndarray,
    orders: dict[str, np.ndarray],
    residues: Sequence[str],
    values: Sequence[DotValues],
    header: dict[str, Any],
) -> dict[str, np.ndarray]:
    """Return columns of the shown dots; kind and residue only if they are known."""
    points = np.round(surface.points[dots] / COORDINATE_STEP).astype(int)
    columns = dict(zip("xyz", points.T, strict=True)) | {"index": dots}
    columns |= dict(zip("uv", flat_normals(surface.normals[dots]).T, strict=True))
    if (surface.kind >= 0).any() or not values:
        columns["kind"] = surface.kind[dots]
    if len(residues) and (surface.atom >= 0).any():
        names, number = np.unique(residues, return_inverse=True)
        atom = surface.atom[dots]
        columns["residue"] = np.where(atom >= 0, number[atom], -1)
        header["residues"] = names.tolist()
    for k, (field, scale) in enumerate(zip(values, header["values"], strict=True)):
        columns[f"value {k}"] = in_steps(field.values[dots], scale["low"], scale["high"])
    position = places_of(dots, len(surface))
    for name, order in orders.items():
        rank = np.empty(len(dots), int)
        chosen = position[order][position[order] >= 0]
        rank[chosen] = np.arange(len(chosen))
        columns[f"rank {name}"] = rank
    return columns


def sheet_columns(
    prepared: PreparedSurface, order: np.ndarray, origin: SurfaceOrigin | None
) -> dict[str, np.ndarray]:
    """Return corners and triangles of the surface below the dots: of the atoms of `origin`, or else reconstructed from dots.

    These are the first dots of an order. There are no triangles where a surface is too large for a page, or where its dots do
    not enclose anything.
    """
    area = len(prepared.points) / prepared.density
    step = max(SHEET_GRID[0], math.sqrt(CORNERS_PER_CELL * area / MAX_CORNERS))
    few = order[: max(MIN_SHEET_DOTS, round(SHEET_DENSITY * area))]
    corners, triangles = np.empty((0, 3)), np.empty((0, 3), int)
    if origin is not None and step <= SHEET_GRID[1]:
        with suppress(InputError):  # a grid around it does not fit into the memory
            made = mesh_of_picture(origin, prepared.threads, min(DENSITY_OF_PICTURES, MAX_CORNERS / area))
            corners, triangles = made.vertices.points, made.triangles
    elif step <= SHEET_GRID[1] and len(few) >= MIN_SHEET_DOTS:
        with no_warnings(), suppress(InputError):
            made = recovered_mesh(
                prepared.points[few], prepared.normals[few], step, 2 / step**2, threads=prepared.threads
            )
            corners, triangles = made.vertices.points, made.triangles
    places = np.round(corners / SHEET_STEP).astype(int)
    return dict(zip(("mx", "my", "mz"), places.T, strict=True)) | {"triangle": triangles.ravel()}
