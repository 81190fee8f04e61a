"""Figures of pairs: both partners opened like a book, and AUC over all pairs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import colors
from matplotlib.lines import Line2D

from sparsurf.orientation import principal_axes
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout, render
from sparsurf.views.layout import styled
from sparsurf_study.pairs.ranking import BASELINE, MAIN_SCORE, means_over_pairs
from sparsurf_study.report.numbers import against_zero, auc_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf.views.render import Camera

SCORE_STYLES = {
    "propensity": "complementarity, nearest patch",
    "propensity_smoothed": "complementarity, smoothed",
    "propensity_k": "complementarity, mean of the nearest",
    "propensity_k_smoothed": "complementarity, mean smoothed",
    "similarity": "similarity, nearest patch",
    "similarity_smoothed": "similarity, smoothed",
    "protrusion": "protrusion: few heavy atoms within 10 Å",
}
INTERFACE_COLOUR, OTHER_COLOUR = "#D55E00", "#DDDDDD"  # of the interface
PARTNER_WIDTH, PARTNER_HEIGHT = 78, 62  # mm, of a partner
GAP_OF_PAGES = 5.0  # Å, between both partners to turn


@styled
def book_figure(
    name: str, surfaces: Sequence[Surface], tables: Sequence[pd.DataFrame], agreement: pd.DataFrame
) -> Figure:
    """Draw smoothed propensity above, the interface below (or smoothed similarity if the partners do not touch)."""
    touching = [table["interface"].to_numpy() == 1 for table in tables]
    in_contact = all(mask.any() for mask in touching)
    pages = partners_opened(surfaces, touching)
    shape = layout.pixels(PARTNER_WIDTH, PARTNER_HEIGHT)
    cameras = [render.aim(dots.points, page, shape) for dots, page in zip(surfaces, pages, strict=True)]
    scale = min(camera.scale for camera in cameras)  # one for both, so that their sizes can be compared
    cameras = [camera._replace(scale=scale) for camera in cameras]
    main = agreement[agreement["score"] == MAIN_SCORE].set_index("partner")
    limits = main[["low", "high"]].to_numpy() - 0.5
    places = {side: against_zero(*ends) for side, ends in zip(main.index, limits, strict=True)}
    figure = layout.sheet(layout.PAGE_WIDTH, 148, layout.headed(name, where_matches_lie(places)))
    for side in (1, 2):
        auc = f": AUC {auc_of(main, side, 'auc')}" if side in main.index else ""
        label = f"partner {side}, seen from partner {3 - side}{auc}"
        layout.text(figure, 4 + (side - 1) * (PARTNER_WIDTH + 2), 1, label)
    label = "rank of the smoothed\ndistance of patches (%)\n(low: good match)"
    _row(figure, 7, surfaces, cameras, tables, "propensity_smoothed", label)
    if in_contact:
        for side in (0, 1):
            colour = np.where(
                touching[side][:, None], colors.to_rgb(INTERFACE_COLOUR), colors.to_rgb(OTHER_COLOUR)
            )
            _page(figure, side, 77, surfaces[side], colour, cameras[side])
        layout.text(figure, 162, 80, "interface: dots\nclose to the\nother partner", color=INTERFACE_COLOUR)
    else:
        label = "rank of the smoothed similarity\n(%; low: alike)"
        _row(figure, 77, surfaces, cameras, tables, "similarity_smoothed", label)
    return figure


def where_matches_lie(places: Mapping[int, str]) -> str:
    """Say whether matching patches lie at the interface, by the place of each partner's AUC relative to 0.5."""
    matching = [side for side, place in places.items() if place == "above"]
    if not places:
        return ""
    if len(matching) == len(places):
        return "matching patches lie at the interface"
    if matching:
        return f"matching patches lie at the interface of partner {matching[0]} only"
    away = [side for side, place in places.items() if place == "below"]
    if len(away) == len(places):
        return "matching patches lie away from the interface"
    but = "".join(f", and lie away from it on partner {side}" for side in away)
    return f"matching patches do not mark the interface{but}"


def _row(
    figure: layout.Sheet,
    y: float,
    surfaces: Sequence[Surface],
    cameras: Sequence[Camera],
    tables: Sequence[pd.DataFrame],
    column: str,
    label: str,
) -> None:
    """Draw both partners in the colours of the ranks of a column."""
    scale = layout.scale(0, 100)
    for side in (0, 1):
        colour = layout.colours(scale, ranks(tables[side][column]))
        _page(figure, side, y, surfaces[side], colour, cameras[side])
    figure.colorbar(scale, cax=layout.axes(figure, 162, y + 5, 2.5, 50)).set_label(label)


def ranks(values: pd.Series) -> np.ndarray:
    """Return the rank of each value of a partner, (N,) float64, %: its AUC compares only the dots of one partner."""
    return 100 * values.rank(pct=True).to_numpy()


def _page(
    figure: layout.Sheet, side: int, y: float, surface: Surface, colour: np.ndarray, camera: Camera
) -> None:
    """Render one partner in some colours."""
    scene = render.draw_surface(surface.points, surface.normals, colour, camera)
    ax = layout.axes(figure, 2 + side * (PARTNER_WIDTH + 2), y, PARTNER_WIDTH, PARTNER_HEIGHT)
    layout.draw_picture(ax, render.picture(scene), camera)


def partners_opened(surfaces: Sequence[Surface], touching: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return rotations that look at each partner from the other, along the centres of `touching` dots, with a common hinge."""
    first, second = surfaces
    if not all(mask.any() for mask in touching):
        facing, around = second.points.mean(axis=0) - first.points.mean(axis=0), first.points
    else:
        facing = first.normals[touching[0]].mean(axis=0) - second.normals[touching[1]].mean(axis=0)
        around = first.points[touching[0]]
    length = np.linalg.norm(facing)
    facing = facing / length if length > render.MIN_MEAN_NORMAL else np.array([0.0, 0.0, 1.0])
    up = principal_axes(around, facing)[0]
    return [np.array([np.cross(up, front), up, front]) for front in (facing, -facing)]


def side_by_side(surfaces: list[Surface], pages: list[np.ndarray], n_atoms: list[int]) -> Surface:
    """Join both partners to one surface, the pages of an open book; `n_atoms` are those with a label, 0 for none."""
    points = [surface.points @ page.T for surface, page in zip(surfaces, pages, strict=True)]
    middles = [(x.min(axis=0) + x.max(axis=0)) / 2 for x in points]
    shift = (np.ptp(points[0][:, 0]) + np.ptp(points[1][:, 0])) / 2 + GAP_OF_PAGES
    points = [points[0] - middles[0], points[1] - middles[1] + [shift, 0, 0]]
    normals = [surface.normals @ page.T for surface, page in zip(surfaces, pages, strict=True)]
    atoms = [
        np.where((surface.atom < 0) | (n == 0), -1, surface.atom + before)
        for surface, n, before in zip(surfaces, n_atoms, (0, n_atoms[0]), strict=True)
    ]
    kind = np.concatenate([surface.kind for surface in surfaces])
    return Surface(np.concatenate(points), np.concatenate(normals), kind=kind, atom=np.concatenate(atoms))


@styled
def over_pairs(run: str, table: pd.DataFrame) -> Figure:
    """Draw AUC of every score, from the highest mean down: a dot for each pair, and the mean with its 95 % interval."""
    means = means_over_pairs(table).sort_values("mean")
    figure = layout.constrained(layout.COLUMN + 50, 24 + 7 * len(means), _of_all(means) or run)
    ax = figure.subplots()
    aucs = table.groupby(["score", "complex"], sort=False)["auc"].mean()
    for y, row in enumerate(means.to_dict("records")):
        of_pairs = aucs[row["score"]]
        ax.plot(of_pairs, np.full(len(of_pairs), y), ".", color="#999999", markersize=3)
        ax.plot([row["low"], row["high"]], [y, y], color="black", linewidth=1.2)
        ax.plot(row["mean"], y, "o", color=INTERFACE_COLOUR, markersize=4)
    ax.axvline(0.5, color="black", linewidth=0.5, linestyle=":")
    ax.set_yticks(range(len(means)), means["score"].replace(SCORE_STYLES))
    ax.set(xlabel="AUC for the interface (0.5: a coin)", xlim=(0, 1), ylim=(-0.6, len(means) - 0.4))
    mean: dict[str, Any] = {"color": "black", "marker": "o", "mfc": INTERFACE_COLOUR, "mec": INTERFACE_COLOUR}
    handles = [
        Line2D([], [], color="#999999", marker=".", linestyle="", label="each pair"),
        Line2D([], [], **mean, label="mean with its 95 % interval"),
    ]
    figure.legend(handles=handles, loc="outside lower right", ncols=2)
    return layout.fix_layout(figure)


def _of_all(means: pd.DataFrame) -> str:
    """Say how well complementarity finds the interfaces, next to protrusion; empty for fewer than two pairs."""
    by_score = means[means["complexes"] > 1].set_index("score")
    parts = {MAIN_SCORE: "AUC of complementarity", BASELINE: "of protrusion"}
    aucs = {label: auc_of(by_score, score, "mean") for score, label in parts.items()}
    return ", ".join(f"{label} {auc}" for label, auc in aucs.items() if auc)
