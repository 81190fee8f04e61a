"""Finding sites again: outcomes against plain counts, where places moved to, and ranges of the tables."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import score_sites
from conftest import ROOT
from measures import sites
from measures.fpfh import fpfh
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.pairs.complexes import superpose_onto


def test_outcomes_are_those_of_plain_counting():
    rng = np.random.default_rng(0)
    distance, right = rng.random((5, 300)), rng.random((5, 300)) < 0.05
    right[4] = False
    found = sites.outcomes(distance, right)
    for i in range(4):
        order = np.argsort(distance[i])
        pairs = distance[i][right[i]][:, None] < distance[i][~right[i]]
        assert found["auc"][i] == pytest.approx(pairs.mean())
        assert found["first"][i] == right[i][order[0]]
        assert found["first_percent"][i] == right[i][order[:3]].any()
    assert np.isnan(found["auc"][4]) and not found["first_percent"][4]
    np.testing.assert_allclose(found["chance"], right.mean(axis=1))


def test_a_place_moves_as_the_atoms_around_it():
    bound = read_molecule(ROOT / "data" / "tdp43" / "topology.pdb")
    numbers = bound.residue_index
    moved = replace(bound, xyz=bound.xyz + np.where(numbers < 30, 0.0, 2.0)[None, :, None] * [1.0, 0, 0])
    ends = [bound.xyz[0][numbers == row].mean(axis=0) for row in (0, numbers.max())]
    mean, rms = sites.displacements(np.array([*ends, [1e3, 0, 0]]), bound, moved)
    np.testing.assert_allclose(mean[:2], [[0, 0, 0], [2, 0, 0]], atol=1e-12)
    assert rms[:2].tolist() == pytest.approx([0, 2]) and np.isnan(mean[2]).all() and np.isnan(rms[2])


def test_a_relative_is_numbered_by_its_alignment_where_the_backbones_meet():
    """It lacks two residues, has others in three places and an end that lies elsewhere, and is turned."""
    path = ROOT / "data" / "tdp43" / "topology.pdb"
    bound = read_molecule(path)
    own = read_molecule(path, residues="209-229,232-269")
    number, names = own.residue.astype(int), own.residue_name.copy()
    names[np.isin(number, [215, 240])] = "TRP"
    names[number == 250] = "XYZ"  # a residue that no table knows
    xyz = (own.xyz + np.where(number > 264, 25.0, 0.0)[None, :, None])[..., [1, 2, 0]] + 4.0
    other = replace(own, xyz=xyz, residue_name=names, residue=(number + 300).astype(str))
    found, alike = sites.numbered_as(other, bound)
    apart = np.isin(number, [228, 229]) | (number > 264)  # the first two: the gap may lie before them
    wanted = np.where(apart, "own", own.residue)
    assert [each.split()[0] for each in found.residue] == wanted.tolist() and len(found.residues) == 59
    assert alike == pytest.approx((59 - 7 - 3) / (59 - 7))
    moved = superpose_onto(found, bound)
    kept = ~apart
    np.testing.assert_allclose(moved.xyz[0][kept], own.xyz[0][kept], atol=1e-6)


def test_every_described_opponent_is_scored(monkeypatch):
    rng = np.random.default_rng(0)
    places = 9 * rng.random((9, 3))
    arrays = {"place 10": places, "place of all": places, "true": places[:4]}
    arrays |= {"interface": np.array([True, True, False, False]), "moved": np.array([0.0, 3, 0, np.nan])}
    arrays |= {"query FPFH": rng.random((4, 33)), "target FPFH": rng.random((9, 33))}
    monkeypatch.setattr(sites, "CHANNELS", {})
    assert {row["channels"] for row in sites.scores(arrays, None)} == {"FPFH"}


def test_histograms_of_features_are_those_by_hand():
    """Of three dots on a line across their normals, and of one far away."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0], [99, 0, 0]])
    tilted = np.array([0, np.sin(1.0), np.cos(1.0)])  # by 1 rad around the line
    normals = np.array([[0.0, 0, 1], [0, 0, 1], tilted, [0, 0, 1]])
    found = fpfh(points, normals, 2.5).reshape(4, 3, 11)
    # line x normal is -y: the tilted normal lies at atan2(0, cos 1) = 0 and at -sin 1 = -0.84 along it, bin 0
    assert np.argwhere(found[0] > 0).tolist() == [[0, 5], [1, 0], [1, 5], [2, 5]]
    own, weights = {0: [0, 100], 1: [50, 50], 2: [100, 0]}, {(0, 1): 1.0, (1, 2): 0.25}
    np.testing.assert_allclose(found[0, 1, [0, 5]], np.add(own[0], own[1]))
    beside = (weights[0, 1] * np.array(own[0]) + weights[1, 2] * np.array(own[2])) / 1.25
    np.testing.assert_allclose(found[1, 1, [0, 5]], own[1] + beside)
    np.testing.assert_allclose(found.sum(axis=2)[:3], 200)
    assert not found[3].any()
    turn = Rotation.random(random_state=2).as_matrix()
    np.testing.assert_allclose(fpfh(points @ turn, normals @ turn, 2.5).reshape(4, 3, 11)[:2], found[:2])


def test_the_potential_is_that_of_apbs(tmp_path):
    """The potential outside a ball with a charge at its centre is Coulomb's, screened by water and salt (Debye and Hückel)."""
    measured = pytest.importorskip("measure_potential")
    (tmp_path / "molecule.pqr").write_text(
        "ATOM      1  N   ION     1       0.000   0.000   0.000  1.0000 3.0000\n"
    )
    points = np.array([[6.0, 0, 0], [0, 8, 0], [0, 0, -10]])
    r = np.linalg.norm(points, axis=1)
    found = measured.solution(tmp_path, np.full(3, 26.0), points)
    inside = 3.0 + 2.0  # ions come as near as the sum of both radii
    np.testing.assert_allclose(
        found, 561.0 / 78.54 * np.exp(-(r - inside) / 7.9) / (1 + inside / 7.9) / r, rtol=0.06
    )


def test_places_are_counted_in_the_range_of_their_move():
    moved = pd.DataFrame({"moved": [0.1, 0.5, 0.9, 7.0], "first": [1, 1, 0, 0]})
    table = score_sites._by_range(moved.assign(first_percent=1, first_of_all=0))
    assert table["moved"].to_list() == [0.0, 0.5, 2.0] and table["below"].to_list() == [0.5, 1.0, np.inf]
    assert table["first"].to_list() == [1, 0.5, 0] and table["places"].to_list() == [1, 2, 1]


def test_every_dot_is_a_place_where_all_are_kept():
    row = {"protein": "a", "atoms": 5, "dots": 100, "places": 10, "bytes": 5e6, "seconds": 2.0}
    costs = pd.DataFrame([row | {"percent": 100.0}, row | {"percent": 10.0, "dots": 10}])
    table = score_sites._costs(costs).set_index("percent")
    assert table.loc[100, ["places", "megabytes", "seconds"]].to_list() == [100, 50, 20]
    assert table.loc[10, ["places", "megabytes", "seconds"]].to_list() == [10, 5, 2]
