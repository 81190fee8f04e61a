"""Atoms around a point by what they can bind, and the attempt to beat residue composition across folds with them."""

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT
from measures import atom_channels
from sparsurf.molecules.read_molecule import read_molecule


@pytest.fixture(scope="module")
def peptide():
    return read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="216-232")


def test_atoms_are_counted_in_shells_of_their_channels(peptide):
    names = [
        f"{peptide.residues['residue_name'][k]}:{n}"
        for k, n in zip(peptide.residue_index, peptide.name, strict=True)
    ]
    kinds = pd.DataFrame(atom_channels.channels(peptide), names, atom_channels.CHANNELS)
    assert kinds.loc[["ARG:NH1"]].iloc[0].to_list() == [1, 0, 0, 0, 1, 0]
    assert kinds.loc[["ASP:OD1"]].iloc[0].to_list() == [0, 1, 0, 0, 0, 1]
    assert kinds.loc[["PHE:CZ"]].iloc[0].to_list() == [0, 0, 1, 0, 0, 0]
    assert kinds.loc[["PHE:CA"]].iloc[0].to_list() == [0, 0, 0, 1, 0, 0]
    ring = [name.startswith("PHE:C") and name not in ("PHE:C", "PHE:CA", "PHE:CB") for name in names]
    assert (kinds["aromatic"] == ring).all()
    far = peptide.xyz[0].max(axis=0) + np.array([0.0, 0, 5])
    distance = np.linalg.norm(peptide.xyz[0] - far, axis=1)
    soft = (
        np.exp(-(((distance[distance < 10] - 9) / 1.2) ** 2) / 2) @ kinds["donor"].to_numpy()[distance < 10]
    )
    assert atom_channels.around(peptide, far[None])[0, 0, 3] == pytest.approx(np.sqrt(soft))


def test_folds_join_proteins_of_a_common_neighbour():
    names = ["a", "b", "c", "d"]
    tm = pd.Series({("a", "b"): 0.2, ("a", "c"): 0.6, ("c", "b"): 0.7, ("a", "d"): 0.4})
    fold = atom_channels.folds(names, tm)
    assert len(set(fold[:3])) == 1 and fold[3] != fold[0]


def test_the_difference_is_over_queries():
    rows = [
        {"query": q, "half": half, "method": method, "right": right}
        for q, half, learned, plain in (("a", 1, [1, 1], [0, 1]), ("b", 2, [0], [1]), ("c", 2, [1], [0]))
        for method, answers in ((atom_channels.CHANNELS_LEARNED, learned), (atom_channels.COMPOSITION, plain))
        for right in answers
    ]
    table = atom_channels.means(pd.DataFrame(rows)).set_index(["half", "method"])
    assert table.loc[("both", "difference"), "right"] == pytest.approx((0.5 - 1 + 1) / 3)
    assert table.loc[("both", "difference"), ["pairs", "queries"]].to_list() == [4, 3]
    assert table.loc[("2", "difference"), ["right_low", "right_high"]].to_list() == [-1, 1]


def test_a_site_planted_on_another_fold_is_found(peptide):
    """Two copies of one peptide under names of two folds, the cofactor on one side; the other two sites teach."""
    names, points = ["a", "b", "c", "d"], peptide.xyz[0].max(axis=0) + np.array([[0.0, 0, 3], [-30.0, 0, 3]])
    tm = pd.Series({(p, q): 0.2 if {p, q} != {"a", "b"} else 0.6 for p in names for q in names})
    moved = atom_channels.relatives([(peptide, peptide)], [peptide.xyz[0][:60] + 3.0])
    np.testing.assert_allclose(moved[0], moved[1], atol=1e-9)
    noisy = np.stack([moved[0], moved[1] + 0.1 * np.random.default_rng(0).random(moved[1].shape)])
    above = [np.concatenate([points, peptide.xyz[0] + 2.0])] * 4
    table = atom_channels.measure(names, ["X"] * 4, [peptide] * 4, [points[0]] * 4, above, tm, noisy)
    assert table["right"].all() and set(table["half"]) == {2}
    assert sorted(zip(table["query"], table["target"], strict=True))[::2] == [("c", "d"), ("d", "c")]
