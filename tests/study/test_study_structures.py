"""Structures of a study: which conformations it chooses, and how it reads what it wrote."""

import mdtraj
import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from peptides import atom_line, moved, peptide, write
from sparsurf.errors import InputError
from sparsurf.settings import Settings
from sparsurf.surfaces.components import on_cavities
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf_study.report.page_origin import with_atoms
from sparsurf_study.structures import choose_conformations, read_study_structure, residue_labels


def chosen(folder, text, stride=1, reading=None, trajectory=None, **asked):
    """Names of the conformations that the study makes of a PDB file, for a asked of `frames`."""
    frames = {"selection": "clusters", "clusters": "auto", "stride": stride} | asked
    structure, rng = write(folder / "p.pdb", text), np.random.default_rng(1)
    choice = choose_conformations(structure, trajectory, reading or {}, rng, **frames)[1]
    return choice.table["conformation"].tolist()


def test_a_single_structure_is_one_conformation_whatever_frames_says(tmp_path):
    """Beside it a trajectory may be studied; a file of several models has as many frames."""
    one, models = peptide() + "END\n", "".join(f"MODEL {k}\n{peptide()}ENDMDL\n" for k in (1, 2, 3))
    assert chosen(tmp_path, one, clusters=3) == chosen(tmp_path, one, stride=5) == ["c1"]
    for use in ([0, 2], [7], [0], "all"):
        assert chosen(tmp_path, one, selection=use) == ["f0"]
    assert chosen(tmp_path, models, selection=[0, 2]) == ["f0", "f2"]
    assert chosen(tmp_path, models, selection=[0, 2], reading={"model": 2}) == ["f1"]
    assert chosen(tmp_path, models, selection="all", start=1) == ["f1", "f2"]
    assert chosen(tmp_path, models, selection="all", start=1, stop=2) == ["f1"]
    assert chosen(tmp_path, one, start=1) == ["c1"]
    for stride, last in ((1, 2), (5, 0)):
        with pytest.raises(InputError, match=rf"\[7\] are not among the frames read, 0 to {last}"):
            chosen(tmp_path, models, selection=[7], stride=stride)
    mdtraj.load(tmp_path / "p.pdb")[:1].save_xtc(str(tmp_path / "p.xtc"))
    with pytest.raises(InputError, match=r"\[2\] are not among the frames read, 0 to 0"):
        chosen(tmp_path, one, selection=[0, 2], trajectory=tmp_path / "p.xtc")


def test_what_a_study_wrote_is_read_as_it_is(tmp_path, caplog):
    """Waters included, residues that the box cuts left cut, and without a warning."""
    lines = peptide(("ALA", "GLY"), "B", 7).splitlines(True)
    lines[4] = moved(lines[4], 40)
    lines += atom_line("O", "HOH", residue="9", place=(90, 0, 0))
    path = write(
        tmp_path / "a.pdb", f"CRYST1{3 * '   40.000'}{3 * '  90.00'} P 1           1\n" + "".join(lines)
    )
    assert residue_labels(path) == 5 * ["ALA 7 B"] + 5 * ["GLY 8 B"] + ["HOH 9 A"]
    assert residue_labels(None) == []
    assert read_study_structure(path).xyz[0, [4, -1], 0].tolist() == [42, 90] and not caplog.messages


def test_dots_of_a_file_with_their_atoms_have_the_exact_areas(tmp_path):
    """Their sums differ by some Å^2; a wall is what the surface without cavities lacks."""
    molecule = sparsurf.read_molecule(ROOT / "data/tdp43/topology.pdb", residues="217-230")
    molecule.write_pdb(tmp_path / "p.pdb")
    placed = sparsurf.surface(molecule)
    sparsurf.write(placed, tmp_path / "p.npz")
    dots = with_atoms(read_npz(tmp_path / "p.npz"), str(tmp_path / "p.pdb"), Settings())
    exact = sparsurf.areas(molecule).residues["excluded"].sum()
    outside = sparsurf.surface(molecule, cavities="remove").total_area
    cavity = on_cavities(placed, placed.known_components("surface"))
    assert dots.total_area == pytest.approx(exact, rel=1e-9) and abs(dots.area.sum() - exact) > 0.1
    assert dots.area_of_walls(cavity) == pytest.approx(exact - outside, rel=1e-9)
    assert exact - outside == pytest.approx(dots.area[cavity].sum(), rel=0.05)
