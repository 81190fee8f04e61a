"""The analytic surface against formulas, brute force, itself moved, and the program DMS."""

import logging
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

from sparsurf.surfaces.dot_placement import place_dots, roll_probe, sphere_template
from sparsurf.surfaces.molecular_surface import DENSITY, molecular_surface
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE

PROBE = 1.4
DMS_RADII = {"H": 1.20, "C": 1.90, "N": 1.50, "O": 1.40, "S": 1.85}
REFERENCES = {"A1": "tdp43/A1", "1a1u": "1a1u/1a1u_A"}
CELL = 1 / 5.5  # Å^2, what one dot stands for


def read_pdb(path):
    """Centres and DMS radii of a clean PDB file."""
    lines = [line for line in path.read_text().splitlines() if line.startswith("ATOM")]
    xyz = [[float(line[30:38]), float(line[38:46]), float(line[46:54])] for line in lines]
    return np.array(xyz), np.array([DMS_RADII[line[12:16].strip().lstrip("0123456789")[0]] for line in lines])


@pytest.fixture(scope="module", params=REFERENCES)
def reference(request, shared):
    """Atoms, DMS's surface, ours in both modes."""
    stem = shared / "data" / REFERENCES[request.param]
    xyz, radii = read_pdb(stem.with_suffix(".pdb"))
    dms = read_surface(stem.with_suffix(".dms.gz"))
    return xyz, radii, dms, molecular_surface(xyz, radii), molecular_surface(xyz, radii, reentrant="dms")


# ---- brute force


def not_covered(places, xyz, reach, tolerance):
    """Which places lie in no sphere, by trying all spheres."""
    free = np.ones(len(places), bool)
    for begin in range(0, len(places), 4000):
        some = slice(begin, begin + 4000)
        free[some] = (cdist(places[some], xyz) >= reach - tolerance).all(axis=1)
    return free


def nearer_centre(place, xyz, reach, within):
    """Is there an accessible probe centre nearer to the place than `within`?

    The nearest one is the place itself, the point straight outwards on a sphere, the nearest point of the circle
    of two spheres, or a point of three: all are tried.
    """
    distance = np.linalg.norm(xyz - place, axis=1)
    close = distance < reach + within
    x, r, d = xyz[close] - place, reach[close], distance[close]
    if (d >= r).all():
        return True
    on = np.abs(d - r) < within
    x_on, r_on, d_on = x[on], r[on], d[on]
    candidates = [x_on * (1 - r_on / d_on)[:, None]]
    i, j = np.triu_indices(len(x_on), 1)
    u = x_on[j] - x_on[i]
    length = np.linalg.norm(u, axis=1)
    height = (length**2 + r_on[i] ** 2 - r_on[j] ** 2) / (2 * length)
    r2 = r_on[i] ** 2 - height**2
    i, u, height, r2, length = (v[r2 > 0] for v in (i, u, height, r2, length))
    u = u / length[:, None]
    middle, radius = x_on[i] + height[:, None] * u, np.sqrt(r2)
    inwards = -middle + (middle * u).sum(axis=1)[:, None] * u
    e1 = inwards / np.linalg.norm(inwards, axis=1)[:, None]
    nearest = middle + radius[:, None] * e1
    candidates.append(nearest)
    reachable = np.linalg.norm(nearest, axis=1) < within
    middle, radius, e1, u = middle[reachable], radius[reachable], e1[reachable], u[reachable]
    e2 = np.cross(u, e1)
    w = x_on[None] - middle[:, None]
    p1, p2 = np.einsum("ckx,cx->ck", w, e1), np.einsum("ckx,cx->ck", w, e2)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = (radius[:, None] ** 2 + (w**2).sum(axis=2) - r_on**2) / (
            2 * radius[:, None] * np.hypot(p1, p2)
        )
        angle, half = np.arctan2(p2, p1), np.arccos(cosine)
    for phi in (angle - half, angle + half):
        c, k = np.nonzero(np.isfinite(phi))
        f = phi[c, k][:, None]
        candidates.append(middle[c] + radius[c, None] * (np.cos(f) * e1[c] + np.sin(f) * e2[c]))
    candidates = np.concatenate(candidates)
    candidates = candidates[np.linalg.norm(candidates, axis=1) < within]
    return len(candidates) > 0 and not_covered(candidates, x, r, 1e-9).any()


def certified(surface, xyz, radii):
    """Dots that a theorem puts on the surface, once the probe that touches them is free.

    For a probe centre c that touches atoms X_k, an accessible centre p has |p - X_k| >= |c - X_k|, hence
    |p - a| >= |c - a| for every a among the convex combinations of the X_k. A dot between c and such an a has
    no accessible centre nearer than c.
    """
    reach = radii + PROBE
    centres = surface.points + PROBE * surface.normals
    near = cKDTree(xyz).query_ball_point(centres, reach.max() + 1e-6)
    out = np.zeros(len(surface), bool)
    for n, atoms in enumerate(near):
        atoms = np.array(atoms)
        to_atoms = xyz[atoms] - centres[n]
        touched = np.abs(np.linalg.norm(to_atoms, axis=1) - reach[atoms]) < 1e-6
        weights, rest = nnls(to_atoms[touched].T, surface.points[n] - centres[n])
        out[n] = rest < 1e-6 and weights.sum() <= 1 + 1e-9
    return out


def assert_on_surface(surface, xyz, radii, most=None):
    """Every dot is within 1e-6 Å of the surface: a free probe touches it, and none comes nearer."""
    reach = radii + PROBE
    centres = surface.points + PROBE * surface.normals
    assert not_covered(centres, xyz, reach, 1e-6).all()
    assert np.abs(np.linalg.norm(surface.normals, axis=1) - 1).max() < 1e-9
    rest = np.flatnonzero(~certified(surface, xyz, radii))
    assert set(surface.kind[rest]) <= {CONCAVE}
    for n in rest[:most]:
        assert not nearer_centre(surface.points[n], xyz, reach, PROBE - 1e-6)


def test_every_dot_lies_on_the_surface(reference):
    xyz, radii, _, exact, _ = reference
    assert_on_surface(exact, xyz, radii)


def test_what_is_removed_from_a_random_heap_lies_inside_and_nothing_else():
    rng = np.random.default_rng(2)
    xyz, radii = rng.uniform(-1, 1, (30, 3)) * [6, 6, 2], rng.choice([1.2, 1.5, 1.9], 30)
    exact, dms = (molecular_surface(xyz, radii, density=6, reentrant=mode) for mode in ("exact", "dms"))
    every = np.flatnonzero(dms.kind == CONCAVE)
    kept = cKDTree(exact.points[exact.kind == CONCAVE]).query(dms.points[every])[0] < 1e-9
    # 1e-6 Å: far above the shift of the atoms by 1e-8 Å
    inside = [nearer_centre(dms.points[n], xyz, radii + PROBE, PROBE - 1e-6) for n in every]
    assert np.array_equal(kept, ~np.array(inside))
    assert 20 < np.sum(inside) < 0.5 * len(every)


# ---- formulas


def test_one_sphere():
    surface = molecular_surface([[1.0, 2.0, 3.0]], [1.9])
    assert (surface.kind == CONTACT).all()
    assert surface.area.sum() == pytest.approx(4 * math.pi * 1.9**2, rel=1e-12)
    # 1e-8 Å: the shift that takes atoms out of special position.
    np.testing.assert_allclose(surface.points, [1.0, 2.0, 3.0] + 1.9 * surface.normals, atol=2e-8)


def two_spheres(r1, r2, d):
    """Contact and saddle area of two spheres at distance d."""
    big, small = max(r1, r2) + PROBE, min(r1, r2) + PROBE
    if d <= big - small:
        return 4 * math.pi * max(r1, r2) ** 2, 0.0
    if d >= big + small:
        return 4 * math.pi * (r1**2 + r2**2), 0.0
    contact, thetas, reach = 0.0, [], (r1 + PROBE, r2 + PROBE)
    for radius, own, other in ((r1, *reach), (r2, *reach[::-1])):
        height = (d * d + own**2 - other**2) / (2 * d)
        contact += 2 * math.pi * radius**2 * (1 + height / own)
        thetas.append(math.asin(height / own))
    rho = math.sqrt(reach[0] ** 2 - ((d * d + reach[0] ** 2 - reach[1] ** 2) / (2 * d)) ** 2)
    low, high = -thetas[0], thetas[1]
    cusp = math.acos(rho / PROBE) if rho < PROBE else 0.0
    pieces = [(low, high)] if cusp == 0 else [(low, min(high, -cusp)), (max(low, cusp), high)]
    band = sum(rho * (b - a) - PROBE * (math.sin(b) - math.sin(a)) for a, b in pieces if b > a)
    return contact, 2 * math.pi * PROBE * band


@pytest.mark.parametrize("radii", [(1.9, 1.2), (1.2, 1.9), (1.5, 1.5)])
@pytest.mark.parametrize("d", [0.2, 0.69, 0.71, 1.0, 2.0, 3.1, 4.0, 4.5, 5.0, 5.5, 5.79, 5.81, 6.0, 30.0])
def test_two_spheres(radii, d):
    axis = np.array([0.36, 0.48, 0.8])
    surface = molecular_surface([[0, 0, 0], d * axis], radii, density=100)
    contact, saddle = two_spheres(*radii, d)
    # 1e-6: the shift of the atoms by 1e-8 Å moves arcs near tangency most. Saddles: up to half a dot.
    assert surface.area[surface.kind == CONTACT].sum() == pytest.approx(contact, rel=1e-6)
    assert surface.area[surface.kind == SADDLE].sum() == pytest.approx(saddle, abs=0.005)
    assert_on_surface(surface, np.array([[0, 0, 0], d * axis]), np.array(radii))
    for atom, radius in enumerate(radii):  # each dot of an atom has its share of what the probe touches of it
        own = surface.area[(surface.kind == CONTACT) & (surface.atom == atom)]
        height = (d * d + (radius + PROBE) ** 2 - (sum(radii) - radius + PROBE) ** 2) / (2 * d)
        cap = 1 + np.clip(height / (radius + PROBE), -1, 1) if d > abs(radii[0] - radii[1]) else 2 * len(own)
        assert own.sum() == pytest.approx(2 * math.pi * radius**2 * min(cap, 2), rel=1e-6)
        assert len(own) == 0 or np.ptp(own) < 1e-9
    dms = molecular_surface([[0, 0, 0], d * axis], radii, density=100, reentrant="dms")
    assert np.array_equal(dms.points[dms.kind == CONTACT], surface.points[surface.kind == CONTACT])


@pytest.mark.parametrize("mode", ["exact", "dms"])
def test_saddle_dots_belong_to_the_nearer_of_two_equal_atoms(mode):
    xyz = np.array([[0, 0, 0], [3.0, 0, 0]])
    surface = molecular_surface(xyz, [1.5, 1.5], density=6.0, reentrant=mode)
    saddle = surface.kind == SADDLE
    # an even number of strips: none in the middle
    assert len(np.unique(surface.points[saddle, 0].round(3))) == 4
    assert np.array_equal(surface.atom[saddle], cdist(surface.points[saddle], xyz).argmin(axis=1))
    if mode == "exact":  # each strip has its own area, by the angle from the plane between the atoms
        end, height = math.asin(1.5 / 2.9), math.sqrt(2.9**2 - 1.5**2)
        theta = np.linspace(-end, end, 5)
        strips = 2 * math.pi * PROBE * (height * np.diff(theta) - PROBE * np.diff(np.sin(theta)))
        x = surface.points[saddle, 0]
        strip = np.searchsorted(np.unique(x.round(3)), x.round(3))
        assert np.bincount(strip, surface.area[saddle]) == pytest.approx(strips, rel=1e-5)


@pytest.mark.parametrize("pairs", [3, 4, 11, 12, 19])
def test_strips_too_narrow_for_a_dot_share_dots(pairs):
    """Pairs of atoms that nearly do not touch, far from each other: their dots together stand for their area."""
    ends = np.array([[0, 0, 0], [5.79, 0, 0]])
    xyz = (ends + [[[30.0 * k, k, 0]] for k in range(pairs)]).reshape(-1, 3)
    area, cell = two_spheres(1.5, 1.5, 5.79)[1], 2 * CELL
    surface = molecular_surface(xyz, np.full(2 * pairs, 1.5), density=DENSITY / 2)
    of_saddles = surface.area[surface.kind == SADDLE]
    assert len(of_saddles) == round(pairs * area / cell)
    assert of_saddles == pytest.approx(cell)


def solid_angle(directions):
    """Of the cone over a convex polygon given by its corners in order (van Oosterom and Strackee, 1983)."""
    total, (a, *others) = 0.0, directions / np.linalg.norm(directions, axis=1)[:, None]
    for b, c in pairwise(others):
        total += 2 * math.atan2(abs(a @ np.cross(b, c)), 1 + a @ b + b @ c + c @ a)
    return total


@pytest.mark.parametrize(("corners", "side"), [(3, 3.0), (4, 2.6), (5, 2.2), (6, 1.9), (8, 1.5)])
def test_probe_on_a_regular_polygon(corners, side):
    """A probe above and one below touch all corners at once: one spherical polygon each."""
    turn = 2 * math.pi * np.arange(corners) / corners
    ring = side / (2 * math.sin(math.pi / corners))
    xyz = ring * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    radii = np.full(corners, 1.5)
    height = math.sqrt((1.5 + PROBE) ** 2 - ring**2)
    assert height > PROBE  # else the two probes would cut each other
    surface = molecular_surface(xyz, radii, density=100)
    area = 2 * PROBE**2 * solid_angle(xyz - [0, 0, height])
    assert surface.area[surface.kind == CONCAVE].sum() == pytest.approx(area, rel=1e-6)
    assert (surface.kind == CONCAVE).sum() == pytest.approx(area * 100, rel=0.1)


def test_two_probes_that_cut_each_other_keep_what_lies_on_their_own_side():
    """Above and below a triangle, so low that they reach through it."""
    turn, ring = 2 * math.pi * np.arange(3) / 3, 2.65
    xyz = ring * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    height = math.sqrt((1.5 + PROBE) ** 2 - ring**2)
    assert height < PROBE
    units = sphere_template(1.0, 0.005)
    to_atoms = xyz - [0, 0, height]
    # faces of the cone over the triangle, turned inwards: that is, down
    faces = np.cross(to_atoms, np.roll(to_atoms, -1, axis=0))
    faces *= -np.sign(faces[:, 2:])
    inside = (units @ faces.T > 0).all(axis=1)
    left = (inside & (height + PROBE * units[:, 2] > 0)).mean()
    assert left < 0.95 * inside.mean()
    surface = molecular_surface(xyz, np.full(3, 1.5), density=1000)
    concave = surface.kind == CONCAVE
    assert surface.area[concave].sum() == pytest.approx(8 * math.pi * PROBE**2 * left, rel=0.01)


def lattice(n, spacing):
    return spacing * np.stack(np.meshgrid(*[np.arange(n)] * 3), axis=-1).reshape(-1, 3).astype(float)


@pytest.mark.parametrize("spacing", [1.5, 3.0, 4.0])
def test_lattice_equals_the_same_out_of_order(spacing):
    """Probes touch four or eight atoms at once; moving all atoms by 0.001 Å must not change the surface."""
    xyz, radii = lattice(3, spacing), np.full(27, 1.5)
    moved = xyz + np.random.default_rng(0).uniform(-1e-3, 1e-3, xyz.shape)
    surface, other = molecular_surface(xyz, radii), molecular_surface(moved, radii)
    for kind in (CONTACT, SADDLE, CONCAVE):
        # A movement of 0.001 Å changes no area by more; what is left of self-cut triangles is counted in dots.
        area = other.area[other.kind == kind].sum()
        assert surface.area[surface.kind == kind].sum() == pytest.approx(area, rel=0.02)
    assert_on_surface(surface, xyz, radii, most=100)


@pytest.mark.parametrize("n", [3, 7])
def test_collinear_atoms(n):
    xyz, radii = np.arange(n)[:, None] * np.array([0.0, 1.5, 0.0]), np.full(n, 1.7)
    surface = molecular_surface(xyz, radii)
    assert_on_surface(surface, xyz, radii)
    # A rod: saddles between neighbours only, two half spheres at the ends.
    contact, saddle = two_spheres(1.7, 1.7, 1.5)
    assert surface.area[surface.kind == SADDLE].sum() == pytest.approx((n - 1) * saddle, abs=CELL)
    assert CONCAVE not in surface.kind
    expected = contact + (n - 2) * (contact - 4 * math.pi * 1.7**2)
    assert surface.area[surface.kind == CONTACT].sum() == pytest.approx(expected, rel=1e-6)


def test_a_band_too_narrow_for_a_dot_still_counts():
    """Three atoms in a rod across whose middle one no ring of dots runs: the others stand for its area."""
    xyz = 0.1 * np.arange(3)[:, None] * [0, 0, 1.0]
    surface = molecular_surface(xyz, np.full(3, 1.7))
    contact = two_spheres(1.7, 1.7, 0.1)[0]
    of_contact = surface.kind == CONTACT
    assert set(surface.atom[of_contact]) == {0, 2}
    assert surface.area[of_contact].sum() == pytest.approx(2 * contact - 4 * math.pi * 1.7**2, rel=1e-6)


def test_spheres_without_arcs_are_summarised_by_one_dot():
    """Buried ones, ones alone, and one that holds another; all dots of all spheres give the same."""
    rng = np.random.default_rng(5)
    heap, alone = rng.uniform(0, 9, (150, 3)), np.array([[30.0, 0, 0], [60, 0, 0], [60.1, 0, 0]])
    xyz, radii = np.concatenate([heap, alone]), np.append(rng.uniform(1.2, 2, 151), [3.0, 1.0])
    rolled = roll_probe(xyz, radii, PROBE, True)
    quick, slow = (
        place_dots(rolled._replace(whole=whole), 5.5) for whole in (rolled.whole, np.zeros(len(xyz), bool))
    )
    assert np.array_equal(quick.points, slow.points)
    dots = np.bincount(quick.atom[quick.kind == CONTACT], minlength=len(xyz))
    whole = rolled.whole[np.argsort(rolled.by_position)]
    assert (whole & (dots == 0)).sum() > 20 and (whole & (dots > 0)).sum() == 2
    assert not roll_probe(xyz, radii, PROBE, False).whole.any()


def components(points, link=0.7):
    """Label of the connected component of each dot."""
    pairs = cKDTree(points).query_pairs(link, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs), bool), pairs.T), shape=(len(points),) * 2)
    return connected_components(graph, directed=False)[1]


def test_template_has_the_rings_of_dms():
    """Dots on the rings of the spheres in DMS's files; the south pole has none."""
    units = sphere_template(1.4, 0.4582)
    z, counts = np.unique(np.round(units[:, 2], 9), return_counts=True)
    assert counts[::-1].tolist() == [1, 5, 10, 15, 17, 19, 19, 17, 15, 10, 5]
    np.testing.assert_allclose(np.sort(np.arccos(z)), math.pi * np.arange(11) / 11, atol=1e-8)


# ---- invariance


def test_duplicates_are_removed_with_a_warning(caplog):
    xyz, radii = np.array([[0, 0, 0], [2.0, 0, 0], [2.0, 0, 0], [0, 0, 0]]), np.array([1.7, 1.5, 1.5, 1.9])
    with caplog.at_level(logging.WARNING, "sparsurf"):
        surface = molecular_surface(xyz, radii)
    assert "left out (2)" in caplog.text and "number 1" in caplog.text
    assert set(surface.atom) == {1, 3}
    assert surface.area.sum() == pytest.approx(
        molecular_surface(xyz[[3, 1]], radii[[3, 1]]).area.sum(), rel=0.01
    )


def test_atoms_that_nearly_coincide_or_lie_far_apart(caplog):
    surface = molecular_surface([[0, 0, 0], [0.04, 0, 0]], [1.7, 1.7])
    assert set(surface.atom) == {0, 1} and not caplog.records
    # The box between them costs nothing.
    xyz, radii = np.array([[0, 0, 0], [1.5, 0, 0]]), np.array([1.7, 1.5])
    both = molecular_surface(np.vstack([xyz, xyz + 9e5]), np.tile(radii, 2))
    assert len(both) == pytest.approx(2 * len(molecular_surface(xyz, radii)), abs=4)


@pytest.mark.parametrize("shift", [[10.0, -20.0, 30.5], [1234.567, 0.001, -777.7]])
def test_translation_changes_nothing(reference, shift):
    """Places are taken relative to the first atom on a grid of 1e-9 Å, so that all else is equal to the bit."""
    xyz, radii, _, exact, _ = reference
    moved = molecular_surface(xyz + shift, radii)
    for name in ("normals", "area", "kind", "atom"):
        np.testing.assert_array_equal(getattr(moved, name), getattr(exact, name))
    np.testing.assert_allclose(moved.points - shift, exact.points, rtol=0, atol=1e-11)


def test_rotation_keeps_the_area(reference):
    """Exact but for self-cut triangles, of which what is left is counted in dots, and half a saddle dot."""
    xyz, radii, _, exact, _ = reference
    area = [exact.area[exact.kind == kind].sum() for kind in (CONTACT, SADDLE, CONCAVE)]
    for rotation in Rotation.random(4, rng=np.random.default_rng(3)):
        turned = molecular_surface(rotation.apply(xyz), radii)
        for kind, tolerance in ((CONTACT, 1e-6), (SADDLE, 2e-4), (CONCAVE, 1e-2)):
            assert turned.area[turned.kind == kind].sum() == pytest.approx(area[kind], rel=tolerance)
        assert turned.area.sum() == pytest.approx(exact.area.sum(), rel=3e-3)


def test_order_of_atoms_does_not_matter(reference):
    xyz, radii, _, exact, _ = reference
    shuffled = np.random.default_rng(5).permutation(len(xyz))
    surface = molecular_surface(xyz[shuffled], radii[shuffled])
    assert len(surface) == pytest.approx(len(exact), abs=2)
    assert np.quantile(cKDTree(exact.points).query(surface.points)[0], 0.999) < 1e-6


spheres = st.lists(
    st.tuples(*[st.floats(-4, 4)] * 3, st.sampled_from([0.64, 1.2, 1.4, 1.5, 1.9, 2.15])),
    min_size=1,
    max_size=12,
)


@settings(max_examples=40)
@given(spheres)
def test_any_few_spheres(atoms):
    table = np.round(np.array(atoms), 2)
    _, first = np.unique(table[:, :3], axis=0, return_index=True)
    xyz, radii = table[first, :3], table[first, 3]
    surface = molecular_surface(xyz, radii)
    assert_on_surface(surface, xyz, radii, most=10)
    assert (np.linalg.norm(surface.points[:, None] - xyz, axis=2) >= radii - 1e-6).all()
    assert len(molecular_surface(xyz, radii, reentrant="dms")) > 0


# ---- the program DMS


def angles(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)))


def both_ways(a, b):
    """Distances and angles of the normals from each dot of a to the nearest of b and back."""
    there, i = cKDTree(b.points).query(a.points)
    back, j = cKDTree(a.points).query(b.points)
    turned = [angles(a.normals, b.normals[i]), angles(b.normals, a.normals[j])]
    return np.concatenate([there, back]), np.concatenate(turned)


def gaps(surface):
    """Distance of each dot to its nearest neighbour."""
    return cKDTree(surface.points).query(surface.points, k=2)[0][:, 1]


def largest_share(surface):
    return np.bincount(components(surface.points, 0.5)).max() / len(surface)


def test_exact_surface_beside_dms(reference):
    _, _, dms, exact, _ = reference
    contact = [s.area[s.kind == CONTACT].sum() for s in (exact, dms)]
    assert contact[0] == pytest.approx(contact[1], rel=0.01)
    assert exact.area.sum() == pytest.approx(dms.area.sum(), rel=0.01)
    assert len(exact) == pytest.approx(len(dms), rel=0.02)
    assert np.median(gaps(exact)) == pytest.approx(np.median(gaps(dms)), abs=0.01)
    assert (gaps(exact) > 0.5).mean() <= 0.003
    distance, angle = both_ways(exact, dms)
    assert np.median(distance) <= 0.20
    assert np.quantile(distance, 0.95) <= 0.31
    assert np.median(angle) <= 8
    assert np.quantile(angle, 0.95) <= 16
    assert largest_share(exact) == pytest.approx(largest_share(dms), abs=0.005)


def test_dms_mode_gives_the_dots_of_dms(reference):
    """The same dots to the 0.0005 Å of the file, but for 2 of 20047 on A1 (an arc that DMS loses)."""
    _, _, dms, _, ours = reference
    assert abs(len(ours) - len(dms)) <= 2
    distance, angle = both_ways(ours, dms)
    assert (distance > 0.001).sum() <= 2
    assert np.quantile(angle, 0.999) < 0.1
    assert ours.area[ours.kind == CONCAVE].sum() == pytest.approx(
        dms.area[dms.kind == CONCAVE].sum(), rel=0.015
    )
    assert ours.area.sum() == pytest.approx(dms.area.sum(), rel=0.0015)
    assert (gaps(ours) < 0.1).mean() == pytest.approx((gaps(dms) < 0.1).mean(), abs=0.005)


def test_dms_mode_keeps_the_order_of_dms(reference):
    """By atom, concave before saddle before contact; DMS gives 1.6 % of the saddle dots to the other atom."""
    _, _, dms, _, ours = reference
    distance, same = cKDTree(dms.points).query(ours.points)
    same = same[distance < 0.001]
    for kind in (CONTACT, SADDLE, CONCAVE):
        mine = dms.kind[same] == kind
        owners = ours.atom[distance < 0.001][mine] == dms.atom[same[mine]]
        assert owners.mean() > (0.98 if kind == SADDLE else 0.9999)
        assert (np.diff(same[mine][owners]) > 0).all()
