"""Donors and acceptors of hydrogen bonds, against values typed by hand."""

from dataclasses import replace

import numpy as np
import pytest

import sparsurf
from sparsurf.errors import InputError
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.residues import known_kind

# of residues that lie apart, without hydrogens: (donated - accepted) / (donated + accepted)
ATOMS = {
    "ALA": {"N": 1, "CA": 0, "C": 0, "O": -1, "CB": 0, "OXT": -1},
    "PRO": {"N": 0, "O": -1},
    "ARG": {"NE": 1, "NH1": 1, "NH2": 1, "CZ": 0},
    "ASN": {"OD1": -1, "ND2": 1},
    "ASP": {"OD1": -1, "OD2": -1, "N": 1},
    "GLN": {"OE1": -1, "NE2": 1},
    "GLU": {"OE1": -1, "OE2": -1},
    "HIS": {"ND1": 0, "NE2": 0},
    "HID": {"ND1": 1, "NE2": -1},
    "HIE": {"ND1": -1, "NE2": 1},
    "HIP": {"ND1": 1, "NE2": 1},
    "HSD": {"ND1": 1, "NE2": -1},
    "HSE": {"ND1": -1, "NE2": 1},
    "GLY": {"N": 1, "OT1": -1, "OT2": -1},
    "C": {"O1P": -1, "O2P": -1, "N4": 1, "O2": -1},
    "LYS": {"NZ": 1},
    "LYN": {"NZ": 1 / 3},
    "SER": {"OG": -1 / 3},
    "THR": {"OG1": -1 / 3},
    "TYR": {"OH": -1 / 3},
    "TRP": {"NE1": 1},
    "ASH": {"OD1": -1, "OD2": -1 / 3},
    "GLH": {"OE1": -1, "OE2": -1 / 3},
    "ARN": {"NE": -1, "NH1": 1, "NH2": 1},
    "TYM": {"OH": -1},
    "CYS": {"SG": 0},
    "MET": {"SD": 0},
    "G": {"N1": 1, "N2": 1, "N3": -1, "O6": -1, "N7": -1, "N9": 0, "O2'": -1 / 3, "OP1": -1, "C8": 0},
    "A": {"N1": -1, "N3": -1, "N6": 1, "N7": -1, "N9": 0, "O5'": -1, "O4'": -1},
    "U": {"N1": 0, "O2": -1, "N3": 1, "O4": -1},
    "DG": {"N1": 1, "N2": 1, "N3": -1, "O6": -1, "N7": -1, "N9": 0},
    "DA": {"N1": -1, "N3": -1, "N6": 1, "N7": -1, "O3'": -1},
    "DC": {"N1": 0, "O2": -1, "N3": -1, "N4": 1},
    "DT": {"O2": -1, "N3": 1, "O4": -1},
    "HOH": {"O": 0},
    "WAT": {"OW": 0},
}


BONDS = {
    "HD1": ("ND1", 1.0),
    "HG": ("OG", 1.39),
    "HB3": ("OG", -1.41),
    "HB2": ("CB", 1.1),
    "HN": ("N", 1.0),
    "HX": ("O", 1.0),
    "H1": ("O", 1.0),
    "H2": ("O", -1.0),
}


def molecule_of(atoms):
    """Atoms by residue, 8 Å and more from one another, and hydrogens beside theirs."""
    rows = [(k, residue, name) for k, (residue, names) in enumerate(atoms.items()) for name in names]
    index, residues, names = map(np.array, zip(*rows, strict=True))
    heavy = [BONDS.get(name, (name, 0.0)) for name in names]
    place = [
        (40 * k, 8 * [*atoms[residue]].index(name), shift)
        for k, residue, (name, shift) in zip(index, residues, heavy, strict=True)
    ]
    return Molecule(
        xyz=np.array([place], float),
        time_ps=np.zeros(1),
        frame_number=np.zeros(1, int),
        name=names,
        residue_name=residues,
        chain=np.full(len(names), "A"),
        element=np.array([name[0] for name in names]),
        residue=(index + 1).astype(str),
        residue_index=index,
        kind=np.array([known_kind(str(residue)) for residue in residues]),
        b_factor=np.zeros(len(names)),
    )


def test_each_dot_has_the_value_of_its_atom(caplog):
    dots = sparsurf.surface(molecule_of(ATOMS))
    table = dots.to_frame().assign(hbond=sparsurf.fields(dots, "hbond")["hbond"])
    of_atoms = table.groupby(["residue_name", "atom_name"])["hbond"].agg(["min", "max"])
    typed = {(residue, atom): value for residue, names in ATOMS.items() for atom, value in names.items()}
    assert {*typed} == {*of_atoms.index}
    for key, value in typed.items():
        assert of_atoms.loc[key].tolist() == pytest.approx([value] * 2), key
    assert not [message for message in caplog.messages if message.startswith("hbond")]


def test_hydrogens_of_the_file_donate_and_tell_the_state_of_histidine():
    """Within 1.4 Å of a donor; one beside an atom that only accepts donates nothing."""
    atoms = {
        "ALA": ["N", "HN", "O", "HX"],
        "HIS": ["ND1", "HD1", "NE2"],
        "NHIS": ["ND1", "NE2"],
        "SER": ["OG", "HG", "HB3", "CB", "HB2"],
        "HOH": ["O", "H1", "H2"],
    }
    few = sparsurf.points(molecule_of(atoms), 400, fields="hbond").to_frame()
    found = few.groupby(["residue_name", "atom_name"])["hbond"].first()
    assert found["ALA"].to_dict() == {"N": 1, "HN": 1, "O": -1, "HX": 0}
    assert found["HIS"].to_dict() == {"HD1": 1, "ND1": 1, "NE2": -1}
    assert found["NHIS"].to_dict() == {"ND1": 0, "NE2": 0}  # without hydrogens
    assert found["SER"].to_dict() == pytest.approx({"CB": 0, "HB2": 0, "HB3": 0, "HG": 1, "OG": -1 / 3})
    assert found["HOH"].to_dict() == {"H1": 1, "H2": 1, "O": 0}


def test_hydrogens_donate_where_they_lie_in_the_frame_of_the_dots():
    """A hydrogen that leaves its donor after the first frame."""
    one = molecule_of({"SER": ["OG", "HG", "CB"]})
    left = one.xyz + np.array([[0, 0, 0], [0, 0, 9.0], [0, 0, 0]])
    both = replace(
        one, xyz=np.concatenate([one.xyz, left]), time_ps=np.arange(2.0), frame_number=np.arange(2)
    )
    for frame, value in ((0, 1), (1, 0)):
        few = sparsurf.points(both, 200, frame=frame, fields="hbond").to_frame()
        assert set(few.loc[few["atom_name"] == "HG", "hbond"]) == {value}


def test_unknown_residues_count_as_neither_and_are_named(caplog):
    molecule = molecule_of({"ALA": ["N"], "HEM": ["O1A", "C1A"], "FOO": ["C1"], "BAR": ["N1"]})
    mesh = sparsurf.mesh(molecule, 200, fields="hbond")
    table = mesh.to_frame()
    assert set(table["hbond"][table["residue_name"] == "ALA"]) == {1.0}
    assert set(table["hbond"][table["residue_name"] != "ALA"]) == {0.0}
    assert [message for message in caplog.messages if message.startswith("hbond")] == [
        "hbond: nitrogen and oxygen atoms of BAR, HEM are not in the table and count as neither donors nor acceptors"
    ]


def test_hbond_needs_the_names_of_atoms():
    spheres = (np.zeros((1, 3)), [1.7])
    with pytest.raises(InputError, match="hbond follows"):
        sparsurf.points(spheres, 50, fields="hbond")
