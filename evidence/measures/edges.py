"""Where in a patch the paper's sampling keeps dots, and which of them are linked: at the edges, where a random subset is not."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from scipy.spatial import cKDTree

from sparsurf_study.workflow.jobs import Job
from measures import fragments
from measures.figures import reduce_figure
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.sampling.combination import Combination
from sparsurf.views import layout
from sparsurf.views.layout import styled
from sparsurf_study.paper.replication import GATHERED

SIDE = 14.0  # Å, of the part of the surface that is drawn
MIN_COSINE = 0.3  # of the normals of dots that are drawn with the direction of view
N_BINS = 10  # of the distance from the centre


def share_by_distance(prepared: PreparedSurface, kept: np.ndarray) -> np.ndarray:
    """Return the share of kept dots (%) of the patches by distance from their centre, in `N_BINS` parts of r_patch."""
    cover = prepared.cover
    ratio = np.exp(-cover.log_ratio)
    part = np.minimum((N_BINS * ratio).astype(int), N_BINS - 1)
    is_kept = np.isin(cover.dot, kept)
    return 100 * np.bincount(part, is_kept, N_BINS) / np.bincount(part, minlength=N_BINS)


def draw_part(ax: Axes, prepared: PreparedSurface, kept: np.ndarray, colour: str) -> None:
    """Draw the flattest part of the surface from above: its dots, the kept ones and their links, and patches with centres."""
    points, normals, cover = prepared.points, prepared.normals, prepared.cover
    middle = cover.centre[np.argmax(cover.roughness)]
    towards = normals[middle]
    right = np.cross(towards, np.eye(3)[np.argmin(np.abs(towards))])
    right /= np.linalg.norm(right)
    flat = (points - points[middle]) @ np.stack([right, np.cross(towards, right)], axis=1)
    depth = (points - points[middle]) @ towards
    shown = (np.abs(flat).max(axis=1) < SIDE / 2) & (normals @ towards > MIN_COSINE)
    shown &= np.abs(depth) < SIDE / 2
    seen = kept[shown[kept]]
    pairs = seen[cKDTree(points[seen]).query_pairs(prepared.patches.d_link, output_type="ndarray")]
    ax.scatter(*flat[shown].T, s=3, color="#CCCCCC", linewidths=0, zorder=1)
    ax.add_collection(LineCollection(flat[pairs], colors=colour, linewidths=1.4, zorder=2))
    ax.scatter(*flat[seen].T, s=9, color=colour, linewidths=0, zorder=3)
    for centre in cover.centre[shown[cover.centre]]:
        ax.add_patch(
            Circle(
                flat[centre], prepared.patches.r_patch, fill=False, color=layout.GREY, linestyle=":", zorder=4
            )
        )
        ax.plot(*flat[centre], "x", color="black", markersize=6, zorder=5)
    ax.set(xlim=(-SIDE / 2, SIDE / 2), ylim=(-SIDE / 2, SIDE / 2), xticks=[], yticks=[], aspect="equal")


@styled
def figure(prepared: PreparedSurface, combination: Combination) -> Figure:
    """Draw where in patches the paper's sampling and a random subset of the same size keep dots."""
    drawn = layout.constrained(layout.PAGE_WIDTH, 68)
    axes = drawn.subplots(1, 3)
    subsets = dict(zip(("sampled", "random subset"), prepared.pair(combination, 0), strict=True))
    edges = np.linspace(0, 1, N_BINS + 1)
    for ax, (name, kept), colour, letter in zip(
        axes, subsets.items(), (layout.SAMPLED, layout.RANDOM), "AB", strict=False
    ):
        draw_part(ax, prepared, kept, colour)
        layout.panel_title(ax, letter, f"{name}, {100 * len(kept) / len(prepared):.0f} %")
        axes[2].stairs(
            share_by_distance(prepared, kept), edges, color=colour, label=name, linewidth=1.6, baseline=None
        )
    axes[2].set(xlim=(0, 1), ylim=(0, 100))
    axes[2].set_xlabel("distance from the centre (patch radii)")
    axes[2].set_ylabel("kept dots (%)")
    axes[2].legend(loc="upper left")
    layout.panel_title(axes[2], "C", "Kept by distance")
    return layout.fix_layout(drawn)


def draw_edges(job: Job) -> None:
    """Draw where the dots that the first combination of Figure 5 keeps lie in the patches of the cover."""
    prepared = fragments.prepare(job.input.structure, job.params, "gathering", job.threads)
    layout.save(figure(prepared, Combination(*GATHERED[0])), job.output.figure)
    reduce_figure(job.output.figure, job.output.figure)
