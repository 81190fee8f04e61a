"""What measurements of reconstructed surfaces share: the true surface, distances from it, and means and pairs over proteins."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

import sparsurf
from sparsurf_study.workflow.jobs import Job
from sparsurf.recovery.readings import comparable_density
from sparsurf.recovery.reconstructing import DENSITY_FOR_EXACT_ERRORS, reconstruct_twice
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.molecular_surface import RolledFrame, roll_spheres, rolled_atoms
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.views import layout
from sparsurf_study.analysis.relation import with_interval
from sparsurf_study.report.figures import subsets

TRUE_DENSITY = 60.0  # dots per Å^2 of the true surface, at which errors are measured


class Truth(NamedTuple):
    """Very dense dots of a surface, and the spheres below it, from which errors are measured.

    tree : scipy.spatial.cKDTree of the dots
    points, normals : (D, 3) float64, Å and unit vectors
    rolled : the spheres, with the probe rolled over them
    """

    tree: cKDTree
    points: np.ndarray
    normals: np.ndarray
    rolled: RolledFrame


def truth(xyz: np.ndarray, radii: np.ndarray) -> Truth:
    """Return the truth of a molecule's surface."""
    rolled = roll_spheres(xyz, radii, PROBE_RADIUS)
    dense = rolled.surface(TRUE_DENSITY)
    return Truth(cKDTree(dense.points), dense.points, dense.normals, rolled)


def distances(points: np.ndarray, true: Truth) -> np.ndarray:
    """Return the exact distance (M,), Å, of every dot from the true surface."""
    return np.abs(exact_distance(points, true.rolled))


def angles(normals: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return angles between unit vectors, row by row, degrees."""
    return np.degrees(np.arccos(np.clip(np.sum(normals * others, axis=1), -1, 1)))


def means(
    table: pd.DataFrame,
    measures: Sequence[str],
    groups: Sequence[str] = ("sampler", "percent"),
) -> pd.DataFrame:
    """Return means over proteins with 95 % intervals: the groups, n, and of each measure itself, `_low` and `_high`."""
    rows = []
    for group, part in table.groupby(list(groups), sort=False):
        row = dict(zip(groups, group, strict=True)) | {"n": len(part)}
        for measure in measures:
            row |= with_interval(measure, part[measure])
        rows.append(row)
    return pd.DataFrame(rows)


def paired(table: pd.DataFrame, first: str, second: str, measures: Sequence[str]) -> pd.DataFrame:
    """Return first sampler minus second, in %, over the proteins that have both: percent, measure, change, n."""
    rows = []
    for percent, part in table.groupby("percent", sort=False):
        by = part.set_index(["protein", "sampler"]).unstack("sampler")
        for measure in measures:
            change = 100 * (by[measure][first] / by[measure][second] - 1)
            rows.append(
                {"first": first, "second": second, "percent": percent, "measure": measure}
                | with_interval("change", change.dropna())
                | {"n": int(change.notna().sum())}
            )
    return pd.DataFrame(rows)


def draw_recovery(job: Job) -> None:
    """Draw the embedded example, the few dots that `minimal` keeps by default, and the surface rebuilt from these."""
    surface = sparsurf.surface(job.input.structure)
    few, density = sparsurf.minimal(surface), comparable_density(sparsurf.prepare(surface).density)
    back = reconstruct_twice(few.surface, density, few.reconstruction, job.threads, DENSITY_FOR_EXACT_ERRORS)
    gap = back.distances(surface.points, job.threads, rolled_atoms(surface.origin))
    figure = subsets.figure(
        surface,
        [("the dots that are kept, with normals", few.surface, layout.DARK)],
        subsets.recovered_from(surface.points, back.comparable, gap, "these"),
    )
    layout.save(figure, job.output.figure)
