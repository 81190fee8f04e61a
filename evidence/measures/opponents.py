"""Other ways to store a surface in few numbers, at equal bytes, each in its best form.

A dot with its normal takes 24 bytes (six float32); rounded, 8: three places of 16 bits, .005 Å apart, and a normal of 16
bits. A mesh takes 12 for a corner and 6 for a triangle (three indices of two bytes, for up to 65,536 corners): with two
triangles per corner this is 24 again, so that equal numbers mean equal bytes. An atom takes 16, a place and a radius; rounded, 6:
three places of 15 bits and the number of its radius.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np
import pandas as pd

from measures.recovery import ERRORS, Truth, errors, truth
from sparsurf.patches.index import build_grid, build_index, select_separated
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, curvature, distance_to_surface, error_table
from sparsurf.recovery.recovering import MIN_SEPARATION, recover
from sparsurf.recovery.relaxation import relax
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.comparison.methods import dotted_surface
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.mesh import Mesh, molecular_mesh
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.spacing import DENSITY

DOT, ROUNDED_DOT, VERTEX, TRIANGLE, ATOM, ROUNDED_ATOM = 24, 8, 12, 6, 16, 6  # bytes
STEP, ANGLES, BOX = 0.005, 2**8 - 1, 2**15 - 1  # Å; steps of a normal's two numbers; of a place in the box
CANDIDATES = 8  # positions on a mesh per dot that is placed on it
TRIES = 8  # orientations of the molecule for sparse dots
MORE = 1.1  # factor on the requested number of dots if there are too few
KEPT, SETTLED, SPARSE, MESH, CORNERS, QUANTISED, ROUNDED, ATOMS, ROUNDED_ATOMS = (
    "farthest dots",
    "settled dots",
    "sparsely laid dots",
    "decimated mesh",
    "its corners on the surface",
    "three times as many, rounded",
    "farthest dots, rounded",
    "atoms",
    "atoms, rounded",
)
MEASURES = ("bytes", "Z", *ERRORS)
# (vertices, triangles, number of triangles) -> vertices and triangles of a mesh with fewer of them
Simplifier = Callable[[np.ndarray, np.ndarray, int], tuple[np.ndarray, np.ndarray]]


def measure(
    name: str,
    xyz: np.ndarray,
    radii: np.ndarray,
    simplify: Simplifier | None,
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
    n_tests : int
    percents : sequence of float
    seed, threads : int

    Returns
    -------
    two DataFrames: protein, sampler (the opponent), percent, n_S, bytes, Z and `recovery.ERRORS`; and protein, sampler,
    percent and the columns of `errors.tails` for the dots of the surface itself, in clefts, on flats and on ridges
    """
    surface = molecular_surface(xyz, radii)
    flat = np.zeros(len(surface))
    evaluator = PreparedSurface(surface, roughness_values=flat, seed=seed, name=name, threads=threads)
    tests, true, rows, where = evaluator.draw_tests(n_tests), truth(xyz, radii, evaluator.area), [], []
    z_tot, _ = evaluator.describe(tests)
    bend = curvature(evaluator.index, threads=threads)
    mesh = None if simplify is None else molecular_mesh(xyz, radii, threads=threads)

    def add(opponent: str, percent: float, n: int, size: int, dots: tuple[np.ndarray, np.ndarray]) -> None:
        z = evaluator.distances_to_index(build_index(*dots, evaluator.d_link), tests, z_tot)[0].mean()
        row = {"protein": name, "sampler": opponent, "percent": percent, "n_S": n, "bytes": size, "Z": z}
        rows.append(row | errors(*dots, true))

    for percent in percents:
        n = max(4, round(percent / 100 * len(surface)))
        for opponent, number, size, lay in _of_size(evaluator, xyz, radii, n, mesh, simplify, true):
            add(opponent, percent, number, size, lay(DENSITY))
            gap = distance_to_surface(surface.points, *lay(DENSITY_FOR_ERRORS), threads)
            where.append(error_table(gap, bend).assign(protein=name, sampler=opponent, percent=percent))
    for opponent, size, places in ((ATOMS, ATOM, xyz), (ROUNDED_ATOMS, ROUNDED_ATOM, rounded_places(xyz))):
        turned = dotted_surface(places, radii, len(surface), evaluator.stream("recovery", "atoms"))
        add(opponent, 100 * len(xyz) / len(surface), len(xyz), size * len(xyz), turned)
    return pd.DataFrame(rows), pd.concat(where)


def _of_size(
    evaluator: PreparedSurface,
    xyz: np.ndarray,
    radii: np.ndarray,
    n: int,
    mesh: Mesh | None,
    simplify: Simplifier | None,
    true: Truth,
) -> Iterator[tuple[str, int, int, Callable]]:
    """Yield each method, its number of dots or corners, its bytes, and a function (density) -> dense dots."""
    points, normals = evaluator.points, evaluator.normals
    farthest = partial(SAMPLERS["farthest"], evaluator)
    chosen = farthest(n, evaluator.stream("recovery", "farthest"))
    kept = points[chosen], normals[chosen]
    yield KEPT, n, DOT * n, partial(recover, *kept)
    settled = relax(*kept, points, normals, threads=evaluator.threads)
    yield SETTLED, n, DOT * n, partial(recover, *settled)
    yield ROUNDED, n, ROUNDED_DOT * n, partial(recover, *rounded(*kept))
    many = farthest(min(3 * n, len(points)), evaluator.stream("recovery", "farthest"))
    dots = rounded(points[many], normals[many])
    yield QUANTISED, len(many), ROUNDED_DOT * len(many), partial(recover, *dots)
    few = sparse(xyz, radii, n, evaluator.stream("recovery", "sparse"))
    yield SPARSE, len(few[0]), DOT * len(few[0]), partial(recover, *few)
    if mesh is None:
        return
    corners, triangles = simplify(mesh.vertices.points, mesh.triangles, 2 * n)
    size = VERTEX * len(corners) + TRIANGLE * len(triangles)
    yield MESH, len(corners), size, partial(dots_on, corners, triangles, evaluator.stream("recovery", "mesh"))
    _, near = true.tree.query(corners)
    yield CORNERS, len(corners), DOT * len(corners), partial(recover, true.points[near], true.normals[near])


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
    """Dots of 8 bytes: places on a grid of `STEP`, normals on an octahedron unfolded into a square of `ANGLES` steps.

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
    """The other side of the octahedron, in the plane: (n, 2)."""
    return (1 - np.abs(flat[:, ::-1])) * np.where(flat < 0, -1.0, 1.0)


def rounded_places(xyz: np.ndarray) -> np.ndarray:
    """Places of atoms in steps of their box, of which 15 bits count along the longest side."""
    step = np.ptp(xyz, axis=0).max() / BOX
    return xyz.min(axis=0) + step * np.round((xyz - xyz.min(axis=0)) / step)


def in_common(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of the methods with a chosen number of dots, on the structures that have all methods."""
    surfaces = table[~table["sampler"].isin((ATOMS, ROUNDED_ATOMS))]
    full = set(surfaces.loc[surfaces["sampler"] == MESH, "protein"]) or set(surfaces["protein"])
    return surfaces[surfaces["protein"].isin(full)]


def simplifier() -> Simplifier | None:
    """Decimation by quadric error of the package fast-simplification; None where it is not installed."""
    try:
        from fast_simplification import simplify
    except ImportError:
        print("fast-simplification is not installed: no mesh takes part")
        return None

    def fewer(vertices: np.ndarray, triangles: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
        reduced = simplify(vertices.astype("float32"), triangles.astype("int32"), target_count=n)
        return reduced[0].astype(float), reduced[1].astype(int)

    return fewer


def corner_normals(corners: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals at the corners of a mesh, (V, 3): the mean of those of the triangles around, by angle.

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
