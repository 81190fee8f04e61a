"""Opponents at equal bytes: dots on a mesh lie on it, and what is counted is what there is."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from measures import opponents, rebuilding
from measures.recovery import truth
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS
from sparsurf.recovery.interpolated_surface import interpolate_surface
from sparsurf.sampling.samplers import farthest
from sparsurf.streams import Streams
from sparsurf.surfaces.mesh import MeshSize
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.triangulation import molecular_mesh

ATOMS, RADII = np.array([[0.0, 0, 0], [2.5, 0, 0], [4.0, 1.5, 0]]), np.array([1.9, 1.7, 1.8])


@pytest.fixture(scope="module")
def ball():
    return molecular_mesh(np.zeros((1, 3)), np.array([4.0]))


def test_normals_at_corners_and_dots_on_a_mesh(ball):
    corners, triangles = ball.vertices.points, ball.triangles
    assert opponents.corner_normals(corners, triangles) == pytest.approx(corners / 4, abs=0.1)
    points, normals = opponents.dots_on(corners, triangles, np.random.default_rng(0))
    radius, unit = np.linalg.norm(points, axis=1), corners[::35] / 4
    assert radius.max() <= 4 + 1e-9 and radius.min() > 3.96
    assert normals == pytest.approx(points / radius[:, None], abs=0.06)
    recovered, _ = interpolate_surface(4 * unit, unit)
    assert len(points) == pytest.approx(len(recovered), rel=0.1)
    apart = cKDTree(points).query(points, k=2)[0][:, 1]
    assert apart.min() >= 0.65 / 5.35**0.5 - 1e-9


def test_errors_of_both_sides_by_hand():
    """Dots 0.1 Å outside of a ball of 4 Å, without its cap: places there have none near, and dots in a cavity do not count."""
    true = truth(np.zeros((1, 3)), np.array([4.0]))
    unit = true.normals
    cap = unit[:, 2] > 0.8
    cavity = unit[:, 2] < -0.9
    measured = opponents.two_sided(4.1 * unit[~cap], unit[~cap], true, ~cavity)
    assert measured["there"] == pytest.approx(0.1, abs=1e-6) and measured["there_most"] == pytest.approx(
        0.1, abs=1e-6
    )
    top = np.linalg.norm([4.1 * 0.6, 4.1 * 0.8 - 4.0])  # from the pole to the rim of what is left
    assert measured["back_most"] == pytest.approx(top, abs=0.15)  # dense dots lie 0.13 Å apart
    assert measured["largest"] == measured["back_most"] and measured["distance"] == measured["back"]
    assert measured["angle"] == pytest.approx(0, abs=1e-3)


def test_surfaces_through_the_same_dots_by_pymeshlab(ball):
    pytest.importorskip("pymeshlab")
    keep = farthest(PreparedSurface(ball.vertices), 200, np.random.default_rng(0))
    dots = ball.vertices.points[keep], ball.vertices.points[keep] / 4
    for name, rebuild in rebuilding.rebuilders().items():
        corners, triangles = rebuild(*dots)
        off = np.abs(np.linalg.norm(corners, axis=1) - 4)
        assert len(triangles) > 1000 and off.mean() < 0.08, name  # dots 1 Å apart rise 0.03 over chords
    corners, triangles = rebuilding.simplify(ball.vertices.points, ball.triangles, 400)
    assert 390 <= len(triangles) <= 400 and np.abs(np.linalg.norm(corners, axis=1) - 4).max() < 0.2


def test_bytes_and_errors():
    asked = []

    def coarser(vertices, triangles, n):
        asked.append(n)
        mesh = molecular_mesh(ATOMS, RADII, size=MeshSize(step=0.7))
        return mesh.vertices.points, mesh.triangles

    def ball_of_its_own(points, normals):
        mesh = molecular_mesh(ATOMS, RADII, size=MeshSize(step=0.3))
        return mesh.vertices.points, mesh.triangles

    others = {"others": ball_of_its_own, "nothing": lambda points, normals: (points, np.empty((0, 3), int))}
    rows = opponents.measure("three atoms", ATOMS, RADII, coarser, others, 40, (10.0,))
    rows = rows.set_index("sampler")
    kept, mesh = rows.loc[opponents.KEPT], rows.loc[opponents.MESH]
    assert kept["bytes"] == 24 * kept["n_S"]
    assert asked == [2 * kept["n_S"]]  # triangles, two for every corner
    corners = rows.loc[opponents.CORNERS]
    assert corners["n_S"] == mesh["n_S"] and corners["bytes"] == 24 * corners["n_S"]
    assert mesh["bytes"] == 12 * mesh["n_S"] + 6 * (
        2 * mesh["n_S"] - 4
    )  # Euler: two triangles a vertex, but for four
    surface = molecular_surface(ATOMS, RADII)
    prepared = PreparedSurface(surface, streams=Streams(20261120, "three atoms"))
    chosen = farthest(prepared, kept["n_S"], prepared.stream("recovery", "farthest"))
    true, few = truth(ATOMS, RADII), (surface.points[chosen], surface.normals[chosen])
    dense = [
        each[len(chosen) :] for each in interpolate_surface(*few, DENSITY_FOR_ERRORS)
    ]  # without the kept dots
    wanted = opponents.two_sided(*dense, true, np.full(len(true.points), True))
    assert rows.loc[opponents.KEPT, list(wanted)].to_dict() == pytest.approx(wanted)
    assert rows.loc["others", "bytes"] == kept["bytes"] and rows.loc["others", "distance"] < 0.03
    assert "nothing" not in rows.index
    assert rows.loc[opponents.UNIFORM, "distance"] > kept["distance"]
    assert corners["distance"] < mesh["distance"]  # moved onto the surface, with its normals
    assert rows.loc[opponents.ATOMS, "percent"] == pytest.approx(300 / len(surface))
    assert rows.loc[opponents.ATOMS, "bytes"] == 48 and rows.loc[opponents.ATOMS, "distance"] < 1e-6
    few = opponents.measure("no mesh", ATOMS, RADII, None, {}, 40, (100 * 30.6 / len(surface),))
    few = few.set_index("sampler")
    assert opponents.MESH not in few.index and few.loc[opponents.KEPT, "n_S"] == 31
