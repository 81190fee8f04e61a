"""Reading of structures and trajectories: what is read, what is chosen, and that it is Å."""

import logging
import struct

import mdtraj
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from peptides import ALANINE, atom_line, peptide, write
from sparsurf.errors import InputError, naming_file
from sparsurf.molecules import pdb
from sparsurf.molecules.atom_table import box_vectors
from sparsurf.molecules.libraries import from_mdtraj
from sparsurf.molecules.mdtraj_process import iterate_frames
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.parm7 import read_parm7
from sparsurf.molecules.pdb import read_pdb, write_pdb
from sparsurf.molecules.psf import read_psf
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.source import open_source
from sparsurf.molecules.trajectory import FrameStore, read_first_frame
from sparsurf.molecules.unwrapping import Unwrapping, has_no_box, make_whole

NAMES = ("name", "residue_name", "chain", "element", "residue", "residue_index", "kind")


def equal_names(first, second):
    return [each for each in NAMES if not np.array_equal(getattr(first, each), getattr(second, each))] == []


@pytest.fixture
def example(shared):
    return shared / "example" / "topology.pdb", shared / "example" / "trajectory.xtc"


# --- files ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("extension", ["xtc", "trr", "dcd", "nc", "h5", "gro", "lammpstrj", "xyz", "pdb"])
def test_twins_give_equal_frames(example, tmp_path, extension):
    """One trajectory in every format: equal to the precision that the format stores."""
    topology, trajectory = example
    original = mdtraj.load(str(trajectory), top=str(topology))[:9]
    twin = tmp_path / f"twin.{extension}"
    original.save(str(twin))
    expected = original.xyz[::4].astype(float) * 10
    molecule = (
        read_molecule(twin, stride=4) if extension == "pdb" else read_molecule(topology, twin, stride=4)
    )
    precision = {"xtc": 0.0051, "gro": 0.0051, "pdb": 0.00051}.get(
        extension, 1e-4
    )  # Å, half of the last digit
    assert molecule.frame_number.tolist() == [0, 4, 8]
    moved = molecule.xyz - expected
    assert np.abs(moved).max() < precision
    if extension in ("xtc", "trr", "nc", "h5", "gro"):
        assert molecule.time_ps.tolist() == [0, 4, 8]
    else:
        assert np.isnan(molecule.time_ps).all()


def test_frames_at_some_times_are_those_of_the_whole(example):
    topology, trajectory = example
    whole = read_molecule(topology, trajectory)
    few = read_molecule(topology, trajectory, times=[-1, 7, 350.0, 700.012, 999.996, 5000])
    assert few.frame_number.tolist() == few.time_ps.tolist() == [0, 7, 350, 1000]
    assert np.array_equal(few.xyz, whole.xyz[few.frame_number]) and equal_names(few, whole)


@pytest.mark.parametrize("entry", [("1BD2.pdb.gz", "1BD2.cif.gz"), ("1a8o_mse.pdb", "1a8o_mse.cif")])
def test_pdb_and_mmcif_of_one_entry_are_equal(shared, entry):
    first, second = (read_molecule(shared / "data" / "structures" / each) for each in entry)
    assert equal_names(first, second)
    assert np.array_equal(first.xyz, second.xyz)


def test_names_and_coordinates_agree_with_mdtraj(shared):
    """Outside oracle: mdtraj's own reader, in nm and float32 (1e-5 Å of 100 Å)."""
    for name in ("1ubi.pdb", "3nzmA_negres.pdb.gz", "ala3_3res.pdb", "2beg_fibril5chains.pdb"):
        path = shared / "data" / "structures" / name
        ours, theirs = read_molecule(path, selection="all"), mdtraj.load(str(path), standard_names=False)
        assert np.allclose(ours.xyz[0], theirs.xyz[0].astype(float) * 10, atol=2e-5)
        assert ours.name.tolist() == [atom.name for atom in theirs.topology.atoms]
        assert ours.element.tolist() == [atom.element.symbol.upper() for atom in theirs.topology.atoms]


@given(
    st.lists(st.tuples(st.sampled_from(["N", "CA", "HG11", "CD1", "OXT"]), st.sampled_from(["ALA", "HISD", "TIP3", "NALA",
     "DA", "A"]), st.sampled_from(["", "A", "b", "7"]), st.integers(-999, 2_000_000), st.sampled_from(["", "A", "Z"]),
     st.tuples(*[st.integers(-999_999, 9_999_999)] * 3)), min_size=1, max_size=20)
)  # fmt: skip
@settings(max_examples=80)
def test_pdb_written_is_pdb_read(tmp_path_factory, rows):
    """Round trip of every name, number (hybrid-36 beyond 9999) and coordinate that the columns hold."""
    names, residue_labels, chains, numbers, codes, places = zip(*rows, strict=True)
    residues = [str(number) + code for number, code in zip(numbers, codes, strict=True)]
    xyz = np.array(places) / 1000
    molecule = Molecule(
        xyz[None], np.zeros(1), np.zeros(1, int), *map(np.array, (names, residue_labels, chains)),
        np.array([name[:1] for name in names]), np.array(residues), np.arange(len(rows)),
        np.array(["protein"] * len(rows)), np.full(len(rows), 12.5),
    )  # fmt: skip
    path = tmp_path_factory.mktemp("pdb") / "a.pdb"
    write_pdb(path, xyz, molecule)
    atoms = read_pdb(path.read_text()).atoms
    assert atoms.name.tolist() == list(names) and atoms.residue_name.tolist() == list(residue_labels)
    assert atoms.chain.tolist() == list(chains) and atoms.residue.tolist() == residues
    assert np.array_equal(atoms.xyz, xyz)
    molecule.write_pdb(path)  # with the molecule's own B factors
    assert (read_pdb(path.read_text()).atoms.b_factor == 12.5).all()


def test_real_structures_agree_with_their_twins_and_pass_unchanged(shared, tmp_path):
    for path in sorted((shared / "data" / "structures").iterdir()):
        if "ribosome" in path.name:
            continue
        molecule = read_molecule(path)
        molecule.write_pdb(tmp_path / "back.pdb", frame=molecule.n_frames - 1)
        back = read_molecule(tmp_path / "back.pdb")
        assert equal_names(back, molecule), path.name
        assert np.array_equal(back.xyz[0], np.round(molecule.xyz[-1], 3)), path.name
    for name in ("1ubi.pdb", "1BD2.cif.gz", "1hvr_dimer_ligand_CSO.pdb", "7etn_tiny.cif.gz", "4cup.cif"):
        path = shared / "data" / "structures" / name
        assert np.array_equal(read_molecule(path).xyz, read_molecule(path, whole=False).xyz)


def test_end_and_model_separate_frames(tmp_path):
    for separators, numbers in (
        (("", "END\n", "END\n"), (1, 2)),
        (("MODEL        3\n", "ENDMDL\nMODEL        7\n", "ENDMDL\n"), (3, 7)),
        (("MODEL 3\n", "ENDMDL\nMODEL 7\n", "ENDMDL\n"), (3, 7)),
    ):
        text = separators[0] + peptide() + separators[1] + peptide(origin=(1, 0, 0)) + separators[2]
        path = write(tmp_path / "a.pdb", text)
        molecule = read_molecule(path)
        assert molecule.n_frames == len(molecule.time_ps) == 2
        assert np.allclose(molecule.xyz[1] - molecule.xyz[0], (1, 0, 0))
        for number, xyz in zip(numbers, molecule.xyz, strict=True):
            assert np.array_equal(read_molecule(path, model=number).xyz[0], xyz)
    assert read_molecule(path, model=7).frame_number.tolist() == [1]


@pytest.mark.parametrize(
    ("given", "called"),
    [((1, 1), (1, 2)), ((2, 2, 3), (2, 3, 4)), ((5, 3), (5, 3)), ((1, 1, 2), (1, 2, 3)), (("", ""), (1, 2))],
)
def test_models_of_equal_numbers_are_models_of_their_own(tmp_path, caplog, given, called):
    """Each is a frame; a number stays with the first that has it, the later one gets the next free one and it is said."""
    models = [f"MODEL {number:>8}\n{peptide(origin=(k, 0, 0))}ENDMDL\n" for k, number in enumerate(given)]
    path = write(tmp_path / "a.pdb", "".join(models))
    with caplog.at_level(logging.WARNING, "sparsurf"):
        molecule = read_molecule(path)
    assert (molecule.xyz[:, 0, 0] - molecule.xyz[0, 0, 0]).tolist() == list(range(len(given)))
    assert ("several models of the number" in caplog.text) == (given != called and given[0] != "")
    for k, number in enumerate(called):
        one = read_molecule(path, model=number)
        assert np.array_equal(one.xyz, molecule.xyz[k : k + 1])
        assert one.frame_number.tolist() == [k]


@pytest.mark.parametrize(
    ("numbers", "step"), [((1, 2, 3), (0, 9, 0)), ((7, 3, 5), (0, 0, 2.9))]
)  # at 2.9 Å a few atoms touch
def test_the_chains_of_an_assembly_have_the_place_of_their_model(tmp_path, numbers, step):
    models = (
        f"MODEL {number:>8}\n{peptide(origin=k * np.array(step))}ENDMDL\n" for k, number in enumerate(numbers)
    )
    molecule = read_molecule(write(tmp_path / "a.pdb", "".join(models)), assembly=True)
    assert [*dict.fromkeys(molecule.chain.tolist())] == ["A", "A-2", "A-3"]
    assert molecule.xyz[0, ::20] == pytest.approx(np.outer(range(3), step))


def test_atoms_of_later_models_are_found_where_the_first_was_put_in_order(tmp_path):
    """The first residue stands behind the others: in each model its atoms come first."""
    models = []
    for k in (1, 2):
        lines = peptide(origin=(0, 0, 5.0 * k)).splitlines(keepends=True)
        first = [line for line in lines if line.startswith("ATOM") and line[22:26] == lines[0][22:26]]
        rest = [line for line in lines if line not in first and not line.startswith("TER")]
        models.append(f"MODEL {k:>8}\n{''.join(rest + first)}ENDMDL\n")
    molecule = read_molecule(write(tmp_path / "a.pdb", "".join(models)))
    in_order = read_molecule(write(tmp_path / "b.pdb", peptide(origin=(0, 0, 5.0))))
    assert molecule.residue.tolist() == in_order.residue.tolist()
    assert molecule.xyz == pytest.approx(in_order.xyz[[0, 0]] + [[[0, 0, 0]], [[0, 0, 5]]], abs=2e-3)


def test_each_copy_of_a_chain_gets_a_free_letter_and_the_ligand_beside_it(tmp_path):
    copies = [peptide(chain=chain, origin=(0, 30 * k, 0)) for k, chain in enumerate("AABB")]
    ligands = "".join(
        atom_line(name, "LIG", "A", str(20 + k), (5, 30 * k, z), record="HETATM")
        for k in (1, 0) for name, z in (("C1", 5), ("C2", 6))
    )  # fmt: skip
    molecule = read_molecule(
        write(tmp_path / "a.pdb", "TER\n".join([*copies, ligands]) + "END\n"), ligands=True
    )
    of_copies = molecule.kind == "protein"
    assert [*dict.fromkeys(molecule.chain[of_copies].tolist())] == ["A", "C", "B", "D"]
    assert molecule.chain[~of_copies].tolist() == ["C", "C", "A", "A"]


@pytest.mark.parametrize("max_pairs", [1_000_000, 0])
def test_residues_stand_in_the_order_of_their_bonds(tmp_path, monkeypatch, max_pairs):
    """One chain has its residues backwards, the other in two pairs; many ends of chains are compared by a tree."""
    monkeypatch.setattr("sparsurf.molecules.residues.MAX_PAIRS_OF_ENDS", max_pairs)
    lines = [peptide(chain=c, origin=(0, 0, z)).splitlines(True) for c, z in (("A", 0), ("B", 9))]
    orders = zip(lines, ((3, 2, 1, 0), (2, 3, 0, 1)), strict=True)
    text = "".join("".join(each[5 * k : 5 * k + 5]) for each, order in orders for k in order)
    molecule = read_molecule(write(tmp_path / "a.pdb", text + "END\n"))
    assert molecule.residue[::5].tolist() == 2 * ["1", "2", "3", "4"]
    assert molecule.chain[::20].tolist() == ["A", "B"] and molecule.xyz[0, ::20, 2].tolist() == [0, 9]


def test_atoms_of_a_trajectory_are_found_where_its_topology_was_put_in_order(tmp_path):
    """The first residue stands behind the others, then all CB; one of them has two locations, which frames have once."""
    lines, order = peptide().splitlines(True), [*range(5, 20), *range(5)]
    order = sorted(order, key=lambda k: k % 5 == 4)
    located = [f"{lines[9][:16]}{letter}{lines[9][17:]}" for letter in "AB"]
    lines[9] = located[0] + located[1].replace(" 1.200 ", " 1.700 ")
    topology = write(tmp_path / "a.pdb", "".join(lines[k] for k in order) + "END\n")
    whole = read_molecule(write(tmp_path / "b.pdb", peptide() + "END\n"))
    frames = whole.xyz[0, order] + 5.0 * np.arange(3)[:, None, None]
    given = mdtraj.Trajectory(frames / 10, mdtraj.load(str(tmp_path / "b.pdb")).topology)
    given.save(str(tmp_path / "a.trr"))
    for selection in (None, "name CB N"):
        read = read_molecule(topology, tmp_path / "a.trr", selection=selection)
        chosen = whole if selection is None else whole.select(selection=selection)
        assert equal_names(read, chosen)
        assert read.xyz == pytest.approx(chosen.xyz[0] + 5.0 * np.arange(3)[:, None, None], abs=1e-4)


# --- what is chosen ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("residues", "expected"),  # in one chain or, if they are named, in two
    [
        ("-5", ["-5"]), ("-5-3", ["-5", "-4", "3"]), ("-5--4", ["-5", "-4"]), ("A:3-52", ["3", "52"]),
        ("A:3-52A", ["3", "52", "52A"]), ("52a-52b", ["52A", "52B"]), ("A:3,52B,B:60", ["3", "52B", "60"]),
        (["A:3", "B:60"], ["3", "60"]), ("3,60", ["A 3", "A 60", "B 3", "B 60"]), ("A:3,60", ["A 3", "A 60"]),
        (["A:3", "60"], ["A 3", "A 60"]), ("60,A:3", ["A 3", "A 60", "B 60"]), ("A:3,B:60,3", ["A 3", "B 3", "B 60"]),
    ],
)  # fmt: skip
def test_residue_ranges(tmp_path, caplog, residues, expected):
    labels = [("A", "-5"), ("A", "-4"), ("A", "3"), ("A", "52"), ("A", "52A"), ("A", "52B"), ("B", "60")]
    twice = " " in expected[0]
    labels = [("A", "3"), ("A", "60"), ("B", "3"), ("B", "60")] if twice else labels
    text = "".join(
        atom_line(name, chain=chain, residue=label, place=np.add(place, (0, 0, 9 * i)))
        for i, (chain, label) in enumerate(labels)
        for name, place in ALANINE.items()
    )
    molecule = read_molecule(write(tmp_path / "a.pdb", text), residues=residues)
    found = zip(molecule.chain.tolist(), molecule.residue.tolist(), strict=True)
    assert list(dict.fromkeys(" ".join(each) if twice else each[1] for each in found)) == expected
    assert "has no residue" not in caplog.text  # in either case of an insertion code


# --- elements and radii --------------------------------------------------------------------------------


# --- periodic box --------------------------------------------------------------------------------------


def wrapped(xyz, box, shift):
    fraction = (xyz + shift) @ np.linalg.inv(box)
    return (fraction - np.floor(fraction)) @ box


def test_molecules_cut_by_the_box_are_made_whole(example):
    """The example, which is whole, wrapped into its rhombic box at random and put together again."""
    topology, trajectory = example
    molecule = read_molecule(topology, trajectory, stride=50)
    box = mdtraj.load(str(trajectory), top=str(topology), stride=50).unitcell_vectors.astype(float) * 10
    shift = np.random.default_rng(1).uniform(0, 60, (len(box), 1, 3))
    cut = wrapped(molecule.xyz, box, shift)
    moved = make_whole(cut, box, molecule.residue_index) - molecule.xyz
    assert np.ptp(cut - molecule.xyz, axis=1).max() > 30
    assert np.ptp(moved, axis=1).max() < 1e-10  # one translation for all atoms; sums of 60 Å in float64
    assert np.array_equal(make_whole(molecule.xyz, box, molecule.residue_index), molecule.xyz)


@pytest.mark.skipif(mdtraj.__version__.startswith("1.10."), reason="its molecules stay cut by the box")
def test_whole_agrees_with_mdtraj(example, tmp_path):
    """Outside oracle: mdtraj's own algorithm along the bonds of its templates, in float32."""
    topology, trajectory = example
    theirs = mdtraj.load(str(trajectory), top=str(topology), stride=100)
    box = theirs.unitcell_vectors.astype(float) * 10
    theirs.xyz = wrapped(theirs.xyz.astype(float) * 10, box, 25.0).astype(np.float32) / 10
    theirs.save(str(tmp_path / "cut.trr"))
    ours = read_molecule(topology, tmp_path / "cut.trr").xyz
    moved = ours - theirs.make_molecules_whole(inplace=False).xyz.astype(float) * 10
    assert np.ptp(moved, axis=1).max() < 1e-3  # float32 of 100 Å, and sums of lattice vectors


def test_the_edges_of_a_box_may_touch_in_their_columns():
    box = pdb._box("CRYST111111.11122222.22233333.333  90.00  90.00  90.00 P 1           1")
    np.testing.assert_allclose(box, np.diag([11111.111, 22222.222, 33333.333]), rtol=0, atol=1e-5)
    oblique = pdb._box("CRYST1   30.000   40.000   50.00070.000080.0000100.000P 1")
    assert np.array_equal(oblique, box_vectors(30, 40, 50, 70, 80, 100))
    assert pdb._box("CRYST1   30.000   40.000") is None


def test_a_dummy_box_and_an_impossible_one_are_none(caplog):
    for cell in ((1, 1, 1, 90, 90, 90), (1, 30, 30, 90, 90, 90), (0, 0, 0, 0, 0, 0)):
        assert box_vectors(*cell) is None and not caplog.text
    for angles in (
        (60, 60, 150), (0, 90, 90), (90, 180, 90), (120, 120, 120), (170, 170, 170), (90, 90, 180),
    ):  # fmt: skip
        with naming_file("a.pdb"):
            assert box_vectors(30, 40, 50, *angles) is None
        said = f"a.pdb: a box of 30, 40, 50 Å with angles of {', '.join(map(str, angles))}° is impossible"
        assert said in caplog.messages[-1]


def test_a_trajectory_in_memory_has_an_atom_and_nanometres(tmp_path):
    given = mdtraj.load(str(write(tmp_path / "a.pdb", peptide() + "END\n")))
    assert from_mdtraj(given.atom_slice([4])).n_atoms == 1
    for n_atoms, n_frames in ((0, 1), (20, 0)):
        with pytest.raises(InputError, match=f"{n_frames} frames of {n_atoms} atoms: give one with both"):
            from_mdtraj(given.atom_slice(range(n_atoms))[:n_frames])
    given.xyz /= 10
    with pytest.raises(InputError, match="lengths in nm,"):
        from_mdtraj(given)


def test_a_trajectory_is_left_as_it_is_where_asked_and_a_gro_file_may_give_the_names(tmp_path):
    path, box = write(tmp_path / "a.pdb", peptide() + "END\n"), np.diag([40.0, 40, 40])
    whole = read_molecule(path).xyz
    cut = wrapped(whole, box, (36, 5, 5))
    one = mdtraj.load(str(path))
    one.xyz, one.unitcell_vectors = cut / 10, box[None] / 10
    one.save(str(tmp_path / "a.gro"))
    both = mdtraj.join([one, one])
    both.xyz[1] += 0.01
    both.save(str(tmp_path / "a.xtc"))
    assert np.ptp(cut - whole, axis=1).max() > 30
    for names in (path, tmp_path / "a.gro"):
        as_it_is = read_molecule(names, tmp_path / "a.xtc", whole=False).xyz
        assert as_it_is == pytest.approx(np.concatenate([cut, cut + 0.1]), abs=0.006)
        joined = read_molecule(names, tmp_path / "a.xtc").xyz
        assert len(joined) == 2 and np.ptp(joined - whole, axis=1).max() < 0.012
    assert read_first_frame(open_source(tmp_path / "a.xtc"), 20, path) == pytest.approx(cut[0], abs=0.006)


@pytest.mark.parametrize(
    ("name", "frames", "last"),
    [("adk.psf", "adk_dims.dcd", "214"), ("tz2.parm7", "tz2.nc", "13"), ("DPDP.parm7", "DPDP.nc", "22")],
)
def test_residues_of_a_topology_are_numbered_from_1(shared, name, frames, last):
    folder = shared / "data" / "trajectories"
    residue = read_molecule(folder / name, folder / frames, selection="all", stride=1000).residue
    assert (residue[0], residue[-1]) == ("1", last)


def test_frames_beyond_some_bytes_lie_in_a_file(monkeypatch):
    parts = [
        np.arange(24.0).reshape(2, 4, 3),
        100 + np.arange(12.0).reshape(1, 4, 3),
        np.full((2, 4, 3), 7.5),
    ]
    for limit, in_file in ((480, False), (479, True), (100, True)):
        monkeypatch.setattr("sparsurf.molecules.trajectory.BYTES_IN_MEMORY", limit)
        store = FrameStore()
        for part in parts:
            store.append(part)
        frames = store.frames()
        assert isinstance(frames, np.memmap) == in_file and np.array_equal(frames, np.concatenate(parts))

    def full(**_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.TemporaryFile", full)
    said = r"frames of run\.xtc do not fit into .* \(No space left on device\): set"
    with naming_file("run.xtc"), pytest.raises(InputError, match=said):
        FrameStore().append(parts[0])


@pytest.mark.parametrize(("n_residues", "kept"), [(1, [0, 1, 2]), (2, [0, 2])])
def test_few_atoms_may_stand_still(tmp_path, n_residues, kept):
    """Ten atoms that repeat their places to the last bit are the same frame again."""
    one = mdtraj.load(str(write(tmp_path / "a.pdb", peptide(["ALA"] * n_residues) + "END\n")))
    frames = mdtraj.join([one, one, one])
    frames.xyz[2] += 0.1
    frames.time = np.array([0.0, 2, 4])
    frames.save(str(tmp_path / "a.trr"))
    read = read_molecule(tmp_path / "a.pdb", tmp_path / "a.trr")
    assert read.frame_number.tolist() == kept
    assert read.time_ps.tolist() == [2 * number for number in kept]


def test_what_is_left_out_is_reported_of_the_first_model_alone(tmp_path, caplog):
    water = [atom_line("O", "HOH", residue=str(k), place=(k, 9, 9), record="HETATM") for k in (8, 9)]
    models = (f"MODEL {k}\n{peptide(origin=(k, 0, 0))}{''.join(water[:k])}ENDMDL\n" for k in (1, 2))
    path = write(tmp_path / "a.pdb", "".join(models))
    with caplog.at_level(logging.INFO, "sparsurf"):
        assert read_molecule(path).n_frames == 2
    assert caplog.messages == [f"{path}: left out 1 HOH"]
    caplog.clear()
    with caplog.at_level(logging.INFO, "sparsurf"):
        assert read_molecule(path, residues="A:1-2").n_residues == 2
    assert caplog.messages == []  # of what lies outside of the range


def test_a_box_and_a_bond_are_longer_than_some_length():
    """Two atoms of a residue across the border: 2.4 Å apart they are bonded, 2.6 Å apart they are not."""
    for side, gap, whole in ((16.0, 2.4, True), (14.9, 2.4, False), (16.0, 2.6, False)):
        xyz = np.array([[[0.1, 0, 0], [side + 0.1 - gap, 0, 0]]])
        made = make_whole(xyz, side * np.eye(3)[None], np.zeros(2, int), join=False)
        assert made[0, 1, 0] == pytest.approx(0.1 - gap if whole else side + 0.1 - gap)
        short = np.diag([side, side, 14.9])[None]  # one dummy among the lattice vectors is enough
        assert np.array_equal(make_whole(xyz, short, np.zeros(2, int), join=False), xyz)


def test_a_box_is_missing_where_that_of_one_frame_is_flat_short_or_no_number():
    good = np.diag([40.0, 40, -40])  # left-handed
    assert not has_no_box(np.stack([good, good]))
    flat, short, unknown = good.copy(), good.copy(), good.copy()
    flat[2], short[1, 1], unknown[0, 0] = (40.0, 40, 1e-7), 14.9, np.nan
    for bad in (flat, short, unknown):
        assert has_no_box(np.stack([good, bad]))


@pytest.mark.parametrize(("count", "joined"), [(2, True), (100, True), (101, False)])
def test_as_many_as_a_hundred_molecules_are_joined(count, joined):
    xyz = np.zeros((1, count, 3))
    xyz[0, :, 0] = np.append(5.0 * np.arange(count - 1), 595.0)  # the last one lies before the first
    made = make_whole(xyz, 600 * np.eye(3)[None], np.arange(count))
    assert made[0, -1, 0] == (-5 if joined else 595)


@pytest.mark.parametrize("n", [16, 301])
def test_a_molecule_is_joined_where_it_is_nearest_over_the_border_of_the_box(n):
    # a rod, and an atom 5.4 Å behind its first atom or, over the border, 4.6 Å before its last
    rod = np.column_stack([2.0 * np.arange(n)[::-1], np.zeros(n), np.zeros(n)])
    xyz = np.concatenate([rod, np.add(rod[:1], (5.4, 0, 0))])
    joined = make_whole(xyz[None], (2 * n + 8) * np.eye(3)[None], np.arange(n + 1))[0]
    assert joined[:-1].tolist() == rod.tolist() and joined[-1] == pytest.approx([-4.6, 0, 0])


def dcd(xyz, cells):
    """Return a DCD file of frames (F, A, 3), Å, with six numbers in the cell of each."""

    def record(content):
        return struct.pack("<i", len(content)) + content + struct.pack("<i", len(content))

    control = [len(xyz), 0, 1, len(xyz), *[0] * 5, 1_025_758_986, 1, *[0] * 8, 24]
    head = record(b"CORD" + struct.pack("<20i", *control)) + record(struct.pack("<i", 1) + b"*".ljust(80))
    frames = (
        record(np.array(cell, "<f8").tobytes())
        + b"".join(record(axis.astype("<f4").tobytes()) for axis in frame.T)
        for frame, cell in zip(xyz, cells, strict=True)
    )
    return head + record(struct.pack("<i", xyz.shape[1])) + b"".join(frames)


def root(box):
    """Return the symmetric matrix whose rows are lattice vectors of the same cell."""
    values, vectors = np.linalg.eigh(box @ box.T)
    return vectors @ np.diag(np.sqrt(values)) @ vectors.T


CELLS = {  # angles of cells in degrees
    "octahedron": (109.4712206, 109.4712206, 109.4712206), "dodecahedron": (60, 90, 60), "hexagonal": (90, 90, 120),
    "cube": (90, 90, 90), "triclinic": (75, 80, 105),
}  # fmt: skip


@pytest.mark.parametrize("shape", CELLS)
@pytest.mark.parametrize("form", ["matrix of CHARMM", "degrees", "cosines of NAMD"])
def test_the_cell_of_a_dcd_file_is_a_matrix_or_lengths_and_angles(tmp_path, shape, form):
    """Two chains that the border cuts are put together again whichever way the cell is written."""
    box = box_vectors(60, 62, 64, *CELLS[shape])
    a, b = (peptide(chain=chain, origin=(0, 0, 4 * (chain == "B"))) for chain in "AB")
    path = write(tmp_path / "a.pdb", a + b + "END\n")
    whole = read_molecule(path).xyz[0]
    matrix = root(box)
    lattice = matrix if form.startswith("matrix") else box
    cosines = np.cos(np.radians(CELLS[shape]))
    numbers = {
        "matrix of CHARMM": [
            matrix[0, 0],
            matrix[0, 1],
            matrix[1, 1],
            matrix[0, 2],
            matrix[1, 2],
            matrix[2, 2],
        ],
        "degrees": [60, CELLS[shape][2], 62, CELLS[shape][1], CELLS[shape][0], 64],
        "cosines of NAMD": [60, cosines[2], 62, cosines[1], cosines[0], 64],
    }[form]
    cut = np.stack([wrapped(whole, lattice, shift) for shift in ((-3, -1, -2), (20, 25, 30), (59, 61, 1))])
    (tmp_path / "a.dcd").write_bytes(dcd(cut, [numbers] * 3))
    moved = read_molecule(path, tmp_path / "a.dcd").xyz - whole
    assert np.ptp(moved, axis=1).max() < 1e-3 and np.ptp(cut - whole, axis=1).max() > 30
    sound = np.stack([whole, whole + 100, whole - 7.0])
    (tmp_path / "b.dcd").write_bytes(dcd(sound, [numbers] * 3))
    np.testing.assert_allclose(read_molecule(path, tmp_path / "b.dcd").xyz, sound, atol=2e-5)  # float32


def test_each_frame_is_made_whole_by_its_own_box():
    """As under constant pressure: the box of the second frame is wider, that of the third oblique."""
    rod = np.column_stack([1.5 * np.arange(20.0), np.zeros(20), np.zeros(20)])
    whole, boxes = np.stack([rod, rod, rod]), np.stack([size * np.eye(3) for size in (40.0, 62.0, 50.0)])
    boxes[2, 1, 0] = 9.0
    cut = np.stack([wrapped(rod, box, (35, 48, 5)) for box in boxes])
    moved = make_whole(cut, boxes, np.repeat(np.arange(4), 5)) - whole
    assert np.ptp(moved, axis=1).max() < 1e-10 and (np.ptp(cut - whole, axis=1).max(axis=1) > 30).all()


def test_frames_that_are_whole_are_never_moved():
    """A box that is not that of the coordinates leaves whole bonds alone, in the first frame and in later ones."""
    rod = np.column_stack([1.5 * np.arange(60.0), np.zeros(60), np.zeros(60)])
    index = np.repeat(np.arange(12), 5)
    frames = np.stack([rod, rod + 3.0, rod[:, ::-1] + 90])
    for side in (16.0, 20.0, 45.0, 90.0, 400.0):
        box = np.repeat(side * np.eye(3)[None], 3, axis=0)
        assert np.array_equal(make_whole(frames, box, index), frames)
        skew = box.copy()
        skew[:, 1] = 0.98 * side, 0.05 * side, 0  # lattice vectors whose difference is as short as a bond
        along_y = frames[..., [1, 0, 2]]
        assert np.array_equal(make_whole(along_y, skew, index), along_y)


@pytest.mark.parametrize(("gap", "joined"), [(1.6, True), (1.7, False)])
def test_a_bond_over_the_border_tells_the_box_of_a_simulation(gap, joined):
    """Atoms of two residues that the border separates, and one of a molecule that is nearer over another border."""
    xyz = np.array([[[0.5, 0.5, 5], [40.5 - gap, 0.5, 5], [0.5, 37.5, 5]]])
    made = make_whole(xyz, 40 * np.eye(3)[None], np.arange(3), join=False)[0]
    assert made[1] == pytest.approx([0.5 - gap, 0.5, 5])  # whatever they are, they belong together
    assert made[2, 1] == (-2.5 if joined else 37.5)


@pytest.mark.parametrize(("side", "refused"), [(50.9, True), (51.2, False)])
def test_atoms_of_two_molecules_less_than_an_angstrom_apart_lie_on_each_other(side, refused):
    piece = np.column_stack([1.5 * np.arange(20.0), np.zeros(20), np.zeros(20)])
    two = np.concatenate([piece, piece + np.array([0, 50, 0])])
    repair = Unwrapping(two, 100 * np.eye(3), np.repeat(np.arange(8), 5))
    box = np.diag([200.0, side, 200.0])[None]
    if refused:
        with pytest.raises(InputError, match="molecule onto another"):
            repair(two[None], box)
    else:
        assert np.ptp(repair(two[None], box)[0, :, 1]) == pytest.approx(side - 50)


def test_a_repair_that_makes_a_frame_worse_is_refused():
    piece = np.column_stack([1.5 * np.arange(20.0), np.zeros(20), np.zeros(20)])
    index = np.repeat(np.arange(8), 5)
    two = np.concatenate([piece, piece + np.array([0, 50, 0])])  # a box of 50 Å would lay one onto the other
    said = r"run.xtc: the box .* in frame 7 .* lay atoms of one molecule onto another"
    with naming_file("run.xtc"), pytest.raises(InputError, match=said):
        Unwrapping(two, 100 * np.eye(3), index)(two[None], np.diag([200.0, 50.0, 200.0])[None], np.array([7]))
    square = np.array([[0.0, 0, 0], [1.5, 0, 0], [1.5, 1.5, 0], [0, 1.5, 0]])
    lost = square - np.array(
        [[49.0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]
    )  # farther than half of the box from two only
    box = 100 * np.eye(3)
    repair = Unwrapping(square, box, np.zeros(4, int))
    assert np.array_equal(repair(square[None], box[None]), square[None])
    with pytest.raises(InputError, match=r"in frame 3 .* would stretch a bond to 98.5 Å"):
        repair(lost[None], box[None], np.array([3]))


@pytest.fixture
def in_parts(monkeypatch):
    """Frames come from the other process two by two, as those of a large file come in parts."""

    def parts(*given, **keys):
        for part in iterate_frames(*given, **keys):
            for k in range(0, len(part[0]), 2):
                yield tuple(each[k : k + 2] for each in part)

    monkeypatch.setattr("sparsurf.molecules.trajectory.iterate_frames", parts)


@pytest.mark.filterwarnings("error")
def test_positions_that_no_distance_can_hold_are_refused_without_a_warning_of_numpy(tmp_path):
    names = "group_PDB id type_symbol label_atom_id label_comp_id label_asym_id label_seq_id Cartn_x Cartn_y Cartn_z"
    head = "data_x\nloop_\n" + "".join(f"_atom_site.{name}\n" for name in names.split(" "))
    rows = "ATOM 1 N N ALA A 1 0 0 0\nATOM 2 C C ALA A 1 1e300 0 0\nATOM 3 N N GLY A 2 1 0 0\n"
    path = tmp_path / "far.cif"
    path.write_text(head + rows)
    with pytest.raises(InputError, match=r"not numbers or beyond 1e.05 Å"):
        read_molecule(path)


def test_a_wrong_frame_is_called_by_its_number_in_the_file(tmp_path, in_parts):
    """Six frames of two peptides in a box of 100 Å, of which every second is read and the fifth is wrong."""
    text = peptide() + "TER\n" + peptide(chain="B", origin=(0, 50, 0)) + "END\n"
    given = mdtraj.join([mdtraj.load(str(write(tmp_path / "a.pdb", text)))] * 6)
    given.xyz = given.xyz + 0.02 * np.arange(6)[:, None, None]
    given.unitcell_vectors, given.time = np.tile(10 * np.eye(3), (6, 1, 1)), np.arange(6.0)
    torn, far, boxes = given[:], given[:], given.unitcell_vectors.copy()
    torn.xyz[4, 4] += 0.8
    far.xyz[4, 7] = 2e4
    boxes[4, 1, 1] = 5  # which would lay one peptide onto the other
    given.unitcell_vectors = boxes
    for frames, words in (
        (torn, "the bond CA-CB of ALA 1 A is .* long in frame 4;"),
        (far, "not numbers or beyond 1e.05 Å in frame 4:"),
        (given, "the box and the coordinates in frame 4 do not fit together"),
    ):
        frames.save(str(tmp_path / "a.trr"))
        for keys in ({"stride": 2}, {"times": [4.0, 5.0]}):
            with pytest.raises(InputError, match=words):
                read_molecule(tmp_path / "a.pdb", tmp_path / "a.trr", **keys)


def test_a_frame_that_repeats_or_goes_back_is_called_by_its_number_in_the_file(tmp_path, caplog, in_parts):
    one = mdtraj.load(str(write(tmp_path / "a.pdb", peptide() + "END\n")))
    frames = mdtraj.join([one] * 8)
    frames.xyz = frames.xyz + 0.02 * np.array([0, 1, 2, 3, 2, 5, 6, 7])[:, None, None]
    frames.time = np.array([0.0, 1, 2, 3, 4, 5, 1, 7])
    frames.save(str(tmp_path / "a.xtc"))
    read = read_molecule(tmp_path / "a.pdb", tmp_path / "a.xtc", stride=2)
    assert read.frame_number.tolist() == [0, 2, 6] and np.isnan(read.time_ps).all()
    assert "1 frame repeats the one before, the first is frame 4: left out" in caplog.text
    assert "time goes back to 1 ps at frame 6" in caplog.text
    frames.time = np.arange(8.0)
    frames.save(str(tmp_path / "a.xtc"))
    caplog.clear()
    few = read_molecule(tmp_path / "a.pdb", tmp_path / "a.xtc", times=[2.0, 4, 7])
    assert few.frame_number.tolist() == few.time_ps.tolist() == [0, 2, 7]
    assert "frame 4" in caplog.text


def test_scaled_coordinates_of_lammps_are_shares_of_the_box(tmp_path):
    path = write(tmp_path / "a.pdb", peptide() + "END\n")
    whole = read_molecule(path).xyz[0]
    low, sides = np.array([-10.0, -5, 3]), np.array([40.0, 50, 60])
    for names, values in (
        ("xs ys zs", (whole - low) / sides),
        ("xu yu zu", whole),
        ("x y z xs ys zs", np.hstack([whole, whole])),
    ):
        rows = "".join(
            f"{k} 1 " + " ".join(f"{value:.7f}" for value in row) + "\n" for k, row in enumerate(values, 1)
        )
        bounds = "".join(f"{a} {a + side}\n" for a, side in zip(low, sides, strict=True))
        head = f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n20\nITEM: BOX BOUNDS pp pp pp\n{bounds}ITEM: ATOMS id type {names}\n"
        write(tmp_path / "a.lammpstrj", head + rows)
        read = read_molecule(path, tmp_path / "a.lammpstrj").xyz[0]
        np.testing.assert_allclose(read, whole, atol=1e-4)


def test_a_complex_that_the_box_of_a_pdb_file_cuts_is_joined_and_a_crystal_is_not(tmp_path):
    text = "CRYST1   40.000   40.000   40.000  90.00  90.00  90.00 P 1           1\n"
    a, b = (read_molecule(write(tmp_path / "a.pdb", peptide(chain=chain))).xyz[0] for chain in "AB")
    whole = np.concatenate([a, b + np.array([0, 0, 4])])

    def read(places):
        lines = (
            atom_line(name, chain="AB"[i // 4], residue=str(1 + i % 4), place=places[5 * i + k])
            for i in range(8) for k, name in enumerate(ALANINE)
        )  # fmt: skip
        return read_molecule(write(tmp_path / "b.pdb", text + "".join(lines) + "END\n")).xyz[0]

    assert np.ptp(read(wrapped(whole, np.diag([40.0] * 3), (36, 5, 38))) - whole, axis=0).max() < 0.003
    as_it_is = read_molecule(tmp_path / "b.pdb", whole=False).xyz[0]
    assert np.abs(as_it_is - wrapped(whole, np.diag([40.0] * 3), (36, 5, 38))).max() < 0.001
    crystal = np.concatenate(
        [a, b + np.array([0, 0, 37])]
    )  # nearer to another image of the first, and no bond is cut
    np.testing.assert_allclose(read(crystal), crystal, atol=6e-4)
    one = mdtraj.load(str(tmp_path / "b.pdb"))
    assert from_mdtraj(one).xyz[0] == pytest.approx(crystal, abs=2e-3)
    moving = mdtraj.join([one, one])
    moving.xyz[1] += 0.01
    joined = crystal - np.repeat([[0, 0, 0], [0, 0, 40.0]], 20, axis=0)  # a trajectory is no crystal
    assert from_mdtraj(moving).xyz[0] == pytest.approx(joined, abs=2e-3)


def test_numbers_of_a_psf_file_beyond_9999_are_hexadecimal_and_all_before_are_not(tmp_path):
    labels = ["1000", "9998", "9999", "2710", "2711"]
    rows = [f"{k:8d} P    {label:4s} ALA  CA   CT1   0.07   12.0   0" for k, label in enumerate(labels, 1)]
    path = tmp_path / "long.psf"
    path.write_text("\n".join(["PSF", "", f"{len(rows):8d} !NATOM", *rows, ""]))
    found = read_psf(open_source(path)).atoms.residue
    assert [*found] == ["1000", "9998", "9999", "10000", "10001"]


def test_an_atom_without_a_number_among_others_is_an_extra_point(tmp_path):
    """Of a water of four points in an AMBER topology."""
    flags = {
        "POINTERS 10I8": [4, *[0] * 10, 1, *[0] * 19], "ATOM_NAME 20a4": ["O", "H1", "H2", "EPW"],
        "ATOMIC_NUMBER 10I8": [8, 1, 1, 0],
        "RESIDUE_LABEL 20a4": ["WAT"], "RESIDUE_POINTER 10I8": [1],
        "BONDS_INC_HYDROGEN 10I8": [0, 3, 1, 0, 6, 1, 0, 9, 1], "BONDS_WITHOUT_HYDROGEN 10I8": [],
    }  # fmt: skip
    lines = ["%VERSION  VERSION_STAMP = V0001.000  DATE = 01/01/26  00:00:00"]
    for flag, words in flags.items():
        name, form = flag.split()
        width = int(form[-1])
        per_line = int(form[:2])
        texts = [f"{word:<{width}}" if form[-2] == "a" else f"{word:>{width}}" for word in words]
        lines += [f"%FLAG {name}", f"%FORMAT({form})"]
        lines += ["".join(texts[k : k + per_line]) for k in range(0, max(len(texts), 1), per_line)]
    path = tmp_path / "water.parm7"
    path.write_text("\n".join([*lines, ""]))
    assert [*read_parm7(open_source(path)).atoms.element] == ["O", "H", "H", "EP"]
