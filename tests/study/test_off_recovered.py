"""Distance of dots from the surface recovered from a few of them."""

import numpy as np
import pytest

from sparsurf.study.off_recovered import off, off_recovered


@pytest.fixture(scope="module")
def sphere():
    """Dots of a sphere of 8 Å, 5.4 per Å^2, with their normals."""
    k = np.arange(4300) + 0.5
    z, turn = 1 - 2 * k / len(k), np.pi * (1 + 5**0.5) * k
    unit = np.stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z], axis=1)
    return 8 * unit, unit


def test_a_tenth_of_a_sphere_gives_it_back(sphere):
    points, normals = sphere
    off = off_recovered(points, points[::10], normals[::10])
    assert off[::10].max() < 1e-9
    assert off.max() < 0.05


def test_a_dot_off_the_surface_is_told_by_how_much(sphere):
    points, normals = sphere
    moved = points.copy()
    moved[5] += 0.3 * normals[5]
    moved[7] -= 0.3 * normals[7]
    moved[9] += 5 * normals[9]
    off = off_recovered(moved, points[::10], normals[::10], 2)
    assert off[[5, 7]] == pytest.approx(0.3, abs=0.03)
    assert off[9] == pytest.approx(5, abs=0.1)


def test_a_missing_cap_is_far(sphere):
    points, normals = sphere
    below = points[:, 2] < 4
    off = off_recovered(points, points[below][::10], normals[below][::10])
    top = np.argmax(points[:, 2])
    assert off[top] > 1.0
    assert np.median(off[points[:, 2] < 3]) < 0.05


def test_a_surface_beside_another_one(sphere):
    points, normals = sphere
    assert off(1.05 * points[::3], points, normals) == pytest.approx(0.4, abs=0.01)
    assert off(np.add(points, [20, 0, 0]), points, normals).max() == pytest.approx(20, abs=0.1)


def test_a_plane_by_hand():
    # dots 1 Å apart on z = 0: above one of them the plane tells, 3 Å beyond the edge the nearest dot
    x, y = np.meshgrid(np.arange(5.0), np.arange(5.0))
    places = np.stack([x.ravel(), y.ravel(), np.zeros(25)], axis=1)
    up = np.tile([0.0, 0, 1], (25, 1))
    points = np.array([[2.3, 2.0, 0.5], [2.3, 2.0, -0.5], [7.0, 2.0, 0.0], [2.0, 2.0, 2.5], [2.0, 2.3, 0.0]])
    assert off(points, places, up) == pytest.approx([0.5, 0.5, 3.0, 2.5, 0.0])
