"""Figures of pairs: both partners opened like a book, maps from few centres, and AUC over all pairs."""

from __future__ import annotations

from collections.abc import Sequence
from string import ascii_uppercase
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import colors
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullFormatter

from sparsurf.orientation import principal_axes
from sparsurf.report.figures import layout, render
from sparsurf.report.figures.layout import LINES, SPARE, styled
from sparsurf.report.numbers import interval, number
from sparsurf.report.pair_page import MAIN_SCORE, main_and_baseline, means_by_score, side_of
from sparsurf.report.pair_page import called as called_score
from sparsurf.sampling.samplers import sampler_label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf.report.figures.render import Camera
    from sparsurf.surfaces.surface import Surface

INSIDE, OUTSIDE = "#D55E00", "#DDDDDD"  # of the interface
PAGE_WIDTH, PAGE_HEIGHT = 78, 62  # mm, of a partner
PANELS = [("correlation", "correlation with the map\nof all dots"), ("auc", "AUC of the smoothed map")]
AGAINST = [("n_S_percent", "centres (% of the dots)"), ("seconds", "CPU seconds for both sides")]
ABSENT = "none: the partners do not touch\n(or touch everywhere)"  # dots inside and outside of the interface
RECOVERED = (0, (3, 1.5))  # dashes of maps whose patches are cut from the surface recovered from the centres


@styled
def book_figure(
    name: str, surfaces: Sequence[Surface], tables: Sequence[pd.DataFrame], agreement: pd.DataFrame
) -> Figure:
    """Draw smoothed propensity above, the interface below (or smoothed similarity if the partners do not touch).

    Parameters
    ----------
    name : str
    surfaces : two Surface
    tables : two DataFrames, the rows of propensity.csv of each partner
    agreement : DataFrame of agreement.csv; empty if the partners do not touch

    Returns
    -------
    matplotlib.figure.Figure
    """
    touching = [table["interface"].to_numpy() == 1 for table in tables]
    both = all(mask.any() for mask in touching)
    pages = opened(surfaces, touching)
    cameras = [
        render.aim(surface.points, page, layout.pixels(PAGE_WIDTH, PAGE_HEIGHT))
        for surface, page in zip(surfaces, pages, strict=True)
    ]
    scale = min(camera.scale for camera in cameras)
    cameras = [camera._replace(scale=scale) for camera in cameras]
    sides = [side_of(side, rows) for side, rows in agreement.groupby("partner")]
    figure = layout.sheet(layout.PAGE, 148, layout.headed(name, where_matches_lie(sides)))
    auc = {side["side"]: f": AUC {interval(side['auc'], side['low'], side['high'])}" for side in sides}
    for side in (1, 2):
        words = f"partner {side}, seen from partner {3 - side}{auc.get(side, '')}"
        layout.text(figure, 4 + (side - 1) * (PAGE_WIDTH + 2), 1, words)
    _row(
        figure,
        7,
        surfaces,
        cameras,
        tables,
        "propensity_smoothed",
        "rank of the smoothed\ndistance of patches (%)\n(low: good match)",
    )
    if both:
        for side in (0, 1):
            colour = np.where(touching[side][:, None], colors.to_rgb(INSIDE), colors.to_rgb(OUTSIDE))
            _page(figure, side, 77, surfaces[side], colour, cameras[side])
        layout.text(figure, 162, 80, "interface: dots\nclose to the\nother partner", color=INSIDE)
    else:
        _row(
            figure,
            77,
            surfaces,
            cameras,
            tables,
            "similarity_smoothed",
            "rank of the smoothed similarity\n(%; low: alike)",
        )
    return figure


def where_matches_lie(sides: Sequence[dict[str, Any]]) -> str:
    """Say whether matching patches lie at the interface, by the AUC of each partner; see `pair_page.side_of`."""
    at = [side["side"] for side in sides if side["place"] == "above"]
    if not sides:
        return ""
    if len(at) == len(sides):
        return "matching patches lie at the interface"
    if at:
        return f"matching patches lie at the interface of partner {at[0]} only"
    if all(side["place"] == "below" for side in sides):
        return "matching patches lie away from the interface"
    away = "".join(
        f", and lie away from it on partner {side['side']}" for side in sides if side["place"] == "below"
    )
    return f"matching patches do not mark the interface{away}"


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
    layout.show(
        layout.axes(figure, 2 + side * (PAGE_WIDTH + 2), y, PAGE_WIDTH, PAGE_HEIGHT),
        render.picture(scene),
        camera,
    )


def opened(surfaces: Sequence[Surface], touching: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return rotations that look at each partner from the other, with a common upright hinge between the pages.

    Parameters
    ----------
    surfaces : two Surface
    touching : two (N,) bool
        The interface; if a partner has none, they face each other along the line between their centres.

    Returns
    -------
    two (3, 3) float64, rows point right, up and to the viewer
    """
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


@styled
def over_pairs(run: str, table: pd.DataFrame, means: pd.DataFrame) -> Figure:
    """Draw AUC of every score, from the highest mean down: a dot for each pair, and the mean with its 95 % interval.

    A single pair has no interval of its mean: then there is a dot for each partner, with its interval.

    Parameters
    ----------
    run : str, the title if no pair touches
    table, means : DataFrames of pairs.csv and means.csv

    Returns
    -------
    matplotlib.figure.Figure
    """
    means = means.sort_values("mean")
    single = table["complex"].nunique() == 1
    figure = layout.constrained(layout.COLUMN + 50, 24 + 7 * len(means), _of_all(means, single) or run)
    ax = figure.subplots()
    by = table.groupby(["score", "complex"], sort=False)["auc"].mean()
    for y, row in enumerate(means.to_dict("records")):
        of_pairs = by[row["score"]]
        if single:
            rows = table[table["score"] == row["score"]]
            heights = y + np.linspace(0.15, -0.15, len(rows))
            ax.hlines(heights, rows["low"], rows["high"], color="#999999", linewidth=0.8)
            of_pairs, y_pairs = rows["auc"], heights
        else:
            y_pairs = np.full(len(of_pairs), y)
        ax.plot(of_pairs, y_pairs, ".", color="#999999", markersize=3)
        ax.plot([row["low"], row["high"]], [y, y], color="black", linewidth=1.2)
        ax.plot(row["mean"], y, "o", color=INSIDE, markersize=4)
    ax.axvline(0.5, color="black", linewidth=0.5, linestyle=":")
    ax.set_yticks(range(len(means)), map(called_score, means["score"]))
    ax.set(xlabel="AUC for the interface (0.5: a coin)", xlim=(0, 1), ylim=(-0.6, len(means) - 0.4))
    grey = "each partner with its 95 % interval" if single else "each pair"
    mean = "their mean" if single else "mean with its 95 % interval"
    handles = [
        Line2D([], [], color="#999999", marker=".", linestyle="-" if single else "", label=grey),
        Line2D(
            [],
            [],
            color="black",
            marker="o",
            mfc=INSIDE,
            mec=INSIDE,
            linestyle="" if single else "-",
            label=mean,
        ),
    ]
    figure.legend(handles=handles, loc="outside lower right", ncols=2)
    return layout.fix_layout(figure)


def _of_all(means: pd.DataFrame, single: bool) -> str:
    """Say how well complementarity finds the interfaces, and the strongest baseline; empty if that was not measured."""
    by_score = means_by_score(means)
    if MAIN_SCORE not in by_score.index:
        return ""
    known = main_and_baseline(by_score, "mean")
    limits = "" if single else f" ({number(known['low'])} to {number(known['high'])})"
    opponent = f"{known['baseline'].split(' (')[0]} {number(known['baseline_auc'])}"
    return f"{'one pair: ' * single}AUC of smoothed complementarity {number(known['auc'])}{limits}, of {opponent}"


@styled
def thinning_figure(table: pd.DataFrame, subject: str) -> Figure:
    """Draw correlation and AUC (mean of both sides and all draws) against n_S and against cost.

    Parameters
    ----------
    table : DataFrame of `thinning.thinning`, or of many
    subject : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = layout.constrained(layout.PAGE, 124, subject)
    panels = figure.subplots(2, 2)
    mean = table.groupby(["sampler", "surface", "percent"], sort=False).mean(numeric_only=True).reset_index()
    whole, thin = mean[mean["sampler"] == "all"].iloc[0], mean[mean["sampler"] != "all"]
    handles = {}
    for row, (value, label) in enumerate(PANELS):
        for column, (against, axis) in enumerate(AGAINST):
            ax = panels[row, column]
            layout.panel_title(ax, ascii_uppercase[2 * row + column], "")
            for k, (key, rows) in enumerate(thin.groupby(["sampler", "surface"], sort=False)):
                sampler, surface = map(str, key)
                colour, width, marker = LINES.get(sampler, (SPARE[k % len(SPARE)], 0.8, "*"))
                dashes = RECOVERED if surface == "recovered" else "-"
                name = sampler_label(sampler) + (", recovered" if surface == "recovered" else "")
                style: dict[str, Any] = {
                    "color": colour,
                    "linewidth": width,
                    "marker": marker,
                    "linestyle": dashes,
                }
                rows = rows.sort_values(against)
                handles[name] = ax.plot(rows[against], rows[value], label=name, **style)[0]
            ax.set(xlabel=axis, ylabel=label if column == 0 else "")
            if mean[value].isna().all():
                ax.set(xticks=[], yticks=[])
                ax.text(0.5, 0.5, ABSENT, transform=ax.transAxes, ha="center", va="center")
                continue
            ax.set_xscale("log")
            if against == "seconds":
                ax.plot(whole["seconds"], whole[value], "k*", markersize=6)
                ax.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
                ax.xaxis.set_minor_formatter(NullFormatter())
            else:
                shown = sorted(thin["percent"].unique())
                ax.set_xticks(shown, [f"{x:g}" for x in shown])
                ax.minorticks_off()
                ax.axhline(whole[value], color="black", linewidth=0.5, linestyle=":")
    n_rows = 1 + int(
        (thin["surface"] == "recovered").any()
    )  # a column for each sampler, as it is and recovered
    figure.legend(
        handles=list(handles.values()),
        loc="outside lower left",
        ncols=min(4, -(-len(handles) // n_rows)),
        title="Both partners averaged. Dotted line and star: all dots as centres.",
        alignment="left",
    )
    return layout.fix_layout(figure)
