"""Smoothing, interface, areas under the curve, references: exact cases and plain references."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.distance import cdist
from scipy.stats import mannwhitneyu, t

from conftest import make_blob
from sparsurf_study.pairs.neighbourhoods import means_within, protrusion, smooth
from sparsurf_study.pairs.partners import interface, native_pairs
from sparsurf_study.pairs.ranking import auc, blocks_of_residues, bootstrap_auc, means_over_pairs


@pytest.fixture(scope="module")
def dots():
    return make_blob(800)[0]


def test_means_equal_the_plain_mean(dots):
    rng = np.random.default_rng(1)
    points, places, values = (
        np.append(dots, [[40.0, 0, 0]], axis=0),
        dots[::3],
        rng.normal(size=(len(dots[::3]), 2)),
    )
    means, counts = means_within(points, places, values, 4.0, threads=2)
    near = cdist(points, places) <= 4.0
    assert np.array_equal(counts, near.sum(axis=1))
    some = counts > 0
    assert np.allclose(means[some], (near @ values)[some] / counts[some, None], rtol=1e-12)
    assert not some[-1] and np.isnan(means[~some]).all()


def test_smoothing_and_protrusion_of_known_maps():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [20, 0, 0]])
    centres, values = np.array([0, 2]), np.array([1.0, 5.0])
    assert smooth(points, centres, values, 1.5).tolist() == [1.0, 3.0, 5.0, 5.0]
    assert smooth(points, centres, values, 0.0).tolist() == [1.0, 1.0, 5.0, 5.0]
    assert smooth(points, centres, np.full(2, 0.25), 6.0).tolist() == [0.25] * 4
    atoms = np.array([[0.0, 0, 0], [3, 0, 0], [10, 0, 0], [30, 0, 0]])
    assert protrusion(np.array([[0.0, 0, 0], [30, 0, 0]]), atoms).tolist() == [-3.0, -1.0]


def test_touching_is_nearer_than_three_angstrom():
    x, y = np.meshgrid(np.arange(10.0), np.arange(10.0))
    lower = np.stack([x.ravel(), y.ravel(), np.zeros(100)], axis=1)
    upper = lower[lower[:, 0] >= 5] + [0, 0, 2.5]
    touching = interface(lower, upper)
    # 2.5 Å above, and one step of 1 Å beside: 2.69 Å; two steps: 3.2 Å
    assert np.array_equal(touching, lower[:, 0] >= 4)
    pairs = native_pairs(lower, upper)
    assert np.array_equal(pairs[:, 0], np.flatnonzero(touching))
    above = lower[:, 0][pairs[:, 0]] >= 5
    assert np.allclose(upper[pairs[above, 1]], lower[pairs[above, 0]] + [0, 0, 2.5])
    points, partner = (
        np.array([[0.0, 0, 0], [5, 0, 0], [9, 0, 0]]),
        np.array([[9.0, 2, 0], [0, 3, 0], [5, 2, 0]]),
    )
    assert interface(points, partner).tolist() == [False, True, True]
    assert native_pairs(points, partner).tolist() == [[1, 2], [2, 0]]


def test_areas_of_rankings():
    labels = np.array([True, True, False, False])
    assert auc(np.array([4.0, 3, 2, 1]), labels) == 1.0
    assert auc(np.array([1.0, 2, 3, 4]), labels) == 0.0
    assert auc(np.array([1.0, 1, 1, 1]), labels) == 0.5
    assert auc(np.array([4.0, 1, 3, 2]), labels) == 0.5
    assert auc(np.array([2e-13, 3e-16, 1e-15, 0]), labels) == 0.5  # rounding errors are ties
    assert auc(np.array([2e-8, 1e-8, 0, 0]), labels) == 1.0
    assert np.isnan(auc(np.arange(4.0), np.ones(4, bool)))
    rng = np.random.default_rng(2)
    score, labels = rng.integers(0, 30, 400).astype(float), rng.random(400) < 0.3
    u = mannwhitneyu(score[labels], score[~labels]).statistic / labels.sum() / (~labels).sum()
    assert auc(score, labels) == pytest.approx(u, abs=1e-12)
    times = rng.integers(0, 4, (2, 400))
    repeated = [auc(np.repeat(score, t), np.repeat(labels, t)) for t in times]
    assert np.allclose(auc(score, labels, times), repeated, atol=1e-12)


def test_blocks_keep_residues_whole_and_stay_short(dots):
    residue = np.round(dots[:, 0] / 3).astype(int) * 10 + np.round(dots[:, 1] / 3).astype(int)
    block = blocks_of_residues(dots, residue, 6.0)
    assert sorted(set(block)) == list(range(block.max() + 1))
    assert block.max() > 3
    for each in np.unique(residue):
        assert len(set(block[residue == each])) == 1
    middles = np.array([dots[residue == each].mean(axis=0) for each in np.unique(residue)])
    owner = np.array([block[residue == each][0] for each in np.unique(residue)])
    for each in range(block.max() + 1):
        assert cdist(middles[owner == each], middles[owner == each]).max() <= 12.0
    # the first lies at 0, the farthest from it at 16 begins the second; 7 stays with 0, 9 goes over
    points = np.array([[0.0, 0, 0], [7, 0, 0], [9, 0, 0], [16, 0, 0]])
    assert blocks_of_residues(points, np.arange(4), 10.0).tolist() == [0, 0, 1, 1]
    twice = blocks_of_residues(np.repeat(points, 2, axis=0), np.repeat(np.arange(4), 2), 10.0)
    assert twice.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]


def test_draws_without_an_answer_and_single_blocks_do_not_count():
    # two dots: a draw that holds both has the area 1, one that holds one of them twice has none
    score, positive = np.array([1.0, 0.0, np.nan]), np.array([True, False, False])
    found = bootstrap_auc({"score": score}, positive, np.array([0, 1, 1]), np.random.default_rng(0))
    assert found == {"score": (1.0, 1.0, 1.0)}
    score, positive = {"score": np.array([2.0, 1.0, 0.0])}, np.array([True, False, False])
    area, *interval = bootstrap_auc(score, positive, np.zeros(3, int), np.random.default_rng(0))["score"]
    assert area == 1.0 and np.isnan(interval).all()


def test_the_interval_holds_95_percent():
    rng = np.random.default_rng(6)
    positive = np.arange(60) < 30
    score = rng.normal(size=60) + positive
    _, low, high = bootstrap_auc({"s": score}, positive, np.arange(60), rng, 2000)["s"]
    some = rng.integers(0, 60, (2000, 60))
    drawn = np.array([auc(score[k], positive[k]) for k in some])
    assert np.mean(drawn < low) == pytest.approx(0.025, abs=0.012)
    assert np.mean(drawn > high) == pytest.approx(0.025, abs=0.012)


def test_the_interval_is_wider_where_dots_come_in_blocks():
    rng = np.random.default_rng(3)
    block = np.repeat(np.arange(20), 50)
    labels = np.repeat(rng.random(20) < 0.5, 50)
    score = {"score": np.repeat(rng.normal(size=20), 50) + 0.3 * labels}
    area, low, high = bootstrap_auc(score, labels, block, np.random.default_rng(4))["score"]
    _, alone_low, alone_high = bootstrap_auc(score, labels, np.arange(1000), np.random.default_rng(4))[
        "score"
    ]
    assert low < area < high
    assert high - low > 3 * (alone_high - alone_low)
    again = bootstrap_auc(score, labels, block, np.random.default_rng(4))["score"]
    assert again == (area, low, high)


def test_means_over_pairs_average_the_sides_first():
    table = pd.DataFrame({"complex": list("aabb"), "score": "s", "auc": [0.44, 0.56, 0.5, 0.52]})
    row = means_over_pairs(table).iloc[0]
    half = t.ppf(0.975, 1) * np.std([0.5, 0.51], ddof=1) / np.sqrt(2)
    assert row[["mean", "low", "high"]].tolist() == pytest.approx([0.505, 0.505 - half, 0.505 + half])
    assert row["complexes"] == 2
    two = pd.concat([table.assign(score="z", size=9), table.iloc[[3, 0]].assign(size=[2, 1], auc=[0.7, 0.3])])
    found = means_over_pairs(two, ("score", "size"))
    assert found[["score", "size", "complexes"]].to_numpy().tolist() == [
        ["z", 9, 2],
        ["s", 2, 1],
        ["s", 1, 1],
    ]
    assert found["mean"].tolist() == pytest.approx(
        [0.505, 0.7, 0.3]
    )  # in order of appearance, each by itself
    far = means_over_pairs(table.assign(auc=[0.1, 0.3, 0.9, 0.9])).iloc[0]
    assert (far["low"], far["high"]) == (0, 1)
