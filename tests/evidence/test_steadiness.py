"""How far position and dots move a descriptor, on a few atoms."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.distance import pdist
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


def test_changes_by_hand(monkeypatch):
    rng = np.random.default_rng(0)
    own = rng.normal(size=(3, 121))  # the descriptors of three patches
    moved = {change: own + 0.1 * rng.normal(size=(2, 3, 121)) for change in steadiness.CHANGES}
    found = [("", own), *((change, z) for change, both in moved.items() for z in both)]
    monkeypatch.setattr(steadiness, "DESCRIPTORS", ("published",))
    monkeypatch.setattr(steadiness, "poses", lambda *_: [(change, z, None, None) for change, z in found])
    monkeypatch.setattr(steadiness, "build_index", lambda z, *_: z)
    monkeypatch.setattr(steadiness, "describe", lambda z, *_, **__: (z, None))
    changes = steadiness.steadiness(None, None, None, None).set_index("change")
    apart = pdist(own).mean()
    for change, both in moved.items():
        one, other = (np.linalg.norm(z - own, axis=1).mean() for z in both)
        z = (one + other) / 2
        assert changes.loc[change, ["Z", "Z_two_patches", "ratio"]].tolist() == pytest.approx(
            [z, apart, z / apart]
        )
        assert changes.loc[change, "sd"] == pytest.approx(abs(one - other) / np.sqrt(2))


def test_the_rotation_robust_descriptor_moves_less(atoms):
    tests = molecular_surface(atoms, RADII).points[::40]
    changes = steadiness.steadiness(atoms, RADII, tests, np.random.default_rng(1))
    ratio = changes.set_index(["descriptor", "change"])["ratio"]
    assert ratio["rotation_robust", "turned"] < 0.1 * ratio["published", "turned"]
    assert ratio["rotation_robust", "turned, fresh dots"] < 0.5 * ratio["published", "turned, fresh dots"]
    assert (changes["ratio"] == changes["Z"] / changes["Z_two_patches"]).all()


def test_the_figure_shows_means_with_their_ends():
    rows = [
        (name, change, k + d) for d, name in enumerate(steadiness.COLOURS) for k, change in enumerate("ab")
    ]
    means = pd.DataFrame(rows, columns=["descriptor", "change", "ratio"])
    means = means.assign(ratio_low=means["ratio"] - 0.1, ratio_high=means["ratio"] + 0.2)
    (ax,) = steadiness.draw(means).axes
    assert [patch.get_height() for patch in ax.patches] == means["ratio"].tolist()
    ends = [path.vertices[:, 1] for bar in ax.collections for path in bar.get_paths()]
    assert np.array(ends) == pytest.approx(means[["ratio_low", "ratio_high"]].to_numpy())
