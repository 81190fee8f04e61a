"""How far position and dots move a descriptor, on a few atoms."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from measures import steadiness
from sparsurf.surfaces.molecular_surface import molecular_surface

RADII = np.full(12, 1.7)


@pytest.fixture(scope="module")
def atoms():
    """Twelve atoms of a loose coil, Å."""
    k = np.arange(12.0)
    return np.stack([3 * np.cos(0.9 * k), 3 * np.sin(0.9 * k), 0.9 * k], axis=1)


def test_poses_are_the_same_surface(atoms):
    dots = molecular_surface(atoms, RADII)
    tests = dots.points[::50]
    found = list(steadiness.poses(atoms, RADII, tests, 5.35, np.random.default_rng(0), turns=1))
    assert [change for change, *_ in found] == ["", *steadiness.CHANGES]
    for _, points, normals, places in found:
        centre = atoms if np.allclose(places, tests) else None
        gap = np.linalg.norm(points[:, None] - places[None], axis=2).min(axis=0)
        assert gap.max() < 0.5  # the places stay on the surface
        assert np.allclose(np.linalg.norm(normals, axis=1), 1)
        if centre is not None:
            assert np.linalg.norm(points[:, None] - centre[None], axis=2).min() > 1.69
    assert np.allclose(np.linalg.norm(found[1][3], axis=1), np.linalg.norm(tests, axis=1))
    turn = Rotation.random(1, np.random.default_rng(0)).as_matrix()[0]
    for still, turned in (found[:2], found[2:]):
        assert all(np.allclose(one @ turn.T, other) for one, other in zip(still[1:], turned[1:], strict=True))


def test_the_rotation_robust_descriptor_moves_less(atoms):
    tests = molecular_surface(atoms, RADII).points[::40]
    changes = steadiness.steadiness(atoms, RADII, tests, np.random.default_rng(1))
    ratio = changes.set_index(["descriptor", "change"])["ratio"]
    assert ratio["rotation_robust", "turned"] < 0.1 * ratio["published", "turned"]
    assert ratio["rotation_robust", "turned, fresh dots"] < 0.5 * ratio["published", "turned, fresh dots"]
    assert (changes["ratio"] == changes["Z"] / changes["Z_two_patches"]).all()
