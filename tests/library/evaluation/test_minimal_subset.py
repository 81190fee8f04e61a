"""A surface and the dots that stand for it: what was asked for, and every table against its parts."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

from peptides import peptide, write
from sparsurf.errors import InputError
from sparsurf.evaluation.minimal_subset import represent, subset_columns
from sparsurf.evaluation.residues import residue_table
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness_of_patches
from sparsurf.recovery.errors import curvature, distance_to_recovered
from sparsurf.recovery.fields import recovery_table
from sparsurf.recovery.interpolated_surface import dot_spacing, interpolate_surface
from sparsurf.sampling.combination import Choices
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.molecular_surface import molecular_surface, roll_spheres
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.surface import Surface

FIELDS = ["hydropathy", "hbond", "mean_curvature"]


def asked(fields=(), test_dots=20, **minimal):
    """Settings with a request."""
    return Settings(minimal=minimal, evaluation={"test_dots": test_dots}, fields=list(fields))


@pytest.fixture(scope="module")
def molecule(tmp_path_factory):
    text = peptide(["ALA", "SER", "ALA"], "A", 5) + "END\n"
    return read_molecule(write(tmp_path_factory.mktemp("peptide") / "p.pdb", text))


@pytest.fixture(scope="module")
def dots(molecule):
    """Dots with an own field, as a study reads them: where they were placed is not known."""
    placed = molecular_surface(molecule.xyz[0].round(3), radii(molecule, "dms"))
    return replace(placed, fields={"own": np.linspace(0, 1, len(placed)) ** 3}, origin=None)


@pytest.fixture(scope="module")
def found(dots, molecule):
    return represent(dots, asked(FIELDS, error=0.06), Streams(2, "p"), molecule)


def test_the_subset_has_the_rows_of_its_dots(found, dots, molecule):
    few = found.subset
    assert len(few) == len(few.table) == len(few.dots) and few.molecule is molecule
    assert repr(few) == f"Subset of {len(few)} dots of {len(dots):,}"
    assert np.array_equal(np.asarray(few), dots.points[few.dots]) and few.to_frame().equals(few.table)
    names = ["dot", "x", "y", "z", "nx", "ny", "nz", "weight", "area", "spacing", "reach"]
    labels = ["chain", "residue", "residue_name", "atom_name", "atom"]
    said = {"probe_radius": 1.4, "radii": "dms", "reconstruction": "auto"}
    assert list(few.table) == [*names, *said, *labels]
    assert (few.table[list(said)] == list(said.values())).all(axis=None)
    assert np.array_equal(few.table[["x", "y", "z"]], dots.points[few.dots])
    assert np.array_equal(few.table[["nx", "ny", "nz"]], dots.normals[few.dots])
    gaps = np.linalg.norm(dots.points[:, None] - few.points, axis=2)
    assert few.table["weight"].tolist() == np.bincount(gaps.argmin(axis=1)).tolist()
    assert few.table["spacing"].tolist() == dot_spacing(few.points, few.normals).tolist()
    assert few.table["reach"].eq(1).all() and few.table["dot"].tolist() == few.dots.tolist()
    assert few.table["atom"].tolist() == dots.atom[few.dots].tolist()
    assert few.table["atom_name"].tolist() == molecule.name[dots.atom[few.dots]].tolist()
    assert list(subset_columns(few.dots, few.weight, few.surface)) == [*names, *said]
    assert list(subset_columns(few.dots, few.weight, Surface(few.points, few.normals))) == [
        name for name in names if name != "area"
    ]


def test_errors_without_atoms_are_those_of_the_dots_that_are_not_kept(dots):
    found = represent(dots, asked(error=0.06), Streams(2, "p"))
    few, table = found.subset, found.errors()
    distance = distance_to_recovered(dots.points, few.points, few.normals, 1, 20.0)
    others = np.delete(distance, few.dots)
    assert table.loc[0, ["mean", "largest"]].tolist() == pytest.approx([others.mean(), others.max()])
    assert table["measured_on"].eq("dots not kept").all()


def test_errors_are_those_of_independent_dots_of_the_whole_surface(found, dots, molecule):
    few, table = found.subset, found.errors()
    row = table.iloc[0]
    stated = found.errors(everywhere=True)  # what a command says, without what it does not
    assert len(stated) == 1 and stated.iloc[0].drop("Z_mean_patch").equals(row.drop("Z_rotation_robust"))
    spheres = molecule.xyz[0].round(3), radii(molecule, "dms")
    fresh = molecular_surface(*spheres, density=8.0)
    dense, _ = interpolate_surface(few.points, few.normals, 20.0)
    # no plane between: the place of the probe nearest to the nearest reconstructed dot
    away, nearest = cKDTree(dense).query(fresh.points)
    distance = np.abs(exact_distance(dense[nearest], roll_spheres(*spheres, 1.4)))
    spacing = np.median(cKDTree(dense).query(dense, k=2)[0][:, 1])
    distance = np.where(away <= 2 * spacing, distance, away)  # no dot in a hole
    assert row[["mean", "high_99", "largest"]].tolist() == pytest.approx(
        [distance.mean(), np.quantile(distance, 0.99), distance.max()]
    )
    # too few dots to infer atoms from
    assert row[["measured_on", "sampler", "reconstruction"]].tolist() == [
        "independent dots",
        "farthest",
        "interpolant",
    ]
    bend = curvature(build_index(fresh.points, fresh.normals))
    ridges, others = np.flatnonzero(bend > 0.05), fresh.points
    assert table["where"].tolist() == ["everywhere", "clefts", "flats", "ridges"]
    assert table["mean"][3] == pytest.approx(distance[ridges].mean())
    assert table["dots"][3] == len(ridges) < len(others)
    share = 100 / len(dots)
    low, high = few.interval
    assert low < len(few) < high
    assert row[["n_S_percent", "n_S_percent_low", "n_S_percent_high"]].tolist() == pytest.approx(
        [share * len(few), share * low, share * high]
    )
    assert row["density"] == pytest.approx(len(few) / dots.area.sum())
    tests = found.trials.tests
    assert len(tests) == 20
    z, _ = found.trials.prepared.distances([few.dots], tests, found.trials._z_tot, "recovered")
    assert row["Z_published"] == pytest.approx(z.mean())
    robust = found.trials.prepared.with_descriptor("rotation_robust")
    z, _ = robust.distances([few.dots], tests, robust.describe(tests)[0], "recovered")
    assert row["Z_rotation_robust"] == pytest.approx(z.mean())
    assert table.loc[1:, ["n_S_percent", "density", "Z_published"]].isna().all(axis=None)


def test_a_requested_number_has_no_interval(dots):
    row = represent(dots, asked(n_dots=40), Streams(2, "p")).errors().iloc[0]
    assert row[["n_S_percent_low", "n_S_percent_high"]].isna().all()
    assert row["n_S_percent"] == pytest.approx(100 * 40 / len(dots))


def test_other_subsets_predict_the_fields_as_well(found):
    few, prepared = found.subset, found.trials.prepared
    n = len(prepared)
    order = farthest_point_sampling(prepared.index, n // 5, prepared.stream("minimal", "farthest"))
    expected = recovery_table(found.surface, order, few.dots, few.points)
    table = found.errors_of_fields()
    pd.testing.assert_frame_equal(table, expected)
    assert table["n_S"].max() == round(0.2 * n) and table["field"].unique().tolist() == ["own", *FIELDS]


def test_residues_have_the_roughness_and_the_kept_dots(found, dots, molecule):
    component = (dots.atom >= 10).astype(int)
    table = found.residues(component)
    few, rough = found.subset, roughness_of_patches(build_index(dots.points, dots.normals))
    pd.testing.assert_frame_equal(
        table, residue_table(found.surface, rough, molecule, few.dots, few.weight, component)
    )
    assert table["kept"].sum() == len(few) and table["weight"].sum() == len(dots)
    assert table["residue"].tolist() == ["5", "6", "7"]
    turned = replace(found, molecule=None)
    with pytest.raises(ValueError, match="have no residues"):
        turned.residues()


def test_fields_stand_beside_those_of_the_dots(found, dots, molecule, tmp_path):
    assert list(found.surface.fields) == ["own", *FIELDS]
    assert np.array_equal(found.surface.fields["own"], dots.fields["own"])
    contact = dots.kind == 0
    assert found.surface.fields["mean_curvature"][contact] == pytest.approx(
        1 / radii(molecule, "dms")[dots.atom[contact]]
    )
    assert np.array_equal(found.subset.surface.fields["own"], dots.fields["own"][found.subset.dots])
    (tmp_path / "t.csv").write_text("residue,score\n5,1\n6,3\n7,3\n")
    few = represent(
        dots, asked(["score"], n_dots=9), Streams(), molecule, table=tmp_path / "t.csv", roughness=dots.area
    )
    assert list(few.surface.fields) == ["own", "score"] and np.ptp(few.surface.fields["score"]) > 1
    assert np.array_equal(few.roughness, dots.area)  # it was given
    assert list(represent(dots, asked(["score"], n_dots=9), Streams(), molecule).surface.fields) == ["own"]
    assert list(represent(dots, asked(FIELDS, n_dots=9), Streams()).surface.fields) == ["own"]


def test_curvature_follows_the_table_of_radii_and_the_probe(molecule):
    own = radii(molecule, "bondi")
    dots = replace(molecular_surface(molecule.xyz[0].round(3), own, 1.6), origin=None)
    settings = asked(["mean_curvature"], n_dots=9).model_copy(
        update={"surface": Settings(surface={"radii": "bondi", "probe_radius": 1.6}).surface}
    )
    moved = molecule.xyz + np.random.default_rng(0).normal(size=molecule.xyz.shape)
    number = np.arange(2)  # of frames, of which the dots lie on the first
    frames = {"xyz": np.concatenate([molecule.xyz, moved]), "time_ps": 1.0 * number, "frame_number": number}
    moving = replace(molecule, **frames)
    bend = represent(dots, settings, Streams(), moving).surface.fields["mean_curvature"]
    contact = dots.kind == 0
    assert bend[contact] == pytest.approx(1 / own[dots.atom[contact]]) and np.isfinite(bend).all()
    assert (dots.kind == 2).any() and bend[dots.kind == 2] == pytest.approx(-1 / 1.6)


@pytest.mark.parametrize("exact", [20.7, 31.3, 31])
@pytest.mark.parametrize("key", ["percent", "density", "n_dots"])
def test_the_number_of_dots_is_that_of_the_request(dots, key, exact):
    whole = {"percent": len(dots) / 100, "density": dots.area.sum(), "n_dots": 1}[key]
    asked_for = round(exact) if key == "n_dots" else exact / whole
    few = represent(dots, asked(**{key: asked_for}), Streams(1, "a")).subset
    assert len(few) == round(exact) and few.weight.sum() == len(dots) and few.interval is None


def test_a_subset_has_a_dot_at_least_and_no_more_than_the_surface(dots):
    assert len(represent(dots, asked(percent=0.001), Streams()).subset) == 1
    assert len(represent(dots, asked(density=1e-4), Streams()).subset) == 1
    for name, said in (("q", "but q has"), ("", "but the surface has")):
        with pytest.raises(InputError, match=f"^density is 9, {said} 5.* dots per"):
            represent(dots, asked(density=9), Streams(1, name))


def test_the_seed_and_the_sampler_choose_the_dots_and_the_name_does_not(dots):
    def chosen(seed, name, sampler):
        return represent(dots, asked(n_dots=40, sampler=sampler), Streams(seed, name)).subset.dots.tolist()

    first = chosen(1, "a", "uniform")
    assert first == chosen(1, "b", "uniform") != chosen(2, "a", "uniform")
    assert sorted(first) != sorted(chosen(1, "a", "poisson"))


def test_the_request_for_a_z_or_a_combination_reaches_the_search(dots):
    result = represent(dots, asked(max_z=2.0, test_dots=10), Streams(1))
    assert len(result.trials.tests) == 10
    assert result.trials.z(len(result.subset)) <= 2.0 < result.trials.z(len(result.subset) - 1)
    sampled = represent(dots, asked(combination=[0.5, 0, 2.0, 0]), Streams(1))
    assert np.array_equal(sampled.subset.dots, sampled.trials.prepared.pair((0.5, 0, 2.0, 0), 0)[0])
    choices = Choices(np.array([0.0]), np.array([[1.0, 0.0, 0.0, 0.0]]))
    own, published = (
        represent(dots, asked(percent=30, sampler="paper"), Streams(1), **given).subset.dots
        for given in ({"choices": choices}, {})
    )
    assert not np.array_equal(own, published)


def test_hydrogens_ask_for_more_dots_at_first(dots, molecule):
    """The search for an error starts at the dots of the law, of which a molecule with hydrogens needs a fifth more."""
    tried = []
    for name in ("CB", "H"):
        element = np.where((molecule.name == "CB") & (name == "H"), "H", molecule.element)
        result = represent(dots, asked(error=0.06), Streams(1), replace(molecule, element=element))
        tried.append(next(iter(result.trials._errors)))
    assert tried == [np.ceil(dots.area.sum() * share / 0.06) for share in (0.0125, 0.015)]


def test_a_surface_of_dots_alone_is_represented(blob):
    few = represent(Surface(*blob), asked(n_dots=20), Streams(1)).subset
    assert len(few) == 20 and list(few.table)[-1] == "reach"
