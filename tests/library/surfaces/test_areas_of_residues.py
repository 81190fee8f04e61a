"""One area in every table: exact, for dots that were placed on a molecule."""

from pathlib import Path

import numpy as np
import pytest

import sparsurf

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def molecule():
    return sparsurf.read_molecule(ROOT / "data/tdp43/topology.pdb", residues="209-222")


def test_the_areas_of_residues_are_those_of_atoms(molecule):
    dots, exact = sparsurf.surface(molecule), sparsurf.areas(molecule)
    table = sparsurf.residues(dots)
    assert table["area"].to_numpy() == pytest.approx(exact.residues["excluded"].to_numpy(), abs=1e-6)
    kinds = table[["area_contact", "area_saddle", "area_concave"]].to_numpy()
    assert kinds.sum(axis=1) == pytest.approx(table["area"].to_numpy(), abs=1e-6)
    contact = (
        exact.accessible
        * (
            sparsurf.surface_atoms(molecule).spheres.radii
            / (1.4 + sparsurf.surface_atoms(molecule).spheres.radii)
        )
        ** 2
    )
    assert kinds[:, 0] == pytest.approx(np.bincount(molecule.residue_index, contact), abs=1e-6)
    assert dots.total_area == pytest.approx(table["area"].sum(), abs=1e-6)
    assert (
        np.abs(np.bincount(molecule.residue_index[dots.atom], dots.area) - table["area"]).max() > 0.1
    )  # sums of dots differ
    of_frames = sparsurf.frames(molecule)
    assert np.asarray(of_frames.residues["area"]) == pytest.approx(table["area"].to_numpy(), abs=1e-6)


def test_dots_of_a_file_and_residues_that_are_cut_keep_the_sums_over_their_dots(molecule, tmp_path):
    dots = sparsurf.surface(molecule)
    sparsurf.write(dots, tmp_path / "dots.npz")
    of_file = sparsurf.residues(molecule, tmp_path / "dots.npz")["area"]
    assert of_file.to_numpy() == pytest.approx(
        np.bincount(molecule.residue_index[dots.atom], dots.area), abs=1e-4
    )
    part, whole = dots[: len(dots) // 2], sparsurf.residues(dots)
    table = sparsurf.residues(part)
    complete = (table["dots"] == whole["dots"]).to_numpy()
    cut = (table["dots"] > 0).to_numpy() & ~complete
    of_dots = np.bincount(molecule.residue_index[part.atom], part.area, len(table))
    assert complete.sum() > 3 and cut.sum() == 1
    assert table["area"][complete].to_numpy() == pytest.approx(whole["area"][complete].to_numpy(), abs=1e-6)
    assert table["area"][cut].to_numpy() == pytest.approx(of_dots[cut])
