"""Other ways to keep a surface in few numbers, at equal bytes: dots moved off their places, a surface laid sparsely, a
decimated mesh, the atoms themselves.

A dot with its normal takes 24 bytes (six float32), a mesh 12 for a vertex and 6 for a triangle (three indices of two
bytes, for up to 65,536 vertices): with two triangles for every vertex also 24, so equal numbers are equal bytes.
"""

import numpy as np
import pandas as pd

from sparsurf.patches.index import apart, build_grid, build_index
from sparsurf.recovery.recovering import APART, recover
from sparsurf.recovery.settling import settle
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.recovery import errors, truth
from sparsurf.study.without_the_surface import dotted
from sparsurf.surfaces.making import molecular_surface
from sparsurf.surfaces.mesh import molecular_mesh
from sparsurf.surfaces.spacing import DENSITY

PERCENTS = (2.5, 5.0, 10.0)
DOT, VERTEX, TRIANGLE, ATOM = 24, 12, 6, 16  # bytes; an atom is its place and its radius
CANDIDATES = 8  # places on a mesh per dot that is laid on it
KEPT, SETTLED, SPARSE, MESH, CORNERS, ATOMS = (
    "farthest dots",
    "settled dots",
    "sparsely laid dots",
    "decimated mesh",
    "its corners with normals",
    "atoms",
)


def measure(name, xyz, radii, simplify=None, n_tests=400, percents=PERCENTS, seed=20261120, threads=1):
    """Z and errors of each opponent, all on one set of test dots.

    Parameters
    ----------
    name : str
    xyz, radii : (A, 3) and (A,), Å
    simplify : callable, optional
        (vertices, triangles, number of triangles) -> fewer of them; without it no mesh takes part.
    n_tests : int
    percents : sequence of float
    seed, threads : int

    Returns
    -------
    DataFrame: protein, sampler (the opponent), percent, n_S, bytes, Z, distance, distance_95, angle
    """
    surface = molecular_surface(xyz, radii)
    evaluator = Evaluator(
        surface, roughness_values=np.zeros(len(surface)), seed=seed, name=name, threads=threads
    )
    tests, true, rows = evaluator.draw_tests(n_tests), truth(xyz, radii, evaluator.area), []
    z_tot, _ = evaluator.describe(tests)
    mesh = None if simplify is None else molecular_mesh(xyz, radii, threads=threads)

    def add(opponent, percent, n, size, dots):
        z = evaluator.distances_of(build_index(*dots, evaluator.d_link), tests, z_tot)[0].mean()
        row = {"protein": name, "sampler": opponent, "percent": percent, "n_S": n, "bytes": size, "Z": z}
        rows.append(row | errors(*dots, true))

    for percent in percents:
        n = max(4, round(percent / 100 * len(surface)))
        chosen = SAMPLERS["farthest"](evaluator, n, evaluator.stream("recovery", "farthest"))
        kept = surface.points[chosen], surface.normals[chosen]
        add(KEPT, percent, n, DOT * n, recover(*kept))
        add(
            SETTLED,
            percent,
            n,
            DOT * n,
            recover(*settle(*kept, surface.points, surface.normals, threads=threads)),
        )
        few = dotted(xyz, radii, n, evaluator.stream("recovery", "sparse"))
        add(SPARSE, percent, len(few[0]), DOT * len(few[0]), recover(*few))
        if mesh is not None:
            corners, triangles = simplify(mesh.vertices.points, mesh.triangles, 2 * n)
            size = VERTEX * len(corners) + TRIANGLE * len(triangles)
            add(
                MESH,
                percent,
                len(corners),
                size,
                dots_on(corners, triangles, evaluator.stream("recovery", "mesh")),
            )
            normals = corner_normals(corners, triangles)
            add(CORNERS, percent, len(corners), DOT * len(corners), recover(corners, normals))
    turned = dotted(xyz, radii, len(surface), evaluator.stream("recovery", "atoms"))
    add(ATOMS, 100 * len(xyz) / len(surface), len(xyz), ATOM * len(xyz), turned)
    return pd.DataFrame(rows)


def corner_normals(corners, triangles):
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


def dots_on(corners, triangles, rng, density=DENSITY):
    """Dots on a mesh, as far apart as recovered ones, with normals interpolated between those of the corners.

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
    of = rng.choice(len(triangles), n, p=area / area.sum())
    u, v = rng.random((2, n))
    share = np.stack([1 - np.sqrt(u), np.sqrt(u) * (1 - v), np.sqrt(u) * v], axis=1)
    points = np.einsum("nk,nkc->nc", share, corners[triangles[of]])
    normals = np.einsum("nk,nkc->nc", share, corner_normals(corners, triangles)[triangles[of]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    index = build_grid(points, side=1.0)
    chosen = apart(index, np.arange(len(points)), APART / np.sqrt(density), len(points), 0)
    return points[chosen], normals[chosen]
