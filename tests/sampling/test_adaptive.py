"""Dots where the recovered surface errs: what the error is, and that the dots lower it."""

import numpy as np
import pytest

from sparsurf.sampling.adaptive import _dots_of_largest_error, adaptive, recovery_errors
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.molecular_surface import molecular_surface


@pytest.fixture(scope="module")
def prepared():
    xyz = np.array(
        [[0, 0, 0], [1.5, 0, 0], [2.2, 1.3, 0.2], [3.7, 1.4, 0.3], [4.3, 2.7, 0.9], [9, 1, 1], [11, 1, 1]]
    )
    return PreparedSurface(molecular_surface(xyz, np.full(len(xyz), 1.7)), seed=2)


def test_the_error_is_distance_and_angle():
    k = np.arange(300) + 0.5  # a sphere, which comes back from any of its dots
    z, turn = 1 - 2 * k / 300, np.pi * (1 + 5**0.5) * k
    unit = np.stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z], axis=1)
    points, normals, kept = 3 * unit, unit.copy(), np.arange(0, 300, 4)
    assert recovery_errors(points, normals, kept).max() < 1e-4
    points[1] *= 1.05  # 0.15 Å off, seen along its normal
    axis = np.cross(unit[2], [0, 0, 1.0])
    axis /= np.linalg.norm(axis)
    normals[2] = np.cos(0.3) * unit[2] + np.sin(0.3) * np.cross(axis, unit[2])
    points[3] *= 0.02  # in the middle, where the gradient says nothing and counts as 0.2
    found = recovery_errors(points, normals, kept)
    assert found[1] == pytest.approx(0.15 / 0.1, rel=0.03)  # 0.1 Å and 1 rad count alike
    assert found[2] == pytest.approx(0.3, rel=0.01)
    assert found[3] == pytest.approx(1.5 / 0.2 / 0.1, rel=0.1)
    assert (found[kept] == 0).all() and (np.delete(found, [1, 2, 3]) < 1e-4).all()


def test_adaptive_dots_lower_the_error(prepared):
    n = len(prepared.points) // 12
    by_error, even = (
        SAMPLERS[name](prepared, n, np.random.default_rng(0)) for name in ("adaptive", "farthest")
    )
    assert len(set(by_error)) == n
    mean = [recovery_errors(prepared.points, prepared.normals, kept).mean() for kept in (by_error, even)]
    assert mean[0] < 0.95 * mean[1]


def test_fifty_even_dots_come_first_and_each_round_adds_a_fifth(prepared):
    found = SAMPLERS["adaptive"](prepared, 72, np.random.default_rng(0))
    assert np.array_equal(found[:50], SAMPLERS["farthest"](prepared, 50, np.random.default_rng(0)))
    assert np.array_equal(found[50:60], _dots_of_largest_error(prepared, found[:50], 10))
    assert np.array_equal(found[60:], _dots_of_largest_error(prepared, found[:60], 12))


@pytest.mark.parametrize("share", [0.02, 0.5, 0.9])
def test_new_dots_are_those_that_err_most_and_keep_clear_of_each_other_while_there_are_enough(
    prepared, share
):
    points, kept = prepared.points, SAMPLERS["farthest"](prepared, 50, np.random.default_rng(0))
    error = recovery_errors(points, prepared.normals, kept)
    order = [i for i in np.argsort(-error, kind="stable").tolist() if i not in set(kept.tolist())]
    length, clear = 0.7 * np.sqrt(prepared.area / 50), []
    for i in order:
        if not clear or np.linalg.norm(points[clear] - points[i], axis=1).min() > length:
            clear.append(i)
    wanted = round(share * len(points))
    expected = clear + [i for i in order if i not in clear]
    assert (wanted < len(clear)) == (share < 0.1)
    assert _dots_of_largest_error(prepared, kept, wanted).tolist() == expected[:wanted]


def test_a_dot_is_recovered_from_those_of_its_own_side():
    upper = np.array([[x, y, 0.0] for x in range(0, 9, 2) for y in range(0, 9, 2)])
    lower = upper[:, :2] + 1  # below the gaps
    points = np.concatenate([upper, np.column_stack([lower, np.full(25, -0.9)]), [[3.0, 3.0, 0]]])
    normals = np.repeat([[0, 0, 1.0], [0, 0, -1.0], [0, 0, 1.0]], [25, 25, 1], axis=0)
    assert recovery_errors(points, normals, np.arange(50))[50] == pytest.approx(0, abs=1e-4)


def test_all_dots_can_be_kept(prepared):
    n = len(prepared.points)
    assert sorted(adaptive(prepared, n, np.random.default_rng(0))) == list(range(n))
