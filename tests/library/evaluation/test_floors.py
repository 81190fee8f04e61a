"""The noise floor, and the subset that stands on its own."""

import shutil

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree
from scipy.stats import t as student

from measures import recovery
from sparsurf.cli import command
from sparsurf.evaluation import floors as study_floors
from sparsurf.evaluation.floors import floors_table, fresh_dots, random_rotation
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.descriptors import describe_patches
from sparsurf.patches.index import build_index
from sparsurf.recovery.interpolated_surface import interpolate_surface
from sparsurf.sampling.samplers import farthest
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.read_surface import read_surface

ATOMS = np.array(
    [[0, 0, 0], [1.5, 0, 0], [2.2, 1.3, 0.2], [3.7, 1.4, 0.3], [4.3, 2.7, 0.9], [5, 5, 1], [7, 5.5, 2.5]]
)
RADII = np.array([1.9, 1.5, 1.9, 1.4, 1.85, 1.9, 1.7])


def lay(xyz):
    return molecular_surface(xyz, RADII)


@pytest.fixture(scope="module")
def prepared():
    return PreparedSurface(lay(ATOMS), streams=Streams(3, "seven atoms"))


def test_other_dots_cost_something_and_the_same_dots_nothing(prepared):
    table = floors_table(fresh_dots(prepared, 60, lay, ATOMS))
    row = table.iloc[0]
    assert len(table) == 1 and (row["floor"], row["draws"], row["test_dots"]) == ("fresh dots", 10, 60)
    assert 0 < row["low"] < row["Z"] < row["high"]
    tests = prepared.draw_tests(60)
    away = prepared.describe(tests)[0] - prepared.describe(np.roll(tests, 1))[0]
    assert row["Z"] < np.linalg.norm(away, axis=1).mean()  # than those of different patches


def test_the_row_of_the_floor_by_hand():
    """Means of the draws 2 and 4, of the test dots 1.5, 3 and 4.5: the mean squares are 6, 4.5 and 0.5."""
    row = floors_table(np.array([[1.0, 2, 3], [2.0, 4, 6]])).iloc[0].to_dict()
    assert list(row) == ["floor", "Z", "se", "low", "high", "draws", "test_dots"]
    half = student.ppf(0.975, 100 / (6**2 + 4.5**2 / 2 + 0.5**2 / 2)) * row["se"]
    assert row == {
        "floor": "fresh dots", "Z": 3, "se": pytest.approx((10 / 6) ** 0.5), "low": pytest.approx(3 - half),
        "high": pytest.approx(3 + half), "draws": 2, "test_dots": 3,
    }  # fmt: skip


@pytest.mark.parametrize("patches", [{}, {"r_zernike": 4.5, "d_link": 0.7, "descriptor": "rotation_robust"}])
def test_the_floor_is_that_of_dots_placed_on_the_turned_molecule(patches):
    """By hand: two sets of dots on the turned atoms, turned back, and described around the test dots."""
    prepared = PreparedSurface(lay(ATOMS), Settings(patches=patches), streams=Streams(4, "seven"))
    patches = prepared.patches
    distances = fresh_dots(prepared, 30, lay, ATOMS, draws=2)
    rng, tests, centre = prepared.stream("floors"), prepared.draw_tests(30), prepared.points.mean(axis=0)
    true = prepared.describe(tests)[0]
    for row in distances:
        turn = random_rotation(rng)
        other = lay((ATOMS - centre) @ turn.T)
        index = build_index(other.points @ turn + centre, other.normals @ turn, patches.d_link)
        z = describe_patches(index, prepared.points[tests], patches.r_zernike, descriptor=patches.descriptor)[
            0
        ]
        assert row == pytest.approx(np.linalg.norm(z - true, axis=1), abs=1e-6)


def test_a_ready_surface_has_the_floor_of_its_dots(prepared):
    of_dots, of_atoms = fresh_dots(prepared, 60), fresh_dots(prepared, 60, lay, ATOMS)
    assert of_dots.mean() == pytest.approx(of_atoms.mean(), rel=0.3) and of_dots.shape == (10, 60)
    assert np.array_equal(fresh_dots(prepared, 60, lay), of_dots)  # without atoms, nothing can be placed


def test_turnings_are_rotations():
    turns = [random_rotation(np.random.default_rng(k)) for k in range(300)]
    assert all(np.allclose(t @ t.T, np.eye(3)) and np.linalg.det(t) > 0 for t in turns)
    assert np.abs(np.mean(turns, axis=0)).max() < 0.12  # no direction is favoured


def test_the_handed_out_dots_need_nothing_else(prepared, tmp_path, monkeypatch):
    """minimal.csv alone, in an empty folder: the surface, as npz, DMS and PLY, and descriptors around points."""
    chosen = farthest(prepared, len(prepared.points) // 8, np.random.default_rng(0))
    kept = prepared.points[chosen], prepared.normals[chosen]
    old, new = tmp_path / "old", tmp_path / "new"
    old.mkdir(), new.mkdir()
    pd.DataFrame(np.hstack(kept), columns=["x", "y", "z", "nx", "ny", "nz"]).to_csv(
        old / "minimal.csv", index=False
    )
    shutil.copy(old / "minimal.csv", new)
    shutil.rmtree(old)
    monkeypatch.chdir(new)
    for name in ("dense.npz", "dense.dms", "dense.ply", "dense.csv"):
        assert command.main(["recover", "minimal.csv", "-o", name]) == 0
    assert command.main(["recover", "minimal.csv", "--at", "minimal.csv", "-o", "z.csv"]) == 0
    points, _ = interpolate_surface(*kept)
    for name in ("dense.npz", "dense.dms", "dense.csv"):
        assert read_surface(new / name).points == pytest.approx(points, abs=1e-3), name
    assert recovery.distances(points, recovery.truth(ATOMS, RADII)).mean() < 0.05
    z = pd.read_csv("z.csv").filter(like="z_").to_numpy()
    true = prepared.describe(chosen)[0]
    as_they_are, _ = prepared.distances([chosen], chosen, true, "full")
    assert np.linalg.norm(z - true, axis=1).mean() < 0.75 * as_they_are.mean()
    assert z == pytest.approx(
        describe_patches(build_index(*interpolate_surface(*kept)), kept[0])[0], rel=1e-5
    )
    assert cKDTree(points).query(prepared.points)[0].max() < 0.5


def test_intervals_over_proteins():
    rng = np.random.default_rng(0)
    rows = [
        {"protein": p, "sampler": s, "percent": 5.0, "Z": z * (0.8 if s == "a" else 1.0)}
        for p, z in enumerate(rng.uniform(0.5, 1, 9))
        for s in ("a", "b")
    ]
    alone = {"protein": 9, "sampler": "b", "percent": 5.0, "Z": 0.7}  # has no other to be compared with
    change = recovery.paired(pd.DataFrame([*rows, alone]), "a", "b", ("Z",)).iloc[0]
    assert change["n"] == 9
    assert change["change"] == pytest.approx(-20)
    assert change["change_high"] - change["change_low"] == pytest.approx(0, abs=1e-9)


def test_fresh_dots_of_a_ready_surface_are_none_of_its_own(prepared):
    points, normals = study_floors._other_dots(prepared, None, None, np.zeros(3), np.eye(3))
    gaps = cKDTree(prepared.points).query(points)[0]
    assert len(points) > 500 and gaps.min() > 1e-6
    as_dense, _ = interpolate_surface(prepared.points, prepared.normals, prepared.density, keep=False)
    assert len(points) == len(as_dense)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)
