"""Fields at dots: kernels against closed forms and plain sums, the charge table against what residues must carry."""

from dataclasses import replace
from types import SimpleNamespace

import gemmi
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import constants
from scipy.spatial.transform import Rotation

import sparsurf
from conftest import ROOT
from peptides import peptide
from sparsurf.cli import command
from sparsurf.dot_fields.charges import _table, pdb2pqr_charges, pqr_charges, table_charges
from sparsurf.dot_fields.columns import TableOfAtoms, columns_of
from sparsurf.dot_fields.named_fields import compute_fields, hydropathy, label_and_unit, potential
from sparsurf.dot_fields.potential import potential_of_charges, potential_of_unit_charge
from sparsurf.dot_fields.smoothing import gaussian_mean
from sparsurf.errors import InputError
from sparsurf.molecules.molecule import Molecule
from sparsurf.surfaces.grid import pairs_within

PEPTIDE = str(ROOT / "data" / "tdp43" / "topology.pdb")
LINE = "ATOM  {:5d}  {:<3s} {:3s} A{:4d}    {:8.3f}{:8.3f}{:8.3f}  1.00{:6.2f}           {:1s}\n"


@pytest.fixture(scope="module")
def molecule():
    return sparsurf.read_molecule(PEPTIDE)


# Kyte & Doolittle 1982, table 2, typed from the paper, in the order of the letters
SEQUENCE = "ARNDCQEGHILKMFPSTWYV"
HYDROPATHY = "1.8 -4.5 -3.5 -3.5 2.5 -3.5 -3.5 -0.4 -3.2 4.5 3.8 -3.9 1.9 2.8 -1.6 -0.8 -0.7 -0.9 -1.3 4.2"


def test_hydropathy_is_that_of_its_source():
    """One residue alone has its own value at every dot."""
    for residue, value in zip(
        gemmi.expand_one_letter_sequence(SEQUENCE, gemmi.ResidueKind.AA), HYDROPATHY.split(), strict=True
    ):
        alone = SimpleNamespace(residue_name=np.array([residue]), xyz=np.zeros((1, 1, 3)))
        assert hydropathy(alone, np.eye(3)) == pytest.approx([float(value)] * 3), residue


def test_atoms_within_a_distance_are_found_in_their_order():
    rng = np.random.default_rng(7)
    points, positions = rng.uniform(-4, 4, (300, 3)), rng.uniform(-7, 7, (200, 3))
    distance = np.linalg.norm(positions[:, None] - points, axis=2)
    for limit in (0.5, 1.4, 20.0):
        assert np.array_equal(np.stack(pairs_within(points, positions, limit)), np.nonzero(distance <= limit))
    assert [part.size for part in pairs_within(points[:0], positions, 1.0)] == [0, 0]


def test_one_charge_has_the_potential_of_the_formula():
    r = np.array([0.0, 2.0, 3.3, 10.0])
    soft = np.sqrt(r**2 + 0.6**2)
    kt = constants.Boltzmann * 298.15
    coulomb = constants.e**2 / (4 * np.pi * constants.epsilon_0 * kt) * 1e10  # kT Å / e^2
    eps = 2 + 160 / (1 + np.exp((3.3 - soft) / 1.2))
    points = np.column_stack([r, np.zeros(4), np.zeros(4)])
    found = potential_of_charges(np.zeros((1, 3)), np.array([-1.0]), points)
    # the table of terms is linear between steps of 0.02 Å: off by h^2 f'' / 8, below 0.1 % where f bends most
    np.testing.assert_allclose(found, -5 * coulomb * np.exp(-soft / 7.9) / (eps * soft), rtol=2e-3)


def test_the_potential_is_the_plain_sum_over_charges_and_turns_with_the_molecule():
    rng = np.random.default_rng(0)
    places, charges, points = rng.normal(0, 12, (80, 3)), rng.normal(size=80), rng.normal(0, 15, (50, 3))
    r = np.linalg.norm(points[:, None] - places, axis=2)
    found = potential_of_charges(places, charges, points)
    np.testing.assert_allclose(
        found, (potential_of_unit_charge(r) * (r < 40)) @ charges, atol=2e-3 * np.abs(found).max()
    )
    turn, shift = Rotation.random(random_state=1).as_matrix(), np.array([50.0, -7, 3])
    turned = potential_of_charges(places @ turn.T + shift, charges, points @ turn.T + shift)
    np.testing.assert_allclose(turned, found, atol=1e-9 * np.abs(found).max() + 1e-9)


def test_a_charge_beyond_40_angstrom_does_not_count():
    points = np.array([[39.99, 0, 0], [40.01, 0, 0]])
    near, far = potential_of_charges(np.zeros((1, 3)), np.ones(1), points)
    assert near > 0 and far == 0


def test_without_another_width_two_atoms_weigh_as_a_gaussian_of_2_5():
    """1 Å from one atom and 4 Å from the other; 10 Å, four sigmas, from the first alone; farther from both."""
    xyz, points = np.array([[0.0, 0, 0], [0, 5, 0]]), np.array([[0, 1.0, 0], [0, -9.99, 0], [0, -10.01, 0]])
    near, far = np.exp(-np.array([1, 16]) / 12.5)
    found = gaussian_mean(np.array([2.0, 7.0]), xyz, points)
    assert found[:2] == pytest.approx([(2 * near + 7 * far) / (near + far), 2]) and np.isnan(found[2])


def test_what_fields_are_called_and_measured_in():
    names = {
        "hydropathy": ("Kyte-Doolittle hydropathy", ""), "potential": ("electrostatic potential", "kT/e"),
        "bfactor": ("B factor", "Å^2"), "mean_curvature": ("mean curvature", "1/Å"),
        "gaussian_curvature": ("Gaussian curvature", "1/Å^2"), "shape_index": ("shape index", ""),
        "hbond": ("hydrogen-bond donor (1) or acceptor (−1)", ""), "my_score": ("my score", ""),
    }  # fmt: skip
    assert {name: label_and_unit(name) for name in names} == names


def test_hydropathy_is_the_mean_of_the_residues_that_the_scale_knows():
    """A variant counts as its standard residue, an unknown one not at all; selenomethionine has its own value."""
    atoms = SimpleNamespace(residue_name=np.array(["ALA", "LIG", "HIP", "ALA"]), xyz=np.zeros((1, 4, 3)))
    assert hydropathy(atoms, np.eye(3)) == pytest.approx([(1.8 + 1.8 - 3.2) / 3] * 3)
    atoms.residue_name[:] = "MSE"
    assert hydropathy(atoms, np.eye(3)) == pytest.approx([1.9] * 3)


def test_fields_come_in_the_order_of_their_names_and_what_has_no_place_is_refused(tmp_path, molecule):
    points = molecule.xyz[0, :4] + 2.0
    (tmp_path / "t.csv").write_text("residue,score\n209,1\n210,5\n")
    table = compute_fields(["score", "potential", "hydropathy"], molecule, points, table=tmp_path / "t.csv")
    assert list(table) == ["score", "potential", "hydropathy"]
    assert table["potential"] == pytest.approx(potential_of_charges(*table_charges(molecule), points))
    with pytest.raises(InputError, match="field 'score';"):
        compute_fields(["score"], molecule, points)
    with pytest.raises(InputError, match="table, pdb2pqr"):
        compute_fields(["potential"], molecule, points, charges=3)
    dots = sparsurf.surface(molecule)
    atoms = dots.atom.copy()
    atoms[7] = -1
    for lacking in (None, replace(dots, origin=None), replace(dots, atom=atoms)):
        for name, words in (("hbond", "hbond follows from"), ("shape_index", "curvature follows from")):
            with pytest.raises(InputError, match=words):
                compute_fields([name], molecule, dots.points, dots=lacking)


@given(st.integers(0, 10**6), st.integers(1, 40), st.floats(0.5, 4))
@settings(max_examples=25)
def test_smoothing_is_the_gaussian_mean_of_the_known_atoms(seed, n, width):
    rng = np.random.default_rng(seed)
    xyz, points = rng.uniform(-9, 9, (n, 3)), rng.uniform(-20, 20, (30, 3))
    values = np.where(rng.random(n) < 0.2, np.nan, rng.normal(size=n))
    d2 = ((points[:, None] - xyz) ** 2).sum(axis=2)
    weight = np.where((d2 < (4 * width) ** 2) & np.isfinite(values), np.exp(-d2 / (2 * width**2)), 0)
    with np.errstate(invalid="ignore"):
        expected = weight @ np.nan_to_num(values) / weight.sum(axis=1)
    np.testing.assert_allclose(gaussian_mean(values, xyz, points, width), expected, rtol=1e-7, atol=1e-12)


def test_charges_of_a_whole_peptide_add_up_with_and_without_its_hydrogens(molecule):
    names = molecule.residues["residue_name"]
    net = names.isin(["LYS", "ARG"]).sum() - names.isin(["ASP", "GLU"]).sum()
    bare = molecule.select(hydrogens="remove")
    for each in (molecule, bare):
        places, charges = table_charges(each)
        # the ends of a chain carry + and -, or, where its last OXT is missing, a carbonyl of 0.10 - 0.55
        lacking = 0.55 * ("OXT" not in molecule.name and "OT2" not in molecule.name)
        assert charges.sum() == pytest.approx(net + lacking, abs=1e-6)
        assert np.isfinite(places).all()


def made(*atoms, kind="protein"):
    """A molecule of atoms, each the number and the name of its residue, its name and its place."""
    number, residue, name, places = zip(*atoms, strict=True)
    index = np.unique(number, return_inverse=True)[1]
    return Molecule(
        xyz=np.array([places], float), time_ps=np.zeros(1), frame_number=np.zeros(1, int), name=np.array(name),
        residue_name=np.array(residue), chain=np.full(len(atoms), "A"), element=np.array([each[0] for each in name]),
        residue=np.array(number).astype(str), residue_index=index,
        kind=np.array(kind) if isinstance(kind, list) else np.full(len(atoms), kind), b_factor=np.full(len(atoms), np.nan),
    )  # fmt: skip


BENT = np.add(
    [[-0.5, 1.4, 0], [0, 0, 0], [1.5, 0, 0]], [3, 4, 5]
)  # three bonded atoms, the second bond along x


@pytest.mark.parametrize(
    ("residue", "names", "bend", "turns", "charge"),
    [("SER", ("CA", "CB", "OG"), 70.5, (0, 60, 120, 180, 240, 300), 0.49), ("ASN", ("CB", "CG", "ND2"), 60.0, (0, 180),
     0.78), ("LYS", ("CD", "CE", "NZ"), 70.5, (60, 180, 300), 0.99)],
)  # fmt: skip
def test_hydrogens_are_built_around_the_bond_of_their_atom(residue, names, bend, turns, charge):
    """At 1 Å, turned from the side where the atom before the bond lies, with equal shares of their charge."""
    atoms = [(1, residue, name, place) for name, place in zip(names, BENT, strict=True)]
    places, charges = table_charges(made(*atoms))
    n, bend, turns = len(turns), np.deg2rad(bend), np.deg2rad(turns)
    expected = [np.full(n, np.cos(bend)), np.sin(bend) * np.cos(turns), np.sin(bend) * np.sin(turns)]
    np.testing.assert_allclose(places[-n:] - BENT[2], np.transpose(expected), atol=1e-12)
    assert charges[-n:] == pytest.approx(charge / n)


def test_hydrogens_of_a_bond_that_nothing_precedes_are_a_ring():
    places, _ = table_charges(made((1, "SER", "CB", BENT[1]), (1, "SER", "OG", BENT[2])))
    ring = places[-6:] - BENT[2]
    assert np.linalg.norm(ring, axis=1) == pytest.approx(1) and ring[:, 0] == pytest.approx(
        np.cos(np.deg2rad(70.5))
    )
    np.testing.assert_allclose(ring[:3, 1:], -ring[3:, 1:], atol=1e-12)


def test_a_hydrogen_stands_opposite_to_both_neighbours_of_its_atom():
    before, own, behind = np.add([[-1.3, 0.6, 0.1], [0, 0, 0], [0.5, -1.2, 0.7]], [3, 4, 5])
    molecule = made((1, "ALA", "C", before), (2, "ALA", "N", own), (2, "ALA", "CA", behind))
    places, charges = table_charges(molecule)
    away = -sum((each - own) / np.linalg.norm(each - own) for each in (before, behind))
    assert places[-1] == pytest.approx(own + away / np.linalg.norm(away)) and charges[-1] == 0.4


def test_the_table_has_ions_and_hydrogens_of_the_file_stay():
    serine = [(1, "SER", name, place) for name, place in zip(("CA", "CB", "OG"), BENT, strict=True)]
    far, own = (1, "SER", "HB2", BENT[2] + [-1.5, -1.0, 0]), (1, "SER", "HG", BENT[2] + [0, 0, 0.96])
    assert len(table_charges(made(*serine, far))[0]) == 2 + 6  # CA, OG and a ring of its hydrogen
    places, charges = table_charges(made(*serine, far, own))
    assert len(places) == 3 and places[-1].tolist() == own[3].tolist() and charges[-1] == 0.49
    # Its name, NA, is no missing value.
    assert _table()["NA", "NA"] == (1.0, 0.0, 0.0)


# Formal charges; residues of proteins without their backbone, nucleotides with their phosphate
IONS = {
    "ZN": 2,
    "MG": 2,
    "CA": 2,
    "MN": 2,
    "FE": 2,
    "FE2": 2,
    "FE3": 3,
    "CU": 2,
    "CU1": 1,
    "NI": 2,
    "CO": 2,
    "CD": 2,
}
IONS |= {"NA": 1, "K": 1, "CL": -1, "BR": -1, "IOD": -1}
FORMAL = IONS | {"ARG": 1, "LYS": 1, "HIP": 1, "ASP": -1, "GLU": -1, "CYM": -1, "TYM": -1}
FORMAL |= dict.fromkeys(["A", "C", "G", "U", "DA", "DC", "DG", "DT"], -1)


def test_every_residue_of_the_table_carries_its_formal_charge():
    """Hydrogens have a charge where there are any, and polar ones a positive one."""
    found = {}
    for (residue, atom), (charge, hydrogens, number) in _table().items():
        found[residue] = found.get(residue, 0) + charge + hydrogens
        assert (hydrogens != 0) == (number > 0) and 0 <= number <= 3, (residue, atom)
        assert hydrogens > 0 or not (number and atom[0] in "NOS"), (residue, atom)
    assert found == pytest.approx({residue: FORMAL.get(residue, 0) for residue in found}, abs=2e-3)
    assert FORMAL.keys() <= found.keys()


@pytest.mark.parametrize(("gap", "bridged"), [(2.0, True), (2.49, True), (2.51, False)])
def test_a_cysteine_without_a_bridge_has_a_hydrogen(gap, bridged):
    x = {"CB": (0, 3.6 + gap), "SG": (1.8, 1.8 + gap)}
    atoms = [(k + 1, "CYS", name, (x[name][k], 0, 0)) for k in (0, 1) for name in ("CB", "SG")]
    molecule = made(*atoms)
    places, charges = table_charges(molecule)
    if bridged:
        assert np.array_equal(places, molecule.xyz[0]) and charges.tolist() == [0.29, -0.29, 0.29, -0.29]
        third = [(0, "CYS", "CB", (0, 50, 0)), (0, "CYS", "SG", (1.8, 50, 0))]  # has none
        _, charges = table_charges(made(*third, *atoms))
        assert charges[:5].tolist() == [-0.29, 0.29, -0.29, 0.29, -0.29]
        assert charges[5:] == pytest.approx([0.29 / 6] * 6)
    else:
        assert len(places) == 2 + 2 * 6 and charges[:2].tolist() == [-0.29, -0.29]
        assert charges[2:] == pytest.approx(0.29 / 6)


@pytest.mark.parametrize(
    ("name", "atom", "hydrogens", "charge"),
    [
        ("HIS", "ND1", (), -0.4), ("HIS", "ND1", ("HD1",), -0.4), ("HIS", "ND1", ("HE2",), -0.56),
        ("HIS", "ND1", ("HD1", "HE2"), -0.35), ("HSP", "ND1", (), -0.35), ("NHIE", "ND1", (), -0.56),
        ("HISE", "ND1", (), -0.56), ("CHID", "ND1", (), -0.4), ("LYS", "NZ", (), -0.32), ("CLYS", "NZ", ("HE2",), -0.32),
        ("LYN", "NZ", (), -0.78),
    ],
)  # fmt: skip
def test_the_state_of_a_residue_follows_from_its_name_and_hydrogens(name, atom, hydrogens, charge):
    far = ((1, name, each, (9, 9, 9)) for each in hydrogens)
    assert table_charges(made((1, name, atom, (0, 0, 0)), *far))[1][0] == charge


def test_each_histidine_has_the_state_of_its_own_hydrogens():
    hydrogens = [(), ("HE2",), ("HD1", "HE2"), ("HD1",), ()]
    names = [("ND1", *each) for each in hydrogens]
    atoms = [
        (k, "HIS", name, (30 * k, 9 * n, 0)) for k, each in enumerate(names) for n, name in enumerate(each)
    ]
    assert table_charges(made(*atoms))[1][:5].tolist() == [-0.4, -0.56, -0.35, -0.4, -0.4]


def test_a_residue_without_charges_and_a_ligand_are_neutral(caplog, tmp_path):
    atoms = (
        (1, "ALA", "CB", (0, 0, 0)),
        (2, "LIG", "C1", (5, 0, 0)),
        (3, "HOH", "O", (9, 0, 0)),
        (4, "NA", "NA", (0, 9, 0)),
    )
    assert table_charges(made(*atoms, kind=["protein", "other", "water", "other"]))[1].tolist() == [1]
    assert caplog.messages == ["potential: LIG have no charges in the table and count as neutral"]
    lines = [LINE.format(k, a, "LIG", 1, 1.4 * k, 0, 0, 5, a[0]) for k, a in enumerate(["N", "C", "O"])]
    path = tmp_path / "ligand.pdb"
    path.write_text("".join(line.replace("ATOM  ", "HETATM") for line in lines) + "END\n")
    assert table_charges(sparsurf.read_molecule(path, selection="all"))[1].tolist() == []


def test_other_names_of_atoms_have_the_same_charges():
    for names in (("O", "OXT"), ("OT1", "OT2")):
        ends = [(1, "GLY", name, (9 * k, 0, 0)) for k, name in enumerate(names)]
        assert table_charges(made(*ends))[1].tolist() == [-0.55, -0.55]
    one, other = (
        table_charges(made(*((1, "A", name, (9 * k, 0, 0)) for k, name in enumerate(names)), kind="nucleic"))[
            1
        ]
        for names in (("OP1", "OP2", "P"), ("O1P", "O2P", "P"))
    )
    assert one.tolist() == other.tolist() and len(one) == 3 and (one[:2] < 0).all() and one[2] > 0


def test_every_chain_has_charged_ends_and_unknown_residues_are_named_in_order(caplog):
    """N, CA, C and O of the first and of the last residue of each of two chains, one with both ends in one residue."""
    names = ("N", "CA", "C", "O")
    atoms = [
        (r, "GLY", name, (20 * r, 6 * k, 0))
        for r in (1, 2, 3, 4)
        for k, name in enumerate(names)
    ]  # fmt: skip
    water = [(5, "HOH", "O", (0, -40, 0))]  # of the first chain, at the end of the file
    chains = np.array([*np.repeat(["A", "A", "A", "B"], 4), "A"])
    kinds = ["protein"] * 16 + ["water"]
    places, charges = table_charges(replace(made(*atoms, *water, kind=kinds), chain=chains))
    of_atoms = [charges[(places == place).all(axis=1)].sum() for *_, place in atoms]
    # hydrogens of an atom without neighbours lie at its own place: -0.32 + 0.99, and -0.4 + 0.4
    start, middle, end = [0.67, 0.33, 0.55, -0.55], [0.0, 0.0, 0.55, -0.55], [0.0, 0.0, 0.10, -0.55]
    assert of_atoms == pytest.approx([*start, *middle, *end, *start[:2], *end[2:]])
    _, charges = table_charges(made(*((k, "PRO", "N", (20 * k, 0, 0)) for k in (1, 2))))
    assert charges.tolist() == pytest.approx([-0.32, -0.56, *[0.33] * 3])  # the second has no hydrogen
    others = [(1, "ZZZ", "C1", (0, 0, 0)), (2, "ALA", "CB", (9, 0, 0)), (3, "LIG", "C1", (0, 9, 0))]
    table_charges(made(*others, kind=["other", "protein", "other"]))
    assert caplog.messages == ["potential: LIG, ZZZ have no charges in the table and count as neutral"]


def test_columns_of_pdb2pqr_do_not_touch_far_from_the_origin(tmp_path, monkeypatch, molecule):
    """Without the option it writes 91.733-207.260, which nobody can read."""
    program = tmp_path / "pdb2pqr"
    wide = "ATOM 1 N ALA 1 1.0 91.733 -207.260 -0.5 1.5"
    whole = f'[ "$(grep -c ^ATOM "$3")" = {molecule.n_atoms} ] || exit 1'
    program.write_text(
        f'#!/bin/sh\nfor last; do :; done\n{whole}\ncase "$*" in\n'
        f'*--ff=PARSE*--whitespace*) echo "{wide}";;\n*) echo "{wide.replace("3 -2", "3-2")}";;\nesac > "$last"\n'
    )
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    places, charges = pdb2pqr_charges(molecule)
    assert places.tolist() == [[1.0, 91.733, -207.26]] and charges.tolist() == [-0.5]
    near = np.add(places, [[1.0, 0, 0]])
    found = potential(molecule, near, charges="pdb2pqr")
    assert found.tolist() == potential_of_charges(places, charges, near).tolist() != [0]


@pytest.mark.parametrize(
    ("script", "reason"),
    [("echo first >&2; echo no such force field >&2; exit 1", "no such force field"), ("exit 0", "no message"),
     ('for last; do :; done; echo "ATOM 1 N ALA 1 1.0 2.0 3.0 -0.5 1.5" > "$last"; exit 3', "no message")],
)  # fmt: skip
def test_a_pdb2pqr_that_fails_or_is_absent_is_a_sentence(tmp_path, monkeypatch, molecule, script, reason):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="pdb2pqr is not on the PATH"):
        pdb2pqr_charges(molecule)
    (tmp_path / "pdb2pqr").write_text(f"#!/bin/sh\n{script}\n")
    (tmp_path / "pdb2pqr").chmod(0o755)
    with pytest.raises(InputError, match=rf"pdb2pqr failed \({reason}\); use the built-in table"):
        pdb2pqr_charges(molecule)


@pytest.mark.parametrize(
    ("line", "words"),
    [("nan 0 0 -0.5 1.5", "line 1 ends in .* no atom has such a position"), ("0 0 0 nan 1.5",
     "line 1 ends in .* no atom has such a position"), ("0 0 0 -10.5 1.5",
     "line 1 ends in .* no atom has such a position"), ("0 0 0 0.6 0.3", "half of its charges are above 0.5 e"),
     ("1.06 0.0 0.0 0.1 1.5", "its atoms lie 1.1 Å from those of the molecule"), ("0.99 0.0 0.0 0.1 1.5", None)],
)  # fmt: skip
def test_a_line_of_a_pqr_file_that_no_atom_has_is_reported(tmp_path, line, words):
    (tmp_path / "a.pqr").write_text(f"ATOM 1 N ALA 1 {line}\n")
    molecule = made((1, "ALA", "N", (0, 0, 0)), (1, "ALA", "H", (5, 0, 0)), (1, "ALA", "H2", (9, 0, 0)))
    if words is None:
        assert pqr_charges(tmp_path / "a.pqr", molecule)[1].tolist() == [0.1]
        return
    with pytest.raises(InputError, match=words):
        pqr_charges(tmp_path / "a.pqr", molecule)


@pytest.mark.parametrize(("charges", "refused"), [((9.0, 0.1, 0.1), False), ((-9.0, 0.6, 0.6), True)])
def test_half_of_the_charges_of_a_pqr_file_are_small(tmp_path, charges, refused):
    """Whatever their mean is: a column of radii has none that are."""
    text = "".join(f"ATOM {k} N ALA 1 {k} 0 0 {charge} 1.5\n" for k, charge in enumerate(charges))
    (tmp_path / "a.pqr").write_text(text)
    if refused:
        with pytest.raises(InputError, match="exchange charge"):
            pqr_charges(tmp_path / "a.pqr")
    else:
        assert pqr_charges(tmp_path / "a.pqr")[1].tolist() == [*charges]


def test_a_pqr_file_gives_places_and_charges(tmp_path):
    path = tmp_path / "a.pqr"
    path.write_text("REMARK\nATOM 1 N ALA 1 1.0 2.0 3.0 -0.5 1.5\nHETATM 2 H LIG 1 1.5 2.0 3.0 0.5 1.0\n")
    places, charges = pqr_charges(path)
    np.testing.assert_array_equal(places, [[1, 2, 3], [1.5, 2, 3]])
    np.testing.assert_array_equal(charges, [-0.5, 0.5])
    for charge, words in (("x", "does not end in x"), ("99", "ends in .* no atom has such")):
        path.write_text(f"REMARK\nATOM 1 N ALA 1 1 2 3 0 1.5\nTER\nATOM 1 N ALA 1 1.0 2.0 3.0 {charge} 1.5\n")
        with pytest.raises(InputError, match=rf"a\.pqr: line 4 {words}"):
            pqr_charges(path)


def test_an_atom_without_a_charge_does_not_make_it_another_structure(tmp_path, caplog):
    """A file of charges may lack a ligand: most of its atoms lie at those of the molecule."""
    molecule = made(*((k, "ALA", "C", (5.0 * k, 0, 0)) for k in range(5)), (5, "LIG", "C", (0, 90, 0)))
    (tmp_path / "a.pqr").write_text("".join(pqr(molecule).splitlines(True)[:5]))
    assert len(pqr_charges(tmp_path / "a.pqr", molecule)[1]) == 5 and not caplog.messages


def pqr(molecule, charge=lambda k: (-1) ** k * 0.3, radius=1.5, scale=1.0, shift=0.0):
    places = molecule.xyz[0] * scale + shift
    return "".join(
        f"ATOM {k} X ALA 1 {x} {y} {z} {charge(k)} {radius}\n" for k, (x, y, z) in enumerate(places)
    )


def test_charges_that_may_be_of_another_frame_are_reported(tmp_path, molecule, caplog):
    path = tmp_path / "a.pqr"
    for shift, told in ((0.17, []), (0.18, ["its atoms lie 0.3 Å from those of the molecule"])):
        path.write_text(pqr(molecule, shift=shift))
        pqr_charges(path, molecule)
        assert [each.split(": ")[1].split(",")[0] for each in caplog.messages] == told


def test_charges_of_a_file_lie_at_the_atoms_of_the_molecule(tmp_path, molecule):
    path, heavy = tmp_path / "a.pqr", molecule.select(hydrogens="remove")
    path.write_text(pqr(heavy, shift=0.4))  # as a force field that relaxes them moves them
    points = molecule.xyz[0, :5] + 5.0
    dots = points, np.tile([0, 0, 1.0], (5, 1))
    found = sparsurf.fields(molecule, dots, "potential", charges=path)["potential"].to_numpy()
    np.testing.assert_array_equal(found, potential_of_charges(*pqr_charges(path), points))
    for text, said in (
        (pqr(molecule, scale=0.1), "its atoms lie .* Å from those of the molecule"),
        (pqr(molecule, shift=50.0), "its atoms lie .* Å from those of the molecule"),
        (pqr(molecule, charge=lambda k: 1.5, radius=0.3), "exchange charge and radius"),
    ):
        path.write_text(text)
        with pytest.raises(InputError, match=said):
            sparsurf.fields(molecule, dots, "potential", charges=path)


def test_columns_of_a_table_and_b_factors_reach_the_dots(tmp_path, molecule):
    residues = molecule.residues
    table = pd.DataFrame({"residue": residues["residue"], "score": np.arange(len(residues)) % 7})
    table.to_csv(tmp_path / "scores.csv", index=False)
    with open(tmp_path / "scores.csv", "a") as stream:
        stream.write(",\n, \n,,\n")  # as a spreadsheet writes below a table
    dots = sparsurf.surface(molecule)
    of_atoms = table["score"].to_numpy(float)[molecule.residue_index]
    scores = {"names": ("score",), "table": tmp_path / "scores.csv"}
    np.testing.assert_array_equal(sparsurf.fields(molecule, dots, **scores)["score"], of_atoms[dots.atom])
    smooth = sparsurf.fields(molecule, dots, **scores, smooth=1.5)
    assert list(smooth) == ["score_smooth"]
    expected = gaussian_mean(of_atoms, molecule.xyz[0], dots.points, 1.5)
    np.testing.assert_array_equal(smooth["score_smooth"], expected)
    with_b = tmp_path / "b.pdb"
    b_factor = np.arange(molecule.n_atoms) % 9.0  # 0 of some atoms is a value
    molecule.write_pdb(with_b, b_factor=b_factor)
    found = sparsurf.fields(with_b, dots, "bfactor")["bfactor"].to_numpy()
    assert found == pytest.approx(b_factor[dots.atom])
    centres = np.linalg.norm(dots.points[::50, None] - molecule.xyz[0], axis=2).argmin(axis=1)
    pair = dots.points[::50], dots.normals[::50]  # whose atoms are unknown
    assert sparsurf.fields(with_b, pair, "bfactor")["bfactor"].to_numpy() == pytest.approx(b_factor[centres])
    expected = gaussian_mean(b_factor, molecule.xyz[0], dots.points)
    found = sparsurf.fields(with_b, dots, "bfactor", smooth=2.5)["bfactor_smooth"]
    assert found.to_numpy() == pytest.approx(expected)
    with pytest.raises(InputError, match="bfactor has no value"):
        sparsurf.fields(molecule, dots, ("bfactor",))


def test_a_dot_of_an_atom_without_a_value_has_that_of_the_nearest_one_of_its_residue(tmp_path, molecule):
    """Shifts of N and C-beta alone, and none of residue 211."""
    rows = [
        f"{residue},{atom},{value}"
        for residue, atom, value in (("209", "N", 7), ("209", "CB", 3), ("210", "CB", 5))
    ]
    (tmp_path / "shifts.csv").write_text("residue,atom,shift\n" + "\n".join(rows) + "\n")
    dots = sparsurf.surface(molecule)
    found = sparsurf.fields(dots, "shift", table=tmp_path / "shifts.csv")["shift"].to_numpy()
    residue = molecule.residue[dots.atom]
    known = [np.flatnonzero((molecule.residue == "209") & (molecule.name == name))[0] for name in ("N", "CB")]
    distance = np.linalg.norm(dots.points[:, None] - molecule.xyz[0, known], axis=2)
    first = residue == "209"
    own = np.isin(dots.atom, known)
    expected = np.where(
        dots.atom == known[0], 7, np.where(dots.atom == known[1], 3, np.where(distance.argmin(axis=1), 3, 7))
    )
    assert (
        found[first].tolist() == expected[first].tolist()
        and (first & ~own).any()
        and {*found[first]} == {3, 7}
    )
    assert (found[residue == "210"] == 5).all() and np.isnan(found[~np.isin(residue, ["209", "210"])]).all()


def test_a_scale_gives_each_residue_the_value_of_its_name(tmp_path, molecule):
    """A residue of a force field has that of the residue it stands for; two rows for one name are refused."""
    (tmp_path / "scale.csv").write_text("residue_name,scale\nPHE,-1.13\nHIS,0.17\n")
    histidine = molecule.residue == "212"
    molecule = replace(molecule, residue_name=np.where(histidine, "HIE", molecule.residue_name))
    values = TableOfAtoms.read(tmp_path / "scale.csv", molecule).field("scale")
    histidine |= np.isin(molecule.residue_name, ["HIS", "HSD", "HSE", "HSP"])  # as in the file
    expected = np.where(molecule.residue_name == "PHE", -1.13, np.where(histidine, 0.17, np.nan))
    np.testing.assert_array_equal(values, expected)
    (tmp_path / "scale.csv").write_text("residue_name,scale\nPHE,1\nPHE,2\n")
    with pytest.raises(InputError, match="residue name"):
        TableOfAtoms.read(tmp_path / "scale.csv", molecule).field("scale")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("residue,score\n209,1\n9998,2\n9999,3\n", "2 of 3 rows name no residue or atom of the molecule: 9998, 9999"),
        ("residue_name,score\nGlu,1\nALAA,2\nCYM,3\n", "1 of 3 rows name no residue or atom of the molecule: ALAA"),
    ],
)  # fmt: skip
def test_rows_of_a_table_that_fit_no_residue_are_told(tmp_path, molecule, caplog, content, said):
    (tmp_path / "scores.csv").write_text(content)
    values = TableOfAtoms.read(tmp_path / "scores.csv", molecule).field("score")
    assert values[molecule.residue == "209"].tolist() == [1] * (molecule.residue == "209").sum()
    assert [text.partition(": ")[2] for text in caplog.messages] == [said]


def test_a_row_that_fits_residues_of_different_names_is_told(tmp_path, caplog):
    text = peptide(("ALA", "SER")) + "TER\n" + peptide(("ALA", "LYS"), "B", origin=(0, 0, 9)) + "END\n"
    (tmp_path / "two.pdb").write_text(text)
    molecule = sparsurf.read_molecule(tmp_path / "two.pdb")
    for header, row in (("chain,residue", "A,"), ("residue", ""), ("residue,residue_name", "")):
        name = ",SER" if "name" in header else ""
        (tmp_path / "scores.csv").write_text(f"{header},score\n{row}2{name},5\n")
        values = TableOfAtoms.read(tmp_path / "scores.csv", molecule).field("score")
        n_chains = 1 + (header == "residue")
        assert np.isfinite(values).sum() == 5 * n_chains == 5 + 5 * ("SER 2 A and LYS 2 B" in caplog.text)
        caplog.clear()


def test_a_row_of_another_residue_is_refused_and_names_of_one_residue_agree(tmp_path, molecule):
    table = molecule.residues.assign(score=1.0)
    table["residue_name"] = table["residue_name"].str.title().replace({"His": "Hie", "Met": "Mse"})
    table.loc[0, "residue_name"] = ""  # of a mutant
    table.to_csv(tmp_path / "scores.csv", index=False)
    assert (TableOfAtoms.read(tmp_path / "scores.csv", molecule).field("score") == 1).all()
    table.loc[3, "residue_name"] = "TRP"
    table.to_csv(tmp_path / "scores.csv", index=False)
    with pytest.raises(
        InputError, match=r"row 4: residue_name is TRP, and the molecule has .* 212.* there .1 row"
    ):
        TableOfAtoms.read(tmp_path / "scores.csv", molecule).field("score")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("a,b\n1,2\n", "no column residue"), ("", "no column residue"), ("residue,score\n209,x\n", "row 1: score is 'x'"),
        ("residue,score\n9999,1\n", "no row fits"),
        ("residue,score\n\n209,1\n210,\n211,y\n", "row 3: score is 'y'"), ("residue,score\n209,1\n209,2\n", "two rows"),
        ("residue,other\n209,1\n", "no column 'score'"), ("residue,score\n209,inf\n", "row 1: score is 'inf'"),
        ("residue,score,score\n209,1,2\n", "column 'score' twice"),
        ("residue,score\n209,1\n210\n", "row 2: it has 1 values, not 2; repair it"),
        ("residue,score\n209,1\n210,2,3\n", "row 2: it has 3 values, not 2; repair it"),
        ('residue,score\n209,"1\n', "commas between"),
    ],
)  # fmt: skip
def test_a_table_that_does_not_fit_is_refused(tmp_path, molecule, content, said):
    (tmp_path / "scores.csv").write_text(content)
    with pytest.raises(InputError, match=said):
        TableOfAtoms.read(tmp_path / "scores.csv", molecule).field("score")


@pytest.mark.parametrize("name", ["kind", "x", "two words", "größe"])
def test_a_column_that_cannot_be_a_field_is_refused(tmp_path, molecule, name):
    """Its values would be lost among the columns of the dots, or damage a PLY file."""
    for encoding in ("utf-8-sig", "latin-1"):
        (tmp_path / "scores.csv").write_text(f"residue,{name}\n209,1\n", encoding=encoding)
        with pytest.raises(InputError, match=f"'{name}' cannot name a field"):
            TableOfAtoms.read(tmp_path / "scores.csv", molecule).field(name)


def test_cells_of_a_table_may_be_quoted_and_hold_lines(tmp_path, molecule):
    path = tmp_path / "scores.csv"
    path.write_text('residue, note ,"score"\r\n209,"a\r\nb, c", "7"\r\n\r\n210,,8\r\n', newline="")
    found = TableOfAtoms.read(path, molecule).field("score")
    for residue, value in (("209", 7), ("210", 8)):
        assert set(found[molecule.residue == residue]) == {value}
    assert np.isnan(found[~np.isin(molecule.residue, ["209", "210"])]).all()


def test_chain_and_atom_tell_the_rows_of_a_residue_apart(tmp_path, caplog):
    """Of two chains with the same numbers of residues, and of two atoms of a residue."""
    atoms = [
        (k + 1, "ALA", name, (9 * k, 5 * n, 0)) for k in (0, 1, 2) for n, name in enumerate(("CA", "CB"))
    ]
    molecule = replace(
        made(*atoms), chain=np.array(list("AAABBB")), residue=np.array(["1", "1", "2", "2", "1", "1"])
    )
    path = tmp_path / "t.csv"
    path.write_text("atom,score,chain,residue\nCA,1,A,1\nCB,2,A,1\nCB,3,B,1\nCA,4,A,2\nCB,,B,2\n")
    with caplog.at_level("INFO", "sparsurf"):
        found = TableOfAtoms.read(path, molecule).field("score")
    assert found.tolist() == pytest.approx([1, 2, 4, np.nan, np.nan, 3], nan_ok=True)
    assert caplog.messages == [f"{path}: 4 of 6 atoms have a value of score"]
    assert columns_of(path) == ["atom", "score", "chain", "residue"]
    path.write_text("chain,residue,score\nA,1,1\nB,1,2\n")
    assert TableOfAtoms.read(path, molecule).field("score").tolist() == pytest.approx(
        [1, 1, np.nan, np.nan, 2, 2], nan_ok=True
    )
    names = {"chain": np.repeat(["NA", "1"], 3), "residue": np.repeat(["-1A", "01", "1"], 2)}
    path.write_text("chain,residue,score\nNA,-1A,1\n1,1,2\nNA,01,3\n")  # names that look like other things
    found = TableOfAtoms.read(path, replace(molecule, **names)).field("score")
    assert found.tolist() == pytest.approx([1, 1, 3, np.nan, 2, 2], nan_ok=True)
    path.write_text("residue,score\n1,7\n")  # of every chain
    assert (
        np.isfinite(TableOfAtoms.read(path, molecule).field("score")).tolist()
        == [True, True, False, False] + [True] * 2
    )
    path.write_text("residue,atom,chain,score\n2,CA,A,7\n")  # a single atom
    assert np.flatnonzero(np.isfinite(TableOfAtoms.read(path, molecule).field("score"))).tolist() == [2]
    path.write_text("chain,residue,score\nA,1,1\nA,1,2\n")
    with pytest.raises(InputError, match="two rows for one residue"):
        TableOfAtoms.read(path, molecule).field("score")
    for name in ("chain", "residue"):
        with pytest.raises(InputError, match=f"no column '{name}' of values; it has chain, residue, score"):
            TableOfAtoms.read(path, molecule).field(name)
    path.write_text("residue,component\n1,1\n")
    with pytest.raises(InputError, match="'component' cannot name"):
        TableOfAtoms.read(path, molecule).field("component")


def test_dots_of_the_accessible_surface_have_the_values_of_their_own_atom(tmp_path, capsys):
    (tmp_path / "a.pdb").write_text(peptide(["ALA", "LYS", "ALA"]) + "END\n")
    molecule = sparsurf.read_molecule(tmp_path / "a.pdb")
    table = molecule.labels(np.arange(molecule.n_atoms)).assign(score=np.arange(molecule.n_atoms))
    table.drop(columns="atom").rename(columns={"atom_name": "atom"}).to_csv(tmp_path / "t.csv", index=False)
    asked = [
        "surface",
        str(tmp_path / "a.pdb"),
        "--boundary",
        "accessible",
        "--table",
        str(tmp_path / "t.csv"),
    ]
    command.main([*asked, "--fields", "score", "-o", str(tmp_path / "dots.csv")])
    dots = pd.read_csv(tmp_path / "dots.csv")
    assert (dots["score"] == dots["atom"]).all()
    steps = dots[["x", "y", "z"]].to_numpy() - molecule.xyz[0][dots["atom"]]
    reach = sparsurf.surfaces.radii.radii(molecule)[dots["atom"]] + 1.4
    assert np.linalg.norm(steps, axis=1) == pytest.approx(reach, abs=2e-4)
    assert dots["area"].sum() == pytest.approx(sparsurf.areas(molecule).accessible.sum(), rel=0.01)
    assert command.main([*asked, "--fields", "depth", "-o", str(tmp_path / "dots.csv")]) != 0
    assert "depth is one of the excluded surface" in capsys.readouterr().err


def test_fields_are_those_of_the_first_frame(tmp_path):
    """A serine with its hydrogen and two cysteines, whose bridge and atoms come apart in the second frame."""
    serine = [(1, "SER", name, place) for name, place in zip(("CA", "CB", "OG"), BENT, strict=True)]
    serine.append((1, "SER", "HG", BENT[2] + [0, 0, 0.96]))
    bridge = [(k, "CYS", "SG", (20, 2.0 * k, 0)) for k in (2, 3)]
    one = replace(made(*serine, *bridge), b_factor=np.arange(6.0))
    away = one.xyz + 3.0 * np.arange(6)[:, None]
    two = replace(one, xyz=np.concatenate([one.xyz, away]), time_ps=np.arange(2.0), frame_number=np.arange(2))
    (tmp_path / "t.csv").write_text("residue,score\n1,1\n2,5\n3,7\n")
    points, names = one.xyz[0] + 1.5, ["hydropathy", "potential", "bfactor", "score"]
    found, wanted = (compute_fields(names, each, points, table=tmp_path / "t.csv") for each in (two, one))
    pd.testing.assert_frame_equal(pd.DataFrame(found), pd.DataFrame(wanted))
    other = compute_fields(names, replace(one, xyz=away), points, table=tmp_path / "t.csv")
    assert all(not np.allclose(other[name], wanted[name]) for name in names)
    (tmp_path / "a.pqr").write_text(pqr(one))
    pqr_charges(tmp_path / "a.pqr", two)  # its atoms lie at those of the first frame


def test_a_column_called_like_a_field_and_an_unknown_field_are_refused(tmp_path, molecule):
    path, dots = tmp_path / "scores.csv", (np.zeros((1, 3)), np.array([[0, 0, 1.0]]))
    path.write_text("residue,bfactor,score\n209,1,2\n")
    with pytest.raises(InputError, match="column 'bfactor'"):
        sparsurf.fields(molecule, dots, ("bfactor",), table=path)
    with pytest.raises(InputError, match="hydropathy, potential"):
        sparsurf.fields(molecule, dots, ("colour",))


def test_commands_take_tables_of_values_and_a_width(tmp_path, capsys):
    (tmp_path / "t.csv").write_text(
        "residue_name,scale\n" + "".join(f"{n},{k}\n" for k, n in enumerate(("GLU", "PHE", "SER")))
    )
    (tmp_path / "b.csv").write_text("residue,score\n209,1\n209,2\n")
    dots = sparsurf.surface(PEPTIDE)
    table = pd.read_csv(_command(tmp_path, "surface", "--fields", "scale", "--table", "t.csv"))
    known = table["scale"].notna()
    assert table.loc[known, "scale"].tolist() == [
        ("GLU", "PHE", "SER").index(n) for n in table.loc[known, "residue_name"]
    ]
    smooth = pd.read_csv(
        _command(tmp_path, "surface", "--fields", "scale", "--table", "t.csv", "--smooth", "3")
    )
    expected = sparsurf.fields(dots, "scale", table=tmp_path / "t.csv", smooth=3)["scale_smooth"]
    np.testing.assert_allclose(smooth["scale_smooth"], expected, atol=1e-4)
    residues = pd.read_csv(_command(tmp_path, "residues", "--fields", "scale", "--table", "t.csv"))
    assert residues.loc[residues["residue_name"] == "SER", "mean_scale"].unique().tolist() == [2]
    _command(
        tmp_path,
        "surface",
        "--mesh",
        "--n-vertices",
        "300",
        "--fields",
        "scale",
        "--table",
        "t.csv",
        name="o.npz",
    )
    with np.load(tmp_path / "o.npz") as mesh:
        assert set(mesh["scale"][mesh["residue_name"] == "PHE"].tolist()) == {1}
    made = sparsurf.mesh(PEPTIDE, 300, fields="scale", table=tmp_path / "t.csv")
    sparsurf.write(made, tmp_path / "own.npz")
    assert (tmp_path / "own.npz").read_bytes() == (tmp_path / "o.npz").read_bytes()
    for words, message in (
        (["--fields", "score", "--table", "b.csv"], "b.csv has two rows for one residue"),
        (["--fields", "height", "--table", "t.csv"], "t.csv has no column 'height' of values; it has residue_name, scale"),
        (["--table", "t.csv"], "--table is about values at the dots; name them by --fields"),
        (["--fields", "hydropathy", "--smooth", "3"], "--smooth averages B factors and columns of a table"),
        (["--fields", "scale"], "there is no field 'scale'"),
    ):  # fmt: skip
        assert _command(tmp_path, "surface", *words) is None
        assert message in capsys.readouterr().err


def _command(folder, name_of_command, *words, name="o.csv"):
    """The file that a command writes of the peptide; None if it fails."""
    words = [str(folder / word) if word.endswith(".csv") else word for word in words]
    failed = command.main([name_of_command, PEPTIDE, *words, "-o", str(folder / name)])
    return None if failed else folder / name
