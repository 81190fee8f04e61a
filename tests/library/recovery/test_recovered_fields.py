"""Fields recovered from a few dots: exact where the interpolant must be, and close on a real field."""

import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.recovery.fields import interpolate_fields, recovery_table
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
    values = np.where(points[:, 0] > 5, np.nan, points[:, 1])
    found = interpolate_fields(points, {"a": values}, points[points[:, 0] < 4])["a"]
    np.testing.assert_allclose(found, points[points[:, 0] < 4, 1], atol=1e-6)
    assert np.isnan(interpolate_fields(points, {"a": np.full(80, np.nan)}, points[:3])["a"]).all()


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
