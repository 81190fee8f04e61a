"""Pictures of one surface: by kind of dots, by roughness, its kept dots, and the roughness of its residues."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colors

from sparsurf.dot_fields.named_fields import label_with_unit
from sparsurf.evaluation.ranking import MIN_AREA
from sparsurf.surfaces.formats.colours import KIND_COLOURS, KIND_NAMES, Scale
from sparsurf.views import layout, render
from sparsurf.views.layout import styled
from sparsurf.views.page.profile import chains, labels_of, limits, places_of_labels, roughest, stretches

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sparsurf.surfaces.surface import Surface
    from sparsurf.views.layout import Sheet

PICTURE = 82.0, 62.0  # mm, of a surface
ROUGH = "#5b2a86"  # residues that are marked as the roughest, as on the page
CHAIN_HEIGHT, TICK_ROOM = 38.0, 9.0  # mm, of the profile of a chain, and from one number below it to the next
MAX_CHAINS = 12  # One picture shows at most so many chains.
RESIDUE_LABEL_WIDTH = 2.6  # mm, of the name of a residue, which stands upright
PROFILE_MARGIN = 16.0  # mm, beside a profile


def _of_surface(
    surface: Surface, colours: np.ndarray, name: str, kept: Surface | None = None, of_kept: Any = None
) -> Sheet:
    """Draw a surface in colours of 0..1, with its name, and kept dots on it, by default dark."""
    figure = layout.sheet(layout.PAGE_WIDTH / 2 + 15, PICTURE[1] + 8, name)
    camera = render.aim(surface.points, render.along_smallest_axis(surface.points), layout.pixels(*PICTURE))
    scene = render.draw_surface(surface.points, surface.normals, colours, camera)
    if kept is not None:
        of_kept = colors.to_rgb(layout.DARK) if of_kept is None else of_kept
        scene = render.draw_dots(scene, kept.points, kept.normals, of_kept, 1.5 * render.DISC_RADIUS)
    layout.draw_picture(layout.axes(figure, 3, 2, *PICTURE), render.picture(scene), camera)
    return figure


@styled
def kinds_picture(surface: Surface, name: str) -> Figure:
    """Draw a surface in the colours of the kinds of its dots."""
    from matplotlib.patches import Patch

    figure = _of_surface(surface, KIND_COLOURS[surface.kind] / 255, name)
    present = np.unique(surface.kind[surface.kind >= 0])
    handles = [Patch(color=KIND_COLOURS[kind] / 255, label=KIND_NAMES[kind]) for kind in present]
    if handles:
        layout.legend(figure, 88, 4, handles)
    return figure


@styled
def values_picture(surface: Surface, scale: Scale, name: str, whole: Surface | None = None) -> Figure:
    """Draw dots in the colours of their values, as a surface or as discs on the `whole` one."""
    colours = scale.colours / 255
    figure = kept_picture(whole, surface, name, colours) if whole else _of_surface(surface, colours, name)
    label = "pLDDT" if scale.bands else label_with_unit(scale.name)
    if scale.name == "roughness":
        label = "roughness $R_i$ (low: rough, high: flat)"
    layout.colour_bar(figure, scale, label, cax=layout.axes(figure, 88, 8, 2.5, 45))
    return figure


@styled
def kept_picture(surface: Surface, kept: Surface, name: str, colours: np.ndarray | None = None) -> Sheet:
    """Draw a surface in pale grey with the kept dots on it, in colours of 0..1 or dark."""
    return _of_surface(surface, np.tile(render.PALE_RGB, (len(surface), 1)), name, kept, colours)


@styled
def profile_picture(residues: pd.DataFrame, name: str) -> Figure:
    """Draw the mean roughness of the residues along each chain, with the roughest named."""
    shown = list(chains(residues))[:MAX_CHAINS]
    figure = layout.constrained(layout.PAGE_WIDTH, 10 + CHAIN_HEIGHT * len(shown), name)
    low, high = limits(residues)
    rough = roughest(residues).index
    for ax, (chain, rows) in zip(figure.subplots(len(shown), squeeze=False).ravel(), shown, strict=True):
        values = rows["mean_roughness"].to_numpy(float)
        for part in stretches(rows):
            ax.plot(part, values[part], "-", color=layout.GREY)
        ax.plot(np.arange(len(rows)), values, ".", color=layout.GREY, markersize=2)
        marked = np.flatnonzero(rows.index.isin(rough))
        ax.plot(marked, values[marked], "o", color=ROUGH, markersize=4)
        per_residue = (layout.PAGE_WIDTH - PROFILE_MARGIN) / len(rows)  # mm
        _name(
            ax,
            marked[np.argsort(values[marked], kind="stable")],
            values,
            labels_of(rows),
            RESIDUE_LABEL_WIDTH / per_residue,
        )
        room = math.ceil(TICK_ROOM / per_residue)
        places = places_of_labels(rows, room)
        ax.set_xticks(places, rows["residue"].iloc[places].astype(str).tolist())
        ax.set(xlim=(-1, len(rows)), ylim=(low - 0.45 * (high - low), high), ylabel="mean roughness")
        if len(shown) > 1:
            ax.set_title(f"chain {chain}", loc="left")
    marked_are = f"; the {len(rough)} roughest of at least {MIN_AREA:g} Å² are marked" if len(rough) else ""
    ax.set_xlabel(f"residue (low: rough, high: flat{marked_are})")
    return layout.fix_layout(figure)


def _name(ax: Axes, residues: np.ndarray, values: np.ndarray, labels: Sequence[str], room: float) -> None:
    """Write the labels of residues, upright below their points, without those that lie within `room` of one before."""
    named: list[int] = []
    style: dict[str, Any] = {
        "textcoords": "offset points",
        "rotation": 90,
        "ha": "center",
        "va": "top",
        "fontsize": 6,
    }
    for k in residues.tolist():
        if all(abs(k - other) >= room for other in named):
            named.append(k)
            ax.annotate(labels[k], (k, values[k]), (0, -4), **style)
