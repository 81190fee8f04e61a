"""Quality of surfaces recovered from subsets, over many proteins: errors, Z relative to the floors, means with intervals."""

import math
import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from measures.timing import peak_memory
from sparsurf.recovery.recovering import recover
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.floors import FEW_DRAWS, FRESH, floors_table, measure_floors
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.relation import with_interval
from sparsurf.surfaces.molecular_surface import molecular_surface

PERCENTS = (2.5, 5.0, 10.0, 20.0)
NAMES = ("farthest", "adaptive", "uniform", "roughness")
TRUE_DENSITY = 60.0  # dots per Å^2 of the true surface that errors are measured from
MAX_TRUE_DOTS = 20_000_000  # a ribosome gets fewer per Å^2
ERRORS = (
    "distance",
    "distance_95",
    "distance_99",
    "distance_most",
    "angle",
)  # mean, quantiles, largest; mean
TRUE_SAMPLE = 20_000  # recovered dots whose error is measured


class Truth(NamedTuple):
    """Very dense dots of a surface, from which errors are measured.

    tree : scipy.spatial.cKDTree of the dots
    points, normals : (D, 3) float64, Å and unit vectors
    spacing : float, 1 / sqrt(dots per Å^2), Å
    """

    tree: cKDTree
    points: np.ndarray
    normals: np.ndarray
    spacing: float


def measure(
    name: str,
    xyz: np.ndarray,
    radii: np.ndarray,
    n_tests: int = 400,
    percents: Sequence[float] = PERCENTS,
    names: Sequence[str] = NAMES,
    seed: int = 20261120,
    threads: int = 1,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Measure noise floors and subsets of one protein, all on one set of test dots.

    Parameters
    ----------
    name : str
    xyz, radii : (A, 3) and (A,), Å
    n_tests : int
    percents : sequence of float
    names : sequence of str, samplers
    seed, threads : int

    Returns
    -------
    two DataFrames: that of `floors.floors` with protein, N, area and atoms; and a row per sampler and n_S: Z_kept (as
    the dots are, islands removed on the full surface), Z (recovered), Z_over_floor, distance (Å, mean and 95 %
    quantile) and angle (degrees) of recovered dots to the true surface, dots (recovered), microseconds (CPU time of
    recovery per recovered dot, the least of three). The kept dots, which lie on the surface, do not count.
    """
    surface = molecular_surface(xyz, radii)
    prepared = PreparedSurface(surface, roughness_values=None, seed=seed, name=name, threads=threads)
    distances = measure_floors(
        prepared, n_tests, lambda places: molecular_surface(places, radii), xyz, draws=FEW_DRAWS
    )
    keys = {"protein": name, "N": len(surface), "area": prepared.area, "atoms": len(xyz)}
    floor = distances[FRESH].mean()
    true = truth(xyz, radii, prepared.area)
    tests, rows = prepared.draw_tests(n_tests), []
    z_tot, _ = prepared.describe(tests)
    for sampler in names:
        for percent in percents:
            n = max(4, round(percent / 100 * len(surface)))
            kept = SAMPLERS[sampler](prepared, n, prepared.stream("recovery", sampler))
            row = keys | {"sampler": sampler, "percent": percent, "n_S": n}
            for key, reading in (("Z_kept", "as_written"), ("Z", "recovered")):
                row[key] = prepared.distances([kept], tests, z_tot, reading)[0].mean()
            row["Z_over_floor"] = row["Z"] / floor
            rows.append(row | _quality(surface.points[kept], surface.normals[kept], true))
    return floors_table(distances).assign(**keys), pd.DataFrame(rows)


def truth(xyz: np.ndarray, radii: np.ndarray, area: float = 0.0) -> Truth:
    """Return the truth of a molecule's surface, of about `area` (Å^2)."""
    density = min(TRUE_DENSITY, MAX_TRUE_DOTS / max(area, 1.0))
    dense = molecular_surface(xyz, radii, density=density)
    return Truth(cKDTree(dense.points), dense.points, dense.normals, 1 / np.sqrt(density))


def _quality(points: np.ndarray, normals: np.ndarray, true: Truth) -> dict[str, float]:
    """Return the size, errors and cost of the surface recovered from dots; errors without these dots, which come first."""
    seconds = []
    for _ in range(3):
        begin = time.process_time()
        dots = recover(points, normals)
        seconds.append(time.process_time() - begin)
    new = errors(*(values[len(points) :] for values in dots), true)
    return new | {"dots": len(dots[0]), "microseconds": 1e6 * min(seconds) / len(dots[0])}


def distances(points: np.ndarray, true: Truth) -> np.ndarray:
    """Return the distance (M,), Å, of every dot from the true surface: along the normal of the nearest dense dot, unless
    that one lies farther than dense dots do."""
    return nearest(points, true)[0]


def nearest(points: np.ndarray, true: Truth) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances of `distances`, and the indices of the nearest dense dots, (M,)."""
    gap, near = true.tree.query(points)
    along = np.abs(np.sum((points - true.points[near]) * true.normals[near], axis=1))
    return np.where(gap > 2 * true.spacing, gap, along), near


def angles(normals: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return angles between unit vectors, row by row, degrees."""
    return np.degrees(np.arccos(np.clip(np.sum(normals * others, axis=1), -1, 1)))


def errors(points: np.ndarray, normals: np.ndarray, true: Truth) -> dict[str, float]:
    """Return `ERRORS` of dots against the surface that `truth` made: Å, and degrees for the angle."""
    sampled = slice(None, None, max(1, len(points) // TRUE_SAMPLE))
    distance, near = nearest(points[sampled], true)
    angle = angles(normals[sampled], true.normals[near]).mean()
    values = distance.mean(), *np.quantile(distance, (0.95, 0.99)), distance.max(), angle
    return dict(zip(ERRORS, values, strict=True))


def means(
    table: pd.DataFrame,
    measures: Sequence[str] = ("Z_kept", "Z", "Z_over_floor", *ERRORS, "microseconds"),
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


def dense_means(table: pd.DataFrame) -> pd.DataFrame:
    """Average the minimal subsets of dense surfaces over proteins.

    Returns
    -------
    DataFrame: hydrogens, requested_density, n (proteins), means of density, N, n_S and n_S_percent; how many times as
    many dots are needed if the surface is recovered at 5.35 dots per Å^2: geometric mean `times`, `fewest`, `most`
    """
    rows = []
    for (hydrogens, requested), part in table.groupby(["hydrogens", "requested_density"], sort=False):
        times = part["n_S_at_5.35"] / part["n_S"]
        row = {"hydrogens": hydrogens, "requested_density": requested, "n": len(part)}
        row |= {"density": part["density"].mean(), "N": part["N"].mean(), "n_S": part["n_S"].mean()}
        row |= {"n_S_percent": (100 * part["n_S"] / part["N"]).mean(), "times": np.exp(np.log(times).mean())}
        rows.append(row | {"fewest": times.min(), "most": times.max()})
    return pd.DataFrame(rows)


def paired(
    table: pd.DataFrame, first: str, second: str, measures: Sequence[str] = ("Z", "distance", "angle")
) -> pd.DataFrame:
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


def copies_of_a_tenth(xyz: np.ndarray, radii: np.ndarray, dots: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points and normals of farthest-point dots, a tenth, of copies of a molecule side by side that have `dots` in all."""
    surface = molecular_surface(xyz, radii)
    prepared = PreparedSurface(surface, roughness_values=np.zeros(len(surface)))
    kept = SAMPLERS["farthest"](prepared, len(surface) // 10, prepared.stream("cost"))
    points, copies = surface.points[kept], math.ceil(dots / len(surface))
    apart = [np.ptp(points[:, 0]) + 10.0, 0.0, 0.0]
    copied = [points + np.multiply(k, apart) for k in range(copies)]
    return np.concatenate(copied), np.tile(surface.normals[kept], (copies, 1))


def cost(points: np.ndarray, normals: np.ndarray) -> dict[str, float]:
    """Return CPU seconds for a million recovered dots, and the peak of memory for each, of a process that did nothing before."""
    recover(points[:1000], normals[:1000])
    before, begin = peak_memory(), time.process_time()
    n = len(recover(points, normals)[0])
    seconds = time.process_time() - begin
    return {"a_million_s": 1e6 * seconds / n, "bytes_per_dot": (peak_memory() - before) / n}
