"""What the samplers choose: which row of Table I, which alpha, what is left out at random."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import naive
from conftest import make_blob
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.index import build_index
from sparsurf.sampling import published
from sparsurf.sampling.combination import (
    PARAMETERS,
    PUBLISHED_CHOICES,
    PUBLISHED_ROWS,
    TABLE_1,
    Choices,
    Combination,
    combination_labels,
    join_combinations,
    split_combinations,
)
from sparsurf.sampling.samplers import _at_largest_length, paper, paper_corrected, tune_alpha
from sparsurf.settings import Settings
from sparsurf.streams import Streams


@pytest.fixture(scope="module")
def surface(blob):
    points, normals = blob
    return PreparedSurface(
        SimpleNamespace(points=points, normals=normals),
        Settings(patches={"d_link": 0.8}),
        streams=Streams(3, "blob"),
    )


def test_the_row_of_table_1_is_that_of_the_range_which_holds_n_s():
    lowest = TABLE_1["n_S_low_percent"]
    for k, low in enumerate(lowest):
        high = lowest[k + 1] if k + 1 < len(lowest) else 100.0
        for percent in (low, low + 0.01, (low + high) / 2, high - 0.01):
            rows = PUBLISHED_CHOICES.from_n_s(percent)
            assert np.array_equal(rows, PUBLISHED_ROWS[k:]), percent
    assert np.array_equal(PUBLISHED_CHOICES.from_n_s(0.1), PUBLISHED_ROWS)  # below all ranges: the first
    assert np.array_equal(PUBLISHED_CHOICES.from_n_s(100.0), PUBLISHED_ROWS[-1:])


SHORT, LONG, WIDE = (1.0, 1.0, 10.0, 10.0), (1.0, 0.5, 6.0, 2.0), (1.0, 0.0, 2.0, 0.0)
WHOLE = (1.0, 0.0, 0.0, 0.0)


def expected(cover, combination):
    return published.expected_n_s(cover, [combination])[0]


@pytest.mark.parametrize("function", [paper, paper_corrected])
def test_where_a_choice_cannot_keep_n_the_next_that_can_takes_its_place(surface, function):
    cover = surface.cover if function is paper else surface.corrected_cover
    reach = [expected(cover, each) for each in (SHORT, LONG, WIDE, WHOLE)]
    assert reach == sorted(reach)
    n = round((reach[1] + reach[2]) / 2)
    choices = Choices(np.array([0.0, 60.0, 80.0, 90.0]), np.array([SHORT, LONG, WIDE, WHOLE]))
    dots = function(surface, n, np.random.default_rng(5), choices)
    assert np.array_equal(
        dots, published.sample_cover(cover, tune_alpha(cover, WIDE, n), np.random.default_rng(5))
    )


@pytest.mark.parametrize(("n", "combination"), [(899, WIDE), (900, WHOLE)])
def test_the_range_is_that_of_the_share_of_all_dots(surface, n, combination):
    """Of 3000 dots 900 are 30 %."""
    choices = Choices(np.array([0.0, 30.0]), np.array([WIDE, WHOLE]))
    dots = paper(surface, n, np.random.default_rng(5), choices)
    alone = tune_alpha(surface.cover, combination, n)
    assert np.array_equal(dots, published.sample_cover(surface.cover, alone, np.random.default_rng(5)))


def test_where_no_choice_can_keep_n_the_nearest_is_taken_and_covers_differ(surface):
    choices = Choices(np.array([0.0, 90.0, 95.0]), np.array([SHORT, LONG, SHORT]))
    dots = paper(surface, 2000, np.random.default_rng(5), choices)
    assert np.array_equal(
        dots,
        published.sample_cover(
            surface.cover, tune_alpha(surface.cover, LONG, 2000), np.random.default_rng(5)
        ),
    )
    choices = Choices(np.array([0.0]), np.array([WIDE]))
    one, two = (f(surface, 900, np.random.default_rng(5), choices) for f in (paper, paper_corrected))
    assert not np.array_equal(one, two)


def test_every_dot_too_many_may_be_the_one_that_is_left_out():
    whole = SimpleNamespace(points=np.zeros((3000, 3)))
    times = np.zeros(103)
    for seed in range(400):
        times[_at_largest_length(lambda length: np.arange(103), whole, 100, np.random.default_rng(seed))] += 1
    assert times.sum() == 400 * 100
    # binomial, 400 of 100 / 103: 388.3 +- 3.4; five of these
    assert np.abs(times - 388.3).max() < 17


def test_the_length_is_sought_until_few_dots_are_too_many():
    whole = SimpleNamespace(points=np.zeros((3000, 3)))
    dots = _at_largest_length(
        lambda length: np.arange(int(3000 / length**1.8)), whole, 500, np.random.default_rng(0)
    )
    assert len(dots) == 500
    assert dots.max() <= 502  # half a percent too many


def test_distances_are_measured_from_the_starter_or_from_the_moved_centre():
    points, normals = make_blob(1000)
    index = build_index(points, normals, 0.75)  # so short that islands lack the dot that starts their patch
    plain, rough = naive.cover(points, 4.0, 0.75), np.linspace(0, 1, len(points))
    assert any(starter != centre for starter, centre, _ in plain)
    assert published.build_cover(index, rough).origin.tolist() == [centre for _, centre, _ in plain]
    own = published.build_cover(index, rough, distance_from_moved_centre=False)
    assert own.origin.tolist() == [starter for starter, _, _ in plain]
    assert own.roughness.tolist() == [rough[starter] for starter, _, _ in plain]
    corrected = PreparedSurface(
        SimpleNamespace(points=points, normals=normals), Settings(patches={"d_link": 0.75})
    ).corrected_cover
    assert np.array_equal(corrected.origin, own.origin)
    seen = set()
    for c, (starter, _, dots) in enumerate(plain):  # a dot has its chance in the first patch that contains it
        pairs = slice(corrected.start[c], corrected.start[c + 1])
        order = np.argsort(corrected.dot[pairs])
        first = [dot for dot in dots.tolist() if dot not in seen]
        assert corrected.dot[pairs][order].tolist() == first
        distance = np.linalg.norm(points[first] - points[starter], axis=1)
        assert np.allclose(4.0 * np.exp(-corrected.log_ratio[pairs][order]), distance, atol=1e-12)
        seen.update(first)


def test_of_two_dots_as_near_the_lower_one_is_the_centre():
    points = np.array(
        [[0.0, 0, 0], [2, 0.3, 0], [2, -0.3, 0]]
    )  # the island lacks the dot that starts the patch
    for order in ([0, 1, 2], [0, 2, 1]):
        cover = published.build_cover(build_index(points[order], points, 0.7), np.zeros(3))
        assert cover.centre[0] == 1


def test_every_dot_is_as_likely_in_a_uniform_subset():
    rng = np.random.default_rng(2)
    times = sum(np.bincount(published.uniform_subset(10, 3, rng), minlength=10) for _ in range(2000))
    assert np.abs(times - 600).max() < 5 * np.sqrt(2000 * 0.3 * 0.7)


def test_a_combination_as_text_and_as_keys():
    one = Combination(0.4, 0.2, 10.0, 0.0)
    assert str(one) == "(0.4, 0.2, 10, 0)"
    assert one.keys() == [400000, 200000, 10000000, 0]


def test_fields_of_tables():
    table = pd.DataFrame(PUBLISHED_ROWS[:2], columns=PARAMETERS).assign(d=1.0)
    assert combination_labels(table) == ["(0.4, 0.2, 10, 10)", "(1, 0.4, 10, 6)"]
    empty = pd.DataFrame(4 * [[np.nan]], PARAMETERS).T  # of a range without combinations
    assert combination_labels(pd.concat([empty, table])) == ["", *combination_labels(table)]
    assert split_combinations(join_combinations(combination_labels(table))) == combination_labels(table)
    assert split_combinations(np.nan) == split_combinations("") == []
