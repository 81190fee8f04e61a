"""How far position and dots move a descriptor, on a few atoms."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.distance import pdist
from scipy.spatial.transform import Rotation

from measures import steadiness
from sparsurf.patches.zernike.polynomials import indices
from sparsurf.sampling import published
from sparsurf.sampling.combination import PUBLISHED_ROWS
from sparsurf.study import grid
from sparsurf.study.prepared_surface import PreparedSurface
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


def test_changes_and_orders_by_hand(monkeypatch):
    rng = np.random.default_rng(0)
    own = rng.normal(size=(3, 121))  # the descriptors of three patches
    moved = {change: own + 0.1 * rng.normal(size=(2, 3, 121)) for change in steadiness.CHANGES}
    found = [("", own), *((change, z) for change, both in moved.items() for z in both)]
    monkeypatch.setattr(steadiness, "DESCRIPTORS", ("published",))
    monkeypatch.setattr(steadiness, "poses", lambda *_: [(change, z, None, None) for change, z in found])
    monkeypatch.setattr(steadiness, "build_index", lambda z, *_: z)
    monkeypatch.setattr(steadiness, "describe", lambda z, *_, **__: (z, None))
    changes, orders = steadiness.steadiness(None, None, None, None)
    changes, orders = changes.set_index("change"), orders.set_index("n")["ratio"]
    apart = pdist(own).mean()
    for change, both in moved.items():
        one, other = (np.linalg.norm(z - own, axis=1).mean() for z in both)
        z = (one + other) / 2
        assert changes.loc[change, ["Z", "Z_two_patches", "ratio"]].tolist() == pytest.approx(
            [z, apart, z / apart]
        )
        assert changes.loc[change, "sd"] == pytest.approx(abs(one - other) / np.sqrt(2))
    for n in (0, 2, 20):
        columns = [k for k, (order, _) in enumerate(indices()) if order == n]
        within = ((moved["turned, fresh dots"] - own) ** 2).mean(axis=(0, 1)) / 2
        assert orders[n] == pytest.approx(within[columns].sum() / own.var(axis=0)[columns].sum())


def test_the_rotation_robust_descriptor_moves_less(atoms):
    tests = molecular_surface(atoms, RADII).points[::40]
    changes, orders = steadiness.steadiness(atoms, RADII, tests, np.random.default_rng(1))
    ratio = changes.set_index(["descriptor", "change"])["ratio"]
    assert ratio["rotation_robust", "turned"] < 0.1 * ratio["published", "turned"]
    assert ratio["rotation_robust", "turned, fresh dots"] < 0.5 * ratio["published", "turned, fresh dots"]
    assert (changes["ratio"] == changes["Z"] / changes["Z_two_patches"]).all()
    assert orders.groupby("descriptor").size().tolist() == [21, 21]


def test_tables_of_rows_grid_and_samplers_agree_with_the_evaluator(blob, monkeypatch):
    surface = SimpleNamespace(points=blob[0], normals=blob[1])
    prepared = PreparedSurface(surface, d_link=0.8, seed=3, name="blob")
    monkeypatch.setattr(steadiness, "SAMPLERS", {"uniform": steadiness.SAMPLERS["uniform"]})
    table = steadiness.of_samplers(prepared, 20, (10,)).set_index("descriptor")
    tests = prepared.draw_tests(20)
    for name in table.index:
        own = prepared.changed(descriptor=name)
        subsets = [
            steadiness.SAMPLERS["uniform"](prepared, 300, prepared.stream("steadiness", "uniform", draw))
            for draw in range(3)
        ]
        z, _ = own.distances(subsets, tests, own.describe(tests)[0], "as_written")
        assert table.loc[name, "Z"] == pytest.approx(z.mean())
        assert table.loc[name, "error"] == pytest.approx(z.mean(axis=0).std(ddof=1) / np.sqrt(20))
        assert table.loc[name, "n_S_percent"] == pytest.approx(10)
    rows = steadiness.rows_of_paper(prepared, 10)
    assert len(rows) == 2 * 2 * 10
    by_hand = grid.evaluate_grid(prepared, PUBLISHED_ROWS, 10, steadiness.DRAWS)
    own = rows[(rows["descriptor"] == "published") & (rows["reading"] == "as_written")].set_index("row")
    gain = by_hand.z_tr[1].astype(float) - by_hand.z_ts[1]
    assert own["d"].to_numpy() == pytest.approx(gain.mean(axis=(1, 2)), abs=1e-6)
    assert own["Z_tS"].to_numpy() == pytest.approx(by_hand.z_ts[1].mean(axis=(1, 2)), abs=1e-6)
    of_tests = gain.mean(axis=1)  # the error is that over test dots
    assert own["error"].to_numpy() == pytest.approx(of_tests.std(axis=1, ddof=1) / np.sqrt(10), abs=1e-6)
    assert own["n_S_percent"].to_numpy() == pytest.approx(by_hand.n_s.mean(axis=1) / 30)
    found = steadiness.whole_grid(prepared, published.parameter_grid([1.0], [0.0], [0, 6], [0]), 12)
    assert found["correlation"].iloc[:2].tolist() == pytest.approx([1, 1])
    whole = grid.evaluate_grid(prepared, published.parameter_grid([1.0], [0.0], [0, 6], [0]), 12, 1)
    d = (whole.z_tr - whole.z_ts).mean(axis=(2, 3))[0]
    first = found.iloc[0]
    assert first["best_d"] == pytest.approx(d.max(), abs=1e-6) and first["gamma"] == [0, 6][d.argmax()]
    assert first["percent_above_0"] == 50 * (d > 0).sum()


def test_the_grid_is_reported_by_its_mean_and_its_ends():
    rows = [
        ("rotation_robust", "as_written", percent, d, 0.5)
        for percent, d in ((1.0, 0.1), (3.0, 0.4), (8.0, 0.1))
    ]
    columns = ["descriptor", "reading", "percent_above_0", "best_d", "correlation"]
    table = pd.DataFrame([*rows, ("published", "as_written", 50.0, 2.0, 1.0)], columns=columns)
    found = steadiness.grid_means(table).set_index("descriptor").loc["rotation_robust"]
    assert found["structures"] == 3 and found["best_d"] == pytest.approx(0.2)
    assert found[["percent_above_0", "percent_above_0_lowest", "percent_above_0_highest"]].to_list() == [
        4,
        1,
        8,
    ]
