"""A molecule cut to some atoms or one frame, its residues and topology; endings of files; the reading `recovered`."""

from dataclasses import replace
from string import ascii_letters, ascii_uppercase, digits

import numpy as np
import pytest

from peptides import ALANINE, STEP, atom_line, write
from sparsurf.molecules import formats
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.pdb import _short_chain_ids, _short_residue_names, read_pdb
from sparsurf.molecules.read_molecule import read_molecule


@pytest.fixture
def molecule():
    """Two frames of five atoms: residues A 1, A 2B and, with the number 1 again, B 1."""
    return Molecule(
        xyz=np.arange(30.0).reshape(2, 5, 3), time_ps=np.array([10.0, 20.0]), frame_number=np.array([3, 7]),
        name=np.array(["N", "CA", "N", "CA", "ZN"]), residue_name=np.array(["ALA", "ALA", "GLY", "GLY", "ZN"]),
        chain=np.array(["A", "A", "A", "A", "B"]), element=np.array(["N", "C", "N", "C", "Q1"]),
        residue=np.array(["1", "1", "2B", "2B", "1"]), residue_index=np.array([0, 0, 1, 1, 2]),
        kind=np.array(["protein"] * 4 + ["other"]), b_factor=np.array([1.0, 2, 3, 4, 5]),
    )  # fmt: skip


def test_parts_and_labels_of_a_molecule(molecule):
    assert (molecule.n_frames, molecule.n_atoms, molecule.n_residues) == (2, 5, 3)
    assert repr(molecule) == "Molecule of 5 atoms in 3 residues, 2 frames"
    assert molecule.counted_residues == "2 residues and 1 ligand"
    assert molecule.take(np.array([4])).counted_residues == "1 ligand"
    assert repr(molecule.take(np.array([2])).frame(0)) == "Molecule of 1 atom in 1 residue, 1 frame"
    assert [molecule.residue_label(atom) for atom in (1, 2, 4)] == ["ALA 1 A", "GLY 2B A", "ZN 1 B"]
    assert molecule.residues.to_numpy().tolist() == [["A", "1", "ALA"], ["A", "2B", "GLY"], ["B", "1", "ZN"]]
    elements = np.array(["H", "C", "D", "HE", "X"])
    assert replace(molecule, element=elements).heavy.tolist() == [False, True, False, True, True]
    part = molecule.take(np.array([2, 3, 4]))
    assert part.residue_index.tolist() == [0, 0, 1] and part.name.tolist() == ["N", "CA", "ZN"]
    assert np.array_equal(part.xyz, molecule.xyz[:, [2, 3, 4]]) and part.time_ps.tolist() == [10, 20]
    assert molecule.take(molecule.name == "N").chain.tolist() == ["A", "A"]
    second = molecule.frame(1)
    assert second.xyz.shape == (1, 5, 3) and np.array_equal(second.xyz[0], molecule.xyz[1])
    assert (second.time_ps.tolist(), second.frame_number.tolist()) == ([20], [7])
    assert molecule.frame(0).frame_number.tolist() == [3]
    labels = molecule.labels(np.array([3, 0]))
    assert list(labels.columns) == ["chain", "residue", "residue_name", "atom_name", "atom"]
    assert labels.to_numpy().tolist() == [["A", "2B", "GLY", "CA", 3], ["A", "1", "ALA", "N", 0]]


def test_the_topology_has_chains_residues_and_elements(molecule):
    topology = molecule.topology
    assert [residue.n_atoms for residue in topology.residues] == [2, 2, 1]
    assert [residue.resSeq for residue in topology.residues] == [
        1,
        2.5,
        1,
    ]  # of 1, 2B and 1: mdtraj has no insertion codes
    assert [residue.chain.index for residue in topology.residues] == [0, 0, 1]
    assert topology.select("segname B").tolist() == [4] and topology.atom(4).element.symbol == "VS"
    assert topology.atom(1).element.symbol == "C" and topology.n_bonds == 0
    nameless = replace(molecule, residue=np.array(["", "", "2B", "2B", "1"]))
    assert [residue.resSeq for residue in nameless.topology.residues] == [0, 2.5, 1]


def test_one_frame_is_written_atoms_from_one_and_with_the_end_of_each_chain(molecule, tmp_path):
    molecule.take(molecule.kind == "protein").write_pdb(tmp_path / "x.pdb", 1, np.arange(4.0))
    lines = [line for line in (tmp_path / "x.pdb").read_text().splitlines() if line.startswith("ATOM")]
    assert [(float(line[30:38]), float(line[60:66])) for line in lines] == [
        (15, 0), (18, 1), (21, 2), (24, 3),
    ]  # fmt: skip
    molecule.write_pdb(tmp_path / "x.pdb")
    first, *others = (tmp_path / "x.pdb").read_text().splitlines()
    assert first == "ATOM      1  N   ALA A   1       0.000   1.000   2.000  1.00  1.00           N"
    assert [line[:11].split() for line in others] == [
        ["ATOM", "2"], ["ATOM", "3"], ["ATOM", "4"], ["TER"], ["HETATM", "5"], ["TER"], ["END"],
    ]  # fmt: skip


def test_every_name_and_number_is_written_in_its_columns(molecule, tmp_path):
    odd = replace(
        molecule, name=np.array(["CA", "OXT", "HG11", "Ω", "ZN"]), residue_name=np.array(["HISE"] * 5),
        chain=np.array(["A", "A", "AB", "AB", "AB"]), b_factor=np.array([np.nan, -200, 5000, 999.99, -99.99]),
        xyz=np.array([[[12345.678, -1234.567, 1], [0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]]),
    )  # fmt: skip
    odd.write_pdb(tmp_path / "x.pdb")
    head, *lines = [line for line in (tmp_path / "x.pdb").read_text().splitlines() if len(line) > 3]
    assert head.split() == ["HETNAM", "~SE", "HISE"]
    assert set(read_pdb((tmp_path / "x.pdb").read_text()).atoms.residue_name) == {"HISE"}
    assert [line[12:16] for line in lines] == [" CA ", " OXT", "HG11", " ?  ", "ZN  "]
    assert lines[0][30:54] == "12345.67-1234.56   1.000"
    assert [line[17:22] for line in lines] == ["~SE A", "~SE A", "~SEAB", "~SEAB", "~SEAB"]
    assert [float(line[60:66]) for line in lines] == [0, -99.99, 999.99, 999.99, -99.99]


def test_long_residue_names_that_end_alike_get_letters_of_their_own():
    short = _short_residue_names(np.array(["ABCXY", "ALA", "~AA", "DEFXY", "GHIXY"]), 3)
    assert short == {"ABCXY": "~XY", "DEFXY": "~AB", "GHIXY": "~AC"}


def test_chains_keep_their_ids_if_all_have_two_letters_or_less():
    assert _short_chain_ids(np.array(["B", "AB", ""])) == ["B", "AB", ""]
    letters = [*ascii_uppercase, *ascii_letters[:26], *digits]
    assert _short_chain_ids(np.array([f"L{k:02}" for k in range(62)])) == letters
    assert _short_chain_ids(np.array([f"L{k:02}" for k in range(64)])) == [*letters, "AA", "AB"]


def test_only_ids_that_do_not_fit_get_other_names_which_is_reported(caplog):
    """A chain keeps the name by which the user asks for its residues."""
    assert _short_chain_ids(np.array(["AAA", "AAA", "A", "C", "BBB"])) == ["B", "B", "A", "C", "D"]
    assert "have other names in its results: AAA is B, BBB is D" in caplog.text
    caplog.clear()
    assert _short_chain_ids(np.array(["A", "AB"])) == ["A", "AB"] and not caplog.text


def test_the_ending_of_a_name():
    names = {
        "a.pdb": ".pdb", "b/A.PDB.GZ": ".pdb", "a.b.cif.gz": ".cif", "a.gz.xtc": ".xtc", "a": "", "a.gz": "",
        "a.gz2": ".gz2",
    }  # fmt: skip
    assert {name: formats.suffix(name) for name in names} == names
    stems = {"a.pdb": "a", "b/A.b.PDB.GZ": "A.b", "a.gz": "a", "a": "a", "a.b.xtc": "a.b"}
    assert {name: formats.stem(name) for name in stems} == stems


def test_an_expression_names_residues_in_the_order_of_the_chain(tmp_path):
    labels = ["1B", "1A", "1", "2", "2A", "3"]
    lines = (
        atom_line(name, residue=label, place=np.add(place, k * STEP))
        for k, label in enumerate(labels) for name, place in ALANINE.items()
    )  # fmt: skip
    molecule = read_molecule(write(tmp_path / "a.pdb", "".join(lines) + "END\n"))
    for expression, chosen in (
        ("residue 1", "1"), ("residue 2", "2"), ("residue 1 to 2", "1 2"), ("residue 2 to 3", "2 2A 3"), ("residue < 1", "1B 1A"),
    ):  # fmt: skip
        assert [*dict.fromkeys(molecule.select(selection=expression).residue.tolist())] == chosen.split()
    two = replace(molecule, chain=np.where(molecule.residue_index < 3, "A", "B"))
    labels = ["1", "1A", "2", "1B", "1A", "1"]  # codes stand before their number in B alone
    two = replace(two, residue=np.repeat(labels, 5))
    for expression, chosen in (
        ("residue < 1", [3, 4]),
        ("residue 1", [0, 5]),
        ("residue 1 to 2", [0, 1, 2, 5]),
    ):
        kept = two.select(selection=expression).xyz[0, ::5]
        assert np.array_equal(kept, two.xyz[0, ::5][chosen])
