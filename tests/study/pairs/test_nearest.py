"""Nearest descriptors: exact cases, a rigid motion, all distances at once, threads, memory and time."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from sparsurf.errors import InputError
from sparsurf_study.pairs.nearest import BLOCK_ROWS, COLUMNS, nearest


@pytest.fixture(scope="module")
def vectors():
    rng = np.random.default_rng(8)
    return rng.normal(size=(2 * BLOCK_ROWS + 37, 121)), rng.normal(size=(COLUMNS + 11, 121))


def test_points_on_a_line():
    of_a, of_b = nearest(np.array([[0.0], [10.0]]), np.array([[1.0], [4.0], [9.5]]), k=2)
    assert of_a.distance.tolist() == [[1.0, 4.0], [0.5, 6.0]]
    assert of_a.partner.tolist() == [[0, 1], [2, 1]]
    assert of_b.distance.tolist() == [[1.0, 9.0], [4.0, 6.0], [0.5, 9.5]]
    assert of_b.mean().tolist() == [5.0, 5.0, 5.0]
    with pytest.raises(InputError, match="3 nearest patches needs at least 3"):
        nearest(np.zeros((5, 2)), np.zeros((2, 2)), k=3)


@pytest.mark.parametrize("k", [1, 4])
def test_equals_all_distances_sorted(vectors, k):
    a, b = vectors
    all_distances = cdist(a, b)
    of_a, of_b = nearest(a, b, k)
    assert np.array_equal(of_a.partner, np.argsort(all_distances, axis=1)[:, :k])
    assert np.array_equal(of_b.partner, np.argsort(all_distances, axis=0)[:k].T)
    assert np.allclose(of_a.distance, np.sort(all_distances, axis=1)[:, :k], rtol=1e-13)
    assert np.allclose(of_b.distance, np.sort(all_distances, axis=0)[:k].T, rtol=1e-13)


def test_a_copy_is_at_distance_zero_and_ties_go_to_the_lower_place(vectors):
    a, _ = vectors
    twice = np.concatenate([a, a, a])
    of_a, of_twice = nearest(a, twice, k=3)
    n = len(a)
    assert np.array_equal(of_a.partner, np.arange(n)[:, None] + [0, n, 2 * n])
    assert (of_a.distance == 0).all()
    assert (of_twice.distance[:, 0] == 0).all()


def test_rounding_errors_do_not_choose_among_copies(vectors):
    """Copies a few rounding errors away tie; the product leaves noise of 1e-14 on the squares."""
    a = vectors[0][:300]
    noise = 1e-12 * np.random.default_rng(3).normal(size=(3, *a.shape))
    found = nearest(a, np.concatenate([a + each for each in noise]), k=2)[0]
    assert np.array_equal(found.partner[:, 0] % 300, np.arange(300))
    assert np.array_equal(np.sort(found.partner, axis=1), np.arange(300)[:, None] + [0, 300])


def test_threads_and_the_order_of_the_sides_change_nothing(vectors):
    for one, many in zip(nearest(*vectors, k=3), nearest(*vectors, k=3, threads=3), strict=True):
        assert np.array_equal(one.distance, many.distance)
        assert np.array_equal(one.partner, many.partner)
    forth, back = nearest(*vectors, k=2), nearest(*vectors[::-1], k=2)
    for one, other in zip(forth, back[::-1], strict=True):
        assert np.array_equal(one.partner, other.partner)
        assert np.array_equal(one.distance, other.distance)
