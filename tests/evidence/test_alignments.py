"""Places moved by alignments, means over the relatives of each protein, and sites of cofactors across folds."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from conftest import ROOT
from measures import alignments, cofactors
from sparsurf.molecules.read_molecule import read_molecule
from tabulate_relatives import means_over_proteins

PATH = ROOT / "data" / "tdp43" / "topology.pdb"
TURN, SHIFT = Rotation.random(random_state=0).as_matrix(), np.array([5.0, -3, 20])


@pytest.fixture(scope="module")
def both():
    """A molecule, and the same without three residues, turned; its last ten residues are moved by 4 Å before."""
    query = read_molecule(PATH)
    target = read_molecule(PATH, residues="209-229,233-269")
    moved = target.residue.astype(int) >= 260
    xyz = target.xyz + np.where(moved, 4.0, 0.0)[None, :, None] * [1.0, 0, 0]
    return query, replace(target, xyz=xyz @ TURN + SHIFT)


def test_a_place_moves_with_the_aligned_residues_around_it(both):
    query, target = both
    number = query.residue.astype(int)
    here = np.stack([query.xyz[0][number == k].mean(axis=0) for k in (215, 245, 268)])
    there = (here + np.array([[0, 0, 0], [0, 0, 0], [4.0, 0, 0]])) @ TURN + SHIFT
    # at most 8 residues around each, of which the last has some that did not move
    off = np.linalg.norm(alignments.by_sequence(query, target, here) - there, axis=1)
    assert off[:2] == pytest.approx(0, abs=0.01) and off[2] < 2.5


def test_tm_align_superposes_what_did_not_move(both):
    pytest.importorskip("tmtools")
    query, target = both
    here = query.xyz[0][::50]
    keep = query.residue[::50].astype(int) < 255
    off = np.linalg.norm(alignments.by_structure(query, target, here) - (here @ TURN + SHIFT), axis=1)
    assert off[keep].max() < 1.0
    assert 0.7 < alignments.tm_align(query, target)[2] <= 1


def test_tm_align_is_left_out_without_its_package(monkeypatch, caplog):
    monkeypatch.setitem(__import__("sys").modules, "tmtools", None)
    assert [*alignments.alignments()] == [alignments.SEQUENCE]
    assert "TM-align is left out" in caplog.text


def test_relatives_of_one_protein_count_as_one():
    row = {"family": "f", "channels": "c", "places": "p", "identity": 0.5}
    row |= dict.fromkeys(("first_percent", "auc", "first_moved", "chance", "there", "whole"), 0.25)
    rows = [
        row | {"query": q, "first": v}
        for q, v in (("a", 0.0), ("a", 0.2), ("a", 0.4), ("b", 0.8), ("c", 0.5))
    ]
    mean = means_over_proteins(pd.DataFrame(rows)).iloc[0]
    assert mean["first"] == pytest.approx(0.5) and mean[["pairs", "proteins"]].to_list() == [5, 3]
    assert mean["first_low"] < 0.2 < 0.8 < mean["first_high"]  # of three proteins


def test_only_pairs_of_other_folds_count():
    rows = [
        {"query": q, "same_class": same, "class": kind, "tm": tm, "method": "find", "right": right}
        for q, same, kind, tm, right in (
            ("a", True, "HEM", 0.3, True),
            ("a", True, "HEM", 0.8, False),  # of the same fold
            ("b", True, "ATP", 0.3, False),
            ("b", False, "ATP", 0.3, True),
        )
    ]
    table = cofactors.means(pd.DataFrame(rows)).query("method == 'find'").set_index("cofactor")
    assert table["right"].to_dict() == {
        "the same": 0.5,
        "the same, heme": 1,
        "the same, not heme": 0,
        "another": 1,
    }
    assert table.loc["the same", ["pairs", "queries"]].to_list() == [2, 2]


def test_a_cofactor_is_placed_where_it_was_on_the_same_protein_turned(both):
    pytest.importorskip("tmtools")
    query, target = both
    near = ["A:235", "A:236", "A:237", "A:238", "A:239", "A:240"]
    chain = query.chain[0]
    residues = [each.replace("A", chain, 1) for each in near]
    ligand = query.xyz[0][np.isin(query.residue, ["237", "238"])]
    table = cofactors.measure(
        ["a", "b"], ["X", "X"], [residues, residues], [query, target], [ligand, ligand @ TURN + SHIFT]
    )
    table = table[table["query"] == "a"].set_index("method")
    assert table.loc[["find", "TM-align"], "right"].all() and table.loc["find", "off"] < 2
    assert 0 < table.loc[cofactors.CHANCE, "right"] < 0.5
