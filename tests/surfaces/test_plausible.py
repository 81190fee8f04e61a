"""Dots that no molecular surface in Å has are refused or told; surfaces and subsets of all densities pass."""

import logging

import numpy as np
import pytest

from conftest import ROOT
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.formats.npz import read_npz, write_npz
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.surface import (
    Surface,
    check_plausibility,
    check_values,
    nearest_neighbours,
    surface_of_columns,
)


@pytest.fixture(scope="module")
def dots():
    molecule = read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-222")
    return molecular_surface(molecule.xyz[0], radii(molecule))


def judged(caplog, points, normals):
    """What is said of dots; '' where nothing is."""
    caplog.clear()
    with caplog.at_level(logging.WARNING, "sparsurf"):
        check_plausibility(points, normals, "a.csv", "dot {}".format)
    return caplog.text


def ball(n, radius, without=0):
    """Dots spread evenly over a sphere but for the first ones, which lie around a pole, and their normals."""
    k = np.arange(without, n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    unit = np.column_stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z])
    return radius * unit, unit


@pytest.mark.parametrize(
    ("dots", "said"),
    [
        (ball(900, 0.5), ""),
        (ball(900, 9.0), ""),
        (ball(900, 12.0), "dots lie on curves of 12 Å; are lengths in Å?"),
        (ball(900, 90.0), "dots lie on curves of 90 Å; are lengths in Å?"),
        (ball(900, 104.0), ""),
        (ball(49, 0.2), ""),
        (ball(1200, 5.0, 44), "the dots do not close around a molecule (4 % of the normals do not cancel)"),
        (ball(1200, 5.0, 30), ""),
        (ball(2002, 5.0, 1001), "do not close"),
        (ball(2000, 5.0, 1000), ""),
        (ball(1150, 9.5, 115), ""),
        (np.add(ball(1200, 5.0, 30), [[[0, 0, 3000]], [[0, 0, 0]]]), ""),
    ],
)  # fmt: skip
def test_what_is_said_of_a_ball(dots, said, caplog):
    text = judged(caplog, *dots)
    assert said in text if said else text == ""
    caplog.clear()
    surface_of_columns(dict(zip(("points", "normals"), dots, strict=True)), "a.csv")
    assert caplog.text == text


@pytest.mark.parametrize("dots", [ball(900, 0.35), ball(50, 0.2)])
def test_a_ball_of_the_size_of_no_atom_is_refused(dots, caplog):
    with pytest.raises(InputError, match="lengths seem to be nm"):
        judged(caplog, *dots)


def test_normals_of_dots_far_apart_may_oppose_each_other(caplog):
    for n, refused in ((170, False), (400, True)):
        points, normals = ball(n, 9.0)
        normals = normals * np.where(np.random.default_rng(0).random(n) < 0.5, -1.0, 1.0)[:, None]
        if not refused:
            assert judged(caplog, points, normals) == ""
            continue
        with pytest.raises(InputError, match="oppose each other"):
            judged(caplog, points, normals)


@pytest.mark.parametrize("length", [1.0, 1.001])
def test_a_plane_has_no_radius(length, caplog):
    points = np.column_stack([*np.divmod(np.arange(100.0), 10), np.zeros(100)])
    assert judged(caplog, points, np.tile([0, 0, length], (100, 1))) == ""


@pytest.mark.parametrize(
    ("n", "area", "said"),
    [
        (50, 1000.0, None),
        (50, 1000.5, "above 1e\\+03 Å"),
        (49, 1.2e5, None),
        (49, 1.4e5, "above 1.3e\\+05 Å"),
    ],
)
def test_the_largest_area_follows_from_those_of_fifty_dots(n, area, said):
    given = np.zeros((n, 3)), np.append(np.ones(n - 1), area), None, None, "a.csv", "dot {}".format
    if said is None:
        check_values(*given)
        return
    with pytest.raises(InputError, match=rf"dot {n - 1} has an area {said}"):
        check_values(*given)


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


def test_a_surface_that_does_not_close_is_reported_once(dots, caplog, tmp_path):
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
        ("area", -0.1, "dot 6 has a negative area: repair or remove it"),
        ("area", np.nan, "dot 6 has an area that is NaN"),
        ("area", 1e4, "dot 6 has an area above"),
        ("area", np.inf, "dot 6 has an area above"),
        ("kind", 3, "dot 6 has a kind other than"),
        ("kind", -2, "dot 6 has a kind other than"),
        ("kind", 256, "dot 6 has a kind other than"),  # which is 0 in a byte
        ("kind", 0.5, "dot 6 has a kind other than"),
        ("atom", -2, "dot 6 has an atom that is no index"),
        ("atom", 1.5, "dot 6 has an atom that is no index"),
        (
            "points",
            -2.1e6,
            r"dot 6 has a coordinate beyond 2e\+06 Å \(.+, -2.1e\+06, .+\): repair or remove it",
        ),
    ],
)
def test_values_that_cannot_be_are_refused(dots, tmp_path, name, value, words):
    columns = {key: getattr(dots, key).copy() for key in ("points", "normals", "area", "kind", "atom")}
    columns[name] = columns[name].astype(type(value))
    columns[name][(5, 1) if name == "points" else 5] = value
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
    distance, other = nearest_neighbours(points, some)
    assert other.tolist() == every[some].argmin(axis=1).tolist()
    np.testing.assert_allclose(distance, every[some].min(axis=1), rtol=1e-12)
