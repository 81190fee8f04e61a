"""The frames of a trajectory in the plane of their first principal components."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import patheffects

from sparsurf.views import layout
from sparsurf.views.layout import styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Annotation
    from matplotlib.transforms import Bbox

MAX_NAMED_CONFORMATIONS = 24  # conformations; if there are more, none is named
MAX_COMPONENTS = 10  # The panel of explained variance shows so many.


def figure_of_tables(
    frames: pd.DataFrame,
    silhouette: pd.DataFrame,
    projection: pd.DataFrame,
    explained: pd.DataFrame,
    name: str,
) -> Figure:
    """Draw the tables of the frames of a protein, see `frames_projection`."""
    row_of_frame = pd.Series(range(len(projection)), index=projection["frame"])
    return frames_projection(
        projection[["pc1", "pc2"]].to_numpy(),
        projection["cluster"].to_numpy(),
        row_of_frame.loc[frames["frame"]].to_numpy(),
        frames["conformation"].tolist(),
        explained["explained"].to_numpy(),
        dict(zip(silhouette["K"], silhouette["silhouette"], strict=True)),
        name,
    )


@styled
def frames_projection(
    projection: np.ndarray,
    labels: np.ndarray,
    chosen: np.ndarray,
    names: Sequence[str],
    explained: np.ndarray,
    silhouettes: dict[int, float],
    name: str = "",
) -> Figure:
    """Draw frames, (F, k) Å, in the plane of the first two principal components, explained variance and silhouette.

    `labels` are the cluster of each frame, `chosen` and `names` the conformations. `explained`, by component, and `silhouettes`,
    by number of clusters, may be empty.
    """
    if np.ptp(projection, axis=0).max() == 0:
        figure = layout.sheet(layout.COLUMN, 8, name)
        layout.text(figure, 2, 1, "All frames are the same.")
        return figure
    silhouettes = {k: value for k, value in silhouettes.items() if np.isfinite(value)}  # none of one cluster
    width = layout.PAGE_WIDTH if len(silhouettes) else 136 if len(explained) else layout.COLUMN
    message = f"{len(chosen):,} of {len(projection):,} frames chosen"
    figure = layout.sheet(width, 66, layout.headed(name, message))
    plane = np.column_stack([projection, np.zeros((len(projection), 2))])[:, :2]
    ax = layout.axes(figure, 14, 7, 69, 49)
    _clusters(ax, plane, labels, np.asarray(chosen, int), names, explained)
    layout.letter(figure, 1, 1, "A")
    if len(explained):
        _explained(layout.axes(figure, 101, 7, 32, 49), 100 * np.asarray(explained)[:MAX_COMPONENTS])
        layout.letter(figure, 87, 1, "B")
    if len(silhouettes):
        _silhouettes(layout.axes(figure, 149, 7, 32, 49), silhouettes, len(np.unique(labels)))
        layout.letter(figure, 137, 1, "C")
    return figure


def _clusters(
    ax: Axes,
    plane: np.ndarray,
    labels: np.ndarray,
    chosen: np.ndarray,
    names: Sequence[str],
    explained: np.ndarray,
) -> None:
    """Draw the frames coloured by cluster, with the chosen ones ringed."""
    colour = np.array(layout.PALETTE)[np.unique(labels, return_inverse=True)[1] % len(layout.PALETTE)]
    ax.scatter(plane[:, 0], plane[:, 1], s=5, c=colour, alpha=0.5, linewidths=0)
    ring: dict[str, Any] = {"s": 22, "edgecolors": "black", "linewidths": 0.8, "zorder": 3}
    ax.scatter(plane[chosen, 0], plane[chosen, 1], c=colour[chosen], **ring)
    share = [f", {100 * e:.0f} % of the variance" for e in explained[:2]] + ["", ""]
    ax.set(xlabel=f"PC 1 (Å){share[0]}", ylabel=f"PC 2 (Å){share[1]}")
    ax.set_title("colours: clusters, ringed: chosen frames")
    ax.margins(0.1)
    if len(names) <= MAX_NAMED_CONFORMATIONS:
        _name_points(ax, plane, plane[chosen], names)


def _name_points(ax: Axes, plane: np.ndarray, points: np.ndarray, names: Sequence[str]) -> None:
    """Write each name where it hides the fewest frames, at the nearest such position free of other names and chosen points."""
    inside, dots, frames = (
        ax.get_window_extent(),
        ax.transData.transform(points),
        ax.transData.transform(plane),
    )
    offsets = [
        (far, angle) for far in (8.0, 14.0, 22.0, 32.0) for angle in np.radians(np.arange(45, 405, 45))
    ]
    taken: list[Bbox] = []
    for point, name in zip(points, names, strict=True):
        free: list[tuple[int, float, float, Bbox]] = []
        for far, angle in offsets:
            annotation = _annotate(ax, name, point, far, angle)
            box = annotation.get_window_extent()
            annotation.remove()
            inner = inside.fully_containsx(box.x0) and inside.fully_containsx(box.x1)
            inner = inner and inside.fully_containsy(box.y0) and inside.fully_containsy(box.y1)
            if inner and not box.count_contains(dots) and not box.count_overlaps(taken):
                free.append((box.count_contains(frames), far, angle, box))
        if free:  # without a free position there is no name
            _, far, angle, box = min(free, key=lambda place: place[:2])
            taken.append(box)
            _annotate(ax, name, point, far, angle)


def _annotate(ax: Axes, name: str, point: np.ndarray, far: float, angle: float) -> Annotation:
    """Write a name at `far` typographic points from a point, with a leader line unless it is the closest position."""
    leader = {"arrowstyle": "-", "linewidth": 0.4, "shrinkA": 3, "shrinkB": 2} if far > 8 else None
    middle: dict[str, Any] = {"textcoords": "offset points", "ha": "center", "va": "center", "zorder": 4}
    offset = far * np.cos(angle), far * np.sin(angle)
    annotation = ax.annotate(name, (point[0], point[1]), offset, arrowprops=leader, **middle)
    annotation.set_path_effects([patheffects.withStroke(linewidth=1.5, foreground="white")])
    return annotation


def _silhouettes(ax: Axes, silhouettes: dict[int, float], chosen: int) -> None:
    """Draw the mean silhouette against the number of clusters."""
    k = sorted(silhouettes)
    ax.plot(k, [silhouettes[n] for n in k], "o-", color="black", markerfacecolor="white")
    if chosen in silhouettes:
        ax.plot([chosen], [silhouettes[chosen]], "o", color=layout.SAMPLED, markersize=5)
        ax.set_title(f"K = {chosen} chosen", color=layout.SAMPLED)
    ax.set(xlabel="number of clusters K", ylabel="mean silhouette")
    ax.margins(0.08, 0.12)
    layout.ticks(ax.xaxis, np.arange(k[0], k[-1] + 1), 32)


def _explained(ax: Axes, percent: np.ndarray) -> None:
    """Draw the explained variance of each component and the cumulative one."""
    k = np.arange(1, len(percent) + 1)
    ax.bar(k, percent, color=["#7F7F7F" if n <= 2 else "#D9D9D9" for n in k], edgecolor="black", label="each")
    ax.plot(k, np.cumsum(percent), "ko-", markerfacecolor="white", clip_on=False, label="cumulative")
    ax.set(xlabel="principal component", ylabel="explained variance (%)", ylim=(0, 100))
    ax.set_xlim(0.3, max(len(k), 3) + 0.7)
    ax.legend(
        loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, borderpad=0, handlelength=1.2, columnspacing=1
    )
    layout.ticks(ax.xaxis, k, 32)
