"""Dots at better places: the surface recovered from them comes nearer to the true one."""

import numpy as np
import pytest

from measures import recovery
from sparsurf.recovery.interpolants import fit_interpolants, interpolant_value
from sparsurf.recovery.recovering import MIN_GRADIENT, recover
from sparsurf.recovery.relaxation import relax
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.molecular_surface import molecular_surface

ATOMS = np.array(
    [[0, 0, 0], [1.5, 0, 0], [2.2, 1.3, 0.2], [3.7, 1.4, 0.3], [4.3, 2.7, 0.9], [5, 5, 1], [7, 5.5, 2.5]]
)
RADII = np.array([1.9, 1.5, 1.9, 1.4, 1.85, 1.9, 1.7])


@pytest.fixture(scope="module")
def dots():
    return molecular_surface(ATOMS, RADII)


@pytest.fixture(scope="module")
def kept(dots):
    chosen = SAMPLERS["farthest"](PreparedSurface(dots), len(dots) // 20, np.random.default_rng(0))
    return dots.points[chosen], dots.normals[chosen]


def test_the_recovered_surface_comes_nearer(dots, kept):
    true = recovery.truth(ATOMS, RADII)
    before = recovery.errors(*recover(*kept), true)
    moved = relax(*kept, dots.points, dots.normals)
    after = recovery.errors(*recover(*moved), true)
    assert after["distance"] < 0.8 * before["distance"] and after["distance_95"] < 0.8 * before["distance_95"]
    assert np.linalg.norm(moved[0] - kept[0], axis=1).max() < 1
    assert np.linalg.norm(moved[1], axis=1) == pytest.approx(1)


def test_a_round_goes_half_the_way_to_a_plane_through_the_heights(dots, kept):
    points, normals = kept
    sheet = dots.points[:90] - np.repeat([1.5, -1.5, 0.0], 30)[:, None] * dots.normals[:90]
    places = np.concatenate([dots.points, sheet])  # two that are too far off, and one that faces anywhere
    anywhere = np.random.default_rng(0).normal(size=(30, 3))
    directions = np.concatenate([dots.normals, dots.normals[:60], anywhere])
    functions = fit_interpolants(points, normals)
    own = [[] for _ in points]
    for x, n in zip(places, directions, strict=True):
        near = np.argsort(np.linalg.norm(points - x, axis=1))[:4]
        alike = near[normals[near] @ n > 0]
        if len(alike):
            f, *gradient = interpolant_value(functions, functions.index.position[alike[0]], *x)
            height = f / max(np.linalg.norm(gradient), MIN_GRADIENT)
            if abs(height) < 1:
                own[alike[0]].append((x, height))
    moved = relax(points, normals, places, directions, rounds=1)
    for i, (p, n) in enumerate(zip(points, normals, strict=True)):
        across = np.linalg.svd(n[None])[2][1:]
        spacing = functions.spacing[functions.index.position[i]]
        x = np.array([[1.0, *(across @ (place - p) / spacing)] for place, _ in own[i]])
        square = x.T @ x + 0.02 * len(x) * np.eye(3)
        lift, *tilt = np.linalg.solve(square, x.T @ [height for _, height in own[i]])
        turned = n - 0.5 * np.array(tilt) @ across / spacing
        assert moved[0][i] == pytest.approx(p + 0.5 * lift * n, abs=1e-6)
        assert moved[1][i] == pytest.approx(turned / np.linalg.norm(turned), abs=1e-6)


def test_threads_and_turning_do_not_matter(dots, kept):
    one = relax(*kept, dots.points, dots.normals)
    two = relax(*kept, dots.points, dots.normals, threads=2)
    assert all(np.array_equal(a, b) for a, b in zip(one, two, strict=True))
    turn = np.array([[0, 1.0, 0], [0, 0, 1.0], [1.0, 0, 0]])
    turned = relax(*(x @ turn for x in kept), dots.points @ turn, dots.normals @ turn)
    assert turned[0] == pytest.approx(one[0] @ turn, abs=1e-6)


def test_a_dot_off_the_surface_is_drawn_onto_it(dots, kept):
    points = kept[0].copy()
    points[3] += 0.3 * kept[1][3]
    moved, _ = relax(points, kept[1], dots.points, dots.normals)
    stayed, _ = relax(*kept, dots.points, dots.normals)
    assert np.linalg.norm(moved[3] - stayed[3]) < 0.05


def test_a_dense_subset_and_a_few_dots_stay(dots):
    whole = dots.points, dots.normals
    moved, _ = relax(dots.points[::2], dots.normals[::2], *whole)
    assert np.linalg.norm(moved - dots.points[::2], axis=1).mean() < 0.03
    few = relax(dots.points[:3], dots.normals[:3], *whole)
    assert np.array_equal(few[0], dots.points[:3])
    alone = [x[::100][:4] for x in whole]  # some face all others, and have no spacing
    settled = relax(*alone, *whole)
    assert np.isfinite(settled).all() and not np.array_equal(settled[0], alone[0])
