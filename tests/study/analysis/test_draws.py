"""Draws that must differ, weights that belong to their subset, numbers of test dots."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.evaluation.statistics import estimate
from sparsurf.evaluation.subset_search import find_subset
from sparsurf.sampling import published
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.settings import Settings
from sparsurf.streams import Streams, stream
from sparsurf_study.analysis import comparison, grid

COMBINATION = (0.5, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def prepared(blob):
    points, normals = blob
    return PreparedSurface(
        SimpleNamespace(points=points, normals=normals),
        Settings(patches={"d_link": 0.8}),
        streams=Streams(3, "blob"),
    )


def test_draws_of_a_combination_differ_and_so_do_their_uniform_subsets(prepared):
    pairs = [prepared.pair(COMBINATION, draw) for draw in (0, 1, 0)]
    for half in (0, 1):
        assert not np.array_equal(pairs[0][half], pairs[1][half])
        assert np.array_equal(pairs[0][half], pairs[2][half])
    # two uniform draws share no more dots than by chance: n m / N, within five standard deviations
    one, two = pairs[0][1], pairs[1][1]
    n, m, every = len(one), len(two), len(prepared.points)
    assert abs(len(np.intersect1d(one, two)) - n * m / every) < 5 * np.sqrt(n * m / every)


def test_uniform_subsets_of_a_draw_are_nested_and_every_dot_is_as_likely(prepared):
    small, large = (prepared.uniform(n, 4) for n in (100, 2000))
    assert len(small) == 100 and set(small) < set(large)
    assert np.array_equal(small, np.sort(small)) and np.array_equal(
        prepared.uniform(3000, 4), np.arange(3000)
    )
    times = np.bincount(np.concatenate([prepared.uniform(600, draw) for draw in range(400)]), minlength=3000)
    assert times.mean() == 80 and times.std() == pytest.approx(np.sqrt(400 * 0.2 * 0.8), rel=0.05)
    # the first and the second half of a draw are as independent of the order of the dots as of each other
    assert abs(np.corrcoef(prepared.uniform_order(0), np.arange(3000))[0, 1]) < 5 / np.sqrt(3000)


def test_seed_name_and_every_key_make_another_stream():
    first = stream(1, "a/c1", "tests").random(4)
    assert np.array_equal(first, stream(1, "a/c1", "tests").random(4))
    for other in (stream(2, "a/c1", "tests"), stream(1, "a/c2", "tests"), stream(1, "a/c1", "tests", 0)):
        assert not np.isclose(first, other.random(4)).any()
    assert np.array_equal(first, Streams(1, "a/c1")("tests").random(4))
    one, two = (Streams(1, name, shared=True) for name in ("a/c1", "a/c2"))  # whose names are for messages
    assert one.name != two.name and np.array_equal(one("tests").random(4), two("tests").random(4))


def test_weights_belong_to_their_subset_also_beyond_64_subsets(prepared):
    rng = np.random.default_rng(1)
    subsets = [rng.choice(3000, 900, replace=False) for _ in range(66)]
    weights = rng.uniform(0.2, 5, (66, 3000))
    tests = np.array([5, 700, 2100])
    z_tot, _ = prepared.describe(tests)
    together, _ = prepared.distances(subsets, tests, z_tot, "full", weights)
    for k in (0, 1, 63, 64, 65):
        alone, _ = prepared.distances(subsets[k : k + 1], tests, z_tot, "full", weights[k : k + 1])
        assert np.allclose(together[k], alone[0], rtol=0, atol=1e-9), k


@pytest.mark.parametrize(
    ("requested", "n_dots", "number"),
    [("published", 20045, 100), ("published", 300, 2), (50, 1000, 50), (50, 20, 20), (1, 100, 2)],
)
def test_number_of_test_dots(requested, n_dots, number):
    assert number_of_tests(requested, n_dots) == number


def test_a_sampler_is_compared_by_draws_that_differ_dots_ascending(prepared):
    def draw(n, rng):
        return rng.permutation(3000)[:n]

    subsets, seconds = comparison._draw(prepared, "any", draw, (0.99, 2.0), 3)  # 29.7 dots are 30
    assert [len(subset) for subset in subsets] == [30] * 3 + [60] * 3
    assert seconds.shape == (2, 3)
    assert len(comparison._draw(prepared, "any", draw, (0.01,), 1)[0][0]) == 1  # 0.3 dots are one
    for a in range(6):
        assert (np.diff(subsets[a]) > 0).all()
        assert not any(set(subsets[a]) <= set(subsets[b]) for b in range(6) if b != a)


@pytest.fixture(scope="module")
def drawn(prepared):
    """Subsets of 3 x 2 x 2 x 2 combinations in one draw, and the combinations."""
    combinations = published.parameter_grid([0.2, 0.5, 1.0], [0.0, 0.7], [0, 5], [0, 3])
    return combinations, prepared.sampled_together(combinations, 3)


def test_in_a_draw_combinations_share_the_numbers_of_their_pairs(prepared, drawn):
    """A pair is kept where its number lies above -ln p, a dot where any of its pairs or its being a centre keeps it."""
    combinations, subsets = drawn
    cover = prepared.cover
    random = prepared.stream("pairs", 3).standard_exponential(len(cover.dot))
    rough = np.repeat(cover.roughness, np.diff(cover.start))
    for k, (alpha, beta, gamma, delta) in enumerate(combinations):
        power = gamma * (1 + rough) + delta
        with np.errstate(invalid="ignore"):
            decay = np.where(power > 0, np.exp(-power * cover.log_ratio), 1.0)
        kept = np.exp(-random) < alpha * (1 - rough) ** beta * decay
        own = np.union1d(cover.dot[kept], cover.centre)
        assert np.array_equal(subsets.subset(k), own) and subsets.sizes()[k] == len(own)
        assert np.array_equal(prepared.pair(combinations[k], 3)[0], own)  # whatever else is in the grid


def test_subsets_of_a_draw_are_nested_in_alpha_and_differ_between_draws(prepared, drawn):
    combinations, subsets = drawn
    for k in range(8):
        small, middle, large = (set(subsets.subset(k + 8 * a)) for a in range(3))
        assert small < middle < large
    other = prepared.sampled_together(combinations, 4)
    chosen = range(16)  # with alpha = 1 and no power, all dots are kept
    assert all(not np.array_equal(other.subset(k), subsets.subset(k)) for k in chosen)


def test_the_mean_number_of_dots_is_that_of_the_closed_form(prepared, drawn):
    combinations, _ = drawn
    sizes = np.array([prepared.sampled_together(combinations, draw).sizes() for draw in range(200)])
    expected = published.expected_n_s(prepared.cover, combinations)
    error = np.maximum(sizes.std(axis=0, ddof=1), 0.1) / np.sqrt(200)
    assert (np.abs(sizes.mean(axis=0) - expected) < 4.5 * error).all()


@pytest.mark.parametrize("n", [1, 63, 64, 65, 130])
def test_equal_patches_are_described_once_with_the_distances_of_each(prepared, n):
    combinations = published.parameter_grid(np.linspace(0.1, 1, 13), [0.0, 0.7], [0, 5], [0, 1, 2, 3])[:n]
    subsets, tests = prepared.sampled_together(combinations, 0), prepared.draw_tests(11)
    z_tot, expected, sizes = prepared.compare([subsets.subset(k) for k in range(n)], tests, ("kept", "full"))
    words = subsets.words(prepared.index.dot, range(n))
    found = prepared.compare_words(words, n, tests, ("kept", "full"), z_tot)
    np.testing.assert_allclose(found[0], expected, rtol=0, atol=1e-13)
    assert np.array_equal(found[1], sizes)
    threaded = prepared.with_threads(2).compare_words(words, n, tests, ("kept", "full"), z_tot)
    assert np.array_equal(threaded[0], found[0])


def test_all_dots_may_be_handed_out_but_not_more(prepared):
    assert sorted(find_subset(prepared, "uniform", 3000).tolist()) == list(range(3000))
    with pytest.raises(InputError, match="blob has 3000 dots; give 1 to 3000"):
        find_subset(prepared, "uniform", 3001)


def test_fragments_are_medians_over_draws_and_test_dots(prepared):
    found = grid.evaluate_grid(prepared, [COMBINATION], 15, draws=3, readings=("kept",))
    z_tot, _ = prepared.describe(found.tests)
    for half in (0, 1):
        subsets = [prepared.pair(COMBINATION, draw)[half] for draw in range(3)]
        _, sizes = prepared.distances(subsets, found.tests, z_tot, "kept")
        assert found.median_patch_size[0, half, 0] == np.median(sizes) != np.mean(sizes)


def test_many_draws_are_compared_in_passes_of_a_word(prepared, monkeypatch):
    """As published, with test dots of each combination: five draws, of which two fit into a pass."""
    combinations = [COMBINATION, (0.3, 0.0, 2.0, 0.0)]
    whole = grid.evaluate_grid(prepared, combinations, 9, 5, shared=False)
    monkeypatch.setattr(grid.descriptors, "MAX_SUBSETS", 4)
    parts = grid.evaluate_grid(prepared, combinations, 9, 5, shared=False)
    assert np.allclose(parts.z_ts, whole.z_ts) and np.allclose(parts.z_tr, whole.z_tr)
    assert np.array_equal(parts.n_s, whole.n_s)
    for k, combination in enumerate(combinations):
        tests, keys = whole.tests[k], [round(1e6 * p) for p in combination]
        pairs = [(prepared.sampled(combination, draw), draw) for draw in range(5)]
        random = [
            published.uniform_subset(3000, len(dots), prepared.stream("uniform", *keys, draw))
            for dots, draw in pairs
        ]
        for half, subsets in enumerate(([dots for dots, _ in pairs], random)):
            z, sizes = prepared.distances(subsets, tests, prepared.describe(tests)[0], "kept")
            assert np.allclose((whole.z_ts, whole.z_tr)[half][0, k], z, rtol=1e-6)
            for found in (whole, parts):
                assert found.median_patch_size[0, half, k] == np.median(sizes)


@pytest.mark.parametrize(("shared", "told"), [(True, range(24, 145, 24)), (False, range(6, 145, 6))])
def test_a_grid_says_how_many_subsets_are_done(prepared, shared, told):
    combinations, done = [(alpha, 0, 0, 0) for alpha in np.linspace(0.1, 1, 24)], []
    grid.evaluate_grid(prepared, combinations, 2, 3, ("kept",), shared, lambda *counts: done.append(counts))
    assert done == [(count, 144) for count in told]


def test_all_readings_of_many_subsets_are_those_of_each_alone(prepared):
    rng = np.random.default_rng(0)
    subsets = [np.sort(rng.choice(3000, n, replace=False)) for n in rng.integers(300, 3000, 70)]
    tests = prepared.draw_tests(4)
    readings = ["full", "kept_scaled", "kept"]
    z_tot, found, _ = prepared.compare(subsets, tests, readings)
    assert np.allclose(z_tot, prepared.describe(tests)[0], atol=1e-12)
    for reading, z in zip(readings, found, strict=True):
        for i in (0, 63, 64, 69):  # more than one pass
            alone = prepared.distances(subsets[i : i + 1], tests, z_tot, reading)[0][0]
            assert np.allclose(z[i], alone, atol=1e-9), (reading, i)
    assert np.abs(found[2] - found[0]).max() > 0.1


def test_d_under_the_scaled_link_stands_beside_its_winner(prepared):
    rows = np.array([(0.7, 0, 2, 0), 4 * (np.nan,), (0.2, 0.3, 0, 0), (0.7, 0, 2, 0)])
    ranges = pd.DataFrame(rows, columns=PARAMETERS).assign(n_combinations=[3, 0, 2, 1])
    table = grid.add_scaled_link(ranges, prepared, 8, 2)
    found = table["d_kept_scaled"]
    tests = prepared.draw_tests(8)
    z_tot, _ = prepared.describe(tests)
    for k in (0, 2, 3):
        pairs = [prepared.pair(rows[k], draw) for draw in range(2)]
        z = [prepared.distances(pair, tests, z_tot, "kept_scaled", approximate=True)[0] for pair in pairs]
        d = estimate([random - sampled for sampled, random in z])
        assert table.loc[
            k, [f"d{end}_kept_scaled" for end in ("", "_low", "_high")]
        ].tolist() == pytest.approx([d.mean, d.low, d.high], rel=1e-5)
    assert np.isnan(found[1]) and found[0] != found[2]


def test_blocks_of_random_numbers_change_no_draw(prepared, monkeypatch):
    combination = (0.7, 0.2, 2.0, 2.0)
    whole = published.sample_cover(prepared.cover, combination, np.random.default_rng(5))
    for block in (1, 100, 3333):
        monkeypatch.setattr(published, "PAIRS_PER_BLOCK", block)
        assert np.array_equal(
            published.sample_cover(prepared.cover, combination, np.random.default_rng(5)), whole
        )


def test_expected_numbers_do_not_depend_on_company_or_order(prepared):
    rows = published.parameter_grid([0.2, 1.0], [0.0, 0.7], [0, 3], [0, 5])
    together = published.expected_n_s(prepared.cover, rows)
    assert np.array_equal(published.expected_n_s(prepared.cover, rows[::-1])[::-1], together)
    assert [published.expected_n_s(prepared.cover, [row])[0] for row in rows] == together.tolist()
