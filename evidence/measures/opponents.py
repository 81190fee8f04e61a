"""Other ways to store a surface in few numbers, at equal bytes, each in its best form.

A dot with its normal takes 24 bytes (six float32); rounded, 8: three places of 16 bits, .005 Å apart, and a normal of 16
bits. A mesh takes 12 for a corner and 6 for a triangle (three indices of two bytes, for up to 65,536 corners): with two
triangles per corner this is 24 again, so that equal numbers mean equal bytes. An atom takes 16, a place and a radius; rounded, 6:
three places of 15 bits and the number of its radius.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from measures.rebuilding import Rebuilder, Simplifier
from measures.recovery import Truth, angles, nearest, truth
from sparsurf.patches.index import build_grid, build_index, select_separated
from sparsurf.recovery.errors import (
    DENSITY_FOR_ERRORS,
    TAIL_QUANTILE,
    curvature,
    distance_to_surface,
    error_table,
)
from sparsurf.recovery.recovering import MIN_SEPARATION, recover
from sparsurf.recovery.relaxation import relax
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.comparison.methods import dotted_surface
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.components import components_of, table_of_components
from sparsurf.surfaces.mesh import Mesh, molecular_mesh
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.spacing import DENSITY

DOT, ROUNDED_DOT, VERTEX, TRIANGLE, ATOM, ROUNDED_ATOM = 24, 8, 12, 6, 16, 6  # bytes
STEP, ANGLES, BOX = 0.005, 2**8 - 1, 2**15 - 1  # Å; steps of a normal's two numbers; of a place in the box
CANDIDATES = 8  # positions on a mesh per dot that is placed on it
TRIES = 8  # orientations of the molecule for sparse dots
MORE = 1.1  # factor on the requested number of dots if there are too few
FIRST_SHARE, ROUNDS = (
    0.7,
    8,
)  # of the dots are farthest dots; the others come in rounds, where the surface is worst
WORST_DENSITY, WORST_SEPARATION = 10.0, 0.5  # dots per Å^2 that show where; of the new dots, in mean spacings
SAMPLE = 3  # errors are seen from every third dense dot of the true surface
TURN_RADIUS = 1.5  # Å; a turn is sharp if normals this close differ by more than 90°
SHARP = "sharp turns"
STEADY, STEADY_TESTS, FLOOR_DRAWS = (
    "rotation_robust",
    200,
    2,
)  # the second descriptor that sees farthest dots, its floor
WORST_QUANTILE = 0.999  # of the distances, from which on a place counts as one of the worst
(
    KEPT,
    UNIFORM,
    SETTLED,
    WORST,
    WORST_SETTLED,
    SPARSE,
    MESH,
    CORNERS,
    QUANTISED,
    ROUNDED,
    ATOMS,
    ROUNDED_ATOMS,
) = (
    "farthest dots",
    "uniform dots",
    "relaxed dots",
    "farthest, then worst",
    "farthest, then worst, relaxed",
    "sparsely placed dots",
    "decimated mesh",
    "its corners on the surface",
    "three times as many, rounded",
    "farthest dots, rounded",
    "atoms",
    "atoms, rounded",
)
SIDES = ("there", "there_99", "there_most", "back", "back_99", "back_most")
MEASURES = ("bytes", "Z", "steady_over_floor", "distance", "distance_99", "largest", "angle", *SIDES)
# A way to keep a surface: its name, number of dots or corners, bytes, a function (density) -> dense dots, and how many
# of these are kept ones, which come first
Way = tuple[str, int, int, Callable[[float], tuple[np.ndarray, np.ndarray]], int]


def measure(
    name: str,
    xyz: np.ndarray,
    radii: np.ndarray,
    simplify: Simplifier | None,
    rebuilders: Mapping[str, Rebuilder],
    n_tests: int,
    percents: Sequence[float],
    seed: int = 20261120,
    threads: int = 1,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Measure Z and errors of each method, all on one set of test dots.

    Parameters
    ----------
    name : str
    xyz, radii : (A, 3) and (A,), Å
    simplify : callable or None
        (vertices, triangles, number of triangles) -> fewer of them; without it no mesh takes part.
    rebuilders : dict of callables
        (points, normals) -> vertices and triangles of a surface through the same dots, by name.
    n_tests : int
    percents : sequence of float
    seed, threads : int

    Returns
    -------
    two DataFrames: protein, sampler (the opponent), percent, n_S and `MEASURES`, see `two_sided`; steady_over_floor is the error
    by the descriptor `STEADY` over that of fresh dots; and protein, sampler,
    percent and the columns of `errors.error_table` for the places of the true surface in clefts, on flats, on ridges and
    at sharp turns, with worst_percent, the share of the worst places that lie at sharp turns
    """
    surface = molecular_surface(xyz, radii)
    flat = np.zeros(len(surface))
    prepared = PreparedSurface(surface, roughness_values=flat, seed=seed, name=name, threads=threads)
    tests, true, rows, where = prepared.draw_tests(n_tests), truth(xyz, radii, prepared.area), [], []
    z_tot, _ = prepared.describe(tests)
    mesh = None if simplify is None else molecular_mesh(xyz, radii, threads=threads)
    component = components_of(surface, xyz, radii)
    outside = ~table_of_components(surface, component)["cavity"].to_numpy()[component]
    at = cKDTree(surface.points).query(true.points)[1]  # the dot of the surface next to each dense one
    steady = PreparedSurface(
        surface, roughness_values=flat, seed=seed, name=name, threads=threads, descriptor=STEADY
    )
    z_steady, _ = steady.describe(tests[:STEADY_TESTS])
    bend, sharp = curvature(prepared.index, threads=threads)[at], _sharp(surface.points, surface.normals)[at]
    outer = outside[at]

    def steady_z(dots: tuple[np.ndarray, np.ndarray]) -> float:
        index = build_index(*dots, steady.d_link)
        return steady.distances_to_index(index, tests[:STEADY_TESTS], z_steady)[0].mean()

    stream = prepared.stream("recovery", "fresh dots")
    floor = np.mean([steady_z(dotted_surface(xyz, radii, len(surface), stream)) for _ in range(FLOOR_DRAWS)])

    def add(percent: float, way: Way) -> np.ndarray:
        opponent, n, size, lay, n_kept = way
        z = prepared.distances_to_index(build_index(*lay(DENSITY), prepared.d_link), tests, z_tot)[0].mean()
        dense = lay(DENSITY_FOR_ERRORS)
        measured, gap = two_sided(*(dots[n_kept:] for dots in dense), true, outer, threads)
        row = {"protein": name, "sampler": opponent, "percent": percent, "n_S": n, "bytes": size, "Z": z}
        if opponent == KEPT:
            row["steady_over_floor"] = steady_z(lay(DENSITY)) / floor
        rows.append(row | measured)
        return gap

    for percent in percents:
        n = max(4, round(percent / 100 * len(surface)))
        for way in _of_size(prepared, xyz, radii, n, mesh, simplify, rebuilders, true):
            gap, seen = add(percent, way), np.flatnonzero(outer)[::SAMPLE]
            table = _where(gap, bend[seen], sharp[seen])
            where.append(table.assign(protein=name, sampler=way[0], percent=percent))
    for opponent, size, places in ((ATOMS, ATOM, xyz), (ROUNDED_ATOMS, ROUNDED_ATOM, rounded_places(xyz))):
        stream, share = prepared.stream("recovery", "atoms"), 100 * len(xyz) / len(surface)

        def dotted(
            density: float, places: np.ndarray = places, stream: np.random.Generator = stream
        ) -> tuple:
            return dotted_surface(places, radii, round(density / DENSITY * len(surface)), stream)

        add(share, (opponent, len(xyz), size * len(xyz), dotted, 0))
    return pd.DataFrame(rows), pd.concat(where)


def two_sided(
    points: np.ndarray, normals: np.ndarray, true: Truth, outer: np.ndarray, threads: int = 1
) -> tuple[dict[str, float], np.ndarray]:
    """Measure the errors of dense dots in both directions, without cavities: not every method gives these back.

    Parameters
    ----------
    points, normals : (M, 3), Å and unit vectors
    true : Truth
    outer : (D,) bool, the true dots that are not in cavities
    threads : int

    Returns
    -------
    dict: mean, 99 % quantile and largest distance of the dots from the true surface (`there`, `there_99`, `there_most`)
        and of places of the true surface from that of the dots (`back`, ...), Å; `distance`, `distance_99` and `largest`,
        the larger of both; and the mean `angle` of the normals, degrees
    (K,) float64 : distances of the places of the true surface, every `SAMPLE`-th of `outer`
    """
    distance, near = nearest(points, true)
    counted = outer[near]
    gap = distance_to_surface(true.points[outer][::SAMPLE], points, normals, threads)
    sides = {}
    for side, values in (("there", distance[counted]), ("back", gap)):
        sides |= {
            side: values.mean(),
            f"{side}_99": np.quantile(values, TAIL_QUANTILE),
            f"{side}_most": values.max(),
        }
    larger = {
        key: max(sides[f"there{end}"], sides[f"back{end}"])
        for key, end in (("distance", ""), ("distance_99", "_99"), ("largest", "_most"))
    }
    angle = angles(normals[counted], true.normals[near[counted]]).mean()
    return larger | {"angle": angle} | sides, gap


def _sharp(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return whether the normal turns by more than 90° within `TURN_RADIUS` of each dot, (N,) bool."""
    pairs = cKDTree(points).query_pairs(TURN_RADIUS, output_type="ndarray")
    opposed = pairs[np.sum(normals[pairs[:, 0]] * normals[pairs[:, 1]], axis=1) < 0]
    sharp = np.zeros(len(points), bool)
    sharp[opposed.ravel()] = True
    return sharp


def _where(gap: np.ndarray, bend: np.ndarray, sharp: np.ndarray) -> pd.DataFrame:
    """Return `error_table` of places with their curvature, and a row for those at sharp turns with their share of the worst."""
    table = error_table(gap, bend)
    if not sharp.any():
        return table
    worst = gap >= np.quantile(gap, WORST_QUANTILE)
    row = error_table(gap[sharp], bend[sharp]).head(1)
    shares = {"dots_percent": 100 * sharp.mean(), "worst_percent": 100 * sharp[worst].mean()}
    return pd.concat([table, row.assign(where=SHARP, **shares)], ignore_index=True)


def farthest_then_worst(prepared: PreparedSurface, n: int, rng: np.random.Generator) -> np.ndarray:
    """Choose farthest-point dots, then in rounds those farthest from the surface recovered from the dots so far."""
    points, normals = prepared.points, prepared.normals
    subset = SAMPLERS["farthest"](prepared, round(FIRST_SHARE * n), rng)
    for size in np.linspace(len(subset), n, ROUNDS + 1).astype(int)[1:]:
        gap = distance_to_surface(
            points, *recover(points[subset], normals[subset], WORST_DENSITY, keep=False)
        )
        gap[subset] = 0.0
        separation = WORST_SEPARATION * np.sqrt(prepared.area / len(subset))
        order = np.argsort(-gap, kind="stable")
        new = select_separated(prepared.index, order, separation, size - len(subset), 0)
        subset = np.concatenate([subset, new])
    return subset


def _of_size(
    prepared: PreparedSurface,
    xyz: np.ndarray,
    radii: np.ndarray,
    n: int,
    mesh: Mesh | None,
    simplify: Simplifier | None,
    rebuilders: Mapping[str, Rebuilder],
    true: Truth,
) -> Iterator[Way]:
    """Yield each method at n dots or corners."""
    points, normals = prepared.points, prepared.normals
    stream = partial(prepared.stream, "recovery")

    def recovered(name: str, dots: tuple[np.ndarray, np.ndarray], size: int = DOT) -> Way:
        return name, len(dots[0]), size * len(dots[0]), partial(recover, *dots), len(dots[0])

    def chosen(subset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return points[subset], normals[subset]

    kept = chosen(SAMPLERS["farthest"](prepared, n, stream("farthest")))
    worst = chosen(farthest_then_worst(prepared, n, stream("farthest")))
    many = SAMPLERS["farthest"](prepared, min(3 * n, len(points)), stream("farthest"))
    yield recovered(KEPT, kept)
    yield recovered(UNIFORM, chosen(SAMPLERS["uniform"](prepared, n, stream("uniform"))))
    yield recovered(SETTLED, relax(*kept, points, normals, threads=prepared.threads))
    yield recovered(WORST, worst)
    yield recovered(WORST_SETTLED, relax(*worst, points, normals, threads=prepared.threads))
    yield recovered(ROUNDED, rounded(*kept), ROUNDED_DOT)
    yield recovered(QUANTISED, rounded(*chosen(many)), ROUNDED_DOT)
    yield recovered(SPARSE, sparse(xyz, radii, n, stream("sparse")))
    for name, rebuild in rebuilders.items():
        rebuilt = rebuild(*kept)
        if len(rebuilt[1]):
            yield name, n, DOT * n, partial(dots_on, *rebuilt, stream(name)), 0
    if mesh is None or simplify is None:
        return
    corners, triangles = simplify(mesh.vertices.points, mesh.triangles, 2 * n)
    size = VERTEX * len(corners) + TRIANGLE * len(triangles)
    yield MESH, len(corners), size, partial(dots_on, corners, triangles, stream("mesh")), 0
    _, near = true.tree.query(corners)
    yield recovered(CORNERS, (true.points[near], true.normals[near]))


def sparse(
    xyz: np.ndarray, radii: np.ndarray, n: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Generate a surface of n dots: take the orientation with the fewest dots above n, and remove those closest to others."""
    best, requested, tries = None, n, 0
    while best is None or tries < TRIES:
        dots, tries = dotted_surface(xyz, radii, requested, rng), tries + 1
        if len(dots[0]) < n:
            requested *= MORE
        elif best is None or len(dots[0]) < len(best[0]):
            best = dots
    kept = farthest_point_sampling(build_grid(best[0], side=1.0), n, rng)
    return best[0][kept], best[1][kept]


def rounded(points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the dots of 8 bytes: places on a grid of `STEP`, normals on an octahedron unfolded into a square of `ANGLES` steps.

    Source: Meyer et al., Computer Graphics Forum 29:1405, 2010.
    """
    flat = normals[:, :2] / np.abs(normals).sum(axis=1, keepdims=True)
    below = normals[:, 2] < 0
    flat[below] = _folded(flat[below])
    flat = 2 * np.round((flat + 1) / 2 * ANGLES) / ANGLES - 1
    height = 1 - np.abs(flat).sum(axis=1)
    back = np.column_stack([flat, height])
    back[height < 0, :2] = _folded(flat[height < 0])
    return STEP * np.round(points / STEP), back / np.linalg.norm(back, axis=1, keepdims=True)


def _folded(flat: np.ndarray) -> np.ndarray:
    """Return the other side of the octahedron, in the plane: (n, 2)."""
    return (1 - np.abs(flat[:, ::-1])) * np.where(flat < 0, -1.0, 1.0)


def rounded_places(xyz: np.ndarray) -> np.ndarray:
    """Return the places of atoms in steps of their box, of which 15 bits count along the longest side."""
    step = np.ptp(xyz, axis=0).max() / BOX
    return xyz.min(axis=0) + step * np.round((xyz - xyz.min(axis=0)) / step)


def in_common(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the methods with a chosen number of dots, on the structures that have all methods."""
    surfaces = table[~table["sampler"].isin((ATOMS, ROUNDED_ATOMS))]
    full = set(surfaces.loc[surfaces["sampler"] == MESH, "protein"]) or set(surfaces["protein"])
    return surfaces[surfaces["protein"].isin(full)]


def corner_normals(corners: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return unit normals at the corners of a mesh, (V, 3): the mean of those of the triangles around, by angle.

    Source: Thürmer & Wüthrich, J. Graphics Tools 3:43, 1998.
    """
    sides = corners[triangles]
    normals = np.zeros((len(corners), 3))
    flat = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
    for k in range(3):
        a, b = sides[:, (k + 1) % 3] - sides[:, k], sides[:, (k + 2) % 3] - sides[:, k]
        length = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
        angle = np.arccos(np.clip(np.sum(a * b, axis=1) / np.maximum(length, 1e-12), -1, 1))
        np.add.at(normals, triangles[:, k], angle[:, None] * flat)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def dots_on(
    corners: np.ndarray, triangles: np.ndarray, rng: np.random.Generator, density: float = DENSITY
) -> tuple[np.ndarray, np.ndarray]:
    """Place dots on a mesh, as far apart as recovered ones, with normals interpolated between those of the corners.

    Parameters
    ----------
    corners, triangles : (V, 3) float, Å, and (F, 3) int
    rng : numpy.random.Generator
    density : dots per Å^2

    Returns
    -------
    points, normals : (M, 3) float64
    """
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    n = int(CANDIDATES * density * area.sum())
    triangle = rng.choice(len(triangles), n, p=area / area.sum())
    u, v = rng.random((2, n))
    share = np.stack([1 - np.sqrt(u), np.sqrt(u) * (1 - v), np.sqrt(u) * v], axis=1)
    points = np.einsum("nk,nkc->nc", share, corners[triangles[triangle]])
    normals = np.einsum("nk,nkc->nc", share, corner_normals(corners, triangles)[triangles[triangle]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    index = build_grid(points, side=1.0)
    chosen = select_separated(
        index, np.arange(len(points)), MIN_SEPARATION / np.sqrt(density), len(points), 0
    )
    return points[chosen], normals[chosen]
