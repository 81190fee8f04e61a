"""Exact distances from the surface of spheres, against all places of the probe on one, two and three spheres tried one by one."""

from itertools import combinations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT, sphere
from sparsurf.surfaces.dot_placement import roll_probe
from sparsurf.surfaces.exact_distance import distance_of_dots, exact_distance
from sparsurf.surfaces.molecular_surface import roll_spheres
from sparsurf.surfaces.rolling_probe import PHI_0, PHI_1

PROBE = 1.4
FAR = 1e6  # Å, in place of the distance of what is not accessible


def naive(points, xyz, radii):
    """Signed distances by the nearest accessible place of all spheres, pairs and triples."""
    reach = np.asarray(radii) + PROBE

    def accessible(places, *touched):
        gap = np.linalg.norm(places[:, None] - xyz, axis=2) - reach
        gap[:, list(touched)] = 0
        return (gap > -1e-9).all(axis=1)

    free = accessible(points)
    best = np.full(len(points), FAR)

    def offer(places, *touched):
        away = np.linalg.norm(places - points, axis=1)
        np.minimum(best, np.where(accessible(places, *touched), away, FAR), out=best)

    for i in range(len(xyz)):
        w = points - xyz[i]
        offer(xyz[i] + reach[i] * w / np.linalg.norm(w, axis=1)[:, None], i)
    for i, j in combinations(range(len(xyz)), 2):
        d = np.linalg.norm(xyz[j] - xyz[i])
        axis = (xyz[j] - xyz[i]) / d
        height = (d**2 + reach[i] ** 2 - reach[j] ** 2) / (2 * d)
        if d >= reach[i] + reach[j] or height**2 >= reach[i] ** 2:
            continue
        middle, radius = xyz[i] + height * axis, np.sqrt(reach[i] ** 2 - height**2)
        w = points - middle
        w -= (w @ axis)[:, None] * axis
        offer(middle + radius * w / np.linalg.norm(w, axis=1)[:, None], i, j)
        for k in range(j + 1, len(xyz)):
            # the places at reach of all three, on the circle of i and j
            to_k = xyz[k] - middle
            across = to_k - (to_k @ axis) * axis
            length = np.linalg.norm(across)
            cosine = (radius**2 + to_k @ to_k - reach[k] ** 2) / (2 * radius * length)
            if abs(cosine) < 1:
                e1, e2 = across / length, np.cross(axis, across / length)
                for sine in (np.sqrt(1 - cosine**2), -np.sqrt(1 - cosine**2)):
                    place = middle + radius * (cosine * e1 + sine * e2)
                    offer(np.tile(place, (len(points), 1)), i, j, k)
    outside = (np.linalg.norm(points[:, None] - xyz, axis=2) - radii).min(axis=1)
    return np.where(free, outside, PROBE - best)


def shell():
    """Spheres around a cavity of a few probes, and a hollow that no probe enters."""
    return 6.0 * sphere(70)[0], np.full(70, 1.9)


def molecule():
    rng = np.random.default_rng(4)
    return rng.uniform(0, 9, (40, 3)), rng.choice([1.2, 1.6, 1.9], 40)


@pytest.mark.parametrize("spheres", [molecule, shell])
def test_distances_are_those_of_all_places_tried_one_by_one(spheres):
    xyz, radii = spheres()
    points = np.random.default_rng(1).uniform(xyz.min(axis=0) - 4, xyz.max(axis=0) + 4, (800, 3))
    expected = naive(points, xyz, radii)
    distance = exact_distance(points, roll_spheres(xyz, radii, PROBE))
    assert np.abs(distance - expected).max() < 1e-6
    for sign in (expected < -1.5, expected > PROBE, (expected > 0) & (expected < PROBE)):
        assert sign.sum() > 10  # each kind of place was tried
    capped = exact_distance(points, roll_spheres(xyz, radii, PROBE), deepest=0.7)
    assert np.abs(capped - np.maximum(expected, -0.7)).max() < 1e-6


def test_a_removed_cavity_is_inside():
    xyz, radii = shell()
    points = np.random.default_rng(1).uniform(-9, 9, (1500, 3))
    kept, removed = (
        exact_distance(points, roll_spheres(xyz, radii, PROBE, cavities=each)) for each in ("keep", "remove")
    )
    middle = np.linalg.norm(points, axis=1) < 2
    assert (kept[middle] > PROBE).sum() > 5
    assert (removed[middle] < -4).all()
    # what lies nearer to the outside than to the cavity does not change
    outside = np.linalg.norm(points, axis=1) > 7
    assert np.abs(removed - kept)[outside].max() == 0
    assert np.abs(removed[middle] - depth_of_outer_places(points[middle], xyz, radii)).max() < 0.02


def depth_of_outer_places(points, xyz, radii):
    """Signed distances by the places of dense dots without those in cavities."""
    outer = sparsurf.surface((xyz, radii), cavities="remove", density=30)
    return PROBE - cKDTree(outer.points + PROBE * outer.normals).query(points)[0]


def test_a_probe_in_a_wide_cavity_is_known_far_from_its_wall():
    xyz, radii = 16.0 * sphere(700)[0], np.full(700, 1.9)
    middle = np.array([[0.5, 0.2, 0.1], [40.0, 0, 0]])
    kept, removed = (
        exact_distance(middle, roll_spheres(xyz, radii, PROBE, cavities=each)) for each in ("keep", "remove")
    )
    outside = (np.linalg.norm(middle[:, None] - xyz, axis=2) - radii).min(axis=1)
    assert kept == pytest.approx(outside, abs=1e-6) and outside.min() > 13
    assert removed == pytest.approx([-10.0, outside[1]], abs=1e-6)
    deep = exact_distance(middle, roll_spheres(xyz, radii, PROBE, cavities="remove"), deepest=30.0)
    assert deep[0] == pytest.approx(depth_of_outer_places(middle, xyz, radii)[0], abs=0.02)


def test_the_seam_of_a_whole_circle_of_places_belongs_to_it():
    turn = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    ring = np.column_stack([6 * np.cos(turn), 6 * np.sin(turn), 0 * turn]).round(3)
    rolled = roll_spheres(ring, np.full(12, 1.7), PROBE)
    assert np.ptp(rolled.rolling.arcs[:, PHI_0 : PHI_1 + 1], axis=1) == pytest.approx(2 * np.pi)
    assert np.abs(exact_distance(rolled.surface(30).points, rolled)).max() < 1e-6


@pytest.mark.parametrize("cavities", ["keep", "remove"])
def test_dots_lie_on_the_surface_and_shifted_ones_beside_it(cavities):
    surface = sparsurf.surface(ROOT / "data/tdp43/topology.pdb", cavities=cavities)
    origin = surface.origin
    rolled = roll_spheres(origin.xyz, origin.radii, PROBE, cavities=cavities)
    assert np.abs(exact_distance(surface.points, rolled)).max() < 1e-6
    for shift in (0.1, -0.1):
        distance = exact_distance(surface.points + shift * surface.normals, rolled)
        assert np.median(distance) == pytest.approx(shift, abs=1e-6)
        # at a cusp the nearest place belongs to the other side
        assert (np.abs(distance) < 0.1 + 1e-6).all() and np.mean(np.abs(distance - shift) < 1e-6) > 0.9


@pytest.mark.parametrize("spheres", [molecule, shell])
@pytest.mark.parametrize("cavities", ["keep", "remove"])
def test_dots_whose_probes_prove_their_distance_have_that_of_a_search(spheres, cavities):
    xyz, radii = spheres()
    rolled = roll_spheres(xyz, radii, PROBE, cavities=cavities)
    moved = xyz + [0.3, 0, 0] * (np.arange(len(xyz)) % 7 == 0)[:, None]
    for centres in (
        xyz,
        moved,
    ):  # with the concave dots of DMS inside other probes, also on the walls of cavities
        dots = roll_spheres(centres, radii, PROBE, "dms").surface(20)
        found = distance_of_dots(dots.points, dots.normals, rolled)
        assert np.abs(found - np.abs(exact_distance(dots.points, rolled))).max() < 1e-7
        assert spheres is shell or ((found > 0.01).sum() > 10 and (found == 0).mean() > 0.2)


def test_a_probe_that_rolls_on_over_further_spheres_rolls_as_over_all():
    xyz, radii = molecule()
    together = roll_probe(xyz, radii, PROBE, True)
    again = roll_probe(xyz, radii, PROBE, True, roll_probe(xyz[:33], radii[:33], PROBE, True))
    for name in ("arcs", "pair", "first_arc", "probes", "triple"):
        assert np.array_equal(getattr(again.rolling, name), getattr(together.rolling, name)), name
    for a, b in zip(again.rolling.atoms, together.rolling.atoms, strict=True):
        assert np.array_equal(a, b)


def test_distances_do_not_depend_on_threads_or_order():
    xyz, radii = molecule()
    rolled = roll_spheres(xyz, radii, PROBE)
    points = np.random.default_rng(2).uniform(0, 9, (9000, 3))
    distance = exact_distance(points, rolled)
    assert np.array_equal(distance, exact_distance(points, rolled, threads=3))
    assert np.array_equal(distance[::-1], exact_distance(points[::-1], rolled))
