"""Dots that no molecular surface in Å has are refused or told; surfaces and subsets of all densities pass."""

import logging

import numpy as np
import pytest

from conftest import ROOT
from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.formats.npz import read_npz, write_npz
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.surface import Surface, nearest_of, refuse_implausible


@pytest.fixture(scope="module")
def dots():
    molecule = read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-222")
    return molecular_surface(molecule.xyz[0], radii(molecule))


def judged(caplog, points, normals):
    """What is said of dots; '' where nothing is."""
    caplog.clear()
    with caplog.at_level(logging.WARNING, "sparsurf"):
        refuse_implausible(points, normals, "a.csv", "dot {}".format)
    return caplog.text


def test_surfaces_and_their_subsets_pass(dots, caplog):
    rng = np.random.default_rng(2)
    for share in (1, 0.3, 0.05, 0.02):
        k = rng.choice(len(dots), int(share * len(dots)), replace=False)
        assert judged(caplog, dots.points[k], dots.normals[k]) == ""
    turned = dots.points[:, [2, 0, 1]] + 3000, dots.normals[:, [2, 0, 1]]
    assert judged(caplog, *turned) == ""


@pytest.mark.parametrize("density", [1.0, 100.0])
def test_the_unit_is_found_at_every_density(density, caplog):
    ball = molecular_surface([[0, 0, 0], [1.5, 0, 0], [0, 4, 0]], [1.9, 1.5, 1.4], density=density)
    assert judged(caplog, ball.points, ball.normals) == ""
    with pytest.raises(InputError, match=r"a\.csv: dots lie .* lengths seem to be nm, give Å"):
        judged(caplog, ball.points / 10, ball.normals)
    assert "are lengths in Å" in judged(caplog, ball.points * 10, ball.normals)


def test_directions_are_judged(dots, caplog):
    rng = np.random.default_rng(3)
    random = rng.normal(size=dots.normals.shape)
    random /= np.linalg.norm(random, axis=1)[:, None]
    sign = np.where(rng.random(len(dots)) < 0.25, -1.0, 1.0)[:, None]
    for normals in (random, sign * dots.normals):
        with pytest.raises(InputError, match="normals that oppose each other: give outward normals"):
            judged(caplog, dots.points, normals)
    assert "normals point inwards" in judged(caplog, dots.points, -dots.normals)


def test_a_surface_that_does_not_close_is_told_once(dots, caplog, tmp_path):
    """The first half of the dots, which are in the order of the atoms; a study's own file repeats nothing."""
    half = slice(len(dots) // 2)
    assert "do not close around a molecule" in judged(caplog, dots.points[half], dots.normals[half])
    write_npz(tmp_path / "a.npz", dots.take(half))
    caplog.clear()
    assert len(read_npz(tmp_path / "a.npz")) == len(dots) // 2 and not caplog.text
    assert len(read_surface(tmp_path / "a.npz")) == len(dots) // 2 and "do not close" in caplog.text


def test_a_dot_far_from_the_others_is_refused(dots, caplog):
    points = dots.points.copy()
    points[7, 1] -= 5000
    with pytest.raises(InputError, match=r"a\.csv: dot 7 lies 49\d\d Å from all other dots"):
        judged(caplog, points, dots.normals)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("area", -0.1, "dot 6 has a negative area"),
        ("area", np.nan, "dot 6 has an area that is NaN"),
        ("area", 1e4, "dot 6 has an area above"),
        ("area", np.inf, "dot 6 has an area above"),
        ("kind", 3, "dot 6 has a kind other than"),
        ("kind", -2, "dot 6 has a kind other than"),
        ("kind", 256, "dot 6 has a kind other than"),  # which is 0 in a byte
        ("kind", 0.5, "dot 6 has a kind other than"),
        ("atom", -5, "dot 6 has an atom that is no index"),
        ("atom", 1.5, "dot 6 has an atom that is no index"),
        ("points", -3e6, "dot 6 has a coordinate beyond"),
    ],
)
def test_values_that_cannot_be_are_refused(dots, tmp_path, name, value, words):
    columns = {key: getattr(dots, key).copy() for key in ("points", "normals", "area", "kind", "atom")}
    columns[name] = columns[name].astype(type(value))
    columns[name][5] = value
    np.savez(tmp_path / "a.npz", **columns)
    with pytest.raises(InputError, match=words):
        read_surface(tmp_path / "a.npz")
    if words != "dot 6 has an area above" or value > 1e5:
        with pytest.raises(InputError, match=words):
            Surface(**columns)


def test_areas_that_nobody_knows_are_known_by_none(dots, tmp_path):
    write_npz(tmp_path / "a.npz", Surface(dots.points, dots.normals))
    assert np.isnan(read_surface(tmp_path / "a.npz").area).all()


def test_nearest_dots_are_those_of_a_search_over_all(dots):
    points, some = dots.points[:300], np.array([0, 5, 299])
    every = np.linalg.norm(points[:, None] - points, axis=2) + np.diag(np.full(300, np.inf))
    distance, other = nearest_of(points, some)
    assert other.tolist() == every[some].argmin(axis=1).tolist()
    np.testing.assert_allclose(distance, every[some].min(axis=1), rtol=1e-12)
