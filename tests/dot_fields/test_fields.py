"""Fields at dots: kernels against closed forms and plain sums, the charge table against what residues must carry."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import sparsurf
from conftest import ROOT
from sparsurf import InputError
from sparsurf.dot_fields.charges import pdb2pqr_charges, pqr_charges, table_charges
from sparsurf.dot_fields.columns import column_of_atoms
from sparsurf.dot_fields.potential import COULOMB, DEBYE, GAIN, SOFT, potential_of_charges, term
from sparsurf.dot_fields.smoothing import smoothed

PEPTIDE = str(ROOT / "data" / "tdp43" / "topology.pdb")
LINE = "ATOM  {:5d}  {:<3s} {:3s} A{:4d}    {:8.3f}{:8.3f}{:8.3f}  1.00{:6.2f}           {:1s}\n"


@pytest.fixture(scope="module")
def molecule():
    return sparsurf.read_molecule(PEPTIDE)


def test_one_charge_has_the_potential_of_the_formula():
    r = np.array([0.0, 2.0, 3.3, 10.0])
    soft = np.sqrt(r**2 + SOFT**2)
    eps = 2 + 160 / (1 + np.exp((3.3 - soft) / 1.2))
    points = np.column_stack([r, np.zeros(4), np.zeros(4)])
    found = potential_of_charges(np.zeros((1, 3)), np.array([-1.0]), points)
    # the table of terms is linear between steps of 0.02 Å: off by h^2 f'' / 8, below 0.1 % where f bends most
    np.testing.assert_allclose(found, -GAIN * COULOMB * np.exp(-soft / DEBYE) / (eps * soft), rtol=1e-3)


def test_the_potential_is_the_plain_sum_over_charges_and_turns_with_the_molecule():
    rng = np.random.default_rng(0)
    places, charges, points = rng.normal(0, 12, (80, 3)), rng.normal(size=80), rng.normal(0, 15, (50, 3))
    r = np.linalg.norm(points[:, None] - places, axis=2)
    found = potential_of_charges(places, charges, points)
    np.testing.assert_allclose(found, (term(r) * (r < 40)) @ charges, atol=2e-3 * np.abs(found).max())
    turn, shift = Rotation.random(random_state=1).as_matrix(), np.array([50.0, -7, 3])
    turned = potential_of_charges(places @ turn.T + shift, charges, points @ turn.T + shift)
    np.testing.assert_allclose(turned, found, atol=1e-9 * np.abs(found).max() + 1e-9)


@given(st.integers(0, 10**6), st.integers(1, 40), st.floats(0.5, 4))
@settings(max_examples=25, deadline=None)
def test_smoothing_is_the_gaussian_mean_of_the_known_atoms(seed, n, width):
    rng = np.random.default_rng(seed)
    xyz, points = rng.uniform(-9, 9, (n, 3)), rng.uniform(-20, 20, (30, 3))
    values = np.where(rng.random(n) < 0.2, np.nan, rng.normal(size=n))
    d2 = ((points[:, None] - xyz) ** 2).sum(axis=2)
    weight = np.where((d2 < (4 * width) ** 2) & np.isfinite(values), np.exp(-d2 / (2 * width**2)), 0)
    with np.errstate(invalid="ignore"):
        expected = weight @ np.nan_to_num(values) / weight.sum(axis=1)
    np.testing.assert_allclose(smoothed(values, xyz, points, width), expected, rtol=1e-7, atol=1e-12)


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


def test_hydrogens_that_are_missing_are_built_where_a_force_field_puts_them(molecule):
    points = sparsurf.surface(molecule).points[::20]
    with_them = sparsurf.fields(molecule, (points, np.tile([0, 0, 1.0], (len(points), 1))))["potential"]
    bare = molecule.select(hydrogens="remove")
    built = sparsurf.fields(bare, (points, np.tile([0, 0, 1.0], (len(points), 1))))["potential"]
    assert np.corrcoef(with_them, built)[0, 1] > 0.9  # hydroxyls turn freely; all others are where they were


def test_states_of_residues_follow_from_hydrogens_and_bridges(tmp_path):
    atoms = [("CB", 0, 0), ("SG", 1.8, 0)]
    lines = "".join(LINE.format(k, a, "CYS", 1, x, y, 0, 5, a[0]) for k, (a, x, y) in enumerate(atoms))
    lines += "".join(LINE.format(k, a, "CYS", 2, 5.6 - x, y, 0, 5, a[0]) for k, (a, x, y) in enumerate(atoms))
    path = tmp_path / "bridge.pdb"
    path.write_text(lines + "END\n")
    bridged = table_charges(sparsurf.read_molecule(path, selection="all"))[1]
    np.testing.assert_allclose(
        sorted(bridged), [-0.29, -0.29, 0.29, 0.29]
    )  # CYX; a CYS would have a hydrogen


def test_a_ligand_is_neutral_whatever_its_atoms_are_called(tmp_path):
    lines = [LINE.format(k, a, "LIG", 1, 1.4 * k, 0, 0, 5, a[0]) for k, a in enumerate(["N", "C", "O"])]
    path = tmp_path / "ligand.pdb"
    path.write_text("".join(line.replace("ATOM  ", "HETATM") for line in lines) + "END\n")
    assert table_charges(sparsurf.read_molecule(path, selection="all"))[1].tolist() == []


def test_columns_of_pdb2pqr_do_not_touch_far_from_the_origin(tmp_path, monkeypatch, molecule):
    """Without the option it writes 91.733-207.260, which nobody can read."""
    program = tmp_path / "pdb2pqr"
    wide = "ATOM 1 N ALA 1 1.0 91.733 -207.260 -0.5 1.5"
    program.write_text(
        '#!/bin/sh\nfor last; do :; done\ncase "$*" in\n'
        f'*--whitespace*) echo "{wide}";;\n*) echo "{wide.replace("3 -2", "3-2")}";;\nesac > "$last"\n'
    )
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    places, charges = pdb2pqr_charges(molecule)
    assert places.tolist() == [[1.0, 91.733, -207.26]] and charges.tolist() == [-0.5]


def test_a_pqr_file_gives_places_and_charges(tmp_path):
    path = tmp_path / "a.pqr"
    path.write_text("REMARK\nATOM 1 N ALA 1 1.0 2.0 3.0 -0.5 1.5\nATOM 2 H ALA 1 1.5 2.0 3.0 0.5 1.0\n")
    places, charges = pqr_charges(path)
    np.testing.assert_array_equal(places, [[1, 2, 3], [1.5, 2, 3]])
    np.testing.assert_array_equal(charges, [-0.5, 0.5])
    path.write_text("ATOM 1 N ALA 1 1.0 2.0 3.0 x 1.5\n")
    with pytest.raises(InputError, match=r"a\.pqr, line 1"):
        pqr_charges(path)


def pqr(molecule, charge=lambda k: (-1) ** k * 0.3, radius=1.5, scale=1.0, shift=0.0):
    places = molecule.xyz[0] * scale + shift
    return "".join(
        f"ATOM {k} X ALA 1 {x} {y} {z} {charge(k)} {radius}\n" for k, (x, y, z) in enumerate(places)
    )


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
        (pqr(molecule).replace("-0.3", "nan", 1), r"a\.pqr, line 2: no atom has such a place or charge"),
        (pqr(molecule).replace("-0.3", "-11", 1), r"a\.pqr, line 2: no atom has such a place or charge"),
    ):
        path.write_text(text)
        with pytest.raises(InputError, match=said):
            sparsurf.fields(molecule, dots, "potential", charges=path)


def test_columns_of_a_table_and_b_factors_reach_the_dots(tmp_path, molecule):
    residues = molecule.residues
    table = pd.DataFrame({"residue": residues["residue"], "score": np.arange(len(residues)) % 7})
    table.to_csv(tmp_path / "scores.csv", index=False)
    dots = sparsurf.surface(molecule)
    found = sparsurf.fields(molecule, dots, ("score",), table=tmp_path / "scores.csv")["score"]
    expected = smoothed(table["score"].to_numpy(float)[molecule.residue_index], molecule.xyz[0], dots.points)
    np.testing.assert_array_equal(found, expected)
    with_b = tmp_path / "b.pdb"
    molecule.write_pdb(with_b, b_factor=np.full(molecule.n_atoms, 12.5))
    assert sparsurf.fields(with_b, dots, "bfactor")["bfactor"].to_numpy() == pytest.approx(12.5)
    with pytest.raises(InputError, match="bfactor has no value"):
        sparsurf.fields(molecule, dots, ("bfactor",))


@pytest.mark.parametrize(
    "content, said",
    [
        ("a,b\n1,2\n", "no column residue"),
        ("residue,score\n209,x\n", "row 1: score is 'x'"),
        ("residue,score\n9999,1\n", "no row fits"),
        ("residue,score\n209,1\n209,2\n", "two rows"),
        ("residue,other\n209,1\n", "no column 'score'"),
        ("residue,score\n209,inf\n", "row 1: score is 'inf'"),
        ("", "no column residue"),
        ("residue,score,score\n209,1,2\n", "has the column 'score' twice"),
        ("residue,score\n209,1\n210\n", "row 2: it has 1 values, not 2; repair it"),
        ("residue,score\n209,1\n210,2,3\n", "row 2: it has 3 values, not 2; repair it"),
        ('residue,score\n209,"1\n', "no table with commas between its columns"),
    ],
)
def test_a_table_that_does_not_fit_is_refused(tmp_path, molecule, content, said):
    path = tmp_path / "scores.csv"
    path.write_text(content)
    with pytest.raises(InputError, match=said):
        sparsurf.fields(molecule, PEPTIDE_DOTS, ("score",), table=path)


@pytest.mark.parametrize("name", ["kind", "area", "x", "component", "two words", "a/b", "größe"])
def test_a_column_that_cannot_be_a_field_is_refused(tmp_path, molecule, name):
    """Its values would be lost among the columns of the dots, or damage a PLY file."""
    path = tmp_path / "scores.csv"
    for encoding in ("utf-8-sig", "latin-1"):
        path.write_text(f"residue,{name}\n209,1\n", encoding=encoding)
        with pytest.raises(InputError, match=f"'{name}' cannot name a field"):
            sparsurf.fields(molecule, PEPTIDE_DOTS, (name,), table=path)


def test_cells_of_a_table_may_be_quoted_and_hold_lines(tmp_path, molecule):
    path = tmp_path / "scores.csv"
    path.write_text('residue, note ,"score"\r\n209,"a\r\nb, c", 7 \r\n\r\n210,,8\r\n', newline="")
    found = column_of_atoms(path, "score", molecule)
    for residue, value in (("209", 7), ("210", 8)):
        assert set(found[molecule.residue == residue]) == {value}
    assert np.isnan(found[~np.isin(molecule.residue, ["209", "210"])]).all()


PEPTIDE_DOTS = (np.zeros((1, 3)), np.array([[0, 0, 1.0]]))


def test_a_column_that_is_called_like_a_field_is_refused(tmp_path, molecule):
    path = tmp_path / "scores.csv"
    path.write_text("residue,charge,score\n209,1,2\n")
    with pytest.raises(InputError, match=r"scores\.csv has the column 'charge'"):
        sparsurf.fields(molecule, PEPTIDE_DOTS, ("charge",), table=path)


def test_an_unknown_field_is_refused_with_the_known_ones(molecule):
    with pytest.raises(InputError, match="hydropathy, volume"):
        sparsurf.fields(molecule, PEPTIDE_DOTS, ("colour",))
