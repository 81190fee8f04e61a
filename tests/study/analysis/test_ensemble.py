"""One combination over frames: the same rows whatever the threads and jobs, and the chain's own surface."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import sparsurf
from peptides import peptide, write
from small_study import run_script
from sparsurf.errors import InputError
from sparsurf.evaluation import frames
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.residues import residue_table
from sparsurf.evaluation.statistics import estimate
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.sampling import published
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import density_for_d_link, molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf_study.analysis import ensemble
from sparsurf_study.settings import StudySettings

SETTINGS = StudySettings(surface={"density": 6.0}, patches={"d_link": 0.6}, ensemble={"test_dots": 20})
STREAMS = Streams(3, "p")
FRAMES = 7


@pytest.fixture(scope="module")
def molecule(tmp_path_factory):
    """Seven models of a peptide, the last residue farther out in each."""
    models = ""
    for k in range(FRAMES):
        models += f"MODEL     {k + 1:4d}\n{peptide()}{peptide(['ALA'], 'B', 9, (0, 0, 4 + 0.5 * k))}ENDMDL\n"
    return read_molecule(write(tmp_path_factory.mktemp("models") / "m.pdb", models + "END\n"))


@pytest.fixture(scope="module")
def table(molecule):
    return ensemble.evaluate_frames(molecule, SETTINGS, STREAMS, 1)


def test_one_row_per_frame_in_order(table):
    assert table["frame"].tolist() == list(range(FRAMES))
    assert table["time_ps"].isna().all()
    first = ["frame", "time_ps", "N", "area", "mean_roughness", "n_S", "n_S_percent", "n_S_expected"]
    assert table.columns[:8].tolist() == first
    for reading in ("kept", "full"):
        for name in ("Z_tS", "Z_tR", "d"):
            assert np.isfinite(table[f"{name}_{reading}"]).all()
            assert (table[f"{name}_se_{reading}"] > 0).all()
        difference = table[f"Z_tR_{reading}"] - table[f"Z_tS_{reading}"]
        assert np.allclose(table[f"d_{reading}"], difference, atol=1e-9)


@pytest.mark.parametrize("n", [2, 3, 9])
def test_parts_gathered_are_the_whole_to_the_last_byte(molecule, table, tmp_path, monkeypatch, n):
    """Seven frames; nine parts leave two without any. Progress counts the frames of the part."""
    monkeypatch.setattr(ensemble, "FRAMES_PER_REPORT", 2)
    molecule.write_pdb(structure := tmp_path / "own.pdb")
    written, counted = {}, []
    for name, n_parts in (("whole", 1), ("parts", n)):
        rows = [tmp_path / f"{name}_{k}" for k in range(1, n_parts + 1)]
        for k, path in enumerate(rows, 1):
            note = lambda *done: counted.append(done)  # noqa: E731
            part = ensemble.evaluate_frames(molecule, SETTINGS, STREAMS, 1, note, (k, n_parts))
            part.to_csv(path, index=False)
        outputs = {key: tmp_path / f"{name}_{key}.csv" for key in ("table", "over_time", "residues")}
        inputs = {"structure": structure, "rows": rows}
        run_script("follow_ensemble", tmp_path, inputs, outputs, {"molecule_options": {}})
        written[name] = [path.read_bytes() for path in outputs.values()]
    assert written["whole"] == written["parts"] and len(pd.read_csv(tmp_path / "parts_table.csv")) == FRAMES
    assert counted[:4] == [(2, 7), (4, 7), (6, 7), (7, 7)]
    assert sum(done for done, of in counted[4:] if done == of) == FRAMES


def test_a_row_is_what_the_parts_give(molecule, table):
    surface = molecular_surface(molecule.xyz[3], radii(molecule), density=6.0)
    prepared = PreparedSurface(surface, StudySettings(patches={"d_link": 0.6}), streams=Streams(3, "p/f3"))
    row = table.iloc[3]
    assert row["N"] == len(surface)
    assert row["area"] == pytest.approx(
        sparsurf.areas(molecule, frame=3).residues["excluded"].sum(), rel=1e-9
    )
    assert row["mean_roughness"] == prepared.roughness.mean()
    n_kept = len(prepared.pair([1, 0, 6, 0], 0)[0])
    assert row["n_S"] == n_kept
    assert row["n_S_percent"] == pytest.approx(100 * n_kept / len(surface))
    for reading in ("kept", "full"):
        tests, pair = prepared.draw_tests(20), prepared.pair([1, 0, 6, 0], 0)
        z = estimate(prepared.distances(pair[:1], tests, prepared.describe(tests)[0], reading)[0])
        assert row[[f"Z_tS_{reading}", f"Z_tS_se_{reading}"]].tolist() == pytest.approx(
            [z.mean, z.error], rel=1e-6
        )
    moved = replace(molecule, time_ps=2.0 * np.arange(FRAMES), frame_number=10 * np.arange(FRAMES))
    of_frame = ensemble.frame_row(moved, 3, radii(molecule), SETTINGS, STREAMS)
    assert (of_frame["time_ps"], of_frame["frame"]) == (6, 30)
    prepared = PreparedSurface(surface, StudySettings(patches={"d_link": 0.6}), streams=Streams(3, "p/f30"))
    tests = prepared.draw_tests(20)
    z, _ = prepared.distances(prepared.pair([1, 0, 6, 0], 0), tests, prepared.describe(tests)[0], "full")
    assert [of_frame["Z_tS_full"], of_frame["Z_tR_full"]] == pytest.approx(z.mean(axis=1), rel=1e-6)


def test_other_combinations_and_readings_are_evaluated_and_threads_change_nothing(molecule, table):
    both = ensemble.evaluate_frames(molecule, SETTINGS, STREAMS, 2, part=(1, 3))
    pd.testing.assert_frame_equal(both, table[:2])
    own = {"ensemble": SETTINGS.ensemble.model_copy(update={"combination": [0.3, 0.0, 2.0, 0.0]})}
    own["evaluation"] = SETTINGS.evaluation.model_copy(update={"readings": ["full", "kept_scaled"]})
    rules = {"distance_from_moved_centre": False, "chance_in_every_patch": False}
    own["sampling"] = SETTINGS.sampling.model_copy(update=rules)
    row = ensemble.frame_row(molecule, 1, radii(molecule), SETTINGS.model_copy(update=own), STREAMS)
    surface = molecular_surface(molecule.xyz[1], radii(molecule), density=6.0)
    prepared = PreparedSurface(surface, SETTINGS, streams=Streams(3, "p/f1"))
    wanted = published.expected_n_s(prepared.corrected_cover, [own["ensemble"].combination])
    assert row["n_S_expected"] == pytest.approx(wanted[0])
    assert row["n_S"] < 0.8 * table["n_S"][1] and not [name for name in row if "kept" in name]


def test_an_error_names_the_frame(molecule, monkeypatch):
    def fail(*_):
        raise InputError("no atoms.")

    monkeypatch.setattr(frames, "roll_frame", fail)
    numbered = replace(molecule, frame_number=10 * np.arange(FRAMES))
    with pytest.raises(InputError, match="frame 30:"):
        ensemble.frame_row(numbered, 3, radii(molecule), SETTINGS, STREAMS)


def test_the_density_that_suits_the_first_frame_is_that_of_all(molecule):
    rules = {"density": "auto", "radii": "bondi", "probe_radius": 1.5}
    auto = SETTINGS.model_copy(update={"surface": SETTINGS.surface.model_copy(update=rules)})
    table = ensemble.evaluate_frames(molecule, auto, STREAMS, 1)
    own = radii(molecule, "bondi")
    density = density_for_d_link(molecule.xyz[0], own, auto.surface, 0.6, "p")
    surfaces = [molecular_surface(xyz, own, 1.5, density) for xyz in molecule.xyz]
    assert table["N"].tolist() == [len(surface) for surface in surfaces]


def test_every_frame_has_the_density_of_the_first(molecule, monkeypatch):
    first = molecule.xyz[0]

    def density_of(xyz, *_):
        return 6.0 if np.array_equal(xyz, first) else 7.0

    monkeypatch.setattr(ensemble, "density_for_d_link", density_of)
    table = ensemble.evaluate_frames(molecule, SETTINGS, STREAMS, 1, part=(4, 4))
    own = [len(molecular_surface(xyz, radii(molecule), density=6.0)) for xyz in molecule.xyz[-2:]]
    assert table["N"].tolist() == own


def test_a_surface_that_is_too_sparse_is_refused(molecule):
    sparse = SETTINGS.model_copy(update={"surface": SETTINGS.surface.model_copy(update={"density": 2.0})})
    with pytest.raises(InputError, match="frame 0: d_link"):
        ensemble.evaluate_frames(molecule, sparse, STREAMS, 1)


def test_residues_of_a_frame_are_those_of_its_surface(molecule, table):
    by_frame, over_time = ensemble.split_residue_columns(table, molecule.residues)
    assert not [name for name in by_frame if name.startswith("residue")]
    assert over_time.columns.tolist() == ["frame", "time_ps", *(f"A:ALA{k}" for k in range(1, 5)), "B:ALA9"]
    surface = molecular_surface(molecule.xyz[3].round(3), radii(molecule, "dms"), density=6.0)
    rough = PreparedSurface(surface, StudySettings(patches={"d_link": 0.6})).roughness
    expected = residue_table(surface, rough, molecule)["mean_roughness"]
    assert np.allclose(over_time.iloc[3, 2:].to_numpy(float), expected, atol=1e-12)


def test_walls_of_cavities_do_not_count_in_the_roughness_of_a_residue(molecule, table, monkeypatch):
    below = []

    def on_cavities(surface, components):
        below.append(surface.points[:, 2] < np.median(surface.points[:, 2]))
        return below[0]

    monkeypatch.setattr(frames, "on_cavities", on_cavities)
    row = ensemble.frame_row(molecule, 3, radii(molecule, "dms"), SETTINGS, STREAMS)
    surface = molecular_surface(molecule.xyz[3].round(3), radii(molecule, "dms"), density=6.0)
    rough, residue = (
        PreparedSurface(surface, StudySettings(patches={"d_link": 0.6})).roughness,
        molecule.residue_index[surface.atom],
    )
    for k in range(molecule.n_residues):
        inside = (residue == k) & ~below[0]
        assert row[f"residue_{k}"] == pytest.approx(rough[inside].mean(), abs=1e-12, nan_ok=True)
    assert row["mean_roughness"] == pytest.approx(table["mean_roughness"][3])  # of all dots
