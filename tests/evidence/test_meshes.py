"""Triangles beside those of other programs: what is counted of a mesh whose surface is known."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from measures.meshes import compared, exact_surface, is_closed

RADIUS = 2.0


@pytest.fixture(scope="module")
def ball():
    """Points on a sphere, and the triangles of their hull, counterclockwise from outside."""
    height = np.linspace(-1, 1, 402)
    turn = np.pi * (1 + 5**0.5) * np.arange(402)
    across = np.sqrt(1 - height**2)
    points = RADIUS * np.column_stack([across * np.cos(turn), across * np.sin(turn), height])
    triangles = ConvexHull(points).simplices
    a, b, c = (points[triangles[:, k]] for k in range(3))
    inwards = (a * np.cross(b, c)).sum(axis=1) < 0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return points, triangles


def test_a_mesh_of_a_sphere_has_its_area_volume_and_place(ball):
    points, triangles = ball
    exact = exact_surface(np.zeros((1, 3)), np.array([RADIUS]))
    assert exact.area == pytest.approx(4 * np.pi * RADIUS**2) and exact.handles == 0
    assert exact.volume == pytest.approx(4 / 3 * np.pi * RADIUS**3)
    for given in (
        (points, triangles),
        (points, triangles[:, ::-1]),
    ):  # turned inside out as a whole, it is the same
        found = compared(given, exact)
        assert -2 < found["area_percent"] < 0 > found["volume_percent"] > -4
        assert found["vertices"] == 402 and found["closed"] == 1 and found["handles"] == 0
        assert 0.01 < found["rms"] < found["largest"] < 0.1


def test_a_mesh_with_a_hole_or_a_turned_triangle_is_not_closed(ball):
    _, triangles = ball
    turned = triangles.copy()
    turned[7] = turned[7][::-1]
    assert is_closed(triangles) and not is_closed(triangles[1:]) and not is_closed(turned)
    assert not is_closed(np.concatenate([triangles, triangles[:1]]))
