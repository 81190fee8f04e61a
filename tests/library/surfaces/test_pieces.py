"""The exact pieces of a surface: Euler characteristics counted by hand, volumes by formulas and by positions tried one by one."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial import cKDTree

from conftest import sphere
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.areas import areas_by_kind
from sparsurf.surfaces.dot_placement import roll_checked
from sparsurf.surfaces.pieces import CUSP_ARC, pieces_of, shapes_of
from sparsurf.surfaces.radii import radii as radii_of
from sparsurf.surfaces.surface import CONCAVE


def shapes(xyz, radii, probe=1.4):
    """Pieces and shapes of spheres, which close, and whose curvatures and areas agree with other ways to compute them."""
    rolled = roll_checked(xyz, radii, probe, in_order=True)
    pieces = pieces_of(rolled)
    found = shapes_of(rolled, pieces)
    assert pieces.n_open == 0
    assert found.curvature == pytest.approx(found.chi, abs=1e-5)
    assert found.closing.max() < 1e-9 * found.area.max() + 1e-11
    assert found.area.sum() == pytest.approx(areas_by_kind(rolled, len(radii)).sum(), rel=1e-6)
    return pieces, found


def ring(n, radius):
    turn = 2 * np.pi * np.arange(n) / n
    return radius * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])


def cubic(step):
    return step * np.stack(np.meshgrid(*[np.arange(4.0)] * 3), -1).reshape(-1, 3)


def heap(n, seed, side=10.0):
    rng = np.random.default_rng(seed)
    return rng.uniform(0, side, (n, 3)).round(3), rng.uniform(1.2, 1.9, n).round(2)


@pytest.mark.parametrize(
    ("name", "chi", "volume"),
    [
        ("1a52_A", [-10, 2, 2, 2, 2], 30341.163),
        ("2k2d_A", [0, 2], 5354.676),
        ("3bd9_A", [-8, 2, 2, 2], 33720.839),
        ("1zbu_B", [-26, 2, 2], 37809.352),
        ("3mtg_B", None, None),  # where many probes lie nearly at one place
    ],
)
def test_proteins(shared, name, chi, volume):
    molecule = read_molecule(shared / "data" / "chains" / f"{name}.pdb.gz")
    _, found = shapes(molecule.xyz[0].round(3), radii_of(molecule))
    assert chi is None or (found.chi.tolist(), found.volume.sum()) == (chi, pytest.approx(volume, abs=6e-4))
    assert (found.volume[0] > 0) and (np.diff(found.area) <= 0).all()


# 64 spheres, 144 tubes between neighbours: each sphere counts 2, each tube takes 2 away. A square of four spheres has a hole
# until the probes on both sides of it do not overlap any more: then the 27 cells are cavities.
@pytest.mark.parametrize(
    ("xyz", "chi"),
    [
        (cubic(4.5), [64 * 2 - 144 * 2]),
        (cubic(4.2), [64 * 2 - 144 * 2]),  # the four spheres of a square touch one probe on each side
        (cubic(4.0), [64 * 2 - 144 * 2]),
        (cubic(3.8), [2] + 27 * [2]),
        (cubic(3.58), [2] + 27 * [2]),  # all eight spheres of a cell nearly touch one probe
        (cubic(3.0), [2]),
        (cubic(6.3), 64 * [2]),
        (ring(6, 3.0), [0]),  # six spheres touch one probe on each side, and these two overlap
        (ring(6, 4.0), [0]),
        (ring(6, 5.0), [0]),
        (ring(6, 6.0), 6 * [2]),
        (ring(6, 2.0), [2]),
        (ring(12, 3.0), [0]),
        (np.concatenate([ring(6, 4.0), ring(6, 4.0) + np.array([0, 0, 3.0])]), [0]),
        (
            np.column_stack([2.3 * np.cos(np.arange(40)), 2.3 * np.sin(np.arange(40)), 0.3 * np.arange(40)]),
            [2],
        ),
    ],
)
def test_symmetric_spheres(xyz, chi):
    assert shapes(xyz, np.full(len(xyz), 1.7))[1].chi.tolist() == chi


def test_a_square_with_a_hole_and_without():
    """The concave pieces of both sides end on one circle, as wide as the probes overlap, which ends as these touch."""
    for side, radius in ((4.0, np.sqrt(1.4**2 - 3.1**2 + 8)), (3.85, 0.0)):
        square = side / 2 * np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0.0]])
        pieces, found = shapes(square, np.full(4, 1.7))
        cusps = pieces.circles[pieces.edge_kind == CUSP_ARC, 9]
        assert found.chi.tolist() == [0 if radius else 2]
        assert cusps == pytest.approx([radius] if radius else [], abs=1e-6)
        assert (pieces.face_kind == CONCAVE).sum() == 2


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("probe", [0.7, 1.4, 2.5])
def test_heaps(seed, probe):
    n = 10 + 6 * seed
    shapes(*heap(n, seed, 3.6 * n ** (1 / 3)), probe)


@pytest.mark.parametrize("distance", [0.05, 1.0, 3.0, 4.5, 5.4, 5.5, 6.0])
def test_two_spheres(distance):
    """The volume is that of a body of revolution around the axis, on which the probe meets itself from 4.2 Å on."""
    radii, probe, xyz = np.array([1.4, 1.3]), 1.4, np.array([[0, 0, 0], [0, 0, distance]])
    reach = radii + probe
    if distance < 0.1:  # the smaller one lies in the larger
        assert shapes(xyz, radii)[1].volume == pytest.approx([4 / 3 * np.pi * 1.4**3])
        return
    height = (distance**2 + reach[0] ** 2 - reach[1] ** 2) / (2 * distance)
    wide = np.sqrt(max(0.0, reach[0] ** 2 - height**2))
    ends = height * radii[0] / reach[0], distance - (distance - height) * radii[1] / reach[1]

    def area(z):  # of the section
        if distance < reach.sum() and ends[0] < z < ends[1]:
            return np.pi * max(0.0, wide - np.sqrt(max(0.0, probe**2 - (z - height) ** 2))) ** 2
        return np.pi * max(0.0, *(radii**2 - (z - xyz[:, 2]) ** 2))

    stops = sorted([-1.4, *ends, height - 1, height, height + 1, distance + 1.3])
    volume = sum(quad(area, *pair, limit=400)[0] for pair in pairwise(stops))
    assert shapes(xyz, radii)[1].volume.sum() == pytest.approx(volume, rel=1e-6)


def test_one_sphere_and_two_at_one_place():
    for xyz in (np.full((1, 3), 5.0), np.full((2, 3), 1e5)):
        _, found = shapes(xyz, np.full(len(xyz), 1.7))
        assert found.chi.tolist() == [2] and found.volume == pytest.approx([4 / 3 * np.pi * 1.7**3])


@pytest.mark.parametrize("seed", range(2))
def test_volumes_are_those_of_positions_tried_one_by_one(seed):
    """A position is outside if a probe covers it whose centre lies in no sphere of centres."""
    xyz, radii = heap(9, seed, 5.5)
    probe, unit, step = 1.4, sphere(12000)[0], 0.12
    centres = (xyz[:, None] + (radii + probe)[:, None, None] * unit).reshape(-1, 3)
    inside = np.zeros(len(centres), bool)
    for position, reach in zip(xyz, radii + probe, strict=True):
        inside |= ((centres - position) ** 2).sum(axis=1) < (reach - 1e-9) ** 2
    low, high = xyz.min(axis=0) - 2, xyz.max(axis=0) + 2
    tried = np.stack(
        np.meshgrid(*[np.arange(a, b, step) for a, b in zip(low, high, strict=True)]), -1
    ).reshape(-1, 3)
    near = np.zeros(len(tried), bool)
    for position, reach in zip(xyz, radii + probe, strict=True):
        near |= ((tried - position) ** 2).sum(axis=1) < reach**2
    covered = cKDTree(centres[~inside]).query(tried[near], distance_upper_bound=probe)[0] < probe
    assert shapes(xyz, radii)[1].volume.sum() == pytest.approx((~covered).sum() * step**3, rel=5e-3)


def test_pieces_do_not_depend_on_place_and_order():
    xyz, radii = heap(60, 4, 14.0)
    found, order = shapes(xyz, radii)[1], np.random.default_rng(1).permutation(60)
    moved = shapes(xyz[order] + np.array([100.0, -50.0, 7.0]), radii[order])[1]
    assert moved.chi.tolist() == found.chi.tolist()
    assert moved.volume == pytest.approx(found.volume, abs=1e-5)
