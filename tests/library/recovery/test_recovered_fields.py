"""Fields recovered from a few dots: exact where the interpolant must be, and close on a real field."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

import conftest
import sparsurf
from conftest import ROOT
from sparsurf.recovery.fields import _errors, interpolate_fields, recovery_table
from sparsurf.surfaces.surface import Surface


def test_a_linear_field_comes_back_exactly_and_dots_keep_their_values():
    rng = np.random.default_rng(0)
    points, places = rng.uniform(0, 20, (300, 3)), rng.uniform(3, 17, (100, 3))
    slope = np.array([1.0, -2, 0.5])
    found = interpolate_fields(points, {"a": points @ slope, "b": rng.normal(size=300)}, places)
    np.testing.assert_allclose(found["a"], places @ slope, atol=1e-6)
    noise = rng.normal(size=300)
    np.testing.assert_allclose(interpolate_fields(points, {"b": noise}, points)["b"], noise, atol=1e-6)


def test_dots_without_a_value_are_left_out():
    points = np.random.default_rng(1).uniform(0, 9, (80, 3))
    values = np.where(points[:, 0] > 5, np.where(points[:, 1] > 5, np.inf, np.nan), points[:, 1])
    found = interpolate_fields(points, {"a": values}, points[points[:, 0] < 4])["a"]
    np.testing.assert_allclose(found, points[points[:, 0] < 4, 1], atol=1e-6)
    assert np.isnan(interpolate_fields(points, {"a": np.full(80, np.nan)}, points[:3])["a"]).all()


def test_few_dots_give_their_mean_five_a_plane_and_no_value_leaves_their_range():
    points = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4], [4, 4, 4]])
    values, places = points @ [1.0, 2, -1] + 3, np.array([[1.0, 1, 1], [2, 1, 0.5], [90, 90, 0]])
    four = interpolate_fields(points[:4], {"a": values[:4]}, places)["a"]
    assert four == pytest.approx([values[:4].mean()] * 3)
    five = interpolate_fields(points, {"a": values}, places)["a"]
    assert five == pytest.approx([5, 6.5, values.max()], abs=1e-5)  # the last place is far outside
    assert interpolate_fields(points, {"a": values}, -90 * places[2:])["a"] == values.min()


def test_many_places_and_coincident_dots_change_no_value():
    rng = np.random.default_rng(3)
    points, places = rng.uniform(0, 9, (60, 3)), rng.uniform(1, 8, (5000, 3))
    field = {"a": np.sin(points[:, 0]) + points[:, 1]}
    found = interpolate_fields(points, field, places)["a"]
    for k in (0, 2047, 2048, 4999):
        assert interpolate_fields(points, field, places[k : k + 1])["a"] == pytest.approx(found[k])
    double = interpolate_fields(np.repeat(points, 2, axis=0), {"a": np.repeat(field["a"], 2)}, places)["a"]
    assert np.abs(double - found).mean() < 0.1 * np.abs(found - field["a"].mean()).mean()


def test_a_value_is_that_of_the_function_through_the_24_nearest_dots():
    """The function of the dot nearest to the place: a cubic radial one with a linear part, as scipy fits it."""
    rng = np.random.default_rng(4)
    points, values = rng.uniform(0, 9, (200, 3)), rng.normal(size=200)
    for place in rng.uniform(2, 7, (5, 3)):
        centre = points[np.linalg.norm(points - place, axis=1).argmin()]
        near = np.argsort(np.linalg.norm(points - centre, axis=1))[:24]
        wanted = RBFInterpolator(points[near], values[near], kernel="cubic", degree=1)(place[None])
        found = interpolate_fields(points, {"a": values}, place[None])["a"]
        assert found == pytest.approx(wanted.clip(values.min(), values.max()), abs=1e-4)


def test_errors_of_a_field_by_hand():
    """Of true values 1, 2, 3 and 4, of which 2 lacks its prediction."""
    r, rms, share = _errors(np.array([2.0, np.nan, 3, 6]), np.array([1.0, 2, 3, 4]))
    assert rms == pytest.approx(np.sqrt(5 / 3)) and share == pytest.approx(rms / np.std([1, 3, 4]))
    assert r == pytest.approx(np.corrcoef([2, 3, 6], [1, 3, 4])[0, 1])
    assert np.isnan(_errors(np.full(3, np.nan), np.ones(3))).all()
    assert np.isnan(_errors(np.array([1.0, 2]), np.ones(2))).tolist() == [True, False, True]


def test_of_few_dots_each_share_is_at_least_one():
    points = conftest.ball(30, 3)[0]
    surface = Surface(points, points / 3, fields={"a": points[:, 0]})
    table = recovery_table(surface, np.arange(30)[::-1])
    assert table["n_S"].tolist() == [1, 2, 3, 6] and table["subset"].eq("farthest").all()
    assert table["n_S_percent"].tolist() == pytest.approx([100 / 30, 200 / 30, 10, 20])
    mean = points[[29, 28, 27], 0].mean()
    assert table["rms"][2] == pytest.approx(np.sqrt(np.mean((points[:27, 0] - mean) ** 2)))


def test_the_table_compares_with_the_field_at_other_dots():
    """A linear field comes back; noise does not; a constant one has no correlation; NaN are no errors."""
    rng = np.random.default_rng(2)
    points = rng.normal(size=(800, 3))
    points *= 10 / np.linalg.norm(points, axis=1)[:, None]
    noise = rng.normal(size=800)
    fields = {
        "noise": noise,
        "a": points @ [1.0, 2, 0],
        "flat": np.ones(800),
        "half": np.where(noise > 0, points[:, 0], np.nan),
    }
    surface = Surface(points, points / 10, fields=fields)
    kept = np.arange(0, 800, 16)
    table = recovery_table(surface, rng.permutation(800)[:160], kept, points[kept])
    assert table["field"].drop_duplicates().to_list() == [*fields]
    assert table["subset"].to_list() == ["minimal", *["farthest"] * 4] * 4
    assert table["n_S"].to_list()[:5] == [50, 20, 40, 80, 160] and table["n_S_percent"][1] == 2.5
    by = table[table["n_S"] == 160].set_index("field")
    assert (
        by["r"]["a"] > 0.9999
        and abs(by["r"]["noise"]) < 0.2
        and np.isnan(by["r"]["flat"])
        and by["r"]["half"] > 0.95
    )
    assert by["rms"]["flat"] == pytest.approx(0, abs=1e-9) and by["rms_sd"]["noise"] > 0.9
    others = np.setdiff1d(np.arange(800), kept)
    found = interpolate_fields(points[kept], {"noise": noise[kept]}, points[others])["noise"]
    assert table["rms"][0] == pytest.approx(np.sqrt(np.mean((found - noise[others]) ** 2)))
    assert table["rms_sd"][0] == pytest.approx(table["rms"][0] / noise[others].std())
    assert found.std() > 1.1 * noise[others].std()  # so that it matters which of both divides


def test_a_tenth_of_the_dots_gives_the_fields_of_a_peptide_back(tmp_path):
    path = ROOT / "data" / "tdp43" / "topology.pdb"
    dots = sparsurf.surface(path)
    kept = sparsurf.sample(dots, percent=10)
    others = np.setdiff1d(np.arange(len(dots)), kept)
    table = sparsurf.fields(path, dots)
    found = interpolate_fields(dots.points[kept], dict(table.iloc[kept]), dots.points[others])
    assert np.corrcoef(found["hydropathy"], table["hydropathy"][others])[0, 1] > 0.999
    assert np.corrcoef(found["potential"], table["potential"][others])[0, 1] > 0.98


def test_fields_of_a_file_go_through_recover(tmp_path):
    path = ROOT / "data" / "tdp43" / "topology.pdb"
    from sparsurf.cli.command import main

    few, dense = tmp_path / "few.csv", tmp_path / "dense.ply"
    residues = ["--selection", "residue 209 to 222"]
    fields = ["--fields", "hydropathy,potential"]
    assert main(["minimal", str(path), "--percent", "20", *fields, *residues, "-o", str(few)]) == 0
    assert main(["recover", str(few), "-o", str(dense)]) == 0
    kept, whole = sparsurf.read_surface(few), sparsurf.read_surface(dense)
    assert list(kept.fields) == ["hydropathy", "potential"] == list(whole.fields)
    molecule = sparsurf.read_molecule(path, residues="209-222")
    true = sparsurf.fields(molecule, whole)
    assert np.corrcoef(true["hydropathy"], whole.fields["hydropathy"])[0, 1] > 0.999
    # a PLY has six digits
    assert whole.fields["potential"][: len(kept)] == pytest.approx(kept.fields["potential"], rel=1e-4)
