"""Samplers: exact sizes, nestedness, plain references, and the ranking at equal n_S."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sparsurf import sampling
from sparsurf.evaluation import Evaluator
from sparsurf.patches import build_index
from sparsurf.samplers import SAMPLERS, farthest, nearest_kept, paper, tune_alpha, weights

EXACT = [name for name in SAMPLERS if not name.startswith("paper")]


@pytest.fixture(scope="module")
def surface(blob):
    points, normals = blob
    return Evaluator(SimpleNamespace(points=points, normals=normals), d_link=0.8, seed=3, name="blob")


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(EXACT), st.integers(1, 3000), st.integers(0, 2**32))
def test_exactly_n_different_dots(surface, name, n, seed):
    dots = SAMPLERS[name](surface, n, np.random.default_rng(seed))
    assert len(dots) == n == len(np.unique(dots))
    assert dots.min() >= 0 and dots.max() < 3000


@pytest.mark.parametrize("name", list(SAMPLERS))
def test_the_same_stream_gives_the_same_dots(surface, name):
    one, two = (SAMPLERS[name](surface, 300, np.random.default_rng(8)) for _ in range(2))
    assert np.array_equal(one, two)


def test_farthest_equals_the_plain_algorithm(surface):
    dots = farthest(surface, 700, np.random.default_rng(1))
    gap = np.full(len(surface.points), np.inf)
    p, expected = dots[0], []
    for _ in range(700):
        expected.append(p)
        gap = np.minimum(gap, ((surface.points - surface.points[p]) ** 2).sum(axis=1))
        p = int(np.argmax(gap))
    assert dots.tolist() == expected


def test_farthest_is_nested_and_its_gaps_shrink(surface):
    long, short = (farthest(surface, n, np.random.default_rng(2)) for n in (3000, 200))
    assert np.array_equal(long[:200], short)
    reach = [
        np.linalg.norm(surface.points[long[:k]] - surface.points[long[k]], axis=1).min() for k in (5, 50, 500)
    ]
    assert reach[0] > reach[1] > reach[2]


def test_poisson_dots_keep_their_distance(surface):
    # the radius is not returned, but n dots that could all be thrown at it are at least that far apart; random
    # subsets of this size come closer than half of it for certain
    dots = SAMPLERS["poisson"](surface, 300, np.random.default_rng(4))
    random = SAMPLERS["uniform"](surface, 300, np.random.default_rng(4))

    def closest(ids):
        d = np.linalg.norm(surface.points[ids][:, None] - surface.points[ids][None], axis=2)
        return d[np.triu_indices(len(ids), 1)].min()

    assert closest(dots) > 3 * closest(random)


def test_roughness_weighting_prefers_rough_dots(surface):
    kept = SAMPLERS["roughness"](surface, 600, np.random.default_rng(5))
    assert surface.roughness[kept].mean() < surface.roughness.mean() - 0.01


def test_alpha_is_tuned_to_the_wished_number(surface):
    combination = tune_alpha(surface.cover, (1.0, 0.2, 2.0, 4.0), 400)
    assert sampling.expected_n_s(surface.cover, [combination])[0] == pytest.approx(400, abs=0.01)
    assert tune_alpha(surface.cover, (1.0, 0.2, 2.0, 4.0), 10**6)[0] == pytest.approx(1.0)


def test_paper_keeps_about_n(surface):
    n = [len(paper(surface, 500, np.random.default_rng(k))) for k in range(20)]
    assert np.mean(n) == pytest.approx(500, abs=4 * np.sqrt(500 / 20))


def test_weights_count_every_dot_once(surface):
    kept = farthest(surface, 100, np.random.default_rng(6))
    w = weights(surface.points, kept)
    d = np.linalg.norm(surface.points[:, None] - surface.points[kept][None], axis=2)
    assert w.sum() == len(surface.points)
    assert np.array_equal(w, np.bincount(d.argmin(axis=1), minlength=100))
    assert np.allclose(nearest_kept(surface.points, kept)[1], d.min(axis=1))


def test_ranking_on_a1(a1):
    # measured with 1000 test dots and three draws, s.e. 0.01; bounds as the reference figures +- 0.03
    surface = Evaluator(a1, seed=1, name="a1")
    tests = surface.draw_tests(1000)
    z_tot, _ = surface.describe(tests)
    n = len(a1) // 10
    reference = {"farthest": 0.975, "voxel": 0.986, "stride": 1.08, "uniform": 1.20}
    for name, expected in reference.items():
        subsets = [SAMPLERS[name](surface, n, np.random.default_rng(k)) for k in range(3)]
        z, _ = surface.distances(subsets, tests, z_tot, "surface")
        assert z.mean() == pytest.approx(expected, abs=0.03), name


def test_index_of_a_tiny_surface_can_be_sampled_whole():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    tiny = SimpleNamespace(points=points, index=build_index(points, points), roughness=np.full(3, 0.5))
    for name in EXACT:
        assert sorted(SAMPLERS[name](tiny, 3, np.random.default_rng(0)).tolist()) == [0, 1, 2], name
