"""Regions: caps of a ball against their formula, and connected dots of molecules against a search of our own."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.cli.command import main
from sparsurf.errors import InputError

TDP43 = ROOT / "data" / "tdp43" / "topology.pdb"
RADIUS, HEIGHT = 10.0, 5.0  # Å, of a ball and of a cap of it


@pytest.fixture(scope="module")
def ball():
    """The dots of a ball with their height and its absolute value as fields."""
    dots = sparsurf.surface(([[0.0, 0, 0]], [RADIUS]))
    return replace(dots, fields={"height": dots.points[:, 2], "apart": np.abs(dots.points[:, 2])})


@pytest.fixture(scope="module")
def dots():
    """The dots of a protein with a cavity, and their hydropathy."""
    placed = sparsurf.surface(TDP43)
    return replace(placed, fields={"hydropathy": sparsurf.fields(placed, "hydropathy")["hydropathy"]})


@pytest.mark.parametrize(
    ("field", "threshold", "sides"),
    [
        ("height", {"above": RADIUS - HEIGHT}, [1]),
        ("height", {"below": HEIGHT - RADIUS}, [-1]),
        ("apart", {"above": RADIUS - HEIGHT}, [1, -1]),
    ],
)
def test_a_cap_of_a_ball_has_the_area_and_the_centre_of_its_formula(ball, field, threshold, sides):
    """A cap has the area 2 pi r h, and the mean height of its surface is halfway up."""
    table = sparsurf.regions(ball, field, **threshold)
    assert table["region"].tolist() == [*range(1, len(sides) + 1)]
    assert table["area"].to_numpy() == pytest.approx(2 * np.pi * RADIUS * HEIGHT, rel=0.02)
    assert sorted(table["z"]) == pytest.approx([side * 7.5 for side in sorted(sides)], abs=0.1)
    assert np.abs(table[["x", "y"]]).to_numpy().max() < 0.2
    factor = sides[0]  # of the field, whose sign that of `below` is
    assert table["mean"].to_numpy() == pytest.approx(factor * 7.5, abs=0.1)
    assert table["peak"].to_numpy() == pytest.approx(factor * RADIUS, abs=0.05)
    assert (table["residues"] == "").all()


def test_a_ring_between_two_caps_is_no_region_of_theirs(ball):
    (area,) = sparsurf.regions(ball, "apart", below=RADIUS - HEIGHT)["area"]
    assert area == pytest.approx(4 * np.pi * RADIUS * (RADIUS - HEIGHT), rel=0.02)


def connected(points, distance):
    """The connected sets of points, by a search that compares each with all others."""
    left, sets = {*range(len(points))}, []
    while left:
        found, waiting = [], [left.pop()]
        while waiting:
            point = waiting.pop()
            found.append(point)
            near = {*np.flatnonzero(np.linalg.norm(points - points[point], axis=1) < distance)} & left
            left -= near
            waiting += near
        sets.append(np.array(found))
    return sets


def test_regions_are_the_connected_dots_past_the_threshold(dots):
    past = np.flatnonzero(dots.fields["hydropathy"] > 1)
    parts = [past[part] for part in connected(dots.points[past], 0.5)]
    parts.sort(key=lambda part: -dots.area[part].sum())
    table = sparsurf.regions(dots, "hydropathy", above=1, min_area=0)
    assert table["area"].to_numpy() == pytest.approx([dots.area[part].sum() for part in parts])
    assert table["area"].sum() == pytest.approx(dots.area[past].sum())
    assert table["dots"].tolist() == [len(part) for part in parts]
    for part, row in zip(parts, table.itertuples(), strict=True):
        assert (row.x, row.y, row.z) == pytest.approx(dots.points[part].mean(axis=0))
        values = dots.fields["hydropathy"][part]
        assert (row.mean, row.peak) == pytest.approx((values.mean(), values.max()))
        assert {*row.residues.split("; ")} == {*map(dots.molecule.residue_label, dots.atom[part])}
    large = sparsurf.regions(dots, "hydropathy", above=1)
    assert large["area"].tolist() == [area for area in table["area"] if area >= 20]
    assert 1 < len(large) < len(table)


def test_a_path_has_no_regions_in_cavities_and_a_turn_changes_no_area(dots):
    outside = sparsurf.surface(TDP43, cavities="remove")
    table = sparsurf.regions(TDP43, "hydropathy", above=2)
    assert table.equals(sparsurf.regions(outside, "hydropathy", above=2))
    areas = [each["area"].sum() for each in (table, sparsurf.regions(dots, "hydropathy", above=2))]
    assert areas[1] > areas[0] + 20  # dots of a surface have their cavities
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    molecule = outside.molecule
    turned = replace(molecule, xyz=molecule.xyz @ (turn * np.sign(np.linalg.det(turn))))
    again = sparsurf.regions(turned, "hydropathy", above=2)
    assert again["area"].to_numpy() == pytest.approx(table["area"].to_numpy(), rel=0.03)


def test_fields_are_computed_or_come_from_a_table(dots, tmp_path):
    hydropathy = sparsurf.regions(dots, "hydropathy", above=1)
    assert sparsurf.regions(replace(dots, fields={}), "hydropathy", above=1).equals(hydropathy)

    def height(molecule, points):
        return points[:, 2]

    (top, *_) = sparsurf.regions(dots, height, above=30)["z"]
    assert top > 30
    path, table = tmp_path / "scores.csv", tmp_path / "regions.csv"
    names = np.unique(dots.molecule.residue)
    path.write_text("residue,score\n" + "".join(f"{name},{name}\n" for name in names))
    call = ["regions", str(TDP43), "--cavities", "keep", "--field", "score", "--above", "250", "-q"]
    for words, keys in (([], {}), (["--smooth", "2.5"], {"smooth": 2.5})):
        assert main([*call, "--table", str(path), *words, "-o", str(table)]) == 0
        wanted = sparsurf.regions(dots, "score", above=250, table=path, **keys)
        assert pd.read_csv(table)["area"].to_numpy() == pytest.approx(wanted["area"].to_numpy())
        past = sparsurf.fields(dots, "score", table=path, **keys).to_numpy().ravel() > 250
        assert wanted["area"].sum() == pytest.approx(dots.area[past].sum(), rel=0.05)


def test_dots_without_a_value_are_past_no_threshold(ball):
    half = replace(ball, fields={"height": np.where(ball.points[:, 0] > 0, np.nan, ball.points[:, 2])})
    for threshold in ({"above": RADIUS - HEIGHT}, {"below": HEIGHT - RADIUS}):
        (area,) = sparsurf.regions(half, "height", **threshold)["area"]
        assert area == pytest.approx(np.pi * RADIUS * HEIGHT, rel=0.03)


def test_a_file_of_dots_has_regions_without_residues(ball, tmp_path):
    path, out = tmp_path / "dots.npz", tmp_path / "regions.csv"
    sparsurf.write(ball, path)
    assert main(["regions", str(path), "--field", "height", "--above", "5", "-o", str(out), "-q"]) == 0
    row = out.read_text().splitlines()[1].split(",")
    assert (
        len(row) == 9
        and row[5] == ""
        and float(row[1]) == pytest.approx(2 * np.pi * RADIUS * HEIGHT, rel=0.02)
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"above": 9}, "No dot is past 9; the highest is 4.2"),
        ({"below": -9}, "No dot is past -9; the lowest is -4"),
        ({}, "either above"),
        ({"above": 1, "below": 0}, "either above"),
        ({"above": "1"}, "above is '1'"),
        ({"below": np.nan}, "below is nan"),
        ({"above": 1, "min_area": -1}, "min_area is -1; it must be a number, 0 or more"),
        ({"above": 1, "field": "hydropaty"}, "no field 'hydropaty'.*; did you mean 'hydropathy'"),
        ({"above": 1, "field": ["a", "b"]}, "must be names"),
    ],
)
def test_a_wrong_threshold_or_field_is_one_sentence(dots, given, message):
    with pytest.raises(InputError, match=message):
        sparsurf.regions(dots, **{"field": "hydropathy"} | given)


def test_dots_that_lack_a_field_or_areas_or_neighbours_are_refused(ball, tmp_path):
    with pytest.raises(InputError, match="'qq'; theirs: height,"):
        sparsurf.regions(ball, "qq", above=1)
    with pytest.raises(InputError, match="field 'hydropathy'"):
        sparsurf.regions(ball, "hydropathy", above=1)
    with pytest.raises(InputError, match="no areas"):
        sparsurf.regions(replace(ball, area=np.full(len(ball), np.nan)), "height", above=1)
    with pytest.raises(InputError, match="give all dots of a surface"):
        sparsurf.regions(ball.take(np.arange(0, len(ball), 20)), "height", above=1)
