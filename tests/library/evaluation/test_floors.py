"""Noise floors, how many dots are enough for them, and the subset that stands on its own."""

import shutil
from types import SimpleNamespace

import mdtraj
import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

from conftest import ROOT
from measures import recovery
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.evaluation import floors as study_floors
from sparsurf.evaluation.floors import (
    floors_table,
    frames_at_gaps,
    random_rotation,
    read_distances,
    read_frames_around,
    write_distances,
)
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.required_dots import MIN_DOTS, Trials, required_dots_table
from sparsurf.evaluation.subset_search import smallest_recovered_subset
from sparsurf.molecules.read_molecule import read_molecule, read_study_structure
from sparsurf.patches.descriptors import describe
from sparsurf.patches.index import build_index
from sparsurf.recovery.recovering import recover
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import molecular_surface, surface_generator
from sparsurf.surfaces.radii import radii
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


@pytest.fixture(scope="module")
def table(distances):
    return floors_table(distances).set_index("floor")


@pytest.fixture(scope="module")
def distances(prepared):
    frames = {1.0: [ATOMS + np.array([0, 0, 4.0])], 20.0: [ATOMS * 1.1]}
    return study_floors.measure_floors(prepared, 60, lay, ATOMS, frames)


def test_floors_grow_with_what_changes(table):
    z = table["Z"]
    assert 0 < z["fresh dots"] < z["turned"]
    assert z["fresh dots"] < z["atoms moved 0.3 Å"] > z["atoms moved 0.1 Å"]
    assert z["frames 1 ps apart"] < 1.5 * z["fresh dots"]  # moved as a whole, patches go along
    assert z["frames 20 ps apart"] > z["frames 1 ps apart"]
    assert (table["low"] < z).all() and (table["test_dots"] == 60).all()
    assert table["draws"].tolist() == [10, 10, 3, 3, 1, 1]


def test_a_study_of_many_proteins_may_draw_fewer(prepared):
    few = floors_table(study_floors.measure_floors(prepared, 20, lay, ATOMS, moved=(), draws=2))
    assert few["draws"].tolist() == [2, 2] and few["floor"].tolist() == ["fresh dots", "turned"]


def test_the_same_dots_cost_nothing(prepared):
    z = study_floors.measure_floors(prepared, 40, lambda xyz: prepared.surface, ATOMS)
    assert z["atoms moved 0.1 Å"] == pytest.approx(np.zeros((3, 40)), abs=1e-9)  # nothing moved


def test_atoms_are_moved_by_the_rms_that_is_named(prepared):
    places = []
    study_floors.measure_floors(
        prepared, 5, lambda xyz: places.append(xyz) or prepared.surface, ATOMS, moved=(0.1, 3.0)
    )
    rms = [np.sqrt(((xyz - ATOMS) ** 2).sum(axis=1).mean()) for xyz in places[10:]]
    assert np.mean(rms[:3]) == pytest.approx(0.1, rel=0.2)  # 21 atoms, 63 numbers: 9 % of scatter
    assert np.mean(rms[3:]) == pytest.approx(3.0, rel=0.2)


def test_a_ready_surface_has_the_floors_of_its_dots(prepared, table):
    z = study_floors.measure_floors(prepared, 60)
    assert list(z) == ["fresh dots", "turned"]
    assert z["fresh dots"].mean() == pytest.approx(table.loc["fresh dots", "Z"], rel=0.3)


def test_frames_so_far_apart_are_found_and_superposed():
    times, turn = np.array([0.0, 1, 2, 21]), random_rotation(np.random.default_rng(0))
    frames = np.array([ATOMS, ATOMS @ turn + 3, ATOMS, ATOMS * 1.01])
    found = frames_at_gaps(SimpleNamespace(xyz=frames, time_ps=times), ATOMS, 1.0)
    assert {gap: len(places) for gap, places in found.items()} == {1.0: 2, 20.0: 1}
    assert found[1.0][0] == pytest.approx(ATOMS, abs=1e-9)
    turned = frames_at_gaps(SimpleNamespace(xyz=frames, time_ps=times), ATOMS, 0.0)
    assert turned[1.0][0] == pytest.approx(ATOMS, abs=1e-9)  # superposed


FRAMES_HEADER = "conformation,frame,time_ps,pc1,pc2,cluster,population,silhouette\n"


def floors_of_frame(folder, trajectory):
    """Read the frames around a frame of a trajectory, by gap; return them and its atoms."""
    molecule, rules = read_study_structure(folder / "own.pdb"), Settings().surface
    atoms = surface_generator(molecule, 0, radii(molecule, "dms"), rules, 0.5, "p")[1]
    structure, options = ROOT / "data" / "tdp43" / "topology.pdb", {"residues": "209-212"}
    frames = read_frames_around(folder / "frames.csv", "c1", structure, trajectory, options, atoms)
    return frames, atoms


def test_of_a_trajectory_only_frames_so_far_apart_are_read(tmp_path, monkeypatch):
    path, part, seen = ROOT / "data" / "tdp43", {"residues": "209-212"}, []
    whole = read_molecule(path / "topology.pdb", path / "trajectory.xtc", **part)
    whole.write_pdb(tmp_path / "own.pdb", 50)
    (tmp_path / "frames.csv").write_text(FRAMES_HEADER + "c1,50,50.0,1,2,1,9,0.5\n")

    def noted(*arguments, **keys):
        seen.append(read_molecule(*arguments, **keys))
        return seen[-1]

    monkeypatch.setattr(study_floors, "read_molecule", noted)
    monkeypatch.setattr("sparsurf.surfaces.molecular_surface.density_for_d_link", lambda *_: 1.0)
    frames, atoms = floors_of_frame(tmp_path, path / "trajectory.xtc")
    assert seen[0].frame_number.tolist() == [0, 30, 49, 50, 51, 70, 150]
    apart = frames_at_gaps(whole, atoms, 50.0)
    assert list(frames) == [1.0, 20.0, 100.0] and [*map(len, apart.values())] == [2, 2, 1]
    for gap, places in apart.items():
        assert np.array_equal(places, frames[gap])


def test_neighbours_that_a_trajectory_has_not_are_no_warning(tmp_path, monkeypatch, caplog):
    path, part = ROOT / "data" / "tdp43", {"residues": "209-212"}
    frames = mdtraj.load(str(path / "trajectory.xtc"), top=str(path / "topology.pdb"))[[3, 500]]
    monkeypatch.setattr("sparsurf.surfaces.molecular_surface.density_for_d_link", lambda *_: 1.0)
    read_molecule(path / "topology.pdb", **part).write_pdb(tmp_path / "own.pdb", 0)
    for ending, time, known in (("xtc", "500.0", {}), ("dcd", "", None)):  # a DCD has no times
        frames.save(str(tmp_path / f"two.{ending}"))
        (tmp_path / "frames.csv").write_text(FRAMES_HEADER + f"c1,1,{time},1,2,1,9,0.5\n")
        assert floors_of_frame(tmp_path, tmp_path / f"two.{ending}")[0] == known
    assert not [message for message in caplog.messages if "at any of the times" in message]


def test_turnings_are_rotations():
    turns = [random_rotation(np.random.default_rng(k)) for k in range(300)]
    assert all(np.allclose(t @ t.T, np.eye(3)) and np.linalg.det(t) > 0 for t in turns)
    assert np.abs(np.mean(turns, axis=0)).max() < 0.12  # no direction is favoured


def test_distances_come_back_from_their_file(distances, tmp_path):
    path = tmp_path / "floor_distances.npz"
    write_distances(path, distances)
    again = read_distances(path)
    assert list(again) == list(distances)
    assert all(np.array_equal(again[name], distances[name]) for name in distances)
    path.write_bytes(path.read_bytes()[:900])
    with pytest.raises(InputError, match=r"floor_distances\.npz is damaged: delete it"):
        read_distances(path)


def test_required_dots_are_where_the_curve_meets_the_floor(prepared, table, distances):
    wanted = distances
    trials = Trials(prepared, "farthest", 60)
    required_dots = required_dots_table(trials, wanted)
    by = required_dots.set_index(["floor", "reading"])
    assert by.loc[("fresh dots", "recovered"), "n_S"] < by.loc[("fresh dots", "full"), "n_S"]
    one = by.loc[("turned", "recovered")]
    dots, interval = smallest_recovered_subset(trials, wanted, "turned")
    assert len(dots) == one["n_S"] >= MIN_DOTS and interval[0] <= len(dots) <= interval[1] + 1
    tests = prepared.draw_tests(60)
    z, _ = prepared.distances([dots], tests, prepared.describe(tests)[0], "recovered")
    assert z.mean() <= 1.2 * table.loc["turned", "Z"] + 1.96 * np.hypot(
        z.std(ddof=1) / 60**0.5, table.loc["turned", "se"]
    )
    with pytest.raises(InputError, match="seven atoms only has fresh dots"):
        smallest_recovered_subset(trials, wanted, "no such floor")


def test_the_handed_out_dots_need_nothing_else(prepared, tmp_path, monkeypatch):
    """minimal.csv alone, in an empty folder: the surface, as npz, DMS and PLY, and descriptors around points."""
    chosen = SAMPLERS["farthest"](prepared, len(prepared.points) // 8, np.random.default_rng(0))
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
    points, _ = recover(*kept)
    for name in ("dense.npz", "dense.dms", "dense.csv"):
        assert read_surface(new / name).points == pytest.approx(points, abs=1e-3), name
    assert recovery.distances(points, recovery.truth(ATOMS, RADII)).mean() < 0.05
    z = pd.read_csv("z.csv").filter(like="z_").to_numpy()
    true = prepared.describe(chosen)[0]
    as_they_are, _ = prepared.distances([chosen], chosen, true, "full")
    assert np.linalg.norm(z - true, axis=1).mean() < 0.75 * as_they_are.mean()
    assert z == pytest.approx(describe(build_index(*recover(*kept)), kept[0])[0], rel=1e-5)
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
    points, normals = study_floors._fresh_dots(prepared, None, None, np.zeros(3), np.eye(3))
    gaps = cKDTree(prepared.points).query(points)[0]
    assert len(points) > 500 and gaps.min() > 1e-6
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)
