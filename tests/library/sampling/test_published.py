"""The sampling: its cover, its probabilities, its closed form, the authors' counts."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from conftest import make_blob
from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness_of_patches
from sparsurf.sampling import published


@pytest.fixture(scope="module")
def prepared(blob):
    index = build_index(*blob, 0.8)
    rough = roughness_of_patches(index, 4.0)
    return index, rough, published.build_cover(index, rough, 4.0)


@pytest.fixture(scope="module")
def a1_cover(a1):
    index = build_index(a1.points, a1.normals)
    return published.build_cover(index, roughness_of_patches(index, 4.0), 4.0)


def test_cover_equals_the_plain_sweep(blob, prepared):
    _, rough, cover = prepared
    plain = naive.cover(blob[0], 4.0, 0.8)
    assert cover.centre.tolist() == [centre for _, centre, _ in plain]
    for c, (starter, centre, dots) in enumerate(plain):
        pairs = slice(cover.start[c], cover.start[c + 1])
        order = np.argsort(cover.dot[pairs])
        assert np.array_equal(cover.dot[pairs][order], dots)
        distance = np.linalg.norm(blob[0][dots] - blob[0][centre], axis=1)
        assert np.allclose(4.0 * np.exp(-cover.log_ratio[pairs][order]), distance, atol=1e-12)
        assert cover.roughness[c] == rough[starter]


def test_closed_form_equals_the_plain_product():
    """Of several combinations at once; some pairs are farther apart than r_patch, where p would exceed 1."""
    turn = np.linspace(0, 2 * np.pi, 40)
    # beside a blob, a dot in the middle of a ring: the ring is its patch, with a centre of its own
    ring = [[40.0, 0, 0], *np.column_stack([40 + 3 * np.cos(turn), 3 * np.sin(turn), 0 * turn])]
    points, normals = (
        np.concatenate(each) for each in zip(make_blob(1000), (ring, np.eye(3)[[2] * 41]), strict=True)
    )
    index, plain = build_index(points, normals, 0.75), naive.cover(points, 4.0, 0.75)
    rough = roughness_of_patches(index)
    combinations = [
        (0.6, 0.4, 2, 4), (1, 0, 2, 0), (1, 0, 10, 10), (0.9, 0, 10, 4), (0.3, 0.4, 2, 4), (1, 1, 0, 4),
    ]  # fmt: skip
    found = published.expected_n_s(published.build_cover(index, rough), combinations)
    above_one = 0
    for combination, expected in zip(combinations, found, strict=True):
        left_out = np.ones(len(points))
        for starter, centre, dots in plain:
            distance = np.linalg.norm(points[dots] - points[centre], axis=1)
            p = naive.probability(*combination, rough[starter], distance, 4.0)
            above_one += (p > 1).sum()
            left_out[dots] *= 1 - np.clip(p, 0, 1)
            left_out[centre] = 0
        assert expected == pytest.approx((1 - left_out).sum(), rel=1e-12)
    assert above_one > 0


@settings(max_examples=25)
@given(st.floats(0.01, 1.0), st.floats(0, 3), st.floats(0, 12), st.floats(0, 12), st.integers(0, 2**32))
def test_draws_scatter_about_the_closed_form(prepared, alpha, beta, gamma, delta, seed):
    # n_S is a sum of independent 0/1 variables, so its variance is at most its mean: 40 draws put the mean
    # within 5 sqrt(mean / 40) of the closed form but once in two million
    _, _, cover = prepared
    rng = np.random.default_rng(seed)
    combination = (alpha, beta, gamma, delta)
    expected = published.expected_n_s(cover, [combination])[0]
    mean = np.mean([len(published.sample_cover(cover, combination, rng)) for _ in range(40)])
    assert abs(mean - expected) <= 5 * np.sqrt(expected / 40)


def test_flat_patches_and_powers_of_zero(prepared):
    # beta = gamma = delta = 0, alpha = 1: every dot of every patch is kept, the centres at r = 0 included
    _, _, cover = prepared
    kept = published.sample_cover(cover, (1, 0, 0, 0), np.random.default_rng(0))
    assert np.array_equal(kept, np.unique(cover.dot))
    flat = cover._replace(roughness=np.ones_like(cover.roughness))  # (1 - R)^0
    assert np.array_equal(published.sample_cover(flat, (1, 0, 0, 0), np.random.default_rng(0)), kept)
    _, _, cover = prepared
    flat = cover._replace(roughness=np.ones_like(cover.roughness))
    kept = published.sample_cover(flat, (1, 0.5, 0, 0), np.random.default_rng(0))
    assert np.array_equal(kept, np.unique(cover.centre))
    assert published.expected_n_s(flat, [(1, 0.5, 0, 0)])[0] == pytest.approx(len(kept), rel=1e-12)
    _, _, cover = prepared
    kept = published.sample_cover(cover, (1e-9, 1, 10, 10), np.random.default_rng(0))
    assert np.array_equal(kept, np.unique(cover.centre))


def test_one_chance_per_dot_is_a_uniform_draw(blob, prepared):
    # As corrected, alpha .2 with beta = gamma = delta = 0 keeps every dot with probability .2; only the
    # centres are kept for certain.
    index, rough, _ = prepared
    cover = published.build_cover(index, rough, distance_from_moved_centre=False, chance_in_every_patch=False)
    assert np.array_equal(np.sort(cover.dot), np.unique(cover.dot))
    centres = len(np.unique(cover.centre))
    covered = len(np.setdiff1d(cover.dot, cover.centre))
    assert published.expected_n_s(cover, [(0.2, 0, 0, 0)])[0] == pytest.approx(
        centres + 0.2 * covered, rel=1e-12
    )


def test_distances_from_the_dot_itself_never_exceed_r_patch(a1):
    index = build_index(a1.points, a1.normals)
    rough = roughness_of_patches(index)
    assert published.build_cover(index, rough, distance_from_moved_centre=False).log_ratio.min() >= 0
    as_published = published.build_cover(index, rough)
    assert np.exp(-as_published.log_ratio.min()) == pytest.approx(
        1.16, abs=0.005
    )  # r / r_patch, measured by the authors' code


def test_grid_runs_over_all_combinations():
    grid = published.parameter_grid([0.1, 1], [0, 0.2, 0.4], [0, 2, 4], [10])
    assert grid.tolist() == [[a, b, g, 10] for a in (0.1, 1) for b in (0, 0.2, 0.4) for g in (0, 2, 4)]


@given(st.integers(1, 200), st.integers(0, 2**32))
def test_uniform_subset_has_exactly_n_distinct_dots(n, seed):
    rng = np.random.default_rng(seed)
    requested = int(rng.integers(0, n + 1))
    subset = published.uniform_subset(n, requested, rng)
    assert len(subset) == requested and len(np.unique(subset)) == requested
    assert requested == 0 or (subset.min() >= 0 and subset.max() < n)


def test_centres_counts_and_range_of_a1_are_those_of_the_authors(a1_cover, shared):
    assert len(a1_cover.centre) == 181
    values = [0.1, 0.2, 0.4, 0.6, 0.8, 1.0], [0, 0.2, 0.4, 0.6, 0.8, 1.0], range(0, 11, 2), range(0, 11, 2)
    grid = published.parameter_grid(*map(list, values))
    percent = 100 * published.expected_n_s(a1_cover, grid) / a1_cover.n_dots
    assert len(grid) == 1296
    assert 2.4 < percent.min() < 2.8
    assert percent.max() == pytest.approx(99.73, abs=0.005)
    # three runs of their code per combination, each within 4 standard deviations of the closed form; the variance
    # of a count is at most its mean
    counts = pd.read_csv(shared / "oracle" / "a1_sampling_counts.csv")
    expected = published.expected_n_s(a1_cover, counts[["alpha", "beta", "gamma", "delta"]].to_numpy())
    assert (np.abs(counts["n_S"] - expected) < 4 * np.sqrt(expected)).all()
    rng = np.random.default_rng(7)
    for combination in [(0.4, 0.2, 10, 10), (1, 0, 6, 0), (0.2, 0, 0, 0)]:
        n = np.array([len(published.sample_cover(a1_cover, combination, rng)) for _ in range(60)])
        error = n.std(ddof=1) / np.sqrt(len(n))
        assert abs(n.mean() - published.expected_n_s(a1_cover, [combination])[0]) < 4 * error
    # beta = gamma = delta = 0 at alpha .2 keeps 47.9 % of A1 in one draw, not 20 %; the variance of a count is at most
    # N / 4, so one draw scatters by 0.35 points
    percent = 100 * published.expected_n_s(a1_cover, [(0.2, 0, 0, 0)])[0] / a1_cover.n_dots
    assert percent == pytest.approx(47.9, abs=0.7)
