"""The surface residue by residue, and the structures coloured by it."""

import re
import sys
from dataclasses import replace
from types import SimpleNamespace

import gemmi
import numpy as np
import pandas as pd
import pytest

from conftest import ROOT
from peptides import peptide, write
from small_study import run_script
from sparsurf.evaluation.residues import residue_table, roughness_over_frames, sum_by_group
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import SurfaceSettings
from sparsurf.surfaces.formats.colours import ROUGHNESS_LIMITS
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii


@pytest.fixture(scope="module")
def molecule(tmp_path_factory):
    """Two chains, the second far from the first."""
    text = peptide(["ALA", "GLY", "SER"], "A", -1) + peptide(["LEU", "LYS"], "B", 40, (0, 0, 30)) + "END\n"
    return read_molecule(write(tmp_path_factory.mktemp("two") / "two.pdb", text), selection="all")


@pytest.fixture(scope="module")
def surface(molecule):
    return molecular_surface(molecule.xyz[0], radii(molecule, "dms"), 1.4, 3.0)


def test_a_residue_has_the_mean_of_each_field(molecule, surface):
    values = np.linspace(0, 5, len(surface))
    charge = np.where(np.arange(len(surface)) % 7 == 0, np.nan, values)  # it is not known at every dot
    own = replace(surface, fields={"charge": charge, "component": values})
    table = residue_table(own, values, molecule)
    assert "mean_component" not in table
    for row in (1, 4):
        of_row = charge[molecule.residue_index[surface.atom] == row]
        assert np.isnan(of_row).any() and table["mean_charge"][row] == pytest.approx(np.nanmean(of_row))


@pytest.mark.parametrize("is_sorted", [True, False])
@pytest.mark.parametrize("has_nan", [True, False])
def test_sums_of_groups_are_to_the_last_bit_those_of_pandas(is_sorted, has_nan):
    rng = np.random.default_rng(0)
    values, group = rng.normal(1, 1, 3000), rng.integers(0, 20, 3000) * 2
    group = np.sort(group) if is_sorted else group
    values[: 7 * has_nan] = np.nan
    expected = pd.Series(values).groupby(group).sum().reindex(range(40), fill_value=0)
    np.testing.assert_array_equal(sum_by_group(values, group, 40), expected)


def test_table_says_what_a_loop_finds(molecule, surface):
    rng = np.random.default_rng(3)
    rough = rng.random(len(surface))
    kept = rng.choice(len(surface), 60, replace=False)
    weight = rng.integers(1, 9, 60)
    table = residue_table(surface, rough, molecule, kept, weight)
    assert table["residue"].tolist() == ["-1", "0", "1", "40", "41"]
    assert table["chain"].tolist() == list("AAABB")
    assert table["residue_name"].tolist() == ["ALA", "GLY", "SER", "LEU", "LYS"]
    for r, row in table.iterrows():
        mine = [k for k in range(len(surface)) if molecule.residue_index[surface.atom[k]] == r]
        assert row["dots"] == len(mine)
        assert row["area"] == pytest.approx(sum(surface.area[mine]))
        for kind, name in enumerate(("contact", "saddle", "concave")):
            assert row[f"area_{name}"] == pytest.approx(
                sum(surface.area[k] for k in mine if surface.kind[k] == kind)
            )
        assert row["mean_roughness"] == pytest.approx(sum(rough[mine]) / len(mine))
        assert row["most_rough"] == min(rough[mine])
        chosen = [i for i, k in enumerate(kept) if k in mine]
        assert row["kept"] == len(chosen)
        assert row["weight"] == sum(weight[chosen])
    assert table["dots"].sum() == len(surface)


def test_buried_residues_have_rows_without_roughness(molecule, surface):
    """Also the last ones of the structure."""
    only = surface.take(np.isin(molecule.residue_index[surface.atom], [0, 2]))
    whole = replace(only, fields={"charge": np.ones(len(only))})
    table = residue_table(whole, np.ones(len(only)), molecule)
    for name in (
        "area",
        "area_contact",
        "area_saddle",
        "area_concave",
        "dots",
        "cavity_dots",
        "kept",
        "weight",
    ):
        assert table[name][[1, 3, 4]].eq(0).all(), name
    assert table["area"][[0, 2]].gt(0).all() and table["dots"].sum() == len(only)
    for name in ("mean_roughness", "most_rough", "mean_charge"):
        assert table[name].isna().tolist() == [False, True, False, True, True], name
    names = [
        "chain", "residue", "residue_name", "area", "area_contact", "area_saddle", "area_concave", "mean_roughness",
        "most_rough", "mean_charge", "dots", "cavity_dots", "kept", "weight",
    ]  # fmt: skip
    assert [name for name in table if name in names] == names  # in this order, whatever else there is


def test_walls_of_cavities_have_no_part_in_the_roughness_of_a_residue(molecule, surface):
    residue = molecule.residue_index[surface.atom]
    of_leucine = np.flatnonzero(residue == 3)
    wall = of_leucine[: len(of_leucine) // 2]
    component = np.zeros(len(surface), int)
    component[wall] = 1
    normals = surface.normals.copy()
    normals[wall] *= -1  # they point inwards
    rough = np.linspace(0.1, 0.9, len(surface))
    turned = replace(surface, normals=normals)
    table = residue_table(turned, rough, molecule, component=component)
    assert table["cavity_dots"].tolist() == [0, 0, 0, len(wall), 0]
    assert table["dots"].tolist() == np.bincount(residue).tolist()  # the walls included
    outside = np.setdiff1d(of_leucine, wall)
    assert table["mean_roughness"][3] == pytest.approx(rough[outside].mean())
    assert table["most_rough"][3] == rough[outside].min() > rough[wall].min()
    assert table["area"][3] == pytest.approx(surface.area[of_leucine].sum())
    component[of_leucine] = 1
    turned.normals[outside] *= -1
    table = residue_table(turned, rough, molecule, component=component)
    assert np.isnan(table["mean_roughness"][3]) and np.isnan(table["most_rough"][3])
    assert table["mean_roughness"].notna().tolist() == [True, True, True, False, True]


def test_buried_residues_are_shown_below_all_roughness(molecule, surface, tmp_path):
    far = surface.atom >= np.flatnonzero(molecule.chain == "B")[0]
    only = surface.take(far)
    inputs = {name: str(tmp_path / name) for name in ("surface", "roughness", "structure.pdb", "minimal")}
    inputs["structure"] = inputs.pop("structure.pdb")
    write_npz(inputs["surface"], only)
    molecule.write_pdb(inputs["structure"])
    pd.DataFrame({"roughness": np.full(far.sum(), 0.25)}).to_csv(inputs["roughness"], index=False)
    kept = pd.DataFrame({"dot": [0, 1], "x": [1.5, -2], "y": [0.25, 3], "z": [7.0, 8]})
    kept["weight"] = [1, len(only) - 1]
    kept.to_csv(inputs["minimal"], index=False)
    outputs = {name: tmp_path / f"open.{name}" for name in ("table", "pdb", "pml", "cxc", "bild")}
    rules = {"surface": SurfaceSettings().model_dump()}
    run_script("tabulate_residues", tmp_path, inputs | {"fields": []}, outputs, rules)
    spheres = [line.split()[1:] for line in outputs["bild"].read_text().splitlines() if ".sphere" in line]
    assert np.array(spheres, float).tolist() == [[1.5, 0.25, 7, 0.3], [-2, 3, 8, 0.3]]
    low, high = ROUGHNESS_LIMITS
    assert f"structure, {low}, {high}" in outputs["pml"].read_text()
    assert f"range {low},{high}" in outputs["cxc"].read_text()
    structure = gemmi.read_structure(str(outputs["pdb"]))
    shown = [each.atom.b_iso for each in structure[0].all()]
    assert shown == [-1.0 if chain == "A" else 0.25 for chain in molecule.chain]


def test_pymol_gets_a_coloured_copy_for_each_field(tmp_path, monkeypatch):
    """The Python of open.pml, with a PyMOL that notes what it is told."""
    (tmp_path / "minimal.csv").write_text("x,y,z\n1,2,3\n")
    # in no order, of three chains with the same numbers, one residue of which is unknown
    rows = ["C,1,0.5,0.05", "A,2,0.5,", "A,1,0.5,-0.25", "B,1,0.5,0.125", "B,2,0.5,0.1"]
    rows = "\n".join(["chain,residue,mean_roughness,mean_charge", *rows, ""])
    (tmp_path / "residues.csv").write_text(rows)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "pymol", SimpleNamespace(cgo=SimpleNamespace(COLOR=0, SPHERE=1)))
    told = []
    known = ("load_cgo", "create", "alter", "spectrum", "disable")
    cmd = SimpleNamespace(**{each: lambda *a, each=each, **k: told.append((each, *a, k)) for each in known})
    text = (ROOT / "src/sparsurf_study/report/scenes/open.pml").read_text()
    exec(re.search(r"^python\n(.*)^python end", text, re.M | re.S)[1], {"cmd": cmd})
    assert [each[0] for each in told] == [*known]
    assert told[0][1] == [0, 0.84, 0.37, 0.0, 1, 1, 2, 3, 0.3]
    assert told[2][3]["space"] == {
        "shown": {("A", "1"): -0.25, ("B", "1"): 0.125, ("B", "2"): 0.1, ("C", "1"): 0.05}
    }
    assert told[3][1:] == ("b", "red_white_blue", "mean_charge", -0.25, 0.25, {})


def test_spread_over_frames():
    residues = pd.DataFrame({"chain": "A", "residue": ["1", "2", "3"], "residue_name": "ALA"})
    values = np.array([[0.2, 0.5, np.nan], [0.4, np.nan, np.nan], [0.9, 0.7, np.nan]])
    table = roughness_over_frames(residues, values)
    assert table["mean_roughness"][:2].tolist() == pytest.approx([0.5, 0.6])
    assert table["sd_roughness"][0] == pytest.approx(np.sqrt((0.09 + 0.01 + 0.16) / 2))
    assert table["most_rough"][:2].tolist() == [0.2, 0.5]
    assert table["largest_roughness"][:2].tolist() == [0.9, 0.7]
    assert table["frames"].tolist() == [3, 2, 0]
    assert table["mean_roughness"].isna().tolist() == [False, False, True]
