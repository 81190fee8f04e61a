"""Atoms inferred from few dots, and the surface rebuilt from them: a real molecule whose atoms and whole surface are known."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT, ball
from sparsurf.errors import InputError
from sparsurf.patches.index import build_grid
from sparsurf.recovery.errors import distance_to_surface
from sparsurf.recovery.interpolated_surface import interpolate_surface
from sparsurf.recovery.spheres.atoms import infer
from sparsurf.recovery.spheres.explanations import (
    BY_CONTACT,
    BY_SADDLE,
    BY_THREE,
    UNEXPLAINED,
    completed,
    explain,
)
from sparsurf.recovery.spheres.inside import Inside
from sparsurf.recovery.spheres.rebuilding import rebuild
from sparsurf.recovery.spheres.rolled import FARTHEST_FROM_GUIDE, rolled_surface
from sparsurf.recovery.spheres.votes import known_model, vote
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.molecular_surface import molecular_surface, roll_spheres
from sparsurf.surfaces.radii import radii as radii_of

DENSITY = 0.4  # kept dots per Å^2
AS_IN_A_FILE = 4  # decimals


@cache
def protein():
    return sparsurf.read_molecule(ROOT / "data/tdp43/topology.pdb", selection="not element H")


def spread(dots, n):
    """Farthest-point dots."""
    index = build_grid(dots.points, dots.normals)
    return dots.take(farthest_point_sampling(index, n, np.random.default_rng(0)))


@cache
def atoms_and_dots(probe=1.4, table="dms", density=DENSITY, molecule=protein):
    """Centres and radii of the atoms, dots of them as a file holds them, and independent dots of the whole surface."""
    centres, radii = molecule().xyz[0], radii_of(molecule(), table)
    dots = molecular_surface(centres, radii, probe)
    few = spread(dots, round(density * dots.area.sum()))
    fresh = molecular_surface(centres, radii, probe, density=8.0)
    return centres, radii, few.points.round(AS_IN_A_FILE), few.normals.round(AS_IN_A_FILE), fresh


def test_nothing_is_invented_between_dots():
    """Of the surface rebuilt from the dots of a small peptide, 99 % lies near the true one, which the interpolant misses."""
    molecule = sparsurf.read_molecule(ROOT / "data/tdp43/topology.pdb", selection="residue 209 to 216")
    few, fresh = sparsurf.minimal(molecule).surface, sparsurf.surface(molecule, density=8.0)
    for model, least, most in (("spheres", 0.0, 0.1), ("interpolant", 0.4, np.inf)):
        dense = sparsurf.recover(few, reconstruction=model)
        back = distance_to_surface(dense.points, fresh.points, fresh.normals)
        assert least < np.quantile(back, 0.99) < most


def errors(fresh, points, normals):
    distance = distance_to_surface(fresh.points, points, normals)
    return distance.mean(), np.quantile(distance, 0.99), distance.max()


@pytest.mark.parametrize(
    ("probe", "table"), [(1.4, "dms"), (1.2, "dms"), (1.5, "dms"), (1.4, "bondi"), (1.7, "bondi")]
)
def test_probe_radii_and_atoms_follow_from_the_dots(probe, table):
    centres, radii, points, normals, _ = atoms_and_dots(probe, table)
    model = vote(points, normals)
    assert (model.probe, model.table) == (probe, table)
    atoms = infer(points, normals, model)
    distance, nearest = cKDTree(centres).query(atoms.centres)
    sure = atoms.touches >= 8
    assert sure.sum() > 0.4 * len(sure) > 120
    right = (distance < 1e-3) & (atoms.radii == radii[nearest])
    assert right[sure].mean() > 0.99 and right.mean() > 0.85
    assert np.median(distance[right]) < 2e-4


def test_exact_dots_give_exact_atoms():
    """Without the rounding of a file, and with the probe and radii given."""
    centres, radii = protein().xyz[0], radii_of(protein(), "dms")
    dots = molecular_surface(centres, radii)
    few = spread(dots, 2500)
    atoms = sparsurf.infer_atoms(few.points, few.normals)
    distance, nearest = cKDTree(centres).query(atoms.centres)
    sure = atoms.touches >= 8
    assert distance[sure].max() < 1e-3 and np.median(distance) < 1e-6
    assert (atoms.radii == radii[nearest])[sure].all()
    exposed = np.unique(dots.atom)
    found = cKDTree(atoms.centres).query(centres[exposed])[0] < 1e-3
    assert found.mean() > 0.8
    for given in (few, (few.points, few.normals)):
        same = sparsurf.infer_atoms(given)
        assert (
            same.centres.tobytes() == atoms.centres.tobytes() and same.radii.tolist() == atoms.radii.tolist()
        )
    untold = sparsurf.infer_atoms(few.points, few.normals, probe_radius="auto", radii=None)
    assert np.array_equal(untold.centres, atoms.centres)
    listed = sparsurf.infer_atoms(few.points, few.normals, radii=[1.4, 1.5, 1.85, 1.9])
    assert np.array_equal(listed.radii, atoms.radii)


def test_touches_are_those_of_a_plain_count():
    _, _, points, normals, _ = atoms_and_dots()
    model = known_model(points, normals, 1.4, "dms")
    atoms = infer(points, normals, model)
    probes = points + 1.4 * normals
    gap = np.abs(np.linalg.norm(probes[:, None] - atoms.centres, axis=2) - atoms.radii - 1.4)
    touching = (gap < 2 * model.tolerance).sum(axis=0)  # of all dots, several of which may share one probe
    assert (atoms.touches <= touching).all()
    inside = (np.linalg.norm(probes[:, None] - atoms.centres, axis=2) < atoms.radii + 1.4 - 0.01).sum(axis=0)
    assert (inside == 0).all()  # no atom holds a probe


@pytest.mark.parametrize(
    ("density", "most", "most_99"), [(0.25, 0.5, 0.9), (0.4, 0.3, 0.65), (0.6, 0.3, 0.6)]
)
def test_the_rebuilt_surface_errs_less_than_the_interpolant(density, most, most_99):
    _, _, points, normals, fresh = atoms_and_dots(density=density)
    before, found = errors(fresh, *interpolate_surface(points, normals, 20.0)), rebuild(points, normals, 30.0)
    after = errors(fresh, found.points, found.normals)
    assert found.share > 0.75
    assert after[0] < most * before[0] and after[1] < most_99 * before[1] and after[2] < before[2] + 0.05
    assert np.array_equal(found.points[: len(points)], points)  # the dots themselves stay
    assert len(found.points) < 1.4 * 30 * fresh.area.sum()


def wavy(points, normals):
    """A surface that is not made of spheres: dots of a ball of 9 Å with waves, and the normals of these."""
    unit = ball(800)[1]
    height, step = lambda u: 9 + 0.6 * np.sin(3 * u).prod(axis=1), 1e-5
    slope = [(height(unit + step * axis) - height(unit - step * axis)) / (2 * step) for axis in np.eye(3)]
    slope = np.array(slope).T
    slope -= (slope * unit).sum(axis=1, keepdims=True) * unit
    outward = unit - slope / height(unit)[:, None]
    return height(unit)[:, None] * unit, outward / np.linalg.norm(outward, axis=1, keepdims=True)


def gaussian(points, normals):
    """The level of a sum of Gaussian functions at the atoms, on which the dots are moved along its gradient."""
    atoms, place = protein().xyz[0], points.copy()
    tree = cKDTree(atoms)
    for _ in range(12):
        value, gradient = np.zeros(len(place)), np.zeros_like(place)
        distance, near = tree.query(place, k=40)
        weight = np.exp(-2.35 * (distance**2 / 3.2 - 1))
        value = weight.sum(axis=1)
        gradient = -(2 * 2.35 / 3.2) * (weight[:, :, None] * (place[:, None] - atoms[near])).sum(axis=1)
        size = np.linalg.norm(gradient, axis=1, keepdims=True)
        step = np.clip((value - 1)[:, None] / size**2 * gradient, -0.2, 0.2)
        place -= step
    good = np.abs(value - 1) < 1e-3
    return place[good], (-gradient / size)[good]


def noisy(points, normals):
    return points + np.random.default_rng(1).normal(0, 0.02, points.shape), normals


def turned(points, normals):
    out = normals + np.random.default_rng(1).normal(0, np.radians(2), normals.shape)
    return points, out / np.linalg.norm(out, axis=1, keepdims=True)


def few(points, normals):
    return points[:99], normals[:99]


@pytest.mark.parametrize("change", [wavy, gaussian, noisy, turned, few])
def test_dots_that_do_not_lie_on_spheres_are_interpolated_to_the_byte(change):
    _, _, points, normals, _ = atoms_and_dots()
    points, normals = change(points, normals)
    found = rebuild(points, normals)
    assert found.share == 0
    for value, expected in zip(found[:2], interpolate_surface(points, normals), strict=True):
        assert value.tobytes() == expected.tobytes()
    with pytest.raises(InputError, match="reconstruction 'spheres' does"):
        sparsurf.recover(sparsurf.Surface(points, normals), reconstruction="spheres")


def test_bytes_do_not_depend_on_threads():
    _, _, points, normals, _ = atoms_and_dots()
    one, three = (rebuild(points, normals, threads=threads) for threads in (1, 3))
    assert one.points.tobytes() == three.points.tobytes() and one.normals.tobytes() == three.normals.tobytes()
    assert one.atoms.centres.tobytes() == three.atoms.centres.tobytes()


def test_missing_atoms_do_not_leak():
    """Without the dots of one side, no atom is known there; a probe that rolled freely over the others would line the inside."""
    _, _, points, normals, fresh = atoms_and_dots(density=0.6)
    side = points[:, 0] > np.quantile(points[:, 0], 0.35)
    found = rebuild(points[side], normals[side], 20.0)
    assert found.share > 0.5
    true = cKDTree(fresh.points)
    off = true.query(found.points)[0]
    assert off.max() < FARTHEST_FROM_GUIDE + 1.0 and np.quantile(off, 0.99) < 1.5


def rolled_over_exposed_atoms(missing=()):
    """Dots of the whole surface, and those of a probe that rolls over its exposed atoms alone, without the missing ones."""
    centres, radii = protein().xyz[0], radii_of(protein(), "dms")
    dots = molecular_surface(centres, radii)
    exposed = np.setdiff1d(sparsurf.surface_atoms(protein(), plugs=False).atom, missing)
    probes = dots.points + 1.4 * dots.normals
    inside = Inside(dots.points, dots.normals, probes, dots.points - dots.normals)
    lost = np.isin(dots.atom, missing)
    rolled = rolled_surface(
        probes,
        centres[exposed],
        radii[exposed],
        dots.points[lost],
        np.zeros(lost.sum()),
        1.4,
        inside,
        dots.points,
    )
    return dots, exposed, rolled.place(5.35)


def test_exposed_atoms_alone_have_the_surface_of_all():
    """The voids that are left where atoms inside are missing hold no probe of a dot, and trim none of the dots."""
    dots, exposed, rolled = rolled_over_exposed_atoms()
    assert len(rolled.points) == len(dots)
    off, nearest = cKDTree(dots.points).query(rolled.points)
    assert off.max() < 1e-6 and len(np.unique(nearest)) == len(dots)
    assert (dots.kind[nearest] == rolled.kind).all() and (
        dots.atom[nearest] == exposed[rolled.atom]
    ).mean() > 0.98
    assert rolled.area.sum() == pytest.approx(dots.area.sum(), rel=1e-9)


def test_a_missing_atom_is_shut():
    """Without an exposed atom, the probe would roll into the molecule through the gap; its dots keep it out."""
    whole = molecular_surface(protein().xyz[0], radii_of(protein(), "dms"))
    widest = np.bincount(whole.atom, whole.area).argmax()
    dots, _, rolled = rolled_over_exposed_atoms(missing=[widest])
    depth = -exact_distance(rolled.points, roll_spheres(protein().xyz[0], radii_of(protein(), "dms"), 1.4))
    assert depth.max() < 1.0
    assert cKDTree(rolled.points).query(dots.points)[0].max() < 1.5


def test_dots_explain_themselves_by_the_atoms_that_they_lie_on():
    centres, radii = protein().xyz[0], radii_of(protein(), "dms")
    dots = molecular_surface(centres, radii)
    model = known_model(dots.points, dots.normals, 1.4, "dms")
    exposed, probes = np.unique(dots.atom), dots.points + 1.4 * dots.normals
    found = explain(probes, dots.normals, centres[exposed], radii[exposed], model)
    assert (found.kind == np.array([BY_CONTACT, BY_SADDLE, BY_THREE])[dots.kind]).mean() > 0.99
    assert found.used.min() > 0 and (found.kind != UNEXPLAINED).mean() > 0.99
    touched = np.linalg.norm(probes[::97, None] - centres[exposed], axis=2) - radii[exposed] - 1.4
    for dot, gaps in zip(range(0, len(dots), 97), touched, strict=True):
        listed = found.touched[found.start[dot] : found.start[dot + 1]]
        assert sorted(listed) == np.flatnonzero(np.abs(gaps) < 2 * model.tolerance).tolist()
    # An atom that is left out is found again from the dots that it leaves unexplained, and one that explains no dot goes
    lost, few = exposed[found.used.argmax()], spread(dots, 3000)
    wrong = np.append(np.setdiff1d(exposed, lost), 0)
    places, sizes = centres[wrong].copy(), radii[wrong]
    places[-1] = centres.mean(axis=0) + 200.0
    again, _, _ = completed(few.points + 1.4 * few.normals, few.normals, places, sizes, model)
    assert cKDTree(again).query(centres[lost])[0] < 1e-3
    assert np.linalg.norm(again - places[-1], axis=1).min() > 100


def test_winding_numbers_are_those_of_a_plain_sum():
    """Of two balls, one of them with a cavity, in which a point is outside."""
    parts = []
    for radius, side, shift in ((6.0, 1.0, 0.0), (2.0, -1.0, 0.0), (5.0, 1.0, 30.0)):
        normals = ball(round(100 * radius**2))[1]  # equally dense
        parts.append((radius * normals + [shift, 0, 0], side * normals))
    all_points, outward = (np.concatenate(part) for part in zip(*parts, strict=True))
    places = np.array([[4.0, 0, 0], [30.0, 2, 0], [0.0, 0, 0], [15.0, 0, 0], [0.0, 9, 0], [30.0, -40, 7]])
    inside = Inside(all_points, outward, places[3:4], places[:1])
    v = all_points - places[:, None]
    plain = ((v * outward).sum(axis=2) / np.linalg.norm(v, axis=2) ** 3).sum(axis=1)
    expected = (plain - plain[3]) / (plain[0] - plain[3])
    assert np.allclose(inside.winding_numbers(places), expected, atol=0.02)
    assert inside.winding_numbers(places).round().tolist() == [1, 1, 0, 0, 0, 0]


def test_recover_returns_as_many_dots_as_are_asked_for_with_their_areas():
    whole = sparsurf.surface(protein())
    few = sparsurf.minimal(whole)
    for density in (4.0, 12.0):
        dense = sparsurf.recover(few, density=density)
        assert len(dense) == pytest.approx(density * whole.area.sum(), rel=0.03)
        assert np.array_equal(dense.points[: len(few)], few.points)
        assert (dense.area > 0).all() and dense.area.sum() == pytest.approx(whole.area.sum(), rel=0.003)
    off = exact_distance(dense.points, roll_spheres(protein().xyz[0], radii_of(protein(), "dms"), 1.4))
    assert np.quantile(np.abs(off), 0.99) < 0.1  # the bound of `minimal`
    interpolated = sparsurf.recover(few, reconstruction="interpolant")
    assert (
        interpolated.area.sum() == pytest.approx(whole.area.sum(), rel=0.08) and (interpolated.area > 0).all()
    )


def test_the_models_of_recover():
    _, _, points, normals, _ = atoms_and_dots()
    dots = sparsurf.Surface(points, normals)
    auto, spheres, interpolant = (
        sparsurf.recover(dots, reconstruction=m) for m in ("auto", "spheres", "interpolant")
    )
    assert auto.points.tobytes() == spheres.points.tobytes()
    assert (
        interpolant.points.tobytes()
        == interpolate_surface(points, normals)[0].tobytes()
        != auto.points.tobytes()
    )
    with pytest.raises(InputError, match="reconstruction"):
        sparsurf.recover(dots, reconstruction="atoms")


@pytest.mark.parametrize("wrong", [{"radii": "x"}, {"radii": 1.5}, {"radii": []}, {"probe_radius": -1}])
def test_infer_atoms_names_the_wrong_argument(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        sparsurf.infer_atoms(*ball(200, 5), **wrong)


def test_infer_atoms_needs_normals():
    with pytest.raises(InputError, match=r"pair \(points, normals\)"):
        sparsurf.infer_atoms(ball(200, 5)[0])


def test_infer_atoms_says_why_dots_tell_nothing():
    with pytest.raises(InputError, match="99, and 100"):
        sparsurf.infer_atoms(*ball(99, 5), probe_radius="auto")
    with pytest.raises(InputError, match="another kind"):
        sparsurf.infer_atoms(*wavy(None, None), probe_radius="auto", radii="auto")
