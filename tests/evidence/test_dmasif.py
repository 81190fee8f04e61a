"""The smooth distance of dMaSIF: of one atom it is the distance, its gradient is its slope, and its points lie on the level."""

import numpy as np
import pytest

from measures.dmasif import INWARD, LEVEL, SMOOTHNESS, moved_points_of_dmasif, points_of_dmasif, soft_distance

ATOMS, SMOOTH = np.array([[0.0, 0, 0], [2.5, 0, 0], [4.0, 1.5, 0]]), np.array([0.5, 0.7, 0.77])


def test_the_distance_from_one_atom_is_exact_and_from_more_it_is_soft():
    at = np.random.default_rng(0).normal(0, 3, (50, 3))
    distance, gradient = soft_distance(at, ATOMS[:1], SMOOTH[:1])
    far = np.linalg.norm(at, axis=1)
    assert distance == pytest.approx(far) and gradient == pytest.approx(at / far[:, None])
    distance, gradient = soft_distance(at, ATOMS, SMOOTH)
    gap = np.linalg.norm(at[:, None] - ATOMS, axis=2)
    mean = (np.exp(-gap) * SMOOTH).sum(axis=1) / np.exp(-gap).sum(axis=1)
    assert distance == pytest.approx(-mean * np.log(np.exp(-gap / SMOOTH).sum(axis=1)))
    for k, step in enumerate(1e-6 * np.eye(3)):
        up, down = (soft_distance(at + sign * step, ATOMS, SMOOTH)[0] for sign in (1, -1))
        assert gradient[:, k] == pytest.approx((up - down) / 2e-6, abs=1e-6)


def test_points_lie_at_the_level_and_the_moved_ones_on_the_surface():
    xyz, radii = np.zeros((40, 3)), np.full(40, 1.2)  # one place, so that many points are drawn around it
    expected = LEVEL + SMOOTHNESS * np.log(40) - INWARD
    points, normals, *_ = points_of_dmasif(xyz, radii)
    far = np.linalg.norm(points, axis=1)
    assert len(points) > 20 and np.abs(far - expected).max() < 0.35
    assert normals == pytest.approx(points / far[:, None], abs=1e-6)
    moved = moved_points_of_dmasif(xyz[:1], radii[:1])[0]
    assert np.linalg.norm(moved, axis=1).mean() == pytest.approx(1.2, abs=1e-6)
