"""The kernels of inference, rebuilding and cover as plain Python, which needs no compilation, beside naive references."""

import importlib
from itertools import pairwise

import numpy as np
import pytest

from conftest import sphere
from sparsurf.patches.index import build_grid
from sparsurf.recovery import neighbours
from sparsurf.recovery.spheres import atoms, explanations, inside, rebuilding, rolled, votes
from sparsurf.sampling import touches
from sparsurf.surfaces import grid
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.surface import Placement, SurfaceOrigin

INDEX = importlib.import_module("sparsurf.patches.index")
MODULES = (INDEX, grid, neighbours, atoms, explanations, inside, rebuilding, rolled, votes, touches)
PROBE, WIDTH = 1.4, 0.004
CENTRES = np.array([[0.0, 0, 0], [2.2, 0.3, 0], [0.4, 2.3, 0.2], [0.2, 0.5, 2.4], [-2.1, 0.2, 0.6]])
RADII = np.array([1.9, 1.5, 1.4, 1.9, 1.5])


@pytest.fixture(autouse=True)
def plain(placed, monkeypatch):
    """Let the modules call the Python of their kernels."""
    for module in MODULES:
        for name, value in [*vars(module).items()]:
            if hasattr(value, "py_func"):
                monkeypatch.setattr(module, name, value.py_func)


def points_and_normals(n=120, radius=3.0, seed=0):
    """Dots of a ball with some noise, and unit normals."""
    rng = np.random.default_rng(seed)
    outward = rng.normal(size=(n, 3))
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return radius * outward + rng.normal(0, 0.3, (n, 3)), outward


def distances(a, b):
    return np.linalg.norm(a[:, None] - b, axis=2)


def test_nearest_dots_are_those_of_all_that_qualify():
    points, normals = points_and_normals()
    places, facing = points_and_normals(40, seed=1)
    normals = normals[np.random.default_rng(2).permutation(len(normals))]  # towards all sides
    index, gap = build_grid(points, normals, side=0.7), distances(places, points)
    nearest = rebuilding._nearest_facing(index, places, facing, 0.8, 0.3, 1)
    fits = np.where((facing @ normals.T > 0.3) & (gap < 0.8), gap, np.inf)
    expected = np.where(np.isfinite(fits.min(axis=1)), fits.argmin(axis=1), -1)
    assert (expected != np.where(gap.min(axis=1) < 0.8, gap.argmin(axis=1), -1)).any()
    assert np.where(nearest < 0, -1, index.dot[nearest]).tolist() == expected.tolist() and -1 in expected
    near = rebuilding._distances_to_nearest(index, places, 0.6)
    np.testing.assert_allclose(near, np.minimum(gap.min(axis=1), 0.6), rtol=1e-12)
    assert rolled._are_near(index, places, 0.6).tolist() == (gap.min(axis=1) < 0.6).tolist()
    assert 5 < (near < 0.6).sum() < 35


def test_points_are_pushed_out_of_the_nearest_ball_three_times():
    centres = points_and_normals(8, 2.0)[0]
    points, normals = points_and_normals(40, 2.5, seed=2)
    expected, outward = points.copy(), normals.copy()
    for i in range(len(points)):
        for _ in range(3):
            away = expected[i] - centres
            gap = np.linalg.norm(away, axis=1)
            k = gap.argmin()
            if gap[k] >= PROBE - 1e-6:
                break
            outward[i] = -away[k] / gap[k]
            expected[i] = centres[k] - PROBE * outward[i]
    assert (expected == points).any() and not (expected == points).all()
    rebuilding._push_out(build_grid(centres), 0, len(points), PROBE, points, normals)
    np.testing.assert_allclose(points, expected, atol=1e-12)
    np.testing.assert_allclose(normals, outward, atol=1e-12)


def test_neighbours_lie_on_the_same_side():
    points, normals = points_and_normals(60, 1.0)
    index, k = build_grid(points, normals, side=0.7), 9
    found, gap = np.empty((60, k), np.int64), np.empty((60, k))
    neighbours.nearest_on_same_side(index, 0, 60, 0.3, found, gap)
    every = distances(index.xyz, index.xyz)
    every[index.normals @ index.normals.T < -0.5] = np.inf
    assert found.tolist() == np.argsort(every, axis=1, kind="stable")[:, :k].tolist()
    np.testing.assert_allclose(gap, np.sort(every, axis=1)[:, :k], atol=1e-12)


@pytest.fixture(scope="module")
def placed():
    """A surface of five atoms, and where its dots were placed, by compiled kernels."""
    dots = molecular_surface(CENTRES, RADII, PROBE, density=2.0)
    return dots, SurfaceOrigin.of_atoms(None, 0, CENTRES, Placement(PROBE), 0.5, RADII)


def test_touches_are_those_of_every_probe_and_atom(placed):
    dots, origin = placed
    dots = dots.take(np.sort([*range(len(dots)), 7, 7, 90]))  # some have one probe
    found = touches.touches_of(dots, origin)
    gap = distances(dots.points + PROBE * dots.normals, CENTRES) - RADII - PROBE
    expected = [np.flatnonzero(np.abs(row) < 1e-5).tolist() for row in gap]
    assert [sorted(found.atom[a:b]) for a, b in pairwise(found.start)] == expected
    assert {len(each) for each in expected} == {1, 2, 3}
    probes = dots.points + PROBE * dots.normals
    same = np.append(False, np.linalg.norm(np.diff(probes, axis=0), axis=1) < 1e-3)
    first = [k for k in range(len(same)) if not same[k]]
    assert found.first.tolist() == [max(k for k in first if k <= i) for i in range(len(same))] and same.any()


def test_each_dot_of_the_cover_touches_most_of_what_lacks_a_touch(placed):
    dots, origin = placed
    found, order = touches.touches_of(dots, origin), np.random.default_rng(0).permutation(len(dots))
    lacks, used = np.array([12, 5, 9, 0, 7]), np.zeros(len(dots), bool)
    left, taken, expected = lacks.copy(), set(), []
    while True:
        gains = [
            0
            if found.first[i] in taken
            else (left[found.atom[found.start[i] : found.start[i + 1]]] > 0).sum()
            for i in order
        ]
        if max(gains) == 0:
            break
        expected.append(order[np.argmax(gains)])
        taken.add(found.first[expected[-1]])
        left[found.atom[found.start[expected[-1]] : found.start[expected[-1] + 1]]] -= 1
    assert touches.set_cover(order, found, lacks, used).tolist() == expected and len(expected) > 9
    assert lacks.tolist() == left.tolist() and {*np.flatnonzero(used)} == taken


def test_votes_and_their_peaks(placed):
    """A vote is the radius of the atom from which a dot and the probe of another one would follow."""
    dots, _ = placed
    booth = votes._Booth(dots.points, dots.normals)
    points, normals, expected = booth.points, booth.normals, []
    for i in booth.voters:
        away = points[i] - points - PROBE * normals
        near = np.argsort((away[booth.near[list(booth.voters).index(i)]] ** 2).sum(axis=1), kind="stable")[
            :16
        ]
        for j in booth.near[list(booth.voters).index(i)][near]:
            slope = PROBE + normals[i] @ away[j]
            radius = (away[j] @ away[j] - PROBE**2) / (2 * slope) if abs(slope) > 0.1 else 0
            expected += [radius] if 0.9 < radius < 2.3 else []
    found = booth.votes(PROBE)
    np.testing.assert_allclose(found, np.sort(expected), rtol=1e-9)
    assert {*votes._peaks(found.copy(), WIDTH, 3)[0].round(2)} == {1.4, 1.5, 1.9}


def test_peaks_are_the_fullest_windows_without_their_flanks():
    """Flanks of a peak hold more votes than the other peaks do."""
    rng = np.random.default_rng(0)
    at = [(1.4, 900), (1.5, 90), (1.9, 30)]
    left = np.sort(np.concatenate([rng.normal(middle, WIDTH, n) for middle, n in at]))
    middle, count = votes._peaks(left.copy(), WIDTH, 3)
    for k in range(3):
        held = [(left >= low) & (left < low + WIDTH) for low in left]
        best = max(held, key=np.sum)
        assert count[k] == best.sum() and middle[k] == pytest.approx(np.median(left[best]), abs=1e-9)
        left = left[(left < left[best].min() - 3 * WIDTH) | (left > left[best].max() + 3 * WIDTH)]
    assert middle.round(2).tolist() == [1.4, 1.5, 1.9]


def test_the_atoms_of_a_small_molecule_follow_from_its_dots(placed):
    dots, _ = placed
    model = votes.known_model(dots.points, dots.normals, PROBE, np.unique(RADII))
    found = atoms.infer(dots.points, dots.normals, model)
    gap = distances(CENTRES, found.centres)
    assert gap.min(axis=1).max() < 1e-6 and found.radii[gap.argmin(axis=1)].tolist() == RADII.tolist()
    probes = dots.points + PROBE * dots.normals
    spread = distances(probes, found.centres) - found.radii - PROBE
    assert spread.min() > -0.02  # no probe lies inside an atom
    assert sorted(gap.argmin(axis=1)) == [
        *range(5)
    ]  # these explain most; others agree with a few dots by chance
    told = explanations.explain(probes, dots.normals, CENTRES, RADII, model)
    assert (
        told.kind.tolist()
        == np.array([explanations.BY_CONTACT, explanations.BY_SADDLE, explanations.BY_THREE])[
            dots.kind
        ].tolist()
    )


def test_spheres_are_those_that_a_probe_lies_on():
    """Probes inside a sphere do not touch it."""
    probes, centres = points_and_normals(60)[0], points_and_normals(9, 1.0, seed=1)[0]
    reach, tolerance = np.linspace(2, 3.5, 9), 0.1
    start, touched = explanations.touched_atoms(probes, centres, reach, tolerance)
    gap = distances(probes, centres) - reach
    expected = [np.flatnonzero(np.abs(row) < tolerance).tolist() for row in gap]
    assert [sorted(touched[a:b]) for a, b in pairwise(start)] == expected
    assert (gap < -tolerance).any() and {len(each) for each in expected} > {0, 1, 2}
    reach = gap.min(axis=0) + reach + np.linspace(-0.23, 0.23, 9)  # around the nearest probe of each
    count = atoms._touches(build_grid(probes), centres, reach, tolerance)
    gap = distances(probes, centres) - reach
    expected = np.where((gap <= -tolerance).any(axis=0), -1, (gap <= tolerance).sum(axis=0))
    assert count.tolist() == expected.tolist() and {*expected} > {-1, 0, 1}


def test_winding_numbers_of_a_ball_are_one_inside():
    normals = sphere(150)[0]
    closed = inside.Inside(3 * normals, normals, 4.4 * normals, 2 * normals)
    places = np.array([[0.0, 0, 0], [1.5, 0, 0], [0, -5, 0], [30.0, 0, 0]])
    assert np.allclose(closed.winding_numbers(places), [1, 1, 0, 0], atol=0.05)


def test_solid_angles_are_those_of_every_dot():
    """Dots of a distant cube are seen as one, within a hundredth of the whole angle."""
    normals = sphere(900)[0]
    points = 14 * normals
    closed = inside.Inside(points, normals, 1.1 * points, 0.9 * points)
    places = np.concatenate([points_and_normals(30, 12.0)[0], points_and_normals(30, 18.0)[0]])
    away = points - places[:, None]
    squares = (away**2).sum(axis=2) + inside.ADDED_TO_SQUARES
    angles = ((away * normals).sum(axis=2) / squares**1.5).sum(axis=1)
    np.testing.assert_allclose(closed._sums(places), angles, atol=0.01 * angles.max())
