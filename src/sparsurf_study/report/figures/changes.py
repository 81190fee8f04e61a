"""Figure of two forms that are compared, and where they differ."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import colors
from matplotlib.patches import Patch

from sparsurf.orientation import rigid_fit
from sparsurf.views import layout, render
from sparsurf.views.layout import styled
from sparsurf_study.pairs.changes import SHARE_ABOVE_FLOOR, superpose_forms
from sparsurf_study.report.numbers import most_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.surface import Surface

PICTURE_WIDTH, HEIGHT = 86, 60  # mm, of a picture
MAX_RESIDUE_GAP = 20  # residues, along the axis of changes
CHANGE_LABEL_WIDTH = 12.0  # mm
N_NAMED, NAME_WIDTH = 5, 11.0  # residues that change most, and mm of a name
ROUND = tuple(k * 10**n for n in range(6) for k in (1, 2, 5))  # residues between labels
REST = render.PALE_RGB
BELOW = colors.to_rgb("#B0B0B0")  # residues that change less than their floor


def seen_alike(
    forms: Sequence[tuple[str, Surface, Molecule, np.ndarray]],
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Superpose two forms and look at what changes most; points and normals (N, 3) of each, towards the viewer along z.

    Third is the turn (3, 3) of the form where it lies, whose rows point right, up and to the viewer.
    """
    (_, surface, molecule, change), (_, other, moved, _) = forms
    changed = change >= np.nanquantile(change, 0.9)
    view = render.oblique(surface.points[changed], surface.normals[changed], 90)  # from above
    rotation, shift = rigid_fit(moved.xyz[0], superpose_forms(moved, molecule).xyz[0])
    return [
        (surface.points @ view.T, surface.normals @ view.T, view),
        ((other.points @ rotation + shift) @ view.T, other.normals @ rotation @ view.T, view @ rotation.T),
    ]


def highest_shown(changes: Sequence[np.ndarray]) -> float:
    """Return the end of the colours of changes over their floors: robust, so that one residue does not set it."""
    return float(max(np.nanquantile(np.concatenate(changes), 0.98), 2))


def change_colours(change: np.ndarray, scale: ScalarMappable) -> np.ndarray:
    """Return the colours of changes over their floors: grey below 1, that of the rest where unknown, (N, 3) float64."""
    shown = np.where(change[:, None] < 1, BELOW, layout.colours(scale, np.nan_to_num(change)))
    return np.where(np.isnan(change)[:, None], REST, shown)


@styled
def changes_figure(
    name: str, forms: Sequence[tuple[str, Surface, Molecule, np.ndarray]], table: pd.DataFrame
) -> Figure:
    """Draw two forms (title, Surface, Molecule, change over its floor by dot), and the change along the residues."""
    ratios = table["over_floor"].dropna()
    n_above = (ratios > 1).sum()
    by_chance = f"about {SHARE_ABOVE_FLOOR * len(ratios):.0f} would by chance"
    message = f"{n_above} of {len(ratios)} residues change more than their floor, {by_chance}"
    if most_of(n_above, len(ratios)):
        message = f"most residues change more than their floor ({n_above} of {len(ratios)}, {by_chance})"
    scale = layout.scale(1, highest_shown([change for *_, change in forms]))
    oriented = seen_alike(forms)
    shape = layout.pixels(PICTURE_WIDTH - 8, HEIGHT)
    camera = render.aim(np.concatenate([points for points, *_ in oriented]), np.eye(3), shape)
    figure = layout.sheet(layout.PAGE_WIDTH, HEIGHT + 65, layout.headed(name, message))
    for k, ((title, *_, change), (points, normals, _)) in enumerate(zip(forms, oriented, strict=True)):
        x = 2 + (PICTURE_WIDTH - 4) * k
        scene = render.draw_surface(points, normals, change_colours(change, scale), camera)
        layout.text(figure, x, 1, title)
        layout.draw_picture(
            layout.axes(figure, x, 5, PICTURE_WIDTH - 8, HEIGHT), render.picture(scene), camera, k == 0
        )
    meanings = {"change below its floor": BELOW, "buried, or missing from the other form": REST}
    handles = [
        Patch(facecolor=colour, edgecolor="0.6", label=meaning) for meaning, colour in meanings.items()
    ]
    layout.legend(figure, 30, HEIGHT + 7, handles, ncols=2)
    bar = figure.colorbar(scale, cax=layout.axes(figure, 168, 10, 2.5, 45), extend="max")
    bar.set_label("change of shape and fields, over its floor")
    _along(layout.axes(figure, 14, HEIGHT + 15, layout.PAGE_WIDTH - 18, 35), table, scale)
    return figure


def _along(ax: Axes, table: pd.DataFrame, scale: ScalarMappable) -> None:
    """Draw the change of each residue in its colour, and its floor."""
    position = _positions(table)
    ax.bar(position, table["total"], 1.0, color=change_colours(table["over_floor"].to_numpy(), scale))
    _name_most(ax, table, position)
    floor = table[["total_floor", "total_moved"]].max(axis=1).where(table["total"].notna())
    label = "floor: fresh dots or moved atoms, the larger one"
    ax.hlines(floor, position - 0.5, position + 0.5, color="black", linewidth=0.8, label=label)
    begin = np.flatnonzero(table["chain"] != table["chain"].shift())
    shown = _named(table, position, begin if len(begin) > 1 else begin[:0])
    names = (table["chain"] + ":" if len(begin) > 1 else "") + table["residue"]
    ax.set_xticks(position[shown], np.asarray(names)[shown])
    ax.set(
        xlabel="residue (no bar: buried, or missing from a form)",
        ylabel="change of shape and\nfields within 10 Å (sd)",
        xlim=(-0.5, position[-1] + 0.5),
        ylim=(0, 1.15 * _highest(table).max()),  # with room for names
    )
    ax.legend(loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0)


def _name_most(ax: Axes, table: pd.DataFrame, position: np.ndarray) -> None:
    """Write the names of the residues that change most over their floors, with a line to their bars, where there is room."""
    taken: list[int] = []
    room = NAME_WIDTH * (position[-1] + 1) / (layout.PAGE_WIDTH - 18)
    change = table["over_floor"].to_numpy()
    highest = _highest(table)
    top = highest.max(initial=0.0)
    for row in np.argsort(-np.nan_to_num(change), kind="stable")[:N_NAMED]:
        place = int(position[row])
        if change[row] > 1 and all(abs(place - other) >= room for other in taken):
            name, residue, change_here = table[["residue_name", "residue", "total"]].iloc[row]
            height = highest[np.abs(position - place) < room / 2].max() + top / 30  # above its neighbours
            style: dict[str, Any] = {"ha": "center", "va": "bottom", "path_effects": layout.HALO}
            if min(place, position[-1] - place) < room / 2:  # beside the axis, not over its numbers
                style["ha"] = "left" if place < room / 2 else "right"
            style["arrowprops"] = {"arrowstyle": "-", "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0}
            ax.annotate(f"{name}{residue}", (place, change_here), (place, height), **style)
            taken.append(place)


def _highest(table: pd.DataFrame) -> np.ndarray:
    """Return the height of each residue, its change or a floor, (n,)."""
    return table[["total", "total_floor", "total_moved"]].max(axis=1).fillna(0).to_numpy(float)


def _positions(table: pd.DataFrame) -> np.ndarray:
    """Place residues along an axis by their numbers, (n,) int; missing ones leave a gap of at most `MAX_RESIDUE_GAP` residues."""
    numbers = _numbers(table)
    step = numbers.diff().where(table["chain"] == table["chain"].shift(), 1)
    return np.append(0, step.clip(1, MAX_RESIDUE_GAP)[1:].cumsum()).astype(int)


def _named(table: pd.DataFrame, position: np.ndarray, begin: np.ndarray) -> list[int]:
    """Choose rows whose residue is named along the axis: where a chain begins, and round numbers with room between them."""
    room = CHANGE_LABEL_WIDTH * (position[-1] + 1) / (layout.PAGE_WIDTH - 18)
    step = next(step for step in ROUND if step >= room)
    shown = [int(row) for row in begin]
    for row in np.flatnonzero(_numbers(table) % step == 0):
        if all(abs(position[row] - position[other]) >= room for other in shown):
            shown.append(int(row))
    return sorted(shown)


def _numbers(table: pd.DataFrame) -> pd.Series:
    """Return the numbers of residues, (n,) int, without insertion codes."""
    return table["residue"].astype(str).str.extract(r"(-?\d+)")[0].astype(int)
