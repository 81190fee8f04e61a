"""Objects of other libraries, as stand-ins with the attributes that are read: the libraries need not be installed."""

from dataclasses import replace
from types import SimpleNamespace

import gemmi
import mdtraj
import numpy as np
import pytest

from peptides import atom_line, peptide, write
from sparsurf.errors import InputError
from sparsurf.molecules.libraries import (
    from_biopython,
    from_biotite,
    from_gemmi,
    from_mdanalysis,
    from_mdtraj,
)
from sparsurf.molecules.read_molecule import read_molecule

BOX = np.diag([40.0, 41.0, 42.0])
OF_ATOMS = ("name", "residue_name", "chain", "element", "residue", "kind")


@pytest.fixture
def molecule(tmp_path):
    """Two residues 7 and 7B of chain C with a ligand, and B factors from 5 on."""
    lines = peptide(("ALA", "GLY"), "C", 7).replace("C   8 ", "C   7B")
    text = lines + atom_line("FE", "HEM", "C", "9", (5, 5, 5), record="HETATM", element="FE") + "END\n"
    read = read_molecule(write(tmp_path / "a.pdb", text), selection="all")
    return replace(read, b_factor=np.arange(5.0, 16.0))


def numbers_and_codes(molecule):
    return [7] * 10 + [9], ["" if label != "7B" else "B" for label in molecule.residue]


def check(found, molecule, n_frames=1):
    for name in OF_ATOMS:
        assert getattr(found, name).tolist() == getattr(molecule, name).tolist(), name
    assert found.b_factor.tolist() == molecule.b_factor.tolist()
    assert found.frame_number.tolist() == list(range(n_frames))
    np.testing.assert_allclose(found.xyz[0], molecule.xyz[0], atol=1e-9)


def array_of_biotite(molecule, **columns):
    number, code = numbers_and_codes(molecule)
    return SimpleNamespace(
        coord=molecule.xyz[0], box=None, atom_name=np.char.add(molecule.name, " "), res_name=molecule.residue_name,
        chain_id=molecule.chain, res_id=number, ins_code=code, element=np.char.lower(molecule.element),
        hetero=molecule.residue_name == "HEM", b_factor=molecule.b_factor, **columns,
    )  # fmt: skip


def test_arrays_of_biotite(molecule, caplog):
    given = array_of_biotite(molecule)
    check(from_biotite(given, selection="all"), molecule)
    assert np.isnan(from_biotite(given).time_ps).all() and all(
        record.levelname == "INFO" for record in caplog.records
    )
    assert "HEM" not in from_biotite(given).residue_name and from_biotite(given, ligands="HEM").n_atoms == 11
    given.coord = np.stack([molecule.xyz[0], molecule.xyz[0] + 3])
    check(two := from_biotite(given, selection="all"), molecule, 2)
    np.testing.assert_allclose(two.xyz[1], molecule.xyz[0] + 3)
    given.coord, given.box = molecule.xyz[0] % np.diag(BOX), BOX  # cut at 0 along y
    moved = molecule.xyz[0] - (0, 1, 0)
    given.coord = moved % np.diag(BOX)
    np.testing.assert_allclose(np.ptp(from_biotite(given).xyz[0] - moved[:10], axis=0), 0, atol=1e-9)
    given.coord, given.box = np.stack([given.coord, moved % np.diag(1.3 * BOX)]), np.stack([BOX, 1.3 * BOX])
    np.testing.assert_allclose(np.ptp(from_biotite(given).xyz - moved[:10], axis=1), 0, atol=1e-9)
    located = array_of_biotite(molecule, altloc_id=["."] * 8 + ["A", "B", "."], occupancy=np.full(11, 0.5))
    located.atom_name = np.array([*molecule.name[:9], molecule.name[8], "FE"])
    assert from_biotite(located).b_factor.tolist() == [5, 6, 7, 8, 9, 10, 11, 12, 13]
    with pytest.raises(InputError, match="masked coordinates: leave"):
        given.coord = np.ma.masked_greater(molecule.xyz[0], 4)
        from_biotite(given)


def group_of_mdanalysis(molecule, n_frames=1, **attributes):
    number, code = numbers_and_codes(molecule)
    step = SimpleNamespace(dimensions=None, data={"time": 12.5})
    trajectory = SimpleNamespace(ts=step, n_frames=n_frames)

    class Group(SimpleNamespace):
        def __len__(self):
            return len(self.names)

    group = Group(
        universe=SimpleNamespace(trajectory=trajectory), positions=molecule.xyz[0], names=molecule.name,
        resnames=molecule.residue_name, resids=number, icodes=code, elements=molecule.element,
        record_types=["ATOM"] * 10 + ["HETATM"], tempfactors=molecule.b_factor, segids=molecule.chain, **attributes,
    )  # fmt: skip
    group.atoms = group
    return group


def test_groups_of_mdanalysis(molecule):
    group = group_of_mdanalysis(molecule, chainIDs=["C"] * 11)
    check(found := from_mdanalysis(group, selection="all"), molecule)
    assert found.time_ps.tolist() == [12.5] and from_mdanalysis(group).n_atoms == 10
    check(from_mdanalysis(group_of_mdanalysis(molecule), selection="all"), molecule)  # chains are segments
    group.segids, group.chainIDs = ["SYSTEM"] * 11, ["SYSTEM"] * 11
    group.universe.trajectory.ts.data = {}
    found = from_mdanalysis(group)
    assert set(found.chain) == {""} and np.isnan(found.time_ps).all()
    group.universe = SimpleNamespace()
    with pytest.raises(InputError, match="the Universe has no coordinates: give it a trajectory"):
        from_mdanalysis(group)


@pytest.mark.parametrize(("n_frames", "joined"), [(1, False), (2, True)])
def test_molecules_of_a_moving_group_are_joined_and_those_of_a_crystal_are_not(molecule, n_frames, joined):
    """The ligand lies nearer to the protein over the border of the box, which cuts no bond."""
    molecule = replace(molecule, xyz=molecule.xyz + np.outer(np.arange(11) == 10, (0, 33.0, 0)))
    group = group_of_mdanalysis(molecule, n_frames)
    step = group.universe.trajectory.ts
    step.dimensions, step.triclinic_dimensions = np.diag(BOX), BOX
    found = from_mdanalysis(group, selection="all")
    assert found.xyz[0, 10, 1] == pytest.approx(38 - 41 if joined else 38)


class Parts(SimpleNamespace):
    """What iterates over its parts, as entities of Biopython do."""

    def __iter__(self):
        return iter(self.parts)

    def get_unpacked_list(self):
        return self.parts


def structure_of_biopython(molecule, shifts=(0, 3)):
    models = []
    for shift in shifts:
        atoms = [
            SimpleNamespace(
                name=name, element=element.capitalize(), altloc=" ", occupancy=None, coord=xyz + shift, bfactor=b,
            )
            for name, element, xyz, b in zip(
                molecule.name, molecule.element, molecule.xyz[0], molecule.b_factor, strict=True
            )
        ]  # fmt: skip
        ids = (
            ((" ", 7, " "), atoms[:5], "ALA"),
            ((" ", 7, "B"), atoms[5:10], "GLY"),
            (("H_HEM", 9, " "), atoms[10:], "HEM"),
        )
        residues = [Parts(id=each, parts=part, resname=name, segid="    ") for each, part, name in ids]
        models.append(Parts(level="M", parts=[Parts(level="C", id="C", parts=residues)]))
    return Parts(level="S", parts=models)


def test_entities_of_biopython(molecule, caplog):
    structure = structure_of_biopython(molecule)
    check(whole := from_biopython(structure, selection="all"), molecule, 2)
    np.testing.assert_allclose(whole.xyz[1], molecule.xyz[0] + 3)
    assert from_biopython(structure).n_atoms == 10 and "occupancy" not in caplog.text
    model = structure.parts[0]
    for entity in (model, model.parts[0]):
        check(from_biopython(entity, selection="all"), molecule)
    atoms = model.parts[0].parts[1].parts
    twin = SimpleNamespace(**vars(atoms[4]) | {"altloc": "B", "occupancy": 0.7, "bfactor": 99.0})
    atoms[4].altloc, atoms[4].occupancy = "A", 0.3
    atoms.append(twin)
    assert from_biopython(model).b_factor.tolist()[-1] == 14  # the first location
    with pytest.raises(InputError, match="structure of Biopython"):
        from_biopython(Parts(level="S", parts=[]))


def test_structures_of_gemmi(molecule, tmp_path):
    molecule.write_pdb(tmp_path / "a.pdb")
    structure = gemmi.read_pdb(str(tmp_path / "a.pdb"))
    check(from_gemmi(structure, selection="all"), molecule)
    check(from_gemmi(structure[0], selection="all"), molecule)
    assert from_gemmi(structure).n_atoms == 10
    free = gemmi.read_pdb_string(peptide(["ALA"]) + "END\n")
    assert from_gemmi(free).n_atoms == 5
    with pytest.raises(
        InputError, match="there is no protein"
    ):  # a free amino acid, which the file calls a hetero group
        from_gemmi(gemmi.read_pdb_string(peptide(["ALA"], record="HETATM") + "END\n"))
    structure.add_model(structure[0])
    for atom in (atom for chain in structure[1] for residue in chain for atom in residue):
        atom.pos += gemmi.Position(0, 0, 4)
    structure[1].num = 2
    assert from_gemmi(structure).xyz[:, 0, 2].tolist() == pytest.approx([0, 4])
    moved = molecule.xyz[0, :10] - (0, 1, 0)
    for atom, xyz in zip(
        (atom for residue in structure[0][0] for atom in residue), moved % np.diag(BOX), strict=False
    ):
        atom.pos = gemmi.Position(*xyz)
    structure.cell = gemmi.UnitCell(*np.diag(BOX), 90, 90, 90)
    del structure[1]
    np.testing.assert_allclose(np.ptp(from_gemmi(structure).xyz[0] - moved, axis=0), 0, atol=1e-6)


def test_times_and_boxes_of_mdtraj_are_in_ps_and_angstrom(molecule, tmp_path):
    molecule.take(np.arange(10)).write_pdb(tmp_path / "a.pdb")
    given = mdtraj.load(str(tmp_path / "a.pdb"))
    given = mdtraj.join([given, given])
    moved = molecule.xyz[:, :10] - np.array([[[0, 1, 0]], [[0, 1.5, 0]]])
    given.xyz, given.time = (moved % np.diag(BOX)) / 10, np.array([4.0, 6.5])
    given.unitcell_vectors = np.stack([BOX, BOX]) / 10
    found = from_mdtraj(given)
    assert found.time_ps.tolist() == [4, 6.5] and found.frame_number.tolist() == [0, 1]
    np.testing.assert_allclose(np.ptp(found.xyz - moved, axis=1), 0, atol=1e-4)
    given.xyz, given.unitcell_vectors = (moved + 50) / 10, None
    np.testing.assert_allclose(from_mdtraj(given).xyz, moved + 50, atol=1e-4)
