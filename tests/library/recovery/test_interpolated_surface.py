"""The surface interpolated between few dots: spheres, a torus, invariances, a naive solution of the same system."""

import itertools

import numpy as np
import pytest
from scipy.spatial import cKDTree

from conftest import ball
from sparsurf.patches.index import build_grid
from sparsurf.recovery.interpolants import SUPPORT, fit_interpolants, interpolant_value
from sparsurf.recovery.interpolated_surface import (
    NEWTON_STEPS,
    _place_discs,
    _project,
    dot_spacing,
    interpolate_surface,
)
from sparsurf.recovery.neighbours import nearest_on_same_side
from sparsurf.surfaces.molecular_surface import molecular_surface


def torus(n, ring=4.0, tube=1.4, seed=0):
    """Random dots of a torus with distances at least a spacing apart, and its normals."""
    rng = np.random.default_rng(seed)
    u, v = rng.random((2, 40 * n)) * 2 * np.pi
    keep = rng.random(len(u)) < (ring + tube * np.cos(v)) / (ring + tube)
    u, v = u[keep], v[keep]
    normals = np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)], axis=1)
    points = ring * np.stack([np.cos(u), np.sin(u), 0 * u], axis=1) + tube * normals
    chosen = [0]
    gap = np.linalg.norm(points - points[0], axis=1)
    while len(chosen) < n:  # farthest-point dots, naively
        chosen.append(int(gap.argmax()))
        gap = np.minimum(gap, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return points[chosen], normals[chosen]


def test_neighbours_are_the_nearest_in_order():
    """Against a sort; on random points, and on a grid of points, where most distances come several times."""
    grid = np.stack(np.meshgrid(*[np.arange(4.0)] * 3), axis=-1).reshape(-1, 3)
    for points, k in itertools.product((grid, grid + np.random.default_rng(0).random((64, 3))), (1, 5, 80)):
        index = build_grid(points, np.tile([0.0, 0, 1], (64, 1)))
        near, gap = np.empty((64, k), np.int32), np.empty((64, k))
        nearest_on_same_side(index, 0, 64, 1.1, near, gap)
        every = np.linalg.norm(index.xyz[:, None] - index.xyz, axis=-1)
        m = min(k, 64)
        assert np.allclose(gap[:, :m], np.sort(every, axis=1)[:, :m])
        assert np.array_equal(near[:, :m], np.argsort(every, axis=1, kind="stable")[:, :m])
        assert (near[:, m:] == -1).all()
        assert (gap[:, m:] == gap[:, m - 1 : m]).all()


def test_a_sphere_comes_back():
    points, normals = interpolate_surface(*ball(60, 3))
    assert (
        np.abs(np.linalg.norm(points, axis=1) - 3).max() < 0.01
    )  # dots are 1.4 Å apart; a chord's height is 0.08
    assert np.abs((normals * points).sum(axis=1) / 3 - 1).max() < 1e-3
    assert len(points) == pytest.approx(5.35 * 4 * np.pi * 9, rel=0.35)
    assert cKDTree(points).query(ball(2000, 3)[0])[0].max() < 0.5  # no hole: patches stay linked


def test_a_torus_comes_back():
    dots = torus(150)
    points, normals = interpolate_surface(*dots)
    ring = np.hypot(points[:, 0], points[:, 1]) - 4
    away = np.hypot(ring, points[:, 2])
    assert np.abs(away - 1.4).mean() < 0.01
    spoke = points[:, :2] / np.hypot(points[:, 0], points[:, 1])[:, None]
    true = np.column_stack([spoke * (ring / away)[:, None], points[:, 2] / away])
    assert np.degrees(np.arccos(np.clip((true * normals).sum(axis=1), -1, 1))).mean() < 3


def test_the_kept_dots_come_first_and_stay():
    dots = ball(60, 3)
    for density in (1.0, 5.35, 20.0):
        points, normals = interpolate_surface(*dots, density=density)
        assert np.array_equal(points[:60], dots[0]) and np.array_equal(normals[:60], dots[1])
        gap = cKDTree(points).query(points[60:], k=2)[0][:, 1]
        assert (gap > 0.65 / np.sqrt(density)).all()
    assert len(interpolate_surface(*ball(3, 3))[0]) == 3  # too few to say anything
    assert len(interpolate_surface(*ball(4, 3))[0]) > 4
    assert cKDTree(interpolate_surface(*dots, keep=False)[0]).query(dots[0])[0].min() > 0


def test_recovery_turns_with_the_dots():
    points, normals = torus(150)
    q = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    there, back = (
        interpolate_surface(points, normals)[0],
        interpolate_surface(points @ q.T + 20, normals @ q.T)[0],
    )
    gap = cKDTree(there).query((back - 20) @ q)[0]
    assert gap.max() < 0.45  # other places of the same surface
    assert (
        np.abs(np.hypot(np.hypot(*((back - 20) @ q)[:, :2].T) - 4, ((back - 20) @ q)[:, 2]) - 1.4).mean()
        < 0.01
    )


def test_threads_do_not_change_a_bit(blob):
    some = slice(0, 700)  # more than a slice of kept dots
    one, two = (
        interpolate_surface(blob[0][some], blob[1][some]),
        interpolate_surface(blob[0][some], blob[1][some], threads=3),
    )
    assert np.array_equal(one[0], two[0]) and np.array_equal(one[1], two[1])


def test_interpolants_solve_the_written_system():
    points, normals = torus(60)
    functions = fit_interpolants(points, normals, neighbours=9)
    i, x = 17, np.array([0.3, -0.2, 0.25])
    own, facing = functions.index.xyz[i], functions.index.normals[i]
    near = np.argsort(np.where(normals @ facing < -0.5, 9.9e9, np.linalg.norm(points - own, axis=1)))[:9]
    support = SUPPORT * np.linalg.norm(points[near[-1]] - own)

    def phi(d):  # Wendland's function of a vector, in supports
        t = min(np.linalg.norm(d), 1.0)
        return (1 - t) ** 6 * (35 * t * t + 18 * t + 3)

    def derivatives(function, d, h=1e-4):
        """Value, then gradient by central differences."""
        return [function(d)] + [(function(d + h * e) - function(d - h * e)) / (2 * h) for e in np.eye(3)]

    p, n = (points[near] - own) / support, normals[near]

    def columns(d):  # phi and -grad phi around every neighbour: the functions that are summed
        rows = [derivatives(phi, d - q) for q in p]
        return np.array([[r[0], *(-np.array(r[1:]))] for r in rows]).ravel()

    rows = np.concatenate([np.array(derivatives(columns, q)) for q in p])
    bend = np.sum(p * (n - facing)) / np.sum(p * p)
    right = np.concatenate(
        [[-(q @ facing) - bend / 2 * q @ q, *(m - facing - bend * q)] for q, m in zip(p, n, strict=True)]
    )
    coefficient = np.linalg.solve(rows, right)
    y = x / support
    expected = support * (columns(y) @ coefficient + facing @ y + bend / 2 * y @ y)
    found = interpolant_value(functions, i, *(own + x))
    assert found[0] == pytest.approx(expected, abs=2e-3)
    step = [
        (
            interpolant_value(functions, i, *(own + x + h))[0]
            - interpolant_value(functions, i, *(own + x - h))[0]
        )
        / 2e-5
        for h in 1e-5 * np.eye(3)
    ]
    assert np.allclose(found[1:], step, atol=1e-6)
    for q, m in zip(points[near], n, strict=True):  # 0 there, with the normals as gradients
        f, *gradient = interpolant_value(functions, i, *q)
        assert abs(f) < 1e-3 and np.allclose(gradient, m, atol=0.01)


def test_every_interpolant_meets_all_its_neighbours():
    """Dots of a thin plate have few neighbours: those on their own side."""
    x, y = (each.ravel() for each in np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.2, 2.3]))
    points = np.concatenate([np.column_stack([x, y, 0.1 * x * y + z]) for z in (0.0, -0.4)])
    normals = np.column_stack([-0.1 * y, -0.1 * x, np.ones(9)]) / np.sqrt(1 + (x**2 + y**2)[:, None] / 100)
    normals = np.concatenate([normals, -normals])
    functions = fit_interpolants(points, normals)
    assert functions.count.tolist() == [9] * 18
    for i, own in enumerate(functions.index.dot):
        for j in np.flatnonzero(np.arange(18) // 9 == own // 9):
            f, *gradient = interpolant_value(functions, i, *points[j])
            assert abs(f) < 1e-3 and np.allclose(gradient, normals[j], atol=0.01)


def test_far_away_only_the_sphere_of_the_mean_curvature_is_left():
    points, normals = torus(60)
    functions = fit_interpolants(points, normals)
    for i in (0, 17):
        d = 1.5 * functions.support[i] * np.array([0.6, 0.0, -0.8])
        own, facing = functions.index.xyz[i], functions.index.normals[i]
        # phi ends one support from the farthest neighbour, a third of a support away
        assert np.linalg.norm(d) > (1 + 1 / SUPPORT) * functions.support[i]
        bend = functions.curvature[i] / functions.support[i]
        f, *gradient = interpolant_value(functions, i, *(own + d))
        assert f == pytest.approx(facing @ d + bend / 2 * d @ d, abs=1e-9)
        assert np.allclose(gradient, facing + bend * d, atol=1e-9)


PLATE = np.array([[2.0 * i, 2.0 * j, 0] for i in range(5) for j in range(5)])


def test_places_around_a_dot_alone_fill_a_disc_like_a_sunflower():
    """On a plane, where none moves: the k-th of m in a disc of a radius R lies R sqrt(k / m) away."""
    functions = fit_interpolants(PLATE, np.tile([0.0, 0, 1], (25, 1)))
    i = int(functions.index.position[12])
    for spacing, density, reach in ((0.5, 5.0, 1.0), (0.5, 40.0, 0.8), (0.4, 100.0, 1.5)):
        alone = functions._replace(spacing=np.full(25, spacing))  # no other dot is in reach
        points, normals = _place_discs(alone, i, i + 1, density, reach, 4)
        m = int(np.pi * reach**2 * max(1.3 * density * spacing**2, 10.0))
        gap = np.linalg.norm(points - PLATE[12], axis=1)
        assert gap == pytest.approx(reach * spacing * np.sqrt(np.arange(1, m) / m))
        assert np.allclose(normals, [0, 0, 1]) and np.abs(points[:, 2]).max() < 1e-9


def test_places_go_to_the_nearest_dot_that_looks_the_same_way():
    below = PLATE[:16] * [0.75, 0.75, 1] + [1.0, 1.0, -0.3]
    dots, normals = np.concatenate([PLATE, below]), np.repeat([[0, 0, 1.0], [0, 0, -1.0]], [25, 16], axis=0)
    functions = fit_interpolants(dots, normals)
    i = int(functions.index.position[12])
    points, _ = _place_discs(functions, i, i + 1, 40.0, 1.0, 4)
    gap = np.linalg.norm(points[:, None] - PLATE, axis=2)
    own = gap[:, 12]
    assert (0.95 * own <= gap.min(axis=1)).all() and (own > gap.min(axis=1)).any()
    # the square of 2 Å around the dot, and a rim for ties
    assert len(points) == pytest.approx(40 * 1.3 * 2.1**2, rel=0.1)


def projected(functions, place, steps, longest):
    """Points and normals at which a place arrives on the function of dot position 7, one or none."""
    points, normals = np.empty((1, 3)), np.empty((1, 3))
    n = _project(functions, 7, place[None], steps, longest, points, normals, 0)
    return points[:n], normals[:n]


def test_a_place_takes_steps_of_a_bounded_length_and_arrives_or_not():
    functions = fit_interpolants(*ball(60, 3))
    place = 1.2 * functions.index.xyz[7]  # 0.6 Å above its dot
    assert not len(projected(functions, place, 6, 0.1)[0])  # on the surface, but not looked at there
    for steps, longest in ((7, 0.1), (4, 9.0)):
        points, normals = projected(functions, place, steps, longest)
        assert np.linalg.norm(points, axis=1) == pytest.approx([3], abs=0.01)
        assert np.allclose(normals, functions.index.normals[7], atol=0.01)
    # about the middle of the sphere no way is nearest, though any leads to it
    assert not len(projected(functions, 0.05 * functions.index.normals[7], 8, 1.0)[0])


def test_close_dots_take_fewer_neighbours_and_no_places_that_are_thinned_out():
    points, normals = ball(600, 3)  # 0.43 Å apart
    wide = np.arange(600) % 12 == 0  # of which one half of the sphere keeps a twelfth
    points, normals = (x[(points[:, 2] > 0) | wide] for x in (points, normals))
    functions = fit_interpolants(points, normals, close=0.8)
    assert functions.count.tolist() == np.where(functions.spacing < 0.8, 8, 12).tolist()
    assert 20 < (functions.count == 12).sum() < 60
    few = fit_interpolants(points, normals, neighbours=8)
    i = int(np.argmin(functions.spacing))
    place = functions.index.xyz[i] * 1.01
    assert interpolant_value(functions, i, *place)[0] == pytest.approx(
        interpolant_value(few, i, *place)[0], abs=1e-4
    )
    laid, _ = _place_discs(functions, 0, len(points), 20.0, 1.0, 4, 0.3)
    nearest = np.linalg.norm(laid[:, None] - points, axis=2).min(axis=1)
    assert 0.28 < nearest.min() < 0.31  # rivals may be nearer by a twentieth
    assert np.linalg.norm(laid, axis=1) == pytest.approx(3, abs=0.02)
    whole, quick = (
        interpolate_surface(points, normals, 20.0),
        interpolate_surface(points, normals, 20.0, close=0.8),
    )
    assert len(quick[0]) == pytest.approx(len(whole[0]), rel=0.01)


def test_two_dots_at_one_place_do_no_harm():
    points, normals = ball(60, 3)
    double = np.concatenate([points, points[:5]]), np.concatenate([normals, normals[5:10]])
    found = interpolate_surface(*double)[0]
    assert np.isfinite(found).all() and np.array_equal(found[:65], double[0])
    assert np.abs(np.linalg.norm(found, axis=1) - 3).max() < 0.5


def test_spacing_belongs_to_its_dot_and_a_single_one_has_none():
    points, normals = torus(60)
    assert dot_spacing(points[::-1], normals[::-1]) == pytest.approx(dot_spacing(points, normals)[::-1])
    assert np.isnan(dot_spacing(points[:1], normals[:1])).tolist() == [True]
    lonely = dot_spacing(np.vstack([points, [[90, 0, 0]]]), np.vstack([normals, [[1, 0, 0]]]))
    assert lonely[-1] == pytest.approx(2 * np.median(lonely)) and lonely[:-1].max() < 1.9 * np.median(lonely)
    # five dots: the distance to the fourth neighbour holds four and a half of them
    cross = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    found = dot_spacing(cross, np.tile([0.0, 0, 1], (5, 1)))
    assert found == pytest.approx(np.sqrt(np.pi / 4.5) * np.array([1, 2, 2, 2, 2]))


def test_a_sheet_goes_on_beyond_its_last_dots_by_their_spacing():
    x, y = (2.0 * k.ravel() for k in np.mgrid[:8, :8])
    points, normals = np.stack([x, y, 0 * x], axis=1), np.tile([0.0, 0, 1], (64, 1))
    spacing = dot_spacing(points, normals)
    recovered, _ = interpolate_surface(points, normals, density=10.0)
    for corner, beyond in ((0, -recovered.min(axis=0)), (-1, recovered.max(axis=0) - 14.0)):
        assert np.all(beyond[:2] <= spacing[corner]) and np.all(beyond[:2] > 0.95 * spacing[corner])


def test_no_place_needs_more_steps_than_are_made(blob):
    points, normals = (each[::60] for each in blob)
    made, all_of_them = (
        len(interpolate_surface(points, normals, 3.0, steps=n)[0]) for n in (NEWTON_STEPS, 1000)
    )
    assert made >= 0.99 * all_of_them  # half as many steps leave a quarter of the places on their way


def test_a_twentieth_of_a_molecule_gives_it_back():
    xyz = np.array(
        [[0, 0, 0], [1.5, 0, 0], [2.2, 1.3, 0.2], [3.7, 1.4, 0.3], [4.3, 2.7, 0.9], [5.8, 2.8, 0.8]]
    )
    radii = np.array([1.9, 1.5, 1.9, 1.4, 1.85, 1.9])
    whole, dense = molecular_surface(xyz, radii), molecular_surface(xyz, radii, density=60)
    rng = np.random.default_rng(0)
    chosen = [0]
    gap = np.linalg.norm(whole.points - whole.points[0], axis=1)
    while len(chosen) < len(whole) // 15:
        chosen.append(int(gap.argmax()))
        gap = np.minimum(gap, np.linalg.norm(whole.points - whole.points[chosen[-1]], axis=1))
    points, _ = interpolate_surface(whole.points[chosen], whole.normals[chosen])
    off = cKDTree(dense.points).query(points)[0]
    assert np.mean(off) < 0.12  # half the spacing of the dense dots is 0.065
    bare = whole.points[chosen] + 0.5 * rng.normal(size=(len(chosen), 3))
    assert np.mean(cKDTree(dense.points).query(interpolate_surface(bare, whole.normals[chosen])[0])[0]) > 0.2
