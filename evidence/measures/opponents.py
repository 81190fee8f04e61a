"""Other ways to store a surface in few numbers, at equal bytes.

A dot with its normal takes 24 bytes (six float32). A mesh takes 12 for a corner and 6 for a triangle (three indices of two
bytes, for up to 65,536 corners): with two triangles per corner this is 24 again, so that equal numbers mean equal bytes. An atom
takes 16, a place and a radius.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from sparsurf_study.workflow.jobs import Job
from measures import rebuilding, recovery
from measures.molecules import atoms_of, dotted_surface
from measures.rebuilding import Rebuilder, Simplifier
from measures.recovery import Truth, angles, distances, truth
from measures.tables import read_tables, write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.index import build_grid, build_index, select_separated
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, TAIL_QUANTILE, distance_to_surface
from sparsurf.recovery.interpolated_surface import MIN_DOT_SEPARATION, interpolate_surface
from sparsurf.sampling.samplers import get_sampler
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.components import components_of, on_cavities
from sparsurf.surfaces.mesh import Mesh
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.triangulation import molecular_mesh

DOT, VERTEX, TRIANGLE, ATOM = 24, 12, 6, 16  # bytes
CANDIDATES = 8  # positions on a mesh per dot that is placed on it
SAMPLE = 3  # errors are seen from every third dense dot of the true surface
STEADY, STEADY_TESTS, FLOOR_DRAWS = "rotation_robust", 200, 2  # the second descriptor, and its floor
KEPT, UNIFORM, MESH, CORNERS, ATOMS = (
    "farthest dots",
    "random dots",
    "decimated mesh",
    "its corners on the surface",
    "atoms",
)
SIDES = ("there", "there_99", "there_most", "back", "back_99", "back_most")
MEASURES = ("bytes", "Z", "steady_over_floor", "distance", "distance_99", "largest", "angle", *SIDES)
MAX_ATOMS_FOR_MESHES = 3_000  # meshes of larger structures take minutes each
COMPARED = (UNIFORM, MESH, CORNERS, *rebuilding.rebuilders())
PAIRED = ("Z", "distance", "distance_99", "largest", "back_most", "angle")
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
) -> pd.DataFrame:
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
    DataFrame: protein, sampler (the opponent), percent, n_S and `MEASURES`, see `two_sided`; steady_over_floor is the error by
    the descriptor `STEADY` over that of fresh dots
    """
    surface = molecular_surface(xyz, radii)
    flat = np.zeros(len(surface))
    prepared = PreparedSurface(surface, Settings(), flat, Streams(seed, name), threads)
    tests, true, rows = prepared.draw_tests(n_tests), truth(xyz, radii), []
    z_tot, _ = prepared.describe(tests)
    mesh = None if simplify is None else molecular_mesh(xyz, radii)
    component = components_of(surface, xyz, radii)
    outside = ~on_cavities(surface, component)
    at = cKDTree(surface.points).query(true.points)[1]  # the dot of the surface next to each dense one
    steady = prepared.with_descriptor(STEADY)
    z_steady, _ = steady.describe(tests[:STEADY_TESTS])
    outer = outside[at]

    def steady_z(dots: tuple[np.ndarray, np.ndarray]) -> float:
        index = build_index(*dots, steady.patches.d_link)
        return steady.distances_to_index(index, tests[:STEADY_TESTS], z_steady)[0].mean()

    stream = prepared.stream("recovery", "fresh dots")
    floor = np.mean([steady_z(dotted_surface(xyz, radii, len(surface), stream)) for _ in range(FLOOR_DRAWS)])

    def add(percent: float, way: Way) -> None:
        opponent, n, size, lay, n_kept = way
        z = prepared.distances_to_index(build_index(*lay(DENSITY), prepared.patches.d_link), tests, z_tot)[
            0
        ].mean()
        dense = lay(DENSITY_FOR_ERRORS)
        measured = two_sided(*(dots[n_kept:] for dots in dense), true, outer, threads)
        row = {"protein": name, "sampler": opponent, "percent": percent, "n_S": n, "bytes": size, "Z": z}
        if opponent == KEPT:
            row["steady_over_floor"] = steady_z(lay(DENSITY)) / floor
        rows.append(row | measured)

    for percent in percents:
        n = max(4, round(percent / 100 * len(surface)))
        for way in _of_size(prepared, n, mesh, simplify, rebuilders, true):
            add(percent, way)
    stream = prepared.stream("recovery", "atoms")
    add(
        100 * len(xyz) / len(surface),
        (ATOMS, len(xyz), ATOM * len(xyz), _dotted(xyz, radii, len(surface), stream), 0),
    )
    return pd.DataFrame(rows)


def _dotted(
    xyz: np.ndarray, radii: np.ndarray, n: int, stream: np.random.Generator
) -> Callable[[float], tuple[np.ndarray, np.ndarray]]:
    """Return the function (density) -> dots that the atoms give, n of them at the usual density."""
    return lambda density: dotted_surface(xyz, radii, round(density / DENSITY * n), stream)


def two_sided(
    points: np.ndarray, normals: np.ndarray, true: Truth, outer: np.ndarray, threads: int = 1
) -> dict[str, float]:
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
    """
    near = true.tree.query(points)[1]
    counted = outer[near]
    gap = distance_to_surface(true.points[outer][::SAMPLE], points, normals, threads, true.rolled)
    sides = {}
    for side, values in (("there", distances(points[counted], true)), ("back", gap)):
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
    return larger | {"angle": angle} | sides


def _of_size(
    prepared: PreparedSurface,
    n: int,
    mesh: Mesh | None,
    simplify: Simplifier | None,
    rebuilders: Mapping[str, Rebuilder],
    true: Truth,
) -> Iterator[Way]:
    """Yield each method at n dots or corners."""
    points, normals = prepared.points, prepared.normals
    stream = partial(prepared.stream, "recovery")

    def recovered(name: str, dots: tuple[np.ndarray, np.ndarray]) -> Way:
        return name, len(dots[0]), DOT * len(dots[0]), partial(interpolate_surface, *dots), len(dots[0])

    def chosen(sampler: str) -> tuple[np.ndarray, np.ndarray]:
        subset = get_sampler(sampler)(prepared, n, stream(sampler))
        return points[subset], normals[subset]

    kept = chosen("farthest")
    yield recovered(KEPT, kept)
    yield recovered(UNIFORM, chosen("uniform"))
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


def in_common(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the methods with a chosen number of dots, on the structures that have all methods."""
    surfaces = table[table["sampler"] != ATOMS]
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
        index, np.arange(len(points)), MIN_DOT_SEPARATION / np.sqrt(density), len(points), 0
    )
    return points[chosen], normals[chosen]


def measure_opponents(job: Job) -> None:
    """Measure other ways to store the surface of one structure in as many bytes; meshes need the package pymeshlab."""
    xyz, radii = atoms_of(job.input.structure)
    meshes = len(xyz) <= MAX_ATOMS_FOR_MESHES and rebuilding.installed()
    simplify, methods = (rebuilding.simplify, rebuilding.rebuilders()) if meshes else (None, {})
    measure(
        job.wildcards.protein,
        xyz,
        radii,
        simplify,
        methods,
        job.params.test_dots,
        job.params.percents,
        job.params.seed,
        job.threads,
    ).to_csv(job.output.table, index=False)


def tabulate_opponents(job: Job) -> None:
    """Tabulate other ways to store a surface over all structures: means with intervals, and pairs."""
    rows = read_tables(job.input.opponents)
    common = in_common(rows)
    atoms = rows[rows["sampler"] == ATOMS].assign(percent=0)  # another share on each structure
    measured = set(common["sampler"])
    pairs = [recovery.paired(common, way, KEPT, PAIRED) for way in COMPARED if way in measured]
    write_tables(
        {
            job.output.recover_opponents: rows,
            job.output.recover_opponents_means: recovery.means(pd.concat([common, atoms]), MEASURES),
            job.output.recover_opponents_pairs: pd.concat(pairs, ignore_index=True),
        }
    )
