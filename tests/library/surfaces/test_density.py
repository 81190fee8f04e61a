"""How dense the dots are laid where the config leaves it open."""

import logging
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from conftest import ROOT
from peptides import peptide, write
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import SurfaceSettings as SurfaceSettings
from sparsurf.surfaces import molecular_surface
from sparsurf.surfaces.molecular_surface import (
    density_for_d_link,
    roll_frame,
    surface_generator,
)
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import (
    DENSITY,
    MIN_D_LINK_PER_SPACING,
    area_of,
    nearest_distances,
    refuse_sparse,
    spacing,
)

SETTINGS = SurfaceSettings()


def without_hydrogens(folder, n_residues):
    molecule = read_molecule(write(folder / "a.pdb", peptide(["ALA"] * n_residues) + "END\n"))
    return molecule, radii(molecule, "dms")


@pytest.mark.parametrize("n_residues", [1, 10, 15, 37])
def test_an_automatic_density_suits_the_linking_distance(tmp_path, caplog, n_residues):
    """From 15 residues on one step of correction does not reach it: the spacing falls slower than 1 / sqrt(density)."""
    molecule, atom_radii = without_hydrogens(tmp_path, n_residues)
    caplog.clear()
    with caplog.at_level(logging.INFO, "sparsurf"):
        surface, density = roll_frame(molecule.xyz[0], atom_radii, SETTINGS).surface_for_d_link(
            "auto", 0.5, "a"
        )
    refuse_sparse(surface.points, 0.5, "a")
    assert [record.levelname for record in caplog.records] == ["INFO"]
    assert f"a: {density:.2f} dots per Å^2" in caplog.text
    assert density_for_d_link(molecule.xyz[0], atom_radii, SETTINGS, 0.5, "a") == density
    assert 0.45 < MIN_D_LINK_PER_SPACING * spacing(surface.points) <= 0.5, "much denser than needed"


def test_a_density_that_suits_already_stays_and_so_does_one_that_is_given(tmp_path, caplog):
    molecule, atom_radii = without_hydrogens(tmp_path, 3)
    rolled = roll_frame(molecule.xyz[0], atom_radii, SETTINGS)
    assert rolled.surface_for_d_link("auto", 1.0, "a")[1] == DENSITY
    thin, density = rolled.surface_for_d_link(0.1, 0.5, "a")
    assert density == 0.1 and len(thin) == len(rolled.surface(0.1))
    placed = rolled.surface(DENSITY)
    assert rolled.surface_for_d_link("auto", 1.0, "a", placed)[0] is placed
    assert not caplog.text


@pytest.mark.parametrize(("hydrogens", "expected"), [("keep", DENSITY), ("remove", 5.8)])
def test_dots_are_placed_once_on_a_protein_and_their_spacing_is_measured(monkeypatch, hydrogens, expected):
    """At a density that follows from the share of hydrogens; the published one leaves gaps on a protein without any."""
    molecule = read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", hydrogens=hydrogens)
    rolled, placed = roll_frame(molecule.xyz[0], radii(molecule), SETTINGS), []
    place = molecular_surface.place_dots
    monkeypatch.setattr(molecular_surface, "place_dots", lambda *given: placed.append(given) or place(*given))
    dots, density = rolled.surface_for_d_link("auto", 0.5, "a")
    assert len(placed) == 1 and density == pytest.approx(expected)
    assert MIN_D_LINK_PER_SPACING * spacing(dots.points) <= 0.5
    suits = MIN_D_LINK_PER_SPACING * spacing(rolled.surface(DENSITY).points) <= 0.5
    assert suits == (hydrogens == "keep")


def test_a_linking_distance_needs_dots_closer_by_a_third_and_no_more_than_the_densest(tmp_path):
    molecule, atom_radii = without_hydrogens(tmp_path, 3)
    with pytest.raises(InputError, match=r"a: d_link = 0.05 Å .* 100 dots per Å\^2; give a larger d_link"):
        roll_frame(molecule.xyz[0], atom_radii, SETTINGS).surface_for_d_link("auto", 0.05, "a")
    points = np.column_stack([np.arange(50.0), np.zeros(50), np.zeros(50)])
    refuse_sparse(points, 1.301, "a")
    with pytest.raises(
        InputError, match=r"below 1.3 times the median distance .* \(1.000 Å\), .* or a larger d_link\.$"
    ):
        refuse_sparse(points, 1.299, "a")
    with pytest.raises(InputError, match="fragmented; do"):
        refuse_sparse(points, 1.299, "a", "do this")
    with pytest.raises(InputError, match="single dot"):
        refuse_sparse(points[:1], 1.3, "a")


def test_a_density_grows_with_the_square_of_the_spacing_as_far_as_it_may(tmp_path, monkeypatch):
    molecule, atom_radii = without_hydrogens(tmp_path, 10)
    dots = roll_frame(molecule.xyz[0], atom_radii, SETTINGS).surface(DENSITY)
    least = MIN_D_LINK_PER_SPACING * spacing(dots.points)
    density = DENSITY * (1.02 * least / 0.5) ** 2
    asked = molecule.xyz[0], atom_radii, SETTINGS, 0.5, "a"
    assert density_for_d_link(*asked) == pytest.approx(density)
    monkeypatch.setattr(molecular_surface, "MAX_DENSITY", 0.99 * density)
    with pytest.raises(InputError, match="so short"):
        density_for_d_link(*asked)


def test_atoms_stand_where_a_pdb_file_has_them_and_densities_are_the_same_elsewhere(tmp_path, caplog):
    molecule, sizes = without_hydrogens(tmp_path, 3)
    molecule = replace(molecule, xyz=np.concatenate([molecule.xyz + 9, molecule.xyz + 0.0004]))
    other = SETTINGS.model_copy(update={"density": 3.0, "probe_radius": 1.8, "reentrant": "dms"})
    for settings in (SETTINGS, SETTINGS.model_copy(update={"density": 2.0}), other):
        generate, atoms = surface_generator(molecule.xyz[1], sizes, settings, 0.5, "a")
        assert np.array_equal(atoms, molecule.xyz[1].round(3))
        assert all(record.levelno < logging.WARNING for record in caplog.records)
        rolled = roll_frame(molecule.xyz[1], sizes, settings)
        wanted = rolled.surface_for_d_link(settings.density, 0.5, "a")[0]
        assert np.array_equal(generate(atoms).points, wanted.points)
    wanted = molecular_surface.molecular_surface(atoms, sizes, 1.8, 3.0, "dms")
    assert np.array_equal(generate(atoms).points, wanted.points)
    exact = molecular_surface.molecular_surface(atoms, sizes, 1.8, 3.0)
    assert len(exact) != len(wanted)
    xyz = np.array([[0, 0, 0], [2.0, 0, 0]])
    file, frame = (
        roll_frame(each, np.full(2, 1.7), SETTINGS).surface(DENSITY) for each in (xyz, xyz + 0.0004)
    )
    assert np.array_equal(file.points, frame.points)


def test_the_nearest_dot_is_that_of_a_tree(blob):
    """To the last bit, which densities rest on; with two dots, equal ones, some far from all others, a sparse cloud."""
    dots, rng = blob[0], np.random.default_rng(3)
    far = [[1e4, 0, 0], [1e4, 3, 0], [-9e5, 0, 0]]
    sparse = np.concatenate([dots, 50 + 100 * rng.random((300, 3))])
    for points in (dots, rng.normal(size=(2, 3)), np.zeros((5, 3)), np.concatenate([dots, far]), sparse):
        for cube in (None, 0.4, 5.0):
            assert np.array_equal(
                nearest_distances(points, cube), cKDTree(points).query(points, k=2)[0][:, 1]
            )
    assert np.isnan(spacing(dots[:1])) and spacing(np.array([[0, 0, 0], [0, 0, 2.5]])) == 2.5


def test_a_median_spacing_need_be_exact_only_above_a_limit(blob):
    """Also where the two middle distances lie on both sides of the limit."""
    points = blob[0][:1000]
    exact = np.sort(cKDTree(points).query(points, k=2)[0][:, 1])
    median = float(np.median(exact))
    assert spacing(points) == spacing(points, near=0.99 * exact[499]) == median
    assert median <= spacing(points, near=1.2 * median) <= 1.2 * median
    four = np.array([[0.0, 0, 0], [0.5, 0, 0], [10, 0, 0], [10, 2, 0]])  # distances .5, .5, 2, 2
    assert spacing(four, near=0.6) == spacing(four) == 1.25
    # With cubes of 1 Å, the dots at 1.1 and 1.9 find each other before the nearer ones in other cubes
    row = [[0.9, 0, 0], [1.1, 0, 0], [1.9, 0, 0], [2.05, 0, 0]]
    short = np.array([*row, [0, 50, 0], [2, 50, 0], [0, 60, 0], [2, 60, 0]])
    assert nearest_distances(short, 1.0, near=0.9)[1:3] == pytest.approx([0.8, 0.8])
    assert spacing(short, 1.0, near=0.9) == spacing(short) == pytest.approx(1.1)


def test_the_area_is_the_sum_of_those_of_the_dots_or_reported_from_their_distances():
    points = np.random.default_rng(6).normal(size=(4000, 3))
    points *= 20 / np.linalg.norm(points, axis=1)[:, None]
    assert area_of(SimpleNamespace(points=points, area=np.full(len(points), 0.25))) == (1000.0, False)
    area, estimated = area_of(SimpleNamespace(points=points, area=np.full(len(points), np.nan)))
    assert estimated and area == pytest.approx(
        4 * np.pi * 20**2, rel=0.03
    )  # of random dots it is right in the mean
    two = SimpleNamespace(points=np.array([[0, 0, 0], [0, 0, 2.0]]), area=np.full(2, np.nan))
    assert area_of(two) == (pytest.approx(8 * np.pi), True)
    area, estimated = area_of(SimpleNamespace(points=points[:1], area=np.array([np.nan])))
    assert np.isnan(area) and estimated
