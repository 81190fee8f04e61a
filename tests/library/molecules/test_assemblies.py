"""Assemblies that files declare, against copies that are placed by hand and against values of independent programs."""

import gemmi
import numpy as np
import pytest

import sparsurf
from peptides import atom_line, peptide, write
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule

TURN = np.roll(np.eye(3), 1, axis=0)  # a third of a turn, which its transpose undoes
SHIFT = np.array([9.0, 6.5, 4.25])


def operators(*transforms, first=1):
    """Lines of REMARK 350 of operators, pairs of a matrix and a shift."""
    lines = []
    for number, (matrix, shift) in enumerate(transforms, first):
        for row in range(3):
            values = "".join(f"{value:10.6f}" for value in matrix[row])
            lines.append(f"REMARK 350   BIOMT{row + 1} {number:3d}{values}     {shift[row]:10.5f}\n")
    return "".join(lines)


def biomolecule(name, chains, *transforms):
    """Lines of REMARK 350 of an assembly."""
    head = f"REMARK 350 BIOMOLECULE: {name}\nREMARK 350 AUTHOR DETERMINED BIOLOGICAL UNIT: DIMERIC\n"
    return head + f"REMARK 350 APPLY THE FOLLOWING TO CHAINS: {chains}\n" + operators(*transforms)


IDENTITY = (np.eye(3), np.zeros(3))
MOVED = (TURN, SHIFT)
CHAINS = peptide(("ALA", "SER", "LYS")) + "TER\n" + peptide(("GLY", "VAL"), "B", origin=(0, 0, 15))
CHAINS += atom_line("C1", "LIG", "A", "9", (2, 2, 4), record="HETATM")
DIMER, SECOND = biomolecule(1, "A, B", IDENTITY, MOVED), biomolecule(2, "B", MOVED)


def as_mmcif(path, text):
    """The mmCIF file of a PDB text with assemblies, without the column that gemmi needs."""
    structure = gemmi.read_pdb_string(text)
    structure.setup_entities()
    structure.assign_label_seq_id(True)
    block = structure.make_mmcif_document().sole_block()
    table = block.get_mmcif_category("_pdbx_struct_assembly.")
    table.pop("method_details")
    block.set_mmcif_category("_pdbx_struct_assembly.", table)
    block.write_file(str(path))
    return path


@pytest.mark.parametrize("form", ["pdb", "mmcif"])
def test_copies_lie_where_the_operators_of_the_assembly_move_them(tmp_path, caplog, form):
    text = DIMER + SECOND + CHAINS + "END\n"
    path = write(tmp_path / "a.pdb", text) if form == "pdb" else as_mmcif(tmp_path / "a.cif", text)
    plain = read_molecule(path, selection="all")
    caplog.clear()
    dimer = read_molecule(path, selection="all", assembly=True)
    assert "a.pdb: assembly 1 (dimeric): 2 copies, 52 atoms; it also declares 2" in caplog.text.replace(
        ".cif", ".pdb"
    )
    assert list(dict.fromkeys(dimer.chain.tolist())) == ["A", "B", "A-2", "B-2"]
    assert dimer.n_residues == 2 * plain.n_residues
    n = plain.n_atoms
    assert dimer.xyz[0, :n] == pytest.approx(plain.xyz[0])
    assert dimer.xyz[0, n:] == pytest.approx(plain.xyz[0] @ TURN.T + SHIFT)
    assert dimer.residue[n:].tolist() == plain.residue.tolist()
    second = read_molecule(path, selection="all", assembly="2")
    b = plain.chain == "B"
    assert set(second.chain.tolist()) == {"B"}
    assert second.xyz[0] == pytest.approx(plain.xyz[0, b] @ TURN.T + SHIFT)


def test_generators_that_number_operators_anew_move_each_chain_by_its_own(tmp_path):
    """Chain A turns by its operator 1, B stays by another operator 1; a chain that is named twice is there once."""
    head = "REMARK 350 BIOMOLECULE: 1\nREMARK 350 APPLY THE FOLLOWING TO CHAINS: "
    again = "REMARK 350 APPLY THE FOLLOWING TO CHAINS: "
    text = head + "A\n" + operators(MOVED) + again + "B\n" + operators(IDENTITY, MOVED) + again + "B\n"
    text += operators(IDENTITY)
    path = write(tmp_path / "a.pdb", text + CHAINS + "END\n")
    plain, both = (read_molecule(path, chains=None, assembly=a) for a in (False, True))
    a, b = (plain.xyz[0, plain.chain == chain] for chain in "AB")
    expected = np.concatenate([a @ TURN.T + SHIFT, b @ TURN.T + SHIFT, b])
    assert sorted(both.xyz[0].round(3).tolist()) == sorted(expected.round(3).tolist())


@pytest.mark.parametrize(
    ("remarks", "assembly", "message"),
    [
        ("", True, "declares no assembly"),
        (DIMER + SECOND, "9", "declares the assemblies 1, 2, not 9"),
        (biomolecule(1, "A", (np.diag([1.0, 1.0, -1.0]), SHIFT)), True, "operator 1 .*"),
        (biomolecule(1, "A", (2 * np.eye(3), SHIFT)), True, "operator 1 .*"),
        (biomolecule(1, "Q", IDENTITY), True, "assembly 1 of .* has none of its chains"),
        (DIMER[: DIMER.rindex("REMARK")], True, "REMARK 350 of .* is incomplete"),
        (DIMER.replace("4.25000", "4.2x000"), True, "holds no row"),
        ("REMARK 350 BIOMOLECULE: 1\n" + operators(IDENTITY), True, "REMARK 350 of .* is incomplete"),
    ],
)
def test_what_is_no_assembly_of_the_file_is_refused_in_a_sentence(tmp_path, remarks, assembly, message):
    path = write(tmp_path / "a.pdb", remarks + CHAINS + "END\n")
    with pytest.raises(InputError, match=message):
        read_molecule(path, assembly=assembly)


def test_chains_that_the_file_lacks_and_the_size_of_60_copies_are_told(tmp_path, caplog):
    turns = [(np.eye(3), np.array([30.0 * k, 0, 0])) for k in range(60)]
    path = write(tmp_path / "a.pdb", biomolecule(1, "A, C", *turns) + CHAINS + "END\n")
    assert read_molecule(path, assembly=True).n_atoms == 60 * 15
    assert "60 copies, 960" in caplog.text


@pytest.mark.parametrize(
    ("name", "accessible", "buried", "tolerance"),
    [
        ("bad/eighth/dimer_by_remark350.pdb", 11320.8, 146.8, 3),  # Shrake-Rupley on copies placed by hand
        ("structures/1a8o_mse.pdb", 8228.5, 556.1, 3),  # the same on the copies of gemmi
        ("structures/1a8o_mse.cif", 8228.5, 556.1, 3),
    ],
)
def test_areas_of_declared_dimers(shared, name, accessible, buried, tolerance):
    areas = sparsurf.areas(read_molecule(shared / "data" / name, assembly=True), radii="bondi")
    assert areas.accessible.sum() == pytest.approx(accessible, abs=tolerance)
    assert areas.chains["buried"].tolist() == pytest.approx([buried] * 2, abs=tolerance)
