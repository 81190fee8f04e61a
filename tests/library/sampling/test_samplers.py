"""Samplers: exact sizes, nestedness, plain references, and the ranking at equal n_S."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from conftest import make_blob
from sparsurf import registry
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.index import build_grid, build_index, select_separated
from sparsurf.sampling import published
from sparsurf.sampling.farthest_point import farthest_points
from sparsurf.sampling.samplers import (
    farthest,
    get_sampler,
    nearest_chosen,
    nearest_kept,
    paper,
    poisson,
    sampler_label,
    tune_alpha,
)
from sparsurf.settings import Settings
from sparsurf.streams import Streams

ON_DOTS = [name for name, choice in registry.TABLE["sampler"].items() if choice.applies != registry.ORIGIN]
EXACT = [name for name in ON_DOTS if not name.startswith("paper")]
NESTED = [name for name in ON_DOTS if registry.TABLE["sampler"][name].nested]


@pytest.fixture(scope="module")
def surface(blob):
    points, normals = blob
    return PreparedSurface(
        SimpleNamespace(points=points, normals=normals),
        Settings(patches={"d_link": 0.8}),
        streams=Streams(3, "blob"),
    )


@settings(max_examples=40)
@given(st.sampled_from(EXACT), st.integers(1, 3000), st.integers(0, 2**32))
def test_exactly_n_different_dots(surface, name, n, seed):
    dots = get_sampler(name)(surface, n, np.random.default_rng(seed))
    assert len(dots) == n == len(np.unique(dots))
    assert dots.min() >= 0 and dots.max() < 3000


@pytest.mark.parametrize("name", ON_DOTS)
def test_the_same_stream_gives_the_same_dots(surface, name):
    one, two = (get_sampler(name)(surface, 300, np.random.default_rng(8)) for _ in range(2))
    assert np.array_equal(one, two)


@settings(max_examples=30)
@given(st.sampled_from(NESTED), st.integers(1, 3000), st.integers(1, 3000), st.integers(0, 2**32))
def test_shorter_subsets_begin_the_longer_ones(surface, name, n, m, seed):
    one, two = (get_sampler(name)(surface, k, np.random.default_rng(seed)) for k in (n, m))
    assert np.array_equal(one[: min(n, m)], two[: min(n, m)])


def test_what_a_sampler_is_called():
    labels = {
        "paper": "paper's sampling", "paper_corrected": "paper's, corrected", "uniform": "random subset",
        "poisson": "Poisson disk", "farthest": "farthest point",
    }  # fmt: skip
    assert {name: sampler_label(name) for name in labels} == labels
    assert {"uniform", "farthest"} <= {*NESTED} and not {"paper", "paper_corrected", "poisson"} & {*NESTED}
    assert [*registry.samplers_of_combinations()] == ["paper", "paper_corrected"]


def test_poisson_equals_the_plain_method(surface):
    order = np.random.default_rng(2).permutation(3000)
    kept = []
    for i in order:
        if not kept or np.linalg.norm(surface.points[kept] - surface.points[i], axis=1).min() > 1.1:
            kept.append(int(i))
    assert select_separated(surface.index, order, 1.1, len(order), 0).tolist() == kept


@pytest.mark.parametrize("n", [100, 500])
def test_few_dots_are_left_out_by_chance(surface, n):
    """The radius is nearly the largest that gives n dots: discs of Poisson fill 0.7 of the area, less the ones left out."""
    dots = poisson(surface, n, np.random.default_rng(7))
    gaps = cdist(surface.points[dots], surface.points[dots]) + 99 * np.eye(n)
    assert gaps.min() > 0.8 * np.sqrt(0.7 * 4 / np.pi * 4 * np.pi * 8.0**2 / n)


def plainly_spread(points, first, n):
    """Every dot the one with the largest squared distance to those before it."""
    gap, p, chosen = np.full(len(points), np.inf), first, []
    for _ in range(n):
        chosen.append(p)
        gap = np.minimum(gap, ((points - points[p]) ** 2).sum(axis=1))
        gap[p] = -1  # never again, not even before a dot that coincides with another one
        p = int(np.argmax(gap))
    return chosen


def test_farthest_equals_the_plain_algorithm_and_is_nested(surface):
    dots = farthest(surface, 700, np.random.default_rng(1))
    assert dots.tolist() == plainly_spread(surface.points, dots[0], 700)
    long, short = (farthest(surface, n, np.random.default_rng(2)) for n in (3000, 200))
    assert np.array_equal(long[:200], short)
    reach = [
        np.linalg.norm(surface.points[long[:k]] - surface.points[long[k]], axis=1).min() for k in (5, 50, 500)
    ]
    assert reach[0] > reach[1] > reach[2]


CLOUDS = {
    "lattice": np.stack(np.meshgrid(*[np.arange(7.0)] * 3, indexing="ij"), axis=-1).reshape(
        -1, 3
    ),  # ties everywhere
    "square": np.array([[x, y, 0.0] for x in range(3) for y in range(3)]),
    "places of four dots": np.repeat(np.random.default_rng(0).normal(size=(10, 3)), 4, axis=0),
    "far apart": np.concatenate(
        [np.random.default_rng(2).normal(size=(200, 3)), [[1e4, 0, 0], [0, -3e4, 0]]]
    ),
    "shell": 12 * make_blob(1500)[0],
    "one dot": np.zeros((1, 3)),
}


@pytest.mark.parametrize("name", CLOUDS)
def test_farthest_points_and_the_nearest_of_them_equal_the_plain_algorithm(name):
    """On a tie the dot of the lowest number is chosen, and the one chosen first is the nearest; each dot is chosen once."""
    points = np.random.default_rng(4).permutation(CLOUDS[name])
    grid = build_grid(points)
    for n in sorted({1, min(9, len(points)), len(points)}):
        start = np.random.default_rng(5)
        dots, nearest = farthest_points(grid, n, np.random.default_rng(5))
        assert dots.tolist() == plainly_spread(points, int(start.integers(len(points))), n)
        assert nearest[dots].tolist() == [*range(n)]
        d2 = ((points[:, None] - points[dots]) ** 2).sum(axis=2)
        others = np.setdiff1d(np.arange(len(points)), dots)
        assert np.array_equal(nearest[others], d2.argmin(axis=1)[others])


def test_alpha_is_tuned_so_that_the_papers_sampler_keeps_about_n(surface):
    combination = tune_alpha(surface.cover, (1.0, 0.2, 2.0, 4.0), 400)
    assert published.expected_n_s(surface.cover, [combination])[0] == pytest.approx(400, abs=0.01)
    assert tune_alpha(surface.cover, (1.0, 0.2, 2.0, 4.0), 10**6)[0] == pytest.approx(1.0)
    assert 0 < tune_alpha(surface.cover, (1.0, 0.2, 2.0, 4.0), 1)[0] < 1e-6  # fewer than its centres
    n = [len(paper(surface, 500, np.random.default_rng(k))) for k in range(20)]
    assert np.mean(n) == pytest.approx(500, abs=4 * np.sqrt(500 / 20))


def test_every_dot_counts_with_the_nearest_kept_one(surface):
    kept = farthest(surface, 100, np.random.default_rng(6))
    nearest = nearest_chosen(surface.points, kept)
    d = np.linalg.norm(surface.points[:, None] - surface.points[kept][None], axis=2)
    assert np.array_equal(nearest, d.argmin(axis=1))
    assert np.allclose(nearest_kept(surface.points, kept)[1], d.min(axis=1))


def test_ranking_on_a1(a1):
    # measured with 1000 test dots and three draws, s.e. 0.01; bounds as the reference figures +- 0.03
    surface = PreparedSurface(a1, streams=Streams(1, "a1"))
    tests = surface.draw_tests(1000)
    z_tot, _ = surface.describe(tests)
    n = len(a1) // 10
    reference = {"farthest": 0.975, "uniform": 1.20, "paper": 1.57}
    for name, expected in reference.items():
        subsets = [get_sampler(name)(surface, n, np.random.default_rng(k)) for k in range(3)]
        z, _ = surface.distances(subsets, tests, z_tot, "full")
        assert z.mean() == pytest.approx(expected, abs=0.03), name


def test_index_of_a_tiny_surface_can_be_sampled_whole():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    tiny = SimpleNamespace(points=points, index=build_index(points, points))
    for name in EXACT:
        assert sorted(get_sampler(name)(tiny, 3, np.random.default_rng(0)).tolist()) == [0, 1, 2], name
