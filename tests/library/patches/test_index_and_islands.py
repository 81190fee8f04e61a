"""Patches and islands against a brute-force reference, and the invariances they must have."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist

import naive
from sparsurf.patches.index import ball, ball_bound, build_index
from sparsurf.patches.islands import drop_small_islands, patch


@pytest.mark.parametrize("radius, d_link", [(4.0, 0.9), (6.0, 0.75), (2.0, 0.4)])
def test_patch_equals_brute_force(blob, radius, d_link):
    points, normals = blob
    index = build_index(points, normals, d_link)
    for i in range(0, len(points), 37):
        assert np.array_equal(patch(index, i, radius), naive.patch(points, i, radius, d_link))


def test_ball_equals_brute_force_outside_the_box_too(blob):
    points, normals = blob
    index = build_index(points, normals)
    for centre in ([0.0, 0, 0], [8, 0, 0], [40, 0, 0], [-14, -14, -14], points[7]):
        centre = np.asarray(centre, float)
        found = np.empty(ball_bound(index, centre[None], 6.0) + 1, np.int32)
        n = ball(index, tuple(centre), 6.0, found)
        expected = np.flatnonzero(np.linalg.norm(points - centre, axis=1) <= 6.0)
        assert np.array_equal(np.sort(index.dot[found[:n]]), expected)


def test_a_dot_at_the_very_radius_belongs_to_the_ball():
    points, found = np.array([[0.0, 0, 0], [3, 4, 0], [1, 1, 0]]), np.empty(4, np.int32)
    index = build_index(points, np.tile([0.0, 0, 1], (3, 1)))
    assert [ball(index, (0.0, 0.0, 0.0), radius, found) for radius in (5.0, 4.999)] == [3, 2]
    # in the middle of a cell, whose sides are farther off than the radius
    assert ball(index, (1.0, 1.0, 0.0), 0.5, found) == 1


def test_links_are_the_pairs_closer_than_d_link(blob):
    points, normals = blob
    index = build_index(points, normals, 0.8)
    near = cdist(points, points) < 0.8
    np.fill_diagonal(near, False)
    for p in range(0, len(points), 11):
        row = index.link[index.link_start[p] : index.link_start[p + 1]]
        assert np.array_equal(np.sort(index.dot[row[row < len(points)]]), np.flatnonzero(near[index.dot[p]]))
    # two dots exactly d_link apart are not linked (0.5 is exact in binary)
    points, normals = np.array([[0.0, 0, 0], [0.5, 0, 0]]), np.tile([0.0, 0, 1], (2, 1))
    assert len(patch(build_index(points, normals, 0.5), 1, 4.0)) == 1
    assert len(patch(build_index(points, normals, 0.5 + 1e-12), 1, 4.0)) == 2


def test_ties_between_islands():
    points = np.array([[0.0, 0, 0], [3.0, 0, 0], [3.1, 0, 0], [0.1, 0, 0]])
    index = build_index(points, np.tile([0.0, 0, 1], (4, 1)), 0.5)
    for i in range(4):
        assert patch(index, i, 4.0).tolist() == [0, 3]
    # the walk meets dot 0, dot 5, then dots 3 and 4, then dots 1 and 2: two ties
    points = np.array([[0.0, 0, 0], [9, 0, 0], [9.1, 0, 0], [6, 0, 0], [6.1, 0, 0], [3, 0, 0]])
    index = build_index(points, np.tile([0.0, 0, 1], (6, 1)), 0.5)
    assert patch(index, 0, 20.0).tolist() == [1, 2]


@settings(max_examples=40)
@given(st.integers(1, 60), st.integers(0, 10**6), st.floats(0.05, 3.0), st.floats(0.1, 8.0))
def test_random_dots_equal_brute_force(n, seed, d_link, radius):
    points = np.random.default_rng(seed).normal(scale=1.5, size=(n, 3))
    index = build_index(points, np.tile([0.0, 0, 1], (n, 1)), d_link)
    for i in range(n):
        assert np.array_equal(patch(index, i, radius), naive.patch(points, i, radius, d_link))


@settings(max_examples=60)
@given(st.integers(1, 40), st.integers(0, 10**6), st.floats(0.05, 1.5), st.integers(1, 64))
def test_small_islands_are_left_out_and_never_the_largest(n, seed, d_link, n_subsets):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, 3))
    index = build_index(points, np.tile([0.0, 0, 1], (n, 1)), d_link)
    ids = np.flatnonzero(rng.random(n) < 0.8).astype(np.int32)  # positions; links to others do not count
    kept = rng.random((len(ids), n_subsets)) < rng.random(n_subsets)
    word = np.array([sum(1 << b for b in np.flatnonzero(row)) for row in kept.tolist()], np.uint64)
    around = np.zeros(n + 1, np.uint64)
    drop_small_islands(ids, word, index.link_start, index.link, around)
    assert not around.any()
    near = np.linalg.norm(index.xyz[ids][:, None] - index.xyz[ids], axis=2) < d_link
    for b in range(n_subsets):
        chosen = np.flatnonzero(kept[:, b])
        label = connected_components(near[chosen][:, chosen])[1]
        size = np.bincount(label, minlength=1)[label] if len(chosen) else label
        left = chosen[size >= min(3, size.max(initial=0))]
        assert np.array_equal(np.flatnonzero(word >> np.uint64(b) & np.uint64(1)), left)


def test_patches_do_not_depend_on_the_order_of_the_dots(blob):
    points, normals = blob
    order = np.random.default_rng(3).permutation(len(points))
    plain, shuffled = build_index(points, normals, 0.8), build_index(points[order], normals[order], 0.8)
    for i in range(0, len(points), 301):
        assert np.array_equal(np.sort(order[patch(shuffled, i, 5.0)]), patch(plain, order[i], 5.0))


@pytest.mark.parametrize("far", [[1e6, 1e6, 1e6], [1e12, 1e12, 0]], ids=["apart", "in a plane"])
def test_two_far_dots_do_not_fill_the_memory_with_cells(far):
    index = build_index(np.array([[0.0, 0, 0], far]), np.tile([0.0, 0, 1], (2, 1)))
    assert len(index.start) < 2e6
    assert patch(index, 1, 6.0).tolist() == [1]
