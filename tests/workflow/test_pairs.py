"""Pairs: what the config may say, and scripts of pairs in cases that the small study does not have."""

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT
from peptides import peptide, write
from small_study import run_script
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.report.summaries import summarise_pairs
from sparsurf.settings import Settings
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.molecular_surface import surface_for_d_link
from sparsurf.surfaces.radii import radii
from sparsurf.workflow import listing
from sparsurf.workflow.config import check_config

SEQUENCE = ("ALA", "LEU", "LYS", "GLY")
SMALL_FILES = [str(ROOT / "tests" / name) for name in ("peptides.py", "conftest.py")]  # any files
PAIRS = {"run": "x", "pairs": {"p": {"files": SMALL_FILES}}}
SURFACE = Settings.of(check_config(PAIRS)).surface


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A complex of two short peptides, as one file and as two."""
    folder = tmp_path_factory.mktemp("pairs")
    first, second = peptide(SEQUENCE, "A"), peptide(SEQUENCE, "B", origin=(0, 9.0, 0))
    write(folder / "both.pdb", first + "TER\n" + second + "END\n")
    write(folder / "both_r.pdb", first + "END\n")
    write(folder / "both_l.pdb", second + "END\n")
    return folder


def config(**pairs):
    return check_config({"run": "x", "pairs": pairs})


def test_a_config_of_pairs_needs_no_proteins(folder):
    pair = {"complex": str(folder / "both.pdb"), "chains": [["A"], ["B"]]}
    checked = config(mine=pair)
    assert checked["proteins"] == {} and checked["pairs"] == {"mine": pair}
    assert checked["complementarity"]["centres"] == {"sampler": "farthest", "percent": 5}
    assert checked["complementarity"]["smoothing"] == 6.0


@pytest.mark.parametrize(
    ("pair", "words"),
    [
        ({"complex": "no.pdb", "chains": [["A"], ["B"]]}, "pairs.p: there is no file 'no.pdb'"),
        ({"complex": "both.pdb"}, "pairs.p"),
        ({"complex": "both.pdb", "chains": [["A"], ["A", "B"]]}, "chain A is on both sides"),
        ({"complex": "both.pdb", "chains": [["A"]]}, "must be a list of 2 or more"),
        ({"files": ["both.pdb", "both.pdb"]}, "'both.pdb' is on both sides; name two partners"),
        ({"proteins": ["a", "b"]}, "'a' is none of the proteins; these are none"),
        (
            {"files": ["both_r.pdb", "both_l.pdb"], "proteins": ["a", "b"]},
            "exactly one of 'proteins', 'files'",
        ),
        ({"file": "both.pdb"}, "did you mean 'files'"),
    ],
)
def test_a_mistake_in_a_pair_is_answered_with_a_sentence(folder, monkeypatch, pair, words):
    monkeypatch.chdir(folder)
    with pytest.raises(InputError) as error:
        config(p=pair)
    assert words in str(error.value)


def test_pairs_come_from_a_table_or_a_folder(folder):
    table = write(
        folder / "pairs.csv",
        "name,first,second,complex,chains_1,chains_2\none,both_r.pdb,both_l.pdb,,,\ntwo,,,both.pdb,A,B\n",
    )
    found = listing.pairs_from_table(str(table))
    assert found["one"] == {"files": [str(folder / "both_r.pdb"), str(folder / "both_l.pdb")]}
    assert found["two"] == {"complex": str(folder / "both.pdb"), "chains": [["A"], ["B"]]}
    assert listing.pairs_from_folder(str(folder)) == {"both": found["one"]}
    assert set(check_config({"pairs": str(table)})["pairs"]) == {"one", "two"}
    assert set(check_config({"pairs": {"folder": str(folder)}})["pairs"]) == {"both"}


@pytest.mark.parametrize("key", ["pairs", "proteins"])
def test_a_folder_stands_alone(folder, key):
    with pytest.raises(InputError, match=f"{key}.folder cannot stand next to other keys .mine."):
        check_config({key: {"folder": str(folder), "mine": {"files": ["a.pdb", "b.pdb"]}}})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name,first\na,b\n", "line 2 of"),
        ("first,second\na,b\n", "needs a header with name and either first"),
        ("name,first,second\n", "at least one row"),
    ],
)
def test_a_wrong_table_of_pairs_is_refused(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        listing.pairs_from_table(str(write(tmp_path / "t.csv", text)))
    with pytest.raises(InputError, match="holds no two structures"):
        listing.pairs_from_folder(str(tmp_path))


def compute_partners(folder, files, chains=None, settings=SURFACE):
    """Run the script; return the paths of both surfaces and of both structures."""
    surfaces = [str(folder / f"surface_{side}.npz") for side in (1, 2)]
    structures = [str(folder / f"structure_{side}.pdb") for side in (1, 2)]
    names = [f"{kind}_{side}" for kind in ("surface", "structure") for side in (1, 2)]
    outputs = dict(zip(names, surfaces + structures, strict=True))
    params = {"pair": {"chains": chains}, "surface": settings.model_dump(), "d_link": 0.5}
    inputs = {f"file_{k}": str(file) for k, file in enumerate(files)}
    run_script("compute_partner_surfaces", folder, inputs, outputs, params, pair="x")
    return surfaces, structures


def test_partners_are_computed_by_the_rules_of_the_config(folder, tmp_path):
    settings = SURFACE.model_copy(update={"radii": "bondi", "probe_radius": 1.2})
    surfaces, _ = compute_partners(tmp_path, [folder / "both.pdb"], [["B"], ["A"]], settings)
    for path, chain in zip(surfaces, "BA", strict=True):
        molecule = read_molecule(folder / "both.pdb", chains=[chain])
        expected, _ = surface_for_d_link(molecule, 0, radii(molecule, "bondi"), settings, 0.5, "x")
        assert np.array_equal(read_npz(path).points, expected.points)


def test_a_partner_of_several_models_is_refused(folder, tmp_path):
    model = f"MODEL 1\n{peptide(SEQUENCE)}ENDMDL\n"
    two = write(tmp_path / "models.pdb", model + model.replace("MODEL 1", "MODEL 2") + "END\n")
    with pytest.raises(InputError, match=r"^x: partner 1 has 2 models"):
        compute_partners(tmp_path, [two, folder / "both_l.pdb"])


def test_chains_that_are_not_there_are_named(folder, tmp_path):
    with pytest.raises(InputError, match="no chain X: its chains are A, B"):
        compute_partners(tmp_path, [folder / "both.pdb"], [["A"], ["X"]])


@pytest.fixture(scope="module")
def tabulated(folder):
    """Surfaces and structures of both partners, and a table of dots in which no dot is of the second lysine."""
    surfaces, structures = compute_partners(folder, [folder / "both_r.pdb", folder / "both_l.pdb"])
    tables = []
    for side, surface in enumerate(surfaces, 1):
        molecule, dots = read_molecule(structures[side - 1]), read_npz(surface)
        residue = molecule.residue_index[dots.atom]
        table = pd.DataFrame(dots.points, columns=["x", "y", "z"]).assign(partner=side, chain="AB"[side - 1])
        table = table.assign(residue=residue + 1, residue_name=np.array(SEQUENCE)[residue], interface=0)
        table["propensity_smoothed"] = table["propensity_k_smoothed"] = table["similarity_smoothed"] = (
            residue + 0.5
        )
        table["propensity"], table["gap"] = table["propensity_smoothed"], 5.0
        table["interface"] = (table["y"] > 4).astype(int) if side == 1 else 0
        tables.append(table)
    dots = pd.concat(tables)
    dots = dots[(dots["partner"] == 1) | (dots["residue"] != 3)].replace(
        {"residue_name": {"GLY": "NA"}}
    )  # sodium
    dots.to_csv(folder / "dots.csv", index=False)
    return surfaces, structures, str(folder / "dots.csv")


def test_residues_without_dots_are_marked_and_scripts_open_both_partners(tabulated, tmp_path):
    _, structures, dots = tabulated
    names = {
        "pdb_1": "1.pdb",
        "pdb_2": "2.pdb",
        "residues": "residues.csv",
        "pml": "open.pml",
        "cxc": "open.cxc",
    }
    outputs = {name: str(tmp_path / file) for name, file in names.items()}
    inputs = {"structure_1": structures[0], "structure_2": structures[1], "dots": dots}
    run_script("tabulate_pair_residues", tmp_path, inputs, outputs)
    residues = pd.read_csv(outputs["residues"], keep_default_na=False)
    assert residues["residue_name"].tolist() == ["ALA", "LEU", "LYS", "NA", "ALA", "LEU", "NA"]
    assert residues["propensity_smoothed"].astype(float).tolist() == [0.5, 1.5, 2.5, 3.5, 0.5, 1.5, 3.5]
    lysine = [line for line in (tmp_path / "2.pdb").read_text().splitlines() if line[17:20] == "LYS"]
    assert len(lysine) > 0 and {line[60:66] for line in lysine} == {" -1.00"}
    low, high = (f"{residues['propensity_smoothed'].astype(float).quantile(q):.3f}" for q in (0.05, 0.95))
    assert f"partner_1 or partner_2, {low}, {high}" in (tmp_path / "open.pml").read_text()
    # https://www.rbvi.ucsf.edu/chimerax/docs/user/commands/color.html: color byattribute [level:]name spec options
    commands = [line.split() for line in (tmp_path / "open.cxc").read_text().splitlines() if line[0] != "#"]
    colours = ["color", "byattribute", "a:bfactor", "#1,2", "target", "s", "palette", "viridis"]
    assert [*colours, "range", f"{low},{high}"] in commands
    assert [words[1] for words in commands if words[0] == "open"] == ["partner_1.pdb", "partner_2.pdb"]
    assert {words[0] for words in commands} == {"open", "cartoon", "surface", "color", "set", "view"}


def test_pairs_that_do_not_touch_have_no_rows(tmp_path):
    (tmp_path / "far").mkdir()
    columns = "partner,score,auc,low,high,dots,interface,blocks\n"
    (tmp_path / "far" / "agreement.csv").write_text(columns)
    outputs = [str(tmp_path / name) for name in ("pairs.csv", "pairs.png")]
    summarise_pairs([tmp_path / "far" / "agreement.csv"], "x", *outputs)
    assert len(pd.read_csv(outputs[0])) == 0 and (tmp_path / "pairs.png").exists()
